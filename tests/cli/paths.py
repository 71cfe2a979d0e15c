"""Paths that are turned and moved as a whole: the ruts are those of a path that was written there."""
import hashlib
import math

from furrow_test import FurrowTest, main

HEAD = "scene: 1\ntime_step: 0.1\nend_time: 6\nspacing: 0.25\nredistribute: {model: box}\nobjects:\n"


class PathsTest(FurrowTest):
    def ruts(self, name, objects):
        """A hash of the offsets that a drive of these objects leaves."""
        self.ok("synth", "-o", "base.furrow", "--posts", "129x129", "--spacing", "1", "--kind", "plain", "--overwrite")
        self.ok("drive", self.scene(HEAD + objects), "--store", "base.furrow", "-o", "out")
        self.ok("export", "base.furrow", "--layer", "offset", "-o", f"{name}.tif")
        return hashlib.sha256((self.folder / f"{name}.tif").read_bytes()).hexdigest()

    def points(self, points, more="", shape="{sphere: {radius: 0.6}}"):
        return f"  - {{name: a, shape: {shape}, sink: 0.2, path: {{points: {[list(p) for p in points]}, speed: 9{more}}}}}\n"

    def test_points_are_turned_about_the_first_and_then_moved(self):
        written = [(30, 40), (70, 40), (70, 52), (61, 75)]
        first = written[0]
        plain = self.ruts("plain", self.points(written))
        for degrees, (east, north) in ((90, (9, 7)), (180, (50, 30)), (-90, (0.5, 60)), (0, (-12.25, 3)), (360, (0, 0))):
            c, s = round(math.cos(math.radians(degrees))), round(math.sin(math.radians(degrees)))
            moved = [(first[0] + c * (x - first[0]) - s * (y - first[1]) + east, first[1] + s * (x - first[0]) + c * (y - first[1]) + north)
                     for x, y in written]
            with self.subTest(degrees=degrees, east=east, north=north):
                there = self.ruts("there", self.points(moved))
                self.assertEqual(self.ruts("same", self.points(written, f", rotate: {degrees}, offset: [{east}, {north}]")), there)
                self.assertEqual(there == plain, degrees == 360)

    def test_one_file_serves_several_objects_and_its_yaws_turn_with_it(self):
        box = "{box: {size: [4, 1, 1]}}"
        rows = [(0, 30, 30, 20), (3, 50, 34, 40), (6, 52, 60, 95)]

        def write(name, rows):
            (self.folder / name).write_text("t,x,y,z,yaw,pitch,roll\n" + "".join(f"{t},{x},{y},-3,{yaw},3,-5\n" for t, x, y, yaw in rows))

        write("poses.csv", rows)
        write("turned.csv", [(t, 30 - (y - 30) + 25, 30 + (x - 30) + 8, yaw + 90) for t, x, y, yaw in rows])
        write("moved.csv", [(t, x + 31, y - 6, yaw) for t, x, y, yaw in rows])

        def one(name, file, more):
            return f"  - {{name: {name}, shape: {box}, path: {{file: {file}{more}}}}}\n"

        used = self.ruts("poses", one("a", "poses.csv", ", rotate: 90, offset: [25, 8]") + one("b", "poses.csv", ", offset: [31, -6]"))
        self.assertEqual(used, self.ruts("poses", one("a", "turned.csv", "") + one("b", "moved.csv", "")))
        self.assertNotEqual(used, self.ruts("poses", one("a", "poses.csv", "") + one("b", "moved.csv", "")))

    def test_what_is_no_turn_or_move_is_refused(self):
        for more, told in ((", rotate: 36001", "path.rotate: 36001 is out of range; allowed: -36000 to 36000"),
                           (", offset: [1]", "path.offset: "), (", offset: [1, 2, 3]", "path.offset: "),
                           (", offset: [1, 2e9]", "path.offset[1]: 2e9 is out of range")):
            scene = self.scene(HEAD + self.points([(30, 40), (70, 40)], more))
            self.assertIn(told, self.refused(3, "explain", scene))


if __name__ == "__main__":
    main()
