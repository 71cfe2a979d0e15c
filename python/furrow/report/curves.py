"""Plots of bodies: ways, curves of objects, vehicles and actuators, pull against slip, digging. Where nothing can be drawn, a sentence stands in place of the plot."""
import math
from typing import Any, Callable, Union

import numpy as np

from furrow.report import digging, energy, plots
from furrow.report.blocks import Block, Place, Section, legend, sentence, short, small, table
from furrow.report.forces import Body
from furrow.report.plots import Line, Plot
from furrow.report.run import COLOURS, Report, Run

Pick = Callable[[Run], "list[Body]"]
SLIPS = 0.05  # share of 1: slip that changes by more is worth a plot of the pull over it
Value = "tuple[str, str, str, tuple[float, float], bool, Union[str, None]]"  # of Body.values; name, unit; ends of the axis; not drawn if it is 0 in all rows; why it is not drawn

OF_OBJECTS: "list[Any]" = [
    ("sinkage", "sinkage", ", mm", (0, 0), False, "No sinkage: objects.csv has none"),
    ("slip", "slip", ", share of 1", (-1, 1), True, "No slip: it is 0 in all rows"),
    ("traction", "traction", ", N", (0, 0), False, None),
    ("grade", "grade resistance", ", N", (0, 0), False, None),
    ("drawbar", "drawbar pull", ", N", (0, 0), False, "No drawbar pull: nothing moved"),
    ("torque", "torque", ", N m", (0, 0), False, None),
    ("energy", "energy into the soil", ", kJ", (0, 0), False, None),
    ("loss", "energy into the soil for each metre", ", J/m", (0, 0), False, None)]
OF_VEHICLES: "list[Any]" = [
    ("speed", "speed", ", m/s", (0, 0), False, "No speed: vehicles.csv has none"),
    ("work", "work of the actuators", ", kJ", (0, 0), False, "No work: vehicles.csv has none"),
    ("soil", "energy into the soil", ", kJ", (0, 0), False, "No energy into the soil: objects.csv has no rows of these vehicles; set output.forces in the scene"),
    ("kinetic", "kinetic energy", ", kJ", (0, 0), False, "No kinetic energy: vehicles.csv has none")]
OF_ACTUATORS: "list[Any]" = [("force", "force of the actuators", ", N or N m", (0, 0), False, None)]
OF_DIGGERS = [("carried mass", ", kg", lambda d: d.weight / d.gravity), ("bucket fill", ", share of the struck capacity", lambda d: d.volume / d.capacity),
              ("horizontal cutting force", ", N", lambda d: d.level), ("whole cutting force", ", N", lambda d: d.force), ("work on the soil", ", kJ", lambda d: d.work * 1e-3)]


def legend_of(report: Report, pick: Pick, many: str = "objects") -> "list[Block]":
    items, told = [], []
    for i, run in enumerate(report.runs):
        bodies = pick(run)
        drawn = report.drawn(bodies)
        items += [(*report.style_of(i, k, bodies), report.name(i, body)) for k, body in enumerate(drawn)]
        if len(drawn) < len(bodies):
            told.append(sentence(report, i, f"The plots show the first {len(drawn)} of {len(bodies)} {many}"))
    return [legend(items), *told]


def _lines(report: Report, pick: Pick, value: Union[str, None], over_time: bool) -> "list[Line]":
    """The lines of one value; of None, the ways in plan. Without those that have no points."""
    lines = []
    for i, run in enumerate(report.runs):
        bodies = pick(run)
        for k, body in enumerate(report.drawn(bodies)):
            colour, dash = report.style_of(i, k, bodies)
            line = Line(body.x, body.y, colour, dash) if value is None else Line(body.time if over_time else body.way, body.values[value], colour, dash)
            if body.count and line.any() and (over_time or body.way[-1] > 0):
                lines.append(line)
    return lines


def _values(report: Report, pick: Pick, value: Any) -> "list[Block]":
    """Two plots: over the way and over time."""
    key, name, unit, (low, high), zero_is_none, why = value
    found = []
    for over_time in (False, True):
        lines = _lines(report, pick, key, over_time)
        if not lines or (zero_is_none and not any((np.nan_to_num(line.y, posinf=0, neginf=0) != 0).any() for line in lines)):
            continue
        found.append(Block("svg", plots.draw(Plot(f"{name} over {'time' if over_time else 'the way'}", "time, s" if over_time else "way, m", f"{name}{unit}", lines, low=low, high=high))))
    return found if found or why is None else [sentence(report, None, why)]


def _missing(report: Report, pick: Pick, text: str) -> "list[Block]":
    """Names the folders without rows."""
    return [sentence(report, i, text) for i, run in enumerate(report.runs) if not pick(run)]


