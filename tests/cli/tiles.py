"""furrow export --tiles: heights, ruts and meshes beside GDAL, edges, resuming, what changed, and the page in a browser."""
import functools
import http.server
import json
import pathlib
import re
import shutil
import signal
import subprocess
import threading
import time
import unittest

import furrow_test
import rasters
import tile_readers
from tile_readers import numpy

LEAFLET = pathlib.Path("/usr/share/javascript/leaflet/leaflet.js")
SCENE = """scene: 1
time_step: 0.05
end_time: 3
spacing: 0.25
redistribute: {{model: box}}
objects:
  - {{name: wheel, shape: {{wheel: {{radius: 0.8, width: 0.6}}}}, sink: 0.15, path: {{points: {points}, speed: 60}}}}
"""


def files(folder):
    """{path below the folder: bytes}"""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def tiles_of(folder, name):
    """(z, x, y) of every tile of a set."""
    return sorted(tuple(int(part) for part in path.relative_to(folder / name).with_suffix("").parts)
                  for path in (folder / name).rglob("*") if path.suffix in (".png", ".terrain"))


class Tiles(furrow_test.FurrowTest):
    def setUp(self):
        super().setUp()
        if not LEAFLET.exists():  # any files with these names do, where no browser reads them
            leaflet = self.folder / "leaflet"
            leaflet.mkdir()
            (leaflet / "leaflet.js").write_text("")
            (leaflet / "leaflet.css").write_text("")
        self.leaflet = LEAFLET.parent if LEAFLET.exists() else self.folder / "leaflet"

    def export(self, store, folder, *options):
        self.ok("export", store, "--tiles", folder, "--leaflet", self.leaflet, *options)
        return self.folder / folder

    def dig(self, store, points, name="scene.yaml"):
        self.drive(self.scene(SCENE.format(points=points), name), "--store", store)

    def hills(self, name, srs, west, north, step, width=200, height=140):
        """A store of smooth hills: what interpolation makes of them is known to centimetres."""
        x, y = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
        values = 800 + 60 * numpy.sin(x / 23) * numpy.cos(y / 31) + 0.4 * x
        path = rasters.make(self.folder / f"{name}.tif", width, height, values.ravel().tolist(), west=west, north=north, step=step, srs=srs)
        self.ok("import", path, "-o", f"{name}.furrow", "--tile", 64, "--max-error", 0.001, "--t-srs", srs)
        return self.folder / f"{name}.furrow"

    # --- heights ---

    def warped(self, surface, bounds, size, srs):
        out = self.folder / "warped.tif"
        rasters.gdal("gdalwarp", "-q", "-overwrite", "-t_srs", srs, "-te", *bounds, "-ts", size, size, "-r", "bilinear", "-et", 0,
                     "-ot", "Float64", "-dstnodata", "nan", surface, out)
        width, height, cells = rasters.pixels(out)
        return numpy.array(cells).reshape(height, width)

    def compare_with_gdal(self, srs, west, north, step):
        store = self.hills(srs.replace(":", ""), srs=srs, west=west, north=north, step=step)
        folder = self.export(store, f"tiles{step}")
        surface = self.folder / "surface.tif"
        self.ok("export", store, "-o", surface)
        tiles, meshes = tiles_of(folder, "terrain"), tiles_of(folder, "mesh")
        finest, deepest = tiles[-1][0], meshes[-1][0]
        self.assertGreater(len(tiles), 2)
        worst = 0
        for z, x, y in [tile for tile in tiles if tile[0] == finest][::2]:
            truth = self.warped(surface, tile_readers.mercator_bounds(z, x, y), 256, "EPSG:3857")
            heights = tile_readers.terrain_rgb(folder / f"terrain/{z}/{x}/{y}.png")
            _, shade = tile_readers.palette(folder / f"hillshade/{z}/{x}/{y}.png")
            there = shade[..., 3] > 0
            both = there & numpy.isfinite(truth)
            # GDAL fills half a pixel beyond the outer posts; everything within is there.
            self.assertLess((there & ~numpy.isfinite(truth)).sum(), 3)
            self.assertGreater(both.sum(), 0.9 * numpy.isfinite(truth).sum() - 600)
            if both.any():
                worst = max(worst, abs(heights - truth)[both].max())
        # Half of a step of terrain-RGB, and the store's error.
        self.assertLess(worst, 0.05 + 0.001)
        self.assertGreater(worst, 0.04)  # the rounding of terrain-RGB is there: something was compared
        worst = 0
        for z, x, y in [tile for tile in meshes if tile[0] == deepest][::5]:
            mesh = tile_readers.Mesh((folder / f"mesh/{z}/{x}/{y}.terrain").read_bytes())
            west_, south, east, north_ = tile_readers.tile_degrees(z, x, y)
            half = (east - west_) / 128
            # Of three by three pixels a sample, the middle one: GDAL would smooth posts that are closer than pixels.
            truth = self.warped(surface, (west_ - half, south - half, east + half, north_ + half), 195, "EPSG:4326")[::-1][1::3, 1::3]
            grid = numpy.zeros((65, 65))
            grid[numpy.rint(mesh.v * 64 / 32767).astype(int), numpy.rint(mesh.u * 64 / 32767).astype(int)] = mesh.heights
            inside = numpy.isfinite(truth)
            if inside.any():
                worst = max(worst, abs(grid - truth)[inside].max())
        # Half of the unit of a tile of at most 250 m of relief.
        self.assertLess(worst, 0.0078125 / 2 + 0.001)
        return folder

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_heights_are_those_that_gdal_warps(self):
        for srs, west, north, step in furrow_test.part((("EPSG:32633", 512340, 4649870, 10), ("EPSG:3035", 4321000, 3210000, 25),
                                                        ("EPSG:32759", 480000, 4889000, 2)), 1):
            with self.subTest(srs=srs):
                self.compare_with_gdal(srs, west, north, step)

    # --- meshes ---

    def check_meshes(self, folder, a=6378137.0, f=1 / 298.257223563):
        meshes = {tile: tile_readers.Mesh((folder / "mesh" / "{}/{}/{}.terrain".format(*tile)).read_bytes())
                  for tile in tiles_of(folder, "mesh")}
        shared = normals = 0
        bounds = json.loads((folder / "mesh" / "layer.json").read_text())["bounds"]
        for (z, x, y), mesh in meshes.items():
            self.assertEqual(len(mesh.u), 65 * 65)
            self.assertEqual(len(mesh.triangles), 2 * 64 * 64)
            # Counter-clockwise from above, and the whole square is covered once.
            points = numpy.stack([mesh.u, mesh.v], axis=1)[mesh.triangles]
            one, two = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
            areas = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
            self.assertGreater(areas.min(), 0)
            self.assertEqual(areas.sum(), 2 * 32767 ** 2)
            for edge, (line, value, along) in enumerate(((mesh.u, 0, mesh.v), (mesh.v, 0, mesh.u), (mesh.u, 32767, mesh.v), (mesh.v, 32767, mesh.u))):
                self.assertTrue((line[mesh.edges[edge]] == value).all() and (numpy.diff(along[mesh.edges[edge]]) > 0).all())
                self.assertEqual((line == value).sum(), len(mesh.edges[edge]))
            for other, mine, theirs in (((z, x + 1, y), 2, 0), ((z, x, y + 1), 3, 1)):
                if other in meshes:
                    shared += 1
                    there = meshes[other]
                    numpy.testing.assert_array_equal(mesh.heights[mesh.edges[mine]], there.heights[there.edges[theirs]])
            if z < 6:
                continue
            west, south, east, north = tile_readers.tile_degrees(z, x, y)
            places = tile_readers.earth_centred(west + (east - west) * mesh.u / 32767, south + (north - south) * mesh.v / 32767, mesh.heights, a, f)
            self.assertLess(numpy.linalg.norm(places - mesh.sphere, axis=1).max(), mesh.radius * 1.001 + 0.1)
            self.assertLess(mesh.radius, 1.5 * numpy.ptp(places, axis=0).max() + 1)
            # The occlusion point is above every plane that touches the ellipsoid at the horizon of a vertex: nothing that a vertex sees
            # is hidden from it. In radii of the ellipsoid both are seen from the axis through the centre.
            scaled = places / (a, a, a * (1 - f))
            axis = mesh.centre / (a, a, a * (1 - f))
            axis = axis / numpy.linalg.norm(axis)
            size = numpy.linalg.norm(scaled, axis=1)
            reach = numpy.arccos(numpy.clip(scaled @ axis / size, -1, 1)) + numpy.arccos(1 / numpy.maximum(size, 1))
            self.assertGreaterEqual(numpy.linalg.norm(mesh.horizon) * (1 + 1e-9), 1 / numpy.cos(reach.max()) - 1e-9)
            # Normals, beside those of the triangles around each vertex.
            corners = places[mesh.triangles]
            across = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            sums = numpy.zeros_like(places)
            for corner in range(3):
                numpy.add.at(sums, mesh.triangles[:, corner], across)
            sums /= numpy.linalg.norm(sums, axis=1)[:, None]
            # Within the terrain, since beyond its edges the ground goes on with folds, and within the tile, whose triangles are all around.
            longitude, latitude = west + (east - west) * mesh.u / 32767, south + (north - south) * mesh.v / 32767
            vertex = (east - west) / 64
            known = (longitude > bounds[0] + vertex) & (longitude < bounds[2] - vertex) & (latitude > bounds[1] + vertex) & (latitude < bounds[3] - vertex)
            known &= (mesh.u > 0) & (mesh.u < 32767) & (mesh.v > 0) & (mesh.v < 32767)
            if z == max(meshes)[0] and known.any():
                normals += known.sum()
                self.assertGreater(numpy.quantile((sums * mesh.normals()).sum(axis=1)[known], 0.02), 0.98, (z, x, y))
        self.assertGreater(normals, 1000)
        self.assertGreater(shared, 4)
        return meshes

    def check_layer(self, folder):
        """Against the schema of Cesium's quantized-mesh repository, as far as it says more than types."""
        layer = json.loads((folder / "mesh/layer.json").read_text())
        self.assertEqual((layer["format"], layer["scheme"], layer["projection"]), ("quantized-mesh-1.0", "tms", "EPSG:4326"))
        self.assertEqual(layer["extensions"], ["octvertexnormals"])
        self.assertEqual((layer["minzoom"], layer["maxzoom"]), (0, len(layer["available"]) - 1))
        self.assertEqual(layer["tiles"], ["{z}/{x}/{y}.terrain?v={version}"])
        west, south, east, north = layer["bounds"]
        self.assertTrue(-180 <= west < east <= 180 and -90 <= south < north <= 90)
        listed = [(z, x, y) for z, level in enumerate(layer["available"]) for box in level
                  for x in range(box["startX"], box["endX"] + 1) for y in range(box["startY"], box["endY"] + 1)]
        self.assertEqual(sorted(listed), tiles_of(folder, "mesh"))
        self.assertEqual([tile for tile in listed if tile[0] == 0], [(0, 0, 0), (0, 1, 0)])

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_meshes_keep_to_the_format_and_share_their_edges(self):
        # Relief that differs much from tile to tile, so that their units do.
        x, y = numpy.meshgrid(numpy.arange(260), numpy.arange(200))
        values = 400 + 0.01 * x + numpy.where(x > 130, 6 * (x - 130) * numpy.sin(y / 9), 0)
        path = rasters.make(self.folder / "steps.tif", 260, 200, values.ravel().tolist(), west=300000, north=8000000, step=5, srs="EPSG:32756")
        self.ok("import", path, "-o", "steps.furrow", "--tile", 32)
        folder = self.export("steps.furrow", "tiles")
        meshes = self.check_meshes(folder)
        units = {(mesh.maximum - mesh.minimum) / 32767 for (z, _, _), mesh in meshes.items() if z == max(meshes)[0]}
        self.assertGreater(len(units), 2, "tiles of one unit would share edges anyway")
        self.check_layer(folder)

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_another_body_is_told(self):
        mars = "+proj=eqc +lat_ts=-5 +lon_0=137 +R=3396190 +units=m +no_defs"
        path = rasters.make(self.folder / "mars.tif", 150, 150, [-4400 + i % 7 for i in range(150 * 150)], west=0, north=-300000, step=20, srs=mars)
        self.ok("import", path, "-o", "mars.furrow", "--t-srs", mars)
        result = self.furrow("export", "mars.furrow", "--tiles", "tiles", "--leaflet", self.leaflet)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("not of the Earth", result.stderr)
        self.check_meshes(self.folder / "tiles", 3396190.0, 0)

    # --- local metres ---

    def test_local_metres_have_a_square_of_their_own(self):
        for spacing, posts in ((1, "300x200"), (0.25, "257x257"), (3, "129x400")):
            with self.subTest(spacing=spacing):
                store = self.synth(f"local{spacing}.furrow", posts=posts, spacing=spacing)
                result = self.furrow("export", store, "--tiles", f"tiles{spacing}", "--leaflet", self.leaflet)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertIn("local metres", result.stderr)
                folder = self.folder / f"tiles{spacing}"
                tiles = tiles_of(folder, "terrain")
                z = tiles[-1][0]
                # A pixel's centre is the middle of four posts.
                for _, x, y in [tile for tile in tiles if tile[0] == z]:
                    heights = tile_readers.terrain_rgb(folder / f"terrain/{z}/{x}/{y}.png")
                    side = spacing * 256
                    column, row = 100, 31
                    east, north = x * side + (column + 0.5) * spacing, (2 ** z - y) * side - (row + 0.5) * spacing
                    sample = self.json("query", store, east, north)
                    sample = sample[0] if isinstance(sample, list) else sample
                    if sample["height"] is not None:
                        self.assertAlmostEqual(heights[row, column], sample["height"], delta=0.0501)
                self.check_layer(folder)
                self.check_meshes(folder)

    # --- ruts, and what changed ---

    @furrow_test.long
    def test_a_rut_is_seen_at_every_zoom_level(self):
        store = self.synth(posts="257x257", spacing=1, kind="plain", relief=2)
        self.dig(store, [[20, 20], [120, 90]])
        folder = self.export(store, "tiles", "--height-range", "-0.2,0.1")
        ruts = tiles_of(folder, "ruts")
        self.assertEqual({z for z, _, _ in ruts}, {z for z, _, _ in tiles_of(folder, "terrain")})
        finest = ruts[-1][0]
        offset = self.folder / "offset.tif"
        if furrow_test.has_gdal():
            self.ok("export", store, "-o", offset, "--layer", "offset", "--level", -2)
            _, height, cells = rasters.pixels(offset)
            truth = numpy.array(cells).reshape(height, -1)[::-1]  # rows from the south
            for z, x, y in [tile for tile in ruts if tile[0] == finest]:
                index, colour = tile_readers.palette(folder / f"ruts/{z}/{x}/{y}.png")
                south = (2 ** z - 1 - y) * 256
                posts = truth[south:south + 257, x * 256:x * 256 + 257]
                if posts.shape != (257, 257):
                    continue
                middles = ((posts[1:, 1:] + posts[:-1, 1:] + posts[1:, :-1] + posts[:-1, :-1]) / 4)[::-1]
                share = numpy.where(middles < 0, middles / 0.2, middles / 0.1)
                wanted = 128 + numpy.sign(share) * numpy.ceil(127 * numpy.minimum(abs(share), 1))
                here = middles != 0
                self.assertLessEqual(abs(index.astype(int) - wanted)[here].max(), 1)
                self.assertTrue((index[~here] == 0).all() and (colour[..., 3][index == 0] == 0).all() and (colour[..., 3][index != 0] > 0).all())
        for z, x, y in [tile for tile in ruts if tile[0] < finest]:
            index, _ = tile_readers.palette(folder / f"ruts/{z}/{x}/{y}.png")
            for i in range(4):
                below = folder / f"ruts/{z + 1}/{2 * x + i % 2}/{2 * y + i // 2}.png"
                quarter = index[i // 2 * 128:i // 2 * 128 + 128, i % 2 * 128:i % 2 * 128 + 128]
                fine = tile_readers.palette(below)[0] if below.exists() else numpy.zeros((256, 256), int)
                self.assertTrue(((quarter != 0) == (fine.reshape(128, 2, 128, 2) != 0).any(axis=(1, 3))).all())

    def test_since_writes_exactly_what_changed(self):
        store = self.synth(posts="513x513", spacing=1, relief=20)
        look = ("--height-range", "-0.2,0.2")
        self.dig(store, [[30, 30], [90, 60]])
        folder = self.export(store, "tiles", *look)
        revision = json.loads((folder / "furrow-tiles.json").read_text())["revision"]
        self.assertEqual(revision, self.json("info", store)["last_run"]["epochs"])
        before = files(folder)
        times = {path: (folder / path).stat().st_mtime_ns for path in before}
        # The last one ends just before a tile: only slopes change behind it.
        for points in furrow_test.part(([[350, 400], [420, 380]], [[60, 45], [200, 64]], [[250, 256], [262, 256]], [[230, 100], [255.3, 100]]), 1, 3):
            self.dig(store, points, "more.yaml")
            self.export(store, "tiles", "--since", revision, *look)
            revision = json.loads((folder / "furrow-tiles.json").read_text())["revision"]
            after = files(folder)
            whole = files(self.export(store, "whole", *look))
            self.assertEqual(after.keys(), whole.keys())
            self.assertEqual([path for path in after if after[path] != whole[path]], [])
            written = {path for path in after if (folder / path).stat().st_mtime_ns != times.get(path)}
            self.assertEqual(written, {path for path in after if after[path] != before.get(path)})
            self.assertTrue(any(path.startswith("mesh/") for path in written))
            self.assertLess(len(written), len(after) / 2)
            before, times = after, {path: (folder / path).stat().st_mtime_ns for path in after}
        # What was reset is gone again.
        self.ok("reset", store)
        self.refused(3, "export", store, "--tiles", "tiles", "--leaflet", self.leaflet, "--since", revision)
        after = files(self.export(store, "tiles", *look))
        shutil.rmtree(self.folder / "whole")
        self.assertEqual(after, files(self.export(store, "whole", *look)))
        self.assertEqual(tiles_of(folder, "ruts"), [])

    def test_since_tells_a_reset_after_more_commits_than_before(self):
        look = ("--height-range", "-0.2,0.2")
        store = self.synth(posts="257x257", spacing=1, relief=10)
        self.dig(store, [[60, 45], [64, 45]], "short.yaml")
        self.export(store, "tiles", *look)
        revision = json.loads((self.folder / "tiles/furrow-tiles.json").read_text())["revision"]
        self.ok("reset", store)
        for points in ([[160, 145], [180, 145]], [[60, 145], [80, 145]]):
            self.dig(store, points, "other.yaml")
        self.assertGreater(self.json("info", store)["last_run"]["epochs"], revision)
        said = self.furrow("export", store, "--tiles", "tiles", "--leaflet", self.leaflet, "--since", revision, *look)
        self.assertEqual(said.returncode, 3)
        self.assertIn("its tiles are of another drive: the store was reset since; leave --since out", said.stderr)
        self.export(store, "tiles", *look)
        after, whole = files(self.folder / "tiles"), files(self.export(store, "whole", *look))
        self.assertEqual([path for path in after if after[path] != whole.get(path)], [])
        self.export(store, "tiles", "--since", json.loads(after["furrow-tiles.json"])["revision"], *look)

    # --- kills ---

    @furrow_test.long
    def test_a_killed_export_goes_on_to_the_same_files(self):
        store = self.synth(posts="1025x1025", spacing=1, relief=60)
        self.dig(store, [[300, 300], [380, 360]])
        whole = files(self.export(store, "whole"))
        command = [furrow_test.FURROW, "export", store, "--tiles", "tiles", "--leaflet", self.leaflet]
        folder, kills, notes = self.folder / "tiles", 0, ""
        for number in (signal.SIGKILL, signal.SIGKILL, signal.SIGINT, signal.SIGKILL):
            program = subprocess.Popen(list(map(str, command)), cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            had = len(list((folder / "mesh").rglob("*.terrain"))) if folder.exists() else 0
            while program.poll() is None and len(list(folder.rglob("*.png")) + list(folder.rglob("*.terrain"))) < had + 40:
                time.sleep(0.01)
            program.send_signal(number)
            _, told = program.communicate(timeout=100)
            notes += told
            if program.returncode == 130:
                self.assertRegex(told, "furrow: tiles: interrupted; run it again to go on")
                self.assertEqual([path for path in files(folder) if path.endswith(".part")], [])
            kills += program.returncode != 0
        if kills == 0:
            self.skipTest("it was done before it could be killed")
        self.assertFalse((folder / "furrow-tiles.json").exists() and (folder / "furrow-tiles.journal").exists() and kills == 4)
        self.assertFalse((folder / "furrow-tiles.json").exists() and kills == 4, "no stamp before the end")
        result = self.furrow("export", store, "--tiles", "tiles", "--leaflet", self.leaflet)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("went on", result.stderr + notes)
        after = {path: data for path, data in files(folder).items() if not path.endswith(".part")}
        self.assertEqual(after.keys(), whole.keys())
        self.assertEqual([path for path in after if after[path] != whole[path]], [])

    # --- refusals ---

    def test_refusals(self):
        store = self.synth(posts="65x65")
        other = self.synth("other.furrow", posts="65x65", relief=5)
        tiles = ("export", store, "--tiles", "tiles", "--leaflet", self.leaflet)
        self.refused(2, *tiles, "-o", "out.tif")
        self.refused(2, *tiles, "--layer", "offset")
        self.refused(2, *tiles, "--height-range", "1,2")
        self.refused(2, *tiles, "--since", -1)
        self.refused(3, *tiles, "--since", 0)  # nothing to go on from
        self.assertIn("libjs-leaflet", self.refused(1, "export", store, "--tiles", "tiles", "--leaflet", "nowhere"))
        self.assertFalse((self.folder / "tiles/index.html").exists())
        self.ok(*tiles)
        self.refused(3, *tiles, "--since", 7)  # later than the store
        self.refused(3, "export", other, "--tiles", "tiles", "--leaflet", self.leaflet)
        self.refused(3, *tiles, "--since", 0, "--sun", "90,45")
        (self.folder / "mine").mkdir()
        (self.folder / "mine/letter.txt").write_text("keep")
        self.refused(3, "export", store, "--tiles", "mine", "--leaflet", self.leaflet)
        self.assertEqual([path.name for path in (self.folder / "mine").iterdir()], ["letter.txt"])
        (self.folder / "tiles/furrow-tiles.json").write_text("{}")
        self.refused(3, *tiles)

    # --- the page ---

    def test_the_page_of_ground_without_ruts_has_no_scale_of_them(self):
        browser = shutil.which("chromium") or shutil.which("chromium-browser")
        if browser is None or not LEAFLET.exists():
            self.skipTest("not on this machine: no chromium")
        folder = self.export(self.synth(posts="65x65", spacing=1, relief=30), "tiles")
        told = subprocess.run([browser, "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={self.folder}/profile", "--virtual-time-budget=5000",
                               "--dump-dom", f"file://{folder}/index.html"], capture_output=True, text=True, timeout=200, cwd=self.folder).stdout
        made = re.sub(r"<script.*?</script>", "", told, flags=re.S)
        self.assertIn("no ruts", made)
        self.assertNotIn("ramp", made.split("</style>")[-1])

    def test_the_page_in_a_browser(self):
        browser = shutil.which("chromium") or shutil.which("chromium-browser")
        if browser is None or not LEAFLET.exists():
            self.skipTest("not on this machine: no chromium")
        store = self.synth(posts="257x257", spacing=1, relief=30)
        self.dig(store, [[40, 60], [200, 180]])
        folder = self.export(store, "tiles")
        asked = []

        class Handler(http.server.SimpleHTTPRequestHandler):
            def log_message(self, text, *arguments):
                asked.append(text % arguments)

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        picture = self.folder / "page.png"
        told = subprocess.run([browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={self.folder}/profile",
                               "--window-size=800,600", "--virtual-time-budget=10000", "--dump-dom", f"--screenshot={picture}",
                               f"http://127.0.0.1:{server.server_port}/"], capture_output=True, text=True, timeout=200, cwd=self.folder)
        self.assertIn('data-drawn="yes"', told.stdout, told.stderr)
        self.assertIn("world.furrow", told.stdout)
        self.assertIn("ruts and heaps, metres", re.sub(r"<script.*?</script>", "", told.stdout, flags=re.S))
        for name in ("hillshade", "ruts"):
            self.assertTrue(any(f"/{name}/" in line for line in asked), asked)
        self.assertEqual([line for line in asked if " 404 " in line], [])
        if picture.exists():
            width, height, _, rows, _ = tile_readers.png(picture.read_bytes())
            self.assertEqual((width, height), (800, 600))
            grey = (abs(rows[..., 0].astype(int) - rows[..., 1]) < 3) & (abs(rows[..., 1].astype(int) - rows[..., 2]) < 3)
            self.assertGreater(grey.mean(), 0.15)
            self.assertGreater((~grey & (rows[..., 2] > rows[..., 1].astype(int) + 60)).sum(), 200, "ruts are blue")
            keep = pathlib.Path(furrow_test.os.environ.get("KEEP_PICTURES", "/nonexistent"))
            if keep.is_dir():
                shutil.copy(picture, keep / "tiles-page.png")


if __name__ == "__main__":
    furrow_test.main()
