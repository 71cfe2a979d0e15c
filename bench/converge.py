#!/usr/bin/env python3
"""Whether scm's numbers converge: the command drives wheels at several spacings, directions and places, and each number stands beside its
closed form. Gates are told as met or MISSED.

    python3 bench/converge.py rel/tools/furrow -o bench-out          # about ten minutes; --quick: about one
    python3 bench/converge.py rel/tools/furrow --only steady --only fixed
    python3 bench/converge.py bench-out/converge.jsonl               # tables of an earlier run
"""
import argparse
import json
import pathlib
import sys
import tempfile
import time

import converge_cases
import lanes
import record
from converge_tables import PARTS, at, convergence, furthest, gates_table, grouped, mean, millimetres, order, percent, posts_errors, worst
from pages import publish, table
from validation import COLOURS, Plot


def steady_text(rows):
    found = []
    for rim in ("default", "none"):
        of = [row for row in rows if row["rim_of"] == rim]
        if of:
            found.append(f"{'The default rim' if rim == 'default' else 'No rim'}:\n\n" + convergence({soil: own for (soil,), own in grouped(of, "soil").items()}))
    return "\n".join(found)


def vertical_text(rows):
    return convergence({soil: own for (soil,), own in grouped(rows, "soil").items()})


def fixed_text(rows):
    lines = []
    for (normals, spacing, sink, slip), of in grouped(rows, "normals", "spacing", "sink", "slip").items():
        cells = []
        for key in ("fz", "drawbar", "torque"):
            for form in ("closed_rim", "closed_ground"):
                reference = of[0][form][key]
                cells.append(f"{reference:.1f} ({percent(worst(of, key, lambda _: reference))})")
            cells.insert(-2, f"{mean(of, key):.1f}")
        lines.append([normals, millimetres(spacing), f"{sink:g}", f"{slip:g}", *cells])
    head = ["normals", "spacing", "sink, m", "slip"]
    for name in ("Fz, N", "Fx, N", "My, N m"):
        head += [name, "closed, j of the rim", "closed, j of the ground"]
    return table(head, lines)


def heavy_text(rows):
    spacings = sorted({row["spacing"] for row in rows}, reverse=True)
    lines = []
    for (soil, load, bulldozing), of in grouped(rows, "soil", "load", "bulldozing").items():
        for key in PARTS:
            reference = of[0]["closed"][key] if of[0]["closed"] else None
            cells = []
            for d in spacings:
                here = at(of, d)
                scale = 1e3 if key == "sinkage" else 1
                cells.append(f"{min(row[key] for row in here) * scale:.4g} .. {max(row[key] for row in here) * scale:.4g}")
            ranges = f"{max(row['sinkage_range'] for row in at(of, spacings[-1])) * 1e3:.3g}" if key == "sinkage" else ""
            lines.append([soil, f"{load:g}", f"{bulldozing:g}", key, f"{reference * (1e3 if key == 'sinkage' else 1):.4g}" if reference else "-", *cells, ranges])
    return table(["soil", "load, N", "bulldozing", "mm, N, N m", "closed form, no rim", *(millimetres(d) for d in spacings), "range along the way, mm, finest"],
                 lines)


def passes_text(rows):
    ways = list(grouped(rows, "direction", "spacing"))
    head = ["pass"] + [f"{what}, {millimetres(d)}, {a:g} degrees" for a, d in ways for what in ("sinkage mm", "drawbar N")]
    lines = []
    for (number,), of in grouped(rows, "pass").items():
        by = {(row["direction"], row["spacing"]): row for row in of}
        lines.append([str(number)] + [f"{by[way][key] * scale:.2f}" for way in ways for key, scale in (("sinkage", 1e3), ("drawbar", 1))])
    return table(head, lines)


