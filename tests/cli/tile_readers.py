"""Second readers of what `furrow export --tiles` writes, made from the formats' specifications alone."""
import math
import struct
import zlib

import numpy


def png(data):
    """(width, height, kind, rows): 8-bit PNGs, colour type `kind`, as an array of height x width x channels; and PLTE, tRNS."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, parts = 8, b"", {}
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + body), "a chunk's sum"
        if kind == b"IDAT":
            packed += body
        else:
            parts[kind] = body
        at += 12 + size
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", parts[b"IHDR"])
    assert depth == 8 and interlaced == 0 and b"IEND" in parts
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    raw = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, 1 + width * channels)
    rows = numpy.zeros((height, width, channels), numpy.uint8)
    above = numpy.zeros((width, channels), numpy.uint8)
    for y in range(height):
        line = raw[y, 1:].reshape(width, channels)
        if raw[y, 0] == 0:
            rows[y] = line
        elif raw[y, 0] == 1:  # difference to the left: a running sum
            rows[y] = numpy.cumsum(line, axis=0, dtype=numpy.uint8)
        elif raw[y, 0] == 2:  # to the one above
            rows[y] = line + above
        else:
            rows[y] = any_filter(raw[y, 0], line.tolist(), above.tolist())
        above = rows[y]
    return width, height, colour, rows, parts


def any_filter(kind, line, above):
    """A row filtered by the average of its left and upper neighbours (3), or by Paeth's choice among three (4)."""
    out = []
    for x, pixel in enumerate(line):
        left, corner = (out[x - 1], above[x - 1]) if x > 0 else ([0] * len(pixel), [0] * len(pixel))
        row = []
        for c, value in enumerate(pixel):
            a, b, d = left[c], above[x][c], corner[c]
            if kind == 3:
                guess = (a + b) // 2
            else:
                assert kind == 4
                guess = min((abs(b - d), 0, a), (abs(a - d), 1, b), (abs(a + b - 2 * d), 2, d))[2]
            row.append((value + guess) & 255)
        out.append(row)
    return out


def terrain_rgb(path):
    """Heights of a terrain-RGB tile, rows from the north, by Mapbox's formula."""
    width, height, colour, rows, _ = png(path.read_bytes())
    assert (width, height, colour) == (256, 256, 2)
    rgb = rows.astype(float)
    return -10000 + (rgb[..., 0] * 65536 + rgb[..., 1] * 256 + rgb[..., 2]) * 0.1


def palette(path):
    """Palette indices of a tile, and each pixel's (red, green, blue, alpha)."""
    width, height, colour, rows, parts = png(path.read_bytes())
    assert (width, height, colour) == (256, 256, 3)
    table = numpy.full((256, 4), 255, numpy.uint8)
    table[:, :3] = numpy.frombuffer(parts[b"PLTE"], numpy.uint8).reshape(-1, 3)
    alphas = numpy.frombuffer(parts[b"tRNS"], numpy.uint8)
    table[:len(alphas), 3] = alphas
    return rows[..., 0], table[rows[..., 0]]


def zig_zag(values):
    values = values.astype(numpy.int64)
    return (values >> 1) ^ -(values & 1)


class Mesh:
    """A quantized-mesh-1.0 tile."""

    def __init__(self, data):
        numbers = struct.unpack_from("<3d2f3dd3d", data)
        self.centre, (self.minimum, self.maximum) = numpy.array(numbers[:3]), numbers[3:5]
        self.sphere, self.radius, self.horizon = numpy.array(numbers[5:8]), numbers[8], numpy.array(numbers[9:12])
        at = 88
        (count,) = struct.unpack_from("<I", data, at)
        assert count <= 65536
        coded = numpy.frombuffer(data, "<u2", 3 * count, at + 4).reshape(3, count)
        self.u, self.v, self.h = (numpy.cumsum(zig_zag(part)) for part in coded)
        at += 4 + 6 * count
        at += at % 2
        (triangles,) = struct.unpack_from("<I", data, at)
        codes = numpy.frombuffer(data, "<u2", 3 * triangles, at + 4)
        at += 4 + 6 * triangles
        highest, indices = 0, []
        for code in codes.tolist():
            indices.append(highest - code)
            highest += code == 0
        assert highest == count, "every vertex is used"
        self.triangles = numpy.array(indices).reshape(-1, 3)
        self.edges = []
        for _ in range(4):  # west, south, east, north
            (size,) = struct.unpack_from("<I", data, at)
            self.edges.append(numpy.frombuffer(data, "<u2", size, at + 4))
            at += 4 + 2 * size
        self.extensions = {}
        while at < len(data):
            kind, size = struct.unpack_from("<BI", data, at)
            self.extensions[kind] = data[at + 5:at + 5 + size]
            at += 5 + size
        assert at == len(data), "nothing is left over"
        self.heights = self.minimum + self.h * ((self.maximum - self.minimum) / 32767)

    def normals(self):
        """Unit vectors, from the extension of oct-encoded normals."""
        coded = numpy.frombuffer(self.extensions[1], numpy.uint8).reshape(-1, 2) / 255 * 2 - 1
        x, y = coded[:, 0], coded[:, 1]
        z = 1 - abs(x) - abs(y)
        folded = z < 0
        fx = numpy.where(folded, (1 - abs(y)) * numpy.where(x < 0, -1, 1), x)
        fy = numpy.where(folded, (1 - abs(x)) * numpy.where(y < 0, -1, 1), y)
        vectors = numpy.stack([fx, fy, z], axis=1)
        return vectors / numpy.linalg.norm(vectors, axis=1)[:, None]


def tile_degrees(z, x, y):
    """West, south, east, north of a tile of the geodetic tiling, y from the south."""
    side = 180 / 2 ** z
    return x * side - 180, y * side - 90, (x + 1) * side - 180, (y + 1) * side - 90


def earth_centred(longitude, latitude, height, a=6378137.0, f=1 / 298.257223563):
    longitude, latitude = numpy.radians(longitude), numpy.radians(latitude)
    radius = a / numpy.sqrt(1 - f * (2 - f) * numpy.sin(latitude) ** 2)
    return numpy.stack([(radius + height) * numpy.cos(latitude) * numpy.cos(longitude),
                        (radius + height) * numpy.cos(latitude) * numpy.sin(longitude),
                        (radius * (1 - f) ** 2 + height) * numpy.sin(latitude)], axis=-1)


def mercator_bounds(z, x, y):
    """West, south, east, north in metres of EPSG:3857, y from the north."""
    half = math.pi * 6378137.0
    side = 2 * half / 2 ** z
    return x * side - half, half - (y + 1) * side, (x + 1) * side - half, half - y * side
