"""Plots of a page: matplotlib draws them, and what it writes becomes SVG within the page, whose classes give colours, so that they suit its light.

A plot has 520 x 320 units and no size of its own: the page stretches it. Of a line with more points than pixels it draws the least and the largest value of each pixel across, so a page stays
small whatever the drive's length.
"""
import io
import math
import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from typing import Any, Union

import matplotlib
import numpy as np
from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from furrow import _svg

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 520, 320, 64, 12, 30, 46
MAP_DOWN = 430         # a map has more room
WAY_POINTS = 3000
NUMBER_MOST = 1e30     # larger numbers are none that a drive has, and differences of them may overflow
NUMBER_LEAST = 1e-30   # of a logarithmic axis; a linear axis takes less for 0
NARROW = 1e-6          # of the numbers: a range that is narrower is widened
DASHES = ("", "7 4", "2 3", "10 3 2 3")
COLOURS = 8
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "furrow", "axes.unicode_minus": False, "path.simplify": False, "font.size": 12}


@dataclass
class Line:
    """x and y, nan in y: a gap. steps: y[i] holds from x[i] to x[i + 1], with an area below it. dots: a dot at each point, and only `dots="alone"` has no line. begins: a dot at the first."""
    x: "np.ndarray"
    y: "np.ndarray"
    colour: int = 0
    dash: int = 0
    steps: bool = False
    dots: Union[bool, str] = False
    begins: bool = False

    def any(self) -> bool:
        return bool((_numbers(self.x) & _numbers(self.y)).any())


@dataclass
class Plot:
    """title; names of the axes with their units; lines, the first on top. zero: the upward axis has 0. logarithmic: across. one_scale: both axes have one, and lines go anywhere. low, high: the
    upward axis has no more. upright: a dashed line at this x, which `told` names. ground: of a map, (png, low, high): a picture, and its edges."""
    title: str
    across: str
    up: str
    lines: "list[Line]" = field(default_factory=list)
    zero: bool = True
    logarithmic: bool = False
    one_scale: bool = False
    low: float = 0.0
    high: float = 0.0
    upright: float = math.nan
    told: str = ""
    ground: "Any" = None


def _numbers(values: "np.ndarray") -> "np.ndarray":
    with np.errstate(invalid="ignore"):
        return np.abs(values) < NUMBER_MOST


# --- axes ---

def _part(low: float, high: float) -> "tuple[float, float]":
    """A range, wide enough for the digits of its numbers."""
    size = max(abs(low), abs(high))
    if size < NUMBER_LEAST:
        return 0.0, 0.0
    return (low - NARROW * size, high + NARROW * size) if high - low < NARROW * size else (low, high)


