"""Tiles of a window, at the antimeridian too; tiles of 512 pixels, of chosen steps; TileJSON, and vertices as near as posts."""
import gzip
import json
import math
import pathlib
import re
import shlex
import sqlite3
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import numpy

from furrow_test import main
from raster_test import RasterTest
import rasters
import tile_readers

SCENE = """scene: 1
time_step: 0.05
end_time: 2
spacing: 0.46875
redistribute: {model: box}
objects:
  - {name: w, shape: {wheel: {radius: 3, width: 2}}, sink: 0.5, path: {points: [[4000, 2500], [4080, 2540]], speed: 60}}
"""


def ground(column, row):
    return 100 + 50 * math.sin(column / 20) * math.cos(row / 17) + 0.3 * column


class TileWindows(RasterTest):
    def store(self, west=815000, north=8120000, srs="EPSG:32760", step=30, width=300, height=200, value=ground):
        for name in ("leaflet.js", "leaflet.css"):
            (self.folder / name).write_text("/* stands for Leaflet */")
        self.make("g.tif", width, height, value, west=west, north=north, srs=srs, step=step)
        self.ok("import", "g.tif", "-o", "s.furrow", "--max-error", 0.001, "--overwrite")

    def export(self, folder, *options):
        told = self.furrow("export", "s.furrow", "--tiles", folder, "--leaflet", ".", *options)
        self.assertEqual(told.returncode, 0, told.stderr)
        return told.stderr

    def tiles(self, folder, name="terrain"):
        """(z, x, y) of every tile of a set, and those of the finest zoom level."""
        found = sorted(tuple(int(part) for part in path.relative_to(self.folder / folder / name).with_suffix("").parts)
                       for path in (self.folder / folder / name).glob("*/*/*.*"))
        return found, [tile for tile in found if tile[0] == found[-1][0]]

    def pixels(self, folder, tile):
        path = "{}/{}/{}.png".format(*tile)
        return tile_readers.terrain_rgb(self.folder / folder / "terrain" / path), tile_readers.palette(self.folder / folder / "hillshade" / path)[1][..., 3] > 0

    def shown(self, folder):
        """How many pixels of the finest zoom level have ground, and how far heights are from what `query` says."""
        places, heights, count = [], [], 0
        for tile in self.tiles(folder)[1]:
            z, x, y = tile
            read, ground = self.pixels(folder, tile)
            count += int(ground.sum())
            for row in range(5, 256, 40):
                for column in range(5, 256, 40):
                    if ground[row, column]:
                        places.append(f"{(x + (column + 0.5) / 256) / 2 ** z * 360 - 180!r} "
                                      f"{math.degrees(math.atan(math.sinh(math.pi * (1 - 2 * (y + (row + 0.5) / 256) / 2 ** z))))!r}")
                        heights.append(read[row, column])
        said = [place["height"] for place in json.loads(self.ok("query", "s.furrow", "--srs", "degrees", "--json", stdin="\n".join(places)))["points"]]
        self.assertGreater(len(said), 30)
        return count, max(abs(a - b) for a, b in zip(said, heights))

    def test_a_terrain_over_the_antimeridian_is_two_exports_that_the_message_gives(self):
        self.store()
        told = self.refused(3, "export", "s.furrow", "--tiles", "all", "--leaflet", ".")
        self.assertIn("crosses the antimeridian", told)
        self.assertFalse((self.folder / "all/tiles.js").exists())
        windows = re.findall(r"--window-srs degrees --window \S+?(?=,? |$)", told)
        self.assertEqual(len(windows), 2, told)
        count = 0
        for side, window in zip(("east", "west"), windows):
            self.export(side, *shlex.split(window))
            pixels, off = self.shown(side)
            count += pixels
            self.assertLess(off, 0.0502)
            bounds = json.loads((self.folder / side / "mesh/layer.json").read_text())["bounds"]
            self.assertTrue(-180 <= bounds[0] < bounds[2] <= 180 and bounds[2] - bounds[0] < 0.1, bounds)
            self.assertEqual(bounds[2] if side == "east" else bounds[0], 180 if side == "east" else -180)
        z, _, y = self.tiles("west")[1][0]
        north = math.degrees(math.atan(math.sinh(math.pi * (1 - 2 * (y + 0.5) / 2 ** z))))
        pixel = 2 * math.pi * 6378137 / 256 / 2 ** z * math.cos(math.radians(north))
        # Both halves have the whole terrain, and nothing twice: its area, within the pixels of its rim.
        self.assertAlmostEqual(count * pixel ** 2 / (299 * 30 * 199 * 30), 1, delta=0.01)
        # A window in metres that does not cross is exported, one that does is not.
        self.export("metres", "--window", "0,0,3000,3000")
        self.assertIn("crosses the antimeridian", self.refused(3, "export", "s.furrow", "--tiles", "none", "--leaflet", ".", "--window", "0,0,8970,3000"))
        self.assertIn("ends at 180", self.refused(3, "export", "s.furrow", "--tiles", "none", "--leaflet", ".", "--window", "179.9,-18,-179.9,-16", "--window-srs", "degrees"))
        self.assertIn("nothing of the terrain", self.refused(3, "export", "s.furrow", "--tiles", "none", "--leaflet", ".", "--window", "0,0,0,3000"))

    def test_a_window_has_the_tiles_of_the_whole_within_it(self):
        self.store(west=400000)
        self.export("all")
        for window, srs in (((1800, 900, 4500, 3600), ()), ((176.08, -17.03, 176.12, -17.01), ("--window-srs", "degrees"))):
            self.export("part", "--window", ",".join(map(str, window)), *srs)
            tiles, finest = self.tiles("part")
            whole = {tile: self.pixels("all", tile) for tile in self.tiles("all")[0]}
            self.assertLess(len(finest), len([tile for tile in whole if tile[0] == finest[0][0]]) + 1)
            self.assertLess(len(self.tiles("part", "mesh")[0]), len(self.tiles("all", "mesh")[0]))
            least, most = [math.inf, math.inf], [-math.inf, -math.inf]
            for tile in tiles:
                heights, ground = self.pixels("part", tile)
                self.assertTrue((whole[tile][1] | ~ground).all(), tile)
                numpy.testing.assert_array_equal(heights[ground], whole[tile][0][ground])
                if tile in finest:
                    rows, columns = numpy.nonzero(ground)
                    z, x, y = tile
                    for column, row in {(columns.min(), rows.min()), (columns.max(), rows.max())} if len(rows) else ():
                        at = ((x + (column + 0.5) / 256) / 2 ** z * 360 - 180, math.degrees(math.atan(math.sinh(math.pi * (1 - 2 * (y + (row + 0.5) / 256) / 2 ** z)))))
                        least, most = [min(a, b) for a, b in zip(least, at)], [max(a, b) for a, b in zip(most, at)]
            if srs:  # the edges are those meridians and parallels, within a pixel
                pixel = 360 / 256 / 2 ** finest[0][0]
                for got, asked in zip((*least, *most), window):
                    self.assertAlmostEqual(got, asked, delta=pixel)
        self.assertIn("window", self.refused(3, "export", "s.furrow", "--tiles", "part", "--leaflet", ".", "--since", 0))

    def test_chosen_steps_and_512_pixels_are_what_terrain_json_says(self):
        self.store(west=400000)
        self.export("coarse")
        self.export("fine", "--height-step", 0.001, "--tile-size", 512)
        listed = json.loads((self.folder / "fine/terrain.json").read_text())
        self.assertEqual((listed["tilejson"], listed["encoding"], listed["tileSize"]), ("3.0.0", "custom", 512))
        self.assertEqual(json.loads((self.folder / "coarse/terrain.json").read_text())["encoding"], "mapbox")
        tiles, finest = self.tiles("fine")
        self.assertEqual((listed["minzoom"], listed["maxzoom"]), (tiles[0][0], finest[0][0]))
        self.assertEqual(finest[0][0] + 1, self.tiles("coarse")[1][0][0])
        self.assertEqual(listed["bounds"], json.loads((self.folder / "fine/mesh/layer.json").read_text())["bounds"])
        self.assertFalse((self.folder / "fine/ruts.json").exists())
        worst, compared = 0, 0
        for z, x, y in finest:
            url = listed["tiles"][0].split("?")[0].format(z=z, x=x, y=y)
            width, height, _, rows, _ = tile_readers.png((self.folder / "fine" / url).read_bytes())
            self.assertEqual((width, height), (512, 512))
            heights = rows[..., 0] * listed["redFactor"] + rows[..., 1] * listed["greenFactor"] + rows[..., 2] * listed["blueFactor"] - listed["baseShift"]
            for dx in (0, 1):
                for dy in (0, 1):
                    quarter = (z + 1, 2 * x + dx, 2 * y + dy)
                    if not (self.folder / "coarse/terrain/{}/{}/{}.png".format(*quarter)).exists():
                        continue
                    read, ground = self.pixels("coarse", quarter)
                    off = abs(heights[256 * dy:256 * dy + 256, 256 * dx:256 * dx + 256] - read)[ground]
                    worst, compared = max(worst, off.max(initial=0)), compared + ground.sum()
        self.assertGreater(compared, 10000)
        self.assertLess(worst, 0.0506)  # half of the coarse step, and half of the fine one
        self.assertGreater(worst, 0.045)
        self.store(west=400000, width=30, height=30, value=lambda column, row: 100.0 * column)
        least = re.search(r"give at least (\S+)", self.refused(3, "export", "s.furrow", "--tiles", "no", "--leaflet", ".", "--height-step", 0.0001)).group(1)
        self.export("least", "--height-step", least)
        self.assertIn("leave one of both out", self.refused(2, "export", "s.furrow", "--tiles", "no", "--leaflet", ".", "--height-step", 0.001, "--encoding", "mapbox"))
        self.assertIn("tile-size", self.refused(2, "export", "s.furrow", "-o", "a.tif", "--tile-size", 512))

    def test_a_fine_globe_has_vertices_as_near_as_posts(self):
        self.store(west=400000)
        self.assertIn("--fine-globe makes one more level", self.export("usual"))
        self.assertNotIn("fine-globe", self.export("fine", "--fine-globe"))
        self.assertEqual(self.tiles("fine", "mesh")[1][0][0], self.tiles("usual", "mesh")[1][0][0] + 1)

    def test_compressed_globe_tiles_unpack_to_the_same_bytes(self):
        self.store(west=400000, width=100, height=80)
        self.export("plain")
        self.assertIn("Content-Encoding: gzip", self.export("packed", "--gzip"))
        self.assertIn("leave --since", self.refused(3, "export", "s.furrow", "--tiles", "packed", "--leaflet", ".", "--since", 0))
        sizes = [0, 0]
        self.assertEqual(self.tiles("plain", "mesh"), self.tiles("packed", "mesh"))
        for tile in self.tiles("plain", "mesh")[0]:
            plain, packed = ((self.folder / name / "mesh/{}/{}/{}.terrain".format(*tile)).read_bytes() for name in ("plain", "packed"))
            self.assertEqual(gzip.decompress(packed), plain, tile)
            sizes = [sizes[0] + len(plain), sizes[1] + len(packed)]
        self.assertLess(sizes[1], sizes[0] / 4)

    def test_an_update_changes_the_version_in_all_urls(self):
        self.store(west=400000)
        versions = []
        for options in ((), ("--sun", "90,45"), "[4080, 2540]", (), "[4080, 2400]", ()):
            if isinstance(options, str):  # after a reset revisions are the same numbers again
                (self.folder / "scene.yaml").write_text(SCENE.replace("[4080, 2540]", options))
                self.ok("reset", "s.furrow")
                self.ok("drive", "scene.yaml", "--store", "s.furrow", "-o", "out")
                if len(versions) == 3:
                    self.assertIn("was reset since", self.refused(3, "export", "s.furrow", "--tiles", "tiles", "--leaflet", ".", "--since", 2))
                continue
            self.export("tiles", *options)
            lists = {name: (self.folder / "tiles" / f"{name}").read_text() for name in ("tiles.js", "terrain.json", "hillshade.json", "mesh/layer.json")}
            version = json.loads(lists["mesh/layer.json"])["version"]
            self.assertTrue(version.startswith("1.0."))
            for name, text in lists.items():
                self.assertIn(version[4:], text, name)
            versions.append(version)
        self.assertEqual(len(set(versions)), 4, versions)
        self.assertEqual(versions[2].split("-")[0], versions[3].split("-")[0])
        ruts = json.loads((self.folder / "tiles/ruts.json").read_text())
        self.assertIn(versions[-1][4:], ruts["tiles"][0])
        # Every tile of ruts lies in the bounds of its list, which are much smaller than the terrain's.
        west, south, east, north = ruts["bounds"]
        whole = json.loads((self.folder / "tiles/terrain.json").read_text())["bounds"]
        self.assertLess((east - west) * (north - south), 0.1 * (whole[2] - whole[0]) * (whole[3] - whole[1]))
        for z, x, y in self.tiles("tiles", "ruts")[0]:
            left, below, right, above = tile_readers.mercator_bounds(z, x, y)
            degrees = [math.degrees(value / 6378137) for value in (left, right)]
            self.assertTrue(degrees[0] < east and degrees[1] > west, (z, x, y))

    def test_mbtiles_of_heights_tell_of_holes_and_of_what_lies_too_deep(self):
        self.store(west=400000, value=lambda column, row: -11000 if column > 200 else math.nan if row > 150 else 100)
        told = {layer: self.furrow("export", "s.furrow", "-o", "a.mbtiles", "--layer", layer) for layer in ("surface", "hillshade")}
        for part in ("the lowest ground is at -11000 m", "the terrain has holes"):
            self.assertEqual([part in told[layer].stderr for layer in ("surface", "hillshade")], [True, False], told)

    def test_mbtiles_have_the_tiles_of_the_folder_and_gdal_opens_them(self):
        self.store(west=400000)
        (self.folder / "scene.yaml").write_text(SCENE)
        self.ok("drive", "scene.yaml", "--store", "s.furrow", "--overlay", "Spuren für später.furrow", "-o", "out")
        store = "Spuren für später.furrow"
        self.ok("export", store, "--tiles", "tiles", "--leaflet", ".", "--tile-size", 256)
        self.export("whole")  # of the store without ruts
        for layer, name in (("surface", "terrain"), ("hillshade", "hillshade"), ("offset", "ruts")):
            out = self.folder / f"{name} 1.mbtiles"
            told = self.furrow("export", store, "-o", out, "--layer", layer)
            self.assertEqual(told.returncode, 0, told.stderr)
            with sqlite3.connect(out) as database:
                rows = {(z, x, 2 ** z - 1 - y): data for z, x, y, data in database.execute("SELECT * FROM tiles")}
                said = dict(database.execute("SELECT name, value FROM metadata"))
                self.assertEqual(database.execute("PRAGMA integrity_check").fetchone()[0], "ok")
            database.close()
            there = {tile: (self.folder / "tiles" / name / "{}/{}/{}.png".format(*tile)).read_bytes() for tile in self.tiles("tiles", name)[0]}
            if name != "ruts":  # without the zoom levels that have tiles around ruts alone
                self.assertIn("finer than its zoom levels", told.stderr)
                finest = max(z for z, _, _ in rows)
                self.assertEqual(finest, self.tiles("whole")[1][0][0])
                there = {tile: data for tile, data in there.items() if tile[0] <= finest}
            self.assertEqual(rows.keys(), there.keys())
            self.assertEqual([tile for tile in rows if rows[tile] != there[tile]], [])
            listed = json.loads((self.folder / f"tiles/{name}.json").read_text())
            self.assertEqual((int(said["minzoom"]), int(said["maxzoom"]), said["format"]), (listed["minzoom"], max(z for z, _, _ in rows), "png"))
            self.assertEqual(said.get("encoding"), "mapbox" if name == "terrain" else None)
            read = rasters.gdalinfo(out)
            self.assertEqual(read["driverShortName"], "MBTiles")
            self.assertIn("Pseudo-Mercator", read["coordinateSystem"]["wkt"])
        self.assertEqual(list(self.folder.glob("*.part")), [])
        self.assertIn("no ruts", self.refused(3, "export", "s.furrow", "-o", "no.mbtiles", "--layer", "offset"))
        self.assertFalse((self.folder / "no.mbtiles").exists())
        self.assertIn("local metres", self.refused(3, "export", self.synth("local.furrow", posts="65x65"), "-o", "no.mbtiles"))
        self.assertIn("no globe", self.refused(2, "export", "s.furrow", "-o", "no.mbtiles", "--fine-globe"))
        self.assertIn("no mesh", self.refused(2, "export", "s.furrow", "--mesh", "m.glb", "-o", "no.mbtiles"))
        self.assertIn("no mesh", self.refused(2, "export", "s.furrow", "--up", "z", "-o", "no.mbtiles"))
        for option, layers in ((("--height-range", "-1,1"), ("surface", "hillshade", "imagery")), (("--sun", "90,30"), ("surface", "offset", "imagery")),
                               (("--exaggerate", 2), ("surface", "offset")), (("--encoding", "terrarium"), ("offset", "hillshade")), (("--height-step", 1), ("hillshade",))):
            for layer in layers:
                self.refused(2, "export", "s.furrow", "-o", "no.mbtiles", "--layer", layer, *option)
        self.assertIn("holds surface", self.refused(2, "export", "s.furrow", "-o", "no.mbtiles", "--layer", "shear"))
        self.assertIn("pmtiles convert", self.refused(2, "export", "s.furrow", "-o", "no.pmtiles"))
        self.refused(3, "export", "s.furrow", "-o", "nowhere/a.mbtiles")


if __name__ == "__main__":
    main()
