"""Law 6 and --resume: a drive that is killed at random instants, over and over, leaves after each kill a store that
verifies and holds the last epoch that was acknowledged or the one after it; resumed until it is complete it ends with
the same rows, figures, forces and pictures as one that was left alone.

Two of the scenes; FURROW_LONG=1: all. KILLS=200 RESUME_SEED=7 python3 resume.py; both are printed."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FULL, FURROW, FurrowTest, chosen, main, write_png16

HEAD = "scene: 1\ntime_step: {step}\nend_time: {end}\nspacing: 0.5\nredistribute: {{model: {model}}}\n"
WHEELS = """objects:
  - {name: left, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.15,
     path: {points: [[20, 20], [170, 90], [40, 130]], speed: 30, loop: true}}
  - {name: ball, shape: {sphere: {radius: 1.6}}, sink: 0.4,
     path: {points: [[22, 18], [150, 158], [12, 98]], speed: 23, loop: true}}
  - {name: block, shape: {box: {size: [3, 2, 1]}}, sink: 0.2,
     path: {points: [[100, 20], [101, 170], [20, 100]], speed: 11}}
"""
# Over the holes, off the edge, back, and a while without moving; then the same again from a file, with attitude.
ASTRAY = """outside: skip
objects:
  - {name: astray, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.15,
     path: {points: [[20, 20], [150, 150], [150, 230], [30, 120]], speed: 17, loop: true}}
  - {name: timed, shape: {box: {size: [3, 2, 1]}}, sink: 0.2, path: {file: poses.csv}}
"""
POSES = "".join(f"{t},{x},{y},{103 - 0.01 * t},{5 * t},{0.3 * t},{-0.2 * t}\n" for t, x, y in (
    (0.5, 10, 100), (9, 100, 90), (12, 100, 90), (21, 170, 20), (21.5, 170, 22), (33, 60, 60), (60, 160, 160)))
# They stand as deep as the soil carries them, and the ground goes on sliding behind them.
LOADED = """output: {{forces: 20}}
objects:
  - {{name: driven, shape: {{wheel: {{radius: 0.8, width: 0.7, lugs: 12, lug_height: 0.05}}}}, load: 9000, slip: 0.25,
     path: {{points: [[20, 20], [170, 90], [40, 130]], speed: 11, loop: true}}}}
  - {{name: ball, shape: {{sphere: {{radius: 1.2}}}}, load: 4000, path: {{points: [[22, 18], [150, 158]], speed: 7}}}}
  - {{name: track, shape: {{box: {{size: [3, 2, 1], belt: true}}}}, load: 70000, slip: 0.2, path: {{points: [[100, 20], [101, 170], [20, 100]], speed: 5}}}}
cache: {{slots: 40}}
"""
# They are dragged, braked, and go aslant, so each has a recent motion. By the modulus of their soil it shows for some steps.
PUSHING = LOADED.replace("slip: 0.25", "slip: -0.4, attitude: [25, 0, 0]").replace("slip: 0.2,", "slip: 0.2, attitude: [10, 0, 0],")
# They scoop soil, lose it where they turn down, and hand it to the ground.
ABOARD = """output: {forces: 20}
objects:
  - {name: plate, shape: {box: {size: [6, 8, 0.5]}}, sink: 1.2, carry: true, path: {points: [[20, 20], [50, 40]], speed: 6}}
  - {name: lifted, shape: {box: {size: [5, 6, 0.5]}}, carry: true, path: {file: scoop.csv}}
