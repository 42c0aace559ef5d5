"""Curves to follow: the base's middle stays near at every instant, and what cannot be followed is refused."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from helpers import assert_close, random_sequence, random_swimmer

from purcell_cli import Configuration, Curve, Follow, Mission, PlanOptions, Swimmer, missions, plan_mission
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, angle_between
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import sample
from purcell_cli.motion.workspace import middle_speed, turning_speed
from purcell_cli.planner.missions.curve_legs import CurvePoses
from purcell_cli.solution import Solution, carried_out

LINE = Curve(np.array([[0.0, 0.0, 0.0], [0.08, 0.0, 0.0]]))


def circle(radius_m: float, part: float = 1.0, points: int = 100) -> Curve:
    angle = 2.0 * math.pi * part * np.arange(points + 1) / points
    return Curve(radius_m * np.stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle], axis=1))


@functools.cache
def followed(tolerance_m: float) -> Solution:
    """Return a short straight line, followed."""
    follow = Follow(LINE, tolerance_m)
    mission = Mission(Configuration(), follow.goal(Configuration()), follow=follow)
    return plan_mission(mission, options=PlanOptions(effort="quick", dt_s=0.002))


def test_the_base_stays_near_the_curve_and_ends_at_its_end() -> None:
    found = followed(0.05)
    off = found.limits.off_curve
    assert found.verdict == "reached"
    assert off is not None
    rows = LINE.distance_m(found.trajectory.pose[:, :3, 3])
    assert rows.max() <= off.most_m <= 0.05
    assert_close(found.trajectory.end.pose[:3, 3], LINE.point_m[-1], 1e-9, 0.1)


def test_a_motion_that_leaves_its_curve_is_not_within_limits() -> None:
    plan = followed(0.05).plan
    strict = carried_out(plan.__class__(plan.swimmer, plan.start, plan.goal, plan.blocks, follow=Follow(LINE, 0.01)))
    assert strict.certificate.reached
    assert strict.verdict == "not found within limits"
    assert [v.limit for v in strict.limits.violations] == ["follow"]


def test_legs_round_a_sharp_corner_do_not_straighten_limbs_again() -> None:
    """Limbs are straight there to rounding; a plan whose phases begin anew could not be verified or read back."""
    corner = Follow(Curve(0.2 * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])), 0.08)
    mission = Mission(Configuration(), corner.goal(Configuration()), follow=corner)
    found = plan_mission(mission, options=PlanOptions(effort="quick"))
    assert found.verdict == "reached"
    assert {block.phase for block in found.plan.blocks} == {2}


@pytest.mark.slow
def test_a_tighter_tolerance_costs_more_travel() -> None:
    assert followed(0.02).joint_travel_rad > 1.2 * followed(0.08).joint_travel_rad


def test_a_tolerance_below_the_least_swing_is_refused_with_the_least_that_would_do() -> None:
    with pytest.raises(ParameterError, match=r"tolerance_m: at least 0\.00\d+ m, which strokes swing aside") as refused:
        followed(0.003)
    assert refused.value.args[0].endswith("found 0.003 m")


@pytest.mark.parametrize("seed", range(3))
def test_the_largest_distance_is_found_between_rows_too(seed: int) -> None:
    """Against very many samples; the distances at the rows alone are less."""
    rng = np.random.default_rng(seed)
    swimmer = random_swimmer(rng)
    blocks = (Block(2, "any", random_sequence(rng, 6)),)
    start = Configuration()
    curve = Curve(swimmer.length_m * rng.normal(size=(4, 3)))
    off = check(swimmer, start, blocks, Limits(follow=Follow(curve, 1e-3 * swimmer.length_m))).off_curve
    rows = sample(swimmer, start, blocks, 0.002 / swimmer.joint_rate_rad_s)
    sampled = float(curve.distance_m(rows.pose[:, :3, 3]).max())
    assert off is not None
    assert sampled <= off.most_m
    assert_close(off.distance_m, sampled, 0.02 * sampled + 2e-4 * swimmer.length_m)


@pytest.mark.parametrize("seed", range(2))
def test_the_largest_turn_from_a_curve_s_orientation_is_bounded(seed: int) -> None:
    """Against very many samples, each beside the nearest of many places of the curve."""
    rng = np.random.default_rng(seed)
    swimmer = random_swimmer(rng)
    blocks = (Block(2, "any", random_sequence(rng, 4)),)
    turns = se3.rotation(0.3 * rng.normal(size=(4, 3)))
    curve = Curve(swimmer.length_m * rng.normal(size=(4, 3)), turns)
    off = check(swimmer, Configuration(), blocks, Limits(follow=Follow(curve, swimmer.length_m))).off_curve
    rows = sample(swimmer, Configuration(), blocks, 0.01 / swimmer.joint_rate_rad_s).pose
    share = np.linspace(0.0, 1.0, 400, endpoint=False)[:, None]
    steps = range(3)
    places = np.concatenate([curve.point_m[k] + share * (curve.point_m[k + 1] - curve.point_m[k]) for k in steps])
    between = [se3.log(se3.pose(turns[k].T @ turns[k + 1], np.zeros(3)))[3:] for k in steps]
    there = np.concatenate([turns[k] @ se3.rotation(share * between[k]) for k in steps])
    nearest = np.argmin(np.linalg.norm(rows[:, None, :3, 3] - places, axis=2), axis=1)
    sampled = float(np.max(angle_between(there[nearest], rows[:, :3, :3])))
    assert off is not None
    assert off.turned_rad is not None
    assert sampled - 0.01 <= off.turned_rad <= 1.05 * sampled + 0.05


def test_the_base_never_turns_faster_than_its_bound() -> None:
    rng = np.random.default_rng(6)
    for _ in range(10):
        swimmer = random_swimmer(rng)
        blocks = (Block(2, "any", random_sequence(rng, 5)),)
        pieces = Pieces.of(blocks[0].sequence)
        most = float(np.max(turning_speed(swimmer, LimbCircles.of(pieces)))) * swimmer.joint_rate_rad_s
        rows = sample(swimmer, Configuration(), blocks, 0.01 / swimmer.joint_rate_rad_s)
        turned = angle_between(rows.pose[:-1, :3, :3], rows.pose[1:, :3, :3])
        assert np.all(turned <= most * np.diff(rows.time_s) + 1e-7)


def test_the_middle_is_never_faster_than_its_bound() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        swimmer = random_swimmer(rng)
        blocks = (Block(2, "any", random_sequence(rng, 5)),)
        pieces = Pieces.of(blocks[0].sequence)
        most = float(np.max(middle_speed(swimmer, LimbCircles.of(pieces)))) * swimmer.joint_rate_rad_s
        rows = sample(swimmer, Configuration(), blocks, 0.01 / swimmer.joint_rate_rad_s)
        step = np.linalg.norm(np.diff(rows.pose[:, :3, 3], axis=0), axis=1)
        assert np.all(step <= most * np.diff(rows.time_s) * (1.0 + 1e-9))


def test_distances_are_those_to_the_nearest_step() -> None:
    bent = Curve(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]))
    points = np.array([[0.5, 0.2, 0.0], [1.5, 0.5, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.3]])
    assert_close(bent.distance_m(points), [0.2, 0.5, 1.0, 0.3], 1e-15)
    assert_close(bent.part(0.5, 1.5).point_m, [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.5, 0.0]], 1e-15)


def test_distances_from_laps_are_those_from_one() -> None:
    """Whichever steps are left out as too far, or as repeated: against all of them."""
    lap, rng = circle(0.3), np.random.default_rng(2)
    laps = Curve(np.concatenate([lap.point_m, *[lap.point_m[1:] + 1e-17 * k for k in range(3)]]))
    path = lap.at(np.linspace(0.0, lap.length_m, 300)) + 0.03 * rng.normal(size=(300, 3))
    begin, edge = lap.point_m[:-1], np.diff(lap.point_m, axis=0)
    share = np.clip(np.sum((path[:, None] - begin) * edge, axis=2) / np.sum(edge * edge, axis=1), 0.0, 1.0)
    every = np.linalg.norm(path[:, None] - begin - share[..., None] * edge, axis=2).min(axis=1)
    assert_close(lap.distance_m(path), every, 1e-15)
    assert_close(laps.distance_m(path), every, 1e-15)


@pytest.mark.slow
def test_laps_cost_the_plans_of_one_and_end_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    legs: list[Configuration] = []
    planned = missions.planned

    def counted(start: Configuration, goal: Configuration, **asked: Any) -> Plan:
        legs.append(start)
        return planned(start, goal, **asked)

    monkeypatch.setattr(missions, "planned", counted)
    lap = circle(0.3)
    follow = Follow(Curve(np.concatenate([lap.point_m, *[lap.point_m[1:]] * 2])), 0.1)
    mission = Mission(Configuration(), follow.goal(Configuration()), follow=follow)
    found = plan_mission(mission, options=PlanOptions(effort="quick", dt_s=10.0))
    assert found.verdict == "reached"
    assert found.certificate.deviation.within(2e-11, 2e-10)
    assert len(legs) <= 6
    assert found.joint_travel_rad > 3 * 500.0


def headings(follow: Follow) -> Array:
    """Return the directions in which the swimmer looks along a curve, in the x-y plane [deg]."""
    x = follow.poses(Configuration())[:, :2, 0]
    return np.degrees(np.arctan2(x[:, 1], x[:, 0]))


def test_a_sharp_corner_is_gone_round_backwards() -> None:
    sharp = Curve(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.2, 0.1, 0.0]]))
    blunt = Curve(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]))
    assert_close(headings(Follow(sharp, 0.1)), [0.0, 0.0, -7.125016, -7.125016], 1e-5)
    assert_close(headings(Follow(blunt, 0.1)), [0.0, 0.0, 90.0, 90.0], 1e-9)


def test_poses_along_a_curve_run_from_the_start_to_the_goal() -> None:
    follow = Follow(circle(0.3), 0.1)
    start = Configuration()
    goal = follow.goal(start)
    poses = CurvePoses.of(follow, start, goal, 0.1)
    assert_close(poses.at(0.0)[0], start.pose, 1e-12)
    assert_close(poses.at(float(poses.along[-1]))[0], goal.pose, 1e-12)
    assert np.all(np.diff(poses.along) >= 0.0)
    middle, place = poses.at(0.5 * float(poses.along[-1]))
    assert_close(middle[:3, 3], [0.0, 0.6, 0.0], 0.01)
    assert_close(place, 0.5 * follow.curve.length_m, 0.01)


@pytest.mark.parametrize(
    ("wanted", "start", "goal", "curve"),
    [
        ("start: a position within 0.05 m", (0.0, 0.06, 0.0), (0.08, 0.0, 0.0), LINE),
        ("goal: the position of the curve's last point", (0.0, 0.0, 0.0), (0.08, 0.01, 0.0), LINE),
        (
            "goal: the orientation of the curve's last point",
            (0.0, 0.0, 0.0),
            (0.08, 0.0, 0.0),
            Curve(LINE.point_m, np.stack([np.eye(3), about_axis(2, 0.5)])),
        ),
    ],
)
def test_ends_that_are_not_the_curve_s_are_refused(
    wanted: str, start: tuple[float, ...], goal: tuple[float, ...], curve: Curve
) -> None:
    with pytest.raises(ParameterError, match=wanted):
        Mission(Configuration.from_angles(start), Configuration.from_angles(goal), follow=Follow(curve, 0.05))


def test_the_swimmer_of_the_paper_needs_no_other_shape_at_the_end() -> None:
    assert followed(0.05).plan.goal.shape.tolist() == [np.eye(3).tolist()] * 2
    assert followed(0.05).plan.swimmer == Swimmer()
