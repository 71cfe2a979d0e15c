#!/usr/bin/env python3
"""What pages say of `furrow rig`: the measured wheel by one command, a wheel of a newton on stiff clay, what K_e changes, and a second pass. A minute.

    python3 bench/rig.py build/tools/furrow --rig FOLDER --figures bench/figures/rig.json     # FOLDER: wheel_smooth.csv

The measured wheel has one load and one soil here; bench/measured_wheel.py gives each trial its own.
"""
import argparse
import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import measured_wheel
import record
from pages import Told
from pages import main as told_main

LOAD, LEAST, MOST = 24.5, -0.55, 0.95   # N; the slips of the rig's page that are compared
STIFFNESSES = ("1e7", "4e7", "4e8", "1e10")   # Pa/m
STIFF = {"shape": "wheel: {radius: 0.35, width: 0.25}", "load": "3000", "soil": "dry_sand", "slip": "0.2"}


def trials(folder, path):
    """Writes the smooth wheel's trials straight ahead, with slips as `furrow rig` counts them. Returns their slips."""
    rows = [row for row in measured_wheel.trials_of(folder / "wheel_smooth.csv") if row["slip_angle_deg"] == 0 and LEAST <= row["setting"] <= MOST]
    slips = [row["setting"] / (1 + row["setting"]) if row["setting"] < 0 else row["setting"] for row in rows]
    with open(path, "w") as file:
        file.write("slip,sinkage_mm,drag_N\n")
        file.writelines(f"{slip:.4f},{row['sinkage_mm']},{row['drag_N']}\n" for slip, row in zip(slips, rows))
    return sorted(set(slips))


def rig(furrow, folder, name, **options):
    """Returns what it printed, and the rows of its CSV as numbers where they are."""
    words = [word for key, value in options.items() for word in (f"--{key}={value}",)]
    done = subprocess.run([furrow, "rig", "-o", str(folder / name), *words], capture_output=True, text=True)
    if done.returncode != 0:
        raise Told(f"furrow rig {' '.join(words)}: {done.stderr.strip()}")
    with open(folder / name / "rig.csv") as file:
        return done.stdout, list(csv.DictReader(file))


def springs_back(furrow, folder, kept):
    """A towed and a driven wheel on loam by its elastic stiffness."""
    for stiffness in STIFFNESSES:
        (folder / f"loam-{stiffness}.yaml").write_text("soil: {name: sandy_loam_15, elastic_stiffness: " + stiffness + "}\n")
    soils = ",".join(str(folder / f"loam-{stiffness}.yaml") for stiffness in STIFFNESSES)
    for name, asked in (("towed", {"torque": "0"}), ("driven", {"slip": "0.2"})):
        _, rows = rig(furrow, folder, name, soil=soils, shape="wheel: {radius: 0.35, width: 0.22}", load="2207", spacing="0.0275", **asked)
        for stiffness, row in zip(STIFFNESSES, rows, strict=True):
            kept.add(f"loam_{stiffness}.{name}.sinkage", float(row["sinkage"]) * 1e3, "mm")
            kept.add(f"loam_{stiffness}.{name}.drawbar", float(row["drawbar"]), "N")
        if name == "towed":
            for stiffness, row in zip(STIFFNESSES, rows):
                kept.add(f"loam_{stiffness}.towed.resistance", -float(row["drawbar"]), "N")


def second_pass(furrow, folder, kept):
    """The wheel that `furrow rig` has by itself, and one that follows another."""
    for passes, name in (("1", "first"), ("2", "second")):
        _, rows = rig(furrow, folder, f"passes-{passes}", soil="dry_sand,sandy_loam_15", slip="0.1,0.2,0.4", spacing="0.02", passes=passes)
        for row in rows:
            kept.add(f"rut.{row['soil']}.slip_{float(row['slip']):g}.{name}", float(row["drawbar"]), "N")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("--rig", type=pathlib.Path, required=True, help="the folder of wheel_smooth.csv")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("rig", options.furrow)
    soil = "{" + measured_wheel.soil_text(0) + "}"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        slips = trials(options.rig, folder / "measured.csv")
        text, _ = rig(options.furrow, folder, "measured", shape="wheel: {radius: 0.058, width: 0.05}", load=LOAD, soil=soil,
                      slip=",".join(f"{slip:.4f}" for slip in slips), compare=folder / "measured.csv")
        print(text)
        found = re.search(r"RMS: sinkage ([\d.]+) mm, drawbar ([\d.]+) N", text)
        if found is None:
            raise Told(f"furrow rig --compare: told no RMS; it printed {text!r}")
        kept.add("measured.sinkage_rms", float(found[1]), "mm")
        kept.add("measured.drawbar_rms", float(found[2]), "N")
        _, (row,) = rig(options.furrow, folder, "clay", shape="wheel: {radius: 0.5, width: 0.4}", load=1, soil="heavy_clay_25", slip=0, spacing=0.02)
        kept.add("heavy_clay_25.load_1.sinkage", float(row["sinkage"]) * 1e3, "mm")
        pulls = []
        for stiffness in ("4e7", "4e9"):
            _, (row,) = rig(options.furrow, folder, stiffness, **STIFF | {"soil": "{name: dry_sand, elastic_stiffness: " + stiffness + "}"})
            pulls.append(float(row["drawbar"]))
            kept.add(f"stiffness_{stiffness}.drawbar", pulls[-1], "N")
        kept.add("stiffness.less", 1 - pulls[1] / pulls[0], "times")
        springs_back(options.furrow, folder, kept)
        second_pass(options.furrow, folder, kept)
    for key, figure in kept.figures.items():
        if not math.isfinite(figure["value"]):
            raise Told(f"{key}: the wheel sank; mend the bench")
        print(f"{key}: {figure['value']:.4g} {figure['unit']}")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
