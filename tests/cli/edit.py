"""furrow edit: soil is brought and taken; the account of the store holds through drives, history, overlays and ranks; and what is refused."""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, has_gdal, main
from store_reader import Store

SQUARE = "POLYGON ((20 20, 30 20, 30 30, 20 30, 20 20))"
UNIT = 2**20
DRIVE = """scene: 1
time_step: 0.05
end_time: 2
spacing: 0.5
soil: {name: dry_sand}
redistribute: {model: scm}
objects:
  - {name: left, shape: {wheel: {radius: 0.8, width: 1.2}}, sink: 0.1, path: {points: [[14, 24], [44, 26]], speed: 12}}
  - {name: right, shape: {wheel: {radius: 0.8, width: 1.2}}, sink: 0.1, path: {points: [[14, 40], [44, 42]], speed: 12}}
"""


class Edit(FurrowTest):
    def plain(self, name="world.furrow", spacing=0.5):
        return self.synth(name, posts="129x129", spacing=spacing, kind="plain", relief=0)

    def balanced(self, store, added):
        """The store is whole, and its offsets + compacted soil are what was added: an independent reader says so, too."""
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["added"], added)
        self.assertEqual(check["offset_sum"]["0"] + check["compacted"], added)
        self.assertEqual(self.json("info", store)["added"], added)
        read = Store(self.folder / store)
        self.assertEqual((read.added, sum(read.offset(0)) + read.compacted), (added, added))

    def heights(self, store, *places):
        points = self.json("query", store, *(number for place in places for number in place))["points"]
        return [point["offset"] for point in points]


