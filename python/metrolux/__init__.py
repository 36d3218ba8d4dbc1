"""Metrolux, a physically based renderer: scenes, rendering, images.

    import metrolux
    scene = metrolux.load("scene.xml")
    image = scene.render(time=60)          # float32 (height, width, 3), linear Rec.709
    metrolux.write("image.png", image)
"""

from types import MappingProxyType as _ReadOnly

import numpy as _numpy

from ._metrolux import (
    Comparison,
    Error,
    Integrator,
    Mesh,
    Parameter,
    Progress,
    Scene,
    Session,
    Transform,
    __version__,
    compare,
    integrators,
    load,
    load_dict,
    merge,
    png,
    read,
    write,
)

__all__ = [
    "Comparison", "Error", "Image", "Integrator", "Interrupted", "Mesh", "Parameter", "Progress", "Scene", "Session",
    "Transform", "compare", "integrators", "load", "load_dict", "merge", "png", "read", "write",
]  # fmt: skip


class Image(_numpy.ndarray):
    """Pixels, float32 (height, width, channels), linear Rec.709: a numpy array that notebooks show as a picture.

    exposure (stops) and curve (srgb, filmic, or none for display values) say how it is shown; arrays that are
    computed from it have them too. layers (a dict) and statistics are those of the rendering that it is the result
    of.
    """

    exposure = 0.0
    curve = "srgb"
    layers = _ReadOnly({})
    statistics = _ReadOnly({})

    def __array_finalize__(self, other):
        if isinstance(other, Image):
            self.exposure, self.curve = other.exposure, other.curve

    def __array_wrap__(self, array, *context):
        return array[()] if array.ndim == 0 else super().__array_wrap__(array, *context)

    def shown(self, *, exposure=None, curve=None):
        """The same pixels, shown with another exposure or curve."""
        image = self.view()
        image.__dict__.update(self.__dict__)
        image.exposure = self.exposure if exposure is None else exposure
        image.curve = self.curve if curve is None else curve
        return image

    def save(self, file):
        """Writes .exr (linear) or .png (with exposure and curve)."""
        write(file, self, exposure=self.exposure, curve=self.curve)

    def _repr_png_(self):
        is_picture = self.ndim == 2 or (self.ndim == 3 and self.shape[2] in (1, 3))
        return png(self, exposure=self.exposure, curve=self.curve) if is_picture and self.size > 0 else None


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, after the pass that was in progress; image is what was rendered, None before the first pass."""

    def __init__(self, image):
        super().__init__("interrupted")
        self.image = image
