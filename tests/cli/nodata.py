"""Holes: a sentinel is nodata at every level and under every kernel, and never a height."""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import SHARED, long, main
from raster_test import RasterTest
import rasters

LOWEST_FLOAT = -3.4028234663852886e38


def holed(x, y):
    """Blocks of holes of several sizes, which the levels meet differently."""
    return (x // 7 + y // 5) % 4 == 0 or (x // 40 + y // 33) % 3 == 1 or x % 16 == 0 and y % 16 == 0


def ground(x, y):
    return 200 + 3 * math.sin(x / 9) * math.cos(y / 7) + 0.25 * ((x * 7 + y * 3) % 11)


class Nodata(RasterTest):
    def check_levels(self, sentinel, tag, *options):
        width, height = 150, 117
        self.make("in.tif", width, height, lambda x, y: sentinel if holed(x, y) else ground(x, y), nodata=tag)
        self.ok("import", "in.tif", "-o", "s.furrow", "--tile", "8", "--overwrite", *options)
        levels = self.json("info", "s.furrow")["levels"]
        self.assertEqual(levels, [0, 5])
        for level in (0, 1, 3, 5):
            w, h, cells = self.exported("s.furrow", "--level", level)
            self.assertEqual((w, h), ((width - 1 >> level) + 1, (height - 1 >> level) + 1))
            for row in range(h):
                for column in range(w):
                    # Rows are decimated from the south.
                    x, y = column << level, height - 1 - (h - 1 - row << level)
                    value = cells[row * w + column]
                    if holed(x, y):
                        self.assertIsNone(value, (level, x, y))
                    else:
                        self.assertLessEqual(abs(value - ground(x, y)), 0.0011, (level, x, y))
        self.assertTrue(self.json("verify", "s.furrow")["ok"])

    @long
    def test_a_sentinel_does_not_drift_in_coarser_levels(self):
        for sentinel, tag, options in ((-32767, -32767, []), (-9999, None, ["--nodata", "-9999"]),
                                       (math.nan, None, []), (LOWEST_FLOAT, "-3.40282e+38", []),
                                       (3.4028234663852886e38, None, ["--nodata", "3.4e38"])):
            with self.subTest(sentinel=sentinel, tag=tag):
                self.check_levels(sentinel, tag, *options)

    def test_a_vehicle_that_starts_over_a_hole_is_told(self):
        self.make("in.tif", 60, 60, lambda x, y: -9999 if x < 9 else 100, nodata=-9999)
        self.ok("import", "in.tif", "-o", "s.furrow", "--nodata", "-9999")
        post = self.json("info", "s.furrow")["spacing"]
        car = pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml"
        for x, told in ((5, "in a hole of the terrain"), (-1, "off the terrain"), (30, None)):
            path = self.scene("scene: 1\ntime_step: 0.01\nend_time: 1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                              f"vehicles: [{{name: car, model: {car}, start: {{at: [{x * post}, {30 * post}]}}}}]\n")
            result = self.furrow("explain", path, "--store", "s.furrow", "--json")
            if "this build has no MuJoCo" in result.stderr:
                self.skipTest(result.stderr.strip())
            self.assertEqual(result.returncode, 0, result.stderr)
            notes = [note for note in json.loads(result.stdout)["notes"] if "start" in note]
            self.assertEqual(notes, told and [f"vehicles.car.start: there is no ground at {x * post:.3f}, {30 * post:.3f} m, {told}, and a drive refuses a "
                                              "vehicle with none below a soil geom; start elsewhere"] or [])
        for at, hint in (("[15.1, -4.7]", True), ("[-5000, 20]", False)):
            path.write_text(path.read_text().replace(path.read_text().split("start: {at: ")[1].split("}")[0], at))
            error = self.refused(3, "drive", path, "--store", "s.furrow", "--overlay", "a.furrow", "-o", "d")
            self.assertEqual("if these are longitude and latitude, give coordinates: degrees" in error, hint, error)
            self.assertIn(f"{path}:7: vehicles.car.start: no ground under car.wheel at ", error)

    def test_a_driver_s_path_over_a_hole_is_told(self):
        self.make("in.tif", 60, 60, lambda x, y: -9999 if 20 <= x < 30 else 100, nodata=-9999)
        self.ok("import", "in.tif", "-o", "s.furrow", "--nodata", "-9999")
        post = self.json("info", "s.furrow")["spacing"]
        car = pathlib.Path(__file__).parents[2] / "tools/scenes/vehicles/offroad.xml"
        for row, outside, told in ((30, "stop", "the drive will stop there"), (30, "skip", "nothing carries the vehicle there"), (None, "stop", None)):
            way = [[10 * post, 30 * post], [50 * post, 30 * post] if row else [12 * post, 50 * post]]
            path = self.scene(f"scene: 1\ntime_step: 0.002\nend_time: 100\noutside: {outside}\nsoil: {{name: dry_sand}}\nredistribute: {{model: scm}}\nvehicles:\n  - "
                              f"{{name: car, model: {car}, start: {{at: {way[0]}}}, soil: [wheel_*], driver: {{path: {{points: {way}, speed: {post}}}, "
                              "steer: [steer_*], drive: [drive_*]}}\n")
            result = self.furrow("explain", path, "--store", "s.furrow", "--json")
            if "this build has no MuJoCo" in result.stderr:
                self.skipTest(result.stderr.strip())
            self.assertEqual(result.returncode, 0, result.stderr)
            notes = [note for note in json.loads(result.stdout)["notes"] if "hole" in note]
            self.assertEqual(len(notes), told is not None, notes)
            if told is not None:
                self.assertRegex(notes[0], r"^vehicles.car.driver.path: is over a hole of the terrain after (9|1\d)\S* s at its speed, at .* m, and for about 2\d % of its "
                                           "path samples: " + told)

    def test_a_path_over_a_hole_is_told(self):
        self.make("in.tif", 60, 60, lambda x, y: -9999 if 20 <= x < 30 else 100, nodata=-9999)
        self.ok("import", "in.tif", "-o", "s.furrow", "--nodata", "-9999")
        info = self.json("info", "s.furrow")
        post, origin = info["spacing"], info["origin"]
        car = ("scene: 1\ntime_step: 0.5\nend_time: 100\noutside: %s\ncoordinates: %s\nredistribute: {model: box}\nobjects: [{name: car, shape: {sphere: "
               f"{{radius: {3 * post}}}}}, sink: 0.1, path: {{points: [[%.9g, %.9g], [%.9g, %.9g]], speed: {post}}}}}]\n")

        def notes(command, *given):
            result = self.furrow(command, self.scene(car % given), "--store", "s.furrow", *(("--json",) if command == "explain" else ("-o", "out", "--overlay", "o.furrow")))
            kept = [note for note in (result.stderr.split("furrow: ") if command == "drive" else json.loads(result.stdout)["notes"]) if "furrow import --fill" in note]
            return result, kept

        way = [x * post for x in (10, 30, 50, 30)]
        _, told = notes("explain", "stop", "local", *way)
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], r"^objects.car.path: is over a hole of the terrain after (9|1\d)\S* s, at .* m, and for about 2\d % of its path samples: the drive will stop there")
        self.assertEqual(notes("explain", "stop", "local", *[x * post for x in (2, 2, 12, 12)])[1], [])
        place = [value + origin[i % 2] for i, value in enumerate(way)]
        result, _ = notes("drive", "stop", "store", *place)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"car: no ground under it at \S+, \S+ m, which is \S+, \S+ in the store's system, after \S+ s: it is over a hole of the terrain; "
                         r"move its path, import with holes filled \(furrow import --fill\), or set outside: skip")
        east = float(result.stderr.split("which is ")[1].split(",")[0])
        self.assertAlmostEqual(east, origin[0] + float(result.stderr.split("under it at ")[1].split(",")[0]), delta=post / 100)
        result, told = notes("drive", "skip", "store", *place)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(told[0], r"^note: objects.car.path: \d+ of \d+ path samples had no ground, so the object pressed nothing there; ")

    def test_nodata_no_tag_declares_is_told_and_can_be_named(self):
        for sentinel in (-32767, -32768, -9999, 32767):
            with self.subTest(sentinel=sentinel):
                self.make("in.tif", 40, 30, lambda x, y: sentinel if x < 9 else 100 + x, "h")
                note = self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite").stderr
                self.assertIn(f"--nodata {sentinel}", note)
                note = self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite", "--nodata", sentinel).stderr
                self.assertEqual(note, "")
                self.assertEqual(self.json("info", "s.furrow")["height"], [109, 139])

    def test_an_undeclared_sentinel_that_resampling_mixed_is_not_named_wrong(self):
        self.make("in.tif", 60, 60, lambda x, y: -32767 if holed(x, y) else 300, "h", west=15, north=46, step=0.001,
                  srs="EPSG:4326")
        note = self.furrow("import", "in.tif", "-o", "s.furrow", "-r", "cubic").stderr
        self.assertLess(self.json("info", "s.furrow")["height"][0], -32767)
        self.assertIn("means nodata", note)
        self.assertNotIn("--nodata -3", note)

    @unittest.skipUnless((SHARED / "dem").is_dir(), "not on this machine: no shared elevation data")
    def test_crater_lake_declares_nothing_and_is_a_third_holes(self):
        crater = SHARED / "dem/craterlake.tif"
        self.assertIn("--nodata -32767", self.furrow("import", crater, "-o", "mixed.furrow").stderr)
        self.ok("import", crater, "-o", "s.furrow", "--nodata", "-32767")
        low, high = self.json("info", "s.furrow")["height"]
        self.assertGreaterEqual(low, 1289)
        self.assertLessEqual(high, 1880)
        _, _, cells = self.exported("s.furrow")
        self.assertAlmostEqual(cells.count(None) / len(cells), 0.34, delta=0.02)

    def test_no_kernel_reaches_over_a_holes_edge(self):
        """Ground is 100 .. 101 m: whatever mixed with the sentinel lies far outside."""
        def value(x, y, sentinel):
            return sentinel if holed(x, y) else 100 + (x + y) % 2

        degrees = {"west": 15, "north": 46, "step": 0.001, "srs": "EPSG:4326"}
        for sentinel, place, spacings in ((LOWEST_FLOAT, degrees, (41, 560)), (3e38, {}, (7.7, 190))):
            self.make("in.tif", 90, 80, lambda x, y: value(x, y, sentinel), nodata=repr(sentinel), **place)
            for method in ("bilinear", "cubic", "near"):
                for spacing in spacings:  # finer, and by a widened kernel
                    with self.subTest(method=method, spacing=spacing):
                        self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "-r", method, "--spacing", spacing)
                        low, high = self.json("info", "s.furrow")["height"]
                        overshoot = 0.6 if method == "cubic" else 0.002
                        self.assertGreaterEqual(low, 100 - overshoot)
                        self.assertLessEqual(high, 101 + overshoot)

    def test_a_hole_stays_a_hole_when_it_is_resampled(self):
        self.make("in.tif", 90, 80, lambda x, y: -9999 if 30 <= x < 60 and 20 <= y < 50 else 50, nodata=-9999)
        self.assertIn("no data: 12.5 % of the posts", self.ok("import", "in.tif", "-o", "own.furrow", "--tile", 8))
        self.assertIn("no data    12.5 % of the posts", self.ok("info", "own.furrow"))
        self.assertEqual(self.json("info", "own.furrow")["holes"], 0.125)
        self.assertNotIn("no data", self.ok("import", "in.tif", "-o", "own.furrow", "--overwrite", "--fill"))
        self.assertEqual(self.json("info", "own.furrow")["holes"], 0)
        for method in ("bilinear", "cubic", "near"):
            self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "-r", method, "--spacing", "4")
            for x, y, nodata in ((450, 440, True), (302 + 16, 440, True), (270, 440, False), (450, 260, False)):
                self.assertEqual(self.json("query", "s.furrow", x, y)["nodata"], nodata, (method, x, y))

    def test_a_real_height_of_minus_32767_is_no_nodata_in_an_export(self):
        self.make("in.tif", 20, 20, lambda x, y: -32767 if x == 3 else -9999 if x == 5 else 7, "h", nodata=-9999)
        self.ok("import", "in.tif", "-o", "s.furrow")
        _, _, cells = self.exported("s.furrow")
        self.assertEqual(cells[:7], [7, 7, 7, -32767, 7, None, 7])


if __name__ == "__main__":
    main()
