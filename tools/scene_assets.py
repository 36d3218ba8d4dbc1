#!/usr/bin/env python3
"""Writes the meshes and images of the scenes in scenes/; needs nothing but Python 3.

Usage: tools/scene_assets.py [FOLDER]     (default: the folder scenes/ next to tools/)

The files are committed: run this only after a change. The output is the same on every machine.
"""

import math
import pathlib
import struct
import sys
import zlib


# Files

def write_ply(path, vertices, faces):
    """A binary mesh; a vertex is (x, y, z, nx, ny, nz, u, v), a face three indices."""
    names = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    data = bytearray("\n".join(header).encode())
    for vertex in vertices:
        data += struct.pack("<8f", *vertex)
    for face in faces:
        data += struct.pack("<B3i", 3, *face)
    path.write_bytes(data)


def write_png(path, width, height, pixel):
    """An 8-bit image, gray or RGB; pixel(x, y) gives codes from 0 to 1."""
    first = pixel(0, 0)
    channels = len(first)
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            rows += bytes(min(255, max(0, round(255 * v))) for v in pixel(x, y))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
                     + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b""))


def write_hdr(path, width, height, pixel):
    """A Radiance image (shared exponent, not run-length encoded); pixel(x, y) gives linear RGB."""
    data = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
    for y in range(height):
        for x in range(width):
            rgb = pixel(x, y)
            mantissa, exponent = math.frexp(max(rgb))
            scale = math.ldexp(256, -exponent) if mantissa else 0
            data += bytes(min(255, int(v * scale)) for v in rgb) + bytes([exponent + 128 if mantissa else 0])
    path.write_bytes(data)


# Meshes

def catmull_rom(points, steps):
    """A smooth curve through the points."""
    p = [points[0]] + list(points) + [points[-1]]
    curve = []
    for i in range(1, len(p) - 2):
        for s in range(steps):
            t = s / steps
            curve.append(tuple(
                0.5 * (2 * p[i][k] + (p[i + 1][k] - p[i - 1][k]) * t
                       + (2 * p[i - 1][k] - 5 * p[i][k] + 4 * p[i + 1][k] - p[i + 2][k]) * t * t
                       + (3 * p[i][k] - p[i - 1][k] - 3 * p[i + 1][k] + p[i + 2][k]) * t ** 3)
                for k in range(2)))
    curve.append(tuple(points[-1]))
    return [(max(r, 0.0), y) for r, y in curve]


def revolution(profile, segments=64):
    """The profile of (radius, height), which turns around the y axis; outside is to the right of its course."""
    rows = len(profile)
    vertices, faces = [], []
    for i, (r, y) in enumerate(profile):
        before, after = profile[max(i - 1, 0)], profile[min(i + 1, rows - 1)]
        dr, dy = after[0] - before[0], after[1] - before[1]
        if r == 0:
            dr, dy = math.copysign(1, dr), 0  # smooth at the axis
        length = math.hypot(dr, dy)
        for j in range(segments + 1):
            angle = 2 * math.pi * j / segments
            c, s = math.cos(angle), math.sin(angle)
            nr, ny = dy / length, -dr / length
            vertices.append((r * c, y, r * s, nr * c, ny, nr * s, j / segments, i / (rows - 1)))
    for i in range(rows - 1):
        for j in range(segments):
            a, b = i * (segments + 1) + j, (i + 1) * (segments + 1) + j
            if profile[i][0] > 0:
                faces.append((a, b, a + 1))
            if profile[i + 1][0] > 0:
                faces.append((a + 1, b, b + 1))
    return vertices, faces


def height_field(width, depth, columns, rows, height):
    """y = height(x, z) over a rectangle around the origin; normals point up."""
    vertices, faces = [], []
    e = 1e-4
    for i in range(rows + 1):
        for j in range(columns + 1):
            x, z = width * (j / columns - 0.5), depth * (i / rows - 0.5)
            dx = (height(x + e, z) - height(x - e, z)) / (2 * e)
            dz = (height(x, z + e) - height(x, z - e)) / (2 * e)
            n = math.sqrt(1 + dx * dx + dz * dz)
            vertices.append((x, height(x, z), z, -dx / n, 1 / n, -dz / n, j / columns, i / rows))
    for i in range(rows):
        for j in range(columns):
            a, b = i * (columns + 1) + j, (i + 1) * (columns + 1) + j
            faces += [(a, b, a + 1), (a + 1, b, b + 1)]
    return vertices, faces


