"""furrow.fit: exact data, data with known noise, closed forms, and files that are none."""
import importlib
import math
import os
import pathlib
import random
import sys
import unittest

import numpy as np

from furrow_test import FURROW, FurrowTest, main

BUILD = pathlib.Path(FURROW).resolve().parents[1]
sys.path.insert(0, str(BUILD / "python"))
os.environ.setdefault("FURROW_LIBRARY", str(BUILD / "src/libfurrow.so.0"))
try:
    importlib.import_module("scipy.optimize")
except ImportError:
    raise unittest.SkipTest("not on this machine: the Python package scipy") from None
models, tables, squares = (importlib.import_module(f"furrow._fit_{name}") for name in ("models", "table", "squares"))
ResultsError = importlib.import_module("furrow.results").ResultsError

# kc, kphi, n, c, tan phi, K
SOILS = [(990, 1528430, 1.1, 1040, 0.53, 0.01), (16540, 811000, 0.55, 10140, 0.5, 0.025), (102000, 5301000, 0.79, 1300, 0.6, 0.012),
         (12700, 1555950, 0.13, 68950, 0.67, 0.006), (-8000, 900000, 1.6, 0, 0.35, 0.03), (1400, 820000, 1, 170, 0.7, 0.018)]
WIDTHS, STRESSES = [0.03, 0.05, 0.1, 0.3], [0, 5e3, 2e4, 1e5]
NOISY = random.Random(46)


def pressure(soil, b, z):
    return (soil[0] / b + soil[1]) * z ** soil[2]


def stress(soil, sigma, j):
    return (soil[3] + sigma * soil[4]) * -math.expm1(-j / soil[5])


def proportional(soil, _, z):
    return 0.87574 * soil[1] * z + soil[3]


def made(test, groups, count, most, soil, of, noise=0.0):
    """A table without a file: `count` rows of each group."""
    rows = []
    for group in groups:
        for i in range(count):
            x = most * (i + 1) / count
            rows.append((group, x, max(of(soil, group, x) + noise * NOISY.gauss(0, 1), 0) if noise else of(soil, group, x), len(rows) + 2))
    return tables.Table("a.csv", test, rows, list(groups))


