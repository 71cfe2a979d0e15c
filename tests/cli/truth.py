"""Colours that agree with depth (view.truth): the light is that of the surface in the depth image, and nothing else has light."""
import json
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import Camera, matrix, read_png
from furrow_test import FurrowTest, main

# Linear green of shaders/lib/body.glsl: ground at the lowest and at the highest height of the store, and the light of ground and sky.
LOW, HIGH, BELOW, SKY, SUN = 0.105, 0.240, 0.19, 0.50, 2.34


def light(png):
    """The light of a picture's green, before the film's curve and sRGB (shaders/lib/tone.glsl)."""
    c = png[..., 1] / 255
    y = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    a, b, c = 2.51 - 2.43 * y, 0.03 - 0.59 * y, -0.14 * y
    return (-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)


class Truth(FurrowTest):
    def height(self, x, y):
        return json.loads(self.ok("query", self.store, x, y, "--json"))["height"]

    def pictures(self, view, cameras, more="", end=0.5):
        text = (f"scene: 1\ntime_step: 0.5\nend_time: {end}\nspacing: 0.0625\n{more}\ncache: {{slots: 200}}\n"
                f"view: {{size: [320, 240], camera: {{fixed: {{eye: [9, 9, 90], target: [20, 20, 0]}}}}, {view}}}\ncameras:\n" +
                "".join(f"  - {{name: {name}, rate: 2, size: [640, 480], fov: 70, images: [colour, depth], {camera}}}\n" for name, camera in cameras.items()))
        (self.folder / "ruts.furrow").unlink(missing_ok=True)
        self.drive(self.scene(text), "--store", self.store, "--overlay", "ruts.furrow")
        return {name: Camera(self.folder / "out/cameras" / name) for name in cameras}

    def colour(self, camera, frame=-1):
        return read_png(camera.folder / f"colour/{camera.frames[frame]['frame']:06}.png").astype(int)

    def agreement(self, camera, sun):
        """How the drawn light correlates with that of the depth image's own normals. Edges of hills before others have none."""
        frame = camera.frames[-1]
        depth = camera.depth(frame).astype(float)
        v, u = np.mgrid[:depth.shape[0], :depth.shape[1]]
        seen = np.isfinite(depth)
        at = camera.rays(frame, u + 0.5, v + 0.5) * np.where(seen, depth, 0)[..., None]
        across, along = at[1:-1, 2:] - at[1:-1, :-2], at[2:, 1:-1] - at[:-2, 1:-1]
        middle = depth[1:-1, 1:-1]
        with np.errstate(invalid="ignore"):
            bends = np.maximum(abs(depth[1:-1, 2:] + depth[1:-1, :-2] - 2 * middle), abs(depth[2:, 1:-1] + depth[:-2, 1:-1] - 2 * middle))
            kept = bends < 0.03 * middle
        normal = np.cross(across, along)
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
        normal *= np.sign(normal[..., 2:])
        azimuth, up = np.radians(sun)
        facing = np.maximum(normal @ [np.sin(azimuth) * np.cos(up), np.cos(azimuth) * np.cos(up), np.sin(up)], 0)
        sky = min(0.2 + 1.6 * np.sin(up), 1)
        share = 0.5 + 0.5 * normal[..., 2]
        rise = np.clip((at[1:-1, 1:-1, 2] + frame["position"][2] - self.range[0]) / (self.range[1] - self.range[0]), 0, 1)
        told = (LOW + (HIGH - LOW) * rise) * (SUN * facing + sky * (SKY * share + BELOW * (1 - share)))
        drawn = light(self.colour(camera))[1:-1, 1:-1]
        self.assertGreater(kept.mean(), 0.5)
        return np.corrcoef(told[kept], drawn[kept])[0, 1]

    def test_light_is_that_of_the_depth_image(self):
        """At 2, 10 and 40 m, with the sun high and low, over slopes of hills, with relief between posts and without."""
        self.store = self.synth(posts="257x257", relief=60)
        self.range = json.loads(self.ok("info", self.store, "--json"))["height"]
        places = [(far, x, y, yaw) for far, x, y, yaw in ((2, 100, 100, 30), (2, 180, 90, 200), (10, 140, 60, 120), (10, 60, 150, 100), (40, 120, 120, 10))]
        cameras = {f"far{far}_{i}": f"kind: fixed, pose: {{at: [{x}, {y}, {self.height(x, y) + 0.75 * far}], yaw: {yaw}, pitch: -55}}"
                   for i, (far, x, y, yaw) in enumerate(places)}
        for relief in ("", "relief: {roughness: 0.02, wavelength: 2, seed: 3}"):
            for sun in ((240, 30), (100, 15), (0, 60)):
                angles = f"sun: {{azimuth: {sun[0]}, height: {sun[1]}, colour: [1, {SUN / 2.6}, 1]}}"
                for name, camera in self.pictures(f"effects: [geomorph, skirts, sky], {angles}", cameras, relief).items():
                    with self.subTest(camera=name, sun=sun, relief=relief):
                        far = np.median(camera.depth(camera.frames[-1]))
                        self.assertAlmostEqual(np.log(far / float(name[3:].split("_")[0])), 0, delta=0.7)
                        agreement = self.agreement(camera, sun)
                        self.assertGreater(agreement, 0.95)

    def test_detail_is_drawn_where_truth_is_off(self):
        """Fixed cameras have no light of the texture's grain. Chase cameras and `truth: false` have it, `truth: true` takes it from all."""
        self.store = self.synth(relief=20)
        cameras = {"stands": f"kind: fixed, pose: {{at: [40, 40, {self.height(40, 40) + 1.5}], yaw: 30, pitch: -30}}",
                   "follows": "kind: chase, on: ball, back: 3, up: 1.5"}
        ball = "objects: [{name: ball, shape: {sphere: {radius: 0.2}}, sink: 0.05, path: {points: [[50, 50], [51, 50]], speed: 1}}]"

        def drawn(effects, truth=""):
            return {name: self.colour(camera) for name, camera in self.pictures(f"effects: [sky, texture{effects}]{truth}", cameras, ball).items()}
        told, plain, off, on = drawn(", detail"), drawn(""), drawn(", detail", ", truth: false"), drawn("", ", truth: true")
        np.testing.assert_array_equal(told["stands"], plain["stands"])
        np.testing.assert_array_equal(told["follows"], off["follows"])
        np.testing.assert_array_equal(on["stands"], plain["stands"])
        for one, other in ((told["follows"], plain["follows"]), (told["stands"], off["stands"]), (on["follows"], plain["follows"])):
            self.assertGreater((abs(one - other) > 8).any(axis=-1).mean(), 0.2)

    def test_a_pass_changes_what_it_changed(self):
        """Before and after a wheel, colours differ only near pixels whose depth does."""
        self.store = self.synth(relief=20)
        cameras = {"eye": f"kind: fixed, pose: {{at: [40, 40, {self.height(40, 40) + 1.5}], yaw: 30, pitch: -25}}"}
        wheel = ("redistribute: {model: box}\nobjects: [{name: wheel, shape: {wheel: {radius: 0.4, width: 0.3}}, sink: 0.08,\n"
                 "  path: {points: [[42, 38], [43, 44], [60, 80]], speed: 30}}]")
        eye = self.pictures("effects: [geomorph, skirts, sky, texture, detail]", cameras, wheel, end=2)["eye"]
        self.assertGreater(len(eye.frames), 3)
        before, after = (eye.depth(eye.frames[i]) for i in (0, -1))
        with np.errstate(invalid="ignore"):
            changed = abs(after - before) > 1e-4 * before
        near = changed.copy()
        for _ in range(6):  # a triangle has one light, and some of its pixels may have the depth they had
            near[1:] |= near[:-1]
            near[:-1] |= near[1:]
            near[:, 1:] |= near[:, :-1]
            near[:, :-1] |= near[:, 1:]
        differs = abs(self.colour(eye, -1) - self.colour(eye, 0)).max(axis=-1) > 2
        self.assertGreater((differs & changed).mean(), 0.01)
        self.assertLess(near.mean(), 0.5)
        self.assertEqual(int((differs & ~near).sum()), 0)


if __name__ == "__main__":
    main()
