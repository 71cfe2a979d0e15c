"""Exports in QGIS, by its own Python: what has no data is none, rasters lie in their place, and names have spaces and umlauts."""
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import long, main
from raster_test import RasterTest

READER = """
import json, sys
from qgis.core import QgsApplication, QgsMapRendererSequentialJob, QgsMapSettings, QgsRasterLayer
from qgis.PyQt.QtCore import QSize
from qgis.PyQt.QtGui import QColor
application = QgsApplication([], False)
application.initQgis()
told = {}
for path in sys.argv[1:]:
    layer = QgsRasterLayer(path, "layer")
    assert layer.isValid(), (path, layer.error().summary())
    extent, provider = layer.extent(), layer.dataProvider()
    block = provider.block(1, extent, layer.width(), layer.height())
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setDestinationCrs(layer.crs())
    settings.setExtent(extent)
    settings.setOutputSize(QSize(layer.width(), layer.height()))
    settings.setBackgroundColor(QColor(255, 0, 255))
    job = QgsMapRendererSequentialJob(settings)
    job.start()
    job.waitForFinished()
    image = job.renderedImage()
    told[path] = {
        "values": [[None if block.isNoData(row, column) else block.value(row, column) for column in range(block.width())] for row in range(block.height())],
        "background": sum(image.pixelColor(x, y).getRgb()[:3] == (255, 0, 255) for x in range(image.width()) for y in range(image.height())),
        "crs": layer.crs().authid(),
        "extent": [extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()],
    }
print("TOLD", json.dumps(told))
"""
SCENE = """scene: 1
time_step: 0.05
end_time: 1
redistribute: {model: box}
objects:
  - {name: w, shape: {wheel: {radius: 12, width: 12}}, sink: 2, path: {points: [[200, 100], [240, 100]], speed: 60}}
"""
WIDTH, HEIGHT, STEP, WEST, NORTH = 60, 50, 10, 500000, 5000000


def hole(column, row):
    return (column - 20) ** 2 + (row - 15) ** 2 < 60 or column == 59


@long
class Gis(RasterTest):
    def read(self, *paths):
        """What QGIS says of each file."""
        if subprocess.run([sys.executable, "-c", "import qgis.core"], capture_output=True).returncode != 0:
            self.skipTest("not on this machine: no PyQGIS (python3-qgis)")
        told = subprocess.run([sys.executable, "-c", READER, *map(str, paths)], capture_output=True, text=True, cwd=self.folder, timeout=250,
                              env=dict(os.environ, QT_QPA_PLATFORM="offscreen", HOME=str(self.folder), XDG_RUNTIME_DIR=str(self.folder)))
        self.assertIn("TOLD ", told.stdout, told.stderr)
        return json.loads(told.stdout.split("TOLD ")[1])

    def test_holes_are_no_data_in_every_raster_and_ground_is_where_it_was(self):
        self.make("g.tif", WIDTH, HEIGHT, lambda column, row: -1.0 if hole(column, row) else 300.0 + 3 * column + row, west=WEST, north=NORTH, step=STEP, nodata=-1)
        store = "Höhe über NN.furrow"
        self.ok("import", "g.tif", "-o", store, "--max-error", 0)
        self.scene(SCENE)
        self.ok("drive", "scene.yaml", "--store", store, "--overlay", "Spur ü.furrow", "-o", "out")
        holes = {(column, row) for column in range(WIDTH) for row in range(HEIGHT) if hole(column, row)}
        paths = {"heights": "Höhen 1.png", "raster": "Höhen 1.tif", "shade": "Schummerung 1.png", "ruts": "Spuren.tif", "window": "Ausschnitt.tif", "post": "ein Post.tif"}
        self.ok("export", store, "-o", paths["heights"])
        self.ok("export", store, "-o", paths["raster"])
        self.ok("export", store, "-o", paths["shade"], "--layer", "hillshade")
        self.ok("export", "Spur ü.furrow", "-o", paths["ruts"], "--layer", "offset", "--level", 0)
        self.ok("export", store, "-o", paths["window"], "--window", "100,200,400,400")
        self.ok("export", store, "-o", paths["post"], "--window", "300,100,300,100")
        read = self.read(*paths.values())
        for name in ("heights", "raster", "shade", "ruts"):
            told = read[paths[name]]
            self.assertEqual(told["crs"], "EPSG:32633", name)
            self.assertEqual({(column, row) for row, line in enumerate(told["values"]) for column, value in enumerate(line) if value is None}, holes, name)
            self.assertEqual(told["background"], len(holes), name)
            for got, asked in zip(told["extent"], (WEST, NORTH - HEIGHT * STEP, WEST + WIDTH * STEP, NORTH)):
                self.assertAlmostEqual(got, asked, delta=1e-6)
        for name in ("heights", "raster"):
            for column, row in ((0, 0), (40, 30), (58, 49)):
                self.assertEqual(read[paths[name]]["values"][row][column], 300 + 3 * column + row)
        ruts = [value for line in read[paths["ruts"]]["values"] for value in line if value is not None]
        self.assertLess(min(ruts), -0.5)
        window = read[paths["window"]]
        self.assertEqual((len(window["values"][0]), len(window["values"])), (31, 21))
        self.assertEqual(window["extent"], [WEST + 100, NORTH - HEIGHT * STEP + 200, WEST + 410, NORTH - HEIGHT * STEP + 410])
        self.assertEqual(window["values"][20][0], 300 + 3 * 10 + 29)  # 100 m east, 200 m north: column 10, row 49 - 20
        self.assertEqual(read[paths["post"]]["values"], [[300 + 3 * 30 + 39]])

    def test_one_file_of_tiles_shows_ground_and_leaves_holes_out(self):
        self.make("g.tif", WIDTH, HEIGHT, lambda column, row: -1.0 if hole(column, row) else 300.0 + 3 * column + row, west=WEST, north=NORTH, step=STEP, nodata=-1)
        self.ok("import", "g.tif", "-o", "s.furrow", "--max-error", 0)
        self.scene(SCENE)
        self.ok("drive", "scene.yaml", "--store", "s.furrow", "--overlay", "o.furrow", "-o", "out", "--set", "spacing=0.625")
        self.ok("export", "o.furrow", "-o", "Schatten 1.mbtiles", "--layer", "hillshade")
        told = self.read("Schatten 1.mbtiles")["Schatten 1.mbtiles"]
        self.assertEqual(told["crs"], "EPSG:3857")
        pixels = len(told["values"]) * len(told["values"][0])
        share = sum(hole(column, row) for column in range(WIDTH) for row in range(HEIGHT)) / (WIDTH * HEIGHT)
        self.assertAlmostEqual(told["background"] / pixels, share, delta=0.1)  # the rest is the rim: the map is turned against the store


if __name__ == "__main__":
    main()
