"""Where no EGL driver is to be found, drive, rig and mobility of soil that bears leave the same as where there is one. Kinematic models, which the GPU computes
otherwise, are computed by the CPU: a note tells it, and the bits are the same."""
import csv
import json
import sqlite3

from furrow_test import MAPS, FurrowTest, main

TABLES = ("offset", "dirt", "heaped", "pressed", "shear", "dug")
SCENE = """scene: 1
time_step: 0.004
end_time: 2
spacing: 0.125
soil: {name: dry_sand}
redistribute: {model: %s, slip_sinkage: 1}
attributes: [disturbance]
objects:
  - {name: wheel, shape: {wheel: {radius: 0.3, width: 0.2}}, load: 900, slip: 0.2, path: {points: [[10, 10], [13, 11]], speed: 2}}
  - {name: blade, shape: {box: {size: [0.2, 1, 0.5]}}, sink: 0.05, path: {points: [[10, 14], [13, 14]], speed: 2}}
output: {forces: 20, vehicles: 20}
"""
CAR = """<mujoco><option timestep="0.002" integrator="implicit"/><worldbody><body name="car" pos="0 0 0.6"><freejoint/>
<inertial pos="0 0 0.1" mass="880" diaginertia="300 800 900"/>%s</body></worldbody><actuator>%s</actuator></mujoco>""" % (
    "".join(f'<body pos="{x} {y} -0.2"><joint name="turn_{name}" axis="0 1 0" armature="1"/>'
            f'<geom name="wheel_{name}" type="cylinder" size="0.4 0.15" euler="90 0 0" mass="30"/></body>'
            for name, x, y in (("fl", 1.1, 0.9), ("fr", 1.1, -0.9), ("rl", -1.1, 0.2), ("rr", -1.1, -0.2))),
    "".join(f'<velocity name="drive_{name}" joint="turn_{name}" kv="3000"/>' for name in ("fl", "fr", "rl", "rr")))
VEHICLE = """vehicles:
  - {name: car, model: car.xml, start: {at: [10, 20]}, driver: {path: {points: [[10, 20], [16, 20]], speed: 2}, drive: [drive_*]}}
"""


