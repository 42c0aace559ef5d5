"""Plans by every combination of joints arrive, use the axes that joints have, and stay in their ranges."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import mostly_slow
from joint_queries import COMBINATIONS, Query, joint_faults, plane_fault, random_query

from purcell_cli.errors import ParameterError
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joints import Joint, limb_at
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.arcs.primitive_counts import LEAST_BEND_RAD
from purcell_cli.solution import plan

QUICK = PlanOptions(effort=Effort.QUICK)
_QUERIES = [(name, seed) for seed in range(4) for name in COMBINATIONS]
"""Random queries; the first seed's are in every run, the first two of them in quick ones."""


@pytest.mark.parametrize("asked", mostly_slow(_QUERIES, 2, 2 * len(COMBINATIONS)))
def test_a_random_query_arrives_by_the_axes_and_within_the_ranges_of_its_joints(asked: tuple[str, int]) -> None:
    name, seed = asked
    query = random_query(name, seed)
    solution = plan(query.start, query.goal, swimmer=query.swimmer, options=QUICK)
    assert solution.verdict == Verdict.REACHED
    off = solution.certificate.deviation
    assert max(off.position_m / query.swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad) < 1e-9
    assert joint_faults(query, solution.trajectory) == []
    assert plane_fault(query, name, solution.trajectory) < 1e-12


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
