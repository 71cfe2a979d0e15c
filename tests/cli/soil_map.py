"""A map of two soils, driven: each half is that of a drive with its soil alone, whatever is resident; and a map that
is no map ends the drive with one line."""
import json
import pathlib
import sqlite3
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, has_gdal, long, main, part, write_png16
import rasters

POSTS = 129  # a metre apart
BORDER = 64  # metres: class 1 west of it, class 2 east
CELLS = 64   # 16 m a tile at 0.25 m
AWAY = 12    # metres on either side of the border: what happens there may have come from beyond it
# Two that differ under each model, also in the angle and the share of soil that is laid.
SOILS = {
    "sumner": ("{name: sand, theta_out: 25, compression: 0.3}", "{name: mud, theta_out: 20, compression: 0.5}"),
    "slippage": ("{name: dry_sand, cohesion: 100}", "{name: clayey_38, friction_angle: 20}"),
    "scm": ("dry_sand", "{name: sandy_loam_15, repose: 20, elastic_stiffness: 4000000}"),
}
SCENE = """scene: 1
time_step: 0.05
end_time: 3
spacing: 0.25
redistribute: {{model: {model}}}
soil: {soil}
objects:
  - {{name: west, shape: {{wheel: {{radius: 0.8, width: 0.7}}}}, sink: 0.25,
     path: {{points: [[12, 20], [40, 60], [20, 90]], speed: 30}}}}
  - {{name: across, shape: {{sphere: {{radius: 1.2}}}}, sink: 0.3, path: {{points: [[60, 30], [68, 40]], speed: 10}}}}
  - {{name: east, shape: {{wheel: {{radius: 0.8, width: 0.7}}}}, sink: 0.25,
     path: {{points: [[88, 20], [116, 60], [96, 90]], speed: 30}}}}
"""


def rough(x, y):
    """Returns a height in centimetres. No slope is steep enough to slide."""
    return 10000 + (x * 7 + y * 3) % 11


def one(soil):
    return soil if soil.startswith("{") else f"{{name: {soil}}}"


