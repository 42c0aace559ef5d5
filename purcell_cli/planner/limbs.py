"""Phases 1 and 3: limbs to the collinear shape and from it, by primitives (section IV-B of the paper)."""

from __future__ import annotations

import itertools
import warnings

from purcell_cli.primitives import PrimitiveSequence
from purcell_cli.rotations import Array

_NEGLIGIBLE_RAD = 1e-15

_ORDERS = ["".join(o) for o in itertools.product("XYZ", repeat=3) if o[0] != o[1] and o[1] != o[2]]
"""The twelve orders in which three turns about own axes reach any orientation."""


def turns_to(rotation: Array, limb: int) -> list[PrimitiveSequence]:
    """Return every way of turning a limb by a rotation with three turns about its own axes.

    Args:
        rotation: The rotation in the limb's own frame. Shape (3, 3).
        limb: 1 or 2.

    Returns:
        Sequences without empty turns, shortest joint travel first.
    """
    from scipy.spatial.transform import Rotation  # slow to import; few commands need it

    ways: dict[tuple[tuple[int, float], ...], PrimitiveSequence] = {}
    rotor = Rotation.from_matrix(rotation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # at gimbal lock one of the many equal ways is taken
        for order in _ORDERS:
            angles = rotor.as_euler(order)
            steps = [
                (3 * (limb - 1) + "XYZ".index(axis), float(angle))
                for axis, angle in zip(order, angles, strict=True)
                if abs(angle) > _NEGLIGIBLE_RAD
            ]
            ways.setdefault(tuple((c, round(a, 12)) for c, a in steps), PrimitiveSequence.of(steps))
    return sorted(ways.values(), key=lambda s: round(s.joint_travel_rad, 12))


def to_collinear(shape: Array) -> PrimitiveSequence:
    """Return the shortest primitives that straighten both limbs, limb 1 first. Shape (2, 3, 3)."""
    return turns_to(shape[0].T, 1)[0] + turns_to(shape[1].T, 2)[0]


def from_collinear(shape: Array) -> PrimitiveSequence:
    """Return the shortest primitives from the collinear shape to a shape, limb 1 first. Shape (2, 3, 3)."""
    return turns_to(shape[0], 1)[0] + turns_to(shape[1], 2)[0]
