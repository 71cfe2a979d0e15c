"""furrow explain: what a scene will make and run, told before; and what a drive then made and ran."""
import csv
import itertools
import json
import math
import pathlib
import re
import resource
import shutil
import sqlite3
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, SCENE, FurrowTest, long, main  # noqa: E402

SCENES = pathlib.Path(__file__).parents[2] / "tools" / "scenes"

BARE = """scene: 1
time_step: 0.1
end_time: 3
objects:
  - {name: a, shape: {wheel: {radius: 1.5, width: 1}}, sink: 0.2, path: {points: [[20, 20], [100, 90]], speed: 10}}
  - {name: b, shape: {wheel: {radius: 1.5, width: 1}}, sink: 0.2, path: {points: [[30, 20], [110, 90]], speed: 10}}
  - {name: c, shape: {sphere: {radius: 2}}, sink: 0.2, path: {points: [[60, 20], [60, 30]], speed: 10}}
"""
VIEW = "{camera: {fixed: {eye: [60, 0, 60], target: [60, 60, 10]}}, size: [64, 48], images: 10}"
ROWS = ["planes", "programs", "passes", "textures", "buffers", "threads", "tables"]


def rows(plan):
    """Every line of a plan, hashable: (section, name or stage, object, unit, amount, effect)."""
    return [(section, row.get("name", row.get("stage")), row.get("object"), row.get("unit"), row.get("amount"),
             row["effect"]) for section in ROWS for row in plan[section]]


