"""One page of a drive, or of up to eight beside each other: `furrow report DIR... -o report.html`, or furrow.report("out", to="report.html").

The page is one HTML file: it needs no network, and no file beside it. docs/REPORT.md tells what it has. It needs the packages jinja2, matplotlib and pandas.
"""
import logging
import os
import pathlib
import sys
import types
from typing import Any, Union

from furrow import _command
from furrow.results import ResultsError

Path = Union[str, "os.PathLike[str]"]
RUNS = 8
# As pip and Debian name them.
NEEDED = {"numpy": "python3-numpy", "pandas": "python3-pandas", "jinja2": "python3-jinja2", "matplotlib": "python3-matplotlib"}


def _need() -> None:
    """Missing: packages are not installed; one line names all of them."""
    missing = []
    for name in NEEDED:
        try:
            __import__(name)
        except ImportError:
            missing.append(name)
    if missing:
        debian = " ".join(NEEDED[name] for name in missing)
        raise _command.Missing(f"{sys.executable} has no {', '.join(missing)}: a report needs {'it' if len(missing) == 1 else 'them'}; apt install {debian}, or {sys.executable} -m pip install {' '.join(missing)}")


def write(folders: "list[Path]", to: Path) -> None:
    """Writes the page. The file is there when it is whole. ResultsError: a folder has no results, or they are damaged. _command.Missing: packages are not installed."""
    names = [os.fspath(folder) for folder in folders]
    if not 1 <= len(names) <= RUNS:
        raise ResultsError(f"{len(names)} folders cannot be one report: it has 1 to {RUNS}; give that many, or collect them with furrow study")
    if len(set(names)) < len(names):
        raise ResultsError(f"{', '.join(names)}: one of them is given twice; give each folder once")
    _need()
    from furrow.report import page
    text = page.html(names)
    with _command.Whole(pathlib.Path(to)) as beside:
        try:
            beside.write_text(text, encoding="utf-8")
        except OSError as error:
            raise OSError(f"{to}: {error.strerror}; give a place that has room and can be written") from None


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("report", "One page of a drive, or of several beside each other: see furrow report --help.")
    parser.add_argument("folders", metavar="DIR", nargs="+")
    parser.add_argument("-o", "--output", metavar="FILE.html", required=True)
    given = parser.parse_args(arguments)

    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # that it has no place to keep its list of fonts is nothing to tell

    def work() -> None:
        write(given.folders, given.output)
        print(f"{given.output}: {len(given.folders)} drive{'' if len(given.folders) == 1 else 's'}")

    return _command.end("report", work)


class _Callable(types.ModuleType):
    """furrow.report is this module, and it is called, too."""

    def __call__(self, *folders: Path, to: Path = "report.html") -> pathlib.Path:
        """Writes a page of one drive, or of up to eight beside each other. Returns its path.

        folders: what furrow drive -o wrote. to: the page. furrow.results.ResultsError: a folder has no results, or they are damaged.
        """
        write(list(folders), to)
        return pathlib.Path(to)


sys.modules[__name__].__class__ = _Callable
