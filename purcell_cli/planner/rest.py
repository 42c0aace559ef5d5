"""The rest of a plan, from where the swimmer is measured to be: its own remaining strokes, brought to the goal.

Where the swimmer is nearest to the plan's way, the strokes before are left out, and Newton's method changes the angles
of those that remain until they arrive exactly. Where few angles remain, a part of the way is gone back first, which
moves nothing in all, and idle controls are offered between them.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import cast

import numpy as np

from purcell_cli.mechanics.configuration import Configuration, displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.incumbent import Contender
from purcell_cli.planner.library.random_plans import free_segment
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.reconfiguration import careful_bend_rad
from purcell_cli.planner.refine.exact_arrival import Patience, approach
from purcell_cli.planner.refine.minimum_travel import Pace, offering
from purcell_cli.planner.refine.segments import free_primitives, segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Near, Refinement, cycles_apart, played

_ENOUGH_FREE = 40
"""Motions of fewer free angles than this are offered idle controls at every switch."""
BACK_RAD = (0.0, 3.0, 8.0)
"""How far the rests that are tried go back along the way first, where the strokes that are left do not arrive [rad]."""
_TOO_FEW_RAD = 4.0
"""Where less joint travel than this is left, its angles alone are seldom room enough [rad]."""
_PATIENCE = Patience(rounds=4, nearly=0.0)
"""Rounds without a halved residual before a rest is given up: twice those of a candidate, since few are tried."""
_APART = 60
"""Cycles of a repeated stroke may change one by one in a rest that is shortened, up to so many primitives."""
_ASTRAY = 0.3
"""A rest that misses the goal by less is shortened all the same, which may bring it there [L, rad]."""
_EXTRA_RAD, _EXTRA_SHARE = 10.0, 0.1
"""A rest is too long where it is longer by this and this part than what is left; a whole plan for a short way takes
about so much [rad]."""
_WORDS = "the rest of the plan"
"""What a rest is made of."""


def of_primitives(plan: Plan) -> bool:
    """Return whether a plan consists of primitives only."""
    return all(isinstance(b.sequence, PrimitiveSequence) for b in plan.blocks)


def blocks_after(plan: Plan, done_rad: float) -> tuple[Block, ...]:
    """Return the strokes of a plan of primitives that are left after some joint travel [rad], cut where it ends."""
    out: list[Block] = []
    for block in plan.blocks:
        if done_rad <= 0.0:
            out.append(block)
            continue
        once = block.sequence.joint_travel_rad
        cycles = min(int(done_rad / once), block.cycles) if once > 0.0 else block.cycles
        done_rad -= cycles * once
        if cycles == block.cycles:
            continue
        sequence = cast(PrimitiveSequence, block.sequence)
        size = np.abs(sequence.angle)
        left = np.clip(np.cumsum(size) - done_rad, 0.0, size)
        out.append(dataclasses.replace(block, sequence=sequence.with_angles(np.sign(sequence.angle) * left), cycles=1))
        if block.cycles - cycles > 1:
            out.append(dataclasses.replace(block, cycles=block.cycles - cycles - 1))
        done_rad = 0.0
    return tuple(b for b in out if np.any(b.sequence.duration))


def rest(
    way: PlanPath,
    place: int,
    measured: Configuration,
    goal: Configuration,
    limits: Limits,
    back_rad: Sequence[float] = BACK_RAD,
    pace: Pace | None = None,
) -> Plan | None:
    """Return the rest of a plan from a measured configuration to a goal, or None where its strokes do not get there.

    Args:
        way: The plan's way.
        place: Where on the way the swimmer is nearest; see `PlanPath.nearest`.
        measured: Where the swimmer is.
        goal: Where it is to end.
        limits: What the motion must keep besides the bend limit.
        back_rad: How far the rests that are tried, in turn, go back along the way first [rad].
        pace: How long a rest that arrives is shortened; not at all where nothing is said.
    """
    swimmer = way.plan.swimmer
    wanted = flattened(swimmer, displacement_between(measured, goal, swimmer.length_m))
    rolls = _rolls_of(way)
    seen, aim = rolls.seen(measured), rolls.seen(goal)
    query = Equations(swimmer.scaled(), (), seen.shape, aim.shape, wanted, SEARCHING)
    bend_rad = careful_bend_rad(swimmer, limits)
    refinement = Refinement(dataclasses.replace(swimmer, max_bend_rad=bend_rad), seen, limits, "travel")
    left = float(way.travel_rad[place])
    for back in back_rad:
        if left < _TOO_FEW_RAD and back == 0.0 and len(back_rad) > 1:
            continue
        blocks = *way.back_and_forth(place, back), *way.blocks_from(place)
        found = _brought(refinement, query, rolls.unplayed(blocks), pace)
        if found is not None and found.good and found.cost < left + _EXTRA_RAD + _EXTRA_SHARE * left:
            made = Plan(swimmer, seen, aim, played(found.motion), limits=found.report)
            return rolls.played(made, measured, goal)
    return None


def _rolls_of(way: PlanPath) -> QuarterRolls:
    """Return how far a plan's limbs are rolled where they are straight, after phase 2."""
    if not way.plan.swimmer.ball_joints:
        return QuarterRolls()
    phases = np.array([*(b.phase for b in way.plan.blocks), 3])[way.block]
    return QuarterRolls.of_straight(way.shape[int(np.argmax(phases > 2))])


def _brought(
    refinement: Refinement, query: Equations, blocks: tuple[Block, ...], pace: Pace | None
) -> Contender | None:
    """Return strokes brought to the goal, or None where they do not get near."""
    segments = segments_of(blocks)
    if not any(s.free for s in segments):
        segments = [free_segment(PrimitiveSequence.of([])), *segments]
    if free_primitives(segments) < _ENOUGH_FREE:
        segments = offering(segments, query.controls)
    near = Near(*approach(query.of(segments), refinement.bend_rad, _PATIENCE))
    if pace is not None and near.off < _ASTRAY:
        apart = near.motion.of(segments_of(cycles_apart(near.motion, _APART)))
        shorter = refinement.near(refinement.shorter(apart, pace))
        found = refinement.contender(shorter, _WORDS) if shorter.close else None
        if found is not None and found.good:
            return found
    return refinement.contender(near, _WORDS) if near.close else None
