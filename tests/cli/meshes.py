"""furrow export --mesh: OBJ, glb and STL, by readers made from the formats alone."""
import json
import pathlib
import struct
import unittest

import furrow_test
import rasters
import tile_readers  # noqa: F401: brings numpy
from tile_readers import numpy


def read_glb(path):
    """JSON, positions, normals, triangles, places in the picture, picture; y up as in the file. Everything that glTF 2.0 asks of such a file is checked."""
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    root = json.loads(data[20:20 + size])
    body_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    body = data[28 + size:]
    assert kind == b"BIN\0" and body_size == len(body) and len(body) % 4 == 0
    assert root["asset"]["version"] == "2.0" and root["buffers"] == [{"byteLength": len(body)}]

    def accessor(number, channels, code, kind, target):
        part = root["accessors"][number]
        view = root["bufferViews"][part["bufferView"]]
        assert part["type"] == kind and view["target"] == target
        item = 4 * channels
        stride = view.get("byteStride", item)
        start = view.get("byteOffset", 0) + part.get("byteOffset", 0)
        assert start % 4 == 0 and stride % 4 == 0 and part["count"] > 0
        assert part.get("byteOffset", 0) + stride * (part["count"] - 1) + item <= view["byteLength"]
        assert view.get("byteOffset", 0) + view["byteLength"] <= len(body)
        rows = numpy.ndarray((part["count"], channels), code, body, start, (stride, 4))
        return part, rows

    (primitive,) = root["meshes"][root["nodes"][root["scenes"][root["scene"]]["nodes"][0]]["mesh"]]["primitives"]
    assert primitive["mode"] == 4
    part, positions = accessor(primitive["attributes"]["POSITION"], 3, "<f4", "VEC3", 34962)
    assert part["componentType"] == 5126
    assert part["min"] == positions.min(axis=0).tolist() and part["max"] == positions.max(axis=0).tolist()
    _, normals = accessor(primitive["attributes"]["NORMAL"], 3, "<f4", "VEC3", 34962)
    part, indices = accessor(primitive["indices"], 1, "<u4", "SCALAR", 34963)
    assert part["componentType"] == 5125 and len(indices) % 3 == 0 and indices.max() < len(positions)
    _, places = accessor(primitive["attributes"]["TEXCOORD_0"], 2, "<f4", "VEC2", 34962)
    (image,), (texture,), (material,) = root["images"], root["textures"], root["materials"]
    view = root["bufferViews"][image["bufferView"]]
    assert primitive["material"] == 0 and material["pbrMetallicRoughness"]["baseColorTexture"] == {"index": 0} and texture == {"source": 0, "sampler": 0}
    assert image["mimeType"] == "image/png" and "target" not in view and view["byteOffset"] + view["byteLength"] <= len(body) < view["byteOffset"] + view["byteLength"] + 4
    picture = tile_readers.png(body[view["byteOffset"]:view["byteOffset"] + view["byteLength"]])[3]
    return root, positions.astype(float), normals.astype(float), indices.reshape(-1, 3).astype(int), places.astype(float), picture


def read_obj(path):
    """Positions, places in a picture, normals, triangles; each vertex has its own place and normal."""
    found = {"v": [], "vt": [], "vn": [], "f": [], "o": []}
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "f":
            corners = [corner.split("/") for corner in rest]
            assert len(corners) == 3 and all(a == b == c for a, b, c in corners)
            found["f"].append([int(a) - 1 for a, _, _ in corners])
        elif word == "o":
            found["o"].append(line[2:])
        elif word != "#":
            found[word].append([float(part) for part in rest])
    assert len(found["o"]) == 1
    return [numpy.array(found[word]) for word in ("v", "vt", "vn", "f")]


