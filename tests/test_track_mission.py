"""Missions tracked: legs arrive in what their waypoints name, where the plan alone misses, and curves are kept to."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
from helpers import assert_close

from purcell_cli import Configuration, Curve, Follow, Mission, PlanOptions, Swimmer, Waypoint, plan_mission
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Sphere
from purcell_cli.errors import ParameterError, PurcellWarning
from purcell_cli.feedback.plan_legs import _along
from purcell_cli.feedback.simulate import simulate
from purcell_cli.feedback.track_mission import track_mission
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.motion.obstacle_distance import link_radii, link_segments
from purcell_cli.motion.trajectory import as_table
from purcell_cli.planning import planned
from purcell_cli.solution import Solution

TRUTH = Swimmer(drag_ratio=1.6)
QUICK = PlanOptions(effort="quick")
START = Configuration()


@pytest.mark.slow
def test_each_leg_arrives_in_what_its_waypoint_names() -> None:
    limb = about_axis(2, 0.2)
    via = (Waypoint(np.array([0.01, 0.0, 0.0])), Waypoint(limb1=limb))
    mission = Mission(START, Configuration.from_angles((0.02, 0.0, 0.0)), via)
    found = track_mission(mission, TRUTH, options=QUICK)
    assert found.arrived
    last = {part.leg: part for part in found.parts}
    assert sorted(last) == [0, 1, 2]
    assert_close(last[0].end.pose[:3, 3], via[0].position_m, 1e-3 * TRUTH.length_m)
    assert_close(last[1].end.shape[0], limb, 1e-9)
    assert_close(last[2].end.pose[:3, 3], mission.goal.pose[:3, 3], 1e-3 * TRUTH.length_m)
    assert found.replans == len(found.parts) - 3
    alone = simulate(as_table(plan_mission(mission, options=QUICK).trajectory), TRUTH)
    assert alone.off.position_m > 1e-3 * TRUTH.length_m


def test_a_plan_along_a_curve_is_cut_into_legs_that_are_the_whole() -> None:
    plan = planned(START, Configuration.from_angles((0.5, 0.0, 0.0)), options=QUICK)
    legs = [(aim, aim.leg) for aim in _along(plan, 0.07) if aim.leg is not None]
    assert len(legs) > 2
    assert_close(sum(leg.joint_travel_rad for _, leg in legs), plan.joint_travel_rad, 1e-9)
    for (aim, before), (_, after) in itertools.pairwise(legs):
        shape = starting_shapes(before.blocks, before.start.shape)[-1]
        assert_close(after.start.shape, shape, 1e-12)
        beside = se3.pose(np.eye(3), np.array([0.0, 0.01, 0.0]))
        assert aim.off(Configuration(after.start.pose, shape)).position_m == 0.0
        assert aim.off(Configuration(matmul(beside, after.start.pose), shape)).position_m > 0.009
    assert_close(legs[-1][0].goal.pose, plan.goal.pose, 0.0)


@pytest.mark.slow
def test_a_curve_is_kept_to() -> None:
    follow = Follow(Curve(np.array([[0.0, 0.0, 0.0], [0.15, 0.0, 0.0]])), 0.08)
    found = track_mission(Mission(START, follow.goal(START), follow=follow), TRUTH, options=QUICK)
    assert found.arrived
    assert found.off_curve_m is not None
    assert 0.01 < found.off_curve_m <= follow.tolerance_m
    narrow = dataclasses.replace(found, follow=Follow(follow.curve, 0.9 * found.off_curve_m))
    assert narrow.arrived
    assert not narrow.judged().arrived
    assert found.judged().arrived


@pytest.mark.slow
def test_what_really_happened_is_clear_of_obstacles() -> None:
    """By samples of another kind than the planner's bound; what touched is no arrival."""
    ball = Sphere((0.1, 0.152, 0.0), 0.1)
    asked = dataclasses.replace(QUICK, obstacles=Scene((ball,)))
    found = track_mission(Mission(START, Configuration.from_angles((0.2, 0.0, 0.0))), TRUTH, options=asked)
    assert found.arrived
    assert found.trajectory is not None
    first, last = link_segments(TRUTH, found.trajectory.pose, found.trajectory.shape[..., 0])
    along = first[:, :, None] + np.linspace(0.0, 1.0, 41)[:, None] * (last - first)[:, :, None]
    off = np.linalg.norm(along - ball.centre_m, axis=-1) - ball.radius_m
    near = float(np.min(off - np.array(link_radii(TRUTH))[:, None]))
    assert found.obstacle_m is not None
    assert 0.0 < found.obstacle_m <= near < found.obstacle_m + 1e-4
    inside = dataclasses.replace(found, obstacles=Scene((Sphere((0.1, 0.152, 0.0), 0.1 + near + 1e-4),)))
    assert inside.arrived
    assert not inside.judged().arrived


def test_where_no_plan_can_be_made_it_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any, **__: Any) -> Solution:
        raise ParameterError("measured: all links clear of obstacles are wanted, found one in a ball")

    made = plan_mission(Mission(START, Configuration.from_angles((0.002, 0.0, 0.0))), options=QUICK)
    plans = iter([lambda *_, **__: made, refused])
    monkeypatch.setattr("purcell_cli.feedback.track.Tracker.update", lambda *a, **k: next(plans)(*a, **k))
    goal = Configuration.from_angles((0.004, 0.0, 0.0))
    with pytest.warns(PurcellWarning, match="it is not planned again: measured: all links clear"):
        found = track_mission(Mission(START, goal), TRUTH, options=QUICK)
    assert (found.arrived, len(found.parts)) == (False, 1)
    monkeypatch.setattr("purcell_cli.feedback.track.Tracker.update", refused)
    with pytest.raises(ParameterError, match="measured: all links"):
        track_mission(Mission(START, goal), TRUTH, options=QUICK)


def test_what_is_not_planned_is_not_swum(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = Mission(START, Configuration.from_angles((0.002, 0.0, 0.0)), (Waypoint(np.array([0.001, 0.0, 0.0])),))
    made = plan_mission(mission, options=QUICK)
    missed = dataclasses.replace(made, plan=dataclasses.replace(made.plan, goal=START))
    monkeypatch.setattr("purcell_cli.feedback.track_mission.plan_mission", lambda *_, **__: missed)
    with pytest.warns(
        PurcellWarning, match="nothing is swum, since the plan of the mission on the model is: not reach"
    ):
        found = track_mission(mission, TRUTH, options=QUICK)
    assert not found.arrived
    assert found.parts == ()
    assert found.replans == 0
