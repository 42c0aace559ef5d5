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
        ParameterError: It is no STL file, or its mesh is empty, open or flat.
    """
    data = _bytes(path)
    corners = _as_text(data.lower()) if _is_text(data) else _as_binary(data)
    triangles = np.asarray(corners * scale, dtype=np.float64)
    if not len(triangles):
        raise ParameterError("a mesh of one triangle or more is wanted, found none")
    bad = np.flatnonzero(~(np.abs(triangles) <= _FARTHEST_M))
    if len(bad):
        found = f"{triangles.flat[bad[0]]:g} in triangle {bad[0] // triangles[0].size + 1}"
        raise ParameterError(f"finite coordinates up to {_FARTHEST_M:g} m are wanted, found {found}")
    return Mesh(str(path.resolve()), scale, hashlib.sha256(data).hexdigest(), triangles)


def _bytes(path: Path) -> bytes:
    data = file_bytes(path, _MOST_BYTES)
    if len(data) > _MOST_BYTES:
        raise UnreadableError(f"more than {_MOST_BYTES} bytes")
    return data


def _is_text(data: bytes) -> bool:
    """Return whether a file is an STL file as text: binary ones may begin with the same word, but have bytes of 0."""
    return data.lstrip()[:5].lower() == b"solid" and b"\0" not in data


def _as_binary(data: bytes) -> Array:
    if len(data) < _HEAD:
        raise ParameterError(f"an STL file is wanted, found {len(data)} bytes that are none")
    count = int(np.frombuffer(data, "<u4", 1, _HEAD - 4)[0])
    size = _HEAD + _TRIANGLE.itemsize * count
    if len(data) != size:
        found = f"none: {len(data)} bytes, and as a binary one its {count} triangles take {size}"
        raise ParameterError(f"an STL file is wanted, found {found}")
    if count > MOST_TRIANGLES:
        raise ParameterError(f"at most {MOST_TRIANGLES} triangles are wanted, found {count}")
    return np.frombuffer(data, _TRIANGLE, -1, _HEAD)["corners"].astype(np.float64)


def _as_text(data: bytes) -> Array:
    if b"endsolid" not in data:
        raise ParameterError("an STL file is wanted, found one that breaks off: endsolid is missing")
    *facets, rest = data.split(b"endfacet")
    if len(facets) > MOST_TRIANGLES:
        raise ParameterError(f"at most {MOST_TRIANGLES} triangles are wanted, found {len(facets)}")
    corners = [facet.count(b"vertex") for facet in (*facets, rest)]
    wrong = [k for k, count in enumerate(corners) if count != (3 if k < len(facets) else 0)]
    if wrong:
        line = 1 + b"endfacet".join([*facets, rest][: wrong[0] + 1]).count(b"\n")
        what = "a facet" if wrong[0] < len(facets) else "a rest without endfacet"
        raise ParameterError(
            f"facets of 3 corners are wanted, found {what} of {corners[wrong[0]]} that ends on line {line}"
        )
    found = _CORNER.findall(data)
    try:
        if len(found) == 3 * len(facets):
            return np.array(found).astype(np.float64).reshape(-1, 3, 3)
    except ValueError:
        pass
    raise ParameterError(f"corners of 3 numbers are wanted, found another on line {_bad_line(data)}")


def _bad_line(data: bytes) -> int:
    """Return the line of the first corner that is not three numbers."""
    for one in re.finditer(rb"vertex", data):
        try:
            np.array(data[one.end() :].split(None, 3)[:3]).astype(np.float64).reshape(3)
        except ValueError:
            break
    return 1 + data.count(b"\n", 0, one.end())
