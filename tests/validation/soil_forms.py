"""The closed forms that bench/converge.py holds the command to, and its own tools: what it measures with must be right itself."""
import os
import pathlib
import random
import struct
import sys
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(os.environ["SOURCES"]).parent / "bench"))
import converge_tables
import lanes
import soil_forms
from soil_forms import Law, Wheel, by_angle, by_posts, by_way, named, under_load


class ClosedForms(unittest.TestCase):
    def test_both_quadratures_agree(self):
        """By the angle and by the way, over random wheels, soils, slips and laws."""
        chance = random.Random(16)
        for _ in range(60):
            soil = named(chance.choice(list(soil_forms.NAMED)))
            wheel = Wheel(chance.uniform(0.05, 1), chance.uniform(0.05, 0.6), chance.choice((None, None, 12, 25)), chance.choice((None, None, 0, 900)))
            law = Law(chance.choice(("surface", "ground")), chance.choice(("rim", "ground")), chance.choice((0.0, 0.0, 0.8)))
            case = soil, wheel, wheel.radius * chance.uniform(0.002, 0.5), chance.choice((-0.5, -0.2, 0.0, 0.2, 0.6, 0.9)), law
            one, two = by_angle(*case), by_way(*case)
            # Slip digs a wheel that is hardly sunk almost free, so that its force alone is no measure.
            most = max(one.fz, 0.01 * soil.yields(case[2], wheel.width) * wheel.width * wheel.radius)
            for a, b in ((one.fz, two.fz), (one.fx, two.fx), (one.my, two.my)):
                self.assertLess(abs(a - b) / most, 1e-6, case)

    def test_a_row_of_posts_agrees(self):
        """Through time, with what a post remembers: digging, reversal of shear, rebound. Its error halves with the distance of posts."""
        for name, load, slip, kappa in (("dry_sand", 1000, 0.2, 1.35), ("lete_sand", 1000, 0.2, 1.35), ("snow_us", 1000, -0.2, 1.35), ("dry_sand", 1000, -0.5, 1.1)):
            soil, wheel, law = named(name), Wheel(0.32, 0.24), Law(kappa=kappa)
            form = under_load(soil, wheel, load, slip, law)
            coarse, fine = (by_posts(soil, wheel, form.sinkage, slip, law, posts).apart(form) for posts in (1000, 8000))
            self.assertLess(fine, 5e-4, name)
            self.assertLess(fine, coarse / 3, name)

    def test_the_numbers_of_the_issue(self):
        """Sinkage in mm, drawbar in N, torque in N m: a wheel of 0.32 m by 0.24 m, 1 kN, slip 0.2, dry_sand."""
        for law, wanted in ((Law(), (33.40, 233.5, 119.5)), (Law("ground"), (34.32, 296.5, 138.0))):
            got = under_load(named("dry_sand"), Wheel(0.32, 0.24), 1000, 0.2, law)
            for value, number in zip((got.sinkage * 1e3, got.fx, got.my), wanted, strict=True):
                self.assertAlmostEqual(value, number, delta=0.06, msg=law)

    def test_a_smooth_rim_pulls_less(self):
        """tests/validation/rolling.c has the same numbers from the reference in C."""
        for soil, rim, wanted in (("dry_sand", (None, None), (33.40, 233.5)), ("dry_sand", (15, None), (33.81, 63.7)),
                                  ("dry_sand", (None, 0), (33.47, 209.8)), ("lete_sand", (20, 300), (3.91, 159.6)),
                                  ("sandy_loam_15", (10, 6000), (8.76, 73.0)), ("dry_sand", (40, 1e5), (33.40, 233.5))):
            got = under_load(named(soil), Wheel(0.32, 0.24, *rim), 1000, 0.2)
            self.assertAlmostEqual(got.sinkage * 1e3, wanted[0], delta=0.006)
            self.assertAlmostEqual(got.fx, wanted[1], delta=0.06)

    def test_chrono_s_soft_soil(self):
        """Both integrals that are known: they differ in j alone."""
        for j, drawbars, torques in (("ground", (-627, 643, 774), (-163, 455, 515)), ("rim", (-659, 624, 767), (-178, 446, 512))):
            for slip, drawbar, torque in zip((0, 0.2, 0.5), drawbars, torques):
                got = by_angle(named("chrono_soft"), Wheel(0.5, 0.4), 0.1, slip, Law("ground", j))
                self.assertAlmostEqual(got.fz, 1350, delta=1)
                self.assertAlmostEqual(got.fx, drawbar, delta=0.6)
                self.assertAlmostEqual(got.my, torque, delta=0.6)

    def test_a_load_that_nothing_bears(self):
        self.assertIsNone(under_load(named("snow_us"), Wheel(0.32, 0.24), 50000, 0.2))


def filtered(rows, kinds):
    """A grey 16-bit PNG of the rows, each with one of the five filters."""
    before, body = bytes(2 * len(rows[0])), b""
    for row, kind in zip(rows, kinds):
        line, out = struct.pack(f">{len(row)}H", *row), bytearray()
        for i, byte in enumerate(line):
            left, up, corner = (line[i - 2] if i > 1 else 0), before[i], (before[i - 2] if i > 1 else 0)
            guess = left + up - corner
            paeth = left if abs(guess - left) <= min(abs(guess - up), abs(guess - corner)) else up if abs(guess - up) <= abs(guess - corner) else corner
            out.append((byte - (0, left, up, (left + up) // 2, paeth)[kind]) & 255)
        body, before = body + bytes([kind]) + bytes(out), line

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 16, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(body)) + chunk(b"IEND", b""))


class Tools(unittest.TestCase):
    def test_pictures_come_back(self):
        chance = random.Random(5)
        rows = [[chance.randrange(65536) for _ in range(7)] for _ in range(10)]
        found = list(lanes.png_rows(filtered(rows, [0, 1, 2, 3, 4, 4, 3, 2, 1, 0])))
        self.assertEqual([list(row) for row in found], rows)

    def test_order(self):
        self.assertAlmostEqual(converge_tables.order({d: 3 * d ** 1.5 for d in (0.08, 0.04, 0.02, 0.01)}), 1.5)

    def test_monotone(self):
        self.assertEqual(converge_tables.monotone([1, 3, 2, 4]), [1, 2.5, 2.5, 4])
        self.assertEqual(converge_tables.monotone([3, 2, 1]), [2, 2, 2])


if __name__ == "__main__":
    unittest.main()
