#!/usr/bin/env python3
"""How fast the environments of furrow.gym step, beside the same model on MuJoCo's own plane, in one run.

    PYTHONPATH=build/python FURROW_LIBRARY=build/src/libfurrow.so.0 python3 bench/gym_envs.py [--envs 16] [--steps 20000] [--runs 5]

Needs gymnasium, and MuJoCo's Python package for what stands beside. Both have the same number of worlds, threads and time steps of 2 ms, and take turns. A
step is a time step of one world. The ratio of times of the processor tells more than that of wall times while the machine is busy.
Told, too: memory of an environment, how it grows over the run, and what a reset takes. Beside each figure stands what is asked, and whether this run meets it.

--flat N drives one environment for N time steps in place of all that, with episodes of 800 actions, and tells its memory ten times.
"""
import argparse
import gc
import os
import pathlib
import resource
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import furrow.gym
from furrow import _rover
import pages
import record

ROOT = pathlib.Path(__file__).resolve().parents[1]
SKIP = 25  # time steps of an action
EPISODE = 800  # actions
ASKED = {"steps_a_second": 10000, "share": 0.25, "reset": 5, "memory": 40}  # at least, at least; ms and MB at most


def held():
    """MB of this process in memory."""
    gc.collect()
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


class Furrow:
    """The environments. drive: a steady turn, all wheels on."""

    def __init__(self, envs, threads, settings):
        before = held()
        self.envs = furrow.gym.DriveToGoalVector(envs, threads=threads, frame_skip=SKIP, **settings)
        self.envs.reset(seed=1)
        self.actions = np.tile(np.array([1.0, 0.3], np.float32), (envs, 1))
        self.move(1)
        self.memory = (held() - before) / envs

    def move(self, actions):
        for _ in range(actions):
            self.envs.step(self.actions)

    def resets(self, count):
        """ms of the processor, and by the clock, of each of some resets after a drive of 0.2 s."""
        found = []
        random = np.random.default_rng(1)
        for _ in range(count):
            rover = self.envs.rovers[0]
            for _ in range(4):
                rover.act((1, 0.3))
            began, used = time.perf_counter(), time.thread_time()
            rover.begin(random)
            found.append(((time.thread_time() - used) * 1e3, (time.perf_counter() - began) * 1e3))
        return [row[0] for row in found], [row[1] for row in found]


class Plane:
    """The same model on MuJoCo's plane, with the scene's gravity. Its rims run as fast, and it goes straight ahead, where the environments turn."""

    def __init__(self, envs, threads):
        import mujoco
        text = (ROOT / "tools/scenes/vehicles/rover.xml").read_text(encoding="utf-8")
        floor = '<worldbody><geom name="floor" type="plane" size="0 0 1" contype="1" conaffinity="1" friction="0.8 0.005 0.0001"/>'
        model = mujoco.MjModel.from_xml_string(text.replace("<worldbody>", floor))
        model.opt.gravity[:] = (0, 0, -1.62)
        self.step, self.model, self.pool = mujoco.mj_step, model, ThreadPoolExecutor(threads)
        self.data = [mujoco.MjData(model) for _ in range(envs)]
        for data in self.data:
            mujoco.mj_step(model, data, 1000)  # it comes to rest
            data.ctrl[4:] = _rover.FASTEST / _rover.WHEEL_RADIUS

    def move(self, actions):
        for _ in range(actions):
            list(self.pool.map(lambda data: self.step(self.model, data, SKIP), self.data))


def speed(mover, envs, actions):
    """Steps a second by the clock, and us of the processor for a step."""
    began, used = time.perf_counter(), time.process_time()
    mover.move(actions)
    steps = actions * SKIP * envs
    return steps / (time.perf_counter() - began), (time.process_time() - used) / steps * 1e6


def met(is_met):
    return "met" if is_met else "NOT met"


