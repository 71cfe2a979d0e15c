"""tools/zoo.py on a folder of small models of our own: each drives, stands, swings, or has one line that says why not. And `furrow model`."""
import json
import pathlib
import re
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from furrow_test import FURROW, FurrowTest, long  # noqa: E402

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
import zoo  # noqa: E402

INERTIAL = '<inertial><mass value="%g"/><inertia ixx="%g" iyy="%g" izz="%g" ixy="0" ixz="0" iyz="0"/></inertial>'


def inertial(mass, moment):
    return INERTIAL % (mass, moment, moment, moment)


def cart(name="cart", material=""):
    wheels = ""
    for side, y in (("l", 0.45), ("r", -0.45)):
        for end, x in (("f", 0.4), ("b", -0.4)):
            wheels += (f'<link name="{end}{side}">{inertial(4, 0.1)}<visual><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.25" length="0.12"/></geometry>{material}</visual></link>'
                       f'<joint name="wheel_{end}{side}" type="continuous"><parent link="base"/><child link="{end}{side}"/><origin xyz="{x} {y} -0.1"/><axis xyz="0 1 0"/>'
                       '<limit effort="60" velocity="20"/></joint>')
    return f'<robot name="{name}"><link name="base">{inertial(40, 3)}<collision><geometry><box size="1 0.6 0.15"/></geometry></collision></link>{wheels}</robot>'


WALKER = """<mujoco><option timestep="0.002"/><worldbody><geom type="plane" size="9 9 1"/><body name="trunk" pos="0 0 0.4"><freejoint/><geom type="box" size="0.3 0.2 0.05" mass="8"/>%s</body></worldbody>
<actuator>%s</actuator><keyframe><key name="home" qpos="0 0 0.4 1 0 0 0 0 0 0 0" ctrl="0 0 0 0"/></keyframe></mujoco>""" % (
    "".join('<body pos="%g %g 0"><joint name="hip_%d" axis="0 1 0" range="-60 60" damping="2"/><geom type="capsule" size="0.03" fromto="0 0 0 0 0 -0.3" mass="0.5"/></body>' % (x, y, i)
            for i, (x, y) in enumerate(((0.25, 0.2), (0.25, -0.2), (-0.25, 0.2), (-0.25, -0.2)))),
    "".join('<position name="p%d" joint="hip_%d" kp="300" ctrlrange="-1 1"/>' % (i, i) for i in range(4)))
ARM = ('<robot name="arm"><link name="world"/><link name="foot">%s<collision><geometry><box size="0.4 0.4 0.2"/></geometry></collision></link><joint name="bolt" type="fixed"><parent link="world"/>'
       '<child link="foot"/><origin xyz="0 0 0.1"/></joint><link name="upper">%s<collision><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision></link>'
       '<joint name="shoulder" type="revolute"><parent link="foot"/><child link="upper"/><origin xyz="0 0 0.12"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="80" velocity="2"/></joint></robot>'
       % (inertial(10, 0.2), inertial(2, 0.05)))
MODELS = {"cart/cart.urdf": cart(), "walker.xml": WALKER, "arm.urdf": ARM, "broken.urdf": "<robot name='r'>\n<link name='a'>\n</robot>\n",
          "macros.urdf": '<robot name="r" xmlns:xacro="x"><xacro:macro name="m"/></robot>', "nan.xml": '<mujoco><worldbody><body><freejoint/><geom size="nan"/></body></worldbody></mujoco>',
          "scene.xml": '<mujoco><include file="walker.xml"/><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>', "package.xml": "<package><name>p</name></package>",
          "launch.xml": "<launch/>"}


