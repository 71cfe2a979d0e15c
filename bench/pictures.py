"""Sixteen pictures to look at, and a contact sheet of them: what Furrow draws, and where mistakes would show.

    python3 bench/pictures.py build/tools/furrow -o bench-out/pictures

A rut from near by, the corner of four tiles, the horizon, levels of detail that meet, each of the ground's textures, a track on the Moon, holes,
a sphere's crater, ten passes in one rut, a drive's map, and the window (with Xvfb and xdotool; left out without). Makes its own terrain. Writes NAME.png of each and,
with gnuplot, sheet.jpg.
"""
import argparse
import contextlib
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time
import zlib

from pages import Told

SIZE = (640, 360)
ALL = ["texture", "detail", "fog", "sky", "geomorph", "skirts", "objects", "shadow"]
SCENES = pathlib.Path(__file__).resolve().parent.parent / "tools" / "scenes"
TEXTURES = {"grass": None, "soil": "sandy_loam_15", "rock": None, "sand": "dry_sand", "snow": "snow_us", "clay": "clayey_38"}
PATIENCE = 60  # s, for a window to come and go


class Studio:
    def __init__(self, furrow, folder):
        self.furrow, self.folder = furrow, folder
        self.made = []  # (title, path)
        folder.mkdir(parents=True, exist_ok=True)

    def run(self, *arguments):
        done = subprocess.run([self.furrow, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise Told(f"furrow {arguments[0]}: {done.stderr.strip()}")
        return done.stdout

    def add(self, title, path):
        self.made.append((title, path))
        print(f"{path}: {title}", flush=True)

    def store(self, name, *how):
        path = self.folder / f"{name}.furrow"
        if not path.exists():
            self.run("synth", "-o", path, *how)
        return path

    def height(self, store, x, y):
        return json.loads(self.run("query", store, x, y, "--json"))["points"][0]["height"]

    def steepest(self, store, low, high, step):
        """(x, y) of a grid."""
        points = "".join(f"{x} {y}\n" for x in range(low, high, step) for y in range(low, high, step))
        done = subprocess.run([self.furrow, "query", str(store), "--json"], input=points, capture_output=True, text=True, check=True)
        steep = min(json.loads(done.stdout)["points"], key=lambda point: point["normal"][2])
        return steep["x"], steep["y"]

    def camera(self, store, eye, target):
        """(x, y, metres above the ground) each."""
        def place(at):
            return [at[0], at[1], self.height(store, at[0], at[1]) + at[2]]
        return {"fixed": {"eye": place(eye), "target": place(target)}}

    def drive(self, name, title, scene, store, steps=1, view=None, soil=None):
        """The picture of the last step; `view` and `soil` over the scene's."""
        shown = {"size": list(SIZE), "effects": ALL, "images": steps, **(view or {})}
        out, overlay = self.folder / f"{name}.drive", self.folder / f"{name}.overlay"
        shutil.rmtree(out, ignore_errors=True)
        overlay.unlink(missing_ok=True)
        settings = [f"view={json.dumps(shown)}"] + ([f"soil={json.dumps(soil)}"] if soil else [])
        self.run("drive", scene, "--store", store, "--overlay", overlay, "-o", out, "--steps", steps,
                 *(part for setting in settings for part in ("--set", setting)))
        picture = self.folder / f"{name}.png"
        shutil.copy(out / f"frame-{steps:06}.png", picture)
        self.add(title, picture)
        return out


def write_png(path, width, height, bits, value):
    """Grey, value(x, y); row 0 north."""
    rows = b"".join(b"\0" + b"".join(value(x, y).to_bytes(bits // 8, "big") for x in range(width)) for y in range(height))
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def scene(folder, name, *lines):
    path = folder / f"{name}.yaml"
    path.write_text("\n".join(("scene: 1", "time_step: 0.04", "end_time: 60") + lines) + "\n")
    return path


def wheel(points, speed=5):
    return ("spacing: 0.125", "redistribute: {model: box}", "attributes: [dirt]", "objects:",
            "  - name: wheel", "    shape: {wheel: {radius: 0.5, width: 0.4, lugs: 12}}", "    sink: 0.12",
            f"    path: {{points: {json.dumps(points)}, speed: {speed}}}")


# The object itself is not drawn.
CRATER = ("spacing: 0.03125", "soil: {name: dry_sand, cohesion: 0}", "redistribute: {model: slippage}", "objects:",
          "  - {name: sphere, shape: {sphere: {radius: 0.6}}, sink: 0.3, path: {points: [[104, 100]], speed: 1}}")


def passes(count):
    """Wheels one behind the other, 800 N each."""
    wheels = (f"  - {{name: wheel{k}, shape: {{wheel: {{radius: 0.32, width: 0.24}}}}, load: 800, slip: 0.2, path: {{points: [[{100 + count - k}, 100], "
              f"[{112 + count - k}, 100]], speed: 1}}}}" for k in range(count))
    return ("spacing: 0.015625", "soil: {name: dry_sand}", "redistribute: {model: scm}", "objects:", *wheels)


def draw_all(studio):
    folder = studio.folder
    hills = studio.store("hills", "--posts", "2049x2049", "--spacing", "1", "--kind", "ridged", "--relief", "160", "--seed", "7")
    plain = studio.store("plain", "--posts", "513x513", "--spacing", "1", "--kind", "plain", "--relief", "1", "--seed", "3")

    drive = studio.drive("rut", "a rut from near by", SCENES / "demo.yaml", hills, 120,
                         {"camera": {"chase": "rear_left", "back": 4.5, "up": 1.3}})
    corner = scene(folder, "corner", *wheel([[53, 58], [75, 70]]))
    studio.drive("corner", "the corner of four tiles", corner, hills, 100,
                 {"camera": studio.camera(hills, (58, 57, 6), (64, 64, 0))})
    still = scene(folder, "still", *wheel([[1000, 1000], [1001, 1000]], 1))
    studio.drive("horizon", "the horizon", still, hills, 1,
                 {"camera": studio.camera(hills, (1250, 400, 40), (1000, 1500, 60)), "sun": {"azimuth": 240, "height": 14}})
    studio.drive("seam", "levels of detail that meet", corner, hills, 100,
                 {"camera": studio.camera(hills, (20, 30, 40), (90, 90, 0)), "effects": ["sky", "geomorph", "skirts"]})

    for name, soil in TEXTURES.items():
        if soil or name == "grass":
            studio.drive(name, name, scene(folder, name, *wheel([[100, 100], [130, 108]])), plain, 60,
                         {"camera": studio.camera(plain, (108.5, 99, 1.5), (112, 103.5, 0))}, {"name": soil} if soil else None)
        else:
            x, y = studio.steepest(hills, 300, 1700, 20)
            studio.drive(name, name, still, hills, 1, {"camera": studio.camera(hills, (x - 12, y - 9, 4), (x, y, 0))})

    studio.drive("moon", "a track on the Moon", scene(folder, "moon", *wheel([[100, 100], [130, 108]])), plain, 60,
                 {"camera": studio.camera(plain, (107, 98, 2), (112, 103.5, 0)), "body": "moon", "sun": {"azimuth": 120, "height": 25},
                  "effects": [effect for effect in ALL if effect != "fog"]}, {"name": "lunar"})

    write_png(folder / "holes-source.png", 257, 257, 16, lambda x, y: 0 if (x - 128) ** 2 + (y - 120) ** 2 < 40 ** 2 or
              (x // 24 + y // 24) % 9 == 0 else round(1000 + 90 * math.sin(x / 19) * math.cos(y / 23) + 40 * math.sin((x + 2 * y) / 9)))
    holes = folder / "holes.furrow"
    studio.run("import", folder / "holes-source.png", "-o", holes, "--nodata", "0", "--height-range", "0,6553.5", "--overwrite")
    studio.drive("nodata", "ground without data", scene(folder, "nodata", *wheel([[60, 20], [61, 20]], 1)), holes, 1,
                 {"camera": {"fixed": {"eye": [128, -20, 190], "target": [128, 110, 110]}}})

    low = {"sun": {"azimuth": 120, "height": 22}, "effects": ["sky", "shadow", "skirts"]}
    studio.drive("crater", "a sphere's crater", scene(folder, "crater", *CRATER), plain, 25,
                 {"camera": studio.camera(plain, (103.2, 97.6, 2.4), (104, 100.3, 0)), **low})
    studio.drive("passes", "ten passes in one rut", scene(folder, "passes", *passes(10)), plain, 325,
                 {"camera": studio.camera(plain, (106.2, 98.7, 1.2), (107.2, 100.1, 0)), **low})

    shutil.copy(drive / "map.png", folder / "map.png")  # its scene asks for one
    studio.add("a drive's map", folder / "map.png")


@contextlib.contextmanager
def display():
    reading, writing = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x1024x24"], pass_fds=[writing],
                              stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        number = os.read(reading, 16).decode().strip()
        if not number:
            raise Told("Xvfb gives no display; look at what it says")
        yield {**os.environ, "DISPLAY": ":" + number}
    finally:
        os.close(reading)
        server.terminate()
        server.wait()


def draw_window(studio):
    missing = [name for name in ("Xvfb", "xdotool") if shutil.which(name) is None]
    if missing:
        print(f"no {' and no '.join(missing)}, so no picture of the window", file=sys.stderr)
        return
    folder = studio.folder / "window"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    shot = folder / "view-0001.png"
    with display() as env:
        view = subprocess.Popen([studio.furrow, "view", str(SCENES / "demo.yaml"), "--store", str((studio.folder / "hills.furrow").resolve()),
                                 "--set", "view.size=[960,540]"], cwd=folder, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        def xdotool(*arguments):
            return subprocess.run(["xdotool", *arguments], env=env, capture_output=True, text=True).stdout.split()
        until, found = time.monotonic() + PATIENCE, []
        while not found and time.monotonic() < until and view.poll() is None:
            time.sleep(0.5)
            found = xdotool("search", "--name", "step")
        time.sleep(4)
        for key in ("2", "p"):
            xdotool("key", "--window", found[0] if found else "0", key)
            time.sleep(2)
        while not shot.exists() and time.monotonic() < until and view.poll() is None:
            time.sleep(0.5)
        view.terminate()
        view.wait(PATIENCE)
    if shot.exists():
        studio.add("the window: offsets in false colour", shot)
    else:
        print("the window gave no picture; try: furrow view", file=sys.stderr)


def draw_sheet(studio):
    if shutil.which("gnuplot") is None:
        print("no gnuplot, so no sheet: install gnuplot-nox (sh tools/packages.sh does)", file=sys.stderr)
        return
    sheet = studio.folder / "sheet.jpg"
    lines = [f"set terminal jpeg size 1680,{(len(studio.made) + 3) // 4 * 264} font 'sans,11' background 'white'", f"set output '{sheet}'",
             f"set multiplot layout {(len(studio.made) + 3) // 4},4 margins 0.005,0.995,0.005,0.965 spacing 0.008,0.035",
             "unset border", "unset tics", "unset key", "set size ratio -1", "set tmargin 1"]
    for title, path in studio.made:
        quoted = title.replace("'", "''")
        lines += [f"set title '{quoted}' offset 0,-0.8 noenhanced", f"plot '{path}' binary filetype=png with rgbimage"]
    subprocess.run(["gnuplot"], input="\n".join(lines) + "\nunset multiplot\n", text=True, check=True)
    print(f"{sheet}: all of them")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("furrow")
    parser.add_argument("-o", "--out", type=pathlib.Path, default=pathlib.Path("bench-out/pictures"))
    arguments = parser.parse_args()
    studio = Studio(str(pathlib.Path(arguments.furrow).resolve()), arguments.out)
    try:
        draw_all(studio)
        draw_window(studio)
        draw_sheet(studio)
    except Told as told:
        sys.exit(f"pictures: {told}")


if __name__ == "__main__":
    main()
