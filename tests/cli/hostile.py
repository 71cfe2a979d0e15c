"""Files of strangers: what they name is not fetched and not opened, what they say moves no cursor, and what lies beside them holds nothing up."""
import gzip
import json
import os
import pathlib
import shutil
import socket
import sqlite3
import subprocess
import threading
import unittest

import furrow_test as ft

ESC = "\x1b]0;owned\x07\x1b[2J\u009b2J\u202e"
ASC = "ncols 10\nnrows 10\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n" + "\n".join(" ".join(str(i + j) for i in range(10)) for j in range(10)) + "\n"
SCENE = """scene: 1
time_step: 0.05
end_time: 0.1
coordinates: "%s"
objects:
  - {name: a, shape: {sphere: {radius: 0.3}}, path: {points: [[500040, 5000040], [500050, 5000050]], speed: 3}, sink: 0.1}
"""


class Listener:
    """A socket of this machine to which nobody may connect."""

    def __init__(self):
        self.socket = socket.socket()
        self.socket.bind(("127.0.0.1", 0))
        self.socket.listen(50)
        self.calls = 0
        threading.Thread(target=self.serve, daemon=True).start()
        self.url = "http://127.0.0.1:%d" % self.socket.getsockname()[1]

    def serve(self):
        while True:
            try:
                connection, _ = self.socket.accept()
            except OSError:
                return
            self.calls += 1
            try:
                connection.recv(4096)
                connection.sendall(b"HTTP/1.0 200 OK\r\nContent-Length: 10\r\n\r\nEPSG:32633")
            except OSError:
                pass
            connection.close()


