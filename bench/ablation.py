#!/usr/bin/env python3
"""What each effect costs by itself: the barest scene in which it can stand, driven without it and with it, in turn.

    python3 bench/ablation.py -o bench-out                # minutes; --quick: fewer and shorter drives
    python3 bench/ablation.py -o bench-out --publish      # and the table into bench/ACCURACY.md

Writes ablation.jsonl, ablation.md. Every figure is the median of the runs; a difference is that of two medians.
"""
import argparse
import copy
import json
import pathlib
import shutil
import signal
import statistics
import struct
import subprocess
import tempfile
import zlib

import pages
import record

HERE = pathlib.Path(__file__).resolve().parent
SIDE, FINE, SPEED = 128, 16, 2.0  # metres of the terrain; posts a metre of its fine store; m/s

# --- the scenes ---

WHEEL = {"wheel": {"radius": 0.5, "width": 0.4}}
PLATE = {"box": {"size": [0.8, 1.2, 0.05]}}
BRICK = {"box": {"size": [0.8, 0.4, 0.4]}}
SAND = {"soil": {"name": "dry_sand"}}


def scene(shape=None, model="none", **more):
    """Flat ground with the posts that are asked for, one object over it in a straight line, 1.6 posts of travel a step."""
    made = {"scene": 1, "store": "fine.furrow", "time_step": 0.05, "spacing": 1 / FINE, "redistribute": {"model": model}}
    if shape:
        made["objects"] = [{"name": "it", "shape": shape, "sink": 0.1}]
    return made | more


def view(*effects, images=1, **more):
    return {"view": {"size": [640, 360], "effects": list(effects),
                     "camera": {"fixed": {"eye": [30, 20, 20], "target": [60, 64, 0]}}, "images": images, **more}}


def cache(loaders, prefetch):
    """With fewer slots than there are tiles: where every tile has one, nothing is loaded ahead."""
    return {"cache": {"slots": 8, "loaders": loaders, "prefetch": prefetch}}


def slipping(made):
    for thing in made["objects"]:
        thing["slip"] = 0.2
    return made


def carrying(made):
    made["objects"][0]["carry"] = True
    return made


def loaded(made):
    del made["objects"][0]["sink"]
    made["objects"][0]["load"] = 4000
    return made


SCM = scene(WHEEL, "scm", **SAND)
SEEN = scene(WHEEL, **view())
EYE = {"name": "eye", "kind": "fixed", "pose": {"at": [30, 20, 20], "target": [60, 64, 0]}, "size": [640, 360], "rate": 20}  # a picture a step
MAPPED = SCM | {"soil": {"map": "classes.png", "classes": {1: "dry_sand", 2: "lete_sand"}, "default": "dry_sand"}}

