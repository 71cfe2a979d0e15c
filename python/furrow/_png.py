"""Grey pictures of 16 bits and colours of 8 as PNG, without another package."""
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
