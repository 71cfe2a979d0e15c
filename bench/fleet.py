"""What a step of many bodies costs: wheels that drive in all directions, spread over a plain.

    python3 bench/fleet.py build/tools/furrow [--before FURROW] [--cpu] [--wheels 200,400,1000,4096] [--model box] [--steps 60] [--json FILE]

Wheels of 0.5 m radius and 0.3 m width, 0.05 m deep, at 2.5 m/s: at posts 1/8 m apart and steps of 0.05 s a path sample for each wheel
and step. The plain has 2049 x 2049 posts 1 m apart; the wheels stand on a square of 1,800 m. No picture. `--before`: another build, which
takes turns with the first one. `--cpu`: so does the first build with `compute: cpu`. `--scene FILE` only writes a scene of the first number of wheels. Figures are medians over the steps after
the first second, of the runs the median. Compare ratios, not figures, between machines."""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import pages
import record

SIDE, TIME_STEP, SPEED, SPACING = 1800, 0.05, 2.5, 0.125
NAMES = ("before", "now", "cpu")  # what takes turns
SOILS = ("scm", "sumner", "slippage")  # models that need a soil


def scene(wheels, model, steps):
    """The text of a scene. Each wheel drives straight on, in a direction of its own."""
    across = math.ceil(math.sqrt(wheels))
    apart = SIDE / across
    lines = ["scene: 1", f"time_step: {TIME_STEP}", f"end_time: {steps * TIME_STEP}", f"spacing: {SPACING}",
             f"redistribute: {{model: {model}}}"] + (["soil: {name: dry_sand}"] if model in SOILS else []) + ["cache: {slots: 4096}", "objects:"]
    far = SPEED * TIME_STEP * (steps + 4)
    for i in range(wheels):
        x, y, turn = 120 + (i % across + 0.5) * apart, 120 + (i // across + 0.5) * apart, 2.399963 * i
        lines.append(f"  - {{name: w{i}, shape: {{wheel: {{radius: 0.5, width: 0.3}}}}, sink: 0.05, path: {{points: "
                     f"[[{x:.3f}, {y:.3f}], [{x + far * math.cos(turn):.3f}, {y + far * math.sin(turn):.3f}]], speed: {SPEED}}}}}")
    return "\n".join(lines) + "\n"


def drive(furrow, folder, path, settings=()):
    """run.json of one drive into an overlay of its own."""
    overlay, out = folder / "overlay.furrow", folder / "out"
    subprocess.run(["rm", "-rf", str(overlay), str(out)], check=True)
    done = subprocess.run([furrow, "drive", str(path), "--store", str(folder / "plain.furrow"), "--overlay", str(overlay), "-o", str(out), *settings],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise pages.Told(f"{furrow}: {done.stderr.strip()}")
    return json.loads((out / "run.json").read_text())


def median(values):
    return sorted(values)[len(values) // 2]


def measure(arguments, folder):
    builds = {"now": (arguments.furrow, ())} | ({"before": (arguments.before, ())} if arguments.before else {})
    builds |= {"cpu": (arguments.furrow, ("--set", "compute=cpu"))} if arguments.cpu else {}
    for wheels in arguments.wheels:
        path = folder / "fleet.yaml"
        path.write_text(scene(wheels, arguments.model, arguments.steps))
        runs = {name: [] for name in builds}
        for _ in range(arguments.runs):
            for name, (furrow, settings) in builds.items():
                runs[name].append(drive(furrow, folder, path, settings))
        row = {"wheels": wheels, "model": arguments.model, "load": os.getloadavg()[0]}
        for name, found in runs.items():
            row[name] = {"step_ms": median([run["step_ms"]["p50"] for run in found]), "gl": found[0]["gl"]["renderer"],
                         "each": [run["step_ms"]["p50"] for run in found],
                         "passes_a_step": (found[0]["passes"]["displace"] + found[0]["passes"]["redistribute"]) / found[0]["steps"],
                         "batches": found[0]["counts"]["units"].get("batch", 0), "gpu_bytes": found[0]["memory"]["gpu_bytes"]}
        yield row


def keep(kept, rows):
    for row in rows:
        for name in NAMES:
            if name in row:
                kept.renderer = row[name]["gl"]
                kept.add(f"w{row['wheels']}.{name}.step_ms", row[name]["each"], "ms")
                kept.add(f"w{row['wheels']}.{name}.passes", row[name]["passes_a_step"], "")
        if "before" in row:
            kept.add(f"w{row['wheels']}.ratio", [now / before for now, before in zip(row["now"]["each"], row["before"]["each"])], "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow")
    parser.add_argument("--before")
    parser.add_argument("--cpu", action="store_true")
    parser.add_argument("--wheels", default="200,400,1000,4096", type=lambda text: [int(n) for n in text.split(",")])
    parser.add_argument("--model", default="box")
    parser.add_argument("--steps", default=60, type=int)
    parser.add_argument("--runs", default=3, type=int)
    parser.add_argument("--json")
    parser.add_argument("--scene")
    record.add_option(parser)
    arguments = parser.parse_args()
    if arguments.scene:
        pathlib.Path(arguments.scene).write_text(scene(arguments.wheels[0], arguments.model, arguments.steps))
        return
    rows, kept = [], record.Record("fleet", arguments.furrow)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([arguments.furrow, "synth", "-o", str(folder / "plain.furrow"), "--posts", "2049x2049", "--spacing", "1",
                        "--kind", "plain"], check=True, capture_output=True)
        for row in measure(arguments, folder):
            rows.append(row)
            print(json.dumps(row), flush=True)
    names = [name for name in NAMES if name in rows[0]]
    head = ["wheels"] + [f"{name}: ms a step" for name in names] + [f"{name}: passes a step" for name in names] + ["load"]
    print(pages.table(head, [[str(row["wheels"])] + [pages.figure(row[name]["step_ms"]) for name in names] +
                             [pages.figure(row[name]["passes_a_step"]) for name in names] + [f"{row['load']:.1f}"] for row in rows]))
    keep(kept, rows)
    kept.write(arguments.figures)
    if arguments.json:
        pathlib.Path(arguments.json).write_text("".join(json.dumps(row) + "\n" for row in rows))


if __name__ == "__main__":
    try:
        main()
    except pages.Told as told:
        sys.exit(f"{sys.argv[0]}: {told}")
