"""Tables and gates of bench/converge.py, from its rows alone."""
import math

from pages import table

PARTS = ("sinkage", "drawbar", "torque")
GATES = []           # (case, function): each returns (text, met, figure) for the rows of its case


def gate(case):
    return lambda function: GATES.append((case, function)) or function


def grouped(rows, *keys):
    found = {}
    for row in rows:
        found.setdefault(tuple(row.get(key) for key in keys), []).append(row)
    return found


def worst(rows, key, reference):
    """The greatest difference of a row from its reference, as a signed share. reference: of a row."""
    return max((row[key] / reference(row) - 1 for row in rows), key=abs)


def mean(rows, key):
    return sum(row[key] for row in rows) / len(rows)


TOLD = 2e-3          # a smaller error is not told from the average over a way of whole posts


def order(errors):
    """The slope of log error against log spacing, by least squares, down to the first spacing whose error is too small to tell (it counts as
    that small, so that the order is at least this). None: the coarsest is so small already. errors: {spacing: error}."""
    points = []
    for spacing, error in sorted(errors.items(), reverse=True):
        points.append((math.log(spacing), math.log(max(abs(error), TOLD))))
        if abs(error) < TOLD:
            break
    if len(points) < 2:
        return None
    x, y = (sum(p[k] for p in points) / len(points) for k in (0, 1))
    return sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a, _ in points)


def percent(share):
    return f"{share * 100:+.1f} %"


def millimetres(spacing):
    return f"{spacing * 100:g} cm"


def finest_of(rows, key):
    least = min(row["spacing"] for row in rows)
    return mean([row for row in rows if row["spacing"] == least], key)


def scaled(key, value):
    """Metres as millimetres."""
    return value * 1e3 if key in ("sinkage", "crest") else value


def convergence(groups, closed_key="closed", keys=PARTS):
    """One table of several soils: quantities down, spacings across. A cell: the mean of the lanes, and the lane furthest from the
    reference. groups: {soil: rows}."""
    spacings = sorted({row["spacing"] for rows in groups.values() for row in rows}, reverse=True)
    lines = []
    for soil, rows in groups.items():
        load = rows[0]["load"]
        for key in (*keys, "fz", "side", "rim"):
            if key not in rows[0] or (key == "rim" and rows[0]["rim_of"] == "none"):
                continue
            reference = load if key in ("fz", "side") else finest_of(rows, key) if key == "rim" else rows[0][closed_key][key]
            cells, errors = [], {}
            for spacing in spacings:
                here = at(rows, spacing)
                shares = [row[key] / reference - (key != "side") for row in here]
                errors[spacing] = max(shares, key=abs)
                cells.append(f"{scaled(key, mean(here, key)):.4g} ({percent(errors[spacing])})")
            if key == "rim":
                errors.pop(spacings[-1])
            slope = order(errors)
            unit = {"sinkage": "mm", "torque": "N m", "rim": "l/m"}.get(key, "N")
            form = "(finest)" if key == "rim" else "0" if key == "side" else f"{scaled(key, reference):.4g}"
            name = {"side": "side force", "fz": "fz"}.get(key, key)
            lines.append([f"{soil}, {load:g} N" if key == keys[0] else "", f"{name}, {unit}", form, *cells,
                          "" if key in ("fz", "side") else "too small" if slope is None else f"{slope:.2f}"])
    return table(["soil", "", "closed form", *(millimetres(d) for d in spacings), "order"], lines)


def at(rows, spacing):
    return [row for row in rows if abs(row["spacing"] - spacing) < 1e-9]


NOTHING = "nothing was driven"


def bounded(text, bounds, rows, off, where):
    """A gate of shares at spacings. bounds: {spacing: the most}. off: of a row."""
    met, worst_one = True, None
    for spacing, most in bounds.items():
        for row in at(rows, spacing):
            share = off(row)
            met &= abs(share) <= most
            if worst_one is None or abs(share) / most > worst_one[0]:
                worst_one = (abs(share) / most, f"{percent(share)} at {millimetres(spacing)}, {where(row)}")
    return text, met and worst_one is not None, worst_one[1] if worst_one else NOTHING


def place(row):
    return " ".join(str(row[key]) for key in ("soil", "lane") if key in row)


@gate("steady")
def sinkage_converges(rows):
    default = [row for row in rows if row["rim_of"] == "default"]
    finest = {soil: finest_of(of, "sinkage") for (soil,), of in grouped(default, "soil").items()}
    return bounded("with the rim: sinkage within 3 % of the finest at 2 cm, 1 % at 1 cm", {0.02: 0.03, 0.01: 0.01}, default,
                   lambda row: row["sinkage"] / finest[row["soil"]] - 1, place)


