"""drive --overlay: the base stays as it is, every command reads an overlay, and many are driven at once."""
import hashlib
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, SCENE, FurrowTest, has_gdal, long, main

NO_GL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json", "EGL_PLATFORM": "surfaceless"}
OTHER = SCENE.replace("[120, 90]", "[200, 60]").replace("[122, 88]", "[202, 58]")


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Overlay(FurrowTest):
    def deformation(self, store):
        """What deformation added, row by row; not which epoch wrote it."""
        with sqlite3.connect(self.folder / store) as db:
            tables = {"offset": "key, low, high, below, above, codec, hash, blob",
                      "dirt": "key, low, high, codec, hash, blob"}
            rows = [db.execute(f'SELECT {columns} FROM "{table}" ORDER BY key').fetchall()
                    for table, columns in tables.items()]
        db.close()
        self.assertGreater(len(rows[0]), 1)
        self.assertGreater(len(rows[1]), 1)
        return rows

    def names(self, pattern="*"):
        return sorted(path.name for path in self.folder.glob(pattern))


class Drives(Overlay):
    @long
    def test_a_large_raster_of_ruts_is_what_changed(self):
        self.synth(posts="1025x1025", kind="plain")
        self.scene()
        self.drive("scene.yaml", "--store", "world.furrow", "--overlay", "r.furrow", "--set", "spacing=0.0625", "--steps", "4")
        told = self.furrow("export", "r.furrow", "-o", "all.tif", "--layer", "offset")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertRegex(told.stderr, r"^furrow: note: all\.tif: only what changed is written, --window \d+,\d+,\d+,\d+; the whole terrain has 1\.1 GB .* give --window 0,0,1024,1024 ")
        window = told.stderr.split("--window ")[1].split(";")[0]
        self.ok("export", "r.furrow", "-o", "part.tif", "--layer", "offset", "--window", window)
        self.assertEqual((self.folder / "all.tif").read_bytes(), (self.folder / "part.tif").read_bytes())
        # Nothing changed outside of it, and what is written is compressed.
        west, south, east, north = map(float, window.split(","))
        asked = [(west - 1, south + 1), (east + 1, north - 1), (west + 1, south - 1), (east - 1, north + 1)]
        points = self.json("query", "r.furrow", stdin="".join(f"{x} {y}\n" for x, y in asked))["points"]
        self.assertEqual([point["offset"] for point in points], [0] * 4)
        posts = ((east - west) * 16 + 1) * ((north - south) * 16 + 1)
        self.assertLess((self.folder / "all.tif").stat().st_size, posts)
        surface = self.furrow("export", "r.furrow", "-o", "s.tif")
        self.assertRegex(surface.stderr, r"^furrow: note: s\.tif: at level 0 it has one of 256 posts of the ruts, which are 0\.0625 m apart: .* give --level -4 --window " + window + "\n$")
        self.assertEqual(self.furrow("export", "r.furrow", "-o", "s.tif", "--level", "0").stderr, "")
        # A map, too.
        for command in ("map", "export"):
            drawn = self.furrow(command, "r.furrow", "-o", "m.png", "--layer", "offset")
            if "no font" in drawn.stderr or "without Pango" in drawn.stderr:
                break
            self.assertEqual(drawn.stderr, f"furrow: note: m.png: only what changed is drawn, --window {window}; the whole terrain: give --window 0,0,1024,1024 for it\n")
            self.assertEqual(self.furrow(command, "r.furrow", "-o", "n.png", "--layer", "offset", "--window", window).stderr, "")
            self.assertEqual((self.folder / "m.png").read_bytes(), (self.folder / "n.png").read_bytes())

    def test_an_overlay_holds_what_a_drive_into_a_copy_would(self):
        store = self.synth()
        (self.folder / "copy.furrow").write_bytes(store.read_bytes())
        before = digest(store)
        info = self.json("info", store)
        self.assertIsNone(info["base"])
        self.assertRegex(info["base_hash"], "^[0-9a-f]{16}$")
        scene = self.scene()
        report = self.drive(scene, "--store", store, "--overlay", "over.furrow")
        self.assertEqual(digest(store), before)
        self.drive(scene, "--store", "copy.furrow")
        self.assertEqual(self.deformation("over.furrow"), self.deformation("copy.furrow"))
        over, copy = self.json("info", "over.furrow"), self.json("info", "copy.furrow")
        self.assertEqual(pathlib.Path(over["base"]), store.resolve())
        self.assertEqual((over["overlays"], over["parent"]), (1, {"path": str(store.resolve()), "revision": 0}))
        self.assertEqual((copy["overlays"], copy["parent"]), (0, None))
        for key in set(copy) - {"base", "bytes", "overlays", "parent"}:
            self.assertEqual(over[key], copy[key], key)
        self.assertEqual(over["bytes"]["base"], copy["bytes"]["base"])
        self.assertIn(str(store.resolve()), self.ok("info", "over.furrow"))
        check = self.json("verify", "over.furrow")
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["offset_sum"]["-2"], report["volume"]["quanta"]["net"])
        self.assertEqual(self.ok("query", "over.furrow", "70", "55"), self.ok("query", "copy.furrow", "70", "55"))
        self.assertLess(self.json("query", "over.furrow", "70", "55")["offset"], -0.05)
        self.assertEqual(self.json("query", store, "70", "55")["offset"], 0)
        # Again into it, as into the copy; by its name as a store too.
        second = self.scene(OTHER, "other.yaml")
        self.drive(second, "--store", store, "--overlay", "over.furrow")
        self.drive(second, "--store", "copy.furrow")
        self.assertEqual(self.deformation("over.furrow"), self.deformation("copy.furrow"))
        self.drive(scene, "--store", "over.furrow")
        self.drive(scene, "--store", "copy.furrow")
        self.assertEqual(self.deformation("over.furrow"), self.deformation("copy.furrow"))
        for layer in ("surface", "base", "hillshade"):
            for name in ("over", "copy"):
                self.ok("export", f"{name}.furrow", "-o", f"{name}.png", "--layer", layer, "--level", "-1")
            self.assertEqual(digest(self.folder / "over.png"), digest(self.folder / "copy.png"), layer)
        # Nothing was done to the base, and nothing lies about.
        self.assertEqual(digest(store), before)
        self.assertEqual(self.names("*.furrow*"), ["copy.furrow", "over.furrow", "world.furrow"])
        self.ok("reset", "over.furrow")
        self.assertEqual(self.json("query", "over.furrow", "70", "55")["offset"], 0)
        self.assertTrue(self.json("verify", "over.furrow")["ok"])
        os.remove(self.folder / "over.furrow")
        self.assertTrue(self.json("verify", store)["ok"])
        self.assertEqual(self.json("info", store), info)

    @long
    def test_drives_over_one_base_run_at_once(self):
        store = self.synth()
        before = digest(store)
        loop = "speed: 30, loop: true}"
        scenes = [self.scene(text.replace("end_time: 4", "end_time: 20").replace("speed: 30}", loop), name)
                  for text, name in ((SCENE, "a.yaml"), (OTHER, "b.yaml"))]
        for i, scene in enumerate(scenes):
            self.drive(scene, "--store", store, "--overlay", f"alone{i}.furrow")
        store.chmod(0o444)
        processes = [subprocess.Popen([FURROW, "drive", scene, "--store", store, "--overlay", f"over{i % 2}-{i}.furrow",
                                       "-o", f"out{i}"], cwd=self.folder, stderr=subprocess.PIPE, text=True,
                                      stdout=subprocess.DEVNULL) for i, scene in enumerate(scenes * 2)]
        for process in processes:
            _, errors = process.communicate(timeout=280)
            self.assertEqual(process.returncode, 0, errors)
        for i in range(4):
            self.assertEqual(self.deformation(f"over{i % 2}-{i}.furrow"), self.deformation(f"alone{i % 2}.furrow"))
            self.assertTrue(self.json("verify", f"over{i % 2}-{i}.furrow")["ok"])
        self.assertNotEqual(self.deformation("alone0.furrow"), self.deformation("alone1.furrow"))
        self.assertEqual(digest(store), before)
        self.assertEqual(self.names("world.furrow*"), ["world.furrow"])

    def test_one_overlay_has_one_drive_and_its_base_may_be_driven_meanwhile(self):
        store = self.synth()
        endless = self.scene(SCENE.replace("end_time: 4", "end_time: 400000").replace("speed: 30}", "speed: 30, loop: true}"))
        process = subprocess.Popen([FURROW, "drive", endless, "--store", store, "--overlay", "over.furrow", "-o", "out"],
                                   cwd=self.folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        try:
            self.until_committed(process)
            short = self.scene(OTHER, "short.yaml")
            self.assertIn("another process", self.refused(1, "drive", short, "--store", store, "--overlay", "over.furrow",
                                                          "-o", "b"))
            self.assertEqual(self.furrow("drive", short, "--store", store, "-o", "c").returncode, 0)
            # A kill leaves the overlay's last epoch.
            process.send_signal(signal.SIGKILL)
        finally:
            process.kill()
            process.communicate(timeout=60)
        self.assertTrue(self.json("verify", "over.furrow")["ok"])
        self.assertGreater(self.json("info", "over.furrow")["last_run"]["epochs"], 0)
        self.assertTrue(self.json("verify", store)["ok"])


class Chains(Overlay):
    def content(self, store):
        """All rows that count, without who wrote them: what export and info say of them."""
        info = self.json("info", store)
        layers = []
        for layer in ("surface", "base", "hillshade") + (("quanta",) if has_gdal() else ()):
            name = "layer.tif" if layer == "quanta" else "layer.png"
            self.ok("export", store, "-o", name, "--layer", layer, "--level", "-1")
            layers.append(digest(self.folder / name))
        return layers, {key: info[key] for key in ("tiles", "soil", "compacted", "levels", "last_run", "working_level")}

    @long
    def test_drives_in_a_chain_are_the_drives_in_one_store(self):
        store = self.synth()
        (self.folder / "copy.furrow").write_bytes(store.read_bytes())
        texts = [SCENE, OTHER, SCENE.replace("end_time: 4", "end_time: 2"), OTHER.replace("speed: 30", "speed: 20")]
        under = store
        for i, text in enumerate(texts):
            scene, over = self.scene(text, f"{i}.yaml"), self.folder / f"over{i}.furrow"
            before = digest(under)
            report = self.drive(scene, "--store", under, "--overlay", over)
            copied = self.drive(scene, "--store", "copy.furrow")
            self.assertEqual(report["volume"], copied["volume"])
            self.assertEqual(self.content(over), self.content("copy.furrow"))
            check = self.json("verify", over)
            self.assertTrue(check["ok"], check["problems"])
            self.assertEqual(check["offset_sum"], self.json("verify", "copy.furrow")["offset_sum"])
            for x, y in ((70, 55), (121, 89), (200, 60)):
                self.assertEqual(self.ok("query", over, x, y), self.ok("query", "copy.furrow", x, y))
            self.assertEqual(digest(under), before)
            under = over
        info = self.json("info", under)
        self.assertEqual((info["overlays"], info["base"]), (4, str(store.resolve())))
        self.assertEqual(info["parent"]["path"], str((self.folder / "over2.furrow").resolve()))
        # A drive goes on in an overlay of what it left; by the name of any store under it.
        long = self.scene(OTHER.replace("end_time: 4", "end_time: 5"), "long.yaml")
        self.drive(long, "--store", "copy.furrow", "--steps", "40")
        self.drive(long, "--store", store, "--overlay", under, "--steps", "40")
        self.drive(long, "--store", under, "--overlay", "last.furrow", "--resume")
        self.drive(long, "--store", "copy.furrow", "--resume")
        self.assertEqual(self.content("last.furrow"), self.content("copy.furrow"))
        self.assertEqual(self.names("*.furrow*"), ["copy.furrow", "last.furrow"] + [f"over{i}.furrow" for i in range(4)] +
                         ["world.furrow"])
        self.ok("reset", "last.furrow")
        self.assertEqual(self.content("last.furrow")[0], self.content(under)[0])
        self.assertTrue(self.json("verify", "last.furrow")["ok"])

    def test_a_chain_that_cannot_be_read_is_refused_in_one_line(self):
        store, scene = self.synth(), self.scene(SCENE.replace("end_time: 4", "end_time: 1"))
        self.drive(scene, "--store", store, "--overlay", "a.furrow")
        self.drive(scene, "--store", "a.furrow", "--overlay", "b.furrow")
        self.drive(scene, "--store", "b.furrow", "--overlay", "c.furrow")
        self.drive(scene, "--store", store, "--overlay", "other.furrow", "--set", "objects.left.sink=0.3")

        def refused(why, path="c.furrow"):
            for command in (["info"], ["verify"], ["query", "1", "1"], ["reset"], ["export", "-o", "x.png"]):
                error = self.refused(3, command[0], path, *command[1:])
                self.assertIn(why, error)
                self.assertIn(path, error)

        self.assertIn("not of", self.refused(3, "drive", scene, "--store", "other.furrow", "--overlay", "b.furrow", "-o", "out"))
        kept = (self.folder / "a.furrow").read_bytes()
        (self.folder / "a.furrow-pins").unlink()  # or a.furrow keeps what b.furrow depends on
        self.drive(self.scene(OTHER, "two.yaml"), "--store", "a.furrow")
        refused("a.furrow has changed since: it was at revision")
        (self.folder / "a.furrow").write_bytes(kept)
        os.rename(self.folder / "a.furrow", self.folder / "aside")
        refused("No such file")
        os.rename(self.folder / "aside", self.folder / "a.furrow")
        with sqlite3.connect(self.folder / "a.furrow") as db:
            db.execute("UPDATE meta SET value = 'c.furrow' WHERE key = 'base_path'")
            db.execute("INSERT INTO meta VALUES('parent_hash', 1), ('parent_revision', 1)")
        db.close()
        refused("overlay of itself")


class Refusals(Overlay):
    def test_a_drive_that_cannot_begin_leaves_no_overlay(self):
        store = self.synth(posts="65x65")
        arguments = ("--store", store, "--overlay", "over.furrow", "-o", "out")
        broken = self.scene(SCENE.replace("sink: 0.15", "sunk: 0.15", 1), "broken.yaml")
        self.refused(3, "drive", broken, *arguments)
        self.refused(4, "drive", self.scene(), *arguments, "--set", "compute=gpu", env=NO_GL)
        self.refused(3, "drive", self.scene(), *arguments, "--set", "spacing=0.00001")
        self.refused(3, "drive", self.scene(), "--store", store, "--overlay", "no/folder/over.furrow", "-o", "out")
        self.refused(3, "drive", self.scene(), "--store", "absent.furrow", "--overlay", "over.furrow", "-o", "out")
        self.assertEqual(self.names(), ["broken.yaml", "scene.yaml", "world.furrow"])

    def test_ruts_of_another_spacing_are_told_of_the_file_that_has_them(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store, "--set", "spacing=0.5", "--steps", 2)
        for overlay in ("a.furrow", "b.furrow"):
            self.drive(self.scene(), "--store", store, "--overlay", "a.furrow", "--set", "spacing=0.5", "--steps", 2)
            error = self.refused(3, "drive", self.scene(), "--store", store, "--overlay", overlay, "-o", "out", "--set", "spacing=0.25")
            self.assertRegex(error, r"world\.furrow: it is deformed at a spacing of 0\.5 m, not 0\.25 m; use that spacing, or furrow reset \S*world\.furrow$")

    def test_an_overlay_that_was_there_is_kept_by_a_drive_that_fails(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store, "--overlay", "over.furrow")
        before = self.deformation("over.furrow")
        self.refused(4, "drive", self.scene(), "--store", store, "--overlay", "over.furrow", "-o", "out", "--set", "compute=gpu", env=NO_GL)
        self.assertEqual(self.deformation("over.furrow"), before)

    def test_what_is_no_overlay_of_that_store_is_refused_and_kept(self):
        store, other = self.synth(), self.synth("other.furrow", kind="dunes")
        scene = self.scene()
        self.drive(scene, "--store", store, "--overlay", "over.furrow")
        before = {path: digest(path) for path in self.folder.glob("*.furrow")}

        def refuse(base, overlay):
            return self.refused(3, "drive", scene, "--store", base, "--overlay", overlay, "-o", "out")

        self.assertIn("not of", refuse(other, "over.furrow"))
        self.assertIn("not an overlay", refuse(store, "other.furrow"))
        self.assertIn("not an overlay", refuse(store, store))
        (self.folder / "text").write_text("no store")
        self.assertIn("it is another file, not an overlay; name an overlay, or a file that is not there yet", refuse(store, "text"))
        self.assertIn("it is a folder, not an overlay", refuse(store, self.folder))
        os.mkfifo(self.folder / "fifo")
        self.assertIn("it is another file, not an overlay", refuse(store, "fifo"))
        self.assertEqual({path: digest(path) for path in before}, before)

    def test_an_overlay_whose_base_is_gone_or_another_is_refused_by_every_command(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store, "--overlay", "over.furrow")
        os.rename(store, self.folder / "aside")
        for change in ("No such file", "another one now"):
            for command in (["info"], ["verify"], ["query", "1", "1"], ["reset"], ["export", "-o", "x.png"]):
                error = self.refused(3, command[0], "over.furrow", *command[1:])
                self.assertIn("over.furrow", error)
                self.assertIn(str(store.resolve()), error)
                self.assertIn(change, error)
            self.assertEqual(self.names("over.furrow*") + self.names("x.png*"), ["over.furrow"])
            self.synth(kind="dunes")
        os.rename(self.folder / "aside", store)
        self.assertTrue(self.json("verify", "over.furrow")["ok"])

    def test_an_import_may_take_an_overlay_s_name(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store, "--overlay", "over.furrow")
        self.refused(3, "synth", "-o", "over.furrow", "--posts", "65x65", "--spacing", "1")
        self.synth("over.furrow", posts="65x65")
        self.assertIsNone(self.json("info", "over.furrow")["base"])
        self.assertTrue(self.json("verify", "over.furrow")["ok"])


if __name__ == "__main__":
    main()
