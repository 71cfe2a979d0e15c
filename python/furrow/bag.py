"""A drive as a bag for ROS 2's tools: `furrow bag DIR -o run.mcap`, or furrow.bag.write("out", "run.mcap").

Needs the packages mcap and mcap-ros2-support. Times are simulated, from 0. Frames: `map` is the store's axes, x east, y north, z up, in metres from its
south-west post; NAME/base_link is a vehicle's root body, x forward; CAMERA is x right, y down, z ahead.
"""
import pathlib
import sys
from typing import Any, Iterator, Union

import numpy as np

from furrow import _command, _ros, _sensors, lens
from furrow.results import Drive, ResultsError, nanoseconds, quaternions, rotate_back, turn_rates

ABOUT = """Writes a drive as a bag of ROS 2 (mcap): clock, tf, and of each vehicle odometry, joint states, IMUs and ranges; of each camera its pictures
and camera info; clouds of points of lidars and, with --points, of cameras with depth.

  furrow drive scene.yaml -o out && furrow bag out -o run.mcap
  ros2 bag play run.mcap --clock"""

Path = Union[str, "pathlib.Path"]
Message = "tuple[int, str, str, dict[str, Any]]"  # ns, topic, type, message
UNKNOWN = [0.0] * 36


def _stamp(ns: int) -> "dict[str, int]":
    return {"sec": ns // 10**9, "nanosec": ns % 10**9}


def _header(ns: int, frame: str) -> "dict[str, Any]":
    return {"stamp": _stamp(ns), "frame_id": frame}


def _named(values: Any, names: str = "xyz") -> "dict[str, float]":
    return {name: float(value) for name, value in zip(names, values)}


def _transform(ns: int, child: str, at: Any, turn: Any) -> "dict[str, Any]":
    return {"header": _header(ns, "map"), "child_frame_id": child, "transform": {"translation": _named(at), "rotation": _named(turn, "xyzw")}}


def _topic(*parts: str) -> str:
    """A topic of names as ROS takes them: of A-Z a-z 0-9 _, without a digit first."""
    words = ["".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in word) for part in parts for word in part.split("/") if word]
    return "".join("/" + ("_" if word[0].isdigit() else "") + word for word in words)


def _still(ns: int, frames: "list[dict[str, Any]]") -> "list[dict[str, Any]]":
    """Where sensors are on their vehicle. A beam of ROS goes along x, and one of MuJoCo along z."""
    transforms = []
    for frame in frames:
        transforms.append(_transform(ns, frame["name"], frame["position"], frame["orientation"]))
        transforms[-1]["header"]["frame_id"] = frame["parent"]
    return transforms


def _of_frames(rows: "dict[str, np.ndarray]", frames: "list[dict[str, Any]]") -> "Iterator[Message]":
    """Of a vehicle that has rows of sensors alone."""
    for t in rows["t"]:
        yield nanoseconds(t), "/tf", "tf2_msgs/TFMessage", {"transforms": _still(nanoseconds(t), frames)}


def _of_vehicle(name: str, rows: "dict[str, np.ndarray]", frames: "list[dict[str, Any]]") -> "Iterator[Message]":
    """`frames`: of sensors that are fixed to it. They come with each row: players do not keep what was told once for those that listen later."""
    turns = quaternions(rows)
    at = np.stack([rows["x"], rows["y"], rows["z"]], axis=1)
    linear = rotate_back(turns, np.stack([rows["vx"], rows["vy"], rows["vz"]], axis=1))
    angular = turn_rates(rows["t"], turns)
    joints = [column for column in rows if column.startswith("q:")]
    base = f"{name}/base_link"
    for i, t in enumerate(rows["t"]):
        ns = nanoseconds(t)
        yield ns, "/tf", "tf2_msgs/TFMessage", {"transforms": [_transform(ns, base, at[i], turns[i]), *_still(ns, frames)]}
        yield ns, _topic(name, "odom"), "nav_msgs/Odometry", {
            "header": _header(ns, "map"), "child_frame_id": base,
            "pose": {"pose": {"position": _named(at[i]), "orientation": _named(turns[i], "xyzw")}, "covariance": UNKNOWN},
            "twist": {"twist": {"linear": _named(linear[i]), "angular": _named(angular[i])}, "covariance": UNKNOWN}}
        if joints:
            yield ns, _topic(name, "joint_states"), "sensor_msgs/JointState", {
                "header": _header(ns, base), "name": [column[2:] for column in joints],
                "position": [float(rows[column][i]) for column in joints], "velocity": [], "effort": []}


def _of_object(name: str, rows: "dict[str, np.ndarray]") -> "Iterator[Message]":
    for i, t in enumerate(rows["t"]):
        values = [float(rows[column][i]) for column in ("fx", "fy", "fz", "tx", "ty", "tz")]
        if np.isfinite(values).all():
            yield nanoseconds(t), _topic(name.replace(".", "/"), "soil"), "geometry_msgs/WrenchStamped", {
                "header": _header(nanoseconds(t), "map"), "wrench": {"force": _named(values[:3]), "torque": _named(values[3:])}}


