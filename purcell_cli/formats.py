"""Trajectories for other programs: parquet, npz and tum, beside CSV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.errors import UnknownNameError
from purcell_cli.export import COLUMNS, whole_file, write_csv
from purcell_cli.rotations import as_euler
from purcell_cli.trajectory import Trajectory

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
        UnknownNameError: No format has this name.
    """
    if name is None:
        ending = "" if path is None else path.suffix.removeprefix(".").lower()
        return ending if ending in FORMATS else "csv"
    if name not in FORMATS:
        raise UnknownNameError(f"--format: one of {', '.join(FORMATS)} is wanted, found {name!r}")
    return name


def columns(trajectory: Trajectory) -> dict[str, Any]:
    """Return all columns of a trajectory by name, in the order of the CSV file. Each of shape (n,)."""
    numbers = [trajectory.pose[:, :3, 3]]
    rotations = [trajectory.pose[:, :3, :3], trajectory.shape[:, 0], trajectory.shape[:, 1]]
    limbs = trajectory.limb_quaternion
    for rotation, quaternion in zip(rotations, [trajectory.base_quaternion, limbs[:, 0], limbs[:, 1]], strict=True):
        numbers += [quaternion, as_euler(rotation)]
    values = np.concatenate([*numbers, trajectory.rate_rad_s], axis=1) + 0.0  # no zero with a sign
    named = {"t_s": trajectory.time_s, "phase": trajectory.phase}
    named["gait"] = np.array(trajectory.gaits)[trajectory.gait]
    return named | {name: np.ascontiguousarray(values[:, k]) for k, name in enumerate(COLUMNS[3:])}


def write_trajectory(trajectory: Trajectory, path: Path | str, form: str = "csv") -> None:
    """Write a trajectory in one of `FORMATS`.

    Args:
        trajectory: The trajectory.
        path: The file; it is replaced only when all is written.
        form: The format's name.

    Raises:
        InputError: The file cannot be written.
        UnknownNameError: No format has this name.
    """
    form = chosen_format(form, None)
    if form == "csv":
        write_csv(trajectory, path)
        return
    table = columns(trajectory)
    with whole_file(path) as stream:
        if form == "npz":
            np.savez(stream, **table)
            return
        import polars as pl  # slow to import

        if form == "parquet":
            pl.DataFrame(table).write_parquet(stream)
        else:
            names = ("t_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
            pl.DataFrame({name: table[name] for name in names}).write_csv(stream, separator=" ", include_header=False)
