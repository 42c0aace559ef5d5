"""Trajectories as CSV files, written whole or not at all: the form that purcell reads back bit for bit."""

from __future__ import annotations

import io
from pathlib import Path
from typing import IO

import numpy as np
import orjson

from purcell_cli.errors import refuse_types
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.motion.trajectory import Trajectory, continuous_quaternions

_LIMB = ("qw", "qx", "qy", "qz", "psi_rad", "theta_rad", "phi_rad")
COLUMNS = (
    *("t_s", "phase", "gait", "x_m", "y_m", "z_m"),
    *_LIMB,
    *(f"l1_{c}" for c in _LIMB),
    *(f"l2_{c}" for c in _LIMB),
    *(f"w{limb}{axis}_rad_s" for limb in (1, 2) for axis in "xyz"),
)
"""The columns of a trajectory file, in order."""

_ROWS_AT_ONCE = 8192
"""Rows that are made into text together: 7 MB of it, however long the trajectory is."""


def write_csv(trajectory: Trajectory, path: Path | str) -> None:
    """Write a trajectory as CSV at full double precision.

    Args:
        trajectory: The trajectory.
        path: The file; it is replaced only when all is written.

    Raises:
        InputError: The file cannot be written.
        ParameterError: What is no trajectory.
    """
    refuse_types(trajectory=(trajectory, Trajectory))
    with whole_file(path) as stream:
        write_rows(trajectory, stream)


def write_rows(trajectory: Trajectory, stream: IO[bytes]) -> None:
    """Write a trajectory as CSV into an open file, as `write_csv` does."""
    stream.write(f"{','.join(COLUMNS)}\n".encode())
    before: list[Array | None] = [None, None, None]
    first, phase = distinct(trajectory.phase)
    gaits = [_quoted(name) for name in trajectory.gaits]
    words = [f",{number},{name},".encode() for number in trajectory.phase[first].tolist() for name in gaits]
    which = phase * len(gaits) + trajectory.gait
    for low in range(0, len(trajectory), _ROWS_AT_ONCE):
        part = slice(low, low + _ROWS_AT_ONCE)
        blocks: list[Array] = [trajectory.time_s[part, None], trajectory.pose[part, :3, 3]]
        for k, rotation in enumerate((trajectory.pose[part, :3, :3], *np.moveaxis(trajectory.shape[part], 1, 0))):
            quaternion = continuous_quaternions(rotation, before[k])
            before[k] = quaternion[-1]
            blocks += [quaternion, as_euler(rotation)]
        numbers = np.concatenate([*blocks, trajectory.rate_rad_s[part]], axis=1) + 0.0  # no zero with a sign
        stream.write(_as_text(numbers, [words[k] for k in which[part].tolist()]))


def goes_on(path: Path | str, trajectory: Trajectory) -> bool:
    """Return whether a file has all rows of a trajectory but the last, in which joints rest, and more after them."""
    made = io.BytesIO()
    write_rows(trajectory, made)
    text = made.getvalue()
    rows = text[: text.rfind(b"\n", 0, -1) + 1]
    try:
        with Path(path).open("rb") as stream:
            return Path(path).stat().st_size > len(text) and stream.read(len(rows)) == rows
    except OSError:
        return False


def _as_text(numbers: Array, words: list[bytes]) -> bytes:
    """Return rows of numbers as lines, with words after the first number of each.

    The JSON package writes arrays with the fewest digits that read back as the same doubles, and is imported in a
    thirtieth of the time that the data frame package takes.
    """
    rows = orjson.dumps(numbers, option=orjson.OPT_SERIALIZE_NUMPY)[2:-2].split(b"],[")
    parts = (row.partition(b",") for row in rows)
    return b"".join(b"%b%b%b\n" % (first, word, rest) for (first, _, rest), word in zip(parts, words, strict=True))


def _quoted(name: str) -> str:
    """Return a name as a field of a CSV file."""
    special = not name or any(mark in name for mark in ',"\n\r')
    return '"{}"'.format(name.replace('"', '""')) if special else name
