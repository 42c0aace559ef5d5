"""The rest of a plan: from a measured configuration its remaining strokes, changed a little, arrive exactly."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, assert_close, flown, runner
from joint_queries import Query, joint_faults

from purcell_cli import (
    Configuration,
    Curve,
    Follow,
    Mission,
    PlanOptions,
    Solution,
    Swimmer,
    Waypoint,
    plan_mission,
)
from purcell_cli.errors import ParameterError
from purcell_cli.feedback.measured import Measuring
from purcell_cli.feedback.plan_legs import legs_of
from purcell_cli.feedback.replan import done_at, done_by, refuse_time, replan
from purcell_cli.feedback.replan_mission import replan_once
from purcell_cli.files.builtin import find_scenario
from purcell_cli.files.plan_file import PlanDocument, write_plan
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.motion.blocks import Block, starting_shapes
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import Controls, Effort
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.refine.minimum_travel import Pace
from purcell_cli.planner.rest import rest
from purcell_cli.planning import plan
from purcell_cli.solution import carried_out

L_M = Swimmer().length_m


@pytest.fixture(scope="module")
def whole() -> Solution:
    query = find_scenario("yaw")
    return plan(query.start, query.goal)


@pytest.fixture(scope="module")
def way(whole: Solution) -> PlanPath:
    return PlanPath.of(whole.plan)


def at(way: PlanPath, place: int) -> Configuration:
    """Return the configuration at a place of a way that ends at its plan's goal."""
    left = way.left[place].copy()
    left[:3, 3] *= L_M
    return Configuration(way.plan.goal.pose @ se3.inverse(left), way.shape[place])


def near(way: PlanPath, place: int) -> Configuration:
    """Return what is measured there with noise of 1e-3 L and 0.1 degree."""
    return Measuring(1e-3, 0.1).of(at(way, place), L_M, np.random.default_rng(3).normal(size=(2, 3)))


def middle(way: PlanPath) -> int:
    return int(np.searchsorted(-way.travel_rad, -0.5 * way.travel_rad[0]))


def test_a_way_is_where_the_trajectory_is(whole: Solution, way: PlanPath) -> None:
    rows = whole.trajectory
    row = np.searchsorted(rows.time_s, way.travel_rad[0] - way.travel_rad - 1e-9)
    exact = np.abs(rows.time_s[row] - (way.travel_rad[0] - way.travel_rad)) < 1e-9
    assert np.sum(exact) > 50
    for place in np.flatnonzero(exact)[::10]:
        here = Configuration(rows.pose[row[place]], rows.shape[row[place]])
        assert Deviation.between(at(way, int(place)), here).within(1e-6 * L_M, 1e-6)
    assert not Deviation.between(at(way, 40), at(way, 44)).within(1e-4 * L_M, 1e-4)


def test_the_rest_arrives_exactly_and_travels_as_far_as_was_left(way: PlanPath) -> None:
    place = middle(way)
    measured = near(way, place)
    found = replan(way, measured)
    assert found.kept
    assert found.solution.verdict == Verdict.REACHED
    assert found.solution.plan.start is measured
    assert found.off < 5e-3
    assert_close(found.done_rad + found.left_rad, way.travel_rad[0], 1e-9)
    assert abs(found.solution.joint_travel_rad - found.left_rad) < 0.1 * found.left_rad
    # The strokes that are left, as they were, miss the goal by what was measured.
    plain = dataclasses.replace(way.plan, start=measured, blocks=way.blocks_from(place), limits=None)
    assert carried_out(plain).verdict == Verdict.NOT_REACHED


def test_on_the_way_the_rest_is_what_is_left(way: PlanPath) -> None:
    for place in (0, 4, middle(way), middle(way) + 1):
        nearest, off = way.nearest(at(way, place), way.plan.goal)
        assert (nearest, off < 1e-7) == (place, True)
        left = flown(way.plan.swimmer, way.blocks_from(place), way.shape[place])
        left[:3, 3] /= L_M
        assert_close(left, way.left[place], 1e-6)
        assert_close(sum(b.joint_travel_rad for b in way.blocks_from(place)), way.travel_rad[place], 1e-9)


@pytest.fixture(scope="module")
def rolled() -> PlanPath:
    """Return the way of a plan whose limbs are rolled by a quarter turn where they are straight."""
    shape = np.stack([about_axis(0, 0.5 * np.pi) @ about_axis(2, bend) for bend in (0.3, -0.4)])
    start, end = (Configuration.from_angles((x, 0.0, 0.0)) for x in (0.0, 0.02))
    found = plan(*(dataclasses.replace(one, shape=shape) for one in (start, end)))
    assert found.verdict == Verdict.REACHED
    return PlanPath.of(found.plan)


