#!/usr/bin/env python3
"""Sinkage and resistance of a towed tyre over its stiffness, by `furrow rig`, beside Wong's two modes.

    python3 bench/tyres.py build/tools/furrow --plots docs      # tyres-sinkage.svg, tyres-resistance.svg; some minutes

Rigid mode: Bekker's towed rigid wheel. Elastic mode: a flat patch of length l with p = W / (b l), sinkage (p / k)^(1/n), resistance b k z^(n+1) / (n+1). l is the chord of
the tyre on rigid ground. The tyre of the rig has 0.9 of that pressure, or half of it as usual.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

from validation import COLOURS, Plot

RADIUS, WIDTH, LOAD = 0.5, 0.3, 5000.0
STIFFNESSES = (60e3, 120e3, 250e3, 500e3, 1e6, 2.5e6, 5e6)
SOILS = {"dry_sand": (1.1, 990, 1528430), "clayey_38": (0.5, 13190, 692150)}  # n, k_c, k_phi: SI
SHARES = (0.9, 0.5)


def patch(stiffness):
    """Length and mean pressure on rigid ground."""
    pressed = LOAD / stiffness
    length = 2 * math.sqrt(pressed * (2 * RADIUS - pressed))
    return length, LOAD / (WIDTH * length)


def modes(soil, stiffness):
    """(sinkage m, resistance N) of the elastic mode and of the rigid one."""
    n, k_c, k_phi = SOILS[soil]
    k = k_c / WIDTH + k_phi
    elastic = (patch(stiffness)[1] / k) ** (1 / n)
    rigid = (3 * LOAD / (WIDTH * k * (3 - n) * math.sqrt(2 * RADIUS))) ** (2 / (2 * n + 1))
    return [(z, WIDTH * k * z ** (n + 1) / (n + 1)) for z in (elastic, rigid)]


def towed(furrow, stiffness, share):
    """(sinkage, resistance) by soil."""
    tyre = f", tyre: {{stiffness: {stiffness}, load: {LOAD}, pressure: {share * patch(stiffness)[1]}}}" if stiffness else ""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([furrow, "rig", "-o", folder, "--shape", f"wheel: {{radius: {RADIUS}, width: {WIDTH}{tyre}}}", "--load", str(LOAD), "--torque", "0",
                               "--soil", ",".join(SOILS), "--spacing", "0.05"], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        with open(pathlib.Path(folder) / "rig.csv", encoding="utf-8") as file:
            return {row["soil"]: (float(row["sinkage"]), -float(row["drawbar"])) for row in csv.DictReader(file)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow")
    parser.add_argument("--plots", type=pathlib.Path)
    arguments = parser.parse_args()
    rigid = towed(arguments.furrow, 0, 0)
    rows = {share: {k: towed(arguments.furrow, k, share) for k in STIFFNESSES} for share in SHARES}
    for soil in SOILS:
        for k in STIFFNESSES:
            told = [f"{1e3 * z:.2f} mm {r:.1f} N" for z, r in [rows[share][k][soil] for share in SHARES] + modes(soil, k) + [rigid[soil]]]
            print(f"{soil} {k / 1e3:g} kN/m: pressure 0.9 {told[0]}, 0.5 {told[1]}; elastic mode {told[2]}, rigid mode {told[3]}, rigid wheel {told[4]}")
    for i, (name, unit, scale, low, high, ticks) in enumerate((("sinkage", "mm", 1e3, 1, 200, (1, 2, 5, 10, 20, 50, 100, 200)), ("resistance", "N", 1, 5, 2000, (5, 10, 20, 50, 100, 200, 500, 1000, 2000)))):
        plot = Plot(f"A towed tyre: {name}. 5 kN, radius 0.5 m, width 0.3 m", ("stiffness, kN/m", 50, 6000, (50, 100, 200, 500, 1000, 2000, 5000)), (f"{name}, {unit}", low, high, ticks), log=True)
        for s, soil in enumerate(SOILS):
            plot.line(f"{soil}, pressure 0.9", [(k / 1e3, scale * rows[0.9][k][soil][i]) for k in STIFFNESSES], COLOURS[s])
            plot.line(f"{soil}, pressure 0.5", [(k / 1e3, scale * rows[0.5][k][soil][i]) for k in STIFFNESSES], COLOURS[s + 2])
            plot.line("Wong's elastic mode", [(k / 1e3, scale * modes(soil, k)[0][i]) for k in STIFFNESSES], COLOURS[s], "6 4")
            plot.line("rigid wheel", [(k / 1e3, scale * rigid[soil][i]) for k in STIFFNESSES], COLOURS[s], "2 3")
        if arguments.plots:
            plot.write(arguments.plots / f"tyres-{name}.svg")


if __name__ == "__main__":
    main()
