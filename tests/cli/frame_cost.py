"""What furrow explain says that pictures cost: by the table of bench/frame_costs.py, computed again here."""
import json
import pathlib
import re
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = """scene: 1
end_time: 100
time_step: 0.1
spacing: 0.25
objects: [{name: r, shape: {sphere: {radius: 1}}, sink: 0.1, path: {points: [[100, 110], [120, 130]], speed: 0.25}}]
view: {camera: {fixed: {eye: [90, 100, 60], target: [120, 120, 20]}}, effects: [texture, sky, objects]}
cameras: [{name: a, kind: fixed, rate: 1, size: [320, 200], pose: {at: [90, 100, 60], target: [120, 120, 20]}}]
"""


class FrameCost(FurrowTest):
    def told(self, *settings):
        return json.loads(self.ok("explain", "scene.yaml", "--store", "world.furrow", "--json", *(word for key in settings for word in ("--set", key))))

    def test_it_is_what_the_bench_measured(self):
        done = subprocess.run([sys.executable, str(ROOT / "bench/frame_costs.py"), "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        of = {key: figure["value"] for key, figure in json.loads((ROOT / "bench/figures/looks.json").read_text())["figures"].items()}
        self.synth()
        self.scene(SCENE)
        size = lambda *pixels: "cameras.a.size=[%d, %d]" % pixels
        frame = lambda *settings: self.told(*settings)["cameras"]["a"]["frame_seconds"]
        self.assertAlmostEqual(frame(size(640, 480)), of["shadow.none.picture"], delta=1e-4)
        self.assertAlmostEqual(frame(size(1280, 720)), of["samples.none.picture"], delta=1e-4)
        plain, shaded = frame(), frame("view.effects=[terrain_shadow]")
        relief = "relief={roughness: 0.02, wavelength: 2}"
        for found, key in ((frame("view.samples=4"), "samples.four"), (shaded, "shadow.terrain_shadow"), (frame("view.pixel_error=1"), "finer.one_pixel"),
                           (frame("view.pixel_error=0.25"), "finer.quarter_pixel"), (frame("view.pixel_error=2", relief), "relief.relief_two_pixels")):
            self.assertAlmostEqual(found / plain / of[f"{key}.ratio"], 1, delta=2e-3, msg=key)
        self.assertAlmostEqual(frame("view.effects=[terrain_shadow]", "view.pixel_error=0.25") / shaded / of["finest.quarter_pixel.ratio"], 1, delta=2e-3)
        self.assertAlmostEqual(frame("cameras.a.images=[colour, normals]") / plain, 2, delta=1e-6)
        told = self.told()
        self.assertAlmostEqual(told["pictures_seconds"], 101 * plain, delta=1e-6)
        with_view = self.told("view.images=10", "view.size=[320, 200]")
        self.assertAlmostEqual(with_view["pictures_seconds"], (101 + 100) * plain, delta=1e-6)

    def test_a_dear_picture_is_told_and_a_cheap_one_is_not(self):
        self.synth()
        self.scene(SCENE)
        dear = ("view.samples=4", "view.pixel_error=0.25", "relief={roughness: 0.02, wavelength: 2}", "cameras.a.rate=5")
        notes = [note for note in self.told(*dear)["notes"] if "a picture takes about" in note]
        self.assertEqual(len(notes), 1)
        found = re.match(r"view: pixel_error: 0\.25 over relief, samples: 4: a picture takes about 14 times as long as without: with software GL ([\d.]+) s of one processor each, "
                         r"(\d+) s for all 501; on a GPU less\.", notes[0])
        self.assertTrue(found, notes[0])
        self.assertAlmostEqual(float(found.group(2)), self.told(*dear)["pictures_seconds"], delta=0.51)
        self.assertAlmostEqual(float(found.group(1)) * 501, float(found.group(2)), delta=0.05 * float(found.group(2)))
        for cheap in ((), ("view.samples=4",), (*dear, "end_time=1")):
            self.assertEqual([note for note in self.told(*cheap)["notes"] if "a picture takes about" in note], [], cheap)
        text = self.ok("explain", "scene.yaml", "--store", "world.furrow")
        self.assertRegex(text, r"\n  a +320 x 200, 1 a second: 101 frames of colour, 250 KiB and about 0\.015 s each\n")
        self.assertRegex(text, r"\npictures: about 1\.5 s of one processor with software GL \(within a factor of three\)\n")


if __name__ == "__main__":
    main()
