"""Plans for one joint beside a fixed limb: a universal joint's loops close by themselves, a ball joint's by a roll."""

from __future__ import annotations

import numpy as np
import pytest
from joint_queries import Query, joint_faults

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joints import Joint, limb_at
from purcell_cli.mechanics.lift import displacements
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.joints.loop import paired, rectangle, rolled
from purcell_cli.planner.joints.loops import loops_of
from purcell_cli.planner.joints.paired import cancelling
from purcell_cli.planning import plan

QUICK = PlanOptions(effort=Effort.QUICK)


def _swimmer(kind: str) -> Swimmer:
    return Swimmer(joints=(Joint(kind), Joint("fixed")))


def _configuration(degrees: float, psi: float, theta: float, pose: np.ndarray | None = None) -> Configuration:
    shape = np.stack([limb_at(psi, theta), limb_at(np.radians(degrees), 0.0)])
    return Configuration(np.eye(4) if pose is None else pose, shape)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "degrees"),
    [
        ("ball", 45.0),
        ("universal", 45.0),
        pytest.param("ball", 90.0, marks=pytest.mark.nightly),
        pytest.param("universal", 20.0, marks=pytest.mark.nightly),
    ],
)
def test_one_joint_beside_a_fixed_limb_out_of_line_reaches_a_pose(kind: str, degrees: float) -> None:
    swimmer = _swimmer(kind)
    start = _configuration(degrees, 0.3, -0.2)
    goal = _configuration(degrees, -0.4, 0.1, Configuration.from_angles((0.1, -0.05, 0.08), (20.0, 10.0, -30.0)).pose)
    solution = plan(start, goal, swimmer=swimmer, options=QUICK)
    assert solution.verdict == Verdict.REACHED
    assert solution.certificate.deviation.within(1e-9 * swimmer.length_m, 1e-9)
    assert joint_faults(Query(swimmer, start, goal), solution.trajectory) == []
    assert np.count_nonzero(solution.trajectory.rate_rad_s[:, 3:]) == 0  # the fixed limb rests


@pytest.mark.parametrize("degrees", [0.0, 12.0])
def test_a_ball_joint_beside_a_limb_almost_in_line_is_refused_with_the_directions(degrees: float) -> None:
    far = Configuration.from_angles((0.3, 0.0, 0.0), (0.0, 0.0, 0.0)).pose
    with pytest.raises(ParameterError, match=r"hardly, in: .*(surge|sway|heave)"):
        plan(_configuration(degrees, 0, 0), _configuration(degrees, 0, 0, far), swimmer=_swimmer("ball"), options=QUICK)


def test_loops_of_a_ball_joint_close_by_their_roll_whatever_their_size() -> None:
    loop = rolled(PrimitiveSequence.of([(0, 0.4), (1, -0.3)]), 0, [(0.8, 0.5, True), (-0.6, 0.7, False)])
    begun = loop.approach.shapes(np.tile(np.eye(3), (2, 1, 1)))[-1]
    for part in (1.0, 0.5, 0.1):
        cycle = loop.sized(part).cycle
        assert np.max(np.abs(cycle.shapes(begun)[-1] - begun)) < 1e-14
        assert cycle.angle[0] == pytest.approx(0.8 * part)
    open_ended = loop.cycle.with_angles(0.5 * loop.cycle.angle)
    assert np.max(np.abs(open_ended.shapes(begun)[-1] - begun)) > 1e-3


def test_pairs_of_loops_cancel_what_both_have_in_common() -> None:
    rng = np.random.default_rng(1)
    common = np.array([0.0, 0.0, -0.1, -0.3, -0.1, 0.0])
    twist = rng.uniform(0.7, 1.2, (20, 1)) * common + 0.02 * rng.normal(size=(20, 6))
    which, part = cancelling(twist, np.full(20, 4.0))
    assert len(which) > 6
    assert np.all((np.abs(part) > 0.3) & (np.abs(part) <= 1.0))
    left = twist[which[:, 0]] + part[:, None] * twist[which[:, 1]]
    assert np.max(np.abs(left @ common)) < 0.1 * np.min(np.abs(twist @ common))


def test_a_pair_of_loops_is_played_one_forward_and_one_backward() -> None:
    swimmer = _swimmer("universal").scaled()
    home = _configuration(60.0, 0.0, 0.0).shape
    first = rectangle((1, 6), (-0.5, 0.5), (0.1, 0.6), None)
    second = rectangle((1, 6), (-0.2, 0.5), (-0.6, 0.3), None)
    moves = []
    for loop, forward in ((first, True), (second, False)):
        cycle = loop.cycle if forward else loop.cycle.inverse()
        played = loop.approach + cycle + loop.approach.inverse()
        moves.append(se3.prefix_products(displacements(swimmer, played, home))[-1])
    pair = paired((first, second), (True, False))
    assert pair.approach is EMPTY
    made = se3.prefix_products(displacements(swimmer, pair.cycle, home))[-1]
    assert np.max(np.abs(made - moves[0] @ moves[1])) < 1e-10
    assert np.max(np.abs(made - moves[0] @ se3.inverse(moves[1]))) > 1e-3
    half = pair.sized(0.5)
    assert half.cycle.joint_travel_rad < pair.cycle.joint_travel_rad
    assert np.max(np.abs(half.cycle.shapes(home)[-1] - home)) < 1e-12


def test_pairs_are_made_for_one_joint_alone() -> None:
    swimmer = _swimmer("universal").scaled()
    home = _configuration(60.0, 0.0, 0.0).shape
    every = loops_of(swimmer, home)
    twists = np.abs(every.screws.twist / every.screws.travel[:, None])
    assert every.pairs > 6
    assert np.min(twists[-every.pairs :, 3]) < 0.1 * np.max(twists[:, 3])
    both = Swimmer(joints=(Joint("universal"), Joint("universal"))).scaled()
    assert loops_of(both, np.tile(np.eye(3), (2, 1, 1))).pairs == 0
