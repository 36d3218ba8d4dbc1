"""A pool at noon, seen from above."""

import numpy as np

from bodies import person, surface
from meshes import Mesh, ball, joined, lathe, rounded_box, spline, tube, unit
from textures import fractal, mixed, noise, places, step, write_png

WATER = (8.6, 6.4)  # its extent in x and z, around the origin


def waves(width, height):
    """Heights of the water in meters: ripples from all sides, whose curvature focuses the sun about 1.4 m below."""
    u, v = places(width, height)
    x, z = WATER[0] * (u - 0.5), WATER[1] * (v - 0.5)
    random = np.random.default_rng(7)
    total = 0
    for k in range(70):
        length = 0.24 * (1.3 / 0.24) ** random.beta(1.1, 1.6)
        angle = random.normal(0.6, 1.0) + np.pi * (random.random() < 0.3)
        steep = 0.0260 * random.uniform(0.5, 1.2) * (length / 0.6) ** 0.15
        wave = 2 * np.pi / length
        phase = wave * (np.cos(angle) * x + np.sin(angle) * z) + random.uniform(0, 2 * np.pi)
        fading = 0.75 + 0.5 * noise(u, v, 3, 100 + k)
        total = total + fading * steep / wave * np.sin(phase + 0.5 * noise(u, v, 5, 300 + k))
    for cx, cz, strength in ((1.55, -0.75, 0.010), (-1.15, 1.05, 0.008)):  # rings around those who float
        r = np.hypot(x - cx, z - cz)
        total = total + strength * np.sin(2 * np.pi * r / 0.42) / (1 + 3 * r) * step(0.3, 0.9, r) * 0.6
    return total


def mosaic(size, tiles, palette, seed):
    """Small tiles, each of its own color, and light joints."""
    u, v = places(size)
    random = np.random.default_rng(seed)
    colors = np.array(palette)[random.choice(len(palette), (tiles, tiles))]
    colors = colors * random.uniform(0.86, 1.10, (tiles, tiles, 1))
    i, j = (u * tiles).astype(int), (v * tiles).astype(int)
    edge = np.minimum(np.minimum((u * tiles) % 1, 1 - (u * tiles) % 1), np.minimum((v * tiles) % 1, 1 - (v * tiles) % 1))
    return mixed((0.86, 0.90, 0.88), colors[j, i], step(0.05, 0.10, edge))


def planks(width, height):
    """Grain along u of six planks, gray where the sun has bleached it."""
    u, v = places(width, height)
    plank = np.floor(v * 6)
    grain = fractal((u + 0.37 * plank) % 1, v, (3, 90), 3, 40) + 0.5 * fractal(u, v, (6, 180), 2, 41)
    tone = 0.5 + 0.35 * grain + 0.3 * noise(plank / 6 + 0.08, 0 * v + 0.3, 6, 42)
    color = mixed((0.50, 0.37, 0.27), (0.74, 0.60, 0.47), np.clip(tone, 0, 1))
    return mixed(color, (0.68, 0.65, 0.61), np.clip(0.35 + 0.5 * fractal(u, v, 4, 4, 43), 0, 0.7))


def stone(size):
    u, v = places(size)
    veins = fractal(u, v, (4, 18), 5, 50)
    color = mixed((0.80, 0.76, 0.68), (0.69, 0.63, 0.54), np.clip(0.5 + 0.7 * veins, 0, 1))
    pores = step(0.55, 0.75, fractal(u, v, (16, 60), 3, 51))
    return mixed(color, (0.52, 0.47, 0.40), 0.5 * pores)


def boxes(places_and_sizes, radius, steps=2, scale=1.0):
    """Round boxes (x, y, z, dx, dy, dz), whose uv are in meters, each shifted at random, divided by `scale`."""
    random = np.random.default_rng(3)
    parts = []
    for x, y, z, dx, dy, dz in places_and_sizes:
        part = rounded_box(dx, dy, dz, radius, steps).moved(x, y, z)
        part.uv = part.points[:, [0, 2]] / scale + random.integers(0, 6, 2) / 6
        parts.append(part)
    return joined(parts)


def coping():
    """Slabs of stone around the pool, which overhang the water by 3 cm."""
    slabs = []
    for k in range(-8, 9):
        slabs += [(0.62 * k, 0.095, z, 0.612, 0.05, 0.36) for z in (-3.25, 3.25)]
    for k in range(-5, 6):
        slabs += [(x, 0.095, 0.566 * k, 0.36, 0.05, 0.560) for x in (-4.35, 4.35)]
    return boxes(slabs, 0.014, scale=1.2)


