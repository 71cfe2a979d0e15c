"""Figures of the rows: means over the last quarter of a drive's time, and where the energy of the whole drive went."""
import math
from dataclasses import dataclass
from typing import Callable, Union

import numpy as np

from furrow.report.forces import Body, is_part
from furrow.report.run import Run, finite

PART = 0.75    # of the time, from which rows count
PULLS = 0.01   # of the axles' work: less traction is noise


@dataclass
class Figure:
    """value: of Body.values. scale: to the base unit. force: of a vehicle it is the sum over its wheels, not their mean."""
    value: str
    name: str
    unit: str
    scale: float
    force: bool


FIGURES = (Figure("slip", "slip", "", 1, False), Figure("sinkage", "sinkage", ", mm", 1e-3, False), Figure("traction", "traction", ", N", 1, True),
           Figure("drawbar", "drawbar pull", ", N", 1, True), Figure("torque", "torque", ", N m", 1, True), Figure("vertical", "vertical force", ", N", 1, True))


def _late(body: Body, begin: float) -> int:
    """The first row of the last quarter."""
    return int(np.searchsorted(body.time, begin * (1 - 1e-9))) if math.isfinite(begin) else body.count


def _own(run: Run, name: str, vehicle: bool, side: str = "") -> "list[Body]":
    """An object, or a vehicle's soil geoms, all or of one side."""
    return [body for body in run.objects if (is_part(body.name, name) and side in ("", run.sides[body.name]) if vehicle else body.name == name)]


def mean(run: Run, name: str, vehicle: bool, figure: Figure, side: str = "") -> float:
    """A figure of an object, or of a vehicle's wheels together; nan: not known."""
    begin, means = PART * run.ends_at(), []
    for body in _own(run, name, vehicle, side):
        late = body.values[figure.value][_late(body, begin):]
        late = late[np.isfinite(late)]
        own = float(np.cumsum(late[::-1])[-1] / len(late)) if len(late) else math.nan
        if not math.isnan(own) or figure.force:
            means.append(own)
    if not means:
        return math.nan
    return figure.scale * (sum(means) / len(means) if vehicle and not figure.force else sum(means))


class Spent:
    """Work in the last quarter, kJ, of a vehicle's actuators, into the soil, and of the soil's force along the way; seconds and m in plan."""

    def __init__(self, run: Run, name: str, vehicle: bool) -> None:
        self.seconds = self.way = self.soil = self.traction = 0.0
        self.work = math.nan
        begin = PART * run.ends_at()
        for body in _own(run, name, vehicle):
            first = _late(body, begin)
            if first + 1 < body.count:
                self.soil += float(body.values["energy"][-1] - body.values["energy"][first])
                self.traction += float(body.values["push"][-1] - body.values["push"][first])
                self._span(body, first)
        for body in run.vehicles if vehicle else []:
            first = _late(body, begin)
            if body.name == name and first + 1 < body.count:
                self._span(body, first)
                self.work = float(body.values["work"][-1] - body.values["work"][first])

    def _span(self, body: Body, first: int) -> None:
        self.seconds, self.way = float(body.time[-1] - body.time[first]), float(body.way[-1] - body.way[first])

    def figures(self) -> "list[tuple[str, float]]":
        """Name and value; the axles' work is what went into the soil and what the soil's force did along the way."""
        axles = self.traction + self.soil
        return [("mean power of its actuators, W", 1e3 * self.work / self.seconds if self.seconds > 0 else math.nan),
                ("work of its actuators for each metre, J/m", 1e3 * self.work / self.way if self.way > 0 else math.nan),
                ("energy into the soil for each metre, J/m", 1e3 * self.soil / self.way if self.way > 0 else math.nan),
                ("tractive efficiency, share of 1", self.traction / axles if self.soil > 0 and self.traction > PULLS * axles else math.nan)]


# --- of the whole drive ---

