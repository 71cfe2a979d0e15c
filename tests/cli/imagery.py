"""Imagery: `furrow import --imagery` beside GDAL's own programs, its pyramid beside a plain one, and what stores do with it."""
import math
import os
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, MAPS, largest, main
from raster_test import POSTS, SOUTH, STEP, WEST, PictureTest

def ramp(x, y):
    """A picture in which each place has its own colours, at most 2 levels a pixel of STEP."""
    return round(30 + 1.6 * x / STEP % 200), round(40 + 1.4 * y / STEP % 180), (round(x / STEP) * 7 + round(y / STEP) * 13) % 256


def noise(x, y):
    generator = random.Random(round(x / STEP) * 100003 + round(y / STEP))
    return tuple(generator.randrange(256) for _ in range(3))


class Imagery(PictureTest):
    def setUp(self):
        super().setUp()
        self.make("dem.tif", POSTS, POSTS, lambda x, y: 100 + 5 * math.sin(x / 9), west=WEST - 0.5, north=SOUTH + POSTS - 0.5, step=1, srs="EPSG:32632")

    def level(self, store, level):
        self.ok("export", store, "-o", "level.png", "--layer", "imagery", "--level", level)
        return self.pixels("level.png")[2]

    def test_pixels_on_the_lattice_are_the_pictures_own(self):
        self.picture("ortho.tif", noise)
        told = self.json("import", "--imagery", "ortho.tif", "-o", self.store(), "--lossless")["imagery"]
        self.assertEqual((told["level"], told["pixel"], told["quality"]), (-2, STEP, 0))
        read = self.level("s.furrow", -2)
        self.assertEqual(len(read), 4 * (POSTS - 1) + 1)
        for j in range(257):
            for i in range(257):
                self.assertEqual(read[j][i], noise(i * STEP, j * STEP), (i, j))

    def test_edges_of_tiles_agree_and_tiles_do_not_show(self):
        self.picture("ortho.tif", noise, 3, 5, 200, 190)  # the picture ends within the terrain
        found = {}
        for tile in (16, 64):
            self.store("--imagery", "ortho.tif", "--lossless", tile=tile)
            found[tile] = [self.level("s.furrow", level) for level in range(-2, 1)]
            self.assertTrue(self.json("verify", "s.furrow")["ok"])
            if tile == 16:
                self.edges()
        self.assertEqual(found[16], found[64])

    def edges(self):
        """A pixel that tiles share is the same in all: an export has that of the last one. Each tile is unpacked alone here."""
        shared, pairs = {}, 0
        with sqlite3.connect(self.folder / "s.furrow") as db:
            rows = db.execute("SELECT key, blob FROM imagery ORDER BY key").fetchall()
        for key, blob in rows:
            level, morton = (key >> 56) - 32, key & ((1 << 56) - 1)
            if level != 0:
                continue
            x, y = (sum((morton >> (2 * i + axis) & 1) << i for i in range(28)) for axis in (0, 1))
            (self.folder / "tile.webp").write_bytes(blob)
            width, height, cells = self.pixels("tile.webp")
            self.assertEqual((width, height), (17, 17))
            # The row's first line is the south one: WebP's first.
            for j in range(17):
                for i in range(17):
                    at = (16 * x + i, 16 * y + j)
                    pairs += at in shared
                    self.assertEqual(shared.setdefault(at, cells[16 - j][i]), cells[16 - j][i], at)
        self.assertGreater(pairs, 300)

    def test_coarser_levels_are_smoothed(self):
        self.picture("ortho.tif", noise)
        self.store("--imagery", "ortho.tif", "--lossless")
        fine, coarse = self.level("s.furrow", -2), self.level("s.furrow", -1)
        for y, x in [(0, 0), (128, 128), (0, 77), (64, 128), (30, 31), (65, 2)]:
            for c in range(3):
                total = weights = 0
                for dy, dx in ((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)):
                    if 0 <= 2 * y + dy < 257 and 0 <= 2 * x + dx < 257:
                        weight = (2 - abs(dy)) * (2 - abs(dx))
                        total += weight * fine[2 * y + dy][2 * x + dx][c]
                        weights += weight
                self.assertEqual(coarse[y][x][c], math.floor(total / weights + 0.5), (x, y, c))

    def test_other_systems_lie_within_half_a_pixel_of_gdal(self):
        """A picture in degrees, whose red and green rise by 4 levels a pixel, so that half a pixel is 2 levels; beside GDAL's own places."""
        self.picture("utm.tif", ramp, -20, -20, 420, 420)
        self.gdal("gdalwarp", "-q", "-t_srs", "EPSG:4326", "-r", "bilinear", "utm.tif", "degrees.tif")
        info = self.json_of("degrees.tif")
        place, (columns, rows) = info["geoTransform"], info["size"]
        data = b"".join(bytes(((4 * i) % 256, (4 * j) % 256, 128)) for j in range(rows) for i in range(columns))
        (self.folder / "degrees.ppm").write_bytes(b"P6\n%d %d\n255\n" % (columns, rows) + data)
        self.gdal("gdal_translate", "-q", "-a_srs", "EPSG:4326", "-a_ullr", place[0], place[3], place[0] + columns * place[1], place[3] + rows * place[5],
                  "degrees.ppm", "ortho.tif")
        self.store("--imagery", "ortho.tif", "--lossless")
        read = self.level("s.furrow", -2)
        generator = random.Random(45)
        spots = [(generator.randrange(257), generator.randrange(257)) for _ in range(50)]
        sent = "".join(f"{WEST + i * STEP} {SOUTH + j * STEP}\n" for i, j in spots)
        there = [tuple(map(float, line.split()[:2])) for line in self.gdal("gdaltransform", "-s_srs", "EPSG:32632", "-t_srs", "EPSG:4326", stdin=sent).splitlines()]
        located = self.gdal("gdallocationinfo", "-valonly", "-b", 1, "-l_srs", "EPSG:32632", "ortho.tif", stdin=sent).split()
        compared = 0
        for (i, j), (longitude, latitude), value in zip(spots, there, located):
            column, row = (longitude - place[0]) / place[1] - 0.5, (latitude - place[3]) / place[5] - 0.5
            self.assertLess(abs((4 * math.floor(column + 0.5)) % 256 - int(value)), 1)
            for at, channel in ((column, 0), (row, 1)):
                if 1 < at % 64 < 62:  # beside its jump from 255 to 0
                    compared += 1
                    self.assertLess(abs(read[j][i][channel] - 4 * (at % 64)), 2, (i, j))
        self.assertGreater(compared, 60)

    def json_of(self, name):
        import json
        return json.loads(self.gdal("gdalinfo", "-json", name))

    def test_the_first_named_wins_and_where_there_is_none(self):
        self.picture("left.tif", lambda x, y: (200, 0, 0), 0, 0, 101, 257)
        self.picture("all.tif", lambda x, y: (0, 0, 200), -5, -5, 200, 150)
        self.store("--imagery", "left.tif", "--imagery", "all.tif", "--lossless")
        read = self.level("s.furrow", -2)
        self.assertEqual((read[10][10], read[10][110], read[200][200]), ((200, 0, 0), (0, 0, 200), (0, 0, 0)))
        info = self.json("info", "s.furrow")["imagery"]
        self.assertEqual(info["sources"], ["left.tif", "all.tif"])
        told = self.gdal("gdallocationinfo", "-valonly", "-b", 4, "level.png", stdin="10 10\n200 40\n150 240\n").split()
        self.assertEqual(told, ["255", "0", "255"])  # rows from the north

    def test_nodata_is_that_of_all_bands(self):
        """A colour whose red and green are the value of nodata hides what lies under it in all bands."""
        self.picture("low.tif", lambda x, y: (200, 90, 50))
        self.picture("high.tif", lambda x, y: (0, 0, 200) if x < 30 else (0, 0, 0), 0, 0, 257, 257, STEP, "EPSG:32632", "-a_nodata", 0)
        self.store("--imagery", "high.tif", "--imagery", "low.tif", "--lossless")
        read = self.level("s.furrow", -2)
        self.assertEqual((read[50][50], read[50][200]), ((0, 0, 200), (200, 90, 50)))

    def test_a_pixel_is_as_large_as_it_is_on_the_terrain(self):
        """A picture of the globe, whose middle is nowhere in the store's zone, and whose pixels are half as large at 75 degrees as at the equator."""
        self.make("dem.tif", POSTS, POSTS, lambda x, y: 100, west=380000, north=8500000, step=4000, srs="EPSG:32660")
        (self.folder / "picture.ppm").write_bytes(b"P6\n1800 900\n255\n" + bytes((10, 200, 30)) * (1800 * 900))
        self.gdal("gdal_translate", "-q", "-a_ullr", -180, 90, 180, -90, "-a_srs", "EPSG:4326", "picture.ppm", "globe.tif")
        self.store(tile=8)
        told = self.json("import", "--imagery", "globe.tif", "-o", "s.furrow", "--lossless")["imagery"]
        self.assertEqual((told["level"], told["pixel"]), (1, 8000))
        self.assertEqual(self.level("s.furrow", 1)[16][16], (10, 200, 30))

    def test_grey_palettes_and_opacity(self):
        self.picture("rgb.tif", lambda x, y: (90, 90, 90))
        self.gdal("gdal_translate", "-q", "-b", 1, "rgb.tif", "grey.tif")
        self.gdal("gdal_translate", "-q", "-b", 1, "-of", "PNM", "rgb.tif", "grey.pgm")
        vrt = self.gdal("gdal_translate", "-q", "-of", "VRT", "grey.tif", "/vsistdout/")
        table = "<ColorInterp>Palette</ColorInterp><ColorTable>" + "<Entry c1='1' c2='2' c3='3' c4='255'/>" * 90 + "<Entry c1='10' c2='20' c3='30' c4='255'/></ColorTable>"
        (self.folder / "palette.vrt").write_text(vrt.replace("<ColorInterp>Red</ColorInterp>", table))
        self.gdal("gdal_translate", "-q", "palette.vrt", "palette.tif")
        for name, colour in (("grey.tif", (90, 90, 90)), ("palette.tif", (10, 20, 30))):
            self.store("--imagery", name, "--lossless")
            self.assertEqual(self.level("s.furrow", -2)[99][99], colour, name)
        self.gdal("gdal_translate", "-q", "-a_nodata", 90, "rgb.tif", "none.tif")
        for before in ((), ("--imagery", "rgb.tif")):
            self.assertIn("no pixel on the terrain", self.refused(3, "import", "--imagery", "none.tif", "-o", self.store(*before), *(("--overwrite",) if before else ())))
            self.assertIsNone(self.json("info", "s.furrow")["imagery"])
            self.assertEqual((self.version(), (self.folder / "s.furrow-wal").exists()), (8, False))
            self.assertTrue(self.json("verify", "s.furrow")["ok"])
            self.ok("import", "--imagery", "rgb.tif", "-o", "s.furrow")
        self.assertIn("x.furrow: it is made, without its imagery", self.refused(3, "import", "dem.tif", "--imagery", "none.tif", "-o", "x.furrow"))
        self.assertTrue(self.json("verify", "x.furrow")["ok"])

    def test_what_a_store_does_with_it(self):
        self.picture("ortho.tif", ramp)
        self.store()
        self.assertEqual(self.version(), 8)  # without imagery older programs go on reading it
        hashes = {self.json("info", "s.furrow")["base_hash"]}
        self.ok("branch", "s.furrow", "o.furrow")
        self.ok("import", "--imagery", "ortho.tif", "-o", "s.furrow")
        self.assertEqual(self.version(), 9)
        hashes.add(self.json("info", "s.furrow")["base_hash"])
        self.assertEqual(len(hashes), 1)
        self.assertEqual(self.json("info", "o.furrow")["imagery"], self.json("info", "s.furrow")["imagery"])
        self.ok("flatten", "o.furrow", "-o", "f.furrow")
        for store in ("s.furrow", "o.furrow", "f.furrow"):
            self.assertTrue(self.json("verify", store)["ok"], store)
            self.assertEqual(self.level(store, -1), self.level("s.furrow", -1))
        self.ok("reset", "s.furrow")
        self.assertIsNotNone(self.json("info", "s.furrow")["imagery"])
        self.assertIn("is an overlay", self.refused(3, "import", "--imagery", "ortho.tif", "-o", "o.furrow"))
        self.assertIn("has imagery already", self.refused(3, "import", "--imagery", "ortho.tif", "-o", "s.furrow"))
        self.picture("other.tif", lambda x, y: (1, 2, 3))
        self.ok("import", "--imagery", "other.tif", "-o", "s.furrow", "--overwrite", "--lossless")
        self.assertEqual(self.level("s.furrow", 0)[5][5], (1, 2, 3))
        with sqlite3.connect(self.folder / "s.furrow") as db:
            db.execute("UPDATE imagery SET blob = zeroblob(40) WHERE key = (SELECT max(key) FROM imagery)")
        self.assertIn("its hash is not that of its bytes", str(self.json_failed("verify", "s.furrow")["problems"]))
        (self.folder / "x.png").write_bytes(b"what was there")
        self.assertIn("it is damaged", self.refused(3, "export", "s.furrow", "-o", "x.png", "--layer", "imagery", "--level", 2))
        self.assertEqual((self.folder / "x.png").read_bytes(), b"what was there")

    def version(self):
        with sqlite3.connect(self.folder / "s.furrow") as db:
            return db.execute("PRAGMA user_version").fetchone()[0]

    def json_failed(self, *arguments):
        import json
        return json.loads(self.furrow(*arguments, "--json").stdout)

    def test_what_was_broken_off_goes_on(self):
        """A signal comes when a tenth of the tiles is written."""
        self.make("dem.tif", 129, 129, lambda x, y: 100, west=WEST - 0.5, north=SOUTH + 128.5, step=1, srs="EPSG:32632")
        grain = iter(random.Random(45).randbytes(3 * 513 * 513))
        self.picture("ortho.tif", lambda x, y: (next(grain), next(grain), next(grain)), 0, 0, 513, 513)
        self.store(tile=8)
        told = self.json("import", "--imagery", "ortho.tif", "-o", "s.furrow", "--lossless")["imagery"]
        whole = self.rows()
        self.assertEqual(told["tiles"], len(whole))
        self.store(tile=8)
        process = subprocess.Popen([FURROW, "import", "--imagery", "ortho.tif", "-o", "s.furrow", "--lossless", "--jobs", "1"], cwd=self.folder, stderr=subprocess.PIPE,
                                   text=True, env=dict(os.environ))
        while process.poll() is None and not self.begun():
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        error = process.communicate()[1]
        self.assertEqual(process.returncode, 130, error)
        self.assertIsNone(self.json("info", "s.furrow")["imagery"])
        self.assertIn("broken off", self.ok("info", "s.furrow"))
        kept = len(self.rows())
        self.assertTrue(0 < kept < len(whole), kept)
        self.assertIn("was another one", self.refused(3, "import", "--imagery", "ortho.tif", "-o", "s.furrow", "--resume"))
        again = self.json("import", "--imagery", "ortho.tif", "-o", "s.furrow", "--resume", "--lossless")["imagery"]
        self.assertEqual(self.rows(), whole)
        self.assertEqual((again["tiles"], again["bytes"]), (told["tiles"], told["bytes"]))  # of those that were kept, too

    def begun(self):
        """SQLite writes tiles there when its cache of 0.5 MB is full, long before they are committed."""
        log = self.folder / "s.furrow-wal"
        return log.exists() and log.stat().st_size > 200000

    def rows(self):
        with sqlite3.connect(self.folder / "s.furrow") as db:
            return db.execute("SELECT key, hash FROM imagery ORDER BY key").fetchall()

    @unittest.skipUnless(MAPS, "this build draws no maps")
    def test_a_map_shows_it(self):
        """Two halves of two colours: on a map of level ground each is where it lies, and has its colour."""
        self.make("dem.tif", POSTS, POSTS, lambda x, y: 100, west=WEST - 0.5, north=SOUTH + POSTS - 0.5, step=1, srs="EPSG:32632")
        self.picture("ortho.tif", lambda x, y: (220, 40, 20) if x < 32 else (20, 60, 200))
        self.store("--imagery", "ortho.tif", "--lossless")
        self.ok("map", "s.furrow", "-o", "map.png", "--layer", "imagery", "--grid", "none", "--size", 100, "--world-file")
        told = self.gdal("gdallocationinfo", "-geoloc", "-valonly", "map.png", stdin=f"{WEST + 10} {SOUTH + 30}\n{WEST + 50} {SOUTH + 30}\n").split()
        for found, colour in zip((told[:3], told[3:6]), ((220, 40, 20), (20, 60, 200))):
            self.assertLess(largest(abs(int(a) - b) for a, b in zip(found, colour)), 3)
        self.refused(2, "map", "s.furrow", "-o", "map.png", "--layer", "imagery", "--height-range", "0,1")
        self.ok("import", "dem.tif", "-o", "plain.furrow")
        self.assertIn("has no imagery", self.refused(3, "map", "plain.furrow", "-o", "x.png", "--layer", "imagery"))

    def test_map_tiles_show_it_as_finely_as_it_is(self):
        """Tiles beside the picture itself, at places of the map that gdalwarp finds; and no tile where there is no imagery."""
        import json
        def soft(x, y):
            return round(120 + 70 * math.sin(x / 7)), round(120 + 70 * math.cos(y / 5)), round(100 + x)
        (self.folder / "leaflet").mkdir()
        for name in ("leaflet.js", "leaflet.css"):
            (self.folder / "leaflet" / name).write_text("")
        self.picture("ortho.tif", soft, 8, 8, 180, 180)
        self.store("--imagery", "ortho.tif", "--lossless")
        told = self.ok("export", "s.furrow", "--tiles", "map", "--leaflet", "leaflet")
        tiles = {tuple(map(int, path.with_suffix("").parts[-3:])): path for path in (self.folder / "map/imagery").rglob("*.webp")}
        finest = max(z for z, _, _ in tiles)
        self.assertIn(f"{len(tiles)} tiles of imagery, to zoom {finest}", told)
        self.assertGreater(finest, max(int(path.name) for path in (self.folder / "map/hillshade").iterdir()))
        listed = json.loads((self.folder / "map/imagery.json").read_text())
        self.assertEqual((listed["maxzoom"], listed["tiles"][0][:27]), (finest, "imagery/{z}/{x}/{y}.webp?v="))
        size, edge = 2 * math.pi * 6378137, math.pi * 6378137
        compared = 0
        for (z, x, y), path in tiles.items():
            if z != finest:
                continue
            step = size / 2 ** z / 256
            west, north = x * size / 2 ** z - edge, edge - y * size / 2 ** z
            cells = self.pixels(path)[2]
            spots = [(i, j) for i in range(20, 256, 60) for j in range(20, 256, 60)]
            sent = "".join(f"{west + (i + 0.5) * step} {north - (j + 0.5) * step}\n" for i, j in spots)
            for (i, j), line in zip(spots, self.gdal("gdaltransform", "-s_srs", "EPSG:3857", "-t_srs", "EPSG:32632", stdin=sent).splitlines()):
                east, northing = (float(number) - of for number, of in zip(line.split(), (WEST, SOUTH)))
                if not (9 < east < 51 and 9 < northing < 51):
                    continue
                compared += 1
                for found, expected in zip(cells[255 - j][i], soft(east, northing)):
                    self.assertLess(abs(found - expected), 4, (z, x, y, i, j))
        self.assertGreater(compared, 8)
        self.ok("export", "s.furrow", "-o", "ortho.mbtiles", "--layer", "imagery")
        with sqlite3.connect(self.folder / "ortho.mbtiles") as db:
            self.assertEqual(dict(db.execute("SELECT name, value FROM metadata"))["format"], "webp")
            self.assertEqual(db.execute("SELECT count(*) FROM tiles").fetchone()[0], len(tiles))
        self.store()
        self.ok("export", "s.furrow", "--tiles", "map", "--leaflet", "leaflet")
        self.assertEqual((list((self.folder / "map/imagery").rglob("*.webp")), (self.folder / "map/imagery.json").exists()), ([], False))

    def test_mistakes(self):
        self.store()
        self.picture("ortho.tif", ramp)
        self.gdal("gdal_translate", "-q", "-ot", "UInt16", "ortho.tif", "deep.tif")
        self.picture("far.tif", ramp, 9000, 0)
        vrt = self.gdal("gdal_translate", "-q", "-of", "VRT", "ortho.tif", "/vsistdout/")
        (self.folder / "ink.vrt").write_text(vrt.replace("<ColorInterp>Red<", "<ColorInterp>Cyan<"))
        (self.folder / "plain.ppm").write_bytes(b"P6\n2 2\n255\n" + bytes(12))
        for name, status, why in (("deep.tif", 3, "8 bits a band"), ("ink.vrt", 3, "not red, green and blue"), ("far.tif", 3, "no imagery lies on the terrain"), ("plain.ppm", 3, "has no place"),
                                  ("gone.tif", 3, "gone.tif")):
            self.assertIn(why, self.refused(status, "import", "--imagery", name, "-o", "s.furrow"), name)
            self.assertIsNone(self.json("info", "s.furrow")["imagery"])
        self.assertIn("gone.furrow", self.refused(3, "import", "--imagery", "ortho.tif", "-o", "gone.furrow"))
        self.assertIn("no imagery lies on the terrain", self.refused(3, "import", "dem.tif", "--imagery", "far.tif", "-o", "gone.furrow", "--dry-run"))
        before = (self.folder / "s.furrow").read_bytes()
        for more in ((), ("--overwrite",), ("--resume",), ("--force",)):  # as of --imagery *.tif
            self.assertIn("dem.tif would be the heights", self.refused(2, "import", "--imagery", "ortho.tif", "dem.tif", "-o", "s.furrow", *more))
        self.assertIn("without --force", self.furrow("import", "--imagery", "ortho.tif", "dem.tif", "-o", "s.furrow", "--overwrite", "--dry-run").stderr)
        for option in (("--nodata", 0), ("--s-srs", "EPSG:4326"), ("--t-srs", "source"), ("--window", "0,0,9,9"), ("--spacing", 1), ("--fill",), ("--force",),
                       ("--inset", "dem.tif"), ("--tile", 64), ("--max-error", 1), ("--pack", "small")):
            self.assertIn("needs no such option", self.refused(2, "import", "--imagery", "ortho.tif", "-o", "s.furrow", *option), option)
        self.assertIn("leave one of both", self.refused(2, "import", "--imagery", "ortho.tif", "-o", "s.furrow", "--lossless", "--imagery-quality", 80))
        self.assertIn("none is named", self.refused(2, "import", "dem.tif", "-o", "gone.furrow", "--lossless"))
        self.assertEqual(((self.folder / "s.furrow").read_bytes(), (self.folder / "gone.furrow").exists()), (before, False))
        self.assertIn("has no imagery", self.refused(3, "export", "s.furrow", "-o", "x.png", "--layer", "imagery"))
        self.refused(2, "import", "-o", "gone.furrow")

    def test_bytes_beside_a_cog_of_the_same_codec(self):
        def soft(x, y):
            return tuple(min(255, max(0, round(120 + 60 * math.sin(x / (5 + c)) * math.cos(y / (6 - c)) + grain(x, y) * (1 + c)))) for c in range(3))

        def grain(x, y):
            return ((round(x / STEP) * 7919 + round(y / STEP) * 104729) % 1013 * 37 % 17) - 8
        self.make("dem.tif", 129, 129, lambda x, y: 100, west=WEST - 0.5, north=SOUTH + 128.5, step=1, srs="EPSG:32632")
        self.picture("ortho.tif", soft, 0, 0, 512, 512)
        self.store(tile=256)
        made = self.json("import", "--imagery", "ortho.tif", "-o", "s.furrow", "--imagery-quality", 80)["imagery"]
        self.gdal("gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=WEBP", "-co", "QUALITY=80", "ortho.tif", "cog.tif")
        self.assertLess(made["bytes"], 1.1 * os.path.getsize(self.folder / "cog.tif"))
        read, off = self.level("s.furrow", -2), []
        for j in range(0, 512, 8):
            for i in range(0, 512, 8):
                off.append(largest(abs(a - b) for a, b in zip(read[j][i], soft(i * STEP, j * STEP))))
        self.assertLess(sum(off) / len(off), 30)


if __name__ == "__main__":
    main()
