"""Sensors of a drive as arrays: its IMUs, its rangefinders, and its lidars. furrow.results.Drive gives them."""
import json
import pathlib
from typing import Any, Iterator

import numpy as np

Rows = "dict[str, dict[str, np.ndarray]]"


def _columns(rows: "dict[str, np.ndarray]", sensor: "dict[str, Any]") -> "np.ndarray":
    return np.stack([rows[column] for column in sensor["columns"]], axis=1)


def imus(listed: "list[dict[str, Any]]", rows: "dict[str, dict[str, np.ndarray]]") -> "list[dict[str, Any]]":
    """Each place that has an accelerometer and a gyro: vehicle, name, frame, t, accelerometer and gyro (n x 3), orientation (n x 4, x, y, z, w, or None), noise.

    Rows whose accelerations are not known are left out.
    """
    places: "dict[tuple[str, str], dict[str, dict[str, Any]]]" = {}
    for sensor in listed:
        if sensor["frame"] and sensor["kind"] == "site" and (sensor["type"] != "framequat" or sensor["axes"] == "map"):
            frame = sensor["frame"]  # sites without a name are told apart by their places
            place = sensor["on"] or json.dumps([frame["body"], frame["position"], frame["orientation"]])
            places.setdefault((sensor["vehicle"], place), {}).setdefault(sensor["type"], sensor)
    found = []
    for (vehicle, _), parts in places.items():
        if not {"accelerometer", "gyro"} <= set(parts) or vehicle not in rows:
            continue
        own = rows[vehicle]
        force, rate = _columns(own, parts["accelerometer"]), _columns(own, parts["gyro"])
        known = np.isfinite(force).all(axis=1)
        turns = _columns(own, parts["framequat"])[known][:, [1, 2, 3, 0]] if "framequat" in parts else None
        found.append({"vehicle": vehicle, "name": parts["accelerometer"]["on"] or parts["accelerometer"]["name"], "frame": parts["accelerometer"]["frame"], "t": own["t"][known], "accelerometer": force[known], "gyro": rate[known],
                      "orientation": turns, "noise": {"accelerometer": parts["accelerometer"]["noise"], "gyro": parts["gyro"]["noise"]}})
    return found


def rangefinders(listed: "list[dict[str, Any]]", rows: "dict[str, dict[str, np.ndarray]]") -> "list[dict[str, Any]]":
    """Rangefinders that tell a distance alone: vehicle, name, frame, t, range (inf: nothing is met), cutoff."""
    found = []
    for sensor in listed:
        if sensor["type"] != "rangefinder" or not sensor["known"] or len(sensor["columns"]) != 1 or not sensor["frame"] or sensor["vehicle"] not in rows:
            continue
        own = rows[sensor["vehicle"]]
        told = own[sensor["columns"][0]]
        found.append({"vehicle": sensor["vehicle"], "name": sensor["name"], "frame": sensor["frame"], "t": own["t"], "range": np.where(told < 0, np.inf, told), "cutoff": sensor["cutoff"]})
    return found


def lidars(folder: pathlib.Path) -> "dict[str, dict[str, Any]]":
    """lidar.json of each lidar, with `folder` and `frames`: frame, time, position and orientation (x, y, z, w) of each."""
    found = {}
    for path in sorted(folder.glob("lidars/*/lidar.json")):
        own = {**json.loads(path.read_text(encoding="utf-8")), "folder": path.parent, "frames": []}
        text = path.with_name("poses.tum").read_text(encoding="ascii") if path.with_name("poses.tum").exists() else ""
        for line in text[:text.rfind("\n") + 1].splitlines():
            if not line.startswith("#"):
                numbers = [float(word) for word in line.split()]
                own["frames"].append({"frame": int(np.floor(numbers[0] * own["rate"] + 1e-6)), "time": numbers[0], "position": numbers[1:4], "orientation": numbers[4:8]})
        found[path.parent.name] = own
    return found


def ways(lidar: "dict[str, Any]") -> "np.ndarray":
    """The directions of a lidar's rays along its axes forward, left, up: rows x columns x 3."""
    around, up = np.array(lidar["azimuths"]), np.array(lidar["elevations"])[:, None]
    return np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up) * np.ones_like(around)], axis=2)


def points(lidar: "dict[str, Any]", frame: int) -> "np.ndarray":
    """The points of a frame along the lidar's axes, n x 3, m: of rays that met something and were not dropped, the highest row first."""
    ranges = np.load(lidar["folder"] / f"{frame:06d}.npy").astype(np.float64)
    met = np.isfinite(ranges)
    return ways(lidar)[met] * ranges[met][:, None]


def frames(listed: "list[dict[str, Any]]") -> "Iterator[dict[str, Any]]":
    """The frames of sensors that are fixed to a vehicle's root body, each once."""
    told = set()
    for sensor in listed:
        frame = sensor["frame"]
        if frame and frame["parent"] == f"{sensor['vehicle']}/base_link" and frame["name"] not in told:
            told.add(frame["name"])
            yield frame
