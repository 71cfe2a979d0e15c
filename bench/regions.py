#!/usr/bin/env python3
"""Fixed regions against windows and dynamic regions, and the dissertation's displacement by a depth buffer: tables and plots of bench_regions.

    python3 bench/regions.py build/bench/bench_regions --figures bench/figures/regions.json --publish bench/REGIONS.md --plots docs

It takes some minutes. `--rows FILE` takes the lines that bench_regions printed before, and measures nothing.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import accuracy_plots
import record
from pages import Told, figure, publish, table

WAYS = {"window": "a window each", "batch": "windows together", "fixed": "fixed regions", "dynamic": "dynamic regions"}
PLACES = {0: "in a tile", 1: "on a corner"}
MAPS = ("R8", "R16F", "R32F")
COLOURS = accuracy_plots.COLOURS


def run(program, quick):
    done = subprocess.run([program] + ["quick"] * quick, capture_output=True, text=True)
    if done.returncode != 0:
        raise Told(done.stderr.strip() or f"{program}: ended with {done.returncode}")
    return done.stdout


class Rows:
    """What bench_regions printed."""

    def __init__(self, text):
        rows = [json.loads(line) for line in text.splitlines()]
        self.gl = next(row for row in rows if row["bench"] == "gl")
        self.of = {}
        for row in rows:
            if row["bench"] == "regions":
                self.of[self.key(row)] = row
        self.below = {(row["footprint"], row["way"]): row for row in rows if row["bench"] == "below"}

    @staticmethod
    def key(row):
        return row["set"], row["model"], row["repetitions"], row["footprint"], row["bodies"], row["crossing"], row["margin"], row["way"]

    def find(self, **wanted):
        return [row for row in self.of.values() if all(row[name] == value for name, value in wanted.items())]

    def one(self, **wanted):
        found = self.find(**wanted)
        if len(found) != 1:
            raise Told(f"{len(found)} rows of {wanted}, and there is to be one; measure anew")
        return found[0]

    def beside(self, row):
        """How many times as long as a window of the same job."""
        return row["us"] / self.of[(*self.key(row)[:-1], "window")]["us"]

    def values(self, name, **wanted):
        return sorted({row[name] for row in self.find(**wanted)})


def kilobytes(row):
    return f"{row['copied'] / 1e3:.1f}" if row["copied"] else "0"


def counts(row):
    return [figure(row["passes"], 2), f"{row['copies']:.3g}", kilobytes(row)]


def footprints(rows, model, repetitions):
    head = ["posts across", "where", "window: passes", "copies", "kB", "fixed: passes", "copies", "time", "dynamic: passes", "copies", "kB", "time"]
    lines = []
    for posts in rows.values("footprint", set="footprint"):
        for place in PLACES:
            of = {way: rows.one(set="footprint", model=model, repetitions=repetitions, footprint=posts, crossing=place, way=way) for way in ("window", "fixed", "dynamic")}
            lines.append([str(posts), PLACES[place], *counts(of["window"]), *counts(of["fixed"])[:2], figure(rows.beside(of["fixed"]), 2),
                          *counts(of["dynamic"]), figure(rows.beside(of["dynamic"]), 2)])
    return table(head, lines)


def bodies(rows, model):
    head = ["bodies", "where", "windows together: passes", "time", "fixed: passes", "time", "dynamic: passes", "time", "MB beside the tiles: window", "together", "fixed", "dynamic"]
    lines = []
    for number in rows.values("bodies", set="bodies"):
        for place in PLACES:
            of = {row["way"]: row for row in rows.find(set="bodies", model=model, bodies=number, crossing=place)}
            cells = [str(number), PLACES[place]]
            for way in ("batch", "fixed", "dynamic"):
                cells += [figure(of[way]["passes"], 2), figure(rows.beside(of[way]), 2)] if way in of else ["", ""]
            lines.append(cells + [f"{of[way]['scratch'] / 1e6:.2f}" if way in of else "" for way in WAYS])
    return table(head, lines)


def crossings(rows):
    head = ["share on corners"] + [f"{model}: {WAYS[way]}" for model in ("none", "box") for way in ("batch", "fixed", "dynamic")] + ["fixed: passes (box)", "window: copies (box)"]
    lines = []
    for share in rows.values("crossing", set="crossing"):
        cells = [f"{share * 100:.0f} %"]
        for model in ("none", "box"):
            cells += [figure(rows.beside(rows.one(set="crossing", model=model, crossing=share, way=way)), 2) for way in ("batch", "fixed", "dynamic")]
        cells += [figure(rows.one(set="crossing", model="box", crossing=share, way="fixed")["passes"], 3),
                  figure(rows.one(set="crossing", model="box", crossing=share, way="window")["copies"], 3)]
        lines.append(cells)
    return table(head, lines)


def margins(rows):
    head = ["margin, posts", "16 across: copies", "kB", "time", "64 across: copies", "kB", "time"]
    lines = []
    for margin in rows.values("margin", set="margin"):
        cells = [str(margin)]
        for posts in (16, 64):
            row = rows.one(set="margin", margin=margin, footprint=posts, way="dynamic")
            cells += [f"{row['copies']:.3g}", kilobytes(row), figure(rows.beside(row), 2)]
        lines.append(cells)
    return table(head, lines)


def below(rows):
    head = ["posts across", "deepest, mm", *(f"{name}: rms, mm" for name in MAPS), *(f"{name}: most, mm" for name in MAPS), "envelope: most, mm", *(f"{name}: time" for name in MAPS)]
    lines = []
    for posts in sorted({posts for posts, _ in rows.below}):
        of = {way: rows.below[posts, way] for way in (*MAPS, "envelope")}
        lines.append([str(posts), figure(of["R8"]["depth_mm"], 3), *(figure(of[name]["rms_mm"], 2) for name in MAPS), *(figure(of[name]["most_mm"], 2) for name in MAPS),
                      figure(of["envelope"]["most_mm"], 2), *(figure(of[name]["us"] / of["envelope"]["us"], 2) for name in MAPS)])
    return table(head, lines)


def spread(values):
    low, high = figure(min(values), 2), figure(max(values), 2)
    return low if low == high else f"{low} to {high}"


def verdict(rows):
    """Which way wins where, as ratios."""
    def ratios(way, **wanted):
        return [rows.beside(row) for row in rows.find(way=way, **wanted)]

    def small(way, place, most):
        return [rows.beside(row) for row in rows.find(set="footprint", way=way, crossing=place) if row["footprint"] <= most]

    def large(way, place, least):
        return [rows.beside(row) for row in rows.find(set="footprint", way=way, crossing=place) if row["footprint"] >= least]

    many = {place: [rows.beside(row) for row in rows.find(set="bodies", way="batch", crossing=place) if row["bodies"] >= 16] for place in PLACES}
    lines = [["one body, in a tile, up to 32 posts across", spread(small("fixed", 0, 32)), spread(small("dynamic", 0, 32)), ""],
             ["one body, on a corner, up to 32 posts across", spread(small("fixed", 1, 32)), spread(small("dynamic", 1, 32)), ""],
             ["one body, in a tile, from 64 posts across", spread(large("fixed", 0, 64)), spread(large("dynamic", 0, 64)), ""],
             ["one body, on a corner, from 64 posts across", spread(large("fixed", 1, 64)), spread(large("dynamic", 1, 64)), ""],
             ["16 to 200 bodies, in tiles", spread([rows.beside(r) for r in rows.find(set="bodies", way="fixed", crossing=0) if r["bodies"] >= 16]),
              spread([rows.beside(r) for r in rows.find(set="bodies", way="dynamic", crossing=0) if r["bodies"] >= 16]), spread(many[0])],
             ["16 to 200 bodies, on corners", spread([rows.beside(r) for r in rows.find(set="bodies", way="fixed", crossing=1) if r["bodies"] >= 16]),
              spread([rows.beside(r) for r in rows.find(set="bodies", way="dynamic", crossing=1) if r["bodies"] >= 16]), spread(many[1])]]
    text = f"Times of a contact on {rows.gl['renderer']}, in units of a window's; below 1 the way is faster than a window. Models none and box.\n\n"
    return text + table(["", "fixed regions", "dynamic regions", "windows together"], lines)


# --- plots ---

def plot(title, x, y, series, out, png, log_y=False):
    """series: [(name, colour, dashed, [(x, y)])]."""
    ticks = sorted({at for _, _, _, points in series for at, _ in points})
    ys = [value for _, _, _, points in series for _, value in points]
    lines = ["set encoding utf8", f"set title {accuracy_plots.quoted(title)} font ',15'", f"set xlabel {accuracy_plots.quoted(x)}", f"set ylabel {accuracy_plots.quoted(y)}",
             "set border 3 linecolor rgb '#888888'", "set tics nomirror scale 0.5", "set grid linetype 1 linewidth 0.6 linecolor rgb '#e4e4e4'",
             "set key outside right top Left reverse samplen 2", "set xtics (" + ", ".join(f'"{at:g}" {at!r}' for at in ticks) + ")"]
    if min(ticks) > 0:
        lines += ["set logscale x", f"set xrange [{min(ticks) * 0.9!r}:{max(ticks) * 1.1!r}]"]
    if log_y:
        lines.append("set logscale y")
        lines.append('set format y "%g"')
    else:
        lines.append(f"set yrange [0:{max(ys) * 1.1!r}]")
    drawn = []
    for i, (name, colour, dashed, points) in enumerate(series):
        lines += [f"$s{i} << end", *(f"{at!r} {value!r}" for at, value in points), "end"]
        drawn.append(f"$s{i} with linespoints linewidth 2 dashtype {2 if dashed else 1} pointtype {6 if dashed else 7} pointsize 0.7 linecolor rgb '{colour}' title {accuracy_plots.quoted(name)}")
    lines.append("plot " + ", ".join(drawn))
    for terminal, path in (("svg size 900,460 background rgb 'white' font 'sans,12'", out), ("pngcairo size 900,460 font 'sans,10'", png)):
        if path is None:
            continue
        script = "\n".join([f"set terminal {terminal}", f"set output {accuracy_plots.quoted(str(path))}", *lines, "set output"]) + "\n"
        done = subprocess.run([accuracy_plots.gnuplot(), "-"], input=script, capture_output=True, text=True)
        if done.returncode != 0:
            raise Told(f"gnuplot: {done.stderr.strip()}")


def series(rows, across, ways, where, **wanted):
    found = []
    for way in ways:
        for place in where:
            points = sorted((row[across], rows.beside(row)) for row in rows.find(way=way, crossing=place, **wanted))
            if points:
                found.append((f"{WAYS[way]}, {PLACES[place]}", COLOURS[list(WAYS).index(way)], place == 1, points))
    return found


def plots(rows, folder, pngs):
    unit = "time of a contact / that of a window"

    def paths(name):
        return folder / f"regions-{name}.svg", pngs / f"regions-{name}.png" if pngs else None
    for model in ("none", "box"):
        plot(f"One body, model {model}", "posts across", unit, series(rows, "footprint", ("fixed", "dynamic"), PLACES, set="footprint", model=model, repetitions=1),
             *paths(f"footprint-{model}"))
    plot("Many bodies of 16 posts, model box", "bodies", unit, series(rows, "bodies", ("batch", "fixed", "dynamic"), PLACES, set="bodies", model="box"), *paths("bodies"))
    of = [(WAYS[way], COLOURS[list(WAYS).index(way)], False, sorted((100 * row["crossing"], rows.beside(row)) for row in rows.find(set="crossing", model="box", way=way)))
          for way in ("batch", "fixed", "dynamic")]
    plot("16 bodies of 16 posts, model box", "share of bodies on a corner of four tiles, %", unit, of, *paths("crossing"))
    ways = (*MAPS, "envelope")
    of = [(f"depth buffer, {way}" if way in MAPS else "lower envelope, fixed point", COLOURS[i], way == "envelope",
           sorted((posts, row["most_mm"]) for (posts, name), row in rows.below.items() if name == way)) for i, way in enumerate(ways)]
    plot("Error of a sphere's rut", "posts across", "largest error, mm", of, *paths("below"), log_y=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", help="bench_regions of a release build")
    parser.add_argument("--quick", action="store_true", help="fewer runs")
    parser.add_argument("--rows", type=pathlib.Path, help="lines that bench_regions printed before")
    parser.add_argument("--publish", type=pathlib.Path, help="a page; the tables go between its markers")
    parser.add_argument("--plots", type=pathlib.Path, help="a folder for the SVG files")
    parser.add_argument("--png", type=pathlib.Path, help="a folder for the same plots as PNG")
    record.add_option(parser)
    options = parser.parse_args()
    try:
        kept = record.Record("regions", options.program)
        rows = Rows(options.rows.read_text() if options.rows else run(options.program, options.quick))
        kept.renderer = rows.gl["renderer"]
        parts = {"regions_verdict": verdict(rows), "regions_footprint": footprints(rows, "box", 1), "regions_bodies": bodies(rows, "box"), "regions_crossing": crossings(rows),
                 "regions_margin": margins(rows), "regions_below": below(rows)}
        for row in rows.of.values():
            key = "{set}.{model}_{repetitions}.f{footprint}.b{bodies}.c{crossing}.m{margin}.{way}".format(**row | {"crossing": round(row["crossing"] * 100)})
            kept.add(key, row["us"], "us", rows.gl["runs"])
        for (posts, way), row in rows.below.items():
            kept.add(f"below.f{posts}.{way}.us", row["us"], "us", rows.gl["runs"])
            kept.add(f"below.f{posts}.{way}.most", row["most_mm"], "mm")
        for name, text in parts.items():
            kept.page(name, text)
            if options.publish:
                publish(options.publish, name, text)
        kept.write(options.figures)
        if options.plots:
            plots(rows, options.plots, options.png)
        print(parts["regions_verdict"])
    except Told as error:
        print(f"regions.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
