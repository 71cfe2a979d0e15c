"""A drive as a bag for ROS 2 and as datasets: positions, times and pictures are those of the drive. Where the packages mcap, mcap-ros2-support and rosbags
are, rosbags reads the bag; without them the messages are read before they are packed."""
import atexit
import csv
import importlib.util
import json
import pathlib
import shutil
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main, need_vehicles, use_package

ROOT = pathlib.Path(__file__).parents[2]
SCENE = f"""scene: 1
time_step: 0.002
end_time: 0.4
spacing: 0.125
soil: {{name: dry_sand}}
redistribute: {{model: scm}}
vehicles:
  - {{name: cart, model: {ROOT}/tests/vehicle/one_wheel.xml, start: {{at: [20, 20], yaw: 40}}}}
output: {{forces: 20, vehicles: 50}}
cameras:
  - {{name: nav, kind: mounted, on: cart, pose: {{at: [0.6, 0.1, 1], yaw: 8, pitch: -20}}, rate: 10, size: [64, 48], fov: 70, images: [colour, depth], stereo: 0.2}}
  - {{name: post, kind: fixed, pose: {{at: [15, 15, 40], target: [20, 20, 25]}}, rate: 5, size: [64, 48], images: [colour]}}
"""


class BagTest(FurrowTest):
    driven = None # the folder of the one drive of all tests

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        use_package()
        need_vehicles()

    def setUp(self):
        super().setUp()
        self.synth("plain.furrow", spacing=0.25, relief=4)
        self.scene(SCENE)
        if BagTest.driven is None:
            self.drive("scene.yaml", "--store", "plain.furrow", "--overlay", "ruts.furrow")
            BagTest.driven = pathlib.Path(tempfile.mkdtemp(prefix="furrow-cli-"))
            atexit.register(shutil.rmtree, BagTest.driven, ignore_errors=True)
            shutil.copytree(self.folder / "out", BagTest.driven / "out")
        shutil.copytree(BagTest.driven / "out", self.folder / "out", dirs_exist_ok=True)

    def rows(self):
        with open(self.folder.joinpath("out/vehicles.csv"), newline="") as file:
            return list(csv.DictReader(file))


