"""Long work in a pipe tells every ten seconds how far it is. The work is stopped for that long, so that no test has to work so long, and ended then."""
import os
import pty
import re
import signal
import subprocess
import time

from furrow_test import FURROW, FurrowTest, main

SCENE = """scene: 1
time_step: 0.00005
end_time: 10000
spacing: 0.03125
redistribute: {model: box}
objects:
  - {name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[20, 20], [100, 20]], speed: 1}}
"""


class Progress(FurrowTest):
    def test_a_drive(self):
        self.synth("plain.furrow", "129x129", kind="plain", relief=2)
        started = time.monotonic()
        process = subprocess.Popen([FURROW, "drive", self.scene(SCENE), "--store", "plain.furrow", "-o", "out"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.until_committed(process)
        process.send_signal(signal.SIGSTOP)
        time.sleep(10)
        process.send_signal(signal.SIGCONT)
        lines = []
        while line := process.stderr.readline():
            lines.append(line)
            if "drive: step" in line:
                process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(250), 130, lines)
        told = [line for line in lines if "drive: step" in line]
        self.assertTrue(1 <= len(told) <= (time.monotonic() - started) // 10, lines)
        step, share = re.fullmatch(r"furrow: note: drive: step (\d+) of 200000000 \((\d+) %\), [\d.]+ a second, \d+ s left\n", told[0]).groups()
        self.assertAlmostEqual(int(step) / 2000000, int(share), delta=1)

    def test_a_drive_tells_what_pictures_take(self):
        self.synth("plain.furrow", "65x65", kind="plain", relief=2)
        scene = self.scene(SCENE.replace("0.00005", "0.05").replace("10000", "1.5") + "view: {size: [320, 240], camera: {fixed: {eye: [10, 10, 30], target: [30, 20, 0]}}, images: 1}\n")
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
