"""Long drives in little memory: step times, waits and memory by slots, beside the same drive all resident.

    paging.py FURROW --big BIG.furrow --small SMALL.furrow [--quick] [--json FILE] [--plots FOLDER] ...

Prints a table a scene, then the bars and whether they are met; README.md says what is measured and how.
Nothing is asserted: a drive that fails is told and left out, and the exit status is 0 if the rest ran."""
import argparse
import hashlib
import json
import os
import pathlib
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time

import paging_plots
import paging_scenes
import record

BIG, SMALL = 65537, 16385  # posts of a side: 17 GB and 1 GB as floats
MARGIN = 64                # slots that the all-resident drive has beside those of the tiles it touches
SAMPLE = 0.2               # seconds between two looks at a drive's memory
LIMIT = 1200               # seconds that a drive may take
ALL = "all"                # a slot for every tile, loaded before the first step
POLICIES = ("lru", "clock", "arc", "s3fifo", "opt")
FIGURES = ("p50", "p95", "p99", "max", "seconds", "touched", "hits", "misses", "late", "not_begun", "stalls", "stalls_late",
           "stall_ms", "range_waits", "range_wait_ms", "naps", "nap_ms", "warm_s", "prefetched", "evictions", "writebacks", "tiles_read", "mb_read", "mb_written", "commits",
           "rss_mb", "growth", "rss_peak_mb", "wal_mb", "frame_p99", "starved")
GREATEST = ("p50", "p95", "p99", "max", "stalls", "stalls_late", "stall_ms")  # told of the run that had most, too
SHOWN = ("p50", "p95", "p99", "max", "misses", "late", "not_begun", "stalls", "stalls_late", "stall_ms", "tiles_read", "evictions",
         "writebacks", "commits", "mb_read", "mb_written", "rss_mb", "growth", "wal_mb")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow", type=pathlib.Path)
    parser.add_argument("--big", type=pathlib.Path, help=f"a terrain of {BIG} x {BIG} posts (made: minutes, 3 GB)")
    parser.add_argument("--small", type=pathlib.Path, help=f"one of {SMALL} x {SMALL}, the same ground (made)")
    parser.add_argument("--slots", type=lambda text: [int(n) for n in text.split(",")], help="64,256,1024")
    parser.add_argument("--scenes", type=lambda text: text.split(","), help="only those whose names begin so")
    parser.add_argument("--runs", type=int, help="of each drive, in turn (3; quick: 1)")
    parser.add_argument("--quick", action="store_true", help="shorter drives, 64 and 256 slots, one run of each")
    parser.add_argument("--json", type=pathlib.Path, help="where the JSON lines go")
    parser.add_argument("--plots", type=pathlib.Path, help="a folder for the pictures (SVG)")
    parser.add_argument("--folder", type=pathlib.Path, help="where the scratch files go (the system's)")
    parser.add_argument("--alone", action="store_true", help="no drive beside: none with all resident, over the small terrain, or for cache-sim")
    record.add_option(parser)
    options = parser.parse_args()
    options.slots = options.slots or ([64, 256] if options.quick else [64, 256, 1024])
    options.runs = options.runs or (1 if options.quick else 3)
    return options


# --- one drive ---

def watch(process, wal):
    """Resident memory over time, [(seconds, MB)], and the greatest size of the WAL, until the process ends."""
    began, samples, most = time.monotonic(), [], 0
    while process.poll() is None:
        now = time.monotonic() - began
        if now > LIMIT:
            raise RuntimeError(f"took longer than {LIMIT} s")
        try:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            samples += [(round(now, 2), int(line.split()[1]) / 1024)
                        for line in status.splitlines() if line.startswith("VmRSS:")]
            most = max(most, wal.stat().st_size)
        except OSError:
            pass  # it has just ended; no WAL yet
        time.sleep(SAMPLE)
    process.wait()
    return samples, most


