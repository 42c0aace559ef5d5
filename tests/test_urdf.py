"""The swimmer as URDF: an independent reader poses its links where the trajectory has them."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from helpers import Run, assert_close, is_close, random_swimmer, runner
from motions import motion, usual, written
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, Swimmer, read_csv
from purcell_cli.exports.joint_path import joint_path
from purcell_cli.exports.urdf import write_urdf
from purcell_cli.files.builtin import find_swimmer
from purcell_cli.files.servo_map_file import Channel, ServoMap
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.drag import LinkSize, LinkSizes
from purcell_cli.motion.trajectory import as_table

yourdfpy: Any = pytest.importorskip("yourdfpy", reason="no yourdfpy: URDF is not read back (pip install yourdfpy)")
HALF = {"base": 0.1, "limb1": 0.07, "limb2": 0.07}


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that exports the motion in swim.csv as URDF: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    written(usual(), tmp_path)
    return runner(capsys, "export", "swim.csv", "--to", "urdf", "--swimmer", "swimmer.yaml")


def robot(path: Path | io.BytesIO) -> Any:
    """Return a robot as yourdfpy reads it."""
    return yourdfpy.URDF.load(path if isinstance(path, io.BytesIO) else str(path), mesh_dir="")


def in_base(found: Any, names: list[str], angles: Array) -> Array:
    """Return where yourdfpy has the limbs' frames in the base's. Shape (2, 4, 4)."""
    found.update_cfg(dict(zip(names, angles.tolist(), strict=True)))
    return np.stack([found.get_transform(f"limb{k}", "base") for k in (1, 2)])


@pytest.mark.parametrize("orders", [{}, {"limb1": "yzx", "limb2": "xzy"}])
def test_links_are_where_the_trajectory_has_them(run: Run, tmp_path: Path, orders: dict[str, str]) -> None:
    (tmp_path / "servos.yaml").write_text(f"hinge_order: {orders}".replace("'", ""))
    code, out, err = run("--map", "servos.yaml")
    assert (code, err) == (0, "")
    assert out.startswith("swim.urdf: 6 joints, ")
    found, rows = robot(tmp_path / "swim.urdf"), read_csv(tmp_path / "swim.csv")
    hinges = ServoMap.of(orders, {})
    angles = joint_path(rows, hinges, rows.time_s, tmp_path / "swim.csv")
    assert found.actuated_joint_names == list(hinges.channels)
    for k in range(0, len(rows.time_s), 7):
        wanted = np.tile(np.eye(4), (2, 1, 1))
        wanted[:, :3, :3] = Rotation.from_quat(rows.limbs[k], scalar_first=True).as_matrix()
        wanted[:, 0, 3] = 0.1, -0.1
        assert_close(in_base(found, list(hinges.channels), angles[k]), wanted, 1e-9)
        assert not is_close(in_base(found, list(hinges.channels), -angles[k]), wanted, 1e-3)


def test_cylinders_have_the_links_true_lengths_radii_and_places() -> None:
    rng = np.random.default_rng(2)
    for _ in range(5):
        swimmer, stream = random_swimmer(rng), io.BytesIO()
        write_urdf(swimmer, ServoMap.of({}, {}), stream)
        stream.seek(0)
        found = robot(stream)
        halves = swimmer.halves_m
        for name, half, middle in zip(("base", "limb1", "limb2"), halves, (0.0, halves[1], -halves[2]), strict=True):
            for part in (found.link_map[name].visuals[0], found.link_map[name].collisions[0]):
                cylinder = part.geometry.cylinder
                assert (cylinder.length, cylinder.radius) == (2.0 * half, swimmer.radii_m[halves.index(half)])
                assert_close(part.origin @ [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], 1e-15)
                assert_close(part.origin[:3, 3], [middle, 0.0, 0.0], 1e-15)
        assert sum(bool(link.visuals) for link in found.link_map.values()) == 3
        assert len(found.link_map) == 7
        assert found.base_link == "base"


def test_hinges_turn_as_far_as_the_map_and_the_lock_allow() -> None:
    channel = Channel("us", 1500.0, -1.0, 10.0, 600.0, 2500.0)
    stream = io.BytesIO()
    write_urdf(random_swimmer(np.random.default_rng(3)), ServoMap.of({}, {"limb1_yaw": channel}, 10.0), stream)
    stream.seek(0)
    joints = robot(stream).joint_map
    assert {joint.type for joint in joints.values()} == {"revolute"}
    limits = {name: np.degrees([j.limit.lower, j.limit.upper]) for name, j in joints.items()}
    assert_close(limits["limb1_yaw"], [-100.0, 90.0], 1e-12)
    assert_close(limits["limb1_pitch"], [-80.0, 80.0], 1e-12)
    assert_close(limits["limb2_roll"], [-180.0, 180.0], 1e-12)


def test_hinges_turn_no_faster_than_the_file_says(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    rows = read_csv(tmp_path / "swim.csv")
    hinges = ServoMap.of({}, {})
    angles = joint_path(rows, hinges, rows.time_s, tmp_path / "swim.csv")
    fastest = np.max(np.abs(np.diff(angles, axis=0)) / np.diff(rows.time_s)[:, None], axis=0)
    limits = [robot(tmp_path / "swim.urdf").joint_map[name].limit.velocity for name in hinges.channels]
    assert np.all(fastest <= limits)
    assert np.max(fastest) > 1.05, "a hinge does turn faster than the limb"


def test_the_file_is_plain_xml_the_same_each_time(run: Run, tmp_path: Path) -> None:
    assert run("--out", "a.urdf")[0] == 0
    assert run("--out", "b.xml")[0] == 0
    assert (tmp_path / "a.urdf").read_bytes() == (tmp_path / "b.xml").read_bytes()
    tree = ET.parse(tmp_path / "a.urdf").getroot()
    assert (tree.tag, len(tree.findall("joint")), len(tree.findall("link"))) == ("robot", 6, 7)
    assert tree.find("joint/limit") is not None
    assert float(tree.find("link/visual/geometry/cylinder").attrib["length"]) == 2 * HALF["base"]


def test_a_hinge_at_its_own_zero_is_the_collinear_shape(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    found = robot(tmp_path / "swim.urdf")
    wanted = np.tile(np.eye(4), (2, 1, 1))
    wanted[:, 0, 3] = 0.1, -0.1
    names = list(ServoMap.of({}, {}).channels)
    assert_close(in_base(found, names, np.zeros(6)), wanted, 1e-15)
    bent = Configuration.from_angles(limb1_euler_deg=[30, 0, 0]).shape[0]
    assert_close(in_base(found, names, np.array([math.radians(30.0), *[0.0] * 5]))[0][:3, :3], bent, 1e-15)


def test_limbs_of_their_own_sizes_and_a_body_are_there() -> None:
    sizes = LinkSizes(limb1=LinkSize(half_length_m=0.05), limb2=LinkSize(half_length_m=0.08, slenderness=0.03))
    swimmer, stream = Swimmer(links=sizes, body_radius_m=0.03), io.BytesIO()
    write_urdf(swimmer, ServoMap.of({}, {}), stream)
    stream.seek(0)
    links = robot(stream).link_map
    told = {name: links[name].visuals[0].geometry.cylinder for name in ("limb1", "limb2")}
    assert (told["limb1"].length, told["limb2"].length) == (0.1, 0.16)
    assert_close([told["limb1"].radius, told["limb2"].radius], [0.001, 0.0048], 1e-15)
    assert_close(links["limb2"].visuals[0].origin[:3, 3], [-0.08, 0.0, 0.0], 1e-15)
    assert [part.geometry.sphere.radius for part in (links["base"].visuals[1], links["base"].collisions[1])] == [
        0.03
    ] * 2


@pytest.mark.parametrize(
    ("name", "way", "joints"),
    [
        ("planar", [("limb1 yaw", 0.5), ("limb2 yaw", -0.8)], ["limb1_yaw", "limb2_yaw"]),
        (
            "robot",
            [("limb1 pitch", 0.4), ("limb1 base yaw", 0.9), ("limb2 pitch", -0.3), ("limb2 base yaw", 0.5)],
            ["limb1_yaw", "limb1_pitch", "limb2_yaw", "limb2_pitch"],
        ),
    ],
)
def test_hinges_and_universal_joints_are_as_the_swimmer_has_them(
    tmp_path: Path, name: str, way: list[tuple[str, float]], joints: list[str]
) -> None:
    swimmer = find_swimmer(name)
    rows = as_table(motion(way, Configuration(), 0.05, swimmer))
    hinges, stream = ServoMap.of_swimmer(swimmer), io.BytesIO()
    assert write_urdf(swimmer, hinges, stream) == tuple(joints)
    stream.seek(0)
    found, b = robot(stream), swimmer.base_half_length_m
    angles = joint_path(rows, hinges, rows.time_s, tmp_path)
    for k in range(0, len(rows.time_s), 5):
        wanted = np.tile(np.eye(4), (2, 1, 1))
        wanted[:, :3, :3] = Rotation.from_quat(rows.limbs[k], scalar_first=True).as_matrix()
        wanted[:, 0, 3] = b, -b
        assert_close(in_base(found, joints, angles[k]), wanted, 1e-9)
    fastest = {joint: found.joint_map[joint].limit.velocity for joint in joints}
    assert fastest == {joint: swimmer.rate_of(int(joint[4]) - 1) for joint in joints}, "a hinge's own rate"
    for limb, joint in enumerate(swimmer.joints, 1):
        for angle, turn in (("psi", "yaw"), ("theta", "pitch")):
            if joint.range_deg(angle) is not None:
                limit = found.joint_map[f"limb{limb}_{turn}"].limit
                assert_close(np.degrees([limit.lower, limit.upper]), joint.range_deg(angle), 1e-12)
