"""What a message suggests works when it is typed. Each message that suggests a number, a word or a command is followed here, or has a
reason why it is not. A new one without a row fails the last test."""
import json
import os
import pathlib
import re
import subprocess
import unittest

from furrow_test import FURROW, FurrowTest, main

ROOT = pathlib.Path(os.environ.get("SOURCES", pathlib.Path(__file__).resolve().parents[2] / "src")).parent
NUMBER = r"(-?[0-9][0-9.e+-]*[0-9]|[0-9])"

SCENE = """scene: 1
time_step: 0.05
end_time: 20
redistribute: {model: scm}
soil: {name: dry_sand}
objects:
  - {name: a, shape: {wheel: {radius: 0.5, width: 3}}, sink: 0.1, path: {points: [[20, 20], [21, 20]], speed: 1}}
"""
VEHICLE = """scene: 1
time_step: 0.002
end_time: 0.02
spacing: 0.25
soil: {name: dry_sand}
redistribute: {model: scm}
vehicles:
  - {name: car, model: one_wheel.xml, start: {at: [20, 20]}, driver: {hold: {drive: 1}}}
"""

# What to set, the note or the refusal, and what to set then: {0} and {1} are what the message says. The message must then be gone.
# The fourth is the part of the message in the sources by which the last test knows it.
SCENES = [
    ({"spacing": 0.0244}, rf"spacing: .* give {NUMBER}, or {NUMBER} for a quarter", [{"spacing": "{0}"}, {"spacing": "{1}"}],
     "give %s, or %s for a quarter of the posts"),
    ({"spacing": 5}, rf"none that are farther; give {NUMBER}", [{"spacing": "{0}"}], "none that are farther; give %s"),
    ({"spacing": 1e-9}, rf"is finer than {NUMBER} m", [{"spacing": "{0}"}], "is finer than %s m"),
    ({"objects.a.shape": "{wheel: {radius: 0.5, width: 0.24414061}}"}, rf"it can pass .* at most {NUMBER}", [{"spacing": "{0}"}],
     "it can pass between them"),
    ({"spacing": 0.5, "objects.a.shape.wheel.grousers": 37}, rf"cannot tell them apart; give fewer, or a spacing of at most {NUMBER}", [{"spacing": "{0}"}],
     "cannot tell them apart"),
    ({"relief": "{roughness: 0.01, wavelength: 0.48828122}", "spacing": 0.4}, rf"relief: .* give a spacing of at most {NUMBER}", [{"spacing": "{0}"}],
     "show no waves of %g m"),
    ({"redistribute": "{model: sheet, tension: 1e9}"}, rf"bends over .*, or a tension of at most {NUMBER}", [{"redistribute.tension": "{0}"}], "which is more than %d posts"),
    ({"end_time": 10, "objects.a.path.speed": 8.10002e-05}, rf"the whole path takes .*: give end_time {NUMBER}", [{"end_time": "{0}"}], "give end_time %s"),
    ({"output": "{forces: 3}", "objects.a.path.speed": 1.99999}, rf"output.forces: .* no object comes to more than {NUMBER} posts", [{"output.forces": "{0}"}],
     "no object comes to more than %s posts"),
    ({"objects.a.path": "{points: [[20, 20]], speed: 1}", "output": "{forces: 50}", "end_time": 7}, rf"one is enough, with less than {NUMBER}",
     [{"output.forces": "0.14"}], "one is enough, with less than %s"),
    ({"cache": "{slots: 300}"}, rf"the others stay empty; give {NUMBER}", [{"cache.slots": "{0}"}], "the others stay empty; give %.0f"),
    ({"cache": "{memory: 1 MB}"}, rf"is too little .* give at least {NUMBER} MB", [{"cache.memory": "{0} MB"}], "is too little for %u slots"),
    ({"cache": "{prefetch: 0}"}, rf"give seconds of travel, as {NUMBER}", [{"cache.prefetch": "{0}"}], "give seconds of travel"),
    ({"objects.a.shape.wheel": "{radius: 0.5, width: 3, grousers: 100, grouser_thickness: 0.1}"}, rf"do not fit around it; give at most {NUMBER} m",
     [{"objects.a.shape.wheel.grouser_thickness": "{0}"}], "do not fit around it"),
    ({"time_step": 30}, r"it is one step; give less", [{"time_step": "0.1"}], None),
    ({"view": "{camera: {overhead: {over: a, height: 9}}, images: 9999}"}, r"ends after ([0-9]+): none is written; give at most that", [{"view.images": "{0}"}],
     None),
    ({"objects.a.load": 9}, None, [], None),
    ({"redistribute": "{model: scm, undisturbed: slides}"}, r"redistribute.undisturbed: .* give a depth, or stable",
     [{"redistribute.depth": "0.1"}, {"redistribute.undisturbed": "stable"}], None),
    ({"view": "{camera: {overhead: {over: a, height: 9}}, sun: {height: 0.01}, images: 9}"}, rf"give {NUMBER} or more, a brighter view.sun.colour, or view.exposure: sun",
     [{"view.sun.height": "{0}"}, {"view.exposure": "sun"}], "%sgive %g or more"),
    ({"soil": "{name: dry_sand, friction_angle: 0.5}"}, rf"radians; the unit is degrees: give {NUMBER}", [{"soil.friction_angle": "{0}"}], "the unit is degrees"),
    ({"soil": "{name: mud}"}, r"or name one of ([a-z_0-9]+)", [{"soil": "{{name: {0}}}"}], "give these beside the name, or name one of"),
    ({"objects.a.path": "{points: [[20, 20], [400, 20]], speed: 100}"}, r"set outside: (skip)", [{"outside": "{0}"}], "or set outside: skip"),
]

