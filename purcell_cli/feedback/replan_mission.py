"""The rest of a mission's plan: the leg that the swimmer is on is brought to its end, and the legs after it stay.

Where that leg's strokes do not get there within limits, the rest of the mission is planned anew.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.plan_legs import legs_of
from purcell_cli.feedback.replan import Replanned, replan, way_of
from purcell_cli.feedback.tracker import Aim
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.missions import plan_mission
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Mission, Passage
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.rest import of_primitives, rest
from purcell_cli.planning import plan
from purcell_cli.query import refuse_query
from purcell_cli.solution import Solution, carried_out

_TOGETHER = 3
"""Legs along a curve that are brought to their common end at most: ends between them are only marks of the plan's."""


def replan_once(
    made: Plan,
    measured: Configuration,
    options: PlanOptions = PlanOptions(),
    *,
    after_rad: float = 0.0,
    progress: Progress = silent,
) -> Replanned:
    """Return the rest of a plan; one that moves nothing, or all joints at once, is planned anew. See `replan`.

    What is left of a mission passes the waypoints that are left, or follows what is left of the curve.

    Raises:
        ParameterError: See `planning.plan`, and a place farther from the curve than its tolerance.
    """
    refuse_query(measured, made.goal, made.swimmer, options, "measured")
    if made.passages or made.follow is not None:
        return _mission(made, measured, options, after_rad, progress)
    way = way_of(made)
    if way is not None:
        return replan(way, measured, options, after_rad=after_rad, progress=progress)
    whole = plan(measured, made.goal, swimmer=made.swimmer, options=options, progress=progress)
    return Replanned(whole, False, done_rad=after_rad, left_rad=made.joint_travel_rad - after_rad)


def _mission(
    made: Plan, measured: Configuration, options: PlanOptions, after_rad: float, progress: Progress
) -> Replanned:
    """Return the rest of a mission's plan; arguments as of `replan_once`."""
    _refuse_off_curve(made, measured)
    legs = legs_of(made)
    before = np.cumsum([0.0, *(_travel_rad(one) for one in legs)])
    k, way, place, off = _nearest(legs, before, measured, after_rad)
    if way is None:
        done = float(before[k])
    else:
        done = float(before[k] + way.travel_rad[0] - way.travel_rad[place])
        figures = off, done, float(before[-1]) - done
        found = _kept(made, legs, k, way, place, measured, options)
        if found is not None:
            return Replanned(found, True, *figures)
    whole = _anew(made, k, done, measured, options, progress)
    return Replanned(whole, False, None if way is None else off, done, float(before[-1]) - done)


def _refuse_off_curve(made: Plan, measured: Configuration) -> None:
    if made.follow is None:
        return
    off = float(made.follow.curve.distance_m(measured.pose[None, :3, 3])[0])
    if off > made.follow.tolerance_m:
        wanted = f"a position within {made.follow.tolerance_m:g} m of the curve"
        raise ParameterError(f"measured: {wanted} is wanted, found one {off:.6g} m from it")


def _travel_rad(one: Aim) -> float:
    return 0.0 if one.leg is None else one.leg.joint_travel_rad


def _nearest(
    legs: Sequence[Aim], before: np.ndarray, measured: Configuration, after_rad: float
) -> tuple[int, PlanPath | None, int, float]:
    """Return the leg that is nearest to a configuration, its way, the place on it and how far off [L, rad].

    Without a way, where legs are not of primitives alone, it is the leg on which the joint travel that is made ends.
    """
    made = min(int(np.searchsorted(before, after_rad, "right")) - 1, len(legs) - 1)
    best: tuple[int, PlanPath | None, int, float] = (made, None, 0, np.inf)
    if not all(one.leg is not None and of_primitives(one.leg) for one in legs):
        return best[0], None, 0, 0.0
    for k in range(made, len(legs)):
        leg = legs[k].leg
        way = None if leg is None else way_of(leg)
        if way is None:
            continue
        place, off = way.nearest(measured, legs[k].goal, max(after_rad - float(before[k]), 0.0))
        if round(off, 9) < round(best[3], 9):
            best = k, way, place, off
    return best


def _kept(
    made: Plan,
    legs: Sequence[Aim],
    k: int,
    way: PlanPath,
    place: int,
    measured: Configuration,
    options: PlanOptions,
) -> Solution | None:
    """Return the rest made of the plan's own strokes; None where those of the leg at hand do not arrive in limits."""
    most = 1 if made.follow is None else _TOGETHER
    limits = dataclasses.replace(Limits.of(options), clock_s=clock_step(made.duration_s))
    for last in range(k, min(k + most, len(legs))):
        if last > k:
            blocks = [b for one in legs[k : last + 1] if one.leg is not None for b in one.leg.blocks]
            longer = Plan(made.swimmer, way.plan.start, legs[last].goal, tuple(blocks))
            way = PlanPath.of(longer)
            place, _ = way.nearest(measured, legs[last].goal)
        first = rest(way, place, measured, legs[last].goal, limits)
        if first is None:
            continue
        found = carried_out(_whole(made, measured, first.blocks, legs, last), options)
        if found.verdict == Verdict.REACHED:
            return found
    return None


def _whole(made: Plan, measured: Configuration, first: Sequence[Block], legs: Sequence[Aim], last: int) -> Plan:
    """Return the rest as one plan: strokes up to the end of a leg, and the legs after it as they are."""
    blocks, passages = list(first), []
    for j in range(last, len(legs)):
        leg = legs[j].leg
        if j > last and leg is not None:
            blocks += leg.blocks
        if j < len(made.passages):
            passages.append(dataclasses.replace(made.passages[j], block=len(blocks)))
    return Plan(made.swimmer, measured, made.goal, tuple(blocks), passages=tuple(passages), follow=made.follow)


def _anew(
    made: Plan, k: int, done_rad: float, measured: Configuration, options: PlanOptions, progress: Progress
) -> Solution:
    """Return the rest of a mission planned anew, from the k-th leg on; arguments as of `replan_once`."""
    left: tuple[Passage, ...] = made.passages[k:]
    follow = made.follow
    if follow is not None:
        near_m = follow.curve.length_m * done_rad / made.joint_travel_rad if made.blocks else 0.0
        curve = follow.curve.rest(measured.pose[:3, 3], near_m)
        follow = None if curve is None else dataclasses.replace(follow, curve=curve)
    mission = Mission(measured, made.goal, tuple(one.waypoint for one in left), follow=follow)
    found = plan_mission(mission, swimmer=made.swimmer, options=options, progress=progress)
    passages = tuple(dataclasses.replace(one, index=left[one.index].index) for one in found.plan.passages)
    return dataclasses.replace(found, plan=dataclasses.replace(found.plan, passages=passages))
