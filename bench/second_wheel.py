#!/usr/bin/env python3
"""How far a second wheel in a rut is off at coarse posts: sinkage and drawbar of furrow rig --passes 1 and 2, beside posts of 1 cm.

    python3 bench/second_wheel.py build/tools/furrow [KEY=VALUE]...

The keys are of the scene, as in redistribute.bulldozing=0. Prints a table in Markdown.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

SPACINGS = (0.0625, 0.03125, 0.015625, 0.01)  # m; the last is what the others are held to
WHEELS = (("sandy_loam_15", 0.4, 0.2, 4905), ("sandy_loam_22", 0.5, 0.4, 5000), ("sandy_loam_22", 0.4, 0.2, 4905), ("sandy_loam_15", 0.25, 0.2, 1000))
SLIP = 0.29


def measured(furrow, folder, spacing, passes, keys, soil, radius, width, load):
    """Sinkage in mm and drawbar in N of the last wheel."""
    command = [furrow, "rig", "-o", folder, "--soil", soil, "--shape", f"wheel: {{radius: {radius}, width: {width}}}", "--load", str(load), "--slip", str(SLIP),
               "--passes", str(passes), "--spacing", str(spacing)]
    told = subprocess.run(command + [word for key in keys for word in ("--set", key)], capture_output=True, text=True, check=True).stdout
    row = next(line.split() for line in told.splitlines() if re.match(r" +\d", line))
    return float(row[2]), float(row[3])


def main():
    furrow, *keys = sys.argv[1:]
    print("| wheel | pass | " + " | ".join(f"{1e3 * spacing:g} mm" for spacing in SPACINGS) + " | sinkage off by | drawbar off by |")
    print("| --- " * (4 + len(SPACINGS)) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for wheel in WHEELS:
            soil, radius, width, load = wheel
            for passes in (1, 2):
                found = [measured(furrow, pathlib.Path(folder) / "rig", spacing, passes, keys, *wheel) for spacing in SPACINGS]
                sinkage = ", ".join(f"{100 * (z / found[-1][0] - 1):+.1f}" for z, _ in found[:-1])
                drawbar = ", ".join(f"{100 * (f - found[-1][1]) / load:+.1f}" for _, f in found[:-1])
                print(f"| {soil}, r {radius} m, b {width} m, {load} N | {passes} | " + " | ".join(f"{z:.1f} mm, {f:.0f} N" for z, f in found) +
                      f" | {sinkage} % | {drawbar} % of the load |", flush=True)


main()
