"""Waypoints, their order and curves in files: read, and refused with the file and the line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers import assert_close

from purcell_cli import load_curve, load_scenario
from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.scenario_file import SCHEMAS
from purcell_cli.files.validate import check_file
from purcell_cli.motion.curve import Curve, CurveError

HEAD = "name: n\nstart: {}\ngoal: {base: {position_m: [1, 0, 0]}}\n"


def scenario(folder: Path, text: str, head: str = HEAD) -> Path:
    path = folder / "s.yaml"
    path.write_text(head + text)
    return path


def curve(folder: Path, text: str) -> Path:
    path = folder / "curve.csv"
    path.write_text(text)
    return path


def test_a_scenario_names_waypoints_and_what_it_leaves_out_is_free(tmp_path: Path) -> None:
    text = "via:\n- base: {position_m: [0.1, 0, 0]}\n- {limb2: {euler_deg: [90, 0, 0]}}\norder: free\n"
    found = load_scenario(scenario(tmp_path, text))
    assert [one.names for one in found.via] == [("position_m",), ("limb2",)]
    assert found.order == "free"
    assert found.mission.via == found.via
    assert load_scenario(scenario(tmp_path, "")).mission.plain
    assert check_file(scenario(tmp_path, text)).error is None


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (4, "via: []", "via: wanted a list of 1 or more"),
        (
            5,
            "via:\n- {}",
            r"via\[0\]: wanted a waypoint that names a position, an .* found nothing",
        ),
        (5, "via:\n- {limb3: {}}", r"via\[0\].limb3: wanted one of the keys base, limb1, limb2"),
        (5, "via:\n- {base: {position_m: [0, .nan, 0]}}", r"via\[0\].base.position_m\[1\]: wanted a finite number"),
        (6, "via:\n- {limb1: {euler_deg: [1, 0, 0]}}\n- {limb1: {euler_deg: [1, 0, 0]}}", r"via\[1\]: wanted another"),
        (5, "via:\n- {base: {position_m: [0, 0, 0]}}", r"via\[0\]: wanted another place than the start"),
        (4, "order: shortest", "order: wanted one of given, free"),
        (4, "order: free", "order: wanted given"),
        (4, "follow: {path: curve.csv}", "follow.tolerance_m: wanted a finite number above 0, found no such key"),
        (4, "follow: {path: none.csv, tolerance_m: 1}", "follow.path: wanted the path of a readable file, found none"),
        (4, "follow: {path: ., tolerance_m: 1}", "follow.path: wanted the path of a readable file, found a directory"),
        (4, "follow: {path: curve.csv, tolerance_m: 0}", "follow.tolerance_m: wanted a finite number above 0"),
        (4, "follow: {path: curve.csv, tolerance_m: 0.1}", "goal: wanted the position of the curve's last point"),
        (
            4,
            "follow: {path: curve.csv, tolerance_m: 0.1}\nvia: [{limb1: {euler_deg: [1, 0, 0]}}]",
            "follow: wanted a curve to follow or waypoints to pass, not both",
        ),
    ],
)
def test_what_is_wrong_in_a_scenario_is_told_with_its_line(tmp_path: Path, line: int, text: str, message: str) -> None:
    curve(tmp_path, "x_m,y_m,z_m\n0,0,0\n2,0,0\n")
    line = 3 if message.startswith("goal") else line
    with pytest.raises(InputError, match=rf"s\.yaml:{line}: {message}"):
        load_scenario(scenario(tmp_path, text))


def test_without_a_goal_a_curve_s_end_is_the_goal(tmp_path: Path) -> None:
    curve(tmp_path, "x_m,y_m,z_m\n0,0,0\n0.3,0,0\n0.3,0.2,0\n")
    head = "name: n\nstart: {}\n"
    found = load_scenario(scenario(tmp_path, "follow: {path: curve.csv, tolerance_m: 0.1}", head))
    assert_close(found.goal.pose[:3, 3], [0.3, 0.2, 0.0], 0.0)
    assert_close(found.goal.pose[:3, 0], [0.0, 1.0, 0.0], 1e-12)
    with pytest.raises(InputError, match=r"goal: wanted .* found no such key"):
        load_scenario(scenario(tmp_path, "", head))
    assert SCHEMAS["scenario"].json_schema()["anyOf"] == [{"required": ["goal"]}, {"required": ["follow"]}]


def test_a_curve_is_read_with_and_without_orientations(tmp_path: Path) -> None:
    plain = load_curve(curve(tmp_path, "\ufeffx_m,y_m,z_m\n0,0,0\n1e-1, 2 ,-3\n\n"))
    assert plain.point_m.tolist() == [[0.0, 0.0, 0.0], [0.1, 2.0, -3.0]]
    assert plain.orientation is None
    half = math.sqrt(0.5)
    turned = load_curve(curve(tmp_path, f"x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,{half!r},0,0,{half!r}\n"))
    assert turned.orientation is not None
    assert_close(turned.orientation[1] @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1e-15)


def test_a_quaternion_of_few_digits_is_normalised_with_a_warning(tmp_path: Path) -> None:
    path = curve(tmp_path, "x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,0.999,0,0,0\n")
    with pytest.warns(PurcellWarning, match=r"curve\.csv:3: qw to qz: normalised"):
        assert load_curve(path).orientation is not None


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (1, "", "wanted the header x_m,y_m,z_m, found an empty file"),
        (1, "0,0,0\n1,0,0\n", "wanted the header x_m,y_m,z_m or .* found '0,0,0'"),
        (1, "x,y,z\n0,0,0\n1,0,0\n", "wanted the header"),
        (1, "x_m,y_m,z_m\n", "wanted two points or more, found none"),
        (2, "x_m,y_m,z_m\n0,0,0\n", "wanted two points or more, found one"),
        (3, "x_m,y_m,z_m\n0,0,0\nnan,0,0\n", "x_m: wanted a finite number .* found 'nan'"),
        (3, "x_m,y_m,z_m\n0,0,0\n0,1_0,0\n", "y_m: wanted a finite number .* found '1_0'"),
        (3, "x_m,y_m,z_m\n0,0,0\n0,0,1e400\n", "z_m: wanted a finite number"),
        (3, "x_m,y_m,z_m\n0,0,0\n1,0\n", "wanted 3 numbers, found 2"),
        (4, "x_m,y_m,z_m\n0,0,0\n1,0,0\n1,0,0\n", "wanted another point than the one before, found it again"),
        (5, "x_m,y_m,z_m\n0,0,0\n\n1,0,0\n1,0,0\n", "wanted another point"),
        (3, "x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,2,0,0,0\n", "qw to qz: wanted a unit quaternion"),
        (3, "x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,0,1,0,0\n", "wanted a turn of at most 3 rad"),
        (
            7,
            "x_m,y_m,z_m\n" + "".join(f"{k + 50 * (k > 4)},0,0\n" for k in range(12)),
            "wanted a step .* a jump of 51 m",
        ),
    ],
)
def test_what_is_wrong_in_a_curve_is_told_with_its_line(tmp_path: Path, line: int, text: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"curve\.csv:{line}: {message}"):
        load_curve(curve(tmp_path, text))


def test_a_few_long_steps_are_no_jump() -> None:
    points = np.array([[0.0, 0, 0], [0.01, 0, 0], [1.0, 0, 0], [1.01, 0, 0]])
    assert len(Curve(points).point_m) == 4
    with pytest.raises(CurveError, match="point 2 of the curve"):
        Curve(np.zeros((2, 3)))