# By the part of the message in the sources: which test types it, or why none does.
ELSEWHERE = {
    "has no imagery; add some with": "cli/imagery_drawn", "and more if another part needs more": "cli/imagery_drawn",
    "give at most %.4g Pa, or a higher": "a measured tyre, docs/VEHICLES.md: no default is near it",
    # tests of this file
    "furrow reset %s": "commands", "furrow restore %s": "commands", "give --window %s": "windows", "--window %s": "windows",
    "--%s is for --tiles": "two options, cli/tiles", "give one above %g and at most %g": "a range", "is missing; give %s": "cli/bag", "show no rocks of %g m": "cli/rocks",
    "spikes or not met; give %g m": "any larger size will do",
    "give 0 to %d": "a range", "coarser than the store's coarsest": "windows", "time_step: %g s is longer": "vehicles", "give gravity: %s": "vehicles",
    "give gravity: %g": "cli/planets", "give view.body: %s": "cli/planets", "soil.damping presses a post": "vehicle/damped.c", "it comes to no rest": "any finer spacing will do", "its axles look along its": "vehicle/strangers.c", "is for --tiles; give --tiles DIR": "no number", "shorten time_step": "a motion that diverged is not made by a scene of a few lines",
    "the lowest height is %s m": "nodata", "give \"--nodata %s": "nodata", "give --nodata %s": "nodata", "import again with --nodata %g": "nodata",
    "give --max-error %s or more": "nodata", "keep it smooth": "cli/vertical", "keeps them smooth": "any number will do",
    # numbers, tests/scene/units.c sets each again
    "is less than soils have": "scene/units.c", "is more than soils have": "scene/units.c", "is large, and perhaps in mm": "scene/units.c",
    "less than the wheel's own weight": "scene/units.c", "degrees is narrow": "scene/units.c", "furrow scene lists all": "cli/scene_page", "degrees above the horizon": "scene/units.c",
    # ranges: what is allowed is named, and the range's own tests try its ends
    "is not kept; give %d to %d": "a range", "pixels; give 1 to %u each": "a range", "not a value it takes; give %s": "help.py types the words",
    "step: %g s from %g s on lead beyond": "api/misuse.c", "give an EPSG code, WKT, PROJ or IAU name": "cli/hostile", "no post was below it in any of": "cli/notes",
    "the sun is %.1f degrees below the horizon": "cli/notes", "as in %s/terrain.furrow": "cli/mistakes", "is empty; give %s": "cli/mistakes", "furrow prune %s lists it": "cli/pins",
    "set it to sizeof": "api/arguments.c", "cannot be deformed; give one from": "a range", "there is no level %d; give one": "a range",
    "are numbers; give at most": "a range", "numbers; give at most %d": "a range", "is out of range; give %g to %g": "a range", "are too many; give": "a range",
    "names no snapshot": "any name will do", "needs a value; give": "help.py", "is no number of slots": "a range", "is not an option; see": "help.py",
    "not a command; see": "help.py", "say which: line: 1 to": "cli/lines", "a resolution that make": "a range", "report: %zu folders": "a range",
    "is too large for posts": "about sizes of a shape: no key of its own", "is too large for one; give sink": "no number", "are too different": "a ratio",
    "it is %g m long": "a range of the file's size", "user says %g grousers": "a range",
    # needs what no test here has, or is told elsewhere
    "give an end_time of": "cli/notes.py", "are too many sizes": "a range", "path samples are due in one step": "cli/contract", "give smaller sizes": "a machine with little memory", "the view needs %zu tiles": "needs a GL drive of many tiles",
    "touches up to %zu tiles at once": "tests/world", "pages must be resident at once": "a caller's error", "each step loads tiles again": "limits",
    "move the path%s, or import": "cli/nodata", "no ground under it": "above", "are too coarse to be divided": "levels no drive makes",
    "try it by hand on": "needs ffmpeg that fails", "try another GL driver": "a driver that fails", "report this, or try another": "a driver that fails",
    "give less load, or": "no number", "give a soil in soil.classes": "cli/soil_map", "which is %s than soils have": "cli/soil_rasters", "replace all that model": "scene/soils.c",
    "reads a soil's numbers by class alone": "scene/refuse.c", "name a file that can be read": "a path", "use that spacing": "commands",
    "it is a whole store, not an overlay": "cli/overlay", "that relief": "cli/relief", "for the ground as it was imported": "commands", "undoes that": "commands",
    "is not there; put it into": "PROJ's grids are not in the tests", "taken as heights over the sphere": "cli/planets", "is used": "a note of what was done",
    "they are taken as metres": "cli/rasters", "that is used, not": "a note of what was done", "does not lie within them": "cli/mixed", "not understood": "cli/placement",
    "is nowhere in": "cli/rasters", "4.2 GB is the most": "a terrain of 4 GB", "would leave out what changed": "cli/tiles", "has a width and a height in it": "cli/tile_windows", "need more steps than a tile has": "cli/tile_windows", "is for --tiles": "cli/globe", "resample it to": "cli/insets",
    "so all would be unknown": "cli/mobility", "its cells are %g m wide": "cli/mobility", "leave %s out and give metres": "cli/contract", "inside as": "cli/contract",
    "is no result of this study": "cli/study", "these come from resampling": "any finer spacing will do", "n would be": "no number to type",
    "names no body of the model": "cli/cameras", "no post lies in --window": "windows", "pictures take": "a progress line", "computed together": "a table",
    "goes on with its imagery": "cli/imagery", "no imagery lies on the terrain": "cli/imagery", "has 8 bits a band": "cli/imagery", "imagery is part of the terrain": "cli/imagery",
    "put some into it: furrow import --imagery": "cli/imagery", "does not take quality": "a range",
    "its pixels are %.10g m apart": "cli/edit", "inset      ": "windows", "<svg": "a picture", "is no number of slots;": "a range",
}


