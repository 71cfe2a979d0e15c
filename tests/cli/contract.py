"""The command's contract: what each subcommand prints, what it refuses, and with which status."""
import hashlib
import json
import os
import pathlib
import re
import subprocess
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, MAPS, SCENE, SHARED, FurrowTest, has_gdal, long, main, part, sampled, write_png16

NO_GL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json", "EGL_PLATFORM": "surfaceless"}


class Usage(FurrowTest):
    def test_help_of_every_command_explains_it(self):
        overview = self.ok("--help")
        for command in sampled("synth import info verify query export edit reset branch snapshot log restore merge flatten relink explain drive rig mobility view cache-sim".split()):
            self.assertIn(command, overview)
            self.assertIn("usage: furrow " + command, self.ok(command, "--help"))

    def test_wrong_usage_is_status_2(self):
        for arguments in sampled((["frobnicate"], ["info"], ["info", "a", "b"], ["info", "a", "--frob"], ["synth", "-o"],
                          ["synth", "-o", "x.furrow", "--posts", "12", "--spacing", "1"],
                          ["synth", "-o", "x.xyz", "--posts", "12x12", "--spacing", "1"],
                          ["import", "a.tif"], ["import", "a.tif", "-o", "b.furrow", "--tile", "100.5"],
                          ["export", "s.furrow", "-o", "x.tif", "--layer", "mood"],
                          ["query", "s.furrow", "1"], ["drive", "s.yaml"], ["drive", "s.yaml", "-o", "d", "--set", "x"])):
            with self.subTest(arguments=arguments):
                self.refused(2, *arguments)
        self.assertEqual(self.furrow().returncode, 2)

    def test_a_negative_number_is_a_value(self):
        store = self.synth(posts="65x65")
        point = self.json("query", store, "-3", "4")
        self.assertTrue(point["nodata"])
        self.assertIsNone(point["height"])


