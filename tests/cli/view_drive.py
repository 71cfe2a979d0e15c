"""What the window of furrow view does to a drive: marks and the way back, targets on the ground, the graph and the map."""
import math
import shutil
import sys
import unittest
import zlib

from furrow_test import main, need_vehicles
from window_test import SCENE, WINDOW, WindowTest

NEEDED = ["Xvfb", "xdotool"]
WIDTH, HEIGHT = 640, 360
EYE, TARGET, FOV = (64, 50, 14), (64, 66, 0), 0.9  # a scene's camera has this field of view
RED, WHEEL = (230, 40, 30), (86, 180, 233)  # a target's flag, and the first wheel's curve


def car():
    wheels = "".join(f'<body name="{n}" pos="{x} {y} 0"><joint name="{n}" axis="0 1 0"/><geom name="{n}" type="cylinder" size="0.3 0.1" euler="90 0 0" mass="5"/></body>'
                     for n, x, y in (("a", 0.6, 0.5), ("b", 0.6, -0.5), ("c", -0.6, 0.5), ("d", -0.6, -0.5)))
    motors = "".join(f'<velocity name="{n}" joint="{n}" kv="200"/>' for n in "abcd")
    return ('<mujoco><worldbody><body name="hull" pos="0 0 0.5"><freejoint/><geom type="box" size="0.6 0.3 0.1" mass="60"/>' + wheels +
            f"</body></worldbody><actuator>{motors}</actuator></mujoco>")


def places(picture, colour):
    """The pixels of a colour: x to the right, y down."""
    return [(x, y) for y, row in enumerate(picture[2]) for x in range(picture[0]) if tuple(row[3 * x:3 * x + 3]) == colour]


class Rested(WindowTest):
    def seen(self):
        """A picture at rest, short enough to be told."""
        return zlib.crc32(b"".join(self.still_picture()[2]))


@unittest.skipUnless(WINDOW, "this build has no window")
class Objects(Rested):
    def test_the_way_back_leads_to_the_mark_and_on_with_the_same_bits(self):
        self.open("--follow", "ball")
        self.until("steps", lambda: self.step() > 5)
        self.hold()
        self.key("z")  # there is no mark yet: nothing happens
        stood, marked = self.step(), self.seen()
        self.key("c")

        def go_on():
            for i in range(1, 7):
                self.key("n")
                self.until("a step", lambda: self.step() == stood + i)
            return self.seen()
        after = go_on()
        self.assertNotEqual(after, marked)
        self.key("2")
        offsets = self.seen()
        for _ in range(2):
            self.key("z")
            self.until("the mark", lambda: self.step() == stood)
            self.assertNotEqual(self.seen(), offsets, "ruts go back, too")
            self.key("1")
            self.assertEqual(self.seen(), marked)
            self.assertEqual(go_on(), after)
            self.key("2")
            self.assertEqual(self.seen(), offsets)
        self.key("Escape")
        self.close()

    def test_what_was_dropped_and_the_end_go_back_in_the_store_itself(self):
        self.scene(SCENE.replace("end_time: 20", "end_time: 2"))
        self.open("--write")
        self.until("steps", lambda: self.step() > 2)
        self.hold()
        self.key("2", "m", "c")  # the store is open for writing while the map is read
        stood, marked = self.step(), self.seen()
        self.xdo("mousemove", "--window", self.window, 100, 140)
        self.key("b", "o")
        self.until("a rut", lambda: self.seen() != marked)
        self.key(*["plus"] * 8, "space")
        self.until("the end", lambda: self.step() == 40)
        self.key("space", "z")
        self.until("the mark", lambda: self.step() == stood)
        self.assertEqual(self.seen(), marked)
        self.assertIn("1 dropped", self.close_with_escape())
        self.json("verify", "world.furrow")

    def test_the_map_follows_what_is_clicked_on_it(self):
        self.scene(SCENE.replace("objects:\n", "objects:\n  - {name: far, shape: {sphere: {radius: 2.5}}, sink: 0.6, path: {points: [[200, 220], [220, 220]], speed: 0.1}}\n"))
        self.open()
        self.until("steps", lambda: self.step() > 5)
        self.hold()
        without = self.still_picture()
        self.key("m")
        with_map = self.still_picture()
        changed = [(x, y) for y in range(180) for x in range(320) if with_map[2][y][3 * x:3 * x + 3] != without[2][y][3 * x:3 * x + 3]]
        left, right = min(x for x, _ in changed), max(x for x, _ in changed)
        top, bottom = min(y for _, y in changed), max(y for _, y in changed)
        self.assertTrue(left > 160 and bottom < 150, (left, right, top, bottom))
        # Its 257 posts span the frame but for an edge of 2 pixels; the far object is at 200, 220 of 256 m.
        side = right - left - 3
        at = (left + 2 + side * 200.5 / 257, bottom - 2 - side * 220.5 / 257)
        dots = places(with_map, WHEEL)
        self.assertTrue(any(math.dist(at, dot) < 5 for dot in dots), f"no dot of the far object at {at}: {dots}")
        self.xdo("mousemove", "--window", self.window, round(at[0]) - 3, round(at[1]) + 3, "click", 1)
        self.until("the eye behind it", lambda: self.eye()[1] > 200)
        self.assertLess(math.dist(self.eye()[:2], (200, 220)), 15)
        self.key("r", "m")
        self.until("the scene's camera", lambda: self.eye()[:2] == (128, 60))
        self.assertTrue(self.still_picture() == without, "without the map all is as before")
        self.key("Escape")
        self.close()

    def test_follow_takes_a_name(self):
        error = self.refused(2, "view", "scene.yaml", "--store", "world.furrow", "--follow", "nobody", env={"DISPLAY": self.display.name})
        self.assertIn("nobody", error)
        self.assertIn("it has ball", error)
        self.open("--follow", "ball")
        self.hold()
        self.until("the eye behind it", lambda: self.eye()[0] < 110 and abs(self.eye()[1] - 60) < 1)
        self.key("t")
        self.assertIn(" 0 dropped", self.close_with_escape())

    def close_with_escape(self):
        self.key("Escape")
        return self.close()[0]


