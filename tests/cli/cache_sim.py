"""A drive's trace and its replay: counts against run.json, and against policies written a second time, in Python."""
import collections
import json
import signal
import struct
import subprocess
import xml.etree.ElementTree

from furrow_test import FURROW, FurrowTest, main

SCENE = """scene: 1
time_step: 0.1
end_time: 4
spacing: 1
objects:
  - {name: a, shape: {sphere: {radius: 2}}, sink: 0.2,
     path: {points: [[20, 20], [240, 120], [30, 230], [150, 20], [60, 240]], speed: 200}}
  - {name: b, shape: {sphere: {radius: 2}}, sink: 0.2, path: {points: [[200, 30], [40, 200]], speed: 100, loop: true}}
cache: {slots: 8, prefetch: 0}
"""


def decode(data):
    """(step, key, drawn, hit) of each access, by what the help says of the format."""
    assert data[:12] == b"furrowPT\x01\0\0\0"
    at, step, keys, accesses = 12, 0, [], []
    while True:
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        if value == 1:
            break
        if value & 1:
            step += value >> 1
            continue
        if value >> 3 == len(keys):
            keys.append(struct.unpack_from("<Q", data, at)[0])
            at += 8
        accesses.append((step, keys[value >> 3], value >> 1 & 1, value >> 2 & 1))
    assert struct.unpack_from("<QQ", data, at) == (len(accesses), len(keys)) and at + 24 == len(data)
    return accesses


def lru(keys, slots):
    held, misses = collections.OrderedDict(), 0
    for key in keys:
        if key in held:
            held.move_to_end(key)
            continue
        misses += 1
        if len(held) == slots:
            held.popitem(last=False)
        held[key] = True
    return misses


def clock(keys, slots):
    used, queue, misses = {}, collections.deque(), 0
    for key in keys:
        if key in used:
            used[key] = True
            continue
        misses += 1
        while len(queue) == slots:
            oldest = queue.popleft()
            if used[oldest]:
                used[oldest] = False
                queue.append(oldest)
            else:
                del used[oldest]
        used[key] = False
        queue.append(key)
    return misses


def arc(keys, slots):
    t1, t2, b1, b2 = (collections.OrderedDict() for _ in range(4))
    target, misses = 0.0, 0

    def replace(in_b2):
        if t1 and (len(t1) > target or (len(t1) == target and in_b2)) or not t2:
            b1[t1.popitem(last=False)[0]] = True
        else:
            b2[t2.popitem(last=False)[0]] = True

    for key in keys:
        if key in t1 or key in t2:
            t1.pop(key, None)
            t2.pop(key, None)
            t2[key] = True
            continue
        misses += 1
        in_b1, in_b2 = key in b1, key in b2
        if in_b1:
            target = min(target + max(len(b2) / len(b1), 1), slots)
            del b1[key]
        if in_b2:
            target = max(target - max(len(b1) / len(b2), 1), 0)
            del b2[key]
        if len(t1) + len(t2) == slots:
            if in_b1 or in_b2:
                replace(in_b2)
            elif len(t1) + len(b1) >= slots and not b1:
                t1.popitem(last=False)
            else:
                if len(t1) + len(b1) >= slots:
                    b1.popitem(last=False)
                elif len(t1) + len(b1) + len(t2) + len(b2) >= 2 * slots and b2:
                    b2.popitem(last=False)
                replace(False)
        (t2 if in_b1 or in_b2 else t1)[key] = True
    return misses


def s3fifo(keys, slots):
    small, queue, ghost, uses = (collections.OrderedDict() for _ in range(4))
    small_size, evicted, misses = slots // 10, False, 0
    for key in keys:
        if key in uses:
            uses[key] += 1
            continue
        misses += 1
        remembered = ghost.pop(key, False)
        if small_size < 2:
            continue
        while len(uses) == slots:
            evicted = True
            if len(queue) > slots - small_size or not small:
                oldest = queue.popitem(last=False)[0]
                if uses[oldest] > 0:
                    uses[oldest] = min(uses[oldest], 3) - 1
                    queue[oldest] = True
                else:
                    del uses[oldest]
                continue
            oldest = small.popitem(last=False)[0]
            # What was used goes on to the main queue, and the search with the next, as long as there is one.
            while uses[oldest] >= 2:
                uses[oldest] = 0
                queue[oldest] = True
                if not small:
                    oldest = None
                    break
                oldest = small.popitem(last=False)[0]
            if oldest is not None:
                del uses[oldest]
                if len(ghost) == slots * 9 // 10:
                    ghost.popitem(last=False)
                ghost[oldest] = True
        (queue if remembered or not evicted and len(small) >= small_size else small)[key] = True
        uses[key] = 0
    return misses


