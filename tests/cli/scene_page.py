"""src/scene/SCENE.md: has every key the checker takes, with its type, range, unit and default, and none that it does not take.

What the checker takes is asked of it: an unknown key is answered with those there are, a value of a wrong type with what is allowed.
"""
import json
import pathlib
import re
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import rasters  # noqa: E402
from furrow_test import FurrowTest, has_gdal, long, main, write_png16  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
PAGE = ROOT / "src" / "scene" / "SCENE.md"
SOIL = ROOT / "src" / "deform" / "SOIL.md"
SOILS = ROOT / "docs" / "SOILS.md"
DRIVES = ROOT / "docs" / "DRIVES.md"
NUMBERS = ("number", "whole number")
COLUMNS = ["key", "type", "unit", "range", "default", "what it does", "effect"]

WHEEL = {"name": "a", "shape": {"wheel": {"radius": 0.5, "width": 0.4}}, "path": {"points": [[20, 20], [30, 20]], "speed": 5}}
NUMBERED = {"name": "dry_sand", "bekker_kc": 990, "bekker_kphi": 1528430, "bekker_n": 1.1, "cohesion": 1040, "friction_angle": 28,
            "janosi_shear": 0.02, "elastic_stiffness": 4e7, "damping": 3e4, "density": 1631, "unit_weight": 16000, "face_strength": 1e6, "face_cohesion": 500, "repose": 28, "theta_in": 45,
            "theta_out": 25, "theta_stop": 45, "roughness": 0.2, "compression": 0.3}


def scene(*objects, **keys):
    return {"scene": 1, "end_time": 2, "objects": list(objects), **keys}


def wheel(**keys):
    return {**WHEEL, **keys}


def view(camera, **keys):
    return {"camera": camera, **keys}


def vehicle(**keys):
    return {"name": "v", "model": "one_wheel.xml", "start": {"at": [5, 5]}, **keys}


