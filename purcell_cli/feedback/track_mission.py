"""Missions tracked: planned once on the model, and swum leg by leg on the truth, measured and planned again between.

Each waypoint ends a leg, and counts as passed in what it names. A plan along a curve is cut into short legs, so that
the swimmer is measured long before it leaves the tolerance; at their ends it need only be near.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

from purcell_cli.errors import ParameterError, PurcellWarning
from purcell_cli.feedback.plan_legs import legs_of
from purcell_cli.feedback.track import Tracking, track
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.missions import plan_mission
from purcell_cli.motion.mission import Mission
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.verdict import Verdict
from purcell_cli.solution import Solution

_TIGHTER = 0.85
"""A curve is planned with this part of its tolerance, if that can be: the rest is for what the model misses by."""


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
    legs = legs_of(dataclasses.replace(made.plan, follow=mission.follow))
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
