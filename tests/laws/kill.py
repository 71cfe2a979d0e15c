"""Law 6: a drive killed at a random instant, 20 times, leaves a store that verifies and holds every
epoch that was acknowledged."""
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from furrow_test import FURROW, SCENE, FurrowTest, main


class Kill(FurrowTest):
    def test_twenty_kills_leave_a_store_that_verifies(self):
        store = self.synth(posts="513x513")
        scene = self.scene(SCENE.replace("end_time: 4", "end_time: 4000").replace("spacing: 0.25", "spacing: 0.125")
                           .replace("speed: 30}", "speed: 30, loop: true}").replace("slots: 16", "slots: 5"))
        chance = random.Random(int(os.environ.get("KILL_SEED", "20")))
        last, survived = 0, 0
        for kill in range(20):
            process = subprocess.Popen([FURROW, "drive", scene, "--store", store, "-o", self.folder / "out"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            time.sleep(chance.uniform(0.3, 2.5))
            process.send_signal(signal.SIGKILL)
            _, errors = process.communicate(timeout=60)
            if process.returncode == 4:
                self.skipTest("no GL here")
            self.assertEqual(process.returncode, -signal.SIGKILL, errors)
            check = self.json("verify", store)
            self.assertTrue(check["ok"], check["problems"])
            run = self.json("info", store)["last_run"]
            log = self.folder / "out/epochs.log"
            lines = log.read_text().splitlines() if log.exists() else []
            acknowledged = int(lines[-1].split()[1]) if lines else 0
            committed = run["epochs"] if run else 0
            self.assertGreaterEqual(committed, acknowledged)
            self.assertGreaterEqual(committed, last)
            survived += committed > last
            last = committed
        # The test is worth something only if kills came after commits.
        self.assertGreater(survived, 5)


if __name__ == "__main__":
    main()
