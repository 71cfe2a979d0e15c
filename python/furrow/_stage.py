"""What a drive left, as other simulators and viewers need it: the ground as a grid, and bodies with shapes and poses in time.

Shapes of vehicles come from their models, which the package mujoco reads. Frame: the store's local axes, x east, y north, z up, m.
"""
import fnmatch
import os
import pathlib
import re
from typing import Any, Iterator, Union

import numpy as np

from furrow import _command
from furrow.results import Drive, ResultsError, matrices, quaternions

MARGIN = 10.0        # m: of ground around what moved
POSTS_MOST = 1025    # on a side, unless more are asked for


class Ground:
    """heights and offsets: rows x columns, m, the southern row first, NaN where there is none. x, y: m, of the south-west post. spacing: m."""

    def __init__(self, heights: "np.ndarray", offsets: "np.ndarray", x: float, y: float, spacing: float) -> None:
        self.heights, self.offsets, self.x, self.y, self.spacing = heights, offsets, x, y, spacing

    @property
    def low(self) -> float:
        return float(np.nanmin(self.heights))

    @property
    def high(self) -> float:
        return float(np.nanmax(self.heights))

    def size(self) -> "tuple[float, float]":
        """m, east and north, between the first and the last post."""
        rows, columns = self.heights.shape
        return (columns - 1) * self.spacing, (rows - 1) * self.spacing

    def filled(self) -> "np.ndarray":
        """The heights; holes have the lowest."""
        return np.where(np.isnan(self.heights), self.low, self.heights)


def _moved(drive: Drive) -> "np.ndarray":
    """Places that vehicles and objects had: n x 2."""
    rows = [np.stack([own["x"], own["y"]], axis=1) for own in [*drive.vehicles.values(), *drive.objects.values()]]
    places = np.concatenate(rows) if rows else np.zeros((0, 2))
    return places[np.isfinite(places).all(axis=1)]


def _of_scene(drive: Drive, key: str) -> "Union[str, None]":
    value = drive.facts["scene"]["values"].get(key)
    return None if value is None else str(value).strip('"')


def _beside(drive: Drive, text: "Union[str, None]") -> "Union[pathlib.Path, None]":
    """A file that the scene names, seen from this folder. None: it is not there."""
    scene = drive.facts["scene"]["file"]
    for folder in (pathlib.Path(scene).parent, pathlib.Path(), drive.folder.parent / pathlib.Path(scene).parent):
        if text is not None and (folder / text).is_file():
            return (folder / text).resolve()
    return None


def _reader(drive: Drive) -> "dict[str, Any]":
    """A scene that reads the store of a drive: with its spacing, and the relief and the rocks that it has. ResultsError: relief by class needs the map of soils, which is gone."""
    scene: "dict[str, Any]" = {"spacing": drive.facts["spacing"]}
    relief = dict(drive.facts.get("relief") or {})
    rocks = relief.pop("rocks", None)
    if rocks:
        scene["ground"] = {"rocks": rocks}
    if not relief:
        return scene
    waves = [{key: each[key] for key in ("roughness", "wavelength")} for each in relief.get("classes", [relief])]
    scene["relief"] = {**waves[0], "seed": relief["seed"]}
    if len(waves) == 1:
        return scene
    text = _of_scene(drive, "soil.map")
    map_file = _beside(drive, text)
    # Which soils they are does not matter to the heights.
    values = [str(value) for key, value in drive.facts["scene"]["values"].items() if re.fullmatch(r"soil\.classes\..+\.value", key)]
    if map_file is None or len(values) != len(waves) - 1:
        raise ResultsError(f"soil.map: {text} is not there, beside {drive.facts['scene']['file']}, and the relief of the drive is by its classes; run this in the folder of the drive")
    scene["soil"] = {"map": str(map_file), "classes": {value: "dry_sand" for value in values}, "default": "dry_sand"}
    scene["relief"]["classes"] = dict(zip(values, waves[1:]))
    return scene