class Explain(FurrowTest):
    def setUp(self):
        super().setUp()
        # A demo that was driven here has left its store where its scene looks for one.
        scenes = shutil.copytree(SCENES, self.folder / "tools" / "scenes")
        self.all_shipped = sorted(scenes.glob("*.yaml"))
        self.assertGreater(len(self.all_shipped), 5)

    def shipped(self, scene, *arguments):
        result = self.furrow("explain", scene, *arguments)
        if "this build reads no meshes" in result.stderr:
            self.skipTest("no meshes")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout

    def bare(self, *settings):
        arguments = [part for setting in settings for part in ("--set", setting)]
        return self.json("explain", self.folder / "bare.yaml", "--store", self.folder / "world.furrow", *arguments)

    def test_every_shipped_scene_is_told_within_the_page(self):
        store = self.synth(posts="513x513")
        for scene in self.all_shipped:
            for arguments in ([], ["--store", store]):
                with self.subTest(scene=scene.name, store=bool(arguments)):
                    only_all = ["effects", "planes: ", "programs: ", "passes", "threads: ", "tables", "not run"]
                    for text, here, not_here in ((self.shipped(scene, *arguments, "--all"), ["memory", *only_all], ["bodies"]),
                                                 (self.shipped(scene, *arguments), ["bodies, and passes", "memory"], only_all)):
                        self.assertLessEqual(max(len(line) for line in text.splitlines()[1:]), 100)
                        self.assertEqual("assumed" in text, not arguments)
                        for section in here:
                            self.assertIn("\n" + section, text)
                        for section in not_here:
                            self.assertNotIn("\n" + section, text)
                        self.assertNotIn("(null)", text)
                    self.assertLess(len(text.splitlines()), 60)
                    self.assertTrue(text.splitlines()[-1].endswith("--all shows effects, planes, programs, passes, threads and statements"))

    def test_every_line_has_a_reason_that_the_scene_gives(self):
        store = self.synth(posts="513x513")
        for scene in self.all_shipped:
            with self.subTest(scene=scene.name):
                if self.furrow("explain", scene).returncode != 0:
                    continue
                plan = self.json("explain", scene, "--store", store)
                called = {effect["name"]: effect for effect in plan["effects"] if effect["called"]}
                for section in ROWS:
                    for row in plan[section]:
                        if row["effect"] is None:
                            self.assertEqual(row["reason"], "every drive")
                        else:
                            self.assertIn(row["effect"], called, row)
                            self.assertEqual(row["reason"], called[row["effect"]]["reason"])
                for effect in plan["effects"]:
                    self.assertEqual(effect["called"], effect["reason"] is not None)

    def test_what_is_not_called_for_is_told(self):
        """No loaders where every tile has a slot; no slip where nothing slips; forces where loads sum them; a queue within the memory there is."""
        store = self.synth(posts="257x257", kind="plain")
        wheel = self.scene(BARE.replace("sphere: {radius: 2}", "wheel: {radius: 2, width: 1}").replace("sink: 0.2", "load: 900") +
                           "soil: {name: dry_sand}\nredistribute: {model: scm}\n")
        called = lambda plan: {effect["name"]: effect["reason"] for effect in plan["effects"] if effect["called"]}
        plan = self.json("explain", wheel, "--store", store)
        self.assertEqual([row["name"] for row in plan["threads"]], ["furrow-write"])
        self.assertIs(plan["memory"]["holds_all"], True)
        self.assertEqual({"slip", "loaders", "prefetch"} & set(called(plan)), set())
        self.assertEqual(called(plan)["forces"], "objects.a.load")
        text = self.ok("explain", wheel, "--store", store, "--all")
        self.assertIn("every tile of the store has a slot: none is loaded ahead, and there are no loaders", text)
        few = self.json("explain", wheel, "--store", store, "--set", "spacing=0.25", "--set", "cache.slots=12", "--set", "objects.a.slip=0.1")
        self.assertEqual((few["memory"]["holds_all"], called(few)["slip"], called(few)["loaders"]),
                         (False, "redistribute.slip_sinkage: 1.35", "cache.loaders: 2"))
        bounds = []
        for limit in (resource.RLIM_INFINITY, 3 * 10**9):  # of a large terrain, where one step may change thousands of tiles
            large = json.loads(subprocess.run([FURROW, "explain", wheel, "--set", "spacing=0.25", "--json"], capture_output=True, check=True,
                                              preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))).stdout)["memory"]
            self.assertLessEqual(large["most"]["total"], large["usable"]["bytes"])
            bounds.append((large["most"]["queue"], large["usable"]["of"]))
        self.assertEqual(bounds[1][1], "ulimit -v")
        self.assertLess(bounds[1][0], bounds[0][0])

    def test_soils_and_vehicles_tell_where_their_numbers_come_from(self):
        scene, own = self.folder / "tools/scenes/vehicles/offroad.yaml", ("--set", "soil.cohesion=1040", "--set", "soil.damping=null", "--set", "vehicles.car.driver.drive=[drive_rear_*]")
        result = self.furrow("explain", scene, *own)
        if "this build has no MuJoCo" in result.stderr:
            self.skipTest("this build has no MuJoCo")
        text = " ".join(result.stdout.split())
        for told in ("sandy_loam_15: the scene's cohesion 1040 Pa; the name's bekker_kc 5270 N/m^(n+1), bekker_kphi 1515040 N/m^(n+2), bekker_n 0.7, "
                     "friction_angle 29 degrees, janosi_shear 0.02 m, density 1529 kg/m3, unit_weight 15000 N/m3, repose 29 degrees; defaults elastic_stiffness 40000000 Pa/m, damping 30000 Pa s/m",
                     "car.wheel_front_left, car.wheel_front_right, car.wheel_rear_left, car.wheel_rear_right (wheel, radius 0.4 m, width 0.2 m)",
                     "7 soil geoms, 6 actuators, 1 engine step in a time step; ",
                     "actuators: driver.steer: steer_front_left, steer_front_right; driver.drive: drive_rear_left, drive_rear_right; "
                     "no key, so 0: drive_front_left, drive_front_right "):
            self.assertIn(told, text)
        plan = self.json("explain", scene, *own)
        self.assertEqual([plan["soils"][0][key] for key in ("cohesion", "damping")], [{"value": 1040, "from": "scene"}, {"value": 30000, "from": "default"}])
        self.assertEqual(plan["vehicles"]["car"]["shapes"]["car.wheel_rear_left"], "wheel, radius 0.4 m, width 0.2 m")
        self.assertEqual([plan["vehicles"]["car"]["actuators"]["drive_" + name] for name in ("front_left", "rear_left")], [None, "drive"])

    def test_the_demo_has_time_for_its_path(self):
        text = (SCENES / "vehicles/offroad.yaml").read_text()  # at a mean of 2.6 m/s the vehicle arrives after 22 s
        points, speed = re.search(r"points: (\[\[.*?\]\]), speed: ([\d.]+)", text).groups()
        length = sum(math.dist(a, b) for a, b in itertools.pairwise(json.loads(points)))
        self.assertGreater(float(re.search(r"^end_time: (\S+)", text, re.M)[1]), 1.18 * length / float(speed))

    def test_loads_on_level_ground_are_those_after_settling(self):
        store = self.synth(kind="plain", spacing=0.5, relief=0)
        for scene, geoms in (("offroad", 4), ("rover", 6), ("tracked", 2), ("walker", 4)):
            path = self.folder / f"tools/scenes/vehicles/{scene}.yaml"
            if "this build has no MuJoCo" in self.furrow("explain", path).stderr:
                self.skipTest("this build has no MuJoCo")
            (vehicle,) = self.json("explain", path)["vehicles"].values()
            weight = vehicle["mass"] * (1.62 if scene == "rover" else 9.81)
            self.drive(path, "--store", store, "--overlay", f"{scene}.furrow", "--set", "end_time=0.002", "--set", "output.forces=500")
            with open(self.folder / "out/objects.csv", newline="") as file:
                loads = {row["name"]: float(row["fz"]) for row in csv.DictReader(file) if float(row["t"]) == 0}
            self.assertEqual((set(loads), len(loads)), ({name for name, share in vehicle["shares"].items() if share}, geoms))
            text = " ".join(self.ok("explain", path).split())
            for name, load in loads.items():
                share = vehicle["shares"][name]
                self.assertLess(abs(share * weight / load - 1), 0.01, (name, load))
                self.assertIn(f"{name} {share * weight:.4g} N ({100 * share:.1f} %)", text)

    def test_a_model_that_does_not_stand_has_no_loads(self):
        (self.folder / "falls.xml").write_text("<mujoco><option timestep='0.002'/><worldbody><body pos='0 0 1'><freejoint/><geom name='pole' type='box' size='.1 .1 .1' mass='9'/>"
                                               "<body pos='2 0 0'><geom name='weight' type='box' size='.1 .1 .1' mass='90'/></body></body></worldbody></mujoco>")
        scene = self.scene("scene: 1\ntime_step: 0.002\nend_time: 1\nspacing: 0.1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
                           "vehicles: [{name: v, model: falls.xml, start: {at: [5, 5]}, soil: [pole]}]\n")
        result = self.furrow("explain", scene)
        if "this build has no MuJoCo" in result.stderr:
            self.skipTest("this build has no MuJoCo")
        self.assertIn("load on level ground: not known", " ".join(result.stdout.split()))
        self.assertEqual(self.json("explain", scene)["vehicles"]["v"]["shares"], {"v.pole": None})

    def test_json_says_what_an_effect_is(self):
        self.synth()
        self.scene(BARE, "bare.yaml")
        plan = self.bare("redistribute.model=box", "redistribute.radius=2")
        box = next(effect for effect in plan["effects"] if effect["name"] == "box")
        self.assertEqual(box["key"], "redistribute.model")
        self.assertEqual(box["reason"], "redistribute.model: box")
        self.assertEqual((box["reads"], box["writes"], box["stencil"]), (["base", "offset"], ["offset"], 4))
        self.assertEqual(box["shaders"], ["deform/box.frag", "deform/gather.frag", "deform/store.frag"])
        self.assertEqual(box["parameters"][0], {"key": "redistribute.radius", "kind": "whole number", "unit": "posts",
                                                "range": [1, 4], "above": False, "words": [], "default": 1})
        self.assertTrue(box["limits"])
        self.assertEqual((plan["assumed"], plan["cells"], plan["level"], plan["spacing"]), (False, 256, 0, 1))
        self.assertEqual((plan["steps"], plan["pictures"], plan["deformed"]), (30, 0, False))
        self.assertEqual(plan["stations"], {"a": 31, "b": 31, "c": 11})
        most = plan["memory"]["most"]
        self.assertEqual(most["total"], sum(most[key] for key in ("slots", "loads", "queue", "ground")))
        self.assertEqual(most["total_few"], sum(most[key] for key in ("slots", "loads", "queue_few", "ground")))

    def test_the_store_decides_level_and_spacing(self):
        scene = self.scene(BARE + "spacing: 0.3\n")
        plan = self.json("explain", scene)
        self.assertEqual((plan["assumed"], plan["store"], plan["level"], plan["spacing"]), (True, None, 0, 0.3))
        store = self.synth(spacing=1)
        plan = self.json("explain", scene, "--store", store)
        self.assertEqual((plan["assumed"], plan["store"], plan["level"], plan["spacing"]), (False, str(store), -2, 0.25))
        self.assertIn("subdivide.frag", " ".join(row["name"] for row in plan["programs"]))
        # The scene's own store is looked for beside it, and assumed where it is not there yet.
        named = self.scene(BARE + "store: world.furrow\n", "named.yaml")
        self.assertFalse(self.json("explain", named)["assumed"])
        store.unlink()
        self.assertTrue(self.json("explain", named)["assumed"])

    def test_a_key_changes_its_own_rows_and_no_others(self):
        self.synth()
        self.scene(BARE, "bare.yaml")
        bare = self.bare()
        for setting, effects in [("attributes=[dirt]", {"dirt"}), ("redistribute.model=box", {"box"}),
                                 ("objects.a.shape.wheel.lugs=8", {"lugs"}), ("spacing=0.5", {"subdivide"}),
                                 ("view=" + VIEW, {"picture", "normals", "pyramid", "images"})]:
            with self.subTest(setting=setting):
                plan = self.bare(setting)
                before, after = rows(bare), rows(plan)
                changed = [row for row in after if row not in before] + [row for row in before if row not in after]
                # An object that leaves a mark needs to know what it touched: the press is another variant.
                variants = [row for row in changed if row[0] == "programs" and row[5] == "displace"]
                # The last pass of a batch writes the tiles: without box that is the press.
                last = [row for row in changed if row[:2] == ("passes", "press") and row[3] in ("batch", "batch_store")]
                self.assertLessEqual({row[5] for row in changed if row not in variants + last}, effects, changed)
                # A batch has other programs without box, whose last pass writes the tiles.
                alone = [row for row in variants if "batch.vert" not in row[1]]
                self.assertEqual(len([row for row in alone if row in after]), len([row for row in alone if row in before]))
                called = {effect["name"] for effect in plan["effects"] if effect["called"]}
                was = {effect["name"] for effect in bare["effects"] if effect["called"]}
                self.assertEqual(called ^ was, effects)
                self.assertEqual(rows(self.bare()), before)
        # Where every tile has a slot, these call for nothing. Here they have none.
        few = ("spacing=0.125", "cache.slots=8")
        for setting, effect in (("cache.loaders=0", "loaders"), ("cache.prefetch=0", "prefetch")):
            self.assertEqual(rows(self.bare(setting)), rows(bare))
            before, after = rows(self.bare(*few)), rows(self.bare(*few, setting))
            # Without loaders fewer images of pages wait: the same lines, of another amount.
            self.assertEqual({row[5] for row in set(before) ^ set(after) if not row[1].startswith("loads: ")}, {effect})

    def test_dirt_adds_its_plane_program_pass_and_table(self):
        self.synth()
        self.scene(BARE, "bare.yaml")
        bare, dirty = self.bare(), self.bare("attributes=[dirt]")
        own = [row for row in rows(dirty) if row[5] == "dirt"]
        self.assertEqual([row for row in rows(bare) if row[5] == "dirt"], [])
        self.assertEqual([row[1] for row in own if row[0] == "planes"], ["dirt"])
        self.assertEqual([row[1].split(" PASSED")[0] for row in own if row[0] == "programs"],
                         ["full.vert deform/disturbance.frag", "deform/batch.vert deform/disturbance.frag"])
        self.assertEqual([row[1:4] for row in own if row[0] == "passes"],
                         [("dirt", "a", "window"), ("dirt", "b", "window"), ("dirt", "c", "window"), ("dirt", None, "batch_store")])
        self.assertEqual({row[1] for row in own if row[0] == "tables"}, {"read dirt", "write dirt"})
        self.assertEqual([row for row in own if row[0] == "threads"], [])

    def test_objects_that_are_alike_are_folded(self):
        self.synth()
        text = self.ok("explain", self.scene(BARE), "--store", "world.furrow", "--all")
        self.assertIn("\n  a and 1 like it: 31 path samples each", text)
        self.assertIn("\n  c: 11 path samples", text)
        self.assertNotIn("\n  b:", text)
        self.assertNotIn("\n  b and", text)

    def test_the_law_of_each_part_is_told(self):
        self.synth()
        scene = self.scene("""scene: 1
end_time: 1
spacing: 0.05
soil: {name: dry_sand}
redistribute: {model: scm, faces: on}
objects:
  - {name: rolls, shape: {wheel: {radius: 0.4, width: 0.2}}, load: 900, path: {points: [[10, 10], [20, 10]], speed: 1}}
  - {name: too, shape: {wheel: {radius: 0.4, width: 0.2}}, load: 900, path: {points: [[10, 20], [20, 20]], speed: 1}}
  - {name: aside, shape: {wheel: {radius: 0.4, width: 0.2, grousers: 12}}, load: 900, attitude: [90, 0, 0], path: {points: [[10, 15], [20, 15]], speed: 1}}
  - {name: blade, shape: {box: {size: [0.1, 1, 0.4]}}, sink: 0.1, path: {points: [[10, 25], [20, 25]], speed: 1}}
""")
        text = " ".join(self.ok("explain", scene, "--store", "world.furrow").split())
        plan = self.json("explain", scene, "--store", "world.furrow")
        told = plan["laws"]
        self.assertEqual(list(told), ["rolls", "too", "aside", "blade"])
        self.assertIn("laws rolls and 1 other: rim: Bekker and Janosi; sides: nothing; ", text)
        self.assertIn("aside: slides 1 of its way; rim: 3D-RFT; sides: 3D-RFT; bars: 3D-RFT; ", text)
        self.assertIn("blade: slides 1 of its way; underside: 3D-RFT; front and sides: 3D-RFT; ", text)
        posts = 0.4 / plan["spacing"]
        self.assertAlmostEqual(told["rolls"]["posts_over_radius"], posts, delta=1e-9)
        self.assertIn(f"{posts:.2g} posts over its radius: its level force may be off by about {round(100 * told['rolls']['error'])} % of its load", text)
        self.assertAlmostEqual(told["blade"]["posts_over_depth"], posts / 4, delta=1e-9)
        self.assertEqual([round(part["faces"], 5) for part in told["aside"]["parts"]], [1, 1, 1])
        off = self.json("explain", scene, "--store", "world.furrow", "--set", "redistribute.faces=off")["laws"]
        self.assertEqual([part["faces"] for part in off["aside"]["parts"] + off["blade"]["parts"]], [0] * 5)
        box = self.json("explain", scene, "--store", "world.furrow", "--set", "redistribute.model=box", "--set", "redistribute.faces=null", "--set", "soil=null", "--set", "objects.rolls.load=null",
                        "--set", "objects.too.load=null", "--set", "objects.aside.load=null")
        self.assertEqual(box["laws"], {})

    def test_posts_and_passes_of_bodies_are_told(self):
        self.synth()
        load = ("--set", "redistribute.model=scm", "--set", "soil.name=dry_sand", "--set", "spacing=0.25")
        text = self.ok("explain", self.scene(BARE), "--store", "world.furrow", *load)
        # A wheel is wider than it is long where it is 0.2 m deep: 2 (0.2) (1.5 - 0.2) / sqrt(0.2 (3 - 0.2)).
        self.assertIn("121 path samples each, one window each, on the CPU, on ground\n    2.8 posts below each: the soil bears it over about 0.69 m\n  c: ", text)
        text = self.ok("explain", "scene.yaml", "--store", "world.furrow", "--set", "redistribute.model=box")
        plan = self.json("explain", "scene.yaml", "--store", "world.furrow", "--set", "redistribute.model=box")
        passes = sum(row["amount"] for row in plan["passes"] if row["object"] == "a" and row["unit"] == "window")
        self.assertGreater(passes, 0)
        self.assertIn(f"\n    passes: {passes} a window, 1 a window that it moved over\n  c: ", text)

    def test_an_elastic_sheet_tells_what_a_contact_costs(self):
        store = self.synth(posts="257x257", kind="plain")
        scene = self.scene(BARE + "spacing: 0.25\nredistribute: {model: sheet, tension: 50000, stiffness: 50000}\n")
        self.assertIn("the sheet bends over 1 m, 4 posts: each contact makes 32 rounds over all posts within 25 of the body", self.ok("explain", scene, "--store", store))
        plan = self.json("explain", scene, "--store", store)
        self.assertEqual((plan["compute"], plan["sheet"]), ("cpu", {"length": 1, "rounds": 32, "reach": 25}))
        plan = self.json("explain", scene, "--store", store, "--set", "compute=gpu")
        passes = {row["stage"]: row["amount"] for row in plan["passes"] if row["object"] == plan["passes"][0]["object"] and row["unit"] == "window"}
        # Where it lets go and where it presses; two that find which posts move, two a round, and one that sets them.
        self.assertEqual((plan["compute"], passes), ("gpu", {"underside": 2, "press": 2, "bend": 2 + 2 * 32 + 1}))
        self.assertIn("the ground is computed by the GPU\n", self.ok("explain", scene, "--store", store, "--set", "compute=gpu"))
        self.assertEqual((self.json("explain", scene, "--store", store)["passes"], self.json("explain", scene, "--store", store)["programs"]), ([], []))
        self.assertIn("more than 16 posts of 0.25 m; give a coarser spacing", self.refused(3, "explain", scene, "--store", store, "--set", "redistribute.tension=1e6"))
        self.assertNotIn("sheet", self.json("explain", self.scene(BARE), "--store", store))

    def test_what_is_beside_ruts_is_told_with_its_cost(self):
        store = self.synth(posts="257x257", kind="plain")
        scene = self.scene(BARE.replace("c, shape: {sphere: {radius: 2}}, sink: 0.2", "c, shape: {box: {size: [2, 2, 1]}}, sink: 0.2, carry: true") +
                           "spacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm, thrown: on}\nattributes: {disturbance: {heals: 86400}, vegetation: {cover: 0.5}}\n", "beside.yaml")
        told = self.ok("explain", scene, "--store", store, "--set", "objects.a.slip=0.4").split("\nbeside ruts\n")[1].split("\n\n")[0]
        bytes_of = {row["name"]: row["bytes"] for row in self.json("explain", scene, "--store", store, "--set", "objects.a.slip=0.4")["buffers"]}
        told = " ".join(told.split())
        self.assertIn(f"carry: soil stays aboard c: {bytes_of['soil aboard bodies'] / 1024:.3g} KiB. It settles after each contact, and for each 0.05 s", told)
        self.assertIn(f"thrown: rims that slip throw soil, which flies as grains and lands: {bytes_of['grains in flight'] / 2 ** 20:.3g} MiB", told)
        self.assertIn("disturbance: marks fade, the darkest in 86400 s: 4 bytes a post", told)
        self.assertIn("vegetation: plants are pressed and torn, rise and grow back: 8 bytes a post", told)
        self.assertNotIn("beside ruts", self.ok("explain", self.scene(BARE), "--store", store))
        for line in self.ok("explain", scene, "--store", store, "--all").splitlines():
            self.assertNotIn("null", line)

    def test_effects_that_nothing_shows_are_told(self):
        store = self.synth(posts="257x257", kind="plain")

        def told(text, word):
            notes = self.json("explain", self.scene(text, "shows.yaml"), "--store", store)["notes"]
            return [note for note in notes if note.startswith(word)]

        ball = "scene: 1\ntime_step: 0.1\nend_time: 3\nspacing: 0.25\nobjects:\n  - {name: a, shape: %s, sink: 0.1, path: {points: [[20, 20], [50, 20]], speed: 10}%s}\n"
        thrown = ball + "soil: {name: dry_sand}\nredistribute: {model: scm, thrown: on}\n"
        self.assertEqual(told(thrown % ("{box: {size: [2, 2, 1]}}", ""), "redistribute.thrown"),
                         ["redistribute.thrown: rims that slip throw soil, and no object turns; add a wheel with a slip, or take thrown away"])
        self.assertEqual(told(thrown % ("{wheel: {radius: 1, width: 1}}", ""), "redistribute.thrown"),
                         ["redistribute.thrown: nothing slips, so nothing is thrown; give a wheel a slip, or take thrown away"])
        self.assertEqual(told(thrown % ("{wheel: {radius: 1, width: 1}}", ", slip: 0.3"), "redistribute.thrown"), [])
        sheet = ball % ("{box: {size: [2, 2, 1]}}", "") + "redistribute: {model: sheet, tension: 1000, stiffness: %s}\n"
        self.assertRegex("".join(told(sheet % "1e6", "redistribute.stiffness")), "bends over 0.0316 m, and posts are 0.25 m apart")
        self.assertEqual(told(sheet % "1000", "redistribute.stiffness"), [])
        plants = ball % ("{box: {size: [2, 2, 1]}}", "") + "attributes: {vegetation: {cover: 0.5}}\n"
        self.assertRegex("".join(told(plants, "attributes.vegetation")), "no picture shows it")
        self.assertEqual(told(plants + f"view: {VIEW}\n", "attributes.vegetation"), [])

    def slots_note(self, setting):
        plan = self.json("explain", self.scene(BARE, "bare.yaml"), "--store", "world.furrow", "--set", setting)
        return "".join(note for note in plan["notes"] if note.startswith("cache.slots"))

    def test_no_size_is_told_as_a_power(self):
        self.synth()
        view = VIEW.replace("[64, 48]", "[128, 487]")  # 999.75 KiB once
        text = self.ok("explain", self.scene(BARE), "--store", "world.furrow", "--set", "view=" + view, "--all")
        self.assertIn("\n  0.976 MiB    once", text)
        self.assertNotIn("e+", text)

    def test_what_has_no_effect_is_told(self):
        self.synth()
        scene = self.scene(BARE + "gravity: 1.62\nsoil: {name: mud}\n")
        plan = self.json("explain", scene, "--store", "world.furrow", "--set", "cache.slots=2000")
        self.assertEqual([note.split(":")[0] for note in plan["notes"]], ["soil", "gravity", "objects.a.path", "cache.slots"])
        text = self.ok("explain", scene, "--all")
        self.assertIn("\nnotes\n  soil: ", text)
        self.assertLess(text.index("\nnotes\n"), text.index("\neffects\n"))
        self.assertEqual(text.splitlines()[-1], "2 notes: see the top")
        self.assertTrue(self.ok("explain", scene).splitlines()[-1].startswith("2 notes: see the top; --all shows "))
        self.assertIn("the store has 1 tile at this spacing: the others stay empty; give 4", self.slots_note("cache.slots=5"))
        self.assertEqual(self.slots_note("cache.slots=4"), "")  # no fewer are allowed
        arrives = BARE.replace("90]], speed: 10", "90]], speed: 36")
        self.assertEqual(self.json("explain", self.scene(arrives, "bare.yaml"), "--store", "world.furrow")["notes"], [])
        self.assertNotIn("note", self.ok("explain", "bare.yaml", "--store", "world.furrow"))
        # What depends on the posts is told where they are known.
        narrow = self.scene(arrives.replace("width: 1", "width: 0.5"), "narrow.yaml")
        self.assertEqual(self.json("explain", narrow)["notes"], [])
        self.assertEqual(len(self.json("explain", narrow, "--store", "world.furrow")["notes"]), 1)

    def notes(self, scene, *settings):
        arguments = [part for setting in settings for part in ("--set", setting)]
        notes = self.json("explain", scene, "--store", "world.furrow", *arguments)["notes"]
        return [note for note in notes if "path: the drive ends after" not in note]  # which it does: tests/cli/notes.py

    def test_a_spacing_that_the_store_has_not_is_told(self):
        self.synth()
        scene = self.scene(BARE)
        self.assertEqual(self.notes(scene, "spacing=0.1"),
                         ["spacing: 0.1 m: posts will be 0.0625 m apart, the coarsest of this store that is at most that; "
                          "give 0.0625, or 0.125 for a quarter of the posts"])
        self.assertEqual(self.notes(scene, "spacing=0.99", "cache.loaders=1")[0].split(":")[:2], ["spacing", " 0.99 m"])
        for spacing in ["0.125", "0.126", "1", "null"]:
            self.assertEqual(self.notes(scene, "spacing=" + spacing), [])
        wide = "objects.a.shape={sphere: {radius: 300}}"
        coarse = self.notes(scene, "spacing=1000", "objects=null",
                            "view={camera: {eye: [1, 2, 3], target: [0, 0, 0]}, images: 30, effects: []}", "time_step=0.1")
        self.assertEqual(coarse, ["spacing: 1000 m: posts will be 1 m apart, and this store has none that are farther; give 1"])
        # Without a store there is nothing to divide.
        self.assertEqual(self.json("explain", scene, "--set", "spacing=0.1")["notes"], [])

    def test_a_path_off_the_terrain_is_told_and_a_drive_stops_there(self):
        self.synth()
        scene = self.scene(BARE)
        away = "objects.a.path={points: [[240, 20], [400, 20]], speed: 10}"
        told = ["objects.a.path: is off the terrain after 1.7 s, at 257.000, 20.000 m: the drive will stop there; keep within "
                "0 to 256, 0 to 256 m, end before, or set outside: skip"]
        self.assertEqual(self.notes(scene, away), told)
        self.assertEqual(self.notes(scene, away, "end_time=1.65"), [])
        skipped = self.notes(scene, away, "outside=skip")
        self.assertEqual(len(skipped), 1)
        self.assertIn(": nothing is pressed there; keep within 0 to 256, 0 to 256 m", skipped[0])
        self.assertNotIn("stop", skipped[0])
        for faster, slower in (("a", "b"), ("b", "a")):
            ways = [f"objects.{name}.path={{points: [[240, 20], [400, 20]], speed: {speed}}}" for name, speed in ((faster, 20), (slower, 10))]
            both = self.notes(scene, *ways)
            self.assertEqual(len(both), 1)
            self.assertTrue(both[0].startswith(f"objects.{faster}.path: is off the terrain after 0.85 s, at 257.000, 20.000 m, and 1 other "
                                               "later: "))
        round_about = "objects.a.path={points: [[1, 1], [20, 1], [20, -0.9]], speed: 20, loop: true}"
        told_of = "objects.a.path: is off the terrain after "
        self.assertTrue(self.notes(scene, round_about)[0].startswith(told_of + "1.05 s, at 19.900, -0.890 m"))
        (self.folder / "poses.csv").write_text("1,10,10\n2,-10,10\n")
        self.assertTrue(self.notes(scene, "objects.a.path={file: poses.csv}")[0].startswith(told_of + "1.55 s"))
        self.assertEqual(self.json("explain", scene, "--set", away)["notes"], [])  # over no store
        # It is so.
        result = self.furrow("drive", scene, "--store", "world.furrow", "-o", "out", "--set", away)
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("furrow: note: " + told[0], result.stderr)
        self.assertIn("a: no ground under it at 257.000, 20.000 m after 1.700 s: it is off the terrain; ", result.stderr)

    def test_a_store_that_is_not_there_is_named(self):
        scene = self.scene(BARE + "store: demo.furrow\n")
        plan = self.json("explain", scene)
        self.assertEqual((plan["store"], plan["assumed"], plan["missing"]), (None, True, str(self.folder / "demo.furrow")))
        head = self.ok("explain", scene).splitlines()
        self.assertEqual(head[0], f"{scene} over no store: {self.folder / 'demo.furrow'} is not there")
        self.assertTrue(head[1].startswith("  assumed: "))
        none = self.scene(BARE, "none.yaml")
        self.assertIsNone(self.json("explain", none)["missing"])
        self.assertEqual(self.ok("explain", none).splitlines()[0], f"{none} over no store")
        self.synth(name="demo.furrow")
        self.assertIsNone(self.json("explain", scene)["missing"])

    def test_a_drive_tells_the_same_on_stderr(self):
        self.synth()
        scene = self.scene(BARE + "gravity: 1.62\n")
        result = self.furrow("drive", scene, "--store", "world.furrow", "-o", "out", "--steps", "1", "--json")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 0, result.stderr)
        notes = [line for line in result.stderr.splitlines() if line.startswith("furrow: note: ")]
        self.assertEqual(notes, ["furrow: note: " + note for note in
                                 self.json("explain", scene, "--store", "world.furrow")["notes"]])
        self.assertEqual(result.stdout.lstrip()[0], "{")

    def test_nothing_is_touched(self):
        store = self.synth()
        scene = self.scene(BARE)
        before = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in self.folder.iterdir() if path.is_file()}
        self.ok("explain", scene, "--store", store)
        self.ok("explain", scene, "--store", store, "--json")
        after = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in self.folder.iterdir() if path.is_file()}
        self.assertEqual(before, after)

    def test_a_store_that_is_being_written_is_explained(self):
        store = self.synth()
        scene = self.scene(BARE)
        writer = sqlite3.connect(store, isolation_level=None)
        self.addCleanup(writer.close)
        writer.execute("BEGIN IMMEDIATE")
        self.assertFalse(self.json("explain", scene, "--store", store)["assumed"])
        writer.execute("ROLLBACK")

    def test_a_store_that_is_being_driven_is_explained(self):
        store = self.synth(posts="513x513")
        scene = self.scene(BARE.replace("end_time: 3", "end_time: 100000").replace("speed: 10}", "speed: 10, loop: true}"))
        drive = subprocess.Popen([FURROW, "drive", scene, "--store", store, "-o", "out"], cwd=self.folder,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            self.until_committed(drive, commits=2)
            self.assertIsNone(drive.poll())
            plan = self.json("explain", scene, "--store", store)
            self.assertEqual((plan["assumed"], plan["deformed"]), (False, True))
        finally:
            drive.terminate()
            drive.communicate(timeout=120)

    def test_what_is_wrong_is_told(self):
        self.synth()
        scene = self.scene(BARE)
        self.refused(3, "explain", "missing.yaml")
        self.refused(3, "explain", self.scene(BARE + "sloth: 1\n", "bad.yaml"))
        self.refused(3, "explain", scene, "--set", "cache.slots=3")
        self.refused(3, "explain", scene, "--set", "cache.sloth=3")
        self.refused(3, "explain", scene, "--store", "missing.furrow")
        self.refused(3, "explain", scene, "--store", scene)
        self.refused(3, "explain", scene, "--set", "coordinates=EPSG:32632")
        self.refused(2, "explain")
        self.refused(2, "explain", scene, scene)
        self.refused(2, "explain", scene, "--set", "cache.slots")
        self.refused(2, "explain", scene, "--steps", "3")

    def test_what_no_drive_can_begin_with_is_refused_as_it_would_be(self):
        self.synth(posts="257x257")
        loose = "soil: {name: dry_sand}\nredistribute: {model: slippage, undisturbed: slides}\n"
        (self.folder / "soils.png").write_text("no picture")
        mapped = "soil: {map: soils.png, classes: {1: clayey_38}, default: clayey_38}\nredistribute: {model: scm}\n"
        for more, setting in [(mapped, "end_time=2"), ("", "spacing=0.00001"), ("", "objects.c.shape={sphere: {radius: 400}}"),
                              (loose, "spacing=0.0625")]:
            with self.subTest(setting=setting):
                arguments = [self.scene(BARE + more), "--store", "world.furrow", "--set", setting]
                told = self.refused(3, "explain", *arguments)
                driven = self.furrow("drive", *arguments, "-o", "out")
                if driven.returncode == 3:
                    self.assertIn(told, driven.stderr)

    def test_help_says_what_it_is(self):
        text = self.ok("explain", "--help")
        for word in ["--store", "--set", "--all", "--json", "<-", "no GL"]:
            self.assertIn(word, text)


class ExplainAndDrive(FurrowTest):
    """What was predicted is what happened: amounts by unit, times the units' counts."""

    SCENES = {
        "bare": BARE,
        "everything but soil": BARE + "spacing: 0.5\nredistribute: {model: box, repetitions: 2}\nattributes: [dirt]\n" +
        "view: " + VIEW.replace("size", "effects: [texture, detail, fog, sky, geomorph, skirts], size") + "\n",
        "fixed regions": BARE + "spacing: 0.5\nredistribute: {model: box, regions: fixed, repetitions: 3}\nattributes: [dirt]\n",
        "scm": BARE.replace("sink: 0.2", "load: 900") + "soil: {name: dry_sand}\nredistribute: {model: scm}\noutput: {forces: 5}\n",
        "sheet": BARE + "redistribute: {model: sheet, yield: 0.1}\nattributes: [dirt]\n",
        "sheet on the GPU": BARE + "compute: gpu\nredistribute: {model: sheet, yield: 0.1}\nattributes: [dirt]\n",
        "slippage": BARE + "soil: {name: dry_sand}\nredistribute: {model: slippage, iterations: 2}\nattributes: [dirt]\n",
    }

    def check(self, plan, run):
        counts = run["counts"]
        units = counts["units"]

        def count_of(row):
            unit = row.get("unit", "once")
            if unit == "once":
                return 1
            if unit in ("changed", "left", "inherited", "kept"):
                return units[unit][row["name"].split()[1]]
            count = units[unit]
            if isinstance(count, dict):
                return count[row["object"]] if row.get("object") else sum(count.values())
            return count

        self.assertEqual({row["name"] for row in plan["programs"]}, {program["name"] for program in counts["programs"]})
        self.assertEqual(len(plan["programs"]), run["programs"])
        self.assertEqual(counts["unplanned"], 0)
        passes = {}
        for row in plan["passes"]:
            passes[row["stage"]] = passes.get(row["stage"], 0) + row["amount"] * count_of(row)
        self.assertEqual({stage: count for stage, count in passes.items() if count > 0}, counts["passes"])
        self.assertEqual(sum(row["amount"] for row in plan["threads"]), counts["threads"])
        self.assertEqual(sum(row["amount"] * count_of(row) for row in plan["textures"]), counts["textures"])
        self.assertEqual(sum(row["bytes"] * count_of(row) for row in plan["textures"] + plan["buffers"]), counts["bytes"])
        tables = {}
        for row in plan["tables"]:
            tables[row["name"]] = tables.get(row["name"], 0) + row["amount"] * count_of(row)
        ran = {f"{verb} {table}": count for table, verbs in counts["statements"].items() for verb, count in verbs.items()}
        self.assertEqual({name: count for name, count in tables.items() if count > 0},
                         {name: count for name, count in ran.items() if count > 0})
        self.assertEqual(plan["memory"]["most"], run["memory"]["budget"])

    @long
    def test_a_drive_makes_and_runs_what_was_told(self):
        for name, text in self.SCENES.items():
            with self.subTest(scene=name):
                self.synth()
                scene = self.scene(text)
                plan = self.json("explain", scene, "--store", "world.furrow")
                self.check(plan, self.drive(scene, "--store", "world.furrow"))
                # Once more, over what the first left.
                again = self.json("explain", scene, "--store", "world.furrow")
                self.assertTrue(again["deformed"])
                self.check(again, self.drive(scene, "--store", "world.furrow"))


if __name__ == "__main__":
    main()
