"""What bench/accuracy.py makes of the lines: studies, how their values read, and which points no other beats.

A line is one setting of one study's knobs: {"study", "knobs", "default", "truth", "error" or "picture" or "off" or none of them, "ms_step",
"ms_runs", "cost", "bytes", "bytes_of", "gl"}. Errors are metres and cubic metres, pictures decibels and steps of 255. "off" is any other error:
{"what", "value", "floor"}, where less than the floor is not known of the truth itself. "truth" says what the errors are against: points of
different truths are never compared. "ms_step" is the median of "ms_runs", of which `cost` tells the unit if it is not a step.
"source" in place of runs: the line is of another program, measured elsewhere. Such a time has no spread, so it is on no front."""
import json
import math

from pages import Told, figure, size

# In the order of the tables. title, and what is turned.
STUDIES = {
    "spacing": ("Spacing of posts, by model", "how far the posts lie apart where the ground is worked on"),
    "sheet": ("Spacing of posts, under an elastic sheet", "how far the posts lie apart; the sheet bends over 0.1 m, and yields at 5 cm"),
    "divided": ("Spacing, over a coarser store", "spacing, over a store of 1 m posts that is divided where the wheel goes"),
    "settled": ("Spacing, slid to rest", "spacing, and with it as much sliding as it asks for: 8 iterations at an interval that goes with its square"),
    "base_format": ("Format of the base", "how the imported heights are kept"),
    "offset_format": ("Format of the offset", "how the ruts are kept"),
    "iterations": ("Iterations of sliding", "iterations in a contact and in an interval"),
    "tolerance": ("Tolerance of sliding", "the excess below which soil is stable"),
    "interval": ("Interval of sliding", "time between the ground's own steps"),
    "time_step": ("Time step", "the simulation's step"),
    "import_error": ("Error of the import", "the bound that the stored heights are held to"),
    "durability": ("Durability", "what a commit waits for"),
    "pairs": ("Two knobs at once", "both"),
    "pixel_error": ("Pixel error", "how many pixels a level may be off"),
    "samples": ("Samples of a pixel", "`view.samples`. The truth has 9 pixels with 4 samples each in place of one"),
    "imagery": ("Imagery", "how fine the pictures over the terrain are drawn"),
    "force": ("Force against time", "spacing, of bodies on dry sand under 600 N: a wheel at slip 0.2, one with bars at slip 0.3, a blade 10 cm deep"),
    "force_soft": ("Force against time, beside Project Chrono", "spacing, of a wheel of 0.5 m under 5 kN at slip 0.2 on Chrono's soft soil, with vertical normals"),
    "faces": ("Faces", "`redistribute.faces` and spacing, for a wheel with bars. The truth has faces"),
    "tyres": ("Tyres", "a tyre of 25 kN/m or a rigid wheel in its place, and spacing. The truth has the tyre"),
    "mesh_triangles": ("Triangles of a mesh", "of how many a ball is that is dragged through the soil"),
    "vehicle_step": ("Time step of a vehicle", "the step of MuJoCo and the soil, for a four-wheel vehicle"),
    "slots": ("Slots", "`cache.slots`: tiles that may be resident. The ground is the same, to the bit"),
}
RUNS = 5  # of each setting, in turn: fewer are not published
NEEDED = {"study": str, "knobs": dict, "default": bool, "ms_step": (int, float)}


def parse(text, where):
    """One line: what it says, or None where it is of another bench."""
    try:
        line = json.loads(text)
    except ValueError as error:
        raise Told(f"{where}: not JSON ({error}): {text.strip()[:60]!r}; take what bench_accuracy printed") from None
    if not isinstance(line, dict) or line.get("bench") != "accuracy":
        return None
    for name, kind in NEEDED.items():
        if not isinstance(line.get(name), kind):
            raise Told(f"{where}: {name!r} is missing or of the wrong kind; take what bench_accuracy printed")
    for part in ("error", "picture", "off"):
        line.setdefault(part, None)
    runs = line.setdefault("ms_runs", [])
    if not isinstance(runs, list) or not all(isinstance(ms, (int, float)) and math.isfinite(ms) and ms > 0 for ms in runs):
        raise Told(f"{where}: 'ms_runs' is no list of times; take what bench_accuracy printed")
    if runs and not min(runs) * (1 - 1e-4) <= line["ms_step"] <= max(runs) * (1 + 1e-4):
        raise Told(f"{where}: 'ms_step' is not between its runs; take what bench_accuracy printed")
    if line["off"] and not all(isinstance(line["off"].get(name), kind) for name, kind in (("what", str), ("value", (int, float)), ("floor", (int, float)))):
        raise Told(f"{where}: 'off' lacks what, value or floor; take what bench_accuracy printed")
    line.setdefault("bytes", None)
    return line