# What is measured, the scene without, the scene with it. Which effects those are is what `furrow explain` says the second
# has and the first has not; every effect of its table is called for by one of these (checked).
PAIRS = [
    ("displace", scene(**view()), SEEN),
    ("box", scene(WHEEL), scene(WHEEL, "box")),
    ("sumner", scene(WHEEL), scene(WHEEL, "sumner", soil={"name": "sand", "compression": 0.3})),
    ("slippage", scene(WHEEL), scene(WHEEL, "slippage", **SAND)),
    ("scm", scene(WHEEL), SCM),
    ("sheet", scene(WHEEL), scene(WHEEL, "sheet")),
    ("soil_map", SCM, MAPPED),
    ("soil_rasters", SCM, SCM | {"soil": SAND["soil"] | {"rasters": {"cohesion": "classes.png"}}}),
    ("mesh", scene(BRICK), scene({"mesh": {"file": "brick.obj"}})),
    ("lugs", scene(WHEEL), scene({"wheel": WHEEL["wheel"] | {"lugs": 18}})),
    ("tyres", SCM, scene({"wheel": WHEEL["wheel"] | {"tyre": {"stiffness": 100e3, "load": 4000}}}, "scm", **SAND)),
    ("load", SCM, loaded(copy.deepcopy(SCM))),
    ("forces", SCM, SCM | {"output": {"forces": 20}}),
    ("slip", SCM, slipping(copy.deepcopy(SCM))),
    ("loose", SCM, SCM | {"redistribute": {"model": "scm", "loosening": 0.67}}),
    ("dense", SCM, SCM | {"redistribute": {"model": "scm", "hardening": 0.5}}),
    ("thrown", slipping(copy.deepcopy(SCM)), slipping(copy.deepcopy(SCM | {"redistribute": {"model": "scm", "thrown": "on"}}))),
    ("carried", scene(PLATE, "scm", **SAND), carrying(scene(PLATE, "scm", **SAND))),
    ("dirt", scene(WHEEL), scene(WHEEL, attributes=["dirt"])),
    ("vegetation", scene(WHEEL), scene(WHEEL, attributes=["vegetation"])),
    ("subdivide", scene(WHEEL), scene(WHEEL, store="coarse.furrow")),
    ("relief", scene(WHEEL, store="coarse.furrow"), scene(WHEEL, store="coarse.furrow", relief={"roughness": 0.02, "wavelength": 2, "seed": 7})),
    ("rocks", scene(WHEEL), scene(WHEEL, ground={"rocks": {"cover": 0.05, "largest": 1.0, "seed": 7}})),
    ("loaders", scene(WHEEL, **cache(0, 0)), scene(WHEEL, **cache(2, 0))),
    ("prefetch", scene(WHEEL, **cache(2, 0)), scene(WHEEL, **cache(2, 1.5))),
    ("picture", scene(WHEEL), SEEN),
    *((name, SEEN, scene(WHEEL, **view(name))) for name in ("texture", "fog", "sky", "geomorph", "skirts")),
    ("objects", SEEN, scene(WHEEL, **view("objects"))),
    ("shadow", scene(WHEEL, **view("objects")), scene(WHEEL, **view("objects", "shadow"))),
    ("detail", scene(WHEEL, **view("texture")), scene(WHEEL, **view("texture", "detail"))),
    ("splat", MAPPED | view("texture"), MAPPED | view("texture", "splat")),
    ("terrain_shadow", scene(WHEEL, **view("texture")), scene(WHEEL, **view("texture", "terrain_shadow"))),
    ("imagery", scene(WHEEL, **view("texture")), scene(WHEEL, store="pictured.furrow", **view("texture", "imagery"))),
    ("cameras", SEEN, SEEN | {"cameras": [EYE]}),
    ("pixel_error", scene(WHEEL, **view("geomorph")), scene(WHEEL, **view("geomorph", pixel_error=4))),
    ("light", SEEN, scene(WHEEL, **view(exposure="auto"))),
    ("antialias", SEEN, scene(WHEEL, **view(samples=4))),
    ("images", scene(WHEEL), SEEN),
]


