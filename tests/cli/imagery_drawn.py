"""`view.effects: [imagery]`: what pictures show of a store's imagery, beside GDAL; and that neither memory nor threads show in them."""
import math
import pathlib
import re
import sqlite3
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import main
from cameras import read_png
from raster_test import POSTS, SOUTH, STEP, WEST, PictureTest

SIZE = 400      # pixels of a camera's picture
SEEDS = 50
LAND = 4 * (POSTS - 1) + 1  # pixels of the picture
PLAIN = """scene: 1
store: s.furrow
time_step: 0.1
end_time: 0.1
view: {{size: [{size}, {size}], effects: [{effects}], camera: {{fixed: {{eye: [32, 32, 140], target: [34, 30, 100]}}}}, sun: {{height: 90}}{more}}}
{rest}"""
ABOVE = "  - {{name: {name}, kind: fixed, rate: 10, size: [{size}, {size}], fov: {fov:.9f}, pose: {{at: [{x}, {y}, {z}], yaw: 90, pitch: -90}}}}\n"


DIG = """scene: 1
store: {store}
time_step: 0.1
end_time: 2
soil: {{name: dry_sand}}
redistribute: {{model: sumner}}
attributes: [disturbance]
objects:
  - {{name: box, shape: {{box: {{size: [4, 4, 2]}}}}, sink: 0.3, path: {{points: [[12, 14], [50, 40]], speed: 20}}}}
view: {{{view}size: [160, 120], effects: [imagery, texture, detail, fog, sky, geomorph, skirts, objects], camera: {{chase: box, back: 6, up: 3}}, images: 5}}
cameras:
  - {{name: above, kind: overhead, on: box, height: 30, rate: 2, size: [120, 120]}}
cache: {cache}
"""


def ramp(x, y):
    return round(30 + 1.6 * x / STEP % 200), round(40 + 1.4 * y / STEP % 180), (round(x / STEP) * 7 + round(y / STEP) * 13) % 256


def spots():
    """50 places, m, none near another or the edge, each with one of six colours."""
    places = [(4.3 + 56 * ((0.5 + k * 0.754877666) % 1), 4.3 + 56 * ((0.5 + k * 0.569840291) % 1)) for k in range(SEEDS)]
    colours = [(230, 20, 20), (20, 200, 20), (20, 20, 230), (220, 220, 20), (20, 220, 220), (220, 20, 220)]
    return [(x, y, colours[k % 6]) for k, (x, y) in enumerate(places)]


def dotted(x, y):
    """Spots of 1 m, grey between them."""
    for px, py, colour in spots():
        if (x - px) ** 2 + (y - py) ** 2 < 0.25:
            return colour
    return 110, 110, 110


def saturation(pixels):
    wide = pixels[..., :3].astype(float)
    return wide.max(axis=-1) - wide.min(axis=-1)


