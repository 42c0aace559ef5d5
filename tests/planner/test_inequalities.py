"""The inequalities of a motion: which bend and which distance is allowed where, what room is left, and its slopes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import UNIT, assert_close, assert_slope, is_close, random_sequence, random_shapes, slope

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.clearance import least_clearance, limb_distance
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.refine.inequalities import clearance_rows, least_cosines, least_distances, limit_rows
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations


def motion(sequences: dict[int, PrimitiveSequence], start: Array, goal: Array) -> Equations:
    """Return the equations of one segment a phase."""
    parts = [Segment(phase, (("a", 0.0, len(s)),), s) for phase, s in sequences.items()]
    return Equations(Swimmer().scaled(), parts, start, goal, np.eye(4))


YAWS = PrimitiveSequence.of([("limb1 yaw", 0.6), ("limb1 roll", 0.4), ("limb1 pitch", 0.5), ("limb2 yaw", 0.9)])


def test_in_phases_one_and_three_a_limb_may_bend_as_far_as_its_shape_does() -> None:
    """In phase 2 as far as the limit allows, whatever the shapes; each limb for itself."""
    start = np.stack([about_axis(2, 1.4), about_axis(1, 0.2)])
    goal = np.stack([about_axis(1, -0.1), about_axis(2, 2.0)])
    phase = np.array([1, 2, 3, 3])
    wanted = np.cos([[1.4, 0.9], [0.9, 0.9], [0.9, 2.0], [0.9, 2.0]])
    found = least_cosines(phase, start, goal, 0.9)
    assert_close(found, wanted, 1e-15)
    assert not is_close(least_cosines(phase, goal, start, 0.9), wanted, 1e-2)


def room_of(equations: Equations, least: Array, angle: Array) -> tuple[Array, Array]:
    return limit_rows(equations, equations.at(angle), least)


def test_the_room_below_the_bend_limit_has_the_derivative_it_says() -> None:
    equations = motion({2: YAWS}, COLLINEAR, COLLINEAR)
    least = least_cosines(equations.phase, COLLINEAR, COLLINEAR, 0.9)
    found = room_of(equations, least, YAWS.angle)
    assert len(found[0]) == 3
    assert_slope(lambda angle: room_of(equations, least, angle), YAWS.angle, 1e-8)


def test_the_error_of_the_differences_falls_with_the_square_of_their_step() -> None:
    """So the derivative is the derivative, and not near it by chance; one of the limit beside it does not."""
    equations = motion({2: YAWS}, COLLINEAR, COLLINEAR)
    least = least_cosines(equations.phase, COLLINEAR, COLLINEAR, 0.9)
    steps, along = np.array([1e-2, 2e-2, 4e-2]), np.array([0.3, -0.5, 0.7, 0.4])
    exact = room_of(equations, least, YAWS.angle)[1] @ along
    errors, foil = [], []
    for h in steps:
        up, down = (room_of(equations, least, YAWS.angle + s * along)[0] for s in (h, -h))
        errors.append(np.max(np.abs((up - down) / (2.0 * h) - exact)))
        foil.append(np.max(np.abs((up - down) / (2.0 * h) - 1.01 * exact)))
    assert abs(slope(steps, errors) - 2.0) < 0.15
    assert abs(slope(steps, foil) - 2.0) > 0.5


@pytest.mark.parametrize("seed", range(4))
def test_the_room_below_the_bend_limit_is_that_at_every_instant_on_large_turns_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sequence, start = random_sequence(rng, 8, 5.0), random_shapes(rng)
    equations = motion({1: sequence}, start, COLLINEAR)
    least = np.full((8, 2), 0.5)
    sweeps = LimbCircles.of(Pieces.of(sequence, start))
    bend = sweeps.largest_bends()[0][np.arange(8), sequence.control // 3]
    watched = (sequence.control % 3 != 0) & (np.cos(bend) - 0.5 < 0.35)
    ends = sequence.shapes(start)[np.arange(1, 9), sequence.control // 3, 0, 0]
    begins = sequence.shapes(start)[np.arange(8), sequence.control // 3, 0, 0]
    later = np.cos(bend) < begins - 1e-9  # where a primitive is most bent as it begins, the one before tells
    known = np.where(later, np.cos(bend), ends)[watched] - 0.5
    assert_close(room_of(equations, least, sequence.angle)[0], known, 1e-12)
    assert np.any(np.cos(bend)[watched] < ends[watched] - 0.1)
    assert_slope(lambda angle: room_of(equations, least, angle), sequence.angle, 1e-7)


def test_limbs_far_below_the_limit_and_rolls_are_not_watched() -> None:
    sequence = PrimitiveSequence.of(
        [("limb1 yaw", 0.2), ("limb1 roll", 1.0), ("limb2 pitch", 0.95), ("limb2 roll", 1.0)]
    )
    equations = motion({2: sequence}, COLLINEAR, COLLINEAR)
    least = least_cosines(equations.phase, COLLINEAR, COLLINEAR, 1.0)
    room = room_of(equations, least, sequence.angle)[0]
    assert_close(room, [math.cos(0.95) - math.cos(1.0)], 1e-15)


def test_limbs_may_come_as_near_as_the_clearance_or_as_the_shape_has_them() -> None:
    """In phase 2 anyhow: within the bend limit they cannot meet."""
    near = np.stack([about_axis(2, 1.7), about_axis(2, -1.7)])
    apart = {1: float(limb_distance(UNIT, near[..., 0])), 3: float(limb_distance(UNIT, COLLINEAR[..., 0]))}
    assert apart[1] < apart[3]
    equations = motion({1: YAWS, 2: YAWS, 3: YAWS}, near, COLLINEAR)
    for clearance in (0.5 * apart[1], 0.5 * (apart[1] + apart[3]), 2.0 * apart[3]):
        least = least_distances(equations, clearance)
        assert np.all(least[equations.phase == 2] == -np.inf)
        for phase, known in apart.items():
            assert_close(least[equations.phase == phase], np.full(4, min(clearance, known)), 1e-3 + 1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_the_room_between_the_limbs_is_that_of_the_clearance_and_has_the_derivative_it_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = np.stack([about_axis(2, 2.0), about_axis(2, -2.0)]) @ se3.rotation(0.03 * rng.normal(size=(2, 3)))
    sequence = random_sequence(rng, 6, 0.1)
    equations = motion({1: sequence}, start, COLLINEAR)
    least = least_distances(equations, 0.1)

    def room(angle: Array) -> tuple[Array, Array]:
        sequence = equations.sequence_at(angle)
        return clearance_rows(equations, sequence, sequence.shapes(start), least)

    shapes = sequence.shapes(start)
    found = room(sequence.angle)[0]
    assert len(found)
    apart = least_clearance(UNIT, Pieces.between(sequence, shapes)).distance_m
    assert apart > 0.0  # where limbs cross, their distance has no derivative
    assert_close(np.min(found), apart - least[0], 1e-8)
    assert_slope(room, sequence.angle, 2e-4)  # the least distance is known to 1e-9
