"""furrow study: what it varies, that it goes on, what it collects, and what schedulers run."""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, long, main, sampled

SCENE = """scene: 1
time_step: 0.05
end_time: 2
spacing: 0.0625
soil: {name: dry_sand}
redistribute: {model: scm}
objects:
  - name: wheel
    shape: {wheel: {radius: 0.25, width: 0.2}}
    path: {points: [[3, 8], [13, 8]], speed: 0.5}
    load: 1000
    slip: 0.1
output: {forces: 20}
"""
GRID = """study: 1
scene: scene.yaml
store: flat.furrow
names: {load: objects.wheel.load, soil: soil.name}
grid:
  load: [400, 800, 1600]
  soil: [dry_sand, lunar]
results:
  sinkage: {run: objects.wheel.sinkage}
  steps: {run: steps}
  model: {run: ended}
  pull: {objects: fx, of: wheel, take: mean, after: 1}
  deepest: {objects: sinkage, of: wheel, take: max}
  least: {objects: fz, of: wheel, take: min}
  end: {objects: x, of: wheel, take: last}
"""
CUBE = """study: 1
scene: scene.yaml
store: flat.furrow
names: {load: objects.wheel.load, soil: soil.name, slip: objects.wheel.slip, grousers: objects.wheel.shape.wheel.grousers}
hypercube:
  count: 8
  seed: 41
  parameters:
    load: {from: 200, to: 3200, scale: log}
    slip: {from: -0.1, to: 0.5}
    grousers: {from: 0, to: 11, whole: true}
    soil: [dry_sand, lunar, sandy_loam_15, clayey_38]
"""


def python_cube(name, seed, runs):
    """Shares of the range, as docs/STUDY.md describes them; written again."""
    mask = 2**64 - 1
    state = 0xcbf29ce484222325 ^ seed
    for byte in name.encode():
        state = (state ^ byte) * 0x100000001b3 & mask

    def draw():
        nonlocal state
        state = state + 0x9e3779b97f4a7c15 & mask
        x = state
        x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9 & mask
        x = (x ^ x >> 27) * 0x94d049bb133111eb & mask
        return x ^ x >> 31

    draw()
    part = list(range(runs))
    for left in range(runs, 1, -1):
        other = draw() % left
        part[left - 1], part[other] = part[other], part[left - 1]
    return [(k + (draw() >> 11) / 2**53) / runs for k in part]


