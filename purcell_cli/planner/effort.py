"""How long to look for a shorter plan."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from purcell_cli.planner.candidate import Breadth
from purcell_cli.planner.refine.minimum_travel import Pace


@dataclasses.dataclass(frozen=True, slots=True)
class Effort:
    """How long to look for a shorter plan.

    Attributes:
        candidates: How many of the search's motions are carried on with.
        pace: How long their strokes are optimised together; None for not at all.
        finalists: How many of the shortest are optimised further.
        last: How long those are.
        most: Cycles are told apart, each free to change, up to so many primitives.
        longest_rad: Motions of more joint travel are not optimised [rad].
        words: How many random words are tried too, for a phase 2 of little joint travel.
        breadth: How widely motions are searched for.
    """

    candidates: int
    pace: Pace | None = None
    finalists: int = 0
    last: Pace = Pace(rounds=12, steps=60, price=300.0)
    most: int = 0
    longest_rad: float = math.inf
    words: int = 0
    breadth: Breadth = Breadth()


EFFORTS: Mapping[str, Effort] = {
    "quick": Effort(1, breadth=Breadth(chains=1, rounds=4, shorter=0, words=4, pace=Pace(1, 6))),
    "standard": Effort(1, Pace(rounds=3, steps=12), most=24, longest_rad=16.0),
    "thorough": Effort(
        8,
        Pace(rounds=3, steps=40, price=300.0),
        finalists=3,
        most=60,
        words=32,
        breadth=Breadth(orders=40, pairs=48, starts=1152, chains=24, rounds=24, shorter=8, words=24, pace=Pace(3, 30)),
    ),
}


_WIDE = Effort(1, breadth=Breadth(pairs=36, starts=432, chains=24, rounds=20, shorter=0, words=24))
"""How to look where nothing arrives otherwise."""
