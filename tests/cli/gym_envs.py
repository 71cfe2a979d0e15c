"""furrow.gym: episodes repeat to the bit, in another process, too; resets go back by rollback; what ends an episode. Where the package gymnasium is, its own
checker passes both environments, and vectors of them do what single ones do, to the bit, for any number of threads."""
import hashlib
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import BUILT, LIBRARY, need_vehicles, use_package

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/GYM.md"
ACTIONS = [(1, 0.5), (1, -1), (-0.5, 0.2), (0.3, 1)]
EPISODE = """import hashlib, sys
import numpy as np
from furrow import _rover
rover = _rover.Rover("pit", sys.argv[1], sys.argv[2], 5)
found = [rover.begin(np.random.default_rng(7))]
for action in %r:
    rover.act(action)
    found.append(rover.look()[0])
print(hashlib.sha256(np.array(found).tobytes()).hexdigest())
rover.close()
""" % ACTIONS


def environment():
    return {**os.environ, "PYTHONPATH": str(BUILT), "FURROW_LIBRARY": LIBRARY}


def python(text, *arguments):
    return subprocess.run([sys.executable, "-c", text, *map(str, arguments)], env=environment(), capture_output=True, text=True)


class GymTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_package()
        need_vehicles()
        from furrow import _rover
        cls.rovers = _rover
        cls.held = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.held.name)
        for kind in _rover.TASKS:
            _rover.make_terrain(kind, cls.folder / f"{kind}.furrow")
        cls.before = {path: path.read_bytes() for path in cls.folder.iterdir()}

    @classmethod
    def tearDownClass(cls):
        cls.held.cleanup()

    def rover(self, kind, name, **settings):
        rover = self.rovers.Rover(kind, self.folder / f"{kind}.furrow", self.folder / f"{name}.ruts.furrow", 5, settings)
        self.addCleanup(rover.close)
        return rover