def ground(drive: Drive, window: "Union[list[float], None]" = None, posts_most: int = POSTS_MOST) -> Ground:
    """The ground at the end of a drive. window: west, south, east, north, m; None: where something moved, and 10 m around; the whole terrain if nothing did.

    Posts are the finest that are at most `posts_most` on a side. ResultsError: the store is not there any more, or the window is outside.
    """
    from furrow import Error, World
    path = drive.facts["store"]["file"]
    try:
        world = World(_reader(drive), store=path, readonly=True)
    except Error as error:
        raise ResultsError(f"the store of the drive cannot be read: {error}") from None
    with world:
        info = world.info
        wide, tall = (float(value) for value in info.extent)
        places = _moved(drive)
        if window is None:
            window = [*(places.min(axis=0) - MARGIN), *(places.max(axis=0) + MARGIN)] if len(places) else [0, 0, wide, tall]
        west, south, east, north = max(window[0], 0.0), max(window[1], 0.0), min(window[2], wide), min(window[3], tall)
        level = info.level
        spacing = info.spacing
        while max(east - west, north - south) / spacing + 1 > posts_most:
            level, spacing = level + 1, spacing * 2
        column, row = int(np.ceil(west / spacing - 1e-9)), int(np.ceil(south / spacing - 1e-9))
        columns, rows = int(np.floor(east / spacing + 1e-9)) - column + 1, int(np.floor(north / spacing + 1e-9)) - row + 1
        if columns < 2 or rows < 2:
            raise ResultsError(f"the window {', '.join(f'{value:g}' for value in window)} has no ground: the terrain goes from 0, 0 to {wide:g}, {tall:g} m; give another window")
        rectangle = {"column": column, "row": row, "columns": columns, "rows": rows, "level": level}
        heights, offsets = world.read("surface", **rectangle), world.read("offset", **rectangle)
    if np.isnan(heights).all():
        raise ResultsError(f"the window {', '.join(f'{value:g}' for value in window)} has no ground: all of it is a hole; give another window")
    return Ground(heights, np.nan_to_num(offsets), column * spacing, row * spacing, spacing)


class Part:
    """A shape of a body. kind: sphere, box, cylinder, capsule, ellipsoid or mesh. size: as MuJoCo has it: radius; half sides; radius, half length (axis z); half axes.
    at, turn: m, and 3 x 3, in the body's axes. vertices, faces: of a mesh. colour: red, green, blue, 0 to 1. collides: it is more than a picture."""

    def __init__(self, name: str, kind: str, size: "list[float]", at: "np.ndarray", turn: "np.ndarray", colour: "list[float]", vertices: "Any" = None, faces: "Any" = None, collides: bool = True) -> None:
        self.name, self.kind, self.size, self.at, self.turn, self.colour = name, kind, size, np.asarray(at, float), np.asarray(turn, float), colour
        self.vertices, self.faces, self.collides = vertices, faces, collides


class Mover:
    """A body: its name, its parts, and at `times` (s) its places (n x 3) and turns (n x 4, x, y, z, w)."""

    def __init__(self, name: str, parts: "list[Part]", times: "np.ndarray", places: "np.ndarray", turns: "np.ndarray") -> None:
        self.name, self.parts, self.times, self.places, self.turns = name, parts, times, places, turns


# --- vehicles ---

_AXES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0)}
_KINDS = {2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}


def _patterns(drive: Drive, key: str) -> "list[str]":
    return [word.strip("\"' ") for word in (_of_scene(drive, key) or "").strip("[]").split(",") if word.strip("\"' ")]


def unused(name: str, taken: "set[str]", between: str = "_") -> str:
    """The name, or the same with a number where it is taken; and takes it."""
    own, number = name, 2
    while own in taken:
        own, number = f"{name}{between}{number}", number + 1
    taken.add(own)
    return own


def model_file(drive: Drive, name: str) -> pathlib.Path:
    """The model of a vehicle. ResultsError: it is not where the scene says, seen from this folder."""
    text = _of_scene(drive, f"vehicles.{name}.model")
    found = _beside(drive, text)
    if found is not None:
        return found
    raise ResultsError(f"vehicles.{name}.model: {text} is not there, beside {drive.facts['scene']['file']}; run this in the folder of the drive, or leave vehicles out by --no-vehicles")


