"""Shorter motions: known upper bounds are met, limits hold, and the arrival stays exact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers import UNIT, assert_close, is_close, random_sequence, random_shapes

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.motion.clearance import least_clearance
from purcell_cli.motion.limb_circles import Sweeps
from purcell_cli.motion.limits import check
from purcell_cli.planner.refine.inequalities import bend_rows, clearance_rows, least_cosines, least_distances
from purcell_cli.planner.refine.minimum_travel import Pace, merged, offered, shorten
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.stretches import Stretch, stretches_of

KNOWN = {
    "0.1 L along x": ([0.01, 0.0, 0.0], [0.0, 0.0, 0.0], 0.7, 4.52),
    "0.05 L along y": ([0.0, 0.005, 0.0], [0.0, 0.0, 0.0], 1.5, 5.32),
    "0.05 L along z": ([0.0, 0.0, 0.005], [0.0, 0.0, 0.0], 1.5, 5.32),
    "a yaw of 5 degrees": ([0.0, 0.0, 0.0], [5.0, 0.0, 0.0], 1.5, 5.72),
    "a roll of 30 degrees": ([0.0, 0.0, 0.0], [0.0, 0.0, 30.0], 1.0, 0.371),
    "20 L along x": ([2.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0, 20 / 0.0451),
    "20 L along x, bent further": ([2.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.2, 20 / 0.0460),
    "(0.1, 0.05, 0.02) L and 5 degrees each": ([0.01, 0.005, 0.002], [5.0, 5.0, 5.0], 1.5, 8.72),
}
"""Position [m], Euler angles [deg], bend limit [rad] and the best joint travel known [rad]."""


@pytest.mark.parametrize("name", KNOWN)
def test_plans_meet_the_best_known_joint_travel(name: str) -> None:
    """Within 1.5 %; the quick plan, the foil, is longer where strokes can be joined."""
    position, angles, bend, best = KNOWN[name]
    swimmer, goal = Swimmer(max_bend_rad=bend), Configuration.from_angles(position, angles)
    found = plan(Configuration(), goal, swimmer=swimmer)
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= 1.015 * best
    axes = found.trajectory.shape[:, :, 0, 0]
    assert np.max(np.arccos(np.clip(axes, -1.0, 1.0))) <= bend + 1e-8
    quick = plan(Configuration(), goal, swimmer=swimmer, options=PlanOptions(effort="quick"))
    assert quick.verdict == "reached"
    assert quick.joint_travel_rad >= found.joint_travel_rad - 1e-6
    # The cruise, the crank and words of the book leave little to be joined.
    assert name not in ("0.1 L along x", "a yaw of 5 degrees") or quick.joint_travel_rad > 1.1 * best


def test_offered_controls_change_nothing_until_they_turn() -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", -0.3)])
    wide = offered(sequence, 2)
    assert len(wide) == 6 + 2 * 2 * 6
    assert list(merged(wide)) == [(name, pytest.approx(angle, abs=1e-15)) for name, angle in sequence]


WORD = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", 0.3), ("limb1 yaw", -0.3), ("limb2 roll", 0.2)])
LOOP = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.6), ("limb1 yaw", -0.5), ("limb2 yaw", -0.6)])
FIXED = PrimitiveSequence.of([("limb1 pitch", 0.2), ("limb2 yaw", 0.1), ("limb2 yaw", -0.1), ("limb1 pitch", -0.2)])


def motion(displacement: np.ndarray) -> Equations:
    """Return equations of free primitives about a repeated rectangle and another repeated stroke."""
    parts = [
        Stretch(1, (("a", 0.0, 4),), WORD),
        Stretch(2, (("b", 0.0, 4),), LOOP, cycles=7),
        Stretch(2, (("c", 0.0, 4),), WORD.inverse()),
        Stretch(2, (("d", 0.0, 4),), FIXED, cycles=3),
        Stretch(3, (("e", 0.0, 4),), WORD),
    ]
    return Equations(Swimmer().scaled(), parts, COLLINEAR, WORD.shapes(COLLINEAR)[-1], displacement)


def test_the_equations_see_every_cycle() -> None:
    """Against the flow of all cycles one after the other; the foil has one cycle fewer."""
    body = Swimmer().scaled()
    played = joined([WORD, LOOP.times(7), WORD.inverse(), FIXED.times(3), WORD])
    equations = motion(flow(body, played))
    assert_close(equations.residual(equations.angles)[:6], np.zeros(6), 1e-12)
    assert_close(equations.at(equations.angles).residual, equations.residual(equations.angles), 1e-12)
    fewer = joined([WORD, LOOP.times(6), WORD.inverse(), FIXED.times(3), WORD])
    assert not is_close(motion(flow(body, fewer)).residual(equations.angles)[:6], np.zeros(6), 1e-3)


def test_the_equations_have_the_derivative_they_say() -> None:
    """Central differences near the arrival, in free angles, sides of rectangles and shapes at phase ends."""
    played = joined([WORD, LOOP.times(7), WORD.inverse(), FIXED.times(3), WORD])
    equations = motion(flow(Swimmer().scaled(), played))
    angle, h = equations.angles, 1e-5
    assert len(angle) == 4 + 2 + 4 + 0 + 4
    rows = [0, 1, 2, 3, 4, 5, *range(18, 24)]  # at the ends of phases 1 and 2 the word is far from collinear
    differences = np.array(
        [(equations.residual(angle + d) - equations.residual(angle - d)) / (2 * h) for d in h * np.eye(len(angle))]
    ).T
    assert_close(equations.at(angle).derivative[rows], differences[rows], 1e-7)
    assert not is_close(equations.at(-angle).derivative[rows], differences[rows], 1e-3)


def test_the_equations_after_some_stretches_miss_the_same() -> None:
    """The base's twist and the gaps of later phases are those of the whole, and so is what the later angles change."""
    displacement = flow(Swimmer().scaled(), WORD) @ np.diag([1.0, -1.0, -1.0, 1.0])
    equations = motion(displacement)
    missing = equations.residual(equations.angles)[:6]
    last = equations.after(4, missing)
    angle = last.angles + 0.1
    whole = np.concatenate([equations.angles[:-4], angle])
    assert_close(last.residual(angle), np.delete(equations.residual(whole), slice(6, 18)), 1e-12)
    assert_close(last.at(angle).derivative[:6], equations.at(whole).derivative[:6, -4:], 1e-11)
    more = equations.after(2, missing)
    assert_close(more.residual(more.angles)[:6], missing, 1e-12)
    assert not is_close(missing, last.residual(angle)[:6], 1e-3)


