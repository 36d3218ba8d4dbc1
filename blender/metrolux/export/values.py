"""Values of a node's socket over a surface: constant, of a picture, or of the mesh's colors.

Nodes that change colors are evaluated on whole pictures, pixel by pixel, so that what Mitsuba's textures cannot say
becomes a picture that they can show.
"""

from dataclasses import dataclass, replace
from typing import Callable

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True)
class Placement:
    """How a picture lies on a surface. `matrix`: 3x3 rows, from the UV map to the picture, v upward."""

    uv_map: str = ""  # empty: the one that is active for rendering
    matrix: tuple = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    wrap: str = "repeat"
    filter: str = "bilinear"


class Value:
    """A color (three channels) over a surface."""

    is_constant = False


@dataclass(frozen=True)
class Constant(Value):
    color: tuple
    is_constant = True

    def array(self):
        return np.array(self.color, np.float32).reshape(1, 1, 3)

    @property
    def scalar(self):
        return float(np.mean(self.color))


@dataclass(frozen=True, eq=False)
class Picture(Value):
    """Linear pixels, shape (height, width, 3), top row first; read by `load` when somebody asks for them."""

    load: Callable
    placement: Placement
    name: str
    file: str = ""  # a file whose pixels are these
    raw: bool = False  # the file's values are linear already

    def array(self):
        return self.load()

    def placed(self, placement):
        return replace(self, placement=placement)


@dataclass(frozen=True)
class MeshColor(Value):
    """The color attribute `name` of the mesh, times `factor`."""

    name: str
    factor: float = 1.0


def constant(value):
    color = tuple(float(v) for v in value[:3]) if hasattr(value, "__len__") else (float(value),) * 3
    return Constant(color)


BLACK, WHITE = constant(0), constant(1)


class CannotCombine(Exception):
    """Two values cannot be computed with; the text says why."""


def _resized(pixels, height, width):
    if pixels.shape[0] in (1, height) and pixels.shape[1] in (1, width):
        return pixels
    rows = (np.arange(height) + 0.5) * pixels.shape[0] / height
    columns = (np.arange(width) + 0.5) * pixels.shape[1] / width
    return pixels[rows.astype(int)][:, columns.astype(int)]


def combine(function, *values):
    """function(arrays...) of values, each array of shape (height, width, 3) or (1, 1, 3)."""
    if all(value.is_constant for value in values):
        return constant(np.broadcast_to(function(*(value.array() for value in values)), (1, 1, 3))[0, 0])
    if any(isinstance(value, MeshColor) for value in values):
        raise CannotCombine("colors of the mesh can be used as they are only")
    pictures = [value for value in values if isinstance(value, Picture)]
    placement = pictures[0].placement
    if any(picture.placement != placement for picture in pictures):
        raise CannotCombine("pictures that lie differently on the surface are mixed")

    def compute():
        arrays = [value.array() for value in values]
        height, width = (max(array.shape[axis] for array in arrays) for axis in (0, 1))
        arrays = [_resized(array, height, width) for array in arrays]
        return np.broadcast_to(function(*arrays), (height, width, 3)).astype(np.float32)

    pixels = compute()
    first = pixels[0, 0]
    if np.all(np.abs(pixels - first) <= 1e-6 * np.maximum(1, np.abs(first))):
        return constant(first)
    return Picture(lambda: pixels, placement, pictures[0].name)


def multiply(a, b):
    for value, other in ((a, b), (b, a)):
        if value == WHITE:
            return other
        if value == BLACK:
            return BLACK
        if isinstance(value, MeshColor) and other.is_constant and len(set(other.color)) == 1:
            return replace(value, factor=value.factor * other.scalar)
    return combine(np.multiply, a, b)


def add(a, b):
    for value, other in ((a, b), (b, a)):
        if value == BLACK:
            return other
    return combine(np.add, a, b)


def complement(a):
    return combine(lambda x: 1 - x, a)


def luminance(a):
    if isinstance(a, MeshColor):
        return a
    return combine(lambda x: (x @ LUMINANCE)[:, :, None], a)


def srgb_to_linear(x):
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0.04045) + 0.055) / 1.055) ** 2.4).astype(np.float32)
