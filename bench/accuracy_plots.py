"""The plots of bench/accuracy.py: exactness against cost, by gnuplot, to SVG and PNG.

Python decides everything that is decided by the data (ranges, ticks, where a label has room), gnuplot draws. The scripts
stay beside the pictures."""
import math
import shutil
import subprocess

from accuracy_study import best, exactness, truth
from pages import Told, figure

WIDTH, HEIGHT = 960, 600                                  # pixels of the picture
LEFT, BOTTOM, TOP = 0.085, 0.125, 0.875                   # the box, shares of it
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")  # Okabe and Ito's
SHAPES = ((7, 6), (5, 4), (9, 8), (13, 12), (11, 10), (15, 14), (7, 6))                  # filled, hollow
LETTER, LINE, REACH = 7.0, 15.0, 9.0                      # pixels: of a label's letter and line; from a point to its label


class Axis:
    """From data to a share of the picture. `floor`: where a logarithmic one has what is exactly 0."""

    def __init__(self, title, values, start, end, log=False):
        self.title, self.start, self.end, self.floor = title, start, end, None
        positive = [v for v in values if v > 0 and math.isfinite(v)]
        self.log = log and bool(positive)
        low, high = (min(positive), max(positive)) if self.log else (min(values), max(values))
        if self.log:
            span = max(math.log10(high / low), 0.3)
            self.low, self.high = low / 10 ** (0.1 * span), high * 10 ** (0.12 * span)
            if any(v <= 0 for v in values):
                self.floor = low / 10 ** (0.2 * span)
                self.low = low / 10 ** (0.28 * span)
        else:
            span = (high - low) or abs(high) or 1
            self.low, self.high = low - 0.1 * span, high + 0.12 * span
            if low >= 0 and self.low < 0.25 * span:
                self.low = 0
        self.ticks = self.log_ticks() if self.log else self.even_ticks()

    def log_ticks(self):
        least = self.low if self.floor is None else self.floor * 1.2
        decades = math.log10(self.high / least)
        if decades < 0.8:
            return self.even_ticks() + ([("exact", self.floor)] if self.floor else [])
        steps = (1, 2, 5) if decades < 2.2 else (1, 3) if decades < 3.2 else (1,)
        found = [m * 10.0 ** e for e in range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1) for m in steps]
        return [(f"{t:g}", t) for t in found if least < t < self.high] + ([("exact", self.floor)] if self.floor else [])

    def even_ticks(self):
        low = self.low if self.floor is None else self.floor * 1.2
        unit = 10.0 ** math.floor(math.log10((self.high - low) / 4))
        step = next(unit * n for n in (1, 2, 5, 10) if (self.high - low) / (unit * n) <= 7)
        return [(f"{i * step:g}", i * step) for i in range(math.ceil(low / step), math.floor(self.high / step) + 1)]

    def drawn(self, value):
        """As gnuplot is given it."""
        return self.floor if self.floor is not None and value <= 0 else value

    def share(self, value):
        value, low, high = self.drawn(value), self.low, self.high
        if self.log:
            value, low, high = math.log(value), math.log(low), math.log(high)
        return self.start + (self.end - self.start) * (value - low) / (high - low)


class Point:
    """ends: the least and the most of its runs, or None. truth: what its error is against."""

    def __init__(self, x, y, label, group, default, on, ends=None, truth=""):
        self.x, self.y, self.label, self.group, self.default, self.on, self.ends, self.truth = x, y, label, group, default, on, ends, truth


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


# --- labels ---

def overlap(a, b):
    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    return wide * high if wide > 0 and high > 0 else 0


def places(x, y, wide):
    """Boxes for a label beside a point, and how unwelcome they are."""
    for ring, far in enumerate((REACH, 1.9 * REACH, 3.2 * REACH)):
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (0.8, 0.9), (-0.8, 0.9), (0.8, -0.9), (-0.8, -0.9)):
            left = x + dx * far - (0 if dx > 0 else wide if dx < 0 else wide / 2)
            middle = y + dy * (far + LINE / 2 - 2)
            yield (left, middle - LINE / 2, left + wide, middle + LINE / 2), 12 * ring + 2 * (dx < 0 or dx == 0)


