"""debian/ says what the build says: the version, the libraries that it needs, the name of the shared library."""
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(os.environ["SOURCES"]).parent
CONTROL = (ROOT / "debian" / "control").read_text(encoding="utf-8")
MESON = (ROOT / "meson.build").read_text(encoding="utf-8")
# What tests and benches alone need.
TESTS = {"libcmocka-dev", "liblmdb-dev"}


def needed():
    return re.search(r"^Build-Depends:(.*?)^\S", CONTROL, re.M | re.S).group(1)


def libraries(text):
    return set(re.findall(r"\blib[a-z0-9+.-]+-dev\b", text))


class Debian(unittest.TestCase):
    def test_the_version_is_mesons(self):
        self.assertFalse((ROOT / "debian" / "changelog").exists(), "meson dist writes it")
        version, date = (re.search(pattern, MESON, re.M).group(1) for pattern in (r"^  version: '([^']+)'", r"^furrow_date = '([^']+)'"))
        made = subprocess.run([sys.executable, ROOT / "tools" / "debian_changelog.py", version, date], capture_output=True, text=True, check=True).stdout
        self.assertTrue(made.startswith(f"furrow ({version}) "), made)
        month, day, year = date.replace(",", "").split()
        self.assertRegex(made, rf"\n -- .+ <.+>  \w{{3}}, {int(day):02d} {month[:3]} {year} \d\d:\d\d:\d\d \+0000\n$")

    def test_it_needs_the_libraries_that_the_build_needs(self):
        packages = libraries((ROOT / "tools" / "packages.sh").read_text(encoding="utf-8")) - TESTS
        self.assertGreater(len(packages), 12)
        self.assertEqual(libraries(needed()), packages)

    def test_lines_of_descriptions_are_short(self):
        lines = [line for text in re.findall(r"^Description: .*\n((?: .*\n)+)", CONTROL, re.M) for line in text.splitlines()]
        self.assertGreater(len(lines), 20)
        self.assertEqual([line for line in lines if len(line) > 80], [])

    def test_the_library_package_has_the_number_of_the_library(self):
        number = re.search(r"soversion: '(\d+)'", (ROOT / "src" / "meson.build").read_text(encoding="utf-8")).group(1)
        self.assertEqual(re.findall(r"^Package: (.*)$", CONTROL, re.M), ["furrow", f"libfurrow{number}", "libfurrow-dev", "python3-furrow"])
        for name in ("furrow", f"libfurrow{number}", "libfurrow-dev", "python3-furrow"):
            self.assertTrue((ROOT / "debian" / f"{name}.install").is_file(), name)


if __name__ == "__main__":
    unittest.main()
