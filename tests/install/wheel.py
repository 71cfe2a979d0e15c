"""`pip install .`: in a fresh environment the command, the Python package and its vehicles work, and no variable is needed."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = pathlib.Path(os.environ["FURROW_BUILD"]) / "wheel"
PROGRAM = """
import furrow
scene = {"spacing": 0.0625, "soil": {"name": "lunar"}, "redistribute": {"model": "scm"}}
with furrow.World(scene, store="plain.furrow", overlay="ball.furrow") as world:
    ball = world.add(shape={"sphere": {"radius": 0.2}})
    z = world.points([(30, 30)])["height"][0] + 0.2
    ball.place(position=(30, 30, z))
    ball.set(position=(30, 30, z - 0.05))
    world.step(0.01)
    assert ball.contact.force[2] > 100, ball.contact.force[2]
    print("a ball presses the soil")
"""


class WheelTest(unittest.TestCase):
    """Nothing of the variables that other tests set is there, and neither is this checkout's folder."""

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir(parents=True)
        if cls.run_in(sys.executable, "-m", "venv", "fresh").returncode != 0:
            raise unittest.SkipTest("this Python makes no environments (python3-venv)")
        if cls.run_in("fresh/bin/pip", "download", "--no-deps", "-d", "there", "meson-python").returncode != 0:
            raise unittest.SkipTest("pip fetches nothing here")
        cls.installed = cls.run_in("fresh/bin/pip", "install", ROOT)

    @staticmethod
    def run_in(*command):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("FURROW", "PYTHON", "LD_", "ASAN", "UBSAN"))}
        return subprocess.run([*map(str, command)], capture_output=True, text=True, cwd=FOLDER, env=environment, timeout=2500)

    def output(self, *command):
        result = self.run_in(*command)
        self.assertEqual(result.returncode, 0, result.stdout[-2000:] + result.stderr[-2000:])
        return result.stdout

    def test_pip_installs_what_works(self):
        self.assertEqual(self.installed.returncode, 0, self.installed.stdout[-3000:] + self.installed.stderr[-3000:])
        self.assertIn("furrow ", self.output("fresh/bin/furrow", "--version"))
        self.output("fresh/bin/furrow", "synth", "-o", "plain.furrow", "--kind", "plain", "--posts", "257x257", "--spacing", "0.25")
        self.assertEqual(self.output("fresh/bin/python", "-c", PROGRAM), "a ball presses the soil\n")

    def test_its_vehicles_need_no_folder_of_the_build(self):
        if "vehicles: MuJoCo" not in self.output("fresh/bin/furrow", "--version"):
            self.skipTest("this build has no MuJoCo")
        self.output("fresh/bin/furrow", "synth", "-o", "hill.furrow", "--kind", "plain", "--posts", "257x257", "--spacing", "0.25")
        model = ROOT / "tests/vehicle/one_wheel.xml"
        (FOLDER / "one.yaml").write_text(f"scene: 1\nend_time: 0.1\ntime_step: 0.002\nspacing: 0.0625\nsoil: {{name: dry_sand}}\n"
                                         f"redistribute: {{model: scm}}\nvehicles:\n  - {{name: one, model: {model}, start: {{at: [20, 20]}}}}\n")
        self.output("fresh/bin/furrow", "drive", "one.yaml", "--store", "hill.furrow", "--overlay", "one.furrow", "-o", "out")
        package, = (FOLDER / "fresh").glob("lib/python*/site-packages/furrow")
        self.assertNotIn(str(ROOT / "mujoco").encode(), (package / "libfurrow.so.0").read_bytes())
        # The engine plugin finds the library beside itself, and says nothing where no MuJoCo loads it.
        told = self.output("fresh/bin/python", "-c", f"import ctypes; ctypes.CDLL({str(package / 'libfurrow_mujoco.so')!r}); print('loaded')")
        self.assertEqual(told, "loaded\n")
        # MuJoCo's own import calls it; here a module of its version stands for it. Of another version nothing is loaded.
        version = re.search(rb"libmujoco\.so\.([0-9.]+)", (package / "libfurrow.so.0").read_bytes())[1].decode()
        called = ("import importlib.metadata as m, sys, types; sys.modules['mujoco'] = types.SimpleNamespace(__version__=sys.argv[1]); "
                  "[e.load()() for e in m.entry_points(group='mujoco.plugins')]; print('libfurrow_mujoco.so' in open('/proc/self/maps').read())")
        self.assertEqual(self.output("fresh/bin/python", "-c", called, version), "True\n")
        self.assertEqual(self.output("fresh/bin/python", "-c", called, "3.3.0"), "False\n")


if __name__ == "__main__":
    unittest.main()
