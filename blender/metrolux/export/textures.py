"""Nodes that give colors and numbers."""

import math

import numpy as np

from . import pictures
from .graph import Input, input_of
from .values import (
    BLACK,
    CannotCombine,
    MeshColor,
    Placement,
    WHITE,
    add,
    combine,
    constant,
    luminance,
    multiply,
)

NODES = {}  # bl_idname: (name in Blender, what becomes of it, function)


def node(kind, name, becomes):
    def register(function):
        NODES[kind] = (name, becomes, function)
        return function

    return register


class TextureReader:
    """Values of sockets, for one material, light or world that `thing` names."""

    def __init__(self, problems, thing):
        self.problems, self.thing = problems, thing

    def problem(self, message):
        self.problems.add(self.thing, message)

    def color(self, socket):
        """The value of an Input as a color; None stands for an input that this version of Blender does not have."""
        if socket is None:
            return None
        if socket.node is None:
            return constant(socket.default if socket.default is not None else 0)
        kind = socket.node.bl_idname
        if kind not in NODES:
            self.problem(f"the node {socket.node.bl_label} is not supported; gray is taken for what it gives")
            return constant(0.5)
        try:
            return NODES[kind][2](self, socket.node, socket.output, socket.groups)
        except CannotCombine as problem:
            self.problem(f"the node {socket.node.bl_label}: {problem}; gray is taken for what it gives")
            return constant(0.5)

    def scalar(self, socket):
        """The value as gray: of a color, its luminance."""
        value = self.color(socket)
        if value is None or socket.node is None or socket.output.type in ("VALUE", "INT"):
            return value
        return luminance(value)

    def number(self, socket, what):
        """A constant; a texture is named, and its mean taken."""
        value = self.scalar(socket)
        if value is None or value.is_constant:
            return None if value is None else value.scalar
        self.problem(f"{what} cannot have a texture; one value is taken")
        return float(value.array().mean()) if not isinstance(value, MeshColor) else 0.5

    def input(self, node, groups, *names):
        return self.color(input_of(node, groups, *names))

    def placement(self, socket, wrap="repeat", filter="bilinear"):
        """Where the coordinates of a picture come from."""
        uv_map, matrix = "", np.eye(3)
        while socket is not None and socket.node is not None:
            node, groups = socket.node, socket.groups
            if node.bl_idname == "ShaderNodeMapping":
                matrix = matrix @ self._mapping(node, groups)
                socket = input_of(node, groups, "Vector")
                if socket.node is None:
                    self.problem("a Mapping node without input; UV coordinates are taken")
            elif node.bl_idname == "ShaderNodeUVMap":
                uv_map, socket = node.uv_map, None
            elif node.bl_idname == "ShaderNodeTexCoord" and socket.output.name == "UV":
                socket = None
            elif node.bl_idname == "ShaderNodeAttribute" and socket.output.name == "Vector":
                uv_map, socket = node.attribute_name, None
            else:
                self.problem(f"coordinates {socket.output.name} of {node.bl_label} are not supported; UV is taken")
                socket = None
        return Placement(uv_map, tuple(tuple(float(v) for v in row) for row in matrix), wrap, filter)

    def _mapping(self, node, groups):
        values = {}
        for name in ("Location", "Rotation", "Scale"):
            socket = input_of(node, groups, name)
            if socket is None:  # a Mapping of a kind without this input
                values[name] = np.zeros(3)
                continue
            value = self.color(socket)
            if not value.is_constant:
                self.problem("a Mapping node with a texture as input; its default is taken")
                value = constant(1 if name == "Scale" else 0)
            values[name] = np.array(value.color)
        if node.vector_type not in ("POINT", "TEXTURE"):
            self.problem(f"a Mapping node of the kind {node.vector_type} is read as POINT")
        if abs(values["Rotation"][0]) > 1e-6 or abs(values["Rotation"][1]) > 1e-6:
            self.problem("a Mapping node rotates a picture out of its plane; the rotation about Z is taken")
        c, s = math.cos(values["Rotation"][2]), math.sin(values["Rotation"][2])
        matrix = (
            np.array([[1, 0, values["Location"][0]], [0, 1, values["Location"][1]], [0, 0, 1]])
            @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            @ np.diag([values["Scale"][0], values["Scale"][1], 1])
        )
        if node.vector_type == "TEXTURE":
            matrix = np.linalg.inv(matrix) if abs(np.linalg.det(matrix)) > 1e-12 else np.eye(3)
        return matrix


