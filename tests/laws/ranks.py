"""Law 12: a drive by any number of MPI processes leaves the rows, objects.csv and vehicles.csv of one process. After a kill of any of
them the drive is resumed by any number. What cannot be done together is refused with one message.

Here 2 and 3 processes and a few kills. By hand: RANKS=2,3,4,8 KILLS=100 RANKS_SEED=7 python3 ranks.py"""
import fcntl
import filecmp
import json
import math
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FULL, FURROW, FurrowTest, chosen_tests, main

RANKS = [int(n) for n in os.environ.get("RANKS", "2,3").split(",")]
KILLS = int(os.environ.get("KILLS", "4" if FULL else "1"))
SEED = int(os.environ.get("RANKS_SEED", "1"))
MODELS = pathlib.Path(os.environ.get("SCENES", "")) / "vehicles"
TABLES = ("offset", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")
# Rows name the commit that wrote them, which may differ.
COMMIT = ("revision", "epoch")


def wheel(name, points, speed, more="load: 2000", radius=0.5):
    return (f"  - {{name: {name}, shape: {{wheel: {{radius: {radius}, width: 0.3}}}}, {more}, "
            f"path: {{points: {points}, speed: {speed}}}}}\n")


def scene(model, end, objects, spacing=0.125, step=0.05, more=""):
    soil = "" if model.startswith(("box", "sheet")) else "soil: {name: dry_sand}\n"
    rows = "output: {forces: 20}\n" if model == "scm" else ""
    return (f"scene: 1\ntime_step: {step}\nend_time: {end}\nspacing: {spacing}\nredistribute: {{model: {model}}}\n{soil}{rows}"
            f"cache: {{slots: 24}}\n{more}objects:\n{objects}")


# Tiles of 64 cells are 8 m wide at 1/8 m. Four wheels meet at the corner of four tiles at (128, 128); others cross their ruts later.
CROSSING = scene("scm", 4, "".join(
    wheel(f"c{i}", [[128 + 12 * x, 128 + 12 * y], [128 - 14 * x, 128 - 14 * y]], 6)
    for i, (x, y) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1)))) +
    wheel("late", [[116, 100], [116, 130], [140, 131]], 12, "load: 1500"))
# All of it is one group: one rank computes it, and the others have nothing.
CONVOY = scene("scm", 2, "".join(wheel(f"w{i}", [[20 - 2 * i, 30], [60, 33]], 8) for i in range(4)))
# Wheels beside each other bend one sheet, over the edges of tiles; two pass close by others that stand.
SHEET = scene("sheet, tension: 3000, yield: 0.05, rut: 0.5", 3, "".join(
    wheel(f"s{i}", [[128 + 12 * x, 126 + 12 * y], [128 - 14 * x, 129 - 14 * y]], 6, "sink: 0.1")
    for i, (x, y) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1)))) +
    wheel("beside", [[127, 100], [127.5, 130]], 12, "sink: 0.15") + wheel("stands", [[126, 126.5]], 1, "sink: 0.12") + wheel("far", [[20, 100], [60, 101]], 9, "load: 900"))
ALONE = scene("box", 2, wheel("only", [[20, 30], [60, 33]], 12, "sink: 0.1"))
# Heaps at both sides of a tile's edge slide for long after what made them has gone, slowly: an iteration each 0.2 s.
HEAPS = scene("sumner", 4, "".join(
    f"  - {{name: b{i}, shape: {{sphere: {{radius: 1.2}}}}, sink: 0.9, path: {{points: [[{x}, {y}], [{to}, {y}]], speed: 10}}}}\n"
    for i, (x, y, to) in enumerate(((36, 60, 61.5), (20, 92, 62), (92, 61, 66.5), (100, 92, 66)))), step=0.04).replace(
        "model: sumner", "model: sumner, iterations: 2, interval: 0.1")
# One stands where it was carried, on soil that slides, when a rank with others takes it over.
STANDING = scene("scm", 5, wheel("stands", [[60, 60], [62, 60]], 4, "load: 4000") + wheel("far", [[20, 100], [60, 101]], 9) +
                 wheel("a", [[100, 60], [64, 60]], 9) + wheel("b", [[100, 62.5], [63, 61.5]], 9) + wheel("c", [[101, 57], [62, 58]], 9))
# Two pass at both sides of a tile's edge, on two ranks, and wake the same blocks there. The first interval comes after the end.
BOTH_SIDES = scene("sumner", 0.8, "".join(wheel(f"w{x}", [[x, 20], [x, 40]], 2, "sink: 0.1") for x in (61, 67))).replace(
    "model: sumner", "model: sumner, iterations: 8, interval: 1")
# Slow wheels have a path sample in 0.3 to 0.42 s and a row in 0.33 s: a sample's forces are asked for long before the row that has them. Fast ones
# on another rank come by meanwhile, and take them over.
LATE = scene("scm", 2.5, "".join(wheel(f"slow{x}", [[x, 60], [x + 3, 60]], speed, "sink: 0.06")
    for x, speed in ((70, 0.3), (90, 0.33), (110, 0.36), (130, 0.39), (150, 0.42))) + "".join(
    wheel(f"fast{i}", [[30 - 2 * i, 63], [180, 63]], 22, "sink: 0.05") for i in range(6)), step=0.01).replace("forces: 20", "forces: 3")
SPREAD = scene("box", 4, "".join(
    wheel(f"s{i}", [[16 + 20 * i, 20 + 7 * i], [200 - 19 * i, 190 - 13 * i]], 25, "sink: 0.08") for i in range(9)), step=0.1)


def on_ring(i, r, turned):
    """A place on a ring around the middle, for the body with this number."""
    angle = math.pi / 4 * i + turned
    return [round(128 + r * math.cos(angle), 3), round(128 + r * math.sin(angle), 3)]


def parts(name, shapes, at, to, speed):
    """Bodies that go one way together. shapes: each with its place ahead and to the left of `at`."""
    length = math.hypot(to[0] - at[0], to[1] - at[1])
    c, s = (to[0] - at[0]) / length, (to[1] - at[1]) / length
    lines = []
    for i, (shape, ahead, left, more) in enumerate(shapes):
        x, y = c * ahead - s * left, s * ahead + c * left
        points = [[round(p[0] + x, 9), round(p[1] + y, 9)] for p in (at, to)]
        lines.append(f"  - {{name: {name}{i}, shape: {shape}, {more}, path: {{points: {points}, speed: {speed}}}}}\n")
    return "".join(lines)


