"""Drives over real elevation data: mosaic.py FURROW DEM... imports the DEMs as one terrain and drives
four wheels across it at about 0.1 m posts: 150 m with 128 slots, where each step draws and writes a picture of 1280 x 720, for peak
memory, and 2 km with 16 slots and none, for evictions and write-backs. Verifies the store after each
and prints a JSON line each. Made for the SRTM pair N41E001 + N42E001."""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import record

PARSER = argparse.ArgumentParser(description=__doc__.split(":")[0])
PARSER.add_argument("furrow")
PARSER.add_argument("dems", nargs="+", metavar="DEM")
record.add_option(PARSER)
OPTIONS = PARSER.parse_args()
furrow, dems = OPTIONS.furrow, OPTIONS.dems
VIEW = ("view: {size: [1280, 720], camera: {chase: w0, back: 12, up: 5}, "
        "effects: [texture, fog, sky, skirts], images: 1}\n")


def call(*arguments):
    return subprocess.run([furrow, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def scene(info, metres, speed, slots, view):
    middle = [info["spacing"] * n / 2 for n in info["posts"]]
    wheels = []
    for number in range(4):
        side, back = (-0.9, 0.9)[number % 2], (0, 2.6)[number // 2]
        points = [[middle[0] + 3 * t - back, middle[1] + 40 * math.sin(t / 12) + side] for t in range(metres // 3 + 1)]
        wheels.append(f"  - {{name: w{number}, shape: {{wheel: {{radius: 0.5, width: 0.4}}}}, sink: 0.1, "
                      f"path: {{points: {points}, speed: {speed}}}}}\n")
    return (f"scene: 1\ntime_step: {0.1 if view else 0.02}\nend_time: {metres * 1.2 / speed}\nspacing: 0.1\nredistribute: {{model: box}}\n"
            "attributes: [dirt]\nobjects:\n" + "".join(wheels) + view + f"cache: {{slots: {slots}}}\n")


kept = record.Record("mosaic", furrow)
with tempfile.TemporaryDirectory(prefix="furrow-mosaic-") as name:
    folder = pathlib.Path(name)
    store, path = folder / "mosaic.furrow", folder / "scene.yaml"
    call("import", *dems, "-o", store)
    info = json.loads(call("info", store, "--json"))
    for metres, speed, slots, view in ((150, 8, 128, VIEW), (2000, 20, 16, "")):
        call("reset", store)
        path.write_text(scene(info, metres, speed, slots, view))
        report = json.loads(call("drive", path, "--store", store, "-o", folder / "out", "--json"))
        check = json.loads(call("verify", store, "--json"))
        print(json.dumps({"bench": "mosaic", "posts": info["posts"], "spacing": report["spacing"], "metres": metres,
                          "pictures": bool(view), "rss_peak_mb": round(report["memory"]["rss_peak"] / 1e6, 1),
                          "cache": report["cache"], "commits": report["io"]["commits"], "step_ms": report["step_ms"],
                          "fps": report["fps"], "steps_per_second": report["steps_per_second"], "rtf": report["rtf"], "verify_ok": check["ok"],
                          "gl": report["gl"]["renderer"]}), flush=True)
        kept.seen(report)
        for key, value, unit in (("rtf", report["rtf"], ""), ("fps", report["view"]["frames"] / report["seconds"] if view else None, "1/s"),
                                 ("rss_peak", report["memory"]["rss_peak"] / 1e6, "MB"),
                                 *((key, report["cache"][key], "") for key in ("touched", "evictions", "writebacks"))):
            if value is not None:
                kept.add(f"m{metres}.{key}", value, unit)
kept.write(OPTIONS.figures)
