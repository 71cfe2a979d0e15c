"""A hundred plausible mistakes: each gets one line that says what, why and what to do, the right exit status, and loses nothing.

`mistakes.py --list` prints what each of them is answered, for whoever judges whether the next step is clear.
"""
import contextlib
import hashlib
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

from furrow_test import FURROW, FurrowTest, write_png16

USAGE, INPUT, FAILED = 2, 3, 1

SCENE = """scene: 1
time_step: 0.05
end_time: 1
spacing: 0.25
soil: {name: dry_sand}
redistribute: {model: scm}
objects:
  - name: wheel
    shape: {wheel: {radius: 0.25, width: 0.2}}
    path: {points: [[20, 20], [24, 20]], speed: 4}
    load: 500
output: {forces: 10}
"""
STUDY = """study: 1
scene: scene.yaml
store: world.furrow
grid: {objects.wheel.load: [300, 500]}
results: {sinkage: {run: objects.wheel.sinkage}}
"""
VEHICLE = """scene: 1
time_step: 0.002
end_time: 1
spacing: 0.25
soil: {name: dry_sand}
redistribute: {model: scm}
vehicles:
  - name: car
    model: rover.xml
    start: {at: [20, 20]}
    driver: {path: {points: [[20, 20], [24, 20]], speed: 0.1}, steer: [steer_*], drive: [drive_*]}
"""


def edit(text, old, new):
    assert old in text, old
    return text.replace(old, new)


def in_scene(old, new, text=SCENE):
    """A scene with a mistake."""
    return {"bad.yaml": edit(text, old, new)}


DRIVE = ("drive", "bad.yaml", "--store", "world.furrow", "--overlay", "new.furrow", "-o", "out")
PLAIN = ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "new.furrow", "-o", "out")
STUDIED = ("study", "bad.yaml", "-o", "out")

