"""Reads the rows of a soil's test from a CSV file, which is untrusted.

A column is known by a word of its name, and its unit is the last word: `plate width b m`, `z [mm]`, `sinkage_mm`. A column without a unit is refused, since a
guess could be wrong by a factor of a thousand. Other columns are passed over.
"""
import bisect
import math
import os
import re
from typing import Any, Union

import numpy as np

from furrow import _command
from furrow.results import ResultsError

LINE, COLUMNS, WORDS, ROWS, GROUPS = 4096, 64, 12, 1000000, 64  # bytes of a line; at most so many of each
SAME = 1e-9                                                     # of the value: a group's values differ at most by so much
MOST = 1e12
GROUP, X, Y = range(3)

# What a column is: words of which its name has all, and the field.
_KNOWN = {
    "plate": [(("width",), GROUP), (("b",), GROUP), (("radius",), GROUP), (("diameter",), GROUP), (("sinkage",), X), (("z",), X), (("pressure",), Y), (("p",), Y)],
    "shear": [(("normal",), GROUP), (("sigma",), GROUP), (("displacement",), X), (("j",), X), (("shear", "stress"), Y), (("tau",), Y)],
    "penetration": [(("area",), GROUP), (("depth",), X), (("sinkage",), X), (("z",), X), (("pressure",), Y), (("p",), Y), (("force",), Y), (("f",), Y)],
}
_NAMES = {"plate": ("plate width b", "sinkage z", "pressure p"), "shear": ("normal stress sigma", "displacement j", "shear stress tau"),
          "penetration": ("area", "depth z", "force or pressure")}
_UNITS = {"length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3}, "stress": {"pa": 1.0, "kpa": 1e3, "mpa": 1e6}, "area": {"m2": 1.0, "cm2": 1e-4, "mm2": 1e-6},
          "force": {"n": 1.0, "kn": 1e3}}
_WRITTEN = {"length": "m, cm or mm", "stress": "Pa, kPa or MPa", "area": "m2, cm2 or mm2", "force": "N or kN"}
_EXAMPLES = {"plate": "plate width b m, sinkage z m, pressure p kPa", "shear": "normal stress sigma kPa, displacement j m, shear stress tau kPa",
             "penetration": "depth z m, force N"}


def _quantity(test: str, field: int, of_force: bool) -> str:
    if test == "penetration":
        return "area" if field == GROUP else "length" if field == X else "force" if of_force else "stress"
    return "stress" if field == Y or (field == GROUP and test == "shear") else "length"


class Table:
    """The rows of a test, in SI units: m, Pa (of a penetration also N) and m2.

    group: width b of a plate, normal stress of a shear test, area of a penetrating plate (0: there is no such column). x: sinkage, displacement or depth, above 0.
    y: pressure, shear stress or force. line: of the file. groups: the different values of group, rising. at: of each row the index of its group. skipped: rows
    where x is 0, which say nothing about the curve. All but the last two are arrays of one length.
    """

    def __init__(self, path: "Union[str, os.PathLike[str]]", test: str, rows: "list[tuple[float, float, float, int]]", groups: "list[float]", skipped: int = 0) -> None:
        self.path, self.test, self.skipped, self.is_force = str(path), test, skipped, False
        numbers = np.array(rows, float).reshape(-1, 4)
        self.group, self.x, self.y = (numbers[:, i].copy() for i in range(3))
        self.line = numbers[:, 3].astype(int)
        self.groups = groups
        self.at = np.array([group_of(groups, value) for value in self.group], int)

    def __len__(self) -> int:
        return len(self.x)

    def of(self, group: int) -> "np.ndarray":
        """Which rows are of a group."""
        return np.asarray(self.at == group)


def _same(a: float, b: float) -> bool:
    return abs(a - b) <= SAME * max(abs(a), abs(b))


def group_of(groups: "list[float]", value: float) -> int:
    """The index of a value's group."""
    at = bisect.bisect_right(groups, value)
    return at if at < len(groups) and _same(groups[at], value) else max(at - 1, 0)


class _Columns:
    """Where the fields are, and what their numbers are multiplied by."""

    def __init__(self, where: str, test: str, line: str) -> None:
        self.where, self.test, self.is_force = where, test, False
        self.at: "dict[int, int]" = {}
        self.unit: "dict[int, float]" = {}
        cells = line.split(",")
        for column, cell in enumerate(cells[:COLUMNS]):
            self._take(column, re.findall("[0-9A-Za-z]+", cell.lower())[:WORDS])
        if len(cells) > COLUMNS:
            raise ResultsError(f"{where}: has more than {COLUMNS} columns; give fewer")
        for field in range(3):
            if field not in self.at and not (test == "penetration" and field == GROUP):
                raise ResultsError(f"{where}: has no column {_NAMES[test][field]}; its first line names the columns with their units, as {_EXAMPLES[test]}")

    def _take(self, column: int, words: "list[str]") -> None:
        field = next((field for needed, field in _KNOWN[self.test] if set(needed) <= set(words)), None)
        if field is None:
            return
        of_force = self.test == "penetration" and field == Y and bool({"force", "f"} & set(words))
        quantity, name = _quantity(self.test, field, of_force), _NAMES[self.test][field]
        if field in self.at:
            raise ResultsError(f"{self.where}: columns {self.at[field] + 1} and {column + 1} are both {name}; name one of them otherwise")
        unit = _UNITS[quantity].get(words[-1]) if len(words) > 1 else None
        if unit is None:
            raise ResultsError(f"{self.where}: column {column + 1}, {name}, does not end with its unit; write {name} {_WRITTEN[quantity]}")
        self.at[field] = column
        self.is_force = self.is_force or of_force
        self.unit[field] = unit / 2 if self.test == "plate" and field == GROUP and "diameter" in words else unit  # the width of a round plate is its radius


