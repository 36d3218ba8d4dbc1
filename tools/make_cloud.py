#!/usr/bin/env python3
"""Makes the grid of scenes/cloud: puffs of density on a flat base, eroded by value noise; one byte a cell.

usage: tools/make_cloud.py scenes/cloud/cloud.vol
"""
import random
import struct
import sys

SIZE = (48, 24, 32)  # cells along x, y, z
PUFFS = 26


def noise_grid(cells, generator):
    """Values at the corners of a lattice, for smooth noise."""
    return [generator.random() for _ in range((cells + 1) ** 3)]


def noise(grid, cells, p):
    """Trilinear interpolation of the lattice at p in [0, 1]^3, with smooth steps."""
    value = 0.0
    index, weight = [], []
    for x in p:
        scaled = min(x * cells, cells - 1e-9)
        cell, f = int(scaled), scaled % 1
        index.append(cell)
        weight.append(f * f * (3 - 2 * f))
    for corner in range(8):
        share, place = 1.0, 0
        for axis in range(3):
            bit = corner >> axis & 1
            share *= weight[axis] if bit else 1 - weight[axis]
            place = place * (cells + 1) + index[axis] + bit
        value += share * grid[place]
    return value


def main():
    generator = random.Random(7)
    puffs = [
        (0.5 + 0.28 * generator.gauss(0, 0.55), 0.28 + 0.3 * generator.random(), 0.5 + 0.2 * generator.gauss(0, 0.6),
         0.1 + 0.09 * generator.random())
        for _ in range(PUFFS)
    ]
    lattices = [(cells, noise_grid(cells, generator), share) for cells, share in ((6, 0.6), (12, 0.4))]
    stretch = (3.2, 1.5, 2.0)  # of the cloud's box: puffs are round in the world
    data = bytearray()
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                p = ((i + 0.5) / SIZE[0], (j + 0.5) / SIZE[1], (k + 0.5) / SIZE[2])
                inside = 0.0
                for x, y, z, radius in puffs:
                    d2 = sum(((a - b) * s) ** 2 for a, b, s in zip(p, (x, y, z), stretch))
                    inside = max(inside, 1 - d2 / (radius * 3) ** 2)
                erosion = sum(share * noise(grid, cells, p) for cells, grid, share in lattices)
                base = min(1.0, max(0.0, (p[1] - 0.12) / 0.1))  # the flat bottom
                edge = min(1.0, 8 * min(min(x, 1 - x) for x in p))
                density = min(1.0, max(0.0, 2.2 * (inside - 0.75 * erosion) * base * edge))
                data.append(round(255 * density))
    with open(sys.argv[1], "wb") as out:
        out.write(b"VOL" + struct.pack("<B5i6f", 3, 3, *SIZE, 1, 0, 0, 0, 1, 1, 1))
        out.write(data)


if __name__ == "__main__":
    main()
