"""The limits of a motion by other joints than balls, as inequalities, have the derivatives they say."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from helpers import assert_close, assert_slope
from reference.clearance_slack import clearance_slack as by_numpy

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint, limb_at
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import clearance_slack, clearances
from purcell_cli.planner.refine.inequalities import clearance_rows, limit_rows, range_rows
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

RANGED = Joint("universal", psi_deg=(-45.0, 60.0), theta_deg=(-40.0, 50.0))
START = np.stack([limb_at(0.3, -0.2), limb_at(-0.1, 0.4)])
TURNS = PrimitiveSequence.of([(6, 0.5), (1, 0.6), (7, -0.4), (6, -0.9), (4, 0.3), (1, -0.7), (7, 0.8), (4, -0.5)])


def motion(sequence: PrimitiveSequence, phase: int, joint: Joint = RANGED) -> Equations:
    swimmer = Swimmer(joints=(joint, joint)).scaled()
    segments = [Segment(phase, (("turns", math.nan, len(sequence)),), sequence)]
    return Equations(swimmer, segments, START, COLLINEAR, np.eye(4))


@pytest.mark.parametrize("rows", ["bends and ranges", "clearance"])
def test_rows_by_psi_and_theta_have_the_derivatives_they_say(rows: str) -> None:
    equations = motion(TURNS, 2 if rows == "bends and ranges" else 1)

    def of(angle: Array) -> tuple[Array, Array]:
        sequence = equations.sequence_at(angle)
        shapes = sequence.shapes(START)
        if rows == "clearance":
            return clearance_rows(equations, sequence, shapes, np.full(len(TURNS), 1.9))
        return limit_rows(equations, equations.at(angle), np.full((len(TURNS), 2), 0.55))

    assert len(of(TURNS.angle)[0]) > 4
    assert_slope(of, TURNS.angle, 1e-7)


def test_room_in_a_range_is_what_the_angles_leave_of_it() -> None:
    sequence = PrimitiveSequence.of([(6, 0.7), (6, -0.6), (1, 0.8)])
    room, slope = range_rows(motion(sequence, 2), sequence)
    margin = 1e-7
    assert_close(
        np.sort(room),
        np.sort([math.radians(60) - 1.0 - margin, math.radians(50) - 0.6 - margin]),
        1e-12,
    )
    assert sorted(map(tuple, slope)) == [(-1.0, 0.0, 0.0), (0.0, 0.0, -1.0)]
    free = dataclasses.replace(RANGED, psi_deg=None, theta_deg=None)
    assert len(range_rows(motion(sequence, 2, free), sequence)[0]) == 0


def test_an_angle_at_the_goal_may_be_at_the_end_of_its_range() -> None:
    edge = dataclasses.replace(RANGED, psi_deg=(0.0, 60.0))
    sequence = PrimitiveSequence.of([(6, -0.3)])
    room = range_rows(motion(sequence, 3, edge), sequence)[0]
    assert_close(np.min(room), 0.0, 1e-12)


@pytest.mark.parametrize(("bend", "looked_for"), [(1.3, False), (2.9, True)])
def test_limbs_are_looked_for_only_where_one_bends_beyond_a_right_angle(bend: float, looked_for: bool) -> None:
    sequence = PrimitiveSequence.of([(6, bend - 0.3), (6, -bend), (7, 0.1)])
    equations = motion(sequence, 1, Joint("universal"))
    shapes = sequence.shapes(START)
    room, _ = clearance_rows(equations, sequence, shapes, np.ones(3))
    apart, _ = clearances(equations.swimmer, Pieces.between(sequence, shapes), 1.3)
    assert len(room) == np.count_nonzero(apart < 1.25)
    assert bool(len(room)) == looked_for


@pytest.mark.parametrize("seed", range(60))
def test_the_room_between_limbs_is_that_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count, most = int(rng.integers(1, 12)), 8 if seed % 2 else 6
    sequence = PrimitiveSequence(rng.integers(0, most, count), rng.uniform(-2.0, 2.0, count))
    swimmer = Swimmer(slenderness=float(rng.uniform(0.005, 0.08))).scaled()
    shapes = sequence.shapes(np.stack([limb_at(*rng.uniform(-1.5, 1.5, 2)) for _ in range(2)]))
    least = np.where(rng.random(count) < 0.3, -np.inf, rng.uniform(0.0, 1.9, count))
    near = float(rng.uniform(0.05, 0.6))
    room, slope = clearance_slack(swimmer, sequence.control, sequence.angle, shapes, least, near)
    wanted = by_numpy(swimmer, sequence, shapes, least, near)
    assert_close(room, wanted[0], 1e-13)
    assert_close(slope, wanted[1], 1e-13)
