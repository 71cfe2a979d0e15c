#!/usr/bin/env python3
"""Figures that tests of the soil print: what they ask of closed forms, and what posts say. A minute or two on two quiet cores.

    ninja -C build tests/test_validation tests/test_bearing tests/test_deform     # bench/measure.py --only tested builds what is needed
    python3 bench/tested.py build --figures bench/figures/tested.json

A test prints lines such as "sinkage, mm   19.2946, wanted   19.29: ...". A figure here is a number of such a line: of one test, found by the line's words.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

import record
from pages import Told
from pages import main as told_main

NUMBER = r"([-+]?[\d.]+(?:e[-+]?\d+)?)"
PLATES = ("dry_sand", "sandy_loam_15", "lete_sand", "lunar", "snow_us")
SOILS = ("dry_sand", "lunar", "lete_sand", "snow_us", "sandy_loam_15")
# Files of tests, as folder_file; FURROW_LONG: it prints some figures in the long run alone.
PROGRAMS = {"validation_plate": {}, "validation_wheel": {}, "validation_slope": {}, "validation_rolling": {}, "validation_incline": {},
            "bearing_camber": {}, "bearing_belt": {"FURROW_LONG": "1"}, "deform_envelope": {}}
TARGETS = ["tests/test_validation", "tests/test_bearing", "tests/test_deform"]


class Printed:
    """Lines of a program by its test."""

    def __init__(self, name, text):
        self.name, self.tests, test = name, {}, None
        for line in text.splitlines():
            begun = re.match(r"\[ RUN +\] (.+)", line)
            if begun:
                test = begun[1]
                self.tests[test] = []
            elif test is not None and not line.startswith("["):
                self.tests[test].append(line)

    def all(self, test, pattern):
        """The numbers of each line that has the pattern, whose NUMBER stands for a number: a list of tuples."""
        compiled = re.compile(pattern.replace("NUMBER", NUMBER))
        found = [tuple(map(float, match.groups())) for match in map(compiled.search, self.tests.get(test, [])) if match]
        if not found:
            raise Told(f"{self.name}: {test}: prints no line with \"{pattern}\"; mend bench/tested.py")
        return found

    def near(self, test, what):
        """(got, wanted) of each line of bed_near() with these words."""
        return self.all(test, "^" + re.escape(what) + r" +NUMBER, wanted +NUMBER:")


def run(build, name):
    folder, file = name.split("_", 1)
    program = build / "tests" / f"test_{folder}"
    if not program.is_file():
        raise Told(f"{program}: is not there; ninja -C {build} {' '.join(TARGETS)} builds it")
    done = subprocess.run([program, file], env=os.environ | PROGRAMS[name], capture_output=True, text=True)
    if done.returncode != 0:
        raise Told(f"{name}: failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    if "SKIPPED" in done.stdout + done.stderr:
        raise Told(f"{name}: skips what needs a GPU; run it where EGL gives OpenGL 4.5")
    return Printed(name, done.stdout + done.stderr)


def plates(kept, printed):
    """Tests of tests/validation/plate.c."""
    for soil in PLATES:
        kept.add(f"plate.{soil}.closed", printed.near("a_plate_sinks_after_bekker", soil)[0][0], "mm")
        kept.add(f"plate.{soil}.posts", printed.near("a_plate_of_posts_sinks_as_deep", soil)[0][0] * 1e3, "mm")
    kept.add("plate.between.posts", [got for (got,) in printed.all("a_plate_between_posts_is_off_by_its_rim_at_most", "posts of .* m: NUMBER mm,")], "mm")
    for name, way in (("at_k", "0.025"), ("at_10cm", "0.1")):
        got, wanted = printed.near("a_dragged_plate_is_held_back_by_that_shear", f"shear per area after {way} m, Pa")[0]
        kept.add(f"shear.{name}.posts", got / 1e3, "kPa")
        kept.add(f"shear.{name}.expected", wanted / 1e3, "kPa")
    test = "a_second_equal_load_sinks_no_deeper"
    first = printed.near(test, "sinkage, mm")[0][0]
    kept.add("reload.first.posts", first, "mm")
    kept.add("reload.rebound.posts", printed.near(test, "rebound, mm")[0][0], "mm")
    kept.add("reload.further.posts", abs(printed.near(test, "sinkage under the second load, m")[0][0] * 1e3 - first), "mm")
    for name, what in (("most", "tau, most, kPa"), ("at_k", "tau at K, kPa"), ("at_10cm", "tau at 0.1 m, kPa")):
        kept.add(f"shear.{name}.closed", printed.near("shear_rises_after_janosi", what)[0][0], "kPa")


def wheels(kept, printed):
    """Of tests/validation/wheel.c. Wheels there: lunar at 1 cm and at 1.9 cm, dry_sand at 2 cm on posts and between them."""
    closed = dict(zip(("lunar", "dry_sand"), printed.near("a_towed_wheel_sinks_after_bekker", "its resistance, N")))
    rows = {"lunar": 0, "dry_sand": 2, "dry_sand_between": 3}
    for soil in closed:
        kept.add(f"towed.{soil}.closed", printed.near("a_towed_wheel_sinks_after_bekker", soil)[0][0], "mm")
        kept.add(f"towed.{soil}.resistance.closed", closed[soil][0], "N")
    test = "a_wheel_on_posts_sinks_as_a_towed_one"
    for name, row in rows.items():
        got, arc = printed.near(test, "sinkage, and the arc's, m")[row]
        kept.add(f"towed.{name}.posts", got * 1e3, "mm")
        kept.add(f"towed.{name}.resistance.posts", printed.near(test, "resistance, N")[row][0], "N")
        kept.add(f"towed.{name}.arc", arc * 1e3, "mm")
    elastic = printed.near("a_wheel_on_elastic_soil_sinks_less", "sinkage, and the arc's, m")
    for soil in closed:
        arc = elastic[rows[soil]][1] * 1e3
        kept.add(f"elastic.{soil}.arc", arc, "mm")
        kept.add(f"elastic.{soil}.less", 1 - arc / kept.figures[f"towed.{soil}.closed"]["value"], "times")


def slopes(kept, printed):
    """Of tests/validation/slope.c."""
    kept.add("cut.closed", printed.near("a_vertical_cut_stands_after_culmann", "height, m")[0][0], "m")
    stands = printed.near("a_cut_between_posts_stands_to_that_and_slips_above", "stands, m")
    kept.add("cut.fine.posts", stands[0][0], "m")
    kept.add("cut.coarse.posts", stands[1][0], "m")
    test = "a_pile_of_sand_relaxes_to_its_angle"
    ((_, furthest, face),) = printed.all(test, "NUMBER of tan 30, furthest from the cone NUMBER of a post, steepest face NUMBER")
    kept.add("pile.slope.posts", [got for got, _ in printed.near(test, "slope of ten posts")], "")
    kept.add("pile.furthest.posts", furthest, "")
    kept.add("pile.face.posts", face, "")


def rolling(kept, printed):
    """Of tests/validation/rolling.c: the worst of all surfaces of a rim, at 4, 2 and 1 cm."""
    weak = printed.all("a_rim_weaker_than_the_soil_pulls_as_the_closed_form_does", "posts of NUMBER m: off by Fz NUMBER %, Fx NUMBER %, My NUMBER %")
    for spacing in (0.04, 0.02, 0.01):
        kept.add(f"weak_rim.{spacing * 100:g}cm.fx", max(row[2] for row in weak if row[0] == spacing) / 100, "times")


def others(kept, found):
    """Of tests/validation/incline.c, tests/bearing and tests/deform."""
    ((_, _, off),) = found["validation_incline"].all("the_soil_s_vertical_force_is_the_load", "NUMBER carried, NUMBER sunk; fz is off by NUMBER %")
    kept.add("incline.fz_off", off / 100, "times")
    camber = found["bearing_camber"].all("forces_are_the_integral_over_the_surface", "at NUMBER m: within NUMBER % of the load; .* by NUMBER %")
    kept.add("camber.off", max(row[1] for row in camber) / 100, "times")
    kept.add("camber.jump", max(row[2] for row in camber) / 100, "times")
    envelope = found["deform_envelope"]
    kept.add("envelope.off", max(row[0] for test in envelope.tests if any("um off" in line for line in envelope.tests[test])
                                 for row in envelope.all(test, "others NUMBER um off")) / 1e3, "mm")
    level = found["bearing_belt"].all("a_track_draws_what_the_closed_form_says", "posts of NUMBER m: drawbar off by NUMBER %")
    front = found["bearing_belt"].all("a_front_that_rises_resists_as_the_integral_says", "posts of NUMBER m: drawbar off by NUMBER %")
    for spacing in (0.04, 0.02, 0.01):
        kept.add(f"belt.level.{spacing * 100:g}cm", max(off for at, off in level if at == spacing) / 100, "times")
        kept.add(f"belt.front.{spacing * 100:g}cm", max(off for at, off in front if at == spacing) / 100, "times")
    dug = found["bearing_belt"].all("a_belt_that_slips_digs_by_the_formula", "drawbar NUMBER N for NUMBER")
    kept.add("belt.dug", max(abs(got / wanted - 1) for got, wanted in dug), "times")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path, help="a build folder of meson with these tests")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("tested", options.build / TARGETS[0])
    found = {name: run(options.build, name) for name in PROGRAMS}
    plates(kept, found["validation_plate"])
    wheels(kept, found["validation_wheel"])
    slopes(kept, found["validation_slope"])
    rolling(kept, found["validation_rolling"])
    others(kept, found)
    for key, figure in kept.figures.items():
        print(f"{key}: {figure['value']:.6g} {figure['unit']}")
    kept.write(options.figures)


if __name__ == "__main__":
    told_main(main)
