"""Every figure that a page shows is that of a file, and every file says where its figures are of (bench/record.py, bench/marks.py).

On pages of figures (WHOLE) each number in a table has a mark, but for the first column, which says what a row is about, and for settings. On every page a
time or a ratio of times in a sentence has one."""
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(os.environ["SOURCES"]).parent
sys.path.insert(0, str(ROOT / "bench"))
import marks  # noqa: E402
import record  # noqa: E402
import scale  # noqa: E402

# Pages whose tables have figures.
WHOLE = ("README.md", "docs/BENCHMARKS.md", "docs/SCALE.md", "src/deform/VALIDATION.md", "src/deform/SOIL.md", "src/store/HISTORY.md", "src/page/PAGING.md",
         "src/vehicle/VEHICLES.md", "src/trials/MOBILITY.md", "docs/CAMERAS.md", "docs/tutorials/how-far-to-believe-it.md", "bench/README.md", "bench/CONVERGE.md", "bench/ACCURACY.md")
# Names that have a number in them. What a row is about is in its first column, where numbers are settings.
NAMES = ("GDAL 3.6", "GeForce 7800 GT")
# What is always measured, wherever a sentence tells it.
TIMES = re.compile(r"(?<![\w.])" + marks.NUMBER + r"(?= (?:us\b|times as long|times the (?:processor )?time|ms (?:a|longer)\b))")
GOOD = {"bench": "b", "command": "c", "commit": "0" * 40, "dirty": False, "date": "2026-01-01T00:00:00Z", "load": [0.1, 0.2],
        "machine": {"cpu": "x", "cores": 2, "memory": 1, "renderer": None}, "build": {"type": "release", "asserts": False, "sanitizers": "none"},
        "figures": {"a": {"value": 2.5, "unit": "ms", "runs": 3, "low": 2, "high": 3}, "r.b": {"value": 12345.6, "unit": "B", "runs": 1}}}


