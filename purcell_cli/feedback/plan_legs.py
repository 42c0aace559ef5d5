"""The legs of a mission's plan: from waypoint to waypoint, or short ones along a curve."""

from __future__ import annotations

import dataclasses

from purcell_cli.feedback.tracker import Aim
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.missions.on_the_way import blocks_before
from purcell_cli.planner.rest import blocks_after
from purcell_cli.planner.routes.one_motion import ended

_LEG_RAD = 25.0
"""Legs along a curve take about so much joint travel [rad]: about 1 L, in which a model 10 % off misses by 0.1 L."""
_NEAR = 0.15
"""At their ends the swimmer may be off by this part of the curve's tolerance."""


def legs_of(plan: Plan) -> list[Aim]:
    """Return the legs of a mission's plan, in order; each has its plan, which begins where the one before ends."""
    return _through(plan) if plan.follow is None else _along(plan, plan.follow.tolerance_m)


def _through(plan: Plan) -> list[Aim]:
    """Return the legs of a plan through waypoints."""
    out: list[Aim] = []
    here = plan.start
    waypoints = [*(one.waypoint for one in plan.passages), None]
    for waypoint, blocks in zip(waypoints, plan.legs, strict=True):
        end = plan.goal if waypoint is None else waypoint.filled(ended(Plan(plan.swimmer, here, plan.goal, blocks)))
        out.append(Aim(end, waypoint, leg=Plan(plan.swimmer, here, end, blocks)))
        here = end
    return out


def _along(plan: Plan, tolerance_m: float) -> list[Aim]:
    """Return the legs of a plan along a curve with a tolerance."""
    out: list[Aim] = []
    rest = Plan(plan.swimmer, plan.start, plan.goal, plan.blocks)
    slack_l = _NEAR * tolerance_m / plan.swimmer.length_m
    for _ in range(int(plan.joint_travel_rad / _LEG_RAD) - 1):
        before = blocks_before(rest, _LEG_RAD)
        end = ended(dataclasses.replace(rest, blocks=before))
        out.append(Aim(end, _place_of(end), slack_l, Plan(plan.swimmer, rest.start, end, before)))
        rest = Plan(plan.swimmer, end, plan.goal, blocks_after(rest, _LEG_RAD))
    return [*out, Aim(plan.goal, leg=rest)]


def _place_of(end: Configuration) -> Waypoint:
    return Waypoint(end.pose[:3, 3])
