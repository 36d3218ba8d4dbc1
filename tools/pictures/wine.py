"""A wine glass, a decanter and its stopper on linen."""

import numpy as np

from meshes import arc, lathe, offset, sheet, spline
from textures import fractal, mixed, noise, places, write_png


def vessel(outer, inner_bottom, thickness, start):
    """The course of the glass: up the outer curve, over a round lip and down to the axis; and where the lip ends.

    The inner curve is `thickness` from the outer one from row `start` on and ends in the points `inner_bottom`.
    """
    inner = offset(outer[start:], thickness)
    tip, top = outer[-1], inner[-1]
    middle, across = (tip + top) / 2, (tip - top) / 2
    ahead = np.array([-across[1], across[0]])
    turn = np.radians(np.linspace(0, 180, 13)[1:-1])[:, None]
    lip = middle + across * np.cos(turn) + ahead * np.sin(turn)
    down = spline(np.vstack([inner[::-1][::4], inner_bottom]), 4)
    return np.vstack([outer, lip, down]), len(outer) + len(lip)


def filled(outer, inner_bottom, thickness, start, level, segments):
    """Meshes of a vessel and what is in it: glass in air, glass in wine (outside is the wine), wine in air."""
    course, inside = vessel(outer, inner_bottom, thickness, start)
    rise = 0.0014  # the wine climbs up the glass
    below = inside + int(np.argmax(course[inside:, 1] < level + rise))
    a, b = course[below - 1], course[below]
    edge = a + (b - a) * (a[1] - level - rise) / (a[1] - b[1])
    distance = np.concatenate([[0], np.geomspace(2e-4, edge[0], 28)])
    surface = np.stack([edge[0] - distance, level + rise * np.exp(-distance / 0.0012)], 1)
    surface[0], surface[-1] = edge, (0, level)
    return (lathe(np.vstack([course[:below], [edge]]), segments), lathe(np.vstack([[edge], course[below:]]), segments),
            lathe(surface, segments))


def glass():
    foot = np.vstack([spline([(0, 0.0016), (0.016, 0.0014), (0.030, 0.0006), (0.0362, 0.0001)], 4)[:-1],
                      arc((0.0366, 0.0011), 0.0011, -90, 70, 8)])
    body = spline([(0.0366 + 0.0011 * np.cos(np.radians(70)), 0.0011 + 0.0011 * np.sin(np.radians(70))),
                   (0.030, 0.0034), (0.019, 0.0058), (0.0095, 0.0098), (0.0054, 0.0170), (0.0041, 0.030),
                   (0.0036, 0.055), (0.0039, 0.078), (0.0056, 0.0905), (0.0110, 0.0990), (0.0225, 0.1080),
                   (0.0345, 0.1195), (0.0427, 0.1350), (0.0459, 0.1520), (0.0456, 0.1700), (0.0424, 0.1950),
                   (0.0382, 0.2150), (0.0356, 0.2260)], 6)
    outer = np.vstack([foot[:-1], body])
    bottom = [(0.0150, 0.1068), (0.0078, 0.1049), (0.0, 0.1043)]
    return filled(outer, bottom, 0.0011, len(foot) - 1 + 62, 0.1520, 128)


def decanter():
    base = spline([(0, 0.0075), (0.030, 0.0060), (0.060, 0.0024), (0.080, 0.0002), (0.092, 0.0012)], 5)[:-1]
    body = spline([(0.092, 0.0012), (0.0995, 0.0060), (0.1025, 0.0160), (0.1010, 0.0340), (0.0930, 0.0560),
                   (0.0770, 0.0820), (0.0540, 0.1080), (0.0350, 0.1330), (0.0245, 0.1600), (0.0210, 0.1900),
                   (0.0218, 0.2180), (0.0262, 0.2420), (0.0335, 0.2580)], 7)
    outer = np.vstack([base, body])
    bottom = [(0.088, 0.0052), (0.078, 0.0036), (0.058, 0.0058), (0.030, 0.0094), (0.0, 0.0110)]
    return filled(outer, bottom, 0.0026, len(base) + 9, 0.0560, 144)


