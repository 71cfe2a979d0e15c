"""Pieces of a page, which page.html writes: a section is a list of them."""
import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Union

from furrow.report.run import Report


class Number(NamedTuple):
    """A cell: what is shown, and all digits."""
    text: str
    value: str


class Place(NamedTuple):
    """A cell with a place, or where a camera looked. wide: it needs room."""
    text: str
    wide: bool = False


Cell = Union[str, Number, Place, None]  # None: nothing is known


@dataclass
class Block:
    """kind: p, small, table, legend, plots, wide, figure, map, svg, details, thumbs, numbers. The other members are what that kind has."""
    kind: str
    text: Any = ""
    items: "list[Any]" = field(default_factory=list)
    head: "list[Any]" = field(default_factory=list)


@dataclass
class Section:
    id: str
    title: str
    blocks: "list[Block]"


def number(value: float, unit: float = 1) -> Cell:
    """Five digits, of the value in a unit."""
    if not math.isfinite(value):
        return None
    shown = value / unit
    whole = shown == math.floor(shown) and abs(shown) < 1e15
    return Number(f"{0 if shown == 0 else shown:{'.0f' if whole else '.5g'}}", f"{value:.17g}")


def short(value: float) -> Cell:
    """Four digits."""
    return Number(f"{0 if value == 0 else value:.4g}", f"{value:.17g}") if math.isfinite(value) else None


def any_value(value: Any, unit: float = 1) -> Cell:
    """A value of run.json."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value, unit)
    return value if isinstance(value, str) else None


def sentence(report: Report, run: "Union[int, None]", text: str, kind: str = "p") -> Block:
    """A paragraph of one sentence; with several drives it begins with the folder."""
    named = f"{report.runs[run].folder}: {text}" if run is not None and report.several else text
    return Block(kind, named if named.endswith(".") else named + ".")


def small(text: Any) -> Block:
    return Block("small", text)


def table(head: "list[Any]", rows: "list[tuple[str, list[Cell]]]") -> Block:
    return Block("table", head=head, items=rows)


def folders(report: Report, corner: str) -> "list[Any]":
    """The head of a table with a column for each folder."""
    return [corner, *(run.folder for run in report.runs)]


def legend(items: "list[tuple[int, int, str]]") -> Block:
    """Each has colour, dash and name."""
    return Block("legend", items=items)
