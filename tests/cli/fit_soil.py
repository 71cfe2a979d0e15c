"""furrow fit-soil: the examples' numbers, the soil that it writes in a scene, its JSON and its page, and files that are refused."""
import json
import math
import pathlib
import re
import shutil
import unittest
import xml.etree.ElementTree

from furrow_test import FurrowTest, main, sampled

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples/soil"
PLATE, SHEAR, PENETRATION = EXAMPLES / "plate.csv", EXAMPLES / "shear.csv", EXAMPLES / "penetration.csv"
# As the first lines of the files say.
TRUTH = {"kc": 25000, "kphi": 1900000, "n": 0.9, "cohesion": 1800, "friction_angle": 31, "janosi_shear": 0.014}
SCENE = """scene: 1
time_step: 0.02
end_time: 1
spacing: 0.0625
redistribute: {model: scm}
output: {forces: 20}
objects:
  - {name: wheel, shape: {wheel: {radius: 0.4, width: 0.2}}, load: 1500, path: {points: [[10, 10], [13, 10]], speed: 2}}
"""


def soil_of(text):
    """{key: value} of a `soil:` block."""
    lines = [line.split("#")[0].rstrip() for line in text[text.index("soil:"):].splitlines()[1:]]
    return {key: value for key, value in (line.strip().split(": ") for line in lines if line.startswith("  "))}


def dots_of(page):
    """How many rows each plot of a page has."""
    return [sum(len(group.findall(".//{*}use")) for group in svg.findall(".//{*}g") if group.get("id", "").startswith("rows-")) for svg in page.findall(".//{*}svg")]


