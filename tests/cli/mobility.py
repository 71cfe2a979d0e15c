"""furrow mobility: ramps of known slopes are go, no-go or unknown as the pull, the friction angle and the posts say, and drives agree."""
import csv
import json
import math
import os
import pathlib
import re
import signal
import struct
import subprocess
import time
import unittest

from furrow_test import FURROW, MAPS, FurrowTest, chosen, has_gdal, long, main
import rasters

SCENES = pathlib.Path(__file__).parents[2] / "tools" / "scenes"
# Four wheels of 250 kg each. The rear ones run beside the ruts of the front ones, and beside the soil that these lay aside.
WHEELS = [("front_left", 1.1, 0.9), ("front_right", 1.1, -0.9), ("rear_left", -1.1, 0.2), ("rear_right", -1.1, -0.2)]
MODEL = """<mujoco><option timestep="0.002" integrator="implicit"/><worldbody><body name="car" pos="0 0 0.6"><freejoint/>
<inertial pos="0 0 0.1" mass="880" diaginertia="300 800 900"/>%s</body></worldbody><actuator>%s</actuator></mujoco>""" % (
    "".join(f'<body pos="{x} {y} -0.2"><joint name="turn_{name}" axis="0 1 0" armature="1"/>'
            f'<geom name="wheel_{name}" type="cylinder" size="0.4 0.15" euler="90 0 0" mass="30"/></body>' for name, x, y in WHEELS),
    "".join(f'<velocity name="drive_{name}" joint="turn_{name}" kv="3000"/>' for name, _, _ in WHEELS))
SPACING = "0.0625"


