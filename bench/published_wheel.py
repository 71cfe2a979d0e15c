#!/usr/bin/env python3
"""A wheel with published figures beside the command. Nothing is fitted to it.

    python3 bench/published_wheel.py build/tools/furrow --plots docs

Ding et al., "Experimental study and analysis on driving wheels' performance for planetary exploration rovers moving in deformable soil",
Journal of Terramechanics 48 (2011) 27-45: wheel and soil of Table 2, sinkage, drawbar pull and torque of Figure 9. The figures were read from
the plot, to about half a millimetre and half a newton.
"""
import argparse
import math
import pathlib
import sys
import tempfile

import lanes
import record
from pages import publish, table
from validation import COLOURS, Plot

RADIUS, WIDTH, LOAD = 0.15735, 0.165, 80.0
SPACING, COARSEST, LENGTH = 0.008, 0.064, 1.2
JANOSI = (0.0097, 0.0114, 0.0131)    # m; the paper gives a range, whose middle is taken
LUGS, LUG_HEIGHT = 30, 0.01
# slip: sinkage mm, drawbar N, torque N m
SMOOTH = {0: (5.0, -6.5, 0.0), 0.1: (5.5, 11.0, 3.0), 0.2: (7.5, 14.5, 4.2), 0.3: (10.0, 15.0, 4.8), 0.4: (12.5, 15.0, 5.0), 0.6: (17.5, 15.0, 5.3)}
LUGGED = {0: (4.5, -6.5, 0.0), 0.1: (5.0, 14.0, 3.5), 0.2: (7.5, 20.0, 5.0), 0.3: (10.5, 22.0, 5.8), 0.4: (14.0, 23.0, 6.3), 0.6: (27.0, 24.5, 7.2)}
NAMES = ("sinkage, mm", "drawbar pull, N", "torque, N m")


def soil_text(janosi):
    return (f"bekker_kc: 15600, bekker_kphi: 2407400, bekker_n: 1.1, cohesion: 250, friction_angle: 31.9, janosi_shear: {janosi!r}, "
            "elastic_stiffness: 4e7, damping: 0, repose: 31.9")


def driven(furrow, store, folder, janosi, redistribute, kept):
    """Returns sinkage, drawbar and torque by slip, of the smooth wheel and of the one with lugs."""
    way = [lanes.Lane(f"{kind}{i}", RADIUS, WIDTH, LOAD, slip=slip, length=LENGTH, speed=0.05, grousers=LUGS * lugged, grouser_height=LUG_HEIGHT * lugged)
           for lugged, (kind, points) in enumerate((("smooth", SMOOTH), ("lugged", LUGGED))) for i, slip in enumerate(points)]
    run = lanes.drive(furrow, store, folder, way, SPACING, soil_text(janosi), redistribute)
    kept.seen(run.run)
    found = {True: {}, False: {}}
    for lane in way:
        mean = lanes.steady(lane, run, 0.6, LENGTH)
        found[lane.grousers > 0][lane.slip] = (mean["sinkage"] * 1e3, mean["drawbar"], mean["torque"])
    return found[False], found[True]


def rms(pairs):
    return math.sqrt(sum((a - b) ** 2 for a, b in pairs) / len(pairs))


def errors_of(measured, told):
    """RMS of sinkage, drawbar and torque. told: by slip, of the middle K."""
    return [rms([(told[slip][k], values[k]) for slip, values in measured.items()]) for k in range(3)]


def keep(kept, name, measured, told):
    """Figures of the middle K: each that was measured, what the command says, and the errors."""
    for slip, values in measured.items():
        for what, unit, value, answer in zip(("sinkage", "drawbar", "torque"), ("mm", "N", "N m"), values, told[slip]):
            kept.add(f"{name}.slip_{slip:g}.{what}_measured", value, unit)
            kept.add(f"{name}.slip_{slip:g}.{what}", answer, unit)
    for what, unit, error in zip(("sinkage", "drawbar", "torque"), ("mm", "N", "N m"), errors_of(measured, told)):
        kept.add(f"{name}.{what}_rms", error, unit)


def compared(measured, told):
    """Text: a table, and the errors. told: of each K."""
    middle, rows = told[len(told) // 2], []
    for slip, values in measured.items():
        cells = [f"{slip:g}"]
        for k, value in enumerate(values):
            ends = sorted(one[slip][k] for one in told)
            cells += [f"{value:.1f}", f"{middle[slip][k]:.1f} ({ends[0]:.1f} .. {ends[-1]:.1f})"]
        rows.append(cells)
    head = ["slip"] + [cell for name in NAMES for cell in (f"measured {name}", "told")]
    errors = errors_of(measured, middle)
    deeper = rms([(middle[slip][0] - middle[0][0], values[0] - measured[0][0]) for slip, values in measured.items() if slip > 0])
    return (table(head, rows) + f"\nRMS: sinkage {errors[0]:.2f} mm, drawbar {errors[1]:.2f} N, torque {errors[2]:.2f} N m. "
            f"What slip adds to the sinkage at slip 0: {deeper:.2f} mm.\n")


def draw(path, measured, told):
    plot = Plot("Smooth wheel of Ding et al. 2011, 80 N; nothing fitted", ("slip", 0, 0.65, (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
                ("sinkage, mm; drawbar pull, N", -10, 35, (-10, 0, 10, 20, 30)))
    for k, (name, colour) in enumerate(zip(("sinkage", "drawbar"), COLOURS)):
        plot.band([(slip, min(one[slip][k] for one in told), max(one[slip][k] for one in told)) for slip in measured], colour)
        plot.line(f"scm, {name}", [(slip, told[len(told) // 2][slip][k]) for slip in measured], colour)
        plot.dots(f"measured, {name}", [(slip, values[k]) for slip, values in measured.items()], colour)
    plot.write(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("--redistribute", default="", help="keys for every scene, as in 'slip_sinkage: 0'")
    parser.add_argument("--plots", type=pathlib.Path, help="a folder for validation-published.svg")
    parser.add_argument("--publish", type=pathlib.Path, help="a page; the tables go between its markers `published`")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("published_wheel", options.furrow)
    extra = ", " * bool(options.redistribute) + options.redistribute
    try:
        with tempfile.TemporaryDirectory() as folder:
            store = lanes.ground(options.furrow, folder, COARSEST)
            told = [driven(options.furrow, store, folder, janosi, extra, kept) for janosi in JANOSI]
    except lanes.Failed as error:
        print(f"published_wheel.py: {error}", file=sys.stderr)
        return 1
    smooth, lugged = ([one[k] for one in told] for k in range(2))
    text = "Smooth wheel:\n\n" + compared(SMOOTH, smooth) + "\nWith 30 lugs of 10 mm:\n\n" + compared(LUGGED, lugged)
    print(text)
    for name, measured, told in (("smooth", SMOOTH, smooth), ("lugged", LUGGED, lugged)):
        keep(kept, name, measured, told[len(told) // 2])
    kept.page("published", text)
    kept.write(options.figures)
    if options.plots:
        draw(options.plots / "validation-published.svg", SMOOTH, smooth)
    if options.publish:
        publish(options.publish, "published", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
