"""A trajectory as ROS 2 messages: an independent reader finds the joints' path, the frames and the robot."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from helpers import Run, assert_close, is_close, runner
from motions import usual, written
from scipy.spatial.transform import Rotation

from purcell_cli import read_csv
from purcell_cli.motion.trajectory_table import Table

pytest.importorskip("mcap_ros2", reason="no mcap-ros2-support: no messages are written (pip install '.[ros]')")
pytest.importorskip("rosbags", reason="no rosbags: messages are not read back (pip install 'rosbags>=0.11')")

TYPES = {
    "/robot_description": "std_msgs/msg/String",
    "/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/tf": "tf2_msgs/msg/TFMessage",
}
JOINTS = [f"limb{limb}_{turn}" for limb in (1, 2) for turn in ("yaw", "pitch", "roll")]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that exports the motion in swim.csv to MCAP: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    written(usual(), tmp_path)
    return runner(capsys, "export", "swim.csv", "--to", "mcap", "--swimmer", "swimmer.yaml")


def messages(path: Path) -> list[tuple[str, int, Any]]:
    """Return all messages of a file, read by rosbags with its own definitions of ROS 2: topic, time [ns], message."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(path) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == TYPES
        return [(c.topic, time, store.deserialize_cdr(data, c.msgtype)) for c, time, data in reader.messages()]


def of(topic: str, path: Path) -> list[tuple[int, Any]]:
    """Return the messages of one topic."""
    return [(time, message) for name, time, message in messages(path) if name == topic]


def nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def frames(rows: Table) -> np.ndarray:
    """Return the base's, limb 1's and limb 2's poses in the world, by scipy. Shape (n, 3, 4, 4)."""
    out = np.tile(np.eye(4), (len(rows.time_s), 3, 1, 1))
    base, first, second = (
        Rotation.from_quat(q, scalar_first=True) for q in (rows.base, rows.limbs[:, 0], rows.limbs[:, 1])
    )
    for k, (turn, x) in enumerate(((base, 0.0), (base * first, 0.1), (base * second, -0.1))):
        out[:, k, :3, :3] = turn.as_matrix()
        out[:, k, :3, 3] = rows.position_m + base.apply([x, 0.0, 0.0])
    return out


def placed(transform: Any) -> np.ndarray:
    """Return a transform as a matrix. Shape (4, 4)."""
    out, at, turn = np.eye(4), transform.translation, transform.rotation
    out[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    out[:3, 3] = at.x, at.y, at.z
    return out


def test_the_joint_trajectory_has_a_point_a_row_with_the_angles_of_the_file(run: Run, tmp_path: Path) -> None:
    code, out, err = run()
    assert (code, err) == (0, "")
    rows = read_csv(tmp_path / "swim.csv")
    assert out.startswith(f"swim.mcap: {len(rows.time_s) + 2} messages, ")
    ((time, message),) = of("/joint_trajectory", tmp_path / "swim.mcap")
    assert (time, message.header.frame_id, message.joint_names) == (0, "base", JOINTS)
    at = np.array([nanoseconds(point.time_from_start) for point in message.points])
    assert np.all(np.diff(at) > 0)
    assert_close(at * 1e-9, rows.time_s, 1e-9)
    wanted = np.unwrap(rows.euler_rad[:, 1:], axis=0).reshape(-1, 6)
    assert_close(np.array([point.positions for point in message.points]), wanted, 1e-9)
    assert all(len(point.velocities) == 0 for point in message.points), "between points a controller goes straight"


def test_the_frames_are_where_the_links_are_at_every_row(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    rows = read_csv(tmp_path / "swim.csv")
    found = of("/tf", tmp_path / "swim.mcap")
    assert len(found) == len(rows.time_s)
    wanted = frames(rows)
    for k, (time, message) in enumerate(found):
        assert [(t.header.frame_id, t.child_frame_id) for t in message.transforms] == [
            ("world", "base"), ("base", "limb1"), ("base", "limb2"),
        ]  # fmt: skip
        assert {nanoseconds(t.header.stamp) for t in message.transforms} == {time}
        base, *limbs = [placed(t.transform) for t in message.transforms]
        assert_close(np.stack([base, *(base @ limb for limb in limbs)]), wanted[k], 1e-12)
    assert not is_close(np.stack([base, *limbs]), wanted[-1], 1e-2), "the limbs hang in the base"


def test_the_robot_has_the_joints_and_the_frames_that_move(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    ((time, message),) = of("/robot_description", tmp_path / "swim.mcap")
    robot = ET.fromstring(message.data)
    assert time == 0
    assert [joint.attrib["name"] for joint in robot.findall("joint")] == JOINTS
    assert {"base", "limb1", "limb2"} <= {link.attrib["name"] for link in robot.findall("link")}


@pytest.mark.slow
def test_the_file_is_the_same_whenever_it_is_written(run: Run, tmp_path: Path) -> None:
    assert run("--out", "a.mcap")[0] == 0
    assert run("--out", "b.mcap")[0] == 0
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_of_rows_at_one_time_the_last_counts(run: Run, tmp_path: Path) -> None:
    lines = (tmp_path / "swim.csv").read_text().splitlines(keepends=True)
    (tmp_path / "swim.csv").write_text("".join([*lines[:3], lines[2], *lines[3:]]))
    document = json.loads(run("--json")[1])
    assert (document["count"], document["joints"]) == (len(lines) - 1 + 2, JOINTS)
    ((_, message),) = of("/joint_trajectory", tmp_path / "swim.mcap")
    assert len(message.points) == len(lines) - 1


def test_what_ros_cannot_tell_is_refused_and_nothing_written(run: Run, tmp_path: Path) -> None:
    lines = (tmp_path / "swim.csv").read_text().splitlines(keepends=True)
    last = lines[-1].split(",")
    (tmp_path / "swim.csv").write_text("".join([*lines[:-1], ",".join(["3e9", *last[1:]])]))
    code, _, err = run()
    assert code == 2
    assert "swim.csv: wanted at most 2147483647 s, which ROS can tell, found 3e+09 s" in err
    assert not (tmp_path / "swim.mcap").exists()
