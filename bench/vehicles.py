#!/usr/bin/env python3
"""What must hold for vehicles over a long time, on rough ground and against each other. Prints a table; takes half an hour.

    bench/vehicles.py FURROW [--only rest|rough|speed|real|touch]... [--dem N41E001.hgt] [--minutes 10]

rest: vehicles are set down and left alone. Told: how far they drift in the last minute, and their kinetic energy at its end.
rough: the off-road vehicle drives at the longest time step over real ground whose posts lie 4 cm apart. Told: its energy, and
for how many rows each wheel is in the air.
speed: the same vehicle drives straight over level sand at 3 m/s. Told: the wall time of a metre, and simulated time over wall time.
real: it drives the same way with tyres, and a robot of twelve joints trots; faces of both are on. Told: simulated time over wall time, and over time of the
processor, beside what is asked. A busy machine changes the latter less. It is that of the last four seconds: a shorter drive is taken off.
touch: two such vehicles, driven at 1 and 0.5 m/s. The faster one pushes the other, or drives 10 m beside it. Told: the wall time of a step.
"""
import argparse
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import pages
import record

PARTS = ("speed", "real", "touch", "rest", "rough")
REAL_TIME = 5  # times real time that are asked of `real`
MODELS = pathlib.Path(__file__).parents[1] / "tools" / "scenes" / "vehicles"
ONE = pathlib.Path(__file__).parents[1] / "tests" / "vehicle" / "one_wheel.xml"
SCENE = """scene: 1
time_step: {step}
end_time: {end}
gravity: {gravity}
spacing: {spacing}
soil: {{name: {soil}}}
redistribute: {{model: scm}}
vehicles:
  - name: v
    model: {model}
    start: {{at: [{x}, {y}], yaw: {yaw}}}
    soil: [wheel*]
{driver}output: {{vehicles: {rows}, forces: {rows}}}
"""


