"""A motion that almost arrives, and how widely such motions are searched for."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.refine.minimum_travel import Pace


@dataclasses.dataclass(frozen=True, slots=True)
class Breadth:
    """How widely to search.

    Attributes:
        orders: Pairs of limbs' ways whose turns are put between one another, at the start and at the goal each.
        pairs: Pairs of ways to straighten and to bend that are steered for.
        starts: Starts of the needle, for all pairs together.
        chains: How many of the needle's ways are settled as chains of loops.
        rounds: Rounds in which they settle.
        shorter: Rounds in which every chain tries to do with one cycle fewer of one of its loops.
        words: How many of the word book's entries are tried for short ways.
        pace: How long those that arrive are shortened.
    """

    orders: int = 10
    pairs: int = 12
    starts: int = 96
    chains: int = 4
    rounds: int = 5
    shorter: int = 2
    words: int = 6
    pace: Pace = Pace(rounds=2, steps=10)


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """A motion that almost arrives.

    Attributes:
        words: What it is made of.
        estimate_rad: About its joint travel, or what it spends in the same units [rad].
        make: Makes its strokes.
        astray: Whether it misses by so much that it may not arrive.
    """

    words: str
    estimate_rad: float
    make: Callable[[], tuple[Block, ...]]
    astray: bool = False

    @functools.cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Its strokes."""
        return self.make()

    @property
    def joint_travel_rad(self) -> float:
        """Its joint travel, as estimated as long as its strokes are not made [rad]."""
        made = "blocks" in self.__dict__
        return sum(b.joint_travel_rad for b in self.blocks) if made else self.estimate_rad

    def rank(self, measure: str, swimmer: Swimmer, start: Array) -> tuple[bool, float]:
        """Return what to sort by: whether it is astray, and what it spends from a start shape (`measures.costs`)."""
        spent = self.estimate_rad if measure == "travel" else cost(measure, swimmer, self.blocks, start)
        return self.astray, float(f"{spent:.9e}")
