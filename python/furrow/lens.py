"""What a real camera would have made of a drive's pictures: `furrow lens DIR --camera NAME -o NEW`, or furrow.lens.write("out", "nav", "nav_fisheye", ...).

A drive's pictures are those of a pinhole without noise, of one moment. Here they get a lens's distortion, an exposure time, and noise by a seed. The new
camera lies beside the others in DIR/cameras, so furrow bag and furrow dataset have it, too. Light is summed as light: sRGB is turned into linear numbers and back.
"""
import json
import pathlib
import shutil
import sys
from typing import Any, Union

import numpy as np

from furrow import _command, _png, _stage
from furrow.results import Drive, ResultsError

ABOUT = """Makes another camera of one of a drive, with a lens, an exposure time and noise: furrow bag and furrow dataset have it, too.

  furrow lens out --camera nav -o nav_lens --model brown_conrady --coefficients=-0.28,0.07,0.0002,0.00002,0
  furrow lens out --camera nav -o nav_noisy --noise 0.004 --electrons 8000 --exposure 0.02 --every 4 --seed 3"""

MODELS = {"pinhole": 0, "brown_conrady": 5, "fisheye": 4}  # how many coefficients each has
STEPS = 50       # of Newton's method at most
CLOSE = 1e-12    # rad, or of the focal length: where it stops


# --- lenses ---

def distort(model: str, coefficients: "Any", rays: "np.ndarray") -> "np.ndarray":
    """Where rays (..., 3: right, down, ahead) meet the image plane, in units of the focal length: (..., 2).

    pinhole: x = X / Z. brown_conrady (k1, k2, p1, p2, k3): radial and tangential, as OpenCV and ROS's plumb_bob have it. fisheye (k1 .. k4): Kannala and Brandt 2006,
    as OpenCV's fisheye and ROS's equidistant have it.
    """
    rays = np.asarray(rays, float)
    if model == "fisheye":
        k = np.asarray(coefficients, float)
        across = np.hypot(rays[..., 0], rays[..., 1])
        angle = np.arctan2(across, rays[..., 2])
        square = angle * angle
        far = angle * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
        scale = np.divide(far, across, out=np.ones_like(far), where=across > 0)
        return rays[..., :2] * scale[..., None]
    plain = rays[..., :2] / rays[..., 2:]
    if model == "pinhole":
        return plain
    k1, k2, p1, p2, k3 = coefficients
    x, y = plain[..., 0], plain[..., 1]
    square = x * x + y * y
    radial = 1 + square * (k1 + square * (k2 + square * k3))
    return np.stack([x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x), y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y], axis=-1)


def _undo_brown(coefficients: "Any", places: "np.ndarray") -> "np.ndarray":
    """Newton's method from the distorted place. nan: it does not come close, where the lens folds over."""
    k1, k2, p1, p2, k3 = coefficients
    at = np.array(places, float)
    for _ in range(STEPS):
        x, y = at[..., 0], at[..., 1]
        square = x * x + y * y
        radial, slope = 1 + square * (k1 + square * (k2 + square * k3)), k1 + square * (2 * k2 + 3 * square * k3)
        off = distort("brown_conrady", coefficients, np.concatenate([at, np.ones((*at.shape[:-1], 1))], axis=-1)) - places
        a = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
        b = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y
        d = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
        det = a * d - b * b
        step = np.stack([d * off[..., 0] - b * off[..., 1], a * off[..., 1] - b * off[..., 0]], axis=-1) / np.where(det > 0, det, np.nan)[..., None]
        at = at - step
        if not np.nanmax(np.abs(step), initial=0.0) > CLOSE:
            break
    off = distort("brown_conrady", coefficients, np.concatenate([at, np.ones((*at.shape[:-1], 1))], axis=-1)) - places
    return np.where(np.abs(off).max(axis=-1, keepdims=True) < 1e-9, at, np.nan)


