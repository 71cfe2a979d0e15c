"""A soil over another, by the command: thickness by number, by class and by raster. Bounds are the two soils to the bit, rigid ground stops what
sinks, and what a drive wrote and told has the layer."""
import csv
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main, write_png16
from soil_map import POSTS, halves, rough
import soil_map
import soil_rasters

SCENE = soil_rasters.SCENE

WHEEL = """scene: 1
time_step: 0.02
end_time: 1
soil: {soil}
redistribute: {{model: scm}}
output: {{forces: 20}}
objects:
- {{name: wheel, shape: {{wheel: {{radius: 0.3, width: 0.2}}}}, path: {{points: [[3, 8], [6, 9]], speed: 2}}, load: 600, slip: 0.2}}
"""


def unnamed(rows):
    """Rows of forces without the soil's name: a layer has that of its upper soil."""
    return [{key: value for key, value in row.items() if key != "soil"} for row in rows]


class Layers(FurrowTest):
    imported, png, driven = soil_rasters.SoilRasters.imported, soil_rasters.SoilRasters.png, soil_rasters.SoilRasters.driven

    def setUp(self):
        super().setUp()
        write_png16(self.folder / "hills.png", POSTS, POSTS, rough)
        self.imported("hills.furrow", soil_rasters.CELLS)

    def test_a_raster_of_thickness_gives_each_half_its_soil(self):
        """0 is the lower soil, 1000 the upper one, both to the last digit. What is laid goes by the upper one, so nothing is."""
        self.png("t.png", 0, 1000)
        store, forces, report = self.driven("{name: snow_us, thickness: 0.2, over: dry_sand, rasters: {thickness: t.png}}", model="scm, bulldozing: 0, slip_sinkage: 0, faces: off")
        self.assertEqual(report["rasters"]["thickness"]["high"], 1000)
        found = halves(store)
        for half, (soil, name) in enumerate((("dry_sand", "west"), ("snow_us", "east"))):
            store, alone, _ = self.driven(f"{{name: {soil}}}", model="scm, bulldozing: 0, slip_sinkage: 0, faces: off")
            self.assertGreater(len(forces[name]), 10)
            self.assertEqual(unnamed(forces[name]), unnamed(alone[name]))
            self.assertTrue(len(found[half]) > 3 and found[half] == halves(store)[half])
            self.assertNotEqual(unnamed(forces[("east", "west")[half]]), unnamed(alone[("east", "west")[half]]))

    def test_dense_ground_sinks_less_by_number_class_and_raster(self):
        """A raster of compaction: each half is the soil of that number, to the last digit."""
        self.png("c.png", 0, 1)
        self.png("m.png", 1, 2)
        harder = "scm, bulldozing: 0, slip_sinkage: 0, hardening: 1"
        _, rasters, _ = self.driven("{name: dry_sand, rasters: {compaction: c.png}}", model=harder)
        _, classes, _ = self.driven("{map: m.png, classes: {1: dry_sand, 2: {name: dry_sand, compaction: 1}}, default: dry_sand}", model=harder)
        alone = {number: self.driven(f"{{name: dry_sand, compaction: {number}}}", model=harder)[1] for number in (0, 1)}
        for name, number in (("west", 0), ("east", 1)):
            self.assertGreater(len(rasters[name]), 10)
            self.assertEqual(unnamed(rasters[name]), unnamed(alone[number][name]))
            self.assertEqual(unnamed(classes[name]), unnamed(alone[number][name]))
        mean = [sum(float(row["sinkage"]) for row in alone[number]["east"]) / len(alone[number]["east"]) for number in (0, 1)]
        self.assertLess(mean[1], 0.8 * mean[0])

    def test_query_and_export_tell_what_lies_loose_and_how_dense_it_is(self):
        self.flat("{name: dry_sand}", "--set", "redistribute.loosening=0.3", "--set", "redistribute.hardening=1", "--set", "spacing=0.0625")
        points = [self.json("query", "rut.furrow", repr(4 + 0.95 * t), repr(8 + 1 / 3 + 0.3 * t + side))["soil"] for t in (0, 0.3, 0.6) for side in (0, 0.14)]
        self.assertEqual({point["density"] for point in points[::2]}, {0.5})
        self.assertTrue(all(point["loose"] >= 0 for point in points) and max(point["loose"] for point in points) > 1e-4, points)
        for layer in ("loose", "density"):
            self.ok("export", "rut.furrow", "-o", f"{layer}.tif", "--layer", layer)
            self.assertIn("write it as .tif", self.furrow("export", "rut.furrow", "-o", "a.png", "--layer", layer).stderr)

    def test_no_thickness_and_an_endless_one_are_the_two_soils(self):
        for thickness, soil in ((0, "clayey_38"), (1000, "snow_us")):
            store, layered, _ = self.driven(f"{{name: snow_us, thickness: {thickness}, over: clayey_38}}")
            found = halves(store)
            store, alone, _ = self.driven(f"{{name: {soil}}}")
            self.assertTrue(found == halves(store))
            self.assertEqual({name: unnamed(rows) for name, rows in layered.items()}, {name: unnamed(rows) for name, rows in alone.items()})

    def test_classes_have_layers_of_their_own(self):
        self.png("m.png", 1, 2)
        store, forces, report = self.driven("{map: m.png, classes: {1: {name: snow_us, thickness: 0.1, over: rigid}, 2: {name: lunar, thickness: 0.05, over: heavy_clay_25}}, default: lunar}")
        self.assertEqual([soil.get("thickness") for soil in report["soils"]], [None, 0.1, 0.05])
        self.assertEqual([soil.get("over", {}).get("name") for soil in report["soils"]], [None, "rigid", "heavy_clay_25"])
        self.assertEqual(report["soils"][2]["over"]["bekker_n"], 0.13)
        for name, soil in (("west", "{name: snow_us, thickness: 0.1, over: rigid}"), ("east", "{name: lunar, thickness: 0.05, over: heavy_clay_25}")):
            _, alone, _ = self.driven(soil)
            self.assertEqual(forces[name], alone[name])

    def flat(self, soil, *options):
        if not (self.folder / "flat.furrow").exists():
            self.synth("flat.furrow", posts="65x65", spacing=0.25, kind="plain", relief=0.001)
        shutil.copy(self.folder / "flat.furrow", self.folder / "rut.furrow")
        self.drive(self.scene(WHEEL.format(soil=soil)), "--store", "rut.furrow", *options)
        with open(self.folder / "out/objects.csv", newline="") as file:
            return max(float(row["sinkage"]) for row in csv.DictReader(file))

    def test_a_wheel_stops_above_rigid_ground(self):
        for spacing in (0.0625, 0.03125):
            deep = self.flat("{name: snow_us}", "--set", f"spacing={spacing}")
            shallow = self.flat("{name: snow_us, thickness: 0.1, over: rigid}", "--set", f"spacing={spacing}")
            self.assertGreater(deep, 0.12)
            self.assertLess(shallow, 0.1)

    def test_a_resume_insists_on_the_layer(self):
        scene = self.scene(SCENE.format(model="scm", soil="{name: snow_us, thickness: 0.1, over: rigid}"))
        shutil.copy(self.folder / "hills.furrow", self.folder / "driven.furrow")
        self.ok("drive", scene, "--store", "driven.furrow", "-o", "out", "--steps", "20")
        for change in ("soil.thickness=0.2", "soil.over=dry_sand"):
            result = self.furrow("drive", scene, "--store", "driven.furrow", "-o", "out", "--resume", "--set", change)
            self.assertNotEqual(result.returncode, 0, change)
        self.ok("drive", scene, "--store", "driven.furrow", "-o", "out", "--resume")

    def test_explain_tells_the_layer(self):
        scene = self.scene(SCENE.format(model="scm", soil="{name: snow_us, thickness: 0.1, over: heavy_clay_25}"))
        text = self.ok("explain", scene, "--store", "hills.furrow")
        self.assertIn("snow_us, 0.1 m over heavy_clay_25:", text)
        soil = self.json("explain", scene, "--store", "hills.furrow")["soils"][0]
        self.assertEqual((soil["thickness"], soil["over"]["name"], soil["over"]["cohesion"]), (0.1, "heavy_clay_25", 68950))

    def test_what_is_wrong_is_told(self):
        for soil, why in (("{name: snow_us, thickness: 0.1}", "soil.thickness: is of a layer, and nothing lies below it"),
                          ("{name: snow_us, over: rigid}", "soil.over: lies below a layer whose thickness is not given"),
                          ("{name: snow_us, thickness: -1, over: rigid}", "soil.thickness: -1"),
                          ("{name: snow_us, thickness: 0.1, over: {name: rigid, cohesion: 5}}", "soil.over.cohesion: is of soil, and rigid ground has no numbers"),
                          ("{name: snow_us, thickness: 0.1, over: granite}", "soil.over.name: \"granite\" is unknown"),
                          ("{name: snow_us, thickness: 0.1, over: {name: dry_sand, thickness: 1}}", "soil.over.thickness: unknown key"),
                          ("{name: rigid}", "soil.name: \"rigid\" is unknown"),
                          ("{name: snow_us, layers: 2}", "soil.layers: unknown key; a soil that ends somewhere has a thickness"),
                          ("{name: snow_us, rasters: {thickness: t.png}}", "soil.rasters.thickness: is of a layer, and no soil lies over another")):
            result = self.furrow("explain", self.scene(SCENE.format(model="scm", soil=soil)), "--store", "hills.furrow")
            self.assertNotEqual(result.returncode, 0, soil)
            self.assertIn(why, result.stderr, soil)
        deep = SCENE.format(model="scm, depth: 0.2", soil="{name: snow_us, thickness: 0.1, over: rigid}")
        self.assertIn("redistribute.depth: is how deep soil slides, and rigid ground begins at 0.1 m", self.furrow("explain", self.scene(deep), "--store", "hills.furrow").stderr)
        slides = soil_map.SCENE.format(model="slippage", soil="{name: snow_us, thickness: 0.1, over: rigid}")
        self.assertIn("model slippage knows one soil from the surface down", self.furrow("explain", self.scene(slides), "--store", "hills.furrow").stderr)


if __name__ == "__main__":
    main()
