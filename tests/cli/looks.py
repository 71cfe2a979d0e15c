"""What pictures show of bodies: their silhouettes, numbers and classes beside closed forms; colours of MJCF and URDF; visuals in place of what collides."""
import json
import math
import pathlib
import struct
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cameras import Camera, read_png
from furrow_test import FurrowTest, main

HEAD = """scene: 1
time_step: 0.004
end_time: 0.008
spacing: 0.25
soil: {name: dry_sand}
redistribute: {model: scm}
"""
MJCF = """<mujoco>
 <asset><material name="blue" rgba="0 0 1 1"/><texture name="t" type="2d" builtin="flat" width="4" height="4" rgb1="1 0 1"/><material name="tex" texture="t"/></asset>
 <worldbody><body name="hull" pos="0 0 0.5"><freejoint/>
  <geom name="box" type="box" size="0.5 0.3 0.1" rgba="1 0 0 1" mass="40"/>
  <geom type="ellipsoid" size="0.2 0.15 0.2" pos="0.2 0 0.3" material="blue" contype="0" conaffinity="0" mass="0" group="1"/>
  <geom type="capsule" size="0.06 0.3" pos="-0.2 0.2 0.4" rgba="0 1 0 1" contype="0" conaffinity="0" mass="0" group="2"/>
  <geom type="cylinder" size="0.1 0.15" pos="-0.2 -0.2 0.25" material="tex" contype="0" conaffinity="0" mass="0" group="2"/>
  <geom type="sphere" size="1" rgba="1 1 0 0.05" contype="0" conaffinity="0" mass="0"/>
  <geom type="sphere" size="0.9" rgba="1 1 0 1" contype="0" conaffinity="0" mass="0" group="3"/>
  %s
 </body></worldbody></mujoco>"""
FEET = "".join(f'<geom type="sphere" size="0.25" pos="{x} {y} -0.2" mass="3"/>' for x in (-0.4, 0.4) for y in (-0.3, 0.3))

URDF = """<robot name="cart">
 <material name="green"><color rgba="0 1 0 1"/></material>
 <link name="base"><inertial><mass value="40"/><inertia ixx="4" iyy="4" izz="4" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><origin xyz="0 0 0.1"/><geometry><box size="0.6 0.4 0.2"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>
  {more}
  <collision><geometry><box size="1 1 0.5"/></geometry></collision></link>
 <link name="mast"><visual><geometry><box size="0.1 0.1 0.4"/></geometry><material name="green"/></visual></link>
 <joint name="fixed" type="fixed"><origin xyz="0.1 0 0.4" rpy="0 0 0.5"/><parent link="base"/><child link="mast"/></joint>
 <link name="arm"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><sphere radius="0.1"/></geometry><material name="red"/></visual></link>
 <joint name="hinge" type="fixed"><origin xyz="0 0.8 0.3"/><parent link="base"/><child link="arm"/></joint>
</robot>"""


def linear_hue(pixels):
    """Which of red, green, blue, yellow and magenta each pixel is: by what is at least twice as bright as the rest."""
    r, g, b = (pixels[..., i].astype(float) + 1 for i in range(3))
    return {"red": (r > 2 * g) & (r > 2 * b), "green": (g > 2 * r) & (g > 2 * b), "blue": (b > 2 * r) & (b > 2 * g),
            "yellow": (r > 2 * b) & (g > 2 * b) & (r < 2 * g) & (g < 2 * r), "magenta": (r > 2 * g) & (b > 2 * g) & (r < 2 * b) & (b < 2 * r)}


