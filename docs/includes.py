#!/usr/bin/env python3
"""Draws docs/includes.svg: which folder of src includes which.

    docs/includes.py            # writes docs/includes.svg
    docs/includes.py --check    # fails if docs/includes.svg is not what would be written

A folder is above all folders that src/meson.build lets it include. An include that goes up or sideways fails the script. The header of hosts,
api/furrow.h, includes nothing of ours: where a folder below api uses its structs, there is no arrow.
A pale arrow goes where a path of other arrows goes, too. All others are dark.
"""
import ast
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "includes.svg"
WIDTH, ROW, BOX, HIGH = 900, 62, 110, 30  # px: of the picture, between rows, of a box


def build_ranks(text):
    """{folder: rank} of src/meson.build: 0 is the folder that may include nothing."""
    def literal(name):
        return ast.literal_eval(re.search(r"^%s = ([\[{].*?[\]}])$" % name, text, re.MULTILINE | re.DOTALL).group(1))
    ranks = {}
    for folder, below in literal("below").items():
        ranks[folder] = 1 + max((ranks[name] for name in below), default=-1)
    for row in literal("siblings"):
        above = 1 + max(ranks.values())
        ranks.update({folder: above for folder in row})
    return ranks


def includes(sources, folders):
    """{(from, to)}: a file of `from` includes a header of `to`. `folders`: {folder: rank}."""
    found = set()
    for folder in folders:
        for path in sorted((sources / folder).rglob("*.[ch]")):
            headers = set(re.findall(r'^\s*#\s*include\s+"(\w+/[^"]*)"', path.read_text(encoding="utf-8"), re.MULTILINE))
            if folders[folder] < folders.get("api", 0):
                headers.discard("api/furrow.h")
            found.update((folder, name) for name in {header.split("/")[0] for header in headers} & set(folders) - {folder})
    return found


def reached(edges, start):
    """Folders that arrows lead to from `start`, itself left out."""
    seen, ahead = set(), [to for a, to in edges if a == start]
    while ahead:
        name = ahead.pop()
        if name not in seen:
            seen.add(name)
            ahead += [to for a, to in edges if a == name]
    return seen


def places(ranks):
    """{folder: (x, y) of its box's middle}."""
    rows = collections.defaultdict(list)
    for folder, rank in ranks.items():
        rows[rank].append(folder)
    top = max(rows)
    return {folder: (WIDTH / 2 + (i - (len(row) - 1) / 2) * (230 if len(row) == 2 else 150), 30 + (top - rank) * ROW)
            for rank, row in rows.items() for i, folder in enumerate(row)}


def crosses(edge, at, points):
    """True if a curve with these control points crosses the box of a folder that is at neither end."""
    def place(t, axis):
        return sum(weight * point[axis] for weight, point in
                   zip(((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3), points))
    along = [(place(i / 60, 0), place(i / 60, 1)) for i in range(61)]
    return any(abs(px - x) < BOX / 2 + 4 and abs(py - y) < HIGH / 2 + 4
               for folder, (x, y) in at.items() if folder not in edge for px, py in along)


def way(edge, at, side):
    """The control points of an arrow: straight where there is room, else a curve on the left (side -1) or on the right (1)."""
    (x0, y0), (x1, y1) = at[edge[0]], at[edge[1]]
    a, b = (x0, y0 + HIGH / 2), (x1, y1 - HIGH / 2 - 2)
    points = [a, ((2 * a[0] + b[0]) / 3, (2 * a[1] + b[1]) / 3), ((a[0] + 2 * b[0]) / 3, (a[1] + 2 * b[1]) / 3), b]
    bulge = 0.36
    while crosses(edge, at, points) and bulge < 0.8:
        out = side * (BOX / 2 + bulge * (y1 - y0))
        points = [(x0 + side * BOX / 2, y0), (x0 + out, y0), (x1 + out, b[1] - 16), (x1 + side * 0.4 * BOX, b[1])]
        bulge += 0.08
    return points


def arrow(edge, at, kind, side):
    return '<path d="M%.0f %.0fC%.0f %.0f %.0f %.0f %.0f %.0f" class="%s"><title>%s includes %s</title></path>' % (
        *[part for point in way(edge, at, side) for part in point], kind, *edge)


def draw(ranks, edges):
    at = places(ranks)
    bottom = min(ranks, key=ranks.get)
    drawn = {edge for edge in edges if edge[1] != bottom}
    pale, dark, left = [], [], False
    for edge in sorted(drawn, key=lambda edge: (-ranks[edge[0]], ranks[edge[1]], edge)):
        past = edge[1] in reached([other for other in drawn if other != edge], edge[0])
        lean = at[edge[1]][0] + at[edge[0]][0] - WIDTH
        left ^= lean == 0 and past
        side = -1 if lean < 0 or (lean == 0 and left) else 1
        (pale if past else dark).append(arrow(edge, at, "past" if past else "direct", side))
    dark += [arrow((folder, bottom), at, "direct", 1) for folder in ranks if (folder, bottom) in edges and ranks[folder] == 1]
    boxes = ['<rect x="%g" y="%g" width="%d" height="%d" rx="5"/><text x="%g" y="%g">%s</text>' %
             (x - BOX / 2, y - HIGH / 2, BOX, HIGH, x, y + 5, folder) for folder, (x, y) in at.items()]
    high = max(y for _, y in at.values()) + 70
    note = "Every folder includes base. These arrows are left out but for the lowest row."
    return """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %g" font-family="sans-serif" font-size="15">
<!-- Written by docs/includes.py. -->
<style>
path { fill: none }
.direct { stroke: #1d4f7c; stroke-width: 2; marker-end: url(#dark) }
.past { stroke: #9db4c9; stroke-width: 1.2; marker-end: url(#pale) }
rect { fill: #f2ede2; stroke: #6b5d43 }
text { text-anchor: middle; fill: #222 }
</style>
<defs>
<marker id="dark" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="5" markerHeight="5" orient="auto"><path d="M0 0L8 4L0 8z" style="fill:#1d4f7c"/></marker>
<marker id="pale" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6" orient="auto"><path d="M0 0L8 4L0 8z" style="fill:#9db4c9"/></marker>
</defs>
<rect width="100%%" height="100%%" style="fill:#fff;stroke:none"/>
%s
<text x="%g" y="%g" font-size="13">%s</text>
</svg>
""" % (WIDTH, high, "\n".join(pale + dark + boxes), WIDTH / 2, high - 18, note)


def picture(root):
    """The picture's text, and the includes that do not go down."""
    ranks = build_ranks((root / "src" / "meson.build").read_text(encoding="utf-8"))
    edges = includes(root / "src", ranks)
    wrong = ["%s includes %s" % edge for edge in sorted(edges) if ranks[edge[0]] <= ranks[edge[1]]]
    return draw(ranks, edges), wrong


def main():
    text, wrong = picture(ROOT)
    if wrong:
        sys.exit("src: %s, which is not below it; move what is shared down" % "; ".join(wrong))
    if sys.argv[1:] == ["--check"]:
        if PICTURE.read_text(encoding="utf-8") != text:
            sys.exit("docs/includes.svg: is not what src includes now; run docs/includes.py")
    elif sys.argv[1:]:
        sys.exit("usage: docs/includes.py [--check]")
    else:
        PICTURE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