_WRAPS = {"REPEAT": "repeat", "EXTEND": "clamp", "MIRROR": "mirror"}


@node("ShaderNodeTexImage", "Image Texture", "`bitmap`: UV map, Mapping, extension, color space; CLIP as repeat")
def _image(reader, node, output, groups):
    if node.projection != "FLAT":
        reader.problem(f"the projection {node.projection} of an image is not supported; FLAT is taken")
    if node.extension not in _WRAPS:
        reader.problem(f"the extension {node.extension} of an image is not supported; REPEAT is taken")
    filter = "nearest" if node.interpolation == "Closest" else "bilinear"
    placement = reader.placement(input_of(node, groups, "Vector"), _WRAPS.get(node.extension, "repeat"), filter)
    alpha = output.name == "Alpha"
    picture = pictures.picture_of(node.image, placement, reader.problems, reader.thing, alpha)
    return picture or (WHITE if alpha else BLACK)


@node("ShaderNodeRGB", "RGB", "constant")
@node("ShaderNodeValue", "Value", "constant")
def _constant(reader, node, output, groups):
    return constant(output.default_value)


@node("ShaderNodeBlackbody", "Blackbody", "constant, Rec. 709, by a fit of the Planckian locus")
def _blackbody(reader, node, output, groups):
    kelvin = reader.number(input_of(node, groups, "Temperature"), "the temperature of a Blackbody")
    return constant(blackbody(kelvin))


def blackbody(kelvin):
    """The color of a black body with luminance 1, linear Rec. 709 (Kim et al. 2002 for the chromaticity)."""
    t = min(max(kelvin, 1667.0), 25000.0)
    if t <= 4000:
        x = -0.2661239e9 / t**3 - 0.2343589e6 / t**2 + 0.8776956e3 / t + 0.179910
    else:
        x = -3.0258469e9 / t**3 + 2.1070379e6 / t**2 + 0.2226347e3 / t + 0.240390
    if t <= 2222:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif t <= 4000:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    xyz = np.array([x / y, 1, (1 - x - y) / y])
    to_rgb = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560],
                       [0.0556434, -0.2040259, 1.0572252]])
    return np.maximum(to_rgb @ xyz, 0)


@node("ShaderNodeVertexColor", "Color Attribute", "`mesh_attribute`")
def _vertex_color(reader, node, output, groups):
    if output.name != "Color":
        reader.problem("the alpha of a color attribute is not supported; 1 is taken")
        return WHITE
    return MeshColor(node.layer_name)


@node("ShaderNodeAttribute", "Attribute", "`mesh_attribute` for a color attribute, a UV map where its Vector is linked")
def _attribute(reader, node, output, groups):
    if node.attribute_type != "GEOMETRY" or output.name != "Color":
        reader.problem(f"attributes of the kind {node.attribute_type} ({output.name}) are not supported; black is taken")
        return BLACK
    return MeshColor(node.attribute_name)


def _curve(function):
    """A function of one channel over arrays, by a table with 4096 steps on [0, 1]."""
    table = np.array([function(i / 4095) for i in range(4096)], np.float32)

    def apply(x):
        return table[np.clip(np.round(x * 4095), 0, 4095).astype(int)]

    return apply


@node("ShaderNodeValToRGB", "Color Ramp", "baked into a picture")
def _ramp(reader, node, output, groups):
    factor = reader.scalar(input_of(node, groups, "Fac", "Factor"))
    ramp = node.color_ramp
    if output.name == "Alpha":
        table = _curve(lambda x: (ramp.evaluate(x)[3],) * 3)
    else:
        table = _curve(lambda x: ramp.evaluate(x)[:3])
    return combine(lambda x: table(x[:, :, 0]), factor)


@node("ShaderNodeRGBCurve", "RGB Curves", "baked")
def _curves(reader, node, output, groups):
    color = reader.input(node, groups, "Color")
    factor = reader.scalar(input_of(node, groups, "Fac", "Factor"))
    mapping = node.mapping
    mapping.update()
    tables = [_curve(lambda x, c=c: mapping.evaluate(mapping.curves[c], mapping.evaluate(mapping.curves[3], x)))
              for c in range(3)]

    def apply(x, f):
        curved = np.stack([tables[c](x[:, :, c]) for c in range(3)], axis=2)
        return x + f * (curved - x)

    return combine(apply, color, factor)


