"""cache.memory: what is told is within it, what a drive takes is within what was told, and no row depends on it."""
import json
import math
import re

from furrow_test import FurrowTest, main


def spread(count, speed, across=230.0, radius=0.3):
    """Wheels on a square, each the way that its number says."""
    side = math.ceil(math.sqrt(count))
    rows = []
    for i in range(count):
        x, y, angle = 20 + i % side * across / side, 20 + i // side * across / side, 2.4 * i
        rows.append(f"  - {{name: w{i}, shape: {{wheel: {{radius: {radius}, width: 0.2}}}}, sink: 0.05, path: {{points: "
                    f"[[{x:.3f}, {y:.3f}], [{x + 9 * math.cos(angle):.3f}, {y + 9 * math.sin(angle):.3f}]], speed: {speed}}}}}\n")
    return "objects:\n" + "".join(rows)


class MemoryTest(FurrowTest):
    CASES = (
        # cells of a tile, spacing of the scene, wheels, speed, model, attributes
        (32, 0.5, 40, 4, "{model: box}", "[]"),
        (64, 0.25, 9, 30, "{model: none}", "[disturbance]"),
        (128, 1, 100, 8, "{model: box, radius: 2}", "[]"),
    )

    def scene_of(self, spacing, count, speed, model, attributes):
        return self.scene(f"scene: 1\ntime_step: 0.1\nend_time: 1.5\nspacing: {spacing}\nredistribute: {model}\nattributes: {attributes}\n" +
                          spread(count, speed))

    def plan(self, scene, memory):
        return json.loads(self.ok("explain", scene, "--store", "base.furrow", "--json", "--set", f"cache.memory={memory}"))["memory"]

    def test_what_is_told_and_taken_is_within_it_and_no_rut_depends_on_it(self):
        for cells, *case in self.CASES:
            with self.subTest(cells=cells, case=case):
                self.ok("synth", "-o", "dem.png", "--posts", "289x289", "--spacing", "1")
                self.ok("import", "dem.png", "-o", "base.furrow", "--tile", cells, "--spacing", "1", "--overwrite", "--force")
                scene = self.scene_of(*case)
                told = self.refused(3, "explain", scene, "--store", "base.furrow", "--set", "cache.memory=1000 MiB",
                                    "--set", "cache.slots=16")
                self.assertIn("remove one of the two", told)
                told = self.refused(3, "drive", scene, "--store", "base.furrow", "-o", "out", "--set", "cache.memory=0.01 MB")
                least = int(re.search(r"give at least (\d+) MB", told).group(1))
                self.refused(3, "explain", scene, "--store", "base.furrow", "--set", f"cache.memory={least - 1} MB")
                hashes, slots, fits = set(), [], []
                for memory in (least, 2 * least, 8 * least):
                    plan = self.plan(scene, f"{memory} MB")
                    self.assertEqual(plan["asked"], memory * 10**6)
                    self.assertLessEqual(plan["most"]["total_few"], plan["asked"])
                    (self.folder / "ruts.furrow").unlink(missing_ok=True)
                    run = json.loads(self.ok("drive", scene, "--store", "base.furrow", "--overlay", "ruts.furrow", "-o", "out", "--json",
                                             "--set", f"cache.memory={memory} MB"))
                    taken, budget = run["memory"], run["memory"]["budget"]
                    self.assertEqual(budget, plan["most"])
                    self.assertEqual(taken["tiles"], plan["tiles"])
                    self.assertEqual(run["cache"]["slots"], plan["tiles"]["slots"])
                    self.assertLessEqual(taken["host_bytes"], budget["loads"] + budget["queue_few"])
                    self.assertLessEqual(sum(taken["plane_bytes"].values()), budget["slots"])
                    slots.append(plan["tiles"]["slots"])
                    fits.append(plan["holds_all"])
                    hashes.add(self.ok("export", "ruts.furrow", "--layer", "offset", "-o", "ruts.tif") and
                               (self.folder / "ruts.tif").read_bytes())
                self.assertEqual(len(hashes), 1)
                self.assertEqual(slots, sorted(slots))
                self.assertTrue(slots[0] < slots[2] or fits[0])  # a small terrain may fit whole into the least

    def test_units_of_memory_are_those_of_their_names(self):
        self.ok("synth", "-o", "base.furrow", "--posts", "289x289", "--spacing", "1")
        scene = self.scene_of(0.5, 3, 4, "{model: none}", "[]")
        for text, asked in (("64 MB", 64 * 10**6), ("64MiB", 64 * 2**20), ("0.5 GB", 5 * 10**8), ("1  GiB", 2**30)):
            self.assertEqual(self.plan(scene, text)["asked"], asked)

    def test_few_slots_for_many_objects_are_noted_with_what_is_enough(self):
        self.ok("synth", "-o", "base.furrow", "--posts", "289x289", "--spacing", "1")
        scene = self.scene_of(0.0625, 60, 4, "{model: none}", "[]")
        told = self.ok("explain", scene, "--store", "base.furrow", "--set", "cache.slots=32")
        slots, memory = (int(n) for n in re.search(r"give (\d+),\s+or\s+cache.memory: (\d+) MB", told).groups())
        for enough in (f"cache.slots={slots}", f"cache.memory={memory} MB"):
            self.assertNotIn("each step loads", self.ok("explain", scene, "--store", "base.furrow", "--set", enough))


if __name__ == "__main__":
    main()
