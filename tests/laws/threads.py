"""How many threads llvmpipe draws with changes no bit: not of the ground, of what is told, or of pictures. The command chooses that number by
how large the passes are, and a host may choose any."""
import pathlib
import sqlite3
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FurrowTest, main

THREADS = (0, 1, 3)
SCENES = pathlib.Path(__file__).parents[2] / "tools" / "scenes"
TABLES = ("offset", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")
COMMIT = ("revision", "epoch")  # of the commit that wrote a row, which differs
# Wheels in all directions, some of them together on a tile: 0.125 m, a path sample for each wheel and step.
MANY = """scene: 1
time_step: 0.05
end_time: 1
spacing: 0.125
soil: {name: dry_sand}
redistribute: {model: %s}
objects:
""" + "".join(f"  - {{name: w{i}, shape: {{wheel: {{radius: 0.5, width: 0.3}}}}, sink: 0.1, path: {{points: "
              f"[[{30 + i % 5 * 12}, {30 + i // 5 * 12}], [{80 - i % 5 * 7}, {70 - i // 5 * 9}]], speed: 9}}}}\n" for i in range(20))


class Threads(FurrowTest):
    def left(self, arguments, threads):
        """All rows of the tables of ground, all files, and the figures that tell no time, of a drive. Not what depends on how fast it is: rows of
        volume.csv, one for each commit, and passes that make a tile ready when it is read."""
        name = f"t{threads}"
        run = self.json("drive", *arguments, "--store", "plain.furrow", "--overlay", f"{name}.furrow", "-o", name, env={"LP_NUM_THREADS": str(threads)})
        rows = []
        with sqlite3.connect(self.folder / f"{name}.furrow") as db:
            for table in TABLES:
                columns = [column[1] for column in db.execute(f'PRAGMA table_info("{table}")') if column[1] not in COMMIT]
                if columns:
                    quoted = ",".join(f'"{column}"' for column in columns)
                    rows += [(table, *row) for row in db.execute(f'SELECT {quoted} FROM "{table}" ORDER BY key')]
        db.close()
        files = {file.name: file.read_bytes() for file in sorted((self.folder / name).iterdir())
                 if file.suffix == ".csv" and file.name != "volume.csv" or file.name.startswith("frame-")}
        return rows, files, [run["volume"], run["steps"], {name: run["passes"][name] for name in ("displace", "redistribute", "render")}]

    def the_same(self, *arguments):
        one = self.left(arguments, THREADS[0])
        self.assertTrue(one[0], "nothing was deformed")
        for threads in THREADS[1:]:
            with self.subTest(threads=threads):
                other = self.left(arguments, threads)
                self.assertEqual(one[2], other[2])
                self.assertEqual(sorted(one[1]), sorted(other[1]))
                for name, data in one[1].items():
                    self.assertTrue(data == other[1][name], name)
                self.assertTrue(one[0] == other[0], "rows differ")
        return one

    def test_many_wheels(self):
        self.synth("plain.furrow", posts="129x129", kind="plain", relief=4)
        for model in ("box", "scm", "scm, faces: on"):
            with self.subTest(model):
                text = MANY % model
                self.the_same(self.scene(text.replace("sink: 0.1", "sink: 0.1, slip: -0.5, attitude: [30, 0, 0]") if "faces" in model else text))

    def test_a_vehicle_and_its_pictures(self):
        self.synth("plain.furrow", posts="129x129", kind="plain", relief=4)
        explained = self.furrow("explain", SCENES / "vehicles/offroad.yaml", "--store", "plain.furrow")
        if "this build has no MuJoCo" in explained.stderr:
            self.skipTest("this build has no MuJoCo")
        _, files, _ = self.the_same(SCENES / "vehicles/offroad.yaml", "--steps", 300, "--set", "view.size=[320, 180]", "--set", "view.images=100")
        self.assertEqual(len([name for name in files if name.startswith("frame-")]), 3)


if __name__ == "__main__":
    main()
