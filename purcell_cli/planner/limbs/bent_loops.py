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
from numpy.typing import NDArray

from purcell_cli.errors import GaitError
from purcell_cli.gaits.gait import Gait, Stroke
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.pairs import MeetingPrices, meetings
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.lift import ROUGH
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.gait_sequence import blocks_of, largest_stroke
from purcell_cli.planner.limbs.drawn_ways import DrawnWays
from purcell_cli.planner.limbs.pairs import OuterPhases
from purcell_cli.planner.limbs.straightening import Straightenings
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.refine.active_set import bounded_step
from purcell_cli.planner.refine.exact_arrival import BY_WHOLE_STEPS, CLOSE, FROM_FAR, MARGIN_RAD, Patience, approach
from purcell_cli.planner.refine.inequalities import clearance_rows, least_distances
from purcell_cli.planner.refine.minimum_travel import NAME, Pace, minimise_travel, offered_at
from purcell_cli.planner.refine.segments import segments_of
from purcell_cli.planner.refine.shooting import Equations

BENT_LOOPS = "loops of bent limbs"
"""What such candidates are made of."""
_WAYS = 60
"""To so many of the shortest ways loops are added."""
_PARENTS = 24
"""The ways of so many of the best pairs are varied."""
_ALIKE = 0
"""Pairs that spend the same, or spend and lack the same, to so many digits after the point [rad] are alike."""
PRICES = MeetingPrices(swing=80.0, far=80.0, aside=265.0, along=24.0)
"""What is missing between a way in and a way out: of a rotation [rad per rad], aside, and along a straight way [rad per
L]; three to four times what the shortened motions of twenty queries took, as what misses much does not arrive."""
_MISSING = 120.0
"""Pairs between which more than this is missing, the straight way left out, are not tried [rad]: of 940 pairs of 36
queries all arrived with less than 18, six in ten with less than 60, one in five with up to 120, and none with more."""
_WORTH = 2.2
"""Pairs of which more than so many times what arcs promise is missing and spent are none."""
_DEARER = 1.2
"""Pairs of which more is missing and spent than so many times the least are none."""
_PLACES = 6
"""At so many switches, about evenly apart, every control is offered for a pair to arrive."""
_SOON_RAD, _HARDLY_RAD = 1.0, 3.0
"""Pairs whose first Newton step changes no angle by more than the one are brought to the goal by whole steps, the best
first; where none arrives, pairs below the other by bolder steps, the smallest first step first [rad]. Of 1,200 pairs of
300 queries 97 % arrived by whole steps below 0.1, 80 % up to 0.3, 39 % up to 0.7, 22 % up to 1 and none beyond 3; by
bolder ones 56 % from 0.3 to 0.7, 38 % up to 1 and a quarter up to 2, in half as much time again."""
_COARSE = Accuracy(stages=2, step=4.0, settled=1e-3)
"""On so rough a flow first steps tell arrivals as well as on one of 1e-4, in six tenths of the time."""
_BOLDLY = FROM_FAR._replace(nearly=5.0)
"""How Newton's method goes by bolder steps."""
_FAR_LESS = 0.75
"""Those are for pairs that, with the way between, spend less than this part of what arcs promise."""
_SHORTENED = 0.75
"""Factor by which shortening is estimated to shorten such motions, the straight way left out."""
_TOUCHING_L = 0.01
"""What lacks more than this of the clearance is none: shortening keeps limbs apart, but does not uncross them [L]."""
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
    promised = problem.promised(breadth)
    drawn, pairs = met(problem, breadth)
    most = (breadth.meetings + 1) // 2
    begun: list[tuple[bool, float, Equations]] = []
    tried, out = 0, list[Candidate]()
    for k, (i, j) in enumerate(_unlike(drawn, pairs)):
        if len(out) == breadth.met:
            return out
        way = _between(drawn, problem.wanted, i, j)
        far_less = drawn.joint_travel_rad(i, j) + PRICES.along * abs(way) < _FAR_LESS * promised
        if tried == most and not far_less:
            continue
        motion = _offered(problem, drawn.around(i, _straight(problem, way), j))
        step_rad = _first_step_rad(motion) if k else 0.0  # the best is tried anyhow
        soon = step_rad < _SOON_RAD and tried < most
        if soon:
            tried += 1
            out += _arrived(problem, motion, BY_WHOLE_STEPS, breadth)
        if far_less:
            begun.append((soon, round(step_rad, 9), motion))
    if not out:
        for _, step_rad, motion in sorted(begun, key=lambda one: one[:2])[:most]:
            if len(out) < breadth.met and step_rad < _HARDLY_RAD:
                out += _arrived(problem, motion, _BOLDLY, breadth)
    return out


