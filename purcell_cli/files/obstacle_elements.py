"""Obstacles in documents: elements that read them, and values that are written."""

from __future__ import annotations

import functools
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from purcell_cli.environment.mesh import Mesh
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import LEVEL, Box, Capsule, HalfSpace, Sphere
from purcell_cli.environment.tube import CentrelineError, Tube
from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.centreline_csv import Centreline, read_centreline
from purcell_cli.files.configuration_file import COORDINATE, ORIENTATION
from purcell_cli.files.containers import Field, ListOf, Record, only_value
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.place import Place, shortened
from purcell_cli.files.scalars import Number, Text
from purcell_cli.files.stl_file import load_mesh

_LENGTH = Number(above=0.0, at_most=1e9)
"""A length [m]."""
_POINT = ListOf(COORDINATE, 3)
"""A point [m]."""
_FILE = Text(meaning="the path of a file")


def _unreadable(place: Place, name: str, error: UnreadableError) -> Exception:
    return place.error("the path of a readable file", f"{error} at '{shortened(str(place.folder / name))}'")


class _Centreline(Element[Centreline]):
    """The points of a centreline, in a file or inline."""

    _inline = ListOf(ListOf(COORDINATE, 3), at_least=2)

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{_FILE.wanted}, or {self._inline.wanted}"

    def read(self, place: Place) -> Centreline:
        """Return the points [m] and, where the file tells them beside them, the radii [m]."""
        if isinstance(place.node, yaml.SequenceNode):
            return Centreline(self._inline.read(place))
        name = _FILE.read(place)
        try:
            return read_centreline(place.folder / name, name)
        except UnreadableError as error:
            raise _unreadable(place, name, error) from error

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [_FILE.json_schema(), self._inline.json_schema()]}


class _Radius(Element[list[float]]):
    """One radius, or one for each point."""

    _each = ListOf(_LENGTH, at_least=2)

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{_LENGTH.wanted}, or {self._each.wanted}"

    def read(self, place: Place) -> list[float]:
        """Return the radii [m]; one stands for all."""
        return self._each.read(place) if isinstance(place.node, yaml.SequenceNode) else [_LENGTH.read(place)]

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [_LENGTH.json_schema(), self._each.json_schema()]}


def _tube(value: dict[str, Any], place: Place) -> Tube:
    line: Centreline = value["centreline"]
    given = value.get("radius_m")
    if (given is None) == (line.radii is None):
        both = "both" if given is not None else "neither"
        raise place.error("a radius, by the key radius_m or by the centreline's column radius_m", both)
    radii = list(line.radii or given or ())
    radii = radii * len(line.points) if len(radii) == 1 else radii
    if len(radii) != len(line.points):
        raise place.at("radius_m").error(f"one radius, or {len(line.points)}, one a point", f"{len(radii)}")
    try:
        return Tube(tuple((x, y, z) for x, y, z in line.points), tuple(radii), line.file)
    except CentrelineError as error:
        if line.places:
            raise InputError(f"{line.places[error.point]}: wanted {error.wanted}, found {error.found}") from error
        raise place.at("centreline", error.point).error(error.wanted, error.found) from error


def _mesh(value: dict[str, Any], place: Place) -> Mesh:
    name = value["file"]
    try:
        mesh = load_mesh(place.folder / name, value.get("scale", 1.0))
    except UnreadableError as error:
        raise _unreadable(place.at("file"), name, error) from error
    if mesh.volume_m3 < 0.0:
        told = "its triangles face inwards, and it is taken as the solid that they enclose all the same"
        warnings.warn(f"{place.file}:{place.line}: {place.key}.file: {told}", PurcellWarning, stacklevel=2)
    return mesh


def _box(value: dict[str, Any], _: Place) -> Box:
    turned = value.pop("orientation", np.array(LEVEL))
    rows: Any = tuple(tuple(row) for row in turned.tolist())
    return Box(**value, orientation=rows)