def growth(samples):
    """By which share memory grows over the second half: twice from the third quarter's median to the fourth's.
    The last sample may be of a drive that frees already."""
    found = [mb for _, mb in samples[:-1]]
    if len(found) < 16:
        return None
    third, fourth = (statistics.median(found[len(found) * i // 4:len(found) * (i + 1) // 4]) for i in (2, 3))
    return 2 * (fourth - third) / third


def contents(overlay):
    """What a drive left: a hash over its rows, and the sum of offsets by level as `furrow verify` gives it."""
    database = sqlite3.connect(f"file:{overlay}?mode=ro", uri=True)
    rows = hashlib.sha256()
    for table in ('"offset"', "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "healed", "risen", "grown"):
        for row in database.execute(f"SELECT key, hash FROM {table} ORDER BY key"):
            rows.update(b"%d %d\n" % row)
    sums = dict(database.execute('SELECT (key >> 56) - 32, sum(below + above) FROM "offset" GROUP BY 1 ORDER BY 1'))
    database.close()
    return rows.hexdigest(), {str(level): found for level, found in sums.items()}


def figures(report, samples, wal):
    """{figure: number or None}, of those in FIGURES."""
    cache, io, view = report["cache"], report["io"], report.get("view", {})
    stable = [mb for at, mb in samples if at >= samples[-1][0] / 2]
    found = {**report["step_ms"], **cache, "seconds": report["seconds"], "tiles_read": io["tiles_read"],
             "mb_read": io["bytes_read"] / 1e6, "mb_written": io["bytes_written"] / 1e6, "commits": io["commits"],
             "rss_mb": statistics.mean(stable), "growth": growth(samples), "wal_mb": wal / 1e6,
             "rss_peak_mb": report["memory"]["rss_peak"] / 1e6, "starved": view.get("starved"),
             "frame_p99": 1e3 / report["fps"]["p99"] if report["fps"] else None, "naps": view.get("naps"), "nap_ms": view.get("nap_ms"),
             "warm_s": report.get("warm_up", {}).get("seconds"),
             # those after the first second; of a program that does not count them apart, all
             "stalls_late": cache.get("stalls_late", cache["stalls"])}
    return {name: found.get(name) for name in FIGURES}


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.lines, self.bars, self.failed, self.gl = [], [], 0, None
        self.kept = record.Record("paging", options.furrow)

    def note(self, **line):
        """A line of JSON; --json holds what is known so far whatever comes."""
        self.lines.append({"bench": "paging", **line})
        if self.options.json:
            self.options.json.write_text("".join(json.dumps(line) + "\n" for line in self.lines))

    def furrow(self, *arguments):
        done = subprocess.run([str(a) for a in (self.options.furrow, *arguments)], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip() or f"{arguments[0]}: status {done.returncode}")
        return done.stdout

    def terrain(self, path, side, name):
        if path is None:
            path = self.folder / name
            print(f"paging.py: making {path}", file=sys.stderr, flush=True)
            self.furrow("synth", "-o", path, "--posts", f"{side}x{side}", "--spacing", 1, "--kind", "ridged")
        posts = json.loads(self.furrow("info", path, "--json"))["posts"]
        self.note(terrain=name, posts=posts, bytes=path.stat().st_size)
        return path

    def drive(self, scene, terrain, slots, run=0, prefetch=None, trace=None, verify=False):
        """The figures of a drive into a new overlay, which is removed; None if it failed, which is told."""
        label = f"{scene.name}, {terrain.name}, {slots} slots{', all resident' if prefetch else ''}"
        try:
            found = self.driven(scene, terrain, slots, prefetch, trace, verify)
        except (RuntimeError, OSError, ValueError, KeyError, sqlite3.Error) as problem:
            self.failed += 1
            self.note(scene=scene.name, terrain=terrain.name, slots=slots, run=run, failed=str(problem))
            print(f"paging.py: {label}: FAILED: {problem}", file=sys.stderr, flush=True)
            return None
        self.note(scene=scene.name, terrain=terrain.name, slots=slots, all_resident=bool(prefetch), run=run, **found)
        print(f"paging.py: {label}: {found['seconds']:.1f} s, p99 {found['p99']:.2f} ms, {found['rss_mb']:.0f} MB",
              file=sys.stderr, flush=True)
        return found

    def driven(self, scene, terrain, slots, prefetch, trace, verify):
        with tempfile.TemporaryDirectory(prefix="drive-", dir=self.folder) as name:
            folder = pathlib.Path(name)
            overlay = folder / "overlay.furrow"
            command = [self.options.furrow, "drive", scene.write(folder), "--store", terrain, "--overlay", overlay,
                       "-o", folder, "--set", f"cache.slots={slots}"]
            command += ["--set", f"cache.prefetch={prefetch}"] if prefetch else []
            command += ["--trace", trace] if trace else []
            with open(folder / "said", "w") as said:
                process = subprocess.Popen([str(c) for c in command], stdout=said, stderr=said)
                try:
                    samples, wal = watch(process, folder / "overlay.furrow-wal")
                except BaseException:
                    process.kill()
                    process.wait()
                    raise
            if process.returncode != 0 or not samples:
                raise RuntimeError((folder / "said").read_text().strip()[-500:] or f"status {process.returncode}")
            report = json.loads((folder / "run.json").read_text())
            self.gl = report["gl"]
            self.kept.seen(report)
            rows, sums = contents(overlay)
            found = figures(report, samples, wal)
            found.update(rows=rows, offset_sum=sums, quanta=report["volume"]["quanta"], memory=samples)
            if verify:
                check = json.loads(self.furrow("verify", overlay, "--json"))
                if not check["ok"] or {k: v for k, v in check["offset_sum"].items() if v} != \
                        {k: v for k, v in sums.items() if v}:
                    raise RuntimeError(f"verify: {check}")
            return found


# --- scenes ---

def medians(runs):
    """Of each figure over the runs that have it."""
    columns = {name: [run[name] for run in runs if run[name] is not None] for name in FIGURES}
    return {name: statistics.median(found) if found else None for name, found in columns.items()}


def greatest(runs):
    """Of each of these figures, the most that one run had: what a median hides."""
    columns = {name: [run[name] for run in runs if run[name] is not None] for name in GREATEST}
    return {name: max(found) if found else None for name, found in columns.items()}


def measure(bench, scene, terrain, slots, verify=False):
    """Drives that take turns: {slots or ALL: medians, with "greatest" of some}; whether all left the same rows, None if there is nothing to
    compare; {slots or ALL: memory over time} of the first."""
    runs = {count: [] for count in [*slots, ALL]}
    touched = None
    for run in range(bench.options.runs):
        for count in slots:
            runs[count].append(bench.drive(scene, terrain, count, run, verify=verify and run == 0))
            if runs[count][-1]:
                touched = runs[count][-1]["touched"]
        if touched and not bench.options.alone:  # with a horizon beyond the end, what lies on the paths is loaded before the first step
            runs[ALL].append(bench.drive(scene, terrain, max(*slots, touched + MARGIN), run, prefetch=3600))
    kept = {count: [run for run in found if run] for count, found in runs.items()}
    left = {(run["rows"], json.dumps(run["quanta"])) for found in kept.values() for run in found}
    first = {count: found[0]["memory"] for count, found in kept.items() if found}
    same = len(left) == 1 if len(first) > 1 else None
    return {count: {**medians(found), "greatest": greatest(found), "runs": len(found)} for count, found in kept.items() if found}, same, first


def simulate(bench, scene, terrain, slots):
    """{policy: {slots: misses}} of caches that only fetch on demand, from a trace of one more drive."""
    if bench.options.alone or "--trace" not in bench.furrow("drive", "--help"):
        return {}
    trace = bench.folder / f"{scene.name}.trace"
    if bench.drive(scene, terrain, slots[-1], run="trace", trace=trace) is None:
        return {}
    try:
        text = ",".join(map(str, slots))
        found = json.loads(bench.furrow("cache-sim", trace, "--json", "--slots", text, "--policy", ",".join(POLICIES)))
        if bench.options.plots:
            bench.furrow("cache-sim", trace, "--plot", bench.options.plots / f"misses {scene.name}.svg")
    except (RuntimeError, ValueError) as problem:
        bench.failed += 1
        print(f"paging.py: cache-sim, {scene.name}: FAILED: {problem}", file=sys.stderr, flush=True)
        return {}
    finally:
        trace.unlink(missing_ok=True)
    misses = {policy: dict(zip(found["slots"], found["policies"][policy]["misses"])) for policy in POLICIES}
    bench.note(scene=scene.name, simulated=misses)
    return misses


# --- what is printed ---

def number(value):
    if value is None:
        return "-"
    return f"{value:,.0f}" if abs(value) >= 1000 or value == int(value) else f"{value:.3g}"


def print_rows(rows):
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.rjust(w) if i else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths))).rstrip())