# What is one body in parts: wheels that abut, a plate in four, a sphere twice. Each crosses edges of tiles of 4 m, some the ways of others.
TWIN = [("{wheel: {radius: 0.5, width: 0.3}}", 0, side * 0.15, "load: 1500, slip: 0.2") for side in (1, -1)]
PLATE = [("{box: {size: [0.6, 0.4, 0.3]}}", ahead * 0.3, left * 0.2, "sink: 0.05") for ahead in (1, -1) for left in (1, -1)]
TWICE = [("{sphere: {radius: 0.5}}", 0, 0, "sink: 0.08")] * 2
TOGETHER = scene("scm", 3, "".join(
    parts(f"twin{i}", TWIN, at, to, 6) + parts(f"plate{i}", PLATE, [at[0] + 4.1, at[1] + 7.2], [to[0] - 3.3, to[1] + 6.1], 5) +
    parts(f"twice{i}", TWICE, [at[0] - 6.2, at[1] + 3.9], [to[0] + 2.2, to[1] - 5.1], 7)
    for i, (at, to) in enumerate((([30, 30], [50, 41]), ([62, 50], [44, 34]), ([100, 60], [84, 73]), ([84, 90], [101, 76]), ([120, 20], [121, 44])))))

# Bodies that slide come from all sides to one place, and pass it: braked, locked, spinning and aslant wheels, one with bars, a blade, a belt, a capsule, a ball. There one
# rank computes all of them, so most go over to another. What each remembers of its recent motion goes with it: by the modulus of the soil it shows for some
# steps.
SLIDES = (("{wheel: {radius: 0.5, width: 0.3}}", "load: 1500, slip: -0.6"),
          ("{wheel: {radius: 0.5, width: 0.3}}", "load: 1500, slip: 0.2, attitude: [40, 0, 0]"),
          ("{wheel: {radius: 0.5, width: 0.3}}", "load: 1500, slip: -1000, attitude: [90, 0, 0]"),
          ("{wheel: {radius: 0.5, width: 0.3, grousers: 18, grouser_height: 0.05}}", "load: 1500, slip: 0.5, attitude: [20, 4, 6]"),
          ("{box: {size: [0.2, 1.5, 0.8]}}", "sink: 0.15, attitude: [25, 30, 0]"),
          ("{box: {size: [1.5, 0.5, 0.4], belt: true}}", "load: 3000, slip: 0.3, attitude: [15, 0, 0]"),
          ("{capsule: {radius: 0.25, length: 1.2}}", "load: 900, attitude: [60, 0, 80]"),
          ("{sphere: {radius: 0.5}}", "sink: 0.12"))
SLIDING = scene("scm", 4, "".join(
    f"  - {{name: p{i}, shape: {shape}, {more}, path: {{points: [{on_ring(i, 34 + 5 * (i % 4), 0)}, {on_ring(i, 22, math.pi + 0.2)}], speed: {14 + i % 3}}}}}\n"
    for i, (shape, more) in enumerate(SLIDES))).replace("model: scm", "model: scm, faces: on").replace("dry_sand", "dry_sand, janosi_shear: 0.2")

# Plates and blades that carry soil come from all sides to one place, and pass it: there one rank computes all of them. Wheels go through what they spill.
CARRYING = scene("scm", 4, "".join(
    f"  - {{name: p{i}, shape: {{box: {{size: {size}}}}}, {more}, carry: true, path: {{points: [{on_ring(i, 30 + 4 * (i % 4), 0)}, {on_ring(i, 20, math.pi + 0.3)}], "
    f"speed: {12 + i % 3}}}}}\n" for i, (size, more) in enumerate((
        ("[1, 1.4, 0.1]", "sink: 0.22"), ("[0.8, 1.2, 0.12]", "sink: 0.2, attitude: [15, 4, 3]"), ("[0.3, 1.6, 0.5]", "sink: 0.3, attitude: [20, 30, 0]"),
        ("[1, 1, 0.3]", "load: 3000"), ("[1.2, 0.9, 0.1]", "sink: 0.15, attitude: [0, 0, 40]")))) +
    wheel("a", [on_ring(5, 30, 0.1), on_ring(5, 25, math.pi)], 14, "load: 1500, slip: 0.3") +
    wheel("stands", [on_ring(2, 3, 0)], 1, "sink: 0.05") + "".join(
        f"  - {{name: slow{i}, shape: {{box: {{size: [1.5, 2, 0.1]}}}}, sink: 0.35, attitude: [10, {6 + 9 * i}, 3], carry: true, path: {{points: [[{30 + 60 * i}, 200], [{34 + 60 * i}, 201]], speed: {0.4 + 0.1 * i}}}}}\n"
        for i in range(2))).replace("forces: 20", "forces: 7").replace("model: scm", "model: scm, interval: 0.06")
# Wheels that spin throw soil over the edges of tiles, at each other, beyond the terrain, and onto a plate that carries it.
THROWING = scene("scm", 4.2, "".join(
    wheel(f"t{i}", [on_ring(2 * i, 25 + 2 * i, 0), on_ring(2 * i, 12, math.pi + 0.2)], 7 + i % 2, f"load: {900 + 150 * i}, slip: {0.2 + 0.04 * i}") for i in range(3)) +
    wheel("edge", [[1.2, 40], [9, 42]], 3, "load: 900, slip: 0.6") +
    "  - {name: plate, shape: {box: {size: [0.6, 0.8, 0.1]}}, sink: 0.2, carry: true, path: {points: [[166, 138.3], [112, 120.8]], speed: 11}}\n", step=0.02).replace(
        "model: scm", "model: scm, thrown: on, interval: 0.06").replace("forces: 20", "forces: 7")


