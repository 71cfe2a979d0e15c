"""Pictures that are kept: written beside the steps, and yet all there and the same after whatever ended the drive."""
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FURROW, SCENE, FurrowTest, long, main

# Every tile has a slot: a picture is the same whenever it is drawn.
VIEW = SCENE.replace("slots: 16", "slots: 120") + """view:
  size: [240, 135]
  camera: {overhead: {over: left, height: 40}}
  effects: [texture, detail]
"""
STEPS = 80


class Images(FurrowTest):
    def setUp(self):
        super().setUp()
        self.store = self.synth()
        self.every(10)

    def every(self, images):
        self.path = self.scene(VIEW + f"  images: {images}\n")

    def overlay(self, name):
        return ["--store", self.store, "--overlay", f"{name}.furrow"]

    def names(self):
        return {path.name for path in (self.folder / "out").glob("frame-*.png")}

    def found(self):
        """All, with what is left of any that is not whole."""
        return {path.name: path.read_bytes() for path in (self.folder / "out").glob("frame-*")}

    def whole(self, images):
        """What a drive that is left alone has, in a folder of its own."""
        self.every(images)
        self.drive(self.path, *self.overlay("whole"))
        pictures = self.found()
        self.assertEqual(sorted(pictures), [f"frame-{step:06}.png" for step in range(images, STEPS + 1, images)])
        (self.folder / "out").rename(self.folder / "alone")
        return pictures

    def start(self, *arguments):
        return subprocess.Popen([FURROW, "drive", self.path, *self.overlay("it"), "-o", "out", *map(str, arguments)], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def last_step(self):
        return self.json("info", self.folder / "it.furrow")["last_run"]["step"]

    def resume(self):
        self.drive(self.path, *self.overlay("it"), "--resume")

    def place(self, step):
        (self.folder / "out").mkdir()
        return self.folder / f"out/frame-{step:06}.png.part"

    def test_what_is_kept_costs_a_thread_and_nothing_else_does(self):
        counts = [self.drive(self.path, *self.overlay(f"over{images}"), "--set", f"view.images={images}") for images in (0, 40)]
        self.assertEqual([run["counts"]["threads"] for run in counts], [1, 2])  # none loads ahead: every tile has a slot
        self.assertEqual([run["counts"]["units"]["frame"] for run in counts], [0, 2])
        self.assertNotIn("view", counts[0])
        self.assertEqual([counts[1]["view"][name] for name in ("frames", "images")], [2, 2])

    def test_a_picture_is_the_same_whether_earlier_ones_were_drawn_or_not(self):
        few = VIEW.replace("slots: 120", "slots: 16").replace("effects: [texture, detail]", "effects: [texture, objects, geomorph]")
        for text in (VIEW, few):
            found = []
            for every in (1, 20):
                self.path = self.scene(text + f"  images: {every}\n")
                self.drive(self.path, *self.overlay(f"every{every}"))
                found.append(self.found())
                (self.folder / f"every{every}.furrow").unlink()
                for path in (self.folder / "out").glob("frame-*"):
                    path.unlink()
            self.assertEqual(len(found[0]), STEPS)
            self.assertEqual(sorted(found[1]), [f"frame-{step:06}.png" for step in range(20, STEPS + 1, 20)])
            for name, picture in found[1].items():
                self.assertTrue(found[0][name] == picture, name)

    @long
    def test_no_epoch_is_committed_before_the_pictures_it_leaves_behind(self):
        wanted = self.whole(10)
        part = self.place(10)
        os.mkfifo(part)  # which nobody reads: its picture is on its way for ever
        process = self.start("--steps", 25)
        log, busy = self.folder / "out/epochs.log", None
        while not log.exists() or busy != (busy := self.busy(process)):
            self.assertIsNone(process.poll())
            time.sleep(0.5)
        process.kill()
        process.communicate()
        part.unlink()
        self.assertLessEqual(self.last_step(), 10)
        self.resume()
        self.assertTrue(self.found() == wanted)

    def busy(self, process):
        """Ticks it ran so far."""
        return sum(map(int, pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]))

    def test_a_picture_that_cannot_be_written_ends_the_drive_which_goes_on_from_there(self):
        wanted = self.whole(10)
        if not os.path.exists("/dev/full"):
            self.skipTest("not on this machine: no device that is full")
        part = self.place(30)
        part.symlink_to("/dev/full")
        error = self.refused(1, "drive", self.path, *self.overlay("it"), "-o", "out")
        self.assertIn("frame-000030.png: cannot write the picture: No space left", error)
        self.assertEqual(json.loads((self.folder / "out/run.json").read_text())["ended"], "failed")
        self.assertFalse(list((self.folder / "out").glob("*.part")))
        self.assertLessEqual(self.last_step(), 30)
        there = self.found()
        self.assertNotIn("frame-000030.png", there)
        self.assertTrue(all(wanted[name] == there[name] for name in there) and len(there) >= 2)
        self.resume()
        self.assertTrue(self.found() == wanted)

    @long
    def test_what_was_begun_is_ended_when_it_is_interrupted(self):
        wanted = self.whole(1)
        process = self.start()
        while process.poll() is None and len(self.names()) < 10:
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=250)
        if process.returncode == 0:
            self.skipTest("it was done before it could be interrupted")
        self.assertEqual(process.returncode, 130, errors)
        there = self.found()
        self.assertEqual(sorted(there), [f"frame-{step:06}.png" for step in range(1, self.last_step() + 1)])
        self.assertTrue(all(wanted[name] == there[name] for name in there))
        self.resume()
        self.assertTrue(self.found() == wanted)

    @long
    def test_killed_over_and_over_it_has_the_pictures_of_one_that_was_left_alone(self):
        kills, seed = int(os.environ.get("KILLS", "8")), int(os.environ.get("RESUME_SEED", "1"))
        print(f"KILLS={kills} RESUME_SEED={seed}", flush=True)
        chance, wanted, resume, killed, before = random.Random(seed), self.whole(1), [], 0, set()
        while killed < kills:
            process = self.start(*resume)
            more = chance.randint(1, 12)
            # Some pictures from now, and a while.
            while process.poll() is None and len(self.names() | before) < len(before) + more:
                time.sleep(0.001)
            time.sleep(chance.uniform(0, 0.05))
            process.kill()
            process.communicate()
            killed += process.returncode != 0
            resume = ["--resume"] if (self.folder / "it.furrow").exists() else []
            before = self.names()
            if process.returncode == 0 or len(before) >= STEPS:
                self.resume()
                self.assertTrue(self.found() == wanted)
                for path in [*self.folder.glob("it.furrow*"), *(self.folder / "out").glob("*")]:
                    path.unlink()
                resume, before = [], set()
        self.resume()
        self.assertTrue(self.found() == wanted)


if __name__ == "__main__":
    main()
