"""furrow map, and the maps of export and drive: what stands on the page, in PNG, SVG and PDF."""
import math
import pathlib
import re
import shutil
import sqlite3
import struct
import subprocess
import unittest
import xml.etree.ElementTree

import rasters
from furrow_test import SCENE, SHARED, FurrowTest, has_gdal, largest, long, main

XHTML = "{http://www.w3.org/1999/xhtml}"
SVG = "{http://www.w3.org/2000/svg}"
MARGIN = 31  # points from the left of the page to the frame
NARROW, MINUS = "\u202f", "\u2212"


def number(text):
    return float(text.replace(NARROW, "").replace(MINUS, "-"))


class Words:
    """The words of a PDF and their places, as poppler finds them: points, y downwards."""

    def __init__(self, text):
        root = xml.etree.ElementTree.fromstring(text)
        pages = root.findall(f".//{XHTML}page")
        self.pages = len(pages)
        self.width, self.height = float(pages[0].get("width")), float(pages[0].get("height"))
        self.words = [(word.text, *(float(word.get(key)) for key in ("xMin", "yMin", "xMax", "yMax")))
                      for word in pages[0].findall(f"{XHTML}word")]

    def text(self):
        return " ".join(word[0] for word in self.words)

    def meeting(self):
        """Pairs of words that lie on each other. Poppler's boxes are higher than letters are, so they are cut above and below."""
        found = []
        for i, (a, ax0, ay0, ax1, ay1) in enumerate(self.words):
            for b, bx0, by0, bx1, by1 in self.words[:i]:
                if ax0 < bx1 - 0.5 and bx0 < ax1 - 0.5 and ay0 + 1.5 < by1 - 1.5 and by0 + 1.5 < ay1 - 1.5:
                    found.append((a, b))
        return found