def loads_text(rows):
    bounds = sorted({row["load"] for row in rows})
    lines = []
    for (soil,), of in grouped(rows, "soil").items():
        by = {row["load"]: row for row in of}
        cells = []
        for load in bounds:
            row = by[load]
            closed = f"{row['closed']['sinkage'] * 1e3:.4g}" if row["closed"] else "none bears it"
            cells.append(f"{percent(row['fz'] / load - 1)}; {row['sinkage'] * 1e3:.4g} mm ({closed}) {row['state']}".strip())
        lines.append([soil, *cells])
    return table(["fz of the load; sinkage (closed form)", *(f"{load:g} N" for load in bounds)], lines)


def crests_text(rows):
    return table(["model", "shape", "spacing", "off the lattice by", "least, mm", "most, mm", "east, mm", "north-east, mm"],
                 [[row["model"], row["shape"], millimetres(row["spacing"]), f"{row['shift']:g} posts"] +
                  [f"{row[key] * 1e3:.1f}" for key in ("least", "most", "east", "northeast")] for row in rows])


def slopes_text(rows):
    lines = []
    for row in rows:
        cells = [f"{row[key]:.4g}" for key in ("fz", "drawbar", "side", "torque", "contact_area")]
        lines.append([row["soil"], f"{row['degrees']:g}", row["lane"], f"{row['load']:g}", *cells, row["state"], row["residual"], percent(row["fz"] / row["load"] - 1)])
    return table(["soil", "degrees", "heading, degrees", "load, N", "fz, N", "drawbar, N", "side force, N", "torque, N m", "area, m2", "state", "residual, N",
                  "fz of the load"], lines)


def speeds_text(rows):
    lines = []
    for (soil, speed), of in grouped(rows, "soil", "speed").items():
        lines.append([soil, f"{speed:g}"] + [f"{min(row[key] for row in of) * scale:.4g} .. {max(row[key] for row in of) * scale:.4g}" for key, scale in
                                             (("sinkage", 1e3), ("drawbar", 1), ("torque", 1))] + [percent(worst(of, "fz", lambda row: row["load"]))])
    return table(["soil", "speed, m/s", "sinkage, mm", "drawbar, N", "torque, N m", "fz of the load"], lines)


def posts_text(rows):
    lines = [[f"{posts:g}", f"{wheel} %", f"{other} %"] for posts, wheel, other in posts_errors(rows)]
    text = table(["posts, at least", "wheels", "other bodies"], lines) + "\nThe worst lane of each; other bodies are held to their mean at 0.5 cm:\n\n"
    of = grouped(rows, "body", "soil", "load", "posts", "spacing")
    return text + table(["body", "soil", "load, N", "spacing", "posts", "error"],
                        [[body, soil, f"{load:.0f}", millimetres(spacing), f"{posts:.2g}", f"{max(map(furthest, lanes)) * 100:.1f} %"]
                         for (body, soil, load, posts, spacing), lanes in of.items()])


def posts_header(rows):
    """src/scene/scene_posts.h"""
    lines = [f"\t{{{posts:g}, {wheel}, {other}}}," for posts, wheel, other in posts_errors(rows)]
    return ("/*\n * How far forces are off, in percent, where so many posts lie below an object: the table \"Few posts below a body\" of\n"
            " * bench/CONVERGE.md. Its bench writes this file, too: python3 bench/converge.py bench-out/converge.jsonl --posts > src/scene/scene_posts.h\n */\n"
            "#ifndef FURROW_SCENE_POSTS_H\n#define FURROW_SCENE_POSTS_H\n\n"
            f"#define SCENE_POSTS_ROWS {len(lines)}\n"
            "/* `posts` or more: no error was larger, of wheels and of other objects. */\n"
            "static const struct {\n\tdouble posts;\n\tint wheel, other;\n} scene_posts[SCENE_POSTS_ROWS] = {\n" + "\n".join(lines) + "\n};\n\n#endif\n")


