"""From the command's EXR file to the passes of Blender."""

import numpy as np

from . import compat, exr

# Blender's passes by the layer of Metrolux that they come from: (name, channels, their letters).
OWN_PASSES = {"albedo": ("Albedo", 3, "RGB", "COLOR"), "variance": ("Variance", 1, "X", "VALUE")}
NO_DEPTH = 1e10  # what Blender has where nothing is hit


def layers_for(view_layer):
    """The layers that a view layer wants of the command. Without a transparent film alpha is 1, as in Cycles."""
    wanted = ["alpha"] if view_layer.id_data.render.film_transparent else []
    settings = view_layer.metrolux
    wanted += [name for name in OWN_PASSES if getattr(settings, f"use_{name}")]
    if view_layer.use_pass_z:
        wanted.append("depth")
    if view_layer.use_pass_normal:
        wanted.append("normal")
    return wanted


def _stack(channels, names):
    return np.stack([channels[name] for name in names], axis=2)


def _plane_depth(channels, window, lens):
    """Distances from the near plane along the rays, as distances from the camera along its axis."""
    distance = depth = channels["depth.Z"]
    x0, y0, width, height = window
    if lens.tangents is not None:
        size, (tx, ty), (sx, sy) = lens.size, lens.tangents, lens.shift
        x = ((np.arange(width) + x0 + 0.5) / size[0] * 2 - 1 + sx) * tx
        y = (1 - (np.arange(height) + y0 + 0.5) / size[1] * 2 + sy) * ty
        depth = depth / np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    return np.where(distance > 0, depth + lens.near, NO_DEPTH)


class Lens:
    """What turns distances into depths: of a perspective camera the tangents of half its view and its shift."""

    def __init__(self, camera, depsgraph, size):
        self.size, self.tangents, self.shift, self.near = size, None, (0, 0), 0.0
        if camera.data.type == "PANO":
            return
        matrix = np.array(camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1]))
        self.near = camera.data.clip_start
        if camera.data.type == "PERSP":
            self.tangents = (1 / matrix[0, 0], 1 / matrix[1, 1])
            self.shift = (matrix[0, 2], matrix[1, 2])


def fill(render_layer, path, lens, is_plain):
    """Gives the passes of a layer what the file has. One with colors only (`is_plain`) Blender reads itself, which is six
    times as quick; of others it does not, and it would multiply colors by alpha."""
    if is_plain and compat.LOADS_FILES:
        render_layer.load_from_file(path)
        return
    window, channels = exr.read(path)
    channels.setdefault("A", np.ones_like(channels["R"]))
    pictures = {"Combined": _stack(channels, "RGBA")}
    if "albedo.R" in channels:
        pictures["Albedo"] = _stack(channels, ["albedo.R", "albedo.G", "albedo.B"])
    if "normal.X" in channels:
        pictures["Normal"] = _stack(channels, ["normal.X", "normal.Y", "normal.Z"])
    if "variance.Y" in channels:
        pictures["Variance"] = _stack(channels, ["variance.Y"])
    if "depth.Z" in channels:
        pictures["Depth"] = _plane_depth(channels, window, lens)[:, :, None]
    for name, pixels in pictures.items():
        render_pass = render_layer.passes.get(name)
        if render_pass is not None and render_pass.channels == pixels.shape[2]:
            compat.set_pixels(render_pass, pixels[::-1])