# Scenes that are sound; each key is in at least one, and without what goes with it alone.
SAMPLES = [
    scene(WHEEL, store="none.furrow", time_step=0.1, gravity=9.81, spacing=0.5, coordinates="local", attributes=["disturbance"],
          outside="skip", cache={"slots": 64, "loaders": 1, "prefetch": 1}, soil=NUMBERED, redistribute={"model": "box", "radius": 2,
                                                                                                     "repetitions": 2},
          view=view({"chase": "a", "back": 9, "up": 4}, size=[64, 48], effects=["sky"], images=5, samples=2, pixel_error=2, body="mars",
                    sun={"azimuth": 90, "height": 20, "colour": [1, 1, 1]})),
    scene(wheel(shape={"wheel": {"radius": 0.5, "width": 0.4, "grousers": 12}}, sink=0.1), wheel(name="b"),
          view=view({"overhead": {"over": "b", "height": 9}})),
    scene(wheel(shape={"wheel": {"radius": 0.5, "width": 0.4, "grousers": 9, "grouser_height": 0.1, "grouser_thickness": 0.02}}, load=500, slip=0.1,
                interface={"friction_angle": 20, "adhesion": 300}),
          soil={**NUMBERED, "rasters": {key: "classes.png" for key in ("bekker_kc", "bekker_kphi", "bekker_n", "cohesion")}},
          redistribute={"model": "scm", "depth": 1, "bulldozing": 0.4, "slip_sinkage": 1.2, "loosening": 0.5, "hardening": 0.2, "iterations": 2, "interval": 0.1, "tolerance": 0.1, "normals": "ground",
                                       "undisturbed": "stable"}, output={"forces": 5}),
    scene(WHEEL, soil={"name": "lunar", "rasters": {key: "classes.png" for key in ("friction_angle", "janosi_shear", "elastic_stiffness")}},
          redistribute={"model": "scm", "faces": "on", "inertia": 0.5}, output={"forces": 5}),
    scene(wheel(shape={"sphere": {"radius": 1}}, path={"points": [[20, 20], [30, 20]], "speed": 5, "loop": True}),
          soil={"name": "mud"}, redistribute={"model": "sumner"}, compute="cpu"),
    scene(wheel(shape={"box": {"size": [1, 1, 1]}}, path={"file": "poses.csv", "rotate": 30, "offset": [1, 2]}), redistribute={"model": "slippage"},
          soil={"map": "classes.png", "classes": [{"value": 1, "name": "lunar"}], "default": {"name": "dry_sand"}}),
    scene(WHEEL, redistribute={"model": "scm"}, spacing=0.25, soil={"map": "classes.png", "classes": [{"value": 1, "name": "lunar"}], "default": {"name": "dry_sand"}},
          relief={"roughness": 0.02, "wavelength": 2, "seed": 7, "classes": [{"value": 1, "roughness": 0.1, "wavelength": 3}]}),
    scene(WHEEL, redistribute={"model": "scm"}, soil={"name": "lunar"}, ground={"rocks": {"cover": 0.1, "k": 0.2, "smallest": 0.5, "largest": 3, "seed": 5}}),
    scene(WHEEL, attributes={"disturbance": {"heals": 86400}, "vegetation": {"cover": 0.9, "height": 0.2, "tears": 0.4, "rises": 3600, "grows": 86400,
          "classes": [{"value": 1, "cover": 0.2}]}, "elapsed": 60}, soil={"map": "classes.png", "classes": [{"value": 1, "name": "lunar"}], "default": {"name": "dry_sand"}}),
    scene(wheel(shape={"mesh": {"file": "foot.obj", "scale": 2, "belt": True}})),
    scene(wheel(shape={"box": {"size": [1, 1, 1], "belt": True}}, load=100), soil={"name": "lunar"}, redistribute={"model": "scm"}),
    scene(wheel(shape={"cylinder": {"radius": 0.5, "length": 1}}), wheel(name="b", shape={"capsule": {"radius": 0.5, "length": 1}}),
          wheel(name="c", shape={"ellipsoid": {"radii": [0.5, 0.4, 0.3]}})),
    scene(view=view({"fixed": {"eye": [1, 2, 3], "target": [4, 5, 6]}}), cache={"memory": "512 MB"}),
    scene(view=view({"fixed": {"eye": [1, 2, 3], "target": [4, 5, 6]}}, sun={"time": "2026-11-27T16:00:00Z"})),
    scene(WHEEL, view=view({"chase": "a"}, exposure="sun", sun={"time": "2026-11-27T16:00:00Z", "at": [10, 45]})),
    scene(WHEEL, cameras=[
        {"name": "a", "kind": "mounted", "on": "a", "rate": 5, "fov": 70, "size": [64, 48], "images": ["colour", "depth"], "depth_unit": 0.01, "stereo": 0.2, "video": True,
         "pose": {"at": [1, 0, 1], "yaw": 10, "pitch": -20, "roll": 3}},
        {"name": "b", "kind": "fixed", "rate": 1, "pose": {"at": [1, 2, 3], "target": [4, 5, 6]}},
        {"name": "c", "kind": "chase", "on": "a", "back": 9, "up": 4, "rate": 1}, {"name": "d", "kind": "overhead", "on": "a", "height": 9, "rate": 1},
        {"name": "e", "kind": "poses", "file": "poses.csv", "rate": 1}]),
    scene(WHEEL, soil={"name": "dry_sand"}, redistribute={"model": "scm"}, time_step=0.002, output={"sensors": 10, "noise_seed": 3},
          vehicles=[vehicle(imu={"body": "wheel", "at": [0, 0, 1], "noise": [0.1, 0.01]})],
          lidars=[{"name": "top", "on": "v", "body": "wheel", "pose": {"at": [0, 0, 1], "yaw": 1, "pitch": 2, "roll": 3}, "rays": [10, 4], "fov": [360, 20], "range": [0, 9], "rate": 5, "noise": 0.1,
                   "dropout": 0.1}, {"name": "post", "pose": {"at": [0, 0, 9], "target": [1, 1, 1]}, "rate": 5}]),
    scene(cameras=[{"name": "alone", "kind": "fixed", "rate": 1, "pose": {"at": [1, 2, 3]}}]),
    scene(soil={"name": "dry_sand"}, redistribute={"model": "scm"}, time_step=0.002, stuck={"after": 5, "below": 0.01}, stop=["overturned", "stuck"], output={"vehicles": 10},
          vehicles=[vehicle(start={"at": [5, 5], "yaw": 30}, soil=["wheel"],
                            driver={"path": {"points": [[5, 5], [6, 5]], "speed": 1}, "steer": [], "drive": ["drive"]}),
                    vehicle(name="y", model="rover.xml", no_soil=["mast"]),
                    vehicle(name="w", driver={"controls": "controls.csv"}),
                    vehicle(name="v", forward="-x", up="y", pushes="pushes.csv", interface=[{"geoms": "wheel", "material": "steel"}, {"geoms": "w*", "friction_angle": 9, "adhesion": 1}],
                            driver={"path": {"points": [[5, 5], [6, 5]], "speeds": [1, 2], "stop": [[1, 2]]}, "follow": "origin", "drive": ["drive"]}),
                    vehicle(name="x", driver={"hold": [{"actuator": "drive", "value": 1}]})]),
    scene(soil={"name": "dry_sand"}, redistribute={"model": "scm"}, time_step=0.002,
          vehicles=[vehicle(brakes=100, powertrain={"wheels": ["drive"], "engine": "engine.csv", "inertia": 0.2, "idle": 900, "drag": 5, "gears": [3, 1], "reverse": 3, "final": 4,
                                                    "shift": [900, 3000], "shift_time": 0.2, "clutch": {"torque": 300, "engage": 1500},
                                                    "differentials": {"centre": "limited", "front": "open", "rear": "locked", "bias": 2, "lock": 10}}),
                    vehicle(name="y", powertrain={"wheels": ["drive"], "torque": [[800, 100], [4000, 120]], "converter": {"capacity": 0.01, "ratio": 2, "coupling": 0.85}})]),
    scene(WHEEL, soil={"name": "dry_sand"}, redistribute={"model": "scm"}, time_step=0.002, vehicles=[vehicle(name="beside")]),
    scene(wheel(path={"points": [[20, 20], [30, 20]], "speed": 5, "smooth": True, "delay": 1}),
          wheel(name="b", path={"relative_to": "a", "offset": [-3, 0]})),
    scene(wheel(path={"file": "line.geojson", "line": 1, "speed": 5}), soil={"name": "dry_sand"}, redistribute={"model": "scm"}, time_step=0.002,
          store="globe.furrow", vehicles=[vehicle(driver={"path": {"file": "line.geojson", "line": 1, "speed": 1, "smooth": True, "rotate": 5, "offset": [1, 1]},
                                                          "drive": ["drive"]})]),
]