def merged(points, across, up):
    """Labels of points that lie on one another are one: [(x, y in pixels, text, default, group)]."""
    found = []
    for point in points:
        x, y = across.share(point.x) * WIDTH, up.share(point.y) * HEIGHT
        for one in found:
            if one["group"] == point.group and math.hypot(one["x"] - x, one["y"] - y) < 5:
                one["texts"].insert(0 if point.default else len(one["texts"]), point.label)
                one["default"] |= point.default
                break
        else:
            found.append({"x": x, "y": y, "texts": [point.label], "default": point.default, "group": point.group})
    return found


def along(line, across, up):
    """Small boxes along a line of (x, y), for labels to keep off."""
    at = [(across.share(x) * WIDTH, up.share(y) * HEIGHT) for x, y in line]
    for (ax, ay), (bx, by) in zip(at, at[1:]):
        count = max(1, int(math.hypot(bx - ax, by - ay) / 4))
        for i in range(count + 1):
            x, y = ax + (bx - ax) * i / count, ay + (by - ay) * i / count
            yield x - 1.5, y - 1.5, x + 1.5, y + 1.5


def dark(colour):
    """Of a colour that lines have, one that letters can have."""
    return "#" + "".join(f"{int(colour[i:i + 2], 16) * 2 // 3:02x}" for i in (1, 3, 5))


def labels(points, lines, colours, across, up, right):
    """gnuplot's commands for them: the default's first, each where it covers least. colours: of groups."""
    marks = [(x - 6, y - 6, x + 6, y + 6) for x, y in
             ((across.share(p.x) * WIDTH, up.share(p.y) * HEIGHT) for p in points)]
    crossed = [box for line in lines for box in along(line, across, up)]
    inks = {group: dark(colour) for group, colour in colours.items()}
    taken, commands = [], []
    edge = (LEFT * WIDTH + 2, BOTTOM * HEIGHT + 2, right * WIDTH - 2, TOP * HEIGHT - 2)
    for one in sorted(merged(points, across, up), key=lambda one: not one["default"]):
        first, *others = dict.fromkeys(one["texts"])
        text = f"default: {first}" + "; the same: " * bool(others) if one["default"] else first + ", " * bool(others)
        text += ", ".join(others)
        wide = LETTER * len(text) + 4

        def cost(box):
            out = (box[2] - box[0]) * LINE - overlap(box, edge)
            return 4 * out + 3 * sum(overlap(box, other) for other in taken) + \
                sum(overlap(box, mark) for mark in marks) + 0.35 * sum(overlap(box, piece) for piece in crossed)
        box = min(places(one["x"], one["y"], wide), key=lambda offer: cost(offer[0]) + offer[1])[0]
        taken.append(box)
        middle = (box[0] + box[2]) / 2 / WIDTH, (box[1] + box[3]) / 2 / HEIGHT
        commands.append(f'set label {quoted(text)} at screen {middle[0]:.4f},{middle[1]:.4f} center front '
                        f'textcolor rgb "{"#000000" if one["default"] else inks[one["group"]]}"')
    return commands


# --- scripts ---

def opening(title, across, up, right, key):
    lines = ["set encoding utf8", f"set lmargin at screen {LEFT}", f"set rmargin at screen {right}",
             f"set bmargin at screen {BOTTOM}", f"set tmargin at screen {TOP}", "set border 3 linecolor rgb '#888888'",
             "set tics nomirror scale 0.5 textcolor rgb '#222222'", f"set grid xtics ytics linetype 1 linewidth 0.6 linecolor rgb '#e4e4e4'",
             f"set label {quoted(title)} at screen {LEFT},0.955 left font ',16'",
             f"set label {quoted(up.title)} at screen {LEFT},0.905 left textcolor rgb '#444444'",
             f"set xlabel {quoted(across.title)} offset 0,-0.2 textcolor rgb '#444444'"]
    for name, axis in (("x", across), ("y", up)):
        lines.append(f"set {name}range [{axis.low!r}:{axis.high!r}]")
        lines.append(f"set {name}tics (" + ", ".join(f"{quoted(text)} {at!r}" for text, at in axis.ticks) + ")")
        if axis.log:
            lines.append(f"set logscale {name}")
    lines.append({"right": f"set key at screen {right + 0.012},{TOP} left top Left reverse samplen 1.5 spacing 1.25 width -2",
                  "above": f"set key at screen {right},0.925 right top Left reverse horizontal samplen 1.5"}.get(key, "set key off"))
    return lines


def block(name, rows):
    return [f"${name} << end", *(" ".join(map(repr, row)) for row in rows), "end"]


