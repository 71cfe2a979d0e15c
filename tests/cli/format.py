"""src/store/FORMAT.md is enough: a reader written from it alone finds in stores every post that `furrow export` finds."""
import array
import contextlib
import json
import math
import pathlib
import re
import sqlite3
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import has_gdal, largest, long, main, part
from raster_test import RasterTest
import rasters
import store_reader
from store_reader import HOLE, Store, key_of

SCENE = """scene: 1
time_step: 0.05
end_time: 3
spacing: 0.25
redistribute: {model: box}
attributes: [dirt]
objects:
  - {name: wheel, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.15,
     path: {points: [[8, 8], [40, 30], [20, 44]], speed: 20}}
cache: {slots: 16}
"""


class FormatTest(RasterTest):
    nodata = {}  # of a layer's raster

    def grid(self, name, width, height, value, cell=2):
        """An ESRI ASCII grid; value(x, y) of posts from the south-west, None: nodata."""
        rows = [" ".join("-9999" if (v := value(x, y)) is None else format(v, ".19f") for x in range(width))
                for y in reversed(range(height))]
        (self.folder / name).write_text(f"ncols {width}\nnrows {height}\nxllcenter 500000\nyllcenter 5000000\n"
                                        f"cellsize {cell}\nNODATA_value -9999\n" + "\n".join(rows) + "\n")
        return name

    def import_(self, source, *arguments, store="s.furrow"):
        self.ok("import", source, "-o", store, "--overwrite", *arguments)
        return self.folder / store

    def raster(self, path, layer, level, code):
        """(width, height, pixels in rows from the south, the nodata value)"""
        self.ok("export", path, "-o", "read.tif", "--layer", layer, "--level", level)
        width, height, cells = rasters.pixels(self.folder / "read.tif", code)
        south_up = array.array(code)
        for y in reversed(range(height)):
            south_up += cells[y * width:(y + 1) * width]
        if layer not in self.nodata:
            self.nodata[layer] = rasters.nodata_of(self.folder / "read.tif")
        return width, height, south_up, self.nodata[layer]

    def same_posts(self, path, store, layer, level):
        """The reader's posts and the export's, bit for bit."""
        code = "i" if layer == "quanta" else "f"
        width, height, exported, nodata = self.raster(path, layer, level, code)
        self.assertEqual((width, height), store.size(level))
        if layer == "quanta":
            read = store.offset(level)
        elif layer == "base":
            read = store.base(level)
        else:
            read = [None if base is None else base + offset / 2**20
                    for base, offset in zip(store.base(level), store.offset(level))]
        read = array.array(code, [nodata if post is None else post for post in read])
        if read.tobytes() != exported.tobytes():
            wrong = [i for i in range(width * height) if read[i:i + 1].tobytes() != exported[i:i + 1].tobytes()]
            first = [(i % width, i // width, read[i], exported[i]) for i in wrong[:5]]
            self.fail(f"{layer} level {level}: {len(wrong)} of {width * height} posts, first x, y, read, exported: {first}")
        return read

    def needs(self, name):
        try:
            store_reader.library(name)
        except store_reader.NoLibrary as error:
            self.skipTest(str(error))

    def hashes(self, path, store):
        try:
            for table in store.rows.values():
                for row in table.values():
                    self.assertEqual(row.hash, row.expected_hash(), (row.level, row.x, row.y))
            self.assertEqual(store.meta["base_hash"], store.expected_base_hash())
            self.assertEqual(format(store.meta["base_hash"] % 2**64, "016x"), self.json("info", path)["base_hash"])
        except store_reader.NoLibrary:
            pass

    @staticmethod
    def covered(rows, row):
        """The rows of the tiles that a row's tile covers at the level below."""
        keys = [key_of(row.level - 1, 2 * row.x + i, 2 * row.y + j) for j in (0, 1) for i in (0, 1)]
        return [rows[key] for key in keys if key in rows]

    def is_decimation(self, store, coarse, fine, level):
        (wide, high), width = store.size(level), store.size(level - 1)[0]
        self.assertEqual(coarse, [fine[2 * y * width + 2 * x] for y in range(high) for x in range(wide)])

    def base_rows(self, store):
        """What the page says of a base row beside its posts, from the posts."""
        cells, side = store.cells, store.cells + 1
        for row in store.rows["base"].values():
            heights = [store.height_of(code) for code in row.posts]
            finer = self.covered(store.rows["base"], row)
            low = [v for v in heights + [tile.low for tile in finer] if v is not None]
            high = [v for v in heights + [tile.high for tile in finer] if v is not None]
            self.assertEqual((row.low, row.high), (min(low), max(high)) if low else (None, None))
            self.assertEqual(row.revision, 0)
            error = 0
            for tile in finer:
                off = 0
                for at, code in enumerate(tile.posts):
                    y, x = divmod(at, side)
                    x, y = x + (tile.x - 2 * row.x) * cells, y + (tile.y - 2 * row.y) * cells
                    around = [heights[j * side + i] for j in {y // 2, (y + 1) // 2} for i in {x // 2, (x + 1) // 2}]
                    if code != HOLE and None not in around:
                        off = max(off, abs(sum(around) / len(around) - store.height_of(code)))
                error = max(error, off + tile.error)
            self.assertAlmostEqual(row.error, error, delta=1e-9 * (1 + error))
        low, high = zip(*((row.low, row.high) for row in store.rows["base"].values() if row.low is not None))
        self.assertEqual((store.meta["low"], store.meta["high"]), (min(low), max(high)))

    def whole_base(self, path, levels=(-2, -1, 0, 1, 2)):
        """The reader's store, after all of its base was found to be what the program says it is."""
        store = Store(path)
        planes = [store.plane("base", level, HOLE) for level in range(store.coarsest + 1)]
        for level in range(1, store.coarsest + 1):
            self.is_decimation(store, planes[level], planes[level - 1], level)
        self.base_rows(store)
        self.hashes(path, store)
        for level in {*levels, store.coarsest}:
            self.same_posts(path, store, "base", level)
        return store

    @staticmethod
    def written_as(store, table="base"):
        return {(row.codec, row.flags) for row in store.rows[table].values()}


class Bases(FormatTest):
    @staticmethod
    def mixed(x, y):
        """Flat, absent, scattered with holes, rough and smooth parts, in 75 x 50 posts."""
        if 16 <= x <= 32 and 16 <= y <= 32:
            return 321
        if x >= 48 and y <= 16 or (x * 7 + y * 13) % 97 == 0:
            return None
        return 300 + 20 * math.sin(x / 9) + (15 if x > 30 else 300 * (x * x * y % 11)) * math.cos(y / 7)

    def test_every_codec_and_height_code(self):
        self.grid("in.asc", 75, 50, self.mixed)
        seen = set()
        for pack in ("fast", "small"):
            if pack == "small":
                self.needs("libzstd.so.1")
            for error in ("0.01", "0"):
                with self.subTest(pack=pack, error=error):
                    path = self.import_("in.asc", "--tile", "16", "--pack", pack, "--max-error", error)
                    store = self.whole_base(path, levels=(-2, -1, 0, 1, 2) if pack == "fast" else (0, 1))
                    self.assertEqual((store.step == 0, store.coarsest), (error == "0", 3))
                    self.assertEqual(store.meta["pack"], ("fast", "small").index(pack))
                    seen |= self.written_as(store)
        seen |= self.written_as(self.whole_base(self.import_("in.asc", "--tile", "128"), levels=(0,)))  # most of it beyond the terrain
        self.grid("board.asc", 65, 65, lambda x, y: 500 + (x + y) % 2)
        seen |= self.written_as(self.whole_base(self.import_("board.asc", "--tile", "64"), levels=(0,)))  # all widths are alike
        # The data are still such that every kind of blob was read.
        self.assertEqual({codec for codec, _ in seen}, {0, 1, 2, 3, 4, 5})
        for codec, wanted in ((1, {1, 2}), (3, {1}), (4, {1, 16, 32, 64})):
            found = {flag for one, flags in seen if one == codec for flag in (1, 2, 4, 16, 32, 64) if flags & flag}
            self.assertEqual(found, wanted, codec)

    @long
    def test_insets_one_within_the_other(self):
        """Below level 0 too the page says where each post comes from."""
        self.grid("coarse.asc", 20, 15, lambda x, y: round(300 + 20 * math.sin(x / 4)) if (x, y) != (12, 7) else None, cell=8)
        for name, first, side, cell in (("site.asc", 3, 20, 2), ("scan.asc", 5, 14, 0.5)):
            self.grid(name, side, side, lambda x, y: 310 + 3 * math.sin(x / 3) * math.cos(y / 5), cell=cell)
            text = (self.folder / name).read_text()
            for axis, at in (("xll", 500000), ("yll", 5000000)):
                text = text.replace(f"{axis}center {at}\n", f"{axis}center {at + 8 * first}\n")
            (self.folder / name).write_text(text)
        for tile in (8, 16):
            path = self.import_("coarse.asc", "--inset", "site.asc", "--inset", "scan.asc", "--feather", "2", "--tile", str(tile))
            store = self.whole_base(path, levels=(-5, -4, -3, -2, -1, 0))
            self.assertEqual({row.level for row in store.rows["base"].values() if row.level < 0}, {-1, -2, -3, -4})

    @long
    def test_a_step_that_is_no_power_of_two(self):
        self.make("in.tif", 70, 50, lambda x, y: x * x // 7 + 3 * y * (x % 3), "h",
                  options=["-a_scale", "0.1", "-a_offset", "-200"])
        self.assertEqual(self.whole_base(self.import_("in.tif", "--tile", "16"), levels=(-1, 0, 1)).step, 0.1)

    @long
    def test_steps_at_the_bound(self):
        """Twice the bound in 1024ths of a metre; what is exported is within the bound of what was imported."""
        height = lambda x, y: 1500 + 700 * math.sin(x / 11 + y / 7) + x * 0.0137
        self.make("in.tif", 83, 45, height)
        for error, step in part((("0.1", 204 / 1024), ("0.01", 20 / 1024), ("0.37", 757 / 1024), ("0.0007", 1 / 1024), ("0.0003", 2**-11)), 1, 4):
            with self.subTest(error=error):
                path = self.import_("in.tif", "--tile", "16", "--max-error", error)
                self.assertEqual(self.whole_base(path, levels=(-1, 0, 1)).step, step)
                width, high, pixels, _ = self.raster(path, "base", 0, "f")
                _, _, source = rasters.pixels(self.folder / "in.tif", "f")
                source = [source[(high - 1 - y) * width + x] for y in range(high) for x in range(width)]
                most = largest(abs(a - b) for a, b in zip(pixels, source, strict=True))
                self.assertTrue(step * 0.49 < most <= float(error), most)

    @long
    def test_halves_of_the_lattice_negative_zero_and_high_places(self):
        for name, value in (("halves", lambda x, y: (x * 5 + y * 3 - 90) * 2**-19),
                            ("zeros", lambda x, y: -0.0 if (x + y) % 3 else 2**-140),
                            ("high", lambda x, y: 8500 - 0.3 * x * y - 2**-9 * x)):
            with self.subTest(name=name):
                self.make("in.tif", 41, 37, value)
                self.whole_base(self.import_("in.tif", "--tile", "16", "--max-error", "0"), levels=(-2, -1, 0))

    @long
    def test_tiles_of_synthetic_terrain(self):
        for kind in ("ridged", "dunes", "plain"):
            with self.subTest(kind=kind):
                self.whole_base(self.synth(posts="70x99", kind=kind, spacing=0.7), levels=(-1,))

    def test_the_page_has_the_words_of_the_tables(self):
        self.synth(posts="65x65")
        page = (pathlib.Path(__file__).parents[2] / "src/store/FORMAT.md").read_text()
        words = " ".join(page.split())
        with contextlib.closing(sqlite3.connect(self.folder / "world.furrow")) as db:
            tables = db.execute("SELECT sql FROM sqlite_schema WHERE name NOT LIKE 'sqlite_%'").fetchall()
        self.assertEqual(len(tables), 22)
        for sql, in tables:
            self.assertTrue("`" + sql.removeprefix("CREATE TABLE ") + "`" in words, sql)


class Deformed(FormatTest):
    @staticmethod
    def ground(x, y):
        if x >= 52 and y <= 16 or x > 50 and (x * 7 + y * 13) % 97 == 0:
            return None
        return 300 + 2 * math.sin(x / 9) + 1.5 * math.cos(y / 7)

    def driven(self, text, width, *where, store="s.furrow", bound="0.001"):
        self.grid("in.asc", width, 58, self.ground, cell=1)
        self.import_("in.asc", "--tile", "16", "--max-error", bound, store=store)
        return self.drive(self.scene(text), "--store", self.folder / store, *where)

    def deformation_rows(self, store):
        """What the page says of rows of offsets and soil beside their posts, from the posts."""
        side = store.cells + 1
        for table, unit in (("offset", 2**-20), ("dirt", 1), ("heaped", 2**-20), ("pressed", 2**-20), ("shear", 2**-15), ("dug", 2**-20), ("settled", 2**-20), ("loose", 2**-20), ("floor", 2**-20), ("density", 2**-20), ("slope", 2**-9), ("healed", 0.25), ("risen", 0.25), ("grown", 0.25)):
            rows = store.rows[table]
            for row in rows.values():
                if table not in ("offset", "dirt"):
                    self.assertEqual(row.level, store.working)
                    self.assertTrue(any(row.posts))
                    parts = row.posts
                    if table in ("shear", "slope"):
                        halves = [post >> half & 0xffff for post in row.posts for half in (0, 16)]
                        parts = halves if table == "slope" else [store_reader.signed(half, 16) for half in halves]
                    self.assertEqual((row.low, row.high), (min(parts) * unit, max(parts) * unit))
                    self.assertTrue(1 <= row.revision <= store.run[0]["epoch"])
                    continue
                finer = self.covered(rows, row)
                self.assertEqual(bool(finer), row.level > store.working)
                self.assertTrue(finer or any(row.posts))
                self.assertEqual(row.low, min([post * unit for post in row.posts] + [tile.low for tile in finer]))
                self.assertEqual(row.high, max([post * unit for post in row.posts] + [tile.high for tile in finer]))
                self.assertTrue(row.level == store.coarsest or key_of(row.level + 1, row.x // 2, row.y // 2) in rows)
                self.assertTrue(1 <= row.revision <= store.run[0]["epoch"])
                if table == "dirt":
                    continue
                across, up = store.tiles(row.level)
                own = [row.posts[y * side + x] for y in range(side - (row.y + 1 < up))
                       for x in range(side - (row.x + 1 < across))]
                self.assertEqual((row.below, row.above), (sum(v for v in own if v < 0), sum(v for v in own if v > 0)))

    def whole_deformation(self, path, levels=(-3, -2, -1, 0, 1)):
        store = Store(path)
        self.assertGreater(min(len(store.rows["offset"]), len(store.rows["dirt"])), 1)
        sums = self.json("verify", path)["offset_sum"]
        self.assertEqual(self.json("info", path)["compacted"], store.compacted)
        for level in range(store.working, store.coarsest + 1):
            offsets, soil = store.offset(level), store.dirt(level)
            rows = [row for row in store.rows["offset"].values() if row.level == level]
            self.assertEqual(sum(row.below + row.above for row in rows), sum(offsets))
            self.assertEqual(sums[str(level)], sum(offsets))
            if level > store.working:
                self.is_decimation(store, offsets, finer[0], level)
                self.is_decimation(store, soil, finer[1], level)
            finer = offsets, soil
        self.deformation_rows(store)
        self.hashes(path, store)
        for level in {*levels, store.coarsest}:
            self.same_posts(path, store, "quanta", level)
        self.same_posts(path, store, "surface", store.working)
        self.same_posts(path, store, "surface", store.working - 1)
        return store

    def same_soil(self, path, store):
        wide, _ = store.size(store.working)
        soil = store.dirt(store.working)
        posts = [at for at, dirt in enumerate(soil) if dirt][::7] + [0, len(soil) - 1]
        size = store.meta["spacing"] * 2**store.working
        lines = "".join(f"{at % wide * size!r} {at // wide * size!r}\n" for at in posts)
        points = self.json("query", path, stdin=lines)["points"]
        self.assertEqual([point["soil"]["dirt"] for point in points], [soil[at] for at in posts])
        self.assertGreater(len(posts), 50)

    def test_a_driven_store_and_an_overlay(self):
        (self.folder / "over").mkdir()
        self.driven(SCENE, 75, "--overlay", "over/o.furrow", bound="0.03")
        over = self.whole_deformation(self.folder / "over/o.furrow")
        self.same_soil(self.folder / "over/o.furrow", over)
        self.assertEqual((over.working, over.meta["base_path"]), (-2, "../s.furrow"))
        self.assertIn(2, {codec for codec, _ in self.written_as(over, "offset")})
        self.same_posts(self.folder / "over/o.furrow", over, "base", -1)
        self.assertEqual(Store(self.folder / "s.furrow").offset(0), [0] * 75 * 58)
        # The base may be deformed: it is the same base, and the overlay has nothing of it.
        self.drive(self.scene(SCENE.replace("[20, 44]", "[70, 20]")), "--store", "s.furrow", "--set", "outside=skip")
        driven, again = Store(self.folder / "s.furrow"), Store(self.folder / "over/o.furrow")
        self.assertEqual(again.offset(-2), over.offset(-2))
        self.assertNotEqual(driven.offset(-2), over.offset(-2))
        self.whole_deformation(self.folder / "s.furrow", levels=(-2, 0))

    def test_the_page_has_the_members_of_a_run_s_state(self):
        self.driven(SCENE, 75, bound="0.03")
        page = (pathlib.Path(__file__).parents[2] / "src/store/FORMAT.md").read_text()
        part = page.split("`state` is a JSON object")[1].split("`revision` is the epoch")[0]
        named = {word for line in part.splitlines() if line.startswith("| `") for word in re.findall(r"`(\w+)`", line.split(" | ")[0])}
        with contextlib.closing(sqlite3.connect(self.folder / "s.furrow")) as db:
            state = json.loads(db.execute("SELECT state FROM run").fetchone()[0])
        written = {*state, *state["objects"][0], *state["objects"][0]["force"]}
        self.assertEqual(written | {"attached", "added", "carried", "in_flight", "since", "heals", "rises", "grows", "grains", "landed", "thrown", "lost", "trend"}, named)  # only with vehicles, where soil was added, with marks that fade, with carried and thrown soil, and with forces

    def test_a_chain_of_overlays(self):
        self.driven(SCENE, 75)
        for name, way, under in (("a", "[70, 20]", "s"), ("b", "[30, 50]", "a"), ("c", "[60, 44]", "b")):
            self.drive(self.scene(SCENE.replace("[20, 44]", way)), "--store", f"{under}.furrow", "--overlay", f"{name}.furrow",
                       "--set", "outside=skip")
        before, after = Store(self.folder / "s.furrow"), Store(self.folder / "c.furrow")
        self.assertNotEqual(before.offset(-2), after.offset(-2))
        self.assertEqual(after.meta["parent_revision"], self.json("info", "b.furrow")["last_run"]["epochs"])
        self.whole_deformation(self.folder / "c.furrow", levels=(-2, 0))

    @long
    def test_a_working_level_above_the_source_s_that_ends_before_the_terrain(self):
        text = SCENE
        for old, new in (("spacing: 0.25", "spacing: 2.5\noutside: skip"), ("radius: 0.8, width: 0.6", "radius: 9, width: 8"),
                         ("sink: 0.15", "sink: 1.5"), ("[20, 44]", "[75, 57], [60, 57]"), ("end_time: 3", "end_time: 6")):
            text = text.replace(old, new)
        self.driven(text, 76)
        store = self.whole_deformation(self.folder / "s.furrow", levels=(-1, 0, 1, 2))
        self.assertEqual((store.working, store.size(1)), (1, (38, 29)))
        offsets = store.offset(0)
        self.assertTrue(any(offsets[y * 76 + 75] for y in range(58)))
        self.assertTrue(any(offsets[57 * 76:]))

    def test_rows_written_from_the_page_are_verified(self):
        """Raised ground, which no drive makes yet: a stranger's own rows, with their sums and hashes."""
        self.grid("in.asc", 65, 65, lambda x, y: 10 + x % 5 + y % 3)
        path = self.import_("in.asc", "--tile", "16")
        store = Store(path)
        up = 5 * 2**19 + 1
        self.needs("libxxhash.so.0")
        with contextlib.closing(sqlite3.connect(path)) as db, db:
            for tile in store.rows["base"].values():
                across, north = store.tiles(tile.level)
                counted = (16 + (tile.x + 1 == across)) * (16 + (tile.y + 1 == north))
                record = {"key": tile.key, "low": up / 2**20, "high": up / 2**20, "below": 0, "above": up * counted,
                          "codec": 0, "revision": 1, "hash": 0, "blob": struct.pack("<i", up)}
                record["hash"] = store_reader.Row(record, 17, "offset").expected_hash()
                db.execute('INSERT INTO "offset" VALUES (:key, :low, :high, :below, :above, :codec, :revision, :hash, :blob)',
                           record)
            # What is kept of the soil's state, of the working level alone.
            for table, unit, value in (("heaped", 2**-20, -3), ("pressed", 2**-20, 2**19 + 1), ("shear", 2**-15, 0x30003)):
                for tile in store.rows["base"].values():
                    if tile.level > 0:
                        continue
                    range_of = (value & 0xffff if table == "shear" else value) * unit
                    record = {"key": tile.key, "low": range_of, "high": range_of, "codec": 0, "revision": 1,
                              "blob": struct.pack("<i", value)}
                    record["hash"] = store_reader.Row(record, 17, table).expected_hash()
                    db.execute(f"INSERT INTO {table} VALUES (:key, :low, :high, :codec, :revision, :hash, :blob)", record)
            db.execute("INSERT INTO meta VALUES ('working', 0)")
            db.execute("INSERT INTO meta VALUES ('compacted', -5)")
            db.execute("INSERT INTO run VALUES (1, 1, '', 1, 0.5, '', 0, '', '')")
        check = self.json("verify", path)
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["offset_sum"], {str(level): up * ((64 >> level) + 1)**2 for level in range(3)})
        self.assertEqual(check["compacted"], -5)
        store = Store(path)
        self.deformation_rows(store)
        self.same_posts(path, store, "quanta", -1)
        self.same_posts(path, store, "surface", 0)
        point, info = self.json("query", path, "20", "30.5"), self.json("info", path)
        self.assertEqual(point["soil"], {"dirt": 0, "deposited": -3 / 2**20, "plastic_sinkage": 0.5 + 2**-20, "shear": [3 / 2**15, 3 / 2**15]})
        self.assertEqual(info["compacted"], -5)
        self.assertEqual({name: found["tiles"] for name, found in info["soil"].items()},
                         {"dirt": 0, "deposited": 16, "plastic_sinkage": 16, "shear": 16, "dug": 0, "settled": 0, "loose": 0, "floor": 0, "density": 0, "slope": 0, "healed": 0, "risen": 0, "grown": 0})
        self.assertEqual((info["tiles"]["soil"], info["bytes"]["soil"]), (48, 48 * 4))
        if has_gdal():
            self.assertIn("2 m apart", self.ok("export", path, "-o", "heaped.tif", "--layer", "heaped"))
        self.ok("reset", path)
        info = self.json("info", path)
        self.assertEqual((info["tiles"]["soil"], info["tiles"]["offset"], info["compacted"]), (0, 0, 0))


if __name__ == "__main__":
    main()
