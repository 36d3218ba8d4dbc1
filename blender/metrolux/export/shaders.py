"""Shader nodes as surfaces. What each becomes stands in the table that docs/reference/blender.md shows."""

import numpy as np

from . import normals
from .graph import Input, input_of
from .principled import principled_surface
from .surface import Lobe, Surface, diffuse
from .textures import TextureReader
from .values import BLACK, CannotCombine, WHITE, combine, complement, constant, multiply
from .xml import plugin

SHADERS = {}  # bl_idname: (name in Blender, what becomes of it, function)
_MOST_NODES = 64


def shader(kind, name, becomes):
    def register(function):
        SHADERS[kind] = (name, becomes, function)
        return function

    return register


class ShaderReader(TextureReader):
    """Surfaces of shader sockets."""

    depth = 0

    def surface(self, socket):
        if socket is None or socket.node is None:
            return Surface()
        kind = socket.node.bl_idname
        if kind not in SHADERS:
            self.problem(f"the shader {socket.node.bl_label} is not supported; it is replaced by gray diffuse")
            return diffuse(constant(0.5))
        self.depth += 1
        try:
            if self.depth > _MOST_NODES:
                self.problem("shaders are nested too deeply; black is taken")
                return Surface()
            return SHADERS[kind][2](self, socket.node, socket.groups)
        except CannotCombine as problem:
            self.problem(f"the shader {socket.node.bl_label}: {problem}; it is replaced by gray diffuse")
            return diffuse(constant(0.5))
        finally:
            self.depth -= 1

    def lobe(self, node, groups, color, make, **properties):
        """A surface of one lobe with the node's normal."""
        perturbed = normals.perturbation(self, input_of(node, groups, "Normal"))
        return Surface([Lobe(WHITE, color, lambda c, writer: perturbed(make(c, writer), writer), **properties)])


@shader("ShaderNodeBsdfDiffuse", "Diffuse BSDF",
        "`diffuse`; with a roughness `roughdiffuse` (Oren and Nayar 1994; Cycles has a later form)")
def _diffuse(reader, node, groups):
    roughness = reader.scalar(input_of(node, groups, "Roughness"))

    def make(color, writer):
        if roughness == BLACK:
            return plugin("bsdf", "diffuse", reflectance=writer.color(color))
        return plugin("bsdf", "roughdiffuse", reflectance=writer.color(color), alpha=writer.scalar(roughness))

    return reader.lobe(node, groups, reader.input(node, groups, "Color"), make)


def squared(value):
    return combine(np.square, value)


_DISTRIBUTIONS = {"GGX": "ggx", "BECKMANN": "beckmann", "MULTI_GGX": "ggx", "SHARP": None}


def microfacets(reader, node, groups):
    """The distribution and its alpha, which is the square of the roughness; no distribution where it is smooth."""
    kind = node.distribution
    if kind not in _DISTRIBUTIONS:
        reader.problem(f"the distribution {kind} is not supported; GGX is taken")
    distribution = _DISTRIBUTIONS.get(kind, "ggx")
    roughness = reader.scalar(input_of(node, groups, "Roughness"))
    if roughness is None or roughness == BLACK:
        return None, BLACK
    if kind == "MULTI_GGX":
        reader.problem("Multiscatter GGX is read as GGX: rough surfaces lose the light that facets reflect twice")
    return distribution, squared(roughness)


@shader("ShaderNodeBsdfGlossy", "Glossy BSDF", "`conductor` or `roughconductor` with the color as its reflectance")
@shader("ShaderNodeBsdfAnisotropic", "Anisotropic BSDF, Glossy BSDF (4.x)", "as Glossy BSDF; the rotation of anisotropy is lost (named)")
def _glossy(reader, node, groups):
    distribution, alpha = microfacets(reader, node, groups)
    anisotropy = reader.number(input_of(node, groups, "Anisotropy"), "Anisotropy") or 0
    if anisotropy and reader.input(node, groups, "Rotation") != BLACK:
        reader.problem("the rotation of an anisotropic surface is not supported; it follows the UV map")

    def make(color, writer):
        if distribution is None:
            return plugin("bsdf", "conductor", specular_reflectance=writer.color(color))
        # Cycles: the two roughnesses are divided and multiplied by sqrt(1 - anisotropy), as in Burley's model.
        stretch = float(np.sqrt(1 - min(max(abs(anisotropy), 0), 0.99)))
        u, v = (stretch, 1 / stretch) if anisotropy < 0 else (1 / stretch, stretch)
        alphas = {"alpha": writer.scalar(alpha)} if stretch == 1 else {
            "alpha_u": writer.scalar(multiply(alpha, constant(u))), "alpha_v": writer.scalar(multiply(alpha, constant(v)))}
        return plugin("bsdf", "roughconductor", distribution=distribution, specular_reflectance=writer.color(color), **alphas)

    return reader.lobe(node, groups, reader.input(node, groups, "Color"), make)


