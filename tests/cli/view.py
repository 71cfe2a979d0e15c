"""furrow view under a display of its own, by real key presses and clicks."""
import ctypes
import ctypes.util
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest
import zlib

from furrow_test import FURROW, FurrowTest, main

NEEDED = ["Xvfb", "xdotool"]
WINDOW = os.environ.get("FURROW_WINDOW", "1") == "1"  # this build has one
PATIENCE = 60  # s, of what must come in the end; nothing is asserted of how soon

SCENE = """scene: 1
time_step: 0.05
end_time: 20
redistribute: {model: box}
attributes: [dirt]
objects:
  - {name: ball, shape: {sphere: {radius: 2.5}}, sink: 0.6, path: {points: [[60, 60], [100, 60]], speed: 10}}
view:
  size: [320, 180]
  camera: {fixed: {eye: [128, 60, 75], target: [128, 150, 20]}}
  effects: [texture, sky, geomorph, skirts]
cache: {slots: 128}
"""


def read_png(path):
    """width, height and the RGB rows of a PNG such as furrow writes."""
    data = path.read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    raw, rows, stride = zlib.decompress(packed), [], 3 * width
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        before = rows[-1] if rows else bytes(stride)
        for i in range(stride):
            left, up = row[i - 3] if i >= 3 else 0, before[i]
            corner = before[i - 3] if i >= 3 else 0
            guess = left + up - corner
            near = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, near)[kind]) & 255
        rows.append(bytes(row))
    return width, height, rows


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


class Display:
    """An X server without a window manager, on a number that is free."""

    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        if not number:
            raise unittest.SkipTest("Xvfb does not start here")
        self.name = ":" + number

    def close(self):
        self.server.terminate()
        self.server.wait()


@unittest.skipIf(WINDOW, "this build has a window")
class NoWindow(FurrowTest):
    def test_a_build_without_a_window_says_so(self):
        self.scene(SCENE)
        self.synth(posts="257x257", kind="plain", relief=4)
        self.assertIn("this build has no window", self.refused(1, "view", "scene.yaml", "--store", "world.furrow"))


@unittest.skipUnless(WINDOW, "this build has no window")
class View(FurrowTest):
    @classmethod
    def setUpClass(cls):
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()

    def setUp(self):
        super().setUp()
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        self.pictures = 0
        self.scene(SCENE)
        self.synth(posts="257x257", kind="plain", relief=4)

    def xdo(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=dict(os.environ, DISPLAY=self.display.name),
                              capture_output=True, text=True, timeout=PATIENCE).stdout

    def until(self, what, tried):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            found = tried()
            if found:
                return found
            if self.process.poll() == 4:
                self.skipTest("no GL here")
            if self.process.poll() is not None:
                self.fail(f"it ended: {self.process.communicate()}")
            time.sleep(0.05)
        self.fail(f"never: {what}")

    def open(self, *arguments, scene="scene.yaml"):
        environment = dict(os.environ, DISPLAY=self.display.name, SDL_VIDEODRIVER="x11", TMPDIR=str(self.temporary))
        self.process = subprocess.Popen([FURROW, "view", scene, "--store", "world.furrow", *arguments], cwd=self.folder, text=True,
                                        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(self.end)
        self.window = self.until("a window", lambda: self.xdo("search", "--name", "^furrow").split())[0]
        self.until("the focus", lambda: self.xdo("windowfocus", self.window) is not None and
                   self.xdo("getwindowfocus").strip() == self.window)
        # The title tells figures once the drive runs.
        self.until("figures", lambda: "step" in self.title())

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def title(self):
        return self.xdo("getwindowname", self.window)

    def key(self, *keys):
        self.xdo("key", *keys)

    def step(self):
        return int(self.title().split("step ")[1].split("/")[0])

    def eye(self):
        return tuple(map(float, self.title().split("eye ")[1].split()[:3]))

    def picture(self):
        """What P writes."""
        self.pictures += 1
        path = self.folder / f"view-{self.pictures:04d}.png"
        self.key("p")
        self.until(path.name, path.exists)
        return read_png(path)

    def still_picture(self):
        """Once nothing changes any more: tiles have come, messages have gone, a follower has swung round."""
        pictures = [self.picture()]

        def rested():
            pictures.append(self.picture())
            return pictures[-1] == pictures[-2]
        self.until("a picture at rest", rested)
        return pictures[-1]

    def close(self, status=0):
        out, err = self.process.communicate(timeout=PATIENCE)
        self.assertEqual(self.process.returncode, status, out + err)
        self.assertEqual(list(self.temporary.iterdir()), [], "the temporary overlay is gone")
        return out, err

    def hold(self):
        """Paused, without the line of figures."""
        self.key("space", "l")
        self.until("a pause", lambda: "paused" in self.title())

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
        self.xdo("keydown", "w")
        time.sleep(0.5)
        self.xdo("keyup", "w")
        flown = self.still_picture()
        self.assertNotEqual(flown, natural)
        # As far down as it goes, and not below the ground; the title shows a tenth of a metre.
        self.xdo("keydown", "q")
        self.until("the ground", lambda: self.eye()[2] < 40 and self.eye() == (time.sleep(1), self.eye())[1])
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

    def test_write_deforms_the_store(self):
        self.open("--write")
        self.until("steps", lambda: self.step() > 5)
        ask_to_close(self.display.name, int(self.window))
        out, _ = self.close()
        self.assertIn("the ruts are in world.furrow", out)
        self.assertGreater(self.json("info", "world.furrow")["tiles"]["offset"], 0)
        # From now on it has ruts of its own.
        error = self.refused(3, "view", "scene.yaml", "--store", "world.furrow", env={"DISPLAY": self.display.name})
        self.assertIn("--write", error)

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

    def test_without_a_display_it_says_so(self):
        environment = {"DISPLAY": "", "WAYLAND_DISPLAY": "", "SDL_VIDEODRIVER": "x11"}
        error = self.refused(1, "view", "scene.yaml", "--store", "world.furrow", env=environment)
        self.assertIn("display", error)
        # Nor does it draw where nobody sees it. Other libraries have their own say on stderr.
        del environment["SDL_VIDEODRIVER"]
        result = self.furrow("view", "scene.yaml", "--store", "world.furrow", env=environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("furrow: window: no display: ", result.stderr)

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

    def test_two_places_for_ruts_are_refused(self):
        self.refused(2, "view", "scene.yaml", "--store", "world.furrow", "--write", "--overlay", "a.furrow")


if __name__ == "__main__":
    if WINDOW and any(shutil.which(name) is None for name in NEEDED):
        sys.exit(77)
    main()