def page_rows():
    """Key: {column: cell} of each table of keys."""
    rows, head = {}, None
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else None
        if cells is None:
            head = None
        elif head is None:
            head = cells
        elif head == COLUMNS and not set(line) <= set("|- "):
            assert len(cells) == len(COLUMNS), line
            row = dict(zip(COLUMNS, cells))
            assert row["key"] not in rows, line
            rows[row["key"].strip("`")] = row
    return rows


def schema_limits():
    """Where: {low, high, above, unit, absent, otherwise}, as src/scene/scene_schema.c has them."""
    text = (ROOT / "src" / "scene" / "scene_schema.c").read_text()
    table = re.search(r"scene_limit limits\[\] = \{\n(.*?)\n\};", text, re.S).group(1)
    cell = r'(NULL|"[^"]*")'
    line_of = re.compile(r'\{"([^"]+)", (\S+), (\S+), (true|false), ' + cell + ", " + cell + r", (\S+), " + cell + r"\},$")
    limits = {}
    for line in table.splitlines():
        where, low, high, above, _, unit, absent, otherwise = line_of.match(line.strip()).groups()
        limits[where] = {"low": float(low), "high": float(high), "above": above == "true", "unit": unit.strip('"').replace("NULL", ""),
                         "absent": None if absent == "NAN" else float(absent),
                         "otherwise": None if otherwise == "NULL" else otherwise.strip('"')}
    return limits


def limit_of(limits, key):
    for where in (key, key + "[]", key + "[][]", key.replace("soil.classes[].", "soil.")):
        if where in limits:
            return limits[where]
    return None


def range_of(text):
    """(low, high, above): "0 .. 4", "above 0 .. 4", "1"; the checker says "to"."""
    numbers = [float(number) for number in re.split(r" \.\. | to ", text.removeprefix("above ").partition(", in ")[0])]
    return numbers[0], numbers[-1], text.startswith("above ")