OBSTACLE: Element[Obstacle] = Made(
    Record(
        {
            "sphere": Field(
                Made(
                    Record(
                        {
                            "centre_m": Field(_POINT, "its middle [m]", required=True),
                            "radius_m": Field(_LENGTH, "its radius [m]", required=True),
                        }
                    ),
                    lambda value, _: Sphere(**value),
                ),
                "a ball",
            ),
            "capsule": Field(
                Made(
                    Record(
                        {
                            "from_m": Field(_POINT, "one end of its axis [m]", required=True),
                            "to_m": Field(_POINT, "the other [m]", required=True),
                            "radius_m": Field(_LENGTH, "its radius [m]", required=True),
                        }
                    ),
                    lambda value, _: Capsule(**value),
                ),
                "a rod with round ends",
            ),
            "box": Field(
                Made(
                    Record(
                        {
                            "centre_m": Field(_POINT, "its middle [m]", required=True),
                            "size_m": Field(ListOf(_LENGTH, 3), "its edges along its own axes [m]", required=True),
                            "orientation": Field(ORIENTATION, "in the world; left out, the world's"),
                        }
                    ),
                    _box,
                ),
                "a box",
            ),
            "half_space": Field(
                Made(
                    Record(
                        {
                            "point_m": Field(_POINT, "a point of its plane [m]", required=True),
                            "normal": Field(ListOf(COORDINATE, 3), "points to where the swimmer stays", required=True),
                        }
                    ),
                    lambda value, _: HalfSpace(**value),
                ),
                "all that lies behind a plane",
            ),
            "tube": Field(
                Made(
                    Record(
                        {
                            "centreline": Field(
                                _Centreline(),
                                "a CSV file with the columns x_m,y_m,z_m and, if wanted, radius_m; or points [m]",
                                required=True,
                            ),
                            "radius_m": Field(_Radius(), "its radius [m], or one for each point"),
                        }
                    ),
                    _tube,
                ),
                "what the swimmer stays inside of; several tubes are one vessel",
            ),
            "mesh": Field(
                Made(
                    Record(
                        {
                            "file": Field(_FILE, "an STL file of a closed surface", required=True),
                            "scale": Field(_LENGTH, "what makes its coordinates metres", default=1.0),
                        }
                    ),
                    _mesh,
                ),
                "a solid with a surface of triangles",
            ),
        },
        exactly_one=True,
    ),
    only_value,
)
"""The element for one obstacle."""

OBSTACLES: Element[Scene] = Made(ListOf(OBSTACLE, at_least=1), lambda value, _: Scene(tuple(value)))
"""The element for what stands in the water."""


def obstacles_written(scene: Scene, folder: Path | None = None) -> list[dict[str, Any]]:
    """Return a scene as a document's value, which needs no file but those of meshes.

    Args:
        scene: The scene.
        folder: Where the document will be, from which the files of meshes are then named.
    """
    out = [{str(one.kind): _written(one)} for one in scene.obstacles]
    for one in (value["mesh"] for value in out if folder is not None and "mesh" in value):
        one["file"] = _named_from(Path(one["file"]), folder)
    return out


def _named_from(file: Path, folder: Path | None) -> str:
    """Return the path of a file from a folder; the whole of it where they have nothing in common."""
    try:
        return Path(os.path.relpath(file, (folder or Path()).resolve())).as_posix()
    except ValueError:  # on another drive
        return str(file)


@functools.singledispatch
def _written(obstacle: Obstacle) -> dict[str, Any]:
    raise NotImplementedError(obstacle.kind)


@_written.register
def _(obstacle: Sphere) -> dict[str, Any]:
    return {"centre_m": [*obstacle.centre_m], "radius_m": obstacle.radius_m}


@_written.register
def _(obstacle: Capsule) -> dict[str, Any]:
    return {"from_m": [*obstacle.from_m], "to_m": [*obstacle.to_m], "radius_m": obstacle.radius_m}


@_written.register
def _(obstacle: Box) -> dict[str, Any]:
    out: dict[str, Any] = {"centre_m": [*obstacle.centre_m], "size_m": [*obstacle.size_m]}
    turned = {} if obstacle.orientation == LEVEL else {"orientation": {"matrix": [[*r] for r in obstacle.orientation]}}
    return out | turned


@_written.register
def _(obstacle: HalfSpace) -> dict[str, Any]:
    return {"point_m": [*obstacle.point_m], "normal": [*obstacle.normal]}


@_written.register
def _(obstacle: Tube) -> dict[str, Any]:
    return {"centreline": [[*p] for p in obstacle.points_m], "radius_m": [*obstacle.radii_m]}


@_written.register
def _(obstacle: Mesh) -> dict[str, Any]:
    return {"file": obstacle.file, "scale": obstacle.scale}
