"""Bands, heights that are coded in colours, averages and Lanczos kernels: each beside GDAL's own answer, or the code's formula."""
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import largest, main
from raster_test import RasterTest
import rasters

WIDTH, HEIGHT = 60, 50
CODES = {"terrarium": (1 / 256, -32768), "mapbox": (0.1, -10000)}


def ground(column, row):
    return 300 + 80 * math.sin(column / 5) + 60 * math.cos(row / 7) + (column * 7 + row * 13) % 11


class Coded(RasterTest):
    def colours(self, name, codes, width=40, height=30, alpha=None, driver="GTiff", **options):
        """Writes whole numbers of 24 bits as red, green and blue, and a fourth band if `alpha` is given."""
        bands = [[code >> shift & 255 for code in codes] for shift in (16, 8, 0)] + ([alpha] if alpha else [])
        for i, band in enumerate(bands):
            rasters.make(self.folder / f"band{i}.tif", width, height, band, "B", **options)
        rasters.gdal("gdalbuildvrt", "-q", "-separate", self.folder / "bands.vrt", *(self.folder / f"band{i}.tif" for i in range(len(bands))))
        names = ("red", "green", "blue", "alpha")[:len(bands)]
        rasters.gdal("gdal_translate", "-q", "-of", driver, "-colorinterp", ",".join(names), self.folder / "bands.vrt", self.folder / name)
        return name

    def test_codes_become_exact_heights(self):
        """Whole numbers of the code come back from the store: all of them, from the least to the greatest that ground has."""
        random.seed(3)
        for encoding, (scale, offset) in CODES.items():
            least, most = ((height - offset) / scale for height in (-9000, 9000))
            codes = [random.randint(math.ceil(least), math.floor(most)) for _ in range(40 * 30)]
            for name, driver in (("höhen 1.png", "PNG"), ("c.tif", "GTiff")):
                self.colours(name, codes, driver=driver)
                self.ok("import", name, "-o", "s.furrow", "--overwrite", "--encoding", encoding)
                cells = self.exported("s.furrow", "--layer", "base")[2]
                read = [rasters.pixels(self.folder / name, "B", band)[2] for band in (1, 2, 3)]
                for i, found in enumerate(cells):
                    self.assertEqual(65536 * read[0][i] + 256 * read[1][i] + read[2][i], codes[i])
                    self.assertLess(abs(found - (codes[i] * scale + offset)), 1e-9 if encoding == "terrarium" else 0.0005)  # a float holds no tenth

    def test_clear_pixels_and_values_of_a_tag_are_holes(self):
        codes = [8_400_000 + i for i in range(40 * 30)]
        self.colours("a.tif", codes, alpha=[0 if i % 40 in (3, 4) else 255 for i in range(40 * 30)])
        self.ok("import", "a.tif", "-o", "s.furrow", "--encoding", "terrarium")
        cells = self.exported("s.furrow", "--layer", "base")[2]
        self.assertEqual([i for i, value in enumerate(cells) if value is None], [i for i in range(40 * 30) if i % 40 in (3, 4)])
        codes[45] = codes[700] = 0
        self.colours("n.tif", codes)
        self.ok("import", "n.tif", "-o", "s.furrow", "--overwrite", "--encoding", "terrarium", "--nodata", -32768)
        cells = self.exported("s.furrow", "--layer", "base")[2]
        self.assertEqual([i for i, value in enumerate(cells) if value is None], [45, 700])
        # A red, or a green, that is 0 is not nodata: only 0, 0, 0 is.
        codes[46] = 8_388_608
        self.colours("t.tif", codes)
        rasters.gdal("gdal_translate", "-q", "-a_nodata", 0, self.folder / "t.tif", self.folder / "u.tif")
        self.ok("import", "u.tif", "-o", "s.furrow", "--overwrite", "--encoding", "terrarium")
        cells = self.exported("s.furrow", "--layer", "base")[2]
        self.assertEqual([i for i, value in enumerate(cells) if value is None], [45, 700])
        self.assertEqual(cells[46], 0)

    def test_coded_heights_are_resampled_as_heights(self):
        """Between 255 and 256 all three colours jump."""
        codes = [8_388_608 + 64 * (i % 40) + 16 * (i // 40) for i in range(40 * 30)]
        self.colours("c.tif", codes)
        heights = self.make("h.tif", 40, 30, lambda column, row: (64 * column + 16 * row) / 256)
        for source, options in (("c.tif", ("--encoding", "terrarium")), (heights, ())):
            self.ok("import", source, "-o", f"{pathlib.Path(source).stem}.furrow", *options, "--spacing", 4, "--max-error", 0.0005)
        self.assertEqual(self.exported("c.furrow", "--layer", "base")[2], self.exported("h.furrow", "--layer", "base")[2])

    def test_what_codes_no_heights_is_refused(self):
        self.make("h.tif", 20, 20, lambda column, row: 5.0)
        self.assertIn("no red, green and blue", self.refused(3, "import", "h.tif", "-o", "s.furrow", "--encoding", "mapbox"))
        self.colours("c.tif", [9_000_000] * 1200)
        self.assertIn("--encoding", self.refused(3, "import", "c.tif", "-o", "s.furrow"))
        self.assertIn("--band", self.refused(2, "import", "c.tif", "-o", "s.furrow", "--encoding", "mapbox", "--band", 2))
        self.assertIn("--height-range", self.refused(2, "import", "c.tif", "-o", "s.furrow", "--encoding", "mapbox", "--height-range", "0,9"))
        rasters.gdal("gdal_translate", "-q", "-co", "COMPRESS=JPEG", self.folder / "c.tif", self.folder / "j.tif")
        self.assertIn("with loss", self.refused(3, "import", "j.tif", "-o", "s.furrow", "--encoding", "mapbox"))
        self.assertEqual([path.name for path in self.folder.glob("s.furrow*")], [])


class Bands(RasterTest):
    def test_a_band_is_chosen(self):
        for i in range(3):
            self.make(f"{i}.tif", 30, 20, lambda column, row, i=i: 1000.0 * i + column + row / 8, nodata=-5 if i == 1 else None)
        rasters.gdal("gdalbuildvrt", "-q", "-separate", self.folder / "all.vrt", *(self.folder / f"{i}.tif" for i in range(3)))
        rasters.gdal("gdal_translate", "-q", self.folder / "all.vrt", self.folder / "drei bänder.tif")
        for number in (1, 2, 3):
            rasters.gdal("gdal_translate", "-q", "-b", number, self.folder / "drei bänder.tif", self.folder / "one.tif")
            self.ok("import", "drei bänder.tif", "--band", number, "-o", "s.furrow", "--overwrite", "--max-error", 0)
            self.assertEqual(self.exported("s.furrow", "--layer", "base")[2], list(rasters.pixels(self.folder / "one.tif")[2]))
        self.assertIn("--band 4 is not there", self.refused(3, "import", "drei bänder.tif", "--band", 4, "-o", "t.furrow"))
        self.assertIn("--band names another", self.furrow("import", "drei bänder.tif", "-o", "t.furrow").stderr)
        self.assertIn("from 1", self.refused(2, "import", "drei bänder.tif", "--band", 0, "-o", "u.furrow"))


class Kernels(RasterTest):
    def beside_gdal(self, method, spacing, source="g.tif"):
        """The greatest difference from gdalwarp's answer, without a border as wide as the kernel."""
        self.ok("import", source, "-o", "s.furrow", "--overwrite", "-r", method, "--spacing", spacing, "--max-error", 0.0005)
        width, height, ours = self.exported("s.furrow", "--layer", "base")
        corners = rasters.gdalinfo(self.folder / "read.tif")["cornerCoordinates"]
        rasters.gdal("gdalwarp", "-q", "-overwrite", "-r", method, "-tr", spacing, spacing, "-te", *corners["lowerLeft"], *corners["upperRight"], "-ot", "Float64",
                     self.folder / source, self.folder / "gdal.tif")
        theirs = rasters.pixels(self.folder / "gdal.tif")[2]
        edge = math.ceil(3 * max(10, spacing) / spacing)
        inner = [y * width + x for y in range(edge, height - edge) for x in range(edge, width - edge)]
        self.assertGreater(len(inner), 20)
        return largest(abs(ours[i] - theirs[i]) for i in inner)

    def test_averages_are_gdals(self):
        self.make("g.tif", WIDTH, HEIGHT, ground)
        for spacing in (40, 25, 30, 12.5, 7, 4):
            self.assertLess(self.beside_gdal("average", spacing), 0.0006, spacing)

    def test_lanczos_is_gdals(self):
        self.make("g.tif", WIDTH, HEIGHT, ground)
        for spacing, most in ((7, 0.001), (4, 0.001), (30, 0.05)):
            self.assertLess(self.beside_gdal("lanczos", spacing), most, spacing)

    def test_lanczos_keeps_a_slope(self):
        """gdalwarp 3.6 has 144 and 154 m for 145 and 155 here."""
        self.make("r.tif", WIDTH, HEIGHT, lambda column, row: 100 + 2.0 * column)
        for spacing in (25, 12.5, 30, 4):
            self.ok("import", "r.tif", "-o", "s.furrow", "--overwrite", "-r", "lanczos", "--spacing", spacing, "--max-error", 0.0005)
            info = self.json("info", "s.furrow")
            text = "".join(f"{500000 + 10 * column + 5.0!r} 4999750\n" for column in range(10, 40))
            for column, point in enumerate(self.json("query", "s.furrow", "--srs", "store", stdin=text)["points"], start=10):
                self.assertAlmostEqual(point["height"], 100 + 2 * column, delta=0.08 if spacing < 10 else 0.01, msg=(spacing, info["spacing"]))

    def test_posts_that_fit_are_copied(self):
        self.make("g.tif", WIDTH, HEIGHT, ground)
        own = rasters.pixels(self.folder / "g.tif")[2]
        for method in ("average", "lanczos", "near", "cubic"):
            self.ok("import", "g.tif", "-o", "s.furrow", "--overwrite", "-r", method, "--max-error", 0)
            self.assertEqual(self.exported("s.furrow", "--layer", "base")[2], list(own))

    def test_holes_have_no_weight(self):
        self.make("h.tif", WIDTH, HEIGHT, lambda column, row: -1.0 if (column, row) == (30, 25) else 500.0, nodata=-1)
        for method in ("average", "lanczos"):
            for spacing in (25, 4):
                self.ok("import", "h.tif", "-o", "s.furrow", "--overwrite", "-r", method, "--spacing", spacing, "--max-error", 0.0005)
                values = {value for value in self.exported("s.furrow", "--layer", "base")[2] if value is not None}
                self.assertLess(largest(abs(value - 500) for value in values), 0.001)


if __name__ == "__main__":
    main()
