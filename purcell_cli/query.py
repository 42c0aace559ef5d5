"""Queries with which nothing is planned, whatever the way: refused before anything is searched."""

from __future__ import annotations

import numpy as np

from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.fluid import refuse_far_bends
from purcell_cli.mechanics.joint_motion import refuse_displacement
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import refuse_wall
from purcell_cli.motion.coordinates import refuse_large
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import PlanOptions


def refuse_query(
    start: Configuration, goal: Configuration, swimmer: Swimmer, options: PlanOptions, called: str = "start"
) -> None:
    """Refuse a start, a goal or an option with which nothing is planned.

    Args:
        start: The start configuration.
        goal: The goal configuration.
        swimmer: The swimmer.
        options: What is asked of the plan.
        called: What the start is called.

    Raises:
        ParameterError: A coordinate too large to be said within the tolerance, a start or goal outside the limits,
            bends that links that feel each other do not have, joints that cannot do it, or a wall.
    """
    limits = Limits.of(options)
    refuse_wall(swimmer)
    for name, configuration in ((called, start), ("goal", goal)):
        refuse_large(swimmer, name, configuration)
        refuse_bent(swimmer, name, configuration)
        limits.refuse(swimmer, name, configuration)
    if not swimmer.ball_joints:
        _refuse_joints(swimmer, start, goal)


def refuse_bent(swimmer: Swimmer, called: str, configuration: Configuration) -> None:
    """Refuse a shape that links that feel each other cannot have.

    Raises:
        ParameterError: A limb is bent too far.
    """
    if swimmer.fluid == "beads":
        refuse_far_bends(float(np.max(bends(configuration.shape[..., 0]))), called)


def _refuse_joints(swimmer: Swimmer, start: Configuration, goal: Configuration) -> None:
    """Refuse what no plan by the joints can do, whatever the way.

    Raises:
        ParameterError: A goal out of reach, or joints that cannot move the base.
    """
    from purcell_cli.lie_brackets.joint_reach import refuse_weak_joints

    refuse_displacement(swimmer, start, goal)
    refuse_weak_joints(swimmer, start.shape)