def unit_quaternion(turn: "np.ndarray") -> "np.ndarray":
    """x, y, z, w of a 3 x 3 turn."""
    trace = np.trace(turn)
    squares = np.array([turn[0, 0], turn[1, 1], turn[2, 2], trace])
    most = int(np.argmax(squares))
    if most == 3:
        q = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1], 1 + trace])
    else:
        i, k = (most + 1) % 3, (most + 2) % 3
        q = np.empty(4)
        q[most] = 1 + 2 * turn[most, most] - trace
        q[i], q[k] = turn[i, most] + turn[most, i], turn[k, most] + turn[most, k]
        q[3] = turn[k, i] - turn[i, k]
    return q / np.linalg.norm(q) * (1 if q[3] >= 0 else -1)


def _unread(assets: "list[Any]", error: str) -> Any:
    """The one whose file an error of MuJoCo says is not opened or read; None: it says something else. wheel.stl is not front_wheel.stl, and b/wheel.stl not a/wheel.stl."""
    def says(name: str) -> bool:
        return re.search(rf"(?:^|[\s'\"/\\(:]){re.escape(name)}(?:$|[\s'\"),:;])", error) is not None

    if re.search(r"open|read|found|find|decod|invalid|unsupported|format", error) is None:
        return None
    said = [(len(name), asset) for asset in assets if asset.file for name in {asset.file, re.split(r"[/\\]", asset.file)[-1]} if says(name)]
    return max(said, key=lambda each: each[0])[1] if said else None


