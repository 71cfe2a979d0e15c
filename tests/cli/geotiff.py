"""Exported GeoTIFFs: tiled, with overviews, valid to GDAL's own validator, with the values and the place that they had."""
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import main
from raster_test import RasterTest
import rasters

VALIDATOR = ("/usr/bin/python3", "-m", "osgeo_utils.samples.validate_cloud_optimized_geotiff")


class GeoTiff(RasterTest):
    def check(self, name, width, height):
        """The layout, by GDAL's validator if it is there, and by what gdalinfo tells."""
        path = self.folder / name
        info = rasters.gdalinfo(path)
        self.assertEqual(info["size"], [width, height])
        self.assertEqual(info["metadata"]["IMAGE_STRUCTURE"]["LAYOUT"], "COG")
        band, = info["bands"]
        self.assertEqual(band["block"], [512, 512])
        halvings = [overview["size"] for overview in band.get("overviews", [])]
        self.assertEqual(halvings, [[width >> k, height >> k] for k in range(1, len(halvings) + 1)])
        self.assertEqual(len(halvings) > 0, max(width, height) > 512)
        self.assertLessEqual(max(halvings[-1] if halvings else (1, 1)), 512)
        if subprocess.run([VALIDATOR[0], "-c", "import osgeo_utils.samples.validate_cloud_optimized_geotiff"], capture_output=True).returncode == 0:
            said = subprocess.run([*VALIDATOR, path], capture_output=True, text=True)
            self.assertEqual(said.returncode, 0, said.stdout + said.stderr)
            self.assertIn("is a valid cloud optimized GeoTIFF", said.stdout)
            self.assertNotIn("warning", (said.stdout + said.stderr).lower())
        self.assertEqual([left.name for left in self.folder.glob(name + ".*") if left.suffix != ".xml"], [])
        return info

    def test_exports_are_cloud_optimized(self):
        for width, height in ((1, 3), (2, 2), (513, 40), (700, 1300)):
            source = self.make("höhe g.tif", max(width, 2), max(height, 2),
                               lambda column, row: -1.0 if (column, row) == (5, 7) else 700 + 3 * column + (row * row) % 13 + row / 1024, nodata=-1)
            self.ok("import", source, "-o", "s.furrow", "--overwrite", "--max-error", 0)
            self.ok("export", "s.furrow", "-o", "aus gang.tif", *(("--window", "0,0,0,1000") if width == 1 else ()))
            self.check("aus gang.tif", width, height)
            theirs = rasters.pixels(source)[2]
            ours = rasters.pixels(self.folder / "aus gang.tif")[2]
            nodata = rasters.nodata_of(self.folder / "aus gang.tif")
            for row in range(height):
                for column in range(width):
                    want = theirs[row * max(width, 2) + column]
                    self.assertEqual(ours[row * width + column], nodata if want == -1 else want, (column, row))

    def test_all_layers_are(self):
        self.make("g.tif", 600, 600, lambda column, row: 700.0 + (column * row) % 7)
        self.ok("import", "g.tif", "-o", "s.furrow")
        for layer, kind in (("surface", "Float32"), ("offset", "Float32"), ("fixed_point", "Int32"), ("hillshade", "Byte")):
            self.ok("export", "s.furrow", "-o", f"{layer}.tif", "--layer", layer)
            self.assertEqual(self.check(f"{layer}.tif", 600, 600)["bands"][0]["type"], kind)

    def test_its_system_is_read_with_what_heights_are_above(self):
        self.make("g.tif", 20, 20, lambda column, row: 5.0)
        for reference, code in (("egm96", "5773"), ("EPSG:5703", "5703")):
            self.ok("import", "g.tif", "-o", "s.furrow", "--overwrite", "--s-vertical", reference)
            self.ok("export", "s.furrow", "-o", "o.tif")
            wkt = rasters.gdalinfo(self.folder / "o.tif")["coordinateSystem"]["wkt"]
            self.assertIn(f'ID["EPSG",{code}]', wkt)
            self.assertIn('ID["EPSG",32633]', wkt)

    def test_overviews_leave_holes_out(self):
        self.make("g.tif", 1100, 600, lambda column, row: -1.0 if column % 2 else 500.0, nodata=-1)
        self.ok("import", "g.tif", "-o", "s.furrow")
        self.ok("export", "s.furrow", "-o", "o.tif")
        rasters.gdal("gdal_translate", "-q", "-ovr", 0, self.folder / "o.tif", self.folder / "half.tif")
        self.assertEqual(set(rasters.pixels(self.folder / "half.tif")[2]), {500.0})

class Png(RasterTest):
    def holed(self, least):
        self.make("g.tif", 40, 30, lambda column, row: -1 if 10 < column < 15 and row > 20 else least + column, code="h", nodata=-1)
        self.ok("import", "g.tif", "-o", "s.furrow", "--overwrite")
        return [i for i in range(40 * 30) if 10 < i % 40 < 15 and i // 40 > 20]

    def test_holes_are_declared(self):
        holes = self.holed(100)
        for layer in ("surface", "hillshade"):
            told = self.furrow("export", "s.furrow", "-o", "lö cher.png", "--layer", layer)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertEqual(rasters.nodata_of(self.folder / "lö cher.png"), 0)
            self.assertEqual([i for i, value in enumerate(rasters.pixels(self.folder / "lö cher.png")[2]) if value == 0], holes)
        self.ok("export", "s.furrow", "-o", "h.png")
        for place in (True, False):  # by GDAL, and by our own reader
            for beside in self.folder.glob("h.*"):
                if not place and beside.name != "h.png":
                    beside.unlink()
            self.ok("import", "h.png", "-o", "t.furrow", "--overwrite")
            self.assertEqual([i for i, value in enumerate(self.exported("t.furrow", "--layer", "base")[2]) if value is None], holes)

    def test_a_value_that_ground_has_is_not_declared(self):
        self.holed(0)
        self.assertIn("which is the height 0 m, too", self.furrow("export", "s.furrow", "-o", "h.png").stderr)
        self.assertIsNone(rasters.nodata_of(self.folder / "h.png"))

    def test_a_png_without_holes_declares_nothing(self):
        self.make("g.tif", 40, 30, lambda column, row: column + 1, code="h")
        self.ok("import", "g.tif", "-o", "s.furrow")
        for layer in ("surface", "hillshade"):
            self.ok("export", "s.furrow", "-o", "h.png", "--layer", layer)
            self.assertIsNone(rasters.nodata_of(self.folder / "h.png"))


if __name__ == "__main__":
    main()
