"""Into a store and out again: places, reference systems, nodata and heights as GDAL's own programs see them."""
import array
import math
import pathlib
import random
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import SHARED, long, main, part
from raster_test import RasterTest
import rasters


def random_height(noise):
    """Of any size: micrometres to 4,000 km, either sign."""
    return noise.choice((-1, 1)) * 10 ** noise.uniform(-6, 6.5)


class Places(RasterTest):
    DEGREES = {"srs": "EPSG:4326", "west": 15.2, "north": 46.9, "step": 0.001}

    def slope(self, x, y):
        """So steep that half a pixel either way is 2.5 or 3.5 m."""
        return 1000 + 5 * x - 7 * y

    def heights_at(self, store, points, srs):
        lines = "".join(f"{x!r} {y!r}\n" for x, y in points)
        return [p["height"] for p in self.json("query", store, "--srs", srs, stdin=lines)["points"]]

    def check_metres(self, source):
        """Store and export agree with gdalinfo on the place, and with gdallocationinfo on heights."""
        self.ok("import", source, "-o", "s.furrow", "--overwrite", "--tile", "8")
        place = rasters.gdalinfo(self.folder / source)["geoTransform"]
        self.assertEqual(self.json("info", "s.furrow")["geotransform"], place)
        self.ok("export", "s.furrow", "-o", "out.tif")
        self.assertEqual(rasters.gdalinfo(self.folder / "out.tif")["geoTransform"], place)
        points = [(place[0] + (x + 0.5) * place[1], place[3] + (y + 0.5) * place[5]) for x in (0, 7, 30, 49) for y in (0, 16, 39)]
        wanted = [float(v) for v in rasters.values_at(self.folder / source, points)]
        self.assertEqual(self.heights_at("s.furrow", points, "store"), wanted)
        self.assertEqual([float(v) for v in rasters.values_at(self.folder / "out.tif", points)], wanted)

    def test_pixel_is_point_and_pixel_is_area_are_not_shifted(self):
        for meaning in ("Area", "Point"):
            with self.subTest(meaning=meaning):
                self.make("in.tif", 50, 40, self.slope, "h", options=["-mo", f"AREA_OR_POINT={meaning}"])
                self.check_metres("in.tif")

    def test_a_projection_that_is_not_true_there_is_told(self):
        """At 46.9 degrees a metre of web Mercator is 0.68 m on the ground."""
        self.make("in.tif", 50, 40, self.slope, "h", **self.DEGREES)
        told = self.furrow("import", "in.tif", "-o", "s.furrow", "--t-srs", "EPSG:3857", "--dry-run")
        self.assertRegex(told.stderr, r"up to 3[12](\.\d+)? % off")
        self.assertIn("projected to WGS 84 / Pseudo-Mercator (EPSG:3857)\n", told.stdout)
        told = self.furrow("import", "in.tif", "-o", "s.furrow", "--dry-run")
        self.assertNotIn("% off", told.stderr)
        self.assertIn("UTM zone 33N (EPSG:32633), where a metre is a metre on the ground\n", told.stdout)

    def test_that_the_source_s_own_system_can_be_kept_is_told_only_where_it_can(self):
        self.make("degrees.tif", 50, 40, self.slope, "h", **self.DEGREES)
        self.make("feet.tif", 50, 40, self.slope, "h", srs="EPSG:2229", west=6400000, north=1900000)
        self.make("mercator.tif", 50, 40, self.slope, "h", srs="EPSG:3857", west=1670000, north=5900000)
        for source, more, can in (("degrees.tif", (), False), ("feet.tif", (), False), ("mercator.tif", (), True),
                                  ("mercator.tif", ("--t-srs", "auto"), True), ("mercator.tif", ("--t-srs", "EPSG:32633"), False)):
            with self.subTest(source=source, more=more):
                told = self.ok("import", source, "-o", "s.furrow", "--dry-run", *more)
                self.assertIn("\nprojected to ", told)
                self.assertEqual("; --t-srs source keeps the source's own system" in told, can)
                self.assertIn("--max-error 0.05 keeps them smooth", told)
                if can:
                    self.ok("import", source, "-o", "s.furrow", "--dry-run", "--t-srs", "source")

    def test_errors_of_resampling_are_told_with_what_lessens_them(self):
        self.make("in.tif", 50, 40, self.slope, "h", **self.DEGREES)
        come = "these come from resampling to posts 30.2 m apart, .*; a finer --spacing"
        self.assertRegex(self.ok("import", "in.tif", "-o", "s.furrow", "--spacing", 30.2), come + " or -r cubic lessens them\n")
        told = self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "--spacing", 30.2, "-r", "cubic", "--max-error", 0.05)
        self.assertRegex(told, come + " lessens them\n")
        self.assertNotIn("smooth", told)
        self.assertRegex(self.ok("info", "s.furrow"), r"\norigin +\d+\.\d{3,6}, \d+\.\d{3,6} ")

    def test_an_srs_in_place_of_the_files_own_is_told(self):
        self.make("in.tif", 50, 40, self.slope, "h")
        self.make("bare.tif", 50, 40, self.slope, "h", srs=None)
        for source, srs, told in (("in.tif", "EPSG:32634", "in.tif: the file says EPSG:32633; --s-srs EPSG:32634 is used\n"),
                                  ("in.tif", "EPSG:32633", ""), ("in.tif", "EPSG:32633+5773", ""), ("bare.tif", "EPSG:32634", "")):
            with self.subTest(source=source, srs=srs):
                found = self.furrow("import", source, "-o", "s.furrow", "--s-srs", srs, "--dry-run")
                self.assertEqual(found.returncode, 0, found.stderr)
                self.assertEqual(told != "", "the file says" in found.stderr, found.stderr)
                self.assertIn(told, found.stderr)

    def test_sources_far_apart_are_told_and_a_large_empty_terrain_refused(self):
        for name, west, north in (("a.tif", 500000, 5000000), ("b.tif", 700000, 5250000)):
            for step in (1, 100):
                self.make(f"{step}{name}", 40, 30, self.slope, "h", west=west, north=north, step=step)
        self.make("fine.tif", 40, 30, self.slope, "h", west=700000, north=5250000, step=10)
        told = self.refused(3, "import", "1a.tif", "1b.tif", "-o", "s.furrow")
        self.assertRegex(told, r"1a.tif: lies 320.1 km from 1b.tif, and the sources cover 4.7e-06 % of 5e\+10 posts; if one has a wrong SRS, .*--s-srs")
        told = self.furrow("import", "100a.tif", "100b.tif", "-o", "s.furrow", "--dry-run")
        self.assertRegex(told.stderr, "100a.tif: lies 31\\d.\\d km from 100b.tif, and the sources cover 0.04\\d % of 5.1")
        self.assertRegex(told.stdout, r"the sources cover 0.0\d+ % of 5.1\d*e\+06 posts: about 0.00 to 0.00 MB")
        self.assertIn("Import it apart", self.furrow("import", "100a.tif", "fine.tif", "-o", "s.furrow", "--dry-run").stderr)
        for i in range(1, 30):  # a corridor is none
            self.make(f"step{i}.tif", 40, 30, self.slope, "h", west=500000 + 4000 * i, north=5000000 + 3000 * i, step=100)
        told = self.furrow("import", "100a.tif", *(f"step{i}.tif" for i in range(1, 30)), "-o", "s.furrow", "--dry-run")
        self.assertEqual("", told.stderr)
        self.assertIn("cover 3.3", told.stdout)
        told = self.furrow("import", "100a.tif", "-o", "s.furrow", "--dry-run")
        self.assertEqual("", told.stderr)
        self.assertIn("cover 100 % of 1200 posts", told.stdout)

    def test_coordinates_that_are_nowhere_in_their_srs_are_told_first(self):
        self.make("in.tif", 50, 40, self.slope, "h")
        self.make("bare.tif", 50, 40, self.slope, "h", srs=None)
        for source, own in (("in.tif", "the file says EPSG:32633: leave --s-srs out, or "), ("bare.tif", "")):
            for more in ((), ("--t-srs", "EPSG:32633")):
                told = self.refused(3, "import", source, "-o", "s.furrow", "--s-srs", "EPSG:4326", *more)
                self.assertIn("its middle at 500250, 4999800 is nowhere in EPSG:4326: these are no degrees; " + own + "name the right one with --s-srs", told)

    def test_a_corner_at_zero_and_a_spacing_of_one_is_a_place(self):
        self.make("in.tif", 50, 40, self.slope, "h", west=0.0, north=0.0, step=1.0, srs=None)
        self.check_metres("in.tif")

    def check_projected(self, source, name, west, north, step, columns, rows):
        self.ok("import", source, "-o", "s.furrow", "--overwrite", "--max-error", "0.01")
        points = [(west + (x + 0.5) * step, north - (y + 0.5) * step)
                  for x in range(columns // 9, columns, columns // 9) for y in range(rows // 9, rows, rows // 9)]
        found = self.heights_at("s.furrow", points, "EPSG:4326")
        wanted = rasters.values_at(self.folder / name, points, "EPSG:4326")
        self.assertGreater(len(points), 50)
        for point, height, value in zip(points, found, wanted, strict=True):
            self.assertLess(abs(height - float(value)), 0.08, point)

    @long
    def test_projected_point_and_area_rasters_are_not_shifted(self):
        for meaning in ("Area", "Point"):
            with self.subTest(meaning=meaning):
                self.make("in.tif", 90, 90, self.slope, "h", options=["-mo", f"AREA_OR_POINT={meaning}"], **self.DEGREES)
                self.check_projected("in.tif", "in.tif", 15.2, 46.9, 0.001, 90, 90)

    def test_a_post_of_an_hgt_lies_on_its_degree(self):
        """SRTM: 1201 posts on whole degrees from side to side, big-endian."""
        cells = array.array("h", [self.slope(x, y) for y in range(1201) for x in range(1201)])
        cells.byteswap()
        (self.folder / "N46E015.hgt").write_bytes(cells.tobytes())
        half = 0.5 / 1200
        self.check_projected("N46E015.hgt", "N46E015.hgt", 15 - half, 47 + half, 1 / 1200, 1201, 1201)
        for x, y in ((600, 600), (300, 900), (1199, 1)):
            found, = self.heights_at("s.furrow", [(15 + x / 1200, 47 - y / 1200)], "EPSG:4326")
            self.assertLess(abs(found - self.slope(x, y)), 0.08)

    def test_a_query_at_a_post_beside_holes_is_that_post(self):
        """A place that no binary fraction is exactly: rounding must not reach over to the hole next to it."""
        self.make("in.tif", 40, 30, lambda x, y: 7 if (x + y) % 2 else -9, "h", nodata=-9, west=400814.8, north=3097562.1, step=87.2)
        self.ok("import", "in.tif", "-o", "s.furrow")
        posts = [(x, y) for x in range(40) for y in range(30)]
        points = [(400814.8 + (x + 0.5) * 87.2, 3097562.1 - (y + 0.5) * 87.2) for x, y in posts]
        for (x, y), height in zip(posts, self.heights_at("s.furrow", points, "store"), strict=True):
            self.assertEqual(height, 7 if (x + y) % 2 else None, (x, y))

    def test_levels_and_windows_export_in_their_place(self):
        self.make("in.tif", 50, 40, self.slope, "h")
        self.ok("import", "in.tif", "-o", "s.furrow", "--tile", "8")
        origin = self.json("info", "s.furrow")["origin"]
        for options, step, west, south in ((["--level", 1], 20, 0, 0), (["--level", 3], 80, 0, 0), (["--level", -2], 2.5, 0, 0),
                                           (["--window", "55,101,300,222"], 10, 60, 110),
                                           (["--level", 1, "--window", "55,101,300,222"], 20, 60, 120)):
            with self.subTest(options=options):
                self.ok("export", "s.furrow", "-o", "out.tif", *options)
                info = rasters.gdalinfo(self.folder / "out.tif")
                width, height = info["size"]
                x, y = origin[0] + west, origin[1] + south
                self.assertEqual(info["geoTransform"], [x - step / 2, step, 0, y + (height - 0.5) * step, 0, -step])
                points = [(x + i * step, y + j * step) for i in (0, 1, width - 1) for j in (0, 1, height - 1)]
                values = [float(v) for v in rasters.values_at(self.folder / "out.tif", points)]
                for value, wanted in zip(values, self.heights_at("s.furrow", points, "store"), strict=True):
                    self.assertAlmostEqual(value, wanted, places=3)


class ErrorBound(RasterTest):
    WIDTH, HEIGHT = 70, 61

    @long
    def test_the_bound_holds_at_every_exported_post(self):
        for seed, (bound, reach) in enumerate(((0, 1e8), (0.001, 4e6), (0.01, 4e6), (0.05, 4e6), (0.123, 4e6), (0.5, 4e6), (3, 4e6),
                                               (None, 4e6))):
            with self.subTest(bound=bound):
                noise = random.Random(seed)
                heights = [math.nan if noise.random() < 0.1 else min(reach, random_height(noise))
                           for _ in range(self.WIDTH * self.HEIGHT)]
                cells = array.array("f", heights)
                rasters.make(self.folder / "in.tif", self.WIDTH, self.HEIGHT, cells)
                options = [] if bound is None else ["--max-error", bound]
                self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "--tile", "16", *options)
                self.ok("export", "s.furrow", "-o", "out.tif", "--layer", "base")
                _, _, back = rasters.pixels(self.folder / "out.tif", "d")  # doubles, where floats do not hold the bound
                for source, stored in zip(cells, back, strict=True):
                    if math.isnan(source):
                        self.assertTrue(stored == -32767 or math.isnan(stored))
                    else:
                        self.assertLessEqual(abs(stored - source), 0.001 if bound is None else bound)

    @long
    def test_the_bound_holds_for_sources_of_64_bits(self):
        noise = random.Random(11)
        cells = [random_height(noise) for _ in range(400)]
        rasters.make(self.folder / "in.tif", 20, 20, cells, "d")
        for bound in (0.001, 0.03, 2):
            self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "--max-error", bound)
            lines = "".join(f"{10 * x} {190 - 10 * y}\n" for y in range(20) for x in range(20))
            for source, point in zip(cells, self.json("query", "s.furrow", stdin=lines)["points"], strict=True):
                self.assertLessEqual(abs(point["base"] - source), bound)

    def test_whole_numbers_are_kept_as_they_are(self):
        for code, scale in (("h", 1), ("H", 0.1), ("i", 0.01)):
            noise = random.Random(5)
            cells = [noise.randrange(0, 30000) for _ in range(900)]
            rasters.make(self.folder / "in.tif", 30, 30, cells, code, options=["-a_scale", scale])
            self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite")
            lines = "".join(f"{10 * x} {290 - 10 * y}\n" for y in range(30) for x in range(30))
            for source, point in zip(cells, self.json("query", "s.furrow", stdin=lines)["points"], strict=True):
                self.assertAlmostEqual(point["base"], source * scale, places=9)


