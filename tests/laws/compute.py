"""The CPU and the GPU compute the ground of a kinematic model to the same bits: rows of the ruts, objects.csv and the volume are equal, in any tiles, on
steep ground with holes, with a map of soils, with bodies of every shape, also where one goes on with what the other began."""
import json
import pathlib
import sqlite3
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FurrowTest, main, write_png16

TABLES = ("offset", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")
HEAD = "scene: 1\ntime_step: 0.05\nend_time: %g\nspacing: %g\noutside: skip\noutput: {forces: 20}\n"
SOILS = {"none": "", "box": "", "sheet": "", "sumner": "soil: {name: sand}\n", "slippage": "soil: {name: dry_sand}\n"}
WHEELS = """objects:
  - {name: wheel, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.15, path: {points: [[20, 20], [34, 26], [22, 33]], speed: 8}}
  - {name: lugs, shape: {wheel: {radius: 0.6, width: 0.5, grousers: 9}}, sink: 0.2, path: {points: [[34, 20], [20, 31]], speed: 9}}
  - {name: ball, shape: {sphere: {radius: 1.1}}, sink: 0.5, path: {points: [[24, 20], [30, 32], [20, 26]], speed: 7}}
  - {name: box, shape: {box: {size: [1.5, 1, 1]}}, sink: 0.2, path: {points: [[40, 20], [40, 28], [30, 30]], speed: 4}}
"""
# Poses with attitude: a blade that leans, a wheel with camber that slides aside, a mesh that turns on the spot, rods, an egg that hops.
TURNED = """objects:
  - {name: blade, shape: {box: {size: [0.3, 2.5, 0.8]}}, path: {file: blade.csv}}
  - {name: leaning, shape: {wheel: {radius: 0.6, width: 0.3}}, path: {file: leaning.csv}}
  - {name: foot, shape: {mesh: {file: foot.obj}}, path: {file: foot.csv}}
  - {name: log, shape: {cylinder: {radius: 0.5, length: 2}}, path: {file: blade.csv, offset: [0, 9]}}
  - {name: pill, shape: {capsule: {radius: 0.4, length: 1.5}}, path: {file: leaning.csv, offset: [0, 9]}}
  - {name: egg, shape: {ellipsoid: {radii: [1, 0.6, 0.5]}}, path: {file: hops.csv}}
  - {name: track, shape: {box: {size: [2, 0.5, 0.6], belt: true}}, path: {file: hops.csv, offset: [0, 7]}}
"""
# One pushes soil against another that stands: posts that a body holds have limits of their own.
BESIDE = """objects:
  - {name: stands, shape: {box: {size: [3, 3, 4]}}, sink: 0.1, path: {points: [[30, 30]], speed: 1}}
  - {name: passes, shape: {sphere: {radius: 1}}, sink: 0.7, path: {points: [[25, 27.2], [35, 27.2]], speed: 8}}
"""
# Bodies at rest keep soil out of themselves: a plate on the ground, one above it that leans, a wheel with grousers, a ball, a mesh, a buried box. What moves
# beside them pushes soil against them; two go side by side, and the one stops where soil still slides.
PARKED = """objects:
  - {name: plate, shape: {box: {size: [2, 2, 0.15]}}, path: {file: plate.csv}}
  - {name: leans, shape: {box: {size: [2, 1.5, 0.1]}}, path: {file: leans.csv}}
  - {name: lugs, shape: {wheel: {radius: 0.6, width: 0.5, grousers: 9}}, sink: 0.1, path: {points: [[33.1, 26.4]], speed: 1}}
  - {name: parked, shape: {sphere: {radius: 0.8}}, sink: 0.2, path: {points: [[36.2, 30.2]], speed: 1}}
  - {name: foot, shape: {mesh: {file: foot.obj}}, path: {file: stands.csv}}
  - {name: buried, shape: {box: {size: [1, 1, 0.3]}}, sink: 0.29, path: {points: [[30.5, 34.6]], speed: 1}}
  - {name: blade, shape: {box: {size: [0.3, 2.5, 1.6]}}, sink: 0.25, path: {points: [[24, 25], [28.9, 26.2], [31.4, 30.4], [37.5, 33.1]], speed: 6}}
  - {name: ball, shape: {sphere: {radius: 0.9}}, sink: 0.4, path: {points: [[24, 27.5], [29.5, 28.5], [34, 31.2]], speed: 6}}
"""
# So large that the GPU cuts it into windows. Mesa ends the loops that lay the soil of a ball of 30 m.
LARGE = """objects:
  - {name: ball, shape: {sphere: {radius: 22}}, sink: 3, path: {points: [[60, 60], [75, 68]], speed: 15}}
  - {name: slab, shape: {box: {size: [40, 45, 2]}}, sink: 0.5, path: {points: [[50, 70], [56, 70]], speed: 5}}
"""
# The window of the ball is in parts. A slab and a wheel stand where it lays soil.
LARGE_PARKED = """objects:
  - {name: slab, shape: {box: {size: [5, 8, 0.6]}}, sink: 0.05, path: {points: [[88, 64]], speed: 1}}
  - {name: wheel, shape: {wheel: {radius: 2, width: 1.5, grousers: 11}}, sink: 0.2, path: {points: [[74, 80]], speed: 1}}
  - {name: ball, shape: {sphere: {radius: 22}}, sink: 3, path: {points: [[60, 60], [75, 68]], speed: 15}}
"""
MAP = "soil: {map: classes.png, classes: {1: %s, 2: %s}, default: %s}\n"
CUBE = "".join(f"v {x} {y} {z}\n" for x in (-0.7, 0.7) for y in (-0.5, 0.6) for z in (-0.6, 0.4)) + "".join(
    f"f {a} {b} {c}\n" for a, b, c in ((1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2), (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4)))


def poses(rows):
    return "t,x,y,z,yaw,pitch,roll\n" + "".join(",".join(f"{value:g}" for value in row) + "\n" for row in rows)


class Compute(FurrowTest):
    def setUp(self):
        super().setUp()
        write_png16(self.folder / "classes.png", 129, 129, lambda x, y: (x // 5 + y // 7) % 3)
        (self.folder / "foot.obj").write_text(CUBE)
        z = 0.3  # the ground of these scenes is level
        (self.folder / "blade.csv").write_text(poses((0.1 * i, 14 + 0.5 * i, 40 + 0.2 * i, z + 0.1 * (i % 3), 5 * i, 9 - i, 3 * i - 20) for i in range(20)))
        (self.folder / "leaning.csv").write_text(poses((0.1 * i, 40 + 0.3 * i, 14 + 0.35 * i, z, 10 + 8 * i, 0, 12 - 2 * i) for i in range(20)))
        (self.folder / "foot.csv").write_text(poses((0.1 * i, 30, 50, z + 0.15 * (i % 2), 9 * i, 4 * i, 2 * i) for i in range(20)))
        (self.folder / "plate.csv").write_text(poses([(0, 29, 29, z + 0.07, 12, 0, 0), (9, 29, 29, z + 0.07, 12, 0, 0)]))
        (self.folder / "leans.csv").write_text(poses([(0, 32, 31.5, z + 0.25, 40, 9, -6), (9, 32, 31.5, z + 0.25, 40, 9, -6)]))
        (self.folder / "stands.csv").write_text(poses([(0, 34.4, 33.4, z + 0.5, 25, 6, -3), (9, 34.4, 33.4, z + 0.5, 25, 6, -3)]))
        (self.folder / "hops.csv").write_text(poses((0.1 * i, 50 + 0.4 * i, 30, z + (6 if i % 5 == 4 else 0.05), 20, 30 - 6 * i, 10) for i in range(20)))

    def ground(self, tile, kind="dunes", relief=3):
        """A store with tiles of so many cells."""
        name = f"{kind}-{relief}-{tile}.furrow"
        if not (self.folder / name).exists():
            self.ok("synth", "-o", "ground.tif", "--posts", "257x257", "--spacing", 0.5, "--kind", kind, "--relief", relief, "--overwrite")
            self.ok("import", "ground.tif", "-o", name, "--tile", tile)
        return name

    def rows(self, store):
        db = sqlite3.connect(store)
        rows = {table: db.execute(f'SELECT key, low, high, codec, hash, blob FROM "{table}" ORDER BY key').fetchall() for table in TABLES}
        db.close()
        return rows

    def left(self, text, compute, base, *more, overlay=None):
        """What a drive leaves in an overlay, and its run.json."""
        self.overlays = getattr(self, "overlays", 0) + 1
        overlay = overlay or f"{compute}-{self.overlays}.furrow"
        self.scene(text)
        run = self.drive("scene.yaml", "--store", base, "--overlay", overlay, "--set", f"compute={compute}", *more)
        return self.rows(self.folder / overlay), (self.folder / "out/objects.csv").read_bytes(), run

    def same(self, what, gpu, cpu):
        self.assertEqual((gpu[2]["computed"]["by"], cpu[2]["computed"]["by"]), ("gpu", "cpu"), what)
        self.assertEqual(sum(cpu[2]["passes"].values()), 0, what)
        self.assertGreater(cpu[2]["computed"]["contacts"], 10, what)
        for table in TABLES:
            self.assertEqual([row[0] for row in gpu[0][table]], [row[0] for row in cpu[0][table]], f"{what}: {table}")
            other = [tile for tile, row in enumerate(gpu[0][table]) if row != cpu[0][table][tile]]
            self.assertEqual(other, [], f"{what}: {table}: these rows differ")
        self.assertTrue(gpu[1] == cpu[1], f"{what}: objects.csv differs")
        self.assertEqual(gpu[2]["volume"], cpu[2]["volume"], what)
        self.assertGreater(gpu[2]["volume"]["quanta"]["removed"], 0, what)
        self.assertEqual(gpu[2]["refused_posts"], cpu[2]["refused_posts"], what)

    def compare(self, what, text, base):
        gpu, cpu = self.left(text, "gpu", base), self.left(text, "cpu", base)
        self.same(what, gpu, cpu)
        for key, table in (("heals", "healed"), ("vegetation", "risen")):
            self.assertEqual(len(gpu[0][table]) > 0, key in text, f"{what}: {table}")

    def scenes(self):
        yield "none", HEAD % (4, 0.125) + "redistribute: {model: none}\nattributes: [disturbance]\n" + WHEELS, 64, "dunes", 3
        yield "box", HEAD % (4, 0.125) + "redistribute: {model: box, radius: 3, repetitions: 4}\nattributes: [disturbance]\n" + WHEELS, 32, "dunes", 3
        yield "sumner", HEAD % (3, 0.125) + "redistribute: {model: sumner, iterations: 3, interval: 0.05}\nattributes: [disturbance]\n" + SOILS["sumner"] + WHEELS, 64, "dunes", 3
        yield "slippage", HEAD % (3, 0.125) + "redistribute: {model: slippage, iterations: 2, interval: 0.05}\nattributes: [disturbance]\n" + SOILS["slippage"] + WHEELS, 128, "dunes", 3
        yield "cohesive, steep", HEAD % (2, 0.25) + "redistribute: {model: slippage, interval: 0.05, depth: 0.5, tolerance: 0.002}\nsoil: {name: clayey_38}\n" + WHEELS, 256, "ridged", 40
        yield "slides by itself", HEAD % (2, 0.25) + "redistribute: {model: slippage, interval: 0.1, undisturbed: slides}\nsoil: {cohesion: 0, friction_angle: 20, unit_weight: 16000}\n" + WHEELS, 32, "dunes", 6
        yield "erodes by itself", HEAD % (0.8, 0.25) + "redistribute: {model: sumner, iterations: 4, interval: 0.1, undisturbed: slides}\nsoil: {name: mud, theta_in: 20, theta_out: 30, theta_stop: 32}\n" + WHEELS, 64, "ridged", 30
        yield "soils, sumner", HEAD % (3, 0.125) + "redistribute: {model: sumner, interval: 0.05}\n" + MAP % ("sand", "mud", "snow") + WHEELS, 64, "dunes", 3
        yield "soils, slippage", HEAD % (3, 0.125) + "redistribute: {model: slippage, interval: 0.05}\n" + MAP % ("dry_sand", "lete_sand", "clayey_38") + WHEELS, 64, "dunes", 3
        yield "beside", HEAD % (2, 0.125) + "redistribute: {model: sumner, iterations: 2, interval: 0.05}\nsoil: {name: sand, theta_in: 8}\n" + BESIDE, 64, "dunes", 3
        for rest in ("slippage, iterations: 3, interval: 0.05}\nsoil: {name: dry_sand}", "slippage, interval: 0.1, depth: 0.3, tolerance: 0.002}\nsoil: {name: clayey_38}",
                     "sumner, iterations: 3, interval: 0.05}\nsoil: {name: sand, compression: 0}", "sumner, interval: 0.1}\nsoil: {name: mud, compression: 0.1, theta_in: 12}",
                     "slippage, interval: 0.1, undisturbed: slides}\nsoil: {cohesion: 0, friction_angle: 20, unit_weight: 16000}",
                     "sumner, iterations: 2, interval: 0.1, undisturbed: slides}\nsoil: {name: sand}"):
            yield f"parked, {rest}", HEAD % (2.5, 0.125) + f"redistribute: {{model: {rest}\nattributes: [disturbance]\n" + PARKED, 32, "plain", 0
            yield f"parked on dunes, {rest}", HEAD % (2, 0.125) + f"redistribute: {{model: {rest}\n" + PARKED, 64, "dunes", 2
            if "tolerance" in rest or "mud" in rest:
                yield f"parked, large, {rest}", HEAD % (0.3, 0.125) + f"redistribute: {{model: {rest}\n" + LARGE_PARKED, 64, "dunes", 2
        yield "parked, soils, slippage", HEAD % (2, 0.125) + "redistribute: {model: slippage, interval: 0.05}\n" + MAP % ("dry_sand", "lete_sand", "clayey_38") + PARKED, 64, "plain", 0
        yield "parked, soils, sumner", HEAD % (2, 0.125) + "redistribute: {model: sumner, interval: 0.05}\n" + MAP % ("sand", "mud", "snow") + PARKED, 64, "plain", 0
        for model in ("none", "box", "sumner", "slippage"):
            yield f"turned, {model}", HEAD % (2.5, 0.125) + f"redistribute: {{model: {model}}}\nattributes: [disturbance]\n" + SOILS[model] + TURNED, 32, "plain", 0
        sheet = "redistribute: {model: sheet, tension: %s, yield: %g, rut: 0.6}\n"
        yield "sheet", HEAD % (1.5, 0.125) + sheet % ("10000", 0.1) + "attributes: [disturbance]\n" + WHEELS, 64, "dunes", 3
        yield "sheet, turned", HEAD % (1.2, 0.125) + sheet % ("3000", 8) + "attributes: {disturbance: {heals: 300}, vegetation: {rises: 100}}\n" + TURNED, 32, "plain", 0
        yield "sheet, stiff", HEAD % (2, 0.25) + sheet % ("10", 0.02) + BESIDE, 256, "ridged", 40
        yield "sheet, long", HEAD % (0.3, 0.125) + sheet % ("200000", 1) + BESIDE, 32, "dunes", 3
        yield "large, sheet", HEAD % (0.3, 0.25) + sheet % ("100000", 0.1) + LARGE, 64, "dunes", 3
        yield "large, box", HEAD % (0.3, 0.125) + "redistribute: {model: box, radius: 2, repetitions: 3}\nattributes: [disturbance]\n" + LARGE, 32, "dunes", 3
        yield "large, slippage", HEAD % (0.2, 0.125) + "redistribute: {model: slippage}\n" + SOILS["slippage"] + LARGE, 64, "dunes", 3
        yield "large, sumner", HEAD % (0.2, 0.125) + "redistribute: {model: sumner, iterations: 2}\n" + SOILS["sumner"] + LARGE, 64, "dunes", 3

    def test_every_model(self):
        for what, text, tile, kind, relief in self.scenes():
            with self.subTest(what):
                self.compare(what, text, self.ground(tile, kind, relief))


    def test_parked_bodies_do_not_show_tiles_steps_slots_or_an_end(self):
        for rest in ("slippage, iterations: 2, interval: 0.05}\nsoil: {name: dry_sand}", "sumner, iterations: 3, interval: 0.05}\nsoil: {name: sand, compression: 0}"):
            text = HEAD % (2, 0.125) + f"redistribute: {{model: {rest}\n" + PARKED
            first = None
            for how, tile, step in ("gpu", 64, 0.05), ("cpu", 16, 0.1), ("gpu", 32, 0.02), ("cpu", 64, 0.02):
                rows, _, run = self.left(text.replace("time_step: 0.05", f"time_step: {step}"), how, self.ground(tile, "plain", 0))
                self.ok("export", f"{how}-{self.overlays}.furrow", "-o", f"posts-{self.overlays}.tif", "--layer", "fixed_point")
                posts = (self.folder / f"posts-{self.overlays}.tif").read_bytes()
                first = first or (posts, run["volume"])
                self.assertTrue(posts == first[0] and run["volume"] == first[1], f"{rest}: {how}, tiles of {tile}, steps of {step} s")
            base = self.ground(32, "plain", 0)
            few = text + "cache: {slots: 12, loaders: 1, prefetch: 0}\n"
            whole = self.left(text, "gpu", base)
            self.left(few, "gpu", base, "--steps", 17, overlay=f"parked-{rest[:6]}.furrow")
            rows, csv, run = self.left(few, "cpu", base, "--resume", overlay=f"parked-{rest[:6]}.furrow")
            self.assertTrue(rows == whole[0] and csv == whole[1], rest)

    def test_ground_that_another_soil_left(self):
        """Walls that only a stiff soil holds: what slides next to them depends on which blocks are active."""
        stiff = HEAD % (2, 0.25) + "redistribute: {model: slippage}\nsoil: {name: clayey_38}\n" + WHEELS
        for what, text in (("slippage", HEAD % (2, 0.25) + "redistribute: {model: slippage, interval: 0.05}\n" + SOILS["slippage"] + WHEELS),
                           ("sumner", HEAD % (2, 0.25) + "redistribute: {model: sumner, interval: 0.05}\n" + SOILS["sumner"] + WHEELS)):
            self.scene(stiff)
            base = self.ground(64, "ridged", 40)
            self.drive("scene.yaml", "--store", base, "--overlay", f"{what}-stiff.furrow")
            self.compare(what, text.replace("[20, 20]", "[21, 20.5]"), f"{what}-stiff.furrow")

    def test_one_goes_on_with_what_the_other_began(self):
        for model in ("box, repetitions: 2", "slippage, interval: 0.05", "sheet, yield: 0.1, rut: 0.5"):
            base = self.ground(64)
            text = HEAD % (3, 0.125) + f"redistribute: {{model: {model}}}\n" + SOILS[model.split(",")[0]] + WHEELS
            whole = self.left(text, "gpu", base)
            for first, then in (("gpu", "cpu"), ("cpu", "gpu")):
                overlay = f"{model.split(',')[0]}-{first}.furrow"
                self.left(text, first, base, "--steps", 23, overlay=overlay)
                rows, csv, run = self.left(text, then, base, "--resume", overlay=overlay)
                self.assertEqual((run["resumed_from"], run["computed"]["by"]), (23, then))
                self.assertTrue(rows == whole[0] and csv == whole[1], f"{model}: {first}, then {then}")
                self.assertEqual(run["volume"], whole[2]["volume"])

    def test_few_slots(self):
        """Tiles leave their slots and come back."""
        for model in ("box", "slippage, interval: 0.1", "sheet, yield: 0.1, rut: 0.5"):
            text = HEAD % (4, 0.125) + f"cache: {{slots: {16 if 'sheet' in model else 12}, loaders: 1, prefetch: 0}}\nredistribute: {{model: {model}}}\n" + SOILS[model.split(",")[0]] + WHEELS
            self.compare(model, text, self.ground(32))

    def test_fixed_regions_leave_what_windows_leave(self):
        """Also with few slots, in small tiles, where a large body is left to windows, and where one way goes on with what the other began."""
        box = "{model: box, radius: 2, repetitions: %d}"
        slots = "cache: {slots: 12, loaders: 1, prefetch: 0}\n"
        for what, text, tile, ways in (("none", HEAD % (3, 0.125) + "redistribute: {model: none}\n" + WHEELS, 64, (True, False)),
                                        ("box", HEAD % (3, 0.125) + f"redistribute: {box % 3}\nattributes: [disturbance]\n" + WHEELS, 64, (True, False)),
                                        ("few slots", slots + HEAD % (3, 0.125) + f"redistribute: {box % 2}\n" + WHEELS, 32, (True, True)),  # the ball is on three tiles in a row
                                        ("turned", HEAD % (2, 0.125) + f"redistribute: {box % 1}\nattributes: [disturbance]\n" + TURNED, 64, (True, False)),
                                        ("large", HEAD % (0.3, 0.125) + f"redistribute: {box % 3}\n" + LARGE, 32, (False, True))):
            with self.subTest(what):
                base = self.ground(tile)
                windows, fixed = self.left(text, "gpu", base), self.left(text, "gpu", base, "--set", "redistribute.regions=fixed")
                self.assertTrue(windows[0] == fixed[0] and windows[1] == fixed[1], what)
                self.assertEqual(windows[2]["volume"], fixed[2]["volume"])
                units = fixed[2]["counts"]["units"]
                self.assertEqual((sum(units["region"].values()) > 0, sum(units["window"].values()) > 0), ways, units)
                self.assertEqual(sum(windows[2]["counts"]["units"]["region"].values()), 0)
        text = HEAD % (3, 0.125) + f"redistribute: {box % 2}\n" + WHEELS
        base = self.ground(64)
        whole = self.left(text, "gpu", base)
        self.left(text, "gpu", base, "--steps", 23, overlay="mixed.furrow")
        rows, csv, run = self.left(text, "gpu", base, "--resume", "--set", "redistribute.regions=fixed", overlay="mixed.furrow")
        self.assertEqual(run["resumed_from"], 23)
        self.assertTrue(rows == whole[0] and csv == whole[1])

    def test_it_is_told(self):
        base = self.ground(64)
        self.scene(HEAD % (1, 0.125) + "redistribute: {model: box}\n" + WHEELS)
        for setting, told, shown in (([], "gpu", "computed by the GPU, or by the CPU where there is no GL\n"), (["--set", "compute=gpu"], "gpu", "computed by the GPU\n"),
                                     (["--set", "compute=cpu"], "cpu", "computed by the CPU\n")):
            self.assertEqual(self.json("explain", "scene.yaml", "--store", base, *setting)["compute"], told)
            self.assertIn(shown, self.ok("explain", "scene.yaml", "--store", base, *setting))
        passes = self.json("explain", "scene.yaml", "--store", base, "--set", "compute=cpu")["passes"]
        self.assertEqual(passes, [])


if __name__ == "__main__":
    main()
