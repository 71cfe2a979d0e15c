"""The limits of a process, each a little too low: every command says which one, as the caller can raise it."""
import pathlib
import re
import resource
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, main

BALL = """scene: 1
time_step: 0.1
end_time: 0.3
spacing: 1
soil: {name: dry_sand}
redistribute: {model: scm}
output: {forces: 10}
objects:
  - {name: ball, shape: {sphere: {radius: 2}}, sink: 0.1, path: {points: [[20, 20], [40, 30]], speed: 5}}
"""


class Limits(FurrowTest):
    def limited(self, which, most, *arguments):
        def prepare():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(which, (most, most))
        return subprocess.run([FURROW, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              preexec_fn=prepare, timeout=280)

    def swept(self, which, limits, statuses, *arguments):
        """The messages of a command that is given more and more, until it succeeds. No run is ended by a signal."""
        told = set()
        for most in limits:
            with self.subTest(most=most):
                result = self.limited(which, most, *arguments)
                if result.returncode == 0:
                    self.assertTrue(told)
                    return told
                if result.returncode == 127 and "error while loading shared libraries" in result.stderr:
                    continue
                told.add(self.told_in(statuses, result))
        self.fail("it never succeeded")

    def told_in(self, statuses, result):
        self.assertIn(result.returncode, statuses, result.stderr)
        errors = [line for line in result.stderr.splitlines() if line.startswith("furrow: ") and "furrow: note: " not in line]
        self.assertEqual(len(errors), 1, result.stderr)
        self.assertRegex(errors[0], r"^furrow: .+: .+; .+")
        return errors[0]

    def test_too_few_open_files_are_told(self):
        store, scene = self.synth(posts="65x65"), self.scene(BALL)
        # Less than 3 are the standard streams alone; the loader needs one.
        for limits, arguments in ((range(4, 30), ("query", store, "10", "10")),
                                  ((6, 9, 12, 14, 17, 18, 40), ("drive", scene, "--store", store, "-o", "out"))):
            for line in self.swept(resource.RLIMIT_NOFILE, limits, (1, 4), *arguments):
                self.assertIn("Too many open files", line)
                if line.startswith(f"furrow: {store}: "):
                    self.assertTrue(line.endswith("; raise the limit on open files (ulimit -n)"), line)
        self.assertTrue(self.json("verify", store)["ok"])

    def test_a_commit_that_does_not_fit_leaves_no_ruts_and_is_told(self):
        store, scene = self.synth(posts="65x65"), self.scene(BALL)
        # More than the index of the WAL, and less than the WAL of the first commit with ruts.
        result = self.limited(resource.RLIMIT_FSIZE, 45000, "drive", scene, "--store", store, "-o", "out")
        self.assertIn("committing: disk I/O error: File too large; raise the limit on the size of files (ulimit -f)", self.told_in((1,), result))
        self.assertIn(f"; no ruts in {store} itself from this drive\n", result.stdout)
        self.assertTrue(self.json("verify", store)["ok"])
        self.assertEqual(self.json("info", store)["tiles"]["offset"], 0)

    def test_too_little_memory_is_told(self):
        store = self.synth(posts="65x65")
        limits = [quarter << 18 for quarter in (*range(128, 400, 1), 512, 1024, 4096)] # the command's own code takes most of it
        for line in self.swept(resource.RLIMIT_AS, limits, (1,), "verify", store):
            self.assertRegex(line, re.compile("memory", re.I))


if __name__ == "__main__":
    main()
