"""Decomposes a limb's rotation into three rotations about its own axes."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.reproducible import arctan2, hypot
from purcell_cli.geometry.rotations import Array, wrapped
from purcell_cli.mechanics.primitives import PrimitiveSequence

_NEGLIGIBLE_RAD = 1e-15
"""Angles up to this are zero: rounding errors of a rotation that needs no such angle [rad]."""
_LOCKED = 1e-12
"""Below this size of the matrix elements that tell the first angle, the rotations are in gimbal lock."""
_ORDERS = ["".join(o) for o in itertools.product("XYZ", repeat=3) if o[0] != o[1] and o[1] != o[2]]
_AXES = np.array([["XYZ".index(axis) for axis in order] for order in _ORDERS])
"""The twelve orders of axes in which three rotations about own axes reach any orientation. Shape (12, 3)."""


@frozen_dataclass(eq=False)
class Ways:
    """Ways to rotate one limb, by three rotations about its own axes each; a rotation may be empty.

    Attributes:
        control: Controls, 0 to 5. Shape (n, 3).
        angle: Angles [rad]. Shape (n, 3).
    """

    control: NDArray[np.int64]
    angle: Array

    def __len__(self) -> int:
        return len(self.control)

    def __getitem__(self, part: NDArray[np.int64]) -> Ways:
        return Ways(self.control[part], self.angle[part])

    @property
    def joint_travel_rad(self) -> Array:
        """The joint travel of each [rad]. Shape (n,)."""
        return np.asarray(np.abs(self.angle).sum(axis=1))

    def primitives(self, k: int) -> PrimitiveSequence:
        """Return the three primitives of one of the ways."""
        return PrimitiveSequence(self.control[k], self.angle[k])


def rotations_to(rotation: Array, limb: int) -> Ways:
    """Return every way of rotating a limb by three rotations about its own axes.

    Args:
        rotation: The rotation in the limb's own frame. Shape (3, 3).
        limb: 1 or 2.

    Returns:
        Ways, all different, the least joint travel first.
    """
    angle = _three_angles(rotation)
    angle = np.stack([angle, _other(angle)], axis=1).reshape(-1, 3)
    angle[np.abs(angle) <= _NEGLIGIBLE_RAD] = 0.0
    control = np.repeat(_AXES, 2, axis=0) + 3 * (limb - 1)
    # Ways that differ only in empty rotations are one.
    key = np.where(angle != 0.0, control + 1.0, 0.0)
    used = np.argsort(key == 0.0, axis=1, kind="stable")
    key, turned = (np.take_along_axis(x, used, axis=1) for x in (key, angle))
    first, _ = distinct(np.concatenate([key, np.round(turned, 9) + 0.0], axis=1))
    ways = Ways(control, angle)[np.sort(first)]
    return ways[np.argsort(np.round(ways.joint_travel_rad, 9), kind="stable")]


def least_travel(rotation: Array) -> Array:
    """Return the least joint travel of three rotations about own axes that make rotations [rad].

    Args:
        rotation: Rotations in the limb's own frame. Shape (..., 3, 3).

    Returns:
        Joint travel. Shape (...).
    """
    angle = _three_angles(rotation)
    travel = np.stack([np.abs(part).sum(axis=-1) for part in (angle, _other(angle))])
    return np.asarray(travel.min(axis=(0, -1)))


def _three_angles(rotation: Array) -> Array:
    """Return the angles of rotations about own axes that make rotations, in each of the orders [rad].

    The second is from -pi / 2 to pi / 2 where all axes differ, and from 0 to pi where the first is the last. Where the
    first and the last axis come to lie in one line, the last rotation is empty (gimbal lock).

    Args:
        rotation: Rotations. Shape (..., 3, 3).

    Returns:
        Angles. Shape (..., 12, 3).
    """
    i, j, k = _AXES.T
    l = 3 - i - j
    twice, sign = i == k, np.where((j - i) % 3 == 1, 1.0, -1.0)
    r = np.asarray(rotation)
    ii, ij, il, jj = r[..., i, i], r[..., i, j], r[..., i, l], r[..., j, j]
    size = hypot(ij, np.where(twice, il, ii))
    middle = arctan2(np.where(twice, size, sign * r[..., i, k]), np.where(twice, ii, size))
    first = arctan2(
        np.where(twice, r[..., j, i], -sign * r[..., j, k]), np.where(twice, -sign * r[..., l, i], r[..., k, k])
    )
    last = arctan2(np.where(twice, ij, -sign * ij), np.where(twice, sign * il, ii))
    locked = size < _LOCKED
    first = np.where(locked, arctan2(sign * r[..., l, j], jj), first)
    return np.stack([first, middle, np.where(locked, 0.0, last)], axis=-1)


def _other(angle: Array) -> Array:
    """Return the other three angles that make the same rotation, in each of the orders [rad]. Shape (..., 12, 3)."""
    middle = np.where(_AXES[:, 0] == _AXES[:, 2], -angle[..., 1], np.pi - angle[..., 1])
    turned = np.stack([angle[..., 0] + np.pi, middle, angle[..., 2] + np.pi], axis=-1)
    return wrapped(turned)
