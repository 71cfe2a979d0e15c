#!/usr/bin/env python3
"""Ten drives at random places beside the map of furrow mobility. Prints a table; takes some minutes.

    bench/mobility.py FURROW [--dem gabilan_dtm1m.bil] [--vehicle offroad|rover] [--soil SOIL] [--seed 1] [--places 10]

The map is made of real ground with posts a metre apart, or of a ridged one. Places are chosen by seed, where the slope hardly changes over the way: spread
over slopes well below, near and above what the map says the vehicle can climb, each with a heading of its own. There furrow drive sends the
vehicle straight on. Told: what the map says of its way, and what the drive did. Both rest on the same soil model, so this is consistency.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

import pages
import record

MODELS = pathlib.Path(__file__).parents[1] / "tools" / "scenes" / "vehicles"
# Of each: soil, gravity, speed of the rims m/s, way m, posts of the drive m, its wheelbase and its wheels' radius m
KINDS = {"offroad": ("dry_sand", 9.81, 0.5, 5.0, 0.03125, 2.8, 0.4), "rover": ("lunar", 1.62, 0.1, 1.5, 0.015625, 1.2, 0.15)}
SCENE = """scene: 1
time_step: 0.002
end_time: {end}
gravity: {gravity}
spacing: {posts}
soil: {{name: {soil}, damping: 0}}
redistribute: {{model: scm}}
vehicles:
  - name: v
    model: {model}
    start: {{at: [{x}, {y}], yaw: {yaw}}}
    soil: [wheel*]
    driver: {{path: {{points: [[{x}, {y}], [{x1}, {y1}]], speed: {speed}}}, steer: [steer_*], drive: [drive_*]}}
