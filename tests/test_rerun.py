"""A trajectory as a Rerun recording: the SDK reads back the links, their poses and the controls."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, assert_close, is_close, runner
from motions import motion, usual, written
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, Swimmer, read_csv
from purcell_cli.files.builtin import find_swimmer
from purcell_cli.mechanics.primitives import CONTROL_NAMES
from purcell_cli.motion.trajectory import as_table

chunk: Any = pytest.importorskip("rerun.chunk", reason="no rerun-sdk, 660 MB: no recording is written or read")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that exports the motion in swim.csv to Rerun: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    written(usual(), tmp_path)
    return runner(capsys, "export", "swim.csv", "--to", "rerun", "--swimmer", "swimmer.yaml")


def recorded(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """Return the columns of each entity, read by the SDK."""
    out: dict[str, dict[str, np.ndarray]] = {}
    for part in chunk.RrdReader(str(path)).stream():
        batch = part.to_record_batch()
        for name in batch.schema.names:
            if ":" in name or name == "time":
                column = batch.column(name)
                values = (column.cast("int64") if name == "time" else column).to_pylist()
                out.setdefault(part.entity_path, {})[name] = np.array(values, dtype=object)
    return out


def numbers(values: np.ndarray, *shape: int) -> np.ndarray:
    return np.array(values.tolist(), dtype=np.float64).reshape(shape)


def test_the_links_turn_and_move_as_the_rows_say(run: Run, tmp_path: Path) -> None:
    code, out, err = run()
    rows = read_csv(tmp_path / "swim.csv")
    n = len(rows.time_s)
    assert (code, err) == (0, "")
    assert out.startswith(f"swim.rrd: {n} rows, ")
    found = recorded(tmp_path / "swim.rrd")
    places = {
        "/world/base": rows.position_m,
        "/world/base/limb1": np.tile([0.1, 0.0, 0.0], (n, 1)),
        "/world/base/limb2": np.tile([-0.1, 0.0, 0.0], (n, 1)),
    }
    for (entity, place), turn in zip(places.items(), (rows.base, rows.limbs[:, 0], rows.limbs[:, 1]), strict=True):
        told = found[entity]
        assert_close(numbers(told["time"], n) * 1e-9, rows.time_s, 1e-9)
        assert_close(numbers(told["Transform3D:translation"], n, 3), place, 1e-7)
        assert_close(numbers(told["Transform3D:quaternion"], n, 4), np.roll(turn, -1, axis=1), 1e-7)
        assert not is_close(numbers(told["Transform3D:quaternion"], n, 4), turn, 1e-2), "w comes last there"
    for k, name in enumerate(CONTROL_NAMES):
        rate = found[f"/controls_rad_s/{name.replace(' ', '_')}"]["Scalars:scalars"]
        assert_close(numbers(rate, n), rows.rate_rad_s[:, k], 0.0)
    path = numbers(found["/world/path"]["LineStrips3D:strips"], n, 3)
    assert_close(path, rows.position_m, 1e-7)


def test_the_links_are_capsules_of_their_length_and_radius_along_their_own_x(run: Run, tmp_path: Path) -> None:
    assert run()[0] == 0
    found = recorded(tmp_path / "swim.rrd")
    for name, begin, end, radius in (
        ("base", -0.1, 0.1, 0.004),
        ("base/limb1", 0.0, 0.14, 0.0028),
        ("base/limb2", 0.0, -0.14, 0.0028),
    ):
        told = {key.removeprefix("Capsules3D:"): value for key, value in found[f"/world/{name}/link"].items()}
        length = float(numbers(told["lengths"], 1)[0])
        turn = Rotation.from_quat(numbers(told["quaternions"], 4))
        first = numbers(told["translations"], 3)
        assert_close(first, [begin, 0.0, 0.0], 1e-7)
        assert_close(first + turn.apply([0.0, 0.0, length]), [end, 0.0, 0.0], 1e-7)
        assert_close(numbers(told["radii"], 1), [radius], 1e-8)


def test_the_body_is_a_ball_at_the_middle_of_the_base(tmp_path: Path) -> None:
    rerun_file = importlib.import_module("purcell_cli.exports.rerun_file")  # wants rerun-sdk
    swimmer = Swimmer(body_radius_m=0.03, joints=find_swimmer("universal").joints)
    table = as_table(motion([("limb1 pitch", 0.4), ("limb1 base yaw", 0.9)], Configuration(), 0.05, swimmer))
    for name, body in (("with", swimmer), ("without", Swimmer())):
        with (tmp_path / name).open("wb") as stream:
            assert rerun_file.write_rerun(table, body, name, stream) == len(table.time_s)
    found = recorded(tmp_path / "with")
    assert_close(numbers(found["/world/base/body"]["Ellipsoids3D:half_sizes"], 3), [0.03] * 3, 1e-8)
    assert_close(numbers(found["/world/base"]["Transform3D:translation"], -1, 3), table.position_m, 1e-7)
    assert "/world/base/body" not in recorded(tmp_path / "without")