def _number(cell: str) -> "float | None":
    text = cell.strip(' \t"')
    if not re.fullmatch(r"[-+.0-9eE]+", text):
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _row(where: str, columns: _Columns, line: str) -> "tuple[float, float, float]":
    cells, values = line.split(","), [0.0, 0.0, 0.0]
    for field, column in sorted(columns.at.items(), key=lambda item: item[1]):
        name = _NAMES[columns.test][field]
        if column >= len(cells):
            raise ResultsError(f"{where}: has no column {column + 1}, {name}; each line has one value for each column")
        value = _number(cells[column])
        if value is None:
            raise ResultsError(f'{where}: column {column + 1}, {name}: "{cells[column][:40]}" is no number; give one, with a point and without a unit')
        values[field] = value * columns.unit[field]
        if not 0 <= values[field] <= MOST:
            raise ResultsError(f"{where}: column {column + 1}, {name}: {cells[column][:40]} is {'below 0' if values[field] < 0 else 'too large'}; count "
                               f"{'downwards or along the way' if field == X else 'pressure and size'} from 0 upwards")
    if columns.test == "plate" and not values[GROUP] > 0:
        raise ResultsError(f"{where}: the plate's width is 0; give its shorter side, or the radius of a round one")
    return values[GROUP], values[X], values[Y]


def _add_group(groups: "list[float]", known: "set[float]", value: float, where: str) -> None:
    if value in known:
        return
    if not groups or not _same(groups[group_of(groups, value)], value):
        if len(groups) == GROUPS:
            raise ResultsError(f"{where}: has more than {GROUPS} plate widths or normal stresses; round them to those that were set")
        bisect.insort(groups, value)
    known.add(value)


def read(path: "Union[str, os.PathLike[str]]", test: str) -> Table:
    """Reads a CSV file. `test`: plate, shear or penetration. ResultsError names file and line: no such column, no unit, no number, a number below 0."""
    rows: "list[tuple[float, float, float, int]]" = []
    groups: "list[float]" = []
    known: "set[float]" = set()
    columns, skipped, number = None, 0, 0
    try:
        with _command.opened(path) as file:
            for number, line in enumerate(iter(lambda: file.readline(LINE), ""), 1):
                where = f"{path}:{number}"
                if len(line.encode()) >= LINE or "\0" in line:
                    raise ResultsError(f"{where}: the line is longer than {LINE - 2} bytes, or has a byte 0; give a CSV file")
                text = line.rstrip("\r\n \t")
                text = text[1:] if number == 1 and text.startswith("\ufeff") else text
                if text == "" or text[0] == "#":
                    continue
                if columns is None:
                    columns = _Columns(where, test, text)
                    continue
                row = _row(where, columns, text)
                if not row[X] > 0:
                    skipped += 1
                    continue
                if len(rows) == ROWS:
                    raise ResultsError(f"{where}: has more than {ROWS} rows; give fewer, as every tenth")
                _add_group(groups, known, row[GROUP], where)
                rows.append((*row, number))
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}; give a file that can be read") from None
    if columns is None:
        raise ResultsError(f"{path}: is empty; its first line names the columns, as {_EXAMPLES[test]}")
    table = Table(path, test, rows, groups, skipped)
    table.is_force = columns.is_force
    return table


def take_pressures(table: Table, area: "float | None") -> None:
    """Divides the forces of a penetration by the area of their row or, where there is none, by `area`, m2. ResultsError: there is no area, or both are given."""
    column = bool(table.groups) and table.groups[0] > 0
    if not table.is_force and area:
        raise ResultsError(f"{table.path}: has pressures, and --area is for forces; leave it out")
    if column and area:
        raise ResultsError(f"{table.path}: has a column area, and --area is given too; give one of them")
    if table.is_force and not column and not area:
        raise ResultsError(f"{table.path}: has forces, and no area; give the plate's area in m2 by --area, or a column area m2")
    if area:
        table.group[:], table.groups = area, [area]
    if table.is_force:
        bad: Any = np.flatnonzero(~(table.group > 0))
        if len(bad) > 0:
            raise ResultsError(f"{table.path}:{table.line[bad[0]]}: the area is 0; give that of the plate")
        table.y = table.y / table.group
    table.is_force = False
