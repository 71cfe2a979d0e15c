"""furrow report of folders that this test makes: a tow test's pull against slip, left and right sides, how a page opens, and what a notebook calls. Figures are closed forms of the rows."""
import json
import math
import os
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, largest, main, use_package, write_png16
from report import Page

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOLDS = ((0.1, 100.0), (0.2, 180.0), (0.35, 220.0))  # slip, N of the load car
RESISTS, SPEED, STEP = 30.0, 0.5, 0.1                # N more on the wheels than it pulls; m/s; s
YAW = 30.0
WHEELS = {"a": (0.3, 0.6), "b": (0.3, -0.6), "c": (-0.3, 0.6), "d": (-0.3, -0.6)}  # ahead and to the left of the vehicle's place, m


def tow(folder, name="car"):
    """A vehicle that a load car holds to one speed for 2 s at each slip, along a level way."""
    folder.mkdir(parents=True)
    ahead = math.cos(math.radians(YAW)), math.sin(math.radians(YAW))
    vehicles, objects = ["t,name,x,y,z,roll,pitch,yaw,vx,vy,vz,kinetic,work,u:tow,f:tow\n"], ["t,name,x,y,z,sinkage,fx,fy,fz,tx,ty,tz,slip,contact_area,load,soil,state,residual,work\n"]
    for i in range(int(2 / STEP) * len(HOLDS)):
        slip, pull = HOLDS[int(i * STEP / 2 + 1e-9)]
        t, way = i * STEP, SPEED * i * STEP
        x, y = 5 + way * ahead[0], 7 + way * ahead[1]
        vehicles.append(f"{t:.6g},{name},{x:.9g},{y:.9g},10,0,0,{YAW},{SPEED * ahead[0]:.9g},{SPEED * ahead[1]:.9g},0,1,{20 * way:.9g},{-SPEED * (1 - slip):.9g},{pull}\n")
        for wheel, (forward, left) in WHEELS.items():
            force = (pull + RESISTS) / len(WHEELS)
            objects.append(f"{t:.6g},{name}.{wheel},{x + forward * ahead[0] - left * ahead[1]:.9g},{y + forward * ahead[1] + left * ahead[0]:.9g},10,0.02,{force * ahead[0]:.9g},{force * ahead[1]:.9g},500,"
                           f"0,0,0,{slip},0.1,,dry_sand,touching,0,{3 * way:.9g}\n")
    (folder / "vehicles.csv").write_text("".join(vehicles))
    (folder / "objects.csv").write_text("".join(objects))
    (folder / "run.json").write_text(json.dumps({"ended": "complete", "steps": 60, "simulated": 6, "rtf": 2.5, "scene": {"values": {}}, "volume": {"removed": 0.5},
                                                 "vehicles": {name: {"mass": 200, "gravity": 9.81, "distance": 2.95}}}))


