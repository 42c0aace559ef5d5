"""The trajectory CSV keeps its documented form to the letter, and files are written whole or not at all."""

from __future__ import annotations

import csv
import errno
import functools
import math
import os
import stat
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest
from helpers import UNIT, assert_close, dop853_rates, is_close, random_rotations
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, plan, read_csv, write_csv
from purcell_cli.errors import InputError
from purcell_cli.files import trajectory_csv
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.geometry.rotations import Array, about_axis, as_quaternion
from purcell_cli.motion.trajectory import Trajectory, continuous_quaternions
from purcell_cli.motion.trajectory_table import Table

HEADER = (
    "t_s,phase,gait,x_m,y_m,z_m,qw,qx,qy,qz,psi_rad,theta_rad,phi_rad,"
    "l1_qw,l1_qx,l1_qy,l1_qz,l1_psi_rad,l1_theta_rad,l1_phi_rad,"
    "l2_qw,l2_qx,l2_qy,l2_qz,l2_psi_rad,l2_theta_rad,l2_phi_rad,"
    "w1x_rad_s,w1y_rad_s,w1z_rad_s,w2x_rad_s,w2y_rad_s,w2z_rad_s"
)
NAMES = HEADER.split(",")
RATES = NAMES[-6:]
START = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 75), (30, 10, 0), (-20, 15, 5))
GOAL = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 135), (0, 0, 30), (-20, 15, 5))
WRITTEN_BEFORE = "what was here before\n"


@functools.cache
def planned() -> Trajectory:
    """Return the trajectory of a plan through all three phases."""
    return plan(START, GOAL).trajectory


@functools.cache
def stroke() -> Trajectory:
    """Return a short trajectory: two cycles of a roll for a swimmer with L = 1 m, seen from an odd place."""
    return sample_stroke(UNIT, Configuration(START.pose), realise(stored_gaits()["x-rotation"], UNIT), 2, 0.01)


def turning(count: int, turns: float) -> Trajectory:
    """Return a trajectory whose base and limbs turn about fixed axes a number of times."""
    angle = np.linspace(0.0, 2 * math.pi * turns, count)
    pose = np.tile(np.eye(4), (count, 1, 1))
    pose[:, :3, :3] = about_axis(2, angle) @ about_axis(0, 0.3)
    pose[:, 0, 3] = angle / 3.0
    shape = np.stack([about_axis(0, -angle), about_axis(1, 2.0 * angle)], axis=1)
    whole = np.ones(count, dtype=np.int64)
    return Trajectory(angle + 0.1, whole, 0 * whole, ("turning",), pose, shape, np.zeros((count, 6)))


def standing(time_s: Array, position_m: Array) -> Trajectory:
    """Return a trajectory with given times and positions and nothing else."""
    n = len(time_s)
    pose = np.tile(np.eye(4), (n, 1, 1))
    pose[:, :3, 3] = position_m
    whole = np.ones(n, dtype=np.int64)
    shape = np.tile(np.eye(3), (n, 2, 1, 1))
    return Trajectory(time_s, whole, 0 * whole, ("standing",), pose, shape, np.zeros((n, 6)))


def rows_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a file by Python's own csv reader."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def columns(rows: list[dict[str, str]], names: list[str]) -> Array:
    """Return columns by Python's own float(). Shape (rows, names)."""
    return np.array([[float(row[name]) for name in names] for row in rows])


def numbers(table: Table) -> Array:
    """Return all numbers of a table side by side. Shape (n, 31)."""
    n = len(table.time_s)
    parts = [table.time_s, table.position_m, table.base, table.limbs, table.euler_rad, table.rate_rad_s]
    return np.concatenate([np.reshape(part, (n, -1)) for part in parts], axis=1)


def written(folder: Path, trajectory: Trajectory) -> Path:
    """Return the file of a trajectory."""
    path = folder / "trajectory.csv"
    write_csv(trajectory, path)
    return path


@pytest.fixture
def good(tmp_path: Path) -> Path:
    """Return a good file of some rows."""
    return written(tmp_path, stroke())


# --- The form ------------------------------------------------------------------------------------------------------


def test_the_header_names_the_columns_in_their_order(good: Path) -> None:
    assert good.read_bytes().startswith(HEADER.encode() + b"\n")


