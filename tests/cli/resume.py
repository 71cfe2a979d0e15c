"""An import that is killed or interrupted goes on with --resume to the same store, whatever --jobs."""
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import time
import unittest

from furrow_test import FURROW, FurrowTest, has_gdal, long, main

SIDE = 5121


class Resume(FurrowTest):
    source = "noise.r16"

    def setUp(self):
        super().setUp()
        # Noise packs badly: enough bytes for several commits.
        (self.folder / "noise.r16").write_bytes(random.Random(3).randbytes(2 * SIDE * SIDE))

    def arguments(self, store, *more):
        return ["import", self.source, "-o", store, "--max-error", "0.01", *more]

    def start(self, *more):
        return subprocess.Popen([FURROW, *self.arguments("killed.furrow", *more)], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def stopped(self, number, after, *more):
        """Its exit status, the process told `number` so many seconds after its first bytes."""
        process = self.start(*more)
        part = self.folder / "killed.furrow.part"
        while process.poll() is None and not (part.exists() and part.stat().st_size > 1 << 20):
            time.sleep(0.001)
        time.sleep(after)
        process.send_signal(number)
        _, errors = process.communicate(timeout=100)
        return process.returncode, errors

    def tiles_in(self, part):
        """What was committed; of a copy, since looking undoes what was not."""
        copy = self.folder / "looked"
        for suffix in ("", "-journal"):
            source = part.with_name(part.name + suffix)
            pathlib.Path(f"{copy}{suffix}").unlink(missing_ok=True)
            if source.exists():
                shutil.copy(source, f"{copy}{suffix}")
        if not copy.exists():
            return 0
        store = sqlite3.connect(copy)
        try:
            return store.execute("SELECT count(*) FROM base").fetchone()[0]
        except sqlite3.Error:  # killed before its tables were there
            return 0
        finally:
            store.close()

    def hash_of(self, store):
        return self.json("info", store)["base_hash"]

    @long
    def test_killed_over_and_over_it_becomes_the_same_store(self):
        started = time.monotonic()
        self.ok(*self.arguments("whole.furrow", "--jobs", "2"))
        took = time.monotonic() - started
        chance = random.Random(int(os.environ.get("KILL_SEED", "7")))
        part = self.folder / "killed.furrow.part"
        committed = kills = 0
        while kills == 0 or committed == 0 or not (self.folder / "killed.furrow").exists():
            if (self.folder / "killed.furrow").exists():  # done before anything of it was killed: again
                (self.folder / "killed.furrow").unlink()
            status, errors = self.stopped(signal.SIGKILL, chance.uniform(0, took), "--resume", "--jobs",
                                          str(chance.choice([1, 2, 5])))
            self.assertIn(status, (0, -signal.SIGKILL), errors)
            kills += status != 0
            committed = max(committed, self.tiles_in(part))
            if kills > 60:  # were nothing kept, it would never end
                self.ok(*self.arguments("killed.furrow", "--resume"))
        self.assertEqual(self.hash_of("killed.furrow"), self.hash_of("whole.furrow"))
        self.assertTrue(self.json("verify", "killed.furrow")["ok"])
        left = sorted(p.name for p in self.folder.glob("killed*"))
        if status != 0:  # killed between the new name and the end, it leaves its lock, which the next writer takes
            left = [name for name in left if name != "killed.furrow-lock"]
        self.assertEqual(left, ["killed.furrow"])

    def test_in_a_log_it_tells_how_far_it_is_every_ten_seconds(self):
        part, process = self.folder / "killed.furrow.part", None
        for _ in range(5):
            if process is None or process.poll() is not None:  # done before it could be stopped: again
                started, process = time.monotonic(), self.start("--overwrite")
                self.addCleanup(process.kill)
            while process.poll() is None and not (part.exists() and part.stat().st_size > 1 << 20):
                time.sleep(0.001)
            process.send_signal(signal.SIGSTOP)  # it takes long, and no processor
        time.sleep(10.5)
        process.send_signal(signal.SIGCONT)
        _, errors = process.communicate(timeout=250)
        self.assertEqual(process.returncode, 0, errors)
        self.assertRegex(errors, r"(?m)^furrow: note: killed.furrow: \d+ of 5121 rows \(\d+ %\), \d+ a second, \d+ s left$")
        self.assertLessEqual(errors.count(" s left"), (time.monotonic() - started) // 10)

    def test_interrupted_it_says_how_to_go_on_and_does(self):
        status, errors = self.stopped(signal.SIGINT, 0)
        if status == 0:
            self.skipTest("it was done before it could be interrupted")
        self.assertEqual(status, 130, errors)
        self.assertIn("--resume", errors)
        self.assertFalse((self.folder / "killed.furrow").exists())
        self.assertTrue((self.folder / "killed.furrow.part").exists())
        for command in ("info", "verify"):
            self.assertIn("--resume", self.refused(3, command, "killed.furrow.part"))
        output = self.ok(*self.arguments("killed.furrow", "--resume"))
        self.assertRegex(output, r"[1-9]\d* tiles were there from before")
        self.ok(*self.arguments("whole.furrow", "--jobs", "1"))
        self.assertEqual(self.hash_of("killed.furrow"), self.hash_of("whole.furrow"))

    def test_it_goes_on_as_the_same_import_only(self):
        status, _ = self.stopped(signal.SIGINT, 0)
        part = self.folder / "killed.furrow.part"
        if status == 0:
            self.skipTest("it was done before it could be interrupted")
        before = part.read_bytes()
        error = self.refused(3, *self.arguments("killed.furrow", "--resume", "--tile", "128"))
        self.assertIn("--resume", error)
        source = self.folder / "noise.r16"
        os.utime(source, (1, 1))
        self.refused(3, *self.arguments("killed.furrow", "--resume"))
        self.assertEqual(part.stat().st_size, len(before))
        # Without --resume it begins anew.
        self.ok(*self.arguments("killed.furrow"))
        self.assertFalse(part.exists())

    @unittest.skipUnless(has_gdal(), "needs GDAL")
    def test_what_a_source_is_made_of_is_part_of_the_import(self):
        (self.folder / "noise.vrt").write_text(
            f'<VRTDataset rasterXSize="{SIDE}" rasterYSize="{SIDE}"><VRTRasterBand dataType="UInt16" band="1" '
            'subClass="VRTRawRasterBand"><SourceFilename relativeToVRT="1">noise.r16</SourceFilename><ByteOrder>LSB'
            '</ByteOrder></VRTRasterBand></VRTDataset>')
        self.source = "noise.vrt"
        status, errors = self.stopped(signal.SIGINT, 0)
        if status == 0 or "without GDAL" in errors:
            self.skipTest("it was done before it could be interrupted, or cannot be read")
        self.assertEqual(status, 130, errors)
        self.assertIn("--resume", self.refused(3, *self.arguments("killed.furrow", "--resume", "--s-unit", "m")))
        os.utime(self.folder / "noise.r16", (1, 1))
        self.assertIn("sources that have changed", self.refused(3, *self.arguments("killed.furrow", "--resume")))
        self.assertTrue((self.folder / "killed.furrow.part").exists())

    def test_with_nothing_to_go_on_from_it_begins(self):
        self.ok(*self.arguments("killed.furrow", "--resume"))
        self.assertTrue(self.json("verify", "killed.furrow")["ok"])
        self.refused(3, *self.arguments("killed.furrow", "--resume"))  # it exists

    def test_a_damaged_part_is_refused_and_kept(self):
        part = self.folder / "killed.furrow.part"
        part.write_bytes(b"SQLite format 3\0" + bytes(5000))
        self.refused(3, *self.arguments("killed.furrow", "--resume"))
        self.assertTrue(part.exists())
        self.ok(*self.arguments("killed.furrow"))


if __name__ == "__main__":
    main()