def flat(steps, kept):
    """Drives one environment, and tells its memory."""
    envs = furrow.gym.DriveToGoalVector(1, threads=1, frame_skip=SKIP, max_episode_steps=EPISODE)
    envs.reset(seed=1)
    random = np.random.default_rng(1)
    memory, actions = [], max(steps // SKIP // 10, 1)
    for part in range(10):
        for index in range(actions):
            if index % 20 == 0:
                action = random.uniform((0.3, -0.6), (1, 1), (1, 2)).astype(np.float32)
            envs.step(action)
        memory.append(held())
        print("%8d time steps: %.1f MB" % ((part + 1) * actions * SKIP, memory[-1]), flush=True)
    grew = memory[-1] - memory[0]
    kept.add("flat.steps", 10 * actions * SKIP, "")
    kept.add("flat.grew", grew, "MB")
    print("from the first tenth to the last it grew by %.1f MB" % grew)
    envs.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--steps", type=int, default=20000, help="time steps of all environments in a run")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--faces", choices=["off", "on"], default="off", help="on: soil also presses from the sides")
    parser.add_argument("--flat", type=int, metavar="N", help="drive one environment for N time steps, and tell its memory")
    record.add_option(parser)
    options = parser.parse_args()
    kept = record.Record("gym_envs" if options.flat is None else "gym_flat", os.environ.get("FURROW_LIBRARY"))
    if options.flat is not None:
        flat(options.flat, kept)
        kept.write(options.figures)
        return
    own = Furrow(options.envs, options.threads, {"redistribute": {"model": "scm", "faces": options.faces}})
    try:
        beside = Plane(options.envs, options.threads)
    except ImportError:
        beside = None
        print("MuJoCo's plane is left out: the Python package mujoco is not installed", flush=True)
    actions = max(options.steps // (SKIP * options.envs), 1)
    began = held()
    found = {"furrow": [], "plane": []}
    for _ in range(options.runs):
        found["furrow"].append(speed(own, options.envs, actions))
        if beside is not None:
            found["plane"].append(speed(beside, options.envs, actions))
    grew = held() - began
    for name, rows in found.items():
        if rows:
            kept.add(f"{name}.steps_a_second", [row[0] for row in rows], "")
            kept.add(f"{name}.us_a_step", [row[1] for row in rows], "us")
            print("%-7s %8.0f steps/s, %7.1f us of the processor a step" % (name, np.median([row[0] for row in rows]), np.median([row[1] for row in rows])))
    fastest = np.median([row[0] for row in found["furrow"]])
    print("asked: %d steps/s, %s" % (ASKED["steps_a_second"], met(fastest >= ASKED["steps_a_second"])))
    if beside is not None:
        shares = [b[1] / a[1] for a, b in zip(found["furrow"], found["plane"])]
        kept.add("share_of_plane", shares, "")
        print("a step on soil is %.3f times as fast as on MuJoCo's plane (by time of the processor), from %.3f to %.3f; asked: %g, %s" %
              (np.median(shares), min(shares), max(shares), ASKED["share"], met(np.median(shares) >= ASKED["share"])))
    used, waited = own.resets(20)
    kept.add("memory", own.memory, "MB")
    kept.add("grew", grew, "MB")
    kept.add("reset.processor", used, "ms")
    kept.add("reset.clock", waited, "ms")
    print("memory of an environment: %.1f MB; all %d grew by %.1f MB over %d steps; asked: %g MB, %s" %
          (own.memory, options.envs, grew, actions * SKIP * options.envs * options.runs, ASKED["memory"], met(own.memory + grew / options.envs < ASKED["memory"])))
    print("reset: %.2f ms of the processor (at most %.2f), %.2f ms by the clock; asked: %g ms, %s" %
          (np.median(used), max(used), np.median(waited), ASKED["reset"], met(np.median(used) < ASKED["reset"])))
    own.envs.close()
    kept.write(options.figures)


if __name__ == "__main__":
    sys.exit(pages.main(main))
