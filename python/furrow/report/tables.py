"""The tables of a report: a row for each figure, a column for each folder."""
import math
from typing import Any, Union

from furrow.report import energy
from furrow.report.blocks import Block, Cell, Section, any_value, folders, number, sentence, short, small, table
from furrow.report.run import Report, Run

NAMES_MOST = 20000  # settings, or objects, of a folder that a table shows
OBJECTS = 100       # of a drive that the table of means shows
Row = "tuple[str, list[Cell]]"
Fact = "tuple[str, str, float]"  # a row's name, where run.json has it, and the unit in which it is shown

RUN = [("ended", "ended", 1), ("steps", "steps", 1), ("simulated, s", "simulated", 1), ("resumed from step", "resumed_from", 1), ("scene", "scene.file", 1), ("hash of the scene", "scene.hash", 1),
       ("store", "store.file", 1), ("base store", "store.base", 1), ("hash of the base store", "store.base_hash", 1), ("spacing of posts, m", "spacing", 1), ("working level", "working_level", 1),
       ("furrow", "version", 1), ("sun of pictures: azimuth, degrees", "sun.azimuth", 1), ("sun of pictures: height, degrees", "sun.height", 1),
       ("sun's azimuth at the end, degrees", "sun.azimuth_at_end", 1), ("sun's height at the end, degrees", "sun.height_at_end", 1)]
OF_OBJECTS = [("distance, m", "distance", 1), ("sinkage, mm", "sinkage", 1e-3), ("load, N", "load", 1), ("slip", "slip", 1), ("path samples without ground", "skipped", 1)]
OF_VEHICLES = [("mass, kg", "mass", 1), ("distance, m", "distance", 1), ("work, J", "work", 1), ("kinetic energy, J", "kinetic", 1), ("settled after, s", "settled_after", 1),
               ("arrived", "arrived", 1), ("stuck since, s", "stuck_since", 1)]
COMPUTATION = [("wall clock, s", "seconds", 1), ("simulated time / wall clock", "rtf", 1), ("start-up, s", "warm_up.seconds", 1), ("cache slots", "cache.slots", 1),
               ("tiles touched", "cache.touched", 1), ("hits", "cache.hits", 1), ("misses", "cache.misses", 1), ("prefetched", "cache.prefetched", 1), ("late", "cache.late", 1),
               ("evictions", "cache.evictions", 1), ("written back", "cache.writebacks", 1), ("stalls", "cache.stalls", 1), ("time in stalls, ms", "cache.stall_ms", 1),
               ("peak memory, MB", "memory.rss_peak", 1e6), ("GPU memory, MB", "memory.gpu_bytes", 1e6), ("read, MB", "io.bytes_read", 1e6), ("written, MB", "io.bytes_written", 1e6),
               ("commits", "io.commits", 1), ("pictures", "view.images", 1), ("ranks", "ranks.count", 1), ("tiles moved between ranks", "ranks.tiles_moved", 1),
               ("moved between ranks, MB", "ranks.bytes_moved", 1e6), ("balance of ranks", "ranks.balance", 1), ("GL renderer", "gl.renderer", 1), ("GL vendor", "gl.vendor", 1),
               ("GL version", "gl.version", 1), ("software GL", "gl.software", 1)]
ELECTRIC = [("current at the end, A", "current", 1), ("voltage at the end, V", "voltage", 1), ("torque at the end, N m", "torque", 1), ("energy taken, kJ", "taken", 1e3),
            ("energy given back, kJ", "recovered", 1e3), ("work of the motor, kJ", "mechanical", 1e3), ("heat of its windings, kJ", "heat", 1e3)]
ENGINE = [("engine speed at the end, rpm", "engine_speed", 1), ("gear at the end", "gear", 1), ("work of the engine, kJ", "engine_work", 1e3),
          ("lost in clutch, converter and differentials, kJ", "driveline_loss", 1e3), ("kinetic energy of the engine at the end, kJ", "engine_kinetic", 1e3)]
