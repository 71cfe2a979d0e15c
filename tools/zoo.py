#!/usr/bin/env python3
"""Drives every model of a folder: MJCF and URDF, wheels, legs and arms.

    python3 tools/zoo.py FOLDER -o OUT [--model-path DIR]... [--furrow build/tools/furrow]

For each model, `furrow model` tells what it has. A model with wheels drives 5 m on a plain, and 5 m over a hill. One with legs stands for 3 s, and then its
joints swing for 3 s. One that is held swings its joints alone. OUT gets zoo.md, a table, zoo.json, with all that was told, and a folder for each model:
scenes, pictures and the drives' own files. What is in zoo.json is not driven again, unless the model, furrow or this script is another: so an interrupted
run goes on. Ctrl-C ends it, and the table has what was driven so far.

The soil presses on lower envelopes alone; a model that does not move so is driven again with all its faces. One that does not load, or does not move, has a line
that says why. The exit status is 0 if every model moved or said why.
"""
import argparse
import concurrent.futures
import hashlib
import json
import math
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree
import zlib

DISTANCE = 5.0       # m
POSTS, APART = 129, 0.25   # of the terrain; m
MIDDLE = (POSTS - 1) * APART / 2
HILL, WIDE = 0.3, 1.2      # m: height and width of the hill: 9 degrees at its steepest
STAND, SWING = 3.0, 3.0    # s
ARRIVED = 0.9        # of the way: what counts as driven
FALLEN = 40.0        # degrees
SOIL = "{bekker_kc: 10e3, bekker_kphi: 20e6, bekker_n: 0.8, cohesion: 5000, friction_angle: 35, janosi_shear: 0.003}"   # a hard floor
STEP = 0.002         # s; furrow divides it where that is too long


# --- models ---

def root_of(path):
    """The outermost element of an XML file: "robot", "mujoco", "mujocoinclude", "launch", ...; of one that is not whole, the first name."""
    try:
        with open(path, "rb") as file:
            head = file.read(65536).decode("utf-8", "replace")
    except OSError:
        return ""
    head = re.sub(r"<!--.*?(-->|$)|<\?.*?\?>|<!.*?>", "", head, flags=re.S)
    found = re.search(r"<\s*([A-Za-z_][\w:.-]*)", head)
    return found.group(1) if found else ""


def included(path):
    """Files that an MJCF includes, and whether it has bodies of its own."""
    try:
        tree = xml.etree.ElementTree.parse(path).getroot()
    except (OSError, xml.etree.ElementTree.ParseError, ValueError):
        return set(), True
    names = {(path.parent / each.get("file", "")).resolve() for each in tree.iter("include") if each.get("file")}
    return names, tree.find(".//worldbody//body") is not None or tree.find(".//worldbody/frame") is not None


def find_models(folder):
    """Models of a folder. A part that others include is none, and a scene that only adds a floor to a model is the same model."""
    models = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() not in (".xml", ".urdf", ".mjcf") or not path.is_file() or path.name == "package.xml":
            continue
        root = root_of(path)
        if root == "robot" or (root == "mujoco" and path.suffix.lower() != ".urdf") or (path.suffix.lower() == ".urdf" and root != "mujoco"):
            models[path] = root
    parts, floors, known = set(), set(), {path.resolve() for path in models}
    for path, root in models.items():
        if root != "mujoco":
            continue
        names, own = included(path)
        whole = {name for name in names if name in known and included(name)[1]}
        if not own and whole:
            floors.add(path)
        else:
            parts |= names
    return [path for path in models if path not in floors and path.resolve() not in parts]


# --- furrow ---

class Stopped(Exception):
    """Ctrl-C."""


