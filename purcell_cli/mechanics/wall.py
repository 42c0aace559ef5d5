"""One plane wall without slip beside a swimmer whose links feel each other's flow.

A wall breaks left invariance: how the swimmer moves depends on where it is, so nothing is planned with one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array

if TYPE_CHECKING:
    from purcell_cli.mechanics.swimmer import Swimmer

FARTHEST_M = 1e6
"""The largest coordinate of a wall's point [m], that of the longest base."""


@frozen_dataclass
class Wall:
    """A plane wall without slip; the fluid is on the side that its normal points to.

    Attributes:
        point_m: A point of it in the world [m].
        normal: Its normal, into the fluid; made a unit vector.

    Raises:
        ParameterError: Not three finite numbers each, or a normal without a direction.
    """

    point_m: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        for name in ("point_m", "normal"):
            value = getattr(self, name)
            if not isinstance(value, Sequence | np.ndarray) or len(value) != 3 or not all(map(_finite, value)):
                raise ParameterError(f"{name}: three finite numbers of at most {FARTHEST_M:g} are wanted")
            object.__setattr__(self, name, tuple(float(x) for x in value))
        size = math.sqrt(sum(x * x for x in self.normal))
        if not size > 1e-12:
            raise ParameterError(f"normal: a vector with a direction is wanted, found {list(self.normal)}")
        if abs(size - 1.0) > 1e-15:
            object.__setattr__(self, "normal", tuple(x / size for x in self.normal))

    def scaled(self, length_m: float) -> Wall:
        """Return the wall with lengths in units of another [m]."""
        x, y, z = self.point_m
        return Wall((x / length_m, y / length_m, z / length_m), self.normal)

    def beside(self, pose: Array) -> Array:
        """Return the wall as a swimmer at a pose sees it.

        Args:
            pose: The base's pose. Shape (4, 4).

        Returns:
            The normal in base coordinates, and the height of the base's middle [m]. Shape (4,).
        """
        normal = np.array(self.normal)
        height = matmul(normal, pose[:3, 3] - np.array(self.point_m))
        return np.append(matmul(pose[:3, :3].T, normal), height)


def _finite(value: object) -> bool:
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    return number and abs(float(value)) <= FARTHEST_M  # type: ignore[arg-type]


def refuse_wall(swimmer: Swimmer) -> None:
    """Refuse a swimmer beside a wall, where only left-invariant motion is known.

    Raises:
        ParameterError: It swims beside a wall.
    """
    if swimmer.wall is not None:
        known = "only simulate, track's --truth and controllability know a wall"
        raise ParameterError(f"wall: a swimmer without one is wanted ({known}), found one beside a wall")
