"""What a drive by many MPI processes costs, and a model of it that is fitted to some runs and checked on others.

    python3 bench/ranks.py build/tools/furrow [--wheels 100,200,400] [--ranks 1,2,3,4,8] [--model box] [--steps 160] [--json FILE]

Wheels as in bench/fleet.py: posts 1/8 m apart, steps of 0.05 s, a path sample for each wheel and step. One wheel of twenty drives
to another that is on another rank, and over its track: 95 % of the wheels are independent. What is measured is processor time, of all ranks together, in steps without waiting: two
processors cannot show how long eight ranks take. It ends before the last commit. From
each figure that of a run of a quarter of the steps is taken off, since the first steps load most of the tiles.

The model of the processor time of a step, s:

    busy(B, N) = N a + w B + N p B + q M

B wheels, N ranks, M tiles moved a step. a: what each rank does in a step whatever it has. w: the work of a wheel. p: what each rank does for
a wheel of any rank. q: a tile that moves. Fitted by least squares to all runs but those of 3 ranks, on which it is checked."""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy

import fleet
import pages
import record

CHECKED = 3  # ranks of the runs that the model is checked on


def scene(wheels, model, steps):
    """fleet.py's scene. One wheel of twenty drives to another, half of the fleet later in the list, and over its track. It is there after 0.6 of the steps."""
    lines = fleet.scene(wheels, model, steps).splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("  - "))
    far = 0.6 * fleet.SPEED * fleet.TIME_STEP * steps
    starts = [[float(n) for n in re.search(r"points: \[\[([^]]*)\]", line).group(1).split(",")] for line in lines[first:]]
    for i in range(0, wheels, 20):
        head = lines[first + i].split("path:")[0]
        x, y = starts[(i + wheels // 2) % wheels]
        lines[first + i] = f"{head}path: {{points: [[{x + far:.3f}, {y + 1:.3f}], [{x - far:.3f}, {y + 1:.3f}]], speed: {fleet.SPEED}}}}}"
    return "\n".join(lines).replace("slots: 4096", "slots: 2048") + "\n"


def drive(furrow, folder, ranks, *more):
    subprocess.run(["rm", "-rf", str(folder / "o.furrow"), str(folder / "out")], check=True)
    command = [furrow, "drive", str(folder / "ranks.yaml"), "--store", str(folder / "plain.furrow"), "--overlay", str(folder / "o.furrow"), "-o",
               str(folder / "out"), *more]
    if ranks > 1:
        command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), *command]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise pages.Told(f"{ranks} ranks: {done.stderr.strip()}")
    return json.loads((folder / "out" / "run.json").read_text())


