"""Plots that are not of bodies: the map, the rut profile, volume, times of steps, and the page cache."""
import base64
import math
from typing import Any, Union

import numpy as np

from furrow.report import cache, plots, shade
from furrow.report.blocks import Block, Section, legend, sentence, small
from furrow.report.curves import legend_of
from furrow.report.ground import Map
from furrow.report.plots import Line, Plot
from furrow.report.run import COLOURS, Report, Run

PNG_BYTES = 16 << 20
EDGES_MOST = 4096
KEY = 24  # colours of the map's legend
VOLUMES = (("removed", "removed"), ("raised", "raised"), ("compacted", "compacted"), ("net", "net: raised less removed"))


def _wide(plot: Plot) -> Block:
    return Block("wide", items=[Block("svg", plots.draw(plot))])


# --- the map ---

def _length(metres: float, largest: float) -> str:
    """With the unit that it needs: mm below 1 m."""
    if metres == 0:
        return "0"
    return f"{'+' if metres > 0 else ''}{metres * 1e3:.4g} mm" if largest < 1 else f"{'+' if metres > 0 else ''}{metres:.4g} m"


def _key(found: Map) -> "list[Block]":
    low, high = found.range
    largest = max(abs(low), high)
    if largest == 0:
        return [small("The drive changed no height here.")]
    ends = [_length(low, largest) + (" or less" if found.beyond[0] else ""), "0" if low < 0 < high else "", _length(high, largest) + (" or more" if found.beyond[1] else "")]
    text = "Colours: by how much the drive changed the height of the ground. Blue is lower, red is higher."
    text += " Hatched ground has no data." if found.holes else ""
    text += f" Posts of this picture are {found.spacing:g} m apart."
    text += f" Ruts are drawn at least {found.rut:g} m wide, so that they are seen." if found.rut > 0 else ""
    return [Block("key", text=ends, items=shade.key(found.range, KEY)), small(text)]


def _coordinates(found: Map) -> Block:
    if not found.system and found.origin == (0.0, 0.0):
        return small("Metres are those of the scene: from the terrain's south-west post.")
    return small(f"Metres are those of the scene: from the terrain's south-west post. That post lies at {found.origin[0]:.10g}, {found.origin[1]:.10g} of {found.system or 'the terrain' + chr(39) + 's source'}.")


def _drawn_map(report: Report, i: int) -> Block:
    found, run = report.maps[i], report.runs[i]
    ways, lines = run.best_ways(), []
    for k, body in enumerate(report.drawn(ways)):
        if body.count:
            lines.append(Line(body.x, body.y, *report.style_of(i, k, ways), begins=True))
    ends = report.ruts[i].ends
    if ends is not None:
        lines.append(Line(ends[:, 0], ends[:, 1], COLOURS - 1, 2, dots=True))
    plot = Plot("Map: the ways over the ground that the drive left", "east, m", "north, m", lines, zero=False, one_scale=True,
                ground=(base64.b64encode(found.png).decode(), found.low, found.high))
    return Block("figure", run.folder if report.several else "", [Block("svg", plots.draw(plot)), *_key(found)])


def _own_map(report: Report, i: int) -> "list[Block]":
    """The map that the drive drew, where the store does not show any more what the drive left."""
    run, why = report.runs[i], report.maps[i].why
    path = f"{run.folder}/map.png"
    try:
        with open(path, "rb") as file:
            data = file.read(PNG_BYTES + 1)
    except FileNotFoundError:
        return [sentence(report, i, f"No map: {why}; and the drive left no map.png")]
    except OSError as error:
        return [sentence(report, i, f"No map: {path}: {error.strerror}; give a folder that can be read")]
    if len(data) > PNG_BYTES:
        return [sentence(report, i, f"No map: {path}: is larger than {PNG_BYTES >> 20} MB; give a folder that furrow drive left")]
    width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    if len(data) < 24 or data[:16] != b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" or not 0 < width <= 65536 or not 0 < height <= 65536:
        return [sentence(report, i, "No map: map.png is no PNG")]
    image = Block("img", text=("Map: ways on the hillshade, and by how much the ground changed", base64.b64encode(data).decode(), "png"), items=[width, height])
    return [sentence(report, i, f"This is the map that the drive drew at its end, since {why}"), Block("figure", run.folder if report.several else "", [image])]


def map_section(report: Report) -> Section:
    drawn = [i for i, found in enumerate(report.maps) if found.png is not None]
    items: "list[Block]" = []
    for i in range(len(report.runs)):
        items += [_drawn_map(report, i)] if i in drawn else _own_map(report, i)
    blocks = legend_of(report, Run.best_ways) if drawn else []
    blocks.append(Block("plots" if report.several else "wide", items=items))
    if drawn:
        blocks.append(small("A way begins at its large dot. A dotted line between two small dots shows where the rut profile lies."))
        if report.several:
            blocks.append(small("All maps that this page draws have one colour scale: the largest of the drives."))
        blocks.append(_coordinates(report.maps[drawn[0]]))
    return Section("map", "Map", blocks)


