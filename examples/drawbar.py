"""Tells the drawbar pull of a vehicle over its slip, of a drive in which a load car holds it back (tools/scenes/vehicles/tow.yaml).

    python3 drawbar.py DRIVE [PLOT.svg] [VEHICLE] [ACTUATOR]

DRIVE is the folder that `furrow drive SCENE -o DRIVE` made, with rows of both tables: `output: {forces: 50, vehicles: 50}`. VEHICLE is the first one,
ACTUATOR is `tow`, if they are not given. A line is the mean over the last second of a time in which the actuator's control stays. The plot needs matplotlib.

pull is the actuator's force. wheels is what the soil does to the wheels along the way: their traction less their motion resistance. grade is
the weight's part along the way. In steady state pull = wheels - grade; off is the difference, and has what the vehicle's acceleration takes.
"""
import csv
import json
import math
import os
import sys

SECOND = 1.0  # s: what a mean is over


def read(folder, name):
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        sys.exit(f"{path}: is not there; give the scene `output: {{forces: 50, vehicles: 50}}`")
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def holds(rows, control):
    """(begin, end) in s of each time in which the control stays, if it is as long as a mean needs and a turn to settle in."""
    found, first = [], 0
    for i in range(1, len(rows) + 1):
        if i == len(rows) or rows[i][control] != rows[first][control]:
            begin, end = float(rows[first]["t"]), float(rows[i - 1]["t"])
            if end - begin > 1.5 * SECOND:
                found.append((end - SECOND, end))
            first = i
    return found


def mean(rows, key):
    return sum(float(row[key]) for row in rows) / len(rows)


def line(rows, wheels, pull, weight):
    """(slip, pull, wheels, grade) over the rows of one time."""
    way = [float(rows[-1][key]) - float(rows[0][key]) for key in "xyz"]
    length = math.hypot(*way)
    if length < 1e-6:
        return None
    count = len(set(row["name"] for row in wheels))
    force = sum(count * mean(wheels, "f" + axis) * part / length for axis, part in zip("xyz", way))
    return mean(wheels, "slip"), mean(rows, pull), force, weight * way[2] / length


def main(folder, plot=None, vehicle=None, actuator="tow"):
    with open(os.path.join(folder, "run.json")) as file:
        run = json.load(file)["vehicles"]
    vehicle = vehicle or next(iter(run))
    if vehicle not in run:
        sys.exit(f"{folder}: there is no vehicle {vehicle}; there are {', '.join(run)}")
    weight = run[vehicle]["mass"] * run[vehicle]["gravity"]
    rows = [row for row in read(folder, "vehicles.csv") if row["name"] == vehicle]
    wheels = [row for row in read(folder, "objects.csv") if row["name"].startswith(vehicle + ".")]
    if not rows or "u:" + actuator not in rows[0] or "f:" + actuator not in rows[0]:
        sys.exit(f"{folder}: {vehicle} has no actuator {actuator}")
    lines = []
    for begin, end in holds(rows, "u:" + actuator):
        def within(table):
            return [row for row in table if begin <= float(row["t"]) <= end]
        lines.append(line(within(rows), within(wheels), "f:" + actuator, weight))
    lines = [numbers for numbers in lines if numbers is not None]
    if not lines:
        sys.exit(f"{folder}: no control of {actuator} stays for more than {1.5 * SECOND:g} s while {vehicle} moves")
    print("  slip    pull N  wheels N   grade N     off N  pull/weight")
    for slip, pull, force, grade in lines:
        print(f"{slip:6.3f}{pull:10.0f}{force:10.0f}{grade:10.0f}{force - grade - pull:10.1f}{pull / weight:13.3f}")
    most = max(lines, key=lambda numbers: numbers[1])
    worst = max(abs(force - grade - pull) for _, pull, force, grade in lines)
    rising = ", still rising at the last step: slower steps of the load car would show more" if len(lines) > 1 and most is lines[-1] else ""
    print(f"greatest pull {most[1]:.0f} N at slip {most[0]:.2f}{rising}; wheels less grade are within {100 * worst / abs(most[1]):.1f} % of that from the pull")
    if plot is not None:
        draw(lines, vehicle, plot)


def draw(lines, vehicle, plot):
    try:
        import matplotlib
    except ImportError:
        sys.exit(f"{plot}: is not drawn: there is no matplotlib; install it (Debian: python3-matplotlib), or leave the file name out")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams["svg.hashsalt"] = "furrow"
    figure, axis = plt.subplots(figsize=(7, 4), constrained_layout=True)
    axis.plot([n[0] for n in lines], [n[1] for n in lines], "o-", label="pull of the load car")
    axis.plot([n[0] for n in lines], [n[2] - n[3] for n in lines], "x", label="sum over the wheels, less grade")
    axis.axhline(0, color="0.5", linewidth=0.8)
    axis.set_xlabel("slip, mean of the wheels")
    axis.set_ylabel(f"drawbar pull of {vehicle}, N")
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(plot, metadata={"Date": None} if plot.endswith(".svg") else None)


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
