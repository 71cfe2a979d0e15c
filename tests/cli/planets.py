"""Sources of other bodies: PDS images with their labels, and values that are radii, beside what GDAL reads of them."""
import array
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import largest, long, main
from raster_test import RasterTest
import rasters

WIDTH, HEIGHT = 60, 44


def label(image, code, scale, offset, radius, unit="METER", line=1):
    """A PDS3 label of an image in a simple cylindrical projection."""
    kind, bits = {"h": ("LSB_INTEGER", 16), "f": ("PC_REAL", 32)}[code]
    lines = ["PDS_VERSION_ID = PDS3", "RECORD_TYPE = FIXED_LENGTH", f"RECORD_BYTES = {WIDTH * bits // 8}", f"FILE_RECORDS = {HEIGHT}",
             f"^IMAGE = {image}", "OBJECT = IMAGE", f"LINES = {HEIGHT}", f"LINE_SAMPLES = {WIDTH}", f"SAMPLE_TYPE = {kind}",
             f"SAMPLE_BITS = {bits}", f"UNIT = {unit}", f"SCALING_FACTOR = {scale}", f"OFFSET = {offset}", "END_OBJECT = IMAGE",
             "OBJECT = IMAGE_MAP_PROJECTION", 'MAP_PROJECTION_TYPE = "SIMPLE CYLINDRICAL"',
             *(f"{axis}_AXIS_RADIUS = {radius / 1000} <KM>" for axis in "ABC"), 'POSITIVE_LONGITUDE_DIRECTION = "EAST"',
             "CENTER_LATITUDE = 0 <DEG>", "CENTER_LONGITUDE = 0 <DEG>", "MAP_RESOLUTION = 256 <PIXEL/DEG>", "MAP_SCALE = 118.45 <METERS/PIXEL>",
             "LINE_PROJECTION_OFFSET = 20", "SAMPLE_PROJECTION_OFFSET = 30", 'COORDINATE_SYSTEM_NAME = "PLANETOCENTRIC"',
             "END_OBJECT = IMAGE_MAP_PROJECTION", "END"]
    return "\r\n".join(lines).encode() + b"\r\n"


