"""furrow bench: rows of each part, a store that stays as it is, and what is refused. Times are not compared."""
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import BUILT, FURROW, FurrowTest, LIBRARY, main


class Bench(FurrowTest):
    def store(self, posts="257x257"):
        self.ok("synth", "-o", "s.furrow", "--posts", posts, "--spacing", 0.5)

    def told_by(self, code):
        done = subprocess.run([sys.executable, "-c", code], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(BUILT), "FURROW_LIBRARY": LIBRARY, "FURROW_PROGRAM": FURROW})
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_each_part_has_its_rows_and_the_store_stays(self):
        self.store()
        before = (self.folder / "s.furrow").read_bytes()
        code = """if True:
            import json, sys
            from furrow import bench
            bench.MODELS, bench.SPACINGS, bench.SIZES, bench.SLOTS = (("box", ""), ("scm", "")), (0.25, 0.125), ((64, 36),), (16, 32)
            told = bench.run("s.furrow", True, lambda text: None)
            told["text"] = bench.table(told)
            print(json.dumps(told))
        """
        told = self.told_by(code)
        self.assertEqual([(row["model"], row["spacing"]) for row in told["steps"]], [("box", 0.25), ("box", 0.125), ("scm", 0.25), ("scm", 0.125)])
        self.assertTrue(all(0 < row["least"] <= row["step_ms"] <= row["most"] for row in told["steps"]))
        self.assertEqual([(row["width"], row["height"]) for row in told["frames"]], [(64, 36)])
        self.assertEqual([row["slots"] for row in told["cache"]], [16, 32])
        self.assertNotIn("s3fifo", told["cache"][0])
        for row in told["cache"]:
            self.assertTrue(0 < row["opt"] <= row["lru"] < 1)
            self.assertGreater(row["hits"], row["misses"])
        self.assertEqual([row["what"] for row in told["tiles"]], ["export", "import"])
        self.assertEqual(told["left_out"], [])
        for word in ("step   scm", "frame    64 x 36", "cache    16 slots", "tiles  import"):
            self.assertIn(word, told["text"])
        self.assertEqual((self.folder / "s.furrow").read_bytes(), before)
        self.assertEqual({path.name for path in self.folder.iterdir()} - {"s.furrow-pins"}, {"s.furrow"})

    def test_what_does_not_fit_into_the_time_is_named(self):
        self.store()
        code = """if True:
            import json
            from furrow import bench
            bench.MODELS, bench.SIZES, bench.QUICK = (("box", ""),), ((64, 36),), 0.05
            print(json.dumps(bench.run("s.furrow", True)["left_out"]))
        """
        left = self.told_by(code)
        self.assertIn("cache", left)
        self.assertTrue(any(name.startswith("tiles: export") for name in left))

    def test_what_is_no_terrain_is_refused(self):
        for name, content in (("none.furrow", None), ("bad.furrow", b"no store" * 99)):
            if content is not None:
                (self.folder / name).write_bytes(content)
            self.assertIn(name, self.refused(3, "bench", name, "--quick"))
        self.ok("synth", "-o", "tiny.furrow", "--posts", "3x3", "--spacing", 0.5)
        self.assertIn("tiny.furrow", self.refused(3, "bench", "tiny.furrow", "--quick"))


if __name__ == "__main__":
    main()
