"""What a report knows of one folder that furrow drive left: run.json, and the rows of its tables. All of it is untrusted: texts are escaped where they are written, numbers are checked
where they are read."""
import json
import math
import os
from typing import Any, Union

import numpy as np

from furrow.report import forces, rows
from furrow.report.forces import Body
from furrow.results import ResultsError

JSON_BYTES = 32 << 20
COLOURS, DASHES = 8, 4
RUNS = 8


def _refuse(word: str) -> Any:
    raise ValueError(word)


def _read_json(path: str) -> "dict[str, Any]":
    try:
        if os.path.getsize(path) > JSON_BYTES:
            raise ResultsError(f"{path}: is larger than {JSON_BYTES >> 20} MB; give a folder that furrow drive left")
        with open(path, "rb") as file:
            found = json.loads(file.read().decode("utf-8", "surrogateescape"), parse_int=float, parse_constant=_refuse)
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}; give a folder that can be read") from None
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or not isinstance(found.get("ended"), str) or not isinstance(found.get("steps"), float):
        raise ResultsError(f"{path}: is no run.json of a drive; give a folder that furrow drive left")
    return found


def finite(value: Any) -> float:
    """The value, if it is a finite number; else nan."""
    return value if isinstance(value, float) and math.isfinite(value) else math.nan