def read_stl(path):
    """Normals and corners of triangles."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count and not data.startswith(b"solid")
    parts = numpy.frombuffer(data, numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")]), count, 84)
    assert not parts["colour"].any()
    return parts["normal"].astype(float), parts["corners"].astype(float)


def z_up(points):
    """x east, y up, z south to x east, y north, z up."""
    return numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


class Meshes(furrow_test.FurrowTest):
    def check(self, store, heights, spacing, window, level, origin):
        """heights: what is expected at the window's posts, rows from the south, NaN in holes; all three formats agree with it."""
        options = ("--window", ",".join(map(str, window)), "--level", level)
        for ending in ("obj", "glb", "stl"):
            self.ok("export", store, "--mesh", f"m.{ending}", *options)
        root, positions, normals, triangles, places, picture = read_glb(self.folder / "m.glb")
        (node,) = root["nodes"]
        self.assertEqual((node["name"], node["extras"]), (pathlib.Path(store).stem, root["extras"]))
        self.assertEqual(node["extras"]["window"], [column * spacing + start for start, column in
                                                    zip([-(-at // spacing) * spacing for at in window[:2]] * 2, (0, 0, heights.shape[1] - 1, heights.shape[0] - 1))])
        self.assertIn("y up", root["extras"]["axes"])
        base = root["extras"]["origin"][2]
        self.assertEqual(root["extras"]["origin"][:2], list(origin))
        positions, normals = z_up(positions), z_up(normals)
        rows, columns = heights.shape
        columns_at, rows_at = numpy.rint(positions[:, 0] / spacing).astype(int), numpy.rint(positions[:, 1] / spacing).astype(int)
        numpy.testing.assert_allclose(positions[:, :2], numpy.stack([columns_at, rows_at], axis=1) * spacing, atol=1e-9 + 1e-7 * spacing * max(rows, columns))
        numpy.testing.assert_allclose(positions[:, 2] + base, heights[rows_at, columns_at], atol=2e-4)
        # Every cell: two triangles, or one, or none, by how many of its posts are there; each post once.
        known = numpy.isfinite(heights)
        count = known[1:, 1:].astype(int) + known[:-1, 1:] + known[1:, :-1] + known[:-1, :-1]
        self.assertEqual(len(triangles), 2 * (count == 4).sum() + (count == 3).sum())
        self.assertEqual(len({(a, b) for a, b in zip(columns_at, rows_at)}), len(positions))
        self.assertEqual(set(triangles.ravel()), set(range(len(positions))))
        corners = positions[triangles]
        across = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((across[:, 2] > 0).all(), "counter-clockwise from above")
        self.assertAlmostEqual(across[:, 2].sum() / 2, spacing ** 2 * ((count == 4).sum() + (count == 3).sum() / 2), delta=1e-3 * spacing ** 2 * count.size)
        # An edge has one triangle on each side: none has two on one.
        edges = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        self.assertEqual(len({tuple(edge) for edge in edges.tolist()}), len(edges))
        numpy.testing.assert_allclose(numpy.linalg.norm(normals, axis=1), 1, atol=1e-5)
        self.assertTrue((normals[:, 2] > 0).all())
        # A post is the centre of its pixel, in the picture of the .glb and in rasters of the same window.
        self.assertEqual(picture.shape[:2], heights.shape)
        numpy.testing.assert_allclose(places, numpy.stack([(columns_at + 0.5) / columns, 1 - (rows_at + 0.5) / rows], axis=1), atol=2e-7)
        points, pixels, obj_normals, faces = read_obj(self.folder / "m.obj")
        numpy.testing.assert_allclose(pixels, numpy.stack([places[:, 0], 1 - places[:, 1]], axis=1), atol=2e-7)
        points, obj_normals = z_up(points), z_up(obj_normals)
        numpy.testing.assert_allclose(points, positions, atol=1e-6 * max(1, abs(positions).max()))
        numpy.testing.assert_allclose(obj_normals, normals, atol=2e-6)
        numpy.testing.assert_array_equal(faces, triangles)
        stl_normals, stl_corners = read_stl(self.folder / "m.stl")
        numpy.testing.assert_array_equal(stl_corners, corners)
        numpy.testing.assert_allclose(stl_normals, across / numpy.linalg.norm(across, axis=1)[:, None], atol=1e-4)
        return positions, normals

    def exported(self, store, window, level):
        self.ok("export", store, "-o", "s.tif", "--window", ",".join(map(str, window)), "--level", level)
        width, height, cells = rasters.pixels(self.folder / "s.tif")
        values = numpy.array(cells).reshape(height, width)[::-1]
        return numpy.where(values == rasters.nodata_of(self.folder / "s.tif"), numpy.nan, values)

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_windows_levels_and_spacings(self):
        for spacing, window, level in ((1, (0, 0, 40, 30), 0), (0.25, (3, 5, 12, 20), 1), (30, (300, 30, 1500, 1200), -1)):
            with self.subTest(spacing=spacing, level=level):
                store = self.synth(posts="520x300", spacing=spacing, relief=20 * spacing)
                step = spacing * 2 ** level
                heights = self.exported(store, window, level)
                self.check(store, heights, step, window, level, (-(-window[0] // step) * step, -(-window[1] // step) * step))

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_holes_are_left_out_and_the_place_is_kept(self):
        generator = numpy.random.default_rng(5)
        for share in (0.02, 0.3, 0.7):
            values = generator.uniform(2000, 2010, (40, 50)).astype(numpy.float32)
            values[generator.uniform(size=values.shape) < share] = -9999
            path = rasters.make(self.folder / "holes.tif", 50, 40, values[::-1].ravel().tolist(), west=4321000, north=3210400, step=10, srs="EPSG:3035",
                                nodata=-9999)
            self.ok("import", path, "-o", "holes.furrow", "--tile", 16, "--overwrite", "--max-error", 0)
            heights = numpy.where(values == -9999, numpy.nan, values)
            self.check("holes.furrow", heights, 10, (0, 0, 490, 390), 0, (4321005, 3210005))

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_normals_are_those_of_the_surface(self):
        x, y = numpy.meshgrid(numpy.arange(60), numpy.arange(60))
        values = 5 * numpy.sin(x / 12) + 3 * numpy.cos(y / 15)
        path = rasters.make(self.folder / "waves.tif", 60, 60, values[::-1].ravel().tolist(), west=0, north=120, step=2, srs=None)
        self.ok("import", path, "-o", "waves.furrow", "--max-error", 0, "--spacing", 2)
        positions, normals = self.check("waves.furrow", values.astype(numpy.float32), 2, (0, 0, 118, 118), 0, (1, 1))
        east, north = 5 / 24 * numpy.cos(positions[:, 0] / 24), -3 / 30 * numpy.sin(positions[:, 1] / 30)
        truth = numpy.stack([-east, -north, numpy.ones_like(east)], axis=1)
        truth /= numpy.linalg.norm(truth, axis=1)[:, None]
        inner = ((positions[:, :2] > 1) & (positions[:, :2] < 117)).all(axis=1)
        self.assertLess(abs(normals - truth)[inner].max(), 5 / 24 / 6 / 12 ** 2 + 1e-4)  # of a difference over two posts

    def test_up(self):
        store = self.synth(name="Große Höhe 7.furrow", posts="40x30", spacing=2)
        for ending, read in (("obj", lambda path: read_obj(path)[0]), ("stl", lambda path: read_stl(path)[1].reshape(-1, 3))):
            for axis in ("y", "z"):
                told = self.ok("export", store, "--mesh", f"{axis}.{ending}", "--up", axis)
                self.assertIn(f"; up is {axis}\n", told)
            numpy.testing.assert_array_equal(z_up(read(self.folder / f"y.{ending}")), read(self.folder / f"z.{ending}"))
            self.ok("export", store, "--mesh", f"m.{ending}")
            self.assertEqual((self.folder / f"m.{ending}").read_bytes(), (self.folder / f"{'y' if ending == 'obj' else 'z'}.{ending}").read_bytes())
        self.assertIn("\no Große Höhe 7\n", (self.folder / "m.obj").read_text())
        self.ok("export", store, "--mesh", "m.glb", "--up", "y")
        self.assertEqual(read_glb(self.folder / "m.glb")[0]["nodes"][0]["name"], "Große Höhe 7")
        self.assertIn("leave --up out", self.refused(2, "export", store, "--mesh", "z.glb", "--up", "z"))
        self.refused(2, "export", store, "--mesh", "z.obj", "--up", "x")
        self.refused(2, "export", store, "-o", "z.tif", "--up", "z")
        self.refused(2, "export", store, "--tiles", "tiles", "--up", "z")
        self.assertFalse((self.folder / "z.glb").exists())

    def colours(self, store, *options):
        """Places of the mesh's vertices and the colours of the picture there."""
        self.ok("export", store, "--mesh", "c.glb", *options)
        _, positions, _, _, places, picture = read_glb(self.folder / "c.glb")
        height, width = picture.shape[:2]
        columns, rows = (numpy.clip(numpy.floor(places[:, k] * side).astype(int), 0, side - 1) for k, side in enumerate((width, height)))
        return z_up(positions), picture[rows, columns].astype(int), picture.shape[:2]

    def test_the_picture_has_ruts_in_colour_and_heights_without_them(self):
        store = self.synth(posts="60x50", kind="plain", relief=0)
        positions, plain, _ = self.colours(store)
        self.assertEqual(len({tuple(colour) for colour in plain.tolist()}), 1)
        self.ok("edit", store, "--polygon", "POLYGON ((10 20, 30 20, 30 28, 10 28, 10 20))", "--depth", -0.5, "--dense")
        self.ok("edit", store, "--polygon", "POLYGON ((10 35, 30 35, 30 43, 10 43, 10 35))", "--depth", 0.5, "--dense")
        positions, colours, _ = self.colours(store)
        dug = positions[:, 2] < positions[:, 2].max() - 0.9
        self.assertEqual(set(map(tuple, numpy.rint(positions[dug, :2]).astype(int).tolist())), {(x, y) for x in range(10, 30) for y in range(20, 28)})
        ground = colours[(positions[:, 0] > 45)]
        self.assertTrue((ground.max(axis=1) - ground.min(axis=1) < 12).all(), "ground is grey")
        inner = dug & (positions[:, 0] > 12) & (positions[:, 0] < 27) & (positions[:, 1] > 22) & (positions[:, 1] < 25)
        self.assertTrue((colours[inner].max(axis=1) - colours[inner].min(axis=1) > 40).all(), "a pit has a colour")
        # A window beside the pit has none, so heights are shown.
        _, beside, _ = self.colours(store, "--window", "40,0,59,49")
        self.assertEqual({tuple(colour) for colour in beside.tolist()}, {tuple(plain[0].tolist())})

    @unittest.skipUnless(furrow_test.has_gdal(), "no GDAL")
    def test_a_large_mesh_has_a_smaller_picture_in_the_same_place(self):
        x = numpy.arange(3000)
        values = numpy.tile(numpy.where(abs(x - 2004) < 24, 50, 0), (20, 1)).astype(numpy.float32)
        path = rasters.make(self.folder / "wall.tif", 3000, 20, values.ravel().tolist(), step=1)
        self.ok("import", path, "-o", "wall.furrow", "--max-error", 0)
        positions, colours, shape = self.colours("wall.furrow")
        self.assertEqual(shape, (10, 1500))
        on = abs(positions[:, 0] - 2004) < 20
        far = abs(positions[:, 0] - 2004) > 28
        high, low = numpy.median(colours[on], axis=0), numpy.median(colours[far], axis=0)
        self.assertTrue((abs(colours[on] - high).sum(axis=1) < abs(colours[on] - low).sum(axis=1)).all())
        self.assertTrue((abs(colours[far] - low).sum(axis=1) < abs(colours[far] - high).sum(axis=1)).all())

    def test_refusals(self):
        store = self.synth(posts="65x65")
        self.refused(2, "export", store, "--mesh", "m.ply")
        self.refused(2, "export", store, "--mesh", "m.obj", "-o", "m.tif")
        self.refused(2, "export", store, "--mesh", "m.obj", "--sun", "90,45")
        self.refused(3, "export", store, "--mesh", "m.obj", "--window", "100,100,200,200")
        self.refused(3, "export", store, "--mesh", "m.obj", "--window", "1.2,1.2,1.8,1.8")
        told = self.refused(3, "export", store, "--mesh", "m.obj", "--window", "3,3,3,9")
        self.assertIn("no cell", told)
        for ending in ("obj", "glb", "stl"):
            told = self.refused(3, "export", store, "--mesh", f"m.{ending}", "--level", -9)
            self.assertRegex(told, r"32769 x 32769 posts .*--level -[5-7]")
        self.refused(1, "export", store, "--mesh", "nowhere/m.obj")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["world.furrow"])


if __name__ == "__main__":
    furrow_test.main()
