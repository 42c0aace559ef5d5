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

from purcell_cli.errors import InputError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.geometry.rotations import INPUT_SLACK, Array, as_euler
from purcell_cli.motion.trajectory import Trajectory, continuous_quaternions
from purcell_cli.motion.trajectory_table import Table
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

_LARGEST_BYTES = 4 << 30
"""Bytes of a trajectory that is read at most: they are some ten million rows, whose numbers take 2.5 GB of memory."""


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


def _unreadable(source: Path, reason: str) -> str:
    """Return the message about a file whose rows cannot be read."""
    with source.open(encoding="utf-8", errors="replace") as stream:
        for line, text in enumerate(stream, start=1):
            if text.count(",") < len(COLUMNS) - 1:
                return f"{source}:{line}: wanted a row of finite numbers, found one that is not"
    return f"{source}: wanted numbers in every row, found: {reason}"


@outside_forks
def read_csv(path: Path | str) -> Table:
    """Read a trajectory file.

    Raises:
        InputError: The file is missing, or its header or a row is not that of a trajectory.
    """
    pl = polars()
    source = Path(path)
    if not source.is_file():
        raise InputError(f"{source}: wanted a trajectory file, found {'a folder' if source.is_dir() else 'none'}")
    if source.stat().st_size > _LARGEST_BYTES:
        raise InputError(f"{source}: wanted at most {_LARGEST_BYTES >> 30} GiB, found more")
    try:
        with source.open("rb") as stream:
            header = stream.readline(65536).decode("utf-8").rstrip("\r\n").split(",")
    except UnicodeDecodeError:
        raise InputError(f"{source}:1: wanted a header line of UTF-8 text, found other bytes") from None
    if header != list(COLUMNS):
        wrong = next(
            (k for k, (a, b) in enumerate(zip(header, COLUMNS, strict=False)) if a != b), min(len(header), len(COLUMNS))
        )
        found = repr(header[wrong][:40]) if wrong < len(header) else "no more"
        wanted = repr(COLUMNS[wrong]) if wrong < len(COLUMNS) else "no more columns"
        raise InputError(f"{source}:1: column {wrong + 1}: wanted {wanted}, found {found}")
    types = dict.fromkeys(COLUMNS, pl.Float64) | {"phase": pl.Int64, "gait": pl.String}
    try:
        frame = pl.read_csv(source, schema=types)
    except (pl.exceptions.PolarsError, OSError) as error:
        raise InputError(_unreadable(source, str(error).splitlines()[0])) from None
    numbers = frame.select(c for c in COLUMNS if c != "gait").to_numpy()
    bad = np.flatnonzero(~np.all(np.isfinite(numbers), axis=1))
    if not len(numbers) or len(bad):
        line = int(bad[0]) + 2 if len(bad) else 2
        raise InputError(
            f"{source}:{line}: wanted a row of finite numbers, found {'one that is not' if len(bad) else 'no row'}"
        )
    values = numbers[:, 2:]
    late = np.flatnonzero(np.diff(numbers[:, 0]) < 0)
    if len(late):
        k = int(late[0])
        before, after = float(numbers[k, 0]), float(numbers[k + 1, 0])
        raise InputError(f"{source}:{k + 3}: t_s: wanted a time of at least {before!r}, found {after!r}")
    for low, name in ((3, "qw to qz"), (10, "l1_qw to l1_qz"), (17, "l2_qw to l2_qz")):
        length = np.linalg.norm(values[:, low : low + 4], axis=1)
        bad = np.flatnonzero(np.abs(length - 1.0) > INPUT_SLACK)
        if len(bad):
            k = int(bad[0])
            raise InputError(f"{source}:{k + 2}: {name}: wanted a quaternion of length 1, found length {length[k]:.9g}")
    return Table(
        numbers[:, 0],
        numbers[:, 1],
        frame["gait"].fill_null("").to_numpy().astype(str),
        values[:, :3],
        values[:, 3:7],
        np.stack([values[:, 10:14], values[:, 17:21]], axis=1),
        np.stack([values[:, 7:10], values[:, 14:17], values[:, 21:24]], axis=1),
        values[:, 24:30],
    )
