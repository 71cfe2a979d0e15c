"""Exposures of pictures, linear light, and notes of frames that show nothing: by the formulas of docs/CAMERAS.md, computed again with NumPy."""
import csv
import pathlib
import struct
import sys
import unittest
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import read_png
from furrow_test import FurrowTest, main

EYE = "pose: {at: [90, 100, 60], target: [120, 120, 20]}"
SCENE = """scene: 1
end_time: 0.2
time_step: 0.1
objects: [{name: r, shape: {sphere: {radius: 2}}, sink: 0.1, path: {points: [[110, 112], [114, 116]], speed: 2}}]
view: {size: [64, 48], camera: {fixed: {eye: [90, 100, 60], target: [120, 120, 20]}}, effects: [texture, sky, objects, shadow, skirts], body: BODY, SUN}
cameras:
"""


def read_wide(path):
    """RGB of 16 bits, rows from the top, unfiltered or filtered by SUB."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    assert (bits, colour) == (16, 2)
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, width * 6 + 1)
    assert set(rows[:, 0]) <= {0, 1}
    sums = np.cumsum(rows[:, 1:].reshape(height, width, 6).astype(np.uint32), axis=1).astype(np.uint8)
    pixels = np.where(rows[:, :1, None] == 1, sums, rows[:, 1:].reshape(height, width, 6)).astype(int)
    return pixels[..., 0::2] * 256 + pixels[..., 1::2]


def film(light):
    """The curve of shaders/lib/tone.glsl, then sRGB, 0 to 255."""
    value = np.clip(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0, 1)
    return 255 * np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


class Light(FurrowTest):
    def setUp(self):
        super().setUp()
        self.synth()
        self.drives = 0

    def shoot(self, cameras, sun="sun: {height: 35}", body="earth"):
        """run.json of a drive with these cameras; each value of `cameras` has the keys of one."""
        listed = [f"  - {{name: {name}, kind: fixed, rate: 10, size: [64, 48], {keys if 'pose' in keys else EYE + ', ' + keys}}}\n" for name, keys in cameras.items()]
        self.drives += 1
        return self.drive(self.scene(SCENE.replace("SUN", sun).replace("BODY", body) + "".join(listed)), "--store", "world.furrow",
                          "--overlay", f"{self.drives}.furrow")

    def picture(self, camera, frame=0, image="colour"):
        return (self.folder / f"out/cameras/{camera}/{image}/{frame:06}.png")

    def exposures(self, camera):
        with open(self.folder / f"out/cameras/{camera}/frames.csv", encoding="utf-8") as file:
            return [float(row["exposure"]) for row in csv.DictReader(file)]

    def test_linear_light_gives_the_colours_by_the_film(self):
        self.shoot({"a": "images: [colour, linear]", "b": "ev: 1, images: [colour, linear]", "c": "exposure: auto, images: [colour, linear]"})
        one = read_wide(self.picture("a", image="linear")) / 65535 * 4
        for camera in "abc":
            exposure, = set(self.exposures(camera)[:1])
            wide = read_wide(self.picture(camera, image="linear"))
            light = wide / 65535 * 4
            self.assertLess(np.abs(film(light) - read_png(self.picture(camera))).max(), 2.2, camera)  # the noise against bands, and rounding
            whole = wide.max(axis=2) < 65535
            self.assertGreater(whole.mean(), 0.8)
            self.assertLess(np.abs(light / exposure - one)[whole & (one.max(axis=2) < 3.9)].max(), 4 / 65535 * (1 + 1 / exposure), camera)
        self.assertEqual(self.exposures("a"), [1, 1, 1])
        self.assertEqual(self.exposures("b"), [2, 2, 2])

    def test_an_automatic_exposure_makes_the_mean_a_middle_grey(self):
        for sun, body in (("sun: {height: 35}", "earth"), ("sun: {height: 4}", "earth"), ("sun: {height: 10}", "mars"), ("sun: {height: 60}", "moon")):
            self.shoot({"c": "exposure: auto, images: [colour, linear]", "up": "exposure: auto, ev: -1"}, sun, body)
            light = read_wide(self.picture("c", image="linear")) / 65535 * 4
            exposure = self.exposures("c")[0]
            mean = np.minimum(light / exposure @ [0.2126, 0.7152, 0.0722], 4).mean() * exposure
            self.assertAlmostEqual(mean, 0.18, delta=0.004, msg=(sun, body))
            self.assertAlmostEqual(self.exposures("up")[0], exposure / 2, delta=1e-6 * exposure)

    def test_a_frame_does_not_depend_on_those_before(self):
        """A camera that has looked into the sky and at the ground before, and one that draws its first frame beside it, see the same."""
        (self.folder / "eyes.csv").write_text("t,x,y,z,yaw,pitch,roll\n0,90,100,60,0,70,0\n0.1,90,100,60,0,-80,0\n0.2,90,100,60,45,-40,0\n")
        (self.folder / "stays.csv").write_text("t,x,y,z,yaw,pitch,roll\n0,90,100,60,45,-40,0\n1,90,100,60,45,-40,0\n")
        row = "  - {name: %s, kind: poses, file: %s.csv, rate: 10, size: [64, 48], exposure: auto}\n"
        self.drive(self.scene(SCENE.replace("SUN", "sun: {height: 12}").replace("BODY", "earth") + row % ("a", "eyes") + row % ("b", "stays")), "--store", "world.furrow",
                   "--overlay", "poses.furrow")
        self.assertEqual(self.picture("a", 2).read_bytes(), self.picture("b", 2).read_bytes())
        self.assertEqual(self.exposures("a")[2], self.exposures("b")[2])
        self.assertGreater(len(set(self.exposures("a"))), 2)

    def test_other_keys_keep_their_bits(self):
        self.shoot({"a": "images: [colour]"})
        plain, first = self.picture("a").read_bytes(), read_png(self.picture("a")).astype(int)
        self.assertFalse((self.folder / "out/cameras/a/frames.csv").exists())
        self.shoot({"a": "images: [colour]", "b": "ev: 2"})
        self.assertEqual(self.picture("a").read_bytes(), plain)
        self.assertNotEqual(self.picture("b").read_bytes(), plain)
        self.shoot({"a": "images: [colour]", "b": "images: [linear]"})
        self.assertLess(np.mean(np.abs(read_png(self.picture("a")).astype(int) - first) > 1), 0.02)  # soft edges of shadows

    def test_white_frames_are_told_with_why(self):
        for rest, why in (("ev: 12", "it is exposed 4.1e+03 times as bright as fixed; give a lower ev, or exposure: auto"),
                          ("ev: 14, pose: {at: [90, 100, 60], pitch: 80}", "no ground is in view, so it shows the sky alone; turn the camera to the ground")):
            notes = [note for note in self.shoot({"c": rest})["notes"] if "is white" in note]
            self.assertEqual(len(notes), 1)
            self.assertRegex(notes[0], r"^cameras/c/colour/000000\.png: is white, and 2 more: [\d.]+ % of its pixels are brighter than 249 of 255: ")
            self.assertTrue(notes[0].endswith(why), notes[0])
        self.assertEqual([note for note in self.shoot({"c": "ev: 0"})["notes"] if "is white" in note or "is black" in note], [])

    def test_local_times_on_mars_are_told(self):
        """Perseverance landed at 15:53 of local mean solar time; the sun is then in the west."""
        sun = self.shoot({"c": "ev: 0"}, 'sun: {time: "2021-02-18T20:43:49Z", at: [77.4508, 18.4447]}', "mars")["sun"]
        self.assertAlmostEqual(sun["local_mean_solar_time"][0], 15 + 53 / 60, delta=0.04)
        self.assertAlmostEqual((sun["local_mean_solar_time"][1] - sun["local_mean_solar_time"][0]) * 1.0274912517 * 3600, 0.2, delta=1e-3)
        self.assertGreater(sun["azimuth"], 200)
        self.assertNotIn("local_mean_solar_time", self.shoot({"c": "ev: 0"}, 'sun: {time: "2021-02-18T20:43:49Z", at: [77.4508, 18.4447]}', "earth")["sun"])

    def test_a_black_sky_is_told_as_such(self):
        note, = [note for note in self.shoot({"c": "pose: {at: [90, 100, 60], pitch: 80}"}, body="moon")["notes"] if "is black" in note]
        self.assertTrue(note.endswith("no ground is in view, so it shows the sky alone; turn the camera to the ground, or give view.effects: [sky]"), note)


if __name__ == "__main__":
    main()