def test_lines_end_in_a_newline_and_all_have_every_column(good: Path) -> None:
    data = good.read_bytes()
    assert b"\r" not in data
    assert data.endswith(b"\n")
    assert not data.endswith(b"\n\n")
    lines = data.decode("ascii").split("\n")[:-1]
    assert len(lines) == len(stroke()) + 1
    assert {line.count(",") for line in lines} == {len(NAMES) - 1}
    assert "nan" not in data.decode().lower()
    assert "inf" not in data.decode().lower()


def test_a_row_says_its_phase_and_its_stroke(tmp_path: Path) -> None:
    rows = rows_of(written(tmp_path, planned()))
    assert list(dict.fromkeys(row["phase"] for row in rows)) == ["1", "2", "3"]
    trajectory = planned()
    assert [row["gait"] for row in rows] == [trajectory.gaits[k] for k in trajectory.gait]
    assert [int(row["phase"]) for row in rows] == trajectory.phase.tolist()


def test_every_number_written_is_the_number_read_back(good: Path) -> None:
    """By Python's float() and by read_csv, to the last bit."""
    trajectory, rows = stroke(), rows_of(good)
    by_python = columns(rows, [n for n in NAMES if n not in {"phase", "gait"}])
    table = read_csv(good)
    assert np.array_equal(by_python[:, 0], trajectory.time_s)
    assert np.array_equal(by_python[:, 1:4], trajectory.pose[:, :3, 3])
    assert np.array_equal(by_python[:, 4:8], trajectory.base_quaternion)
    assert np.array_equal(by_python[:, 8:11], trajectory.base_euler_rad)
    assert np.array_equal(by_python[:, [*range(11, 15), *range(18, 22)]], trajectory.limb_quaternion.reshape(-1, 8))
    assert np.array_equal(by_python[:, -6:], trajectory.rate_rad_s)
    assert np.array_equal(table.time_s, trajectory.time_s)
    assert np.array_equal(table.position_m, trajectory.pose[:, :3, 3])
    assert np.array_equal(table.base, trajectory.base_quaternion)
    assert np.array_equal(table.limbs, trajectory.limb_quaternion)
    assert np.array_equal(table.euler_rad[:, 0], trajectory.base_euler_rad)
    assert np.array_equal(table.euler_rad.reshape(-1, 9), by_python[:, [8, 9, 10, 15, 16, 17, 22, 23, 24]])
    assert np.array_equal(table.rate_rad_s, trajectory.rate_rad_s)
    assert np.array_equal(table.phase, trajectory.phase)
    assert table.gait.tolist() == [row["gait"] for row in rows]


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.lists(st.tuples(FINITE, FINITE, FINITE, FINITE), min_size=1, max_size=8))
def test_any_double_comes_back_to_the_last_bit(tmp_path: Path, values: list[tuple[float, ...]]) -> None:
    wanted = np.array(sorted(values))  # times do not fall
    path = written(tmp_path, standing(wanted[:, 0].copy(), wanted[:, 1:].copy()))
    table = read_csv(path)
    found = columns(rows_of(path), ["t_s", "x_m", "y_m", "z_m"])
    assert np.array_equal(found, wanted)
    assert np.array_equal(table.time_s, wanted[:, 0])
    assert np.array_equal(table.position_m, wanted[:, 1:])
    assert not np.any(np.signbit(found[:, 1:]) & (found[:, 1:] == 0.0)), "a zero is written without a sign"


@pytest.mark.slow
def test_a_file_longer_than_one_batch_has_one_header_and_every_row(tmp_path: Path) -> None:
    trajectory = turning(140_001, 40.0)
    path = written(tmp_path, trajectory)
    assert path.read_bytes().count(b"t_s") == 1
    table = read_csv(path)
    assert np.array_equal(table.time_s, trajectory.time_s)
    assert np.array_equal(table.base, trajectory.base_quaternion)
    assert np.array_equal(table.limbs, trajectory.limb_quaternion)


# --- What it says --------------------------------------------------------------------------------------------------


def test_the_first_row_is_the_start_and_the_last_the_goal(tmp_path: Path) -> None:
    table = read_csv(written(tmp_path, planned()))
    for row, where, tolerance in ((0, START, 1e-14), (-1, GOAL, 1e-9)):
        assert_close(table.position_m[row], where.pose[:3, 3], tolerance)
        for quaternion, rotation in zip(
            [table.base[row], *table.limbs[row]], [where.pose[:3, :3], *where.shape], strict=True
        ):
            assert_close(Rotation.from_quat(quaternion, scalar_first=True).as_matrix(), rotation, tolerance)
    assert table.time_s[0] == 0.0


