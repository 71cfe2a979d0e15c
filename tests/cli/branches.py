"""merge, relink, flatten: overlays are joined, find a base that was moved, and become one store with it."""
import json
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import SCENE, FurrowTest, long, main, sampled

EAST = SCENE.replace("[[20, 20], [120, 90], [40, 130]]", "[[160, 30], [230, 60], [170, 110]]").replace(
    "[[22, 18], [122, 88], [42, 128]]", "[[162, 28], [232, 58], [172, 108]]")

class Branches(FurrowTest):
    def sums(self, store):
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        return check["offset_sum"]


class Merge(Branches):
    def content(self, store):
        self.ok("export", store, "-o", "surface.r16", "--level", "-2", "--height-range", "-2,60")
        info = self.json("info", store)
        return self.sums(store), info["tiles"], info["soil"], info["compacted"], (self.folder / "surface.r16").read_bytes()

    def branches(self, **drives):
        for name, scene in drives.items():
            self.ok("branch", "world.furrow", f"{name}.furrow")
            self.drive(scene, "--store", f"{name}.furrow")

    def test_two_drives_over_disjoint_ground_are_both_in_one_store(self):
        self.synth()
        west, east = self.scene(), self.scene(EAST, "east.yaml")
        self.drive(self.scene(SCENE.replace("end_time: 4", "end_time: 1"), "before.yaml"), "--store", "world.furrow")
        shutil.copy(self.folder / "world.furrow", self.folder / "both.furrow")
        self.branches(a=west, b=east)
        for scene in (west, east):
            self.drive(scene, "--store", "both.furrow")
        self.assertIn("ab.furrow", self.ok("merge", "a.furrow", "b.furrow", "-o", "ab.furrow"))
        told = self.json("merge", "b.furrow", "a.furrow", "-o", "ba.furrow")
        self.assertEqual(told, {"file": "ba.furrow", "level": -2, "posts": 0, "places": 0, "both_changed": []})
        both = self.content("both.furrow")
        for name in ("ab.furrow", "ba.furrow"):
            self.assertEqual(self.content(name), both)
            self.assertEqual(pathlib.Path(self.json("info", name)["parent"]["path"]).name, "world.furrow")
        self.assertIn("merge", self.json("log", "ab.furrow")["revisions"][0]["what"])

    def test_what_both_changed_is_listed_and_nothing_is_made(self):
        self.synth()
        # The same ways in two depths: they meet everywhere along the ruts of a wheel, and nowhere else.
        self.branches(a=self.scene(), b=self.scene(SCENE.replace("sink: 0.15", "sink: 0.2"), "deep.yaml"))
        result = self.furrow("merge", "a.furrow", "b.furrow", "-o", "ab.furrow", "--json")
        self.assertIn("changed the same ground", self.told(3, result))
        told = json.loads(result.stdout)
        self.assertIsNone(told["file"])
        self.assertGreater(told["posts"], 100)
        self.assertEqual(len(told["both_changed"]), min(told["places"], 20))
        lines = self.furrow("merge", "a.furrow", "b.furrow", "-o", "ab.furrow").stdout.splitlines()
        self.assertGreaterEqual(len(lines), len(told["both_changed"]))
        for line, (west, south, east, north) in zip(lines, told["both_changed"]):
            self.assertEqual(line, f"both changed {west:g},{south:g},{east:g},{north:g}")
            self.assertTrue(15 <= west <= east <= 125 and 15 <= south <= north <= 135, line)
        self.assertEqual(list(self.folder.glob("ab*")), [])

    def test_what_cannot_be_merged_is_refused_and_nothing_is_left(self):
        self.synth(posts="65x65")
        self.synth("other.furrow", posts="129x129")
        for name, base in (("a", "world"), ("b", "world"), ("c", "other")):
            self.ok("branch", f"{base}.furrow", f"{name}.furrow")
        before = {path: path.read_bytes() for path in self.folder.iterdir()}
        for pair, told in ((["a", "b"], "drive them"), (["a", "c"], "another base"), (["world", "a"], "whole store"), (["a", "absent"], "No such file")):
            with self.subTest(pair=pair):
                self.assertIn(told, self.refused(3, "merge", *(f"{name}.furrow" for name in pair), "-o", "x.furrow", "--json"))
        self.refused(2, "merge", "a.furrow", "b.furrow")
        self.refused(2, "merge", "a.furrow", "-o", "x.furrow")
        self.assertEqual({path: path.read_bytes() for path in self.folder.iterdir()}, before)


