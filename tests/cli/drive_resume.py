"""drive --resume: where it goes on, where it begins, what it refuses. tests/laws/resume.py kills."""
import csv
import hashlib
import json
import pathlib
import shutil
import signal
import sqlite3
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, SCENE, FurrowTest, long, main, part, sampled, write_png16

NO_GL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json", "EGL_PLATFORM": "surfaceless"}
WHOLE = "ended steps simulated spacing working_level volume objects".split()


class Resume(FurrowTest):
    def setUp(self):
        super().setUp()
        self.store = self.synth()
        self.copies = 0

    def copy(self):
        """Another store that was never driven."""
        self.copies += 1
        return pathlib.Path(shutil.copy(self.store, self.folder / f"copy{self.copies}.furrow"))

    def rows(self, store):
        db = sqlite3.connect(store)
        found = [db.execute(sql).fetchall() for sql in (
            'SELECT key, low, high, below, above, codec, hash, blob FROM "offset" ORDER BY key',
            "SELECT key, low, high, codec, hash, blob FROM dirt ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM heaped ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM pressed ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM shear ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM dug ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM settled ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM loose ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM floor ORDER BY key",
            "SELECT key, low, high, codec, hash, blob FROM density ORDER BY key",
            "SELECT value FROM meta WHERE key = 'compacted'")]
        db.close()
        self.assertGreater(len(found[0]), 1)
        return found

    def kept(self, store):
        """All that a drive changes; the file's header counts openings too."""
        db = sqlite3.connect(store)
        run = db.execute("SELECT id, epoch, scene_hash, step, time, state FROM run").fetchall()
        db.close()
        return self.rows(store), run, self.log(), (self.folder / "out/run.json").read_text()

    def assert_same(self, a, b):
        """Reports and stores."""
        for key in WHOLE:
            self.assertEqual(a[0][key], b[0][key])
        self.assertTrue(self.rows(a[1]) == self.rows(b[1]))

    def pieces(self, scene, store, *pieces):
        """Driven with these options one after the other, all but the first resumed."""
        report = None
        for i, options in enumerate(pieces):
            before = report["steps"] if report else None
            report = self.drive(scene, "--store", store, *(["--resume"] if i > 0 else []), *options)
            self.assertEqual(report["resumed_from"], before)
        return report, store

    def log(self):
        return [line.split() for line in (self.folder / "out/epochs.log").read_text().splitlines()]

    def test_in_pieces_it_is_what_it_is_in_one_go(self):
        for step in (0.05, 0.37):
            scene = self.scene(SCENE.replace("time_step: 0.05", f"time_step: {step}"))
            whole = self.pieces(scene, self.copy(), [])
            self.assertEqual(whole[0]["steps"], 80 if step == 0.05 else 11)
            in_pieces = self.pieces(scene, self.copy(), ["--steps", 1], ["--steps", 2], ["--steps", 7],
                                    ["--set", "cache.slots=4", "--set", "cache.prefetch=0"])
            self.assert_same(in_pieces, whole)
            log = self.log()
            self.assertEqual([int(step) for _, _, _, step in log if step != "0"][:3], [1, 2, 7])
            self.assertEqual([int(epoch) for _, epoch, _, _ in log], list(range(1, len(log) + 1)))

    def test_the_ground_slides_on_around_what_carries_a_load(self):
        scene = self.scene("""scene: 1
time_step: 0.05
end_time: 3
spacing: 0.125
soil: {name: dry_sand, repose: 5}
redistribute: {model: scm, interval: 0.02, iterations: 2}
objects:
  - {name: ball, shape: {sphere: {radius: 0.9}}, load: 60000, path: {points: [[20, 20], [30, 20]], speed: 0.3}}
cache: {slots: 16}
""")
        whole = self.pieces(scene, self.copy(), [])
        self.assertNotEqual(whole[0]["objects"]["ball"]["z"], 0)
        in_pieces = self.pieces(scene, self.copy(), ["--steps", 1], ["--steps", 2], ["--steps", 11], ["--steps", 30], [])
        self.assert_same(in_pieces, whole)
        with sqlite3.connect(in_pieces[1]) as db:
            db.execute("UPDATE run SET state = json_set(state, '$.objects[0].force.z', '4611686018427387904')")
        db.close()
        self.assertIn("stands where it cannot", self.refused(3, "drive", scene, "--store", in_pieces[1], "-o", "out", "--resume"))

    def test_a_model_without_forces_has_rows_of_where_its_objects_are(self):
        for model in part(("box", "none", "sumner", "slippage"), 0):
            scene = self.scene(SCENE.replace("{model: box}", f"{{model: {model}}}\nsoil: {{name: dry_sand}}\noutput: {{forces: 7}}"))
            self.pieces(scene, self.copy(), [])
            rows = (self.folder / "out/objects.csv").read_text()
            self.pieces(scene, self.copy(), ["--steps", 1], ["--steps", 9], [])
            self.assertEqual((self.folder / "out/objects.csv").read_text(), rows)
            found = list(csv.DictReader(rows.splitlines()))
            self.assertEqual([(float(row["t"]), row["name"]) for row in found],
                             [(float(f"{i / 7:.9g}"), name) for i in range(29) for name in ("left", "right")])
            for row in found:
                self.assertAlmostEqual(float(row["sinkage"]), 0.15, delta=1e-5)
                self.assertEqual({row[name] for name in ("fx", "fy", "fz", "tx", "ty", "tz", "contact_area", "residual")}, {"nan"})
                self.assertEqual(row["state"], "touching")
            self.assertEqual((float(found[0]["x"]), float(found[0]["y"])), (20, 20))
            self.assertGreater(float(found[-1]["x"]), 100)
            self.ok("report", "out", "-o", "out.html")

    def test_nothing_is_awake_without_objects(self):
        scene = self.scene("scene: 1\ntime_step: 0.1\nend_time: 1\nspacing: 0.25\nsoil: {name: dry_sand}\n"
                           "redistribute: {model: slippage}\nview: {size: [64, 64], camera: {fixed: {eye: [20, 20, 200], target: [60, 60, 0]}}, images: 5}\n")
        self.drive(scene, "--store", self.store, "--steps", 5)
        with sqlite3.connect(self.store) as db:
            db.execute("UPDATE run SET state = json_set(state, '$.awake', '0,0;')")
        db.close()
        self.assertIn("awake", self.refused(3, "drive", scene, "--store", self.store, "-o", "out", "--resume"))

    @long
    def test_a_scene_that_ends_later_now_goes_on(self):
        # 1 s is 2.7 steps: the third is done to its end.
        for step, first, total in ((0.05, 20, 80), (0.37, 3, 11)):
            scene = self.scene(SCENE.replace("time_step: 0.05", f"time_step: {step}"))
            whole = self.pieces(scene, self.copy(), [])
            store = self.copy()
            report = self.drive(scene, "--store", store, "--set", "end_time=1")
            self.assertEqual(report["steps"], first)
            self.assertEqual(report["simulated"], 1)
            report = self.drive(scene, "--store", store, "--resume", "--set", "end_time=1.05")
            self.assertEqual(report["simulated"], 1.05)
            report = self.drive(scene, "--store", store, "--resume")
            self.assertEqual(report["steps"], total)
            self.assert_same((report, store), whole)

    @long
    def test_a_step_that_was_cut_short_leaves_the_picture_before_it(self):
        view = "view: {size: [160, 90], camera: {overhead: {over: left, height: 40}}, effects: [texture], images: 1}\n"
        scene = self.scene(SCENE.replace("time_step: 0.05", "time_step: 0.37") + view)
        self.drive(scene, "--store", self.store, "--set", "end_time=1")
        pictures = [self.folder / f"out/frame-{step:06}.png" for step in (1, 2)]
        before = [hashlib.sha256(picture.read_bytes()).hexdigest() for picture in pictures]
        self.drive(scene, "--store", self.store, "--resume")
        self.assertEqual([hashlib.sha256(picture.read_bytes()).hexdigest() for picture in pictures], before)

    def test_where_nothing_was_driven_it_begins(self):
        scene = self.scene()
        whole = self.pieces(scene, self.copy(), [])
        for options, driven in (([], self.store), (["--overlay", "over.furrow"], self.folder / "over.furrow")):
            result = self.furrow("drive", scene, "--store", self.store, *options, "-o", "out", "--resume", "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("note: ", result.stderr)
            self.assertIn("step 0", result.stderr)
            report = json.loads(result.stdout)
            self.assertIsNone(report["resumed_from"])
            self.assert_same((report, driven), whole)
            self.ok("reset", self.store)

    def test_on_a_fresh_branch_of_a_driven_store_it_begins(self):
        text = """scene: 1
time_step: 0.1
end_time: 1
spacing: 0.5
soil: {name: dry_sand}
redistribute: {model: scm}
objects:
  - {name: ball, shape: {sphere: {radius: 2}}, sink: 0.1, path: {points: [[20, 20], [40, 30]], speed: 5}}
"""
        first, other = self.scene(text), self.scene(text.replace("0.1, path", "0.3, path"), "other.yaml")
        another = self.copy()
        self.drive(first, "--store", self.store)
        for name in ("a", "b"):
            self.ok("branch", self.store, f"{name}.furrow")
        begins = r"a\.furrow: nothing was driven there: the drive that it begins with is of another scene, or has ended; begins at step 0"
        self.assertRegex(self.furrow("drive", other, "--store", "a.furrow", "-o", "out", "--resume", "--steps", "3").stderr, begins)
        # From its first commit on the record is the branch's own.
        self.assertEqual(self.drive(other, "--store", "a.furrow", "--resume")["resumed_from"], 3)
        self.assertIn("resume with the same scene and the same --set",
                      self.refused(3, "drive", first, "--store", "a.furrow", "-o", "out", "--resume"))
        self.drive(other, "--store", "b.furrow")
        self.assertIsNone(self.drive(other, "--store", self.store, "--overlay", "new.furrow", "--resume", "--set", "output.forces=10")["resumed_from"])
        for name in ("a", "new"):
            self.assertTrue(self.rows(self.folder / f"{name}.furrow") == self.rows(self.folder / "b.furrow"), name)
        # In another folder, the rows of the steps before are missing.
        for store, folder, told in (("a", "elsewhere", True), ("new", "out", False)):
            result = self.furrow("drive", other, "--store", f"{store}.furrow", "-o", folder, "--resume", "--set", "end_time=1.5", "--set", "output.forces=10")
            self.assertEqual(f"{folder}/objects.csv: has no rows of the steps up to 10" in result.stderr, told, result.stderr)
        # The same terrain with other ruts is another store.
        self.drive(other, "--store", another)
        self.assertIn("it is an overlay of", self.refused(3, "drive", other, "--store", another, "--overlay", "a.furrow", "-o", "out", "--resume"))
        # The same scene goes on where its parent's drive ended, after a reset too; if there is a step left.
        self.ok("reset", "b.furrow")
        self.ok("branch", "b.furrow", "c.furrow")
        self.assertIsNone(self.drive(first, "--store", "c.furrow", "--resume")["resumed_from"])
        self.assertEqual(self.drive(first, "--store", "b.furrow", "--resume", "--set", "end_time=2")["resumed_from"], 10)

    def test_parts_of_many_processes_that_are_damaged_are_told_with_what_to_do(self):
        scene = self.scene("{scene: 1, time_step: 0.1, end_time: 1, spacing: 1, soil: {name: dry_sand}, redistribute: {model: scm}, objects: [{name: a, "
                           "shape: {sphere: {radius: 2}}, sink: 0.1, path: {points: [[20, 20], [40, 30]], speed: 5}}]}")
        drive = ["drive", scene, "--store", self.store, "--overlay", "a.furrow", "-o", "out", "--steps", "2"]
        self.ok(*drive)
        parts = self.folder / "a.furrow.parts"
        parts.mkdir()
        for content in (b"rubbish", (self.folder / "a.furrow").read_bytes()):
            (parts / "part-00000.furrow").write_bytes(content)
            self.assertRegex(self.refused(3, *drive, "--resume"),
                             r"a\.furrow\.parts/part-00000\.furrow: .*; put the part back, or remove a\.furrow\.parts, which gives up what that drive did$")
            self.assertEqual((parts / "part-00000.furrow").read_bytes(), content)
        shutil.rmtree(parts)
        parts.write_text("no folder")
        self.assertIn("remove it, if it is no folder of a drive", self.refused(1, *drive, "--resume"))

    def test_what_is_complete_is_left_as_it_is(self):
        scene = self.scene()
        report = self.drive(scene, "--store", self.store)
        before = self.kept(self.store)
        for options in ([], ["--set", "end_time=3"], ["--steps", 80], ["--steps", 12], ["--set", "cache.slots=9"]):
            # Nothing is drawn, nor is it asked whether it could be.
            result = self.furrow("drive", scene, "--store", self.store, "-o", "out", "--resume", "--json", *options, env=NO_GL)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stderr, "^furrow: note: .*step 80, 4 s, already.*\n$")
            again = json.loads(result.stdout)
            self.assertEqual(again["resumed_from"], 80)
            for key in WHOLE:
                self.assertEqual(again[key], report[key])
            self.assertTrue(self.kept(self.store) == before)
        # Killed after the last commit, a drive has not told.
        (self.folder / "out/run.json").unlink()
        self.ok("drive", scene, "--store", self.store, "-o", "out", "--resume")
        told = json.loads((self.folder / "out/run.json").read_text())
        self.assertEqual({key: told[key] for key in WHOLE}, {key: report[key] for key in WHOLE})

    def test_without_resume_it_begins_again(self):
        scene = self.scene()
        self.drive(scene, "--store", self.store, "--steps", 30)
        report = self.drive(scene, "--store", self.store)
        self.assertIsNone(report["resumed_from"])
        self.assertEqual(report["steps"], 80)
        self.assertEqual(self.log()[0][3], "0")
        self.assertEqual(len(self.log()), report["io"]["commits"])
        self.assertAlmostEqual(report["objects"]["left"]["distance"], 120, delta=1)

    @long
    def test_another_scene_is_refused_and_a_cache_or_a_view_is_no_other_scene(self):
        scene = self.scene()
        self.drive(scene, "--store", self.store, "--steps", 30)
        before = self.kept(self.store)
        for setting in ("time_step=0.1", "objects.left.sink=0.1", "redistribute.model=none", "outside=skip", "spacing=0.125"):
            error = self.refused(3, "drive", scene, "--store", self.store, "-o", "out", "--resume", "--set", setting)
            self.assertRegex(error, "without --resume|furrow reset")
            self.assertTrue(self.kept(self.store) == before)
        report = self.drive(self.scene(SCENE + "view: {size: [64, 64], camera: {overhead: {over: left, height: 40}}, images: 40}\n"), "--store", self.store, "--resume",
                            "--set", "cache.loaders=1")
        self.assertEqual((report["resumed_from"], report["steps"]), (30, 80))

    def test_a_damaged_record_is_refused_and_named(self):
        scene = self.scene()
        self.drive(scene, "--store", self.store, "--steps", 30)
        for change in sampled(("state = 'x'", "state = '{}'", "state = replace(state, 'left', 'lost')", "state = replace(state, '\"next\":\"', '\"next\":\"1')",
                       "state = replace(state, '\"in_contact\":true', '\"in_contact\":false')",
                       "state = replace(state, '\"x\":\"', '\"x\":\"9')", "state = replace(state, '\"y\":\"', '\"y\":\"-')",
                       "state = replace(state, '\"z\":\"', '\"z\":\"12')",
                       # Half a metre: a sweep from there is longer than any that the budget knows.
                       "state = json_set(state, '$.objects[0].x', CAST(json_extract(state, '$.objects[0].x') + 524288 AS TEXT))", "state = replace(state, '\"level\":\"-2', '\"level\":\"-1')",
                       "step = 29", "step = 31", "step = -1", "time = 1.49", "time = 1.51", "time = -1", "time = 1e300",
                       "step = 0, time = 0")):
            with self.subTest(change=change):
                damaged = pathlib.Path(shutil.copy(self.store, self.folder / "damaged.furrow"))
                db = sqlite3.connect(damaged)
                with db:
                    self.assertEqual(db.execute(f"UPDATE run SET {change}").rowcount, 1)
                db.close()
                before = self.kept(damaged)
                error = self.refused(3, "drive", scene, "--store", damaged, "-o", "other", "--resume")
                self.assertIn("damaged.furrow", error)
                self.assertIn("without --resume", error)
                self.assertTrue(self.kept(damaged) == before)
                self.assertFalse((self.folder / "other").exists())

    @long
    def test_soil_that_bore_by_another_law_is_not_gone_on_with(self):
        """A drive that goes on by another law than it began with is neither of the two."""
        scene = self.scene("""scene: 1
time_step: 0.05
end_time: 3
spacing: 0.25
soil: {name: dry_sand}
redistribute: {model: scm}
objects:
  - {name: ball, shape: {sphere: {radius: 0.9}}, load: 60000, path: {points: [[20, 20], [30, 20]], speed: 1}}
""")
        self.drive(scene, "--store", self.store, "--steps", 3)
        for change in ("json_set(state, '$.law', '1')", "json_remove(state, '$.law')", "json_set(state, '$.law', '99')"):
            with self.subTest(change=change):
                other = pathlib.Path(shutil.copy(self.store, self.folder / "other.furrow"))
                with sqlite3.connect(other) as db:
                    db.execute(f"UPDATE run SET state = {change}")
                db.close()
                before = self.kept(other)
                self.assertIn("whose soil bears otherwise", self.refused(3, "drive", scene, "--store", other, "-o", "other", "--resume"))
                self.assertEqual(self.kept(other), before)
                self.drive(scene, "--store", other, "--steps", 1)
        self.drive(scene, "--store", self.store, "--steps", 2, "--resume")

    def test_a_torn_line_is_dropped_and_the_others_are_kept(self):
        scene = self.scene()
        self.drive(scene, "--store", self.store, "--steps", 30)
        log = self.folder / "out/epochs.log"
        kept = log.read_text()
        log.write_text(kept + "epoch 3 st")
        self.drive(scene, "--store", self.store, "--resume", "--steps", 50)
        text = log.read_text()
        self.assertTrue(text.startswith(kept + "epoch 3 step "))
        self.assertTrue(text.endswith(" step 50\n"))
        shutil.rmtree(self.folder / "out")
        self.drive(scene, "--store", self.store, "--resume")
        self.assertEqual(self.log()[0][1], str(int(text.split()[-3]) + 1))

    def test_volume_csv_has_a_row_for_each_step_with_a_commit(self):
        """A drive with vehicles commits when it goes on, too, so there are two commits of that step. A drive goes on from step 0 if it was killed before its second commit."""
        cart = f"vehicles: [{{name: cart, model: {pathlib.Path(__file__).parents[1]}/vehicle/one_wheel.xml, start: {{at: [20, 20]}}}}]"
        bodies = {"objects": "objects: [{name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[20, 20], [24, 20]], speed: 2}}]"}
        if "vehicles: MuJoCo" in subprocess.run([FURROW, "--version"], capture_output=True, text=True).stdout:
            bodies["vehicles"] = cart
        store = self.synth("plain.furrow", spacing=0.25, kind="plain", relief=2)
        for name, body in bodies.items():
            with self.subTest(name):
                scene = self.scene(f"scene: 1\ntime_step: 0.002\nend_time: 0.1\nspacing: 0.125\nsoil: {{name: dry_sand}}\nredistribute: {{model: scm}}\n{body}\n")
                drive = lambda *more: self.drive(scene, "--store", store, "--overlay", f"{name}.furrow", "--keep-history", *more)
                drive("--steps", 10)
                self.assertEqual(self.json("log", f"{name}.furrow")["revisions"][1]["step"], 0)
                self.ok("restore", f"{name}.furrow", 1)
                drive("--resume", "--steps", 5)
                run = drive("--resume")
                with open(self.folder / "out/volume.csv", newline="") as file:
                    rows = list(csv.DictReader(file))
                steps = [int(row["step"]) for row in rows]
                self.assertEqual((steps[0], steps[-1]), (0, 50))
                self.assertIn(5, steps)
                self.assertEqual(steps, sorted(set(steps)))
                self.assertEqual([row[key] for row in rows[:1] for key in ("removed", "raised", "compacted")], ["0", "0", "0"])
                for key in ("removed", "raised", "compacted"):
                    self.assertAlmostEqual(float(rows[-1][key]), run["volume"][key], delta=1e-9)

    def test_interrupted_it_goes_on(self):
        scene = self.scene(SCENE.replace("end_time: 4", "end_time: 60").replace("speed: 30}", "speed: 30, loop: true}"))
        whole = self.pieces(scene, self.copy(), [])
        shutil.rmtree(self.folder / "out")
        log, done, resumed = self.folder / "out/epochs.log", 0, []
        for commits in (2, 1, 1):
            before = len(log.read_text().splitlines()) if resumed else 0
            process = subprocess.Popen([FURROW, "drive", scene, "--store", self.store, "-o", "out", *resumed], cwd=self.folder,
                                       stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
            self.until_committed(process, commits=before + commits)
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=280)
            report = json.loads((self.folder / "out/run.json").read_text())
            if report["ended"] == "complete":
                break
            self.assertEqual(process.returncode, 130, errors)
            self.assertEqual(report["resumed_from"], done if resumed else None)
            self.assertGreaterEqual(report["steps"], done)
            done, resumed = report["steps"], ["--resume"]
            self.assertEqual(self.json("info", self.store)["last_run"]["step"], done)
        if report["ended"] == "interrupted":  # begun anew over those ruts: told
            shutil.copy(self.folder / self.store, self.folder / "anew.furrow")
            told = self.furrow("drive", scene, "--store", "anew.furrow", "-o", "anew", "--steps", "1").stderr
            self.assertIn(f"driven to step {done} there and not to its end", told)
        report = self.drive(scene, "--store", self.store, "--resume")
        self.assert_same((report, self.store), whole)

    @long
    def test_a_drive_that_ran_out_of_ground_stops_there_again(self):
        write_png16(self.folder / "holes.png", 150, 150, lambda x, y: 0 if x > 80 else 100 + (x * 7 + y) % 5)
        self.ok("import", "holes.png", "-o", "holes.furrow", "--nodata", "0")
        scene = self.scene(SCENE.replace("outside", "").replace("[40, 130]", "[10, 130]"))
        skip = ["--set", "outside=skip"]
        self.drive(scene, "--store", self.store, "--steps", 1)  # skips without GL
        self.assertIn("no ground", self.refused(1, "drive", scene, "--store", "holes.furrow", "-o", "out"))
        stopped = json.loads((self.folder / "out/run.json").read_text())
        rows = self.rows(self.folder / "holes.furrow")
        self.assertIn("no ground", self.refused(1, "drive", scene, "--store", "holes.furrow", "-o", "out", "--resume"))
        again = json.loads((self.folder / "out/run.json").read_text())
        self.assertEqual(again["resumed_from"], stopped["steps"])
        for key in WHOLE:
            self.assertEqual(again[key], stopped[key])
        self.assertTrue(self.rows(self.folder / "holes.furrow") == rows)
        # Skipping, at every step over the hole and out of it.
        for name in ("whole", "pieces"):
            self.ok("import", "holes.png", "-o", f"{name}.furrow", "--nodata", "0")
        whole = self.pieces(scene, self.folder / "whole.furrow", skip)
        self.assertGreater(whole[0]["objects"]["left"]["skipped"], 0)
        in_pieces = self.pieces(scene, self.folder / "pieces.furrow", *([*skip, "--steps", n] for n in (39, 41, 58, 60, 61, 62)), skip)
        self.assert_same(in_pieces, whole)

    @long
    def test_a_picture_of_the_step_that_was_committed_is_not_left_out(self):
        scene = self.scene(SCENE + "view: {size: [64, 48], camera: {chase: left, back: 8, up: 4}, images: 20}\noutput: {map: true}\n")
        self.drive(scene, "--store", self.copy())
        out = self.folder / "out"
        self.assertTrue((out / "map.png").exists())  # it names its store, and so differs
        wanted = {path.name: hashlib.sha256(path.read_bytes()).digest() for path in out.glob("frame-*.png")}
        self.assertEqual(len(wanted), 4)
        shutil.rmtree(out)
        self.drive(scene, "--store", self.store, "--steps", 40)
        (out / "frame-000040.png").unlink()
        # So it is found when the kill came after the last step's commit, before that of the end.
        with sqlite3.connect(self.store) as db:
            db.execute("UPDATE run SET state = replace(state, '\"ended\":true', '\"ended\":false')")
        db.close()
        report = self.drive(scene, "--store", self.store, "--resume", "--steps", 40)
        self.assertEqual((report["ended"], report["resumed_from"], report["view"]["frames"]), ("complete", 40, 1))
        (out / "frame-000040.png").unlink()
        self.drive(scene, "--store", self.store, "--resume")
        self.assertEqual({path.name: hashlib.sha256(path.read_bytes()).digest() for path in out.glob("frame-*.png")}, wanted)
        self.assertTrue((out / "map.png").exists())


if __name__ == "__main__":
    main()
