"""The examples, built with pkg-config in another folder against an installed Furrow, and run."""
import csv
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import prefix

EXAMPLES = prefix.ROOT / "examples"


def rows(text):
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]


class ExamplesTest(unittest.TestCase):
    def build(self, compiler, source, *flags, libraries=()):
        shutil.copy(EXAMPLES / source, prefix.work)
        program = prefix.work / source.rsplit(".", 1)[0]
        prefix.run(compiler, *flags, "-Wall", "-Wextra", "-Wpedantic", "-Werror", *prefix.compile_flags, source, "-o", program,
                   *prefix.package_config("--cflags", "--libs"), *libraries)
        return program

    def run_example(self, program, *arguments):
        result = prefix.run(program, *arguments, env=prefix.environment, check=False)
        if result.returncode == 4:
            self.skipTest("there is no GL")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def test_drop_ball(self):
        program = self.build("cc", "drop_ball.c", "-std=c99")
        text = self.run_example(program, prefix.synthesize("plain.furrow", "plain"), "drop_ball.furrow")
        fall = rows(text)
        self.assertEqual(len(fall), 21)
        self.assertAlmostEqual(fall[0]["above_ground_m"], 0.5, places=3)
        # It falls as bodies fall until it touches, then the soil carries its 196 N and it lies still, a little sunk.
        self.assertAlmostEqual(fall[4]["above_ground_m"], 0.5 - 9.81 * 0.2 ** 2 / 2, delta=0.01)
        self.assertLess(abs(fall[-1]["velocity_m_s"]), 0.02)
        self.assertTrue(-0.1 < fall[-1]["above_ground_m"] < -0.001, fall[-1])
        self.assertAlmostEqual(fall[-1]["force_N"], 196.2, delta=40)
        self.assertIn("# the ball left a hollow", text)

    def test_mujoco_ball(self):
        folder = os.environ.get("MUJOCO")
        if not folder:
            self.skipTest("MuJoCo is not here")
        library = next(library for library in sorted(pathlib.Path(folder).rglob("libmujoco.so.4.*")))
        program = self.build("cc", "mujoco_ball.c", "-std=c99", "-isystem", f"{folder}/include", libraries=[library, f"-Wl,-rpath,{library.parent}"])
        fall = rows(self.run_example(program, EXAMPLES / "mujoco_ball.xml", prefix.synthesize("plain.furrow", "plain"), "mujoco_ball.furrow"))
        self.assertEqual(len(fall), 12)
        self.assertAlmostEqual(fall[0]["above_ground_m"], 0.2, places=6)
        # It rolls on, the soil brakes it, and it lies still: its 20 kg are carried.
        self.assertTrue(30.2 < fall[-1]["x_m"] < 30.6, fall[-1])
        self.assertLess(abs(fall[-1]["velocity_x_m_s"]), 0.01)
        self.assertAlmostEqual(fall[-1]["force_N"], 20 * 9.81, delta=1)
        self.assertTrue(-0.05 < fall[-1]["above_ground_m"] < -0.005, fall[-1])

    def test_spring_wheel(self):
        program = self.build("c++", "spring_wheel.cpp", "-std=c++17")
        ride = rows(self.run_example(program, prefix.synthesize("dunes.furrow", "dunes"), "spring_wheel.furrow"))
        self.assertEqual(len(ride), 12)
        self.assertAlmostEqual(ride[-1]["x_m"], 16 + 3, places=3)
        later = ride[4:]
        # The soil carries wheel and carriage, 736 N, up and down the dunes.
        self.assertAlmostEqual(sum(row["soil_N"] for row in later) / len(later), 736, delta=150)
        self.assertTrue(all(0 < row["sinkage_m"] < 0.15 for row in later), later)

    def test_rut(self):
        shutil.copy(EXAMPLES / "rut.py", prefix.work)
        plots = prefix.python_with("numpy", "matplotlib") is not None
        picture = prefix.work / "rut.png"
        result = prefix.run_python("rut.py", prefix.synthesize("plain.furrow", "plain"), "rut.furrow", picture,
                                   modules=("numpy", "matplotlib") if plots else ("numpy",), check=False)
        if "no GL" in result.stderr or "OpenGL 4.5" in result.stderr:
            self.skipTest("there is no GL")
        self.assertEqual(result.returncode, 0, result.stderr)
        told = dict(line.split(": ", 1) for line in result.stdout.splitlines() if ": " in line)
        self.assertEqual(told["posts"], "33 x 97")
        self.assertTrue(0.01 < float(told["deepest"].split()[0]) < 0.06, told)
        self.assertGreater(float(told["highest heap"].split()[0]), 0)
        self.assertGreater(float(told["drawbar pull, mean of the last half"].split()[0]), 0)
        if plots:
            self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        else:
            self.assertIn("nothing is plotted", result.stdout)

    def test_plot_drive(self):
        if prefix.python_with("numpy", "matplotlib") is None:
            self.skipTest("there is no matplotlib")
        shutil.copy(EXAMPLES / "plot_drive.py", prefix.work)
        drive, picture = prefix.work / "drive", prefix.work / "drive.png"
        drive.mkdir()
        # A car goes 2 m/s for 10 s; its one wheel slips by 0.2, is 30 mm deep, and its motors give 4 kW.
        times = [i / 50 for i in range(501)]
        (drive / "vehicles.csv").write_text("t,name,x,y,z,roll,pitch,yaw,vx,vy,vz,kinetic,work\n" + "".join(
            f"{t},car,{2 * t},5,1,0,3,0,2,0,0,10,{4000 * t}\n" for t in times))
        (drive / "objects.csv").write_text("t,name,sinkage,slip\n" + "".join(f"{t},car.wheel,0.03,0.2\n" for t in times))
        told = prefix.run_python("plot_drive.py", drive, picture, modules=("numpy", "matplotlib")).stdout
        self.assertIn("car: 20.0 m in 10.0 s, 40.0 kJ", told)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        missing = prefix.run_python("plot_drive.py", drive, picture, "bus", modules=("numpy", "matplotlib"), check=False)
        self.assertNotEqual(missing.returncode, 0)
        self.assertIn("there is no vehicle bus; there are car", missing.stderr)

    def test_drawbar(self):
        shutil.copy(EXAMPLES / "drawbar.py", prefix.work)
        drive = prefix.work / "towed"
        drive.mkdir()
        (drive / "run.json").write_text('{"vehicles": {"car": {"mass": 100, "gravity": 10}}}')
        # A load car lets a car go 0.9 m/s, then 0.8 m/s; the pull grows, or falls.
        for last, rising in ((300, True), (100, False)):
            pulls, times = {-0.9: 200, -0.8: last}, [i / 50 for i in range(201)]
            control = {t: -0.9 if t < 2 else -0.8 for t in times}
            (drive / "vehicles.csv").write_text("t,name,x,y,z,u:tow,f:tow\n" + "".join(f"{t},car,{t},5,1,{control[t]},{pulls[control[t]]}\n" for t in times))
            (drive / "objects.csv").write_text("t,name,slip,fx,fy,fz\n" + "".join(f"{t},car.wheel,{1 + control[t]},{pulls[control[t]]},0,1000\n" for t in times))
            told = prefix.run("python3", "drawbar.py", drive).stdout
            self.assertEqual("still rising at the last step" in told, rising, told)
            self.assertIn(f"greatest pull {max(200, last)} N at slip 0.{2 if rising else 1}0", told)
        missing = prefix.run("python3", "-I", "-S", "drawbar.py", drive, "tow.svg", check=False)  # without any package
        self.assertEqual((missing.returncode, len(missing.stderr.splitlines())), (1, 1), missing.stderr)
        self.assertIn("there is no matplotlib", missing.stderr)

    def readme(self):
        """The command that makes the terrain, and the two programs."""
        section = (prefix.ROOT / "README.md").read_text(encoding="utf-8").split("## From C and Python")[1].split("\n## ")[0]
        sources = dict(re.findall(r"```(python|c)\n(.*?)```", section, re.DOTALL))
        return re.search(r"`(furrow synth [^`]*)`", section)[1].split(), sources["c"], sources["python"]

    def stranger(self, name, *arguments):
        """Somebody with the terrain in a folder of his own."""
        stranger = prefix.Stranger(name, *arguments)
        synth, *self.sources = self.readme()
        stranger.run(*synth)
        return stranger

    def private(self, stranger, name):
        """What a stranger's umask keeps to himself stays so."""
        self.assertEqual((stranger.folder / name).stat().st_mode & 0o077, 0, name)

    def test_the_readme_s_program_in_c_by_a_stranger_without_a_home(self):
        stranger = self.stranger("stränger", "de_DE.UTF-8")
        source = prefix.work / "readme.c"
        source.write_text(self.sources[0])
        stranger.run("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", *prefix.compile_flags, source, "-o", "readme", *prefix.package_config("--cflags", "--libs"))
        result = stranger.run("./readme", check=False)
        if result.returncode == 4:
            self.skipTest("there is no GL")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertAlmostEqual(float(re.match(r"offset: (\S+) m", result.stdout).group(1)), -0.05, delta=0.01)
        self.private(stranger, "wheel.furrow")

    def test_the_readme_s_program_in_python_by_a_stranger_who_cannot_write_his_home(self):
        stranger = self.stranger("another", "C", "/")
        python = prefix.python_with("numpy")
        self.assertIsNotNone(python, "no python3 has numpy; run tools/packages.sh")
        result = stranger.run(python, "-c", self.sources[1], check=False, **prefix.loaded)
        if "no GL" in result.stderr or "OpenGL 4.5" in result.stderr:
            self.skipTest("there is no GL")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        force, offset = map(float, re.match(r"force: (\S+) N; offset: (\S+) m", result.stdout).groups())
        self.assertGreater(force, 0)
        self.assertAlmostEqual(offset, -0.05, delta=0.002)
        self.private(stranger, "ball.furrow")

    def test_the_program_of_the_manual_page(self):
        page = (prefix.prefix / "share" / "man" / "man3" / "furrow.3").read_text(encoding="utf-8")
        source = prefix.work / "manual.c"
        source.write_text(re.search(r"\.Bd -literal\n(#include.*?)\.Ed", page, re.DOTALL).group(1).replace("\\e", "\\"))
        prefix.synthesize("plain.furrow", "plain")
        program = prefix.work / "manual"
        prefix.run("cc", "-std=c99", "-Wall", "-Wpedantic", "-Werror", *prefix.compile_flags, source, "-o", program,
                   *prefix.package_config("--cflags", "--libs"))
        self.assertGreater(float(re.fullmatch(r"(\S+) N\n", self.run_example(program)).group(1)), 1)

    def test_what_is_wrong_is_said(self):
        program = self.build("cc", "drop_ball.c", "-std=c99")
        result = prefix.run(program, "missing.furrow", "none.furrow", env=prefix.environment, check=False)
        self.assertEqual(result.returncode, 3)
        self.assertIn("drop_ball: ", result.stderr)
        self.assertIn("missing.furrow", result.stderr)


if __name__ == "__main__":
    unittest.main()