# Bodies that stand at edges and corners of tiles of 8 m. Balls push soil against them from other ranks, and it slides on when they have stopped.
PARKED = scene("slippage, iterations: 2, interval: 0.1", 4, "".join(
    f"  - {{name: b{i}, shape: {{sphere: {{radius: 1.1}}}}, sink: 0.7, path: {{points: [[{x}, {y}], [{to}, {y + 0.7}]], speed: 9}}}}\n"
    for i, (x, y, to) in enumerate(((36, 63, 62), (20, 92, 62), (92, 64.5, 67), (100, 92, 66)))) + "".join(
    f"  - {{name: p{i}, shape: {shape}, sink: 0.05, path: {{points: [[{x}, {y}]], speed: 1}}}}\n"
    for i, (x, y, shape) in enumerate(((64.2, 64.1, "{box: {size: [2, 3, 0.3]}}"), (64, 93.5, "{sphere: {radius: 1.5}}"), (63.5, 90.3, "{wheel: {radius: 0.8, width: 1}}")))))


class Ranks(FurrowTest):
    @classmethod
    def setUpClass(cls):
        if shutil.which("mpirun") is None:
            raise unittest.SkipTest("no mpirun here")

    def setUp(self):
        super().setUp()
        self.base = None
        for kind, relief in (("plain", 3), ("ridged", 30)):
            self.ok("synth", "-o", f"{kind}.tif", "--posts", "257x257", "--spacing", 1, "--kind", kind, "--relief", relief)
            self.ok("import", f"{kind}.tif", "-o", f"{kind}.furrow", "--tile", 64)

    def command(self, ranks, file, name, *more, store="plain.furrow"):
        drive = [FURROW, "drive", file, "--store", store, "--overlay", f"{name}.furrow", "-o", name, *map(str, more)]
        return drive if ranks == 1 else ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), *drive]

    def run_command(self, command, expect=0):
        result = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=280)
        if expect == 0 and result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        if expect == 0:
            self.assertEqual(result.returncode, 0, result.stderr)
        else:
            self.assertNotEqual(result.returncode, 0, result.stdout)
            lines = [line for line in result.stderr.splitlines() if line.startswith("furrow: ") and not line.startswith("furrow: note: ")]
            self.assertEqual(len(lines), 1, result.stderr)
            self.assertRegex(lines[0], r"^furrow: .+: .+; .+")
            return lines[0]
        return json.loads((self.folder / command[command.index("-o") + 1] / "run.json").read_text())

    def rows(self, name):
        with sqlite3.connect(self.folder / f"{name}.furrow") as db:
            out = []
            for table in TABLES:
                columns = [row[1] for row in db.execute(f'PRAGMA table_info("{table}")') if row[1] not in COMMIT]
                quoted = ",".join(f'"{column}"' for column in columns)
                out += [(table, *row) for row in db.execute(f'SELECT {quoted} FROM "{table}" ORDER BY key')]
        db.close()
        return out

    def record(self, name):
        """What a drive goes on from: step, time, state, and the active blocks. Which of them are awake without need depends on the GPU."""
        with sqlite3.connect(self.folder / f"{name}.furrow") as db:
            step, time_, state = db.execute("SELECT step, time, state FROM run").fetchone()
        db.close()
        state = json.loads(state)
        return (step, time_, state), state.pop("awake").split(";")[:-1]

    def same(self, one, many, reports):
        self.assertEqual(self.rows(one), self.rows(many))
        record, awake = self.record(many)
        self.assertEqual(self.record(one)[0], record)
        self.assertEqual(len(awake), len(set(awake)), "a block stands twice in the record")
        for file in ("objects.csv", "vehicles.csv"):
            a, b = self.folder / one / file, self.folder / many / file
            self.assertEqual(a.exists(), b.exists(), file)
            if a.exists():
                self.assertTrue(filecmp.cmp(a, b, shallow=False), file)
        for key in ("ended", "steps", "volume", "objects"):
            self.assertEqual(reports[0][key], reports[1][key], key)
        self.assertEqual(reports[0].get("thrown"), reports[1].get("thrown"))
        self.assertFalse((self.folder / f"{many}.furrow.parts").exists())
        self.ok("verify", f"{many}.furrow")

    def ledger(self, report, *names):
        """Offsets + compacted + carried + in flight - added is 0 to the unit, of run.json alone and of each store."""
        units = report["volume"]["quanta"]
        self.assertEqual(units["net"] + units["compacted"] + units.get("carried", 0) + units.get("in_flight", 0) - units["added"], 0)
        for name in names:
            check = json.loads(self.ok("verify", f"{name}.furrow", "--json"))
            self.assertEqual(check["offset_sum"]["-3"] + sum(check[key] for key in ("compacted", "carried", "in_flight")), check["added"])
            self.assertEqual({key: check[key] for key in ("carried", "in_flight")}, {key: units.get(key, 0) for key in ("carried", "in_flight")})

    def compare(self, text, store="plain.furrow", ranks=None, moves=True, blocks=False):
        self.scene(text)
        one = self.run_command(self.command(1, "scene.yaml", "one", store=store))
        self.assertGreater(len(self.rows("one")), 3)
        moved = blocks_moved = 0
        for n in ranks or RANKS:
            many = self.run_command(self.command(n, "scene.yaml", f"many{n}", store=store))
            self.same("one", f"many{n}", (one, many))
            self.assertEqual(many["ranks"]["count"], n)
            moved += many["ranks"]["tiles_moved"]
            blocks_moved += many["ranks"]["blocks_moved"]
            print(f"{n} ranks: {many['ranks']}")
        if moves:
            self.assertGreater(moved, 0, "nothing moved between ranks, so this shows little")
        if blocks:
            self.assertGreater(blocks_moved, 0, "no sliding soil moved between ranks")

    def kill_one(self, process, chance):
        """Kills mpirun's child, or the drive itself. Returns whether there was one."""
        if process.poll() is not None:
            return 0
        children = []
        for task in pathlib.Path(f"/proc/{process.pid}/task").glob("*/children"):
            children += [int(pid) for pid in task.read_text().split()]
        try:
            os.kill(chance.choice(children) if children else process.pid, signal.SIGKILL)
        except ProcessLookupError:
            return 0
        return 1

    def kill_after_a_commit(self, command):
        """Kills one process of a drive into "many" once a commit of it is there, unless it is done by then."""
        log = self.folder / "many" / "epochs.log"
        log.unlink()
        process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while process.poll() is None and (not log.exists() or log.stat().st_size == 0):
            time.sleep(0.01)
        self.kill_one(process, random.Random(SEED))
        process.wait(timeout=200)


