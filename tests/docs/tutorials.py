"""The tutorials do what they say: every file that a page tells to save is saved, every command is run, and its output is compared.

A page's blocks, in order:
- after "Save this as `NAME`:", a block of any language is the file NAME;
- in a `console` block, a line that begins with "$ " is a command (with a backslash at its end it goes on), and what follows is its output. "..." stands
  for any text, on a line of its own for any lines.

`tutorials.py --show PAGE` prints what the commands print here, for writing a page.
"""
import csv
import importlib.util
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "cli"))
from furrow_test import chosen_tests  # noqa: E402

PAGES = ROOT / "docs" / "tutorials"
FURROW = pathlib.Path(os.environ["FURROW"])
BUILD = os.environ.get("FURROW_BUILD")
# What a command tells of its progress where it is slow; no page has it.
PROGRESS = re.compile(r"^furrow: note: .* s left\n", re.MULTILINE)
# What a page needs besides the command: a program, or what a build may lack, as the message says that it does.
LACKS = ("mujoco/mujoco.h: No such file", "this build has no MuJoCo", "built without GDAL", "this build has no MPI", "no GL")


def blocks(text):
    """(language, the file that it is to be saved as or None, lines, number of the first line) of each block."""
    found, language, before = [], None, ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            if language is None:
                language, lines, first = line[3:].strip(), [], number + 1
                named = re.search(r"Save (?:this|it) as `([^`]+)`:$", before)
            else:
                found.append((language, named.group(1) if named else None, lines, first))
                language, before = None, ""
        elif language is not None:
            lines.append(line)
        elif line.strip():
            before = line.strip()
    return found


def commands(lines, first):
    """(command, lines of its output, number of its line) of a console block."""
    found = []
    for number, line in enumerate(lines, first):
        if line.startswith("$ "):
            found.append([line[2:], [], number])
        elif found and found[-1][0].endswith("\\"):
            found[-1][0] = found[-1][0][:-1] + line.strip()
        elif found:
            found[-1][1].append(line)
        else:
            raise ValueError(f"line {number}: output before a command")
    return found


def pattern(lines):
    """A regular expression of the output; "..." is any text, on a line of its own any lines."""
    parts = []
    for line in lines:
        parts.append(r"(?:.*\n)*?" if line.strip() == "..." else ".*".join(map(re.escape, line.rstrip().split("..."))) + r"[ \t]*\n")
    return re.compile("".join(parts) + r"\Z")


class Runner:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        for name in ("tools/scenes", "examples"):
            shutil.copytree(ROOT / name, self.folder / name, ignore=shutil.ignore_patterns("*.furrow*"))
        self.environment = dict(os.environ, PATH=f"{FURROW.parent}{os.pathsep}{os.environ['PATH']}", LC_ALL="C.UTF-8", COLUMNS="100",
                                OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1")

    def install(self):
        """What the page on embedding begins with: an installation of this build."""
        sys.path.insert(0, str(ROOT / "tests" / "install"))
        import prefix
        description = next(prefix.libdir.rglob("furrow.pc"))
        description.write_text(re.sub("^prefix=.*", f"prefix={prefix.prefix}", description.read_text(), flags=re.M))
        self.environment.update({name: prefix.environment[name] for name in ("LD_LIBRARY_PATH", "PYTHONPATH", "PKG_CONFIG_PATH", "PATH")})
        if os.environ.get("MUJOCO"):
            (self.folder / "mujoco-4.0.0").symlink_to(os.environ["MUJOCO"])
        python = prefix.python_with("numpy")
        if python is not None:
            (self.folder / "bin").mkdir()
            (self.folder / "bin/python3").symlink_to(python)
            self.environment["PATH"] = f"{self.folder / 'bin'}{os.pathsep}{self.environment['PATH']}"

    def run(self, command):
        result = subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True, timeout=280)
        return result.returncode, PROGRESS.sub("", result.stdout)


