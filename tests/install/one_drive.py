"""Law 11: a drive by the command and a drive by the library leave the same rows and the same objects.csv, also when the library
went back to a checkpoint meanwhile."""
import sqlite3
import unittest

import prefix

SCENES = prefix.ROOT / "tools" / "scenes"
STEPS = 30

LIBRARY = """
import pathlib, sys
import furrow
scene, store, overlay, output, steps, back = sys.argv[1:]
with furrow.World(pathlib.Path(scene), store=store, overlay=overlay, output=output) as world:
    for _ in range(int(back)):
        world.step()
    if int(back) > 0:
        world.checkpoint()
        for _ in range(int(steps)):
            world.step()
        world.points([(60, 60)])
        world.rollback()
    for _ in range(int(steps) - int(back)):
        world.step()
"""


def rows(path):
    """All that a drive writes: each table's planes, and the soil that is compacted."""
    found = {}
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as store:
        for table, in store.execute("select name from sqlite_master where type = 'table'").fetchall():
            columns = [row[1] for row in store.execute(f"pragma table_info('{table}')") if row[1] != "revision"]
            if "blob" in columns:
                found[table] = store.execute(f"select {', '.join(columns)} from \"{table}\" order by key").fetchall()
        found["meta"] = store.execute("select key, value from meta where key like '%compacted%'").fetchall()
    return found


class OneDriveTest(unittest.TestCase):
    def setUp(self):
        self.store = prefix.work / "ridges.furrow"
        if not self.store.exists():
            prefix.run("furrow", "synth", "-o", self.store, "--kind", "ridged", "--posts", "513x513", "--spacing", "1", "--relief", "60",
                       env=prefix.environment)

    def command(self, scene):
        overlay, output = prefix.work / f"{scene.stem}-command.furrow", prefix.work / f"{scene.stem}-command"
        if not overlay.exists():
            result = prefix.run("furrow", "drive", scene, "--store", self.store, "--overlay", overlay, "-o", output, "--steps", STEPS,
                                env=prefix.environment, check=False)
            if result.returncode == 4:
                self.skipTest("there is no GL")
            self.assertEqual(result.returncode, 0, result.stderr)
        return overlay, output

    def compare(self, scene, back):
        overlay, output = (prefix.work / f"{scene.stem}-{back}{end}" for end in (".furrow", ""))
        prefix.run_python("-c", LIBRARY, scene, self.store, overlay, output, STEPS, back)
        other, told = self.command(scene)
        expected, found = rows(other), rows(overlay)
        self.assertTrue(any(expected[table] for table in expected), "the drive changed nothing")
        self.assertEqual(list(expected), list(found))
        for table in expected:
            self.assertTrue(expected[table] == found[table], f"{scene.name}: {table} differs")
        self.assertEqual((told / "objects.csv").exists(), (output / "objects.csv").exists())
        if (told / "objects.csv").exists():
            self.assertEqual((told / "objects.csv").read_text(), (output / "objects.csv").read_text())
        prefix.run("furrow", "verify", overlay, env=prefix.environment)

    def test_every_example_scene(self):
        scenes = sorted(SCENES.glob("*.yaml"))
        self.assertGreaterEqual(len(scenes), 8)
        for scene in scenes:
            with self.subTest(scene.name):
                self.compare(scene, 0)

    def test_after_a_rollback(self):
        for name in ("rover", "tracks", "shapes"):
            with self.subTest(name):
                self.compare(SCENES / f"{name}.yaml", 11)


if __name__ == "__main__":
    unittest.main()
