"""Procedural images for the scenes of the gallery, as arrays of codes from 0 to 1."""

import struct
import zlib

import numpy as np


def write_png(path, image, bits=8):
    """An image of 8 or 16 bits, gray (h x w) or RGB (h x w x 3)."""
    codes = np.round((2**bits - 1) * np.clip(image, 0, 1)).astype(">u1" if bits == 8 else ">u2")
    height, width = codes.shape[:2]
    color = codes.ndim == 3
    codes = np.ascontiguousarray(codes.reshape(height, -1)).view(np.uint8)
    if bits == 16:  # what differs from the pixel to the left compresses better
        codes = np.hstack([codes[:, :2], codes[:, 2:] - codes[:, :-2]])
    rows = np.hstack([np.full((height, 1), bits == 16, np.uint8), codes])

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, bits, 2 if color else 0, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
                   + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))


def places(width, height=None):
    """u and v of the pixels' centers, from 0 to 1; v grows downward."""
    height = height or width
    return np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)


def noise(u, v, period, seed=0):
    """Smooth noise from -1 to 1 with `period` (a number, or two) cells over the unit square, which it tiles."""
    nx, ny = (period, period) if np.isscalar(period) else period
    lattice = np.random.default_rng(seed).uniform(-1, 1, (ny, nx))
    x, y = u * nx, v * ny
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = x - i, y - j
    fx, fy = (f**3 * (f * (6 * f - 15) + 10) for f in (fx, fy))
    def at(a, b):
        return lattice[b % ny, a % nx]
    return ((at(i, j) * (1 - fx) + at(i + 1, j) * fx) * (1 - fy)
            + (at(i, j + 1) * (1 - fx) + at(i + 1, j + 1) * fx) * fy)


def fractal(u, v, period, octaves=5, seed=0, fall=0.5):
    """Noise of several scales, about from -1 to 1."""
    nx, ny = (period, period) if np.isscalar(period) else period
    total = sum(fall**k * noise(u, v, (nx * 2**k, ny * 2**k), seed + 31 * k) for k in range(octaves))
    return total / sum(fall**k for k in range(octaves)) * 1.6


def step(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mixed(a, b, t):
    """Colors a and b, blended by the array t."""
    t = t[..., None]
    return np.asarray(a) * (1 - t) + np.asarray(b) * t
