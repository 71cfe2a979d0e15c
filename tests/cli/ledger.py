"""The ledger of soil, by a reader of run.json alone, and of `furrow verify` and `furrow info` alone: offsets + carried + compacted + in flight - added is 0 to the unit,
after drives that carry and throw, over ground on which soil was poured, in parts by --resume."""
import contextlib
import json
import pathlib
import sqlite3
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main

SCENE = """scene: 1
time_step: 0.02
end_time: 1.2
spacing: 0.0625
soil: {name: dry_sand}
redistribute: {model: scm, interval: 0.05, thrown: on}
objects:
- {name: plate, shape: {box: {size: [0.8, 1.2, 0.1]}}, sink: 0.2, carry: true, path: {points: [[20, 24], [30, 25]], speed: 3}}
- {name: wheel, shape: {wheel: {radius: 0.3, width: 0.25}}, path: {points: [[20, 30], [30, 31]], speed: 3}, load: 700, slip: 0.6}
"""
TERMS = ("compacted", "carried", "in_flight")


class Ledger(FurrowTest):
    def setUp(self):
        super().setUp()
        self.synth("world.furrow", posts="65x65", kind="plain", relief=0)

    def closed(self, run, carries=True, throws=True, store="world.furrow"):
        """Sums up. Gives the units of run.json."""
        units = run["volume"]["quanta"]
        self.assertEqual(("carried" in units, "in_flight" in units), (carries, throws))
        self.assertEqual(units["net"] + sum(units.get(term, 0) for term in TERMS) - units["added"], 0)
        cell = 2.0**-20 * 0.0625**2
        for key in units:
            self.assertAlmostEqual(run["volume"][key], units[key] * cell, delta=1e-12)
        check, info = self.json("verify", store), self.json("info", store)
        self.assertTrue(check["ok"], check["problems"])
        self.assertEqual(check["offset_sum"]["-4"] + sum(check[term] for term in TERMS) - check["added"], 0)
        self.assertEqual([info[term] for term in (*TERMS, "added")], [check[term] for term in (*TERMS, "added")])
        self.assertEqual([check[term] for term in TERMS[1:]], [units.get(term, 0) for term in TERMS[1:]])
        return units

    def test_a_drive_that_carries_and_throws(self):
        run = self.drive(self.scene(SCENE), "--store", "world.furrow")
        units = self.closed(run)
        self.assertGreater(min(units["carried"], units["in_flight"]), 1000)
        rows = (self.folder / "out/volume.csv").read_text().splitlines()
        last = dict(zip(rows[0].split(","), rows[-1].split(",")))
        for key in ("removed", "raised", "compacted"):
            self.assertAlmostEqual(float(last[key]), run["volume"][key], delta=1e-9)
        self.assertEqual(units["carried"], run["objects"]["plate"]["carried"]["quanta"])
        self.assertEqual(units["in_flight"], run["thrown"]["quanta"]["in_flight"])
        said = self.ok("info", "world.furrow")
        for term, label in zip(TERMS, ("compacted", "carried", "in flight")):
            self.assertRegex(said, rf"\n{label} +{run['volume'][term]:.6g} m3")

    def test_without_such_soil_it_is_not_told(self):
        text = SCENE.replace(", carry: true", "")
        self.closed(self.drive(self.scene(text.replace(", thrown: on", "")), "--store", "world.furrow"), False, False)
        self.assertNotRegex(self.ok("info", "world.furrow"), r"\n(carried|in flight|added) ")
        self.closed(self.drive(self.scene(text), "--store", "world.furrow"), False)

    def test_in_parts(self):
        path = self.scene(SCENE)
        whole = self.closed(self.drive(path, "--store", "world.furrow"))
        self.ok("reset", "world.furrow")
        self.closed(self.drive(path, "--store", "world.furrow", "--steps", 25))
        self.closed(self.drive(path, "--store", "world.furrow", "--steps", 41, "--resume"))
        self.assertEqual(self.closed(self.drive(path, "--store", "world.furrow", "--resume")), whole)
        self.closed(self.drive(path, "--store", "world.furrow", "--resume"))  # nothing is left to drive

    def test_a_drive_that_does_not_go_on_begins_with_it_compacted(self):
        path = self.scene(SCENE)
        first = self.closed(self.drive(path, "--store", "world.furrow", "--steps", 40))
        again = self.closed(self.drive(path, "--store", "world.furrow", "--steps", 1))
        self.assertLess(again["carried"], first["carried"] / 2)
        self.assertEqual(self.json("verify", "world.furrow")["compacted"], sum(first[term] for term in TERMS) + again["compacted"])

    def test_over_poured_ground(self):
        path = self.scene(SCENE)
        self.ok("edit", "--polygon", "POLYGON ((21 23, 24 23, 24 32, 21 32))", "--volume", 3, "world.furrow", "--spacing", 0.0625)
        units = self.closed(self.drive(path, "--store", "world.furrow"))
        self.assertEqual(units["added"], 0)  # by this drive
        self.assertEqual(self.json("info", "world.furrow")["added"], round(3 / (2.0**-20 * 0.0625**2)))
        self.ok("edit", "--polygon", "POLYGON ((10 10, 12 10, 12 12, 10 12))", "--depth", -0.1, "--dense", "world.furrow")
        check = self.json("verify", "world.furrow")
        self.assertEqual(check["offset_sum"]["-4"] + check["compacted"], check["added"])
        self.assertEqual((check["carried"], check["in_flight"]), (0, 0))  # nothing goes on with it

    def test_an_overlay_of_it(self):
        self.drive(self.scene(SCENE), "--store", "world.furrow")
        over = self.drive(self.scene(SCENE.replace("[20, 24]", "[21, 20]")), "--store", "world.furrow", "--overlay", "over.furrow")
        units = over["volume"]["quanta"]
        self.assertEqual(units["net"] + sum(units[term] for term in TERMS), 0)
        for store in ("world.furrow", "over.furrow"):
            check = self.json("verify", store)
            self.assertEqual(check["offset_sum"]["-4"] + sum(check[term] for term in TERMS), 0)

    def test_a_record_with_other_words_is_refused(self):
        self.drive(self.scene(SCENE), "--store", "world.furrow")
        with contextlib.closing(sqlite3.connect(self.folder / "world.furrow")) as db, db:
            state = json.loads(db.execute("SELECT state FROM run").fetchone()[0])
            for damaged in ("-5", "much", "99999999999999999999", ""):
                db.execute("UPDATE run SET state = ?", [json.dumps({**state, "carried": damaged})])
                db.commit()
                self.assertIn("aboard or in flight is damaged", self.refused(3, "info", "world.furrow"))


if __name__ == "__main__":
    main()
