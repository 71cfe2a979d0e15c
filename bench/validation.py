#!/usr/bin/env python3
"""The soil model against its closed forms and against a measured wheel: tables, and two pictures.

    python3 bench/validation.py build/bench/bench_validation --plots docs --json validation.jsonl

`--quick --figures FILE` writes what VALIDATION.md says of plates and wheels, in a minute or so.
"""
import argparse
import html
import json
import math
import pathlib
import subprocess
import sys

import record

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#7f3c8d", "#11a579", "#a5aa99",
           "#80581f", "#cf1c90")
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 900, 520, 66, 220, 44, 54


class Plot:
    """Axes, linear or logarithmic, with a legend to the right."""

    def __init__(self, title, x, y, log=False):
        """x, y: (name, low, high, ticks)."""
        self.x, self.y, self.log, self.legend = x, y, log, 0
        self.text = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
            'font-size="12"><rect width="100%" height="100%" fill="white"/>',
            f'<text x="{LEFT}" y="22" font-size="15">{html.escape(title)}</text>']
        for tick in x[3]:
            at = self.across(tick)
            self.text.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                             f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{tick:g}</text>')
        for tick in y[3]:
            at = self.up(tick)
            self.text.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{at:.1f}" y2="{at:.1f}" stroke="#ddd"/>'
                             f'<text x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{tick:g}</text>')
        self.text.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 12}" text-anchor="middle">'
                         f'{html.escape(x[0])}</text><text x="6" y="{TOP - 10}">{html.escape(y[0])}</text>')

    def share(self, value, axis):
        low, high = axis[1], axis[2]
        if self.log:
            value, low, high = math.log(value), math.log(low), math.log(high)
        return (value - low) / (high - low)

    def across(self, value):
        return LEFT + (WIDTH - LEFT - RIGHT) * self.share(value, self.x)

    def up(self, value):
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * self.share(value, self.y)

    def inside(self, points):
        return [(x, y) for x, y in points if self.x[1] <= x <= self.x[2] and self.y[1] <= y <= self.y[2]]

    def named(self, name, mark):
        at = TOP + 8 + 18 * self.legend
        self.legend += 1
        self.text.append(mark(WIDTH - RIGHT + 22, at) +
                         f'<text x="{WIDTH - RIGHT + 42}" y="{at + 4}">{html.escape(name)}</text>')

    def line(self, name, points, colour, dash=""):
        drawn = " ".join(f"{self.across(x):.1f},{self.up(y):.1f}" for x, y in self.inside(points))
        style = f'stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"'
        self.text.append(f'<polyline points="{drawn}" fill="none" {style}/>')
        if name:
            self.named(name, lambda x, y: f'<line x1="{x - 12}" x2="{x + 12}" y1="{y}" y2="{y}" {style}/>')

    def band(self, points, colour):
        """points: (x, low, high)."""
        edge = [(x, low) for x, low, _ in points] + [(x, high) for x, _, high in reversed(points)]
        drawn = " ".join(f"{self.across(x):.1f},{self.up(y):.1f}" for x, y in edge)
        self.text.append(f'<polygon points="{drawn}" fill="{colour}" fill-opacity="0.15"/>')

    def dots(self, name, points, colour, filled=True):
        def mark(x, y):
            fill = colour if filled else "none"
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.4" fill="{fill}" stroke="{colour}"/>'
        self.text += [mark(self.across(x), self.up(y)) for x, y in self.inside(points)]
        if name:
            self.named(name, mark)

    def write(self, path):
        path.write_text("\n".join(self.text + ["</svg>\n"]))