@chosen_tests(6)  # of fourteen
class Tutorials(unittest.TestCase):
    maxDiff = None

    def page(self, name, needs=(), installed=False):
        for program in needs:
            if shutil.which(program) is None:
                self.skipTest(f"{program} is not here")
        folder = tempfile.mkdtemp(prefix="furrow-tutorial-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        runner = Runner(folder)
        if installed:
            runner.install()
        ran = 0
        for language, saved, lines, first in blocks((PAGES / name).read_text(encoding="utf-8")):
            if saved is not None:
                (runner.folder / saved).parent.mkdir(parents=True, exist_ok=True)
                (runner.folder / saved).write_text("\n".join(lines) + "\n", encoding="utf-8")
            if language != "console":
                continue
            for command, wanted, number in commands(lines, first):
                code, output = runner.run(command)
                if any(lack in output for lack in LACKS):
                    self.skipTest(output.strip().splitlines()[-1])
                ran += 1
                where = f"{name}:{number}: {command}"
                self.assertEqual(code, 0, f"{where}\n{output}")
                if wanted and not pattern(wanted).match(output):
                    self.fail(f"{where}\nthe page has\n" + "\n".join(wanted) + f"\nand it printed\n{output}")
        self.assertGreater(ran, 0)
        return runner

    def test_each_page_has_a_test(self):
        tested = re.findall(r'self\.page\("([^"]+)"', pathlib.Path(__file__).read_text(encoding="utf-8"))
        self.assertEqual(sorted(tested), sorted(["../RIG.md", "../SOIL-TESTS.md", *(path.name for path in PAGES.glob("*.md"))]))

    def test_first_drive(self):
        self.page("first-drive.md")

    def test_your_own_dem(self):
        self.page("your-own-dem.md", needs=["gdal_translate"])

    def test_a_vehicle_on_a_slope(self):
        folder = self.page("vehicle-on-a-slope.md").folder
        for name, lines in (("tow", 8), ("uphill", 4)):
            self.assert_pull_is_that_of_the_wheels(folder / name, lines)

    def assert_pull_is_that_of_the_wheels(self, folder, lines):
        """A tow test in steady state: the load car's force is the sum of the soil's along the way, less the weight's part. In each hold of the
        controls, means over its last second; a second time, without drawbar.py."""
        def rows(name):
            with open(folder / name, newline="") as file:
                return list(csv.DictReader(file))
        vehicle, wheels = rows("vehicles.csv"), rows("objects.csv")
        ends = [3.5 + 3 * i for i in range(lines)]
        pulls, offs = [], []
        for end in ends:
            during = [row for row in vehicle if end - 1 <= float(row["t"]) <= end]
            rise = math.atan2(float(during[-1]["z"]) - float(during[0]["z"]), float(during[-1]["x"]) - float(during[0]["x"]))
            soil = sum(float(row["fx"]) * math.cos(rise) + float(row["fz"]) * math.sin(rise) for row in wheels if end - 1 <= float(row["t"]) <= end) / len(during)
            pulls.append(sum(float(row["f:tow"]) for row in during) / len(during))
            offs.append(soil - 2000 * 9.81 * math.sin(rise) - pulls[-1])
        self.assertEqual(pulls, sorted(pulls))
        self.assertTrue(all(abs(off) < 0.01 * 5460 for off in offs), offs)

    def test_ten_passes(self):
        folder = self.page("many-passes.md").folder
        with open(folder / "passes.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["drive"], row["pass"]) for row in rows], [(drive, str(i)) for drive in ("clay", "loam") for i in range(1, 11)])
        clay = [float(row["depth"]) for row in rows[:10]]
        self.assertEqual(clay, sorted(clay))
        self.assertAlmostEqual(clay[-1] / clay[0], 10 ** (1 / 3), delta=0.2)

    def test_a_rover_on_mars(self):
        self.page("rover-on-mars.md", needs=["gdal_translate"])

    def test_digging(self):
        folder = self.page("digging.md").folder
        for out, most, least in (("dig", 28.2e-3, 0.8), ("scoop", 0.54e-3, 0.8)):
            with open(folder / out / "vehicles.csv", newline="") as file:
                carried = [float(row["carried"]) for row in csv.DictReader(file)]
            lifted = max(volume for volume, later in zip(carried, carried[15:]) if volume > 0 and abs(volume - later) < 0.01 * volume)
            self.assertTrue(least * most < lifted < 1.5 * most, (out, lifted))
            self.assertEqual(carried[-1], 0)

    def test_soil_from_your_own_tests(self):
        self.page("../SOIL-TESTS.md")

    def test_single_wheel_test(self):
        self.page("../RIG.md")

    def test_many_runs(self):
        self.page("many-runs.md")

    def test_embedding(self):
        if os.environ.get("SANITIZE", "none") != "none":
            self.skipTest("programs outside of the build are not sanitized")
        self.page("embedding.md", needs=["cc", "pkg-config"], installed=True)

    def test_a_rover_that_learns(self):
        if importlib.util.find_spec("gymnasium") is None:
            self.skipTest("not on this machine: the Python package gymnasium is not installed")
        self.page("learning.md", installed=True)

    def test_on_a_cluster(self):
        self.page("on-a-cluster.md", needs=["mpirun"])

    def test_how_far_to_believe_it(self):
        self.page("how-far-to-believe-it.md")

    # --- the test itself ---

    def test_what_differs_is_seen(self):
        self.assertTrue(pattern(["a ... b", "...", "end"]).match("a 12 b\nx\ny\nend\n"))
        self.assertTrue(pattern(["...", "end"]).match("end\n"))
        for text in ("a 12 c\nend\n", "a 12 b\nend", "a 12 b\nend\nmore\n", "more\na 12 b\nend\n"):
            self.assertFalse(pattern(["a ... b", "...", "end"]).match(text))
        page = "Save this as `x.yaml`:\n\n```yaml\na: 1\n```\n\nNow run it:\n\n```console\n$ one \\\n  two\nout\n$ three\n```\n"
        (yaml, console) = blocks(page)
        self.assertEqual((yaml[1], yaml[2]), ("x.yaml", ["a: 1"]))
        self.assertEqual([(c, o) for c, o, _ in commands(console[2], console[3])], [("one two", ["out"]), ("three", [])])


def show(name):
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(folder)
        if name.startswith("embedding"):
            runner.install()
        for language, saved, lines, first in blocks((PAGES / name).read_text(encoding="utf-8")):
            if saved is not None:
                (runner.folder / saved).write_text("\n".join(lines) + "\n", encoding="utf-8")
            if language == "console":
                for command, _, _ in commands(lines, first):
                    code, output = runner.run(command)
                    print(f"$ {command}\n{output}" + (f"[exit status {code}]\n" if code else ""), end="")
        if len(sys.argv) > 3:
            shutil.copytree(folder, sys.argv[3], dirs_exist_ok=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--show"]:
        show(sys.argv[2])
    else:
        unittest.main(verbosity=2)
