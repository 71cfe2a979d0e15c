"""furrow report: the page is one file, its figures are those of the folder, and what cannot be known is said."""
import base64
import csv
import json
import math
import os
import pathlib
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, MAPS, FurrowTest, largest, long, main, sampled

SCENE = """scene: 1
time_step: 0.02
end_time: 4
spacing: 0.0625
soil: {name: dry_sand}
redistribute: {model: scm}
store: flat.furrow
objects:
  - name: left
    shape: {wheel: {radius: 0.25, width: 0.2}}
    path: {points: [[3, 8], [10, 9], [11, 14]], speed: 2}
    load: 900
    slip: 0.2
  - name: right
    shape: {wheel: {radius: 0.25, width: 0.2}}
    path: {points: [[3, 6.8], [10, 7.8], [12, 13]], speed: 2}
    load: 1500
    slip: 0.1
output: {forces: 20, map: true}
cache: {slots: 16}
"""
BOX = """scene: 1
time_step: 0.05
end_time: 2
spacing: 0.125
redistribute: {model: box}
store: flat.furrow
objects:
  - {name: ball, shape: {sphere: {radius: 0.5}}, path: {points: [[4, 20], [20, 20]], speed: 4}, sink: 0.1}
"""
CAR = """scene: 1
time_step: 0.002
end_time: 2.5
spacing: 0.125
soil: {name: sandy_loam_15}
redistribute: {model: scm}
store: wide.furrow
vehicles:
  - name: car
    model: %s
    start: {at: [12, 12], yaw: 40}
    soil: [wheel_*]
    driver: {path: {points: [[12, 12], [24, 22]], speed: 3}, steer: [steer_*], drive: [drive_*]}
output: {forces: 50, vehicles: 50, map: true}
"""
ALWAYS = ["run", "results", "map", "curves", "rut", "volume", "steps", "cache", "soils", "notes", "settings"]
OFFROAD = pathlib.Path(__file__).resolve().parents[2] / "tools/scenes/vehicles/offroad.xml"


class Page:
    """A page, read as XML: it is written so that both kinds of reader take it."""

    def __init__(self, path):
        self.text = pathlib.Path(path).read_text(encoding="utf-8")
        self.root = xml.etree.ElementTree.fromstring(self.text)

    def sections(self):
        return [section.get("id") for section in self.root.iter("section")]

    def section(self, name):
        found, = [section for section in self.root.iter("section") if section.get("id") == name]
        return found

    def sentences(self, name):
        return ["".join(p.itertext()) for p in self.section(name).iter("p")]

    def plots(self, name):
        return {svg.find("title").text: Plot(svg) for svg in self.section(name).iter("svg") if svg.get("class") != "key"}

    def rows(self, name):
        """{first cell: the others}: numbers with all digits, else text."""
        out = {}
        for row in self.section(name).iter("tr"):
            cells = [float(cell.find("data").get("value")) if cell.find("data") is not None else "".join(cell.itertext()) for cell in row]
            out[cells[0]] = cells[1:]
        return out


class Png:
    """The pixels of an 8-bit RGB picture, row 0 the highest."""

    def __init__(self, data, pixels=True):
        self.width, self.height, depth, colours = struct.unpack(">IIBB", data[16:26])
        if not pixels:
            return
        assert (depth, colours) == (8, 2)
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
            at += size + 12
        raw, side, self.rows, above = zlib.decompress(packed), 3 * self.width, [], bytes(3 * self.width)
        for y in range(self.height):
            kind, row = raw[y * (side + 1)], bytearray(raw[y * (side + 1) + 1:(y + 1) * (side + 1)])
            for i in range(side):
                left, up, corner = row[i - 3] if i > 2 else 0, above[i], above[i - 3] if i > 2 else 0
                near = left + up - corner
                paeth = min((abs(near - left), 0, left), (abs(near - up), 1, up), (abs(near - corner), 2, corner))[2]
                row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
            self.rows.append(bytes(row))
            above = row

    def at(self, x, y):
        return self.rows[y][3 * x:3 * x + 3]


class Plot:
    """What a plot shows, in the units of its axes."""

    def __init__(self, svg):
        ticks = [[], []]
        for text in svg.iter("text"):
            try:
                value = float(text.text)
            except (TypeError, ValueError):
                continue
            axis = {"middle": 0, "end": 1}[text.get("text-anchor")]
            ticks[axis].append((float(text.get("xy"[axis])) - (4 if axis else 0), value))
        self.scale = []
        for axis in range(2):
            (a, low), (b, high) = min(ticks[axis], key=lambda t: t[1]), max(ticks[axis], key=lambda t: t[1])
            self.scale.append((a, low, (high - low) / (b - a)))
        self.curves, self.classes = [], []
        for path in svg.iter("path"):
            if "curve" in path.get("class"):
                self.classes.append((path.get("class"), path.get("stroke-dasharray")))
                self.curves.append([self.value(*map(float, point)) for point in re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path.get("d"))])
        self.dots = len(list(svg.iter("circle")))
        self.names = [text.text for text in svg.iter("text")]

    def value(self, x, y):
        return tuple(low + (at - begin) * unit for at, (begin, low, unit) in zip((x, y), self.scale))

    def grain(self, axis):
        """The value of a tenth of a pixel, the plot's last digit."""
        return abs(self.scale[axis][2]) * 0.16


