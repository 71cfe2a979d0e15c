"""Looking changes nothing (law 16): commands that only read leave each byte, need nothing that can be written, and are right beside a writer."""
import hashlib
import os
import signal
import subprocess
import time
import unittest

from furrow_test import FURROW, MAPS, FurrowTest

SCENE = """scene: 1
time_step: 0.05
end_time: 4000
spacing: 0.125
redistribute: {model: box}
objects: [{name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[8, 8], [24, 20]], speed: 4, loop: true}}]
"""
NOBODY = 65534


def become_nobody():
    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)


class Looking(FurrowTest):
    def setUp(self):
        super().setUp()
        self.here = self.folder / "here"
        self.here.mkdir()
        (self.here / "s.yaml").write_text(SCENE)
        self.ok("synth", "-o", "plain.furrow", "--kind", "plain", "--posts", "129x129", "--spacing", "0.25", cwd=self.here)
        os.chmod(self.folder, 0o755)
        self.out = self.folder / "out"
        self.out.mkdir()
        os.chmod(self.out, 0o777)

    def now(self):
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in self.here.iterdir()
                if path.is_file() and not path.name.endswith("-shm")} | {path.name: "" for path in self.here.iterdir()}

    def commands(self, store):
        out = str(self.out / "x")
        return [["query", store, "10", "10"], ["info", store], ["log", store], ["verify", store],
                ["export", store, "-o", out + ".png"],
                ["explain", "s.yaml", "--store", store]] + ([["map", store, "-o", out + ".svg"]] if MAPS else [])

    def look(self, store, nobody=False, some=None):
        for command in self.commands(store)[:some]:
            with self.subTest(command=command):
                result = subprocess.run([FURROW, *command], cwd=self.here, capture_output=True, text=True, timeout=280,
                                        preexec_fn=become_nobody if nobody else None)
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_each_command_leaves_each_byte_and_needs_none_that_can_be_written(self):
        self.ok("drive", "s.yaml", "--store", "plain.furrow", "--overlay", "over.furrow", "-o", self.out / "run", "--steps", "20", cwd=self.here)
        self.ok("branch", "over.furrow", "branch.furrow", cwd=self.here)
        self.ok("snapshot", "over.furrow", "first", cwd=self.here)
        before = self.now()
        self.look("branch.furrow")
        self.ok("report", self.out / "run", "-o", self.out / "report.html", cwd=self.here)
        self.assertEqual(self.now(), before)
        for path in self.here.iterdir():
            path.chmod(0o444)
        self.here.chmod(0o555)
        try:
            for path in self.out.rglob("*"):
                path.chmod(0o777 if path.is_dir() else 0o666)
            self.look("over.furrow", nobody=True)
        finally:
            self.here.chmod(0o755)
        self.assertEqual(self.now(), before)

    def begun(self):
        """A drive that has committed, and goes on for long."""
        drive = subprocess.Popen([FURROW, "drive", "s.yaml", "--store", "plain.furrow", "-o", str(self.out / "run")], cwd=self.here,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(drive.kill)
        log = self.out / "run" / "epochs.log"
        while not (log.exists() and log.read_text().count("\n") > 1):
            self.assertIsNone(drive.poll())
            time.sleep(0.02)
        return drive

    def test_beside_a_drive_and_after_it_was_killed(self):
        drive = self.begun()
        drive.send_signal(signal.SIGSTOP)
        beside = self.now()
        self.assertIn("plain.furrow-wal", beside)
        deep = self.json("query", "plain.furrow", "8", "8", "--json", cwd=self.here)
        self.look("plain.furrow", some=5)
        self.assertEqual(self.now(), beside)
        drive.send_signal(signal.SIGCONT)
        self.look("plain.furrow", some=1)  # while it writes
        drive.kill()
        drive.wait()
        killed = self.now()
        self.look("plain.furrow", some=4)
        self.assertEqual(self.now(), killed)
        self.assertEqual(self.json("query", "plain.furrow", "8", "8", "--json", cwd=self.here)["points"], deep["points"])


if __name__ == "__main__":
    unittest.main()