class Rovers(GymTest):
    def episode(self, rover, seed):
        found = [rover.begin(np.random.default_rng(seed))]
        for action in ACTIONS:
            rover.act(action)
            found.append(rover.look()[0])
        return np.array(found)

    def test_an_episode_repeats_to_the_bit(self):
        rover = self.rover("pit", "repeats")
        first = self.episode(rover, 7)
        ground = rover.world.read("surface", x=8, y=8, width=8, height=8)
        other = self.episode(rover, 8)
        again = self.episode(rover, 7)
        self.assertEqual(first.tobytes(), again.tobytes())
        self.assertEqual(ground.tobytes(), rover.world.read("surface", x=8, y=8, width=8, height=8).tobytes())
        self.assertNotEqual(first.tobytes(), other.tobytes())
        self.assertTrue((np.abs(first) <= self.rovers.BOUND).all())
        self.assertGreater(first[-1, 17:23].max(), 0.05, "the wheels turn")
        done = python(EPISODE, self.folder / "pit.furrow", self.folder / "process.furrow")
        self.assertEqual((done.stdout.strip(), done.stderr), (hashlib.sha256(first.tobytes()).hexdigest(), ""))

    def test_a_reset_leaves_no_rut_and_no_heap(self):
        rover = self.rover("pit", "resets")
        opened = self.offsets(rover)
        rover.begin(np.random.default_rng(1))
        poured = self.offsets(rover)
        self.assertAlmostEqual(poured.max(), self.rovers.HEAP[1], delta=0.01)
        rover.act((1, 0))
        self.assertNotEqual(self.offsets(rover).tobytes(), poured.tobytes())
        rover.begin(np.random.default_rng(1))
        self.assertEqual(self.offsets(rover).tobytes(), poured.tobytes())
        rover.world.rollback()
        self.assertEqual(self.offsets(rover).tobytes(), opened.tobytes())
        self.assertEqual(rover.world.time, 0)

    @staticmethod
    def offsets(rover):
        return rover.world.read("offset", x=8, y=8, width=8, height=8)

    def test_the_terrain_stays_as_it_is(self):
        rover = self.rover("hill", "looks")
        rover.begin(np.random.default_rng(1))
        rover.act((1, 0))
        rover.world.checkpoint()
        for path, content in self.before.items():
            self.assertEqual(path.read_bytes(), content, path)

    def test_where_it_ends(self):
        rover = self.rover("hill", "ends")
        start = np.array(rover.task.start)
        rover.begin(np.random.default_rng(1), goal=start + (0.7, 0))
        rover.act((0, 0))
        observation, reward, ended, info = rover.look()
        self.assertTrue(ended and info["reached"])
        self.assertAlmostEqual(reward, self.rovers.REACHED + self.rovers.A_STEP, delta=0.01)
        self.assertAlmostEqual(observation[0], 0.07, delta=0.01)
        rover.begin(np.random.default_rng(1))
        rover.act((0, 0))
        self.assertFalse(rover.look()[2])
        for goal in ((-1, 3), (3, 1e9), (np.nan, 3), (1, 2, 3)):
            with self.assertRaisesRegex(ValueError, "is not on the terrain; give x and y from 0 to 32 and 24 m"):
                rover.begin(np.random.default_rng(1), goal=goal)

    def test_what_leaves_the_terrain_has_failed(self):
        task = {"name": "rover", "model": str(self.rovers.MODEL), "start": {"at": [31.0, 12], "yaw": 0}}
        rover = self.rover("hill", "leaves", vehicles=[task])
        rover.begin(np.random.default_rng(1))
        for _ in range(400):
            rover.act((1, 0))
            observation, reward, ended, info = rover.look()
            if ended:
                break
        self.assertIn("rover", info["failure"])
        self.assertEqual(reward, self.rovers.FAILED + self.rovers.A_STEP)
        self.assertTrue(np.isfinite(observation).all())
        rover.begin(np.random.default_rng(1))
        rover.act((0, 0))
        self.assertFalse(rover.look()[2], "the next episode begins as if nothing had been")

    def test_no_gymnasium_is_told_in_one_line(self):
        done = python("import sys; sys.modules['gymnasium'] = None; import furrow.gym")
        self.assertEqual(done.returncode, 1)
        self.assertIn("ImportError: furrow.gym: the Python package gymnasium is not installed for", done.stderr.splitlines()[-1])
        self.assertNotIn("During handling", done.stderr)

    def test_an_old_gymnasium_is_told_in_one_line(self):
        done = python("import sys, types; old = types.ModuleType('gymnasium'); old.__version__ = '1.0.0'; old.vector = types.SimpleNamespace(); "
                      "sys.modules['gymnasium'] = old; import furrow.gym")
        self.assertEqual(done.returncode, 1)
        self.assertIn("ImportError: furrow.gym: gymnasium 1.0.0 is too old; install one from 1.1 on", done.stderr.splitlines()[-1])

    def test_arguments(self):
        with self.assertRaisesRegex(ValueError, "'valley' is no terrain; give one of hill, pit"):
            self.rovers.make_terrain("valley", self.folder / "valley.furrow")
        vehicle = self.rover("hill", "arguments").vehicle
        with self.assertRaisesRegex(ValueError, r"controls has the shape \(3,\); it must be \(10,\)"):
            vehicle.set_controls([1, 2, 3])
        vehicle.set_controls(np.arange(10) / 100)
        vehicle.world.step()
        self.assertEqual([round(control, 6) for control, _ in vehicle.actuators.values()], [n / 100 for n in range(10)])
        values, rates = vehicle.get_joints()
        self.assertEqual(list(zip(values.tolist(), rates.tolist())), list(vehicle.joints.values()))
        self.assertEqual([contact["force"].tolist() for contact in vehicle.get_contacts()], [body.contact.force.tolist() for body in vehicle.bodies.values()])


