"""Centrelines of tubes as CSV: the columns x_m, y_m, z_m and, if wanted, radius_m."""

from __future__ import annotations

from pathlib import Path

from purcell_cli.errors import InputError
from purcell_cli.files.place import shortened
from purcell_cli.files.points_csv import POINT, read_points
from purcell_cli.files.yaml_source import file_bytes
from purcell_cli.frozen_dataclass import frozen_dataclass

_RADIUS = "radius_m"
_WIDEST_M = 1e9
"""Radii go no farther than this, as in documents [m]."""


@frozen_dataclass
class Centreline:
    """What a centreline says, and where.

    Attributes:
        points: Its points [m].
        radii: The tube's radius at each [m]; None where they are told elsewhere.
        file: The file; empty where they stand in the document.
        places: The file and the line of each point; empty where they stand in the document.
    """

    points: list[list[float]]
    radii: list[float] | None = None
    file: str = ""
    places: tuple[str, ...] = ()


def read_centreline(path: Path, file: str) -> Centreline:
    """Return the centreline of a file.

    Args:
        path: The file.
        file: What documents call it.

    Raises:
        UnreadableError: There is no such file, or it cannot be read.
        InputError: A header or a row that is not what is wanted.
    """
    name = str(path)
    rows, lines = read_points(file_bytes(path), name, (_RADIUS,))
    places = tuple(f"{name}:{line}" for line in lines)
    radii = [row[3] for row in rows] if len(rows[0]) > len(POINT) else None
    for place, radius in zip(places, radii or (), strict=radii is not None):
        if not 0.0 < radius <= _WIDEST_M:
            wanted = f"a finite number above 0 and at most {_WIDEST_M:g}"
            raise InputError(f"{place}: {_RADIUS}: wanted {wanted}, found {shortened(f'{radius:g}')}")
    return Centreline([row[:3] for row in rows], radii, file, places)
