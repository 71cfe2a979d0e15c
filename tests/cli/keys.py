"""Every key of a scene counts: for each there is a scene in which another value of it changes what a drive leaves, or what it says.

What is compared: rows of objects.csv and vehicles.csv without the columns that repeat the scene, all tables of ruts and soil, pictures,
which files there are, and notes and errors. run.json repeats the scene, so of it only a few parts are compared.
"""
import hashlib
import json
import os
import pathlib
import re
import shutil
import sqlite3
import unittest

from furrow_test import FULL, FurrowTest, main, write_png16

ROOT = pathlib.Path(__file__).parents[2]
PAGE = ROOT / "src/scene/SCENE.md"
LEAVES = ("number", "whole number", "text", "word", "switch")
PART = 32  # without FURROW_LONG: every so many

HEAD = {"time_step": "0.05", "end_time": "0.6", "spacing": "0.125"}
WHEEL = "{name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, path: {points: [[10, 20], [12, 21], [12, 24]], speed: 3}, %s}"
SCM = {**HEAD, "soil": "{name: dry_sand}", "redistribute": "{model: scm, interval: 0.05}", "output": "{forces: 20}",
       "objects": f"[{WHEEL % 'load: 900, slip: 0.3'}]"}
RUT = {**SCM, "objects": "[{name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, load: 900, slip: 0.3, path: {points: [[10, 20], [14, 20]], speed: 3}}, "
                         "{name: b, shape: {wheel: {radius: 0.5, width: 0.4}}, load: 900, slip: 0.3, path: {points: [[8.5, 20], [12.5, 20]], speed: 3}}]"}
DENSE = {**SCM, "redistribute": "{model: scm, interval: 0.05, hardening: 1}"}
LOOSE = {**HEAD, "soil": "{cohesion: 0, friction_angle: 30, unit_weight: 16000}", "redistribute": "{model: slippage, interval: 0.05, depth: 0.3, undisturbed: slides}",
         "objects": f"[{WHEEL % 'sink: 0.2'}]"}
SUMNER = {**HEAD, "soil": "{name: sand}", "redistribute": "{model: sumner, interval: 0.05}", "objects": f"[{WHEEL % 'sink: 0.2'}]"}
SHEET = {**HEAD, "redistribute": "{model: sheet, yield: 0.05, rut: 0.5}", "objects": f"[{WHEEL % 'sink: 0.2'}]"}
PLAIN = {**HEAD, "objects": f"[{WHEEL % 'sink: 0.2'}]"}
LAYER = {**SCM, "soil": "{name: snow_us, thickness: 0.05, over: rigid}"}
MAP = {**SCM, "soil": "{map: map.png, classes: {1: dry_sand, 2: lunar}, default: clayey_38}"}
ROAD = {**SCM, "ground": "{roads: [{points: [[10, 20], [12, 21], [12, 24]], width: 1, soil: rock}]}"}
ROCKS = {**SCM, "ground": "{rocks: {cover: 0.3, largest: 1.5, smallest: 0.5, seed: 1}}"}
VIEW = {**PLAIN, "view": "{size: [48, 32], camera: {chase: a, back: 6, up: 3}, effects: [texture, objects], images: 6}"}
RELIEF = {**SCM, "relief": "{roughness: 0.05, wavelength: 0.8}"}
CAR = {"time_step": "0.002", "end_time": "0.3", "spacing": "0.125", "soil": "{name: dry_sand}", "redistribute": "{model: scm}", "output": "{vehicles: 50}",
       "vehicles": "[{name: car, model: one_wheel.xml, start: {at: [20, 20]}, driver: {hold: {drive: 3}}}]"}
STEERED = "[{name: car, model: four.xml, start: {at: [20, 20]}, driver: {hold: {drive_a: 3}}}]"
WAY = {**CAR, "vehicles": "[{name: car, model: four.xml, start: {at: [20, 20]}, driver: {path: {points: [[20, 20], [24, 20], [24, 26]], speed: 2}, drive: [drive*], steer: [steer]}}]"}
SLIPS = {**CAR, "store": "flat.furrow", "vehicles": "[{name: car, model: four.xml, start: {at: [20, 20]}, driver: {hold: {drive_a: 30, drive_b: 30, drive_c: 30, drive_d: 30}}}]"}
URDF = {**CAR, "vehicles": "[{name: car, model: cart.urdf, start: {at: [20, 20]}, servo: {torque: 20}, driver: {path: {points: [[20, 20], [24, 20]], speed: 2}, drive: [wheel_*]}}]"}
ARMED = {**CAR, "vehicles": URDF["vehicles"].replace("cart.urdf", "armed.urdf")}
LIMP = {**CAR, "vehicles": re.sub(r"path: .*?speed: 2}, drive: \[wheel_\*\]", "hold: {wheel_fl: 3}", ARMED["vehicles"])}
TRAIN = {**CAR, "store": "flat.furrow", "vehicles": "[{name: car, model: four.xml, start: {at: [20, 20]}, powertrain: {wheels: [drive*], engine: [[500, 20], [6000, 20]], inertia: 0.1, gears: [8, 4], shift_time: 0}, "
                           "driver: {hold: {throttle: 1}}}]"}


def trained(more, hold="throttle: 1", end="0.3"):
    """The car with more keys of its powertrain, or other ones."""
    return {**TRAIN, "end_time": end, "vehicles": TRAIN["vehicles"].replace("gears: [8, 4], shift_time: 0", more).replace("throttle: 1", hold)}


FELT = {**CAR, "output": "{sensors: 50}", "vehicles": "[{name: car, model: one_wheel.xml, start: {at: [20, 20], speed: 1}, imu: {}, driver: {hold: {drive: 3}}}]"}
BEAMS = {**CAR, "output": "{}", "lidars": "[{name: l, on: car, pose: {at: [0, 0, 1]}, rate: 10, rays: [12, 4], range: [0, 30]}]"}


def beamed(key, value):
    """The scene with another value of a key of its lidar."""
    return {"lidars": BEAMS["lidars"].replace("rate: 10", f"rate: 10, {key}: {value}") if key + ":" not in BEAMS["lidars"] else BEAMS["lidars"].replace(value[0], value[1])}


TYRED = {**CAR, "vehicles": CAR["vehicles"].replace("driver:", "tyres: [{geom: wheel, stiffness: 30e3}], driver:")}
ROLLS = {**SCM, "soil": "{name: lete_sand}", "objects": SCM["objects"].replace("width: 0.4}", "width: 0.4, tyre: {stiffness: 30e3, load: 900}}")}
SHAPE = {**PLAIN}
HEALS = {**PLAIN, "attributes": "{disturbance: {heals: 100}}"}
PLANTS = {**PLAIN, "attributes": "{vegetation: {cover: 0.7}}", "objects": f"[{WHEEL % 'sink: 0.2, slip: 0.2'}]"}
GREEN = {**VIEW, "attributes": PLANTS["attributes"]}
COVERED = {**MAP, "view": VIEW["view"], "attributes": "{vegetation: {cover: 0.7, classes: [{value: 1, cover: 0.2}]}}"}
CAMERA = "{name: c, kind: %s, size: [32, 24], rate: 4, %s}"
SHOT = {**PLAIN, "cameras": f"[{CAMERA % ('mounted', 'on: a, pose: {at: [-3, 0, 2], yaw: 3, pitch: -30}')}]"}