@unittest.skipUnless(importlib.util.find_spec("gymnasium"), "not on this machine: the Python package gymnasium is not installed")
class Environments(GymTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        global gymnasium
        import gymnasium
        import furrow.gym
        cls.names = list(furrow.gym.LONGEST)

    def test_gymnasium_checks_them(self):
        from gymnasium.utils.env_checker import check_env
        for name in self.names:
            with self.subTest(name), warnings.catch_warnings():
                warnings.simplefilter("error")
                env = gymnasium.make(name, render_mode="rgb_array", size=(64, 48), frame_skip=2)
                check_env(env.unwrapped)
                env.reset(seed=1)
                picture = env.render()
                self.assertEqual((picture.shape, picture.dtype), ((48, 64, 3), np.uint8))
                self.assertGreater(picture.std(), 10)
                env.close()

    def run_vector(self, actions, **more):
        envs = gymnasium.make_vec("furrow/SandPit-v0", num_envs=3, max_episode_steps=3, frame_skip=5, store=self.folder / "pit.furrow", **more)
        found = [[envs.reset(seed=5)[0]]]
        for action in actions:
            found.append(list(envs.step(action)[:4]))
        envs.close()
        return found

    def test_a_vector_is_single_ones_to_the_bit(self):
        random = np.random.default_rng(1)
        actions = random.uniform(-1, 1, (6, 3, 2)).astype(np.float32)
        own = self.run_vector(actions, threads=3)
        alone = self.run_vector(actions, threads=1)
        gymnasiums = self.run_vector(actions, vectorization_mode="sync")
        for other in (alone, gymnasiums):
            for mine, theirs in zip(own, other):
                for a, b in zip(mine, theirs):
                    self.assertEqual(np.asarray(a, dtype=float).tobytes(), np.asarray(b, dtype=float).tobytes())
        self.assertEqual([step[3].tolist() for step in own[1:]], [[done] * 3 for done in (False, False, True, False, False, False)])

    def test_the_page_s_processes(self):
        blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
        text = next(block for block in blocks if '"async"' in block).replace("num_envs=8", "num_envs=2, frame_skip=1").replace("envs.close()", "print(observations.shape)\n    envs.close()")
        (self.folder / "processes.py").write_text(text, encoding="utf-8")
        (self.folder / "processes").mkdir()
        done = subprocess.run([sys.executable, self.folder / "processes.py"], env=environment(), cwd=self.folder / "processes", capture_output=True, text=True, timeout=300)
        self.assertEqual((done.returncode, done.stdout), (0, "(2, 40)\n"), done.stderr)

    def test_a_failure_waits_for_all(self):
        import threading
        envs = gymnasium.make_vec(self.names[1], num_envs=2, frame_skip=1, threads=2, store=self.folder / "pit.furrow")
        self.addCleanup(envs.close)
        vector, failed, ended = envs.unwrapped, threading.Event(), []

        def work(index):
            if index == 0:
                failed.set()
                raise ValueError("the first")
            failed.wait()
            time.sleep(0.3)
            ended.append(index)

        with self.assertRaisesRegex(ValueError, "the first"):
            vector._each(work)
        self.assertEqual(ended, [1])

    def test_arguments_and_files(self):
        before = set(pathlib.Path(tempfile.gettempdir()).glob("furrow-gym-*"))
        for wrong, says in (({"frame_skip": 0}, "frame_skip is 0"), ({"render_mode": "human"}, "there is no render_mode 'human'"), ({"soil": {"name": "cheese"}}, "cheese")):
            with self.assertRaisesRegex(Exception, says):
                gymnasium.make_vec(self.names[0], num_envs=2, **wrong)
        envs = gymnasium.make_vec(self.names[0], num_envs=2, frame_skip=1)
        with self.assertRaisesRegex(ValueError, "there are 3 seeds for 2 environments"):
            envs.reset(seed=[1, 2, 3])
        with self.assertRaisesRegex(ValueError, r"the shape \(2,\); it must be \(2, 2\)"):
            envs.step(np.zeros(2))
        same, _ = envs.reset(seed=[4, 4])
        self.assertEqual(same[0].tobytes(), same[1].tobytes())
        for seed in (np.int64(3), np.array([3, 4])):
            self.assertEqual(envs.reset(seed=seed)[0].tobytes(), envs.reset(seed=3)[0].tobytes())
        envs.close()
        envs.close()
        self.assertEqual(set(pathlib.Path(tempfile.gettempdir()).glob("furrow-gym-*")), before)


if __name__ == "__main__":
    unittest.main(verbosity=2)