class RoundTrips(RasterTest):
    def wkt(self, name):
        return rasters.gdalinfo(self.folder / name).get("coordinateSystem", {}).get("wkt", "")

    def check(self, source, *options):
        """Source -> store -> GeoTIFF -> store -> GeoTIFF."""
        self.ok("import", source, "-o", "a.furrow", "--overwrite", *options)
        self.ok("export", "a.furrow", "-o", "a.tif", "--layer", "base")
        self.ok("import", "a.tif", "-o", "b.furrow", "--overwrite")
        self.ok("export", "b.furrow", "-o", "b.tif", "--layer", "base")
        a, b = self.json("info", "a.furrow"), self.json("info", "b.furrow")
        for key in ("posts", "spacing", "geotransform", "origin", "bounds", "levels", "height"):
            self.assertEqual(a[key], b[key], key)
        # The same system; the names of its parts differ with the format that holds them.
        self.assertEqual(rasters.proj4(a["srs"]), rasters.proj4(b["srs"]))
        self.assertEqual(rasters.proj4(a["srs"]), rasters.proj4(self.wkt("a.tif")))
        info = rasters.gdalinfo(self.folder / "a.tif")
        self.assertEqual(info["size"], a["posts"])
        for ours, theirs in zip(a["geotransform"], info["geoTransform"], strict=True):
            self.assertAlmostEqual(ours, theirs, places=6)
        self.assertEqual(info["bands"][0]["noDataValue"], -32767)
        first, second = (rasters.pixels(self.folder / name, "f")[2] for name in ("a.tif", "b.tif"))
        self.assertEqual(first.tobytes(), second.tobytes())
        noise, (width, height), place = random.Random(3), info["size"], info["geoTransform"]
        posts = [(noise.randrange(width), noise.randrange(height)) for _ in range(40)]
        points = [(place[0] + (x + 0.5) * place[1], place[3] + (y + 0.5) * place[5]) for x, y in posts]
        found = [float(v) for v in rasters.values_at(self.folder / "a.tif", points)]
        lines = "".join(f"{x!r} {y!r}\n" for x, y in points)
        for value, point in zip(found, self.json("query", "a.furrow", "--srs", "store", stdin=lines)["points"], strict=True):
            if point["nodata"]:
                self.assertEqual(value, -32767)
            else:
                self.assertAlmostEqual(value, point["base"], delta=0.002)
        return info

    def check_as_source(self, source, *options):
        """What needs no projection comes out with its source's own system, place and posts."""
        info, was = self.check(source, *options), rasters.gdalinfo(self.folder / source)
        self.assertEqual(info["geoTransform"], was["geoTransform"])
        self.assertEqual(rasters.proj4(self.wkt("a.tif")), rasters.proj4(self.wkt(source)))
        _, _, cells = rasters.pixels(self.folder / source, "f")
        _, _, back = rasters.pixels(self.folder / "a.tif", "f")
        nodata = was["bands"][0].get("noDataValue")
        for source_cell, cell in zip(cells, back, strict=True):
            if source_cell == nodata or math.isnan(source_cell):
                self.assertEqual(cell, -32767)
            else:
                self.assertLessEqual(abs(cell - source_cell), 0.001)

    def test_synthetic_rasters_come_back(self):
        noise = random.Random(2)
        for code, nodata, srs in part((("h", -1, "EPSG:32633"), ("f", -9999, "EPSG:32719"), ("f", None, "EPSG:3035"), ("d", 0, None)), 0, 3):
            with self.subTest(code=code, srs=srs):
                east = {"EPSG:3035": 4321000.0, None: -30.0}.get(srs, 500000.0)
                north = {"EPSG:3035": 3210000.0, None: 77.0, "EPSG:32719": 6000000.0}.get(srs, 5000000.0)
                self.make("in.tif", 90, 70, lambda x, y: nodata if nodata is not None and holes(x, y) else
                          noise.randrange(1, 3000) + (0.25 if code != "h" else 0), code, west=east, north=north, srs=srs,
                          nodata=nodata)
                self.check_as_source("in.tif")

    def test_a_16_bit_png_comes_back_pixel_for_pixel(self):
        noise = random.Random(6)
        cells = [noise.choice((0, 1, 255, 256, 32767, 65535, noise.randrange(65536))) for _ in range(60 * 50)]
        rasters.make(self.folder / "in.png", 60, 50, cells, "H", driver="PNG", step=None, srs=None)
        for extra in ([], ["--height-range", "-100.5,8848.25"]):
            self.ok("import", "in.png", "-o", "s.furrow", "--overwrite", *extra)
            self.ok("export", "s.furrow", "-o", "out.png", *extra)
            self.assertEqual(list(rasters.pixels(self.folder / "out.png", "H")[2]), cells)
        self.assertFalse((self.folder / "out.pgw").exists())  # the store has no place on a body

    def test_a_png_tells_gdal_where_it_lies(self):
        self.make("in.tif", 60, 50, lambda x, y: x + y, "f", west=500000.0, north=5000000.0, srs="EPSG:32633", nodata=None)
        self.ok("import", "in.tif", "-o", "s.furrow", "--tile", 16)
        for extra in ([], ["--level", "1"], ["--window", "100,50,300,200"]):
            self.ok("export", "s.furrow", "-o", "out.png", *extra)
            self.ok("export", "s.furrow", "-o", "out.tif", *extra)
            png, tif = (rasters.gdalinfo(self.folder / name) for name in ("out.png", "out.tif"))
            self.assertEqual(png["geoTransform"], tif["geoTransform"])
            self.assertEqual(png["size"], tif["size"])
            self.assertEqual(png["coordinateSystem"]["wkt"], tif["coordinateSystem"]["wkt"])


