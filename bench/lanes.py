"""Wheels on flat or sloping ground, driven by the command: many lanes in one scene, read back lane by lane.

A lane is one wheel on a straight way. Lanes lie so far apart that no soil goes from one to the other."""
import csv
import dataclasses
import json
import math
import os
import struct
import subprocess
import zlib

ROOM = 6.0           # m between lanes
COLUMNS = 4          # lanes side by side
UNIT = 1e-5          # m, of an exported height


class Failed(Exception):
    """The command's own message."""


@dataclasses.dataclass
class Lane:
    name: str
    radius: float = 0.32
    width: float = 0.24
    load: float | None = 1000.0
    sink: float | None = None
    slip: float = 0.2
    direction: float = 0.0                # degrees, from east to north
    shift: tuple = (0.0, 0.0)             # of the start, in posts: away from the lattice
    length: float = 1.6                   # m
    speed: float = 0.2
    start: tuple | None = None            # m; chosen where it is not given
    grousers: int = 0
    grouser_height: float = 0.0
    more: str = ""                        # further keys of its wheel
    yaw: float = 0.0                      # degrees from the way to the wheel's plane, to the left; without `height` slip counts the whole way
    pitch: float = 0.0                    # degrees that its nose is up; without `height` alone
    height: float | None = None           # m of the axle, instead of load and sink
    shape: str = ""                       # of another body; `radius` is how far its centre is above its lowest point, and it does not slip

    def end(self):
        a = math.radians(self.direction)
        return self.start[0] + self.length * math.cos(a), self.start[1] + self.length * math.sin(a)


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise Failed(done.stderr.strip() or f"{command[0]} ended with {done.returncode}")
    return done.stdout


def accepts(furrow, folder, key, value):
    """Returns whether a scene may have this key of `redistribute`."""
    scene = os.path.join(folder, "accepts.yaml")
    with open(scene, "w") as file:
        file.write("scene: 1\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nobjects:\n"
                   "  - {name: a, shape: {sphere: {radius: 1}}, path: {points: [[1, 1]], speed: 1}, sink: 0.1}\n")
    done = subprocess.run([furrow, "explain", scene, "--set", f"redistribute.{key}={value}"], capture_output=True, text=True)
    return done.returncode == 0