class Maps(FurrowTest):
    def pdf(self, *arguments):
        self.ok(*arguments)
        return self.words(arguments[-1])

    def words(self, path):
        if shutil.which("pdftotext") is None:
            self.skipTest("needs pdftotext, of poppler")
        text = subprocess.run(["pdftotext", "-bbox", self.folder / path, "-"], capture_output=True, check=True, timeout=60).stdout
        return Words(re.sub(rb"[\x00-\x08\x0b\x0c\x0e-\x1f]", b"", text))

    def synth(self, name="a.furrow", posts="300x200", spacing=2, kind="ridged"):
        self.ok("synth", "-o", name, "--posts", posts, "--spacing", spacing, "--kind", kind, "--seed", 3, "--overwrite")
        return name

    # --- files ---

    def test_the_ending_chooses_the_format_and_the_same_map_is_the_same_file(self):
        store = self.synth()
        for ending, head in (("png", b"\x89PNG\r\n\x1a\n"), ("svg", b"<?xml"), ("pdf", b"%PDF-"), ("PDF", b"%PDF-")):
            first = self.ok("map", store, "-o", f"a.{ending}")
            self.assertRegex(first, rf"^a\.{ending}: a map of surface, \d+ x \d+ (pixels|points), of 300 x 200 posts, 2 m apart\n$")
            self.ok("map", store, "-o", f"b.{ending}")
            data = (self.folder / f"a.{ending}").read_bytes()
            self.assertTrue(data.startswith(head))
            self.assertEqual(data, (self.folder / f"b.{ending}").read_bytes())
        self.assertEqual(list(self.folder.glob("*.part")), [])

    def test_size_and_resolution_make_the_pixels(self):
        store = self.synth(posts="300x300")
        for size, dpi in ((100, 254), (160, 100), (50.8, 50)):
            self.ok("map", store, "-o", "a.png", "--size", size, "--dpi", dpi, "--grid", "none")
            data = (self.folder / "a.png").read_bytes()
            width, height = struct.unpack(">II", data[16:24])
            frame = round(size / 25.4 * dpi)
            self.assertTrue(frame < width < frame + 4 * dpi and frame < height < frame + 4 * dpi)
            at = data.index(b"pHYs") + 4
            self.assertAlmostEqual(struct.unpack(">I", data[at:at + 4])[0], dpi / 0.0254, delta=0.01 * dpi / 0.0254)

    def test_a_world_file_places_each_pixel(self):
        """GDAL finds one high post at its coordinates, as wide as a post is, in maps of the whole and of a window."""
        if not has_gdal():
            self.skipTest("needs GDAL's programs")
        east, north, step = 500000 + 40.5 * 10, 5000000 - 10.5 * 10, 10
        rasters.make(self.folder / "a.tif", 65, 41, [0.1 * ((x, y) == (40, 10)) for y in range(41) for x in range(65)])
        self.ok("import", "a.tif", "-o", "a.furrow")
        for arguments in ([], ["--window", "350,250,450,350"], ["--size", "97", "--dpi", "201", "--layer", "base"]):
            self.ok("map", "a.furrow", "-o", "a.png", "--world-file", "--exaggerate", "0.01", "--grid", "none", *arguments)
            self.assertIn("UTM zone", rasters.gdalinfo(self.folder / "a.png")["coordinateSystem"]["wkt"])
            around = [(far * x, far * y) for far in (0.42, 0.58) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))]
            told = rasters.gdal("gdallocationinfo", "-geoloc", "-valonly", self.folder / "a.png",
                                stdin="".join(f"{east + dx * step} {north + dy * step}\n" for dx, dy in [(0, 0), *around])).split()
            peak, *others = [[int(band) for band in told[i:i + 3]] for i in range(0, 27, 3)]
            self.assertLess(largest(math.dist(peak, other) for other in others[:4]), 5, arguments)
            self.assertGreater(min(math.dist(peak, other) for other in others[4:]), 50, arguments)
        self.ok("map", self.synth(), "-o", "b.png", "--world-file")
        self.assertTrue((self.folder / "b.pgw").exists() and not (self.folder / "b.png.aux.xml").exists())
        self.ok("map", "a.furrow", "-o", "c.png")
        self.assertEqual([path.name for path in self.folder.glob("c*")], ["c.png"])

    def test_what_is_asked_wrongly_is_told(self):
        store = self.synth()
        for status, arguments, words in (
                (2, ["-o", "a.jpg"], ".png, .svg and .pdf"), (2, [], "-o is missing"), (2, ["-o", "a.png", "--size", "20"], "size"),
                (2, ["-o", "a.png", "--size", "1000", "--dpi", "1200"], "8192"), (2, ["-o", "a.png", "--grid", "feet"], "grid"), (2, ["-o", "a.pdf", "--world-file"], "no PNG"),
                (2, ["-o", "a.png", "--layer", "hillshade"], "hillshade"), (2, ["-o", "a.png", "--height-range", "5,4"], "empty"),
                (2, ["-o", "a.png", "--layer", "offset", "--height-range", "1,4"], "both signs"),
                (3, ["-o", "a.png", "--window", "9000,9000,9001,9001"], "window"), (1, ["-o", "no/a.pdf"], "no/a.pdf")):
            with self.subTest(arguments=arguments):
                result = self.furrow("map", store, *arguments)
                self.assertEqual(result.returncode, status, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertEqual(len(result.stderr.splitlines()), 1)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), [store])

    def test_without_a_font_it_is_refused_and_a_drive_without_a_map_goes_on(self):
        store = self.synth()
        (self.folder / "none.conf").write_text('<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd"><fontconfig><dir>/nowhere</dir></fontconfig>')
        env = {"FONTCONFIG_FILE": str(self.folder / "none.conf")}
        result = self.furrow("map", store, "-o", "a.png", env=env)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"^furrow: map: there is no font .*; install one.*\n$")
        (self.folder / "scene.yaml").write_text(SCENE)
        for command in (("drive", "scene.yaml", "--store", store, "-o", "asked"), ("explain", "scene.yaml")):
            result = self.furrow(*command, "--set", "output.map=true", env=env)
            self.assertEqual(result.returncode, 3)
            self.assertRegex(result.stderr, r"^furrow: scene\.yaml: output\.map: there is no font .*; install one, .*; or take it away\n$")
            self.assertFalse((self.folder / "asked").exists())
        result = self.furrow("drive", "scene.yaml", "--store", store, "-o", "out", env=env)
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("map", result.stderr + result.stdout)
        self.assertFalse((self.folder / "out/map.png").exists())

    # --- what stands on the page ---

    def test_a_pdf_has_one_page_with_its_words_and_none_on_another(self):
        store = self.synth("Grüße.furrow")
        for layer, head in (("surface", "Height, m"), ("offset", "Offset: no change")):
            page = self.pdf("map", store, "--layer", layer, "-o", "a.pdf")
            self.assertEqual(page.pages, 1)
            self.assertEqual(page.meeting(), [])
            for words in ("Grüße.furrow", head, "200 m", "Metres east and north", "Posts are 2 m apart"):
                self.assertIn(words, page.text())

    def test_coordinates_at_the_corners_are_the_store_s(self):
        """A straight line through the numbers below the map, to its corners: where these are is known from the margin and the size."""
        for posts, spacing, window in (("300x200", 2, None), ("300x200", 2, (100, 50, 140, 70)), ("2000x1500", 4, None)):
            store = self.synth(f"{posts}.furrow", posts=posts, spacing=spacing)
            more = ["--window", ",".join(map(str, window))] if window else []
            page = self.pdf("map", store, "--size", 160, *more, "-o", "a.pdf")
            sides = [window[i + 2] - window[i] if window else (int(posts.split("x")[i]) - 1) * spacing for i in range(2)]
            self.assertIn(" by ".join(f"{side / 1000:g} km" if side >= 1000 else f"{side} m" for side in sides), page.text())
            legend = next(word[2] for word in page.words if word[0] == "Height,")
            below = [(number(text), (x0 + x1) / 2) for text, x0, y0, x1, y1 in page.words
                     if re.fullmatch(rf"[{MINUS}]?[\d{NARROW}.]+", text) and x1 > MARGIN and legend - 25 < y0 < legend - 5]
            self.assertGreaterEqual(len(below), 3)
            (a, at_a), (b, at_b) = below[0], below[-1]
            metres, first = (window[2] - window[0] + spacing, window[0]) if window else (int(posts.split("x")[0]) * spacing, 0)
            for place, wanted in ((MARGIN, first - spacing / 2), (MARGIN + 160 / 25.4 * 72, first - spacing / 2 + metres)):
                self.assertAlmostEqual(a + (place - at_a) * (b - a) / (at_b - at_a), wanted, delta=0.02 * metres)

    def test_a_map_of_a_projected_store_names_its_system_and_has_degrees(self):
        if not has_gdal() or not (SHARED / "dem").is_dir():
            self.skipTest("not on this machine: no shared elevation data")
        self.ok("import", SHARED / "dem/everest_voids.tif", "-o", "a.furrow")
        page = self.pdf("map", "a.furrow", "-o", "a.pdf")
        self.assertIn("WGS 84 / UTM zone 45N (EPSG:32645)", page.text())
        self.assertIn("3 040 000 N", page.text())
        self.assertIn("440 000 E", page.text())
        self.assertIn("no data", page.text())
        self.assertEqual(page.meeting(), [])
        degrees = self.pdf("map", "a.furrow", "--grid", "degrees", "-o", "b.pdf")
        self.assertIn("27.4° N", degrees.text())
        self.assertIn("86.4° E", degrees.text())
        self.assertIn("Longitude and latitude: WGS 84", degrees.text())
        self.assertEqual(degrees.meeting(), [])

    def test_notes_tell_the_scale_the_posts_and_what_heights_are_above(self):
        if not has_gdal() or not (SHARED / "dem").is_dir():
            self.skipTest("not on this machine: no shared elevation data")
        told = self.furrow("import", SHARED / "dem/bigtujunga.tif", "-o", "a.furrow", "--t-srs", "EPSG:3857", "--s-vertical", "egm96")
        share = re.search(r"distances are up to (\d+) % off", told.stderr).group(1)
        page = self.pdf("map", "a.furrow", "-o", "a.pdf")
        for words in (f"The scale bar has metres of the map: on the ground distances are up to {share} % shorter.", "Height above EGM96, m",
                      "Drawn from every 2nd post: posts are 30 m apart."):
            self.assertIn(words, page.text())
        page = self.pdf("map", "a.furrow", "--layer", "base", "--size", "60", "-o", "a.pdf")
        self.assertIn("Height of the base above EGM96, m", page.text())
        self.assertEqual(page.meeting(), [])
        self.ok("import", SHARED / "dem/bigtujunga.tif", "-o", "b.furrow")
        page = self.pdf("map", "b.furrow", "-o", "b.pdf")
        self.assertIn("Height, m", page.text())
        self.assertNotIn("on the ground", page.text())
        # The store says where a metre is a metre on the ground, so nobody waits for GDAL there; an older one says nothing, and it is asked.
        for name, key, loads in (("b", True, False), ("a", True, True), ("b", False, True), ("a", False, True)):
            with self.subTest(name, key=key):
                if not key:
                    with sqlite3.connect(self.folder / f"{name}.furrow") as database:
                        self.assertEqual(database.execute("DELETE FROM meta WHERE key = 'ground_off'").rowcount, 1)
                    database.close()
                told = self.furrow("map", f"{name}.furrow", "--grid", "local", "-o", f"{name}.svg", env={"LD_DEBUG": "files"})
                self.assertEqual(told.returncode, 0)
                self.assertEqual("libgdal" in told.stderr, loads)
                self.assertEqual("on the ground" in (self.folder / f"{name}.svg").read_text(), name == "a")

    def test_a_local_store_has_no_degrees(self):
        store = self.synth()
        result = self.furrow("map", store, "-o", "a.svg", "--grid", "degrees")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stderr, r"^furrow: note: .*grid is in metres\n$")

    def test_an_svg_has_its_words_and_parses(self):
        title = "Карта <&> \u2068شيء\u2069 火星 e\u030a \"q\""
        self.ok("map", self.synth(), "-o", "a.svg", "--title", title)
        root = xml.etree.ElementTree.parse(self.folder / "a.svg").getroot()
        self.assertEqual(root.tag, SVG + "svg")
        self.assertEqual(root.find(SVG + "title").text, title)
        words = root.find(SVG + "desc").text.splitlines()
        for line in (title, "Height, m", "0", "N", "100 m"):
            self.assertIn(line, words)
        self.assertEqual(len(root.findall(f".//{SVG}image")), 1)

    def test_titles_of_any_script_are_in_the_pdf(self):
        store = self.synth()
        for title in ("Карта", "火星", "Ångström", "x" * 300):
            told = self.furrow("map", store, "--title", title, "-o", "a.pdf")
            self.assertEqual(told.returncode, 0, told.stderr)
            page = self.words("a.pdf")
            # Where no font has the signs, a note says so. tools/packages.sh brings none for Chinese.
            self.assertEqual(title[:8] in page.text(), told.stderr == "", told.stderr)
            if title == "火星":
                self.assertIn(told.stderr, ("", self.BOXES.format("a.pdf", "火 (U+706B), 星 (U+661F)", self.INSTALL.format("fonts-noto-cjk"))))
            else:
                self.assertEqual(told.stderr, "")
            self.assertTrue(all(0 <= x0 and x1 <= page.width for _, x0, _, x1, _ in page.words))
        # Bytes that are no UTF-8.
        self.ok("map", store, "-o", "a.svg", "--title", b"\xff\xfe bad".decode("utf-8", "surrogateescape"))
        xml.etree.ElementTree.parse(self.folder / "a.svg")

    BOXES = "furrow: note: {}: no installed font has {}, so each is drawn as a box with its number; {}\n"
    INSTALL = "install a font that has it, as in {}"

    def test_signs_that_no_font_has_are_told(self):
        """With DejaVu alone: whatever this machine has beside it changes nothing. One sign is no letter, so no font has it."""
        store, dejavu = self.synth(posts="65x65"), pathlib.Path("/usr/share/fonts/truetype/dejavu")
        (self.folder / "one.conf").write_text(f'<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd"><fontconfig><dir>{dejavu}</dir></fontconfig>')
        env = {"FONTCONFIG_FILE": str(self.folder / "one.conf")}
        cases = [("a\u0378", "U+0378", "give a text without it")]
        if dejavu.is_dir():
            cases += [("火星火 Карта", "火 (U+706B), 星 (U+661F)", self.INSTALL.format("fonts-noto-cjk")),
                      ("한 ग 🚙", "한 (U+D55C), ग (U+0917), 🚙 (U+1F699)", self.INSTALL.format("fonts-noto-cjk and fonts-noto-core and fonts-noto-color-emoji")),
                      ("火" + "x" * 300 + "星", "火 (U+706B), 星 (U+661F)", self.INSTALL.format("fonts-noto-cjk")),  # its middle is cut out
                      ("".join(map(chr, range(0x4e00, 0x4e0a))), ", ".join(f"{chr(i)} (U+{i:04X})" for i in range(0x4e00, 0x4e08)) + " and more",
                       self.INSTALL.format("fonts-noto-cjk")),
                      ("a\x85b\u2029c\u202ed", None, None)]  # ends of lines and a mark of direction are no signs
        for title, signs, todo in cases:
            with self.subTest(title):
                told = self.furrow("map", store, "--title", title, "-o", "a.svg", env=env)
                self.assertEqual(told.returncode, 0, told.stderr)
                self.assertEqual(told.stderr, "" if signs is None else self.BOXES.format("a.svg", signs, todo))

    # --- drives ---

    @long
    def test_names_of_a_drive_do_not_meet(self):
        for side, count in ((100, 3), (300, 30), (780, 150)):
            with self.subTest(side=side, count=count):
                store = self.synth(f"{count}.furrow", posts="400x400", kind="dunes")
                golden = math.pi * (3 - math.sqrt(5))
                lines = [SCENE[:SCENE.index("  - {name: left")]]
                for i in range(count):
                    far = 0.45 * side * math.sqrt((i + 0.5) / count)
                    x, y = 399 + far * math.cos(golden * i), 399 + far * math.sin(golden * i)
                    lines.append(f"  - {{name: object_of_a_drive_{i}, shape: {{sphere: {{radius: 0.8}}}}, sink: 0.1,\n"
                                 f"     path: {{points: [[{x:.2f}, {y:.2f}], [{x + 5:.2f}, {y + 3:.2f}]], speed: 20}}}}\n")
                (self.folder / "scene.yaml").write_text("".join(lines) + "cache: {slots: 64}\n")
                result = self.furrow("drive", "scene.yaml", "--store", store, "-o", f"out{count}", "--map", "way.pdf")
                if result.returncode == 4:
                    self.skipTest("no GL here")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertFalse((self.folder / f"out{count}/map.png").exists())  # --map asks for its own file alone
                page = self.words("way.pdf")
                self.assertEqual(page.meeting(), [])
                names = {word[0] for word in page.words if re.fullmatch(r"object_of_a_drive_\d+", word[0])}
                self.assertTrue(names)
                told = re.search(r"(\d+) of (\d+) names have no room", page.text())
                self.assertTrue(told is not None or count < 100)

    def test_a_drive_s_map_in_a_format_that_is_none_is_refused_before_it(self):
        error = self.refused(2, "drive", self.scene(), "--store", self.synth(), "-o", "out", "--map", "way.jpg")
        self.assertIn(".svg", error)
        self.assertFalse((self.folder / "out").exists())

    def test_exports_and_mobility_make_the_same_kinds(self):
        store = self.synth()
        page = self.pdf("export", store, "--layer", "offset", "-o", "a.pdf")
        self.assertIn("Offset: no change", page.text())
        self.ok("export", store, "--layer", "plastic_sinkage", "-o", "a.svg")
        self.assertIn("furrow map", self.refused(2, "export", store, "-o", "b.svg"))
        self.assertFalse((self.folder / "b.svg").exists())


if __name__ == "__main__":
    main()
