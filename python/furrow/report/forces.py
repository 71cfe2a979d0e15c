"""Forces along the ground, and energy into the soil, of the rows of an object:

    traction = F . t                 t: the direction of the way along the ground as it was, in space: of the centre's way, raised by the sinkage
    grade    = W t_z                 W: the load; without one the soil's upward force, as of a vehicle's wheel
    drawbar  = traction - grade      what is left to pull with. On level ground it is the traction

and between two rows, with the means of F and M:

    push     = F . dp                dp: the way of the centre, in space. F without the weight of soil aboard
    soil     = torque - push         of a vehicle the soil's part is the column `work`, and the torque's work follows from it
    torque   = -(M . a) ds / (r (1 - slip))      only of a wheel; a: its axle, to the left; ds: its way along the ground
    axle's torque = -(M . a)         of a wheel, and of a vehicle's soil geom; a: level, to the left of the way
    Of a shape that carries soil, and does not turn by itself, the column `work` has its turns, too: push = -work.
    by slip  = slip x torque         a wheel with the torque's force T / r loses T / r x slip x rim's way to slip (Wong, ch. 4)

F, M: the soil's force and moment on the object.
"""
import math
from typing import Union

import numpy as np

SLIP_MOST = 0.99   # above it a wheel turns almost in place, so its angle cannot be computed from its way
TURN_WAY = 0.05    # m in plan from which the direction of the way is taken
SLOPE_WAY = 0.25   # m in plan: the slope is a mean over once to twice that
LOSS_WAY = 0.1     # m in plan over which the energy for each metre is a mean
VALUES = ("sinkage", "slip", "traction", "grade", "drawbar", "energy", "loss", "torque", "vertical", "push")


class Body:
    """The rows of an object, a vehicle or an actuator, and what is computed of them.

    time (s), way (m in plan since the first row), x, y (m). values: by name, nan where not known: of an object VALUES (sinkage in mm, forces in N, torque in N m, energy and push in kJ,
    loss in J/m); of a vehicle speed (m/s), work, kinetic and soil (kJ); of an actuator force. energy: kJ of the whole drive, of an object. rise: m from the first row to the last.
    steepest: of an object, its largest grade resistance over the weight. columns: as they were read; of an object those that are needed afterwards.
    """

    def __init__(self, name: str, columns: "dict[str, np.ndarray]") -> None:
        self.name, self.columns = name, columns
        self.x, self.y = columns["x"], columns["y"]
        self.time = columns.get("t", np.zeros(len(self.x)))
        self.went = np.hypot(np.diff(self.x, prepend=self.x[:1]), np.diff(self.y, prepend=self.y[:1]))
        self.way = np.cumsum(self.went)
        self.rise = float(columns["z"][-1] - columns["z"][0]) if "z" in columns and len(self.x) else math.nan
        self.values: "dict[str, np.ndarray]" = {}
        self.energy: "dict[str, float]" = {}
        self.steepest = 0.0

    @property
    def count(self) -> int:
        return len(self.x)


def _tangents(body: Body) -> "tuple[np.ndarray, int]":
    """The direction of the way at each row, n x 3, and the first row from which it is known. The slope is a mean over a longer way, since sinkage is as coarse as posts are."""
    xs, ys, went = body.x.tolist(), body.y.tolist(), body.went.tolist()
    zs = (body.columns["z"] + body.columns["sinkage"]).tolist()  # the ground as it was: its height has an unknown but constant offset
    tangents = np.full((len(xs), 3), np.nan)
    first, since = len(xs), 0
    mark = older = newer = (xs[0], ys[0], zs[0])
    tangent = None
    for i in range(1, len(xs)):
        level = math.hypot(xs[i] - mark[0], ys[i] - mark[1])
        if tangent is None and went[i] == 0:  # what it sinks before it moves is no slope
            mark = older = newer = (xs[i], ys[i], zs[i])
        if not level >= TURN_WAY:
            continue
        ground = (xs[i], ys[i], zs[i])
        far = math.hypot(ground[0] - older[0], ground[1] - older[1])
        slope = (ground[2] - older[2]) / far if far > 0 else 0.0
        length = math.sqrt(1 + slope * slope)
        if tangent is None:
            first = i
        else:
            tangents[since:i] = tangent
        tangent, since = ((ground[0] - mark[0]) / level / length, (ground[1] - mark[1]) / level / length, slope / length), i
        mark = ground
        if math.hypot(ground[0] - newer[0], ground[1] - newer[1]) >= SLOPE_WAY:
            older, newer = newer, ground
    if tangent is not None:
        tangents[since:] = tangent
    if first == 1:  # the first row looks along the way to the second
        tangents[0] = tangents[1]
        first = 0
    return tangents, first


def _losses(body: Body, energy: "np.ndarray") -> "np.ndarray":
    """The energy for each metre, known where there is enough way since the row where it was known last."""
    loss, way = np.full(body.count, np.nan), body.way.tolist()
    paid = 0
    for at in range(1, len(way)):
        if way[at] - way[paid] < LOSS_WAY:
            continue
        loss[0 if paid == 0 else paid + 1:at + 1] = 1e3 * (energy[at] - energy[paid]) / (way[at] - way[paid])
        paid = at
    return loss