BRAKES = [("energy that the brakes took, kJ", "brake_loss", 1e3)]
STEPS = [("median, ms", "step_ms.p50"), ("95th percentile, ms", "step_ms.p95"), ("99th percentile, ms", "step_ms.p99"), ("slowest, ms", "step_ms.max")]
VOLUME = [("removed, m3", "volume.removed", 1), ("raised, m3", "volume.raised", 1), ("net (raised - removed), m3", "volume.net", 1), ("compacted, m3", "volume.compacted", 1),
          ("added, m3", "volume.added", 1), ("removed, fixed-point units", "volume.quanta.removed", 1), ("raised, fixed-point units", "volume.quanta.raised", 1),
          ("net, fixed-point units", "volume.quanta.net", 1), ("compacted, fixed-point units", "volume.quanta.compacted", 1), ("added, fixed-point units", "volume.quanta.added", 1)]
ABOARD = [("carried by bodies, m3", "volume.carried", 1), ("carried by bodies, fixed-point units", "volume.quanta.carried", 1)]
THROWN = [("thrown, kg", "thrown.mass", 1), ("of that in flight, kg", "thrown.in_flight_mass", 1), ("thrown, fixed-point units", "thrown.quanta.thrown", 1),
          ("landed, fixed-point units", "thrown.quanta.landed", 1), ("in flight, fixed-point units", "thrown.quanta.in_flight", 1), ("lost, fixed-point units", "thrown.quanta.lost", 1)]
# Units of a soil's numbers, as docs/SCENE.md has them.
UNITS = {"bekker_kc": "N/m^(n+1)", "bekker_kphi": "N/m^(n+2)", "cohesion": "Pa", "friction_angle": "degrees", "janosi_shear": "m", "elastic_stiffness": "Pa/m", "damping": "Pa s/m",
         "density": "kg/m3", "unit_weight": "N/m3", "face_strength": "N/m3", "face_cohesion": "Pa", "repose": "degrees", "theta_in": "degrees", "theta_out": "degrees", "theta_stop": "degrees",
         "thickness": "m"}


def facts(report: Report, wanted: "list[Any]") -> "list[Any]":
    """A row for each fact that a folder has."""
    rows = []
    for name, path, unit in wanted:
        values = [run.at(path) for run in report.runs]
        if any(value is not None for value in values):
            rows.append((name, [any_value(value, unit) for value in values]))
    return rows


def what_ran(report: Report) -> Section:
    blocks = [table(folders(report, ""), facts(report, RUN))]
    blocks += [sentence(report, i, "run.json has no settings of the scene: an older furrow made it") for i, run in enumerate(report.runs) if not isinstance(run.at("scene.values"), dict)]
    return Section("run", "What was run", blocks)


# --- settings ---

def _base(run: Run, hashed: bool) -> "Union[str, None]":
    """The terrain: its hash if each run has one, else the path of its store: another path may be a copy."""
    return run.text("store.base_hash") if hashed else run.text("store.base") or run.text("store.file")


def _base_cell(run: Run, hashed: bool) -> Cell:
    path, found = _base(run, False), _base(run, hashed)
    return f"{(path or '').rpartition('/')[2]} ({found})" if hashed and found is not None else found


def settings_rows(report: Report, only_different: bool) -> "list[Any]":
    """A row for each setting, or for each that differs, also the terrain."""
    rows: "list[Any]" = []
    hashed = all(run.text("store.base_hash") is not None for run in report.runs)
    if only_different and len({_base(run, hashed) for run in report.runs}) > 1:
        rows.append(("base store", [_base_cell(run, hashed) for run in report.runs]))
    seen: "set[str]" = set()
    for run in report.runs:
        for key in list(run.members("scene.values"))[:NAMES_MOST]:
            values = [other.setting(key) for other in report.runs]
            if key not in seen and not (only_different and len(set(values)) == 1):
                rows.append((key, values))
            seen.add(key)
    return rows


def _too_many(report: Report) -> "list[Block]":
    return [sentence(report, i, f"The table shows the first {NAMES_MOST} settings") for i, run in enumerate(report.runs) if len(run.members("scene.values")) > NAMES_MOST]


def began_on(report: Report) -> "list[Block]":
    """Of each drive that began on ruts of earlier ones how deep these were: then drives of the same scene differ."""
    blocks = []
    for i, run in enumerate(report.runs):
        deepest, highest = run.number("store.began_on.deepest"), run.number("store.began_on.highest")
        if math.isfinite(deepest):
            heaps = f" and heaps up to {1e3 * highest:.3g} mm high" if highest > 0 else ""
            blocks.append(sentence(report, i, f"The drive began on ground that earlier drives had left, with ruts up to {1e3 * deepest:.3g} mm deep{heaps}"))
    return blocks