class Pull(FurrowTest):
    def report(self, *folders):
        self.ok("report", *folders, "-o", "page.html")
        return Page(self.folder / "page.html")

    def test_a_tow_test_has_its_pull_against_slip(self):
        tow(self.folder / "out")
        page = self.report("out")
        self.assertIn("pull", page.sections())
        rows = page.rows("pull")
        for number, (slip, pull) in enumerate(HOLDS, 1):
            told = rows[f"car, {number}"]
            self.assertAlmostEqual(told[0], slip, delta=1e-9)
            self.assertAlmostEqual(told[1], pull, delta=1e-9)
            self.assertAlmostEqual(told[2], pull + RESISTS, delta=1e-6)
        plot = page.plots("pull")["Pull over slip"]
        self.assertEqual((len(plot.curves), plot.dots), (2, len(HOLDS)))
        for (x, y), (slip, pull) in zip(plot.curves[1], HOLDS):  # the first lies on top
            self.assertAlmostEqual(x, slip, delta=plot.grain(0))
            self.assertAlmostEqual(y, pull, delta=plot.grain(1))
        text = (self.folder / "out/vehicles.csv").read_text()
        (self.folder / "out/vehicles.csv").write_text(text.replace(",u:tow,", ",u:other,"))
        self.assertNotIn("pull", self.report("out").sections())

    def test_a_wheel_whose_slip_changes_has_its_pull_over_it(self):
        tow(self.folder / "out", "rig")
        (self.folder / "out/vehicles.csv").unlink()
        page = self.report("out")
        plot = page.plots("pull")["Pull over slip"]
        self.assertEqual(len(plot.curves), 0)
        self.assertGreater(plot.dots, 100)
        self.assertNotIn("pull-table", page.sections())

    def test_left_and_right_are_told_apart(self):
        tow(self.folder / "out")
        page = self.report("out")
        legend = ["".join(item.itertext()).strip() for item in page.section("curves").iter("li")]
        self.assertEqual(legend, ["car.a (left)", "car.b (right)", "car.c (left)", "car.d (right)"])
        classes = page.plots("curves")["drawbar pull over time"].classes[::-1]
        self.assertEqual(classes, [("curve s0", ""), ("curve s0", "7 4"), ("curve s1", ""), ("curve s1", "7 4")])
        results = page.rows("results")
        self.assertAlmostEqual(results["car: mean drawbar pull, sum of its wheels, N"][0], HOLDS[-1][1] + RESISTS, delta=1e-4)
        for side in ("left", "right"):
            self.assertAlmostEqual(results[f"car: mean drawbar pull, sum of its {side} wheels, N"][0], (HOLDS[-1][1] + RESISTS) / 2, delta=1e-4)
        self.report("out")  # a wheel that is named for its side is taken at its word
        text = (self.folder / "out/objects.csv").read_text()
        (self.folder / "out/objects.csv").write_text(text.replace("car.a", "car.front_right").replace("car.b", "car.front_left"))
        legend = ["".join(item.itertext()).strip() for item in self.report("out").section("curves").iter("li")]
        self.assertEqual(legend, ["car.front_right", "car.front_left", "car.c (left)", "car.d (right)"])

    def test_a_page_opens_with_pictures_and_four_numbers(self):
        tow(self.folder / "out")
        write_png16(self.folder / "out/frame-000030.png", 40, 20, lambda x, y: 500 * (x + y))
        write_png16(self.folder / "out/frame-000060.png", 2000, 100, lambda x, y: 20 * (x + y))
        (self.folder / "out/frame-000060.png.part").write_bytes(b"")
        page = self.report("out")
        self.assertEqual(page.sections()[0], "opening")
        images = list(page.section("opening").iter("img"))
        self.assertEqual([(image.get("width"), image.get("height")) for image in images], [("666", "33")])  # of one picture the middle one is the last one
        (self.folder / "out/frame-000045.png").write_bytes(b"GIF89a")
        page = self.report("out")
        self.assertEqual(len(list(page.section("opening").iter("img"))), 1)
        self.assertIn("frame-000045.png: is no picture that can be shown", " ".join(page.sentences("opening")))
        numbers = {"".join(item.itertext()).strip(): float(item.find("data").get("value")) for item in page.section("opening").iter("li")}
        self.assertEqual(len(numbers), 4)
        self.assertEqual(list(numbers.values())[0], 2.95)
        slip, sinkage, pull = list(numbers.values())[1:]
        self.assertAlmostEqual(slip, HOLDS[-1][0], delta=1e-9)
        self.assertAlmostEqual(sinkage, 20, delta=1e-9)
        self.assertAlmostEqual(pull, HOLDS[-1][1], delta=1e-9)
        sections = list(page.root.iter("section"))
        last_plot = largest(i for i, section in enumerate(sections) if page.plots(section.get("id")))
        self.assertTrue(all(i > last_plot for i, section in enumerate(sections) if list(section.iter("table"))))  # tables come last
        self.assertIn("The drive did not complete", " ".join(self.ended("failed").sentences("opening")))

    def ended(self, how):
        run = json.loads((self.folder / "out/run.json").read_text())
        (self.folder / "out/run.json").write_text(json.dumps({**run, "ended": how}))
        return self.report("out")

    def test_units_of_soils_are_those_of_a_scene(self):
        use_package()
        from furrow.report.tables import UNITS
        page = (ROOT / "src/scene/SCENE.md").read_text(encoding="utf-8")
        scene = {key: unit for key, unit in re.findall(r"^\| `soil\.(\w+)` \| [^|]* \| ([^|]*?) \|", page, re.M)}
        self.assertGreater(len(scene), 20)
        self.assertEqual({key: scene.get(key) for key in UNITS}, UNITS)

    def test_a_notebook_has_tables_and_the_same_page(self):
        use_package()
        import furrow
        from furrow.results import ResultsError
        tow(self.folder / "out")
        drive = furrow.load(self.folder / "out")
        self.assertEqual(len(drive.vehicles), 60)
        self.assertEqual(drive.objects.groupby("name", observed=True)["slip"].max().to_dict(), {f"car.{wheel}": 0.35 for wheel in WHEELS})
        self.assertAlmostEqual(float(drive.vehicles["f:tow"].iloc[-1]), HOLDS[-1][1])
        self.assertTrue(drive.sensors.empty and drive.volume.empty)
        self.assertEqual(drive.facts["steps"], 60)
        with open(self.folder / "out/vehicles.csv", "a") as file:
            file.write("7,car,to")  # a kill tore it
        self.assertEqual(len(furrow.load(self.folder / "out").vehicles), 60)
        self.assertRaises(ResultsError, furrow.load, self.folder / "absent")
        self.report("out")
        before = pathlib.Path.cwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)
        self.assertEqual(furrow.report("out", to="own.html"), pathlib.Path("own.html"))
        self.assertEqual((self.folder / "own.html").read_text(), (self.folder / "page.html").read_text())
        self.assertEqual(furrow.load("out").report("third.html"), pathlib.Path("third.html"))
        self.assertRaises(ResultsError, furrow.report, "out", "out")
        self.assertRaises(ResultsError, furrow.report, "out", "absent")
        self.assertRaises(ResultsError, furrow.report)

    def test_a_missing_package_is_one_line_that_names_it(self):
        tow(self.folder / "out")
        for missing in (["jinja2"], ["matplotlib", "pandas"]):
            for name in missing:
                (self.folder / f"{name}.py").write_text(f"raise ImportError('no {name}')\n")
            result = self.furrow("report", "out", "-o", "page.html", env={"PYTHONPATH": str(self.folder)})
            error = self.told(1, result)
            for name in missing:
                self.assertIn(f"python3-{name}", error)
                (self.folder / f"{name}.py").unlink()
            self.assertFalse((self.folder / "page.html").exists())

    def test_many_rows_are_read_in_parts(self):
        """Rows of several parts of a file make the same page as they do at once; a line that is none is told by its number behind the first part, too."""
        use_package()
        import furrow.report.rows as rows
        tow(self.folder / "out")
        whole = dict(rows.objects(str(self.folder / "out")))
        self.addCleanup(setattr, rows, "PART", rows.PART)
        rows.PART = 1000
        parts = dict(rows.objects(str(self.folder / "out")))
        self.assertEqual(list(parts), list(whole))
        for name, columns in whole.items():
            for column, values in columns.items():
                self.assertEqual([repr(value) for value in parts[name][column].tolist()], [repr(value) for value in values.tolist()])
        path = self.folder / "out/objects.csv"
        lines = path.read_text().splitlines(keepends=True)
        for change, why in ((lambda line: line.replace(",0.02,", ",x,"), "has a cell that is no number"), (lambda line: "0" + line[line.index(","):], "goes back in time"),
                            (lambda line: line.replace(",10,", ",nan,", 1), "does not tell when or where"), (lambda line: line.replace(",touching", ""), "as many columns")):
            path.write_text("".join([*lines[:150], change(lines[150]), *lines[151:]]))
            with self.assertRaisesRegex(Exception, rf"objects\.csv:151: .*{why}"):
                list(rows.objects(str(self.folder / "out")))


if __name__ == "__main__":
    main()