def print_greatest(found):
    """The worst run by each figure; nothing where there was one run."""
    if all(median["greatest"][name] == median[name] for median in found.values() for name in GREATEST):
        return
    print("the greatest of the runs:")
    print_rows([("slots", *GREATEST)] +
               [(str(count), *(number(median["greatest"][name]) for name in GREATEST)) for count, median in found.items()])


def print_scene(scene, found, misses):
    touched = next((median["touched"] for median in found.values()), None)
    print(f"\n{scene.name}: {scene.metres / 1e3:.3g} km, {len(scene.drives)} x four wheels, posts "
          f"{scene.spacing} m apart, {number(touched)} tiles touched")
    simulated = [policy for policy in POLICIES if policy in misses]
    rows = [("slots", *SHOWN, "p99 of all", *(f"sim {policy}" for policy in simulated))]
    for count, median in found.items():
        beside = median["p99"] / found[ALL]["p99"] if ALL in found else None
        rows.append((str(count), *(number(median[name]) for name in SHOWN), number(beside),
                     *(number(misses[policy].get(count)) for policy in simulated)))
    print_rows(rows)
    print_greatest(found)


class Bars:
    def __init__(self, bench):
        self.bench, self.rows = bench, [("bar", "data", "figure", "limit", "met")]

    def add(self, what, data, figure, limit, met, unit=""):
        if figure is None or limit is None:
            return
        self.rows.append((what, data, number(figure) + unit, number(limit) + unit, "yes" if met else "NOT met"))
        self.bench.note(bar=what, data=data, figure=figure, limit=limit, unit=unit, met=met)