def differences(report: Report) -> "list[Section]":
    if not report.several:
        return []
    rows = settings_rows(report, True)
    hashes = [run.text("scene.hash") for run in report.runs]
    same = None not in hashes and len(set(hashes)) == 1
    blocks = [table(folders(report, "setting"), rows)] if rows else [Block("p", "No setting differs." if same else
              "No setting differs, but the hashes of the scenes differ. Either a file that a scene names differs, or run.json has no settings.")]
    return [Section("differences", "Settings that differ", blocks + _too_many(report) + began_on(report))]


def settings(report: Report) -> Section:
    rows = settings_rows(report, False)
    blocks = [table(folders(report, "setting"), rows)] if rows else [Block("p", "run.json has no settings of the scene: an older furrow made it.")]
    return Section("settings", "All settings", [Block("details", "Every setting of the scene, with those of --set", blocks + _too_many(report))])


# --- soils ---

def soils(report: Report) -> Section:
    own = [[soil for soil in (run.at("soils") if isinstance(run.at("soils"), list) else run.members("soils").values()) if isinstance(soil, dict)] for run in report.runs]
    each: "list[dict[str, Any]]" = []
    for soil in (soil for soils_ in own for soil in soils_):
        if soil not in each:
            each.append(soil)
    if not each:
        return Section("soils", "Soils", [Block("p", "No soil: the drive's model uses none.")])
    head: "list[Any]" = ["number"]
    for soil in each:
        having = [run.folder for run, soils_ in zip(report.runs, own) if soil in soils_]
        name = soil.get("name")
        name = name if isinstance(name, str) else "unnamed"
        head.append((name, having) if len(having) < len(report.runs) else name)  # if not all folders have this soil, names those that have it
    keys = list(dict.fromkeys(key for soil in each for key, value in soil.items() if key != "name" and value is not None))
    rows = []
    for key in keys:
        values = [soil.get(key) for soil in each]  # a soil that lies below is told by its name
        rows.append((f"{key}, {UNITS[key]}" if key in UNITS else key, [any_value(value.get("name") if isinstance(value, dict) else value) for value in values]))
    return Section("soils", "Soils", [table(head, rows)])


# --- results ---

def _names(report: Report, path: str) -> "list[str]":
    return list(dict.fromkeys(name for run in report.runs for name in list(run.members(path))[:NAMES_MOST]))


def named(report: Report, path: str, wanted: "list[Any]") -> "list[Any]":
    """A row for each name and figure of all objects or vehicles."""
    rows = []
    for name in _names(report, path):
        for label, key, unit in wanted:
            values = [run.named(path, name, key) for run in report.runs]
            if any(value is not None for value in values):
                rows.append((f"{name}: {label}", [any_value(value, unit) for value in values]))
    return rows


def _figure_rows(name: str, found: "list[list[tuple[str, float]]]") -> "list[Any]":
    """found: of each run its figures, by name and value."""
    rows = [(each[0][0], [value for _, value in each]) for each in zip(*found)]
    return [(f"{name}: {label}", [number(value) for value in values]) for label, values in rows if any(math.isfinite(value) for value in values)]


def _mean_rows(report: Report, name: str, vehicle: bool) -> "list[Any]":
    rows = []
    both = vehicle and any({"left", "right"} <= {run.sides[body.name] for body in run.objects if body.name.startswith(name + ".")} for run in report.runs)
    for figure in energy.FIGURES:
        if figure.value == "traction" and not report.any_slope():
            continue
        for side in ("", "left", "right") if both else ("",):
            found = [energy.mean(run, name, vehicle, figure, side) for run in report.runs]
            wheels = f"its {side} wheels" if side else "its wheels"
            means = "" if not vehicle else f", sum of {wheels}" if figure.force else f" of {wheels}"
            if any(math.isfinite(value) for value in found):
                rows.append((f"{name}: mean {figure.name}{means}{figure.unit}", [number(value, figure.scale) for value in found]))
    return rows + _figure_rows(name, [energy.Spent(run, name, vehicle).figures() for run in report.runs])


