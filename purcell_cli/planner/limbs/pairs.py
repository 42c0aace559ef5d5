"""Pairs of ways to straighten the limbs of the start and of the goal."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.blocks import PHASES, Block
from purcell_cli.planner.limbs.shape_loops import Detours
from purcell_cli.planner.limbs.straightening import DETOURS, Straightenings

_CROSSED = 60
"""Ways to straighten and to bend that are carried on with to where their turns are put between one another."""


_TURNED = 10
"""Those that are carried on with to where detours are made before them."""


_ALIKE = 10
"""How many ways promise about the same, at most."""


Price = Callable[[Array, Array, Array], Array]
"""What phase 2 costs, about [rad]: of a change of heading [rad], a distance [L] and how much of it goes aside [L]."""


def _gone_round(outer: _Outer, round_: Sequence[Detours], wanted: Array, price: Price) -> _Outer:
    """Return the ways in and out that promise most with detours before them, if there are any.

    Args:
        outer: The ways in and out.
        round_: The detours round the start's and round the goal's shape.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
    """
    if not any(len(some.sequence) for some in round_):
        return outer
    few = outer.best(wanted, price, _TURNED)
    for k in range(DETOURS):
        most = _CROSSED if k == DETOURS - 1 else _TURNED
        first = _Outer(round_[0].before(few.first), few.last).best(wanted, price, most).first
        last = _Outer(first, round_[1].before(few.last)).best(wanted, price, most).last
        few = _Outer(first, last)
    return few


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Outer:
    """The ways to straighten the limbs of the start and of the goal: phases 1 and 3."""

    first: Straightenings
    last: Straightenings

    def promised(self, wanted: Array, price: Price) -> tuple[Array, Array]:
        """Return what is left when the limbs are straight, and the joint travel that pairs of ways promise [rad].

        Args:
            wanted: Body displacement of the whole. Shape (4, 4).
            price: What phase 2 costs, about.

        Returns:
            Displacements, shape (n, 4, 4), and joint travel, shape (n, m).
        """
        gone = matmul(se3.inverse(self.first.displacement), wanted)
        done = self.last.displacement  # phase 3 is played backwards, so this is what undoes it
        heading = np.clip(matmul(gone[:, 0, :3], done[:, :3, 0].T), -1.0, 1.0)
        between = matmul(gone[:, :3, :3].reshape(-1, 3), done[:, :3, 3].T)
        position = between.reshape(len(gone), 3, len(done)) + gone[:, :3, 3:]
        distance = np.sqrt(np.add.reduce(position * position, axis=1))
        aside = np.sqrt(np.add.reduce(position[:, 1:] * position[:, 1:], axis=1))
        limbs = self.first.joint_travel_rad[:, None] + self.last.joint_travel_rad
        return gone, price(arccos(heading), distance, aside) + limbs

    def best(self, wanted: Array, price: Price, most: int) -> _Outer:
        """Return the ways that promise most, at the start and at the goal, the best first (see `promised`)."""
        promised = self.promised(wanted, price)[1]
        order = (np.argsort(np.round(promised.min(axis=axis, initial=np.inf), 9), kind="stable") for axis in (1, 0))
        return _Outer(*(ways[row[:most]] for ways, row in zip((self.first, self.last), order, strict=True)))

    def joint_travel_rad(self, i: int, j: int) -> float:
        return float(self.first.joint_travel_rad[i] + self.last.joint_travel_rad[j])

    def around(self, i: int, inner: Sequence[Block], j: int) -> tuple[Block, ...]:
        """Return the strokes of a phase 2 with ways in and out."""
        before, after = self.first.sequence(i), self.last.sequence(j).inverse()
        return (
            *([Block(1, PHASES[1], before)] if len(before) else []),
            *inner,
            *([Block(3, PHASES[3], after)] if len(after) else []),
        )


def _pairs(outer: _Outer, wanted: Array, price: Price, most: int) -> tuple[list[tuple[int, int]], Array]:
    """Return the pairs of ways in and out that promise the least joint travel, and what they leave to be made.

    Args:
        outer: The ways in and out.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
        most: How many.
    """
    gone, promised = outer.promised(wanted, price)
    count = min(_ALIKE * most, promised.size)
    few = np.flatnonzero(promised <= np.partition(promised, count - 1, axis=None)[count - 1])
    # Ways that differ by how a limb rolls promise the same; the first of them will do.
    _, first = np.unique(np.round(promised.ravel()[few], 1), return_index=True)
    best = few[first[:most]]
    pairs = [(int(k // promised.shape[1]), int(k % promised.shape[1])) for k in best]
    return pairs, se3.normalised(np.stack([matmul(gone[i], outer.last.displacement[j]) for i, j in pairs]))
