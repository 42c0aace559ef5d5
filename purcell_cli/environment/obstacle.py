"""What every obstacle can be asked, and the products that several of them are made of."""

from __future__ import annotations

import abc
from numbers import Real
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array
from purcell_cli.geometry.three_numbers import three_numbers

Point = tuple[float, float, float]
"""A point of the world: x, y and z [m]."""


class Obstacle(abc.ABC):
    """Something that no part of the swimmer may touch.

    Attributes:
        kind: What it is, as documents call it.
    """

    kind: ClassVar[str]

    @abc.abstractmethod
    def distance(self, first: Array, last: Array) -> Array:
        """Return how far segments are from the obstacle, negative inside it; never more than the truth [m].

        Args:
            first: The segments' beginnings [m]. Shape (n, 3).
            last: Their ends; a point has both alike [m]. Shape (n, 3).

        Returns:
            Distances. Shape (n,).
        """

    @abc.abstractmethod
    def bounds(self) -> Array:
        """Return the least and the largest x, y and z of its surface, infinite where it has no end [m]. (2, 3)."""


def point(value: ArrayLike, name: str) -> Point:
    """Return three finite numbers.

    Raises:
        ParameterError: Not three, or not finite.
    """
    x, y, z = three_numbers(value, name).tolist()
    return x, y, z


def length(value: float, name: str) -> float:
    """Return a finite number above 0.

    Raises:
        ParameterError: It is none.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 < value < np.inf:
        raise ParameterError(f"{name}: a finite number above 0 is wanted, found {value!r}")
    return float(value)


def dot(a: Array, b: Array) -> Array:
    """Return inner products over the last axis, of three: the same bits everywhere. Shapes (..., 3), broadcast."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def along(points: Array, first: Array, way: Array) -> Array:
    """Return where on segments points are nearest to them, from 0 to 1. Shapes (..., 3), broadcast, to (...)."""
    square = dot(way, way)
    return np.asarray(np.clip(dot(points - first, way) / np.where(square > 0.0, square, 1.0), 0.0, 1.0))
