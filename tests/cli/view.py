"""furrow view under a display of its own, by real key presses and clicks."""
import ctypes
import ctypes.util
import math
import re
import shutil
import signal
import sys
import unittest

from furrow_test import FurrowTest, long, main
from window_test import SCENE, WINDOW, Display, WindowTest

NEEDED = ["Xvfb", "xdotool"]


def ask_to_close(display, window):
    """What a window manager sends when its cross is pressed, which not every xdotool can."""
    x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    server = ctypes.c_void_p(x11.XOpenDisplay(display.encode()))
    # XClientMessageEvent: type, serial, send_event, display, window, message_type, format, data; in the room of an XEvent.
    event = (ctypes.c_long * 24)()
    event[0], event[4], event[6] = 33, window, 32
    event[5] = x11.XInternAtom(server, b"WM_PROTOCOLS", 0)
    event[7] = x11.XInternAtom(server, b"WM_DELETE_WINDOW", 0)
    x11.XSendEvent(server, ctypes.c_ulong(window), 0, ctypes.c_long(0), event)
    x11.XCloseDisplay(server)


@unittest.skipIf(WINDOW, "not on this machine: a build without a window")
class NoWindow(FurrowTest):
    def test_a_build_without_a_window_says_so(self):
        self.scene(SCENE)
        self.synth(posts="257x257", kind="plain", relief=4)
        self.assertIn("this build has no window", self.refused(1, "view", "scene.yaml", "--store", "world.furrow"))


