"""What `furrow drive -o DIR` left in its folder, as arrays.

    drive = furrow.results.Drive("out")
    rover = drive.vehicles["rover"]
    print(rover["t"], rover["x"])               # s, m
    print(drive.cameras["nav"]["frames"][0])    # a camera.json

docs/RESULTS.md and docs/CAMERAS.md say what the files have. Nothing is written, and the library is not needed.
"""
import csv
import json
import os
import pathlib
from typing import Any, Union

import numpy as np

from furrow import _sensors


class ResultsError(Exception):
    """A folder of results cannot be used. Its text says what, why, and what to do."""


Rows = "dict[str, np.ndarray]"


def _numbers(cells: "list[str]") -> "np.ndarray":
    return np.array([float(cell) if cell else np.nan for cell in cells])


def read_rows(path: pathlib.Path) -> "dict[str, dict[str, np.ndarray]]":
    """Reads a file of rows: for each name its columns, in the order of the rows. Words stay words; an empty cell is nan.

    A last line without its end is left out: the drive was killed while it wrote it.
    """
    with open(path, newline="", encoding="utf-8") as file:
        text = file.read()
    lines = list(csv.reader(text[:text.rfind("\n") + 1].splitlines()))
    if not lines or "t" not in lines[0] or "name" not in lines[0]:
        raise ResultsError(f"{path}: its first line does not name the columns t and name; give the folder that furrow drive wrote")
    header, at = lines[0], lines[0].index("name")
    of_name: "dict[str, list[list[str]]]" = {}
    for number, line in enumerate(lines[1:], 2):
        if len(line) != len(header):
            raise ResultsError(f"{path}:{number}: {len(line)} cells where the first line names {len(header)}; drive again")
        of_name.setdefault(line[at], []).append(line)
    rows: "dict[str, dict[str, np.ndarray]]" = {}
    for name, own in of_name.items():
        rows[name] = {}
        for column, cells in zip(header, zip(*own)):
            try:
                rows[name][column] = _numbers(list(cells))
            except ValueError:
                rows[name][column] = np.array(cells)
    return rows


class Drive:
    """The results of one drive. `vehicles` and `objects` are read when they are first asked for.

    facts: run.json. folder: a pathlib.Path.
    ResultsError: the folder has no results, or they are damaged.
    """

    def __init__(self, folder: "Union[str, os.PathLike[str]]") -> None:
        self.folder = pathlib.Path(folder)
        path = self.folder / "run.json"
        try:
            self.facts: "dict[str, Any]" = json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise ResultsError(f"{path}: {error.strerror}; give the folder that furrow drive -o wrote") from None
        except ValueError:
            raise ResultsError(f"{path}: it is no JSON; drive again") from None
        self._rows: "dict[str, dict[str, dict[str, np.ndarray]]]" = {}

    def _read(self, name: str) -> "dict[str, dict[str, np.ndarray]]":
        if name not in self._rows:
            path = self.folder / name
            self._rows[name] = read_rows(path) if path.exists() else {}
        return self._rows[name]

    @property
    def vehicles(self) -> "dict[str, dict[str, np.ndarray]]":
        """For each vehicle the columns of vehicles.csv. {}: the scene has no output.vehicles."""
        return self._read("vehicles.csv")

    @property
    def objects(self) -> "dict[str, dict[str, np.ndarray]]":
        """For each object, and each geom of a vehicle that presses the soil, the columns of objects.csv."""
        return self._read("objects.csv")

    @property
    def sensors(self) -> "dict[str, dict[str, np.ndarray]]":
        """For each vehicle the columns of sensors.csv. {}: the scene has no output.sensors. docs/SENSORS.md names the columns."""
        return self._read("sensors.csv")

    @property
    def sensor_list(self) -> "list[dict[str, Any]]":
        """What each sensor of sensors.csv is: `sensors` of sensors.json."""
        path = self.folder / "sensors.json"
        return list(json.loads(path.read_text(encoding="utf-8"))["sensors"]) if path.exists() else []

    @property
    def imus(self) -> "list[dict[str, Any]]":
        """The IMUs: each has vehicle, name, frame, t (s), accelerometer (m/s2) and gyro (rad/s), n x 3, and orientation (x, y, z, w; None: it tells none)."""
        return _sensors.imus(self.sensor_list, self.sensors)

    @property
    def lidars(self) -> "dict[str, dict[str, Any]]":
        """For each lidar its lidar.json; `folder` is added, and `frames`: frame, time, position, orientation of each."""
        return _sensors.lidars(self.folder)

    def points(self, lidar: str, frame: int) -> "np.ndarray":
        """The points that a lidar met in a frame, n x 3, m, along its axes forward, left, up; the highest row first. KeyError: there is no such lidar."""
        return _sensors.points(self.lidars[lidar], frame)

    @property
    def cameras(self) -> "dict[str, dict[str, Any]]":
        """For each camera its camera.json, which is there once the drive has ended; `folder` is added: where its pictures are."""
        cameras = {}
        for path in sorted(self.folder.glob("cameras/*/camera.json")):
            cameras[path.parent.name] = {**json.loads(path.read_text(encoding="utf-8")), "folder": path.parent}
        return cameras


