"""Efforts: the stages of a search, and how many candidates each stage looks for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.planner.refine.minimum_travel import Pace

LAST = Pace(rounds=12, steps=60, price=300.0, longest=300, work=4000, entering=6, own=True)
"""How long the best motions of a thorough search are optimised in the end."""


@frozen_dataclass
class Breadth:
    """How widely candidates are looked for.

    Attributes:
        orders: Pairs of limbs' ways whose rotations are put between one another, at the start and at the goal each.
        pairs: Pairs of ways to straighten and to bend the limbs that are steered for.
        starts: Starts of needle steering, for all pairs together.
        chains: How many of the steered ways are settled as chains of loops.
        rounds: Rounds in which they settle.
        shorter: Rounds in which every chain tries to do with one cycle fewer of one of its loops.
        arcs_from: Arcs are made at once where what is known takes more than this part of what they promise.
        library_below: Library plans are tried where they promise less than so many times what arcs promise.
        longer: Parts by which the cycles of every chain grow, one after the other, while none is settled.
        library_plans: How many of the library's plans are tried.
        pace: How long library plans that arrive are shortened.
        drawn: How many ways in and out with shape loops before them are drawn, and in each generation after that.
        generations: How often the ways of the best pairs are varied.
        meetings: How many pairs of these, between which little is missing, are brought to the goal.
        met: Of so many that arrive, no more are.
        bent_pace: How long they are shortened.
    """

    orders: int = 10
    pairs: int = 12
    starts: int = 96
    chains: int = 4
    rounds: int = 5
    shorter: int = 2
    arcs_from: float = 0.7
    library_below: float = 1.25
    longer: tuple[float, ...] = ()
    library_plans: int = 4
    pace: Pace = Pace(rounds=2, steps=20, longest=40, worth=1e-3)
    drawn: int = 100
    generations: int = 6
    meetings: int = 5
    met: int = 1
    bent_pace: Pace = Pace(rounds=1, steps=6, longest=0, own=True)


@frozen_dataclass
class Stage:
    """A stage of the search: which candidates it makes, and what it does with them.

    Attributes:
        breadth: How widely candidates are looked for.
        candidates: How many of them are refined; more where none of these arrives within limits.
        rivals: How many more are refined where they are short and seem hardly longer than the best plan.
        pace: How long the strokes of each are optimised together; None for not at all.
        rungs: How many of the shortest are optimised further, and how long, again and again.
        longest_rad: Motions of more joint travel are not optimised that long [rad].
        brief: How long motions of more than that are optimised; None for not at all.
        largest: Motions of more free primitives than this are not optimised.
        most_apart: Cycles of a repeated stroke may change one by one, up to so many primitives in a motion.
        random_plans: How many random plans are tried too, where phase 2 takes little joint travel.
        last_resort: Whether it is for when nothing arrives before it; the earlier candidates are then dropped.
        interrupt_keeps_best: Whether an interrupt ends the search with the best plan so far, if one arrives in limits.
    """

    breadth: Breadth = Breadth()
    candidates: int = 1
    rivals: int = 0
    pace: Pace | None = None
    rungs: tuple[tuple[int, Pace], ...] = ()
    longest_rad: float = math.inf
    brief: Pace | None = None
    largest: float = math.inf
    most_apart: int = 0
    random_plans: int = 0
    last_resort: bool = False
    interrupt_keeps_best: bool = False

    def pace_of(self, joint_travel_rad: float) -> Pace | None:
        """Return how long motions of so much joint travel [rad] are optimised; None for not at all."""
        return self.pace if joint_travel_rad < self.longest_rad else self.brief

    @property
    def trials(self) -> int:
        """How many motions it refines, unless candidates fail."""
        return self.candidates + sum(count for count, _ in self.rungs) + self.random_plans


_QUICK = Stage(Breadth(chains=1, rounds=4, shorter=0, pace=Pace(1, 6), meetings=0))
"""A quick search: one chain of loops, and nothing is optimised together."""
_STANDARD = Stage(
    rivals=2,
    pace=Pace(rounds=3, steps=30, longest=40, entering=6, worth=1e-3),
    longest_rad=20.0,
    brief=Pace(rounds=2, steps=15, work=1800, entering=1, worth=2e-3, own=True),
    largest=300,
    most_apart=24,
)
"""A standard search: the best candidate, or up to three, optimised, below 20 rad for longer."""
_THOROUGH = Stage(
    Breadth(
        arcs_from=0.0,
        orders=40,
        pairs=48,
        starts=1152,
        chains=24,
        rounds=24,
        shorter=8,
        library_plans=24,
        pace=Pace(3, 30),
        drawn=600,
        generations=10,
        meetings=60,
        met=12,
    ),
    candidates=14,
    pace=Pace(rounds=3, steps=30, price=300.0, longest=300, work=4000, own=True),
    rungs=((5, Pace(rounds=3, steps=40, price=300.0, longest=300, work=4000, entering=4, own=True)), (2, LAST)),
    most_apart=60,
    random_plans=20,
    interrupt_keeps_best=True,
)
"""The second stage of a thorough search: more candidates of each kind, the shorter ones optimised for longer."""
_WIDE = Stage(
    Breadth(
        arcs_from=0.0,
        library_below=math.inf,
        pairs=36,
        starts=432,
        chains=24,
        rounds=20,
        shorter=0,
        longer=(0.15, 0.3, 0.6, 1.2),
        library_plans=24,
    ),
    last_resort=True,
)
"""The last resort of a quick or standard search: more starts, chains and rounds, so that something arrives."""
_EARLY = dataclasses.replace(_STANDARD, interrupt_keeps_best=True)
"""The first stage of a thorough search: the standard one, so that a plan is there early and never gets longer."""

_ONE_LEG = Stage(Breadth(starts=48, chains=1, rounds=4, shorter=0, library_plans=1, pace=Pace(1, 4), meetings=0))
"""The search for a leg: quicker still, as a way takes many of them."""
LEG = "leg"
"""The effort of a leg round obstacles."""

_AGAIN = Stage(
    dataclasses.replace(
        _THOROUGH.breadth,
        arcs_from=0.7,
        library_plans=4,
        pace=Pace(2, 10, longest=40),
        drawn=100,
        generations=6,
        meetings=5,
        met=1,
    ),
    pace=Pace(rounds=2, steps=30, price=300.0, longest=300, work=4000, own=True),
    most_apart=60,
)
"""The second stage of the search for the rest of a way on which the swimmer is measured: as wide as a thorough one, but
only the best candidate is optimised. It takes half a second, and plans of 0.3 to 3 L are 4 to 10 % shorter for it."""
AGAIN = "again"
"""The effort of whole plans that are made on the way, after what was measured."""

EFFORTS: Mapping[str, tuple[Stage, ...]] = {
    "quick": (_QUICK, _WIDE),
    "standard": (_STANDARD, _WIDE),
    "thorough": (_EARLY, _THOROUGH),
    LEG: (_ONE_LEG, _WIDE),
    AGAIN: (_STANDARD, _AGAIN, _WIDE),
}
"""The stages of each effort, in order; of a leg round obstacles and of plans on the way too."""
