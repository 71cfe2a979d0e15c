"""furrow report of bodies that carry soil: its figures are closed forms of the rows, and the rows are those of the drive."""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, main
from report import Page

BUCKET = pathlib.Path(__file__).resolve().parents[2] / "tools/scenes/vehicles/excavator_bucket.obj"
UNIT_WEIGHT, GRAVITY = 15000, 9.81
SCENE = """scene: 1
time_step: 0.02
end_time: 7
spacing: 0.03125
soil: {name: sandy_loam_15, unit_weight: 15000}
redistribute: {model: scm}
store: flat.furrow
objects:
  - {name: bucket, shape: {mesh: {file: bucket.obj}}, carry: true, path: {file: bucket.csv}}
  - {name: plate, shape: {box: {size: [0.4, 0.5, 0.0625]}}, carry: true, path: {file: plate.csv}}
  - {name: ball, shape: {sphere: {radius: 0.2}}, path: {points: [[4, 10], [6, 10]], speed: 1}, sink: 0.05}
output: {forces: 50}
"""
# The bucket looks back: its lip is at its back, so it cuts forward. It fills, is lifted and goes away. The plate digs with its edge, and is lifted.
WAYS = {"bucket.csv": [(0, 4, 4, 0.4, 180, 40, 0), (0.5, 4, 4, 0.15, 180, 40, 0), (3, 5, 4, 0.12, 180, 25, 0), (4.5, 5.3, 4, 0.35, 180, -5, 0), (5.5, 5.3, 4, 1, 180, -5, 0),
                       (6.5, 6.3, 4, 1, 180, -5, 0), (7, 6.3, 4, 1, 180, 100, 0)],
        "plate.csv": [(0, 4, 7, -0.05, 0, 0, 0), (2, 5, 7, -0.05, 0, 0, 0), (4, 5, 7, 0.7, 0, 0, 0), (7, 5, 7, 0.7, 0, 0, 0)]}
HEAD = "t,name,x,y,z,sinkage,fx,fy,fz,tx,ty,tz,slip,contact_area,load,soil,state,residual,work,carried,carried_weight\n"


# A tub of 0.4 x 0.3 x 0.2 m inside, of five plates of 2 cm; its body is turned in the model's first pose, and its level attitude is its own.
TUB = """<mujoco model="tub"><worldbody><body name="base" pos="0 0 0.5"><freejoint/><geom name="skid" type="box" size="0.5 0.4 0.1" mass="100"/>
<body name="tub" pos="0 0 1" euler="0 -30 0"><joint name="tilt" axis="0 1 0" damping="100" stiffness="10000"/>
<geom name="floor" type="box" size="0.22 0.17 0.01" pos="0 0 -0.01" mass="5"/>
<geom name="front" type="box" size="0.01 0.17 0.1" pos="0.21 0 0.1" mass="2"/><geom name="back" type="box" size="0.01 0.17 0.1" pos="-0.21 0 0.1" mass="2"/>
<geom name="left" type="box" size="0.2 0.1 0.01" pos="0 0.16 0.1" euler="90 0 0" mass="2"/><geom name="right" type="box" size="0.2 0.01 0.1" pos="0 -0.16 0.1" mass="2"/>
</body></body></worldbody></mujoco>
"""
TUBS = """scene: 1
time_step: 0.002
end_time: 0.1
spacing: 0.0625
soil: {name: sandy_loam_15}
redistribute: {model: scm}
store: flat.furrow
vehicles:
  - {name: car, model: tub.xml, start: {at: [8, 8]}, soil: [skid, floor, front, back, left, right], carry: [floor, front, back, left, right]}
output: {forces: 50}
"""