def stopper():
    """Of glass, lying on its side."""
    ball = arc((0, 0.046), 0.021, 90, -66, 40)[::-1]
    neck = spline([(0.0118, 0.0), (0.0124, 0.001), (0.0132, 0.012), (0.0138, 0.0225), (0.0118, 0.0248),
                   ball[0]], 6)
    course = np.vstack([[(0, -0.0008)], neck, ball[1:]])
    return lathe(course, 96)


def linen():
    """A cloth that was folded to squares and is not quite flat."""
    def position(u, v):
        x, z = 2.4 * (u - 0.5), -2.0 * (v - 0.62)
        y = 0.0050 * fractal(u % 1, v % 1, 9, 3, 5) + 0.0040 * fractal((u + 0.7 * v) % 1, (v - 0.3 * u) % 1, (16, 5), 2, 9)
        for across, height in ((x + 0.255, 1.0), (x - 0.215, -0.8), (z + 0.20, 0.9), (z - 0.27, 0.8)):
            y = y + 0.0032 * height * np.exp(-np.abs(across) / 0.012)
        # the cloth is flat below what stands on it
        for cx, cz, radius in ((0.115, 0.03, 0.04), (-0.10, -0.07, 0.10), (-0.19, 0.13, 0.01), (-0.055, 0.20, 0.01)):
            far = np.clip((np.hypot(x - cx, z - cz) - radius) / 0.09, 0, 1)
            y = y * far * far * (3 - 2 * far)
        return x, y - 0.0002, z

    return sheet(position, 160, 130)


def weave(size, threads):
    """Heights and colors of a plain weave whose threads are uneven."""
    u, v = places(size)
    warp, weft = u * threads, v * threads
    i, j = np.floor(warp), np.floor(weft)
    over = (i + j) % 2
    thick = 0.85 + 0.15 * noise(u, v, (threads, 4), 3), 0.85 + 0.15 * noise(u, v, (4, threads), 4)
    a = np.abs(np.sin(np.pi * warp)) * (0.55 + 0.45 * np.where(over > 0, 1, -1) * np.abs(np.sin(np.pi * weft))) * thick[0]
    b = np.abs(np.sin(np.pi * weft)) * (0.55 + 0.45 * np.where(over > 0, -1, 1) * np.abs(np.sin(np.pi * warp))) * thick[1]
    height = np.maximum(a, b) + 0.05 * noise(u, v, threads * 4, 8)
    tone = 0.88 + 0.10 * height + 0.05 * np.where(a > b, noise(u, v, (threads, 6), 11), noise(u, v, (6, threads), 12))
    return height, tone[..., None] * np.array([0.93, 0.91, 0.87])


def cork():
    profile = np.vstack([[(0, 0)], arc((0.0107, 0.0010), 0.0010, -90, 0, 4), arc((0.0107, 0.0430), 0.0010, 0, 90, 4),
                         [(0, 0.0440)]])
    return lathe(profile, 64)


def cork_bark(size):
    u, v = places(size)
    grain = fractal(u, v, (24, 24), 4, 21)
    pores = np.clip(fractal(u, v, (14, 40), 2, 22) - 0.55, 0, 1) * 3
    color = mixed((0.80, 0.64, 0.44), (0.66, 0.47, 0.29), np.clip(0.5 + 0.6 * grain, 0, 1))
    return mixed(color, (0.30, 0.18, 0.10), np.clip(pores, 0, 1))


def write(folder):
    for name, meshes in (("glass", glass()), ("decanter", decanter())):
        for part, mesh in zip(("", "-wall", "-wine"), meshes):
            mesh.write(folder / f"{name}{part}.ply.gz")
    stopper().write(folder / "stopper.ply.gz")
    cork().write(folder / "cork.ply.gz", uv=True)
    linen().write(folder / "linen.ply.gz", uv=True, normals=False)
    height, color = weave(256, 16)
    write_png(folder / "weave.png", color)
    write_png(folder / "weave-height.png", height)
    write_png(folder / "cork.png", cork_bark(128))
