#!/usr/bin/env python3
"""A vehicle on slopes of dry sand: up ramps, beside `furrow mobility`, and across. Some minutes on two quiet cores.

Told: its slip by speed with soil damping and without; the steepest ramp that it drives up; how far it comes off its way across a slope.

    python3 bench/climb.py build/tools/furrow --figures bench/figures/climb.json
"""
import argparse
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import record
from pages import Told
from pages import main as told_main

MODEL = record.ROOT / "tools/scenes/vehicles/offroad.xml"
FOOT, UP = 20.0, 4.0      # m: where a ramp begins; slip is that of the way from 4 m up
SPEEDS, DEGREES, CLIMB = (0.5, 1, 3), 12, 2   # m/s; degrees; m/s on the steep ramps
ACROSS = (8, 15)          # degrees: slopes whose contour it is to follow, at CLIMB
RAMPS = (15.2, 16.8)      # degrees: of which the first is driven up and the second is not
SCENE = {"scene": 1, "time_step": 0.002, "spacing": 0.0625, "redistribute": {"model": "scm"}, "stuck": {"after": 2, "below": 0.05},
         "output": {"forces": 20, "vehicles": 20}}


def write_grid(path, height):
    """An ESRI grid of 129 x 129 posts, half a metre apart. height(x, y): m, of a post so many metres east and north of the first one."""
    rows = (" ".join(f"{height(x * 0.5, y * 0.5):.4f}" for x in range(129)) for y in range(128, -1, -1))
    path.write_text("ncols 129\nnrows 129\nxllcenter 0\nyllcenter 0\ncellsize 0.5\n" + "\n".join(rows) + "\n")


def ramp(path, degrees):
    """Level to the foot, then up to the east."""
    rise = math.tan(math.radians(degrees))
    write_grid(path, lambda x, y: 10 + max(x - FOOT, 0) * rise)


def side_slope(path, degrees):
    """Rises to the north everywhere."""
    rise = math.tan(math.radians(degrees))
    write_grid(path, lambda x, y: 10 + y * rise)


class Bench:
    def __init__(self, furrow, folder, kept):
        self.furrow, self.folder, self.kept, self.stores = furrow, folder, kept, {}

    def command(self, *words):
        """Runs furrow with these words. Returns what it prints."""
        done = subprocess.run([self.furrow, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise Told(f"furrow {words[0]}: {done.stderr.strip()}")
        return done.stdout

    def store(self, made, degrees):
        """made: ramp or side_slope."""
        if (made, degrees) not in self.stores:
            source, store = (self.folder / f"{made.__name__}-{degrees:g}.{kind}" for kind in ("asc", "furrow"))
            made(source, degrees)
            self.command("import", source, "-o", store)
            self.stores[made, degrees] = store
        return self.stores[made, degrees]

    def mobility(self):
        """What the map says of the same vehicle in the same soil: the steepest slope straight up, and the slip on a slope of DEGREES."""
        told = json.loads(self.command("mobility", self.store(ramp, DEGREES), "-o", self.folder / "map.png", "--vehicle", MODEL, "--soil", "dry_sand",
                                       "--json"))
        up = next(verdict for row in told["slopes"] if row["slope"] == DEGREES for verdict in row["verdicts"] if verdict["heading"] == 90)
        return told["steepest_up"], up["slip"]

    def drive(self, store, speed, damping, start, end):
        """Rows of vehicles.csv and of objects.csv."""
        car = {"name": "car", "model": str(MODEL), "start": {"at": [start, 32]}, "soil": ["wheel_*"],
               "driver": {"path": {"points": [[start, 32], [end, 32]], "speed": speed}, "steer": ["steer_*"], "drive": ["drive_*"]}}
        soil = {"name": "dry_sand"} | ({} if damping is None else {"damping": damping})
        made = SCENE | {"soil": soil, "vehicles": [car], "end_time": 2 + 2 * (end - start) / speed}
        (self.folder / "climb.yaml").write_text(json.dumps(made))
        ruts, out = self.folder / "ruts.furrow", self.folder / "out"
        self.command("drive", self.folder / "climb.yaml", "--store", store, "--overlay", ruts, "-o", out)
        for path in self.folder.glob("ruts.furrow*"):
            path.unlink()
        self.kept.seen(json.loads((out / "run.json").read_text()))
        with open(out / "vehicles.csv") as vehicles, open(out / "objects.csv") as objects:
            return [[{key: float(value) for key, value in row.items() if key not in ("name", "soil", "state") and value} for row in csv.DictReader(file)]
                    for file in (vehicles, objects)]

    def climb(self, degrees, speed, damping, start, end):
        """Returns the mean slip of the wheels from UP on, and how far along x the vehicle came."""
        rows, wheels = self.drive(self.store(ramp, degrees), speed, damping, start, end)
        slips = [row["slip"] for row in wheels if FOOT + UP <= row["x"] <= end - 3]
        return sum(slips) / len(slips) if slips else None, max(row["x"] for row in rows)

    def across(self, degrees):
        """Returns the mean angle between its way and its nose from half of the path on, how far it slid down, and how far along the path it came."""
        start, end = 10, 34
        rows, _ = self.drive(self.store(side_slope, degrees), CLIMB, None, start, end)
        far = max(row["x"] for row in rows)
        half = [row for row in rows if start + 12 <= row["x"] <= end - 3]
        if not half:
            raise Told(f"across {degrees} degrees: stopped after {far - start:.1f} m; mend the bench")
        crab = sum(row["yaw"] - math.degrees(math.atan2(row["vy"], row["vx"])) for row in half) / len(half)
        return crab, rows[0]["y"] - min(row["y"] for row in rows), far - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("climb", options.furrow)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options.furrow, pathlib.Path(folder), kept)
        for speed in SPEEDS:
            for name, damping in (("default", None), ("none", 0)):
                slip, far = bench.climb(DEGREES, speed, damping, 14, 38)
                print(f"{DEGREES} degrees, {speed:g} m/s, damping {name}: slip {slip}, came to {far:.1f} m", flush=True)
                if slip is None:
                    raise Told(f"{speed:g} m/s: got stuck before {FOOT + UP:g} m; mend the bench")
                kept.add(f"damping.v{speed:g}.{name}", slip, "")
        for degrees in RAMPS:
            slip, far = bench.climb(degrees, CLIMB, 0, 10, 50)
            print(f"{degrees:g} degrees: came to {far:.1f} m", flush=True)
            kept.add(f"ramp.{degrees:g}.way_up", max(far - FOOT, 0) / math.cos(math.radians(degrees)), "m")
        steepest, slip = bench.mobility()
        print(f"furrow mobility: up to {steepest:g} degrees; slip {slip:.3f} on {DEGREES}")
        kept.add("mobility.steepest", steepest, "degrees")
        kept.add("mobility.slip", slip, "")
        for degrees in ACROSS:
            crab, slid, way = bench.across(degrees)
            print(f"across {degrees} degrees: crab {crab:.1f} degrees, slid {slid:.2f} m on {way:.1f} m", flush=True)
            kept.add(f"across.{degrees}.crab", crab, "degrees")
            kept.add(f"across.{degrees}.slid", slid, "m")
            kept.add(f"across.{degrees}.way", way, "m")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
