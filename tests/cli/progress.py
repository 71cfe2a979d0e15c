"""Long work in a pipe tells every ten seconds how far it is. The work is stopped for that long, so that no test has to work so long."""
import re
import signal
import subprocess
import time

from furrow_test import FURROW, FurrowTest, main

SCENE = """scene: 1
time_step: 0.00005
end_time: 80
spacing: 0.03125
redistribute: {model: box}
objects:
  - {name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[20, 20], [100, 20]], speed: 1}}
"""


class Progress(FurrowTest):
    def stopped(self, begun, *arguments):
        """stderr of a command that is stopped for eleven seconds once `begun` says that it works."""
        process = subprocess.Popen([FURROW, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        while process.poll() is None and not begun():
            time.sleep(0.001)
        time.sleep(0.1)  # its clock starts soon after
        if process.poll() is None:
            process.send_signal(signal.SIGSTOP)
            time.sleep(11)
            process.send_signal(signal.SIGCONT)
        errors = process.communicate(timeout=250)[1]
        if process.returncode == 4:
            self.skipTest("no GL here: " + errors.strip())
        self.assertEqual(process.returncode, 0, errors)
        return errors

    def test_a_drive(self):
        self.synth("plain.furrow", "129x129", kind="plain", relief=2)
        scene = self.scene(SCENE)
        log = self.folder / "out/epochs.log"
        errors = self.stopped(lambda: log.exists() and log.stat().st_size > 0, "drive", scene, "--store", "plain.furrow", "-o", "out")
        told = re.findall(r"^furrow: note: drive: step (\d+) of 1600000 \((\d+) %\), [\d.]+ a second, \d+ s left$", errors, re.M)
        self.assertEqual(len(told), 1, errors)
        self.assertAlmostEqual(int(told[0][0]) / 16000, int(told[0][1]), delta=1)


if __name__ == "__main__":
    main()
