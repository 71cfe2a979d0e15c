"""What the tests of importing and exporting rasters share: rasters made, and stores read back, by GDAL's programs."""
import math
import subprocess
import unittest

from furrow_test import FurrowTest, has_gdal
import rasters

WEST, SOUTH = 500000, 5000000  # of the terrain's first post, EPSG:32632
POSTS = 65                     # 1 m apart
STEP = 0.25                    # m, of the picture's pixels: 4 a post


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


class PictureTest(RasterTest):
    """Pictures over a terrain: GeoTIFFs that GDAL makes, and their pixels."""

    def gdal(self, *arguments, stdin=None):
        return subprocess.run([*map(str, arguments)], cwd=self.folder, check=True, capture_output=True, text=True, input=stdin).stdout

    def picture(self, name, value, x0=0, y0=0, width=257, height=257, step=STEP, srs="EPSG:32632", *more):
        """A GeoTIFF of three bands; its pixels' centres are x0, y0 and multiples of `step`, metres from the first post."""
        rows = b"".join(bytes(value(x0 + i * step, y0 + j * step)) for j in reversed(range(height)) for i in range(width))
        (self.folder / "picture.ppm").write_bytes(b"P6\n%d %d\n255\n" % (width, height) + rows)
        west, south = (WEST, SOUTH) if srs else (0, 0)
        corners = (west + x0 - step / 2, south + y0 + (height - 0.5) * step, west + x0 + (width - 0.5) * step, south + y0 - step / 2)
        self.gdal("gdal_translate", "-q", "-a_ullr", *corners, *(("-a_srs", srs) if srs else ()), *more, "picture.ppm", name)
        return name

    def store(self, *more, name="s.furrow", tile=16):
        self.ok("import", "dem.tif", "-o", name, "--tile", tile, "--overwrite", *(("--force",) if "--imagery" in more else ()), *more)
        return name

    def pixels(self, picture):
        """(width, height, rows from the south of tuples), without opacity"""
        self.gdal("gdal_translate", "-q", "-of", "PNM", "-b", 1, "-b", 2, "-b", 3, picture, "read.ppm")
        data = (self.folder / "read.ppm").read_bytes().split(b"\n", 3)
        width, height = map(int, data[1].split())
        at = data[3]
        rows = [[tuple(at[3 * (j * width + i):3 * (j * width + i) + 3]) for i in range(width)] for j in range(height)]
        return width, height, rows[::-1]