def camera(kind, keys):
    return {**PLAIN, "cameras": f"[{CAMERA % (kind, keys)}]"}


def shaped(shape, more=""):
    return {**PLAIN, "objects": f"[{{name: a, shape: {{{shape}}}, path: {{file: poses.csv}}{more}}}]"}


def lying(shape):
    """Its axis is level, so that its length leaves a print."""
    return {**PLAIN, "store": "flat.furrow", "objects": f"[{{name: a, shape: {{{shape}}}, path: {{file: lying.csv}}}}]"}


def pathed(path):
    return {**PLAIN, "objects": f"[{{name: a, shape: {{wheel: {{radius: 0.5, width: 0.4}}}}, sink: 0.2, path: {{{path}}}}}]"}


# Key: a sound scene, and what to set in it. A second change of that kind counts too: the first is then part of both.
ROWS = {
    "scene": (PLAIN, {"scene": "2"}),
    "store": ({**PLAIN, "store": "hills.furrow"}, {"store": "flat.furrow"}),
    "time_step": (CAR, {"time_step": "0.004"}),
    "end_time": (PLAIN, {"end_time": "0.2"}),
    "gravity": (CAR, {"gravity": "3.71"}),
    "spacing": (PLAIN, {"spacing": "0.25"}),
    "relief.roughness": (RELIEF, {"relief.roughness": "0.04"}),
    "relief.wavelength": (RELIEF, {"relief.wavelength": "1.6"}),
    "relief.seed": (RELIEF, {"relief.seed": "5"}),
    "relief.classes": ({**MAP, **{"relief": RELIEF["relief"]}}, {"relief.classes": "{1: 0.01}"}),
    "relief.classes[].value": ({**MAP, "relief": "{roughness: 0.05, wavelength: 0.8, classes: [{value: 1, roughness: 0.01}]}"}, {"relief.classes.0.value": "2"}),
    "relief.classes[].roughness": ({**MAP, "relief": "{roughness: 0.05, wavelength: 0.8, classes: [{value: 1, roughness: 0.01}]}"}, {"relief.classes.0.roughness": "0.02"}),
    "relief.classes[].wavelength": ({**MAP, "relief": "{roughness: 0.05, wavelength: 0.8, classes: [{value: 1, roughness: 0.03}]}"}, {"relief.classes.0.wavelength": "1.6"}),
    "compute": (SCM, {"compute": "gpu"}),  # it is refused; with other models it changes nothing
    "attributes.disturbance.heals": (HEALS, {"attributes.disturbance.heals": "200"}),
    "attributes.elapsed": (HEALS, {"attributes.elapsed": "300"}),
    "attributes.vegetation.cover": (GREEN, {"attributes.vegetation.cover": "0.2"}),
    "attributes.vegetation.height": (GREEN, {"attributes.vegetation.height": "0.9"}),
    "attributes.vegetation.tears": (PLANTS, {"attributes.vegetation.tears": "0.9"}),
    "attributes.vegetation.rises": (PLANTS, {"attributes.vegetation.rises": "90"}),
    "attributes.vegetation.grows": (PLANTS, {"attributes.vegetation.grows": "90"}),
    "attributes.vegetation.classes": (COVERED, {"attributes.vegetation.classes": "{1: 0.9}"}),
    "attributes.vegetation.classes[].value": (COVERED, {"attributes.vegetation.classes.0.value": "2"}),
    "attributes.vegetation.classes[].cover": (COVERED, {"attributes.vegetation.classes.0.cover": "0.9"}),
    "outside": (pathed("points: [[1, 20], [-5, 20]], speed: 20"), {"outside": "skip"}),
    "objects": (PLAIN, {"objects": f"[{WHEEL % 'sink: 0.1'}]"}),
    "vehicles": ({**CAR, "objects": PLAIN["objects"], "vehicles": "[]", "output": "{forces: 50}"}, {"vehicles": CAR["vehicles"]}),
    "world": ({**CAR, "store": "flat.furrow"}, {"world": "wall.xml"}),  # on the hills it rolls back
    "stuck.after": ({**WAY, "end_time": "1", "stuck": "{after: 0.3, below: 100}"}, {"stuck.after": "0.6"}),
    "stuck.below": ({**WAY, "end_time": "1", "stuck": "{after: 0.3, below: 100}"}, {"stuck.below": "0.001"}),
    "stop": ({**WAY, "end_time": "1", "stuck": "{after: 0.3, below: 100}"}, {"stop": "[buried]"}),
    "cameras": (PLAIN, {"cameras": SHOT["cameras"]}),
    "objects[].name": (SCM, {"objects.a.name": "b"}),
    "objects[].shape.wheel.radius": (PLAIN, {"objects.a.shape.wheel.radius": "0.7"}),
    "objects[].shape.wheel.width": (PLAIN, {"objects.a.shape.wheel.width": "0.8"}),
    "objects[].shape.wheel.grousers": (PLAIN, {"objects.a.shape.wheel.grousers": "8"}),
    "objects[].shape.wheel.grouser_height": ({**PLAIN, "objects": PLAIN["objects"].replace("width: 0.4", "width: 0.4, grousers: 8")}, {"objects.a.shape.wheel.grouser_height": "0.2"}),
    "objects[].shape.wheel.grouser_thickness": ({**PLAIN, "objects": PLAIN["objects"].replace("width: 0.4", "width: 0.4, grousers: 8, grouser_height: 0.2")},
                                                {"objects.a.shape.wheel.grouser_thickness": "0.3"}),
    "objects[].shape.sphere.radius": (shaped("sphere: {radius: 1}"), {"objects.a.shape.sphere.radius": "0.8"}),
    "objects[].shape.box.size": (shaped("box: {size: [1, 1, 1]}"), {"objects.a.shape.box.size": "[2, 1, 1]"}),
    "objects[].shape.box.belt": ({**SCM, "objects": "[{name: a, shape: {box: {size: [1, 1, 1]}}, path: {points: [[10, 20], [12, 20]], speed: 3}, load: 900}]"},
                                 {"objects.a.shape.box.belt": "true"}),
    "objects[].shape.mesh.file": (shaped("mesh: {file: a.obj}"), {"objects.a.shape.mesh.file": "b.obj"}),
    "objects[].shape.mesh.scale": (shaped("mesh: {file: a.obj}"), {"objects.a.shape.mesh.scale": "1.5"}),
    "objects[].shape.mesh.belt": ({**SCM, "objects": "[{name: a, shape: {mesh: {file: a.obj}}, path: {points: [[10, 20], [12, 20]], speed: 3}, load: 900}]"},
                                  {"objects.a.shape.mesh.belt": "true"}),
    "objects[].shape.cylinder.radius": (shaped("cylinder: {radius: 0.6, length: 1}"), {"objects.a.shape.cylinder.radius": "0.8"}),
    "objects[].shape.cylinder.length": (lying("cylinder: {radius: 0.6, length: 1}"), {"objects.a.shape.cylinder.length": "2"}),
    "objects[].shape.capsule.radius": (shaped("capsule: {radius: 0.6, length: 1}"), {"objects.a.shape.capsule.radius": "0.8"}),
    "objects[].shape.capsule.length": (lying("capsule: {radius: 0.6, length: 1}"), {"objects.a.shape.capsule.length": "2"}),
    "objects[].shape.ellipsoid.radii": (shaped("ellipsoid: {radii: [1, 1, 0.8]}"), {"objects.a.shape.ellipsoid.radii": "[1, 1, 1]"}),
    "objects[].path.points": (PLAIN, {"objects.a.path.points": "[[10, 20], [13, 20]]"}),
    "objects[].path.speed": (PLAIN, {"objects.a.path.speed": "4"}),
    "objects[].path.loop": (pathed("points: [[10, 20], [11, 20], [11, 21]], speed: 9"), {"objects.a.path.loop": "true"}),
    "objects[].path.file": (pathed("file: poses.csv"), {"objects.a.path.file": "other.csv", "objects.a.sink": "null"}),
    "objects[].path.smooth": (PLAIN, {"objects.a.path.smooth": "true"}),
    "objects[].path.rotate": (PLAIN, {"objects.a.path.rotate": "30"}),
    "objects[].path.offset": (PLAIN, {"objects.a.path.offset": "[1, 0]"}),
    "objects[].path.relative_to": ({**PLAIN, "objects": f"[{WHEEL % 'sink: 0.2'}, {{name: b, shape: {{sphere: {{radius: 1}}}}, sink: 0.1, path: {{points: [[20, 9], [22, 9]], speed: 3}}}}, "
                                                       "{name: c, shape: {sphere: {radius: 1}}, sink: 0.3, path: {relative_to: a}}]"}, {"objects.c.path.relative_to": "b"}),
    "objects[].path.delay": (PLAIN, {"objects.a.path.delay": "0.3"}),
    "objects[].sink": (PLAIN, {"objects.a.sink": "0.1"}),
    "objects[].load": (SCM, {"objects.a.load": "1200"}),
    "objects[].slip": (SCM, {"objects.a.slip": "0.1"}),
    "objects[].carry": ({**SCM, "objects": "[{name: a, shape: {box: {size: [1, 1, 0.1]}}, path: {points: [[10, 20], [12, 20]], speed: 3}, sink: 0.3}]"}, {"objects.a.carry": "true"}),
    "objects[].attitude": (SCM, {"objects.a.attitude": "[30, 0, 0]"}),
    "objects[].interface.friction_angle": (SCM, {"objects.a.interface": "{friction_angle: 10}"}),
    "objects[].interface.adhesion": (SCM, {"objects.a.interface": "{adhesion: 10}"}),
    "vehicles[].name": (CAR, {"vehicles.car.name": "bus"}),
    "vehicles[].model": (CAR, {"vehicles.car.model": "heavy.xml"}),
    "vehicles[].start.at": (CAR, {"vehicles.car.start.at": "[20, 20.4]"}),
    "vehicles[].start.yaw": (CAR, {"vehicles.car.start.yaw": "40"}),
    "vehicles[].soil": ({**CAR, "vehicles": CAR["vehicles"].replace("one_wheel", "four").replace("{drive: 3}", "{drive_a: 3}")}, {"vehicles.car.soil": "[left_fl, left_rl, right_fr]"}),
    "vehicles[].no_soil": ({**CAR, "vehicles": CAR["vehicles"].replace("one_wheel", "four").replace("{drive: 3}", "{drive_a: 3}")}, {"vehicles.car.no_soil": "[left_fl]"}),
    "vehicles[].start.keyframe": ({**CAR, "vehicles": CAR["vehicles"].replace("one_wheel.xml", "four.xml").replace("{drive: 3}", "{drive_a: 3}")}, {"vehicles.car.start.keyframe": "turned"}),
    "vehicles[].start.pitch": (CAR, {"vehicles.car.start.pitch": "5"}),
    "vehicles[].start.roll": (CAR, {"vehicles.car.start.roll": "5"}),
    "vehicles[].start.height": (CAR, {"vehicles.car.start.height": "0.1"}),
    "vehicles[].start.speed": (CAR, {"vehicles.car.start.speed": "1"}),
    "vehicles[].start.settle": (CAR, {"vehicles.car.start.settle": "false"}),
    "vehicles[].start.joints": ({**CAR, "store": "flat.furrow", "vehicles": STEERED}, {"vehicles.car.start.joints": "{steer: 0.2}"}),
    "vehicles[].start.joints[].joint": ({**CAR, "store": "flat.furrow", "vehicles": STEERED.replace("at: [20, 20]", "at: [20, 20], joints: [{joint: steer, value: 0.3}]")}, {"vehicles.car.start.joints.0.joint": "fr"}),
    "vehicles[].start.joints[].value": ({**CAR, "store": "flat.furrow", "vehicles": STEERED.replace("at: [20, 20]", "at: [20, 20], joints: [{joint: steer, value: 0.3}]")}, {"vehicles.car.start.joints.0.value": "0.1"}),
    "vehicles[].start.controls": ({**CAR, "store": "flat.furrow", "vehicles": STEERED}, {"vehicles.car.start.controls": "{steer: 0.2}"}),
    "vehicles[].start.controls[].actuator": ({**CAR, "store": "flat.furrow", "vehicles": STEERED.replace("at: [20, 20]", "at: [20, 20], controls: [{actuator: steer, value: 0.3}]")}, {"vehicles.car.start.controls.0.actuator": "drive_b"}),
    "vehicles[].start.controls[].value": ({**CAR, "store": "flat.furrow", "vehicles": STEERED.replace("at: [20, 20]", "at: [20, 20], controls: [{actuator: steer, value: 0.3}]")}, {"vehicles.car.start.controls.0.value": "0.1"}),
    "vehicles[].start.fixed": (URDF, {"vehicles.car.start.fixed": "true"}),
    "vehicles[].tyres": (CAR, {"vehicles.car.tyres": "{wheel: {stiffness: 30e3}}"}),
    "vehicles[].tyres[].geom": ({**CAR, "vehicles": CAR["vehicles"].replace("one_wheel.xml", "four.xml").replace("{drive: 3}", "{drive_a: 3}").replace("driver:", "tyres: [{geom: left_*, stiffness: 30e3}], driver:")}, {"vehicles.car.tyres.0.geom": "right_*"}),
    "vehicles[].tyres[].stiffness": (TYRED, {"vehicles.car.tyres.0.stiffness": "20e3"}),
    "vehicles[].tyres[].width": (TYRED, {"vehicles.car.tyres.0.width": "0.3"}),
    "vehicles[].tyres[].load": (TYRED, {"vehicles.car.tyres.0.load": "500"}),
    "vehicles[].tyres[].pressure": (TYRED, {"vehicles.car.tyres.0.pressure": "1000"}),
    "vehicles[].tyres[].damping": (TYRED, {"vehicles.car.tyres.0.damping": "3000"}),
    "objects[].shape.wheel.tyre.stiffness": (ROLLS, {"objects.a.shape.wheel.tyre.stiffness": "20e3"}),
    "objects[].shape.wheel.tyre.load": (ROLLS, {"objects.a.shape.wheel.tyre.load": "1200"}),
    "objects[].shape.wheel.tyre.pressure": (ROLLS, {"objects.a.shape.wheel.tyre.pressure": "1000"}),
    "vehicles[].model_path": (URDF, {"vehicles.car.model_path": "[packages]"}),
    "vehicles[].servo.kv": (URDF, {"vehicles.car.servo.kv": "0.01"}),
    "vehicles[].servo.free": (ARMED, {"vehicles.car.servo.free": "[arm]"}),
    "vehicles[].servo.lock": (LIMP, {"vehicles.car.servo.lock": "[arm]"}),
    "vehicles[].servo.torque": (URDF, {"vehicles.car.servo.torque": "0.1"}),
    "vehicles[].powertrain.wheels": (TRAIN, {"vehicles.car.powertrain.wheels": "[drive_a, drive_b]"}),
    "vehicles[].powertrain.engine": ({**TRAIN, "vehicles": TRAIN["vehicles"].replace("[[500, 20], [6000, 20]]", "one_engine.csv")}, {"vehicles.car.powertrain.engine": "two_engine.csv"}),
    "vehicles[].powertrain.torque": ({**TRAIN, "vehicles": TRAIN["vehicles"].replace("engine:", "torque:")}, {"vehicles.car.powertrain.torque": "[[500, 15], [6000, 20]]"}),
    "vehicles[].powertrain.inertia": (TRAIN, {"vehicles.car.powertrain.inertia": "0.3"}),
    "vehicles[].powertrain.idle": (TRAIN, {"vehicles.car.powertrain.idle": "700"}),
    "vehicles[].powertrain.drag": (trained("gears: [8]", "throttle: 0.5"), {"vehicles.car.powertrain.drag": "5"}),
    "vehicles[].powertrain.gears": (TRAIN, {"vehicles.car.powertrain.gears": "[5, 4]"}),
    "vehicles[].powertrain.reverse": (trained("gears: [8], shift_time: 0", "throttle: 1, gear: -1"), {"vehicles.car.powertrain.reverse": "4"}),
    "vehicles[].powertrain.final": (TRAIN, {"vehicles.car.powertrain.final": "2"}),
    "vehicles[].powertrain.shift": (trained("gears: [8, 4], shift: [200, 900]", end="0.6"), {"vehicles.car.powertrain.shift": "[200, 600]"}),
    "vehicles[].powertrain.shift_time": (trained("gears: [8, 4], shift: [200, 600]", end="0.6"), {"vehicles.car.powertrain.shift_time": "0.1"}),
    "vehicles[].powertrain.clutch.torque": (TRAIN, {"vehicles.car.powertrain.clutch": "{torque: 10}"}),
    "vehicles[].powertrain.clutch.engage": (TRAIN, {"vehicles.car.powertrain.clutch": "{engage: 1500}"}),
    "vehicles[].powertrain.converter.capacity": (trained("gears: [8], converter: {capacity: 0.002}"), {"vehicles.car.powertrain.converter.capacity": "0.004"}),
    "vehicles[].powertrain.converter.ratio": (trained("gears: [8], converter: {capacity: 0.002}"), {"vehicles.car.powertrain.converter.ratio": "1.5"}),
    "vehicles[].powertrain.converter.coupling": (trained("gears: [8], converter: {capacity: 0.002}"), {"vehicles.car.powertrain.converter.coupling": "0.7"}),
    "vehicles[].powertrain.differentials.centre": (TRAIN, {"vehicles.car.powertrain.differentials": "{centre: locked}"}),
    "vehicles[].powertrain.differentials.front": (TRAIN, {"vehicles.car.powertrain.differentials": "{front: locked}"}),
    "vehicles[].powertrain.differentials.rear": (TRAIN, {"vehicles.car.powertrain.differentials": "{rear: locked}"}),
    "vehicles[].powertrain.differentials.bias": (trained("gears: [8], differentials: {front: limited, centre: limited, bias: 1}"), {"vehicles.car.powertrain.differentials.bias": "3"}),
    "vehicles[].powertrain.differentials.lock": (trained("gears: [8], differentials: {front: limited, centre: limited, bias: 1}"), {"vehicles.car.powertrain.differentials.lock": "10"}),
    "vehicles[].brakes": ({**CAR, "vehicles": CAR["vehicles"].replace("{drive: 3}", "{drive: 3, brake: 1}").replace("start:", "brakes: 1, start:")}, {"vehicles.car.brakes": "2"}),
    "vehicles[].forward": ({**CAR, "vehicles": CAR["vehicles"].replace("one_wheel.xml", "four.xml").replace("{drive: 3}", "{drive_a: 3}")}, {"vehicles.car.forward": "+y"}),
    "vehicles[].up": ({**CAR, "vehicles": "[{name: car, model: brick.xml, start: {at: [20, 20]}}]"}, {"vehicles.car.up": "y"}),
    "vehicles[].interface": (SLIPS, {"vehicles.car.interface": "{'*': steel}"}),
    "vehicles[].interface[].geoms": ({**SLIPS, "vehicles": SLIPS["vehicles"].replace("start", "interface: [{geoms: 'left*', material: steel}], start")}, {"vehicles.car.interface.0.geoms": "'right*'"}),
    "vehicles[].interface[].material": ({**SLIPS, "vehicles": SLIPS["vehicles"].replace("start", "interface: [{geoms: 'left*', material: steel}], start")}, {"vehicles.car.interface.0.material": "rubber"}),
    "vehicles[].interface[].friction_angle": (SLIPS, {"vehicles.car.interface": "{'*': {friction_angle: 10}}"}),
    "vehicles[].interface[].adhesion": (SLIPS, {"vehicles.car.interface": "{'*': {adhesion: 10}}"}),
    "vehicles[].pushes": (CAR, {"vehicles.car.pushes": "pushes.csv"}),
    "vehicles[].driver.path.speeds": (WAY, {"vehicles.car.driver.path": "{points: [[20, 20], [24, 20], [24, 26]], speeds: [1, 1, 2]}"}),
    "vehicles[].driver.path.stop": (WAY, {"vehicles.car.driver.path.stop": "[[0.1, 0.2]]"}),
    "vehicles[].driver.follow": (WAY, {"vehicles.car.driver.follow": "origin"}),
    "vehicles[].carry": ({**CAR, "vehicles": "[{name: car, model: tray.xml, start: {at: [20, 20]}, soil: [tray], driver: {hold: {along: 0.1, lift: -0.1, tip: 0.3}}}]"}, {"vehicles.car.carry": "[tray]"}),
    "vehicles[].driver.path.points": (WAY, {"vehicles.car.driver.path.points": "[[20, 20], [24, 24]]"}),
    "vehicles[].driver.path.speed": (WAY, {"vehicles.car.driver.path.speed": "1"}),
    "vehicles[].driver.path.smooth": (WAY, {"vehicles.car.driver.path.smooth": "true"}),
    "vehicles[].driver.path.rotate": (WAY, {"vehicles.car.driver.path.rotate": "50"}),
    "vehicles[].driver.path.offset": (WAY, {"vehicles.car.driver.path.offset": "[0, 3]"}),
    "vehicles[].driver.steer": ({**WAY, "vehicles": WAY["vehicles"].replace("[20, 20], [24, 20]", "[20, 20], [20, 25]")}, {"vehicles.car.driver.steer": "[]"}),
    "vehicles[].driver.drive": (WAY, {"vehicles.car.driver.drive": "[drive_a]"}),
    "vehicles[].driver.controls": ({**CAR, "vehicles": CAR["vehicles"].replace("hold: {drive: 3}", "controls: one.csv")}, {"vehicles.car.driver.controls": "two.csv"}),
    "vehicles[].driver.hold": (CAR, {"vehicles.car.driver.hold": "{drive: 5}"}),
    "vehicles[].driver.hold[].actuator": ({**CAR, "vehicles": WAY["vehicles"].replace("path: {points: [[20, 20], [24, 20], [24, 26]], speed: 2}, drive: [drive*], steer: [steer]",
                                                                                     "hold: [{actuator: drive_a, value: 3}]")}, {"vehicles.car.driver.hold.0.actuator": "drive_b"}),
    "vehicles[].driver.hold[].value": ({**CAR, "vehicles": CAR["vehicles"].replace("{drive: 3}", "[{actuator: drive, value: 3}]")}, {"vehicles.car.driver.hold.0.value": "5"}),
    "soil.name": (SCM, {"soil.name": "lunar"}),
    "soil.bekker_kc": (SCM, {"soil.bekker_kc": "5000"}),
    "soil.bekker_kphi": (SCM, {"soil.bekker_kphi": "900000"}),
    "soil.bekker_n": (SCM, {"soil.bekker_n": "0.9"}),
    "soil.cohesion": (SCM, {"soil.cohesion": "2000"}),
    "soil.friction_angle": (SCM, {"soil.friction_angle": "35"}),
    "soil.janosi_shear": (SCM, {"soil.janosi_shear": "0.01"}),
    "soil.elastic_stiffness": (SCM, {"soil.elastic_stiffness": "2e8"}),
    "soil.damping": (CAR, {"soil.damping": "0"}),
    "soil.density": ({**LOOSE, "soil": "{cohesion: 300, friction_angle: 30, density: 1600}"}, {"soil.density": "300"}),
    "soil.face_strength": (SCM, {"soil.face_strength": "1e4"}),
    "soil.face_cohesion": (SCM, {"soil.face_cohesion": "100"}),
    "soil.unit_weight": ({**LOOSE, "soil": "{cohesion: 300, friction_angle: 30, unit_weight: 16000}"}, {"soil.unit_weight": "3000"}),
    "soil.repose": (SCM, {"soil.repose": "12"}),
    "soil.theta_in": (SUMNER, {"soil.theta_in": "5"}),
    "soil.theta_out": (SUMNER, {"soil.theta_out": "5"}),
    "soil.theta_stop": ({**SUMNER, "soil": "{name: sand, theta_out: 5}"}, {"soil.theta_stop": "6"}),
    "soil.roughness": (SUMNER, {"soil.roughness": "0.1"}),
    "soil.compression": (SUMNER, {"soil.compression": "0.2"}),
    "ground.roads": (ROAD, {"ground.roads": "[{points: [[10, 20], [14, 20]], width: 1, soil: lunar}]"}),
    "ground.roads[].points": (ROAD, {"ground.roads": "[{points: [[10, 23], [14, 23]], width: 1, soil: rock}]"}),
    "ground.roads[].smooth": ({**ROAD, "ground": "{roads: [{points: [[8, 20], [12, 20], [12, 24]], width: 0.5, soil: rock}]}"},
                              {"ground.roads": "[{points: [[8, 20], [12, 20], [12, 24]], smooth: true, width: 0.5, soil: rock}]"}),
    "ground.roads[].width": (ROAD, {"ground.roads": "[{points: [[10, 20], [12, 21], [12, 24]], width: 0.3, soil: rock}]"}),
    "ground.rocks.cover": (ROCKS, {"ground.rocks.cover": "0.2"}),
    "ground.rocks.k": (ROCKS, {"ground.rocks.k": "0.1"}),
    "ground.rocks.largest": (ROCKS, {"ground.rocks.largest": "2"}),
    "ground.rocks.smallest": (ROCKS, {"ground.rocks.smallest": "0.8"}),
    "ground.rocks.seed": (ROCKS, {"ground.rocks.seed": "2"}),
    "soil.map": (MAP, {"soil.map": "west.png"}),
    "soil.classes": (MAP, {"soil.classes": "{1: lunar, 2: lunar}"}),
    "soil.classes[].value": ({**MAP, "soil": "{map: map.png, classes: [{value: 1, name: dry_sand}, {value: 2, name: lunar}], default: clayey_38}"}, {"soil.classes": "[{value: 9, name: dry_sand}, {value: 2, name: lunar}]"}),
    "redistribute.model": (SUMNER, {"redistribute.model": "box", "redistribute.interval": "null", "soil": "null"}),
    "redistribute.radius": ({**PLAIN, "redistribute": "{model: box}"}, {"redistribute.radius": "2"}),
    "redistribute.repetitions": ({**PLAIN, "redistribute": "{model: box}"}, {"redistribute.repetitions": "3"}),
    "redistribute.regions": ({**PLAIN, "redistribute": "{model: box}"}, {"redistribute.regions": "fixed"}),  # it changes no ground, but counts
    "redistribute.iterations": (LOOSE, {"redistribute.iterations": "3"}),
    "redistribute.interval": (LOOSE, {"redistribute.interval": "0.3"}),
    "redistribute.depth": (LOOSE, {"redistribute.depth": "0.02"}),
    "redistribute.tolerance": (LOOSE, {"redistribute.tolerance": "0.05"}),
    "redistribute.bulldozing": (SCM, {"redistribute.bulldozing": "1"}),
    "redistribute.slip_sinkage": (SCM, {"redistribute.slip_sinkage": "4"}),
    "redistribute.loosening": (RUT, {"redistribute.loosening": "0.67"}),
    "redistribute.hardening": (RUT, {"redistribute.hardening": "0.5"}),
    "redistribute.faces": ({**SCM, "redistribute": "{model: scm, interval: 0.05, faces: on}", "objects": f"[{WHEEL % 'load: 900, slip: -0.5'}]"}, {"redistribute.faces": "off"}),
    "redistribute.inertia": ({**SCM, "redistribute": "{model: scm, interval: 0.05, faces: on}", "objects": f"[{WHEEL % 'load: 900, slip: -0.5'}]"}, {"redistribute.inertia": "0"}),
    "redistribute.tension": (SHEET, {"redistribute.tension": "20000"}),
    "redistribute.stiffness": (SHEET, {"redistribute.stiffness": "5000"}),
    "redistribute.yield": (SHEET, {"redistribute.yield": "0.03"}),
    "redistribute.rut": (SHEET, {"redistribute.rut": "0.3"}),
    "redistribute.thrown": ({**SCM, "objects": f"[{WHEEL % 'load: 900, slip: 0.8'}]"}, {"redistribute.thrown": "on"}),
    "redistribute.normals": (SCM, {"redistribute.normals": "ground"}),
    "redistribute.undisturbed": (LOOSE, {"redistribute.undisturbed": "stable"}),
    "output.forces": (SCM, {"output.forces": "5"}),
    "output.vehicles": (CAR, {"output.vehicles": "20"}),
    "output.sensors": (FELT, {"output.sensors": "20"}),
    "output.noise_seed": ({**FELT, "vehicles": FELT["vehicles"].replace("imu: {}", "imu: {noise: [0.1, 0.1]}")}, {"output.noise_seed": "9"}),
    "vehicles[].imu.body": (FELT, {"vehicles": FELT["vehicles"].replace("imu: {}", "imu: {body: wheel}")}),
    "vehicles[].imu.at": (FELT, {"vehicles": FELT["vehicles"].replace("imu: {}", "imu: {at: [0, 0, 5]}")}),
    "vehicles[].imu.noise": (FELT, {"vehicles": FELT["vehicles"].replace("imu: {}", "imu: {noise: [0.1, 0.1]}")}),
    "view.size": (VIEW, {"view.size": "[40, 32]"}),
    "view.camera.chase": ({**VIEW, "objects": f"[{WHEEL % 'sink: 0.2'}, {{name: b, shape: {{sphere: {{radius: 1}}}}, sink: 0.1, path: {{points: [[20, 9]], speed: 3}}}}]"},
                          {"view.camera.chase": "b"}),
    "view.camera.back": (VIEW, {"view.camera.back": "9"}),
    "view.camera.up": (VIEW, {"view.camera.up": "5"}),
    "view.camera.overhead.over": ({**VIEW, "objects": f"[{WHEEL % 'sink: 0.2'}, {{name: b, shape: {{sphere: {{radius: 1}}}}, sink: 0.1, path: {{points: [[20, 9]], speed: 3}}}}]",
                                   "view": VIEW["view"].replace("chase: a, back: 6, up: 3", "overhead: {over: a, height: 20}")}, {"view.camera.overhead.over": "b"}),
    "view.camera.overhead.height": ({**VIEW, "view": VIEW["view"].replace("chase: a, back: 6, up: 3", "overhead: {over: a, height: 20}")}, {"view.camera.overhead.height": "10"}),
    "view.camera.fixed.eye": ({**VIEW, "view": VIEW["view"].replace("chase: a, back: 6, up: 3", "fixed: {eye: [5, 5, 30], target: [12, 20, 10]}")}, {"view.camera.fixed.eye": "[5, 9, 30]"}),
    "view.camera.fixed.target": ({**VIEW, "view": VIEW["view"].replace("chase: a, back: 6, up: 3", "fixed: {eye: [5, 5, 30], target: [12, 20, 10]}")}, {"view.camera.fixed.target": "[20, 20, 9]"}),
    "view.effects": (VIEW, {"view.effects": "[sky]"}),
    "view.images": (VIEW, {"view.images": "4"}),
    "view.samples": (VIEW, {"view.samples": "4"}),
    "view.body": (VIEW, {"view.body": "mars"}),
    "view.sun.azimuth": (VIEW, {"view.sun": "{azimuth: 20}"}),
    "view.sun.height": (VIEW, {"view.sun": "{height: 70}"}),
    "view.sun.time": ({**VIEW, "view": VIEW["view"].replace("images: 6", "images: 6, sun: {time: '2026-06-01T10:00:00Z', at: [10, 45]}")}, {"view.sun.time": "2026-06-01T16:00:00Z"}),
    "view.sun.at": ({**VIEW, "view": VIEW["view"].replace("images: 6", "images: 6, sun: {time: '2026-06-01T10:00:00Z', at: [10, 45]}")}, {"view.sun.at": "[60, 45]"}),
    "view.exposure": ({**VIEW, "view": VIEW["view"].replace("images: 6", "images: 6, sun: {height: 12}")}, {"view.exposure": "sun"}),
    "view.ev": (VIEW, {"view.ev": "1"}),
    "view.sun.colour": (VIEW, {"view.sun": "{colour: [0.2, 1, 1]}"}),
    "view.truth": (VIEW, {"view.truth": "true"}),
    "view.pixel_error": ({**VIEW, "view": VIEW["view"].replace("[48, 32]", "[200, 150]")}, {"view.pixel_error": "16"}),
    "cache.slots": (PLAIN, {"cache": "{slots: 9}"}),
    "cache.memory": (PLAIN, {"cache": "{memory: 99 MB}"}),
    "cache.loaders": (PLAIN, {"cache": "{loaders: 0}"}),
    "cache.prefetch": (PLAIN, {"cache": "{prefetch: 0}"}),
    "lidars": (BEAMS, {"lidars": "[]"}),
    "lidars[].name": (BEAMS, beamed("name", ("name: l", "name: m"))),
    "lidars[].on": ({**BEAMS, "vehicles": BEAMS["vehicles"][:-1] + ", {name: other, model: one_wheel.xml, start: {at: [24, 22]}}]"}, beamed("on", ("on: car", "on: other"))),
    "lidars[].body": (BEAMS, beamed("body", "wheel")),
    "lidars[].pose.at": (BEAMS, beamed("at", ("[0, 0, 1]", "[0, 0, 2]"))),
    "lidars[].pose.target": (BEAMS, beamed("pose", ("[0, 0, 1]", "[0, 0, 1], target: [1, 0, 0]"))),
    "lidars[].pose.yaw": ({**BEAMS, "lidars": BEAMS["lidars"].replace("rays:", "fov: [60, 20], rays:")}, {"lidars": BEAMS["lidars"].replace("rays:", "fov: [60, 20], rays:").replace("1]}", "1], yaw: 77}")}),
    "lidars[].pose.pitch": (BEAMS, beamed("pose", ("[0, 0, 1]", "[0, 0, 1], pitch: 20"))),
    "lidars[].pose.roll": (BEAMS, beamed("pose", ("[0, 0, 1]", "[0, 0, 1], roll: 20"))),
    "lidars[].rays": (BEAMS, beamed("rays", ("[12, 4]", "[13, 4]"))),
    "lidars[].fov": (BEAMS, beamed("fov", "[300, 30]")),
    "lidars[].range": (BEAMS, beamed("range", ("[0, 30]", "[0, 3]"))),
    "lidars[].rate": (BEAMS, beamed("rate", ("rate: 10", "rate: 5"))),
    "lidars[].noise": (BEAMS, beamed("noise", "0.5")),
    "lidars[].dropout": (BEAMS, beamed("dropout", "0.5")),
    "cameras[].name": (SHOT, {"cameras.c.name": "d"}),
    "cameras[].kind": (camera("chase", "on: a"), {"cameras.c.kind": "overhead", "cameras.c.height": "20"}),
    "cameras[].on": ({**SHOT, "objects": f"[{WHEEL % 'sink: 0.2'}, {{name: b, shape: {{sphere: {{radius: 1}}}}, sink: 0.1, path: {{points: [[20, 9]], speed: 3}}}}]"}, {"cameras.c.on": "b"}),
    "cameras[].body": ({**CAR, "end_time": "0.5", "cameras": f"[{CAMERA % ('mounted', 'on: car, pose: {at: [-3, 0, 2], pitch: -30}')}]"}, {"cameras.c.body": "wheel"}),
    "cameras[].pose.at": (SHOT, {"cameras.c.pose.at": "[-4, 0, 2]"}),
    "cameras[].pose.target": (camera("fixed", "pose: {at: [5, 5, 30], target: [12, 20, 10]}"), {"cameras.c.pose.target": "[20, 20, 9]"}),
    "cameras[].pose.yaw": (SHOT, {"cameras.c.pose.yaw": "20"}),
    "cameras[].pose.pitch": (SHOT, {"cameras.c.pose.pitch": "-50"}),
    "cameras[].pose.roll": (SHOT, {"cameras.c.pose.roll": "30"}),
    "cameras[].back": (camera("chase", "on: a"), {"cameras.c.back": "6"}),
    "cameras[].up": (camera("chase", "on: a"), {"cameras.c.up": "9"}),
    "cameras[].height": (camera("overhead", "on: a, height: 20"), {"cameras.c.height": "9"}),
    "cameras[].file": (camera("poses", "file: eyes.csv"), {"cameras.c.file": "eyes2.csv"}),
    "cameras[].fov": (SHOT, {"cameras.c.fov": "40"}),
    "cameras[].size": (SHOT, {"cameras.c.size": "[40, 24]"}),
    "cameras[].rate": (SHOT, {"cameras.c.rate": "9"}),
    "cameras[].images": (SHOT, {"cameras.c.images": "[colour, height]"}),
    "cameras[].exposure": (SHOT, {"cameras.c.exposure": "auto"}),
    "cameras[].ev": (SHOT, {"cameras.c.ev": "1"}),
    "cameras[].depth_unit": ({**SHOT, "cameras": SHOT["cameras"].replace("rate: 4", "rate: 4, images: [depth]")}, {"cameras.c.depth_unit": "0.01"}),
    "cameras[].video": (SHOT, {"cameras.c.video": "true"}),
    "cameras[].stereo": (SHOT, {"cameras.c.stereo": "0.4"}),
}
ROWS["soil.rasters.thickness"] = (LAYER, {"soil.rasters": "{thickness: west.png}"})
ROWS["soil.rasters.compaction"] = (DENSE, {"soil.rasters": "{compaction: dense.png}"})
ROWS["soil.compaction"] = (DENSE, {"soil.compaction": "0.5"})
ROWS["soil.thickness"] = (LAYER, {"soil.thickness": "0.1"})
ROWS |= {f"soil.rasters.{key}": (SCM, {"soil.rasters": f"{{{key}: {key}.png}}"}) for key in
         ("bekker_kc", "bekker_kphi", "bekker_n", "cohesion", "friction_angle", "janosi_shear", "elastic_stiffness")}