def _no_energy(report: Report) -> "list[Block]":
    told = []
    for i, run in enumerate(report.runs):
        drawn = report.drawn(run.objects)
        unknown = sum(1 for body in drawn if not math.isfinite(body.values["energy"][0]))
        if unknown:
            told.append(sentence(report, i, f"No energy for {unknown} of these objects: the rows do not tell how far belts turn, nor wheels of vehicles that an older furrow drove"))
    return told


def _energy_table(report: Report, pick: Pick, told: energy.Told) -> "list[Block]":
    shown = [(i, run, body) for i, run in enumerate(report.runs) for body in report.drawn(pick(run)) if body.count > 1]
    if not shown:
        return []
    rows = [(name, [short(value) for value in values]) for name, values in energy.columns([(run, body) for _, run, body in shown], told)]
    return [table(["from the first row to the last", *(f"{run.folder}: {body.name}" if report.several else body.name for _, run, body in shown)], rows)]


def _objects(run: Run) -> "list[Body]":
    return run.objects


def objects(report: Report) -> "tuple[Section, list[Section]]":
    """Curves of objects.csv, and their table."""
    title = "Sinkage, slip, drawbar pull, torque, energy"
    if not any(run.objects for run in report.runs):
        return Section("curves", title, [sentence(report, None, "No curves: there are no rows of objects.csv; set output.forces in the scene, if its model computes forces (scm)")]), []
    slope = report.any_slope()
    drawn = [block for value in OF_OBJECTS if slope or value[0] not in ("traction", "grade") for block in _values(report, _objects, value)]
    drawn += _no_energy(report) + _missing(report, _objects, "No rows of objects.csv")
    blocks = [*legend_of(report, _objects), Block("plots", items=drawn)]
    blocks.append(small("The way is that of the object's centre, seen from above. Slip beyond -1 and 1 is drawn at -1 and 1. Torque is what turns a wheel. Where curves lie on each other, as those of "
                        "the two wheels of an axle on level ground, the one that the legend names first is on top." + ("" if report.several else " Of a left and a right side with one colour, the right "
                        "one is dashed.")))
    blocks.append(small("Traction is the soil's force on the object along the ground, in the direction of the way. Grade resistance is the part of it that carries the weight up the slope: the weight "
                        "times the sine of the slope, below 0 downhill. Drawbar pull is traction less grade resistance. The weight is the object's load; of an object without a load, such as a wheel "
                        "of a vehicle, it is the soil's upward force." if slope else "Drawbar pull is the soil's force on the object along the ground, in the direction of the way. These ways are "
                        "level: less than 2 % of the weight acts along them."))
    if any(run.members("vehicles") for run in report.runs):
        blocks.append(small("A vehicle that drives itself at constant speed on level ground has a drawbar pull near 0, summed over its wheels. What its plot shows then is noise."))
    figures = _energy_table(report, _objects, energy.of_object)
    if figures:
        figures.append(small("Work of the torque = energy into the soil + work of the drawbar pull + work that lifts the weight. The table has the whole drive, with its run-up; the results have the "
                             "last quarter. The pull's work is below 0 where the object is pushed or towed. The part by slip is slip times the work of the torque. Tractive efficiency is the work of "
                             "pull and lifting over that of the torque."))
    return Section("curves", title, blocks), [Section("curves-table", "Where the energy of objects went", figures)] if figures else []


def _vehicles(run: Run) -> "list[Body]":
    return run.vehicles


def _actuators(run: Run) -> "list[Body]":
    return run.actuators


def vehicles(report: Report) -> "tuple[list[Section], list[Section]]":
    """Curves of vehicles.csv and of actuators, and their table. No section without a vehicle."""
    if not any(run.members("vehicles") for run in report.runs):
        return [], []
    if not any(run.vehicles for run in report.runs):
        return [Section("vehicles", "Vehicles", [sentence(report, None, "No curves of vehicles: there are no rows of vehicles.csv; set output.vehicles in the scene")])], []
    drawn = [block for value in OF_VEHICLES for block in _values(report, _vehicles, value)]
    blocks = [*legend_of(report, _vehicles, "vehicles"), Block("plots", items=drawn + _missing(report, _vehicles, "No rows of vehicles.csv"))]
    if any(run.actuators for run in report.runs):
        blocks += [*legend_of(report, _actuators, "actuators"), Block("plots", items=[block for value in OF_ACTUATORS for block in _values(report, _actuators, value)]),
                   small("Force of an actuator before its gear: N m at a hinge, N at a slide or a site.")]
    else:
        blocks.append(sentence(report, None, "No forces of actuators: vehicles.csv has none"))
    figures = _energy_table(report, _vehicles, energy.of_vehicle)
    if figures:
        figures.append(small("The table has the whole drive, with its run-up; the results have the last quarter. The weight is lifted by as much as the origin of the vehicle's root body rises. The "
                             "energy into the soil is that of the rows of objects.csv."))
    return [Section("vehicles", "Vehicles", blocks)], [Section("vehicles-table", "Where the work of vehicles went", figures)] if figures else []


