"""A six-wheeled rover in a world of its own, with a task: what the environments of furrow.gym are made of. It needs no gymnasium.

A terrain is written by `make_terrain`, and never changes afterwards. Each rover's world has its own overlay over it.
"""
import dataclasses
import math
import os
import pathlib
import tempfile
from typing import Any, Dict, Optional, Tuple, Union

import numpy as np

from furrow import _png
from furrow._library import Error, import_dem
from furrow._declarations import Status
from furrow._world import World

Path = Union[str, "os.PathLike[str]"]

MODEL = pathlib.Path(__file__).with_name("rover.xml")
WHEEL_RADIUS = 0.15  # m, of the model
# Where the wheels are, m ahead of and to the left of the middle: those of front and rear steer.
WHEELS = {f"{end}_{side}": (x, y) for side, y in (("left", 0.425), ("right", -0.425)) for end, x in (("front", 0.6), ("middle", 0.0), ("rear", -0.6))}
FASTEST = 1.0        # m/s: the speed that an action of 1 asks for
BEND = 0.8           # 1/m: the curvature that an action of 1 asks for
AHEAD = np.array([(x, y) for x in (0.8, 1.6, 2.4) for y in (-0.6, 0.0, 0.6)])  # m: where it looks at the ground, in its own axes
ACTIONS = 2
OBSERVATIONS = 40
BOUND = 10.0         # of each observation

# Rewards, for each step and at an end.
NEAR = 0.75          # m: the goal is reached
REACHED = 10.0
FAILED = -10.0
A_STEP = -0.01
LEANS = math.cos(math.radians(60))  # of the upright axis, upward: below it the rover is overturned


@dataclasses.dataclass(frozen=True)
class Task:
    """A terrain and where the rover begins, and how far its goals are. Lengths in m, angles in rad."""

    size: Tuple[float, float]       # of the terrain, east and north
    plain: float                    # its height
    bump: Tuple[float, float, float, float]  # a round hill, or a pit: x, y, radius, and height or -depth
    start: Tuple[float, float]
    yaw: float
    goals: Tuple[float, float]      # least and most distance of goals from the start
    bearings: Tuple[float, float]   # least and most direction of goals from the start, from east to north
    heaps: int                      # heaps of loose sand
    heap_places: Tuple[float, float]  # least and most distance of heaps from the start
    soil: str
    gravity: float                  # m/s2
    body: str                       # what pictures show


# The hill's steepest slope and the pit's are 9 degrees.
HILL = Task((32.0, 24.0), 1.0, (16.0, 12.0, 8.0, 0.8), (6.0, 12.0), 0.0, (17.0, 22.0), (-0.35, 0.35), 0, (0.0, 0.0), "lunar", 1.62, "moon")
PIT = Task((24.0, 24.0), 2.0, (12.0, 12.0, 4.0, -0.4), (12.0, 12.0), 0.0, (5.0, 6.0), (-math.pi, math.pi), 2, (1.8, 3.2), "dry_sand", 3.71, "mars")
TASKS = {"hill": HILL, "pit": PIT}
SPACING = 0.2  # m, of the terrain's posts
HEAP = (0.5, 0.12)  # m: radius and height of a heap


def _bump(x: Any, y: Any, bump: Tuple[float, float, float, float]) -> "np.ndarray":
    """h (1 - r2/R2)2: its height, its slope and its rim are even. Sums and products alone, so it is the same on every machine."""
    inside = np.maximum(1 - ((x - bump[0]) ** 2 + (y - bump[1]) ** 2) / bump[2] ** 2, 0)
    return bump[3] * inside * inside


def make_terrain(kind: str, store: Path) -> None:
    """Writes the terrain of a task as a store: "hill" or "pit". A file that is there is not replaced."""
    if kind not in TASKS:
        raise ValueError(f"furrow: {kind!r} is no terrain; give one of {', '.join(TASKS)}")
    task = TASKS[kind]
    x, y = (SPACING * np.arange(round(side / SPACING) + 1) for side in task.size)
    heights = task.plain + _bump(x[None, :], y[:, None], task.bump)
    top = 4.0
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / f"{kind}.png"
        picture.write_bytes(_png.grey16(np.rint(heights[::-1] * (65535 / top))))  # a picture's first row is the northernmost
        import_dem(picture, store, spacing=SPACING, height_range=f"0,{top:g}", tile=64)