def stairs(points, across, up, begin):
    """The corners of a front's steps, of points that are on it: from `begin` on the axis `up`."""
    on = sorted((across.drawn(p.x), up.drawn(p.y)) for p in points if p.on)
    if not on:
        return []
    return [(on[0][0], begin), *on, (across.high, on[-1][1])]


def scatter(title, across, up, points, begin):
    """A front for each truth, whose first step comes from `begin` on the axis `up`. Hollow points are on no front. Bars have all runs."""
    groups = list(dict.fromkeys(point.group for point in points))
    right = 0.8 if len(groups) > 1 else 0.97
    across.end = right
    lines = opening(title, across, up, right, "right" if len(groups) > 1 else "above")
    drawn, keep_off = [], []
    truths = list(dict.fromkeys(point.truth for point in points))
    for i, of in enumerate(truths):
        own = [point for point in points if point.truth == of]
        steps = stairs(own, across, up, begin)
        if not steps:
            continue
        colours_of = {groups.index(point.group) for point in own}
        colour = COLOURS[colours_of.pop() % len(COLOURS)] if len(truths) > 1 and len(colours_of) == 1 else "#b0b0b0"
        lines += block(f"front{i}", steps)
        drawn.append(f"$front{i} with steps linewidth {2 if len(truths) == 1 else 1.2} dashtype {1 if len(truths) == 1 else 3} linecolor rgb '{colour}' " +
                     ("title 'Pareto front'" if len(truths) == 1 else "notitle"))
        keep_off.append([corner for (ax, ay), (bx, by) in zip(steps, steps[1:]) for corner in ((ax, ay), (bx, ay), (bx, by))])
    for i, group in enumerate(groups):
        own = [point for point in points if point.group == group]
        filled, hollow = SHAPES[i % len(SHAPES)]
        style = f"linecolor rgb '{COLOURS[i % len(COLOURS)]}'"
        if len(groups) > 1:
            keep_off.append([(across.drawn(p.x), up.drawn(p.y)) for p in own])
            lines += block(f"all{i}", keep_off[-1])
            drawn.append(f"$all{i} with lines linewidth 0.8 {style} notitle")
        ends = [(across.drawn(p.x), up.drawn(p.y), *p.ends) for p in own if p.ends]
        if ends:
            lines += block(f"ends{i}", ends)
            drawn.append(f"$ends{i} using 1:2:3:4 with xerrorbars pointtype 0 linewidth 1.2 {style} notitle")
        for name, shape, on in ((f"on{i}", filled, True), (f"off{i}", hollow, False)):
            rows = [(across.drawn(p.x), up.drawn(p.y)) for p in own if p.on == on]
            if rows:
                lines += block(name, rows)
                drawn.append(f"${name} with points pointtype {shape} pointsize dot linewidth 1.4 {style} notitle")
        if group:
            drawn.append(f"NaN with points pointtype {filled} pointsize dot {style} title {quoted(group)}")
    chosen = [(across.drawn(p.x), up.drawn(p.y)) for p in points if p.default]
    if chosen:
        lines += block("chosen", chosen)
        drawn.append("$chosen with points pointtype 6 pointsize 2.4 * dot linewidth 2 linecolor rgb '#000000' title 'default'")
    colours = {group: COLOURS[i % len(COLOURS)] if len(groups) > 1 else "#666666" for i, group in enumerate(groups)}
    lines += labels(points, keep_off, colours, across, up, right)
    return lines + ["plot " + ", \\\n     ".join(drawn)]


def bars(title, axis_title, found):
    """Cost alone. found: [(label, value, default)]."""
    across = Axis(axis_title, [0, *(value for _, value, _ in found)], 0.25, 0.97)
    up = Axis("", [-0.5, len(found) - 0.5], BOTTOM, TOP)
    up.low, up.high = -0.7, len(found) - 0.3
    up.ticks = [(label + (" (default)" if default else ""), len(found) - 1 - i) for i, (label, _, default) in enumerate(found)]
    lines = opening(title, across, up, 0.97, None)
    lines += ["set lmargin at screen 0.25", "unset grid", "set grid xtics linetype 1 linewidth 0.6 linecolor rgb '#e4e4e4'"]
    high = min(0.28, 0.06 * len(found))
    for i, (_, value, default) in enumerate(found):
        at = len(found) - 1 - i
        lines.append(f"set object rectangle from 0,{at - high} to {value!r},{at + high} "
                     f"fillstyle solid 1 noborder fillcolor rgb '{COLOURS[0] if default else '#9ecae1'}'")
        lines.append(f"set label {quoted(figure(value))} at {value!r},{at} left offset 0.6,0 textcolor rgb '#222222'")
    return lines + ["plot NaN notitle"]


