"""How the package's plots look: SVG with texts that stay texts, in the light or dark of the viewer, the same bytes for the same numbers.

Sizes are pixels. Colours: Okabe's and Ito's, which every eye tells apart.
"""
import html
import io
import math
import re
import warnings
from typing import Any

from furrow import _command

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5c00", "#808080"]
TEXT, BACK, GRID, ZERO = "#222222", "#fefefe", "#dddddd", "#888888"
SIZE = 13  # of texts
# Matplotlib writes its colours into each element. In the dark these four become others.
_DARK = "".join(f'[style*="{what}: {light}"]{{{what}:{dark}!important}}'
                for what, light, dark in (("fill", TEXT, "#dddddd"), ("stroke", TEXT, "#dddddd"), ("fill", BACK, "#111111"), ("stroke", GRID, "#333333")))
_LOOK = {"svg.fonttype": "none", "svg.hashsalt": "furrow", "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": SIZE,
         "text.color": TEXT, "axes.labelcolor": TEXT, "xtick.color": TEXT, "ytick.color": TEXT, "xtick.labelsize": SIZE, "ytick.labelsize": SIZE,
         "axes.titlesize": SIZE, "axes.labelsize": SIZE, "lines.scale_dashes": False, "path.simplify": False, "figure.dpi": 72, "legend.fontsize": SIZE}


def visible(text: Any) -> str:
    """A text of a user without control characters, and without what is no character: each is a question mark."""
    return "".join("?" if not char.isprintable() or 0xd800 <= ord(char) <= 0xdfff or ord(char) in (0xfffe, 0xffff) else char for char in str(text))


def plain(text: Any, most: int = 0) -> str:
    """A text of a user as a plot shows it: no formula, no control characters. `most`: it is cut after so many characters; 0: it is not cut."""
    out = visible(text)
    if most and len(out) > most:
        out = out[:most] + "…"
    out = out.replace("$", r"\$")
    return "\u200b" + out if out.startswith("_") else out  # Matplotlib's legends leave out what begins with _


def step(least: float) -> float:
    """The distance between an axis's lines: the smallest of 1, 2 or 5 times a power of ten that is at least `least`, above 0."""
    power = 10.0 ** math.floor(math.log10(least))
    factor = least / power
    return power * (1 if factor <= 1 else 2 if factor <= 2 else 5 if factor <= 5 else 10)


def axis(low: float, high: float) -> "tuple[float, float, float]":
    """An axis: its ends, rounded outward to lines, and the distance between lines, about seven of them. An empty range becomes one of length 1."""
    if not high > low:
        low = low - 0.5 if math.isfinite(low) else 0.0
        high = low + 1
    each = step((high - low) / 7)
    return math.floor(low / each + 1e-9) * each, math.ceil(high / each - 1e-9) * each, each


def steps(low: float, high: float) -> "list[float]":
    """An axis's lines from outside `low` to outside `high`."""
    first, last, each = axis(low, high)
    return [i * each for i in range(round(first / each), round(last / each) + 1)]


def figure(width: int, height: int) -> Any:
    """An empty figure. _command.Missing: there is no matplotlib."""
    module = _command.need("matplotlib.figure", "matplotlib")
    return module.Figure(figsize=(width / 72, height / 72), dpi=72, facecolor=BACK)


def look() -> Any:
    """The settings under which a figure is made and written: with look(): ..."""
    matplotlib = _command.need("matplotlib", "matplotlib")
    return matplotlib.rc_context(_LOOK)


def axes(fig: Any, left: float, top: float, wide: float, tall: float) -> Any:
    """Axes at a place from the figure's upper left corner, with a grid and no frame."""
    width, height = (side * 72 for side in fig.get_size_inches())
    made = fig.add_axes([left / width, 1 - (top + tall) / height, wide / width, tall / height], facecolor="none")
    made.set_axisbelow(True)
    made.grid(True, color=GRID, linewidth=1)
    made.tick_params(length=0, pad=6)
    for spine in made.spines.values():
        spine.set_visible(False)
    return made


def ruled(made: Any, which: str, lines: "list[float]") -> None:
    """Gives an axis ("x" or "y") its lines and its ends; the line at 0 is darker."""
    axis = getattr(made, f"{which}axis")
    axis.set_ticks(lines)
    axis.set_ticklabels([f"{0 if abs(value) < 1e-6 * (lines[-1] - lines[0]) else value:g}" for value in lines])
    getattr(made, f"set_{which}lim")(lines[0], lines[-1])
    if lines[0] <= 0 <= lines[-1]:
        (made.axhline if which == "y" else made.axvline)(0, color=ZERO, linewidth=1, zorder=0.6, clip_on=False)


def titled(made: Any, title: str) -> None:
    """A bold title over the upper left corner of axes."""
    made.set_title(title, loc="left", fontweight="bold", pad=8)


def at(fig: Any, x: float, y: float, text: str, **options: Any) -> None:
    """Writes a text at pixels from the figure's upper left corner."""
    width, height = (side * 72 for side in fig.get_size_inches())
    fig.text(x / width, 1 - y / height, text, **options)


def keys(fig: Any, left: float, top: float, entries: "list[tuple[dict[str, Any], str]]", title: "str | None" = None) -> None:
    """A legend at a place: of each entry how its line looks (of matplotlib's Line2D), and its text. Marks alone need less room than lines."""
    if not entries:
        return
    line2d = _command.need("matplotlib.lines", "matplotlib").Line2D
    width, height = (side * 72 for side in fig.get_size_inches())
    legend = fig.legend([line2d([], [], **options) for options, _ in entries], [text for _, text in entries], loc="upper left", frameon=False, borderpad=0,
                        borderaxespad=0, bbox_to_anchor=(left / width, 1 - top / height), handlelength=0.9 if all(options.get("linestyle") == "none" for options, _ in entries) else 2.6, title=title, alignment="left")
    if title:
        legend.get_title().set_fontweight("bold")


def written(fig: Any, inline: "str | None" = None) -> str:
    """The figure as SVG. `inline`: the title of a figure that is part of an HTML page, where it has no size of its own; None: a file."""
    canvas = _command.need("matplotlib.backends.backend_svg", "matplotlib").FigureCanvasSVG(fig)
    buffer = io.StringIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a character that the font lacks is the viewer's to draw
        canvas.print_svg(buffer, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    text = re.sub(r' id="[\w.]+_\d+"', "", buffer.getvalue())  # matplotlib's own numbers; a name that was given has a hyphen
    text = text.replace("*{stroke-linejoin", "svg *{stroke-linejoin", 1)
    text = text.replace("</style>", f"@media (prefers-color-scheme: dark) {{{_DARK}}}</style>", 1)
    size = "" if inline is not None else r'width="\1" height="\2"'
    text = re.sub(r'width="([\d.]+)pt" height="([\d.]+)pt"', size, text, count=1)
    if inline is None:
        return text
    whole = text[text.index("<svg"):]
    return re.sub(r"<svg([^>]*)>", lambda found: f'<svg role="img"{found[1]}><title>{html.escape(inline)}</title>', whole, count=1)