def undistort(model: str, coefficients: "Any", places: "np.ndarray") -> "np.ndarray":
    """The ray (..., 3) of each place of the image plane (..., 2), in units of the focal length. nan: no ray comes there."""
    places = np.asarray(places, float)
    if model == "pinhole":
        return np.concatenate([places, np.ones((*places.shape[:-1], 1))], axis=-1)
    if model == "brown_conrady":
        at = _undo_brown(coefficients, places)
        return np.concatenate([at, np.ones((*at.shape[:-1], 1))], axis=-1)
    k = np.asarray(coefficients, float)
    far = np.hypot(places[..., 0], places[..., 1])
    angle = np.array(far)
    for _ in range(STEPS):
        square = angle * angle
        off = angle * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3])))) - far
        slope = 1 + square * (3 * k[0] + square * (5 * k[1] + square * (7 * k[2] + 9 * square * k[3])))
        step = off / np.where(slope > 0, slope, np.nan)
        angle = angle - step
        if not np.nanmax(np.abs(step), initial=0.0) > CLOSE:
            break
    angle = np.where((angle >= 0) & (angle < np.pi), angle, np.nan)
    across = np.divide(np.sin(angle), far, out=np.ones_like(far), where=far > 0)
    return np.concatenate([places * across[..., None], np.cos(angle)[..., None]], axis=-1)


# --- light ---

def _linear(picture: "np.ndarray") -> "np.ndarray":
    srgb = np.arange(256) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)[picture]


def _srgb(light: "np.ndarray") -> "np.ndarray":
    light = np.clip(light, 0, 1)
    return np.rint(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)).astype(np.uint8)


def _mixed(numbers: "np.ndarray") -> "np.ndarray":
    """The finaliser of splitmix64."""
    x = numbers + np.uint64(0x9e3779b97f4a7c15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xbf58476d1ce4e5b9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94d049bb133111eb)
    return x ^ (x >> np.uint64(31))


def noise(seed: int, frame: int, shape: "tuple[int, ...]", camera: str = "") -> "np.ndarray":
    """Numbers whose mean is 0 and whose standard deviation is 1: sums of twelve uniform random numbers between 0 and 1, minus 6.

    The same bits for the same seed, frame and name of the camera, everywhere.
    """
    with np.errstate(over="ignore"):
        stream = _mixed(np.array([seed], np.uint64))
        for byte in camera.encode():
            stream = _mixed(stream ^ np.uint64(byte))
        stream = _mixed(stream ^ np.uint64(frame))
        base = _mixed(stream ^ _mixed(np.arange(int(np.prod(shape)), dtype=np.uint64)))
        total = np.zeros(len(base), np.uint64)
        for i in range(12):
            total += _mixed(base + np.uint64(i)) >> np.uint64(16)
    return (total.astype(np.float64) * 2.0 ** -48 - 6).reshape(shape)


def expose(light: "np.ndarray", read: float, electrons: float, seed: int, frame: int, camera: str = "") -> "np.ndarray":
    """Light, 0 to 1, with noise. read: standard deviation in the dark, of full scale. electrons: at full scale; light of L electrons has the deviation sqrt(L); 0: none."""
    square = read * read + (np.clip(light, 0, 1) / electrons if electrons > 0 else 0.0)
    return light + np.sqrt(square) * noise(seed, frame, light.shape, camera) if read > 0 or electrons > 0 else light


# --- the new camera ---