def shell(outer, thickness, floor):
    """A closed profile: up the outer curve, over the lip and down the inner side."""
    inner = []
    for i, (r, y) in enumerate(outer):
        before, after = outer[max(i - 1, 0)], outer[min(i + 1, len(outer) - 1)]
        dr, dy = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dy)
        x, h = r - thickness * dy / length, y + thickness * dr / length
        if x > 0 and h > floor:
            inner.append((x, h))
    top_out, top_in = outer[-1], inner[-1]
    lip = ((top_out[0] + top_in[0]) / 2, max(top_out[1], top_in[1]) + thickness / 2)
    return outer + [lip] + inner[::-1] + [(0.0, inner[0][1])]


def vase():
    outer = [(0.0, 0.0)] + catmull_rom(
        [(0.055, 0.0), (0.085, 0.04), (0.105, 0.12), (0.08, 0.21), (0.045, 0.28), (0.06, 0.34)], 8)
    return revolution(shell(outer, 0.008, 0.012))


def bowl():
    outer = [(0.0, 0.0)] + catmull_rom([(0.06, 0.0), (0.13, 0.035), (0.175, 0.09), (0.185, 0.13)], 8)
    return revolution(shell(outer, 0.007, 0.006))


def chess_queen():
    """A turned figure with sharp and soft moldings, one unit high."""
    profile = [(0.0, 0.0)] + catmull_rom(
        [(0.26, 0.0), (0.29, 0.03), (0.27, 0.09), (0.2, 0.13), (0.21, 0.17), (0.13, 0.23), (0.1, 0.38),
         (0.085, 0.6), (0.09, 0.65), (0.17, 0.67), (0.17, 0.7), (0.1, 0.73), (0.12, 0.78), (0.185, 0.9),
         (0.16, 0.93), (0.06, 0.94), (0.05, 0.96), (0.04, 0.99), (0.0, 1.0)], 5)
    return revolution(profile, 72)


def water():
    waves = [(0.020, 3.1, 1.6, 0.3), (0.013, -4.7, 5.9, 1.7), (0.011, 7.3, 4.4, 4.0), (0.009, -6.1, -9.2, 2.2),
             (0.006, 12.4, -6.9, 0.9), (0.004, 5.2, 15.1, 3.3)]

    def height(x, z):
        return sum(a * math.sin(kx * x + kz * z + phase) for a, kx, kz, phase in waves)

    return height_field(4.2, 3.2, 128, 96, height)


def cut_stone(sides=8):
    """A brilliant cut: table above, culet below, girdle of radius 1 at height 0; flat facets."""
    def ring(radius, y, shift, count):
        angles = (2 * math.pi * (i + shift) / count for i in range(count))
        return [(radius * math.cos(a), y, radius * math.sin(a)) for a in angles]

    girdle = 2 * sides
    below, above = ring(1, 0, 0, girdle), ring(1, 0.06, 0, girdle)
    table, pavilion = ring(0.57, 0.40, 0.5, sides), ring(0.45, -0.50, 0.5, sides)
    culet = (0.0, -0.88, 0.0)
    facets = []
    for i in range(girdle):
        j = (i + 1) % girdle
        facets += [(below[i], above[i], above[j]), (below[i], above[j], below[j])]
    for i in range(sides):
        j = (i + 1) % sides
        a, b, c = 2 * i, 2 * i + 1, (2 * i + 2) % girdle
        facets += [(above[a], table[i], above[b]), (above[b], table[i], above[c]), (above[c], table[i], table[j])]
        facets += [(below[a], below[b], pavilion[i]), (below[b], below[c], pavilion[i])]
        facets += [(below[c], pavilion[j], pavilion[i]), (pavilion[i], pavilion[j], culet)]
        if 0 < i < sides - 1:
            facets.append((table[0], table[i], table[j]))

    vertices, faces = [], []
    for p, q, r in facets:
        u, v = [b - a for a, b in zip(p, q)], [b - a for a, b in zip(p, r)]
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        outward = sum(n * (a + b + c) / 3 for n, a, b, c in zip(normal, p, q, r))
        inside = normal[1] * -0.1  # a point on the axis that every facet faces away from
        corners = (p, q, r) if outward > inside else (p, r, q)
        size = math.sqrt(sum(n * n for n in normal)) * (1 if outward > inside else -1)
        faces.append(tuple(len(vertices) + k for k in range(3)))
        vertices += [(*corner, *(n / size for n in normal), 0.0, 0.0) for corner in corners]
    return vertices, faces