def deck():
    rows = [-3.43 - 0.075 - 0.15 * k for k in range(14)]
    slabs = [(x, 0.09, z, 2.995, 0.03, 0.144) for k, z in enumerate(rows)
             for x in np.arange(-9 + 1.5 * (k % 2), 9.1, 3.0)]
    side = [-4.53 - 1.5 - 0.0 - 3.0 * k for k in range(2)]
    slabs += [(x, 0.09, z, 2.995, 0.03, 0.144) for x in side for z in np.arange(-3.43 + 0.075, 5, 0.15)]
    return boxes(slabs, 0.006, 1, 0.9)


def mattress():
    """Five tubes of air and a pillow; two meshes, for its stripes."""
    def pad(x, z, length, radius):
        profile = spline([(0, -length / 2), (0.5 * radius, -length / 2 + 0.004), (0.92 * radius, -length / 2 + 0.045),
                          (radius, -length / 2 + 0.1), (radius, 0), (radius, length / 2 - 0.1),
                          (0.92 * radius, length / 2 - 0.045), (0.5 * radius, length / 2 - 0.004), (0, length / 2)], 4)
        return lathe(profile, 24).turned(2, 90).scaled(1, 0.8, 1).moved(x, 0, z)

    stripes = [pad(-0.10, 0.145 * k, 1.55, 0.077) for k in range(-2, 3)]
    pillow = lathe(spline([(0, -0.36), (0.05, -0.355), (0.095, -0.31), (0.10, -0.2), (0.10, 0.2), (0.095, 0.31),
                           (0.05, 0.355), (0, 0.36)], 5), 28).turned(0, 90).scaled(1.1, 0.75, 1).moved(0.77, 0.035, 0)
    return joined(stripes[::2] + [pillow]), joined(stripes[1::2])


def ring():
    angle = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    return tube(np.stack([0.36 * np.cos(angle), 0 * angle, 0.36 * np.sin(angle)], 1), 0.135, 40, closed=True)


def beach_ball():
    mesh = ball(0.19, 48)
    mesh.uv[:, 1] /= np.pi * 0.19
    return mesh.turned(0, 50).turned(1, 20)


def clothed(body, parts):
    """The body with uv as seen from above, and its colors there: parts are (distance(x, z) < 0, color)."""
    low, high = body.points.min(0), body.points.max(0)
    body.uv = (body.points[:, [0, 2]] - low[[0, 2]]) / (high - low)[[0, 2]]
    u, v = places(512, 192)
    x, z = low[0] + (high[0] - low[0]) * u, low[2] + (high[2] - low[2]) * (1 - v)
    image = np.broadcast_to((0.80, 0.60, 0.49), u.shape + (3,))
    image = image * (1 + 0.05 * fractal(u, v, (12, 5), 4, 77))[..., None]
    for distance, color in parts:
        image = mixed(image, color, step(0.003, -0.003, distance(x, np.abs(z))))
    return body, image


def swimmer():
    """Gliding below the surface, arms ahead."""
    knees = [((-0.46, -0.03, 0.10), (-0.86, 0.02, 0.08), (-1.04, 0.05, 0.09)),
             ((-0.46, 0.00, 0.11), (-0.87, 0.03, 0.11), (-1.05, 0.04, 0.12))]
    body = surface(person([(0.74, 0.015, 0.195), (0.97, 0.02, 0.10), (1.13, 0.015, 0.055)], knees),
                   (-1.15, -0.18, -0.36), (1.22, 0.18, 0.36), 0.018)
    return clothed(body, [(lambda x, z: np.abs(x + 0.07) - 0.12, (0.10, 0.16, 0.42)),
                          (lambda x, z: np.hypot((x - 0.79) / 0.09, z / 0.09) * 0.09 - 0.09, (0.93, 0.93, 0.91))])


def sleeper():
    """On the mattress, face up, an arm behind the head on each side and a knee bent; +y is up."""
    knees = [((-0.47, -0.03, 0.13), (-0.88, 0.01, 0.15), (-0.95, -0.10, 0.17)),
             ((-0.40, -0.20, 0.17), (-0.66, 0.02, 0.16), (-0.82, 0.03, 0.18))]
    body = surface(person([(0.58, 0.02, 0.42), (0.80, -0.02, 0.28), (0.86, 0.0, 0.14)], knees),
                   (-1.10, -0.32, -0.52), (1.0, 0.2, 0.52), 0.018)
    low = (lambda x, z: np.maximum(np.maximum(-0.15 + 0.75 * z - x, x - 0.045), z - 0.2), (0.86, 0.25, 0.22))
    high = (lambda x, z: np.maximum(np.hypot(x - 0.36, z - 0.075) - 0.072, x - 0.41), (0.86, 0.25, 0.22))
    band = (lambda x, z: np.maximum(np.abs(x - 0.325) - 0.012, z - 0.2), (0.86, 0.25, 0.22))
    hair = (lambda x, z: np.maximum(0.785 - 0.5 * z * z / 0.01 * 0.06 - x, z - 0.1), (0.30, 0.20, 0.13))
    body, image = clothed(body, [low, high, band, hair])
    return body.turned(0, 180), image


