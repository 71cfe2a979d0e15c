"""The studies of bench/accuracy.py that the command measures: force against time, and knobs of bodies, vehicles and the cache.

A study drives its truth once, and then its settings in turn, so that what else the machine does falls on all alike. Each must give the same
result every time. Ways of some metres: a time a metre is that of the steps without the longest, which is the first and reads the tiles."""
import dataclasses
import hashlib
import json
import math
import pathlib
import re
import typing

import lanes
import vehicles
from converge_cases import CHRONO, fan
from pages import Told

HERE = pathlib.Path(__file__).resolve().parent
COARSEST = 0.16
SPACINGS = (0.08, 0.04, 0.02, 0.01, 0.005)  # m; a quick run has the first three, and the fourth is its truth
DEFAULT = 0.01                              # what `furrow rig` takes for this wheel
FINEST = 0.0025
LOAD = 600.0
WHEEL = {"radius": 0.25, "width": 0.2, "load": LOAD, "slip": 0.2}
BARS = WHEEL | {"slip": 0.3, "grousers": 18, "grouser_height": 0.02}
BLADE = WHEEL | {"shape": "box: {size: [0.06, 0.6, 0.4]}", "sink": 0.1, "load": None, "pitch": 30.0}
BODIES = {"wheel": WHEEL, "bars": BARS, "blade": BLADE}
TYRE = f"tyre: {{stiffness: 25000, load: {LOAD!r}}}"
SOFT = {"radius": 0.5, "width": 0.4, "load": 5000.0, "slip": 0.2, "length": 2.4, "speed": 0.4}  # Chrono's wheel
STEPS = (0.01, 0.005, 0.002, 0.001)         # s, of a vehicle
TRIANGLES = (80, 320, 1280, 5120)           # of a ball; the last is the truth
SLOTS = (8, 16, 32, 256)
PLACES = (1.0, 1.6)                         # m of the way, between which forces are taken


@dataclasses.dataclass
class Setting:
    """run: makes the drive, and returns (its result, ms, bytes or None). Results are compared with the truth's by the study."""
    knobs: dict
    default: bool
    run: typing.Callable


def in_turn(settings, runs, progress):
    """[(result, [ms of each run], bytes)] of each setting."""
    found = [None] * len(settings)
    for turn in range(runs):
        for i, setting in enumerate(settings):
            progress(setting.knobs)
            result, ms, size = setting.run()
            if not (math.isfinite(ms) and ms > 0):
                raise Told(f"{setting.knobs}: took {ms} ms; mend the bench")
            if turn == 0:
                found[i] = (result, [ms], size)
            elif result != found[i][0]:
                raise Told(f"{setting.knobs}: the same drive gave another result; that is against law 10, so look for the reason")
            else:
                found[i][1].append(ms)
    return found


