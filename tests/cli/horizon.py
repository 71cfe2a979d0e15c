"""Ground beyond the terrain, to the horizon; and frames that are the same alone and in a drive."""
import json
import math
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import Camera, read_png
from furrow_test import FurrowTest, main

MOON = 1.7374e6  # m


class Horizon(FurrowTest):
    def frames(self, text, *more):
        self.drive(self.scene("scene: 1\ntime_step: 0.5\nend_time: 1\n" + text), "--store", self.store, *more)
        return Camera(self.folder / "out/cameras/eye")

    def colours(self, camera, frame=-1):
        return read_png(camera.folder / f"colour/{camera.frames[frame]['frame']:06}.png").astype(int)

    def height(self, x, y):
        return json.loads(self.ok("query", self.store, x, y, "--json"))["height"]

    def looking_out(self, body, above, effects="sky, texture, geomorph, skirts", pitch=-8):
        """Over the southern and the western edge, from the terrain's middle."""
        at = [128, 128, self.height(128, 128) + above]
        camera = self.frames(f"view: {{camera: {{fixed: {{eye: [1, 1, 99], target: [9, 9, 0]}}}}, body: {body}, effects: [{effects}], sun: {{azimuth: 220, height: 40}}}}\n"
                             f"cameras: [{{name: eye, kind: fixed, pose: {{at: {at}, yaw: 225, pitch: {pitch}}}, fov: 60, size: [320, 240], rate: 1, images: [colour, depth]}}]\n")
        return camera, camera.depth(camera.frames[-1]), self.colours(camera)

    def test_the_moon_has_a_horizon(self):
        """It is as far below the eye's level as the Moon's roundness says, and sharp: ground below, stars or nothing above."""
        self.store = self.synth(kind="plain", relief=2)
        for above in (2, 400, 3000):
            with self.subTest(above=above):
                camera, depth, colour = self.looking_out("moon", above)
                told, bright = camera.told, colour.max(axis=-1)
                dip = math.radians(8) - math.acos(MOON / (MOON + above))
                row = told["cy"] - told["fy"] * math.tan(dip)
                middle = bright[:, 150:170]
                first = (middle > 40).all(axis=1).argmax()
                self.assertAlmostEqual(first, row, delta=2.5)
                self.assertGreater(bright[first + 2:].min(), 25)
                self.assertLess((bright[:first - 2] > 0).mean(), 0.01)
                self.assertTrue(above < 400 or np.isinf(depth[first + 2:first + 6]).all())

    def test_no_cliff_before_the_sky(self):
        """Beyond the edge of hills there is ground: no pixel below the horizon has the sky's colour, and none of it has depth."""
        self.store = self.synth(relief=60)
        camera, depth, colour = self.looking_out("earth", 120, pitch=-20)
        row = math.ceil(camera.told["cy"] - camera.told["fy"] * math.tan(math.radians(20))) + 12
        beyond = np.isinf(depth[row:])
        self.assertGreater(beyond.mean(), 0.05)
        sky = colour[row - 24].mean(axis=0)
        self.assertLess(((abs(colour[row:] - sky).max(axis=-1) < 20) & beyond).sum(), 0.01 * beyond.sum())
        camera, other, plain = self.looking_out("earth", 120, effects="texture, geomorph, skirts", pitch=-20)
        np.testing.assert_array_equal(depth, other)
        near = np.isfinite(depth)
        np.testing.assert_array_equal(colour[near], plain[near])

    def test_a_frame_alone_is_that_of_the_drive(self):
        """The last frame of a drive with many wheels, and the same frame of a scene without them, where slots are few: the same bits."""
        self.store = self.synth(relief=60)
        x, y = 60, 60
        view = "view: {camera: {fixed: {eye: [1, 1, 99], target: [9, 9, 0]}}, effects: [sky, texture, geomorph, skirts], pixel_error: 0.25}\n"
        shared = (f"spacing: 0.125\nredistribute: {{model: box}}\ncache: {{slots: 40}}\n{view}cameras: [{{name: eye, kind: fixed, "
                  f"pose: {{at: [{x}, {y}, {self.height(x, y) + 6}], yaw: 30, pitch: -8}}, size: [320, 240], rate: 1, images: [colour, depth]}}]\n")
        wheels = ", ".join(f"{{name: w{i}, shape: {{wheel: {{radius: 0.4, width: 0.3}}}}, sink: 0.1, path: {{points: [[{90 + 3 * i}, {80 + 4 * i}], [{120 + 3 * i}, 90]], speed: 60}}}}"
                           for i in range(4))
        camera = self.frames(f"{shared}objects: [{wheels}]\n", "--overlay", "ruts.furrow")
        before, depth, colour = camera.depth(camera.frames[0]), camera.depth(camera.frames[-1]), self.colours(camera)
        self.assertTrue((before != depth).any())
        self.store = self.folder / "ruts.furrow"
        alone = self.frames(shared)
        np.testing.assert_array_equal(alone.depth(alone.frames[0]), depth)
        np.testing.assert_array_equal(self.colours(alone, 0), colour)


if __name__ == "__main__":
    main()
