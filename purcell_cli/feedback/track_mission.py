"""Missions tracked: planned once on the model, and swum leg by leg on the truth, measured and planned again between.

Each waypoint ends a leg, and counts as passed in what it names. A plan along a curve is cut into short legs, so that
the swimmer is measured long before it leaves the tolerance; at their ends it need only be near.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

from purcell_cli.errors import ParameterError, PurcellWarning
from purcell_cli.feedback.track import Tracking, track
from purcell_cli.feedback.tracker import Aim
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.missions import plan_mission
from purcell_cli.motion.mission import Mission, Waypoint
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.missions.on_the_way import blocks_before
from purcell_cli.planner.rest import blocks_after
from purcell_cli.planner.routes.one_motion import ended
from purcell_cli.solution import Solution

_TIGHTER = 0.85
"""A curve is planned with this part of its tolerance, if that can be: the rest is for what the model misses by."""
_LEG_RAD = 25.0
"""Legs along a curve take about so much joint travel [rad]: about 1 L, in which a model 10 % off misses by 0.1 L."""
_NEAR = 0.15
"""At their ends the swimmer may be off by this part of the curve's tolerance."""


def track_mission(
    mission: Mission,
    truth: Swimmer,
    *,
    model: Swimmer | None = None,
    options: PlanOptions = PlanOptions(),
    **asked: Any,
) -> Tracking:
    """Plan a mission on a model, swim it on the truth leg by leg, measure, and plan again until each leg arrives.

    Args:
        mission: What is to be done.
        truth: The swimmer that swims.
        model: The swimmer that is planned for; the paper's where none is given.
        options: What is asked of plans.
        asked: What else `track` takes.

    Raises:
        ParameterError: See `plan_mission` and `track`.
    """
    body = model or Swimmer()
    if mission.plain:
        return track(mission.start, mission.goal, truth, model=body, options=options, **asked)
    made = _planned(mission, body, options)
    if made.verdict != Verdict.REACHED:
        text = f"nothing is swum, since the plan of the mission on the model is: {made.verdict}"
        warnings.warn(text, PurcellWarning, stacklevel=2)
        return Tracking(mission.start, mission.goal, truth, (), False, mission.follow)
    legs = _through(made.plan) if mission.follow is None else _along(made.plan, mission.follow.tolerance_m)
    return track(
        mission.start, mission.goal, truth, model=body, options=options, legs=legs, follow=mission.follow, **asked
    )


def _planned(mission: Mission, model: Swimmer, options: PlanOptions) -> Solution:
    """Return the plan of a mission, along a curve with room to the tolerance where there is any."""
    if mission.follow is not None:
        tighter = dataclasses.replace(mission.follow, tolerance_m=_TIGHTER * mission.follow.tolerance_m)
        try:
            found = plan_mission(dataclasses.replace(mission, follow=tighter), swimmer=model, options=options)
        except ParameterError:  # strokes swing farther, or the start is farther from the curve
            found = None
        if found is not None and found.verdict == Verdict.REACHED:
            return found
    return plan_mission(mission, swimmer=model, options=options)


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
