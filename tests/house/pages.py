"""The pages of the project name what there is: links lead somewhere, named files and tests exist, the picture of includes is of today."""
import importlib.util
import os
import pathlib
import re
import unittest

ROOT = pathlib.Path(os.environ["SOURCES"]).parent
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
for folder in ("docs", "src", "bench", "examples"):
    PAGES += sorted((ROOT / folder).rglob("*.md"))
DESIGN = ROOT / "docs" / "DESIGN.md"
PATH = re.compile(r"(?:src|tests|tools|shaders|docs|bench|python|examples)/[\w./*-]+")


def prose(text):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(text):
    """What a link may name behind #, as GitHub makes it of headings."""
    heads = re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head)).strip().lower().replace(" ", "-") for head in heads}


def wrong_links(page, text):
    """Links of a page that lead nowhere."""
    wrong = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(text)):
        name, _, anchor = link.partition("#")
        if re.match(r"\w+:", link):
            continue
        to = page.parent / name if name else page
        if not to.exists():
            wrong.append(link)
        elif anchor and anchor not in anchors(text if to == page else to.read_text(encoding="utf-8")):
            wrong.append(link)
    return wrong


def wrong_paths(text):
    """Files that a page names in `...` from the project's root and that do not exist; * stands for any text."""
    named = [name.rstrip("./") for name in re.findall(r"`([^`\s]+)`", prose(text)) if PATH.fullmatch(name)]
    return [name for name in named if not any(ROOT.glob(name))]


def wrong_tests(text):
    """Tests that a page names in `...` behind their file, on one line, and that the file does not have."""
    wrong = []
    for line in text.splitlines():
        within = None
        for name in re.findall(r"`([^`\s]+)`", line):
            if PATH.fullmatch(name):
                within = ROOT / name if name.startswith("tests/") else None
            elif within is not None and within.is_file() and re.fullmatch(r"[a-z]+(_[a-z0-9]+){2,}", name):
                if not re.search(r"\b%s\b" % name, within.read_text(encoding="utf-8")):
                    wrong.append("%s: %s" % (within.name, name))
    return wrong


def numbers(text, row):
    """The numbers of each line that is such a row."""
    return [tuple(map(float, found)) for found in re.findall(row, text, re.MULTILINE)]


class Pages(unittest.TestCase):
    def each(self, wrong):
        found = {str(page.relative_to(ROOT)): wrong(page, page.read_text(encoding="utf-8")) for page in PAGES}
        self.assertGreater(len(found), 8)
        self.assertEqual({page: names for page, names in found.items() if names}, {})

    def test_links_lead_somewhere(self):
        self.each(wrong_links)

    def test_named_files_exist(self):
        # The list of changes names files of its own time.
        self.each(lambda page, text: [] if page.name == "CHANGELOG.md" else wrong_paths(text))

    def test_named_tests_exist(self):
        self.each(lambda page, text: wrong_tests(text))
        self.assertGreater(len(re.findall(r"`tests/\S+`", DESIGN.read_text(encoding="utf-8"))), 20)

    def test_the_picture_of_includes_is_of_today(self):
        spec = importlib.util.spec_from_file_location("includes", ROOT / "docs" / "includes.py")
        script = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(script)
        text, wrong = script.picture(ROOT)
        self.assertEqual(wrong, [])
        self.assertEqual((ROOT / "docs" / "includes.svg").read_text(encoding="utf-8"), text, "run docs/includes.py")

    def test_the_errors_that_notes_tell_are_those_of_the_bench_s_page(self):
        page = (ROOT / "bench" / "CONVERGE.md").read_text(encoding="utf-8").partition("### Few posts below a body")[2]
        header = (ROOT / "src" / "scene" / "scene_posts.h").read_text(encoding="utf-8")
        told = numbers(header, r"^\t\{([\d.]+), (\d+), (\d+)\},$")
        self.assertGreater(len(told), 5)
        self.assertEqual(told, numbers(page, r"^\| ([\d.]+) \| (\d+) % \| (\d+) % \|$"), "bench/README.md says how to write both again")
        for fewer, more in zip(told, told[1:]):
            self.assertTrue(fewer[0] < more[0] and fewer[1] >= more[1] and fewer[2] >= more[2], (fewer, more))

    def test_the_errors_that_explain_tells_of_faces_are_those_of_the_bench_s_page(self):
        page = (ROOT / "bench" / "CONVERGE.md").read_text(encoding="utf-8").partition("### What a coarse spacing costs where a body slides")[2]
        header = (ROOT / "src" / "scene" / "scene_faces_errors.h").read_text(encoding="utf-8")
        rows = numbers(page, r"^\| ([\d.]+) \|" + r" ([\d.]+) %; [\d.]+ % \|" * 4 + r" ([\d.]+) \| ([\d.]+) % \|$")
        wheels = numbers(header, r"^\t\{([\d.]+), \{(\d+), (\d+), (\d+), (\d+)\}\},$")
        blades = numbers(header, r"^\t\{([\d.]+), (\d+)\},$")
        self.assertEqual((len(rows), len(wheels), len(blades)), (4, 4, 4))
        self.assertEqual([row[0] for row in rows], [row[0] for row in wheels])
        self.assertEqual([row[5] for row in rows], [row[0] for row in blades])
        for column, told in [(k, [row[k] for row in wheels]) for k in range(1, 5)] + [(6, [row[1] for row in blades])]:
            for i, error in enumerate(told):  # rounded up, and never more at finer posts
                self.assertAlmostEqual(error, max(row[column] for row in rows[i:]) + 0.5, delta=0.56, msg=(column, i))

    def test_what_is_wrong_is_seen(self):
        self.assertEqual(wrong_links(DESIGN, "[a](nowhere.md) [b](#none) [c](../README.md) [d](https://example.org)\n# Here\n[e](#here)"),
                         ["nowhere.md", "#none"])
        self.assertEqual(wrong_paths("`src/none.c` `src/base/base.h` `tests/*/folders.py` `src/none/*.c`"), ["src/none.c", "src/none/*.c"])
        self.assertEqual(wrong_tests("`tests/laws/laws.c`: `no_time_step_shows_in_the_rut`, `no_such_test_is_there`"),
                         ["laws.c: no_such_test_is_there"])


if __name__ == "__main__":
    unittest.main()
