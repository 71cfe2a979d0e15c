"""Drives with numbers of the soil from rasters. Each half of the world equals that of a drive with this half's numbers alone, with any
slots and tiles. A raster that cannot be used ends the drive before it begins, with one line."""
import csv
import pathlib
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, has_gdal, long, main, part, write_png16
from soil_map import BORDER, POSTS, SCENE, halves, rough, tiles
import rasters

CELLS = 64
SCENE = SCENE.replace("sink: 0.25", "load: 9000, slip: 0.2").replace("sink: 0.3", "sink: 0.1").replace("objects:", "output: {{forces: 20}}\nobjects:")


def beside(**paths):
    return "{name: dry_sand, rasters: {" + ", ".join(f"{key}: {path}" for key, path in paths.items()) + "}}"


def own(**numbers):
    return "{name: dry_sand, " + ", ".join(f"{key}: {number}" for key, number in numbers.items()) + "}"


class SoilRasters(FurrowTest):
    def setUp(self):
        super().setUp()
        write_png16(self.folder / "hills.png", POSTS, POSTS, rough)
        self.imported("hills.furrow", CELLS)

    def imported(self, name, cells):
        self.ok("import", "hills.png", "-o", name, "--tile", cells, "--height-range", "0,655.35")

    def png(self, name, west, east):
        write_png16(self.folder / name, POSTS, POSTS, lambda x, y: west if x < BORDER else east)
        return name

    def driven(self, soil, *options, base="hills.furrow", model="scm"):
        """The store that such a drive leaves, its rows of forces by object, and its run.json."""
        store = self.folder / "driven.furrow"
        shutil.copy(self.folder / base, store)
        report = self.drive(self.scene(SCENE.format(model=model, soil=soil)), "--store", store, *options)
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        rows = {}
        with open(self.folder / "out/objects.csv", newline="") as file:
            for row in csv.DictReader(file):
                rows.setdefault(row["name"], []).append(row)
        return store, rows, report

    def assert_near(self, found, expected, what):
        """The driver computes the tangent of an angle, so forces may differ a little."""
        self.assertEqual(len(found), len(expected))
        for row, other in zip(found, expected):
            for column in ("fx", "fz", "tx", "z"):
                a, b = float(row[column]), float(other[column])
                self.assertLessEqual(abs(a - b), 1e-4 * max(abs(b), 1), (what, column))

    def test_each_half_is_that_of_its_numbers_alone(self):
        self.png("c.png", 0, 5000)
        store, forces, report = self.driven(beside(cohesion="c.png"))
        found = halves(store)
        self.assertEqual(report["rasters"], {"cohesion": {"file": str(self.folder / "c.png"), "low": 0, "high": 5000, "step": 5000 / 254}})
        for half, cohesion in enumerate((0, 5000)):
            store, alone, report = self.driven(own(cohesion=cohesion))
            self.assertNotIn("numbers", report["memory"]["plane_bytes"])  # law 7
            self.assertNotIn("rasters", report)
            of_alone = halves(store)
            self.assertGreater(len(found[half]), 5)
            self.assertTrue(found[half] == of_alone[half])
            name, other = ("west", "east")[half], ("east", "west")[half]
            self.assertGreater(len(forces[name]), 10)
            self.assertEqual(forces[name], alone[name])  # to the last digit
            # Worth something only if the other number shows.
            self.assertNotEqual(forces[other], alone[other])

    def test_every_number_may_come_from_a_raster(self):
        halves_of = {"bekker_kc": (500, 4000), "bekker_kphi": (900000, 3000000), "bekker_n": (1, 2), "friction_angle": (20, 35),
                     "janosi_shear": (1, 3), "elastic_stiffness": (2 * 10 ** 4, 6 * 10 ** 4)}
        _, plain, _ = self.driven("{name: dry_sand}", "--set", "end_time=1")
        for key, (west, east) in part(halves_of.items(), 0, 2, 3):
            if max(west, east) > 65535:
                if not has_gdal():
                    continue
                values = [west if x < BORDER else east for y in range(POSTS) for x in range(POSTS)]
                rasters.make(self.folder / "n.tif", POSTS, POSTS, values, "f", west=-0.5, north=POSTS - 0.5, step=1, srs=None)
                path = "n.tif"
            else:
                path = self.png("n.png", west, east)
            _, found, _ = self.driven(beside(**{key: path}), "--set", "end_time=1")
            for name, number in (("west", west), ("east", east)):
                _, alone, _ = self.driven(own(**{key: number}), "--set", "end_time=1")
                self.assertGreater(len(found[name]), 5)
                self.assertNotEqual(alone[name], plain[name], key)
                self.assert_near(found[name], alone[name], key)

    @long
    def test_four_rasters_are_each_for_its_number(self):
        halves_of = {"bekker_kc": (500, 4000), "cohesion": (200, 5000), "friction_angle": (20, 35), "janosi_shear": (1, 3)}
        soil = beside(**{key: self.png(key + ".png", west, east) for key, (west, east) in halves_of.items()})
        _, found, report = self.driven(soil, "--set", "end_time=1")
        self.assertEqual(list(report["rasters"]), list(halves_of))
        for half, name in enumerate(("west", "east")):
            _, alone, _ = self.driven(own(**{key: values[half] for key, values in halves_of.items()}), "--set", "end_time=1")
            self.assertGreater(len(found[name]), 5)
            self.assert_near(found[name], alone[name], name)

    @long
    def test_tiles_slots_and_loaders_change_no_bit(self):
        write_png16(self.folder / "c.png", POSTS, POSTS, lambda x, y: (x * 37 + y * 101) % 4000)
        write_png16(self.folder / "phi.png", POSTS, POSTS, lambda x, y: 20 + (x + y) % 15)
        soil = beside(cohesion="c.png", friction_angle="phi.png")
        store, forces, report = self.driven(soil, "--set", "cache.slots=512")
        self.assertEqual(report["cache"]["evictions"], 0)
        self.assertGreater(report["memory"]["plane_bytes"]["numbers"], 0)
        wanted, volume = tiles(store), report["volume"]["quanta"]
        for loaders in (0, 2):
            store, again, report = self.driven(soil, "--set", "cache.slots=4", "--set", f"cache.loaders={loaders}")
            self.assertGreater(report["cache"]["evictions"], 20)
            self.assertTrue(tiles(store) == wanted, f"{loaders} loaders: other rows")
            self.assertEqual(again, forces)
        self.imported("small.furrow", 32)
        store, again, report = self.driven(soil, "--set", "cache.slots=64", base="small.furrow")
        self.assertEqual(again, forces)
        self.assertEqual(report["volume"]["quanta"], volume)

    def test_a_raster_goes_with_a_map_and_its_value_counts(self):
        self.png("map.png", 1, 2)
        self.png("c.png", 300, 300)
        classes = "{map: map.png, classes: {1: dry_sand}, default: lete_sand"
        _, found, _ = self.driven(classes + ", rasters: {cohesion: c.png}}")
        _, alone, _ = self.driven(own(cohesion=300))
        self.assertEqual([{**row, "soil": ""} for row in found["west"]], [{**row, "soil": ""} for row in alone["west"]])
        self.assertEqual({row["soil"] for row in found["east"]}, {"lete_sand"})
        _, alone, _ = self.driven("{name: lete_sand, cohesion: 300}")
        self.assertEqual(found["east"], alone["east"])

    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_without_a_value_the_soils_own_number_counts(self):
        # Nodata in the east half, and nothing north of y = 40.
        values = [-1 if x >= BORDER else 3000 for y in range(41) for x in range(POSTS)]
        rasters.make(self.folder / "c.tif", POSTS, 41, values, "f", west=-0.5, north=40.5, step=1, srs=None, nodata=-1)
        _, found, _ = self.driven(beside(cohesion="c.tif"), "--set", "end_time=4")
        _, plain, _ = self.driven("{name: dry_sand}", "--set", "end_time=4")
        _, alone, _ = self.driven(own(cohesion=3000), "--set", "end_time=4")
        self.assertEqual(found["east"], plain["east"])
        south = [i for i, row in enumerate(found["west"]) if float(row["y"]) < 38]
        self.assertGreater(len(south), 5)
        for i in south:
            self.assertEqual(found["west"][i], alone["west"][i])
        self.assertNotEqual(found["west"], plain["west"])
        self.assertNotEqual(found["west"], alone["west"])

    def test_explain_tells_how_finely_numbers_are_kept(self):
        write_png16(self.folder / "c.png", POSTS, POSTS, lambda x, y: 200 + 20 * ((x + y) % 255))
        scene = self.scene(SCENE.format(model="scm", soil=beside(cohesion="c.png")))
        text = self.ok("explain", scene, "--store", "hills.furrow")
        self.assertIn("cohesion          200 to 5280 Pa in steps of 20", text)
        told = self.json("explain", scene, "--store", "hills.furrow")["rasters"]
        self.assertEqual(told, [{"number": "cohesion", "file": str(self.folder / "c.png"), "unit": "Pa", "range": [200, 5280], "step": 20, "share": 1}])
        self.assertEqual(self.json("explain", scene)["rasters"], [])  # over no store

    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_the_longest_step_counts_the_stiffest_post(self):
        car = pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml"
        text = ("scene: 1\ntime_step: 0.002\nend_time: 0.01\nspacing: 0.25\nsoil: %s\nredistribute: {model: scm}\n"
                f"vehicles: [{{name: v, model: {car}, start: {{at: [20, 20]}}, driver: {{hold: {{drive: 0}}}}}}]\n")

        def longest(soil, *store):
            return self.json("explain", self.scene(text % soil), *store)["vehicles"]["v"]["largest_step"]
        for name, most in (("soft", 1e6), ("hard", 9e8), ("rock", 9e9)):
            values = [most if (x, y) == (9, 7) else 1e6 for y in range(POSTS) for x in range(POSTS)]
            rasters.make(self.folder / f"{name}.tif", POSTS, POSTS, values, "f", west=-0.5, north=POSTS - 0.5, step=1, srs=None)
        store = "--store", "hills.furrow"
        if "this build has no MuJoCo" in self.furrow("explain", self.scene(text % "{name: dry_sand}"), *store).stderr:
            self.skipTest("this build has no MuJoCo")
        plain = longest("{name: dry_sand}", *store)
        self.assertEqual(longest(beside(elastic_stiffness="soft.tif"), *store), plain)
        self.assertAlmostEqual(longest(beside(elastic_stiffness="hard.tif"), *store), longest(own(elastic_stiffness=9e8)), delta=1e-9)
        self.assertEqual(longest(beside(elastic_stiffness="rock.tif")), plain)  # over no store
        why = "; soil.rasters.elastic_stiffness has at most 9e+09 Pa/m); give at most that"
        scene = self.scene(text % beside(elastic_stiffness="rock.tif"))
        self.assertIn(why, self.refused(3, "explain", scene, *store))
        self.assertIn(why, self.refused(3, "drive", scene, *store, "-o", "refused"))
        self.assertFalse((self.folder / "refused").exists())

    def test_a_raster_beside_the_paths_is_told(self):
        write_png16(self.folder / "corner.png", 9, 9, lambda x, y: 500)  # the north-west of the terrain alone
        scene = self.scene(SCENE.format(model="scm", soil=beside(cohesion="corner.png")))
        told = self.json("explain", scene, "--store", "hills.furrow")
        self.assertEqual(told["rasters"][0]["share"], 0)
        notes = [note for note in told["notes"] if note.startswith("soil.rasters")]
        self.assertEqual(notes, [f"soil.rasters.cohesion: {self.folder / 'corner.png'} covers 0 % of the paths of objects and vehicles: the soil's own number counts "
                                 "there; look at its place and its reference system (gdalinfo): without one it is in metres from the south-west post"])

    def test_a_raster_in_a_wrong_unit_is_told(self):
        self.png("one.png", 0, 1)
        self.png("right.png", 20, 200)
        self.png("shear.png", 1, 3)
        for rasters_of, notes in (({"friction_angle": "one.png"}, "soil.rasters.friction_angle: {} has at most 1 degrees, which is less than soils have, "
                                                                  "and probably in radians; give degrees"),
                                  ({"cohesion": "one.png"}, "soil.rasters.cohesion: {} has at most 1 Pa, which is less than soils have, and probably "
                                                            "in kPa; give Pa"),
                                  ({"bekker_kphi": "one.png", "bekker_kc": "right.png"}, "soil.rasters.bekker_kphi: {} has at most 1 N/m^(n+2), which is less than soils "
                                                                                         "have, and probably in kN/m^(n+2); give N/m^(n+2)"),
                                  ({"janosi_shear": "shear.png"}, "soil.rasters.janosi_shear: {} has at least 1 m, which is more than soils have, and probably "
                                                                  "in cm or mm; give m"),
                                  ({"cohesion": "right.png", "bekker_n": "right_n.png"}, None)):
            write_png16(self.folder / "right_n.png", POSTS, POSTS, lambda x, y: 1)
            scene = self.scene(SCENE.format(model="scm", soil=beside(**rasters_of)))
            told = [note for note in self.json("explain", scene, "--store", "hills.furrow")["notes"] if note.startswith("soil.rasters")]
            self.assertEqual(told, [notes.format(self.folder / rasters_of.get("janosi_shear", "one.png"))] if notes else [])

    @long
    def test_a_changed_raster_is_another_scene(self):
        self.png("c.png", 100, 2000)
        scene = self.scene(SCENE.format(model="scm", soil=beside(cohesion="c.png")))
        report = self.drive(scene, "--store", "hills.furrow", "--steps", 5)
        self.assertEqual(report["steps"], 5)
        whole = (self.folder / "c.png").read_bytes()
        self.png("c.png", 100, 2001)
        self.refused(3, "drive", scene, "--store", "hills.furrow", "-o", "out", "--resume")
        (self.folder / "c.png").write_bytes(whole)
        report = self.drive(scene, "--store", "hills.furrow", "--resume", "--steps", 5)
        self.assertEqual(report["resumed_from"], 5)

    def refused_with(self, soil, *says, model="scm"):
        store = self.folder / "driven.furrow"
        shutil.copy(self.folder / "hills.furrow", store)
        text = SCENE.format(model=model, soil=soil)
        if model != "scm":
            text = text.replace("output: {forces: 20}\n", "").replace("load: 9000, slip: 0.2", "sink: 0.1")
        scene = self.scene(text)
        for arguments in (("explain", scene, "--store", store), ("drive", scene, "--store", store, "-o", "out")):
            error = self.refused(3, *arguments)
            for text in says:
                self.assertIn(text, error)
        self.assertIsNone(self.json("info", store)["last_run"])

    def test_what_cannot_be_used_is_refused_before_anything_is_driven(self):
        self.png("c.png", 100, 2000)
        (self.folder / "short.png").write_bytes((self.folder / "c.png").read_bytes()[:100])
        (self.folder / "text.png").write_text("cohesion 1")
        for path in ("absent.png", "short.png", "text.png"):
            self.refused_with(beside(cohesion=path), path)
        write_png16(self.folder / "steep.png", POSTS, POSTS, lambda x, y: 95 if (x, y) == (7, 3) else 30)
        self.refused_with(beside(friction_angle="steep.png"),
                          "steep.png: column 7, row 3: friction_angle 95 degrees is out of range; allowed: 0 to 89")
        self.png("zero.png", 0, 1)
        self.refused_with(beside(bekker_n="zero.png"), "zero.png: column 0, row 0: bekker_n 0 is out of range; allowed: above 0 to 3")
        self.refused_with("{name: dry_sand, bekker_kc: 0, rasters: {bekker_kphi: zero.png}}",
                          "soil.rasters: bekker_kc / b + bekker_kphi is as low as 0 under west")
        self.refused_with(beside(cohesion="c.png"), "soil.rasters: model slippage reads a soil's numbers by class alone; allowed with: scm",
                          model="slippage")

    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_geotiffs_that_cannot_be_used_are_refused(self):
        place = {"west": -0.5, "north": POSTS - 0.5, "step": 1, "srs": None}
        rasters.make(self.folder / "cut.tif", POSTS, POSTS, [float(i) for i in range(POSTS ** 2)], "f", **place)
        whole = (self.folder / "cut.tif").read_bytes()
        (self.folder / "cut.tif").write_bytes(whole[:len(whole) * 2 // 3])
        self.refused_with(beside(cohesion="cut.tif"), "cut.tif: reading it failed")
        rasters.make(self.folder / "none.tif", POSTS, POSTS, [-9.0] * POSTS ** 2, "f", nodata=-9, **place)
        self.refused_with(beside(cohesion="none.tif"), "none.tif: has no value, all is nodata")
        rasters.make(self.folder / "untold.tif", POSTS, POSTS, [-9999.0] * POSTS ** 2, "f", **place)
        self.refused_with(beside(cohesion="untold.tif"), "column 0, row 0: cohesion -9999 Pa is out of range; allowed: 0 to 1000000000")


if __name__ == "__main__":
    main()
