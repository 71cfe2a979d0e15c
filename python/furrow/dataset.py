"""A drive as a dataset of odometry and depth: `furrow dataset DIR -o FOLDER`, or furrow.dataset.euroc("out", "sequence") and furrow.dataset.tum.

The layouts are those of the EuRoC MAV dataset (mav0: cam0, imu0, state_groundtruth_estimate0) and of the TUM RGB-D benchmark (rgb, depth, groundtruth.txt).
Times are simulated. The frame of EuRoC's poses is the store's axes, in metres from its south-west post.
"""
import os
import pathlib
import shutil
import sys
from typing import Any, Union

import numpy as np

from furrow import _command, _png
from furrow.results import Drive, ResultsError, matrices, nanoseconds, quaternions

Path = Union[str, "os.PathLike[str]"]
TUM_UNITS = 5000  # of depth in a metre
STEADY = 1e-3     # m, rad: a camera that moves more against its vehicle is no camera of EuRoC


class _Folder(_command.Whole):
    """A folder that is there when it is whole."""

    def __init__(self, path: pathlib.Path) -> None:
        if path.exists():
            raise ResultsError(f"{path}: it is there already; give another folder")
        super().__init__(path)

    def __enter__(self) -> pathlib.Path:
        self.beside.mkdir(parents=True)
        return self.beside

    def __exit__(self, kind: Any, value: Any, trace: Any) -> None:
        if kind is not None:
            shutil.rmtree(self.beside, ignore_errors=True)
        else:
            super().__exit__(kind, value, trace)


def _same_file(source: pathlib.Path, to: pathlib.Path) -> None:
    try:
        os.link(source, to)
    except OSError:
        shutil.copyfile(source, to)


def _pose_of(drive: Drive, vehicle: str) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Times, places and attitudes (as matrices) of a vehicle's root body."""
    rows = drive.vehicles[vehicle]
    return rows["t"], np.stack([rows["x"], rows["y"], rows["z"]], axis=1), matrices(quaternions(rows))


def _mount(drive: Drive, camera: "dict[str, Any]") -> "np.ndarray":
    """The constant 4 x 4 matrix from a camera's axes to those of its vehicle's root body."""
    times, places, axes = _pose_of(drive, camera["on"])
    mounts = []
    for frame in camera["frames"]:
        at = int(np.argmin(np.abs(times - frame["time"])))
        if abs(times[at] - frame["time"]) > 1e-9:
            continue
        own = matrices(np.array([frame["orientation"]]))[0]
        mount = np.eye(4)
        mount[:3, :3] = axes[at].T @ own
        mount[:3, 3] = axes[at].T @ (np.array(frame["position"]) - places[at])
        mounts.append(mount)
    if not mounts:
        raise ResultsError(f"cameras.{camera['name']}: no row of vehicles.csv has the time of a picture; give output.vehicles the camera's rate, or a multiple of it")
    if max(np.abs(mount - mounts[0]).max() for mount in mounts) > STEADY:
        raise ResultsError(f"cameras.{camera['name']}: it moves against the root body of {camera['on']}, and EuRoC has cameras that do not; mount it on the root body, or give --format tum")
    return mounts[0]


def _imu_of(drive: Drive, vehicle: str) -> "Union[dict[str, Any], None]":
    """An IMU that is fixed to the root body of a vehicle: that of the scene, or the first one of the model."""
    own = [imu for imu in drive.imus if imu["vehicle"] == vehicle and imu["frame"]["parent"] == f"{vehicle}/base_link"]
    named = {imu["name"]: imu for imu in reversed(own)}
    return named.get("imu.site", named.get("imu", own[0] if own else None))  # the scene's is imu.site where the model has an imu


def _euroc_imu(folder: pathlib.Path, drive: Drive, imu: "dict[str, Any]") -> None:
    folder.mkdir()
    with open(folder / "data.csv", "w", encoding="ascii") as file:
        file.write("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n")
        for t, gyro, force in zip(imu["t"], imu["gyro"], imu["accelerometer"]):
            file.write(f"{nanoseconds(t)}," + ",".join(f"{value:.12g}" for value in [*gyro, *force]) + "\n")
    mount = np.eye(4)
    mount[:3, :3] = matrices(np.array([imu["frame"]["orientation"]]))[0]
    mount[:3, 3] = imu["frame"]["position"]
    rate = 1 / float(np.median(np.diff(imu["t"]))) if len(imu["t"]) > 1 else 0.0
    density = {name: value / np.sqrt(rate) if rate > 0 else 0.0 for name, value in imu["noise"].items()}
    (folder / "sensor.yaml").write_text(
        f"sensor_type: imu\ncomment: {imu['name']}, of the last step before each time\nT_BS:\n" + _yaml_matrix(mount) + f"rate_hz: {rate:g}\n"
        f"gyroscope_noise_density: {density['gyro']:.9g}\ngyroscope_random_walk: 0\naccelerometer_noise_density: {density['accelerometer']:.9g}\naccelerometer_random_walk: 0\n", encoding="utf-8")


