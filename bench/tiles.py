#!/usr/bin/env python3
"""What tiles for maps and globes take: processor time of `furrow export --tiles`, and bytes. Some two minutes on two quiet cores.

    python3 bench/tiles.py build/tools/furrow N41E001.hgt --figures bench/figures/tiles.json

The DEM is resampled to posts 8 m apart. Terrains of a whole degree have some tens of thousands of tiles.
"""
import argparse
import pathlib
import resource
import subprocess
import sys
import tempfile

import record
from pages import Told
from pages import main as told_main

SPACING = 8  # m


def furrow(options, *words):
    done = subprocess.run([options.furrow, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise Told(f"furrow {words[0]}: {done.stderr.strip()}")


def processor_seconds():
    """Of all commands that ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("dem")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("tiles", options.furrow)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        furrow(options, "import", options.dem, "-o", folder / "dem.furrow", "--spacing", SPACING)
        before = processor_seconds()
        furrow(options, "export", folder / "dem.furrow", "--tiles", folder / "tiles")
        seconds = processor_seconds() - before
        kinds = {}  # the bytes of each tile, by the folder of its kind: terrain, hillshade, ruts, mesh
        for path in sorted((folder / "tiles").glob("*/*/*/*.*")):  # KIND/Z/X/Y.ENDING
            kinds.setdefault(path.relative_to(folder / "tiles").parts[0], []).append(path.stat().st_size)
    count = sum(map(len, kinds.values()))
    kept.add("count", count, "")
    kept.add("processor", seconds, "s")
    kept.add("each", 1e3 * seconds / count, "ms")
    print(f"{count:,} tiles in {seconds:.0f} s of processor time, {1e3 * seconds / count:.2f} ms each")
    for kind, sizes in kinds.items():
        kept.add(f"{kind}.count", len(sizes), "")
        kept.add(f"{kind}.mean", sum(sizes) / len(sizes) / 1e3, "kB")
        print(f"{kind}: {len(sizes):,}, {sum(sizes) / len(sizes) / 1e3:.0f} kB each")
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(told_main(main))