def length(metres):
    for unit, name in ((1, "m"), (1e-2, "cm"), (1e-3, "mm")):
        if metres >= unit:
            return f"{metres / unit:g} {name}"
    return f"{metres * 1e6:g} µm" if metres else "0"


def fraction(metres):
    """Spacings are halves of halves."""
    if 0 < metres < 1 and math.frexp(metres)[0] == 0.5:
        return f"1/{1 / metres:.0f} m"
    return length(metres)


def duration(seconds):
    return f"{seconds:g} s" if seconds >= 1 or seconds == 0 else f"{seconds * 1e3:g} ms"


UNITS = {"spacing": fraction, "import_error": length, "tolerance": length, "time_step": duration, "interval": duration,
         "pixel_error": "{:g} px".format, "posts": length, "size": length}
ABSENT = {"pixel_error": "by radii"}  # of null


def value(knob, said):
    """A knob's value as it reads in a plot."""
    if said is None:
        return ABSENT.get(knob, "none")
    if isinstance(said, bool):
        return "yes" if said else "no"
    if isinstance(said, (int, float)):
        return UNITS.get(knob, "{:g}".format)(said)
    return str(said)


class Study:
    """The lines of one study that turn the same knobs. `varied`: those knobs; `series`: the one that colours the plot's
    points, or None; the others label them."""

    def __init__(self, name, lines):
        self.lines = lines
        knobs = list(dict.fromkeys(knob for line in lines for knob in line["knobs"]))
        self.varied = [k for k in knobs if len({json.dumps(line["knobs"].get(k)) for line in lines}) > 1] or knobs[:1]
        self.study, self.name = name, name
        self.title, self.what = STUDIES.get(name, (name, "see its knobs"))
        if name == "pairs":
            turned = [knob for knob in knobs if knob != "model"]
            self.name = "_".join(["pairs", *turned])
            self.title = " and ".join(turned).replace("_", " ").capitalize()
        others = [knob for knob in self.varied if knob != "model"]
        self.series = "model" if "model" in self.varied and others else self.varied[0] if len(self.varied) > 1 else None
        if self.series and len({json.dumps(line["knobs"].get(self.series)) for line in lines}) == len(lines):
            self.series = None  # a colour for each point says nothing
        self.varied.sort(key=lambda knob: knob != self.series)

    def cost(self, line):
        """ms. With another time step a step does other work: then of a simulated second."""
        return line["ms_second"] if self.by_second() else line["ms_step"]

    def spread(self, line):
        """The least and the most of the runs, in the unit of cost(). None of a line without runs."""
        each = self.cost(line) / line["ms_step"]
        return (min(line["ms_runs"]) * each, max(line["ms_runs"]) * each) if line["ms_runs"] else None

    def range_of_cost(self, line):
        """(least, median, most). The first and the last are None where there is no spread."""
        ends = self.spread(line) or (None, None)
        return ends[0], self.cost(line), ends[1]

    def truths(self):
        return list(dict.fromkeys(truth(line) for line in self.lines))

    def by_second(self):
        return "time_step" in self.varied and all("ms_second" in line for line in self.lines)

    def cost_title(self):
        if "cost" in self.lines[0]:
            return self.lines[0]["cost"]
        return "ms a frame" if self.of_pictures() else "ms a simulated second" if self.by_second() else "ms a step"

    def label(self, line):
        return ", ".join(value(knob, line["knobs"].get(knob)) for knob in self.varied if knob != self.series)

    def labelled(self):
        """What label() is of."""
        return ", ".join(knob.replace("_", " ") for knob in self.varied if knob != self.series)

    def whole_label(self, line):
        return ", ".join(value(knob, line["knobs"].get(knob)) for knob in self.varied)

    def group(self, line):
        return value(self.series, line["knobs"].get(self.series)) if self.series else ""

    def of_pictures(self):
        return any(line["picture"] for line in self.lines)

    def tells_apart(self):
        """Whether any setting is more exact than another."""
        part = "picture" if self.of_pictures() else "off" if self.of_others() else "error"
        return len({json.dumps(line[part]) for line in self.lines if line[part]}) > 1

    def of_others(self):
        return any(line["off"] for line in self.lines)

    def exact_title(self):
        return next((line["off"]["what"] for line in self.lines if line["off"]), "error, RMS, mm")


def truth(line):
    """What its error is against. Lines that do not say it have a truth for each model."""
    return line.get("truth") or f"of {line['knobs'].get('model', 'the study')}"