def holes(x, y):
    return (x - 40) ** 2 + (y - 30) ** 2 < 200 or x == 0 or y == 69


@unittest.skipUnless((SHARED / "dem").is_dir(), "not on this machine: no shared elevation data")
class RealRoundTrips(RoundTrips):
    test_synthetic_rasters_come_back = test_a_16_bit_png_comes_back_pixel_for_pixel = None

    def copy(self, *names):
        for name in names:
            shutil.copy(SHARED / "dem" / name, self.folder)
        return names[0]

    @long
    def test_metric_ones_come_back_as_they_were(self):
        for name, more in (("bigtujunga.tif", []), ("sthelens.dem", []), ("gabilan_dtm1m.bil", ["gabilan_dtm1m.hdr"])):
            with self.subTest(name=name):
                self.check_as_source(self.copy(name, *more))

    @long
    def test_projected_ones_come_back_from_their_export(self):
        for name, options in (("craterlake.tif", ["--nodata", "-32767"]), ("mars_gale_ctx20m.tif", []), ("everest_voids.tif", [])):
            with self.subTest(name=name):
                self.check(self.copy(name), *options)

    @long
    def test_the_16_bit_png_comes_back_pixel_for_pixel(self):
        name = self.copy("heightmap16_1280.png")
        self.ok("import", name, "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "out.png")
        self.assertEqual(rasters.pixels(self.folder / name, "H")[2], rasters.pixels(self.folder / "out.png", "H")[2])


if __name__ == "__main__":
    main()
