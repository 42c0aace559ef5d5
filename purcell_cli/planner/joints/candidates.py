"""Candidates for swimmers on other joints than balls: chains of loops, and short plans where chains are long.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import home_shape, in_plane, plane_axis
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.joints.chains import Chains, best_loops, chains_for
from purcell_cli.planner.joints.effort import JointBreadth
from purcell_cli.planner.joints.hinge_arcs import arcs_by_hinges
from purcell_cli.planner.joints.loop import Loop
from purcell_cli.planner.joints.loops import Loops, loops_of
from purcell_cli.planner.joints.outer_phases import Way, ways_home
from purcell_cli.planner.library.random_plans import brought, random_plans
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD
from purcell_cli.planner.refine.minimum_travel import NAME, minimise_travel
from purcell_cli.planner.refine.segments import segments_of
from purcell_cli.planner.refine.shooting import Equations

_LOOPS_PLANAR, _LOOPS = 20, 24
"""How many of the best loops chains are made of, in a plane and in space."""
_SHORT_RAD = 60.0
"""Short plans are tried where the best chain takes less joint travel than this, or there is none [rad]."""
_ENOUGH = 48
"""No further pair of ways is looked at where there are so many candidates."""
_MANY_L = 3.0
"""Short plans are tried up to this displacement, where there is no chain [L, rad]."""
_PARTS_L, _MOST_PARTS = (1.0, 0.3, 0.12), 40
"""Where no chain makes a displacement, it is made in equal parts of at most these, in turn, and so many [L, rad]."""
_LONGER = 3
"""Chains of parts have so many loops more: where ranges are one-sided, short ones that do little are rare."""
_MANY_CHAINS = 4
"""So many chains of one pair of ways tell what the next pair's are like."""
_THEN, _HARDLY = " then ", 1.1
"""What stands between the loops of a chain in words, and how much dearer than the best a chain may be to be tried next
since it begins otherwise."""
_LESS = 0.1
"""A chain's fraction of a cycle below this is made by the others."""


def joint_candidates(
    swimmer: Swimmer, start: Array, goal: Array, wanted: Array, breadth: JointBreadth
) -> list[Candidate]:
    """Return motions by the joints that almost make a displacement between two shapes, the best first.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        start: Shape at the beginning. Shape (2, 3, 3).
        goal: Shape at the end. Shape (2, 3, 3).
        wanted: The displacement. Shape (4, 4).
        breadth: How widely to search.
    """
    seed = breadth.seed
    home = home_shape(swimmer, start)
    axis = plane_axis(swimmer)
    rows = tuple(range(6)) if axis is None else in_plane(axis)
    pairs = _outer(swimmer, start, goal, home, wanted)[: breadth.ways]
    found: list[Candidate] = []
    if breadth.arcs and axis is not None:
        for first, last, missing in pairs:
            found += arcs_by_hinges(swimmer, home, missing, breadth.arcs, functools.partial(_around, first, last))
    every = loops_of(swimmer, home) if breadth.chains else None
    if every is not None and len(every.screws):
        best = best_loops(every.screws, rows, _LOOPS if axis is None else _LOOPS_PLANAR)
        pairs_of_loops = np.arange(len(every.screws) - every.pairs, len(every.screws))
        few = every.some(np.unique(np.concatenate([best, pairs_of_loops])) if every.pairs else best)
        counts = (6, 7, breadth.chains) if axis is None else (3, 4, breadth.chains)
        like = None
        for first, last, missing in pairs:
            if len(found) >= _ENOUGH:
                break
            chains = chains_for(few.screws, missing, rows, counts, seed, like)
            like = chains if like is None and len(chains.loops) >= _MANY_CHAINS else like
            if not len(chains.loops):
                chains = _in_parts(few, missing, rows, counts, seed, chains)
            found += list(_of_chains(few, chains, first, last, breadth.kept))
    found.sort(key=lambda c: round(c.estimate_rad, 9))
    least = min((c.estimate_rad for c in found), default=math.inf)
    far = float(np.max(np.abs(se3.log(pairs[0][2]))))
    if breadth.short and (least < _SHORT_RAD or (not found and far < _MANY_L)):
        found += _short_plans(swimmer, start, goal, wanted, pairs, breadth, seed)
    return sorted(found, key=lambda c: (c.astray, round(c.estimate_rad, 9)))


def _in_parts(
    loops: Loops, missing: Array, rows: tuple[int, ...], counts: tuple[int, int, int], seed: int, none: Chains
) -> Chains:
    """Return chains that make a displacement in equal parts, the longest parts that some make; or none."""
    twist, (least, most, tries) = se3.log(missing), counts
    for part in _PARTS_L:
        parts = math.ceil(float(np.max(np.abs(twist))) / part)
        if 1 < parts <= _MOST_PARTS:
            longer = (least + _LONGER, most + _LONGER, tries)
            chains = chains_for(loops.screws, se3.exp(twist / parts), rows, longer, seed)
            if len(chains.loops):
                return chains.times(parts)
    return none


