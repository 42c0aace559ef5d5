"""Trajectories as CSV files, written whole or not at all: the form that purcell reads back bit for bit."""

from __future__ import annotations

import csv
import math
import re
import signal
import threading
from pathlib import Path
from types import FrameType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import InputError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.paths import UnreadableError, is_folder, readable
from purcell_cli.files.place import shortened
from purcell_cli.files.plain_csv import read_rows, refuse_fork, without_polars, write_columns
from purcell_cli.files.used_files import note_input
from purcell_cli.geometry.rotations import INPUT_SLACK, Array, as_euler
from purcell_cli.motion.trajectory import Trajectory, continuous_quaternions
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.wording import counted

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


_ODD = re.compile("_")
"""What Python takes for part of a number, and nobody else."""

_LONGEST_HEADER = 65536
"""Bytes of the first line that are looked at: a good one has 315."""


def polars() -> Any:
    """Return the polars package: slow to import, and seven times faster at CSV than numpy.

    An interrupt waits until it is imported, which would end in a panic otherwise.

    Raises:
        ResultsError: The process is forked from one that has it.
    """
    refuse_fork()
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
        columns: dict[str, Any] = {"t_s": trajectory.time_s[part], "phase": trajectory.phase[part]}
        columns["gait"] = names[trajectory.gait[part]]
        columns |= {name: np.ascontiguousarray(numbers[:, k]) for k, name in enumerate(COLUMNS[3:])}
        write_table(columns, stream, include_header=low == 0)


def write_table(columns: dict[str, Any], stream: IO[bytes], separator: str = ",", *, include_header: bool) -> None:
    """Write columns of numbers and texts as CSV: by polars, or without it where it would wait for ever."""
    if without_polars():
        write_columns(columns, stream, separator, include_header=include_header)
    else:
        polars().DataFrame(columns).write_csv(stream, separator=separator, include_header=include_header)


def _fault(source: Path, reason: str) -> str:
    """Return the message about a file whose rows cannot be read: its first bad line, else the reason given."""
    with source.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        rows = csv.reader(stream)
        fault: str | None = None
        try:
            next(rows, None)
            fault = next(filter(None, map(_row_fault, rows)), None)
        except csv.Error as error:
            fault = f"wanted a row of finite numbers, found one that cannot be read ({error})"
        if fault is not None:
            return f"{source}:{rows.line_num}: {fault}"
    return f"{source}: wanted numbers in every row, found: {reason}"


def _row_fault(row: list[str]) -> str | None:
    """Return what is wrong with a row, None if nothing is."""
    if len(row) > len(COLUMNS):
        return f"wanted a row of finite numbers, found more fields than {len(COLUMNS)}"
    if len(row) < len(COLUMNS):
        return f"wanted a row of finite numbers, found {counted(len(row), 'field')} of {len(COLUMNS)}"
    for name, cell in zip(COLUMNS, row, strict=True):
        try:
            good = name == "gait" or math.isfinite(int(cell) if name == "phase" else float(_ODD.sub("x", cell)))
        except ValueError:
            if cell:
                return f"column '{name}': wanted numbers in every row, found '{shortened(cell)}'"
            good = False
        if not good:
            return "wanted a row of finite numbers, found one that is not"
    return None


def _check_header(source: Path, stream: IO[bytes]) -> None:
    """Refuse a first line that does not name the columns; a byte order mark and quotes may stand there."""
    try:
        text = stream.readline(_LONGEST_HEADER).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{source}:1: wanted a header line of UTF-8 text, found other bytes") from None
    try:
        header = next(csv.reader([text.rstrip("\r\n")]), []) or [""]
    except csv.Error:
        header = [text]
    if header == list(COLUMNS):
        return
    wrong = next(
        (k for k, (a, b) in enumerate(zip(header, COLUMNS, strict=False)) if a != b), min(len(header), len(COLUMNS))
    )
    found = f"'{shortened(header[wrong], 40)}'" if wrong < len(header) else "no more"
    wanted = repr(COLUMNS[wrong]) if wrong < len(COLUMNS) else "no more columns"
    hint = ""
    if header[1:] == list(COLUMNS):
        hint = " (a column of row names; R leaves it out with row.names = FALSE)"
    elif header and header[0].startswith((f"{COLUMNS[0]};", f"{COLUMNS[0]}\t")):
        hint = f" (columns are parted by commas, not by {header[0][len(COLUMNS[0])]!r})"
    raise InputError(f"{source}:1: column {wrong + 1}: wanted {wanted}, found {found}{hint}")


def _rows(source: Path) -> tuple[Array, NDArray[np.str_]]:
    """Return the numbers of a file's rows, shape (n, 33), and the gaits."""
    pl = polars()
    types = dict.fromkeys(COLUMNS, pl.Float64) | {"phase": pl.Int64, "gait": pl.String}
    try:
        with source.open("rb") as stream:  # polars takes a path for a pattern, or for an address
            _check_header(source, stream)
            stream.seek(0)
            frame = pl.read_csv(stream, schema=types)
    except (pl.exceptions.PolarsError, OSError) as error:
        reason = str(getattr(error, "strerror", None) or error).splitlines() or ["no reason"]
        raise InputError(_fault(source, reason[0])) from None
    while frame.height and all(value is None for value in frame.row(-1)):  # empty lines at the end
        frame = frame.head(-1)
    numbers = frame.select(c for c in COLUMNS if c != "gait").to_numpy()
    return numbers, frame["gait"].fill_null("").to_numpy().astype(str)


def _rows_without_polars(source: Path) -> tuple[Array, NDArray[np.str_]]:
    """Return the same in a process that cannot use polars."""
    with source.open("rb") as stream:
        _check_header(source, stream)
    try:
        with source.open(encoding="utf-8-sig", newline="") as text:
            text.readline()
            numbers, gaits = read_rows(text, COLUMNS)
    except (ValueError, csv.Error, OSError) as error:
        raise InputError(_fault(source, str(error))) from None
    return numbers, np.array(gaits, dtype=str)


def read_csv(path: Path | str) -> Table:
    """Read a trajectory file.

    Raises:
        InputError: The file is missing, or its header or a row is not that of a trajectory.
    """
    source = Path(path)
    try:
        size = readable(source).st_size
    except UnreadableError as error:
        found = "a folder" if is_folder(source) else error
        raise InputError(f"{source}: wanted a trajectory file, found {found}") from None
    if size > _LARGEST_BYTES:
        raise InputError(f"{source}: wanted at most {_LARGEST_BYTES >> 30} GiB, found more")
    note_input(source)
    numbers, gaits = (_rows_without_polars if without_polars() else _rows)(source)
    bad = np.flatnonzero(~np.all(np.isfinite(numbers), axis=1))
    if len(bad):
        raise InputError(_fault(source, f"others in row {int(bad[0]) + 1}"))
    if not len(numbers):
        raise InputError(f"{source}:2: wanted a row of finite numbers, found no row")
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
        gaits,
        values[:, :3],
        values[:, 3:7],
        np.stack([values[:, 10:14], values[:, 17:21]], axis=1),
        np.stack([values[:, 7:10], values[:, 14:17], values[:, 21:24]], axis=1),
        values[:, 24:30],
    )