class BadInput(FurrowTest):
    def test_missing_empty_garbage_and_truncated_stores_are_status_3(self):
        store = self.synth(posts="600x600")
        (self.folder / "empty.furrow").touch()
        (self.folder / "garbage.furrow").write_bytes(b"this is no store" * 500)
        (self.folder / "short.furrow").write_bytes(store.read_bytes()[:30000])
        for name in ("missing.furrow", "empty.furrow", "garbage.furrow", "short.furrow"):
            for command in sampled((["info"], ["verify"], ["query"], ["reset"])):
                with self.subTest(name=name, command=command):
                    self.assertIn(name, self.refused(3, command[0], name, *(["1", "1"] if command == ["query"] else [])))
            with self.subTest(name=name, command="drive"):
                self.refused(3, "drive", self.scene(), "--store", name, "-o", "out")
                self.assertFalse((self.folder / "out").exists())

    def test_what_to_do_is_told_behind_a_long_path(self):
        path = "/".join(["folder-of-a-long-name"] * 45 + ["missing.furrow"])
        self.assertIn(path, self.refused(3, "info", path))

    def test_a_drive_that_cannot_start_leaves_nothing(self):
        self.synth(posts="65x65")
        self.assertIn("no/trace:", self.refused(1, "drive", self.scene(), "--store", "world.furrow", "--overlay", "o.furrow", "-o", "out", "--trace", "no/trace"))
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["scene.yaml", "world.furrow"])

    def test_a_scene_may_begin_with_a_byte_order_mark(self):
        self.assertEqual(self.json("explain", self.scene(), "--json"), self.json("explain", self.scene("\ufeff" + SCENE), "--json"))
        self.assertIn(":2:1: time_ste: unknown key", self.refused(3, "explain", self.scene("\ufeff" + SCENE.replace("time_step", "time_ste"))))

    def test_slots_below_what_a_step_needs_are_refused_with_the_number(self):
        """Before anything is made; and with that number of slots it runs, within what it says it takes."""
        self.ok("synth", "-o", "dem.png", "--posts", "513x513", "--spacing", "1")
        self.ok("import", "dem.png", "-o", "small.furrow", "--tile", "64", "--spacing", "1")
        scene = self.scene("""
scene: 1
time_step: 0.1
end_time: 2
objects:
  - name: plate
    shape: {box: {size: [120, 80, 2]}}
    path: {points: [[150, 150], [330, 350]], speed: 40}
    sink: 0.2
cache: {slots: 4}
""")
        told = self.refused(3, "drive", scene, "--store", "small.furrow", "-o", "out")
        needed = int(re.search(r"there are 4 slots; give at least (\d+)", told).group(1))
        self.assertFalse((self.folder / "out").exists())
        self.refused(3, "drive", scene, "--store", "small.furrow", "-o", "out", "--set", f"cache.slots={needed - 1}")
        run = json.loads(self.ok("drive", scene, "--store", "small.furrow", "-o", "out", "--json", "--set",
                                 f"cache.slots={needed}"))
        self.assertLessEqual(run["tiles_per_window"], needed)
        self.assertGreater(run["tiles_per_window"], 4)
        budget, memory = run["memory"]["budget"], run["memory"]
        self.assertEqual(budget["total"], sum(budget[name] for name in ("slots", "loads", "queue", "ground")))
        self.assertLessEqual(memory["host_bytes"], budget["loads"] + budget["queue"])
        self.assertLessEqual(sum(memory["plane_bytes"].values()), budget["slots"])

    @long
    def test_the_slots_asked_for_are_enough_wherever_the_object_lies_between_posts(self):
        self.ok("synth", "-o", "dem.png", "--posts", "129x129", "--spacing", "1")
        self.ok("import", "dem.png", "-o", "tiny.furrow", "--tile", "8", "--spacing", "1")
        for radius in (0.28, 0.305, 0.345, 0.37):
            scene = self.scene(f"""
scene: 1
time_step: 0.1
end_time: 1
spacing: 0.125
objects:
  - {{name: ball, shape: {{sphere: {{radius: {radius}}}}}, path: {{points: [[20, 20], [100, 90]], speed: 60}}, sink: 0.05}}
""")
            told = self.furrow("drive", scene, "--store", "tiny.furrow", "-o", "out", "--set", "cache.slots=4").stderr
            found = re.search(r"give at least (\d+)", told)
            run = json.loads(self.ok("drive", scene, "--store", "tiny.furrow", "-o", "out", "--json", "--set",
                                     f"cache.slots={found.group(1) if found else 4}"))
            self.assertLessEqual(run["tiles_per_window"], int(found.group(1)) if found else 4)

    def test_missing_empty_and_garbage_sources_are_status_3_and_leave_nothing(self):
        (self.folder / "empty.tif").touch()
        (self.folder / "garbage.tif").write_bytes(b"II*\0 and then nothing of use" * 20)
        (self.folder / "empty.png").touch()
        for name in ("missing.tif", "empty.tif", "garbage.tif", "empty.png"):
            with self.subTest(name=name):
                self.assertIn(name, self.refused(3, "import", name, "-o", "out.furrow"))
                self.assertEqual(sorted(p.name for p in self.folder.glob("out.furrow*")), [])

    def test_an_existing_store_is_not_overwritten_unless_asked(self):
        store = self.synth(posts="65x65")
        before = store.read_bytes()
        self.refused(3, "synth", "-o", store, "--posts", "65x65", "--spacing", "1")
        self.assertEqual(store.read_bytes(), before)

    def test_a_dry_run_makes_nothing_and_tells_what_is_in_the_way(self):
        store = self.synth(posts="33x33")
        self.ok("synth", "-o", "dem.png", "--posts", "33x33", "--spacing", "1")
        before = store.read_bytes()
        for options, told in (([], True), (["--overwrite"], False)):
            result = self.furrow("import", "dem.png", "-o", store, "--dry-run", *options)
            self.assertEqual((result.returncode, "exists" in result.stderr), (0, told))
        self.assertEqual(store.read_bytes(), before)

    def test_only_a_store_is_ever_replaced(self):
        """Not a DEM whose name was given by mistake, its own source's above all."""
        self.ok("synth", "-o", "dem.png", "--posts", "33x33", "--spacing", "1")
        before = (self.folder / "dem.png").read_bytes()
        (self.folder / "folder").mkdir()
        for name in ("dem.png", "folder"):
            self.assertIn("no Furrow store", self.refused(3, "import", "dem.png", "-o", name, "--overwrite"))
        self.assertEqual((self.folder / "dem.png").read_bytes(), before)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["dem.png", "folder"])

    def test_a_png_with_holes(self):
        png = self.folder / "grey.png"
        write_png16(png, 80, 70, lambda x, y: 0 if 30 < x < 40 and 20 < y < 30 else 100 + x + y)
        self.ok("import", png, "-o", "holes.furrow", "--nodata", "0")
        # Row 0 is south: y = 25 from the top is 44 from the bottom.
        self.assertTrue(self.json("query", "holes.furrow", "35", "44")["nodata"])
        self.assertEqual(self.json("query", "holes.furrow", "10", "20")["height"], 100 + 10 + 49)
        for name in ("back.png", "back.r16"):
            told = self.furrow("export", "holes.furrow", "-o", name)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertRegex(told.stderr, r"furrow: note: back\.\w+: 81 posts have no data; they are 0, ")
        self.ok("import", "back.png", "-o", "back.furrow", "--nodata", "0")
        self.assertTrue(self.json("query", "back.furrow", "35", "44")["nodata"])
        raw = struct.unpack("<5600H", (self.folder / "back.r16").read_bytes())  # the northern row first
        self.assertEqual(list(raw), [0 if 30 < x < 40 and 20 < y < 30 else 100 + x + y for y in range(70) for x in range(80)])
        self.ok("export", "holes.furrow", "-o", "shade.png", "--layer", "hillshade")
        scene = self.scene(SCENE.replace("[20, 20], [120, 90], [40, 130]", "[10, 40], [70, 48]")
                           .replace("[22, 18], [122, 88], [42, 128]", "[10, 20], [70, 20]"))
        result = self.furrow("drive", scene, "--store", "holes.furrow", "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"furrow: left: no ground under it at .* after .* s: it is over a hole of the terrain; .*")
        self.assertEqual(json.loads((self.folder / "out/run.json").read_text())["ended"], "failed")
        report = self.drive(scene, "--store", "holes.furrow", "--set", "outside=skip")
        self.assertGreater(report["objects"]["left"]["skipped"], 0)
        self.assertTrue(self.json("verify", "holes.furrow")["ok"])

    def test_more_relief_than_the_lattice_holds_imports_but_is_not_driven_on(self):
        png = self.folder / "full.png"
        write_png16(png, 80, 70, lambda x, y: 800 * x)
        self.ok("import", png, "-o", "full.furrow")
        self.assertEqual(self.json("query", "full.furrow", "10", "20")["height"], 8000)
        self.assertIn("relief", self.refused(3, "drive", self.scene(), "--store", "full.furrow", "-o", "out"))
        self.ok("import", png, "-o", "half.furrow", "--height-range", "0,500")
        self.assertAlmostEqual(self.json("query", "half.furrow", "10", "20")["height"], 8000 / 65535 * 500, delta=0.01)

    def test_a_scene_with_a_wrong_key_names_file_line_and_what_is_allowed(self):
        store = self.synth(posts="65x65")
        scene = self.scene(SCENE.replace("sink: 0.15", "sunk: 0.15", 1))
        error = self.refused(3, "drive", scene, "--store", store, "-o", "out")
        self.assertRegex(error, r"scene\.yaml:8:\d+: .*sunk.*sink")
        self.assertFalse((self.folder / "out/run.json").exists())

    def test_a_soil_that_lacks_what_the_model_reads_is_refused_before_anything_is_driven(self):
        store = self.synth(posts="65x65")
        for soil, key in (("{name: mud}", "soil.name"), ("{name: sand, cohesion: 0}", "soil.name"),
                          ("{map: no.png, classes: {4: snow}, default: lunar}", "soil.classes[0].name"),
                          ("{map: no.png, classes: {4: lunar}, default: mud}", "soil.default.name")):
            if "map" in soil:
                write_png16(self.folder / "no.png", 65, 65, lambda x, y: 1)
            scene = self.scene(SCENE.replace("redistribute: {model: box}", f"soil: {soil}\nredistribute: {{model: scm}}"))
            for command in (["drive", scene, "--store", store, "-o", "out"], ["explain", scene]):
                error = self.refused(3, *command)
                name = re.search(r"mud|sand|snow", soil).group()
                self.assertRegex(error, rf"scene\.yaml:\d+:\d+: {re.escape(key)}: {name} has no bekker_kc, bekker_kphi, bekker_n, ")
                self.assertIn("which model scm reads; give these beside the name, or name one of dry_sand, sandy_loam_15, ", error)
                self.assertEqual("cohesion" in error, "cohesion" not in soil)
            self.assertFalse((self.folder / "out/run.json").exists())

    def test_a_machine_without_gl_is_status_4(self):
        store = self.synth(posts="65x65")
        before = self.ok("info", store)
        self.assertIn("GL", self.refused(4, "drive", self.scene(), "--store", store, "-o", "out", "--set", "compute=gpu", env=NO_GL))
        self.assertEqual(self.ok("info", store), before)
        # Everything else works there.
        self.assertTrue(self.json("verify", store, env=NO_GL)["ok"])
        self.json("info", store, env=NO_GL)
        told = self.furrow("drive", self.scene(), "--store", store, "-o", "out", "--set", "compute=gpu", env={"MESA_GL_VERSION_OVERRIDE": "3.3"})
        if told.returncode != 0:  # drivers other than Mesa's do not listen
            self.assertIn("GL: the driver has no OpenGL 4.5 core context", self.told(4, told))

    def test_a_drive_that_deforms_nothing_fixes_no_spacing(self):
        store = self.synth()
        scene = self.scene(SCENE.replace("[20, 20]", "[-5, 20]"))
        result = self.furrow("drive", scene, "--store", store, "-o", "out")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIsNone(self.json("info", store)["working_level"])
        self.drive(self.scene(), "--store", store, "--set", "spacing=0.125")

    def test_another_spacing_is_refused_until_reset(self):
        store = self.synth()
        self.drive(self.scene(), "--store", store)
        error = self.refused(3, "drive", self.scene(), "--store", store, "-o", "out", "--set", "spacing=0.125")
        self.assertIn("reset", error)
        self.ok("reset", store)
        self.drive(self.scene(), "--store", store, "--set", "spacing=0.125")


class RoundTrips(FurrowTest):
    @unittest.skipUnless(has_gdal(), "needs gdal_translate")
    def test_a_geotiff_comes_back_as_it_was(self):
        self.ok("synth", "-o", "in.tif", "--posts", "301x233", "--spacing", "2", "--relief", "90")
        self.ok("import", "in.tif", "-o", "s.furrow", "--max-error", "0", "--spacing", "2")
        self.ok("export", "s.furrow", "-o", "out.tif", "--layer", "base")
        checksums = []
        for name in ("in.tif", "out.tif"):
            info = json.loads(subprocess.run(["gdalinfo", "-json", "-checksum", str(self.folder / name)], check=True,
                                             capture_output=True, text=True).stdout)
            checksums.append((info["size"], info["bands"][0]["checksum"]))
        self.assertEqual(*checksums)

    def test_a_png_comes_back_as_it_was(self):
        write_png16(self.folder / "in.png", 100, 61, lambda x, y: 7 * x + 300 * y)
        self.ok("import", "in.png", "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "out.png")
        self.ok("import", "out.png", "-o", "t.furrow")
        for x, y in ((0, 0), (99, 60), (50, 30)):
            self.assertEqual(self.json("query", "s.furrow", x, y)["height"], 7 * x + 300 * (60 - y))
            self.assertEqual(self.json("query", "t.furrow", x, y)["height"], 7 * x + 300 * (60 - y))

    def test_an_export_tells_what_it_replaced_and_what_unreal_takes(self):
        store = self.synth(posts="300x257", spacing=0.5)
        told = self.furrow("export", store, "-o", "a.r16", "--height-range", "-500,500")
        self.assertIn("300 x 257 posts are no size of Unreal's Landscape; the nearest that lies within is 253 x 253: --window 0,0,126,126\n", told.stderr)
        self.assertNotIn("replaced", told.stdout)
        told = self.furrow("export", store, "-o", "a.r16", "--height-range", "-500,500", "--window", "0,0,126,126")
        self.assertEqual((told.stderr, told.stdout), ("", "a.r16: surface, 253 x 253 posts, 0.5 m apart; the file that was there is replaced\n"))
        self.assertEqual(self.furrow("export", store, "-o", "b.r16", "--height-range", "-500,500", "--window", "0,0,128,128").stderr, "")
        self.assertIn("name a .tif", self.refused(2, "export", store, "-o", "a.asc"))

    def test_a_heightmap_of_16_bits_comes_back_within_its_step(self):
        for relief, low, high in part(((40, -100, 100), (3, -5, 7), (900, -2000, 2500)), 1):
            store = self.synth(posts="129x129", spacing=2, relief=relief)
            for name in ("map.r16", "map.raw", "map.png"):
                self.ok("export", store, "-o", name, "--height-range", f"{low},{high}")
                self.ok("import", self.folder / name, "-o", "back.furrow", "--height-range", f"{low},{high}", "--spacing", "2", "--overwrite")
                for x, y in ((0, 0), (256, 256), (40, 198), (254, 2)):
                    difference = self.json("query", "back.furrow", x, y)["height"] - self.json("query", store, x, y)["height"]
                    # Half a step of 16 bits, and what both imports may be off.
                    bound = sum(self.json("info", each)["max_error"] for each in (store, "back.furrow"))
                    self.assertLess(abs(difference), (high - low) / 65535 / 2 + bound + 1e-6)
            self.assertEqual((self.folder / "map.r16").read_bytes(), (self.folder / "map.raw").read_bytes())
            self.assertIn("16 bits", self.refused(3, "export", store, "-o", "no.r16", "--height-range", "0,0.01"))
            self.refused(2, "export", store, "-o", "no.raw", "--layer", "hillshade")
            self.refused(2, "export", store, "-o", "no.raw", "--layer", "offset")
            self.assertEqual(list(self.folder.glob("no.*")), [])

    def test_any_number_of_jobs_makes_the_same_store(self):
        write_png16(self.folder / "in.png", 400, 310, lambda x, y: 7 * x + 30 * y)
        for jobs in (1, 2, 5):
            self.ok("import", "in.png", "-o", f"jobs{jobs}.furrow", "--tile", "32", "--jobs", jobs)
            self.assertTrue(self.json("verify", f"jobs{jobs}.furrow")["ok"])
        infos = [self.json("info", f"jobs{jobs}.furrow") for jobs in (1, 2, 5)]
        self.assertEqual(infos[0], infos[1])
        self.assertEqual(infos[0], infos[2])

    @long
    def test_any_number_of_jobs_makes_the_same_synthetic_terrain(self):
        made = []
        for jobs in (1, 2, 5):
            terrain = ("--posts", "300x263", "--spacing", "1", "--jobs", jobs, "-o")
            self.ok("synth", *terrain, f"jobs{jobs}.furrow")
            self.ok("synth", *terrain, f"jobs{jobs}.png")
            picture = hashlib.sha256((self.folder / f"jobs{jobs}.png").read_bytes()).hexdigest()
            made.append((self.json("info", f"jobs{jobs}.furrow"), picture))
        self.assertEqual(made[0], made[1])
        self.assertEqual(made[0], made[2])
        for jobs in (0, 65):
            self.refused(2, "synth", *terrain, "none.furrow", "--jobs", jobs)

    def test_info_holds_what_the_contract_names(self):
        info = self.json("info", self.synth(posts="600x400", spacing=2))
        for key in ("tile spacing posts levels srs geotransform vertical origin bounds nodata max_error height tiles "
                    "bytes soil compacted sources last_run base_hash base").split():
            self.assertIn(key, info)
        self.assertEqual(info["posts"], [600, 400])
        self.assertEqual(info["levels"], [0, 2])
        self.assertEqual(info["tiles"], {"base": 6 + 2 + 1, "offset": 0, "soil": 0})
        self.assertEqual(info["geotransform"], [-1, 2, 0, 799, 0, -2])
        self.assertIsNone(info["last_run"])

    def test_query_reads_points_from_stdin(self):
        store = self.synth(posts="65x65")
        points = self.json("query", store, stdin="1 1\n2.5,3\n\n64 64\n65 1\n")["points"]
        self.assertEqual([p["nodata"] for p in points], [False, False, False, True])
        self.refused(3, "query", store, stdin="1 one\n")
        self.refused(3, "query", store, stdin="1 1 1\n")

    def test_query_casts_rays(self):
        store = self.synth(posts="65x65")
        # Straight down is the surface at that point; at a post that is the height.
        for x, y in ((10, 20), (31.25, 7.75), (64, 64), (0, 0)):
            answer = self.json("query", store, x, y, "--ray", f"{x},{y},9000,0,0,-3")
            point, ray = answer["points"][0], answer["rays"][0]
            self.assertAlmostEqual(ray["distance"], 9000 - point["surface"], places=6)
            self.assertAlmostEqual(ray["point"][2], point["surface"], places=6)
            self.assertEqual((ray["normal"], ray["hit"], ray["below"]), (point["normal"], True, False))
            if x == int(x):
                self.assertAlmostEqual(point["surface"], point["height"], places=5)
        up = self.json("query", store, "--ray=10,20,-9000,0,0,1")
        self.assertEqual((up["hit"], up["below"], up["points"]), (True, True, []))
        self.assertFalse(self.json("query", store, "--ray", "10,20,9000,0,0,1")["hit"])
        self.assertFalse(self.json("query", store, "--ray", "-10,20,9000,0,0,-1")["hit"])
        lines = self.ok("query", store, stdin="1 1\n1 1 9000 0 0 -1\n1 1 9000 0 0 1\n").splitlines()
        self.assertIn("height", lines[0])
        self.assertIn("distance", lines[1])
        self.assertTrue(lines[2].endswith("none"))
        for ray in ("1,2,3", "1,2,3,0,0,0", "1,2,3,0,0,x", "1,2,3,0,0,1,7", "1,2,nan,0,0,1", "1,2,3,0,0,1,"):
            self.refused(2, "query", store, "--ray", ray)
        self.refused(3, "query", store, stdin="1 1 1 0 0 0\n")


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", data[16:24])


class Maps(FurrowTest):
    def test_what_deformation_left_is_a_map_in_false_colour(self):
        store = self.synth()
        self.ok("export", store, "-o", "none.png", "--layer", "offset")
        self.drive(self.scene(), "--store", store)
        for arguments in ([], ["--window", "10,10,60,60"], ["--level", "0"], ["--level", "-4"], ["--height-range=-0.1,0.2"],
                          ["--sun", "90,30", "--exaggerate", "3"]):
            with self.subTest(arguments=arguments):
                told = self.ok("export", store, "-o", "ruts.png", "--layer", "offset", *arguments)
                width, height, posts_x, posts_y = map(int, re.search(r"a map of offset, (\d+) x (\d+) pixels, of (\d+) x (\d+) posts",
                                                                     told).groups())
                self.assertEqual(png_size(self.folder / "ruts.png"), (width, height))
                self.assertTrue(posts_x < width and posts_y < height)
                self.assertLessEqual(max(posts_x, posts_y), 4096)
        self.assertEqual(list(self.folder.glob("*.part")), [])

    @long
    def test_a_pixel_a_post_or_a_coarser_level(self):
        store = self.synth(posts="1025x9")
        for level, wanted in ((0, "1025 x 9 posts, 1 m"), (2, "257 x 3 posts, 4 m"), (-1, "2049 x 17 posts, 0.5 m"),
                              (-2, "2049 x 17 posts, 0.5 m"), (-3, "2049 x 17 posts, 0.5 m")):  # 4097 are more than are drawn
            told = self.ok("export", store, "-o", "a.png", "--layer", "offset", "--level", level)
            self.assertIn(wanted, told)

    def test_the_soils_state_is_a_map_too(self):
        store = self.synth()
        scene = self.scene(SCENE.replace("redistribute: {model: box}", "soil: {name: dry_sand}\nredistribute: {model: scm}"))
        self.drive(scene, "--store", store, "--set", "cache.slots=32")
        for layer in ("deposited", "plastic_sinkage", "shear"):
            for level in ("-2", "0"):
                self.assertIn("a map of " + layer, self.ok("export", store, "-o", layer + ".png", "--layer", layer, "--level", level))
        self.ok("export", store, "-o", "p.png", "--layer", "pressed", "--height-range", "0,0.05")
        self.refused(2, "export", store, "-o", "p.png", "--layer", "pressed", "--height-range", "0.01,0.05")
        self.refused(2, "export", store, "-o", "p.png", "--layer", "heaped", "--height-range", "0,0.05")

    def test_what_is_no_picture_is_refused_and_leaves_nothing(self):
        store = self.synth(posts="65x65")
        for status, arguments in sampled(((2, ["--layer", "quanta"]), (2, ["--layer", "offset", "--height-range", "0,1"]),
                                  (2, ["--layer", "offset", "--height-range", "1,-1"]), (2, ["--layer", "surface", "--sun", "0,45"]),
                                  (2, ["--layer", "hillshade", "--sun", "0,5"]), (2, ["--layer", "hillshade", "--exaggerate", "0"]),
                                  (2, ["--exaggerate", "2"]), (3, ["--layer", "offset", "--level", "9"]),
                                  (3, ["--layer", "offset", "--window", "100,100,200,200"]))):
            with self.subTest(arguments=arguments):
                self.refused(status, "export", store, "-o", "out.png", *arguments)
        self.refused(1, "export", store, "-o", "no/such/folder/out.png", "--layer", "offset")
        if os.path.exists("/dev/full"):
            (self.folder / "full.png.part").symlink_to("/dev/full")
            self.assertIn("No space left", self.refused(1, "export", store, "-o", "full.png", "--layer", "offset"))
        self.assertEqual([path.name for path in self.folder.glob("*.png*")], [])

    def test_a_hillshade_is_grey_and_a_sun_from_elsewhere_is_another(self):
        store = self.synth(posts="65x65")
        made = []
        for arguments in ([], ["--sun", "315,45"], ["--sun", "135,45"], ["--exaggerate", "4"]):
            self.ok("export", store, "-o", "a.png", "--layer", "hillshade", *arguments)
            data = (self.folder / "a.png").read_bytes()
            self.assertEqual(struct.unpack(">IIBB", data[16:26]), (65, 65, 8, 0))  # 8 bits, grey
            made.append(data)
        self.assertEqual(made[0], made[1])
        self.assertEqual(len(set(made)), 3)

    @long
    @unittest.skipUnless(has_gdal(), "needs gdal_translate")
    def test_a_hillshade_keeps_its_place(self):
        self.ok("synth", "-o", "a.tif", "--posts", "65x65", "--spacing", "2")
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32633", "-a_ullr", "500000", "4000130", "500130", "4000000",
                        str(self.folder / "a.tif"), str(self.folder / "utm.tif")], check=True)
        self.ok("import", "utm.tif", "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "shade.tif", "--layer", "hillshade", "--window", "20,20,60,60")
        info = json.loads(subprocess.run(["gdalinfo", "-json", str(self.folder / "shade.tif")], check=True,
                                         capture_output=True, text=True).stdout)
        self.assertIn("UTM zone 33N", info["coordinateSystem"]["wkt"])
        self.assertEqual(info["bands"][0]["type"], "Byte")
        self.assertEqual(info["bands"][0]["noDataValue"], 0)
        self.assertEqual(info["geoTransform"], [500020, 2, 0, 4000062, 0, -2])

    @unittest.skipUnless(has_gdal(), "needs gdal_translate")
    def test_a_window_in_a_reference_system(self):
        self.ok("synth", "-o", "a.tif", "--posts", "65x65", "--spacing", "2")
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32633", "-a_ullr", "500000", "4000130", "500130", "4000000",
                        str(self.folder / "a.tif"), str(self.folder / "utm.tif")], check=True)
        self.ok("import", "utm.tif", "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "local.tif", "--window", "20,20,60,60")
        wanted = (self.folder / "local.tif").read_bytes()
        for srs, window in (("store", "500021,4000021,500061,4000061"), ("EPSG:32633", "500021,4000021,500061,4000061")):
            self.ok("export", "s.furrow", "-o", "there.tif", "--window", window, "--window-srs", srs)
            self.assertEqual((self.folder / "there.tif").read_bytes(), wanted, srs)
        # gdaltransform has the degrees of its corners; a slanted window becomes the rectangle around it.
        told = subprocess.run(["gdaltransform", "-s_srs", "EPSG:32633", "-t_srs", "EPSG:4326", "-output_xy"], check=True, capture_output=True,
                              text=True, input="500022 4000022\n500060 4000060\n").stdout.split()
        self.ok("export", "s.furrow", "-o", "there.tif", "--window", ",".join(told), "--window-srs", "EPSG:4326")
        self.assertEqual((self.folder / "there.tif").read_bytes(), (self.ok("export", "s.furrow", "-o", "inner.tif", "--window", "21,21,59,59"),
                                                                    (self.folder / "inner.tif").read_bytes())[1])
        self.ok("map", "s.furrow", "-o", "there.png", "--window", ",".join(told), "--window-srs", "EPSG:4326")
        self.assertIn("there is no window", self.refused(2, "export", "s.furrow", "-o", "x.tif", "--window-srs", "store"))
        self.ok("synth", "-o", "nowhere.furrow", "--posts", "65x65", "--spacing", "1")
        self.assertIn("or import again with --s-srs EPSG:", self.refused(3, "export", "nowhere.furrow", "-o", "x.tif", "--window", "1,1,9,9", "--window-srs", "EPSG:4326"))

    @unittest.skipUnless(has_gdal(), "needs gdal_translate")
    def test_coordinates_without_their_system_are_found_out(self):
        self.ok("synth", "-o", "a.tif", "--posts", "65x65", "--spacing", "2")
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32611", "-a_ullr", "400000.1234567", "4000130.7654321", "400130.1234567", "4000000.7654321",
                        str(self.folder / "a.tif"), str(self.folder / "utm.tif")], check=True)
        self.ok("import", "utm.tif", "-o", "s.furrow")
        told = subprocess.run(["gdaltransform", "-s_srs", "EPSG:32611", "-t_srs", "EPSG:4326", "-output_xy"], check=True, capture_output=True,
                              text=True, input="400022 4000022\n400060 4000060\n").stdout.split()
        for window, words in ((["400022", "4000022", "400060", "4000060"], "inside as coordinates of WGS 84 / UTM zone 11N (EPSG:32611); give {} store"),
                              (told, "inside as longitude and latitude; give {} degrees"),
                              ([told[i] for i in (1, 0, 3, 2)], "inside as latitude and longitude; give longitude first, and {} degrees")):
            for command, name in (("map", "x.png"), ("export", "x.tif")):
                self.assertIn(words.format("--window-srs"), self.refused(3, command, "s.furrow", "-o", name, "--window", ",".join(window)))
            # A hint comes once.
            for arguments, points in ((window, None), (["--ray", f"{window[0]},{window[1]},9000,0,0,-1"], None), ([], f"{window[0]} {window[1]}\n" * 3)):
                asked = self.furrow("query", "s.furrow", *arguments, stdin=points)
                self.assertEqual(asked.returncode, 0, asked.stderr)
                self.assertRegex(asked.stderr, rf"^furrow: note: query: \S+ \S+: is outside the terrain, but {re.escape(words.format('--srs'))}\n$")
        for arguments in (["-5", "-5"], ["--ray", "5,5,9000,0,0,1"], ["400022", "4000022", "--srs", "store"], ["1", "1", "--srs", "store"]):
            self.assertEqual(self.furrow("query", "s.furrow", *arguments).stderr, "", arguments)
        # info tells the south-west post so that it is found.
        origin = re.search(r"^origin +(\S+), (\S+) ", self.ok("info", "s.furrow"), re.M).groups()
        self.assertNotIn("outside", self.ok("query", "s.furrow", *origin, "--srs", "store"))


