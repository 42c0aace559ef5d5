"""Plans by every combination of joints arrive, use the axes that joints have, and stay in their ranges."""

from __future__ import annotations

import dataclasses
import itertools
import math
import types
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from helpers import NIGHTLY, assert_close, mostly_slow
from joint_queries import COMBINATIONS, EVERY, Query, joint_faults, plane_fault, random_query
from reintegrated import displacement

from purcell_cli.errors import ParameterError
from purcell_cli.files.plan_file import PlanDocument, load_plan, write_plan
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_motion import bend_limits, home_shape, joint_rates
from purcell_cli.mechanics.joint_turns import by_turns, choices, columns, rotation_vectors
from purcell_cli.mechanics.joints import Joint, limb_at
from purcell_cli.mechanics.lift import displacements
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.options import Controls, Effort, PlanOptions
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.arcs.primitive_counts import LEAST_BEND_RAD
from purcell_cli.planner.joints.loops import loops_of
from purcell_cli.planner.refine.inequalities import range_rows
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planning import plan

QUICK = PlanOptions(effort=Effort.QUICK)
_QUERIES = [(name, seed) for seed in range(4) for name in EVERY]
"""Random queries; the first seed's are in every run, the first two of them in quick ones."""


@pytest.mark.parametrize("asked", mostly_slow(_QUERIES, 2, 2 * len(EVERY)))
def test_a_random_query_arrives_by_the_axes_and_within_the_ranges_of_its_joints(asked: tuple[str, int]) -> None:
    name, seed = asked
    query = random_query(name, seed)
    solution = plan(query.start, query.goal, swimmer=query.swimmer, options=QUICK)
    assert solution.verdict == Verdict.REACHED
    off = solution.certificate.deviation
    assert max(off.position_m / query.swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad) < 1e-9
    assert joint_faults(query, solution.trajectory) == []
    assert plane_fault(query, name, solution.trajectory) < 1e-12


AT_ONCE = [
    pytest.param(name, marks=pytest.mark.slow if name == "yaw hinges" else NIGHTLY)
    for name in (*COMBINATIONS, "ball joint and fixed limb")
]


SEEDS = {"yaw hinges": 1, "yaw and pitch hinge": 4}
"""Of the first queries of these, one has ranges that leave no room to round corners, and one gains less than asked."""


@pytest.mark.parametrize("name", AT_ONCE)
def test_joints_turn_at_once(name: str) -> None:
    """In less time than one by one, as exactly, by the axes and within the ranges of the joints, and at their rates."""
    query = random_query(name, SEEDS.get(name, 0), 5.0)
    first, second = query.swimmer.joints
    slow = first if first.kind == "fixed" else first.at_rate(0.5)
    swimmer = dataclasses.replace(query.swimmer, joints=(slow, second))
    query = dataclasses.replace(query, swimmer=swimmer)
    asked = (PlanOptions(effort=Effort.QUICK, controls=controls) for controls in Controls)
    plain, quick = (plan(query.start, query.goal, swimmer=swimmer, options=options) for options in asked)
    assert (plain.verdict, quick.verdict) == (Verdict.REACHED, Verdict.REACHED)
    assert quick.controls == Controls.SIMULTANEOUS
    assert quick.duration_s < 0.995 * plain.duration_s
    assert quick.certificate.deviation.within(1e-9 * swimmer.length_m, 1e-9)
    rows = quick.trajectory
    assert joint_faults(query, rows) == []
    assert plane_fault(query, name, rows) < 1e-12
    turning = joint_rates(swimmer, rows.shape, rows.rate_rad_s)
    busy = np.max(np.abs(turning).reshape(-1, 2, 3), axis=(0, 2))
    assert_close(
        busy, [swimmer.rate_of(limb) if swimmer.joints[limb].kind != "fixed" else 0.0 for limb in (0, 1)], 1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["universal joints", "ball and universal joint"])
def test_universal_joints_turn_at_once_with_the_other_joint(name: str, tmp_path: Path) -> None:
    """One angle of each limb at once, each about an axis that is constant in the limb; its file makes the same plan."""
    swimmer, goal = Swimmer(joints=COMBINATIONS[name]), Configuration.from_angles((0.003, 0.001, 0.001))
    asked = (PlanOptions(effort=Effort.QUICK, controls=controls) for controls in Controls)
    plain, quick = (plan(Configuration(), goal, swimmer=swimmer, options=options) for options in asked)
    assert (quick.verdict, quick.controls) == (Verdict.REACHED, Controls.SIMULTANEOUS)
    assert quick.duration_s < 0.8 * plain.duration_s
    assert quick.certificate.deviation.within(1e-9 * swimmer.length_m, 1e-9)
    assert joint_faults(Query(swimmer, Configuration(), goal), quick.trajectory) == []
    write_plan(PlanDocument(quick.plan), tmp_path / "plan.json")
    again = load_plan(tmp_path / "plan.json").plan
    assert_close(again.joint_travel_rad, quick.plan.joint_travel_rad, 1e-12)
    # The foil: limb rates say that universal joints turn further than they do.
    felt = sum(float(np.sum(np.abs(block.sequence.rates()))) for block in quick.plan.blocks)
    known = sum(float(np.sum(np.abs(cast(MoveSequence, block.sequence).joint_rate))) for block in quick.plan.blocks)
    assert felt > known + 1e-3