@node("ShaderNodeInvert", "Invert Color", "baked")
def _invert(reader, node, output, groups):
    factor = reader.scalar(input_of(node, groups, "Fac", "Factor"))
    return combine(lambda x, f: x + f * (1 - 2 * x), reader.input(node, groups, "Color"), factor)


@node("ShaderNodeGamma", "Gamma", "baked")
def _gamma(reader, node, output, groups):
    gamma = reader.scalar(input_of(node, groups, "Gamma"))
    return combine(lambda x, g: np.maximum(x, 0) ** g, reader.input(node, groups, "Color"), gamma)


@node("ShaderNodeBrightContrast", "Brightness/Contrast", "baked")
def _bright_contrast(reader, node, output, groups):
    bright, contrast = (reader.scalar(input_of(node, groups, name)) for name in ("Bright", "Contrast"))
    return combine(
        lambda x, b, c: np.maximum((1 + c) * x + b - c * 0.5, 0), reader.input(node, groups, "Color"), bright, contrast
    )


def _rgb_to_hsv(x):
    most, least = x.max(axis=2), x.min(axis=2)
    spread = most - least
    safe = np.where(spread > 0, spread, 1)
    r, g, b = (x[:, :, c] for c in range(3))
    hue = np.where(most == r, (g - b) / safe % 6, np.where(most == g, (b - r) / safe + 2, (r - g) / safe + 4)) / 6
    saturation = np.where(most > 0, spread / np.where(most > 0, most, 1), 0)
    return np.where(spread > 0, hue, 0), saturation, most


def _hsv_to_rgb(hue, saturation, value):
    channels = []
    for offset in (5, 3, 1):
        k = (offset + hue * 6) % 6
        channels.append(value - value * saturation * np.clip(np.minimum(k, 4 - k), 0, 1))
    return np.stack(channels, axis=2)


@node("ShaderNodeHueSaturation", "Hue/Saturation/Value", "baked")
def _hue_saturation(reader, node, output, groups):
    names = (("Hue",), ("Saturation",), ("Value",), ("Fac", "Factor"))
    hue, saturation, value, factor = (reader.scalar(input_of(node, groups, *name)) for name in names)

    def apply(x, h, s, v, f):
        old_hue, old_saturation, old_value = _rgb_to_hsv(x)
        new = _hsv_to_rgb((old_hue + h[:, :, 0] + 0.5) % 1, np.clip(old_saturation * s[:, :, 0], 0, 1),
                          old_value * v[:, :, 0])
        return np.maximum(x + f * (new - x), 0)

    return combine(apply, reader.input(node, groups, "Color"), hue, saturation, value, factor)


_BLENDS = {
    "MIX": lambda a, b: b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
    "DIVIDE": lambda a, b: np.where(b != 0, a / np.where(b != 0, b, 1), a),
    "DIFFERENCE": lambda a, b: np.abs(a - b),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "OVERLAY": lambda a, b: np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b)),
}


@node("ShaderNodeMixRGB", "Mix (before 3.4)", "the same as Mix")
def _mix_rgb(reader, node, output, groups):
    return _mixed(reader, node, Input(node.inputs[0], groups), Input(node.inputs[1], groups),
                  Input(node.inputs[2], groups), node.use_clamp, False)


@node("ShaderNodeMix", "Mix", "numbers and colors; products, and factors of 0 and 1, as they are, else baked")
def _mix(reader, node, output, groups):
    suffix = {"RGBA": "Color", "FLOAT": "Float", "VECTOR": "Vector"}.get(node.data_type)
    if suffix is None or (node.data_type == "VECTOR" and node.factor_mode != "UNIFORM"):
        reader.problem(f"a Mix node of the kind {node.data_type} is not supported; gray is taken for what it gives")
        return constant(0.5)
    by_identifier = {socket.identifier: socket for socket in node.inputs}
    factor, a, b = (Input(by_identifier[name], groups) for name in
                    ("Factor_Float", f"A_{suffix}", f"B_{suffix}"))
    blend = node.data_type == "RGBA"
    return _mixed(reader, node, factor, a, b, blend and node.clamp_result, not blend, node.clamp_factor)