class Drives(FurrowTest):
    def test_info_tells_soil_that_was_compacted_in_m3_as_run_json_does(self):
        store = self.synth()
        compacted = self.drive(self.scene(SCENE.replace("box", "scm, bulldozing: 0").replace("attributes: [dirt]", "soil: {name: dry_sand}")
                                           .replace("sink: 0.15", "load: 900")), "--store", store, "--steps", 20)["volume"]["compacted"]
        self.assertGreater(compacted, 0)
        self.assertRegex(self.ok("info", store), rf"\ncompacted +{compacted:.6g} m3\n")

    def test_no_pictures_of_a_scene_without_a_view_are_no_change(self):
        scene = self.scene()
        plan = self.json("explain", scene, "--store", self.synth())
        self.assertEqual(self.json("explain", scene, "--store", "world.furrow", "--set", "view.images=0")["effects"], plan["effects"])
        self.assertIn("view.camera: is missing", self.refused(3, "explain", scene, "--store", "world.furrow", "--set", "view.images=1"))

    def test_a_drive_leaves_ruts_figures_and_a_clean_store(self):
        store = self.synth()
        report = self.drive(self.scene(), "--store", store)
        for key in ("ended steps seconds processor_seconds rtf fps steps_per_second step_ms stage_ms cache passes gl memory programs io volume "
                    "objects").split():
            self.assertIn(key, report)
        self.assertEqual(report["ended"], "complete")
        self.assertEqual(report["steps"], 80)
        self.assertIsNone(report["fps"])  # no picture
        self.assertEqual(sorted(report["steps_per_second"]), ["mean", "p50", "p99"])
        self.assertAlmostEqual(report["steps_per_second"]["p99"] * report["step_ms"]["p99"], 1000, places=6)
        self.assertGreater(report["volume"]["removed"], 1)
        self.assertAlmostEqual(report["objects"]["left"]["sinkage"], 0.15, places=4)
        self.assertAlmostEqual(report["objects"]["left"]["distance"], 120, delta=1)
        check = self.json("verify", store)
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["offset_sum"]["-2"], report["volume"]["quanta"]["net"])
        self.assertEqual((check["compacted"], report["volume"]["quanta"]["compacted"], report["volume"]["compacted"]), (0, 0, 0))
        # The second station's place, on the path: the wheel's lowest point is sink below the base.
        point = self.json("query", store, "70", "55")
        self.assertLess(point["offset"], -0.05)
        self.assertGreater(point["soil"]["dirt"], 0)
        # A ray meets the rut, where it is finer than its source.
        ray = self.json("query", store, "--ray", "70,55,9000,0,0,-1")
        self.assertEqual(ray["level"], -2)
        self.assertAlmostEqual(ray["point"][2], point["height"], places=5)
        epochs = (self.folder / "out/epochs.log").read_text().splitlines()
        self.assertEqual(len(epochs), report["io"]["commits"])
        # Ruts are exported where they are exact, unless another level is asked for.
        self.assertIn("0.25 m apart", self.ok("export", store, "-o", "ruts.tif", "--layer", "quanta") if has_gdal()
                      else "0.25 m apart")
        info = self.json("info", store)
        self.assertEqual(info["last_run"]["step"], 80)
        self.assertGreater(info["tiles"]["offset"], 0)
        self.ok("reset", store)
        self.assertEqual(self.json("query", store, "70", "55")["offset"], 0)
        self.assertEqual(self.json("info", store)["tiles"]["offset"], 0)

    def test_the_same_pass_twice_cuts_no_deeper(self):
        store = self.synth()
        scene = self.scene(SCENE.replace("model: box", "model: none"))
        self.drive(scene, "--store", store)
        first = self.json("verify", store)["offset_sum"]
        self.drive(scene, "--store", store)
        self.assertEqual(self.json("verify", store)["offset_sum"], first)

    @long
    def test_what_no_offset_holds_is_refused_counted_and_told(self):
        store = self.synth()
        (self.folder / "deep.csv").write_text("t,x,y,z\n0,40,40,-1500\n1,44,41,-1500\n")
        for model in ("none", "box", "sumner", "slippage", "scm", "sheet"):
            scene = self.scene(f"""
scene: 1
time_step: 0.1
end_time: 1
spacing: 0.25
soil: {{name: dry_sand}}
redistribute: {{model: {model}}}
objects:
  - {{name: deep, shape: {{sphere: {{radius: 1.5}}}}, path: {{file: deep.csv}}}}
""")
            result = self.furrow("drive", scene, "--store", store, "-o", "out", "--json")
            if result.returncode == 4:
                self.skipTest("no GL here: " + result.stderr.strip())
            self.assertEqual(result.returncode, 0, result.stderr)
            refused = json.loads(result.stdout)["refused_posts"]
            self.assertGreater(refused, 0)
            notes = [line for line in result.stderr.splitlines() if "deeper than an offset holds" in line]
            self.assertEqual(len(notes), 1, result.stderr)
            self.assertIn(f"note: {refused} times", notes[0])

    def test_ctrl_c_ends_cleanly_with_130(self):
        import signal
        store = self.synth()
        scene = self.scene(SCENE.replace("end_time: 4", "end_time: 400000").replace("speed: 30}", "speed: 30, loop: true}"))
        process = subprocess.Popen([FURROW, "drive", scene, "--store", store, "-o", self.folder / "out"],
                                   stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.until_committed(process)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)  # within a second of the first, so it changes nothing
        _, errors = process.communicate(timeout=250)
        self.assertEqual(process.returncode, 130, errors)
        told = [line for line in errors.splitlines() if not line.startswith("furrow: note: ")]
        self.assertEqual(len(told), 1, errors)
        report = json.loads((self.folder / "out/run.json").read_text())
        self.assertEqual(report["ended"], "interrupted")
        self.assertTrue(self.json("verify", store)["ok"])
        self.assertEqual(self.json("info", store)["last_run"]["step"], report["steps"])

    def test_a_long_step_gives_way_and_a_third_signal_ends_at_once(self):
        """Of 800,000 path samples: the step is left, the store has what was committed before. Other signals than one another do not merge."""
        import signal
        import time
        self.synth(posts="65x65")
        scene = self.scene("scene: 1\ntime_step: 20\nend_time: 200\nspacing: 0.25\nobjects:\n"
                           "  - {name: a, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[10, 10], [50, 10], [50, 50]], speed: 10000, loop: true}}\n")
        for name, numbers in (("left", [signal.SIGTERM]), ("ended", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])):
            process = subprocess.Popen([FURROW, "drive", scene, "--store", "world.furrow", "--overlay", f"{name}.furrow", "-o", name],
                                       stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=self.folder)
            log = self.folder / name / "epochs.log"
            while process.poll() is None and not (log.exists() and log.read_text()):
                time.sleep(0.05)
            for number in numbers:
                if process.poll() is None:
                    process.send_signal(number)
            _, errors = process.communicate(timeout=250)
            if process.returncode == 4:
                self.skipTest("no GL here")
            if name == "ended":
                self.assertIn(-process.returncode, numbers, errors)
                continue
            self.assertEqual(process.returncode, 130, errors)
            self.assertIn("interrupted", errors)
            report = json.loads((self.folder / name / "run.json").read_text())
            self.assertEqual((report["ended"], report["steps"]), ("interrupted", 0))
            self.assertTrue(self.json("verify", f"{name}.furrow")["ok"])
        far = "t,x,y\n0,10,10\n1e-300,1000000000,10\n"
        for text, says in ((far, r"objects.a.path: 4e\+09 path samples are due in one step of 20 s, and 1000000 is the most; give its rows more time, or a coarser spacing"),
                           (far.replace("1e-300", "30000"), r"; give a time_step of (\S+) or less, its rows more time"), ("t,x,y\n1,-5,10\n3,20,10\n", r"no ground under it at -5.000, 10.000 m after 1.000 s")):
            (self.folder / "far.csv").write_text(text)
            arguments = ("drive", scene, "--store", "world.furrow", "--overlay", "far.furrow", "-o", "far", "--set", "objects.a.path={file: far.csv}")
            error = FurrowTest.told(self, 1 if "-5" in text else 3, self.furrow(*arguments))
            self.assertRegex(error, says)
        found = re.search(r"a time_step of (\S+) or less", self.told(3, self.furrow("explain", scene, "--store", "world.furrow", "--set", "objects.a.path={points: [[1, 1], [1e9, 1]], speed: 10000}",
                                                                                     "--set", "time_step=3600")))
        self.ok("explain", scene, "--store", "world.furrow", "--set", "objects.a.path={points: [[1, 1], [1e9, 1]], speed: 10000}", "--set", f"time_step={found[1]}")

    def test_a_second_drive_is_refused_the_same_store_and_the_same_folder(self):
        one, two = self.synth("one.furrow"), self.synth("two.furrow")
        scene = self.scene(SCENE.replace("end_time: 4", "end_time: 400000").replace("speed: 30}", "speed: 30, loop: true}"))
        process = subprocess.Popen([FURROW, "drive", scene, "--store", one, "-o", self.folder / "out"],
                                   stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            self.until_committed(process)
            self.assertIn("another process", self.refused(1, "drive", self.scene(name="b.yaml"), "--store", one, "-o", "b"))
            self.assertFalse((self.folder / "b").exists())
            self.assertIn("folder", self.refused(1, "drive", self.scene(name="b.yaml"), "--store", two, "-o", "out"))
        finally:
            process.kill()
            process.communicate(timeout=60)

    def test_pictures_are_written(self):
        store = self.synth()
        view = ("view: {size: [320, 180], camera: {chase: left, back: 8, up: 4}, "
                "effects: [texture, fog, sky, skirts], images: 40}\n")
        report = self.drive(self.scene(SCENE + view), "--store", store)
        self.assertEqual(report["view"]["frames"], 2)
        # Drawing and stepping are parts of the time, and neither is in the other.
        self.assertLessEqual(2 / report["fps"]["mean"] + 80 / report["steps_per_second"]["mean"], report["seconds"])
        for name in ("frame-000040.png", "frame-000080.png"):
            data = (self.folder / "out" / name).read_bytes()
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", data[16:24]), (320, 180))
        self.assertEqual(len(list((self.folder / "out").glob("frame-*.png"))), 2)

    def test_pictures_of_an_earlier_drive_are_removed(self):
        store, out = self.synth(), self.folder / "out"
        shot = ("view: {size: [32, 18], camera: {fixed: {eye: [24, 16, 60], target: [24, 20, 10]}}, images: %d}\n"
                "cameras: [{name: %s, kind: fixed, pose: {at: [24, 16, 60], target: [24, 20, 10]}, size: [32, 18], rate: 1, images: [colour, depth]}]\n")
        def left():
            return {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file() and (path.name.startswith("frame-") or "cameras" in path.parts)}
        def drive(images, camera, *more):
            return self.drive(self.scene(SCENE + shot % (images, camera)), "--store", store, *more)
        drive(10, "a")
        first = left()
        self.assertTrue({"frame-000010.png", "cameras/a/camera.json", "cameras/a/poses.tum"} <= first, first)
        self.assertTrue(any(name.endswith(".npy") for name in first))
        mine = {"frame-000010-mine.png", "frame-1.png", "cameras/mine.txt", "cameras/a/depth/mine.npy"}
        for name in mine:
            (out / name).write_text("mine")
        drive(40, "b")
        second = left()
        self.assertEqual(second & first, {"frame-000040.png", "frame-000080.png"})
        self.assertTrue(mine <= second)
        self.assertEqual({name for name in second if name.startswith("cameras/a/")}, {"cameras/a/depth/mine.npy"})
        # A folder without a drive keeps all, and a resumed drive keeps its pictures.
        (self.folder / "other").mkdir()
        (self.folder / "other/frame-000010.png").write_text("mine")
        self.ok("drive", self.scene(), "--store", store, "-o", "other")
        self.assertEqual((self.folder / "other/frame-000010.png").read_text(), "mine")

    @unittest.skipUnless(MAPS, "this build draws no maps")
    def test_a_drive_leaves_a_map_where_it_is_asked_for_and_says_where(self):
        store, asked = self.synth(), ("--set", "output.map=true")
        self.assertRegex(self.furrow("explain", self.scene(), "--store", store, *asked).stdout, r"\n  \d+ steps; a map at the end\n")
        self.assertNotIn("map", self.furrow("explain", self.scene(), "--store", store).stdout.replace("soil.map", ""))
        self.assertIs(self.json("explain", self.scene(), "--store", store, *asked)["map"], True)
        result = self.furrow("drive", self.scene(), "--store", store, "-o", "out", *asked)
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, r"^complete: .* in out/run\.json; a map in out/map\.png; ruts in .*world\.furrow itself\n$")
        self.assertRegex(self.ok("drive", self.scene(), "--store", store, "--overlay", "o.furrow", "-o", "o", "--map", "both.pdf", *asked),
                         r"^complete: .* in o/run\.json; a map in o/map\.png and both\.pdf; ruts in o\.furrow\n$")
        result = self.furrow("drive", self.scene(), "--store", store, "-o", "out", "--resume", "--map", "way.pdf")
        self.assertRegex(result.stdout, r"json; a map in way\.pdf; ruts in .*itself\n$")
        self.assertTrue((self.folder / "way.pdf").exists() and (self.folder / "both.pdf").exists())
        width, height = png_size(self.folder / "out/map.png")
        self.assertLessEqual(max(width, height), 1600)
        self.assertEqual(list((self.folder / "out").glob("*.part")), [])
        # A drive that cannot begin takes nothing away, and leaves none.
        before = (self.folder / "out/map.png").read_bytes()
        self.refused(3, "drive", self.scene(), "--store", store, "-o", "out", "--set", "spacing=0.125")
        self.assertEqual((self.folder / "out/map.png").read_bytes(), before)
        # A drive that does not ask draws none, and leaves no map of another drive. A file of that name that no drive made stays.
        self.ok("drive", self.scene(), "--store", store, "-o", "out", "--steps", "1")
        self.assertFalse((self.folder / "out/map.png").exists())
        (self.folder / "mine").mkdir()
        (self.folder / "mine/map.png").write_text("mine")
        self.ok("drive", self.scene(), "--store", store, "-o", "mine", "--steps", "1")
        self.assertEqual((self.folder / "mine/map.png").read_text(), "mine")