def scene_bars(bars, name, found, same, misses):
    everything = found.get(ALL)
    if everything:
        for figure, most in (("misses", everything["misses"]), ("stalls", everything["greatest"]["stalls"])):
            bars.add(f"all resident: {figure}", name, most, 0, most == 0)
    if everything and 256 in found:
        limit = max(1.2 * everything["p99"], everything["p99"] + 1)
        bars.add("step p99, 256 slots", name, found[256]["p99"], limit, found[256]["p99"] <= limit, " ms")
    bars.add("contents that differ by slots", name, None if same is None else int(not same), 0, same)
    for count, median in found.items():
        if count == ALL:
            continue
        stalls = median["greatest"]["stalls_late"]
        bars.add("stalls after the first second", f"{name}, {count} slots", stalls, 0, stalls == 0)
        faults = misses.get("lru", {}).get(count)
        waits = median["late"] + (median["not_begun"] or 0) + median["stalls"]
        if faults is not None:
            bars.add("late and stalled, of LRU's faults", f"{name}, {count} slots", waits, faults / 10,
                     waits <= faults / 10)


def policy_bars(bars, simulated):
    """LRU against OPT over the scenes that do not fit; those that hardly do not (a lap of them is LRU's worst)
    apart. `simulated`: [(name, touched, misses)]. Returns the summed ratio by slots."""
    sums = {}
    for name, touched, misses in simulated:
        for count, lru in misses.get("lru", {}).items():
            opt = misses["opt"][count]
            if count < touched <= 1.25 * count:
                bars.add("LRU / OPT, tiles just over slots", f"{name}, {count} slots", lru / opt, 1.5, lru <= 1.5 * opt)
            elif touched > count:
                total = sums.setdefault(count, [0, 0])
                total[0] += lru
                total[1] += opt
    for count, (lru, opt) in sums.items():
        bars.add("LRU / OPT, summed", f"{count} slots", lru / opt, 1.5, lru <= 1.5 * opt)
    return {count: lru / opt for count, (lru, opt) in sums.items()}


def memory_bars(bars, big, small):
    """Memory grows while slots fill: no bar for a drive that fills them late."""
    for count, median in big.items():
        if count == ALL:
            continue
        if median["growth"] is not None and median["touched"] >= 4 * count:
            bars.add("memory's growth, second half", f"straight, {count} slots", 100 * median["growth"], 1,
                     median["growth"] < 0.01, " %")
        if count in small:
            ratio = median["rss_mb"] / small[count]["rss_mb"]
            bars.add("memory, big terrain / small", f"straight, {count} slots", ratio, 1.1, ratio <= 1.1)


