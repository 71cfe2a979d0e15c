"""The scripts of bench/ that make tables and plots of lines: fronts, labels, pages, what is told. No figure is measured."""
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock
import xml.etree.ElementTree

BENCH = pathlib.Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))
import ablation  # noqa: E402
import accuracy  # noqa: E402
import accuracy_knobs  # noqa: E402
import accuracy_plots  # noqa: E402
import accuracy_study  # noqa: E402
import converge  # noqa: E402
import measure  # noqa: E402
import pages  # noqa: E402
import record  # noqa: E402
import rig  # noqa: E402
import soil_forms  # noqa: E402
import tested  # noqa: E402
import validation  # noqa: E402
from furrow_test import FURROW, long  # noqa: E402


def line(study, knobs, ms, rms=None, default=False, count=1000, picture=None):
    made = {"bench": "accuracy", "study": study, "knobs": knobs, "default": default, "ms_step": ms, "bytes": count,
            "bytes_of": "slots", "gl": "a renderer", "ms_runs": [ms * share for share in (1, 0.99, 1.01, 0.98, 1.02)]}
    if rms is not None:
        made["error"] = {"max": 3 * rms, "rms": rms, "volume": rms / 2}
    if picture:
        made["picture"] = {"psnr": picture[0], "worst": picture[1]}
    return made


LINES = [line("spacing", {"model": model, "spacing": 1 / n}, cost * n, 0.01 * worse / n, default=(model, n) == ("scm", 4), count=1000 * n * n)
         for model, cost, worse in (("none", 0.01, 1), ("scm", 0.1, 2)) for n in (1, 4, 16)]
LINES += [line("offset_format", {"offset_format": name}, ms, rms, name == "R32I") for name, ms, rms in
          (("R8", 0.2, 0.003), ("R16F", 0.3, 0.004), ("R32I", 0.25, 0))]
LINES += [line("import_error", {"import_error": n}, 0.2, 0.01 + n, n == 0.001, count=int(1000 / (n + 0.1))) for n in (0, 0.001, 0.5)]
LINES += [line("durability", {"durability": name}, ms, default=name == "normal") for name, ms in (("normal", 0.2), ("full", 0.9))]
LINES += [line("pairs", {"spacing": 1 / n, "iterations": i}, 0.1 * n * i, 0.01 / n / i) for n in (1, 4) for i in (1, 2)]
LINES += [line("pairs", {"spacing": 1 / n, "interval": i}, 0.1 * n / i, 0.01 / n * i) for n in (1, 4) for i in (0.02, 0.05)]
LINES += [line("settled", {"spacing": 1 / n, "interval": 0.01 / n}, n, 0.01 / n) for n in (1, 2)]
LINES += [line("time_step", {"time_step": n}, 0.1 * n, 0.01) | {"ms_second": 7.0} for n in (1, 2)]
LINES += [line("pixel_error", {"pixel_error": n}, 20 / n, default=n == 1, picture=(None, 0) if n == 0.5 else (50 / n, 20 * n)) for n in (0.5, 1, 4)]


LINES += [line("force", {"body": body, "spacing": n}, 1 / n) | {"truth": f"{body} at 1 mm", "cost": "ms a metre", "bytes": None, "off": {"what": "drawbar off, %", "value": worse * n, "floor": 0.5}}
          for body, worse in (("wheel", 10), ("blade", 90)) for n in (0.08, 0.02, 0.01)]
LINES += [line("force_soft", {"program": name, "spacing": n}, 1 / n) | {"truth": f"{name}'s own", "cost": "ms a metre", "bytes": None, "off": {"what": "drawbar off, %", "value": n, "floor": 0}} | more
          for name, more in (("Furrow", {}), ("Chrono", {"ms_runs": [], "source": "words"})) for n in (0.08, 0.02)]
# In the order of the tables, as plots are named.
NAMES = ["spacing", "settled", "offset_format", "time_step", "import_error", "durability", "pairs_spacing_iterations", "pairs_spacing_interval", "pixel_error", "force", "force_soft"]