class RealElevation(FurrowTest):
    @unittest.skipUnless((SHARED / "dem").is_dir() and has_gdal(), "not on this machine: no shared elevation data")
    def test_each_of_the_real_dems_imports_and_verifies(self):
        dem = SHARED / "dem"
        cases = {"bigtujunga.tif": [], "craterlake.tif": ["--nodata", "-32767"], "everest_voids.tif": [],
                 "gabilan_dtm1m.bil": [], "heightmap16_1280.png": [], "mars_gale_ctx20m.tif": [], "sthelens.dem": []}
        for name, extra in cases.items():
            with self.subTest(name=name):
                result = self.furrow("import", dem / name, "-o", "real.furrow", "--overwrite", *extra)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertNotIn("means nodata", result.stderr)
                check = self.json("verify", "real.furrow")
                self.assertTrue(check["ok"], check["problems"])
                os.remove(self.folder / "real.furrow")

    @unittest.skipUnless((SHARED / "dem").is_dir() and has_gdal(), "not on this machine: no shared elevation data")
    def test_nodata_that_no_tag_declares_is_told(self):
        result = self.furrow("import", SHARED / "dem/craterlake.tif", "-o", "real.furrow")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("--nodata -32767", result.stderr)

    @unittest.skipUnless((SHARED / "dem").is_dir() and has_gdal(), "not on this machine: no shared elevation data")
    def test_a_wheel_leaves_its_shape_in_a_90_m_mosaic(self):
        dem = SHARED / "dem"
        self.ok("import", dem / "N41E001.hgt", dem / "N42E001.hgt", "-o", "es.furrow")
        spacing = self.json("info", "es.furrow")["spacing"]
        scene = self.scene("scene: 1\ntime_step: 0.05\nend_time: 6\nspacing: 0.1\nredistribute: {model: none}\n"
                           "objects:\n  - {name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1,\n"
                           "     path: {points: [[40010, 60000], [40040, 60010]], speed: 5}}\n")
        report = self.drive(scene, "--store", "es.furrow")
        self.assertLessEqual(report["spacing"], 0.1)
        self.assertGreater(report["spacing"], 0.05)
        self.assertGreater(spacing, 60)
        offset = self.json("query", "es.furrow", 40025, 60005)["offset"]
        self.assertAlmostEqual(offset, -0.1, delta=0.02)
        self.assertTrue(self.json("verify", "es.furrow")["ok"])


if __name__ == "__main__":
    main()