# (what was done, exit status, command, files that are written before, what the answer must name)
MISTAKES = [
    # --- the command line ---
    ("a subcommand that there is not", USAGE, ("run", "scene.yaml"), {}, "run"),
    ("a letter left out of a subcommand", USAGE, ("exprt", "world.furrow"), {}, "exprt"),
    ("no subcommand's argument", USAGE, ("drive",), {}, "-o"),
    ("no folder for the results", USAGE, ("drive", "scene.yaml", "--store", "world.furrow"), {}, "-o"),
    ("an unknown option", USAGE, ("drive", "scene.yaml", "--speed", "3", "-o", "out"), {}, "--speed"),
    ("an option without its value", USAGE, ("import", "dem.png", "-o"), {}, "-o"),
    ("a number that is none", USAGE, ("synth", "-o", "s.furrow", "--posts", "65x65", "--spacing", "one"), {}, "one"),
    ("posts as one number", USAGE, ("synth", "-o", "s.furrow", "--posts", "abc", "--spacing", "1"), {}, "abc"),
    ("no spacing", USAGE, ("synth", "-o", "s.furrow", "--posts", "65x65"), {}, "--spacing"),
    ("a spacing of 0", USAGE, ("synth", "-o", "s.furrow", "--posts", "65x65", "--spacing", "0"), {}, "spacing"),
    ("a kind of terrain that there is not", USAGE, ("synth", "-o", "s.furrow", "--posts", "65x65", "--spacing", "1", "--kind", "flat"), {}, "flat"),
    ("a comma between x and y", USAGE, ("query", "world.furrow", "12,30"), {}, "12,30"),
    ("x without y", USAGE, ("query", "world.furrow", "12"), {}, "12"),
    ("longitude and latitude on local metres", INPUT, ("query", "world.furrow", "15.02", "45.17", "--srs", "EPSG:4326"), {}, "--srs"),
    ("a layer that there is not", USAGE, ("export", "world.furrow", "-o", "x.tif", "--layer", "height"), {}, "height"),
    ("an export to a format that there is not", USAGE, ("export", "world.furrow", "-o", "x.xyz"), {}, "x.xyz"),
    ("a window off the terrain", INPUT, ("export", "world.furrow", "-o", "x.png", "--window", "900,900,950,950"), {}, "window"),
    ("a window with its corners swapped", INPUT, ("export", "world.furrow", "-o", "x.png", "--window", "40,40,10,10"), {}, "window"),
    ("a window of three numbers", USAGE, ("export", "world.furrow", "-o", "x.png", "--window", "40,40,10"), {}, "window"),
    ("an export over itself", USAGE, ("export", "world.furrow", "-o", "world.furrow"), {}, "world.furrow"),
    ("a setting without =", USAGE, (*PLAIN, "--set", "end_time"), {}, "end_time"),
    ("a setting of a key that there is not", INPUT, (*PLAIN, "--set", "endtime=3"), {}, "endtime"),
    ("a setting of an object that there is not", INPUT, (*PLAIN, "--set", "objects.whel.load=3"), {}, "whel"),
    ("steps below 1", USAGE, (*PLAIN, "--steps", "0"), {}, "--steps"),
    ("a revision that was not kept", INPUT, ("restore", "world.furrow", "5"), {}, "5"),
    # --- files ---
    ("a scene that there is not", INPUT, ("drive", "scen.yaml", "-o", "out"), {}, "scen.yaml"),
    ("a store that there is not", INPUT, ("drive", "scene.yaml", "--store", "wrld.furrow", "-o", "out"), {}, "wrld.furrow"),
    ("a scene without a store", INPUT, ("drive", "scene.yaml", "-o", "out"), {}, "--store"),
    ("a scene where a store is wanted", INPUT, ("info", "scene.yaml"), {}, "scene.yaml"),
    ("a store where a scene is wanted", INPUT, ("explain", "world.furrow"), {}, "world.furrow"),
    ("a picture where a scene is wanted", INPUT, ("explain", "dem.png"), {}, "dem.png"),
    ("a folder where a store is wanted", INPUT, ("info", "."), {}, "."),
    ("an empty file as a store", INPUT, ("info", "empty.furrow"), {"empty.furrow": ""}, "empty.furrow"),
    ("a text file as a store", INPUT, ("info", "text.furrow"), {"text.furrow": "hello, I am no store\n" * 99}, "text.furrow"),
    ("half a store", INPUT, ("verify", "half.furrow"), {"half.furrow": "half of world.furrow"}, "half.furrow"),
    ("a store that is there already", INPUT, ("import", "dem.png", "-o", "world.furrow", "--spacing", "1", "--height-range", "0,10"), {}, "world.furrow"),
    ("a synthetic terrain over a store", INPUT, ("synth", "-o", "world.furrow", "--posts", "65x65", "--spacing", "1"), {}, "world.furrow"),
    ("a folder that there is not, to write in", INPUT, ("synth", "-o", "no/such/s.furrow", "--posts", "65x65", "--spacing", "1"), {}, "no/such"),
    ("a map in a folder that there is not, told before the drive", INPUT, (*PLAIN, "--map", "no/such/way.pdf"), {}, "the folder no/such is not there"),
    ("a map that is a folder", INPUT, (*PLAIN, "--map", "way.png"), {"way.png/file": "x"}, "way.png: Is a directory"),
    ("a page in a folder that there is not", FAILED, ("map", "world.furrow", "-o", "no/such/m.png"), {}, "the folder no/such is not there"),
    ("results in a folder that there is not", FAILED, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "new.furrow", "-o", "no/such/out"), {},
     "the folder that it is to be in is not there"),
    ("a folder where a new store is wanted", INPUT, ("import", "dem.png", "-o", "stores", "--spacing", "1", "--height-range", "0,10"), {"stores/file": "x"}, "it is a folder"),
    ("a folder as an overlay", INPUT, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "ruts", "-o", "out"), {"ruts/file": "x"},
     "it is a folder, not an overlay; name an overlay, or a file that is not there yet"),
    ("a text file as an overlay", INPUT, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "text.txt", "-o", "out"), {"text.txt": "hello, I am no store\n"},
     "it is another file, not an overlay; name an overlay, or a file that is not there yet"),
    ("a variable of the shell that is not set", USAGE, ("drive", "scene.yaml", "--store", "", "-o", "out"), {}, "--store is empty"),
    ("an empty name of the results' folder", USAGE, ("drive", "scene.yaml", "--store", "world.furrow", "-o", ""), {}, "-o is empty"),
    ("an empty argument", USAGE, ("info", ""), {}, "an argument is empty"),
    ("a key without the mapping that it is in", INPUT, (*PLAIN, "--set", "forces=10"), {}, "did you mean output.forces?"),
    ("a file where a folder is wanted", FAILED, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "new.furrow", "-o", "dem.png"), {}, "dem.png"),
    ("an overlay that is a store of its own", INPUT, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "other.furrow", "-o", "out"), {}, "other.furrow"),
    ("an overlay of another store", INPUT, ("drive", "scene.yaml", "--store", "other.furrow", "--overlay", "ruts.furrow", "-o", "out"), {}, "ruts.furrow"),
    ("an overlay that is the store", INPUT, ("drive", "scene.yaml", "--store", "world.furrow", "--overlay", "world.furrow", "-o", "out"), {}, "world.furrow"),
    ("an overlay whose store has moved", INPUT, ("info", "lost/ruts.furrow"), {"lost/ruts.furrow": "ruts.furrow without its base"}, "relink"),
    ("a merge of a store", INPUT, ("merge", "world.furrow", "ruts.furrow", "-o", "m.furrow"), {}, "world.furrow"),
    ("a relink to the wrong store", INPUT, ("relink", "ruts.furrow", "other.furrow"), {}, "other.furrow"),
    ("a report of a folder without a drive", INPUT, ("report", ".", "-o", "r.html"), {}, "run.json"),
    ("a report of a file", INPUT, ("report", "dem.png", "-o", "r.html"), {}, "dem.png"),
    ("a trace that there is not", INPUT, ("cache-sim", "trace.bin"), {}, "trace.bin"),
    ("a scene as a trace", INPUT, ("cache-sim", "scene.yaml"), {}, "scene.yaml"),
    # --- elevation data ---
    ("a source that there is not", INPUT, ("import", "dme.tif", "-o", "s.furrow"), {}, "dme.tif"),
    ("a text file as a source", INPUT, ("import", "notes.tif", "-o", "s.furrow"), {"notes.tif": "some notes\n"}, "notes.tif"),
    ("heights of a PNG swapped", USAGE, ("import", "dem.png", "-o", "s.furrow", "--spacing", "1", "--height-range", "10,0"), {}, "10, 0"),
    ("an error below 0", USAGE, ("import", "dem.png", "-o", "s.furrow", "--spacing", "1", "--height-range", "0,10", "--max-error", "-1"), {}, "max-error"),
    ("no output", USAGE, ("import", "dem.png"), {}, "-o"),
    ("a cut PNG", INPUT, ("import", "cut.png", "-o", "s.furrow", "--spacing", "1", "--height-range", "0,10"), {"cut.png": "half of dem.png"}, "cut.png"),
    ("an inset that there is not", INPUT, ("import", "dem.png", "-o", "s.furrow", "--spacing", "1", "--height-range", "0,10", "--inset", "none.tif"), {}, "none.tif"),
    # --- scenes: YAML ---
    ("a tab in YAML", INPUT, DRIVE, in_scene("time_step: 0.05", "\ttime_step: 0.05"), "bad.yaml:2"),
    ("a bracket not closed", INPUT, DRIVE, in_scene("[24, 20]], speed", "[24, 20], speed"), "bad.yaml"),
    ("an indent that is off", INPUT, DRIVE, in_scene("    shape:", "   shape:"), "bad.yaml"),
    ("a colon without a blank", INPUT, DRIVE, in_scene("end_time: 1", "end_time:1"), "bad.yaml"),
    ("an empty scene", INPUT, DRIVE, {"bad.yaml": ""}, "bad.yaml"),
    ("a key twice", INPUT, DRIVE, in_scene("end_time: 1\n", "end_time: 1\nend_time: 2\n"), "end_time"),
    ("no version", INPUT, DRIVE, in_scene("scene: 1\n", ""), "scene"),
    ("a version to come", INPUT, DRIVE, in_scene("scene: 1", "scene: 2"), "scene"),
    ("no end", INPUT, DRIVE, in_scene("end_time: 1\n", ""), "end_time"),
    ("an unknown key", INPUT, DRIVE, in_scene("spacing:", "resolution:"), "resolution"),
    ("a number with its unit", INPUT, DRIVE, in_scene("end_time: 1", "end_time: 1 s"), "1 s"),
    ("a comma as decimal point", INPUT, DRIVE, in_scene("spacing: 0.25", "spacing: 0,25"), "0,25"),
    ("a time step of 0", INPUT, DRIVE, in_scene("time_step: 0.05", "time_step: 0"), "time_step"),
    ("a negative spacing", INPUT, DRIVE, in_scene("spacing: 0.25", "spacing: -0.25"), "spacing"),
    ("objects as a mapping", INPUT, DRIVE, in_scene("objects:\n  - name: wheel\n    shape", "objects:\n  wheel:\n    shape"), "objects"),
    # --- scenes: objects ---
    ("a shape that there is not", INPUT, DRIVE, in_scene("{wheel: {radius: 0.25, width: 0.2}}", "{tyre: {radius: 0.25, width: 0.2}}"), "tyre"),
    ("a diameter", INPUT, DRIVE, in_scene("radius: 0.25", "diameter: 0.5"), "diameter"),
    ("a wheel in millimetres", INPUT, DRIVE, in_scene("radius: 0.25, width: 0.2", "radius: 250000, width: 200"), "radius"),
    ("a wheel smaller than the spacing allows", INPUT, DRIVE, in_scene("radius: 0.25, width: 0.2", "radius: 0.0001, width: 0.2"), "radius"),
    ("a path of one number", INPUT, DRIVE, in_scene("[[20, 20], [24, 20]]", "[20, 24]"), "points"),
    ("a path in three dimensions", INPUT, DRIVE, in_scene("[[20, 20], [24, 20]]", "[[20, 20, 5], [24, 20, 5]]"), "points"),
    ("no speed", INPUT, DRIVE, in_scene(", speed: 4", ""), "speed"),
    ("speed and file", INPUT, DRIVE, {**in_scene("points: [[20, 20], [24, 20]]", "file: way.csv"), "way.csv": "t,x,y\n0,20,20\n1,24,20\n"}, "speed"),
    ("a file of poses that there is not", INPUT, DRIVE, in_scene("{points: [[20, 20], [24, 20]], speed: 4}", "{file: way.csv}"), "way.csv"),
    ("poses with semicolons", INPUT, DRIVE, {**in_scene("{points: [[20, 20], [24, 20]], speed: 4}", "{file: way.csv}"), "way.csv": "t;x;y\n0;20;20\n"}, "way.csv:1"),
    ("poses with x and t swapped", INPUT, DRIVE, {**in_scene("{points: [[20, 20], [24, 20]], speed: 4}", "{file: way.csv}"),
                                                  "way.csv": "x,y,t\n20,20,0\n24,20,1\n"}, "way.csv:1"),
    ("poses whose time goes back", INPUT, DRIVE, {**in_scene("{points: [[20, 20], [24, 20]], speed: 4}", "{file: way.csv}"),
                                                  "way.csv": "t,x,y\n0,20,20\n2,22,20\n1,24,20\n"}, "way.csv:4"),
    ("a path in longitude and latitude", FAILED, DRIVE, in_scene("[[20, 20], [24, 20]]", "[[-500020, 4500020], [-500024, 4500020]]"), "wheel"),
    ("a path that leaves the terrain", FAILED, DRIVE, in_scene("[[20, 20], [24, 20]]", "[[62, 20], [70, 20]]"), "wheel"),
    ("a follower of nobody", INPUT, DRIVE, in_scene("{points: [[20, 20], [24, 20]], speed: 4}", "{relative_to: truck}"), "truck"),
    ("load and sink", INPUT, DRIVE, in_scene("load: 500", "load: 500\n    sink: 0.1"), "load"),
    ("a load under a model without forces", INPUT, DRIVE, in_scene("model: scm", "model: box"), "scm"),
    ("a negative load", INPUT, DRIVE, in_scene("load: 500", "load: -500"), "load"),
    ("a slip of 1", INPUT, DRIVE, in_scene("load: 500", "load: 500\n    slip: 1"), "slip"),
    ("a slip in percent", INPUT, DRIVE, in_scene("load: 500", "load: 500\n    slip: 20"), "slip"),
    ("slip of a ball", INPUT, DRIVE, in_scene("{wheel: {radius: 0.25, width: 0.2}}", "{sphere: {radius: 0.25}}\n    slip: 0.1"), "slip"),
    ("two objects with one name", INPUT, DRIVE, in_scene("output:", "  - {name: wheel, shape: {sphere: {radius: 1}}, path: {points: [[30, 30]], speed: 1}}\noutput:"), "wheel"),
    ("a name with a blank", INPUT, DRIVE, in_scene("name: wheel", "name: left wheel"), "left wheel"),
    ("a mesh that there is not", INPUT, DRIVE, in_scene("{wheel: {radius: 0.25, width: 0.2}}", "{mesh: {file: foot.obj}}"), "foot.obj"),
    ("a mesh that is none", INPUT, DRIVE, {**in_scene("{wheel: {radius: 0.25, width: 0.2}}", "{mesh: {file: foot.obj}}"), "foot.obj": "hello\n"}, "foot.obj"),
    # --- scenes: soil ---
    ("a soil that there is not", INPUT, DRIVE, in_scene("dry_sand", "drysand"), "drysand"),
    ("a model that there is not", INPUT, DRIVE, in_scene("model: scm", "model: bekker"), "bekker"),
    ("cohesion under another name", INPUT, DRIVE, in_scene("{name: dry_sand}", "{name: dry_sand, c: 1000}"), "soil.c"),
    ("an angle above 90 degrees", INPUT, DRIVE, in_scene("{name: dry_sand}", "{name: dry_sand, friction_angle: 280}"), "friction_angle"),
    ("a soil that bears nothing", INPUT, DRIVE, in_scene("{name: dry_sand}", "{name: dry_sand, bekker_kc: 0, bekker_kphi: 0}"), "bekker"),
    ("a map of the soil that there is not", INPUT, DRIVE, in_scene("{name: dry_sand}", "{map: soil.tif, classes: {1: dry_sand}, default: dry_sand}"), "soil.tif"),
    ("a map of the soil without classes", INPUT, DRIVE, in_scene("{name: dry_sand}", "{map: dem.png}"), "classes"),
    # --- scenes: the rest ---
    ("a camera after an object that there is not", INPUT, DRIVE, in_scene("output:", "view: {camera: {chase: car}}\noutput:"), "car"),
    ("an effect that there is not", INPUT, DRIVE, in_scene("output:", "view: {camera: {chase: wheel}, effects: [shadows]}\noutput:"), "shadows"),
    ("a picture too large", INPUT, DRIVE, in_scene("output:", "view: {camera: {chase: wheel}, size: [99999, 20]}\noutput:"), "size"),
    ("coordinates in degrees over a store without a place", INPUT, DRIVE, in_scene("spacing:", "coordinates: EPSG:4326\nspacing:"), "EPSG:4326"),
    ("too little memory", INPUT, DRIVE, in_scene("output:", "cache: {memory: 1 MB}\noutput:"), "memory"),
    ("memory without a unit", INPUT, DRIVE, in_scene("output:", "cache: {memory: 512}\noutput:"), "512"),
    ("slots and memory", INPUT, DRIVE, in_scene("output:", "cache: {slots: 16, memory: 512 MB}\noutput:"), "slots"),
    # --- vehicles ---
    ("a model that there is not", INPUT, DRIVE, in_scene("rover.xml", "rovr.xml", VEHICLE), "rovr.xml"),
    ("a model that is none", INPUT, DRIVE, {**in_scene("rover.xml", "text.xml", VEHICLE), "text.xml": "<robot"}, "text.xml"),
    ("geoms that there are not", INPUT, DRIVE, in_scene("    driver", "    soil: [tyre_*]\n    driver", VEHICLE), "geom"),
    ("actuators that there are not", INPUT, DRIVE, in_scene("drive: [drive_*]", "drive: [motor_*]", VEHICLE), "motor_*"),
    ("a vehicle under a model without forces", INPUT, DRIVE, in_scene("model: scm", "model: box", VEHICLE), "vehicles"),
    ("a vehicle off the terrain", INPUT, DRIVE, in_scene("at: [20, 20]", "at: [500, 20]", VEHICLE), "car"),
    # --- studies ---
    ("a study that is a scene", INPUT, ("study", "scene.yaml", "-o", "out"), {}, "scene.yaml"),
    ("a study of a scene that there is not", INPUT, STUDIED, {"bad.yaml": edit(STUDY, "scene.yaml", "scen.yaml")}, "scen.yaml"),
    ("a parameter that there is not", INPUT, STUDIED, {"bad.yaml": edit(STUDY, "objects.wheel.load", "objects.wheel.lode")}, "lode"),
    ("a value that a scene refuses", INPUT, STUDIED, {"bad.yaml": edit(STUDY, "[300, 500]", "[300, -500]")}, "-500"),
    ("two designs", INPUT, STUDIED, {"bad.yaml": STUDY + "list: [{objects.wheel.load: 3}]\n"}, "list"),
    ("a plot of a result that there is not", INPUT, STUDIED, {"bad.yaml": STUDY + "plots: [{x: objects.wheel.load, y: drawbar}]\n"}, "sinkage"),
]