@pytest.mark.parametrize("joints", [COMBINATIONS[name] for name in ("universal joints", "ball and universal joint")])
def test_rotation_vectors_of_universal_joints_change_with_the_turns_before(joints: tuple[Joint, Joint]) -> None:
    """The shapes are those of psi and theta, and derivatives those of small changes; without tilts (the foil) not."""
    swimmer, rng = Swimmer(joints=joints), np.random.default_rng(5)
    turn = np.zeros((6, 6))
    for k, way in enumerate(itertools.islice(itertools.cycle(choices(swimmer)), 6)):
        turn[k, list(way)] = rng.uniform(-1.0, 1.0, len(way))
    start = np.stack([limb_at(0.3, -0.6)] * 2)
    made = MoveSequence.of_turns(rotation_vectors(swimmer, start, turn)).shapes(start)[-1, 1]
    psi, theta = 0.3 + np.sum(turn[:, 5]), -0.6 + np.sum(turn[:, 4])
    assert_close(made, limb_at(psi, theta), 1e-14)
    slope = by_turns(swimmer, start, turn, np.eye(36))
    change = np.zeros((6, 6))
    change[:, columns(swimmer)] = 1e-6 * rng.normal(size=(6, len(columns(swimmer))))
    more, less = (rotation_vectors(swimmer, start, turn + sign * change) for sign in (1.0, -1.0))
    assert_close(slope @ change.ravel(), 0.5 * (more - less).ravel(), 1e-14)
    tilts = slope.reshape(6, 6, 6, 6)[2:, :, 0]  # of later vectors by the first turn
    assert np.max(np.abs(tilts)) > 0.1