def suggestions():
    """Each literal of a message whose advice has a printf conversion beside a word that tells to write something."""
    for path in sorted([*(ROOT / "src").rglob("*.c"), *(ROOT / "tools").rglob("*.c")]):
        text = path.read_text()
        for found in re.finditer(r'((?:"(?:[^"\\\n]|\\.)*"\s*)+)', text):
            literal = "".join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', found[1]))
            advice = literal.split(";", 1)[1] if ";" in literal else ""
            if re.search(r"\b(give|use|try|set|take|say|name|raise|lower|shorten|furrow|--[a-z]+)\b[^;]*%[-+ #0-9.*]*l*[gdfuxs]", advice, re.I):
                yield f"{path.relative_to(ROOT)}:{text.count(chr(10), 0, found.start()) + 1}", literal


class Advice(FurrowTest):
    def setUp(self):
        super().setUp()
        self.scene(SCENE)

    def explain(self, settings, store="world.furrow", scene="scene.yaml"):
        """All notes, or the refusal."""
        sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        result = self.furrow("explain", scene, "--store", store, "--json", *sets)
        return "\n".join(json.loads(result.stdout)["notes"]) if result.returncode == 0 else result.stderr

    def followed(self, settings, pattern, then, **options):
        told = self.explain(settings, **options)
        found = re.search(pattern, told)
        self.assertIsNotNone(found, f"{settings}: {pattern}: {told}")
        for typed in then:
            typed = {key: value.format(*found.groups()) for key, value in typed.items()}
            again = self.explain({**settings, **typed}, **options)
            self.assertIsNone(re.search(pattern, again), f"{found[0]}: {typed}: {again}")

    def test_what_is_said_of_a_scene_works(self):
        # Spacings of which no level is a short decimal: 0.9765625 / 2^k needs up to 20 digits, 1.0477 / 16 is just above half a grouser's pitch.
        self.synth(spacing=0.9765625, posts="65x65", kind="plain", relief=0)
        for settings, pattern, then, _ in SCENES:
            if pattern is not None:
                self.followed(settings, pattern, then)
        self.synth("odd.furrow", spacing=1.35838, posts="65x65", kind="plain", relief=0)
        # Half a pitch is 0.0424538: as 0.0425 it would be the level of 0.042449 m or a coarser one.
        for grousers in (24, 31, 37, 53):
            self.followed({"spacing": 0.5, "objects.a.shape.wheel.grousers": grousers}, rf"a spacing of at most {NUMBER}", [{"spacing": "{0}"}], store="odd.furrow")

    def test_a_printed_spacing_is_the_level_that_it_was_printed_for(self):
        for spacing in (1, 0.78125, 0.3, 2 / 3, 30.5):
            self.synth("odd.furrow", spacing=repr(spacing), posts="33x33", kind="plain", relief=0)
            for level in (0, 3, 6):
                exact = spacing / 2 ** level
                for digits in (6, 7, 9, 17):
                    asked = f"{exact:.{digits}g}"
                    self.assertEqual(self.json("explain", "scene.yaml", "--store", "odd.furrow", "--set", f"spacing={asked}",
                                               "--set", "objects.a.path.points=[[1, 1]]", "--set", "objects.a.shape={sphere: {radius: 0.1}}")["spacing"], exact, asked)

    def test_commands_that_are_told_work_in_a_shell(self):
        """Of a store in a folder whose name a shell would cut."""
        folder = self.folder / "it's a $HOME of mine"
        folder.mkdir()
        self.synth(folder / "w.furrow", spacing=0.9765625, posts="65x65", kind="plain", relief=0)
        drive = ("drive", "scene.yaml", "--store", folder / "w.furrow", "-o", "out", "--steps", "5", "--set", "redistribute={model: box}")
        # The wheel passes between the posts of the first drive. To go back and forth over drives without a rut leaves a store that can be read.
        self.ok(*drive, "--keep-history", "--set", "objects.a.path.points=[[20, 20], [20.1, 20]]", "--set", "objects.a.shape={sphere: {radius: 0.02}}")
        for revision in (0, 2):
            self.ok("restore", folder / "w.furrow", revision)
        self.assertTrue(self.json("verify", folder / "w.furrow")["ok"])
        self.ok(*drive, "--keep-history", "--steps", "40")
        told = self.told(3, self.furrow(*drive, "--set", "spacing=0.1"))
        asked = re.search(rf"deformed at a spacing of {NUMBER} m", told)[1]
        self.ok(*drive, "--keep-history", "--set", f"spacing={asked}", "--steps", "40")
        undo = re.search(r"; (furrow restore .*) undoes that", self.ok("restore", folder / "w.furrow", "1"))[1]
        self.shell(undo)
        note = self.furrow(*drive).stderr
        self.shell(re.search(r"run (furrow reset .*)", note)[1])
        self.assertEqual(self.json("info", folder / "w.furrow")["tiles"]["offset"], 0)

    def shell(self, command):
        done = subprocess.run(["sh", "-c", command.replace("furrow", FURROW, 1)], cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, f"{command}: {done.stderr}")

    def test_windows_that_are_told_hold_what_they_are_told_for(self):
        self.synth(spacing=1 / 3, posts="200x170", kind="plain", relief=0)
        self.ok("drive", "scene.yaml", "--store", "world.furrow", "-o", "out", "--steps", "40", "--set", "redistribute={model: box}", "--set", "spacing=0.084")
        west, south, east, north = map(float, re.search(r"ruts +within ([^ ]+)", self.ok("info", "world.furrow"))[1].split(","))
        self.assertLessEqual(west, 19.5)
        note = self.furrow("export", "world.furrow", "-o", "a.tif").stderr
        level, window = re.search(r"--level (\S+) --window (\S+)", note).groups()
        self.ok("export", "world.furrow", "-o", "b.tif", "--level", level, "--window", window)
        self.assertIn("give at most 0", self.told(3, self.furrow("export", "world.furrow", "-o", "c.tif", "--level", "9")))
        whole = re.search(r"inside (\S+)", self.told(3, self.furrow("export", "world.furrow", "-o", "c.tif", "--window", "-9,-9,-8,-8")))[1]
        self.ok("export", "world.furrow", "-o", "c.raw", "--layer", "base", "--window", whole)
        self.assertEqual((self.folder / "c.raw").stat().st_size, 200 * 170 * 2, "the rim is in")
        side, window = re.search(r"within is (\d+) x \d+: --window (\S+)", self.furrow("export", "world.furrow", "-o", "d.raw", "--layer", "base").stderr).groups()
        self.ok("export", "world.furrow", "-o", "d.raw", "--layer", "base", "--window", window)
        self.assertEqual((self.folder / "d.raw").stat().st_size, int(side) ** 2 * 2)

    def test_what_is_said_of_vehicles_works(self):
        self.synth(posts="65x65", kind="plain", relief=0)
        (self.folder / "one_wheel.xml").write_text((ROOT / "tests/vehicle/one_wheel.xml").read_text())
        self.scene(VEHICLE, "car.yaml")
        told = self.explain({"time_step": 1}, scene="car.yaml")
        if "MuJoCo" in told:
            self.skipTest(told)
        self.followed({"time_step": 1}, rf"time_step: .* longer than {NUMBER} s", [{"time_step": "{0}"}], scene="car.yaml")
        (self.folder / "one_wheel.xml").write_text((ROOT / "tests/vehicle/one_wheel.xml").read_text().replace("<mujoco>", '<mujoco><option gravity="0 0 -1.6249871"/>', 1)
                                                   .replace('<mujoco model="one wheel">', '<mujoco model="one wheel"><option gravity="0 0 -1.6249871"/>', 1))
        note = self.explain({}, scene="car.yaml")
        if "does not count; give gravity" in note:
            self.followed({}, rf"does not count; give gravity: {NUMBER}", [{"gravity": "{0}"}], scene="car.yaml")

    def test_every_message_that_suggests_something_is_followed(self):
        known = [row[3] for row in SCENES if row[3] is not None] + list(ELSEWHERE)
        messages = list(suggestions())
        self.assertGreater(len(messages), 60)
        self.assertEqual([message for message in messages if not any(part in message[1] for part in known)], [])


if __name__ == "__main__":
    main()