def table(head, rows):
    """Markdown, so that a run can be put into the page as it is."""
    print("| " + " | ".join(head) + " |")
    print("|" + " --- |" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print()


def percent(value, of):
    return f"{(value / of - 1) * 100:+.2f} %"


def towed_table(lines):
    rows = []
    for line in lines:
        wanted = line["elastic_arc_mm"]
        rows.append([line["soil"], f'{line["bekker_mm"]:.2f}', f'{line["arc_mm"]:.2f}', f"{wanted:.2f}"] +
                    [f"{mm:.2f} ({percent(mm, wanted)})" for mm, _ in line["posts"].values()] +
                    [percent(wanted, line["bekker_mm"])])
    table(["towed wheel, mm", "Bekker", "exact arc", "and it springs back"] +
          [f"posts of {spacing} mm" for spacing in lines[0]["posts"]] +
          ["model: last closed form to Bekker"], rows)


def rig_tables(lines):
    spacings = list(lines[0]["posts"])
    table(["slip", "measured", "Wong-Reece, loose", "Wong-Reece, compact", "scm, closed"] +
          [f"scm, posts of {spacing} mm" for spacing in spacings],
          [[f'{line["slip"]:g}', f'{line["measured_mm"]:.1f}'] +
           ["{:.2f} ({:.2f} .. {:.2f})".format(*line[name]) for name in
            ("wong_reece_loose_mm", "wong_reece_compact_mm", "scm_mm")] +
           [f'{line["posts"][spacing]["mm"]:.2f}' for spacing in spacings] for line in lines])

    def errors(pairs):
        """rms and greatest in mm, rms of the relative ones."""
        off = [got - wanted for got, wanted in pairs]
        share = [(got / wanted - 1) ** 2 for got, wanted in pairs]
        return (f"{math.sqrt(sum(e * e for e in off) / len(off)):.3f}", f"{max(off, key=abs):+.3f}",
                f"{math.sqrt(sum(share) / len(share)) * 100:.2f} %")

    finest = spacings[-1]
    table(["slip", "drawbar, N: Wong-Reece, loose", "compact", f"scm, posts of {finest} mm", "scm less the soil's yielding"],
          [[f'{line["slip"]:g}', f'{line["wong_reece_loose_drawbar_n"]:.2f}', f'{line["wong_reece_compact_drawbar_n"]:.2f}',
            f'{line["posts"][finest]["drawbar_n"]:.2f}',
            f'{line["posts"][finest]["drawbar_n"] - line["posts"][finest]["resistance_n"]:.2f}'] for line in lines])

    none, rows = ("", "", ""), []
    for name, key in (("Wong-Reece, loose sand", "wong_reece_loose_mm"),
                      ("Wong-Reece, compact sand", "wong_reece_compact_mm"), ("scm, closed form", "scm_mm")):
        rows.append([name, *none, *errors([(line[key][0], line["measured_mm"]) for line in lines])])
        low = [line for line in lines if abs(line["slip"]) <= 0.2]
        rows.append([name + ", slip -0.2 .. 0 alone", *none, *errors([(line[key][0], line["measured_mm"]) for line in low])])
    for spacing in spacings:
        rows.append([f"scm, posts of {spacing} mm",
                     *errors([(line["posts"][spacing]["mm"], line["scm_mm"][0]) for line in lines]), *none])
    table(["", "numerical: rms mm", "greatest mm", "rms share", "model: rms mm", "greatest mm", "rms share"], rows)


def plate_table(lines):
    soils = list(dict.fromkeys(line["soil"] for line in lines))
    spacings = list(lines[0]["posts_kpa"])
    rows = []
    for soil in soils:
        of = [line for line in lines if line["soil"] == soil]
        at = next(line for line in of if line["mm"] == 20)
        rows.append([soil, f'{at["closed_kpa"]:.4g}'] + [f"{kpa:.4g} ({percent(kpa, at['closed_kpa'])})" for kpa in
                                                         at["posts_kpa"].values()])
    table(["plate of 0.1 m, 20 mm deep, kPa", "Bekker"] + [f"posts of {float(spacing):.4g} mm" for spacing in spacings], rows)


def draw(lines, folder):
    rig = [line for line in lines if line["what"] == "rig"]
    plot = Plot("Single-wheel rig of CMU, smooth wheel, 24.5 N (bands: 22 to 27 N): sinkage against slip", ("slip", -0.6, 1, (-0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 1)),
                ("sinkage, mm", 0, 40, range(0, 41, 5)))
    for i, (key, name) in enumerate((("scm_mm", "scm, closed form"), ("wong_reece_loose_mm", "Wong-Reece, loose sand"),
                                     ("wong_reece_compact_mm", "Wong-Reece, compact sand"))):
        plot.band([(line["slip"], line[key][1], line[key][2]) for line in rig], COLOURS[i])
        plot.line(name, [(line["slip"], line[key][0]) for line in rig], COLOURS[i])
    for i, spacing in enumerate(rig[0]["posts"]):
        plot.dots(f"scm, posts of {spacing} mm", [(line["slip"], line["posts"][spacing]["mm"]) for line in rig], COLOURS[3 + i],
                  filled=False)
    plot.dots("measured", [(line["slip"], line["measured_mm"]) for line in rig], "#000000")
    plot.write(folder / "validation-wheel.svg")

    plates = [line for line in lines if line["what"] == "plate"]
    plot = Plot("Plate of 0.1 m: pressure against sinkage (lines: Bekker; dots: posts)", ("sinkage, mm", 1, 200, (1, 2, 5, 10, 20, 50, 100, 200)),
                ("mean pressure, kPa", 0.1, 3000, (0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000)), log=True)
    for i, soil in enumerate(dict.fromkeys(line["soil"] for line in plates)):
        of = [line for line in plates if line["soil"] == soil]
        plot.line(soil, [(line["mm"], line["closed_kpa"]) for line in of], COLOURS[i], "" if i < 6 else "6 2")
        for k, spacing in enumerate(of[0]["posts_kpa"]):
            plot.dots("", [(line["mm"], line["posts_kpa"][spacing]) for line in of], COLOURS[i], filled=k == 1)
    for k, spacing in enumerate(plates[0]["posts_kpa"]):
        plot.dots(f"posts of {float(spacing):.4g} mm", [], "#000000", filled=k == 1)
    plot.write(folder / "validation-plates.svg")


def leaning_table(lines):
    table(["soil", "camber", "sinkage mm", "drawbar N", "side force N"],
          [[line["soil"], f'{line["degrees"]:g}', *(f"{line[key]:.1f}" for key in ("mm", "drawbar_n", "side_n"))] for line in lines])


STIFF = ("heavy_clay_25", "lean_clay_22")   # at 20 mm they yield at K_e z


def keep(kept, lines):
    """Figures: how far plates of 20 mm and towed wheels are from closed forms, and the wheels that lean."""
    plates = [line for line in lines if line["what"] == "plate" and line["mm"] == 20]
    for name, key in (("posts", "posts_kpa"),):
        off = [kpa / line["closed_kpa"] - 1 for line in plates if line["soil"] not in STIFF for kpa in line[key].values()]
        if off:
            kept.add(f"plates.{name}_off", max(map(abs, off)) * 100, "%")
    for line in plates:
        if line["soil"] in STIFF:
            kept.add(f"plates.{line['soil']}.less", (1 - min(line["posts_kpa"].values()) / line["closed_kpa"]) * 100, "%")
    for line in lines:
        if line["what"] == "towed":
            finest, _ = line["posts"][min(line["posts"], key=float)]
            kept.add(f"towed.{line['soil']}.less", (1 - finest / line["elastic_arc_mm"]) * 100, "%")
        elif line["what"] == "leaning":
            for name, key, unit in (("sinkage", "mm", "mm"), ("drawbar", "drawbar_n", "N"), ("side", "side_n", "N")):
                kept.add(f"leaning.{line['soil']}.{line['degrees']:g}.{name}", line[key], unit)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("bench", help="bench_validation; or a file of the lines it printed")
    parser.add_argument("--plots", type=pathlib.Path, help="a folder for the pictures")
    parser.add_argument("--json", type=pathlib.Path, help="a file for the figures, a line each")
    parser.add_argument("--quick", action="store_true", help="without posts of 1 mm")
    record.add_option(parser)
    options = parser.parse_args()
    kept = None if options.bench.endswith(".jsonl") else record.Record("validation", options.bench)
    if options.bench.endswith(".jsonl"):
        text = pathlib.Path(options.bench).read_text()
    else:
        text = subprocess.run([options.bench] + ["quick"] * options.quick, check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [json.loads(line) for line in text.splitlines()]
    if options.json:
        options.json.write_text(text)
    plate_table([line for line in lines if line["what"] == "plate"])
    towed_table([line for line in lines if line["what"] == "towed"])
    leaning_table([line for line in lines if line["what"] == "leaning"])
    rig_tables([line for line in lines if line["what"] == "rig"])
    if kept is not None:
        keep(kept, lines)
        kept.write(options.figures)
    if options.plots:
        options.plots.mkdir(parents=True, exist_ok=True)
        draw(lines, options.plots)
    return 0


if __name__ == "__main__":
    sys.exit(main())
