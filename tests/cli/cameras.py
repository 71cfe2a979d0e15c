"""Cameras of a drive: pictures and poses agree with the ground, by a projection that is written here a second time.

The ground is asked of `furrow query`, which computes on the CPU. Poses are read from camera.json, poses.tum and COLMAP's text.
"""
import json
import math
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, largest, long, main, write_png16

ROOT = pathlib.Path(__file__).parents[2]
SCENE = """scene: 1
time_step: 0.05
end_time: 2
objects:
  - {name: box, shape: {box: {size: [0.2, 0.2, 0.2]}}, path: {points: [[40, 40], [46, 44]], speed: 3}}
cache: {slots: 120}
"""
# Three poses and more of each kind.
CAMERAS = """cameras:
  - {name: post, kind: fixed, pose: {at: [30, 34, 34], target: [44, 42, 20]}, rate: 1, size: [320, 240], images: [colour, depth]}
  - {name: tilted, kind: fixed, pose: {at: [30, 34, 34], yaw: 20, pitch: -30, roll: 25}, fov: 80, rate: 1, images: [depth]}
  - {name: nav, kind: mounted, on: box, pose: {at: [-4, 0.5, 3], yaw: 10, pitch: -25}, fov: 70, rate: 2, images: [depth], stereo: 0.4}
  - {name: behind, kind: chase, on: box, back: 6, up: 4, rate: 2, images: [depth]}
  - {name: above, kind: overhead, on: box, height: 12, rate: 1, images: [depth]}
  - {name: drone, kind: poses, file: drone.csv, rate: 2, images: [depth]}
"""
DRONE = "t,x,y,z,yaw,pitch,roll\n0.5,38,30,36,60,-40,0\n1.5,44,34,34,100,-50,20\n"


def read_png(path):
    """Pixels, rows from the top, of a PNG whose rows are unfiltered or filtered by SUB."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", chunk[:10])
        packed += chunk if kind == b"IDAT" else b""
        at += 12 + length
    wide = {0: 1, 2: 3}[colour] * bits // 8
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, width * wide + 1)
    assert set(rows[:, 0]) <= {0, 1}
    sums = np.cumsum(rows[:, 1:].reshape(height, width, wide).astype(np.uint32), axis=1).astype(np.uint8)
    pixels = np.where(rows[:, :1, None] == 1, sums, rows[:, 1:].reshape(height, width, wide))
    return pixels[..., 0].astype(int) * 256 + pixels[..., 1] if bits == 16 else pixels


def matrix(q):
    """The rotation of a quaternion x, y, z, w: columns are the images of the axes."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Camera:
    """A camera as its files tell it."""

    def __init__(self, folder):
        self.folder = folder
        self.told = json.loads((folder / "camera.json").read_text())
        self.frames = self.told["frames"]

    def project(self, frame, points):
        """Pixel x, y and depth of points of the world."""
        at, turn = np.array(frame["position"]), matrix(frame["orientation"])
        x, y, z = ((np.atleast_2d(points) - at) @ turn).T
        return self.told["cx"] + self.told["fx"] * x / z, self.told["cy"] + self.told["fy"] * y / z, z

    def rays(self, frame, u, v):
        """Directions through pixels; a step along one goes as far ahead as the number says."""
        own = np.stack([(u - self.told["cx"]) / self.told["fx"], (v - self.told["cy"]) / self.told["fy"], np.ones_like(u)], axis=-1)
        return own @ matrix(frame["orientation"]).T

    def depth(self, frame):
        return np.load(self.folder / f"depth/{frame['frame']:06}.npy")

    def tum(self):
        return [list(map(float, line.split())) for line in (self.folder / "poses.tum").read_text().splitlines() if line[0] != "#"]