def beaten(point, points):
    """As the words say it: by a more exact one that took less in one of its runs than this one in any; by one as exact that took less in all."""
    return any(other[3] < point[3] and not point[2] < other[0] or other[3] == point[3] and other[2] < point[0] for other in points)


class Ablation(unittest.TestCase):
    def test_every_effect_has_a_pair_that_calls_for_it(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.object(ablation, "SIDE", 40):
            bench = ablation.Bench(os.environ["FURROW"], pathlib.Path(folder))
            changes, lacking = bench.changes(ablation.PAIRS)
        self.assertEqual(lacking, [])
        for (name, _, _), (brings, _) in zip(ablation.PAIRS, changes):
            self.assertTrue(name in brings or name == "images", (name, brings))


class Front(unittest.TestCase):
    def test_is_what_no_other_beats(self):
        chance = random.Random(1)
        for _ in range(300):
            points = []
            for _ in range(chance.randrange(9)):
                least = chance.randrange(6)
                points.append((least, least + 0.5, least + chance.randrange(1, 4), chance.randrange(6)))
            wanted = [i for i, point in enumerate(points) if not beaten(point, points)]
            self.assertEqual(accuracy_study.front(points), wanted, points)

    def test_a_gap_within_the_spread_counts_for_nothing(self):
        quick, slow = (1, 1, 1, 2), (2, 2, 2, 1)
        self.assertEqual(accuracy_study.front([quick, slow]), [0, 1])
        self.assertEqual(accuracy_study.front([(1, 1, 2, 2), slow]), [1])
        self.assertEqual(accuracy_study.front([quick, (1, 2, 3, 1)]), [1])

    def test_of_equals_keeps_all_and_of_ties_the_better(self):
        self.assertEqual(accuracy_study.front([(1, 1, 1, 2), (1, 1, 1, 2), (1, 1, 1, 3), (2, 2, 2, 2)]), [0, 1])

    def test_leaves_out_what_is_not_known(self):
        self.assertEqual(accuracy_study.front([(1, 1, 1, None), (float("nan"), 1, 1, 0), (None, 1, None, 0), (3, 3, 3, 4)]), [3])
        self.assertEqual(accuracy_study.front([]), [])


class Studies(unittest.TestCase):
    def setUp(self):
        self.lines = [accuracy_study.parse(json.dumps(one), "here") for one in LINES]
        self.found = {study.name: study for study in accuracy_study.studies(self.lines)}

    def test_pairs_are_parted_by_their_knobs(self):
        self.assertEqual(list(self.found), NAMES)

    def test_points_of_different_truths_are_not_compared(self):
        for name in ("spacing", "force"):
            study = self.found[name]
            for against in study.truths():
                own = [one for one in study.lines if accuracy_study.truth(one) == against]
                alone = accuracy_study.Study(name, own)
                on = accuracy_study.best(study, study.range_of_cost, accuracy_study.exactness(study))
                self.assertEqual([id(one) in on for one in own],
                                 [id(one) in accuracy_study.best(alone, alone.range_of_cost, accuracy_study.exactness(alone)) for one in own])
        one = self.lines[0]
        with self.assertRaisesRegex(pages.Told, "cannot be compared"):
            accuracy_study.studies([one | {"truth": "a"}, one | {"truth": "b"}])

    def test_less_than_the_truth_knows_is_no_better(self):
        head, rows = accuracy_study.rows(self.found["force"])
        self.assertEqual([row[head.index("drawbar off, %")] for row in rows], ["0.800", "at most 0.500", "at most 0.500", "7.20", "1.80", "0.900"])
        self.assertEqual([row[-1] for row in rows], ["●", "●", "", "●", "●", "●"])
        self.assertNotIn("bytes", head)
        self.assertEqual(rows[0][head.index("runs")], "5: 12.2 to 12.8")

    def test_a_time_without_runs_is_on_no_front(self):
        head, rows = accuracy_study.rows(self.found["force_soft"])
        self.assertEqual([(row[head.index("runs")], row[-1]) for row in rows], [("5: 12.2 to 12.8", "●"), ("5: 49.0 to 51.0", "●"), ("elsewhere", ""), ("elsewhere", "")])

    def test_a_model_is_compared_with_itself_only(self):
        head, rows = accuracy_study.rows(self.found["spacing"])
        self.assertEqual([row[head.index("front")] for row in rows], ["●"] * 6)

    def test_what_is_beaten_is_not_marked_and_the_default_is(self):
        head, rows = accuracy_study.rows(self.found["offset_format"])
        self.assertEqual([row[-1] for row in rows], ["●", "", "●"])
        self.assertEqual([row[0] for row in rows], ["R8", "R16F", "**R32I** (default)"])
        self.assertEqual(rows[0][head.index("error, RMS, mm")], "3.00")
        self.assertEqual(rows[0][head.index("max")], "9.00")
        self.assertEqual(rows[0][head.index("net, l")], "1.50")
        self.assertEqual(rows[0][head.index("bytes")], "1.00 kB")

    def test_pictures_that_are_the_same_are_the_most_exact(self):
        head, rows = accuracy_study.rows(self.found["pixel_error"])
        self.assertEqual([row[1:3] for row in rows], [["same", "0"], ["**50.0**", "**20**"], ["12.5", "80"]])
        self.assertEqual([row[-1] for row in rows], ["●"] * 3)

    def test_values_read_as_people_write_them(self):
        for knob, said, text in (("spacing", 0.0625, "1/16 m"), ("spacing", 1, "1 m"), ("spacing", 0.3, "30 cm"), ("spacing", 0.04, "4 cm"), ("spacing", 0.005, "5 mm"), ("import_error", 0.1, "10 cm"),
                                 ("import_error", 0.001, "1 mm"), ("import_error", 0, "0"), ("time_step", 0.02, "20 ms"),
                                 ("pixel_error", 2, "2 px"), ("pixel_error", None, "by radii"), ("iterations", 4, "4"), ("offset_format", "R16F", "R16F")):
            self.assertEqual(accuracy_study.value(knob, said), text)

    def test_steps_of_other_lengths_are_compared_by_the_second(self):
        head, rows = accuracy_study.rows(self.found["time_step"])
        self.assertEqual([row[head.index("ms a simulated second")] for row in rows], ["7.00"] * 2)
        self.assertIn("ms a step", accuracy_study.rows(self.found["durability"])[0])

    def test_points_are_coloured_by_a_knob_of_which_some_have_the_same(self):
        self.assertEqual([self.found[name].series for name in ("spacing", "settled", "durability", "pairs_spacing_interval")],
                         ["model", None, None, "spacing"])
        settled = self.found["settled"]
        self.assertEqual(settled.label(settled.lines[1]), "1/2 m, 5 ms")

    def test_lines_that_are_none_are_told(self):
        self.assertIsNone(accuracy_study.parse('{"bench": "deform"}', "here"))
        for bad in ("{", '{"bench": "accuracy"}', json.dumps(LINES[0] | {"ms_step": "fast"}), json.dumps(LINES[0] | {"knobs": []}), json.dumps(LINES[0] | {"ms_runs": [1, None]}),
                    json.dumps(LINES[0] | {"ms_runs": [9000]}), json.dumps(LINES[0] | {"off": {"what": "it"}})):
            with self.assertRaisesRegex(pages.Told, "^here: .*; "):
                accuracy_study.parse(bad, "here")


class Knobs(unittest.TestCase):
    """Studies that the command measures."""

    def measured(self, *names):
        with tempfile.TemporaryDirectory() as folder:
            return [accuracy_study.parse(json.dumps(one), "here") for one in accuracy_knobs.measured(FURROW, folder, 2, True, lambda *_: None, names)]

    def test_settings_take_turns_and_must_say_the_same_again(self):
        said = []

        def setting(name, results):
            return accuracy_knobs.Setting({"it": name}, False, lambda: (said.append(name), (results.pop(0), 1.0, None))[1])
        found = accuracy_knobs.in_turn([setting("a", [1, 1, 1]), setting("b", [2, 2, 2])], 3, lambda _: None)
        self.assertEqual((said, found), (["a", "b"] * 3, [(1, [1.0] * 3, None), (2, [1.0] * 3, None)]))
        with self.assertRaisesRegex(pages.Told, "another result"):
            accuracy_knobs.in_turn([setting("a", [1, 3])], 2, lambda _: None)

    def test_balls_are_closed_round_and_turned_outwards(self):
        for triangles in (20, 80, 320):
            corners, faces = accuracy_knobs.sphere(triangles, 2)
            self.assertEqual(len({(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1])}), 3 * triangles)
            self.assertTrue(all(abs(sum(n * n for n in corner) - 4) < 1e-9 for corner in corners))
            volume = 0
            for a, b, c in ([corners[i] for i in face] for face in faces):
                volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
            self.assertTrue(0.6 * 33.5 < volume < 33.51, volume)
        with self.assertRaisesRegex(pages.Told, "not 100"):
            accuracy_knobs.sphere(100, 1)

    def test_figures_of_chrono_are_against_a_truth_of_their_own(self):
        found = list(accuracy_knobs.chrono())
        self.assertEqual([one["ms_step"] for one in found], [856, 3550, 13861, 20, 158, 1388])
        self.assertEqual([round(one["off"]["value"], 2) for one in found if "off" in one], [0.76, 0.56])
        self.assertTrue(all("Chrono" in one["truth"] and one["source"] and not one["ms_runs"] for one in found))

    def test_more_triangles_are_nearer_to_the_finest_mesh(self):
        found = {one["knobs"]["triangles"]: one["off"] for one in self.measured("mesh_triangles")}
        self.assertEqual(list(found), [80, 320])
        self.assertLess(found[320]["value"], found[80]["value"])

    @long
    def test_each_study_has_finite_errors_and_the_spread_of_its_runs(self):
        found = self.measured(*accuracy_knobs.STUDIES)
        self.assertEqual(list(dict.fromkeys(one["study"] for one in found)), list(accuracy_knobs.STUDIES))
        for one in found:
            self.assertEqual(len(one["ms_runs"]), 0 if "source" in one else 2)
            self.assertTrue(one["off"] is None or 0 <= one["off"]["value"] < 500, one)
        force = {(one["knobs"]["body"], one["knobs"]["spacing"]): one["off"]["value"] for one in found if one["study"] == "force"}
        for body in accuracy_knobs.BODIES:
            self.assertLess(force[body, 0.02], force[body, 0.08], body)


