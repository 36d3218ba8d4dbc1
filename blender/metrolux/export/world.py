"""The World: a constant, or a map of the sky, with the suns that have a size drawn into it."""

import math

import numpy as np

from .. import compat
from . import pictures
from .graph import Input, input_of, output_node
from .textures import TextureReader
from .values import BLACK, CannotCombine, Picture, Placement, WHITE, combine, constant, multiply
from .xml import add, plugin, rgb, transform

# From the frame of Mitsuba's map (+y up, the middle of the map at +z) to that of Blender's (+z up, the middle at +x).
_FRAME = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
_MOST_WIDTH = 8192
NODES = {
    "ShaderNodeTexEnvironment": ("Environment Texture", "`envmap` with the rotation of a Mapping node; equirectangular"),
}


class _WorldReader(TextureReader):
    """Colors of a world: Environment Textures are its pictures, and their rotation is kept."""

    def __init__(self, problems, thing):
        super().__init__(problems, thing)
        self.rotation = np.eye(3)

    def color(self, socket):
        if socket is not None and socket.node is not None and socket.node.bl_idname == "ShaderNodeTexEnvironment":
            return self._environment(socket.node, socket.groups)
        return super().color(socket)

    def _environment(self, node, groups):
        if node.projection != "EQUIRECTANGULAR":
            self.problem(f"the projection {node.projection} of an environment is read as EQUIRECTANGULAR")
        self.rotation = self._rotation(input_of(node, groups, "Vector"))
        return pictures.picture_of(node.image, Placement(), self.problems, self.thing) or BLACK

    def _rotation(self, socket):
        """The rotation that takes directions of the world to those of the picture."""
        if socket is None or socket.node is None:
            return np.eye(3)
        node = socket.node
        if node.bl_idname == "ShaderNodeTexCoord" and socket.output.name in ("Generated", "Normal"):
            return np.eye(3)
        if node.bl_idname != "ShaderNodeMapping":
            self.problem(f"coordinates of {node.bl_label} are not supported; the sky is not turned")
            return np.eye(3)
        from mathutils import Euler

        rotation = super().color(input_of(node, socket.groups, "Rotation"))
        scale = super().color(input_of(node, socket.groups, "Scale"))
        if not scale.is_constant or max(abs(abs(s) - 1) for s in scale.color) > 1e-6 or not rotation.is_constant:
            self.problem("a Mapping node of the sky that scales, or has textures as inputs, is not supported")
            rotation = rotation if rotation.is_constant else constant(0)
            scale = WHITE
        matrix = np.array(Euler(rotation.color).to_matrix()) @ np.diag(scale.color)
        if node.vector_type == "TEXTURE":
            matrix = np.linalg.inv(matrix)
        return matrix @ self._rotation(input_of(node, socket.groups, "Vector"))


def _radiance(world, problems):
    """The radiance of the sky as a Value, and its rotation."""
    if world is None:
        return BLACK, np.eye(3)
    thing = f"world {world.name}"
    if not world.use_nodes or world.node_tree is None:
        return constant(world.color), np.eye(3)
    reader = _WorldReader(problems, thing)
    output = output_node(world.node_tree, "ShaderNodeOutputWorld")
    if output is None:
        return BLACK, np.eye(3)
    volume = input_of(output, (), "Volume")
    if volume is not None and volume.node is not None:
        reader.problem("the volume of the world is not rendered: volumes are not exported yet")
    try:
        return _shader(reader, input_of(output, (), "Surface")), reader.rotation
    except CannotCombine as problem:
        reader.problem(f"{problem}; the sky is black")
        return BLACK, np.eye(3)


def _shader(reader, socket):
    if socket.node is None:
        return BLACK
    node, groups = socket.node, socket.groups
    if node.bl_idname in ("ShaderNodeBackground", "ShaderNodeEmission"):
        strength = reader.scalar(input_of(node, groups, "Strength"))
        return multiply(reader.input(node, groups, "Color"), strength)
    if node.bl_idname == "ShaderNodeAddShader":
        return combine(np.add, *(_shader(reader, Input(s, groups)) for s in list(node.inputs)[:2]))
    if node.bl_idname == "ShaderNodeMixShader":
        factor = reader.scalar(Input(node.inputs[0], groups))
        first, second = (_shader(reader, Input(s, groups)) for s in list(node.inputs)[1:3])
        return combine(lambda f, a, b: a + f * (b - a), factor, first, second)
    reader.problem(f"the shader {node.bl_label} of a world is not supported; the sky is black")
    return BLACK