def test_room_in_the_ranges_of_joints_is_linear_in_the_turns() -> None:
    """Only the range that is near is looked at: limb 2's pitch; its yaw (the foil) changes nothing."""
    joints = (Joint("hinge", "yaw", psi_deg=(-25.0, 30.0)), Joint("hinge", "pitch", theta_deg=(-18.0, 18.0)))
    swimmer, rng = Swimmer(joints=joints).scaled(), np.random.default_rng(2)
    turn = np.zeros((3, 6))
    turn[:, [2, 4]] = rng.uniform(-0.01, 0.01, (3, 2))

    def room(turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        motion = Equations(swimmer, [Segment.by_moves(2, "any", turn)], COLLINEAR, COLLINEAR, np.eye(4))
        return range_rows(motion, motion.sequence)

    here, slope = room(turn)
    change = np.zeros((3, 6))
    change[:, [2, 4]] = rng.uniform(-1e-3, 1e-3, (3, 2))
    assert len(here) == 6  # the range of limb 1 is farther off
    assert_close(room(turn + change)[0] - here, slope @ change.ravel(), 1e-12)
    other = turn.copy()
    other[:, 5] = 0.1
    assert_close(room(other)[0], here, 0.0)
    theta = np.cumsum(turn[:, 4])
    assert_close(here, np.concatenate([theta, -theta]) + math.radians(18.0), 2e-7)


@pytest.mark.slow
def test_one_universal_joint_reaches_every_pose_where_the_other_limb_is_fixed_out_of_line() -> None:
    swimmer = Swimmer(joints=(Joint("universal"), Joint("fixed")))
    fixed = limb_at(np.pi / 2.0, 0.0)
    start = Configuration(np.eye(4), np.stack([limb_at(0.2, -0.3), fixed]))
    displacement = Configuration.from_angles((0.05, 0.03, -0.04), (10.0, -5.0, 8.0)).pose
    goal = Configuration(displacement, np.stack([limb_at(-0.4, 0.1), fixed]))
    solution = plan(start, goal, swimmer=swimmer, options=QUICK)
    assert solution.verdict == Verdict.REACHED
    assert solution.certificate.deviation.within(1e-9 * swimmer.length_m, 1e-9)
    assert joint_faults(Query(swimmer, start, goal), solution.trajectory) == []
    assert np.array_equal(
        solution.trajectory.shape[:, 1], np.broadcast_to(fixed, solution.trajectory.shape[:, 1].shape)
    )
    # In line the same joints are hopeless.
    with pytest.raises(ParameterError, match="hardly, in: surge"):
        plan(Configuration(), Configuration(displacement), swimmer=swimmer, options=QUICK)


def test_pairs_of_loops_beside_a_fixed_limb_do_not_hang_on_how_its_bend_is_rounded() -> None:
    """A fixed limb is at its own bend limit, whichever way it is turned; without pairs no chain reached far poses."""
    swimmer = Swimmer(max_bend_rad=0.9, joints=(Joint("fixed"), Joint("universal", theta_deg=(-75.0, -8.0)))).scaled()
    rng, bends = np.random.default_rng(3), set[bool]()
    for _ in range(5):
        fixed = from_euler([0.0, *rng.uniform(0.92, 1.3, 1), rng.uniform(-3.0, 3.0)])
        home = home_shape(swimmer, np.stack([fixed, limb_at(0.2, -0.4)]))
        every = loops_of(swimmer, home)
        assert every.pairs > 10
        loop = every.others[-1]
        found = LimbCircles.of(Pieces.of(loop.approach + loop.cycle, home)).largest_bends()[0]
        bends.add(bool(np.all(found[:, 0] <= bend_limits(swimmer, home)[0])))
    assert bends == {True, False}  # the foil: without slack for rounding some have none


@pytest.mark.slow
def test_one_universal_joint_of_a_one_sided_range_reaches_a_far_pose_beside_a_fixed_limb() -> None:
    name = "universal joint and fixed limb"
    query = random_query(name, 427)
    solution = plan(query.start, query.goal, swimmer=query.swimmer, options=QUICK)
    assert solution.verdict == Verdict.REACHED
    assert joint_faults(query, solution.trajectory) == []


@pytest.mark.slow
def test_the_check_of_joints_finds_what_they_cannot_do() -> None:
    query = random_query("universal joints", 0)
    rows = plan(
        query.start, query.goal, swimmer=dataclasses.replace(query.swimmer, joints=(Joint(), Joint()))
    ).trajectory
    assert any("axis that its joint has not" in fault for fault in joint_faults(query, rows))
    narrow = Joint("hinge", "yaw", psi_deg=(-20.0, 20.0))
    query = random_query("yaw hinges", 0)
    wide = Swimmer(joints=(Joint("hinge", "yaw"), Joint("hinge", "yaw")))
    rows = plan(query.start, query.goal, swimmer=wide, options=QUICK).trajectory
    held = dataclasses.replace(query, swimmer=Swimmer(joints=(narrow, narrow)))
    assert any("leaves its range" in fault for fault in joint_faults(held, rows))
    assert np.all(np.isfinite(rows.time_s))


@pytest.mark.parametrize("bend", [0.1, 0.4])
def test_small_bends_for_which_no_chain_is_found_are_refused_with_the_key(
    bend: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("purcell_cli.planner.joints.candidates.joint_candidates", lambda *_: [])
    swimmer = Swimmer(max_bend_rad=bend, joints=COMBINATIONS["universal joint and yaw hinge"])
    asked = Configuration(), Configuration.from_angles((0.05, 0.0, 0.0))
    if bend > LEAST_BEND_RAD:
        assert plan(*asked, swimmer=swimmer).verdict == "not reached"
        return
    with pytest.raises(ParameterError, match=r"^max_bend_rad: .*found none within 0\.1 rad .*from 0\.3 on"):
        plan(*asked, swimmer=swimmer)


def test_the_integration_that_judges_plans_is_of_sixth_order_and_finds_another_drag() -> None:
    """It agrees with the flow; another drag ratio (the foil) ends elsewhere."""
    query = random_query("universal joints", 1)
    begun = query.start.shape
    sequence = PrimitiveSequence.of([(1, 0.4), (7, -0.3), (6, 0.5), (1, -0.2)])
    shapes = sequence.shapes(begun)
    time_s = np.append(0.0, np.cumsum(sequence.duration))
    rates = np.concatenate([sequence.rates(shapes[:-1]), np.zeros((1, 6))])
    rows = cast(Trajectory, types.SimpleNamespace(time_s=time_s, shape=shapes, rate_rad_s=rates))
    wanted = se3.prefix_products(displacements(query.swimmer, sequence, begun))[-1]
    off = [float(np.max(np.abs(displacement(query.swimmer, rows, step) - wanted))) for step in (0.2, 0.1, 0.02)]
    assert off[0] > 20.0 * off[1]
    assert off[2] < 1e-12
    other = dataclasses.replace(query.swimmer, drag_ratio=1.9)
    assert np.max(np.abs(displacement(other, rows, 0.02) - wanted)) > 1e-4
