#!/usr/bin/env python3
"""A vehicle on ramps of dry sand: its slip by speed with soil damping and without, and the steepest ramp that it drives up. Some minutes on two quiet cores.

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

FOOT, UP = 20.0, 4.0      # m: where a ramp begins; slip is that of the way from 4 m up
SPEEDS, DEGREES, CLIMB = (0.5, 1, 3), 12, 2   # m/s; degrees; m/s on the steep ramps
RAMPS = (15.2, 16.8)      # degrees: of which the first is driven up and the second is not
SCENE = {"scene": 1, "time_step": 0.002, "spacing": 0.0625, "redistribute": {"model": "scm"}, "stuck": {"after": 2, "below": 0.05},
         "output": {"forces": 20, "vehicles": 20}}


def ramp(path, degrees):
    """An ESRI grid: level to the foot, then up to the east."""
    rise = math.tan(math.radians(degrees))
    row = " ".join(f"{10 + max(x * 0.5 - FOOT, 0) * rise:.4f}" for x in range(129))
    path.write_text("ncols 129\nnrows 129\nxllcenter 0\nyllcenter 0\ncellsize 0.5\n" + f"{row}\n" * 129)


class Bench:
    def __init__(self, furrow, folder, kept):
        self.furrow, self.folder, self.kept, self.stores = furrow, folder, kept, {}

    def command(self, *words):
        done = subprocess.run([self.furrow, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise Told(f"furrow {words[0]}: {done.stderr.strip()}")

    def store(self, degrees):
        if degrees not in self.stores:
            source, self.stores[degrees] = self.folder / f"ramp-{degrees:g}.asc", self.folder / f"ramp-{degrees:g}.furrow"
            ramp(source, degrees)
            self.command("import", source, "-o", self.stores[degrees])
        return self.stores[degrees]

    def drive(self, degrees, speed, damping, start, end):
        """Returns the mean slip of the wheels from UP on, and how far along x the vehicle came."""
        car = {"name": "car", "model": str(record.ROOT / "tools/scenes/vehicles/offroad.xml"), "start": {"at": [start, 32]}, "soil": ["wheel_*"],
               "driver": {"path": {"points": [[start, 32], [end, 32]], "speed": speed}, "steer": ["steer_*"], "drive": ["drive_*"]}}
        soil = {"name": "dry_sand"} | ({} if damping is None else {"damping": damping})
        made = SCENE | {"soil": soil, "vehicles": [car], "end_time": 2 + 2 * (end - start) / speed}
        (self.folder / "climb.yaml").write_text(json.dumps(made))
        ruts, out = self.folder / "ruts.furrow", self.folder / "out"
        self.command("drive", self.folder / "climb.yaml", "--store", self.store(degrees), "--overlay", ruts, "-o", out)
        for path in self.folder.glob("ruts.furrow*"):
            path.unlink()
        self.kept.seen(json.loads((out / "run.json").read_text()))
        with open(out / "objects.csv") as file:
            slips = [float(row["slip"]) for row in csv.DictReader(file) if FOOT + UP <= float(row["x"]) <= end - 3]
        with open(out / "vehicles.csv") as file:
            far = max(float(row["x"]) for row in csv.DictReader(file))
        return sum(slips) / len(slips) if slips else None, far


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
                slip, far = bench.drive(DEGREES, speed, damping, 14, 38)
                print(f"{DEGREES} degrees, {speed:g} m/s, damping {name}: slip {slip}, came to {far:.1f} m", flush=True)
                if slip is None:
                    raise Told(f"{speed:g} m/s: got stuck before {FOOT + UP:g} m; mend the bench")
                kept.add(f"damping.v{speed:g}.{name}", slip, "")
        for degrees in RAMPS:
            slip, far = bench.drive(degrees, CLIMB, 0, 10, 50)
            print(f"{degrees:g} degrees: came to {far:.1f} m", flush=True)
            kept.add(f"ramp.{degrees:g}.way_up", max(far - FOOT, 0) / math.cos(math.radians(degrees)), "m")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
