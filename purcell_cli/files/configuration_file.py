"""Configurations and goals as YAML."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.errors import PurcellWarning
from purcell_cli.files.containers import Field, ListOf, OrNull, Record, only_value
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import Number
from purcell_cli.files.yaml_source import load
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import (
    INPUT_SLACK,
    MEASURED_SLACK,
    Array,
    from_euler,
    from_matrix,
    from_quaternion,
    matrix_error,
    quaternion_error,
)
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.motion.workspace import Workspace

_FARTHEST_M = 1e15
"""Coordinates go no farther than this, so that none can overflow."""


_LARGEST_ANGLE = 1e6
"""Euler angles go no farther than this [deg, rad]: a double holds them to 1e-10 rad there, and 1e-9 is promised."""


def _rotation(length: int, item: Element[Any], make: Callable[[Array], Array]) -> Element[Array]:
    """Return the element for a rotation made from a list of items."""
    return Made(ListOf(item, length), lambda value, _: make(np.array(value, dtype=np.float64)))


def _measured(
    length: int, item: Element[Any], make: Callable[[Array, float], Array], error: Callable[[Array], Array]
) -> Element[Array]:
    """Return the element for a rotation that may be off by rounding to few digits; how much is told in a warning.

    Args:
        length: How many items its list has.
        item: What they are.
        make: Takes the array of them, and what it may be off, to the rotation.
        error: Returns what it is off.
    """

    def made(value: list[Any], place: Place) -> Array:
        with np.errstate(all="ignore"):
            given = np.array(value, dtype=np.float64)
            rotation, off = make(given, MEASURED_SLACK), float(error(given))
        if off > INPUT_SLACK:
            text = f"{place.file}:{place.line}: {place.key}: normalised, since it is off by {off:.2g}"
            warnings.warn(text, PurcellWarning, stacklevel=2)
        return rotation

    return Made(ListOf(item, length), made)


_ANGLE = Number(at_least=-_LARGEST_ANGLE, at_most=_LARGEST_ANGLE)


ORIENTATION: Element[Array] = Made(
    Record(
        {
            "euler_deg": Field(_rotation(3, _ANGLE, lambda e: from_euler(np.radians(e))), "[psi, theta, phi] [deg]"),
            "euler_rad": Field(_rotation(3, _ANGLE, from_euler), "[psi, theta, phi] [rad]"),
            "quaternion_wxyz": Field(
                _measured(4, Number(), from_quaternion, quaternion_error),
                "unit quaternion, within 1e-2",
            ),
            "matrix": Field(
                _measured(3, ListOf(Number(), 3), from_matrix, matrix_error),
                "rotation matrix within 1e-2, rows first",
            ),
        },
        exactly_one=True,
    ),
    only_value,
)

COORDINATE = Number(at_least=-_FARTHEST_M, at_most=_FARTHEST_M)

_BASE = Record(
    {
        "position_m": Field(ListOf(COORDINATE, 3), "position in the world [m]", default=[0.0, 0.0, 0.0]),
        "orientation": Field(ORIENTATION, "orientation in the world; left out, the world's"),
    }
)


def _configuration(value: dict[str, Any], _: Place) -> Configuration:
    level = np.eye(3)
    base = value.get("base", {})
    pose = se3.pose(base.get("orientation", level), base.get("position_m", np.zeros(3)))
    return Configuration(pose, np.stack([value.get("limb1", level), value.get("limb2", level)]))


CONFIGURATION_FIELDS = {
    "base": Field(_BASE, "the base link"),
    "limb1": Field(ORIENTATION, "limb 1 in the base; left out, collinear"),
    "limb2": Field(ORIENTATION, "limb 2 in the base; left out, collinear"),
}

CONFIGURATION = Document(
    "A configuration of the swimmer (start.yaml)", Made(Record(CONFIGURATION_FIELDS), _configuration)
)

_CORNER = ListOf(OrNull(COORDINATE), 3)
"""A corner of a box: x, y and z [m]."""

WORKSPACE: Element[Workspace] = Made(
    Record(
        {
            "min": Field(_CORNER, "the corner of least x, y and z, null for no wall there [m]; left out, no walls"),
            "max": Field(_CORNER, "the opposite corner, null for no wall there [m]; left out, no walls"),
        }
    ),
    lambda value, _: Workspace(**value),
)
"""The element for a box that the links stay in."""

WORKSPACE_FIELD = {"workspace_m": Field(WORKSPACE, "a box that all three links stay in; left out, there is none")}


@frozen_dataclass
class Goal:
    """What a goal file says.

    Attributes:
        configuration: Where to end.
        workspace: The box to stay in on the way, if there is one.
    """

    configuration: Configuration
    workspace: Workspace | None = None


def _goal(value: dict[str, Any], place: Place) -> Goal:
    return Goal(_configuration(value, place), value.get("workspace_m"))


GOAL = Document(
    "A goal: a configuration of the swimmer (goal.yaml)", Made(Record(CONFIGURATION_FIELDS | WORKSPACE_FIELD), _goal)
)


def load_configuration(path: Path | str) -> Configuration:
    """Return the configuration of a file (start.yaml); the path - is standard input.

    Raises:
        InputError: The file says no configuration.
    """
    return load(path, CONFIGURATION)


def load_goal(path: Path | str) -> Goal:
    """Return the goal of a file: its configuration, and its workspace if it has one. The path - is standard input.

    Raises:
        InputError: The file says no goal.
    """
    return load(path, GOAL)
