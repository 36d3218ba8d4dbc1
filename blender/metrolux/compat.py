"""Everything that differs between the versions of Blender, 3.4 to 4.3, and between Blender in a window and without one."""

import math
import os

import bpy
import numpy as np

VERSION = bpy.app.version
EEVEE = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}  # its panels of lights, worlds and materials serve Metrolux, too


def absolute_path(image):
    return os.path.normpath(bpy.path.abspath(image.filepath, library=image.library))


def corner_normals(mesh):
    """Normals of the corners of a mesh's faces, custom and split ones included: shape (corners, 3)."""
    normals = np.empty(3 * len(mesh.loops), np.float32)
    if VERSION >= (4, 1, 0):
        mesh.corner_normals.foreach_get("vector", normals)
    else:
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals)
    return normals.reshape(-1, 3)


def corner_colors(mesh, name):
    """A color attribute at the corners, linear, shape (corners, 3); None if there is none of that name. Without a name the
    one that is active for rendering."""
    attributes = mesh.color_attributes
    index = attributes.render_color_index
    attribute = attributes.get(name) if name else (attributes[index] if 0 <= index < len(attributes) else None)
    if attribute is None:
        return None
    colors = np.empty(4 * len(attribute.data), np.float32)
    attribute.data.foreach_get("color", colors)
    colors = colors.reshape(-1, 4)[:, :3]
    return colors if attribute.domain == "CORNER" else colors[corner_vertices(mesh)]


def corner_vertices(mesh):
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    return vertices


def corner_uvs(mesh, name):
    """A UV map at the corners, shape (corners, 2); None if there is none of that name. Without a name the one that is active
    for rendering."""
    layers = mesh.uv_layers
    layer = layers.get(name) if name else next((layer for layer in layers if layer.active_render), None)
    if layer is None:
        return None
    uvs = np.empty(2 * len(mesh.loops), np.float32)
    if hasattr(layer, "uv") and len(layer.uv):  # 3.5 and later
        layer.uv.foreach_get("vector", uvs)
    else:
        layer.data.foreach_get("uv", uvs)
    return uvs.reshape(-1, 2)


def light_spread(light):
    """The full angle into which an area light shines."""
    return getattr(light, "spread", np.pi)


def cycles_setting(data, name, default):
    """A setting of Cycles, which 4.x has partly made Blender's own."""
    value = getattr(data, name, None)
    return getattr(getattr(data, "cycles", None), name, default) if value is None else value


def area_radiance(power, area):
    """Of an Area light, W/(m^2 sr): its power is its flux, and before 4.0 4/pi of it."""
    return power / (area * (4 if VERSION < (4, 0, 0) else math.pi))


def spot_falloff(cosine, half_angle, blend):
    """Cycles' spot: a smooth step between the cosines of the cone and of its inner part; before 4.0 times the cosine."""
    edge = math.cos(half_angle)
    smooth = (1 - edge) * blend
    t = np.clip((cosine - edge) / max(smooth, 1e-6), 0, 1)
    falloff = t * t * (3 - 2 * t)
    return falloff * cosine if VERSION < (4, 0, 0) else falloff


def transmitted_color(base):
    """The base color of glass for a model whose color is that of two crossings: before 4.0 Cycles has it for each."""
    return base * base if VERSION < (4, 0, 0) else base


def sun_radiance(cosine):
    """Cycles' sun over its disk, by the cosine of the angle to its middle, up to a factor; and what the strength is of it: the
    integral of the radiance times cosine^k, as k. Before 4.0 it is even on a plane, without the cosine of a surface."""
    if VERSION < (4, 0, 0):
        return np.maximum(cosine, 1e-3) ** -3, 0
    return np.ones_like(cosine), 1


def light_is_normalized(light):
    """4.5 can give a light's power per area; before, all are normalized."""
    return getattr(light, "normalize", True)


def later(function):
    """Runs a function that changes the document outside of a render: at once without a window, else when Blender is idle."""
    if bpy.app.background:
        function()
    else:
        bpy.app.timers.register(function)


# In 4.3 RenderLayer.load_from_file() leaves the layer black.
LOADS_FILES = VERSION < (4, 0, 0)


def set_pixels(render_pass, pixels):
    """Gives a pass of a RenderResult its pixels: shape (height, width, channels), bottom row first. (foreach_set() of a pass
    with several channels takes too few values.)"""
    flat = np.ascontiguousarray(pixels, np.float32)
    render_pass.rect = flat.reshape(-1, flat.shape[2])