class MessagesTest(BagTest):
    def setUp(self):
        super().setUp()
        from furrow import bag, results
        drive = results.Drive(self.folder.joinpath("out"))
        sources = ([bag._of_vehicle(*each, []) for each in drive.vehicles.items()] + [bag._of_object(*each) for each in drive.objects.items()]
                   + [bag._of_camera(*each, True) for each in drive.cameras.items()])
        self.messages = list(bag._in_time(sources))

    def of(self, topic):
        return [(ns, message) for ns, at, _, message in self.messages if at == topic]

    def test_times_grow_and_a_clock_comes_first(self):
        times = [ns for ns, *_ in self.messages]
        self.assertEqual(times, sorted(times))
        told = {}
        for ns, topic, *_ in self.messages:
            self.assertTrue(topic == "/clock" or ns in told, (ns, topic))
            told.setdefault(ns, topic)
        self.assertEqual(len(self.of("/clock")), len(told))

    def test_odometry_is_vehicles_csv(self):
        rows = self.rows()
        odometry = self.of("/cart/odom")
        self.assertEqual(len(odometry), len(rows))
        for (ns, message), row in zip(odometry, rows):
            self.assertEqual(ns, round(float(row["t"]) * 1e9))
            at, turn = message["pose"]["pose"]["position"], message["pose"]["pose"]["orientation"]
            self.assertEqual([at[axis] for axis in "xyz"], [float(row[axis]) for axis in "xyz"])
            x, y, z, w = (turn[axis] for axis in "xyzw")
            self.assertAlmostEqual(x * x + y * y + z * z + w * w, 1, delta=1e-12)
            yaw, pitch, roll = (np.radians(float(row[name])) for name in ("yaw", "pitch", "roll"))
            forward = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
            left = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
            np.testing.assert_allclose(forward, [np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)], atol=1e-9)
            self.assertAlmostEqual(left[2], np.cos(pitch) * np.sin(roll), delta=1e-9)
            velocity = [float(row[name]) for name in ("vx", "vy", "vz")]
            self.assertAlmostEqual(message["twist"]["twist"]["linear"]["x"], float(np.dot(forward, velocity)), delta=1e-9)

    def test_topics_are_as_ros_takes_them(self):
        """It takes A-Z a-z 0-9 _, and no digit first."""
        from furrow import bag, results
        drive = results.Drive(self.folder.joinpath("out"))
        rows = drive.vehicles["cart"]
        found = {topic for name in ("2nd cart", "team/a-b") for _, topic, *_ in bag._of_vehicle(name, rows, [])}
        found |= {topic for name in ("3", "nav-left") for _, topic, *_ in bag._of_camera(name, drive.cameras["nav"], True)}
        found |= {topic for _, topic, *_ in bag._of_object("cart-2.wheel-1", drive.objects["cart.wheel"])}
        self.assertEqual(found - {"/tf"}, {f"/{name}" for name in ("_2nd_cart/odom", "_2nd_cart/joint_states", "team/a_b/odom", "team/a_b/joint_states", "cart_2/wheel_1/soil")}
                         | {f"/{camera}/{topic}" for camera in ("_3", "nav_left") for topic in ("camera_info", "image_raw/compressed", "depth/image_raw", "points")})
        for sources in ([bag._of_vehicle("a-b", rows, []), bag._of_vehicle("a_b", rows, [])], [bag._of_camera("nav", drive.cameras["nav"], False), bag._of_camera("nav", drive.cameras["nav"], False)]):
            with self.assertRaisesRegex(results.ResultsError, "two parts of the drive have the (topic /a_b/odom|frame nav), and topics have .*; give one of them another name"):
                list(bag._in_time(sources))

    def test_turn_rates_are_those_of_a_steady_turn(self):
        from furrow import results
        t = np.linspace(0, 2, 81)
        for tilt in (0, 40):
            rows = {"t": t, "yaw": np.degrees(3.0 * t), "pitch": np.zeros(81), "roll": np.full(81, float(tilt))}
            rates = results.turn_rates(t, results.quaternions(rows))
            np.testing.assert_allclose(rates, np.tile([0, 3 * np.sin(np.radians(tilt)), 3 * np.cos(np.radians(tilt))], (81, 1)), atol=1e-9)

    def test_a_camera_is_where_its_vehicle_carries_it(self):
        """map -> cart/base_link and map -> nav give the mount of the scene."""
        base = {ns: m["transforms"][0]["transform"] for ns, m in self.of("/tf") if m["transforms"][0]["child_frame_id"] == "cart/base_link"}
        seen = 0
        from furrow import results
        for ns, message in self.of("/tf"):
            if message["transforms"][0]["child_frame_id"] != "nav" or ns not in base:
                continue
            own, of = message["transforms"][0]["transform"], base[ns]
            axes = results.matrices(np.array([[of["rotation"][k] for k in "xyzw"]]))[0]
            between = np.array([own["translation"][k] - of["translation"][k] for k in "xyz"])
            np.testing.assert_allclose(axes.T @ between, [0.6, 0.1, 1], atol=2e-6) # rows have 9 digits
            view = results.matrices(np.array([[own["rotation"][k] for k in "xyzw"]]))[0][:, 2]
            np.testing.assert_allclose(axes.T @ view, [np.cos(np.radians(-20)) * np.cos(np.radians(8)), np.cos(np.radians(-20)) * np.sin(np.radians(8)), np.sin(np.radians(-20))], atol=2e-6)
            seen += 1
        self.assertGreaterEqual(seen, 4)

    def test_pictures_are_the_files(self):
        for topic, folder in (("/nav/image_raw/compressed", "nav/colour"), ("/post/image_raw/compressed", "post/colour")):
            files = sorted(self.folder.joinpath("out/cameras", folder).glob("*.png"))
            self.assertEqual([m["data"] for _, m in self.of(topic)], [file.read_bytes() for file in files])
        for (_, depth), file in zip(self.of("/nav/depth/image_raw"), sorted(self.folder.joinpath("out/cameras/nav/depth").glob("*.npy"))):
            self.assertEqual(depth["data"], np.load(file).tobytes())

    def test_a_cloud_lies_on_the_rays_of_its_pixels(self):
        camera = json.loads(self.folder.joinpath("out/cameras/nav/camera.json").read_text())
        (_, cloud), (_, depth), (_, info) = (self.of(f"/nav/{topic}")[1] for topic in ("points", "depth/image_raw", "camera_info"))
        points = np.frombuffer(cloud["data"], "<f4").reshape(-1, 3)
        picture = np.frombuffer(depth["data"], "<f4").reshape(48, 64)
        self.assertEqual(len(points), np.isfinite(picture).sum())
        columns = points[:, 0] / points[:, 2] * info["k"][0] + info["k"][2] # ROS: from the first pixel's centre
        np.testing.assert_allclose(columns, np.nonzero(np.isfinite(picture))[1], atol=1e-3)
        self.assertEqual(info["k"][2], camera["cx"] - 0.5)
        (_, right), = self.of("/nav_right/camera_info")[:1]
        self.assertAlmostEqual(right["p"][3], -camera["fx"] * 0.2, delta=1e-9)