def _mixed(reader, node, factor, a, b, clamp_result, only_mix, clamp_factor=True):
    kind = "MIX" if only_mix else node.blend_type
    f, x, y = reader.scalar(factor), reader.color(a), reader.color(b)
    if kind not in _BLENDS:
        reader.problem(f"the blend type {kind} of a Mix node is not supported; MIX is taken")
        kind = "MIX"
    if f.is_constant and clamp_factor:
        f = constant(min(max(f.scalar, 0), 1))
    if f.is_constant and not clamp_result:
        if f.scalar == 0:
            return x
        if kind == "MIX" and f.scalar == 1:
            return y
        if kind == "MULTIPLY" and f.scalar == 1:
            return multiply(x, y)
        if kind == "ADD" and f.scalar == 1:
            return add(x, y)

    def apply(f, x, y):
        f = np.clip(f, 0, 1) if clamp_factor else f
        result = x + f * (_BLENDS[kind](x, y) - x)
        return np.clip(result, 0, 1) if clamp_result else result

    return combine(apply, f, x, y)


def _wrapped(x, high, low):
    span = high - low
    return np.where(span != 0, x - span * np.floor((x - low) / np.where(span != 0, span, 1)), low)


_MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: np.where(b != 0, a / np.where(b != 0, b, 1), 0),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: np.where((a >= 0) | (b == np.round(b)), np.abs(a) ** b * np.where((a < 0) & (b % 2 == 1), -1, 1), 0),
    "LOGARITHM": lambda a, b, c: np.log(np.maximum(a, 1e-30)) / np.log(np.maximum(b, 1e-30)),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) * 1.0,
    "GREATER_THAN": lambda a, b, c: (a > b) * 1.0,
    "SIGN": lambda a, b, c: np.sign(a),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: np.where(b != 0, np.fmod(a, np.where(b != 0, b, 1)), 0),
    "WRAP": _wrapped,
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "RADIANS": lambda a, b, c: np.radians(a),
    "DEGREES": lambda a, b, c: np.degrees(a),
}


@node("ShaderNodeMath", "Math", "folded where its inputs are constant, else baked")
def _math(reader, node, output, groups):
    if node.operation not in _MATH:
        reader.problem(f"the operation {node.operation} of a Math node is not supported; 0.5 is taken for what it gives")
        return constant(0.5)
    values = [reader.scalar(Input(socket, groups)) if socket.enabled else BLACK for socket in node.inputs]
    function = _MATH[node.operation]
    clamp = (lambda x: np.clip(x, 0, 1)) if node.use_clamp else (lambda x: x)
    return combine(lambda a, b, c: clamp(function(a, b, c)), *values)


@node("ShaderNodeClamp", "Clamp", "baked")
def _clamp(reader, node, output, groups):
    value, low, high = (reader.scalar(input_of(node, groups, name)) for name in ("Value", "Min", "Max"))
    return combine(np.clip, value, low, high)


@node("ShaderNodeMapRange", "Map Range", "baked; linear, of numbers")
def _map_range(reader, node, output, groups):
    if node.interpolation_type != "LINEAR" or getattr(node, "data_type", "FLOAT") != "FLOAT":
        reader.problem("a Map Range node that is not linear, or not of numbers, is read as linear")
    names = ("Value", "From Min", "From Max", "To Min", "To Max")
    values = [reader.scalar(input_of(node, groups, name)) for name in names]

    def apply(x, a, b, c, d):
        t = (x - a) / np.where(b != a, b - a, 1)
        result = c + t * (d - c)
        return np.clip(result, np.minimum(c, d), np.maximum(c, d)) if node.clamp else result

    return combine(apply, *values)


@node("ShaderNodeRGBToBW", "RGB to BW", "baked")
def _to_gray(reader, node, output, groups):
    return luminance(reader.input(node, groups, "Color"))


@node("ShaderNodeSeparateColor", "Separate Color", "baked; RGB")
@node("ShaderNodeSeparateRGB", "Separate RGB", "baked")
def _separate(reader, node, output, groups):
    if getattr(node, "mode", "RGB") != "RGB":
        reader.problem(f"Separate Color with the mode {node.mode} is read as RGB")
    channel = list(node.outputs).index(output)
    return combine(lambda x: np.repeat(x[:, :, channel : channel + 1], 3, axis=2), reader.color(Input(node.inputs[0], groups)))



@node("ShaderNodeCombineColor", "Combine Color", "baked; RGB")
@node("ShaderNodeCombineRGB", "Combine RGB", "baked")
def _combine(reader, node, output, groups):
    if getattr(node, "mode", "RGB") != "RGB":
        reader.problem(f"Combine Color with the mode {node.mode} is read as RGB")
    channels = [reader.scalar(Input(socket, groups)) for socket in list(node.inputs)[:3]]

    def apply(*arrays):
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
        return np.stack([np.broadcast_to(array, shape)[:, :, 0] for array in arrays], axis=2)

    return combine(apply, *channels)