@unittest.skipUnless(WINDOW, "this build has no window")
class View(WindowTest):
    def test_keys_do_what_they_say(self):
        before = self.json("verify", "world.furrow")
        self.open()
        self.until("steps", lambda: self.step() > 0)
        self.hold()
        first = self.still_picture()
        self.assertEqual(first[:2], (320, 180))
        self.assertGreater(len({pixel for row in first[2] for pixel in zip(row[::3], row[1::3], row[2::3])}), 100)
        stood = self.step()
        self.assertEqual(self.still_picture(), first, "paused, nothing moves")
        self.assertEqual(self.step(), stood)
        self.key("n")
        self.until("one step", lambda: self.step() == stood + 1)
        self.key("period")
        self.until("another", lambda: self.step() == stood + 2)
        # Colours, and back.
        self.key("4")
        heights = self.still_picture()
        self.key("6")
        tiles = self.still_picture()
        self.key("1")
        natural = self.still_picture()
        self.assertNotEqual(heights, natural)
        self.assertNotEqual(tiles, heights)
        # Flying changes the picture, the scene's camera brings it back.
        stood = self.eye()
        self.xdo("keydown", "w")
        self.until("another place", lambda: math.dist(self.eye(), stood) > 1)
        self.xdo("keyup", "w")
        flown = self.still_picture()
        self.assertNotEqual(flown, natural)
        # As far down as it goes, and not below the ground; the title shows a tenth of a metre.
        self.xdo("keydown", "q")
        ground = self.json("query", "world.furrow", *self.eye()[:2])["height"]
        self.until("the ground", lambda: abs(self.eye()[2] - ground - 0.3) < 0.1)
        self.still_picture()
        self.xdo("keyup", "q")
        x, y, z = self.eye()
        self.assertAlmostEqual(z, self.json("query", "world.furrow", x, y)["height"] + 0.3, delta=0.1)
        self.xdo("keydown", "e")
        self.until("a little height", lambda: self.eye()[2] > z + 3)
        self.xdo("keyup", "e")
        flown = self.still_picture()
        self.xdo("mousemove", "--window", self.window, 100, 90, "mousedown", 1, "mousemove_relative", "--sync", 40, 0, "mouseup", 1)
        self.assertNotEqual(self.still_picture(), flown)
        self.key("f")
        self.assertNotEqual(self.still_picture(), natural)
        self.key("r")
        self.assertEqual(self.still_picture(), natural)
        # The line of figures, and the keys.
        self.key("h")
        self.assertNotEqual(self.still_picture(), natural)
        self.key("h")
        self.key("Escape")
        out, err = self.close()
        self.assertIn("world.furrow is as it was", out)
        self.assertIn(f"{self.pictures} written", out)
        self.assertIn("looking changes nothing", err)
        self.assertEqual(self.json("verify", "world.furrow"), before)

    @long
    def test_what_is_dropped_is_kept_in_the_overlay(self):
        self.open("--overlay", "ruts.furrow")
        self.hold()
        before = self.still_picture()
        self.xdo("mousemove", "--window", self.window, 160, 110)
        self.key("o")
        self.until("a drop", lambda: self.still_picture() != before)
        self.key("b")
        self.xdo("mousemove", "--window", self.window, 100, 110, "click", 3)
        self.key("2")
        self.still_picture()
        self.key("Escape")
        out, _ = self.close()
        self.assertIn("2 dropped", out)
        self.assertIn("the ruts are in ruts.furrow", out)
        self.assertTrue(self.json("verify", "ruts.furrow")["ok"])
        self.assertEqual(self.json("info", "world.furrow")["tiles"]["offset"], 0)
        # Under the cursor: on the way that the eye looks, and as deep as it sinks.
        deepest = min(self.json("query", "ruts.furrow", 128, y)["offset"] for y in range(70, 250))
        self.assertAlmostEqual(deepest, -0.6, delta=0.1)

    @long
    def test_write_deforms_the_store(self):
        self.open("--write")
        self.until("steps", lambda: self.step() > 5)
        ask_to_close(self.display.name, int(self.window))
        out, _ = self.close()
        self.assertIn("the ruts are in world.furrow", out)
        self.assertGreater(self.json("info", "world.furrow")["tiles"]["offset"], 0)
        # Over its ruts a temporary overlay goes as over bare ground.
        before = (self.folder / "world.furrow").read_bytes()
        self.open()
        self.until("steps", lambda: self.step() > 5)
        ask_to_close(self.display.name, int(self.window))
        out, _ = self.close()
        self.assertIn("the ruts are gone", out)
        self.assertEqual((self.folder / "world.furrow").read_bytes(), before)

    def test_ctrl_c_ends_it_with_everything_written(self):
        self.open("--overlay", "ruts.furrow")
        self.until("steps", lambda: self.step() > 3)
        self.process.send_signal(signal.SIGINT)
        out, err = self.close(130)
        self.assertIn("view: interrupted after step", err)
        self.assertTrue(self.json("verify", "ruts.furrow")["ok"])
        self.assertGreater(self.json("info", "ruts.furrow")["tiles"]["offset"], 0)

    def test_a_scene_without_a_view_gets_one_and_the_window_another_size(self):
        self.scene(SCENE[:SCENE.index("view:")] + "cache: {slots: 128}\n", "plain.yaml")
        self.open("--set", "view.size=[200, 120]", scene="plain.yaml")
        self.hold()
        self.assertEqual(self.still_picture()[:2], (200, 120))
        self.xdo("windowsize", "--sync", self.window, 260, 150)
        self.until("the new size", lambda: self.picture()[:2] == (260, 150))
        self.key("Escape")
        self.close()

    def test_the_line_tells_of_the_followed_vehicle(self):
        """Its speed, slip and sinkage, in the title and on the screen."""
        if "MuJoCo" not in self.ok("--version"):
            self.skipTest("not on this machine: a build without vehicles")
        geoms = "".join(f'<body name="{n}" pos="{x} {y} 0"><joint name="{n}" axis="0 1 0"/><geom type="cylinder" size="0.3 0.1" euler="90 0 0" mass="5"/></body>'
                        for n, x, y in (("a", 0.6, 0.5), ("b", 0.6, -0.5), ("c", -0.6, 0.5), ("d", -0.6, -0.5)))
        motors = "".join(f'<velocity name="{n}" joint="{n}" kv="200"/>' for n in "abcd")
        (self.folder / "car.xml").write_text('<mujoco><worldbody><body name="hull" pos="0 0 0.5"><freejoint/><geom type="box" size="0.6 0.3 0.1" mass="60"/>' + geoms +
                                             f"</body></worldbody><actuator>{motors}</actuator></mujoco>")
        vehicles = "vehicles:\n" + "".join(f"  - {{name: {name}, model: car.xml, start: {{at: [60, {y}]}}, driver: {{hold: {{a: {turns}, b: {turns}, c: {turns}, d: {turns}}}}}}}\n"
                                           for name, y, turns in (("slow", 60, 2), ("fast", 70, 4)))
        text = "scene: 1\ntime_step: 0.004\nend_time: 20\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n" + vehicles
        self.scene(text + "view: {size: [320, 180], camera: {chase: slow}, effects: [objects]}\n", "cars.yaml")
        self.synth(posts="257x257", spacing=0.5, kind="plain", relief=0.1)
        self.open(scene="cars.yaml")
        told = re.compile(r"  (\w+) ([\d.]+) m/s  slip (-?[\d.]+)  sinkage ([\d.]+) mm  ")

        def told_of(name):
            found = told.search(self.title())
            return found and found[1] == name and [float(number) for number in found.groups()[1:]]
        self.until("a drive", lambda: self.step() > 200)
        speed, slip, sinkage = self.until("the camera's vehicle", lambda: told_of("slow"))
        self.assertAlmostEqual(speed, 0.6 * (1 - slip), delta=0.15)  # 2 rad/s on a radius of 0.3 m, less its slip
        self.assertTrue(1 < sinkage < 150, sinkage)
        self.key("space")
        self.until("a pause", lambda: "paused" in self.title())
        with_line = self.screen()[2]
        self.key("l")
        self.until("another picture", lambda: self.screen()[2] != with_line)
        self.key("l", "space", "f", "f")
        self.until("the other vehicle", lambda: "fast" in self.title())
        self.assertGreater(self.until("its speed", lambda: told_of("fast"))[0], 0.75)
        self.key("Escape")
        self.close()

    def test_without_a_display_it_says_so(self):
        environment = {"DISPLAY": "", "WAYLAND_DISPLAY": "", "SDL_VIDEODRIVER": "x11"}
        error = self.refused(1, "view", "scene.yaml", "--store", "world.furrow", env=environment)
        self.assertIn("display", error)
        # Nor does it draw where nobody sees it. Other libraries have their own say on stderr.
        del environment["SDL_VIDEODRIVER"]
        result = self.furrow("view", "scene.yaml", "--store", "world.furrow", env=environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("furrow: window: no display: ", result.stderr)

    def test_only_the_window_needs_sdl(self):
        """A file that is no library stands before SDL's."""
        (self.folder / "broken").mkdir()
        (self.folder / "broken" / "libSDL2-2.0.so.0").write_bytes(b"no library")
        env = {"LD_LIBRARY_PATH": str(self.folder / "broken")}
        self.assertEqual(self.json("explain", "scene.yaml", "--store", "world.furrow", env=env)["store"], "world.furrow")
        error = self.refused(1, "view", "scene.yaml", "--store", "world.furrow", env=env)
        self.assertRegex(error, "^furrow: window: SDL cannot be loaded: .*libSDL2.*; install it")

    def test_a_display_that_is_lost_leaves_nothing_behind(self):
        shared, self.display = self.display, Display()
        try:
            self.open("--overlay", "ruts.furrow")
            self.until("steps", lambda: self.step() > 3)
        finally:
            self.display.close()
            self.display = shared
        _, err = self.close(1)
        self.assertIn("the display is gone", err)
        self.assertTrue(self.json("verify", "ruts.furrow")["ok"])

    def test_ruts_that_are_there_and_units_are_told(self):
        self.open("--overlay", "ruts.furrow", "--set", "view.sun.height=0.6")
        self.until("steps", lambda: self.step() > 3)
        self.key("Escape")
        _, err = self.close()
        self.assertNotIn("ruts already", err)
        self.assertEqual(err.count("view.sun.height: 0.6 degrees above the horizon"), 1, err)
        self.open("--overlay", "ruts.furrow")
        self.key("Escape")
        _, err = self.close()
        self.assertEqual(err.count("ruts.furrow: the ground has ruts already"), 1, err)
        self.assertNotIn("view.sun.height", err)

    def test_two_places_for_ruts_are_refused(self):
        self.refused(2, "view", "scene.yaml", "--store", "world.furrow", "--write", "--overlay", "a.furrow")


if __name__ == "__main__":
    if WINDOW and any(shutil.which(name) is None for name in NEEDED):
        print("no Xvfb, xdotool or their like")
        sys.exit(77)
    main()
