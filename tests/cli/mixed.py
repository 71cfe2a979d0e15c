"""Sources of several reference systems, spacings and units in one import, beside what gdalwarp makes of each of them."""
import array
import gzip
import lzma
import math
import pathlib
import random
import signal
import subprocess
import sys
import time
import unittest
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, largest, long, main, part, write_png16
from raster_test import RasterTest
import rasters

UTM = "EPSG:32633"


def hills(x, y):
    """Metres at coordinates of UTM 33N: 60 m high, 700 m long, and 4 m high, 90 m long."""
    return 400 + 60 * math.sin(x / 111) * math.cos(y / 97) + 4 * math.sin(x / 14 + y / 19)


class MixedTest(RasterTest):
    def hills_in(self, name, width, height, west, north, step, srs=UTM, scale=1.0, more=0.0, options=()):
        """A raster of the hills; places in another SRS come from gdaltransform."""
        points = [(west + (x + 0.5) * step, north - (y + 0.5) * step) for y in range(height) for x in range(width)]
        if srs != UTM:
            text = "".join(f"{x!r} {y!r}\n" for x, y in points)
            found = rasters.gdal("gdaltransform", "-s_srs", srs, "-t_srs", UTM, "-output_xy", stdin=text)
            points = [tuple(map(float, line.split())) for line in found.splitlines()]
        rasters.make(self.folder / name, width, height, [(hills(x, y) + more) / scale for x, y in points], "f", west=west,
                     north=north, step=step, srs=srs, options=options)

    def sources(self):
        """A site, the country around it in degrees and feet, and a neighbour in the next zone."""
        self.hills_in("site.tif", 60, 50, 500400.0, 5000700.0, 5.0)
        self.hills_in("country.tif", 60, 45, 14.999, 45.157, 0.0003, "EPSG:4326", scale=0.3048)
        with_unit = self.folder / "country.vrt"
        rasters.gdal("gdal_translate", "-q", "-of", "VRT", self.folder / "country.tif", with_unit)
        with_unit.write_text(with_unit.read_text().replace("<ColorInterp>", "<UnitType>ft</UnitType><ColorInterp>"))
        east, north = map(float, rasters.gdal("gdaltransform", "-s_srs", UTM, "-t_srs", "EPSG:32634", "-output_xy",
                                              stdin="501100 5000600\n").split())
        self.hills_in("zone34.tif", 40, 40, round(east), round(north), 20.0, "EPSG:32634", more=7)
        return ["site.tif", "country.vrt", "zone34.tif"]

    def warped(self, name, like, method="bilinear", factor=1.0, span=(1, 1)):
        """What gdalwarp makes of a source at the posts of another raster: {(x, y): height}."""
        info = rasters.gdalinfo(like)
        (width, height), place = info["size"], info["geoTransform"]
        out = self.folder / "warped.tif"
        rasters.gdal("gdalwarp", "-q", "-overwrite", "-t_srs", UTM, "-te", place[0], place[3] + height * place[5],
                     place[0] + width * place[1], place[3], "-ts", width, height, "-r", method, "-wo", f"XSCALE={1 / span[0]!r}", "-wo", f"YSCALE={1 / span[1]!r}", "-et", 0, "-ovr", "NONE", "-ot",
                     "Float32", "-dstnodata", "nan", self.folder / name, out)
        _, _, cells = rasters.pixels(out, "f")
        return {(i % width, i // width): v * factor for i, v in enumerate(cells) if not math.isnan(v)}


class Mixed(MixedTest):
    def test_each_source_is_what_gdalwarp_makes_of_it_and_the_first_wins(self):
        sources = self.sources()
        for spacing in (4, 5, 12.5):
            with self.subTest(spacing=spacing):
                told = self.ok("import", *sources, "-o", "s.furrow", "--overwrite", "--max-error", 0.001, "--spacing", spacing)
                self.assertRegex(told, r"differ at \d+ of them, by ([7-9]|1[0-2])(\.\d+)? m at most")
                width, height, found = self.exported("s.furrow", "--layer", "base")
                site = max(1, spacing / 5) if spacing > 10 else 1  # of the site's posts a post is a mean then
                layers = [self.warped(name, self.folder / "read.tif", factor=0.3048 if name == "country.vrt" else 1,
                                      span=(site, site) if name == "site.tif" else (1, 1)) for name in sources]
                counts = [0, 0, 0]
                for i, value in enumerate(found):
                    x, y = i % width, i // width
                    # Around here a source has data: then the post is the first such source's.
                    reach = math.ceil(34 / spacing)
                    inner = [all((x + dx, y + dy) in layer for dx in (-reach, 0, reach) for dy in (-reach, 0, reach))
                             for layer in layers]
                    if True in inner:
                        first = inner.index(True)
                        if any((x, y) in layer for layer in layers[:first]):
                            continue
                        self.assertAlmostEqual(value, layers[first][x, y], delta=0.03)
                        counts[first] += 1
                    elif value is not None:
                        self.assertTrue(any((x + dx, y + dy) in layer for layer in layers for dx in (-1, 0, 1) for dy in (-1, 0, 1)))
                self.assertTrue(all(count > 100 for count in counts), counts)

    @long
    def test_kernels_are_gdals(self):
        noise = random.Random(8)
        cells = [noise.uniform(0, 100) for _ in range(120 * 100)]
        rasters.make(self.folder / "noise.tif", 120, 100, cells, "f", west=15.0, north=45.2, step=0.0004, srs="EPSG:4326")
        for method, kept in (("bilinear", (0, 2)), ("cubic", (1,)), ("near", (2,))):
            for spacing in part((9, 40, 170), *kept):  # of posts 31 x 44 m apart: finer, about the same, a mean
                with self.subTest(method=method, spacing=spacing):
                    self.ok("import", "noise.tif", "-o", "s.furrow", "--overwrite", "--max-error", 0.001, "--spacing", spacing, "-r", method)
                    width, _, found = self.exported("s.furrow", "--layer", "base")
                    # At most twice as far apart as the source's, posts are samples. Metres a degree are those of the ellipsoid.
                    span = (spacing / 31.44, spacing / 44.45) if spacing > 62 else (1, 1)
                    wanted = self.warped("noise.tif", self.folder / "read.tif", method, span=span)
                    inner = [(value, wanted[i % width, i // width]) for i, value in enumerate(found)
                             if value is not None and (i % width, i // width) in wanted]
                    self.assertGreater(len(inner), 0.95 * len(wanted))
                    if method == "near":
                        self.assertGreater(sum(abs(a - b) < 0.002 for a, b in inner), 0.99 * len(inner))
                        continue
                    rms = math.sqrt(sum((a - b) ** 2 for a, b in inner) / len(inner))
                    self.assertLess(rms, 0.15)

    @long
    def test_a_window_in_degrees_cuts_the_same_posts_from_all(self):
        sources = self.sources()
        self.ok("import", *sources, "-o", "whole.furrow", "--spacing", 5, "--max-error", 0.001)
        whole = self.json("info", "whole.furrow")
        for window in ((15.003, 45.152, 15.008, 45.155), (15.0065, 45.1535, 15.012, 45.1561)):
            self.ok("import", *sources, "-o", "part.furrow", "--overwrite", "--spacing", 5, "--max-error", 0.001,
                    "--window", ",".join(map(str, window)), "--window-srs", "EPSG:4326")
            part = self.json("info", "part.furrow")
            points = [(part["origin"][0] + 5 * x, part["origin"][1] + 5 * y) for x in range(0, part["posts"][0], 7)
                      for y in range(0, part["posts"][1], 7)]
            lines = "".join(f"{x!r} {y!r}\n" for x, y in points)
            a, b = ([p["height"] for p in self.json("query", store, "--srs", "store", stdin=lines)["points"]]
                    for store in ("part.furrow", "whole.furrow"))
            for mine, theirs in zip(a, b, strict=True):
                self.assertEqual(mine is None, theirs is None)
                self.assertAlmostEqual(mine or 0, theirs or 0, delta=0.01)  # places are off by at most 0.01 of a source's post
            self.assertGreater(sum(v is not None for v in a), 50)
            self.assertLess(part["posts"][0] * part["posts"][1], 0.5 * whole["posts"][0] * whole["posts"][1])
        self.refused(2, "import", *sources, "-o", "x.furrow", "--window", "1,2,3")
        self.refused(3, "import", *sources, "-o", "x.furrow", "--window", "10,40,11,41", "--window-srs", "EPSG:4326")

    def off_source(self, store, *names):
        """By how much a store's surface is off sources at their own posts, as gdalwarp interpolates it: (greatest, rms, posts)."""
        self.ok("export", store, "-o", "base.tif", "--layer", "base")
        off = []
        for name in names:
            info = rasters.gdalinfo(self.folder / name)
            (width, height), place = info["size"], info["geoTransform"]
            out = self.folder / "back.tif"
            rasters.gdal("gdalwarp", "-q", "-overwrite", "-t_srs", info["coordinateSystem"]["wkt"], "-te", place[0],
                         place[3] + height * place[5], place[0] + width * place[1], place[3], "-ts", width, height, "-r", "bilinear",
                         "-wo", "XSCALE=1", "-wo", "YSCALE=1", "-et", 0, "-ot", "Float64", "-dstnodata", "nan", self.folder / "base.tif", out)
            _, _, back = rasters.pixels(out, "d")
            _, _, own = rasters.pixels(self.folder / name, "d")
            # gdalwarp goes on for half a pixel beyond the outermost posts.
            off += [back[i] - own[i] for i in range(width * height) if not math.isnan(back[i]) and
                    4 <= i % width < width - 4 and 4 <= i // width < height - 4]
        return largest(map(abs, off)), math.sqrt(sum(v * v for v in off) / len(off)), len(off)

    def test_the_error_at_a_sources_own_posts_is_what_gdalwarp_finds(self):
        noise = random.Random(3)
        cells = [200 + 30 * math.sin(i / 7) + noise.uniform(-1, 1) for i in range(90 * 80)]
        for west, north, step, srs, spacings in ((15.0, 45.2, 0.0004, "EPSG:4326", (10, 37, 130)), (500000.0, 5e6, 10.0, UTM, (4, 17, 45))):
            rasters.make(self.folder / "in.tif", 90, 80, cells, "f", west=west, north=north, step=step, srs=srs)
            for spacing in spacings:
                with self.subTest(srs=srs, spacing=spacing):
                    made = self.json("import", "in.tif", "-o", "s.furrow", "--overwrite", "--spacing", spacing, "--max-error", 0.01)
                    told = self.json("info", "s.furrow")
                    for key in ("off_source", "off_resampled", "max_error"):
                        self.assertEqual(made[key], told[key])
                    greatest, rms, posts = self.off_source("s.furrow", "in.tif")
                    self.assertLessEqual(made["off_resampled"]["greatest"], 0.01)
                    self.assertGreater(made["off_resampled"]["rms"], 0.0005)
                    self.assertAlmostEqual(made["off_source"]["rms"], rms, delta=0.03 * rms + 0.01)
                    self.assertGreater(made["off_source"]["greatest"], greatest - 0.05)
                    self.assertLess(made["off_source"]["greatest"], 1.2 * greatest + 0.05)
                    self.assertAlmostEqual(made["off_source"]["posts"], posts, delta=0.25 * posts)

    def test_what_is_not_resampled_is_off_by_the_bound_alone(self):
        for bound, spacing in ((0, 10.0), (0.01, 3.0), (1, 30.0)):
            self.hills_in("in.tif", 50, 40, 500000.0, 5e6, spacing)
            made = self.json("import", "in.tif", "-o", "s.furrow", "--overwrite", "--max-error", bound)
            self.assertEqual(made["off_source"], made["off_resampled"])
            self.assertEqual(made["off_source"]["posts"], 2000)
            self.assertLessEqual(made["off_source"]["greatest"], bound)
            self.assertEqual(made["off_source"]["greatest"] > 0, bound > 0)

    @long
    def test_a_source_under_another_is_not_counted(self):
        """The hidden part of the second source is 7 m off; its own posts show only where it is on top."""
        self.hills_in("top.tif", 40, 40, 500000.0, 5e6, 10.0)
        self.hills_in("low.tif", 60, 40, 500003.0, 5e6 + 4, 10.0, more=7)
        made = self.json("import", "top.tif", "low.tif", "-o", "s.furrow", "--spacing", 10)
        self.assertLess(made["off_source"]["greatest"], 3)  # half way between its posts
        self.assertGreater(made["overlap"]["greatest"], 6.5)
        self.assertGreater(made["off_source"]["posts"], 40 * 40 + 15 * 35)
        self.assertLess(made["off_source"]["posts"], 40 * 40 + 20 * 40 + 41 * 3)

    @long
    def test_a_directory_skips_what_has_no_place(self):
        folder = self.folder / "tiles"
        folder.mkdir()
        self.sources()
        for name in ("site.tif", "zone34.tif"):
            (self.folder / name).rename(folder / name)
        write_png16(folder / "preview.png", 8, 8, lambda x, y: x + y)
        rasters.make(folder / "hillshade.tif", 9, 9, range(81), "h", step=None, srs=None)
        result = self.furrow("import", "tiles", "-o", "s.furrow")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, r"2 sources")
        for name in ("preview.png", "hillshade.tif"):
            self.assertRegex(result.stderr, rf"note: tiles/{name}: skipped")
        self.assertEqual(len(self.json("info", "s.furrow")["sources"]), 2)
        # Named, it is no accident.
        self.assertIn("preview.png", self.refused(3, "import", "tiles/site.tif", "tiles/preview.png", "-o", "x.furrow"))
        for name in ("site.tif", "zone34.tif", "hillshade.tif"):
            (folder / name).unlink()
        self.ok("import", "tiles", "-o", "png.furrow")

    def test_xz_is_unpacked_whole_or_refused(self):
        """Of any ending, in several streams, twice in one import; broken ones by name."""
        self.hills_in("site.tif", 40, 30, 500400.0, 5000700.0, 5.0)
        self.hills_in("beside.tif", 40, 30, 500600.0, 5000700.0, 5.0)
        for name in ("site.tif", "beside.tif"):
            whole = (self.folder / name).read_bytes()
            (self.folder / (name + ".xz")).write_bytes(lzma.compress(whole[:999]) + lzma.compress(whole[999:]))
        self.ok("import", "site.tif", "beside.tif", "-o", "plain.furrow")
        self.ok("import", "site.tif.xz", "beside.tif.xz", "-o", "s.furrow")
        plain, packed = self.json("info", "plain.furrow"), self.json("info", "s.furrow")
        self.assertEqual(plain["base_hash"], packed["base_hash"])
        self.assertEqual(packed["sources"], ["site.tif.xz", "beside.tif.xz"])
        whole = (self.folder / "site.tif.xz").read_bytes()
        for broken, why in ((whole[:-40], "ends early"), (whole[:600], "ends early"), (b"no xz at all", "xz format"), (whole[:300] + b"no" + whole[302:], "corrupt"),
                            (lzma.compress(b"no raster"), "cannot be opened"), (b"", "empty")):
            (self.folder / "broken.tif.xz").write_bytes(broken)
            told = self.refused(3, "import", "broken.tif.xz", "-o", "x.furrow")
            self.assertIn("broken.tif.xz", told)
            self.assertIn(why, told)
        self.assertEqual(list(self.folder.glob("x.furrow*")), [])

    def test_packed_tiles_are_read_as_they_are(self):
        cells = array.array("h", [(x * 7 + y * 3) % 900 for y in range(1201) for x in range(1201)])
        cells.byteswap()
        tile = cells.tobytes()
        (self.folder / "N46E015.hgt").write_bytes(tile)
        (self.folder / "N46E015.hgt.gz").write_bytes(gzip.compress(tile, 1))
        with zipfile.ZipFile(self.folder / "N46E015.hgt.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as packed:
            packed.writestr("N46E015.hgt", tile)
        (self.folder / "N46E015.hgt.xz").write_bytes(lzma.compress(tile, preset=1))
        hashes, packed = set(), ("N46E015.hgt.gz", "N46E015.hgt.zip", "N46E015.hgt.xz")
        for name in ("N46E015.hgt", *packed):
            self.ok("import", name, "-o", "s.furrow", "--overwrite", "--spacing", 400)
            hashes.add(self.json("info", "s.furrow")["base_hash"])
        folder = self.folder / "tiles"
        folder.mkdir()
        for name in packed:
            (self.folder / name).rename(folder / name)
            self.ok("import", "tiles", "-o", "s.furrow", "--overwrite", "--spacing", 400)
            hashes.add(self.json("info", "s.furrow")["base_hash"])
            (folder / name).rename(self.folder / name)
        self.assertEqual(len(hashes), 1)
        (self.folder / "N46E015.hgt.gz").write_bytes(gzip.compress(tile, 1)[:5000])
        self.assertIn("N46E015.hgt.gz", self.refused(3, "import", "N46E015.hgt.gz", "-o", "x.furrow"))

    def test_killed_a_mixed_import_goes_on_to_the_same_store(self):
        sources = self.sources()
        arguments = ["import", *sources, "--spacing", "0.6", "--max-error", "0.0001", "--tile", "128", "-o"]
        started = time.monotonic()
        self.ok(*arguments, "whole.furrow")
        took, chance = time.monotonic() - started, random.Random(5)
        kills = 0
        while kills == 0 or not (self.folder / "killed.furrow").exists():
            if (self.folder / "killed.furrow").exists():  # done before it was killed: again, and sooner
                (self.folder / "killed.furrow").unlink()
                took /= 2
            process = subprocess.Popen([FURROW, *arguments, "killed.furrow", "--resume", "--jobs", str(chance.choice([1, 2, 4]))],
                                       cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                process.communicate(timeout=chance.uniform(0.3, 1.1) * took)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.communicate()
                kills += 1
            self.assertIn(process.returncode, (0, -signal.SIGKILL))
            if kills > 20:
                self.ok(*arguments, "killed.furrow", "--resume")
        whole, killed = (self.json("info", store) for store in ("whole.furrow", "killed.furrow"))
        for key in ("base_hash", "off_source", "off_resampled"):  # errors are summed up in the part, too
            self.assertEqual(whole[key], killed[key])
        # Another order of the same sources is another import.
        part = self.folder / "other.furrow.part"
        process = subprocess.Popen([FURROW, *arguments, "other.furrow"], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        while process.poll() is None and not (part.exists() and part.stat().st_size > 1 << 16):
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        if process.wait() == 130:
            turned = ["import", *reversed(sources), *arguments[4:], "other.furrow", "--resume"]
            self.assertIn("--resume", self.refused(3, *turned))


if __name__ == "__main__":
    main()
