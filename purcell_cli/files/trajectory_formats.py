"""Trajectories for other programs: parquet, npz and tum, beside CSV."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.errors import UnknownNameError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.polars_package import polars
from purcell_cli.files.swimmer_file import swimmer_written
from purcell_cli.files.trajectory_csv import COLUMNS, write_csv
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory, as_table
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.processes import outside_forks
from purcell_cli.wording import nearest_hint

FORMATS = {
    "csv": "text at full double precision; the one that purcell reads",
    "parquet": "the same columns, for data frames",
    "npz": "the same columns as numpy arrays by name",
    "tum": "time, position and quaternion x, y, z, w of the base alone, for tools that compare trajectories",
}
"""The formats of a trajectory file, and what each is for."""


def chosen_format(name: str | None, path: Path | None) -> str:
    """Return the format that is asked for: by its name, else by the file's ending, else csv.

    Raises:
        UnknownNameError: No format has this name, or this ending.
    """
    if name is None:
        ending = "" if path is None else path.suffix.removeprefix(".").lower()
        if ending and ending not in FORMATS:
            known = ", ".join(f".{form}" for form in FORMATS)
            raise UnknownNameError(f"--out: a name that ends in {known} is wanted, found .{ending} in {path}")
        return ending or "csv"
    if name not in FORMATS:
        known = f"{', '.join(FORMATS)}{nearest_hint(name, FORMATS)}"
        raise UnknownNameError(f"--format: one of {known} is wanted, found {name!r}")
    return name


def columns(table: Table) -> dict[str, Any]:
    """Return all columns of a trajectory by name, in the order of the CSV file. Each of shape (n,)."""
    quaternions = [table.base, table.limbs[:, 0], table.limbs[:, 1]]
    turns = [part for k, q in enumerate(quaternions) for part in (q, table.euler_rad[:, k])]
    values = np.concatenate([table.position_m, *turns, table.rate_rad_s], axis=1) + 0.0  # no zero with a sign
    named = {"t_s": table.time_s, "phase": table.phase.astype(np.int64), "gait": table.gait}
    return named | {name: np.ascontiguousarray(values[:, k]) for k, name in enumerate(COLUMNS[3:])}


@outside_forks
def write_trajectory(
    trajectory: Trajectory, path: Path | str, form: str = "csv", swimmer: Swimmer | None = None
) -> None:
    """Write a trajectory in one of `FORMATS`.

    Args:
        trajectory: The trajectory.
        path: The file; it is replaced only when all is written.
        form: The format's name.
        swimmer: Who swims it; parquet and npz files name the swimmer, in metadata and an entry "swimmer", as JSON.

    Raises:
        InputError: The file cannot be written.
        UnknownNameError: No format has this name.
    """
    form = chosen_format(form, None)
    if form == "csv":
        write_csv(trajectory, path)
        return
    named = columns(as_table(trajectory))
    about = None if swimmer is None else json.dumps(swimmer_written(swimmer))
    with whole_file(path) as stream:
        if form == "npz":
            np.savez(stream, **(named if about is None else {**named, "swimmer": np.array(about)}))
            return
        pl = polars()
        if form == "parquet":
            pl.DataFrame(named).write_parquet(stream, metadata=None if about is None else {"swimmer": about})
        else:
            names = ("t_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
            pl.DataFrame({name: named[name] for name in names}).write_csv(stream, separator=" ", include_header=False)
