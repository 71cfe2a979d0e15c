"""furrow mobility: ramps of known slopes are go, no-go or unknown as the pull, the friction angle and the posts say."""
import pathlib
import re
import struct

from furrow_test import FurrowTest, main

SCENES = pathlib.Path(__file__).parents[2] / "tools" / "scenes"
ROVER = SCENES / "vehicles" / "rover.xml"


class Mobility(FurrowTest):
    def ramp(self, name, rise, spacing=0.5, posts=33):
        """A ramp to the east: rise in metres a metre."""
        top = rise * spacing * (posts - 1)
        row = struct.pack(f"<{posts}H", *(round(65535 * x / (posts - 1)) for x in range(posts)))
        (self.folder / f"{name}.raw").write_bytes(row * posts)
        self.ok("import", f"{name}.raw", "-o", f"{name}.furrow", "--spacing", spacing, "--height-range", f"0,{top or 1!r}" if rise else "0,1e-9",
                "--max-error", "0")
        return f"{name}.furrow"

    def judged(self, store, *arguments):
        """What is said of the terrain: shares by class, and the steepest slope straight up."""
        result = self.furrow("mobility", store, "--vehicle", ROVER, "--soil", "lunar", "--gravity", "1.62", "--spacing", "0.04", "-o", "out.png", *arguments)
        if result.returncode == 4 or "no MuJoCo" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, 0, result.stderr)
        told = result.stdout
        shares = {name: float(share) for name, share in re.findall(r"(no-go|go|some headings|unknown) ([\d.]+) %", told)}
        self.assertAlmostEqual(sum(shares.values()), 100, delta=0.2)
        return shares, float(re.search(r"straight up: up to ([\d.]+) degrees", told).group(1)), result

    def test_ramps_are_what_their_slopes_are(self):
        shares, steepest, _ = self.judged(self.ramp("level", 0))
        self.assertEqual(shares["go"], 100)
        self.assertGreater(steepest, 10)
        self.assertLess(steepest, 30)
        # Inner cells only: at the border there is no slope.
        for rise, name in ((0.1, "go"), (0.5, "no-go"), (1.0, "unknown")):
            with self.subTest(rise=rise):
                shares, again, _ = self.judged(self.ramp(f"ramp{rise}", rise))
                self.assertEqual(again, steepest)
                self.assertGreater(shares[name], 99)
        self.assertEqual((self.folder / "out.png").read_bytes()[:4], b"\x89PNG")

    def test_a_coarse_terrain_is_unknown(self):
        shares, _, result = self.judged(self.ramp("coarse", 0.1, spacing=30))
        self.assertEqual(shares["unknown"], 100)
        self.assertIn("give a finer terrain", result.stderr)

    def test_a_spread_of_soils_is_the_same_with_the_same_seed(self):
        store = self.ramp("steep", 0.26)
        first = self.judged(store, "--spread", "0.3", "--samples", "3", "--seed", "7")[2].stdout
        self.assertEqual(first, self.judged(store, "--spread", "0.3", "--samples", "3", "--seed", "7")[2].stdout)

    def test_wrong_input_is_told(self):
        store = self.ramp("level", 0)
        self.judged(store)
        for status, arguments, part in (
                (2, ["--vehicle", ROVER, "--soil", "lunar"], "-o is missing"), (2, ["-o", "x.png", "--soil", "lunar"], "--vehicle and --scene"),
                (2, ["-o", "x.png", "--vehicle", ROVER], "--soil is missing"), (3, ["-o", "x.png", "--vehicle", "absent.xml", "--soil", "lunar"], "absent.xml"),
                (3, ["-o", "x.png", "--vehicle", ROVER, "--soil", "moondust"], "moondust"), (2, ["-o", "x.jpg", "--vehicle", ROVER, "--soil", "lunar"], "neither"),
                (3, ["-o", "x.png", "--vehicle", SCENES / "vehicles" / "walker.xml", "--soil", "lunar"], "wheel")):
            with self.subTest(arguments=arguments):
                self.assertIn(part, self.refused(status, "mobility", store, *arguments))


if __name__ == "__main__":
    main()