def parts_of(text):
    """The text without what a bench writes whole, and without code."""
    text = re.sub(r"^<!-- (\w+): begin -->$.*?^<!-- \1: end -->$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"^```.*?^```$|^    [^\n]*$", "", text, flags=re.MULTILINE | re.DOTALL)


def tables(text):
    """(the comment above it or "", heads, rows of cells) of each table."""
    lines = parts_of(text).split("\n")
    for at, line in enumerate(lines):
        if not line.startswith("|") or at and lines[at - 1].startswith("|"):
            continue
        rows = []
        while at + len(rows) < len(lines) and lines[at + len(rows)].startswith("|"):
            rows.append([cell.strip() for cell in lines[at + len(rows)].strip().strip("|").split("|")])
        yield lines[at - 1].strip() or lines[max(at - 2, 0)].strip(), rows[0], rows[2:]


def holds(test, share):
    """Whether the test multiplies something by this share."""
    text = (ROOT / test).read_text() if (ROOT / test).is_file() else ""
    share = re.escape(f"{share:g}")
    return re.search(rf"(?<![\d.]){share} \*|\* {share}(?![\d.])", text) is not None


def bounds_of(row):
    """The shares that a row of bounds tells, each with the test that the row names."""
    tests = re.findall(r"tests/[\w/]+\.\w+", row[-1])
    return [(share, test) for cell in row for share in re.findall(r"([\d.]+) %", cell) for test in tests]


def without_marks(text):
    """Cells of the tables that have a number without a mark, as "HEAD: CELL"."""
    found = []
    for comment, heads, rows in tables(text):
        settings, bounds = marks.SETTINGS.fullmatch(comment), marks.BOUNDS.fullmatch(comment)
        if bounds:
            found += [f"{comment}: {test} is not there" for test in bounds["tests"].split() if not (ROOT / test).is_file()]
            found += [f"{comment}: no {share} % in {test}" for row in rows for share, test in bounds_of(row) if not holds(test, float(share) / 100)]
            continue
        if marks.CELLS.fullmatch(comment) or settings and settings["heads"] is None:
            continue
        free = {head.strip() for head in settings["heads"].split(";")} if settings else set()
        if free - set(heads):
            found.append(f"{comment}: the table has no such column")
        found += [f"{head}: {cell}" for row in rows for head, cell in list(zip(heads, row))[1:] if head not in free and unmarked(cell)]
    return found


def unmarked(cell):
    """Numbers of a cell without a mark."""
    for name in NAMES:
        cell = cell.replace(name, "")
    cell = re.sub(r"`[^`]*`|\]\([^)]*\)", "", marks.MARK.sub("", cell))  # neither code nor addresses
    return re.findall(r"(?<![\w.])" + marks.NUMBER + r"(?!\w)", cell)


class Files(unittest.TestCase):
    def test_each_says_what_it_is_of(self):
        found = marks.records()
        self.assertGreater(len(found), 10)
        self.assertEqual({name: record.faults(of) for name, of in found.items() if record.faults(of)}, {})

    def test_each_is_one_that_a_bench_writes(self):
        for name, of in marks.records().items():
            with self.subTest(file=name):
                self.assertTrue(of["bench"] == "none" or list((ROOT / "bench").glob(of["bench"] + ".*")), "no such bench")
                self.assertNotRegex(json.dumps(of), r'[ "]/(home|root|tmp|work|usr)/', "a path of a machine")

    def test_figures_that_follow_from_others_do(self):
        records = marks.records()
        kept = records["scale"]["figures"]
        wanted = {key: value for key, value, _ in scale.derived(records, kept["ruts.a_km"]["value"])}
        self.assertEqual(set(kept), set(wanted))
        for key, value in wanted.items():
            self.assertAlmostEqual(kept[key]["value"], value, delta=1e-9 * abs(value), msg=f"{key}: bench/scale.py was not run after what it follows from")

    def test_what_is_wrong_is_seen(self):
        self.assertEqual(record.faults(GOOD), [])
        for change, wanted in (({"commit": "abc"}, ["commit, load"]), ({"load": [1]}, ["commit, load"]), ({"more": 1}, ["more"]), ({"machine": {}}, None),
                               ({"figures": {"a": {"value": 9, "unit": "", "runs": 3, "low": 1, "high": 2}}}, ["figures.a"]),
                               ({"figures": {"a": {"value": float("nan"), "unit": "", "runs": 1}}}, ["figures.a"]),
                               ({"figures": {"a": {"value": 1, "unit": "", "runs": 0}}}, ["figures.a"])):
            faults = record.faults(GOOD | change)
            self.assertTrue(faults if wanted is None else faults == wanted, (change, faults))
        for name in record.FIELDS:
            self.assertEqual(record.faults({key: value for key, value in GOOD.items() if key != name}), [name])
        self.assertEqual(record.faults({"bench": "b", "source": "somewhere", "figures": GOOD["figures"]}), ["source: says too little"])
        self.assertEqual(record.faults(GOOD | {"figures": {}}), ["figures: none, and no part of a page"])
        self.assertEqual(record.faults(GOOD | {"figures": {}, "parts": {"a": ["b"]}}), [])
        self.assertEqual(record.faults(GOOD | {"build": None}), [])  # a script's own figures
        self.assertEqual(record.faults(GOOD | {"build": "release"}), ["build"])
        self.assertEqual(json.loads(record.text(GOOD)), GOOD)


class Pages(unittest.TestCase):
    def setUp(self):
        self.filler = marks.Filler(marks.records())
        for path in marks.pages():
            self.filler.page(path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix())

    def test_each_figure_is_that_of_its_file(self):
        self.assertGreater(len(self.filler.used), 100)
        self.assertEqual(self.filler.wrong, [], "\npython3 bench/marks.py writes the files' figures into the pages")

    def test_each_file_is_on_a_page(self):
        self.assertEqual(set(marks.records()) - {name for name, key in self.filler.used}, set())

    def test_each_part_that_a_bench_writes_is_held_to_a_file(self):
        parts = {key for of in marks.records().values() for key in of.get("parts", {})}
        self.assertGreater(len(parts), 3)
        for path in marks.pages():
            for name in re.findall(r"^<!-- (\w+): begin -->$", path.read_text(encoding="utf-8"), re.MULTILINE):
                page = path.relative_to(ROOT).as_posix()
                self.assertTrue({name, f"{page} {name}"} & parts, f"{page}: no file of bench/figures has the part {name}")

    def test_each_figure_in_a_table_of_a_page_of_figures_has_a_mark(self):
        for page in WHOLE:
            with self.subTest(page=page):
                self.assertEqual(without_marks((ROOT / page).read_text(encoding="utf-8")), [], "\nbench/marks.py explains marks, and `settings`")

    def test_each_time_in_a_sentence_has_a_mark(self):
        for path in marks.pages():
            page = path.relative_to(ROOT).as_posix()
            for line in parts_of(path.read_text(encoding="utf-8")).split("\n"):
                with self.subTest(page=page):
                    self.assertEqual([] if line.startswith("|") else TIMES.findall(marks.MARK.sub("", line)), [], line)

    def test_pages_of_figures_are_pages(self):
        self.assertEqual(set(WHOLE) - {path.relative_to(ROOT).as_posix() for path in marks.pages()}, set())


class Manual(unittest.TestCase):
    def test_a_manual_page_has_no_marks(self):
        for name, page in (("scene(5)", "src/scene/SCENE.md"), ("store(5)", "src/store/FORMAT.md")):
            text = subprocess.run([sys.executable, ROOT / "docs" / "manual.py", "page", name, "x", "2026-01-01", "1", ROOT / page], check=True, capture_output=True, text=True).stdout
            self.assertNotIn("<!", text)


class Marks(unittest.TestCase):
    def filled(self, text, **more):
        filler = marks.Filler({"f": GOOD | more})
        return filler.page(text, "page"), filler.wrong

    def test_a_number_is_written_with_the_digits_that_are_there(self):
        for like, value, wanted in (("1.50", 2.504, "2.50"), ("0.0", -0.0, "0.0"), ("1,000", 28141.4, "28,141"), ("7", 0.4, "0"), ("+0.1", 0.26, "+0.3"), ("-3", -3.6, "-4"),
                                    ("2.5e-22", 1.04e-9, "1.0e-09"), ("999", 12345, "12,345"), ("1086", 1090.2, "1090")):
            self.assertEqual(marks.printed(value, like), wanted)
        self.assertEqual(marks.converted(5589870, "B", "MB"), 5.58987)
        self.assertEqual(marks.converted(0.25, "times", "%"), 25)
        self.assertIsNone(marks.converted(1, "B", "ms"))

    def test_a_mark_fills_the_number_before_it(self):
        self.assertEqual(self.filled("it takes 2.5<!-- f.a --> ms, **12.3**<!-- f.r.b kB --> kB"),
                         ("it takes 2.5<!-- f.a --> ms, **12.3**<!-- f.r.b kB --> kB", []))
        text, wrong = self.filled("it takes 2.6<!-- f.a --> ms")
        self.assertEqual((text, len(wrong)), ("it takes 2.5<!-- f.a --> ms", 1))
        for text in ("it takes <!-- f.a --> ms", "1<!-- f.none -->", "1<!-- g.a -->", "1<!-- f.a MB -->"):
            self.assertEqual((self.filled(text)[0], len(self.filled(text)[1])), (text, 1), text)

    def test_a_table_is_filled_by_one_mark(self):
        figures = {key: {"value": value, "unit": "", "runs": 1} for key, value in (("x.p", 1), ("x.q", 2), ("y.p", 3), ("y.q", 4))}
        mark = "<!-- cells: f; rows: x y; columns: p/q - -->\n"
        right = mark + "| | 9 | 9 |\n| --- | --- | --- |\n| 8 | 1 / 2 | 7 |\n| z | 3 / 4 | 7 |\n\n5"
        self.assertEqual(self.filled(right, figures=figures), (right, []))
        text, wrong = self.filled(right.replace("3 / 4", "3 / 5"), figures=figures)
        self.assertEqual((text, len(wrong)), (right, 1))
        self.assertEqual(self.filled(right.replace("| 8 | 1 / 2 |", "| 8 | |"), figures=figures)[1], [])
        for before, after in (("1 / 2", "1"), ("| z | 3 / 4 | 7 |\n", ""), ("| 7 |\n|", "|\n|"), ("rows: x y", "rows: x"), ("cells: f;", "cells: f")):
            self.assertEqual(len(self.filled(right.replace(before, after, 1), figures=figures)[1]), 1, after)

    def test_a_part_is_that_of_the_file(self):
        page = "a\n<!-- part: begin -->\nx 1\n<!-- part: end -->\nb"
        self.assertEqual(self.filled(page, parts={"part": ["x 1"]}), (page, []))
        text, wrong = self.filled(page, parts={"part": ["x 2", "y"]})
        self.assertEqual((text, len(wrong)), (page.replace("x 1", "x 2\ny"), 1))
        self.assertEqual(len(self.filled(page + page, parts={"part": ["x 1"]})[1]), 1)
        self.assertEqual(self.filled(page, parts={"other part": ["x 2"], "page part": ["x 1"]}), (page, []))

    def test_a_number_without_a_mark_is_seen(self):
        self.assertEqual(unmarked(" 5.59<!-- store.a MB --> MB, GDAL 3.6 COG "), [])
        self.assertEqual(unmarked("1.7<!-- store.a --> s, 181 MB of `x 3` by [A](b-4.md)"), ["181"])
        page = "# A\n\n## B\n\n%s\n| a | b | asked |\n| --- | --- | --- |\n| 3 | 1<!-- f.a --> | 2 |\n\n```\n| d | 2 |\n```\n"
        for comment, wanted in (("", ["asked: 2"]), ("<!-- settings -->", []), ("<!-- settings: asked -->", []), ("<!-- bounds: tests/house/figures.py -->", []),
                                ("<!-- bounds: tests/none.c -->", ["<!-- bounds: tests/none.c -->: tests/none.c is not there"]), ("<!-- cells: f; rows: a; columns: b c -->", []),
                                ("<!-- settings: wanted -->", ["<!-- settings: wanted -->: the table has no such column", "asked: 2"])):
            self.assertEqual(without_marks(page % comment), wanted)

    def test_a_time_in_a_sentence_is_seen(self):
        for text, wanted in (("takes 1.8 times as long", ["1.8"]), ("12 us", ["12"]), ("0.1 ms a step", ["0.1"]), ("a step of 2 ms", []), ("2 times", [])):
            self.assertEqual(TIMES.findall(text), wanted, text)


if __name__ == "__main__":
    unittest.main()
