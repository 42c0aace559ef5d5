"""Measured trajectories read from CSV files: columns by name, in any order, those that a measurement has.

Each link's orientation is read from its quaternion, or from its Euler angles where there is no quaternion. Rows may be
missing; a row whose cells for the base are all empty says that the base was not seen. Other columns are passed over.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from purcell_cli.errors import InputError
from purcell_cli.files.place import shortened
from purcell_cli.files.trajectory_reader import other_bytes, other_separator
from purcell_cli.files.used_files import note_large_input
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import MEASURED_SLACK, Array, from_euler, from_quaternion
from purcell_cli.motion.measured_trajectory import MeasuredTrajectory

_POSITION = ("x_m", "y_m", "z_m")
_ORIENTATIONS = {
    link: (
        tuple(f"{prefix}{name}" for name in ("qw", "qx", "qy", "qz")),
        tuple(f"{prefix}{name}_rad" for name in ("psi", "theta", "phi")),
    )
    for link, prefix in (("base", ""), ("limb 1", "l1_"), ("limb 2", "l2_"))
}
"""The columns of each link's orientation: a quaternion, or Euler angles."""

_LARGEST_BYTES = 1 << 30
"""Bytes of a file at most: two million rows, hours at 200 rows a second."""
_BEGIN_BYTES = 4
"""Bytes by which a file that is no text is known."""
_FAR_M = 1e6
"""A base farther from the origin was not measured in metres."""


def read_measured(path: Path | str) -> MeasuredTrajectory:
    """Read a measured trajectory.

    Raises:
        InputError: The file is missing, lacks a column, or has a row that no swimmer can be in; the row is told.
    """
    source = Path(path)
    note_large_input(source, "a measured trajectory's file", _LARGEST_BYTES)
    line = 1
    try:
        with source.open(encoding="utf-8-sig", newline="") as stream:
            rows = csv.reader(stream)
            columns = _columns(source, next(rows, []))
            numbers, lines = [], []
            for row in rows:
                line = rows.line_num
                if not any(cell.strip() for cell in row):
                    continue
                numbers.append(_numbers(f"{source}:{line}", row, columns))
                lines.append(line)
    except UnicodeDecodeError:
        with source.open("rb") as begun:
            found = other_bytes(begun.read(_BEGIN_BYTES))
        raise InputError(f"{source}:{line + 1}: wanted UTF-8 text, found {found}") from None
    except (csv.Error, OSError) as error:
        raise InputError(f"{source}:{line + 1}: wanted rows of numbers, found {error}") from None
    if not numbers:
        raise InputError(f"{source}:2: wanted rows of numbers, found none")
    table = np.array(numbers)
    return _measured(source, {name: table[:, k] for k, name in enumerate(columns)}, lines)


def _columns(source: Path, header: Sequence[str]) -> dict[str, int]:
    """Return where the columns that are read stand."""
    if header and (hint := other_separator(header[0])):
        raise InputError(f"{source}:1: wanted a header line, found '{shortened(header[0], 40)}'{hint}")
    places: dict[str, int] = {}
    for k, name in enumerate(cell.strip() for cell in header):
        if name and name in places:
            raise InputError(f"{source}:1: wanted each column once, found '{shortened(name, 40)}' twice")
        places[name] = k
    wanted = ["t_s", *_POSITION]
    for link, (quaternion, euler) in _ORIENTATIONS.items():
        chosen = next((form for form in (quaternion, euler) if all(name in places for name in form)), None)
        if chosen is None:
            names, others = ", ".join(quaternion), ", ".join(euler)
            missing = ", ".join(name for name in quaternion if name not in places)
            raise InputError(
                f"{source}:1: wanted columns for the {link}'s orientation ({names}; or {others}), found no {missing}"
            )
        wanted += chosen
    missing = ", ".join(name for name in wanted if name not in places)
    if missing:
        raise InputError(f"{source}:1: wanted the columns {', '.join(('t_s', *_POSITION))}, found no {missing}")
    return {name: places[name] for name in wanted}


def _of_base(name: str) -> bool:
    return name in _POSITION or name in _ORIENTATIONS["base"][0] or name in _ORIENTATIONS["base"][1]


def _numbers(where: str, row: Sequence[str], columns: Mapping[str, int]) -> list[float]:
    """Return the numbers of a row; those of a base that was not seen are no numbers."""
    cells = {name: row[k].strip() if k < len(row) else "" for name, k in columns.items()}
    unseen = not any(cell for name, cell in cells.items() if _of_base(name))
    out = []
    for name, cell in cells.items():
        if unseen and _of_base(name):
            out.append(math.nan)
            continue
        try:
            value = float(cell.replace("_", "x"))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{where}: column '{name}': wanted a finite number, found '{shortened(cell)}'")
        out.append(value)
    return out


def _measured(source: Path, values: Mapping[str, Array], lines: Sequence[int]) -> MeasuredTrajectory:
    """Return what the columns say, checked row by row."""
    time = values["t_s"]
    back = np.flatnonzero(np.diff(time) < 0.0)
    if len(back):
        k = int(back[0])
        wanted, found = float(time[k]), float(time[k + 1])
        raise InputError(f"{source}:{lines[k + 1]}: t_s: wanted a time of at least {wanted!r}, found {found!r}")
    seen = np.isfinite(values["x_m"])
    position = np.stack([np.where(seen, values[name], 0.0) for name in _POSITION], axis=1)
    far = np.flatnonzero(np.max(np.abs(position), axis=1) > _FAR_M)
    if len(far):
        k = int(far[0])
        found = float(np.max(np.abs(position[k])))
        raise InputError(f"{source}:{lines[k]}: x_m to z_m: wanted at most {_FAR_M:g} m, found {found:g}")
    base, one, two = (_rotations(source, values, link, seen, lines) for link in _ORIENTATIONS)
    return MeasuredTrajectory(time, se3.pose(base, position), np.stack([one, two], axis=1), seen, str(source))


def _rotations(source: Path, values: Mapping[str, Array], link: str, seen: Array, lines: Sequence[int]) -> Array:
    """Return a link's orientations. Shape (n, 3, 3)."""
    quaternion, euler = _ORIENTATIONS[link]
    if quaternion[0] not in values:
        angles = np.stack([values[name] for name in euler], axis=1)
        return from_euler(np.where(np.isfinite(angles), angles, 0.0))
    q = np.stack([values[name] for name in quaternion], axis=1)
    if link == "base":
        q[~seen.astype(bool)] = (1.0, 0.0, 0.0, 0.0)
    length = np.linalg.norm(q, axis=1)
    off = np.flatnonzero(~(np.abs(length - 1.0) <= MEASURED_SLACK))
    if len(off):
        k = int(off[0])
        what = f"{quaternion[0]} to {quaternion[3]}: wanted a quaternion of length 1 for the {link}"
        raise InputError(f"{source}:{lines[k]}: {what}, found length {length[k]:.9g}")
    return from_quaternion(q / length[:, None])