def _yaml_matrix(matrix: "np.ndarray") -> str:
    return ("  cols: 4\n  rows: 4\n  data: [" + ",\n         ".join(", ".join(f"{value:.12g}" for value in row) for row in matrix) + "]\n")


def _coefficients(camera: "dict[str, Any]") -> "list[float]":
    """Four, as EuRoC has them. A third radial one that is not 0 is the fifth."""
    if camera["distortion"] == "none":
        return [0.0] * 4
    return list(camera["distortion"][:4 if camera["model"] == "fisheye" or camera["distortion"][4] == 0 else 5])


def _euroc_camera(folder: pathlib.Path, drive: Drive, camera: "dict[str, Any]") -> None:
    (folder / "data").mkdir(parents=True)
    with open(folder / "data.csv", "w", encoding="ascii") as file:
        file.write("#timestamp [ns],filename\n")
        for frame in camera["frames"]:
            ns = nanoseconds(frame["time"])
            file.write(f"{ns},{ns}.png\n")
            _same_file(camera["folder"] / "colour" / f"{frame['frame']:06d}.png", folder / "data" / f"{ns}.png")
    (folder / "sensor.yaml").write_text(
        f"# Pixels count from the centre of the first one.\nsensor_type: camera\ncomment: {camera['name']}\nT_BS:\n" + _yaml_matrix(_mount(drive, camera)) +
        f"rate_hz: {camera['rate']:g}\nresolution: [{camera['width']}, {camera['height']}]\ncamera_model: pinhole\n"
        f"intrinsics: [{camera['fx']:.12g}, {camera['fy']:.12g}, {camera['cx'] - 0.5:.12g}, {camera['cy'] - 0.5:.12g}]\n"
        f"distortion_model: {'equidistant' if camera['model'] == 'fisheye' else 'radial-tangential'}\n"
        f"distortion_coefficients: [{', '.join(f'{value:.12g}' for value in _coefficients(camera))}]\n", encoding="utf-8")


def _euroc_truth(folder: pathlib.Path, drive: Drive, vehicle: str) -> None:
    rows, turns = drive.vehicles[vehicle], quaternions(drive.vehicles[vehicle])
    folder.mkdir()
    with open(folder / "data.csv", "w", encoding="ascii") as file:
        file.write("#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], "
                   "v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n")
        for i, t in enumerate(rows["t"]):
            x, y, z, w = turns[i]
            values = [rows["x"][i], rows["y"][i], rows["z"][i], w, x, y, z, rows["vx"][i], rows["vy"][i], rows["vz"][i], 0, 0, 0, 0, 0, 0]
            file.write(f"{nanoseconds(t)}," + ",".join(f"{value:.12g}" for value in values) + "\n")
    (folder / "sensor.yaml").write_text(f"sensor_type: pose\ncomment: the root body of {vehicle}, as simulated\nT_BS:\n" + _yaml_matrix(np.eye(4)), encoding="utf-8")


def euroc(folder: Path, to: Path, camera: "Union[str, None]" = None) -> "dict[str, Any]":
    """Writes a folder `to` that has `mav0`. `camera`: the only one; None: all with colours on the first camera's vehicle. Returns {vehicle, cameras, imu, rows}.

    The folder is there when it is whole. ResultsError: there is no camera on a vehicle, or no rows of it, or one moves against it.
    """
    drive = Drive(folder)
    mounted = {name: each for name, each in drive.cameras.items()
               if each["kind"] == "mounted" and each["on"] in drive.vehicles and "colour" in each["images"] and camera in (None, name)}
    if not mounted:
        raise ResultsError(f"{drive.folder}: no camera with colours is mounted on a vehicle with rows" + (f" and has the name {camera}" if camera else "")
                           + "; give the scene such a camera, and output.vehicles")
    vehicle = next(iter(mounted.values()))["on"]
    own = {name: each for name, each in mounted.items() if each["on"] == vehicle}
    with _Folder(pathlib.Path(to)) as whole:
        for number, each in enumerate(own.values()):
            _euroc_camera(whole / "mav0" / f"cam{number}", drive, each)
        _euroc_truth(whole / "mav0" / "state_groundtruth_estimate0", drive, vehicle)
        imu = _imu_of(drive, vehicle)
        if imu is not None:
            _euroc_imu(whole / "mav0" / "imu0", drive, imu)
        (whole / "mav0" / "body.yaml").write_text(f"comment: {vehicle}, its root body: x forward, y left, z up\n", encoding="utf-8")
    return {"vehicle": vehicle, "cameras": list(own), "imu": imu["name"] if imu is not None else None, "rows": len(drive.vehicles[vehicle]["t"])}


