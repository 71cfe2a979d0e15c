"""furrow rig at slip angles, at depths and at rakes: its rows are those of a drive by poses, a mirrored wheel has mirrored forces, a locked wheel does not turn."""
import csv
import json
import math
import xml.etree.ElementTree

from furrow_test import FurrowTest, main

WHEEL = "wheel: {radius: 0.25, width: 0.2}"
BLADE = "box: {size: [0.06, 0.8, 0.4]}"
SPACING = 0.02


class Angles(FurrowTest):
    def ok(self, *arguments, **options):
        result = self.furrow(*arguments, **options)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def rig(self, *arguments, shape=WHEEL, out="rig"):
        self.ok("rig", "-o", out, "--shape", shape, "--spacing", repr(SPACING), *arguments)
        xml.etree.ElementTree.parse(self.folder / out / "rig.svg")
        with open(self.folder / out / "rig.csv") as file:
            return [{key: value if key in ("soil", "state") else float(value or "nan") for key, value in row.items()} for row in csv.DictReader(file)]

    def driven(self, shape, z, yaw, pitch, slip, way):
        """Means of objects.csv over the last quarter of a drive by poses along +x at a height, in the object's own level axes."""
        self.ok("synth", "-o", "flat.furrow", "--posts", "129x129", "--spacing", repr(SPACING * 8), "--kind", "plain", "--relief", "0", "--overwrite")
        (self.folder / "poses.csv").write_text("".join(f"{t!r},{6 + x!r},9.0,{z!r},{yaw!r},{pitch!r},0\n" for t, x in ((0, 0.0), (way / 0.1, way))))
        step = SPACING / 0.1
        slips = f"slip: {slip!r}, " if slip is not None else ""
        (self.folder / "scene.yaml").write_text(
            f"scene: 1\ntime_step: {step!r}\nend_time: {way / 0.1!r}\nspacing: {SPACING!r}\nsoil: {{name: dry_sand}}\nredistribute: {{model: scm}}\n"
            f"output: {{forces: {0.99 / step!r}}}\nobjects:\n  - {{name: a, shape: {{{shape}}}, {slips}path: {{file: poses.csv}}}}\n")
        self.ok("drive", "scene.yaml", "--store", "flat.furrow", "-o", "out")
        with open(self.folder / "out" / "objects.csv") as file:
            rows = [row for row in csv.DictReader(file) if float(row["x"]) >= 6 + 0.75 * way]
        mean = {key: sum(float(row[key]) for row in rows) / len(rows) for key in ("fx", "fy", "fz", "tx", "ty", "tz")}
        c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
        return {"drawbar": c * mean["fx"] + s * mean["fy"], "side": c * mean["fy"] - s * mean["fx"], "fz": mean["fz"], "against": -mean["fx"],
                "torque": s * mean["tx"] - c * mean["ty"], "overturning": c * mean["tx"] + s * mean["ty"], "aligning": mean["tz"]}

    def test_a_wheel_at_an_angle_is_what_a_drive_by_poses_tells(self):
        """The poses' slip counts the way along the wheel's plane: 1 - way cos a / rim is as much turn."""
        for row in self.rig("--slip-angle", "20,-50", "--slip=-0.5,0.4", "--load", "600"):
            angle, slip = row["slip_angle"], row["slip"]
            self.assertAlmostEqual(row["fz"], 600, delta=0.5)
            wanted = self.driven(WHEEL, 0.25 - row["sinkage"], angle, 0, 1 - math.cos(math.radians(angle)) * (1 - slip), 2.0)
            for key, value in wanted.items():
                scale = 600 * 0.25 if key in ("torque", "overturning", "aligning") else 600
                self.assertAlmostEqual(row[key], value, delta=0.015 * scale, msg=(angle, slip, key))

    def test_a_blade_is_what_a_drive_by_poses_tells(self):
        for rake in (90, 50):
            for row in self.rig("--depth", "0.1", "--yaw", "0,30", "--rake", repr(rake), "--way", "1", shape=BLADE):
                pitch = math.radians(90 - rake)
                reach = 0.03 * math.sin(pitch) + 0.2 * math.cos(pitch)
                wanted = self.driven(BLADE, reach - 0.1, row["slip_angle"], 90 - rake, None, 1.0)
                for key in ("against", "side", "fz", "overturning", "aligning"):
                    self.assertAlmostEqual(row[key], wanted[key], delta=0.01 * max(wanted["fz"], wanted["against"]), msg=(rake, row["slip_angle"], key))
                self.assertTrue(math.isnan(row["load"]) and row["depth"] == 0.1)
                self.assertLessEqual(row["against_least"], row["against"])
                self.assertLessEqual(row["against"], row["against_most"])
                self.assertGreater(row["against"], 0)
                self.assertGreater(row["heap"], 0.005)
                self.assertTrue(0 < row["heap_volume"] < 0.8 * 0.1 * 1.0 * 1.3)

    def test_a_mirrored_wheel_has_mirrored_forces(self):
        left, right = self.rig("--slip-angle", "25,-25", "--slip", "0.2", "--load", "600", "--set", "redistribute.bulldozing=0")
        for key in ("sinkage", "drawbar", "fz", "torque", "against"):
            self.assertAlmostEqual(left[key], right[key], delta=0.003 * abs(left[key]), msg=key)
        for key in ("side", "overturning", "aligning"):
            self.assertAlmostEqual(left[key], -right[key], delta=0.003 * max(abs(left[key]), 1), msg=key)
        self.assertGreater(left["side"], 50)  # its way leads to its right, so the soil holds it to its left
        self.assertAlmostEqual(left["against"], -(math.cos(math.radians(25)) * left["drawbar"] - math.sin(math.radians(25)) * left["side"]), delta=1e-3)
        gentle, = self.rig("--slip-angle", "4", "--slip", "0.3", "--load", "600")
        self.assertAlmostEqual(gentle["efficiency"], -gentle["against"] * 0.7 * 0.25 / gentle["torque"], delta=1e-6)

    def test_no_angle_is_the_rig_of_old(self):
        with_it = self.rig("--slip-angle", "0", "--slip", "0,0.3", "--load", "600", "--speed", "0.02")
        without = self.rig("--slip", "0,0.3", "--load", "600")
        for one, other in zip(with_it, without, strict=True):
            for key in ("sinkage", "drawbar", "torque", "fz"):
                self.assertAlmostEqual(one[key], other[key], delta=1e-6 * max(abs(other[key]), 1e-3))
        with open(self.folder / "rig" / "rig.csv") as file:
            self.assertTrue(file.readline().startswith("soil,load,slip,torque,sinkage,drawbar,side,fz,efficiency,deeper,state,slip_angle,"))

    def test_a_locked_wheel_and_one_along_its_axle(self):
        locked, dragged = self.rig("--slip", "locked,-999", "--load", "600")
        self.assertEqual(locked["slip"], -1000)
        for key in ("sinkage", "drawbar", "torque"):
            self.assertAlmostEqual(locked[key], dragged[key], delta=1e-3 * abs(dragged[key]))
        self.assertLess(locked["torque"], 0)
        still, turns = self.rig("--slip-angle", "90", "--slip", "locked,0.8", "--load", "300")
        self.assertAlmostEqual(still["drawbar"], 0, delta=0.03 * still["side"])  # nothing goes along its plane
        self.assertGreater(turns["drawbar"], 10 + still["drawbar"])        # its rim does
        self.assertGreater(still["side"], turns["side"])
        self.assertIn("locked", self.ok("rig", "-o", "rig", "--shape", WHEEL, "--slip", "locked", "--spacing", "0.04"))

    def test_any_shape_and_json(self):
        (self.folder / "block.obj").write_text("".join(f"v {x} {y} {z}\n" for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.1, 0.1)) + "".join(
            f"f {a} {b} {c} {d}\n" for a, b, c, d in ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))))
        for shape in ("sphere: {radius: 0.2}", "cylinder: {radius: 0.2, length: 0.3}", "capsule: {radius: 0.1, length: 0.3}", "ellipsoid: {radii: [0.2, 0.15, 0.1]}",
                      f"mesh: {{file: {self.folder}/block.obj}}", "box: {size: [0.4, 0.3, 0.2]}"):
            told = json.loads(self.ok("rig", "-o", "rig", "--shape", shape, "--spacing", "0.02", "--depth", "0.03,0.06", "--way", "0.6", "--json"))
            with open(self.folder / "rig" / "rig.csv") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual([row["depth"] for row in told["rows"]], [0.03, 0.06])
            for one, other in zip(told["rows"], rows, strict=True):
                self.assertEqual(set(one), set(other))
                for key, value in one.items():
                    self.assertEqual(other[key], "" if value is None else value if isinstance(value, str) else other[key], key)
                    if isinstance(value, float | int):
                        self.assertAlmostEqual(float(other[key]), value, delta=1e-8 * max(abs(value), 1e-6))
            self.assertGreater(told["rows"][1]["fz"], told["rows"][0]["fz"])
            self.assertEqual((told["spacing"], told["speed"]), (0.02, 0.1))

    def test_a_torque_finds_its_slip_at_an_angle(self):
        by_slip = self.rig("--slip-angle", "0,30", "--slip", "0.3", "--load", "600")
        for row in by_slip:
            found, = self.rig(f"--slip-angle={row['slip_angle']}", f"--torque={row['torque']}", "--load", "600", out="found")
            self.assertAlmostEqual(found["slip"], 0.3, delta=0.01)
            self.assertEqual(found["slip_angle"], row["slip_angle"])

    def test_measured_trials_go_to_their_angle(self):
        rows = self.rig("--slip-angle", "0,30", "--slip", "0,0.4", "--load", "600")
        text = "slip,slip_angle_deg,sinkage_mm,drag_N,lateral_N\n"
        for row in rows:
            off = 3 if row["slip_angle"] else 1
            text += f"{row['slip']},{row['slip_angle']},{row['sinkage'] * 1e3 + off},{-row['drawbar'] + 2 * off},{row['side'] - 3 * off}\n"
        (self.folder / "measured.csv").write_text(text + "0.2,90,50,0,0\n")
        told = self.ok("rig", "-o", "rig", "--shape", WHEEL, "--spacing", repr(SPACING), "--slip-angle", "0,30", "--slip", "0,0.4", "--load", "600", "--compare", "measured.csv")
        self.assertIn("at 600 N, 0 degrees, RMS: sinkage 1.00 mm, drawbar 2.00 N, side force 3.00 N\n", told)
        self.assertIn("at 600 N, 30 degrees, RMS: sinkage 3.00 mm, drawbar 6.00 N, side force 9.00 N\n", told)

    def test_what_is_wrong_is_told(self):
        for arguments, part in ((["--yaw", "3", "--slip-angle", "3"], "--slip-angle is the same"), (["--load", "3", "--depth", "0.1"], "loads and depths"),
                                (["--rake", "40"], "no rake"), (["--slip-angle", "200"], "angle: 200 is out of range; give -180 to 180"),
                                (["--depth=-1"], "depth: -1 is out of range"), (["--slip", "lock"], "--slip lock: is no number and no range"), (["--speed", "0"], "--speed"),
                                (["--rake", "0", "--shape", BLADE], "--rake")):
            with self.subTest(arguments=arguments):
                result = self.furrow("rig", "-o", "r", *arguments)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(part, result.stderr)


if __name__ == "__main__":
    main()
