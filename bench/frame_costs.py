#!/usr/bin/env python3
"""Writes src/report/frame_costs.h, by which `furrow explain` tells what pictures will cost, from the figures of bench/looks.py.

    python3 bench/frame_costs.py            # writes it; --check: only says whether it is as these figures say
"""
import json
import math
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
FIGURES, HEADER = ROOT / "bench/figures/looks.json", ROOT / "src/report/frame_costs.h"
SMALL, LARGE = 640 * 480, 1280 * 720   # pixels of looks.shadow.none and looks.samples.none, which are the same view


def text():
    record = json.loads(FIGURES.read_text())
    of = {key: figure["value"] for key, figure in record["figures"].items()}
    pixel = (of["samples.none.picture"] - of["shadow.none.picture"]) / (LARGE - SMALL)
    power = math.log((of["finer.quarter_pixel.ratio"] - 1) / (of["finer.one_pixel.ratio"] - 1)) / math.log(4)
    shaded = (of["finest.quarter_pixel.ratio"] - 1) / (of["finer.quarter_pixel.ratio"] - 1)
    rough = of["relief.relief_two_pixels.ratio"] - 1
    finest = (of["finest.relief_quarter_pixel.ratio"] - 1) / shaded
    rough_power = math.log(finest / rough) / math.log(8)
    rows = [("pixel", pixel, "s a pixel"), ("frame", of["shadow.none.picture"] - SMALL * pixel, "s a frame"),
            ("sample", (of["samples.four.ratio"] - 1) / 3, "each sample above one, of a picture without"),
            ("terrain_shadow", of["shadow.terrain_shadow.ratio"], "times a picture without"),
            ("error", of["finer.one_pixel.ratio"] - 1, "a pixel_error of 1, of a picture without"), ("error_power", power, "of 1 / pixel_error"),
            ("error_shaded", shaded, "times, with terrain_shadow"),
            ("relief", rough * 2 ** rough_power, "the same over relief"), ("relief_power", rough_power, "")]
    lines = [f"	.{name} = {value:.4g},{f' /* {what} */' if what else ''}" for name, value, what in rows]
    return "\n".join(["/* Made by bench/frame_costs.py from bench/figures/looks.json. Processor seconds of llvmpipe, all effects. */",
                      "static const struct frame_costs llvmpipe = {", *lines, "};", ""])


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        sys.exit(0 if HEADER.read_text() == text() else f"{HEADER.name} is not what {FIGURES.name} says: run python3 bench/frame_costs.py")
    HEADER.write_text(text())