class Cameras(FurrowTest):
    def make(self, text=SCENE + CAMERAS, *arguments, **ground):
        self.store = self.synth(**{"relief": 20, **ground})
        (self.folder / "drone.csv").write_text(DRONE)
        return self.drive(self.scene(text), "--store", self.store, "--overlay", "o.furrow", *arguments)

    def camera(self, name):
        return Camera(self.folder / "out/cameras" / name)

    def hits(self, origin, rays):
        text = "".join(" ".join(map(repr, [*map(float, origin), *map(float, ray)])) + "\n" for ray in rays)
        told = json.loads(self.ok("query", self.folder / "o.furrow", "--json", stdin=text))
        return [ray.get("point") for ray in told["rays"]]

    def test_depth_is_where_rays_meet_the_ground(self):
        self.make(SCENE + CAMERAS + "spacing: 0.25\n")
        seen = 0
        for name in ("post", "tilted", "nav", "nav_right", "behind", "above", "drone"):
            camera = self.camera(name)
            self.assertGreaterEqual(len(camera.frames), 3)
            for frame in camera.frames:
                depth = camera.depth(frame)
                height, width = depth.shape
                self.assertEqual((width, height), (camera.told["width"], camera.told["height"]))
                u, v = np.meshgrid(np.linspace(5, width - 6, 6).astype(int), np.linspace(height // 2, height - 6, 4).astype(int))
                u, v = u.ravel(), v.ravel()
                rays = camera.rays(frame, u + 0.5, v + 0.5)
                for i, hit in enumerate(self.hits(frame["position"], rays)):
                    if hit is None or math.dist(hit, frame["position"]) > 18 or self.on_the_way(hit):
                        continue
                    ahead = (np.array(hit) - frame["position"]) @ matrix(frame["orientation"])[:, 2]
                    seen += 1
                    self.assertAlmostEqual(depth[v[i], u[i]], ahead, delta=5e-4 * ahead, msg=(name, frame["frame"], u[i], v[i]))
        self.assertGreater(seen, 200)

    def on_the_way(self, point):
        """Near where the box is, was or will be: the ground is another at other times."""
        along = min(max(((point[0] - 40) * 6 + (point[1] - 40) * 4) / 52, 0), 1)
        return math.hypot(point[0] - 40 - 6 * along, point[1] - 40 - 4 * along) < 1.5

    def test_a_post_is_at_its_pixel(self):
        """The tip of a spike on a plain, from three places: it is found in the picture within half a pixel of where it is projected."""
        write_png16(self.folder / "spike.png", 65, 65, lambda x, y: 150 if (x, y) == (40, 64 - 36) else 0)
        self.ok("import", self.folder / "spike.png", "-o", "spike.furrow", "--spacing", 1, "--height-range", "0,655.35")
        tip = np.array([40, 36, 1.5])
        self.assertAlmostEqual(json.loads(self.ok("query", "spike.furrow", 40, 36, "--json"))["height"], 1.5, delta=0.01)
        places = {"a": "at: [33, 36, 3], target: [40, 36.5, 1]", "b": "at: [41, 29, 2.5], yaw: 95, pitch: -10, roll: 15", "c": "at: [46, 42, 2], target: [41, 36, 1.2]"}
        text = "scene: 1\nend_time: 0.1\ntime_step: 0.1\ncameras:\n" + "".join(
            f"  - {{name: {name}, kind: fixed, pose: {{{pose}}}, rate: 1, fov: 30, size: [640, 480], images: [depth]}}\n" for name, pose in places.items())
        self.drive(self.scene(text), "--store", "spike.furrow")
        for name in places:
            camera = self.camera(name)
            frame = camera.frames[0]
            depth = camera.depth(frame)
            v, u = np.mgrid[:depth.shape[0], :depth.shape[1]]
            near = np.where(np.isfinite(depth), depth, 1e4)
            points = np.array(frame["position"]) + camera.rays(frame, u + 0.5, v + 0.5) * near[..., None]
            high = (points[..., 2] > 1) & (near < 100) & (np.hypot(points[..., 0] - 40, points[..., 1] - 36) < 1)
            x, y, z = (value[0] for value in camera.project(frame, tip))
            # Its two sides are straight in the picture, and meet at the tip.
            rows = np.unique(v[high])
            rows = rows[:len(rows) // 2]
            self.assertGreater(len(rows), 12, name)
            sides = [np.polyfit(rows + 0.5, [edge(u[high & (v == row)]) for row in rows], 1) for edge in (np.min, lambda pixels: pixels.max() + 1)]
            found_y = (sides[1][1] - sides[0][1]) / (sides[0][0] - sides[1][0])
            found_x = np.polyval(sides[0], found_y)
            self.assertLess(largest((abs(found_x - x), abs(found_y - y))), 0.5, (name, found_x, x, found_y, y))
            self.assertAlmostEqual(depth[int(y) + 1, int(x)], z, delta=0.02, msg=name)

    def seen(self, camera, frame, depth):
        """Where the ground is that each pixel sees, and pixels near enough that the mesh is as fine as the posts."""
        v, u = np.mgrid[:depth.shape[0], :depth.shape[1]]
        rays = camera.rays(frame, u + 0.5, v + 0.5)
        near = np.isfinite(depth) & (np.where(np.isfinite(depth), depth, 1e4) * np.linalg.norm(rays, axis=-1) < 18)
        return np.array(frame["position"]) + rays * np.where(near, depth, 0)[..., None], near

    def test_normals_heights_and_classes_are_those_of_the_ground(self):
        """Over waves whose height and slope are known in closed form, and a map of two soils."""
        size, wave = 129, 2 * math.pi / 40
        write_png16(self.folder / "waves.png", size, size,
                    lambda x, y: round(20000 + 3000 * math.sin(wave * x) + 2000 * math.cos(wave * (size - 1 - y))))
        write_png16(self.folder / "soils.png", size, size, lambda x, y: 1 if (x // 6 + (size - 1 - y) // 6) % 2 else 7)
        self.ok("import", self.folder / "waves.png", "-o", "waves.furrow", "--spacing", 1, "--height-range", "0,65.535")
        ball = "objects: [{name: ball, shape: {sphere: {radius: 1}}, path: {points: [[66, 60]], speed: 1}}]\nview: {effects: [objects, geomorph, sky], camera: {chase: ball}}\n"
        text = ("scene: 1\nend_time: 0.1\ntime_step: 0.1\nsoil: {map: soils.png, classes: {7: mud, 1: snow}, default: dry_sand}\n" + ball +
                "cameras:\n  - {name: a, kind: fixed, rate: 1, pose: {at: [60, 52, 30], target: [66, 61, 20]}, images: [depth, normals, height, class]}\n"
                "  - {name: b, kind: fixed, rate: 1, size: [200, 200], pose: {at: [75, 70, 27], target: [68, 62, 20]}, fov: 100, images: [depth, normals, height, class]}\n"
                "  - {name: c, kind: fixed, rate: 1, pose: {at: [58, 66, 26], target: [66, 60, 23]}, images: [colour, depth, normals, height, class]}\n")
        run = self.drive(self.scene(text), "--store", "waves.furrow")
        self.assertEqual(run["counts"]["units"]["frame"], 3)
        balls = skies = 0
        for name in "abc":
            camera = self.camera(name)
            frame, folder = camera.frames[0], camera.folder
            depth = camera.depth(frame)
            normals, heights = np.load(folder / "normals/000000.npy"), np.load(folder / "height/000000.npy")
            classes = read_png(folder / "class/000000.png")[..., 0]
            self.assertEqual((normals.dtype, heights.dtype), (np.float32, np.float64))
            points, near = self.seen(camera, frame, depth)
            ground = near & (classes < 250)
            self.assertGreater(ground.sum(), 5000)
            x, y = points[..., 0], points[..., 1]
            height = 20 + 3 * np.sin(wave * x) + 2 * np.cos(wave * y)
            # a cell's triangles are below a wave of 40 m by up to 0.03 m
            self.assertLess(np.abs(heights - points[..., 2])[ground].max(), 1e-3)
            self.assertLess(np.abs(heights - height)[ground].max(), 0.04)
            slope = np.stack([-3 * wave * np.cos(wave * x), 2 * wave * np.sin(wave * y), np.ones_like(x)], axis=-1)
            slope /= np.linalg.norm(slope, axis=-1, keepdims=True)
            self.assertLess(np.abs(normals - slope)[ground].max(), 0.01)
            np.testing.assert_allclose(np.linalg.norm(normals[ground], axis=-1), 1, atol=1e-6)
            soils = {soil["map_value"]: soil["index"] for soil in camera.told["images"]["class"]["soils"]}
            # the soil of the nearest post, where a post's border is not too near
            col, row = np.floor(x + 0.5).astype(int), np.floor(y + 0.5).astype(int)
            clear = ground & (np.abs(x + 0.5 - col - 0.5) < 0.48) & (np.abs(y + 0.5 - row - 0.5) < 0.48)
            wanted = np.where((col // 6 + row // 6) % 2, soils[1], soils[7])
            self.assertGreater(clear.sum(), 3000)
            self.assertTrue((classes == wanted)[clear].all(), name)
            self.assertEqual({soil["name"] for soil in camera.told["images"]["class"]["soils"]}, {"mud", "snow", "dry_sand"})
            # The ball's normals are those of a ball.
            ball = near & (classes == 253)
            balls += ball.sum()
            from_middle = points - [66, 60, json.loads(self.ok("query", "waves.furrow", 66, 60, "--json"))["height"] + 1]
            self.assertLess(np.abs(normals - from_middle)[ball].max(initial=0), 0.2)
            sky = np.isinf(depth)
            skies += sky.sum()
            self.assertTrue(np.isnan(normals[sky]).all() and np.isnan(heights[sky]).all() and (classes[sky] == 255).all())
            told = camera.told["images"]["height"]
            grey = read_png(folder / "height/000000.png")
            self.assertLess(np.abs(grey * told["png_unit"] + told["png_zero"] - heights)[~sky].max(), 0.51 * told["png_unit"])
            self.assertTrue((grey[sky] == 0).all())
            shades = read_png(folder / "normals/000000.png")
            self.assertLess(np.abs((shades - 127.5) / 127.5 - normals)[~sky].max(), 0.5 / 127)
        self.assertGreater(min(balls, skies), 500)

    def test_between_posts_of_the_source_a_camera_measures_what_wheels_feel(self):
        """Posts 20 m apart and bilinear ground between them, computed here from the posts; a box that drives changes only its rut."""
        posts = [[round(400 * (2 + math.sin(0.9 * x) + math.cos(1.3 * y + 0.7 * x))) + 37 * (x * x + 5 * x * y + 3 * y * y) % 200 for x in range(17)] for y in range(17)]
        write_png16(self.folder / "coarse.png", 17, 17, lambda x, y: posts[16 - y][x])
        self.ok("import", self.folder / "coarse.png", "-o", "coarse.furrow", "--spacing", 20, "--height-range", "0,655.35", "--max-error", 0, "--tile", 16)
        z = np.array(posts) / 100

        def ground(x, y):
            """Height, slope east and north, and by how much the source's triangles are off."""
            cx, cy = np.clip(np.floor(x / 20).astype(int), 0, 15), np.clip(np.floor(y / 20).astype(int), 0, 15)
            u, v = x / 20 - cx, y / 20 - cy
            a, b, c, d = z[cy, cx], z[cy, cx + 1], z[cy + 1, cx], z[cy + 1, cx + 1]
            twist = a - b - c + d
            high = a + (b - a) * u + (c - a) * v + twist * u * v
            flat = np.where(u > v, a + (b - a) * u + (d - b) * v, a + (d - c) * u + (c - a) * v)
            return high, (b - a + twist * v) / 20, (c - a + twist * u) / 20, np.abs(high - flat), np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v))

        most = np.abs(z[:-1, :-1] - z[:-1, 1:] - z[1:, :-1] + z[1:, 1:]).max() / 4
        eye = float(ground(np.array(142.0), np.array(150.0))[0]) + 2
        for spacing, error in ((0.3125, None), (0.625, None), (0.625, 0.5), (1.25, None)):
            text = (f"scene: 1\nend_time: 2\ntime_step: 0.5\nspacing: {spacing}\nredistribute: {{model: box}}\ncache: {{slots: 200}}\n"
                    "objects:\n  - {name: box, shape: {box: {size: [1, 1, 0.5]}}, sink: 0.1, path: {points: [[152, 151], [158, 153]], speed: 4}}\n" +
                    ("" if error is None else f"view: {{camera: {{chase: box}}, effects: [objects, geomorph, skirts], pixel_error: {error}}}\n") +
                    f"cameras:\n  - {{name: a, kind: fixed, rate: 0.5, size: [160, 120], fov: 70, pose: {{at: [142, 150, {eye}], yaw: 8, pitch: -12}}, images: [depth, normals, height]}}\n")
            (self.folder / "o.furrow").unlink(missing_ok=True)
            self.drive(self.scene(text), "--store", "coarse.furrow", "--overlay", "o.furrow")
            camera = self.camera("a")
            self.assertEqual(len(camera.frames), 2)
            depths = [camera.depth(frame) for frame in camera.frames]
            frame, depth = camera.frames[0], depths[0]
            v, u = np.mgrid[:120, :160]
            rays = camera.rays(frame, u + 0.5, v + 0.5)
            near = depth < 70
            points = np.array(frame["position"]) + rays * np.where(near, depth, 0)[..., None]
            x, y = points[..., 0], points[..., 1]
            box = np.hypot(x - 152, y - 151) < 1.2
            near &= ~box
            high, east, north, off, within = ground(x, y)
            cell = np.maximum(spacing, (depth if error is None else 0) / 18)  # of the mesh
            allowed = 0.002 + most * (cell / 20) ** 2 + (0 if error is None else error * depth / camera.told["fx"])
            self.assertGreater((near & (off > 0.1)).sum(), 3000, spacing)  # the source's triangles are not this ground
            self.assertLess((np.abs(points[..., 2] - high) - allowed)[near].max(), 0, (spacing, error))
            heights, normals = np.load(camera.folder / "height/000000.npy"), np.load(camera.folder / "normals/000000.npy")
            self.assertLess((np.abs(heights - high) - allowed)[near].max(), 0, (spacing, error))
            wanted = np.stack([-east, -north, np.ones_like(east)], axis=-1) / np.sqrt(east ** 2 + north ** 2 + 1)[..., None]
            inner = near & (within > 0.15) & (depth < 25)
            self.assertGreater(inner.sum(), 1000)
            self.assertLess(np.abs(normals - wanted)[inner].max(), 0.02, (spacing, error))
            # What the command's rays meet is the same ground, to the bit's rounding.
            rut = np.abs((y - 151) * 6 - (x - 152) * 2) / math.hypot(6, 2) < 5
            picked = np.argwhere(near & ~rut & (v % 7 == 3) & (u % 13 == 7))
            self.assertGreater(len(picked), 15)
            for (row, column), hit in zip(picked, self.hits(frame["position"], [rays[row, column] for row, column in picked])):
                self.assertIsNotNone(hit)
                self.assertAlmostEqual(hit[2], ground(np.array(hit[0]), np.array(hit[1]))[0], delta=1e-4)
                ahead = (np.array(hit) - frame["position"]) @ matrix(frame["orientation"])[:, 2]
                steep = max(0.05, -(rays[row, column] / np.linalg.norm(rays[row, column])) @ wanted[row, column])
                self.assertLess(abs(depth[row, column] - ahead), allowed[row, column] / steep + 1e-3, (spacing, error, row, column))
            # The tiles under the box are deformed now. Away from it and its rut nothing has moved.
            after = np.array(frame["position"]) + rays * np.where(near, depths[1], 0)[..., None]
            still = near & ~rut & (depths[1] < 70)
            self.assertGreater(still.sum(), 1500)
            self.assertLess((np.abs(after[..., 2] - points[..., 2]) - allowed)[still].max(), 0, (spacing, error))
            self.assertGreater(np.abs(depths[1][near & rut] - depths[0][near & rut]).max(), 0.3)

    def test_a_stereo_pair_sees_the_same_ground(self):
        self.make()
        left, right = self.camera("nav"), self.camera("nav_right")
        self.assertEqual(left.told["stereo"], {"right": "nav_right", "baseline": 0.4})
        self.assertEqual(right.told["stereo"], {"left": "nav", "baseline": 0.4})
        compared = 0
        for a, b in zip(left.frames, right.frames):
            self.assertEqual(a["orientation"], b["orientation"])
            apart = (np.array(b["position"]) - a["position"]) @ matrix(a["orientation"])
            np.testing.assert_allclose(apart, [0.4, 0, 0], atol=1e-9)
            one, other = left.depth(a), right.depth(b)
            for v in range(250, 470, 20):
                for u in range(200, 620, 35):
                    z = float(one[v, u])
                    at = u - left.told["fx"] * 0.4 / z  # disparity = f b / z
                    if not math.isfinite(z) or at < 0:
                        continue
                    low, part = int(at), at - int(at)
                    beside = other[v, low] * (1 - part) + other[v, low + 1] * part
                    compared += abs(beside - z) < 0.01 * z
                    self.assertLess(abs(beside - z), 0.5 * z)
        self.assertGreater(compared, 300)

    def test_every_file_tells_the_same_pose(self):
        self.make()
        folders = sorted((self.folder / "out/cameras").iterdir())
        self.assertGreater(len(folders), 2)
        for folder in folders:
            camera = Camera(folder)
            self.assertGreater(len(camera.frames), 0)
            rows, told = camera.tum(), camera.told
            self.assertEqual(len(rows), len(camera.frames))
            model = (folder / "cameras.txt").read_text().splitlines()[1].split()
            self.assertEqual(model[1:4], ["PINHOLE", str(told["width"]), str(told["height"])])
            np.testing.assert_allclose(list(map(float, model[4:])), [told[key] for key in ("fx", "fy", "cx", "cy")], rtol=1e-9)
            self.assertAlmostEqual(told["fx"], told["width"] / 2 / math.tan(math.radians(told["fov_horizontal"]) / 2), places=9)
            lines = (folder / "images.txt").read_text().splitlines()[1:]
            self.assertEqual(lines[1::2], [""] * len(rows))
            for frame, row, line in zip(camera.frames, rows, lines[::2]):
                np.testing.assert_allclose(row, [frame["time"], *frame["position"], *frame["orientation"]], atol=1e-8)
                words = line.split()
                w, x, y, z, *t = map(float, words[1:8])
                np.testing.assert_allclose(matrix((x, y, z, w)), matrix(frame["orientation"]).T, atol=1e-9)
                np.testing.assert_allclose(t, -matrix((x, y, z, w)) @ frame["position"], atol=1e-6)
                self.assertTrue((folder / words[9]).exists(), words[9])

    def test_the_16_bit_picture_has_the_depth(self):
        self.make(SCENE + CAMERAS.replace("images: [depth]}", "images: [depth], depth_unit: 0.0002}"))
        beyond = within = 0
        for name, unit in (("post", 0.001), ("drone", 0.0002)):
            camera = self.camera(name)
            self.assertEqual(camera.told["images"]["depth"]["png_unit"], unit)
            for frame in camera.frames:
                depth = camera.depth(frame)
                grey = read_png(camera.folder / f"depth/{frame['frame']:06}.png")
                held = np.isfinite(depth) & (depth < 65535.4 * unit)
                self.assertTrue((grey[~held] == 0).all())
                self.assertLessEqual(np.abs(grey[held] * unit - depth[held]).max(initial=0), 0.51 * unit)
                beyond += (~held).sum()
                within += held.sum()
        self.assertGreater(min(beyond, within), 1000)

    def test_frames_come_at_their_rate_and_nothing_else_is_drawn(self):
        run = self.make(SCENE + "cameras: [{name: a, kind: overhead, on: box, height: 9, rate: 3, size: [64, 48]},\n"
                        "  {name: b, kind: chase, on: box, rate: 20, size: [64, 48], images: [colour, depth]}]\n")
        a, b = self.camera("a"), self.camera("b")
        self.assertEqual([frame["frame"] for frame in a.frames], list(range(7)))
        # after the first step that ends at n / 3 s or later
        np.testing.assert_allclose([frame["time"] for frame in a.frames], [0, 0.35, 0.7, 1, 1.35, 1.7, 2], atol=1e-9)
        np.testing.assert_allclose([frame["time"] for frame in b.frames], np.arange(41) * 0.05, atol=1e-9)
        self.assertEqual(sorted(path.name for path in (a.folder / "colour").iterdir()), [f"{i:06}.png" for i in range(7)])
        self.assertEqual(run["counts"]["units"]["frame"], 48)
        self.assertEqual(run["view"]["images"], 7 + 2 * 41)
        for camera, kind, images, size in ((a, "overhead", ["colour"], [64, 48]), (b, "chase", ["colour", "depth"], [64, 48])):
            told = run["cameras"][camera.told["name"]]
            self.assertEqual([told[key] for key in ("kind", "on", "images", "frames")], [kind, "box", images, len(camera.frames)])
            self.assertEqual([told["width"], told["height"]], size)
            for key, frame in (("first", camera.frames[0]), ("last", camera.frames[-1])):
                self.assertEqual(told[key], frame)
        plan = self.json("explain", self.folder / "scene.yaml", "--store", self.store)
        self.assertEqual({name: camera["frames"] for name, camera in plan["cameras"].items()}, {"a": 7, "b": 41})
        self.assertEqual({key: value for key, value in plan["cameras"]["b"].items() if key != "frame_seconds"}, {"images": ["colour", "depth"], "frames": 41, "frame_bytes": 2 * 64 * 48 * 4})

    def shade(self, sun, name="a"):
        """Mean green of the ground under this sun, and the picture."""
        text = ("scene: 1\nend_time: 0.1\ntime_step: 0.1\nview: {camera: {fixed: {eye: [1, 1, 50], target: [9, 9, 20]}}, " + sun + "}\n"
                "cameras: [{name: a, kind: fixed, rate: 1, size: [160, 120], pose: {at: [30, 30, 60], pitch: -60}}]\n")
        self.drive(self.scene(text), "--store", self.store)
        pixels = read_png(self.folder / "out/cameras/a/colour/000000.png").astype(int)
        return pixels[..., 1].mean(), pixels

    def test_the_sun_of_a_time_is_where_it_was_published(self):
        """The example of NREL's SPA: azimuth 194.34024, height 39.88838."""
        self.store = self.synth(relief=20)
        timed = self.shade('sun: {time: "2003-10-17T19:30:30Z", at: [-105.1786, 39.742476]}')[1]
        plan = self.json("explain", self.folder / "scene.yaml", "--store", self.store)
        for told in (plan["sun"], json.loads((self.folder / "out/run.json").read_text())["sun"], self.camera("a").told["sun"]):
            self.assertAlmostEqual(told["azimuth"], 194.34024, delta=0.02)
            self.assertAlmostEqual(told["height"], 39.88838, delta=0.02)
        self.assertRegex(self.ok("explain", self.folder / "scene.yaml", "--store", self.store), r"\nsun: azimuth 194\.3 degrees.*; 39\.9 degrees above the horizon\n")
        self.assertFalse([note for note in plan["notes"] if "horizon" in note])
        # Half a day later it is below the horizon.
        night = self.json("explain", self.folder / "scene.yaml", "--store", self.store, "--set", "view.sun.time=2003-10-18T07:30:30Z")
        note, = [note for note in night["notes"] if "horizon" in note]
        self.assertRegex(note, "^view.sun.time: the sun is below the horizon for all of the drive")
        self.assertRegex(note, "; it rises 5.[78] h after the drive begins;")  # SPA's: 13:12:43, with half a degree of refraction
        self.assertLess(night["sun"]["height"], -30)
        given = self.shade("sun: {azimuth: 194.34, height: 39.888}")[1]
        other = self.shade("sun: {azimuth: 194.34, height: 36}")[1]
        self.assertLess(np.abs(timed - given).max(), 3)
        self.assertGreater(np.abs(other - given).max(), 3)

    def test_without_a_place_it_is_seen_from_the_store(self):
        """The same example from a store in UTM, two zones to the east: its north is off true north by 3.95 degrees there."""
        if shutil.which("gdal_translate") is None or shutil.which("gdaltransform") is None:
            self.skipTest("no GDAL's programs here")
        text = subprocess.run(["gdaltransform", "-s_srs", "EPSG:4326", "-t_srs", "EPSG:32614", "-output_xy"], input="-105.1786 39.742476\n", text=True,
                              capture_output=True, check=True).stdout
        east, north = map(float, text.split()[:2])
        self.ok("synth", "-o", "hills.tif", "--posts", "257x257", "--spacing", "1", "--relief", "20")
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32614", "-a_ullr", *map(str, (east - 128.5, north + 128.5, east + 128.5, north - 128.5)),
                        "hills.tif", "placed.tif"], cwd=self.folder, check=True)
        self.ok("import", "placed.tif", "-o", "placed.furrow", "--t-srs", "source")
        self.store = self.folder / "placed.furrow"
        timed = self.shade('sun: {time: "2003-10-17T19:30:30Z"}')[1]
        off = math.degrees(math.radians(-105.1786 + 99) * math.sin(math.radians(39.742476)))
        given = self.shade(f"sun: {{azimuth: {194.34 - off}, height: 39.888}}")[1]
        other = self.shade("sun: {azimuth: 194.34, height: 39.888}")[1]
        self.assertLess(np.abs(timed - given).max(), 3)
        self.assertGreater(np.abs(other - given).max(), 3)

    @long
    def test_it_moves_with_the_time_of_the_drive(self):
        text = ('scene: 1\nend_time: 7200\ntime_step: 3600\nview: {camera: {fixed: {eye: [1, 1, 50], target: [9, 9, 20]}}, '
                'sun: {time: "2026-06-21T09:00:00Z", at: [0, 45]}}\n'
                "cameras: [{name: a, kind: fixed, rate: 0.000277777778, size: [80, 60], pose: {at: [30, 30, 60], pitch: -60}}]\n")
        self.store = self.synth(relief=20)
        self.drive(self.scene(text), "--store", self.store)
        greens = [read_png(self.folder / f"out/cameras/a/colour/{i:06}.png")[..., 1].mean() for i in range(3)]
        suns, run = [frame["sun"] for frame in self.camera("a").frames], json.loads((self.folder / "out/run.json").read_text())["sun"]
        self.assertEqual([run[key] for key in ("azimuth", "height", "azimuth_at_end", "height_at_end")], suns[0] + suns[2])
        self.assertGreater(suns[1][0] - suns[0][0], 15)
        self.assertGreater(suns[2][1] - suns[0][1], 10)
        self.assertEqual(greens, sorted(greens))
        self.assertGreater(greens[2], greens[0] + 2)

    def test_shadows_are_where_rays_to_the_sun_meet_the_ground(self):
        """Each pixel's place is asked of `furrow query`, by a ray from there to the sun."""
        self.store = self.synth(relief=60)
        for azimuth, height, at, pitch in ((250, 7, [120, 110], -45), (70, 16, [60, 150], -40), (160, 6, [180, 60], -55)):
            ground = json.loads(self.ok("query", self.store, *at, "--json"))["height"]
            text = ("scene: 1\nend_time: 0.1\ntime_step: 0.1\nspacing: 0.25\nview: {camera: {fixed: {eye: [1, 1, 50], target: [9, 9, 20]}}, body: moon, exposure: sun, "
                    f"sun: {{azimuth: {azimuth}, height: {height}}}, effects: [geomorph, EFFECT]}}\ncameras: [{{name: a, kind: fixed, rate: 1, fov: 90, "
                    f"size: [240, 180], pose: {{at: [{at[0]}, {at[1]}, {ground + 9}], yaw: 30, pitch: {pitch}}}, images: [colour, depth, normals]}}]\n")
            greens = []
            for effect in ("skirts", "terrain_shadow"):
                self.drive(self.scene(text.replace("EFFECT", effect)), "--store", self.store)
                greens.append(read_png(self.folder / "out/cameras/a/colour/000000.png")[..., 1].astype(float))
            camera = self.camera("a")
            frame = camera.frames[0]
            points, near = self.seen(camera, frame, camera.depth(frame))
            normals = np.load(camera.folder / "normals/000000.npy")
            az, up = math.radians(azimuth), math.radians(height)
            sun = np.array([math.sin(az) * math.cos(up), math.cos(az) * math.cos(up), math.sin(up)])
            facing = near & (normals @ sun > 0.04)
            picked = np.argwhere(facing)[::17]
            rays = "".join(" ".join(map(repr, map(float, [*(points[v, u] + 0.05 * normals[v, u]), *sun]))) + "\n" for v, u in picked)
            hidden = ["point" in ray for ray in json.loads(self.ok("query", self.store, "--json", stdin=rays))["rays"]]
            dark = [greens[1][v, u] < 0.5 * greens[0][v, u] for v, u in picked]
            agree = np.mean(np.array(hidden) == np.array(dark))
            self.same = getattr(self, "same", np.zeros(2)) + [agree * len(hidden), len(hidden)]
            self.assertGreater(agree, 0.95, (azimuth, height, len(hidden), sum(hidden), sum(dark)))
            self.both = getattr(self, "both", np.zeros(2)) + [sum(hidden), len(hidden) - sum(hidden)]
            # Nothing else changes.
            lit = np.array([greens[1][v, u] - greens[0][v, u] for (v, u), is_hidden in zip(picked, hidden) if not is_hidden])
            self.assertLess(np.median(np.abs(lit)) if len(lit) else 0, 3)
        self.assertGreater(self.both.min(), 150, self.both)
        self.assertGreater(self.same[0], 0.99 * self.same[1], self.same)

    @long
    def test_exposure_by_the_sun_keeps_a_low_sun_visible(self):
        self.store = self.synth(relief=5)
        for body in ("earth", "moon", "mars"):
            default = self.shade(f"body: {body}")[0]
            low = self.shade(f"body: {body}, sun: {{height: 3}}")[0]
            exposed = self.shade(f"body: {body}, sun: {{height: 3}}, exposure: sun")[0]
            self.assertLess(low, 0.75 * default, body)
            self.assertGreater(exposed, 0.7 * default, body)
            self.assertEqual(self.shade(f"body: {body}, exposure: sun")[0], default)

    def test_a_time_without_a_place_is_refused(self):
        self.store = self.synth(relief=5)
        base = 'scene: 1\nend_time: 1\nview: {images: 1, camera: {fixed: {eye: [1, 1, 50], target: [9, 9, 20]}}, sun: {%s}}\n'
        path = self.scene(base % 'time: "2026-06-21T09:00:00Z"')
        result = self.furrow("drive", path, "--store", self.store, "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertIn("the store has no reference system, so where it is is not known; give view.sun.at", self.told(3, result))
        for sun, told in (('time: "2026-06-21"', "is no time; allowed: UTC from 1900 to 2100, as 2026-11-27T16:00:00Z"), ("at: [1, 2]", "there is no time"),
                          ('time: "2026-06-21T09:00:00Z", height: 3', "and an angle are given"),
                          ('time: "2026-06-21T09:00:00Z", at: [1, 95]', "95 is no latitude")):
            self.assertIn(told, self.refused(3, "explain", self.scene(base % sun)))

    def test_pictures_too_large_for_the_machine_are_refused(self):
        self.store = self.synth(relief=5)
        path = self.scene("scene: 1\nend_time: 1\ncameras:\n" + "".join(
            f"  - {{name: c{i}, kind: fixed, rate: 1, size: [8192, {8192 - i}], images: [normals], pose: {{at: [30, 30, 60]}}}}\n" for i in range(64)))
        if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") > 95e9:
            self.skipTest("not on this machine: it has room for them")
        result = self.furrow("drive", path, "--store", self.store, "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertRegex(self.told(3, result), r"cameras: their pictures take 10\d GB, and this machine has [\d.]+ GB; give smaller sizes")
        self.assertFalse((self.folder / "out").exists())

    def with_ffmpeg(self, script):
        """Drives with this program in place of ffmpeg, or with none."""
        tools = self.folder / "tools"
        tools.mkdir(exist_ok=True)
        (tools / "ffmpeg").unlink(missing_ok=True)
        if script is not None:
            (tools / "ffmpeg").write_text("#!/bin/sh\n" + script)
            (tools / "ffmpeg").chmod(0o755)
        path = self.scene("scene: 1\nend_time: 0.5\ntime_step: 0.1\ncameras:\n  - {name: a, kind: fixed, rate: 4, size: [33, 25], video: true, pose: {at: [30, 30, 60]}}\n"
                          "  - {name: b, kind: fixed, rate: 4, size: [33, 25], pose: {at: [30, 30, 60]}}\n")
        result = self.furrow("drive", path, "--store", self.store, "-o", "50%d -y", env={"PATH": str(tools)})
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stderr, self.folder / "50%d -y/cameras/a"

    def test_a_video_is_made_by_ffmpeg_if_it_is_there(self):
        self.store = self.synth(relief=5)
        told, folder = self.with_ffmpeg('/bin/cat colour/000000.png colour/000002.png > colour.part.mp4; echo "$@" > "$PWD/words"\n')
        self.assertEqual((folder / "colour.mp4").read_bytes(), b"".join((folder / f"colour/{i:06}.png").read_bytes() for i in (0, 2)))
        self.assertIn("-framerate 4 -i colour/%06d.png", (folder / "words").read_text())
        self.assertNotIn("video", told)
        self.assertFalse((folder.parent / "b/colour.mp4").exists())
        (folder / "colour.mp4").unlink()
        for script, words in ((None, "there is no ffmpeg"), ("exit 3\n", "ffmpeg ended with 3")):
            told, folder = self.with_ffmpeg(script)
            self.assertIn("furrow: note: cameras.a.video: " + words, told)
            self.assertFalse(list(folder.glob("*.mp4")))

    @long
    def test_ffmpeg_makes_a_video_of_every_frame(self):
        if shutil.which("ffprobe") is None:
            self.skipTest("not on this machine: no ffmpeg")
        self.store = self.synth(relief=5)
        self.drive(self.scene("scene: 1\nend_time: 1\ntime_step: 0.1\ncameras: [{name: a, kind: fixed, rate: 10, size: [65, 49], video: true, "
                              "pose: {at: [30, 30, 60]}}]\n"), "--store", self.store)
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=width,height,nb_read_frames,r_frame_rate", "-of", "json",
                                self.folder / "out/cameras/a/colour.mp4"], capture_output=True, text=True, check=True)
        self.assertEqual(json.loads(probe.stdout)["streams"], [{"width": 66, "height": 50, "r_frame_rate": "10/1", "nb_read_frames": "11"}])

    def test_on_a_vehicle_it_goes_along_with_the_body(self):
        """The body's pose is that of vehicles.csv; here it is turned into axes a second time."""
        shutil.copy(ROOT / "tools/scenes/vehicles/rover.xml", self.folder)
        self.store = self.synth(kind="plain", relief=6)
        path = self.scene("scene: 1\ntime_step: 0.002\nend_time: 1\ngravity: 1.62\nspacing: 0.03125\nsoil: {name: lunar}\nredistribute: {model: scm}\n"
                          "vehicles:\n  - {name: rover, model: rover.xml, start: {at: [60, 60], yaw: 30}, soil: [wheel_*],\n"
                          "     driver: {path: {points: [[60, 60], [63, 61.7]], speed: 0.1}, steer: [steer_*], drive: [drive_*]}}\noutput: {vehicles: 10}\n"
                          "cameras: [{name: mast, kind: mounted, on: rover, pose: {at: [0.3, 0.1, 1.3], pitch: -35}, rate: 5, size: [64, 48]}]\n")
        if "no MuJoCo" in self.furrow("explain", path).stderr:
            self.skipTest("no MuJoCo here")
        self.drive(path, "--store", self.store, "--overlay", "o.furrow")
        rows = [line.split(",") for line in (self.folder / "out/vehicles.csv").read_text().splitlines()]
        poses = {round(float(row[0]), 6): list(map(float, row[2:8])) for row in rows[1:]}
        compared = 0
        for frame in self.camera("mast").frames:
            x, y, z, *angles = poses[round(frame["time"], 6)]
            roll, pitch, yaw = map(math.radians, angles)
            ahead = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)])
            level = np.array([-math.sin(yaw), math.cos(yaw), 0])
            top = np.cross(ahead, level)
            left, up = math.cos(roll) * level + math.sin(roll) * top, math.cos(roll) * top - math.sin(roll) * level
            compared += 1
            np.testing.assert_allclose(frame["position"], np.array([x, y, z]) + 0.3 * ahead + 0.1 * left + 1.3 * up, atol=1e-5)
            tilt = math.radians(-35)
            np.testing.assert_allclose(matrix(frame["orientation"]),
                                       np.stack([-left, math.sin(tilt) * ahead - math.cos(tilt) * up, math.cos(tilt) * ahead + math.sin(tilt) * up], axis=1), atol=1e-5)
        self.assertEqual(compared, 6)

    def test_on_a_mast_it_turns_with_the_mast(self):
        """The hinge's angle is that of vehicles.csv. A spring turns the mast to about 40 degrees before the drive begins."""
        text = (ROOT / "tools/scenes/vehicles/rover.xml").read_text()
        root = re.search(r"<freejoint[^>]*/>", text).group()
        (self.folder / "mast.xml").write_text(text.replace(root, root + """
            <body name="mast" pos="0.3 0.1 0.6"><joint name="pan" axis="0 0 1" stiffness="20" damping="4" springref="40"/>
              <geom name="head" type="box" size="0.05 0.1 0.05" mass="2" contype="0" conaffinity="0"/></body>"""))
        self.store = self.synth(kind="plain", relief=6)
        scene = ("scene: 1\ntime_step: 0.002\nend_time: 0.4\ngravity: 1.62\nspacing: 0.0625\nsoil: {name: lunar}\nredistribute: {model: scm}\n"
                 "vehicles: [{name: rover, model: mast.xml, start: {at: [60, 60], yaw: 30}, soil: [wheel_*]}]\noutput: {vehicles: 10}\n"
                 "cameras: [{name: eye, kind: mounted, on: rover, body: mast, pose: {at: [0.2, 0, 0.05]}, stereo: 0.1, rate: 10, size: [64, 48]}]\n")
        path = self.scene(scene)
        if "no MuJoCo" in self.furrow("explain", path).stderr:
            self.skipTest("no MuJoCo here")
        self.drive(path, "--store", self.store, "--overlay", "o.furrow")
        lines = [line.split(",") for line in (self.folder / "out/vehicles.csv").read_text().splitlines()]
        rows = {round(float(line[0]), 6): dict(zip(lines[0], line)) for line in lines[1:]}
        cameras = [self.camera(name) for name in ("eye", "eye_right")]
        self.assertEqual(len(cameras[0].frames), 5)
        for left, right in zip(*(camera.frames for camera in cameras)):
            row = rows[round(left["time"], 6)]
            roll, pitch, yaw = (math.radians(float(row[key])) for key in ("roll", "pitch", "yaw"))
            ahead = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)])
            level = np.array([-math.sin(yaw), math.cos(yaw), 0])
            top = np.cross(ahead, level)
            axes = np.stack([ahead, math.cos(roll) * level + math.sin(roll) * top, math.cos(roll) * top - math.sin(roll) * level], axis=1)
            pan = float(row["q:pan"])
            self.assertAlmostEqual(pan, 0.7, delta=0.1)
            turn = axes @ np.array([[math.cos(pan), -math.sin(pan), 0], [math.sin(pan), math.cos(pan), 0], [0, 0, 1]])
            eye = np.array([float(row[key]) for key in "xyz"]) + axes @ [0.3, 0.1, 0.6] + turn @ [0.2, 0, 0.05]
            np.testing.assert_allclose(left["position"], eye, atol=1e-5)
            np.testing.assert_allclose(right["position"], eye - 0.1 * turn[:, 1], atol=1e-5)
            np.testing.assert_allclose(matrix(left["orientation"])[:, 2], turn[:, 0], atol=1e-5)
        run = json.loads((self.folder / "out/run.json").read_text())["cameras"]
        self.assertEqual([cameras[0].told["body"], cameras[1].told["body"], run["eye"]["body"], run["eye_right"]["body"]], ["mast"] * 4)

    def test_a_body_that_is_not_there_is_refused(self):
        shutil.copy(ROOT / "tests/vehicle/one_wheel.xml", self.folder)
        self.store = self.synth(posts="65x65")
        scene = ("scene: 1\ntime_step: 0.002\nend_time: 0.1\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                 "vehicles: [{name: car, model: one_wheel.xml, start: {at: [20, 20]}}]\n"
                 "objects: [{name: box, shape: {box: {size: [1, 1, 1]}}, sink: 0.1, path: {points: [[30, 30], [50, 50]], speed: 1}}]\n"
                 "cameras: [{name: eye, kind: %s, on: %s, body: %s, stereo: 0.1, rate: 10, size: [64, 48]}]\n")
        if "no MuJoCo" in self.furrow("explain", self.scene(scene % ("mounted", "car", "boom"))).stderr:
            self.skipTest("no MuJoCo here")
        for kind, on, body, words in (("mounted", "car", "boom", r"cameras\.eye\.body: boom names no body of the model of car; give one of them, .*; there are: \w+"),
                                      ("mounted", "box", "boom", r'cameras\[0\]\.body: is given, and "?box"? is no vehicle; allowed with: a vehicle'),
                                      ("chase", "car", "boom", r"cameras\[0\]\.body: is not of a camera of kind chase; allowed with: mounted")):
            path = self.scene(scene % (kind, on, body))
            for command in (["explain", path], ["drive", path, "--store", self.store, "--overlay", "p.furrow", "-o", "p"]):
                with self.subTest(kind=kind, on=on, command=command[0]):
                    self.assertRegex(self.refused(3, *command), words)
        self.assertEqual([*self.folder.glob("p.furrow*"), *self.folder.glob("p/*")], [])

    def files(self):
        return {str(path.relative_to(self.folder / "out")): path.read_bytes() for path in (self.folder / "out/cameras").rglob("*") if path.is_file()}

    def test_a_camera_that_sees_nothing_at_first_is_told(self):
        self.store = self.synth(relief=20)
        ground = json.loads(self.ok("query", self.store, "--json", stdin="30 30\n"))["points"][0]["height"]
        cases = ((f"kind: fixed, pose: {{at: [30, 30, {ground - 1}]}}", r"pose\.at: its height is .* m, and the ground there is .* below the ground"),
                 (f"kind: fixed, pose: {{at: [30, 30, {ground + 1}]}}", None),
                 ("kind: fixed, pose: {at: [500000, 4400000, 30]}", r"pose\.at: 500000, 4400000 m is off the terrain, which is 0 to .*: the place of a camera is in local metres"),
                 ("kind: mounted, on: box, pose: {at: [0, 0, -0.6]}", r"pose\.at: the camera is 0\.200 m below the soil when the drive begins; .* centre of box"),
                 ("kind: mounted, on: box, pose: {at: [0, 0, -0.3]}", None))
        path = self.scene("scene: 1\nend_time: 0.1\ntime_step: 0.1\nobjects:\n"
                          "  - {name: box, shape: {box: {size: [1, 1, 1]}}, sink: 0.1, path: {points: [[30, 30], [50, 50]], speed: 1}}\ncameras:\n" +
                          "".join(f"  - {{name: c{i}, rate: 1, size: [33, 25], fov: {(3, 1.05)[i == 4]}, {entry}}}\n" for i, (entry, _) in enumerate(cases)))
        result = self.furrow("drive", path, "--store", self.store, "--overlay", "seen.furrow", "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        # A drive reads no more of the store for it: it tells what it finds at the first picture.
        seen = [line.removeprefix("furrow: note: ") for line in result.stderr.splitlines() if "pose.at" in line]
        self.assertEqual([note.split(" m below the ground when the drive begins; ")[0].split(" is ")[0] for note in seen], ["cameras.c0.pose.at: the camera", "cameras.c3.pose.at: the camera"])
        told = [note for note in self.json("explain", path, "--store", self.store)["notes"] if "cameras" in note]
        wanted = [rf"^cameras\.c{i}\.{words}" for i, (_, words) in enumerate(cases) if words is not None]
        wanted.append(r"scene\.yaml:11:\d+: cameras\[4\]\.fov: 1\.05 degrees is narrow, .*: if it is in radians give 60\.2$")
        self.assertEqual(len(told), len(wanted), told)
        for words in wanted:
            self.assertEqual(sum(re.search(words, note) is not None for note in told), 1, (words, told))
        shutil.copy(ROOT / "tests/vehicle/one_wheel.xml", self.folder)
        path = self.scene("scene: 1\ntime_step: 0.002\nend_time: 0.01\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                          "vehicles: [{name: car, model: one_wheel.xml, start: {at: [20, 20]}}]\ncameras:\n"
                          "  - {name: low, kind: mounted, on: car, pose: {at: [0, 0, -2]}, rate: 1, size: [33, 25]}\n"
                          "  - {name: top, kind: mounted, on: car, pose: {at: [0, 0, 2]}, rate: 1, size: [33, 25]}\n")
        result = self.furrow("drive", path, "--store", self.store, "--overlay", "car.furrow", "-o", "out")
        if "no MuJoCo" not in result.stderr:
            self.assertRegex("".join(line for line in result.stderr.splitlines() if "cameras" in line),
                             r"^furrow: note: cameras\.low\.pose\.at: the camera is \d\.\d+ m below the ground when the drive begins; .*, in metres$")

    @long
    def test_samples_smooth_colours_alone(self):
        self.store = self.synth(relief=20)
        images = {}
        for samples in (1, 4):
            path = self.scene("scene: 1\nend_time: 0.1\ntime_step: 0.1\nview: {camera: {chase: box}, samples: %d}\nobjects:\n"
                              "  - {name: box, shape: {box: {size: [2, 1, 1]}}, sink: 0.1, path: {points: [[30, 30], [50, 50]], speed: 1}}\ncameras:\n"
                              "  - {name: a, kind: chase, on: box, rate: 1, size: [160, 120], images: [colour, depth]}\n"
                              "  - {name: b, kind: chase, on: box, rate: 1, size: [80, 60], images: [normals, height]}\n" % samples)
            self.drive(path, "--store", self.store, "--overlay", f"{samples}.furrow")
            cameras = self.folder / "out/cameras"
            images[samples] = [read_png(cameras / "a/colour/000000.png"), *(np.load(cameras / name / "000000.npy") for name in ("a/depth", "b/normals", "b/height"))]
        self.assertFalse(np.array_equal(images[1][0], images[4][0]))
        for one, four in zip(images[1][1:], images[4][1:]):
            self.assertEqual(np.isfinite(one).sum(), np.isfinite(four).sum())
            np.testing.assert_allclose(one, four, rtol=1e-5)

    @long
    def test_killed_and_resumed_it_leaves_what_it_leaves_in_one_go(self):
        text = (SCENE + CAMERAS).replace("rate: 2", "rate: 10")
        self.make(text)
        wanted = self.files()
        (self.folder / "out").rename(self.folder / "alone")
        (self.folder / "o.furrow").unlink()
        command = [FURROW, "drive", "scene.yaml", "--store", self.store, "--overlay", "o.furrow", "-o", "out"]
        for after in (3, 9):
            resume = ["--resume"] if (self.folder / "o.furrow").exists() else []
            process = subprocess.Popen([*command, *resume], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while process.poll() is None and len(list((self.folder / "out").glob("cameras/drone/depth/*.npy"))) < after:
                time.sleep(0.002)
            process.send_signal(signal.SIGKILL if after == 3 else signal.SIGINT)
            process.communicate()
        self.drive("scene.yaml", "--store", self.store, "--overlay", "o.furrow", "--resume")
        found = self.files()
        self.assertEqual(sorted(found), sorted(wanted))
        for name in wanted:
            self.assertTrue(found[name] == wanted[name], name)

    def test_what_is_wrong_is_told(self):
        base = "scene: 1\nend_time: 1\ntime_step: 0.1\nobjects:\n  - {name: box, shape: {box: {size: [1, 1, 1]}}, path: {points: [[9, 9]], speed: 1}}\n"
        (self.folder / "bad.csv").write_text("t,x,y,z,yaw,pitch,roll\n0,1,1,1,0,0,0\n1,1,1,1,0,zero,0\n")
        (self.folder / "short.csv").write_text("0,1,1\n")
        for entry, told in (
                ("kind: mounted, on: bax, rate: 1", 'cameras[0].on: "bax" is no object; allowed: box'),
                ("kind: mounted, rate: 1", "cameras[0]: is of kind mounted and has no on; needed: on"),
                ("kind: fixed, rate: 1", "cameras[0]: is of kind fixed and has no pose"),
                ("kind: overhead, on: box, rate: 1", "has no height"),
                ("kind: chase, on: box, rate: 1, height: 3", "cameras[0].height: is not of a camera of kind chase; allowed with: overhead"),
                ("kind: chase, on: box, back: 0, up: 0, rate: 1", "stands in its object"),
                ("kind: chase, on: box, rate: 1, fov: 0", "cameras[0].fov: 0 is out of range; allowed: 1 to 170"),
                ("kind: chase, on: box, rate: 1, fov: 180", "cameras[0].fov: 180 is out of range"),
                ("kind: chase, on: box, rate: 11", "cameras[0].rate: 11 a second are more than there are steps, 10 a second"),
                ("kind: chase, on: box, rate: 0", "cameras[0].rate: 0 is out of range"),
                ("kind: chase, on: box, rate: 1, size: [9000, 10]", "cameras[0].size[0]: 9000 is out of range"),
                ("kind: chase, on: box, rate: 1, images: [colours]", 'cameras[0].images[0]: "colours" is unknown; allowed: colour, depth, normals, height, class, instance'),
                ("kind: chase, on: box, rate: 1, images: [depth, depth]", "is named twice"),
                ("kind: chase, on: box, rate: 1, images: [depth], video: true", "cameras[0].video: is of colours, which it does not write"),
                ("kind: poses, rate: 1, file: none.csv", "none.csv"),
                ("kind: poses, rate: 1, file: bad.csv", "bad.csv:3: pitch: \"zero\" is not a number"),
                ("kind: poses, rate: 1, file: short.csv", "its rows say no attitude; allowed: t,x,y,z,yaw,pitch,roll"),
                ("kind: fixed, rate: 1, pose: {at: [1, 1, 1], target: [1, 1, 1]}", "cameras[0].pose.target: is where the camera is"),
                ("kind: fixed, rate: 1, pose: {at: [1, 1, 1], target: [2, 1, 1], yaw: 3}", "and an angle are given"),
                ("kind: fixed, rate: 1, pose: {at: [1, 1, 1]}}\n  - {name: a, kind: fixed, rate: 1, pose: {at: [1, 1, 1]}", "is the name of another camera"),
                ("kind: fixed, rate: 1, stereo: 1, pose: {at: [1, 1, 1]}}\n  - {name: a_right, kind: fixed, rate: 1, pose: {at: [1, 1, 1]}",
                 '"a_right" is the name of another camera')):
            path = self.scene(base + f"cameras:\n  - {{name: a, {entry}}}\n")
            self.assertIn(told, self.refused(3, "explain", path), entry)


if __name__ == "__main__":
    main()