def test_the_last_rows_controls_are_zero_and_no_others(tmp_path: Path) -> None:
    for trajectory in (planned(), stroke()):
        rows = rows_of(written(tmp_path, trajectory))
        assert [rows[-1][name] for name in RATES] == ["0.0"] * 6
        assert all(np.count_nonzero(rates) == 1 for rates in columns(rows[:-1], RATES))


def test_a_plan_of_one_row_is_a_file_of_one_row(tmp_path: Path) -> None:
    path = written(tmp_path, plan(Configuration(), Configuration()).trajectory)
    rows = rows_of(path)
    assert len(rows) == 1
    assert [rows[0][name] for name in RATES] == ["0.0"] * 6


def test_quaternions_are_of_unit_length_and_keep_their_sign_along_the_file(tmp_path: Path) -> None:
    """Through many turns; the foil, quaternions with w never negative, jumps."""
    trajectory = turning(2000, 5.0)
    table = read_csv(written(tmp_path, trajectory))
    for quaternion in (table.base, table.limbs[:, 0], table.limbs[:, 1]):
        assert_close(np.linalg.norm(quaternion, axis=1), np.ones(2000), 1e-15)
        assert np.all(np.einsum("ni,ni->n", quaternion[1:], quaternion[:-1]) > 0.9)
        assert quaternion[0, 0] > 0.0 > quaternion[:, 0].min()
    jumping = as_quaternion(trajectory.pose[:, :3, :3])
    assert np.einsum("ni,ni->n", jumping[1:], jumping[:-1]).min() < -0.9


def test_euler_angles_and_quaternions_say_the_same_orientations(tmp_path: Path) -> None:
    """Intrinsic Z-Y-X, as scipy reads them; the extrinsic angles are the foil."""
    table = read_csv(written(tmp_path, planned()))
    for k, quaternion in enumerate((table.base, table.limbs[:, 0], table.limbs[:, 1])):
        wanted = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
        assert_close(Rotation.from_euler("ZYX", table.euler_rad[:, k]).as_matrix(), wanted, 1e-14)
        assert not is_close(Rotation.from_euler("zyx", table.euler_rad[:, k]).as_matrix(), wanted, 1e-3)


@pytest.mark.slow
def test_the_controls_of_the_file_alone_replay_the_motion(good: Path) -> None:
    """By the plain equations of motion; controls that hold until their own row, not from it, are the foil."""
    rows = rows_of(good)
    time, rates = columns(rows, ["t_s"])[:, 0], columns(rows, RATES)
    position, quaternion = columns(rows, ["x_m", "y_m", "z_m"]), columns(rows, ["qw", "qx", "qy", "qz"])

    def replayed(held: Array) -> Array:
        begins = np.flatnonzero(np.append(True, np.any(held[1:] != held[:-1], axis=1)))
        seconds = np.diff(np.append(time[begins], time[-1]))
        return dop853_rates(UNIT, held[begins], seconds, np.tile(np.eye(3), (2, 1, 1)), START.pose)

    wanted = np.eye(4)
    wanted[:3, 3] = position[-1]
    wanted[:3, :3] = Rotation.from_quat(quaternion[-1], scalar_first=True).as_matrix()
    assert_close(replayed(rates[:-1]), wanted, 1e-11)
    assert not is_close(replayed(rates[1:]), wanted, 1e-11)


def test_every_control_switch_has_a_row(good: Path) -> None:
    """Every turn of every cycle begins at a row, at the time that the turns before it take."""
    trajectory = stroke()
    angles = realise(stored_gaits()["x-rotation"], UNIT).played(2).angle
    begins = np.cumsum(np.abs(angles)) - np.abs(angles)
    rows = np.searchsorted(trajectory.time_s, begins - 1e-12)
    assert_close(trajectory.time_s[rows], begins, 1e-12)
    table = read_csv(good)
    assert np.all(np.diff(table.time_s) <= 0.01 * (1 + 1e-9))


# --- Whole or not at all -------------------------------------------------------------------------------------------


def write_half(path: Path, failure: BaseException) -> None:
    """Write half of a file, and fail."""
    with whole_file(path) as stream:
        stream.write(b"half of")
        stream.flush()
        raise failure