def studies(lines):
    """In the table's order, then as they came. Pairs are parted by the knobs they turn. A setting that is there against two truths is refused."""
    found, against = {}, {}
    for line in lines:
        turned = tuple(sorted(set(line["knobs"]) - {"model"})) if line["study"] == "pairs" else ()
        found.setdefault((line["study"], turned), []).append(line)
        said = against.setdefault((line["study"], json.dumps(line["knobs"], sort_keys=True)), truth(line))
        if said != truth(line):
            raise Told(f"{line['study']} {line['knobs']}: one line is against {said!r}, one against {truth(line)!r}, and they cannot be compared; give lines of one run")
    order = list(STUDIES)
    return [Study(name, of) for (name, _), of in
            sorted(found.items(), key=lambda item: order.index(item[0][0]) if item[0][0] in order else len(order))]


def front(points):
    """Which of the points (least cost, median, most, error) no other beats, as a list of their places in `points`. A more exact point beats another
    unless the other took less in every run than it did in any. One as exact beats another that took more in every run. What is None or NaN is in no front."""
    known = [i for i, point in enumerate(points) if None not in point and not any(math.isnan(n) for n in point)]

    def beats(i, k):
        mine, other = points[i], points[k]
        if mine[3] < other[3]:
            return mine[0] <= other[2]
        return mine[3] == other[3] and mine[2] < other[0]
    return [k for k in known if not any(beats(i, k) for i in known)]


def millimetres(line, which):
    return line["error"][which] * 1e3 if line["error"] and line["error"].get(which) is not None else None


def psnr(line):
    """Decibels; infinity of a picture that is the same."""
    if not line["picture"]:
        return None
    same = line["picture"]["worst"] == 0
    return math.inf if same else line["picture"]["psnr"]


def best(study, cost, exact):
    """The lines, by id, that no other of the same truth beats. cost: of a line, (least, median, most)."""
    found = set()
    for against in study.truths():
        part = [line for line in study.lines if truth(line) == against]
        points = [(*cost(line), exact(line)) for line in part]
        found |= {id(part[i]) for i in front(points)}
    return found


def exactness(study):
    """Of a line, the smaller the better. Less than the truth knows itself is no better."""
    if study.of_pictures():
        return lambda line: None if psnr(line) is None else -psnr(line)
    if study.of_others():
        return lambda line: None if line["off"] is None else max(line["off"]["value"], line["off"]["floor"])
    return lambda line: millimetres(line, "rms")


def litres(line, which):
    said = (line["error"] or {}).get(which)
    return figure(said * 1e3 if said is not None else None)


def spread_text(study, line):
    ends = study.spread(line)
    return "elsewhere" if line.get("source") else "-" if ends is None else f"{len(line['ms_runs'])}: {figure(ends[0])} to {figure(ends[1])}"


def columns(study):
    """[(head, what of a line)] of what is measured."""
    if study.of_pictures():
        found = [("PSNR, dB", lambda line: "same" if psnr(line) == math.inf else figure(psnr(line))),
                 ("worst of 255", lambda line: str((line["picture"] or {}).get("worst", "-")))]
    elif study.of_others():
        found = [(study.exact_title(), lambda line: "-" if line["off"] is None else "at most " * (line["off"]["value"] < line["off"]["floor"]) + figure(exactness(study)(line)))]
        found += [(head, lambda line, head=head: figure(line["more"][head]) if "more" in line else "-")
                  for head in dict.fromkeys(head for line in study.lines for head in line.get("more", {}))]
    elif any(line["error"] for line in study.lines):
        found = [("error, RMS, mm", lambda line: figure(millimetres(line, "rms"))), ("max", lambda line: figure(millimetres(line, "max")))]
        found += [(head, lambda line, which=which: litres(line, which)) for which, head in
                  (("volume_abs", "volume, l"), ("volume", "net, l")) if any(which in (line["error"] or {}) for line in study.lines)]
    else:
        found = []
    if any("beside" in line for line in study.lines):
        found.append(("moved by rounding, RMS", lambda line: figure(line["beside"]["rms"] * 1e3) if "beside" in line else "-"))
    found += [(study.cost_title(), lambda line: figure(study.cost(line))), ("runs", lambda line: spread_text(study, line))]
    if any(line["bytes"] is not None for line in study.lines):
        found.append(("bytes", lambda line: size(line["bytes"])))
    if any("laws" in line for line in study.lines):
        found.append(("laws", lambda line: line.get("laws", "-")))
    return found


def rows(study):
    """(head, rows) of its table."""
    on = best(study, study.range_of_cost, exactness(study)) if study.tells_apart() else set()
    measured, found = columns(study), []
    for line in study.lines:
        row = [value(knob, line["knobs"].get(knob)) for knob in study.varied] + [of(line) for _, of in measured]
        if line["default"]:
            row = [f"**{cell}**" for cell in row]
            row[len(study.varied) - 1] += " (default)"
        found.append(row + ["●" * (id(line) in on)])
    return [knob.replace("_", " ") for knob in study.varied] + [head for head, _ in measured] + ["front"], found
