"""Benchmarks on the user's own store: `furrow bench STORE`, or furrow.bench.run("site.furrow").

What is timed are whole drives and imports by the program furrow, each of them one by one; ruts go to an overlay in a temporary folder, so the store stays as it
is. A figure is the median of its runs; its spread is their range. What no longer fits into the time is left out and named.
"""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any, Callable, Union

from furrow import _command
from furrow.results import ResultsError

ABOUT = """Benchmarks of a terrain store: what a page cache of each size and policy would miss, frames a second over picture sizes, milliseconds a step by
model and spacing, and posts a second of export and import. Ruts go to a temporary overlay.

  furrow bench site.furrow -o bench
  furrow bench site.furrow --quick --json"""

WHOLE, QUICK = 300.0, 60.0  # s of work at most
MODELS = (("none", ""), ("box", ""), ("sheet", ", yield: 0.1"), ("sumner", ", iterations: 2, interval: 0.02"), ("slippage", ", iterations: 2, interval: 0.02"), ("scm", ""))
SPACINGS = (0.125, 0.0625, 0.03125)  # m
SIZES = ((320, 180), (640, 360), (1280, 720), (1920, 1080))  # pixels
SLOTS = (8, 16, 32, 64, 128)
POLICIES = ("lru", "clock", "arc", "s3fifo", "opt")
S3FIFO_LEAST = 20  # slots: with fewer it takes nothing in
REACH = 8.0  # m: of the square in which the wheel drives
TRIES = 64  # places that are looked at for one with ground
WHEEL = "{name: wheel, shape: {wheel: {radius: 0.5, width: 0.3}}, sink: 0.05, path: {points: POINTS, speed: SPEED}}"

Path = Union[str, "pathlib.Path"]
Row = "dict[str, Any]"


class _Late(Exception):
    """The time is over."""


class _Bench:
    """One store, a temporary folder, and the time that is left."""

    def __init__(self, store: pathlib.Path, folder: pathlib.Path, quick: bool, say: "Callable[[str], None]") -> None:
        self.store, self.folder, self.say = store, folder, say
        self.program = os.environ.get("FURROW_PROGRAM") or "furrow"
        self.runs = 1 if quick else 3
        self.quick = quick
        self.left_out: "list[str]" = []
        self.until = time.monotonic() + WHOLE  # to find a place
        info = json.loads(self.furrow("info", store, "--json"))
        self.spacing = float(info["spacing"])
        self.extent = [(posts - 1) * self.spacing for posts in info["posts"]]
        self.tile = info["tile"] * self.spacing
        self.wheel = self._wheel()
        self.until = time.monotonic() + (QUICK if quick else WHOLE)

    def furrow(self, *arguments: Any) -> str:
        """What the program prints. ResultsError: it failed, with its own words. _Late: the time is over first."""
        left = self.until - time.monotonic()
        if left <= 0:
            raise _Late
        try:
            done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, timeout=left)
        except subprocess.TimeoutExpired:
            raise _Late from None
        if done.returncode != 0:
            errors = [line for line in done.stderr.splitlines() if not line.startswith("furrow: note:")]
            raise ResultsError((errors or [f"{self.program} {arguments[0]} ended with {done.returncode}"])[-1].removeprefix("furrow: "))
        return done.stdout

    def drive(self, scene: str, *options: Any) -> "dict[str, Any]":
        """run.json of a drive into an overlay of its own."""
        for old in self.folder.glob("ruts.furrow*"):
            old.unlink()
        (self.folder / "scene.yaml").write_text(scene, encoding="utf-8")
        self.furrow("drive", self.folder / "scene.yaml", "--store", self.store, "--overlay", self.folder / "ruts.furrow", "-o", self.folder / "out", *options)
        return json.loads((self.folder / "out/run.json").read_text(encoding="utf-8"))

    def median(self, name: str, work: "Callable[[], float]") -> "tuple[float, float, float] | None":
        """Median, least and most of some runs. None: left out, since no time is left."""
        self.say(name)
        found: "list[float]" = []
        try:
            for _ in range(self.runs):
                found.append(work())
        except _Late:
            if not found:
                self.left_out.append(name)
                return None
        return statistics.median(found), min(found), max(found)

    def _wheel(self) -> str:
        """A wheel on a way of 6.4 m where there is ground. ResultsError: none was found, or the store is too small."""
        if min(self.extent) < REACH:
            raise ResultsError(f"{self.store}: is {self.extent[0]:g} x {self.extent[1]:g} m; a bench needs {REACH:g} m each way")
        for i in range(TRIES):  # the middle first, then all over
            x, y = (((0.5 + i * step) % 1) * (extent - REACH) for extent, step in zip(self.extent, (0.618034, 0.754878)))
            places = [(x + REACH * u, y + REACH * v) for u, v in ((0, 0), (1, 0), (0, 1), (1, 1), (0.5, 0.5))]
            points = json.loads(self.furrow("query", self.store, "--json", *(f"{number:.6f}" for place in places for number in place)))["points"]
            if all(point["height"] is not None for point in points):
                way = [[x + 0.1 * REACH, y + REACH / 2], [x + 0.9 * REACH, y + REACH / 2]]
                return WHEEL.replace("POINTS", json.dumps(way)).replace("SPEED", "2")
        raise ResultsError(f"{self.store}: no ground was found in {TRIES} places; its posts are holes")