def line(study, setting, truth, runs, off, cost, gl, size=None, size_of="", more=None):
    """off: (what, value, floor), or None. more: further columns."""
    times = sorted(runs)
    middle = (times[(len(times) - 1) // 2] + times[len(times) // 2]) / 2
    made = {"bench": "accuracy", "study": study, "knobs": setting.knobs, "default": setting.default, "truth": truth, "ms_step": middle, "ms_runs": runs, "cost": cost,
            "bytes": size, "bytes_of": size_of, "gl": gl}
    if off is not None:
        what, value, floor = off
        if not (math.isfinite(value) and math.isfinite(floor)):
            raise Told(f"{study} {setting.knobs}: {what} is {value}; the body sank, or the bench is wrong")
        made["off"] = {"what": what, "value": value, "floor": floor}
    return made | ({"more": more} if more else {})


class Knobs:
    def __init__(self, furrow, folder, runs, quick, progress):
        self.furrow, self.folder, self.runs, self.quick, self.progress = str(furrow), str(folder), runs, quick, progress
        self.gl = ""

    def spacings(self):
        """(those that are measured, the truth's)"""
        return (SPACINGS[:3], SPACINGS[3]) if self.quick else (SPACINGS, FINEST)

    # --- one body ---

    def steady(self, way, spacing, soil, extra, places=PLACES):
        """Means of each lane, and ms a metre."""
        driven = lanes.drive(self.furrow, lanes.ground(self.furrow, self.folder, COARSEST), self.folder, way, spacing, soil, extra)
        self.gl = (driven.run["gl"] or {}).get("renderer", "")
        steps, longest = driven.run["steps"], driven.run["step_ms"]["max"]
        whole = 1e3 * steps / driven.run["steps_per_second"]["mean"]
        found = [lanes.steady(lane, driven, *places) for lane in way]
        if not all(found):
            raise Told(f"{way[0].name}: has no rows at its way's end; mend the bench")
        return found, (whole - longest) * steps / (steps - 1) / way[0].length

    def forces(self, keys, spacing, soil="name: dry_sand", extra="", places=PLACES):
        """Means of lanes in three directions, on the lattice and off it."""
        return self.steady(fan(**keys), spacing, soil, extra, places)[0]

    def bodies(self, study, of, truth_of, soil="name: dry_sand", extra="", chosen=DEFAULT, spacings=None, places=PLACES):
        """of: {knob's value: (keys, extra)}, each at all spacings. truth_of: of a value, the one that is the truth. Yields lines."""
        (knob, values), (measured, finest) = of, spacings or self.spacings()
        truths = {}
        for name in dict.fromkeys(map(truth_of, values)):
            keys, own = values[name]
            at = [self.mean(self.forces(keys, spacing, soil, extra + own, places)) for spacing in (finest, measured[-1])]
            truths[name] = at[0], abs(at[0] - at[1])
        settings, off = [], []
        for name, (keys, own) in values.items():
            for spacing in measured:
                drawbar, floor = truths[truth_of(name)]
                scale = keys["load"] or abs(drawbar)
                rows = self.forces(keys, spacing, soil, extra + own, places)
                off.append((max(abs(row["drawbar"] - drawbar) for row in rows) / scale * 100, floor / scale * 100,
                            {"load off, %": max(abs(row["fz"] / keys["load"] - 1) for row in rows) * 100} if keys["load"] else None))

                def run(keys=keys, own=own, spacing=spacing):
                    (row,), ms = self.steady([lanes.Lane("one", **keys)], spacing, soil, extra + own, places)
                    return row["drawbar"], ms, None
                settings.append(Setting({knob: name, "spacing": spacing}, spacing == chosen and name == truth_of(name), run))
        found = in_turn(settings, self.runs, lambda knobs: self.progress(study, knobs))
        for setting, (_, ms, _), (value, floor, more) in zip(settings, found, off):
            truth = f"{truth_of(setting.knobs[knob])} at posts of {finest:g} m"
            yield line(study, setting, truth, ms, ("drawbar off, % of the load (of a blade: of its force)", value, floor), "ms a metre", self.gl, more=more)

    @staticmethod
    def mean(rows):
        return sum(row["drawbar"] for row in rows) / len(rows)

    def force(self):
        yield from self.bodies("force", ("body", {name: (keys, "") for name, keys in BODIES.items()}), lambda name: name)

    def faces(self):
        yield from self.bodies("faces", ("faces", {"on": (BARS, ", faces: on"), "off": (BARS, ", faces: off")}), lambda _: "on")

    def tyres(self):
        yield from self.bodies("tyres", ("tyre", {"tyre": (WHEEL | {"more": TYRE}, ""), "rigid": (WHEEL, "")}), lambda _: "tyre")

    def force_soft(self):
        spacings = ((0.08, 0.04), 0.02) if self.quick else ((0.08, 0.04, 0.02, 0.01), 0.005)
        of = {"Furrow": (SOFT, ", normals: ground")}
        yield from self.bodies("force_soft", ("program", of), lambda name: name, CHRONO, chosen=0.02, spacings=spacings, places=(1.6, 2.4))
        yield from chrono()

    # --- a ball of triangles ---

    def mesh_triangles(self):
        """The truth is the mesh of four times the most triangles that are measured. The shape `sphere` has another law of its faces."""
        keys, spacing = {"radius": 0.2, "load": 300.0, "length": 1.6}, 0.02 if self.quick else 0.01
        *measured, finest = TRIANGLES[:3] if self.quick else TRIANGLES

        def drive(triangles):
            name = f"ball{triangles}.obj"
            (pathlib.Path(self.folder) / name).write_text(obj(*sphere(triangles, 0.2)))
            return self.ball(keys | {"shape": f"mesh: {{file: {name}}}"}, spacing)
        truth, half = drive(finest)()[0], drive(measured[-1])()[0]
        settings = [Setting({"triangles": triangles}, False, drive(triangles)) for triangles in measured]
        found = in_turn(settings, self.runs, lambda knobs: self.progress("mesh_triangles", knobs))
        for setting, (drawbar, ms, _) in zip(settings, found):
            off = ("force off, % of the load", abs(drawbar - truth) / keys["load"] * 100, abs(half - truth) / keys["load"] * 100)
            yield line("mesh_triangles", setting, f"{finest} triangles at posts of {spacing:g} m", ms, off, "ms a metre", self.gl)

    def ball(self, keys, spacing):
        def run():
            (row,), ms = self.steady([lanes.Lane("one", **keys)], spacing, "name: dry_sand", "")
            return row["drawbar"], ms, None
        return run

    # --- a vehicle ---

    def vehicle_step(self):
        folder, seconds = pathlib.Path(self.folder), 2 if self.quick else 5
        driver = "    driver: {path: {points: [[4, 16], [30, 16]], speed: 3}, steer: [steer_*], drive: [drive_*]}\n"

        def drive(step):
            text, count = re.subn(r'timestep="[^"]*"', f'timestep="{step!r}"', (vehicles.MODELS / "offroad.xml").read_text())
            if count != 1:
                raise Told("offroad.xml: has no time step of its own; mend the bench")
            (folder / "offroad.xml").write_text(text)
            scene = vehicles.SCENE.format(step=repr(step), end=seconds, gravity=9.81, spacing=0.0625 if self.quick else 0.03125, soil="sandy_loam_15",
                                          model=folder / "offroad.xml", x=4, y=16, yaw=0, driver=driver, rows=10)
            rows, _ = vehicles.drive(self.furrow, folder, scene, vehicles.plane(self.furrow, folder, 0))
            run = json.loads((folder / "out" / "run.json").read_text())
            self.gl = (run["gl"] or {}).get("renderer", "")
            return {round(row["t"], 4): [row[key] for key in "xyz"] for row in rows}, 1e3 * run["seconds"] / run["simulated"], None

        def apart(a, b):
            shared = sorted(set(a) & set(b))
            if len(shared) < 5 * seconds:
                raise Told("vehicle_step: rows of the drives are of other times; mend the bench")
            return 1e3 * math.sqrt(sum(math.dist(a[t], b[t]) ** 2 for t in shared) / len(shared))
        finest = 0.0005 if self.quick else 0.00025
        truth, half = drive(finest)[0], drive(2 * finest)[0]
        settings = [Setting({"time_step": step}, step == 0.002, lambda step=step: drive(step)) for step in (STEPS[:3] if self.quick else STEPS)]
        found = in_turn(settings, self.runs, lambda knobs: self.progress("vehicle_step", knobs))
        for setting, (rows, ms, _) in zip(settings, found):
            off = ("place of the vehicle off, RMS, mm", apart(rows, truth), apart(half, truth))
            yield line("vehicle_step", setting, f"steps of {finest * 1e3:g} ms", ms, off, "ms a simulated second", self.gl)

    # --- the cache ---

    def slots(self):
        folder = pathlib.Path(self.folder)
        store, scene, overlay = folder / "slots.furrow", folder / "slots.yaml", folder / "slots-over.furrow"
        side = 1025 if self.quick else 2049
        lanes.run(self.furrow, "synth", "-o", str(store), "--posts", f"{side}x{side}", "--spacing", "0.0625", "--kind", "ridged", "--relief", "2")
        most = side * 0.0625 - 6
        corners = [[6, 6], [most, 6], [most, most], [6, most], [6, 8], [most - 2, 8]]

        def drive(slots):
            scene.write_text(f"scene: 1\ntime_step: 0.02\nend_time: {sum(map(math.dist, corners, corners[1:])) / 8!r}\nredistribute: {{model: box}}\ncache: {{slots: {slots}}}\nobjects:\n"
                             f"  - {{name: w, shape: {{wheel: {{radius: 0.5, width: 0.4}}}}, sink: 0.1, path: {{points: {corners}, speed: 8}}}}\n")
            for name in (overlay, pathlib.Path(f"{overlay}-wal"), pathlib.Path(f"{overlay}-shm")):
                name.unlink(missing_ok=True)
            lanes.run(self.furrow, "drive", str(scene), "--store", str(store), "--overlay", str(overlay), "-o", str(folder / "slots-out"))
            run = json.loads((folder / "slots-out" / "run.json").read_text())
            self.gl = (run["gl"] or {}).get("renderer", "")
            lanes.run(self.furrow, "export", str(overlay), "-o", str(folder / "slots.png"), "--layer", "offset", "--height-range=-1,1")
            ground = hashlib.sha256((folder / "slots.png").read_bytes()).hexdigest()
            return (ground, run["volume"]["quanta"]["net"]), 1e3 / run["steps_per_second"]["mean"], sum(run["memory"]["plane_bytes"].values())
        settings = [Setting({"slots": slots}, slots == 256, lambda slots=slots: drive(slots)) for slots in SLOTS]
        found = in_turn(settings, self.runs, lambda knobs: self.progress("slots", knobs))
        if len({result for result, _, _ in found}) != 1:
            raise Told("slots: the ground depends on the number of slots, against law 10; look for the reason")
        for setting, (_, ms, size) in zip(settings, found):
            yield line("slots", setting, "256 slots", ms, None, "ms a step", self.gl, size, "slot planes")


STUDIES = ("force", "force_soft", "faces", "tyres", "mesh_triangles", "vehicle_step", "slots")


def measured(furrow, folder, runs, quick, progress, only=STUDIES):
    """Yields the lines of the studies. progress: is told (study, knobs)."""
    knobs = Knobs(furrow, folder, runs, quick, progress)
    for name in only:
        try:
            yield from getattr(knobs, name)()
        except (lanes.Failed, SystemExit) as error:  # vehicles.run ends so
            raise Told(f"{name}: {error}") from None


def chrono(path=HERE / "figures" / "chrono.json"):
    """What is known of Project Chrono's SCM for the wheel of `force_soft`. Its drawbar is compared with its own at the finest posts, which is another truth."""
    kept = json.loads(path.read_text())
    figures = kept["figures"]
    finest = figures["soft.1cm.drawbar"]["value"]
    for how, name in (("small_steps", "Chrono, steps of 1 ms"), ("long_steps", "Chrono, a step a post")):
        for cm in (4, 2, 1):
            made = line("force_soft", Setting({"program": name, "spacing": cm / 100}, False, None), f"{name}, at its posts of 1 cm", [figures[f"soft.{cm}cm.{how}.ms_a_metre"]["value"]],
                        ("drawbar off, % of the load (of a blade: of its force)", abs(figures[f"soft.{cm}cm.drawbar"]["value"] - finest) / SOFT["load"] * 100, 0)
                        if how == "small_steps" and cm > 1 else None, "ms a metre", "")
            yield made | {"ms_runs": [], "source": kept["source"]}


# --- meshes ---

def sphere(triangles, radius):
    """Corners and triangles of a ball: an icosahedron whose triangles are cut into four, until there are so many."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden), (0, -1, -golden), (0, 1, -golden),
               (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    corners = [tuple(n / math.hypot(*corner) for n in corner) for corner in corners]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    while len(faces) < triangles:
        middles, cut = {}, []

        def middle(a, b):
            key = min(a, b), max(a, b)
            if key not in middles:
                at = [(m + n) / 2 for m, n in zip(corners[a], corners[b])]
                middles[key] = len(corners)
                corners.append(tuple(n / math.hypot(*at) for n in at))
            return middles[key]
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            cut += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = cut
    if len(faces) != triangles:
        raise Told(f"a ball has 20, 80, 320 ... triangles, not {triangles}; mend the bench")
    return [tuple(radius * n for n in corner) for corner in corners], faces


def obj(corners, faces):
    return "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
