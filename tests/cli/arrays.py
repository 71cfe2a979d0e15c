"""What the Python package gives to other packages: columns for pandas, places of posts for xarray, and results where the library is not installed."""
import contextlib
import copy
import importlib.util
import os
import pathlib
import pickle
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import BUILT, FurrowTest, main, use_package, write_png16

SCENE = {"time_step": 0.01, "spacing": 0.0625, "soil": {"name": "dry_sand"}, "redistribute": {"model": "scm"}}
EAST, NORTH = 0.21, 0.13  # slopes of the ground


def has(module):
    return importlib.util.find_spec(module) is not None


class ArraysTest(FurrowTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        use_package()

    @contextlib.contextmanager
    def world(self):
        """A world of 129 x 129 posts at 0.25 m, and a ball in it that has driven."""
        import furrow
        write_png16(self.folder / "slope.png", 129, 129, lambda x, y: round(1000 * (2 + EAST * 0.25 * x + NORTH * 0.25 * (128 - y))))
        self.ok("import", "slope.png", "-o", "slope.furrow", "--spacing", 0.25, "--height-range", "0,65.535")
        with furrow.World(SCENE, store=self.folder / "slope.furrow", overlay=self.folder / "ruts.furrow") as world:
            ball = world.add(shape={"sphere": {"radius": 0.5}})
            z = float(world.points([(16, 16)])["height"][0]) + 0.4
            ball.place((16, 16, z + 0.1))
            for x in np.arange(16, 17, 0.1):
                ball.set((x, 16, z + EAST * (x - 16)))
                world.step()
            yield world, ball


class Columns(ArraysTest):
    def check(self, array, name, parts):
        """Each name is a column of numbers; the field of several numbers is still there, in the same memory."""
        self.assertNotIn(name, array.dtype.names)
        for column in array.dtype.names:
            self.assertEqual(array[column].shape, array.shape, column)
        for i, part in enumerate(parts):
            np.testing.assert_array_equal(array[part], array[name].reshape(*array.shape, len(parts))[..., i])
            self.assertTrue(np.shares_memory(array[part], array[name]))

    def test_points_hits_and_contacts_have_a_column_for_each_number(self):
        import furrow
        with self.world() as (world, ball):
            points = world.points([(4, 5), (16, 16), (-1, 0)])
            self.assertEqual(points.dtype, furrow.POINT)
            self.assertEqual(points.dtype.names, ("height", "normal_x", "normal_y", "normal_z", "offset", "soil", "nodata"))
            self.check(points, "normal", ("normal_x", "normal_y", "normal_z"))
            upward = np.array([-EAST, -NORTH, 1]) / np.sqrt(1 + EAST**2 + NORTH**2)
            np.testing.assert_allclose(points["normal"][0], upward, atol=0.01)
            np.testing.assert_allclose(points[0]["normal"], upward, atol=0.01)
            self.assertTrue(np.isnan(points["normal"][2]).all() and points["nodata"][2])
            self.check(world.points(np.full((4, 3, 2), 7.0)), "normal", ("normal_x", "normal_y", "normal_z"))
            hits = world.rays([(4, 5, 50)], (0, 0, -1))
            self.check(hits, "position", ("position_x", "position_y", "position_z"))
            np.testing.assert_allclose(hits["position"][0], [4, 5, points["height"][0]], atol=1e-6)
            contacts = world.get_contacts([ball])
            self.check(contacts, "force", ("force_x", "force_y", "force_z"))
            self.check(contacts, "stiffness", [f"stiffness_{i}_{j}" for i in range(6) for j in range(6)])
            np.testing.assert_array_equal(contacts["force"][0], ball.contact.force)
            np.testing.assert_array_equal(contacts["damping"][0], ball.contact.damping)
            self.assertGreater(contacts["force_z"][0], 10)

    def test_what_numpy_makes_of_them_knows_both(self):
        import furrow
        array = np.zeros(4, furrow.POINT)
        array["normal"][:, 1] = 5
        array["normal_z"] = 6
        array["normal"][2] = (7, 8, 9)
        several = np.zeros((2, 4), furrow.POINT)
        several[1] = array
        for made in (array.copy(), np.array(array), copy.deepcopy(array), pickle.loads(pickle.dumps(array)), np.concatenate([array, array])[4:], array[np.arange(4)],
                     np.stack([array, array])[1], several[1]):
            np.testing.assert_array_equal(made["normal"], [(0, 5, 6), (0, 5, 6), (7, 8, 9), (0, 5, 6)])
            np.testing.assert_array_equal(made["normal_y"], [5, 5, 8, 5])
        self.assertEqual(array[["height", "normal"]][2]["normal"].tolist(), [7, 8, 9])

    def test_pandas_takes_them(self):
        if not has("pandas"):
            self.skipTest("not on this machine: the Python package pandas")
        import pandas
        with self.world() as (world, ball):
            points = world.points([(4, 5), (16, 16), (-1, 0)])
            frame = pandas.DataFrame(points)
            self.assertEqual(list(frame), ["height", "normal_x", "normal_y", "normal_z", "offset", "soil", "nodata"])
            np.testing.assert_array_equal(frame[["normal_x", "normal_y", "normal_z"]], points["normal"])
            self.assertEqual((frame["nodata"].dtype, frame["nodata"].tolist()), (bool, [False, False, True]))
            self.assertLess(frame["offset"][1], -0.01)
            self.assertEqual(list(pandas.DataFrame(world.points(np.zeros((0, 2))))), list(frame))
            self.assertEqual(pandas.DataFrame(world.rays([(4, 5, 50)], (0, 0, -1)))["position_y"][0], 5)
            self.assertEqual(pandas.DataFrame(world.get_contacts([ball]))["force_z"][0], ball.contact.force[2])


class Places(ArraysTest):
    def test_read_says_where_its_posts_are(self):
        with self.world() as (world, _):
            for x, y in ((15.3, 15.77), (15.3125, 15.75), (15.31, 15.7500001)):
                patch = world.read("surface", x=x, y=y, width=2, height=1)
                self.assertEqual(patch.shape, (len(patch.y), len(patch.x)))
                for start, length, at in ((x, 2, patch.x), (y, 1, patch.y)):  # the first post at or beyond the corner, the last one before the other side
                    self.assertEqual(at[0], 0.0625 * np.ceil(start / 0.0625 - 1e-6))
                    self.assertEqual(at[-1], 0.0625 * np.floor((start + length) / 0.0625 + 1e-6))
                    np.testing.assert_array_equal(np.diff(at), 0.0625)
                points = world.points(np.stack(np.meshgrid(patch.x, patch.y), axis=-1))
                np.testing.assert_allclose(patch, points["height"], atol=1e-9)
                self.assertLess(points["offset"].min(), -0.01)
            by_posts = world.read("surface", column=30, row=40, columns=3, rows=2)
            np.testing.assert_array_equal(by_posts.x, [30 * 0.0625, 31 * 0.0625, 32 * 0.0625])
            np.testing.assert_array_equal(by_posts.y, [40 * 0.0625, 41 * 0.0625])
            coarse = world.read("base", x=3.1, y=4.1, width=6, height=5, level=world.info.level + 2)
            np.testing.assert_array_equal(coarse.x, np.arange(3.25, 9.1, 0.25))
            np.testing.assert_array_equal(coarse.y, np.arange(4.25, 9.1, 0.25))
            np.testing.assert_allclose(coarse, 2 + EAST * coarse.x + NORTH * coarse.y[:, None], atol=0.01)

    def test_a_part_of_it_has_no_places_and_says_so(self):
        with self.world() as (world, _):
            whole = np.full((20, 30), -7.0)
            patch = world.read("offset", column=250, row=250, columns=10, rows=10, out=whole[5:15, 8:18])
            self.assertTrue(np.shares_memory(patch, whole))
            self.assertEqual(patch.x[0], 250 * 0.0625)
            for part in (patch[2:], patch[::-1], patch.T, patch.copy()):
                with self.assertRaisesRegex(AttributeError, "^furrow: only the array that World.read returned has y, .*; take the same part of its y"):
                    part.y  # pylint: disable=pointless-statement
            self.assertEqual({type(made) for made in (1000 * patch, -patch, np.abs(patch), patch.min(axis=0))}, {np.ndarray})
            self.assertEqual({type(made) for made in (patch.min(), patch.mean(), patch[3, 4])}, {np.float64})
            self.assertEqual(patch.min(), np.asarray(patch).min())
            with self.assertRaisesRegex(AttributeError, "no attribute 'z'"):
                patch.z  # pylint: disable=pointless-statement

    def test_xarray(self):
        with self.world() as (world, _):
            rectangle = {"x": 15.3, "y": 15.77, "width": 2, "height": 1}
            if not has("xarray"):
                with self.assertRaises(ImportError) as raised:
                    world.read("offset", **rectangle, xarray=True)
                self.assertRegex(str(raised.exception), r"^furrow: read with xarray=True: the Python package xarray is not installed for \S+; \S+ -m pip install xarray$")
                self.skipTest("not on this machine: the Python package xarray")
            patch, placed = world.read("offset", **rectangle), world.read("offset", **rectangle, xarray=True)
            self.assertEqual((placed.dims, placed.name, placed.attrs["units"], placed.x.attrs["units"]), (("y", "x"), "offset", "m", "m"))
            np.testing.assert_array_equal(placed.x, patch.x)
            np.testing.assert_array_equal(placed.y, patch.y)
            np.testing.assert_array_equal(placed, patch)
            self.assertEqual(placed.sel(x=16, y=16, method="nearest"), patch[list(patch.y).index(16), list(patch.x).index(16)])
            self.assertEqual(world.read("disturbance", **rectangle, xarray=True).attrs["units"], "1")


class NoLibrary(ArraysTest):
    def python(self, text):
        environment = {**os.environ, "PYTHONPATH": str(BUILT), "FURROW_LIBRARY": "/nonexistent/libfurrow.so.0"}
        return subprocess.run([sys.executable, "-c", text], env=environment, cwd=self.folder, capture_output=True, text=True)

    def test_results_need_none(self):
        (self.folder / "out").mkdir()
        (self.folder / "out/run.json").write_text('{"steps": 3}')
        (self.folder / "out/vehicles.csv").write_text("t,name,x\n0,cart,1\n0.5,cart,2.5\n")
        read = self.python("import furrow.results; drive = furrow.results.Drive('out'); print(drive.facts['steps'], drive.vehicles['cart']['x'].tolist())")
        self.assertEqual((read.returncode, read.stdout, read.stderr), (0, "3 [1.0, 2.5]\n", ""))

    def test_a_call_names_what_is_missing(self):
        for call in ("furrow.version()", "furrow.__version__", "furrow.World({}, store='a.furrow')", "furrow.set_log(print)"):
            told = self.python(f"import furrow\ntry: {call}\nexcept ImportError as error: print(error)")
            self.assertEqual((told.returncode, told.stderr), (0, ""))
            self.assertRegex(told.stdout, r"^furrow: the library cannot be loaded: .*; install libfurrow, or set FURROW_LIBRARY to the path of libfurrow.so.0\n$")


if __name__ == "__main__":
    main()
