#!/usr/bin/env python3
"""What pages say of a soil's rebound, and of a wheel in the rut of another: `furrow rig` with coarse posts. Two minutes on two quiet cores.

    python3 bench/towed.py build/tools/furrow --figures bench/figures/towed.json
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import record
from pages import Told
from pages import main as told_main

UTV = ("--shape=wheel: {radius: 0.35, width: 0.22}", "--load=2207", "--spacing=0.0275")
STIFFNESSES, SLIPS = ("1e7", "4e7", "4e8", "1e10"), ("0.1", "0.2", "0.4")
KC, KPHI, N = 5270, 1515040, 0.7   # of sandy_loam_15


def rig(furrow, folder, *words):
    done = subprocess.run([furrow, "rig", "-o", folder, *words], capture_output=True, text=True)
    if done.returncode != 0:
        raise Told(f"furrow rig {' '.join(words)}: {done.stderr.strip()}")
    with open(pathlib.Path(folder) / "rig.csv") as file:
        return [{key: value if key in ("soil", "state") else float(value or "nan") for key, value in row.items()} for row in csv.DictReader(file)]


def bekker(radius, width, load):
    """The resistance of a towed wheel on soil that does not spring back, N."""
    k = KC / width + KPHI
    sinkage = (3 * load / (width * k * (3 - N) * math.sqrt(2 * radius))) ** (2 / (2 * N + 1))
    return width * k * sinkage ** (N + 1) / (N + 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("towed", options.furrow)
    soils = ",".join("{name: sandy_loam_15, elastic_stiffness: " + stiffness + "}" for stiffness in STIFFNESSES)
    with tempfile.TemporaryDirectory() as folder:
        for name, asked in (("towed", "--torque=0"), ("slip_0.2", "--slip=0.2")):
            for stiffness, row in zip(STIFFNESSES, rig(options.furrow, folder, *UTV, f"--soil={soils}", asked)):
                kept.add(f"stiffness_{stiffness}.{name}.sinkage", row["sinkage"] * 1e3, "mm")
                kept.add(f"stiffness_{stiffness}.{name}.force", abs(row["drawbar"]), "N")
        kept.add("bekker.resistance", bekker(0.35, 0.22, 2207), "N")
        for soil in ("dry_sand", "sandy_loam_15"):
            for passes, name in ((1, "first"), (2, "second")):
                rows = rig(options.furrow, folder, f"--soil={soil}", f"--slip={','.join(SLIPS)}", "--spacing=0.02", f"--passes={passes}")
                for slip, row in zip(SLIPS, rows):
                    kept.add(f"{soil}.slip_{slip}.{name}", row["drawbar"], "N")
    for key, figure in kept.figures.items():
        if not math.isfinite(figure["value"]):
            raise Told(f"{key}: the wheel sank; mend the bench")
        print(f"{key}: {figure['value']:.4g} {figure['unit']}")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
