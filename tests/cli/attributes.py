"""Marks that fade: what a body disturbs, bends and tears is gone in the time that the scene says. Closed forms, over drives, resumes and evictions."""
import json
import math
import pathlib
import sqlite3
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import MAPS, FurrowTest, has_gdal, main  # noqa: E402

TABLES = ("offset", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")
BALL = "objects: [{name: ball, shape: {sphere: {radius: 1}}, sink: %g, path: {points: [[%g, %g]], speed: 1, delay: %g}}]\n"
WHEEL = "{name: %s, shape: {wheel: {radius: 0.5, width: 0.5}}, %s, path: {points: [[%g, %g], [%g, %g]], speed: %g}}"
HEALS = "attributes: {disturbance: {heals: %g}}\n"
PLANTS = "attributes: {disturbance: {heals: 4000}, vegetation: {cover: 0.9, height: 0.2, tears: 0.5, rises: 400, grows: 8000}}\n"
# Two cross each other's tracks, one of them slips; they cross borders of tiles, too.
CROSS = ("objects: [" + WHEEL % ("a", "sink: 0.1", 20, 20, 44, 46, 3) + ", " + WHEEL % ("b", "sink: 0.15, slip: 0.2", 44, 20, 20, 46, 2.5) + "]\n")
MODELS = {"none": "", "box": "", "sumner": "soil: {name: sand}\n", "slippage": "soil: {name: dry_sand}\n", "scm": "soil: {name: dry_sand}\n"}


def whole(seconds):
    return int(4 * seconds)


def gone(time, shades, seconds):
    """When a mark is gone, quarter seconds."""
    return math.floor(4 * time) - -shades * whole(seconds) // 255


def left(until, time, seconds):
    """The shades of a mark that are left."""
    return max(0, min(255, (until - math.floor(4 * time)) * 255 // whole(seconds)))


def darkness(offset):
    """The shades of a post that was lowered just now."""
    return min(255, 96 + (round(-offset * 2**20) >> 10))


class Attributes(FurrowTest):
    def head(self, end, step=10.0, model="box", spacing=0.25):
        return f"scene: 1\ntime_step: {step:g}\nend_time: {end:g}\nspacing: {spacing:g}\noutside: skip\nredistribute: {{model: {model}}}\n" + MODELS[model]

    def ground(self, tile=64, relief=0):
        name = f"ground-{tile}-{relief}.furrow"
        if not (self.folder / name).exists():
            self.ok("synth", "-o", "ground.tif", "--posts", "129x129", "--spacing", 0.5, "--kind", "dunes" if relief else "plain", "--relief", relief or 1, "--overwrite")
            self.ok("import", "ground.tif", "-o", name, "--tile", tile)
        return name

    def left(self, text, overlay, *more, base=None):
        self.scene(text)
        return self.drive("scene.yaml", "--store", base or self.ground(), "--overlay", overlay, *more)

    def soil(self, store, x, y):
        point = self.json("query", store, x, y)["points"][0]
        return point["offset"], point["soil"]

    def rows(self, store):
        db = sqlite3.connect(self.folder / store)
        rows = {table: db.execute(f'SELECT key, low, high, codec, hash, blob FROM "{table}" ORDER BY key').fetchall() for table in TABLES}
        db.close()
        return rows

    def test_disturbance_heals_as_its_closed_form_says(self):
        for number, (heals, end, sink) in enumerate(((64, 50, 0.1), (1000, 300, 0.02), (86400, 40000, 0.15))):
            store = f"heals-{number}.furrow"
            self.left(self.head(end, step=end / 20) + HEALS % heals + BALL % (sink, 30, 30, 3.3), store)
            offset, soil = self.soil(store, 30, 30)
            shades = darkness(offset)
            self.assertGreater(shades, 96)
            self.assertEqual(soil["dirt"], left(gone(3.3, shades, heals), end, heals), (heals, offset))
            self.assertTrue(0 < soil["dirt"] < shades, (heals, soil, shades))
            self.assertEqual(self.soil(store, 10, 10)[1]["dirt"], 0)

    def test_what_is_healed_is_gone(self):
        self.left(self.head(200, step=50) + HEALS % 100 + BALL % (0.1, 30, 30, 3), "gone.furrow")
        offset, soil = self.soil("gone.furrow", 30, 30)
        self.assertLess(offset, -0.09)
        self.assertEqual(soil["dirt"], 0)

    def test_time_goes_on_from_drive_to_drive(self):
        heals = 2000
        self.left(self.head(300, step=20) + HEALS % heals + BALL % (0.1, 30, 30, 10), "two.furrow")
        first = darkness(self.soil("two.furrow", 30, 30)[0])
        # A drive without marks lets time go on, too; then 500 s pass; in the last one another ball falls.
        self.left(self.head(100, step=20) + BALL % (0.1, 44, 44, 5), "two.furrow")
        self.assertEqual(self.soil("two.furrow", 30, 30)[1]["dirt"], left(gone(10, first, heals), 400, heals))
        self.left(self.head(200, step=20) + f"attributes: {{disturbance: {{heals: {heals}}}, elapsed: 500}}\n" + BALL % (0.05, 20, 30, 40), "two.furrow")
        offset, soil = self.soil("two.furrow", 20, 30)
        self.assertEqual(soil["dirt"], left(gone(940, darkness(offset), heals), 1100, heals))
        older = self.soil("two.furrow", 30, 30)[1]["dirt"]
        self.assertEqual(older, left(gone(10, first, heals), 1100, heals))
        self.assertTrue(0 < older < soil["dirt"])
        self.assertEqual(self.soil("two.furrow", 44, 44)[1]["dirt"], 0)

    def test_another_rate_lets_older_marks_go_when_they_would_have(self):
        self.left(self.head(100, step=20) + HEALS % 400 + BALL % (0.1, 30, 30, 10), "rates.furrow")
        until = gone(10, darkness(self.soil("rates.furrow", 30, 30)[0]), 400)
        self.left(self.head(40, step=20) + HEALS % 800 + BALL % (0.1, 40, 40, 10), "rates.furrow")
        self.assertEqual(self.soil("rates.furrow", 30, 30)[1]["dirt"], left(until, 140, 800))
        self.left(self.head(100, step=20) + HEALS % 100 + BALL % (0.1, 20, 40, 10), "rates.furrow")
        self.assertEqual(self.soil("rates.furrow", 30, 30)[1]["dirt"], left(until, 240, 100))

    def test_no_step_size_tile_slot_or_computer_shows(self):
        for model in MODELS:
            for relief in (0, 2):
                def ran(overlay, tile=64, step=0.1, *more):
                    self.left(self.head(12, step=step, model=model) + PLANTS + CROSS, overlay, *more, base=self.ground(tile, relief))
                    rows = self.rows(overlay)
                    self.assertTrue(rows["healed"] and rows["risen"] and rows["grown"], model)
                    return rows
                want = ran(f"{model}-{relief}-a.furrow")
                self.assertEqual(want, ran(f"{model}-{relief}-b.furrow", 64, 0.7), (model, "time step"))
                self.assertEqual(want, ran(f"{model}-{relief}-c.furrow", 64, 0.1, "--set", "cache.slots=4", "--set", "cache.loaders=1"), (model, "slots"))
                if model != "scm":
                    self.assertEqual(want, ran(f"{model}-{relief}-d.furrow", 64, 0.1, "--set", "compute=cpu"), (model, "computer"))
                ran(f"{model}-{relief}-e.furrow", 32)
                for x, y in ((24, 24.25), (32, 33), (40, 24), (32.5, 33.25), (31, 31.5)):
                    a, b = (self.soil(f"{model}-{relief}-{which}.furrow", x, y) for which in "ae")
                    self.assertEqual([a[0]] + [a[1][name] for name in ("dirt", "bent", "torn")], [b[0]] + [b[1].get(name, 0) for name in ("dirt", "bent", "torn")], (model, "tiles"))

    def test_a_drive_in_pieces_leaves_what_one_drive_leaves(self):
        for model in ("box", "scm"):
            text = self.head(12, step=0.1, model=model) + PLANTS.replace("tears", "rises: 500, tears").replace("rises: 400, ", "") + CROSS
            text = text.replace("vegetation: {", "elapsed: 77, vegetation: {")
            self.left(text, f"whole-{model}.furrow")
            for steps in ("37", "50", "1000"):
                self.left(text, f"pieces-{model}.furrow", "--resume", "--steps", steps)
            self.assertEqual(self.rows(f"whole-{model}.furrow"), self.rows(f"pieces-{model}.furrow"))
            self.assertEqual(self.soil(f"whole-{model}.furrow", 32, 33), self.soil(f"pieces-{model}.furrow", 32, 33))

    def test_other_planes_stay_as_they_are_without_marks(self):
        for model in ("box", "slippage", "scm"):
            plain, cross = self.head(12, step=0.1, model=model), CROSS if model == "scm" else CROSS.replace(", slip: 0.2", "")
            self.left(plain + cross, f"plain-{model}.furrow")
            self.left(plain + PLANTS + cross, f"marks-{model}.furrow")
            bare, marked = self.rows(f"plain-{model}.furrow"), self.rows(f"marks-{model}.furrow")
            self.assertEqual(bare["healed"] + bare["risen"] + bare["grown"], [])
            for table in TABLES[:-3]:
                self.assertEqual(bare[table], marked[table], (model, table))
            db = sqlite3.connect(self.folder / f"plain-{model}.furrow")
            self.assertNotIn("since", json.loads(db.execute("SELECT state FROM run").fetchone()[0]))
            db.close()

    def test_slip_tears_and_rolling_bends(self):
        objects = "objects: [" + ", ".join((
            WHEEL % ("rolls", "sink: 0.05", 10, 10, 50, 10, 4), WHEEL % ("slips", "sink: 0.05, slip: 0.2", 10, 20, 50, 20, 4),
            WHEEL % ("spins", "sink: 0.05, slip: 0.8", 10, 30, 50, 30, 4), WHEEL % ("brakes", "sink: 0.05, slip: -0.25", 10, 40, 50, 40, 4),
            "{name: dragged, shape: {box: {size: [1, 1, 1]}}, sink: 0.05, path: {points: [[10, 50], [50, 50]], speed: 4}}",
            "{name: foot, shape: {box: {size: [1, 1, 1]}}, sink: 0.05, path: {points: [[30, 58]], speed: 4, delay: 5}}")) + "]\n"
        end, rises, grows = 200, 400, 8000
        for model in ("none", "scm"):
            text = self.head(end, step=0.5, model=model) + PLANTS + objects
            self.left(text if model == "none" else text.replace("sink: 0.05", "load: 500", 4), f"slip-{model}.furrow")
            for y, slip in ((10, 0), (20, 0.2), (30, 0.8), (40, 0.2), (50, 1), (58, 0)):
                x = 30
                soil = self.soil(f"slip-{model}.furrow", x, y)[1]
                torn = round(255 * min(1, slip / 0.5))
                # The last contact that touches the post: when the body leaves it, within the length that touches, 1 m
                near = {left(gone(time, torn, grows), end, grows) for time in (4.5, 5, 5.5)} if torn else {0}
                self.assertLessEqual(min(near), round(soil["torn"] * 255), (model, y, soil))
                self.assertGreaterEqual(max(near), round(soil["torn"] * 255), (model, y, soil))
                self.assertLessEqual(abs(round(soil["bent"] * 255) - left(gone(5, 255, rises), end, rises)), 1, (model, y, soil))
            self.assertEqual(self.soil(f"slip-{model}.furrow", 20, 15)[1]["bent"], 0)

    def test_plants_rise_and_grow_back(self):
        rises, grows = 400, 8000
        text = self.head(20, step=1, model="none") + PLANTS + "objects: [" + WHEEL % ("a", "sink: 0.05, slip: 0.9", 20, 30, 40, 30, 4) + "]\n"
        self.left(text, "grows.furrow")
        db = sqlite3.connect(self.folder / "grows.furrow")
        until = {table: 4 * db.execute(f"SELECT max(high) FROM {table}").fetchone()[0] for table in ("risen", "grown")}
        db.close()
        at = self.soil("grows.furrow", 40, 30)[1]
        self.assertEqual(round(255 * at["bent"]), left(until["risen"], 20, rises))
        self.assertEqual(round(255 * at["torn"]), left(until["grown"], 20, grows))
        for elapsed, age in ((100, 140), (300, 460), (7000, 7480), (1000, 8500)):
            self.left(text.replace("vegetation: {", f"elapsed: {elapsed}, vegetation: {{").replace("20, 30], [40, 30", "20, 10], [30, 10"), "grows.furrow")
            at = self.soil("grows.furrow", 40, 30)[1]
            self.assertEqual(round(255 * at["bent"]), left(until["risen"], age, rises), age)
            self.assertEqual(round(255 * at["torn"]), left(until["grown"], age, grows), age)
        self.assertEqual((at["bent"], at["torn"]), (0, 0))

    @unittest.skipUnless(has_gdal(), "gdallocationinfo is the witness")
    def test_export_tells_what_query_tells(self):
        self.left(self.head(12, step=0.1, model="none") + PLANTS + CROSS, "export.furrow")
        for layer, name in (("disturbance", "dirt"), ("bent", "bent"), ("torn", "torn")):
            seen = set()
            self.ok("export", "export.furrow", "-o", f"{layer}.tif", "--layer", layer, "--window", "20,20,46,46", "--level", "-1")
            for x, y in ((20, 20), (32, 33), (24, 24.25), (40, 24.25), (30, 20)):
                told = float(subprocess.run(["gdallocationinfo", "-valonly", f"{layer}.tif", str(round((x - 20) * 4)), str(round((46 - y) * 4))],
                                            cwd=self.folder, capture_output=True, text=True).stdout)
                soil = self.soil("export.furrow", x, y)[1]
                self.assertAlmostEqual(told, soil[name] / (255 if name == "dirt" else 1), 6, (layer, x, y))
                seen.add(told > 0)
            self.assertEqual(seen, {False, True}, layer)

    @unittest.skipUnless(has_gdal() and MAPS, "gdallocationinfo is the witness of maps")
    def test_maps_show_what_query_tells(self):
        """A map is grey where nothing is, and coloured where a mark is; the stronger, the more."""
        self.left(self.head(12, step=0.1, model="none") + PLANTS + CROSS, "map.furrow")
        west, south = self.json("info", "map.furrow").get("origin", (0, 0))
        for layer, name in (("disturbance", "dirt"), ("bent", "bent"), ("torn", "torn")):
            told = self.ok("map", "map.furrow", "-o", f"{layer}.png", "--layer", layer, "--window", "18,18,48,48", "--world-file", "--grid", "none")
            self.assertIn(f"a map of {layer}", told)
            shown = []
            for x, y in ((20, 20), (32, 33), (24, 24.25), (40, 24.25), (30, 20), (46, 40)):
                bands = subprocess.run(["gdallocationinfo", "-valonly", "-geoloc", f"{layer}.png", str(west + x), str(south + y)], cwd=self.folder, capture_output=True, text=True).stdout.split()
                red, green, blue = map(int, bands[:3])
                shown.append((self.soil("map.furrow", x, y)[1][name], max(red, green, blue) - min(red, green, blue)))
            for mark, colour in shown:
                self.assertTrue(colour > 15 if mark > 0 else colour < 8, (layer, shown))
            self.assertEqual({mark > 0 for mark, _ in shown}, {False, True})

    def test_merged_and_branched_stores_keep_their_time(self):
        heals = 2000
        base = self.ground()
        self.left(self.head(100, step=20) + HEALS % heals + BALL % (0.1, 30, 30, 10), "one.furrow", base=base)
        self.left(self.head(300, step=20) + HEALS % heals + BALL % (0.1, 44, 44, 20), "other.furrow", base=base)
        self.ok("merge", "one.furrow", "other.furrow", "-o", "merged.furrow")
        for at, time in ((30, 10), (44, 20)):
            offset, soil = self.soil("merged.furrow", at, at)
            self.assertEqual(soil["dirt"], left(gone(time, darkness(offset), heals), 300, heals))
        self.ok("verify", "merged.furrow")
        self.left(self.head(100, step=20) + HEALS % heals + BALL % (0.1, 20, 44, 10), "merged.furrow", base=base)
        offset, soil = self.soil("merged.furrow", 20, 44)
        self.assertEqual(soil["dirt"], left(gone(310, darkness(offset), heals), 400, heals))
        # A branch begins with its parent's time.
        self.ok("branch", "one.furrow", "branch.furrow")
        self.left(self.head(60, step=20) + HEALS % heals + BALL % (0.1, 44, 20, 10), "branch.furrow", base="one.furrow")
        offset, soil = self.soil("branch.furrow", 30, 30)
        self.assertEqual(soil["dirt"], left(gone(10, darkness(offset), heals), 160, heals))

    def test_what_is_wrong_is_told(self):
        self.scene(self.head(10) + "attributes: {elapsed: 5, disturbance: {}}\n" + BALL % (0.1, 30, 30, 3))
        self.assertIn("attributes.elapsed", self.refused(3, "drive", "scene.yaml", "--store", self.ground(), "--overlay", "no.furrow", "-o", "out"))
        self.scene(self.head(10) + "attributes: {disturbance: {heals: 5}}\n" + BALL % (0.1, 30, 30, 3))
        self.assertIn("the unit is s", self.refused(3, "drive", "scene.yaml", "--store", self.ground(), "--overlay", "no.furrow", "-o", "out"))
        self.left(self.head(20, step=10) + "attributes: {disturbance: {heals: 100}, elapsed: 134217728}\n" + BALL % (0.1, 30, 30, 3), "old.furrow")
        self.scene(self.head(20, step=10) + "attributes: {disturbance: {heals: 100}, elapsed: 134217728}\n" + BALL % (0.1, 30, 30, 3))
        self.assertIn("furrow reset", self.refused(3, "drive", "scene.yaml", "--store", self.ground(), "--overlay", "old.furrow", "-o", "out"))

    def test_stores_of_before_are_read_and_raised(self):
        self.left(self.head(10, step=1) + "attributes: [disturbance]\n" + BALL % (0.1, 30, 30, 3), "older.furrow")
        db = sqlite3.connect(self.folder / "older.furrow")
        for table in ("healed", "risen", "grown"):
            db.execute(f"DROP TABLE {table}")
        db.execute("PRAGMA user_version=7")
        db.commit()
        db.close()
        offset, soil = self.soil("older.furrow", 30, 30)
        self.assertEqual(soil["dirt"], darkness(offset))
        self.left(self.head(10, step=1) + HEALS % 100 + BALL % (0.05, 40, 40, 3), "older.furrow")
        db = sqlite3.connect(self.folder / "older.furrow")
        self.assertEqual(db.execute("PRAGMA user_version").fetchone()[0], 8)
        db.close()
        self.assertEqual(self.soil("older.furrow", 30, 30)[1]["dirt"], darkness(offset))
        self.ok("verify", "older.furrow")


if __name__ == "__main__":
    main()