stuck: {{after: 5, below: {still}}}
output: {{vehicles: 10, forces: 10}}
"""


def run(furrow, *arguments):
    done = subprocess.run([str(furrow), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("%s: %s" % (" ".join(map(str, arguments)), done.stderr))
    return done.stdout


class Ground:
    """Slopes of a store, as the map takes them: central differences at its posts, straight between."""

    def __init__(self, furrow, store):
        info = json.loads(run(furrow, "info", store, "--json"))
        self.furrow, self.store, self.spacing = furrow, store, info["spacing"]
        self.size = (info["posts"][0] - 1) * self.spacing, (info["posts"][1] - 1) * self.spacing
        self.heights = {}

    def around(self, x, y):
        i, j = round(x / self.spacing), round(y / self.spacing)
        return [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]

    def fetch(self, places):
        """Reads what the slopes at these places need, all at once."""
        posts = sorted({post for place in places for post in self.around(*place)} - set(self.heights))
        if posts:
            lines = "".join("%r %r\n" % (i * self.spacing, j * self.spacing) for i, j in posts)
            done = subprocess.run([str(self.furrow), "query", str(self.store), "--json"], input=lines, capture_output=True, text=True, check=True)
            points = json.loads(done.stdout)["points"] if len(posts) > 1 else [json.loads(done.stdout)]
            self.heights.update(zip(posts, (point["height"] for point in points)))

    def slope(self, x, y):
        """Rise to the east and to the north at a cell that was fetched."""
        h = [self.heights[post] for post in self.around(x, y)]
        return ((h[0] - h[1]) / 2 / self.spacing, (h[2] - h[3]) / 2 / self.spacing) if all(v is not None for v in h) else None


def verdict(table, slope, heading):
    """The map's: of the table's row and column, the slip straight between rows."""
    at = min(slope / 0.5, len(table["slopes"]) - 1.001)
    low, high = table["slopes"][int(at)], table["slopes"][int(at) + 1]
    column = round((90 - heading) / 5)
    a, b = low["verdicts"][column], high["verdicts"][column]
    if b["reason"] != "go" or a["reason"] != "go":
        return b["reason"], None
    return "go", a["slip"] + (b["slip"] - a["slip"]) * (at - int(at))


def along(ground, table, x, y, yaw, way):
    """Slopes, headings above the contour and verdicts on a way."""
    told = []
    ways = [k * ground.spacing / 2 for k in range(int(way / ground.spacing * 2) + 1)]
    places = [(x + s * math.cos(yaw), y + s * math.sin(yaw)) for s in ways]
    ground.fetch(places)
    for place in places:
        rise = ground.slope(*place)
        if rise is None:
            return None
        up = rise[0] * math.cos(yaw) + rise[1] * math.sin(yaw)
        steep = math.hypot(*rise)
        if up < -0.02:
            return None
        heading = math.degrees(math.asin(max(0, min(1, up / steep)))) if steep > 0 else 90
        slope = math.degrees(math.atan(steep))
        told.append((slope, heading, *verdict(table, slope, heading)))
    return told


def choose(ground, table, length, way, count, seed):
    """Places for slopes from 0.4 to 1.3 of the steepest, half straight up, half at other headings."""
    dice, found = random.Random(seed), []
    steepest = table["steepest_up"]
    wanted = [steepest * (0.4 + 0.9 * i / (count - 1)) for i in range(count)]
    border = 2 * length + way
    places = [tuple(round(dice.uniform(border, size - border), 3) for size in ground.size) for _ in range(5000)]
    ground.fetch(places)
    for x, y in places:
        if len(found) == count:
            break
        slope = wanted[len(found)]
        off = 0 if len(found) % 2 == 0 else dice.uniform(15, 75)
        rise = ground.slope(x, y)
        if rise is None or abs(math.degrees(math.atan(math.hypot(*rise))) - slope) > 0.06 * slope + 0.2:
            continue
        yaw = math.atan2(rise[1], rise[0]) + math.radians(off) * dice.choice((-1, 1))
        told = along(ground, table, x - length / 2 * math.cos(yaw), y - length / 2 * math.sin(yaw), yaw, way + length)
        if told is None or max(t[0] for t in told) - min(t[0] for t in told) > 0.2 * slope + 1 or max(t[1] for t in told) - min(t[1] for t in told) > 25:
            continue
        found.append((x, y, yaw, told))
    return found


def drive(furrow, folder, store, kind, soil, place):
    """Whether it passed, and its mean slip in the second half of its way."""
    _, gravity, speed, way, posts, _, radius = KINDS[kind]
    x, y, yaw, _ = place
    (folder / "scene.yaml").write_text(SCENE.format(end=way / speed * 8, gravity=gravity, posts=posts, soil=soil, model=MODELS / (kind + ".xml"), x=x, y=y,
                                                    yaw=math.degrees(yaw), x1=x + 2 * way * math.cos(yaw), y1=y + 2 * way * math.sin(yaw),
                                                    speed=speed, still=0.03 * speed))
    (folder / "over.furrow").unlink(missing_ok=True)
    out = folder / "out"
    run(furrow, "drive", folder / "scene.yaml", "--store", store, "-o", out, "--overlay", folder / "over.furrow")
    with open(out / "vehicles.csv", encoding="ascii") as file:
        rows = []
        for r in csv.DictReader(file):
            turns = [float(value) for name, value in r.items() if name.startswith("q:roll_")]
            rows.append((sum(turns) / len(turns) * radius, float(r["x"]), float(r["y"]), float(r["z"])))
    gone = [(r[1] - rows[0][1]) * math.cos(yaw) + (r[2] - rows[0][2]) * math.sin(yaw) for r in rows]
    aside = [(r[2] - rows[0][2]) * math.cos(yaw) - (r[1] - rows[0][1]) * math.sin(yaw) for r in rows]
    passed = gone[-1] >= way
    first = next((i for i, g in enumerate(gone) if g > way / 2), None)
    if not passed or first is None:
        return False, None, max(gone), aside[-1]
    last = next(i for i, g in enumerate(gone) if g >= way)
    covered = sum(math.dist(a[1:], b[1:]) for a, b in zip(rows[first:last], rows[first + 1:last + 1]))
    return True, 1 - covered / (rows[last][0] - rows[first][0]), gone[last], aside[last]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow", type=pathlib.Path)
    parser.add_argument("--dem", type=pathlib.Path, help="real ground, posts a metre apart; without it a ridged one is made")
    parser.add_argument("--vehicle", choices=sorted(KINDS), default="offroad")
    parser.add_argument("--soil")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--places", type=int, default=10)
    record.add_option(parser)
    given = parser.parse_args()
    furrow, kept, rows = given.furrow.resolve(), record.Record("mobility", given.furrow), []
    soil, gravity, _, way, _, length, _ = KINDS[given.vehicle]
    soil = given.soil or soil
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = folder / "ground.furrow"
        if given.dem:
            run(furrow, "import", given.dem, "-o", store, "--spacing", 1)
        else:
            run(furrow, "synth", "-o", store, "--posts", "513x513", "--spacing", 1, "--kind", "ridged", "--relief", 60)
        table = json.loads(run(furrow, "mobility", store, "--vehicle", MODELS / (given.vehicle + ".xml"), "--soil", soil, "--gravity", gravity,
                               "-o", folder / "map.tif", "--json"))
        print("%s in %s at %g m/s2: the map says up to %g degrees straight up, %g along the slope" %
              (given.vehicle, soil, gravity, table["steepest_up"], table["steepest_along"]), flush=True)
        ground = Ground(furrow, store)
        print("| place | slope, degrees | heading above the contour | the map | the drive | slip, map | slip, drive | aside, m |")
        print("| --- | --- | --- | --- | --- | --- | --- | --- |")
        agree = 0
        for place in choose(ground, table, length, way, given.places, given.seed):
            told = place[3]
            stops = [t[2] for t in told if t[2] != "go"]
            passed, slip, gone, aside = drive(furrow, folder, store, given.vehicle, soil, place)
            half = told[len(told) // 2:]
            mean = sum(t[3] for t in half) / len(half) if not stops else None
            agree += passed == (not stops)
            row = ["%.1f to %.1f" % (min(t[0] for t in told), max(t[0] for t in told)), "%.0f" % (sum(t[1] for t in told) / len(told)),
                   "go" if not stops else "%s on %.0f %%" % (stops[0], 100 * len(stops) / len(told)),
                   "passes" if passed else "stops after %.1f m" % gone, "" if mean is None else "%.2f" % mean, "" if slip is None else "%.2f" % slip]
            print("| %.1f, %.1f | %s | %.2f |" % (place[0], place[1], " | ".join(row), aside), flush=True)
            if not stops:
                rows.append(row)
        print("%d of %d agree" % (agree, given.places))
        kept.seen(json.loads((folder / "out" / "run.json").read_text()))
    kept.page("mobility", pages.table(["slope, degrees", "heading above the contour", "the map", "the drive", "slip, map", "slip, drive"], rows))
    kept.write(given.figures)


if __name__ == "__main__":
    main()