class Hostile(ft.FurrowTest):
    def setUp(self):
        super().setUp()
        self.listener = Listener()
        self.addCleanup(self.listener.socket.close)
        self.url = self.listener.url
        (self.folder / "a.asc").write_text(ASC)

    def furrow(self, *arguments, **options):
        environment = dict(os.environ, PROJ_NETWORK="ON", NO_PROXY="*", **options.pop("env", {}))
        return subprocess.run([ft.FURROW, *map(str, arguments)], env=environment, cwd=self.folder, capture_output=True, timeout=60, text=True)

    def said(self, path, key, value):
        """Puts a text into a store's header."""
        store = sqlite3.connect(self.folder / path)
        store.execute("UPDATE meta SET value = ? WHERE key = ?", (value, key))
        store.commit()
        store.close()

    def nothing_fetched(self):
        self.assertEqual(self.listener.calls, 0)

    def test_a_listener_notices(self):
        with socket.create_connection(("127.0.0.1", self.listener.socket.getsockname()[1])) as connection:
            connection.sendall(b"x")
        for _ in range(100):
            if self.listener.calls == 1:
                return
            threading.Event().wait(0.02)
        self.fail("it did not")

    @unittest.skipUnless(ft.has_gdal(), "needs GDAL's programs (gdal-bin)")
    def test_the_srs_of_a_store_or_a_scene_leads_nowhere(self):
        self.ok("import", "a.asc", "-o", "base.furrow", "--s-srs", "EPSG:32633")
        srs = sqlite3.connect(self.folder / "base.furrow").execute("SELECT value FROM meta WHERE key = 'srs'").fetchone()[0]
        os.mkfifo(self.folder / "pipe")
        (self.folder / "text.prj").write_text(srs)
        grids = srs.replace("PROJCRS[", "BOUNDCRS[SOURCECRS[PROJCRS[", 1) + (
            ",TARGETCRS[GEOGCRS[\"WGS 84\",DATUM[\"World Geodetic System 1984\",ELLIPSOID[\"WGS 84\",6378137,298.257223563]],CS[ellipsoidal,2],"
            "AXIS[\"lat\",north],AXIS[\"lon\",east],UNIT[\"degree\",0.0174532925199433]]],"
            "ABRIDGEDTRANSFORMATION[\"x\",METHOD[\"NTv2\",ID[\"EPSG\",9615]],PARAMETERFILE[\"Latitude and longitude difference file\",\"%s\"]]]")
        lies = {
            self.url + "/x": "it is an address",
            "https://127.0.0.1/x": "it is an address",
            str(self.folder / "text.prj"): "it is the name of a file",
            "text.prj": "it is the name of a file",
            "pipe": "it is the name of a file",
            "DICT:pipe,1": "it is the name of a file",
            "+proj=utm +zone=33 +nadgrids=" + str(self.folder / "pipe"): "it names a file by a path",
            "+proj=utm +zone=33 +nadgrids=" + self.url + "/x": "it names a file by a path",
            "+init=./pipe:1": "it names a file by a path",
            grids % (self.folder / "pipe"): "it names a file by a path",
            "+proj=utm +zone=33 +geoidgrids=@../pipe": "it names a file by a path",
        }
        commands = [["query", "s.furrow", "13.0", "45.0", "--srs", "degrees"], ["export", "s.furrow", "-o", "x.tif"],
                    ["export", "s.furrow", "--tiles", "tiles"], ["map", "s.furrow", "-o", "x.png"],
                    ["explain", "scene.yaml", "--store", "s.furrow"]]
        known = [command for command in commands if command[0] != "map" or ft.MAPS]
        (self.folder / "scene.yaml").write_text(SCENE % "EPSG:32633")
        shutil.copy(self.folder / "base.furrow", self.folder / "s.furrow")
        for i, (lie, why) in enumerate(lies.items()):
            self.said("s.furrow", "srs", lie)
            for command in known if i in (0, 3, 6) else known[:1]:
                result = self.furrow(*command)
                if command[0] != "map" and "--tiles" not in command:
                    self.assertIn(why, result.stderr, (lie, command))
                    self.assertNotEqual(result.returncode, 0)
        for lie, why in ft.sampled(list(lies.items())[:8]):
            self.scene(SCENE % lie.replace("\\", "\\\\"))
            self.assertIn(why, self.refused(3, "explain", "scene.yaml", "--store", "base.furrow"))
        self.nothing_fetched()

    @unittest.skipUnless(ft.has_gdal(), "needs GDAL's programs (gdal-bin)")
    def test_what_a_source_names_is_not_fetched(self):
        subprocess.run(["gdal_translate", "-q", "-a_srs", "EPSG:32633", "a.asc", "a.tif"], cwd=self.folder, check=True)
        (self.folder / "sub").mkdir()
        shutil.copy(self.folder / "a.tif", self.folder / "sub/b.tif")
        make = ["import", "-o", "o.furrow", "--overwrite", "--dry-run"]

        def refused(why, *sources):
            error = self.refused(3, *make, *sources)
            self.assertIn(why, error)

        def vrt(source, srs="EPSG:32633", more="", relative=0, name="v.vrt"):
            (self.folder / name).write_text(
                f'<VRTDataset rasterXSize="10" rasterYSize="10"><SRS>{srs}</SRS><GeoTransform>500000,10,0,5000100,0,-10</GeoTransform>{more}'
                f'<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="{relative}">{source}</SourceFilename>'
                f'<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>')
            return name

        network, outside = "that is on a network, which is not used; give --allow-network", "that is not in its own folder"
        for name in ("/vsicurl/" + self.url + "/a.tif", self.url + "/a.tif", "/vsicurl_streaming/" + self.url + "/a.tif", "/vsigzip//vsicurl/" + self.url + "/a",
                     "/vsis3/bucket/a.tif"):
            refused(network, name)
        refused("is no name of a file", "vrt://a.tif")
        (self.folder / "wms.tif").write_text(f'<GDAL_WMS><Service name="WMS"><ServerUrl>{self.url}/?</ServerUrl><Layers>a</Layers><SRS>EPSG:4326</SRS></Service>'
                                             '<DataWindow><UpperLeftX>0</UpperLeftX><UpperLeftY>10</UpperLeftY><LowerRightX>10</LowerRightX><LowerRightY>0'
                                             '</LowerRightY><SizeX>10</SizeX><SizeY>10</SizeY></DataWindow><BandsCount>1</BandsCount></GDAL_WMS>')
        refused("with WMS, which uses a network", "wms.tif")
        refused("an address", "a.tif", "--s-srs", self.url + "/x")
        refused("an address", "a.tif", "--t-srs", self.url + "/x")
        (self.folder / "list.txt").write_text("a.tif\n" + self.url + "/b.tif\n")
        refused(network, "@list.txt")
        refused(network, vrt("/vsicurl/" + self.url + "/a.tif"))
        refused(network, vrt("&#47;vsicurl/" + self.url + "/a.tif"))
        refused(network, vrt("a.tif", more=f'<Metadata domain="OVERVIEWS"><MDI key="OVERVIEW_FILE">{self.url}/o</MDI></Metadata>'))
        refused("an address", vrt("a.tif", srs=self.url + "/x"))
        refused("with WMS, which uses a network", vrt("wms.tif"))
        refused(network, vrt(vrt(self.url + "/a.tif", name="in.vrt")))
        refused(outside, vrt("/etc/hostname"))
        (self.folder / "m.mrf").write_text("<MRF_META><CachedSource><Source>%s/x</Source></CachedSource></MRF_META>" % self.url)
        refused(network, "m.mrf")
        (self.folder / "sub/a.kml").write_text("<kml><Document><GroundOverlay><Icon><href>%s/x.png</href></Icon></GroundOverlay></Document></kml>" % self.url)
        self.refused(3, *make, "sub/a.kml")
        refused(outside, vrt("../a.tif", relative=1, name="sub/v.vrt"))
        refused("8 deep", vrt("v.vrt"))
        os.symlink("../a.tif", self.folder / "sub/link.tif")
        refused(outside, vrt("link.tif", relative=1, name="sub/v.vrt"))
        with open(self.folder / "in.vrt.gz", "wb") as file:
            file.write(gzip.compress((self.folder / "in.vrt").read_bytes()))
        refused("is a packed VRT", "in.vrt.gz")
        (self.folder / "sub/b.tif.aux.xml").write_text(f'<PAMDataset><Metadata domain="OVERVIEWS"><MDI key="OVERVIEW_FILE">{self.url}/o</MDI></Metadata></PAMDataset>')
        refused(network, "sub/b.tif")
        (self.folder / "sub/b.tif.aux.xml").write_text(f'<PAMDataset><SRS>{self.url}/x</SRS></PAMDataset>')
        refused("an address", "sub/b.tif")
        (self.folder / "sub/b.tif.aux.xml").unlink()
        subprocess.run(["gdal_translate", "-q", "-a_srs", "+proj=utm +zone=33 +ellps=bessel +nadgrids=/x/grid.gsb +type=crs", "a.asc", "grid.tif"], cwd=self.folder,
                       capture_output=True)
        if (self.folder / "grid.tif").exists():
            refused("it names a file by a path", "grid.tif")
        self.nothing_fetched()
        # What stays within its folder, or is allowed, is read.
        for sources in ([vrt("a.tif")], [vrt("sub/b.tif", relative=1)], [vrt("../a.tif", relative=1, name="sub/v.vrt"), "--vrt-folder", "."],
                        ["a.asc", "--s-srs", "text.prj"]):
            (self.folder / "text.prj").write_text("EPSG:32633")
            self.ok(*make, *sources)
        self.nothing_fetched()
        self.assertIn("cannot be opened as a raster", self.refused(3, *make, "/vsicurl/" + self.url + "/a.tif", "--allow-network"))
        self.assertGreater(self.listener.calls, 0)

    @unittest.skipUnless(ft.has_gdal(), "needs GDAL's programs (gdal-bin)")
    def test_files_of_a_scene_lead_nowhere(self):
        self.ok("import", "a.asc", "-o", "base.furrow", "--s-srs", "EPSG:32633")
        (self.folder / "line.geojson").write_text(json.dumps({
            "type": "FeatureCollection", "crs": {"type": "link", "properties": {"href": self.url + "/x", "type": "proj4"}},
            "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[15.0, 45.15], [15.0001, 45.1501]]}}]}))
        self.scene((SCENE % "store").replace("{points: [[500040, 5000040], [500050, 5000050]], speed: 3}", "{file: line.geojson, speed: 3}"))
        self.furrow("explain", "scene.yaml", "--store", "base.furrow")
        subprocess.run(["gdal_translate", "-q", "-ot", "Byte", "-a_srs", "EPSG:32633", "a.asc", "map.tif"], cwd=self.folder, check=True)
        (self.folder / "map.tif.aux.xml").write_text(f'<PAMDataset><Metadata domain="OVERVIEWS"><MDI key="OVERVIEW_FILE">{self.url}/o</MDI></Metadata></PAMDataset>')
        self.scene(SCENE % "store" + "redistribute: {model: slippage}\nsoil: {map: map.tif, classes: {1: dry_sand}, default: dry_sand}\n")
        self.assertIn("on a network", self.refused(3, "drive", "scene.yaml", "--store", "base.furrow", "-o", "out"))
        self.nothing_fetched()

    def test_text_of_a_store_moves_no_cursor(self):
        self.synth("s.furrow", posts="33x33")
        for key in ("vertical", "sources"):
            self.said("s.furrow", key, "a" + ESC + "b")
        self.said("s.furrow", "srs", ESC + "LOCAL\nverified   all well")
        store = sqlite3.connect(self.folder / "s.furrow")
        store.execute("INSERT INTO snapshot VALUES (?, 0, 0, ?)", ("x", "who" + ESC))
        store.execute("INSERT OR REPLACE INTO run VALUES (1, 1, ?, 1, 1.0, '{}', 0, ?, ?)", ("0" * 32, "w" + ESC, "what\n* 9 faked" + ESC))
        store.commit()
        store.close()
        for command in ("info", "log", "verify"):
            for more in ([], ["--json"]):
                result = self.furrow(command, "s.furrow", *more)
                for text in (result.stdout, result.stderr):
                    for odd in "\x1b\x07\u009b\u202e\x7f":
                        self.assertNotIn(odd, text, (command, more))
                self.assertNotRegex(result.stdout, r"(?m)^(verified|\* 9 faked)")
        info = json.loads(self.furrow("info", "s.furrow", "--json").stdout)
        self.assertEqual(info["vertical"], "a" + ESC + "b")
        name = "x\x1b[2J\u009b\u202e.yaml"
        (self.folder / name).write_text("scene: 1\n\"k\\e[2J\u009b\": 1\n")
        for odd in "\x1b\u009b\u202e":
            self.assertNotIn(odd, self.refused(3, "explain", name))

    def test_pipes_and_links_beside_a_store_hold_nothing_up(self):
        self.synth("s.furrow", posts="33x33")
        scene = self.scene((SCENE % "local").replace("5000040", "10").replace("5000050", "12").replace("500040", "10").replace("500050", "12"))
        for suffix in ("-journal", "-wal", "-shm"):
            for make in (os.mkfifo, lambda path: os.symlink("elsewhere", path)):
                make(self.folder / ("s.furrow" + suffix))
                self.assertIn("is no plain file", self.refused(3, "info", "s.furrow"))
                os.unlink(self.folder / ("s.furrow" + suffix))
        os.symlink("made", self.folder / "s.furrow-lock")
        self.assertIn("it is a link; remove that link", self.refused(1, "drive", scene, "--store", "s.furrow", "-o", "out"))
        self.assertFalse((self.folder / "made").exists())
        for name in ("pipe.tif", "pipe.txt", "pipe.yaml", "pipe.csv", "pipe.furrow", "pipe.png", "pipe.raw"):
            os.mkfifo(self.folder / name)
        for name in ("pipe.tif", "pipe.png", "pipe.raw", "@pipe.txt", "@/dev/zero", "/dev/zero"):
            self.assertIn("not a file", self.refused(3, "import", name, "-o", "o.furrow"))
        self.assertIn("not a file", self.refused(3, "explain", "pipe.yaml"))
        self.assertIn("not a file", self.refused(3, "info", "pipe.furrow"))
        self.assertIn("not a file", self.refused(3, "cache-sim", "pipe.csv"))
        self.assertIn("not a file", self.refused(3, "fit-soil", "pipe.csv"))
        plate = pathlib.Path(__file__).resolve().parents[2] / "examples/soil/plate.csv"
        self.assertIn("pipe.yaml: is a device or a pipe, and would be replaced; give a file", self.refused(1, "fit-soil", plate, "-o", "pipe.yaml"))
        self.assertTrue((self.folder / "pipe.yaml").is_fifo())
        for name in ("epochs.log", "objects.csv"):
            shutil.rmtree(self.folder / "out", ignore_errors=True)
            (self.folder / "out").mkdir()
            (os.mkfifo if name == "epochs.log" else lambda path: os.symlink("../made", path))(self.folder / "out" / name)
            self.furrow("drive", scene, "--store", "s.furrow", "-o", "out")
            self.assertFalse((self.folder / "made").exists())
        (self.folder / "site").mkdir()
        shutil.copy(self.folder / "a.asc", self.folder / "site/a.asc")
        os.mkfifo(self.folder / "site/a.prj")
        if ft.has_gdal():
            self.assertIn("lies beside it and is not a file", self.refused(3, "import", "site", "-o", "o.furrow"))


if __name__ == "__main__":
    ft.main()
