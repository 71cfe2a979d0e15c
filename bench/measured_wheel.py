#!/usr/bin/env python3
"""The measured wheel of a single-wheel rig (C. Pavlov, CMU) beside `furrow rig`: sinkage, drawbar and side force, trial by trial, at slip angles of 0, 30 and 90 degrees.

    python3 bench/measured_wheel.py rel/tools/furrow --rig FOLDER -o bench-out      # FOLDER: wheel_smooth.csv, wheel_grouser.csv
    python3 bench/measured_wheel.py rel/tools/furrow --rig FOLDER --table           # the RMS of each wheel and angle alone, in a minute
    python3 bench/measured_wheel.py rel/tools/furrow --rig FOLDER --table --set redistribute.bulldozing=0

One constant, slip sinkage, is fitted to the smooth wheel at slips of -0.5 to 0.9. Then it is frozen, and all else is told as it is. Each trial has its own load.
Trials of one rim speed and one angle have their mean slip.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import record
from pages import Told, publish, table

RADIUS, WIDTH, SPEED = 0.058, 0.05, 0.01
SPACING = 0.004
BARS, BAR_HEIGHT, BAR_THICKNESS = 24, 0.005, 0.0015   # the lab's mesh and drawing show 24; nobody tells their thickness
KAPPAS = (0.0, 0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)
ANGLES = (0, 30, 90)
AT_ONCE = 2                   # runs of the command


def soil_text(slip):
    return (f"bekker_kc: 0, bekker_kphi: 8e6, bekker_n: {1.46 + 0.01 * slip!r}, cohesion: 1000, friction_angle: 29, janosi_shear: 0.021, "
            "elastic_stiffness: 4e7, damping: 0, repose: 29, unit_weight: 13030")


def trials_of(path):
    """Numbers of each line. `rim` is the rim's speed by the trial's slip, since the file has it in whole numbers; `setting` is the slip
    that trials of one rim speed share."""
    with open(path) as file:
        found = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    for trial in found:
        slip = trial["slip"]
        trial["rim"] = max(trial["way_mm_s"] * (1 + slip if slip < 0 else 1 / (1 - slip)), 0.0)
        same = [other["slip"] for other in found if other["rim_mm_s"] == trial["rim_mm_s"] and other["slip_angle_deg"] == trial["slip_angle_deg"]]
        trial["setting"] = round(sum(same) / len(same), 2) + 0.0
    return found


def slip_of(setting):
    """The command's slip, 1 - way / rim. Below 0 the rig's is rim / way - 1."""
    return "locked" if setting <= -1 else repr(setting / (1 + setting) if setting < 0 else setting)


class Rig:
    """Asks `furrow rig`. settings: KEY=VALUE for all runs."""

    def __init__(self, furrow, folder, settings=(), spacing=SPACING):
        self.furrow, self.folder, self.settings, self.spacing = furrow, pathlib.Path(folder), list(settings), spacing
        self.runs = 0

    def ask(self, out, angle, setting, loads, grousers, kappa):
        """Rows of wheels under these loads, in their order."""
        bars = f", grousers: {BARS}, grouser_height: {BAR_HEIGHT!r}, grouser_thickness: {BAR_THICKNESS!r}" if grousers else ""
        settings = self.settings + ([f"redistribute.slip_sinkage={kappa!r}"] if kappa is not None else [])
        command = [self.furrow, "rig", "-o", str(self.folder / out), "--shape", f"wheel: {{radius: {RADIUS!r}, width: {WIDTH!r}{bars}}}",
                   "--soil", "{" + soil_text(setting) + "}", "--load", ",".join(map(repr, loads)), f"--slip={slip_of(setting)}", "--slip-angle", repr(angle),
                   "--speed", repr(SPEED), "--spacing", repr(self.spacing), "--json"] + [word for one in settings for word in ("--set", one)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise Told(f"furrow rig at {angle:g} degrees, slip {setting:g}: {done.stderr.strip()}")
        return json.loads(done.stdout)["rows"]

    def drive(self, trials, grousers, kappa):
        """What the command says of each trial: sinkage mm, drawbar N, side N, fz N; None for one that sank out of sight."""
        answers, groups = [None] * len(trials), {}
        for i, trial in enumerate(trials):
            groups.setdefault((trial["slip_angle_deg"], trial["setting"]), []).append(i)
        with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
            asked = []
            for (angle, setting), own in groups.items():
                self.runs += 1
                loads = [trials[i]["load_N"] for i in own]
                asked.append((own, pool.submit(self.ask, f"run-{self.runs}", angle, setting, loads, grousers, kappa)))
            for own, future in asked:
                for i, row in zip(own, future.result(), strict=True):
                    if row["state"] != "sunk":
                        answers[i] = {"sinkage": row["sinkage"] * 1e3, "drawbar": row["drawbar"], "side": row["side"], "fz": row["fz"]}
        return answers


def rms(pairs):
    return math.sqrt(sum((a - b) ** 2 for a, b in pairs) / len(pairs)) if pairs else math.nan


def between(kappas, values, kappa):
    """The parabola through the three fitted points nearest to kappa."""
    near = sorted(sorted(range(len(kappas)), key=lambda k: abs(kappas[k] - kappa))[:3])
    return sum(values[i] * math.prod((kappa - kappas[k]) / (kappas[i] - kappas[k]) for k in near if k != i) for i in near)


def best_kappa(curves, trials, kept):
    grid = [k * 0.01 for k in range(int(KAPPAS[-1] * 100) + 1)]
    return min(grid, key=lambda kappa: sum((between(KAPPAS, curves[i], kappa) - trials[i]["sinkage_mm"]) ** 2 for i in kept))


def fit(rig, trials):
    """The constant, and the errors of what is left out: one trial, and one slip with its three trials."""
    driven = [rig.drive(trials, False, kappa) for kappa in KAPPAS]
    curves = [[answers[i]["sinkage"] for answers in driven] for i in range(len(trials))]
    everything = range(len(trials))

    def left_out(same):
        pairs = []
        for i in everything:
            kappa = best_kappa(curves, trials, [k for k in everything if not same(k, i)])
            pairs.append((between(KAPPAS, curves[i], kappa), trials[i]["sinkage_mm"]))
        return rms(pairs)

    return best_kappa(curves, trials, everything), left_out(lambda k, i: k == i), left_out(lambda k, i: trials[k]["setting"] == trials[i]["setting"])


def errors(trials, answers):
    pairs = [(t, a) for t, a in zip(trials, answers) if a]
    return (rms([(a["sinkage"], t["sinkage_mm"]) for t, a in pairs]), rms([(a["drawbar"], -t["drag_N"]) for t, a in pairs]),
            rms([(a["side"], t["lateral_N"]) for t, a in pairs]))


def trial_table(trials, answers, side=False):
    """One line a setting: the means of its trials."""
    lines, settings = [], {}
    for i, trial in enumerate(trials):
        settings.setdefault(trial["setting"], []).append(i)
    for setting, own in sorted(settings.items()):
        def mean(values):
            return sum(values) / len(values)
        cells = [f"{setting:.2f}", f"{mean([trials[i]['load_N'] for i in own]):.1f}", f"{mean([trials[i]['sinkage_mm'] for i in own]):.1f}"]
        known = [answers[i] for i in own if answers[i]]
        cells.append(f"{mean([a['sinkage'] for a in known]):.1f}" if known else "no scene says it")
        cells += [f"{mean([-trials[i]['drag_N'] for i in own]):.1f}", f"{mean([a['drawbar'] for a in known]):.1f}" if known else ""]
        if side:
            cells += [f"{mean([trials[i]['lateral_N'] for i in own]):.1f}", f"{mean([a['side'] for a in known]):.1f}" if known else ""]
        if known:
            cells.append(f"{max(abs(a['fz'] / trials[i]['load_N'] - 1) for i, a in zip(own, (answers[i] for i in own)) if a) * 100:.1f} %")
        else:
            cells.append("")
        lines.append(cells)
    head = ["slip", "load, N", "measured sinkage, mm", "told", "measured drawbar, N", "told"] + ["measured side force, N", "told"] * side
    return table(head + ["fz off the load"], lines)


def summary(trials, answers, side=False):
    depth, pull, across = errors(trials, answers)
    text = f"RMS over {sum(a is not None for a in answers)} trials: sinkage {depth:.2f} mm, drawbar {pull:.2f} N"
    return text + (f", side force {across:.2f} N" if side else "") + "."


def rms_table(rig, folder, frozen=None):
    """RMS of sinkage mm, drawbar N and side force N of each wheel and angle. Returns Markdown, and the figures by wheel and angle."""
    lines, found = [], {}
    for name, bars in (("smooth", False), ("grouser", True)):
        trials = [trial for trial in trials_of(folder / f"wheel_{name}.csv") if trial["slip_angle_deg"] in ANGLES]
        answers = rig.drive(trials, bars, frozen)
        for angle in ANGLES:
            own = [i for i, trial in enumerate(trials) if trial["slip_angle_deg"] == angle]
            pairs = [trials[i] for i in own], [answers[i] for i in own]
            found[name, angle] = errors(*pairs)
            lines.append([name, f"{angle:g}", *(f"{value:.2f}" for value in found[name, angle]), f"{sum(a is not None for a in pairs[1])} of {len(own)}"])
    return table(["wheel", "slip angle", "sinkage, mm", "drawbar, N", "side force, N", "trials"], lines), found


def report(rig, folder, quick, frozen=None):
    """frozen: the constant of an earlier fit; None: it is fitted."""
    smooth, grouser = trials_of(folder / "wheel_smooth.csv"), trials_of(folder / "wheel_grouser.csv")

    def chosen(trials, angle, low, high):
        return [t for t in trials if t["slip_angle_deg"] == angle and low <= t["setting"] <= high]
    fitted = chosen(smooth, 0, -0.55, 0.95)
    told = []

    def say(text, **row):
        print(text, flush=True)
        told.append({"text": text, **row})

    kappa, one = frozen, None
    if frozen is not None:
        say(f"Slip sinkage {frozen:g}, fitted by an earlier run.\n", what="fit", kappa=frozen)
    else:
        kappa, one, setting = fit(rig, fitted)
        say(f"Slip sinkage {kappa:.2f} fits the smooth wheel best; left out one trial at a time {one:.2f} mm, one slip at a time {setting:.2f} mm RMS.\n",
            what="fit", kappa=kappa, leave_one_trial=one, leave_one_slip=setting)
    answers = rig.drive(fitted, False, kappa)
    say("Smooth wheel, slips -0.5 to 0.9, each trial under its own load:\n\n" + trial_table(fitted, answers) + "\n" + summary(fitted, answers))
    depth, pull, _ = errors(fitted, answers)
    say(f"\n| gate | | |\n| --- | --- | --- |\n| sinkage 2.0 mm RMS | {'met' if depth <= 2 else 'MISSED'} | {depth:.2f} mm |\n"
        f"| drawbar 3 N RMS | {'met' if pull <= 3 else 'MISSED'} | {pull:.2f} N |\n" +
        (f"| sinkage 2.5 mm left out | {'met' if one <= 2.5 else 'MISSED'} | {one:.2f} mm |\n" if one is not None else ""),
        what="smooth", sinkage_rms=depth, drawbar_rms=pull, trials=len(fitted))
    if quick:
        return told
    say("From here on nothing is fitted.\n")
    for key, name, trials, bars, angle, low, high in (
            ("locked", "Smooth wheel, locked and nearly locked", smooth, False, 0, -1, -0.65),
            ("grousers", "Wheel with grousers, 0 degrees", grouser, True, 0, -1, 0.95),
            ("smooth_30", "Smooth wheel at a slip angle of 30 degrees", smooth, False, 30, -1, 0.95),
            ("smooth_90", "Smooth wheel at a slip angle of 90 degrees", smooth, False, 90, -1, 0.95),
            ("grousers_30", "Wheel with grousers at 30 degrees", grouser, True, 30, -1, 0.95),
            ("grousers_90", "Wheel with grousers at 90 degrees", grouser, True, 90, -1, 0.95)):
        of = chosen(trials, angle, low, high)
        got = rig.drive(of, bars, kappa)
        say(f"{name}:\n\n{trial_table(of, got, side=angle > 0)}\n{summary(of, got, side=angle > 0)}\n", what=name, key=key,
            rms=dict(zip(("sinkage", "drawbar", "side"), errors(of, got))))
    return told


def keep(kept, told):
    """Figures of what report() told."""
    for part in told:
        if part.get("kappa") is not None:
            kept.add("slip_sinkage", part["kappa"], "")
            for name in ("trial", "slip"):
                if f"leave_one_{name}" in part:
                    kept.add(f"left_out.{name}", part[f"leave_one_{name}"], "mm")
        elif part.get("what") == "smooth":
            kept.add("smooth.sinkage_rms", part["sinkage_rms"], "mm")
            kept.add("smooth.drawbar_rms", part["drawbar_rms"], "N")
            kept.add("smooth.trials", part["trials"], "")
        elif "key" in part:
            for what, unit in (("sinkage", "mm"), ("drawbar", "N"), ("side", "N")):
                kept.add(f"{part['key']}.{what}_rms", part["rms"][what], unit)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow")
    parser.add_argument("--rig", type=pathlib.Path, required=True, help="folder of wheel_smooth.csv and wheel_grouser.csv")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a key of every scene, as in redistribute.bulldozing=0")
    parser.add_argument("--spacing", type=float, default=SPACING, metavar="M", help="m between posts")
    parser.add_argument("--table", action="store_true", help="the RMS of each wheel and angle alone, with the slip sinkage that the command has by itself")
    parser.add_argument("--quick", action="store_true", help="the smooth wheel alone")
    parser.add_argument("--slip-sinkage", type=float, metavar="K", help="the constant of an earlier fit; nothing is fitted then, which takes minutes")
    parser.add_argument("-o", "--out", type=pathlib.Path, help="a folder for measured_wheel.md and .jsonl")
    parser.add_argument("--publish", type=pathlib.Path, help="a page; the tables go between its markers `measured`")
    record.add_option(parser)
    options = parser.parse_args()
    missing = [name for name in ("wheel_smooth.csv", "wheel_grouser.csv") if not (options.rig / name).is_file()]
    if missing:
        print(f"{options.rig}: has no {' and no '.join(missing)}; give the folder of the rig's numbers by --rig. Nothing was compared.")
        return 0
    kept = record.Record("measured_wheel", options.furrow)
    try:
        with tempfile.TemporaryDirectory() as folder:
            rig = Rig(options.furrow, folder, options.set, options.spacing)
            if options.table:
                print(rms_table(rig, options.rig, options.slip_sinkage)[0])
                return 0
            told = report(rig, options.rig, options.quick, options.slip_sinkage)
    except Told as error:
        print(f"measured_wheel.py: {error}", file=sys.stderr)
        return 1
    keep(kept, told)
    if not options.quick:
        kept.page("measured", "\n".join(part["text"] for part in told))
    kept.write(options.figures)
    if options.publish:
        publish(options.publish, "measured", "\n".join(part["text"] for part in told))
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "measured_wheel.md").write_text("\n".join(part["text"] for part in told) + "\n")
        (options.out / "measured_wheel.jsonl").write_text("".join(json.dumps(part) + "\n" for part in told))
    return 0


if __name__ == "__main__":
    sys.exit(main())
