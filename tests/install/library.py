"""The installed library: what leaves it, its name, its header, pkg-config, man page, and programs that link it."""
import re
import subprocess
import unittest

import prefix


def declared(header):
    return set(re.findall(r"^FURROW_API [\w ]+?[ *]+(furrow_\w+)\(", (prefix.prefix / "include" / header).read_text(), re.M))


PLAIN = declared("furrow.h")  # furrow(3) has these
DECLARED = PLAIN | declared("furrow_mujoco.h")

PROGRAM = """#include <furrow.h>
#include <stdio.h>
int main(void)
{
	struct furrow_world *world;
	struct furrow_open open = {sizeof open, "{", NULL, NULL, NULL, NULL, false, false};
	printf("%s\\n", furrow_version());
	return furrow_world_open(&open, &world) == FURROW_INPUT && furrow_last_error()[0] != '\\0' ? 0 : 1;
}
/* A host may use the library's inner names for its own ends. */
void fail_with(void) {}
void note(void) {}
void mem_alloc(void) {}
void page_cache_pin(void) {}
"""


def symbols(*arguments):
    return [line.split()[-1] for line in prefix.run("nm", *arguments).stdout.splitlines() if len(line.split()) == 3]


class LibraryTest(unittest.TestCase):
    def setUp(self):
        self.shared, self.static = prefix.libdir / "libfurrow.so.0", prefix.libdir / "libfurrow.a"

    def test_only_declared_functions_leave_it(self):
        self.assertGreater(len(DECLARED), 20)
        leaving = symbols("-D", "--defined-only", self.shared)
        if prefix.SANITIZE == "none":
            self.assertEqual(sorted(leaving), sorted(DECLARED))
        else:
            self.assertTrue(DECLARED <= set(leaving))

    def test_the_static_one_shows_no_more(self):
        if prefix.SANITIZE == "none":
            self.assertEqual(sorted(symbols("-g", "--defined-only", self.static)), sorted(DECLARED))

    def test_soname_and_links(self):
        self.assertIn("Library soname: [libfurrow.so.0]", prefix.run("readelf", "-d", self.shared).stdout)
        self.assertEqual((prefix.libdir / "libfurrow.so").resolve(), self.shared.resolve())
        self.assertTrue(self.shared.is_symlink())

    def test_nothing_is_undefined(self):
        if prefix.SANITIZE == "none":
            result = subprocess.run(["ldd", "-r", self.shared], capture_output=True, text=True, check=True)
            self.assertNotIn("undefined", result.stdout + result.stderr)

    def test_pkg_config(self):
        self.assertEqual(prefix.package_config("--modversion"), prefix.run("furrow", "--version", env=prefix.environment).stdout.split()[1:2])
        self.assertEqual(prefix.package_config("--libs"), [f"-L{prefix.libdir}", "-lfurrow"])
        self.assertEqual(prefix.package_config("--cflags"), [f"-I{prefix.prefix / 'include'}"])
        self.assertIn("-lsqlite3", prefix.package_config("--static", "--libs"))

    def build(self, name, *libraries):
        source = prefix.work / "host.c"
        source.write_text(PROGRAM)
        prefix.run("cc", "-Wall", "-Werror", *prefix.compile_flags, source, "-o", prefix.work / name,
                   *prefix.package_config("--cflags"), *libraries)
        return prefix.run(prefix.work / name, env=prefix.environment).stdout.strip()

    def test_a_program_that_links_it(self):
        self.assertEqual(self.build("host", *prefix.package_config("--libs")), prefix.package_config("--modversion")[0])

    def test_a_program_that_links_the_static_one(self):
        rest = [flag for flag in prefix.package_config("--static", "--libs") if flag != "-lfurrow"]
        self.build("host_static", self.static, *rest)
        needed = prefix.run("readelf", "-d", prefix.work / "host_static").stdout
        self.assertNotIn("libfurrow", needed)

    def test_the_man_page(self):
        page = prefix.prefix / "share" / "man" / "man3" / "furrow.3"
        result = prefix.run("groff", "-mandoc", "-ww", "-Tutf8", "-P-c", page)
        self.assertEqual(result.stderr, "")
        text = re.sub(".\b", "", result.stdout)
        for name in PLAIN:
            self.assertIn(name, text)

    def test_the_command_is_there(self):
        self.assertTrue((prefix.prefix / "bin" / "furrow").exists())


if __name__ == "__main__":
    unittest.main()
