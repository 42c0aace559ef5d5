"""Queries with which nothing is planned, whatever the way: refused before anything is searched."""

from __future__ import annotations

from purcell_cli.errors import ParameterError
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import refuse_displacement
from purcell_cli.mechanics.joints import AT_ONCE, named
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import refuse_wall
from purcell_cli.motion.coordinates import refuse_large
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import Controls, PlanOptions


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
            joints that cannot do it, or a wall.
    """
    limits = Limits.of(options)
    refuse_wall(swimmer)
    for name, configuration in ((called, start), ("goal", goal)):
        refuse_large(swimmer, name, configuration)
        limits.refuse(swimmer, name, configuration)
    if not swimmer.ball_joints:
        _refuse_joints(swimmer, start, goal, options)


def _refuse_joints(swimmer: Swimmer, start: Configuration, goal: Configuration, options: PlanOptions) -> None:
    """Refuse what no plan by the joints can do, whatever the way.

    Raises:
        ParameterError: A goal out of reach, joints that cannot move the base, or simultaneous controls.
    """
    from purcell_cli.lie_brackets.joint_reach import refuse_weak_joints

    refuse_displacement(swimmer, start, goal)
    refuse_weak_joints(swimmer, start.shape)
    if {joint.kind for joint in swimmer.joints} == {"ball", "fixed"}:
        raise ParameterError(
            "swimmer: a universal joint, whose loops close, beside a limb that is fixed, is wanted by the planner as "
            f"it is, found {named(swimmer.joints)}"
        )
    if options.controls == Controls.SIMULTANEOUS and {joint.kind for joint in swimmer.joints}.difference(AT_ONCE):
        raise ParameterError(
            "controls: primitive, since only ball joints and hinges turn at once so far, is wanted, "
            f"found simultaneous with {named(swimmer.joints)}"
        )
