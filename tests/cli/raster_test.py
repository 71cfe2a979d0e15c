"""What the tests of importing and exporting rasters share: rasters made, and stores read back, by GDAL's programs."""
import math
import unittest

from furrow_test import FurrowTest, has_gdal
import rasters


@unittest.skipUnless(has_gdal(), "needs GDAL's programs")
class RasterTest(FurrowTest):
    def make(self, name, width, height, value, code="f", **options):
        cells = [value(x, y) for y in range(height) for x in range(width)]
        return rasters.make(self.folder / name, width, height, cells, code, **options)

    def exported(self, store, *arguments, code="d"):
        """(width, height, pixels in rows from the north, None where the file says nodata)"""
        self.ok("export", store, "-o", "read.tif", *arguments)
        nodata = rasters.nodata_of(self.folder / "read.tif")
        width, height, cells = rasters.pixels(self.folder / "read.tif", code)
        return width, height, [None if math.isnan(v) or v == nodata else v for v in cells]
