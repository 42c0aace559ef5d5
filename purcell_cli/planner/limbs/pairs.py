"""Pairs of a phase 1, which straightens the limbs of the start, and a phase 3, which bends them to the goal's shape."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.pairs import PriceNumbers, pair_prices
from purcell_cli.mechanics.lift import SEARCHING, run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES, Block
from purcell_cli.planner.limbs.shape_loops import ShapeLoops
from purcell_cli.planner.limbs.straightening import MOST_LOOPS, Straightenings

INTERLEAVED_FROM = 60
"""How many ways, at the start and at the goal each, go on to the interleaving of their rotations."""
_LOOPED_FROM = 10
"""How many ways, at the start and at the goal each, go on to shape loops before them."""
_ALIKE = 10
"""How many times the wanted pairs are sorted: room for pairs of equal estimates, of which one is kept."""
_MISJUDGED = 0.01
"""By how much the displacement of a way may be out before it is worked out anew [L, rad]; most are by under 1e-4."""


def _least(promised: Array, most: int) -> NDArray[np.int64]:
    """Return the numbers of the least of some promises, the least first."""
    return np.argsort(np.round(promised, 9), kind="stable")[:most]


@frozen_dataclass(eq=False)
class OuterPhases:
    """The ways to straighten the limbs of the start and of the goal: phases 1 and 3.

    Attributes:
        first: Those of the start.
        last: Those of the goal, played backwards.
    """

    first: Straightenings
    last: Straightenings

    def promised(self, wanted: Array, price: PriceNumbers, least_of: int = 0, most_rad: float = math.inf) -> Array:
        """Return the joint travel that pairs of ways promise [rad]; see `pair_prices`.

        Args:
            wanted: Body displacement of the whole. Shape (4, 4).
            price: What phase 2 costs, about.
            least_of: 0 for all pairs, 1 for the best with each of the first, 2 with each of the last, 3 for both.
            most_rad: Of all pairs those that promise more may be told to promise infinitely much [rad].

        Returns:
            Joint travel. Shape (n, m), (n,), (m,) or (n + m,).
        """
        done = self.last.displacement  # phase 3 is played backwards, so this is what undoes it
        spent = self.first.joint_travel_rad, self.last.joint_travel_rad
        return pair_prices(self.left_by_first(wanted), done, *spent, price, least_of, most_rad)

    def left_by_first(self, wanted: Array) -> Array:
        """Return what of a wanted displacement, shape (4, 4), each of the first leaves. Shape (n, 4, 4)."""
        return matmul(se3.inverse(self.first.displacement), wanted)

    def best(self, wanted: Array, price: PriceNumbers, most: int) -> OuterPhases:
        """Return the ways that promise most, at the start and at the goal, the best first (see `promised`)."""
        if len(self.first) == len(self.last) == 1:
            return self
        first, last = np.split(self.promised(wanted, price, 3), [len(self.first)])
        return OuterPhases(self.first[_least(first, most)], self.last[_least(last, most)])

    def best_first(self, wanted: Array, price: PriceNumbers, most: int) -> Straightenings:
        """Return the ways at the start that promise most for a displacement (4, 4), the best first."""
        return self.first[_least(self.promised(wanted, price, 1), most)]

    def best_last(self, wanted: Array, price: PriceNumbers, most: int) -> Straightenings:
        """Return the ways at the goal that promise most for a displacement (4, 4), the best first."""
        return self.last[_least(self.promised(wanted, price, 2), most)]

    def joint_travel_rad(self, i: int, j: int) -> float:
        """Return the joint travel of way i in and way j out [rad]."""
        return float(self.first.joint_travel_rad[i] + self.last.joint_travel_rad[j])

    def around(self, i: int, inner: Sequence[Block], j: int) -> tuple[Block, ...]:
        """Return the strokes of a phase 2 with ways in and out."""
        before, after = self.first.sequence(i), self.last.sequence(j).inverse()
        return (
            *([Block(1, PHASES[1], before)] if len(before) else []),
            *inner,
            *([Block(3, PHASES[3], after)] if len(after) else []),
        )


@frozen_dataclass(eq=False)
class LimbPairs:
    """Pairs of ways in and out, and what each of them leaves to phase 2.

    Attributes:
        ways: The ways.
        index: Which way in and which way out. Shape (n, 2).
        missing: Body displacement between them, in units of L. Shape (n, 4, 4).
    """

    ways: OuterPhases
    index: NDArray[np.int64]
    missing: Array

    def __len__(self) -> int:
        return len(self.index)

    @property
    def joint_travel_rad(self) -> Array:
        """The joint travel of each pair [rad]. Shape (n,)."""
        return np.array([self.ways.joint_travel_rad(i, j) for i, j in self.index.tolist()])

    def around(self, k: int, inner: Sequence[Block]) -> tuple[Block, ...]:
        """Return the strokes of a phase 2 with the ways of pair k in and out."""
        i, j = self.index[k].tolist()
        return self.ways.around(i, inner, j)

    def checked(self, swimmer: Swimmer, shapes: tuple[Array, Array], wanted: Array) -> LimbPairs:
        """Return the pairs with what is missing worked out anew where the ways were misjudged.

        The accuracy by which ways are compared is not enough where a limb passes near the base's line at a large angle,
        and a missing displacement that is far out leads every candidate astray.

        Args:
            swimmer: The swimmer, scaled to L = 1.
            shapes: Shapes at the start and at the goal. Each of shape (2, 3, 3).
            wanted: Body displacement of the whole. Shape (4, 4).
        """
        if not (self.ways.first.joint_travel_rad.any() or self.ways.last.joint_travel_rad.any()):
            return self
        ends = []
        for ways, shape, column in zip((self.ways.first, self.ways.last), shapes, self.index.T, strict=True):
            first, place = distinct(column)
            sequences = [ways.sequence(k) for k in column[first].tolist()]
            pieces, counts = Pieces.together(Pieces.of(s, shape) for s in sequences), [len(s) for s in sequences]
            ends.append(run_displacements(swimmer, pieces, counts, np.ones_like(first), SEARCHING)[place])
        found = se3.normalised(matmul(matmul(se3.inverse(ends[0]), wanted), ends[1]))
        off = np.max(np.abs(se3.log(se3.normalised(matmul(se3.inverse(self.missing), found)))), axis=-1)
        far = (off > _MISJUDGED)[:, None, None]
        return dataclasses.replace(self, missing=np.where(far, found, self.missing))


def best_pairs(outer: OuterPhases, wanted: Array, price: PriceNumbers, most: int) -> LimbPairs:
    """Return the pairs of ways in and out that promise the least joint travel.

    Args:
        outer: The ways in and out.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
        most: How many.
    """
    gone, count = outer.left_by_first(wanted), min(_ALIKE * most, len(outer.first) * len(outer.last))
    # Of so many ways at the start each has a pair that promises no more than this.
    enough = np.sort(outer.promised(wanted, price, 1))[count - 1] if count <= len(outer.first) else math.inf
    promised = outer.promised(wanted, price, most_rad=enough)
    few = np.flatnonzero(promised <= enough)
    few = few[promised.ravel()[few] <= np.partition(promised.ravel()[few], count - 1)[count - 1]]
    # Ways that differ by how a limb rolls promise the same; the first of them will do.
    first, _ = distinct(np.round(promised.ravel()[few], 1))
    index = np.stack(np.divmod(few[first[:most]], promised.shape[1]), axis=1)
    missing = se3.normalised(np.stack([matmul(gone[i], outer.last.displacement[j]) for i, j in index]))
    return LimbPairs(outer, index, missing)


def with_shape_loops(
    outer: OuterPhases, loops: Sequence[ShapeLoops], wanted: Array, price: PriceNumbers
) -> OuterPhases:
    """Return the ways in and out that promise most with shape loops before them, if there are any.

    Args:
        outer: The ways in and out.
        loops: The shape loops round the start's and round the goal's shape.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
    """
    if not any(len(some.sequence) for some in loops):
        return outer
    few = outer.best(wanted, price, _LOOPED_FROM)
    for k in range(MOST_LOOPS):
        most = INTERLEAVED_FROM if k == MOST_LOOPS - 1 else _LOOPED_FROM
        first = OuterPhases(loops[0].before(few.first), few.last).best_first(wanted, price, most)
        last = OuterPhases(first, loops[1].before(few.last)).best_last(wanted, price, most)
        few = OuterPhases(first, last)
    return few
