"""The scenes of paging.py: vehicles of four wheels on a terrain of posts a metre apart, 65 km wide.

A scene is a YAML file and a file of poses a wheel. Where a vehicle drives is a line of points; its wheels
follow it 0.9 m to either side and 2.6 m behind, so that four wheels write two ruts."""
import math
import random

TRACK, BASE = 0.9, 2.6  # metres: from the middle to a wheel, from the front wheels to the rear ones
TILE = 256              # cells of a tile's side
TIME_STEP = 0.02


class Line:
    """Points by the metres driven to them; straight on before the first and behind the last."""

    def __init__(self, points):
        self.points, self.lengths = points, [0.0]
        for (ax, ay), (bx, by) in zip(points, points[1:]):
            self.lengths.append(self.lengths[-1] + math.hypot(bx - ax, by - ay))
        self.length, self.found = self.lengths[-1], 0

    def at(self, metres):
        i = self.found  # asked in order, mostly
        while i > 0 and self.lengths[i] > metres:
            i -= 1
        while i + 2 < len(self.lengths) and self.lengths[i + 1] <= metres:
            i += 1
        self.found = i
        (ax, ay), (bx, by) = self.points[i], self.points[i + 1]
        share = (metres - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i])
        return ax + share * (bx - ax), ay + share * (by - ay)

    def beside(self, metres, aside):
        (ax, ay), (bx, by) = self.at(metres - 1), self.at(metres + 1)
        x, y = self.at(metres)
        long = math.hypot(bx - ax, by - ay)
        return x - aside * (by - ay) / long, y + aside * (bx - ax) / long


class Scene:
    """`drives`: for each vehicle its line and how many metres behind the line's first point it starts."""

    def __init__(self, name, spacing, speed, drives, every=2, more=""):
        self.name, self.spacing, self.speed, self.drives = name, spacing, speed, drives
        self.every, self.more = every, more  # every: metres from pose to pose
        self.metres = min(line.length for line, _ in drives)

    def write(self, folder):
        """The scene's file."""
        lines = ["scene: 1", f"time_step: {TIME_STEP}", f"end_time: {self.metres / self.speed}",
                 f"spacing: {self.spacing}", "redistribute: {model: box}", "objects:"]
        for vehicle, (line, behind) in enumerate(self.drives):
            for wheel in range(4):
                aside, back = (-TRACK, TRACK)[wheel % 2], (0, BASE)[wheel // 2]
                name = f"v{vehicle}w{wheel}"
                poses = folder / f"{self.name}-{name}.csv"
                poses.write_text("".join(self.poses(line, behind + back, aside)))
                lines.append(f"  - {{name: {name}, shape: {{wheel: {{radius: 0.4, width: 0.3}}}}, sink: 0.05, "
                             f"path: {{file: {poses.name}}}}}")
        path = folder / f"{self.name}.yaml"
        path.write_text("\n".join(lines) + "\n" + self.more)
        return path

    def poses(self, line, behind, aside):
        yield "t,x,y\n"
        count = max(1, math.ceil(self.metres / self.every))
        for i in range(count + 1):
            metres = self.metres * i / count
            x, y = line.beside(metres - behind, aside)
            yield f"{metres / self.speed:.4f},{x:.4f},{y:.4f}\n"


def straight(name, metres, spacing, speed, at=(2000, 2000), direction=(1, 1), more=""):
    long = math.hypot(*direction)
    end = [a + metres * d / long for a, d in zip(at, direction)]
    return Scene(name, spacing, speed, [(Line([at, end]), 0)], every=metres, more=more)


def ring(laps, radius, spacing, speed):
    steps = int(2 * math.pi * radius / 5)
    points = [(20000 + radius * math.cos(2 * math.pi * i / steps), 20000 + radius * math.sin(2 * math.pi * i / steps))
              for i in range(laps * steps + 1)]
    return Scene("loop", spacing, speed, [(Line(points), 0)])


def walk(metres, side, spacing, speed, seed=1):
    """From one random place of a square to the next, no turn sharper than a radius of 12 m."""
    chance, middle = random.Random(seed), 30000
    x, y, heading, points = middle, middle, 0.0, []
    goal = (x, y)
    for _ in range(metres + 1):
        points.append((x, y))
        if math.hypot(goal[0] - x, goal[1] - y) < 30:
            goal = [middle + side * (chance.random() - 0.5) for _ in range(2)]
        turn = math.remainder(math.atan2(goal[1] - y, goal[0] - x) - heading, 2 * math.pi)
        heading += max(-1 / 12, min(1 / 12, turn))
        x, y = x + math.cos(heading), y + math.sin(heading)
    return Scene("walk", spacing, speed, [(Line(points), 0)], more="attributes: [dirt]\n")


def convoy(metres, spacing, speed, vehicles=8, apart=20):
    points = [(10000 + i, 40000 + 60 * math.sin(i / 150)) for i in range(0, metres + 1, 5)]
    line = Line(points)
    return Scene("convoy", spacing, speed, [(line, apart * i) for i in range(vehicles)])


def far_apart(metres, spacing, speed):
    first, second = Line([(5000, 6000), (5000 + metres * 0.8, 6000 + metres * 0.6)]), \
        Line([(52000, 47000), (52000 - metres * 0.28, 47000 + metres * 0.96)])
    return Scene("two apart", spacing, speed, [(first, 0), (second, 0)])


def adversary(slots, laps, spacing, speed):
    """Round and round on the seam of two rings of tiles that are four more than there are slots: LRU has
    just evicted whichever comes next. Of a rectangle of W x H tiles with round corners the ring outside has
    2 (W + H) tiles that are touched, the ring inside 2 (W + H) - 4."""
    tile, both, r = TILE * spacing, (slots + 8) // 4, 8
    wide, high = both // 2 * tile, (both - both // 2) * tile
    x0, y0 = (math.ceil(n / tile) * tile for n in (8000, 20000))
    corners = ((x0 + wide - r, y0 + r, -90), (x0 + wide - r, y0 + high - r, 0), (x0 + r, y0 + high - r, 90),
               (x0 + r, y0 + r, 180))
    lap = [(x + r * math.cos(math.radians(first + turn)), y + r * math.sin(math.radians(first + turn)))
           for x, y, first in corners for turn in range(0, 91, 10)]
    start = (x0 + tile / 2, y0)
    return Scene(f"adversary {slots}", spacing, speed, [(Line([start] + (lap + [start]) * laps), 0)])


VIEW = ("view: {size: [640, 360], camera: {chase: v0w0, back: 12, up: 5}, "
        "effects: [texture, fog, sky, skirts], images: 1}\n")


def scenes(slots, quick):
    """Those that are timed. Of each adversary, how many slots it is made for; of others None."""
    share = 0.2 if quick else 1
    found = [(straight("straight", 10000 * share, 0.0625, 25), None),
             (ring(2 if quick else 3, 700 if quick else 1180, 0.25, 30), None),
             (walk(int(30000 * share), 1500 if quick else 3000, 0.25, 20), None),
             (convoy(int(2500 * share), 0.125, 20), None),
             (far_apart(8000 * share, 0.125, 40), None)]
    for count in slots:
        if count <= 256 or not quick:
            found.append((adversary(count, 4 if count < 256 else 3 if count < 1024 else 2, 0.25, 30), count))
    return found


def picture(quick):
    return straight("picture", 100 if quick else 300, 0.125, 25, direction=(0.8, 0.6), more=VIEW)
