#!/usr/bin/env python3
"""Films of shipped vehicles, as animated GIFs: a rover on the Moon and a legged robot on sand.

    bench/films.py build/tools/furrow -o docs        # writes docs/rover.gif and docs/walker.gif; some minutes of a processor

Needs Pillow (Debian: python3-pil). Each film is a drive of a scene of tools/scenes/vehicles with a camera; the frames become one GIF of few colours.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
SCENES = ROOT / "tools/scenes/vehicles"
# Name, scene, what is set, the camera, its height above the ground in m, frames for each second of the film.
FILMS = [
    ("rover", "rover", ["end_time=26", "vehicles.rover.driver.path.speed=0.25"],
     "{name: film, kind: fixed, pose: {at: [64.6, 54.6, %.3f], yaw: 107, pitch: -14}, size: [480, 300], fov: 60, rate: 1.5, images: [colour]}", 1.5, 8),
    ("walker", "walker", ["end_time=5", "spacing=0.03125", "vehicles.walker.start.settle=false", "view.body=mars"],
     "{name: film, kind: fixed, pose: {at: [61.2, 57.6, %.3f], yaw: 106, pitch: -14}, size: [480, 300], fov: 50, rate: 12, images: [colour]}", 1, 12),
]
COLOURS = 64


def run(*command):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"films.py: {' '.join(map(str, command))}: exit {done.returncode}")
    return done.stdout


def film(furrow, folder, name, scene, settings, camera, above, rate, out):
    from PIL import Image
    text = (SCENES / f"{scene}.yaml").read_text()
    for file in SCENES.iterdir():  # the scene's own folder has its models
        (folder / file.name).write_bytes(file.read_bytes())
    store = folder / "plain.furrow"
    if not store.exists():
        run(furrow, "synth", "-o", store, "--kind", "plain", "--posts", "513x513", "--spacing", "0.25", "--relief", "1")
    place = [float(number) for number in camera.split("at: [")[1].split(",")[:2]]
    height = json.loads(run(furrow, "query", store, *place, "--json"))["height"] + above
    path = folder / f"{name}.yaml"
    path.write_text(text + "cameras:\n  - " + camera % height + "\n")
    sets = [part for setting in settings for part in ("--set", setting)]
    run(furrow, "drive", path, "--store", store, "--overlay", folder / f"{name}.furrow", "-o", folder / name, *sets)
    frames = [Image.open(file).convert("RGB") for file in sorted((folder / name / "cameras/film/colour").glob("*.png"))]
    palette = frames[len(frames) // 2].quantize(COLOURS)
    frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0, optimize=True)
    print(f"{out}: {len(frames)} frames, {out.stat().st_size / 1e6:.2f} MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow", type=pathlib.Path)
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True)
    parser.add_argument("--only", help="one film, by its name")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name, scene, settings, camera, above, rate in FILMS:
            if arguments.only in (None, name):
                film(arguments.furrow.resolve(), pathlib.Path(folder), name, scene, settings, camera, above, rate, arguments.out / f"{name}.gif")


if __name__ == "__main__":
    main()