def _steps(bench: _Bench) -> "list[Row]":
    rows = []
    for model, more in MODELS:
        for spacing in SPACINGS:
            soil = "soil: {name: dry_sand}\n" if model in ("sumner", "slippage", "scm") else ""
            scene = (f"scene: 1\nend_time: {0.8 if bench.quick else 2.4}\ntime_step: 0.02\nspacing: {spacing}\n{soil}redistribute: {{model: {model}{more}}}\n"
                     f"objects:\n  - {bench.wheel}\n")
            found = bench.median(f"steps: {model}, posts {spacing:g} m", lambda: 1e3 / bench.drive(scene)["steps_per_second"]["mean"])
            if found:
                rows.append({"model": model, "spacing": spacing, "step_ms": found[0], "least": found[1], "most": found[2]})
    return rows


def _frames(bench: _Bench) -> "list[Row]":
    rows = []
    for width, height in SIZES:
        scene = (f"scene: 1\nend_time: 0.1\ntime_step: 0.02\nspacing: 0.125\nredistribute: {{model: box}}\nobjects:\n  - {bench.wheel}\n"
                 f"view: {{size: [{width}, {height}], camera: {{chase: wheel}}, effects: [texture, detail, fog, sky, geomorph, skirts, objects, shadow], images: 1}}\n")
        found = bench.median(f"frames: {width} x {height}", lambda: bench.drive(scene)["fps"]["p50"])
        if found:
            rows.append({"width": width, "height": height, "frames_per_second": found[0], "least": found[1], "most": found[2]})
    return rows