def ground(furrow, folder, spacing, degrees=0.0):
    """A square store that holds 16 lanes. With degrees it rises to the east by that slope, exactly the same from post to post."""
    store = os.path.join(folder, f"ground-{spacing:g}-{degrees:g}.furrow")
    if os.path.exists(store):
        return store
    posts = int((COLUMNS + 0.5) * ROOM / spacing) + 2
    if not degrees:
        run(furrow, "synth", "-o", store, "--posts", f"{posts}x{posts}", "--spacing", repr(spacing), "--kind", "plain", "--relief", "0")
        return store
    rise = spacing * math.tan(math.radians(degrees))
    steps = max(1, 65535 // (posts - 1))
    row = struct.pack(f"<{posts}H", *(steps * x for x in range(posts)))
    raw = store.replace(".furrow", ".raw")
    with open(raw, "wb") as file:
        file.write(row * posts)
    run(furrow, "import", raw, "-o", store, "--spacing", repr(spacing), "--height-range", f"0,{rise / steps * 65535!r}", "--max-error", "0")
    os.remove(raw)
    return store


def placed(lanes, spacing):
    """Gives a start to each lane that has none: in the middle of its room, on a post of every spacing, then shifted."""
    for i, lane in enumerate(lanes):
        if lane.start is None:
            a = math.radians(lane.direction)
            middle = ROOM * (0.75 + i % COLUMNS), ROOM * (0.75 + i // COLUMNS)
            at = (middle[0] - lane.length / 2 * math.cos(a), middle[1] - lane.length / 2 * math.sin(a))
            lane.start = tuple(round(at[k] / 0.24) * 0.24 + lane.shift[k] * spacing for k in range(2))
    return lanes


def path_text(lane, folder):
    """The path: two points, or a file where it has a height or an attitude."""
    if lane.height is None:
        return f"{{points: [[{lane.start[0]!r}, {lane.start[1]!r}], [{lane.end()[0]!r}, {lane.end()[1]!r}]], speed: {lane.speed!r}}}"
    with open(os.path.join(folder, f"{lane.name}.csv"), "w") as file:
        for t, at in ((0, lane.start), (lane.length / lane.speed, lane.end())):
            file.write(f"{t!r},{at[0]!r},{at[1]!r},{lane.height!r},{lane.direction + lane.yaw!r},0,0\n")
    return f"{{file: {lane.name}.csv}}"


def scene_text(lanes, spacing, soil, redistribute, folder):
    end = max(lane.length / lane.speed for lane in lanes)
    rate = max(lane.speed for lane in lanes) / spacing
    step = min(3600.0, spacing / max(lane.speed for lane in lanes))
    text = [f"scene: 1\ntime_step: {step!r}\nend_time: {end + step!r}\nspacing: {spacing!r}\nsoil: {{{soil}}}\n"
            f"redistribute: {{model: scm{redistribute}}}\nobjects:"]
    for lane in lanes:
        bars = f", grousers: {lane.grousers}, grouser_height: {lane.grouser_height!r}" if lane.grousers else ""
        carried = "" if lane.height is not None else f"load: {lane.load!r}, " if lane.load is not None else f"sink: {lane.sink!r}, "
        bars += f", {lane.more}" if lane.more else ""
        shape = lane.shape or f"wheel: {{radius: {lane.radius!r}, width: {lane.width!r}{bars}}}"
        slips = "" if lane.shape else f"slip: {lane.slip!r}, "
        if lane.height is None and (lane.yaw or lane.pitch):
            slips += f"attitude: [{lane.yaw!r}, {lane.pitch!r}, 0], "
        text.append(f"  - {{name: {lane.name}, shape: {{{shape}}}, {carried}{slips}path: {path_text(lane, folder)}}}")
    text.append(f"output: {{forces: {rate!r}}}\n")
    return "\n".join(text)


@dataclasses.dataclass
class Driven:
    rows: dict      # of each lane's name, the rows of objects.csv
    run: dict       # run.json
    overlay: str


def drive(furrow, store, folder, lanes, spacing, soil, redistribute=""):
    """soil: the mapping's inside. redistribute: what follows `model: scm`, with its comma."""
    placed(lanes, spacing)
    scene, out, overlay = (os.path.join(folder, name) for name in ("lanes.yaml", "out", "lanes.furrow"))
    for name in (overlay, overlay + "-wal", overlay + "-shm"):
        if os.path.exists(name):
            os.remove(name)
    with open(scene, "w") as file:
        file.write(scene_text(lanes, spacing, soil, redistribute, folder))
    run(furrow, "drive", scene, "--store", store, "--overlay", overlay, "-o", out)
    rows = {lane.name: [] for lane in lanes}
    with open(os.path.join(out, "objects.csv")) as file:
        for row in csv.DictReader(file):
            rows[row["name"]].append(row)
    with open(os.path.join(out, "run.json")) as file:
        return Driven(rows, json.load(file), overlay)


def measures(lane, row):
    """One row in the wheel's own axes. Sinkage is for level ground at height 0, of the tips of its bars."""
    way, a = math.radians(lane.direction), math.radians(lane.direction + lane.yaw)
    fx, fy, fz, tx, ty = (float(row[key]) for key in ("fx", "fy", "fz", "tx", "ty"))
    return {"sinkage": lane.radius + lane.grouser_height - float(row["z"]), "drawbar": fx * math.cos(a) + fy * math.sin(a),
            "side": fy * math.cos(a) - fx * math.sin(a), "fz": fz, "torque": tx * math.sin(a) - ty * math.cos(a),
            "along": (float(row["x"]) - lane.start[0]) * math.cos(way) + (float(row["y"]) - lane.start[1]) * math.sin(way)}


def steady(lane, driven, low, high):
    """Means over the path samples between two places along the way, and how far sinkage and drawbar range there. Rows of a wheel that has
    come to its end are left out: it stands."""
    found = {}
    for row in driven.rows[lane.name]:
        m = measures(lane, row)
        if low <= m["along"] <= high:
            found.setdefault(round(m["along"], 5), m)
    found = list(found.values())
    if not found:
        return None
    mean = {key: sum(m[key] for m in found) / len(found) for key in found[0]}
    mean["samples"] = len(found)
    mean["sinkage_range"] = max(m["sinkage"] for m in found) - min(m["sinkage"] for m in found)
    mean["drawbar_range"] = max(m["drawbar"] for m in found) - min(m["drawbar"] for m in found)
    mean["side_most"] = max((m["side"] for m in found), key=abs)
    return mean


# --- what lies on the ground ---

def png_rows(data):
    """Rows of a grey 16-bit PNG, from the north."""
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            if (depth, colour) != (16, 0):
                raise Failed(f"a PNG of depth {depth} and colour {colour}; 16-bit grey was asked for")
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    flat, before, size = zlib.decompress(packed), bytearray(2 * width), 2 * width
    for y in range(height):
        kind, line = flat[y * (size + 1)], bytearray(flat[y * (size + 1) + 1:(y + 1) * (size + 1)])
        for i in range(size):
            left, up, corner = (line[i - 2] if i > 1 else 0), before[i], (before[i - 2] if i > 1 else 0)
            if kind == 1:
                add = left
            elif kind == 2:
                add = up
            elif kind == 3:
                add = (left + up) // 2
            elif kind == 4:
                guess = left + up - corner
                add = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            else:
                break
            line[i] = (line[i] + add) & 255
        yield struct.unpack(f">{width}H", bytes(line))
        before = line


def heights(furrow, driven, folder, coarsest, spacing, window, unit=UNIT):
    """Posts (x, y, height) of a window, to half a unit; heights may be 32767 units from 0."""
    picture = os.path.join(folder, "window.png")
    west, south, east, north = (round(v / spacing) for v in window)
    level = -round(math.log2(coarsest / spacing))
    run(furrow, "export", driven.overlay, "-o", picture, "--layer", "surface", "--level", str(level),
        "--window", ",".join(repr(v * spacing) for v in (west, south, east, north)),
        "--height-range", f"{-32768 * unit!r},{32767 * unit!r}")
    with open(picture, "rb") as file:
        rows = list(png_rows(file.read()))
    for k, row in enumerate(rows):
        for i, value in enumerate(row):
            yield (west + i) * spacing, (south + len(rows) - 1 - k) * spacing, (value - 32768) * unit


def rim(furrow, driven, folder, coarsest, spacing, lane, low, high, reach=0.8):
    """Litres a metre of way that lie above the undisturbed level ground, the crest in m, and the rut's section in l/m, between two places
    along the way."""
    a = math.radians(lane.direction)
    ends = [(lane.start[0] + s * math.cos(a) - c * math.sin(a), lane.start[1] + s * math.sin(a) + c * math.cos(a))
            for s in (low, high) for c in (-reach, reach)]
    window = (min(x for x, _ in ends), min(y for _, y in ends), max(x for x, _ in ends), max(y for _, y in ends))
    raised = removed = crest = 0.0
    count = 0
    for x, y, height in heights(furrow, driven, folder, coarsest, spacing, window):
        dx, dy = x - lane.start[0], y - lane.start[1]
        along, across = dx * math.cos(a) + dy * math.sin(a), dy * math.cos(a) - dx * math.sin(a)
        if low <= along <= high and abs(across) <= reach:
            count += 1
            raised += max(height, 0.0)
            removed += max(-height, 0.0)
            crest = max(crest, height)
    share = 2 * reach / max(count, 1) * 1e3
    return {"rim": raised * share, "crest": crest, "rut": removed * share}