class Looks(FurrowTest):
    def setUp(self):
        super().setUp()
        self.synth(posts="129x129", spacing=0.5, kind="plain", relief=0.001)

    def picture(self, name, image, frame=0):
        return read_png(self.folder / f"out/cameras/{name}/{image}/{frame:06d}.png")

    def driven(self, text, **options):
        (self.folder / "o.furrow").unlink(missing_ok=True)
        return self.drive(self.scene(text), "--store", "world.furrow", "--overlay", "o.furrow", **options)

    def test_a_named_soil_looks_like_it_without_a_map(self):
        eye = "pose: {at: [32, 32, 30], target: [32, 33, 0]}"
        colour = {}
        for soil, model in (("lunar", "scm"), ("dry_sand", "scm"), ("dry_sand", "box"), ("mud", "sumner"), (None, "box")):
            named = f"soil: {{name: {soil}}}\n" if soil else ""
            scene = (f"scene: 1\ntime_step: 0.1\nend_time: 0.1\n{named}redistribute: {{model: {model}}}\n"
                        "objects: [{name: a, shape: {sphere: {radius: 0.2}}, path: {points: [[2, 2], [3, 2]], speed: 1}}]\n"
                        f"cameras: [{{name: a, kind: fixed, rate: 1, size: [64, 48], {eye}}}]\n")
            self.driven(scene)
            told = self.furrow("explain", self.scene(scene), "--store", "world.furrow").stderr
            self.assertNotIn("does not depend", told)  # a picture shows it, so it is not in vain
            colour[soil, model] = self.picture("a", "colour").reshape(-1, 3).mean(axis=0)
        red, green, blue = colour["dry_sand", "scm"]
        self.assertGreater(red, blue + 10)
        self.assertLess(np.ptp(colour["lunar", "scm"]), 22)
        self.assertLess(colour["lunar", "scm"].mean(), green - 20)
        self.assertLess(colour["mud", "sumner"].mean(), green - 40)
        self.assertEqual(colour["dry_sand", "box"].tolist(), colour["dry_sand", "scm"].tolist())
        self.assertGreater(abs(colour[None, "box"] - colour["mud", "sumner"]).max(), 20)

    def test_a_balls_silhouette_is_that_of_a_ball(self):
        ball, radius = np.array([20.0, 22.0]), 0.8
        ground = json.loads(self.ok("query", "world.furrow", *ball, "--json"))["height"]
        middle = np.array([*ball, ground + 3])
        for name, at in (("ball", middle), ("far", middle + [0, 4, 0])):
            (self.folder / f"{name}.csv").write_text(f"t,x,y,z,yaw,pitch,roll\n0,{at[0]},{at[1]},{at[2]},0,0,0\n9,{at[0]},{at[1]},{at[2]},0,0,0\n")
        eye = [float(number) for number in middle + [-4, -3, 2]]
        run = self.driven("scene: 1\ntime_step: 0.1\nend_time: 0.1\nredistribute: {model: box}\nobjects:\n"
                          f"  - {{name: far, shape: {{sphere: {{radius: {radius}}}}}, path: {{file: far.csv}}}}\n"
                          f"  - {{name: ball, shape: {{sphere: {{radius: {radius}}}}}, path: {{file: ball.csv}}}}\n"
                          f"cameras: [{{name: a, kind: fixed, rate: 1, size: [320, 240], pose: {{at: {eye}, target: {[float(n) for n in middle]}}}, images: [class, instance]}}]\n")
        self.assertEqual(run["instances"], {"1": "far", "2": "ball"})
        camera = Camera(self.folder / "out/cameras/a")
        self.assertEqual(camera.told["images"]["instance"]["instances"], {"1": "far", "2": "ball"})
        classes, numbers = self.picture("a", "class")[..., 0], self.picture("a", "instance")
        v, u = np.mgrid[:240, :320]
        rays = camera.rays(camera.frames[0], u + 0.5, v + 0.5)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        to = middle - np.array(camera.frames[0]["position"])
        apart = np.linalg.norm(to - rays * (rays @ to)[..., None], axis=-1)  # of the ray from the middle
        pixel = np.linalg.norm(to) / camera.told["fx"]
        inside, outside = apart < radius - pixel, apart > radius + 0.5 * pixel
        self.assertGreater(inside.sum(), 2000)
        self.assertTrue((numbers[inside] == 2).all())
        self.assertFalse((numbers[outside] == 2).any())
        self.assertTrue((classes[numbers > 0] == 253).all())
        self.assertEqual(set(np.unique(numbers)), {0, 1, 2})
        self.assertTrue(set(np.unique(classes[numbers == 0])) <= {0, 255})

    def mounted(self, model, vehicles="", at="[-3, 0, 1.6]", more=""):
        return (HEAD + f"vehicles:\n  - {{name: car, model: {model}, start: {{at: [20, 22], yaw: 25}}{more}}}\n{vehicles}"
                f"cameras: [{{name: a, kind: mounted, on: car, pose: {{at: {at}, pitch: -25}}, rate: 1, size: [320, 240], fov: 60, images: [colour, class, instance, normals]}}]\n")

    def on_body(self, point, at=(-3, 0, 1.6), pitch=-25):
        """The pixel of a place in the axes of the vehicle."""
        fx = 160 / math.tan(math.radians(30))
        c, s = math.cos(math.radians(pitch)), math.sin(math.radians(pitch))
        d = np.array(point, float) - at
        ahead = d[0] * c + d[2] * s
        return 160 - fx * d[1] / ahead, 120 - fx * (-s * d[0] + c * d[2]) / ahead

    def box_of(self, middle, half):
        """The pixels that a box spans: left, right, top, bottom."""
        corners = [self.on_body([m + s * h for m, s, h in zip(middle, sign, half)]) for sign in np.ndindex(2, 2, 2) for sign in [2 * np.array(sign) - 1]]
        x, y = zip(*corners)
        return min(x), max(x), min(y), max(y)

    def assert_spans(self, mask, box, delta=1.5):
        v, u = np.nonzero(mask)
        self.assertGreater(len(u), 30)
        for found, wanted in zip((u.min(), u.max() + 1, v.min(), v.max() + 1), box):
            self.assertAlmostEqual(found, wanted, delta=delta)

    def test_geoms_of_a_model_have_its_colours(self):
        """Its own, a material's, a texture's; those of group 3 and clear ones are not there."""
        (self.folder / "car.xml").write_text(MJCF % FEET)
        run = self.driven(self.mounted("car.xml"))
        self.assertEqual(run["instances"], {"1": "car.hull"})
        numbers, classes, colours = self.picture("a", "instance"), self.picture("a", "class")[..., 0], self.picture("a", "colour")
        self.assertTrue(((numbers == 1) == (classes == 254)).all())
        seen = {hue: int((mask & (numbers == 1)).sum()) for hue, mask in linear_hue(colours).items()}
        for hue in ("red", "green", "blue", "magenta"):
            self.assertGreater(seen[hue], 150, seen)
        self.assertLess(seen["yellow"], 20, seen)
        green = linear_hue(colours)["green"] & (numbers == 1)
        self.assert_spans(green, self.box_of([-0.2, 0.2, 0.43], [0.04, 0.06, 0.33]))

    def test_textures_are_told(self):
        """One that has more than one colour, and once."""
        for kind, told in (("flat", 0), ("checker", 1)):
            (self.folder / "car.xml").write_text(MJCF.replace("flat", kind) % FEET)
            result = self.furrow("drive", self.scene(self.mounted("car.xml")), "--store", "world.furrow", "--overlay", kind + ".furrow", "-o", kind)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stderr.count("vehicles.car: 1 of its geoms has textures: pictures show their mean colour"), told, result.stderr)

    def test_a_model_of_group_3_alone_is_shown(self):
        (self.folder / "car.xml").write_text(MJCF.replace('rgba="1 0 0 1" mass', 'rgba="1 0 0 1" group="3" mass').split("<geom type=\"ellipsoid\"")[0] +
                                             FEET.replace("<geom", '<geom group="4"') + "</body></worldbody></mujoco>")
        result = self.furrow("drive", self.scene(self.mounted("car.xml")), "--store", "world.furrow", "--overlay", "o.furrow", "-o", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("none of its geoms is in groups 0 to 2: pictures show those of all groups", result.stderr)
        self.assertGreater((self.picture("a", "instance") == 1).sum(), 1000)

    def test_two_vehicles_number_their_bodies(self):
        (self.folder / "car.xml").write_text(MJCF % (FEET + '<body name="arm" pos="0 0.5 0.6"><joint axis="0 1 0" damping="50"/><geom type="sphere" size="0.1" mass="0.1" rgba="0 0 1 1"/></body>'))
        run = self.driven(self.mounted("car.xml", "  - {name: other, model: car.xml, start: {at: [23, 24], yaw: 25}}\n"))
        self.assertEqual(run["instances"], {"1": "car.hull", "2": "car.arm", "3": "other.hull", "4": "other.arm"})
        numbers = self.picture("a", "instance")
        for number in (1, 2, 3, 4):
            self.assertGreater((numbers == number).sum(), 20, number)

    def test_a_urdf_shows_its_visuals(self):
        """In place of what collides, with colours by name, on links that are fixed to others; the motion has the same bits as without pictures."""
        (self.folder / "cart.urdf").write_text(URDF.format(more=""))
        self.driven(self.mounted("cart.urdf") + "output: {vehicles: 250}\n")
        rows = (self.folder / "out/vehicles.csv").read_bytes()
        numbers, colours = self.picture("a", "instance"), self.picture("a", "colour")
        hues = linear_hue(colours)
        left = np.arange(320)[None, :] < self.on_body([0, 0.5, 0])[0]
        self.assert_spans(hues["red"] & (numbers == 1) & ~left, self.box_of([0, 0, 0.1], [0.3, 0.2, 0.1]))
        half = 0.05 * (math.cos(0.5) + math.sin(0.5))
        self.assert_spans(hues["green"] & (numbers == 1), self.box_of([0.1, 0, 0.4], [half, half, 0.2]))
        self.assert_spans((numbers > 0) & left, self.box_of([0, 0.8, 0.3], [0.07, 0.1, 0.1]), delta=3)
        self.assertTrue((hues["red"] | hues["green"])[numbers > 0].mean() > 0.95)
        text = self.mounted("cart.urdf").split("cameras:")[0]
        self.driven(text + "output: {vehicles: 250}\n")
        self.assertEqual((self.folder / "out/vehicles.csv").read_bytes(), rows)

    def wedge(self, name):
        """A wedge that is higher on its left, with a material, as OBJ."""
        (self.folder / "wedge.mtl").write_text("newmtl blue\nKd 0 0 1\n")
        (self.folder / name).write_text("mtllib wedge.mtl\nv -0.2 0 0\nv 0.2 0 0\nv -0.2 1 0\nv 0.2 1 0\nv -0.2 1 0.5\nv 0.2 1 0.5\nusemtl blue\n"
                                        "f 1 3 4 2\nf 1 2 6 5\nf 3 5 6 4\nf 1 5 3\nf 2 4 6\n")

    def test_a_mirrored_mesh_is_right_side_out(self):
        self.wedge("wedge.obj")
        for scale, side in (("1 1 1", 1), ("1 -1 1", -1)):
            more = f'<visual><origin xyz="0 {0.25 * side} 0.2"/><geometry><mesh filename="wedge.obj" scale="{scale}"/></geometry></visual>'
            (self.folder / "cart.urdf").write_text(URDF.format(more=more))
            self.driven(self.mounted("cart.urdf"))
            blue = linear_hue(self.picture("a", "colour"))["blue"] & (self.picture("a", "instance") == 1)
            self.assert_spans(blue, self.box_of([0, 0.75 * side, 0.45], [0.2, 0.5, 0.25]))
            normals = np.load(self.folder / "out/cameras/a/normals/000000.npy")[blue]
            slope = normals[normals[:, 2] > 0.5]  # the sloping face: seen from above, so its normal points up
            self.assertGreater(len(slope), 1000)
            self.assertLess(np.abs(slope[:, 2] - 1 / math.hypot(1, 0.5)).max(), 0.05)

    def test_missing_visuals_are_told_and_what_collides_is_shown(self):
        more = '<visual><geometry><mesh filename="package://nowhere/shell.dae"/></geometry></visual>'
        text = URDF.format(more=more).replace('<visual><origin xyz="0 0 0.1"/><geometry><box size="0.6 0.4 0.2"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>', "")
        (self.folder / "cart.urdf").write_text(text.split('<link name="mast">')[0] + "</robot>")
        result = self.furrow("drive", self.scene(self.mounted("cart.urdf")), "--store", "world.furrow", "--overlay", "o.furrow", "-o", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("pictures lack 1 visual mesh (shell.dae), whose files are not found", result.stderr)
        numbers = self.picture("a", "instance")
        self.assertGreater((numbers == 1).sum(), 3000)

    def test_a_collada_is_drawn_in_its_unit_and_colours(self):
        """One whose node is in itself would never end: it is told, and the drive goes on."""
        def dae(node):
            return ('<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>'
                    '<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse><color>0 0 1 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>'
                    '<library_materials><material id="m" name="m"><instance_effect url="#e"/></material></library_materials><library_geometries><geometry id="g"><mesh><source id="p">'
                    '<float_array id="pa" count="12">-20 -20 60 20 -20 60 20 20 60 -20 20 60</float_array><technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>'
                    '<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
                    '<triangles count="2" material="k"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3</p></triangles></mesh></geometry></library_geometries>'
                    f'<library_visual_scenes><visual_scene id="s">{node}</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>')
        geometry = ('<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="k" target="#m"/></technique_common></bind_material></instance_geometry>')
        (self.folder / "plate.dae").write_text(dae(f'<node id="A" name="A">{geometry}</node>'))
        (self.folder / "cycle.dae").write_text(dae(f'<node id="A" name="A">{geometry}<node id="B"><instance_node url="#A"/></node></node>'))
        more = "".join(f'<visual><geometry><mesh filename="{name}.dae"/></geometry></visual>' for name in ("plate", "cycle"))
        (self.folder / "cart.urdf").write_text(URDF.format(more=more))
        result = self.furrow("drive", self.scene(self.mounted("cart.urdf")), "--store", "world.furrow", "--overlay", "o.furrow", "-o", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("pictures lack 1 visual mesh (cycle.dae), whose files cannot be read", result.stderr)
        blue = linear_hue(self.picture("a", "colour"))["blue"] & (self.picture("a", "instance") == 1)
        self.assert_spans(blue, self.box_of([0, 0, 0.6], [0.2, 0.2, 0]), delta=2)

    def test_a_mesh_of_a_million_triangles_is_drawn(self):
        side = 708
        grid = [(x / side - 0.5, y / side - 0.5, 0.3 + 0.05 * math.sin(20 * x / side)) for x in range(side + 1) for y in range(side + 1)]
        at = lambda x, y: struct.pack("<3f", *grid[x * (side + 1) + y])
        faces = b"".join(bytes(12) + at(x, y) + at(x + 1, y) + at(x + (k == 0), y + 1) + b"\0\0" if k == 0 else bytes(12) + at(x, y) + at(x + 1, y + 1) + at(x, y + 1) + b"\0\0"
                         for x in range(side) for y in range(side) for k in (0, 1))
        (self.folder / "sheet.stl").write_bytes(bytes(80) + struct.pack("<I", 2 * side * side - 2528) + faces[:50 * (2 * side * side - 2528)])
        more = '<visual><geometry><mesh filename="sheet.stl"/></geometry><material name="b"><color rgba="0 0 1 1"/></material></visual>'
        (self.folder / "cart.urdf").write_text(URDF.format(more=more))
        self.driven(self.mounted("cart.urdf"))
        self.assertGreater((linear_hue(self.picture("a", "colour"))["blue"] & (self.picture("a", "instance") == 1)).sum(), 3000)


if __name__ == "__main__":
    main()
