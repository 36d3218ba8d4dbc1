"""Images of Blender as pictures, and pictures as files that Metrolux reads."""

import os
import shutil

import numpy as np

from .. import compat, exr
from .values import Picture, Placement, srgb_to_linear

# Formats that OpenImageIO reads as Blender does, bit for bit.
_READABLE = {"PNG": ".png", "JPEG": ".jpg", "OPEN_EXR": ".exr", "HDR": ".hdr", "TARGA": ".tga", "BMP": ".bmp"}
_LINEAR = {"Linear", "Linear Rec.709", "Non-Color", "Raw", "Generic Data", "Utility - Raw"}


def pixels_of(image):
    """The pixels that Blender has in memory, as the file has them: shape (height, width, channels), top row first."""
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, image.channels)[::-1]


def _colors(image, raw, alpha):
    pixels = pixels_of(image)
    if alpha:
        channel = pixels[:, :, 3:4] if image.channels == 4 else np.ones_like(pixels[:, :, :1])
        return np.repeat(channel, 3, axis=2)
    colors = pixels[:, :, :3] if image.channels >= 3 else np.repeat(pixels[:, :, :1], 3, axis=2)
    return colors if raw else srgb_to_linear(colors)


def picture_of(image, placement, problems, thing, alpha=False):
    """An image of Blender as a picture; None if it has no pixels. `alpha`: its opacity as gray."""
    if image is None or image.size[0] == 0:
        problems.add(thing, f"the image {image.name if image else ''!r} has no pixels; it is left out".replace("''", ""))
        return None
    if image.source in ("MOVIE", "TILED"):
        problems.add(thing, f"images of the kind {image.source} are not supported; what Blender has loaded of it is taken")
    space = image.colorspace_settings.name
    raw = space in _LINEAR or image.is_float
    if not raw and space != "sRGB":
        problems.add(thing, f"the color space {space!r} is not supported; sRGB is taken")
    path = ""
    if not alpha and image.source == "FILE" and not image.packed_file and not image.is_dirty:
        candidate = compat.absolute_path(image)
        readable = image.file_format in _READABLE and not (image.is_float and space not in _LINEAR)
        # Blender's colors are not multiplied by alpha, and a file's may be.
        if readable and os.path.isfile(candidate) and (image.depth in (8, 24, 48, 96) or image.alpha_mode == "NONE"
                                                       or not image.is_float):
            path = candidate
    return Picture(lambda: _colors(image, raw, alpha), placement, image.name, path, raw)


def environment_of(image, problems, thing):
    return picture_of(image, Placement(), problems, thing)


class PictureFiles:
    """Where pictures are written: each once. `copies`: files of the user's are copied, too, so that a folder is complete."""

    def __init__(self, folder, copies):
        self._folder, self._copies, self._names = folder, copies, {}

    def path(self, picture, half=True):
        """The file for a picture, relative to the scene's folder if it is in it, and whether its values are linear."""
        key = (picture.file,) if picture.file else (id(picture.load),)
        if key not in self._names:
            self._names[key] = (self._store(picture, half), picture)  # the picture stays alive, so that ids are unique
        return self._names[key][0], picture.raw if picture.file else True

    def _store(self, picture, half):
        if picture.file and not self._copies:
            return picture.file
        os.makedirs(os.path.join(self._folder, "textures"), exist_ok=True)
        stem = "".join(c if c.isalnum() or c in "-_." else "_" for c in os.path.splitext(picture.name)[0]) or "image"
        ending = os.path.splitext(picture.file)[1] if picture.file else ".exr"
        name = f"textures/{stem}-{len(self._names)}{ending}"
        target = os.path.join(self._folder, name)
        if picture.file:
            shutil.copyfile(picture.file, target)
        else:
            exr.write(target, np.ascontiguousarray(picture.array()), half)
        return name
