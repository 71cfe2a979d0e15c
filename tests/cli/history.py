"""branch, snapshot, log, restore, drive --keep-history: a store goes back to what it was, and forward again."""
import datetime
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import SCENE, FurrowTest, long, main
from store_reader import Store

OTHER = SCENE.replace("[120, 90]", "[200, 60]").replace("[122, 88]", "[202, 58]")


class History(FurrowTest):
    def content(self, store):
        """Every post of every plane: two stores with the same are the same ground."""
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        info = self.json("info", store)
        self.ok("export", store, "-o", "content.png", "--layer", "surface", "--level", "-1")
        return check["offset_sum"], info["tiles"], info["soil"], info["compacted"], (self.folder / "content.png").read_bytes()

    def test_history_restored_is_the_run_that_stopped_there(self):
        for name in ("kept", "stopped"):
            self.synth(f"{name}.furrow")
        scene = self.scene()
        self.drive(scene, "--store", "kept.furrow", "--keep-history")
        self.drive(self.scene(OTHER, "other.yaml"), "--store", "kept.furrow", "--keep-history", "--steps", "40")
        last = self.content("kept.furrow")
        log = self.json("log", "kept.furrow")["revisions"]
        self.assertEqual([revision["revision"] for revision in log], list(range(log[0]["revision"], -1, -1)))
        self.assertEqual([revision["present"] for revision in log], [True] + [False] * (len(log) - 1))
        self.assertEqual((log[0]["step"], pathlib.Path(log[0]["what"]).name), (40, "other.yaml"))
        self.assertLess(abs(datetime.datetime.fromisoformat(log[0]["when"]) - datetime.datetime.now(datetime.timezone.utc)),
                        datetime.timedelta(minutes=10))
        # Every revision of the first drive, beside a drive that stopped at its step.
        first = [revision for revision in log if pathlib.Path(revision["what"]).name == "scene.yaml" and revision["step"] > 0]
        self.assertGreater(len(first), 0)
        for revision in first:
            self.ok("restore", "kept.furrow", revision["revision"])
            self.ok("reset", "stopped.furrow")
            self.drive(scene, "--store", "stopped.furrow", "--steps", revision["step"])
            self.assertEqual(self.content("kept.furrow"), self.content("stopped.furrow"))
            self.assertEqual(self.json("info", "kept.furrow")["last_run"]["step"], revision["step"])
        # As imported, and back to the end.
        self.ok("restore", "kept.furrow", "0")
        self.ok("reset", "stopped.furrow")
        self.assertEqual(self.content("kept.furrow"), self.content("stopped.furrow"))
        self.ok("restore", "kept.furrow", log[0]["revision"])
        self.assertEqual(self.content("kept.furrow"), last)
        self.assertIn("already", self.ok("restore", "kept.furrow", self.json("log", "kept.furrow")["revisions"][0]["revision"]))
        # What that costs is told, and the second reader finds the same in the file.
        history = self.json("info", "kept.furrow")["history"]
        self.assertEqual(history["revisions"], len(self.json("log", "kept.furrow")["revisions"]) - 1)
        self.assertGreater(history["bytes"], 0)
        store, revision = Store(self.folder / "kept.furrow"), first[0]["revision"]
        self.ok("restore", "kept.furrow", revision)
        then = Store(self.folder / "kept.furrow")
        keys = {key for key in set(store.rows["offset"]) | set(then.rows["offset"]) if key >> 56 == then.working + 32}
        for key in sorted(keys):
            row = then.rows["offset"].get(key)
            self.assertEqual(store.posts_then("offset", key, revision), list(row.posts) if row else [0] * (store.cells + 1)**2)

    @long
    def test_a_run_goes_on_from_what_is_restored(self):
        store, scene = self.synth(), self.scene()
        self.drive(scene, "--store", store, "--steps", "30")
        self.ok("snapshot", store, "half")
        self.drive(scene, "--store", store, "--resume")
        whole = self.content(store)
        self.ok("restore", store, "half")
        self.assertEqual(self.json("info", store)["last_run"]["step"], 30)
        self.drive(scene, "--store", store, "--resume")
        self.assertEqual(self.content(store), whole)

    def test_branches_and_names_are_told(self):
        store, scene = self.synth(), self.scene()
        self.drive(scene, "--store", store, "--steps", "30")
        self.ok("snapshot", store, "half")
        for name in ("a", "b", "c"):
            self.ok("branch", store, f"{name}.furrow")
        self.drive(self.scene(OTHER, "other.yaml"), "--store", "a.furrow", "--keep-history")
        self.ok("branch", "a.furrow", "d.furrow")
        log = self.json("log", store)
        revision = log["revisions"][0]["revision"]
        self.assertEqual(log["revisions"][0]["names"], ["half"])
        self.assertEqual(log["branches"], [{"file": str(self.folder.resolve() / f"{name}.furrow"), "revision": revision} for name in "abc"])
        files = [entry["file"] for entry in self.json("log", "d.furrow")["revisions"]]
        self.assertEqual(list(dict.fromkeys(pathlib.Path(file).name for file in files)), ["d.furrow", "a.furrow", "world.furrow"])
        self.assertIn("* ", self.ok("log", "d.furrow"))
        # A branch returns to where it began, by its parent's name for that. What depends on it stays as it was.
        deep = self.content("d.furrow")
        before = self.content(store)
        self.ok("restore", "a.furrow", "half")
        self.assertEqual(self.content("a.furrow"), before)
        self.assertEqual(self.content("d.furrow"), deep)
        self.assertIn("never driven", self.ok("log", self.synth("bare.furrow", posts="65x65")))

    def test_what_cannot_be_is_refused(self):
        store = self.synth(posts="65x65")
        self.refused(3, "branch", store, store)
        self.refused(3, "branch", "absent.furrow", "x.furrow")
        self.refused(2, "branch", store)
        self.refused(2, "snapshot", store)
        self.assertIn("names no snapshot", self.refused(3, "snapshot", store, "12"))
        self.refused(3, "snapshot", "absent.furrow", "x")
        self.ok("snapshot", store, "x")
        self.assertIn("already", self.refused(3, "snapshot", store, "x"))
        self.assertIn("keeps no revision 7", self.refused(3, "restore", store, "7"))
        self.assertIn("keeps no snapshot y", self.refused(3, "restore", store, "y"))
        self.refused(3, "log", "absent.furrow")
        self.assertFalse((self.folder / "x.furrow").exists())
        self.assertEqual(self.json("info", store)["history"], {"revisions": 1, "snapshots": 1, "rows": 0, "bytes": 0})
        self.assertIn("1 snapshot", self.refused(3, "reset", store))
        self.assertIn("1 snapshot; that is lost now", self.furrow("reset", store, "--force").stderr)
        self.assertEqual(self.json("info", store)["history"]["revisions"], 0)


if __name__ == "__main__":
    main()