class Digging(FurrowTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="furrow-digging-"))
        cls.addClassCleanup(shutil.rmtree, cls.made, ignore_errors=True)
        cls.call("synth", "-o", "flat.furrow", "--posts", "65x65", "--spacing", "0.25", "--kind", "plain", "--relief", "0")
        shutil.copy(BUCKET, cls.made / "bucket.obj")
        for name, rows in WAYS.items():
            (cls.made / name).write_text("t,x,y,z,yaw,pitch,roll\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
        (cls.made / "scene.yaml").write_text(SCENE)
        cls.call("drive", "scene.yaml", "-o", "dig", "--overlay", "dig.furrow")

    @classmethod
    def call(cls, *arguments):
        result = subprocess.run([FURROW, *arguments], cwd=cls.made, capture_output=True, text=True, timeout=280)
        if result.returncode != 0:
            raise AssertionError(result.stderr)
        return result.stdout

    def report(self, *folders):
        self.ok("report", *folders, "-o", self.folder / "page.html", cwd=self.folder)
        return Page(self.folder / "page.html")

    def rows_of(self, name):
        with open(self.made / "dig/objects.csv", newline="") as lines:
            return [{key: float(value) if key not in ("name", "soil", "state") and value else value for key, value in row.items()}
                    for row in csv.DictReader(lines) if row["name"] == name]

    def run_of(self):
        return json.loads((self.made / "dig/run.json").read_text())

    # --- the rows ---

    def test_only_bodies_that_carry_have_the_columns(self):
        self.assertEqual((self.made / "dig/objects.csv").read_text().splitlines()[0] + "\n", HEAD)
        for row in self.rows_of("ball"):
            self.assertEqual([row[name] for name in ("work", "carried", "carried_weight")], ["", "", ""])
        (self.made / "plain.yaml").write_text(SCENE.replace(", carry: true", "").replace("end_time: 7", "end_time: 0.1"))
        self.call("drive", "plain.yaml", "-o", "plain", "--overlay", "plain.furrow")
        self.assertEqual((self.made / "plain/objects.csv").read_text().splitlines()[0], HEAD.split(",work")[0])
        self.assertNotIn("digging", Page(self.page_of("plain")).sections())

    def page_of(self, name):
        self.ok("report", self.made / name, "-o", self.folder / "page.html")
        return self.folder / "page.html"

    def test_a_lifted_load_weighs_what_it_is(self):
        """In the air the soil's whole force is the weight of what is aboard, and the body does no work on the soil."""
        for name, since in (("plate", 4), ("bucket", 5.6)):
            rows = [row for row in self.rows_of(name) if since < row["t"] < 6.4]
            self.assertGreater(min(row["carried"] for row in rows), 0.002)
            for row in rows:
                self.assertAlmostEqual(row["carried_weight"], UNIT_WEIGHT * row["carried"], delta=1e-7 * row["carried_weight"])
                self.assertAlmostEqual(row["fz"], -row["carried_weight"], delta=1e-7 * row["carried_weight"])
            self.assertEqual(len({row["work"] for row in rows}), 1)
        last, told = self.rows_of("plate")[-1], self.run_of()["objects"]["plate"]["carried"]
        self.assertAlmostEqual(last["carried"], told["volume"], delta=1e-8 * told["volume"])
        self.assertEqual(told["capacity"], 0)
        self.assertEqual(told["gravity"], GRAVITY)

    def test_the_work_is_the_force_over_the_way(self):
        """The plate does not turn: its work is the cutting force times the way, summed over rows."""
        rows = self.rows_of("plate")
        told = rows[-1]["work"]
        summed = 0
        for a, b in zip(rows, rows[1:]):
            cut = [[row["fx"], row["fy"], row["fz"] + row["carried_weight"]] for row in (a, b)]
            summed -= sum((cut[0][k] + cut[1][k]) / 2 * (b[axis] - a[axis]) for k, axis in enumerate("xyz"))
        print(f"work {told:g} J, of the rows {summed:g} J", file=sys.stderr)
        self.assertGreater(told, 100)
        self.assertAlmostEqual(told, summed, delta=0.02 * told)

    def test_the_capacity_is_that_of_the_mesh(self):
        """The bucket's inside is a prism, so its capacity is its profile's area times its width."""
        corners = [tuple(map(float, line.split()[1:])) for line in BUCKET.read_text().splitlines() if line.startswith("v ")]
        inside, width = [(x, z) for x, y, z in corners[14:21]], 2 * corners[14][1]
        area = abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(inside, inside[1:] + inside[:1]))) / 2
        told = self.run_of()["objects"]["bucket"]["carried"]["capacity"]
        print(f"capacity {told:g}, closed form {area * width:g} m3", file=sys.stderr)
        self.assertAlmostEqual(told, area * width, delta=0.01 * area * width)

    def test_plates_of_one_body_are_one_bucket(self):
        (self.made / "tub.xml").write_text(TUB)
        (self.made / "tubs.yaml").write_text(TUBS)
        self.call("drive", "tubs.yaml", "-o", "tubs", "--overlay", "tubs.furrow")
        geoms = json.loads((self.made / "tubs/run.json").read_text())["vehicles"]["car"]["carried"]["geoms"]
        self.assertEqual(sorted(geoms), ["car.back", "car.floor", "car.front", "car.left", "car.right"])
        for told in geoms.values():
            self.assertAlmostEqual(told["capacity"], 0.4 * 0.3 * 0.2, delta=0.01 * 0.024)
        shutil.copytree(self.made / "tubs", self.folder / "tubs")
        told = self.report("tubs").rows("digging")
        self.assertEqual(told["of the whole drive"], ["car.floor", "car.front", "car.back", "car.left", "car.right"])
        self.assertNotIn("car.skid", told["of the whole drive"])

    # --- the page ---

    def test_the_page_has_the_figures_of_the_rows(self):
        shutil.copytree(self.made / "dig", self.folder / "dig")
        page, run = self.report("dig"), self.run_of()
        told, plots = page.rows("digging"), page.plots("digging")
        bodies = {"bucket": 0, "plate": 1}
        for name, at in bodies.items():
            rows = self.rows_of(name)
            most = max(row["carried"] for row in rows)
            self.assertAlmostEqual(told["most that was aboard, m3"][at], most, delta=1e-9)
            self.assertAlmostEqual(told["most that was aboard, kg"][at], most * UNIT_WEIGHT / GRAVITY, delta=1e-4 * most * 1500)
            self.assertAlmostEqual(told["aboard at the end, m3"][at], rows[-1]["carried"], delta=1e-9)
            self.assertAlmostEqual(told["horizontal cutting force: largest, N"][at], max(math.hypot(row["fx"], row["fy"]) for row in rows), delta=1e-3)
            curve = dict((round(x, 2), y) for x, y in plots["carried mass over time"].curves[-1 - at])
            self.assertAlmostEqual(max(curve.values()), most * UNIT_WEIGHT / GRAVITY, delta=plots["carried mass over time"].grain(1))
        self.assertAlmostEqual(told["largest fill, share of the struck capacity"][0], max(row["carried"] for row in self.rows_of("bucket")) / run["objects"]["bucket"]["carried"]["capacity"], delta=1e-9)
        self.assertEqual(told["largest fill, share of the struck capacity"][1], "–")
        self.assertEqual(set(plots), {"carried mass over time", "bucket fill over time", "horizontal cutting force over time", "whole cutting force over time", "work on the soil over time"})
        self.assertGreater(told["bucket, 1"][-1], 0.9 * told["bucket, 1"][3])
        self.assertEqual(told["plate, 1"][-1], "–")  # what slides off its edges is no dump

    def closed_form(self):
        """A bucket that takes 60 l over 4 m at 800 N, spills 10 l, and dumps, where it pushes at 200 N; then 40 l over 2 m at 500 N. It spills 10 l and keeps 30. Rows each 0.1 s, at 1 m/s."""
        shutil.copytree(self.made / "dig", self.folder / "dig")
        work = 0
        with open(self.folder / "dig/objects.csv", "w") as out:
            out.write(HEAD)
            for i in range(201):
                t = i / 10
                digs = 800 if 1 < t <= 5 else 200 if 8 < t <= 8.5 else 500 if 12 < t <= 14 else 0
                work += digs * 0.1
                carried = 0.06 * (t - 1) / 4 if 1 < t <= 5 else 0.06 - 0.02 * (t - 5) if 5 < t <= 5.5 else 0.05 if 5 < t <= 8 else 0.05 * (8.9 - t) / 0.9 if 8 < t <= 8.9 else 0.04 * (t - 12) / 2 if 12 < t <= 14 else 0.04 - 0.02 * (t - 14) if 14 < t <= 14.5 else 0.03 if t > 14 else 0
                weight = UNIT_WEIGHT * carried
                out.write(f"{t},bucket,{t},4,{1 if 5 < t < 9 else 0},0,{-digs * 0.6:.9g},{-digs * 0.8:.9g},{digs * 0.75 - weight:.9g},0,0,0,0,0.1,,sandy_loam_15,touching,0,{work:.9g},{carried:.9g},{weight:.9g}\n")

    def test_cycles_forces_and_energy_are_those_of_the_closed_form(self):
        self.closed_form()
        run = json.loads((self.folder / "dig/run.json").read_text())
        run["objects"]["bucket"]["carried"]["capacity"] = 0.04
        (self.folder / "dig/run.json").write_text(json.dumps(run))
        page = self.report("dig")
        told, plots = page.rows("digging"), page.plots("digging")
        mass = UNIT_WEIGHT / GRAVITY
        for label, value in {"struck capacity, m3": 0.04, "most that was aboard, m3": 0.06, "most that was aboard, kg": 0.06 * mass, "largest fill, share of the struck capacity": 1.5,
                             "brought in all cycles, m3": 0.08, "aboard at the end, m3": 0.03, "horizontal cutting force: largest, N": 800,
                             "horizontal cutting force: mean while it digs, N": (40 * 800 + 5 * 200 + 20 * 500) / 65, "whole cutting force: largest, N": 1000,
                             "whole cutting force: mean while it digs, N": (40 * 1000 + 5 * 250 + 20 * 625) / 65, "time in which it digs, s": 6.5, "energy of digging, J": 4200,
                             "energy of digging for each m3 that it brought, J/m3": 4200 / 0.08}.items():
            self.assertAlmostEqual(told[label][0], value, delta=1e-6 * value, msg=label)
        first, second = told["bucket, 1"], told["bucket, 2"]
        #     fills from, to, place, m3, kg, fill, J, J/m3, held s, m, dumped from, to, place, m3
        for got, value in zip(first, [1, 5.4, "2.70, 4.00", 0.05, 0.05 * mass, 1.25, 3200, 64000, 2.6, 2.6, 8, 8.9, "8.50, 4.00", 0.05]):
            self.assertEqual(got, value) if isinstance(value, str) else self.assertAlmostEqual(got, value, delta=1e-6 * value)
        for got, value in zip(second, [12, 14.4, "12.80, 4.00", 0.03, 0.03 * mass, 0.75, 1000, 1000 / 0.03, 5.6, 5.6, "–", "–", "–", "–"]):
            self.assertEqual(got, value) if isinstance(value, str) else self.assertAlmostEqual(got, value, delta=1e-6 * value)
        self.assertNotIn("bucket, 3", told)
        for name, value in (("horizontal cutting force", 800), ("whole cutting force", 1000), ("carried mass", 0.06 * mass), ("bucket fill", 1.5), ("work on the soil", 4.3)):
            plot = plots[f"{name} over time"]
            self.assertAlmostEqual(max(y for _, y in plot.curves[0]), value, delta=plot.grain(1))
        # The soil's energy in the other section is the same.
        self.assertAlmostEqual(page.rows("curves")["energy into the soil, kJ"][0], 4.3, delta=1e-6)

    def test_what_is_not_known_is_said(self):
        self.closed_form()
        path, run = self.folder / "dig/objects.csv", json.loads((self.folder / "dig/run.json").read_text())
        del run["objects"]["bucket"]["carried"]["capacity"]
        (self.folder / "dig/run.json").write_text(json.dumps(run))
        text = path.read_text()
        path.write_text(text.replace(",work,", ",other,"))
        page = self.report("dig")
        self.assertNotIn("energy of digging, J", page.rows("digging"))
        self.assertNotIn("bucket fill over time", page.plots("digging"))
        self.assertIn("No energy of digging", " ".join(page.sentences("digging")))
        self.assertIn("No fill where there is no struck capacity", " ".join(page.sentences("digging")))
        path.write_text("".join(",".join(line.split(",")[:-3]) + "\n" for line in text.splitlines()))
        self.assertEqual(self.report("dig").sentences("digging"), ["No digging: objects.csv has no rows of what is aboard; set output.forces in the scene."])

    def test_drives_beside_each_other(self):
        self.closed_form()
        shutil.copytree(self.made / "dig", self.folder / "other")
        page = self.report("dig", "other")
        self.assertIn("dig: bucket, 1", page.rows("digging"))
        self.assertIn("other: plate, 1", page.rows("digging"))
        self.assertEqual(len(page.plots("digging")["work on the soil over time"].curves), 3)


if __name__ == "__main__":
    main()
