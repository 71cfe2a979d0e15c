"""Figures on pages come from the files of bench/figures. A mark behind a number names the figure, and no reader sees it:

    5.59 MB: "5.59<!-- store.bytes MB --> MB" shows figure `bytes` of store.json, in MB. Without a unit the mark takes the file's.

A table of many figures has one mark above it. Its rows and columns are words; a figure's key is ROW.COLUMN. A cell of several numbers has a
column of several words, parted by "/". "-" is a column or row without figures, and an empty cell has none. The first column is never looked at:

    <!-- cells: deform; rows: none box; columns: one/one_mean four/four_mean -->

A table on a page of figures that has none, or columns that are settings, says so above it, by the heads of these columns:

    <!-- settings -->
    <!-- settings: asked; allowed -->

A table of bounds names the tests that hold them: `<!-- bounds: tests/api/probe.c -->`.

What lies between "<!-- NAME: begin -->" and "<!-- NAME: end -->" a bench writes whole. Its file has the text, in `parts`.

    python3 bench/marks.py            # writes every figure into its page, with as many digits as are there
    python3 bench/marks.py --check    # tells what differs, and writes nothing
"""
import argparse
import json
import pathlib
import re
import sys

from pages import Told, aside, between
from record import FIGURES, ROOT

FOLDERS = ("docs", "src", "bench", "examples")
NUMBER = r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?"
MARK = re.compile(r"(?P<number>" + NUMBER + r")?(?P<mark>(?P<bold>\*\*)?<!-- (?P<file>\w+)\.(?P<key>[\w.]+)(?: (?P<unit>[^\s>]+))? -->)")
SETTINGS = re.compile(r"<!-- settings(?:: (?P<heads>[^>]+))? -->")
BOUNDS = re.compile(r"<!-- bounds: (?P<tests>[^>]+) -->")
CELLS = re.compile(r"<!-- cells: (?P<file>\w+); rows: (?P<rows>[\w. -]+); columns: (?P<columns>[\w./ -]+) -->")
# In how many of its first unit a unit is. Units of a line may be turned into each other.
UNITS = ({"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9}, {"s": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}, {"m": 1, "cm": 1e-2, "mm": 1e-3}, {"times": 1, "%": 1e-2},
         {"N": 1, "kN": 1e3}, {"J": 1, "kJ": 1e3})


def pages():
    """Every page that a mark may be on."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md"] + [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.md"))]


def records(folder=FIGURES):
    """{NAME: contents} of NAME.json."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def converted(value, unit, wanted):
    """None if one unit is nothing of the other."""
    if wanted in (None, unit):
        return value
    line = next((line for line in UNITS if unit in line and wanted in line), None)
    return line and value * line[unit] / line[wanted]


def printed(value, like):
    """A value with the digits, the sign and the commas of the number that a page has."""
    mantissa, _, exponent = like.partition("e")
    places = len(mantissa.partition(".")[2])
    if not exponent:
        value = round(value, places)
    value += 0.0  # no -0.0
    sign = "+" if like.startswith("+") else ""
    if exponent:
        digits, _, power = f"{value:{sign}.{places}e}".partition("e")
        return f"{digits}e{int(power):0{len(exponent)}d}" if exponent[0] == "-" else f"{digits}e{int(power)}"
    return f"{value:{sign}{',' if ',' in like or abs(value) >= 1e4 else ''}.{places}f}"


class Filler:
    """Writes figures into the text of a page, and notes what differed and what it used."""

    def __init__(self, found):
        self.records, self.wrong, self.used = found, [], set()

    def figure(self, name, key, unit, like, where):
        """The number as the page should have it; what it has where nothing gives it."""
        figure = self.records.get(name, {}).get("figures", {}).get(key)
        if figure is None:
            self.wrong.append(f"{where}: bench/figures/{name}.json has no figure {key}")
            return like
        self.used.add((name, key))
        value = converted(figure["value"], figure["unit"], unit)
        if value is None:
            self.wrong.append(f"{where}: {name}.{key} is in {figure['unit'] or 'no unit'}, not in {unit}")
            return like
        right = printed(value, like)
        if right != like:
            self.wrong.append(f"{where}: {name}.{key} is {right}, the page has {like}")
        return right

    def marks(self, row, where):
        def filled(found):
            if found["number"] is None:
                self.wrong.append(f"{where}: no number before the mark {found['mark']}")
                return found[0]
            return self.figure(found["file"], found["key"], found["unit"], found["number"], where) + found["mark"]
        return MARK.sub(filled, row)

    def cell(self, name, row, column, text, where):
        if "-" in (row, column) or not text.strip():
            return text
        keys = column.split("/")
        numbers = list(re.finditer(NUMBER, text))
        if len(keys) != len(numbers):
            self.wrong.append(f"{where}: {len(numbers)} numbers in \"{text.strip()}\", {column} has {len(keys)}")
            return text
        for key, number in reversed(list(zip(keys, numbers))):
            if key != "-":
                text = text[:number.start()] + self.figure(name, f"{row}.{key}", None, number[0], where) + text[number.end():]
        return text

    def table(self, mark, rows, where, first):
        """rows: of the table, with its head and the line below that."""
        names, columns = mark["rows"].split(), mark["columns"].split()
        if len(rows) != len(names) + 2:
            self.wrong.append(f"{where}: a table of {len(names)} rows is to follow the mark, and {max(0, len(rows) - 2)} do")
            return rows
        out = rows[:2]
        for number, (name, row) in enumerate(zip(names, rows[2:]), first + 2):
            cells = row.strip().strip("|").split("|")
            if len(cells) != len(columns) + 1:
                self.wrong.append(f"{where}: row {name} has {len(cells) - 1} cells of figures, the mark has {len(columns)}")
                return rows
            filled = [self.cell(mark["file"], name, column, cell, f"{where.rpartition(':')[0]}:{number}") for column, cell in zip(columns, cells[1:])]
            out.append("|" + "|".join([cells[0], *filled]) + "|")
        return out

    def parts(self, text, name):
        """The text with each part that a bench writes whole as its file has it."""
        for file, record in self.records.items():
            for key, lines in record.get("parts", {}).items():
                page, _, part = key.rpartition(" ")
                if page not in ("", name) or f"<!-- {part}: begin -->" not in text:
                    continue
                try:
                    filled = between(text, part, "\n".join(lines))
                except Told as told:
                    self.wrong.append(f"{name}: {part}: {told}")
                    continue
                self.used.add((file, key))
                if filled != text:
                    self.wrong.append(f"{name}: what is between the markers of {part} is not what bench/figures/{file}.json has")
                    text = filled
        return text

    def page(self, text, name):
        """The text with every figure as its file has it."""
        text = self.parts(text, name)
        lines, out, at = text.split("\n"), [], 0
        while at < len(lines):
            mark = CELLS.fullmatch(lines[at].strip())
            if mark is None:
                if lines[at].lstrip().startswith("<!-- cells"):
                    self.wrong.append(f"{name}:{at + 1}: is no mark of a table as bench/marks.py explains it")
                out.append(self.marks(lines[at], f"{name}:{at + 1}"))
                at += 1
                continue
            begin = at + 1 + (lines[at + 1:at + 2] == [""])
            end = begin
            while end < len(lines) and lines[end].startswith("|"):
                end += 1
            out += lines[at:begin] + self.table(mark, lines[begin:end], f"{name}:{at + 1}", begin + 1)
            at = end
        return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; the exit status is 1 if something differs")
    options = parser.parse_args()
    filler = Filler(records())
    for path in pages():
        text = path.read_text(encoding="utf-8")
        filled = filler.page(text, path.relative_to(ROOT).as_posix())
        if filled != text and not options.check:
            with aside(path) as file:
                file.write(filled)
    print("\n".join(filler.wrong) or f"{len(filler.used)} figures are as their files have them")
    if options.check:
        return 1 if filler.wrong else 0
    again = Filler(filler.records)
    for path in pages():
        again.page(path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix())
    return 1 if again.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
