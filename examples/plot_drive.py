"""Plots what a vehicle did in a drive: speed, slip and sinkage of its wheels, power, roll and pitch, over its way.

    python3 plot_drive.py DRIVE PLOT.png [VEHICLE]

DRIVE is the folder that `furrow drive SCENE -o DRIVE` made, of a scene with `output: {forces: 50, vehicles: 50}`.
"""
import csv
import os
import sys

try:
    import matplotlib
    import numpy
except ImportError as missing:
    sys.exit(f"plot_drive.py: there is no {missing.name}; install it (Debian: python3-matplotlib has both)")

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def read(path):
    """The columns of a CSV file: arrays of numbers, or lists of words."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    columns = {}
    for name in rows[0] if rows else []:
        words = [row[name] for row in rows]
        try:
            columns[name] = numpy.array([float(word) if word else numpy.nan for word in words])
        except ValueError:
            columns[name] = numpy.array(words)
    return columns


def mean(values, width):
    """The running mean over `width` rows, narrower at the ends."""
    width = max(1, min(width, len(values)))
    known = numpy.isfinite(values)
    sums = numpy.convolve(numpy.where(known, values, 0), numpy.ones(width), "same")
    return sums / numpy.maximum(numpy.convolve(known, numpy.ones(width), "same"), 1)


def main(folder, picture, name=None):
    vehicles = read(os.path.join(folder, "vehicles.csv"))
    if not vehicles:
        sys.exit(f"{folder}: vehicles.csv has no rows; give the scene `output: {{vehicles: 50}}`")
    name = name or vehicles["name"][0]
    own = vehicles["name"] == name
    if not own.any():
        sys.exit(f"{folder}: there is no vehicle {name}; there are {', '.join(sorted(set(vehicles['name'])))}")
    t, x, y, z, work = (vehicles[key][own] for key in ("t", "x", "y", "z", "work"))
    way = numpy.concatenate([[0], numpy.cumsum(numpy.hypot(numpy.diff(x), numpy.diff(y)))])
    second = max(1, round(1 / (t[1] - t[0]))) if len(t) > 1 else 1
    figure, axes = plt.subplots(5, 1, sharex=True, figsize=(8, 10), constrained_layout=True)
    axes[0].plot(way, numpy.sqrt(sum(vehicles[key][own] ** 2 for key in ("vx", "vy", "vz"))))
    axes[0].set_ylabel("speed, m/s")
    forces = os.path.join(folder, "objects.csv")
    objects = read(forces) if os.path.exists(forces) else {}
    for geom in sorted(set(objects.get("name", []))):
        if not geom.startswith(name + "."):
            continue
        rows = objects["name"] == geom
        rate = max(1, round(rows.sum() / max(t[-1] - t[0], 1)))
        at = numpy.interp(objects["t"][rows], t, way)
        axes[1].plot(at, mean(numpy.clip(objects["slip"][rows], -1, 1), rate), label=geom[len(name) + 1:])
        axes[2].plot(at, mean(objects["sinkage"][rows], rate // 2) * 1000, label=geom[len(name) + 1:])
    axes[1].set_ylabel("slip, mean over 1 s")
    axes[1].set_ylim(-0.25, 1)
    axes[2].set_ylabel("sinkage, mm")
    if axes[1].lines:
        axes[1].legend(fontsize="small", ncol=2)
    axes[3].plot(way, mean(numpy.gradient(work, t), second) / 1000 if len(t) > 1 else work, label="power of the motors")
    axes[3].set_ylabel("power, kW")
    axes[4].plot(way, vehicles["roll"][own], label="roll")
    axes[4].plot(way, vehicles["pitch"][own], label="pitch")
    axes[4].set_ylabel("degrees")
    height = axes[4].twinx()
    height.plot(way, z - z[0], color="0.5", linestyle=":")
    height.set_ylabel("height, m (dotted)")
    axes[4].legend(fontsize="small", loc="upper left")
    axes[4].set_xlabel(f"way of {name}, m")
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.savefig(picture, dpi=100)
    print(f"{name}: {way[-1]:.1f} m in {t[-1] - t[0]:.1f} s, {work[-1] / 1000:.1f} kJ; {picture}")


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