class _Axes:
    """The ends of both axes (across: log10 of them, if it is logarithmic), their steps, and the area in units of the plot."""

    def __init__(self, plot: Plot) -> None:
        self.plot = plot
        self.left, self.top, self.wide, self.tall = float(LEFT), float(TOP), float(WIDTH - LEFT - RIGHT), float(MAP_DOWN if plot.one_scale else HEIGHT - TOP - BOTTOM)
        self.low, self.high, self.step = [math.inf, math.inf], [-math.inf, -math.inf], [1.0, 1.0]
        for line in plot.lines:
            drawn = self.drawn(line)
            if drawn.any():
                for k, values in enumerate((self.scale(line.x[drawn]), line.y[drawn])):
                    self._widen(k, float(values.min()), float(values.max()))
        if self.has_upright:
            self._widen(0, *[float(self.scale(np.array([plot.upright]))[0])] * 2)
        self._find()

    @property
    def has_upright(self) -> bool:
        return abs(self.plot.upright) < NUMBER_MOST and (not self.plot.logarithmic or self.plot.upright > NUMBER_LEAST)

    def drawn(self, line: Line) -> "np.ndarray":
        found = _numbers(line.x) & _numbers(line.y)
        return found & (line.x > NUMBER_LEAST) if self.plot.logarithmic else found

    def scale(self, x: "np.ndarray") -> "np.ndarray":
        with np.errstate(all="ignore"):
            return np.log10(x) if self.plot.logarithmic else x

    def _widen(self, k: int, low: float, high: float) -> None:
        self.low[k], self.high[k] = min(self.low[k], low), max(self.high[k], high)

    def _find(self) -> None:
        plot, low, high = self.plot, self.low, self.high
        if plot.low < plot.high:
            low[1], high[1] = (min(max(value, plot.low), plot.high) for value in (low[1], high[1]))
        if plot.zero:
            self._widen(1, 0, 0)
        if plot.one_scale:  # a square at least a metre wide, so that a straight way has an area
            side = max(max(high[0] - low[0], high[1] - low[1]) * 0.25, 1)
            for k in range(2):
                more = max(side - (high[k] - low[k]), 0) / 2
                low[k], high[k] = low[k] - more, high[k] + more
        for k in range(1 if plot.logarithmic else 0, 2):
            low[k], high[k] = _part(low[k], high[k])
        if plot.ground is not None:
            for k in range(2):
                low[k], high[k] = plot.ground[1][k], plot.ground[2][k]
                self.step[k] = _svg.step((high[k] - low[k]) / 7)
        else:
            low[1], high[1], self.step[1] = _svg.axis(low[1], high[1])
            if not plot.logarithmic:
                low[0], high[0], self.step[0] = _svg.axis(low[0], high[0])
            elif high[0] - low[0] < 0.1:
                self._widen(0, low[0] + 0.1, low[0] + 0.1)
        if plot.one_scale:
            wide, tall = high[0] - low[0], high[1] - low[1]
            unit = min(self.wide / wide, self.tall / tall)
            self.left += (self.wide - unit * wide) / 2
            self.wide, self.tall = unit * wide, unit * tall

    def place(self, x: "np.ndarray", y: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
        """In units of the plot, y down."""
        held = np.clip(y, self.low[1], self.high[1])
        return (self.left + self.wide * (self.scale(x) - self.low[0]) / (self.high[0] - self.low[0]), self.top + self.tall * (self.high[1] - held) / (self.high[1] - self.low[1]))

    def ticks(self, k: int) -> "list[tuple[float, str]]":
        """Where, and the number there."""
        if k == 0 and self.plot.logarithmic:
            return self._logarithmic_ticks()
        first = math.ceil(self.low[k] / self.step[k] - 1e-6) * self.step[k]
        steps = int(math.floor((self.high[k] - first) / self.step[k] + 1e-6))
        room = (self.wide / 30 if k == 0 else self.tall / 14) / max(steps, 1)
        every = 4 if room < 0.5 else 2 if room < 1 else 1  # numbers stay apart
        values = [first + i * self.step[k] for i in range(0, steps + 1, every)]
        return [(value, f"{0 if abs(value) < self.step[k] * 1e-6 else value:g}") for value in values]

    def _logarithmic_ticks(self) -> "list[tuple[float, str]]":
        wide, found = self.high[0] - self.low[0], []
        every = max(math.ceil(wide / 8), 1)
        for power in range(math.floor(self.low[0]), math.floor(self.high[0]) + 1, every):
            for i in range(1, 10):
                at = power + math.log10(i)
                if self.low[0] - 1e-9 <= at <= self.high[0] + 1e-9 and not (i > 1 and wide > 3) and (i in (1, 2, 5) or wide <= 0.8):
                    found.append((at, f"{i * 10.0 ** power:g}"))
        return found


# --- lines ---

def _thin(x: "np.ndarray", y: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
    """Of each pixel across the least and the largest point, in their order. nan in y: a gap."""
    if len(x) <= 1.5 * WIDTH:
        return x, y
    gap = np.isnan(y)
    column = np.where(gap, -1, np.floor(np.where(gap, 0, x)))
    begins = np.flatnonzero(np.r_[True, column[1:] != column[:-1]])
    kept: "list[int]" = []
    for begin, end in zip(begins.tolist(), [*begins[1:].tolist(), len(x)]):
        least, most = begin + int(y[begin:end].argmin()), begin + int(y[begin:end].argmax())
        kept += [least] if least == most else sorted((least, most))
    return x[kept], y[kept]


def _thin_way(x: "np.ndarray", y: "np.ndarray", apart: float) -> "list[int]":
    """Places of points that are at least `apart` from the last one, of gaps, and of the end."""
    kept, last = [], None
    xs, ys = x.tolist(), y.tolist()
    for i, (px, py) in enumerate(zip(xs, ys)):
        if py != py:
            kept.append(i)
            last = None
        elif last is None or i + 1 == len(xs) or math.hypot(px - xs[last], py - ys[last]) >= apart:
            kept.append(i)
            last = i
    return kept


def _shape(axes: _Axes, line: Line) -> "tuple[np.ndarray, np.ndarray]":
    """The points that are drawn, nan in y where the line begins again."""
    drawn = axes.drawn(line)
    x, y = axes.place(np.where(drawn, line.x, 1.0), np.where(drawn, line.y, 0.0))
    y = np.where(drawn, y, np.nan)
    if line.steps:
        return np.repeat(x, 2)[1:-1], np.repeat(y[:-1], 2)
    if not axes.plot.one_scale:
        return _thin(x, y)
    apart = 0.7
    kept = _thin_way(x, y, apart)
    while len(kept) > WAY_POINTS and apart < WIDTH:
        apart *= 1.5
        kept = _thin_way(x, y, apart)
    return x[kept], y[kept]


class _Sheet:
    """One matplotlib figure, taken again for each plot: making axes costs more than drawing them."""

    def __init__(self) -> None:
        self.figure = Figure(dpi=72)
        self.figure.patch.set_visible(False)
        self.canvas = FigureCanvasSVG(self.figure)
        self.axes = self.figure.add_axes([0, 0, 1, 1])
        self.axes.patch.set_visible(False)
        for spine in self.axes.spines.values():
            spine.set_visible(False)
        self.axes.tick_params(bottom=False, left=False, pad=5)
        self.axes.set_axisbelow(True)
        self.axes.grid(True)

    def draw(self, axes: _Axes) -> str:
        """Draws a plot and returns what matplotlib writes. Data are in units of the plot."""
        height = TOP + axes.tall + BOTTOM
        own, plot = self.axes, axes.plot
        self.figure.set_size_inches(WIDTH / 72, height / 72, forward=False)
        own.set_position([axes.left / WIDTH, 1 - (axes.top + axes.tall) / height, axes.wide / WIDTH, axes.tall / height])
        own.set_xlim(axes.left, axes.left + axes.wide)
        own.set_ylim(axes.top + axes.tall, axes.top)
        for k, axis in enumerate((own.xaxis, own.yaxis)):
            ticks = axes.ticks(k)
            side, low, length = (axes.left, axes.low[k], axes.wide) if k == 0 else (axes.top, axes.high[k], -axes.tall)
            axis.set_ticks([side + abs(length) * (value - low) / (axes.high[k] - axes.low[k]) * (1 if k == 0 else -1) for value, _ in ticks], labels=[text for _, text in ticks])
            for tick, (_, text) in zip(axis.get_major_ticks(), ticks):
                tick.gridline.set_gid("zero" if text == "0" else "grid")
                tick.gridline.set_clip_on(False)
        for line in [*own.lines, *own.texts]:
            line.remove()
        for line in reversed(plot.lines):  # the first lies on top
            self._line(axes, line)
        own.text(axes.left + axes.wide / 2, axes.top + axes.tall + 34, plot.across, ha="center", parse_math=False)
        own.text(min(axes.left, LEFT) - 6, TOP - 12, plot.up, gid="name", parse_math=False)
        if axes.has_upright:
            x = float(axes.place(np.array([plot.upright]), np.zeros(1))[0][0])
            left = x > axes.left + axes.wide / 2
            own.plot([x, x], [axes.top, axes.top + axes.tall], gid="mark", clip_on=False)
            own.text(x + (-5 if left else 5), axes.top + 13, plot.told, ha="right" if left else "left", parse_math=False)
        out = io.StringIO()
        self.canvas.print_svg(out, metadata={"Date": None})
        return out.getvalue()

    def _line(self, axes: _Axes, line: Line) -> None:
        own, colour = self.axes, line.colour % COLOURS
        x, y = _shape(axes, line)
        if line.steps:
            bottom = float(axes.place(np.ones(1), np.zeros(1))[1][0])
            own.plot(np.r_[x[:1], x, x[-1:]], np.r_[bottom, y, bottom], gid=f"area f{colour}", clip_on=False)
        if axes.plot.ground is not None and not line.dots:  # so that it is seen on any ground
            own.plot(x, y, gid="halo", clip_on=False)
        if line.dots != "alone":
            own.plot(x, y, gid=f"curve s{colour} dash{line.dash % len(DASHES)}", clip_on=False)
        known = ~np.isnan(y)
        if line.begins and known.any():
            own.plot(x[known][:1], y[known][:1], "o", gid=f"begin f{colour}", clip_on=False)
        if line.dots:
            own.plot(x[known], y[known], "o", gid=f"dot f{colour}", clip_on=False)


_sheets: "list[_Sheet]" = []
_SVG, _LINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
_PATH = re.compile(r"([MLzZ])\s*([-\d.]*)\s*([-\d.]*)\s*")


def _round(value: str) -> str:
    return f"{float(value):.1f}"


def _path(text: str) -> str:
    """A path of matplotlib, shorter: a tenth of a unit is the last digit."""
    return "".join(f"{kind}{_round(x)} {_round(y)}" if x else kind for kind, x, y in _PATH.findall(text))


def _walk(node: Any, name: str, out: "list[str]") -> None:
    """Takes what is seen of matplotlib's SVG. Names of groups become classes, and style sheets and ids go."""
    for child in node:
        tag = child.tag.replace(_SVG, "")
        if tag == "g":
            own = child.get("id", "")
            _walk(child, own if own in ("grid", "zero", "mark", "halo", "name") or own.split(" ")[0] in ("curve", "area", "begin", "dot") else name, out)
        elif tag == "path" and name and child.get("d"):
            words, dash = name, ""
            if " dash" in name:
                words, _, number = name.partition(" dash")
                dash = f' stroke-dasharray="{DASHES[int(number)]}"'
            out.append(f'<path class="{words}"{dash} d="{_path(child.get("d"))}{"Z" if name.startswith("area") else ""}"/>\n')
        elif tag == "use":
            kind, _, colour = name.partition(" ")
            out.append(f'<circle class="{colour}{" begin" if kind == "begin" else ""}" cx="{_round(child.get("x"))}" cy="{_round(child.get("y"))}" r="{4 if kind == "begin" else 2.5}"/>')
        elif tag == "text":
            anchor = re.search(r"text-anchor: (\w+)", child.get("style", ""))
            x, y = child.get("x"), child.get("y")
            out.append(f'<text{" class=" + chr(34) + "name" + chr(34) if name == "name" else ""} x="{_round(x)}" y="{_round(y)}" text-anchor="{anchor[1] if anchor else "start"}">{escape(child.text or "")}</text>\n')


def draw(plot: Plot) -> Markup:
    """The plot as SVG for a page."""
    axes = _Axes(plot)
    with matplotlib.rc_context(STYLE):
        if not _sheets:
            _sheets.append(_Sheet())
        text = _sheets[0].draw(axes)
    root = xml.fromstring(text)
    out = [f'<svg role="img"{" class=" + chr(34) + "map" + chr(34) if plot.ground is not None else ""} viewBox="0 0 {WIDTH} {TOP + axes.tall + BOTTOM:.0f}"><title>{escape(plot.title)}</title>\n']
    if plot.ground is not None:
        out.append(f'<image x="{axes.left:.2f}" y="{axes.top:.2f}" width="{axes.wide:.2f}" height="{axes.tall:.2f}" preserveAspectRatio="none" href="data:image/png;base64,{plot.ground[0]}"/>'
                   f'<path class="edge" d="M{axes.left:.2f} {axes.top:.2f}h{axes.wide:.2f}v{axes.tall:.2f}h{-axes.wide:.2f}z"/>\n')
    _walk(root, "", out)
    out.append("</svg>\n")
    return Markup("".join(out))
