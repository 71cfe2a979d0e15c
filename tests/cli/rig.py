"""furrow rig: its rows are those of a drive, closed forms hold, a torque finds its slip, and what is measured is drawn beside it."""
import csv
import math
import pathlib
import re
import signal
import subprocess
import time
import xml.etree.ElementTree

from furrow_test import FURROW, FurrowTest, long, main

WHEEL = "wheel: {radius: 0.32, width: 0.24}"


class Rig(FurrowTest):
    def ok(self, *arguments, **options):
        result = self.furrow(*arguments, **options)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def rig(self, *arguments, out="rig", wheel=WHEEL):
        """The rows of rig.csv, with numbers; NaN where a cell is empty."""
        self.ok("rig", "-o", out, *(["--shape", wheel] if wheel else []), *arguments)
        with open(self.folder / out / "rig.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([], [path.name for path in (self.folder / out).iterdir() if path.name not in ("rig.csv", "rig.svg")])
        xml.etree.ElementTree.parse(self.folder / out / "rig.svg")
        return [{key: value if key in ("soil", "state") else float(value or "nan") for key, value in row.items()} for row in rows]

    def driven(self, slip, load, spacing, way):
        """Means of objects.csv over the last quarter of a drive of the same wheel, on other ground, in another direction."""
        self.ok("synth", "-o", "flat.furrow", "--posts", "129x129", "--spacing", repr(spacing * 8), "--kind", "plain", "--relief", "0", "--overwrite")
        step = spacing / 0.2
        (self.folder / "scene.yaml").write_text(
            f"scene: 1\ntime_step: {step!r}\nend_time: {way / 0.2!r}\nspacing: {spacing!r}\nsoil: {{name: dry_sand}}\n"
            f"redistribute: {{model: scm}}\noutput: {{forces: {0.99 / step!r}}}\nobjects:\n"
            f"  - {{name: a, shape: {{{WHEEL}}}, load: {load!r}, slip: {slip!r}, path: {{points: [[6, 3], [6, {3 + way!r}]], speed: 0.2}}}}\n")
        self.ok("drive", "scene.yaml", "--store", "flat.furrow", "-o", "out")
        with open(self.folder / "out" / "objects.csv") as file:
            rows = [row for row in csv.DictReader(file) if float(row["y"]) >= 3 + 0.75 * way]
        mean = {key: sum(float(row[key]) for row in rows) / len(rows) for key in ("sinkage", "fy", "fz", "tx")}
        return mean["sinkage"], mean["fy"], mean["tx"], mean["fz"]

    def test_each_pass_sinks_less_than_the_one_before_and_pulls_more_in_soil_that_hardens(self):
        for hardening in (0, 1):
            found = []
            for passes in (1, 2, 3, 4):
                row, = self.rig("--load", "5000", "--slip", "0.2", "--passes", str(passes), "--spacing", "0.04",
                                "--set", f"redistribute.hardening={hardening}", "--set", "redistribute.loosening=0.67", wheel="wheel: {radius: 0.5, width: 0.3}")
                found.append((row["sinkage"], row["drawbar"]))
            deeper = [after[0] - before[0] for before, after in zip(found, found[1:])]
            self.assertTrue(deeper[0] > deeper[1] > deeper[2] > 0, found)
            if hardening:
                self.assertEqual(sorted(row[1] for row in found), [row[1] for row in found])

    def test_a_row_is_what_a_drive_tells(self):
        row, = self.rig("--slip", "0.2", "--load", "800", "--spacing", "0.02")
        wanted = self.driven(0.2, 800, 0.02, 2.56)
        for got, want, name in zip((row["sinkage"], row["drawbar"], row["torque"], row["fz"]), wanted, ("sinkage", "drawbar", "torque", "fz"), strict=True):
            self.assertAlmostEqual(got, want, delta=0.005 * abs(want), msg=name)

    def test_it_meets_closed_forms_at_three_spacings(self):
        """A wheel of r 0.32 m, b 0.24 m and 1 kN in dry_sand at slip 0.2: bench/CONVERGE.md's forms, by two integrals."""
        for spacing, share in (("0.04", 0.03), ("0.02", 0.02), ("0.01", 0.01)):
            row, = self.rig("--slip", "0.2", "--spacing", spacing)
            self.assertAlmostEqual(row["sinkage"], 0.04278, delta=0.04278 * share / 2)
            self.assertAlmostEqual(row["drawbar"], 205.5, delta=205.5 * share)
            self.assertAlmostEqual(row["fz"], 1000, delta=5)
            self.assertLess(abs(row["side"]), 1)
            self.assertAlmostEqual(row["efficiency"], row["drawbar"] * 0.8 * 0.32 / row["torque"], delta=1e-6)
            self.assertEqual(row["state"], "steady")

    @long
    def test_lanes_do_not_meet(self):
        """Each row is the same beside 17 others as alone: more lanes than a bed has."""
        slips = [round(-0.4 + 0.07 * i, 2) for i in range(18)]
        many = self.rig("--slip", ",".join(map(str, slips)), "--spacing", "0.04", "--soil", "lunar")
        self.assertEqual([row["slip"] for row in many], slips)
        for row in (many[0], many[9], many[17]):
            alone, = self.rig(f"--slip={row['slip']}", "--spacing", "0.04", "--soil", "lunar")
            for key in ("sinkage", "drawbar", "torque"):
                self.assertAlmostEqual(row[key], alone[key], delta=1e-3 * abs(alone[key]), msg=key)

    def test_a_torque_finds_its_slip(self):
        by_slip = self.rig("--slip", "-0.1:0.4:0.25", "--load", "500,1000", "--spacing", "0.04")
        self.assertEqual([(row["load"], row["slip"]) for row in by_slip], [(load, slip) for load in (500, 1000) for slip in (-0.1, 0.15, 0.4)])
        torques = ",".join(repr(row["torque"]) for row in by_slip[3:])
        by_torque = self.rig("--torque", torques, "--load", "1000", "--spacing", "0.04")
        for row, found in zip(by_slip[3:], by_torque, strict=True):
            self.assertAlmostEqual(found["slip"], row["slip"], delta=0.01)
            self.assertAlmostEqual(found["torque"], row["torque"], delta=max(0.005 * abs(row["torque"]), 0.005 * 0.05 * 1000 * 0.32) + 1e-6)
        far, = self.rig("--torque", "5000", "--spacing", "0.04")
        self.assertEqual((far["state"], far["torque"]), ("spins", 5000))
        self.assertTrue(math.isnan(far["slip"]))

    def test_rebound_and_a_rut_make_a_towed_wheel_s_resistance(self):
        """By the closed form of src/scene/scene_rebound.c, and of Bekker where the soil does not spring back. Without faces: a towed wheel is braked a little."""
        shape, soils = "wheel: {radius: 0.35, width: 0.22}", ("sandy_loam_15", "{name: sandy_loam_15, elastic_stiffness: 1e10}")
        result = self.furrow("rig", "-o", "rig", "--shape", shape, "--soil", ",".join(soils), "--load", "2207", "--torque", "0", "--spacing", "0.0275", "--set", "redistribute.faces=off")
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        told, = re.findall(r"soil\.elastic_stiffness: is not given.* springs back by about \S+ of (\S+) mm.* resistance is about (\d+) % less", result.stderr)
        with open(self.folder / "rig" / "rig.csv") as file:
            first, rigid = ({key: float(row[key]) for key in ("slip", "sinkage", "drawbar", "torque")} for row in csv.DictReader(file))
        k, n, b, r = 5270 / 0.22 + 1515040, 0.7, 0.22, 0.35
        bekker = (3 * 2207 / (b * k * (3 - n) * math.sqrt(2 * r))) ** (2 / (2 * n + 1))
        self.assertAlmostEqual(rigid["drawbar"], -b * k * bekker ** (n + 1) / (n + 1), delta=0.08 * 300)
        self.assertAlmostEqual(first["sinkage"] * 1e3, float(told[0]), delta=0.08 * float(told[0]))
        self.assertAlmostEqual(1 - first["drawbar"] / rigid["drawbar"], float(told[1]) / 100, delta=0.04)
        second, = self.rig("--soil", soils[0], "--load", "2207", "--torque", "0", "--spacing", "0.0275", "--passes", "2", "--set", "redistribute.faces=off", wheel=shape)
        self.assertLess(abs(second["torque"]), 0.001 * 2207 * r)  # soil that slides into the rut is a step of up to 0.7 N m
        self.assertTrue(0.8 * first["drawbar"] < second["drawbar"] < 0, (first, second))  # nearly all is pressed down already

    def test_soils_in_braces_settings_and_other_objects(self):
        own = "{name: dry_sand, cohesion: 500, janosi_shear: 0.02}"
        rows = self.rig("--soil", f"lunar,{own}", "--slip", "0,0.5", "--spacing", "0.04")
        self.assertEqual([row["soil"] for row in rows], ["lunar", "lunar", own, own])
        plain = self.rig("--soil", "lunar", "--slip", "0.5", "--spacing", "0.04", "--set", "redistribute.slip_sinkage=0")
        self.assertLess(plain[0]["sinkage"], rows[1]["sinkage"])
        boxes = self.rig("--load", "100,400", wheel="{box: {size: [0.4, 0.3, 0.2]}}")
        self.assertEqual([row["load"] for row in boxes], [100, 400])
        for row in boxes:
            self.assertTrue(math.isnan(row["slip"]) and math.isnan(row["torque"]))
            self.assertLess(row["drawbar"], 0)

    def test_numbers_in_a_wrong_unit_are_told_once(self):
        (self.folder / "mine.yaml").write_text("soil: {name: dry_sand, bekker_kphi: 9000, janosi_shear: 2}\n")
        result = self.furrow("rig", "-o", "rig", "--shape", WHEEL, "--soil", "mine.yaml", "--load", "50,100", "--spacing", "0.08")
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        for note in ("soil.bekker_kphi: 9000 N/m^(n+2) is less", "soil.janosi_shear: 2 m is more"):
            self.assertEqual(result.stderr.count(note), 1, result.stderr)

    def test_forces_of_a_wheel_that_is_not_carried_are_left_out(self):
        result = self.furrow("rig", "-o", "rig", "--shape", WHEEL, "--soil", "{name: dry_sand, bekker_kphi: 1528.43},dry_sand", "--load", "3000", "--slip", "0.2,0.5", "--spacing", "0.04")
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(self.folder / "rig" / "rig.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["state"] == "sunk" for row in rows], [True, True, False, False])
        for row in rows:
            for key in ("torque", "drawbar", "side", "efficiency"):
                self.assertEqual(row[key] == "", row["state"] == "sunk", (key, row))
        deepest = max(float(row["sinkage"]) for row in rows[:2])
        self.assertIn(f"furrow: note: rig: 2 of 4 rows are sunk, up to {deepest:.3g} m deep: the soil does not carry the load; bekker_kphi or the load is probably in a "
                      "wrong unit: give N/m^(n+2) and N\n", result.stderr)
        self.assertRegex(result.stdout, r"3000 +0\.200 +\d+\.\d+ +- +- +-  sunk\n")

    def test_a_soil_of_a_file_has_its_name(self):
        numbers = "name: dry_sand, cohesion: 500, janosi_shear: 0.02"
        (self.folder / "a").mkdir()
        for name in ("mine.yaml", "a/mine.yaml"):
            (self.folder / name).write_text("# as furrow fit-soil writes it\nsoil:\n  " + numbers.replace(", ", "  # a note\n  ") + "\n")
        (self.folder / "scene.yml").write_text(f"scene: 1\nend_time: 1\ntime_step: 1\nsoil: {{{numbers}}}\nredistribute: {{model: box}}\n")
        names = ["mine", "a/mine.yaml", "scene", "lunar", "snow_us", "clayey_38", "lete_sand", "dry_sand"]
        rows = self.rig("--soil", "mine.yaml,a/mine.yaml,scene.yml," + ",".join(names[3:]), "--slip", "0.5", "--spacing", "0.08")
        self.assertEqual([row["soil"] for row in rows], names)
        braces, = self.rig("--soil", f"{{{numbers}}}", "--slip", "0.5", "--spacing", "0.08", out="braces")
        for row in rows[:3]:
            for key in ("sinkage", "drawbar", "torque"):
                self.assertAlmostEqual(row[key], braces[key], delta=1e-9 * abs(braces[key]))
        self.assertNotAlmostEqual(rows[0]["drawbar"], rows[7]["drawbar"], delta=1)
        # Each of eight soils has its own pair of colour and mark.
        drawn = xml.etree.ElementTree.parse(self.folder / "rig" / "rig.svg").iter("{http://www.w3.org/2000/svg}g")
        looks = {(use.get("style").partition("stroke:")[2], use.get("{http://www.w3.org/1999/xlink}href")) for group in drawn if group.get("id", "").startswith("rows-")
                 for use in group.iter("{http://www.w3.org/2000/svg}use")}
        self.assertEqual(len(looks), 8)

    @long
    def test_a_belt_draws_as_a_rigid_track(self):
        """(A c + W tan phi) (1 - K / (i l) (1 - exp(-i l / K))): Wong's rigid track under a uniform pressure. A box has no resistance."""
        length, width = 1.2, 0.3
        belt = f"{{box: {{size: [{length}, {width}, 0.5], belt: true}}}}"
        plain = ["--set", "redistribute.slip_sinkage=0", "--set", "redistribute.bulldozing=0"]
        for soil, c, phi, modulus in (("dry_sand", 1040, 28, 0.02), ("sandy_loam_15", 1720, 29, 0.02), ("lunar", 170, 35, 0.018)):
            for row in self.rig("--soil", soil, "--load", "3000,6000", "--slip", "-0.2,0.05,0.2,0.5", *plain, wheel=belt):
                slip, load = row["slip"], row["load"]
                slid = abs(slip) * length / modulus
                effort = (length * width * c + load * math.tan(math.radians(phi))) * (1 - (1 - math.exp(-slid)) / slid)
                self.assertAlmostEqual(row["drawbar"], math.copysign(effort, slip), delta=0.005 * effort, msg=(soil, slip))
                self.assertAlmostEqual(row["torque"], row["drawbar"], delta=1e-3 * load)
                self.assertAlmostEqual(row["fz"], load, delta=0.002 * load)
                self.assertEqual(row["state"], "steady")
                if slip > 0:
                    self.assertAlmostEqual(row["efficiency"], 1 - slip, delta=0.002)
                else:
                    self.assertTrue(math.isnan(row["efficiency"]))
        rolls, = self.rig("--load", "3000", "--slip", "0", wheel=belt)
        self.assertLess(abs(rolls["drawbar"]), 3)
        by_slip = self.rig("--load", "3000", "--slip", "0.1,0.3", "--spacing", "0.04", wheel=belt)
        by_pull = self.rig("--load", "3000", "--torque", ",".join(repr(row["torque"]) for row in by_slip), "--spacing", "0.04", wheel=belt)
        for row, found in zip(by_slip, by_pull, strict=True):
            self.assertAlmostEqual(found["slip"], row["slip"], delta=0.02)

    @long
    def test_a_second_pass_is_what_a_drive_tells(self):
        """Two wheels of a drive, one 1.28 m behind the other, on other ground and in another direction. Where both sides of a wheel are exactly on posts,
        its rut is a post wider."""
        row, = self.rig("--slip", "0.2", "--load", "800", "--spacing", "0.02", "--passes", "2")
        first, = self.rig("--slip", "0.2", "--load", "800", "--spacing", "0.02")
        self.assertGreater(row["sinkage"], 1.1 * first["sinkage"])
        self.ok("synth", "-o", "flat.furrow", "--posts", "129x129", "--spacing", "0.16", "--kind", "plain", "--relief", "0", "--overwrite")
        wheels = "".join(f"  - {{name: {name}, shape: {{{WHEEL}}}, load: 800, slip: 0.2, path: {{points: [[6.003, {y}], [6.003, {y + 3.84}]], speed: 0.2}}}}\n"
                         for name, y in (("ahead", 4.28), ("behind", 3)))
        (self.folder / "scene.yaml").write_text(
            "scene: 1\ntime_step: 0.1\nend_time: 19.2\nspacing: 0.02\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
            f"output: {{forces: 9.9}}\nobjects:\n{wheels}")
        self.ok("drive", "scene.yaml", "--store", "flat.furrow", "-o", "out")
        with open(self.folder / "out" / "objects.csv") as file:
            rows = [r for r in csv.DictReader(file) if r["name"] == "behind" and float(r["y"]) >= 3 + 3.84 - 0.64]
        for key, name in (("sinkage", "sinkage"), ("fy", "drawbar"), ("tx", "torque")):
            mean = sum(float(r[key]) for r in rows) / len(rows)
            self.assertAlmostEqual(row[name], mean, delta=0.05 * abs(mean), msg=name)  # ruts differ by where the posts are
        self.assertIn("--passes", self.refused(2, "rig", "-o", "r", "--passes", "5"))

    def test_measured_trials_are_compared(self):
        (self.folder / "m.csv").write_text("trial,slip,drag_N,sinkage_mm,slip_angle_deg\n1,0.1,-100,40,0\n2,0.3,-200,50,0\n3,0.3,900,900,30\n4,5,1,1,0\n")
        told = self.ok("rig", "-o", "rig", "--shape", WHEEL, "--slip", "0:0.4:0.1", "--spacing", "0.04", "--compare", "m.csv")
        with open(self.folder / "rig" / "rig.csv") as file:
            rows = {round(float(row["slip"]), 3): row for row in csv.DictReader(file)}
        gaps = [(float(rows[slip]["sinkage"]) * 1e3 - mm, float(rows[slip]["drawbar"]) - pull) for slip, mm, pull in ((0.1, 40, 100), (0.3, 50, 200))]
        sinkage, drawbar = (math.sqrt(sum(gap[k] ** 2 for gap in gaps) / 2) for k in range(2))
        self.assertIn(f"sinkage {sinkage:.2f} mm, drawbar {drawbar:.2f} N\n", told)
        tree = xml.etree.ElementTree.parse(self.folder / "rig" / "rig.svg")
        drawn = {group.get("id"): len(list(group.findall(".//{*}use"))) for group in tree.findall(".//{*}g") if group.get("id", "").startswith("measured-")}
        self.assertEqual(drawn, {"measured-sinkage-222222": 2, "measured-drawbar-222222": 2})
        self.assertIn("measured", [text.text for text in tree.findall(".//{*}text")])

    def test_without_matplotlib_the_table_is_whole_and_no_old_plot_stays(self):
        self.rig("--slip", "0.2", "--spacing", "0.08")
        (self.folder / "lacks").write_text("#!/bin/sh\nprintf 'furrow: the Python package matplotlib is not installed; pip install matplotlib\\n' >&2\nexit 127\n")
        (self.folder / "lacks").chmod(0o755)
        for python, why in (("./lacks", "the Python package matplotlib is not installed; pip install matplotlib"), ("./gone", "./gone: No such file or directory; name a Python 3 in FURROW_PYTHON")):
            result = self.furrow("rig", "-o", "rig", "--shape", WHEEL, "--slip", "0.2", "--spacing", "0.08", env={"FURROW_PYTHON": python})
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(f"furrow: note: rig/rig.svg: is not drawn: {why}\n", result.stderr)
            self.assertTrue(result.stdout.endswith("\nrig/rig.csv: written\n"))
            self.assertEqual([path.name for path in (self.folder / "rig").iterdir()], ["rig.csv"])

    def test_wrong_input_is_told(self):
        (self.folder / "none.csv").write_text("a,b\n1,2\n")
        (self.folder / "odd.csv").write_text("slip,sinkage\n0.1,deep\n")
        (self.folder / "typo.yaml").write_text("soil: {name: dry_sand, cohesin: 3}\n")
        (self.folder / "map.yaml").write_text("soil: {name: dry_sand, rasters: {cohesion: typo.yaml}}\n")
        for status, arguments, part in (
                (2, [], "-o is missing"), (2, ["-o", "r", "--slip", "x"], "--slip x"), (2, ["-o", "r", "--slip", "0:1"], "--slip 0:1"),
                (2, ["-o", "r", "--slip", "0.1", "--torque", "5"], "give one of them"), (2, ["-o", "r", "--slip", "1"], "slip: 1"),
                (2, ["-o", "r", "--load", "0"], "load: 0"), (2, ["-o", "r", "--soil", "lunar,,mud"], "name is missing"),
                (3, ["-o", "r", "--soil", "moondust"], "moondust"), (3, ["-o", "r", "--soil", "absent.yaml"], "absent.yaml"),
                (3, ["-o", "r", "--set", "soil.cohesion=-3"], "soil.cohesion: -3"),
                (3, ["-o", "r", "--soil", "{name: dry_sand, cohesion: -3}"], "soil.cohesion: -3 is out of range"),
                (3, ["-o", "r", "--soil", "map.yaml"], "its soil is a map"), (3, ["-o", "r", "--soil", "typo.yaml"], "typo.yaml:1:24: soil.cohesin: unknown key"), (3, ["-o", "r", "--shape", "wheel: {radius: -1, width: 1}"], "radius"),
                (2, ["-o", "r", "--shape", "box: {size: [1, 1, 1]}", "--torque", "5"], "no wheel"),
                (3, ["-o", "r", "--compare", "absent.csv"], "absent.csv"), (3, ["-o", "r", "--compare", "none.csv"], "none.csv:1"),
                (3, ["-o", "r", "--compare", "odd.csv"], "odd.csv:2"), (2, ["-o", "r", "--set", "x"], "KEY=VALUE")):
            with self.subTest(arguments=arguments):
                error = self.refused(status, "rig", *arguments)
                self.assertIn(part, error)
                self.assertNotIn("scene text", error)

    def test_it_stops_when_told_and_leaves_what_was_there(self):
        (self.folder / "rig").mkdir()
        (self.folder / "rig" / "bed.furrow").write_text("the user's own")
        process = subprocess.Popen([FURROW, "rig", "-o", "rig", "--slip", "0:0.8:0.01"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        while process.poll() is None and not list((self.folder / "rig").glob("bed-*/bed.furrow")):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=250)
        if process.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(process.returncode, 130, told)
        self.assertEqual([path.name for path in (self.folder / "rig").iterdir()], ["bed.furrow"])
        self.assertEqual((self.folder / "rig" / "bed.furrow").read_text(), "the user's own")


if __name__ == "__main__":
    main()
