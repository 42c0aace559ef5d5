"""Plans on which all joints turn at once: as exact as others and quicker, within the rates and bends allowed."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import NIGHTLY, assert_close

from purcell_cli import Configuration, PlanOptions, Swimmer, plan, read_csv, write_csv
from purcell_cli.errors import UnknownNameError
from purcell_cli.files.builtin import find_scenario
from purcell_cli.files.plan_file import PlanDocument, load_plan
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.kernel import moves
from purcell_cli.mechanics.collocation import flow_of
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.options import Controls
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.planner.refine.inequalities import distance_rows
from purcell_cli.planner.refine.minimum_energy import Dissipation, durations
from purcell_cli.planner.refine.random_starts import random_starts
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.simultaneous import quickened
from purcell_cli.solution import Solution, carried_out
from purcell_cli.verification.verify import verify

BENT = Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 0), (30, 10, 0), (-20, 15, 5))

QUERIES = {
    "near": (Configuration(), Configuration.from_angles((0.004, 0.003, -0.002), (3, -2, 5)), Swimmer()),
    "bent limbs": (BENT, Configuration.from_angles((0.005, 0, 0), (0, 0, 10), (10, -20, 30)), Swimmer()),
    "fast joints": (Configuration(), Configuration.from_angles((0.05, 0.01, 0)), Swimmer(joint_rate_rad_s=7.3)),
    "small bends": (Configuration(), Configuration.from_angles((0.03, 0, 0.01)), Swimmer(max_bend_rad=0.5)),
    "other links": (Configuration(), BENT, Swimmer(0.1, 0.05, slenderness=0.005, drag_ratio=1.7)),
    "an arc": (Configuration(), Configuration.from_angles((0.4, 0.3, 0), (60, 0, 0)), Swimmer()),
}


LONG = ("small bends", "other links", "an arc")
"""Queries whose plans take tens of seconds with the usual effort."""


@functools.cache
def solved(name: str, controls: str = "simultaneous", effort: str = "standard") -> Solution:
    """Return the plan of a query; planned once in a process."""
    start, goal, swimmer = QUERIES[name]
    return plan(start, goal, swimmer=swimmer, options=PlanOptions(controls=controls, effort=effort))


@functools.cache
def far(bend: float) -> Solution:
    """Return the plan of 20 L along x with a bend limit [rad]."""
    goal = Configuration.from_angles((2.0, 0.0, 0.0))
    return plan(Configuration(), goal, swimmer=Swimmer(max_bend_rad=bend), options=PlanOptions(controls="simultaneous"))


# --- Plans ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "effort"),
    [
        *((name, "standard") for name in QUERIES if name not in LONG),
        ("small bends", "quick"),
        *(pytest.param(name, "quick", marks=NIGHTLY) for name in LONG[1:]),
        *(pytest.param(name, "standard", marks=NIGHTLY) for name in LONG),
    ],
)
def test_quick_plans_arrive_exactly_in_less_time_within_rates_and_bends(name: str, effort: str) -> None:
    """In one test, since a plan takes seconds: its parts are named below."""
    found, plain = solved(name, "simultaneous", effort), solved(name, "primitive", effort)
    arrives_in_less_time(found, plain)
    turns_no_joint_too_fast(found)
    bends_no_limb_too_far(found)


def arrives_in_less_time(found: Solution, plain: Solution) -> None:
    """The independent replay meets the goal to 1e-9; the plan by primitives takes at least a fifth longer."""
    assert (found.verdict, found.controls, plain.controls) == ("reached", "simultaneous", "primitive")
    assert found.certificate.tolerance_rad <= 1e-9
    assert 1.2 * found.duration_s < plain.duration_s
    assert math.isclose(found.trajectory.time_s[-1], found.duration_s, rel_tol=1e-12)


def turns_no_joint_too_fast(found: Solution) -> None:
    """At every moment a joint turns as fast as it can, and at some moments several turn."""
    rate = found.plan.swimmer.joint_rate_rad_s
    assert np.max(np.abs(found.trajectory.rate_rad_s)) <= rate * (1.0 + 1e-12)
    lasting = np.diff(found.trajectory.time_s) > 1e-6
    busy = np.max(np.abs(found.trajectory.rate_rad_s[:-1][lasting]), axis=1)
    assert np.min(busy) >= rate * (1.0 - 1e-6)
    assert np.max(np.count_nonzero(found.trajectory.rate_rad_s, axis=1)) > 1


def bends_no_limb_too_far(solution: Solution) -> None:
    """At any instant; the phases meet at the collinear shape."""
    made = solution.plan
    found = check(made.swimmer, made.start, made.blocks)
    assert found.kept
    assert found.largest_bend_rad[1] <= made.swimmer.max_bend_rad
    shapes = starting_shapes(made.blocks, made.start.shape)
    for k in range(1, len(made.blocks)):
        if made.blocks[k].phase != made.blocks[k - 1].phase:
            assert np.max(angle_between(shapes[k], COLLINEAR)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("bend", "speed"), [(1.0, 0.083), (1.6, 0.104)])
def test_far_plans_cruise_with_all_joints(bend: float, speed: float) -> None:
    """Units of L per second over the whole way; planar loops of one joint a limb (the foil) make 0.0769 at most."""
    found = far(bend)
    assert found.verdict == "reached"
    assert 20.0 / found.duration_s >= speed
    assert max(b.cycles for b in found.plan.blocks) > 20
    assert len(found.plan.blocks) < 20


@pytest.mark.slow
def test_the_file_of_a_quick_plan_replays_it(tmp_path: Path) -> None:
    """`verify` finds no fault; with one rate a little off (the foil) it does."""
    start, goal, swimmer = QUERIES["fast joints"]
    write_csv(solved("fast joints").trajectory, tmp_path / "swim.csv")
    table = read_csv(tmp_path / "swim.csv")
    assert verify([table], start, goal, swimmer, 1e-9, 1e-9).faults == ()
    row, joint = np.argwhere(np.abs(table.rate_rad_s) > 1.0)[5]
    table.rate_rad_s[row, joint] *= 1.0 - 1e-4
    assert verify([table], start, goal, swimmer, 1e-9, 1e-9).faults != ()


@pytest.mark.slow
def test_the_document_of_a_quick_plan_makes_the_same_trajectory(tmp_path: Path) -> None:
    solution = solved("fast joints")
    (tmp_path / "plan.json").write_text(PlanDocument(solution.plan).as_text())
    again = carried_out(load_plan(tmp_path / "plan.json").plan)
    assert_close(again.trajectory.rate_rad_s, solution.trajectory.rate_rad_s, 0.0)
    assert_close(again.trajectory.time_s, solution.trajectory.time_s, 0.0)
    assert_close(again.trajectory.pose, solution.trajectory.pose, 0.0)


@pytest.mark.slow
def test_planning_twice_makes_the_same_plan() -> None:
    start, goal, swimmer = QUERIES["fast joints"]
    again = plan(start, goal, swimmer=swimmer, options=PlanOptions(controls="simultaneous"))
    assert_close(again.trajectory.rate_rad_s, solved("fast joints").trajectory.rate_rad_s, 0.0)


def test_a_goal_already_reached_needs_no_moves() -> None:
    found = plan(Configuration(), Configuration(), options=PlanOptions(controls="simultaneous"))
    assert (found.verdict, found.duration_s, found.plan.blocks) == ("reached", 0.0, ())


@pytest.mark.slow
def test_a_quick_plan_that_breaks_a_limit_is_not_taken() -> None:
    """Limbs wanted further apart than they ever come: the plan by primitives stays; without the limit it does not."""
    made = solved("fast joints", "primitive").plan
    assert quickened(made, Limits(clearance_m=1.0)) is made
    assert solved("fast joints").plan.duration_s < made.duration_s


def test_a_tiny_way_of_few_bends_gets_a_quick_plan() -> None:
    """No limb then comes near its limit, so that no bend is in the equations."""
    start, goal = Configuration(), Configuration.from_angles((0.0002, 0.0, 0.0))
    plain, quick = (plan(start, goal, options=PlanOptions(effort="quick", controls=c)) for c in Controls)
    assert (plain.verdict, quick.verdict) == ("reached", "reached")
    assert quick.duration_s < 0.8 * plain.duration_s


@pytest.mark.slow
def test_limbs_that_may_fold_swing_at_random_to_begin_with() -> None:
    """In much less time than loops take, all in one phase, and limbs do not touch each other."""
    goal = Configuration.from_angles((0.06, 0.02, -0.03), (50.0, -20.0, 40.0), (60, 10, 0), (-40, 20, 0))
    swimmer = Swimmer(max_bend_rad=math.pi)
    plain, quick = (
        plan(BENT, goal, swimmer=swimmer, options=PlanOptions(effort="quick", controls=c)) for c in Controls
    )
    assert quick.verdict == "reached"
    assert 3.0 * quick.duration_s < plain.duration_s
    made = quick.plan
    assert check(made.swimmer, made.start, made.blocks).kept
    assert {block.phase for block in made.blocks} == {2}


def test_random_motions_end_at_the_goals_shape_the_nearest_first() -> None:
    wanted = Configuration.from_angles((0.05, 0.0, 0.0)).pose
    swimmer = Swimmer(max_bend_rad=2.0).scaled()
    motion = Equations(swimmer, [], BENT.shape, COLLINEAR, wanted, SEARCHING)
    found = random_starts(motion, "any", 12.0, 20, 20, 1)
    off = [float(np.linalg.norm(one.at(one.angles).residual[:6])) for one in found]
    assert len(found) == 20
    assert off == sorted(off)
    assert off[-1] > 2.0 * off[0]
    for one in found:
        assert_close(MoveSequence.of_turns(one.segments[0].turn).shapes(BENT.shape)[-1], COLLINEAR, 1e-12)


def test_the_room_between_limbs_is_linear_in_the_turns_where_they_are_nearest() -> None:
    """At the end of the last move, where they are nearest; with one limb's part alone (the foil) it is not."""
    swimmer, rng = Swimmer(max_bend_rad=math.pi).scaled(), np.random.default_rng(4)
    turn = np.zeros((3, 6))
    turn[:, 2], turn[:, 5] = 0.75, -0.6
    turn += 0.05 * rng.normal(size=(3, 6))

    def room(turn: Array) -> tuple[Array, Array]:
        ends = np.array([3]), np.stack([COLLINEAR])[:1]
        found = moves.equations(flow_of(swimmer, SEARCHING), COLLINEAR, turn, np.empty((0, 3)), np.eye(4), *ends)
        return distance_rows(swimmer, found, turn, 3.0)

    left, slope = room(turn)
    change = 1e-5 * rng.normal(size=(3, 6))
    more, less = room(turn + change)[0], room(turn - change)[0]
    assert len(left) == len(more) == len(less) > 0
    assert_close(slope[-1] @ change.ravel(), 0.5 * (more - less)[-1], 1e-8)
    change[:, 3:] = 0.0
    assert abs(slope[-1] @ change.ravel() - 0.5 * (more - less)[-1]) > 1e-6


