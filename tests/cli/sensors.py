"""Sensors of a drive beside closed forms: gravity in the axes of an IMU, weights on feet, rays to a plane, a ball and a wall; what bags and datasets have of them."""
import atexit
import csv
import json
import pathlib
import shutil
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main, need_vehicles, use_package, write_png16  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
SLED = ROOT / "tests/vehicle/sled.xml"
G = 9.81
LEVEL = 10.0  # m: height of the level ground
SLOPE = 12.0  # degrees, up toward east
BALL = (36.0, 30.0)
SCENE = f"""scene: 1
time_step: 0.002
end_time: 0.3
spacing: 0.0625
soil: {{name: dry_sand}}
redistribute: {{model: scm}}
vehicles:
  - {{name: sled, model: {SLED}, start: {{at: [30, 30], yaw: 25}}, imu: {{at: [0.1, 0.2, 0.3]}}, driver: {{hold: {{mast: 0.7}}}}}}
output: {{vehicles: 100, sensors: 100}}
"""
LIDAR = """lidars:
  - {name: post, pose: {at: [31, 30, 14], yaw: 20}, rate: 10, rays: [40, 35], fov: [360, 176], range: [0.2, 28]}
  - {name: noisy, pose: {at: [31, 30, 14], pitch: -90}, rate: 10, rays: [60, 60], fov: [40, 40], range: [0.2, 60], noise: 0.05, dropout: 0.1}
  - {name: top, on: sled, pose: {at: [0.1, 0.2, 1.5], yaw: 30, pitch: -20}, rate: 10, rays: [24, 9], fov: [360, 60], range: [0.5, 60]}
  - {name: mast, on: sled, body: mast, rate: 10, rays: [3, 2], pose: {at: [0, 0, 2]}}
objects:
  - {name: ball, shape: {sphere: {radius: 1.5}}, sink: 0.1, path: {points: [[36, 30], [36.1, 30]], speed: 0.001}}
"""
WALL = '<mujoco><worldbody><body pos="34 30 10"><geom type="box" size="0.1 9 9"/></body></worldbody></mujoco>'


def turned(yaw, pitch, roll):
    """The axes forward, left, up of a row of vehicles.csv as columns."""
    y, p, r = np.radians([yaw, pitch, roll])
    forward = np.array([np.cos(p) * np.cos(y), np.cos(p) * np.sin(y), np.sin(p)])
    left = np.cos(r) * np.array([-np.sin(y), np.cos(y), 0]) + np.sin(r) * np.array([-np.sin(p) * np.cos(y), -np.sin(p) * np.sin(y), np.cos(p)])
    return np.stack([forward, left, np.cross(forward, left)], axis=1)


def euler(x, y, z):
    """MJCF's euler angles: about x, then the new y, then the new z."""
    turns = []
    for axis, angle in enumerate(np.radians([x, y, z])):
        turn, (i, k) = np.eye(3), ((1, 2), (2, 0), (0, 1))[axis]
        turn[i, i] = turn[k, k] = np.cos(angle)
        turn[i, k], turn[k, i] = -np.sin(angle), np.sin(angle)
        turns.append(turn)
    return turns[0] @ turns[1] @ turns[2]