class Lens:
    """Where each pixel of the new camera looks in the drive's pictures."""

    def __init__(self, camera: "dict[str, Any]", model: str, coefficients: "list[float]", focal: float, size: "tuple[int, int]") -> None:
        self.width, self.height = size
        self.focal, self.cx, self.cy = focal, size[0] / 2, size[1] / 2
        columns, rows = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        rays = undistort(model, coefficients, np.stack([(columns - self.cx) / focal, (rows - self.cy) / focal], axis=-1))
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = rays[..., 2] > 1e-6
            self.x = np.where(ahead, camera["cx"] + camera["fx"] * rays[..., 0] / rays[..., 2] - 0.5, -1e9)
            self.y = np.where(ahead, camera["cy"] + camera["fy"] * rays[..., 1] / rays[..., 2] - 0.5, -1e9)
        self.seen = (self.x >= -0.5) & (self.x <= camera["width"] - 0.5) & (self.y >= -0.5) & (self.y <= camera["height"] - 0.5)

    def colours(self, light: "np.ndarray") -> "np.ndarray":
        """Light of the new pixels, between those of the picture; 0 where it does not reach."""
        x, y = np.clip(self.x, 0, light.shape[1] - 1), np.clip(self.y, 0, light.shape[0] - 1)
        left, upper = np.minimum(x.astype(int), max(light.shape[1] - 2, 0)), np.minimum(y.astype(int), max(light.shape[0] - 2, 0))
        u, v = (x - left)[..., None], (y - upper)[..., None]
        right, lower = np.minimum(left + 1, light.shape[1] - 1), np.minimum(upper + 1, light.shape[0] - 1)
        mixed = (light[upper, left] * (1 - u) + light[upper, right] * u) * (1 - v) + (light[lower, left] * (1 - u) + light[lower, right] * u) * v
        return np.where(self.seen[..., None], mixed, 0.0)

    def depths(self, depth: "np.ndarray") -> "np.ndarray":
        """Depth of the nearest pixel: depths of two bodies do not mix. inf where the picture does not reach."""
        x, y = np.clip(np.rint(self.x), 0, depth.shape[1] - 1).astype(int), np.clip(np.rint(self.y), 0, depth.shape[0] - 1).astype(int)
        return np.where(self.seen, depth[y, x], np.float32(np.inf)).astype(np.float32)