@pytest.mark.parametrize("before", [WRITTEN_BEFORE, None], ids=["old file", "no file"])
@pytest.mark.parametrize(
    "failure", [RuntimeError("stop"), KeyboardInterrupt(), MemoryError(), SystemExit(3)], ids=lambda f: type(f).__name__
)
def test_an_exception_in_the_middle_leaves_what_was_there(
    tmp_path: Path, failure: BaseException, before: str | None
) -> None:
    path = tmp_path / "trajectory.csv"
    if before is not None:
        path.write_text(before)
    with pytest.raises(type(failure)):
        write_half(path, failure)
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == ({} if before is None else {path.name: before})


@pytest.mark.parametrize(
    "failure",
    [KeyboardInterrupt(), MemoryError(), OSError(errno.ENOSPC, "No space left on device")],
    ids=lambda f: type(f).__name__,
)
def test_a_write_that_fails_in_its_second_batch_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: BaseException
) -> None:
    path = tmp_path / "trajectory.csv"
    path.write_text(WRITTEN_BEFORE)

    def failing(rotation: Array, before: Array | None) -> Array:
        if before is not None:
            raise failure
        return continuous_quaternions(rotation, before)

    monkeypatch.setattr(trajectory_csv, "continuous_quaternions", failing)
    with pytest.raises(InputError if isinstance(failure, OSError) else type(failure)) as caught:
        write_csv(turning(70_000, 1.0), path)
    if isinstance(failure, OSError):
        assert str(caught.value) == f"{path}: cannot be written (No space left on device)"
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {path.name: WRITTEN_BEFORE}


def test_a_good_write_takes_the_place_of_the_old_file_and_leaves_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.csv"
    path.write_text(WRITTEN_BEFORE)
    write_csv(stroke(), path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_text().startswith(HEADER)


@pytest.mark.skipif(os.name != "posix", reason="permission bits are POSIX's")
def test_a_file_has_the_permissions_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("")
    path = written(tmp_path, stroke())
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)