class Model:
    """The model of a vehicle in MuJoCo, set to rows of vehicles.csv. `lost`: what cannot be told of it, a line each."""

    def __init__(self, drive: Drive, name: str) -> None:
        self.mujoco = _command.need("mujoco", "mujoco")
        self.name, self.rows = name, drive.vehicles[name]
        self.file = model_file(drive, name)
        try:
            self.spec = self.mujoco.MjSpec.from_file(str(self.file))
            self._free_roots(_of_scene(drive, f"vehicles.{name}.start.fixed"))
            self._name_joints()
            left_out = self._compile()
        except (ValueError, TypeError, self.mujoco.FatalError) as error:
            line = str(error).strip().splitlines()[0]
            raise ResultsError(f"{self.file}: MuJoCo {self.mujoco.__version__} does not read it: {line}; leave vehicles out by --no-vehicles") from None
        self.data = self.mujoco.MjData(self.model)
        self._first_pose(_of_scene(drive, f"vehicles.{name}.start.keyframe"))
        self.root = self._find_root(drive)
        self.axes = self._find_axes(drive)  # of base_link, in the root body's
        self.turns = matrices(quaternions(self.rows))
        self.lost = left_out + self._not_told()

    def _free_roots(self, fixed: "Union[str, None]") -> None:
        """A root without a joint is free if the scene says so, and in a URDF if it does not say otherwise. A link that is called world holds it."""
        text = self.file.read_text(encoding="utf-8", errors="replace")
        urdf = re.search(r"<robot\b", text) is not None and re.search(r"<link\s[^>]*name\s*=\s*[\"']world[\"']", text) is None
        bodies = list(self.spec.worldbody.bodies)
        if not bodies:
            raise ValueError("it has no body")
        for body in bodies:
            if not list(body.joints) and not body.mocap and (fixed == "false" or (fixed is None and urdf)):
                body.add_freejoint()

    def _compile(self) -> "list[str]":
        """Sets `model`. A drive leaves out meshes and images that it does not find or read, so these are left out here, too. Returns a line for each."""
        lost: "list[str]" = []
        while True:
            try:
                self.model = self.spec.compile()
                return lost
            except (ValueError, self.mujoco.FatalError) as error:
                asset = _unread([*self.spec.meshes, *self.spec.textures], str(error))
                if asset is None:
                    raise
                lost.append(self._leave_out(asset))

    def _leave_out(self, asset: Any) -> str:
        """Takes an asset out of the model, with what has its shape. Returns what is to be told."""
        spec, name = self.spec, re.split(r"[/\\]", asset.file)[-1]
        delete = spec.delete if hasattr(spec, "delete") else lambda part: part.delete()  # before MuJoCo 3.3 parts do it
        if asset in spec.textures:
            for material in spec.materials:
                if asset.name in material.textures:
                    material.textures = ["" if texture == asset.name else texture for texture in material.textures]
            delete(asset)
            return f"image {name} of {self.file.name} is not found or not read: what shows it has its plain colour"
        for geom in [geom for geom in spec.geoms if geom.meshname == asset.name]:
            delete(geom)
        delete(asset)
        spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6  # of bodies that had their mass of it alone
        return f"mesh {name} of {self.file.name} is not found or not read: its shape, and the mass that it gives, are left out"

    def _name_joints(self) -> None:
        """A drive calls hinges and slides without a name after their bodies, so columns have these names."""
        taken = {joint.name for joint in self.spec.joints}
        for joint in self.spec.joints:
            if joint.name or joint.type not in (self.mujoco.mjtJoint.mjJNT_HINGE, self.mujoco.mjtJoint.mjJNT_SLIDE):
                continue
            joint.name = unused(joint.parent.name or "joint", taken)

    def _first_pose(self, keyframe: "Union[str, None]") -> None:
        if keyframe is not None:
            self.mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key(keyframe).id)
        self.first = np.array(self.data.qpos)
        self.mujoco.mj_kinematics(self.model, self.data)

    def _geom_name(self, geom: int) -> str:
        model, body = self.model, int(self.model.geom_bodyid[geom])
        alone = model.body(body).name if model.body_geomnum[body] == 1 else ""
        return model.geom(geom).name or alone or f"geom_{geom}"

    def _find_root(self, drive: Drive) -> int:
        """The body whose motion the rows have: the one below the model's world that has the first geom that presses the soil."""
        model, (soil, no_soil) = self.model, (_patterns(drive, f"vehicles.{self.name}.{key}") for key in ("soil", "no_soil"))
        for geom in range(model.ngeom):
            collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
            touches = any(fnmatch.fnmatchcase(self._geom_name(geom), pattern) for pattern in soil) if soil else collides and int(model.geom_type[geom]) in _KINDS
            if model.body_weldid[model.geom_bodyid[geom]] != 0 and touches and not any(fnmatch.fnmatchcase(self._geom_name(geom), pattern) for pattern in no_soil):
                return int(model.body_rootid[model.geom_bodyid[geom]])
        return next((body for body in range(1, model.nbody) if model.body_parentid[body] == 0 and model.body_mocapid[body] < 0), 1)

    def _find_axes(self, drive: Drive) -> "np.ndarray":
        """Forward, left and up as columns: the root body's own, or those that the scene says of the model, as its root body is turned in the first pose."""
        forward, up = (_of_scene(drive, f"vehicles.{self.name}.{key}") for key in ("forward", "up"))
        if forward in (None, "+x") and up != "y":
            return np.eye(3)
        ahead, above = np.array(_AXES[forward or "+x"], float), np.array([0, 1, 0] if up == "y" else [0, 0, 1], float)
        return self.data.xmat[self.root].reshape(3, 3).T @ np.stack([ahead, np.cross(above, ahead), above], axis=1)

    def _not_told(self) -> "list[str]":
        """Columns of joints that the model does not have, and bodies that move without rows."""
        mujoco, model = self.mujoco, self.model
        named = {f"q:{model.joint(joint).name}" for joint in range(model.njnt) if int(model.jnt_type[joint]) in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))}
        lost = [f"column {column} of vehicles.csv is of no joint of {self.file.name}" for column in self.rows
                if column.startswith("q:") and column not in named and np.isfinite(self.rows[column]).any()]
        for body in range(1, model.nbody):
            free = model.body_jntnum[body] > 0 and model.jnt_type[model.body_jntadr[body]] == mujoco.mjtJoint.mjJNT_FREE
            if body != self.root and model.body_parentid[body] == 0 and (free or model.body_mocapid[body] >= 0):
                lost.append(f"{self.body_name(body)} has no rows: it is where {self.file.name} has it")
        return lost

    def qpos(self, row: int) -> "np.ndarray":
        """The model's places at a row. A root without a free joint, and joints without a column, stay as the model, or the drive's keyframe, has them."""
        mujoco, model = self.mujoco, self.model
        qpos = np.array(self.first)
        for joint in range(model.njnt):
            at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
            column = f"q:{model.joint(joint).name}"
            if kind == mujoco.mjtJoint.mjJNT_FREE and model.jnt_bodyid[joint] == self.root:
                x, y, z, w = unit_quaternion(self.turns[row] @ self.axes.T)
                qpos[at:at + 7] = [*(self.rows[axis][row] for axis in "xyz"), w, x, y, z]
            elif column in self.rows and np.isfinite(self.rows[column][row]):
                qpos[at] = self.rows[column][row]
        return qpos

    def set(self, row: int) -> None:
        """Poses of the bodies at a row. A root that is held, or moves along joints of its own, is where the model has it."""
        self.data.qpos[:] = self.qpos(row)
        self.mujoco.mj_kinematics(self.model, self.data)

    def _shift(self, row: int) -> "tuple[np.ndarray, np.ndarray]":
        """What takes the root from where the model has it to where the row says, after set: a place p goes to turn p + move. Returns turn, move."""
        turn = self.turns[row] @ self.axes.T @ self.data.xmat[self.root].reshape(3, 3).T
        return turn, np.array([self.rows[axis][row] for axis in "xyz"]) - turn @ self.data.xpos[self.root]

    def moves_at(self, row: int) -> "tuple[np.ndarray, np.ndarray]":
        """Places and turns (3 x 3) of all bodies at a row, shifted so that the root is exactly where the row says."""
        self.set(row)
        turn, move = self._shift(row)
        return np.array(self.data.xpos) @ turn.T + move, turn @ np.array(self.data.xmat).reshape(-1, 3, 3)

    def bases_at(self, row: int) -> "dict[int, tuple[np.ndarray, np.ndarray]]":
        """Of each body below the model's world its place and turn (3 x 3) where its joints, other than free ones, are at 0, shifted as moves_at does."""
        places, turns = self.moves_at(row)
        turn, move = self._shift(row)
        bases = {}
        for body in range(1, self.model.nbody):
            if self.model.body_parentid[body] != 0:
                continue
            if self.model.body_jntnum[body] > 0 and self.model.jnt_type[self.model.body_jntadr[body]] == self.mujoco.mjtJoint.mjJNT_FREE:
                bases[body] = places[body], turns[body]
                continue
            own = np.empty(9)
            self.mujoco.mju_quat2Mat(own, self.model.body_quat[body])
            bases[body] = turn @ self.model.body_pos[body] + move, turn @ own.reshape(3, 3)
        return bases

    def body_name(self, body: int) -> str:
        """Its own, or body_N."""
        return self.model.body(body).name or f"body_{body}"

    def parts(self, body: int) -> "Iterator[Part]":
        """The shapes of a body that pictures show, and those that collide."""
        model = self.model
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            kind = _KINDS.get(int(model.geom_type[geom]))
            collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
            if kind is None or (model.geom_group[geom] > 2 and not collides):
                continue
            turn = np.empty(9)
            self.mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
            colour = model.mat_rgba[model.geom_matid[geom]] if model.geom_matid[geom] >= 0 else model.geom_rgba[geom]
            vertices = faces = None
            if kind == "mesh":
                mesh = model.geom_dataid[geom]
                vertices = np.array(model.mesh_vert[model.mesh_vertadr[mesh]:model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh]], float)
                faces = np.array(model.mesh_face[model.mesh_faceadr[mesh]:model.mesh_faceadr[mesh] + model.mesh_facenum[mesh]])
            yield Part(model.geom(geom).name or f"geom_{geom}", kind, [float(value) for value in model.geom_size[geom]], model.geom_pos[geom], turn.reshape(3, 3),
                       [float(value) for value in colour[:3]], vertices, faces, collides)

    def movers(self) -> "list[Mover]":
        """All bodies that have shapes, at each row."""
        count, rows = self.model.nbody, len(self.rows["t"])
        places, turns = np.empty((count, rows, 3)), np.empty((count, rows, 4))
        for row in range(rows):
            at, axes = self.moves_at(row)
            places[:, row] = at
            for body in range(1, count):
                q = unit_quaternion(axes[body])
                turns[body, row] = -q if row > 0 and q @ turns[body, row - 1] < 0 else q
        return [Mover(f"{self.name}/{self.body_name(body)}", list(self.parts(body)), self.rows["t"], places[body], turns[body]) for body in range(1, count) if self.model.body_geomnum[body] > 0]


