"""Candidates by loops of bent limbs: phases 1 and 3 do the work, with a straight way between them at the most.

In phases 1 and 3 a limb may bend as far as it does at the start or the goal. Loops at such bends turn the base by up
to five times as much per joint travel as those that phase 2 may make. So many ways in and out are drawn, with a few
shape loops before them, and of all their pairs those are looked for between which hardly more than a straight way is
missing. Newton's method, with every control offered at every switch, makes what is missing by all strokes together.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import cast

import numpy as np

from purcell_cli.errors import GaitError
from purcell_cli.gaits.gait import Gait, Stroke
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.pairs import MeetingPrices, meetings
from purcell_cli.mechanics.lift import ROUGH
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.gait_sequence import blocks_of, largest_stroke
from purcell_cli.planner.limbs.pairs import OuterPhases
from purcell_cli.planner.limbs.straightening import Straightenings
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.refine.exact_arrival import CLOSE, FROM_FAR, MARGIN_RAD, approach
from purcell_cli.planner.refine.minimum_travel import NAME, Pace, minimise_travel, offered_at
from purcell_cli.planner.refine.segments import segments_of
from purcell_cli.planner.refine.shooting import Equations

BENT_LOOPS = "loops of bent limbs"
"""What such candidates are made of."""
_WAYS = 60
"""To so many of the shortest ways loops are added."""
_PRICES = MeetingPrices(swing=45.0, far=45.0, aside=150.0, along=24.0)
"""What is missing between a way in and a way out: of a rotation [rad per rad], aside, and along a straight way [rad per
L]; some twice what the shortened motions of twenty queries took for it, since what misses much does not arrive."""
_WITHIN = 1.7
"""Pairs between which more than so many times their own joint travel is missing, the straight way left out, are not
tried: of 24 queries' two in three with less arrived, and one in six with more."""
_WORTH = 1.25
"""Pairs of which more than so many times what arcs promise is missing and spent are none."""
_DEARER = 1.3
"""Pairs of which more is missing and spent than so many times the least are none."""
_APART = 2
"""Every control is offered after so many rotations."""
_SHORTENED = 0.75
"""Factor by which shortening is estimated to shorten such motions, the straight way left out."""
_SHORT_WAY = 0.1
"""Straight ways below this are left to Newton's method [L]."""


def bent_loops(problem: Problem, breadth: Breadth, known: Sequence[Candidate] = ()) -> list[Candidate]:
    """Return motions by loops of bent limbs, brought to the goal; none where no limb bends far enough for loops.

    Args:
        problem: The problem.
        breadth: How widely to search.
        known: The candidates that are known.
    """
    del known
    if not breadth.meetings or problem.objective != "travel" or not any(len(s.sequence) for s in problem.shape_loops):
        return []
    drawn = OuterPhases(*_drawn(problem, breadth))
    out: list[Candidate] = []
    for i, j, way in _met(drawn, problem.wanted, _WORTH * problem.promised(breadth), breadth.meetings):
        near = _arrived(problem, drawn.around(i, _straight(problem, way), j))
        if near is not None:
            make = functools.cache(functools.partial(_shortened, near, problem.clearance, breadth.bent_pace))
            straight = sum(s.joint_travel_rad for s in near.segments if s.phase == 2)
            rest = near.joint_travel_rad - straight
            out.append(Candidate(BENT_LOOPS, straight + _SHORTENED * rest, make))
            if len(out) == breadth.met:
                break
    return out


def _drawn(problem: Problem, breadth: Breadth) -> list[Straightenings]:
    """Return ways in and out with loops before them, of either the least joint travel first."""
    ways, out = problem.ways(breadth.orders), []
    for some, loops in zip((ways.first, ways.last), problem.shape_loops, strict=True):
        few = some[np.argsort(np.round(some.joint_travel_rad, 9), kind="stable")[:_WAYS]]
        more = loops.drawn(few, breadth.drawn)
        out.append(more[np.argsort(np.round(more.joint_travel_rad, 9), kind="stable")])
    return out


