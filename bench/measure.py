#!/usr/bin/env python3
"""Measures again the figures of README.md and of the pages about the soil, by the benches that they name.

Some half an hour on two quiet cores, less with `--big`. With `--long` also those of benches that take longer: some hours more.

    python3 bench/measure.py -o bench/figures --dem FOLDER --rig FOLDER     # then: python3 bench/marks.py writes them into the pages
    python3 bench/measure.py -o bench/figures --only soil_forms --only tested --only validation --only rig --only climb   # no times: a busy machine will do

It builds what it needs in the release build `build` first. Each bench leaves one file. Where a bench fails, or the data that it needs are
not given, its file stays as it is, which is told.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import time

import looks
import tested
from record import FIGURES, ROOT

LONG = ("deform", "frame", "ranks", "ranks_again", "scale", "track", "vehicles_rest", "measured_wheel", "converge", "ablation", "accuracy", "accuracy_sheet",
        "store_full", "paging")
SLIP_SINKAGE = 1.27  # as bench/measured_wheel.py fits it; a fit takes minutes
BUSY = 0.5  # a load above which other programs take a core's time that is worth telling


class Step:
    """One bench: the file that it leaves, its targets in the build, its command. needs: the options without which it cannot run. One of LONG runs
    with --long or --only."""

    def __init__(self, name, targets, command, needs=()):
        self.name, self.targets, self.command, self.needs, self.long = name, targets, command, needs, name in LONG


def steps(options):
    furrow, programs = options.build / "tools" / "furrow", options.build / "bench"
    python, bench = sys.executable, ROOT / "bench"
    dem = options.dem or pathlib.Path()
    srtm = [dem / "N41E001.hgt", dem / "N42E001.hgt"]
    big = ["--big", options.big] if options.big else []
    return [
        Step("store", ["bench/bench_store"], [python, bench / "store.py", furrow, options.build / "bench/bench_store", "--quick", "--runs", 3,
                                              "--dem", options.dem], ["dem"]),
        Step("store_write", ["bench/bench_store"], [programs / "bench_store", "--runs", 3, "write"]),
        Step("tiles", [], [python, bench / "tiles.py", furrow, srtm[0]], ["dem"]),
        Step("mosaic", [], [python, bench / "mosaic.py", furrow, *srtm], ["dem"]),
        Step("vehicles", [], [python, bench / "vehicles.py", furrow, "--only", "speed", "--only", "touch"]),
        Step("vehicles_rest", [], [python, bench / "vehicles.py", furrow, "--only", "rest", "--only", "rough", "--dem", srtm[0]], ["dem"]),
        Step("converge_fixed", [], [python, bench / "converge.py", furrow, "--only", "fixed", "--quick"]),
        Step("measured_smooth", [], [python, bench / "measured_wheel.py", furrow, "--quick", "--slip-sinkage", SLIP_SINKAGE, "--rig", options.rig], ["rig"]),
        Step("published_wheel", [], [python, bench / "published_wheel.py", furrow]),
        Step("table2", ["bench/bench_table2"], [options.build / "bench/bench_table2"]),
        Step("soil_forms", [], [python, bench / "soil_forms.py"]),
        Step("tested", tested.TARGETS, [python, bench / "tested.py", options.build]),
        Step("validation", ["bench/bench_validation"], [python, bench / "validation.py", programs / "bench_validation", "--quick"]),
        Step("faces_error", [], [python, bench / "faces_error.py", furrow]),
        Step("rig", [], [python, bench / "rig.py", furrow, "--rig", options.rig], ["rig"]),
        Step("mobility", [], [python, bench / "mobility.py", furrow, "--dem", dem / "gabilan_dtm1m.bil"], ["dem"]),
        Step("climb", [], [python, bench / "climb.py", furrow]),
        Step("probe", ["bench/bench_probe"], [programs / "bench_probe"]),
        Step("bearing", ["bench/bench_bearing"], [programs / "bench_bearing"]),
        Step("roofline", ["bench/bench_roofline"], [programs / "bench_roofline"]),
        Step("transfer", ["bench/bench_transfer"], [programs / "bench_transfer"]),
        Step("terrain_size", ["bench/bench_terrain_size"], [programs / "bench_terrain_size"]),
        Step("looks", [], [python, bench / "looks.py", furrow, *(word for part in looks.parts() for word in ("--only", part))]),
        Step("looks_tile", [], [python, bench / "looks.py", furrow, "--only", "tile", "--runs", 5]),
        Step("deform", ["bench/bench_deform"], [programs / "bench_deform"]),
        Step("frame", ["bench/bench_frame"], [programs / "bench_frame"]),
        Step("fleet_quiet", [], [python, bench / "fleet.py", furrow, "--wheels", "200,1000,4096", "--cpu"]),
        Step("store_full", ["bench/bench_store"], [python, bench / "store.py", furrow, programs / "bench_store", "--dem", dem, "--mosaic", *srtm,
                                                   "--runs", 3], ["dem"]),
        Step("ranks", [], [python, bench / "ranks.py", furrow, "--wheels", "100,400", "--runs", 3, "--steps", 480]),
        Step("ranks_again", [], [python, bench / "ranks.py", furrow, "--wheels", "100,400", "--runs", 3, "--steps", 480]),
        Step("scale", [], [python, bench / "scale.py", furrow]),
        Step("track", [], [python, bench / "track.py", furrow]),
        Step("measured_wheel", [], [python, bench / "measured_wheel.py", furrow, "--rig", options.rig], ["rig"]),
        Step("converge", [], [python, bench / "converge.py", furrow]),
        Step("ablation", [], [python, bench / "ablation.py", "--build", options.build, "-o", options.build / "bench-out"]),
        Step("accuracy", ["bench/bench_accuracy", "bench/bench_picture_error"], [python, bench / "accuracy.py", "--build", options.build, "-o", options.build / "bench-out",
                                                             "--publish"]),
        Step("accuracy_sheet", ["bench/bench_accuracy"], [python, bench / "accuracy.py", "--build", options.build, "-o", options.build / "bench-out",
                                                                   "--sheet", "--publish"]),
        Step("paging", [], [python, bench / "paging.py", furrow, "--runs", 1, *big]),
    ]


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--out", type=pathlib.Path, default=FIGURES, help="the folder of the files (bench/figures)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="a release build of meson (build)")
    parser.add_argument("--dem", type=pathlib.Path, help="the folder of the nine DEMs, for the store")
    parser.add_argument("--rig", type=pathlib.Path, help="the folder of wheel_smooth.csv and wheel_grouser.csv, for the measured wheel")
    parser.add_argument("--big", type=pathlib.Path, help="a terrain that bench/paging.py made before (made: minutes, 3 GB)")
    parser.add_argument("--long", action="store_true", help="also what takes long: " + ", ".join(LONG))
    parser.add_argument("--only", action="append", help="the file of one bench, as table2; may be given again")
    return parser.parse_args()


def measured(step, options):
    """Whether the bench left its file."""
    lacking = [f"--{name}" for name in step.needs if getattr(options, name) is None]
    if lacking:
        print(f"{step.name}: left as it is; it needs {' and '.join(lacking)}", flush=True)
        return False
    began = time.monotonic()
    path = options.out / f"{step.name}.json"
    done = subprocess.run([str(word) for word in (*step.command, "--figures", path)], cwd=ROOT, stdout=subprocess.DEVNULL)
    seconds = time.monotonic() - began
    if done.returncode != 0:
        print(f"{step.name}: FAILED after {seconds:.0f} s, see above; {path} stays as it is", flush=True)
        return False
    print(f"{step.name}: {seconds:.0f} s", flush=True)
    return True


def main():
    options = parse()
    for name in ("out", "build", "dem", "rig", "big"):
        if getattr(options, name) is not None:
            setattr(options, name, getattr(options, name).resolve())
    every = steps(options)
    wrong = set(options.only or ()) - {step.name for step in every}
    if wrong:
        sys.exit(f"measure.py: --only {' '.join(sorted(wrong))}: is no file of it; there are {', '.join(step.name for step in every)}")
    chosen = [step for step in every if (step.name in options.only if options.only else options.long or not step.long)]
    targets = sorted({"tools/furrow"}.union(*(step.targets for step in chosen)))
    if subprocess.run(["ninja", "-C", str(options.build), *targets], stdout=subprocess.DEVNULL).returncode != 0:
        sys.exit(f"measure.py: {options.build}: cannot be built, see above; meson setup build makes a release build")
    load = os.getloadavg()[0]
    if load > BUSY:
        print(f"other programs run (load {load:.1f}); times will be too long, and the files say so", file=sys.stderr)
    options.out.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    good = [measured(step, options) for step in chosen]
    print(f"{time.monotonic() - began:.0f} s in all; python3 bench/marks.py writes them into the pages")
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