class Labels(unittest.TestCase):
    def test_beside_points_with_room_cover_nothing(self):
        points = [accuracy_plots.Point(x, y, f"number {x}", "", x == 3, True) for x, y in ((1, 5), (1.2, 5), (1.2, 4.9), (3, 2), (3.2, 2), (5, 1))]
        across = accuracy_plots.Axis("x", [1, 5], 0.1, 0.9)
        up = accuracy_plots.Axis("y", [1, 5], 0.1, 0.9)
        said = accuracy_plots.labels(points, [], {"": "#000000"}, across, up, 0.97)
        self.assertIn('"default: number 3"', said[0])
        boxes = []
        for command in said:
            text = command.split('"')[1]
            x, y = map(float, command.split(" at screen ")[1].split()[0].split(","))
            wide = accuracy_plots.LETTER * len(text) / accuracy_plots.WIDTH / 2
            high = accuracy_plots.LINE / accuracy_plots.HEIGHT / 2
            boxes.append((x - wide, y - high, x + wide, y + high))
        for i, box in enumerate(boxes):
            self.assertFalse(any(accuracy_plots.overlap(box, other) for other in boxes[:i]))
            for point in points:
                x, y = across.share(point.x), up.share(point.y)
                self.assertFalse(box[0] < x < box[2] and box[1] < y < box[3])

    def test_axes_hold_their_values_and_zero_below_a_logarithm(self):
        axis = accuracy_plots.Axis("error", [0, 0.001, 10], 0.1, 0.9, log=True)
        self.assertTrue(0.1 < axis.share(0) < axis.share(0.001) < axis.share(10) < 0.9)
        self.assertEqual(axis.ticks[-1][0], "exact")
        self.assertTrue(all(0.1 <= axis.share(at) <= 0.9 for _, at in axis.ticks))
        even = accuracy_plots.Axis("ms", [2, 7], 0, 1)
        self.assertTrue(3 <= len(even.ticks) <= 8)


