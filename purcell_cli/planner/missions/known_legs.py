"""Legs along a curve that are planned already: by left invariance each serves wherever the way ahead is the same.

So the laps of a closed curve, or the parts of a circle, cost one plan, and their distance from the curve one look.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import apply, matmul, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.mission import Follow

LegBlocks = Callable[[Configuration, Configuration, float], tuple[Block, ...]]
"""Plans a leg from a configuration to another with limbs that bend no further than so much [rad]."""

_SAME = 1e-3
"""A leg whose strokes end within this of where another is to end serves for that one too [L, rad]: what is written to
six digits turns from point to point by some 1e-4 rad. The last leg is planned exactly."""


@dataclasses.dataclass(slots=True, eq=False)
class Leg:
    """A leg that is planned, wherever it begins.

    Attributes:
        bend_rad: How far limbs may bend in its strokes [rad].
        shape: The shape it begins with. Shape (2, 3, 3).
        blocks: Its strokes.
        moved: What they do to the base [m]. Shape (4, 4).
        near: Parts of the curve, seen from where it began, and how far from them it was at most [m].
    """

    bend_rad: float
    shape: Array
    blocks: tuple[Block, ...]
    moved: Array
    near: list[tuple[Array, float]] = dataclasses.field(default_factory=list)

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its joints of |angle| [rad]."""
        return sum(b.joint_travel_rad for b in self.blocks)

    def serves(self, wanted: Array, shape: Array, bend_rad: float, length_m: float) -> bool:
        """Return whether it makes a displacement [m] from a shape. Shapes (4, 4) and (2, 3, 3)."""
        if self.bend_rad != bend_rad or not np.array_equal(self.shape, shape):
            return False
        off = se3.log(se3.normalised(matmul(se3.inverse(self.moved), wanted)))
        return float(norm(off[:3])) < _SAME * length_m and float(norm(off[3:])) < _SAME


class KnownLegs:
    """The legs of one search.

    Args:
        swimmer: The swimmer.
        tolerance_m: How far from the curve the base's middle may be [m].
        plan_leg: Plans a leg.
    """

    def __init__(self, swimmer: Swimmer, tolerance_m: float, plan_leg: LegBlocks) -> None:
        self._swimmer, self._tolerance_m, self._plan = swimmer, tolerance_m, plan_leg
        self._known: list[Leg] = []

    def leg(self, here: Configuration, there: Configuration, bend_rad: float, exact: bool) -> Leg:
        """Return a leg from one configuration to another.

        Args:
            here: Where it begins.
            there: Where it ends.
            bend_rad: How far limbs may bend [rad].
            exact: Whether it ends there exactly, and not within `_SAME`.
        """
        wanted = se3.normalised(matmul(se3.inverse(here.pose), there.pose))
        for leg in [] if exact else self._known:
            if leg.serves(wanted, here.shape, bend_rad, self._swimmer.length_m):
                return leg
        blocks = self._plan(here, there, bend_rad)
        moved = se3.prefix_products(block_displacements(self._swimmer, blocks, here.shape))[-1]
        self._known.append(Leg(bend_rad, here.shape, blocks, moved))
        return self._known[-1]

    def off_m(self, leg: Leg, here: Configuration, part: Curve) -> float:
        """Return how far from a part of a curve a leg is at most [m]."""
        back = se3.inverse(here.pose)
        seen = apply(back[:3, :3], part.point_m) + back[:3, 3]
        for points, off in leg.near:
            if points.shape == seen.shape:
                away = float(np.max(norm(points - seen)))
                if off + away <= self._tolerance_m or off - away > self._tolerance_m:
                    return off + away
        limits = Limits(follow=Follow(part, self._tolerance_m))
        found = check(self._swimmer, here, leg.blocks, limits).off_curve
        off = np.inf if found is None else found.most_m
        leg.near.append((seen, off))
        return off
