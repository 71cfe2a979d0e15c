"""The ROS 2 messages that a bag has: the fields of the standard types, as ROS defines them."""

_FIELDS = {
    "builtin_interfaces/Time": "int32 sec, uint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp, string frame_id",
    "geometry_msgs/Vector3": "float64 x, float64 y, float64 z",
    "geometry_msgs/Point": "float64 x, float64 y, float64 z",
    "geometry_msgs/Quaternion": "float64 x, float64 y, float64 z, float64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform",
    "geometry_msgs/Pose": "geometry_msgs/Point position, geometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose, float64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist, float64[36] covariance",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force, geometry_msgs/Vector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header, geometry_msgs/Wrench wrench",
    "nav_msgs/Odometry": "std_msgs/Header header, string child_frame_id, geometry_msgs/PoseWithCovariance pose, geometry_msgs/TwistWithCovariance twist",
    "rosgraph_msgs/Clock": "builtin_interfaces/Time clock",
    "sensor_msgs/CameraInfo": "std_msgs/Header header, uint32 height, uint32 width, string distortion_model, float64[] d, float64[9] k, float64[9] r,"
                              " float64[12] p, uint32 binning_x, uint32 binning_y, sensor_msgs/RegionOfInterest roi",
    "sensor_msgs/CompressedImage": "std_msgs/Header header, string format, uint8[] data",
    "sensor_msgs/Image": "std_msgs/Header header, uint32 height, uint32 width, string encoding, uint8 is_bigendian, uint32 step, uint8[] data",
    "sensor_msgs/Imu": "std_msgs/Header header, geometry_msgs/Quaternion orientation, float64[9] orientation_covariance,"
                       " geometry_msgs/Vector3 angular_velocity, float64[9] angular_velocity_covariance,"
                       " geometry_msgs/Vector3 linear_acceleration, float64[9] linear_acceleration_covariance",
    "sensor_msgs/JointState": "std_msgs/Header header, string[] name, float64[] position, float64[] velocity, float64[] effort",
    "sensor_msgs/PointCloud2": "std_msgs/Header header, uint32 height, uint32 width, sensor_msgs/PointField[] fields, bool is_bigendian,"
                               " uint32 point_step, uint32 row_step, uint8[] data, bool is_dense",
    "sensor_msgs/PointField": "string name, uint32 offset, uint8 datatype, uint32 count",
    "sensor_msgs/Range": "std_msgs/Header header, uint8 radiation_type, float32 field_of_view, float32 min_range, float32 max_range, float32 range",
    "sensor_msgs/RegionOfInterest": "uint32 x_offset, uint32 y_offset, uint32 height, uint32 width, bool do_rectify",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
}


def _fields(name: str) -> "list[list[str]]":
    return [field.split() for field in _FIELDS[name].split(", ")]


def _needs(name: str, known: "list[str]") -> "list[str]":
    """All types that a type is made of, each once."""
    for kind, _ in _fields(name):
        kind = kind.split("[")[0]
        if kind in _FIELDS and kind not in known:
            known.append(kind)
            _needs(kind, known)
    return known


def definition(name: str) -> str:
    """The text of a type such as "nav_msgs/Odometry", followed by those of the types in it, as bags have it."""
    parts = ["\n".join(f"{kind} {field}" for kind, field in _fields(name))]
    for kind in _needs(name, []):
        parts.append(f"MSG: {kind}\n" + "\n".join(f"{of} {field}" for of, field in _fields(kind)))
    return ("\n" + "=" * 80 + "\n").join(parts) + "\n"


def full_name(name: str) -> str:
    """nav_msgs/Odometry as ROS 2 has it: nav_msgs/msg/Odometry."""
    package, own = name.split("/")
    return f"{package}/msg/{own}"