def means(report: Report) -> "list[Block]":
    if not any(run.objects for run in report.runs):
        return [sentence(report, None, "No means of slip, sinkage and forces: there are no rows of objects.csv")]
    rows = [(label, [number(part * run.ends_at()) for run in report.runs]) for label, part in (("rows of objects.csv from t, s", energy.PART), ("to t, s", 1))]
    for name in _names(report, "vehicles"):
        rows += _mean_rows(report, name, True)
    for name in dict.fromkeys(body.name for run in report.runs for body in run.objects[:OBJECTS]):
        rows += _mean_rows(report, name, False)
    blocks = [table(folders(report, "means over the last quarter of the time"), rows)]
    if any(len(run.objects) > OBJECTS for run in report.runs):
        blocks.append(sentence(report, None, f"The table shows the first {OBJECTS} objects of each drive"))
    blocks.append(small("Each figure is the mean of the rows of objects.csv in that time. Wheels of a vehicle are its soil geoms. Torque is what turns the wheel: the soil's moment about the axle, "
                        "turned round. Vertical force is the soil's force upward. Drawbar pull is explained below its plot. Power, energy for each metre and tractive efficiency are those of the "
                        "same rows: efficiency is the work of traction over that of the axles. The actuators' work is the sum over all of them; one that holds the vehicle back has work below 0."))
    return blocks


def drives(report: Report) -> "list[Block]":
    """Electric drives, engines and brakes. Nothing without any."""
    rows: "list[Any]" = []

    def add(label: str, found: "list[Any]", wanted: "list[Any]") -> None:
        each = [part if isinstance(part, dict) else {} for part in found]
        rows.extend((f"{label}: {name}", [number(part[key], unit) if isinstance(part.get(key), float) else None for part in each]) for name, key, unit in wanted)

    for vehicle in _names(report, "vehicles"):
        own = [run.members("vehicles").get(vehicle) for run in report.runs]
        parts = [each if isinstance(each, dict) else {} for each in own]
        if any("powertrain" in part for part in parts):
            add(vehicle, [part.get("powertrain") for part in parts], ENGINE)
        if any("brake_loss" in part for part in parts):
            add(vehicle, parts, BRAKES)
        motors = [part["drives"] if isinstance(part.get("drives"), dict) else {} for part in parts]
        for name in dict.fromkeys(name for each in motors for name in each):
            add(f"{vehicle} {name}", [each.get(name) for each in motors], ELECTRIC)
    return [table(folders(report, "drives"), rows)] if rows else []


def results(report: Report) -> Section:
    whole = named(report, "objects", OF_OBJECTS) + named(report, "vehicles", OF_VEHICLES)
    return Section("results", "Results", [*means(report), table(folders(report, "the whole drive"), whole), *drives(report), table(folders(report, "the computation"), facts(report, COMPUTATION))])


def steps(report: Report) -> Section:
    return Section("steps-table", "Step times, table", [table(folders(report, ""), [(name, [short(run.number(path)) for run in report.runs]) for name, path in STEPS])])


def _balance(run: Run) -> float:
    """0 to the unit where volume is conserved. nan: the model reads no soils, so it need not be. A run of an older furrow has no added soil."""
    if not run.at("soils"):
        return math.nan
    units = {key: run.number(f"volume.quanta.{key}") for key in ("net", "compacted", "carried", "in_flight", "added")}
    aboard = sum(units[key] for key in ("carried", "in_flight") if units[key] > 0)
    return units["net"] + units["compacted"] + aboard - (0 if math.isnan(units["added"]) else units["added"])


def volume(report: Report) -> Section:
    carries, throws = (any(run.at(path) is not None for run in report.runs) for path in ("volume.carried", "thrown"))
    rows = facts(report, VOLUME) + (facts(report, ABOARD) if carries else []) + (facts(report, THROWN) if throws else [])
    if any(run.at("soils") for run in report.runs):
        parts = "net + compacted" + (" + carried" if carries else "") + (" + in flight" if throws else "")
        rows.append((f"{parts} - added, fixed-point units", [number(_balance(run)) for run in report.runs]))
    return Section("volume-table", "Volume balance, table", [table(folders(report, ""), rows), small(("A fixed-point unit is 2", "-20",
                   " m of height at one post. If the model conserves volume, net + compacted - added is 0."))])
