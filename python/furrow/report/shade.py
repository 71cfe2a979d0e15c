"""The ground of a map as a picture: its shade, and in colours by how much the drive changed its height. It is coloured as furrow map colours a map."""
import io
import math

import numpy as np
from PIL import Image

SHARE = 0.999   # part of the values that are within the legend's range
OUTLIERS = 2    # the range goes to the largest value, unless that is so many times as large
SQUARES = 3     # pixels a post, from which on a post is a square of its value
HATCH, LINE = 10, 1
# Direction and height of the sun, of two lower ones at its sides, and of the sky; and how much light each gives.
SUNS = ((0.0, 0.0, 0.52), (-65.0, 15.0, 0.17), (65.0, 15.0, 0.17), (0.0, -180.0, 0.14))
DOWN = np.array([[150, 205, 255], [55, 130, 235], [75, 50, 195], [62, 0, 105]], float)
UP = np.array([[255, 226, 140], [253, 160, 50], [222, 70, 25], [125, 0, 32]], float)
TINT = np.array([1, 0.992, 0.972])  # of paper
HOLE, HATCHED = (214, 219, 226), (150, 160, 174)


def _go_on(a: "np.ndarray", b: "np.ndarray", here: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
    """Two opposite neighbours; one that is nodata goes on as the other side does."""
    return np.where(np.isnan(a), np.where(np.isnan(b), here, 2 * here - b), a), np.where(np.isnan(b), np.where(np.isnan(a), here, 2 * here - a), b)


def light(east: "np.ndarray", north: "np.ndarray") -> "np.ndarray":
    """How light ground of a slope is; nan: nodata."""
    sum_, length = np.zeros_like(east), np.sqrt(1 + east * east + north * north)
    for turn, lower, weight in SUNS:
        azimuth, up = math.radians(315 + turn), min(max(math.radians(45 - lower), math.pi / 18), math.pi / 2)
        sum_ += np.maximum(weight * (math.sin(up) - math.cos(up) * math.sin(azimuth) * east - math.cos(up) * math.cos(azimuth) * north), 0)
    share = np.minimum(sum_ / length / 0.84, 1)  # that much comes from no slope
    return 0.04 + 0.96 * share * (0.5 + 0.5 * share)


FLAT = float(light(np.zeros(1), np.zeros(1))[0])


def slopes(heights: "np.ndarray", spacing: float) -> "tuple[np.ndarray, np.ndarray]":
    """Horn's slopes of each post, to the east and to the north. heights: m, with one more post at each side; nan: nodata."""
    here = heights[1:-1, 1:-1]
    w, e = _go_on(heights[1:-1, :-2], heights[1:-1, 2:], here)
    s, n = _go_on(heights[:-2, 1:-1], heights[2:, 1:-1], here)
    corner = {}
    for name, value, a, b in (("sw", heights[:-2, :-2], s, w), ("se", heights[:-2, 2:], s, e), ("nw", heights[2:, :-2], n, w), ("ne", heights[2:, 2:], n, e)):
        corner[name] = np.where(np.isnan(value), a + b - here, value)
    east = (corner["ne"] + 2 * e + corner["se"] - corner["nw"] - 2 * w - corner["sw"]) / (8 * spacing)
    north = (corner["nw"] + 2 * n + corner["ne"] - corner["sw"] - 2 * s - corner["se"]) / (8 * spacing)
    return np.where(np.isnan(here), np.nan, east), np.where(np.isnan(here), np.nan, north)


def _round_up(size: float) -> float:
    ten = 10.0 ** math.floor(math.log10(size) + 1e-9)
    return next(end for end in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if end * ten >= size * (1 - 1e-6)) * ten


def signed_range(values: "np.ndarray") -> "tuple[float, float]":
    """The ends of the colours, m: 0 and the largest value, or a rounder and smaller one if a few values are much larger than all others."""
    sizes = np.abs(values.astype(np.float32))
    low, high = min(0.0, float(values.min(initial=0))), max(0.0, float(values.max(initial=0)))
    sizes = sizes[sizes != 0]
    if not sizes.size:
        return 0.0, 0.0
    classes = sizes.view(np.uint32) >> 15  # classes of their size
    beyond = math.floor((1 - SHARE) * sizes.size)
    above = np.cumsum(np.bincount(classes)[::-1])
    found = int(classes.max()) - int(np.argmax(above > beyond))
    most = float(np.array([(found << 15) | 0x7fff], np.uint32).view(np.float32)[0])
    size, largest = min(most, max(-low, high)), max(-low, high)
    end = largest if largest <= OUTLIERS * size else _round_up(size)
    return (-end if low < 0 else 0.0), (end if high > 0 else 0.0)


def _ramp(values: "np.ndarray", ends: "tuple[float, float]") -> "tuple[np.ndarray, np.ndarray]":
    """The colour of a change of height, and how much of it is seen: small ones let the ground through."""
    with np.errstate(all="ignore"):
        size = np.minimum(np.abs(np.where(values < 0, values / -ends[0] if ends[0] else 0, values / ends[1] if ends[1] else 0)), 1)
    at = size * 3
    i = np.minimum(at.astype(int), 2)
    share = (at - i)[..., None]
    stops = np.where((values < 0)[..., None], DOWN[i] + share * (DOWN[i + 1] - DOWN[i]), UP[i] + share * (UP[i + 1] - UP[i]))
    return np.floor(stops + 0.5), np.floor(255 * np.minimum(1.6 * np.sqrt(size), 0.94) + 0.5) / 255


def _colours(values: "np.ndarray", shades: "np.ndarray", ends: "tuple[float, float]") -> "np.ndarray":
    over, alpha = _ramp(values, ends)
    grey = 255 * (0.28 + 0.72 * shades)
    lit = np.clip(1 + 0.7 * (shades - FLAT), 0.5, 1.12)
    return np.minimum(grey[..., None] * TINT * (1 - alpha[..., None]) + over * (lit * alpha)[..., None] + 0.5, 255)


def key(ends: "tuple[float, float]", count: int) -> "list[str]":
    """The colours of the legend, from the lowest value to the highest, as #rrggbb."""
    values = ends[0] + (ends[1] - ends[0]) * (np.arange(count) + 0.5) / count
    return ["#%02x%02x%02x" % tuple(int(c) for c in colour) for colour in _colours(values, np.full(count, FLAT), ends)]


def _enlarge(values: "np.ndarray", times: int, smooth: bool) -> "np.ndarray":
    """Each post becomes times x times pixels; interpolated between posts if `smooth`."""
    if times == 1:
        return values
    if not smooth:
        return np.repeat(np.repeat(values, times, axis=0), times, axis=1)
    for axis in range(2):
        count = values.shape[axis]
        at = (np.arange(count * times) + 0.5) / times - 0.5
        first = np.floor(at).astype(int)
        share = (at - first).reshape((-1, 1) if axis == 0 else (1, -1))
        near = np.clip(np.floor(at + 0.5).astype(int), 0, count - 1)
        a, b, here = (np.take(values, np.clip(k, 0, count - 1), axis=axis) for k in (first, first + 1, near))
        mixed = np.where(np.isnan(a), here, a) * (1 - share) + np.where(np.isnan(b), here, b) * share
        values = np.where(np.isnan(here), np.nan, mixed)
    return values


def picture(values: "np.ndarray", shades: "np.ndarray", ends: "tuple[float, float]", times: int) -> "np.ndarray":
    """Rows x columns x 3 of 0 to 255, the southern row first."""
    shades = _enlarge(shades, times, True)
    pixels = _colours(_enlarge(values, times, times < SQUARES), np.nan_to_num(shades, nan=FLAT), ends).astype(np.uint8)
    holes = np.isnan(shades)
    if holes.any():
        rows, columns = np.indices(shades.shape)
        pixels[holes] = HOLE
        pixels[holes & ((columns + shades.shape[0] - 1 - rows) % HATCH < LINE)] = HATCHED
    return pixels


def png(pixels: "np.ndarray") -> bytes:
    """A picture, the upper row first."""
    out = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels, np.uint8)).save(out, "PNG", optimize=True)
    return out.getvalue()