def parasol():
    """Eight panels that sag between the ribs; white and terracotta by turns."""
    rings, around = 14, 96
    angle = 2 * np.pi * np.arange(around + 1) / around
    radius = np.linspace(0.001, 1, rings + 1)
    r, a = np.meshgrid(radius, angle, indexing="ij")
    sag = np.abs(np.sin(4 * a))
    reach = 1.35 * r * (1 - 0.05 * sag * r)
    points = np.stack([reach * np.cos(a), 2.35 - 0.42 * r**1.25 - 0.05 * sag * r * r, reach * np.sin(a)], 2)
    du, dv = np.gradient(points, axis=1), np.gradient(points, axis=0)
    i, j = np.meshgrid(np.arange(around), np.arange(rings))
    k = (j * (around + 1) + i).ravel()
    up = k + around + 1
    faces = np.vstack([np.stack([k, k + 1, up + 1], 1), np.stack([k, up + 1, up], 1)])
    uv = np.stack([a / (2 * np.pi), r], 2)
    return Mesh(points.reshape(-1, 3), unit(np.cross(du, dv)).reshape(-1, 3), uv.reshape(-1, 2), faces)


def rails():
    """The handrails of a ladder and its steps, of steel."""
    parts = []
    for x in (-0.25, 0.25):
        course = spline([(x, 0.10, -0.52), (x, 0.55, -0.50), (x, 0.78, -0.36), (x, 0.84, -0.14), (x, 0.74, 0.10),
                         (x, 0.45, 0.22), (x, 0.0, 0.24), (x, -0.6, 0.24), (x, -1.0, 0.24)], 10)
        parts.append(tube(course, 0.0195, 14))
    for y in (-0.25, -0.55, -0.85):
        parts.append(rounded_box(0.48, 0.025, 0.08, 0.01, 2).moved(0, y, 0.25))
    return joined(parts)


def write(folder):
    heights = waves(640, 480)
    write_png(folder / "water.png", 0.5 + heights / 0.24, 16)
    turquoise = [(0.52, 0.80, 0.83), (0.44, 0.74, 0.80), (0.64, 0.86, 0.86), (0.76, 0.90, 0.88), (0.36, 0.66, 0.76)]
    write_png(folder / "mosaic.png", mosaic(640, 40, turquoise, 1))
    write_png(folder / "mosaic-dark.png", mosaic(160, 10, [(0.03, 0.08, 0.25), (0.04, 0.12, 0.33), (0.02, 0.06, 0.18)], 2))
    write_png(folder / "planks.png", planks(384, 384))
    write_png(folder / "stone.png", stone(256))
    coping().write(folder / "coping.ply.gz", uv=True)
    deck().write(folder / "deck.ply.gz", uv=True)
    for name, mesh in zip(("mattress", "mattress-stripes"), mattress()):
        mesh.write(folder / f"{name}.ply.gz")
    for name, mesh in (("ring", ring()), ("ball", beach_ball()), ("parasol", parasol())):
        mesh.write(folder / f"{name}.ply.gz", uv=True)
    rails().write(folder / "rails.ply.gz")
    for name, (mesh, image) in (("swimmer", swimmer()), ("sleeper", sleeper())):
        mesh.write(folder / f"{name}.ply.gz", uv=True)
        write_png(folder / f"{name}.png", image)
    white = (0.93, 0.92, 0.90)
    write_png(folder / "ring.png", np.array([[(0.88, 0.22, 0.18)], [white]] * 4))
    write_png(folder / "parasol.png", np.array([[(0.91, 0.90, 0.86), (0.82, 0.50, 0.36)] * 4]))
    rows = [[white, (0.88, 0.28, 0.2), white, (0.97, 0.8, 0.2), white, (0.2, 0.5, 0.82)]] * 18
    write_png(folder / "ball.png", np.array([[white] * 6] + rows + [[white] * 6]))
