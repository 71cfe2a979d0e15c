"""A drive for other simulators: `furrow world DIR -o FOLDER --format sdf|mjcf`, or furrow.world.sdf("out", "folder") and furrow.world.mjcf.

Both have the ground at the end of the drive, with its ruts, and vehicles where they were then. Vehicles need the package mujoco. x east, y north, z up, in
metres from the store's south-west post.
"""
import pathlib
import re
import struct
import sys
from typing import Any, Union
from xml.etree import ElementTree as xml

import numpy as np

from furrow import _command, _png, _stage
from furrow.dataset import _Folder
from furrow.results import Drive

ABOUT = """Writes the ground at the end of a drive, with its ruts, and the vehicles, as a world for Gazebo (SDF) or MuJoCo (MJCF with a height field).

  furrow drive scene.yaml -o out && furrow world out -o site --format mjcf
  python -m mujoco.viewer --mjcf=site/world.xml"""

BASE = 1.0    # m: of a height field below its lowest post
LIGHT = 1e-4, 1e-8  # kg, kg m2: of links of SDF without mass, which would get 1 kg there
SDF_POSTS_MOST = 1025


def _numbers(values: "Any") -> str:
    return " ".join(f"{float(value):.17g}" for value in values)


def _small(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)


def _angles(turn: "np.ndarray") -> "tuple[float, float, float]":
    """roll, pitch, yaw of SDF: about the fixed x, then y, then z."""
    return (float(np.arctan2(turn[2, 1], turn[2, 2])), float(np.arctan2(-turn[2, 0], np.hypot(turn[2, 1], turn[2, 2]))), float(np.arctan2(turn[1, 0], turn[0, 0])))


# --- MJCF ---

def _height_file(own: "_stage.Ground") -> "tuple[bytes, float]":
    """MuJoCo's own file of a height field: rows and columns as int32, then float32 from the south; and the range of heights, m."""
    rows, columns = own.heights.shape
    reach = max(own.high - own.low, 1e-6)
    return struct.pack("<ii", rows, columns) + ((own.filled() - own.low) / reach).astype("<f4").tobytes(), reach


def _save_model(model: "_stage.Model", folder: pathlib.Path, taken: "set[str]") -> str:
    """Writes a vehicle's model, its root body in the origin, beside the world. Files of meshes stay where they are. MuJoCo writes 6 digits: places of a
    terrain are in world.xml."""
    spec = model.spec
    bases = model.bases_at(len(model.rows["t"]) - 1)
    origin, axes = bases[model.root]
    for body in spec.worldbody.bodies:
        place, turn = bases[body.id]
        x, y, z, w = _stage.unit_quaternion(axes.T @ turn)
        frame = body
        while frame is not None:  # frames of MJCF around it, too
            frame.alt.type = model.mujoco.mjtOrientation.mjORIENTATION_QUAT
            frame.pos, frame.quat = [0, 0, 0], [1, 0, 0, 0]
            frame = frame.frame
        body.pos, body.quat = axes.T @ (place - origin), [w, x, y, z]
    for geom in list(spec.worldbody.geoms):  # its own floor
        spec.delete(geom)
    for camera in [*spec.worldbody.cameras, *spec.worldbody.lights]:
        spec.delete(camera)
    for key in list(spec.keys):
        spec.delete(key)
    for name in ("meshdir", "texturedir"):
        setattr(spec, name, str((model.file.parent / (getattr(spec, name) or "")).resolve()))
    spec.compile()
    name = f"{_stage.unused(_small(model.name), taken)}.xml"
    (folder / name).write_text(spec.to_xml(), encoding="utf-8")
    return name