def _met(drawn: OuterPhases, wanted: Array, most_rad: float, most: int) -> list[tuple[int, int, float]]:
    """Return pairs of a way in and a way out between which little is missing, and the straight way between [L].

    Args:
        drawn: The ways.
        wanted: Body displacement of the whole. Shape (4, 4).
        most_rad: What pairs may spend and lack at the most [rad].
        most: How many pairs.
    """
    first, last = drawn.first.displacement, matmul(wanted, drawn.last.displacement)
    begin, end = (np.concatenate([g[:, :3, 3], g[:, :3, 0]], axis=1) for g in (first, last))
    spent = drawn.first.joint_travel_rad, drawn.last.joint_travel_rad
    cost, index = meetings(begin, end, *spent, _PRICES, most_rad, _DEARER, _WITHIN)
    out: list[tuple[int, int, float]] = []
    told: set[float] = set()
    for i in np.argsort(np.round(cost, 9), kind="stable").tolist():
        j, alike = int(index[i]), round(float(cost[i]), 1)
        if j < 0 or alike in told:
            continue  # the same but for how a limb rolls
        told.add(alike)
        between = end[j, :3] - begin[i, :3]
        ahead = float(matmul(between, begin[i, 3:]))
        length = math.copysign(math.sqrt(float(matmul(between, between))), ahead)
        out.append((i, j, length))
        if len(out) == most:
            break
    return out


def _straight(problem: Problem, way: float) -> list[Block]:
    """Return strokes that go about so far straight ahead [L]; none for less than Newton's method makes."""
    cruise = None if abs(way) < _SHORT_WAY else _cruise(tuple(problem.gaits.values()), problem.swimmer)
    if cruise is None:
        return []
    stroke, reach = cruise
    count = math.ceil(abs(way) / abs(reach))
    part = math.sqrt(abs(way) / (count * abs(reach)))
    whole = cast(PrimitiveSequence, stroke.approach), cast(PrimitiveSequence, stroke.cycle)
    aside, cycle = (s.with_angles(part * s.angle) for s in whole)
    if way * reach < 0.0:
        cycle = cycle.inverse()
    return blocks_of(Stroke(stroke.gait, part * stroke.amplitude_rad, aside, cycle), count)


@functools.lru_cache(maxsize=64)
def _cruise(gaits: tuple[Gait, ...], swimmer: Swimmer) -> tuple[Stroke, float] | None:
    """Return the largest stroke of a gait that goes straight ahead, and how far it goes [L]; None where none does."""
    for gait in gaits:
        if gait.moves == "x":
            try:
                stroke = largest_stroke(gait, swimmer)
            except GaitError:
                continue
            return stroke, float(stroke.displacement(swimmer)[0, 3])
    return None


def _arrived(problem: Problem, blocks: Sequence[Block]) -> Equations | None:
    """Return a motion brought to the goal with every control offered at its switches, or None where it is not."""
    query = Equations(problem.swimmer, (), problem.start, problem.goal, problem.wanted, ROUGH)
    segments = [
        s if s.phase == 2 else s.renamed(NAME, offered_at(s.sequence, max(len(s.sequence) // _APART, 1)))
        for s in segments_of(blocks)
    ]
    begun = query.of(segments)
    near, _, off = approach(begun, problem.swimmer.max_bend_rad - MARGIN_RAD, FROM_FAR)
    return near if off < CLOSE else None


def _shortened(near: Equations, clearance: float, pace: Pace) -> tuple[Block, ...]:
    """Return the strokes of a motion of less joint travel."""
    short = minimise_travel(near, near.swimmer.max_bend_rad - MARGIN_RAD, pace, clearance)
    return tuple(b for b in short.blocks() if np.any(b.sequence.duration))
