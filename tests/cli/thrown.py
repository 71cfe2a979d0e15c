"""Thrown soil by the command: what a rim that slips digs flies, lands and is told, to the unit; steps, tiles, slots and --resume change no bit; it is off by itself."""
import pathlib
import struct
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, has_gdal, main

SCENE = """scene: 1
time_step: 0.05
end_time: 1.5
spacing: 0.0625
soil: {name: dry_sand}
redistribute: {model: scm, interval: 0.05, thrown: on}
objects:
- {name: a, shape: {wheel: {radius: 0.3, width: 0.25}}, path: {points: [[20, 30], [30, 31]], speed: 1}, load: 700, slip: 0.8}
"""
UNIT = 2.0 ** -20 * 0.0625 ** 2
DENSITY = 1600  # kg/m3, of dry_sand


class Thrown(FurrowTest):
    def driven(self, *more, store="world.furrow", scene=None, tile=256, fresh=True):
        """Drives over fresh ground. Gives run.json and the sums of the store."""
        if fresh:
            self.ok("synth", "-o", "ground.tif" if has_gdal() else "ground.png", "--posts", "65x65", "--spacing", 1, "--kind", "plain", "--relief", 2)
            source = ["ground.tif"] if has_gdal() else ["ground.png", "--height-range", "0,2"]
            self.ok("import", *source, "-o", store, "--tile", tile, "--overwrite", "--force")
        run = self.drive(self.scene(scene or SCENE), "--store", store, *more)
        check = self.json("verify", store)
        self.assertTrue(check["ok"])
        self.assertEqual(check["offset_sum"]["-4"] + check["compacted"] + check["in_flight"], 0)
        self.assertEqual(run["volume"]["quanta"]["net"] + run["volume"]["quanta"]["compacted"] + run["volume"]["quanta"].get("in_flight", 0), 0)
        if "thrown" in run:
            units = run["thrown"]["quanta"]
            self.assertEqual(units["thrown"], units["landed"] + units["in_flight"] + units["lost"])
            self.assertEqual(run["thrown"]["grains"] > 0, units["in_flight"] > 0)
        return run

    def ground(self, store="world.furrow"):
        """The offsets around the path, in fixed-point units, by row from the north."""
        if not has_gdal():
            self.skipTest("no GDAL here")
        self.ok("export", store, "-o", "offsets.tif", "--layer", "fixed_point", "--window", "14,27,26,34")
        result = subprocess.run(["gdal_translate", "-q", "-of", "ENVI", "offsets.tif", "offsets.raw"], cwd=self.folder, capture_output=True, text=True)
        if result.returncode != 0:
            self.skipTest("no gdal_translate here")
        data = (self.folder / "offsets.raw").read_bytes()
        return struct.unpack(f"<{len(data) // 4}i", data)

    def test_what_is_thrown_is_told_and_lands_behind_the_wheel(self):
        run = self.driven()
        told = run["thrown"]
        self.assertAlmostEqual(told["volume"], told["quanta"]["thrown"] * UNIT, delta=1e-9)
        self.assertAlmostEqual(told["mass"] / told["volume"], DENSITY, delta=0.2 * DENSITY)
        self.assertAlmostEqual(told["in_flight_mass"], told["mass"] * told["quanta"]["in_flight"] / told["quanta"]["thrown"], delta=1e-6)
        self.assertGreater(told["mass"], 1)
        self.assertGreater(told["quanta"]["landed"], 0)
        self.assertEqual(told["quanta"]["lost"], 0)
        thrown = self.ground()
        wide = 12 * 16 + 1
        self.assertEqual(len(thrown) % wide, 0)

        def behind(offsets):
            """Of posts that lie 0.5 m and more behind the start of the path."""
            return sum(value for i, value in enumerate(offsets) if i % wide < (20 - 14 - 0.5) * 16)
        run = self.driven("--set", "redistribute.thrown=off")
        self.assertNotIn("thrown", run)
        laid = self.ground()
        self.assertEqual(behind(laid), 0)
        self.assertGreater(behind(thrown), 1000)

    def test_without_slip_nothing_flies_and_no_bit_differs(self):
        self.assertNotIn("thrown", self.driven("--set", "objects.a.slip=0"))  # nothing slips, so nothing is kept for it
        for slip in (0, 1e-7, -0.4):
            told = self.driven("--set", f"objects.a.slip={slip}").get("thrown", {"quanta": {"thrown": 0}})
            self.assertEqual(told["quanta"]["thrown"], 0)
            on = self.ground()
            self.driven("--set", f"objects.a.slip={slip}", "--set", "redistribute.thrown=null")
            self.assertEqual(on, self.ground())

    def test_more_slip_throws_more(self):
        mass = [self.driven("--set", f"objects.a.slip={slip}")["thrown"]["mass"] for slip in (0.2, 0.5, 0.8)]
        self.assertEqual(mass, sorted(mass))
        self.assertGreater(mass[2], 10 * mass[0])

    def test_steps_tiles_slots_and_resume_change_no_bit(self):
        scene = SCENE.replace("{name: dry_sand}", "{name: dry_sand, cohesion: 0, repose: 4}")  # what lands slides
        once = self.driven(scene=scene)["thrown"]["quanta"]
        ground = self.ground()
        for more, tile in ((["--set", "time_step=0.012"], 256), (["--set", "time_step=0.75"], 256), ([], 32), (["--set", "cache.slots=9", "--set", "cache.loaders=0"], 32)):
            self.assertEqual(self.driven(*more, tile=tile, scene=scene)["thrown"]["quanta"], once, more)
            self.assertEqual(self.ground(), ground, more)
        for step in (1, 13, 29):
            first = self.driven("--steps", str(step), scene=scene)["thrown"]
            self.assertTrue(step == 1 or first["grains"] > 0)
            second = self.driven("--resume", fresh=False, scene=scene)
            self.assertEqual((second["resumed_from"], second["thrown"]["quanta"]), (step, once))
            self.assertEqual(self.ground(), ground)

    def test_what_flies_over_the_edge_is_lost_and_told(self):
        scene = SCENE.replace("[[20, 30], [30, 31]]", "[[1.2, 30], [10, 30]]")
        told = self.driven(scene=scene)["thrown"]["quanta"]
        self.assertGreater(told["lost"], 0)
        self.assertGreater(told["landed"], 0)

    def test_grains_show_in_colour_and_depth(self):
        view = "cameras: [{name: c, kind: fixed, pose: {at: [20.2, 28, %s], target: [20.6, 30, %s]}, rate: 1, size: [160, 100], images: [colour, depth]}]\n"
        self.driven()
        z = self.json("query", "world.furrow", "20", "28")["height"]
        pictures = []
        for thrown in ("on", "off"):
            self.driven("--set", f"redistribute.thrown={thrown}", scene=SCENE + view % (z + 1, z + 0.3))
            folder = self.folder / "out/cameras/c"
            pictures.append([sorted(folder.glob(f"{kind}/*.png"))[-1].read_bytes() for kind in ("colour", "depth")])
        self.assertNotEqual(pictures[0][0], pictures[1][0])
        self.assertNotEqual(pictures[0][1], pictures[1][1])

    def test_what_cannot_be_is_refused(self):
        self.driven()
        self.assertIn("slip_sinkage", self.refused(3, "drive", self.scene(SCENE), "--store", "world.furrow", "-o", "out", "--set", "redistribute.slip_sinkage=0"))
        self.assertIn("allowed with: scm", self.refused(3, "drive", self.scene(SCENE), "--store", "world.furrow", "-o", "out", "--set", "redistribute.model=slippage"))
        self.assertIn("off, on", self.refused(3, "drive", self.scene(SCENE), "--store", "world.furrow", "-o", "out", "--set", "redistribute.thrown=maybe"))


if __name__ == "__main__":
    main()