def _dielectric(reader, node, groups, reflects):
    distribution, alpha = microfacets(reader, node, groups)
    ior = reader.number(input_of(node, groups, "IOR"), "IOR")

    def make(color, writer):
        values = {"int_ior": float(max(ior, 1e-3)), "ext_ior": 1.0,
                  "specular_reflectance": writer.color(color if reflects else BLACK),
                  "specular_transmittance": writer.color(color)}
        if abs(ior - 1) < 1e-4:
            values["int_ior"] = 1.0001
        if distribution is None:
            return plugin("bsdf", "dielectric", **values)
        return plugin("bsdf", "roughdielectric", distribution=distribution, alpha=writer.scalar(alpha), **values)

    return reader.lobe(node, groups, reader.input(node, groups, "Color"), make, is_transmissive=True)


@shader("ShaderNodeBsdfGlass", "Glass BSDF", "`dielectric` or `roughdielectric`; its normals must point outward")
def _glass(reader, node, groups):
    return _dielectric(reader, node, groups, True)


@shader("ShaderNodeBsdfRefraction", "Refraction BSDF",
        "`dielectric` or `roughdielectric` without reflection: darker than Cycles' by Fresnel's share (named)")
def _refraction(reader, node, groups):
    reader.problem("a Refraction BSDF loses the share that glass would reflect (Cycles lets all through)")
    return _dielectric(reader, node, groups, False)


@shader("ShaderNodeBsdfTranslucent", "Translucent BSDF", "`difftrans`")
def _translucent(reader, node, groups):
    return reader.lobe(node, groups, reader.input(node, groups, "Color"),
                       lambda color, writer: plugin("bsdf", "difftrans", transmittance=writer.color(color)),
                       is_transmissive=True)


@shader("ShaderNodeBsdfTransparent", "Transparent BSDF", "`mask`, or `null` alone; a tint is read as gray (named)")
def _transparent(reader, node, groups):
    color = reader.input(node, groups, "Color")
    if color.is_constant and max(color.color) - min(color.color) > 1e-4:
        reader.problem("the tint of a Transparent BSDF is not supported; its mean is taken")
        color = constant(color.scalar)
    return Surface(transparency=color)


@shader("ShaderNodeEmission", "Emission", "`area`; open meshes emit on both sides by a second, inverted copy")
def _emission(reader, node, groups):
    return Surface(emission=multiply(reader.input(node, groups, "Color"),
                                     reader.scalar(input_of(node, groups, "Strength"))))


@shader("ShaderNodeBackground", "Background", "on a mesh, as Emission; in a World `constant` or `envmap`")
def _background(reader, node, groups):
    return _emission(reader, node, groups)


@shader("ShaderNodeMixShader", "Mix Shader", "`blendbsdf`, `mask` where one side is transparent, emission scaled")
def _mix(reader, node, groups):
    factor = reader.scalar(Input(node.inputs[0], groups))
    factor = combine(lambda f: np.clip(f, 0, 1), factor)
    first, second = (reader.surface(Input(socket, groups)) for socket in list(node.inputs)[1:3])
    if factor == BLACK:
        return first
    if factor == WHITE:
        return second
    return first.scaled(complement(factor)).plus(second.scaled(factor))


@shader("ShaderNodeAddShader", "Add Shader", "emission is added; of surfaces as far as no color exceeds 1")
def _add(reader, node, groups):
    first, second = (reader.surface(Input(socket, groups)) for socket in list(node.inputs)[:2])
    return first.plus(second)


@shader("ShaderNodeBsdfPrincipled", "Principled BSDF",
        "`principled`, `area`, `mask`; see below")
def _principled(reader, node, groups):
    return principled_surface(reader, node, groups)