# They need a store that lies on the Earth, and GDAL. These tests drive with two values of each.
ELSEWHERE = {"output.map": "tests/cli/contract.py", "coordinates": "tests/cli/lines.py", "objects[].path.line": "tests/cli/lines.py", "vehicles[].driver.path.file": "tests/cli/lines.py",
             "vehicles[].driver.path.line": "tests/cli/lines.py", "ground.roads[].lines": "tests/cli/roads.py",
             "view.imagery_budget": "tests/cli/imagery_drawn.py"}
UNUSED = ("output.delay",)  # kept for scenes that give it; changes nothing
RASTERS = {"bekker_kc": 5000, "bekker_kphi": 60000, "bekker_n": 2, "cohesion": 9000, "friction_angle": 45, "janosi_shear": 1, "elastic_stiffness": 50000}
# The same results whatever they are, so it is told by run.json alone.
TOLD = {"soil.face_strength": lambda run: run["soils"][0].get("face_strength"), "soil.face_cohesion": lambda run: run["soils"][0].get("face_cohesion"), "cache.slots": lambda run: run["cache"]["slots"], "cache.memory": lambda run: run["cache"]["slots"], "cache.loaders": lambda run: run["counts"]["threads"],
        "redistribute.regions": lambda run: run["counts"]["units"]["region"],
        "cache.prefetch": lambda run: run["counts"]["threads"]}
