#!/usr/bin/env python3
"""The figures of docs/SCALE.md that follow from others: tables of bodies and of a country, from ranks.json, ranks_again.json and the store's files in
bench/figures. It drives one wheel for a kilometre, for the bytes of its rut. Seconds.

    python3 bench/scale.py build/tools/furrow --figures bench/figures/scale.json

The test house/figures computes them again: run this after bench/ranks.py or bench/store.py.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import marks
import record
from pages import Told
from pages import main as told_main

COUNTRY = 4e11                      # posts: 400,000 km2 at 1 m
COARSER = 4 / 3                     # what all coarser levels add to the finest
GABILAN = 921 * 859                 # posts of gabilan_dtm1m
IMPORTED = 16385 ** 2               # posts of the import that store.json has
RANKS = 16
MACHINES = {"wheels": 4000, "hours": 8, "step": 0.05, "km": 72}   # of each wheel
NETWORKS = {"infiniband": (2e-6, 1e10), "ethernet": (50e-6, 1e10)}  # s, bytes a second; assumed
VEHICLES = 2                        # exchanges a step
METRES = 1000
SCENE = """scene: 1
end_time: 500
spacing: 0.125
redistribute: {model: box}
soil: {name: dry_sand}
objects:
  - {name: wheel, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[20, 30], [1020, 96]], speed: 2}}
cache: {slots: 64}
"""


def value(records, name, key):
    return records[name]["figures"][key]["value"]


def derived(records, rut):
    """(key, value, unit) of each figure that follows. rut: bytes a kilometre of one wheel."""
    w, p = (value(records, "ranks", f"model.{name}") * 1e-6 for name in "wp")

    def step(bodies, ranks):
        return w * bodies / ranks + p * bodies
    pairs = [[value(records, name, key) for name in ("ranks", "ranks_again")] for key in records["ranks"]["figures"] if key.endswith(".busy")]
    yield "series.apart", max(abs(again / once - 1) for once, again in pairs), "times"
    for name in ("ranks", "ranks_again"):
        if value(records, name, "model.p") > 0:
            yield f"half.{name}", math.floor(value(records, name, "model.w") / value(records, name, "model.p")), ""
        for wheels in (100, 400):
            yield f"four_{name}.w{wheels}", value(records, name, f"w{wheels}_r4.busy") / value(records, name, f"w{wheels}_r1.busy"), ""
    off = {key.split(".")[0]: abs(value(records, "ranks", key) / value(records, "ranks", key.replace("modelled", "busy")) - 1)
           for key in records["ranks"]["figures"] if key.endswith(".modelled")}
    yield "model_off.three_ranks", max(share for name, share in off.items() if name.endswith("_r3")), "times"
    yield "model_off.others", max(share for name, share in off.items() if not name.endswith("_r3")), "times"
    yield "moving.most", max(value(records, "ranks", key) for key in records["ranks"]["figures"] if key.endswith(".moving")), "ms"
    for network, (latency, width) in NETWORKS.items():
        for place, exchanges in (("here", value(records, "ranks", "w100_r8.exchanges")), ("vehicles", VEHICLES)):
            yield f"messages.{network}.{place}", exchanges * latency * math.log2(RANKS) + value(records, "ranks", "w400_r8.bytes") / width, "s"
    for bodies in (100, 1000, 10000, 100000):
        yield f"b{bodies}.one", step(bodies, 1) * 1e3, "ms"
        yield f"b{bodies}.sixteen", step(bodies, RANKS) * 1e3, "ms"
        yield f"b{bodies}.rate", 1 / step(bodies, RANKS), ""
    rate = IMPORTED / value(records, "store", "synth_16385.import.furrow")
    yield "import.posts", IMPORTED / 1e6, ""
    yield "import.rate", rate / 1e6, ""
    yield "import.hours", COUNTRY / rate / 3600, ""
    for name, key in (("coarse", "store_full.gabilan_dtm1m.bil.bytes_at_0.1_m.furrow"), ("fine", "store_full.gabilan_dtm1m.bil.bytes.furrow")):
        a_post = value(records, *key.split(".", 1)) / GABILAN
        yield f"store.{name}.a_post", a_post, "B"
        yield f"store.{name}.country", a_post * COUNTRY * COARSER, "B"
    steps = MACHINES["hours"] * 3600 / MACHINES["step"]
    for name, ranks in (("one", 1), ("sixteen", RANKS)):
        seconds = step(MACHINES["wheels"], ranks)
        yield f"machines.{name}.step", seconds, "s"
        yield f"machines.{name}.hours", seconds * steps / 3600, ""
    yield "ruts.a_km", rut, "B"
    yield "ruts.all", rut * MACHINES["wheels"] * MACHINES["km"], "B"


def measured(furrow, kept):
    """The bytes of a kilometre of one wheel's rut, of all levels."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "rut.yaml").write_text(SCENE)
        store = folder / "plain.furrow"
        for words in (("synth", "-o", store, "--posts", "1041x129", "--spacing", "1", "--kind", "plain"),
                      ("drive", folder / "rut.yaml", "--store", store, "-o", folder / "out")):
            done = subprocess.run([furrow, *map(str, words)], capture_output=True, text=True)
            if done.returncode != 0:
                raise Told(done.stderr.strip())
        kept.seen(json.loads((folder / "out" / "run.json").read_text()))
        info = json.loads(subprocess.run([furrow, "info", store, "--json"], check=True, capture_output=True, text=True).stdout)
        return info["bytes"]["offset"] + info["bytes"]["soil"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("scale", options.furrow)
    for key, number, unit in derived(marks.records(), measured(options.furrow, kept)):
        kept.add(key, number, unit)
        print(f"{key}: {number:.4g} {unit}")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