@unittest.skipUnless(MAPS, "this build draws no maps")
class Report(FurrowTest):
    @classmethod
    def setUpClass(cls):
        """Drives of all tests; a test that changes one copies it."""
        super().setUpClass()
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="furrow-report-"))
        cls.addClassCleanup(shutil.rmtree, cls.made, ignore_errors=True)
        cls.call("synth", "-o", "flat.furrow", "--posts", "129x129", "--spacing", "0.25", "--kind", "plain", "--relief", "0.4")
        (cls.made / "scene.yaml").write_text(SCENE)
        (cls.made / "box.yaml").write_text(BOX)
        cls.call("drive", "scene.yaml", "-o", "a", "--overlay", "a.furrow", "--trace", "a.trace")
        cls.call("drive", "scene.yaml", "-o", "b", "--overlay", "b.furrow", "--set", "soil.name=sandy_loam_15", "--set", "objects.left.slip=0.4",
                 "--set", "cache.slots=8")
        cls.call("drive", "box.yaml", "-o", "box", "--overlay", "box.furrow")

    @classmethod
    def call(cls, *arguments):
        result = subprocess.run([FURROW, *arguments], cwd=cls.made, capture_output=True, text=True, timeout=280)
        if result.returncode == 4:
            raise unittest.SkipTest("no GL here: " + result.stderr.strip())
        if result.returncode != 0:
            raise AssertionError(result.stderr)
        return result.stdout

    def copy(self, *names):
        for name in names:
            shutil.copytree(self.made / name, self.folder / name)

    def report(self, *folders, cwd=None):
        self.ok("report", *folders, "-o", self.folder / "page.html", cwd=cwd or self.made)
        self.assertFalse(list(self.folder.glob("*.part")))
        page = Page(self.folder / "page.html")
        self.is_alone(page)
        return page

    def is_alone(self, page):
        """Nothing in the page makes a reader fetch anything, or run anything."""
        for node in page.root.iter():
            self.assertIn(node.tag, ("html head meta title style body h1 h2 p section table thead tbody tr th td data div figure figcaption img svg path "
                                     "text circle image ul li details summary small sup br").split())
            for name, value in node.attrib.items():
                if node.tag == "image" and name == "href":
                    self.assertTrue(value.startswith("data:image/png;base64,"))
                    continue
                self.assertNotIn(name, ("href", "onload", "onclick", "style", "srcset", "action"))
                if name == "src":
                    self.assertTrue(value.startswith("data:image/png;base64,"))
        self.assertNotIn("url(", page.text)
        self.assertNotIn("@import", page.text)

    def json_of(self, name):
        return json.loads((self.made / name / "run.json").read_text())

    def csv_of(self, folder, file="objects.csv"):
        rows = {}
        with open(self.made / folder / file, newline="") as lines:
            for row in csv.DictReader(lines):
                rows.setdefault(row["name"], []).append({key: float(value) if key not in ("name", "soil", "state") and value else value
                                                         for key, value in row.items()})
        return rows

    # --- a drive of wheels ---

    def test_the_figures_of_the_page_are_those_of_run_json(self):
        page, run = self.report("a"), self.json_of("a")
        self.assertEqual(page.sections(), ALWAYS)
        told = page.rows("run")
        self.assertEqual(told["steps"], [run["steps"]])
        self.assertEqual(told["ended"], ["complete"])
        self.assertEqual(told["scene"], ["scene.yaml"])
        self.assertEqual(told["hash of the scene"], [run["scene"]["hash"]])
        self.assertEqual(told["store"], [str((self.made / "a.furrow").resolve())])
        self.assertEqual(told["base store"], [str((self.made / "flat.furrow").resolve())])
        self.assertEqual(told["furrow"], [self.ok("--version").split()[1]])
        results = page.rows("results")
        self.assertEqual(results["GL renderer"], [run["gl"]["renderer"]])
        labels = list(results)
        self.assertTrue(labels.index("left: mean slip") < labels.index("left: distance, m") < labels.index("hits") < labels.index("GL renderer"))
        for name, object_ in run["objects"].items():
            for label, key in (("distance, m", "distance"), ("sinkage, mm", "sinkage"), ("load, N", "load"), ("slip", "slip")):
                self.assertEqual(results[f"{name}: {label}"], [object_[key]])
        for label, value in (("wall clock, s", run["seconds"]), ("tiles touched", run["cache"]["touched"]), ("hits", run["cache"]["hits"]),
                             ("commits", run["io"]["commits"]), ("peak memory, MB", run["memory"]["rss_peak"])):
            self.assertEqual(results[label], [value])
        volume = page.rows("volume")
        for label, key in (("removed", "removed"), ("raised", "raised"), ("net (raised - removed)", "net"), ("compacted", "compacted"), ("added", "added")):
            self.assertEqual(volume[label + ", m3"], [run["volume"][key]])
        for key in ("removed", "raised", "net", "compacted", "added"):
            self.assertEqual(volume[key + ", fixed-point units"], [run["volume"]["quanta"][key]])
        self.assertEqual(volume["net + compacted - added, fixed-point units"], [0])
        steps = page.rows("steps")
        self.assertEqual([steps[label][0] for label in steps if label], [run["step_ms"][key] for key in ("p50", "p95", "p99", "max")])
        soils = page.rows("soils")
        soil, = run["soils"]
        for key, value in soil.items():
            found = [cells for label, cells in soils.items() if label.split(",")[0] == key]
            self.assertEqual(found, [] if key == "name" else [[value]], key)
        self.assertIn("cohesion, Pa", soils)
        self.assertEqual(page.sentences("notes"), [note + ("" if note.endswith(".") else ".") for note in run["notes"]] or ["None."])
        settings = page.rows("settings")
        self.assertEqual({key: cells[0] for key, cells in settings.items() if key != "setting"}, run["scene"]["values"])
        self.assertEqual(settings["objects.left.path.points"], ["[[3, 8], [10, 9], [11, 14]]"])

    def test_curves_are_the_rows_of_objects_csv(self):
        page, rows = self.report("a"), self.csv_of("a")
        plots = page.plots("curves")
        values = ("sinkage", "slip", "traction", "grade resistance", "drawbar pull", "torque", "energy into the soil", "energy into the soil for each metre")
        self.assertEqual(sorted(plots), sorted(f"{name} over {axis}" for axis in ("time", "the way") for name in values))
        for index, name in enumerate(("left", "right")):
            mine, radius = rows[name], 0.25
            way, energy, ways, energies, pulls = 0, 0, [0], [0], []
            for a, b in zip(mine, mine[1:]):
                step = math.hypot(b["x"] - a["x"], b["y"] - a["y"])
                ahead = ((b["x"] - a["x"]) / step, (b["y"] - a["y"]) / step)
                force = [(a[key] + b[key]) / 2 for key in ("fx", "fy", "fz")]
                moment = [(a[key] + b[key]) / 2 for key in ("tx", "ty", "tz")]
                pulls.append(b["fx"] * ahead[0] + b["fy"] * ahead[1])
                energy -= force[0] * (b["x"] - a["x"]) + force[1] * (b["y"] - a["y"]) + force[2] * (b["z"] - a["z"])
                energy -= (-moment[0] * ahead[1] + moment[1] * ahead[0]) * math.hypot(step, b["z"] - a["z"]) / (radius * (1 - b["slip"]))
                way += step
                ways.append(way)
                energies.append(energy / 1e3)
            self.assertGreater(energies[-1], 0.5)
            wanted = {"sinkage": [row["sinkage"] * 1e3 for row in mine], "slip": [row["slip"] for row in mine], "energy into the soil": energies}
            for value, list_ in wanted.items():
                for axis, across in (("time", [row["t"] for row in mine]), ("the way", ways)):
                    plot = plots[f"{value} over {axis}"]
                    # The first curve is drawn last, on top.
                    curve = plot.curves[1 - index]
                    self.assertAlmostEqual(curve[-1][0], across[-1], delta=plot.grain(0))
                    self.assertAlmostEqual(curve[-1][1], list_[-1], delta=plot.grain(1))
                    self.assertAlmostEqual(max(y for _, y in curve), max(list_), delta=plot.grain(1))
                    self.assertAlmostEqual(min(y for _, y in curve), min(list_), delta=plot.grain(1))
            # The soil carries the load, so what is left along the ground is the level force, but for the slope's cosine.
            for axis in ("time", "the way"):
                curve = plots[f"drawbar pull over {axis}"].curves[1 - index]
                self.assertAlmostEqual(curve[-1][1], pulls[-1], delta=2)
                self.assertAlmostEqual(max(y for _, y in curve), max(pulls), delta=4)
            self.means_are_those_of([mine], page.rows("results"), name, "")
            told = page.rows("curves")
            self.assertAlmostEqual(told["energy into the soil, kJ"][index], energies[-1], delta=1e-6)
            self.assertAlmostEqual(told["energy into the soil for each metre, J/m"][index], 1e3 * energies[-1] / ways[-1], delta=1e-3)

    def means_are_those_of(self, wheels, results, name, means=" of its wheels", sums=""):
        """The means over the last quarter of the time, of one object's rows, or of several wheels together."""
        end = wheels[0][-1]["t"]
        self.assertEqual((results["rows of objects.csv from t, s"], results["to t, s"]), ([0.75 * end], [end]))
        late = [[row for row in wheel if row["t"] >= 0.75 * end * (1 - 1e-9)] for wheel in wheels]
        self.assertGreater(len(late[0]), 10)
        mean = lambda key: sum(sum(row[key] for row in wheel) / len(wheel) for wheel in late)
        for label, value in ((f"slip{means}", mean("slip") / len(late)), (f"sinkage{means}, mm", mean("sinkage") / len(late)), (f"vertical force{sums}, N", mean("fz"))):
            told, = results[f"{name}: mean {label}"]
            self.assertAlmostEqual(told, value, delta=1e-9 * abs(value), msg=label)
        told = {"drawbar pull": 0, "torque": 0}  # of ways that are almost level
        for wheel in wheels:
            for a, b in list(zip(wheel, wheel[1:]))[-len(late[0]):]:
                step = math.hypot(b["x"] - a["x"], b["y"] - a["y"]) * len(late[0])
                told["drawbar pull"] += (b["fx"] * (b["x"] - a["x"]) + b["fy"] * (b["y"] - a["y"])) / step
                told["torque"] += (b["tx"] * (b["y"] - a["y"]) - b["ty"] * (b["x"] - a["x"])) / step
        self.assertAlmostEqual(results[f"{name}: mean drawbar pull{sums}, N"][0], told["drawbar pull"], delta=0.005 * mean("fz"))
        self.assertAlmostEqual(results[f"{name}: mean torque{sums}, N m"][0], told["torque"], delta=0.005 * mean("fz"))

    def rows_on_a_slope(self, degrees, work):
        """A wheel that climbs at a slip, with forces that do not change: what the page tells of it. Returns its closed form."""
        self.copy("a")
        a, pull, load, radius, slip, resists, way = math.radians(degrees), 120, 1000, 0.25, 0.2, 80, 4
        # Along the ground the soil gives the pull and carries the weight; the wheel's torque also works against what resists it.
        traction, torque = pull + load * math.sin(a), (pull + load * math.sin(a) + resists) * radius
        up = load * math.cos(a)
        fx, fz = traction * math.cos(a) - up * math.sin(a), traction * math.sin(a) + up * math.cos(a)
        with open(self.folder / "a/objects.csv", "w") as out:
            out.write("t,name,x,y,z,sinkage,fx,fy,fz,tx,ty,tz,slip,contact_area,load,soil,state,residual" + (",work" if work else "") + "\n")
            for i in range(81):
                s = way * i / 80
                # Looking north: its axle is to the west, and the soil's moment turns it back.
                told = f",{(torque / radius / (1 - slip) - traction) * s:.9g}" if work else ""
                out.write(f"{i / 10},{'other' if work else 'left'},5,{3 + s * math.cos(a):.9g},{10 + s * math.sin(a):.9g},0.02,0,{fx:.9g},{fz:.9g},{torque:.9g},0,0,{slip},0.1,{load},"
                          f"dry_sand,touching,0{told}\n")
        page, along = self.report("a", cwd=self.folder), way * math.cos(a)
        return page, {"way, m": along, "work of the axle's torque, kJ": torque / radius / (1 - slip) * way / 1e3, "work of the drawbar pull, kJ": pull * way / 1e3,
                      "work that lifts the weight, kJ": load * math.sin(a) * way / 1e3,
                      "of that, by slip, J/m": slip / (1 - slip) * torque / radius * way / along, "of that, by sinking and pushing soil, J/m": resists * way / along,
                      "energy into the soil, kJ": (torque / radius / (1 - slip) - traction) * way / 1e3,
                      "tractive efficiency, share of 1": traction * (1 - slip) * radius / torque}, {"traction": traction, "grade resistance": load * math.sin(a), "drawbar pull": pull,
                      "torque": torque}

    def test_forces_and_energy_on_a_slope_are_those_of_the_closed_form(self):
        for degrees, work in ((20, False), (-8, False), (20, True)):
            page, energy, forces = self.rows_on_a_slope(degrees, work)
            shutil.rmtree(self.folder / "a")
            told, plots, results = page.rows("curves"), page.plots("curves"), page.rows("results")
            for label, value in energy.items():
                if label in told or value == value and degrees > 0:
                    self.assertAlmostEqual(told[label][0], value, delta=1e-5 * abs(value) + 1e-9, msg=(label, degrees, work))
            for name, value in forces.items():
                for x, y in plots[f"{name} over the way"].curves[0]:
                    self.assertAlmostEqual(y, value, delta=plots[f"{name} over the way"].grain(1), msg=(name, x))
                if name != "grade resistance":
                    unit = "N m" if name == "torque" else "N"
                    self.assertAlmostEqual(results[f"{'other' if work else 'left'}: mean {name}, {unit}"][0], value, delta=1e-4 * abs(value))
            for label in ("tractive efficiency, share of 1", "energy into the soil for each metre, J/m"):  # of the last quarter the same
                if label in told and degrees > 0:
                    self.assertAlmostEqual(results[f"{'other' if work else 'left'}: {label}"][0], told[label][0], delta=1e-4 * told[label][0])
            loss = plots["energy into the soil for each metre over time"]
            self.assertTrue(all(abs(y - told["energy into the soil for each metre, J/m"][0]) < loss.grain(1) for _, y in loss.curves[0]))
            self.assertIn("Grade resistance is the part of it that carries the weight up the slope", " ".join(page.sentences("curves")))

    @long
    def test_many_rows_make_a_small_page_that_has_the_extremes(self):
        self.copy("a")
        with open(self.folder / "a/objects.csv") as lines:
            header = lines.readline()
        with open(self.folder / "a/objects.csv", "w") as out:
            out.write(header)
            for i in range(100000):
                sinkage = 0.9 if i == 61234 else -0.3 if i == 61235 else 0.05 + 0.01 * math.sin(i)
                out.write(f"{i * 4e-5:.9g},left,{3 + i * 4e-5:.9g},8,0,{sinkage},1,0,900,0,0,0,0.2,0.1,900,dry_sand,touching,0\n")
        page = self.report("a", cwd=self.folder)
        plot = page.plots("curves")["sinkage over time"]
        heights = [y for _, y in plot.curves[0]]
        self.assertLess(len(heights), 1200)
        self.assertAlmostEqual(max(heights), 900, delta=plot.grain(1))
        self.assertAlmostEqual(min(heights), -300, delta=plot.grain(1))
        self.assertLess(len(re.sub(r"base64,[^\"]*", "", page.text)), 200000)
        self.assertLess(len(page.text), 400000)

    @long
    def test_the_rut_is_that_of_the_store(self):
        page, run = self.report("a"), self.json_of("a")
        sentence, = page.sentences("rut")
        x, y, deep, high = map(float, re.search(r"way of left \(([\d.]+) m east, ([\d.]+) m north\): ([\d.]+) mm deep, rims ([\d.]+) mm", sentence).groups())
        rows = self.csv_of("a")["left"]
        half = sum(math.hypot(b["x"] - a["x"], b["y"] - a["y"]) for a, b in zip(rows, rows[1:])) / 2
        # The middle lies on the first leg, from (3, 8) to (10, 9).
        length = math.hypot(7, 1)
        self.assertAlmostEqual(x, 3 + half * 7 / length, delta=0.02)
        self.assertAlmostEqual(y, 8 + half * 1 / length, delta=0.02)
        left = (-1 / length, 7 / length)
        plot = page.plots("rut")["The ground across the way"]
        asked = "".join(f"{x + across * left[0]} {y + across * left[1]}\n" for across, _ in plot.curves[0])
        points = self.json("query", self.made / "a.furrow", stdin=asked)["points"]
        for (across, change), point in zip(plot.curves[0], points, strict=True):
            self.assertAlmostEqual(change, point["offset"] * 1e3, delta=1.5, msg=across)
        self.assertAlmostEqual(deep, -min(y for _, y in plot.curves[0]), delta=plot.grain(1) + 0.05)
        self.assertAlmostEqual(high, max(y for _, y in plot.curves[0]), delta=plot.grain(1) + 0.05)
        self.assertGreater(deep, 15)
        # Both wheels' ruts are within it.
        self.assertLess(min(y for x, y in plot.curves[0] if x < -0.9), -15)
        self.assertGreater(run["volume"]["removed"], 0)

    def test_the_histogram_has_every_step(self):
        run = self.json_of("a")
        edges, counts = run["step_ms"]["histogram"]["edges"], run["step_ms"]["histogram"]["counts"]
        self.assertEqual(sum(counts), run["steps"])
        self.assertEqual(len(edges), len(counts) + 1)
        self.assertEqual(edges, sorted(set(edges)))
        self.assertTrue(edges[-2] <= run["step_ms"]["max"] <= edges[-1])
        plot = self.report("a").plots("steps")["Step times"]
        self.assertIn("median", plot.names)
        highest = max(y for _, y in plot.curves[0])
        self.assertAlmostEqual(highest, 100 * max(counts) / sum(counts), delta=plot.grain(1))

    def test_the_cache_curve_is_that_of_the_trace(self):
        self.call("synth", "-o", "long.furrow", "--posts", "257x257", "--spacing", "0.5", "--kind", "plain", "--relief", "0.3")
        self.call("drive", "box.yaml", "-o", "long", "--store", "long.furrow", "--overlay", "over.furrow", "--trace", "long.trace", "--set", "spacing=0.0625",
                  "--set", "objects.ball.path={points: [[4, 20], [120, 50], [4, 100]], speed: 90}", "--set", "cache.slots=8")
        page = self.report("long")
        got = self.json("cache-sim", "long.trace", "--policy", "lru,opt", cwd=self.made)
        self.assertGreater(len(got["slots"]), 3)
        plot = page.plots("cache")["Misses over slots"]
        self.assertEqual(plot.dots, 2 * len(got["slots"]))
        self.assertIn("slots of this drive", plot.names)
        for curve, policy in zip(plot.curves, ("opt", "lru")):
            for (_, y), misses in zip(curve, got["policies"][policy]["misses"]):
                self.assertAlmostEqual(y, misses, delta=plot.grain(1))
        self.assertIn(f"{got['accesses']} accesses to {got['tiles']} tiles", page.sentences("cache")[0])

    def test_a_cache_curve_of_one_point_is_none(self):
        tiles = self.json_of("a")["cache"]["touched"]
        self.assertLess(tiles, 4)
        self.without_plots(self.report("a"), "cache", f"^No cache curve: the drive touched {tiles} tiles?, fewer than")

    def ground(self, page):
        """The picture under a map: its pixels and the metres of its edges."""
        svg, = [svg for svg in page.section("map").iter("svg") if svg.get("class") == "map"]
        image, = svg.iter("image")
        return Plot(svg), image, Png(base64.b64decode(image.get("href").split(",")[1]))

    def test_the_map_shows_the_ruts_under_the_ways(self):
        page = self.report("a")
        self.assertNotIn("ways", page.sections())
        plot, image, png = self.ground(page)
        x, y, wide, tall = (float(image.get(key)) for key in ("x", "y", "width", "height"))
        self.assertAlmostEqual(wide / tall, png.width / png.height, delta=0.01)
        asked, places = "", []
        for curve in plot.curves[:2] if len(plot.curves) > 2 else plot.curves:
            for east, north in curve[1:-1]:
                asked += f"{east} {north}\n"
                places.append((east, north))
        points = self.json("query", self.made / "a.furrow", stdin=asked)["points"]
        scale = [plot.scale[axis] for axis in range(2)]
        seen = 0
        for (east, north), point in zip(places, points, strict=True):
            column = int(((east - scale[0][1]) / scale[0][2] + scale[0][0] - x) / wide * png.width)
            row = int(((north - scale[1][1]) / scale[1][2] + scale[1][0] - y) / tall * png.height)
            red, _, blue = png.at(column, row)
            if point["offset"] < -0.02:
                seen += 1
                self.assertGreater(blue, red + 30, (east, north))
        self.assertGreater(seen, 10)
        # Ground that nothing touched is grey.
        red, _, blue = png.at(2, 2)
        self.assertLess(abs(red - blue), 25)
        self.assertIn("Metres are those of the scene", " ".join(page.sentences("map")))

    @unittest.skipUnless(shutil.which("gdal_translate"), "needs GDAL's programs")
    def test_the_store_s_system_is_named(self):
        self.call("synth", "-o", "ground.tif", "--posts", "65x65", "--spacing", "1", "--kind", "plain", "--overwrite")
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32633", "-a_ullr", "499999.5", "5000064.5", "500064.5", "4999999.5", self.made / "ground.tif",
                        self.made / "utm.tif"], check=True)
        self.call("import", "utm.tif", "-o", "utm.furrow", "--overwrite")
        self.scene(BOX)
        self.call("drive", self.folder / "scene.yaml", "-o", "utm", "--store", "utm.furrow")
        self.assertIn("That post lies at 500000, 5000000 of WGS 84 / UTM zone 33N (EPSG:32633).", " ".join(self.report("utm").sentences("map")))

    def test_a_store_that_changed_leaves_the_map_of_the_drive(self):
        self.copy("a")
        run = json.loads((self.folder / "a/run.json").read_text())
        run["store"]["file"] = str(self.folder / "gone.furrow")
        (self.folder / "a/run.json").write_text(json.dumps(run))
        page = self.report("a", cwd=self.folder)
        image, = page.section("map").iter("img")
        self.assertEqual(base64.b64decode(image.get("src").split(",")[1]), (self.made / "a/map.png").read_bytes())
        self.assertIn("gone.furrow is not there any more", page.sentences("map")[0])
        self.assertIn("ways", page.sections())

    def test_the_volume_over_time_is_that_of_volume_csv(self):
        page, run = self.report("a"), self.json_of("a")
        with open(self.made / "a/volume.csv", newline="") as lines:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
        self.assertEqual(rows[0]["t"], 0)
        for key in ("removed", "raised", "compacted"):
            self.assertAlmostEqual(rows[-1][key], run["volume"][key], delta=1e-9)
        plot = page.plots("volume")["Volume over time"]
        wanted = [run["volume"][key] for key in ("net", "compacted", "raised", "removed")]
        for curve, value in zip(plot.curves, wanted):
            self.assertAlmostEqual(curve[-1][0], run["simulated"], delta=plot.grain(0))
            self.assertAlmostEqual(curve[-1][1], value, delta=plot.grain(1))
        self.copy("a")
        (self.folder / "a/volume.csv").write_text("t,step,removed,raised,compacted\n0,0,0,0,0\n1,x,0,0,0\n")
        self.assertIn("a/volume.csv:3: ", self.refused(3, "report", "a", "-o", "page.html"))
        (self.folder / "a/volume.csv").unlink()
        self.without_plots(self.report("a", cwd=self.folder), "volume", "^No volume over time: the folder has no volume.csv")

    def test_cameras_and_the_sun(self):
        self.copy("box")
        run = json.loads((self.folder / "box/run.json").read_text())
        self.assertNotIn("sun", run)  # it drew no picture
        frame = lambda number, east: {"frame": number, "time": number / 2, "position": [east, 20, 12.5], "orientation": [-0.5, 0.5, -0.5, 0.5]}
        run["sun"] = {"azimuth": 220.5, "height": 12.25, "moves": True, "azimuth_at_end": 221, "height_at_end": -3}
        run["cameras"] = {"eye": {"kind": "mounted", "on": "ball", "width": 640, "height": 360, "fov_horizontal": 60, "rate": 2, "images": ["colour"], "frames": 3,
                                  "first": frame(0, 4), "last": frame(2, 8)}, "../..": {"images": ["colour"], "first": frame(0, 4)}, "odd": 3, "none": {"images": [3], "last": []}}
        (self.folder / "box/run.json").write_text(json.dumps(run))
        pictures = self.folder / "box/cameras/eye/colour"
        pictures.mkdir(parents=True)
        shutil.copy(self.made / "a/map.png", pictures / "000000.png")
        shutil.copytree(pictures, self.folder / "colour")  # where the name of the second camera leads
        page = self.report("box", cwd=self.folder)
        told = page.rows("run")
        self.assertEqual([told[f"sun of pictures: {key}, degrees"] for key in ("azimuth", "height")], [[220.5], [12.25]])
        self.assertEqual(told["sun's height at the end, degrees"], [-3])
        rows = page.rows("cameras")
        self.assertEqual(rows["eye"], ["mounted, on ball", "640 x 360", "60", "2", "3", "colour", "4.00, 20.00, 12.50 m; looks to 90°, 0° up",
                                       "8.00, 20.00, 12.50 m; looks to 90°, 0° up"])
        image, = page.section("cameras").iter("img")
        whole, small = Png((self.made / "a/map.png").read_bytes(), False), Png(base64.b64decode(image.get("src").split(",")[1]))
        times = -(-max(whole.width, whole.height) // 320)
        self.assertEqual((small.width, small.height), (whole.width // times, whole.height // times))
        self.assertEqual((image.get("width"), image.get("height")), (str(small.width), str(small.height)))
        self.assertIn("000002.png: is not there", " ".join(page.sentences("cameras")))
        for damage in (b"", b"GIF89a", (self.made / "a/map.png").read_bytes()[:3000]):
            (pictures / "000000.png").write_bytes(damage)
            page = self.report("box", cwd=self.folder)
            self.assertEqual(list(page.section("cameras").iter("img")), [])
            self.assertIn("000000.png: ", " ".join(page.sentences("cameras")))

    # --- what is not known is said, and not drawn ---

    def without_plots(self, page, name, pattern):
        self.assertEqual(page.plots(name), {})
        self.assertRegex(" ".join(page.sentences(name)), pattern)

    def test_a_model_without_forces_has_ways_and_a_rut(self):
        page = self.report("box")
        self.assertEqual(page.sections(), ALWAYS)
        self.without_plots(page, "curves", r"^No curves: .*output\.forces")
        self.without_plots(page, "cache", r"^No cache curve: .*--trace")
        self.assertIn("No soil", page.sentences("soils")[0])
        self.assertNotIn("net + compacted - added, fixed-point units", page.rows("volume"))
        way, _, _ = self.ground(page)
        curve = way.curves[-1]
        self.assertAlmostEqual(curve[0][0], 4, delta=way.grain(0))
        self.assertAlmostEqual(curve[-1][0], 12, delta=way.grain(0))
        self.assertAlmostEqual(curve[-1][1], 20, delta=way.grain(1))
        rut = page.plots("rut")["The ground across the way"]
        self.assertAlmostEqual(min(y for _, y in rut.curves[0]), -100, delta=25)

    def test_what_is_gone_is_said(self):
        self.copy("a")
        run = json.loads((self.folder / "a/run.json").read_text())
        run["store"]["file"], run["trace"] = str(self.folder / "gone.furrow"), str(self.folder / "gone.trace")
        (self.folder / "a/run.json").write_text(json.dumps(run))
        (self.folder / "a/map.png").unlink()
        (self.folder / "a/objects.csv").unlink()
        page = self.report("a", cwd=self.folder)
        self.without_plots(page, "rut", r"^No rut profile: .*gone\.furrow is not there any more\.$")
        self.without_plots(page, "cache", r"^No cache curve: .*gone\.trace is not there any more\.$")
        self.without_plots(page, "curves", "^No curves: ")
        self.assertEqual(list(page.section("map").iter("img")), [])
        self.assertRegex(page.sentences("map")[0], "^No map: ")

    def test_a_way_off_the_terrain_has_no_rut(self):
        self.copy("box")
        run = json.loads((self.folder / "box/run.json").read_text())
        for way in ([[-90, 20], [-50, 20]], [[1e15, 20], [2e15, 1e15]], [[20, 40], [20, 90]]):
            run["objects"]["ball"]["way"] = way
            (self.folder / "box/run.json").write_text(json.dumps(run))
            self.without_plots(self.report("box", cwd=self.folder), "rut", "^No rut profile: the middle of the way of ball lies off the terrain")

    def test_a_store_or_a_trace_of_another_drive_is_not_taken(self):
        self.copy("a")
        shutil.copy(self.made / "a.furrow", self.folder)
        shutil.copy(self.made / "flat.furrow", self.folder)
        run = json.loads((self.folder / "a/run.json").read_text())
        run["store"]["file"] = str(self.folder / "a.furrow")
        (self.folder / "a/run.json").write_text(json.dumps(run))
        self.assertEqual(len(self.report("a", cwd=self.folder).plots("rut")), 1)
        run["cache"]["hits"] += 1
        (self.folder / "a/run.json").write_text(json.dumps(run))
        self.ok("reset", "a.furrow")
        page = self.report("a", cwd=self.folder)
        self.without_plots(page, "rut", "was changed after this drive")
        self.without_plots(page, "cache", "trace of another drive")

    def test_run_json_of_an_older_furrow(self):
        self.copy("a")
        run = json.loads((self.folder / "a/run.json").read_text())
        for key in ("version", "scene", "store", "trace", "notes"):
            del run[key]
        del run["step_ms"]["histogram"]
        for object_ in run["objects"].values():
            del object_["way"]
        (self.folder / "a/run.json").write_text(json.dumps(run))
        page = self.report("a", cwd=self.folder)
        self.assertEqual(page.sections(), ALWAYS[:3] + ["ways"] + ALWAYS[3:])
        self.without_plots(page, "rut", "does not name the store")
        self.without_plots(page, "steps", "No histogram")
        self.assertIn("sinkage over time", page.plots("curves"))
        # Of a wheel whose radius is not told, the energy is not known.
        self.assertNotIn("energy into the soil over time", page.plots("curves"))
        self.assertIn("No energy for 2 of these objects", " ".join(page.sentences("curves")))

    # --- a vehicle ---

    def test_a_vehicle(self):
        self.call("synth", "-o", "wide.furrow", "--posts", "129x129", "--spacing", "0.25", "--kind", "plain", "--relief", "0.2", "--overwrite")
        self.scene(CAR % OFFROAD)
        result = self.furrow("drive", self.folder / "scene.yaml", "-o", "car", "--store", "wide.furrow", "--overlay", "car.furrow", cwd=self.made)
        if "no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        page, run, rows = self.report("car"), self.json_of("car"), self.csv_of("car", "vehicles.csv")["car"]
        way = run["vehicles"]["car"]["way"]
        self.assertEqual([f"{value:.9g}" for value in way[0] + way[-1]], [f"{row[key]:.9g}" for row in (rows[0], rows[-1]) for key in "xy"])
        self.assertTrue(20 < len(way) <= 66)
        self.assertLess(largest(min(math.hypot(x - row["x"], y - row["y"]) for row in rows) for x, y in way), 0.04)
        self.assertGreater(run["vehicles"]["car"]["distance"], 128 * 0.02)
        self.assertEqual(page.sections(), ALWAYS[:4] + ["vehicles"] + ALWAYS[4:])
        results = page.rows("results")
        for label, key in (("mass, kg", "mass"), ("distance, m", "distance"), ("work, J", "work"), ("kinetic energy, J", "kinetic")):
            self.assertEqual(results["car: " + label], [run["vehicles"]["car"][key]])
        self.means_are_those_of(list(self.csv_of("car").values()), results, "car", sums=", sum of its wheels")
        # Energy in the same rows: of the actuators, and into the soil. On level ground its wheels pull next to nothing.
        late = [row for row in rows if row["t"] >= 0.75 * rows[-1]["t"] * (1 - 1e-9)]
        work, went = late[-1]["work"] - late[0]["work"], sum(math.hypot(b["x"] - a["x"], b["y"] - a["y"]) for a, b in zip(late, late[1:]))
        self.assertAlmostEqual(results["car: mean power of its actuators, W"][0], work / (late[-1]["t"] - late[0]["t"]), delta=1e-3 * work)
        self.assertAlmostEqual(results["car: work of its actuators for each metre, J/m"][0], work / went, delta=1e-6 * work / went)
        lost = sum(wheel[-1]["work"] - next(row["work"] for row in wheel if row["t"] >= late[0]["t"] * (1 - 1e-9)) for wheel in self.csv_of("car").values())
        self.assertAlmostEqual(results["car: energy into the soil for each metre, J/m"][0], lost / went, delta=1e-3 * lost / went)
        self.assertLess(abs(results.get("car: tractive efficiency, share of 1", [0])[0]), 0.05)
        plots = page.plots("vehicles")
        wanted = {"speed": math.hypot(*(rows[-1][key] for key in ("vx", "vy", "vz"))), "work of the actuators": rows[-1]["work"] / 1e3,
                  "kinetic energy": rows[-1]["kinetic"] / 1e3}
        for name, value in wanted.items():
            for axis in ("time", "the way"):
                plot = plots[f"{name} over {axis}"]
                self.assertAlmostEqual(plot.curves[0][-1][1], value, delta=plot.grain(1))
        self.assertAlmostEqual(plots["speed over the way"].curves[0][-1][0], run["vehicles"]["car"]["distance"], delta=0.1)
        for axis in ("time", "the way"):
            plot = plots[f"force of the actuators over {axis}"]
            ends = [force for name, force in rows[-1].items() if name.startswith("f:")]
            self.assertEqual((len(plot.curves), len(ends)), (6, 6))
            for curve, end in zip(reversed(plot.curves), ends):  # the first lies on top
                self.assertAlmostEqual(curve[-1][1], end, delta=plot.grain(1))
        self.assertGreater(max(ends), 50)
        curves = page.plots("curves")
        self.assertEqual(len(curves["sinkage over time"].curves), 4)
        near = "has a drawbar pull near 0"
        self.assertTrue(near in " ".join(page.sentences("curves")) and near not in self.report("a").text)
        self.assertTrue(all(-1.001 <= y <= 1.001 for curve in curves["slip over time"].curves for _, y in curve))
        # The work of the motors went into the soil, into height and motion, and a little into the dampers of its springs.
        works = {name: [float(row["work"]) for row in list_] for name, list_ in self.csv_of("car").items()}
        soil = sum(list_[-1] for list_ in works.values())
        vehicle = page.rows("vehicles")
        self.assertAlmostEqual(vehicle["into the soil, by all soil geoms, kJ"][0], soil / 1e3, delta=1e-6)
        lifted = run["vehicles"]["car"]["mass"] * 9.81 * (rows[-1]["z"] - rows[0]["z"])
        self.assertAlmostEqual(vehicle["to lift its weight, kJ"][0], lifted / 1e3, delta=1e-6)
        rest = rows[-1]["work"] - soil - lifted - (rows[-1]["kinetic"] - rows[0]["kinetic"])
        self.assertTrue(-0.01 * rows[-1]["work"] < rest < 0.1 * rows[-1]["work"], (rest, rows[-1]["work"], soil))
        self.assertEqual(len(curves["energy into the soil over the way"].curves), 4)
        self.copy("car")
        run["objects"] = {"roller": {"way": [[12, 14], [15, 14]]}}
        (self.folder / "car/run.json").write_text(json.dumps(run))
        self.assertEqual(["".join(item.itertext()).strip() for item in self.report("car", cwd=self.folder).section("map").iter("li")], ["roller", "car"])
        self.assertIn("The ground across the way", page.plots("rut"))

    # --- several folders ---

    def test_drives_beside_each_other(self):
        page, runs = self.report("a", "b", "box"), [self.json_of(name) for name in ("a", "b", "box")]
        self.assertEqual(page.sections(), ["run", "differences"] + ALWAYS[1:3] + ["ways"] + ALWAYS[3:])
        self.assertEqual(page.rows("run")["steps"], [run["steps"] for run in runs])
        self.assertEqual(page.rows("results")["left: sinkage, mm"], [runs[0]["objects"]["left"]["sinkage"], runs[1]["objects"]["left"]["sinkage"], "\u2013"])
        self.assertEqual(page.rows("volume")["removed, m3"], [run["volume"]["removed"] for run in runs])
        curves = page.plots("curves")["drawbar pull over time"]
        self.assertEqual(len(curves.curves), 4)
        self.assertEqual(len(set(curves.classes)), 4)
        legend = ["".join(item.itertext()).strip() for item in page.section("curves").iter("li")]
        self.assertEqual(legend, ["a: left", "a: right", "b: left", "b: right"])
        self.assertIn("box: No rows of objects.csv.", page.sentences("curves"))
        self.assertEqual(len(page.plots("rut")["The ground across the way"].curves), 3)
        self.assertEqual(len(list(page.section("map").iter("image"))), 3)
        ends = lambda page: [[t.text for t in svg.iter("text")] for svg in page.section("map").iter("svg") if svg.get("class") == "ramp"]
        largest = max((ends(self.report(name))[0][0] for name in ("a", "b", "box")), key=lambda text: abs(float(text.split()[0])))
        self.assertEqual([low for low, _, _ in ends(page)], [largest] * 3)
        self.assertIn("one colour scale", " ".join(page.sentences("map")))
        heads = [th.text for th in page.section("soils").iter("th") if th.text and th.get("scope") == "col"]
        self.assertEqual(heads, ["number", "dry_sand", "sandy_loam_15"])
        page = self.report("a", "b")
        self.assertEqual(page.rows("differences"), {"setting": ["a", "b"], "soil.name": ["dry_sand", "sandy_loam_15"],
                                                    "objects.left.slip": ["0.2", "0.4"], "cache.slots": ["16", "8"]})
        self.copy("a")
        page = self.report("a", self.folder / "a")
        self.assertEqual(page.sentences("differences"), ["No setting differs."])
        run = self.json_of("a")
        run["store"]["base"] = "/other.furrow"
        (self.folder / "a/run.json").write_text(json.dumps(run))
        self.assertEqual(self.report("a", self.folder / "a").sentences("differences"), ["No setting differs."])  # a copy of the same terrain
        run["store"]["began_on"] = {"deepest": 0.0841, "highest": 0.0123}
        (self.folder / "a/run.json").write_text(json.dumps(run))
        tells = "The drive began on ground that earlier drives had left, with ruts up to 84.1 mm deep and heaps up to 12.3 mm high."
        self.assertEqual(self.report("a", self.folder / "a").sentences("differences"), ["No setting differs.", f"{self.folder / 'a'}: {tells}"])
        self.assertEqual(self.report(self.folder / "a").sentences("notes")[0], tells)
        del run["store"]["began_on"]
        is_, run["store"]["base_hash"] = run["store"]["base_hash"], "0123456789abcdef"
        self.assertEqual(is_, json.loads(self.call("info", "flat.furrow", "--json"))["base_hash"])
        (self.folder / "a/run.json").write_text(json.dumps(run))
        self.assertEqual(self.report("a", self.folder / "a").rows("differences"), {"setting": ["a", str(self.folder / "a")], "base store": [
            f"flat.furrow ({is_})", "other.furrow (0123456789abcdef)"]})
        del run["store"]["base_hash"]  # of an older furrow
        (self.folder / "a/run.json").write_text(json.dumps(run))
        base = str((self.made / "flat.furrow").resolve())
        self.assertEqual(self.report("a", self.folder / "a").rows("differences"), {"setting": ["a", str(self.folder / "a")], "base store": [base, "/other.furrow"]})

    # --- a drive that was gone on with ---

    def test_a_resumed_drive_is_whole(self):
        self.call("drive", "scene.yaml", "-o", "parts", "--overlay", "parts.furrow", "--steps", "70")
        page = self.report("parts")
        self.assertEqual(page.rows("run")["steps"], [70])
        self.assertIn("The ground across the way", page.plots("rut"))
        shutil.copytree(self.made / "parts", self.folder / "before")
        self.call("drive", "scene.yaml", "-o", "parts", "--overlay", "parts.furrow", "--resume")
        page, whole = self.report("parts"), self.report("a")
        self.assertEqual(page.rows("run")["resumed from step"], [70])
        self.assertNotIn("resumed from step", whole.rows("run"))
        self.assertIn("--resume", " ".join(page.sentences("notes")))
        for name in ("curves", "rut"):
            self.assertEqual({title: plot.curves for title, plot in page.plots(name).items()},
                             {title: plot.curves for title, plot in whole.plots(name).items()})
        self.assertEqual(page.rows("volume"), {**whole.rows("volume"), "": ["parts"]})
        self.assertEqual(self.ground(page)[2].rows, self.ground(whole)[2].rows)
        # The store has gone on since, so it does not show what the first part left.
        self.without_plots(self.report("before", cwd=self.folder), "rut", "was changed after this drive")

    @long
    def test_a_drive_by_two_processes(self):
        command = [FURROW, "drive", "scene.yaml", "-o", "two", "--overlay", "two.furrow", "--set", "end_time=1"]
        if shutil.which("mpirun") is None:
            self.skipTest("no mpirun here")
        result = subprocess.run(["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2", *command], cwd=self.made, capture_output=True, text=True, timeout=280)
        if "no MPI" in result.stderr or "ranks" not in (self.json_of("two") if result.returncode == 0 else {}):
            self.skipTest("this build has no MPI")
        run = self.json_of("two")
        self.assertEqual(run["store"]["file"], str((self.made / "two.furrow").resolve()))
        page = self.report("two")
        self.assertEqual(page.rows("results")["ranks"], [2])
        self.assertIn("The ground across the way", page.plots("rut"))

    # --- what is not trusted ---

    def test_names_are_text(self):
        evil = "a<script>alert('1')</script>&amp;\"'"
        shutil.copytree(self.made / "a", self.folder / evil.replace("/", "_"))
        folder = evil.replace("/", "_")
        path = self.folder / folder / "run.json"
        run = json.loads(path.read_text())
        run["scene"]["file"] = "</td><img src=x onerror=alert(1)>\u0001\u0085\ufffe"
        run["scene"]["values"] = {"</th><b>": "<i>", "x" * 5000: "y" * 100000}
        run["notes"] = ["</p><script src='https://example.org/x.js'></script>", 3, None]
        run["gl"]["renderer"] = "]]>&#0;<!--"
        run["soils"][0]["name"] = "<b>"
        run["soils"][0]["<i>"] = "<u>"
        run["objects"] = {"<b>": run["objects"]["left"], "left": 3, "way": {"way": [[1, 2], ["x", 3]]}, "none": {"way": [[]]}}
        path.write_text(json.dumps(run))
        raw = path.read_bytes().replace(b"]]>&#0;", b"]]>&#0;\xff\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80\xe2\x82")
        path.write_bytes(raw)
        page = self.report(folder, cwd=self.folder)
        self.assertEqual(page.root.find("body/h1").text, folder)
        self.assertIn("<script src='https://example.org/x.js'></script>", page.sentences("notes")[0])
        self.assertEqual(page.rows("settings")["</th><b>"], ["<i>"])
        self.assertRegex(page.rows("results")["GL renderer"][0], r"^\]\]>&#0;\?+<!--$")

    def test_numbers_are_checked(self):
        self.copy("a")
        path = self.folder / "a/run.json"
        text = path.read_text()
        for old, new in sampled((('"seconds":', '"seconds": 1e999, "was":'), ('"edges":', '"edges": [3, 2], "was":'), ('"counts":', '"counts": [-1], "was":'),
                         ('"volume":', '"volume": [1, {"quanta": 3}], "was":'), ('"cache":', '"cache": "none", "was":'), ('"soils":', '"soils": {"a": [1]}, "was":'),
                         ('"spacing":', '"spacing": -1, "was":'), ('"spacing":', '"spacing": 1e-300, "was":'), ('"values":', '"values": [[1]], "was":'),
                         ('"edges":', '"edges": [1e-320, 1e308], "was":'), ('"objects":', '"objects": [1, [2]], "was":'), ('"step_ms":', '"step_ms": {"p50": {}}, "was":'),
                         ('"way":', '"way": [[1e308, 1e308], [-1e308, -1e308]], "was":'), ('"scene":', '"scene": 7, "was":'))):
            self.assertIn(old, text)
            path.write_text(text.replace(old, new, 1))
            page = self.report("a", cwd=self.folder)
            self.assertNotIn("nan", re.sub(r"data:image/png;base64,[^\"]*", "", page.text).replace("Adhesion", ""), new)
            self.assertNotRegex(page.text, r"\d inf|[ML]inf")
        path.write_text(text)
        rows = self.folder / "a/objects.csv"
        lines = rows.read_text().splitlines(keepends=True)
        for cell in ("1e308", "-1e308", "1e-320", "nan", "1e29"):
            for column in sampled((2, 5, 6, 12)):
                changed = lines[20].split(",")
                changed[column] = cell
                rows.write_text("".join(lines[:20] + [",".join(changed)] + lines[21:]))
                if cell == "nan" and column == 2:
                    self.assertIn("a/objects.csv:21: ", self.refused(3, "report", "a", "-o", "page.html"))
                    continue
                plots = self.report("a", cwd=self.folder).plots("curves")
                self.assertTrue(all(math.isfinite(x + y) for plot in plots.values() for curve in plot.curves for x, y in curve))

    def test_rows_that_are_none_are_told_with_their_line(self):
        self.copy("a")
        path = self.folder / "a/objects.csv"
        lines = path.read_text().splitlines(keepends=True)
        for name, changed, line in (("cells", lines[:3] + ["1,2,3\n"] + lines[3:], 4), ("number", lines[:2] + [re.sub(r"^((?:[^,]*,){5})", r"\1x", lines[2])] + lines[3:], 3),
                                    ("back", lines + [lines[1]], len(lines) + 1), ("columns", ["t,name,x,y\n"] + lines[1:], 1),
                                    ("zero", lines[:2] + ["0,le\0ft\n"] + lines[2:], 3)):
            path.write_text("".join(changed))
            error = self.refused(3, "report", "a", "-o", "page.html")
            self.assertIn(f"a/objects.csv:{line}: ", error, name)
            self.assertFalse((self.folder / "page.html").exists())
        # A line that a kill has torn is none.
        path.write_text("".join(lines) + "4.05,lef")
        self.assertEqual(self.report("a", cwd=self.folder).plots("curves").keys(), self.report("a").plots("curves").keys())
        path.write_text(lines[0])
        self.without_plots(self.report("a", cwd=self.folder), "curves", "^No curves: ")
        # A pipe that nobody writes to is not waited for.
        path.unlink()
        os.mkfifo(path)
        self.without_plots(self.report("a", cwd=self.folder), "curves", "^No curves: ")

    def test_what_is_no_drive_is_refused_and_nothing_is_left(self):
        self.copy("a")
        (self.folder / "empty").mkdir()
        for name, text in (("torn", '{"ended": "complete", '), ("list", "[]"), ("other", '{"steps": 3}'), ("nothing", ""), ("deep", "[" * 100000)):
            (self.folder / name).mkdir()
            (self.folder / name / "run.json").write_text(text)
        self.assertIn("empty: there is no run.json in it; give a folder that furrow drive left", self.refused(3, "report", "empty", "-o", "page.html"))
        for name in ("torn", "list", "other", "nothing", "deep"):
            self.assertIn(f"{name}/run.json: is no run.json of a drive", self.refused(3, "report", "a", name, "-o", "page.html"))
        self.refused(3, "report", "absent", "-o", "page.html")
        self.refused(2, "report", "a")
        self.refused(2, "report", "-o", "page.html")
        self.refused(2, "report", "a", "a", "-o", "page.html")
        self.refused(2, "report", "a", "-o", "empty")
        self.assertIn("at most 8", self.refused(2, "report", *"123456789", "-o", "page.html"))
        self.refused(1, "report", "a", "-o", "absent/page.html")
        full = subprocess.run([FURROW, "report", "a", "-o", "page.html"], cwd=self.folder, capture_output=True, text=True, timeout=60,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000)))
        self.told(1, full)
        self.assertEqual([path.name for path in self.folder.iterdir() if "page" in path.name], [])
        (self.folder / "page.html").write_text("old")
        self.refused(3, "report", "torn", "-o", "page.html")
        self.assertEqual((self.folder / "page.html").read_text(), "old")
        self.assertEqual(self.ok("report", "a", "-o", "page.html"), "page.html: 1 drive\n")
        run = json.loads((self.folder / "a/run.json").read_text())
        run["store"]["file"] = "gone.furrow"
        (self.folder / "a/run.json").write_text(json.dumps(run))
        for damage in (b"", b"GIF89a", (self.folder / "a/map.png").read_bytes()[:20], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + b"\0" * 8):
            (self.folder / "a/map.png").write_bytes(damage)
            self.assertEqual(self.report("a", cwd=self.folder).sentences("map"), ["No map: map.png is no PNG."])


if __name__ == "__main__":
    main()
