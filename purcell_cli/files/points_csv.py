"""Points in CSV files: curves and centrelines, a point a row and perhaps more of it in further columns."""

from __future__ import annotations

import csv
import io
import math
import re

from purcell_cli.errors import InputError
from purcell_cli.files.place import shortened
from purcell_cli.files.yaml_source import MOST_BYTES

POINT = ("x_m", "y_m", "z_m")
"""The columns that every file of points has."""
MOST_POINTS = 20_000
"""Points of a file at most: as many as one of the largest size has."""
_FARTHEST_M = 1e15
"""Numbers go no farther than this, as in configurations [m]."""
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)


def read_points(data: bytes, name: str, more: tuple[str, ...]) -> tuple[list[list[float]], list[int]]:
    """Return the numbers of each row, three or with those of further columns, and the line that each stands on.

    Args:
        data: The file's bytes.
        name: The file's name, for messages.
        more: The columns that may follow the point's.

    Raises:
        InputError: No text, another header, a row that is not as many finite numbers, too few rows or too many.
    """
    if len(data) > MOST_BYTES:
        raise InputError(f"{name}:1: wanted at most {MOST_BYTES} bytes, found more")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"{name}:{line}: wanted UTF-8, found the byte 0x{data[error.start]:02x}") from error
    reader = csv.reader(io.StringIO(text, newline=""))
    rows: list[list[float]] = []
    lines: list[int] = []
    columns: tuple[str, ...] | None = None
    try:
        for row in reader:
            if not any(cell.strip() for cell in row) and columns is not None:
                continue
            if columns is None:
                columns = _columns(tuple(cell.strip() for cell in row), name, more)
                continue
            rows.append(_numbers(row, columns, f"{name}:{reader.line_num}"))
            lines.append(reader.line_num)
    except csv.Error as error:
        raise InputError(f"{name}:{reader.line_num}: wanted a row of numbers, found a fault ({error})") from error
    if columns is None:
        raise InputError(f"{name}:1: wanted the header {','.join(POINT)}, found an empty file")
    if len(rows) < 2:
        found = "none" if not rows else "one"
        raise InputError(f"{name}:{lines[-1] if lines else 1}: wanted two points or more, found {found}")
    if len(rows) > MOST_POINTS:
        raise InputError(f"{name}:{lines[MOST_POINTS]}: wanted at most {MOST_POINTS} points, found more")
    return rows, lines


def _columns(header: tuple[str, ...], name: str, more: tuple[str, ...]) -> tuple[str, ...]:
    if header in (POINT, POINT + more):
        return header
    wanted = f"the header {','.join(POINT)} or {','.join(POINT + more)}"
    raise InputError(f"{name}:1: wanted {wanted}, found '{shortened(','.join(header))}'")


def _numbers(row: list[str], columns: tuple[str, ...], place: str) -> list[float]:
    if len(row) != len(columns):
        raise InputError(f"{place}: wanted {len(columns)} numbers, found {len(row)}")
    out = []
    for column, cell in zip(columns, row, strict=True):
        value = float(cell) if _NUMBER.fullmatch(cell) else math.nan
        if not abs(value) <= _FARTHEST_M:
            wanted = f"a finite number of at most {_FARTHEST_M:g}"
            raise InputError(f"{place}: {column}: wanted {wanted}, found '{shortened(cell)}'")
        out.append(value)
    return out
