"""Legs along a curve as one motion: on one clock, their drift made up for, and ending exactly.

Each leg is exact to rounding. That its limbs end off by some 1e-12 rad adds up where it repeats, and limbs that begin a
leg off by an angle turn the base by some fifty times as much. So the last leg is brought to the goal once more, from
where those before it end.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from purcell_cli.mechanics.configuration import Configuration, displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step, on_the_clock
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.missions.known_legs import Leg
from purcell_cli.planner.refine.segments import segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Refinement, played
from purcell_cli.planner.rest import of_primitives
from purcell_cli.planner.ways.around import ended


def one_motion(swimmer: Swimmer, start: Configuration, goal: Configuration, legs: Sequence[Leg]) -> tuple[Block, ...]:
    """Return legs one after the other, the last one brought to the goal from where those before it end.

    Args:
        swimmer: The swimmer.
        start: Where they begin.
        goal: Where they end.
        legs: The legs.
    """
    every = tuple(b for leg in legs for b in leg.blocks)
    if len(legs) < 2 or not of_primitives(Plan(swimmer, start, goal, every)):
        return every
    step = clock_step(1.01 * sum(b.duration for b in every) / swimmer.joint_rate_rad_s)
    earlier = tuple(
        dataclasses.replace(b, sequence=on_the_clock(b.sequence, swimmer, step))
        for leg in legs[:-1]
        for b in leg.blocks
    )
    here = ended(Plan(swimmer, start, goal, earlier))
    wanted = flattened(swimmer, displacement_between(here, goal, swimmer.length_m))
    last = Equations(swimmer.scaled(), tuple(segments_of(legs[-1].blocks)), here.shape, goal.shape, wanted, SEARCHING)
    body = dataclasses.replace(swimmer, max_bend_rad=legs[-1].bend_rad)
    refinement = Refinement(body, here, Limits(), "travel", step)
    return earlier + played(refinement.contender(refinement.near(last), "").motion)