def test_the_rest_of_a_plan_of_rolled_limbs_is_its_own_strokes(rolled: PlanPath) -> None:
    phases = np.array([*(b.phase for b in rolled.plan.blocks), 3])[rolled.block]
    straight = rolled.shape[int(np.argmax(phases == 3))]
    assert np.max(np.abs(straight - np.eye(3))) > 0.9  # the foil: limbs that are straight need not be unrolled
    place = len(rolled.block) // 4
    aside = at(rolled, place)
    measured = dataclasses.replace(aside, pose=aside.pose @ se3.pose(np.eye(3), np.array([0.0, 2e-4, 0.0])))
    found = rest(rolled, place, measured, rolled.plan.goal, Limits(), (0.0,))
    assert found is not None
    solution = carried_out(found)
    assert solution.verdict == Verdict.REACHED
    assert abs(solution.joint_travel_rad - rolled.travel_rad[place]) < 2.0


@pytest.mark.parametrize("name", ["universal-joints", "robot-joints"])
def test_the_rest_of_a_plan_by_universal_joints_is_its_own_strokes(name: str) -> None:
    query = find_scenario(name)
    way = PlanPath.of(plan(query.start, query.goal, swimmer=query.swimmer).plan)
    assert max(int(np.max(b.sequence.control)) for b in way.plan.blocks) > 5  # psi, which no ball joint turns
    place = middle(way)
    aside = at(way, place)
    measured = dataclasses.replace(aside, pose=aside.pose @ se3.pose(np.eye(3), np.array([0.0, 2e-4, 0.0])))
    found = replan(way, measured)
    assert (found.kept, found.solution.verdict) == (True, Verdict.REACHED)
    faults = joint_faults(Query(query.swimmer, measured, query.goal), found.solution.trajectory)
    assert faults == []


def test_rests_whose_limbs_are_bent_to_their_limit_are_brought_to_the_goal_by_being_shortened(way: PlanPath) -> None:
    plain, shortened = [], []
    for place in range(2, 14, 2):
        aside = at(way, place)
        measured = dataclasses.replace(aside, pose=aside.pose @ se3.pose(np.eye(3), np.array([0.0, 1e-3, 1e-3])))
        plain.append(rest(way, place, measured, way.plan.goal, Limits(), (0.0,)) is not None)
        found = rest(way, place, measured, way.plan.goal, Limits(), (0.0,), Pace(2, 30))
        shortened.append(found is not None)
        if found is not None:
            solution = carried_out(found)
            assert solution.verdict == Verdict.REACHED
            assert abs(solution.joint_travel_rad - way.travel_rad[place]) < 2.0
    assert sum(shortened) >= sum(plain) + 3  # the foil: Newton's method within the limit sticks


