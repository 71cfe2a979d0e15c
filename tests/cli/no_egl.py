"""Soil that bears needs no GL: where no EGL driver is to be found, drive, rig and mobility leave the same as where there is one."""
import csv
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
        files = {name: (self.folder / out / name).read_bytes() for name in ("objects.csv", "volume.csv") + (("vehicles.csv",) if vehicle else ())}
        return rows, files

    def test_a_drive(self):
        with_picture = ("--set", "view={camera: {fixed: {eye: [1, 1, 10], target: [10, 10, 0]}}, size: [64, 48], images: 25}")
        self.scene((SCENE % "scm").replace(", vehicles: 20", ""))
        self.refused(4, "drive", "scene.yaml", "--store", "world.furrow", "--overlay", "seen.furrow", "-o", "seen", *with_picture, env=self.blind)  # it is hidden
        blind, seeing = self.driven("blind", self.blind), self.driven("seeing", None)
        for table in ("offset", "dirt", "heaped", "pressed", "shear", "dug"):
            self.assertGreater(len(blind[0][table]), 0, table)
        self.assertEqual(blind, seeing)

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