def brick():
    """The box, of triangles."""
    x, y, z = (side / 2 for side in BRICK["box"]["size"])
    corners = [(a * x, b * y, c * z) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    return "".join(f"v {a} {b} {c}\n" for a, b, c in corners) + \
        "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in faces)


def classes(wide=SIDE * FINE + 1, high=SIDE * FINE + 1, stripe=8 * FINE):
    """Stripes of two soils: a PNG of a pixel a post."""
    row = b"\0" + bytes(1 + x // stripe % 2 for x in range(wide))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", wide, high, 8, 0, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(row * high)) + chunk(b"IEND", b"")


# --- drives ---

class Bench:
    def __init__(self, furrow, folder):
        self.furrow, self.folder = furrow, folder
        for name, posts in (("fine", FINE), ("coarse", 1)):
            self.command("synth", "-o", f"{name}.png", "--posts", f"{SIDE * posts + 1}x{SIDE * posts + 1}", "--spacing", 1 / posts,
                         "--kind", "plain", "--relief", 1)
            self.command("import", f"{name}.png", "-o", f"{name}.furrow", "--spacing", 1 / posts, "--height-range", "0,1")
        (folder / "picture.ppm").write_bytes(b"P6\n%d %d\n255\n" % (SIDE + 1, SIDE + 1) + bytes((150, 120, 90)) * (SIDE + 1) ** 2)
        (folder / "picture.wld").write_text(f"1\n0\n0\n-1\n0\n{SIDE}\n")
        shutil.copy(folder / "fine.furrow", folder / "pictured.furrow")
        self.command("import", "--imagery", "picture.ppm", "-o", "pictured.furrow")
        (folder / "brick.obj").write_text(brick())
        (folder / "classes.png").write_bytes(classes())

    def command(self, *arguments):
        done = subprocess.run([str(self.furrow), *map(str, arguments)], cwd=self.folder, capture_output=True, text=True)
        if done.returncode == -signal.SIGINT or done.returncode == 130:
            raise KeyboardInterrupt
        if done.returncode:
            raise pages.Told(done.stderr.strip() or f"furrow {arguments[0]} ended with {done.returncode}")
        return done.stdout

    def written(self, made, metres=1):
        """YAML is a superset of JSON."""
        made = copy.deepcopy(made) | {"end_time": metres / SPEED}
        for thing in made.get("objects", []):
            thing["path"] = {"points": [[30, 70], [30 + metres, 70]], "speed": SPEED}
        (self.folder / "scene.yaml").write_text(json.dumps(made))
        return "scene.yaml"

    def effects(self, made):
        """(those it calls for, all that there are)"""
        said = json.loads(self.command("explain", self.written(made), "--json"))
        return {row["name"] for row in said["effects"] if row["called"]}, {row["name"] for row in said["effects"]}

    def changes(self, pairs):
        """For each pair the effects that it brings and those that it drops; and all that no pair brings."""
        changes, every, called = [], set(), set()
        for _, without, made in pairs:
            had, every = self.effects(without)
            has, _ = self.effects(made)
            changes.append((sorted(has - had), sorted(had - has)))
            called |= has - had
        return changes, sorted(every - called)

    def drive(self, made, metres):
        run = json.loads(self.command("drive", self.written(made, metres), "--overlay", "ruts.furrow", "-o", "out", "--json"))
        for path in self.folder.glob("ruts.furrow*"):
            path.unlink()
        return run


def figures(run):
    """Of one drive. ms: all its time over its steps, pictures and commits with them; p50: of a step and its picture."""
    steps, counts = run["steps"], run["counts"]
    return {"ms": run["seconds"] * 1e3 / steps, "p50": run["step_ms"]["p50"] + (1e3 / run["fps"]["p50"] if run["fps"] else 0), "step_p50": run["step_ms"]["p50"],
            "bytes": counts["bytes"], "programs": len(counts["programs"]), "threads": counts["threads"],
            "passes": {stage: count / steps for stage, count in counts["passes"].items()}, "gl": run["gl"]["renderer"]}


def median(found):
    """Of the same figures of several drives."""
    first = found[0]
    if isinstance(first, dict):
        return {name: median([one.get(name, 0) for one in found]) for name in dict.fromkeys(n for one in found for n in one)}
    return statistics.median(found) if isinstance(first, (int, float)) else first


def length(pair, metres):
    """Pictures take long: a quarter of the way, where one side has them."""
    return metres / 4 if any("view" in made for made in pair[1:]) else metres


def measure(bench, pair, metres, runs, progress, done, total):
    name, without, made = pair
    sides = ([], [])
    for run in range(runs + 1):
        for side, one in zip(sides, (without, made)):
            progress.show(done, total, f"{name}, run {run} of {runs}")
            found = bench.drive(one, metres)
            if run > 0:  # the first warms the driver's cache of programs
                side.append(figures(found))
            done += 1
    return median(sides[0]), median(sides[1])


# --- what is said of it ---

def passes_text(without, made):
    more = [(name, made["passes"].get(name, 0) - without["passes"].get(name, 0)) for name in
            dict.fromkeys([*without["passes"], *made["passes"]])]
    return ", ".join(f"{name} {n:+.2f}" for name, n in more if abs(n) >= 0.005) or "0"


def row(line):
    a, b = line["without"], line["with"]
    beside = [name for name in line["brings"] if name != line["effect"]]
    instead = [f"not {name}" for name in line["drops"]]
    change = b["bytes"] - a["bytes"]
    return [f"`{line['effect']}`", ", ".join(beside + instead), pages.figure(a["ms"]), pages.figure(b["ms"]),
            f"{b['ms'] - a['ms']:+.3f}", f"{b['ms'] / a['ms']:.2f}", f"{b['p50'] - a['p50']:+.3f}",
            ("+" if change > 0 else "") + pages.size(change), passes_text(a, b), f"{b['programs'] - a['programs']:+.0f}",
            f"{b['threads'] - a['threads']:+.0f}"]


def report(lines):
    head = ["effect", "and with it", "ms a step without", "with", "difference", "ratio", "of the median step",
            "GPU bytes", "passes a step", "programs", "threads"]
    first = lines[0]
    return pages.table(head, map(row, lines)) + \
        f"\n{max(line['metres'] for line in lines):g} m, a quarter of it with pictures; {first['runs']} runs of each drive " \
        f"in turn; {first['with']['gl']}.\n"


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=HERE.parent / "build", help="a release build (build)")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True, help="the folder for what is written")
    parser.add_argument("--runs", type=int, help="of each drive, in turn (7; quick: 1)")
    parser.add_argument("--only", type=lambda text: text.split(","), help="those effects alone: scm,load")
    parser.add_argument("--quick", action="store_true", help="drives a fifth as long, one run of each")
    parser.add_argument("--publish", action="store_true", help="rewrites the table in bench/ACCURACY.md")
    record.add_option(parser)
    options = parser.parse_args()
    if options.only and not set(options.only) <= {name for name, _, _ in PAIRS}:
        parser.error("--only: of " + ", ".join(name for name, _, _ in PAIRS))
    if options.publish and (options.only or options.quick):
        parser.error("--publish: a whole run is published, not --only or --quick")
    options.runs = options.runs or (1 if options.quick else 7)
    options.furrow = (options.build / "tools" / "furrow").resolve()
    if not options.furrow.exists():
        parser.error(f"{options.furrow}: not there; meson setup build && ninja -C build")
    return options