class FitSoil(FurrowTest):
    def test_a_notebook_has_the_same_numbers(self):
        told = self.json("fit-soil", PLATE, SHEAR, "--penetration", PENETRATION, "--area", "0.0025", "--method", "wong")
        script = f"import furrow, json\nfit = furrow.fit_soil({str(PLATE)!r}, {str(SHEAR)!r}, penetration={str(PENETRATION)!r}, area=0.0025, method='wong')\nprint(json.dumps(fit.told()))"
        self.assertEqual(json.loads(self.python(script, needs=("scipy",))), told)

    def test_a_missing_package_is_named_and_nothing_is_written(self):
        (self.folder / "lacks").mkdir()
        for package, options in (("scipy", ()), ("jinja2", ("--page", "soil.html")), ("matplotlib", ("--page", "soil.html"))):
            for old in (self.folder / "lacks").glob("*"):
                shutil.rmtree(old) if old.is_dir() else old.unlink()
            (self.folder / "lacks" / f"{package}.py").write_text("raise ImportError\n")
            said = self.refused(1, "fit-soil", PLATE, "-o", "soil.yaml", *options, env={"PYTHONPATH": str(self.folder / "lacks")})
            self.assertRegex(said, rf"furrow: fit-soil: the Python package {package} is not installed for .*; .* -m pip install {package}")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["lacks"])
        self.assertIn("no/soil.yaml: No such file or directory; ", self.refused(1, "fit-soil", PLATE, "-o", "no/soil.yaml"))

    def test_the_examples_give_their_numbers_within_three_standard_errors(self):
        fit = self.json("fit-soil", PLATE, SHEAR)
        for method in ("plain", "wong"):
            for key in ("kc", "kphi", "n"):
                number = fit["plate"][method][key]
                self.assertLess(abs(number["value"] - TRUTH[key]), 3 * number["error"], (method, key))
                self.assertLess(number["error"], 0.1 * TRUTH[key])
            self.assertGreater(fit["plate"][method]["goodness"], 0.97)
            self.assertLess(fit["plate"][method]["rms"], 2500)
        for key in ("cohesion", "friction_angle", "janosi_shear"):
            self.assertLess(abs(fit["shear"][key]["value"] - TRUTH[key]), 3 * fit["shear"][key]["error"], key)
        self.assertEqual(fit["plate"]["widths"], [0.05, 0.1, 0.15])
        self.assertEqual([fit["plate"]["rows"], fit["shear"]["rows"]], [36, 42])
        # The largest residual is that of its line.
        line = PLATE.read_text().splitlines()[fit["plate"]["plain"]["largest_line"] - 1]
        b, z, p = (float(cell) for cell in line.split(","))
        numbers = {key: fit["plate"]["plain"][key]["value"] for key in ("kc", "kphi", "n")}
        fitted = (numbers["kc"] / (b / 1e3) + numbers["kphi"]) * (z / 1e3) ** numbers["n"]
        self.assertAlmostEqual(fit["plate"]["plain"]["largest"], p * 1e3 - fitted, delta=1e-6 * p * 1e3)

    def test_a_diameter_is_two_radii(self):
        lines = PLATE.read_text().splitlines()
        double = [lines[1].replace("plate width b", "diameter")] + [f"{2 * float(line.split(',')[0]):g},{line.split(',', 1)[1]}" for line in lines[2:]]
        (self.folder / "round.csv").write_text("\n".join(double) + "\n")
        self.assertEqual(self.json("fit-soil", "round.csv")["plate"]["plain"], {
            **self.json("fit-soil", PLATE)["plate"]["plain"], "largest_line": self.json("fit-soil", PLATE)["plate"]["plain"]["largest_line"] - 1})

    def test_the_text_has_the_numbers_and_a_soil(self):
        text, fit = self.ok("fit-soil", PLATE, SHEAR), self.json("fit-soil", PLATE, SHEAR)
        for word in ("plain", "weighted as Wong", "goodness of fit", "plates of 50, 100, 150 mm", "normal stresses of 10, 25, 50 kPa"):
            self.assertIn(word, text)
        soil = soil_of(text)
        self.assertEqual(soil.pop("name"), "dry_sand")
        self.assertAlmostEqual(float(soil.pop("repose")), fit["soil"]["friction_angle"], places=6)
        for key, value in soil.items():
            self.assertTrue(math.isclose(float(value), fit["soil"][key], rel_tol=1e-10), key)
        wong = self.json("fit-soil", PLATE, "--method", "wong", "--soil", "lunar")
        self.assertEqual(wong["soil"]["name"], "lunar")
        self.assertEqual(wong["soil"]["bekker_n"], wong["plate"]["wong"]["n"]["value"])
        self.assertNotEqual(wong["soil"]["bekker_n"], fit["soil"]["bekker_n"])
        self.assertNotIn("cohesion", wong["soil"])

    def test_a_scene_takes_the_soil_as_it_is(self):
        self.synth(kind="plain", posts="65x65", relief=1)
        self.assertNotIn("soil:", self.ok("fit-soil", PLATE, SHEAR, "-o", "soil.yaml"))
        fit = self.json("fit-soil", PLATE, SHEAR)
        scene = self.scene(SCENE + (self.folder / "soil.yaml").read_text())
        result = self.furrow("drive", scene, "--store", "world.furrow", "--overlay", "ruts.furrow", "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads((self.folder / "out/run.json").read_text())
        soil = report["soils"][0]
        for key, value in fit["soil"].items():
            if key != "name":
                self.assertTrue(math.isclose(soil[key], value, rel_tol=1e-9), (key, soil))
        self.assertGreater(report["objects"]["wheel"]["sinkage"], 0.005)
        # The same without editing the scene.
        same = self.scene(SCENE + "soil: {name: lunar, cohesion: 3}\n", "same.yaml")
        told = self.ok("fit-soil", PLATE, SHEAR, "-o", "soil.yaml").splitlines()[-1]
        self.assertIn("furrow drive SCENE --set soil=soil.yaml", told)
        self.ok("drive", same, "--store", "world.furrow", "--overlay", "set.furrow", "-o", "set", "--set", "soil=soil.yaml", "--set", "soil.damping=7")
        set_ = json.loads((self.folder / "set/run.json").read_text())
        self.assertEqual(set_["soils"][0], {**soil, "damping": 7})
        self.assertNotIn("lunar", set_["scene"]["values"].values())
        self.assertIn("no.yaml", self.refused(3, "explain", same, "--set", "soil=no.yaml"))
        self.assertIn("--set soil=utv.xml: not a soil file; give one that ends in .yaml", self.refused(2, "explain", same, "--set", "soil=utv.xml"))
        # A penetration alone: all else is that of the named soil.
        self.ok("fit-soil", "--penetration", PENETRATION, "--area", "0.0025", "-o", "faces.yaml")
        self.ok("drive", self.scene(SCENE + (self.folder / "faces.yaml").read_text()), "--store", "world.furrow", "--overlay", "faces.furrow", "-o", "faces")
        faces = json.loads((self.folder / "faces/run.json").read_text())["soils"][0]
        self.assertAlmostEqual(faces["face_strength"], self.json("fit-soil", "--penetration", PENETRATION, "--area", "0.0025")["soil"]["face_strength"], delta=1)
        self.assertEqual(faces["cohesion"], 1040)
        # Plates alone: the strength is that of the named soil.
        self.ok("fit-soil", PLATE, "-o", "soil.yaml", "--soil", "lete_sand")
        scene = self.scene(SCENE + (self.folder / "soil.yaml").read_text())
        self.ok("drive", scene, "--store", "world.furrow", "--overlay", "other.furrow", "-o", "other")
        soil = json.loads((self.folder / "other/run.json").read_text())["soils"][0]
        self.assertEqual([soil["cohesion"], soil["janosi_shear"]], [1300, 0.012])
        self.assertTrue(math.isclose(soil["bekker_n"], fit["soil"]["bekker_n"], rel_tol=1e-9))

    def test_the_page_is_one_file_with_plots(self):
        self.ok("fit-soil", PLATE, SHEAR, "--page", "soil.html")
        text = (self.folder / "soil.html").read_text()
        root = xml.etree.ElementTree.fromstring(text)
        self.assertEqual([section.get("id") for section in root.iter("section")], ["plates", "shear", "soil"])
        plots = [svg.find("{*}title").text for svg in root.findall(".//{*}svg")]
        self.assertEqual(plots, ["pressure over sinkage", "residuals of pressure", "shear stress over displacement", "residuals of shear stress"])
        self.assertEqual(dots_of(root), [36, 36, 42, 42])
        self.assertNotRegex(text, r'(?:src|href)="(?!#)|https?:(?!//www\.w3\.org/(?:1999/xlink|2000/svg)")|url\((?!#)|@import')
        self.assertEqual(soil_of("".join(root.find(".//pre").itertext())), soil_of(self.ok("fit-soil", PLATE, SHEAR)))

    def test_one_width_and_one_stress_are_told(self):
        lines = PLATE.read_text().splitlines()
        (self.folder / "one.csv").write_text("\n".join(lines[:2] + [line for line in lines if line.startswith("50,")]) + "\n")
        lines = SHEAR.read_text().splitlines()
        (self.folder / "ones.csv").write_text("\n".join(lines[:2] + [line for line in lines if line.startswith("25,")]) + "\n")
        text = self.ok("fit-soil", "one.csv", "ones.csv")
        self.assertIn("does not tell kc and kphi apart", text)
        self.assertIn("does not tell cohesion and friction apart", text)
        soil = soil_of(text)
        self.assertEqual([soil["bekker_kc"], soil["cohesion"]], ["0", "0"])
        k = TRUTH["kc"] / 0.05 + TRUTH["kphi"]
        fit = self.json("fit-soil", "one.csv")["plate"]["plain"]
        self.assertLess(abs(fit["kphi"]["value"] - k), 3 * fit["kphi"]["error"])
        self.assertIsNone(fit["kc"]["error"])

    def test_a_kc_below_0_tells_for_which_widths_it_holds(self):
        rows = [f"{b},{z},{(-40e3 / b + 4e6) * z ** 1.2:.3f}" for b in (0.03, 0.05) for z in (0.01, 0.02, 0.04, 0.08)]
        (self.folder / "low.csv").write_text("radius b m,z m,p Pa\n" + "\n".join(rows) + "\n")
        text = self.ok("fit-soil", "low.csv")
        self.assertIn("above 0 only for widths over 10 mm", text)
        self.assertAlmostEqual(float(soil_of(text)["bekker_kc"]), -40e3, delta=1)
        self.assertNotIn("kc is below 0", self.ok("fit-soil", PLATE))

    def test_a_penetration_gives_the_strength_of_faces(self):
        """The example's first line says 1.1e6 N/m3. By hand: the sum of p z over the sum of z z, and the standard error of the textbook."""
        fit = self.json("fit-soil", "--penetration", PENETRATION, "--area", "0.0025")
        number = fit["penetration"]["face_strength"]
        rows = [[float(cell) for cell in line.split(",")] for line in PENETRATION.read_text().splitlines()[2:]]
        x, y = [0.87574 * z / 1e3 for z, _ in rows], [force / 0.0025 for _, force in rows]
        slope = sum(a * b for a, b in zip(x, y)) / sum(a * a for a in x)
        error = math.sqrt(sum((b - slope * a) ** 2 for a, b in zip(x, y)) / (len(x) - 1) / sum(a * a for a in x))
        self.assertAlmostEqual(number["value"], slope, delta=1e-9 * slope)
        self.assertAlmostEqual(number["error"], error, delta=1e-9 * error)
        self.assertLess(abs(slope - 1.1e6), 3 * error)
        self.assertEqual(fit["soil"], {"name": "dry_sand", "face_strength": number["value"]})
        self.assertEqual(fit["penetration"]["areas"], [0.0025])
        # Pressures, kN, cm2 and an own column say the same.
        for name, head, row in (("p.csv", "depth mm,pressure kPa", lambda z, f: f"{z},{f / 2.5!r}"), ("k.csv", "area cm2,z cm,F kN", lambda z, f: f"25,{z / 10!r},{f / 1e3!r}")):
            (self.folder / name).write_text(head + "\n" + "\n".join(row(z, f) for z, f in rows) + "\n")
            self.assertAlmostEqual(self.json("fit-soil", "--penetration", name)["soil"]["face_strength"], slope, delta=1e-9 * slope)
        # Beside the others.
        text = self.ok("fit-soil", PLATE, SHEAR, "--penetration", PENETRATION, "--area", "0.0025", "--page", "all.html")
        soil = soil_of(text)
        self.assertAlmostEqual(float(soil.pop("face_strength")), slope, delta=1e-10 * slope)
        self.assertEqual(soil, soil_of(self.ok("fit-soil", PLATE, SHEAR)))
        self.assertIn("plates of 25 cm2", text)
        self.assertNotIn("is more than its error", text)
        root = xml.etree.ElementTree.fromstring((self.folder / "all.html").read_text())
        self.assertEqual([section.get("id") for section in root.iter("section")], ["plates", "shear", "penetration", "soil"])
        self.assertEqual(dots_of(root), [36, 36, 42, 42, 21, 21])
        (self.folder / "c.csv").write_text("z m,p Pa\n" + "".join(f"{z / 100},{900 + 9e5 * z / 100 + z % 2}\n" for z in range(1, 9)))
        self.assertIn("is more than its error", self.ok("fit-soil", "--penetration", "c.csv"))

    def test_the_page_tells_what_the_command_says_of_a_penetration(self):
        page = (EXAMPLES.parents[1] / "docs/SOIL-TESTS.md").read_text()
        block = page[page.index("fit-soil --penetration penetration.csv"):]
        arguments, *told = block[:block.index("```")].strip().split("\n")
        shutil.copy(PENETRATION, self.folder)
        self.assertEqual(self.ok(*arguments.split()).strip().split("\n"), told)
        self.assertEqual(list(soil_of((self.folder / "sand.yaml").read_text())), ["name", "face_strength"])

    def test_what_is_wrong_is_refused_and_leaves_nothing(self):
        (self.folder / "bad.csv").write_text("b mm,z mm,p kPa\n50,4,10\n50,8,no\n")
        (self.folder / "short.csv").write_text("b mm,z mm,p kPa\n50,4,10\n")
        for arguments, status, why in sampled((
                (("bad.csv",), 3, r"bad\.csv:3: column 3, pressure p"), (("short.csv",), 3, r"short\.csv: has 1 rows"),
                (("gone.csv",), 3, "No such file"), ((SHEAR,), 3, "no column plate width b"), ((PLATE, PLATE), 3, "no column normal stress"),
                ((PLATE, "--soil", "cheese"), 3, "known are"), ((PLATE, "--soil", "mud"), 3, "mud has no numbers of Bekker"), ((PLATE, "--method", "guess"), 2, "method"), ((), 2, "PLATE"),
                (("--penetration", PENETRATION), 3, "has forces, and no area"), (("--penetration", PLATE, "--area", "0.1"), 3, "--area is for forces"), ((PLATE, "--area", "0.1"), 2, "give both"),
                (("--penetration", SHEAR), 3, "no column depth z"), ((PLATE, SHEAR, PLATE), 2, "fit-soil"))):
            said = self.refused(status, "fit-soil", *arguments, *(("-o", "soil.yaml", "--page", "soil.html") if arguments else ()))
            self.assertRegex(said, why)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["bad.csv", "short.csv"])

    def test_help_lists_it(self):
        self.assertRegex(self.ok("--help"), r"(?m)^  fit-soil ")
        self.assertIn("plate width b", self.ok("fit-soil", "--help"))

    def test_a_name_cannot_break_out_of_the_soil_or_the_page(self):
        name = "a<b>&\n  name: lunar\n\".csv"
        (self.folder / name).write_text(PLATE.read_text())
        self.assertEqual(soil_of(self.ok("fit-soil", name, "--page", "soil.html"))["name"], "dry_sand")
        xml.etree.ElementTree.fromstring((self.folder / "soil.html").read_text())


if __name__ == "__main__":
    main()