# --- objects on paths ---

def _object_part(drive: Drive, name: str) -> "Union[Part, None]":
    number = {key: float(_of_scene(drive, f"objects.{name}.shape.{key}") or 0) for key in ("sphere.radius", "wheel.radius", "wheel.width", "cylinder.radius", "cylinder.length", "capsule.radius", "capsule.length")}
    grey, here = [0.5, 0.5, 0.5], np.zeros(3)
    if number["sphere.radius"]:
        return Part(name, "sphere", [number["sphere.radius"]], here, np.eye(3), grey)
    if number["wheel.radius"]:  # its axis is y
        return Part(name, "cylinder", [number["wheel.radius"], number["wheel.width"] / 2], here, np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), [0.1, 0.1, 0.1])
    for kind in ("cylinder", "capsule"):
        if number[f"{kind}.radius"]:
            return Part(name, kind, [number[f"{kind}.radius"], number[f"{kind}.length"] / 2], here, np.eye(3), grey)
    for kind, key in (("box", "size"), ("ellipsoid", "radii")):
        sides = _of_scene(drive, f"objects.{name}.shape.{kind}.{key}")
        if sides is not None:
            half = [float(value) / (2 if kind == "box" else 1) for value in re.findall(r"[-+.\deE]+", sides)]
            return Part(name, kind, half, here, np.eye(3), grey)
    return None


