"""Law 7, from outside: each shipped scene, driven for a while, makes and runs what `explain` said, by name, and nothing else."""
import collections
import json
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FurrowTest, main

SCENES = pathlib.Path(__file__).parents[2] / "tools" / "scenes"
STEPS = {"bare": 200, "rover": 10, "tracks": 10}  # others: 25


def units_of(line, counts):
    """How many of the line's unit there were: of its object, or of its table."""
    unit = line.get("unit", "once")
    if unit == "once":
        return 1
    units = counts["units"][unit]
    if not isinstance(units, dict):
        return units
    if unit in ("changed", "left", "inherited", "kept"):
        return units[line["name"].split()[1]]
    return units[line["object"]] if line.get("object") else sum(units.values())


def total(lines, counts, key, name="name"):
    sums = collections.Counter()
    for line in lines:
        sums[line[name]] += line[key] * units_of(line, counts)
    return {name: count for name, count in sums.items() if count}


class Explained(FurrowTest):
    def check(self, plan, counts):
        self.assertEqual(sorted(program["name"] for program in plan["programs"]),
                         sorted(program["name"] for program in counts["programs"]))
        self.assertEqual(counts["unplanned"], 0)
        self.assertEqual(total(plan["passes"], counts, "amount", "stage"), counts["passes"])
        self.assertEqual(sum(total(plan["textures"], counts, "amount").values()), counts["textures"])
        self.assertEqual(sum(total(plan["textures"] + plan["buffers"], counts, "bytes").values()), counts["bytes"])
        self.assertEqual(sum(thread["amount"] for thread in plan["threads"]), counts["threads"])
        self.assertEqual(total(plan["tables"], counts, "amount"),
                         {f"{verb} {table}": count for table, verbs in counts["statements"].items()
                          for verb, count in verbs.items() if count})

    def test_every_shipped_scene_does_what_it_was_said_to(self):
        store = self.synth(posts="513x513", kind="plain", relief=20)
        scenes = sorted(SCENES.glob("*.yaml"))
        self.assertGreater(len(scenes), 5)
        for scene in scenes:
            with self.subTest(scene.stem):
                shutil.copy(store, self.folder / "driven.furrow")
                over = [scene, "--store", "driven.furrow"]
                if "\nview:" in scene.read_text():
                    over += ["--set", "view.size=[160, 90]", "--set", "view.images=5"]
                explained = self.furrow("explain", *over, "--json")
                if "reads no meshes" in explained.stderr:
                    continue
                self.assertEqual(explained.returncode, 0, explained.stderr)
                self.check(json.loads(explained.stdout), self.drive(*over, "--steps", STEPS.get(scene.stem, 25))["counts"])

    def test_vehicles_do_what_they_were_said_to(self):
        self.synth("flat.furrow", posts="513x513", kind="plain", relief=0.01)
        scenes = sorted((SCENES / "vehicles").glob("*.yaml"))
        self.assertGreater(len(scenes), 3)
        for scene in scenes:
            with self.subTest(scene.stem):
                shutil.copy(self.folder / "flat.furrow", self.folder / "driven.furrow")
                over = [scene, "--store", "driven.furrow", "--set", "view.size=[160, 90]", "--set", "view.images=50"]
                explained = self.furrow("explain", *over, "--json")
                if "this build has no MuJoCo" in explained.stderr:
                    return
                self.assertEqual(explained.returncode, 0, explained.stderr)
                plan, run = json.loads(explained.stdout), self.drive(*over, "--steps", 100)
                self.check(plan, run["counts"])
                # A contact of a soil geom needs a time step, of settling or of the drive; here each has one window.
                settled = max(vehicle["settled_after"] for vehicle in run["vehicles"].values())
                for vehicle in plan["vehicles"].values():
                    touching = {geom: contacts for geom, contacts in vehicle["contacts_per_metre"].items() if contacts != 0}  # not a hull aloft
                    self.assertNotEqual(touching, {})
                    for geom, contacts in touching.items():
                        self.assertGreater(contacts, 10)
                        self.assertLess(run["counts"]["units"]["window"][geom], 101 + settled / 0.002)


if __name__ == "__main__":
    main()
