"""The installed Python package. Each test is a script of its own, run by an interpreter that has numpy."""
import pathlib
import re
import signal
import subprocess
import textwrap
import unittest

import prefix

BEGIN = """
import ctypes, json, os, sys, threading
import numpy as np
import furrow
store, work = sys.argv[1], sys.argv[2]
SCENE = {"time_step": 0.01, "spacing": 0.125, "soil": {"name": "dry_sand"}, "redistribute": {"model": "scm"}}

def raises(kind, call, *arguments, **keys):
    try:
        call(*arguments, **keys)
    except kind as error:
        return error
    raise AssertionError(f"{call} raised nothing")

def refused(status, call, *arguments, **keys):
    error = raises(furrow.Error, call, *arguments, **keys)
    assert error.status == status, (error.status, str(error))
    assert ": " in str(error) and "; " in str(error), str(error)
    return str(error)

def rut(world, y=20):
    ball = world.add(shape={"sphere": {"radius": 0.5}})
    z = float(world.points([(20, y)])["height"][0])
    ball.place(position=(20, y, z + 0.5))
    for x in np.arange(20, 22, 0.1):
        ball.set(position=(x, y, z + 0.4))
        world.step()
    return ball
"""


class PythonPackageTest(unittest.TestCase):
    def script(self, text):
        path = prefix.work / f"{self.id().rsplit('.', 1)[1]}.py"
        path.write_text(BEGIN + textwrap.dedent(text))
        return path

    def run_script(self, text):
        store = prefix.synthesize("plain.furrow", "plain")
        model = pathlib.Path(__file__).resolve().parents[1] / "vehicle/one_wheel.xml"
        result = prefix.run_python(self.script(text), store, prefix.work, model, check=False)
        if "this build has no MuJoCo" in result.stderr:
            self.skipTest("there is no MuJoCo")
        if "OpenGL 4.5" in result.stderr and "NO_GL" in result.stderr:
            self.skipTest("there is no GL")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def test_a_vehicle_takes_controls(self):
        self.run_script("""
            scene = {**SCENE, "time_step": 0.002, "vehicles": [{"name": "cart", "model": sys.argv[3], "start": {"at": [10, 10]}}]}
            with furrow.World(scene, store=store, overlay=work + "/cart.furrow") as world:
                cart = world.vehicle("cart")
                assert cart.actuator_names == ("drive",) and cart.joint_names[3] == "turn", (cart.actuator_names, cart.joint_names)
                assert list(cart.bodies) == ["wheel"] and cart.state.mass == 100
                cart.set(drive=2)
                for _ in range(300):
                    world.step()
                wheel = cart.bodies["wheel"].contact
                assert wheel.slip > 0 and 800 < wheel.force[2] < 1200 and cart.joints["turn"][1] > 1.5, (wheel, cart.joints)
                assert cart.actuators["drive"][0] == 2 and cart.state.distance > 0.1, (cart.actuators, cart.state)
                assert "drive" in str(raises(ValueError, cart.set, drives=2))
                state, inner = cart.state, cart.state.state
                assert np.array_equal(state.position, inner.pose.position) and np.array_equal(state.orientation, inner.pose.orientation)
                assert np.array_equal(state.velocity, inner.linear) and np.array_equal(state.angular, inner.angular)
                assert state.position.shape == (3,) and state.position[0] > 10.1 and state.velocity[0] > 0.1, state
                assert np.array_equal(cart.bodies["wheel"].state.position, cart.bodies["wheel"].state.pose.position)
                cart.set(drive=None)
                world.step(0.004)
                assert cart.actuators["drive"][0] == 0
                assert cart.model_body_names == ("carriage", "wheel") and "carriage" in str(raises(ValueError, cart.push, "hull"))
                slow = cart.state.velocity[1]
                cart.push("carriage", force=[0, 500, 0])
                for _ in range(50):
                    world.step()
                cart.push("carriage")
                assert cart.state.velocity[1] > slow + 0.01, (slow, cart.state)
                refused(furrow.Status.INPUT, world.vehicle, "horse")
                refused(furrow.Status.USAGE, cart.bodies["wheel"].remove)
                world.rollback()
                assert cart.state.distance == 0 and world.time == 0
                rgb, depth = world.render(size=(64, 48))
        """)

    def test_a_belt_draws(self):
        self.run_script("""
            scene = {"spacing": 0.0625, "soil": {"name": "dry_sand"}, "redistribute": {"model": "scm"}}
            with furrow.World(scene, store=store, overlay=work + "/belt.furrow") as world:
                track = world.add(shape={"box": {"size": [1.2, 0.3, 0.5], "belt": True}})
                z = world.points([(50, 50)])["height"][0] + 0.2
                track.place(position=(50, 50, z))
                drawn = []
                travel = 0
                for speed in (1.25, 0.5):
                    for x in np.linspace(50, 51, 50) + len(drawn):
                        travel += speed * 0.02
                        track.run_belt(travel, speed)
                        track.set(position=(x, 50, z), linear=(1, 0, 0))
                        world.step(0.02)
                    drawn.append(track.contact.force[0])
                    assert abs(track.contact.slip - (1 - 1 / speed)) < 1e-9
                assert drawn[0] > 0 > drawn[1], drawn
                world.set_belts([track], [[travel, 1.0]])
                refused(furrow.Status.USAGE, world.add(shape={"sphere": {"radius": 1}}).run_belt, 0.0, 1.0)
            """)

    def test_the_example_of_the_page(self):
        self.run_script("""
            overlay = work + "/run1.furrow"
            scene = {"spacing": 0.0625, "soil": {"name": "lunar"}, "redistribute": {"model": "scm"}}
            with furrow.World(scene, store=store, overlay=overlay) as world:
                wheel = world.add(shape={"wheel": {"radius": 0.25, "width": 0.2}})
                z = world.points([(50, 50)])["height"][0] + 0.2
                wheel.place(position=(50, 50, z))
                for x in np.linspace(50, 52, 100):
                    wheel.set(position=(x, 50, z), orientation=(1, 0, 0, 0), linear=(1, 0, 0), angular=(0, 5, 0))
                    world.step(0.002)
                    f = wheel.contact.force
                assert f.shape == (3,) and f.dtype == np.float64 and f[2] > 0
                assert abs(world.time - 0.2) < 1e-9
                heights = world.points(np.array([[50, 50], [51, 51.0]]))["height"]
                assert heights.shape == (2,) and heights.dtype == np.float64
                rgb, depth = world.render(position=(48, 50, z + 2), orientation=(1, 0, 0, 0), fovy=1.0, size=(64, 48))
                assert rgb.shape == (48, 64, 3) and rgb.dtype == np.uint8
                assert "view" not in scene and rgb.mean() > 60  # the sun shines on it
                assert depth.shape == (48, 64) and depth.dtype == np.float32
                patch = world.read("offset", x=50, y=50, width=4, height=4)
                assert patch.shape == (65, 65) and patch.dtype == np.float64 and patch.min() < -0.01
            assert os.path.exists(overlay)
            assert "it is closed" in refused(furrow.Status.USAGE, world.step)
            world.close()
            """)

    def test_velocities_that_are_not_given_are_those_of_the_poses(self):
        self.run_script("""
            with furrow.World(SCENE, store=store, overlay=work + "/rolls.furrow") as world:
                wheels = [world.add(shape={"wheel": {"radius": 0.5, "width": 0.4}}) for _ in range(3)]
                z = [world.points([(20, 20 + 5 * i)])["height"][0] + 0.45 for i in range(3)]
                for i, wheel in enumerate(wheels):
                    wheel.place(position=(20, 20 + 5 * i, z[i]))
                speed, spin = 1.0, 2.5  # a slip of 0.2
                for step in range(1, 40):
                    turn = spin * step * 0.01 / 2
                    rolled = (np.cos(turn), 0, np.sin(turn), 0)
                    wheels[0].set((20 + speed * step * 0.01, 20, z[0]), rolled)
                    wheels[1].set((20 + speed * step * 0.01, 25, z[1]), rolled, (speed, 0, 0), (0, spin, 0))
                    wheels[2].set((20 + speed * step * 0.01, 30, z[2]), rolled, (speed, 0, 0), (0, 0, 0))
                    world.step()
                posed, given, locked = (wheel.contact for wheel in wheels)
                assert abs(posed.slip - 0.2) < 1e-3 and abs(given.slip - 0.2) < 1e-3, (posed.slip, given.slip)
                pulls = [contact.force[0] / contact.force[2] for contact in (posed, given, locked)]  # the ground under each is another
                assert pulls[0] > 0.1 and abs(pulls[0] - pulls[1]) < 0.03 and pulls[2] < -0.5, pulls
                assert np.allclose(wheels[0].state.velocity, (speed, 0, 0)) and np.allclose(wheels[0].state.angular, (0, spin, 0))
        """)

    def test_looking_changes_nothing(self):
        self.run_script("""
            import hashlib, pathlib
            overlay = pathlib.Path(work + "/looked.furrow")
            with furrow.World(SCENE, store=store, overlay=overlay) as world:
                rut(world)
            before = hashlib.sha256(overlay.read_bytes()).digest(), sorted(os.listdir(work))
            with furrow.World({"spacing": 0.125}, store=overlay) as world:
                world.read("offset", columns=10, rows=10)
            overlay.chmod(0o444)
            with furrow.World(SCENE, store=overlay, readonly=True) as world:
                ball = world.add(shape={"sphere": {"radius": 0.5}})
                assert world.points([(21, 20)])["offset"][0] < 0
                world.render(size=(64, 48))
                for call in (world.step, world.checkpoint, lambda: ball.place((20, 20, 9)), lambda: ball.set((20, 20, 9))):
                    assert "readonly" in refused(furrow.Status.USAGE, call)
            assert before == (hashlib.sha256(overlay.read_bytes()).digest(), sorted(os.listdir(work)))
            overlay.chmod(0o644)
            with furrow.World(SCENE, store=overlay, resume=True, readonly=True) as world:
                assert abs(world.time - 0.2) < 1e-9
        """)

    def test_arrays_are_not_copied(self):
        self.run_script("""
            from furrow import _world
            xy = np.zeros((5, 2))
            assert np.shares_memory(_world._array(xy, "xy", 2), xy)
            states = np.zeros(3, furrow.STATE)
            assert np.shares_memory(_world._structs(states, furrow.STATE, 3, "states"), states)
            with furrow.World(SCENE, store=store, overlay=work + "/copies.furrow") as world:
                ball = rut(world)
                contact = ball.contact
                assert np.shares_memory(contact.force, contact.force)
                # A window of a larger array is filled where it lies.
                whole = np.full((20, 30), -7.0)
                got = world.read("offset", column=160, row=155, columns=10, rows=10, out=whole[5:15, 8:18])
                assert np.shares_memory(got, whole)
                assert (whole[:5] == -7).all() and (whole[:, 18:] == -7).all() and whole[5:15, 8:18].min() < -0.01
                again = world.read("offset", column=160, row=155, columns=10, rows=10)
                assert (again == got).all()
                raises(ValueError, world.read, "offset", column=0, row=0, columns=4, rows=4, out=np.zeros((4, 8))[:, ::2])
                raises(ValueError, world.read, "offset", column=0, row=0, columns=4, rows=4, out=np.zeros((4, 4), np.float32))
                raises(ValueError, world.read, "offset", column=0, row=0, columns=4, rows=4, out=np.zeros((3, 4)))
                # Other layouts are taken, by a copy.
                points = world.points(np.array([[20, 20], [21, 20]], dtype=np.float32).T.copy().T)
                assert points["offset"].shape == (2,)
                grid = world.points(np.zeros((4, 3, 2)) + 20)
                assert grid.shape == (4, 3)
                raises(ValueError, world.points, np.zeros((4, 3)))
                hits = world.rays([(20, 20, 200), (21, 20, 200)], (0, 0, -1))
                assert hits["hit"].all() and hits["position"].shape == (2, 3)
                assert np.allclose(hits["position"][:, 2], points["height"])
            """)

    def test_pictures_need_no_view_and_no_camera(self):
        self.run_script("""
            from furrow import _world
            near = lambda a, b: np.allclose(a, b, atol=1e-9)
            with furrow.World(SCENE, store=store, overlay=work + "/looks.furrow") as world:
                # Nothing to look at: the whole terrain is in the picture, and sky at its sides.
                rgb, depth = world.render(size=(64, 48))
                middle = np.array([*world.info.extent, world.info.low + world.info.high]) / 2
                eye, target = world._overview(1.0, 64 / 48)
                assert near(target, middle) and abs(depth[24, 32] - np.linalg.norm(eye - middle)) < 0.1 * np.linalg.norm(eye - middle)
                assert np.isinf(depth[:, [0, -1]]).all() and np.isinf(depth[[0, -1]]).all() and np.isfinite(depth).mean() > 0.1
                ball = world.add(shape={"sphere": {"radius": 0.5}})
                raises(ValueError, world.render, look_at=ball)
                z = float(world.points([(20, 20)])["height"][0]) + 0.5
                ball.place((20, 20, z))
                # A body is seen from the south, as are places; it is in the picture.
                first = world.render(size=(64, 48))[1]
                assert abs(first[24, 32] - (6 ** 2 + 3 ** 2) ** 0.5 + 0.5) < 0.05, first[24, 32]
                assert (world.render(look_at=ball, size=(64, 48))[1] == first).all()
                assert (world.render(look_at=(20, 20, z), size=(64, 48))[1] == first).all()
                assert abs(world.render((20, 20, z + 4), look_at=ball, size=(9, 9))[1][4, 4] - 3.5) < 0.05
                assert near(_world._toward(np.zeros(3), np.array([3, 0, 0])), (1, 0, 0, 0))
                # Straight down, north is up: own x is down, own z north.
                w, x, y, z = _world._toward(np.array([0, 0, 5]), np.zeros(3))
                assert near([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], (0, 0, -1))
                assert near([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], (0, 1, 0))
                raises(ValueError, world.render, (0, 0, 0), (1, 0, 0, 0), look_at=ball)
                raises(ValueError, world.render, orientation=(1, 0, 0, 0))
            with furrow.World({**SCENE, "view": {"effects": ["sky"]}}, store=store, overlay=work + "/looks.furrow") as world:
                assert world.render(size=(64, 48))[0].shape == (48, 64, 3)
            """)

    def test_off_the_terrain_nothing_is_raised(self):
        self.run_script("""
            with furrow.World(SCENE, store=store, overlay=work + "/off.furrow") as world:
                point = world.points([(-5, 5)])[0]
                assert point["nodata"] and np.isnan([point["height"], point["offset"], *point["normal"]]).all()
                hit = world.rays([(-5, 5, 500)], (0, 0, -1))[0]
                assert not hit["hit"] and np.isnan([hit["distance"], *hit["position"], *hit["normal"]]).all()
                ball = world.add(shape={"sphere": {"radius": 0.5}})
                ball.place((-20, -20, 50))
                ball.set((-20, -20, 0))
                world.step()
                assert (ball.contact.force == 0).all() and ball.contact.state == furrow.ContactState.AIR
            """)

    def test_soil_is_poured_and_taken(self):
        self.run_script("""
            with furrow.World(SCENE, store=store, overlay=work + "/poured.furrow") as world:
                info = world.info
                heights = np.zeros((9, 12))
                heights[2:5, 3:7] = 0.25
                heights[6, 1] = -0.5
                world.pour(heights, column=80, row=90, loose=False)
                read = lambda: world.read("offset", column=80, row=90, columns=12, rows=9)
                assert (read() == heights).all()
                world.pour(heights.T[::2].T, x=80 * info.spacing, y=90 * info.spacing)  # every other column; rows need not be contiguous
                assert (read()[:, :6] == heights[:, :6] + heights[:, ::2]).all()
                world.pour_polygon([(20, 20), (24, 20), (22, 25)], 3.5)
                world.checkpoint()
                area = info.spacing ** 2
                assert abs(world.stats["volume"]["added"] - (heights.sum() + heights[:, ::2].sum()) * area - 3.5) < 1e-4
                raises(ValueError, world.pour, heights[0])
                raises(ValueError, world.pour, heights, x=3)
                raises(ValueError, world.pour_polygon, [1, 2, 3], 1)
                for wrong in (dict(column=-1), dict(soil=7)):
                    raises(furrow.Error, world.pour, heights, **wrong)
                world.rollback()
            """)

    def test_states_and_contacts_of_many(self):
        self.run_script("""
            with furrow.World(SCENE, store=store, overlay=work + "/many.furrow") as world:
                balls = [world.add(name=f"ball{i}", shape={"sphere": {"radius": 0.5}}) for i in range(4)]
                z = world.points([(10 + 5 * i, 10) for i in range(4)])["height"]
                for i, ball in enumerate(balls):
                    ball.place(position=(10 + 5 * i, 10, z[i] + 0.5))
                states = world.get_states(balls)
                states["pose"]["position"][:, 2] -= 0.1
                world.set_states(balls, states)
                world.step()
                contacts = world.get_contacts(balls)
                assert contacts["force"].shape == (4, 3) and (contacts["force"][:, 2] > 0).all()
                assert (contacts["state"] == furrow.ContactState.TOUCHING).all()
                assert (world.get_states(balls) == states).all()
                assert balls[2].contact.force[2] == contacts["force"][2, 2]
                assert balls[2].contact.state is furrow.ContactState.TOUCHING
                assert balls[2].state.pose.position[2] == states["pose"]["position"][2, 2]
                assert world.body("ball3").handle == balls[3].handle
                probed = world.probe(balls, states)
                assert (probed["state"] == furrow.ContactState.TOUCHING).all()
                assert probed["stiffness"].shape == (4, 6, 6) and (probed["stiffness"][:, 2, 2] < 0).all()
                assert np.allclose(probed["force"][:, 2], contacts["force"][:, 2], rtol=0.05)
                states["pose"]["position"][:, 0] += 5000  # off the terrain
                assert (world.probe(balls, states)["state"] == furrow.ContactState.UNKNOWN).all()
                states["pose"]["position"][:, 0] -= 5000
                raises(ValueError, world.set_states, balls, states[:3])
                balls[0].remove()
                refused(furrow.Status.USAGE, balls[0].remove)
                refused(furrow.Status.INPUT, world.body, "nobody")
                refused(furrow.Status.INPUT, world.add, shape={"cone": {}})
                refused(furrow.Status.USAGE, balls[1].set, position=(np.nan, 0, 0))
            """)

    def test_checkpoint_rollback_and_changes(self):
        self.run_script("""
            with furrow.World(SCENE, store=store, overlay=work + "/back.furrow") as world:
                rut(world, 20)
                world.checkpoint()
                at, info = world.time, world.info
                copy = world.read("surface", column=0, row=0, columns=info.columns, rows=info.rows)
                saved = copy.copy()
                rut(world, 30)
                assert world.time > at
                rects, now = world.changes(info.revision)
                assert len(rects) > 0 and now > info.revision
                for column, row, columns, rows in rects:
                    world.read("surface", column=column, row=row, columns=columns, rows=rows,
                               out=copy[row:row + rows, column:column + columns])
                assert (copy == world.read("surface", column=0, row=0, columns=info.columns, rows=info.rows)).all()
                assert not (copy == saved).all()
                world.rollback()
                assert world.time == at
                assert (saved == world.read("surface", column=0, row=0, columns=info.columns, rows=info.rows)).all()
                assert world.stats["steps"] >= 0
                assert "spacing=0.125" in repr(info)
            """)

    def test_a_scene_has_paths_of_any_characters(self):
        self.run_script(r"""
            import shutil
            for name in ("b\U0001f600", "R\u00e4der", "q\"\\ud83d"):
                path = f"{work}/{name}.furrow"
                shutil.copy(store, path)
                with furrow.World({**SCENE, "store": path}) as world:
                    assert "is not a name" in refused(furrow.Status.INPUT, world.add, name=name, shape={"sphere": {"radius": 0.5}})
            for name in ("a\x7fb", "a\x85b", "a\u2028b", "a\ufeffb"):
                assert "a control character" in refused(furrow.Status.INPUT, furrow.World, {**SCENE, "store": name})
            """)

    def test_what_is_wrong_is_an_error(self):
        self.run_script("""
            refused(furrow.Status.INPUT, furrow.World, SCENE, store=work + "/missing.furrow")
            refused(furrow.Status.INPUT, furrow.World, {"no_such_key": 1}, store=store)
            refused(furrow.Status.INPUT, furrow.World, "scene: 1\\nobjects: 7\\n", store=store)
            refused(furrow.Status.INPUT, furrow.World, work + "/missing.yaml", store=store)
            raises(TypeError, furrow.World, {"spacing": object()}, store=store)
            raises(ValueError, furrow.World, {"spacing": float("nan")}, store=store)
            path = work + "/scene.yaml"
            open(path, "w").write("scene: 1\\ntime_step: 0.5\\n")
            with furrow.World(path, store=store) as world:
                assert world.info.time_step == 0.5
                world.step()
                assert world.time == 0.5
                refused(furrow.Status.USAGE, world.step, -1)
                raises(KeyError, world.read, "colour", x=0, y=0, width=1, height=1)
                raises(ValueError, world.read, "offset", x=0)
                raises(ctypes.ArgumentError, world.step, "long")
                assert "offset" in str(raises(KeyError, world.read, "colour", columns=1, rows=1))
                raises(ValueError, world.read, "offset", columns=-1, rows=1)
                raises(ValueError, world.read, "offset", x=float("nan"), y=0, width=1, height=1)
                for wrong in ({"size": (0, 0)}, {"fovy": 0}, {"fovy": float("nan")}):
                    refused(furrow.Status.USAGE, world.render, **wrong)
                raises(TypeError, world.render, size=(10.5, 3))
            with furrow.World({"spacing": np.float64(0.125), "soil": {"name": "dry_sand"}}, store=store, overlay=work + "/np.furrow"):
                pass
            """)

    def test_the_log_may_come_from_any_thread(self):
        out = self.run_script("""
            notes, threads = [], set()
            def log(level, message):
                notes.append((level, message))
                threads.add(threading.get_ident())
            furrow.set_log(log)
            def live(y):
                with furrow.World(SCENE, store=store, overlay=f"{work}/log{y}.furrow", resume=True) as world:
                    rut(world, y)
            workers = [threading.Thread(target=live, args=(y,)) for y in (20, 30)]
            for worker in workers: worker.start()
            for worker in workers: worker.join()
            assert len(notes) >= 2 and len(threads) >= 2 and threading.get_ident() not in threads, (notes, threads)
            assert all(level == 0 and "\\n" not in message for level, message in notes)
            furrow.set_log(None)
            told = len(notes)
            live(40)
            assert len(notes) == told
            furrow.set_log(lambda level, message: print("note"))
            live(45)
            forgotten = furrow.World(SCENE, store=store, overlay=work + "/forgotten.furrow")
            rut(forgotten)
            """)
        self.assertIn("note", out)
        # A world that nobody closed was closed when Python ended: its rut is in the file.
        told = prefix.run("furrow", "info", prefix.work / "forgotten.furrow", env=prefix.environment).stdout
        self.assertIn("deformed at level -1", told)
        self.assertIn("step 20 ", told)

    def test_an_import_tells_stops_and_goes_on(self):
        prefix.run("furrow", "synth", "-o", prefix.work / "dem.png", "--posts", "600x600", "--spacing", "1", env=prefix.environment)
        self.run_script("""
            out, shares = work + "/dem.furrow", []
            error = raises(furrow.Error, furrow.import_dem, work + "/dem.png", out, progress=lambda share: len(shares) > 0, tile=32)
            assert error.status is furrow.Status.INTERRUPTED
            def fail(share): raise KeyError("mine")
            raises(KeyError, furrow.import_dem, [work + "/dem.png"], out, progress=fail, resume=True, tile=32)
            furrow.import_dem([work + "/dem.png"], out, progress=shares.append, resume=True, tile=32)
            assert shares == sorted(shares) and shares[-1] == 1
            refused(furrow.Status.INPUT, furrow.import_dem, work + "/dem.png", out)
            refused(furrow.Status.USAGE, furrow.import_dem, work + "/dem.png", out, no_such_option=1)
            furrow.import_dem(work + "/dem.png", out, overwrite=True, max_error=0.1)
            with furrow.World({}, store=out) as world:
                assert world.info.columns == 600
            """)

    def test_control_c_works_between_steps(self):
        store = prefix.synthesize("plain.furrow", "plain")
        path = self.script("""
            with furrow.World(SCENE, store=store, overlay=work + "/interrupted.furrow") as world:
                ball = rut(world)
                told = False
                try:
                    while True:
                        world.step()
                        if not told and world.time > 0.2:
                            told = True
                            print("stepping", flush=True)
                except KeyboardInterrupt:
                    world.checkpoint()
                    print("interrupted at", world.time > 0.2)
            """)
        process = subprocess.Popen([prefix.python_with("numpy"), path, store, prefix.work], stdout=subprocess.PIPE, text=True,
                                   env=dict(prefix.environment, **prefix.loaded))
        self.addCleanup(process.stdout.close)
        if process.stdout.readline() != "stepping\n":
            process.wait()
            self.fail("it did not come to step")
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.stdout.read(), "interrupted at True\n")
        self.assertEqual(process.wait(60), 0)

    def test_structs_have_the_layout_of_c(self):
        out = self.run_script("""
            from furrow import _declarations as declared
            for name, struct in sorted(vars(declared).items()):
                if name.startswith("furrow_"):
                    print(f"struct {name}", ctypes.sizeof(struct))
                    for field, *_ in struct._fields_:
                        print(f"struct {name} {field}", getattr(struct, field).offset)
            """)
        lines = out.splitlines()
        self.assertGreater(len(lines), 60)
        program = "#include <furrow.h>\n#include <stdio.h>\nint main(void)\n{\n"
        for line in lines:
            words = line.split()
            size = f"sizeof(struct {words[1]})" if len(words) == 3 else f"offsetof(struct {words[1]}, {words[2]})"
            program += f'\tprintf("{" ".join(words[:-1])} %zu\\n", {size});\n'
        (prefix.work / "layout.c").write_text(program + "\treturn 0;\n}\n")
        prefix.run("cc", "layout.c", "-o", "layout", *prefix.package_config("--cflags"))
        self.assertEqual(prefix.run(prefix.work / "layout").stdout, out)
        declared = set(re.findall(r"^struct (furrow_\w+) \{", (prefix.prefix / "include" / "furrow.h").read_text(), re.M))
        self.assertEqual({line.split()[1] for line in lines}, declared)

    def test_everything_is_documented_and_typed(self):
        self.run_script("""
            import inspect
            for name in furrow.__all__:
                thing = getattr(furrow, name)
                if isinstance(thing, np.dtype) or inspect.isclass(thing) and issubclass(thing, int):
                    continue
                assert thing.__doc__, name
                members = inspect.getmembers(thing) if inspect.isclass(thing) else [(name, thing)]
                for member, value in members:
                    if member.startswith("_") or member in ("args", "with_traceback", "add_note"):
                        continue
                    function = value.fget if isinstance(value, property) else type(value).__call__ if inspect.ismodule(value) else value
                    assert inspect.getdoc(value), (name, member)
                    assert "return" in function.__annotations__, (name, member)
            assert "(n, 2)" in furrow.World.points.__doc__
            assert "N, on the body" in furrow.Contact.force.__doc__ and "(3,)" in furrow.Contact.force.__doc__
            assert furrow.__version__ == furrow.version()
            """)
        self.assertTrue((prefix.package / "py.typed").exists())

    def test_a_header_that_is_not_understood_is_an_error(self):
        header = prefix.work / "odd.h"
        header.write_text((prefix.prefix / "include" / "furrow.h").read_text()
                          .replace("struct furrow_rect {", "union furrow_odd { int a; };\nstruct furrow_rect {"))
        result = prefix.run("python3", prefix.ROOT / "python" / "declare.py", header, prefix.work / "odd.py", "/lib/a.so", "/lib/furrow",
                            check=False)
        self.assertEqual(result.returncode, 1)
        self.assertIn("furrow_odd", result.stderr)


if __name__ == "__main__":
    unittest.main()
