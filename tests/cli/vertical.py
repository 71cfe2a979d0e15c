"""What heights are above: told, kept, and converted by PROJ's grids, beside what gdaltransform says at the same points."""
import json
import pathlib
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import long, main, part, write_png16
from raster_test import RasterTest
import rasters

EGM96 = "+5773"
DATA = pathlib.Path("/usr/share/proj")


def converted(points, before, after):
    """Heights at (x, y, z) of one SRS with three axes in another."""
    text = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
    return [float(line.split()[2]) for line in rasters.gdal("gdaltransform", "-s_srs", before, "-t_srs", after, stdin=text).splitlines()]


def has_grid():
    try:
        return abs(converted([(15, 45, 0)], "EPSG:4326" + EGM96, "EPSG:4979")[0]) > 1
    except (OSError, ValueError, IndexError):
        return False


class Vertical(RasterTest):
    def heights_at(self, store, points, srs):
        lines = "".join(f"{x!r} {y!r}\n" for x, y, *_ in points)
        return [p["height"] for p in self.json("query", store, "--srs", srs, stdin=lines)["points"]]

    def ground(self, name, west, north, step, srs, width=80, height=70):
        """A slope, so that a shift of places would be seen."""
        cells = [500 + 3 * x - 2 * y for y in range(height) for x in range(width)]
        rasters.make(self.folder / name, width, height, cells, "f", west=west, north=north, step=step, srs=srs)
        return [(west + (x + 0.5) * step, north - (y + 0.5) * step) for x in (9, 31, 40, 66) for y in (7, 34, 61)]

    @unittest.skipUnless(has_grid(), "needs PROJ's grid egm96_15")
    def test_whole_metres_that_are_rounded_again_are_told(self):
        rasters.make(self.folder / "in.tif", 40, 30, [500 + x for y in range(30) for x in range(40)], "h", west=500000, north=7200000, step=900, srs="EPSG:32627")
        shift = ("--s-vertical", "egm96", "--t-vertical", "ellipsoid", "--overwrite")
        told = self.furrow("import", "in.tif", "-o", "s.furrow", *shift).stderr
        self.assertRegex(told, r"note: in\.tif: its heights are multiples of 1 m, and so they are again after the conversion to ellipsoid WGS 84: up to 0\.5 m off, .*"
                               r"; give --max-error 0\.05 to keep it smooth\n")
        for more in (("--max-error", "0.05", *shift), ("--s-vertical", "egm96", "--overwrite"), ("--s-vertical", "egm96", "--t-vertical", "egm96", "--overwrite")):
            self.assertNotIn("multiples", self.furrow("import", "in.tif", "-o", "s.furrow", *more).stderr)
        rasters.make(self.folder / "float.tif", 40, 30, [500 + x for y in range(30) for x in range(40)], "f", west=500000, north=7200000, step=900, srs="EPSG:32627")
        self.assertNotIn("multiples", self.furrow("import", "float.tif", "-o", "s.furrow", *shift).stderr)

    @unittest.skipUnless(has_grid(), "needs PROJ's grid egm96_15")
    def test_heights_differ_as_gdaltransform_says(self):
        for turn, (place, west, north, step, srs) in enumerate((("Nepal", 86.6, 28.2, 0.01, "EPSG:4326"), ("Iceland", 500000, 7200000, 900, "EPSG:32627"),
                                                               ("Andes", -70.3, -33.1, 0.0008, "EPSG:4326"), ("Java", 600000, 9200000, 25, "EPSG:32749"))):
            points = self.ground("in.tif", west, north, step, srs)
            metric = ("--t-srs", srs) if srs != "EPSG:4326" else ()
            spacing = ("--spacing", step * (1 if metric else 80000))
            deep = "EPSG:4979" if srs == "EPSG:4326" else None
            for before, after in part((("egm96", "ellipsoid"), ("ellipsoid", "egm96"), ("EPSG:5773", "ellipsoid")), turn % 3):
                with self.subTest(place=place, before=before, after=after):
                    self.ok("import", "in.tif", "-o", "plain.furrow", "--overwrite", *metric, *spacing, "--max-error", 0.001)
                    told = self.json("import", "in.tif", "-o", "s.furrow", "--overwrite", *metric, *spacing, "--max-error", 0.001, "--s-vertical",
                                     before, "--t-vertical", after)
                    kept = self.json("info", "s.furrow")
                    self.assertEqual(kept["vertical"], told["vertical"])
                    self.assertIn("ellipsoid WGS 84" if after == "ellipsoid" else "EGM96 height", kept["vertical"])
                    names = {"ellipsoid": deep or "EPSG:4979", "egm96": "EPSG:4326" + EGM96, "EPSG:5773": "EPSG:4326" + EGM96}
                    degrees = points
                    if not deep:
                        text = "".join(f"{x!r} {y!r}\n" for x, y in points)
                        found = rasters.gdal("gdaltransform", "-s_srs", srs, "-t_srs", "EPSG:4326", "-output_xy", stdin=text)
                        degrees = [tuple(map(float, line.split())) for line in found.splitlines()]
                    wanted = converted([(x, y, 0.0) for x, y in degrees], names[before], names[after])
                    pairs = zip(self.heights_at("s.furrow", points, srs), self.heights_at("plain.furrow", points, srs), strict=True)
                    for (found, plain), difference in zip(pairs, wanted, strict=True):
                        # Heights of the store lie between posts, of a geoid that is bent there.
                        self.assertAlmostEqual(found - plain, difference, delta=0.0025 + 1e-8 * (step if metric else step * 1e5) ** 2)
                    self.assertGreater(max(map(abs, wanted)), 5)

    @unittest.skipUnless(has_grid(), "needs PROJ's grid egm96_15")
    def test_what_a_source_says_is_told_kept_and_used(self):
        said = {"EPSG:4326" + EGM96: "EGM96 height", "EPSG:4979": "ellipsoid WGS 84", "EPSG:4326": "", "EPSG:32633+3855": "EGM2008 height"}
        for srs, name in said.items():
            with self.subTest(srs=srs):
                place = (15.1, 45.2, 0.001) if srs.startswith("EPSG:4") else (500000, 5000000, 90)
                self.ground("in.tif", *place, "EPSG:4326")
                rasters.gdal("gdal_translate", "-q", "-a_srs", srs, self.folder / "in.tif", self.folder / "said.tif")
                told = self.ok("import", "said.tif", "-o", "s.furrow", "--overwrite")
                self.assertIn(f"vertical: {name or 'not said'}", told)
                self.assertEqual("srs: WGS 84 / UTM zone 33N" in told, srs.startswith("EPSG:32633"))
                self.assertEqual(self.json("info", "s.furrow")["vertical"], name)
                self.assertRegex(self.ok("info", "s.furrow"), rf"vertical +{name or 'not said'}")
                globe = self.furrow("export", "s.furrow", "--tiles", "tiles")
                self.assertEqual(globe.returncode, 0, globe.stderr)
                self.assertEqual([line.split("; ")[1] for line in globe.stderr.splitlines() if "globes take heights as above the ellipsoid" in line],
                                 [] if "ellipsoid" in name else [f"import with {'' if name else '--s-vertical and '}--t-vertical ellipsoid for globes"])
                shutil.rmtree(self.folder / "tiles")
                self.ok("branch", "s.furrow", "b.furrow")
                self.assertEqual(self.json("info", "b.furrow")["vertical"], name)
                (self.folder / "b.furrow").unlink()
                if name == "":
                    self.assertIn("--s-vertical", self.refused(3, "import", "said.tif", "-o", "x.furrow", "--t-vertical", "egm96"))
        # The same heights need no grid and stay; --s-srs may say it, too.
        self.ground("in.tif", 15.1, 45.2, 0.001, "EPSG:4326")
        hashes = []
        for more in ((), ("--s-vertical", "egm96", "--t-vertical", "EPSG:5773"), ("--s-srs", "EPSG:4326" + EGM96, "--t-vertical", "egm96")):
            self.ok("import", "in.tif", "-o", "s.furrow", "--overwrite", "--spacing", 100, *more)
            hashes.append(self.exported("s.furrow", "--layer", "base"))
        self.assertEqual(hashes[0], hashes[1])
        self.assertEqual(hashes[0], hashes[2])

    @long
    @unittest.skipUnless(has_grid(), "needs PROJ's grid egm96_15")
    def test_sources_above_different_references_become_one(self):
        """The second is the first's ground in ellipsoidal heights."""
        self.ground("a.tif", 86.6, 28.2, 0.001, "EPSG:4326")
        self.ok("import", "a.tif", "-o", "a.furrow", "--spacing", 90, "--s-vertical", "egm96", "--t-vertical", "ellipsoid", "--max-error", 0)
        self.ok("export", "a.furrow", "-o", "b.tif")
        rasters.gdal("gdal_translate", "-q", "-a_srs", "EPSG:4326" + EGM96, self.folder / "a.tif", self.folder / "geoid.tif")
        rasters.gdal("gdal_translate", "-q", "-a_srs", "EPSG:32645+3855", self.folder / "b.tif", self.folder / "said.tif")
        told = self.furrow("import", "geoid.tif", "said.tif", "-o", "s.furrow", "--spacing", 90, "--max-error", 0.001, "--json")
        self.assertGreater(json.loads(told.stdout)["overlap"]["greatest"], 20)
        self.assertRegex(told.stderr, "above EGM96 height, and those of said.tif above EGM2008 height")
        self.ok("import", "b.tif", "-o", "b.furrow", "--s-vertical", "ellipsoid", "--t-vertical", "egm96", "--max-error", 0.001)
        self.ok("export", "b.furrow", "-o", "back.tif")
        told = self.json("import", "geoid.tif", "back.tif", "-o", "s.furrow", "--overwrite", "--spacing", 90, "--max-error", 0.001)
        self.assertLess(told["overlap"]["greatest"], 0.7)  # between posts

    @long
    def test_an_exported_raster_says_above_what_its_heights_are(self):
        for turn, (srs, west, step) in enumerate((("EPSG:32645", 500000, 90), ("EPSG:4326", 86.6, 0.001))):
            self.ground("a.tif", west, 3100000 if step > 1 else 28.2, step, srs)
            for reference, said in part((("egm96", "EGM96 height"), ("EPSG:3855", "EGM2008 height"), ("ellipsoid", None), ("EPSG:6360", None)), turn, 2 + turn):
                with self.subTest(srs=srs, reference=reference):
                    self.ok("import", "a.tif", "-o", "a.furrow", "--overwrite", "--spacing", 90, "--s-vertical", reference)
                    told = self.furrow("export", "a.furrow", "-o", "b.tif")
                    self.assertEqual(0, told.returncode, told.stderr)
                    self.assertEqual(said is None, "cannot say" in told.stderr, told.stderr)  # those of EPSG:6360 are feet
                    found = rasters.gdalinfo(self.folder / "b.tif")
                    wkt, band = found["coordinateSystem"]["wkt"], found["bands"][0]
                    self.assertEqual((band["unit"], band["description"]), ("m", "surface"))
                    self.assertEqual(found["metadata"][""]["VERTICAL_REFERENCE"], self.json("info", "a.furrow")["vertical"])
                    self.assertEqual(said is not None, wkt.startswith("COMPOUNDCRS"), wkt)
                    self.ok("import", "b.tif", "-o", "b.furrow", "--overwrite")
                    self.assertEqual(self.json("info", "b.furrow")["vertical"], found["metadata"][""]["VERTICAL_REFERENCE"].split(", converted")[0])
                    self.ok("export", "a.furrow", "-o", "c.tif", "--layer", "offset")
                    found = rasters.gdalinfo(self.folder / "c.tif")
                    self.assertNotIn("COMPOUNDCRS", found["coordinateSystem"]["wkt"])
                    self.assertNotIn("VERTICAL_REFERENCE", found["metadata"][""])
                    self.assertEqual((found["bands"][0]["unit"], found["bands"][0]["description"]), ("m", "offset"))

    @long
    def test_what_contradicts_the_file_or_is_not_said_by_all_is_told(self):
        self.make("wide.tif", 40, 30, lambda x, y: 100, srs="EPSG:32633+5773", step=30)
        for name, west, step, options in (("beside.tif", 501200, 30, ()), ("fine.tif", 500300, 5, ()), ("other.tif", 500300, 5, ("-a_srs", "EPSG:32633+3855"))):
            self.make(name, 40, 30, lambda x, y: 100, west=west, north=4999800 if step == 5 else 5000000, step=step, options=options)
        untold, unlike = "does not say above what its heights are, and wide.tif says EGM96 height", "EGM2008 height, and those of wide.tif above EGM96 height"
        for sources, told in ((("wide.tif", "--s-vertical", "egm2008"), "the file says heights above EGM96 height; --s-vertical egm2008 is used"),
                              (("wide.tif", "--s-vertical", "egm96"), None), (("beside.tif", "--s-vertical", "egm96"), None),
                              (("wide.tif", "beside.tif"), untold), (("beside.tif", "wide.tif"), untold), (("wide.tif", "--inset", "fine.tif"), untold),
                              (("wide.tif", "--inset", "other.tif"), unlike), (("wide.tif", "other.tif"), unlike), (("beside.tif", "fine.tif"), None)):
            with self.subTest(sources=sources):
                made = self.furrow("import", *sources, "-o", "s.furrow", "--overwrite")
                self.assertEqual(0, made.returncode, made.stderr)
                self.assertEqual(told is not None, "above" in made.stderr, made.stderr)
                self.assertIn(told or "", made.stderr)

    def test_feet_become_metres_by_whoever_says_that_they_are(self):
        us, ft = 1200 / 3937, 0.3048
        for name, srs in (("plain", "EPSG:32611"), ("plane", "EPSG:2229"), ("said", "EPSG:32611+6360")):
            self.make(f"{name}.tif", 20, 15, lambda x, y: 1000, srs=srs)
        rasters.gdal("gdal_translate", "-q", "-of", "VRT", self.folder / "plain.tif", self.folder / "tagged.vrt")
        text = (self.folder / "tagged.vrt").read_text()
        (self.folder / "tagged.vrt").write_text(text.replace("<ColorInterp>", "<UnitType>ft</UnitType><ColorInterp>"))
        navd = ("--s-vertical", "EPSG:6360")
        for source, options, metres, told in (
                ("plain.tif", (), 1, None), ("plain.tif", navd, us, None), ("plain.tif", (*navd, "--t-vertical", "EPSG:5703"), us, None),
                ("plain.tif", ("--s-srs", "EPSG:32611+6360"), us, None), ("plain.tif", ("--s-unit", "ft"), ft, None), ("said.tif", (), us, None),
                ("tagged.vrt", (), ft, None), ("tagged.vrt", navd, ft, "its unit is ft; that is used, not the 0.3048006096 m of EPSG:6360"),
                ("tagged.vrt", ("--s-unit", "us-ft"), us, "its unit is ft; --s-unit us-ft is used"), ("tagged.vrt", ("--s-vertical", "egm96"), ft,
                                                                                                   "not the 1 m of egm96"),
                ("plane.tif", (), 1, "Give --s-unit us-ft"), ("plane.tif", ("--s-unit", "m"), 1, None), ("plane.tif", navd, us, None)):
            with self.subTest(source=source, options=options):
                made = self.furrow("import", source, "-o", "s.furrow", "--overwrite", "--spacing", 10, "--max-error", 0, *options)
                self.assertEqual(0, made.returncode, made.stderr)
                self.assertEqual(told is not None, "nit" in made.stderr, made.stderr)
                self.assertIn(told or "", made.stderr)
                for height in self.json("info", "s.furrow")["height"]:
                    self.assertAlmostEqual(height, 1000 * metres, delta=1e-4)
        write_png16(self.folder / "a.png", 9, 9, lambda x, y: 100)
        self.assertIn("--height-range", self.refused(2, "import", "a.png", "-o", "x.furrow", "--s-unit", "ft"))

    def test_a_grid_that_is_not_there_is_named_and_where_to_put_it(self):
        folder = self.folder / "proj"
        folder.mkdir()
        if not (DATA / "proj.db").exists():
            self.skipTest("needs PROJ's database")
        (folder / "proj.db").symlink_to(DATA / "proj.db")
        self.ground("in.tif", 15.1, 45.2, 0.001, "EPSG:4326")
        env = {"PROJ_LIB": str(folder), "PROJ_DATA": str(folder), "XDG_DATA_HOME": str(self.folder / "home"), "PROJ_NETWORK": "OFF"}
        arguments = ("import", "in.tif", "-o", "s.furrow", "--s-vertical", "egm96", "--t-vertical", "ellipsoid")
        told = self.refused(3, *arguments, env=env)
        self.assertIn("us_nga_egm96_15.tif", told)
        self.assertIn(str(self.folder / "home" / "proj"), told)
        self.assertEqual(list(self.folder.glob("s.furrow*")), [])
        self.assertIn("egm08", self.refused(3, "import", "in.tif", "-o", "s.furrow", "--s-vertical", "egm2008", "--t-vertical", "ellipsoid", env=env))
        if (DATA / "egm96_15.gtx").exists():
            (self.folder / "home" / "proj").mkdir(parents=True)
            shutil.copy(DATA / "egm96_15.gtx", self.folder / "home" / "proj")
            self.ok(*arguments, env=env)

    def test_what_is_no_vertical_reference_is_refused(self):
        self.ground("in.tif", 15.1, 45.2, 0.001, "EPSG:4326")
        self.ground("bare.tif", 0, 70, 1, None)
        for source, more, why in (("in.tif", ("--s-vertical", "egm97"), "does not know"), ("in.tif", ("--s-vertical", "EPSG:4326"), "not one of heights"),
                                  ("in.tif", ("--s-vertical", "egm96", "--t-vertical", "EPSG:5706"), "not one of heights"),
                                  ("bare.tif", ("--s-vertical", "egm96", "--t-vertical", "ellipsoid"), "no SRS")):
            self.assertIn(why, self.refused(3, "import", source, "-o", "x.furrow", *more))
        self.assertEqual(list(self.folder.glob("x.furrow*")), [])


if __name__ == "__main__":
    main()