def of_object(run: Run, body: Body) -> "list[tuple[str, float]]":
    """Where the energy of an object went, from its first row to its last."""
    way, energy = float(body.way[-1]), body.energy
    turns = energy["torque"] if energy["torque"] != 0 else math.nan
    a_metre = 1e3 * energy["soil"] / way if way > 0 else math.nan
    by_slip = 1e3 * energy["slip"] / way if turns > 0 and way > 0 else math.nan
    return [("way, m", way), ("work of the axle's torque, kJ", turns), ("work of the drawbar pull, kJ", energy["push"] - energy["climb"]), ("work that lifts the weight, kJ", energy["climb"]),
            ("energy into the soil, kJ", energy["soil"]), ("energy into the soil for each metre, J/m", a_metre), ("of that, by slip, J/m", by_slip),
            ("of that, by sinking and pushing soil, J/m", a_metre - (by_slip if math.isfinite(by_slip) else 0)),
            ("tractive efficiency, share of 1", energy["push"] / energy["torque"] if energy["torque"] > 0 and energy["push"] > 0 else math.nan)]


def of_vehicle(run: Run, body: Body) -> "list[tuple[str, float]]":
    """Where the work of a vehicle went, from its first row to its last."""
    way = float(body.way[-1])
    work, soil, kinetic = (float(body.values[name][-1] - body.values[name][0]) for name in ("work", "soil", "kinetic"))
    mass, gravity, loss = (finite(run.named("vehicles", body.name, key)) for key in ("mass", "gravity", "brake_loss"))
    lifted, braked = mass * gravity * body.rise / 1e3, loss / 1e3
    return [("way, m", way), ("work of the actuators, kJ", work), ("work of the actuators for each metre, J/m", 1e3 * work / way if way > 0 else math.nan),
            ("into the soil, by all soil geoms, kJ", soil), ("to lift its weight, kJ", lifted), ("into motion, kJ", kinetic), ("into brakes, in the whole drive, kJ", braked),
            ("the rest: dampers, springs and stops of its joints, kJ", work - soil - kinetic - lifted - (0 if math.isnan(braked) else braked))]


Told = Callable[[Run, Body], "list[tuple[str, float]]"]


def columns(shown: "list[tuple[Run, Body]]", told: Told) -> "list[tuple[str, list[float]]]":
    """A row for each figure that one of them has."""
    each = [told(run, body) for run, body in shown]
    rows = [(figures[0][0], [value for _, value in figures]) for figures in zip(*each)]
    return [(name, values) for name, values in rows if any(math.isfinite(value) for value in values)]


# --- pull against slip ---

SECOND = 1.0  # s: what a mean is over, where a load car holds the vehicle to one speed


def holds(times: "np.ndarray", control: "np.ndarray") -> "list[tuple[float, float]]":
    """Begin and end, s, of the last second of each time in which the control stays, if it is as long as a mean needs and a turn to settle in."""
    ends = np.r_[np.flatnonzero(np.diff(control) != 0), len(control) - 1]
    found = []
    for first, last in zip(np.r_[0, ends[:-1] + 1], ends):
        begin, end = float(times[first]), float(times[last])
        if end - begin > 1.5 * SECOND:
            found.append((end - SECOND, end))
    return found


def tow_points(run: Run, vehicle: Body) -> "Union[np.ndarray, None]":
    """Of a tow test: rows of slip, pull of the load car (the actuator `tow`), and force of the soil along the way, N. None: it is none."""
    control, pull = vehicle.columns.get("u:tow"), vehicle.columns.get("f:tow")
    wheels = _own(run, vehicle.name, True)
    if control is None or pull is None or not wheels or not np.isfinite(control).all():
        return None
    points = []
    for begin, end in holds(vehicle.time, control):
        late = (vehicle.time >= begin) & (vehicle.time <= end)
        rows = np.flatnonzero(late)
        way = np.array([vehicle.columns[key][rows[-1]] - vehicle.columns[key][rows[0]] for key in "xyz"])
        length = float(np.linalg.norm(way))
        own = [np.flatnonzero((body.time >= begin) & (body.time <= end)) for body in wheels]
        if length < 1e-6 or any(not len(part) for part in own):
            continue
        with np.errstate(all="ignore"):
            slip = float(np.mean(np.concatenate([body.columns["slip"][part] for body, part in zip(wheels, own)])))
            force = sum(float(np.mean(body.columns[f"f{axis}"][part])) * along / length for body, part in zip(wheels, own) for axis, along in zip("xyz", way))
        points.append((slip, float(np.mean(pull[late])), force))
    found = np.array(points).reshape(-1, 3)
    found = found[np.isfinite(found).all(axis=1)]
    return found if len(found) else None