TEXTS = {"steady": steady_text, "vertical": vertical_text, "fixed": fixed_text, "heavy": heavy_text, "passes": passes_text, "loads": loads_text,
         "slopes": slopes_text, "speeds": speeds_text, "crests": crests_text, "posts": posts_text}
HEADS = {"steady": "Steady rolling at slip 0.2", "vertical": "No rim, no damping, beside vertical normals", "fixed": "Chrono's soft soil at a fixed sinkage, no rim",
         "heavy": "Heavy wheels with a rim", "passes": "Passes in one rut, dry_sand, 800 N", "loads": "Loads from 1 N to 50 kN at 2 cm",
         "slopes": "Loads on slopes at 2 cm", "speeds": "Speeds at 2 cm", "crests": "Rims by direction",
         "posts": "Few posts below a body"}


def page(rows, before=()):
    parts = ["In brackets: the lane that is furthest from the closed form. Of the rim it is furthest from the finest; fz and side force are of the load. "
             "Lanes lie in directions of 0, 22.5 and 45 degrees, on the lattice and off it.\n"]
    for case, text in TEXTS.items():
        of = [row for row in rows if row["case"] == case]
        if of:
            parts.append(f"### {HEADS[case]}\n\n{text(of)}")
    return f"### Gates\n\n{gates_table(rows, before)}\n" + "\n".join(parts)


def draw(rows, before, folder):
    """Errors of the worst lane against the spacing, dashed for an earlier run."""
    for key in PARTS:
        plot = Plot(f"{key}: how far the worst lane is from the closed form, no rim{' (dashed: before)' if before else ''}",
                    ("spacing, cm", 0.4, 10, (0.5, 1, 2, 4, 8)), ("error, %", 0.01, 200, (0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100)), log=True)
        for source, dash in ((rows, ""), (before, "6 3")):
            lines = grouped([row for row in source if row["case"] == "steady" and row["rim_of"] == "none"], "soil")
            for i, ((soil,), of) in enumerate(lines.items()):
                errors = [(d * 100, max(abs(worst(at(of, d), key, lambda row: row["closed"][key])) * 100, 0.0101))
                          for d in sorted({row["spacing"] for row in of})]
                plot.line(soil if not dash else "", errors, COLOURS[i], dash)
                if not dash:
                    plot.dots("", errors, COLOURS[i])
        plot.write(folder / f"converge-{key}.svg")


def keep(kept, rows):
    """Figures: of each number its closed form, what the lanes say on average, and how far the worst lane is off."""
    for (normals, spacing, sink, slip), of in grouped([row for row in rows if row["case"] == "fixed"], "normals", "spacing", "sink", "slip").items():
        form = of[0]["closed_ground" if normals == "ground" else "closed_rim"]
        for key, unit in (("fz", "N"), ("drawbar", "N"), ("torque", "N m")):
            name = f"fixed.{normals}.{spacing * 100:g}cm.sink_{sink:g}.slip_{slip:g}.{key}"
            kept.add(f"{name}.closed", form[key], unit)
            kept.add(name, mean(of, key), unit)
            kept.add(f"{name}.off", abs(worst(of, key, lambda _: form[key])) * 100, "%")
    for (soil, rim), own in grouped([row for row in rows if row["case"] == "steady"], "soil", "rim_of").items():
        for key, unit, scale in (("sinkage", "mm", 1e3), ("drawbar", "N", 1), ("torque", "N m", 1)):
            name = f"steady.{soil}.{rim}_rim.{key}"
            errors = {spacing: worst(at(own, spacing), key, lambda row: row["closed"][key]) for spacing in {row["spacing"] for row in own}}
            kept.add(f"{name}.closed", own[0]["closed"][key] * scale, unit)
            for spacing, error in sorted(errors.items()):
                kept.add(f"{name}.{spacing * 100:g}cm", error * 100, "%")
            if order(errors) is not None:
                kept.add(f"{name}.order", order(errors), "")
    keep_worst(kept, rows)