# --- the rut ---

def rut(report: Report) -> Section:
    blocks = [sentence(report, i, found.why) for i, found in enumerate(report.ruts) if found.why]
    shown = [(i, found) for i, found in enumerate(report.ruts) if not found.why]
    if shown:
        if report.several:
            blocks.append(legend([(i, 0, report.runs[i].folder) for i, _ in shown]))
        blocks.append(_wide(Plot("The ground across the way", "across the way, m (left is positive)", "change of height, mm", [Line(found.across, found.change, i) for i, found in shown])))
        for i, found in shown:
            blocks.append(sentence(report, i, f"At the middle of the way of {found.body} ({found.middle[0]:.3f} m east, {found.middle[1]:.3f} m north): {-found.deepest:.1f} mm deep, "
                                              f"rims {found.highest:.1f} mm high; {found.below:.4g} m2 below the old ground, {found.above:.4g} m2 above it"))
    return Section("rut", "Rut profile", blocks)


# --- volume ---

def volume(report: Report) -> Section:
    blocks: "list[Block]" = []
    lines, items = [], []
    for i, run in enumerate(report.runs):
        count = len(run.volumes.get("t", ()))
        if count < 2:
            blocks.append(sentence(report, i, "No volume over time: the drive made one commit" if count == 1 else "No volume over time: the folder has no volume.csv"))
            continue
        for k, (key, name) in enumerate(VOLUMES):
            colour, dash = (i, k) if report.several else (k, 0)
            lines.append(Line(run.volumes["t"], run.volumes[key], colour, dash, dots=count <= 60))
            items.append((colour, dash, f"{run.folder}: {name}" if report.several else name))
    if lines:
        blocks += [legend(items), _wide(Plot("Volume over time", "time, s", "volume, m3", lines)),
                   small("A point for each commit, which are some seconds of wall clock apart. Volumes are those below and above the ground as it was imported.")]
    return Section("volume", "Volume over time", blocks)


# --- times of steps ---

def _histogram(run: Run) -> "Union[tuple[np.ndarray, np.ndarray], None]":
    """Edges, and percent of the steps between them, with a 0 at the end. None: there is no valid histogram."""
    edges, counts = run.at("step_ms.histogram.edges"), run.at("step_ms.histogram.counts")
    if not isinstance(edges, list) or not isinstance(counts, list) or not 1 <= len(counts) < EDGES_MOST or len(edges) != len(counts) + 1:
        return None
    if not all(isinstance(value, float) and math.isfinite(value) for value in [*edges, *counts]) or not all(a < b for a, b in zip([0.0, *edges], edges)) or min(counts) < 0 or not sum(counts) > 0:
        return None
    shares = np.array([*counts, 0.0]) * (100 / sum(counts))
    return np.array(edges), shares


def steps(report: Report) -> Section:
    blocks, lines = [], []
    for i, run in enumerate(report.runs):
        found = _histogram(run)
        if found is None:
            blocks.append(sentence(report, i, "No histogram: run.json has none; no step was made, or an older furrow made it"))
        else:
            lines.append(Line(found[0], found[1], i, steps=True))
    if lines:
        if report.several:
            blocks.append(legend([(line.colour, 0, report.runs[line.colour].folder) for line in lines]))
        middle = math.nan if report.several else report.runs[0].number("step_ms.p50")
        blocks += [_wide(Plot("Step times", "step time, ms", "steps, %", lines, logarithmic=True, upright=middle, told="median")), small("Four bars for each doubling of the time.")]
    return Section("steps", "Step times", blocks)


# --- the page cache ---

def cache_section(report: Report) -> Section:
    blocks, lines, items = [], [], []
    for i, found in enumerate(report.caches):
        if found.why:
            blocks.append(sentence(report, i, found.why))
            continue
        for k, name in enumerate(cache.NAMES):
            colour, dash = (i, k) if report.several else (k, 0)
            lines.append(Line(np.array(found.slots, float), np.array(found.misses[k], float), colour, dash, dots=True))
            items.append((colour, dash, f"{report.runs[i].folder}: {name}" if report.several else name))
    if lines:
        own = math.nan if report.several else report.runs[0].number("cache.slots")
        blocks += [legend(items), _wide(Plot("Misses over slots", "slots", "misses", lines, logarithmic=True, upright=own, told="slots of this drive"))]
        blocks += [sentence(report, i, f"{found.accesses} accesses to {found.tiles} tiles, simulated as furrow cache-sim does: each cache starts empty and does not prefetch")
                   for i, found in enumerate(report.caches) if not found.why]
    return Section("cache", "Page cache: misses over slots", blocks)