@functools.cache
def small(number: int, controls: str, objective: str | None = None) -> Solution:
    """Return the plan of a random small displacement; planned once in a process."""
    rng = np.random.default_rng(number)
    goal = Configuration.from_angles(0.01 * rng.uniform(-1.0, 1.0, 3), rng.uniform(-8.0, 8.0, 3))
    asked = PlanOptions(effort="quick", controls=controls, objective=objective)
    return plan(Configuration(), goal, options=asked)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(4))
def test_no_plan_is_worse_than_the_one_by_primitives(number: int) -> None:
    """Neither in time nor, where that is minimised, in joint travel; one of least time (the foil) travels further."""
    plain, quick, short = (
        small(number, "primitive"),
        small(number, "simultaneous"),
        small(number, "simultaneous", "travel"),
    )
    assert {plain.verdict, quick.verdict, short.verdict} == {"reached"}
    assert quick.duration_s <= plain.duration_s
    assert (quick.duration_s, quick.joint_travel_rad) < (plain.duration_s, plain.joint_travel_rad)
    assert short.joint_travel_rad <= plain.joint_travel_rad
    assert short.duration_s <= plain.duration_s
    assert quick.duration_s < short.duration_s
    assert short.joint_travel_rad < quick.joint_travel_rad


@pytest.mark.slow
def test_a_plan_of_least_energy_takes_less_in_the_same_time() -> None:
    """Less than the plan by primitives of least energy, and than the quickest plan (the foil) played as slowly."""
    start, goal, swimmer = QUERIES["near"]

    def planned(**asked: str) -> Solution:
        return plan(start, goal, swimmer=swimmer, options=PlanOptions(effort="quick", **asked))

    plain, quick = planned(objective="energy"), planned(controls="simultaneous")
    found = planned(controls="simultaneous", objective="energy")
    assert {plain.verdict, found.verdict} == {"reached"}
    assert found.duration_s <= plain.duration_s
    assert found.duration_s > (1.0 - 1e-6) * plain.duration_s
    spent, slowly = float(np.sum(found.energy_j)), float(np.sum(quick.energy_j)) * quick.duration_s / plain.duration_s
    assert 2.0 * spent < float(np.sum(plain.energy_j))
    assert 1.1 * spent < slowly
    assert np.max(np.abs(found.trajectory.rate_rad_s)) <= found.plan.swimmer.joint_rate_rad_s * (1.0 + 1e-12)


