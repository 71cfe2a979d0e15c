"""Plots of `furrow rig` and `furrow cache-sim`, as SVG texts.

    import furrow.plot
    open("rig.svg", "w").write(furrow.plot.rig("bench"))            # the folder that furrow rig -o wrote
    told = json.loads(subprocess.check_output(["furrow", "cache-sim", "trace", "--json"]))
    open("misses.svg", "w").write(furrow.plot.cache(told, "my drive"))

They need matplotlib, and no library of Furrow. _command.Missing: it is not installed.
"""
import csv
import json
import math
import os
import pathlib
import sys
from typing import Any, Callable, Union

from furrow import _command, _svg

DASHES = ["-", (0, (7, 4)), (0, (2, 3)), (0, (10, 3, 2, 3))]
SAME_ANGLE = 0.5  # degrees: by how much measured slip angles of one setting differ at most

# --- furrow rig ---

# Seven marks and six colours: no two of 42 curves have both the same.
MARKS, HUES = ["o", "s", "^", "D", "v", ">", "<"], _svg.COLOURS[:6]
FIGURES = [("sinkage, mm", "sinkage", 1e3), ("drawbar pull, N", "drawbar", 1.0), ("side force, N", "side", 1.0), ("torque, N m", "torque", 1.0),
           ("efficiency", "efficiency", 1.0), ("force against the way, N", "against", 1.0)]


def _number(value: Any) -> float:
    return math.nan if value is None or value == "" else float(value)


def _distinct(values: "list[Any]") -> "list[Any]":
    """In the order in which they first come. Numbers that are none are left out."""
    return list(dict.fromkeys(value for value in values if value == value))


class _Rig:
    """What is drawn over what: over the slip; of an object without one over its angle if it has several, else over its load or depth."""

    def __init__(self, told: "dict[str, Any]") -> None:
        self.rows = [{key: value if key in ("soil", "state") else _number(value) for key, value in row.items()} for row in told["rows"]]
        self.soils = _distinct([row["soil"] for row in self.rows])
        self.angles = _distinct([row["slip_angle"] for row in self.rows]) or [0.0]
        self.deep = any(row.get("depth", math.nan) == row.get("depth", math.nan) for row in self.rows)
        self.presses = "depth" if self.deep else "load"
        self.loads = _distinct([row[self.presses] for row in self.rows])
        self.belt = bool(told.get("belt"))
        self.slips = any(math.isfinite(row["slip"]) or math.isfinite(row["torque"]) for row in self.rows)
        self.locks = any(row["slip"] < -1 for row in self.rows)
        self.turned = any(self.angles)
        self.over = "slip" if self.slips else "angle" if len(self.angles) > 1 else "load"
        self.measured = [{key: _number(value) for key, value in row.items()} for row in told.get("measured", [])] if self.slips else []

    def slip(self, slip: float) -> float:
        """A slip as it is drawn: if a wheel turns by less than half of its way, those that are braked go from 0 to -1, which is a locked one."""
        return slip / (1 - slip) if slip < 0 and self.locks else slip

    def across(self, row: "dict[str, Any]") -> float:
        if self.over == "slip":
            return self.slip(row["slip"])
        return float(row["slip_angle"]) if self.over == "angle" else row[self.presses] * (1e3 if self.deep else 1)

    def name(self) -> str:
        if self.over == "slip":
            return "slip; below 0: turn x radius / way - 1" if self.locks else "slip"
        return "angle from its way, degrees" if self.over == "angle" else "depth, mm" if self.deep else "load, N"

    def shown(self) -> "list[tuple[str, str, float]]":
        """The figures that these rows have."""
        force = not self.slips or self.deep
        wanted = [not self.deep, not force or self.turned, self.turned, self.slips, self.slips and not force, force]
        figures = [("pull of the belt, N", *rest) if self.belt and rest[0] == "torque" else (title, *rest) for title, *rest in FIGURES]
        return [figure for figure, want in zip(figures, wanted) if want and any(math.isfinite(row[figure[1]]) for row in self.rows)]

    def curves(self) -> "list[tuple[int, int, list[dict[str, Any]]]]":
        """Of each curve its colour and mark, its dash, and its rows in order along the axis."""
        found: "dict[tuple[int, int], list[dict[str, Any]]]" = {}
        for row in self.rows:
            angle = 0 if self.over == "angle" else self.angles.index(row["slip_angle"])
            colour = self.soils.index(row["soil"]) * (1 if self.over == "angle" else len(self.angles)) + angle
            found.setdefault((colour, 0 if self.over == "load" else self.loads.index(row[self.presses])), []).append(row)
        return [(colour, dash, sorted((row for row in rows if math.isfinite(self.across(row))), key=self.across)) for (colour, dash), rows in sorted(found.items())]

    def colour_of_trial(self, trial: "dict[str, float]") -> "str | None":
        """None: no setting has its angle."""
        for at, angle in enumerate(self.angles):
            if abs(trial["angle"] - angle) <= SAME_ANGLE:
                return HUES[at % len(HUES)] if len(self.angles) > 1 else _svg.TEXT
        return None