class Relink(Branches):
    @long
    def test_after_a_move_every_command_names_relink_and_it_mends(self):
        store, scene = self.synth(), self.scene()
        self.drive(scene, "--store", store, "--steps", "20")
        self.ok("branch", store, "a.furrow")
        self.drive(scene, "--store", "a.furrow", "--resume")
        self.ok("branch", "a.furrow", "b.furrow")
        before = self.sums("b.furrow")
        (self.folder / "elsewhere").mkdir()
        shutil.move(store, self.folder / "elsewhere/renamed.furrow")
        for command in (["info", "a.furrow"], ["verify", "b.furrow"], ["query", "b.furrow", "70", "55"], ["log", "b.furrow"],
                        ["export", "a.furrow", "-o", "x.png"], ["branch", "b.furrow", "c.furrow"], ["restore", "a.furrow", "1"],
                        ["drive", scene, "--store", "b.furrow", "-o", "out2"], ["reset", "a.furrow"], ["snapshot", "b.furrow", "x"]):
            with self.subTest(command=command):
                told = self.refused(3, *command)
                self.assertIn("No such file", told)
                self.assertIn("furrow relink", told)
        self.assertIn("elsewhere/renamed.furrow", self.ok("relink", "a.furrow", "elsewhere/renamed.furrow"))
        self.assertEqual(self.sums("b.furrow"), before)
        # Both in one folder are moved together: there is nothing to mend.
        (self.folder / "again").mkdir()
        for name in ("a.furrow", "b.furrow", "elsewhere"):
            shutil.move(self.folder / name, self.folder / "again" / name)
        self.assertEqual(self.sums("again/b.furrow"), before)
        # From another folder, by a path from there.
        self.ok("relink", "../a.furrow", "renamed.furrow", cwd=self.folder / "again/elsewhere")
        self.assertEqual(self.sums("again/b.furrow"), before)

    def test_what_is_not_the_base_is_refused_and_the_overlay_kept(self):
        store = self.synth(posts="129x129")
        other = self.synth("other.furrow", posts="65x65")
        self.ok("branch", store, "a.furrow")
        before = (self.folder / "a.furrow").read_bytes()
        for arguments, told in sampled(((["a.furrow", other], "another one"), (["a.furrow", "absent.furrow"], "No such file"),
                                (["a.furrow", "a.furrow"], "overlay itself"), ([store, other], "store of its own"),
                                (["absent.furrow", store], "No such file"))):
            with self.subTest(arguments=arguments):
                self.assertIn(told, self.refused(3, "relink", *arguments))
        self.refused(2, "relink", "a.furrow")
        self.refused(2, "relink", "a.furrow", store, other)
        self.assertEqual((self.folder / "a.furrow").read_bytes(), before)
        (self.folder / "a.furrow").chmod(0o444)
        if os.geteuid() != 0:  # for root every file can be written
            self.assertIn("writable", self.refused(1, "relink", "a.furrow", store))


class Flatten(Branches):
    @long
    def test_a_chain_and_its_flat_store_are_the_same_ground(self):
        store, scene = self.synth(), self.scene()
        self.drive(scene, "--store", store, "--steps", "20")
        self.ok("branch", store, "a.furrow")
        self.drive(scene, "--store", "a.furrow", "--resume", "--steps", "20")
        self.ok("branch", "a.furrow", "b.furrow")
        self.assertIn("flat.furrow", self.ok("flatten", "b.furrow", "-o", "flat.furrow"))
        flat, chain = self.json("info", "flat.furrow"), self.json("info", "b.furrow")
        self.assertEqual((flat["base"], flat["parent"], flat["overlays"]), (None, None, 0))
        for key in set(chain) - {"base", "bytes", "overlays", "parent"}:
            self.assertEqual(flat[key], chain[key], key)
        self.assertEqual({**flat["bytes"], "file": 0}, {**chain["bytes"], "file": 0})
        for name in ("flat", "b"):
            self.drive(scene, "--store", f"{name}.furrow", "--resume")
        sums = self.sums("b.furrow")
        store.unlink()
        self.assertEqual(self.sums("flat.furrow"), sums)
        self.assertEqual(sorted(path.name for path in self.folder.glob("flat*")), ["flat.furrow"])

    def test_what_cannot_be_flattened_is_refused_and_nothing_is_left(self):
        store = self.synth(posts="129x129")
        self.ok("branch", store, "a.furrow")
        other = self.synth("other.furrow", posts="65x65")
        (self.folder / "dem.tif").write_bytes(b"a DEM")
        before = {path: path.read_bytes() for path in self.folder.iterdir()}
        for arguments, told in sampled((([store, "-o", "x.furrow"], "store of its own"), (["absent.furrow", "-o", "x.furrow"], "No such file"),
                                (["a.furrow", "-o", other], "--overwrite"), (["a.furrow", "-o", "nowhere/x.furrow"], "No such file"),
                                (["a.furrow", "-o", store, "--overwrite"], "file of the chain"),
                                (["a.furrow", "-o", "a.furrow", "--overwrite"], "file of the chain"),
                                (["a.furrow", "-o", "dem.tif", "--overwrite"], "no Furrow store"))):
            with self.subTest(arguments=arguments):
                self.assertIn(told, self.refused(3, "flatten", *arguments))
        self.refused(2, "flatten", "a.furrow")
        self.refused(2, "flatten", "-o", "x.furrow")
        self.assertEqual({path: path.read_bytes() for path in self.folder.iterdir()}, before)
        self.ok("flatten", "a.furrow", "-o", other, "--overwrite")
        self.assertEqual(self.json("info", other)["base_hash"], self.json("info", store)["base_hash"])


if __name__ == "__main__":
    main()