def parts_of(key):
    return re.findall(r"\[\]|[^.\[\]]+", key)


class Checker:
    """What furrow takes at each key."""

    def __init__(self, test):
        self.test = test
        self.lengths = {}
        self.soils = {}  # keys of those that are written in another's place

    def answer(self, value, name="probe.yaml"):
        path = self.test.folder / name
        path.write_text(json.dumps(value))
        return self.test.furrow("explain", path)

    def allowed(self, key, value):
        """What is said to be allowed where `key` has that value and nothing else is wrong."""
        at = ""
        parts, whole = parts_of(key), value
        for i in reversed(range(len(parts))):
            at = ".".join(parts[:i]).replace(".[]", "[]")
            whole = [whole] * self.lengths[at] if parts[i] == "[]" else {parts[i]: whole}
        return self.answer({**whole, "scene": whole.get("scene", 1)}).stderr.strip().rpartition("; ")[2].removeprefix("allowed: ")

    def crawl(self, key="", found=None):
        """Key: (type, what is allowed) of all there are, without entries that are single values."""
        found = {} if found is None else found
        names = self.allowed(key + ".no_such_key" if key else "no_such_key", 1).split(", ")
        if key == "soil.classes[]":
            self.soils[key] = [name for name in names if name != "value"]
            names = ["value"]
        for name in names:
            self.visit(f"{key}.{name}" if key else name, found)
        return found

    def visit(self, key, found):
        if key == "attributes":  # a list of names is right, too
            found[key] = ("mapping", "")
            self.crawl(key, found)
            return
        allowed = self.allowed(key, [])
        if allowed == "text":
            found[key] = ("text", self.allowed(key, "x" * 70000))
        elif allowed.startswith("a mapping of "):
            found[key] = ("mapping", "")
            if key in ("soil.default", "soil.over", "ground.roads[].soil"):
                self.soils[key] = allowed.removeprefix("a mapping of ").split(", ")
            else:
                self.crawl(key, found)
        elif allowed.startswith(("a number", "a whole number")):
            kind, _, rest = allowed.removeprefix("a ").partition(", ")
            found[key] = (kind, rest)
        elif allowed == "true, false":
            found[key] = ("switch", allowed)
        elif (counts := self.allowed(key, "x")).startswith("a list of "):
            found[key] = ("list", counts.removeprefix("a "))
            self.lengths[key] = int(re.search(r"\d+", counts).group()) or 1
            self.entries(key + "[]", found)
        else:
            found[key] = ("word", allowed)

    def entries(self, key, found):
        allowed = self.allowed(key, {"no_such_key": 1})
        if "unknown" in self.allowed(key, "x") or allowed.startswith(("a number", "a whole number", "text")):
            return
        counts = self.allowed(key, "x")
        if counts.startswith("a list of "):
            self.lengths[key] = int(re.search(r"\d+", counts).group())
            return
        self.crawl(key, found)


