"""Smooth bodies from signed distances: cones with round ends, blended, and a mesh of where the distance is zero."""

import numpy as np

from meshes import Mesh, unit


def cone(p, a, b, ra, rb):
    """About the distance to a cone with round ends; p is (..., 3)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    axis = b - a
    t = np.clip((p - a) @ axis / (axis @ axis), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * axis, axis=-1) - (ra + (rb - ra) * t)


def ellipsoid(p, center, radii):
    q = (p - np.asarray(center)) / np.asarray(radii)
    k = np.linalg.norm(q, axis=-1)
    gradient = np.linalg.norm(q / np.asarray(radii), axis=-1)
    return k * (k - 1) / np.maximum(gradient, 1e-9)


def blended(parts, width):
    """The union, rounded where parts meet, over this width."""
    total = parts[0]
    for part in parts[1:]:
        h = np.clip(0.5 + 0.5 * (part - total) / width, 0, 1)
        total = part * (1 - h) + total * h - width * h * (1 - h)
    return total


def surface(distance, low, high, cell):
    """The mesh of distance(p) = 0 within a box, by surface nets whose vertices are then moved onto the surface."""
    axes = [np.arange(a, b + cell, cell) for a, b in zip(low, high)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), 3)
    inside = distance(grid) < 0
    corners = sum(inside[i:inside.shape[0] - 1 + i, j:inside.shape[1] - 1 + j, k:inside.shape[2] - 1 + k].astype(int)
                  for i in (0, 1) for j in (0, 1) for k in (0, 1))
    crossed = (corners > 0) & (corners < 8)
    number = np.full(crossed.shape, -1)
    number[crossed] = np.arange(crossed.sum())
    points = grid[:-1, :-1, :-1][crossed] + cell / 2

    def gradient(p):
        e = cell / 50
        return np.stack([distance(p + e * d) - distance(p - e * d) for d in np.eye(3)], -1) / (2 * e)

    for _ in range(6):
        g = gradient(points)
        move = -0.8 * (distance(points) / np.maximum((g * g).sum(-1), 0.1))[:, None] * g
        points = points + np.clip(move, -cell / 2, cell / 2)
    faces = []
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        here, there = [slice(1, -1)] * 3, [slice(1, -1)] * 3
        here[axis], there[axis] = slice(0, -1), slice(1, None)
        first, second = inside[tuple(here)], inside[tuple(there)]
        for sign in (1, -1):
            index = np.argwhere(first & ~second if sign > 0 else second & ~first)
            index[:, b] += 1
            index[:, c] += 1
            quad = []
            for db, dc in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
                cell_index = index.copy()
                cell_index[:, b] += db
                cell_index[:, c] += dc
                quad.append(number[tuple(cell_index.T)])
            q = np.stack(quad, 1)[:, ::sign]
            faces += [q[:, [0, 1, 2]], q[:, [0, 2, 3]]]
    return Mesh(points, unit(gradient(points)), None, np.vstack(faces))


def person(arms, knees):
    """The distance of a body of 1.75 m along x, head first, chest toward -y; z is to the sides.

    `arms` are elbow, wrist and hand of one side (+z), `knees` knee, ankle and toes of both.
    """
    def distance(p):
        q = p.copy()
        q[..., 2] = np.abs(q[..., 2])
        trunk = blended([cone(q, (-0.03, 0.005, 0.075), (0.02, 0, 0.07), 0.100, 0.092),
                         cone(q, (0.02, 0, 0.05), (0.22, 0, 0.045), 0.095, 0.082),
                         cone(q, (0.22, 0, 0.05), (0.43, 0, 0.085), 0.085, 0.098),
                         cone(q, (0.50, 0.005, 0.02), (0.48, 0.005, 0.165), 0.062, 0.056),
                         cone(q, (0.50, 0, 0), (0.64, 0.01, 0), 0.058, 0.052)], 0.05)
        head = blended([ellipsoid(p, (0.745, 0.01, 0), (0.112, 0.098, 0.077)),
                        cone(p, (0.66, -0.045, 0), (0.70, -0.05, 0), 0.040, 0.040)], 0.03)
        shoulder = (0.485, 0.0, 0.175)
        arm = blended([cone(q, shoulder, arms[0], 0.050, 0.038), cone(q, arms[0], arms[1], 0.040, 0.026),
                       cone(q, arms[1], arms[2], 0.026, 0.030)], 0.02)
        legs = []
        for side, (knee, ankle, toes) in zip((1, -1), knees):
            r = p * (1, 1, side)
            legs.append(blended([cone(r, (-0.05, 0, 0.085), knee, 0.088, 0.055), cone(r, knee, ankle, 0.056, 0.034),
                                 cone(r, np.asarray(knee) * 0.75 + np.asarray(ankle) * 0.25 + (0, 0.014, 0), ankle,
                                      0.052, 0.030),
                                 cone(r, ankle, toes, 0.034, 0.026)], 0.03))
        return blended([trunk, head, arm] + legs, 0.035)

    return distance