def _rig_panel(rig: _Rig, axes: Any, figure: "tuple[str, str, float]") -> None:
    title, key, unit = figure
    xs = [rig.across(row) for row in rig.rows if math.isfinite(rig.across(row))]
    ys = [row[key] * unit for row in rig.rows if math.isfinite(row[key])]
    trials = [(rig.slip(trial["slip"]), trial.get(key, math.nan) * unit, rig.colour_of_trial(trial)) for trial in rig.measured]
    if xs:
        ys += [y for x, y, _ in trials if math.isfinite(y) and min(xs) <= x <= max(xs)]
    lines = _svg.steps(min(xs, default=math.inf), max(xs, default=-math.inf))
    _svg.ruled(axes, "x", lines)
    _svg.ruled(axes, "y", _svg.steps(min([*ys, 0.0]), max(ys)))
    _svg.titled(axes, title)
    axes.set_xlabel(rig.name())
    for colour, dash, rows in rig.curves():
        hue, mark = HUES[colour % len(HUES)], MARKS[colour % len(MARKS)]
        axes.plot([rig.across(row) for row in rows], [row[key] * unit for row in rows], color=hue, linewidth=2, linestyle=DASHES[dash % len(DASHES)], clip_on=False)
        for steady in (True, False):
            own = [row for row in rows if (row["state"] == "steady") == steady]
            made, = axes.plot([rig.across(row) for row in own], [row[key] * unit for row in own], linestyle="none", marker=mark, markersize=6, color=hue,
                              markerfacecolor=hue if steady else "none", clip_on=False)
            made.set_gid(f"rows-{key}-{colour}-{dash}-{'steady' if steady else 'not-steady'}")
    for hue in _distinct([colour for _, _, colour in trials if colour]):
        own_trials = [(x, y) for x, y, colour in trials if colour == hue and math.isfinite(y) and lines[0] <= x <= lines[-1]]
        if not own_trials:
            continue
        made, = axes.plot([x for x, _ in own_trials], [y for _, y in own_trials], "o", markersize=6.4, color=_svg.TEXT, markerfacecolor=hue, zorder=3, clip_on=False)
        made.set_gid(f"measured-{key}-{hue[1:]}")