@chosen_tests(2)
class TheSame(Ranks):
    def test_wheels_that_cross_at_the_corner_of_four_tiles(self):
        self.compare(CROSSING)

    def test_bodies_that_slide_keep_their_recent_motion(self):
        self.compare(SLIDING)

    def test_soil_aboard_bodies_that_pass_between_ranks(self):
        self.compare(CARRYING)
        report = json.loads((self.folder / "many3" / "run.json").read_text())
        self.assertGreater(report["volume"]["quanta"]["carried"], 1000000)
        self.assertGreater(report["ranks"]["bodies_moved"], 1)
        self.ledger(report, "one", "many2", "many3")

    def test_soil_in_flight(self):
        self.compare(THROWING)
        report = json.loads((self.folder / "many3" / "run.json").read_text())
        thrown = report["thrown"]["quanta"]
        self.assertEqual(thrown["thrown"], thrown["landed"] + thrown["lost"] + thrown["in_flight"])
        for key in ("landed", "lost", "in_flight"):
            self.assertGreater(thrown[key], 1000, key)
        self.assertEqual(report["volume"]["quanta"]["in_flight"], thrown["in_flight"])
        self.ledger(report, "one", "many2", "many3")

    def test_marks_that_fade(self):
        self.compare(CROSSING.replace("objects:", "attributes: {disturbance: {heals: 500}, vegetation: {tears: 0.5, rises: 300, grows: 900}, elapsed: 9}\nobjects:"))

    def test_what_the_cpu_computes(self):
        for name, text in (("spread", SPREAD), ("heaps", HEAPS), ("sides", BOTH_SIDES)):
            self.scene(text)
            gpu = self.run_command(self.command(1, "scene.yaml", f"{name}_gpu", "--set", "compute=gpu"))
            cpu = self.run_command(self.command(2, "scene.yaml", f"{name}_cpu", "--set", "compute=cpu"))
            self.assertEqual((gpu["computed"]["by"], cpu["computed"]["by"]), ("gpu", "cpu"))
            self.assertGreater(cpu["ranks"]["tiles_moved"] + (name == "sides"), 0)
            self.same(f"{name}_gpu", f"{name}_cpu", (gpu, cpu))

    def test_wheels_that_cross_each_other_everywhere(self):
        self.compare(SPREAD, "ridged.furrow")

    def test_heaps_that_slide_over_the_edge_of_a_rank(self):
        self.compare(HEAPS, blocks=True)

    def test_soil_that_is_pushed_against_bodies_that_stand(self):
        self.compare(PARKED, ranks=RANKS[:1], moves=False)

    def test_a_loaded_wheel_that_stands_on_sliding_soil_goes_over_to_another_rank(self):
        self.compare(STANDING, ranks=RANKS[:1])

    def test_rows_that_come_later_than_their_contact(self):
        text = CROSSING.replace("load: 2000", "sink: 0.06").replace("load: 1500", "sink: 0.05")
        self.compare(text.replace("forces: 20", "forces: 3").replace("time_step: 0.05", "time_step: 0.01"), ranks=RANKS[-1:])

    def test_wheels_on_one_elastic_sheet(self):
        self.compare(SHEET)

    def test_wheels_on_one_elastic_sheet_that_the_gpu_bends(self):
        self.compare("compute: gpu\n" + SHEET.replace("end_time: 3", "end_time: 1").replace("load: 900", "sink: 0.1"), ranks=RANKS[:1])

    def test_forces_that_are_asked_for_long_before_their_row(self):
        self.compare(LATE)

    def test_blocks_that_two_ranks_have_woken_stand_once_in_the_record(self):
        self.compare(BOTH_SIDES, ranks=[2], moves=False)
        awake = [self.record(name)[1] for name in ("one", "many2")]
        self.assertGreater(len(awake[0]), 3)
        self.assertEqual(*awake)
        balance = json.loads((self.folder / "many2" / "run.json").read_text())["ranks"]["balance"]
        self.assertLess(balance, 1.5, "one rank had both")

    def test_a_convoy_in_one_rut_leaves_a_rank_with_nothing(self):
        self.compare(CONVOY, moves=False)

    def test_a_path_that_leaves_the_terrain_ends_all_after_one_step(self):
        self.scene(scene("box", 4, wheel("stays", [[20, 30], [60, 33]], 8, "sink: 0.1") + wheel("leaves", [[240, 200], [300, 201]], 9, "sink: 0.1")))
        for ranks, name in ((1, "one"), (2, "two")):
            said = self.run_command(self.command(ranks, "scene.yaml", name), expect=1)
            self.assertIn("leaves: no ground under it", said)
        reports = [json.loads((self.folder / name / "run.json").read_text()) for name in ("one", "two")]
        self.assertEqual([report["ended"] for report in reports], ["failed", "failed"])
        self.assertIn("leaves: no ground under it", self.run_command(self.command(2, "scene.yaml", "two", "--resume"), expect=1))
        self.same("one", "two", reports)

    def test_bodies_that_are_one_body_in_parts(self):
        for cells in (32, 16):
            self.ok("import", "plain.tif", "-o", f"tiles{cells}.furrow", "--tile", cells)
            for path in (*self.folder.glob("one*"), *self.folder.glob("many*")):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            self.compare(TOGETHER.replace("slots: 24", f"slots: {128 * 32 // cells}"), f"tiles{cells}.furrow")

    def test_more_ranks_than_bodies(self):
        self.compare(ALONE, ranks=[3], moves=False)

    def test_vehicles_that_pass_between_ranks(self):
        if not (MODELS / "offroad.xml").exists():
            self.skipTest("no vehicle models")
        shutil.copy(MODELS / "offroad.xml", self.folder)
        vehicles = "".join(
            f"  - name: {name}\n    model: offroad.xml\n    start: {{at: {at}, yaw: {yaw}}}\n    soil: [wheel_*]\n"
            f"    driver: {{path: {{points: [{at}, {to}], speed: 5}}, steer: [steer_*], drive: [drive_*]}}\n"
            for name, at, yaw, to in (("car", [40, 40], 0, [70, 40]), ("cab", [60, 30], 90, [60, 60])))
        text = scene("scm", 3.2, wheel("w", [[50, 33], [50, 60]], 4), step=0.008, more="vehicles:\n" + vehicles)
        text = text.replace("output: {forces: 20}", "output: {forces: 50, vehicles: 50}").replace("model: scm", "model: scm, faces: on")
        if "this build has no MuJoCo" in self.furrow("explain", self.scene(text)).stderr:
            self.skipTest("no MuJoCo in this build")
        self.compare(text, ranks=RANKS[-1:])


    def test_hulls_that_touch_the_ground_of_other_ranks(self):
        """Sleds tip over, so that masts that were high above the ground hit it, in the ruts of others and over the edges of tiles. A car drives with its hulls, and one falls on its roof."""
        if not (MODELS / "offroad.xml").exists():
            self.skipTest("no vehicle models")
        shutil.copy(MODELS / "offroad.xml", self.folder)
        (self.folder / "sled.xml").write_text("""<mujoco><worldbody><body name="sled"><freejoint/><geom name="base" type="box" size=".5 .4 .1" mass="60"/>
            <geom name="mast" type="capsule" size=".12" fromto="0 0 .2 0 0 1.2" mass="90"/><geom name="head" type="sphere" size=".25" pos="0 0 1.3" mass="60"/></body></worldbody></mujoco>""")
        vehicles = "".join(
            f"  - name: {name}\n    model: sled.xml\n    start: {{at: {at}, yaw: {yaw}, speed: {speed}, settle: false}}\n"
            for name, at, yaw, speed in (("a", [60.5, 60], 0, 5), ("b", [100, 66.5], -90, 5.5))) + "".join(
            f"  - name: {name}\n    model: offroad.xml\n    start: {{at: {at}, yaw: {yaw}{start}}}\n"
            f"    driver: {{path: {{points: [{at}, {to}], speed: 5}}, steer: [steer_*], drive: [drive_*]}}\n"
            for name, at, yaw, to, start in (("car", [50, 58.5], 0, [80, 59.5], ", settle: false"), ("roof", [61, 90], 0, [80, 90], ", roll: 160, height: 0.5")))
        text = scene("scm", 2, wheel("w", [[76, 61], [60, 60.5]], 9), step=0.004, more="vehicles:\n" + vehicles)
        text = text.replace("output: {forces: 20}", "output: {forces: 50, vehicles: 50}")
        if "this build has no MuJoCo" in self.furrow("explain", self.scene(text)).stderr:
            self.skipTest("no MuJoCo in this build")
        self.compare(text, ranks=RANKS[-1:])
        reports = [json.loads((self.folder / name / "run.json").read_text())["vehicles"] for name in ("one", f"many{RANKS[-1]}")]
        for name in reports[0]:
            self.assertEqual(reports[1][name], reports[0][name])
        told = (self.folder / "one" / "objects.csv").read_text()
        for hull in ("a.mast", "b.head", "roof."):   # they were in the world, at some time
            self.assertIn(hull, told)


