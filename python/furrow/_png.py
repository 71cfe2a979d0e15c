"""Grey pictures of 16 bits and colours of 8 as PNG, without another package."""
import pathlib
import struct
import zlib

import numpy as np


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def grey16(picture: "np.ndarray") -> bytes:
    """`picture`: rows x columns of whole numbers 0 .. 65535, the upper row first."""
    rows = np.ascontiguousarray(picture, dtype=">u2")
    lines = np.zeros((rows.shape[0], 1 + 2 * rows.shape[1]), np.uint8)
    lines[:, 1:] = rows.view(np.uint8)
    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(lines.tobytes(), 4)) + _chunk(b"IEND", b"")


def colours(picture: "np.ndarray") -> bytes:
    """`picture`: rows x columns x 3 of whole numbers 0 .. 255 (sRGB), the upper row first."""
    rows = np.ascontiguousarray(picture, dtype=np.uint8)
    lines = np.zeros((rows.shape[0], 1 + 3 * rows.shape[1]), np.uint8)
    lines[:, 1:] = rows.reshape(rows.shape[0], -1)
    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(lines.tobytes(), 4)) + _chunk(b"IEND", b"")


def read(path: "pathlib.Path") -> "np.ndarray":
    """Colours of 8 bits, rows x columns x 3, the upper row first: of a PNG as the drive writes it. ValueError: it is another."""
    data, at, packed, form = path.read_bytes(), 8, b"", (0, 0, 0, 0)
    while at + 12 <= len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        form = struct.unpack(">IIBB", chunk[:10]) if kind == b"IHDR" else form
        packed += chunk if kind == b"IDAT" else b""
        at += 12 + length
    width, height, bits, colour = form
    if (bits, colour) != (8, 2):
        raise ValueError(f"{path}: it has no colours of 8 bits")
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 3 * width + 1)
    if not set(rows[:, 0]) <= {0, 1}:
        raise ValueError(f"{path}: another program wrote it")
    pixels = rows[:, 1:].reshape(height, width, 3)
    return np.where(rows[:, :1, None] == 1, np.cumsum(pixels.astype(np.uint32), axis=1).astype(np.uint8), pixels)
