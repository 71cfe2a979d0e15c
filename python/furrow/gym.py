"""Gymnasium environments on soil that gives way: a six-wheeled rover drives to a goal.

    import gymnasium, furrow.gym
    env = gymnasium.make("furrow/DriveToGoal-v0")                    # over a hill
    envs = gymnasium.make_vec("furrow/SandPit-v0", num_envs=16)      # out of a sand pit; 16 worlds over one terrain, on all cores

Both need MuJoCo 4 (docs/INSTALL.md) and the package gymnasium. docs/GYM.md has observations, actions, rewards and what they cost.
"""
import itertools
import operator
import os
import pathlib
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from furrow import _command, _rover
from furrow._library import Path
from furrow._rover import make_terrain

try:
    gymnasium: Any = _command.need("gymnasium", "gymnasium")
except _command.Missing as missing:
    raise ImportError(f"furrow.gym: {missing}") from None
if not hasattr(gymnasium.vector, "AutoresetMode"):
    raise ImportError(f"furrow.gym: gymnasium {gymnasium.__version__} is too old; install one from 1.1 on: pip install 'gymnasium>=1.1'")

__all__ = ["DriveToGoal", "DriveToGoalVector", "RoverEnv", "RoverVectorEnv", "SandPit", "SandPitVector", "make_terrain"]

FRAME_SKIP = 25  # time steps of an action: 50 ms
LONGEST = {"furrow/DriveToGoal-v0": 800, "furrow/SandPit-v0": 400}  # actions of an episode
PICTURE = (480, 360)


def _spaces() -> "Tuple[Any, Any]":
    observations = gymnasium.spaces.Box(-_rover.BOUND, _rover.BOUND, (_rover.OBSERVATIONS,), np.float32)
    return observations, gymnasium.spaces.Box(-1.0, 1.0, (_rover.ACTIONS,), np.float32)


class _Files:
    """The folder of overlays, and of the terrain if none was given. It is gone when it is closed, or nobody holds it."""

    def __init__(self, kind: str, store: Optional[Path]) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="furrow-gym-")
        self._count = itertools.count()
        if store is None:
            store = pathlib.Path(self._folder.name) / f"{kind}.furrow"
            make_terrain(kind, store)
        self.store = store

    def overlay(self) -> pathlib.Path:
        return pathlib.Path(self._folder.name) / f"{next(self._count)}.furrow"

    def close(self) -> None:
        self._folder.cleanup()


def _check_mode(render_mode: Optional[str]) -> Optional[str]:
    if render_mode not in (None, "rgb_array"):
        raise ValueError(f"furrow.gym: there is no render_mode {render_mode!r}; give 'rgb_array' or None")
    return render_mode


