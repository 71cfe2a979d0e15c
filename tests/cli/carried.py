"""Soil aboard bodies by the command: pictures show it; with redistribute.thrown it flies off a body that is high up, lands where a grain would, comes down on other bodies, and no unit is lost."""
import math
import pathlib
import struct
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main, write_png16

SPACING = 0.0625
HEAD = f"""scene: 1
time_step: 0.05
end_time: 6
spacing: {SPACING}
soil: {{name: dry_sand}}
redistribute: {{model: scm, thrown: on}}
objects:
- {{name: plate, shape: {{box: {{size: [1, 1, 0.1]}}}}, carry: true, path: {{file: plate.csv}}}}
"""
DIG = "0,6,8,19.9,0,0,0\n1,7,8,19.9,0,0,0\n2,7.1,8,{top},0,0,0\n"


def grey(path):
    """The rows of an 8 or 16-bit grey PNG that Furrow wrote, as lists of numbers."""
    data = path.read_bytes()
    width, height, bits = struct.unpack(">IIB", data[16:25])
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    raw, wide, rows, before = zlib.decompress(packed), width * bits // 8, [], None
    step = bits // 8
    for y in range(height):
        how, row = raw[y * (wide + 1)], bytearray(raw[y * (wide + 1) + 1:(y + 1) * (wide + 1)])
        before = before or bytearray(wide)
        for i in range(wide if how else 0):
            left, up, corner = row[i - step] if i >= step else 0, before[i], before[i - step] if i >= step else 0
            paeth = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[how]) & 255
        rows.append(list(row) if bits == 8 else list(struct.unpack(f">{width}H", bytes(row))))
        before = row
    return rows


