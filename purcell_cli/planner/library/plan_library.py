"""The motion library: short plans found offline, which begin the search for those that resemble them.

A library plan is a closed sequence of primitives from the collinear shape, of the least joint travel that
a long search found for its displacement. The collinear swimmer has 16 symmetries (two ends, four sides
and a mirror), and a plan can be played backwards, so each plan stands for 32. Where its limbs are not alike
it has 8, and the plans with exchanged limbs are plans of their own. With all angles scaled by
s its displacement is about s^2 times as large, since areas lead the displacement of closed strokes; where
that would break the bend limit, several laps share it. Newton's method brings the plans that come near a
wanted displacement to it.

`python -m benchmarks.motion_library` finds the plans. Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import orjson

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner, matmul, norm
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.prepared import run_displacements_kept

PRICES = np.array([204.0, 566.0, 566.0, 4.0, 374.0, 374.0])
"""Estimated square of the joint travel per component of a small displacement [rad^2 per L or rad]. Shape (6,)."""

_END_FOR_END = np.diag([-1.0, 1.0, 1.0])
"""The reflection that exchanges the limbs."""
_SPARE = 0.1
"""A count of laps is rounded down if it exceeds a whole number by less than this: refinement takes up the rest."""
_LONG_RAD = 9.0
"""Plans of more joint travel than this are far from linear [rad]: what their displacement is apart by counts twice."""
_UNEVEN = 0.25
"""How much the scale of such a plan counts beside that: displacements do not grow as areas do; from a few fits."""
_FEW = 1e-12
"""The least size of a displacement in units of `PRICES`, so that none divides by zero [rad^2]."""
_ROUNDED = 1.0 - 1e-9
"""What is left of a bound where rounding errors are let pass."""
_MOST_LAPS = 20
"""Plans that need more laps than this are left out."""


def symmetries() -> Array:
    """Return the rotations and reflections of space that the collinear swimmer does not show. Shape (16, 3, 3)."""
    out = np.zeros((16, 3, 3))
    for k, (swapped, *signs) in enumerate(itertools.product((0, 1), (1, -1), (1, -1), (1, -1))):
        out[k, [0, 1, 2], [0, 2, 1] if swapped else [0, 1, 2]] = signs
    return out


def image(plan: PrimitiveSequence, symmetry: Array, backwards: bool = False) -> PrimitiveSequence:
    """Return a plan as a symmetry shows it: it does to the base what the plan does, seen in the same way.

    Rotation vectors are axial, so a reflection negates them too; what takes x to -x exchanges the limbs.

    Args:
        plan: The plan.
        symmetry: One of `symmetries`. Shape (3, 3).
        backwards: Whether it is played backwards.
    """
    limb, axis = np.divmod(plan.control, 3)
    turned = np.abs(symmetry).argmax(axis=0)
    handed = inner(symmetry[0], cross(symmetry[1], symmetry[2]))
    sign = handed * symmetry[turned, [0, 1, 2]]
    exchanged = 1 - limb if symmetry[0, 0] < 0.0 else limb
    out = PrimitiveSequence(3 * exchanged + turned[axis], np.round(sign[axis]) * plan.angle)
    return out.inverse() if backwards else out


@functools.cache
def stored_plans() -> tuple[PrimitiveSequence, ...]:
    """Return the plans of the library."""
    plans = orjson.loads(Path(__file__).with_name("plans.json").read_bytes())["plans"]
    control, angle = ([number for plan in plans for number in plan[key]] for key in ("control", "angle"))
    whole = PrimitiveSequence(np.array(control), np.array(angle))
    ends = itertools.accumulate((len(plan["angle"]) for plan in plans), initial=0)
    return tuple(whole[low:high] for low, high in itertools.pairwise(ends))


@frozen_dataclass(eq=False)
class Entry:
    """A library plan, scaled to resemble a displacement that is wanted, in as many laps as the bend limit asks for.

    Attributes:
        wanted: Which displacement.
        lap: One lap.
        laps: How many.
        estimate_rad: About the joint travel that the displacement takes by it [rad].
    """

    wanted: int
    lap: PrimitiveSequence
    laps: int
    estimate_rad: float


class MotionLibrary:
    """Library plans and what they do, for one swimmer.

    Args:
        plans: The plans.
        swimmer: The swimmer, scaled to L = 1.
    """

    def __init__(self, plans: tuple[PrimitiveSequence, ...], swimmer: Swimmer) -> None:
        self._symmetries = symmetries()
        if not swimmer.equal_limbs:
            plans = (*plans, *(image(plan, _END_FOR_END) for plan in plans))
            self._symmetries = self._symmetries[self._symmetries[:, 0, 0] > 0.0]
        self._plans, self._limit = plans, swimmer.max_bend_rad
        whole, counts = joined(plans), [len(p) for p in plans]
        pieces = Pieces.of(whole)
        once = run_displacements_kept("library", swimmer, pieces, counts, SEARCHING)
        self._does = se3.log(se3.normalised(once)) * PRICES
        self._size = norm(self._does)
        bends = LimbCircles.of(pieces).largest_bends()[0].max(axis=1)
        self._bend = np.maximum.reduceat(bends, np.cumsum([0, *counts[:-1]]))
        self._travel = np.array([p.joint_travel_rad for p in plans])

    def nearest(self, wanted: Array, around: Array, most: int, least: float = math.inf) -> Iterator[Entry]:
        """Give the entries that promise the least joint travel, the best first, each made when it is asked for.

        Args:
            wanted: The displacements that are wanted. Shape (n, 4, 4).
            around: Joint travel before and after each [rad]. Shape (n,).
            most: How many.
            least: What they may promise at the most [rad].
        """
        worth = np.flatnonzero(self._at_least(wanted) + around <= least)
        if not len(worth):
            return
        estimate, laps, scale = self.estimates(wanted[worth])
        estimate += around[worth, None, None]
        told: set[tuple[int, float]] = set()
        promised = estimate.ravel()
        few = np.flatnonzero((promised <= least) & (promised < np.inf))
        for flat in few[np.argsort(promised[few], kind="stable")].tolist():
            if len(told) == most:
                break
            (pair, k), travel = divmod(flat, len(self._plans)), float(promised[flat])
            if (alike := (k, round(travel, 1))) in told:
                continue  # the same plan seen another way, for what looks the same then
            told.add(alike)
            i, j = divmod(pair, estimate.shape[1])
            seen, backwards = j % len(self._symmetries), j >= len(self._symmetries)
            plan = image(self._plans[k], self._symmetries[seen], backwards)
            lap = plan.with_angles(math.sqrt(scale[i, j, k]) * plan.angle)
            yield Entry(int(worth[i]), lap, int(laps[i, j, k]), travel)

    def _at_least(self, wanted: Array) -> Array:
        """Return what `estimates` is not below for displacements, whatever the plan's image [rad]. Shape (n,)."""
        size = np.maximum(norm(se3.log(se3.normalised(wanted)) * PRICES), _FEW)  # of an image it is the same
        laps, scale = self._laps(_ROUNDED * size[:, None])
        alike = np.where(laps > _MOST_LAPS, np.inf, self._travel * np.sqrt(scale * laps))
        return np.asarray(np.min(alike, axis=1))

    def _laps(self, size: Array) -> tuple[Array, Array]:
        """Return how many laps of each plan displacements of sizes take, and their scale. Shape (n, 1) to (n, k)."""
        scale = size / self._size
        return np.ceil(np.maximum(scale * (self._bend / self._limit) ** 2 - _SPARE, 1.0)), scale

    def estimates(self, wanted: Array) -> tuple[Array, Array, Array]:
        """Return about the joint travel of displacements by every image of every plan [rad], laps, and scales of a lap.

        Args:
            wanted: The displacements. Shape (n, 4, 4).

        Returns:
            Three arrays of shape (n, images, plans); too many laps cost infinitely much.
        """
        # Instead of many images of each plan, as many of each displacement.
        space = np.zeros((len(self._symmetries), 4, 4))
        space[:, :3, :3], space[:, 3, 3] = self._symmetries, 1.0
        seen = matmul(matmul(np.swapaxes(space, 1, 2), wanted[:, None]), space)
        asked = se3.log(se3.normalised(np.stack([seen, se3.inverse(seen)], axis=1))) * PRICES
        asked = asked.reshape(len(wanted), 2 * len(space), 1, 6)
        size = np.maximum(norm(asked), _FEW)
        apart = norm(asked / size[..., None] - self._does / self._size[:, None])
        laps, scale = self._laps(size)
        apart += np.where(self._travel > _LONG_RAD, apart + _UNEVEN * np.abs(scale / laps - laps / scale), 0.0)
        estimate = self._travel * np.sqrt(scale * laps) * (1.0 + apart)
        return np.where(laps > _MOST_LAPS, np.inf, estimate), laps, scale / laps


@functools.lru_cache(maxsize=64)
def library_for(swimmer: Swimmer) -> MotionLibrary:
    """Return the stored plans for a scaled swimmer, made once."""
    return MotionLibrary(stored_plans(), swimmer)