def mjcf(folder: _stage.Path, to: _stage.Path, window: "Union[list[float], None]" = None, vehicles: bool = True) -> "dict[str, Any]":
    """Writes a folder with world.xml, ground.bin and the models of the vehicles. Returns {posts, spacing, vehicles, lost}.

    lost: what cannot be told of the vehicles, a line each. A keyframe `end` has the vehicles' joints. The folder is there when it is whole. ResultsError: the store is gone, or the window or a model cannot be used.
    _command.Missing: mujoco is not installed, and there are vehicles.
    """
    drive = Drive(folder)
    own = _stage.ground(drive, window)
    models = _stage.models(drive, not vehicles)
    wide, tall = own.size()
    data, reach = _height_file(own)
    root = xml.Element("mujoco", model="furrow")
    xml.SubElement(root, "option", gravity=f"0 0 {-float(_gravity(drive)):.17g}", integrator="implicitfast")
    asset, world = xml.SubElement(root, "asset"), xml.SubElement(root, "worldbody")
    xml.SubElement(asset, "hfield", name="ground", file="ground.bin", size=_numbers([wide / 2, tall / 2, reach, BASE]))
    xml.SubElement(asset, "texture", name="ground", type="2d", file="ground.png")
    xml.SubElement(asset, "material", name="ground", texture="ground", texuniform="false")
    xml.SubElement(world, "light", directional="true", dir="0.5 -0.5 -1", pos=_numbers([own.x + wide / 2, own.y + tall / 2, own.high + 50]))
    xml.SubElement(world, "geom", name="ground", type="hfield", hfield="ground", material="ground", pos=_numbers([own.x + wide / 2, own.y + tall / 2, own.low]))
    with _Folder(pathlib.Path(to)) as whole:
        (whole / "ground.bin").write_bytes(data)
        (whole / "ground.png").write_bytes(_png.colours(np.rint(255 * _stage.ground_colours(own)[::-1])))
        qpos: "list[float]" = []
        taken = {"world"}
        for model in models:
            model.set(len(model.rows["t"]) - 1)
            qpos += list(model.data.qpos)
            xml.SubElement(asset, "model", name=model.name, file=_save_model(model, whole, taken))
            place, turn = model.bases_at(len(model.rows["t"]) - 1)[model.root]
            frame = xml.SubElement(world, "frame", pos=_numbers(place), quat=_numbers(np.roll(_stage.unit_quaternion(turn), 1)))
            xml.SubElement(frame, "attach", model=model.name, prefix=f"{model.name}/")
        if qpos:
            xml.SubElement(xml.SubElement(root, "keyframe"), "key", name="end", qpos=_numbers(qpos))
        xml.indent(root)
        xml.ElementTree(root).write(whole / "world.xml", encoding="utf-8")
    return {"posts": list(own.heights.shape[::-1]), "spacing": own.spacing, "vehicles": [model.name for model in models], "lost": _lost(models)}


def _lost(models: "list[_stage.Model]") -> "list[str]":
    return [f"{model.name}: {text}" for model in models for text in model.lost]


def _gravity(drive: Drive) -> float:
    return float(drive.facts["scene"]["values"].get("gravity", 9.81))


# --- SDF ---

def _square(own: "_stage.Ground") -> "_stage.Ground":
    """The ground as a square of 2^n + 1 posts, as Gazebo wants it: interpolated between its posts, over the smaller side."""
    rows, columns = own.heights.shape
    side = min(own.size())
    posts = 2
    while posts + 1 < min(rows, columns) and 2 * posts + 1 <= SDF_POSTS_MOST:
        posts *= 2
    at = np.linspace(0, side / own.spacing, posts + 1)
    low = np.minimum(at.astype(int), min(rows, columns) - 2)
    part = at - low

    def across(values: "np.ndarray") -> "np.ndarray":
        south, north = values[low], values[low + 1]
        lines = south + part[:, None] * (north - south)
        return lines[:, low] + part[None, :] * (lines[:, low + 1] - lines[:, low])

    return _stage.Ground(across(own.filled()), across(own.offsets), own.x, own.y, side / posts)


def _pose(parent: Any, place: "Any", turn: "np.ndarray", relative: "Union[str, None]" = None) -> None:
    pose = xml.SubElement(parent, "pose", {"relative_to": relative} if relative else {})
    pose.text = _numbers([*place, *_angles(turn)])


def _geometry(parent: Any, part: "_stage.Part", folder: pathlib.Path, name: str, files: "set[str]") -> None:
    own = xml.SubElement(parent, "geometry")
    shape = xml.SubElement(own, part.kind)
    if part.kind == "box":
        xml.SubElement(shape, "size").text = _numbers([2 * half for half in part.size])
    elif part.kind == "ellipsoid":
        xml.SubElement(shape, "radii").text = _numbers(part.size)
    elif part.kind == "mesh":
        file = f"meshes/{_stage.unused(_small(name), files)}.obj"
        (folder / "meshes").mkdir(exist_ok=True)
        (folder / file).write_text("".join(f"v {_numbers(v)}\n" for v in part.vertices) + "".join("f " + " ".join(str(i + 1) for i in f) + "\n" for f in part.faces), encoding="ascii")
        xml.SubElement(shape, "uri").text = file
    else:
        xml.SubElement(shape, "radius").text = _numbers(part.size[:1])
        if part.kind != "sphere":
            xml.SubElement(shape, "length").text = _numbers([2 * part.size[1]])


