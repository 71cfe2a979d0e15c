"""What slides on the rig: a braked wheel among its own heap beside the reference in doubles, and a sled beside the bearing capacity of a footing."""
import json
import math

from furrow_test import FurrowTest, main

# Of bench/faces_law.py, level ground without a heap: a wheel of 58 x 50 mm, 28 mm deep, whose rim runs at this share of its way. Drawbar and upward force, N.
BRAKED = {0.1: (-17.66, 12.97), 0.3: (-25.00, 22.52), 0.5: (-29.95, 36.62), 0.8: (-21.54, 68.04)}
RIG = ("{bekker_kc: 0, bekker_kphi: 8e6, bekker_n: 1.453, cohesion: 1000, friction_angle: 29, janosi_shear: 0.021, elastic_stiffness: 4e7, damping: 0, repose: 29, "
       "unit_weight: 13030}")
OFF = 0.08


class Slides(FurrowTest):
    def rows(self, *words):
        result = self.furrow("rig", "-o", "rig", "--json", *words)
        if result.returncode == 4:
            self.skipTest("no GL here: " + result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["rows"]

    def test_a_braked_wheel_bears_as_if_its_own_heap_were_not_there(self):
        for spacing in ("0.008", "0.004"):
            for rim, (drawbar, fz) in BRAKED.items():
                row, = self.rows("--shape", "wheel: {radius: 0.058, width: 0.05}", "--soil", RIG, "--depth", "0.028", f"--slip={1 - 1 / rim!r}", "--speed", "0.01", "--spacing", spacing,
                                 "--way", "0.24", "--set", "redistribute.slip_sinkage=1.27")
                self.assertLess(abs(row["fz"] / fz - 1), OFF, (spacing, rim, row))
                self.assertLess(abs(row["drawbar"] / drawbar - 1), OFF, (spacing, rim, row))

    def test_a_sled_slides_where_its_width_bears_it(self):
        length, width, load, weight, phi = 1.0, 0.5, 5000.0, 1631 * 9.81, math.radians(28)
        tangent, along = math.tan(phi), math.tan(2 * phi / 3)
        factor = math.exp(math.pi * tangent) * math.tan(math.pi / 4 + phi / 2) ** 2
        upright = (1 - along) ** ((2 + length / width) / (1 + length / width) + 1)
        self.assertGreater(weight * width * (factor + 1) * tangent * upright, 2 * load / length / width)   # so no depth is needed
        row, = self.rows("--shape", f"box: {{size: [{length}, {width}, 0.4]}}", "--soil", "dry_sand", "--load", repr(load), "--spacing", "0.025")
        self.assertEqual(row["state"], "steady", row)
        self.assertLess(row["sinkage"], 0.03, row)
        self.assertGreater(row["against"], along * load, row)   # and it pushes a heap


if __name__ == "__main__":
    main()