def prism(index):
    """An equilateral prism on the ground, sides of length 1, turned so that light along +x whose index is this one
    goes through with the least deviation, through the middle of its faces."""
    incidence = math.asin(index * math.sin(math.radians(30)))
    turn = incidence - math.radians(30)
    corners = [(math.cos(angle - turn) / math.sqrt(3), math.sin(angle - turn) / math.sqrt(3))
               for angle in (math.radians(90), math.radians(210), math.radians(330))]
    # The light enters between the first and the second corner, at z = 0.
    shift = sum(z for _, z in corners[:2]) / 2
    corners = [(x, z - shift) for x, z in corners]
    vertices, faces = [], []

    def facet(points, normal):
        first = len(vertices)
        vertices.extend((*p, *normal, 0.0, 0.0) for p in points)
        faces.extend((first, first + k, first + k + 1) for k in range(1, len(points) - 1))

    height = 1.0
    for k, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1])):
        middle = math.radians(150 + 120 * k) - turn
        facet([(a[0], 0, a[1]), (b[0], 0, b[1]), (b[0], height, b[1]), (a[0], height, a[1])],
              (math.cos(middle), 0, math.sin(middle)))
    facet([(x, height, z) for x, z in corners], (0, 1, 0))
    facet([(x, 0, z) for x, z in reversed(corners)], (0, -1, 0))
    return vertices, faces


def leaf_mesh():
    return height_field(1, 1, 12, 12, lambda x, z: 0.16 * (0.5 - x * x * 1.6 - abs(z) * 0.5))


# Images

def sky(width, height):
    """A clear sky in the afternoon with a sun of about 5 degrees; y is up, the map is in Mitsuba's layout."""
    sun = (0.52, 0.62, 0.59)
    length = math.sqrt(sum(v * v for v in sun))
    sun = tuple(v / length for v in sun)

    def pixel(x, y):
        theta = math.pi * (y + 0.5) / height
        phi = 2 * math.pi * (x + 0.5) / width
        d = (math.sin(phi) * math.sin(theta), math.cos(theta), -math.cos(phi) * math.sin(theta))
        cos_sun = sum(a * b for a, b in zip(d, sun))
        up = max(d[1], 0.0)
        if d[1] < 0:
            base = (0.30, 0.29, 0.28)
        else:
            t = (1 - up) ** 3
            base = tuple(a + (b - a) * t for a, b in zip((0.10, 0.22, 0.52), (0.55, 0.62, 0.70)))
        glow = 0.9 * max(cos_sun, 0.0) ** 40 + 0.15 * max(cos_sun, 0.0) ** 4
        if d[1] < 0:
            glow = 0
        disk = 560.0 if cos_sun > math.cos(math.radians(2.6)) else 0.0
        return tuple(b + glow * g + disk * s
                     for b, g, s in zip(base, (1.0, 0.85, 0.6), (1.0, 0.86, 0.66)))

    return pixel


def noise(x, y, period):
    """Smooth periodic noise from -1 to 1 on a lattice; the values come from a small integer hash."""
    def lattice(i, j):
        h = ((i % period) * 374761393 + (j % period) * 668265263 + period * 2246822519) & 0xFFFFFFFF
        h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
        return ((h ^ (h >> 16)) & 0xFFFF) / 32767.5 - 1

    i, j = math.floor(x), math.floor(y)
    fx, fy = x - i, y - j
    sx, sy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
    top = lattice(i, j) * (1 - sx) + lattice(i + 1, j) * sx
    bottom = lattice(i, j + 1) * (1 - sx) + lattice(i + 1, j + 1) * sx
    return top * (1 - sy) + bottom * sy