class Pages(unittest.TestCase):
    PAGE = "before\n<!-- it: begin -->\nold\n<!-- it: end -->\nafter\n"

    def test_only_what_is_between_the_markers_changes(self):
        changed = pages.between(self.PAGE, "it", "new\n\n")
        self.assertEqual(changed, self.PAGE.replace("old", "new"))
        self.assertEqual(pages.between(changed, "it", "new"), changed)

    def test_no_place_and_two_places_are_told(self):
        for page in ("", self.PAGE * 2, "<!-- it: begin -->\n" + self.PAGE, self.PAGE + "<!-- it: end -->", self.PAGE.replace("begin", "end"), "<!-- it: end --> <!-- it: begin -->"):
            with self.assertRaisesRegex(pages.Told, "; "):
                pages.between(page, "it", "new")

    def test_the_pages_that_are_published_to_have_their_places(self):
        root = BENCH.parent
        for path, name in ((root / "docs" / "BENCHMARKS.md", "accuracy"), (BENCH / "ACCURACY.md", "accuracy"), (BENCH / "ACCURACY.md", "ablation")):
            pages.between(path.read_text(), name, "new")

    def test_figures_have_three_digits(self):
        for value, text in ((0, "0"), (None, "-"), (1.23456, "1.23"), (0.0123456, "0.0123"), (1234.5, "1,234"), (2e-7, "2.00e-07")):
            self.assertEqual(pages.figure(value), text)


