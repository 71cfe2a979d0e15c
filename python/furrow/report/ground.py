"""The store that a drive left: the rut across its way, and the picture of its map. The library reads the posts; furrow info tells whose drive the store shows.

A store that cannot be read does not make the report fail: another program may be writing it.
"""
import json
import math
import os
import shutil
import subprocess
import sys
from typing import Any, Union

import numpy as np

from furrow import _stage
from furrow.report import shade
from furrow.report.forces import Body
from furrow.report.run import Run
from furrow.results import Drive, ResultsError

ALONG = 1.0       # m of way, or four posts, that give its direction
REACH = 20.0      # m to either side of the profile: ways further away are others
BESIDE = 1.0, 3.0 # m, or 16 posts, beyond the outermost way of an object; where objects may be wider, and vehicles have wheels beside their way
HALF_MOST = 2000  # samples to either side
PART = 64         # samples that are read at once
CHANGED = 0.01    # mm: less is no rut
MARGIN, SHOWN = 0.08, 2.0  # of a map: of its longer side; m around a way
POSTS_LEAST, NARROW = 64, 0.4
TILES_MOST = 2048  # tiles of offsets that are read for a map
RUT = 1e-3         # m: ground that is lowered by so much is a rut


class NoGround(Exception):
    """Why a store shows nothing, a part of a sentence."""


def command() -> "Union[str, None]":
    """The program furrow: the one that called, of this installation, or of the path."""
    beside = [os.environ.get("FURROW_PROGRAM", ""), os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "furrow"), os.path.join(os.path.dirname(sys.executable), "furrow")]
    return next((path for path in beside if os.path.isfile(path) and os.access(path, os.X_OK)), None) or shutil.which("furrow")