class SensorsTest(FurrowTest):
    kept = {} # folders of drives

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        use_package()
        need_vehicles()

    def ground(self, name, height):
        """A store of 257 x 257 posts at 0.25 m; height(x), m, from 0 to 65."""
        if self.folder.joinpath(f"{name}.furrow").exists():
            return f"{name}.furrow"
        write_png16(self.folder / f"{name}.png", 257, 257, lambda x, y: round(1000 * height(0.25 * x)))
        self.ok("import", f"{name}.png", "-o", f"{name}.furrow", "--spacing", 0.25, "--height-range", "0,65.535")
        return f"{name}.furrow"

    def driven(self, scene=SCENE, store=None, out="out", sets=(), again=False):
        """A drive into the folder `out`. Tests share those of the same scene and settings, unless `again`."""
        from furrow import results
        self.scene(scene)
        store = store or self.ground("level", lambda x: LEVEL)
        key, kept = (scene, store, tuple(sets)), SensorsTest.kept
        shutil.rmtree(self.folder / out, ignore_errors=True)
        for file in self.folder.glob("ruts.furrow*"):
            file.unlink()
        if again or key not in kept:
            self.ok("drive", "scene.yaml", "--store", store, "--overlay", "ruts.furrow", "-o", out, *(word for one in sets for word in ("--set", one)))
            kept[key] = pathlib.Path(tempfile.mkdtemp(prefix="furrow-cli-"))
            atexit.register(shutil.rmtree, kept[key], ignore_errors=True)
            shutil.copytree(self.folder / out, kept[key] / "out")
        else:
            shutil.copytree(kept[key] / "out", self.folder / out)
        return results.Drive(self.folder / out)

    def listed(self, drive):
        return {sensor["name"]: sensor for sensor in drive.sensor_list}

    def of(self, drive, name):
        rows = drive.sensors["sled"]
        return np.stack([rows[column] for column in self.listed(drive)[name]["columns"]], axis=1)


