"""Each failure says what is wrong, why, and what to do: "WHAT: WHY; WHAT TO DO"."""
import os
import pathlib
import re
import unittest

SOURCES = pathlib.Path(os.environ.get("SOURCES", pathlib.Path(__file__).resolve().parents[2] / "src"))
TOOLS = SOURCES.parent / "tools"
# Their callers put such a message into another one, which says what to do.
PARTS = {"store/store_stage.c", "store/store_undo.c", "store/store_overlay.c"}
FAILURE = re.compile(r"fail_with\(\s*STATUS_\w+,\s*((?:\"(?:[^\"\\]|\\.)*\"\s*|[A-Z][A-Z_0-9a-z]*\s*)+)[,)]")


def messages(text):
    """Each message that is written out, with its line. What a macro puts in is left out."""
    for found in FAILURE.finditer(text):
        yield text.count("\n", 0, found.start()) + 1, found[1]


def lacks_advice(message):
    literal = "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', message))
    only_text = re.fullmatch(r'(?:"(?:[^"\\]|\\.)*"\s*|PRI\w+\s*)+', message) is not None
    return only_text and not literal.endswith("%s") and "; " not in literal


class Messages(unittest.TestCase):
    def test_each_failure_says_what_to_do(self):
        found, count = [], 0
        for path in sorted([*SOURCES.rglob("*.c"), *TOOLS.glob("*.c")]):
            for line, message in messages(path.read_text()):
                count += 1
                if lacks_advice(message) and not any(path.match(part) for part in PARTS):
                    found.append(f"{path.relative_to(SOURCES.parent)}:{line}: {message}")
        self.assertEqual(found, [])
        self.assertGreater(count, 600)

    def test_each_limit_names_the_way_that_exists(self):
        """In the pages' lists of limits, and in sentences of --help that say what cannot be done."""
        way = re.compile(r"`|\]\(|\b(give|use|run|leave|take|is a store)\b", re.I)
        for page in (SOURCES.parent / "README.md", SOURCES / "vehicle/VEHICLES.md"):
            limits = page.read_text().split("\n## Limits\n")[1].split("\n## ")[0]
            points = re.split(r"\n- ", limits)[1:]
            self.assertGreater(len(points), 5)
            self.assertEqual([point for point in points if not way.search(point)], [], page)
        ways = re.compile(r"\b(give|use|leave|name|drive|see|furrow)\b|--", re.I)
        for path in TOOLS.glob("*.c"):
            for details in re.findall(r"\.details = ((?:\"(?:[^\"\\]|\\.)*\"\s*)+)", path.read_text()):
                text = "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', details)).replace("\\n", " ")
                for sentence in re.findall(r"[^.]*\b(?:cannot|refused|do not tell|are not seen)\b[^.]*\.[^.]*", text):
                    self.assertRegex(sentence, ways, path.name)

    def test_it_finds_what_lacks_advice(self):
        text = 'fail_with(STATUS_INPUT, "%s: it is damaged", name); fail_with(STATUS_FAILED, "a: b; " ADVICE); fail_with(STATUS_USAGE, "a: b "\n "c; d")'
        self.assertEqual([lacks_advice(message) for _, message in messages(text)], [True, False, False])


if __name__ == "__main__":
    unittest.main(verbosity=2)