class RoverEnv(gymnasium.Env):
    """A rover on one of the terrains. DriveToGoal and SandPit are made of it.

    render_mode: None or "rgb_array". store: a terrain by make_terrain, which many environments and processes may share; None: one of its own.
    frame_skip: time steps of an action, 1 or more. size: width and height of pictures. settings: keys of the scene in place of the environment's.

    reset(seed) takes the ground and the rover back to where they were, bit by bit; options={"goal": (x, y)} sets the goal, in m.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}
    kind = "hill"

    def __init__(self, render_mode: Optional[str] = None, *, store: Optional[Path] = None, frame_skip: int = FRAME_SKIP,
                 size: Tuple[int, int] = PICTURE, **settings: Any) -> None:
        self.render_mode, self._size = _check_mode(render_mode), size
        self.observation_space, self.action_space = _spaces()
        self._files: Optional[_Files] = _Files(self.kind, store)
        self.rover = _rover.Rover(self.kind, self._files.store, self._files.overlay(), _whole(frame_skip, "frame_skip", 10000), settings, render_mode is not None)
        self.metadata = {**self.metadata, "render_fps": _frames(self.rover)}

    def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> "Tuple[np.ndarray, Dict[str, Any]]":
        super().reset(seed=seed)
        observation = self.rover.begin(self.np_random, (options or {}).get("goal"))
        return observation, {"distance": self.rover.distance}

    def step(self, action: Any) -> "Tuple[np.ndarray, float, bool, bool, Dict[str, Any]]":
        self.rover.act(action)
        observation, reward, ended, info = self.rover.look()
        return observation, reward, ended, False, info

    def render(self) -> "Optional[np.ndarray]":
        return self.rover.picture(self._size) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        if self._files is not None:
            self.rover.close()
            self._files.close()
            self._files = None


def _whole(value: Any, name: str, most: int) -> int:
    if not hasattr(value, "__index__") or not 1 <= operator.index(value) <= most:
        raise ValueError(f"furrow.gym: {name} is {value!r}; give a whole number from 1 to {most}")
    return operator.index(value)


def _frames(rover: _rover.Rover) -> int:
    return max(round(1 / (rover.steps * rover.time_step)), 1)


class DriveToGoal(RoverEnv):
    """Drive over a hill of lunar soil to a goal 17 to 22 m away."""

    kind = "hill"


class SandPit(RoverEnv):
    """Drive out of a pit of dry sand with loose heaps, to a goal on its rim in any direction."""

    kind = "pit"


class RoverVectorEnv(gymnasium.vector.VectorEnv):
    """Several rovers in one process, each in a world of its own over one terrain. `threads` move them at once.

    What it returns is what as many single environments would, to the bit, for any number of threads. An environment whose episode has ended begins the
    next one in the step after: gymnasium.vector.AutoresetMode.NEXT_STEP.

    num_envs: how many. max_episode_steps: actions after which an episode is truncated; None: never. threads: None: one for each core.
    Others: as of RoverEnv.
    """

    metadata: Dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20, "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}
    kind = "hill"

    def __init__(self, num_envs: int = 1, *, render_mode: Optional[str] = None, max_episode_steps: Optional[int] = None, store: Optional[Path] = None,
                 frame_skip: int = FRAME_SKIP, size: Tuple[int, int] = PICTURE, threads: Optional[int] = None, **settings: Any) -> None:
        self.rovers: List[Any] = []
        self.num_envs = num_envs = _whole(num_envs, "num_envs", 10000)
        self.render_mode, self._size, self._longest = _check_mode(render_mode), size, max_episode_steps
        steps = _whole(frame_skip, "frame_skip", 10000)
        self.single_observation_space, self.single_action_space = _spaces()
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self._files = _Files(self.kind, store)
        overlays = [self._files.overlay() for _ in range(num_envs)]
        self._threads = min(len(os.sched_getaffinity(0)) if threads is None else _whole(threads, "threads", 1000), num_envs)
        self._pool = ThreadPoolExecutor(self._threads) if self._threads > 1 else None
        self.rovers = [None] * num_envs
        self._randoms: "List[Optional[np.random.Generator]]" = [None] * num_envs

        def open_one(index: int) -> None:
            self.rovers[index] = _rover.Rover(self.kind, self._files.store, overlays[index], steps, settings, render_mode is not None)

        try:
            self._each(open_one)
        except BaseException:
            self.close()
            raise
        self.metadata = {**self.metadata, "render_fps": _frames(self.rovers[0])}
        self._ended = np.zeros(num_envs, bool)
        self._actions = np.zeros(num_envs, int)  # of each episode so far
        self._observations = np.zeros((num_envs, _rover.OBSERVATIONS), np.float32)

    def _each(self, work: Any) -> None:
        """Calls work(index) for all environments, on all threads. The first failure is raised when all have ended."""
        if self._pool is None:
            for index in range(self.num_envs):
                work(index)
            return
        indices, lock = iter(range(self.num_envs)), threading.Lock()

        def take() -> None:
            while True:
                with lock:
                    index = next(indices, None)
                if index is None:
                    return
                work(index)

        taken = [self._pool.submit(take) for _ in range(self._threads)]
        wait(taken)
        for done in taken:
            done.result()

    def _begin(self, index: int, goal: Any = None) -> Dict[str, Any]:
        random = self._randoms[index]
        if random is None:
            random = self._randoms[index] = gymnasium.utils.seeding.np_random()[0]
        self._observations[index] = self.rovers[index].begin(random, goal)
        self._ended[index], self._actions[index] = False, 0
        return {"distance": self.rovers[index].distance}

    def reset(self, *, seed: "Union[int, Sequence[Optional[int]], None]" = None,
              options: Optional[Dict[str, Any]] = None) -> "Tuple[np.ndarray, Dict[str, Any]]":
        """seed: of the first; the others have the numbers that follow. Or a list with one for each. options["goal"]: of all."""
        if isinstance(seed, (int, np.integer)):
            seed = range(int(seed), int(seed) + self.num_envs)
        seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"furrow.gym: there are {len(seeds)} seeds for {self.num_envs} environments; give one for each")
        for index, own in enumerate(seeds):
            if own is not None:
                self._randoms[index] = gymnasium.utils.seeding.np_random(operator.index(own))[0]
        found: List[Dict[str, Any]] = [{}] * self.num_envs

        def begin(index: int) -> None:
            found[index] = self._begin(index, (options or {}).get("goal"))

        self._each(begin)
        return self._observations.copy(), self._infos(found)

    def step(self, actions: Any) -> "Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Dict[str, Any]]":
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs, _rover.ACTIONS):
            raise ValueError(f"furrow.gym: actions have the shape {actions.shape}; it must be {(self.num_envs, _rover.ACTIONS)}")
        rewards, terminations = np.zeros(self.num_envs), np.zeros(self.num_envs, bool)
        begins = self._ended.copy()
        moves = np.flatnonzero(~begins).tolist()
        found: List[Dict[str, Any]] = [{}] * self.num_envs
        for index in moves:
            self.rovers[index].aim(actions[index])

        def move(index: int) -> None:
            if begins[index]:
                found[index] = self._begin(index)
            else:
                self.rovers[index].move()

        self._each(move)
        # What Python does is done for all at once: between the steps it would cost many times as much, since its code leaves the processor's caches.
        for index, (observation, reward, ended, info) in zip(moves, _rover.look([self.rovers[index] for index in moves])):
            self._observations[index], rewards[index], terminations[index], found[index] = observation, reward, ended, info
        self._actions[moves] += 1
        truncations = ~begins & (self._actions >= self._longest) if self._longest is not None else np.zeros(self.num_envs, bool)
        self._ended = terminations | truncations
        return self._observations.copy(), rewards, terminations, truncations, self._infos(found)

    def _infos(self, found: "List[Dict[str, Any]]") -> Dict[str, Any]:
        infos: Dict[str, Any] = {}
        for index, info in enumerate(found):
            infos = self._add_info(infos, info, index)
        return infos

    def render(self) -> "Optional[Tuple[np.ndarray, ...]]":
        return tuple(rover.picture(self._size) for rover in self.rovers) if self.render_mode == "rgb_array" else None

    def close_extras(self, **_: Any) -> None:
        """Called once by close()."""
        if not self.rovers:
            return  # it was never opened
        self._each(lambda index: self.rovers[index] and self.rovers[index].close())
        if self._pool is not None:
            self._pool.shutdown()
        self._files.close()


class DriveToGoalVector(RoverVectorEnv):
    """Several of DriveToGoal."""

    kind = "hill"


class SandPitVector(RoverVectorEnv):
    """Several of SandPit."""

    kind = "pit"


for _name, _longest in LONGEST.items():
    if _name not in gymnasium.registry:
        _class = _name.partition("/")[2].partition("-")[0]
        gymnasium.register(id=_name, entry_point=f"furrow.gym:{_class}", vector_entry_point=f"furrow.gym:{_class}Vector", max_episode_steps=_longest)