@unittest.skipUnless(MAPS, "this build draws no maps")
class Mobility(FurrowTest):
    def setUp(self):
        super().setUp()
        (self.folder / "car.xml").write_text(MODEL)

    def ramp(self, name, rise, spacing=0.5, posts=33):
        """A ramp to the east: rise in metres a metre."""
        top = rise * spacing * (posts - 1)
        row = struct.pack(f"<{posts}H", *(round(65535 * x / (posts - 1)) for x in range(posts)))
        (self.folder / f"{name}.raw").write_bytes(row * posts)
        self.ok("import", f"{name}.raw", "-o", f"{name}.furrow", "--spacing", spacing, "--height-range", f"0,{top or 1!r}" if rise else "0,1e-9",
                "--max-error", "0", "--overwrite")
        return f"{name}.furrow"

    def judged(self, store, *arguments, out="out.png"):
        """What is said of the terrain, as JSON."""
        result = self.furrow("mobility", store, "--vehicle", "car.xml", "--soil", "dry_sand", "--spacing", SPACING, "-o", out, "--json", *arguments)
        if result.returncode == 4 or "no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        told = json.loads(result.stdout)
        self.assertAlmostEqual(sum(told["shares"].values()), 1, delta=1e-9)
        return told, result

    def raster(self, name):
        """West and north of its first pixel's corner, its step, its size, and its values from the north."""
        west, step, _, north, _, _ = rasters.gdalinfo(self.folder / name)["geoTransform"]
        return (west, north, step, *rasters.pixels(self.folder / name, "f"))

    def drives(self, degrees):
        """Whether it drives 4 m up a ramp, and its slip in the last third of them, from how far its rims turned."""
        way = 4
        (self.folder / "scene.yaml").write_text(
            f"scene: 1\ntime_step: 0.002\nend_time: 14\nspacing: {SPACING}\nsoil: {{name: dry_sand, damping: 0}}\nredistribute: {{model: scm}}\n"
            "vehicles:\n  - {name: car, model: car.xml, start: {at: [5, 8]}, driver: {path: {points: [[5, 8], [12, 8]], "
            "speed: 0.8}, drive: [drive_*]}}\nstuck: {after: 3, below: 0.03}\noutput: {vehicles: 20}\n")
        self.ok("drive", "scene.yaml", "--store", self.ramp("drive", math.tan(math.radians(degrees))), "-o", "out")
        with open(self.folder / "out" / "vehicles.csv") as file:
            rows = [(sum(float(row["q:turn_" + name]) for name, _, _ in WHEELS) / 4 * 0.4, (float(row["x"]) - 5) / math.cos(math.radians(degrees)))
                    for row in csv.DictReader(file)]
        ended = next((row for row in rows if row[1] >= way), None)
        if ended is None:
            return False, None
        begun = next(row for row in rows if row[1] >= way * 2 / 3)
        return True, 1 - (ended[1] - begun[1]) / (ended[0] - begun[0])

    def test_ramps_are_what_their_slopes_are_and_drives_agree(self):
        told, _ = self.judged(self.ramp("level", 0))
        self.assertEqual(told["shares"]["go"], 1)
        steepest = told["steepest_up"]
        self.assertGreater(steepest, 10)
        self.assertLess(steepest, 25)
        for slip in ("0.2", "0.3"):
            slope = told["steepest_up_slip_" + slip]
            self.assertTrue(0 < slope < steepest, told)
            ups = [told["slopes"][round(slope / 0.5) + more]["verdicts"][0] for more in (0, 1)]
            self.assertTrue(ups[0]["slip"] <= float(slip) and (ups[1]["slip"] > float(slip) or ups[1]["reason"] != "go"), ups)
        shares = (0.5, 0.8, 1.25)
        for place in chosen(1, len(shares)):
            degrees = shares[place] * steepest
            row = told["slopes"][round(degrees / 0.5)]
            up = row["verdicts"][0]
            self.assertEqual(up["heading"], 90)
            with self.subTest(degrees=degrees):
                passed, slip = self.drives(row["slope"])
                self.assertEqual(passed, up["reason"] == "go", (row["slope"], up))
                if passed:
                    self.assertAlmostEqual(slip, up["slip"], delta=0.05)

    @long
    def test_cells_have_the_class_of_their_slope(self):
        store = self.ramp("steep", 0.5)
        told, _ = self.judged(store)
        self.assertGreater(told["shares"]["no-go"], 0.99)
        (self.folder / "car.xml").write_text(MODEL.replace('kv="3000"', 'kv="3000" forcerange="-40 40" forcelimited="true"'))
        weak, _ = self.judged(self.ramp("ramp", 0.15))
        self.assertGreater(weak["shares"]["no-go"] + weak["shares"]["some headings"], 0.99)
        self.assertEqual(next(row["verdicts"][0]["reason"] for row in weak["slopes"] if row["verdicts"][0]["reason"] != "go"), "too little torque")

    def test_what_cannot_be_known_is_unknown(self):
        told, _ = self.judged(self.ramp("cliff", 1.0))
        self.assertGreater(told["shares"]["unknown"], 0.99)
        # That is told before the rig: at so fine a spacing it would take hours.
        self.assertIn("posts are 30 m apart, and vehicle is 2.2 m long, so all would be unknown; give a terrain with posts of at most 2.2 m", self.refused(
            3, "mobility", self.ramp("coarse", 0.1, spacing=30), "--vehicle", "car.xml", "--soil", "dry_sand", "--spacing", "0.002", "-o", "out.png"))

    @long
    @unittest.skipUnless(has_gdal(), "needs GDAL's programs")
    def test_a_window_is_that_part_of_the_whole(self):
        store = self.ramp("ramp", 0.15)
        for name, window in (("whole", ()), ("part", ("--window", "3,5,9,12.2"))):
            self.judged(store, "--spacing", "0.25", "--layer", "slip", *window, out=name + ".tif")
            self.judged(store, "--spacing", "0.25", *window, out=name + ".png")
        west, north, step, width, height, values = self.raster("whole.tif")
        part = self.raster("part.tif")
        x, y = round((part[0] - west) / step), round((north - part[1]) / step)
        self.assertEqual((part[2], x * step, (height - y - part[4]) * step), (step, 3, 5))
        self.assertEqual(part[3:5], (round(6 / step) + 1, int(7.2 / step) + 1))
        self.assertEqual(list(part[5]), [values[(y + row) * width + x + column] for row in range(part[4]) for column in range(part[3])])
        self.assertTrue(all(value == value for value in part[5][part[3] + 1:part[3] * 2 - 1]))
        self.assertIn("no post lies in --window", self.refused(3, "mobility", store, "--vehicle", "car.xml", "--soil", "lunar", "-o", "x.png", "--window", "90,90,95,95"))

    @long
    def test_a_spread_of_soils_gives_probabilities(self):
        store = self.ramp("steep", 0.2)
        options = ["--spread", "0.3,0.2,0.1", "--samples", "3", "--seed", "7", "--spacing", "0.125"]
        first, result = self.judged(store, *options)
        picture = (self.folder / "out.png").read_bytes()
        again = self.judged(store, *options)[1].stdout
        self.assertEqual(result.stdout, again)
        self.assertEqual(picture, (self.folder / "out.png").read_bytes())
        chances = [row["probability"] for row in first["slopes"]]
        self.assertEqual(first["spread"], [0.3, 0.2, 0.1])
        self.assertEqual((chances[0], chances[-1]), (1, 0))
        self.assertTrue(all(abs(3 * chance - round(3 * chance)) < 1e-9 for chance in chances))
        self.assertTrue(any(0 < chance < 1 for chance in chances))

    @long
    def test_a_soil_of_a_file_or_a_scene_has_its_numbers(self):
        store, numbers = self.ramp("level", 0), "name: dry_sand, cohesion: 300, bekker_n: 1.3"
        (self.folder / "mine.yaml").write_text(f"soil: {{{numbers}}}\n")
        (self.folder / "car.yaml").write_text(f"scene: 1\ntime_step: 0.002\nend_time: 1\nsoil: {{{numbers}}}\nredistribute: {{model: scm}}\n"
                                              "vehicles: [{name: car, model: car.xml, start: {at: [5, 8]}}]\n")
        told = [self.judged(store, "--spacing", "0.25", "--soil", soil)[0] for soil in (f"{{{numbers}}}", "mine.yaml")]
        result = self.furrow("mobility", store, "--scene", "car.yaml", "--spacing", "0.25", "-o", "out.png", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        told.append(json.loads(result.stdout))
        self.assertEqual([each["soil"] for each in told], [f"{{{numbers}}}", "mine", "dry_sand of car.yaml"])
        for each in told[1:]:
            self.assertAlmostEqual(each["steepest_up"], told[0]["steepest_up"], delta=0.01)
            self.assertAlmostEqual(each["slopes"][5]["verdicts"][0]["slip"], told[0]["slopes"][5]["verdicts"][0]["slip"], delta=1e-6)
        plain = self.judged(store, "--spacing", "0.25")[0]
        self.assertNotAlmostEqual(plain["slopes"][5]["verdicts"][0]["slip"], told[0]["slopes"][5]["verdicts"][0]["slip"], delta=1e-3)

    def test_numbers_in_a_wrong_unit_are_told_once(self):
        _, result = self.judged(self.ramp("level", 0), "--spacing", "0.25", "--soil", "{name: dry_sand, janosi_shear: 2}", "--spread", "0.1", "--samples", "1")
        self.assertEqual(len(re.findall(r"furrow: note: .*soil\.janosi_shear: 2 m is more than soils have, .* in cm give 0\.02,", result.stderr)), 1, result.stderr)

    def test_ctrl_c_leaves_nothing(self):
        store = self.ramp("level", 0)
        before = sorted(path.name for path in self.folder.iterdir())
        running = subprocess.Popen([FURROW, "mobility", store, "--vehicle", "car.xml", "--soil", "dry_sand", "--spacing", "0.02", "-o", "out.png"],
                                   cwd=self.folder, env=dict(os.environ, TMPDIR=str(self.folder)), stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        while running.poll() is None and not list(self.folder.glob("furrow-mobility-*")):  # it begins to measure the vehicle
            time.sleep(0.01)
        running.send_signal(signal.SIGINT)
        _, error = running.communicate(timeout=250)
        self.assertEqual(running.returncode, 130, error)
        self.assertIn("interrupted", error)
        self.assertEqual(before, sorted(path.name for path in self.folder.iterdir()))

    def test_wrong_input_is_told(self):
        store = self.ramp("level", 0)
        car = ["--vehicle", "car.xml"]
        for status, arguments, part in (
                (2, [*car, "--soil", "lunar"], "-o is missing"), (2, ["-o", "x.png", "--soil", "lunar"], "--vehicle and --scene"),
                (2, ["-o", "x.png", *car], "--soil is missing"), (3, ["-o", "x.png", "--vehicle", "absent.xml", "--soil", "lunar"], "absent.xml"),
                (3, ["-o", "x.png", *car, "--soil", "moondust"], "moondust"), (2, ["-o", "x.jpg", *car, "--soil", "lunar"], "neither"),
                (2, ["-o", "x.png", *car, "--soil", "lunar", "--layer", "slip"], "is not for a picture"),
                (2, ["-o", "x.tif", *car, "--soil", "lunar", "--layer", "probability"], "give --spread"),
                (2, ["-o", "x.tif", *car, "--soil", "lunar", "--spread", "0.1,2,0.1"], "--spread"),
                (3, ["-o", "x.png", "--vehicle", SCENES / "convoy.yaml", "--soil", "lunar"], "convoy.yaml: "),
                (3, ["-o", "x.png", "--vehicle", SCENES / "vehicles" / "walker.xml", "--soil", "lunar"], "wheel")):
            with self.subTest(arguments=arguments):
                error = self.refused(status, "mobility", store, *arguments)
                self.assertIn(part, error)
                self.assertNotIn("scene text", error)


if __name__ == "__main__":
    main()
