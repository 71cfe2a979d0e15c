"""Relief below the source, as the command's users meet it: the heights of FORMAT.md's formula, refusals, resume, classes, pictures."""
import json
import math
import pathlib
import re
import signal
import sqlite3
import struct
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, largest, main, write_png16

HEAD = """scene: 1
time_step: 0.05
end_time: {end}
spacing: 0.125
relief: {relief}
redistribute: {{model: box}}
objects:
  - {{name: a, shape: {{wheel: {{radius: 0.8, width: 0.6}}}}, sink: 0.1, path: {{points: [[20, 20], [60, 50], [30, 70]], speed: 8}}}}
"""
RELIEF = "{roughness: 0.08, wavelength: 3, seed: 7}"
MASK = 0xffffffff


def mix(v):
    v ^= v >> 16
    v = v * 0x7feb352d & MASK
    v ^= v >> 15
    v = v * 0x846ca68b & MASK
    return v ^ v >> 16


def amplitude(waves, spacing, level):
    roughness, wavelength = waves
    step = first = spacing * 2.0 ** level
    if step > wavelength / 2:
        return 0
    while 2 * first <= wavelength / 2:
        first *= 2
    return round(1.5 * roughness * math.sqrt(step / first) * math.sqrt(3) / 2 * 2 ** 24)


def raised(x, y, level, spacing, seed, waves_at):
    """By what the post (x, y) of a level is raised, 2^-18 m, from level 0. waves_at(level, x, y): roughness and wavelength of a post."""
    total = 0  # 2^-24 m, times 4^12
    for band in range(-1, level - 1, -1):
        key = mix((mix(seed) + (-1 - band)) & MASK)
        q = 2 ** (band - level)

        def half(number, px, py):
            return (2 * number - 65535) * amplitude(waves_at(band, px, py), spacing, band) >> 16

        def post(px, py):
            """A post of the band's level."""
            cx, cy = px // 2, py // 2
            edges = mix((mix((key + cx) & MASK) + cy) & MASK)
            if px % 2 == 0 and py % 2 == 0:
                return 0
            if py % 2 == 0:
                return 2 * half(edges & 0xffff, px, py)
            if px % 2 == 0:
                return 2 * half(edges >> 16, px, py)
            return -(post(px - 1, py) + post(px + 1, py) + post(px, py - 1) + post(px, py + 1)) // 2

        px, py, u, v = x // q, y // q, x % q, y % q
        value = sum(w * post(px + i, py + j) for i, j, w in ((0, 0, (q - u) * (q - v)), (1, 0, u * (q - v)),
                                                            (0, 1, (q - u) * v), (1, 1, u * v)) if w)
        total += value * 4 ** 12 // q ** 2
    return (total + 2 ** 5 * 4 ** 12) // (2 ** 6 * 4 ** 12)


