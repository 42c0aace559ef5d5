"""Trajectories read from CSV files, whole or part by part, checked row by row."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

import numpy as np

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.place import shortened
from purcell_cli.files.polars_package import polars
from purcell_cli.files.trajectory_csv import COLUMNS
from purcell_cli.files.used_files import note_large_input
from purcell_cli.geometry.rotations import INPUT_SLACK, Array
from purcell_cli.motion.memory import DEFAULT_GB, budget_gb
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.processes import outside_forks
from purcell_cli.wording import counted

Names = np.ndarray[tuple[int, ...], np.dtype[np.str_]]
"""Names, one a row."""

_PART_BYTES = 32 << 20
"""Bytes that are read together: some 60,000 rows, whose numbers take 15 MB."""

_LARGEST_BYTES = 4 << 30
"""Bytes of a trajectory that is read at most: they are some ten million rows, whose numbers take 2.5 GB of memory."""

_MEMORY_A_BYTE = 2.2
"""Memory that a trajectory read whole, and what is made of it, takes for each byte of its file: simulations, pages and
plots of 230,000 and 460,000 rows took 1.7 to 2.0."""

_ODD = re.compile("_")
"""What Python takes for part of a number, and nobody else."""

_MARKS = {b"PAR1": "a Parquet file", b"PK": "an npz file or a workbook", b"\x1f\x8b": "a compressed file"}
"""How files begin that hold trajectories too, and are not read: their first bytes."""

_LONGEST_HEADER = 65536
"""Bytes of the first line that are looked at: a good one has 315."""


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
            return f"column '{name}': wanted finite numbers in every row, found {shortened(cell) or 'an empty cell'}"
    return None


def other_bytes(begun: bytes) -> str:
    """Return what the first bytes of a file are that is no text, in words."""
    form = next((name for mark, name in _MARKS.items() if begun.startswith(mark)), "")
    return f"{form}; write it as CSV" if form else "other bytes"


def other_separator(first: str) -> str:
    """Return that columns are parted by another sign than a comma, by the first cell of a header; else nothing."""
    sign = next((sign for sign in (";", "\t") if sign in first), None)
    return f" (columns are parted by commas, not by {sign!r})" if sign else ""


def _check_header(source: Path, stream: IO[bytes]) -> None:
    """Refuse a first line that does not name the columns; a byte order mark and quotes may stand there."""
    try:
        line = stream.readline(_LONGEST_HEADER)
        text = line.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{source}:1: wanted a header line of UTF-8 text, found {other_bytes(line)}") from None
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
    elif other := other_separator(header[0]):
        hint = other
    elif text.startswith("{"):
        hint = " (purcell run makes the trajectory of a plan document)"
    raise InputError(f"{source}:1: column {wrong + 1}: wanted {wanted}, found {found}{hint}")


def read_csv(path: Path | str, max_memory_gb: float = DEFAULT_GB, memory_a_byte: float = _MEMORY_A_BYTE) -> Table:
    """Read a trajectory file.

    Args:
        path: The file.
        max_memory_gb: The memory that its rows and what is made of them may take; where it is the default, no more
            than half of what is free [GB].
        memory_a_byte: How much that is for each byte of the file.

    Raises:
        InputError: The file is missing, or its header or a row is not that of a trajectory.
        ParameterError: It is too large for the memory.
    """
    found_gb, wanted_gb = budget_gb(max_memory_gb), 1e-9 * memory_a_byte * _size(Path(path))
    if wanted_gb > found_gb:
        raise ParameterError(
            f"max-memory: a budget of at least {wanted_gb:.2g} GB for all rows of {path} is wanted, found "
            f"{found_gb:.2g} GB"
        )
    parts = list(read_parts(path))
    if len(parts) == 1:
        return parts[0]
    names = [field.name for field in dataclasses.fields(Table)]
    later = [[getattr(part, name)[1:] for part in parts[1:]] for name in names]
    return Table(*(np.concatenate([getattr(parts[0], n), *rest]) for n, rest in zip(names, later, strict=True)))


def _size(source: Path) -> int:
    return note_large_input(source, "a trajectory file", _LARGEST_BYTES)


def read_parts(path: Path | str, progress: Callable[[int, int], None] = lambda _done, _of: None) -> Iterator[Table]:
    """Read a trajectory file in parts, each of which begins with the last row of the one before.

    Args:
        path: The file.
        progress: Is told how many bytes of how many were read, whenever a part is used up.

    Raises:
        InputError: As for `read_csv`; what is wrong in a part is found when it is read.
    """
    source = Path(path)
    size = _size(source)
    before: tuple[Array, Names] | None = None
    row = 0
    try:
        with source.open("rb") as stream:
            _check_header(source, stream)
            stream.seek(0)
            header = True
            while block := stream.read(_PART_BYTES):
                block += stream.readline()
                numbers, gaits, fault = _parsed(block, header, stream.peek(1) == b"")
                header = False
                if fault:
                    raise InputError(_fault(source, fault))
                if before is not None:
                    numbers, gaits = (np.concatenate([a, b]) for a, b in zip(before, (numbers, gaits), strict=True))
                if not len(numbers):
                    continue
                yield _table(source, numbers, gaits, row)
                progress(stream.tell(), size)
                before, row = (numbers[-1:], gaits[-1:]), row + len(numbers) - 1
    except OSError as error:
        raise InputError(_fault(source, error.strerror or str(error))) from None
    if before is None:
        raise InputError(f"{source}:2: wanted a row of finite numbers, found no row")


@outside_forks
def _parsed(block: bytes, header: bool, last: bool) -> tuple[Array, Names, str]:
    """Return the numbers and the gaits of some lines, empty ones at the end left out, and why it cannot be done."""
    pl = polars()
    types = dict.fromkeys(COLUMNS, pl.Float64) | {"phase": pl.Int64, "gait": pl.String}
    try:  # polars takes a path for a pattern, or for an address
        frame = pl.read_csv(io.BytesIO(block), schema=types, has_header=header)
    except pl.exceptions.PolarsError as error:
        return (
            np.empty((0, len(COLUMNS) - 1)),
            np.empty(0, dtype=np.str_),
            (str(error).splitlines() or ["no reason"])[0],
        )
    while last and frame.height and all(value is None for value in frame.row(-1)):
        frame = frame.head(-1)
    numbers = frame.select(c for c in COLUMNS if c != "gait").to_numpy()
    return numbers, frame["gait"].fill_null("").to_numpy().astype(str), ""


def _table(source: Path, numbers: Array, gaits: Names, row: int) -> Table:
    """Return some rows, the first of which has a number, and check them."""
    bad = np.flatnonzero(~np.all(np.isfinite(numbers), axis=1))
    if len(bad):
        raise InputError(_fault(source, f"others in row {row + int(bad[0]) + 1}"))
    values = numbers[:, 2:]
    late = np.flatnonzero(np.diff(numbers[:, 0]) < 0)
    if len(late):
        k = int(late[0])
        before, after = float(numbers[k, 0]), float(numbers[k + 1, 0])
        raise InputError(f"{source}:{row + k + 3}: t_s: wanted a time of at least {before!r}, found {after!r}")
    for low, name in ((3, "qw to qz"), (10, "l1_qw to l1_qz"), (17, "l2_qw to l2_qz")):
        length = np.linalg.norm(values[:, low : low + 4], axis=1)
        bad = np.flatnonzero(np.abs(length - 1.0) > INPUT_SLACK)
        if len(bad):
            k = int(bad[0])
            where = f"{source}:{row + k + 2}: {name}"
            raise InputError(f"{where}: wanted a quaternion of length 1, found length {length[k]:.9g}")
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
