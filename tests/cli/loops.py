"""furrow.mujoco: the soil under a user's own model and loop in Python. Where this Python has no package mujoco, only that it says so is tested."""
import importlib.util
import os
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, FurrowTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(FURROW).resolve().parents[1]
WHEEL = (ROOT / "tests/vehicle/one_wheel.xml").read_text()
HEAD = f"""
import sys
sys.path.insert(0, {str(BUILD / "python")!r})
"""
COMMON = HEAD + """
import mujoco, numpy as np, furrow, furrow.mujoco
G = 9.80665
SCENE = {"spacing": 0.0625, "soil": {"name": "dry_sand"}, "redistribute": {"model": "scm"}}
BALL = f'''<mujoco><option timestep="0.002" gravity="0 0 -{G}"/><worldbody><body name="b" pos="0 0 .2"><freejoint/>
<geom name="ball" type="sphere" size=".2" mass="20"/></body></worldbody></mujoco>'''

def loop(text, geoms, steps, prepare=lambda data: None, control=lambda time, data: None, seconds=None):
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    world = furrow.World(SCENE, store="plain.furrow", overlay="loop.furrow")
    soil = furrow.mujoco.Soil(world, model, data, geoms=geoms, origin=(10, 10.5, 0))
    prepare(data)
    for _ in range(steps):
        control(data.time, data)
        soil.apply()
        mujoco.mj_step(model, data)
        soil.commit()
    return world, soil, model, data

def refused(words, function, *arguments, **named):
    try:
        function(*arguments, **named)
    except (furrow.Error, ImportError) as error:
        assert words in str(error) and chr(10) not in str(error), error
        return
    raise AssertionError(f"not refused: {words}")
"""


