"""Metrolux against Cycles, block by block, with the noise of both."""

import math
import os
from dataclasses import dataclass

import bpy
import numpy as np

import support

BLOCK = 16  # pixels along the edge of a patch


@dataclass
class Comparison:
    """Means over the patches of a picture; noise is the standard error of a patch's ratio."""

    metrolux: np.ndarray
    cycles: np.ndarray
    ratios: np.ndarray  # of the patches that are bright enough to compare
    noise: np.ndarray

    @property
    def worst(self):
        return float(np.abs(self.ratios - 1).max())

    def __str__(self):
        mean = self.metrolux.mean() / self.cycles.mean() - 1
        return (f"{len(self.ratios)} patches, mean {100 * mean:+.2f} %, worst patch {100 * self.worst:.2f} %, noise of a patch "
                f"{100 * self.noise.max():.2f} %, so that {300 * self.noise.max():.2f} % would be seen")


def _patches(picture):
    """Luminance of blocks: mean of the channels."""
    height, width, _ = picture.shape
    gray = picture.mean(axis=2)
    return gray[: height // BLOCK * BLOCK, : width // BLOCK * BLOCK].reshape(
        height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3)).reshape(-1)


def compare(name, samples=256, passes=256, floor=0.05, parts=4):
    """Renders the scene in `parts` independent parts with each; patches darker than `floor` of the brightest are left out."""
    pictures = {}
    for engine, render, count in (("metrolux", support.metrolux, passes), ("cycles", support.cycles, samples)):
        pictures[engine] = [render(count // parts, seed) for seed in range(1, parts + 1)]
    leave(name, *(np.mean(pictures[engine], axis=0) for engine in ("metrolux", "cycles")))
    patches = {engine: np.array([_patches(p) for p in several]) for engine, several in pictures.items()}
    mean = {engine: values.mean(axis=0) for engine, values in patches.items()}
    bright = mean["cycles"] > floor * mean["cycles"].max()
    variance = 0
    for engine, values in patches.items():
        # Four parts of one patch say little of its noise; of all patches together they say enough.
        relative = (values[:, bright] / mean[engine][bright]).var(axis=0, ddof=1) / parts
        variance = variance + np.maximum(relative, relative.mean())
    result = Comparison(pictures["metrolux"][0], pictures["cycles"][0], mean["metrolux"][bright] / mean["cycles"][bright],
                        np.sqrt(variance))
    print(f"COMPARED {name}: {result}", flush=True)
    return result


def leave(name, *pictures):
    """Both pictures side by side in the folder of METROLUX_BLENDER_PICTURES, Metrolux on the left."""
    if not support.PICTURES:
        return
    os.makedirs(support.PICTURES, exist_ok=True)
    side_by_side = np.concatenate(pictures, axis=1)
    support._exr().write(os.path.join(support.PICTURES, name + ".exr"), side_by_side.astype(np.float32))
    height, width, _ = side_by_side.shape
    image = bpy.data.images.new(name, width, height)
    shown = np.clip(side_by_side, 0, 1)
    shown = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    pixels = np.concatenate([shown, np.ones((height, width, 1))], axis=2)[::-1].astype(np.float32)
    image.pixels.foreach_set(pixels.reshape(-1))
    image.filepath_raw, image.file_format = os.path.join(support.PICTURES, name + ".png"), "PNG"
    image.save()
    bpy.data.images.remove(image)


def checked(test, result, bound=0.01):
    """Fails where a patch differs by more than the bound, or where noise would hide that."""
    test.assertLess(3 * result.noise.max(), bound, f"too noisy to see {100 * bound:g} %: {result}")
    test.assertLess(result.worst, bound, str(result))


def degrees(value):
    return math.radians(value)