# --- which plots ---

def points_of(study, cost, exact):
    """cost: of a line, (least, median, most). exact: of a line, the smaller the better. What was measured elsewhere has no spread: it is hollow."""
    on = best(study, cost, exact)
    found = []
    for line in study.lines:
        (least, x, most), y = cost(line), exact(line)
        if x is not None and y is not None:
            ends = (least, most) if least is not None and least < most else None
            found.append(Point(x, y, (study.whole_label if line["default"] else study.label)(line), study.group(line), line["default"],
                               id(line) in on, ends, truth(line)))
    return found


def spread(values):
    positive = [v for v in values if v > 0]
    return len(positive) == len(values) and max(values) > 6 * min(values)


def plot(study, cost, cost_title, exact, exact_title, log, turned=False):
    """turned: the more the better, and `exact` is its negative."""
    points = points_of(study, cost, exact)
    if len({(p.x, p.y) for p in points}) < 2:
        return None
    if turned:
        for point in points:
            point.y = -point.y
    finite = [p.y for p in points if math.isfinite(p.y)]
    if not finite:
        return None
    exact_title += f"  (beside the points: {study.labelled()})"
    up = Axis(exact_title, finite, BOTTOM, TOP, log)
    if turned:
        top = max(finite) + 0.15 * (max(finite) - min(finite) or 10)
        same = [p for p in points if not math.isfinite(p.y)]
        if same:
            up = Axis(exact_title, [*finite, top], BOTTOM, TOP)
            up.ticks = [tick for tick in up.ticks if tick[1] < top * 0.97] + [("same", top)]
        for point in same:
            point.y = top
    costs = [x for p in points for x in (p.x, *(p.ends or ()))]
    across = Axis(cost_title, costs, LEFT, 0.97, spread(costs))
    return scatter(study.title, across, up, points, up.low if turned else up.high)


def plots(study):
    """[(name, gnuplot's commands)]"""
    def room(line):
        return (None if line["bytes"] is None else line["bytes"] / 1e6,) * 3
    if not study.tells_apart():
        known = [(study.whole_label(line), study.cost(line), line["default"]) for line in study.lines]
        return [(study.name, bars(study.title, study.cost_title(), known))]
    of = next((line["bytes_of"] for line in study.lines if line.get("bytes_of")), "")
    found = []
    axes = [(study.name, study.range_of_cost, study.cost_title())]
    if any(line["bytes"] is not None for line in study.lines):
        axes.append((study.name + "-bytes", room, f"MB ({of})" if of else "MB"))
    for name, cost, title in axes:
        if study.of_pictures():
            found.append((name, plot(study, cost, title, exactness(study), "PSNR against the finest, dB", False, turned=True)))
            found.append((name + "-worst", plot(study, cost, title, lambda line: (line["picture"] or {}).get("worst"),
                                                "worst pixel, of 255", False)))
        else:
            found.append((name, plot(study, cost, title, exactness(study), study.exact_title(), True)))
    return [(name, lines) for name, lines in found if lines]


def gnuplot():
    path = shutil.which("gnuplot")
    if path is None:
        raise Told("no gnuplot, so no plots: install gnuplot-nox (sh tools/packages.sh does)")
    return path


def draw(folder, name, lines):
    """NAME.gnuplot, .svg and .png in the folder."""
    script = folder / f"{name}.gnuplot"
    body = "\n".join(lines) + "\n"
    script.write_text(
        f"# gnuplot {name}.gnuplot, in this folder\n"
        f"set terminal svg size {WIDTH},{HEIGHT} dynamic enhanced font 'sans-serif,13' background 'white'\n"
        f"set termoption noenhanced\nset output '{name}.svg'\ndot = 0.7\n{body}"
        f"set terminal pngcairo size {WIDTH},{HEIGHT} noenhanced font 'sans,10'\nset output '{name}.png'\ndot = 1.1\nreplot\nset output\n")
    done = subprocess.run([gnuplot(), script.name], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise Told(f"{script}: gnuplot: {done.stderr.strip()}; mend the script and run gnuplot on it")
    return [folder / f"{name}.svg", folder / f"{name}.png"]