cache: {slots: 40}
"""
SCOOP = "t,x,y,z,yaw,pitch,roll\n" + "".join(f"{t},{x},{y},{z},{yaw},{pitch},0\n" for t, x, y, z, yaw, pitch in (
    (0, 80, 60, 99.4, 0, 0), (3, 95, 60, 99.4, 0, 0), (5, 96, 60, 102, 0, 0), (8, 110, 80, 102, 50, 0), (10, 110, 80, 103, 50, -55)))
MAP = "soil: {{map: classes.png, classes: {{1: {0}, 2: {1}}}, default: {2}}}\n"
PICTURES = """view: {size: [160, 90], camera: {overhead: {over: left, height: 40}}, effects: [texture], images: 7}
"""

# name: the scene, the store, what drive is told besides
SCENES = {
    "objects": (HEAD.format(step=0.05, end=90, model="box") + "attributes: [dirt]\n" + WHEELS + "cache: {slots: 24}\n",
                "hills.furrow", []),
    "slots": (HEAD.format(step=0.37, end=60, model="box") + "attributes: [dirt]\n" + WHEELS +
              "cache: {slots: 4, loaders: 1, prefetch: 0}\n", "hills.furrow", []),
    "holes": (HEAD.format(step=0.03, end=240, model="box") + ASTRAY + "cache: {slots: 9}\n", "holes.furrow", []),
    "overlay": (HEAD.format(step=0.11, end=120, model="none") + "attributes: [dirt]\n" + WHEELS + "cache: {slots: 12}\n",
                "hills.furrow", ["--overlay"]),
    "sliding": (HEAD.format(step=0.07, end=20, model="slippage, interval: 0.05") + "soil: {name: clayey_38}\n" +
                WHEELS + "cache: {slots: 40}\n", "hills.furrow", []),
    "eroding": (HEAD.format(step=0.07, end=8, model="sumner, interval: 0.05") + MAP.format("sand", "mud", "snow") +
                WHEELS + "cache: {slots: 40}\n", "gentle.furrow", []),
    "carried": (HEAD.format(step=0.05, end=12, model="scm, bulldozing: 0.5, interval: 0.03") + "soil: {name: dry_sand}\n" +
                LOADED.format(), "gentle.furrow", []),
    "carried later": (HEAD.format(step=0.13, end=16, model="scm, bulldozing: 0.8") +
                      MAP.format("dry_sand", "lete_sand", "snow_us") + LOADED.format(), "gentle.furrow", []),
    "pushing": (HEAD.format(step=0.05, end=12, model="scm, faces: on, interval: 0.03") + "soil: {name: dry_sand, janosi_shear: 0.3}\n" +
                PUSHING.format(), "gentle.furrow", []),
    "aboard": (HEAD.format(step=0.07, end=12, model="scm, interval: 0.03") + "soil: {name: dry_sand}\n" + ABOARD, "gentle.furrow", []),
    "sheet": (HEAD.format(step=0.05, end=60, model="sheet, tension: 20000, yield: 0.1, rut: 0.6") + "attributes: [dirt]\n" + WHEELS.replace("sink: 0.4", "load: 30000") +
              "cache: {slots: 24}\n", "hills.furrow", []),
    "bent": (HEAD.format(step=0.05, end=20, model="sheet, tension: 20000, yield: 0.1, rut: 0.6") + "compute: gpu\nattributes: [dirt]\n" + WHEELS +
             "cache: {slots: 24}\n", "hills.furrow", []),
    "thrown": (HEAD.format(step=0.05, end=12, model="scm, thrown: on, interval: 0.03") + "soil: {name: dry_sand}\n" +
               LOADED.format().replace("slip: 0.25", "slip: 0.7"), "gentle.furrow", []),
    "pictures": (HEAD.format(step=0.05, end=24.5, model="box") + WHEELS + "cache: {slots: 120}\n" + PICTURES,
                 "hills.furrow", []),
}


class NoGL(Exception):
    pass


def rows(store):
    """What deformation added; not which epoch wrote it."""
    db = sqlite3.connect(store)
    found = [db.execute(sql).fetchall() for sql in (
        'SELECT key, low, high, below, above, codec, hash, blob FROM "offset" ORDER BY key',
        "SELECT key, low, high, codec, hash, blob FROM dirt ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM heaped ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM pressed ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM shear ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM dug ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM settled ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM loose ORDER BY key",
        "SELECT key, low, high, codec, hash, blob FROM floor ORDER BY key",
        "SELECT value FROM meta WHERE key = 'compacted'")]
    db.close()
    return found


class Campaign:
    """One scene, driven and killed in a folder of its own."""

    def __init__(self, test, name, seed):
        text, self.base, self.options = SCENES[name]
        self.test, self.name = test, name
        self.chance = random.Random(f"{seed} {name}")
        self.folder = test.folder / name
        self.folder.mkdir()
        self.scene = self.folder / "scene.yaml"
        self.scene.write_text(text)
        (self.folder / "classes.png").write_bytes((test.folder / "classes.png").read_bytes())
        (self.folder / "scoop.csv").write_text(SCOOP)
        (self.folder / "poses.csv").write_text("t,x,y,z,yaw,pitch,roll\n" + POSES)
        self.counts = dict.fromkeys(("kills", "before_first_epoch", "nothing_new", "not_acknowledged", "interrupts", "resumed", "drives"), 0)

    def start(self, round_, resume):
        """The command, on its way, and the store it drives."""
        out, store = self.folder / f"out{round_}", self.folder / f"{round_}.furrow"
        command = [FURROW, "drive", self.scene, "-o", out, *(["--resume"] if resume else [])]
        if self.options:
            command += ["--store", self.test.folder / self.base, "--overlay", store]
        else:
            command += ["--store", store]
            if not store.exists():
                store.write_bytes((self.test.folder / self.base).read_bytes())
        process = subprocess.Popen([str(part) for part in command], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        return process, out, store

    def ended(self, process, status):
        _, errors = process.communicate(timeout=300)
        if process.returncode == 4:
            raise NoGL(errors)
        self.test.assertEqual(process.returncode, status, (self.name, errors))

    def result(self, out, store):
        report = json.loads((out / "run.json").read_text())
        figures = {key: report[key] for key in ("ended", "steps", "simulated", "spacing", "working_level", "volume", "objects")}
        pictures = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in out.glob("frame-*")}
        forces = out / "objects.csv"
        self.test.assertEqual(forces.exists(), "forces:" in self.scene.read_text())
        check = self.test.json("verify", store)
        self.test.assertTrue(check["ok"], check["problems"])
        return report, (rows(store), figures, pictures, forces.read_bytes() if forces.exists() else b"")

    def alone(self):
        started = time.monotonic()
        process, out, store = self.start("alone", False)
        self.ended(process, 0)
        report, self.wanted = self.result(out, store)
        self.test.assertIsNone(report["resumed_from"])
        self.test.assertGreater(len(self.wanted[0][0]), 20)
        self.seconds = report["seconds"]
        self.starting = time.monotonic() - started - self.seconds
        self.commits = report["io"]["commits"]
        print(f"{self.name}: {report['steps']} steps and {self.commits} commits in {self.seconds:.1f} s, after "
              f"{self.starting:.1f} s; committing {report['stage_ms']['writeback'] / 1e3 / self.seconds:.0%} of the time",
              flush=True)

    def state(self, out, store):
        """The last (epoch, step) in the store and in the log."""
        run = self.test.json("info", store)["last_run"] if store.exists() else None
        log = out / "epochs.log"
        text = log.read_text() if log.exists() else ""
        lines = [tuple(map(int, line.split()[1::2])) for line in text.splitlines(keepends=True) if line.endswith("\n")]
        self.test.assertEqual(lines, sorted(lines, key=lambda line: line[0]))
        self.test.assertEqual(lines, sorted(lines, key=lambda line: line[1]))
        self.test.assertEqual(len({epoch for epoch, _ in lines}), len(lines))
        return (run["epochs"], run["step"]) if run else (0, 0), lines[-1] if lines else (0, 0)

    def look(self, out, store, before):
        """After a kill; `before`: what the store held at the one before."""
        if store.exists():
            check = self.test.json("verify", store)
            self.test.assertTrue(check["ok"], check["problems"])
        committed, acknowledged = self.state(out, store)
        known = max(before, acknowledged)
        self.test.assertIn(committed[0] - known[0], (0, 1), (self.name, committed, known))
        if committed[0] == known[0]:
            self.test.assertEqual(committed[1], known[1], self.name)
        self.test.assertGreaterEqual(committed[1], known[1], self.name)
        self.counts["before_first_epoch"] += committed[0] == 0
        self.counts["nothing_new"] += committed == before
        self.counts["not_acknowledged"] += committed[0] > known[0]
        return committed

    def wait(self, process, out):
        """For the instant of the kill: some commits from now and a while, or anywhere in the beginning. Returns whether it is after new commits."""
        if self.chance.random() < 0.15:
            time.sleep(self.chance.uniform(0, self.starting))
            return False
        log = out / "epochs.log"
        lines, more = (len(log.read_bytes().splitlines()) if log.exists() else 0), self.chance.randint(1, 2 + self.commits // 4)
        while process.poll() is None and not (log.exists() and len(log.read_bytes().splitlines()) >= lines + more):
            time.sleep(0.002)
        time.sleep(self.chance.uniform(0, self.seconds / self.commits))
        return True

    def drive_once(self, round_, kills):
        """From the start to the end, with at most so many kills."""
        committed, resume, told = (0, 0), False, False
        while True:
            process, out, store = self.start(round_, resume)
            self.counts["resumed"] += resume
            left = self.counts["kills"] < kills
            gently = self.chance.random() < 0.15
            late = left and self.wait(process, out)
            if not left or process.poll() is not None:
                self.ended(process, 0)
                break
            process.send_signal(signal.SIGINT if gently else signal.SIGKILL)
            _, errors = process.communicate(timeout=300)
            if process.returncode == 0:
                break
            # An interrupt may come before it is caught.
            self.test.assertIn(process.returncode, (-signal.SIGINT, 130) if gently else (-signal.SIGKILL,), (self.name, errors))
            self.counts["interrupts" if gently else "kills"] += 1
            before, committed = committed, self.look(out, store, committed)
            self.test.assertTrue(committed > before or not late, (self.name, "commits that were acknowledged are gone", before, committed))
            # Killed when all was done and told: the next will find nothing left, and leave that as it is.
            report = out / "run.json"
            told = report.exists() and json.loads(report.read_text())["ended"] == "complete"
            resume = True
        report, found = self.result(out, store)
        for part, (got, wanted) in enumerate(zip(found, self.wanted, strict=True)):
            self.test.assertTrue(got == wanted, f"{self.name}: {'rows figures pictures forces'.split()[part]} are not those of a "
                                                f"drive that was left alone: {(got, wanted) if part == 1 else ''}")
        if not told:
            self.test.assertEqual(report["resumed_from"], committed[1] if committed[0] > 0 else None)
        self.counts["drives"] += 1

    def run(self, kills):
        self.alone()
        round_ = 0
        while self.counts["kills"] < kills:
            self.drive_once(round_, kills)
            for path in self.folder.glob(f"{round_}.furrow*"):
                path.unlink()
            round_ += 1
        return self.counts


class Resume(FurrowTest):
    def test_killed_over_and_over_it_ends_as_one_that_was_left_alone(self):
        kills, seed = int(os.environ.get("KILLS", "48" if FULL else "2")), int(os.environ.get("RESUME_SEED", "1"))
        print(f"KILLS={kills} RESUME_SEED={seed}", flush=True)
        write_png16(self.folder / "hills.png", 193, 193, lambda x, y: 100 + (x * 7 + y * 3) % 11 % 4)
        write_png16(self.folder / "holes.png", 193, 193,
                    lambda x, y: 0 if 60 < x < 90 and 90 < y < 140 or (x // 3 + y // 5) % 19 == 0 else 100 + (x * 7 + y * 3) % 11 % 4)
        # Ground that stands, in centimetres; and three soils over it.
        write_png16(self.folder / "gentle.png", 193, 193, lambda x, y: 10000 + (x * 7 + y * 3) % 11 + (x // 4 * y // 5) % 9)
        write_png16(self.folder / "classes.png", 193, 193, lambda x, y: (x // 20 + y // 15) % 3)
        for name, options in (("hills", []), ("holes", ["--nodata", "0"]), ("gentle", ["--height-range", "0,655.35"])):
            self.ok("import", f"{name}.png", "-o", f"{name}.furrow", "--tile", "16", *options)
        base = hashlib.sha256((self.folder / "hills.furrow").read_bytes()).digest()
        names = [list(SCENES)[place] for place in chosen(2, len(SCENES))]
        shares = {name: kills // len(names) + (i < kills % len(names)) for i, name in enumerate(names)}
        total = {}
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            campaigns = {name: pool.submit(Campaign(self, name, seed).run, share) for name, share in shares.items()}
            try:
                for name, campaign in campaigns.items():
                    counts = campaign.result()
                    print(name, counts, flush=True)
                    total = {key: total.get(key, 0) + count for key, count in counts.items()}
            except NoGL as error:
                self.skipTest(f"no GL here: {error}")
        print("all", total, flush=True)
        self.assertGreaterEqual(total["kills"], kills)
        self.assertGreaterEqual(total["resumed"], kills)
        self.assertEqual(hashlib.sha256((self.folder / "hills.furrow").read_bytes()).digest(), base)


if __name__ == "__main__":
    main()
