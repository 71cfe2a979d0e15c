"""Insets: what import makes of nested sources of other spacings, beside GDAL and beside the sources themselves."""
import math
import os
import pathlib
import random
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, SHARED, largest, long, main, part
from raster_test import RasterTest
import rasters

WEST, SOUTH = 500000, 5000000  # of the country's first post


class Insets(RasterTest):
    """A country of 32 m, a site of 1 m in it, a scan of 1/16 m in that: all on one lattice, so that nothing is resampled."""

    def country(self, x, y):
        return round(400 + 60 * math.sin(x / 700) + 40 * math.cos(y / 500))

    def site(self, x, y):
        return 407 + 60 * math.sin(x / 700) + 40 * math.cos(y / 500) + 2 * math.sin(x / 9) * math.cos(y / 7)

    def scan(self, x, y):
        return self.site(x, y) - 1.5 + 0.1 * math.sin(x * 3) * math.sin(y * 2.5)

    def raster(self, name, value, x0, y0, width, height, step, code="f", **options):
        """Posts from (x0, y0) on, metres from the country's first."""
        self.make(name, width, height, lambda x, y: value(x0 + x * step, y0 + (height - 1 - y) * step), code, step=step,
                  west=WEST + x0 - step / 2, north=SOUTH + y0 + (height - 0.5) * step, **options)
        return name

    made = {}  # the bytes of the three, for the next test

    def three(self):
        for name, data in self.made.items():
            (self.folder / name).write_bytes(data)
        if self.made:
            return
        for name in (self.raster("country.tif", self.country, 0, 0, 97, 81, 32, "h"), self.raster("site.tif", self.site, 800, 600, 501, 401, 1),
                     self.raster("scan.tif", self.scan, 1000, 780, 641, 481, 1 / 16)):
            self.made[name] = (self.folder / name).read_bytes()

    def imported(self, *more, name="s.furrow", tile=64):
        self.ok("import", "country.tif", *more, "-o", name, "--tile", tile, "--overwrite")
        self.assertTrue(self.json("verify", name)["ok"])
        return name

    def base_of(self, store, level, x0, y0, x1, y1):
        """{(x, y): height} of a window, in metres from the country's first post."""
        step = 32 * 2.0 ** level
        self.ok("export", store, "-o", "window.tif", "--layer", "base", "--level", level, "--window", f"{x0},{y0},{x1},{y1}")
        width, height, cells = rasters.pixels(self.folder / "window.tif", "d")
        place = rasters.gdalinfo(self.folder / "window.tif")["geoTransform"]
        west, north = place[0] + step / 2 - WEST, place[3] - step / 2 - SOUTH
        return {(west + i % width * step, north - i // width * step): v for i, v in enumerate(cells)}

    def assertCore(self, store, level, window, truth, bound, most):
        heights = self.base_of(store, level, *window)
        self.assertGreater(len(heights), most)
        worst = largest(abs(v - truth(x, y)) for (x, y), v in heights.items())
        self.assertLessEqual(worst, bound)

    @unittest.skipUnless(os.environ.get("FURROW_MAPS") == "1", "this build draws no maps")
    def test_a_map_shades_the_relief_of_insets(self):
        self.three()
        spans = {}
        for name, window in (("with.furrow", "1010,790,1030,805"), ("with.furrow", "1200,1500,1220,1515"), ("site.furrow", "1010,790,1030,805")):
            if not (self.folder / name).exists():
                self.imported("--inset", "site.tif", *(("--inset", "scan.tif") if name[0] == "w" else ()), "--feather", 40, name=name)
            # nearly one colour, so that only the light differs
            self.ok("map", name, "-o", "m.png", "--window", window, "--height-range", "-1e6,1e6", "--grid", "none", "--exaggerate", 4)
            width, height, cells = rasters.pixels(self.folder / "m.png", "B")
            middle = [cells[y * width + x] for y in range(height // 3, height // 2) for x in range(width // 3, width // 2)]
            spans[name, window] = max(middle) - min(middle)
        found = self.json("info", "with.furrow")
        for inset in found["insets"]:
            self.assertEqual(inset["window"], [b - found["origin"][i % 2] for i, b in enumerate(inset["bounds"])])
            self.assertIn("; --window {:.10g},{:.10g},{:.10g},{:.10g}\n".format(*inset["window"]), self.ok("info", "with.furrow"))
        scan, beside, site = spans.values()
        self.assertGreater(scan, 8 + 2 * max(site, beside))

    def test_in_each_core_the_store_is_that_source_at_every_level(self):
        self.three()
        store = self.imported("--inset", "site.tif", "--inset", "scan.tif", "--feather", 40)
        self.assertEqual(self.json("info", store)["levels"], [-9, 1])
        for level in (-9, -7, -5):
            self.assertCore(store, level, (1011, 791, 1029, 799), self.scan, 0.00101, 100)
        for level in (-5, -3, 0):
            self.assertCore(store, level, (850, 650, 960, 950), self.site, 0.00101, 8)
        # where no inset lies, the store is what it is without one
        self.imported(name="plain.furrow")
        for level in (-2, 0):
            self.assertEqual(self.base_of(store, level, 0, 0, 760, 2500), self.base_of("plain.furrow", level, 0, 0, 760, 2500))
        # at every bound: the step of a country in whole metres is a multiple of the store's
        for bound in part((0.01, 0.1, 0.3), 1):
            store = self.imported("--inset", "site.tif", "--feather", 40, "--max-error", bound, name="coarser.furrow")
            self.assertEqual(self.base_of(store, 0, 0, 0, 760, 2500), self.base_of("plain.furrow", 0, 0, 0, 760, 2500))
            self.assertCore(store, -5, (850, 650, 960, 950), self.site, bound + 1e-4, 100)

    @long
    def test_the_tile_size_does_not_show(self):
        self.three()
        for name, tile in (("a", 16), ("b", 256)):
            self.imported("--inset", "scan.tif", "--inset", "site.tif", name=name, tile=tile)
        for level, window in ((-9, (995, 775, 1045, 815)), (-11, (1009, 779, 1013, 783)), (-5, (780, 580, 1320, 1010)), (0, (0, 0, 3000, 2500))):
            self.assertEqual(self.base_of("a", level, *window), self.base_of("b", level, *window))

    def steps(self, heights, step):
        return [abs(v - heights[x + step, y]) for (x, y), v in heights.items() if (x + step, y) in heights]

    @long
    def test_no_step_in_a_rim_is_above_the_slopes_that_meet_there(self):
        """The steepest of a feather is 1.5 times the difference over its width; half a step of heights comes with each post."""
        self.three()
        for feather, apart in ((20, 8.7), (80, 8.7)):
            store = self.imported("--inset", "site.tif", "--feather", feather)
            heights = self.base_of(store, -5, 790, 700, 860, 720)
            own = self.steps({p: self.site(*p) for p in heights}, 1)
            under = self.steps(self.base_of(self.imported(name="plain.furrow"), -5, 790, 700, 860, 720), 1)
            bound = max(own) + max(under) + 1.5 * apart / feather + 0.002
            self.assertLessEqual(largest(self.steps(heights, 1)), bound)
            self.assertGreater(max(self.steps(heights, 1)), 1.5 * 6 / feather)  # it rises at all
            # across the outline, where the weight begins, there is hardly any
            edge = [abs(heights[800.0, float(y)] - heights[801.0, float(y)]) for y in range(701, 719)]
            self.assertLess(largest(edge), largest(own) + largest(under) + 3 * apart / feather ** 2 + 0.002)

    @long
    def test_its_offset_is_found_and_taken_off_when_asked(self):
        self.three()
        for shift in (-3.0, 7.0):
            self.raster("flat.tif", lambda x, y: shift + self.country(x, y), 640, 640, 41, 31, 16)
            self.raster("country.tif", lambda x, y: 350, 0, 0, 97, 81, 32, "h")
            self.raster("flat.tif", lambda x, y: 350 + shift, 640, 640, 41, 31, 16)
            told = self.ok("import", "country.tif", "--inset", "flat.tif", "-o", "s.furrow", "--overwrite")
            self.assertIn(f"{abs(shift):.3f} m {'lower' if shift < 0 else 'higher'} than what surrounds it", told)
            self.assertCore("s.furrow", -1, (850, 850, 1000, 900), lambda x, y: 350 + shift, 0.001, 20)
            told = self.ok("import", "country.tif", "--inset", "flat.tif", "-o", "s.furrow", "--overwrite", "--match-heights")
            self.assertIn("taken off", told)
            self.assertCore("s.furrow", -1, (600, 600, 1300, 1200), lambda x, y: 350, 0.001, 20)

    def test_holes_are_filled_and_a_ragged_outline_is_feathered(self):
        """A pinhole gets what is around it; in the middle of a large hole is the country; beyond a slanted edge too."""
        def value(x, y):
            if (x, y) == (1000.0, 1000.0) or math.hypot(x - 1200, y - 1000) < 110 or x - 640 < (y - 640) * 0.3:
                return -9999.0
            return 460.0
        self.raster("country.tif", lambda x, y: 450, 0, 0, 97, 81, 32, "h")
        self.raster("holed.tif", value, 640, 640, 201, 181, 4, nodata=-9999)
        store = self.imported("--inset", "holed.tif", "--feather", 40)
        heights = self.base_of(store, -3, 600, 600, 1450, 1380)
        self.assertFalse(any(math.isnan(v) for v in heights.values()))
        self.assertAlmostEqual(heights[1000.0, 1000.0], 460, delta=10 * 3 * (4 / 40) ** 2)
        self.assertAlmostEqual(heights[1200.0, 1000.0], 450, delta=0.01)
        self.assertEqual(heights[700.0, 1000.0], 450)
        self.assertAlmostEqual(heights[900.0, 1000.0], 460, delta=0.002)
        self.assertLess(largest(self.steps(heights, 4.0)), 1.5 * 10 / 40 * 4 + 0.1)

    @long
    def test_of_two_the_first_named_lies_on_top(self):
        self.raster("country.tif", lambda x, y: 100, 0, 0, 97, 81, 32, "h")
        self.raster("a.tif", lambda x, y: 110, 640, 640, 101, 101, 4)
        self.raster("b.tif", lambda x, y: 120, 840, 640, 101, 101, 4)
        for first, second, height in (("a.tif", "b.tif", 110), ("b.tif", "a.tif", 120)):
            self.imported("--inset", first, "--inset", second, "--feather", 20)
            self.assertCore("s.furrow", -3, (870, 700, 1010, 1000), lambda x, y: height, 0.001, 500)

    def test_the_store_grows_by_the_insets_posts(self):
        self.three()
        store = self.imported("--inset", "site.tif", tile=32)
        plain, inset = self.json("info", self.imported(name="plain.furrow", tile=32)), self.json("info", store)
        grown = inset["bytes"]["base"] - plain["bytes"]["base"]
        self.assertLess(grown, 3.2 * 501 * 401)
        finer = inset["tiles"]["base"] - plain["tiles"]["base"]
        self.assertLess(finer * 32 * 32, 2.2 * 501 * 401)

    @long
    def test_a_flat_store_of_a_branch_has_the_insets(self):
        self.three()
        store = self.imported("--inset", "site.tif", "--inset", "scan.tif")
        self.ok("branch", store, "b.furrow")
        self.ok("flatten", "b.furrow", "-o", "flat.furrow")
        self.assertTrue(self.json("verify", "flat.furrow")["ok"])
        inset, flat = self.json("info", store), self.json("info", "flat.furrow")
        for key in ("tiles", "levels", "base_hash", "height"):
            self.assertEqual(flat[key], inset[key], key)
        for level, window in ((-9, (1010, 790, 1014, 794)), (-5, (830, 630, 900, 700)), (0, (0, 0, 3072, 2560))):
            self.assertEqual(self.base_of("flat.furrow", level, *window), self.base_of(store, level, *window))

    VIEW = """scene: 1
time_step: 0.1
end_time: 0.2
view:
  size: [320, 240]
  camera: {fixed: {eye: [390, 330, 520], target: [520, 520, 420]}}
  effects: []
  images: 1
cache: {slots: 256}
"""

    def picture_of(self, store):
        self.drive(self.scene(self.VIEW), "--store", store, "--overlay", store + ".over")
        width, height, cells = rasters.pixels(self.folder / "out" / "frame-000001.png", "B")
        return cells

    def test_a_picture_shows_the_inset_as_if_all_were_as_fine(self):
        """The same ground once more, all of it at the inset's spacing, must look the same; the country alone must not."""
        def rough(x, y):
            return self.site(x, y) + 3 * math.sin(x / 11) * math.sin(y / 13)
        self.raster("country.tif", self.country, 0, 0, 33, 33, 32, "h")
        self.raster("site.tif", rough, 400, 400, 301, 301, 2)
        store, plain = self.imported("--inset", "site.tif", "--feather", 30), self.imported(name="plain.furrow")
        self.ok("export", store, "-o", "fine.tif", "--layer", "base", "--level", -4)
        self.ok("import", "fine.tif", "-o", "fine.furrow", "--tile", 64)
        seen, fine, coarse = self.picture_of(store), self.picture_of("fine.furrow"), self.picture_of(plain)
        off = [sum(abs(a - b) for a, b in zip(seen, other)) / len(seen) for other in (fine, coarse)]
        self.assertLess(off[0], 0.25 * off[1])
        self.assertLess(off[0], 1.5)
        self.assertGreater(off[1], 3)

    def test_what_cannot_be_an_inset_is_refused_and_leaves_nothing(self):
        self.three()
        self.raster("coarse.tif", self.country, 320, 320, 11, 11, 32)
        self.raster("away.tif", self.site, 9000, 9000, 51, 51, 1)
        self.raster("bare.tif", self.site, 800, 600, 51, 51, 1, srs=None)
        for name, why in (("coarse.tif", "no finer than"), ("away.tif", "does not lie in the terrain"), ("bare.tif", "no SRS"),
                          ("gone.tif", "no such file")):
            told = self.refused(3, "import", "country.tif", "--inset", name, "-o", "no.furrow")
            self.assertIn(name, told)
            self.assertIn(why, told)
        self.assertEqual(list(self.folder.glob("no.furrow*")), [])

    @long
    def test_neither_threads_nor_a_kill_show_in_the_store(self):
        self.three()
        insets = ("--inset", "site.tif", "--inset", "scan.tif")
        hashes = {self.json("info", self.imported(*insets, "--jobs", jobs))["base_hash"] for jobs in (1, 3)}
        for after in (0.02, 0.1, 0.2, 0.4):
            (self.folder / "s.furrow").unlink(missing_ok=True)
            process = subprocess.Popen([FURROW, "import", "country.tif", *insets, "-o", "s.furrow", "--tile", "64"], cwd=self.folder,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(after)
            process.kill()
            process.wait()
            if not (self.folder / "s.furrow").exists():
                self.imported(*insets, "--resume")
            hashes.add(self.json("info", "s.furrow")["base_hash"])
        self.assertEqual(len(hashes), 1)


    # --- without --inset ---

    def info_of(self, *arguments, told=None):
        result = self.furrow("import", *arguments, "-o", "s.furrow", "--tile", 64, "--overwrite")
        self.assertEqual(result.returncode, 0, result.stderr)
        if told:
            self.assertRegex(result.stdout + result.stderr, told)
        self.assertTrue(self.json("verify", "s.furrow")["ok"])
        return self.json("info", "s.furrow")

    def test_finer_sources_are_insets_whatever_the_order(self):
        self.three()
        named = self.json("info", self.imported("--inset", "site.tif", "--inset", "scan.tif"))
        for order in (("country.tif", "site.tif", "scan.tif"), ("scan.tif", "country.tif", "site.tif"), ("site.tif", "scan.tif", "country.tif")):
            found = self.info_of(*order, told=r"inset scan.tif: 641 x 481 posts, 0.0625 m apart, level -9, .*finer than the others")
            for key in ("base_hash", "levels", "spacing", "posts", "origin", "srs", "off_source", "off_resampled"):
                self.assertEqual(found[key], named[key], key)
            self.assertEqual(sorted(found["sources"]), sorted(named["sources"]))
        # A spacing is one for all.
        found = self.info_of("country.tif", "site.tif", "--spacing", 16)
        self.assertEqual((found["levels"][0], found["insets"]), (0, []))

    @long
    def test_about_as_fine_is_no_inset(self):
        self.raster("country.tif", self.country, 0, 0, 97, 81, 32, "h")
        for step, level in ((33, 0), (17, 0), (16, -1), (15, -2), (8, -2)):
            self.raster("near.tif", self.site, 640, 640, 61, 51, step)
            found = self.info_of("country.tif", "near.tif")
            self.assertEqual(found["levels"][0], level)
            self.assertEqual(found["spacing"], 32 if level < 0 else min(step, 32))

    @long
    def test_what_lies_beside_is_no_inset(self):
        self.raster("country.tif", self.country, 0, 0, 65, 65, 32, "h")
        for x0, level in ((2000, -3), (2030, -3), (2100, 0), (2300, 0)):
            self.raster("beside.tif", self.site, x0 - 120, 640, 41, 41, 4)
            found = self.info_of("beside.tif", "country.tif", told=None if level < 0 else "note: beside.tif: its posts of 4 m are finer")
            self.assertEqual((found["levels"][0], found["spacing"]), (level, 32 if level < 0 else 4))

    @long
    def test_tiles_side_by_side_are_one_inset_without_a_rim_between(self):
        self.three()
        whole = self.info_of("country.tif", "site.tif")
        wanted = self.base_of("s.furrow", -5, 780, 580, 1320, 1020)
        for tiles in range(2, 5):
            names = []
            for i in range(tiles):
                first, last = 500 * i // tiles, 500 * (i + 1) // tiles
                names.append(self.raster(f"tile{i}.tif", self.site, 800 + first, 600, last - first + 1, 401, 1))
            found = self.info_of(*names, "country.tif", told=rf"inset tile0.tif and {tiles - 1} more: 501 x 401 posts")
            self.assertEqual(found["levels"], whole["levels"])
            self.assertEqual(len(found["insets"]), 1)
            self.assertEqual(self.base_of("s.furrow", -5, 780, 580, 1320, 1020), wanted)
        # far from each other they are two
        self.raster("tile0.tif", self.site, 300, 300, 101, 101, 1)
        self.raster("tile1.tif", self.site, 2000, 2000, 101, 101, 1)
        self.assertEqual([i["source"] for i in self.info_of("tile1.tif", "country.tif", "tile0.tif")["insets"]], ["tile1.tif", "tile0.tif"])

    def test_a_window_leaves_out_what_it_does_not_have(self):
        self.three()
        found = self.info_of("country.tif", "site.tif", "--window", f"{WEST + 1600},{SOUTH},{WEST + 3000},{SOUTH + 900}", told="site.tif: left out")
        self.assertEqual((found["levels"][0], found["insets"]), (0, []))
        found = self.info_of("country.tif", "site.tif", "--window", f"{WEST + 1000},{SOUTH},{WEST + 3000},{SOUTH + 900}")
        self.assertEqual(found["insets"][0]["posts"][0], 277)  # from 1024 to 1300 m

    def test_info_tells_each_inset(self):
        self.three()
        found = self.json("info", self.imported("--inset", "scan.tif", "--inset", "site.tif"))["insets"]
        self.assertEqual(found[0], {"source": "scan.tif", "level": -9, "spacing": 1 / 16, "posts": [641, 481],
                                    "bounds": [WEST + 1000, SOUTH + 780, WEST + 1040, SOUTH + 810], "window": [1000, 780, 1040, 810],
                                    "tiles": 12 * 9})
        self.assertEqual([found[1][key] for key in ("source", "level", "posts")], ["site.tif", -5, [501, 401]])
        lines = [line for line in self.ok("info", "s.furrow").splitlines() if line.startswith("inset ")]
        self.assertEqual(len(lines), 2)
        self.assertRegex(lines[1], r"site.tif: 501 x 401 posts, 1 m apart, level -5, 63 tiles; 500800.000, 5000600.000 to 501300.000, 5001000.000")
        self.ok("branch", "s.furrow", "b.furrow")
        self.ok("flatten", "b.furrow", "-o", "flat.furrow")
        for name in ("b.furrow", "flat.furrow"):
            self.assertEqual(self.json("info", name)["insets"], found)

    @long
    def test_s_srs_is_that_of_insets_too(self):
        self.three()
        def heights():
            return self.base_of("s.furrow", -5, 700, 500, 1400, 1100)
        self.info_of("country.tif", "--inset", "site.tif")
        wanted = heights()
        self.raster("bare.tif", self.site, 800, 600, 501, 401, 1, srs=None)
        self.raster("far.tif", self.site, 800, 600, 501, 401, 1, srs="EPSG:32634")
        for name in ("bare.tif", "far.tif"):
            self.info_of("country.tif", "--inset", name, "--s-srs", "EPSG:32633")
            self.assertEqual(heights(), wanted)

    @long
    def test_the_bound_holds_everywhere(self):
        """The country's heights are whole metres, to which it is also rounded where it is resampled; the inset's are finer."""
        self.three()
        for spacing in (32, 24, 70):
            self.ok("import", "country.tif", "--inset", "site.tif", "--spacing", spacing, "-o", "s.furrow", "--overwrite")
            found = self.json("info", "s.furrow")
            self.assertEqual(found["max_error"], 0.5)
            self.assertLessEqual(found["off_resampled"]["greatest"], found["max_error"])

    def test_the_error_at_the_sources_posts_counts_insets(self):
        """Posts that are kept are off by the bound alone. Beside the lattice they are off as the surface between stored posts is, which
        is computed here once more."""
        self.three()
        plain = self.info_of("country.tif")["off_source"]
        found = self.info_of("country.tif", "--inset", "site.tif", "--max-error", 0.01, "--feather", 10)
        core = (501 - 2 * 10) * (401 - 2 * 10)
        self.assertAlmostEqual(found["off_source"]["posts"] - plain["posts"], core, delta=0.02 * core)
        self.assertLessEqual(found["off_source"]["greatest"], 0.5)
        self.assertEqual(found["off_source"], found["off_resampled"])
        for step in (1.25, 3, 7):
            self.raster("off.tif", self.site, 803.3, 601.7, 90, 80, step)
            found = self.info_of("country.tif", "--inset", "off.tif", "--max-error", 0.01, "--feather", 40)
            inset = found["insets"][0]
            stored = self.base_of("s.furrow", inset["level"], 803, 601, 803 + 90 * step, 601 + 80 * step)
            fine, off = inset["spacing"], []
            for i in range(90):
                for j in range(80):
                    x, y = 803.3 + i * step, 601.7 + j * step
                    if min(i, 89 - i, j, 79 - j) * step < min(40, 79 * step / 4) + 2:
                        continue
                    west, south = math.floor(x / fine) * fine, math.floor(y / fine) * fine
                    u, v = (x - west) / fine, (y - south) / fine
                    a, b, c, d = (stored[west + p * fine, south + q * fine] for q in (0, 1) for p in (0, 1))
                    off.append((a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v - self.site(x, y))
            told = found["off_source"]
            self.assertAlmostEqual(told["posts"] - plain["posts"], len(off), delta=0.12 * len(off) + 40)
            self.assertGreaterEqual(told["greatest"], largest(map(abs, off)) - 0.001)
            self.assertLess(told["greatest"], 1.3 * largest(map(abs, off)) + 0.011)
            squares = told["rms"] ** 2 * told["posts"]
            self.assertAlmostEqual(squares, sum(v * v for v in off), delta=0.2 * sum(v * v for v in off) + 0.01)


@unittest.skipUnless((SHARED / "dem").is_dir(), "not on this machine: no shared elevation data")
class RealInsets(RasterTest):
    """Big Tujunga at 30 m; a site of it, made finer and raised; the Gabilan ground made a scan of 5 cm. GDAL makes them and says what
    is true."""

    def test_three_nested_sources(self):
        dem, made = SHARED / "dem", self.folder
        rasters.gdal("gdalwarp", "-q", "-ot", "Float32", "-r", "cubicspline", "-tr", 1, 1, "-te", 394000, 3798000, 394600, 3798500,
                     dem / "bigtujunga.tif", made / "flat.tif")
        rasters.gdal("gdal_translate", "-q", "-scale", 0, 1000, 3, 1003, made / "flat.tif", made / "site.tif")
        ground = float(rasters.values_at(made / "site.tif", [(394300, 3798250)])[0])
        rasters.gdal("gdal_translate", "-q", "-srcwin", 200, 200, 400, 360, "-a_srs", "EPSG:32611", "-a_ullr", 394290, 3798259, 394310,
                     3798241, "-ot", "Float32", "-scale", 187.9, 307.3, ground, ground + 6, dem / "gabilan_dtm1m.bil", made / "scan.tif")
        told = self.ok("import", dem / "bigtujunga.tif", "--inset", "site.tif", "--inset", "scan.tif", "-o", "s.furrow")
        self.assertRegex(told, r"site.tif: .* level -5.*\n  [23]\.\d+ m higher")
        self.assertRegex(told, r"scan.tif: .* level -10")
        self.assertTrue(self.json("verify", "s.furrow")["ok"])
        for level, source, window in ((-5, "site.tif", (394160, 3798170, 394280, 3798220)),
                                      (-10, "scan.tif", (394296, 3798247, 394304, 3798253))):
            self.check_core(level, source, window)
        # the same site in degrees, the same scan in the next zone: resampled twice, but the same ground
        rasters.gdal("gdalwarp", "-q", "-t_srs", "EPSG:4326", "-r", "cubic", made / "site.tif", made / "degrees.tif")
        rasters.gdal("gdalwarp", "-q", "-t_srs", "EPSG:32612", "-r", "cubic", "-tr", 0.05, 0.05, made / "scan.tif", made / "zone.tif")
        told = self.furrow("import", dem / "bigtujunga.tif", "--inset", "degrees.tif", "--inset", "zone.tif", "-o", "s.furrow", "--overwrite")
        self.assertEqual((told.returncode, told.stderr), (0, ""))
        self.assertRegex(told.stdout, r"degrees.tif: .* level -5(.|\n)*zone.tif: .* level -10")
        self.assertTrue(self.json("verify", "s.furrow")["ok"])
        self.check_core(-5, "site.tif", (394160, 3798170, 394280, 3798220), 0.03)
        self.check_core(-10, "scan.tif", (394296, 3798247, 394304, 3798253), 0.05)

    def check_core(self, level, source, window, bound=0.0012):
        """Every post of a window against what gdalwarp makes of the source on the same lattice."""
        info = self.json("info", "s.furrow")
        west, south = info["origin"]
        near = [v - o for v, o in zip(window, (west, south) * 2)]
        self.ok("export", "s.furrow", "-o", "w.tif", "--layer", "base", "--level", level,
                "--window", ",".join(map(repr, near)))
        place = rasters.gdalinfo(self.folder / "w.tif")
        gt, (width, height) = place["geoTransform"], place["size"]
        step = 30 * 2.0 ** level
        rasters.gdal("gdalwarp", "-q", "-overwrite", "-r", "bilinear", "-et", 0, "-tr", step, step, "-te", repr(gt[0]),
                     repr(gt[3] - height * step), repr(gt[0] + width * step), repr(gt[3]), "-t_srs", "EPSG:32611", self.folder / source,
                     self.folder / "truth.tif")
        wide, high, ours = rasters.pixels(self.folder / "w.tif")
        self.assertEqual((wide, high), rasters.pixels(self.folder / "truth.tif")[:2])
        truth = rasters.pixels(self.folder / "truth.tif")[2]
        self.assertGreater(len(ours), 5000)
        self.assertLessEqual(largest(abs(a - b) for a, b in zip(ours, truth, strict=True)), bound)
        # and by points, as a user asks
        pixels = random.Random(level).sample(range(len(ours)), 40)
        points = [(gt[0] + (i % width + 0.5) * step, gt[3] - (i // width + 0.5) * step) for i in pixels]
        lines = "".join(f"{x!r} {y!r}\n" for x, y in points)
        heights = [p["height"] for p in self.json("query", "s.furrow", "--srs", "EPSG:32611", stdin=lines)["points"]]
        self.assertLessEqual(largest(abs(h - truth[i]) for h, i in zip(heights, pixels, strict=True)), bound)


if __name__ == "__main__":
    main()