def _headings(places: "np.ndarray") -> "np.ndarray":
    """x, y, z, w along the way in plan: rows of objects tell no attitude. Where it does not move it looks as before."""
    ahead = np.gradient(places[:, :2], axis=0) if len(places) > 1 else np.zeros((len(places), 2))
    yaw, last = np.zeros(len(places)), 0.0
    moving = np.hypot(ahead[:, 0], ahead[:, 1]) > 1e-9
    if moving.any():
        last = float(np.arctan2(*ahead[np.argmax(moving)][::-1]))
    for i, (x, y) in enumerate(ahead):
        last = float(np.arctan2(y, x)) if moving[i] else last
        yaw[i] = last
    yaw = np.unwrap(yaw)
    return np.stack([np.zeros_like(yaw), np.zeros_like(yaw), np.sin(yaw / 2), np.cos(yaw / 2)], axis=1)


def objects(drive: Drive) -> "list[Mover]":
    """Objects of the scene that have rows and a shape that is no mesh. They look along their way, level: rows tell no attitude."""
    found = []
    for name, rows in drive.objects.items():
        part = _object_part(drive, name)
        if part is None:
            continue
        places = np.stack([rows[axis] for axis in "xyz"], axis=1)
        known = np.isfinite(places).all(axis=1)
        if known.any():
            found.append(Mover(name, [part], rows["t"][known], places[known], _headings(places[known])))
    return found


def models(drive: Drive, without: bool = False) -> "list[Model]":
    """The models of all vehicles that have rows."""
    return [] if without else [Model(drive, name) for name in drive.vehicles]


Path = Union[str, "os.PathLike[str]"]


def ground_colours(own: Ground) -> "np.ndarray":
    """How the ground looks: rows x columns x 3, 0 to 1 (sRGB), the southern row first. Soil in the light of a sun in the north-west; ruts are darker, heaps lighter."""
    heights = own.filled()
    slope_y, slope_x = np.gradient(heights, own.spacing)
    light = (0.5 * slope_x - 0.5 * slope_y + 0.7) / np.sqrt(slope_x ** 2 + slope_y ** 2 + 1)
    most = max(float(np.abs(own.offsets).max()), 1e-6)
    rut = np.clip(own.offsets / most, -1, 1)
    shade = np.clip(0.35 + 0.65 * light, 0.15, 1.0) * (1 + 0.35 * rut)
    return np.clip(shade[..., None] * np.array([0.66, 0.56, 0.42]), 0, 1)
