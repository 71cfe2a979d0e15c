"""What the tests of the command share: runs build/tools/furrow in a folder of its own."""
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

FURROW = os.environ["FURROW"]
MAPS = os.environ.get("FURROW_MAPS", "1") == "1"  # this build draws them
FULL = "FURROW_LONG" in os.environ  # in `sh tools/test.sh long`
SHARED = pathlib.Path(os.environ.get("SHARED", "/nonexistent"))

SCENE = """scene: 1
time_step: 0.05
end_time: 4
spacing: 0.25
redistribute: {model: box}
attributes: [dirt]
objects:
  - {name: left, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.15,
     path: {points: [[20, 20], [120, 90], [40, 130]], speed: 30}}
  - {name: right, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.15,
     path: {points: [[22, 18], [122, 88], [42, 128]], speed: 30}}
cache: {slots: 16}
"""


def write_png16(path, width, height, value):
    """A 16-bit grey PNG; value(x, y) with y from the top."""
    rows = b"".join(b"\0" + b"".join(struct.pack(">H", value(x, y)) for x in range(width)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def has_gdal():
    return shutil.which("gdal_translate") is not None


BUILT = pathlib.Path(FURROW).parents[1] / "python"  # the Python package of this build
LIBRARY = os.environ.get("FURROW_LIBRARY", str(BUILT.parent / "src/libfurrow.so.0"))


def use_package():
    """Lets a test import the Python package of this build; without one the test skips."""
    if not (BUILT / "furrow/_declarations.py").exists():
        raise unittest.SkipTest("the Python package is not built")
    sys.path.insert(0, str(BUILT))
    os.environ["FURROW_LIBRARY"] = LIBRARY


def need_vehicles():
    """Skips a test where this build has no vehicles."""
    if "vehicles: MuJoCo" not in subprocess.run([FURROW, "--version"], capture_output=True, text=True).stdout:
        raise unittest.SkipTest("this build has no MuJoCo")


def long(test):
    """Of a test or a class of them that costs much for what it finds: `sh tools/test.sh long` runs it."""
    return unittest.skipUnless(FULL, "for sh tools/test.sh long")(test)


def chosen(count, of):
    """Returns the places of `count` cases out of `of`, by the hash of the commit, so that all come up over some commits; in
    `sh tools/test.sh long` all. FURROW_COMMIT has the hash's first eight digits; without it the first are taken."""
    first = int(os.environ.get("FURROW_COMMIT") or "0", 16)
    return list(range(of)) if FULL else sorted((first + i) % of for i in range(min(count, of)))


def chosen_tests(count):
    """Of a class whose tests are many cases of one thing, such as kills and ranks: a run takes `count` of them, as chosen() says."""
    def mark(cls):
        names = sorted(name for name in vars(cls) if name.startswith("test_"))
        run = {names[place] for place in chosen(count, len(names))}
        for name in names:
            if name not in run:
                setattr(cls, name, long(getattr(cls, name)))
        return cls
    return mark


def part(cases, *kept):
    """Returns the cases at the places `kept`; in `sh tools/test.sh long` all of them."""
    cases = list(cases)
    return cases if FULL else [cases[i] for i in kept]


def sampled(cases):
    """Returns the cases; with sanitizers (cli/sanitized) every eighth, but in `sh tools/test.sh long` all of them."""
    cases, every = list(cases), int(os.environ.get("FURROW_EVERY", "1"))
    return cases[min(every, len(cases)) // 2::every]  # from the middle, since the first case is often the plainest


def largest(values):
    """Returns the largest value; NaN if one is NaN, which max() drops. No values are an error."""
    values = list(values)
    return math.nan if any(math.isnan(value) for value in values) else max(values)


class FurrowTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="furrow-cli-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def furrow(self, *arguments, stdin=None, env=None, cwd=None):
        environment = dict(os.environ, **(env or {}))
        return subprocess.run([FURROW, *map(str, arguments)], input=stdin, env=environment, cwd=cwd or self.folder,
                              capture_output=True, text=True, timeout=280)

    def python(self, script, needs=()):
        """What a script prints that has the package of this build. Skips where the interpreter lacks a package that it needs."""
        python = os.environ.get("FURROW_PYTHON") or sys.executable
        build = pathlib.Path(FURROW).resolve().parents[1]
        env = dict(os.environ, PYTHONPATH=str(build / "python"), FURROW_LIBRARY=str(build / "src/libfurrow.so.0"))
        for module in ("numpy", *needs):
            if subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode != 0:
                self.skipTest(f"not on this machine: {module} for {python}")
        result = subprocess.run([python, "-c", script], cwd=self.folder, env=env, capture_output=True, text=True, timeout=280)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def ok(self, *arguments, **options):
        result = self.furrow(*arguments, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def json(self, *arguments, **options):
        return json.loads(self.ok(*arguments, "--json", **options))

    def refused(self, status, *arguments, **options):
        """Exit `status` and one line: `furrow: WHAT: WHY; WHAT TO DO`."""
        return self.told(status, self.furrow(*arguments, **options))

    def told(self, status, result):
        self.assertEqual(result.returncode, status, result.stderr + result.stdout)
        errors = [line for line in result.stderr.splitlines() if not line.startswith("furrow: note: ")]
        self.assertEqual(len(errors), 1, result.stderr)
        self.assertRegex(errors[0], r"^furrow: .+: .+; .+")
        return errors[0]

    def synth(self, name="world.furrow", posts="257x257", spacing=1, kind="ridged", relief=40):
        self.ok("synth", "-o", name, "--posts", posts, "--spacing", spacing, "--kind", kind, "--relief", relief,
                "--overwrite")
        return self.folder / name

    def scene(self, text=SCENE, name="scene.yaml"):
        path = self.folder / name
        path.write_text(text)
        return path

    def drive(self, *arguments, **options):
        """run.json of a drive; skips where there is no GL."""
        result = self.furrow("drive", *arguments, "-o", "out", "--json", **options)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def until_committed(self, process, out="out", commits=1):
        """Waits until a drive into the folder `out` has committed so often, or has ended: however long that takes. Skips where there is no GL."""
        log = self.folder / out / "epochs.log"
        while process.poll() is None and not (log.exists() and log.read_text().count("\n") >= commits):
            time.sleep(0.01)
        if process.poll() == 4:
            self.skipTest("no GL here: " + (process.communicate()[1] or ""))


def main():
    unittest.main(verbosity=2, argv=[sys.argv[0], *sys.argv[1:]])
