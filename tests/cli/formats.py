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
        rasters.gdal("gdal_translate", "-q", *options, "-a_nodata", -30, path, self.folder / "tagged.tif")
        self.ok("import", "tagged.tif", "-o", "s.furrow", "--overwrite")
        self.assertGreater(values.count(-30), 0)
        self.assertAlmostEqual(self.json("info", "s.furrow")["holes"], values.count(-30) / len(values), delta=1e-6)

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

    def described(self, name, items, driver=None):
        """A raster whose band has metadata, in a VRT or as another driver writes that."""
        path = rasters.make(self.folder / "plain.tif", WIDTH, HEIGHT, self.grid())
        text = self.folder / "described.vrt"
        rasters.gdal("gdal_translate", "-q", "-of", "VRT", path, text)
        lines = "".join(f'<MDI key="{key}">{value}</MDI>' for key, value in items.items())
        text.write_text(text.read_text().replace("<ColorInterp>", f"<Metadata>{lines}</Metadata><ColorInterp>"))
        if driver is None:
            return text.rename(self.folder / name)
        rasters.gdal("gdal_translate", "-q", "-of", driver, text, self.folder / name)
        return self.folder / name

    def test_names_that_mean_a_depth(self):
        for number, (items, sign) in enumerate((({"standard_name": "sea_floor_depth_below_geoid"}, -1), ({"standard_name": "depth"}, -1),
                                                ({"standard_name": "sea_floor_depth_below_geoid", "positive": "up"}, 1), ({"standard_name": "height_above_geoid"}, 1),
                                                ({"positive": "down"}, -1))):
            with self.subTest(items=items):
                told = self.check(self.described(f"{number}.vrt", items).name, [sign * value for value in self.grid()])
                self.assertEqual("count down" in told, sign < 0, told)

    def with_driver(self, name):
        if f"  {name} -" not in rasters.gdal("gdalinfo", "--formats"):
            self.skipTest(f"not on this machine: GDAL's driver {name}")

    def test_a_bag_has_elevations_though_its_axis_points_down(self):
        self.with_driver("BAG")
        path = self.described("b.bag", {}, "BAG")
        self.assertIn("down", rasters.gdal("gdalinfo", path))
        self.assertNotIn("count down", self.check("b.bag", self.grid()))

    def test_a_part_of_an_hdf5_file_by_its_name(self):
        self.with_driver("BAG")
        self.with_driver("HDF5")
        self.described("b.bag", {}, "BAG")
        self.ok("import", 'HDF5:"b.bag"://BAG_root/elevation', "-o", "s.furrow")
        self.assertEqual(self.json("info", "s.furrow")["posts"], [WIDTH, HEIGHT])
        self.assertIn("network", self.refused(3, "import", 'HDF5:"http://127.0.0.1:1/b.h5"://elevation', "-o", "x.furrow"))

    def test_coarse_degrees_without_an_srs_are_told_where_the_ground_is_higher_than_wide(self):
        for rise, told in ((10.0, True), (0.01, False)):
            self.make("d.tif", 50, 40, lambda column, row: rise * column, west=12.0, north=45.0, step=0.25, srs=None)
            result = self.furrow("import", "d.tif", "-o", "s.furrow", "--overwrite")
            self.assertEqual((result.returncode, "looks like degrees" in result.stderr), (0, told), result.stderr)

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