def forces_gate(rim, key):
    def found(rows):
        of = [row for row in rows if row["rim_of"] == rim]
        return bounded(f"{'with the rim' if rim == 'default' else 'without a rim'}: {key} within 5 % of its closed form at 2 cm, 2.5 % at 1 cm",
                       {0.02: 0.05, 0.01: 0.025}, of, lambda row: row[key] / row["closed"][key] - 1, place)
    return found


SMALL = 5e-3         # an error below it from 4 cm on needs no order


def order_gate(key):
    def found(rows):
        slopes = {}
        for (soil,), of in grouped([row for row in rows if row["rim_of"] == "none"], "soil").items():
            errors = {d: worst(at(of, d), key, lambda row: row["closed"][key]) for d in {row["spacing"] for row in of}}
            slope, fine = order(errors), max(abs(error) for d, error in errors.items() if d <= 0.04)
            slopes[soil] = (math.inf if slope is None or fine < SMALL else slope), fine
        soil = min(slopes, key=lambda soil: slopes[soil][0])
        least, _ = slopes[soil]
        most = max(fine for _, fine in slopes.values())
        figure = f"{least:.2f}, {soil}" if least < math.inf else f"at most {most * 100:.2f} % from 4 cm on"
        return f"without a rim: {key} of order 1 or more, or below {SMALL * 100:g} % from 4 cm on", least >= 1, figure
    return found


for _key in ("drawbar", "torque"):
    for _rim in ("default", "none"):
        GATES.append(("steady", forces_gate(_rim, _key)))
    GATES.append(("steady", order_gate(_key)))


@gate("steady")
def rim_converges(rows):
    default = [row for row in rows if row["rim_of"] == "default"]
    finest = {soil: finest_of(of, "rim") for (soil,), of in grouped(default, "soil").items()}
    return bounded("rim volume within 15 % of the finest at 1 cm", {0.01: 0.15}, default,
                   lambda row: row["rim"] / finest[row["soil"]] - 1 if finest[row["soil"]] else 0.0, place)


@gate("steady")
def side_is_small(rows):
    return bounded("side force below 1 % of the load at 2 cm and finer", {0.02: 0.01, 0.01: 0.01, 0.005: 0.01}, rows,
                   lambda row: row["side"] / row["load"], place)


@gate("steady")
def fz_is_the_load(rows):
    return bounded("fz within 0.5 % of the load", {d: 0.005 for d in {row["spacing"] for row in rows}}, rows,
                   lambda row: row["fz"] / row["load"] - 1, place)


def fixed_gate(normals, key, most):
    def found(rows):
        of = [row for row in rows if row["normals"] == normals]
        form = "closed_rim" if normals == "surface" else "closed_ground"
        # A force is measured against the vertical force where it is nearly nothing itself.
        return bounded(f"fixed sinkage, normals {normals}: {key} within {most * 100:g} % at 2 cm", {0.02: most}, of,
                       lambda row: (row[key] - row[form][key]) / max(abs(row[form][key]), 0.05 * row[form]["fz"]),
                       lambda row: f"{row['sink']:g} m, slip {row['slip']:g}, {row['lane']}")
    return found


for _key, _most in (("fz", 0.005), ("drawbar", 0.02), ("torque", 0.02)):
    GATES.append(("fixed", fixed_gate("surface", _key, _most)))
    GATES.append(("fixed", fixed_gate("ground", _key, 0.06)))


@gate("heavy")
def heavy_converges(rows):
    finest = {key: finest_of(of, "sinkage") for key, of in grouped(rows, "soil", "load", "bulldozing").items()}
    return bounded("heavy wheels with a rim: sinkage within 3 % of the finest at 2 cm", {0.02: 0.03}, rows,
                   lambda row: row["sinkage"] / finest[row["soil"], row["load"], row["bulldozing"]] - 1,
                   lambda row: f"{row['soil']} {row['load']:g} N, bulldozing {row['bulldozing']:g}, {row['lane']}")


def monotone(values):
    """The nearest sequence that does not fall, by pooling neighbours."""
    pools = []
    for value in values:
        pools.append([value, 1])
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            high, count = pools.pop()
            low, before = pools.pop()
            pools.append([(low * before + high * count) / (before + count), before + count])
    return [value for value, count in pools for _ in range(count)]


@gate("passes")
def passes_deepen_steadily(rows):
    most, where = 0.0, ""
    for (direction, spacing), of in grouped(rows, "direction", "spacing").items():
        depths = [row["sinkage"] for row in of]
        off = max(abs(a - b) for a, b in zip(depths, monotone(depths))) / max(depths)
        if off >= most:
            most, where = off, f"{millimetres(spacing)}, {direction:g} degrees"
    return "passes in one rut: residual from a monotone fit below 3 %", most < 0.03, f"{most * 100:.1f} %, {where}"


