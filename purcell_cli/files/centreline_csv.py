"""Centrelines of tubes as CSV: the columns x_m, y_m, z_m and, if wanted, radius_m."""

from __future__ import annotations

import math
from pathlib import Path

from purcell_cli.errors import InputError
from purcell_cli.files.place import input_error, shortened
from purcell_cli.files.yaml_source import MOST_BYTES, file_bytes

_COLUMNS = ("x_m", "y_m", "z_m")
_RADIUS = "radius_m"


def read_centreline(path: Path) -> tuple[list[list[float]], list[float] | None]:
    """Return the points of a centreline [m] and, where the file says them, the radii there [m].

    Raises:
        UnreadableError: There is no such file, or it cannot be read.
        InputError: A header or a row that is not what is wanted.
    """
    file, data = str(path), file_bytes(path)
    if len(data) > MOST_BYTES:
        raise input_error(file, 1, "", f"at most {MOST_BYTES} bytes", "more")
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise input_error(file, data.count(b"\n", 0, error.start) + 1, "", "UTF-8", "another byte") from error
    header = tuple(name.strip() for name in lines[0].split(",")) if lines else ()
    if header not in {_COLUMNS, (*_COLUMNS, _RADIUS)}:
        wanted = f"the columns {','.join(_COLUMNS)} and, if wanted, {_RADIUS}"
        raise input_error(file, 1, "header", wanted, shortened(lines[0]) if lines else "nothing")
    rows = [_row(file, number, line, header) for number, line in enumerate(lines[1:], 2) if line.strip()]
    if len(rows) < 2:
        raise input_error(file, len(lines), "rows", "two points or more", f"{len(rows)}")
    return [row[:3] for row in rows], [row[3] for row in rows] if len(header) == 4 else None


def _row(file: str, number: int, line: str, header: tuple[str, ...]) -> list[float]:
    """Return the numbers of a row."""
    cells = line.split(",")
    if len(cells) != len(header):
        raise input_error(file, number, "row", f"{len(header)} numbers", f"{len(cells)}")
    return [_number(file, number, name, cell) for name, cell in zip(header, cells, strict=True)]


def _number(file: str, number: int, name: str, cell: str) -> float:
    fault: InputError = input_error(file, number, name, "a finite number", shortened(cell.strip()) or "nothing")
    try:
        value = float(cell)
    except ValueError:
        raise fault from None
    if not math.isfinite(value):
        raise fault
    return value
