"""Every format of a trajectory says the same, number for number, and reads back as it was written."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers import assert_close, is_close
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, read_csv, realise, stored_gaits, write_csv
from purcell_cli.cli.app import _run
from purcell_cli.errors import InputError, UnknownNameError
from purcell_cli.files.measured_reader import read_measured
from purcell_cli.files.trajectory_csv import COLUMNS
from purcell_cli.files.trajectory_formats import FORMATS, chosen_format, write_trajectory
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.motion.trajectory_table import Table


@functools.cache
def stroke() -> Trajectory:
    """Return two cycles of a roll in which limbs and base turn about all axes, from an odd place."""
    start = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 175))
    return sample_stroke(Swimmer(), start, realise(stored_gaits()["x-rotation"], Swimmer(), 1.0), 2, 0.01)


def as_csv_says(folder: Path) -> pl.DataFrame:
    """Return the trajectory as its CSV file says it."""
    write_csv(stroke(), folder / "t.csv")
    types = dict.fromkeys(COLUMNS, pl.Float64) | {"phase": pl.Int64, "gait": pl.String}
    return pl.read_csv(folder / "t.csv", schema=types)


def test_parquet_holds_what_the_csv_holds(tmp_path: Path) -> None:
    write_trajectory(stroke(), tmp_path / "t.parquet", "parquet")
    found = pl.read_parquet(tmp_path / "t.parquet")
    wanted = as_csv_says(tmp_path)
    assert tuple(found.columns) == COLUMNS
    assert found.equals(wanted)
    assert not found.equals(wanted.with_columns(pl.col("x_m") * (1.0 + 2.0**-52)))


def test_npz_holds_what_the_csv_holds(tmp_path: Path) -> None:
    write_trajectory(stroke(), tmp_path / "t.npz", "npz")
    wanted = as_csv_says(tmp_path)
    with np.load(tmp_path / "t.npz", allow_pickle=False) as found:
        assert tuple(found.files) == COLUMNS
        for name in COLUMNS:
            assert np.array_equal(found[name], wanted[name].to_numpy()), name


def test_tum_lines_are_time_position_and_quaternion_with_w_last(tmp_path: Path) -> None:
    """The foil is a quaternion with w first, which is another rotation."""
    write_trajectory(stroke(), tmp_path / "t.tum", "tum")
    found = np.loadtxt(tmp_path / "t.tum")
    table = read_csv_of(tmp_path)
    assert found.shape == (len(stroke()), 8)
    assert np.array_equal(found[:, 0], table.time_s)
    assert np.array_equal(found[:, 1:4], table.position_m)
    wanted = stroke().pose[:, :3, :3]
    assert_close(Rotation.from_quat(found[:, 4:]).as_matrix(), wanted, 1e-14)
    assert not is_close(Rotation.from_quat(found[:, 4:], scalar_first=True).as_matrix(), wanted, 1e-3)


def read_csv_of(folder: Path) -> Table:
    """Return the trajectory as its CSV file is read."""
    write_csv(stroke(), folder / "t.csv")
    return read_csv(folder / "t.csv")


@pytest.mark.parametrize("form", FORMATS)
def test_a_file_is_the_same_bytes_each_time(tmp_path: Path, form: str) -> None:
    for name in ("a", "b"):
        write_trajectory(stroke(), tmp_path / name, form)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]


@pytest.mark.parametrize(("form", "found"), [("parquet", "a Parquet file"), ("npz", "an npz file")])
def test_a_format_that_is_not_read_is_told(tmp_path: Path, form: str, found: str) -> None:
    path = tmp_path / f"t.{form}"
    write_trajectory(stroke(), path, form)
    for read in (read_csv, read_measured):
        with pytest.raises(InputError, match=f"{found}.*; write it as CSV"):
            read(path)


def test_csv_is_what_write_csv_writes(tmp_path: Path) -> None:
    write_trajectory(stroke(), tmp_path / "a.csv")
    write_csv(stroke(), tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_the_format_is_named_or_told_by_the_ending() -> None:
    assert chosen_format(None, None) == "csv"
    assert chosen_format(None, Path("swim")) == "csv"
    for ending in (".dat", ".xlsx", ".bag", ".gz", ".5", ".csv~"):
        with pytest.raises(UnknownNameError, match=rf"--out: .* \.csv, \.parquet, .* is wanted, found \{ending}"):
            chosen_format(None, Path(f"swim{ending}"))
    assert chosen_format("csv", Path("swim.xlsx")) == "csv"
    assert chosen_format(None, Path("swim.Parquet")) == "parquet"
    assert chosen_format("tum", Path("swim.npz")) == "tum"
    with pytest.raises(UnknownNameError, match="one of csv, parquet, npz, tum is wanted, found 'hdf'"):
        chosen_format("hdf", None)


@pytest.mark.slow
def test_plan_run_and_gait_write_the_format_that_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command, file in (
        (["gait", "y-motion", "--format", "npz"], "y-motion.npz"),
        (["plan", "nearby", "--format", "parquet", "--plan-out", "plan.json"], "trajectory.parquet"),
        (["run", "plan.json", "--out", "again.tum"], "again.tum"),
    ):
        assert _run([*command, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["trajectory"] == file
    planned, played = pl.read_parquet("trajectory.parquet"), np.loadtxt("again.tum")
    assert np.array_equal(planned.select("t_s", "x_m", "y_m", "z_m").to_numpy(), played[:, :4])
    assert np.load("y-motion.npz")["gait"][0] == "y-motion"
    assert _run(["gait", "y-motion", "--format", "hdf"]) == 2
    assert "found 'hdf'" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "again.tum",
        "plan.json",
        "trajectory.parquet",
        "y-motion.npz",
    ]
