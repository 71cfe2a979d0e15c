"""Paths from GPX and GeoJSON, ways that follow others, and templates: the ruts and rows are those of paths that were written by hand."""
import csv
import hashlib
import json
import math
import pathlib
import shutil
import subprocess
import unittest

from furrow_test import MAPS, FurrowTest, has_gdal, largest, long, main
import rasters

HEAD = "scene: 1\ntime_step: 0.1\nend_time: 12\nspacing: 0.25\nredistribute: {model: box}\nobjects:\n"
WAY = [(500020, 5000030), (500060, 5000034), (500075, 5000070)]  # in UTM zone 33
BALL = "shape: {sphere: {radius: 0.6}}, sink: 0.2"


class Lines(FurrowTest):
    def ruts(self, name, scene, *more):
        """A hash of the offsets that a drive leaves."""
        self.ok("drive", scene if "\n" not in scene else self.scene(scene, f"{name}.yaml"), "--store", "base.furrow", "--overlay",
                f"{name}.furrow", "-o", name, *more)
        self.ok("export", f"{name}.furrow", "--layer", "offset", "-o", f"{name}.tif")
        return hashlib.sha256((self.folder / f"{name}.tif").read_bytes()).hexdigest()

    def plain(self):
        self.ok("synth", "-o", "base.furrow", "--posts", "129x129", "--spacing", "1", "--kind", "plain", "--overwrite")

    # --- followers and templates: what they are is written in the scene of their own points ---

    def test_a_convoy_is_the_same_paths_later_and_further_on(self):
        self.plain()
        written = (f"  - {{name: a, {BALL}, path: {{points: [[20, 30], [80, 30]], speed: 8}}}}\n"
                   f"  - {{name: b, {BALL}, path: {{points: [[20, 33], [80, 33]], speed: 8, delay: 1.5}}}}\n"
                   f"  - {{name: c, {BALL}, path: {{points: [[10, 28], [70, 28]], speed: 8}}}}\n")
        follows = (f"  - {{name: c, {BALL}, path: {{relative_to: a, offset: [-10, -2]}}}}\n"
                   f"  - {{name: a, {BALL}, path: {{points: [[20, 30], [80, 30]], speed: 8}}}}\n"
                   f"  - {{name: b, {BALL}, path: {{relative_to: a, offset: [0, 3], delay: 1.5}}}}\n")
        self.assertEqual(self.ruts("written", HEAD + written), self.ruts("follows", HEAD + follows))

    def test_a_template_is_its_copies(self):
        self.plain()
        written = "".join(f"  - {{name: w-{1 + 3 * j + i}, {BALL}, path: {{points: [[{20 + 12 * i}, {20 + 9 * j}], [{28 + 12 * i}, {20 + 9 * j}]], "
                          f"speed: 4, delay: {0.5 * (3 * j + i)}}}}}\n" for j in range(2) for i in range(3))
        template = (f"  template: {{name: w, {BALL}, path: {{points: [[20, 20], [28, 20]], speed: 4}}}}\n"
                    "  at: {rows: 2, columns: 3, step: [12, 9]}\n  every: 0.5\n")
        self.assertEqual(self.ruts("written", HEAD + written), self.ruts("template", HEAD + template))
        run = json.loads((self.folder / "template/run.json").read_text())
        self.assertEqual(list(run["objects"]), [f"w-{i}" for i in range(1, 7)])

    def test_what_has_not_begun_touches_nothing(self):
        self.plain()
        scene = self.scene(HEAD + f"  - {{name: a, {BALL}, path: {{points: [[20, 30], [80, 30]], speed: 8, delay: 11.95}}}}\n")
        early = self.ruts("early", str(scene), "--set", "end_time=11.9")
        self.ok("export", "base.furrow", "--layer", "offset", "-o", "none.tif")
        self.assertEqual(early, hashlib.sha256((self.folder / "none.tif").read_bytes()).hexdigest())
        self.assertNotEqual(self.ruts("late", str(scene)), early)
        self.assertIn("objects.a.path: begins after 11.95 s, and the drive ends after 5 s", self.furrow("explain", scene, "--set", "end_time=5").stdout)

    # --- files in longitude and latitude; gdaltransform says what the points are ---

    def globe(self, points):
        text = "".join(f"{x} {y}\n" for x, y in points)
        told = subprocess.run(["gdaltransform", "-s_srs", "EPSG:32633", "-t_srs", "EPSG:4326", "-output_xy"], input=text, check=True,
                              capture_output=True, text=True).stdout
        return [tuple(map(float, line.split())) for line in told.splitlines()]

    def utm(self):
        if not has_gdal():
            self.skipTest("needs GDAL's programs")
        rasters.make(self.folder / "utm.tif", 101, 101, [100.0] * 101 * 101, "f", step=1, west=499999.5, north=5000100.5, srs="EPSG:32633")
        result = self.furrow("import", "utm.tif", "-o", "base.furrow")
        if "built without GDAL" in result.stderr:
            self.skipTest("built without GDAL")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.degrees = self.globe(WAY)

    def gpx(self, name, tracks, kind="trk", times=None):
        point, segment = ("trkpt", True) if kind == "trk" else ("rtept", False)
        text = '<?xml version="1.0"?>\n<gpx version="1.1" creator="a test" xmlns="http://www.topografix.com/GPX/1/1">\n'
        for track in tracks:
            text += f"<{kind}>" + ("<trkseg>" if segment else "")
            for i, (east, north) in enumerate(track):
                time = f"<time>{times[i]}</time>" if times else ""
                text += f'<{point} lat="{north:.10f}" lon="{east:.10f}"><ele>1</ele>{time}</{point}>'
            text += ("</trkseg>" if segment else "") + f"</{kind}>\n"
        (self.folder / name).write_text(text + "</gpx>\n")

    def geojson(self, name, geometry, **more):
        feature = {"type": "Feature", "properties": {}, "geometry": geometry}
        (self.folder / name).write_text(json.dumps({"type": "FeatureCollection", "features": [feature], **more}))

    def places(self, name, path, *more):
        """Where the ball is at its stations, from its rows."""
        scene = HEAD.replace("model: box", "model: scm") + f"  - {{name: a, {BALL}, path: {path}}}\noutput: {{forces: 1000}}\nsoil: {{name: dry_sand}}\n"
        self.ok("drive", self.scene(scene, f"{name}.yaml"), "--store", "base.furrow", "--overlay", f"{name}.furrow", "-o", name, *more)
        with open(self.folder / name / "objects.csv") as rows:
            return [(float(row["t"]), float(row["x"]), float(row["y"])) for row in csv.DictReader(rows)]

    def assert_near(self, found, wanted, tolerance):
        self.assertEqual(len(found), len(wanted))
        self.assertGreater(len(found), 50)
        for a, b in zip(found, wanted):
            self.assertLess(largest(abs(p - q) for p, q in zip(a, b)), tolerance, (a, b))

    def test_points_nowhere_and_unknown_coordinates_name_their_key(self):
        self.utm()
        ball = HEAD + f"  - {{name: a, {BALL}, path: {{points: [[15.0002, 45.15], [15.0005, 45.15]], speed: 8}}}}\ncoordinates: "
        car = (HEAD.split("redistribute")[0].replace("0.1", "0.002") + "soil: {name: dry_sand}\nredistribute: {model: scm}\ncoordinates: degrees\nvehicles:\n"
               "  - {name: car, model: one_wheel.xml, start: {at: [45.15, 115.0002]}}\n")
        shutil.copy(pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml", self.folder)
        result = self.furrow("drive", self.scene(car, "car.yaml"), "--store", "base.furrow", "-o", "x")
        if "this build has no MuJoCo" not in result.stderr:
            self.assertIn("car.yaml:9: vehicles.car.start.at: point 45.15, 115.0002: is no longitude and latitude in degrees; latitude and longitude swapped?", result.stderr)
        for scene, told in ((ball + "lonlat\n", r'lost.yaml: coordinates: SRS "lonlat": not understood.*, or degrees$'),
                            (ball.replace("[15.0002, 45.15]", "[45.15, 115.0002]") + "degrees\n", r"lost.yaml:\d+: a: path: point 45.15, 115.0002: is no longitude and latitude in degrees; latitude and longitude swapped\?"),
                            (ball.replace("[15.0002, 45.15]", "[45.15, 1115]") + "degrees\n", r"in degrees; metres from the south-west post need no")):
            self.assertRegex(self.refused(3, "drive", self.scene(scene, "lost.yaml"), "--store", "base.furrow", "-o", "x").strip(), told)

    def test_a_line_on_the_globe_is_the_same_way(self):
        self.utm()
        local = [[x - 500000, y - 5000000] for x, y in WAY]
        for more in ("", ", smooth: true", ", rotate: 10, offset: [1, 2]"):
            wanted = self.places("local", f"{{points: {local}, speed: 8{more}}}")
            self.gpx("track.gpx", [self.degrees])
            self.gpx("route.GPX", [self.degrees], "rte")
            self.geojson("line.geojson", {"type": "LineString", "coordinates": self.degrees})
            for name in ("track.gpx", "route.GPX", "line.geojson"):
                with self.subTest(name=name, more=more):
                    self.assert_near(self.places("globe", f"{{file: {name}, speed: 8{more}}}"), wanted, 1e-4)
                    for suffix in ("", "-wal", "-shm"):
                        (self.folder / f"globe.furrow{suffix}").unlink(missing_ok=True)
            (self.folder / "local.furrow").unlink()
        if MAPS:
            for name, path, system in (("globe", "{file: track.gpx, speed: 8}", "WGS 84 / UTM zone 33N (EPSG:32633)"), ("local", f"{{points: {local}, speed: 8}}", "south-west post")):
                self.places(name, path, "--steps", 60, "--map", "way.svg")
                self.assertIn(system, (self.folder / "way.svg").read_text())

    @long
    def test_degrees_are_those_of_the_stores_body(self):
        if not has_gdal():
            self.skipTest("needs GDAL's programs")
        rasters.make(self.folder / "mars.tif", 101, 101, [100.0] * 101 * 101, "f", step=0.00002, west=137.4, north=-4.6, srs="IAU_2015:49900")
        result = self.furrow("import", "mars.tif", "-o", "base.furrow")
        if "built without GDAL" in result.stderr:
            self.skipTest("built without GDAL")
        self.assertEqual(result.returncode, 0, result.stderr)
        store = self.json("info", "base.furrow")
        degrees = [(137.4004, -4.6014), (137.4010, -4.6012), (137.4014, -4.6006)]
        told = subprocess.run(["gdaltransform", "-s_srs", "IAU_2015:49900", "-t_srs", store["srs"], "-output_xy"], check=True, capture_output=True,
                              text=True, input="".join(f"{x} {y}\n" for x, y in degrees)).stdout
        metres = [tuple(map(float, line.split())) for line in told.splitlines()]
        local = [[x - store["origin"][0], y - store["origin"][1]] for x, y in metres]
        wanted = self.places("local", f"{{points: {local}, speed: 8}}")
        self.geojson("line.geojson", {"type": "LineString", "coordinates": degrees})
        self.assert_near(self.places("globe", "{file: line.geojson, speed: 8}"), wanted, 1e-4)
        points = [list(point) for point in degrees]
        self.assert_near(self.places("named", f"{{points: {points}, speed: 8}}", "--set", "coordinates=degrees"), wanted, 1e-4)
        point = self.json("query", "base.furrow", *degrees[0], "--srs", "degrees")["points"][0]
        self.assertLess(largest(abs(point[key] - value) for key, value in zip("xy", degrees[0])), 1e-9, point)
        window = ",".join(f"{value:.10f}" for value in (*degrees[0], *degrees[2]))
        self.ok("export", "base.furrow", "-o", "there.tif", "--window", window, "--window-srs", "degrees")
        self.ok("import", "mars.tif", "-o", "part.furrow", "--window", window, "--window-srs", "degrees")
        self.assertLess(self.json("info", "part.furrow")["posts"][0], 60)
        # Longitude and latitude of the Earth are refused, and the whole message is there.
        for command in (("query", "base.furrow", *degrees[0], "--srs", "EPSG:4326"),
                        ("import", "mars.tif", "-o", "x.furrow", "--window", window, "--window-srs", "EPSG:4326")):
            self.assertRegex(self.refused(3, *command), 'radius 6378 km, and .* "Mars .*", on one of 3396 km; .* give degrees$')

    def test_a_track_has_its_own_times(self):
        self.utm()
        stamps = ["2026-02-28T23:59:58Z", "2026-03-01T00:00:03Z", "2026-03-01T01:00:08.500+01:00"]
        self.gpx("track.gpx", [self.degrees], times=stamps)
        local = [(t, x - 500000, y - 5000000) for t, (x, y) in zip((0, 5, 10.5), WAY)]
        (self.folder / "poses.csv").write_text("".join(f"{t},{x},{y}\n" for t, x, y in local))
        self.assert_near(self.places("track", "{file: track.gpx}"), self.places("poses", "{file: poses.csv}"), 1e-4)

    def test_a_driver_follows_the_line_that_is_asked_for(self):
        self.utm()
        shutil.copy(pathlib.Path(__file__).parents[1] / "vehicle/one_wheel.xml", self.folder)
        self.gpx("ways.gpx", [self.degrees, self.globe([(500010, 5000080), (510000, 5000080)])])
        self.gpx("other.gpx", [self.globe([(500010, 5000080), (500090, 5900080)])])
        car = (HEAD.split("redistribute")[0].replace("0.1", "0.002") + "soil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
               "  - {name: car, model: one_wheel.xml, start: {at: [20, 20]}, driver: {path: {file: %s, speed: 1%s}, drive: [drive]}}\n")
        for file, line, off in (("ways.gpx", ", line: 1", False), ("ways.gpx", ", line: 2", True), ("other.gpx", "", True)):
            result = self.furrow("explain", self.scene(car % (file, line), "car.yaml"), "--store", "base.furrow", "--json")
            if "this build has no MuJoCo" in result.stderr:
                self.skipTest(result.stderr)
            self.assertEqual("driver.path: point 2" in result.stdout, off, (file, line, result.stderr))

    @long
    def test_one_of_several_lines(self):
        self.utm()
        other = self.globe([(500010, 5000080), (500090, 5000080)])
        local = self.places("local", "{points: [[10, 80], [90, 80]], speed: 8}")
        self.gpx("two.gpx", [self.degrees, other])
        self.geojson("two.geojson", {"type": "MultiLineString", "coordinates": [self.degrees, other]})
        for name in ("two.gpx", "two.geojson"):
            self.assertIn("it has 2 lines; say which: line: 1 to 2", self.refused(3, "explain", self.one(f"{{file: {name}, speed: 1}}")))
            self.assertIn("it has 2 lines, and line 3 is asked for", self.refused(3, "explain", self.one(f"{{file: {name}, speed: 1, line: 3}}")))
            self.assert_near(self.places(f"second-{name}", f"{{file: {name}, speed: 8, line: 2}}"), local, 1e-4)

    def one(self, path, more=""):
        return self.scene(HEAD + f"  - {{name: a, {BALL}, path: {path}}}\n" + more)

    def test_what_is_no_line_is_refused(self):
        self.utm()
        self.gpx("still.gpx", [self.degrees])
        self.gpx("back.gpx", [self.degrees], times=["2026-01-01T00:00:05Z", "2026-01-01T00:00:02Z", "2026-01-01T00:00:09Z"])
        self.gpx("empty.gpx", [])
        self.gpx("swapped.gpx", [[(45, 115), (45, 115.01)]])
        self.geojson("point.geojson", {"type": "Point", "coordinates": [15, 45]})
        self.geojson("metres.geojson", {"type": "LineString", "coordinates": WAY})
        self.geojson("utm.geojson", {"type": "LineString", "coordinates": WAY},
                     crs={"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}})
        (self.folder / "text.gpx").write_text("t,x,y\n0,1,2\n")
        (self.folder / "cut.gpx").write_text((self.folder / "still.gpx").read_text()[:-60])
        for path, told in (("{file: still.gpx}", "its points have no times; give a speed in m/s beside it"),
                           ("{file: back.gpx}", "point 2 is 3 s before the one before it; give a speed"),
                           ("{file: empty.gpx, speed: 1}", "it has no line; give a GPX file with a track or a route"),
                           ("{file: point.geojson, speed: 1}", "it has no line; give"),
                           ("{file: metres.geojson, speed: 1}", "is no longitude and latitude; both are degrees"),
                           ("{file: swapped.gpx, speed: 1}", "swapped.gpx\": point 1 has lat 115 and lon 45, which is no place; lat and lon are swapped"),
                           ("{file: utm.geojson, speed: 1}", "it is not in longitude and latitude; convert it: ogr2ogr"),
                           ("{file: text.gpx, speed: 1}", '"text.gpx": '),
                           ("{file: cut.gpx, speed: 1}", '"cut.gpx": '),
                           ("{file: none.gpx, speed: 1}", "there is no such file"),
                           ("{file: poses.csv, speed: 1}", "objects[0].path.speed: does not go with a file of poses")):
            with self.subTest(path=path):
                self.assertIn(told, self.refused(3, "drive", self.one(path), "--store", "base.furrow", "-o", "out"))
        # A store that lies nowhere.
        self.ok("synth", "-o", "nowhere.furrow", "--posts", "129x129", "--spacing", "1", "--kind", "plain")
        self.assertIn("the store has no reference system and lies nowhere on the globe; give points in metres, or import again with --s-srs EPSG:",
                      self.refused(3, "drive", self.one("{file: still.gpx, speed: 1}"), "--store", "nowhere.furrow", "-o", "out"))
        # What a path that is far off is told.
        ball = HEAD + f"  - {{name: a, {BALL}, path: {{points: [%s], speed: 8}}}}\ncoordinates: %s\n"
        degrees = [", ".join(str(list(pair)[::step]) for pair in self.degrees[:2]) for step in (-1, 1)]
        far = "[500000, 4000000], [500010, 4000000]"
        for points, coordinates, told in ((degrees[0], "degrees", "; are its longitude and latitude swapped?"), (far, "EPSG:32634", "; is coordinates: EPSG:32634 right?"),
                                          ("[10, 20], [20, 20]", "degrees", "; is coordinates: degrees right?"),
                                          (far, "local", "; if these are coordinates of a reference system, say which in coordinates")):
            notes = [note for note in self.json("explain", self.scene(ball % (points, coordinates)), "--store", "base.furrow")["notes"] if "is off the terrain" in note]
            self.assertTrue(len(notes) == 1 and notes[0].endswith(told), (told, notes))
        # A line that leaves the terrain is told as any path is.
        self.geojson("far.geojson", {"type": "LineString", "coordinates": self.globe([(500050, 5000050), (500250, 5000050)])})
        self.refused(1, "drive", self.one("{file: far.geojson, speed: 8}", "outside: stop\n"), "--store", "base.furrow", "-o", "far")


if __name__ == "__main__":
    main()
