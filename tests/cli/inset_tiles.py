"""furrow export --tiles of a store with insets: which tiles there are, and their heights beside `furrow query`."""
import json
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import largest, main
from raster_test import RasterTest
import rasters
import tile_readers

SITE = (800, 600, 1300, 1000)  # west, south, east, north, metres from the country's first post
SCAN = (1000, 780, 1040, 810)
SIDE = 8192  # of the map of a store of 97 x 81 posts of 32 m: zoom 0 is one tile of 256 pixels
SCENE = """scene: 1
time_step: 0.05
end_time: 8
spacing: 4
redistribute: {{model: box}}
objects:
  - {{name: ball, shape: {{sphere: {{radius: 12}}}}, sink: 2, path: {{points: {points}, speed: 100}}}}
"""


def site(x, y):
    return 407 + 20 * math.sin(x / 170) + 10 * math.cos(y / 150) + 2 * math.sin(x / 9) * math.cos(y / 7)


class InsetTiles(RasterTest):
    def setUp(self):
        super().setUp()
        self.leaflet = self.folder / "leaflet"
        self.leaflet.mkdir()
        for name in ("leaflet.js", "leaflet.css"):
            (self.leaflet / name).write_text("")

    def raster(self, name, value, box, step, srs):
        west, south, east, north = box
        width, height = round((east - west) / step) + 1, round((north - south) / step) + 1
        self.make(name, width, height, lambda x, y: value(west + x * step, north - y * step), step=step, srs=srs,
                  west=500000 + west - step / 2, north=5000000 + north + step / 2)

    def imported(self, srs="", tile=64):
        self.raster("country.tif", lambda x, y: 400 + 20 * math.sin(x / 170) + 10 * math.cos(y / 150), (0, 0, 96 * 32, 80 * 32), 32, srs)
        self.raster("site.tif", site, SITE, 1, srs)
        self.raster("scan.tif", lambda x, y: site(x, y) - 1 + 0.3 * math.sin(3 * x), SCAN, 1 / 8, srs)
        self.ok("import", "country.tif", "--inset", "site.tif", "--inset", "scan.tif", "-o", "s.furrow", "--tile", tile, "--overwrite")
        return "s.furrow"

    def export(self, store, folder="tiles", *options):
        self.ok("export", store, "--tiles", folder, "--leaflet", self.leaflet, *options)
        return self.folder / folder

    def tiles(self, folder, kind, suffix=".png"):
        """{z: {(x, y)}}"""
        tiles = {}
        for path in (folder / kind).rglob("*" + suffix):
            z, x, y = (int(part) for part in path.relative_to(folder / kind).with_suffix("").parts)
            tiles.setdefault(z, set()).add((x, y))
        return tiles

    def middles(self, z, x, y, count=40):
        """(row, column, east, north) of the middles of pixels."""
        step = SIDE / 2 ** z / 256
        for _ in range(count):
            row, column = random.randrange(256), random.randrange(256)
            yield row, column, (x * 256 + column + 0.5) * step, SIDE - (y * 256 + row + 0.5) * step

    def queried(self, store, points):
        told = json.loads(self.ok("query", store, "--json", stdin="".join(f"{x!r} {y!r}\n" for x, y in points)))
        return told["points"]

    def touching(self, z, box):
        step = SIDE / 2 ** z
        return {(x, y) for x in range(int(box[0] // step), int(box[2] // step) + 1)
                for y in range(int((SIDE - box[3]) // step), int((SIDE - box[1]) // step) + 1)}

    def off_query(self, folder, store, z, box, but=(0, 0, 0, 0)):
        """The greatest difference between a zoom level's heights and those that `query` tells, within a box but not in another."""
        points, heights = [], []
        for x, y in sorted(self.touching(z, box)):
            tile = tile_readers.terrain_rgb(folder / f"terrain/{z}/{x}/{y}.png")
            for row, column, east, north in self.middles(z, x, y, 250):
                inside = [low <= at <= high for low, at, high in zip(box, (east, north), box[2:])]
                beside = [low <= at <= high for low, at, high in zip(but, (east, north), but[2:])]
                if all(inside) and not all(beside):
                    points.append((east, north))
                    heights.append(tile[row, column])
        self.assertGreater(len(points), 60)
        return largest(abs(point["height"] - height) for point, height in zip(self.queried(store, points), heights, strict=True))

    def test_insets_are_shown_as_finely_as_they_are(self):
        for tile in (16, 64, 256):
            store = self.imported(tile=tile)
            folder = self.export(store, f"tiles{tile}")
            terrain = self.tiles(folder, "terrain")
            self.assertEqual(set(terrain), set(range(9)))  # pixels of 32 m to 1/8 m
            for z in range(1, 9):
                step = 32 / 2 ** z
                # The site down to its spacing, then the scan alone; with at most a cell of level 0 and a tile of the store around it, or one
                # that shares a post.
                here = SITE if step >= 1 else SCAN
                more = 32 + (tile + 1) * step
                around = (here[0] - more, here[1] - more, here[2] + more, here[3] + more)
                self.assertLessEqual(self.touching(z, here), terrain[z])
                self.assertLessEqual(terrain[z], self.touching(z, around))
            # With pixels as fine as an inset, heights are those that `query` tells, but for the 0.1 m of the format.
            self.assertLess(self.off_query(folder, store, 8, SCAN), 0.0502)
            self.assertLess(self.off_query(folder, store, 5, SITE, but=(SCAN[0] - 9, SCAN[1] - 9, SCAN[2] + 9, SCAN[3] + 9)), 0.0502)
            self.assertGreater(self.off_query(folder, store, 4, SITE), 0.0502)
            # The globe has them too, and its list has what is there.
            meshes, layer = self.tiles(folder, "mesh", ".terrain"), json.loads((folder / "mesh/layer.json").read_text())
            listed = {z: {(x, y) for box in level for x in range(box["startX"], box["endX"] + 1) for y in range(box["startY"], box["endY"] + 1)}
                      for z, level in enumerate(layer["available"])}
            self.assertEqual(listed, meshes)

    def test_ruts_in_insets_and_beside_them(self):
        """Of 4 m: finer than the country, coarser than the site."""
        store = self.imported()
        points = [[1010, 790], [1030, 800], [1600, 1100]]
        self.drive(self.scene(SCENE.format(points=points)), "--store", store)
        colours = ("--height-range", "-3,1")
        folder = self.export(store, "tiles", *colours)
        terrain, ruts = self.tiles(folder, "terrain"), self.tiles(folder, "ruts")
        self.assertEqual(set(ruts), set(range(9)))
        for x, y in points:
            self.assertLessEqual(self.touching(3, (x, y, x, y)), ruts[3])  # pixels of 4 m, as the working level has
        for z in range(9):
            self.assertLessEqual(ruts[z], terrain[z])
            for x, y in ruts[z]:
                index, _ = tile_readers.palette(folder / f"ruts/{z}/{x}/{y}.png")
                if z < 3:
                    for i in range(4):
                        below = folder / f"ruts/{z + 1}/{2 * x + i % 2}/{2 * y + i // 2}.png"
                        quarter = index[i // 2 * 128:i // 2 * 128 + 128, i % 2 * 128:i % 2 * 128 + 128] != 0
                        fine = tile_readers.palette(below)[0] != 0 if below.exists() else False
                        self.assertEqual(quarter.any(), fine is not False and fine.any())
                    continue
                pixels = [pixel for pixel in self.middles(z, x, y) if 0 < pixel[2] < 96 * 32 and 0 < pixel[3] < 80 * 32]
                for pixel, point in zip(pixels, self.queried(store, [pixel[2:] for pixel in pixels]), strict=True):
                    self.assertEqual(index[pixel[0], pixel[1]] != 0, point["offset"] != 0, (z, x, y, pixel))
        # Nothing else changes when a drive comes later.
        self.drive(self.scene(SCENE.format(points=[[1015, 805], [1039, 782]]), "more.yaml"), "--store", store)
        revision = json.loads((folder / "furrow-tiles.json").read_text())["revision"]
        self.export(store, "tiles", "--since", revision, *colours)
        self.export(store, "whole", *colours)
        for path in sorted((self.folder / "whole").rglob("*.*")):
            if path.suffix in (".png", ".terrain"):
                self.assertEqual((folder / path.relative_to(self.folder / "whole")).read_bytes(), path.read_bytes(), path)

    def test_the_list_of_ruts_bounds_those_beside_insets_too(self):
        store, srs = self.imported("EPSG:32632"), "EPSG:32632"
        points = [[1010, 790], [1030, 800], [1600, 1100]]
        self.drive(self.scene(SCENE.format(points=points)), "--store", store)
        west, south, east, north = json.loads((self.export(store) / "ruts.json").read_text())["bounds"]
        sent = "".join(f"{500000 + x} {5000000 + y}\n" for x, y in points)
        for line in rasters.gdal("gdaltransform", "-s_srs", srs, "-t_srs", "EPSG:4326", stdin=sent).splitlines():
            longitude, latitude = map(float, line.split()[:2])
            self.assertTrue(west < longitude < east and south < latitude < north, line)
        self.assertLess(east - west, 0.05)


if __name__ == "__main__":
    main()
