#!/usr/bin/env python3
"""What a coarse spacing costs where a body slides: forces of a wheel that rolls, of one with bars, a locked one, one at a slip angle, and of a blade, at posts
of a quarter of the wheel's radius to a thirty-second of it.

    python3 bench/faces_error.py build/tools/furrow --figures bench/figures/faces_error.json --publish bench/CONVERGE.md
    python3 bench/faces_error.py build/tools/furrow --header src/scene/scene_faces_errors.h     # what `furrow explain` reads; it takes some minutes, too

Each stands beside the mean of its own lanes at the finest spacing. Lanes lie in three directions, on the lattice and off it. An error is that of the
furthest lane.
"""
import argparse
import dataclasses
import math
import pathlib
import sys
import tempfile

import lanes
import record
from converge_cases import fan
from pages import Told, publish, table

RADIUS, WIDTH, DEPTH = 0.25, 0.2, 0.1
COARSEST = 0.125
SPACINGS = tuple(RADIUS / parts for parts in (4, 8, 16, 32))
SOILS = {"dry_sand": 600.0, "lete_sand": 600.0, "lunar": 400.0}   # N
BARS = {"grousers": 18, "grouser_height": 0.02}


@dataclasses.dataclass
class Case:
    name: str
    what: str
    keys: dict
    blade: bool = False


CASES = (
    Case("rolls", "rolls, slip 0.2", {"slip": 0.2}),
    Case("bars", "bars, slip 0.3", {"slip": 0.3, **BARS}),
    Case("locked", "locked", {"slip": -1000.0}),
    Case("turned", "at 30 degrees, slip 0.2", {"slip": 0.2, "yaw": 30.0}),
    Case("blade", "a blade", {"shape": "box: {size: [0.06, 0.6, 0.4]}", "sink": DEPTH, "load": None, "pitch": 30.0}, blade=True),
)
WHEELS = [case for case in CASES if not case.blade]


def driven(furrow, store, folder, case, soil, spacing, extra):
    """Means of each lane over the last part of its way."""
    keys = {"radius": RADIUS, "width": WIDTH, "load": SOILS[soil], **case.keys}
    way = fan(**keys)
    of = lanes.drive(furrow, store, folder, way, spacing, f"name: {soil}", extra)
    return [lanes.steady(lane, of, 1.0, 1.6) for lane in way]


def errors_of(case, soil, finest, rows):
    """Of the furthest lane: its force in the level as a share of the load (of a blade: of its force), and its sinkage as a share."""
    def mean(key):
        return sum(row[key] for row in finest) / len(finest)
    drawbar, side, sinkage = mean("drawbar"), mean("side"), mean("sinkage")
    scale = math.hypot(drawbar, side) if case.blade else SOILS[soil]
    force = max(math.hypot(row["drawbar"] - drawbar, row["side"] - side) for row in rows) / scale
    return force, 0.0 if case.blade else max(abs(row["sinkage"] / sinkage - 1) for row in rows)


def measure(furrow, folder, extra, progress):
    """{case: {spacing: (force, sinkage)}}, of all soils the most."""
    store = lanes.ground(furrow, folder, COARSEST)
    found = {}
    for case in CASES:
        most = found[case.name] = {spacing: (0.0, 0.0) for spacing in SPACINGS}
        for soil in SOILS:
            rows = {spacing: driven(furrow, store, folder, case, soil, spacing, extra) for spacing in SPACINGS}
            for spacing in SPACINGS:
                here = errors_of(case, soil, rows[SPACINGS[-1]], rows[spacing])
                most[spacing] = tuple(max(a, b) for a, b in zip(most[spacing], here))
            progress(f"{case.what}, {soil}: " + ", ".join(f"{errors_of(case, soil, rows[SPACINGS[-1]], rows[s])[0] * 100:.1f} %" for s in SPACINGS))
    return found


def percent(share):
    return math.ceil(share * 100 - 1e-9)


def text_of(found):
    head = ["posts over the radius", *(case.what for case in WHEELS), "posts over the depth", CASES[-1].what]
    lines = []
    for spacing in SPACINGS:
        cells = [f"{found[case.name][spacing][0] * 100:.1f} %; {found[case.name][spacing][1] * 100:.1f} %" for case in WHEELS]
        lines.append([f"{RADIUS / spacing:g}", *cells, f"{DEPTH / spacing:.3g}", f"{found['blade'][spacing][0] * 100:.1f} %"])
    return ("Level force as a share of the load, then sinkage as a share. Of the blade its force as a share of itself.\n\n" + table(head, lines))


def header_of(found):
    """src/scene/scene_faces_errors.h. An error never grows with finer posts there."""
    def rounded(case):
        return [max(percent(found[case][spacing][0]) for spacing in SPACINGS[i:]) for i in range(len(SPACINGS))]
    wheels = [rounded(case.name) for case in WHEELS]
    rows = [f"\t{{{RADIUS / spacing:g}, {{{', '.join(str(of[i]) for of in wheels)}}}}}," for i, spacing in enumerate(SPACINGS)]
    blades = [f"\t{{{DEPTH / spacing:g}, {error}}}," for spacing, error in zip(SPACINGS, rounded("blade"))]
    names = ", ".join("SCENE_FACES_" + case.name.upper() for case in WHEELS)
    return ("/*\n * How far level forces of a body that slides are off. Of a wheel: in percent of its load, by the posts over its radius. Of a blade: in percent of\n"
            " * its force, by the posts over its depth. bench/faces_error.py measures that and writes this file:\n"
            " * python3 bench/faces_error.py build/tools/furrow --header src/scene/scene_faces_errors.h\n */\n"
            "#ifndef FURROW_SCENE_FACES_ERRORS_H\n#define FURROW_SCENE_FACES_ERRORS_H\n\n"
            f"enum {{ SCENE_FACES_ROWS = {len(rows)} }};\nenum scene_faces_wheel {{ {names}, SCENE_FACES_WHEELS }};\n"
            "static const struct {\n\tdouble posts;\n\tint errors[SCENE_FACES_WHEELS];\n} scene_faces_wheels[SCENE_FACES_ROWS] = {\n" + "\n".join(rows) +
            "\n};\nstatic const struct {\n\tdouble posts;\n\tint error;\n} scene_faces_blades[SCENE_FACES_ROWS] = {\n" + "\n".join(blades) + "\n};\n\n#endif\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("--redistribute", default="faces: on", help="keys for every scene, as in 'faces: off' (faces: on)")
    parser.add_argument("--header", type=pathlib.Path, help="src/scene/scene_faces_errors.h")
    parser.add_argument("--publish", type=pathlib.Path, help="a page; the table goes between its markers `faces`")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("faces_error", options.furrow)
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = measure(options.furrow, folder, ", " * bool(options.redistribute) + options.redistribute, lambda line: print(line, flush=True))
        text = text_of(found)
        print("\n" + text)
        for case, by in found.items():
            for spacing, (force, sinkage) in by.items():
                kept.add(f"{case}.r_{RADIUS / spacing:g}.force", force * 100, "%")
                if case != "blade":
                    kept.add(f"{case}.r_{RADIUS / spacing:g}.sinkage", sinkage * 100, "%")
        kept.page("faces", text)
        kept.write(options.figures)
        if options.header:
            options.header.write_text(header_of(found))
        if options.publish:
            publish(options.publish, "faces", text)
    except (lanes.Failed, Told) as error:
        print(f"faces_error.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
