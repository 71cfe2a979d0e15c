"""Roads: which posts lie on them, beside distances computed here; hard ground under wheels; what is refused and told."""
import json
import math
import subprocess

import numpy as np

from furrow_test import FurrowTest, has_gdal, main, use_package

SCENE = """scene: 1
time_step: 0.02
end_time: 4
spacing: 0.25
soil: {name: dry_sand}
ground: {roads: [%s]}
redistribute: {model: %s}
output: {forces: 50}
objects:
  - {name: wheel, shape: {wheel: {radius: 0.4, width: 0.3}}, load: 2000, slip: 0.2, path: {points: [[20, 40], [60, 40]], speed: 10}}
"""
CROSSING = "{points: [[40, 20], [40, 60]], width: 6, soil: asphalt}"


def distance(x, y, line):
    """From each place to a line of points, m."""
    least = np.full(np.shape(x), np.inf)
    for (ax, ay), (bx, by) in zip(line, line[1:]):
        length2 = (bx - ax) ** 2 + (by - ay) ** 2
        share = np.clip(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length2, 0, 1)
        least = np.minimum(least, np.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay)))
    return least


class Roads(FurrowTest):
    def setUp(self):
        super().setUp()
        self.ok("synth", "-o", "level.furrow", "--kind", "plain", "--relief", "0", "--posts", "257x257", "--spacing", "0.5")

    def drive(self, roads, model="scm", status=0, name="out"):
        text = SCENE % (roads, model)
        self.scene(text if model == "scm" else text.replace("load: 2000, slip: 0.2", "sink: 0.1"))
        (self.folder / f"{name}.furrow").unlink(missing_ok=True)
        done = self.furrow("drive", "scene.yaml", "--store", "level.furrow", "--overlay", f"{name}.furrow", "-o", name)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def rows(self, name="out"):
        table = np.genfromtxt(self.folder / name / "objects.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
        return table

    def soils(self, roads, spacing=0.25, step=1):
        """The index of the soil at every post of the terrain."""
        use_package()
        import furrow
        scene = {"spacing": spacing, "soil": {"name": "dry_sand"}, "ground": {"roads": roads}, "redistribute": {"model": "scm"}}
        side = np.arange(0, 128 + spacing / 2, spacing * step)
        x, y = np.meshgrid(side, side)
        with furrow.World(scene, store=self.folder / "level.furrow", overlay=self.folder / f"look{spacing}.furrow") as world:
            found = world.points(np.column_stack([x.ravel(), y.ravel()]))["soil"].reshape(x.shape)
        return x, y, found

    def test_posts_within_half_the_width_have_the_roads_soil(self):
        lines = [([[10, 10], [70.3, 55.1], [70.3, 100], [20, 110]], 4.2, "asphalt"), ([[5, 90], [120, 30]], 7, "concrete"), ([[100, 100], [100, 100.5]], 9, "rock"),
                 ([[-30, 64], [200, 64.01]], 1.1, "ice"), ([[64, 127], [64.3, -50]], 0.3, "lunar")]
        roads = [{"points": points, "width": width, "soil": soil} for points, width, soil in lines]
        for spacing in (0.5, 0.25, 0.125):
            with self.subTest(spacing=spacing):
                x, y, found = self.soils(roads, spacing, 2 if spacing < 0.2 else 1)
                expected = np.zeros(x.shape, dtype=int)
                near = np.zeros(x.shape, dtype=bool)
                for i, (points, width, _) in enumerate(lines):
                    off = distance(x, y, points) - width / 2
                    expected[off <= 0] = i + 1
                    near |= abs(off) < 1e-9
                self.assertTrue((found == expected)[~near].all())
                self.assertEqual({*np.unique(found)}, {0, 1, 2, 3, 4, 5})

    def test_a_wheel_leaves_no_rut_on_a_road_and_grips_by_friction(self):
        self.drive(CROSSING)
        rows = self.rows()
        on = (rows["x"] > 38) & (rows["x"] < 42)
        off = (rows["x"] < 35) | (rows["x"] > 45)
        # A rigid wheel on a spring: W = 4/3 K b z sqrt(2 R z).
        closed = (2000 / (2e8 * 0.3 * 4 / 3 * math.sqrt(2 * 0.4))) ** (2 / 3)
        self.assertLess(abs(rows["sinkage"][on] / closed - 1).max(), 0.02)
        self.assertGreater(rows["sinkage"][off].min(), 0.02)
        self.assertTrue(np.allclose(rows["fz"], 2000, rtol=0.01))
        use_package()
        import furrow
        with furrow.World({"spacing": 0.25, "redistribute": {"model": "none"}}, store=self.folder / "out.furrow", readonly=True) as world:
            heights = world.points([(x, 40) for x in np.arange(38, 42.1, 0.25)])["offset"]
        self.assertEqual(abs(heights).max(), 0)
        run = json.loads((self.folder / "out/run.json").read_text())
        self.assertEqual([soil["name"] for soil in run["soils"]], ["dry_sand", "asphalt"])
        self.assertAlmostEqual(run["soil_shares"][1], 6 / 40, delta=0.01)

    def test_a_wheel_comes_onto_a_road_by_a_step_that_goes_with_the_spacing(self):
        for spacing in (0.125, 0.0625, 0.03125):
            with self.subTest(spacing=spacing):
                text = SCENE % (CROSSING, "scm")
                for old, new in (("spacing: 0.25", f"spacing: {spacing}"), ("time_step: 0.02", "time_step: 0.01"), ("end_time: 4", "end_time: 1"), ("forces: 50", "forces: 100"),
                                 ("[20, 40], [60, 40]", "[36, 40], [38, 40]"), ("speed: 10", "speed: 2")):
                    text = text.replace(old, new)
                self.scene(text)
                (self.folder / "out.furrow").unlink(missing_ok=True)
                self.ok("drive", "scene.yaml", "--store", "level.furrow", "--overlay", "out.furrow", "-o", "out")
                rows = self.rows()
                rise = np.diff(rows["z"])
                whole = rows["z"][-1] - rows["z"][20]
                self.assertGreater(whole, 0.03)
                # It rises as its rim comes over the edge. Posts are hard or soft, so there is a step, which goes with the spacing.
                self.assertLess(rise.max(), 0.01 + 0.28 * spacing)
                self.assertTrue(np.allclose(rows["fz"][5:], 2000, rtol=0.01))

    def test_lines_of_a_file(self):
        if not has_gdal():
            self.skipTest("built without GDAL: lines of a file are read by it")
        self.ok("synth", "-o", "plain.tif", "--kind", "plain", "--relief", "0", "--posts", "257x257", "--spacing", "0.5")
        north = 4649776
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32631", "-a_ullr", "499999.75", str(north + 128.25), "500128.25", str(north - 0.25), "plain.tif", "utm.tif"],
                       cwd=self.folder, check=True)
        self.ok("import", "utm.tif", "-o", "utm.furrow")
        # Two lines along meridians near 3 degrees east, 42 degrees north: 20 and 60 m east of the store's west edge.
        per_degree = 111320 * math.cos(math.radians(42))
        lines = [[[3 + east / per_degree, 41.9990], [3 + east / per_degree, 42.0020]] for east in (20, 60)]
        features = [{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": line}} for line in lines]
        (self.folder / "roads.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        scene = SCENE.replace("[20, 40], [60, 40]", "[5, 40], [80, 40]").replace("end_time: 4", "end_time: 7.5")
        self.scene(scene % ("{lines: roads.geojson, width: 4, soil: rock}", "scm"))
        self.ok("drive", "scene.yaml", "--store", "utm.furrow", "--overlay", "ruts.furrow", "-o", "out")
        rows = self.rows()
        for east in (20, 60):
            self.assertLess(rows["sinkage"][abs(rows["x"] - east) < 1][5:].max(), 2e-3)
        self.assertGreater(rows["sinkage"][abs(rows["x"] - 40) < 10].min(), 0.02)

    def test_what_is_wrong_is_refused_and_what_does_nothing_is_told(self):
        for roads, model, says in (
                ("{width: 4, soil: rock}", "scm", r"ground.roads\[0\]: names neither lines nor points; allowed: exactly one of them"),
                ("{points: [[1, 2], [3, 4]], lines: a.gpx, width: 4, soil: rock}", "scm", r"names both lines and points"),
                ("{points: [[1, 2], [3, 4]], width: 0, soil: rock}", "scm", r"ground.roads\[0\].width: 0 is out of range; allowed: above 0 to 1000"),
                ("{points: [[1, 2], [3, 4]], width: 4, soil: tarmac}", "scm", r"ground.roads\[0\].soil.name: \"tarmac\" is unknown; allowed: "),
                ("{points: [[1, 2], [3, 4]], width: 4}", "scm", r"ground.roads\[0\].soil"),
                ("{points: [[1, 2], [3, 4]], width: 4, soil: {name: dry_sand, thickness: 0.1, over: {name: dry_sand, bekker_kc: -5e6, bekker_kphi: 1e6}}}", "scm",
                 r"ground.roads\[0\].soil.over.bekker_kc: bekker_kc / b \+ bekker_kphi is -1.567e\+07 under wheel, whose b is 0.3 m"),
                ("{lines: a.shp, width: 4, soil: rock}", "scm", r"lines are read from .gpx and .geojson; convert it"),
                ("{points: [[40, 20], [40, 60]], width: 4, soil: rock}", "slippage", r"rock is hard ground, into which nothing sinks, and model slippage presses into all ground; write redistribute: {model: scm}"),
                ("{points: [[40, 20], [40, 60]], width: 4, soil: rock}", "box", r"rock is hard ground, into which nothing sinks, and model box presses")):
            with self.subTest(roads=roads, model=model):
                self.assertRegex(self.drive(roads, model, status=3), says)
        self.assertIn("ground.roads: no path of an object or a vehicle comes onto one", self.drive("{points: [[100, 100], [110, 100]], width: 4, soil: rock}"))


if __name__ == "__main__":
    main()
