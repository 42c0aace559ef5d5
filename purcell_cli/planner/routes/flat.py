"""Ways round obstacles in a plane: a swimmer on ball joints does what one on two hinges of an axis does.

Strokes in a plane take no room aside of it, so that in a flat channel they may be large where round ones must be small.
"""

from __future__ import annotations

import dataclasses

from purcell_cli.errors import ParameterError
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import refuse_displacement
from purcell_cli.mechanics.joints import AXES, Joint
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import Limits


def on_hinges(swimmer: Swimmer, start: Configuration, goal: Configuration, limits: Limits) -> Swimmer | None:
    """Return a swimmer on two hinges of one axis in the place of ball joints, if those can lead it to a goal.

    Args:
        swimmer: The swimmer; one on other joints has no other.
        start: The start configuration.
        goal: The goal configuration.
        limits: What start and goal keep.
    """
    for axis in AXES if swimmer.ball_joints else ():
        joints = (Joint("hinge", axis), Joint("hinge", axis))
        body = dataclasses.replace(swimmer, joints=joints)
        try:
            limits.refuse(body, "start", start)
            limits.refuse(body, "goal", goal)
            refuse_displacement(body, start, goal)
        except ParameterError:
            continue
        return body
    return None