def test_going_back_and_forth_moves_nothing(way: PlanPath) -> None:
    place = middle(way)
    blocks = way.back_and_forth(place, 5.0)
    start = way.shape[place]
    travel = sum(b.joint_travel_rad for b in blocks)
    assert 10.0 <= travel < 13.0
    assert_close(starting_shapes(blocks, start)[-1], start, 1e-12)
    still = dataclasses.replace(way.plan, start=Configuration(np.eye(4), start), blocks=blocks)
    solution = dataclasses.replace(still, goal=Configuration(np.eye(4), start), limits=None)
    assert carried_out(solution).deviation.within(1e-10, 1e-10)
    half = dataclasses.replace(solution, blocks=blocks[: len(blocks) // 2])
    assert not carried_out(half).deviation.within(1e-3, 1e-3)


def test_near_the_end_a_part_of_the_way_is_gone_back(way: PlanPath) -> None:
    place = len(way.travel_rad) - 2
    found = replan(way, near(way, place))
    assert found.kept
    assert found.solution.verdict == Verdict.REACHED
    assert found.left_rad < 0.5 < 4.0 < found.solution.joint_travel_rad < 11.0


@pytest.mark.slow
def test_far_off_the_way_it_is_planned_anew(way: PlanPath) -> None:
    aside = Configuration.from_angles((0.0, 0.2, 0.0), (90, 0, 0))
    found = replan(way, aside)
    assert not found.kept
    assert found.solution.verdict == Verdict.REACHED


def test_strokes_that_are_said_to_be_swum_are_left_out(way: PlanPath) -> None:
    start = way.plan.start
    nearest, _ = way.nearest(start, way.plan.goal)
    later, off = way.nearest(start, way.plan.goal, 0.5 * float(way.travel_rad[0]))
    assert nearest == 0
    assert way.travel_rad[later] <= 0.5 * way.travel_rad[0] + 1e-9
    assert off > 1e-2


def test_a_time_says_how_much_joint_travel_is_made(whole: Solution) -> None:
    assert_close(done_by(whole.plan, 7.5), 7.5, 1e-9)  # one joint at a time, at 1 rad/s
    assert_close(done_by(whole.plan, 1e9), whole.joint_travel_rad, 1e-9)
    times = np.array([0.0, 3.25, 7.5, 1e9])
    assert done_at(whole.plan, times).tolist() == [done_by(whole.plan, t) for t in times.tolist()]
    quick = dataclasses.replace(whole.plan, swimmer=Swimmer(joint_rate_rad_s=2.0))
    assert_close(done_by(quick, 7.5), 15.0, 1e-9)
    refuse_time(whole.plan, round(whole.duration_s + 4e-4, 4))  # as far as a duration is shown
    for wrong in (math.nan, -1e-9, whole.duration_s + 1e-3, 1e9):
        with pytest.raises(ParameterError, match=rf"0 s to {whole.duration_s:.3f} s, the plan's end, is wanted, found"):
            refuse_time(whole.plan, wrong)


def test_a_plan_of_all_joints_at_once_is_planned_anew_and_no_place_on_its_way_is_named() -> None:
    options = PlanOptions(effort=Effort.QUICK, controls=Controls.SIMULTANEOUS)
    goal = Configuration.from_angles((0.002, 0.0, 0.0))
    made = plan(Configuration(), goal, options=options).plan
    found = replan_once(made, Configuration.from_angles((0.001, 0.0, 0.0)), options, after_rad=0.5)
    assert found.solution.verdict == Verdict.REACHED
    assert (found.kept, found.off, found.done_rad) == (False, None, 0.5)
    assert abs(found.left_rad - (made.joint_travel_rad - 0.5)) < 1e-12


def test_a_plan_that_moves_nothing_is_planned_anew() -> None:
    goal = Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 0), (10, 0, 0), (0, 0, 0))
    still = plan(goal, goal).plan
    found = replan_once(still, dataclasses.replace(goal), PlanOptions())
    assert not found.kept
    assert found.solution.verdict == Verdict.REACHED


@pytest.fixture
def command(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: Solution
) -> Run:
    monkeypatch.chdir(tmp_path)
    write_plan(PlanDocument(whole.plan, whole.options), "plan.json")
    Path("measured.yaml").write_text("base: {orientation: {euler_deg: [0.2, 0, 0]}}\n")
    return runner(capsys, "replan")


def test_a_plan_document_is_no_scenario_and_what_takes_it_is_told(
    capsys: pytest.CaptureFixture[str], command: Run
) -> None:
    for words in (["plan", "plan.json"], ["track", "plan.json", "--truth", "planar"]):
        code, out, err = runner(capsys)(*words)
        assert (code, out) == (2, "")
        assert "purcell run plays it again, purcell replan plans the rest" in err