class Kept(unittest.TestCase):
    """Figures that benches of the soil keep."""

    def kept(self):
        return record.Record("soil_forms", None)

    def values(self, kept):
        return {key: figure["value"] for key, figure in kept.figures.items()}

    def test_lines_that_tests_print_are_found_by_their_test(self):
        printed = tested.Printed("a", "[ RUN      ] one (gpu)\nsinkage, mm    1.5e-3, wanted    2: -0.1 %, allowed 1 %\nposts of 0.1 m: 3 mm\n[       OK ] one (gpu)\n"
                                      "[ RUN      ] two\nsinkage, mm    4, wanted    5: +1 %\n")
        self.assertEqual(printed.near("one (gpu)", "sinkage, mm"), [(0.0015, 2)])
        self.assertEqual(printed.near("two", "sinkage, mm"), [(4, 5)])
        self.assertEqual(printed.all("one (gpu)", "posts of NUMBER m: NUMBER mm"), [(0.1, 3)])
        for test, pattern in (("two", "posts of NUMBER m"), ("three", "sinkage")):
            with self.assertRaisesRegex(pages.Told, test):
                printed.all(test, pattern)

    def test_a_case_of_the_closed_forms_has_a_key_of_its_own(self):
        keys = [soil_forms.key_of(name, wheel, load, depth, slip, law) for name, wheel, load, depth, slip, law in soil_forms.cases()]
        self.assertEqual(len(set(keys)), len(keys))
        self.assertIn("dry_sand.surface_rim.slip_0.2.load_1000.delta_15", keys)
        self.assertAlmostEqual(soil_forms.stiff_to(soil_forms.named("heavy_clay_25"), 0.1), 0.0262, places=4)

    def test_the_worst_of_converging_wheels_is_kept(self):
        row = {"case": "steady", "soil": "a", "rim_of": "default", "spacing": 0.02, "load": 100, "fz": 101, "side": -0.5, "sinkage": 1.1, "drawbar": 1, "torque": 1,
               "closed": {"sinkage": 1, "drawbar": 1, "torque": 1}}
        kept = self.kept()
        converge.keep(kept, [row, row | {"soil": "b", "sinkage": 0.8}, {"case": "passes", "direction": 0, "pass": 1, "sinkage": 1},
                             {"case": "passes", "direction": 0, "pass": 1, "sinkage": 1.05}])
        for key, value in (("worst.2cm.sinkage", 20), ("fz_off", 1), ("side_off", 0.5), ("passes.apart", 5)):
            self.assertAlmostEqual(self.values(kept)[key], value)

    def test_plates_and_wheels_are_kept(self):
        kept = self.kept()
        validation.keep(kept, [{"what": "plate", "soil": "lunar", "mm": 20, "closed_kpa": 10, "posts_kpa": {"4": 10.1, "1": 10}, "gpu_kpa": {}},
                               {"what": "plate", "soil": "lean_clay_22", "mm": 20, "closed_kpa": 10, "posts_kpa": {"4": 9}, "gpu_kpa": {}},
                               {"what": "towed", "soil": "lunar", "elastic_arc_mm": 20, "posts": {"40": [1, 1], "10": [19, 1]}},
                               {"what": "leaning", "soil": "lunar", "degrees": 1, "mm": 3, "drawbar_n": 4, "side_n": 5}])
        wanted = {"plates.posts_off": 1, "plates.lean_clay_22.less": 10, "towed.lunar.less": 5, "leaning.lunar.1.sinkage": 3, "leaning.lunar.1.drawbar": 4,
                  "leaning.lunar.1.side": 5}
        self.assertEqual({key: round(value, 9) for key, value in self.values(kept).items()}, wanted)

    def test_slips_of_the_measured_wheel_are_counted_as_the_rig_does(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "wheel_smooth.csv").write_text("slip_angle_deg,slip,rim_mm_s,way_mm_s,lateral_N,drag_N,load_N,sinkage_mm\n0,-0.5,5,10,0,7,24,20\n"
                                                     "0,0.5,20,10,0,-1,24,21\n30,0.5,20,10,0,-1,24,21\n0,-1,0,10,0,9,24,50\n")
            self.assertEqual(rig.trials(folder, folder / "out.csv"), [-1.0, 0.5])
            self.assertEqual((folder / "out.csv").read_text(), "slip,sinkage_mm,drag_N\n-1.0000,20.0,7.0\n0.5000,21.0,-1.0\n")

    def test_measure_knows_each_file_that_it_names(self):
        names = {step.name for step in measure.steps(measure.argparse.Namespace(build=pathlib.Path("build"), dem=None, rig=None, big=None))}
        self.assertLessEqual(set(measure.LONG), names)
        self.assertLessEqual(names, {path.stem for path in (BENCH / "figures").glob("*.json")})


