"""Known strokes brought to a goal by Newton's method, though they begin or end a little elsewhere than before."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from purcell_cli.mechanics.configuration import Configuration, displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.reconfiguration import careful_bend_rad
from purcell_cli.planner.refine.exact_arrival import Patience, approach
from purcell_cli.planner.refine.minimum_travel import Pace, offering
from purcell_cli.planner.refine.segments import free_primitives, segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Near, Refinement, played

_PATIENCE = Patience(rounds=8, nearly=0.0)
"""Rounds without a halved residual before strokes are given up: they are few, and often at their bend limit."""

_MOST_OFFERED = 150
"""Strokes of more primitives are not offered other controls [1]."""
_PACE = Pace(rounds=1, steps=12, longest=0)
"""How long strokes that were offered other controls are shortened."""


def brought(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    blocks: Sequence[Block],
    limits: Limits | None = None,
) -> Plan | None:
    """Return strokes of primitives changed until they lead from a start to a goal; None where they do not get there.

    Args:
        swimmer: The swimmer.
        start: Where they begin.
        goal: Where they are to end.
        blocks: The strokes.
        limits: What the motion must keep besides the bend limit.
    """
    kept_to = limits or Limits()
    wanted = flattened(swimmer, displacement_between(start, goal, swimmer.length_m))
    motion = Equations(swimmer.scaled(), segments_of(blocks), start.shape, goal.shape, wanted, SEARCHING)
    careful = dataclasses.replace(swimmer, max_bend_rad=careful_bend_rad(swimmer, kept_to))
    refinement = Refinement(careful, start, kept_to, "travel")
    near = Near(*approach(motion, refinement.bend_rad, _PATIENCE))
    if not near.close and free_primitives(motion.segments) <= _MOST_OFFERED:
        every = motion.of(offering(motion.segments, motion.controls))
        near = Near(*approach(every, refinement.bend_rad, _PATIENCE))
        if near.close:
            near = refinement.near(refinement.shorter(near.motion, _PACE))
    found = refinement.contender(near, "") if near.close else None
    if found is None or not found.good:
        return None
    return Plan(swimmer, start, goal, played(found.motion), limits=found.report)
