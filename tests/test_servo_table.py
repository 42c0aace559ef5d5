"""A servo table plays the trajectory: angles at every tick, continuous, in range, and refused near gimbal lock."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers import Run, assert_close, is_close, random_rotations, runner
from motions import START, motion, usual, written
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, read_csv
from purcell_cli.exports import joint_path
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.hinge_chain import ORDERS, HingeChain

JOINTS = [f"limb{limb}_{turn}" for limb in (1, 2) for turn in ("yaw", "pitch", "roll")]
COLLINEAR = Configuration()


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that exports the motion in swim.csv as a servo table: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    written(usual(), tmp_path)
    return runner(capsys, "export", "swim.csv", "--to", "servo", "--swimmer", "swimmer.yaml", "--out", "t.csv")


def servo_map(text: str) -> list[str]:
    """Write a servo map and return the words that name it."""
    Path("servos.yaml").write_text(text)
    return ["--map", "servos.yaml"]


def table(folder: Path) -> tuple[Array, Array]:
    """Return the times of a table and its other columns. Shapes (n,), (n, k)."""
    frame = pl.read_csv(folder / "t.csv")
    values = frame.to_numpy()
    return values[:, 0], values[:, 1:]


def by_scipy(quaternions: Array, order: str) -> Array:
    """Return the continuous angles of intrinsic rotations about some axes, by scipy [deg]."""
    found = Rotation.from_quat(quaternions, scalar_first=True).as_euler(order.upper())
    return np.degrees(np.unwrap(found, axis=0))


# --- Hinges ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_three_hinges_turn_a_limb_anywhere_as_scipy_says(order: str) -> None:
    wanted = random_rotations(np.random.default_rng(0), 200)
    angles = HingeChain(1, order).angles(wanted)
    assert_close(HingeChain(1, order).rotation(angles), wanted, 1e-14)
    assert_close(angles, Rotation.from_matrix(wanted).as_euler(order.upper()), 1e-12)
    assert not is_close(angles, Rotation.from_matrix(wanted).as_euler(order.lower()), 0.1), "axes that stay are others"


@pytest.mark.parametrize("order", ["x", "y", "z", "xy", "xz", "yx", "yz", "zx", "zy"])
def test_one_hinge_or_two_have_no_lock(order: str) -> None:
    angles = np.random.default_rng(1).uniform(-math.pi, math.pi, (200, len(order)))
    angles[:3] = [[0.0] * len(order), [math.pi / 2] * len(order), [-math.pi / 2] * len(order)]
    chain = HingeChain(2, order)
    assert_close(chain.rotation(angles), Rotation.from_euler(order.upper(), angles).as_matrix(), 1e-14)
    assert_close(chain.angles(chain.rotation(angles)), angles, 1e-13)


# --- The table reproduces the trajectory ------------------------------------------------------------------------


def test_rows_on_ticks_have_the_angles_of_the_file(run: Run, tmp_path: Path) -> None:
    code, out, err = run()
    assert (code, err) == (0, "")
    rows = read_csv(tmp_path / "swim.csv")
    time, told = table(tmp_path)
    assert (tmp_path / "t.csv").read_text().partition("\n")[0] == "t_s," + ",".join(f"{j}_deg" for j in JOINTS)
    assert out == f"t.csv: {len(time)} ticks, {(tmp_path / 't.csv').stat().st_size / 1e6:.2f} MB\n"
    assert_close(np.diff(time), np.full(len(time) - 1, 0.02), 1e-12)
    on = [k for k, t in enumerate(rows.time_s) if abs(t * 50 - round(t * 50)) < 1e-9]
    assert len(on) > 300
    wanted = np.degrees(np.unwrap(rows.euler_rad[:, 1:], axis=0).reshape(-1, 6))[on]
    found = told[np.round(rows.time_s[on] * 50).astype(int)]
    assert_close(found, wanted, 1e-9)
    assert not is_close(found[:, ::-1], wanted, 1.0)


@pytest.mark.parametrize("rate", [47.0, 333.0])
def test_between_ticks_the_trajectory_is_found_by_interpolation(run: Run, tmp_path: Path, rate: float) -> None:
    assert run("--rate", str(rate))[0] == 0
    rows = read_csv(tmp_path / "swim.csv")
    time, told = table(tmp_path)
    wanted = np.degrees(np.unwrap(rows.euler_rad[:, 1:], axis=0).reshape(-1, 6))
    found = np.stack([np.interp(rows.time_s, time, column) for column in told.T], axis=1)
    fastest = float(np.max(np.abs(np.diff(wanted, axis=0)) / np.diff(rows.time_s)[:, None]))
    assert_close(found, wanted, 0.5 * fastest / rate)  # a switch half-way between two ticks
    assert not is_close(found, wanted, 1e-3 * fastest / rate)


def test_the_last_tick_is_the_end(run: Run, tmp_path: Path) -> None:
    rows = read_csv(tmp_path / "swim.csv")
    for rate in ("50", "37", "0.01"):
        assert run("--rate", rate)[0] == 0
        time, told = table(tmp_path)
        assert 0.0 <= time[-1] - rows.time_s[-1] + 1e-9 < 1.0 / float(rate) + 1e-9
        assert time[0] == rows.time_s[0]
        end = Rotation.from_quat(rows.limbs[-1], scalar_first=True)
        played = Rotation.from_euler("ZYX", told[-1].reshape(2, 3), degrees=True)
        assert float(np.max((end.inv() * played).magnitude())) < 1e-9


@pytest.mark.parametrize("order", ["zxy", "yzx"])
def test_another_order_of_hinges_has_its_own_angles_and_columns(run: Run, tmp_path: Path, order: str) -> None:
    assert run(*servo_map(f"hinge_order: {{limb1: {order}}}"))[0] == 0
    rows = read_csv(tmp_path / "swim.csv")
    _, told = table(tmp_path)
    names = (tmp_path / "t.csv").read_text().partition("\n")[0].split(",")[1:4]
    assert names == [f"limb1_{ {'z': 'yaw', 'y': 'pitch', 'x': 'roll'}[axis] }_deg" for axis in order]
    on = np.flatnonzero(np.abs(rows.time_s * 50 - np.round(rows.time_s * 50)) < 1e-9)
    found = told[np.round(rows.time_s[on] * 50).astype(int)]
    assert_close(found[:, :3], by_scipy(rows.limbs[:, 0], order)[on], 1e-9)
    assert_close(found[:, 3:], by_scipy(rows.limbs[:, 1], "zyx")[on], 1e-9)
    assert not is_close(found[:, :3], by_scipy(rows.limbs[:, 0], "zyx")[on], 1.0)


def test_angles_go_on_past_a_turn_however_coarse_the_rows_are(run: Run, tmp_path: Path) -> None:
    for dt in (0.05, 100.0):
        written(motion([("limb1 roll", 20.0), ("limb2 yaw", -7.0)], COLLINEAR, dt), tmp_path)
        wide = "channels: {limb1_roll: {range: [-2000, 2000]}, limb2_yaw: {range: [-500, 500]}}"
        assert run(*servo_map(wide))[0] == 0
        time, told = table(tmp_path)
        wanted = np.zeros((len(time), 6))
        wanted[:, 2], wanted[:, 3] = np.minimum(time, 20.0), -np.clip(time - 20.0, 0.0, 7.0)
        assert_close(told, np.degrees(wanted), 1e-9, 1e3)


def test_a_channel_has_its_zero_sign_scale_and_unit(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    _, plain = table(tmp_path)
    given = "channels:\n  limb1_yaw: {unit: us}\n  limb2_roll: {unit: us, zero: 1400, sign: -1, scale: 5}\n"
    given += "  limb2_pitch: {zero: 90, range: [0, 180]}\n"
    assert run(*servo_map(given))[0] == 0
    _, told = table(tmp_path)
    wanted = plain.copy()
    wanted[:, 0] = 1500.0 + plain[:, 0] * 1000.0 / 90.0
    wanted[:, 5] = 1400.0 - plain[:, 5] * 5.0
    wanted[:, 4] = 90.0 + plain[:, 4]
    assert_close(told, wanted, 1e-9)
    names = (tmp_path / "t.csv").read_text().partition("\n")[0].split(",")[1:]
    assert [n.rpartition("_")[2] for n in names] == ["us", "deg", "deg", "deg", "deg", "us"]


def test_the_same_table_each_time_and_for_the_map_that_init_writes(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    first = (tmp_path / "t.csv").read_bytes()
    from purcell_cli.files.templates import SERVOS

    assert run(*servo_map(SERVOS))[0] == 0
    assert (tmp_path / "t.csv").read_bytes() == first


def test_the_document_says_what_the_table_holds(run: Run, tmp_path: Path) -> None:
    document = json.loads(run("--json")[1])
    time, _ = table(tmp_path)
    assert (document["to"], document["holds"], document["count"]) == ("servo", "ticks", len(time))
    assert document["joints"] == JOINTS
    assert document["bytes"] == (tmp_path / "t.csv").stat().st_size


# --- What no table can be made of ---------------------------------------------------------------------------------


def test_gimbal_lock_is_refused_with_its_line_and_time_and_an_order_that_has_none(run: Run, tmp_path: Path) -> None:
    trajectory = motion([("limb2 yaw", 0.4), ("limb1 pitch", 1.9), ("limb1 pitch", -1.9)], COLLINEAR)
    written(trajectory, tmp_path)
    code, out, err = run()
    assert (code, out) == (2, "")
    found = re.search(r"swim\.csv:(\d+): limb1_pitch at ([\d.]+) s: wanted 5 degrees or more from \+-90", err)
    assert found, err
    assert abs(float(found[2]) - (0.4 + math.radians(85.0))) < 0.021
    row = int(found[1]) - 2
    assert trajectory.time_s[row] <= float(found[2]) + 1e-5 < trajectory.time_s[row + 1] + 0.02
    order = re.search(r"hinge_order ([xyz]{3}) in --map stays (\d+) degrees away", err)
    assert order, err
    assert not (tmp_path / "t.csv").exists()
    assert run(*servo_map(f"hinge_order: {{limb1: {order[1]}}}"))[0] == 0
    _, told = table(tmp_path)
    assert 90.0 - np.max(np.abs(told[:, 1])) >= float(order[2]) - 1.0


def test_a_lock_that_lies_between_rows_is_found(run: Run, tmp_path: Path) -> None:
    written(motion([("limb1 pitch", 3.0)], COLLINEAR, 100.0), tmp_path)
    code, _, err = run("--rate", "0.1")
    assert code == 2
    assert re.search(r"swim\.csv:2: limb1_pitch at 1\.(48|49|5)", err)
    assert run(*servo_map("hinge_order: {limb1: y}"))[0] == 0, "a hinge of its own has no lock"


def test_an_axis_that_the_hinges_have_not_is_refused_where_the_limb_first_turns_about_it(
    run: Run, tmp_path: Path
) -> None:
    written(motion([("limb1 yaw", 0.5), ("limb2 pitch", 0.4), ("limb1 roll", 0.2)], COLLINEAR), tmp_path)
    assert run(*servo_map("hinge_order: {limb1: zx, limb2: y}"))[0] == 0
    assert [len(part) for part in table(tmp_path)[1][:1]] == [3]
    code, _, err = run(*servo_map("hinge_order: {limb1: zy, limb2: y}"))
    assert code == 2
    assert re.search(r"swim\.csv:\d+: limb1 at 0\.9\d* s: wanted an orientation that the hinges of hinge_order zy", err)


def test_angles_out_of_range_are_refused_with_row_channel_and_by_how_much(run: Run, tmp_path: Path) -> None:
    code, out, err = run(*servo_map("channels: {limb1_yaw: {range: [-60, 45]}}"))
    assert (code, out) == (2, "")
    found = re.search(
        r"swim\.csv:(\d+): limb1_yaw at ([\d.]+) s: wanted -60 to 45 deg, found ([\d.]+) deg, ([\d.]+) deg beyond "
        r"\(at most ([\d.]+) deg beyond, at ([\d.]+) s\)",
        err,
    )
    assert found, err
    rows = read_csv(tmp_path / "swim.csv")
    yaw = np.degrees(rows.euler_rad[:, 1, 0])
    first = int(np.flatnonzero(yaw > 45.0)[0])
    assert abs(int(found[1]) - 2 - first) <= 1
    assert 45.0 < float(found[3]) < 47.0
    assert abs(float(found[4]) - (float(found[3]) - 45.0)) < 1e-2
    assert abs(float(found[5]) - (np.max(yaw) - 45.0)) < 1e-3
    assert abs(float(found[6]) - rows.time_s[int(np.argmax(yaw))]) < 0.03
    assert not (tmp_path / "t.csv").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hinge_order: {limb1: zyz}", "hinge_order.limb1: wanted one to three different letters of x, y and z"),
        ("hinge_order: {limb1: ''}", "hinge_order.limb1: wanted one to three different letters"),
        ("hinge_order: zyx", "hinge_order: wanted a mapping"),
        ("channels: {limb1_jaw: {}}", "(nearest: limb1_yaw), found the unknown key 'limb1_jaw'"),
        ("hinge_order: {limb1: zy}\nchannels: {limb1_roll: {}}", ":2: channels.limb1_roll: wanted a joint of the"),
        ("channels: {limb1_yaw: {unit: rad}}", "channels.limb1_yaw.unit: wanted one of deg, us"),
        ("channels: {limb1_yaw: {sign: 0}}", "channels.limb1_yaw.sign: wanted 1 or -1, found the number 0"),
        ("channels: {limb1_yaw: {sign: '1'}}", "channels.limb1_yaw.sign: wanted 1 or -1, found the text '1'"),
        ("channels: {limb1_yaw: {scale: 0}}", "channels.limb1_yaw.scale: wanted a finite number above 0"),
        ("channels: {limb1_yaw: {scale: 1e300}}", "channels.limb1_yaw.scale: wanted a finite number above 0 and at"),
        ("channels: {limb1_yaw: {zero: .nan}}", "channels.limb1_yaw.zero: wanted a finite number"),
        ("channels: {limb1_yaw: {range: [90, -90]}}", "channels.limb1_yaw.range: wanted the least before the most"),
        ("channels: {limb1_yaw: {range: [90, 90]}}", "channels.limb1_yaw.range: wanted the least before the most"),
        ("channels: {limb1_yaw: {range: [90]}}", "channels.limb1_yaw.range: wanted a list of 2, each a finite number"),
        ("lock_margin_deg: 0", "lock_margin_deg: wanted a finite number above 0 and at most 45"),
        ("lock_margin_deg: 5 deg", "lock_margin_deg: wanted a finite number above 0"),
        ("servos: {}", "servos: wanted one of the keys hinge_order, lock_margin_deg, channels"),
    ],
)
def test_bad_maps_are_refused(run: Run, tmp_path: Path, text: str, message: str) -> None:
    code, out, err = run(*servo_map(text))
    assert (code, out) == (2, "")
    assert message in err
    assert err.startswith("purcell export: servos.yaml:")
    assert err.count("\n") == 1
    assert not (tmp_path / "t.csv").exists()


@pytest.mark.parametrize("rate", ["0", "-50", "nan", "inf", "1e9", "99999"])
def test_rates_that_no_clock_has_are_refused(run: Run, tmp_path: Path, rate: str) -> None:
    if rate == "99999":
        written(motion([("limb1 yaw", 100.0)], COLLINEAR, 10.0), tmp_path)
    code, _, err = run("--rate", rate)
    assert code == 2
    assert err.startswith("purcell export: --rate: ")
    assert "wanted, found" in err
    assert not (tmp_path / "t.csv").exists()


def test_a_limb_that_turns_without_end_is_refused(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_path, "_MOST_INSTANTS", 250)
    code, _, err = run()
    assert code == 2
    assert "swim.csv: wanted limbs that turn by 5 rad in all at most, found limb 1 turning by" in err


def test_options_that_do_not_belong_are_refused(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain = runner(capsys, "export", "swim.csv")
    assert "--rate: no rate is wanted for urdf" in plain("--to", "urdf", "--rate", "50")[2]
    assert "--map: no map is wanted for rerun" in plain("--to", "rerun", *servo_map("{}"))[2]
    assert "--to: one of servo, mcap, rerun, urdf (nearest: servo) is wanted" in plain("--to", "servos")[2]
    assert plain("--out", "t.csv")[0] == 2
    assert sorted(p.name for p in tmp_path.iterdir()) == ["servos.yaml", "swim.csv", "swimmer.yaml"]


def test_a_trajectory_of_another_swimmer_is_warned_of(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = runner(capsys, "export", "swim.csv", "--to", "urdf")()
    assert code == 0
    assert "its rows move otherwise than this swimmer does" in err
    assert run()[2] == ""
    assert START.pose[0, 3] == 0.2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("package", "words", "message"),
    [
        ("mcap_ros2", ["export", "swim.csv", "--to", "mcap"], "exports to mcap need mcap-ros2-support, found none"),
        ("rerun", ["export", "swim.csv", "--to", "rerun"], "exports to rerun need rerun-sdk, found none"),
        ("PIL", ["view", "swim.csv", "--out", "swim.gif"], "films need pillow, found none"),
        ("av", ["view", "swim.csv", "--out", "swim.mp4", "--size", "64x64"], "films need av, found none"),
    ],
)
def test_without_a_package_one_sentence_says_what_to_install(
    tmp_path: Path, package: str, words: list[str], message: str
) -> None:
    written(usual(), tmp_path)
    program = f"import sys; sys.modules[{package!r}] = None\nfrom purcell_cli.cli.app import main; main()"
    arguments = [sys.executable, "-c", program, *words, "--swimmer", "swimmer.yaml"]
    done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, encoding="utf-8")
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert "install it: python -m pip install '" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["swim.csv", "swimmer.yaml"]
