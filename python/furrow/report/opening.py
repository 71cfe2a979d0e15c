"""How the page opens: pictures of each drive and four numbers; and what cameras did."""
import base64
import io
import math
import os
import re
import struct
from typing import Any, Union

from PIL import Image

from furrow.report import energy
from furrow.report.blocks import Block, Cell, Place, Section, sentence, small, table
from furrow.report.run import Report, Run, finite

THUMB, OPENING = 320, 960  # pixels of a picture's longer side
BYTES, PIXELS = 64 << 20, 64 << 20
CAMERAS_MOST = 6   # of a drive, whose pictures are shown
ROWS_MOST = 200    # of a drive, in the table of cameras
NUMBERS = 4


class NoPicture(Exception):
    """A picture cannot be shown: a sentence."""


def _picture(path: str, most: int) -> "tuple[int, int, str]":
    """Width, height and base64 of a PNG, which is not trusted, made smaller to at most `most` pixels: each pixel is the mean of those that it covers."""
    if not os.path.isfile(path):
        raise NoPicture(f"{path}: is not there; give a folder that furrow drive left")
    try:
        if os.path.getsize(path) > BYTES:
            raise ValueError("it is too large")
        with Image.open(path, formats=["PNG"]) as image:
            if not 0 < image.width * image.height <= PIXELS:
                raise ValueError("it is too large")
            times = min(-(-max(image.size) // most), *image.size)
            size = image.width // times, image.height // times
            shrunk = image.convert("RGB").crop((0, 0, size[0] * times, size[1] * times)).reduce(times)
    except (OSError, ValueError, SyntaxError, struct.error, Image.DecompressionBombError) as error:
        why = str(error) if str(error) == "it is too large" else "it is damaged, or no PNG"
        raise NoPicture(f"{path}: is no picture that can be shown: {why}; give a folder that furrow drive left") from None
    out = io.BytesIO()
    shrunk.save(out, "PNG" if most == THUMB else "JPEG", optimize=True, quality=88)  # large ones as JPEG, which is a fifth as long
    return size[0], size[1], base64.b64encode(out.getvalue()).decode()


def _figure(path: str, most: int, alt: str, caption: str) -> Block:
    width, height, data = _picture(path, most)
    return Block("figure", caption, [Block("img", text=(alt, data, "png" if most == THUMB else "jpeg"), items=[width, height])])


# --- the opening ---

def _frames(run: Run) -> "list[str]":
    """The drive's own pictures, in their order."""
    try:
        return sorted(name for name in os.listdir(run.folder) if re.fullmatch(r"frame-\d{1,12}\.png", name))
    except OSError:
        return []


def _pictures(report: Report, i: int) -> "list[Block]":
    """The picture in the middle of the drive and the last one; of several drives the last one. A picture that cannot be shown is left out: a sentence tells."""
    run, blocks = report.runs[i], []
    frames = _frames(run)
    for name in dict.fromkeys(frames[-1:] if report.several else [*frames[len(frames) // 2:len(frames) // 2 + 1], *frames[-1:]]):
        step = float(name[6:-4])
        steps, simulated = run.number("steps"), run.number("simulated")
        when = f"{step / steps * simulated:.4g} s" if steps > 0 and math.isfinite(simulated) else f"step {step:.0f}"
        try:
            blocks.append(_figure(f"{run.folder}/{name}", OPENING, f"The drive at {when}", f"{run.folder}, {when}" if report.several else when))
        except NoPicture as error:
            blocks.append(sentence(report, i, str(error)))
    return blocks


def _found(report: Report, i: int) -> "list[tuple[str, str, float]]":
    """What is known of a drive, the most telling first: name, unit, value."""
    run = report.runs[i]
    vehicle = next(iter(run.members("vehicles")), None)
    name, of_vehicle = (vehicle, True) if vehicle is not None else (next(iter(run.members("objects")), None), False)
    found = []
    if name is not None:
        by = {figure.value: figure for figure in energy.FIGURES}
        spent = dict(energy.Spent(run, name, of_vehicle).figures())
        found = [("way", "m", finite(run.named("vehicles" if of_vehicle else "objects", name, "distance"))), ("mean slip", "", energy.mean(run, name, of_vehicle, by["slip"])),
                 ("mean sinkage", "mm", 1e3 * energy.mean(run, name, of_vehicle, by["sinkage"]))]
        tows = [points for points in (energy.tow_points(run, body) for body in run.vehicles) if points is not None]
        if tows:
            found.append(("greatest pull", "N", max(float(points[:, 1].max()) for points in tows)))
        elif not of_vehicle:
            found.append(("mean drawbar pull", "N", energy.mean(run, name, of_vehicle, by["drawbar"])))
        found.append(("work for each metre", "J/m", spent["work of its actuators for each metre, J/m"]))
        found.append(("energy into the soil for each metre", "J/m", spent["energy into the soil for each metre, J/m"]))
    rut = report.ruts[i]
    found += [("rut", "mm deep", -rut.deepest if not rut.why else math.nan), ("soil moved", "m3", run.number("volume.removed")), ("simulated", "s", run.number("simulated")),
              ("steps", "", run.number("steps")), ("simulated time / wall clock", "", run.number("rtf"))]
    return [(label, unit, value) for label, unit, value in found if math.isfinite(value)]


def opening(report: Report) -> Section:
    pictures = [block for i in range(len(report.runs)) for block in _pictures(report, i)]
    blocks = [Block("opening", items=pictures)] if pictures else []
    for i, run in enumerate(report.runs):
        cells = [(label, f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}", unit, f"{value:.17g}") for label, unit, value in _found(report, i)[:NUMBERS]]
        blocks.append(Block("numbers", run.folder if report.several else "", cells))
        ended = run.text("ended")
        if ended != "complete":
            blocks.append(sentence(report, i, f"The drive did not complete. It ended as: {ended}"))
    blocks.append(small("Slip, sinkage, pull and energy for each metre are those of the last quarter of the time. Of a vehicle they are of all its wheels."))
    return Section("opening", "At a glance", blocks)


# --- cameras ---

def _place(frame: Any) -> Cell:
    """Where a camera was: metres of the scene, and where it looked."""
    at, turn = (frame.get(key) if isinstance(frame, dict) else None for key in ("position", "orientation"))
    if not isinstance(at, list) or not isinstance(turn, list) or len(at) != 3 or len(turn) != 4:
        return Place("", True)
    p, q = [finite(value) for value in at], [finite(value) for value in turn]
    if not all(abs(value) < 1e12 for value in p) or not all(abs(value) < 2 for value in q):
        return Place("", True)
    ahead = 2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]), 1 - 2 * (q[0] * q[0] + q[1] * q[1])  # the third column of the rotation: where its axis ahead points
    bearing, height = math.degrees(math.atan2(ahead[0], ahead[1])) % 360, abs(math.degrees(math.atan2(ahead[2], math.hypot(ahead[0], ahead[1]))))
    return Place(f"{p[0]:.2f}, {p[1]:.2f}, {p[2]:.2f} m; looks to {bearing:.0f}°, {height:.0f}° {'down' if ahead[2] < 0 else 'up'}", True)


def _number(camera: "dict[str, Any]", key: str) -> Cell:
    value = finite(camera.get(key))
    return f"{value:.6g}" if math.isfinite(value) else None


def _row(report: Report, i: int, name: str, camera: "dict[str, Any]") -> "tuple[str, list[Cell]]":
    kind, on = (camera.get(key) if isinstance(camera.get(key), str) else None for key in ("kind", "on"))
    width, height = finite(camera.get("width")), finite(camera.get("height"))
    images = camera.get("images")
    words = ", ".join(image for image in (images if isinstance(images, list) else []) if isinstance(image, str))
    return (f"{report.runs[i].folder}: {name}" if report.several else name,
            [(kind or "") + (f", on {on}" if on else "") or None, f"{width:.0f} x {height:.0f}" if math.isfinite(width + height) else None, _number(camera, "fov_horizontal"),
             _number(camera, "rate"), _number(camera, "frames"), words or None, _place(camera.get("first")), _place(camera.get("last"))])


def _is_name(name: Any) -> bool:
    """Names of folders come from run.json, which is not trusted: no name leads out of the drive's folder."""
    return isinstance(name, str) and name != "" and name[0] != "." and "/" not in name and "\0" not in name and len(name) < 200


def _thumbs(report: Report, i: int) -> "list[Block]":
    run, blocks = report.runs[i], []
    cameras = list(run.members("cameras").items())
    for name, camera in cameras[:CAMERAS_MOST]:
        images = camera.get("images") if isinstance(camera, dict) else None
        image = images[0] if isinstance(images, list) and images else None
        if not _is_name(name) or not _is_name(image):
            continue
        for which in ("first", "last") if finite(camera.get("frames")) > 1 else ("first",):
            frame = camera.get(which)
            number, time = (finite(frame.get(key)) if isinstance(frame, dict) else math.nan for key in ("frame", "time"))
            if not 0 <= number < 1e9:
                continue
            caption = f"{run.folder + ', ' if report.several else ''}{name}, {which} picture, {time:.4g} s"
            try:
                blocks.append(_figure(f"{run.folder}/cameras/{name}/{image}/{math.floor(number):06d}.png", THUMB, f"The {which} picture", caption))
            except NoPicture as error:
                blocks.append(sentence(report, i, str(error)))
    if len(cameras) > CAMERAS_MOST:
        blocks.append(sentence(report, i, f"The page shows the pictures of the first {CAMERAS_MOST} of {len(cameras)} cameras"))
    return blocks


def cameras(report: Report) -> "tuple[list[Section], list[Section]]":
    """Their first and last pictures, and what they are. No section without any."""
    if not any(run.members("cameras") for run in report.runs):
        return [], []
    rows = [_row(report, i, name, camera if isinstance(camera, dict) else {}) for i, run in enumerate(report.runs) for name, camera in list(run.members("cameras").items())[:ROWS_MOST]]
    head = ["camera", "kind", "pixels", "field of view, degrees", "frames a second", "frames", "images", "first frame from", "last frame from"]
    return ([Section("cameras", "Cameras", [Block("thumbs", items=[block for i in range(len(report.runs)) for block in _thumbs(report, i)])])],
            [Section("cameras-table", "Cameras, table", [table(head, rows), small("Places are east, north and height, in metres of the scene. Directions are degrees clockwise from north, and below or "
                                                                                  "above the horizon.")])])
