"""Long work in a pipe tells every ten seconds how far it is. The work is stopped for that long, so that no test has to work so long."""
import os
import pty
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

    def test_a_drive_tells_what_pictures_take(self):
        self.synth("plain.furrow", "65x65", kind="plain", relief=2)
        scene = self.scene(SCENE.replace("0.00005", "0.05").replace("80", "1.5") + "view: {size: [320, 240], camera: {fixed: {eye: [10, 10, 30], target: [30, 20, 0]}}, images: 1}\n")
        seen, terminal = pty.openpty()
        process = subprocess.Popen([FURROW, "drive", scene, "--store", "plain.furrow", "-o", "out"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=terminal)
        self.addCleanup(process.kill)
        os.close(terminal)
        text = b""
        try:
            while more := os.read(seen, 4096):
                text += more
        except OSError:  # the other end is closed
            pass
        os.close(seen)
        if process.wait() == 4:
            self.skipTest("no GL here")
        self.assertRegex(text.decode(), r"drive: step \d+ of 30 \(\d+ %\), [\d.]+ a second, \d+ s left; pictures take [\d.e-]+ s each, \d+ % of the time")


if __name__ == "__main__":
    main()