class AtRestTest(SensorsTest):
    def check_gravity(self, drive, since=0.1):
        rows = drive.vehicles["sled"]
        own = self.of(drive, "imu.accelerometer")
        self.assertEqual(len(own), len(rows["t"]))
        late = rows["t"] > since
        for i in np.nonzero(late)[0]:
            axes = turned(rows["yaw"][i], rows["pitch"][i], rows["roll"][i])
            np.testing.assert_allclose(own[i], axes[2] * G, atol=1e-3)
            np.testing.assert_allclose(self.of(drive, "force_of_rest")[i], euler(20, -35, 70).T @ axes[2] * G, atol=1e-3)
            w, x, y, z = self.of(drive, "imu.orientation")[i]
            np.testing.assert_allclose([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axes[:, 0], atol=1e-7)
            at = np.array([rows[axis][i] for axis in "xyz"]) + axes @ [0.2, -0.1, 0.15]
            np.testing.assert_allclose(self.of(drive, "place")[i], at, atol=1e-6) # rows have 9 digits
        np.testing.assert_allclose(self.of(drive, "imu.gyro")[late], 0, atol=1e-3)

    def test_an_imu_reads_gravity_on_level_ground(self):
        drive = self.driven(sets=["end_time=1.1"])
        self.check_gravity(drive, 0.8) # until then the soil still gives way below it
        self.assertAlmostEqual(float(self.of(drive, "imu.accelerometer")[-1][2]), G, delta=0.02)

    def test_an_imu_reads_the_parts_of_gravity_on_a_slope(self):
        drive = self.driven(store=self.ground("slope", lambda x: 2 + np.tan(np.radians(SLOPE)) * x), sets=["end_time=1.1"])
        self.check_gravity(drive, 0.8)
        yaw = np.radians(25)
        own = self.of(drive, "imu.accelerometer")[-1]
        self.assertAlmostEqual(own[0], G * np.sin(np.radians(SLOPE)) * np.cos(yaw), delta=0.3) # feet sink, more below
        self.assertAlmostEqual(own[1], -G * np.sin(np.radians(SLOPE)) * np.sin(yaw), delta=0.3)

    def test_an_imu_reads_what_the_velocities_change(self):
        """It falls from 5 cm, hits the ground, and comes to rest."""
        scene = SCENE.replace("{at: [0.1, 0.2, 0.3]}", "{}").replace("yaw: 25}", "yaw: 25, height: 0.05}").replace("100, sensors: 100", "500, sensors: 500")
        drive = self.driven(scene)
        rows, own = drive.vehicles["sled"], self.of(drive, "imu.accelerometer")
        self.assertTrue(np.isnan(own[0]).all()) # nothing moved it yet
        velocities = np.stack([rows[f"v{axis}"] for axis in "xyz"], axis=1)
        for i in range(1, len(own)):
            axes = turned(rows["yaw"][i], rows["pitch"][i], rows["roll"][i])
            felt = (velocities[i] - velocities[i - 1]) / 0.002 + [0, 0, G]
            np.testing.assert_allclose(axes @ own[i], felt, atol=0.02 + 0.01 * np.abs(felt).max(), err_msg=str(rows["t"][i])) # velocities turn with the body
        np.testing.assert_allclose(own[1:30], 0, atol=1e-3)
        self.assertGreater(np.nanmax(own[:, 2]), 3 * G)

    def test_feet_bear_the_weight(self):
        drive = self.driven()
        touches = sum(self.of(drive, f"touch_{foot}")[-1, 0] for foot in "abcd")
        self.assertAlmostEqual(touches, 101 * G, delta=0.01 * 101 * G)
        above = sum(np.abs(self.of(drive, f"leg_{foot}")[-1, 2]) for foot in "abcd")
        self.assertAlmostEqual(above, 81 * G, delta=0.01 * 81 * G)

    def test_a_rangefinder_sees_ground_and_bodies(self):
        (self.folder / "wall.xml").write_text(WALL)
        drive = self.driven(SCENE.replace("yaw: 25", "yaw: 0") + "world: wall.xml\n")
        rows = drive.vehicles["sled"]
        axes = turned(rows["yaw"][-1], rows["pitch"][-1], rows["roll"][-1])
        hull = np.array([rows[axis][-1] for axis in "xyz"])
        down = hull + axes @ [0, 0.9, 0.3]
        self.assertAlmostEqual(self.of(drive, "down")[-1, 0], (down[2] - LEVEL) / axes[2, 2], delta=1e-4)
        ahead = hull + axes @ [0.7, 0, 0.1]
        self.assertAlmostEqual(self.of(drive, "ahead")[-1, 0], (33.9 - ahead[0]) / axes[0, 0], delta=1e-4)
        self.assertEqual(self.of(drive, "sky")[-1, 0], -1)
        self.assertEqual(self.of(drive, "near")[-1, 0], 0.3)
        fields = self.of(drive, "all")[-1]
        np.testing.assert_allclose(fields, [self.of(drive, "down")[-1, 0], *-axes[:, 2], *down, *(down - self.of(drive, "down")[-1, 0] * axes[:, 2]), 0, 0, 1], atol=1e-3)
        self.assertAlmostEqual(self.of(drive, "clock")[-1, 0], rows["t"][-1], delta=1e-9)
        self.assertAlmostEqual(self.of(drive, "jointpos_" + str([s["name"] for s in drive.sensor_list].index("mast_rate") - 1))[-1, 0], rows["q:mast"][-1], delta=1e-8)


class FilesTest(SensorsTest):
    def test_sensors_change_nothing(self):
        left = []
        for name, scene in (("with", SCENE + LIDAR), ("without", SCENE.replace(", sensors: 100", ", sensors: 0").replace("imu: {at: [0.1, 0.2, 0.3]}, ", "") + LIDAR[LIDAR.index("objects:"):])):
            self.driven(scene, out=name)
            left.append(self.folder.joinpath(name, "vehicles.csv").read_bytes())
        self.assertEqual(*left)
        self.assertFalse(self.folder.joinpath("without/sensors.csv").exists() or self.folder.joinpath("without/sensors.json").exists())

    def test_a_drive_into_the_same_folder_takes_the_files_away(self):
        self.driven(SCENE + LIDAR)
        self.assertTrue(self.folder.joinpath("out/lidars/post/000000.npy").exists())
        self.scene(SCENE.replace(", sensors: 100", ""))
        self.ok("drive", "scene.yaml", "--store", "level.furrow", "--overlay", "other.furrow", "-o", "out")
        self.assertEqual([name for name in ("sensors.csv", "sensors.json", "lidars") if self.folder.joinpath("out", name).exists()], [])

    def test_frames_are_the_mounts(self):
        drive = self.driven()
        frames = {name: sensor["frame"] for name, sensor in self.listed(drive).items()}
        np.testing.assert_allclose(frames["imu.gyro"]["position"], [0.1, 0.2, 0.3], atol=1e-9)
        np.testing.assert_allclose(frames["imu.gyro"]["orientation"], [0, 0, 0, 1], atol=1e-9)
        self.assertEqual([frames["imu.gyro"][key] for key in ("name", "parent")], ["sled/imu", "sled/base_link"])
        from furrow import results
        np.testing.assert_allclose(results.matrices(np.array([frames["rate"]["orientation"]]))[0], euler(20, -35, 70), atol=1e-9)
        np.testing.assert_allclose(frames["rate"]["position"], [0.2, -0.1, 0.15], atol=1e-9)
        self.assertEqual(frames["top"]["parent"], "sled/mast")
        np.testing.assert_allclose(frames["top"]["position"], [0.1, 0, 0.5], atol=1e-9)
        units = {name: sensor["unit"] for name, sensor in self.listed(drive).items()}
        self.assertEqual([units[name] for name in ("force_of_rest", "rate", "turn", "place", "down", "touch_a", "mast_rate")], ["m/s2", "rad/s", "", "m", "m", "N", "rad/s"])
        axes = {name: sensor["axes"] for name, sensor in self.listed(drive).items()}
        self.assertEqual([axes[name] for name in ("force_of_rest", "place", "top", "down")], ["own", "map", "hull", None])

    def drive_model(self, changes, scene=SCENE, sets=(), out="out"):
        """A drive of the sled with some of its text replaced."""
        text = SLED.read_text()
        for old, new in changes:
            self.assertEqual(text.count(old), 1, old)
            text = text.replace(old, new)
        (self.folder / "own.xml").write_text(text)
        return self.driven(scene.replace(str(SLED), "own.xml"), out=out, sets=sets, again=True)

    def test_an_imu_of_the_model_stays_beside_the_scenes(self):
        own = [('<site name="sky"', '<site name="imu" pos="0 0 -0.05" euler="90 0 0"/><site name="sky"'),
               ('<clock name="clock"/>', '<clock name="clock"/><accelerometer name="a" site="imu"/><gyro name="g" site="imu" noise="9"/>')]
        drive = self.drive_model(own, SCENE.replace("0.3]}", "0.3], noise: [0, 0.5]}"))
        places = {imu["name"]: (imu["frame"]["name"], imu["frame"]["position"], imu["noise"]["gyro"]) for imu in drive.imus}
        self.assertEqual(sorted(places), ["imu", "imu.site", "pack"])
        self.assertEqual((places["imu"][0], places["imu.site"][0]), ("sled/imu", "sled/imu.site"))
        np.testing.assert_allclose(places["imu"][1], [0, 0, -0.05], atol=1e-9)
        np.testing.assert_allclose(places["imu.site"][1], [0.1, 0.2, 0.3], atol=1e-9)
        self.assertEqual((places["imu"][2], places["imu.site"][2]), (0, 0.5))
        from furrow import dataset
        self.assertEqual(dataset._imu_of(drive, "sled")["name"], "imu.site")
        # Names that the scene's sensors would need are told.
        (self.folder / "own.xml").write_text(SLED.read_text().replace('<clock name="clock"/>', '<gyro name="imu.gyro" site="pack"/>'))
        self.scene(SCENE.replace(str(SLED), "own.xml"))
        told = self.furrow("drive", "scene.yaml", "--store", "level.furrow", "--overlay", "ruts.furrow", "-o", "out")
        self.assertEqual(told.returncode, 3)
        self.assertIn("imu: the model has a sensor imu.gyro already; call that otherwise", told.stderr)

    def test_frames_of_different_things_have_different_names(self):
        own = [('<site name="top" ', '<site name="mast" pos="0 0 0.2"/><site name="base_link"/><site name="top" '),
               ('<clock name="clock"/>', '<clock name="clock"/><gyro name="of_site" site="mast"/><framepos name="of_geom" objtype="geom" objname="mast"/><gyro name="of_link" site="base_link"/>'
                '<framepos name="of_body" objtype="xbody" objname="mast"/><framepos name="of_foot" objtype="geom" objname="foot_a"/>')]
        frames = {name: sensor["frame"]["name"] for name, sensor in self.listed(self.drive_model(own)).items() if sensor["frame"]}
        self.assertEqual([frames[name] for name in ("of_site", "of_geom", "of_link", "of_body", "of_foot", "touch_a", "touch_b", "top")],
                         ["sled/mast.site", "sled/mast.geom", "sled/base_link.site", "sled/mast", "sled/foot_a.geom", "sled/foot_a.site", "sled/foot_b", "sled/top"])

    def test_the_imu_is_on_the_body_that_the_rows_have(self):
        """A body that the scene does not move comes first. And a root that is turned in a model that looks backward."""
        marker = ('<body name="hull" pos="0 0 0.6">', '<body name="marker" mocap="true" pos="3 3 3"/><body name="hull" pos="0 0 0.6">')
        turned_root = ('<body name="hull" pos="0 0 0.6">', '<body name="hull" pos="0 0 0.6" euler="0 0 90">')
        for changes, keys, at in (([marker], "", [0.1, 0.2, 0.3]), ([turned_root], "forward: -x, ", [0.1, 0.2, 0.3]), ([turned_root], "forward: -x, body: foot_b, ", None)):
            with self.subTest(keys=keys, changes=changes):
                scene = SCENE.replace("imu: {at", f"{keys.replace('body: foot_b, ', '')}imu: {{{'body: foot_b, ' if at is None else ''}at")
                frame = self.listed(self.drive_model(changes, scene))["imu.gyro"]["frame"]
                self.assertEqual((frame["body"], frame["parent"]), ("hull" if at else "foot_b", "sled/base_link"))
                # foot_b is 0.5, -0.35, -0.35 in the hull, whose x is the model's y, which looks to the right of -x.
                np.testing.assert_allclose(frame["position"], at or [0.1 - 0.35, 0.2 - 0.5, 0.3 - 0.35], atol=1e-9)
                np.testing.assert_allclose(np.abs(frame["orientation"]), [0, 0, 0, 1], atol=1e-9)

    def test_noise_of_a_rangefinder_is_of_distances(self):
        own = [(f'<rangefinder name="{name}" ', f'<rangefinder name="{name}" noise="{noise}" ') for name, noise in (("down", 0.05), ("sky", 0.05), ("near", 0.05), ("all", 0.05), ("ahead", 0.05))]
        exact, noisy = (self.drive_model(own, sets=sets, out=out) for sets, out in (([], "exact"), (["output.noise_seed=4"], "noisy")))
        one, two = self.of(noisy, "down"), self.of(exact, "down")
        self.assertAlmostEqual((one - two).std(), 0.05, delta=0.02)
        self.assertTrue((self.of(noisy, "sky") == -1).all())
        self.assertTrue((self.of(noisy, "ahead") == -1).all())
        self.assertTrue(((self.of(noisy, "near") >= 0) & (self.of(noisy, "near") <= 0.3)).all())
        self.assertGreater(len(set(self.of(noisy, "near")[:, 0])), 5)
        np.testing.assert_array_equal(self.of(noisy, "all")[:, 1:], self.of(exact, "all")[:, 1:])
        self.assertTrue((self.of(noisy, "all")[:, 0] != self.of(exact, "all")[:, 0]).all())

    def test_noise_follows_the_seed(self):
        exact, one, again, other = (self.driven(out=f"n{i}", sets=sets, again=True) for i, sets in enumerate(([], ["output.noise_seed=4"], ["output.noise_seed=4"], ["output.noise_seed=5"])))
        self.assertEqual(one.folder.joinpath("sensors.csv").read_bytes(), again.folder.joinpath("sensors.csv").read_bytes())
        noise, differs = self.of(one, "rate") - self.of(exact, "rate"), self.of(other, "rate") - self.of(exact, "rate")
        self.assertTrue((noise != differs).all())
        self.assertAlmostEqual(noise.std(), 0.01, delta=0.003) # 93 numbers
        np.testing.assert_array_equal(self.of(one, "imu.gyro"), self.of(exact, "imu.gyro")) # it names no noise

    def test_a_resumed_drive_has_the_same_rows(self):
        whole = self.driven().folder.joinpath("sensors.csv").read_bytes()
        self.driven(out="part", sets=["end_time=0.15"], again=True)
        self.ok("drive", "scene.yaml", "--store", "level.furrow", "--overlay", "ruts.furrow", "-o", "part", "--resume")
        self.assertEqual(self.folder.joinpath("part/sensors.csv").read_bytes(), whole)

    def test_what_is_wrong_is_one_line(self):
        self.ground("level", lambda x: LEVEL)
        for scene, words in ((SCENE.replace("imu: {at", "imu: {body: tail, at"), "imu.body: tail is no body of the model; there are: hull"),
                             (SCENE + LIDAR.replace("on: sled, body: mast", "on: sled, body: tail"), "lidars.mast.body: tail is no body of sled; there are: hull"),
                             (SCENE + LIDAR.replace("on: sled, body", "body"), "body: is a body of a vehicle"),
                             (SCENE + LIDAR.replace("[0.5, 60]", "[60, 0.5]"), "allowed: a lower number"),
                             (SCENE + LIDAR.replace("name: top", "name: post"), "unique names")):
            self.scene(scene)
            told = self.refused(3, "drive", "scene.yaml", "--store", "level.furrow", "--overlay", "ruts.furrow", "-o", "out")
            self.assertIn(words, told if isinstance(told, str) else str(told))


class LidarTest(SensorsTest):
    def closed(self, origin, ways, ball, wall=None):
        """Ranges to level ground, a ball and a wall at a plane of x; inf: none."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ground = (LEVEL - origin[2]) / ways[..., 2]
            ground[~(ground > 0)] = np.inf
            between = np.array(origin) - ball
            b, c = ways @ between, between @ between - 1.5 ** 2
            root = np.sqrt(b * b - c)
        ranges = np.fmin(ground, np.where((b * b > c) & (b < 0), -b - root, np.inf))
        if wall is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (wall - origin[0]) / ways[..., 0]
                at = np.array(origin) + ways * t[..., None]
            ranges = np.fmin(ranges, np.where((t > 0) & (np.abs(at[..., 1] - 30) < 9) & (np.abs(at[..., 2] - 10) < 9), t, np.inf))
        return ranges

    def test_rays_are_those_of_closed_forms(self):
        from furrow import _sensors, results
        (self.folder / "wall.xml").write_text(WALL)
        for world, wall in (("", None), ("world: wall.xml\n", 33.9)):
            drive = self.driven(SCENE + LIDAR + world)
            post = drive.lidars["post"]
            self.assertEqual([frame["frame"] for frame in post["frames"]], [0, 1, 2, 3])
            axes = results.matrices(np.array([post["frames"][2]["orientation"]]))[0]
            np.testing.assert_allclose(axes, turned(20, 0, 0), atol=1e-9)
            ranges = np.load(post["folder"] / "000002.npy")
            self.assertEqual(ranges.shape, (35, 40))
            self.assertEqual(ranges.dtype, np.float32)
            expected = self.closed((31, 30, 14), _sensors.ways(post) @ axes.T, np.array([36.0002, 30, LEVEL + 1.4]), wall)
            expected[expected > 28] = np.inf # the terrain ends at 33 m
            # The sled is seen too: only rays that do not go near it are compared.
            ways = _sensors.ways(post) @ axes.T
            toward = np.array([30, 30, LEVEL + 0.5]) - [31, 30, 14]
            clear = ways @ toward / np.linalg.norm(toward) < np.cos(np.radians(28))
            np.testing.assert_allclose(ranges[clear], expected[clear], rtol=0, atol=2e-5)
            self.assertGreater(np.isfinite(expected[clear]).sum(), 250)
            if wall is None:
                bare = self.closed((31, 30, 14), ways, np.array([1e9, 0, 0]))
                bare[bare > 28] = 28
                self.assertGreater((bare > expected + 0.01)[clear].sum(), 3) # on the ball
            self.assertTrue((ranges < expected - 0.1)[~clear & np.isfinite(expected)].any()) # the sled

    def test_a_mounted_lidar_goes_with_its_body(self):
        from furrow import results
        drive = self.driven(SCENE + LIDAR)
        rows = drive.vehicles["sled"]
        for name, at in (("top", [0.1, 0.2, 1.5]), ("mast", None)):
            for frame in drive.lidars[name]["frames"]:
                i = int(np.argmin(np.abs(rows["t"] - frame["time"])))
                axes = turned(rows["yaw"][i], rows["pitch"][i], rows["roll"][i])
                place = np.array([rows[axis][i] for axis in "xyz"])
                self.assertAlmostEqual(rows["t"][i], frame["time"], delta=1e-9)
                np.testing.assert_allclose(frame["position"], place + axes @ (at if at else [-0.4, 0, 2.1]), atol=1e-6)
                own = results.matrices(np.array([frame["orientation"]]))[0]
                np.testing.assert_allclose(own, axes @ (turned(30, -20, 0) if at else turned(np.degrees(rows["q:mast"][i]), 0, 0)), atol=1e-6)
        top = drive.points("top", 3)
        frame = drive.lidars["top"]["frames"][3]
        world = top @ results.matrices(np.array([frame["orientation"]]))[0].T + frame["position"]
        on_ground = np.abs(world[:, 2] - LEVEL) < 1e-4
        self.assertGreater(on_ground.sum(), 50)

    def test_noise_and_dropouts_follow_the_seed(self):
        drives = [self.driven(SCENE + LIDAR, out=f"l{i}", sets=sets, again=True) for i, sets in enumerate(([], [], ["output.noise_seed=9"]))]
        frames = [np.load(drive.folder / "lidars/noisy/000001.npy") for drive in drives]
        self.assertEqual(*(drive.folder.joinpath("lidars/noisy/000001.npy").read_bytes() for drive in drives[:2]))
        self.assertTrue((frames[0] != frames[2]).any())
        noisy = drives[0].lidars["noisy"]
        from furrow import _sensors, results
        ways = _sensors.ways(noisy) @ results.matrices(np.array([noisy["frames"][1]["orientation"]]))[0].T
        aside = np.array([31, 30, 14]) + ways * (4 / -ways[..., 2])[..., None]
        clear = (np.hypot(aside[..., 0] - 30, aside[..., 1] - 30) > 1.9) & (np.hypot(aside[..., 0] - 36, aside[..., 1] - 30) > 3)
        dropped = np.isnan(frames[0])
        self.assertAlmostEqual(dropped.mean(), 0.1, delta=0.02)
        error = (frames[0] - 4 / -ways[..., 2])[clear & ~dropped]
        self.assertGreater(len(error), 500)
        self.assertAlmostEqual(error.std(), 0.05, delta=0.005)
        self.assertAlmostEqual(error.mean(), 0, delta=0.01)


class OutTest(SensorsTest):
    def rows(self):
        with open(self.folder / "out/sensors.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_the_bag_has_imus_ranges_and_clouds(self):
        from furrow import _sensors, bag, results
        drive = self.driven(SCENE + LIDAR)
        messages = list(bag._in_time(bag._sources(drive, False)))
        imu = [(ns, m) for ns, topic, kind, m in messages if topic == "/sled/imu" and kind == "sensor_msgs/Imu"]
        rows = self.rows()
        self.assertEqual([ns for ns, _ in imu], [round(float(row["t"]) * 1e9) for row in rows])
        for (_, m), row in zip(imu, rows):
            self.assertEqual([m["linear_acceleration"][a] for a in "xyz"], [float(row[f"imu.accelerometer.{a}"]) for a in "xyz"])
            self.assertEqual([m["angular_velocity"][a] for a in "xyz"], [float(row[f"imu.gyro.{a}"]) for a in "xyz"])
            self.assertEqual([m["orientation"][a] for a in "xyzw"], [float(row[f"imu.orientation.{a}"]) for a in "xyzw"])
        self.assertEqual(imu[0][1]["header"]["frame_id"], "sled/imu")
        # They come with each row, so that who listens later has them.
        self.assertNotIn("/tf_static", {topic for _, topic, *_ in messages})
        told = [(ns, t["child_frame_id"]) for ns, topic, _, m in messages if topic == "/tf" for t in m["transforms"]]
        self.assertEqual([ns for ns, child in told if child == "sled/imu"], [ns for ns, child in told if child == "sled/base_link"])
        still = {t["child_frame_id"]: t for _, topic, _, m in messages if topic == "/tf" for t in m["transforms"]}
        self.assertEqual(still["sled/imu"]["header"]["frame_id"], "sled/base_link")
        np.testing.assert_allclose([still["sled/imu"]["transform"]["translation"][a] for a in "xyz"], [0.1, 0.2, 0.3], atol=1e-9)
        beam = results.matrices(np.array([[still["sled/down/beam"]["transform"]["rotation"][a] for a in "xyzw"]]))[0]
        np.testing.assert_allclose(beam[:, 0], [0, 0, -1], atol=1e-9) # x of a beam of ROS goes along it
        ranges = [m["range"] for _, topic, _, m in messages if topic == "/sled/down/range"]
        self.assertEqual(ranges, [float(row["down"]) for row in rows])
        cloud = [m for _, topic, _, m in messages if topic == "/post/points"][1]
        np.testing.assert_array_equal(np.frombuffer(cloud["data"], "<f4").reshape(-1, 3), _sensors.points(drive.lidars["post"], 1).astype("<f4"))

    def test_euroc_has_the_imu(self):
        self.driven(SCENE + 'cameras: [{name: nav, kind: mounted, on: sled, pose: {at: [0.6, 0, 1]}, rate: 10, size: [32, 24], images: [colour, depth]}]\n')
        told = self.furrow("dataset", "out", "-o", "sequence")
        self.assertEqual(told.returncode, 0, told.stderr)
        own = self.folder / "sequence/mav0/imu0"
        read = [line.split(",") for line in (own / "data.csv").read_text().splitlines()[1:]]
        self.assertEqual([[int(line[0]), *map(float, line[1:])] for line in read],
                         [[round(float(row["t"]) * 1e9), *(float(row[f"imu.gyro.{a}"]) for a in "xyz"), *(float(row[f"imu.accelerometer.{a}"]) for a in "xyz")] for row in self.rows()])
        text = (own / "sensor.yaml").read_text()
        matrix = np.array(json.loads(text[text.index("["):text.index("]") + 1])).reshape(4, 4)
        np.testing.assert_allclose(matrix, [[1, 0, 0, 0.1], [0, 1, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]], atol=1e-9)
        self.ok("dataset", "out", "-o", "rgbd", "--format", "tum")
        self.assertEqual(len((self.folder / "rgbd/accelerometer.txt").read_text().splitlines()), len(read) + 1)


if __name__ == "__main__":
    main()