def _rig_keys(rig: _Rig) -> "list[tuple[dict[str, Any], str]]":
    entries: "list[tuple[dict[str, Any], str]]" = []
    each = 1 if rig.over == "angle" else len(rig.angles)
    for i in range(len(rig.soils) * each):
        text = _svg.plain(rig.soils[i // each], 22) + (f", {rig.angles[i % each]:g}°" if rig.turned and rig.over != "angle" else "")
        entries.append(({"color": HUES[i % len(HUES)], "linewidth": 2, "marker": MARKS[i % len(MARKS)], "markersize": 6}, text))
    if rig.over != "load":
        for i, load in enumerate(rig.loads):
            entries.append(({"color": _svg.ZERO, "linewidth": 2, "linestyle": DASHES[i % len(DASHES)]}, f"{load * 1e3:g} mm deep" if rig.deep else f"{load:g} N"))
    if rig.measured:
        entries.append(({"color": _svg.TEXT, "linestyle": "none", "marker": "o", "markersize": 6.4}, "measured"))
    entries.append(({"color": _svg.ZERO, "linestyle": "none", "marker": "o", "markersize": 6, "markerfacecolor": "none"}, "not steady"))
    return entries


def _rig_folder(folder: "Union[str, os.PathLike[str]]") -> "dict[str, Any]":
    path = pathlib.Path(folder) / "rig.csv"
    with open(path, newline="", encoding="utf-8") as file:
        return {"shape": str(folder), "rows": list(csv.DictReader(file))}


def rig(what: "Union[str, os.PathLike[str], dict[str, Any]]") -> str:
    """Sinkage, drawbar pull, torque and efficiency over slip, as SVG.

    `what`: what `furrow rig --json` printed, or the folder that it wrote, whose rig.csv does not tell the shape and the spacing. OSError: there is no rig.csv.
    """
    told = what if isinstance(what, dict) else _rig_folder(what)
    drawn = _Rig(told)
    figures = drawn.shown()
    with _svg.look():
        fig = _svg.figure(1190, 60 + (len(figures) + 1) // 2 * 350)
        spacing = f"; posts of {told['spacing'] * 1e3:g} mm" if told.get("spacing") else ""
        _svg.at(fig, 70, 24, _svg.plain(told["shape"]) + spacing, fontsize=15)
        for i, figure in enumerate(figures):
            _rig_panel(drawn, _svg.axes(fig, 70 + i % 2 * 470, 60 + i // 2 * 350, 390, 270), figure)
        _svg.keys(fig, 960, 60, _rig_keys(drawn))
        return _svg.written(fig)


# --- furrow cache-sim ---

POLICIES = {"lru": ("LRU", "#2a86c8", 1.4), "clock": ("CLOCK", "#e69f00", 2.8), "arc": ("ARC", "#009e73", 4.2), "s3fifo": ("S3-FIFO", "#cc79a7", 5.6),
            "opt": ("OPT", "#d55e00", 1.8)}
S3FIFO_LEAST = 20  # slots; with fewer every access is a miss, and the others would lie on the floor


def cache(told: "dict[str, Any]", title: str = "") -> str:
    """Misses over slots, as SVG: slots on a scale of powers of two, a line for each policy, and dashed the misses that no size avoids.

    `told`: what `furrow cache-sim --json` printed. `title`: of which drive.
    """
    curves = {name: [(slots, misses) for slots, misses in zip(told["slots"], one["misses"]) if name != "s3fifo" or slots >= S3FIFO_LEAST]
              for name, one in told["policies"].items()}
    most = max([told["tiles"], 1, *(misses for curve in curves.values() for _, misses in curve)])
    each = max(_svg.step(most / 5), 1)
    low, high = math.log2(told["slots"][0]), math.log2(told["slots"][-1])
    if high - low < 1:
        low, high = low - 0.5, high + 0.5
    with _svg.look():
        fig = _svg.figure(920, 500)
        axes = _svg.axes(fig, 100, 56, 640, 384)
        _svg.at(fig, 100, 26, "Misses by slots" + (f": {_svg.plain(title)}" if title else ""), fontsize=15)
        _svg.at(fig, 100, 44, f"{told['accesses']} accesses to {told['tiles']} tiles")
        axes.set_xscale("log", base=2)
        axes.grid(False, axis="x")
        axes.tick_params(axis="x", which="minor", bottom=False)
        axes.spines["bottom"].set(visible=True, color=_svg.TEXT)
        ticks = range(math.ceil(low), math.floor(high) + 1, max(math.ceil((high - low) / 10), 1))
        axes.set_xticks([2.0 ** power for power in ticks], [str(2 ** power) if power >= 0 else f"{2.0 ** power:g}" for power in ticks])
        axes.tick_params(axis="x", length=5, color=_svg.TEXT)
        axes.set_yticks([i * each for i in range(math.ceil(most / each) + 1)], [f"{i * each:.0f}" for i in range(math.ceil(most / each) + 1)])
        axes.set_xlim(2.0 ** low, 2.0 ** high)
        axes.set_ylim(0, each * math.ceil(most / each))
        axes.set_xlabel("slots")
        axes.set_ylabel("misses", labelpad=12)
        axes.axhline(told["tiles"], color=_svg.ZERO, linewidth=1, linestyle=(0, (5, 4)))
        entries: "list[tuple[dict[str, Any], str]]" = []
        for order, (name, curve) in enumerate(curves.items()):  # those that coincide lie upon one another like bands
            label, colour, wide = POLICIES[name]
            made, = axes.plot([slots for slots, _ in curve], [misses for _, misses in curve], color=colour, linewidth=wide, marker="o", markersize=wide + 2,
                              markeredgewidth=0, zorder=3 - order / 10, clip_on=False)
            made.set_gid(f"curve-{name}")
            entries.append(({"color": colour, "linewidth": wide}, label + (f" (from {S3FIFO_LEAST})" if len(curve) < len(told["slots"]) else "")))
        entries.append(({"color": _svg.ZERO, "linewidth": 1, "linestyle": (0, (5, 4))}, "first access"))
        _svg.keys(fig, 756, 56, entries)
        return _svg.written(fig)


# --- for the command ---

KINDS: "dict[str, Callable[[dict[str, Any]], str]]" = {"rig": rig, "cache": lambda told: cache(told, told.get("title", ""))}


def main(arguments: "list[str]") -> int:
    """Reads what is to be drawn as JSON on the standard input, and writes the SVG to the standard output. Returns 127 if a package is missing."""
    try:
        told = json.loads(sys.stdin.buffer.read().decode("utf-8", "replace"))
        sys.stdout.buffer.write(KINDS[arguments[0]](told).encode("utf-8", "replace"))
        sys.stdout.flush()
    except _command.Missing as error:
        print(f"furrow: plot: {error}", file=sys.stderr)
        return 127
    except OSError as error:
        print(f"furrow: plot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