def _unlike(drawn: OuterPhases, pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the pairs, in order, of those that spend about the same one: the others are hardly different."""
    out: dict[float, tuple[int, int]] = {}
    for pair in pairs:
        out.setdefault(round(drawn.joint_travel_rad(*pair), _ALIKE), pair)
    return list(out.values())


def met(problem: Problem, breadth: Breadth) -> tuple[OuterPhases, list[tuple[int, int]]]:
    """Return ways in and out with loops before them, and pairs of these that all but meet, the best first.

    The ways of the best pairs are varied, a generation after the other.
    """
    ways, rng = problem.ways(breadth.orders), np.random.default_rng(0)
    most_rad = _WORTH * problem.promised(breadth)
    both = [
        DrawnWays.drawn(some[_shortest(some)], loops, breadth.drawn, rng)
        for some, loops in zip((ways.first, ways.last), problem.shape_loops, strict=True)
    ]
    for generation in range(breadth.generations + 1):
        both, made = map(list, zip(*(some.ascending() for some in both), strict=True))
        drawn = OuterPhases(*made)
        last = generation == breadth.generations
        pairs = _meeting(drawn, problem.wanted, most_rad, _MISSING if last else math.inf)
        if last or not pairs:
            break
        best = np.array(pairs[:_PARENTS])
        both = [some.varied(few, breadth.drawn, rng) for some, few in zip(both, best.T, strict=True)]
    return drawn, pairs


def _shortest(ways: Straightenings) -> NDArray[np.int64]:
    """Return the numbers of the ways of least joint travel, to which loops are added."""
    return np.argsort(np.round(ways.joint_travel_rad, 9), kind="stable")[:_WAYS]


def _meeting(drawn: OuterPhases, wanted: Array, most_rad: float, missing_rad: float) -> list[tuple[int, int]]:
    """Return pairs of a way in and a way out between which little is missing, the best first, of those alike one.

    Args:
        drawn: The ways, those out of the least joint travel first.
        wanted: Body displacement of the whole. Shape (4, 4).
        most_rad: What pairs may spend and lack at the most [rad].
        missing_rad: What they may lack at the most, the straight way left out [rad].
    """
    first, last = drawn.first.displacement, matmul(wanted, drawn.last.displacement)
    begin, end = (np.concatenate([g[:, :3, 3], g[:, :3, 0]], axis=1) for g in (first, last))
    spent = drawn.first.joint_travel_rad, drawn.last.joint_travel_rad
    cost, index = meetings(begin, end, *spent, PRICES, most_rad, _DEARER, missing_rad)
    out: dict[float, tuple[int, int]] = {}
    for i in np.argsort(np.round(cost, 9), kind="stable").tolist():
        if index[i] < 0:
            break
        out.setdefault(round(float(cost[i]), _ALIKE), (i, int(index[i])))  # the others differ by how a limb rolls
    return list(out.values())


def _between(drawn: OuterPhases, wanted: Array, i: int, j: int) -> float:
    """Return how long the straight way between way in i and way out j is, negative where it goes backwards [L]."""
    begin, end = drawn.first.displacement[i], matmul(wanted, drawn.last.displacement[j])
    between = end[:3, 3] - begin[:3, 3]
    return math.copysign(math.sqrt(float(matmul(between, between))), float(matmul(between, begin[:3, 0])))


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


def _offered(problem: Problem, blocks: Sequence[Block]) -> Equations:
    """Return the equations of a motion with every control offered at some switches of phases 1 and 3."""
    query = Equations(problem.swimmer, (), problem.start, problem.goal, problem.wanted, ROUGH)
    return query.of(
        [
            s if s.phase == 2 else s.renamed(NAME, offered_at(s.sequence, min(len(s.sequence), _PLACES)))
            for s in segments_of(blocks)
        ]
    )


def _first_step_rad(begun: Equations) -> float:
    """Return the largest change of an angle in the least step to the goal, limits left aside; infinite from too far."""
    values = begun.at_accuracy(_COARSE).at(begun.angles)
    if values.size > FROM_FAR.hopeless:
        return math.inf
    nothing = np.empty(0), np.empty((0, len(begun.angles)))
    step = bounded_step(values.derivative, values.residual, *nothing, reach=math.inf)
    return float(np.max(np.abs(step), initial=0.0))


def _arrived(problem: Problem, begun: Equations, patience: Patience, breadth: Breadth) -> list[Candidate]:
    """Return a motion brought to the goal as a candidate, to be shortened; none where it does not arrive."""
    near, values, off = approach(begun, problem.swimmer.max_bend_rad - MARGIN_RAD, patience)
    if off >= CLOSE:
        return []
    room, _ = clearance_rows(near, values.sequence, values.shapes, least_distances(near, problem.clearance))
    if np.min(room, initial=0.0) <= -_TOUCHING_L:
        return []
    make = functools.cache(functools.partial(_shortened, near, problem.clearance, breadth.bent_pace))
    straight = sum(s.joint_travel_rad for s in near.segments if s.phase == 2)
    return [Candidate(BENT_LOOPS, straight + _SHORTENED * (near.joint_travel_rad - straight), make)]


def _shortened(near: Equations, clearance: float, pace: Pace) -> tuple[Block, ...]:
    """Return the strokes of a motion of less joint travel."""
    short = minimise_travel(near, near.swimmer.max_bend_rad - MARGIN_RAD, pace, clearance)
    return tuple(b for b in short.blocks() if np.any(b.sequence.duration))
