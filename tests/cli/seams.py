"""Elevation data at the seams of the globe, with units that its metadata say, in PNGs with a place, with holes that nothing declares: each beside GDAL's own
answer, or a formula."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import main
from raster_test import RasterTest
import rasters

DEGREE = 1 / 900
SIDE = 90


class Seams(RasterTest):
    def pair(self, west, east):
        """Two tiles side by side, 90 x 90 pixels each; heights rise to the north by 2 m a pixel and to the east by 0.5 m."""
        for name, x, first in (("west.tif", west, 0), ("east.tif", east, SIDE)):
            self.make(name, SIDE, SIDE, lambda column, row: 100 + 2 * (SIDE - 1 - row) + 0.5 * (first + column), west=x, north=-17.0, step=DEGREE, srs="EPSG:4326")

    def check_pair(self, west, zones, *sources_and_options):
        self.ok("import", *sources_and_options, "-o", "s.furrow", "--overwrite", "--max-error", 0.001)
        info = self.json("info", "s.furrow")
        self.assertLess(max(info["posts"]), 300)
        self.assertTrue(any(zone in info["srs"] for zone in zones), info["srs"][:80])
        places = [(column, row) for column in (5.2, 44.8, 88.9, 89.7, 90.6, 133, 174.4) for row in (6.3, 45.5, 84.1)]
        degrees = [(west + column * DEGREE, -17.0 - row * DEGREE) for column, row in places]
        text = "".join(f"{x!r} {y!r}\n" for x, y in degrees)
        points = self.json("query", "s.furrow", "--srs", "degrees", stdin=text)["points"]
        for (column, row), point in zip(places, points, strict=True):
            self.assertAlmostEqual(point["height"], 100 + 2 * (SIDE - 1 - (row - 0.5)) + 0.5 * (column - 0.5), delta=0.02)
            self.assertFalse(point["nodata"], (column, row))

    def test_tiles_on_both_sides_of_180_degrees_are_neighbours(self):
        self.pair(180 - SIDE * DEGREE, -180.0)
        for order in (("west.tif", "east.tif"), ("east.tif", "west.tif")):
            self.check_pair(180 - SIDE * DEGREE, ("zone 60S", "zone 1S"), *order)
        self.check_pair(180 - SIDE * DEGREE, ("zone 60S",), "west.tif", "east.tif", "--t-srs", "EPSG:32760")

    def test_tiles_on_both_sides_of_the_meridian_of_greenwich_are_neighbours(self):
        """West of it x counts to 360, east of it from 0."""
        self.pair(360 - SIDE * DEGREE, 0.0)
        for order in (("west.tif", "east.tif"), ("east.tif", "west.tif")):
            self.check_pair(-SIDE * DEGREE, ("zone 31S", "zone 30S"), *order)

    def test_a_window_may_count_from_either_side(self):
        self.pair(180 - SIDE * DEGREE, -180.0)
        posts = set()
        for window in ("179.95,-17.08,180.05,-17.02", "-180.05,-17.08,-179.95,-17.02"):
            self.ok("import", "west.tif", "east.tif", "-o", "s.furrow", "--overwrite", "--window", window, "--window-srs", "EPSG:4326")
            posts.add(tuple(self.json("info", "s.furrow")["posts"]))
        self.assertEqual(len(posts), 1)

    def test_a_globe_in_tiles_stays_whole(self):
        """Four tiles around the planet have no gap to begin at."""
        for i in range(4):
            self.make(f"t{i}.tif", 30, 20, lambda column, row: 5.0 * i + column / 10, west=-180.0 + 90 * i, north=30.0, step=3, srs="EPSG:4326")
        self.ok("import", *(f"t{i}.tif" for i in (2, 0, 1, 3)), "-o", "s.furrow", "--t-srs", "EPSG:6933")
        self.assertGreater(self.json("info", "s.furrow")["posts"][0], 100)

    def test_all_longitudes_around_a_pole_leave_no_line_of_holes(self):
        """The posts on the meridian where both ends of the data meet, and the pole itself. Heights fall by 50 m a degree."""
        step, rows = 0.5, 12

        def tile(name, west, pole, columns):
            heights = lambda column, row: 1000 - 50 * step * ((row if pole > 0 else rows - 1 - row) + 0.5)  # noqa: E731
            return self.make(name, columns, rows, heights, west=west, north=90.0 if pole > 0 else -90.0 + rows * step, step=step, srs="EPSG:4326")

        for pole in (1, -1):
            for number, west in enumerate((-180.0, -90.0, 0.0, 90.0)):
                tile(f"quarter{number}.tif", west, pole, 180)
            tile("whole.tif", -180.0, pole, 720)
            tile("whole360.tif", 0.0, pole, 720)
            for sources in (("whole.tif",), ("whole360.tif",), ("quarter2.tif", "quarter0.tif", "quarter3.tif", "quarter1.tif")):
                with self.subTest(pole=pole, sources=sources):
                    self.ok("import", *sources, "-o", "s.furrow", "--overwrite", "--max-error", 0.01)
                    width, height, found = self.exported("s.furrow")
                    self.assertEqual(width % 2 + height % 2, 2)  # a post is on the pole, and a line of posts on the meridian
                    info = self.json("info", "s.furrow")
                    for place, got in enumerate(found):
                        x, y = place % width - width // 2, place // width - height // 2
                        away = math.hypot(x, y) * info["spacing"] / 111600  # degrees, nearly
                        if away < rows * step - 0.2:
                            self.assertIsNotNone(got, (x, y))
                            self.assertAlmostEqual(got, 1000 - 50 * max(away, step / 2), delta=6)

    def test_a_pole_in_the_middle_of_a_grid(self):
        for srs, centre in (("EPSG:3413", 0.0), ("EPSG:3031", 0.0), ("EPSG:5041", 2000000.0)):
            self.make("pole.tif", 60, 60, lambda column, row: 3000 - 20 * math.hypot(column - 29.5, row - 29.5), west=centre - 30000, north=centre + 30000, step=1000, srs=srs)
            result = self.furrow("import", "pole.tif", "-o", "s.furrow", "--overwrite", "--max-error", 0.001)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertNotIn("off those on the ground", result.stderr)
            info = self.json("info", "s.furrow")
            # A kilometre of the grid on the ground, as PROJ's factors tell: 1031, 1028 and 1006 m.
            self.assertAlmostEqual(info["spacing"] / 1000, {"EPSG:3413": 1.031, "EPSG:3031": 1.028, "EPSG:5041": 1.006}[srs], delta=0.006)
            scale = {"EPSG:3413": 1.0311, "EPSG:3031": 1.0279, "EPSG:5041": 1.0060}[srs]
            middle = [info["spacing"] * (count - 1) / 2 for count in info["posts"]]
            for away in (5000.0, 12000.0, 20000.0):
                point, = self.json("query", "s.furrow", repr(middle[0] + away), repr(middle[1]))["points"]
                off = math.hypot(info["origin"][0] + middle[0] + away, info["origin"][1] + middle[1])
                self.assertAlmostEqual(point["height"], 3000 - 20 * off / (1000 * scale), delta=1.0)


class Meanings(RasterTest):
    def test_degrees_without_an_srs(self):
        self.make("d.tif", 50, 40, lambda column, row: 1500 + 30.0 * column, west=-120.0, north=45.0, step=0.1, srs=None)
        self.assertIn("looks like degrees", self.refused(3, "import", "d.tif", "-o", "s.furrow"))
        rasters.gdal("gdal_translate", "-q", "-mo", "lon#units=degrees_east", "-mo", "lat#units=degrees_north", self.folder / "d.tif", self.folder / "u.tif")
        result = self.furrow("import", "u.tif", "-o", "s.furrow")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("degrees_east: taken as WGS 84", result.stderr)
        self.assertIn("zone 11N", self.json("info", "s.furrow")["srs"])

    def test_a_small_field_in_metres_is_no_field_in_degrees(self):
        self.make("lab.tif", 50, 40, lambda column, row: 0.02 * column, west=12.0, north=45.0, step=0.05, srs=None)
        self.ok("import", "lab.tif", "-o", "s.furrow")
        self.assertAlmostEqual(self.json("info", "s.furrow")["spacing"], 0.05)

    def test_values_that_count_down(self):
        self.make("depth.tif", 40, 30, lambda column, row: 25.0 + 0.5 * column, srs="EPSG:26911+6357")
        result = self.furrow("import", "depth.tif", "-o", "s.furrow", "--max-error", 0.001)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("count down", result.stderr)
        self.assertIn("converted from units of -1 m", self.json("info", "s.furrow")["vertical"])
        width, height, cells = self.exported("s.furrow", "--layer", "base")
        for i, found in enumerate(cells):
            self.assertAlmostEqual(found, -25 - 0.5 * (i % 40), delta=0.002)

    def test_a_png_with_a_place(self):
        values = [900 + (column * 7 + row * 13) % 400 for row in range(30) for column in range(40)]
        self.make("g.tif", 40, 30, lambda column, row: values[row * 40 + column], code="H")
        rasters.gdal("gdal_translate", "-q", "-of", "PNG", self.folder / "g.tif", self.folder / "aux.png")
        rasters.gdal("gdal_translate", "-q", "-of", "PNG", "-co", "WORLDFILE=YES", self.folder / "g.tif", self.folder / "wld.png")
        (self.folder / "wld.png.aux.xml").unlink()
        for source, options, srs in (("aux.png", (), "zone 33N"), ("wld.png", ("--s-srs", "EPSG:32633"), "zone 33N"), ("wld.png", (), "")):
            self.ok("import", source, *options, "-o", "s.furrow", "--overwrite")
            info = self.json("info", "s.furrow")
            self.assertEqual((info["spacing"], info["posts"]), (10, [40, 30]))
            self.assertIn(srs, info["srs"] or "")
            self.assertEqual(self.exported("s.furrow", "--layer", "base")[2], values)
        (self.folder / "tiles").mkdir()
        for name in ("aux.png", "aux.png.aux.xml"):
            (self.folder / "tiles" / name).write_bytes((self.folder / name).read_bytes())
        self.make("tiles/east.tif", 40, 30, lambda column, row: 700, west=500000 + 400)
        self.ok("import", "tiles", "-o", "both.furrow")
        self.assertEqual(len(self.json("info", "both.furrow")["sources"]), 2)
        (self.folder / "wld.wld").unlink()
        self.assertIn("has no place", self.refused(3, "import", "wld.png", "--s-srs", "EPSG:32633", "-o", "t.furrow"))

    def test_our_own_png_comes_back_where_it_was(self):
        self.make("g.tif", 40, 30, lambda column, row: 900 + (column * 7 + row * 13) % 400, code="H")
        self.ok("import", "g.tif", "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "own.png")
        self.ok("import", "own.png", "-o", "t.furrow")
        before, after = self.json("info", "s.furrow"), self.json("info", "t.furrow")
        self.assertEqual([before[key] for key in ("spacing", "posts", "origin")], [after[key] for key in ("spacing", "posts", "origin")])

    def notes(self, code, value, ground=lambda column, row: 500 + 40 * math.sin(column / 7), holed=lambda column, row: 10 < column < 25 and 8 < row < 20):
        self.make("n.tif", 60, 40, lambda column, row: value if holed(column, row) else (int if code in "hHi" else float)(ground(column, row)), code=code)
        return self.furrow("import", "n.tif", "-o", "s.furrow", "--overwrite").stderr

    def test_holes_that_nothing_declares_are_told(self):
        for code, value in (("H", 65535), ("h", 9999), ("f", -9999.0), ("H", 55537), ("h", 32767), ("f", 12345.0), ("i", -32768)):
            told = self.notes(code, value)
            self.assertIn(f"--nodata {value:g}" if abs(value) < 10000 else f"--nodata {int(value)}", told, (code, value))
            self.assertIn("at 154 posts", told)

    def test_a_lake_a_tower_and_a_peak_are_no_holes(self):
        for value, holed in ((455.0, None), (900.0, None), (2400.0, lambda column, row: (column, row) == (20, 20)), (0.0, None)):
            told = self.notes("f", value, **({"holed": holed} if holed else {}))
            self.assertNotIn("--nodata", told, value)

    def test_numbers_that_are_exchanged(self):
        self.make("g.tif", 40, 30, lambda column, row: 5.0, north=4000000)
        self.ok("import", "g.tif", "-o", "s.furrow")
        for srs, east, north in (("EPSG:32633", 500100, 3999900), ("degrees", 15.001, 36.143)):
            self.assertNotIn("exchanged", self.furrow("query", "s.furrow", "--srs", srs, east, north).stderr)
            told = self.furrow("query", "s.furrow", "--srs", srs, north, east)
            self.assertIn("outside", told.stdout)
            self.assertRegex(told.stderr, "exchanged|latitude and longitude")

    def turned(self, name, turn):
        """Heights of one ground in a raster that counts from another corner."""
        west, north, step = (500000 if turn in ("", "south") else 500400), (5000000 if turn in ("", "east") else 4999700), [10, 10]
        step[0] *= -1 if turn in ("east", "both") else 1
        step[1] *= -1 if turn in ("south", "both") else 1
        self.make(name, 40, 30, lambda column, row: 300 + 2 * (39 - column if step[0] < 0 else column) + 3 * (29 - row if step[1] < 0 else row) + (column * row) % 2, code="h",
                  west=west, north=north, step=tuple(step))

    def test_grids_that_count_from_another_corner_are_not_resampled(self):
        for turn in ("", "south", "east", "both"):
            self.turned("von süden.tif", turn)
            rasters.gdal("gdalwarp", "-q", "-overwrite", "-tr", 10, 10, "-te", 500000, 4999700, 500400, 5000000, self.folder / "von süden.tif", self.folder / "gdal.tif")
            result = self.furrow("import", "von süden.tif", "-o", "s.furrow", "--overwrite")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertNotIn("resampl", result.stderr + result.stdout)
            self.assertIn("measured: 0 m", result.stdout)
            self.assertEqual(self.exported("s.furrow", "--layer", "base")[2], list(rasters.pixels(self.folder / "gdal.tif")[2]))

    def test_turned_and_other_grids_join(self):
        self.turned("up.tif", "both")
        self.make("east.tif", 40, 30, lambda column, row: 7, west=500000 + 400, code="h")
        alone = None
        for order in (("up.tif", "east.tif"), ("east.tif", "up.tif")):
            self.ok("import", *order, "-o", "s.furrow", "--overwrite")
            self.assertEqual(self.json("info", "s.furrow")["posts"], [80, 30])
            cells = self.exported("s.furrow", "--layer", "base")[2]
            self.assertEqual(alone or cells, cells)
            alone = cells

    def test_rasters_of_one_pixel(self):
        self.make("one.tif", 1, 1, lambda column, row: 5.0)
        self.assertIn("at least 2 x 2", self.refused(3, "import", "one.tif", "-o", "s.furrow"))
        for column in range(3):
            self.make(f"strip {column}.tif", 1, 20, lambda _, row, column=column: 10.0 * column + row, west=500000 + 10 * column)
        self.ok("import", *(f"strip {column}.tif" for column in (2, 0, 1)), "-o", "s.furrow", "--max-error", 0)
        self.assertEqual(self.exported("s.furrow", "--layer", "base"), (3, 20, [10.0 * column + row for row in range(20) for column in range(3)]))

    def test_whole_metres_of_the_nearest_posts_stay_as_they_are(self):
        self.make("g.tif", 40, 30, lambda column, row: 300 + 2 * column + 3 * row, code="h")
        output = self.ok("import", "g.tif", "-o", "s.furrow", "-r", "near", "--spacing", 7)
        self.assertNotIn("rounded to", output)
        self.assertNotIn("-r cubic", output)
        self.assertIn("rounded to", self.ok("import", "g.tif", "-o", "t.furrow", "--spacing", 7))

    def test_a_height_range_that_does_not_reach_names_the_height(self):
        self.make("g.tif", 40, 30, lambda column, row: 300 + 2 * column + 3 * row, code="h")
        self.ok("import", "g.tif", "-o", "s.furrow")
        for name in ("r.png", "r.r16"):
            told = self.refused(3, "export", "s.furrow", "-o", name, "--height-range", "350,470")
            self.assertRegex(told, r"height of \d+ m does not fit the 16 bits of --height-range 350,470")
            self.ok("export", "s.furrow", "-o", name, "--height-range", "300,470")


if __name__ == "__main__":
    main()
