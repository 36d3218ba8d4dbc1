"""Normal Map and Bump nodes: what they do to the BSDF whose normal they feed."""

import numpy as np

from .graph import input_of
from .values import MeshColor, combine
from .xml import plugin

NODES = {
    "ShaderNodeNormalMap": ("Normal Map", "`normalmap`, tangent space; a strength is baked into the picture"),
    "ShaderNodeBump": ("Bump", "`bumpmap` with Distance × Strength as its scale: the same slope for small ones"),
}


def perturbation(reader, socket):
    """A function (bsdf, writer) that wraps a BSDF in the maps that feed a Normal input."""
    if socket is None or socket.node is None:
        return lambda bsdf, writer: bsdf
    node, groups = socket.node, socket.groups
    if node.bl_idname == "ShaderNodeNormalMap":
        return _normal_map(reader, node, groups)
    if node.bl_idname == "ShaderNodeBump":
        return _bump(reader, node, groups)
    reader.problem(f"the node {node.bl_label} as a normal is not supported; the mesh's normal is taken")
    return lambda bsdf, writer: bsdf


def _normal_map(reader, node, groups):
    if node.space != "TANGENT":
        reader.problem(f"normal maps of the space {node.space} are not supported; the mesh's normal is taken")
        return lambda bsdf, writer: bsdf
    color = reader.input(node, groups, "Color")
    strength = reader.number(input_of(node, groups, "Strength"), "the strength of a Normal Map")
    if isinstance(color, MeshColor):
        reader.problem("a Normal Map of colors of the mesh is not supported; the mesh's normal is taken")
        return lambda bsdf, writer: bsdf
    if abs(strength - 1) > 1e-4:
        color = combine(lambda x: _weakened(x, strength), color)

    def wrap(bsdf, writer):
        result = plugin("bsdf", "normalmap", normalmap=writer.texture(color))
        result.append(bsdf)
        return result

    return wrap


def _weakened(x, strength):
    """Cycles: the normal moves toward the mesh's by 1 - strength."""
    tilted = 2 * x - 1
    tilted = tilted / np.maximum(np.linalg.norm(tilted, axis=2, keepdims=True), 1e-6)
    moved = np.array([0, 0, 1]) + strength * (tilted - np.array([0, 0, 1]))
    moved = moved / np.maximum(np.linalg.norm(moved, axis=2, keepdims=True), 1e-6)
    return 0.5 * moved + 0.5


def _bump(reader, node, groups):
    height = reader.scalar(input_of(node, groups, "Height"))
    if height.is_constant:
        return perturbation(reader, input_of(node, groups, "Normal"))
    if isinstance(height, MeshColor):
        reader.problem("a Bump of colors of the mesh is not supported; the mesh's normal is taken")
        return lambda bsdf, writer: bsdf
    strength = reader.number(input_of(node, groups, "Strength"), "the strength of a Bump")
    scale = strength * reader.number(input_of(node, groups, "Distance"), "the distance of a Bump")
    below = perturbation(reader, input_of(node, groups, "Normal"))

    def wrap(bsdf, writer):
        result = plugin("bsdf", "bumpmap", scale=-scale if node.invert else scale)
        result.append(writer.texture(height))
        result.append(bsdf)
        return below(result, writer)

    return wrap