def nanoseconds(seconds: float) -> int:
    """The nearest whole number of nanoseconds."""
    return round(seconds * 1e9)


def quaternions(rows: "dict[str, np.ndarray]") -> "np.ndarray":
    """The attitudes of a vehicle's rows: n x 4, x, y, z, w, from its axes (forward, left, up) to the world's. They do not change sign between rows.

    A row's turns are as path files have them: yaw from east to north, then pitch nose up, then roll right side down.
    """
    yaw, pitch, roll = (np.radians(rows[name]) / 2 for name in ("yaw", "pitch", "roll"))
    cy, sy, cp, sp, cr, sr = np.cos(yaw), np.sin(yaw), np.cos(-pitch), np.sin(-pitch), np.cos(roll), np.sin(roll)
    turns = np.stack([cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr, cy * cp * cr + sy * sp * sr], axis=1)
    flips = np.cumprod(np.where(np.sum(turns[1:] * turns[:-1], axis=1) < 0, -1.0, 1.0))
    turns[1:] *= flips[:, None]
    return turns


def rotate_back(turns: "np.ndarray", vectors: "np.ndarray") -> "np.ndarray":
    """Vectors of the world's axes, n x 3, in the axes of the attitudes, n x 4."""
    axis, w = -turns[:, :3], turns[:, 3:]
    twice = 2 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)


def turn_rates(times: "np.ndarray", turns: "np.ndarray") -> "np.ndarray":
    """Angular velocities in the axes of the attitudes, rad/s, n x 3: of the turn from the row before to the row after. One row has 0."""
    rates = np.zeros((len(times), 3))
    if len(times) < 2:
        return rates
    before, after = np.maximum(np.arange(len(times)) - 1, 0), np.minimum(np.arange(len(times)) + 1, len(times) - 1)
    a, b = turns[before], turns[after]
    vector = a[:, 3:] * b[:, :3] - b[:, 3:] * a[:, :3] - np.cross(a[:, :3], b[:, :3])
    w = np.sum(a * b, axis=1, keepdims=True)
    length = np.linalg.norm(vector, axis=1, keepdims=True)
    angle = 2 * np.arctan2(length, w)
    seconds = (times[after] - times[before])[:, None]
    return np.divide(vector * angle, length * seconds, out=np.zeros_like(vector), where=(length > 0) & (seconds > 0))


def matrices(turns: "np.ndarray") -> "np.ndarray":
    """Attitudes n x 4 (x, y, z, w) as matrices n x 3 x 3, whose columns are the turned axes."""
    x, y, z, w = turns.T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1).reshape(-1, 3, 3)
