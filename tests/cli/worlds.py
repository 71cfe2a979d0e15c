"""A drive as a world for MuJoCo and Gazebo, and as a USD stage: the ground is the store's, bodies are where the rows say. Where mujoco and usd-core are,
they read what was written; without them the ground alone is checked."""
import importlib.util
import json
import pathlib
import re
import shutil
import struct
import sys
import unittest
import zlib
from xml.etree import ElementTree

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import read_png  # noqa: E402
from furrow_test import main  # noqa: E402
from sensors import SLOPE, SensorsTest, turned  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
SCENE = f"""scene: 1
time_step: 0.002
end_time: 0.2
spacing: 0.0625
soil: {{name: dry_sand}}
redistribute: {{model: scm}}
vehicles:
  - {{name: sled, model: {ROOT}/tests/vehicle/sled.xml, start: {{at: [30, 30], yaw: 25}}, driver: {{hold: {{mast: 0.7}}}}}}
output: {{vehicles: 50, forces: 20}}
objects:
  - {{name: ball, shape: {{sphere: {{radius: 0.5}}}}, sink: 0.1, path: {{points: [[34, 30], [35, 30]], speed: 4}}}}
"""
WITH_PYTHON = {"FURROW_PYTHON": sys.executable}


def write_png8(path, width, height, value):
    """An 8-bit grey PNG; value(x, y) with y from the top."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(value(x, y) for x in range(width)) for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def has(*modules):
    return all(importlib.util.find_spec(module) is not None for module in modules)


FEET = "".join(f'<geom type="sphere" size="0.1" pos="{x} {y} -0.2" mass="2"/>' for x in (-0.4, 0.4) for y in (-0.3, 0.3))
# Each with sensors that tell where its bodies are.
VEHICLES = {
    "swing": ("", "", f"""<body name="hull" pos="0 0 0.4"><freejoint/><geom type="box" size="0.4 0.3 0.1" mass="50"/>{FEET}
      <body name="arm" pos="0 0 0.3"><joint axis="0 1 0"/><joint type="slide" axis="1 0 0" range="-0.1 0.1" limited="true"/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1" contype="0" conaffinity="0"/>
        <body name="plate" pos="0.3 0 0"/></body></body>"""),
    "held": ("", "", """<frame pos="2 1 0" euler="0 0 80"><body name="base" euler="0 0 30"><geom type="box" size="0.1 0.1 0.1" mass="50"/>
      <body name="arm" pos="0 0 0.5"><joint name="base" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/></body></body></frame>"""),
    "stopped": ("fixed: true", "", """<body name="base"><geom type="box" size="0.1 0.1 0.1" mass="50"/>
      <body name="arm" pos="0 0 0.5"><joint name="arm" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/></body></body>"""),
    "rail": ("", "", f"""<body name="cart" pos="0 0 0.4"><joint name="east" type="slide" axis="1 0 0"/><joint name="up" type="slide" axis="0 0 1"/><joint name="pitch" axis="0 1 0"/>
      <geom type="box" size="0.4 0.3 0.1" mass="50"/>{FEET}</body>"""),
    "turned": ("", "forward: -x", f"""<body name="marker" mocap="true" pos="0 3 1"/>
      <body name="hull" pos="0 0 0.4" euler="0 0 50"><freejoint/><geom type="box" size="0.4 0.3 0.1" mass="50"/>{FEET}<body name="top" pos="0.2 0.1 0.3"/></body>"""),
}


def turn_of(roll, pitch, yaw):
    """SDF's: about the fixed x, then y, then z."""
    return turned(np.degrees(yaw), -np.degrees(pitch), np.degrees(roll))