def _link(parent: Any, model: "_stage.Model", body: int, name: str, place: "np.ndarray", turn: "np.ndarray", folder: pathlib.Path, files: "set[str]") -> None:
    link = xml.SubElement(parent, "link", name=name)
    _pose(link, place, turn)
    mass, inertia = float(model.model.body_mass[body]), model.model.body_inertia[body]
    if not mass > 0:
        mass, inertia = LIGHT[0], [LIGHT[1]] * 3
    inner = np.empty(9)
    model.mujoco.mju_quat2Mat(inner, model.model.body_iquat[body])
    inertial = xml.SubElement(link, "inertial")
    _pose(inertial, model.model.body_ipos[body], inner.reshape(3, 3))
    xml.SubElement(inertial, "mass").text = f"{mass:.17g}"
    matrix = xml.SubElement(inertial, "inertia")
    for key, value in (("ixx", inertia[0]), ("ixy", 0), ("ixz", 0), ("iyy", inertia[1]), ("iyz", 0), ("izz", inertia[2])):
        xml.SubElement(matrix, key).text = f"{float(value):.17g}"
    for number, part in enumerate(model.parts(body)):
        for kind in ("visual", "collision") if part.collides else ("visual",):
            shape = xml.SubElement(link, kind, name=f"{kind}_{number}")
            _pose(shape, part.at, part.turn)
            _geometry(shape, part, folder, f"{model.name}_{name}_{number}", files)
            if kind == "visual":
                material = xml.SubElement(shape, "material")
                for word in ("ambient", "diffuse"):
                    xml.SubElement(material, word).text = _numbers([*part.colour, 1])


def _name_once(name: str, taken: "set[str]", ending: str = "") -> str:
    """A name of SDF that no link and no joint of the model has: they have one namespace."""
    name = name.replace("::", "_")
    return _stage.unused(name + ending if ending and name in taken else name, taken)


