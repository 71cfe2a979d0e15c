"""What bench/accuracy.py makes of the lines: studies, how their values read, and which points no other beats.

A line is one setting of one study's knobs: {"study", "knobs", "default", "error" or "picture" or neither, "ms_step",
"bytes", "bytes_of", "gl"}. Errors are metres and cubic metres, pictures decibels and steps of 255."""
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
}
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
    for part in ("error", "picture"):
        line.setdefault(part, None)
    line.setdefault("bytes", None)
    return line


def fraction(metres):
    """Spacings are halves of halves."""
    if 0 < metres < 1 and (1 / metres).is_integer():
        return f"1/{1 / metres:.0f} m"
    return f"{metres:g} m"


def length(metres):
    for unit, name in ((1, "m"), (1e-2, "cm"), (1e-3, "mm")):
        if metres >= unit:
            return f"{metres / unit:g} {name}"
    return f"{metres * 1e6:g} µm" if metres else "0"


def duration(seconds):
    return f"{seconds:g} s" if seconds >= 1 or seconds == 0 else f"{seconds * 1e3:g} ms"


UNITS = {"spacing": fraction, "import_error": length, "tolerance": length, "time_step": duration, "interval": duration,
         "pixel_error": "{:g} px".format}
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

    def by_second(self):
        return "time_step" in self.varied and all("ms_second" in line for line in self.lines)

    def cost_title(self):
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
        part = "picture" if self.of_pictures() else "error"
        return len({json.dumps(line[part]) for line in self.lines if line[part]}) > 1


def studies(lines):
    """In the table's order, then as they came. Pairs are parted by the knobs they turn."""
    found = {}
    for line in lines:
        turned = tuple(sorted(set(line["knobs"]) - {"model"})) if line["study"] == "pairs" else ()
        found.setdefault((line["study"], turned), []).append(line)
    order = list(STUDIES)
    return [Study(name, of) for (name, _), of in
            sorted(found.items(), key=lambda item: order.index(item[0][0]) if item[0][0] in order else len(order))]


def front(points):
    """Which points (x, y), both the better the smaller, no other beats: that none equals in both and betters in one. In
    the order of x; of equal points all. What is None or NaN is in no front."""
    known = sorted((p for p in points if None not in p and not any(math.isnan(n) for n in p)))
    best, kept = math.inf, []
    for x, y in known:
        if y < best:
            best = y
            kept.append((x, y))
        elif kept and (x, y) == kept[-1]:
            kept.append((x, y))
    return kept


def millimetres(line, which):
    return line["error"][which] * 1e3 if line["error"] and line["error"].get(which) is not None else None


def psnr(line):
    """Decibels; infinity of a picture that is the same."""
    if not line["picture"]:
        return None
    same = line["picture"]["worst"] == 0
    return math.inf if same else line["picture"]["psnr"]


def best(study, cost, exact):
    """The lines, by id, that no other of the study beats: neither at less cost as exact, nor more exact at the same. What is
    compared has one model: it is chosen for what the ground does, not for this."""
    parts = {}
    for line in study.lines:
        parts.setdefault(line["knobs"].get("model"), []).append(line)
    found = set()
    for part in parts.values():
        on = set(front([(cost(line), exact(line)) for line in part]))
        found |= {id(line) for line in part if (cost(line), exact(line)) in on}
    return found


def exactness(study):
    """Of a line, the smaller the better."""
    if study.of_pictures():
        return lambda line: None if psnr(line) is None else -psnr(line)
    return lambda line: millimetres(line, "rms")


def litres(line, which):
    said = (line["error"] or {}).get(which)
    return figure(said * 1e3 if said is not None else None)


def columns(study):
    """[(head, what of a line)] of what is measured."""
    if study.of_pictures():
        found = [("PSNR, dB", lambda line: "same" if psnr(line) == math.inf else figure(psnr(line))),
                 ("worst of 255", lambda line: str((line["picture"] or {}).get("worst", "-")))]
    elif any(line["error"] for line in study.lines):
        found = [("error, RMS, mm", lambda line: figure(millimetres(line, "rms"))), ("max", lambda line: figure(millimetres(line, "max")))]
        found += [(head, lambda line, which=which: litres(line, which)) for which, head in
                  (("volume_abs", "volume, l"), ("volume", "net, l")) if any(which in (line["error"] or {}) for line in study.lines)]
    else:
        found = []
    if any("beside" in line for line in study.lines):
        found.append(("moved by rounding, RMS", lambda line: figure(line["beside"]["rms"] * 1e3) if "beside" in line else "-"))
    found += [(study.cost_title(), lambda line: figure(study.cost(line))), ("bytes", lambda line: size(line["bytes"]))]
    if any("laws" in line for line in study.lines):
        found.append(("laws", lambda line: line.get("laws", "-")))
    return found


def rows(study):
    """(head, rows) of its table."""
    on = best(study, study.cost, exactness(study)) if study.tells_apart() else set()
    measured, found = columns(study), []
    for line in study.lines:
        row = [value(knob, line["knobs"].get(knob)) for knob in study.varied] + [of(line) for _, of in measured]
        if line["default"]:
            row = [f"**{cell}**" for cell in row]
            row[len(study.varied) - 1] += " (default)"
        found.append(row + ["●" * (id(line) in on)])
    return [knob.replace("_", " ") for knob in study.varied] + [head for head, _ in measured] + ["front"], found