def _between(values: "np.ndarray") -> "np.ndarray":
    """The means of each row and the one before."""
    return (values[:-1] + values[1:]) / 2


def _torque_between(body: Body, radius: float, flat: bool) -> "np.ndarray":
    """The work of the torque between two rows, J. nan: not known."""
    rows = body.columns
    if math.isnan(radius) or radius == 0:
        return np.full(body.count - 1, radius)
    slip, went = _between(rows["slip"]), body.went[1:]
    with np.errstate(all="ignore"):
        axle = -np.diff(body.y) / went, np.diff(body.x) / went
        rolled = went if flat else np.hypot(went, np.diff(rows["z"]))  # as the world rolls it
        work = -(_between(rows["tx"]) * axle[0] + _between(rows["ty"]) * axle[1] + _between(rows["tz"]) * 0) * rolled / (radius * (1 - slip))
    return np.where(slip < SLIP_MOST, np.where(went == 0, 0, work), np.nan)


def compute(body: Body, radius: float, flat: bool) -> None:
    """Fills the values, energy and steepest of an object. radius: of a wheel, m; 0: a shape that does not turn; nan: not known how it turns. flat: a wheel that rolls by its way in plan."""
    rows, count, nothing = body.columns, body.count, np.full(body.count, np.nan)
    work, aboard, load = rows.get("work", nothing), rows.get("carried_weight", nothing), rows.get("load", nothing)
    force = np.stack([rows["fx"], rows["fy"], rows["fz"]], axis=1)
    cuts = force.copy()
    cuts[:, 2] += np.where(np.isfinite(aboard), aboard, 0)  # the soil's force without the weight of what is aboard
    weight = np.where(load > 0, load, cuts[:, 2])
    with np.errstate(all="ignore"):
        tangents, first = _tangents(body)
        traction, grade = (force * tangents).sum(axis=1), weight * tangents[:, 2]
        turns = radius > 0 or math.isnan(radius)
        known = np.full(count, turns) & ((radius > 0) | np.isfinite(work))
        torque = (rows["tx"] * tangents[:, 1] - rows["ty"] * tangents[:, 0]) / np.hypot(tangents[:, 0], tangents[:, 1])
        body.values = {"sinkage": rows["sinkage"] * 1e3, "slip": rows["slip"], "vertical": rows["fz"], "traction": traction, "grade": grade, "drawbar": traction - grade,
                       "torque": np.where(known, torque, np.nan)}
        bears = (weight > 0) & np.isfinite(tangents[:, 2])
        body.steepest = float(np.abs(tangents[bears, 2]).max()) if bears.any() else 0.0
        steps = np.diff(np.stack([body.x, body.y, rows["z"]], axis=1), axis=0)
        push = (_between(cuts) * steps).sum(axis=1)
        climb = _between(weight) * steps[:, 2]
        told = np.isfinite(work[:-1]) & np.isfinite(work[1:])
        if radius == 0:
            push = np.where(told, work[:-1] - work[1:], push)
        soil = np.where(told, np.diff(work), _torque_between(body, radius, flat) - push)
        by_torque, slip = soil + push, _between(rows["slip"])
        by_slip = np.where((by_torque > 0) & (slip > 0), np.minimum(slip, 1) * by_torque / 1e3, by_torque * 0)
        start = math.nan if math.isnan(radius) and math.isnan(work[0]) else 0.0
        sums = {name: np.cumsum([begin, *values]) for name, begin, values in (("soil", start, soil / 1e3), ("torque", start, by_torque / 1e3), ("push", 0.0, push / 1e3),
                                                                              ("climb", 0.0, climb / 1e3), ("slip", start, by_slip))}
        body.energy = {name: float(values[-1]) for name, values in sums.items()}
        body.values["energy"], body.values["push"] = sums["soil"], sums["push"]
        body.values["loss"] = _losses(body, sums["soil"])
    carries = "carried" in rows and count > 0 and math.isfinite(rows["carried"][0])
    body.columns = {name: rows[name] for name in ("slip", "fx", "fy", "fz", *(("carried", "carried_weight", "work") if carries else ())) if name in rows}
    body.went = np.zeros(0)


def is_part(part: str, vehicle: str) -> bool:
    """Whether an object is a soil geom of a vehicle: VEHICLE.GEOM."""
    return part.startswith(vehicle + ".")


def side(body: Body, vehicle: "Union[Body, None]") -> str:
    """"left", "right" or "": of a vehicle's soil geom by where it lies in the first row, else by its name."""
    words = body.name.lower()
    for word, other in (("left", "right"), ("right", "left")):
        if word in words and other not in words:
            return word
    if vehicle is None or "yaw" not in vehicle.columns or vehicle.count == 0 or body.count == 0:
        return ""
    yaw = math.radians(vehicle.columns["yaw"][0])
    aside = -(body.x[0] - vehicle.x[0]) * math.sin(yaw) + (body.y[0] - vehicle.y[0]) * math.cos(yaw)
    return "left" if aside > 0.05 else "right" if aside < -0.05 else ""
