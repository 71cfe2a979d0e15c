"""Sources of many formats, types and units, each beside GDAL's own values: what is imported is that, at each post, or it is told."""
import array
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import main
from raster_test import RasterTest
import rasters

WIDTH, HEIGHT = 30, 24


class Formats(RasterTest):
    def check(self, name, wanted, *options, within=0.002):
        """wanted: heights in rows from the north. Returns what was told."""
        result = self.furrow("import", name, "-o", "s.furrow", "--overwrite", "--max-error", 0.001, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        width, height, found = self.exported("s.furrow", "--layer", "base")
        self.assertEqual((width, height), (WIDTH, HEIGHT))
        for post, (got, right) in enumerate(zip(found, wanted, strict=True)):
            self.assertAlmostEqual(got, right, delta=within, msg=f"{name}: post {post % width}, row {post // width}")
        return result.stderr

    def grid(self, value=lambda column, row: 100 + column + 2 * (HEIGHT - 1 - row)):
        return [value(column, row) for row in range(HEIGHT) for column in range(WIDTH)]

    def test_bytes_with_a_sign(self):
        """GDAL has them as Byte with a PIXELTYPE, or as Int8 from 3.7 on."""
        values = self.grid(lambda column, row: column * 3 - row * 2 - 30)
        self.assertLess(min(values), -60)
        version = tuple(map(int, rasters.gdal("gdalinfo", "--version").split()[1].split(".")[:2]))
        if version >= (3, 7):
            path, options = rasters.make(self.folder / "plain.tif", WIDTH, HEIGHT, values, "h"), ["-ot", "Int8"]
        else:
            path = rasters.make(self.folder / "plain.tif", WIDTH, HEIGHT, array.array("B", array.array("b", values).tobytes()), "B")
            options = ["-co", "PIXELTYPE=SIGNEDBYTE"]
        rasters.gdal("gdal_translate", "-q", *options, path, self.folder / "signed.tif")
        told = self.check("signed.tif", values)
        self.assertNotIn("8 bits", told)
        self.refused(2, "import", "signed.tif", "-o", "x.furrow", "--height-range", "0,100")
        # A tag and --nodata are compared with the values, not with the bytes.
        self.ok("import", "signed.tif", "-o", "s.furrow", "--overwrite", "--nodata", -30)
        self.assertAlmostEqual(self.json("info", "s.furrow")["holes"], values.count(-30) / len(values), delta=1e-6)
        self.ok("import", "signed.tif", "-o", "s.furrow", "--overwrite", "--nodata", 226)
        self.assertEqual(self.json("info", "s.furrow")["holes"], 0)

    def test_units_that_are_known_and_others(self):
        values = self.grid()
        path = rasters.make(self.folder / "plain.tif", WIDTH, HEIGHT, values)
        for unit, metres in (("Meters", 1), ("feet", 0.3048), ("sft", 1200 / 3937), ("kilometers", 1000), ("fathoms", 1.8288), ("furlong", None), ("m above the pier", None)):
            text = (self.folder / "unit.vrt")
            rasters.gdal("gdal_translate", "-q", "-of", "VRT", path, text)
            text.write_text(text.read_text().replace("<ColorInterp>", f"<UnitType>{unit}</UnitType><ColorInterp>"))
            self.assertEqual(rasters.gdalinfo(text)["bands"][0]["unit"], unit)
            told = self.check("unit.vrt", [value * (metres or 1) for value in values], within=0.002 * max(1, metres or 1))
            self.assertEqual("is not known" in told, metres is None, told)
            if metres is None:
                self.assertIn(f"its unit is {unit}", told)
                self.assertNotIn("is not known", self.check("unit.vrt", [value * 0.3048 for value in values], "--s-unit", "ft"))

    def test_what_a_projection_does_not_hold_is_told(self):
        for width, lost in ((360, True), (10, False)):
            rasters.make(self.folder / "globe.tif", width, 180, [50.0] * (180 * width), west=-width / 2, north=90.0, step=1, srs="EPSG:4326")
            result = self.furrow("import", "globe.tif", "-o", "s.furrow", "--overwrite", "--t-srs", "EPSG:32631")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual("is left out" in result.stderr, lost, result.stderr)
        rasters.make(self.folder / "globe.tif", 360, 180, [50.0] * (180 * 360), west=-180.0, north=90.0, step=1, srs="EPSG:4326")
        self.assertNotIn("is left out", self.furrow("import", "globe.tif", "-o", "s.furrow", "--overwrite", "--t-srs", "EPSG:6933").stderr)
        self.assertNotIn("is left out", self.furrow("import", "globe.tif", "-o", "s.furrow", "--overwrite", "--window", "0,40,10,50", "--window-srs", "EPSG:4326").stderr)


if __name__ == "__main__":
    main()
