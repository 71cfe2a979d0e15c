"""Rocks: which posts they raise and make hard, wheels and pictures over them, what is kept, refused and told."""
import json
import math

import numpy as np

from cameras import read_png
from furrow_test import FurrowTest, main, use_package, write_png16

SCENE = """scene: 1
time_step: 0.01
end_time: 6
spacing: {spacing}
soil: {{name: dry_sand}}
ground: {{rocks: {rocks}}}
redistribute: {{model: {model}}}
output: {{forces: 100}}
objects:
  - {{name: wheel, shape: {{wheel: {{radius: 0.5, width: 0.25}}}}, {sunk}, path: {{points: {path}, speed: 1}}}}
"""
NUMBERS = {"cover": 0.08, "largest": 0.6, "smallest": 0.1, "seed": 7}
ROCKS = "{cover: 0.08, largest: 0.6, smallest: 0.1, seed: 7}"
PATH = "[[20, 20], [25, 20]]"


class Rocks(FurrowTest):
    def setUp(self):
        super().setUp()
        self.ok("synth", "-o", "level.furrow", "--kind", "plain", "--relief", "0", "--posts", "257x257", "--spacing", "0.5")

    def drive(self, rocks=ROCKS, model="scm", path=PATH, spacing=0.03125, status=0, name="out", more=""):
        text = SCENE.format(rocks=rocks, model=model, path=path, spacing=spacing, sunk="load: 1000" if model == "scm" else "sink: 0.02") + more
        self.scene(text if rocks else "\n".join(line for line in text.splitlines() if not line.startswith("ground")))
        (self.folder / f"{name}.furrow").unlink(missing_ok=True)
        done = self.furrow("drive", "scene.yaml", "--store", "level.furrow", "--overlay", f"{name}.furrow", "-o", name)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def rows(self, name="out"):
        return np.genfromtxt(self.folder / name / "objects.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")

    def posts(self, rocks, spacing, box, overlay="look"):
        """Heights and soils of the posts of a box that no wheel touched."""
        use_package()
        import furrow
        scene = {"spacing": spacing, "soil": {"name": "dry_sand"}, "ground": {"rocks": rocks}, "redistribute": {"model": "scm"}}
        x, y = np.meshgrid(np.arange(box[0], box[2], spacing), np.arange(box[1], box[3], spacing))
        with furrow.World(scene, store=self.folder / "level.furrow", overlay=self.folder / f"{overlay}{spacing}.furrow") as world:
            found = world.points(np.column_stack([x.ravel(), y.ravel()]))
        return x, y, found["height"].reshape(x.shape), found["soil"].reshape(x.shape)

    def test_posts_with_rocks_are_rock_and_finer_posts_agree(self):
        before = {}
        for spacing in (0.125, 0.0625, 0.03125):
            with self.subTest(spacing=spacing):
                x, y, height, soil = self.posts({"cover": 0.2, "largest": 1, "smallest": 0.2, "seed": 3}, spacing, (30, 30, 44, 44))
                self.assertTrue(((height > 0) == (soil == 1)).all())
                self.assertEqual({*np.unique(soil)}, {0, 1})
                self.assertLess(height.max(), 0.61)
                self.assertGreater(height.max(), 0.1)
                for other, coarse in before.items():
                    step = round(other / spacing)
                    self.assertTrue((height[::step, ::step] == coarse).all())
                before[spacing] = height
        law = 0.2 * (math.exp(-(1.79 + 0.152 / 0.2) * 0.2) - math.exp(-(1.79 + 0.152 / 0.2) * 1))
        self.assertAlmostEqual((before[0.03125] > 0).mean(), law, delta=0.3 * law)  # of 196 m2; tests/base/rocks.c has many

    def test_a_wheel_rises_over_a_rock_as_the_posts_say_and_the_sand_beside_is_as_without(self):
        spacing = 0.03125
        x, y, height, _ = self.posts(NUMBERS, spacing, (19, 19, 31, 21))
        inside, around = abs(y - 20) <= 0.125 - spacing / 2, abs(y - 20) <= 0.125 + spacing / 2 + 1e-9
        rocky = (height * around).max(axis=0) > 0
        start = next(at for at in np.arange(20, 27, 0.125) if not rocky[abs(x[0] - at) < 0.75].any() and rocky[abs(x[0] - at) < 2].any())
        path = f"[[{start}, 20], [{start + 4}, 20]]"
        self.drive(path=path)
        self.drive(rocks=None, name="bare", path=path)
        rows, bare = self.rows(), self.rows("bare")
        self.assertEqual(len(rows), len(bare))
        far = np.array([(height[around & (abs(x - row["x"]) < 0.55)] > 0).any() for row in rows])

        def top(under, at):
            """How high the wheel's middle is if it touches the highest rock under it."""
            dx = abs(x - at)
            on = under & (dx < 0.5) & (height > 0)
            return (height[on] + np.sqrt(0.25 - dx[on] ** 2)).max() if on.any() else 0
        met = 0
        for row, flat, rock in zip(rows, bare, far):
            if not rock:
                continue
            low, high = top(inside, row["x"]), top(around, row["x"])
            if low > flat["z"] + 0.03:  # the rock bears it, not the sand
                met += 1
                self.assertGreater(row["z"], low - 0.006)  # rock springs: 5 mm under one post
                self.assertLess(row["z"], high + 0.001)
                self.assertAlmostEqual(row["fz"], 1000, delta=20)
        self.assertGreater(met, 10)
        # Before it comes to the first one, and nothing shows of it.
        first = np.argmax(far)
        self.assertGreater(first, 3)
        for key in ("z", "fx", "fz", "sinkage"):
            self.assertTrue((rows[key][:first] == bare[key][:first]).all(), key)
        # No rut in rock.
        use_package()
        import furrow
        with furrow.World({"spacing": spacing, "redistribute": {"model": "none"}, "ground": {"rocks": NUMBERS}},
                          store=self.folder / "out.furrow", readonly=True) as world:
            told = world.points(np.column_stack([x.ravel(), y.ravel()]))
        self.assertTrue((told["offset"][(height > 0).ravel()] > -1e-6).all())
        self.assertLess(told["offset"].min(), -0.005)

    def test_what_is_kept_tells_it_and_other_rocks_are_refused(self):
        self.drive(name="kept")
        run = json.loads((self.folder / "kept/run.json").read_text())
        self.assertEqual(run["relief"], {"rocks": {"cover": 0.08, "k": 0.08, "smallest": 0.1, "largest": 0.6, "seed": 7}})
        self.assertEqual(self.json("info", "kept.furrow")["relief"], run["relief"])
        self.assertEqual([soil["name"] for soil in run["soils"]], ["dry_sand", "rock"])
        self.assertTrue(run["soils"][1]["rock"])
        self.assertGreater(run["soil_shares"][1], 0)
        x, y, height, _ = self.posts(NUMBERS, 0.03125, (40, 40, 41, 41))
        row, column = np.unravel_index(height.argmax(), height.shape)
        self.assertGreater(height.max(), 0)
        answer = self.json("query", "kept.furrow", f"{x[row, column]:.9g}", f"{y[row, column]:.9g}")["points"][0]
        self.assertAlmostEqual(answer["base"], height.max(), places=6)
        for rocks in (ROCKS.replace("7}", "8}"), ROCKS.replace("0.08", "0.07"), None):
            text = (self.folder / "scene.yaml").read_text()
            text = text.replace(ROCKS, rocks) if rocks else "\n".join(line for line in text.splitlines() if not line.startswith("ground"))
            (self.folder / "other.yaml").write_text(text)
            done = self.furrow("drive", "other.yaml", "--store", "kept.furrow", "-o", "other")
            self.assertEqual(done.returncode, 3)
            self.assertRegex(done.stderr, "it was deformed over relief .*rocks.*; give the scene that relief, or furrow reset")
        self.drive(rocks=None, name="bare")
        self.assertNotIn("relief", json.loads((self.folder / "bare/run.json").read_text()))

    def test_explain_tells_cover_and_count(self):
        self.drive()
        told = self.json("explain", "scene.yaml", "--store", "level.furrow")["rocks"]
        q = 1.79 + 0.152 / 0.08
        self.assertAlmostEqual(told["cover"], 0.08 * (math.exp(-q * 0.1) - math.exp(-q * 0.6)), places=9)
        self.assertAlmostEqual(told["count"], told["a_square_metre"] * 128 ** 2, delta=1)
        text = " ".join(self.ok("explain", "scene.yaml", "--store", "level.furrow").split())
        self.assertRegex(text, r"rocks 0\.1 to 0\.6 m across, up to 0\.37 m high, cover [0-9.]+ % of the ground; .* a square metre, about [0-9,]+ on the terrain")
        self.assertRegex(text, r"rock \(rocks; [0-9.]+ % of the paths\)")

    def test_pictures_show_them_and_depth_agrees(self):
        more = ("view: {pixel_error: 0.25, camera: {fixed: {eye: [23, 20.001, 6], target: [23, 20, 0]}}}\n"
                "cameras: [{name: down, kind: fixed, pose: {at: [23, 20, 6], pitch: -90}, rate: 0.5, fov: 40, size: [160, 120], images: [depth, class, height]}]\n")
        self.drive(name="seen", more=more)
        folder = self.folder / "seen/cameras/down"
        depth, seen = np.load(folder / "depth/000000.npy"), np.load(folder / "height/000000.npy")
        soil = np.array(read_png(folder / "class/000000.png")).reshape(depth.shape)
        ground = soil < 2  # the wheel is in the picture, too
        self.assertLess(abs(6 - depth - seen)[ground].max(), 1e-4)
        # By the posts: at each pixel's place on the ground.
        focal = json.loads((folder / "camera.json").read_text())["fx"]
        column, row = np.meshgrid(np.arange(160) + 0.5 - 80, np.arange(120) + 0.5 - 60)
        pose = np.loadtxt(folder / "poses.tum", ndmin=2)[0]
        qx, qy, qz, qw = pose[4:8]
        right = np.array([1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw)])
        down = np.array([2 * (qx * qy - qz * qw), 1 - 2 * (qx * qx + qz * qz)])
        places = pose[1:3] + depth[..., None] / focal * (column[..., None] * right + row[..., None] * down)
        use_package()
        import furrow
        scene = {"spacing": 0.03125, "soil": {"name": "dry_sand"}, "ground": {"rocks": NUMBERS}, "redistribute": {"model": "scm"}}
        with furrow.World(scene, store=self.folder / "level.furrow", overlay=self.folder / "look.furrow") as world:
            points = world.points(places[ground])
        off = abs(points["height"] - seen[ground])
        self.assertGreater((points["height"] > 0.02).sum(), 200)
        self.assertLess(np.quantile(off, 0.98), 0.002)
        self.assertGreater((points["soil"] == soil[ground]).mean(), 0.99)

    def test_what_is_wrong_or_does_nothing_is_told(self):
        for rocks, says in (
                ("{cover: 1.2, largest: 1}", r"ground.rocks.cover: 1.2 is out of range, since cover is a share .*; allowed: 0 to 0.9"),
                ("{cover: -0.1, largest: 1}", r"ground.rocks.cover: -0.1 is out of range"),
                ("{cover: 0.1, k: 0, largest: 1}", r"ground.rocks.k: 0 is out of range; allowed: above 0 to 1"),
                ("{cover: 0.1, largest: 30}", r"ground.rocks.largest: 30 is out of range; allowed: above 0 to 20"),
                ("{cover: 0.1}", r"ground.rocks.*largest"),
                ("{largest: 1}", r"ground.rocks.*cover"),
                ("{cover: 0.1, largest: 1, smallest: 1}", r"ground.rocks.smallest: 1 m is not below the largest, 1 m; allowed: less than that"),
                ("{cover: 0.1, largest: 1, smallest: 0.001}", r"ground.rocks.smallest: 0.001 m is less than 1/256 of the largest, 1 m; allowed: 0.00390625 m and more"),
                ("{cover: 0.1, largest: 1, smallest: 1e-12}", r"ground.rocks.smallest: 1e-12 is out of range; allowed: 0.001 to 20"),
                ("{cover: 0.1, largest: 1, seed: -1}", r"ground.rocks.seed: -1 is out of range"),
                ("{cover: 0.1, largest: 1, shape: round}", r"ground.rocks.shape")):
            with self.subTest(rocks=rocks):
                self.assertRegex(self.drive(rocks=rocks, status=3), says)
        self.assertIn("ground.rocks: a cover of 0 has no rocks", self.drive(rocks="{cover: 0, largest: 1}"))
        self.assertIn("ground.rocks: posts 0.25 m apart show no rocks of 0.6 m: the smallest is 3 posts wide; give a spacing below 0.2",
                      self.drive(rocks="{cover: 0.1, largest: 0.6}", spacing=0.25))
        self.assertIn("ground.rocks.smallest: rocks of 0.1 m are narrower than 2 posts", self.drive(spacing=0.125))
        self.assertIn("ground.rocks: model slippage knows no hard ground", self.drive(model="slippage"))
        write_png16(self.folder / "numbers.png", 257, 257, lambda x, y: 5)
        self.scene(SCENE.format(rocks=ROCKS, model="scm", path=PATH, spacing=0.03125, sunk="load: 1000").replace("{name: dry_sand}", "{name: dry_sand, rasters: {cohesion: numbers.png}}"))
        self.assertRegex(self.furrow("explain", "scene.yaml").stderr, "ground.rocks: do not go with soil.rasters, ")


if __name__ == "__main__":
    main()