def write(folder: _stage.Path, camera: str, new: str, model: str = "pinhole", coefficients: "Union[list[float], None]" = None, focal: "Union[float, None]" = None,
          read: float = 0.0, electrons: float = 0.0, exposure: float = 0.0, every: int = 1, seed: int = 0) -> "dict[str, Any]":
    """Writes DIR/cameras/NEW of DIR/cameras/CAMERA. Returns {frames, seen, averaged}: seen: share of the pixels that the drive's picture reaches.

    coefficients: of the model, as distort has them. focal: pixels; None: that of the drive's picture. read, electrons: as expose has them. exposure: s: frames that
    end at most so long before are averaged. every: each so many is written. The folder is there when it is whole. ResultsError: there is no such camera, or a number is off.
    """
    drive = Drive(folder)
    if camera not in drive.cameras:
        raise ResultsError(f"{drive.folder}: no camera has the name {camera}; there are: {', '.join(drive.cameras) or 'none'}")
    own = drive.cameras[camera]
    if "of" in own:
        raise ResultsError(f"cameras.{camera}: it has a lens already; give a camera of the scene")
    if "colour" not in own["images"]:
        raise ResultsError(f"cameras.{camera}: it has no colours; give it images: [colour]")
    coefficients = list(coefficients or [0.0] * MODELS[model])
    if len(coefficients) != MODELS[model]:
        raise ResultsError(f"--coefficients: {len(coefficients)} numbers; the model {model} has {MODELS[model]}")
    if not set(new) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") or not new:
        raise ResultsError(f"-o {new}: it is no name of a camera; allowed: A-Z a-z 0-9 _ -")
    if every < 1 or read < 0 or electrons < 0 or exposure < 0 or not 0 <= seed < 2 ** 63 or (focal is not None and not focal > 0):
        raise ResultsError("a number is below what is allowed; allowed: --every 1 or more, --focal above 0, other numbers 0 or more")
    lens = Lens(own, model, coefficients, focal if focal is not None else own["fx"], (own["width"], own["height"]))
    to = drive.folder / "cameras" / new
    if to.exists():
        raise ResultsError(f"{to}: it is there already; give another name")
    beside = to.with_name(f".{new}.part")
    shutil.rmtree(beside, ignore_errors=True)
    averaged = 0
    try:
        images = {"colour": {"png": "8-bit sRGB"}}
        if "depth" in own["images"]:
            images["depth"] = {"npy": "float32, m along the camera's z axis; inf: sky, or beyond the picture"}
        for image in images:
            (beside / image).mkdir(parents=True)
        frames = []
        for i in range(0, len(own["frames"]), every):
            frame = own["frames"][i]
            first = i
            while first > 0 and own["frames"][first - 1]["time"] > frame["time"] - exposure + 1e-9:
                first -= 1
            averaged = max(averaged, i - first + 1)
            light = sum(_linear(_png.read(own["folder"] / "colour" / f"{each['frame']:06d}.png")) for each in own["frames"][first:i + 1]) / (i - first + 1)
            shown = expose(lens.colours(light), read, electrons, seed, frame["frame"], camera)
            (beside / "colour" / f"{len(frames):06d}.png").write_bytes(_png.colours(_srgb(shown)))
            if "depth" in images:
                np.save(beside / "depth" / f"{len(frames):06d}.npy", lens.depths(np.load(own["folder"] / "depth" / f"{frame['frame']:06d}.npy")))
            frames.append({**frame, "frame": len(frames)})
        told = {key: value for key, value in own.items() if key not in ("folder", "stereo", "fov_horizontal")}
        told.update(name=new, of=camera, fx=lens.focal, fy=lens.focal, cx=lens.cx, cy=lens.cy, width=lens.width, height=lens.height, images=images, rate=own["rate"] / every, frames=frames,
                    model=model, distortion=coefficients if coefficients else "none", noise={"read": read, "electrons": electrons, "seed": seed}, exposure=exposure)
        (beside / "camera.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        beside.rename(to)
    except ValueError as error:
        raise ResultsError(f"{error}; give the folder as the drive left it") from None
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    return {"frames": len(frames), "seen": float(lens.seen.mean()), "averaged": averaged}


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("lens", ABOUT)
    parser.add_argument("folder", metavar="DIR", help="what furrow drive -o wrote")
    parser.add_argument("-o", "--output", metavar="NAME", required=True, help="the new camera")
    parser.add_argument("--camera", metavar="NAME", required=True)
    parser.add_argument("--model", choices=list(MODELS), default="pinhole")
    parser.add_argument("--coefficients", metavar="K1,K2,...")
    parser.add_argument("--focal", type=float, metavar="PIXELS")
    parser.add_argument("--noise", type=float, default=0.0, metavar="SHARE")
    parser.add_argument("--electrons", type=float, default=0.0, metavar="N")
    parser.add_argument("--exposure", type=float, default=0.0, metavar="S")
    parser.add_argument("--every", type=int, default=1, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    given = parser.parse_args(_command.joined(arguments, "--coefficients"))

    def work() -> None:
        try:
            numbers = [float(word) for word in given.coefficients.split(",")] if given.coefficients else None
        except ValueError:
            raise ResultsError(f"--coefficients {given.coefficients}: these are no numbers; give them as -0.28,0.07,0,0,0") from None
        told = write(given.folder, given.camera, given.output, given.model, numbers, given.focal, given.noise, given.electrons, given.exposure, given.every, given.seed)
        if told["seen"] < 1:
            print(f"furrow: note: {100 * (1 - told['seen']):.1f} % of the pixels look beyond the pictures of {given.camera}, and are black; give that camera a wider fov, or a larger --focal", file=sys.stderr)
        print(f"{pathlib.Path(given.folder) / 'cameras' / given.output}: {told['frames']} frames, each of up to {told['averaged']} of {given.camera}")

    return _command.end("lens", work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
