"""Legs as one motion: on one clock, and the last one brought to the goal from where those before it end.

Each leg is exact to rounding. That its limbs end off by some 1e-13 rad adds up, since limbs that begin a leg off by an
angle turn the base by some fifty times as much.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.mechanics.configuration import Configuration, displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements, starting_shapes
from purcell_cli.motion.clock import clock_step, on_the_clock
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.refine.segments import segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Refinement, played


def one_motion(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    legs: Sequence[Sequence[Block]],
    bend_rad: float,
    limits: Limits | None = None,
) -> tuple[Block, ...] | None:
    """Return legs one after the other that end at the goal; None where the last one does not get there in limits.

    Args:
        swimmer: The swimmer.
        start: Where they begin.
        goal: Where they end.
        legs: The blocks of each; of primitives.
        bend_rad: The bend limit of the last one's strokes [rad].
        limits: What the last one must keep.
    """
    every = tuple(b for leg in legs for b in leg)
    if len(legs) < 2:
        return every
    step = clock_step(1.01 * sum(b.duration for b in every) / swimmer.joint_rate_rad_s)
    earlier = tuple(
        dataclasses.replace(b, sequence=on_the_clock(b.sequence, swimmer, step)) for leg in legs[:-1] for b in leg
    )
    here = ended(Plan(swimmer, start, goal, earlier))
    wanted = flattened(swimmer, displacement_between(here, goal, swimmer.length_m))
    last = Equations(swimmer.scaled(), tuple(segments_of(legs[-1])), here.shape, goal.shape, wanted, SEARCHING)
    body = dataclasses.replace(swimmer, max_bend_rad=bend_rad)
    refinement = Refinement(body, here, dataclasses.replace(limits or Limits(), clock_s=step), "travel")
    found = refinement.contender(refinement.near(last), "")
    return earlier + played(found.motion) if found.good else None


def ended(plan: Plan) -> Configuration:
    """Return where a plan ends, by the planner's own flow."""
    if not plan.blocks:
        return plan.start
    moves = block_displacements(plan.swimmer, plan.blocks, plan.start.shape)
    pose = se3.normalised(matmul(plan.start.pose, se3.prefix_products(moves)[-1]))
    return Configuration(pose, starting_shapes(plan.blocks, plan.start.shape)[-1])