class Run:
    """A folder. objects, vehicles, actuators: their rows, a Body each; ways: corners of their ways in run.json. volumes: of volume.csv. sides: "left", "right" or "" by the name of
    an object or an actuator."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        path = f"{folder}/run.json"
        if not os.path.isfile(path):
            raise ResultsError(f"{folder}: there is no run.json in it; give a folder that furrow drive left")
        self.json = _read_json(path)
        self.objects: "list[Body]" = []
        for name, columns in rows.objects(folder):
            self.objects.append(Body(name, columns))
            del columns  # what is computed takes their place
            forces.compute(self.objects[-1], self._radius(name), self._is_flat(name))
        self.vehicles = [Body(name, columns) for name, columns in rows.vehicles(folder)]
        self.actuators: "list[Body]" = []
        for vehicle in self.vehicles:
            self._take_vehicle(vehicle)
        found = rows.volumes(folder)
        self.volumes = found if found is not None else {}
        self.ways = [way for key in ("objects", "vehicles") for way in self._ways(key)]
        self.sides = {body.name: forces.side(body, next((v for v in self.vehicles if forces.is_part(body.name, v.name)), None)) for body in self.objects}
        self.sides.update({body.name: forces.side(body, None) for body in self.actuators})

    # --- run.json ---

    def at(self, path: str) -> Any:
        """The value at a path with dots, such as "cache.slots". None: there is none."""
        found: Any = self.json
        for key in path.split("."):
            found = found.get(key) if isinstance(found, dict) else None
        return found

    def number(self, path: str) -> float:
        """nan: it is no finite number."""
        return finite(self.at(path))

    def text(self, path: str) -> "Union[str, None]":
        found = self.at(path)
        return found if isinstance(found, str) else None

    def members(self, path: str) -> "dict[str, Any]":
        """The value if it is a mapping; else {}."""
        found = self.at(path)
        return found if isinstance(found, dict) else {}

    def named(self, path: str, name: str, key: str) -> Any:
        """One value of a named object or vehicle. None: there is none."""
        found = self.members(path).get(name)
        return found.get(key) if isinstance(found, dict) else None

    def setting(self, key: str) -> "Union[str, None]":
        found = self.members("scene.values").get(key)
        return found if isinstance(found, str) else None

    # --- rows ---

    def _radius(self, name: str) -> float:
        """The radius of a wheel; 0 of a shape that does not turn by itself; nan of a belt, or if run.json has no settings."""
        prefix = f"objects.{name}.shape."
        wheel = self.setting(prefix + "wheel.radius")
        if wheel is not None:
            try:
                radius = float(wheel)
            except ValueError:
                return math.nan
            return radius if radius > 0 and math.isfinite(radius) else math.nan
        keys = [key[len(prefix):] for key in self.members("scene.values") if key.startswith(prefix)]
        return math.nan if not keys or any("belt" in key or "wheel" in key for key in keys) else 0.0

    def _is_flat(self, name: str) -> bool:
        """A path has heights only if a file gives it."""
        return self.setting(f"objects.{name}.load") is None and self.setting(f"objects.{name}.path.file") is not None

    def _take_vehicle(self, vehicle: Body) -> None:
        columns, count = vehicle.columns, vehicle.count
        soil = np.full(count, np.nan)
        for body in self.objects:
            if forces.is_part(body.name, vehicle.name):
                last = np.maximum(np.searchsorted(body.time, vehicle.time * (1 + 1e-9), side="right") - 1, 0)
                soil = np.where(np.isnan(soil), 0, soil) + body.values["energy"][last]
        vehicle.values = {"speed": np.hypot(np.hypot(columns["vx"], columns["vy"]), columns["vz"]), "work": columns["work"] / 1e3, "kinetic": columns["kinetic"] / 1e3, "soil": soil}
        for name, force in columns.items():
            if not name.startswith("f:") or np.isnan(force).all():  # the vehicle has no such actuator
                continue
            actuator = Body(f"{vehicle.name}: {name[2:]}", {"t": vehicle.time, "x": vehicle.x, "y": vehicle.y})
            actuator.values = {"force": force}
            self.actuators.append(actuator)

    def _ways(self, key: str) -> "list[Body]":
        """What is no point ends a way."""
        found = []
        for name, each in self.members(key).items():
            way = each.get("way") if isinstance(each, dict) else None
            if not isinstance(way, list) or not way or not isinstance(way[0], list):
                continue
            points: "list[tuple[float, float]]" = []
            for point in way:
                x, y = (finite(point[0]), finite(point[1])) if isinstance(point, list) and len(point) > 1 else (math.nan, math.nan)
                if math.isnan(x + y):
                    break
                points.append((x, y))
            places = np.array(points).reshape(-1, 2)
            found.append(Body(name, {"x": places[:, 0], "y": places[:, 1]}))
        return found

    def best_ways(self) -> "list[Body]":
        """The ways, from the first of these that has them: vehicles.csv, objects.csv, run.json. Of vehicles and objects on paths together, from run.json: no file of rows has both."""
        if self.vehicles and self.ways and self.members("objects"):
            return self.ways
        return self.vehicles or self.objects or self.ways

    def ends_at(self) -> float:
        """The time of the last row of objects.csv; nan: there are none."""
        return max((float(body.time[-1]) for body in self.objects if body.count), default=math.nan)


class Report:
    """The drives of a page. ruts, maps, caches: one for each (ground.py, cache.py)."""

    def __init__(self, runs: "list[Run]") -> None:
        self.runs = runs
        self.ruts: "list[Any]" = []
        self.maps: "list[Any]" = []
        self.caches: "list[Any]" = []
        self._styles: "dict[tuple[int, str], tuple[int, int]]" = {}

    @property
    def several(self) -> bool:
        return len(self.runs) > 1

    @property
    def most(self) -> int:
        """Bodies of a drive that plots show."""
        return DASHES if self.several else COLOURS

    def drawn(self, bodies: "list[Body]") -> "list[Body]":
        return bodies[:self.most]

    def style(self, run: int, place: int) -> "tuple[int, int]":
        """Colour and dash of a body. One drive: each body has a colour. Several: each drive has a colour and each body a dash."""
        return (run, place) if self.several else (place, 0)

    def style_of(self, run: int, place: int, bodies: "list[Body]") -> "tuple[int, int]":
        """The same where bodies have sides: of one drive, a left and a right one share a colour, and the right one is dashed."""
        sides = [self.runs[run].sides.get(body.name, "") for body in bodies]
        if self.several or not {"left", "right"} <= set(sides):
            return self.style(run, place)
        pairs = max(sides.count("left"), sides.count("right"))
        own = sides[:place].count(sides[place])
        return (own, 1 if sides[place] == "right" else 0) if sides[place] else (pairs + own, 0)

    def name(self, run: int, body: Body) -> str:
        """For a legend or a head: with several drives the folder, too; and the side, if the name does not tell it."""
        side = self.runs[run].sides.get(body.name, "")
        text = f"{body.name} ({side})" if side and side not in body.name.lower() else body.name
        return f"{self.runs[run].folder}: {text}" if self.several else text

    def any_slope(self) -> bool:
        """Whether grade resistance is a part of the traction somewhere."""
        return any(body.steepest >= 0.02 for run in self.runs for body in self.drawn(run.objects))  # sine of a slope
