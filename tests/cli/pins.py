"""Pins: what branches and overlays depend on is kept, whatever is done to their parent, or that is refused."""
import hashlib
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import SCENE, FurrowTest, main
from store_reader import Store

SHORT = SCENE.replace("end_time: 4", "end_time: 0.5")
OTHER = SHORT.replace("sink: 0.15", "sink: 0.25")


class Pins(FurrowTest):
    def setUp(self):
        super().setUp()
        self.synth("p.furrow", posts="129x129")
        self.a, self.b = self.scene(SHORT, "a.yaml"), self.scene(OTHER, "b.yaml")

    def seen(self, store):
        self.ok("export", store, "-o", "seen.png", "--level", "-2", "--layer", "surface")
        return hashlib.sha256((self.folder / "seen.png").read_bytes()).hexdigest(), self.json("verify", store)["ok"]

    def pins(self, store="p.furrow"):
        return {pathlib.Path(pin["file"]).name: (pin["revision"], pin["state"]) for pin in self.json("log", store)["pins"]}

    def test_a_branch_is_read_after_a_drive_of_its_parent(self):
        self.drive(self.a, "--store", "p.furrow")
        bytes_before = (self.folder / "p.furrow").read_bytes()
        self.ok("branch", "p.furrow", "q.furrow")
        self.drive(self.b, "--store", "q.furrow")
        self.drive(self.b, "--store", "p.furrow", "--overlay", "o.furrow")
        self.assertEqual((self.folder / "p.furrow").read_bytes(), bytes_before)
        self.ok("branch", "q.furrow", "r.furrow")
        before = {name: self.seen(name + ".furrow") for name in "qro"}
        self.drive(self.b, "--store", "p.furrow")
        self.drive(self.b, "--store", "q.furrow", "--set", "objects.left.sink=0.3")
        self.assertEqual({name: self.seen(name + ".furrow") for name in "ro"}, {name: before[name] for name in "ro"})
        revision = self.json("log", "q.furrow")["revisions"][-1]["revision"]
        self.assertEqual(self.pins(), {"q.furrow": (revision, "there"), "o.furrow": (revision, "there")})
        self.assertRegex(self.ok("log", "p.furrow"), rf"\npinned revision {revision} for \S+/q\.furrow\n")
        # The second reader, made from FORMAT.md alone, finds the state that each of them names.
        for name in "qro":
            Store(self.folder / f"{name}.furrow")
        self.assertEqual([Store(self.folder / name).version for name in ("p.furrow", "q.furrow", "r.furrow")], [8, 8, 8])
        # An overlay is opened by its parent's name, and drives go on in it.
        self.drive(self.a, "--store", "p.furrow", "--overlay", "o.furrow")
        self.assertIn("is over p.furrow", self.ok("relink", "q.furrow", "p.furrow"))
        self.ok("flatten", "r.furrow", "-o", "flat.furrow")
        self.assertEqual(self.seen("flat.furrow"), before["r"])
        # Looking writes nothing: neither a store nor a list.
        files = {path: path.read_bytes() for path in self.folder.glob("*.furrow*")}
        for command in (["log"], ["info"], ["verify"], ["query", "20", "20"], ["prune"]):
            self.ok(command[0], "p.furrow", *command[1:])
            self.ok(command[0], "r.furrow", *command[1:])
        self.assertEqual({path: path.read_bytes() for path in self.folder.glob("*.furrow*")}, files)

    def test_what_would_lose_a_branch_is_refused_and_force_says_what(self):
        self.drive(self.a, "--store", "p.furrow")
        self.ok("branch", "p.furrow", "q.furrow")
        self.ok("snapshot", "p.furrow", "early")
        self.ok("branch", "q.furrow", "r.furrow")
        self.ok("branch", "q.furrow", "s.furrow")
        before = self.seen("s.furrow")
        ways = (["reset", "p.furrow"],
                ["synth", "-o", "p.furrow", "--posts", "65x65", "--spacing", "1", "--overwrite"],
                ["flatten", "r.furrow", "-o", "p.furrow", "--overwrite"],
                ["flatten", "s.furrow", "-o", "q.furrow", "--overwrite"])
        for way in ways:
            with self.subTest(way):
                told = self.refused(3, *way)
                if "chain" not in told:  # a file of the chain is refused in any case
                    self.assertRegex(told, "1 overlay depends on it: q.furrow, and it has 1 snapshot, which would be lost; .*--force")
        self.assertEqual(self.seen("s.furrow"), before)
        self.ok("synth", "-o", "dem.tif", "--posts", "65x65", "--spacing", "1")
        told = self.furrow("import", "dem.tif", "-o", "p.furrow", "--overwrite", "--dry-run")
        self.assertIn("1 overlay depends on it: q.furrow, and it has 1 snapshot, which would be lost; without --force", told.stderr)
        self.assertFalse(list(self.folder.glob("*.part*")))
        for way in (["reset", "p.furrow"], ["synth", "-o", "p.furrow", "--posts", "65x65", "--spacing", "1", "--overwrite"]):
            shutil.copy(self.folder / "p.furrow", self.folder / "kept")
            lists = (self.folder / "p.furrow-pins").read_bytes()
            result = self.furrow(*way, "--force")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stderr, "1 overlay depends on it: q.furrow, and it has 1 snapshot; that is lost")
            self.assertFalse((self.folder / "p.furrow-pins").exists())
            self.refused(3, "info", "q.furrow")
            shutil.copy(self.folder / "kept", self.folder / "p.furrow")
            (self.folder / "p.furrow-pins").write_bytes(lists)

    def test_prune_tells_what_it_drops_and_finds_what_was_moved(self):
        (self.folder / "far").mkdir()
        self.drive(self.a, "--store", "p.furrow", "--overlay", "far/base.furrow")  # of the base alone, in another folder
        self.drive(self.a, "--store", "p.furrow")
        for name in ("q", "far/r", "s"):
            self.ok("branch", "p.furrow", f"{name}.furrow")
        self.drive(self.b, "--store", "p.furrow")
        before = self.seen("q.furrow")
        (self.folder / "q.furrow").rename(self.folder / "t.furrow")
        (self.folder / "far/r.furrow").rename(self.folder / "far/u.furrow")
        (self.folder / "s.furrow").unlink()
        states = [state for _, state in self.pins().values()]
        self.assertEqual(sorted(states), ["gone", "moved", "moved", "there"])
        told = self.ok("prune", "p.furrow")
        self.assertRegex(told, r"dropped  \S+/s\.furrow of revision \d+: ")
        self.assertEqual(told.count("moved  "), 2)
        self.assertIn("1 pin dropped, 3 stay", told)
        self.assertEqual(sorted(self.pins()), ["base.furrow", "t.furrow", "u.furrow"])
        self.assertEqual(self.seen("t.furrow"), before)
        for name in ("t.furrow", "far/u.furrow"):
            (self.folder / name).unlink()
        pruned = self.json("prune", "p.furrow")
        self.assertEqual((pruned["dropped"], sorted(pin["done"] for pin in pruned["pins"])), (2, ["dropped", "dropped", "stays"]))
        self.assertEqual(list(self.pins()), ["base.furrow"])
        self.refused(2, "prune")
        self.refused(3, "prune", "absent.furrow")
        # The base itself is what that one depends on.
        self.ok("reset", "p.furrow")
        self.assertIn("base.furrow", self.refused(3, "synth", "-o", "p.furrow", "--posts", "65x65", "--spacing", "1", "--overwrite"))

    def test_a_parent_that_cannot_be_told_says_so(self):
        self.drive(self.a, "--store", "p.furrow")
        (self.folder / "p.furrow-pins").mkdir()
        self.assertIn("p.furrow-pins: it is no list", self.refused(3, "branch", "p.furrow", "q.furrow"))
        self.assertFalse((self.folder / "q.furrow").exists())
        (self.folder / "p.furrow-pins").rmdir()
        self.ok("branch", "p.furrow", "q.furrow")
        (self.folder / "p.furrow-pins").unlink()
        self.drive(self.b, "--store", "p.furrow")
        self.assertRegex(self.refused(3, "info", "q.furrow"), "its parent .* has changed since: it was at revision")


if __name__ == "__main__":
    main()