# --- pull against slip ---

def _sweeps(body: Body) -> bool:
    """Whether slip changes while it moves, so that its pull over slip is more than a dot."""
    slip = body.values["slip"][np.isfinite(body.values["drawbar"])]
    slip = slip[np.isfinite(slip) & (np.abs(slip) <= 1)]
    return len(slip) > 10 and float(np.percentile(slip, 95) - np.percentile(slip, 5)) > SLIPS


def pull(report: Report) -> "tuple[list[Section], list[Section]]":
    """Of a tow test the load car's pull over slip; of objects on paths whose slip changes, their drawbar pull over it. No section without."""
    lines, items, rows, any_tow = [], [], [], False
    for i, run in enumerate(report.runs):
        tows = [(vehicle, energy.tow_points(run, vehicle)) for vehicle in report.drawn(run.vehicles)]
        place = 0
        for vehicle, points in tows:
            if points is None:
                continue
            any_tow = True
            style = report.style(i, place)
            order = np.argsort(points[:, 0])
            lines.append(Line(points[order, 0], points[order, 1], *style, dots=True))
            lines.append(Line(points[order, 0], points[order, 2], style[0], 2))
            items += [(*style, report.name(i, vehicle)), (style[0], 2, f"{report.name(i, vehicle)}: soil on its wheels")]
            rows += [(f"{report.name(i, vehicle)}, {k + 1}", [short(float(value)) for value in points[k]]) for k in range(len(points))]
            place += 1
        for body in report.drawn([body for body in run.objects if not any(body.name.startswith(vehicle.name + ".") for vehicle in run.vehicles) and _sweeps(body)]):
            known = np.isfinite(body.values["drawbar"]) & (np.abs(body.values["slip"]) <= 1)
            every = max(1, int(known.sum()) // 300)
            style = report.style(i, place)
            lines.append(Line(body.values["slip"][known][::every], body.values["drawbar"][known][::every], *style, dots="alone"))
            items.append((*style, report.name(i, body)))
            place += 1
    if not lines:
        return [], []
    plot = Plot("Pull over slip", "slip, share of 1", "pull, N", lines, one_scale=False)
    blocks = [legend(items), Block("wide", items=[Block("svg", plots.draw(plot))])]
    if any_tow:
        blocks.append(small("A dot is the mean over the last second of a time in which the control of the actuator tow stays: the load car's pull, over the mean slip of the wheels. Beside it is the soil's "
                            "force on all wheels along the way. Where the ground is level and the speed constant, both are the same."))
    else:
        blocks.append(small("Each dot is a row of objects.csv."))
    tables = [Section("pull-table", "Pull over slip, table", [table(["held speed", "slip", "pull, N", "soil on its wheels, N"], rows)])] if rows else []
    return [Section("pull", "Pull against slip", blocks)], tables


# --- ways ---

def ways(report: Report) -> "list[Section]":
    """All ways in one plot: for several drives, and for one drive without a map."""
    if not report.several and report.maps[0].png is not None:
        return []
    lines = _lines(report, Run.best_ways, None, False)
    if not lines:
        text = "No ways: nothing moved" if any(run.best_ways() for run in report.runs) else "No ways: run.json has none, and there are no rows of objects.csv or vehicles.csv"
        return [Section("ways", "Ways, seen from above", [sentence(report, None, text)])]
    profiles = [(i, rut.ends) for i, rut in enumerate(report.ruts) if rut.ends is not None]
    lines += [Line(ends[:, 0], ends[:, 1], i if report.several else COLOURS - 1, 2, dots=True) for i, ends in profiles]
    plot = Plot("Ways, seen from above", "east, m", "north, m", lines, zero=False, one_scale=True)
    blocks = [*legend_of(report, Run.best_ways), Block("wide", items=[Block("svg", plots.draw(plot))])]
    return [Section("ways", "Ways, seen from above", blocks + ([small("A dotted line between two dots shows where the rut profile lies.")] if profiles else []))]


# --- digging ---

CYCLE_HEAD = ["cycle", "fills from, s", "to, s", "at x, y, m", "brought, m3", "brought, kg", "fill, share of 1", "energy of digging, J", "energy, J/m3", "held for, s", "over, m", "dumped from, s",
              "to, s", "at x, y, m", "dumped, m3"]


def _cycle_cells(digger: digging.Digger, cycle: digging.Cycle) -> "list[Any]":
    body, brought, spent = digger.body, digger.brought_in(cycle), digger.spent_in(cycle)

    def place(row: int) -> Place:
        return Place(f"{body.x[row]:.2f}, {body.y[row]:.2f}")

    def at(row: int) -> Any:
        return short(float(body.time[row]))

    dumped = [at(cycle.dumps), at(cycle.emptied), place(cycle.fallen), short(float(digger.volume[cycle.held] - digger.volume[cycle.end]))]
    return [at(cycle.fills), at(cycle.holds), place(cycle.half), short(brought), short(float(digger.weight[cycle.held] - digger.weight[cycle.low]) / digger.gravity),
            short(float(digger.volume[cycle.held]) / digger.capacity), short(spent), short(spent / brought if brought > 0 else math.nan),
            short(float(body.time[cycle.dumps] - body.time[cycle.holds])), short(float(body.way[cycle.dumps] - body.way[cycle.holds])), *(dumped if cycle.dumped else [None] * 4)]


def _digging_tables(report: Report, own: "list[digging.Digger]") -> "list[Block]":
    names = [f"{report.runs[each.run].folder}: {each.body.name}" if report.several else each.body.name for each in own]
    figures = [(rows[0][0], [value for _, value in rows]) for rows in zip(*(each.figures() for each in own))]
    blocks = [table(["of the whole drive", *names], [(name, [short(value) for value in values]) for name, values in figures if any(math.isfinite(value) for value in values)])]
    rows = [(f"{name}, {k + 1}", _cycle_cells(each, cycle)) for name, each in zip(names, own) for k, cycle in enumerate(each.cycles)]
    blocks.append(table(CYCLE_HEAD, rows) if rows else sentence(report, None, "No cycles: nothing was aboard in any row"))
    return blocks + [sentence(report, each.run, f"The table and the sums have the first {digging.CYCLES} of {each.count} cycles of {each.body.name}") for each in own if each.count > digging.CYCLES]


def diggings(report: Report) -> "tuple[list[Section], list[Section]]":
    """What bodies carried, how hard they cut, and their cycles. No section where nothing carries."""
    carries = [run.at("volume.carried") is not None for run in report.runs]
    if not any(carries):
        return [], []
    blocks: "list[Block]" = []
    own: "list[digging.Digger]" = []
    for i, run in enumerate(report.runs):
        found, left = digging.diggers(run, i, report.most, lambda place, i=i: report.style(i, place))
        own += found
        if left:
            blocks.append(sentence(report, i, f"This section shows the first {len(found)} of {len(found) + left} bodies that carry"))
        if carries[i] and not found:
            blocks.append(sentence(report, i, "No digging: objects.csv has no rows of what is aboard; set output.forces in the scene"))
    if not own:
        return [Section("digging", "Digging", blocks)], []
    drawn = []
    for name, unit, values in OF_DIGGERS:
        lines = [line for line in (Line(each.body.time, values(each), *each.style) for each in own) if line.any()]
        if lines:
            drawn.append(Block("svg", plots.draw(Plot(f"{name} over time", "time, s", f"{name}{unit}", lines))))
    blocks += [legend([(*each.style, report.name(each.run, each.body)) for each in own]), Block("plots", items=drawn)]
    blocks.append(small("The cutting force is the soil's force on the body without the weight of what is aboard. A body digs where its work on the soil grows from one row to the next. In a cycle the volume "
                        "aboard rises from a low to a peak and falls again; rises and falls of less than a tenth of the most aboard are part of what they interrupt. Behind the peak it holds its load where "
                        "the volume stays within a twentieth for the longest time. What it holds then is what it brought; the rest was spilled. It is dumped while 99 to 1 % of that is aboard. The places "
                        "are where half of it was. The energy of digging is the body's work on the soil from the low before to where it begins to hold. It does not have what lifts the load."))
    if all(math.isfinite(each.capacity) for each in own):
        blocks.append(small("The struck capacity is the volume between the body's upper envelope and a straightedge that rests on it, along and across, at level attitude. A heap makes the fill larger than 1."))
    else:
        blocks.append(sentence(report, None, "No fill where there is no struck capacity: nothing of such a body, as of a plate or a blade, stands up around a hollow, or run.json does not tell it"))
    if not all(math.isfinite(each.spent) for each in own):
        blocks.append(sentence(report, None, "No energy of digging for a body whose work the rows do not tell"))
    return [Section("digging", "Digging", blocks)], [Section("digging-table", "Digging, tables", _digging_tables(report, own))]