class Carried(FurrowTest):
    def driven(self, *more, scene=HEAD, way="", top=21, fresh=True, tile=64):
        """Drives over fresh level ground at 20 m. Gives run.json."""
        if fresh:
            write_png16(self.folder / "flat.png", 65, 65, lambda x, y: 32768)
            self.ok("import", "flat.png", "--height-range", "0,39.999389648", "--spacing", 0.5, "-o", "world.furrow", "--tile", tile, "--overwrite", "--force")
            (self.folder / "plate.csv").write_text("t,x,y,z,yaw,pitch,roll\n" + DIG.format(top=top) + way)
        run = self.drive(self.scene(scene), "--store", "world.furrow", *more)
        check = self.json("verify", "world.furrow")
        self.assertTrue(check["ok"])
        self.assertEqual(check["offset_sum"].get("-3", 0) + check["compacted"] + check["carried"] + check["in_flight"], 0)
        quanta = run["volume"]["quanta"]
        self.assertEqual(quanta["net"] + quanta["compacted"] + quanta.get("carried", 0) + quanta.get("in_flight", 0), 0)
        if "thrown" in run:
            units = run["thrown"]["quanta"]
            self.assertEqual(units["thrown"], units["landed"] + units["in_flight"] + units["lost"])
        return run

    def raised(self, x0, x1, y0, y1):
        """By column from x0 to x1, m: its x, and the sum of what its posts stand above the level ground."""
        xs, ys = ([low + i * SPACING for i in range(round((high - low) / SPACING) + 1)] for low, high in ((x0, x1), (y0, y1)))
        points = self.json("query", "world.furrow", stdin="".join(f"{x} {y}\n" for x in xs for y in ys))["points"]
        return [(x, sum(max(point["offset"], 0) for point in points[i * len(ys):(i + 1) * len(ys)])) for i, x in enumerate(xs)]

    def test_an_emptied_plate_lands_what_it_carried(self):
        full = self.driven("--set", "end_time=3")
        aboard = full["volume"]["quanta"]["carried"]
        self.assertGreater(aboard, 0)
        self.assertEqual(full["thrown"]["grains"], 0)
        run = self.driven(way="3,7.1,8,21,0,0,0\n3.5,7.1,8,21,0,60,0\n")
        units = run["thrown"]["quanta"]
        self.assertEqual((run["volume"]["quanta"]["carried"], units["in_flight"], units["lost"]), (0, 0, 0))
        self.assertGreaterEqual(units["landed"] - full["thrown"]["quanta"]["landed"], aboard)  # some of it lands on the plate first
        self.assertEqual(run["volume"]["quanta"]["net"] - full["volume"]["quanta"]["net"], aboard)

    def test_steps_tiles_and_resume_change_no_bit(self):
        way = "3,7.1,8,21,0,0,0\n3.5,7.4,8.1,21,0.3,60,0\n"
        once = self.driven(way=way)
        for more, tile in ((["--set", "time_step=0.03"], 64), (["--set", "time_step=0.4"], 64), ([], 16)):
            run = self.driven(*more, way=way, tile=tile)
            self.assertEqual((run["thrown"], run["volume"]), (once["thrown"], once["volume"]), more)
        flown = 0
        for step in (61, 66, 68):
            flown += self.driven("--steps", step, way=way)["thrown"]["grains"]
            run = self.driven("--resume", fresh=False)
            self.assertEqual((run["resumed_from"], run["thrown"], run["volume"]), (step, once["thrown"], once["volume"]))
        self.assertGreater(flown, 0)

    def test_soil_falls_with_the_velocity_of_its_body(self):
        """A plate at 2 m/s whose lower edge is about 2.8 m above the ground lets its soil go: it lands 2 m/s times the time of its fall ahead of where it lands without `thrown`."""
        middle = {}
        for thrown in ("on", "off"):
            self.driven("--set", f"redistribute.thrown={thrown}", "--set", "end_time=8", top=23, way="3,7.1,8,23,0,0,0\n4,9.1,8,23,0,0,0\n7,15.1,8,23,0,0,60\n")
            columns = self.raised(8.5, 18, 6, 10)
            middle[thrown] = sum(x * sums for x, sums in columns) / sum(sums for _, sums in columns)
        ahead = middle["on"] - middle["off"]
        self.assertAlmostEqual(ahead, 2 * math.sqrt(2 * 2.8 / 9.81), delta=0.12)

    def test_what_falls_onto_a_body_is_aboard_of_it(self):
        """Two bodies that hand soil over: the plate empties over a tray."""
        scene = HEAD + "- {name: tray, shape: {box: {size: [3, 3, 0.1]}}, carry: true, path: {file: tray.csv}}\n"
        (self.folder / "tray.csv").write_text("t,x,y,z,yaw,pitch,roll\n0,7.4,14,20.4,0,0,0\n6,7.4,14,20.4,0,0,0\n")
        run = self.driven(scene=scene, way="3,7.1,14,21,0,0,0\n3.5,7.1,14,21.5,0,60,0\n")
        plate, tray = (run["objects"][name]["carried"] for name in ("plate", "tray"))
        self.assertEqual(plate["quanta"], 0)
        self.assertGreater(tray["quanta"], 0)
        self.assertEqual(run["thrown"]["quanta"]["lost"], 0)
        self.assertGreater(tray["weight"], 100)

    def test_pictures_show_soil_aboard(self):
        view = "cameras: [{name: c, kind: fixed, pose: {at: [7.1, 6, 22.2], target: [7.1, 8, 21]}, rate: 1, size: [120, 80], images: [colour, depth, class]}]\n"
        shown = {}
        for carry in ("true", "false"):
            self.driven("--set", "end_time=3", "--set", f"objects.plate.carry={carry}", "--set", "redistribute.thrown=off", scene=HEAD + view, way="3,7.1,8,21,0,0,0\n")
            folder = self.folder / "out/cameras/c"
            last = [sorted(folder.glob(f"{kind}/*.png"))[-1] for kind in ("colour", "depth", "class")]
            shown[carry] = (last[0].read_bytes(), grey(last[1]), grey(last[2]))
        self.assertNotEqual(shown["true"][0], shown["false"][0])
        soil = [(y, x) for y in range(80) for x in range(120) if shown["true"][2][y][x] == 0 and shown["false"][2][y][x] == 253]
        self.assertGreater(len(soil), 300)  # what was the plate is ground
        self.assertTrue(all(shown["true"][1][y][x] <= shown["false"][1][y][x] for y, x in soil))
        self.assertGreater(max(shown["false"][1][y][x] - shown["true"][1][y][x] for y, x in soil), 50)  # mm

    def test_a_body_that_carries_nothing_costs_no_draw(self):
        view = "view: {size: [120, 80], camera: {fixed: {eye: [7.1, 6, 22.2], target: [7.1, 8, 21]}}, images: 1}\n"
        drawn = []
        for dig in (True, False):
            text = HEAD if dig else HEAD.replace("plate.csv", "air.csv")
            (self.folder / "air.csv").write_text("t,x,y,z,yaw,pitch,roll\n0,7,8,21,0,0,0\n2,7.1,8,21,0,0,0\n")
            drawn.append(self.driven("--set", "end_time=1", scene=text + view)["counts"]["units"].get("objects", 0))
        self.assertGreater(drawn[0], 0)
        self.assertEqual(drawn[1], 0)


if __name__ == "__main__":
    main()