def test_the_slope_of_the_energy_is_what_small_changes_make_of_it() -> None:
    """With the shapes' part left out (the foil) it is not."""
    rng = np.random.default_rng(3)
    turn = rng.uniform(-0.5, 0.5, (5, 6))
    segment = Segment.by_moves(2, "any", turn)
    goal = MoveSequence.of_turns(turn).shapes(COLLINEAR)[-1]
    motion = Equations(Swimmer().scaled(), [segment], COLLINEAR, goal, np.eye(4), SEARCHING)
    dissipation, each = Dissipation(motion, 5.0), rng.uniform(0.5, 2.0, 5)
    slope, alone = dissipation.slope(turn, each), np.empty((5, 6))
    found = np.empty((5, 6))
    for k, i in np.ndindex(5, 6):
        change = np.zeros((5, 6))
        change[k, i] = 1e-5
        more, less = dissipation.work(turn + change), dissipation.work(turn - change)
        found[k, i] = each @ (more - less) / 2e-5
        alone[k, i] = each[k] * (more[k] - less[k]) / 2e-5
    assert_close(slope, found, 1e-4)
    assert np.max(np.abs(alone - found)) > 0.05


def test_moves_that_rates_hold_back_last_as_long_as_they_must() -> None:
    """The others share what is left by the roots of their work, which takes least; others (the foil) take more."""
    turn = np.zeros((3, 6))
    turn[:, 2] = 1.0, 0.1, 0.1
    work, cycles = np.array([1e-4, 1.0, 4.0]), np.array([1, 2, 1])
    found = durations(work, turn, cycles, 5.0)
    assert found[0] >= 1.0
    assert found[0] < 1.05
    assert_close(found[2] / found[1], 2.0, 1e-9)
    assert_close(cycles @ found, 5.0, 1e-9)
    other = found + np.array([0.0, 0.05, -0.1])
    assert cycles @ (work / other) > cycles @ (work / found) + 1e-4


