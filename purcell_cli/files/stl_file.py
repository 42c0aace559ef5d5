"""Triangle meshes from STL files, binary and as text.

Read here rather than by a mesh library: the form is fifty bytes a triangle, and a fault is to be told in few words.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import numpy as np

from purcell_cli.environment.mesh import Mesh
from purcell_cli.errors import ParameterError
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.yaml_source import file_bytes
from purcell_cli.geometry.rotations import Array

MOST_TRIANGLES = 200_000
"""Triangles of a mesh at most: their tree takes a second to build, and a distance stays below a millisecond."""

_MOST_BYTES = 300 * MOST_TRIANGLES
"""Bytes of a file at most: a triangle takes 50 as binary, some 250 as text."""

_HEAD = 84
"""Bytes before the triangles of a binary file: 80 of anything, and their number."""

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A triangle of a binary file."""

_CORNER = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")

_FARTHEST_M = 1e9
"""Coordinates go no farther than this [m]: their squares are exact enough, and cannot overflow."""


def load_mesh(path: Path, scale: float) -> Mesh:
    """Return the mesh of an STL file.

    Args:
        path: The file.
        scale: What its coordinates are multiplied by to be metres.

    Raises:
        UnreadableError: There is no such file, it cannot be read, or it is too large.
        ParameterError: It is no STL file, or its mesh is empty or open.
    """
    data = _bytes(path)
    corners = _as_text(data) if _is_text(data) else _as_binary(data)
    triangles = np.asarray(corners * scale, dtype=np.float64)
    if not len(triangles):
        raise ParameterError("a mesh of one triangle or more is wanted, found none")
    if not np.all(np.abs(triangles) <= _FARTHEST_M):
        raise ParameterError(f"coordinates up to {_FARTHEST_M:g} m are wanted, found others")
    return Mesh(str(path.resolve()), scale, hashlib.sha256(data).hexdigest(), triangles)


def _bytes(path: Path) -> bytes:
    data = file_bytes(path, _MOST_BYTES)
    if len(data) > _MOST_BYTES:
        raise UnreadableError(f"more than {_MOST_BYTES} bytes")
    return data


def _is_text(data: bytes) -> bool:
    """Return whether a file is an STL file as text: binary ones may begin with the same word."""
    if not data.lstrip().startswith(b"solid"):
        return False
    return len(data) < _HEAD or _HEAD + _TRIANGLE.itemsize * _count(data) != len(data)


def _count(data: bytes) -> int:
    return int(np.frombuffer(data, "<u4", 1, _HEAD - 4)[0])


def _as_binary(data: bytes) -> Array:
    if len(data) < _HEAD or len(data) != _HEAD + _TRIANGLE.itemsize * _count(data):
        raise ParameterError("an STL file is wanted, found none")
    if _count(data) > MOST_TRIANGLES:
        raise ParameterError(f"at most {MOST_TRIANGLES} triangles are wanted, found {_count(data)}")
    return np.frombuffer(data, _TRIANGLE, -1, _HEAD)["corners"].astype(np.float64)


def _as_text(data: bytes) -> Array:
    facets = data.count(b"endfacet")
    found = _CORNER.findall(data)
    if b"endsolid" not in data or len(found) != 3 * facets:
        raise ParameterError("an STL file is wanted, found one that breaks off or has corners too many or too few")
    if facets > MOST_TRIANGLES:
        raise ParameterError(f"at most {MOST_TRIANGLES} triangles are wanted, found {facets}")
    try:
        return np.array(found).astype(np.float64).reshape(-1, 3, 3)
    except ValueError as error:
        raise ParameterError("an STL file is wanted, found a corner that is no number") from error
