#!/usr/bin/env python3
"""What pictures cost with relief, finer tiles, a bound of the error, the terrain's shadow and samples; what relief costs as tiles are loaded.

    python3 bench/looks.py build/tools/furrow --figures bench/figures/looks.json     # some minutes; --only relief: one part

A figure is processor time, so the machine's load counts less; ratios are of two drives in turn. A picture's time is the difference of two drives, of which one
draws more pictures, over the number that it draws more.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import ablation
import record
from pages import Told
from pages import main as told_main

FEW, MANY, LONG = 4, 28, {"finest": 10}   # pictures of a drive, fewer where each takes a second; the wheel hardly moves, so later ones load nothing
STORES = {"metre": ("--posts", "1025x129", "--spacing", "1", "--kind", "plain", "--relief", "1"),
          "coarse": ("--posts", "129x129", "--spacing", "20", "--kind", "ridged", "--relief", "200"),
          "hills": ("--posts", "1025x1025", "--spacing", "1", "--kind", "ridged", "--relief", "160", "--seed", "7")}
RELIEF = {"roughness": 0.02, "wavelength": 2, "seed": 7}
EFFECTS = ["texture", "detail", "sky", "geomorph", "skirts", "objects", "shadow"]


def scene(store, at, spacing=None, relief=None, size=(640, 480), shadow=False, **view):
    made = {"scene": 1, "store": f"{store}.furrow", "time_step": 0.1, "redistribute": {"model": "none"},
            "objects": [{"name": "wheel", "shape": {"wheel": {"radius": 0.5, "width": 0.4}}, "sink": 0.05,
                         "path": {"points": [at, [at[0] + 8, at[1]]], "speed": 0.01}}], "cache": {"slots": 2048},
            "view": {"size": list(size), "camera": {"chase": "wheel"}, "images": 1, "effects": EFFECTS + ["terrain_shadow"] * shadow, **view}}
    return made | ({"spacing": spacing} if spacing else {}) | ({"relief": relief} if relief else {})


def parts():
    """{part: {name: scene}}: the first of a part is what the others are compared with."""
    small, middle, plain = (640, 360), [1000, 1000], [40, 64]
    rover = {"spacing": 0.04, "shadow": True}
    return {
        "relief": {"none": scene("metre", plain, 1 / 16, size=small), "relief": scene("metre", plain, 1 / 16, RELIEF, small),
                   "two_pixels": scene("metre", plain, 1 / 16, size=small, pixel_error=2),
                   "relief_two_pixels": scene("metre", plain, 1 / 16, RELIEF, small, pixel_error=2)},
        "finer": {"none": scene("coarse", middle), "finer": scene("coarse", middle, 0.3125), "one_pixel": scene("coarse", middle, 0.3125, pixel_error=1),
                  "quarter_pixel": scene("coarse", middle, 0.3125, pixel_error=0.25)},
        "finest": {"none": scene("coarse", middle, **rover), "quarter_pixel": scene("coarse", middle, **rover, pixel_error=0.25),
                   "relief": scene("coarse", middle, relief=RELIEF | {"roughness": 0.015}, **rover),
                   "relief_quarter_pixel": scene("coarse", middle, relief=RELIEF | {"roughness": 0.015}, **rover, pixel_error=0.25)},
        "shadow": {"none": scene("hills", [500, 500]), "terrain_shadow": scene("hills", [500, 500], shadow=True)},
        "samples": {"none": scene("hills", [500, 500], size=(1280, 720)), "four": scene("hills", [500, 500], size=(1280, 720), samples=4)},
    }


class Bench:
    def __init__(self, furrow, folder):
        self.furrow, self.folder, self.renderer = pathlib.Path(furrow).resolve(), folder, None
        for name, words in STORES.items():
            self.command("synth", "-o", f"{name}.furrow", *words)
        (folder / "classes.png").write_bytes(ablation.classes(1025, 129, 8))

    def command(self, *words):
        done = subprocess.run([str(self.furrow), *words], cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise Told(f"furrow {words[0]}: {done.stderr.strip()}")
        return done.stdout

    def drive(self, made, seconds):
        """Processor seconds, and run.json."""
        (self.folder / "scene.yaml").write_text(json.dumps(made | {"end_time": seconds}))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = json.loads(self.command("drive", "scene.yaml", "--overlay", "ruts.furrow", "-o", "out", "--json"))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.renderer = run["gl"]["renderer"]
        for path in self.folder.glob("ruts.furrow*"):
            path.unlink()
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, run

    def picture(self, made, most):
        few, many = (self.drive(made, count * made["time_step"])[0] for count in (FEW, most))
        return (many - few) / (most - FEW)


def pictures(bench, kept, wanted, runs):
    for part, scenes in parts().items():
        if wanted and part not in wanted:
            continue
        found = {name: [] for name in scenes}
        for _ in range(runs):
            for name, made in scenes.items():
                found[name].append(bench.picture(made, LONG.get(part, MANY)))
        for name, seconds in found.items():
            kept.add(f"{part}.{name}.picture", seconds, "s")
            beside = "two_pixels" if name == "relief_two_pixels" else "none"
            if name not in ("none", "two_pixels"):
                kept.add(f"{part}.{name}.ratio", [a / b for a, b in zip(seconds, found[beside])], "times")


def tiles(bench, kept, runs):
    """A wheel goes through the whole strip at posts that are five levels finer. Every tile on its way is made once."""
    way = {"points": [[20, 64], [1000, 64]], "speed": 100}
    soils = {"map": "classes.png", "classes": {1: "dry_sand", 2: "lete_sand"}, "default": "dry_sand"}
    bare = scene("metre", [20, 64], 1 / 32) | {"soil": soils}
    del bare["view"]
    bare["objects"][0]["path"] = way
    made = {"none": bare, "relief": bare | {"relief": RELIEF},
            "by_class": bare | {"relief": RELIEF | {"classes": [{"value": 1, "roughness": 0.02}, {"value": 2, "roughness": 0.01}]}}}
    found = {name: [] for name in made}
    for _ in range(runs):
        for name, one in made.items():
            seconds, run = bench.drive(one, 9.8)
            found[name].append((seconds, run["cache"]["touched"]))
    for name in ("relief", "by_class"):
        kept.add(f"tile.{name}", [(a - b) / count * 1e3 for (a, count), (b, _) in zip(found[name], found["none"])], "ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--only", action="append", choices=[*parts(), "tile"], help="one part; may be given again")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("looks", options.furrow)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options.furrow, pathlib.Path(folder))
        pictures(bench, kept, options.only, options.runs)
        if not options.only or "tile" in options.only:
            tiles(bench, kept, options.runs)
        kept.renderer = bench.renderer
    for key, figure in kept.figures.items():
        print(f"{key}: {figure['value']:.3g} {figure['unit']}")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
