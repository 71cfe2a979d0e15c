"""Notes that a drive prints: ruts that are there already, numbers that are probably in another unit, and paths without ground or end."""
import json
import pathlib
import re
import shutil

from furrow_test import SCENE, FurrowTest, main

SCM = """scene: 1
time_step: 0.05
end_time: 1
soil: {name: dry_sand, cohesion: 1.04}
redistribute: {model: scm}
objects:
  - {name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, load: 900, path: {points: [[20, 20], [40, 20]], speed: 5}}
"""


class Notes(FurrowTest):
    def setUp(self):
        super().setUp()
        self.store = self.synth()
        self.scene()

    def notes(self, word, *arguments, scene="scene.yaml", status=0, store=("--store", "world.furrow")):
        """The notes of a drive that have `word` in them."""
        result = self.furrow("drive", scene, *store, "-o", "out", *arguments)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, status, result.stderr)
        return [line for line in result.stderr.splitlines() if line.startswith("furrow: note: ") and word in line]

    def deepest(self, store):
        return -min(point["offset"] for point in self.json("query", store, stdin="".join(
            f"{20 + 100 * i / 1000} {20 + 70 * i / 1000}\n" for i in range(1001)))["points"])

    def test_ruts_in_an_overlay_are_told(self):
        began = lambda: json.loads((self.folder / "out/run.json").read_text())["store"].get("began_on")
        self.assertEqual(self.notes("ruts", "--overlay", "a.furrow"), [], "it has none yet")
        self.assertIsNone(began())
        told = self.notes("ruts", "--overlay", "a.furrow")
        self.assertRegex(told[0], f"up to {began()['deepest']:.3g} m deep")
        self.assertEqual(len(told), 1, told)
        self.assertIn("a.furrow: the ground has ruts already, up to ", told[0])
        self.assertIn("; for the ground as it was imported give another --overlay, or run furrow reset a.furrow", told[0])
        self.assertEqual(self.notes("ruts", "--overlay", "b.furrow"), [], "another overlay has none")
        self.ok("reset", "a.furrow")
        self.assertEqual(self.notes("ruts", "--overlay", "a.furrow"), [], "nor has one that was reset")

    def test_the_first_ruts_in_an_imported_store_are_told(self):
        self.ok("synth", "-o", "dem.png", "--posts", "129x129", "--spacing", "1")
        self.ok("import", "dem.png", "-o", "dem.furrow", "--spacing", "1")
        self.ok("import", "dem.png", "-o", "kept.furrow", "--spacing", "1")
        over = ("--store", "dem.furrow")
        self.assertEqual(self.notes("into the imported store", "--overlay", "a.furrow", store=over), [])
        self.assertEqual(self.notes("into the imported store", "--keep-history", store=("--store", "kept.furrow")), [])
        told = self.notes("ruts", "--steps", "10", store=over)
        self.assertEqual(len(told), 1, told)
        self.assertIn("dem.furrow: this run writes its ruts into the imported store itself; to keep the store as it is, give --overlay FILE", told[0])
        self.assertEqual(self.notes("ruts", "--resume", store=over), [])
        self.assertIn("the ground has ruts already", "".join(self.notes("ruts", store=over)))
        self.assertEqual(self.notes("into the imported store", store=over), [])
        self.assertEqual(self.notes("into the imported store"), [], "furrow synth makes the same again")

    def test_how_deep_they_are(self):
        self.notes("ruts")
        deepest = self.deepest("world.furrow")
        told = self.notes("ruts")
        self.assertEqual(len(told), 1, told)
        said = float(told[0].split("up to ")[1].split(" m deep")[0])
        self.assertGreater(said, 0.1)
        self.assertGreaterEqual(said, 0.98 * deepest)
        self.assertLess(said, 1.5 * deepest)
        self.assertIn("as it was imported run furrow reset world.furrow", told[0])
        self.assertNotIn("--overlay", told[0], "an overlay goes over no store with ruts")

    def test_a_world_file_beside_a_heightmap_is_told(self):
        self.ok("synth", "-o", "a.png", "--posts", "33x33", "--spacing", "2")
        self.assertIn("a.png: says no distance between posts; taken as 1 m", self.furrow("import", "a.png", "-o", "a.furrow").stderr)
        (self.folder / "a.pgw").write_text("2\n0\n0\n-2\n500000\n4600000\n")
        told = self.furrow("import", "a.png", "-o", "a.furrow", "--overwrite").stderr
        if told == "": # GDAL is there, and reads it
            self.assertEqual(self.json("info", "a.furrow")["spacing"], 2)
        else:
            self.assertRegex(told, r"the world file a\.pgw is not read, since GDAL finds no place in it or is not there, and posts are taken as 1 m apart; give the first number of that file as --spacing")
        self.assertEqual(self.furrow("import", "a.png", "-o", "a.furrow", "--overwrite", "--spacing", "2").stderr, "")

    def test_a_resumed_drive_is_told_nothing(self):
        self.notes("ruts", "--overlay", "a.furrow", "--steps", "40")
        shutil.copy(self.folder / "a.furrow", self.folder / "b.furrow")
        self.assertEqual(self.notes("ruts already", "--overlay", "a.furrow", "--resume"), [])
        self.assertEqual(len(self.notes("ruts already", "--overlay", "b.furrow")), 1)

    def test_the_unit_of_a_number_is_told_once(self):
        self.scene(SCM, "scm.yaml")
        told = self.notes("kPa", "--overlay", "a.furrow", scene="scm.yaml")
        self.assertEqual(told, ["furrow: note: scm.yaml:4:24: soil.cohesion: 1.04 Pa is less than soils have, and probably in kPa; the unit is "
                                "Pa: give 1040, or 0 for none"])
        self.assertEqual(len([note for note in self.json("explain", "scm.yaml")["notes"] if "kPa" in note]), 1)
        self.scene(SCM.replace("cohesion: 1.04", "bekker_kphi: 1528, janosi_shear: 2"), "scm.yaml")
        explained = self.json("explain", "scm.yaml")["notes"]
        for key in ("soil.bekker_kphi", "soil.janosi_shear"):
            told = self.notes(f" {key}: ", "--overlay", "c.furrow", "--set", "end_time=0.1", scene="scm.yaml")
            self.assertEqual([told[0].removeprefix("furrow: note: ")], [note for note in explained if f" {key}: " in note])
            self.assertEqual(len(told), 1)
        self.scene(SCM.replace("1.04", "1040"), "scm.yaml")
        self.assertEqual(self.notes("kPa", "--overlay", "b.furrow", scene="scm.yaml"), [])

    def test_a_vehicle_that_has_not_arrived_is_told(self):
        shutil.copy(pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml", self.folder)
        scene = ("scene: 1\ntime_step: 0.002\nend_time: 0.1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
                 "  - {name: car, model: one_wheel.xml, start: {at: [20, 20]}, driver: {path: {points: [[20, 20], %s], speed: 1}, drive: [drive]}}\n")
        self.scene(scene % "[30, 20]", "car.yaml")
        result = self.furrow("drive", "car.yaml", "--store", "world.furrow", "--overlay", "c.furrow", "-o", "out")
        if result.returncode == 4 or "this build has no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        told = [line for line in result.stderr.splitlines() if "vehicles.car" in line]
        # What the soil's rebound does is told once, of drives and by explain, unless the scene gives it.
        springs = [line for line in told if line.startswith("furrow: note: soil.elastic_stiffness: is not given, so it is 4e+07 Pa/m: below vehicles.car.wheel the soil springs back by ")]
        self.assertEqual(len(springs), 1, result.stderr)
        told.remove(springs[0])
        self.assertIn(springs[0].removeprefix("furrow: note: "), self.json("explain", "car.yaml", "--store", "world.furrow")["notes"])
        self.assertNotIn("elastic_stiffness", "".join(self.json("explain", "car.yaml", "--set", "soil.elastic_stiffness=1e8")["notes"]))
        # Few posts are below its wheel, as is told of an object of that shape and load.
        uneven = [line for line in told if "its slip goes up and down at 1 m/s by up to about 0.09 (standard deviation)" in line]
        self.assertEqual(len(uneven), 1, result.stderr)
        told.remove(uneven[0])
        self.assertEqual(len(told), 3, result.stderr)
        self.assertEqual(told.pop(0), "furrow: note: vehicles.car.wheel: is 0.24 m across, and posts are 0.25 m apart: it can pass between them and leave nothing; "
                         "give a spacing of at most 0.24")
        self.scene(SCM.replace("1.04", "1040").replace("radius: 0.5, width: 0.4", "radius: 0.32, width: 0.24").replace("900", "981"), "alike.yaml")
        alike = [note for note in self.json("explain", "alike.yaml", "--store", "world.furrow", "--set", "spacing=0.25")["notes"] if "forces may" in note]
        self.assertEqual([told[0].replace("vehicles.car.wheel", "objects.a.shape").removeprefix("furrow: note: ")], alike)
        self.assertIn(told[0].removeprefix("furrow: note: "), self.json("explain", "car.yaml", "--store", "world.furrow")["notes"])
        fine = self.json("explain", "car.yaml", "--store", "world.furrow", "--set", "spacing=0.01")["notes"]
        self.assertEqual([note for note in fine if "vehicles.car" in note and "springs back" not in note], [])
        coarse = self.json("explain", "car.yaml", "--store", "world.furrow", "--set", "spacing=0.5")["notes"]
        self.assertEqual(len([note for note in coarse if "posts: forces may be off by " in note]), 1)
        # Damping is told where the scene does not give it.
        damped = "soil.damping: is not given, so it is 30000 Pa s/m: it adds slip, more at a higher speed; furrow rig and furrow mobility have no damping: for the same as there give 0"
        self.assertIn("furrow: note: " + damped + "\n", result.stderr)
        self.assertIn(damped, fine)
        self.assertNotIn("soil.damping", "".join(self.json("explain", "car.yaml", "--set", "soil.damping=30000")["notes"]))
        self.assertRegex(told[1], r"^furrow: note: vehicles\.car: is not at the end of its path: it has come [\d.e-]+ m(, and its wheels slip -?[\d.]+)?; drive longer, or look ")
        self.scene(scene % "[30, 20], [9000, 20]", "far.yaml")
        far = [note for note in self.json("explain", "far.yaml", "--store", "world.furrow")["notes"] if "off the terrain" in note]
        self.assertEqual(len(far), 1)
        self.assertRegex(far[0], r"^vehicles\.car\.driver\.path: point 3, at 9000\.000, 20\.000 m, is off the terrain, where the drive would end; keep within 0 to ")
        # It drives on the level, and hardly moved on the hill above.
        self.synth("plain.furrow", posts="65x65", kind="plain", relief=0.2)
        moving = self.notes("vehicles.car: ", "--set", "end_time=2", "--store", "plain.furrow", scene="car.yaml", store=())
        self.assertEqual(len(moving), 1, moving)
        told = re.search(r"not at the end of its path, but still drives at ([\d.]+) m/s: it has come ([\d.]+) m, and ([\d.]+) m are left; give an end_time of (\d+) s or more$",
                         moving[0])
        speed, way, left, end = map(float, told.groups())
        self.assertAlmostEqual(way + left, 10, delta=0.1)
        self.assertAlmostEqual(end, 3.5 + left / speed, delta=1)  # 2 s, and one in which it slows down
        stuck = self.notes("vehicles.car: ", "--overlay", "f.furrow", "--set", "end_time=20", "--set", "stuck={after: 1, below: 0.5}", scene="car.yaml")
        self.assertRegex(" ".join(stuck), r"vehicles\.car: is stuck since [\d.]+ s: it has come [\d.]+ m, and its wheels slip [\d.]+, and car\.wheel is deepest in the soil, by [\d.]+ m; look ")
        # One point: it is there.
        self.scene((scene % "[30, 20]").replace("[[20, 20], [30, 20]]", "[[20, 20]]"), "there.yaml")
        self.assertEqual(self.notes("vehicles.car: ", "--overlay", "d.furrow", scene="there.yaml"), [])

    def test_how_a_vehicle_lies_is_told(self):
        """Once, with time and place, in run.json and in the report; `stop` ends the drive."""
        (self.folder / "over.xml").write_text(
            '<mujoco><option timestep="0.002" integrator="implicit"/><worldbody><body name="car" pos="0 0 0.5" quat="0 1 0 0"><freejoint/>'
            '<geom name="hull" type="box" size="0.6 0.4 0.1" mass="80"/></body></worldbody></mujoco>')
        self.scene("scene: 1\ntime_step: 0.002\nend_time: 3\nspacing: 0.125\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                   "vehicles: [{name: car, model: over.xml, start: {at: [20, 20], settle: false}}]\nstop: [overturned]\n", "over.yaml")
        told = self.notes("vehicles.car", "--overlay", "over.furrow", scene="over.yaml")
        lies = [note for note in told if "lies on its roof since t = " in note]
        self.assertEqual(len(lies), 1, told)
        self.assertRegex(lies[0], r"vehicles\.car lies on its roof since t = [\d.]+ s, at [\d.]+, [\d.]+ m; stop: \[overturned\] ends a drive there$")
        run = json.loads((self.folder / "out/run.json").read_text())
        self.assertEqual(run["ended"], "overturned")
        self.assertAlmostEqual(run["simulated"], 1, delta=0.1)
        lie, = run["vehicles"]["car"]["lies"]
        self.assertEqual((lie["what"], lie["geom"], lie["depth"]), ("overturned", None, None))
        self.ok("report", "out", "-o", "page.html")
        self.assertIn("car lay on its side or roof from t = ", (self.folder / "page.html").read_text())
        self.assertIn("no_soil: hul names no geom", self.refused(3, "drive", "over.yaml", "--store", "world.furrow", "-o", "x", "--set", "vehicles.car.no_soil=[hul]"))

    def test_sizes_and_paths_of_a_model_are_told(self):
        model = (pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml").read_text()
        (self.folder / "mm.xml").write_text(model.replace('size="0.32 0.12"', 'size="320 120"'))
        scene = "scene: 1\ntime_step: 0.002\nend_time: 1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles: [{name: car, model: %s, start: {at: [20, 20]}}]\n"
        self.scene(scene % "mm.xml", "mm.yaml")
        result = self.furrow("explain", "mm.yaml")
        if "this build has no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertRegex(result.stderr.splitlines()[0], r"^furrow: note: mm\.yaml: vehicles\.car: car\.wheel reaches 341\.8 m from its middle: that is large, and perhaps in mm; ")
        # What grousers cost is told of a vehicle, and where posts cannot tell their prints apart: 2 pi 0.32 / 20 m.
        (self.folder / "bars.xml").write_text(model.replace('mass="30"', 'mass="30" user="20 0.01 0.01"').replace("<worldbody>", '<size nuser_geom="3"/><worldbody>'))
        self.scene(scene % "bars.xml", "bars.yaml")
        bars = [note for note in self.json("explain", "bars.yaml", "--set", "redistribute.faces=off")["notes"] if "rousers" in note]
        self.assertRegex(bars[0], r"^vehicles\.car\.wheel: has grousers: where such a wheel slips it pulls less here than a smooth one, ")
        self.assertRegex(bars[1], r"^vehicles\.car\.wheel: grousers: their prints are 0\.101 m apart, less than two posts of 0\.25 m: ")
        self.assertEqual([note for note in self.json("explain", "bars.yaml")["notes"] if "rousers" in note], bars[1:])
        self.assertEqual([note for note in self.json("explain", "bars.yaml", "--set", "spacing=0.05")["notes"] if "rousers" in note], [])
        self.scene(scene % "none.xml", "none.yaml")
        self.assertIn(f"name a file that can be read; it was looked for at {self.folder.resolve()}/none.xml", self.refused(3, "explain", "none.yaml"))
        self.scene(SCM.replace("1.04", "1040").replace("radius: 0.5", "radius: 500"), "large.yaml")
        self.assertIn("too large for posts", self.refused(3, "explain", "large.yaml", "--set", "spacing=0.25"))
        self.assertIn("if it is in mm, give thousandths of it", self.refused(3, "explain", "large.yaml", "--set", "spacing=0.25"))

    def test_a_vehicle_that_cannot_start_leaves_nothing(self):
        model = (pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml").read_text()
        (self.folder / "one_wheel.xml").write_text(model.replace('<body name="wheel">', '<body name="wheel" pos="0.75 0 0">'))
        self.scene("scene: 1\ntime_step: 0.002\nend_time: 0.1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\noutput: {vehicles: 20}\n"
                   "vehicles: [{name: car, model: one_wheel.xml, start: {at: [-5, 20]}}]\n", "off.yaml")
        before = sorted(self.folder.rglob("*"))
        new = ("drive", "off.yaml", "--store", "world.furrow", "--overlay", "new.furrow", "-o", "out", "--trace", "new.trace")
        result = self.furrow(*new)
        if result.returncode == 4 or "this build has no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertIn("no ground under car.wheel at -4.25, 20 m", self.told(3, result))
        self.assertEqual(result.stdout, "")
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        # What was there before stays.
        self.ok(*new, "--set", "vehicles.car.start.at=[20, 20]")
        (self.folder / "out/mine").write_text("mine")
        self.refused(3, *new)
        self.assertTrue((self.folder / "out/mine").exists() and (self.folder / "new.furrow").exists())

    def test_a_vehicle_that_the_soil_does_not_carry_is_told(self):
        self.synth(posts="65x65", kind="plain", relief=1)
        model = (pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml").read_text()
        (self.folder / "car.xml").write_text(model.replace("<actuator>", '<actuator><motor name="press" joint="z"/>'))
        soil = "{bekker_kc: 5, bekker_kphi: %s, bekker_n: 0.9, cohesion: 0, friction_angle: 32, janosi_shear: 0.015, elastic_stiffness: 1e6, damping: 30000}"
        scene = ("scene: 1\ntime_step: 0.002\nend_time: 1.6\nspacing: 0.125\nsoil: " + soil + "\nredistribute: {model: scm}\nvehicles:\n  - {name: car, "
                 "model: car.xml, start: {at: [20, 20]}, driver: {hold: [{actuator: press, value: %g}]}}\n")
        self.scene(scene % ("1200", 0), "mud.yaml")
        before = sorted(self.folder.rglob("*"))
        result = self.furrow("drive", "mud.yaml", "--store", "world.furrow", "--overlay", "a.furrow", "-o", "out")
        if result.returncode == 4 or "this build has no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual((result.returncode, result.stdout), (3, ""), result.stderr)
        self.assertRegex(result.stderr, r"mud\.yaml: while it settles, vehicles\.car\.wheel: is [\d.]+ m deep in the soil, deeper than it is high, at [\d., ]+ m: the soil does not "
                         r"carry the vehicle, which weighs 981 N; check bekker_kphi \(in N/m\^\(n\+2\), here 1200\), the vehicle's mass, and spacing, [\d.]+ m")
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        # It is pressed down only once it drives.
        self.scene(scene % ("200000", -1e5), "pressed.yaml")
        told = self.notes("deep in the soil", "--overlay", "a.furrow", scene="pressed.yaml")
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], r"note: after 1\.\d+ s, vehicles\.car\.wheel: is [\d.]+ m deep in the soil, deeper than it is high, .* here 200000\)")
        self.assertIn(told[0].removeprefix("furrow: note: "), json.loads((self.folder / "out/run.json").read_text())["notes"])

    def test_a_load_that_the_soil_does_not_carry_is_told_before_and_after(self):
        self.synth(posts="65x65", kind="plain", relief=0)
        scene = SCM.replace("dry_sand, cohesion: 1.04", "sandy_loam_22").replace("radius: 0.5, width: 0.4", "radius: 0.66, width: 0.7")
        for load, told in ((40000, 1), (25000, 0)):
            self.scene(scene.replace("load: 900", f"load: {load}, slip: 0.1"), "heavy.yaml")
            before = [note for note in self.json("explain", "heavy.yaml", "--store", "world.furrow")["notes"] if ".load:" in note]
            self.assertEqual(len(before), told, before)
            if told:  # furrow rig: 32.2 cm under 19200 N, 77 cm under 32000 N, and under 38000 N it is sunk
                self.assertEqual(before[0], "objects.a.load: sandy_loam_22 on its path does not carry 40000 N: it bears about 32000 N when the object has sunk by "
                                            "0.66 m, and about 19000 N at 0.33 m; give less load, or a wider wheel")
            after = self.notes("did not carry", "--overlay", f"{load}.furrow", "--set", "spacing=0.125", "--set", "end_time=0.3", scene="heavy.yaml")
            self.assertEqual(len(after), told, after)
            if told:
                self.assertRegex(after[0], r"note: \d+ times the soil did not carry an object's load, which sank as deep as it is high; most often a \(40000 N\), first after "
                                           r"0\.05 s at 20\.\d\d, 20\.00 m, on sandy_loam_22 \(output\.forces: 10 in the scene writes objects\.csv, whose rows then have the "
                                           r"state sunk\)$")
                most = json.loads((self.folder / "out/run.json").read_text())["forces"]["sunk_most"]
                self.assertEqual((most["object"], most["soil"], most["steps"]), ("a", "sandy_loam_22", 6))
                rows = self.notes("did not carry", "--overlay", "b.furrow", "--set", "spacing=0.125", "--set", "end_time=0.3", "--set", "output.forces=10", scene="heavy.yaml")
                self.assertIn("on sandy_loam_22 (state sunk of objects.csv)", rows[0])
        self.assertNotIn("sunk_most", json.loads((self.folder / "out/run.json").read_text())["forces"])

    def test_a_slope_that_does_not_hold_a_load_is_told_with_its_first_place(self):
        self.synth(posts="65x65", relief=60)
        self.scene(SCM.replace("[40, 20]], speed: 5", "[40, 40]], speed: 20"), "steep.yaml")
        told = self.notes("on a slope", "--overlay", "a.furrow", "--set", "spacing=0.125", "--set", "end_time=0.5", scene="steep.yaml")
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], r"cannot hold it: only its path did; most often a \(900 N\), first after 0\.\d+ s at [\d.]+, [\d.]+ m, on dry_sand \(output\.forces: 10 in the "
                                  r"scene writes objects\.csv, whose rows then have the state slides\)$")

    def test_a_path_that_is_not_finished_is_told(self):
        scene = ("scene: 1\ntime_step: 0.1\nend_time: %s\nspacing: 0.5\nredistribute: {model: box}\nobjects:\n"
                 "  - {name: a, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[20, 20], [50, 60]], speed: 5}}\n"
                 "  - {name: b, shape: {sphere: {radius: 1}}, sink: 0.1, path: {relative_to: a, delay: 2.5}}\n"
                 "  - {name: late, shape: {sphere: {radius: 1}}, sink: 0.1, path: {relative_to: a, delay: 4.5}}\n"
                 "  - {name: round, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[20, 70], [50, 70]], speed: 5, loop: true}}\n")
        for end, told in ((4, ["objects.b.path: the drive ends after 4 s, when it has come 7.5 m of 50 m, and 1 other is not at the end either; the whole path takes "
                               "12.5 s: give end_time 12.5, or a shorter path"]), (14.5, [])):
            self.scene(scene % end, "way.yaml")
            notes = self.json("explain", "way.yaml", "--store", "world.furrow")["notes"]
            self.assertEqual([note for note in notes if ".path:" in note and "begins after" not in note], told)
        driven = self.notes(".path: the drive ends", "--overlay", "w.furrow", "--set", "end_time=4", scene="way.yaml")
        self.assertEqual(len(driven), 1)
        self.assertEqual(self.notes(".path: the drive ends", "--overlay", "v.furrow", scene="way.yaml"), [])
        # A path of 50 m that takes 10 s: what is within a path sample, or a time step, is not missing.
        self.scene((scene % 10).replace("time_step: 0.1", "time_step: 0.01").split("  - {name: b")[0], "one.yaml")
        for end, told in ((9.6, 1), (9.85, 1), (9.95, 0), (9.992, 0)):
            notes = self.json("explain", "one.yaml", "--store", "world.furrow", "--set", f"end_time={end}")["notes"]
            self.assertEqual(sum(".path: the drive ends" in note for note in notes), told, (end, notes))

    def test_a_path_without_any_ground_is_told(self):
        scene = ("scene: 1\ntime_step: 0.1\nend_time: 4\nspacing: 0.5\noutside: skip\nredistribute: {model: box}\nobjects:\n"
                 "  - {name: off, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[-50, -50], [-50, -40]], speed: 5}}\n"
                 "  - {name: half, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[-5, 20], [10, 20]], speed: 5}}\n")
        self.scene(scene, "off.yaml")
        told = self.notes("had no ground", "--overlay", "w.furrow", scene="off.yaml")
        self.assertEqual(len(told), 2, told)
        run = json.loads((self.folder / "out/run.json").read_text())
        self.assertRegex(told[1], f"objects.half.path: {run['objects']['half']['skipped']} of 31 path samples had no ground, so the object pressed nothing there; ")
        self.assertRegex(told[0], f"objects.off.path: all {run['objects']['off']['skipped']} path samples had no ground, ")
        self.assertEqual([f"furrow: note: {note}" for note in run["notes"] if "had no ground" in note], told)

    def test_what_touches_nothing_and_black_pictures_are_told_at_the_end(self):
        (self.folder / "foot.obj").write_text("v 0 0 0\nv 0.02 0 0\nv 0 0.02 0\nv 0 0 0.02\nf 3 2 1\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        (self.folder / "aloft.csv").write_text("t,x,y,z\n0,20,30,900\n1,22,30,900\n")
        self.scene("scene: 1\ntime_step: 0.02\nend_time: 1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nobjects:\n"
                   "  - {name: foot, shape: {mesh: {file: foot.obj, scale: 0.1}}, load: 500, path: {points: [[20.1, 30.1]], speed: 1}}\n"
                   "  - {name: bird, shape: {sphere: {radius: 1}}, path: {file: aloft.csv}}\n"
                   "  - {name: stone, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[40, 40]], speed: 1}}\n"
                   "view: {camera: {fixed: {eye: [128, 128, 110], target: [129, 128, 0]}}, size: [64, 48], images: 25}\n", "end.yaml")
        mesh = "this build reads no meshes" not in self.furrow("explain", "end.yaml").stderr
        without = () if mesh else ("--set", "objects.foot.shape={sphere: {radius: 0.01}}")
        night = ("--set", "view.sun={time: 2026-11-27T00:30:00Z, at: [0, 50]}")
        told = self.notes("", "--overlay", "a.furrow", *night, *without, scene="end.yaml")
        run = json.loads((self.folder / "out/run.json").read_text())
        end = [note.removeprefix("furrow: note: ") for note in told if "left nothing" in note or "is black" in note]
        self.assertEqual([note for note in run["notes"] if "left nothing" in note or "is black" in note], end)
        foot, bird, black = end
        self.assertRegex(foot, r"^objects\.foot: no post was below it in any of its 1 path samples, so nothing bore its load, and it left nothing: it is 0\.0\d+ m large, "
                               r"and posts are 0\.25 m apart; give a finer spacing" + (r", or another shape\.mesh\.scale" if mesh else "$"))
        self.assertRegex(bird, r"^objects\.bird: it touched the ground in none of its \d+ path samples, and left nothing; lower the z of its path")
        self.assertRegex(black, r"^frame-000025\.png: is black, and 1 more: [\d.]+ % of its pixels are darker than 11 of 255: the sun is 59\.9 degrees below the horizon, so "
                                r"nothing is lit, and no exposure helps; give another time in view\.sun\.time$")
        self.assertEqual(run["view"]["black"], 2)
        low = ("--set", "view.sun.height=0.2", "--set", "view.body=moon")
        self.synth("flat.furrow", kind="plain", relief=0)
        flat = {"scene": "end.yaml", "store": ("--store", "flat.furrow")}
        black, = self.notes("is black", "--overlay", "b.furrow", *low, *without, **flat)
        self.assertRegex(black, r"the sun is only 0\.2 degrees high, and lights little; view\.exposure: sun makes pictures \d+ times as bright$")
        self.assertEqual(self.notes("is black", "--overlay", "b.furrow", *low, "--set", "view.exposure=sun", *without, **flat), [])

    def test_a_path_that_turns_far_from_row_to_row_is_told(self):
        (self.folder / "spin.csv").write_text("t,x,y,z,yaw,pitch,roll\n" + "".join(f"{i / 10},{20 + i / 20},30,1,{170 * i},0,0\n" for i in range(201)))
        self.scene("scene: 1\ntime_step: 0.02\nend_time: 20\nspacing: 0.0625\nobjects:\n"
                   "  - {name: box, shape: {box: {size: [2, 1, 0.5]}}, path: {file: spin.csv}}\n", "spin.yaml")
        explained = self.json("explain", "spin.yaml", "--store", "world.furrow")
        note, = [note for note in explained["notes"] if "path samples" in note]
        self.assertRegex(note, rf"^objects\.box\.path: has {explained['stations']['box']} path samples, each a contact: \d+ times as many as there are posts on its way of 10 m, "
                               r"since it turns by up to 170 degrees from one row to the next; look at its angles, which are in degrees, or give a coarser spacing$")
        (self.folder / "spin.csv").write_text("t,x,y,z,yaw,pitch,roll\n" + "".join(f"{i / 10},{20 + i / 20},30,1,{2 * i},0,0\n" for i in range(201)))
        self.assertEqual([note for note in self.json("explain", "spin.yaml", "--store", "world.furrow")["notes"] if "path samples" in note], [])

    def test_few_posts_below_a_wheel_are_told(self):
        self.scene(SCM, "scm.yaml")
        told = self.notes("forces may be off", "--overlay", "a.furrow", "--set", "spacing=0.125", "--steps", "1", scene="scm.yaml")
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], r"objects\.a\.shape: the soil bears it over about 0\.\d+ m, [\d.]+ posts: forces may be off by about \d+ % here; at 0\.[\d]+ m by \d+ %$")
        explained = self.json("explain", "scm.yaml", "--store", "world.furrow", "--set", "spacing=0.125")["notes"]
        self.assertEqual([note for note in explained if "forces may be off" in note], [told[0].removeprefix("furrow: note: ")])
        explained = self.json("explain", "scm.yaml", "--store", "world.furrow", "--set", "spacing=0.0078125")["notes"]
        self.assertEqual([note for note in explained if "forces may be off" in note], [])

    def test_a_blade_thinner_than_the_posts_are_apart_is_told(self):
        self.synth("plain.furrow", posts="161x161", spacing=0.5, kind="plain", relief=0.2)
        scene = pathlib.Path(__file__).parents[2] / "tools" / "scenes" / "vehicles" / "dozer.yaml"
        for spacing, told in ((0.0625, ["vehicles.dozer.blade: is 0.04 m across, and posts are 0.0625 m apart: it can pass between them and leave nothing; give a spacing of at most 0.04"]), (0.03125, [])):
            result = self.furrow("explain", scene, "--store", "plain.furrow", "--set", f"spacing={spacing}", "--json")
            if result.returncode == 4 or "this build has no MuJoCo" in result.stderr:
                self.skipTest(result.stderr.strip())
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual([note for note in json.loads(result.stdout)["notes"] if "pass between them" in note], told)


if __name__ == "__main__":
    main()
