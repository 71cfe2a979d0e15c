"""The exports in the programs that they are for: CesiumJS, MapLibre GL JS and the page, each in a headless Chromium. Their code is that of EXCHANGE.md."""
import json
import math
import os
import pathlib
import random
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import numpy

import browser
from furrow_test import long, main
from raster_test import RasterTest
import tile_readers

LEAFLET = pathlib.Path("/usr/share/javascript/leaflet/leaflet.js")
PAGE = pathlib.Path(__file__).parents[2] / "src/exchange/EXCHANGE.md"
SCENE = """scene: 1
time_step: 0.05
end_time: 4
spacing: 0.46875
redistribute: {model: box}
objects:
  - {name: wheel, shape: {wheel: {radius: 3.2, width: 2.4}}, sink: 0.6, path: {points: [[3000, 600], [3200, 700]], speed: 60}}
"""
CESIUM = """<!DOCTYPE html><html><head><meta charset="utf-8"><script>window.CESIUM_BASE_URL = "/client/cesium/Build/Cesium/";</script>
<script src="/client/cesium/Build/Cesium/Cesium.js"></script><link rel="stylesheet" href="/client/cesium/Build/Cesium/Widgets/widgets.css"><style>html, body, #map {margin: 0; width: 100%; height: 100%}</style></head>
<body><div id="map"></div><script>
const Real = Cesium.Viewer; // the recipe's viewer, with a canvas that can be read, and nothing that asks other hosts
Cesium.Viewer = function (id, options) {
  return new Real(id, {...options, baseLayer: false, baseLayerPicker: false, geocoder: false, animation: false, timeline: false,
                       skyBox: false, skyAtmosphere: false, contextOptions: {webgl: {preserveDrawingBuffer: true}}});
};
ELLIPSOID
(async () => {
RECIPE
  const places = PLACES.map(([x, y]) => Cesium.Cartographic.fromDegrees(x, y));
  await Cesium.sampleTerrainMostDetailed(terrain, places);
  const view = VIEW;
  viewer.camera.setView({destination: Cesium.Cartesian3.fromDegrees(...view.from), orientation: {heading: 0, pitch: Cesium.Math.toRadians(view.pitch), roll: 0}});
  const begun = Date.now();
  let quiet = 0; // frames, however long one takes
  await new Promise(done => viewer.scene.postRender.addEventListener(() => {
    quiet = viewer.scene.globe.tilesLoaded ? quiet + 1 : 0;
    if (quiet > 15 || Date.now() - begun > 250000)
      done();
  }));
  await tell({heights: places.map(place => place.height)}, viewer.scene.canvas);
})();
</script></body></html>"""
MAPLIBRE = """<!DOCTYPE html><html><head><meta charset="utf-8"><style>html, body, #map {margin: 0; width: 100%; height: 100%}</style></head>
<body><div id="map"></div><script type="module">
import * as maplibregl from "/client/maplibre-gl/dist/maplibre-gl.mjs";
const map = new maplibregl.Map({container: "map", center: CENTRE, zoom: ZOOM, fadeDuration: 0, attributionControl: false,
  canvasContextAttributes: {preserveDrawingBuffer: true}, style: {version: 8, sources: {}, layers: [{id: "sky", type: "background", paint: {"background-color": "#d6dbe2"}}]}});
const errors = [];
map.on("error", event => errors.push(String(event.error && event.error.message)));
await map.once("load");
RECIPE
map.setTerrain({source: "relief"});
await Promise.race([map.once("idle"), new Promise(done => setTimeout(done, 60000))]);
const heights = [];
for (const place of PLACES)
  heights.push(map.queryTerrainElevation(place));
await tell({errors, heights, loaded: map.areTilesLoaded()}, map.getCanvas());
</script></body></html>"""
POINTER = """<script>
(async () => {
  while (document.body.dataset.drawn !== "yes")
    await new Promise(done => setTimeout(done, 50));
  const told = [], box = map.getContainer().getBoundingClientRect();
  for (const [lng, lat] of PLACES) {
    map.setView([lat, lng], map.getZoom(), {animate: false});
    const at = map.latLngToContainerPoint([lat, lng]).round(), mouse = {clientX: box.left + at.x, clientY: box.top + at.y};
    const where = map.mouseEventToLatLng(mouse);
    map.getContainer().dispatchEvent(new PointerEvent(told.length % 2 ? "pointerdown" : "pointermove", {...mouse, isPrimary: true,
      pointerType: told.length % 2 ? "touch" : "mouse", bubbles: true}));
    while (document.getElementById("where").dataset.shown !== String(asked))
      await new Promise(done => setTimeout(done, 5));
    told.push({place: [where.lng, where.lat], text: document.getElementById("where").textContent});
  }
  await tell(told);
})();
</script></body>"""