def scene_of(kind: str, pictures: bool, **settings: Any) -> Dict[str, Any]:
    """The scene of a task. pictures: it has a view, which takes memory. settings: keys of a scene that replace its own, such as gravity=9.81, soil={"name": "clayey_38"}.

    Faces are off: soil bears the wheels from below alone. With redistribute={"model": "scm"} it also pushes from the sides, at many times the cost.
    """
    task = TASKS[kind]
    scene: Dict[str, Any] = {
        "time_step": 0.002, "spacing": 0.05, "gravity": task.gravity, "soil": {"name": task.soil}, "redistribute": {"model": "scm", "faces": "off"},
        "vehicles": [{"name": "rover", "model": str(MODEL), "start": {"at": list(task.start), "yaw": math.degrees(task.yaw)},
                      "no_soil": ["mast", "panels"]}],  # an episode ends before they touch
        "cache": {"slots": 64, "loaders": 0},
    }
    if pictures:
        scene["view"] = {"effects": ["texture", "detail", "objects", "shadow"], "body": task.body}
    return {**scene, **settings}


class Rover:
    """One world with a rover and its task. `begin` starts an episode, `act` and `look` make a step of it.

    act: the library alone works in it, without Python's lock, so several threads may move several rovers at once.
    kind: "hill" or "pit". store: its terrain. overlay: a new file, for its ruts. steps: time steps of an action. settings: as of scene_of.
    pictures: `picture` will be called.
    """

    def __init__(self, kind: str, store: Path, overlay: Path, steps: int, settings: Optional[Dict[str, Any]] = None,
                 pictures: bool = False) -> None:
        self.task, self.steps = TASKS[kind], steps
        self.world = World(scene_of(kind, pictures, **(settings or {})), store=store, overlay=overlay)
        self.vehicle = self.world.vehicle("rover")
        info = self.world.info
        self.time_step, self.spacing, self.extent = info.time_step, info.spacing, info.extent
        names = self.vehicle.actuator_names
        self._steer = [(names.index(f"steer_{name}"), *place) for name, place in WHEELS.items() if place[0] != 0]
        self._drive = [(names.index(f"drive_{name}"), *place) for name, place in WHEELS.items()]
        self._controls = np.zeros(len(names))
        joints, geoms = self.vehicle.joint_names, list(self.vehicle.bodies)
        self._steers = [joints.index(f"steer_{name}") for name, place in WHEELS.items() if place[0] != 0]
        self._rolls = [joints.index(f"roll_{name}") for name in WHEELS]
        self._wheels = [geoms.index(f"wheel_{name}") for name in WHEELS]
        self.goal = np.zeros(3)
        self.action = np.zeros(ACTIONS)
        self.distance = 0.0
        self.failure: Optional[str] = None  # what the library said when a step failed

    def begin(self, random: "np.random.Generator", goal: Any = None) -> "np.ndarray":
        """Takes the world back to its opening and begins an episode. goal: (2,), m; None: drawn from random. Returns the observation."""
        self.world.rollback()
        task = self.task
        distance, bearing = random.uniform(*task.goals), random.uniform(*task.bearings)
        at = np.array(task.start) + distance * np.array([math.cos(bearing), math.sin(bearing)])
        for _ in range(task.heaps):
            self._pour_heap(random.uniform(*task.heap_places), random.uniform(-math.pi, math.pi))
        if goal is not None:
            at = np.asarray(goal, dtype=float)
            if at.shape != (2,) or not ((at >= 0) & (at <= self.extent)).all():
                raise ValueError(f"furrow: the goal {goal} is not on the terrain; give x and y from 0 to {self.extent[0]:g} and {self.extent[1]:g} m")
        self.goal[:2] = at
        self.goal[2] = self.world.points(at)["height"]
        self.action[:] = 0
        self._set_controls()
        self.failure = None
        observation = self._observe()
        return observation

    def _pour_heap(self, distance: float, bearing: float) -> None:
        radius, height = HEAP
        place = np.array(self.task.start) + distance * np.array([math.cos(bearing), math.sin(bearing)])
        column, row = np.rint((place - radius) / self.spacing).astype(int)
        posts = self.spacing * np.arange(round(2 * radius / self.spacing) + 1) - radius
        self.world.pour(_bump(posts[None, :], posts[:, None], (0.0, 0.0, radius, height)), column=int(column), row=int(row))

    def _set_controls(self) -> None:
        speed, bend = FASTEST * self.action[0], BEND * self.action[1]
        for index, x, y in self._steer:
            self._controls[index] = math.atan2(bend * x, 1 - bend * y)
        for index, x, y in self._drive:
            self._controls[index] = speed * math.hypot(bend * x, 1 - bend * y) / WHEEL_RADIUS
        self.vehicle.set_controls(self._controls)

    def act(self, action: Any) -> None:
        """Moves on by the time of an action. action: (2,): speed and curvature, each -1 .. 1; clipped to that."""
        self.action[:] = np.clip(np.nan_to_num(np.asarray(action, dtype=float)), -1, 1)
        self._set_controls()
        try:
            self.world.step(self.steps * self.time_step)
        except Error as error:
            if error.status != Status.FAILED and error.status != Status.INPUT:
                raise
            self.failure = str(error)

    def look(self) -> "Tuple[np.ndarray, float, bool, Dict[str, Any]]":
        """What the last action came to: observation, reward, whether the episode has ended there, and more of it."""
        before = self.distance
        observation = self._observe()
        reached = self.distance < NEAR
        overturned = self.up < LEANS
        ended = reached or overturned or self.failure is not None
        reward = (before - self.distance if self.failure is None else 0.0) + A_STEP
        if ended:
            reward += REACHED if reached else FAILED
        info = {"distance": self.distance, "reached": reached, "overturned": overturned, "failure": self.failure or ""}
        return observation, reward, ended, info

    def _observe(self) -> "np.ndarray":
        if self.failure is not None:
            return self.observation.copy()  # a world whose step failed tells nothing new
        pose = self.vehicle.state
        position, (w, x, y, z) = pose.position, pose.orientation
        # Its axes in the world's.
        axes = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                         [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                         [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]])
        self.position, self.heading, self.up = position, math.atan2(axes[0, 1], axes[0, 0]), float(axes[2, 2])
        to = self.goal - position
        self.distance = math.hypot(to[0], to[1])
        c, s = math.cos(self.heading), math.sin(self.heading)
        along, left = c * to[0] + s * to[1], c * to[1] - s * to[0]
        by = 1 / max(self.distance, 1e-9)
        angles, rates = self.vehicle.get_joints()
        contacts = self.vehicle.get_contacts()
        places = AHEAD @ np.array([[c, s], [-s, c]]) + position[:2]
        heights = self.world.points(places)["height"] - position[2]
        found = np.concatenate([
            (self.distance / 10, along * by, left * by, to[2]), axes[:, 2], axes @ pose.velocity, axes @ pose.angular,
            angles[self._steers], rates[self._rolls] * WHEEL_RADIUS, 10 * contacts["sinkage"][self._wheels], heights, self.action])
        self.observation = np.clip(np.nan_to_num(found), -BOUND, BOUND).astype(np.float32)
        return self.observation.copy()

    def picture(self, size: Tuple[int, int]) -> "np.ndarray":
        """(height, width, 3) uint8: the rover from behind, and a red pole at its goal. size: width, height."""
        back = np.array([math.cos(self.heading), math.sin(self.heading), 0.0])
        eye = self.position - 3.2 * back
        ground = self.world.points(eye[:2])["height"]
        eye[2] = np.fmax(self.position[2] + 1.6, ground + 1.0)
        fovy = 1.0
        target = self.position + 1.2 * back
        rgb, depth = self.world.render(eye, look_at=target, fovy=fovy, size=size)
        _draw_pole(rgb, depth, eye, target - eye, fovy, self.goal)
        return rgb

    def close(self) -> None:
        """Leaves the world as it was opened, and frees it."""
        try:
            self.world.rollback()
        except Error:
            pass  # closing says what is wrong
        self.world.close()


def _draw_pole(rgb: "np.ndarray", depth: "np.ndarray", eye: "np.ndarray", look: "np.ndarray", fovy: float, goal: "np.ndarray") -> None:
    """Draws a pole of 2 m where nothing hides it."""
    height, width = depth.shape
    ahead = look / np.linalg.norm(look)
    right = np.array([ahead[1], -ahead[0], 0.0]) / math.hypot(ahead[0], ahead[1])
    up = np.cross(right, ahead)
    pole = goal + np.linspace(0, 2, 400)[:, None] * np.array([0.0, 0.0, 1.0]) - eye
    far = pole @ ahead
    pixels = height / 2 / math.tan(fovy / 2)
    for at, beyond in zip(pole[far > 0.1], far[far > 0.1]):
        column, row = width / 2 + pixels * (at @ right) / beyond, height / 2 - pixels * (at @ up) / beyond
        half = max(pixels * 0.04 / beyond, 0.5)
        left, end = int(max(math.floor(column - half), 0)), int(min(math.ceil(column + half), width))
        if 0 <= row < height and left < end:
            line = int(row)
            seen = depth[line, left:end] > beyond
            rgb[line, left:end][seen] = (220, 30, 30)
