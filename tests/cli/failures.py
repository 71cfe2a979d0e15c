"""What fails is told by name and leaves nothing: full disks, unreadable and broken sources, damaged stores."""
import lzma
import os
import pathlib
import random
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, long, main
from raster_test import RasterTest
import rasters


class FullDisk(FurrowTest):
    def limited(self, limit, *arguments, **more):
        """As on a disk with room for `limit` bytes: writes beyond fail, no signal ends the program."""
        def prepare():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        return subprocess.run([FURROW, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              preexec_fn=prepare, timeout=280, env=dict(os.environ, **more))

    def check(self, whole, output, *arguments):
        """At every size short of the whole it is status 1, one line and no file."""
        before = sorted(p.name for p in self.folder.iterdir())
        for limit in (0, 1, 4096, 30000, whole // 2, whole - 1):
            with self.subTest(limit=limit, output=output):
                result = self.limited(limit, *arguments, "-o", output)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr, r"^furrow: [^\n]+: [^\n]+; [^\n]+\n$")
                self.assertNotIn("Success", result.stderr)
                self.assertEqual(sorted(p.name for p in self.folder.iterdir()), before)

    def test_import_and_export_onto_a_full_disk_leave_nothing(self):
        noise = random.Random(7)
        side = 300
        (self.folder / "in.raw").write_bytes(noise.randbytes(2 * side * side))
        store = self.folder / "whole.furrow"
        self.ok("import", "in.raw", "--spacing", "1", "-o", store)
        size = store.stat().st_size
        self.check(size, "out.furrow", "import", "in.raw", "--spacing", "1")
        self.check(size, "out.furrow", "import", "in.raw", "--spacing", "1", "--jobs", "1")
        for name in ("whole.tif", "whole.png"):
            self.ok("export", store, "-o", name)
            size = (self.folder / name).stat().st_size
            self.check(size, "out" + name[-4:], "export", store)

    def test_a_store_that_is_to_be_overwritten_survives_a_full_disk(self):
        (self.folder / "in.raw").write_bytes(random.Random(8).randbytes(2 * 200 * 200))
        self.ok("import", "in.raw", "--spacing", "1", "-o", "s.furrow")
        before = (self.folder / "s.furrow").read_bytes()
        self.assertEqual(self.limited(60000, "import", "in.raw", "--spacing", "1", "-o", "s.furrow", "--overwrite").returncode, 1)
        self.assertEqual((self.folder / "s.furrow").read_bytes(), before)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["in.raw", "s.furrow"])

    def test_filling_holes_without_room_is_told(self):
        (self.folder / "in.raw").write_bytes(random.Random(9).randbytes(2 * 100 * 100))
        result = self.limited(5000, "import", "in.raw", "--spacing", "1", "-o", "s.furrow", "--fill")
        self.assertEqual(result.returncode, 1)
        self.assertIn("TMPDIR", result.stderr)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["in.raw"])

    @long
    def test_unpacking_without_room_and_without_end_is_told(self):
        (self.folder / "N46E015.hgt.xz").write_bytes(lzma.compress(random.Random(5).randbytes(2 * 1201 * 1201), preset=0))
        result = self.limited(100000, "import", "N46E015.hgt.xz", "-o", "s.furrow")
        self.assertEqual(result.returncode, 1)
        self.assertIn("TMPDIR", result.stderr)
        packer, packed = lzma.LZMACompressor(preset=0), b""
        for _ in range(129):
            packed += packer.compress(bytes(1 << 20))
        (self.folder / "N46E015.hgt.xz").write_bytes(packed + packer.flush())
        told = self.refused(3, "import", "N46E015.hgt.xz", "-o", "s.furrow")
        self.assertIn("unpacks to more than 128 MB", told)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["N46E015.hgt.xz"])

    def test_a_drive_names_no_file_that_it_could_not_write_and_the_step_to_go_on_from(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("not on this machine: no device that is full")
        store, scene = self.synth(), self.scene()
        (self.folder / "out").mkdir()
        (self.folder / "out/run.json.part").symlink_to("/dev/full")
        result = self.furrow("drive", scene, "--store", store, "--overlay", "a.furrow", "-o", "out", "--steps", "10")
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn(", but out/run.json could not be written; ", result.stdout)
        self.assertNotIn("--resume", result.stdout, "it is complete")
        (self.folder / "out/frame-000012.png.part").symlink_to("/dev/full")
        result = self.furrow("drive", scene, "--store", store, "--overlay", "a.furrow", "-o", "out", "--resume", "--set",
                             "view={camera: {overhead: {over: left, height: 40}}, size: [64, 64], images: 12}")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("; ruts in a.furrow, up to step 10; --resume goes on with the same scene from there\n", result.stdout)

    @unittest.skipUnless(os.geteuid() == 0, "needs the right to mount")
    def test_a_real_disk_that_is_full(self):
        disk = self.folder / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", disk], capture_output=True).returncode:
            self.skipTest("not on this machine: cannot mount a small file system here")
        try:
            (self.folder / "in.raw").write_bytes(random.Random(7).randbytes(2 * 400 * 400))
            self.assertIn("free some disk space, then run it again", self.refused(1, "import", "in.raw", "--spacing", "1", "-o", "disk/out.furrow"))
            self.assertEqual(list(disk.iterdir()), [])
            self.ok("import", "in.raw", "--spacing", "1", "-o", "whole.furrow")
            for name in ("out.tif", "out.png"):
                self.assertNotRegex(self.refused(1, "export", "whole.furrow", "-o", f"disk/{name}"), "(?i)tiff")
                self.assertEqual(list(disk.iterdir()), [])
        finally:
            subprocess.run(["umount", disk], check=True)


class Unreadable(RasterTest):
    def nothing_left(self, output="out.furrow"):
        self.assertEqual(sorted(p.name for p in self.folder.glob(output + "*")), [])

    def tiles(self, **options):
        """A folder of three tiles side by side."""
        (self.folder / "tiles").mkdir(exist_ok=True)
        for i in range(3):
            rasters.make(self.folder / f"tiles/{i}.tif", 200, 200, [(x * 7919) % 1000 for x in range(40000)], "h",
                         west=500000 + 2000 * i, **options)
        return self.folder / "tiles/1.tif"

    @long
    def test_a_source_that_fails_in_the_middle_is_named_and_leaves_nothing(self):
        """A broken strip of a compressed TIFF: the file opens, and most of it reads."""
        bad = self.tiles(options=["-co", "COMPRESS=DEFLATE", "-co", "BLOCKYSIZE=10"])
        data = bytearray(bad.read_bytes())
        middle = len(data) // 2
        data[middle:middle + 900] = bytes(b ^ 0x5a for b in data[middle:middle + 900])
        bad.write_bytes(data)
        for arguments in (["tiles"], [bad], ["tiles/0.tif", "tiles/1.tif"], ["tiles", "--spacing", "7"], ["tiles", "--fill"],
                          ["tiles", "--jobs", "1"]):
            with self.subTest(arguments=arguments):
                error = self.refused(3, "import", *arguments, "-o", "out.furrow")
                self.assertRegex(error, r"^furrow: \S*1\.tif: ")
                self.nothing_left()

    def test_a_source_that_ends_early_is_named_and_leaves_nothing(self):
        bad = self.tiles()
        whole = bad.read_bytes()
        for keep in (len(whole) * 3 // 4, len(whole) // 3, 600, 100, 7, 0):
            bad.write_bytes(whole[:keep])
            for source in ("tiles", bad):
                with self.subTest(keep=keep, source=source):
                    self.assertRegex(self.refused(3, "import", source, "-o", "out.furrow"), r"^furrow: \S*1\.tif: ")
                    self.nothing_left()

    @long
    def test_rubbish_among_tiles_is_named_and_not_left_out(self):
        bad = self.tiles()
        bad.write_bytes(b"no raster at all" * 40)
        self.assertRegex(self.refused(3, "import", "tiles", "-o", "out.furrow"), r"^furrow: \S*1\.tif: ")
        self.nothing_left()
        bad.unlink()
        bad.symlink_to("gone.tif")
        self.assertRegex(self.refused(3, "import", "tiles", "-o", "out.furrow"), r"^furrow: \S*1\.tif: ")
        bad.unlink()
        (self.folder / "tiles/notes.log").write_text("no raster, and not called one")
        self.ok("import", "tiles", "-o", "out.furrow")
        self.assertEqual(len(self.json("info", "out.furrow")["sources"]), 2)

    def test_a_source_without_permission_is_named_and_not_left_out(self):
        bad = self.tiles()
        bad.chmod(0)
        nobody = 65534 if os.geteuid() == 0 else None  # for root every file is readable
        self.folder.chmod(0o777)
        for source in ("tiles", bad):
            result = subprocess.run([FURROW, "import", source, "-o", "out.furrow"], cwd=self.folder, capture_output=True,
                                    text=True, user=nobody, group=nobody, timeout=280)
            if "cannot execute" in result.stderr or result.returncode in (126, 127):
                self.skipTest("not on this machine: another user may not run the command")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertRegex(result.stderr, r"^furrow: \S*1\.tif: ")
            self.nothing_left()


class SeamsThatDisagree(RasterTest):
    def two(self, higher):
        """Two tiles in degrees that share a column of posts, as SRTM's do; the second is higher by so much there."""
        for name, west, more in (("west.tif", 15.0, 0), ("east.tif", 15.039, higher)):
            rasters.make(self.folder / name, 40, 30, [1000 + (more if x == 0 else 0) for _ in range(30) for x in range(40)], "h",
                         west=west, north=46, step=0.001, srs="EPSG:4326")

    def test_a_seam_is_told_by_how_much_and_the_first_named_wins(self):
        self.two(17)
        told = self.ok("import", "west.tif", "east.tif", "-o", "a.furrow", "-r", "near")
        self.assertIn("overlap at 30 posts and differ at 30 of them, by 17 m at most; the first named wins", told)
        self.assertEqual(self.json("info", "a.furrow")["height"], [1000, 1000])
        told = self.ok("import", "east.tif", "west.tif", "-o", "b.furrow", "-r", "near")
        self.assertIn("by 17 m at most", told)
        self.assertEqual(self.json("info", "b.furrow")["height"], [1000, 1017])
        self.assertIn("by 17 m at most", self.ok("import", "west.tif", "east.tif", "-o", "c.furrow", "--dry-run"))
        self.assertFalse((self.folder / "c.furrow").exists())

    def test_a_seam_that_agrees_differs_nowhere(self):
        self.two(0)
        self.assertIn("differ at 0 of them", self.ok("import", "west.tif", "east.tif", "-o", "a.furrow"))

    def test_a_broken_overlap_names_the_sources(self):
        self.two(3)
        data = (self.folder / "east.tif").read_bytes()
        (self.folder / "east.tif").write_bytes(data[:len(data) - 1500])
        error = self.refused(3, "import", "west.tif", "east.tif", "-o", "a.furrow")
        self.assertIn("east.tif", error)
        self.assertEqual([p.name for p in self.folder.glob("a.furrow*")], [])


class Damage(FurrowTest):
    NAMES = {"base": "base tile", "offset": "offset tile", "dirt": "dirt tile"}

    @staticmethod
    def tile_of(key):
        """level, x, y of a key: 6 bits of level, biased by 32, above 28 + 28 interleaved bits."""
        x = y = 0
        for bit in range(28):
            x |= (key >> 2 * bit & 1) << bit
            y |= (key >> 2 * bit + 1 & 1) << bit
        return (key >> 56) - 32, x, y

    def damage(self, store, picks):
        """Spoils rows; picks: (table, how, row number). Returns what is to be named."""
        names = []
        with sqlite3.connect(store) as database:
            for table, how, number in picks:
                keys = [key for key, in database.execute(f'SELECT key FROM "{table}" ORDER BY key')]
                key = keys[number % len(keys)]
                if how == "blob":
                    blob = bytearray(database.execute(f'SELECT blob FROM "{table}" WHERE key = ?', (key,)).fetchone()[0])
                    blob[len(blob) // 2] ^= 0x10
                    database.execute(f'UPDATE "{table}" SET blob = ? WHERE key = ?', (bytes(blob), key))
                elif how == "range":
                    database.execute(f'UPDATE "{table}" SET low = low - 1 WHERE key = ?', (key,))
                elif how == "hash":
                    database.execute(f'UPDATE "{table}" SET hash = hash + 1 WHERE key = ?', (key,))
                elif how == "missing":
                    database.execute(f'DELETE FROM "{table}" WHERE key = ?', (key,))
                level, x, y = self.tile_of(key)
                names.append(f"{self.NAMES[table]} level {level} x {x} y {y}")
        database.close()
        return names

    def check(self, store, picks):
        broken = self.folder / "broken.furrow"
        shutil.copyfile(store, broken)
        names = self.damage(broken, picks)
        self.assertEqual(len(set(names)), len(picks))
        result = self.furrow("verify", broken, "--json")
        self.assertEqual(result.returncode, 3, result.stderr)
        for name in names:
            self.assertIn(name + ":", result.stdout)
            self.assertIn(name + ":", self.furrow("verify", broken).stdout)
        return result.stdout

    def test_verify_names_each_broken_tile(self):
        store = self.synth(posts="500x400")
        self.check(store, [("base", "blob", 0)])
        self.check(store, [("base", "blob", 1), ("base", "range", 3), ("base", "hash", 4), ("base", "missing", 2)])
        self.check(store, [("base", "blob", i) for i in range(5)])  # every one

    def test_verify_names_broken_ruts_too(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store)
        self.check(store, [("offset", "blob", 0), ("offset", "range", 2), ("dirt", "blob", 1), ("base", "hash", 0)])

    def test_a_key_of_no_tile_is_told(self):
        store = self.synth(posts="500x400")
        with sqlite3.connect(store) as database:
            database.execute("UPDATE base SET key = key + 1000000 WHERE key = (SELECT min(key) FROM base)")
        database.close()
        text = self.furrow("verify", store).stdout
        self.assertIn("base tile level 0 x 0 y 0: it is missing", text)
        self.assertIn("outside the terrain", text)


class WithoutGdal(RasterTest):
    def test_only_what_needs_gdal_says_that_it_is_missing(self):
        """A file that is no library stands before GDAL's."""
        self.make("in.tif", 40, 30, lambda x, y: x + y, "h")
        self.ok("import", "in.tif", "-o", "s.furrow")
        libraries = subprocess.run(["ldd", shutil.which("gdalinfo")], capture_output=True, text=True, check=True).stdout
        name = next(line.split()[0] for line in libraries.splitlines() if line.split()[0].startswith("libgdal."))
        (self.folder / "broken").mkdir()
        (self.folder / "broken" / name).write_bytes(b"no library")
        env = {"LD_LIBRARY_PATH": str(self.folder / "broken")}
        self.assertEqual(self.json("info", "s.furrow", env=env)["posts"], [40, 30])
        self.ok("export", "s.furrow", "-o", "out.png", "--layer", "hillshade", env=env)
        # Each of the ways to GDAL; a folder, whose files it is asked about, too.
        (self.folder / "tiles").mkdir()
        shutil.copy(self.folder / "in.tif", self.folder / "tiles")
        for arguments in (["import", "in.tif", "-o", "b.furrow"], ["import", "tiles", "-o", "b.furrow"],
                          ["export", "s.furrow", "-o", "out.tif"], ["query", "s.furrow", "1", "2", "--srs", "EPSG:4326"]):
            with self.subTest(arguments=arguments):
                error = self.refused(1, *arguments, env=env)
                self.assertIn("needs GDAL, which cannot be loaded: ", error)
                self.assertIn(name, error)
        self.assertEqual([*self.folder.glob("b.furrow*"), *self.folder.glob("out.tif*")], [])


if __name__ == "__main__":
    main()