class VehiclesTest(SensorsTest):
    """Vehicles of many kinds are where their own sensors say."""

    def drive_one(self, name):
        start, keys, bodies = VEHICLES[name]
        names = [word for word in re.findall(r'<body name="(\w+)"', bodies) if word != "marker"]
        sensors = "".join(f'<framepos name="{body}" objtype="xbody" objname="{body}"/>' for body in names)
        motor = '<actuator><motor name="swing" joint="arm"/></actuator>' if '<joint name="arm"' in bodies else ""
        (self.folder / "own.xml").write_text(f'<mujoco><option timestep="0.002"/><worldbody>{bodies}</worldbody>{motor}<sensor>{sensors}</sensor></mujoco>')
        scene = SCENE[:SCENE.index("vehicles:")] + f"vehicles:\n  - {{name: it, model: own.xml, {keys + ', ' if keys else ''}start: {{at: [30, 30], yaw: 40{', ' + start if start else ''}}}}}\n"
        self.result = self.driven(scene + "output: {vehicles: 50, sensors: 50}\n", self.ground("level", lambda x: 5), again=True)
        own = {sensor["name"]: np.array([self.result.sensors["it"][column][-1] for column in sensor["columns"]]) for sensor in self.result.sensor_list}
        self.assertEqual(sorted(own), sorted(names))
        return own

    def check_mjcf(self, name, own):
        import mujoco
        told = self.furrow("world", "out", "-o", f"{name}_mjcf", env=WITH_PYTHON)
        self.assertEqual(told.returncode, 0, told.stderr)
        model = mujoco.MjModel.from_xml_path(str(self.folder / f"{name}_mjcf/world.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0) if model.nkey else None
        mujoco.mj_forward(model, data)
        for body, place in own.items():
            np.testing.assert_allclose(data.body(f"it/{body}").xpos, place, atol=1e-6, err_msg=body)
        self.assertEqual([model.body(f"it/{body}").weldid[0] == 0 for body in own if body == "base"], [True] if "base" in own else [])
        return told.stderr

    def check_sdf(self, name, own):
        told = self.furrow("world", "out", "-o", f"{name}_sdf", "--format", "sdf", env=WITH_PYTHON)
        self.assertEqual(told.returncode, 0, told.stderr)
        model = ElementTree.parse(self.folder / f"{name}_sdf/world.sdf").getroot().find("world/model[@name='it']")
        whole = np.array([float(word) for word in model.find("pose").text.split()])
        for body, place in own.items():
            pose = [float(word) for word in model.find(f"link[@name='{body}']/pose").text.split()]
            np.testing.assert_allclose(whole[:3] + turn_of(*whole[3:]) @ pose[:3], place, atol=1e-6, err_msg=body)
        parts = [part.get("name") for kind in ("link", "joint") for part in model.findall(kind)]
        self.assertEqual(len(parts), len(set(parts)), parts)  # links and joints have one namespace
        self.assertTrue(all(float(link.find("inertial/mass").text) > 0 for link in model.findall("link")))
        return told.stderr, {joint.get("name"): (joint.get("type"), joint.find("parent").text, joint.find("child").text) for joint in model.findall("joint")}

    def test_each_is_where_its_sensors_say(self):
        if not has("mujoco"):
            self.skipTest("not on this machine: the Python package mujoco")
        joints = {"swing": {"arm_joint": ("revolute", "hull", "arm"), "joint_plate": ("fixed", "arm", "plate")}, "held": {"hold_base": ("fixed", "world", "base"), "base_joint": ("revolute", "base", "arm")},
                  "stopped": {"hold_base": ("fixed", "world", "base"), "arm_joint": ("revolute", "base", "arm")}, "rail": {"east": ("prismatic", "world", "cart")},
                  "turned": {"hold_marker": ("fixed", "world", "marker"), "joint_top": ("fixed", "hull", "top")}}
        notes = {"swing": "note: it: plate: without mass in the model, with 0.0001 kg in SDF", "stopped": "note: it: its actuators (1) are left out: SDF has none",
                 "rail": "note: it: cart has 3 joints, and SDF takes the first", "turned": "note: it: marker has no rows: it is where own.xml has it"}
        for name in VEHICLES:
            with self.subTest(vehicle=name):
                own = self.drive_one(name)
                self.assertEqual("marker has no rows" in self.check_mjcf(name, own), name == "turned")
                said, found = self.check_sdf(name, own)
                self.assertEqual(found, joints[name])
                self.assertIn(notes.get(name, ""), said)
                self.assertNotIn("is of no joint", said)
                if not has("pxr"):
                    continue
                from pxr import Usd, UsdGeom
                self.made("usd", "out", "-o", f"{name}.usdc")
                stage, rows = Usd.Stage.Open(str(self.folder / f"{name}.usdc")), self.result.vehicles["it"]
                for body, place in own.items():
                    prim = UsdGeom.Xformable.Get(stage, f"/World/it/{body}")
                    if prim:  # it has shapes
                        at = prim.ComputeLocalToWorldTransform(float(rows["t"][-1]) * stage.GetTimeCodesPerSecond()).ExtractTranslation()
                        np.testing.assert_allclose(list(at), place, atol=1e-6, err_msg=body)

    def test_meshes_that_are_not_there_are_left_out(self):
        """A drive tells of them and leaves them out, so what is made of the drive does, too."""
        if not has("mujoco"):
            self.skipTest("not on this machine: the Python package mujoco")
        assets = '<asset><mesh name="lid" file="gone.stl"/><mesh file="away.obj"/><mesh name="one" file="one.obj"/><mesh name="two" file="gone_one.obj"/><texture name="t" type="2d" file="gone.png"/><material name="m" texture="t"/></asset>'
        bodies = (f'<body name="hull" pos="0 0 0.4"><freejoint/><geom type="box" size="0.4 0.3 0.1" mass="50" material="m"/>{FEET}<geom type="mesh" mesh="lid" contype="0" conaffinity="0"/><geom type="mesh" mesh="one" contype="0" conaffinity="0" mass="0"/>'
                  '<body name="arm" pos="0 0 0.3"><joint name="elbow" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><geom type="mesh" mesh="away" contype="0" conaffinity="0"/></body></body>')
        (self.folder / "one.obj").write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")  # its name is the end of another one's
        (self.folder / "own.xml").write_text(f"<mujoco>{assets}<worldbody>{bodies}</worldbody></mujoco>")
        self.driven(SCENE[:SCENE.index("vehicles:")] + "vehicles:\n  - {name: it, model: own.xml, start: {at: [30, 30]}}\noutput: {vehicles: 50}\n", self.ground("level", lambda x: 5), again=True)
        for made in (("world", "out", "-o", "mjcf"), ("world", "out", "-o", "sdf", "--format", "sdf"), *([("usd", "out", "-o", "it.usdc")] if has("pxr") else [])):
            told = self.furrow(*made, env=WITH_PYTHON)
            self.assertEqual(told.returncode, 0, told.stderr)
            for line in ("mesh gone.stl of own.xml is not found", "mesh away.obj of own.xml is not found", "mesh gone_one.obj of own.xml is not found", "image gone.png of own.xml is not found"):
                self.assertEqual(told.stderr.count(line), 1, told.stderr)
            self.assertNotIn("mesh one.obj", told.stderr)
        import mujoco
        model = mujoco.MjModel.from_xml_path(str(self.folder / "mjcf/world.xml"))
        self.assertEqual((model.nmesh, model.body("it/arm").mass[0]), (1, 1))

    def test_a_column_of_no_joint_is_told(self):
        if not has("mujoco"):
            self.skipTest("not on this machine: the Python package mujoco")
        self.drive_one("swing")
        (self.folder / "own.xml").write_text((self.folder / "own.xml").read_text().replace('<joint axis="0 1 0"/>', '<joint name="elbow" axis="0 1 0"/>'))
        self.assertIn("note: it: column q:arm_2 of vehicles.csv is of no joint of own.xml", self.furrow("world", "out", "-o", "site", env=WITH_PYTHON).stderr)

    def made(self, *arguments):
        told = self.furrow(*arguments, env=WITH_PYTHON)
        self.assertEqual(told.returncode, 0, told.stderr)
        return told.stdout


class WorldsTest(SensorsTest):
    def setUp(self):
        super().setUp()
        self.result = self.driven(SCENE, self.ground("slope", lambda x: 2 + np.tan(np.radians(SLOPE)) * x), again=True)

    def made(self, *arguments):
        told = self.furrow(*arguments, env=WITH_PYTHON)
        self.assertEqual(told.returncode, 0, told.stderr)
        return told.stdout

    def surface(self, column, row, columns, rows):
        """Heights by the command, of posts of the working level."""
        window = ",".join(f"{value:.17g}" for value in (column * 0.0625, row * 0.0625, (column + columns - 1) * 0.0625, (row + rows - 1) * 0.0625))
        from furrow import World
        with World({"spacing": 0.0625}, store=self.folder / "ruts.furrow", readonly=True) as world:
            self.assertEqual(window.count(","), 3)
            return world.read("surface", column=column, row=row, columns=columns, rows=rows)

    def test_a_height_field_is_the_ground(self):
        self.made("world", "out", "-o", "site", "--no-vehicles", "--window", "28,29,32,31.5")
        data = (self.folder / "site/ground.bin").read_bytes()
        rows, columns = struct.unpack("<ii", data[:8])
        self.assertEqual((rows, columns), (41, 65))
        field = np.frombuffer(data[8:], "<f4").reshape(rows, columns).astype(float)
        world = ElementTree.parse(self.folder / "site/world.xml").getroot()
        half_x, half_y, reach, base = (float(word) for word in world.find("asset/hfield").get("size").split())
        x, y, z = (float(word) for word in world.find("worldbody/geom").get("pos").split())
        np.testing.assert_allclose([half_x, half_y, x, y, base], [2, 1.25, 30, 30.25, 1], atol=1e-12)
        heights = self.surface(448, 464, 65, 41)
        np.testing.assert_allclose(z + reach * field, heights, atol=1e-6)
        self.assertLess((heights - (2 + np.tan(np.radians(SLOPE)) * (28 + 0.0625 * np.arange(65)))).min(), -0.02) # with ruts

    def check_ground(self, text, ground, steps):
        """The ground that is exported is that of a world over the drive's overlay, whose `ground` stands in its scene. It has steps above `steps`, in metres."""
        from furrow import World
        shutil.rmtree(self.folder / "site", ignore_errors=True)
        self.driven(text.replace("end_time: 0.2", "end_time: 0.02"), "slope.furrow", again=True)
        self.made("world", "out", "-o", "site", "--no-vehicles", "--window", "28,28,32,31")
        data = (self.folder / "site/ground.bin").read_bytes()
        world = ElementTree.parse(self.folder / "site/world.xml").getroot()
        low, reach = float(world.find("worldbody/geom").get("pos").split()[2]), float(world.find("asset/hfield").get("size").split()[2])
        with World({"spacing": 0.0625, **ground}, store=self.folder / "ruts.furrow", readonly=True) as own:
            heights = own.read("surface", column=448, row=448, columns=65, rows=49)
        np.testing.assert_allclose(low + reach * np.frombuffer(data[8:], "<f4").reshape(49, 65), heights, atol=1e-6)
        self.assertGreater(np.abs(np.diff(heights, axis=0)).max(), steps)

    def test_the_ground_has_the_relief_of_the_drive(self):
        """For all ground, and by classes of a map of soils."""
        write_png8(self.folder / "map.png", 65, 65, lambda x, y: 1 if x < 30 else 2 if x < 40 else 0)
        plain = {"roughness": 0.004, "wavelength": 3.0, "seed": 7}
        soil = {"map": str(self.folder / "map.png"), "classes": {"1": "dry_sand", "2": "lete_sand"}, "default": "lunar"}
        by_class = {**plain, "classes": {"2": {"roughness": 0.03}}}
        for relief, ground in ((plain, None), (by_class, soil)):
            with self.subTest(relief=relief):
                text = SCENE.replace("redistribute:", f"relief: {json.dumps(relief)}\nredistribute:")
                if ground:
                    text = text.replace("soil: {name: dry_sand}", "soil: {map: map.png, classes: {1: dry_sand, 2: lete_sand}, default: lunar}")
                self.check_ground(text, {"relief": relief, **({"soil": ground} if ground else {})}, steps=0.001)

    def test_the_ground_has_the_rocks_of_the_drive(self):
        """Alone, and with relief."""
        rocks, relief = {"cover": 0.2, "largest": 1, "smallest": 0.2, "seed": 3}, {"roughness": 0.004, "wavelength": 3.0, "seed": 7}
        for more in ({"ground": {"rocks": rocks}}, {"ground": {"rocks": rocks}, "relief": relief}):
            with self.subTest(more=more):
                text = SCENE.replace("redistribute:", "".join(f"{key}: {json.dumps(value)}\n" for key, value in more.items()) + "redistribute:")
                self.check_ground(text, more, steps=0.05)

    def test_a_heightmap_is_the_ground(self):
        self.made("world", "out", "-o", "gazebo", "--format", "sdf", "--no-vehicles", "--window", "28,28,32,32")
        picture = read_png(self.folder / "gazebo/heightmap.png").astype(float)[::-1]
        self.assertEqual(picture.shape, (65, 65))
        field = ElementTree.parse(self.folder / "gazebo/world.sdf").getroot().find("world/model/link/collision/geometry/heightmap")
        wide, tall, reach = (float(word) for word in field.find("size").text.split())
        x, y, z = (float(word) for word in field.find("pos").text.split())
        np.testing.assert_allclose([wide, tall, x, y], [4, 4, 30, 30], atol=1e-12)
        self.assertEqual((picture.min(), picture.max()), (0, 65535)) # Gazebo scales by the highest
        np.testing.assert_allclose(z + reach * picture / 65535, self.surface(448, 448, 65, 65), atol=0.51 * reach / 65535 + 1e-6)

    def test_mujoco_loads_the_world(self):
        if not has("mujoco"):
            told = self.furrow("world", "out", "-o", "site", env=WITH_PYTHON)
            self.assertEqual(told.returncode, 1)
            self.assertRegex(told.stderr, r"^furrow: world: the Python package mujoco is not installed for \S+; \S+ -m pip install mujoco\n$")
            self.skipTest("not on this machine: the Python package mujoco")
        import mujoco
        self.made("world", "out", "-o", "site")
        model = mujoco.MjModel.from_xml_path(str(self.folder / "site/world.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_forward(model, data)
        rows = self.result.vehicles["sled"]
        np.testing.assert_allclose(data.body("sled/hull").xpos, [rows[axis][-1] for axis in "xyz"], atol=1e-9)
        np.testing.assert_allclose(data.body("sled/hull").xmat.reshape(3, 3), turned(rows["yaw"][-1], rows["pitch"][-1], rows["roll"][-1]), atol=1e-9)
        self.assertAlmostEqual(data.joint("sled/mast").qpos[0], rows["q:mast"][-1], delta=1e-9)
        # It stands in its ruts, and stays.
        for _ in range(500):
            mujoco.mj_step(model, data)
        self.assertGreater(data.ncon, 3)
        self.assertLess(np.linalg.norm(data.body("sled/hull").xpos - [rows[axis][-1] for axis in "xyz"]), 0.1)

    def test_gazebos_model_is_where_the_rows_say(self):
        if not has("mujoco"):
            self.skipTest("not on this machine: the Python package mujoco")
        self.made("world", "out", "-o", "gazebo", "--format", "sdf")
        model = ElementTree.parse(self.folder / "gazebo/world.sdf").getroot().find("world/model[@name='sled']")
        rows = self.result.vehicles["sled"]
        pose = [float(word) for word in model.find("pose").text.split()]
        np.testing.assert_allclose(pose[:3], [rows[axis][-1] for axis in "xyz"], atol=1e-9)
        np.testing.assert_allclose(turned(np.degrees(pose[5]), -np.degrees(pose[4]), np.degrees(pose[3])), turned(rows["yaw"][-1], rows["pitch"][-1], rows["roll"][-1]), atol=1e-9)
        self.assertAlmostEqual(sum(float(mass.text) for mass in model.iter("mass")), 101, delta=1e-9)
        self.assertEqual(sorted(joint.get("type") for joint in model.iter("joint")), ["fixed"] * 4 + ["revolute"])
        mast = [float(word) for word in model.find("link[@name='mast']/pose").text.split()]
        np.testing.assert_allclose(mast, [-0.4, 0, 0.1, 0, 0, rows["q:mast"][-1]], atol=1e-9)

    def test_a_stage_has_ground_and_motion(self):
        if not has("pxr", "mujoco"):
            told = self.furrow("usd", "out", "-o", "world.usdc", env=WITH_PYTHON)
            self.assertEqual(told.returncode, 1)
            self.assertRegex(told.stderr, r"^furrow: usd: the Python package (usd-core|mujoco) is not installed for \S+; \S+ -m pip install (usd-core|mujoco)\n$")
            self.skipTest("not on this machine: the Python packages usd-core and mujoco")
        from pxr import Usd, UsdGeom
        self.made("usd", "out", "-o", "world.usdc", "--window", "28,28,36,32")
        stage = Usd.Stage.Open(str(self.folder / "world.usdc"))
        self.assertEqual((UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage), str(stage.GetDefaultPrim().GetPath())), ("Z", 1.0, "/World"))
        ground = UsdGeom.Mesh.Get(stage, "/World/ground")
        points = np.array(ground.GetPointsAttr().Get(), float) + list(ground.GetPrim().GetAttribute("xformOp:translate").Get())
        np.testing.assert_allclose(points[:, 2].reshape(65, 129), self.surface(448, 448, 129, 65), atol=1e-6)
        np.testing.assert_allclose(points[[0, -1], :2], [[28, 28], [36, 32]], atol=1e-6)
        st = np.array(UsdGeom.PrimvarsAPI(ground).GetPrimvar("st").Get())
        self.assertEqual(len(st), len(points))
        self.assertEqual(read_png(self.folder / "world_ground.png").shape[:2], (65, 129))
        rows = self.result.vehicles["sled"]
        for i, t in enumerate(rows["t"]):
            matrix = np.array(UsdGeom.Xformable.Get(stage, "/World/sled/hull").ComputeLocalToWorldTransform(t * stage.GetTimeCodesPerSecond())).T
            np.testing.assert_allclose(matrix[:3, 3], [rows[axis][i] for axis in "xyz"], atol=1e-9)
            np.testing.assert_allclose(matrix[:3, :3], turned(rows["yaw"][i], rows["pitch"][i], rows["roll"][i]), atol=1e-9)
        foot = np.array(UsdGeom.Xformable.Get(stage, "/World/sled/foot_a").ComputeLocalToWorldTransform(0)).T
        hull = np.array(UsdGeom.Xformable.Get(stage, "/World/sled/hull").ComputeLocalToWorldTransform(0)).T
        np.testing.assert_allclose(np.linalg.inv(hull) @ foot, [[1, 0, 0, 0.5], [0, 1, 0, 0.35], [0, 0, 1, -0.35], [0, 0, 0, 1]], atol=1e-9)
        ball, last = self.result.objects["ball"], UsdGeom.Xformable.Get(stage, "/World/objects/ball")
        at = last.ComputeLocalToWorldTransform(float(ball["t"][-1]) * stage.GetTimeCodesPerSecond()).ExtractTranslation()
        np.testing.assert_allclose(list(at), [ball[axis][-1] for axis in "xyz"], atol=1e-9)
        validate = importlib.util.find_spec("pxr.UsdValidation")
        if validate is not None:
            from pxr import UsdValidation
            context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
            self.assertEqual([error.GetMessage() for error in context.Validate(stage)], [])

    def test_what_is_wrong_is_one_line(self):
        for arguments, status, words in ((("world", "out"), 2, "-o is missing"), (("usd", "out"), 2, "-o is missing"), (("world", "nowhere", "-o", "x"), 3, "run.json"),
                                         (("world", "out", "-o", "x", "--no-vehicles", "--window", "1,2,3"), 3, "no rectangle"),
                                         (("world", "out", "-o", "x", "--no-vehicles", "--window", "900,900,910,910"), 3, "has no ground")):
            told = self.furrow(*arguments, env=WITH_PYTHON)
            self.assertEqual(told.returncode, status, (arguments, told.stderr))
            self.assertRegex(told.stderr, r"^furrow: .+; .+\n$")
            self.assertIn(words, told.stderr)
        self.assertFalse((self.folder / "x").exists())


del SensorsTest # its own tests are not of this file

if __name__ == "__main__":
    main()