class Script(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="furrow-bench-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        (self.folder / "lines").write_text("".join(json.dumps(one) + "\n" for one in LINES))
        self.out = self.folder / "out"

    def accuracy(self, *arguments, path=None):
        environment = dict(os.environ, **({"PATH": path} if path else {}))
        return subprocess.run([sys.executable, str(BENCH / "accuracy.py"), *map(str, arguments), "-o", str(self.out)],
                              capture_output=True, text=True, env=environment, timeout=120)

    def written(self):
        return {path.name for path in self.out.iterdir()}

    @unittest.skipUnless(shutil.which("gnuplot"), "no gnuplot here")
    def test_draws_every_study_with_its_values_and_the_default_named(self):
        done = self.accuracy("--from", self.folder / "lines")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        names = {"spacing", "spacing-bytes", "offset_format", "durability", "pairs_spacing_iterations", "pairs_spacing_iterations-bytes",
                 "pairs_spacing_interval", "pairs_spacing_interval-bytes", "pixel_error", "pixel_error-worst", "force", "force_soft"}
        made = self.written()
        self.assertLessEqual({f"{name}.{kind}" for name in names for kind in ("svg", "png", "gnuplot")}, made)
        self.assertFalse([name for name in made if name.endswith(".part")])
        for name in made:
            self.assertGreater((self.out / name).stat().st_size, 100, name)
        texts = "|".join(xml.etree.ElementTree.parse(self.out / "spacing.svg").getroot().itertext())
        for text in ("default: scm, 1/4 m", "1/16 m", "scm", "error, RMS, mm  (beside the points: spacing)", "ms a step"):
            self.assertIn(text, texts)
        self.assertNotIn("front", texts)  # one of all models would be of different truths
        self.assertFalse((self.out / "force-bytes.svg").exists())
        texts = "|".join(xml.etree.ElementTree.parse(self.out / "offset_format.svg").getroot().itertext())
        for text in ("Pareto front", "default: R32I", "exact", "R16F"):
            self.assertIn(text, texts)
        self.assertEqual(len((self.out / "accuracy.jsonl").read_text().splitlines()), len(LINES))
        again = self.accuracy("--from", self.out / "accuracy.jsonl")
        self.assertEqual(again.stdout, done.stdout)

    @unittest.skipUnless(shutil.which("gnuplot"), "no gnuplot here")
    def test_publishes_tables_and_pictures_that_its_pages_show(self):
        root = self.folder / "root"
        shutil.copytree(BENCH, root / "bench", ignore=lambda *_: ["__pycache__"])
        (root / "docs").mkdir()
        shutil.copy(BENCH.parent / "docs" / "BENCHMARKS.md", root / "docs")
        shutil.copy(BENCH.parent / "README.md", root)
        command = [sys.executable, str(root / "bench" / "accuracy.py"), "-o", str(self.out), "--publish", "--from"]
        for _ in range(2):  # what was published is published over
            done = subprocess.run([*command, str(self.folder / "lines")], capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
        for page, row in (("README.md", "(docs/accuracy-force.svg)"), ("docs/BENCHMARKS.md", "**5.00 / 0.400**"), ("bench/ACCURACY.md", "### Format of the offset")):
            text = (root / page).read_text()
            self.assertEqual(text.count(row), 1)
            self.assertNotIn("accuracy.py -o bench-out --publish` writes", text)
            shown = re.findall(r"!\[[^\]]*\]\((\S*accuracy-\S*)\)", text)
            self.assertEqual(len(shown), len(accuracy.PUBLISHED) if page == "bench/ACCURACY.md" else 1)
            for name in shown:
                self.assertTrue((root / page).parent.joinpath(name).exists(), name)
        few = LINES[0] | {"ms_runs": [LINES[0]["ms_step"]]}
        for lines, said in (([LINES[0]], "not drawn"), ([few, *LINES[1:]], "1 runs; 5 are published")):
            (self.folder / "lines").write_text("".join(json.dumps(one) + "\n" for one in lines))
            done = subprocess.run([*command, str(self.folder / "lines")], capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, 1)
            self.assertIn(said, done.stderr)

    def test_without_gnuplot_says_which_package_and_keeps_lines_and_table(self):
        done = self.accuracy("--from", self.folder / "lines", path="/nonexistent")
        self.assertEqual(done.returncode, 1)
        self.assertIn("gnuplot-nox", done.stderr)
        self.assertEqual(self.written(), {"accuracy.jsonl", "accuracy.md"})

    def test_bad_lines_and_absent_programs_are_told(self):
        (self.folder / "lines").write_text('{"bench": "deform"}\n{"bench": "accuracy"}\n')
        done = self.accuracy("--from", self.folder / "lines")
        self.assertEqual(done.returncode, 1)
        self.assertIn("lines:2", done.stderr)
        (self.folder / "lines").write_text('{"bench": "deform"}\n')
        self.assertEqual(self.accuracy("--from", self.folder / "lines").returncode, 1)
        self.assertFalse((self.out / "accuracy.jsonl").exists())
        self.assertEqual(self.accuracy("--from", self.folder / "absent").returncode, 1)
        self.assertEqual(self.accuracy("--build", self.folder).returncode, 2)

    def programs(self, *texts):
        (self.folder / "bench").mkdir()
        for name, text in zip(("bench_accuracy", "bench_picture_error"), texts):
            path = self.folder / "bench" / name
            path.write_text("#!/bin/sh\n" + text)
            path.chmod(0o755)
        (self.folder / "tools").mkdir()
        (self.folder / "tools" / "furrow").write_text("#!/bin/sh\necho it fails >&2; exit 1\n")
        (self.folder / "tools" / "furrow").chmod(0o755)

    def test_runs_both_programs_and_the_command(self):
        said = "echo 'spacing {\"spacing\": 1}' >&2; echo 'furrow: note: of a scene' >&2; echo 'bench: it warns' >&2\n"
        self.programs(*(f"{said}grep {'-v ' * invert}pixel_error {self.folder / 'lines'}\n" for invert in (1, 0)))
        done = self.accuracy("--build", self.folder)
        self.assertEqual([text for text in done.stderr.splitlines() if "gnuplot" not in text], ["bench: it warns"] * 2 + ["accuracy.py: force: it fails"])
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len((self.out / "accuracy.jsonl.part").read_text().splitlines()), len(LINES))

    @long
    def test_pictures_are_more_like_the_true_one_at_a_smaller_error(self):
        program = pathlib.Path(FURROW).parents[1] / "bench" / "bench_picture_error"
        if not program.exists():
            self.skipTest(f"no {program}: this build has no benches")
        done = subprocess.run([program, "--quick"], capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        by_radii, by_error, one, four = map(json.loads, done.stdout.splitlines())
        self.assertEqual((by_radii["knobs"], by_error["knobs"]), ({"pixel_error": None}, {"pixel_error": 4}))
        self.assertEqual((one["knobs"], four["knobs"]), ({"samples": 1}, {"samples": 4}))
        self.assertLess(one["picture"]["psnr"], four["picture"]["psnr"])
        self.assertLess(by_radii["picture"]["psnr"], by_error["picture"]["psnr"])
        self.assertLess(by_error["picture"]["psnr"], 60)

    def test_a_program_that_fails_fails_it(self):
        self.programs(f"head -2 {self.folder / 'lines'}; exit 3\n", "true\n")
        done = self.accuracy("--build", self.folder)
        self.assertEqual(done.returncode, 1)
        self.assertIn("ended with 3", done.stderr)
        self.assertEqual(self.written(), {"accuracy.jsonl.part"})

    def test_an_interrupt_ends_it_and_what_it_started(self):
        self.programs(f"head -2 {self.folder / 'lines'}; echo $$ > {self.folder / 'pid.part'}; mv {self.folder / 'pid.part'} {self.folder / 'pid'}; exec sleep 100\n", "true\n")
        process = subprocess.Popen([sys.executable, str(BENCH / "accuracy.py"), "--build", str(self.folder), "-o", str(self.out)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        part = self.out / "accuracy.jsonl.part"
        self.addCleanup(process.kill)
        while process.poll() is None and not (part.exists() and part.read_text().count("\n") == 2 and (self.folder / "pid").exists()):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("accuracy.jsonl.part: the 2 lines", said)
        self.assertNotIn("Traceback", errors)
        with self.assertRaises(ProcessLookupError):
            os.kill(int((self.folder / "pid").read_text()), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
