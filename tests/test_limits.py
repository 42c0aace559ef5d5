"""A plan keeps its limits at every instant of its path, or says by how much it does not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import assert_close, calls, mostly_slow, random_rotations, random_shapes

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clearance import apart_bend_rad, least_clearance
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.workspace import Workspace
from purcell_cli.planner.limbs.interleaving import interleaved
from purcell_cli.planner.limbs.shape_loops import shape_loops
from purcell_cli.planner.limbs.straightening import straightenings

ROUND = PrimitiveSequence.of([("limb1 yaw", 2.0 * math.pi)])
BENT = Configuration.from_angles(limb1_euler_deg=(100, 0, 0))


def test_a_bend_is_watched_at_every_instant_in_every_phase() -> None:
    for phase in (1, 2, 3):
        found = check(Swimmer(limb_half_length_m=0.04), Configuration(), [Block(phase, "round", ROUND)])
        (broken,) = found.violations
        assert (broken.limit, broken.unit, broken.phase, broken.what) == ("bend", "rad", phase, "limb 1")
        assert_close([broken.excess, broken.time_s], [math.pi - 1.0, math.pi], 1e-9)
        assert_close(found.largest_bend_rad[phase - 1], math.pi, 1e-9)
        assert found.largest_bend_rad[phase % 3] is None


def test_a_limb_may_bend_as_far_as_it_does_at_the_start_but_only_in_phase_one() -> None:
    back = PrimitiveSequence.of([("limb1 yaw", -math.radians(100))])
    further = PrimitiveSequence.of([("limb1 yaw", 1e-3), ("limb1 yaw", -math.radians(100) - 1e-3)])
    other = PrimitiveSequence.of([("limb2 yaw", 1.1), ("limb2 yaw", -1.1)])
    for sequence, phase, kept in ((back, 1, True), (back, 2, False), (further, 1, False), (other, 1, False)):
        assert check(Swimmer(), BENT, [Block(phase, "any", sequence)]).kept == kept
    forth = [Block(3, "any", back.inverse())]
    assert check(Swimmer(), Configuration(), forth).kept


def test_a_collision_is_told_with_where_and_when() -> None:
    turn = PrimitiveSequence.of([("limb2 yaw", 0.5), ("limb1 yaw", math.pi)])
    found = check(Swimmer(max_bend_rad=math.pi), Configuration(), [Block(2, "any", turn, 1)], Limits(0.01))
    (broken,) = found.violations
    assert (broken.limit, broken.unit, broken.phase, broken.what) == ("clearance", "m", 2, "limb 1 and limb 2")
    assert_close(broken.excess, 0.014, 1e-9)
    assert broken.time_s > 0.5
    assert not found.kept


def test_a_motion_of_nothing_has_a_clearance_and_no_bends() -> None:
    found = check(Swimmer(), BENT, [], Limits(0.1, Workspace((-1, -1, -1), (1, 1, 1))))
    assert found.kept
    assert found.largest_bend_rad == (None, None, None)
    still = np.zeros((1, 6)), np.zeros(1)
    assert found.clearance.distance_m == least_clearance(Swimmer(), Pieces(BENT.shape[None], *still)).distance_m


@pytest.mark.parametrize("clearance", [-1e-9, math.nan, math.inf])
def test_a_clearance_that_is_none_is_refused(clearance: float) -> None:
    with pytest.raises(ParameterError, match="clearance: a finite length of 0 m or more is wanted, found"):
        plan(Configuration(), Configuration(), options=PlanOptions(clearance_m=clearance))


def test_a_start_or_goal_in_collision_is_refused_and_one_that_just_keeps_its_clearance_is_not() -> None:
    folded = Configuration.from_angles(limb1_euler_deg=(0, 180, 0))
    for name, query in (("start", (folded, Configuration())), ("goal", (Configuration(), folded))):
        with pytest.raises(ParameterError, match=f"{name}: a clearance .* between limb 1 and limb 2 .* overlap"):
            plan(*query)
    assert plan(Configuration(), Configuration(), options=PlanOptions(clearance_m=0.196)).verdict == "reached"
    with pytest.raises(ParameterError, match=r"start: a clearance of at least 0\.196001 m"):
        plan(Configuration(), Configuration(), options=PlanOptions(clearance_m=0.196001))


@pytest.mark.slow
def test_a_plan_outside_its_workspace_is_not_found_within_limits() -> None:
    goal = Configuration.from_angles((0.02, 0.0, 0.0))
    found = plan(
        Configuration(), goal, options=PlanOptions(workspace=Workspace((-0.5, -0.01, -0.01), (0.5, 0.01, 0.01)))
    )
    assert found.certificate.reached
    assert found.verdict == "not found within limits"
    assert [v.limit for v in found.limits.violations] == ["workspace"]
    roomy = plan(Configuration(), goal, options=PlanOptions(workspace=Workspace((-1, -1, -1), (1, 1, 1))))
    assert roomy.verdict == "reached"


def test_to_check_a_motion_takes_no_more_work_however_often_its_loops_repeat() -> None:
    """One cycle of each tells of all; the foil, the same cycles one by one, takes more."""
    loop = PrimitiveSequence.of([("limb1 yaw", 1.0), ("limb2 yaw", 1.0), ("limb1 yaw", -1.0), ("limb2 yaw", -1.0)])

    def work(*cycles: int) -> int:
        return calls(lambda: check(Swimmer(), Configuration(), [Block(2, "any", loop, n) for n in cycles]))

    work(2)  # what is made once
    assert work(10_000) == work(10)
    assert work(*[1] * 20) > work(20)


@pytest.mark.parametrize("seed", mostly_slow(range(15), 1))
def test_limbs_are_straightened_without_touching_and_without_bending_further(seed: int) -> None:
    """Long limbs at random orientations, which some of the shortest ways would bring together."""
    swimmer = Swimmer(limb_half_length_m=0.2, slenderness=0.05).scaled()
    shape = random_shapes(np.random.default_rng(seed))
    here = Configuration(np.eye(4), shape)
    if not check(swimmer, here, []).kept:
        pytest.skip("the limbs touch to begin with")
    ways = straightenings(swimmer, [shape])[0]
    assert np.all(np.diff(ways.joint_travel_rad) >= -1e-8)
    more = interleaved(swimmer, [shape, COLLINEAR], [ways, straightenings(swimmer, [COLLINEAR])[0]], 6)
    assert len(more[0].order) > len(ways.order)
    assert len(more[1].order) == 1  # limbs that are straight need no turns
    for k in range(0, len(more[0].order), 7):
        sequence = more[0].sequence(k)
        assert sequence.joint_travel_rad == pytest.approx(more[0].joint_travel_rad[k], abs=1e-12)
        assert_close(sequence.shapes(shape)[-1], COLLINEAR, 1e-12)
        assert_close(more[0].displacement[k], flow(swimmer, sequence, shape), 3e-3)
        found = check(swimmer, here, [Block(1, "any", sequence)])
        assert found.kept, found.violations
    distinct = {tuple(map(tuple, zip(*more[0].sequence(k), strict=True))) for k in range(len(more[0].order))}
    assert len(distinct) == len(more[0].order)


@pytest.mark.parametrize("seed", mostly_slow(range(6), 0))
def test_shape_loops_lead_back_move_the_base_as_they_say_and_keep_the_limits(seed: int) -> None:
    swimmer = Swimmer(slenderness=0.03).scaled()
    shape = random_shapes(np.random.default_rng([7, seed]))
    here = Configuration(np.eye(4), shape)
    if not check(swimmer, here, []).kept:
        pytest.skip("the limbs touch to begin with")
    (round_,) = shape_loops(swimmer, [shape])
    ways = straightenings(swimmer, [shape])[0][np.arange(5)]
    every = round_.before(round_.before(ways))
    assert len(every) == 5 * (1 + len(round_.sequence)) ** 2
    assert len(round_.sequence) or np.max(bends(shape[..., 0])) < 2.6
    for k in np.random.default_rng(seed).integers(0, len(every), 12):
        sequence = every.sequence(int(k))
        assert sequence.joint_travel_rad == pytest.approx(every.joint_travel_rad[k], abs=1e-12)
        assert_close(sequence.shapes(shape)[-1], COLLINEAR, 1e-12)
        assert_close(every.displacement[k], flow(swimmer, sequence, shape), 1e-2)
        found = check(swimmer, here, [Block(1, "any", sequence)])
        assert found.kept, found.violations


def test_limbs_that_are_little_bent_make_no_shape_loops() -> None:
    shape = Configuration.from_angles(limb1_euler_deg=(60.0, 0.0, 0.0), limb2_euler_deg=(0.0, 70.0, 0.0)).shape
    assert [len(some.sequence) for some in shape_loops(Swimmer().scaled(), [shape, COLLINEAR])] == [0, 0]


@pytest.mark.parametrize("seed", range(3))
def test_a_bend_limit_at_which_limbs_could_meet_is_used_as_far_as_they_cannot(seed: int) -> None:
    swimmer = Swimmer(max_bend_rad=2.6)
    rng = np.random.default_rng(seed)
    goal = Configuration(se3.pose(random_rotations(rng), 0.5 * rng.normal(size=3)), COLLINEAR)
    solution = plan(Configuration(), goal, swimmer=swimmer)
    assert solution.verdict == "reached"
    assert solution.limits.clearance.distance_m >= 0.0
    largest = solution.limits.largest_bend_rad[1]
    assert largest is not None
    assert largest < apart_bend_rad(swimmer) < math.radians(120.0)
