"""Reads objects.csv, vehicles.csv and volume.csv of a drive. None is trusted: a line that is none is told with its number.

A file is read in parts, so that what is held are its numbers alone. pandas reads a part; only where it cannot, each line is looked at.
"""
import os
import sys
import time
from typing import Any, Iterator, Union

import numpy as np
import pandas

from furrow.results import ResultsError

PART = 8 << 20           # bytes of a file that are read at once
ROWS_MOST = 20_000_000   # in a file: about 2 GB
BODIES_MOST = 4096
VOLUMES_MOST = 1_000_000
NANS = ["nan", "-nan", "NaN", "-NaN", "NAN"]

OBJECTS = ("t", "x", "y", "z", "sinkage", "slip", "fx", "fy", "fz", "tx", "ty", "tz")
OBJECTS_MAY = ("load", "work", "carried", "carried_weight")  # the file may have none of it, and a cell may be empty
VEHICLES = ("t", "x", "y", "z", "vx", "vy", "vz", "work", "kinetic")
VEHICLES_MAY = ("yaw",)
VOLUME = b"t,step,removed,raised,compacted"

Columns = "dict[str, np.ndarray]"


class Progress:
    """Tells on the terminal, or each ten seconds in a log, how much of a file is read."""

    def __init__(self, what: str, total: int) -> None:
        self.what, self.total, self.terminal = what, total, sys.stderr.isatty()
        self.shown = time.monotonic() + (0.5 if self.terminal else 0)

    def tell(self, done: int) -> None:
        now = time.monotonic()
        if now - self.shown < (0.1 if self.terminal else 10):
            return
        self.shown = now
        begin, end = ("\r", "\033[K") if self.terminal else ("furrow: note: ", "\n")
        print(f"{begin}{self.what}: {done / 1e6:.0f} of {self.total / 1e6:.0f} MB ({100 * done / max(self.total, 1):.0f} %)", end=end, file=sys.stderr, flush=True)

    def end(self) -> None:
        if self.terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def wrong(path: str, line: int, why: str) -> ResultsError:
    return ResultsError(f"{path}:{line}: {why}; give a folder that furrow drive left, or remove the file")


def parts(path: str) -> "Iterator[bytes]":
    """Whole lines of a file, many at once. A last line without its end is left out: a kill may have torn it."""
    left = b""
    try:
        with open(path, "rb") as file:
            progress = Progress(path, os.fstat(file.fileno()).st_size)
            done = 0
            while data := file.read(PART):
                done += len(data)
                progress.tell(done)
                whole, end, rest = data.rpartition(b"\n")
                if end:
                    yield left + whole + end
                    left = rest
                else:
                    left += data
            progress.end()
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}; give a folder that can be read") from None


class _File:
    """A file of rows while it is read."""

    def __init__(self, path: str, needed: "tuple[str, ...]", may: "tuple[str, ...]", actuators: bool) -> None:
        self.path, self.needed, self.may, self.actuators = path, needed, may, actuators
        self.names: "list[str]" = []   # of the columns that are read
        self.cells: "list[int]" = []   # their numbers in a line
        self.wide = 0                  # cells of a line
        self.line, self.rows = 0, 0
        self.bodies: "dict[str, list[np.ndarray]]" = {}
        self.last: "dict[str, float]" = {}

    def header(self, line: bytes) -> None:
        names = [name.decode(errors="replace") for name in line.rstrip(b"\r").split(b",")]
        self.line, self.wide = 1, len(names)
        if b"\0" in line:
            raise wrong(self.path, 1, "has a byte 0")
        if names[:2] != ["t", "name"]:
            raise wrong(self.path, 1, "does not begin with the columns t and name")
        if any(name not in names for name in self.needed):
            raise wrong(self.path, 1, "lacks a column that such a file has")
        first: "dict[str, int]" = {}
        for cell, name in enumerate(names):
            first.setdefault(name, cell)
        self.names = [*self.needed, *(name for name in self.may if name in first)]
        if self.actuators:
            self.names += [name for name in first if name.startswith("f:") or name == "u:tow"]
        self.cells = [first[name] for name in self.names]

    def diagnose(self, data: bytes) -> ResultsError:
        """What is wrong with the first line that is none."""
        for number, line in enumerate(data.split(b"\n")[:-1], self.line + 1):
            cells = line.rstrip(b"\r").split(b",")
            if b"\0" in line:
                return wrong(self.path, number, "has a byte 0")
            if len(cells) != self.wide:
                return wrong(self.path, number, "has not as many columns as the first line")
            for name, cell in zip(self.names, self.cells):
                try:
                    if cells[cell] or name in self.needed:
                        float(cells[cell])
                except ValueError:
                    return wrong(self.path, number, "has a cell that is no number")
        return wrong(self.path, self.line + 1, "or one of the lines after it cannot be read")

    def take(self, data: bytes) -> None:
        """Rows that follow on those that were taken."""
        count = data.count(b"\n")
        if data.count(b",") != count * (self.wide - 1) or b"\0" in data or data.count(b"\r") not in (0, count):
            raise self.diagnose(data)
        self.rows += count
        if self.rows > ROWS_MOST:
            raise wrong(self.path, self.line + ROWS_MOST - self.rows + count + 1, "is behind the 20 million rows that a report reads")
        try:
            table = pandas.read_csv(_Bytes(data), header=None, names=range(self.wide), usecols=[1, *self.cells], dtype={1: str, **{cell: np.float64 for cell in self.cells}},
                                    na_values={cell: NANS if name in self.needed else [*NANS, ""] for name, cell in zip(self.names, self.cells)}, keep_default_na=False, index_col=False,
                                    quoting=3, float_precision="round_trip", engine="c", skip_blank_lines=False, encoding="utf-8", encoding_errors="surrogateescape")
        except (ValueError, OverflowError):
            raise self.diagnose(data) from None
        values = table[self.cells].to_numpy(np.float64)
        values[~np.isfinite(values)] = np.nan
        lost = np.isnan(values[:, :4]).any(axis=1)
        if lost.any():
            raise wrong(self.path, self.line + 1 + int(np.argmax(lost)), "does not tell when or where it is")
        self._share(table[1].to_numpy(object), values)
        self.line += count

    def _share(self, names: "np.ndarray", values: "np.ndarray") -> None:
        """Gives each body its rows."""
        codes, bodies = pandas.factorize(names)
        order = np.argsort(codes, kind="stable")
        ends = np.cumsum(np.bincount(codes, minlength=len(bodies)))
        back = []
        for body, begin, end in zip(bodies, [0, *ends[:-1]], ends):
            own = order[begin:end]
            rows = values[own]
            steps = np.diff(rows[:, 0], prepend=self.last.get(body, -np.inf))
            if (steps < 0).any():
                back.append(int(own[np.argmax(steps < 0)]))
            self.last[body] = float(rows[-1, 0])
            self.bodies.setdefault(body, []).append(rows)
        if back:
            raise wrong(self.path, self.line + 1 + min(back), "goes back in time")
        if len(self.bodies) > BODIES_MOST:
            raise wrong(self.path, self.line + 1, "or a line after it has too many names")


