"""Drawn ways: ways to straighten the limbs with shape loops before them, drawn at random and varied one part at a time.

There are thousands of millions of such ways. The best of a few hundred, varied, and the best of those again, leave
less to be made than the best of as many thousands that are drawn anew (a genetic algorithm without recombination).

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.planner.limbs.shape_loops import ShapeLoops
from purcell_cli.planner.limbs.straightening import MOST_LOOPS, Straightenings


@frozen_dataclass(eq=False)
class DrawnWays:
    """Straightenings with shape loops before them, by number.

    Attributes:
        ways: The straightenings that there are.
        loops: The shape loops that there are.
        way: Which straightening. Shape (n,).
        loop: Which shape loops come before it, one after the other; 0 is none. Shape (n, 3).
    """

    ways: Straightenings
    loops: ShapeLoops
    way: NDArray[np.int64]
    loop: NDArray[np.int64]

    @classmethod
    def drawn(cls, ways: Straightenings, loops: ShapeLoops, most: int, rng: np.random.Generator) -> DrawnWays:
        """Return all straightenings, and as many as asked with one, two or three loops before, if there are any.

        Args:
            ways: The straightenings.
            loops: The shape loops.
            most: How many with loops.
            rng: Draws them.
        """
        every, n = np.arange(len(ways)), len(loops.sequence)
        alone = cls(ways, loops, every, np.zeros((len(ways), MOST_LOOPS), dtype=np.int64))
        if not n:
            return alone
        place, many = np.arange(MOST_LOOPS), np.arange(most) % MOST_LOOPS
        loop = np.where(place <= many[:, None], rng.integers(1, n + 1, (most, MOST_LOOPS)), 0)
        return alone._and(rng.integers(len(ways), size=most), loop)

    def varied(self, few: NDArray[np.int64], most: int, rng: np.random.Generator) -> DrawnWays:
        """Return some of the ways, and as many as asked that differ from one of them by a loop or the straightening.

        Args:
            few: Which. Shape (k,).
            most: How many differ.
            rng: Draws which, and what is different.
        """
        some = DrawnWays(self.ways, self.loops, self.way[few], self.loop[few])
        own, n = rng.integers(len(few), size=most), len(self.loops.sequence)
        way, loop = some.way[own], some.loop[own]
        place = rng.integers(0 if n else MOST_LOOPS, MOST_LOOPS + 1, most)
        changed = np.arange(MOST_LOOPS) == place[:, None]
        loop = np.where(changed, rng.integers(0, n + 1, most)[:, None], loop)
        way = np.where(place == MOST_LOOPS, rng.integers(len(self.ways), size=most), way)
        return some._and(way, loop)

    def ascending(self) -> tuple[DrawnWays, Straightenings]:
        """Return the ways, of the least joint travel first, and what they are."""
        made = self.loops.before_each(self.ways, self.way, self.loop)
        order = np.argsort(np.round(made.joint_travel_rad, 9), kind="stable")
        return DrawnWays(self.ways, self.loops, self.way[order], self.loop[order]), made[order]

    def _and(self, way: NDArray[np.int64], loop: NDArray[np.int64]) -> DrawnWays:
        """Return these and more."""
        return DrawnWays(self.ways, self.loops, np.concatenate([self.way, way]), np.concatenate([self.loop, loop]))
