"""What the runs of `furrow study` gave, as one table and plots.

    import furrow
    frame = furrow.study("drawbar")                    # a pandas.DataFrame: a row for each run
    frame.pivot_table("drawbar", "slip", "soil").plot()
    furrow.studies.collect("drawbar")                  # what `furrow study collect` does: study.csv and the plots

docs/STUDY.md says what a study collects. study.json in its folder has it, beside the values of each run.
"""
import json
import math
import os
import pathlib
import sys
from typing import Any, Iterator, Union

from furrow import _command, _study_plot
from furrow.results import ResultsError

Path = Union[str, "os.PathLike[str]"]
LISTED = 320  # bytes of a list in a message


class Cell:
    """A result of a run: its text, as the CSV has it, and its number; nan: it is none."""

    def __init__(self, text: str = "", number: float = math.nan) -> None:
        self.text, self.number = text, number

    @staticmethod
    def of(number: float) -> "Cell":
        """In as few digits as tell it apart."""
        text = f"{number:.15g}"
        return Cell(text if float(text) == number else f"{number:.17g}", number)


def _listed(words: "list[str]") -> str:
    """A list as a message has it; words that do not fit are left out."""
    text = ""
    for word in words:
        longer = f"{text}, {word}" if text else word
        text = longer if len(longer.encode()) < LISTED else text
    return text


# --- run.json ---

def _find(at: Any, path: str) -> "tuple[Any, bool, Any]":
    """What a dotted path means, whether it is there, and what the path leads to before it is lost. Keys may have dots themselves."""
    if path == "":
        return at, True, at
    deepest = at
    pairs = at.items() if isinstance(at, dict) else ((str(i), value) for i, value in enumerate(at)) if isinstance(at, list) else ()
    for key, child in pairs:
        if key and (path == key or path.startswith(key + ".")):
            found, there, deepest = _find(child, path[len(key) + 1:])
            if there:
                return found, True, deepest
    return None, False, deepest


def _of_json(result: "dict[str, Any]", facts: Any) -> Cell:
    found, there, deepest = _find(facts, result["run"])
    if not there and deepest is None:  # a run that has none of it
        return Cell()
    if not there or isinstance(found, (dict, list)):
        names = found if there else deepest
        what = "is no single value of" if there else "is not in"
        raise ResultsError(f"{result['at']}: {result['run']} {what} run.json; allowed: {_listed(list(names) if isinstance(names, dict) else []) or 'a path to one value'}")
    if isinstance(found, bool):
        return Cell("true" if found else "false")
    if isinstance(found, (int, float)):
        return Cell.of(float(found))
    return Cell(found or "")


# --- columns of objects.csv and vehicles.csv ---

class _Figure:
    """The mean, the maximum, the minimum and the last of what is taken."""

    def __init__(self) -> None:
        self.column, self.count, self.sum, self.max, self.min, self.last = -1, 0, 0.0, -math.inf, math.inf, math.nan

    def take(self, value: float) -> None:
        self.sum += value
        self.max, self.min, self.last = max(self.max, value), min(self.min, value), value
        self.count += 1

    def cell(self, take: str) -> Cell:
        if take == "mean":
            return Cell.of(float(f"{self.sum / self.count:.12g}"))  # the rows have 9 digits
        return Cell.of({"max": self.max, "min": self.min, "last": self.last}[take])


def _rows(path: pathlib.Path) -> "Iterator[list[str]]":
    with _command.opened(path) as file:
        for line in file:
            yield line.rstrip("\r\n").split(",")


def _take_row(result: "dict[str, Any]", what: str, cells: "list[str]", figure: _Figure) -> None:
    time = _command.number(cells[0])
    if len(cells) <= figure.column or time is None or (result["after"] is not None and time < result["after"]) or cells[figure.column] == "":
        return
    value = _command.number(cells[figure.column])
    if value is None:
        raise ResultsError(f"{result['at']}: column {what} has {_command.quoted(cells[figure.column])}; allowed: a column of numbers")
    figure.take(value)


def _columns(results: "list[dict[str, Any]]", source: str, path: pathlib.Path) -> "list[_Figure]":
    """A file is read once for all results."""
    figures = [_Figure() for _ in results]
    try:
        for number, cells in enumerate(_rows(path)):
            for result, figure in zip(results, figures):
                if number == 0:
                    if result[source] not in cells:
                        raise ResultsError(f"{result['at']}: {result[source]} is no column; allowed: {_listed(cells[:1] + cells[2:])}")
                    figure.column = cells.index(result[source])
                elif len(cells) > 1 and cells[1] == result["of"]:
                    _take_row(result, result[source], cells, figure)
    except OSError as error:
        key = "forces" if source == "objects" else "vehicles"
        raise ResultsError(f"{results[0]['at']}: {path}: {error.strerror}; allowed: with output.{key} in the scene") from None
    return figures


# --- runs ---