def _diagonal(deviation: float) -> "list[float]":
    square = deviation * deviation
    return [square, 0.0, 0.0, 0.0, square, 0.0, 0.0, 0.0, square]


def _of_imu(imu: "dict[str, Any]") -> "Iterator[Message]":
    """At rest the linear acceleration is what holds it against gravity, as REP 145 says. Without an attitude its covariance begins with -1."""
    turns = imu["orientation"]
    for i, t in enumerate(imu["t"]):
        ns = nanoseconds(t)
        yield ns, _topic(imu["vehicle"], imu["name"]), "sensor_msgs/Imu", {
            "header": _header(ns, imu["frame"]["name"]), "orientation": _named(turns[i] if turns is not None else [0.0, 0.0, 0.0, 1.0], "xyzw"),
            "orientation_covariance": [0.0] * 9 if turns is not None else [-1.0] + [0.0] * 8,
            "angular_velocity": _named(imu["gyro"][i]), "angular_velocity_covariance": _diagonal(imu["noise"]["gyro"]),
            "linear_acceleration": _named(imu["accelerometer"][i]), "linear_acceleration_covariance": _diagonal(imu["noise"]["accelerometer"])}


def _of_range(finder: "dict[str, Any]") -> "Iterator[Message]":
    for t, told in zip(finder["t"], finder["range"]):
        ns = nanoseconds(t)
        yield ns, _topic(finder["vehicle"], finder["name"], "range"), "sensor_msgs/Range", {
            "header": _header(ns, finder["frame"]["name"] + "/beam"), "radiation_type": 1, "field_of_view": 0.0, "min_range": 0.0,
            "max_range": float(finder["cutoff"]) if finder["cutoff"] > 0 else float("inf"), "range": float(told)}


def _beam(frame: "dict[str, Any]") -> "dict[str, Any]":
    """The frame of a beam: its x is the site's z. The turn about (1, 1, 1) by -120 degrees takes z to x."""
    x, y, z, w = frame["orientation"]
    a, b, c, d = 0.5, 0.5, 0.5, -0.5
    return {**frame, "name": frame["name"] + "/beam", "orientation": [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c]}


def _cloud_of(ns: int, frame: str, points: "np.ndarray") -> "dict[str, Any]":
    data = points.astype("<f4")
    return {"header": _header(ns, frame), "height": 1, "width": len(data), "is_bigendian": False, "point_step": 12, "row_step": 12 * len(data),
            "fields": [{"name": axis, "offset": 4 * i, "datatype": 7, "count": 1} for i, axis in enumerate("xyz")], "data": data.tobytes(), "is_dense": True}


def _of_lidar(name: str, lidar: "dict[str, Any]") -> "Iterator[Message]":
    for frame in lidar["frames"]:
        ns = nanoseconds(frame["time"])
        yield ns, "/tf", "tf2_msgs/TFMessage", {"transforms": [_transform(ns, name, frame["position"], frame["orientation"])]}
        yield ns, _topic(name, "points"), "sensor_msgs/PointCloud2", _cloud_of(ns, name, _sensors.points(lidar, frame["frame"]))


def _info(ns: int, name: str, camera: "dict[str, Any]", right: "float") -> "dict[str, Any]":
    """ROS counts pixels from the first one's centre. `right`: m, how far the camera is to the right of the first of its pair."""
    fx, fy, cx, cy = camera["fx"], camera["fy"], camera["cx"] - 0.5, camera["cy"] - 0.5
    fisheye = camera["model"] == "fisheye"
    return {"header": _header(ns, name), "height": camera["height"], "width": camera["width"], "distortion_model": "equidistant" if fisheye else "plumb_bob",
            "d": [0.0] * 5 if camera["distortion"] == "none" else list(camera["distortion"]),
            "k": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "r": [1, 0, 0, 0, 1, 0, 0, 0, 1], "p": [fx, 0, cx, -fx * right, 0, fy, cy, 0, 0, 0, 1, 0],
            "binning_x": 0, "binning_y": 0, "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}}


def _cloud(ns: int, name: str, camera: "dict[str, Any]", depth: "np.ndarray") -> "dict[str, Any]":
    """The points of a picture of depth, along the camera's axes. Sky has none."""
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns].astype(np.float64)
    places = np.stack([(columns + 0.5 - camera["cx"]) / camera["fx"], (rows + 0.5 - camera["cy"]) / camera["fy"]], axis=1)
    rays = lens.undistort(camera["model"], camera["distortion"], places)
    return _cloud_of(ns, name, rays / rays[:, 2:] * z[:, None])