FOUR = """<mujoco model="four"><option timestep="0.002" integrator="implicit"/><worldbody><body name="car" pos="0 0 0.5"><freejoint/>
<geom name="hull" type="box" size="0.8 0.3 0.1" mass="80" contype="0" conaffinity="0"/>%s</body></worldbody><actuator><position name="steer" joint="steer" kp="300"/>
<velocity name="drive_a" joint="fl" kv="80"/><velocity name="drive_b" joint="fr" kv="80"/><velocity name="drive_c" joint="rl" kv="80"/><velocity name="drive_d" joint="rr" kv="80"/></actuator><keyframe><key name="turned" qpos="0 0 .5 1 0 0 0 .4 0 0 0 0" ctrl=".4 0 0 0 0"/></keyframe></mujoco>"""
WHEELS = "".join(f'<body name="{name}" pos="{x} {y} -0.2">{steer}<joint name="{name}" axis="0 1 0"/><geom name="{"left" if y > 0 else "right"}_{name}" type="cylinder" size="0.3 0.1" '
                 'euler="90 0 0" mass="8"/></body>' for name, x, y, steer in (("fl", 0.6, 0.4, '<joint name="steer" axis="0 0 1" damping="5"/>'), ("fr", 0.6, -0.4, ""), ("rl", -0.6, 0.4, ""),
                                                                              ("rr", -0.6, -0.4, "")))


