"""Values as elements of the scene."""

import numpy as np

from .values import MeshColor
from .xml import add, plugin, rgb, scalar, transform

_FLIP = np.array([[1, 0, 0], [0, -1, 1], [0, 0, 1]])


class ValueWriter:
    """Colors, numbers and textures, with their pictures in `files`. It notes which UV map and which color attribute of the
    mesh they need, since a file has one of each."""

    def __init__(self, files, problem):
        self._files, self._problem = files, problem
        self.uv_map = None
        self.mesh_color = None

    def color(self, value):
        """A reflectance; constants are cut at 1."""
        if value.is_constant:
            return rgb([min(max(c, 0), 1) for c in value.color])
        return self.texture(value)

    def radiance(self, value):
        return rgb([max(c, 0) for c in value.color]) if value.is_constant else self.texture(value, half=False)

    def scalar(self, value):
        return scalar(min(max(value.scalar, 0), 1)) if value.is_constant else self.texture(value)

    def texture(self, value, half=True):
        if value.is_constant:
            return plugin("texture", "rawconstant", value=rgb(value.color))
        if isinstance(value, MeshColor):
            self._need("mesh_color", value.name, "color attributes")
            element = plugin("texture", "mesh_attribute", scale=float(value.factor))
            add(element, "name", "vertex_color")
            return element
        placement = value.placement
        self._need("uv_map", placement.uv_map, "UV maps")
        path, raw = self._files.path(value, half)
        element = plugin("texture", "bitmap", filename=path, filter_type=placement.filter, wrap_mode=placement.wrap)
        if raw:
            add(element, "raw", True)
        # Mitsuba's v points down; what is rotated upward is rotated between two flips.
        matrix = _FLIP @ np.array(placement.matrix) @ _FLIP
        if not np.allclose(matrix, np.eye(3)):
            rows = np.eye(4)
            rows[:2, :2], rows[:2, 3] = matrix[:2, :2], matrix[:2, 2]
            add(element, "to_uv", transform(rows))
        return element

    def _need(self, attribute, name, what):
        known = getattr(self, attribute)
        if known is None:
            setattr(self, attribute, name)
        elif known != name:
            self._problem(f"several {what} in one material are not supported; {known or 'the active one'!r} is taken")