def keep_worst(kept, rows):
    """Figures of all soils together: the worst by spacing with the rim, of the vertical and the side force, and of ten passes."""
    steady = [row for row in rows if row["case"] == "steady"]
    for (spacing,), own in grouped([row for row in steady if row["rim_of"] == "default"], "spacing").items():
        for key in PARTS:
            kept.add(f"worst.{spacing * 100:g}cm.{key}", abs(worst(own, key, lambda row: row["closed"][key])) * 100, "%")
    loaded = [row for row in rows if row["case"] in ("steady", "slopes", "speeds") or row["case"] == "loads" and row["carried"]]
    if loaded:
        kept.add("fz_off", max(abs(row["fz"] / row["load"] - 1) for row in loaded) * 100, "%")
    if steady:
        kept.add("side_off", max(abs(row["side"]) / row["load"] for row in steady) * 100, "%")
    passes = grouped([row for row in rows if row["case"] == "passes"], "direction", "pass")
    if passes:
        kept.add("passes.apart", max(max(row["sinkage"] for row in own) / min(row["sinkage"] for row in own) - 1 for own in passes.values()) * 100, "%")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow", help="the command; or a file of JSON lines of an earlier run")
    parser.add_argument("-o", "--out", type=pathlib.Path, help="a folder for converge.jsonl, converge.md and plots")
    parser.add_argument("--quick", action="store_true", help="fewer soils, spacings and cases")
    parser.add_argument("--only", action="append", choices=list(converge_cases.CASES), help="one case; may be given again")
    parser.add_argument("--redistribute", default="", help="keys for every scene, as in 'slip_sinkage: 0'")
    parser.add_argument("--soil", default="", help="keys for every soil, as in 'damping: 0'")
    parser.add_argument("--kappa", type=float, default=1.35, help="slip sinkage of the closed forms; 1.35, a scene's default, unless --redistribute gives another")
    parser.add_argument("--normals", choices=("surface", "ground"), help="what a scene of this build means that says nothing of normals")
    parser.add_argument("--before", type=pathlib.Path, help="JSON lines of an earlier run: its gates and plots beside")
    parser.add_argument("--publish", type=pathlib.Path, help="a page; the tables go between its markers")
    parser.add_argument("--posts", action="store_true", help="print src/scene/scene_posts.h of the rows, and nothing else")
    parser.add_argument("--block", default="converge", help="which markers of the page")
    record.add_option(parser)
    options = parser.parse_args()
    kept = None
    if options.furrow.endswith(".jsonl"):
        rows = [json.loads(line) for line in pathlib.Path(options.furrow).read_text().splitlines()]
    else:
        rows, kept = [], record.Record("converge", options.furrow)
        with tempfile.TemporaryDirectory() as folder:
            bench = converge_cases.Bench(options.furrow, folder, ", " * bool(options.redistribute) + options.redistribute,
                                         ", " * bool(options.soil) + options.soil, options.kappa, options.normals)
            for name in options.only or converge_cases.CASES:
                begun = time.monotonic()
                try:
                    for row in converge_cases.CASES[name](bench, options.quick):
                        rows.append(row)
                except lanes.Failed as error:
                    print(f"{name}: {error}", file=sys.stderr)
                print(f"{name}: {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
        kept.seen(bench.run)
        keep(kept, rows)
    if options.posts:
        print(posts_header(rows), end="")
        return 0
    before = [json.loads(line) for line in options.before.read_text().splitlines()] if options.before else []
    text = page(rows, before)
    print(text)
    if kept is not None:
        if not options.only and not options.quick:
            kept.page(options.block, text)
        kept.write(options.figures)
    if options.publish:
        publish(options.publish, options.block, text)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "converge.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
        (options.out / "converge.md").write_text(text)
        if any(row["case"] == "steady" for row in rows):
            draw(rows, before, options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