class Place:
    """A folder with sound files, in which mistakes are made."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        for name in ("world", "other"):
            self.run("synth", "-o", f"{name}.furrow", "--posts", "65x65", "--spacing", "1", "--kind", "plain", "--relief", "2" if name == "world" else "3")
        self.run("branch", "world.furrow", "ruts.furrow")
        write_png16(self.folder / "dem.png", 65, 65, lambda x, y: 30000 + 100 * x + y)
        (self.folder / "scene.yaml").write_text(SCENE)
        shutil.copy(pathlib.Path(__file__).parents[2] / "tools/scenes/vehicles/rover.xml", self.folder)
        self.sound = {path.name for path in self.folder.iterdir()}

    def run(self, *arguments):
        return subprocess.run([FURROW, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=280)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        if text.startswith("half of "):
            data = (self.folder / text.removeprefix("half of ")).read_bytes()
            path.write_bytes(data[:len(data) // 2])
        elif text.endswith(" without its base"):
            shutil.copy(self.folder / text.removesuffix(" without its base"), path)
        else:
            path.write_text(text)

    def hashes(self):
        return {name: hashlib.sha256(self.content(name)).hexdigest() for name in self.sound}

    def content(self, name):
        """A file's bytes; a store's rows, since opening it may tidy the file."""
        path = self.folder / name
        if path.suffix != ".furrow":
            return path.read_bytes()
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as store:
            return "\n".join(store.iterdump()).encode()

    def make(self, mistake):
        """Makes the mistake, and takes away what it left."""
        _, _, command, files, _ = mistake
        for name, text in files.items():
            self.write(name, text)
        result = self.run(*command)
        left = {path.name for path in self.folder.iterdir()} - self.sound - {name.split("/")[0] for name in files}
        for name in left | {name.split("/")[0] for name in files}:
            path = self.folder / name
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        return result, left


class Mistakes(FurrowTest):
    def test_each_is_told(self):
        self.assertGreaterEqual(len(MISTAKES), 100)
        place = Place(self.folder)
        before = place.hashes()
        for mistake in MISTAKES:
            title, status, command, _, named = mistake
            with self.subTest(title):
                result, left = place.make(mistake)
                if result.returncode == 4 or "this build" in result.stderr or "built without" in result.stderr:
                    continue
                error = self.told(status, result)
                self.assertIn(named, error)
                # A drive that had begun tells what it did; all else leaves nothing.
                self.assertLessEqual({name for name in left if not name.startswith("new.furrow")}, {"out"} if command[0] in ("drive", "study") else set())
                self.assertEqual(place.hashes(), before)


def list_them():
    with tempfile.TemporaryDirectory() as folder:
        place = Place(folder)
        for i, mistake in enumerate(MISTAKES, 1):
            result, left = place.make(mistake)
            print(f"{i}. {mistake[0]}\n   $ furrow {' '.join(mistake[2])}")
            for name, text in mistake[3].items():
                if name == "bad.yaml":
                    base = VEHICLE if "vehicles:" in text else STUDY if "study:" in text else SCENE
                    changed = [line for line in text.splitlines() if line not in base.splitlines()]
                    print("   bad.yaml: " + " / ".join(changed if changed else ["(lines left out)"]))
                elif len(text) < 99:
                    print(f"   {name}: {text!r}")
            print("   " + (result.stderr.strip() or "(nothing)").replace(folder, "").replace("\n", "\n   ") + f"\n   [exit status {result.returncode}]"
                  + (f" left: {', '.join(sorted(left))}" if left else "") + "\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        list_them()
    else:
        unittest.main(verbosity=2)
