"""Tests assert what they say: no comparison of theirs is passed by a NaN, by a float's rounding, or by having nothing to compare."""
import os
import pathlib
import re
import unittest

SOURCES = pathlib.Path(os.environ.get("SOURCES", pathlib.Path(__file__).resolve().parents[2] / "src"))
TESTS = SOURCES.parent / "tests"
NEAR = "tests/support/near.h has assert_near, support_most and support_least"
FORBIDDEN = (  # what, in files that end so, and why
    (re.compile(r"\bassert_(?:float|double)_\w+"), (".c", ".h"), "cmocka compares floats, and a NaN passes; " + NEAR),
    (re.compile(r"(\S+) = fm(?:ax|in)f?\(\1, .*\bfabs\("), (".c", ".h"), "fmax drops a NaN; " + NEAR),
    (re.compile(r"\bif \((?:fabs|hypot)\([^;]*\) > [^;&|]*\)\n\t*fail"), (".c", ".h"), "a NaN passes; write if (!(error <= allowed))"),
    (re.compile(r"assert_(?:int|string)_equal\(([^,()]+), \1\)"), (".c", ".h"), "it compares a thing with itself"),
    (re.compile(r"assertEqual\(([\w.\[\]\"']+), \1\)"), (".py",), "it compares a thing with itself"),
    (re.compile(r"assertLess(?:Equal)?\(max\((?:abs|math\.\w+|map\(abs)[(,]"), (".py",), "max drops a NaN; tests/cli/furrow_test.py has largest"),
    (re.compile(r"assertTrue\(True|\bor True\b|\band False\b"), (".py",), "it cannot fail"),
    (re.compile(r"except(?: Exception)?:\n\s*pass\b"), (".py",), "it hides each failure"),
)
# Pictures' own ground, which tests make; and a second implementation, which is compared itself.
MADE = {"render/golden.c", "render/land.h", "render/picture_rig.h", "dem/cut.c"}


def found(text, suffix):
    """Returns (line, why) of all that is forbidden in such a file."""
    return [(text.count("\n", 0, match.start()) + 1, why) for pattern, suffixes, why in FORBIDDEN if suffix in suffixes for match in pattern.finditer(text)]


class Asserts(unittest.TestCase):
    def test_none_passes_for_a_nan_or_for_nothing(self):
        told, count = [], 0
        for path in sorted([*TESTS.rglob("*.c"), *TESTS.rglob("*.h"), *TESTS.rglob("*.py")]):
            name = path.relative_to(TESTS).as_posix()
            if name in MADE or name.startswith(("deform/reference/", "support/", "house/asserts")):
                continue
            count += 1
            told += [f"tests/{name}:{line}: {why}" for line, why in found(path.read_text(), path.suffix)]
        self.assertEqual(told, [])
        self.assertGreater(count, 300)

    def test_it_finds_each(self):
        for text, suffix in (("assert_float_equal(a, b, 1e-9);", ".c"), ("assert_double_not_equal(a, b, 0);", ".h"), ("worst = fmax(worst, fabs(a - b));", ".c"),
                             ("\tif (fabs(a - b) > 1e-9)\n\t\tfail_msg(\"no\");", ".c"), ("assert_int_equal(count, count);", ".c"), ("self.assertEqual(a.b, a.b)", ".py"),
                             ("self.assertTrue(a or True)", ".py"), ("self.assertLess(max(abs(a - b) for a, b in c), 1)", ".py"), ("    except Exception:\n        pass\n", ".py")):
            self.assertEqual(len(found(text, suffix)), 1, text)
        for text, suffix in (("assert_near(a, b, 1e-9);", ".c"), ("worst = support_most(worst, fabs(a - b));", ".c"), ("high = fmax(high, height);", ".c"),
                             ("\tif (!(fabs(a - b) <= 1e-9))\n\t\tfail_msg(\"no\");", ".c"), ("self.assertEqual(a.b, a.c)", ".py")):
            self.assertEqual(found(text, suffix), [], text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
