"""What the tests of furrow view share: an X server of their own, and a window in it that they press and look at."""
import os
import struct
import subprocess
import time
import unittest
import zlib

from furrow_test import FURROW, FurrowTest

WINDOW = os.environ.get("FURROW_WINDOW", "1") == "1"  # this build has one
PATIENCE = 240  # s, of what must come in the end; nothing is asserted of how soon

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


def unpredicted(row, before):
    """Undoes the Paeth filter of PNG, in place."""
    left, corner = [0, 0, 0], [0, 0, 0]
    for i, up in enumerate(before):
        channel = i % 3
        west, north_west = left[channel], corner[channel]
        to_west, to_north, to_corner = abs(up - north_west), abs(west - north_west), abs(west + up - 2 * north_west)
        guess = west if to_west <= to_north and to_west <= to_corner else up if to_north <= to_corner else north_west
        left[channel] = row[i] = (row[i] + guess) & 255
        corner[channel] = up


def read_png(data):
    """width, height and the RGB rows of a PNG such as furrow writes."""
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
        if kind == 4:
            unpredicted(row, before)
        elif kind != 0:
            for i in range(stride):
                left = row[i - 3] if i >= 3 else 0
                row[i] = (row[i] + (left, before[i], (left + before[i]) // 2)[kind - 1]) & 255
        rows.append(bytes(row))
    return width, height, rows


def read_xwd(data):
    """width, height and the RGB rows of what xwd writes of a screen with 8 bits a colour."""
    header = struct.unpack(">25I", data[:100])
    size, width, height, order, bits, stride, colours = header[0], *header[4:6], header[7], header[11], header[12], header[19]
    assert bits in (24, 32), f"{bits} bits a pixel"
    at, step = size + 12 * colours, bits // 8
    red, green, blue = (2, 1, 0) if order == 0 else (step - 3, step - 2, step - 1)
    rows = []
    for y in range(height):
        row, rgb = data[at + y * stride:at + y * stride + step * width], bytearray(3 * width)
        rgb[0::3], rgb[1::3], rgb[2::3] = row[red::step], row[green::step], row[blue::step]
        rows.append(bytes(rgb))
    return width, height, rows


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


class WindowTest(FurrowTest):
    """Has world.furrow and scene.yaml in its folder, and a display without windows."""

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

    def open(self, *arguments, scene="scene.yaml", env=None):
        environment = dict(os.environ, DISPLAY=self.display.name, SDL_VIDEODRIVER="x11", TMPDIR=str(self.temporary), **(env or {}))
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

    def picture_file(self):
        """The bytes of what P writes."""
        self.pictures += 1
        path = self.folder / f"view-{self.pictures:04d}.png"
        self.key("p")
        self.until(path.name, path.exists)
        return path.read_bytes()

    def picture(self):
        """What P writes."""
        return read_png(self.picture_file())

    def still_picture(self):
        """Once nothing changes any more: tiles have come, messages have gone, a follower has swung round."""
        files = [self.picture_file()]

        def rested():
            files.append(self.picture_file())
            return files[-1] == files[-2]
        self.until("a picture at rest", rested)
        return read_png(files[-1])

    def close(self, status=0):
        out, err = self.process.communicate(timeout=PATIENCE)
        self.assertEqual(self.process.returncode, status, out + err)
        self.assertEqual(list(self.temporary.iterdir()), [], "the temporary overlay is gone")
        return out, err

    def hold(self):
        """Paused, without the line of figures."""
        self.key("space", "l")
        self.until("a pause", lambda: "paused" in self.title())

    def screen(self):
        """Width, height and rows of what a person sees of the window: from the screen itself, not from the program."""
        shell = self.xdo("getwindowgeometry", "--shell", self.window)
        x, y, width, height = (int(shell.split(f"{name}=")[1].split()[0]) for name in ("X", "Y", "WIDTH", "HEIGHT"))
        dumped = subprocess.run(["xwd", "-root", "-silent", "-display", self.display.name], capture_output=True, timeout=PATIENCE)
        self.assertEqual(dumped.returncode, 0, dumped.stderr)
        rows = read_xwd(dumped.stdout)[2]
        return width, height, [row[3 * x:3 * (x + width)] for row in rows[y:y + height]]