@pytest.mark.slow
def test_a_thorough_plan_is_never_worse_than_a_standard_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the thorough search ends worse, here since it may not make its plan quicker, the standard one stays."""
    start, goal = Configuration(), Configuration.from_angles((0.004, 0.002, 0.0))
    efforts: list[str] = []

    def hindered(made: Plan, limits: Limits, objective: str, effort: str) -> Plan:
        efforts.append(effort)
        return quickened(made, limits, objective, "quick") if effort == "standard" else made

    def quick(*given: Any) -> Plan:
        return reconfigure(*given[:4], "quick", *given[5:])

    monkeypatch.setattr("purcell_cli.planner.refine.simultaneous.quickened", hindered)
    monkeypatch.setattr("purcell_cli.planning.reconfigure", quick)
    found = plan(start, goal, options=PlanOptions(controls="simultaneous", effort="thorough"))
    plain = plan(start, goal, options=PlanOptions(effort="quick"))
    assert efforts == ["standard", "thorough"]
    assert found.verdict == "reached"
    assert found.duration_s < plain.duration_s


def test_angle_controls_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="primitive, simultaneous"):
        plan(Configuration(), Configuration(), options=PlanOptions(controls="both"))


@pytest.mark.slow
def test_a_stored_scenario_is_quicker_by_far() -> None:
    """`nearby` in less than half the time of its plan by primitives."""
    scenario = find_scenario("nearby")
    quick, plain = (
        plan(scenario.start, scenario.goal, swimmer=scenario.swimmer, options=PlanOptions(controls=c))
        for c in ("simultaneous", "primitive")
    )
    assert quick.verdict == "reached"
    assert 2.0 * quick.duration_s < plain.duration_s


@pytest.mark.slow
def test_primitive_plans_are_left_as_they_are() -> None:
    assert all(isinstance(b.sequence, PrimitiveSequence) for b in solved("fast joints", "primitive").plan.blocks)