class LoopTest(FurrowTest):
    def setUp(self):
        super().setUp()
        self.synth("plain.furrow", "129x129", 0.25, "plain", 0)

    def run_script(self, text):
        environment = dict(os.environ, FURROW_LIBRARY=str(BUILD / "src" / "libfurrow.so.0"))
        return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=self.folder, env=environment, timeout=300)

    def check_script(self, text):
        if importlib.util.find_spec("mujoco") is None:
            self.skipTest("not on this machine: the Python package mujoco")
        result = self.run_script(COMMON + text)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def test_without_mujoco_it_names_the_package(self):
        result = self.run_script(HEAD + "sys.modules['mujoco'] = None\nimport furrow.mujoco")
        self.assertEqual(result.returncode, 1)
        self.assertIn("pip install mujoco", result.stderr.splitlines()[-1])

    def test_a_ball_rests_at_its_weight_and_a_reset_is_the_start(self):
        self.check_script("""
def push(data):
    data.qvel[0] = 0.3
    data.qfrc_applied[1] = 0.25  # the user's own
world, soil, model, data = loop(BALL, "ball", 1000, push)
contact = soil.contact("ball")
assert abs(contact.force[2] - 20 * G) < 0.01 * 20 * G and abs(data.qvel[2]) < 1e-3, (contact.force, data.qvel)
assert soil.geoms == ["ball"] and 0.01 < contact.sinkage < 0.05 and data.qpos[2] < 0.19
assert list(data.qfrc_applied) == [0, 0.25, 0, 0, 0, 0], data.qfrc_applied
end = data.qpos.copy()
for _ in range(3):
    soil.reset()
    mujoco.mj_resetData(model, data)
    push(data)
    for _ in range(1000):
        soil.apply()
        mujoco.mj_step(model, data)
        soil.commit()
    assert (data.qpos == end).all()
world.close()
""")

    def test_a_force_from_outside_counts(self):
        self.check_script("""
def press(data): data.xfrc_applied[1, 2] = -100
world, soil, model, data = loop(BALL, "ball", 1500, press)
assert abs(soil.contact(0).force[2] - 20 * G - 100) < 0.01 * 20 * G, soil.contact(0).force
""")

    def test_the_plugin_goes_the_same_way(self):
        wheel = WHEEL.replace('pos="0 0 0.5"', 'pos="0 0 0.321"').replace("<option", '<option gravity="0 0 -9.80665"')
        if not self.check_script("print(mujoco.__version__)").startswith("4."):
            self.skipTest("not on this machine: MuJoCo 4 in this Python, for which the plugin is")
        self.check_script(f"WHEEL = {wheel!r}" + """
def control(time, data): data.ctrl[0] = 2 * min(time, 1)
world, soil, model, data = loop(WHEEL, "wheel", 800, control=control)
mujoco.mj_loadPluginLibrary(furrow.mujoco.plugin())
head = '''<extension><plugin plugin="furrow.soil"><instance name="ground"><config key="scene" value="{scene: 1, spacing: 0.0625, soil: {name: dry_sand},
redistribute: {model: scm}}"/><config key="store" value="plain.furrow"/><config key="geoms" value="wheel"/><config key="origin" value="10 10.5"/></instance></plugin></extension><worldbody>'''
text = WHEEL.replace("<worldbody>", head).replace('<joint name="x"', '<plugin plugin="furrow.soil" instance="ground"/><joint name="x"')
text = text.replace("</mujoco>", '<sensor><plugin plugin="furrow.soil" instance="ground" objtype="geom" objname="wheel"/></sensor></mujoco>')
model2 = mujoco.MjModel.from_xml_string(text)
data2 = mujoco.MjData(model2)
for _ in range(800):
    control(data2.time, data2)
    mujoco.mj_step(model2, data2)
assert data.qpos[0] > 0.4 and abs(data.qpos[0] - data2.qpos[0]) < 1e-3 * data.qpos[0], (data.qpos, data2.qpos)
assert abs(soil.contact("wheel").sinkage - data2.sensordata[1]) < 0.02 * data2.sensordata[1]
assert abs(soil.contact("wheel").slip - data2.sensordata[0]) < 0.01
""")

    def test_a_long_step_is_told(self):
        self.check_script("""
import warnings
for step, count in ((0.005, 0), (0.01, 1)):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        loop(BALL.replace("0.002", str(step)), "ball", 1)
    assert [str(one.message).count("timestep is 0.01 s") for one in told] == [1] * count, told
""")

    def test_a_skin_is_what_it_asks_for(self):
        self.check_script("""
furrow.mujoco.write_skin("ground.skn", size=(4, 2), spacing=0.05, centre=(1, 0))
model = mujoco.MjModel.from_xml_string('<mujoco><deformable><skin name="terrain" file="ground.skn"/></deformable><worldbody/></mujoco>')
vertices, faces = model.skin_vert, model.skin_face
assert vertices.shape == (81 * 41, 3) and faces.shape == (2 * 80 * 40, 3), (vertices.shape, faces.shape)
assert np.allclose(vertices.min(0), (-1, -1, 0)) and np.allclose(vertices.max(0), (3, 1, 0)), (vertices.min(0), vertices.max(0))
corners = vertices[faces]
assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0.002).all()  # all look up
try:
    furrow.mujoco.write_skin("none.skn", size=(4, 2), spacing=5)
except ValueError as error:
    assert "give a size and spacing" in str(error)
else:
    raise AssertionError("not refused")
""")

    def test_a_soil_has_tyres(self):
        self.check_script("""
CART = f'''<mujoco><option timestep="0.002" gravity="0 0 -{G}" integrator="implicit"/><worldbody><body pos="0 0 .301"><joint type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="90" diaginertia="1 1 1"/>
<body><joint axis="0 1 0"/><inertial pos="0 0 0" mass="10" diaginertia=".5 .5 .5"/><geom name="wheel" type="cylinder" size=".3 .1" euler="90 0 0"/></body></body></worldbody></mujoco>'''
model = mujoco.MjModel.from_xml_string(CART)
data = mujoco.MjData(model)
world = furrow.World(dict(SCENE, soil={"name": "concrete"}), store="plain.furrow", overlay="loop.furrow")
refused("has no stiffness or no load", furrow.mujoco.Soil, world, model, data, origin=(10, 10.5, 0), tyres={"wheel": {"stiffness": 5e4}})
refused("soil rolls off", furrow.mujoco.Soil, world, model, data, origin=(10, 10.5, 0), carry="wheel")
soil = furrow.mujoco.Soil(world, model, data, origin=(10, 10.5, 0), tyres={"wheel": {"stiffness": 5e4, "load": 100 * G}})
for _ in range(2000):
    soil.apply()
    mujoco.mj_step(model, data)
    soil.commit()
assert abs(-0.001 - data.qpos[0] - 100 * G / 5e4) < 0.02 * 100 * G / 5e4, data.qpos  # the tyre's deflection
""")

    def test_what_the_user_applies_stays(self):
        self.check_script("""
world, soil, model, data = loop(BALL, "ball", 1500)
def begin():
    soil.apply()
    assert data.qfrc_applied[2] > 100, data.qfrc_applied  # it carries the ball
    mujoco.mj_step(model, data)
begin()
mujoco.mj_resetData(model, data)
soil.reset()
assert not data.qfrc_applied.any(), data.qfrc_applied
for _ in range(1500):
    soil.apply()
    mujoco.mj_step(model, data)
    soil.commit()
begin()
data.qfrc_applied[:] = 0
soil.commit()
assert not data.qfrc_applied.any(), data.qfrc_applied
begin()
data.qfrc_applied[2] += 5
refused("data.qfrc_applied was changed", soil.commit)
""")

    def test_one_step_is_one_step(self):
        self.check_script("""
world, soil, model, data = loop(BALL, "ball", 10)
soil.apply()
mujoco.mj_step(model, data, nstep=5)
refused("data.time went on by 0.01 s since apply, and a step is 0.002 s", soil.commit)
soil.apply()
refused("data.time went on by 0 s", soil.commit)
mujoco.mj_step(model, data)
soil.commit()
world.checkpoint()
refused("a checkpoint was made after", soil.reset)
time = world.time
soil.apply()
mujoco.mj_step(model, data)
soil.commit()
world.rollback()
assert world.time == time
""")

    def test_a_soil_that_is_gone_leaves_the_world(self):
        self.check_script("""
world, soil, model, data = loop(BALL, "ball", 20)
refused("mujoco.ball", furrow.mujoco.Soil, world, model, data, "ball")  # the name is taken
soil.close()
soil.close()
refused("this soil is closed", soil.apply)
mujoco.mj_resetData(model, data)
soil = furrow.mujoco.Soil(world, model, data, "ball", (10, 10.5, 0))
soil.apply()
del soil
soil = furrow.mujoco.Soil(world, model, data, "ball", (10, 10.5, 0))
world.close()
del soil
""")

    def test_what_cannot_be_is_refused(self):
        self.check_script(f"MODEL = {str(ROOT / 'tests/vehicle/one_wheel.xml')!r}" + """
world, soil, model, data = loop(BALL, None, 2)
refused("call soil.apply() before mj_step", soil.commit)
data.qpos[0], data.qpos[2] = 5, 0.19
for _ in range(5):
    soil.apply()
    mujoco.mj_step(model, data)
    soil.commit()
assert abs(world.points([(12.5, 10.5)])["offset"][0]) == 0  # on the way between: no rut
data.qpos[0] = -100
refused("off the terrain", soil.apply)
refused("geoms: bal names no geom", furrow.mujoco.Soil, world, model, data, geoms="bal")
try:
    soil.contact("wheel")
except KeyError as error:
    assert "there are ball" in str(error)
else:
    raise AssertionError("not refused: wheel")
world.close()
refused("its world is closed", soil.apply)
vehicles = furrow.World(dict(SCENE, time_step=0.002, vehicles=[{"name": "v", "model": MODEL, "start": {"at": [10, 10]}}]), store="plain.furrow", overlay="v.furrow")
refused("vehicles of its own", furrow.mujoco.Soil, vehicles, model, data)
""")


if __name__ == "__main__":
    main()
