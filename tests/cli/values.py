"""What a stored value means: scale and offset, lossless bits, infinities, byte order, carriage returns."""
import array
import math
import pathlib
import struct
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import long, main, write_png16
from raster_test import RasterTest
import rasters


class Values(RasterTest):
    def test_scale_and_offset_tags_make_metres_and_nodata_is_as_stored(self):
        # 500 as it is stored is nodata; 150 m is a height like others, and so is a stored 1500.
        self.make("in.tif", 70, 50, lambda x, y: 500 if x == 4 else 1500 if x == 6 else 10 * x + y, "h", nodata=500,
                  options=["-a_scale", "0.1", "-a_offset", "100"])
        self.ok("import", "in.tif", "-o", "s.furrow")
        info = self.json("info", "s.furrow")
        self.assertAlmostEqual(info["max_error"], 0.05, places=12)
        _, _, cells = self.exported("s.furrow")
        for y in range(50):
            for x in range(70):
                stored = 10 * x + y
                if x == 4 or stored == 500:
                    self.assertIsNone(cells[70 * y + x])
                else:
                    self.assertAlmostEqual(cells[70 * y + x], 100 + 0.1 * (1500 if x == 6 else stored), places=4)

    def test_a_negative_scale_keeps_the_bound(self):
        self.make("in.tif", 30, 30, lambda x, y: 7 * x + y, "h", options=["-a_scale", "-0.25", "-a_offset", "3.5"])
        self.ok("import", "in.tif", "-o", "s.furrow")
        self.assertEqual(self.json("info", "s.furrow")["max_error"], 0.125)
        _, _, cells = self.exported("s.furrow")
        for i, value in enumerate(cells):
            self.assertEqual(value, 3.5 - 0.25 * (7 * (i % 30) + i // 30))

    def test_infinities_are_refused_with_their_place(self):
        for height in (math.inf, -math.inf):
            for options in ([], ["--max-error", "0"], ["--spacing", "7"], ["--spacing", "7", "-r", "cubic"]):
                with self.subTest(height=height, options=options):
                    self.make("in.tif", 60, 50, lambda x, y: height if (x, y) == (13, 20) else 5)
                    error = self.refused(3, "import", "in.tif", "-o", "s.furrow", *options)
                    self.assertIn("infinite", error)
                    if "--spacing" not in options:
                        self.assertIn("post 13, 29", error)
                    self.assertEqual([p.name for p in self.folder.glob("s.furrow*")], [])
        self.ok("import", "in.tif", "-o", "s.furrow", "--nodata", "-inf")
        self.assertTrue(self.json("query", "s.furrow", "130", "290")["nodata"])

    def test_a_height_that_no_ground_has_is_refused_lossless_too(self):
        self.make("in.tif", 20, 20, lambda x, y: 3e38 if (x, y) == (7, 7) else 5)
        self.assertIn("post 7, 12", self.refused(3, "import", "in.tif", "-o", "s.furrow", "--max-error", "0"))
        self.assertEqual([p.name for p in self.folder.glob("s.furrow*")], [])

    def test_lossless_keeps_every_bit_negative_zero_and_denormals_too(self):
        patterns = [0x80000000, 0, 0x80000001, 1, 0x007fffff, 0x807fffff, 0x00800000, 0x3f800001, 0x449a522b, 0xc49a522b]
        for first in (0, 1, 4):  # negative zero is the lowest of some tile, and the highest
            bits = [patterns[(first + i // 41) % len(patterns)] for i in range(600)]
            cells = array.array("f", struct.pack("<600I", *bits))
            rasters.make(self.folder / "in.tif", 30, 20, cells)
            self.ok("import", "in.tif", "-o", "s.furrow", "--max-error", "0", "--tile", "8", "--overwrite")
            self.assertTrue(self.json("verify", "s.furrow")["ok"])
            for layer in ("base", "surface"):
                self.ok("export", "s.furrow", "-o", "out.tif", "--layer", layer)
                back = rasters.pixels(self.folder / "out.tif", "f")[2]
                self.assertEqual(back.tobytes(), cells.tobytes())

    def test_a_terrain_of_negative_zeros_alone_is_whole(self):
        cells = array.array("f", [-0.0] * 400)
        rasters.make(self.folder / "in.tif", 20, 20, cells)
        self.ok("import", "in.tif", "-o", "s.furrow", "--max-error", "0")
        self.assertTrue(self.json("verify", "s.furrow")["ok"])
        self.ok("export", "s.furrow", "-o", "out.tif")
        self.assertEqual(rasters.pixels(self.folder / "out.tif", "f")[2].tobytes(), cells.tobytes())

    def test_doubles_that_are_no_floats_are_not_called_lossless(self):
        self.make("in.tif", 20, 20, lambda x, y: 0.1 if (x, y) == (3, 4) else 5, "d")
        self.assertIn("post 3, 15", self.refused(3, "import", "in.tif", "-o", "s.furrow", "--max-error", "0"))
        self.make("in.tif", 20, 20, lambda x, y: 0.5 * x, "d")
        self.ok("import", "in.tif", "-o", "s.furrow", "--max-error", "0")


    @long
    def test_whole_numbers_are_kept_whole_at_any_bound(self):
        """No float has 16777217; and a bound finer than their unit makes them no better, nor larger."""
        self.make("in.tif", 20, 20, lambda x, y: 16777217 if (x, y) == (3, 4) else 5 * x - y, "i")
        sizes = set()
        for bound in ("0", "0.001", "0.5"):
            self.ok("import", "in.tif", "-o", "s.furrow", "--max-error", bound, "--overwrite")
            points = self.json("query", "s.furrow", 30, 150, 40, 150)["points"]
            self.assertEqual([point["height"] for point in points], [16777217, 16])
            sizes.add(self.json("info", "s.furrow")["bytes"]["base"])
        self.assertEqual(len(sizes), 1)
        self.make("rough.tif", 40, 40, lambda x, y: 37 * x * y % 101, "h")
        for bound in ("0.5", "3"):
            self.ok("import", "rough.tif", "-o", "s.furrow", "--max-error", bound, "--overwrite")
            sizes.add(self.json("info", "s.furrow")["bytes"]["base"])
        self.assertEqual(len(sizes), 3)  # a coarser bound is smaller
        self.make("scaled.tif", 20, 20, lambda x, y: 7 * x + y, "h",
                  options=("-a_scale", "0.25", "-a_offset", "100"))
        self.ok("import", "scaled.tif", "-o", "s.furrow", "--max-error", "0", "--overwrite")
        self.assertEqual(self.json("query", "s.furrow", 30, 150)["points"][0]["height"], 0.25 * (7 * 3 + 4) + 100)


    def test_what_looks_like_degrees_and_what_has_no_place_is_told(self):
        for west, north, step, height, told in ((119.2, 34.1, 0.01, 0.5, "looks like degrees"), (119.2, 34.1, 0.01, 50, None), (119.2, 34.1, 0.5, 5000, None), (119.2, 34.1, 0.5, 5, ""),
                                                (0, 0.2, 0.01, 5, ""), (500000, 34.1, 0.01, 5, ""), (None, 0, 0, 5, "--spacing")):
            with self.subTest(west=west, step=step, height=height):
                if west is None:
                    write_png16(self.folder / "in.png", 20, 20, lambda x, y: height)
                else:
                    self.make("in.tif", 20, 20, lambda x, y: height * x / 19, west=west, north=north, step=step, srs=None)
                source = "in.png" if west is None else "in.tif"
                if told is None:
                    self.assertIn("--s-srs EPSG:4326", self.refused(3, "import", source, "-o", "s.furrow"))
                    self.ok("import", source, "-o", "s.furrow", "--overwrite", "--s-srs", "LOCAL_CS[\"metres\"]")
                    continue
                found = self.furrow("import", source, "-o", "s.furrow", "--overwrite")
                self.assertEqual(0, found.returncode, found.stderr)
                self.assertEqual(told != "", "note" in found.stderr, found.stderr)
                self.assertIn(told, found.stderr)
        self.make("in.tif", 20, 20, lambda x, y: 5000 * x / 19, west=119.2, north=34.1, step=0.01, srs="EPSG:4326")
        self.assertIn("EPSG:26911 is in metres, and its place 119.2, 34.1 with posts 0.01 apart looks like degrees: as metres it is 0.2 m wide",
                      self.refused(3, "import", "in.tif", "-o", "s.furrow", "--s-srs", "EPSG:26911"))
        self.make("in.tif", 20, 20, lambda x, y: 0.5 * x / 19, west=119.2, north=34.1, step=0.01, srs=None)
        self.assertIn("looks like degrees; taken as the metres", self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite", "--s-srs", rasters.UTM).stderr)
        self.make("in.tif", 20, 20, lambda x, y: x, west=500000, north=34.1, step=0.01, srs=None)
        self.assertEqual("", self.furrow("import", "in.png", "-o", "s.furrow", "--overwrite", "--spacing", 1).stderr)
        self.assertEqual("", self.furrow("import", "in.tif", "-o", "s.furrow", "--overwrite", "--s-srs", rasters.UTM).stderr)

    def test_of_several_bands_the_first_is_taken_and_that_is_told(self):
        self.make("one.tif", 20, 20, lambda x, y: 3 * x + y, "h")
        rasters.gdal("gdal_translate", "-q", "-b", "1", "-b", "1", "-b", "1", self.folder / "one.tif", self.folder / "in.tif")
        self.assertIn("3 bands", self.furrow("import", "in.tif", "-o", "s.furrow").stderr)
        self.assertEqual(self.json("query", "s.furrow", 30, 150)["points"][0]["height"], 3 * 3 + 4)


def write_png8(path, side, colour, depth, row):
    """A PNG of that colour type; row(y): its bytes. With colour type 3 it has a palette."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    palette = chunk(b"PLTE", bytes(range(256)) * 3) if colour == 3 else b""
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, depth, colour, 0, 0, 0)) + palette +
                     chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row(y) for y in range(side)))) + chunk(b"IEND", b""))


class EightBits(RasterTest):
    """Heightfields of 8 bits, as old terrain engines have them: raw, PNG, PGM, TIFF."""

    SIDE = 24

    def setUp(self):
        super().setUp()
        side = self.SIDE
        self.cells = [(7 * x + 11 * y) % 256 for y in range(side) for x in range(side)]
        rows = [bytes(self.cells[y * side:(y + 1) * side]) for y in range(side)]
        self.make("in.tif", side, side, lambda x, y: self.cells[y * side + x], "B", step=1)
        (self.folder / "in.r8").write_bytes(b"".join(rows))
        (self.folder / "in.raw").write_bytes(b"".join(rows))
        write_png8(self.folder / "in.png", side, 0, 8, rows.__getitem__)
        rasters.gdal("gdal_translate", "-q", "-of", "PNM", self.folder / "in.tif", self.folder / "in.pgm")
        self.rows = rows

    def test_a_height_range_says_what_they_mean_and_all_of_them_come_back(self):
        for name in ("in.r8", "in.raw", "in.png", "in.pgm", "in.tif"):
            for low, high in ((0, 255), (-20, 235), (100, 151)):
                with self.subTest(name=name, low=low):
                    self.ok("import", name, "-o", "s.furrow", "--overwrite", "--spacing", 1, "--height-range", f"{low},{high}", "--max-error", 0)
                    _, _, heights = self.exported("s.furrow")
                    for height, cell in zip(heights, self.cells):
                        self.assertAlmostEqual(height, low + cell * (high - low) / 255, delta=1e-5)
                    self.ok("export", "s.furrow", "-o", "out.r16", "--height-range", f"{low},{high}")
                    back = struct.unpack(f"<{len(self.cells)}H", (self.folder / "out.r16").read_bytes())
                    self.assertEqual([round(value / 257) for value in back], self.cells)

    def test_the_bound_of_a_height_is_half_a_step_of_8_bits(self):
        for name in ("in.r8", "in.png", "in.tif"):
            self.ok("import", name, "-o", "s.furrow", "--overwrite", "--spacing", 1, "--height-range", "0,510")
            self.assertEqual(self.json("info", "s.furrow")["max_error"], 1)

    def test_without_a_range_raw_posts_are_refused_and_others_tell_what_they_are_taken_for(self):
        for name in ("in.r8", "in.raw"):
            self.assertIn("--height-range MIN,MAX", self.refused(3, "import", name, "-o", "s.furrow"))
        for name in ("in.png", "in.pgm", "in.tif"):
            told = self.furrow("import", name, "-o", "s.furrow", "--overwrite", "--spacing", 1)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertEqual(told.stderr.count("8 bits"), 1, told.stderr)
            _, _, heights = self.exported("s.furrow")
            self.assertEqual(heights, self.cells)

    def test_a_raster_of_16_bits_without_a_sign_has_a_range_too(self):
        self.make("wide.tif", 20, 20, lambda x, y: 3000 * (x % 20) + y, "H", step=1)
        self.ok("import", "wide.tif", "-o", "s.furrow", "--height-range", "-100,555.35", "--max-error", 0)
        _, _, heights = self.exported("s.furrow")
        self.assertAlmostEqual(heights[25], -100 + (3000 * 5 + 1) * 0.01, delta=1e-4)

    def test_what_says_itself_what_it_means_takes_no_range(self):
        self.make("metres.tif", 20, 20, lambda x, y: x + y)
        self.make("signed.tif", 20, 20, lambda x, y: x + y, "h")
        self.make("scaled.tif", 20, 20, lambda x, y: x + y, "B", options=["-a_scale", "0.5"])
        for name in ("metres.tif", "signed.tif", "scaled.tif"):
            self.assertIn("leave it out", self.refused(2, "import", name, "-o", "s.furrow", "--height-range", "0,1"))
        self.assertIn("--height-range", self.refused(2, "import", "in.tif", "-o", "s.furrow", "--height-range", "0,1", "--s-unit", "ft"))

    def test_pictures_are_no_heightfields(self):
        side = self.SIDE
        write_png8(self.folder / "palette.png", side, 3, 8, self.rows.__getitem__)
        write_png8(self.folder / "picture.png", side, 2, 8, lambda y: self.rows[y] * 3)
        for name in ("palette", "picture"):
            rasters.gdal("gdal_translate", "-q", self.folder / f"{name}.png", self.folder / f"{name}.tif")
        for name, why in (("palette.png", "a palette of colours"), ("palette.tif", "a palette of colours"), ("picture.png", "in colour"),
                          ("picture.tif", "the red of a picture")):
            for options in ([], ["--height-range", "0,100"]):
                self.assertIn(why, self.refused(3, "import", name, "-o", "s.furrow", *options))
        self.assertEqual(list(self.folder.glob("s.furrow*")), [])


class Bytes(RasterTest):
    def values(self):
        return array.array("h", [(257 * i) % 9001 - 300 for i in range(24 * 18)])

    def check(self, source, values=None):
        self.ok("import", source, "-o", "s.furrow", "--overwrite")
        width, height, cells = self.exported("s.furrow")
        self.assertEqual((width, height), (24, 18))
        self.assertEqual(list(cells), [float(v) for v in (values or self.values())])
        return self.json("info", "s.furrow")

    def test_carriage_returns_in_headers_are_no_part_of_them(self):
        values, wkt = self.values(), rasters.gdal("gdalsrsinfo", "-o", "wkt_esri", "--single-line", rasters.UTM).strip()
        for end in ("\n", "\r\n"):
            head = ["BYTEORDER I", "LAYOUT BIL", "NROWS 18", "NCOLS 24", "NBANDS 1", "NBITS 16", "PIXELTYPE SIGNEDINT",
                    "ULXMAP 500005", "ULYMAP 4999995", "XDIM 10", "YDIM 10", "NODATA -9999", ""]
            (self.folder / "in.bil").write_bytes(values.tobytes())
            (self.folder / "in.hdr").write_bytes(end.join(head).encode())
            (self.folder / "in.prj").write_bytes((wkt + end).encode())
            with self.subTest(format="BIL", end=repr(end)):
                self.assertEqual(self.check("in.bil")["geotransform"], [500000, 10, 0, 5000000, 0, -10])
                self.assertIn("33", self.json("info", "s.furrow")["srs"])
            rows = [" ".join(str(v) for v in values[24 * y:24 * y + 24]) for y in range(18)]
            head = ["ncols 24", "nrows 18", "xllcorner 500000", "yllcorner 4999820", "cellsize 10", "NODATA_value -9999"]
            (self.folder / "in.asc").write_bytes(end.join(head + rows + [""]).encode())
            with self.subTest(format="ASCII grid", end=repr(end)):
                self.assertEqual(self.check("in.asc")["geotransform"], [500000, 10, 0, 5000000, 0, -10])

    @long
    def test_byte_order_is_the_sources(self):
        values = self.values()
        for letter, order in (("I", values), ("M", array.array("h", values))):
            if letter == "M":
                order.byteswap()
            (self.folder / "in.bil").write_bytes(order.tobytes())
            (self.folder / "in.hdr").write_text(
                f"BYTEORDER {letter}\nNROWS 18\nNCOLS 24\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\n")
            with self.subTest(byteorder=letter):
                self.check("in.bil")
        for order in ("BIG", "LITTLE"):
            rasters.make(self.folder / "in.tif", 24, 18, values, "h", options=["-co", f"ENDIANNESS={order}"])
            with self.subTest(tiff=order):
                self.assertEqual((self.folder / "in.tif").read_bytes()[:2], b"MM" if order == "BIG" else b"II")
                self.check("in.tif")

    def test_a_float_grid_of_either_byte_order(self):
        values = array.array("f", [1.25 * i - 77 for i in range(24 * 18)])
        for name, order in (("LSBFIRST", values), ("MSBFIRST", array.array("f", values))):
            if name == "MSBFIRST":
                order.byteswap()
            (self.folder / "in.flt").write_bytes(order.tobytes())
            (self.folder / "in.hdr").write_bytes(
                ("ncols 24\r\nnrows 18\r\nxllcorner 0\r\nyllcorner 0\r\ncellsize 5\r\nNODATA_value -9999\r\n"
                 f"BYTEORDER {name}\r\n").encode())
            with self.subTest(byteorder=name):
                self.check("in.flt", values)


if __name__ == "__main__":
    main()
