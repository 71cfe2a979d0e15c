"""Digging, of each body that carries soil: what is aboard, how hard it cuts, the energy of digging for each m3 that it brought, and its cycles.

    cutting force = the soil's force on the body, without the weight of what is aboard: (fx, fy, fz + carried_weight)
    it digs       where its work on the soil grows from one row to the next
    energy        of a cycle: its work on the soil from the low before to where it begins to hold its load, so without dumping
    fill          volume aboard / struck capacity (run.json: `capacity`, of the body's shape at level attitude)
    mass          weight aboard / gravity

A cycle: the volume aboard rises from a low to a peak, and falls to the next low. Rises and falls of less than a tenth of the most that was aboard are part of what they interrupt. Behind the
peak it holds its load where the volume falls by no more than a twentieth of the peak's rise for the longest time. What it holds in the middle of that time is what it brought; the rest was
spilled.
"""
import math
from dataclasses import dataclass
from typing import Union

import numpy as np

from furrow.report.forces import Body, is_part
from furrow.report.run import Run, finite

SWING = 0.1   # of the most that was aboard: a smaller rise or fall is part of what it interrupts
LEVEL = 0.05  # of a peak's rise: a load that changes by less is held
CYCLES = 100


@dataclass
class Cycle:
    """Rows. low, peak, end: of the volume aboard; end is the low after it, or the last row. fills, half: 1 %, and half, of what it brought is aboard. holds, held: the first row and the middle of
    the time in which it is held. dumps, fallen, emptied: the last row before 1 % of that has left, the first at which half, and 99 %, have. dumped: it was; else these are the last row."""
    low: int
    peak: int
    end: int
    fills: int = 0
    half: int = 0
    holds: int = 0
    held: int = 0
    dumps: int = 0
    fallen: int = 0
    emptied: int = 0
    dumped: bool = False


def _find_hold(volume: "list[float]", time: "list[float]", cycle: Cycle) -> None:
    within = LEVEL * (volume[cycle.peak] - volume[cycle.low])
    own, begin = volume[cycle.peak:cycle.end + 1], cycle.peak
    highest = np.maximum.accumulate(own[::-1])[::-1].tolist()  # from a row on: smaller rises count as level
    longest, last, b = -1.0, begin, 0
    for a in range(len(own)):
        b = max(a, b)
        while b + 1 < len(own) and highest[b + 1] >= highest[a] - within:
            b += 1
        if time[begin + b] - time[begin + a] > longest:
            longest, cycle.holds, last = time[begin + b] - time[begin + a], begin + a, begin + b
    cycle.held = cycle.holds
    while cycle.held < last and time[cycle.held] < time[cycle.holds] + longest / 2:
        cycle.held += 1


def _find_phases(volume: "list[float]", time: "list[float]", swing: float, cycle: Cycle) -> None:
    """Of a cycle whose low, peak and end are known. A fall of less than `swing` from what it holds is no dump."""
    _find_hold(volume, time, cycle)
    low, held, left = volume[cycle.low], volume[cycle.held], volume[cycle.end]
    cycle.dumped = held - left >= swing
    brought, fell = held - low, held - left
    cycle.fills = cycle.low
    while cycle.fills + 1 < cycle.peak and volume[cycle.fills + 1] <= low + 0.01 * brought:
        cycle.fills += 1
    cycle.half = cycle.fills
    while cycle.half < cycle.peak and volume[cycle.half] < low + 0.5 * brought:
        cycle.half += 1
    cycle.dumps = cycle.fallen = cycle.emptied = cycle.end
    if not cycle.dumped:
        return
    while cycle.dumps > cycle.held and volume[cycle.dumps] < left + 0.99 * fell:
        cycle.dumps -= 1
    cycle.fallen = cycle.dumps
    while cycle.fallen < cycle.end and volume[cycle.fallen] > left + 0.5 * fell:
        cycle.fallen += 1
    cycle.emptied = cycle.fallen
    while cycle.emptied < cycle.end and volume[cycle.emptied] > left + 0.01 * fell:
        cycle.emptied += 1


def cycles(values: "np.ndarray", times: "np.ndarray") -> "tuple[list[Cycle], int]":
    """The first CYCLES cycles of a volume aboard, m3, and how many there are."""
    volume, time = values.tolist(), times.tolist()
    swing = SWING * max(volume, default=0.0)
    found: "list[Cycle]" = []
    count, low, peak, end, falls = 0, 0, 0, 0, False
    for i in range(len(volume) + 1 if swing > 0 else 0):
        over = i == len(volume)
        if over:
            if not falls and volume[peak] - volume[low] < swing:
                continue
        elif falls:
            end = i if volume[i] < volume[end] else end
            if not volume[i] >= volume[end] + swing:
                continue
        else:
            if volume[peak] - volume[low] >= swing and volume[i] <= volume[peak] - swing:
                falls, end = True, i
            elif volume[i] > volume[peak]:
                peak = i
            elif volume[i] < volume[low]:
                low = peak = i
            continue
        if count < CYCLES:
            cycle = Cycle(low, peak, end if falls and not over else len(volume) - 1)
            _find_phases(volume, time, swing, cycle)
            found.append(cycle)
        count += 1
        low, peak, end, falls = end, i, 0, False
    return found, count


