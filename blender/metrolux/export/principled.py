"""The Principled BSDF: sockets of Blender 2.8 to 3.x and of 4.x, as Burley's model in Mitsuba's form."""

import numpy as np

from .. import compat
from . import normals
from .graph import input_of
from .surface import Lobe, Surface
from .values import BLACK, WHITE, combine, complement, multiply
from .xml import plugin


def _eta(reader, node, groups, is_transmissive):
    """The index of refraction. Blender 3's Specular means F0 = 0.08 specular, 4's level scales the F0 of the IOR by twice
    itself; for glass the IOR holds."""
    ior = reader.number(input_of(node, groups, "IOR"), "IOR")
    level = reader.number(input_of(node, groups, "Specular IOR Level"), "Specular IOR Level")
    specular = reader.number(input_of(node, groups, "Specular"), "Specular")
    if is_transmissive:
        return ior
    f0 = 0.08 * specular if level is None else ((ior - 1) / (ior + 1)) ** 2 * 2 * level
    root = np.sqrt(min(max(f0, 0), 0.95))
    return float((1 + root) / (1 - root))


def principled_surface(reader, node, groups):
    def scalar(*names):
        return reader.scalar(input_of(node, groups, *names)) or BLACK

    base = reader.input(node, groups, "Base Color")
    subsurface = scalar("Subsurface Weight", "Subsurface")
    if subsurface != BLACK:
        reader.problem("subsurface scattering is not supported; it is read as diffuse")
        other = reader.input(node, groups, "Subsurface Color")
        if other is not None and subsurface.is_constant:
            base = combine(lambda a, b, f: a + f * (b - a), base, other, subsurface)
    for name in ("Thin Film Thickness",):
        if scalar(name) != BLACK:
            reader.problem(f"{name} of the Principled BSDF is not supported; it is left out")
    transmission = scalar("Transmission Weight", "Transmission")
    is_transmissive = transmission != BLACK
    if transmission == WHITE:
        base = combine(compat.transmitted_color, base)
    eta = _eta(reader, node, groups, is_transmissive)
    if scalar("Transmission Roughness") != BLACK:
        reader.problem("Transmission Roughness is not supported; Roughness holds for what is transmitted, too")
    if scalar("Anisotropic Rotation") != BLACK:
        reader.problem("the rotation of an anisotropic surface is not supported; it follows the UV map")
    values = {
        "roughness": scalar("Roughness"),
        "metallic": scalar("Metallic"),
        "anisotropic": scalar("Anisotropic"),
        "spec_trans": transmission,
        "sheen": _sheen(reader, node, groups, scalar),
        "clearcoat": scalar("Coat Weight", "Clearcoat"),
    }
    tint = input_of(node, groups, "Specular Tint")
    if tint is not None and tint.node is None and not hasattr(tint.default, "__len__"):
        values["spec_tint"] = scalar("Specular Tint")
        values["sheen_tint"] = scalar("Sheen Tint")
    elif tint is not None and reader.color(tint) != WHITE:
        reader.problem("a Specular Tint as a color is not supported; white is taken")
    if values["clearcoat"] != BLACK:
        # Mitsuba's gloss 0 is a roughness alpha of 0.1, 1 is 0.001; Blender's alpha is the square of the roughness.
        roughness = scalar("Coat Roughness", "Clearcoat Roughness")
        values["clearcoat_gloss"] = combine(lambda r: np.clip((0.1 - np.square(r)) / 0.099, 0, 1), roughness)

    perturbed = normals.perturbation(reader, input_of(node, groups, "Normal"))

    def make(color, writer):
        given = {name: writer.scalar(value) for name, value in values.items() if value != BLACK or name == "roughness"}
        return perturbed(plugin("bsdf", "principled", base_color=writer.color(color), eta=float(max(eta, 1.0001)), **given),
                         writer)

    emission = multiply(reader.input(node, groups, "Emission Color", "Emission"),
                        reader.scalar(input_of(node, groups, "Emission Strength")) or WHITE)
    surface = Surface([Lobe(WHITE, base, make, is_transmissive, is_linear=False)], BLACK, emission)
    alpha = reader.scalar(input_of(node, groups, "Alpha")) or WHITE
    if alpha == WHITE:
        return surface
    return surface.scaled(alpha).plus(Surface(transparency=complement(alpha)))


def _sheen(reader, node, groups, scalar):
    sheen = scalar("Sheen Weight", "Sheen")
    if sheen != BLACK and input_of(node, groups, "Sheen Roughness") is not None:
        reader.problem("the sheen of Blender 4 is another model than Burley's, which is taken")
    return sheen