class Study:
    """A study's folder: facts (study.json), and where its runs are. ResultsError: it is no study's."""

    def __init__(self, folder: Path, facts: "dict[str, Any] | None" = None) -> None:
        self.folder = pathlib.Path(folder)
        self.facts = facts if facts is not None else self._read()
        self.parameters = [parameter["name"] for parameter in self.facts["parameters"]]
        self.results: "list[dict[str, Any]]" = self.facts["results"]
        self.runs: "list[dict[str, Any]]" = self.facts["runs"]

    def _read(self) -> "dict[str, Any]":
        path = self.folder / "study.json"
        try:
            facts = json.loads(path.read_text(encoding="utf-8"))
            for run in facts["runs"]:  # a scheduler may have run them since
                run["state"] = self._state(run)
            return {"parameters": [], "results": [], "plots": [], **facts}
        except (OSError, ValueError, KeyError, TypeError):
            raise ResultsError(f"{self.folder}: is no study's; give the folder that furrow study was given with -o") from None

    def _state(self, run: "dict[str, Any]") -> str:
        try:
            ended = str(json.loads((self.folder / "runs" / run["folder"] / "run.json").read_text(encoding="utf-8")).get("ended"))
        except (OSError, ValueError):
            return str(run["state"])
        return ended if ended in ("interrupted", "failed") else "complete"

    def cells(self, run: "dict[str, Any]", tells: bool = True) -> "list[Cell]":
        """What a run gave for each result. `tells`: notes say what it lacks. ResultsError: it cannot have such a result."""
        folder = self.folder / "runs" / run["folder"]
        cells = {result["name"]: Cell() for result in self.results}
        if any("run" in result for result in self.results):
            try:
                facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
            except (OSError, ValueError):
                raise OSError(f"runs/{run['folder']}/run.json: cannot be read; run the study again") from None
            cells.update((result["name"], _of_json(result, facts)) for result in self.results if "run" in result)
        for source in ("objects", "vehicles"):
            own = [result for result in self.results if source in result]
            for result, figure in zip(own, _columns(own, source, folder / f"{source}.csv") if own else []):
                if figure.count > 0:
                    cells[result["name"]] = figure.cell(result["take"])
                elif tells:
                    print(f"furrow: note: run {run['folder']} has no row of {result['of']} for {result['name']}: its cell is empty", file=sys.stderr)
        return [cells[result["name"]] for result in self.results]

    def table(self) -> "list[list[Cell]]":
        """The results of all runs; those of runs that are not complete are empty."""
        return [self.cells(run) if run["state"] == "complete" and self.results else [Cell() for _ in self.results] for run in self.runs]


def study(folder: Path) -> Any:
    """The table of a study as a pandas.DataFrame: folder, state, values, results; its index is the run's number. Values and results that are numbers are numbers.

    `folder`: what `furrow study` was given with -o. _command.Missing: there is no pandas. ResultsError: it is no study's, or its runs lack a result.
    """
    pandas = _command.need("pandas", "pandas")
    own = Study(folder)
    columns: "dict[str, list[Any]]" = {"folder": [run["folder"] for run in own.runs], "state": [run["state"] for run in own.runs]}
    for name in own.parameters:
        columns[name] = [run["values"][name] for run in own.runs]
    table = own.table()
    for i, result in enumerate(own.results):
        columns[result["name"]] = [row[i].text or None for row in table]
    for name in [*own.parameters, *(result["name"] for result in own.results)]:
        numbers = [math.nan if text is None else _command.number(text) for text in columns[name]]
        if None not in numbers:
            columns[name] = numbers
    return pandas.DataFrame(columns, index=pandas.Index(range(1, len(own.runs) + 1), name="run"))


# --- what is written ---

def _csv_cell(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(char in text for char in ',"\n\r') else text


def _write_table(own: Study, table: "list[list[Cell]]") -> None:
    lines = [["run", "folder", "state", *own.parameters, *(result["name"] for result in own.results)]]
    for number, (run, cells) in enumerate(zip(own.runs, table), 1):
        lines.append([str(number), run["folder"], run["state"], *(run["values"][name] for name in own.parameters), *(cell.text for cell in cells)])
    with _command.Whole(own.folder / "study.csv") as path:
        path.write_bytes("".join(",".join(map(_csv_cell, line)) + "\n" for line in lines).encode("utf-8", "replace"))


def _plot_path(own: Study, plot: "dict[str, str]") -> pathlib.Path:
    """DIR/RESULT-over-X-by-Y.svg"""
    names = [plot[key].encode()[:40] for key in ("y", "x", "by") if key in plot]
    name = b"-over-".join(names[:2]) + (b"-by-" + names[2] if len(names) > 2 else b"")
    return own.folder / ("".join(chr(byte) if chr(byte).isalnum() and byte < 128 or byte in b"._-" else "_" for byte in name) + ".svg")


def collect(folder: Path, facts: "dict[str, Any] | None" = None) -> "list[pathlib.Path]":
    """Writes study.csv and the plots. Returns the plots' paths. `facts`: what study.json would say; None: it is read.

    Without matplotlib a note says that nothing is drawn, and no older plot of these names stays. ResultsError, OSError.
    """
    own = Study(folder, facts)
    table = own.table()
    _write_table(own, table)
    paths = []
    for plot in own.facts["plots"]:
        path = _plot_path(own, plot)
        y = [result["name"] for result in own.results].index(plot["y"])
        try:
            text = _study_plot.draw(own.facts, plot, [row[y].number for row in table])
        except _command.Missing as error:
            print(f"furrow: note: {own.folder}: no plot is drawn: {error}", file=sys.stderr)
            for other in own.facts["plots"]:
                _plot_path(own, other).unlink(missing_ok=True)
            return []
        with _command.Whole(path) as whole:
            whole.write_text(text, encoding="utf-8", errors="replace")
        paths.append(path)
    return paths


def main(arguments: "list[str]") -> int:
    """A part of the command: `collect DIR` or `check DIR RUN`, with the text of study.json on the standard input. Returns its status."""
    def work() -> None:
        facts = json.loads(sys.stdin.buffer.read().decode("utf-8", "replace"))
        if arguments[0] == "check":
            Study(arguments[1], facts).cells(facts["runs"][int(arguments[2]) - 1], tells=False)
            return
        plots = collect(arguments[1], facts)
        complete = sum(run["state"] == "complete" for run in facts["runs"])
        print(f"{complete} of {len(facts['runs'])} runs are complete: {arguments[1]}/study.csv" + (f", and {len(plots)} plots" if facts["results"] else ""))

    return _command.end("study", work, whole=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
