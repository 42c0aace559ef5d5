"""A trajectory as ROS 2 messages in an MCAP file, written without ROS.

/joint_trajectory has one trajectory_msgs/JointTrajectory with a point a row: what a joint trajectory controller takes.
/tf has the frames base in world, limb1 and limb2 in base at every row. /robot_description has the swimmer as URDF,
whose links have these names. Times begin at 0, so that a file is the same whenever it is written.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import InputError, MissingPackageError
from purcell_cli.exports.joint_path import joint_path
from purcell_cli.exports.ros_messages import DEFINITIONS, header, time, transform
from purcell_cli.exports.urdf import LINKS, joint_m, write_urdf
from purcell_cli.files.servo_map_file import ServoMap
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory_table import Table

try:
    from mcap_ros2.writer import Writer
except ImportError:
    raise MissingPackageError(
        "exports to mcap need mcap-ros2-support, found none; "
        "install it: python -m pip install 'mcap-ros2-support>=0.5.7'"
    ) from None

_LONGEST_S = 2147483647.0
"""A message's seconds at most: they have 32 bits."""


def write_mcap(table: Table, swimmer: Swimmer, servo_map: ServoMap, source: Path, stream: IO[bytes]) -> int:
    """Write a trajectory as ROS 2 messages.

    Args:
        table: The trajectory.
        swimmer: The swimmer, for where its joints are.
        servo_map: Its hinges.
        source: The trajectory's file, for messages.
        stream: Where to write.

    Returns:
        How many messages there are.

    Raises:
        InputError: As for `joint_path`, or the trajectory lasts longer than messages can tell.
    """
    rows, time_ns = _rows(table, source)
    angles = joint_path(table, servo_map, table.time_s[rows], source)
    description = io.BytesIO()
    write_urdf(swimmer, servo_map, description)
    writer = Writer(stream)
    types = {name: writer.register_msgdef(name, text) for name, text in DEFINITIONS.items()}
    path = _joint_trajectory(tuple(servo_map.channels), angles, time_ns)
    for topic, kind, message in (
        ("/robot_description", "std_msgs/msg/String", {"data": description.getvalue().decode()}),
        ("/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", path),
    ):
        writer.write_message(topic, types[kind], message, log_time=0)
    for k, (row, now) in enumerate(zip(rows.tolist(), time_ns.tolist(), strict=True)):
        message = {"transforms": _frames(table, swimmer, row, now)}
        writer.write_message("/tf", types["tf2_msgs/msg/TFMessage"], message, log_time=now, sequence=k)
    writer.finish()
    return len(rows) + 2


def _rows(table: Table, source: Path) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows whose times differ, and these times from the first row on [ns]; of equal times the last row."""
    lasts = float(table.time_s[-1] - table.time_s[0])
    if lasts > _LONGEST_S:
        raise InputError(f"{source}: wanted at most {_LONGEST_S:.0f} s, which ROS can tell, found {lasts:.6g} s")
    time_ns = np.round((table.time_s - table.time_s[0]) * 1e9).astype(np.int64)
    rows = np.append(np.flatnonzero(np.diff(time_ns)), len(time_ns) - 1)
    return rows, time_ns[rows]


def _joint_trajectory(names: tuple[str, ...], angles: Array, time_ns: NDArray[np.int64]) -> dict[str, Any]:
    """Return the message of all hinges' angles [rad]."""
    points = [
        {"positions": row, "velocities": [], "accelerations": [], "effort": [], "time_from_start": time(now)}
        for row, now in zip(angles.tolist(), time_ns.tolist(), strict=True)
    ]
    return {"header": header(0, "base"), "joint_names": list(names), "points": points}


def _frames(table: Table, swimmer: Swimmer, row: int, time_ns: int) -> list[dict[str, Any]]:
    """Return where the base is in the world, and the limbs in the base."""
    base = transform(time_ns, "world", LINKS[0], table.position_m[row].tolist(), table.base[row].tolist())
    limbs = [
        transform(time_ns, LINKS[0], LINKS[k], [joint_m(swimmer, k), 0.0, 0.0], table.limbs[row, k - 1].tolist())
        for k in (1, 2)
    ]
    return [base, *limbs]