class Furrow:
    def __init__(self, program, timeout):
        self.program, self.timeout = program, timeout
        self.running, self.stopped, self.lock = set(), False, threading.Lock()

    def __call__(self, *arguments, timeout=None):
        """Returns (exit status or None after the timeout, stdout, stderr, seconds)."""
        begun = time.monotonic()
        with self.lock:
            if self.stopped:
                raise Stopped
            process = subprocess.Popen([str(self.program), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                       errors="replace", start_new_session=True)
            self.running.add(process)
        status = None
        try:
            out, told = process.communicate(timeout=timeout or self.timeout)
            status = process.returncode
        except subprocess.TimeoutExpired:
            out, told = self.end(process)
        with self.lock:
            self.running.discard(process)
            if self.stopped:
                raise Stopped
        return status, out, told, time.monotonic() - begun

    def stop(self):
        """Ends what runs, and lets nothing begin."""
        with self.lock:
            self.stopped = True
            running = list(self.running)
        for process in running:
            self.signal(process, signal.SIGINT)

    @staticmethod
    def signal(process, how):
        try:
            os.killpg(process.pid, how)
        except ProcessLookupError:
            pass

    @staticmethod
    def end(process):
        """Ends a command as Ctrl-C does; kills it if that takes long."""
        for how, wait in ((signal.SIGINT, 10), (signal.SIGKILL, None)):
            Furrow.signal(process, how)
            try:
                return process.communicate(timeout=wait)
            except subprocess.TimeoutExpired:
                continue
        return process.communicate()


def lines_of(told, *strip):
    """Notes and the error of a command, without the paths that repeat in each line."""
    notes, error = [], ""
    for line in told.splitlines():
        for path in strip:
            line = line.replace(str(path) + ": ", "")
        line = line.replace("vehicles.model: ", "")
        if line.startswith("furrow: note: "):
            notes.append(line[len("furrow: note: "):])
        elif line.startswith("furrow: "):
            error = line[len("furrow: "):]
    return notes, error


# --- terrain ---

def write_hill(path):
    """A plain with one round hill, as a PNG of 16 bits: 0 to 65535 is 0 to 1 m."""
    rows = bytearray()
    for y in range(POSTS):
        rows.append(0)
        for x in range(POSTS):
            away = math.hypot(x * APART - MIDDLE, y * APART - MIDDLE)
            rows += struct.pack(">H", round(65535 * HILL * math.exp(-(away / WIDE) ** 2 / 2)))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", POSTS, POSTS, 16, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(bytes(rows))) + chunk(b"IEND", b""))


def make_grounds(furrow, out):
    plain, hill = out / "plain.furrow", out / "hill.furrow"
    if not plain.exists():
        furrow("synth", "--posts", "%dx%d" % (POSTS, POSTS), "--spacing", APART, "--kind", "plain", "--relief", 0.001, "-o", plain)
    if not hill.exists():
        write_hill(out / "hill.png")
        furrow("import", out / "hill.png", "-o", hill, "--spacing", APART, "--height-range", "0,1")
    return {"plain": plain, "hill": hill}


# --- scenes ---

def quoted(text):
    return json.dumps(str(text))


def power(length):
    return 2.0 ** math.floor(math.log2(length))


class Plan:
    """How one model is driven: by what `furrow model` told of it."""

    def __init__(self, seen, path, model_path):
        self.seen, self.path, self.model_path = seen, path, model_path
        self.faces = "off"   # on a hard floor the lower envelope does, and costs a fraction
        size = [high - low for low, high in zip(seen["low"], seen["high"])]
        self.length = max(size[0], size[1], 0.05)
        self.height = max(size[2], 0.05)
        self.drive = [j for j in seen["joints"] if j["role"] == "drives"]
        self.steer = [j for j in seen["joints"] if j["role"] == "steers"]
        radii = [j["radius"] for j in self.drive if j.get("radius")]
        self.radius = min(radii) if radii else None
        fine = self.radius / 2.5 if radii else self.length / 24
        self.spacing = min(max(power(fine), 1 / 128), APART / 2)
        self.speed = min(max(10 * self.radius, 0.5), 1.5) if radii else 0

    def wheels(self):
        return bool(self.drive)

    def end_time(self):
        return 2 + 1.3 * DISTANCE / self.speed if self.wheels() else STAND + SWING

    def only_forces(self):
        return bool(self.seen["actuators"]) and all(a["keeps"] == "force" for a in self.seen["actuators"])

    def limp(self):
        """Joints of limbs whose actuators give forces alone: a path leaves them limp, so they are locked."""
        forces = {a["joint"] for a in self.seen["actuators"] if a["keeps"] == "force"}
        return [j["name"] for j in self.seen["joints"] if j["role"] == "holds" and j["name"] in forces]

    def swings(self):
        """Actuators, or joints without one, that the table of controls moves: (name, middle, how far)."""
        swung = []
        actuators = {a["name"]: a for a in self.seen["actuators"]}
        if actuators:
            joints = {j["name"]: j for j in self.seen["joints"]}
            for name, actuator in actuators.items():
                low, high = actuator["range"] or (-1, 1)
                joint = joints.get(actuator["joint"])
                if actuator["keeps"] == "place":
                    middle = joint["value"] if joint and low <= joint["value"] <= high else min(max(0, low), high)
                    swung.append((name, middle, min(0.15, (high - low) / 8)))
                else:
                    swung.append((name, min(max(0, low), high), 0.1 * min(high, -low) if low < 0 < high else 0))
        else:
            for joint in self.seen["joints"]:
                low, high = joint["range"] or (-math.inf, math.inf)
                reach = 0.15 if joint["type"] == "hinge" else 0.02
                reach = min(reach, (high - low) / 8)
                middle = min(max(joint["value"], low + reach), high - reach)
                if joint["wheel"] is None and high > low and (joint["type"] == "hinge" or joint["range"]):   # a slide without limits holds nothing
                    swung.append((joint["name"], middle, reach))
        return [each for each in swung if "," not in each[0]]

    def write_table(self, path):
        swung = self.swings()
        rows = ["t," + ",".join(name for name, _, _ in swung)]
        for i in range(round((STAND + SWING) / 0.05) + 1):
            t = i * 0.05
            turn = math.sin(2 * math.pi * (t - STAND)) if t > STAND else 0
            rows.append("%.3f," % t + ",".join("%.6g" % (middle + reach * turn) for _, middle, reach in swung))
        path.write_text("\n".join(rows) + "\n")

    def write_scene(self, folder, ground, images, settles=True):
        start = [MIDDLE - DISTANCE / 2, MIDDLE] if self.wheels() else [MIDDLE, MIDDLE]
        more = ", forward: +y" if self.seen["forward"] == "+y" else ""
        if self.model_path:
            more += ", model_path: [%s]" % ", ".join(map(quoted, self.model_path))
        if self.wheels():
            names = {role: ", ".join(quoted(j["actuator"] or j["name"]) for j in joints) for role, joints in (("drive", self.drive), ("steer", self.steer))}
            more += ", driver: {path: {points: [[%g, %g], [%g, %g]], speed: %g}, drive: [%s]%s}" % (
                *start, start[0] + DISTANCE, start[1], self.speed, names["drive"], ", steer: [%s]" % names["steer"] if self.steer else "")
            if self.limp():
                more += ", servo: {lock: [%s]}" % ", ".join(map(quoted, self.limp()))
        elif self.swings():
            self.write_table(folder / "controls.csv")
            more += ", driver: {controls: controls.csv}"
        keyframe = next((name for name in self.seen["keyframes"] if name), None)
        place = "at: [%g, %g]" % tuple(start) + (", keyframe: %s" % quoted(keyframe) if keyframe else "")
        if not settles or not self.wheels() and self.only_forces():   # nothing holds its pose: it begins as it is, and does not settle
            place += ", settle: false"
        steps = round(self.end_time() / STEP)
        path = folder / (ground + ".yaml")
        path.write_text(f"""# Made by tools/zoo.py.
scene: 1
end_time: {self.end_time():.6g}
time_step: {STEP}
spacing: {self.spacing:.9g}
soil: {SOIL}
redistribute: {{model: scm, faces: {self.faces}}}
vehicles:
  - {{name: model, model: {quoted(self.path)}, start: {{{place}}}{more}}}
output: {{vehicles: 20}}
""" + ("stuck: {after: 5, below: 0.01}\n" if self.wheels() else "") + (f"""view:
  size: [480, 320]
  camera: {{chase: model, back: {2.5 * max(self.length, self.height):.4g}, up: {max(self.length, self.height):.4g}}}
  effects: [texture, detail, sky, geomorph, skirts, objects, shadow]
  images: {max(steps // 4, 1)}
""" if images else ""))
        return path


# --- what came of it ---

def read_rows(path):
    try:
        lines = path.read_text().splitlines()
    except OSError:
        return []
    names = lines[0].split(",") if lines else []
    return [dict(zip(names, line.split(","))) for line in lines[1:]]


def number(row, name):
    try:
        return float(row[name])
    except (KeyError, ValueError):
        return math.nan


LIES = {"high_centred": "its body lies on the ground", "buried": "the soil does not carry it"}


def wheels_told(plan, rows, way):
    """Whether wheels that did not bring it far turned."""
    turned = [abs(number(rows[-1], "q:" + j["name"]) - number(rows[0], "q:" + j["name"])) * j["radius"] for j in plan.drive if j.get("radius")]
    turned = [each for each in turned if math.isfinite(each)]
    if not turned:
        return ""
    mean = sum(turned) / len(turned)
    return ", and its wheels slip: they rolled %.2f m" % mean if mean > 2 * way + 0.1 else ", since its wheels turned by %.2f m alone: give servo.torque" % mean if mean < 0.5 * DISTANCE else ""


def judge_wheels(plan, rows, run):
    way = math.hypot(number(rows[-1], "x") - number(rows[0], "x"), number(rows[-1], "y") - number(rows[0], "y"))
    off = abs(number(rows[-1], "y") - MIDDLE)
    tilt = max(abs(number(rows[-1], "roll")), abs(number(rows[-1], "pitch")))
    result = {"distance": round(way, 3), "aside": round(off, 3), "moves": ARRIVED * DISTANCE <= way <= (2 - ARRIVED) * DISTANCE and off < 0.2 * DISTANCE and tilt < FALLEN}
    if not result["moves"]:
        vehicle = run.get("vehicles", {}).get("model", {})
        why = "it lies on its side or its roof" if tilt >= FALLEN else "it came %.2f m aside" % off if off >= 0.2 * DISTANCE else "it came %.2f m" % way
        if way > DISTANCE:
            why += ", beyond the end of its path"
        elif tilt < FALLEN:
            why += wheels_told(plan, rows, way)
        if not plan.seen["free"]:
            why = "its root has no free joint: it is held, or goes where other joints let it; give it one"
        for lie in vehicle.get("lies") or []:
            if LIES.get(lie.get("what")):
                why += ", " + LIES[lie["what"]]
        if vehicle.get("stuck_since") is not None:
            why += ", and was stuck from %.3g s on" % vehicle["stuck_since"]
        result["why"] = why
    return result


def judge_limbs(plan, rows, run):
    stood = [row for row in rows if number(row, "t") <= STAND] or rows[:1]
    first, last = rows[0], stood[-1]
    tilt = max(abs(number(last, "roll") - number(first, "roll")), abs(number(last, "pitch") - number(first, "pitch")))
    sank = number(first, "z") - number(last, "z")
    joints = [name for name in rows[0] if name.startswith("q:") and rows[0][name] != ""]
    swung = [row for row in rows if number(row, "t") > STAND]
    travel = max((max(number(r, n) for r in swung) - min(number(r, n) for r in swung) for n in joints), default=0) if swung else 0
    stands = tilt < FALLEN and sank < 0.4 * plan.height
    result = {"stands": stands, "travel": round(travel, 4), "moves": travel > 0.02}
    why = []
    if not stands:
        why.append("it does not stand in its first pose: %s" % ("its actuators give forces alone, so it needs a controller of its own" if plan.only_forces() else
                                                                "give start.joints, start.keyframe or controls of a pose that stands"))
    if not result["moves"]:
        why.append("its joints do not move: %s" % ("it has none" if not joints else "controls do not reach them; give driver.controls"))
    if why:
        result["why"] = "; ".join(why)
    return result


def drop_overlay(folder, ground):
    for old in folder.glob(ground + ".furrow*"):
        old.unlink()


def drive(furrow, plan, folder, ground, store, images, settles=True):
    scene = plan.write_scene(folder, ground, images, settles)
    out = folder / ground
    drop_overlay(folder, ground)
    if out.exists():
        for old in out.iterdir():
            old.unlink()
    status, _, told, seconds = furrow("drive", scene, "--store", store, "--overlay", folder / (ground + ".furrow"), "-o", out)
    if status == 4 and images:
        return drive(furrow, plan, folder, ground, store, False, settles)
    if status == 3 and settles and ("it moves before the drive begins" in told or "it comes to no rest" in told):   # what falls or trembles may still be seen
        return drive(furrow, plan, folder, ground, store, images, False)
    notes, error = lines_of(told, scene, plan.path)
    notes = [note for note in notes if not note.startswith("drive: step ")]
    result = {"notes": notes, "seconds": round(seconds, 2), "moves": False}
    run = {}
    try:
        run = json.loads((out / "run.json").read_text())
    except (OSError, ValueError):
        pass
    rows = read_rows(out / "vehicles.csv")
    drop_overlay(folder, ground)
    if status is None:
        result["why"] = "it took more than %g s: --timeout gives more" % furrow.timeout + ("; it came to %.3g s of %.3g s" % (number(rows[-1], "t"), plan.end_time()) if rows else "")
    elif status != 0 or not rows:
        result["why"] = error or (notes[-1] if notes else "exit status %s" % status)
    else:
        result.update(judge_wheels(plan, rows, run) if plan.wheels() else judge_limbs(plan, rows, run))
    if status == 0:
        result["real_time"] = round(run.get("rtf") or 0, 3)
    pictures = sorted(out.glob("frame-*.png"))
    if pictures:
        result["picture"] = str(pictures[-1])
    return result


def try_model(furrow, path, folder, grounds, model_path, images):
    places = [part for each in model_path for part in ("--model-path", each)]
    status, out, told, seconds = furrow("model", path, "--json", *places)
    result = {"model": str(path), "loads": status == 0, "load_seconds": round(seconds, 2), "drives": {}}
    if status != 0:
        notes, error = lines_of(told, path)
        result.update(notes=notes, why="it took more than %g s to load" % furrow.timeout if status is None else error or "exit status %s" % status)
        result["kind"] = "-"
        return result
    seen = json.loads(out)
    plan = Plan(seen, path, model_path)
    result.update(kind=kind_of(plan), mass=seen["mass"], length=round(plan.length, 3), notes=seen["notes"])
    if not plan.wheels() and not plan.swings():
        result["kind"] = "body"
    folder.mkdir(parents=True, exist_ok=True)
    for ground in ("plain", "hill") if plan.wheels() else ("plain",):
        result["drives"][ground] = drive(furrow, plan, folder, ground, grounds[ground], images)
        if not result["drives"][ground]["moves"] and "distance" in result["drives"][ground] and plan.faces == "off":   # once more, by the whole law
            plan.faces = "on"
            result["drives"][ground] = drive(furrow, plan, folder, ground, grounds[ground], images)
        if not result["drives"][ground]["moves"]:
            break   # the hill is no easier
    return result


def kind_of(plan):
    joints = len(plan.seen["joints"])
    if plan.wheels():
        return "wheels" if joints - len(plan.drive) - len(plan.steer) < 8 else "wheels and limbs"
    return "limbs" if plan.seen["free"] else "held"


# --- tables ---

def all_notes(result):
    notes = list(result.get("notes", []))
    for each in result["drives"].values():
        notes += [note for note in each.get("notes", []) if note not in notes]
    return notes


def cell(text):
    return text.replace("|", "/").replace("\n", " ")


def outcome(result, ground):
    each = result["drives"].get(ground)
    if each is None:
        return ""
    if "distance" in each:
        return "%.2f m" % each["distance"] if each["moves"] else each.get("why", "no")
    if each["moves"]:
        return ("stands, moves" if each.get("stands") else "moves; " + each.get("why", ""))
    return each.get("why", "no")


def moves(result):
    return any(each["moves"] for each in result["drives"].values())


def write_tables(out, results, version):
    data = json.dumps({"furrow": version, "models": results}, indent=1) + "\n"
    half = out / "zoo.json.part"
    half.write_text(data)
    half.replace(out / "zoo.json")
    lines = ["# A zoo", "", "%d models: %d load, %d move. %s." % (len(results), sum(r["loads"] for r in results), sum(map(moves, results)), version), "",
             "| model | kind | kg | 5 m on a plain, or 3 s standing and 3 s swinging | over a hill | times real time | told |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for result in results:
        ratios = [each["real_time"] for each in result["drives"].values() if each.get("real_time")]
        name = result["name"]
        picture = next((each["picture"] for each in result["drives"].values() if each.get("picture")), None)
        if picture:
            name = "[%s](%s)" % (name, os.path.relpath(picture, out))
        told = "; ".join(all_notes(result))
        lines.append("| %s | %s | %s | %s | %s | %s | %s |" % (
            name, result["kind"], "%.4g" % result["mass"] if "mass" in result else "", cell(outcome(result, "plain") if result["loads"] else "does not load: " + result["why"]),
            cell(outcome(result, "hill")), "%.2g" % min(ratios) if ratios else "", cell(told)))
    (out / "zoo.md").write_text("\n".join(lines) + "\n")


def short_name(path, folder):
    return str(path.relative_to(folder))


def key_of(path, version, settings):
    key = hashlib.sha256(path.read_bytes())
    for part in (version, settings, pathlib.Path(__file__).read_text()):
        key.update(part.encode())
    return key.hexdigest()[:16]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0], formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog=__doc__.split("\n\n", maxsplit=1)[1])
    parser.add_argument("folder", type=pathlib.Path, help="models: MJCF and URDF, in it and below it")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder of the table, the pictures and the drives")
    parser.add_argument("--model-path", action="append", default=[], type=pathlib.Path, help="folder of packages and meshes; may be repeated")
    parser.add_argument("--furrow", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build" / "tools" / "furrow", help="the command")
    parser.add_argument("--timeout", type=float, default=300, help="s for each command; default 300")
    parser.add_argument("--jobs", type=int, default=1, help="models at a time; default 1, since times real time are of a machine that does nothing else")
    parser.add_argument("--only", help="a pattern: models whose path has it")
    parser.add_argument("--no-pictures", action="store_true")
    arguments = parser.parse_args()
    if not arguments.folder.is_dir():
        parser.error("%s is no folder" % arguments.folder)
    furrow = Furrow(arguments.furrow, arguments.timeout)
    try:
        status, version, told, _ = furrow("--version", timeout=30)
    except OSError as error:
        parser.error("%s: %s; --furrow names the command" % (arguments.furrow, error.strerror))
    if status != 0:
        parser.error("%s: %s" % (arguments.furrow, told.strip() or "it does not run"))
    version = version.splitlines()[0].strip()
    out = arguments.output
    out.mkdir(parents=True, exist_ok=True)
    models = [path for path in find_models(arguments.folder.resolve()) if arguments.only is None or re.search(arguments.only, str(path))]
    if not models:
        parser.error("%s has no model: .urdf, or .xml whose outermost element is mujoco or robot" % arguments.folder)
    try:
        before = {each.get("key"): each for each in json.loads((out / "zoo.json").read_text())["models"]}
    except (OSError, ValueError, KeyError, TypeError):
        before = {}
    signal.signal(signal.SIGINT, signal.default_int_handler)   # a shell's background ignores it
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    results, status = [None] * len(models), 0
    settings = "%s %s %s" % (arguments.timeout, arguments.no_pictures, arguments.model_path)
    grounds = None

    def one(place):
        path = models[place]
        key = key_of(path, version + str(path) + str(arguments.furrow.stat().st_mtime_ns), settings)
        result = before.get(key)
        if result is None:
            folder = out / re.sub(r"[^A-Za-z0-9._-]", "_", short_name(path, arguments.folder.resolve()))
            result = try_model(furrow, path.resolve(), folder, grounds, [each.resolve() for each in arguments.model_path], not arguments.no_pictures)
            result.update(name=short_name(path, arguments.folder.resolve()), key=key)
        return place, result

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        try:
            grounds = make_grounds(furrow, out)
            works = [pool.submit(one, place) for place in range(len(models))]
            for count, work in enumerate(concurrent.futures.as_completed(works)):
                place, result = work.result()
                results[place] = result
                write_tables(out, [each for each in results if each], version)
                text = "does not load: " + result["why"] if not result["loads"] else ", ".join("%s: %s" % (g, outcome(result, g)) for g in result["drives"])
                print("%d/%d %s: %s" % (count + 1, len(models), result["name"], text), flush=True)
        except (Stopped, KeyboardInterrupt):
            furrow.stop()
            pool.shutdown(wait=False, cancel_futures=True)
            print("zoo: interrupted; the same command goes on", file=sys.stderr)
            status = 130
    results = [each for each in results if each]
    print("%d models: %d load, %d move: %s" % (len(results), sum(r["loads"] for r in results), sum(map(moves, results)), out / "zoo.md"))
    silent = [r["name"] for r in results if not moves(r) and not r.get("why") and not any(d.get("why") for d in r["drives"].values())]
    if silent:
        print("zoo: no word why: %s" % ", ".join(silent), file=sys.stderr)
        status = status or 1
    return status


if __name__ == "__main__":
    sys.exit(main())