def wood(size):
    """Planks with a grain along x."""
    def pixel(x, y):
        u, v = x / size, y / size
        plank = int(v * 4)
        shift = (0.37 * plank) % 1
        edge = min((v * 4) % 1, 1 - (v * 4) % 1) < 0.025 or abs((u + shift) % 1 - 0.5) < 0.004
        grain = sum(noise(u * 8 * f, v * 64 * f + 7 * plank, 1024) / f for f in (1, 2, 4))
        tone = 0.82 + 0.10 * grain + 0.08 * noise(plank * 3.7, 1.3, 64)
        return tuple(c * tone * (0.45 if edge else 1) for c in (0.72, 0.52, 0.34))

    return pixel


def bricks(size, rows=6):
    """The height of a brick wall: joints low, bricks a little uneven."""
    def height(u, v):
        row = math.floor(v * rows)
        a = (u * rows / 2 + 0.5 * (row % 2)) % 1
        b = (v * rows) % 1
        edge = min(a * 2, (1 - a) * 2, b, 1 - b)
        t = min(max((edge - 0.04) / 0.08, 0), 1)
        return t * t * (3 - 2 * t) * (0.9 + 0.1 * noise(u * 16, v * 16, 16))

    def pixel(x, y):
        e = 1 / size
        u, v = x / size, 1 - (y + 0.5) / size
        dx = (height(u + e, v) - height(u - e, v)) * 4.0 / (2 * e * size) * 0.9
        dy = (height(u, v + e) - height(u, v - e)) * 4.0 / (2 * e * size) * 0.9
        n = math.sqrt(dx * dx + dy * dy + 1)
        return (0.5 - 0.5 * dx / n, 0.5 - 0.5 * dy / n, 0.5 + 0.5 / n)

    return pixel


def dents(size):
    def pixel(x, y):
        u, v = x / size, y / size
        value = 0.5 + 0.5 * math.sin(2 * math.pi * 16 * u) * math.sin(2 * math.pi * 8 * v)
        return (value,)

    return pixel


def leaf(size, mask):
    """A leaf with teeth and veins, along u; the mask or the color."""
    def pixel(x, y):
        u, v = (x + 0.5) / size, 2 * (y + 0.5) / size - 1
        width = 0.85 * math.sin(math.pi * min(max((u - 0.12) / 0.86, 0), 1)) ** 0.8
        teeth = 0.05 * abs(math.sin(28 * u - 4 * abs(v)))
        inside = abs(v) < width - teeth * (width > 0.05) or (u < 0.2 and abs(v) < 0.03)
        if mask:
            return (1.0 if inside else 0.0,)
        vein = abs(v) < 0.025 or abs(((u - 0.55 * abs(v)) * 9) % 1 - 0.5) < 0.05
        tone = 1 + 0.2 * noise(u * 12, v * 12, 64)
        color = (0.50, 0.62, 0.22) if vein else (0.24, 0.46, 0.12)
        return tuple(c * tone for c in color)

    return pixel


def main():
    scenes = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).parents[1] / "scenes"
    for name in ["door-ajar", "environment", "water-sds", "textured", "vitrine", "prism"]:
        (scenes / name).mkdir(parents=True, exist_ok=True)
    write_ply(scenes / "door-ajar/vase.ply", *vase())
    write_ply(scenes / "door-ajar/bowl.ply", *bowl())
    write_png(scenes / "door-ajar/wood.png", 256, 256, wood(256))
    write_ply(scenes / "environment/queen.ply", *chess_queen())
    write_hdr(scenes / "environment/sky.hdr", 256, 128, sky(256, 128))
    write_ply(scenes / "water-sds/water.ply", *water())
    write_ply(scenes / "vitrine/stone.ply", *cut_stone())
    write_ply(scenes / "prism/prism.ply", *prism(1.7906))
    write_ply(scenes / "textured/leaf.ply", *leaf_mesh())
    write_png(scenes / "textured/leaf.png", 256, 256, leaf(256, False))
    write_png(scenes / "textured/leaf-mask.png", 256, 256, leaf(256, True))
    write_png(scenes / "textured/bricks-normal.png", 256, 256, bricks(256))
    write_png(scenes / "textured/dents.png", 256, 128, dents(256))
    write_png(scenes / "textured/wood.png", 256, 256, wood(256))


if __name__ == "__main__":
    main()
