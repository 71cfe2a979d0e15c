"""The folders of src keep their order: who may include whom, and whose name an extern begins with.

The compiler holds the first as well, since each library sees only links to what it may include; this says which line is wrong.
"""
import os
import pathlib
import re
import subprocess
import unittest

SOURCES = pathlib.Path(os.environ["SOURCES"])      # src
LIBRARIES = pathlib.Path(os.environ["LIBRARIES"])  # where libfurrow_FOLDER.a are
# From below to above; folders of one line are siblings, and never include each other.
ORDER = [["base"], ["dem", "store", "page", "soil"], ["gpu", "intake"], ["deform", "chart"], ["resident"], ["bearing"], ["scene"], ["motion"], ["world"],
         ["vehicle", "render"], ["report", "exchange"], ["drive"], ["api", "fleet"], ["trials"]]
FOLDERS = [folder for row in ORDER for folder in row]
FREE = {"base"}  # its words are everybody's: status, tile, lattice, ...
WHOLE = {("deform", "soil"), ("bearing", "soil")}  # the first may include every header of the second
# Hosts' header, which includes nothing of ours. The folders from world on use its structs.
CONTRACT = ("api/furrow.h", "world")
OUTWARD = {"api": "furrow"}
HOSTS = {"trials"}  # they use furrow.h alone
# What leaves the shared library.
ALSO = {"api": ("furrow_",)}


def below(folder):
    if folder in HOSTS:
        return {"base", "api"}
    for i, row in enumerate(ORDER):
        if folder in row:
            return {name for under in ORDER[:i] for name in under}
    raise KeyError(folder)


def outward(folder):
    """The one header that the folders above it may include."""
    return "%s/%s.h" % (folder, OUTWARD.get(folder, folder))


def wrong_includes(folder, path, text):
    """Lines of a file of the folder that include what it may not."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        included = re.match(r'\s*#\s*include\s+"([^"]+)"', line)
        if not included:
            continue
        name = included.group(1)
        into = name.split("/")[0]
        inside = into in (folder, "base")
        seen = into in below(folder) and (name == outward(into) or (folder, into) in WHOLE)
        contract = name == CONTRACT[0] and CONTRACT[1] in below(folder) | {folder}
        if not inside and not seen and not contract and (into in FOLDERS or "/" in name):
            found.append("%s:%d: %s" % (path, number, line.strip()))
    return found


def wrong_externs(folder, names):
    begins = (folder + "_",) + ALSO.get(folder, ())
    return [name for name in names if folder not in FREE and not name.startswith(begins)]


def externs(folder):
    told = subprocess.run(["nm", "--defined-only", "-g", str(LIBRARIES / ("libfurrow_%s.a" % folder))],
                          capture_output=True, text=True, check=True).stdout
    # Sanitizers and coverage add their own.
    return [part[2] for part in map(str.split, told.splitlines()) if len(part) == 3 and part[1] in "TDBRC" and
            not part[2].startswith(("__", "_Z"))]


class Folders(unittest.TestCase):
    def test_all_are_known(self):
        there = {path.name for path in SOURCES.iterdir() if path.is_dir() and any(path.rglob("*.c"))}
        self.assertEqual(there, set(FOLDERS))

    def test_each_has_its_outward_header(self):
        for folder in FOLDERS:
            self.assertTrue((SOURCES / outward(folder)).is_file(), folder)

    def test_includes_go_down(self):
        for folder in FOLDERS:
            for path in sorted((SOURCES / folder).rglob("*.[ch]")):
                self.assertEqual(wrong_includes(folder, path, path.read_text(encoding="utf-8")), [])

    def test_externs_begin_with_their_folder(self):
        for folder in FOLDERS:
            names = externs(folder)
            self.assertGreater(len(names), 3, folder)
            self.assertEqual(wrong_externs(folder, names), [], folder)

    def test_what_is_wrong_is_seen(self):
        def include(folder, name):
            return len(wrong_includes(folder, "x.c", '#include "%s"\n' % name))
        self.assertEqual(include("store", "page/page.h"), 1)         # a sibling
        self.assertEqual(include("gpu", "deform/deform.h"), 1)       # above
        self.assertEqual(include("world", "deform/internal.h"), 1)   # inside another
        self.assertEqual(include("world", "deform/soil/model.h"), 1)
        self.assertEqual(include("world", "deform/deform.h"), 0)
        self.assertEqual(include("deform", "deform/soil/model.h"), 0)
        self.assertEqual(include("deform", "soil/shape/body.h"), 0)
        self.assertEqual(include("world", "soil/shape/body.h"), 1)
        self.assertEqual(include("soil", "deform/deform.h"), 1)
        self.assertEqual(include("store", "base/key_set.h"), 0)
        self.assertEqual(include("world", "api/furrow.h"), 0)
        self.assertEqual(include("vehicle", "api/furrow.h"), 0)
        self.assertEqual(include("motion", "api/furrow.h"), 1)       # below world
        self.assertEqual(include("world", "api/library.h"), 1)
        self.assertEqual(include("trials", "world/world.h"), 1)
        self.assertEqual(include("trials", "api/library.h"), 1)
        self.assertEqual(include("trials", "api/furrow.h"), 0)
        self.assertEqual(wrong_externs("store", ["codec_decode", "store_open"]), ["codec_decode"])
        self.assertEqual(wrong_externs("api", ["api_library_begin", "furrow_step", "host_steps"]), ["host_steps"])


if __name__ == "__main__":
    unittest.main()