def ask(*words: str) -> "dict[str, Any]":
    """What a command of furrow prints with --json. NoGround: it fails, or is not there; its text is the command's."""
    program = command()
    if program is None:
        raise NoGround("the command furrow is not in PATH; install it, or name it in FURROW_PROGRAM")
    done = subprocess.run([program, *words, "--json"], capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        raise NoGround(done.stderr.strip().rpartition("\n")[2].removeprefix("furrow: ") or f"furrow {words[0]} failed")
    found = json.loads(done.stdout)
    return found if isinstance(found, dict) else {}


class Store:
    """The store of a drive, open to be read. NoGround: it is gone, damaged, or has changed since."""

    def __init__(self, run: Run) -> None:
        from furrow import Error, World
        path = run.text("store.file")
        if path is None:
            raise NoGround("run.json does not name the store; an older furrow made it")
        if not os.path.isfile(path):
            raise NoGround(f"{path} is not there any more")
        self.path, self.info = path, ask("info", path)
        last = self.info.get("last_run") or {}
        if last.get("scene_hash") is None or last["scene_hash"] != run.text("scene.hash") or last.get("step") != run.number("steps"):
            raise NoGround(f"{path} was changed after this drive: by another drive, a reset or a restore")
        self.spacing = float(self.info["spacing"])
        self.working: "Union[int, None]" = self.info.get("working_level")
        self.posts = [int(count) for count in self.info["posts"]]
        self.size = [(count - 1) * self.spacing for count in self.posts]
        scene: "dict[str, Any]" = {"spacing": self.spacing_at(self.working) if self.working is not None else self.spacing}
        try:
            if run.members("relief"):  # a store that was deformed over relief is read with the same
                scene = {**_stage._reader(Drive(run.folder)), **scene}
            self.world = World(scene, store=path, readonly=True)
        except (Error, ResultsError) as error:
            raise NoGround(str(error)) from None

    def spacing_at(self, level: int) -> float:
        return math.ldexp(self.spacing, level)

    def posts_at(self, level: int) -> "list[int]":
        """Of both axes."""
        return [((count - 1) << -level) + 1 if level < 0 else ((count - 1) >> level) + 1 for count in self.posts]

    def read(self, layer: str, level: int, x0: int, y0: int, x1: int, y1: int) -> "np.ndarray":
        """Posts of a rectangle, its ends not included; nan outside."""
        return np.asarray(self.world.read(layer, column=x0, row=y0, columns=x1 - x0, rows=y1 - y0, level=level))

    def close(self) -> None:
        self.world.close()


def open_store(run: Run) -> "tuple[Union[Store, None], str]":
    """The store, or None and why."""
    try:
        return Store(run), ""
    except (NoGround, ImportError, ValueError, KeyError, TypeError) as error:
        return None, str(error)


# --- the rut profile ---

class Rut:
    """The ground across a way, at its middle. across: m to the left of the way; change: mm above the ground before all drives, nan over holes. middle, left: m, and the unit vector to the
    left. deepest, highest: mm. below, above: m2. why: a sentence where there is none (across is empty then)."""

    def __init__(self) -> None:
        self.across = self.change = np.zeros(0)
        self.middle = self.left = (0.0, 0.0)
        self.body, self.why = "", ""
        self.deepest = self.highest = self.below = self.above = 0.0

    @property
    def ends(self) -> "Union[np.ndarray, None]":
        """Where it begins and ends, two rows of x, y. None: there is none."""
        if not len(self.across):
            return None
        half = max(abs(self.across[0]), abs(self.across[-1]))
        return np.array([[self.middle[0] + side * half * self.left[0], self.middle[1] + side * half * self.left[1]] for side in (-1, 1)])


def _point(body: Body, at: float) -> "tuple[float, float]":
    """The point of a way at `at` metres from its start."""
    i = int(min(max(np.searchsorted(body.way, at), 1), body.count - 1))
    length = body.way[i] - body.way[i - 1]
    share = min(max((at - body.way[i - 1]) / length, 0), 1) if length > 0 else 0.0
    return float(body.x[i - 1] + share * (body.x[i] - body.x[i - 1])), float(body.y[i - 1] + share * (body.y[i] - body.y[i - 1]))


def _find_middle(body: Body, spacing: float, rut: Rut) -> bool:
    """Finds where the profile lies. False: the body moved less than two posts."""
    length = float(body.way[-1]) if body.count > 1 else 0.0
    if length < 2 * spacing:
        return False
    half = min(max(ALONG, 4 * spacing), length) / 2
    before, behind = _point(body, length / 2 - half), _point(body, length / 2 + half)
    along = behind[0] - before[0], behind[1] - before[1]
    far = math.hypot(*along)
    if far == 0:
        return False
    rut.middle, rut.left, rut.body = _point(body, length / 2), (-along[1] / far, along[0] / far), body.name
    return True


def _outermost(bodies: "list[Body]", rut: Rut) -> float:
    """The distance from the profile's middle to the outermost way that it crosses."""
    most = 0.0
    for body in bodies:
        x, y = body.x - rut.middle[0], body.y - rut.middle[1]
        ahead = x * rut.left[1] - y * rut.left[0] <= 0
        aside = np.abs(x * rut.left[0] + y * rut.left[1])[:-1][ahead[:-1] != ahead[1:]]
        most = max(most, float(aside[aside <= REACH].max(initial=0.0)))
    return most


def _sample(store: Store, level: int, rut: Rut, count: int) -> None:
    """The change of height, interpolated between posts. Posts are read in parts, since a rectangle around all may be large."""
    spacing = store.spacing_at(level)
    rut.across = (np.arange(count) - count // 2) * spacing
    places = (np.array(rut.middle)[:, None] + rut.across * np.array(rut.left)[:, None]) / spacing
    rut.change = np.full(count, np.nan)
    for begin in range(0, count, PART):
        x, y = places[:, begin:begin + PART]
        x0, y0 = int(np.floor(x.min())), int(np.floor(y.min()))
        posts = store.read("offset", level, x0, y0, int(np.floor(x.max())) + 2, int(np.floor(y.max())) + 2)
        i, k = np.floor(x).astype(int) - x0, np.floor(y).astype(int) - y0
        u, v = x - np.floor(x), y - np.floor(y)
        rut.change[begin:begin + PART] = 1e3 * ((1 - v) * ((1 - u) * posts[k, i] + u * posts[k, i + 1]) + v * ((1 - u) * posts[k + 1, i] + u * posts[k + 1, i + 1]))


def _cut(rut: Rut, spacing: float) -> None:
    """Cuts the profile to what changed, and a margin. Sums it."""
    changed = np.flatnonzero(np.abs(np.nan_to_num(rut.change)) >= CHANGED)
    if not len(changed):
        rut.why = f"No rut profile: the ground across the way of {rut.body}, at its middle, is as it was"
        rut.across = rut.change = np.zeros(0)
        return
    own = rut.change[changed]
    rut.deepest, rut.highest = min(0.0, float(own.min())), max(0.0, float(own.max()))
    rut.below, rut.above = float(-np.minimum(own, 0).sum() * spacing / 1e3), float(np.maximum(own, 0).sum() * spacing / 1e3)
    margin = (int(changed[-1]) - int(changed[0])) // 5 + 4
    part = slice(max(int(changed[0]) - margin, 0), int(changed[-1]) + margin + 1)
    rut.across, rut.change = rut.across[part], rut.change[part]


def rut(run: Run, store: "Union[Store, None]", why: str) -> Rut:
    """The profile of a drive; `why`: why there is no store."""
    found = Rut()
    found.why = _read_rut(run, store, why, found)
    if found.why:
        found.across = found.change = np.zeros(0)
    return found


def _read_rut(run: Run, store: "Union[Store, None]", why: str, out: Rut) -> str:
    spacing, path = run.number("spacing"), run.text("store.file")
    bodies = run.objects or run.best_ways()  # of vehicles, the soil geoms make the ruts
    if not spacing > 0 or path is None:
        return "No rut profile: run.json does not name the store; an older furrow made it"
    if not bodies:
        return "No rut profile: no file of the folder tells where the drive went; set output.vehicles in the scene"
    if not os.path.isfile(path):
        return f"No rut profile: {path} is not there any more"
    if not any(_find_middle(body, spacing, out) for body in bodies):
        return f"No rut profile: nothing moved by two posts ({2 * spacing:g} m)"
    if store is None:
        return f"No rut profile: {why}"
    if store.working is None or store.spacing_at(store.working) != spacing:
        return f"No rut profile: {path} has no ruts at this spacing"
    if not all(0 <= at <= size for at, size in zip(out.middle, store.size)):
        return f"No rut profile: the middle of the way of {out.body} lies off the terrain"
    half = math.ceil((_outermost(bodies, out) + max(BESIDE[0 if bodies is run.objects else 1], 16 * spacing)) / spacing)
    _sample(store, store.working, out, 2 * min(half, HALF_MOST) + 1)
    _cut(out, spacing)
    return out.why


# --- the map ---

class Map:
    """The ground of a map: shades and changes (m) of posts from the south, and what its colours mean. png: None until it is drawn, or where there is none: `why` tells. low, high: m, its
    edges. range: m, values at the ends of the colours. rut: m, how wide ruts are drawn at least; 0: as wide as they are."""

    def __init__(self, why: str) -> None:
        self.why, self.png = why, None  # type: str, Union[bytes, None]
        self.values = self.shades = np.zeros((0, 0))
        self.low = self.high = (0.0, 0.0)
        self.range = (0.0, 0.0)
        self.beyond, self.holes = (False, False), False
        self.spacing = self.rut = 0.0
        self.origin, self.system = (0.0, 0.0), ""
        self.pixels = 0


def _extent(run: Run, store: Store, spacing: float) -> "tuple[np.ndarray, np.ndarray]":
    """Of all ways, cut at the terrain's edges. Without a way on the terrain it is the whole terrain."""
    size = np.array(store.size)
    places = [np.stack([body.x, body.y], axis=1) for body in run.best_ways() if body.count]
    low, high = np.zeros(2), size
    if places:
        held = np.clip(np.concatenate(places), 0, size)
        low, high = held.min(axis=0), held.max(axis=0)
    longest = float((high - low).max())
    margin = max(MARGIN * longest, SHOWN)
    more = np.maximum(margin, (max(POSTS_LEAST * spacing, NARROW * (longest + 2 * margin)) - (high - low)) / 2)
    return low - more, high + more


def _coarser(rect: "tuple[int, int, int, int]", shift: int) -> "tuple[int, int, int, int]":
    """The posts of a level that is `shift` coarser, each with the posts that are nearest to it."""
    if shift == 0:
        return rect
    half = 1 << (shift - 1)
    x0, y0, x1, y1 = rect
    return (x0 + half) >> shift, (y0 + half) >> shift, ((x1 - 1 + half) >> shift) + 1, ((y1 - 1 + half) >> shift) + 1


def _shown(value: "np.ndarray", other: "np.ndarray") -> "np.ndarray":
    """Whether a pixel shows a value rather than the other. A rut comes before a heap, even a higher one. Else the larger one comes first."""
    rut, other_rut = value <= -RUT, other <= -RUT
    return np.where(rut != other_rut, rut, np.abs(value) > np.abs(other))


def _reduce(posts: "np.ndarray", x0: int, y0: int, shift: int, rect: "tuple[int, int, int, int]", into: "np.ndarray") -> None:
    """Adds posts of a finer level, whose first is x0, y0, to the pixels that they are in."""
    half = (1 << shift) >> 1
    rows, columns = into.shape
    for axis, first, low, count in ((0, y0, rect[1], rows), (1, x0, rect[0], columns)):
        pixel = np.clip(((np.arange(posts.shape[axis]) + first + half) >> shift) - low, -1, count)
        inside = (pixel >= 0) & (pixel < count)
        pixel, posts = pixel[inside], np.compress(inside, posts, axis=axis)
        if not len(pixel):
            return
        begins = np.flatnonzero(np.diff(pixel, prepend=-1))
        deepest, highest = np.minimum.reduceat(posts, begins, axis=axis), np.maximum.reduceat(posts, begins, axis=axis)
        posts = np.where(_shown(deepest, highest), deepest, highest)
        x0, y0 = (x0, int(pixel[0])) if axis == 0 else (int(pixel[0]), y0)
    part = into[y0:y0 + posts.shape[0], x0:x0 + posts.shape[1]]
    part[...] = np.where(_shown(posts, part), posts, part)


def _changes(store: Store, rect: "tuple[int, int, int, int]", level: int) -> "np.ndarray":
    """By how much the height of each pixel's ground changed, m: what is shown of the posts within it."""
    into = np.zeros((rect[3] - rect[1], rect[2] - rect[0]))
    if store.working is None:
        return into
    if level <= store.working:
        return np.nan_to_num(store.read("offset", level, *rect))
    rects, _ = store.world.changes(0)
    finest = store.working
    while True:  # the finest level of which not too many tiles must be read
        shift, side = finest - store.working, 256
        keys = {(int(r["column"]) // side >> shift, int(r["row"]) // side >> shift) for r in rects}
        if len(keys) <= TILES_MOST or finest >= level:
            break
        finest += 1
    down = level - finest
    half = (1 << down) >> 1
    x_most, y_most = store.posts_at(finest)
    for column, row in sorted(keys):
        x0, y0 = max(column * side, (rect[0] << down) - half), max(row * side, (rect[1] << down) - half)
        x1, y1 = min((column + 1) * side + 1, (rect[2] << down) + half + 1, x_most), min((row + 1) * side + 1, (rect[3] << down) + half + 1, y_most)
        if x0 < x1 and y0 < y1:
            _reduce(np.nan_to_num(store.read("offset", finest, max(x0, 0), max(y0, 0), x1, y1)), max(x0, 0), max(y0, 0), down, rect, into)
    return into


def _widen(values: "np.ndarray") -> "np.ndarray":
    """Ruts of one pixel become three wide, so that ways do not hide them."""
    rows, columns = values.shape
    around = np.pad(values, 1)
    out = np.zeros_like(values)
    for y in range(3):
        for x in range(3):
            part = around[y:y + rows, x:x + columns]
            out = np.where(_shown(part, out), part, out)
    return out


def _slopes(store: Store, level: int, rect: "tuple[int, int, int, int]", by: int) -> "tuple[np.ndarray, np.ndarray]":
    """The base's slopes at posts of a level, interpolated between posts of the level `by`, which is not finer."""
    shift = by - level
    x0, y0, x1, y1 = rect[0] >> shift, rect[1] >> shift, ((rect[2] - 1) >> shift) + 2, ((rect[3] - 1) >> shift) + 2
    found = shade.slopes(store.read("base", by, x0 - 1, y0 - 1, x1 + 1, y1 + 1), store.spacing_at(by))
    x, y = np.arange(rect[0], rect[2]), np.arange(rect[1], rect[3])
    i, k = (x >> shift) - x0, (y >> shift) - y0
    u, v = np.ldexp(x - ((x >> shift) << shift), -shift), np.ldexp(y - ((y >> shift) << shift), -shift)[:, None]
    out = []
    for each in found:
        # A post of which nothing is taken may be nodata.
        across = np.where(u == 0, each[:, i], (1 - u) * each[:, i] + u * each[:, np.minimum(i + 1, each.shape[1] - 1)])
        out.append(np.where(v == 0, across[k], (1 - v) * across[k] + v * across[np.minimum(k + 1, across.shape[0] - 1)]))
    return out[0], out[1]


def _shades(store: Store, level: int, rect: "tuple[int, int, int, int]", offsets: "Union[np.ndarray, None]") -> "np.ndarray":
    """How light the posts of a map are. Below level 0 the base is bilinear between posts: slopes that are interpolated show no cells there. Insets have posts of their own."""
    east, north = _slopes(store, level, rect, max(level, 0))
    spacing = store.spacing_at(level)
    for inset in sorted(store.info.get("insets") or [], key=lambda each: -each["level"]):
        west, south, far, top = inset["window"]
        own = (max(math.ceil(west / spacing - 1e-6), rect[0]), max(math.ceil(south / spacing - 1e-6), rect[1]), min(math.floor(far / spacing + 1e-6) + 1, rect[2]), min(math.floor(top / spacing + 1e-6) + 1, rect[3]))
        if level < 0 and inset["level"] < 0 and own[0] < own[2] and own[1] < own[3]:
            part = slice(own[1] - rect[1], own[3] - rect[1]), slice(own[0] - rect[0], own[2] - rect[0])
            east[part], north[part] = _slopes(store, level, own, max(level, int(inset["level"])))
    if offsets is not None:
        more = shade.slopes(np.pad(offsets, 1, constant_values=np.nan), spacing)
        east, north = east + more[0], north + more[1]
    return shade.light(east, north)


def read_map(run: Run, store: "Union[Store, None]", why: str, pixels: int) -> Map:
    """The ground of a drive, as its store has it. pixels: of the longer side, at most."""
    out = Map(why)
    if store is None:
        return out
    start = store.working if store.working is not None and store.working < 0 else 0
    spacing = store.spacing_at(start)
    low, high = _extent(run, store, spacing)
    columns, rows = store.posts_at(start)
    fine = (max(math.floor(low[0] / spacing), 0), max(math.floor(low[1] / spacing), 0), min(math.ceil(high[0] / spacing) + 1, columns), min(math.ceil(high[1] / spacing) + 1, rows))
    level, rect = start, fine
    while level < int(store.info["levels"][1]) and max(rect[2] - rect[0], rect[3] - rect[1]) > pixels:
        level += 1
        most = store.posts_at(level)
        x0, y0, x1, y1 = _coarser(fine, level - start)
        rect = (min(x0, most[0] - 1), min(y0, most[1] - 1), min(x1, most[0]), min(y1, most[1]))
    out.spacing = store.spacing_at(level)
    out.values = _changes(store, rect, level)
    out.shades = _shades(store, level, rect, out.values if store.working is not None and level <= store.working else None)
    out.holes = bool(np.isnan(out.shades).any())
    if store.working is not None and level > store.working:
        out.values, out.rut = _widen(out.values), 3 * out.spacing
    out.low = ((rect[0] - 0.5) * out.spacing, (rect[1] - 0.5) * out.spacing)
    out.high = (out.low[0] + out.values.shape[1] * out.spacing, out.low[1] + out.values.shape[0] * out.spacing)
    out.origin = tuple(float(value) for value in store.info.get("origin", (0, 0)))  # type: ignore[assignment]
    out.system = str(store.info.get("srs_name") or "")
    out.pixels = pixels
    out.range = shade.signed_range(out.values)
    out.png = b""
    return out


def draw_maps(maps: "list[Map]") -> None:
    """Draws the pictures, all with the largest range."""
    drawn = [each for each in maps if each.png is not None]
    low, high = min((each.range[0] for each in drawn), default=0.0), max((each.range[1] for each in drawn), default=0.0)
    if low < 0 < high:
        high = max(high, -low)
        low = -high
    for each in drawn:
        if each.range[1] > each.range[0]:
            each.range = (low, high)
        each.beyond = (bool(each.values.min() < each.range[0] * (1 + 1e-9)), bool(each.values.max() > each.range[1] * (1 + 1e-9)))
        times = max(1, each.pixels // max(each.values.shape))  # posts stay whole pixels
        picture = shade.picture(each.values, each.shades, each.range, times if max(each.values.shape) * 2 <= each.pixels else 1)
        each.png = shade.png(picture[::-1])