class _Bytes:
    """Bytes as pandas reads a file."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = memoryview(data), 0

    def read(self, size: int = -1) -> bytes:
        end = len(self.data) if size < 0 else self.at + size
        out = bytes(self.data[self.at:end])
        self.at += len(out)
        return out

    def readline(self) -> bytes:
        raise NotImplementedError

    def __iter__(self) -> "Iterator[bytes]":
        return iter(())


def _read(path: str, needed: "tuple[str, ...]", may: "tuple[str, ...]", actuators: bool) -> "Iterator[tuple[str, dict[str, np.ndarray]]]":
    """Each name and its columns. What was given away is not held."""
    if not os.path.isfile(path):  # reading a pipe might never end
        return
    file = _File(path, needed, may, actuators)
    for data in parts(path):
        if file.wide == 0:
            line, _, data = data.partition(b"\n")
            file.header(line)
        if data:
            file.take(data)
    for name in list(file.bodies):
        rows = file.bodies.pop(name)
        yield name, {column: np.concatenate([part[:, k] for part in rows]) for k, column in enumerate(file.names)}


def objects(folder: str) -> "Iterator[tuple[str, dict[str, np.ndarray]]]":
    """Each name of objects.csv, and its columns, nan where a number is not known. Nothing: there are no rows. ResultsError: it is damaged."""
    return _read(f"{folder}/objects.csv", OBJECTS, OBJECTS_MAY, False)


def vehicles(folder: str) -> "Iterator[tuple[str, dict[str, np.ndarray]]]":
    """The same of vehicles.csv, with the columns f:ACTUATOR and u:tow."""
    return _read(f"{folder}/vehicles.csv", VEHICLES, VEHICLES_MAY, True)


def volumes(folder: str) -> "Union[dict[str, np.ndarray], None]":
    """volume.csv: t, removed, raised, compacted and net, which is raised less removed. None: there is none. ResultsError: it is damaged."""
    path = f"{folder}/volume.csv"
    if not os.path.isfile(path):
        return None
    values: "list[list[float]]" = []
    number = 0
    for data in parts(path):
        for line in data.split(b"\n")[:-1]:
            number += 1
            row: "list[float]" = []
            if number == 1 and line == VOLUME:
                continue
            try:
                row = [float(cell) for cell in line.split(b",")]
            except ValueError:
                pass
            if number == 1 or len(row) != 5 or not np.isfinite(row).all() or len(values) == VOLUMES_MOST or (values and row[0] < values[-1][0]):
                raise ResultsError(f"{path}:{number}: is no line of such a file; give a folder that furrow drive left, or remove the file")
            values.append(row)
    t, _, removed, raised, compacted = np.array(values).reshape(-1, 5).T
    return {"t": t, "removed": removed, "raised": raised, "compacted": compacted, "net": raised - removed}