class NoEgl(FurrowTest):
    def setUp(self):
        super().setUp()
        (self.folder / "no_drivers").mkdir()
        # libglvnd then knows no vendor, and a libEGL of Mesa alone no display.
        self.blind = {"__EGL_VENDOR_LIBRARY_DIRS": str(self.folder / "no_drivers"), "__EGL_VENDOR_LIBRARY_FILENAMES": str(self.folder / "no_drivers/none.json"),
                      "EGL_PLATFORM": "surfaceless"}
        self.synth(posts="65x65", spacing=0.5, kind="plain", relief=0.5)
        (self.folder / "car.xml").write_text(CAR)

    def driven(self, out, env, vehicle=True):
        """The rows of the ruts, and each file that tells of bodies."""
        text = SCENE % "scm"
        self.scene(text + VEHICLE if vehicle else text.replace(", vehicles: 20", ""))
        result = self.furrow("drive", "scene.yaml", "--store", "world.furrow", "--overlay", out + ".furrow", "-o", out, env=env)
        if vehicle and "no MuJoCo" in result.stderr:
            return self.driven(out, env, vehicle=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        store = sqlite3.connect(self.folder / (out + ".furrow"))
        self.addCleanup(store.close)
        rows = {table: store.execute(f'SELECT key, low, high, codec, hash, blob FROM "{table}" ORDER BY key').fetchall() for table in TABLES}
        files = {name: (self.folder / out / name).read_bytes() for name in ("objects.csv",) + (("vehicles.csv",) if vehicle else ())}
        files["the last row of volume.csv"] = (self.folder / out / "volume.csv").read_text().splitlines()[-1]  # the others are those of commits, whose times a clock chooses
        return rows, files

    def test_an_edit(self):
        for name, env in (("seeing", {}), ("blind", self.blind)):
            self.synth(f"{name}.furrow", posts="65x65", spacing=0.5, kind="plain", relief=0.5)
            self.ok("edit", f"{name}.furrow", "--polygon", "POLYGON ((5 5, 12 5, 9 13))", "--volume", 20, env=env)
        contents = []
        for name in ("seeing", "blind"):
            store = sqlite3.connect(self.folder / f"{name}.furrow")
            self.addCleanup(store.close)
            contents.append([store.execute(f'SELECT key, hash, blob FROM "{table}" ORDER BY key').fetchall() for table in TABLES])
        self.assertGreater(len(contents[0][0]), 0)
        self.assertEqual(contents[0], contents[1])

    def test_a_drive(self):
        with_picture = ("--set", "view={camera: {fixed: {eye: [1, 1, 10], target: [10, 10, 0]}}, size: [64, 48], images: 25}")
        self.scene((SCENE % "scm").replace(", vehicles: 20", ""))
        self.refused(4, "drive", "scene.yaml", "--store", "world.furrow", "--overlay", "seen.furrow", "-o", "seen", *with_picture, env=self.blind)  # it is hidden
        blind, seeing = self.driven("blind", self.blind), self.driven("seeing", None)
        for table in TABLES:
            self.assertGreater(len(blind[0][table]), 0, table)
        self.assertEqual(blind, seeing)

    def test_kinematic_models(self):
        text = (SCENE % "scm").replace(", slip_sinkage: 1", "").replace(", vehicles: 20", "").replace("load: 900, slip: 0.2", "sink: 0.1").replace("{name: dry_sand}", "{name: %s}")
        for model, soil in (("none", "sand"), ("box", "sand"), ("sumner", "sand"), ("slippage", "dry_sand")):
            self.scene(text.replace("model: scm", f"model: {model}") % soil)
            found = []
            for out, env in ((f"blind-{model}", self.blind), (f"seeing-{model}", None)):
                drive = ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", out + ".furrow", "-o", out)
                result = self.furrow(*drive, env=env)
                self.assertEqual(result.returncode, 0, result.stderr)
                notes = [line for line in result.stderr.splitlines() if "the CPU computes" in line]
                self.assertEqual(len(notes), env is not None, result.stderr)
                if env is not None:
                    self.assertRegex(notes[0], rf"^furrow: note: GL: [^;]+: the CPU computes model {model}, .+compute: cpu")
                store = sqlite3.connect(self.folder / (out + ".furrow"))
                rows = {table: store.execute(f'SELECT key, low, high, codec, hash, blob FROM "{table}" ORDER BY key').fetchall() for table in TABLES}
                store.close()
                self.assertGreater(len(rows["offset"]), 0)
                run = json.loads((self.folder / out / "run.json").read_text())
                self.assertEqual(run["computed"]["by"], "cpu" if env is not None else "gpu")
                found.append((rows, (self.folder / out / "objects.csv").read_bytes(), run["volume"]))
            self.assertTrue(found[0] == found[1], model)
            self.assertIn("GL", self.refused(4, *drive, "--set", "compute=gpu", env=self.blind))
            asked = self.furrow(*drive, "--set", "compute=cpu", "--overlay", f"asked-{model}.furrow", env=self.blind)
            self.assertEqual((asked.returncode, "the CPU computes" in asked.stderr), (0, False), asked.stderr)

    def test_a_rig(self):
        found = []
        for out, env in (("blind", self.blind), ("seeing", None)):
            self.ok("rig", "-o", out, "--shape", "wheel: {radius: 0.32, width: 0.24}", "--spacing", "0.08", "--slip", "0,0.2", "--passes", "2", env=env)
            found.append((self.folder / out / "rig.csv").read_bytes())
        self.assertEqual(len(list(csv.reader(found[0].decode().splitlines()))), 3)
        self.assertEqual(*found)

    def test_mobility(self):
        if not MAPS:
            self.skipTest("this build draws no maps")
        found = []
        for out, env in (("blind", self.blind), ("seeing", None)):
            result = self.furrow("mobility", "world.furrow", "--vehicle", "car.xml", "--soil", "dry_sand", "--spacing", "0.125", "-o", out + ".png", "--json", env=env)
            if "no MuJoCo" in result.stderr:
                self.skipTest(result.stderr.strip())
            self.assertEqual(result.returncode, 0, result.stderr)
            found.append((result.stdout.replace(out, "OUT"), (self.folder / (out + ".png")).read_bytes()))
        self.assertEqual(*found)


if __name__ == "__main__":
    main()