def _tum_camera(drive: Drive, name: "Union[str, None]") -> "dict[str, Any]":
    found = [each for own, each in drive.cameras.items() if {"colour", "depth"} <= set(each["images"]) and name in (None, own)]
    if not found:
        raise ResultsError(f"{drive.folder}: no camera has colour and depth" + (f" and the name {name}" if name else "") + "; give one images: [colour, depth]")
    if found[0]["distortion"] != "none":
        raise ResultsError(f"cameras.{found[0]['name']}: it has a lens, and TUM has pinholes; give another with --camera")
    return found[0]


def tum(folder: Path, to: Path, camera: "Union[str, None]" = None) -> "dict[str, Any]":
    """Writes the colours, depths and poses of one camera. `camera`: its name; None: the first with both. Returns {camera, frames}.

    Depth is along the axis of view, 5000 units a metre; 0: sky, or beyond 13.1 m. The folder is there when it is whole. ResultsError: no camera has both.
    """
    drive = Drive(folder)
    own = _tum_camera(drive, camera)
    with _Folder(pathlib.Path(to)) as whole:
        files = {name: open(whole / f"{name}.txt", "w", encoding="ascii") for name in ("rgb", "depth", "groundtruth")}
        try:
            files["rgb"].write("# timestamp filename\n")
            files["depth"].write("# timestamp filename; 5000 units a metre, 0: nothing\n")
            files["groundtruth"].write("# timestamp tx ty tz qx qy qz qw\n")
            for name in ("rgb", "depth"):
                (whole / name).mkdir()
            for frame in own["frames"]:
                stamp, file = f"{frame['time']:.9f}", f"{frame['frame']:06d}"
                _same_file(own["folder"] / "colour" / f"{file}.png", whole / "rgb" / f"{stamp}.png")
                depth = np.load(own["folder"] / "depth" / f"{file}.npy").astype(np.float64) * TUM_UNITS
                depth[~(depth < 65535.5)] = 0
                (whole / "depth" / f"{stamp}.png").write_bytes(_png.grey16(np.rint(depth)))
                for name in ("rgb", "depth"):
                    files[name].write(f"{stamp} {name}/{stamp}.png\n")
                files["groundtruth"].write(" ".join([stamp, *(f"{value:.12g}" for value in [*frame["position"], *frame["orientation"]])]) + "\n")
        finally:
            for file in files.values():
                file.close()
        imu = _imu_of(drive, own.get("on", ""))
        if imu is not None:
            with open(whole / "accelerometer.txt", "w", encoding="ascii") as file:
                file.write("# timestamp ax ay az\n")
                for t, force in zip(imu["t"], imu["accelerometer"]):
                    file.write(f"{t:.9f} " + " ".join(f"{value:.12g}" for value in force) + "\n")
        (whole / "intrinsics.txt").write_text("# fx fy cx cy; pixels count from the centre of the first one\n"
                                              f"{own['fx']:.12g} {own['fy']:.12g} {own['cx'] - 0.5:.12g} {own['cy'] - 0.5:.12g}\n", encoding="ascii")
    return {"camera": own["name"], "frames": len(own["frames"])}


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("dataset", "Writes a drive as an EuRoC or TUM dataset: see furrow dataset --help.")
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("-o", "--output", metavar="FOLDER", required=True)
    parser.add_argument("--format", choices=["euroc", "tum"], default="euroc")
    parser.add_argument("--camera", metavar="NAME")
    given = parser.parse_args(arguments)

    def work() -> None:
        if given.format == "euroc":
            told = euroc(given.folder, given.output, given.camera)
            print(f"{given.output}/mav0: {len(told['cameras'])} camera{'s' if len(told['cameras']) != 1 else ''} ({', '.join(told['cameras'])}) on {told['vehicle']}, {told['rows']} poses"
                  + (f", IMU {told['imu']}" if told["imu"] else ""))
        else:
            told = tum(given.folder, given.output, given.camera)
            print(f"{given.output}: {told['frames']} pictures of colour and depth of {told['camera']}")

    return _command.end("dataset", work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