def emitter(world, suns, files, problems):
    """The environment <emitter>, None where the sky is black. `suns`: (direction to it, irradiance, angle) with a size."""
    radiance, rotation = _radiance(world, problems)
    if suns:
        pixels = _turned(radiance, rotation, _width_for(radiance, suns))
        for direction, irradiance, angle in suns:
            _draw_sun(pixels, np.asarray(direction), np.asarray(irradiance), angle)
        sky = Picture(lambda: pixels, Placement(), "sky")
        return _map(sky, np.eye(3), files)
    if radiance == BLACK:
        return None
    if radiance.is_constant:
        return plugin("emitter", "constant", radiance=rgb(radiance.color))
    return _map(_from_pole_to_pole(radiance), rotation, files)


def _map(picture, rotation, files):
    path, _ = files.path(picture, half=False)
    element = plugin("emitter", "envmap", filename=path)
    to_world = np.eye(4)
    to_world[:3, :3] = np.linalg.inv(rotation)
    add(element, "to_world", transform(to_world @ _FRAME))
    return element


def _from_pole_to_pole(picture):
    """A map whose first and last rows are the poles, as Mitsuba has it; those of Blender begin half a row further in. Of
    large maps that half row is less than 0.1 degrees, and they stay as they are."""
    pixels = picture.array()
    if len(pixels) >= 1024:
        return picture
    result = np.repeat(pixels, 2, axis=0)
    result = np.concatenate([result, result[-1:]])
    result[2:-1:2] = 0.5 * (pixels[:-1] + pixels[1:])
    return Picture(lambda: result, picture.placement, picture.name)


def _width_for(radiance, suns):
    """At least six pixels across the smallest sun, and what a picture of the sky has."""
    wanted = 6 * 2 * math.pi / min(angle for _, _, angle in suns)
    if isinstance(radiance, Picture):
        wanted = max(wanted, radiance.array().shape[1])
    return min(1 << math.ceil(math.log2(max(wanted, 64))), _MOST_WIDTH)


def directions(width, height, rows=slice(None)):
    """Of the pixels of a map in Blender's frame, the first and the last row at the poles: shape (rows, width, 3)."""
    azimuth = -2 * math.pi * ((np.arange(width) + 0.5) / width - 0.5)
    elevation = math.pi * (0.5 - np.arange(height)[rows] / (height - 1))
    c = np.cos(elevation)[:, None]
    return np.stack(np.broadcast_arrays(c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)[:, None]), axis=2)


def _turned(radiance, rotation, width):
    """The sky as pixels of the world's frame, shape (width / 2 + 1, width, 3)."""
    height = width // 2 + 1
    result = np.empty((height, width, 3), np.float32)
    if radiance.is_constant:
        result[:] = radiance.color
        return result
    source = radiance.array()
    for row in range(height):
        d = directions(width, height, slice(row, row + 1))[0] @ rotation.T
        u = -np.arctan2(d[:, 1], d[:, 0]) / (2 * math.pi) + 0.5
        v = 0.5 - np.arctan2(d[:, 2], np.hypot(d[:, 0], d[:, 1])) / math.pi
        result[row] = _bilinear(source, u, v)
    return result


def _bilinear(source, u, v):
    x, y = u * source.shape[1] - 0.5, np.clip(v * source.shape[0] - 0.5, 0, source.shape[0] - 1)
    x0, y0 = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), source.shape[0] - 1)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    x1, y1 = (x0 + 1) % source.shape[1], np.minimum(y0 + 1, source.shape[0] - 1)
    x0 %= source.shape[1]
    return (source[y0, x0] * (1 - fx) + source[y0, x1] * fx) * (1 - fy) + (source[y1, x0] * (1 - fx) + source[y1, x1] * fx) * fy


def _draw_sun(pixels, direction, irradiance, angle):
    """Adds a disk of the angle (its diameter), with smooth edges, of the sun's strength."""
    height, width, _ = pixels.shape
    step = math.pi / (height - 1)
    elevation = math.asin(min(max(direction[2], -1), 1))
    first = int(max((math.pi / 2 - elevation - angle / 2 - 2 * step) / step, 0))
    last = int(min((math.pi / 2 - elevation + angle / 2 + 2 * step) / step + 1, height))
    d = directions(width, height, slice(first, last))
    cosine = np.clip(d @ direction, -1, 1)
    distance = np.arctan2(np.linalg.norm(np.cross(d, direction), axis=2), cosine)
    cover = np.clip((angle / 2 - distance) / step + 0.5, 0, 1)
    solid = np.hypot(d[:, :, 0], d[:, :, 1]) * step * (2 * math.pi / width)
    shape, power = compat.sun_radiance(cosine)
    total = float((cover * shape * solid * np.maximum(cosine, 0) ** power).sum())
    pixels[first:last] += (cover * shape / total)[:, :, None] * irradiance.astype(np.float32)