def ground(column, row):
    return 2400 + 250 * math.sin(column / 17) * math.cos(row / 23) + 1.5 * column


def in_hole(column, row):
    return math.hypot(column - 70, row - 60) < 22 or (column, row) == (20, 20)


def recipe(heading):
    """The code of a section of EXCHANGE.md: its indented lines."""
    parts = re.split(r"\n##+ ", PAGE.read_text())
    part = next(part for part in parts if part.startswith(heading + "\n"))
    return "\n".join(line for line in part.splitlines() if line.startswith("    ") and not line.startswith("    location"))  # nginx's


@long
class Clients(RasterTest):
    def setUp(self):
        super().setUp()
        browser.program()
        if not LEAFLET.exists():
            self.skipTest("not on this machine: no libjs-leaflet")

    def store(self, name="Höhen über NN.furrow", srs="EPSG:32645", value=None, west=686000, north=3100000):
        """A store of 4.5 x 3.6 km with holes, and an overlay with a rut."""
        self.make("g.tif", 150, 120, value or (lambda column, row: -1.0 if in_hole(column, row) else ground(column, row)), west=west, north=north, srs=srs, step=30,
                  nodata=-1)
        self.ok("import", "g.tif", "-o", name, "--max-error", 0.001, "--t-srs", srs)
        (self.folder / "scene.yaml").write_text(SCENE)
        self.ok("drive", "scene.yaml", "--store", name, "--overlay", "Spuren 1.furrow", "-o", "out")
        return "Spuren 1.furrow"

    def serve(self, store, *options):
        self.ok("export", store, "--tiles", "tiles", *options)
        server = browser.Server(self.folder / "tiles")
        self.addCleanup(server.close)
        return server

    def picture(self, name):
        """The path of a picture that a page told; kept where KEEP_PICTURES says."""
        keep = pathlib.Path(os.environ.get("KEEP_PICTURES", "/nonexistent"))
        return keep / name if keep.is_dir() else self.folder / name

    def query(self, store, places, *srs):
        told = json.loads(self.ok("query", store, *(srs or ("--srs", "degrees")), "--json", stdin="\n".join(f"{x!r} {y!r}" for x, y in places)))
        return told["points"]

    def places(self, count):
        """Places all over the terrain, and some beside it."""
        chance = random.Random(7)
        west, south, east, north = json.loads((self.folder / "tiles/mesh/layer.json").read_text())["bounds"]
        return [(chance.uniform(west, east), chance.uniform(south, north)) for _ in range(count)]

    # --- Cesium ---

    def cesium(self, server, places, view, name, ellipsoid=""):
        browser.client("cesium")
        page = CESIUM.replace("ELLIPSOID", ellipsoid).replace("RECIPE", recipe("Cesium").replace("http://localhost:8000", server.address))
        page = page.replace("PLACES", json.dumps(places)).replace("VIEW", json.dumps(view))
        return server.run(page, self.folder / "profile", picture=self.picture(name), seconds=290, size=(600, 500))["heights"]

    def test_cesium_has_the_heights_of_query_fills_holes_and_shows_the_ruts(self):
        store = self.store()
        server = self.serve(store, "--fine-globe")
        places = self.places(300)
        west, south, east, north = json.loads((self.folder / "tiles/mesh/layer.json").read_text())["bounds"]
        view = {"from": [(west + east) / 2, south - 0.03, 5000], "pitch": -35}
        heights = self.cesium(server, places, view, "cesium.png")
        off, holes = [], []
        for place, height in zip(self.query(store, places), heights):
            self.assertIsNotNone(height)
            if place["height"] is None:
                holes.append(height)
            else:
                off.append(abs(place["height"] - height))
        self.assertGreater(len(off), 200)
        self.assertGreater(len(holes), 15)
        self.assertLess(numpy.median(off), 0.03)
        self.assertLess(numpy.quantile(off, 0.95), 0.25)
        self.assertLess(max(off), 4)  # of slopes up to 50 %, beside a hole's rim
        self.assertTrue(2100 < min(holes) and max(holes) < 2900, holes)
        # Nothing of the globe is asked for in vain; of pictures only tiles of the zoom levels that are there around ruts alone.
        missing = server.missing()
        self.assertEqual([line for line in missing if "/mesh/" in line], [])
        self.assertLess(len(missing), len(server.asked) / 2)
        shown = tile_readers.png(self.picture("cesium.png").read_bytes())[3].astype(int)
        grey = (abs(shown[..., 0] - shown[..., 1]) < 4) & (abs(shown[..., 1] - shown[..., 2]) < 4) & (shown[..., 0] > 20)
        self.assertGreater(grey.mean(), 0.1, "the hillshade lies on the globe")
        blue = (shown[..., 2] > shown[..., 1] + 25) & (shown[..., 1] > 40)
        self.assertGreater(blue.sum(), 30, "and the rut")

    def test_cesium_has_the_heights_of_mars_on_its_ellipsoid(self):
        mars = "+proj=eqc +lat_ts=-5 +lon_0=137 +R=3396190 +units=m +no_defs"
        store = self.store("Mars.furrow", mars, lambda column, row: -1.0 if in_hole(column, row) else ground(column, row) - 7000, west=0, north=-300000)
        told = self.furrow("export", store, "--tiles", "tiles")
        self.assertIn("a body of 3396190 m radius", told.stderr)
        server = self.serve(store)
        places = self.places(200)
        west, south, east, north = json.loads((self.folder / "tiles/mesh/layer.json").read_text())["bounds"]
        view = {"from": [(west + east) / 2, south - 0.06, -1500], "pitch": -35}
        heights = self.cesium(server, places, view, "cesium-mars.png", "Cesium.Ellipsoid.default = new Cesium.Ellipsoid(3396190, 3396190, 3396190);")
        known = self.query(store, places)
        off = [abs(place["height"] - height) for place, height in zip(known, heights) if place["height"] is not None]
        self.assertGreater(len(off), 130)
        self.assertLess(numpy.median(off), 0.2)
        self.assertLess(max(off), 6)
        self.assertTrue(-5000 < min(heights) and max(heights) < -4000, "no towers in holes")

    def test_cesium_unpacks_compressed_tiles(self):
        store = self.store()
        server = self.serve(store, "--gzip")
        places = self.places(100)
        west, south, east, north = json.loads((self.folder / "tiles/mesh/layer.json").read_text())["bounds"]
        heights = self.cesium(server, places, {"from": [(west + east) / 2, south - 0.03, 5000], "pitch": -35}, "cesium-gzip.png", recipe("Compressed globe tiles"))
        off = [abs(place["height"] - height) for place, height in zip(self.query(store, places), heights) if place["height"] is not None]
        self.assertGreater(len(off), 60)
        self.assertLess(numpy.median(off), 0.2)
        self.assertLess(max(off), 6)

    # --- MapLibre ---

    def maplibre(self, server, centre, zoom, places, name):
        browser.client("maplibre-gl")
        page = MAPLIBRE.replace("RECIPE", recipe("MapLibre and Leaflet").replace("http://localhost:8000", server.address))
        page = page.replace("CENTRE", json.dumps(centre)).replace("ZOOM", str(zoom)).replace("PLACES", json.dumps(places))
        told = server.run(page, self.folder / "profile", picture=self.picture(name), seconds=200)
        self.assertEqual(told["errors"], [])
        self.assertTrue(told["loaded"])
        return told["heights"]

    def test_maplibre_reads_each_encoding_and_shades_the_ruts(self):
        store = self.store()
        seen = {}
        for name, options in (("mapbox", ()), ("terrarium", ("--encoding", "terrarium")), ("custom", ("--height-step", 0.001, "--tile-size", 512))):
            shutil.rmtree(self.folder / "tiles", ignore_errors=True)
            server = self.serve(store, *options)
            bounds = json.loads((self.folder / "tiles/ruts.json").read_text())["bounds"]
            centre = [(bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2]
            places = [[centre[0] + 0.0003 * i, centre[1] + 0.0002 * k] for i in range(-3, 4) for k in range(-3, 4)]
            heights = self.maplibre(server, centre, 16.5, places, f"maplibre-{name}.png")
            off = [abs(height - place["height"]) for height, place in zip(heights, self.query(store, places)) if abs(place["offset"]) < 0.01]
            self.assertGreater(len(off), 30)
            self.assertLess(numpy.median(off), 0.5, name)
            self.assertLess(max(off), 3, name)
            seen[name] = tile_readers.png(self.picture(f"maplibre-{name}.png").read_bytes())[3].astype(int)
            blue = (seen[name][..., 2] > seen[name][..., 1] + 60).sum()
            self.assertGreater(blue, 200, "ruts are blue")
            server.close()

    # --- the page ---

    def test_the_page_tells_height_offset_and_place_under_pointer_and_finger(self):
        store = self.store()
        for options in (("--tile-size", 512, "--height-step", 0.001), ()):
            shutil.rmtree(self.folder / "tiles", ignore_errors=True)
            server = self.serve(store, *options)
            ruts = json.loads((self.folder / "tiles/ruts.json").read_text())["bounds"]
            places = self.places(60) + [((ruts[0] + ruts[2]) / 2 + 1e-5 * i, (ruts[1] + ruts[3]) / 2 + 1e-5 * k) for i in range(-2, 3) for k in range(-2, 3)]
            told = server.run((self.folder / "tiles/index.html").read_text().replace("</body>", POINTER.replace("PLACES", json.dumps(places))), self.folder / "profile",
                              path="/index.html")
            known = self.query(store, [entry["place"] for entry in told])
            origin = self.json("info", store)["origin"]
            off, offsets = [], 0
            for entry, place in zip(told, known):
                text = entry["text"]
                self.assertIn("WGS 84 / UTM zone 45N", text)
                east, north = map(float, re.search(r"^(-?[\d.]+), (-?[\d.]+) m", text, re.M).groups())
                self.assertAlmostEqual(east - origin[0], place["local"][0], delta=0.02)
                self.assertAlmostEqual(north - origin[1], place["local"][1], delta=0.02)
                height = re.search(r"^height (\S+) m", text, re.M)
                if height is None or place["height"] is None:  # at a rim, half a pixel decides
                    self.assertTrue(place["height"] is None or "no data" in text, text)
                    continue
                off.append(abs(float(height.group(1)) - place["height"]))
                offset = re.search(r"^offset (\S+) m", text, re.M)
                if place["offset"] < -0.3 and offset:
                    offsets += 1
                    self.assertAlmostEqual(float(offset.group(1)), place["offset"], delta=0.15)
            self.assertGreater(len(off), 50)
            self.assertLess(numpy.median(off), 0.1)
            self.assertLess(max(off), 3)
            self.assertEqual(server.missing(), [])
            server.close()


if __name__ == "__main__":
    main()