def _joint(parent: Any, model: "_stage.Model", body: int, names: "dict[int, str]", taken: "set[str]") -> "list[str]":
    """The joint between a body and the one above. Returns what SDF cannot have of it."""
    mujoco, own = model.mujoco, model.model
    above, first, count = int(own.body_parentid[body]), int(own.body_jntadr[body]), int(own.body_jntnum[body])
    kinds = {int(mujoco.mjtJoint.mjJNT_HINGE): "revolute", int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic", int(mujoco.mjtJoint.mjJNT_BALL): "ball"}
    if count > 0 and int(own.jnt_type[first]) == int(mujoco.mjtJoint.mjJNT_FREE):
        return []
    kind = kinds[int(own.jnt_type[first])] if count > 0 else "fixed"
    name = (own.joint(first).name if count > 0 else "") or f"{'hold' if above == 0 else 'joint'}_{names[body]}"
    joint = xml.SubElement(parent, "joint", name=_name_once(name, taken, "_joint"), type=kind)
    xml.SubElement(joint, "parent").text, xml.SubElement(joint, "child").text = names.get(above, "world"), names[body]
    if count > 0:
        _pose(joint, own.jnt_pos[first], np.eye(3), names[body])
    if kind in ("revolute", "prismatic"):
        axis = xml.SubElement(joint, "axis")
        xml.SubElement(axis, "xyz").text = _numbers(own.jnt_axis[first])
        limit = xml.SubElement(axis, "limit")
        now = float(model.data.qpos[own.jnt_qposadr[first]])
        for word, end in (("lower", 0), ("upper", 1)):  # SDF's 0 is the pose that is written
            xml.SubElement(limit, word).text = f"{float(own.jnt_range[first][end]) - now:.17g}" if own.jnt_limited[first] else ("-1e16", "1e16")[end]
        dynamics = xml.SubElement(axis, "dynamics")
        xml.SubElement(dynamics, "damping").text = f"{float(np.ravel(own.dof_damping[own.jnt_dofadr[first]])[0]):.17g}"
    return [f"{names[body]} has {count} joints, and SDF takes the first"] if count > 1 else []


def _not_of_sdf(model: "_stage.Model", names: "dict[int, str]") -> "list[str]":
    """What a model has, and SDF has not."""
    own = model.model
    light = [name for body, name in names.items() if not own.body_mass[body] > 0]
    told = [f"its {word} ({count}) are left out: SDF has none" for count, word in ((int(own.neq), "equalities"), (int(own.ntendon), "tendons"), (int(own.nu), "actuators")) if count > 0]
    if light:
        told.append(f"{', '.join(light[:3])}{f' and {len(light) - 3} others' if len(light) > 3 else ''}: without mass in the model, with {LIGHT[0]:g} kg in SDF")
    return told


def _sdf_model(world: Any, model: "_stage.Model", folder: pathlib.Path, files: "set[str]", models: "set[str]") -> "list[str]":
    row = len(model.rows["t"]) - 1
    places, turns = model.moves_at(row)
    taken: "set[str]" = set()
    names = {body: _name_once(model.body_name(body), taken) for body in range(1, model.model.nbody)}
    own = xml.SubElement(world, "model", name=_name_once(model.name, models, "_vehicle"))
    _pose(own, places[model.root], turns[model.root])
    back = turns[model.root].T
    told = model.lost + _not_of_sdf(model, names)
    for body, name in names.items():
        _link(own, model, body, name, back @ (places[body] - places[model.root]), back @ turns[body], folder, files)
    for body in names:
        told += _joint(own, model, body, names, taken)
    return told


def _heightmap(link: Any, own: "_stage.Ground", reach: float) -> None:
    """The ground for physics and for pictures. Gazebo's physics places a heightmap by the pose of its collision, and lays its posts size / posts apart; its
    pictures go by `pos`, and lay them size / (posts - 1) apart."""
    wide, tall = own.size()
    posts = own.heights.shape[0]
    place = [own.x + wide / 2, own.y + tall / 2, own.low]
    for kind, share in (("collision", posts / (posts - 1)), ("visual", 1.0)):
        shape = xml.SubElement(link, kind, name=kind)
        if kind == "collision":
            _pose(shape, place, np.eye(3))
        field = xml.SubElement(xml.SubElement(shape, "geometry"), "heightmap")
        xml.SubElement(field, "uri").text = "heightmap.png"
        xml.SubElement(field, "size").text = _numbers([wide * share, tall * share, reach])
        if kind == "visual":
            xml.SubElement(field, "pos").text = _numbers(place)
            texture = xml.SubElement(field, "texture")
            xml.SubElement(texture, "diffuse").text = "ground.png"
            xml.SubElement(texture, "normal").text = "flat.png"
            xml.SubElement(texture, "size").text = f"{max(wide, tall):.17g}"


def sdf(folder: _stage.Path, to: _stage.Path, window: "Union[list[float], None]" = None, vehicles: bool = True) -> "dict[str, Any]":
    """Writes a folder with world.sdf, heightmap.png and texture. Returns {posts, spacing, vehicles, lost}. lost: what SDF cannot have.

    Gazebo's ground is a square of 2^n + 1 posts, over the smaller side of the window, with 65535 steps of height. The folder is there when it is whole.
    Errors: as of mjcf.
    """
    drive = Drive(folder)
    own = _square(_stage.ground(drive, window))
    models = _stage.models(drive, not vehicles)
    reach = max(own.high - own.low, 1e-6)
    root = xml.Element("sdf", version="1.9")
    world = xml.SubElement(root, "world", name="furrow")
    xml.SubElement(world, "gravity").text = f"0 0 {-_gravity(drive):.17g}"
    light = xml.SubElement(world, "light", name="sun", type="directional")
    xml.SubElement(light, "direction").text = "0.5 -0.5 -1"
    ground = xml.SubElement(world, "model", name="ground")
    xml.SubElement(ground, "static").text = "true"
    link = xml.SubElement(ground, "link", name="ground")
    _heightmap(link, own, reach)
    lost: "list[str]" = []
    with _Folder(pathlib.Path(to)) as whole:
        heights = np.rint((own.heights - own.low) / reach * 65535)
        (whole / "heightmap.png").write_bytes(_png.grey16(heights[::-1]))
        (whole / "ground.png").write_bytes(_png.colours(np.rint(255 * _stage.ground_colours(own)[::-1])))
        (whole / "flat.png").write_bytes(_png.colours(np.full((4, 4, 3), [128, 128, 255])))
        files: "set[str]" = set()
        taken = {"ground"}
        for model in models:
            lost += [f"{model.name}: {text}" for text in _sdf_model(world, model, whole, files, taken)]
        xml.indent(root)
        xml.ElementTree(root).write(whole / "world.sdf", encoding="utf-8", xml_declaration=True)
    return {"posts": list(own.heights.shape[::-1]), "spacing": own.spacing, "vehicles": [model.name for model in models], "lost": lost}


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("world", ABOUT)
    parser.add_argument("folder", metavar="DIR", help="what furrow drive -o wrote")
    parser.add_argument("-o", "--output", metavar="FOLDER", required=True)
    parser.add_argument("--format", choices=["mjcf", "sdf"], default="mjcf")
    parser.add_argument("--window", metavar="X0,Y0,X1,Y1", help="of the ground, m")
    parser.add_argument("--no-vehicles", action="store_true", help="the ground alone")
    given = parser.parse_args(_command.joined(arguments, "--window"))

    def work() -> None:
        told = (mjcf if given.format == "mjcf" else sdf)(given.folder, given.output, _command.window(given.window), not given.no_vehicles)
        for text in told.get("lost", []):
            print(f"furrow: note: {text}", file=sys.stderr)
        print(f"{given.output}/world.{'xml' if given.format == 'mjcf' else 'sdf'}: ground of {told['posts'][0]} x {told['posts'][1]} posts at {told['spacing']:.4g} m"
              + (f", {', '.join(told['vehicles'])}" if told["vehicles"] else ""))

    return _command.end("world", work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