class Zoo(FurrowTest):
    def setUp(self):
        super().setUp()
        for name, text in MODELS.items():
            path = self.folder / "models" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        self.command = [sys.executable, str(TOOLS / "zoo.py"), str(self.folder / "models"), "-o", str(self.folder / "out"), "--furrow", FURROW, "--no-pictures"]

    def test_a_scene_says_where_it_looks_and_what_is_locked(self):
        """Wheels whose axles look along x drive along y. A leg whose motor gives a force alone would hang."""
        wheels = "".join('<body pos="%g 0 0"><joint name="turn_%s" axis="1 0 0"/><geom type="cylinder" size="0.2 0.05" euler="0 90 0" mass="2"/></body>' % (x, side) for side, x in (("l", -0.4), ("r", 0.4)))
        path = self.folder / "looks.xml"
        path.write_text('<mujoco><compiler autolimits="true"/><worldbody><body pos="0 0 0.2"><freejoint/><geom type="box" size="0.3 0.5 0.1" mass="20"/>' + wheels +
                        '<body pos="0 0 0.2"><joint name="hip" axis="0 1 0" range="-40 40"/><geom type="box" size="0.3 0.05 0.05" mass="1"/></body></body></worldbody>'
                        '<actuator><velocity name="turn_l" joint="turn_l" kv="5"/><velocity name="turn_r" joint="turn_r" kv="5"/><motor name="hip" joint="hip"/></actuator></mujoco>')
        seen = json.loads(self.furrow("model", path, "--json").stdout)
        self.assertEqual(seen["forward"], "+y")
        scene = zoo.Plan(seen, path, []).write_scene(self.folder, "plain", False).read_text()
        self.assertIn(", forward: +y", scene)
        self.assertIn(', servo: {lock: ["hip"]}', scene)
        self.assertIn("forward: +y", self.furrow("model", path).stdout)

    def test_each_moves_or_says_why(self):
        done = subprocess.run(self.command, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        models = {each["name"]: each for each in json.loads((self.folder / "out/zoo.json").read_text())["models"]}
        self.assertEqual(set(models), {"cart/cart.urdf", "walker.xml", "arm.urdf", "broken.urdf", "macros.urdf", "nan.xml"})
        for ground in ("plain", "hill"):
            drive = models["cart/cart.urdf"]["drives"][ground]
            self.assertTrue(drive["moves"], drive)
            self.assertGreater(drive["distance"], 4.5)
        self.assertIn("turn and have no collision", " ".join(models["cart/cart.urdf"]["notes"]))
        self.assertTrue(models["walker.xml"]["drives"]["plain"]["stands"])
        self.assertGreater(models["walker.xml"]["drives"]["plain"]["travel"], 0.1)
        self.assertEqual(models["arm.urdf"]["kind"], "held")
        self.assertGreater(models["arm.urdf"]["drives"]["plain"]["travel"], 0.1)
        for name, why in (("broken.urdf", "line 4: its XML is not whole"), ("macros.urdf", "expand it first: xacro"), ("nan.xml", "; ")):
            self.assertFalse(models[name]["loads"])
            self.assertIn(why, models[name]["why"])
            self.assertNotIn("\n", models[name]["why"])
        table = (self.folder / "out/zoo.md").read_text()
        self.assertIn("6 models: 3 load, 3 move", table)
        self.assertEqual(len(re.findall(r"^\| (?!model |---)", table, re.M)), 6)
        # What is known is not driven again.
        begun = time.monotonic()
        again = subprocess.run(self.command, capture_output=True, text=True, check=False)
        self.assertEqual(again.returncode, 0)
        self.assertLess(time.monotonic() - begun, 20)
        self.assertEqual(sorted(again.stdout.splitlines()[-1:]), sorted(done.stdout.splitlines()[-1:]))

    @long
    def test_it_stops_and_goes_on(self):
        process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first = process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("the same command goes on", told)
        done = subprocess.run(self.command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0)
        self.assertIn(first.split(": ", 1)[1], done.stdout)

    def test_models_are_found(self):
        found = {str(path.relative_to(self.folder / "models")) for path in zoo.find_models(self.folder / "models")}
        self.assertEqual(found, {"cart/cart.urdf", "walker.xml", "arm.urdf", "broken.urdf", "macros.urdf", "nan.xml"})


class Model(FurrowTest):
    def model(self, text, *arguments, name="m.urdf"):
        (self.folder / name).write_text(text)
        return self.furrow("model", self.folder / name, *arguments)

    def test_it_tells_what_a_model_has(self):
        seen = json.loads(self.model(cart(), "--json").stdout)
        self.assertEqual([joint["role"] for joint in seen["joints"]], ["drives"] * 4)
        self.assertEqual([joint["radius"] for joint in seen["joints"]], [0.25] * 4)
        self.assertEqual((seen["kind"], seen["mass"], seen["free"], seen["actuators"]), ("wheels", 56, True, []))
        self.assertTrue(any("no collision: what is seen of them collides" in note for note in seen["notes"]))
        text = self.model(cart()).stdout
        self.assertIn("drive: [wheel_fl, wheel_bl, wheel_fr, wheel_br]", text)
        self.assertFalse(json.loads(self.model(cart(), "--json", "--fixed", "true").stdout)["free"])
        self.assertEqual(self.model(cart(), "--fixed", "maybe").returncode, 2)

    def test_wrong_models_have_one_line(self):
        base = '<mujoco><worldbody>%s</worldbody></mujoco>'
        cases = {
            "no joint": base % '<body name="b"><geom size="1"/></body>', "nothing": base % "", "negative mass": base % '<body><freejoint/><geom size="1" mass="-1"/></body>',
            "not a number": base % '<body pos="nan 0 0"><freejoint/><geom size="1"/></body>', "another version": base % '<body><freejoint/><geom size="1" of_a_later_version="1"/></body>',
            "nan in a URDF": '<robot name="r"><link name="a">%s<collision><origin xyz="0 nan 0"/><geometry><sphere radius="1"/></geometry></collision></link></robot>' % inertial(1, 1), "another element": base % "<novelty/>", "empty": "", "no XML": "v 1 2 3\n", "cut": "<mujoco><worldbody>", "inertia": '<robot name="r"><link name="a">%s</link></robot>' % INERTIAL % (-5, 1, 1, 1),
            "loop": '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint><joint name="k" type="fixed"><parent link="b"/>'
                    '<child link="a"/></joint></robot>',
            "no mesh": '<robot name="r"><link name="a">%s<collision><geometry><mesh filename="none.stl"/></geometry></collision></link></robot>' % inertial(1, 1),
        }
        for name, text in cases.items():
            with self.subTest(name):
                begun = time.monotonic()
                done = self.model(text, name="m.xml")
                self.assertEqual(done.returncode, 3, done.stdout)
                errors = [line for line in done.stderr.splitlines() if not line.startswith("furrow: note: ")]
                self.assertEqual(len(errors), 1, errors)
                self.assertRegex(errors[0], r"^furrow: model: .*; ")
                self.assertLess(time.monotonic() - begun, 20)

    def test_a_million_triangles(self):
        """They are taken, or refused with what to do, within seconds."""
        side = 708
        lines = ["v %d %d %g" % (i % side, i // side, ((i * 7919) % 13) / 13) for i in range(side * side)]
        for y in range(side - 1):
            for x in range(side - 1):
                a = y * side + x + 1
                lines.append("f %d %d %d\nf %d %d %d" % (a, a + 1, a + side, a + 1, a + side + 1, a + side))
        (self.folder / "many.obj").write_text("\n".join(lines) + "\n")
        begun = time.monotonic()
        done = self.model('<robot name="r"><link name="a">%s<collision><geometry><mesh filename="many.obj" scale="0.001 0.001 0.1"/></geometry></collision></link></robot>' % inertial(1, 1))
        self.assertIn(done.returncode, (0, 3), done.stderr)
        self.assertLess(time.monotonic() - begun, 60)


if __name__ == "__main__":
    unittest.main()