class ScenePage(FurrowTest):
    @classmethod
    def setUpClass(cls):
        cls.rows, cls.limits = page_rows(), schema_limits()

    def setUp(self):
        super().setUp()
        shutil.copy(ROOT / "tools" / "scenes" / "foot.obj", self.folder)
        shutil.copy(ROOT / "tools" / "scenes" / "vehicles" / "rover.xml", self.folder)
        shutil.copy(ROOT / "tests" / "vehicle" / "one_wheel.xml", self.folder)
        (self.folder / "controls.csv").write_text("t,drive\n0,0\n1,2\n")
        (self.folder / "engine.csv").write_text("rpm,torque\n800,100\n4000,120\n")
        (self.folder / "poses.csv").write_text(re.search(r"```csv\n(.*?)```", PAGE.read_text(), re.S).group(1))
        for name in ("classes.png", "cohesion.png", "friction.png"):
            write_png16(self.folder / name, 4, 4, lambda x, y: 1)
        (self.folder / "line.geojson").write_text('{"type": "LineString", "coordinates": [[15.0002, 45.1535], [15.0004, 45.1535]]}')
        if has_gdal():
            rasters.make(self.folder / "utm.tif", 64, 64, [100.0] * 64 * 64, "f", step=1, west=500000, north=5000064)
            self.furrow("import", "utm.tif", "-o", "globe.furrow")

    def needs_meshes(self, result):
        return any(told in result.stderr for told in ("this build reads no meshes", "this build has no MuJoCo", "built without GDAL",
                                                      "globe.furrow: "))

    def test_its_keys_are_those_that_the_checker_takes(self):
        checker = Checker(self)
        taken = checker.crawl()
        soil = [key.removeprefix("soil.") for key in taken if re.fullmatch(r"soil\.\w+", key)]
        self.assertEqual(checker.soils["soil.over"] + ["thickness", "compaction", "over"], checker.soils["soil.default"])
        for place in ("soil.default", "soil.classes[]", "ground.roads[].soil"):
            self.assertEqual(checker.soils[place] + ["map", "classes", "default", "rasters"], soil)
            self.assertEqual(range_of(checker.allowed(place + ".cohesion", -1)), range_of(self.rows["soil.cohesion"]["range"]))
        self.assertEqual(set(self.rows), set(taken))
        self.assertGreater(len(taken), 80)
        for key, (kind, said) in taken.items():
            row = self.rows[key]
            with self.subTest(key=key):
                self.assertTrue(row["type"] == kind or kind == "list" and row["type"].startswith("list of "), row)
                if kind in NUMBERS:
                    self.assertEqual(range_of(row["range"]), range_of(said))
                elif kind == "list":
                    self.assertTrue(row["type"].startswith(said.replace(" to ", " .. ")), (row["type"], said))
                elif kind == "text":
                    self.assertEqual(row["range"], said)
                elif kind != "mapping":
                    self.assertEqual(re.findall(r"`([+\w-]+)`", row["range"]), said.split(", "))

    def check_numbers(self, key, low, high, above, unit, default):
        row = self.rows[key]
        self.assertEqual(range_of(row["range"]), (low, high, above), key)
        self.assertEqual(row["unit"], unit or "", key)
        if default is None:
            self.assertTrue(row["default"].startswith("needed"), key)
        elif isinstance(default, str):
            self.assertEqual(row["default"], default, key)
        else:
            self.assertEqual(float(row["default"]), default, key)

    def test_numbers_have_the_ranges_units_and_defaults_of_the_schema(self):
        numbers = {key for key, row in self.rows.items() if row["type"].endswith(("number", "numbers"))}
        used = []
        for key in numbers:
            limit = limit_of(self.limits, key)
            used.append(limit)
            otherwise = limit["absent"] if limit["absent"] is not None else limit["otherwise"]
            self.check_numbers(key, limit["low"], limit["high"], limit["above"], limit["unit"], otherwise)
        self.assertEqual([where for where, limit in self.limits.items() if not any(limit is other for other in used)], [])
        self.assertEqual([key for key, row in self.rows.items() if row["unit"] and key not in numbers], [])

    def test_explain_says_the_same_of_parameters_and_effects(self):
        path = self.folder / "least.yaml"
        path.write_text(json.dumps(SAMPLES[1]))
        effects = self.json("explain", path)["effects"]
        calls, uses = set(), set()
        for effect in effects:
            calls.add((effect["key"].replace("objects.", "objects[]."), effect["name"]))
            for parameter in effect["parameters"]:
                key = parameter["key"].removesuffix("[]")
                uses.add((key, effect["name"]))
                if parameter["kind"] in NUMBERS:
                    self.check_numbers(key, *parameter["range"], parameter["above"], parameter["unit"], parameter["default"])
                elif parameter["kind"] == "word":
                    self.assertEqual(re.findall(r"`([+\w-]+)`", self.rows[key]["range"]), parameter["words"])
        told = [(key, name) for key, row in self.rows.items() for name in row["effect"].split(", ") if name]
        self.assertEqual({(key, name.strip("*")) for key, name in told if name.startswith("**")}, calls)
        self.assertEqual({(key, name) for key, name in told if not name.startswith("*")}, uses - calls)
        self.assertEqual(len(told), len(set(told)))

    def holders(self, sample, parts):
        """Every mapping of the sample that holds the last of `parts`."""
        at = [sample]
        for part in parts[:-1]:
            if part == "[]":
                at = [entry for inner in at if isinstance(inner, list) for entry in inner]
            else:
                at = [inner[part] for inner in at if isinstance(inner, dict) and part in inner]
        return [inner for inner in at if isinstance(inner, dict) and parts[-1] in inner]

    def samples_without(self, samples, parts):
        for sample in samples:
            for i in range(len(self.holders(sample, parts))):
                without = json.loads(json.dumps(sample))
                del self.holders(without, parts)[i][parts[-1]]
                yield without

    @long
    def test_what_is_needed_is_needed_and_nothing_else(self):
        checker = Checker(self)
        samples = [sample for sample in SAMPLES if not self.needs_meshes(checker.answer(sample))]
        for i, sample in enumerate(samples):
            self.assertEqual(checker.answer(sample).returncode, 0, f"sample {i}: " + checker.answer(sample).stderr)
        for key, row in self.rows.items():
            if re.search(r"mesh|driver|line", key) and len(samples) < len(SAMPLES):
                continue
            always, sometimes = row["default"] == "needed", row["default"].startswith("needed")
            refused = []
            for without in self.samples_without(samples, parts_of(key)):
                refused.append(checker.answer(without).returncode != 0)
                if not always and refused[-1] == sometimes:
                    break
            with self.subTest(key=key):
                self.assertGreater(len(refused), 0, "in no sample")
                # Needed here and there: some are refused without. Not needed: some are not.
                told = all(refused) if always else any(refused) if sometimes else not all(refused)
                self.assertTrue(told, (row["default"], refused))

    def examples(self):
        for page in (PAGE, DRIVES, SOIL, SOILS):
            for i, text in enumerate(re.findall(r"```yaml\n(.*?)```", page.read_text(), re.S)):
                yield f"{page.name} {i}", text

    def test_its_examples_are_scenes(self):
        count = 0
        for name, text in self.examples():
            with self.subTest(example=name):
                keys = re.findall(r"^(\w+):", text, re.M)
                self.assertGreater(len(keys), 0)
                self.assertLessEqual({key for key in keys}, set(self.rows))
                for key, line in (("scene", "scene: 1"), ("end_time", "end_time: 10"), ("objects", "objects: " + json.dumps([WHEEL]))):
                    text = text if key in keys else line + "\n" + text
                path = self.folder / "example.yaml"
                path.write_text(text)
                result = self.furrow("explain", path)
                self.assertEqual((result.returncode, result.stderr), (0, ""))
                count += 1
        self.assertGreaterEqual(count, 5)

    def test_settings_are_as_it_says(self):
        lines = re.findall(r"^    --set ('[^']*'|\S+) ", PAGE.read_text(), re.M)
        self.assertEqual(len(lines), 7)
        (self.folder / "soil.yaml").write_text("soil: {name: dry_sand, cohesion: 500}\n")
        path = self.folder / "set.yaml"
        path.write_text(json.dumps(scene(wheel(name="wheel"), view=view({"fixed": {"eye": [1, 2, 3], "target": [4, 5, 6]}}, images=1,
                                                                        effects=["sky"]))))
        plan = self.json("explain", path, *[part for line in lines[:-1] for part in ("--set", line.strip("'"))])
        called = {effect["name"] for effect in plan["effects"] if effect["called"]}
        self.assertLessEqual({"fog", "box", "displace"}, called)
        self.assertNotIn("sky", called)
        self.assertEqual(self.json("explain", path, "--set", lines[-1])["stations"], {})

    def test_spacings_are_as_it_says(self):
        store = self.synth(posts="1025x1025", spacing=1, kind="plain")
        path = self.folder / "least.yaml"
        path.write_text(json.dumps(SAMPLES[1]))
        table = re.search(r"\| asked \| posts are apart \|\n\| --- \| --- \|\n(.*?)\n\n", PAGE.read_text(), re.S).group(1)
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        self.assertGreater(len(rows), 4)
        for asked, apart in rows:
            plan = self.json("explain", path, "--store", store, "--set", "spacing=" + asked.split(",")[0])
            self.assertEqual(plan["spacing"], float(apart), asked)
        self.assertEqual(self.json("explain", path, "--store", store)["spacing"], 1)

    def test_bytes_are_as_it_says(self):
        text = PAGE.read_text()
        said = re.search(r"Each post has (\d+) byte\s+more with disturbance, (\d+) with `scm`, (\d+) where a body slips", text)
        dirt, scm, slip = map(int, said.groups())
        bearing = {"soil": {"name": "lunar"}, "redistribute": {"model": "scm"}}
        path = self.folder / "scene.yaml"
        for body, keys, more in ((WHEEL, {}, 0), (WHEEL, {"attributes": ["disturbance"]}, dirt), (WHEEL, bearing, scm), (wheel(slip=0.1), bearing, slip)):
            path.write_text(json.dumps(scene(body, **keys)))
            self.assertEqual(sum(plane["bytes"] for plane in self.json("explain", path)["planes"]), 8 + more, keys)
        rows = re.findall(r"^\| ([\d.]+) \| ([\d.]+) \| (\d+) \| ([\d.]+) (kB|MB) \|$", text, re.M)
        self.assertGreater(len(rows), 4)
        for apart, under, stations, size, unit in rows:
            self.assertEqual(float(under), float(f"{0.2 / float(apart) ** 2:.{2 if float(under) < 100 else 3}g}"))
            self.assertEqual(int(stations), 1 / float(apart))
            bytes_of = 8 * 1e4 / float(apart) ** 2
            self.assertAlmostEqual(float(size) * {"kB": 1e3, "MB": 1e6}[unit] / bytes_of, 1, delta=0.03)

    def test_columns_of_poses_are_as_it_says(self):
        text = PAGE.read_text()
        ranges = {name: range_of(cell) for names, cell in re.findall(r"^\| (`[`\w, ]+`) \| [^|]+ \| ([^|]+) \| [^|]+ \|$", text, re.M)
                  for name in re.findall(r"\w+", names)}
        self.assertEqual(list(ranges), ["t", "x", "y", "z", "yaw", "pitch", "roll"])
        checker = Checker(self)
        path = {**WHEEL, "shape": {"sphere": {"radius": 1}}, "path": {"file": "poses.csv"}}
        lows, highs = [low for low, _, _ in ranges.values()], [high for _, high, _ in ranges.values()]
        beyond = [(row[:i] + [value] + row[i + 1:], 3) for i, (low, high, _) in enumerate(ranges.values())
                  for row, value in ((lows, low - abs(low) * 0.01 - 1e-3), (highs, high * 1.01))]
        for row, status in [(lows, 0), (highs, 0)] + beyond:
            (self.folder / "poses.csv").write_text(",".join(map(repr, row)) + "\n")
            self.assertEqual(checker.answer(scene(path)).returncode, status, row)
        for rows, status in (("t,x,y\n0,1,1\n1,2,2\n", 0), ("t,x,y\n1,1,1\n1,2,2\n", 3), ("0,1,1,5\n1,2,2\n", 3), ("0,1,1,5,6\n", 3),
                             ("t,y,x\n0,1,1\n", 3), ("\n0,1,1\n\n1,2,2\n", 0), ("# comment\n0,1,1\n", 3)):
            (self.folder / "poses.csv").write_text(rows)
            self.assertEqual(checker.answer(scene(path)).returncode, status, rows)

    def test_columns_of_objects_csv_are_as_it_says(self):
        table = re.search(r"^## objects\.csv\n.*?\n\| --- \| --- \| --- \|\n(.*?)\n\n", PAGE.read_text(), re.S | re.M).group(1)
        said = [name for line in table.splitlines() for name in line.split("|")[1].strip().split(", ")]
        written = re.search(r'#define COLUMNS "([^"]*)"', (ROOT / "src" / "report" / "objects_csv.c").read_text()).group(1)
        self.assertEqual(said, written.split(","))

    def test_other_pages_lead_to_it(self):
        for page in (ROOT / "README.md", DRIVES, ROOT / "docs" / "DESIGN.md", SOIL):
            self.assertIn("scene/SCENE.md)", page.read_text(), page.name)
        for command in ("drive", "explain"):
            self.assertIn("src/scene/SCENE.md", self.ok(command, "--help"))


if __name__ == "__main__":
    main()
