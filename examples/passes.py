"""Tells how deep the rut is after each pass, of drives in which the copies of a template follow each other over one way.

    python3 passes.py DRIVE... [TABLE.csv] [PLOT.svg]

DRIVE is a folder that `furrow drive SCENE -o DRIVE` made, with rows of objects.csv: `output: {forces: 10}`. Pass 3 is the copy `wheel-3`. Its depth is
the mean sinkage over the middle half of its way, below the ground as it was imported. The table has the columns drive, object, pass, depth and deeper,
in m. a is fitted to depth = first depth x pass^(1/a). The plot needs matplotlib.
"""
import csv
import math
import os
import re
import sys


def middle(rows):
    """The mean sinkage over the middle half of the way of one object."""
    ways = [0.0]
    for before, row in zip(rows, rows[1:]):
        ways.append(ways[-1] + math.hypot(float(row["x"]) - float(before["x"]), float(row["y"]) - float(before["y"])))
    found = [float(row["sinkage"]) for row, way in zip(rows, ways) if 0.25 * ways[-1] <= way <= 0.75 * ways[-1]]
    return sum(found) / len(found) if ways[-1] > 0 else None


def passes(folder):
    """{object without its number: depths of its passes, in m}"""
    path, rows, found = os.path.join(folder, "objects.csv"), {}, {}
    if not os.path.exists(path):
        sys.exit(f"{path}: is not there; give the scene `output: {{forces: 10}}`")
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            rows.setdefault(row["name"], []).append(row)
    for name, of in rows.items():
        copy = re.fullmatch(r"(.+)-(\d+)", name)
        depth = middle(of) if copy else None
        if depth is not None:
            found.setdefault(copy[1], {})[int(copy[2])] = depth
    if not found:
        sys.exit(f"{folder}: no copies of a template move in it; their names end in -1, -2, ...")
    return {name: [depth for _, depth in sorted(depths.items())] for name, depths in found.items()}


def coefficient(depths):
    """a of depth = first depth x pass^(1/a), by least squares of the logarithms; inf: it gets no deeper."""
    logs = [(math.log(i + 1), math.log(depth / depths[0])) for i, depth in enumerate(depths)]
    slope = sum(n * z for n, z in logs) / max(sum(n * n for n, _ in logs), 1e-9)
    return 1 / slope if slope > 0 else math.inf


def main(arguments):
    tables = [name for name in arguments if name.endswith(".csv")]
    plots = [name for name in arguments if name.endswith((".svg", ".png"))]
    folders = [name for name in arguments if name not in tables + plots]
    if not folders:
        sys.exit(__doc__)
    curves = [(folder, name, depths) for folder in folders for name, depths in passes(folder).items()]
    print("pass" + "".join(f"{folder + ' ' + name:>16}" for folder, name, _ in curves) + "   mm")
    for i in range(max(len(depths) for _, _, depths in curves)):
        print(f"{i + 1:4}" + "".join(f"{1e3 * depths[i]:16.1f}" if i < len(depths) else " " * 16 for _, _, depths in curves))
    print("a   " + "".join(f"{coefficient(depths):16.2f}" for _, _, depths in curves))
    for table in tables:
        with open(table, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["drive", "object", "pass", "depth", "deeper"])
            for folder, name, depths in curves:
                for i, depth in enumerate(depths):
                    writer.writerow([folder, name, i + 1, f"{depth:.6f}", f"{depth - (depths[i - 1] if i > 0 else 0):.6f}"])
    for plot in plots:
        draw(curves, plot)


def draw(curves, plot):
    try:
        import matplotlib
    except ImportError:
        sys.exit(f"{plot}: is not drawn: there is no matplotlib; install it (Debian: python3-matplotlib), or leave the file name out")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams["svg.hashsalt"] = "furrow"
    figure, axis = plt.subplots(figsize=(7, 4), constrained_layout=True)
    for i, (folder, name, depths) in enumerate(curves):
        count, a = range(1, len(depths) + 1), coefficient(depths)
        axis.plot(count, [1e3 * depth for depth in depths], "os^Dv"[i % 5], color=f"C{i}", label=f"{folder}: {name}")
        axis.plot(count, [1e3 * depths[0] * n ** (1 / a) for n in count], "--", color=f"C{i}", linewidth=1, label=f"first x pass^(1/{a:.2f})")
    axis.set_xlabel("pass")
    axis.set_ylabel("depth of the rut, mm")
    axis.set_ylim(bottom=0)
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(plot, metadata={"Date": None} if plot.endswith(".svg") else None)


if __name__ == "__main__":
    main(sys.argv[1:])
