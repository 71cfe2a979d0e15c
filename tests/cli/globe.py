"""Globe tiles of terrain with holes and edges: no shaft, no wall, and exact ground where there is some."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import numpy

from furrow_test import main
from raster_test import RasterTest
import rasters
import tile_readers


def ground(column, row):
    return 2400 + 250 * math.sin(column / 17) * math.cos(row / 23) + 1.5 * column


def in_hole(column, row):
    return math.hypot(column - 70, row - 60) < 22 or (column, row) == (20, 20)


class Globe(RasterTest):
    def export(self, value, west=686000, north=3100000, srs="EPSG:32645", step=30, width=150, height=120, nodata=-1, folder="tiles"):
        leaflet = self.folder / "leaflet"
        leaflet.mkdir(exist_ok=True)
        for name in ("leaflet.js", "leaflet.css"):
            (leaflet / name).write_text("/* stands for Leaflet */")
        self.make("g.tif", width, height, value, west=west, north=north, srs=srs, step=step, nodata=nodata)
        self.ok("import", "g.tif", "-o", "s.furrow", "--overwrite", "--max-error", 0.001)
        told = self.furrow("export", "s.furrow", "--tiles", folder, "--leaflet", "leaflet")
        self.assertEqual(told.returncode, 0, told.stderr)
        meshes = {}
        for path in (self.folder / folder / "mesh").glob("*/*/*.terrain"):
            mesh = tile_readers.Mesh(path.read_bytes())
            grid = numpy.zeros((65, 65))
            grid[numpy.rint(mesh.v * 64 / 32767).astype(int), numpy.rint(mesh.u * 64 / 32767).astype(int)] = mesh.heights
            meshes[tuple(int(part) for part in (path.parts[-3], path.parts[-2], path.stem))] = (mesh, grid)
        return told.stderr, meshes

    def steps_between(self, meshes, z):
        return max(max(abs(numpy.diff(grid, axis=axis)).max() for axis in (0, 1)) for tile, (_, grid) in meshes.items() if tile[0] == z)

    def test_holes_are_filled_from_their_rims(self):
        told, meshes = self.export(lambda column, row: -1.0 if in_hole(column, row) else ground(column, row))
        self.assertIn("globe tiles fill from their rims", told)
        finest = max(tile[0] for tile in meshes)
        lowest = min(ground(column, row) for column in range(150) for row in range(120))
        highest = max(ground(column, row) for column in range(150) for row in range(120))
        for z in range(finest + 1):
            for tile, (_, grid) in meshes.items():
                if tile[0] == z:
                    self.assertGreater(grid.min(), lowest - 60, tile)
                    self.assertLess(grid.max(), highest + 60, tile)
        # The ground has slopes of up to 25 m a post, and vertices are up to 1.41 posts apart: a step in a hole is no steeper.
        _, whole = self.export(ground, folder="whole")
        self.assertLess(self.steps_between(meshes, finest), 1.5 * self.steps_between(whole, finest))
        # Where there is ground, a hole elsewhere changes nothing but the unit.
        same = 0
        for tile, (mesh, grid) in whole.items():
            unit = max((other.maximum - other.minimum) / 32767 for other, _ in (meshes[tile], whole[tile]))
            if tile[0] == finest:
                off = abs(meshes[tile][1] - grid)
                same += (off <= unit).sum() / off.size
        self.assertGreater(same, 0.7 * sum(tile[0] == finest for tile in whole))

    def test_beyond_the_edge_the_ground_goes_on(self):
        _, meshes = self.export(lambda column, row: 1900.0 + 0.25 * row)
        for tile, (_, grid) in meshes.items():
            self.assertGreaterEqual(grid.min(), 1900 - 5, tile)
            self.assertLessEqual(grid.max(), 1900 + 30 + 5, tile)

    def test_a_terrain_below_zero_makes_no_towers(self):
        _, meshes = self.export(lambda column, row: -1.0 if column > 75 else -4000.0 - column)
        self.assertLess(max(grid.max() for _, grid in meshes.values()), -3900)

    def test_what_terrain_rgb_cannot_hold_is_told(self):
        told, meshes = self.export(lambda column, row: -9000.0 - 20 * column)
        self.assertIn("the lowest ground is at -11980 m", told)
        z, x, y = max(tuple(int(part) for part in (path.parts[-3], path.parts[-2], path.stem)) for path in (self.folder / "tiles" / "terrain").glob("*/*/*.png"))
        heights = tile_readers.terrain_rgb(self.folder / f"tiles/terrain/{z}/{x}/{y}.png")
        self.assertEqual(heights.min(), -10000)
        self.assertLess(min(grid.min() for _, grid in meshes.values()), -11900)

    def test_terrarium_has_steps_of_4_mm(self):
        self.make("g.tif", 150, 120, lambda column, row: 512 + column / 64 + row / 128, west=686000, north=3100000, srs="EPSG:32645", step=30)
        self.ok("import", "g.tif", "-o", "s.furrow", "--max-error", 0)
        for name in ("leaflet.js", "leaflet.css"):
            (self.folder / name).write_text("/* stands for Leaflet */")
        read = {}
        for encoding in ("mapbox", "terrarium"):
            self.ok("export", "s.furrow", "--tiles", encoding, "--leaflet", ".", "--encoding", encoding)
            self.assertIn(f'encoding: "{encoding}"', (self.folder / encoding / "tiles.js").read_text())
            path = max((self.folder / encoding / "terrain").glob("*/*/*.png"))
            red, green, blue = (numpy.array(rasters.pixels(path, "B", band)[2], float) for band in (1, 2, 3))
            code = 65536 * red + 256 * green + blue
            read[encoding] = code / 256 - 32768 if encoding == "terrarium" else code / 10 - 10000
            self.assertEqual(path.parts[-3:], max((self.folder / "mapbox" / "terrain").glob("*/*/*.png")).parts[-3:])
        off = abs(read["mapbox"] - read["terrarium"])
        self.assertLess(off.max(), 0.05 + 1 / 512 + 1e-9)
        self.assertGreater(off.max(), 0.03)
        self.assertGreater(len(set(read["terrarium"])), 10 * len(set(read["mapbox"])))
        self.assertIn("encoding", self.refused(3, "export", "s.furrow", "--tiles", "mapbox", "--leaflet", ".", "--encoding", "terrarium", "--since", 0))

    def test_options_of_tiles_are_for_tiles(self):
        self.make("g.tif", 20, 20, lambda column, row: 5.0)
        self.ok("import", "g.tif", "-o", "s.furrow")
        for option in (("--encoding", "terrarium"), ("--since", 1), ("--jobs", 2), ("--leaflet", ".")):
            self.assertIn("is for --tiles", self.refused(2, "export", "s.furrow", "-o", "o.tif", *option))

    def test_shared_edges_are_equal_in_holes(self):
        _, meshes = self.export(lambda column, row: -1.0 if in_hole(column, row) or column < 10 else ground(column, row))
        shared = 0
        for (z, x, y), (_, grid) in meshes.items():
            if (z, x + 1, y) in meshes:
                numpy.testing.assert_array_equal(grid[:, 64], meshes[z, x + 1, y][1][:, 0])
                shared += 1
            if (z, x, y + 1) in meshes:
                numpy.testing.assert_array_equal(grid[64], meshes[z, x, y + 1][1][0])
                shared += 1
        self.assertGreater(shared, 6)

    def test_headers_have_the_heights_of_their_tile(self):
        _, meshes = self.export(lambda column, row: -1.0 if in_hole(column, row) else ground(column, row))
        for tile, (mesh, grid) in meshes.items():
            self.assertEqual(mesh.minimum, grid.min())
            self.assertGreaterEqual(mesh.maximum, grid.max())
            # Units are powers of two, so that neighbours share edges exactly: the range is at most twice what is there, and some spare.
            self.assertLess(mesh.maximum - mesh.minimum, max(2.2 * (grid.max() - grid.min()), 33), tile)

    def test_the_distance_of_vertices_is_told(self):
        told, _ = self.export(ground)
        self.assertRegex(told, r"vertices [\d.]+ x [\d.]+ m apart, and the store has posts every 30 m")


if __name__ == "__main__":
    main()