class Planets(RasterTest):
    def image(self, name="moon", code="h", scale=0.5, offset=1737400, radius=1737400, unit="METER", attached=False, ending=".lbl"):
        cells = array.array(code, [(x * 7 + y * 3) % 900 - 300 for y in range(HEIGHT) for x in range(WIDTH)])
        record = WIDTH * cells.itemsize
        if attached:
            records = 2 + len(label(1, code, scale, offset, radius, unit)) // record
            text = label(records + 1, code, scale, offset, radius, unit)
            (self.folder / (name + ".img")).write_bytes(text.ljust(records * record) + cells.tobytes())
        else:
            (self.folder / (name + ".img")).write_bytes(cells.tobytes())
            (self.folder / (name + ending)).write_bytes(label(f'"{name}.img"', code, scale, offset, radius, unit))
        return [v * scale for v in cells]

    def heights(self, *arguments):
        """What an import keeps, rows from the north, and its notes."""
        result = self.furrow("import", *arguments, "-o", "s.furrow", "--overwrite", "--max-error", 0.001)
        self.assertEqual(result.returncode, 0, result.stderr)
        width, height, found = self.exported("s.furrow", "--layer", "base")
        self.assertEqual((width, height), (WIDTH, HEIGHT))
        return found, result.stderr

    def assert_near(self, found, wanted, within=0.002):
        self.assertLess(largest(abs(a - b) for a, b in zip(found, wanted, strict=True)), within)

    def test_an_image_is_read_by_its_label_whichever_is_named(self):
        hashes = set()
        for ending in (".lbl", ".LBL"):
            self.image(ending=ending)
            for name in ("moon.img", "moon" + ending, "."):
                self.ok("import", name, "-o", self.folder.parent / (self.folder.name + ".furrow"))
                store = (self.folder.parent / (self.folder.name + ".furrow")).rename(self.folder / "s.store")
                told = self.json("info", store)
                hashes.add(told["base_hash"])
                self.assertEqual(len(told["sources"]), 1)
                store.unlink()
            (self.folder / ("moon" + ending)).unlink()
        self.image(attached=True)
        for name in ("moon.img", "."):
            self.ok("import", name, "-o", "s.store", "--overwrite")
            hashes.add(self.json("info", "s.store")["base_hash"])
            (self.folder / "s.store").unlink()
        self.assertEqual(len(hashes), 1)
        # A label of something else, and an image without one.
        (self.folder / "moon.lbl").write_text("this is no label")
        self.ok("import", "moon.img", "-o", "s.store")
        self.image()
        (self.folder / "moon.lbl").unlink()
        self.assertIn("moon.img", self.refused(3, "import", "moon.img", "-o", "x.furrow"))

    @long
    def test_radii_become_heights_over_their_sphere(self):
        for radius, scale, offset, code, unit in ((1737400, 0.5, 1737400, "h", "METER"), (3396000, 1, 3396000, "h", "METER"),
                                                  (1737400, 0.0005, 1737.4, "f", "KILOMETER"), (3396190, 0.0005, 3396.19, "f", "KILOMETER"),
                                                  (265000, 1, 265000, "f", "METER"), (3396190, 1, 3389000, "h", "METER")):
            with self.subTest(radius=radius, scale=scale, offset=offset):
                values = self.image(code=code, scale=scale, offset=offset, radius=radius, unit=unit)
                metres = 1000 if unit == "KILOMETER" else 1
                wanted = [(v + offset) * metres - radius for v in values]
                found, told = self.heights("moon.img")
                self.assert_near(found, wanted)
                self.assertIn("its values are radii", told)
                self.assertIn(f"{radius} m", self.json("info", "s.furrow")["vertical"])
                self.assert_near(self.heights("moon.img", "--radii", "yes")[0], wanted)
                # What GDAL itself makes of the values.
                rasters.gdal("gdal_translate", "-q", "-unscale", "-ot", "Float64", self.folder / "moon.lbl", self.folder / "plain.tif")
                _, _, plain = rasters.pixels(self.folder / "plain.tif", "d")
                found, told = self.heights("moon.img", "--radii", "no", "--max-error", 0.5)
                self.assert_near(found, plain, 0.51)
                self.assertNotIn("radii", told)

    def test_longitudes_beyond_180_are_found(self):
        """Products of planets count longitude to 360: their x is beyond half a turn from the central meridian."""
        kept = {}
        for north in (-257330.0, 200.0):  # projected, or kept as true metres were it not for its place
            for west in (11860000.0, 11860000.0 - 2 * math.pi * 3396190):
                self.make("mars.tif", WIDTH, HEIGHT, lambda x, y: x * 7 - y * 3, west=west, north=north, step=20.0, srs="IAU_2015:49910", options=["-mo", "GEOID=mola"])
                self.ok("import", "mars.tif", "-o", "s.furrow", "--overwrite")
                told = self.json("info", "s.furrow")
                self.assertLess(told["holes"], 0.05)
                self.assertEqual(told["vertical"], "mola")
                x, y = 11860000 + 20 * WIDTH / 2, north - 20 * HEIGHT / 2
                for turn in (0, 360):
                    point = self.json("query", "s.furrow", "--srs", "degrees", math.degrees(x / 3396190) - turn, math.degrees(y / 3396190))
                    kept.setdefault(north, []).append(point["height"])
                    self.assertAlmostEqual(self.json("query", "s.furrow", *point["local"])["height"], point["height"], delta=1e-6)
        for heights in kept.values():
            self.assertLess(largest(heights) - min(heights), 0.5)
        # Kept as it is, it is told.
        self.make("mars.tif", WIDTH, HEIGHT, lambda x, y: 5, west=11860000.0, north=200.0, step=20.0, srs="IAU_2015:49910")
        result = self.furrow("import", "mars.tif", "-o", "s.furrow", "--overwrite", "--t-srs", "source")
        self.assertIn("beyond 180 degrees", result.stderr)

    def test_a_store_without_heights_is_refused(self):
        self.make("none.tif", WIDTH, HEIGHT, lambda x, y: -9999, west=2e6, north=-257330.0, step=20.0, srs="IAU_2015:49910", nodata=-9999)
        for more, why in (((), "longitude beyond 180"), (("--t-srs", "source"), "nodata")):
            told = self.refused(3, "import", "none.tif", "-o", "x.furrow", *more)
            self.assertIn("has a height", told)
            self.assertIn(why, told)

    def test_heights_stay_heights(self):
        for radius, offset in ((1737400, 0), (3396190, -4000), (1737400, 9000)):
            values = self.image(offset=offset, radius=radius)
            found, told = self.heights("moon.img")
            self.assert_near(found, [v + offset for v in values])
            self.assertNotIn("radii", told)
            self.assertIn("not radii", self.refused(3, "import", "moon.img", "-o", "x.furrow", "--radii", "yes"))

    def test_metres_like_the_radius_in_kilometres_are_heights(self):
        """Highlands of the Moon at 1,400 to 2,000 m, in a file that says no unit; and radii in kilometres, which are within 1.2 % of it."""
        for low, high, radii in ((1400, 2000, False), (1729, 1747, True), (1717, 1757, True)):
            rasters.make(self.folder / "in.tif", WIDTH, HEIGHT, [low + (high - low) * k / (WIDTH * HEIGHT - 1) for k in range(WIDTH * HEIGHT)], west=10.0, north=20.0,
                         step=0.01, srs="IAU_2015:30100")
            result = self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite")
            self.assertEqual((result.returncode, "its values are radii" in result.stderr), (0, radii), result.stderr)
            self.assertAlmostEqual(self.json("info", "s.furrow")["height"][0], 1000 * (low - 1737.4) if radii else low, delta=1000 if radii else 10)

    def test_radii_need_a_sphere(self):
        cells = [3389000 + x for x in range(WIDTH * HEIGHT)]
        for srs, status, why in (("IAU_2015:49900", 0, ""), ("+proj=longlat +a=3396190 +b=3376200 +no_defs", 3, "ellipsoid"), (None, 3, "no SRS")):
            rasters.make(self.folder / "in.tif", WIDTH, HEIGHT, cells, "f", west=10.0, north=20.0, step=0.01, srs=srs)
            if status == 0:
                self.ok("import", "in.tif", "-o", "s.furrow")
            else:
                self.assertIn(why, self.refused(3, "import", "in.tif", "-o", "x.furrow", "--radii", "yes"))
        # Holes that no tag declares do not hide what the others are.
        cells[::7] = [0] * len(cells[::7])
        rasters.make(self.folder / "in.tif", WIDTH, HEIGHT, cells, "f", west=10.0, north=20.0, step=0.01, srs="IAU_2015:49900")
        self.assertIn("radii", self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite", "--nodata", 0).stderr)
        self.assertIn("auto yes no", self.refused(2, "import", "in.tif", "-o", "x.furrow", "--radii", "maybe"))

    def test_the_body_of_the_store_is_told_where_the_scene_has_another(self):
        car = pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml"
        drives = f"vehicles: [{{name: car, model: {car}, start: {{at: [20, 20]}}, driver: {{hold: {{drive: 0}}}}}}]\n"


        def of_its_own(name, gravity):
            (self.folder / f"{name}.xml").write_text(car.read_text().replace("<option ", f'<option gravity="{gravity}" '))
            return drives.replace(str(car), f"{name}.xml")
        light, near, none, aslant = of_its_own("light", "0 0 -1.62"), of_its_own("near", "0 0 -9.80665"), of_its_own("none", "0 0 0"), of_its_own("aslant", "6 0 -8")
        two = light.replace("]\n", ", {name: other, model: aslant.xml, start: {at: [30, 30]}}]\n")
        counts = "gravity: it is not given, so vehicles weigh as on the Earth, 9.81 m/s2 straight down; that of the model of car, %s, does not count; give gravity: %s"
        plain = "objects: [{name: a, shape: {sphere: {radius: 9}}, sink: 0.1, path: {points: [[20, 20], [21, 20]], speed: 1}}]\n"
        looks = "view: {camera: {fixed: {eye: [1, 1, 50], target: [9, 9, 20]}}, images: 1, %s}\n"
        eye = "cameras: [{name: c, kind: fixed, rate: 1, fov: 90, size: [64, 64], pose: {at: [1, 1, 50]}}]\n"
        on = "view.body: the store is on %s, and pictures have the colours, the sky and the sun of %s; give view.body: %s, or leave it out"
        weighs = "gravity: it is not given, so vehicles weigh as on the Earth, and %s; give gravity: %s"
        mars, moon = "IAU_2015:49900", "IAU_2015:30100"
        seen = "the store is on Mars"
        other = "gravity: %s is that of %s, and %s %s; give gravity: %s"
        cases = ((mars, plain, []), (mars, plain + looks % "body: mars", []), (mars, plain + looks % "body: moon", [on % ("Mars", "the Moon", "mars")]),
                 (mars, plain + looks % "body: earth", [on % ("Mars", "the Earth", "mars")]), (mars, plain + looks % "samples: 1", []), (mars, plain + eye, []),
                 (moon, plain + looks % "body: earth", [on % ("the Moon", "the Earth", "moon")]), (moon, plain + looks % "body: moon", []),
                 ("EPSG:4326", plain + looks % "body: moon", []), (mars, drives, [weighs % (seen, "3.71")]), (mars, drives + "gravity: 3.7\n", []),
                 (mars, drives + "gravity: 9.81\n", []), (moon, drives, [weighs % ("the store is on the Moon", "1.62")]), ("EPSG:4326", drives, []),
                 (moon, drives + "gravity: 3.72\n", [other % ("3.72", "Mars", "the store is on", "the Moon", "1.62")]), (None, drives + "gravity: 3.72\n", []),
                 (None, drives + "gravity: 3.72\n" + looks.replace("images: 1, ", "") % "body: moon",
                  [other % ("3.72", "Mars", "the scene's body is", "the Moon", "1.62") + ", or view.body: mars"]),
                 ("EPSG:4326", drives + looks % "body: mars", [weighs % ("the scene's body is Mars", "3.71")]),
                 (None, drives + looks.replace("images: 1, ", "") % "body: mars", [weighs % ("the scene's body is Mars", "3.71")]))
        cases += ((None, light, [counts % ("0 0 -1.62", "1.62")]), ("EPSG:4326", two, [counts % ("0 0 -1.62", "1.62")]), (None, aslant, [counts % ("6 0 -8", "10")]),
                  (mars, light, [weighs % (seen, "3.71")]), (None, near, []), (None, none, []), (None, light + "gravity: 9.81\n", []), (moon, light + "gravity: 1.62\n", []))
        for srs, scene, told in cases:
            name = f"{str(srs)[-5:]}.furrow"
            if not (self.folder / name).exists():
                rasters.make(self.folder / "in.tif", 101, 101, [100.0] * 101 * 101, "f", west=10.0, north=20.0, step=0.00002, srs=srs)
                self.ok("import", "in.tif", "-o", name)
            with self.subTest(srs=srs, scene=scene):
                path = self.scene("scene: 1\ntime_step: 0.01\nend_time: 1\nspacing: 0.5\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n" + scene)
                result = self.furrow("explain", path, "--store", name, "--json")
                if "this build has no MuJoCo" in result.stderr:
                    continue
                self.assertEqual(result.returncode, 0, result.stderr)
                planned = json.loads(result.stdout)
                if scene == plain + looks % "samples: 1": # programs name the body they draw
                    self.assertIn("MARS", json.dumps(planned["programs"]))
                self.assertEqual([note for note in planned["notes"] if note.startswith(("view.body", "gravity"))], told)


if __name__ == "__main__":
    main()
