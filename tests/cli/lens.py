"""Lenses, exposure times and noise of cameras: known points are where the model says, noise has its size and follows its seed, and bags and datasets tell the model."""
import json
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import matrix, read_png  # noqa: E402
from furrow_test import FurrowTest, main, use_package, write_png16  # noqa: E402

BALLS = [(18.0, 26.0), (24.0, 26.0), (21.0, 24.0), (16.5, 22.0), (25.5, 22.0)]
SCENE = """scene: 1
time_step: 0.02
end_time: 0.2
objects: [%s]
cameras:
  - {name: eye, kind: fixed, pose: {at: [21, 16, 26], target: [21, 24, 20.3]}, rate: 50, size: [320, 240], fov: 100, images: [colour, depth, instance]}
""" % ", ".join(f"{{name: ball_{i}, shape: {{sphere: {{radius: 0.4}}}}, path: {{points: [[{x}, {y}], [{x + 1}, {y}]], speed: 5}}}}" for i, (x, y) in enumerate(BALLS))
BROWN = [-0.25, 0.06, 0.0012, -0.0008, 0.004]
FISHEYE = [0.02, -0.011, 0.006, -0.001]


class LensTest(FurrowTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        use_package()

    def setUp(self):
        super().setUp()
        write_png16(self.folder / "level.png", 65, 65, lambda x, y: 20000)
        self.ok("import", "level.png", "-o", "plain.furrow", "--spacing", 1, "--height-range", "0,65.535")
        self.scene(SCENE)
        self.drive("scene.yaml", "--store", "plain.furrow", "--overlay", "ruts.furrow")
        self.cameras = self.folder / "out/cameras"

    def told(self, name):
        return json.loads((self.cameras / name / "camera.json").read_text())


class ModelsTest(LensTest):
    def test_known_rays_are_where_the_formulas_say(self):
        from furrow import lens
        k1, k2, p1, p2, k3 = BROWN
        x, y, r2 = 0.3, -0.4, 0.25
        radial = 1 + k1 * r2 + k2 * r2 ** 2 + k3 * r2 ** 3
        np.testing.assert_allclose(lens.distort("brown_conrady", BROWN, [2 * x, 2 * y, 2]), [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], atol=1e-15)
        angle = np.radians(110)  # behind the image plane
        k = FISHEYE
        far = angle + k[0] * angle ** 3 + k[1] * angle ** 5 + k[2] * angle ** 7 + k[3] * angle ** 9
        np.testing.assert_allclose(lens.distort("fisheye", FISHEYE, [np.sin(angle) * 0.6, np.sin(angle) * 0.8, np.cos(angle)]), [0.6 * far, 0.8 * far], atol=1e-14)

    def test_the_inverse_is_the_inverse(self):
        from furrow import lens
        for model, numbers, most in (("pinhole", [], 80), ("brown_conrady", BROWN, 45), ("fisheye", FISHEYE, 115)):
            angles, around = np.meshgrid(np.radians(np.linspace(0, most, 24)), np.linspace(0, 2 * np.pi, 37))
            rays = np.stack([np.sin(angles) * np.cos(around), np.sin(angles) * np.sin(around), np.cos(angles)], axis=-1)
            back = lens.undistort(model, numbers, lens.distort(model, numbers, rays))
            back /= np.linalg.norm(back, axis=-1, keepdims=True)
            np.testing.assert_allclose(back, rays, atol=1e-9)
        self.assertTrue(np.isnan(lens.undistort("brown_conrady", [-0.5, 0, 0, 0, 0], [[3.0, 0.0]])).any()) # no ray comes so far out

    def test_noise_has_its_size_and_its_seed(self):
        from furrow import lens
        numbers = lens.noise(3, 5, (200, 300, 3))
        np.testing.assert_array_equal(numbers, lens.noise(3, 5, (200, 300, 3)))
        self.assertAlmostEqual(numbers.mean(), 0, delta=0.01)
        self.assertAlmostEqual(numbers.std(), 1, delta=0.01)
        self.assertAlmostEqual((np.abs(numbers) > 2).mean(), 0.0455, delta=0.004)
        for other in (lens.noise(4, 5, (200, 300, 3)), lens.noise(3, 6, (200, 300, 3)), lens.noise(3, 5, (200, 300, 3), "left"), lens.noise(3, 5, (200, 300, 3), "left_right"), np.roll(numbers, 1, axis=1)):
            self.assertAlmostEqual(np.corrcoef(numbers.ravel(), other.ravel())[0, 1], 0, delta=0.01)
        light = np.full((200, 300, 3), 0.36)
        self.assertAlmostEqual((lens.expose(light, 0.01, 2500, 1, 0) - light).std(), np.sqrt(0.01 ** 2 + 0.36 / 2500), delta=2e-4)
        # A number does not depend on the size of the picture.
        self.assertEqual(float(numbers[0, 0, 0]), float(lens.noise(3, 5, (1,))[0]))


class PicturesTest(LensTest):
    def test_known_points_are_where_the_model_projects_them(self):
        """The middles of balls on the ground, and all points of the pinhole's depth."""
        from furrow import lens
        eye = self.told("eye")
        frame = eye["frames"][3]
        instances = read_png(self.cameras / "eye/instance/000003.png")
        depth = np.load(self.cameras / "eye/depth/000003.npy").astype(float)
        middles = [(x + 5 * 0.06, y) for x, y in BALLS]
        axes = matrix(frame["orientation"])
        columns, rows = np.meshgrid(np.arange(320) + 0.5, np.arange(240) + 0.5)
        points = np.stack([(columns - eye["cx"]) / eye["fx"], (rows - eye["cy"]) / eye["fy"], np.ones_like(rows)], axis=-1) * np.where(np.isfinite(depth), depth, 1)[..., None]
        near = np.where(np.isfinite(depth), depth, 1e3)
        steep = np.hypot(*np.gradient(near)) > 0.02 * near # at silhouettes
        for model, numbers in (("brown_conrady", BROWN), ("fisheye", FISHEYE)):
            self.ok("lens", "out", "--camera", "eye", "-o", model, "--model", model, f"--coefficients={','.join(map(str, numbers))}", "--focal", 110)
            new = np.load(self.cameras / model / "depth/000003.npy")
            at = np.floor(lens.distort(model, numbers, points) * 110 + [160, 120]).astype(int)
            inside = np.isfinite(depth) & ~steep & (at >= 2).all(axis=-1) & (at < [318, 238]).all(axis=-1)
            off = np.abs(new[at[inside][:, 1], at[inside][:, 0]] - depth[inside]) / depth[inside]
            self.assertGreater(len(off), 20000)
            self.assertLess(np.percentile(off, 98), 0.02)
            shown, seen = lens.Lens(eye, model, numbers, 110, (320, 240)).depths(instances[..., 0] if instances.ndim == 3 else instances), 0
            for number, (x, y) in enumerate(middles, 1):
                at = np.argwhere(shown == number)
                if len(at) < 6:
                    continue
                ray = axes.T @ (np.array([x, y, 20.4]) - frame["position"])
                expected = lens.distort(model, numbers, ray) * 110 + [160, 120]
                np.testing.assert_allclose(at.mean(axis=0)[::-1] + 0.5, expected, atol=0.7, err_msg=f"{model} {number}")
                seen += 1
            self.assertGreaterEqual(seen, 4)

    def test_a_lens_without_distortion_leaves_pictures_as_they_are(self):
        self.ok("lens", "out", "--camera", "eye", "-o", "same")
        for n in range(3):
            np.testing.assert_array_equal(read_png(self.cameras / f"same/colour/{n:06d}.png"), read_png(self.cameras / f"eye/colour/{n:06d}.png"))
            np.testing.assert_array_equal(np.load(self.cameras / f"same/depth/{n:06d}.npy"), np.load(self.cameras / f"eye/depth/{n:06d}.npy"))
        self.assertEqual(self.told("same")["frames"][2]["position"], self.told("eye")["frames"][2]["position"])

    def test_an_exposure_is_the_mean_light(self):
        self.ok("lens", "out", "--camera", "eye", "-o", "slow", "--exposure", 0.04, "--every", 5)
        def light(picture):
            srgb = picture / 255
            return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        slow = read_png(self.cameras / "slow/colour/000001.png")
        mean = (light(read_png(self.cameras / "eye/colour/000004.png")) + light(read_png(self.cameras / "eye/colour/000005.png"))) / 2
        np.testing.assert_allclose(light(slow), mean, atol=0.006)
        self.assertEqual([frame["time"] for frame in self.told("slow")["frames"]], [self.told("eye")["frames"][i]["time"] for i in (0, 5, 10)])

    def test_a_seed_repeats_to_the_bit(self):
        for name, seed in (("a", 1), ("b", 1), ("c", 2)):
            self.ok("lens", "out", "--camera", "eye", "-o", name, "--noise", 0.02, "--electrons", 500, "--seed", seed)
        a, b, c = ((self.cameras / name / "colour/000002.png").read_bytes() for name in "abc")
        self.assertEqual(a, b)
        self.assertNotEqual(a, c)
        # A camera that sees the same has noise of its own.
        shutil.copytree(self.cameras / "eye", self.cameras / "twin")
        self.ok("lens", "out", "--camera", "twin", "-o", "d", "--noise", 0.02, "--electrons", 500, "--seed", 1)
        self.assertFalse(a == (self.cameras / "d/colour/000002.png").read_bytes())

    def test_camera_info_tells_the_model(self):
        from furrow import bag, lens, results
        for model, numbers, word in (("brown_conrady", BROWN, "plumb_bob"), ("fisheye", FISHEYE, "equidistant")):
            self.ok("lens", "out", "--camera", "eye", "-o", model, "--model", model, f"--coefficients={','.join(map(str, numbers))}")
            camera = results.Drive(self.folder / "out").cameras[model]
            messages = list(bag._of_camera(model, camera, True))
            info = next(m for _, topic, _, m in messages if topic == f"/{model}/camera_info")
            self.assertEqual((info["distortion_model"], info["d"]), (word, numbers))
            self.assertAlmostEqual(info["k"][2], 159.5, delta=1e-12)
            cloud = np.frombuffer(next(m for _, topic, _, m in messages if topic == f"/{model}/points")["data"], "<f4").reshape(-1, 3)
            depth = np.load(camera["folder"] / "depth/000000.npy")
            rows, columns = np.nonzero(np.isfinite(depth))
            at = lens.distort(model, numbers, cloud.astype(float)) * camera["fx"] + [camera["cx"], camera["cy"]]
            np.testing.assert_allclose(at, np.stack([columns + 0.5, rows + 0.5], axis=1), atol=1e-3)

    def test_what_is_wrong_is_one_line(self):
        for arguments, status, words in ((("lens", "out", "--camera", "eye"), 2, "-o is missing"), (("lens", "out", "-o", "x"), 2, "--camera is missing"),
                                         (("lens", "out", "--camera", "nose", "-o", "x"), 3, "there are: eye"),
                                         (("lens", "out", "--camera", "eye", "-o", "x", "--model", "fisheye", "--coefficients=1,2"), 3, "the model fisheye has 4"),
                                         (("lens", "out", "--camera", "eye", "-o", "eye"), 3, "there already"),
                                         (("lens", "out", "--camera", "eye", "-o", "../x"), 3, "no name")):
            told = self.furrow(*arguments)
            self.assertEqual(told.returncode, status, (arguments, told.stderr))
            self.assertRegex(told.stderr, r"^furrow: .+; .+\n$")
            self.assertIn(words, told.stderr)
        self.assertEqual([path.name for path in self.cameras.iterdir()], ["eye"])


if __name__ == "__main__":
    main()