class Drawn(PictureTest):
    def setUp(self):
        super().setUp()
        self.make("dem.tif", POSTS, POSTS, lambda x, y: 100, west=WEST - 0.5, north=SOUTH + POSTS - 0.5, step=1, srs="EPSG:32632")

    def above(self, out, views, effects="imagery", more="", rest=""):
        """Pictures straight from above, north up, of level ground. A view is its middle, m, and how many metres it shows: a pixel is so many / SIZE."""
        cameras = "".join(ABOVE.format(name=f"c{k}", size=SIZE, fov=2 * math.degrees(math.atan(across / 2 / 40)), x=x, y=y, z=140) for k, (x, y, across) in enumerate(views))
        self.scene(PLAIN.format(size=64, effects=effects, more=more, rest="cameras:\n" + cameras + rest), out + ".yaml")
        self.ok("drive", out + ".yaml", "-o", out)
        return [read_png(sorted((self.folder / out / "cameras" / f"c{k}" / "colour").glob("*.png"))[-1]) for k in range(len(views))]

    def middle_of_spot(self, strong, px, py, metre):
        """Of what is coloured within a metre of a place; pixels' centres are at halves."""
        rows, columns = np.mgrid[int(py - metre):int(py + metre) + 1, int(px - metre):int(px + metre) + 1]
        weight = np.where(strong[rows, columns] > 20, strong[rows, columns], 0)
        return np.array([(columns + 0.5) * weight, (rows + 0.5) * weight]).sum(axis=(1, 2)) / weight.sum()

    def test_colours_lie_where_gdal_has_them(self):
        """The middles of 50 spots, in pictures and in what the store gives back. A pixel of a picture is a twelfth of the imagery's, a third, and two thirds."""
        self.picture("ortho.tif", dotted)
        self.store("--imagery", "ortho.tif", "--lossless")
        self.ok("export", "s.furrow", "-o", "back.png", "--layer", "imagery", "--level", -2)
        places = "".join(f"{WEST + x} {SOUTH + y}\n" for x, y, _ in spots())
        told = np.array(list(map(int, self.gdal("gdallocationinfo", "-geoloc", "-valonly", "back.png", stdin=places).split()))).reshape(SEEDS, -1)
        grid = {(i, j): dotted(i * STEP, j * STEP) for i in range(LAND) for j in range(LAND)}
        views = [(16, 16, 36), (48, 16, 36), (16, 48, 36), (48, 48, 36), (32.3, 31.8, 70), (20.1, 41.3, 8)]
        seen = {across: set() for _, _, across in views}
        for (cx, cy, across), picture in zip(views, self.above("a", views)):
            strong, metre = saturation(picture), SIZE / across
            for k, (x, y, colour) in enumerate(spots()):
                self.assertEqual(tuple(told[k][:3]), colour)
                px, py = SIZE / 2 + (x - cx) * metre, SIZE / 2 - (y - cy) * metre
                if not (metre < px < SIZE - metre - 1 and metre < py < SIZE - metre - 1):
                    continue
                own = [(i * STEP, j * STEP) for (i, j), has in grid.items() if abs(i * STEP - x) < 1 and abs(j * STEP - y) < 1 and has == colour]
                mx, my = np.mean(own, axis=0)
                off = self.middle_of_spot(strong, px, py, metre) - [SIZE / 2 + (mx - cx) * metre, SIZE / 2 - (my - cy) * metre]
                self.assertLess(np.abs(off).max(), 0.5, (across, x, y))
                middle = picture[int(py), int(px)][:3].astype(int)
                for value, channel in zip(colour, middle):
                    self.assertEqual(value > 100, channel > 150, (across, x, y, middle))
                seen[across].add(k)
        self.assertEqual((len(seen[36]), len(seen[70])), (SEEDS, SEEDS))
        self.assertGreater(len(seen[8]), 0)

    def test_no_seam_shows(self):
        """One colour is drawn as one colour, whatever pages and levels it comes from. A ramp has no step."""
        self.picture("ortho.tif", lambda x, y: (150, 120, 90))
        self.store("--imagery", "ortho.tif", "--lossless", tile=8)
        oblique = "  - {name: far, kind: fixed, rate: 10, size: [400, 300], fov: 60, pose: {at: [2, 3, 102], yaw: 45, pitch: -30}}\n"
        for picture in self.above("a", [(32, 32, 30)], rest=oblique) + [read_png(self.folder / "a/cameras/far/colour/000000.png")]:
            ground = picture[picture[..., :3].max(axis=-1) > 60][:, :3].astype(int)  # not what is beyond the terrain
            self.assertGreater(len(ground), 60000)
            self.assertLessEqual((ground.max(axis=0) - ground.min(axis=0)).max(), 3)  # noise against bands, of a level each way
        self.picture("ortho.tif", lambda x, y: (round(40 + 2.4 * x), round(40 + 2.4 * y), 100))
        self.store("--imagery", "ortho.tif", "--lossless", tile=8)
        for across in (6, 24, 60):
            picture = self.above(f"r{across}", [(32.2, 31.7, across)])[0].astype(int)
            step = round(2.4 * across / SIZE * 2.2) + 4
            self.assertLessEqual(np.abs(np.diff(picture[..., 0], axis=1)).max(), step)
            self.assertLessEqual(np.abs(np.diff(picture[..., 1], axis=0)).max(), step)

    def pictures(self, out):
        return {path.relative_to(self.folder / out): path.read_bytes() for path in sorted((self.folder / out).rglob("*.png"))}

    def drive_over(self, out, view="", cache="{slots: 64}", tile=16, stop=None):
        """A box that digs drives over the picture, with a camera behind it and one from above."""
        store = self.store(name=out + ".furrow", tile=tile) if not (self.folder / (out + ".furrow")).exists() else None
        if store:
            self.ok("import", "--imagery", "ortho.tif", "-o", store)
        self.scene(DIG.format(store=out + ".furrow", view=view, cache=cache), out + ".yaml")
        result = self.furrow("drive", out + ".yaml", "-o", out, *(("--steps", stop) if stop else ()))
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stderr

    def test_memory_and_threads_do_not_show(self):
        self.picture("ortho.tif", ramp)
        self.drive_over("all")
        whole = self.pictures("all")
        self.assertEqual(len(whole), 9)
        for name, view, cache in (("few", "imagery_budget: 0.03, ", "{slots: 64}"), ("alone", "", "{slots: 64, loaders: 0}"), ("many", "imagery_budget: 0.06, ", "{slots: 24, loaders: 4}"),
                                  ("late", "", "{slots: 64, prefetch: 0}")):
            told = self.drive_over(name, view, cache)
            self.assertEqual("view.imagery_budget" in told, "imagery_budget" in view, told)
            self.assertTrue(self.pictures(name) == whole, name)
        told = self.drive_over("least", "imagery_budget: 0.001, ")
        self.assertIn("drawn coarser", told)
        for again in range(9):
            budget = re.search(r"give at least (\S+) MB, and more if another part needs more", told)[1]
            told = self.drive_over(f"more{again}", f"imagery_budget: {budget}, ")
            if "drawn coarser" not in told:
                break
        self.assertNotIn("drawn coarser", told)
        self.assertTrue(self.pictures(f"more{again}") == whole)
        self.assertEqual(self.pictures("least").keys(), whole.keys())

    def test_disturbed_soil_shows_through(self):
        """Blue imagery, and a box that comes down in the middle: there the ground is brown, and every other pixel is as before."""
        self.picture("ortho.tif", lambda x, y: (20, 40, 230))
        digs = DIG.split("view:")[0].format(store="s.furrow").split("time_step: 0.1\nend_time: 2\n")[1]
        found = []
        for objects in ("", digs.replace("[[12, 14], [50, 40]], speed: 20", "[[32, 32], [34, 32]], speed: 20")):
            self.store("--imagery", "ortho.tif", "--lossless")
            found.append(self.above(f"d{len(found)}", [(32, 32, 40)], "imagery, texture, detail", rest=objects)[0].astype(int))
        before, after = found
        self.assertTrue((before[..., 2] > before[..., 0] + 60).all())
        metre, middle = SIZE / 40, SIZE // 2
        dug = after[int(middle - metre):int(middle + metre), int(middle - metre):int(middle + metre)]
        self.assertTrue((dug[..., 2] < dug[..., 0] + 20).all())
        far = np.ones(before.shape[:2], bool)
        far[int(middle - 8 * metre):int(middle + 8 * metre), int(middle - 8 * metre):int(middle + 8 * metre)] = False
        self.assertTrue((before[far] == after[far]).all())

    def test_a_store_without_imagery_is_told(self):
        self.store()
        self.scene(PLAIN.format(size=64, effects="imagery", more=", images: 1", rest=""), "plain.yaml")
        for command in (("drive", "plain.yaml", "-o", "out"), ("explain", "plain.yaml")):
            told = self.refused(3, *command)
            self.assertIn("s.furrow has no imagery; add some with furrow import --imagery PICTURE.tif -o s.furrow", told)
        self.picture("ortho.tif", ramp)
        self.ok("import", "--imagery", "ortho.tif", "-o", "s.furrow")
        self.ok("drive", "plain.yaml", "-o", "out")
        self.ok("explain", "plain.yaml")

    def test_a_damaged_tile_ends_the_drive(self):
        self.picture("ortho.tif", ramp)
        self.store("--imagery", "ortho.tif")
        with sqlite3.connect(self.folder / "s.furrow") as db:
            db.execute("UPDATE imagery SET blob = zeroblob(40)")
        self.scene(PLAIN.format(size=64, effects="imagery", more=", images: 1", rest=""), "plain.yaml")
        self.assertIn("it is damaged", self.refused(3, "drive", "plain.yaml", "-o", "out"))


if __name__ == "__main__":
    main()
