#!/usr/bin/env python3
"""The measured wheel of a single-wheel rig (C. Pavlov, CMU) beside the command: sinkage, drawbar and side force, trial by trial.

    python3 bench/measured_wheel.py rel/tools/furrow --rig FOLDER -o bench-out      # FOLDER: wheel_smooth.csv, wheel_grouser.csv

One constant, slip sinkage, is fitted to the smooth wheel at slips of -0.5 to 0.9. Then it is frozen, and all else is told as it is.
"""
import argparse
import csv
import json
import math
import pathlib
import sys
import tempfile

import lanes
import record
from pages import publish, table

RADIUS, WIDTH, SPEED, LENGTH = 0.058, 0.05, 0.01, 0.5
SPACING, COARSEST = 0.004, 0.064
GROUSERS = 16                 # the rig's page tells their height, 5 mm, and not how many there are
KAPPAS = (0.0, 0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)
DRAGGED_MOST = -1000.0        # the slip that stands for a locked wheel


def soil_text(slip):
    return (f"bekker_kc: 0, bekker_kphi: 8e6, bekker_n: {1.46 + 0.01 * slip!r}, cohesion: 1000, friction_angle: 29, janosi_shear: 0.021, "
            "elastic_stiffness: 4e7, damping: 0, repose: 29")


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


def slip_of(trial, angle=0.0):
    """The scene's slip, 1 - way / rim. Below 0 the rig's is rim / way - 1."""
    along, rim = trial["way_mm_s"] * math.cos(math.radians(angle)), trial["rim"]
    return max(1 - along / rim, DRAGGED_MOST) if rim > 0 else DRAGGED_MOST


def angle_of(trial):
    """The yaw that stands for the trial's slip angle. At 90 degrees no way is along the wheel's plane, so that a slip of 0.99 says nothing of
    its turning: the yaw is as little less as makes the rim as fast as it was."""
    angle = trial["slip_angle_deg"]
    if angle == 90 and trial["rim"] > 0:
        angle = math.degrees(math.acos(trial["rim"] * 0.01 / trial["way_mm_s"]))
    return angle


class Rig:
    def __init__(self, furrow, folder, redistribute):
        self.furrow, self.folder, self.redistribute = furrow, folder, redistribute
        self.store = lanes.ground(furrow, folder, COARSEST)
        self.run = None  # run.json of the last drive
        self.digs = lanes.accepts(furrow, folder, "slip_sinkage", "1")
        self.least = DRAGGED_MOST if self.accepts_slip(DRAGGED_MOST) else -0.99

    def accepts_slip(self, slip):
        lane = lanes.Lane("a", RADIUS, WIDTH, 20.0, slip=slip, length=0.01, speed=SPEED)
        try:
            lanes.drive(self.furrow, self.store, self.folder, [lane], SPACING, soil_text(0), "")
        except lanes.Failed:
            return False
        return True

    def drive(self, trials, grousers, kappa, heights=None):
        """What the command says of each trial: sinkage mm, drawbar N, side N, fz N. heights: of the axles, m, instead of loads.
        None for a trial whose slip no scene can give."""
        answers, keys = [None] * len(trials), {}
        for i, trial in enumerate(trials):
            keys.setdefault(trial["setting"], []).append(i)
        for setting, own in keys.items():
            way = []
            for i in own:
                angle = angle_of(trials[i])
                slip = slip_of(trials[i], angle)
                if slip < self.least - 0.02:
                    continue
                way.append((i, lanes.Lane(f"trial{i}", RADIUS, WIDTH, trials[i]["load_N"] if heights is None else None, slip=min(max(slip, self.least), 0.99),
                                          length=LENGTH, speed=SPEED, grousers=GROUSERS if grousers else 0, grouser_height=0.005,
                                          yaw=-angle if heights is not None else 0.0, height=None if heights is None else heights[i])))
            if not way:
                continue
            extra = self.redistribute + (f", slip_sinkage: {kappa!r}" if self.digs and kappa is not None else "")
            driven = lanes.drive(self.furrow, self.store, self.folder, [lane for _, lane in way], SPACING, soil_text(setting), extra)
            self.run = driven.run
            for i, lane in way:
                found = lanes.steady(lane, driven, 0.3, LENGTH)
                answers[i] = {"sinkage": found["sinkage"] * 1e3, "drawbar": found["drawbar"], "side": found["side"], "fz": found["fz"]}
        return answers

    def at_an_angle(self, trials, grousers, kappa):
        """Loads by trial and error, since a path with an attitude takes none: heights are moved until fz is the load."""
        low, high = [RADIUS - 0.1] * len(trials), [RADIUS - 0.0005] * len(trials)
        for _ in range(12):
            heights = [(a + b) / 2 for a, b in zip(low, high)]
            answers = self.drive(trials, grousers, kappa, heights)
            for i, (trial, answer) in enumerate(zip(trials, answers)):
                if answer and answer["fz"] > trial["load_N"]:
                    low[i] = heights[i]
                else:
                    high[i] = heights[i]
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
            rms([(abs(a["side"]), abs(t["lateral_N"])) for t, a in pairs]))


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
            cells += [f"{mean([abs(trials[i]['lateral_N']) for i in own]):.1f}", f"{mean([abs(a['side']) for a in known]):.1f}" if known else ""]
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
    elif rig.digs:
        kappa, one, setting = fit(rig, fitted)
        say(f"Slip sinkage {kappa:.2f} fits the smooth wheel best; left out one trial at a time {one:.2f} mm, one slip at a time {setting:.2f} mm RMS.\n",
            what="fit", kappa=kappa, leave_one_trial=one, leave_one_slip=setting)
    else:
        say("This build has no `redistribute.slip_sinkage`: nothing is fitted.\n", what="fit", kappa=None)
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
        got = rig.at_an_angle(of, bars, kappa) if angle else rig.drive(of, bars, kappa)
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
    parser.add_argument("--redistribute", default="", help="keys for every scene, as in 'bulldozing: 0'")
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
            rig = Rig(options.furrow, folder, ", " * bool(options.redistribute) + options.redistribute)
            told = report(rig, options.rig, options.quick, options.slip_sinkage)
    except lanes.Failed as error:
        print(f"measured_wheel.py: {error}", file=sys.stderr)
        return 1
    kept.seen(rig.run)
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