def run(furrow, *arguments):
    """Runs furrow. Returns what it wrote to standard error; stops if it failed."""
    done = subprocess.run([str(furrow), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("%s: %s" % (" ".join(map(str, arguments)), done.stderr))
    return done.stderr


def plane(furrow, folder, degrees):
    """A store whose ground rises to the east."""
    store, raster = folder / ("plane%g.furrow" % degrees), folder / "plane.asc"
    if store.exists():
        return store
    row = " ".join("%.9g" % (100 + 0.25 * i * math.tan(math.radians(degrees))) for i in range(129))
    raster.write_text("ncols 129\nnrows 129\nxllcorner 0\nyllcorner 0\ncellsize 0.25\n" + (row + "\n") * 129)
    run(furrow, "import", raster, "-o", store, "--spacing", 0.25, "--max-error", 1e-5)
    return store


def braked(text):
    """The model with a stiff spring on each wheel instead of its motor: 0.2 MN m / rad, well damped."""
    wheels = re.findall(r'<joint name="((?:roll|turn)\w*)"', text)
    text = re.sub(r'(<joint name="(?:roll|turn)\w*")', r'\1 damping="2000" stiffness="200000"', text)
    return re.sub(r'<velocity (?:class="\w+" )?name="\w+" joint="(?:%s)"[^>]*/>' % "|".join(wheels), "", text)


def drive(furrow, folder, scene, store):
    path = folder / "scene.yaml"
    path.write_text(scene)
    overlay = folder / "over.furrow"
    overlay.unlink(missing_ok=True)
    run(furrow, "drive", path, "--store", store, "-o", folder / "out", "--overlay", overlay)
    with open(folder / "out" / "vehicles.csv", encoding="ascii") as file:
        rows = [{k: float(v) for k, v in row.items() if k != "name" and v != ""} for row in csv.DictReader(file)]
    return rows, json.loads((folder / "out" / "run.json").read_text())["vehicles"]["v"]


def rest(furrow, folder, kept, minutes):
    print("| vehicle | soil | slope | settled after, s | slid in all, mm | drift in the last minute, um/s | kinetic, J |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, model, soil, gravity in (("one wheel", ONE, "dry_sand", 9.81), ("four wheels", MODELS / "offroad.xml", "dry_sand", 9.81),
                                       ("six wheels", MODELS / "rover.xml", "lunar", 1.62)):
        (folder / "model.xml").write_text(braked(model.read_text()))
        for degrees in (0, 15, 20):
            store = plane(furrow, folder, degrees)
            scene = SCENE.format(step=0.002, end=60 * minutes, gravity=gravity, spacing=0.0625, soil=soil, model="model.xml", x=16.013, y=16.021,
                                 yaw=0, driver="", rows=1)
            rows, info = drive(furrow, folder, scene, store)
            first, last, before = rows[0], rows[-1], rows[-61]
            slid = math.dist([first[k] for k in "xyz"], [last[k] for k in "xyz"])
            drift = math.dist([before[k] for k in "xyz"], [last[k] for k in "xyz"]) / 60
            row = {"settled": (info["settled_after"], "s"), "slid": (1e3 * slid, "mm"), "drift": (1e6 * drift, "um/s"), "kinetic": (last["kinetic"], "J")}
            for key, (value, unit) in row.items():
                kept.add(f"{name.split()[0]}_{degrees}.{key}", value, unit)
            print("| %s | %s | %g | %.2f | %.3f | %.3g | %.2g |" % (name, soil, degrees, *(value for value, _ in row.values())), flush=True)


def rough(furrow, folder, kept, dem):
    store = folder / "rough.furrow"
    run(furrow, "import", dem, "-o", store)
    (folder / "model.xml").write_text((MODELS / "offroad.xml").read_text().replace('timestep="0.002"', 'timestep="0.01"'))
    driver = "    driver: {path: {points: [[51000, 47000], [51200, 47000], [51200, 47200]], speed: 2}, steer: [steer_*], drive: [drive_*]}\n"
    scene = SCENE.format(step=0.01, end=100, gravity=9.81, spacing=0.04, soil="sandy_loam_15", model="model.xml", x=51000, y=47000, yaw=0,
                         driver=driver, rows=100)
    rows, info = drive(furrow, folder, scene, store)
    weight = info["mass"] * 9.81
    # Mechanical energy less what the motors did. Springs and soil hold a little more.
    left = [row["kinetic"] + weight * row["z"] - row["work"] for row in rows]
    gained = max(b - a for a, b in zip(left, left[1:]))
    above = max(value - left[0] for value in left)
    air = {}  # after the first second: the drive begins at the longest step as well
    with open(folder / "out" / "objects.csv", encoding="ascii") as file:
        for row in csv.DictReader(file):
            air[row["name"]] = air.get(row["name"], 0) + (row["state"] == "air" and float(row["t"]) > 1)
    lowest, highest = min(row["z"] for row in rows), max(row["z"] for row in rows)
    for key, value, unit in (("way", info["distance"], "m"), ("relief", highest - lowest, "m"), ("motors", rows[-1]["work"], "J"), ("above", above, "J"),
                             ("air", sum(air.values()), "")):
        kept.add(f"rough.{key}", value, unit)
    print("%d rows over %.1f m, from %.2f to %.2f m; greatest speed %.2f m/s; motors %.0f J" %
          (len(rows), info["distance"], lowest, highest, max(math.hypot(r["vx"], r["vy"], r["vz"]) for r in rows), rows[-1]["work"]))
    print("energy less the motors' work: at most %.1f J above the start (%.2g of the motors'), and +%.2f J in a step" %
          (above, above / max(rows[-1]["work"], 1), gained))
    print("rows in the air after the first second: %s" % ", ".join("%s %d" % item for item in sorted(air.items())))


def speed(furrow, folder, kept, runs):
    """Drives at both spacings take turns. The time is that of all steps, and the way that from the start, where the vehicle stands."""
    print("| posts, cm | times real time | ms for a metre |\n| --- | --- | --- |")
    found = {0.03125: [], 0.015625: []}
    driver = "    driver: {path: {points: [[4, 16], [30, 16]], speed: 3}, steer: [steer_*], drive: [drive_*]}\n"
    for _ in range(runs):
        for spacing, of in found.items():
            scene = SCENE.format(step=0.002, end=5, gravity=9.81, spacing=spacing, soil="sandy_loam_15", model=MODELS / "offroad.xml", x=4, y=16, yaw=0,
                                 driver=driver, rows=10)
            rows, info = drive(furrow, folder, scene, plane(furrow, folder, 0))
            run = json.loads((folder / "out" / "run.json").read_text())
            kept.seen(run)
            of.append((run["rtf"], 1e3 * run["seconds"] / info["distance"]))
    for spacing, of in found.items():
        times, metres = zip(*of)
        kept.add(f"posts_{spacing * 100:.1f}cm.real_time", times, "")
        kept.add(f"posts_{spacing * 100:.1f}cm.ms_a_metre", metres, "ms")
        print("| %.1f | %.1f | %.0f |" % (spacing * 100, sorted(times)[runs // 2], sorted(metres)[runs // 2]))


TROT = """scene: 1
time_step: 0.002
end_time: {end}
spacing: 0.015625
soil: {{name: sandy_loam_15, damping: 30000}}
redistribute: {{model: scm}}
vehicles:
  - name: v
    model: {model}
    start: {{at: [16, 16], keyframe: home}}
    soil: [foot_*]
    driver: {{controls: {controls}}}
output: {{vehicles: 10, forces: 10}}
"""


def real(furrow, folder, kept, runs):
    """The drives take turns, each once for 1 s and once for 5 s. That with rigid wheels tells how busy the machine is."""
    driver = "    driver: {path: {points: [[4, 16], [30, 16]], speed: 3}, steer: [steer_*], drive: [drive_*]}\n"
    tyred = "    tyres: [{geom: wheel*, stiffness: 200000}]\n"

    def rolls(end, more=""):
        return SCENE.format(step=0.002, end=end, gravity=9.81, spacing=0.03125, soil="sandy_loam_15", model=MODELS / "offroad.xml", x=4, y=16, yaw=0,
                            driver=more + driver, rows=10)

    def trots(end):
        return TROT.format(end=end, model=MODELS / "quadruped.xml", controls=MODELS / "quadruped_controls.csv")

    drives = {"rigid": ("rigid wheels, posts of 3.1 cm", rolls, None), "tyres": ("tyres, posts of 3.1 cm", lambda end: rolls(end, tyred), REAL_TIME),
              "robot": ("robot of 12 joints, posts of 1.6 cm", trots, REAL_TIME)}
    found = {name: [] for name in drives}
    for _ in range(runs):
        for name, (_, scene, _) in drives.items():
            used = []
            for end in (1, 5):
                drive(furrow, folder, scene(end), plane(furrow, folder, 0))
                run = json.loads((folder / "out" / "run.json").read_text())
                used.append(run["processor_seconds"])
            found[name].append((run["rtf"], 4 / (used[1] - used[0])))
    print("| drive | times real time by the clock | by time of the processor | asked | met |\n| --- | --- | --- | --- | --- |")
    for name, (text, _, asked) in drives.items():
        times, processor = (sorted(column) for column in zip(*found[name]))
        kept.add(f"{name}.real_time", times, "")
        kept.add(f"{name}.of_the_processor", processor, "")
        verdict = ("", "") if asked is None else ("%g" % asked, "yes" if processor[runs // 2] >= asked else "NO")
        print("| %s | %.1f | %.1f | %s | %s |" % (text, times[runs // 2], processor[runs // 2], *verdict), flush=True)


def touch(furrow, folder, kept, runs):
    """Both drives take turns. The hulls, 4.3 m long, meet in the first second if one vehicle starts behind the other."""
    driver = "driver: {path: {points: [[%g, %g], [28, %g]], speed: %g}, steer: [steer_*], drive: [drive_*]}"
    first = "    " + driver % (8, 16, 16, 1) + "\n"
    found = {"apart": [], "pushing": []}
    for _ in range(runs):
        for name, of in found.items():
            x, y = (12.6, 16) if name == "pushing" else (12.6, 26)
            other = "  - {name: other, model: %s, start: {at: [%g, %g]}, soil: [wheel*], %s}\n" % (MODELS / "offroad.xml", x, y, driver % (x, y, y, 0.5))
            scene = SCENE.format(step=0.002, end=6, gravity=9.81, spacing=0.0625, soil="sandy_loam_15", model=MODELS / "offroad.xml", x=8, y=16, yaw=0,
                                 driver=first + other, rows=10)
            drive(furrow, folder, scene, plane(furrow, folder, 0))
            report = json.loads((folder / "out" / "run.json").read_text())
            ways = [report["vehicles"][vehicle]["distance"] for vehicle in ("v", "other")]
            if (ways[0] - ways[1] < 1) != (name == "pushing"):
                raise pages.Told(f"touch: {name}: the vehicles moved {ways[0]:.2f} and {ways[1]:.2f} m; mend the bench")
            kept.seen(report)
            of.append(report["step_ms"]["p50"])
    for name, of in found.items():
        kept.add(f"touch.{name}", of, "ms")
        print("two vehicles %s: %.3f ms a step" % (name, sorted(of)[runs // 2]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow", type=pathlib.Path)
    parser.add_argument("--only", action="append", choices=PARTS, help="one part; may be given again")
    parser.add_argument("--dem", type=pathlib.Path, help="real ground for rough: N41E001.hgt")
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--runs", type=int, default=3, help="of each drive for speed, real and touch, in turn")
    record.add_option(parser)
    arguments = parser.parse_args()
    kept = record.Record("vehicles", arguments.furrow)
    chosen = arguments.only or [part for part in PARTS if part != "rough" or arguments.dem is not None]
    if "rough" in chosen and arguments.dem is None:
        raise pages.Told("--only rough: needs --dem, real ground to drive on")
    with tempfile.TemporaryDirectory() as folder:
        parts = {"speed": (speed, arguments.runs), "real": (real, arguments.runs), "touch": (touch, arguments.runs), "rest": (rest, arguments.minutes), "rough": (rough, arguments.dem)}
        for part in chosen:
            of, option = parts[part]
            of(arguments.furrow.resolve(), pathlib.Path(folder), kept, option)
            kept.seen(json.loads((pathlib.Path(folder) / "out" / "run.json").read_text()))
            kept.write(arguments.figures)


if __name__ == "__main__":
    sys.exit(pages.main(main))