def varied(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Return candidates, the best first, then the best of those that begin with another loop, if it is hardly dearer.

    Chains that begin alike end alike when they are optimised, so the second that is should be of another kind.
    """
    out = sorted(candidates, key=lambda c: round(c.estimate_rad, 9))
    for k, one in enumerate(out[1:], 1):
        if one.estimate_rad > _HARDLY * out[0].estimate_rad:
            break
        if one.words.split(_THEN)[0] != out[0].words.split(_THEN)[0]:
            out.insert(1, out.pop(k))
            break
    return out


def _outer(swimmer: Swimmer, start: Array, goal: Array, home: Array, wanted: Array) -> list[tuple[Way, Way, Array]]:
    """Return pairs of ways home and from home, and the displacement that they leave, the least first."""
    out = []
    for first in ways_home(swimmer, start, home):
        for last in ways_home(swimmer, goal, home):
            # wanted = first missing last^-1
            missing = matmul(matmul(se3.inverse(first.displacement), wanted), last.displacement)
            out.append((first, last, se3.normalised(missing)))
    return sorted(out, key=lambda one: round(float(np.sum(np.abs(se3.log(one[2])))), 9))


def _around(first: Way, last: Way, inner: Iterable[Block]) -> tuple[Block, ...]:
    """Return phase 2 between phases 1 and 3."""
    ahead = [Block(1, f"straighten limb {limb + 1}", part) for limb, part in first.parts]
    behind = [Block(3, f"bend limb {limb + 1}", part.inverse()) for limb, part in reversed(last.parts)]
    return (*ahead, *inner, *behind)


def _of_chains(loops: Loops, chains: Chains, first: Way, last: Way, kept: int) -> Iterator[Candidate]:
    seen = set[str]()
    outer = first.sequence.joint_travel_rad + last.sequence.joint_travel_rad
    for row, cycles, travel in zip(chains.loops, chains.cycles, chains.travel, strict=True):
        parts = [(int(k), float(n)) for k, n in zip(row, cycles, strict=True) if abs(n) > 1e-3]
        words = _THEN.join(f"{max(1, math.ceil(abs(n) - _LESS))} {loops.loops[k].name}" for k, n in parts)
        if words in seen:
            continue
        seen.add(words)
        made = functools.partial(_chain_blocks, loops, tuple(parts), first, last)
        yield Candidate(words or "phases 1 and 3 alone", outer + float(travel), made)
        if len(seen) >= kept:
            return


def _chain_blocks(loops: Loops, parts: tuple[tuple[int, float], ...], first: Way, last: Way) -> tuple[Block, ...]:
    """Return the strokes of a chain, the ways between the corners of its loops as short as they can be."""
    inner: list[Block] = []
    before = EMPTY
    for k, n in parts:
        cycles = max(1, math.ceil(abs(n) - _LESS))
        loop: Loop = loops.loops[k].sized(math.sqrt(abs(n) / cycles))
        between = _between(before, loop.approach)
        if len(between):
            inner.append(Block(2, "to a loop", between))
        inner.append(Block(2, loop.name, loop.cycle if n > 0.0 else loop.cycle.inverse(), cycles))
        before = loop.approach
    if len(before):
        inner.append(Block(2, "from a loop", before.inverse()))
    return _around(first, last, inner)


def _between(before: PrimitiveSequence, after: PrimitiveSequence) -> PrimitiveSequence:
    """Return the way from the corner of a loop to the next one's: each angle once, where angles close one by one."""
    both = before.inverse() + after
    for limb in (0, 1):
        controls = set(both.control[both.limb == limb].tolist())
        if len(controls) > 1 and 6 + limb not in controls:
            return both  # a ball joint's turns do not commute
    order = list(dict.fromkeys(both.control.tolist()))
    sums = [(c, float(np.sum(both.angle[both.control == c]))) for c in order]
    return PrimitiveSequence.of([(c, a) for c, a in sums if abs(a) > 1e-12])


def _short_plans(
    swimmer: Swimmer,
    start: Array,
    goal: Array,
    wanted: Array,
    pairs: list[tuple[Way, Way, Array]],
    breadth: JointBreadth,
    seed: int,
) -> list[Candidate]:
    """Return random plans in place of phase 2 that arrive, the shorter ones made shorter still."""
    bend = swimmer.max_bend_rad - MARGIN_RAD
    bends = tuple(c for c in swimmer.controls if c % 3 or c >= 6)
    arrived: list[tuple[float, int, Equations]] = []
    for k, plan in enumerate(random_plans(breadth.short, seed, bends)):
        first, last, _ = pairs[k % len(pairs)]
        blocks = _around(first, last, [Block(2, NAME, plan.sequence)])
        query = Equations(swimmer, segments_of(blocks), start, goal, wanted, SEARCHING)
        near, off = brought(query, bend)
        if off < CLOSE:
            arrived.append((round(near.joint_travel_rad, 9), k, near))
    arrived.sort(key=lambda one: one[:2])
    out = []
    for _, _, near in arrived[: max(1, breadth.short // 4)]:
        shorter = minimise_travel(near, bend, breadth.pace)
        out.append(Candidate.of("a random short plan, refined", tuple(shorter.blocks())))
    return out
