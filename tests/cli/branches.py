"""relink, flatten: overlays find a base that was moved, and become one store with it."""
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main

class Branches(FurrowTest):
    def sums(self, store):
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        return check["offset_sum"]


class Relink(Branches):
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
        for arguments, told in ((["a.furrow", other], "another base"), (["a.furrow", "absent.furrow"], "No such file"),
                                (["a.furrow", "a.furrow"], "overlay itself"), ([store, other], "store of its own"),
                                (["absent.furrow", store], "No such file")):
            with self.subTest(arguments=arguments):
                self.assertIn(told, self.refused(3, "relink", *arguments))
        self.refused(2, "relink", "a.furrow")
        self.refused(2, "relink", "a.furrow", store, other)
        self.assertEqual((self.folder / "a.furrow").read_bytes(), before)
        (self.folder / "a.furrow").chmod(0o444)
        if os.geteuid() != 0:  # for root every file can be written
            self.assertIn("writable", self.refused(1, "relink", "a.furrow", store))


class Flatten(Branches):
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
        for arguments, told in (([store, "-o", "x.furrow"], "store of its own"), (["absent.furrow", "-o", "x.furrow"], "No such file"),
                                (["a.furrow", "-o", other], "--overwrite"), (["a.furrow", "-o", "nowhere/x.furrow"], "No such file"),
                                (["a.furrow", "-o", store, "--overwrite"], "file of the chain"),
                                (["a.furrow", "-o", "a.furrow", "--overwrite"], "file of the chain"),
                                (["a.furrow", "-o", "dem.tif", "--overwrite"], "no Furrow store")):
            with self.subTest(arguments=arguments):
                self.assertIn(told, self.refused(3, "flatten", *arguments))
        self.refused(2, "flatten", "a.furrow")
        self.refused(2, "flatten", "-o", "x.furrow")
        self.assertEqual({path: path.read_bytes() for path in self.folder.iterdir()}, before)
        self.ok("flatten", "a.furrow", "-o", other, "--overwrite")
        self.assertEqual(self.json("info", other)["base_hash"], self.json("info", store)["base_hash"])


if __name__ == "__main__":
    main()