def _of_camera(name: str, camera: "dict[str, Any]", points: bool) -> "Iterator[Message]":
    """A camera's pictures. Colours are the bytes of their PNG; depth is that of .npy."""
    pair = camera.get("stereo", {})
    right = pair.get("baseline", 0.0) if "left" in pair else 0.0
    for frame in camera["frames"]:
        ns, file = nanoseconds(frame["time"]), f"{frame['frame']:06d}"
        yield ns, "/tf", "tf2_msgs/TFMessage", {"transforms": [_transform(ns, name, frame["position"], frame["orientation"])]}
        yield ns, _topic(name, "camera_info"), "sensor_msgs/CameraInfo", _info(ns, name, camera, right)
        for image in camera["images"]:
            png = camera["folder"] / image / f"{file}.png"
            npy = png.with_suffix(".npy")
            if image == "depth" and npy.exists():
                depth = np.load(npy)
                yield ns, _topic(name, "depth/image_raw"), "sensor_msgs/Image", {
                    "header": _header(ns, name), "height": depth.shape[0], "width": depth.shape[1], "encoding": "32FC1", "is_bigendian": 0,
                    "step": 4 * depth.shape[1], "data": depth.astype("<f4").tobytes()}
                if points:
                    yield ns, _topic(name, "points"), "sensor_msgs/PointCloud2", _cloud(ns, name, camera, depth)
            elif png.exists():
                topic = _topic(name, "" if image == "colour" else image, "image_raw/compressed")
                yield ns, topic, "sensor_msgs/CompressedImage", {"header": _header(ns, name), "format": "png", "data": png.read_bytes()}


def _in_time(sources: "list[Iterator[Message]]") -> "Iterator[Message]":
    """Messages of several sources in the order of their times; a clock comes first at each time. Only the next one of each source is held.

    ResultsError: two sources have one topic, or place one frame.
    """
    owners: "dict[str, int]" = {}
    heads = [next(source, None) for source in sources]
    told = -1
    while any(head is not None for head in heads):
        first = min((head[0], i) for i, head in enumerate(heads) if head is not None)[1]
        message = heads[first]
        assert message is not None
        names = [f"frame {each['child_frame_id']}" for each in message[3]["transforms"]] if message[1] == "/tf" else [f"topic {message[1]}"]
        for name in names:
            if owners.setdefault(name, first) != first:
                raise ResultsError(f"two parts of the drive have the {name}, and topics have A-Z a-z 0-9 and _ alone; give one of them another name")
        if message[0] > told:
            told = message[0]
            yield told, "/clock", "rosgraph_msgs/Clock", {"clock": _stamp(told)}
        yield message
        heads[first] = next(sources[first], None)


def _sources(drive: Drive, points: bool) -> "list[Iterator[Message]]":
    finders = _sensors.rangefinders(drive.sensor_list, drive.sensors)
    still = list(_sensors.frames(drive.sensor_list))
    still += [_beam(frame) for frame in still if frame["name"] in {finder["frame"]["name"] for finder in finders}]
    own = {name: [frame for frame in still if frame["parent"] == f"{name}/base_link"] for name in {**drive.vehicles, **drive.sensors}}
    sources = [_of_vehicle(name, rows, own[name]) for name, rows in drive.vehicles.items()]
    sources += [_of_frames(rows, own[name]) for name, rows in drive.sensors.items() if name not in drive.vehicles and own[name]] + [_of_object(*each) for each in drive.objects.items()]
    sources += [_of_imu(imu) for imu in drive.imus] + [_of_range(finder) for finder in finders]
    return sources + [_of_camera(*each, points) for each in drive.cameras.items()] + [_of_lidar(*each) for each in drive.lidars.items()]


def write(folder: Path, file: Path, points: bool = False) -> "dict[str, int]":
    """Writes the results in a folder as a bag. Returns how many messages each topic has. `points`: with clouds of points of pictures of depth.

    The file is there when it is whole. ResultsError: the folder has nothing for a bag. _command.Missing: mcap-ros2-support is not installed.
    """
    writer_of = _command.need("mcap_ros2.writer", "mcap-ros2-support")
    drive = Drive(folder)
    sources = _sources(drive, points)
    if not sources:
        raise ResultsError(f"{drive.folder}: the drive left no rows and no pictures; give the scene output.vehicles, output.forces, output.sensors, cameras or lidars")
    counts: "dict[str, int]" = {}
    with _command.Whole(pathlib.Path(file)) as whole:
        with open(whole, "wb") as out:
            with writer_of.Writer(out) as writer:
                schemas: "dict[str, Any]" = {}
                for ns, topic, kind, message in _in_time(sources):
                    if kind not in schemas:
                        schemas[kind] = writer.register_msgdef(_ros.full_name(kind), _ros.definition(kind))
                    writer.write_message(topic, schemas[kind], message, ns, ns, counts.get(topic, 0))
                    counts[topic] = counts.get(topic, 0) + 1
    return counts


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("bag", ABOUT)
    parser.add_argument("folder", metavar="DIR", help="what furrow drive -o wrote")
    parser.add_argument("-o", "--output", metavar="FILE.mcap", required=True)
    parser.add_argument("--points", action="store_true", help="clouds of points of pictures of depth, too")
    given = parser.parse_args(arguments)

    def work() -> None:
        counts = write(given.folder, given.output, given.points)
        for topic, count in sorted(counts.items()):
            print(f"{count:8d}  {topic}")
        print(f"{sum(counts.values())} messages of {len(counts)} topics in {given.output}")

    return _command.end("bag", work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
