"""The installed header by itself, as a host includes it: valid C99 and C++17, strict, and alone."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADER = ROOT / "src" / "api" / "furrow.h"
STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]

# Each struct and the enumerators are used, so that a broken declaration is seen, too.
PROGRAM = """#include <furrow.h>
#include <furrow.h>
int main(void)
{
	struct furrow_open open;
	struct furrow_info info;
	struct furrow_camera camera;
	struct furrow_contact contact;
	struct furrow_state state;
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rect;
	furrow_body body = 0;
	furrow_status status = FURROW_INTERRUPTED;
	enum furrow_layer layer = FURROW_DISTURBANCE;
	enum furrow_contact_state last = FURROW_UNKNOWN;
	double at[1][2] = {{1, 2}}, ray[2][3] = {{1, 2, 3}, {0, 0, -1}}; /* a host's own arrays, not const */
	if (furrow_points(0, 1, at[0], &point) != FURROW_OK || furrow_points(0, 1, &at[0][0], &point) != FURROW_OK ||
	    furrow_rays(0, 1, ray[0], ray[1], &hit) != FURROW_OK)
		body = 1;
	open.size = sizeof open + sizeof contact + sizeof state + sizeof point + sizeof hit + sizeof rect;
	info.size = sizeof info;
	camera.size = sizeof camera;
	return (int)(open.size + info.size + camera.size) + (int)body + (int)status + (int)layer + (int)last;
}
"""


def compilers(variable, names):
    """The one that the build uses, and the usual others that are there."""
    chosen = [shlex.split(os.environ[variable])] if os.environ.get(variable) else []
    return chosen + [[name] for name in names if shutil.which(name)]


class HeaderTest(unittest.TestCase):
    def compile(self, command, standard, suffix, text=PROGRAM):
        with tempfile.TemporaryDirectory(prefix="furrow-header-") as folder:
            shutil.copy(HEADER, folder)
            source = pathlib.Path(folder) / ("host" + suffix)
            source.write_text(text)
            return subprocess.run([*command, f"-std={standard}", *STRICT, f"-I{folder}", str(source)],
                                  capture_output=True, text=True)

    def test_c99_and_c11(self):
        found = compilers("CC", ["gcc", "clang"])
        self.assertTrue(found)
        for command in found:
            for standard in ("c99", "c11"):
                result = self.compile(command, standard, ".c")
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_cpp17(self):
        found = compilers("CXX", ["g++", "clang++"])
        self.assertTrue(found, "there is no C++ compiler; install g++")
        for command in found:
            result = self.compile(command, "c++17", ".cpp")
            self.assertEqual(result.returncode, 0, result.stderr)

    def test_the_compilers_are_strict(self):
        found = compilers("CC", ["gcc", "clang"])
        self.assertTrue(found)
        for command in found:
            self.assertNotEqual(self.compile(command, "c99", ".c", "enum { A, };\nint a[0];\n").returncode, 0)

    def test_needs_only_the_three_standard_headers(self):
        includes = re.findall(r"#\s*include\s*(\S+)", HEADER.read_text())
        self.assertEqual(sorted(includes), ["<stdbool.h>", "<stddef.h>", "<stdint.h>"])

    def test_every_function_is_exported_and_documented(self):
        text = HEADER.read_text()
        names = re.findall(r"^(?:FURROW_API )?[\w ]+?[ *](furrow_\w+)\(", text, re.M)
        exported = re.findall(r"^FURROW_API [\w ]+?[ *]+(furrow_\w+)\(", text, re.M)
        self.assertEqual(sorted(names), sorted(exported))
        self.assertGreaterEqual(len(exported), 26)
        undocumented = [name for name in exported
                        if not re.search(r"\*/\nFURROW_API [^;/]*\b" + name + r"\(", text)]
        self.assertEqual(undocumented, [])


if __name__ == "__main__":
    unittest.main()
