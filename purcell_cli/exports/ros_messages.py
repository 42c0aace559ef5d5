"""The ROS 2 messages that are written: their definitions, as the format wants them, and their parts as mappings.

The definitions are those of common_interfaces, builtin_interfaces and geometry2, without their comments; what a message
is made of follows it behind a line of signs, as in files that rosbag2 writes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

_FIELDS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/String": "string data\n",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "trajectory_msgs/JointTrajectoryPoint": (
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
        "builtin_interfaces/Duration time_from_start\n"
    ),
    "trajectory_msgs/JointTrajectory": (
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n"
    ),
}
"""Each message's fields."""

_PARTS = {
    "std_msgs/String": (),
    "tf2_msgs/TFMessage": (
        *("geometry_msgs/TransformStamped", "std_msgs/Header", "builtin_interfaces/Time"),
        *("geometry_msgs/Transform", "geometry_msgs/Vector3", "geometry_msgs/Quaternion"),
    ),
    "trajectory_msgs/JointTrajectory": (
        *("std_msgs/Header", "builtin_interfaces/Time", "trajectory_msgs/JointTrajectoryPoint"),
        "builtin_interfaces/Duration",
    ),
}
"""The messages that are written, each with all that it is made of."""

_LINE = "=" * 80 + "\n"
"""What stands before each part of a definition: 80 signs, as the format has it."""

DEFINITIONS: Mapping[str, str] = MappingProxyType(
    {
        name.replace("/", "/msg/"): _FIELDS[name] + "".join(f"{_LINE}MSG: {p}\n{_FIELDS[p]}" for p in parts)
        for name, parts in _PARTS.items()
    }
)
"""The whole definition of each message that is written, by its type."""


def time(time_ns: int) -> dict[str, int]:
    """Return a time, or a duration, as a message [ns]."""
    return {"sec": time_ns // 1_000_000_000, "nanosec": time_ns % 1_000_000_000}


def header(time_ns: int, frame: str) -> dict[str, Any]:
    """Return a header: when, and in which frame."""
    return {"stamp": time(time_ns), "frame_id": frame}


def transform(time_ns: int, parent: str, child: str, at_m: Sequence[float], turn: Sequence[float]) -> dict[str, Any]:
    """Return where one frame is in another.

    Args:
        time_ns: When [ns].
        parent: The frame that it is in.
        child: The frame that is there.
        at_m: Its origin (x, y, z) [m].
        turn: Its orientation, a quaternion (w, x, y, z).
    """
    place = {
        "translation": dict(zip("xyz", at_m, strict=True)),
        "rotation": dict(zip("wxyz", turn, strict=True)),
    }
    return {"header": header(time_ns, parent), "child_frame_id": child, "transform": place}
