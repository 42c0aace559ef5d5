"""Trajectories as CSV files, written whole or not at all: the form that purcell reads back bit for bit."""

from __future__ import annotations

import io
import signal
import threading
from collections.abc import Mapping
from pathlib import Path
from types import FrameType
from typing import IO, Any

import numpy as np

from purcell_cli.files.atomic_file import whole_file
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.motion.trajectory import Trajectory, continuous_quaternions
from purcell_cli.processes import outside_forks

_LIMB = ("qw", "qx", "qy", "qz", "psi_rad", "theta_rad", "phi_rad")
COLUMNS = (
    *("t_s", "phase", "gait", "x_m", "y_m", "z_m"),
    *_LIMB,
    *(f"l1_{c}" for c in _LIMB),
    *(f"l2_{c}" for c in _LIMB),
    *(f"w{limb}{axis}_rad_s" for limb in (1, 2) for axis in "xyz"),
)
"""The columns of a trajectory file, in order."""

_ROWS_AT_ONCE = 65536
"""Rows that are made into text together: 15 MB of numbers, however long the trajectory is."""


def polars() -> Any:
    """Return the polars package: slow to import, and seven times faster at CSV than numpy.

    An interrupt waits until it is imported, which would end in a panic otherwise.
    """
    held: list[tuple[int, FrameType | None]] = []
    before = signal.getsignal(signal.SIGINT)
    ours = callable(before) and threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, lambda number, frame: held.append((number, frame)))
    try:
        import polars as pl
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)
    if held and callable(before):
        before(*held[0])
    return pl


def write_csv(trajectory: Trajectory, path: Path | str) -> None:
    """Write a trajectory as CSV at full double precision.

    Args:
        trajectory: The trajectory.
        path: The file; it is replaced only when all is written.

    Raises:
        InputError: The file cannot be written.
    """
    with whole_file(path) as stream:
        write_rows(trajectory, stream)


def write_rows(trajectory: Trajectory, stream: IO[bytes]) -> None:
    """Write a trajectory as CSV into an open file, as `write_csv` does."""
    names = np.array(trajectory.gaits)
    before: list[Array | None] = [None, None, None]
    for low in range(0, len(trajectory), _ROWS_AT_ONCE):
        part = slice(low, low + _ROWS_AT_ONCE)
        blocks: list[Array] = [trajectory.pose[part, :3, 3]]
        for k, rotation in enumerate((trajectory.pose[part, :3, :3], *np.moveaxis(trajectory.shape[part], 1, 0))):
            quaternion = continuous_quaternions(rotation, before[k])
            before[k] = quaternion[-1]
            blocks += [quaternion, as_euler(rotation)]
        numbers = np.concatenate([*blocks, trajectory.rate_rad_s[part]], axis=1) + 0.0
        columns = {"t_s": trajectory.time_s[part], "phase": trajectory.phase[part]}
        named = {
            **columns,
            "gait": names[trajectory.gait[part]],
            **{name: np.ascontiguousarray(numbers[:, k]) for k, name in enumerate(COLUMNS[3:])},
        }
        stream.write(_as_text(named, low == 0))


@outside_forks
def _as_text(columns: Mapping[str, Array], header: bool) -> bytes:
    """Return rows as text, columns by name."""
    text = io.BytesIO()
    polars().DataFrame(columns).write_csv(text, include_header=header)
    return text.getvalue()