class Relief(FurrowTest):
    def store(self, name="flat.furrow", spacing=2, posts=65):
        write_png16(self.folder / "flat.png", posts, posts, lambda x, y: 1000)
        self.ok("import", "flat.png", "-o", name, "--spacing", spacing, "--height-range", "0,65535", "--max-error", 0, "--tile", 64)
        return name

    def scene(self, relief=RELIEF, end=5, more="", name="relief.yaml"):
        path = self.folder / name
        path.write_text(HEAD.format(relief=relief, end=end) + more)
        return path

    def drive(self, scene, *arguments):
        self.ok("drive", scene, "--store", "flat.furrow", *arguments, "-o", "out")
        return json.loads((self.folder / "out/run.json").read_text())

    def rows(self, store):
        """What deformation added, row by row; not which commit wrote it."""
        self.json("verify", store)
        with sqlite3.connect(self.folder / store) as db:
            rows = db.execute('SELECT key, low, high, below, above, codec, hash FROM "offset" ORDER BY key').fetchall()
        db.close()
        self.assertGreater(len(rows), 3)
        return rows

    def test_heights_are_those_of_the_formula(self):
        self.store()
        run = self.drive(self.scene(), "--overlay", "over.furrow")
        self.assertEqual(run["relief"], {"roughness": 0.08, "wavelength": 3, "seed": 7})
        self.assertEqual(self.json("info", "over.furrow")["relief"], run["relief"])
        self.assertIsNone(self.json("info", "flat.furrow")["relief"])
        places = [(100 + 7 * k, 37 + 11 * k) for k in range(70)] + [(k, 0) for k in range(40)]
        points = [f"{x * 0.125:.9g}" for place in places for x in place]
        answers = self.json("query", "over.furrow", *points)["points"]
        low, high = 0, 0
        for (x, y), answer in zip(places, answers, strict=True):
            quanta = raised(x, y, -4, 2, 7, lambda *place: (0.08, 3))
            self.assertAlmostEqual((answer["base"] - 1000) * 2 ** 18, quanta, places=4, msg=(x, y))
            wanted = quanta / 2 ** 18
            low, high = min(low, wanted), max(high, wanted)
        self.assertLess(low, -0.08)
        self.assertGreater(high, 0.08)
        # The source's own posts, and a store without it, are as they were.
        for answer in self.json("query", "over.furrow", "30", "42", "128", "128")["points"]:
            self.assertEqual(answer["base"], 1000)
        self.assertEqual(self.json("query", "flat.furrow", *points[:2])["points"][0]["base"], 1000)

    def test_explain_tells_what_is_coarse_and_what_is_too_steep(self):
        self.store()
        more = "soil: {name: lunar}\ncameras: [{name: nav, kind: chase, on: a, back: 3, up: 2, rate: 5, images: [IMAGE]}]\n"

        def notes(image="depth", relief=RELIEF, model="scm", *arguments):
            scene = self.scene(relief, more=more.replace("IMAGE", image))
            scene.write_text(scene.read_text().replace("model: box", "model: " + model))
            return self.json("explain", scene, "--store", "flat.furrow", *arguments)["notes"]

        def find(notes, words):
            return [note for note in notes if words in note]

        coarse, steep = "over relief its numbers", "degrees (root mean square)"
        found = notes()
        self.assertEqual(len(find(found, coarse)), 1)
        # 2.72 r / sqrt(first d) for many levels; here four, posts of 1 m to 0.125 m
        slope = 0.08 * 1.5 * math.sqrt(sum((7 / 6 + 5 / 6 / q ** 2) / q for q in (1, 2, 4, 8)) / 0.125)
        share = math.erfc(math.tan(math.radians(35)) / slope / math.sqrt(2))
        told = re.search(r"slope by (\d+) degrees .*, and lunar is stable up to (\d+): about ([\d.]+) %", find(found, steep)[0])
        self.assertEqual(told.groups()[:2], (f"{math.degrees(math.atan(slope)):.0f}", "35"))
        self.assertAlmostEqual(float(told[3]), 100 * share, delta=0.06 * 100 * share)
        self.assertFalse(find(notes(model="box"), steep))  # nothing slides
        self.assertFalse(find(notes(relief=RELIEF.replace("0.08", "0.01")), steep))
        self.assertFalse(find(notes(image="colour"), coarse))
        fine = "view={camera: {chase: a}, pixel_error: 0.25}"
        self.assertFalse(find(notes("depth", RELIEF, "scm", "--set", fine), coarse))
        self.assertTrue(find(notes("depth", RELIEF, "scm", "--set", fine.replace("0.25", "1")), coarse))

    def test_another_relief_is_refused_and_the_same_goes_on(self):
        self.store()
        self.drive(self.scene(), "--overlay", "over.furrow")
        for relief in (RELIEF.replace("7", "8"), RELIEF.replace("0.08", "0.07"), RELIEF.replace("3,", "4,"), "null"):
            text = self.scene(relief, name="other.yaml").read_text()
            (self.folder / "other.yaml").write_text(text if relief != "null" else text.replace("relief: null\n", ""))
            result = self.furrow("drive", "other.yaml", "--store", "flat.furrow", "--overlay", "over.furrow", "-o", "out2")
            self.assertEqual(result.returncode, 3, relief)
            self.assertRegex(result.stderr, "over.furrow: it was deformed over relief .*\"seed\":7.*; give the scene that relief, or furrow reset")
            self.assertEqual(self.furrow("explain", "other.yaml", "--store", "over.furrow").returncode, 3)
        self.ok("drive", self.scene(end=2, name="again.yaml"), "--store", "flat.furrow", "--overlay", "over.furrow", "-o", "out3")
        self.ok("verify", "over.furrow")
        self.ok("reset", "over.furrow")
        self.assertIsNone(self.json("info", "over.furrow")["relief"])
        self.ok("drive", "other.yaml", "--store", "flat.furrow", "--overlay", "over.furrow", "-o", "out4")

    def test_a_drive_that_was_killed_resumes_to_the_same_rows(self):
        self.store()
        scene = self.scene(end=100000, relief=RELIEF)  # it is killed long before its end, however fast the machine is
        text = scene.read_text().replace("speed: 8", "speed: 8, loop: true") + "cache: {slots: 4}\n"
        scene.write_text(text)
        process = subprocess.Popen([FURROW, "drive", str(scene), "--store", "flat.furrow", "--overlay", "cut.furrow", "-o", "cut"],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.kill)
        self.until_committed(process, "cut")
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertEqual(process.returncode, -signal.SIGKILL)
        steps = self.json("info", "cut.furrow")["last_run"]["step"] + 100
        self.ok("drive", scene, "--store", "flat.furrow", "--overlay", "cut.furrow", "-o", "cut", "--resume", "--steps", steps)
        self.ok("drive", scene, "--store", "flat.furrow", "--overlay", "whole.furrow", "-o", "whole", "--steps", steps)
        self.assertEqual(json.loads((self.folder / "cut/run.json").read_text())["steps"], steps)
        self.assertEqual(self.rows("whole.furrow"), self.rows("cut.furrow"))

    def test_each_class_of_soil_has_its_own(self):
        self.store()
        (self.folder / "classes.png").write_bytes((self.folder / "flat.png").read_bytes())
        write_png16(self.folder / "classes.png", 65, 65, lambda x, y: 1 if x < 20 else 2 if y < 30 else 3)
        soil = "soil: {map: classes.png, classes: {1: dry_sand, 2: mud}, default: dry_sand}\n"
        relief = "{roughness: 0.05, wavelength: 3, seed: 7, classes: {1: 0, 2: {roughness: 0.2, wavelength: 1}}}"
        scene = self.scene(relief, more=soil)
        run = self.drive(scene, "--overlay", "over.furrow")
        self.assertEqual(run["counts"]["unplanned"], 0)
        self.assertEqual([waves["roughness"] for waves in run["relief"]["classes"]], [0.05, 0, 0.2])
        self.assertNotIn("subdivide.frag", json.dumps(self.json("explain", scene, "--store", "flat.furrow")["programs"]))
        # No GPU and no scene: what the map says is not known, and that is told.
        result = self.furrow("query", "over.furrow", "100.125", "100.125")
        self.assertIn("relief by class of soil", result.stderr)
        self.assertIn("base 1000.0000", result.stdout)
        few = self.scene(relief, more=soil + "cache: {slots: 4, loaders: 0}\n", name="few.yaml")
        self.drive(few, "--overlay", "few.furrow")
        self.assertEqual(self.rows("over.furrow"), self.rows("few.furrow"))
        # The same list of classes, and other values for them: another ground.
        other = soil.replace("{1: dry_sand, 2: mud}", "{2: dry_sand, 1: mud}")
        swapped = self.scene("{roughness: 0.05, wavelength: 3, seed: 7, classes: {2: 0, 1: {roughness: 0.2, wavelength: 1}}}", more=other, name="swapped.yaml")
        result = self.furrow("drive", swapped, "--store", "flat.furrow", "--overlay", "over.furrow", "-o", "out2")
        self.assertEqual(result.returncode, 3)
        self.assertIn("was deformed over relief", result.stderr)
        for wrong, why in (("classes: {4: 0.1}", "4 is no class of soil.classes"), ("classes: [{value: 1, roughness: 1}, {value: 1, roughness: 2}]", "each value once"),
                           ("classes: {1: 11}", "is out of range")):
            scene = self.scene("{roughness: 0.05, wavelength: 3, " + wrong + "}", more=soil, name="wrong.yaml")
            result = self.furrow("explain", scene)
            self.assertEqual(result.returncode, 3, wrong)
            self.assertIn(why, result.stderr)
        result = self.furrow("explain", self.scene("{roughness: 0.05, wavelength: 3, classes: {1: 0.1}}", name="wrong.yaml"))
        self.assertIn("relief.classes: is of a map of soils, and there is none", result.stderr)

    def test_what_raises_nothing_is_told_and_changes_nothing(self):
        self.store()
        plain = self.scene(name="plain.yaml")
        plain.write_text(re.sub("relief: .*\n", "", plain.read_text()))
        self.drive(plain, "--overlay", "plain.furrow")
        wanted = self.rows("plain.furrow")
        for i, (relief, why) in enumerate((("{roughness: 0, wavelength: 3}", "relief: a roughness of 0 raises nothing"),
                                           ("{roughness: 0.1, wavelength: 0.2}", "relief: posts 0.125 m apart show no waves of 0.2 m; give a spacing of at most 0.1"))):
            scene = self.scene(relief)
            result = self.furrow("drive", scene, "--store", "flat.furrow", "--overlay", f"{i}.furrow", "-o", "out")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(why, result.stderr)
            self.assertEqual(self.rows(f"{i}.furrow"), wanted)
        scene = self.scene()
        scene.write_text(scene.read_text().replace("spacing: 0.125\n", ""))
        self.assertIn("relief: it raises posts between the store's, which are 2 m apart", self.ok("explain", scene, "--store", "flat.furrow"))
        for wrong in ("{roughness: 0.1}", "{wavelength: 1}", "{roughness: -1, wavelength: 1}", "{roughness: 0.1, wavelength: 0}",
                      "{roughness: 0.1, wavelength: 1, seed: 1.5}", "{roughness: 0.1, wavelength: 1, seed: 4294967296}", "7"):
            self.assertEqual(self.furrow("explain", self.scene(wrong, name="wrong.yaml")).returncode, 3, wrong)

    def test_a_picture_shows_it_where_no_wheel_went(self):
        self.store()
        view = "view: {size: [320, 180], camera: {fixed: {eye: [60, 20, 1001.5], target: [90, 60, 1000]}}, images: 100, effects: [skirts]}\n"
        pixels = {}
        for name, relief in (("with", RELIEF), ("without", None)):
            scene = self.scene(more=view, name=name + ".yaml")
            if relief is None:
                scene.write_text(re.sub("relief: .*\n", "", scene.read_text()))
            self.ok("drive", scene, "--store", "flat.furrow", "--overlay", name + ".furrow", "-o", name)
            pixels[name] = (self.folder / name / "frame-000100.png").read_bytes()
        self.assertGreater(len(pixels["with"]), 1.5 * len(pixels["without"]))

    def test_pictures_show_no_cells_of_the_finest_posts(self):
        """From 1.5 m above, a cell of 12.5 cm is 30 pixels wide. So from pixel to pixel the normal turns little, also where cells meet."""
        self.store()
        camera = ("cameras: [{name: a, kind: fixed, rate: 1, fov: 45, size: [300, 300], pose: {at: [90, 20, 1001.5], pitch: -90}, images: [normals]}]\n")
        self.ok("drive", self.scene(end=0.1, more=camera), "--store", "flat.furrow", "--overlay", "o.furrow", "-o", "out")
        header, numbers = (self.folder / "out/cameras/a/normals/000000.npy").read_bytes().split(b"\n", 1)
        self.assertIn(b"(300, 300, 3)", header)
        east = struct.unpack("<270000f", numbers)[::3]
        turns = [abs(east[i + 1] - east[i]) for i in range(len(east) - 1) if i % 300 < 299]
        self.assertGreater(max(east) - min(east), 0.5)
        self.assertLess(largest(turns), 0.15)


if __name__ == "__main__":
    main()