def test_a_name_as_long_as_the_system_allows_can_be_written(tmp_path: Path) -> None:
    path = tmp_path / ("n" * 251 + ".csv")
    write_csv(turning(3, 0.1), path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    with pytest.raises(InputError, match="cannot be written"):
        write_csv(turning(3, 0.1), tmp_path / ("n" * 300 + ".csv"))
    assert len(list(tmp_path.iterdir())) == 1


def refused(path: Path) -> str:
    """Return the message with which a file is refused, and check that it names the file."""
    with pytest.raises(InputError) as caught:
        write_csv(stroke(), path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_a_place_that_cannot_be_written_to_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text(WRITTEN_BEFORE)
    (tmp_path / "folder").mkdir()
    assert "folder" in refused(tmp_path / "missing" / "t.csv")
    assert "folder" in refused(tmp_path / "file" / "t.csv")
    assert "wanted a file to write, found a folder" in refused(tmp_path / "folder")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]
    assert list((tmp_path / "folder").iterdir()) == []
    assert (tmp_path / "file").read_text() == WRITTEN_BEFORE


def test_a_folder_without_write_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For real where permissions bind us, else as the system would say it."""
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):

        def denied(*_: object, **__: object) -> NoReturn:
            raise PermissionError(errno.EACCES, "Permission denied")

        monkeypatch.setattr(Path, "open", denied)
    assert "cannot be written" in refused(folder / "t.csv")
    folder.chmod(0o700)
    assert list(folder.iterdir()) == []


# --- Reading -------------------------------------------------------------------------------------------------------


def with_cell(text: str, line: int, column: str, cell: str) -> str:
    """Return a file's text with one cell changed; the header is line 1."""
    lines = text.split("\n")
    cells = lines[line - 1].split(",")
    cells[NAMES.index(column)] = cell
    lines[line - 1] = ",".join(cells)
    return "\n".join(lines)


def with_line(text: str, line: int, new: str | None) -> str:
    """Return a file's text with one line replaced, or left out."""
    lines = text.split("\n")
    lines[line - 1 : line] = [] if new is None else [new]
    return "\n".join(lines)


def reading(folder: Path, text: str | bytes) -> str:
    """Return the message with which a file of this text is refused; it begins with the file's name."""
    path = folder / "changed.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as caught:
        read_csv(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message.removeprefix(str(path))


@pytest.mark.parametrize(
    ("header", "column", "wanted", "found"),
    [
        (HEADER.replace("qw,qx", "qx,qw", 1), 7, "'qw'", "'qx'"),
        (HEADER.replace("t_s", "time", 1), 1, "'t_s'", "'time'"),
        (HEADER.replace("w2z_rad_s", "w2z_deg_s"), 33, "'w2z_rad_s'", "'w2z_deg_s'"),
        (HEADER.rsplit(",", 1)[0], 33, "'w2z_rad_s'", "no more"),
        (HEADER + ",more", 34, "no more columns", "'more'"),
        (HEADER.upper(), 1, "'t_s'", "'T_S'"),
        (HEADER.replace(",", ";"), 1, "'t_s'", "'t_s;phase;"),
        ("# a comment\n" + HEADER, 1, "'t_s'", "'# a comment'"),
        ("", 1, "'t_s'", "''"),
    ],
)
def test_a_wrong_header_is_refused_at_its_column(good: Path, header: str, column: int, wanted: str, found: str) -> None:
    message = reading(good.parent, with_line(good.read_text(), 1, header))
    assert message.startswith(f":1: column {column}: wanted {wanted}, found {found}")


@pytest.mark.parametrize("cell", ["nan", "NaN", "inf", "-inf", "1e999", ""])
@pytest.mark.parametrize("column", ["t_s", "x_m", "l2_qz", "w1x_rad_s"])
def test_a_number_that_is_not_finite_is_refused_at_its_line(good: Path, column: str, cell: str) -> None:
    message = reading(good.parent, with_cell(good.read_text(), 5, column, cell))
    assert message == f":5: column '{column}': wanted finite numbers in every row, found {cell or 'an empty cell'}"


@pytest.mark.parametrize(("column", "cell"), [("x_m", "abc"), ("x_m", "0x1p3"), ("x_m", "1_0"), ("phase", "1.5")])
def test_a_cell_that_is_no_number_is_refused(good: Path, column: str, cell: str) -> None:
    message = reading(good.parent, with_cell(good.read_text(), 5, column, cell))
    assert message == f":5: column '{column}': wanted numbers in every row, found '{cell}'"


def test_a_truncated_row_is_refused_at_its_line(good: Path) -> None:
    text = good.read_text()
    row = text.split("\n")[6]
    for cut in (row[: row.rindex(",")], row[:40], row.split(",")[0]):
        assert reading(good.parent, with_line(text, 7, cut)).startswith(":7: wanted a row of finite numbers")
    last = len(stroke()) + 1
    assert reading(good.parent, text[:-150]).startswith(f":{last}: wanted a row of finite numbers")
    assert reading(good.parent, with_line(text, 4, "")).startswith(":4: wanted a row of finite numbers")


def test_a_row_with_more_columns_is_refused(good: Path) -> None:
    text = good.read_text()
    assert "more fields" in reading(good.parent, with_line(text, 7, text.split("\n")[6] + ",1.0"))


@pytest.mark.parametrize("text", [HEADER, HEADER + "\n"])
def test_a_file_without_rows_is_refused(tmp_path: Path, text: str) -> None:
    assert reading(tmp_path, text) == ":2: wanted a row of finite numbers, found no row"


@pytest.mark.parametrize("data", [b"\x00\xff\xfe" * 100, b"\xff", b"\x89PNG\r\n\x1a\n", b"\x1f\x8b\x08\x00"])
def test_a_file_of_other_bytes_is_refused(tmp_path: Path, data: bytes) -> None:
    assert reading(tmp_path, data).startswith(":1: ")


def test_a_file_that_is_missing_or_a_folder_is_refused(tmp_path: Path) -> None:
    for path, found in ((tmp_path / "missing.csv", "none: no such file"), (tmp_path, "a folder")):
        with pytest.raises(InputError) as caught:
            read_csv(path)
        assert str(caught.value) == f"{path}: wanted a trajectory file, found {found}"


def test_line_ends_of_other_systems_are_read(good: Path) -> None:
    """The foil of all refusals: a file that says the same is read the same."""
    other = good.parent / "other.csv"
    wanted = numbers(read_csv(good))
    for data in (good.read_bytes().replace(b"\n", b"\r\n"), good.read_bytes().rstrip(b"\n")):
        other.write_bytes(data)
        assert np.array_equal(numbers(read_csv(other)), wanted)


def quoted(text: str) -> str:
    """Return a trajectory file as R writes it: texts in quotes."""
    names = [f'"{name}"' for name in text.split("\n")[0].split(",")]
    rows = [line.split(",") for line in text.splitlines()[1:]]
    return "\n".join([",".join(names), *(",".join([*row[:2], f'"{row[2]}"', *row[3:]]) for row in rows)]) + "\n"


SAVED_AGAIN = {
    "a byte order mark": lambda text: "\ufeff" + text,
    "the mark and the line ends of a spreadsheet": lambda text: "\ufeff" + text.replace("\n", "\r\n"),
    "quotes, as R writes them": quoted,
    "quotes and a mark": lambda text: "\ufeff" + quoted(text),
    "quotes in the header alone": lambda text: "\n".join([quoted(text).split("\n")[0], *text.split("\n")[1:]]),
    "empty lines at the end": lambda text: text + "\n\n",
    "empty lines of a spreadsheet": lambda text: text.replace("\n", "\r\n") + "\r\n",
    "large exponents": lambda text: text.replace("e-", "E-"),
}


@pytest.mark.parametrize("what", SAVED_AGAIN)
def test_a_file_that_another_program_saved_again_is_read_the_same(good: Path, what: str) -> None:
    wanted = numbers(read_csv(good))
    good.write_bytes(SAVED_AGAIN[what](good.read_text()).encode())
    assert np.array_equal(numbers(read_csv(good)), wanted)
    assert set(read_csv(good).gait) == {"x-rotation"}


@pytest.mark.parametrize(
    ("change", "hint"),
    [
        (lambda text: text.replace(",", ";"), "columns are parted by commas, not by ';'"),
        (lambda text: text.replace(",", "\t"), "columns are parted by commas, not by '\\t'"),
        (
            lambda text: '{\n  "schema": "purcell/plan-document/1"\n}\n',
            "purcell run makes the trajectory of a plan document",
        ),
        (lambda text: "\n".join(f'"{k or ""}",{row}' for k, row in enumerate(text.splitlines())), "row.names = FALSE"),
    ],
)
def test_a_file_saved_with_other_columns_is_refused_with_a_hint(good: Path, change: Any, hint: str) -> None:
    message = reading(good.parent, change(good.read_text()))
    assert message.startswith(":1: column 1: wanted 't_s'")
    assert hint in message


PATHS = [
    "run[1].csv",
    "a*b.csv",
    "a?.csv",
    "~/t.csv",
    "{a,b}.csv",
    "50%25 off.csv",
    "s3:/b/t.csv",
    "a b\nc.csv",
    "$HOME",
]


@pytest.mark.skipif(os.name != "posix", reason="other systems do not take such names")
@pytest.mark.parametrize("name", [*PATHS, "\udcff.csv", "run[[]1].csv", "file:t.csv", "hf:/t.csv", "x=1/t.csv"])
def test_a_path_is_a_path_and_no_pattern(good: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """The foil stands beside: a file that the name as a pattern, or as an address, would mean."""
    monkeypatch.chdir(good.parent)
    text = good.read_text()
    for other in ("run1.csv", "aXb.csv", "ab.csv", "a.csv", "50% off.csv"):
        Path(other).write_text(text.replace(text.splitlines()[5], text.splitlines()[6]))
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    write_csv(stroke(), name)
    assert np.array_equal(numbers(read_csv(name)), numbers(read_csv(good)))
    assert Path(name).read_bytes() == text.encode()


def test_reading_what_was_written_and_writing_it_again_gives_the_same_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    n = 200
    pose = np.tile(np.eye(4), (n, 1, 1))
    pose[:, :3, :3], pose[:, :3, 3] = random_rotations(rng, n), rng.normal(size=(n, 3))
    whole = np.ones(n, dtype=np.int64)
    wanted = Trajectory(
        np.arange(n) / 7.0, whole, 0 * whole, ("g",), pose, random_rotations(rng, n, 2), rng.normal(size=(n, 6))
    )
    table = read_csv(written(tmp_path, wanted))
    again = [
        Rotation.from_quat(q, scalar_first=True).as_matrix() for q in (table.base, table.limbs[:, 0], table.limbs[:, 1])
    ]
    assert_close(again[0], wanted.pose[:, :3, :3], 1e-15, 10.0)
    assert_close(np.stack(again[1:], axis=1), wanted.shape, 1e-15, 10.0)
    assert np.array_equal(table.position_m, wanted.pose[:, :3, 3])
    assert np.array_equal(table.rate_rad_s, wanted.rate_rad_s)
