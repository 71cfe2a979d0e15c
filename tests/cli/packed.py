"""Terrain in folders that are rasters, in archives, and in packed blocks; an import that was broken off. GDAL's own answer is beside each."""
import os
import pathlib
import random
import signal
import subprocess
import sys
import time
import unittest
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, main
from raster_test import RasterTest
import rasters


def ground(column, row):
    return 800 + column * 3 + (row * row) % 17 + 0.25 * row


class Packed(RasterTest):
    def base(self, store):
        return self.exported(store, "--layer", "base")[2]

    def zip(self, name, *files, under="", how=zipfile.ZIP_DEFLATED):
        with zipfile.ZipFile(self.folder / name, "w", how) as archive:
            for file in files:
                archive.write(self.folder / file, under + file)
        for file in files:
            (self.folder / file).unlink()

    @unittest.skipUnless("Zarr" in rasters.gdal("gdalinfo", "--formats"), "this GDAL has no Zarr")
    def test_a_folder_that_is_a_zarr(self):
        self.make("g.tif", 70, 40, ground)
        own = list(rasters.pixels(self.folder / "g.tif")[2])
        for number, options in enumerate(((), ("-co", "FORMAT=ZARR_V3"), ("-co", "BLOCKSIZE=16,16"))):
            name = f"großes gitter {number}.zarr"
            rasters.gdal("gdal_translate", "-q", "-of", "Zarr", *options, self.folder / "g.tif", self.folder / name)
            self.ok("import", name, "-o", f"{number}.furrow", "--max-error", 0)
            self.assertEqual(self.base(f"{number}.furrow"), own)
            self.assertIn("zone 33N", self.json("info", f"{number}.furrow")["srs"])
        # Two in a folder are two sources.
        (self.folder / "all").mkdir()
        (self.folder / "großes gitter 0.zarr").rename(self.folder / "all" / "a.zarr")
        self.make("east.tif", 70, 40, lambda column, row: 1.0, west=500000 + 700)
        rasters.gdal("gdal_translate", "-q", "-of", "Zarr", self.folder / "east.tif", self.folder / "all" / "b.zarr")
        self.ok("import", "all", "-o", "all.furrow")
        self.assertEqual(self.json("info", "all.furrow")["posts"], [140, 40])

    @unittest.skipUnless("Zarr" in rasters.gdal("gdalinfo", "--formats"), "this GDAL has no Zarr")
    def test_what_is_in_a_zarr_is_its_own(self):
        self.make("g.tif", 30, 20, ground)
        rasters.gdal("gdal_translate", "-q", "-of", "Zarr", self.folder / "g.tif", self.folder / "z.zarr")
        chunk = next(path for path in (self.folder / "z.zarr").glob("z/*") if not path.name.startswith("."))
        inside = chunk.read_bytes()
        chunk.unlink()
        os.mkfifo(chunk)
        self.assertIn("no regular file", self.refused(3, "import", "z.zarr", "-o", "s.furrow"))
        chunk.unlink()
        (self.folder / "elsewhere").mkdir()
        (self.folder / "elsewhere" / "chunk").write_bytes(inside)
        (self.folder / "deep").mkdir()
        (self.folder / "z.zarr").rename(self.folder / "deep" / "z.zarr")
        chunk = self.folder / "deep" / chunk.relative_to(self.folder)
        chunk.symlink_to(self.folder / "elsewhere" / "chunk")
        self.assertIn("no regular file", self.refused(3, "import", "deep/z.zarr", "-o", "s.furrow"))

    def test_an_archive_with_rasters(self):
        self.make("höhe 1.tif", 40, 30, ground)
        own = list(rasters.pixels(self.folder / "höhe 1.tif")[2])
        self.make("z.tif", 40, 30, lambda column, row: 5.0, west=500000 + 400)
        (self.folder / "readme.txt").write_text("words")
        self.zip("höhen und mehr.zip", "z.tif", "readme.txt", "höhe 1.tif", under="ein ordner/tief/")
        self.ok("import", "höhen und mehr.zip", "-o", "s.furrow", "--max-error", 0)
        info = self.json("info", "s.furrow")
        self.assertEqual((info["posts"], len(info["sources"])), ([80, 30], 2))
        width, _, cells = self.exported("s.furrow", "--layer", "base")
        self.assertEqual([cells[row * width + column] for row in range(30) for column in range(40)], own)
        self.ok("import", self.folder / "höhen und mehr.zip", "-o", "t.furrow", "--max-error", 0)
        self.assertEqual(self.base("t.furrow"), cells)
        self.ok("import", "/vsizip/höhen und mehr.zip/ein ordner/tief/höhe 1.tif", "-o", "u.furrow", "--max-error", 0)
        self.assertEqual(self.base("u.furrow"), own)

    def test_a_folder_of_archives(self):
        (self.folder / "fetched").mkdir()
        for i in range(2):
            self.make(f"{i}.tif", 20, 20, lambda column, row, i=i: 100.0 * i, west=500000 + 200 * i)
            self.zip(f"fetched/{i}.zip", f"{i}.tif", how=zipfile.ZIP_STORED)
        self.ok("import", "fetched", "-o", "s.furrow")
        self.assertEqual(self.json("info", "s.furrow")["posts"], [40, 20])
        # Beside what was unpacked, archives are not read a second time.
        self.make("fetched/0.tif", 20, 20, lambda column, row: 7.0)
        self.ok("import", "fetched", "-o", "t.furrow")
        self.assertEqual(len(self.json("info", "t.furrow")["sources"]), 1)

    def test_archives_without_a_raster_are_refused(self):
        (self.folder / "words.txt").write_text("words")
        self.zip("w.zip", "words.txt")
        self.assertIn("no raster in this archive", self.refused(3, "import", "w.zip", "-o", "s.furrow"))
        (self.folder / "cut.zip").write_bytes(b"PK\3\4" + bytes(100))
        self.refused(3, "import", "cut.zip", "-o", "s.furrow")
        self.make("a.tif", 20, 20, ground)
        (self.folder / "leads.vrt").write_text('<VRTDataset rasterXSize="20" rasterYSize="20"><VRTRasterBand dataType="Float32" band="1"><SimpleSource>'
                                               f"<SourceFilename>{self.folder}/a.tif</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>")
        self.zip("v.zip", "leads.vrt")
        self.assertIn("packed VRT", self.refused(3, "import", "v.zip", "-o", "s.furrow"))

    def test_packed_blocks_have_the_same_bits_with_any_threads(self):
        self.make("g.tif", 700, 500, ground)
        own = list(rasters.pixels(self.folder / "g.tif")[2])
        hashes = set()
        for name, options in (("strips", ()), ("tiles", ("-co", "TILED=YES", "-co", "BLOCKXSIZE=128", "-co", "BLOCKYSIZE=64"))):
            rasters.gdal("gdal_translate", "-q", "-co", "COMPRESS=DEFLATE", "-co", "PREDICTOR=3", *options, self.folder / "g.tif", self.folder / f"{name}.tif")
            for jobs in (1, 2, 16):
                self.ok("import", f"{name}.tif", "-o", "s.furrow", "--overwrite", "--jobs", jobs, "--max-error", 0)
                hashes.add(self.json("info", "s.furrow")["base_hash"])
        self.assertEqual(len(hashes), 1)
        self.assertEqual(self.base("s.furrow"), own)
        # A block that is damaged is told, whichever thread reads it.
        broken = bytearray((self.folder / "tiles.tif").read_bytes())
        broken[len(broken) // 2:len(broken) // 2 + 4000] = bytes(4000)
        (self.folder / "broken.tif").write_bytes(broken)
        for jobs in (1, 4):
            self.assertIn("broken.tif", self.refused(3, "import", "broken.tif", "-o", "b.furrow", "--jobs", jobs))


class BrokenOff(RasterTest):
    def test_an_import_that_was_broken_off_is_told_by_the_next(self):
        side = 3073
        (self.folder / "noise.r16").write_bytes(random.Random(3).randbytes(2 * side * side))
        arguments = ("import", "noise.r16", "-o", "s.furrow", "--max-error", "0.01")
        process = subprocess.Popen([FURROW, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        part = self.folder / "s.furrow.part"
        while process.poll() is None and not (part.exists() and part.stat().st_size > 1 << 20):
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        if process.wait(timeout=100) == 0:
            self.skipTest("it was done before it could be interrupted")
        for more in (("--dry-run",), ("--tile", "128", "--dry-run")):
            told = self.furrow(*arguments, *more)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertIn("was broken off", told.stderr)
            self.assertIn("--resume", told.stderr)
            self.assertTrue(part.exists())
        self.assertNotIn("broken off", self.furrow(*arguments, "--dry-run", "--resume").stderr)
        told = self.furrow(*arguments)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("was broken off", told.stderr)
        self.assertNotIn("broken off", self.furrow(*arguments, "--overwrite").stderr)


if __name__ == "__main__":
    main()