class Killed(Ranks):
    def test_a_kill_of_any_rank_loses_nothing(self):
        chance = random.Random(SEED)
        print(f"RANKS_SEED={SEED} KILLS={KILLS}")
        self.scene(CROSSING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        kills, longest = 0, 3.0
        while kills < KILLS:
            for path in self.folder.glob("many*"):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            more, done = [], False
            while not done:
                n = chance.choice([1, *RANKS])
                command = self.command(n, "scene.yaml", "many", *more)
                process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                more = ["--resume"]
                if kills < KILLS:
                    self.wait(process, chance.uniform(0, longest))
                    killed = self.kill_one(process, chance)
                    kills += killed
                    longest *= 1 if killed else 0.8  # it was done by then: sooner, the next time
                said = process.communicate(timeout=200)[0]
                done = process.returncode == 0
                if done:
                    break
                self.assertNotRegex(said, r"(?m)^furrow: (?!note: )")
                if (self.folder / "many.furrow").exists():
                    self.ok("verify", "many.furrow")
            self.same("one", "many", (one, json.loads((self.folder / "many" / "run.json").read_text())))

    @staticmethod
    def wait(process, seconds):
        until = time.monotonic() + seconds
        while time.monotonic() < until and process.poll() is None:
            time.sleep(0.01)

    def test_ctrl_c_ends_all_after_one_step(self):
        self.scene(CROSSING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        process = subprocess.Popen(self.command(2, "scene.yaml", "many"), cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        log = self.folder / "many" / "epochs.log"
        while (not log.exists() or log.stat().st_size == 0) and process.poll() is None:
            time.sleep(0.02)
        for task in pathlib.Path(f"/proc/{process.pid}/task").glob("*/children"):
            for pid in task.read_text().split():
                try:
                    os.kill(int(pid), signal.SIGINT)
                except ProcessLookupError:
                    pass  # it is complete
                break
        process.communicate(timeout=250)
        self.assertFalse((self.folder / "many.furrow.parts").exists())
        self.assertIn(json.loads((self.folder / "many" / "run.json").read_text())["ended"], ("interrupted", "complete"))
        many = self.run_command(self.command(3, "scene.yaml", "many", "--resume"))
        self.same("one", "many", (one, many))


@chosen_tests(1)
class GoesOn(Ranks):
    def test_soil_aboard_and_in_flight_goes_on(self):
        """A drive in parts, by other numbers of processes, one of them cut off by a kill."""
        self.scene(THROWING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        self.run_command(self.command(2, "scene.yaml", "many", "--steps", 60))
        part = self.run_command(self.command(3, "scene.yaml", "many", "--resume", "--steps", 100))
        self.ledger(part, "many")
        self.assertGreater(min(part["volume"]["quanta"][key] for key in ("carried", "in_flight")), 1000)
        self.kill_after_a_commit(self.command(3, "scene.yaml", "many", "--resume"))
        many = self.run_command(self.command(2, "scene.yaml", "many", "--resume"))
        self.same("one", "many", (one, many))
        self.ledger(many, "one", "many")
        self.run_command(self.command(2, "scene.yaml", "again", "--steps", 130))
        self.same("one", "again", (one, self.run_command(self.command(1, "scene.yaml", "again", "--resume"))))

    def test_soil_that_is_poured_between_drives(self):
        """Ranks go over ground on which a heap was poured, and leave what one process leaves. Where parts of a drive were left, they are not put over what was poured since."""
        heap = ["edit", "--polygon", "POLYGON ((120 120, 134 120, 134 134, 120 134))", "--volume", 12]
        self.scene(CARRYING)
        for n, name in ((1, "one"), (2, "many")):
            self.run_command(self.command(n, "scene.yaml", name, "--steps", 30))
            self.ok(*heap, f"{name}.furrow")
            self.ledger({"volume": {"quanta": {"net": 0, "compacted": 0, "added": 0}}}, name)
            self.assertIn("of another scene", self.run_command(self.command(3, "scene.yaml", name, "--resume"), expect=1))
        self.same("one", "many", [self.run_command(self.command(n, "scene.yaml", name)) for n, name in ((1, "one"), (3, "many"))])
        report = json.loads((self.folder / "many" / "run.json").read_text())
        self.ledger(report, "one", "many")
        self.assertGreater(json.loads(self.ok("verify", "many.furrow", "--json"))["added"], 0)
        self.kill_after_a_commit(self.command(2, "scene.yaml", "many"))
        self.assertTrue((self.folder / "many.furrow.parts").exists(), "it was done before the kill")
        self.ok(*heap, "many.furrow")
        self.assertIn("has changed since", self.run_command(self.command(2, "scene.yaml", "many", "--resume"), expect=1))


@chosen_tests(2)
class Refused(Ranks):
    def mpmd(self, first, second):
        """A run of two processes that are not started alike."""
        return ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "1", *first, ":", "-n", "1", *second]

    def test_what_many_processes_cannot_do(self):
        self.scene(CONVOY)
        command = self.command(2, "scene.yaml", "many")
        at = command.index("--overlay")
        self.assertIn("--overlay", self.run_command(command[:at] + command[at + 2:], expect=1))
        self.assertIn("--trace", self.run_command(command + ["--trace", "x.trace"], expect=1))
        self.assertIn("--keep-history", self.run_command(command + ["--keep-history"], expect=1))
        self.scene(CONVOY + "view: {camera: {overhead: {over: w0, height: 40}}, images: 5}\n")
        self.assertIn("view.images=0", self.run_command(command, expect=1))
        self.assertFalse((self.folder / "many.furrow").exists())
        self.run_command(command + ["--set", "view.images=0"])

    def test_more_grains_than_one_process_has_room_for(self):
        wheels = "".join(wheel(f"t{i}", [[20 + 24 * (i % 5), 30 + 9 * i], [50 + 24 * (i % 5), 31 + 9 * i]], 16, "load: 900, slip: 0.7") for i in range(14))
        self.scene(scene("scm", 2, wheels, step=0.02).replace("model: scm", "model: scm, thrown: on"))
        said = self.run_command(self.command(2, "scene.yaml", "many"), expect=1)
        self.assertIn("redistribute.thrown: ranks: more than 16384 grains fly at once", said)
        step, time_, state = self.record("many")[0]
        self.assertLess(step, 100)
        self.assertTrue(json.loads(self.ok("verify", "many.furrow", "--json"))["ok"])

    def test_grains_that_come_down_on_bodies_over_several_soils(self):
        made = subprocess.run(["gdal_translate", "-q", "-ot", "Byte", "plain.tif", "classes.tif"], cwd=self.folder, capture_output=True, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.scene(THROWING.replace("{name: dry_sand}", "{map: classes.tif, classes: {1: dry_sand}, default: sandy_loam_15}"))
        said = self.run_command(self.command(2, "scene.yaml", "many"), expect=1)
        self.assertIn("a grain that comes down on a body with carry has the soil that was thrown most", said)
        self.assertEqual(list(self.folder.glob("many.furrow*")), [])

    def test_a_rank_without_gl(self):
        drive = self.command(1, "scene.yaml", "many")
        blind = ["env", "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json", "EGL_PLATFORM=surfaceless", *drive]
        self.scene(BOTH_SIDES)
        said = self.run_command(self.mpmd([*drive, "--set", "compute=gpu"], [*blind, "--set", "compute=gpu"]), expect=1)
        self.assertIn("rank 1", said)
        self.assertEqual(list(self.folder.glob("many.furrow*")), [])
        self.assertFalse((self.folder / "many" / "run.json").exists())
        for name, text in (("both", BOTH_SIDES), ("bears", CROSSING)):  # there the CPU computes
            self.scene(text)
            one = self.run_command(self.command(1, "scene.yaml", f"one_{name}"))
            many = [[word.replace("many", f"many_{name}") for word in command] for command in (drive, blind)]
            self.same(f"one_{name}", f"many_{name}", (one, self.run_command(self.mpmd(*many))))

    def test_ranks_that_are_given_different_things(self):
        self.scene(BOTH_SIDES)
        drive = self.command(1, "scene.yaml", "many")
        for other, told in (([*drive, "--steps", "3"], "its end_time or --steps is not that of rank 0"),
                            ([*drive, "--set", "output.forces=7"], "its output.forces is not that of rank 0"),
                            (self.command(1, "scene.yaml", "many", store="ridged.furrow"), "its --store, --overlay or --resume is not that of rank 0")):
            self.assertIn(f"rank 1: {told}; give all ranks the same", self.run_command(self.mpmd(drive, other), expect=1))
            self.assertEqual(list(self.folder.glob("many*")), [])

    def test_a_rank_that_does_not_start_is_told(self):
        self.scene(BOTH_SIDES)
        command = self.mpmd(self.command(1, "scene.yaml", "many"), ["sleep", "100"])
        launcher = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        lines = []
        try:
            for line in launcher.stderr:
                lines.append(line)
                if "furrow: note: has waited" in line:
                    break
        finally:
            launcher.terminate()
            launcher.communicate(timeout=60)
        self.assertRegex(lines[-1], r"has waited \d+ s for the other ranks to start; each must be furrow drive, and Ctrl-C ends all")

    def test_a_rank_with_another_scene(self):
        self.scene(CONVOY)
        self.scene(ALONE, "other.yaml")
        said = self.run_command(self.mpmd(self.command(1, "scene.yaml", "many"), self.command(1, "other.yaml", "many")), expect=1)
        self.assertIn("rank 1: its scene is not that of rank 0", said)
        self.assertEqual(list(self.folder.glob("many.furrow*")), [])

    def test_a_rank_with_another_renderer(self):
        self.scene(BOTH_SIDES)
        drive = self.command(1, "scene.yaml", "many")
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        if "Mesa" not in one["gl"]["version"] or one["gl"]["version"].startswith("4.6"):
            self.skipTest(f"not on this machine: the version of {one['gl']['version']} cannot be changed")
        other = ["env", "MESA_GL_VERSION_OVERRIDE=4.6", *drive]
        self.same("one", "many", (one, self.run_command(self.mpmd(drive, other))))

    def test_a_rank_whose_disk_is_full(self):
        self.scene(CROSSING)
        drive = self.command(1, "scene.yaml", "many")
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        full = ["sh", "-c", 'ulimit -f 40; exec "$@"', "sh", *drive]
        said = self.run_command(self.mpmd(drive, full), expect=1)
        self.assertIn("rank 1", said)
        if (self.folder / "many.furrow").exists():
            self.ok("verify", "many.furrow")
        many = self.run_command(self.command(2, "scene.yaml", "many", "--resume"))
        self.same("one", "many", (one, many))

    def test_an_overlay_that_is_there(self):
        self.scene(CONVOY)
        self.run_command(self.command(1, "scene.yaml", "one"))
        self.run_command(self.command(1, "scene.yaml", "one"))
        self.run_command(self.command(2, "scene.yaml", "many"))
        again = self.run_command(self.command(2, "scene.yaml", "many"))
        one = json.loads((self.folder / "one" / "run.json").read_text())
        self.same("one", "many", (one, again))
        (self.folder / "many.furrow.parts").mkdir()
        self.assertIn("--resume", self.run_command(self.command(2, "scene.yaml", "many"), expect=1))
        self.assertIn("--resume", self.refused(3, "drive", "scene.yaml", "-o", "x", "--overlay", "many.furrow", "--store", "plain.furrow"))


@chosen_tests(2)
class Staged(Ranks):
    """--stage: all ranks of a machine read the base from one copy."""

    def copies(self):
        return sorted(path.name for path in (self.folder / "stage").iterdir())

    def test_a_staged_base_gives_the_same(self):
        self.scene(CROSSING)
        for store in ("plain", "ridged"):
            one = self.run_command(self.command(1, "scene.yaml", "one", store=f"{store}.furrow"))
            for n in (1, *RANKS):
                more = self.command(n, "scene.yaml", "many", "--stage", "stage", store=f"{store}.furrow")
                many = self.run_command(more)
                self.same("one", "many", (one, many))
                self.assertEqual(many["store"]["base"], str((self.folder / f"{store}.furrow").resolve()))
                self.assertEqual(pathlib.Path(many["store"]["staged"]).parent.name, "stage")
                self.assertEqual(json.loads(self.ok("info", "many.furrow", "--json"))["base"], one["store"]["base"])
                for path in self.folder.glob("many*"):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            for path in self.folder.glob("one*"):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        self.assertEqual([name.split("-")[0] for name in self.copies()], ["plain", "ridged"])

    def test_a_drive_goes_on_with_a_staged_base_or_without(self):
        self.scene(CROSSING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        self.run_command(self.command(2, "scene.yaml", "many", "--stage", "stage", "--steps", 30))
        self.run_command(self.command(1, "scene.yaml", "many", "--resume", "--steps", 50))
        os.rename(self.folder / "plain.furrow", self.folder / "moved.furrow")
        said = self.run_command(self.command(2, "scene.yaml", "many", "--resume", "--stage", "stage", store="moved.furrow"), expect=1)
        self.assertIn("relink", said)
        self.ok("relink", "many.furrow", "moved.furrow")
        many = self.run_command(self.command(3, "scene.yaml", "many", "--resume", "--stage", "stage", store="moved.furrow"))
        self.same("one", "many", (one, many))
        self.assertEqual(len(self.copies()), 2)

    def test_a_copy_that_is_none_is_refused(self):
        self.scene(CONVOY)
        self.run_command(self.command(1, "scene.yaml", "one", "--stage", "stage"))
        copy = self.folder / "stage" / self.copies()[0]
        whole = copy.read_bytes()
        copy.write_bytes(whole[:len(whole) // 2])
        for n in (1, 2):
            said = self.run_command(self.command(n, "scene.yaml", "many", "--stage", "stage"), expect=1)
            self.assertRegex(said, r"not the whole copy of .*plain.furrow.*; remove that file")
            self.assertEqual(list(self.folder.glob("many*")), [])
        self.assertIn("--overlay", self.run_command([FURROW, "drive", "scene.yaml", "-o", "x", "--store", "plain.furrow", "--stage", "stage"],
                                                    expect=2))
        copy.unlink()
        self.run_command(self.command(2, "scene.yaml", "many", "--stage", "stage"))
        self.assertEqual(copy.stat().st_size, len(whole))

    # mpirun starts this in place of ssh: a machine is a host name, and a disk of its own at node/.
    MACHINE = """#!/bin/sh
cd {folder}; host=$1; shift
exec unshare --uts --mount sh -c "hostname $host && mount $(cat $host.mount) {folder}/node && $*"
"""

    def machines(self, *mounts):
        """The beginning of a command that starts two ranks on each of some machines, whose disks are mounted so."""
        (self.folder / "node").mkdir(exist_ok=True)
        agent = self.folder / "machine.sh"
        agent.write_text(self.MACHINE.format(folder=self.folder))
        agent.chmod(0o755)
        for i, mount in enumerate(mounts):
            (self.folder / f"machine{i}.mount").write_text(mount)
        (self.folder / "hosts").write_text("".join(f"machine{i} slots=2\n" for i in range(len(mounts))))
        command = ["mpirun", "--allow-run-as-root", "--hostfile", "hosts", "-n", str(2 * len(mounts)), "--mca", "plm", "rsh", "--mca", "plm_rsh_agent",
                   str(agent), "--mca", "btl_tcp_if_include", "lo", "--mca", "oob_tcp_if_include", "lo"]
        try:
            tried = subprocess.run([*command, "hostname"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        except subprocess.TimeoutExpired:
            self.skipTest("not on this machine: no machines can be made here: mpirun does not end")
        if sorted(tried.stdout.split()) != [f"machine{i}" for i in range(len(mounts)) for _ in range(2)]:
            self.skipTest("not on this machine: no machines can be made here: " + tried.stderr.strip()[-300:])
        return command

    def test_each_machine_has_a_copy_of_its_own(self):
        disks = [self.folder / name for name in ("disk0", "disk1")]
        for disk in disks:
            disk.mkdir()
        begin = self.machines(*(f"--bind {disk}" for disk in disks))
        self.scene(CROSSING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        many = self.run_command(begin + self.command(1, "scene.yaml", "many", "--stage", self.folder / "node" / "stage"))
        self.same("one", "many", (one, many))
        self.assertEqual(many["ranks"]["count"], 4)
        names = [[path.name for path in (disk / "stage").iterdir()] for disk in disks]
        self.assertEqual(len(names[0]), 1)
        self.assertEqual(*names)
        self.assertEqual(list((self.folder / "node").iterdir()), [])

    def test_the_disk_of_one_machine_is_full(self):
        begin = self.machines("-t tmpfs -o size=20m tmpfs", "-t tmpfs -o size=64k tmpfs")
        self.scene(CONVOY)
        said = self.run_command(begin + self.command(1, "scene.yaml", "many", "--stage", self.folder / "node" / "stage"), expect=1)
        self.assertRegex(said, r"rank [23]: .*stage/plain-[0-9a-f]{16}\.furrow: .*(disk|space)")
        self.assertEqual(list(self.folder.glob("many*")), [])

    def test_a_disk_that_is_full(self):
        self.scene(CROSSING)
        one = self.run_command(self.command(1, "scene.yaml", "one"))
        self.run_command(self.command(2, "scene.yaml", "many", "--steps", 30))
        rows = self.rows("many")
        command = self.command(2, "scene.yaml", "many", "--resume", "--stage", "stage")
        drive = self.command(1, "scene.yaml", "many", "--resume", "--stage", "stage")
        full = ["sh", "-c", 'ulimit -f 100; exec "$@"', "sh", *drive]
        said = self.run_command(Refused.mpmd(self, full, drive), expect=1)
        self.assertRegex(said, r"stage/plain-[0-9a-f]{16}\.furrow: .*disk")
        self.assertEqual(self.copies(), [])
        self.assertEqual(self.rows("many"), rows)
        self.assertFalse((self.folder / "many.furrow.parts").exists())
        self.same("one", "many", (one, self.run_command(command)))

    def test_ctrl_c_before_the_base_is_copied_ends_all(self):
        self.scene(CONVOY)
        self.run_command(self.command(2, "scene.yaml", "first", "--stage", "stage"))
        copy = self.folder / "stage" / self.copies()[0]
        copy.unlink()
        with open(f"{copy}-stage", "w", encoding="utf-8") as lock: # as another process that copies has it
            fcntl.flock(lock, fcntl.LOCK_EX)
            process = subprocess.Popen(self.command(2, "scene.yaml", "many", "--stage", "stage"), cwd=self.folder, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True, start_new_session=True)
            self.assertTrue(any("waiting for it" in line for line in process.stderr))
            for task in pathlib.Path(f"/proc/{process.pid}/task").glob("*/children"):
                for pid in task.read_text().split():
                    os.kill(int(pid), signal.SIGINT)
            try:
                said = process.communicate(timeout=25)[1]
            except subprocess.TimeoutExpired:
                self.kill_all(process)
                self.fail("the ranks wait for each other")
        self.assertIn("furrow: stage: interrupted", said)
        self.assertEqual(process.returncode, 130)
        self.assertEqual(list(self.folder.glob("many*")), [])
        self.run_command(self.command(2, "scene.yaml", "many", "--stage", "stage"))

    def test_a_kill_while_the_base_is_copied(self):
        self.ok("synth", "-o", "large.tif", "--posts", "1537x1537", "--spacing", 1, "--relief", 30)
        self.ok("import", "large.tif", "-o", "large.furrow", "--tile", 64)
        self.scene(CONVOY)
        one = self.run_command(self.command(1, "scene.yaml", "one", store="large.furrow"))
        stage = self.folder / "stage"
        cut = 0
        for turn in range(60):
            command = self.command((1, 2)[turn % 2], "scene.yaml", "many", "--stage", "stage", store="large.furrow")
            process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            while process.poll() is None and not any(path.stat().st_size > 200000 for path in stage.glob("*.part")):
                pass
            self.kill_all(process)
            cut += any(stage.glob("*.part"))
            self.assertEqual(list(self.folder.glob("many*")) if turn % 2 == 0 else [], [])
            for path in stage.glob("large*.furrow"):
                path.unlink()
            if cut >= 4 or cut > 0 and turn >= 11:
                break
        self.assertGreater(cut, 0, "no kill came while the base was copied")
        many = self.run_command(self.command(2, "scene.yaml", "many", "--resume", "--stage", "stage", store="large.furrow"))
        self.same("one", "many", (one, many))
        self.assertEqual([path.suffix for path in stage.iterdir()], [".furrow"])

    @staticmethod
    def kill_all(process):
        """Kills the processes of a drive, each of them at once."""
        found = [process.pid]
        for pid in found:
            for task in pathlib.Path(f"/proc/{pid}/task").glob("*/children"):
                try:
                    found += [int(child) for child in task.read_text().split()]
                except (OSError, ProcessLookupError):
                    pass
        for pid in found:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        process.wait(timeout=60)
        while any(pathlib.Path(f"/proc/{pid}").exists() and "Z" not in pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1][:3]
                  for pid in found[1:]):
            time.sleep(0.01)


if __name__ == "__main__":
    main()
