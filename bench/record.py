"""The file of figures that a bench leaves: bench/figures/NAME.json. Pages show its figures (bench/marks.py).

    record = Record("track", options.furrow)
    record.add("step_ms", [0.226, 0.231, 0.229], "ms")     # of several runs the median, with the least and the most
    record.write(options.figures)

A file says which commit, build and machine its figures are of, and how busy the machine was. bench/record.c writes the same for
benches in C. Figures that no bench of today measures have a `source` instead, in words: a publication, or what is known of the run.
"""
import datetime
import json
import math
import os
import pathlib
import platform
import re
import shlex
import statistics
import subprocess
import sys

from pages import Told, aside

ROOT = pathlib.Path(__file__).resolve().parents[1]
FIGURES = ROOT / "bench" / "figures"
# What a file of a bench has, and what each of them is.
FIELDS = {"bench": str, "command": str, "commit": str, "dirty": bool, "date": str, "machine": dict, "build": (dict, type(None)),
          "load": list, "figures": dict}
OTHERWISE = {"bench": str, "source": str, "figures": dict}
MACHINE = {"cpu": str, "cores": int, "memory": int, "renderer": (str, type(None))}
# A program of bench/ is made anew for each commit, which it has in it. That is no other program.
COMMIT = re.compile(r"bench_commit\.h|libfurrow_bench\.a\.p/record\.c\.o|Linking static target bench/libfurrow_bench\.a|Linking target bench/")
BUILD = {"type": str, "asserts": bool, "sanitizers": str}


def add_option(parser):
    parser.add_argument("--figures", type=pathlib.Path, metavar="FILE", help="a file for the figures that pages show, as bench/figures/NAME.json")


def said(*command):
    """What a command prints, or None if it fails."""
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    except OSError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def machine(renderer):
    cpu = next((line.partition(":")[2].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")),
               platform.machine())
    return {"cpu": cpu, "cores": len(os.sched_getaffinity(0)), "memory": os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"), "renderer": renderer}


def build_of(program):
    """The options of the build folder that has `program`, and whether the program is older than its sources."""
    program = pathlib.Path(program).resolve()
    folder = next((folder for folder in program.parents if (folder / "meson-info" / "intro-buildoptions.json").is_file()), None)
    if folder is None:
        raise Told(f"{program}: is in no build folder of meson, so nothing says how it was built; give the command of a build folder")
    options = {option["name"]: option["value"] for option in json.loads((folder / "meson-info" / "intro-buildoptions.json").read_text())}
    asserts = options["b_ndebug"] == "false" or options["b_ndebug"] == "if-release" and options["buildtype"] not in ("release", "plain")
    wanting = said("ninja", "-C", str(folder), "-n", str(program.relative_to(folder)))
    stale = wanting is None or any(re.match(r"\[\d+/\d+\] ", line) and not COMMIT.search(line) for line in wanting.splitlines())
    return {"type": options["buildtype"], "asserts": asserts, "sanitizers": options["b_sanitize"]}, stale


def changed():
    """Whether a tracked file differs from the commit. Pages and figures do not count, since no program is made of them."""
    return said("git", "status", "--porcelain", "--untracked-files=no", "--", ".", ":!*.md", ":!bench/figures", ":!docs/accuracy-*.svg") != ""


def shown(argument):
    """The argument, to be written down. Of a path outside the project it keeps the file name alone, since its folders are of this machine."""
    path = pathlib.Path(argument)
    if path.is_absolute():
        return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else f".../{path.name}"
    return argument


class Record:
    """Made before the first measurement, since it looks at the machine's load."""

    def __init__(self, bench, program, command=None):
        """program: what is measured, in its build folder; None if the script alone makes its figures. command: words of a command line, if not this script's own."""
        self.bench, self.command = bench, command or ["python3", *sys.argv]
        self.program, self.load, self.renderer, self.figures, self.parts = program, os.getloadavg()[0], None, {}, {}

    def seen(self, run):
        """Takes the renderer's name from the run.json of a drive."""
        self.renderer = run["gl"]["renderer"]

    def page(self, name, text):
        """A part of a page that the bench writes whole, between the markers of `name`; "PAGE NAME" where several pages have such markers."""
        self.parts[name] = text.strip().split("\n")

    def add(self, key, values, unit, runs=None):
        """One figure: a number, or the list of what several runs gave. unit: as a page writes it, "" without one. runs: of how many runs a
        number is the median, where each run's is not known."""
        values = list(values) if isinstance(values, (list, tuple)) else [values]
        if key in self.figures or not values or not all(math.isfinite(value) for value in values):
            raise Told(f"{self.bench}: {key}: is there twice or is no number ({values}); mend the bench")
        figure = {"value": statistics.median(values), "unit": unit, "runs": runs or len(values)}
        if len(values) > 1:
            figure.update(low=min(values), high=max(values))
        self.figures[key] = figure

    def write(self, path):
        """Nothing without a path."""
        if path is None:
            return
        commit = said("git", "rev-parse", "HEAD")
        if commit is None:
            raise Told(f"{path}: {ROOT} is no checkout of git, so no commit is known; measure in one")
        build, stale = (None, False) if self.program is None else build_of(self.program)
        path.parent.mkdir(parents=True, exist_ok=True)
        with aside(path) as file:
            parts = {"parts": self.parts} if self.parts else {}
            file.write(text({"bench": self.bench, "command": shlex.join(map(shown, self.command)), "commit": commit, "dirty": stale or changed(),
                             "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"), "machine": machine(self.renderer),
                             "build": build, "load": [round(self.load, 2), round(os.getloadavg()[0], 2)], **parts, "figures": self.figures}))


def text(record):
    """JSON with a line for each figure, so that a change of one is a line of a patch."""
    head = json.dumps({key: value for key, value in record.items() if key != "figures"}, indent=1)[:-2]
    rows = ",\n".join(f"  {json.dumps(key)}: {json.dumps(figure)}" for key, figure in record["figures"].items())
    return f'{head},\n "figures": {{\n{rows}\n }}\n}}\n'


def lacks(record, fields, where=""):
    """Names of fields that are missing, that are of another kind, or that nobody knows."""
    wrong = [where + name for name, kind in fields.items() if not isinstance(record.get(name, ...), kind)]
    return wrong + [where + name for name in record if name not in fields]


def faults(record):
    """What is wrong with a file's contents, a line each."""
    fields = OTHERWISE if "source" in record else FIELDS
    wrong = lacks({key: value for key, value in record.items() if key != "parts"}, fields)
    if wrong:
        return wrong
    if not record["figures"] and not record.get("parts"):
        return ["figures: none, and no part of a page"]
    if fields is FIELDS:
        wrong = lacks(record["machine"], MACHINE, "machine.") + (lacks(record["build"], BUILD, "build.") if record["build"] is not None else [])
        if len(record["commit"]) != 40 or len(record["load"]) != 2:
            wrong.append("commit, load")
    elif len(record["source"].split()) < 5:
        wrong.append("source: says too little")
    for key, figure in record["figures"].items():
        value, low, high = (figure.get(name, figure.get("value")) for name in ("value", "low", "high"))
        known = set(figure) - {"low", "high"} == {"value", "unit", "runs"} and ("low" in figure) == ("high" in figure)
        if not known or not isinstance(value, (int, float)) or not math.isfinite(value) or not low <= value <= high or not figure["runs"] >= 1:
            wrong.append(f"figures.{key}")
    return wrong