def _cache(bench: _Bench) -> "list[Row]":
    """A wheel that goes to and fro over the middle of the store, ten lanes a tile apart, once there and once back, looked at by no camera."""
    lanes = 4 if bench.quick else 10
    across = [min(extent * 0.9, lanes * bench.tile) for extent in bench.extent]
    x, y = ((bench.extent[k] - across[k]) / 2 for k in range(2))
    points = []
    for lane in range(lanes):
        at = y + across[1] * lane / max(1, lanes - 1)
        points += [[x, at], [x + across[0], at]] if lane % 2 == 0 else [[x + across[0], at], [x, at]]
    points += points[::-1]
    length = sum(((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 for a, b in zip(points, points[1:]))
    steps = 400 if bench.quick else 2000
    wheel = WHEEL.replace("POINTS", json.dumps(points)).replace("SPEED", f"{length / (steps * 0.05):.6f}")
    scene = (f"scene: 1\nend_time: {steps * 0.05}\ntime_step: 0.05\nredistribute: {{model: none}}\nobjects:\n  - {wheel}\ncache: {{slots: SLOTS}}\n")
    rows: "list[Row]" = []
    bench.say("cache: a trace")
    try:
        bench.drive(scene.replace("SLOTS", "1024"), "--trace", bench.folder / "trace")
        told = json.loads(bench.furrow("cache-sim", bench.folder / "trace", "--policy", ",".join(POLICIES), "--slots", ",".join(map(str, SLOTS)), "--json"))
    except _Late:
        bench.left_out.append("cache")
        return rows
    for index, slots in enumerate(SLOTS):
        row: "Row" = {"slots": slots, "tiles": told["tiles"], "accesses": told["accesses"]}
        row.update({policy: told["policies"][policy]["miss_ratio"][index] for policy in POLICIES if policy != "s3fifo" or slots >= S3FIFO_LEAST})
        bench.say(f"cache: {slots} slots")
        try:
            cache = bench.drive(scene.replace("SLOTS", str(slots)))["cache"]
            row.update({"hits": cache["hits"], "misses": cache["misses"], "stall_ms": cache["stall_ms"]})
        except _Late:
            bench.left_out.append(f"cache: {slots} slots")
        except ResultsError as error:  # so few slots may not hold a step's tiles
            row["refused"] = str(error)
        rows.append(row)
    return rows


def _tiles(bench: _Bench) -> "list[Row]":
    """Export of a square of posts reads and unpacks tiles; import packs and writes them, with their pyramid. The program's start counts."""
    most = 512 if bench.quick else 2048
    posts = 2
    while 2 * posts <= most and (2 * posts - 1) * bench.spacing <= min(bench.extent):
        posts *= 2
    across = (posts - 1) * bench.spacing
    x, y = (round((extent - across) / 2 / bench.spacing) * bench.spacing for extent in bench.extent)
    raw, again = bench.folder / "window.raw", bench.folder / "again.furrow"

    def timed(*arguments: Any) -> float:
        begun = time.monotonic()
        bench.furrow(*arguments)
        return posts * posts / (time.monotonic() - begun)

    rows = []
    for name, arguments in (("export", ("export", bench.store, "--window", f"{x:.9g},{y:.9g},{x + across:.9g},{y + across:.9g}", "-o", raw)),
                            ("import", ("import", raw, "-o", again, "--overwrite", "--spacing", f"{bench.spacing:.9g}"))):
        found = bench.median(f"tiles: {name} of {posts} x {posts} posts", lambda: timed(*arguments))
        if found is None:
            break
        rows.append({"what": name, "posts": posts * posts, "posts_per_second": found[0], "least": found[1], "most": found[2]})
    return rows


PARTS = (("steps", _steps), ("frames", _frames), ("cache", _cache), ("tiles", _tiles))


def run(store: Path, quick: bool = False, say: "Callable[[str], None]" = lambda text: None) -> "dict[str, Any]":
    """Benchmarks a store and returns {"store", "renderer", "processors", "runs", "seconds", "steps", "frames", "cache", "tiles", "left_out"}; each of the four a list of rows.

    quick: one run of each in about a minute, else three in five. say: called with what begins. The program is FURROW_PROGRAM, or furrow of the PATH.
    ResultsError: the store is none, is too small, or has no ground.
    """
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="furrow-bench-") as temporary:
        bench = _Bench(pathlib.Path(store), pathlib.Path(temporary), quick, say)
        out: "dict[str, Any]" = {"store": str(store), "processors": os.cpu_count(), "runs": bench.runs}
        for name, part in PARTS:
            out[name] = part(bench)
        gl = json.loads((bench.folder / "out/run.json").read_text(encoding="utf-8"))["gl"] if (bench.folder / "out/run.json").exists() else {}
    out["renderer"] = gl.get("renderer")
    out["left_out"] = bench.left_out
    out["seconds"] = time.monotonic() - begun
    return out


def table(told: "dict[str, Any]") -> str:
    """What run() returned, as text."""
    lines = [f"{told['store']}: {told['processors']} processors, GL {told['renderer']}; medians of {told['runs']} (least to most), {told['seconds']:.0f} s"]
    for row in told["steps"]:
        lines.append(f"step   {row['model']:9} posts {row['spacing']:<8g} m  {row['step_ms']:9.3f} ms ({row['least']:.3f} to {row['most']:.3f})")
    for row in told["frames"]:
        lines.append(f"frame  {row['width']:4} x {row['height']:<4} pixels      {row['frames_per_second']:9.2f} a second ({row['least']:.2f} to {row['most']:.2f})")
    for row in told["cache"]:
        simulated = ", ".join(f"{policy} {100 * row[policy]:.2f} %" for policy in POLICIES if policy in row)
        real = f"; here {row['misses']} of {row['hits'] + row['misses']}, {row['stall_ms']:.0f} ms waited" if "hits" in row else f"; here {row['refused']}" if "refused" in row else ""
        lines.append(f"cache  {row['slots']:4} slots, {row['tiles']} tiles: missed by {simulated}{real}")
    for row in told["tiles"]:
        lines.append(f"tiles  {row['what']:9} {row['posts']} posts: {row['posts_per_second'] / 1e6:.2f} million a second ({row['least'] / 1e6:.2f} to {row['most'] / 1e6:.2f})")
    lines += [f"not run, since the time was over: {name}" for name in told["left_out"]]
    return "\n".join(lines)


def plot(told: "dict[str, Any]", path: Path) -> None:
    """Draws what run() returned as an SVG or PNG of four parts. _command.Missing: matplotlib is not installed."""
    _command.need("matplotlib", "matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    figure = Figure(figsize=(11, 8), layout="constrained")
    FigureCanvasAgg(figure)
    steps, frames, cache, tiles = figure.subplots(2, 2).flat
    for model in dict.fromkeys(row["model"] for row in told["steps"]):
        rows = [row for row in told["steps"] if row["model"] == model]
        steps.errorbar([row["spacing"] for row in rows], [row["step_ms"] for row in rows], marker="o", label=model, capsize=3,
                       yerr=[[row["step_ms"] - row["least"] for row in rows], [row["most"] - row["step_ms"] for row in rows]])
    steps.set(xscale="log", yscale="log", xlabel="between posts, m", ylabel="a step, ms", title="Steps of one wheel")
    frames.plot([row["width"] * row["height"] / 1e6 for row in told["frames"]], [row["frames_per_second"] for row in told["frames"]], marker="o")
    frames.set(yscale="log", xlabel="million pixels", ylabel="frames a second", title=f"Pictures, {told['renderer']}")
    for policy in POLICIES:
        rows = [row for row in told["cache"] if policy in row]
        cache.plot([row["slots"] for row in rows], [100 * row[policy] for row in rows], marker="o", label=policy)
    rows = [row for row in told["cache"] if "hits" in row]
    cache.plot([row["slots"] for row in rows], [100 * row["misses"] / (row["hits"] + row["misses"]) for row in rows], "k--", marker="x", label="here, read ahead")
    cache.set(xscale="log", ylim=(0, None), xlabel="slots", ylabel="missed, %", title="Page cache")
    tiles.bar([row["what"] for row in told["tiles"]], [row["posts_per_second"] / 1e6 for row in told["tiles"]])
    tiles.set(ylabel="million posts a second", title="Tiles")
    for axes, at in ((steps, SPACINGS), (cache, SLOTS)):
        axes.set_xticks(at, [f"{number:g}" for number in at], minor=False)
        axes.set_xticks([], minor=True)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")
    for axes in (steps, frames, cache):
        axes.grid(True, alpha=0.3)
    figure.savefig(path)


def main(arguments: "list[str]") -> int:
    parser = _command.parser("bench", ABOUT)
    parser.add_argument("store")
    parser.add_argument("-o", dest="out")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)

    def work() -> None:
        told = run(given.store, given.quick, lambda text: print(f"furrow: bench: {text}", file=sys.stderr))
        print(json.dumps(told, indent=1) if given.json else table(told))
        if given.out is None:
            return
        out = pathlib.Path(given.out)
        out.mkdir(parents=True, exist_ok=True)
        with _command.Whole(out / "bench.json") as file:
            file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        with _command.Whole(out / "bench.svg") as file:
            plot(told, file)
        if not given.json:
            print(f"in {out}/bench.json and {out}/bench.svg")

    return _command.end("bench", work)