def tiles(store, level=-2):
    """Each tile's rows, but for which epoch wrote them: {(x, y): {table: row}}"""
    db = sqlite3.connect(store)
    found = {}
    for table in ("offset", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density"):
        for key, *row in db.execute(f'SELECT key, low, high, codec, hash, blob FROM "{table}"'):
            if (key >> 56) - 32 != level:
                continue
            x = sum((key >> 2 * bit & 1) << bit for bit in range(28))
            y = sum((key >> 2 * bit + 1 & 1) << bit for bit in range(28))
            found.setdefault((x, y), {})[table] = row
    db.close()
    return found


def halves(store):
    """The tiles well to the west of the border, and those well to the east of it."""
    side = CELLS * 0.25
    found = tiles(store)
    return ({at: rows for at, rows in found.items() if (at[0] + 1) * side <= BORDER - AWAY},
            {at: rows for at, rows in found.items() if at[0] * side >= BORDER + AWAY})


class SoilMap(FurrowTest):
    def setUp(self):
        super().setUp()
        write_png16(self.folder / "hills.png", POSTS, POSTS, rough)
        self.ok("import", "hills.png", "-o", "hills.furrow", "--tile", CELLS, "--height-range", "0,655.35")
        write_png16(self.folder / "map.png", POSTS, POSTS, lambda x, y: 1 if x < BORDER else 2)

    def driven(self, model, soil, base="hills.furrow", options=(), scene=SCENE):
        """The store that such a drive leaves, and its run.json."""
        store = self.folder / "driven.furrow"
        store.write_bytes((self.folder / base).read_bytes())
        scene = self.scene(scene.format(model=model, soil=soil))
        report = self.drive(scene, "--store", store, *options)
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["offset_sum"]["-2"] + report["volume"]["quanta"]["compacted"], 0)
        return store, report

    def check_halves(self, model, mapped, base="hills.furrow"):
        """Of a store driven with a map."""
        found, alone = halves(mapped), []
        for soil in SOILS[model]:
            store, report = self.driven(model, one(soil), base)
            alone.append(halves(store))
            self.assertNotIn("classes", report["memory"]["plane_bytes"])  # law 7
        for half in (0, 1):
            self.assertGreater(len(found[half]), 5)
            self.assertTrue(found[half] == alone[half][half], f"{model}: the {'west east'.split()[half]} is not that of its soil")
            # Worth something only if the other soil shows.
            self.assertFalse(found[half] == alone[1 - half][half], model)

    def mapped(self, model, path="map.png"):
        return f"{{map: {path}, classes: {{1: {SOILS[model][0]}}}, default: {SOILS[model][1]}}}"

    def test_each_half_is_that_of_its_soil_alone_whatever_is_resident(self):
        for model, loader_counts in (("sumner", (0, 1)), ("slippage", (3,)), ("scm", (0, 2))):
            store, report = self.driven(model, self.mapped(model), options=("--set", "cache.slots=512"))
            self.assertEqual(report["cache"]["evictions"], 0)
            self.assertGreater(report["memory"]["plane_bytes"]["classes"], 0)
            wanted = tiles(store)
            self.check_halves(model, store)
            for loaders in part(loader_counts, 0):
                store, report = self.driven(model, self.mapped(model), options=(
                    "--set", "cache.slots=4", "--set", f"cache.loaders={loaders}", "--set", f"cache.prefetch={loaders % 2}"))
                self.assertGreater(report["cache"]["evictions"], 20)
                self.assertTrue(tiles(store) == wanted, f"{model}, {loaders} loaders: other rows")

    @long
    def test_each_window_of_a_large_object_has_its_own_soil(self):
        plate = """
  - {{name: plate, shape: {{box: {{size: [80, 6, 2]}}}}, sink: 0.1, path: {{points: [[64, 100], [64.5, 100.25]], speed: 1}}}}
"""
        scene = SCENE.split("objects:")[0] + "objects:" + plate
        # What a plate lays aside comes from all of it.
        found = [halves(self.driven("scm, bulldozing: 0, slip_sinkage: 0", soil, scene=scene)[0]) for soil in (self.mapped("scm"), *map(one, SOILS["scm"]))]
        for half in (0, 1):
            self.assertGreater(len(found[0][half]), 1)
            self.assertTrue(found[0][half] == found[1 + half][half])
        self.assertFalse(all(found[1][half] == found[2][half] for half in (0, 1)))

    def test_a_map_that_no_model_reads_costs_nothing(self):
        report = self.drive(self.scene(SCENE.format(model="box", soil=self.mapped("scm"))), "--store", "hills.furrow")
        self.assertNotIn("classes", report["memory"]["plane_bytes"])

    def told(self, soil, *options):
        """Notes on the map, and {soil: share of the paths}, before a drive."""
        plan = self.json("explain", self.scene(SCENE.format(model="scm", soil=soil)), "--store", "hills.furrow", *options)
        return ([note for note in plan["notes"] if note.startswith(("soil.map", "soil.classes"))],
                {(row["name"], row.get("class")): round(row["share"], 2) for row in plan["soils"]})

    def test_what_the_map_has_along_the_paths_is_told(self):
        both = "{map: map.png, classes: {1: dry_sand, 2: sandy_loam_15}, default: dry_sand}"
        notes, shares = self.told(both)
        self.assertEqual(notes, [])
        west, east = shares[("dry_sand", 1)], shares[("sandy_loam_15", 2)]
        self.assertAlmostEqual(west, 0.49, delta=0.03)  # 77 m of 79, and half of 13
        self.assertAlmostEqual(west + east + shares[("dry_sand", None)], 1, delta=0.011)
        west = both.replace("both", "").replace("map.png", "west.png")
        write_png16(self.folder / "west.png", POSTS, POSTS, lambda x, y: 1)
        self.assertEqual(self.told(west)[1][("dry_sand", 1)], 1)
        notes, = self.told(west)[0]
        self.assertRegex(notes, r"soil.classes: class 2 \(sandy_loam_15\) lies under no path \(\d+ places looked at\)")
        write_png16(self.folder / "west.png", POSTS, POSTS, lambda x, y: 3)
        notes = self.told(west)[0]
        self.assertEqual(notes[0], "soil.map: value 3, along 100 % of the paths, is in no class: the default soil is there, dry_sand; give a soil in soil.classes")
        write_png16(self.folder / "west.png", 9, 9, lambda x, y: 1)  # the north-west of the terrain alone
        notes, shares = self.told(west)
        self.assertEqual(shares, {("dry_sand", None): 1, ("dry_sand", 1): 0, ("sandy_loam_15", 2): 0})
        self.assertEqual(notes, [f"soil.map: {self.folder / 'west.png'} covers 0 % of the paths of objects and vehicles: all get the default soil, dry_sand; look at "
                                 "its place and its reference system (gdalinfo): without one it is in metres from the south-west post"])
        # Without a default that is refused, and so is a path of which a part has no class.
        bare = lambda path: both.replace(", default: dry_sand", "").replace("map.png", path)
        write_png16(self.folder / "part.png", 100, POSTS, lambda x, y: 1)  # no path is to the east of it all the time
        for path, says in (("west.png", r"soil.map: \S*west.png covers 0 % of the paths, and there is no soil.default; look at "),
                           ("part.png", r"soil.map: \S*part.png covers \d\d.?\d* % of the paths, and there is no soil.default; ")):
            self.scene(SCENE.format(model="scm", soil=bare(path)), "bare.yaml")
            self.assertRegex(FurrowTest.told(self, 3, self.furrow("explain", "bare.yaml", "--store", "hills.furrow")), says)
            self.assertRegex(FurrowTest.told(self, 3, self.furrow("drive", "bare.yaml", "--store", "hills.furrow", "--overlay", "a.furrow", "-o", "out")), says)
        write_png16(self.folder / "all.png", POSTS, POSTS, lambda x, y: 1 + (x > POSTS // 2))
        self.scene(SCENE.format(model="scm", soil=bare("all.png")), "bare.yaml")
        plan = self.json("explain", "bare.yaml", "--store", "hills.furrow")
        self.assertEqual(round(sum(row["share"] for row in plan["soils"] if row.get("class")), 6), 1)
        self.scene(SCENE.format(model="scm", soil=bare("all.png").replace("2: sandy_loam_15", "4: sandy_loam_15")), "bare.yaml")
        self.assertRegex(FurrowTest.told(self, 3, self.furrow("explain", "bare.yaml", "--store", "hills.furrow")),
                         r"soil.map: value 2, along \d+.?\d* % of the paths, is in no class, and there is no soil.default; give a soil in soil.classes, or soil.default")
        text = self.ok("explain", "scene.yaml", "--store", "hills.furrow")
        self.assertIn("  dry_sand (class 1 and default; 100 % of the paths): the name's", text)  # both at once
        self.assertIn("  soil.map has no value along 100 % of the paths: the default soil is there", text)
        self.assertEqual(text.count("dry_sand ("), 1)
        self.assertNotIn("GiB", text)  # nor what no drive comes near
        result = self.furrow("drive", "scene.yaml", "--store", "hills.furrow", "--overlay", "a.furrow", "-o", "out", "--steps", 1)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(json.loads((self.folder / "out/run.json").read_text())["soil_shares"], [1, 0, 0])
        self.assertIn(f"furrow: note: {notes[0].replace(f'{self.folder}/', '')}\n", result.stderr)

    def test_what_is_no_map_is_refused_before_anything_is_driven(self):
        (self.folder / "short.png").write_bytes((self.folder / "map.png").read_bytes()[:100])
        (self.folder / "text.png").write_text("class 1")
        for path in ("absent.png", "short.png", "text.png"):
            scene = self.scene(SCENE.format(model="scm", soil=self.mapped("scm", path)))
            self.driven_badly(scene, 2, path, "")
            self.assertIsNone(self.json("info", "driven.furrow")["last_run"])

    def test_a_vector_file_is_told_how_it_becomes_a_raster(self):
        for name, size in (("map.geojson", "0.00005 0.00005"), ("map.shp", "5 5")):
            (self.folder / name).write_text("polygons")
            self.driven_badly(self.scene(SCENE.format(model="scm", soil=self.mapped("scm", name))), 2, name, f"gdal_rasterize -a CLASS -ot Byte -tr {size}")

    def test_a_value_that_is_no_class_ends_the_drive_where_it_is_read(self):
        # Far from where the drive begins.
        write_png16(self.folder / "odd.png", POSTS, POSTS, lambda x, y: 300 if x > 90 and y < 40 else 1)
        for loaders in (0, 2):
            scene = self.scene(SCENE.format(model="scm", soil=self.mapped("scm", "odd.png")))
            self.driven_badly(scene, loaders, "odd.png", "its value 300 is no class")

    def driven_badly(self, scene, loaders, path, why, base="hills.furrow"):
        store = self.folder / "driven.furrow"
        store.write_bytes((self.folder / base).read_bytes())
        arguments = ("drive", scene, "--store", store, "-o", "out", "--set", "cache.slots=4", "--set", f"cache.loaders={loaders}",
                     "--set", "cache.prefetch=0")
        result = self.furrow(*arguments)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        error = super().told(3, result)
        self.assertIn(path, error)
        self.assertIn(why, error)
        self.assertTrue(self.json("verify", store)["ok"])

    @long
    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_a_map_in_degrees_over_a_store_in_metres(self):
        west, north = 500000, 5000000
        rasters.make(self.folder / "utm.tif", POSTS, POSTS, [rough(x, y) / 100 for y in range(POSTS) for x in range(POSTS)],
                     west=west, north=north, step=1)
        self.ok("import", "utm.tif", "-o", "utm.furrow", "--tile", CELLS)
        # Beyond the ground in the west, and no farther than the border in the east; then turned into degrees.
        columns, rows = BORDER + 30, POSTS + 60
        rasters.make(self.folder / "classes.tif", columns, rows, [1] * (columns * rows), "b", west=west - 30, north=north + 30, step=1)
        subprocess.run(["gdalwarp", "-q", "-t_srs", "EPSG:4326", "-r", "near", "-tr", "0.000004", "0.000004", "-dstnodata", "255",
                        "classes.tif", "degrees.tif"], cwd=self.folder, check=True, capture_output=True)
        store, _ = self.driven("scm", self.mapped("scm", "degrees.tif"), "utm.furrow",
                               ("--set", "cache.slots=64", "--set", "cache.loaders=2"))  # each load transforms every post
        self.check_halves("scm", store, "utm.furrow")

    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_a_map_of_fractions_is_refused_and_a_truncated_one_ends_the_drive(self):
        rasters.make(self.folder / "real.tif", POSTS, POSTS, [1.0] * POSTS ** 2, "f", west=0, north=POSTS, step=1, srs=None)
        rasters.make(self.folder / "cut.tif", POSTS, POSTS, [1] * POSTS ** 2, "b", west=0, north=POSTS, step=1, srs=None)
        scene = self.scene(SCENE.format(model="scm", soil=self.mapped("scm", "real.tif")))
        self.driven_badly(scene, 2, "real.tif", "whole numbers")
        whole = (self.folder / "cut.tif").read_bytes()
        # Its first rows, of the north, are there; the drive begins in the south.
        (self.folder / "cut.tif").write_bytes(whole[:len(whole) * 2 // 3])
        scene = self.scene(SCENE.format(model="scm", soil=self.mapped("scm", "cut.tif")))
        for loaders in (0, 2):
            self.driven_badly(scene, loaders, "cut.tif", "reading it failed")


if __name__ == "__main__":
    main()