def measure(arguments, folder, wheels, ranks):
    """One run: busy, planning and moving in s a step, and what moved a step. A run of a quarter of the steps is taken off."""
    (folder / "ranks.yaml").write_text(scene(wheels, arguments.model, arguments.steps))
    report = drive(arguments.furrow, folder, ranks)
    before = drive(arguments.furrow, folder, ranks, "--steps", str(arguments.steps // 4))
    steps = arguments.steps - arguments.steps // 4
    row = {"wheels": wheels, "ranks": ranks, "gl": report["gl"]["renderer"]}
    if ranks == 1:
        return row | {"busy": (report["processor_seconds"] - before["processor_seconds"]) / steps, "planning": 0, "moving": 0, "tiles": 0, "bytes": 0, "exchanges": 0, "balance": 1}
    told = {key: (report["ranks"][key] - before["ranks"][key]) / steps
            for key in ("busy", "planning", "moving", "tiles_moved", "bytes_moved", "exchanges")}
    return row | {"busy": told["busy"], "planning": told["planning"], "moving": told["moving"], "tiles": told["tiles_moved"], "bytes": told["bytes_moved"],
                  "exchanges": told["exchanges"], "balance": report["ranks"]["balance"]}


def fit(rows):
    """a, w, p, q of the model, none below 0: those that would be are left out."""
    names = ["a", "w", "p", "q"]
    used = [row for row in rows if row["ranks"] != CHECKED]

    def columns(row):
        return [row["ranks"], row["wheels"], row["ranks"] * row["wheels"], row["tiles"]]

    keep = list(range(4))
    while True:
        matrix = numpy.array([[columns(row)[k] / row["busy"] for k in keep] for row in used])  # each run counts by its share
        values = numpy.linalg.lstsq(matrix, numpy.ones(len(used)), rcond=None)[0]
        if min(values) >= 0 or len(keep) == 1:
            break
        keep.pop(int(numpy.argmin(values)))
    found = dict.fromkeys(names, 0.0) | {names[k]: float(v) for k, v in zip(keep, values)}
    for row in rows:
        row["modelled"] = sum(found[name] * value for name, value in zip(names, columns(row)))
    return found


def half(found, bodies):
    """The most ranks at which each still spends at least half of its time on its own bodies, by the model."""
    return max(1, math.floor(found["w"] * bodies / (found["a"] + found["p"] * bodies))) if found["a"] + found["p"] > 0 else math.inf


def keep(kept, rows, found, runs):
    kept.renderer = rows[-1]["gl"]
    for row in rows:
        one = next((r["busy"] for r in rows if r["wheels"] == row["wheels"] and r["ranks"] == 1), None)
        if row["busy"] <= 0:
            raise pages.Told(f"{row['wheels']} wheels, {row['ranks']} ranks: fewer steps took longer; measure again when nothing else runs, or with more --steps")
        values = {"busy": (row["busy"] * 1e3, "ms"), "modelled": (row["modelled"] * 1e3, "ms"), "planning": (row["planning"] * 1e3, "ms"),
                  "moving": (row["moving"] * 1e3, "ms"), "tiles": (row["tiles"], ""), "bytes": (row["bytes"], "B"), "exchanges": (row["exchanges"], "")}
        if one is not None:
            values["efficiency"] = one / row["busy"], ""
        for name, (value, unit) in values.items():
            kept.add(f"w{row['wheels']}_r{row['ranks']}.{name}", value, unit, runs=runs)
    for name in "awpq":
        kept.add(f"model.{name}", found[name] * 1e6, "us")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow")
    parser.add_argument("--wheels", type=lambda text: [int(n) for n in text.split(",")], default=[100, 200, 400])
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")], default=[1, 2, 3, 4, 8])
    parser.add_argument("--model", default="box")
    parser.add_argument("--steps", type=int, default=160)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--json")
    record.add_option(parser)
    arguments = parser.parse_args()
    rows, kept = [], record.Record("ranks", arguments.furrow)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([arguments.furrow, "synth", "-o", str(folder / "plain.furrow"), "--posts", "2049x2049", "--spacing", "1", "--kind", "plain"],
                       check=True, capture_output=True)
        for wheels in arguments.wheels:
            for ranks in arguments.ranks:
                runs = sorted((measure(arguments, folder, wheels, ranks) for _ in range(arguments.runs)), key=lambda row: row["busy"])
                rows.append(runs[len(runs) // 2])
                print(f"{wheels} wheels, {ranks} ranks: {rows[-1]['busy'] * 1e3:.2f} ms of processors a step", file=sys.stderr)
    found = fit(rows)
    print("| wheels | ranks | processor time a step, ms | by the model | planning | moving | tiles moved | bytes moved | exchanges | efficiency |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for row in rows:
        one = next((r["busy"] for r in rows if r["wheels"] == row["wheels"] and r["ranks"] == 1), math.nan)
        print(f"| {row['wheels']} | {row['ranks']} | {row['busy'] * 1e3:.2f} | {row['modelled'] * 1e3:.2f} | {row['planning'] * 1e3:.3f} | "
              f"{row['moving'] * 1e3:.3f} | {row['tiles']:.3f} | {row['bytes']:.0f} | {row['exchanges']:.2f} | {one / row['busy']:.2f} |")
    print(f"\na = {found['a'] * 1e6:.0f} us, w = {found['w'] * 1e6:.1f} us, p = {found['p'] * 1e6:.2f} us, q = {found['q'] * 1e6:.0f} us")
    checked = [abs(row["modelled"] / row["busy"] - 1) for row in rows if row["ranks"] == CHECKED]
    fitted = [abs(row["modelled"] / row["busy"] - 1) for row in rows if row["ranks"] != CHECKED]
    print(f"the model is off by at most {max(fitted) * 100:.0f} % where it was fitted" +
          (f", and by at most {max(checked) * 100:.0f} % at {CHECKED} ranks" if checked else ""))
    for power in (2, 3, 4, 5):
        print(f"10^{power} bodies: half of the time is its own work up to {half(found, 10 ** power)} ranks")
    keep(kept, rows, found, arguments.runs)
    kept.write(arguments.figures)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps({"rows": rows, "model": found}, indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except pages.Told as told:
        sys.exit(f"{sys.argv[0]}: {told}")