@gate("passes")
def passes_converge(rows):
    most, where = 0.0, ""
    for (direction, number), of in grouped(rows, "direction", "pass").items():
        depths = [row["sinkage"] for row in of]
        off = max(depths) / min(depths) - 1 if min(depths) > 0 else math.inf
        if off >= most:
            most, where = off, f"pass {number}, {direction:g} degrees"
    return "passes in one rut: the same within 5 % at both spacings", most < 0.05, f"{most * 100:.1f} %, {where}"


POSTS = (0.5, 0.75, 1, 1.5, 2, 3, 4, 6, 8, 12, 16)


def furthest(row):
    """The largest error of a lane's own rows of objects.csv: of its sinkage, of its drawbar as a share of the load, and of a wheel's mean torque."""
    closed, off = row["closed"], []
    for key, of in (("sinkage", row["closed"]["sinkage"]), ("drawbar", row["load"])):
        off.append((abs(row[key] - closed[key]) + row[f"{key}_range"] / 2) / of)
    return max(*off, abs(row["torque"] / closed["torque"] - 1) if row["body"] == "wheel" else 0.0)


def posts_errors(rows):
    """[(posts, percent of wheels, percent of other bodies)]: what no lane exceeds that has at least so many posts, rounded up."""
    def most(of, posts):
        return math.ceil(max(furthest(row) for row in of if row["posts"] >= posts * (1 - 1e-9)) * 100)
    of = [row for row in rows if row["case"] == "posts"]
    kinds = [row for row in of if row["body"] == "wheel"], [row for row in of if row["body"] != "wheel"]
    return [(posts, *(most(kind, posts) for kind in kinds)) for posts in POSTS
            if all(any(row["posts"] >= posts * (1 - 1e-9) for row in kind) for kind in kinds)]


def load_gate(text):
    def found(rows):
        of = [row for row in rows if row.get("carried", True)]
        furthest = max(of, key=lambda row: abs(row["fz"] / row["load"] - 1))
        off = furthest["fz"] / furthest["load"] - 1
        told = " ".join(f"{furthest[key]:g} {key}" if isinstance(furthest[key], float) else str(furthest[key])
                        for key in ("soil", "degrees", "speed", "load", "lane") if key in furthest)
        inside = sum(abs(row["fz"] / row["load"] - 1) <= 0.005 for row in of)
        return f"{text}: fz within 0.5 % of the load", abs(off) <= 0.005, f"{inside} of {len(of)}; worst {percent(off)}, {told}"
    return found


for _case, _text in (("loads", "twelve soils, 1 N to 50 kN"), ("slopes", "slopes"), ("speeds", "speeds 0.01 to 10 m/s")):
    GATES.append((_case, load_gate(_text)))


@gate("speeds")
def speed_does_not_matter(rows):
    most, where = 0.0, ""
    for (soil, lane), of in grouped(rows, "soil", "lane").items():
        slow = min(of, key=lambda row: row["speed"])
        for row in of:
            off = row["sinkage"] / slow["sinkage"] - 1
            if abs(off) >= abs(most):
                most, where = off, f"{soil} {lane} at {row['speed']:g} m/s"
    return "speeds: the slowest's sinkage within 0.5 %", abs(most) <= 0.005, f"{percent(most)}, {where}"


@gate("crests")
def crests_are_round(rows):
    furthest = max(rows, key=lambda row: row["most"] / max(row["least"], 1e-5))
    off = furthest["most"] / max(furthest["least"], 1e-5) - 1
    return "rims of sphere and box: the crest differs by less than 10 % with the direction", off < 0.1, \
        f"{furthest['least'] * 1e3:.0f} .. {furthest['most'] * 1e3:.0f} mm, {furthest['model']} {furthest['shape']} at {millimetres(furthest['spacing'])}"


def judged(rows):
    """[(case, text, met, figure)] for the cases that were driven."""
    found = []
    for case, function in GATES:
        of = [row for row in rows if row["case"] == case]
        answer = function(of) if of else None
        if answer and answer[2] != NOTHING:
            found.append((case, *answer))
    return found


def gates_table(rows, before=()):
    """With the rows of an earlier run its figures stand beside."""
    earlier = {text: (met, figure) for _, text, met, figure in judged(before)}
    head, lines = ["case", "gate", "", "worst"], []
    for case, text, met, figure in judged(rows):
        lines.append([case, text, "met" if met else "MISSED", figure])
        if before:
            was, old = earlier.get(text, (None, "-"))
            lines[-1].append(("met: " if was else "") + old)
    return table(head + ["before"] * bool(before), lines)