class FitNumbers(FurrowTest):
    def setUp(self):
        super().setUp()
        NOISY.seed(46)

    def close(self, a, b, share, why=None):
        self.assertLessEqual(abs(a - b), share * max(abs(a), abs(b)), why)

    def test_exact_data_gives_back_the_exact_numbers(self):
        for soil in SOILS:
            kc, kphi, n, c, tan_phi, k = soil
            for groups in (2, 3, 4):
                for far, most in enumerate((0.01, 0.08, 0.5)):
                    plates = models.fit_plates(made("plate", WIDTHS[:groups], 9, most, soil, pressure))
                    self.assertFalse(plates.one_width or plates.no_kphi)
                    for method in ("plain", "wong"):
                        self.close(plates.n[method].value, n, 1e-9)
                        self.close(plates.kphi[method].value, kphi, 1e-8)
                        self.close(plates.kc[method].value, kc, 1e-7)
                        self.assertLess(plates.n[method].error, 1e-8)
                        self.assertGreater(plates.quality[method].goodness, 1 - 1e-8)
                    for width, curve in zip(WIDTHS, plates.curves):
                        self.close(curve.n, n, 1e-9)
                        self.close(curve.k, kc / width + kphi, 1e-8)
                    shear = models.fit_shear(made("shear", STRESSES[:groups], 11, 5 * k * (far + 1), soil, stress))
                    self.close(shear.shear.value, k, 1e-8)
                    self.close(math.tan(shear.friction.value), tan_phi, 1e-7)
                    self.assertLess(abs(shear.cohesion.value - c), 1e-5 * (c + 1))
                    self.close(shear.stress(3e4, 0.01), stress(soil, 3e4, 0.01), 1e-7)

    def test_two_plates_are_as_by_the_closed_form(self):
        """For two plates the weighted fit has a closed form: n of both together, ln k of each. Each alone is by Wong's own formulas."""
        for turn in range(20):
            soil = SOILS[turn % 3]
            table = made("plate", WIDTHS[1:3], 12, 0.06, soil, pressure, 0.02 * pressure(soil, 0.05, 0.06))
            plates = models.fit_plates(table)
            sums = []
            for g in range(2):
                p, x = table.y[table.of(g)], np.log(table.x[table.of(g)])
                w, y = p ** 2, np.log(np.where(p > 0, p, 1))
                sums.append([float(np.sum(each)) for each in (w, w * x, w * y, w * x * x, w * x * y)])
            n = sum(xy - x * y / w for w, x, y, xx, xy in sums) / sum(xx - x * x / w for w, x, y, xx, xy in sums)
            k0, k1 = (math.exp((y - n * x) / w) for w, x, y, xx, xy in sums)
            kc = (k0 - k1) / (1 / 0.05 - 1 / 0.1)
            self.close(plates.n["wong"].value, n, 1e-9)
            self.close(plates.kphi["wong"].value, k0 - kc / 0.05, 1e-6)
            self.close(plates.kc["wong"].value, kc, 1e-6)
            for (w, x, y, xx, xy), curve in zip(sums, plates.curves):
                alone = (w * xy - x * y) / (w * xx - x * x)
                self.close(curve.n, alone, 1e-9)
                self.close(curve.k, math.exp((y - alone * x) / w), 1e-9)

    def test_a_straight_line_has_the_numbers_and_errors_of_the_textbook(self):
        x = 1e4 + np.arange(30.0) ** 2
        y = 3 + 0.02 * x + np.array([NOISY.gauss(0, 1) for _ in x])
        slope = np.sum((x - x.mean()) * (y - y.mean())) / np.sum((x - x.mean()) ** 2)
        at0, sxx = y.mean() - slope * x.mean(), np.sum((x - x.mean()) ** 2)
        rest = np.sum((y - at0 - slope * x) ** 2)
        found = squares.least_squares(lambda p: (p[0] + p[1] * x - y, np.stack([np.ones(30), x, 0 * x], axis=1)), np.array([0.0, 0, 7]), (False, False, True))
        self.close(found.x[1], slope, 1e-9)
        self.close(found.x[0], at0, 1e-7)
        self.assertEqual(found.x[2], 7)
        self.close(found.sum, rest, 1e-9)
        for got, want in ((found.covariance[1, 1], rest / 28 / sxx), (found.covariance[0, 0], rest / 28 * (1 / 30 + x.mean() ** 2 / sxx)), (found.covariance[0, 1], -rest / 28 * x.mean() / sxx)):
            self.close(got, want, 1e-7)
        at_one_place = np.full(30, 5.0)  # the numbers are not told apart
        self.assertIsNone(squares.least_squares(lambda p: (p[0] + p[1] * at_one_place - y, np.stack([np.ones(30), at_one_place], axis=1)), np.array([0.0, 0]), (False, False)))

    def rates(self, truths, trial):
        """Of Student's distribution 67.7 % are within one standard error and 94.8 % within two, with 42 rows more than numbers. The rates of 1000 trials
        are off that by 1.5 % and 0.7 % (one sigma). Logarithms of noise have a mean, so that the numbers by Wong have one, too."""
        off = {name: [] for name in truths}
        for _ in range(1000):
            for name, number in trial().items():
                off[name].append((number.value - truths[name]) / number.error)
        for name, values in off.items():
            one, two, bias = np.mean(np.abs(values) <= 1), np.mean(np.abs(values) <= 2), np.mean(values)
            self.assertTrue(0.63 <= one <= 0.73 and 0.925 <= two <= 0.97 and abs(bias) <= 0.2, (name, one, two, bias))

    def test_noise_gives_numbers_within_their_standard_errors_at_the_expected_rate(self):
        soil = (40e3, 2e6, 0.9, 4000, 0.6, 0.015)

        def trial():
            plates = models.fit_plates(made("plate", WIDTHS[1:], 15, 0.08, soil, pressure, 1200))
            shear = models.fit_shear(made("shear", STRESSES[1:], 20, 0.08, soil, stress, 600))
            found = {f"{name} {method}": getattr(plates, name)[method] for name in ("kc", "kphi", "n") for method in ("plain", "wong")}
            return {**found, "c": shear.cohesion, "phi": shear.friction, "K": shear.shear}

        truths = {f"{name} {method}": value for name, value in zip(("kc", "kphi", "n"), soil) for method in ("plain", "wong")}
        self.rates({**truths, "c": 4000, "phi": math.atan(0.6), "K": 0.015}, trial)

    def test_a_penetration_gives_back_its_number(self):
        for s, (_, kphi, *_rest) in enumerate(SOILS):
            soil = (0, kphi, 0, 0, 0, 0)
            for areas in ([0], [0.0004, 0.0025], [0.0004, 0.0025, 0.04]):
                table = made("penetration", areas, 8, 0.01 * (s + 1), soil, proportional)
                table.is_force = len(areas) < 3
                table.y = table.y * np.where(table.group > 0, table.group, 0.003) if table.is_force else table.y
                tables.take_pressures(table, 0.003 if areas == [0] else None)
                faces = models.fit_penetration(table)
                self.close(faces.strength.value, kphi, 1e-12)
                self.close(faces.slope.value, kphi, 1e-9)
                self.assertTrue(faces.strength.error < 1e-6 * kphi and abs(faces.offset.value) < 1e-9 * kphi)
                for alone in faces.alone:
                    self.close(alone.value, kphi, 1e-12)
        table = made("penetration", [0], 20, 0.1, (0, 1e6, 0, 800, 0, 0), proportional)  # an offset has no say in the strength
        faces = models.fit_penetration(table)
        self.close(faces.slope.value, 1e6, 1e-9)
        self.close(faces.offset.value, 800, 1e-8)
        self.close(faces.strength.value, float(np.sum(table.x * table.y) / np.sum(table.x ** 2)) / 0.87574, 1e-12)

    def test_noise_of_a_penetration_gives_its_standard_errors(self):
        def trial():
            table = made("penetration", [0.002], 43, 0.1, (0, 1.1e6, 0, 5000, 0, 0), proportional, 900)
            faces = models.fit_penetration(table)
            table.y = table.y - 5000
            return {"slope": faces.slope, "offset": faces.offset, "strength": models.fit_penetration(table).strength}

        self.rates({"slope": 1.1e6, "offset": 5000, "strength": 1.1e6}, trial)

    def test_one_width_and_one_stress_give_sums(self):
        soil = SOILS[1]
        plates = models.fit_plates(made("plate", [0.1], 10, 0.08, soil, pressure))
        self.assertTrue(plates.one_width and plates.kc["plain"].value == 0 and math.isnan(plates.kc["plain"].error) and math.isfinite(plates.kphi["plain"].error))
        for method in ("plain", "wong"):
            self.close(plates.kphi[method].value, soil[0] / 0.1 + soil[1], 1e-8)
        shear = models.fit_shear(made("shear", [2e4], 12, 0.08, soil, stress))
        self.assertTrue(shear.one_stress and shear.cohesion.value == 0 and math.isnan(shear.cohesion.error) and math.isfinite(shear.friction.error))
        self.close(math.tan(shear.friction.value), (soil[3] + 2e4 * soil[4]) / 2e4, 1e-8)
        shear = models.fit_shear(made("shear", [0], 12, 0.08, soil, stress))
        self.assertTrue(shear.one_stress and shear.friction.value == 0 and math.isnan(shear.friction.error))
        self.close(shear.cohesion.value, soil[3], 1e-8)

    def test_what_no_scene_takes_is_0_and_said(self):
        plates = models.fit_plates(made("plate", WIDTHS[1:3], 10, 0.08, (90e3, -2e5, 0.8), pressure))
        self.assertTrue(plates.no_kphi and plates.kphi["plain"].value == 0 and math.isnan(plates.kphi["plain"].error) and plates.kc["plain"].value > 0)
        shear = models.fit_shear(made("shear", STRESSES[1:], 20, 0.08, (0, 0, 0, -900, 0.6, 0.01), stress))
        self.assertTrue(shear.no_cohesion and shear.cohesion.value == 0 and math.isnan(shear.cohesion.error) and shear.friction.value > 0.4)
        shear = models.fit_shear(made("shear", STRESSES[1:], 20, 0.08, (0, 0, 0, 90e3, -0.1, 0.01), stress))
        self.assertTrue(shear.no_friction and shear.friction.value == 0 and shear.cohesion.value > 1000)

    def says(self, why, fit, *arguments):
        with self.assertRaises(ResultsError) as raised:
            fit(*arguments)
        self.assertIn(why, str(raised.exception))
        self.assertIn("; ", str(raised.exception))

    def test_rows_that_determine_nothing_are_refused(self):
        cut = made("plate", WIDTHS[:2], 10, 0.08, SOILS[0], pressure)
        few = tables.Table("a.csv", "plate", [*zip(cut.group[:3], cut.x, cut.y, cut.line)], WIDTHS[:2])
        self.says("has 3 rows with a sinkage above 0, and 4 are needed", models.fit_plates, few)
        cut.x[10:] = 0.04
        self.says("plate of 0.05 m has rows of one sinkage only", models.fit_plates, cut)
        self.says("no pressure above 0", models.fit_plates, made("plate", WIDTHS[:2], 10, 0.08, (0, 0, 1), pressure))
        self.says("no pressure above 0", models.fit_penetration, made("penetration", [0.01], 5, 0.08, (0, 0, 0, 0), proportional))
        deep = made("penetration", [0.01], 5, 0.08, (0, 1e6, 0, 0), proportional)
        self.says("--area is for forces", tables.take_pressures, deep, 2)
        deep.is_force = True
        self.says("--area is given too", tables.take_pressures, deep, 2)
        deep.groups[0] = deep.group[3] = 0
        self.says("no area; give the plate's area in m2", tables.take_pressures, deep, None)
        self.says("has 2 rows with a depth above 0, and 3 are needed", models.fit_penetration, made("penetration", [0.01], 2, 0.08, (0, 1e6, 0, 0), proportional))
        deep.x[:] = 0.02
        self.says("all rows have one depth", models.fit_penetration, deep)
        for n in (3.5, -0.5):
            self.says(f"n would be {n}", models.fit_plates, made("plate", WIDTHS[:2], 10, 0.08, (1e3, 1e6, n), pressure))
        self.says("has to level off", models.fit_shear, made("shear", STRESSES[1:], 12, 0.08, (0, 0, 0, 1e6, 1e3, 1e6), stress))  # K may be anything
        self.says("has 3 rows", models.fit_shear, made("shear", STRESSES[1:], 1, 0.08, SOILS[0], stress))
        one = made("shear", STRESSES[1:], 4, 0.08, SOILS[0], stress)
        one.x[:] = 0.04
        self.says("one displacement", models.fit_shear, one)

    # --- files ---

    def read(self, content, test):
        path = self.folder / "test.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return tables.read(path, test)

    def test_columns_are_known_by_a_word_and_a_unit(self):
        plate, shear = (0.1, 0.02, 5e4), (2e4, 0.015, 8500)
        for test, text, want in (("plate", "b m,z m,p Pa\n0.1,0.02,5e4\n", plate), ("plate", "plate width b mm,sinkage z mm,pressure p kPa\n100,20,50\n", plate),
                                 ("plate", "# a comment\n\ntrial,Pressure [kPa],Sinkage (cm),Radius_mm\r\nA 1, 50 , +2.0 ,1e2\r\n", plate),
                                 ("plate", '\ufeff"p/MPa","z/mm","b/cm"\n"0.05","20","10"', plate),
                                 ("shear", "normal stress sigma kPa,shear displacement j mm,shear stress tau kPa\n20,15,8.5\n", shear), ("shear", "tau_Pa,j_m,sigma_MPa\n8500,0.015,0.02\n", shear),
                                 ("shear", "displacement mm,shear stress Pa,normal Pa\n15,8500,0\n", (0, *shear[1:]))):
            table = self.read(text, test)
            self.assertEqual((len(table), len(table.groups)), (1, 1))
            for got, value in zip((table.group[0], table.x[0], table.y[0]), want):
                self.close(got, value, 1e-12)
        table = self.read("b mm,z mm,p kPa\n300,0,0\n100,1,3\n50.0,1,4\n300,1,2\n50,2,5\n", "plate")
        self.assertEqual((table.skipped, len(table.groups), list(table.at), table.line[3]), (1, 3, [1, 0, 2, 0], 6))
        self.assertEqual(table.groups, sorted(table.groups))

    def test_bad_files_are_told_with_their_line(self):
        head = "b m,z m,p Pa\n"
        for test, text, why in (
                ("plate", "", "is empty"), ("plate", "\n# nothing\n\n", "is empty"), ("plate", "b m,z m\n1,2\n", ":1: has no column pressure p"),
                ("plate", "1,2,3\n4,5,6\n", ":1: has no column plate width b"), ("plate", "sigma kPa,j mm,tau kPa\n1,2,3\n", ":1: has no column plate width b"),
                ("shear", head + "1,2,3\n", ":1: has no column normal stress sigma"),
                ("plate", "b m,z m,p\n1,2,3\n", ":1: column 3, pressure p, does not end with its unit; write pressure p Pa, kPa or MPa"),
                ("plate", "b m,z kPa,p kPa\n1,2,3\n", ":1: column 2, sinkage z, does not end with its unit; write sinkage z m, cm or mm"),
                ("plate", "b m,width m,z m,p Pa\n", ":1: columns 1 and 2 are both plate width b"), ("plate", head + "1,2,3\n1,2\n", ":3: has no column 3, pressure p"),
                ("plate", head + "1,2,3\n\n# x\n1,2,x\n", ':5: column 3, pressure p: "x" is no number'), ("plate", head + "1,nan,3\n", ':2: column 2, sinkage z: "nan" is no number'),
                ("plate", head + "1,2,inf\n", '"inf" is no number'), ("plate", head + "1,2,1e999\n", '"1e999" is no number'), ("plate", head + "1,2,0x10\n", '"0x10" is no number'),
                ("plate", head + "1,2,1_0\n", '"1_0" is no number'), ("plate", head + "1,2,\n", '"" is no number'), ("plate", head + "1,2 mm,3\n", '"2 mm" is no number'),
                ("plate", head + "1;2;3\n", '"1;2;3" is no number'), ("plate", head + "1,-2,3\n", ":2: column 2, sinkage z: -2 is below 0"),
                ("plate", head + "1,2,-3\n", ":2: column 3, pressure p: -3 is below 0"), ("plate", head + "1,2,1e13\n", "is too large"),
                ("plate", head + "0,2,3\n", ":2: the plate's width is 0"), ("plate", head.encode() + b"1,2,3\n1,\0,3\n", ":3: the line is longer"), ("plate", "1" * 600000, ":1: the line is longer"),
                ("plate", head + "".join(f"{i + 1},1,1\n" for i in range(70)), ":66: has more than 64 plate widths"), ("plate", "".join(f"c{i}," for i in range(70)), ":1: has more than 64 columns")):
            self.says(why, self.read, text, test)
        self.says("No such file", tables.read, "/nonexistent/x.csv", "plate")
        self.says("Is a directory", tables.read, "/", "plate")

    def test_a_damaged_file_is_read_or_refused(self):
        """Bytes of a good file are changed, removed and put twice: it is read or refused, and what was read is fitted or refused."""
        good = {"plate": b"b mm,z mm,p kPa\n50,4,10.5\n50,8,21\n50,20,44\n100,4,8\n100,8,16\n100,20,37.25\n",
                "shear": b"sigma kPa,j mm,tau kPa\n10,2,2\n10,8,4.5\n10,40,7\n50,2,6\n50,8,17\n50,40,31\n"}
        signs, refused, fitted = b'0123456789.,-+eE\n\r"#kPamz \xff\x01\0', 0, 0
        for turn in range(1200):
            test = ("plate", "shear")[turn % 2]
            data = bytearray(good[test])
            for _ in range(NOISY.randint(1, 4)):
                at = NOISY.randrange(len(data))
                length, kind = NOISY.randrange(max((len(data) - at) // 4, 1)), NOISY.random()
                if kind < 0.6:
                    data[at] = signs[NOISY.randrange(len(signs))]
                elif kind < 0.8:
                    del data[at:at + length]
                else:
                    data[at:at] = data[at:at + length]
            try:
                table = self.read(bytes(data), test)
                found = models.fit_plates(table) if test == "plate" else models.fit_shear(table)
            except ResultsError:
                refused += 1
                continue
            fitted += 1
            if test == "plate":
                for method in ("plain", "wong"):
                    self.assertTrue(math.isfinite(found.kc[method].value) and found.kphi[method].value >= 0 and found.n[method].value > 0)
            else:
                self.assertTrue(found.cohesion.value >= 0 and 0 <= found.friction.value < math.pi / 2 and found.shear.value > 0)
        self.assertTrue(refused > 100 and fitted > 100, (refused, fitted))


if __name__ == "__main__":
    main()