def keys_of_page():
    """The keys with a value of their own. A mapping is told by its keys."""
    for line in PAGE.read_text().splitlines():
        found = re.match(r"\| `([^`]+)` \| ([^|]+) \|", line)
        if found and (found[2].strip() in LEAVES or found[2].strip().startswith("list of")):
            yield found[1]


def chosen():
    """All keys in `sh tools/test.sh long`; else a part of them, another one whenever the page changes. FURROW_KEYS=REGEX chooses others."""
    if "FURROW_KEYS" in os.environ:
        return [key for key in ROWS if re.search(os.environ["FURROW_KEYS"], key)]
    first = int(hashlib.sha256(PAGE.read_bytes()).hexdigest(), 16) % PART
    return [key for place, key in enumerate(ROWS) if FULL or place % PART == first]


class Keys(FurrowTest):
    maxDiff = None

    def setUp(self):
        super().setUp()
        self.synth("hills.furrow", posts="65x65", spacing=0.5, kind="ridged", relief=4)
        self.synth("flat.furrow", posts="65x65", spacing=0.5, kind="plain", relief=0.001)
        write_png16(self.folder / "map.png", 65, 65, lambda x, y: 1 + (x > 22))
        write_png16(self.folder / "west.png", 65, 65, lambda x, y: 2)
        write_png16(self.folder / "dense.png", 65, 65, lambda x, y: 1)
        for key, value in RASTERS.items():
            write_png16(self.folder / f"{key}.png", 65, 65, lambda x, y: value)
        one = (ROOT / "tests/vehicle/one_wheel.xml").read_text()
        texts = {"one_wheel.xml": one, "wall.xml": '<mujoco><worldbody><geom name="wall" type="box" pos="20.6 20 0" size="0.2 2 500"/></worldbody></mujoco>',
                 "brick.xml": '<mujoco><worldbody><body name="car"><freejoint/><geom name="brick" type="box" size=".4 .3 .2" mass="40"/></body></worldbody></mujoco>', "pushes.csv": "t,body,fx,fy,fz\n0.1,carriage,200,0,0\n",
                 "tray.xml": (ROOT / "tests/vehicle/tray.xml").read_text(), "heavy.xml": one.replace('mass="70"', 'mass="140"'), "four.xml": FOUR % WHEELS, "one.csv": "t,drive\n0,3\n", "one_engine.csv": "rpm,torque\n500,20\n6000,20\n", "two_engine.csv": "500,15\n6000,20\n", "two.csv": "t,drive\n0,5\n",
                 "poses.csv": "t,x,y,yaw,pitch,roll\n".replace(",yaw,pitch,roll", "") + "0,10,20\n0.6,11,20\n", "lying.csv": "t,x,y,z,yaw,pitch,roll\n0,10,20,0.3,0,0,90\n0.6,11,20,0.3,0,0,90\n", "other.csv": "t,x,y\n0,10,20\n0.6,11,23\n",
                 "eyes.csv": "t,x,y,z,yaw,pitch,roll\n0,12,10,20,90,-40,0\n", "eyes2.csv": "t,x,y,z,yaw,pitch,roll\n0,12,12,20,90,-40,0\n"}
        for file, half in (("a.obj", 0.6), ("b.obj", 1.2)):
            texts[file] = "".join(f"v {x} {y} {z}\n" for x in (-1, 1) for y in (-half, half) for z in (-0.5, 0.5)) + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
        inertial = '<inertial><mass value="%g"/><inertia ixx="%g" iyy="%g" izz="%g" ixy="0" ixz="0" iyz="0"/></inertial>'
        texts["cart.urdf"] = "<robot name='cart'><link name='base'>" + inertial % (80, 5, 8, 8) + "<collision><geometry><mesh filename='package://parts/hull.obj' scale='.5 .3 .2'/></geometry></collision></link>" + "".join(
            f"<link name='{name}'>" + inertial % (8, .2, .3, .2) + "<collision><origin rpy='1.5708 0 0'/><geometry><cylinder radius='.3' length='.2'/></geometry></collision></link>"
            f"<joint name='wheel_{name}' type='continuous'><parent link='base'/><child link='{name}'/><origin xyz='{x} {y} -.2'/><axis xyz='0 1 0'/></joint>"
            for name, x, y in (("fl", .6, .5), ("fr", .6, -.5), ("rl", -.6, .5), ("rr", -.6, -.5))) + "</robot>"
        texts["armed.urdf"] = texts["cart.urdf"].replace("</robot>", "<link name='hand'>" + inertial.replace("<mass", "<origin xyz='0.3 0 0'/><mass") % (2, .1, .1, .1) +
                                                         "</link><joint name='arm' type='revolute'><parent link='base'/><child link='hand'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='9' velocity='1'/></joint></robot>")
        (self.folder / "packages" / "parts").mkdir(parents=True)
        (self.folder / "packages" / "parts" / "hull.obj").write_text(texts["a.obj"])
        for name, text in texts.items():
            (self.folder / name).write_text(text)

    def drive_and_read(self, key, name, store, overlay, sets):
        out = self.folder / f"{name}.out"
        result = self.furrow("drive", "base.yaml", *store, "--overlay", overlay, "-o", out, *sets)
        if result.returncode == 4 or "this build has no" in result.stderr:
            return None
        told = re.sub(r"[\d.]+ s\b|\d+ s of|[\w./-]+\.(furrow|out)", "", result.stderr)
        told = "\n".join(line for line in told.splitlines() if " a second" not in line and "pictures take" not in line and "settling" not in line)
        left = {"status": result.returncode, "told": told}
        for file in sorted(out.rglob("*")) if out.exists() else ():
            if file.is_dir() or file.name in ("run.json", "epochs.log", "map.png", "cameras.json", "camera.json", "lidar.json", "sensors.json"):
                continue
            place = str(file.relative_to(out))
            left[place] = file.read_bytes()
            if file.name == "objects.csv":
                rows = [line.split(",") for line in file.read_text().splitlines()]
                kept = [i for i, column in enumerate(rows[0]) if column not in ("slip", "load")]
                left[place] = [[row[i] for i in kept] for row in rows]
        if (out / "run.json").exists():
            run = json.loads((out / "run.json").read_text())
            left["steps"] = run["steps"], run["ended"]
            if key in TOLD:
                left["run"] = TOLD[key](run)
        if overlay.exists():
            with sqlite3.connect(overlay) as rows:
                left["ground"] = {table: rows.execute(f"SELECT * FROM {table}").fetchall() for table in ("offset", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "dirt", "healed", "risen", "grown")
                                  if rows.execute("SELECT count(*) FROM sqlite_master WHERE name = ?", (table,)).fetchone()[0]}
        return left

    def test_every_key_has_a_row(self):
        self.assertEqual(sorted([*ROWS, *ELSEWHERE, *UNUSED]), sorted(set(keys_of_page())), "give a new key a scene in which it changes a result")
        for key, test in ELSEWHERE.items():
            self.assertIn(key.split(".")[-1], (ROOT / test).read_text(), f"{test} drives no such scene")

    def test_each_key_changes_what_a_drive_leaves(self):
        idle = []
        for key in chosen():
            scene, change = ROWS[key]
            text = "".join(f"{word}: {value}\n" for word, value in scene.items())
            self.scene("scene: 1\n" + text, "base.yaml")
            store = [] if "store" in scene else ["--store", self.folder / "hills.furrow"]
            sets = [word for name, value in change.items() for word in ("--set", f"{name}={value}")]
            left = []
            for name, settings in (("one", []), ("two", sets)):
                shutil.rmtree(self.folder / f"{name}.out", ignore_errors=True)
                for file in self.folder.glob(f"{name}.furrow*"):
                    file.unlink()
                left.append(self.drive_and_read(key, name, store, self.folder / f"{name}.furrow", settings))
            if None in left:
                continue
            # A refusal would be a difference as well, and tell nothing of the key.
            for which, allowed in ((0, (0, 1) if key == "outside" else (0,)), (1, (3,) if key == "scene" else (0,))):
                if left[which]["status"] not in allowed:
                    idle.append((key, left[which]["told"]))
            if left[0] == left[1]:
                idle.append(key)
        self.assertEqual(idle, [], "nothing reads these, or their scene is refused")


if __name__ == "__main__":
    main()
