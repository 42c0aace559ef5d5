"""Legs along a curve as one motion: on one clock, their drift made up for, and ending exactly.

Each leg is exact to rounding. That its limbs end off by some 1e-12 rad adds up where it repeats, and limbs that begin a
leg off by an angle turn the base by some fifty times as much. So the last leg is brought to the goal once more, from
where those before it end.
"""

from __future__ import annotations

from collections.abc import Sequence

from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.missions.known_legs import Leg
from purcell_cli.planner.reconfiguration import careful_bend_rad
from purcell_cli.planner.rest import of_primitives
from purcell_cli.planner.ways.one_motion import one_motion as in_one_motion


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
    bend_rad = careful_bend_rad(swimmer, Limits())
    return in_one_motion(swimmer, start, goal, [leg.blocks for leg in legs], bend_rad) or every