class Study(FurrowTest):
    def setUp(self):
        super().setUp()
        self.store = self.synth("flat.furrow", posts="65x65", spacing=0.25, kind="plain", relief=0)
        self.scene(SCENE)

    def study(self, text, *arguments, out="out", status=0):
        """Runs a study. Skips where there is no GL."""
        self.scene(text, "study.yaml")
        result = self.furrow("study", "study.yaml", "-o", out, *arguments)
        if "no usable GL" in result.stderr or "EGL" in result.stderr:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, status, result.stderr + result.stdout)
        return result

    def rows(self, out="out"):
        with open(self.folder / out / "study.csv", newline="") as file:
            return list(csv.DictReader(file))

    def manifest(self, out="out"):
        return json.loads((self.folder / out / "study.json").read_text())

    def test_a_grid_s_table_is_what_its_runs_tell(self):
        before = self.store.read_bytes()
        self.study(GRID, "--jobs", 2)
        self.assertEqual(self.store.read_bytes(), before)
        rows = self.rows()
        self.assertEqual([(row["load"], row["soil"]) for row in rows], [(load, soil) for load in ("400", "800", "1600") for soil in ("dry_sand", "lunar")])
        for row in rows:
            folder = self.folder / "out" / "runs" / row["folder"]
            run = json.loads((folder / "run.json").read_text())
            self.assertEqual(run["objects"]["wheel"]["load"], float(row["load"]))
            self.assertEqual(float(row["sinkage"]), run["objects"]["wheel"]["sinkage"])
            self.assertEqual((row["steps"], row["model"], row["state"]), (str(run["steps"]), "complete", "complete"))
            with open(folder / "objects.csv") as file:
                columns = list(csv.DictReader(file))
            self.assertEqual({column["soil"] for column in columns}, {row["soil"]})
            late = [float(column["fx"]) for column in columns if float(column["t"]) >= 1]
            self.assertTrue(0 < len(late) < len(columns))
            self.assertAlmostEqual(float(row["pull"]), sum(late) / len(late), delta=1e-9 * abs(max(late, key=abs)))
            self.assertEqual(float(row["deepest"]), max(float(column["sinkage"]) for column in columns))
            self.assertEqual(float(row["least"]), min(float(column["fz"]) for column in columns))
            self.assertEqual(float(row["end"]), float(columns[-1]["x"]))
        self.assertEqual(len({row["sinkage"] for row in rows}), 6)
        loads = [float(row["sinkage"]) for row in rows if row["soil"] == "dry_sand"]
        self.assertEqual(loads, sorted(loads))
        self.assertEqual(self.manifest()["states"]["complete"], 6)
        plots = list((self.folder / "out").glob("*.svg"))
        self.assertEqual(len(plots), 7)
        tree = xml.etree.ElementTree.parse(self.folder / "out" / "sinkage-over-load-by-soil.svg")
        self.assertEqual([len(group.findall(".//{*}use")) for group in tree.findall(".//{*}g") if group.get("id", "").startswith("runs-of-")], [3, 3])

    def test_what_is_complete_is_not_run_again(self):
        self.study(GRID)
        files = {path: path.stat().st_mtime_ns for path in (self.folder / "out").glob("runs/*/run.json")}
        names = [row["folder"] for row in self.rows()]
        self.study(GRID)
        # One value more, in front: the others keep their folders, whatever their numbers are now.
        self.study(GRID.replace("[400, 800", "[200, 400, 800"))
        for path, changed in files.items():
            self.assertEqual(path.stat().st_mtime_ns, changed)
        rows = self.rows()
        self.assertEqual([row["folder"] for row in rows][2:], names)
        self.assertEqual([row["state"] for row in rows], ["complete"] * 8)
        # Another scene is another run.
        self.scene(SCENE.replace("slip: 0.1", "slip: 0.2"))
        self.study(GRID)
        self.assertFalse(set(names) & {row["folder"] for row in self.rows()})

    def test_a_list_may_vary_the_terrain(self):
        self.synth("other.furrow", posts="65x65", spacing=0.25, kind="plain", relief=0)
        shutil.move(self.folder / "other.furrow", self.folder / "other one.furrow")
        self.study("study: 1\nscene: scene.yaml\nset: {end_time: 1}\nlist:\n"
                   "  - {store: flat.furrow, objects.wheel.load: 500, soil: {name: clayey_38, cohesion: 900}}\n"
                   "  - {store: 'other one.furrow', objects.wheel.load: 700, soil: {name: \"lunar\"}}\n"
                   "results: {steps: {run: steps}, load: {run: objects.wheel.load}}\n")
        rows = self.rows()
        self.assertEqual([(row["load"], row["steps"]) for row in rows], [("500", "20"), ("700", "20")])
        self.assertEqual([row["soil"] for row in rows], ["{name: clayey_38, cohesion: 900}", "{name: lunar}"])
        parents = [self.json("info", f"out/runs/{row['folder']}/overlay.furrow") for row in rows]
        self.assertIn("other one.furrow", json.dumps(parents[1]))
        self.assertNotIn("other one.furrow", json.dumps(parents[0]))

    def test_a_hypercube_has_one_value_in_each_part(self):
        self.study(CUBE, "--write", "parallel")
        runs = [run["values"] for run in self.manifest()["runs"]]
        self.assertEqual(len(runs), 8)
        load = [math.log(float(run["load"]) / 200) / math.log(16) for run in runs]
        slip = [(float(run["slip"]) + 0.1) / 0.6 for run in runs]
        for values, name in ((load, "load"), (slip, "slip")):
            self.assertEqual(sorted(int(value * 8) for value in values), list(range(8)), name)
            for value, wanted in zip(values, python_cube(name, 41, 8), strict=True):
                self.assertAlmostEqual(value, wanted, delta=1e-9)
        self.assertEqual([run["grousers"] for run in runs], [str(int(share * 12)) for share in python_cube("grousers", 41, 8)])
        self.assertEqual(sorted(run["soil"] for run in runs), sorted(["dry_sand", "lunar", "sandy_loam_15", "clayey_38"] * 2))
        self.study(CUBE.replace("seed: 41", "seed: 42"), "--write", "parallel", out="other")
        self.assertNotEqual([run["values"] for run in self.manifest("other")["runs"]], runs)
        # A parameter less leaves the values of the others.
        self.study(CUBE.replace("    slip: {from: -0.1, to: 0.5}\n", "").replace("slip: objects.wheel.slip, ", ""), "--write", "parallel", out="less")
        self.assertEqual([run["values"]["load"] for run in self.manifest("less")["runs"]], [run["load"] for run in runs])
        for count in (1, 9, 100):
            self.study(CUBE.replace("count: 8", f"count: {count}"), "--write", "parallel", out=f"n{count}")
            slip = [(float(run["values"]["slip"]) + 0.1) / 0.6 for run in self.manifest(f"n{count}")["runs"]]
            self.assertEqual(sorted(int(value * count) for value in slip), list(range(count)))

    @long
    def test_a_grid_s_ranges(self):
        self.study("study: 1\nscene: scene.yaml\nstore: flat.furrow\ngrid:\n  objects.wheel.load: {from: 100, to: 10000, count: 3, scale: log}\n"
                   "  objects.wheel.slip: {from: 0, to: 0.3, count: 4}\n", "--write", "slurm")
        runs = [run["values"] for run in self.manifest()["runs"]]
        self.assertEqual([run["objects.wheel.load"] for run in runs], ["100"] * 4 + ["1000"] * 4 + ["10000"] * 4)
        self.assertEqual([float(run["objects.wheel.slip"]) for run in runs[:4]], [0, 0.1, 0.2, 0.3])

    # --- stopped and killed ---

    # Long enough that its first commit, after a second, is far from its end on a fast machine.
    LONG = GRID.replace("grid:", "set: {time_step: 0.002, end_time: 18, spacing: 0.015625}\ngrid:").replace("[400, 800, 1600]", "[800]")

    def begin(self, *arguments, drives=1):
        """Starts a study, and waits until so many drives have committed something: however long that takes."""
        self.study(self.LONG, "--write", "parallel")
        process = subprocess.Popen([FURROW, "study", "study.yaml", "-o", "out", *arguments], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        while process.poll() is None:
            if sum(path.stat().st_size > 0 for path in (self.folder / "out").glob("runs/*/epochs.log")) >= drives:
                return process
            time.sleep(0.02)
        if process.returncode == 0:
            self.skipTest("all runs were complete before the first look at them")
        errors = process.communicate()[1]
        if "EGL" in errors:
            self.skipTest("no GL here: " + errors.strip())
        self.fail("no drive has begun: " + errors)

    def drives(self):
        """Drives into this test's folder: their process ids, and the number of each run."""
        found = []
        for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = path.read_bytes().split(b"\0")
            except OSError:
                continue
            places = [word for word in words if word.startswith(os.fsencode(self.folder.resolve() / "out/runs/"))]
            if b"drive" in words[1:2] and places:
                found.append((int(path.parent.name), int(re.search(rb"/runs/(\d+)-", places[0])[1])))
        return found

    WHOLE = {}  # what an uninterrupted study leaves, once for all tests

    def left(self, out):
        return [(self.folder / out / "study.csv").read_bytes(),
                *((self.folder / out / "runs" / row["folder"] / "objects.csv").read_bytes() for row in self.rows(out))]

    def goes_on(self):
        """The study goes on, to what an uninterrupted one has. Returns the step that each run went on from."""
        self.study(self.LONG)
        if not self.WHOLE:
            self.study(self.LONG, out="whole")
            self.WHOLE["left"] = self.left("whole")
        self.assertEqual(self.left("out"), self.WHOLE["left"])
        return [json.loads((self.folder / "out/runs" / row["folder"] / "run.json").read_text())["resumed_from"] for row in self.rows()]

    def test_ctrl_c_ends_it_cleanly(self):
        process = self.begin("--jobs", "2", drives=2)
        process.send_signal(signal.SIGINT)
        errors = process.communicate(timeout=250)[1]
        if process.returncode == 0:
            self.skipTest("both runs were complete before Ctrl-C")
        self.assertEqual(process.returncode, 130, errors)
        self.assertEqual(self.drives(), [])
        states = [run["state"] for run in self.manifest()["runs"]]  # one may be complete by then
        self.assertTrue(set(states) <= {"complete", "interrupted"} and "interrupted" in states, states)
        self.assertIn(f"interrupted, {states.count('complete')} of 2 runs are complete", errors)
        self.assertEqual([step is not None for step in self.goes_on()], [state == "interrupted" for state in states])

    @long
    def test_killed_it_goes_on(self):
        process = self.begin("--jobs", "1")
        process.kill()
        process.communicate()
        while self.drives():  # the drive does not go on alone
            time.sleep(0.02)
        ended = [json.loads(path.read_text())["ended"] for path in sorted((self.folder / "out").glob("runs/*/run.json"))]
        self.assertTrue(set(ended) <= {"complete", "interrupted"} and ended, ended)
        ended += [None] * (2 - len(ended))  # has not begun
        self.assertEqual([step is not None for step in self.goes_on()], [state == "interrupted" for state in ended])

    def test_a_killed_drive_is_told_and_goes_on(self):
        process = self.begin("--jobs", "1")
        found = None
        while process.poll() is None and not found:  # between two runs there is none
            found = self.drives()
        if not found:
            self.skipTest("both runs were complete before one was killed")
        (drive, run), = found
        os.kill(drive, signal.SIGKILL)
        errors = process.communicate(timeout=250)[1]
        self.assertEqual(process.returncode, 1, errors)
        self.assertRegex(errors, rf"run {run:04}-[0-9a-f]{{12}} failed: was ended by signal 9")
        self.assertEqual([row["state"] for row in self.rows()], ["failed" if run == i else "complete" for i in (1, 2)])
        self.goes_on()

    def test_one_that_fails_does_not_stop_the_others(self):
        text = ("study: 1\nscene: scene.yaml\nstore: flat.furrow\nnames: {way: objects.wheel.path.points}\n"
                "grid:\n  way: ['%s', '%s', '%s']\nresults: {x: {objects: x, of: wheel, take: last}}\n")
        text = text.replace("'%s'", "%s") % ("[[3, 8], [9, 8]]", "[[15.5, 8], [30, 8]]", "[[8, 3], [8, 9]]")
        result = self.study(text, "--jobs", "1", status=1)
        error = self.told(1, result)
        self.assertIn("1 of 3 runs failed, first 0002-", error)
        log = next((self.folder / "out/runs").glob("0002-*/log.txt")).read_text()
        last = [line for line in log.splitlines() if line.startswith("furrow: ") and not line.startswith("furrow: note: ")][-1]
        self.assertIn(last[8:][:100], error)
        rows = self.rows()
        self.assertEqual([row["state"] for row in rows], ["complete", "failed", "complete"])
        self.assertEqual([row["x"] for row in rows][1:], ["", "8"])
        self.assertEqual(self.manifest()["runs"][1]["error"], last[8:])

    # --- schedulers ---

    @long
    def test_schedulers_run_the_same(self):
        self.study(GRID)
        wanted = (self.folder / "out/study.csv").read_bytes()
        self.study(GRID, "--write", "parallel", out="b'y list")
        self.assertEqual(self.manifest("b'y list")["states"]["waiting"], 6)
        subprocess.run(["sh", "parallel.txt"], cwd=self.folder / "b'y list", check=True)
        self.ok("study", "collect", "b'y list")
        self.assertEqual((self.folder / "b'y list/study.csv").read_bytes(), wanted)
        self.study(GRID, "--slurm", "--jobs", 3, out="by slurm")
        script = (self.folder / "by slurm/slurm.sh").read_text()
        self.assertIn("#SBATCH --array=1-6%3\n", script)
        for task in range(1, 7):
            env = dict(os.environ, SLURM_ARRAY_TASK_ID=str(task))
            subprocess.run(["sh"], input=script, text=True, cwd="/", env=env, check=True)  # Slurm runs a copy
            self.ok("study", "study.yaml", "-o", "by slurm", "--collect")
            self.assertEqual(sum(row["state"] == "complete" for row in self.rows("by slurm")), task)
        self.assertEqual((self.folder / "by slurm/study.csv").read_bytes(), wanted)
        self.assertNotEqual(subprocess.run(["sh"], input=script, text=True, env=dict(os.environ, SLURM_ARRAY_TASK_ID="7"),
                                           stderr=subprocess.DEVNULL).returncode, 0)
        # What is complete stays, by run.sh, too.
        files = {path: path.stat().st_mtime_ns for path in (self.folder / "b'y list").glob("runs/*/run.json")}
        subprocess.run(["sh", "parallel.txt"], cwd=self.folder / "b'y list", check=True)
        for path, changed in files.items():
            self.assertEqual(path.stat().st_mtime_ns, changed)

    def test_a_snakefile(self):
        self.study(GRID, "--write", "snakemake")
        text = (self.folder / "out/Snakefile").read_text()
        for run in self.manifest()["runs"]:
            self.assertIn(f'"{run["folder"]}"', text)
        if shutil.which("snakemake") is None:
            self.skipTest("not on this machine: no snakemake")
        subprocess.run(["snakemake", "--snakefile", "out/Snakefile", "--cores", "2"], cwd=self.folder, check=True, capture_output=True)
        self.assertEqual([row["state"] for row in self.rows()], ["complete"] * 6)

    # --- what is shipped ---

    def test_the_shipped_studies_are_whole(self):
        shipped = pathlib.Path(__file__).parents[2] / "tools" / "scenes" / "studies"
        for path in shipped.glob("*.yaml"):
            shutil.copy(path, self.folder)
        for name, runs in (("drawbar", 45), ("hypercube", 12)):
            self.ok("study", f"{name}.yaml", "-o", name, "--write", "parallel")
            self.assertEqual(len(self.manifest(name)["runs"]), runs)
        first = (self.folder / "drawbar/parallel.txt").read_text().splitlines()[0]
        if subprocess.run(["sh", "-c", first]).returncode == 4:
            self.skipTest("no GL here")
        self.ok("study", "collect", "drawbar")
        row = self.rows("drawbar")[0]
        self.assertTrue(float(row["sinkage"]) > 0 and float(row["drawbar"]) > 0 and float(row["torque"]) < 0, row)

    def test_columns_of_vehicles(self):
        shipped = pathlib.Path(__file__).parents[2] / "tools" / "scenes" / "vehicles"
        self.synth("hill.furrow", posts="129x129", spacing=1, relief=0, kind="plain")
        shutil.copy(shipped / "offroad.xml", self.folder)
        text = (shipped / "offroad.yaml").read_text()
        name = text.partition("- name: ")[2].split()[0]
        self.scene(text, "car.yaml")
        self.scene(f"study: 1\nscene: car.yaml\nstore: hill.furrow\nset: {{end_time: 2, view: null}}\n"
                   f"grid: {{vehicles.{name}.driver.path.speed: [2, 4]}}\nresults:\n  x: {{vehicles: x, of: {name}, take: last}}\n"
                   f"  fastest: {{vehicles: vx, of: {name}, take: max}}\n", "study.yaml")
        result = self.furrow("study", "study.yaml", "-o", "out")
        if result.returncode != 0 and ("MuJoCo" in result.stderr or "EGL" in result.stderr):
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        for row in self.rows():
            with open(self.folder / "out/runs" / row["folder"] / "vehicles.csv") as file:
                columns = list(csv.DictReader(file))
            self.assertEqual(float(row["x"]), float(columns[-1]["x"]))
            self.assertEqual(float(row["fastest"]), max(float(column["vx"]) for column in columns))
        self.assertNotEqual(*(row["fastest"] for row in self.rows()))

    # --- refused ---

    def test_refused_studies(self):
        cases = [
            (GRID.replace("grid:", "grit:"), 5, "grit"), (GRID.replace("study: 1", "study: 2"), 1, "allowed: 1 to 1"),
            (GRID.replace("study: 1\n", ""), 1, "says no version"), (GRID.replace("scene: scene.yaml\n", ""), 1, "names no scene"),
            (GRID.replace("[400, 800, 1600]", "400"), 6, "single value"), (GRID.replace("[400, 800, 1600]", "[]"), 6, "0 values"),
            (GRID.replace("[400, 800, 1600]", "[400, 400]"), 6, "twice"), (GRID + "grid: {a: [1]}\n", 16, "twice"),
            (GRID + "list: [{a: 1}]\n", 16, "second design"), (GRID.replace("[400, 800, 1600]", "{from: 5, to: 4, count: 2}"), 6, "from below to"),
            (GRID.replace("[400, 800, 1600]", "{from: 0, to: 4, count: 3, scale: log}"), 6, "from above 0"),
            (GRID.replace("[400, 800, 1600]", "{from: 1, to: 4}"), 6, "count"), (GRID.replace("[400, 800, 1600]", "{from: 1, to: 4, count: 2.5}"), 6, "count"),
            (GRID.replace("[400, 800, 1600]", "{from: 1, to: x, count: 3}"), 6, "no number"),
            (GRID.replace("[400, 800, 1600]", "{from: 1, to: 4, count: 1001}"), 6, "allowed: 2 to 1000"),
            (GRID.replace("[400, 800, 1600]", "{from: 1, to: 4, cuont: 3}"), 6, "cuont"), (GRID.replace("{load:", "{a: b, load:"), 4, "no parameter"),
            (GRID.replace("soil: soil.name", "soil: objects.wheel.load"), 7, "set elsewhere"),
            (GRID.replace("grid:", "set: {store: a}\ngrid:"), 5, "cannot be set"),
            (GRID.replace("take: max", "take: most"), 13, "allowed: mean, max, min, last"), (GRID.replace(", take: max", ""), 13, "of"),
            (GRID.replace("run: steps", "run: steps, of: wheel"), 10, "`run` alone"), (GRID.replace("  steps:", "  load:"), 10, "name of a parameter"),
            (GRID + "plots: [{x: load, y: depth}]\n", 16, "no result"), (GRID + "plots: [{x: lode, y: end}]\n", 16, "allowed: load, soil"),
            (GRID + "plots: [{x: load, y: end, by: load}]\n", 16, "another parameter"),
            (CUBE.replace("count: 8", "count: 10001"), 6, "10000"), (CUBE.replace("count: 8", "count: 0"), 6, "allowed: 1"),
            (CUBE.replace("seed: 41", "seed: -1"), 7, "allowed: 0"), (CUBE.replace("  count: 8\n", ""), 5, "count"),
            (CUBE.replace("from: 0, to: 11", "from: 0.5, to: 11"), 11, "whole"), (CUBE.replace("  count: 8", "  count: 8\n  cuont: 9"), 7, "cuont"),
            ("study: 1\nscene: scene.yaml\nlist:\n  - {a: 1}\n  - {b: 1}\n", 5, "lacks a"), ("study: 1\nscene: scene.yaml\nlist: []\n", 3, "0 runs"),
            ("study: 1\nscene: scene.yaml\nlist:\n  - {a: 1}\n  - {a: 1, b: 1}\n", 5, "first run"), ("study: 1\nscene: scene.yaml\n", 1, "what is varied"),
            ("study: 1\nscene: scene.yaml\ngrid: {" + ", ".join(f"k{i}: {{from: 0, to: 1, count: 10}}" for i in range(5)) + "}\n", 3, "10000 runs"),
        ]
        for text, line, why in sampled(cases):
            self.scene(text, "study.yaml")
            error = self.refused(3, "study", "study.yaml", "-o", "out")
            self.assertRegex(error, rf"study\.yaml:{line}:\d+: ")
            self.assertIn(why, error)
            self.assertFalse((self.folder / "out").exists())

    def test_every_run_s_scene_is_checked_before_one_runs(self):
        for change, why in ((("soil.name}", "soil.nmae}"), "nmae"), (("1600]", "-5]"), "2 of 6 runs cannot begin: 5 (load: -5, soil: dry_sand), 6 (load: -5, soil: lunar): of the first: "),
                            (("lunar]", "cheese]"), "3 of 6 runs cannot begin: 2 (load: 400, soil: cheese), 4 (load: 800, soil: cheese), 6 (load: 1600, soil: cheese): of "),
                            (("[400, 800, 1600]", "[" + ", ".join(map(str, range(-5, 15))) + "]"), "(load: -4, soil: dry_sand) and 9 more: of the first: "),
                            (("grid:", "set: {spacing: 1e-9}\ngrid:"), " and 3 more: of the first: spacing: 1e-09 m is finer than "),
                            (("flat.furrow", "none.furrow"), "none.furrow"), (("scene.yaml", "none.yaml"), "none.yaml"),
                            (("[dry_sand, lunar]", "[dry_sand, ' dry_sand']"), ': 2 (load: 400, soil: " dry_sand"), 4 ')):
            self.scene(GRID.replace(*change), "study.yaml")
            self.assertIn(why, self.refused(3, "study", "study.yaml", "-o", "out"))
            self.assertFalse((self.folder / "out").exists())
        self.scene("study: 1\nscene: scene.yaml\nstore: flat.furrow\nlist: [{soil.name: clayey_38}, {soil.name: lunar}, {soil.name: clayey_38}]\n", "study.yaml")
        self.assertIn("runs 1 and 3 have the same settings", self.refused(3, "study", "study.yaml", "-o", "out"))

    def test_vehicles_of_every_run_are_checked_before_one_runs(self):
        model = pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml"
        self.scene("scene: 1\ntime_step: 0.002\nend_time: 0.02\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                   f"vehicles: [{{name: car, model: {model}, start: {{at: [8, 8]}}, driver: {{hold: {{drive: 1}}}}}}]\n", "car.yaml")
        steps = ", ".join(f"{0.002 + i:g}" for i in range(200))
        self.scene(f"study: 1\nscene: car.yaml\nstore: flat.furrow\ngrid: {{time_step: [{steps}]}}\n", "study.yaml")
        error = self.refused(3, "study", "study.yaml", "-o", "out")
        if "MuJoCo" in error:
            self.skipTest(error)
        self.assertRegex(error, r"199 of 200 runs cannot begin: 2 \(time_step: 1.002\), 3 .* and 196 more: of the first: .*car: time_step: 1.002 s is longer than ")
        self.assertFalse((self.folder / "out").exists())

    def test_results_and_plots_are_checked_before_one_runs(self):
        ten = "[dry_sand, sandy_loam_15, sandy_loam_22, clayey_38, heavy_clay_25, heavy_clay_40, lean_clay_22, lete_sand, snow_us, lunar]"
        many = GRID.replace("[400, 800, 1600]", "[400]").replace("[dry_sand, lunar]", ten)
        for text, why in ((many + "plots: [{x: load, y: end, by: soil}]\n", "study.yaml:16:9: plots[0]: is by soil, which has more than 8 values that are no numbers; "),
                          (GRID.replace("objects: fx", "objects: fq"), "study.yaml:12:3: results.pull: fq is no column; allowed: t, x, y"),
                          (GRID.replace("objects: fx", "objects: state"), "state is no column"),
                          (GRID.replace("of: wheel, take: max", "of: whale, take: max"), "results.deepest: no run has whale among its objects; allowed: "),
                          (GRID.replace("objects: fx", "vehicles: vx"), "no run has wheel among its vehicles; "),
                          (GRID.replace("grid:", "set: {output.forces: 0}\ngrid:"), "no run writes such rows; allowed with: output.forces above 0")):
            self.scene(text, "study.yaml")
            self.assertIn(why, self.refused(3, "study", "study.yaml", "-o", "out"))
            self.assertFalse((self.folder / "out").exists())
        # Values of run.json are known from the first run that is complete: no other is begun then.
        self.scene(GRID.replace("objects.wheel.sinkage", "objects.wheel.sinkag").replace("results:", "set: {end_time: 0.1}\nresults:"), "study.yaml")
        self.assertIn("sinkag is not in run.json", self.refused(3, "study", "study.yaml", "-o", "out", "--jobs", "1"))
        states = [run["state"] for run in self.manifest()["runs"]]
        self.assertEqual(states[0], "complete")
        self.assertEqual(set(states[2:]), {"waiting"})

    def test_plots_that_nobody_named_leave_out_what_has_too_many_values(self):
        many = GRID.replace("[400, 800, 1600]", "[400]").replace("[dry_sand, lunar]", str([f"{{name: lunar, cohesion: {i}}}" for i in range(100, 109)]).replace("'", ""))
        self.study(many.replace("soil.name", "soil").replace("results:", "set: {end_time: 0.1}\nresults:"))
        self.assertTrue((self.folder / "out/steps-over-load.svg").exists())

    def test_wrong_usage(self):
        self.scene(GRID, "study.yaml")
        for arguments in (["study.yaml"], [], ["study.yaml", "-o", "out", "--jobs", "0"], ["study.yaml", "-o", "out", "--write", "pbs"],
                          ["study.yaml", "more", "-o", "out"], ["collect", "out", "-o", "out"], ["study.yaml", "-o", "out", "--write", "slurm", "--collect"],
                          ["study.yaml", "-o", "out", "--slurm", "--parallel"]):
            self.refused(2, "study", *arguments)
        self.refused(3, "study", "collect", "nowhere")

    def test_a_notebook_has_the_same_table(self):
        self.study(GRID.replace("[400, 800, 1600]", "[400, 800]"))
        script = ("import furrow, json; frame = furrow.study('out')\nprint(json.dumps([list(frame.columns), list(frame.index), frame['load'].tolist(), frame['soil'].tolist(),"
                  " frame['pull'].tolist(), [path.name for path in furrow.studies.collect('out')]]))")
        before = (self.folder / "out/study.csv").read_bytes()
        (self.folder / "out/study.csv").unlink()
        columns, index, loads, soils, pulls, plots = json.loads(self.python(script, needs=("pandas", "matplotlib")))
        self.assertEqual((self.folder / "out/study.csv").read_bytes(), before)
        rows = self.rows()
        self.assertEqual(columns, list(rows[0])[1:])
        self.assertEqual((index, loads, soils), ([1, 2, 3, 4], [400, 400, 800, 800], [row["soil"] for row in rows]))
        self.assertEqual(pulls, [float(row["pull"]) for row in rows])
        self.assertEqual(sorted(plots), sorted(path.name for path in (self.folder / "out").glob("*.svg")))

    def test_without_matplotlib_the_table_is_whole_and_no_old_plot_stays(self):
        self.study(GRID.replace("[400, 800, 1600]", "[400]"))
        self.assertEqual(len(list((self.folder / "out").glob("*.svg"))), 7)
        before = (self.folder / "out/study.csv").read_bytes()
        (self.folder / "lacks").mkdir()
        (self.folder / "lacks/matplotlib.py").write_text("raise ImportError\n")
        result = self.furrow("study", "collect", "out", env={"PYTHONPATH": str(self.folder / "lacks")})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"\Afurrow: note: .*/out: no plot is drawn: the Python package matplotlib is not installed for .*pip install matplotlib\n\Z")
        self.assertRegex(result.stdout, r"\A2 of 2 runs are complete: .*/out/study.csv, and 0 plots\n\Z")
        self.assertEqual(((self.folder / "out/study.csv").read_bytes(), list((self.folder / "out").glob("*.svg"))), (before, []))
        self.assertIn("name a Python 3 in FURROW_PYTHON", self.refused(1, "study", "collect", "out", env={"FURROW_PYTHON": "./gone"}))

    def test_what_cannot_be_collected_says_what_can(self):
        self.study(GRID)
        for change, why in ((("objects.wheel.sinkage", "objects.wheel.sinkag"), "sinkage"), (("objects.wheel.sinkage", "objects.wheel"), "no single value"),
                            (("objects: fx", "objects: fq"), "fx"), (("objects: fx", "objects: state"), "numbers"), (("objects: fx", "vehicles: vx"), "output.vehicles")):
            self.scene(GRID.replace(*change), "study.yaml")
            self.assertIn(why, self.refused(3, "study", "study.yaml", "-o", "out", "--collect"))
        self.scene(GRID.replace("of: wheel, take: max", "of: whale, take: max"), "study.yaml")
        result = self.furrow("study", "study.yaml", "-o", "out", "--collect")
        self.assertIn("has no row of whale", result.stderr)
        self.assertEqual([row["deepest"] for row in self.rows()], [""] * 6)


if __name__ == "__main__":
    main()