def run():
    options = parse()
    metres = 16 if options.quick else 80
    pairs = [pair for pair in PAIRS if not options.only or pair[0] in options.only]
    options.out.mkdir(parents=True, exist_ok=True)
    lines, progress, kept = [], pages.Progress("ablation"), record.Record("ablation", options.furrow)
    each = 2 * (options.runs + 1)
    with tempfile.TemporaryDirectory(prefix="furrow-ablation-") as name:
        bench = Bench(options.furrow, pathlib.Path(name))
        changes, lacking = bench.changes(pairs)
        if not options.only and lacking:
            raise pages.Told(f"no pair calls for {', '.join(lacking)}; add one to PAIRS")
        with pages.aside(options.out / "ablation.jsonl") as file:
            for i, (pair, (brings, drops)) in enumerate(zip(pairs, changes)):
                without, made = measure(bench, pair, length(pair, metres), options.runs, progress, i * each, len(pairs) * each)
                lines.append({"bench": "ablation", "effect": pair[0], "brings": brings, "drops": drops,
                              "metres": length(pair, metres), "runs": options.runs, "without": without, "with": made})
                file.write(json.dumps(lines[-1]) + "\n")
                file.flush()
    progress.end()
    text = report(lines)
    (options.out / "ablation.md").write_text(text)
    print(text)
    print(f"{options.out / 'ablation.jsonl'}, {options.out / 'ablation.md'}: written")
    kept.renderer = lines[-1]["with"]["gl"]
    kept.page("ablation", text)
    kept.write(options.figures)
    if options.publish:
        pages.publish(HERE / "ACCURACY.md", "ablation", text)
        print(f"{HERE / 'ACCURACY.md'}: its table is this one now")


if __name__ == "__main__":
    pages.main(run)
