"""OpenEXR files as numpy arrays: what Metrolux writes is read, and baked textures and skies are written.

Blender's Python can load such a file only as a data-block of the open document, which a render must not change. Scan
lines, channels of 16 or 32 bits, without compression or with ZIP: https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

import struct
import zlib

import numpy as np

_MAGIC = b"\x76\x2f\x31\x01"
_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_ROWS = {0: 1, 2: 1, 3: 16}  # scan lines in a block, by compression: none, ZIPS, ZIP


def _header(data, path):
    if data[:4] != _MAGIC:
        raise ValueError(f"{path}: found no OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        start = type_end + 5
        attributes[data[at:name_end].decode()] = data[start : start + size]
        at = start + size
    return attributes, at + 1


def _channels(blob):
    channels, at = [], 0
    while blob[at]:
        end = blob.index(b"\0", at)
        (kind,) = struct.unpack_from("<i", blob, end + 1)
        channels.append((blob[at:end].decode(), _TYPES[kind]))
        at = end + 17
    return channels


def _unzip(block, size):
    """A block's bytes: inflated, the differences summed, the two halves interleaved."""
    if len(block) == size:
        return block
    steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.uint8)
    steps[1:] -= 128
    values = np.cumsum(steps, dtype=np.uint8)
    result = np.empty(size, np.uint8)
    result[0::2] = values[: (size + 1) // 2]
    result[1::2] = values[(size + 1) // 2 :]
    return result.tobytes()


def read(path):
    """The data window (x, y, width, height) and the channels by name, float32 of shape (height, width), top row first."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = _header(data, path)
    compression = attributes["compression"][0]
    if compression not in _ROWS or "tiles" in attributes:
        raise ValueError(f"{path}: found compression {compression} or tiles, expected scan lines with ZIP or none")
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(attributes["channels"])
    row_size = width * sum(kind.itemsize for _, kind in channels)
    result = {name: np.empty((height, width), np.float32) for name, _ in channels}
    rows = _ROWS[compression]
    blocks = (height + rows - 1) // rows
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(rows, y1 + 1 - y)
        block = data[offset + 8 : offset + 8 + size]
        if compression:
            block = _unzip(block, lines * row_size)
        cursor = 0
        for line in range(y - y0, y - y0 + lines):
            for name, kind in channels:
                result[name][line] = np.frombuffer(block, kind, width, cursor)
                cursor += width * kind.itemsize
    return (x0, y0, width, height), result


def write(path, pixels, half=False):
    """Writes RGB pixels, shape (height, width, 3), top row first, with ZIP; `half`: 16 bits a channel."""
    height, width, _ = pixels.shape
    kind = np.dtype("<f2") if half else np.dtype("<f4")
    pixels = np.clip(pixels, -65504, 65504) if half else pixels
    channels = b"".join(
        name + b"\0" + struct.pack("<iB3xii", 1 if half else 2, 0, 1, 1) for name in (b"B", b"G", b"R")
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        (b"channels", b"chlist", channels + b"\0"),
        (b"compression", b"compression", b"\x03"),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]
    header = _MAGIC + struct.pack("<i", 2)
    for name, type_name, value in attributes:
        header += name + b"\0" + type_name + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    # A scan line has all of B, then G, then R.
    planes = np.ascontiguousarray(pixels[:, :, ::-1].transpose(0, 2, 1)).astype(kind)
    blocks = []
    for y in range(0, height, 16):
        raw = np.frombuffer(planes[y : y + 16].tobytes(), np.uint8)
        halves = np.concatenate([raw[0::2], raw[1::2]])
        steps = halves.copy()
        steps[1:] = halves[1:] - halves[:-1] + np.uint8(128)
        packed = zlib.compress(steps.tobytes(), 4)
        block = packed if len(packed) < raw.size else raw.tobytes()
        blocks.append(struct.pack("<ii", y, len(block)) + block)
    offsets, at = [], len(header) + 8 * len(blocks)
    for block in blocks:
        offsets.append(at)
        at += len(block)
    with open(path, "wb") as file:
        file.write(header)
        file.write(struct.pack(f"<{len(offsets)}Q", *offsets))
        file.writelines(blocks)