@pytest.mark.slow
def test_the_command_writes_what_plan_writes(command: Run) -> None:
    code, out, _ = command("--from", "measured.yaml", "plan.json", "--out", "a.csv", "--plan-out", "b.json", "--json")
    document = json.loads(out)
    assert (code, document["schema"], document["verdict"]) == (0, "purcell/replan/1", "reached")
    assert document["rest"]["kept"]
    assert document["rest"]["off_way"] < 0.01
    assert Path("a.csv").read_text().startswith("t_s,phase,gait")
    assert json.loads(Path("b.json").read_text())["goal"] == json.loads(Path("plan.json").read_text())["goal"]
    code, out, _ = command("--from", "measured.yaml", "plan.json", "--out", "a.csv")
    assert code == 0
    assert "the rest of its own strokes" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--from", "measured.yaml", "measured.yaml"], "measured.yaml"),
        (["--from", "plan.json", "plan.json"], "plan.json"),
        (["--from", "measured.yaml", "plan.json", "--after", "-1"], "after"),
        (["--from", "measured.yaml", "plan.json", "--after", "1e9"], "--after: a time from 0 s to "),
        (["--from", "far.yaml", "plan.json"], "far.yaml: measured: position_m: coordinates up to 112589 m"),
        (["--from", "measured.yaml", "plan.json", "--out", "plan.json"], "plan.json"),
        (["--from", "missing.yaml", "plan.json"], "no such file"),
    ],
)
def test_bad_input_is_refused(command: Run, arguments: list[str], message: str) -> None:
    Path("far.yaml").write_text("base: {position_m: [1e9, 0, 0]}\n")
    code, out, err = command(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert sorted(path.name for path in Path().iterdir()) == ["far.yaml", "measured.yaml", "plan.json"]


@pytest.fixture(scope="module")
def mission() -> Solution:
    via = (Waypoint(np.array([0.02, 0.0, 0.0])), Waypoint(np.array([0.05, 0.01, 0.0])))
    return plan_mission(Mission(Configuration(), Configuration.from_angles((0.08, 0.0, 0.0)), via))


@pytest.mark.parametrize("leg", [0, 1, 2])
def test_the_rest_of_a_mission_passes_the_waypoints_that_are_left(mission: Solution, leg: int) -> None:
    made = mission.plan
    one = legs_of(made)[leg].leg
    assert one is not None
    way = PlanPath.of(one)
    measured = near(way, middle(way))
    done = sum(b.joint_travel_rad for blocks in made.legs[:leg] for b in blocks)
    found = replan_once(made, measured, after_rad=done)
    rest = found.solution
    assert found.kept
    assert rest.verdict == Verdict.REACHED
    assert [p.index for p in rest.plan.passages] == [0, 1][leg:]
    assert found.done_rad > done
    for passage, blocks in zip(rest.plan.passages, itertools.accumulate(rest.plan.legs), strict=False):
        moved = measured.pose @ flown_from(rest, blocks)
        assert_close(moved[:3, 3], passage.waypoint.position_m, 1e-9 * L_M)
    # The strokes that are left, as they were, miss the first of them.
    plain = dataclasses.replace(rest.plan, blocks=(*way.blocks_from(middle(way)), *rest.plan.blocks[-1:]), limits=None)
    assert carried_out(plain).certificate.deviation.position_m > 1e-5 * L_M


def flown_from(solution: Solution, blocks: tuple[Block, ...]) -> Array:
    """Return where strokes take the base from where a plan begins [m]. Shape (4, 4)."""
    return flown(solution.plan.swimmer, blocks, solution.plan.start.shape)


def test_far_off_its_way_the_rest_of_a_mission_is_planned_anew(mission: Solution) -> None:
    aside = Configuration.from_angles((0.02, -0.1, 0.0), (60, 0, 0))
    found = replan_once(mission.plan, aside)
    assert not found.kept
    assert found.solution.verdict == Verdict.REACHED
    left = [p.index for p in found.solution.plan.passages]
    assert left == [0, 1][2 - len(left) :]


@pytest.mark.slow
def test_the_rest_of_a_plan_along_a_curve_stays_near_it() -> None:
    follow = Follow(Curve(np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.4, 0.1, 0.0]])), 0.07)
    asked = PlanOptions(effort="quick")
    made = plan_mission(Mission(Configuration(), follow.goal(Configuration()), follow=follow), options=asked).plan
    leg = legs_of(made)[1].leg
    assert leg is not None
    way = PlanPath.of(leg)
    found = replan_once(made, near(way, middle(way)), asked)
    assert found.kept
    assert found.solution.verdict == Verdict.REACHED
    off = found.solution.limits.off_curve
    assert off is not None
    assert 0.01 < off.distance_m <= follow.tolerance_m
    with pytest.raises(
        ParameterError, match=r"measured: a position within 0\.07 m of the curve is wanted, found one 0\.2"
    ):
        replan_once(made, Configuration.from_angles((0.2, -0.2, 0.0)), asked)


def test_what_is_left_of_a_curve_begins_where_it_is_nearest() -> None:
    lap = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    laps = Curve(np.concatenate([lap, lap, lap[:1]]))
    for near_m, left in ((0.3, 7.8), (4.1, 3.8)):
        rest = laps.rest(np.array([0.2, -0.1, 0.0]), near_m)
        assert rest is not None
        assert_close(rest.point_m[0], [0.2, 0.0, 0.0], 1e-12)
        assert_close(rest.length_m, left, 1e-12)
    turned = Curve(np.array([[0.0, 0, 0], [1, 0, 0]]), np.stack([np.eye(3), about_axis(2, 1.0)]))
    rest = turned.rest(np.array([0.25, 0.1, 0.0]), 0.0)
    assert rest is not None
    assert rest.orientation is not None
    assert_close(rest.orientation[0], about_axis(2, 0.25), 1e-12)
    assert turned.rest(np.array([2.0, 0.0, 0.0]), 0.0) is None