class FilesTest(BagTest):
    def test_another_reader_reads_the_bag(self):
        if any(importlib.util.find_spec(name) is None for name in ("mcap_ros2", "rosbags")):
            told = self.furrow("bag", "out", "-o", "run.mcap")
            self.assertEqual(told.returncode, 1)
            self.assertRegex(told.stderr, r"^furrow: bag: the Python package mcap-ros2-support is not installed for \S+; \S+ -m pip install mcap-ros2-support\n$")
            self.skipTest("not on this machine: the Python packages mcap-ros2-support and rosbags")
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
        self.furrow("bag", "out", "-o", "run.mcap", env={"FURROW_PYTHON": sys.executable})
        with AnyReader([self.folder.joinpath("run.mcap")], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            read = [(t, c.topic, reader.deserialize(raw, c.msgtype)) for c, t, raw in reader.messages()]
        odometry = [m for _, topic, m in read if topic == "/cart/odom"]
        self.assertEqual([m.pose.pose.position.x for m in odometry], [float(row["x"]) for row in self.rows()])
        colours = [bytes(m.data) for _, topic, m in read if topic == "/nav/image_raw/compressed"]
        self.assertEqual(colours, [file.read_bytes() for file in sorted(self.folder.joinpath("out/cameras/nav/colour").glob("*.png"))])

    def test_euroc_has_the_mount_and_the_truth(self):
        self.ok("dataset", "out", "-o", "sequence")
        own = self.folder.joinpath("sequence/mav0")
        truth = [line.split(",") for line in (own / "state_groundtruth_estimate0/data.csv").read_text().splitlines()[1:]]
        self.assertEqual([[int(line[0]), *map(float, line[1:4])] for line in truth],
                         [[round(float(row["t"]) * 1e9), *(float(row[axis]) for axis in "xyz")] for row in self.rows()])
        text = (own / "cam0/sensor.yaml").read_text()
        matrix = np.array(json.loads(text[text.index("["):text.index("]") + 1])).reshape(4, 4)
        np.testing.assert_allclose(matrix[:3, 3], [0.6, 0.1, 1], atol=2e-6)
        right = (own / "cam1/sensor.yaml").read_text()
        other = np.array(json.loads(right[right.index("["):right.index("]") + 1])).reshape(4, 4)
        np.testing.assert_allclose(np.linalg.inv(matrix) @ other, [[1, 0, 0, 0.2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=5e-6)
        listed = [line.split(",")[1] for line in (own / "cam0/data.csv").read_text().splitlines()[1:]]
        self.assertEqual([(own / "cam0/data" / name).read_bytes() for name in listed],
                         [file.read_bytes() for file in sorted(self.folder.joinpath("out/cameras/nav/colour").glob("*.png"))])

    def test_tum_has_depth_in_its_units(self):
        self.ok("dataset", "out", "-o", "rgbd", "--format", "tum", "--camera", "nav")
        lines = self.folder.joinpath("rgbd/depth.txt").read_text().splitlines()[1:]
        self.assertEqual(len(lines), len(list(self.folder.joinpath("out/cameras/nav/depth").glob("*.npy"))))
        sys.path.insert(0, str(pathlib.Path(__file__).parent))
        from cameras import read_png
        for line, file in zip(lines, sorted(self.folder.joinpath("out/cameras/nav/depth").glob("*.npy"))):
            depth, picture = np.load(file), read_png(self.folder / "rgbd" / line.split()[1])
            near = depth < 13.1
            self.assertGreater(near.sum(), 100)
            np.testing.assert_allclose(picture[near] / 5000, depth[near], atol=1.01e-4)
            self.assertTrue((picture[~np.isfinite(depth)] == 0).all())
        poses = [line.split() for line in self.folder.joinpath("rgbd/groundtruth.txt").read_text().splitlines()[1:]]
        frames = json.loads(self.folder.joinpath("out/cameras/nav/camera.json").read_text())["frames"]
        self.assertEqual([[float(value) for value in line[1:4]] for line in poses], [frame["position"] for frame in frames])

    def test_what_is_wrong_is_one_line(self):
        for arguments, status, words in ((("dataset", "out"), 2, "-o is missing"), (("dataset", "nowhere", "-o", "x"), 3, "run.json"),
                                         (("dataset", "out", "-o", "x", "--camera", "mast"), 3, "mast"), (("bag", "out"), 2, "-o is missing"),
                                         (("dataset", "out", "-o", "x", "--format", "tum", "--camera", "post"), 3, "colour and depth")):
            told = self.furrow(*arguments)
            self.assertEqual(told.returncode, status, (arguments, told.stderr))
            self.assertRegex(told.stderr, r"^furrow: .+: .+; .+\n$")
            self.assertIn(words, told.stderr)
        self.assertFalse(self.folder.joinpath("x").exists())
        self.folder.joinpath("x").mkdir()
        self.assertEqual(self.furrow("dataset", "out", "-o", "x").returncode, 3)


if __name__ == "__main__":
    main()
