"""A surface as the sum of lobes, what it lets through and what it emits; from it, a BSDF of Mitsuba."""

from dataclasses import dataclass, field
from typing import Callable

import numpy as np

from .values import BLACK, MeshColor, WHITE, add, combine, constant, multiply
from .xml import plugin


@dataclass
class Lobe:
    """`make(color, writer)` gives its BSDF. Its color is a factor of all it scatters unless `is_linear` is false."""

    weight: object
    color: object
    make: Callable
    is_transmissive: bool = False
    is_linear: bool = True


@dataclass
class Surface:
    """Weights are Values: of the lobes, and of what goes straight through; the emission is a radiance."""

    lobes: list = field(default_factory=list)
    transparency: object = BLACK
    emission: object = BLACK

    @property
    def is_opaque(self):
        return self.transparency == BLACK and not any(lobe.is_transmissive for lobe in self.lobes)

    def scaled(self, weight):
        if weight == WHITE:
            return self
        lobes = [Lobe(multiply(l.weight, weight), l.color, l.make, l.is_transmissive, l.is_linear) for l in self.lobes]
        lobes = [l for l in lobes if l.weight != BLACK]
        return Surface(lobes, multiply(self.transparency, weight), multiply(self.emission, weight))

    def plus(self, other):
        return Surface(
            self.lobes + other.lobes, add(self.transparency, other.transparency), add(self.emission, other.emission)
        )


def _diffuse(color, writer):
    return plugin("bsdf", "diffuse", reflectance=writer.color(color))


def diffuse(color):
    """A surface that is diffuse and nothing else."""
    return Surface([Lobe(WHITE, color, _diffuse)])


def _share(weight, total):
    """The part of a weight in a total, 0 where there is nothing."""
    return combine(lambda w, t: np.clip(w / np.where(t > 0, t, 1), 0, 1), weight, total)


def _peak(color):
    """The largest channel of a color anywhere; of colors of the mesh, which are not known here, 1."""
    return 1.0 if isinstance(color, MeshColor) else max(float(color.array().max()), 1e-6)


def _limited(color, problem):
    def clip(x):
        if np.any(x > 1 + 1e-4):
            problem("reflects more than arrives (an Add Shader, or a color above 1); colors are cut at 1")
        return np.minimum(x, 1)

    return color if isinstance(color, MeshColor) else combine(clip, color)


def _normalized(lobes, solid, problem):
    """Lobes whose weights sum to one: the rest of the sum goes into their colors."""
    weights = [_share(lobe.weight, solid) for lobe in lobes] if solid != WHITE else [lobe.weight for lobe in lobes]
    total = weights[0]
    for weight in weights[1:]:
        total = add(total, weight)
    if total == WHITE or (total.is_constant and abs(total.scalar - 1) < 1e-6):
        return [(weight, lobe.color, lobe) for weight, lobe in zip(weights, lobes)]
    if all(lobe.is_linear for lobe in lobes):
        # Each lobe gets the share that its brightest color needs; exact as long as these fit into 1 together.
        peaks = [_peak(lobe.color) for lobe in lobes]
        needs = [multiply(weight, constant(peak)) for weight, peak in zip(weights, peaks)]
        total = needs[0]
        for need in needs[1:]:
            total = add(total, need)
        return [
            (_share(need, total), _limited(multiply(lobe.color, multiply(total, constant(1 / peak))), problem), lobe)
            for need, peak, lobe in zip(needs, peaks, lobes)
        ]
    # A Principled BSDF has no single color to scale: what is missing of one is black.
    if total.is_constant and total.scalar > 1:
        problem("an Add Shader sums surfaces of which one cannot be scaled; their mean is taken")
        return [(_share(weight, total), lobe.color, lobe) for weight, lobe in zip(weights, lobes)]
    rest = Lobe(combine(lambda t: np.clip(1 - t, 0, 1), total), BLACK, _diffuse)
    return [(w, lobe.color, lobe) for w, lobe in zip(weights + [rest.weight], lobes + [rest])]


def bsdf_of(surface, writer, problem):
    """The <bsdf> of a surface; `writer` writes values, `problem` takes messages."""
    opacity = combine(lambda t: np.clip(1 - t, 0, 1), surface.transparency)
    if opacity == BLACK:
        return plugin("bsdf", "null")
    lobes = surface.lobes or [Lobe(opacity, BLACK, _diffuse)]
    parts = _normalized(lobes, opacity, problem)
    two_sided = not any(lobe.is_transmissive for _, _, lobe in parts)

    def element(color, lobe):
        made = lobe.make(color, writer)
        if two_sided or lobe.is_transmissive:
            return made
        outer = plugin("bsdf", "twosided")
        outer.append(made)
        return outer

    weight, color, lobe = parts[0]
    result, total = element(color, lobe), weight
    for weight, color, lobe in parts[1:]:
        total = add(total, weight)
        blend = plugin("bsdf", "blendbsdf", weight=writer.scalar(_share(weight, total)))
        blend.append(result)
        blend.append(element(color, lobe))
        result = blend
    if two_sided:
        inner, result = result, plugin("bsdf", "twosided")
        result.append(inner)
    if opacity != WHITE:
        inner, result = result, plugin("bsdf", "mask", opacity=writer.scalar(opacity))
        result.append(inner)
    return result