class Pours(Edit):
    def test_a_heap_slides_to_its_repose_and_its_volume_is_exact(self):
        self.plain()
        told = self.json("edit", "world.furrow", "--polygon", SQUARE, "--volume", 123.4567)
        units = round(123.4567 / 0.25 * UNIT)
        self.assertEqual((told["added_quanta"], told["posts"], told["settled"], told["loose"]), (units, 400, True, True))
        self.assertAlmostEqual(told["added"], units / UNIT * 0.25, delta=1e-12)
        self.assertEqual(told["bounds"], [20, 20, 29.5, 29.5])
        self.assertGreater(told["slid_for"], 0)
        self.balanced("world.furrow", units)
        read = Store(self.folder / "world.furrow")
        offsets = read.offset(0)
        steepest = max(abs(offsets[i] - offsets[i + 1]) for i in range(len(offsets) - 1) if i % 129 != 128) / UNIT / 0.5
        self.assertLess(math.degrees(math.atan(steepest)), 37)  # dry sand rests at 35
        text = self.ok("info", "world.furrow")
        self.assertRegex(text, rf"\nadded +{units / UNIT * 0.25:.6g} m3\n")
        self.assertEqual(self.json("log", "world.furrow")["revisions"][0]["what"], "edit")

    def test_a_dense_pit_stands_and_a_snapshot_undoes_it(self):
        self.plain()
        told = self.json("edit", "world.furrow", "--polygon", SQUARE, "--depth", -1.25, "--dense", "--snapshot", "before")
        self.assertEqual((told["added_quanta"], told["slid_for"]), (-400 * UNIT * 5 // 4, 0))
        self.assertEqual(self.heights("world.furrow", (25, 25), (20, 20), (19.5, 20), (30, 30)), [-1.25, -1.25, 0, 0])
        self.balanced("world.furrow", -400 * UNIT * 5 // 4)
        dug = self.json("log", "world.furrow")["revisions"][0]["revision"]
        self.ok("restore", "world.furrow", "before")
        self.balanced("world.furrow", 0)
        self.ok("restore", "world.furrow", dug)
        self.balanced("world.furrow", -400 * UNIT * 5 // 4)
        self.ok("reset", "world.furrow", "--force")
        self.assertEqual(self.json("info", "world.furrow")["added"], 0)

    def test_a_dry_run_changes_no_byte(self):
        path = self.plain()
        before = path.read_bytes()
        told = self.json("edit", "world.furrow", "--polygon", SQUARE, "--volume", 5, "--snapshot", "no", "--dry-run")
        self.assertEqual((told["done"], told["posts"], told["revision"]), (False, 400, 0))
        self.assertIn("would be changed: 5 m3 added to 400 posts", self.ok("edit", "world.furrow", "--polygon", SQUARE, "--volume", 5, "--dry-run"))
        self.assertEqual(path.read_bytes(), before)

    def test_polygons_come_as_text_as_files_and_in_other_systems(self):
        for name in ("a", "b", "c"):
            self.plain(f"{name}.furrow")
        (self.folder / "square.wkt").write_text("\n" + SQUARE.replace("POLYGON", "Polygon Z") .replace("20 20", "20 20 7") + "\n")
        ring = [[20, 20], [30, 20], [30, 30], [20, 30], [20, 20]]
        (self.folder / "square.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
        for name, polygon in (("a", SQUARE), ("b", "square.wkt"), ("c", "square.geojson")):  # a store without a system: metres
            self.ok("edit", f"{name}.furrow", "--polygon", polygon, "--volume", 5, "--dense")
        self.assertEqual(len({str(Store(self.folder / f"{name}.furrow").offset(0)) for name in "abc"}), 1)
        self.assertIn("reference system", self.refused(3, "edit", "a.furrow", "--polygon", SQUARE, "--srs", "EPSG:4326", "--volume", 5))

    def test_another_soil_rests_at_another_slope(self):
        highest = {}
        for soil in ("dry_sand", "heavy_clay_40"):
            self.plain(f"{soil}.furrow")
            self.ok("edit", f"{soil}.furrow", "--polygon", SQUARE, "--depth", 3, "--soil", soil)
            highest[soil] = self.heights(f"{soil}.furrow", (25, 25))[0]
        self.assertGreater(highest["dry_sand"], highest["heavy_clay_40"] + 0.5)  # wet clay flows further

    def test_a_scenes_spacing_and_soils_count_and_its_bodies_do_not(self):
        self.plain()
        told = self.json("edit", "world.furrow", "--scene", self.scene(DRIVE.replace("spacing: 0.5", "spacing: 0.25")), "--polygon", SQUARE, "--volume", 5)
        self.assertEqual((told["spacing"], told["posts"]), (0.25, 1600))
        check = self.json("verify", "world.furrow")
        self.assertEqual(check["offset_sum"]["-1"], check["added"])


class Goes(Edit):
    """The account goes on through drives and all that a store does."""

    def edited(self, name="world.furrow"):
        self.plain(name)
        return self.json("edit", name, "--polygon", SQUARE, "--volume", 50)["added_quanta"]

    def test_a_drive_over_it_keeps_the_account(self):
        added = self.edited()
        run = self.drive(self.scene(DRIVE), "--store", "world.furrow")
        self.assertEqual(run["volume"]["quanta"]["added"], 0)  # of the drive's own
        self.assertEqual(run["volume"]["quanta"]["net"] + run["volume"]["quanta"]["compacted"], 0)
        self.balanced("world.furrow", added)
        self.json("edit", "world.furrow", "--polygon", SQUARE, "--volume", -10)
        self.balanced("world.furrow", added - 10 * 4 * UNIT)

    def test_overlays_pins_and_merges_have_it(self):
        added = self.edited()
        self.ok("branch", "world.furrow", "a.furrow")
        self.ok("branch", "world.furrow", "b.furrow")
        self.ok("edit", "a.furrow", "--polygon", "POLYGON ((5 5, 10 5, 10 10, 5 10))", "--volume", 2, "--dense")
        self.ok("edit", "b.furrow", "--polygon", "POLYGON ((50 50, 60 50, 60 60, 50 60))", "--volume", -3, "--dense")
        for name, more in (("a", 2), ("b", -3)):
            self.balanced(f"{name}.furrow", added + more * 4 * UNIT)
        # Their parent goes on: they show what it was.
        self.ok("edit", "world.furrow", "--polygon", SQUARE, "--volume", 7)
        self.balanced("world.furrow", added + 7 * 4 * UNIT)
        for name, more in (("a", 2), ("b", -3)):
            self.balanced(f"{name}.furrow", added + more * 4 * UNIT)
        self.ok("flatten", "a.furrow", "-o", "flat.furrow")
        self.balanced("flat.furrow", added + 2 * 4 * UNIT)
        self.ok("merge", "a.furrow", "b.furrow", "-o", "ab.furrow")
        self.balanced("ab.furrow", added - 1 * 4 * UNIT)
        self.ok("branch", "b.furrow", "c.furrow")
        self.ok("edit", "c.furrow", "--polygon", SQUARE, "--volume", 1)
        self.ok("reset", "c.furrow")
        self.balanced("c.furrow", added - 3 * 4 * UNIT)

    def test_history_has_it_at_each_revision(self):
        added = self.edited()
        self.ok("snapshot", "world.furrow", "heap")
        self.drive(self.scene(DRIVE), "--store", "world.furrow", "--keep-history")
        self.ok("edit", "world.furrow", "--polygon", SQUARE, "--volume", 8)
        self.ok("snapshot", "world.furrow", "more")
        self.ok("edit", "world.furrow", "--polygon", SQUARE, "--volume", -4)
        for name, volume in (("heap", 0), ("more", 8), ("heap", 0)):
            self.ok("restore", "world.furrow", name)
            self.balanced("world.furrow", added + volume * 4 * UNIT)

    def test_ranks_have_the_same_ground_and_account(self):
        if shutil.which("mpirun") is None:
            self.skipTest("no mpirun here")
        added = self.edited("one.furrow")
        shutil.copy(self.folder / "one.furrow", self.folder / "many.furrow")
        scene = self.scene(DRIVE)
        self.drive(scene, "--store", "one.furrow", "--overlay", "one-over.furrow")
        result = subprocess.run(["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2", FURROW, "drive", str(scene), "--store", "many.furrow", "--overlay",
                                 "many-over.furrow", "-o", "ranks"], cwd=self.folder, capture_output=True, text=True, timeout=280, env=dict(os.environ))
        if "no MPI" in result.stderr:
            self.skipTest("not on this machine: MPI")
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ("one-over.furrow", "many-over.furrow"):
            self.balanced(name, added)
        self.assertEqual(Store(self.folder / "one-over.furrow").offset(0), Store(self.folder / "many-over.furrow").offset(0))


class Rasters(Edit):
    def setUp(self):
        super().setUp()
        if not has_gdal():
            self.skipTest("not on this machine: GDAL's programs")

    def run_gdal(self, *command):
        subprocess.run([*map(str, command)], cwd=self.folder, check=True, capture_output=True)

    def test_what_was_exported_comes_back(self):
        self.plain()
        self.ok("edit", "world.furrow", "--polygon", SQUARE, "--volume", 50)
        self.ok("edit", "world.furrow", "--polygon", "POLYGON ((40 40, 50 41, 45 50))", "--depth", -0.7, "--dense")
        self.ok("export", "world.furrow", "--layer", "offset", "-o", "changes.tif")
        self.plain("other.furrow")
        told = self.json("edit", "other.furrow", "--add", "changes.tif", "--dense")
        self.assertEqual(told["added_quanta"], self.json("info", "world.furrow")["added"])
        self.balanced("other.furrow", told["added_quanta"])
        self.assertEqual(Store(self.folder / "other.furrow").offset(0), Store(self.folder / "world.furrow").offset(0))

    def test_rasters_that_do_not_fit_are_refused_with_what_to_do(self):
        path = self.plain()
        self.ok("edit", "world.furrow", "--polygon", SQUARE, "--depth", 1, "--dense")
        self.ok("export", "world.furrow", "--layer", "offset", "-o", "changes.tif")
        self.ok("reset", "world.furrow")
        before = path.read_bytes()
        self.run_gdal("gdal_translate", "-a_srs", "EPSG:32631", "changes.tif", "utm.tif")
        self.run_gdal("gdal_translate", "-a_ullr", 0, 64.25, 64.5, -0.25, "changes.tif", "between.tif")
        self.run_gdal("gdal_translate", "-a_ullr", 39.75, 64.25, 104.25, -0.25, "changes.tif", "beyond.tif")
        self.run_gdal("gdal_translate", "-tr", 1, 1, "changes.tif", "coarse.tif")
        self.run_gdal("gdal_translate", "-scale", 0, 1, 0, 900, "changes.tif", "high.tif")
        (self.folder / "no.tif").write_bytes(b"II*\0nothing")
        for name, why in (("utm.tif", "reference system"), ("between.tif", "not on posts"), ("beyond.tif", "the terrain goes from 0, 0 to 64, 64"),
                          ("high.tif", "700 m is the most"), ("no.tif", "no.tif"), ("changes.png", "GeoTIFF"), ("missing.tif", "missing.tif")):
            self.assertIn(why, self.refused(3, "edit", "world.furrow", "--add", name), name)
        self.assertIn("--spacing 1", self.refused(3, "edit", "world.furrow", "--add", "coarse.tif", "--spacing", 0.5))
        self.assertEqual(path.read_bytes(), before)

    def test_a_finer_raster_sets_the_spacing(self):
        self.plain("fine.furrow", spacing=0.25)
        self.ok("edit", "fine.furrow", "--polygon", "POLYGON ((5 5, 8 5, 8 8, 5 8))", "--depth", 0.5, "--dense")
        self.ok("export", "fine.furrow", "--layer", "offset", "-o", "fine.tif")
        self.plain()
        told = self.furrow("edit", "world.furrow", "--add", "fine.tif", "--dense", "--json")
        self.assertEqual(json.loads(told.stdout)["spacing"], 0.25)
        self.assertIn("posts 0.25 m apart from now on", told.stderr)
        self.assertIn("0.25 m", self.refused(3, "edit", "world.furrow", "--polygon", SQUARE, "--volume", 1, "--spacing", 0.5))


class Refusals(Edit):
    def test_what_is_wrong_is_told_and_nothing_changes(self):
        path = self.plain()
        before = path.read_bytes()
        (self.folder / "two.json").write_text('{"type": "MultiPolygon", "coordinates": []}')
        (self.folder / "text.json").write_text('{"type": "Polygon", "coordinates": [[["x", 1], [2, 2], [3, 1]]]}')
        (self.folder / "bad.json").write_text("{")
        usage = ([], ["--add", "a.tif", "--polygon", SQUARE], ["--polygon", SQUARE], ["--polygon", SQUARE, "--volume", 1, "--depth", 1], ["--add", "a.tif", "--volume", 1],
                 ["--polygon", SQUARE, "--volume", "x"], ["--polygon", SQUARE, "--volume", 1, "--dense", "--loose"],
                 ["--polygon", SQUARE, "--volume", 1, "--scene", "s.yaml", "--soil", "dry_sand"])
        for arguments in usage:
            self.refused(2, "edit", "world.furrow", *arguments)
        for polygon, why in (("POLYGON ((1 1, 2 2))", "three corners"), ("POLYGON ((1 1, 2 x, 3 3))", "two numbers"), ("POLYGON (1 1, 2 2)", "ring"),
                             ("POLYGON ((1 1, 9 1, 9 9), (2 2, 3 2, 3 3))", "hole"), ("POLYGON ((1 1, 9 1, 9 9)) x", "more than"), ("POLYGON ((1 1, 9 1, 9 9", "no end"),
                             ("POLYGON ((1 1, 9 1, 99 9))", "off the terrain"), ("POLYGON ((1.1 1.1, 1.2 1.1, 1.2 1.2))", "no post"),
                             ("POLYGON ((1 1, inf 1, 9 9))", "xy[1]"), ("nothing.wkt", "nothing.wkt"), ("two.json", "no Polygon"), ("text.json", "two numbers"),
                             ("bad.json", "neither WKT")):
            status = 2 if "inf" in polygon else 3
            self.assertIn(why, self.refused(status, "edit", "world.furrow", "--polygon", polygon, "--volume", 1), polygon)
        for arguments, why in ((["--volume", 1e9], "2048 m"), (["--depth", 701], "700 m is the most"), (["--volume", 1e-12], "no post would change"),
                               (["--volume", 1, "--soil", "cheese"], "cheese")):
            self.assertIn(why, self.refused(3, "edit", "world.furrow", "--polygon", SQUARE, *arguments))
        whole = "POLYGON ((0 0, 64 0, 64 64, 0 64))"
        self.assertIn("pour one part after the other", self.refused(3, "edit", "world.furrow", "--polygon", whole, "--volume", 1, "--spacing", 0.002))
        self.refused(3, "edit", "missing.furrow", "--polygon", SQUARE, "--volume", 1)
        self.assertEqual(path.read_bytes(), before)
        self.refused(3, "edit", "world.furrow", "--polygon", SQUARE, "--volume", 1, "--snapshot", "1")  # no name
        self.assertEqual(self.json("info", "world.furrow")["added"], 0)

    def test_holes_are_refused(self):
        from furrow_test import write_png16
        write_png16(self.folder / "holed.png", 65, 65, lambda x, y: 0 if 20 < x < 24 and 40 < y < 44 else 500)
        self.ok("import", "holed.png", "-o", "holed.furrow", "--nodata", 0)
        self.assertIn("hole", self.refused(3, "edit", "holed.furrow", "--polygon", "POLYGON ((15 15, 30 15, 30 30, 15 30))", "--volume", 1))
        self.ok("edit", "holed.furrow", "--polygon", "POLYGON ((30 30, 40 30, 40 40, 30 40))", "--volume", 1)


if __name__ == "__main__":
    main()
