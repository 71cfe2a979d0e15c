"""Peak memory of a drive over real elevation data: mosaic.py FURROW DEM... imports the DEMs as one
terrain, drives 4 wheels 300 m across it at about 0.1 m posts with 128 slots and a picture every 500
steps, verifies the store, and prints one JSON line. Made for the SRTM pair N41E001 + N42E001."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

furrow, dems = sys.argv[1], sys.argv[2:]


def call(*arguments):
    return subprocess.run([furrow, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


with tempfile.TemporaryDirectory(prefix="furrow-mosaic-") as name:
    folder = pathlib.Path(name)
    store, scene = folder / "mosaic.furrow", folder / "scene.yaml"
    call("import", *dems, "-o", store)
    info = json.loads(call("info", store, "--json"))
    middle = [info["spacing"] * n / 2 for n in info["posts"]]
    wheels = []
    for number in range(4):
        side, back = (-0.9, 0.9)[number % 2], (0, 2.6)[number // 2]
        points = [[middle[0] + 3 * t - back, middle[1] + 40 * math.sin(t / 12) + side] for t in range(101)]
        wheels.append(f"  - {{name: w{number}, shape: {{wheel: {{radius: 0.5, width: 0.4}}}}, sink: 0.1, "
                      f"path: {{points: {points}, speed: 8}}}}\n")
    scene.write_text("scene: 1\ntime_step: 0.02\nend_time: 40\nspacing: 0.1\nredistribute: {model: box}\n"
                     "attributes: [dirt]\nobjects:\n" + "".join(wheels) +
                     "view: {size: [1280, 720], camera: {chase: w0, back: 12, up: 5}, "
                     "effects: [texture, fog, sky, skirts], images: 500}\ncache: {slots: 128}\n")
    report = json.loads(call("drive", scene, "--store", store, "-o", folder / "out", "--json"))
    check = json.loads(call("verify", store, "--json"))
    print(json.dumps({"bench": "mosaic", "posts": info["posts"], "spacing": report["spacing"],
                      "rss_peak_mb": round(report["memory"]["rss_peak"] / 1e6, 1), "cache": report["cache"],
                      "step_ms": report["step_ms"], "fps": report["fps"], "verify_ok": check["ok"],
                      "gl": report["gl"]["renderer"]}))