class Digger:
    """A body that carries. volume (m3), weight (N), level and force (N: horizontal part, and all, of the cutting force), work (J) of each row. capacity (m3) and gravity (m/s2): nan where not
    known."""

    def __init__(self, run: int, body: Body, capacity: float, gravity: float, style: "tuple[int, int]") -> None:
        self.run, self.body, self.capacity, self.gravity, self.style = run, body, capacity, gravity, style
        rows = body.columns
        weight = rows.get("carried_weight", np.full(body.count, np.nan))
        self.volume = np.where(np.isfinite(rows["carried"]), rows["carried"], 0)
        self.weight = np.where(np.isfinite(weight), weight, 0)
        self.level = np.hypot(rows["fx"], rows["fy"])
        self.force = np.hypot(self.level, rows["fz"] + self.weight)
        self.work = rows.get("work", np.full(body.count, np.nan))
        grows = np.diff(self.work, prepend=self.work[:1]) > 0
        self.digs = np.where(np.isfinite(self.work), grows, True) & (self.force > 0)
        self.cycles, self.count = cycles(self.volume, body.time)
        self.brought = float(sum(self.brought_in(cycle) for cycle in self.cycles))
        self.spent = float(sum(self.spent_in(cycle) for cycle in self.cycles))

    def brought_in(self, cycle: Cycle) -> float:
        return float(self.volume[cycle.held] - self.volume[cycle.low])

    def spent_in(self, cycle: Cycle) -> float:
        return float(self.work[cycle.holds] - self.work[cycle.low])

    def figures(self) -> "list[tuple[str, float]]":
        """Of the whole drive: its name and value."""
        most, known = float(self.volume.max()), self.digs.any()
        seconds = float(np.diff(self.body.time, prepend=self.body.time[:1])[self.digs].sum())
        peaks = [float(np.fmax.reduce(values)) for values in (self.level, self.force)]
        means = [float(values[self.digs].mean()) if known else math.nan for values in (self.level, self.force)]
        return [("struck capacity, m3", self.capacity), ("most that was aboard, m3", most), ("most that was aboard, kg", float(self.weight.max()) / self.gravity),
                ("largest fill, share of the struck capacity", most / self.capacity), ("brought in all cycles, m3", self.brought), ("aboard at the end, m3", float(self.volume[-1])),
                ("horizontal cutting force: largest, N", peaks[0]), ("horizontal cutting force: mean while it digs, N", means[0]), ("whole cutting force: largest, N", peaks[1]),
                ("whole cutting force: mean while it digs, N", means[1]), ("time in which it digs, s", seconds), ("energy of digging, J", self.spent),
                ("energy of digging for each m3 that it brought, J/m3", self.spent / self.brought if self.brought > 0 else math.nan)]


def _facts(run: Run, name: str) -> "Union[tuple[float, float], None]":
    """Capacity and gravity of a body: of an object with a path, or of a vehicle's soil geom. None: run.json has no soil aboard of it."""
    told = run.named("objects", name, "carried")
    gravity = finite(told.get("gravity")) if isinstance(told, dict) else math.nan
    for vehicle, each in run.members("vehicles").items():
        if is_part(name, vehicle) and isinstance(each, dict):
            gravity = finite(each.get("gravity"))
            aboard = each.get("carried")
            geoms = aboard.get("geoms") if isinstance(aboard, dict) else None
            told = geoms.get(name) if isinstance(geoms, dict) else None
    if told is None:
        return None
    capacity = finite(told.get("capacity")) if isinstance(told, dict) else math.nan
    return capacity if capacity > 0 else math.nan, gravity if gravity > 0 else math.nan


def diggers(run: Run, number: int, most: int, style: "object") -> "tuple[list[Digger], int]":
    """The bodies of a drive that carry, as many as plots show; and how many are left out. style(place): colour and dash."""
    found: "list[Digger]" = []
    left = 0
    for body in run.objects:
        facts = _facts(run, body.name)
        if "carried" not in body.columns or body.count == 0 or facts is None:
            continue
        if len(found) == most:
            left += 1
            continue
        found.append(Digger(number, body, *facts, style(len(found))))  # type: ignore[operator]
    return found, left
