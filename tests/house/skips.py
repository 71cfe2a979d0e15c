"""A test that skips says why, and the closing line of `sh tools/test.sh` fails for reasons that may not stand (tests/summary.py)."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

TESTS = pathlib.Path(os.environ["SOURCES"]).parent / "tests"


def bare(text):
    """Numbers of the lines of a C file that skip without a reason."""
    return [number for number, line in enumerate(text.splitlines(), 1) if re.search(r"(?<![\w\"])skip\(\)", line)]


class Skips(unittest.TestCase):
    def test_each_has_a_reason(self):
        self.assertEqual(bare('\tskip_since("no GL");\n\tskip();\n'), [2])
        wrong = [f"{path.relative_to(TESTS)}:{number}" for path in sorted(TESTS.rglob("*.[ch]")) if path.name != "skip.h"
                 for number in bare(path.read_text(encoding="utf-8"))]
        self.assertEqual(wrong, [], "say why: skip_since() of tests/support/skip.h")

    def summary(self, *tests, **environment):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as log:
            for number, (result, text) in enumerate(tests):
                log.write(json.dumps({"name": f"folder/{number}", "result": result, "stdout": text}) + "\n")
            log.flush()
            plain = {key: value for key, value in os.environ.items() if key != "FURROW_TESTS_MAY_SKIP"}
            done = subprocess.run([sys.executable, TESTS / "summary.py", log.name], capture_output=True, text=True, env=plain | environment)
        return done.returncode, done.stdout.splitlines()

    def test_the_closing_line_counts_them(self):
        code, lines = self.summary(("OK", "test_a ... skipped 'for sh tools/test.sh long'\ntest_b ... ok"), ("OK", "skipped 'not on this machine: no disk'"),
                                   ("FAIL", ""), ("OK", ""))
        self.assertEqual(code, 0)
        self.assertEqual(lines, ["folder/1: skipped, not on this machine: no disk",
                                 "3 passed, 1 failed, 0 skipped whole; in them 2 tests skipped: 1 wait for the long run, 1 need what this machine lacks, 0 should have run"])

    def test_what_packages_brings_may_not_be_missing(self):
        lacks = [("OK", 'test_a ... skipped "no numpy"'), ("SKIP", "no Xvfb\n"), ("SKIP", ""),
                 ("OK", "[  SKIPPED ] one\n[  SKIPPED ] 1 test(s), listed below:\n[  SKIPPED ] one\n"), ("OK", "skipped 'no GL'\n[  SKIPPED ] 1 test(s), listed below:")]
        for lack in lacks:
            with self.subTest(lack):
                self.assertEqual(self.summary(lack)[0], 1)
                self.assertEqual(self.summary(lack, FURROW_TESTS_MAY_SKIP="1")[0], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