def opt(keys, slots):
    after, later = [0] * len(keys), {}
    for i in range(len(keys) - 1, -1, -1):
        after[i] = later.get(keys[i], len(keys))
        later[keys[i]] = i
    needed, misses = {}, 0
    for i, key in enumerate(keys):
        if key not in needed:
            misses += 1
            if len(needed) == slots:
                del needed[max(needed, key=needed.get)]
        needed[key] = after[i]
    return misses


POLICIES = {"lru": lru, "clock": clock, "arc": arc, "s3fifo": s3fifo, "opt": opt}


class CacheSim(FurrowTest):
    def setUp(self):
        super().setUp()
        self.ok("synth", "-o", "hills.png", "--posts", "257x257", "--spacing", "1", "--relief", "40")
        self.ok("import", "hills.png", "-o", "hills.furrow", "--tile", "16")
        self.store = self.folder / "hills.furrow"
        self.scene(SCENE.replace("scene: 1", "scene: 1\nstore: hills.furrow"))

    def traced(self, *more):
        return self.drive("scene.yaml", "--trace", "t.trace", *more)

    def here(self):
        return sorted(path.name for path in self.folder.iterdir())

    def test_it_has_what_run_json_counts(self):
        run = self.traced()
        got = self.json("cache-sim", "t.trace")
        self.assertEqual(got["traced"]["pin"], {name: run["cache"][name] for name in ("hits", "misses")})
        self.assertEqual(got["traced"]["draw"], {"hits": 0, "misses": 0})
        self.assertEqual(got["accesses"], run["cache"]["hits"] + run["cache"]["misses"])
        self.assertEqual(got["tiles"], run["cache"]["touched"])
        self.assertGreater(got["tiles"], 40)
        accesses = decode((self.folder / "t.trace").read_bytes())
        self.assertEqual(sum(hit for _, _, _, hit in accesses), run["cache"]["hits"])
        self.assertLess(max(step for step, _, _, _ in accesses), run["steps"])

    def test_the_trace_changes_nothing_that_is_simulated(self):
        self.traced("--overlay", "a.furrow")
        with_trace = self.json("verify", "a.furrow")
        self.drive("scene.yaml", "--overlay", "b.furrow")
        self.assertEqual(with_trace, self.json("verify", "b.furrow"))

    def test_misses_are_those_of_policies_written_a_second_time(self):
        self.traced()
        self.ok("cache-sim", "t.trace", "--csv", "t.csv")
        lines = (self.folder / "t.csv").read_text().splitlines()
        self.assertEqual(lines[0], "time,obj_id,obj_size")
        rows = [tuple(map(int, line.split(","))) for line in lines[1:]]
        accesses = decode((self.folder / "t.trace").read_bytes())
        self.assertEqual(rows, [(step, key, 1) for step, key, _, _ in accesses])
        keys = [key for _, key, _ in rows]
        for options in ([], ["--slots", "64,1,3,20,33,3,500"]):
            got = self.json("cache-sim", "t.trace", *options)
            self.assertEqual(list(got["policies"]), list(POLICIES))
            for name, policy in POLICIES.items():
                misses = [policy(keys, slots) for slots in got["slots"]]
                self.assertEqual(got["policies"][name]["misses"], misses, name)
                for miss, ratio in zip(misses, got["policies"][name]["miss_ratio"]):
                    self.assertAlmostEqual(ratio, miss / len(keys))
        self.assertEqual(got["slots"], [1, 3, 20, 33, 64, 500])
        self.assertEqual(got["policies"]["opt"]["misses"][-1], got["tiles"])
        self.assertGreater(got["policies"]["lru"]["misses"][1], got["policies"]["opt"]["misses"][1])

    def test_default_sizes_go_up_to_all_tiles(self):
        self.traced()
        got = self.json("cache-sim", "t.trace")
        self.assertEqual(got["slots"][0], 4)
        self.assertEqual(got["slots"][-1], got["tiles"])
        self.assertEqual(got["slots"], sorted(set(got["slots"])))

    def test_a_picture_is_drawn_from_accesses_too(self):
        text = (self.folder / "scene.yaml").read_text()
        (self.folder / "scene.yaml").write_text(text + "view: {size: [64, 48], camera: {overhead: {over: a, height: 60}}, images: 1}\n")
        run = self.traced("--steps", "5")
        traced = self.json("cache-sim", "t.trace")["traced"]
        self.assertGreater(traced["draw"]["hits"], 0)
        self.assertEqual(traced["pin"], {name: run["cache"][name] for name in ("hits", "misses")})

    def test_table_and_plot(self):
        self.traced()
        result = self.furrow("cache-sim", "t.trace", "--policy", "opt,lru", "--slots", "8,16", "--plot", "t.svg")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        got = self.json("cache-sim", "t.trace", "--policy", "opt,lru", "--slots", "8,16")
        self.assertEqual(list(got["policies"]), ["lru", "opt"])
        table = result.stdout.splitlines()
        self.assertRegex(table[-3], r"slots +LRU +OPT +LRU/OPT")
        for i in range(2):
            misses = [got["policies"][name]["misses"][i] for name in ("lru", "opt")]
            row = table[-2 + i].split()
            self.assertEqual([int(row[0]), int(row[1]), int(row[3])], [8 << i, *misses])
            self.assertAlmostEqual(float(row[5]), misses[0] / misses[1], places=3)
        svg = xml.etree.ElementTree.parse(self.folder / "t.svg").getroot()
        self.assertEqual(svg.tag, "{http://www.w3.org/2000/svg}svg")
        curves = {group.get("id"): len(list(group.findall(".//{*}use"))) for group in svg.findall(".//{*}g") if group.get("id", "").startswith("curve-")}
        self.assertEqual(curves, {"curve-lru": 2, "curve-opt": 2})
        texts = [text.text for text in svg.findall(".//{*}text")]
        for text in ("LRU", "OPT", "slots", "misses", "8", "16"):
            self.assertIn(text, texts)

    def test_s3fifo_with_few_slots_is_explained(self):
        self.traced()
        few = self.furrow("cache-sim", "t.trace", "--policy", "s3fifo", "--slots", "19", "--json")
        self.assertIn("fewer than 20 slots", few.stderr)
        got = json.loads(few.stdout)
        self.assertEqual(got["policies"]["s3fifo"]["misses"], [got["accesses"]])
        self.assertEqual(self.furrow("cache-sim", "t.trace", "--policy", "s3fifo", "--slots", "20").stderr, "")

    def test_what_is_no_trace_is_refused_and_nothing_is_left(self):
        self.traced()
        data = (self.folder / "t.trace").read_bytes()
        bad = {"cut": data[:-1], "cut2": data[:len(data) // 2], "flip": data[:-30] + bytes([data[-30] ^ 1]) + data[-29:],
               "more": data + b"\0", "text": b"time,obj_id\n", "empty": b"", "version": data[:8] + b"\x02" + data[9:]}
        for name, content in bad.items():
            (self.folder / name).write_bytes(content)
        before = self.here()
        for name in (*bad, "absent", "out", "hills.furrow"):
            error = self.refused(3, "cache-sim", name, "--csv", "t.csv", "--plot", "t.svg")
            self.assertIn(name, error)
        self.assertEqual(self.here(), before)

    def test_wrong_usage(self):
        self.traced()
        before = self.here()
        self.assertIn("lru,clock,arc,s3fifo,opt", self.refused(2, "cache-sim", "t.trace", "--policy", "lru,fifo"))
        for policy in ("", "lru,", "LRU", "lr"):
            self.refused(2, "cache-sim", "t.trace", f"--policy={policy}")
        for slots in ("", "0", "-4", "4,,8", "4,", "4x", "1e3", "1000000001", "99999999999999999999", ",".join(map(str, range(1, 66)))):
            self.assertIn("slots", self.refused(2, "cache-sim", "t.trace", f"--slots={slots}"))
        self.refused(2, "cache-sim")
        self.refused(2, "cache-sim", "t.trace", "t.trace")
        self.assertIn("itself", self.refused(2, "cache-sim", "t.trace", "--csv", "./t.trace"))
        self.refused(2, "cache-sim", "t.trace", "--csv", "a", "--plot", "a")
        self.refused(1, "cache-sim", "t.trace", "--csv", "t.csv", "--plot", "no/where.svg")
        self.assertEqual(self.here(), before)
        result = self.furrow("cache-sim", "t.trace", "--plot", "t.svg", env={"FURROW_PYTHON": "./gone"})
        self.assertEqual((result.returncode, result.stderr), (1, "furrow: ./gone: No such file or directory; name a Python 3 in FURROW_PYTHON\n"))
        self.assertEqual(self.here(), before)

    def test_a_drive_that_cannot_begin_leaves_no_trace(self):
        (self.folder / "notes").write_text("not a trace")
        before = self.here()
        self.refused(3, "drive", "scene.yaml", "-o", "out", "--store", "absent.furrow", "--trace", "t.trace")
        self.assertEqual(self.here(), before)
        for name in ("notes", "hills.furrow"):
            result = self.furrow("drive", "scene.yaml", "-o", "out", "--trace", name)
            if result.returncode == 4:
                self.skipTest("no GL here")
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn("no trace", result.stderr)
        self.assertEqual((self.folder / "notes").read_text(), "not a trace")
        self.assertTrue(self.json("verify", "hills.furrow")["ok"])
        self.assertFalse((self.folder / "out" / "run.json").exists())
        self.assertEqual([name for name in self.here() if name.endswith(".part")], [])

    def endless(self):
        text = (self.folder / "scene.yaml").read_text().replace("end_time: 4", "end_time: 100000")
        (self.folder / "scene.yaml").write_text(text.replace("speed: 200", "speed: 200, loop: true"))

    def test_a_full_disk_under_the_trace_ends_the_drive_and_loses_nothing(self):
        self.endless()
        (self.folder / "t.trace.part").symlink_to("/dev/full")
        result = self.furrow("drive", "scene.yaml", "-o", "out", "--trace", "t.trace", "--overlay", "a.furrow")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"(?m)^furrow: t.trace: .*No space left.*; ")
        self.assertEqual([name for name in self.here() if name.startswith("t.trace")], [])
        run = json.loads((self.folder / "out" / "run.json").read_text())
        self.assertEqual(run["ended"], "failed")
        self.assertEqual(self.json("info", "a.furrow")["last_run"]["step"], run["steps"])
        self.drive("scene.yaml", "--overlay", "b.furrow", "--steps", run["steps"])
        self.assertEqual(self.json("verify", "a.furrow"), self.json("verify", "b.furrow"))

    def test_a_full_disk_at_the_traces_end_fails_the_drive(self):
        (self.folder / "t.trace.part").symlink_to("/dev/full")
        result = self.furrow("drive", "scene.yaml", "-o", "out", "--trace", "t.trace")
        if result.returncode == 4:
            self.skipTest("no GL here")
        self.assertEqual(result.returncode, 1, result.stderr)
        run = json.loads((self.folder / "out" / "run.json").read_text())
        self.assertEqual((run["ended"], run["steps"]), ("failed", 40))
        self.assertEqual(self.json("info", "hills.furrow")["last_run"]["step"], 40)
        self.assertFalse((self.folder / "t.trace").exists())

    def test_an_interrupted_drive_leaves_a_whole_trace(self):
        self.endless()
        process = subprocess.Popen([FURROW, "drive", "scene.yaml", "-o", "out", "--trace", "t.trace"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.until_committed(process)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=250)
        self.assertEqual(process.returncode, 130, errors)
        run = json.loads((self.folder / "out" / "run.json").read_text())
        got = self.json("cache-sim", "t.trace", "--policy", "lru")
        self.assertEqual(got["accesses"], run["cache"]["hits"] + run["cache"]["misses"])
        self.assertFalse((self.folder / "t.trace.part").exists())


if __name__ == "__main__":
    main()
