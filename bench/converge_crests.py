"""The rim around a sphere and around a box, by direction: a case of bench/converge.py."""
import json
import math
import os

import lanes

SECTORS = 36
SCENE = """scene: 1
time_step: 0.05
end_time: %(end)r
spacing: %(spacing)r
soil: {%(soil)s}
redistribute: {model: %(model)s}
objects:
  - {name: a, shape: {%(shape)s}, path: {points: [[%(x)r, %(y)r]], speed: 1}, sink: 0.3}
"""
SHAPES = {"sphere": "sphere: {radius: 0.6}", "box": "box: {size: [1, 1, 1]}"}
SOILS = {"slippage": "name: dry_sand, cohesion: 0", "sumner": "name: sand"}


def sector_crests(posts, x, y, reach):
    """The greatest height in each sector around (x, y)."""
    found = [0.0] * SECTORS
    for px, py, height in posts:
        dx, dy = px - x, py - y
        if math.hypot(dx, dy) < reach:
            k = int((math.atan2(dy, dx) / (2 * math.pi) + 1 + 0.5 / SECTORS) * SECTORS) % SECTORS
            found[k] = max(found[k], height)
    return found


def crests(bench, quick):
    """The crest by direction, on a post and between posts. Of a box the four sides and the four corners are told apart."""
    for model in ("slippage", "sumner"):
        for shape in ("sphere",) if quick else ("sphere", "box"):
            for spacing in (0.0625,) if quick else (0.125, 0.0625, 0.03125):
                for shift in ((0.0, 0.0),) if quick else ((0.0, 0.0), (0.4, 0.3)):
                    x, y = 14.0 + shift[0] * spacing, 14.0 + shift[1] * spacing
                    store = lanes.ground(bench.furrow, bench.folder, 0.125)
                    scene, overlay, out = (os.path.join(bench.folder, name) for name in ("crest.yaml", "crest.furrow", "crest"))
                    for name in (overlay, overlay + "-wal", overlay + "-shm"):
                        if os.path.exists(name):
                            os.remove(name)
                    with open(scene, "w") as file:
                        file.write(SCENE % {"end": 4.0, "spacing": spacing, "soil": SOILS[model], "model": model, "shape": SHAPES[shape], "x": x, "y": y})
                    lanes.run(bench.furrow, "drive", scene, "--store", store, "--overlay", overlay, "-o", out)
                    with open(os.path.join(out, "run.json")) as file:
                        run = json.load(file)
                    posts = lanes.heights(bench.furrow, lanes.Driven({}, run, overlay), bench.folder, 0.125, spacing, (x - 2, y - 2, x + 2, y + 2), 1e-4)
                    found = sector_crests(posts, x, y, 1.9)
                    like = [found[k] for k in range(SECTORS) if shape == "sphere" or abs((k * 360 / SECTORS + 45) % 90 - 45) <= 25]
                    yield {"case": "crests", "model": model, "shape": shape, "spacing": spacing, "shift": shift[0], "least": min(like), "most": max(like),
                           "east": found[0], "northeast": (found[SECTORS // 8] + found[SECTORS // 8 + 1]) / 2}
