"""Curves as CSV files: a point a row, and the base's orientation there if that is wanted."""

from __future__ import annotations

import csv
import io
import math
import re
import warnings
from pathlib import Path

import numpy as np

from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.place import shortened
from purcell_cli.files.yaml_source import MOST_BYTES, file_bytes
from purcell_cli.geometry.rotations import INPUT_SLACK, MEASURED_SLACK, from_quaternion, quaternion_error
from purcell_cli.motion.curve import Curve, CurveError

POINT = ("x_m", "y_m", "z_m")
"""The columns that every curve has."""
QUATERNION = ("qw", "qx", "qy", "qz")
"""The columns of a curve with orientations, besides."""
_FARTHEST_M = 1e15
"""Coordinates go no farther than this, as in configurations [m]."""
_MOST_POINTS = 20_000
"""Points of a curve at most: as many as a file of the largest size has."""
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)


def load_curve(path: Path | str) -> Curve:
    """Return the curve of a CSV file with the columns x_m, y_m, z_m and, if wanted, qw, qx, qy, qz.

    Raises:
        InputError: The file is missing, its header or a row is not a curve's, or its points are no curve.
    """
    try:
        data = file_bytes(Path(path))
    except UnreadableError as error:
        raise InputError(f"{shortened(str(path), 1000)}: wanted a readable file, found {error}") from error
    return curve_of(data, str(path))


def curve_of(data: bytes, name: str) -> Curve:
    """Return the curve that the bytes of a CSV file say.

    Args:
        data: The bytes.
        name: The file's name, for messages.

    Raises:
        InputError: See `load_curve`.
    """
    columns, rows, lines = _rows(data, name)
    numbers = np.array(rows, dtype=np.float64).reshape(len(rows), len(columns))
    orientation = None
    if len(columns) > len(POINT):
        quaternions = numbers[:, 3:]
        off = quaternion_error(quaternions)
        bad = np.flatnonzero(~(off <= MEASURED_SLACK))
        if len(bad):
            k = int(bad[0])
            raise InputError(f"{name}:{lines[k]}: qw to qz: wanted a unit quaternion, found one off by {off[k]:.3g}")
        if float(np.max(off)) > INPUT_SLACK:
            k = int(np.argmax(off))
            text = f"{name}:{lines[k]}: qw to qz: normalised, since it is off by {off[k]:.2g}"
            warnings.warn(text, PurcellWarning, stacklevel=2)
        orientation = from_quaternion(quaternions, MEASURED_SLACK)
    try:
        return Curve(numbers[:, :3], orientation)
    except CurveError as error:
        raise InputError(f"{name}:{lines[error.point]}: wanted {error.wanted}, found {error.found}") from error


def _rows(data: bytes, name: str) -> tuple[tuple[str, ...], list[list[float]], list[int]]:
    """Return the columns, the numbers of each row, and the line that each stands on."""
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
                columns = _columns(tuple(cell.strip() for cell in row), name)
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
    if len(rows) > _MOST_POINTS:
        raise InputError(f"{name}:{lines[_MOST_POINTS]}: wanted at most {_MOST_POINTS} points, found more")
    return columns, rows, lines


def _columns(header: tuple[str, ...], name: str) -> tuple[str, ...]:
    if header in (POINT, POINT + QUATERNION):
        return header
    wanted = f"the header {','.join(POINT)} or {','.join(POINT + QUATERNION)}"
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
