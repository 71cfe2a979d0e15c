"""A six-wheeled rover in a world of its own, with a task: what the environments of furrow.gym are made of. It needs no gymnasium.

A terrain is written by `make_terrain`, and never changes afterwards. Each rover's world has its own overlay over it.
"""
import ctypes
import dataclasses
import math
import os
import pathlib
import tempfile
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from furrow import _declarations, _png
from furrow._library import Error, import_dem
from furrow._declarations import Status
from furrow._world import CONTACT, POINT, World

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

VEHICLE = np.dtype(_declarations.furrow_vehicle_state)


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
    """One world with a rover and its task. `begin` starts an episode, `act` (`aim`, then `move`) and `look` make a step of it.

    move: the library alone works in it, without Python's lock, so several threads may move several rovers at once. `look` of several rovers reads
    them at once.
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
        joints, bodies = self.vehicle.joint_names, self.vehicle.bodies
        self._joints = len(joints)
        self._steers = [joints.index(f"steer_{name}") for name, place in WHEELS.items() if place[0] != 0]
        self._rolls = [joints.index(f"roll_{name}") for name in WHEELS]
        self._wheels = np.array([bodies[f"wheel_{name}"].handle for name in WHEELS], np.int32)
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
        _observe([self])
        return self.observation.copy()

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

    def aim(self, action: Any) -> None:
        """Sets the controls for the next `move`. action: (2,): speed and curvature, each -1 .. 1; clipped to that."""
        self.action[:] = np.clip(np.nan_to_num(np.asarray(action, dtype=float)), -1, 1)
        self._set_controls()

    def move(self) -> None:
        """Moves on by the time of an action."""
        try:
            self.world.step(self.steps * self.time_step)
        except Error as error:
            if error.status != Status.FAILED and error.status != Status.INPUT:
                raise
            self.failure = str(error)

    def act(self, action: Any) -> None:
        """Both. action: as of `aim`."""
        self.aim(action)
        self.move()

    def look(self) -> "Tuple[np.ndarray, float, bool, Dict[str, Any]]":
        """What the last action came to: observation, reward, whether the episode has ended there, and more of it."""
        return look([self])[0]

    def _read(self, state: "np.ndarray", joints: "np.ndarray", contacts: "np.ndarray") -> None:
        """state: (1,) of VEHICLE; joints: (2, joints): values and rates; contacts: (wheels,) of CONTACT."""
        call, handle = self.world._call, self.vehicle.handle  # pylint: disable=protected-access
        state["size"] = VEHICLE.itemsize
        call("furrow_vehicle_get", handle, ctypes.byref(_declarations.furrow_vehicle_state.from_buffer(state)))
        call("furrow_get_joints", handle, self._joints, joints[0].ctypes.data, joints[1].ctypes.data)
        call("furrow_get_contacts", len(self._wheels), self._wheels.ctypes.data, contacts.ctypes.data, CONTACT.itemsize)

    def picture(self, size: Tuple[int, int]) -> "np.ndarray":
        """(height, width, 3) uint8: the rover from behind, and a red pole at its goal. size: width, height."""
        back = np.array([*self.heading, 0.0])
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


def look(rovers: "Sequence[Rover]") -> "List[Tuple[np.ndarray, float, bool, Dict[str, Any]]]":
    """What `Rover.look` returns of each of several rovers of one task, to the bit: they are read at once, which is faster."""
    before = [rover.distance for rover in rovers]
    _observe([rover for rover in rovers if rover.failure is None])  # a world whose step failed tells nothing new
    found = []
    for rover, was in zip(rovers, before):
        reached, overturned = rover.distance < NEAR, rover.up < LEANS
        ended = reached or overturned or rover.failure is not None
        reward = (was - rover.distance if rover.failure is None else 0.0) + A_STEP
        if ended:
            reward += REACHED if reached else FAILED
        info = {"distance": rover.distance, "reached": reached, "overturned": overturned, "failure": rover.failure or ""}
        found.append((rover.observation.copy(), reward, ended, info))
    return found


def _observe(rovers: "Sequence[Rover]") -> None:
    """Sets observation, distance, position, heading and up of each of several rovers of one task.

    It has sums, products, quotients and roots alone: so how many rovers there are changes no bit.
    """
    if not rovers:
        return
    count, first = len(rovers), rovers[0]
    states, joints = np.zeros(count, VEHICLE), np.empty((count, 2, first._joints))  # pylint: disable=protected-access
    contacts, points = np.empty((count, len(WHEELS)), CONTACT), np.empty((count, len(AHEAD)), POINT)
    for index, rover in enumerate(rovers):
        rover._read(states[index:index + 1], joints[index], contacts[index])  # pylint: disable=protected-access
    state = states["state"]
    position, linear, angular = state["pose"]["position"], state["linear"], state["angular"]
    w, x, y, z = state["pose"]["orientation"].T
    # Its axes in the world's: [i][k] is number k of axis i.
    axes = ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
    level = np.sqrt(axes[0][0] * axes[0][0] + axes[0][1] * axes[0][1])
    up = level > 1e-9  # else its nose is straight up or down: it looks east
    by = 1 / np.where(up, level, 1)
    c, s = np.where(up, axes[0][0] * by, 1), np.where(up, axes[0][1] * by, 0)
    to = np.array([rover.goal for rover in rovers]) - position
    distance = np.sqrt(to[:, 0] * to[:, 0] + to[:, 1] * to[:, 1])
    near = 1 / np.maximum(distance, 1e-9)
    places = np.empty((count, len(AHEAD), 2))
    places[:, :, 0] = (c[:, None] * AHEAD[:, 0] - s[:, None] * AHEAD[:, 1]) + position[:, 0:1]
    places[:, :, 1] = (s[:, None] * AHEAD[:, 0] + c[:, None] * AHEAD[:, 1]) + position[:, 1:2]
    for index, rover in enumerate(rovers):
        rover.world._call("furrow_points", len(AHEAD), places[index].ctypes.data, points[index].ctypes.data)  # pylint: disable=protected-access
    found = np.empty((count, OBSERVATIONS))
    found[:, 0] = distance / 10
    found[:, 1] = (c * to[:, 0] + s * to[:, 1]) * near
    found[:, 2] = (c * to[:, 1] - s * to[:, 0]) * near
    found[:, 3] = to[:, 2]
    for k in range(3):
        found[:, 4 + k] = axes[k][2]
        for at, v in ((7, linear), (10, angular)):
            found[:, at + k] = axes[k][0] * v[:, 0] + axes[k][1] * v[:, 1] + axes[k][2] * v[:, 2]
    found[:, 13:17] = joints[:, 0, first._steers]  # pylint: disable=protected-access
    found[:, 17:23] = joints[:, 1, first._rolls] * WHEEL_RADIUS  # pylint: disable=protected-access
    found[:, 23:29] = 10 * contacts["sinkage"]
    found[:, 29:38] = points["height"] - position[:, 2:3]
    found[:, 38:40] = [rover.action for rover in rovers]
    observations = np.clip(np.nan_to_num(found), -BOUND, BOUND).astype(np.float32)
    for index, rover in enumerate(rovers):
        rover.observation, rover.distance, rover.up = observations[index], float(distance[index]), float(axes[2][2][index])
        rover.position, rover.heading = position[index], (float(c[index]), float(s[index]))


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