def keep(kept, name, found, misses):
    """Figures of a scene, by its number of slots."""
    units = {"p50": "ms", "p99": "ms", "rss_mb": "MB", "growth": "times", "touched": "", "stalls": "", "stalls_late": ""}
    for count, median in found.items():
        for figure, unit in units.items():
            if median[figure] is not None:
                kept.add(f"{name}.{'all' if count == ALL else count}.{figure}", median[figure], unit, runs=median["runs"])
    kept.add(f"{name}.any.stalls_late", max(median["greatest"]["stalls_late"] for median in found.values()), "")
    for policy in ("lru", "opt"):
        for count, missed in misses.get(policy, {}).items():
            kept.add(f"{name}.{count}.misses_{policy}", missed, "")


# --- all of it ---

def write_plots(folder, results, slots, memory):
    folder.mkdir(parents=True, exist_ok=True)
    groups = [(name, [found.get(count, {}).get("p99") for count in [*slots, ALL]]) for name, found in results.items()]
    legend = [*(f"{count} slots" for count in slots), "all resident"]
    (folder / "p99.svg").write_text(paging_plots.bars("99th percentile of a step", "ms", groups, legend))
    (folder / "memory.svg").write_text(paging_plots.lines("Resident memory, straight drive", "MB", memory))


def wanted(options, name):
    return options.scenes is None or any(name.startswith(start) for start in options.scenes)


def run(bench):
    options = bench.options
    big = bench.terrain(options.big, BIG, "big.furrow")
    bars, results, simulated, memory = Bars(bench), {}, [], []
    for scene, only in paging_scenes.scenes(options.slots, options.quick):
        if not wanted(options, scene.name):
            continue
        slots = [only] if only else options.slots
        found, same, samples = measure(bench, scene, big, slots)
        misses = simulate(bench, scene, big, slots)
        results[scene.name] = found
        for count, median in found.items():
            bench.note(scene=scene.name, slots=count, median=median)
        print_scene(scene, found, misses)
        scene_bars(bars, scene.name, found, same, misses)
        simulated.append((scene.name, next((m["touched"] for m in found.values()), 0), misses))
        keep(bench.kept, scene.name.replace(" ", "_"), found, misses)
        if scene.name == "straight" and not options.alone:
            small = bench.terrain(options.small, SMALL, "small.furrow")
            found_small, _, samples_small = measure(bench, scene, small, options.slots, verify=True)
            print_scene(scene, found_small, {})
            memory_bars(bars, found, found_small)
            for count in set(found) & set(found_small):
                bench.kept.add(f"straight.{count}.big_to_small", found[count]["rss_mb"] / found_small[count]["rss_mb"], "times")
            memory = [(f"big, {count}", line) for count, line in samples.items()]
            memory += [(f"small, {count}", line) for count, line in samples_small.items()]
    for count, ratio in policy_bars(bars, simulated).items():
        bench.kept.add(f"lru_to_opt.{count}", ratio, "times")
    if wanted(options, "picture"):
        pictures(bench, big)
    print()
    print_rows(bars.rows)
    if options.plots:
        write_plots(options.plots, results, options.slots, memory)


def pictures(bench, terrain):
    """A drive with a picture of each step, which waits for its tiles."""
    scene = paging_scenes.picture(bench.options.quick)
    found, _, _ = measure(bench, scene, terrain, [count for count in bench.options.slots if count <= 256])
    for count, median in found.items():
        bench.note(scene=scene.name, slots=count, median=median)
    print(f"\npicture: {scene.metres:.0f} m behind a vehicle, 640 x 360")
    names = ("frame_p99", "p99", "naps", "nap_ms", "stalls", "range_waits", "range_wait_ms", "late", "not_begun", "warm_s", "rss_mb")
    rows = [("slots", "frame p99 ms", "step p99 ms", *names[2:])]
    rows += [(str(count), *(number(median[name]) for name in names)) for count, median in found.items()]
    print_rows(rows)
    print_greatest(found)


def main():
    options = parse()
    options.furrow = options.furrow.resolve()
    with tempfile.TemporaryDirectory(prefix="furrow-paging-", dir=options.folder) as name:
        bench = Bench(options, pathlib.Path(name))
        if options.plots:
            options.plots.mkdir(parents=True, exist_ok=True)
        run(bench)
    if bench.failed == 0:
        bench.kept.write(options.figures)
    print(f"\n{bench.failed} drives failed; {os.cpu_count()} cores; GL: "
          f"{bench.gl['renderer'] + ', ' + bench.gl['version'] if bench.gl else 'none'}")


if __name__ == "__main__":
    main()
