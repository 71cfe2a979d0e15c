"""A world is opaque: only its own folder knows what it holds, and its header stays one that a person reads in one sitting.

The compiler holds the first as long as no file outside includes the definition; this says which line does, or names a member.
"""
import os
import pathlib
import re
import unittest

SOURCES = pathlib.Path(os.environ.get("SOURCES", pathlib.Path(__file__).resolve().parents[2] / "src"))
ROOT = SOURCES.parent
INSIDE = ("src/world/", "tests/world/")
PRIVATE = {"world/model.h", "world/internal.h"}
SEAM = "world/made.h"  # for tests and benches alone
MOST_LINES = 250


def members(text):
    """Names of the members of struct world, as model.h defines it; those of structs in it are left out."""
    body = re.sub(r"/\*.*?\*/", "", text[text.index("\nstruct world {") + len("\nstruct world {"):], flags=re.S)
    depth, outer = 1, ""
    for c in body:
        depth += (c == "{") - (c == "}")
        if depth == 0:
            break
        outer += c if depth == 1 and c != "}" else ""
    names = set()
    for part in outer.split(";"):
        names.update(re.findall(r"(\w+)(?:\[\w*\])*\s*(?:,|$)", part.strip()))
    return names


def wrong_includes(path, text):
    """Lines of a file that include what only the folder of the world may, or what only tests and benches may."""
    inside = path.startswith(INSIDE)
    program = path.startswith(("src/", "tools/")) and not inside
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        included = re.match(r'\s*#\s*include\s+"(?:[^"]*/)?(world/[^"/]+)"', line)
        name = included.group(1) if included else ""
        if (name in PRIVATE and not inside) or (name == SEAM and program):
            found.append("%s:%d: %s" % (path, number, line.strip()))
    return found


def wrong_members(path, text, names):
    """Places of a file that reach into a world: through a pointer that their function declares, or through a member `world` of another struct."""
    if path.startswith(INSIDE) or not re.search(r"\bstruct world\b|\bworld\s*->", text):
        return []
    text = re.sub(r"/\*.*?\*/|//[^\n]*", lambda comment: re.sub(r"[^\n]", " ", comment.group()), text, flags=re.S)
    found = set()
    start = 0
    for end in [match.end() for match in re.finditer(r"^}", text, re.M)] + [len(text)]:
        function = text[start:end]
        worlds = set(re.findall(r"\bstruct world \*(?:const )?(\w+)", function)) - set(re.findall(r"\bstruct (?!world\b)\w+ \*(?:const )?(\w+)", function))
        for match in re.finditer(r"\b(\w+)\s*->\s*(?=(\w+))", function):
            name, member = match.groups()
            of_another = function[:match.start()].endswith(("->", "."))
            if member in names and (name == "world" if of_another else name in worlds):
                found.add((text.count("\n", 0, start + match.start()) + 1, name + "->" + member))
        for match in re.finditer(r"\bstruct world (?:\w+\s*[;=,\[]|{)|\bsizeof\s*\(\s*struct world\s*\)", function):
            found.add((text.count("\n", 0, start + match.start()) + 1, match.group().strip()))
        start = end
    return ["%s:%d: %s" % (path, number, what) for number, what in sorted(found)]


class World(unittest.TestCase):
    def setUp(self):
        self.members = members((SOURCES / "world/model.h").read_text(encoding="utf-8"))

    def files(self):
        for folder in ("src", "tools", "tests", "bench"):
            for path in sorted((ROOT / folder).rglob("*.[ch]")):
                yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")

    def test_its_members_are_read(self):
        self.assertLessEqual({"scene", "resident", "bodies", "facts", "phase"}, self.members)
        self.assertFalse({"store", "struct", "meta"} & self.members)  # of structs in it, and words that are no name

    def test_only_its_folder_includes_what_it_holds(self):
        told, count = [], 0
        for path, text in self.files():
            count += 1
            told += wrong_includes(path, text)
        self.assertEqual(told, [])
        self.assertGreater(count, 300)

    def test_nobody_else_names_a_member(self):
        told = []
        for path, text in self.files():
            told += wrong_members(path, text, self.members)
        self.assertEqual(told, [])

    def test_its_header_is_short(self):
        lines = len((SOURCES / "world/world.h").read_text(encoding="utf-8").splitlines())
        self.assertLessEqual(lines, MOST_LINES)

    def test_what_is_wrong_is_seen(self):
        def include(path, name):
            return len(wrong_includes(path, '#include "%s"\n' % name))
        self.assertEqual(include("src/render/view.c", "world/model.h"), 1)
        self.assertEqual(include("tests/render/view.c", "world/internal.h"), 1)
        self.assertEqual(include("bench/frame.c", "../src/world/model.h"), 1)
        self.assertEqual(include("tools/drive.c", "world/made.h"), 1)
        self.assertEqual(include("tests/render/view.c", "world/made.h"), 0)
        self.assertEqual(include("tests/world/phases.c", "world/internal.h"), 0)
        self.assertEqual(include("src/world/steps.c", "world/internal.h"), 0)

        def member(text, path="src/report/report.c"):
            return len(wrong_members(path, text, {"time", "rows", "resident"}))
        self.assertEqual(member("void f(const struct world *w)\n{\n\tg(w->time);\n}\n"), 1)
        self.assertEqual(member("void f(struct world *world)\n{\n\tworld->resident.store = NULL;\n}\n"), 1)
        self.assertEqual(member("void f(struct drive *drive)\n{\n\tg(drive->world->rows);\n}\n"), 1)
        self.assertEqual(member("struct rig {\n\tstruct world world;\n};\n"), 1)
        self.assertEqual(member("struct world {\n\tint time;\n};\n"), 1)
        self.assertEqual(member("void f(struct world *world)\n{\n\tg(world_time(world)); /* not world->time */\n}\n"), 0)
        self.assertEqual(member("void f(struct furrow_world *world)\n{\n\tg(world->rows);\n}\n"), 0)
        self.assertEqual(member("void f(struct world *world)\n{\n\tg(world->time);\n}\n", "src/world/steps.c"), 0)
        # The pointer of one function is not another's.
        self.assertEqual(member("void f(struct world *w)\n{\n}\nvoid g(struct track *w)\n{\n\th(w->time);\n}\n"), 0)


if __name__ == "__main__":
    unittest.main()