@unittest.skipUnless(WINDOW, "this build has no window")
class Vehicles(Rested):
    def setUp(self):
        need_vehicles()
        super().setUp()
        (self.folder / "car.xml").write_text(car())
        self.scene("scene: 1\ntime_step: 0.004\nend_time: 40\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                   "vehicles:\n  - {name: car, model: car.xml, start: {at: [60, 60]}, driver: {path: {points: [[60, 60], [75, 60]], speed: 1}, drive: [a, b, c, d]}}\n"
                   f"view: {{size: [{WIDTH}, {HEIGHT}], camera: {{fixed: {{eye: {list(EYE)}, target: {list(TARGET)}}}}}, effects: [objects]}}\n", "car.yaml")
        self.synth(posts="257x257", spacing=0.5, kind="plain", relief=0.1)

    def ground_at(self, x, y):
        forward = [b - a for a, b in zip(EYE, TARGET)]
        forward = [part / math.hypot(*forward) for part in forward]
        up, focal = (0, -forward[2], forward[1]), HEIGHT / 2 / math.tan(FOV / 2)
        ray = [forward[i] * focal + (x - WIDTH / 2) * (1, 0, 0)[i] + (HEIGHT / 2 - y) * up[i] for i in range(3)]
        return self.json("query", "world.furrow", "--ray", ",".join(map(str, [*EYE, *ray])))["point"]

    def test_a_click_sends_the_vehicle_there_and_the_way_back_its_old_path(self):
        x, y = 200, 130  # behind the car and to its left
        place = self.ground_at(x, y)
        self.open("--overlay", "ruts.furrow", scene="car.yaml")
        self.hold()
        self.key("c")
        before, stood = self.seen(), self.step()
        path = self.go_on(stood)
        self.back_to(stood)
        self.xdo("mousemove", "--window", self.window, x, y, "click", 1)
        flag = self.until("a flag", lambda: places(self.picture(), RED))
        low = max(flag, key=lambda at: at[1])
        self.assertLess(math.dist(low, (x, y)), 5, "its foot is where the click was")
        self.assertNotEqual(self.go_on(stood), path)
        self.back_to(stood)
        self.assertEqual(self.seen(), before, "the flag goes, too")
        self.assertEqual(self.go_on(stood), path, "and it is on its path")
        self.back_to(stood)
        self.xdo("mousemove", "--window", self.window, x, y, "click", 1)
        self.until("a flag", lambda: places(self.picture(), RED))
        self.key("g", *["plus"] * 8, "space")
        speed = lambda: float(self.title().split(" m/s")[0].split()[-1])
        self.until("a start", lambda: speed() > 0.3)
        self.until("the curves of the wheels", lambda: len(places(self.picture(), WHEEL)) > 60)
        self.until("an end", lambda: self.step() > stood + 1500 and speed() < 0.02)
        self.key("Escape")
        self.close()
        self.assertGreater(self.ruts_near(*place[:2]), 0, f"there are no ruts at {place}")
        self.assertEqual(self.ruts_near(70, 60), 0, "it left its path")
        # It is off its path, and the store does not have where it was to go.
        self.assertIn("furrow view sent it", self.refused(3, "drive", "car.yaml", "--store", "world.furrow", "--overlay", "ruts.furrow", "--resume", "-o", "out"))

    def go_on(self, stood):
        """What is seen 150 steps on."""
        self.key(*["n"] * 150)
        self.until("150 steps", lambda: self.step() == stood + 150)
        return self.seen()

    def back_to(self, stood):
        self.key("z")
        self.until("the mark", lambda: self.step() == stood)

    def ruts_near(self, east, north):
        points = "".join(f"{east + i / 4} {north + j / 4}\n" for i in range(-5, 6) for j in range(-5, 6))
        return sum(max(-point["offset"], 0) for point in self.json("query", "ruts.furrow", stdin=points)["points"])


if __name__ == "__main__":
    if WINDOW and any(shutil.which(name) is None for name in NEEDED):
        print("no Xvfb, xdotool or their like")
        sys.exit(77)
    main()
