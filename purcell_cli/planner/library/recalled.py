"""Candidates by plans of the motion library that Newton's method brings to the goal."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.pairs import PriceNumbers
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import ROUGH
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.library.plan_library import library_for
from purcell_cli.planner.library.random_plans import free_segment
from purcell_cli.planner.limbs.pairs import LimbPairs, best_pairs
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.refine.exact_arrival import CLOSE, FROM_FAR, MARGIN_RAD, approach
from purcell_cli.planner.refine.minimum_travel import NAME, Pace, merged, minimise_travel, offered, offered_at
from purcell_cli.planner.refine.shooting import Equations

LIBRARY_PLAN = "a library plan"
"""What such candidates are made of."""
_OFFERED = 6
"""At so many switches of a library plan every control is offered for it to arrive."""
_TRIED = 3
"""So many times the library plans that are wanted are tried; some do not arrive by their own primitives."""
_SHORTENED = 1.05
"""Factor by which refinement is estimated to shorten a library plan that arrives."""
_WAYS_RAD = 12.0
"""What arcs take besides what they promise [rad]: the ways in and out of three loops, more than all else for a slight
turn."""
_PRICE = PriceNumbers(turn1=374.0, way1=445.0)
"""Estimated joint travel by a library plan: the roots of the price of pitch and yaw in `PRICES` per small change of
heading, and of the mean over directions per small distance [rad^2 per rad or L]."""


def library_plans(problem: Problem, breadth: Breadth, known: Sequence[Candidate] = ()) -> list[Candidate]:
    """Return motions by library plans, brought to the goal, that promise to be shorter than what is known.

    Args:
        problem: The problem.
        breadth: How widely to search.
        known: The candidates that are known.
    """
    swimmer = problem.swimmer
    least = min((c.estimate_rad for c in known if not c.astray), default=math.inf)
    if problem.objective == "travel":
        least = min(least, breadth.library_below * problem.promised(breadth) + _WAYS_RAD)
    pairs = best_pairs(problem.one_by_one, problem.wanted, _PRICE, breadth.pairs)
    around = pairs.joint_travel_rad
    entries = library_for(swimmer).nearest(pairs.missing, around, _TRIED * breadth.library_plans, least)
    first, again = itertools.tee(entries)
    for offering, tried in ((False, first), (True, itertools.islice(again, breadth.library_plans))):
        out: list[Candidate] = []
        for entry in tried:
            if len(out) == breadth.library_plans or entry.estimate_rad > least:
                break
            each = se3.exp(se3.log(pairs.missing[entry.wanted]) / entry.laps)
            near, off = _arrived(swimmer, entry.lap, each, offering)
            if off < CLOSE:
                make = functools.partial(_shortened, near, entry.laps, breadth.pace, pairs, entry.wanted)
                travel = float(around[entry.wanted]) + entry.laps * near.joint_travel_rad / _SHORTENED
                out.append(Candidate(LIBRARY_PLAN, travel, functools.cache(make)))  # it takes a while
                least = min(least, travel)
        if out:
            return out
    return []


def _arrived(swimmer: Swimmer, lap: PrimitiveSequence, each: Array, offering: bool) -> tuple[Equations, float]:
    """Return a lap brought to a displacement, and what it misses by [L, rad].

    Args:
        swimmer: The swimmer, scaled to L = 1.
        lap: The lap.
        each: The displacement. Shape (4, 4).
        offering: Whether every control is offered at every switch, not only at a few.
    """
    empty, bend = Equations(swimmer, (), COLLINEAR, COLLINEAR, each, ROUGH), swimmer.max_bend_rad - MARGIN_RAD
    begun = empty.of([free_segment(offered(lap, 1) if offering else offered_at(lap, _OFFERED))])
    near, _, off = approach(begun, bend, FROM_FAR)
    return near.of([free_segment(merged(near.sequence))]), off


def _shortened(lap: Equations, laps: int, pace: Pace, pairs: LimbPairs, pair: int) -> tuple[Block, ...]:
    """Return the strokes of a plan that arrives, in as many laps; where they are several, each is shortened."""
    if laps > 1:  # a single one is shortened with all the rest
        lap = minimise_travel(lap, lap.swimmer.max_bend_rad - MARGIN_RAD, pace)
    return pairs.around(pair, [Block(2, NAME, lap.sequence.times(laps))])
