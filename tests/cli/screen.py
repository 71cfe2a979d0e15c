"""What a person sees of furrow view: the screen of an X server against the picture that P writes, and where a click lands."""
import math
import os
import shutil
import subprocess
import sys
import time
import unittest

from furrow_test import main
from window_test import WINDOW, WindowTest

NEEDED = ["Xvfb", "xdotool", "xwd", "xlogo"]

# The camera of the scene in window_test.py. A look down upon a plain: no row is like the one as far from the other edge.
EYE, TARGET, FOV = (128, 60, 75), (128, 150, 20), 0.9
WIDTH, HEIGHT = 320, 180


def ray_through(x, y):
    """The direction from the eye through a pixel, counted from the picture's top left."""
    forward = [b - a for a, b in zip(EYE, TARGET)]
    length = math.hypot(*forward)
    forward = [part / length for part in forward]
    level = math.hypot(forward[0], forward[1])
    right = (forward[1] / level, -forward[0] / level, 0)
    up = (-forward[2] * forward[0] / level, -forward[2] * forward[1] / level, level)
    focal = HEIGHT / 2 / math.tan(FOV / 2)
    return [forward[i] * focal + (x - WIDTH / 2) * right[i] + (HEIGHT / 2 - y) * up[i] for i in range(3)]


def apart(first, second):
    """The mean difference of two pictures, of 255."""
    total = sum(abs(a - b) for one, other in zip(first[2], second[2]) for a, b in zip(one, other))
    return total / (3 * first[0] * first[1])


def upside_down(picture):
    return picture[0], picture[1], picture[2][::-1]


def centre_of_change(before, after):
    """The mean place of the pixels that differ, and how many do."""
    places = [(x, y) for y in range(before[1]) for x in range(before[0])
              if before[2][y][3 * x:3 * x + 3] != after[2][y][3 * x:3 * x + 3]]
    count = max(len(places), 1)
    return sum(x for x, _ in places) / count, sum(y for _, y in places) / count, len(places)


@unittest.skipUnless(WINDOW, "this build has no window")
class Screen(WindowTest):
    def settled(self):
        """The picture that P writes, once the screen shows the same: it is shown after it is written."""
        picture = self.still_picture()
        self.assertEqual(picture[:2], self.screen()[:2])
        return picture

    def test_the_screen_shows_what_p_writes(self):
        self.open()
        self.hold()
        self.key("h")  # text, too
        written = self.settled()
        seen = self.screen()
        self.assertGreater(apart(written, upside_down(written)), 10, "the test's picture must tell up from down")
        self.assertLess(apart(written, seen), 0.5, f"upside down it would be {apart(upside_down(written), seen):.2f}")
        self.key("Escape")
        self.close()

    def test_a_click_lands_where_it_points(self):
        x, y = 100, 140
        self.open("--overlay", "ruts.furrow")
        self.hold()
        self.key("2", "b")  # offsets in false colours, and a ball
        self.settled()
        before = self.screen()
        self.xdo("mousemove", "--window", self.window, x, y, "click", 3)
        self.until("a rut", lambda: self.still_picture()[2] != before[2])
        self.settled()
        seen_x, seen_y, changed = centre_of_change(before, self.screen())
        self.key("Escape")
        self.assertIn("1 dropped", self.close()[0])
        self.assertGreater(changed, 3)
        self.assertLess(math.hypot(seen_x - x, seen_y - y), 5, f"it is seen at {seen_x:.1f}, {seen_y:.1f}")
        # And in the overlay: the middle of what is lower now.
        meant = self.json("query", "world.furrow", "--ray", ",".join(map(str, [*EYE, *ray_through(x, y)])))["point"]
        middle = [round(part) for part in meant[:2]]
        places = [(east, north) for north in range(max(middle[1] - 20, 70), middle[1] + 21)
                  for east in range(middle[0] - 20, middle[0] + 21)]
        points = self.json("query", "ruts.furrow", stdin="".join(f"{east} {north}\n" for east, north in places))["points"]
        depths = [max(-point["offset"], 0) for point in points]
        self.assertGreater(sum(depths), 0, f"no rut within 20 m of {meant}")
        east, north = (sum(depth * place[i] for depth, place in zip(depths, places)) / sum(depths) for i in (0, 1))
        self.assertLess(math.hypot(east - meant[0], north - meant[1]), 1, f"{east:.2f}, {north:.2f}, not {meant}")

    def test_what_was_covered_is_shown_again(self):
        self.open()
        self.hold()
        before = self.settled()
        self.assertLess(apart(before, self.screen()), 0.5)
        shell = self.xdo("getwindowgeometry", "--shell", self.window)
        x, y = (int(shell.split(f"{name}=")[1].split()[0]) for name in ("X", "Y"))
        time.sleep(6)  # by now the message of P is gone from the line of figures: nothing else draws again
        cover = subprocess.Popen(["xlogo", "-geometry", f"200x120+{x + 20}+{y + 20}"], env=dict(os.environ, DISPLAY=self.display.name),
                                 stderr=subprocess.DEVNULL)
        self.addCleanup(cover.wait)
        self.addCleanup(cover.kill)
        self.until("a cover", lambda: apart(before, self.screen()) > 10)
        cover.kill()
        cover.wait()
        self.until("the picture, where it was covered", lambda: apart(before, self.screen()) < 0.5)
        self.key("Escape")
        self.close()

    def test_a_renderer_in_the_environment_changes_nothing(self):
        self.open()  # skipped where there is no GL at all
        self.key("Escape")
        self.close()
        try:
            self.open(env={"SDL_FRAMEBUFFER_ACCELERATION": "1", "SDL_RENDER_DRIVER": "no-such-driver"})
        except unittest.SkipTest:
            self.fail(f"GL is lost to SDL: {self.process.communicate()}")
        self.hold()
        written = self.settled()
        self.assertLess(apart(written, self.screen()), 0.5)
        self.key("Escape")
        self.close()


if __name__ == "__main__":
    if WINDOW and any(shutil.which(name) is None for name in NEEDED):
        print("no Xvfb, xdotool or their like")
        sys.exit(77)
    main()