def test_rectangles_close_whatever_their_sides() -> None:
    equations = motion(np.eye(4))
    angle = equations.angles.copy()
    angle[4:6] += [0.2, -0.1]
    loop = equations.with_angles(angle)[1]
    assert loop.rectangle
    assert_close(loop.sequence.shapes(COLLINEAR)[-1], COLLINEAR, 1e-15)


def alone(sequence: PrimitiveSequence, phase: int, start: Array, goal: Array) -> Equations:
    """Return the equations of one stretch in one phase."""
    parts = [Stretch(phase, (("a", 0.0, len(sequence)),), sequence)]
    return Equations(Swimmer().scaled(), parts, start, goal, np.eye(4))


def assert_slope(rows: Callable[[Array], tuple[Array, Array]], angle: Array, tolerance: float) -> None:
    """Assert that rows have the derivative they say."""
    derivative = rows(angle)[1]
    for k, step in enumerate(1e-6 * np.eye(len(angle))):
        assert_close(derivative[:, k], (rows(angle + step)[0] - rows(angle - step)[0]) / 2e-6, tolerance)


def test_the_room_below_the_bend_limit_has_the_derivative_it_says() -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.6), ("limb1 roll", 0.4), ("limb1 pitch", 0.5), ("limb2 yaw", 0.9)])
    equations = alone(sequence, 2, COLLINEAR, COLLINEAR)
    least = least_cosines(equations.phase, COLLINEAR, COLLINEAR, 0.9)

    def room(angle: Array) -> tuple[Array, Array]:
        sequence = equations.sequence_at(angle)
        return bend_rows(equations, sequence, sequence.shapes(COLLINEAR), least)

    assert len(room(sequence.angle)[0]) == 3
    assert_slope(room, sequence.angle, 1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_the_room_below_the_bend_limit_is_that_at_every_instant_on_large_turns_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sequence, start = random_sequence(rng, 8, 5.0), random_shapes(rng)
    equations = alone(sequence, 1, start, COLLINEAR)
    least = np.full((8, 2), 0.5)

    def room(angle: Array) -> tuple[Array, Array]:
        sequence = equations.sequence_at(angle)
        return bend_rows(equations, sequence, sequence.shapes(start), least)

    sweeps = Sweeps.of(sequence.shapes(start)[:-1], sequence.rates(), sequence.duration)
    bend = sweeps.largest_bends()[0][np.arange(8), sequence.control // 3]
    watched = (sequence.control % 3 != 0) & (np.cos(bend) - 0.5 < 0.35)
    ends = sequence.shapes(start)[np.arange(1, 9), sequence.control // 3, 0, 0]
    begins = sequence.shapes(start)[np.arange(8), sequence.control // 3, 0, 0]
    later = np.cos(bend) < begins - 1e-9  # where a primitive is most bent as it begins, the one before tells
    known = np.where(later, np.cos(bend), ends)[watched] - 0.5
    assert_close(room(sequence.angle)[0], known, 1e-12)
    assert np.any(np.cos(bend)[watched] < ends[watched] - 0.1)
    assert_slope(room, sequence.angle, 1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_the_room_between_the_limbs_is_that_of_the_clearance_and_has_the_derivative_it_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = np.stack([about_axis(2, 2.0), about_axis(2, -2.0)]) @ se3.rotation(0.03 * rng.normal(size=(2, 3)))
    sequence = random_sequence(rng, 6, 0.1)
    equations = alone(sequence, 1, start, COLLINEAR)
    least = least_distances(equations, 0.1)

    def room(angle: Array) -> tuple[Array, Array]:
        sequence = equations.sequence_at(angle)
        return clearance_rows(equations, sequence, sequence.shapes(start), least)

    shapes = sequence.shapes(start)
    found = room(sequence.angle)[0]
    assert len(found)
    apart = least_clearance(UNIT, shapes[:-1], sequence.rates(), sequence.duration).distance_m
    assert apart > 0.0  # where limbs cross, their distance has no derivative
    assert_close(np.min(found), apart - least[0], 1e-8)
    assert_slope(room, sequence.angle, 2e-4)  # the least distance is known to 1e-9


def test_a_motion_with_bent_limbs_becomes_shorter_and_keeps_its_limits() -> None:
    swimmer = Swimmer()
    start = Configuration.from_angles(limb1_euler_deg=(120.0, 0.0, 30.0), limb2_euler_deg=(-110.0, 20.0, 0.0))
    goal = Configuration.from_angles((0.02, 0.01, -0.01), (20.0, 10.0, 30.0), limb1_euler_deg=(0.0, 70.0, 0.0))
    begun = plan(start, goal, swimmer=swimmer, options=PlanOptions(effort="quick")).plan
    wanted = displacement_between(start, goal, swimmer.length_m)
    equations = Equations(swimmer.scaled(), stretches_of(begun.blocks), start.shape, goal.shape, wanted)
    found = shorten(equations, swimmer.max_bend_rad - 1e-5, Pace(rounds=2, steps=20))
    assert found.joint_travel_rad < 0.95 * begun.joint_travel_rad
    assert found.at(found.angles).size < 1e-4
    report = check(swimmer, start, found.blocks())
    assert report.clearance.distance_m > 0.0
    assert all(v.excess < 1e-4 for v in report.violations)


def test_a_small_displacement_in_all_directions_takes_a_word_that_no_hand_would_write() -> None:
    """(0.1, 0.05, 0.02) L and 5 degrees of yaw, pitch and roll: best known 8.72 rad."""
    goal = Configuration.from_angles([0.01, 0.005, 0.002], [5.0, 5.0, 5.0])
    found = plan(Configuration(), goal, swimmer=Swimmer(max_bend_rad=1.5), options=PlanOptions(effort="thorough"))
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= 1.03 * 8.72
