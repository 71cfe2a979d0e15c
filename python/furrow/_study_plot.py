"""A plot of a study: one parameter across, a result up, a colour for each value of a second parameter.

A pale dot is a run. The line joins the means of the runs with the same value across. A bar goes from the lowest to the highest of them: what all other
parameters make of it. A parameter with many values is cut into parts of equal width, as a hypercube's are.
"""
import math
from typing import Any

from furrow import _command, _svg

GROUPS, SERIES = 24, 8        # different values, at most; tools/study_results.c has them, too
PARTS, SERIES_PARTS = 8, 3    # that a range is cut into
BESIDE = 3                    # pixels between the bars of two series


class _Groups:
    """The values of a parameter, sorted into groups: each value a group, or parts of equal width."""

    def __init__(self, facts: "dict[str, Any]", name: str, most: int, parts: int) -> None:
        parameter = next(each for each in facts["parameters"] if each["name"] == name)
        values = [run["values"][name] for run in facts["runs"]]
        numbers = [_command.number(value) for value in values]
        self.text = None in numbers
        self.cut = False
        self.names: "list[Any]" = list(dict.fromkeys(values if self.text else numbers))
        if self.text:
            self.log, self.low, self.high = False, 0.0, float(len(self.names) - 1)
            self.at = [float(self.names.index(value)) for value in values]
            self.edges = [float(i) for i in range(len(self.names))]
            return
        self.low, self.high = min(self.names), max(self.names)
        self.log = parameter["scale"] == "log" and self.low > 0
        self.at = [self.scaled(number) for number in numbers]
        self.edges = [self.scaled(value) for value in self.names]
        if parameter["range"] or len(self.names) > most:  # each run of a hypercube has a value of its own
            self.cut, count = True, parts if self.low < self.high else 1
            low, high = self.scaled(self.low), self.scaled(self.high)
            self.edges = [low + (high - low) * i / count for i in range(count)]

    def scaled(self, value: "float | None") -> float:
        """Where a value is on the axis."""
        assert value is not None
        return math.log10(value) if self.log else value

    def group(self, run: int) -> int:
        """The group of a run's value."""
        if not self.cut:
            return self.edges.index(self.at[run])
        return max(i for i, edge in enumerate(self.edges) if i == 0 or edge <= self.at[run])

    def label(self, i: int) -> str:
        if self.text:
            return _svg.plain(self.names[i], 26)
        if not self.cut:
            return f"{self.names[i]:g}"
        edges = [10 ** edge if self.log else edge for edge in self.edges] + [self.high]
        return f"{edges[i]:.3g} to {edges[i + 1]:.3g}"


def _mark_across(axes: Any, groups: _Groups, name: str) -> None:
    axes.set_xlabel(_svg.plain(name))
    if groups.text:
        axes.set_xticks(range(len(groups.names)), [groups.label(i) for i in range(len(groups.names))])
        axes.set_xlim(-0.5, len(groups.names) - 0.5)
    elif groups.log:
        low, high = groups.scaled(groups.low), groups.scaled(groups.high)
        edge = max((high - low) * 0.04, 0.02)
        low, high = low - edge, high + edge
        digits = [1] if high - low > 3 else [1, 2, 5] if high - low > 0.7 else list(range(1, 10))
        ticks = [digit * 10.0 ** power for power in range(math.floor(low), math.ceil(high) + 1) for digit in digits]
        ticks = [tick for tick in ticks if low <= math.log10(tick) <= high]
        axes.set_xticks([math.log10(tick) for tick in ticks], [f"{tick:g}" for tick in ticks])
        axes.set_xlim(low, high)
    else:
        lines = _svg.steps(groups.low, groups.high)
        axes.set_xticks(lines, [f"{0 if abs(line) < 1e-6 * (lines[-1] - lines[0]) else line:g}" for line in lines])
        axes.set_xlim(lines[0], lines[-1])


def _draw_series(axes: Any, dots: "list[tuple[int, float, float]]", number: int, shift: Any, joined: bool) -> None:
    """dots: of each run its group, and where it is."""
    colour = _svg.COLOURS[number % SERIES]
    runs = axes.scatter([x for _, x, _ in dots], [y for _, _, y in dots], s=36, color=colour, alpha=0.35, linewidths=0, transform=shift, clip_on=False)
    runs.set_gid(f"runs-of-{number}")
    means = []
    for group in sorted({group for group, _, _ in dots}, key=lambda group: min(x for g, x, _ in dots if g == group)):
        xs, ys = [x for g, x, _ in dots if g == group], [y for g, _, y in dots if g == group]
        means.append((sum(xs) / len(xs), sum(ys) / len(ys), min(ys), max(ys)))
    bars = [mean for mean in means if mean[3] > mean[2]]
    axes.plot([x for x, *_ in bars for _ in range(3)], [y for _, _, low, high in bars for y in (low, high, math.nan)], color=colour, alpha=0.7, linewidth=1.5,
              transform=shift, solid_capstyle="butt", clip_on=False)
    axes.plot([x for x, *_ in bars for _ in range(2)], [y for _, _, low, high in bars for y in (low, high)], linestyle="none", marker="_", markersize=8, color=colour,
              alpha=0.7, markeredgewidth=1.5, transform=shift, clip_on=False)
    axes.plot([x for x, *_ in means], [y for _, y, *_ in means], color=colour, linewidth=2, linestyle="-" if joined else "none", marker="o", markersize=8,
              markeredgewidth=0, transform=shift, clip_on=False)[0].set_gid(f"means-of-{number}")


def draw(facts: "dict[str, Any]", plot: "dict[str, str]", numbers: "list[float]") -> str:
    """The plot as SVG. `facts`: study.json. `plot`: x, y and maybe by. `numbers`: the result of each run; nan: it has none. Missing: there is no matplotlib."""
    count = len(facts["runs"])
    parts = 1 if count < 8 else count // 4 if count < 4 * PARTS else PARTS
    across = _Groups(facts, plot["x"], GROUPS, parts)
    series = _Groups(facts, plot["by"], SERIES, SERIES_PARTS) if "by" in plot else None
    kinds = len(series.edges) if series else 1
    with _svg.look():
        offset = _command.need("matplotlib.transforms", "matplotlib").ScaledTranslation
        fig = _svg.figure(860, 470)
        axes = _svg.axes(fig, 80, 46, 540, 350)
        _svg.titled(axes, _svg.plain(plot["y"]))
        known = [number for number in numbers if math.isfinite(number)]
        _svg.ruled(axes, "y", _svg.steps(min(known, default=math.inf), max(known, default=-math.inf)))
        _mark_across(axes, across, plot["x"])
        for kind in range(kinds):
            beside = (kind / (kinds - 1) - 0.5) * 0.5 if across.text and kinds > 1 else 0
            dots = [(across.group(run), across.at[run] + beside, numbers[run]) for run in range(count)
                    if math.isfinite(numbers[run]) and (series is None or series.group(run) == kind)]
            pixels = 0 if across.text else (kind - (kinds - 1) / 2) * BESIDE
            _draw_series(axes, dots, kind, axes.transData + offset(pixels / 72, 0, fig.dpi_scale_trans), not across.text)
        if series:
            entries = [({"color": _svg.COLOURS[kind % SERIES], "marker": "o", "markersize": 8, "markeredgewidth": 0, "linestyle": "none"}, series.label(kind)) for kind in range(kinds)]
            _svg.keys(fig, 646, 46, entries, _svg.plain(plot["by"], 26))
        _svg.at(fig, 80, 458, "dots: runs; line: means; bars: lowest to highest")
        return _svg.written(fig)
