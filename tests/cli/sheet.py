"""An elastic sheet by a scene: a load on one post against Bessel's closed form, what comes back, what the CPU alone computes, and what is refused."""
import csv
import math

from furrow_test import FurrowTest, main

SCENE = """scene: 1
time_step: 0.1
end_time: %g
spacing: %g
redistribute: {model: sheet, tension: 4000, stiffness: 16000%s}
output: {forces: 10}
objects:
  - {name: point, shape: {sphere: {radius: %g}}, load: 400, path: {points: %s, speed: 4}}
"""


def k0(x):
    """The modified Bessel function, by its integral over cosh."""
    step = 1e-3
    return sum(math.exp(-x * math.cosh(step * (i + 0.5))) * step for i in range(int(12 / step)) if x * math.cosh(step * i) < 700)


class Sheet(FurrowTest):
    def ground(self):
        self.ok("synth", "-o", "flat.tif", "--posts", "129x129", "--spacing", 0.25, "--kind", "plain", "--relief", 0, "--overwrite")
        self.ok("import", "flat.tif", "-o", "flat.furrow", "--tile", 64, "--overwrite")
        return "flat.furrow"

    def pressed(self, *more, end=0.2, spacing=0.125, sheet="", radius=None, points="[[16, 16]]", **other):
        store = self.ground()
        self.scene(SCENE % (end, spacing, sheet, radius or 0.4 * spacing, points))
        return store, self.drive("scene.yaml", "--store", store, *more, **other)

    def test_a_load_on_a_post_bends_it_as_bessels_function(self):
        length = math.sqrt(4000 / 16000)
        for spacing in (0.125, 0.0625, 0.03125):
            store, run = self.pressed(spacing=spacing)
            # On posts, three away and farther; three lengths at most.
            places = [(16 + r * math.cos(a), 16 + r * math.sin(a)) for r in (0.375, 0.5, 1, 1.5) for a in (0, 0.5 * math.pi, math.pi)]
            points = self.json("query", store, *(f"{number:.6f}" for place in places for number in place))["points"]
            for (x, y), point in zip(places, points):
                closed = 400 * k0(math.hypot(x - 16, y - 16) / length) / (2 * math.pi * 4000)
                self.assertAlmostEqual(-point["offset"] / closed, 1, delta=0.02, msg=f"{spacing} m, at {x}, {y}")
            # All of it together carries the load: k times the volume. It ends at six lengths.
            self.assertAlmostEqual(16000 * run["volume"]["removed"], 400, delta=0.02 * 400)
            own = run["objects"]["point"]
            at = self.json("query", store, 16, 16)["points"][0]
            self.assertAlmostEqual(own["sinkage"], -at["offset"], delta=1e-5)
            self.assertAlmostEqual(own["z"], at["base"] + 0.4 * spacing - own["sinkage"], delta=1e-5)
            self.assertEqual(own["load"], 400)

    def test_a_loaded_body_leaves_nothing_and_rows_tell_where_it_stood(self):
        store, run = self.pressed(radius=0.4, points="[[10, 16], [14, 16]]", end=1)
        with open(self.folder / "out/objects.csv") as file:
            rows = list(csv.DictReader(file))
        heights = [float(row["z"]) for row in rows[2:]]
        # It bears on the sheet wherever it is between posts, so it stands about as high everywhere.
        self.assertLess(max(heights) - min(heights), 0.02)
        self.assertTrue(all(row["state"] == "touching" and float(row["sinkage"]) > 0.005 for row in rows))
        behind = self.json("query", store, 10, 16)["points"][0]["offset"]
        self.assertEqual(behind, 0)

    def test_what_the_gpu_does_not_compute_is_refused(self):
        store, _ = self.pressed()
        self.assertIn("the CPU finds how deep a sheet bears it; allowed with: compute: cpu", self.refused(3, "explain", "scene.yaml", "--store", store, "--set", "compute=gpu"))
        self.assertIn("allowed with: redistribute: {model: scm, sheet}", self.refused(3, "explain", "scene.yaml", "--store", store, "--set", "redistribute={model: box}"))


if __name__ == "__main__":
    main()
