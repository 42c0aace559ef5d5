"""The lift: exact against an independent integrator, of the order it claims, true to the laws of Stokes swimming."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from helpers import (
    PITCH_1,
    PITCH_2,
    ROLL_1,
    ROLL_2,
    UNIT,
    YAW_1,
    YAW_2,
    assert_close,
    bent,
    dop853_flow,
    dop853_rates,
    in_lengths,
    is_close,
    mostly_slow,
    random_rotations,
    random_sequence,
    random_shapes,
    random_swimmer,
    slope,
)

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, as_euler
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.connection import COLLINEAR, base_twist, power
from purcell_cli.mechanics.lift import displacements, flow, flow_of_rates, work
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

of = PrimitiveSequence.of
ONE = np.eye(4)
UNGRADED = 1e3
"""A step that never cuts a piece: each piece is one step of the method."""


def loop(a: float, b: float, first: int = YAW_1, second: int = YAW_2) -> PrimitiveSequence:
    """Return the rectangle: one control by a, another by b, and both back."""
    return of([(first, a), (second, b), (first, -a), (second, -b)])


# --- Against an independent integrator -----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_flow_is_the_solution_of_the_equations_of_motion(seed: int) -> None:
    """Random swimmers, shapes and sequences: off by less than 1e-12 (L, rad) per radian of joint travel."""
    rng = np.random.default_rng(seed)
    swimmer, sequence, start = random_swimmer(rng), random_sequence(rng, 5), random_shapes(rng)
    found, wanted = flow(swimmer, sequence, start), dop853_flow(swimmer, sequence, start)
    assert_close(in_lengths(swimmer, found), in_lengths(swimmer, wanted), 1e-12, sequence.joint_travel_rad)


SWIMMERS = {
    "equal links": UNIT,
    "short stout limbs": Swimmer(1.0, 0.3, slenderness=0.05),
    "long thin limbs": Swimmer(1.0, 3.0, slenderness=0.002, drag_ratio=1.7),
    "small and thin": Swimmer(0.01, 0.01, slenderness=0.002),
}


@pytest.mark.parametrize("beside", mostly_slow([0.1, 0.001, 0.003, 0.01, 0.03], 1))
@pytest.mark.parametrize("swimmer", SWIMMERS.values(), ids=SWIMMERS)
def test_flow_is_exact_where_a_limb_passes_the_collinear_shape(swimmer: Swimmer, beside: float) -> None:
    """A(r) is sharp there: the graded mesh keeps 1e-12, one step of the same method (the foil) does not."""
    sequence, start = of([(YAW_1, 0.6)]), bent(beside, -0.3)
    wanted = in_lengths(swimmer, dop853_flow(swimmer, sequence, start))
    assert_close(in_lengths(swimmer, flow(swimmer, sequence, start)), wanted, 1e-12)
    if swimmer.roll_sharpness() < 0.2:
        one_step = flow(swimmer, sequence, start, Accuracy(step=UNGRADED))
        assert not is_close(in_lengths(swimmer, one_step), wanted, 1e-9)


@pytest.mark.parametrize("beside", [0.01, 0.1])
@pytest.mark.parametrize("ratio", [1.0, 2.0, 3.0, 10.0])
def test_flow_is_exact_where_a_limb_passes_the_parallel_of_the_other(ratio: float, beside: float) -> None:
    """Parallel limbs longer than the base are nearly one line beside it, and A(r) is sharp there as well.

    A mesh graded by the limbs' bends from the base alone errs by 4e-10 for limbs thrice as long, 1e-4 for ten times.
    """
    swimmer = Swimmer(1.0, ratio, slenderness=0.002).scaled()
    start = np.stack([about_axis(2, 1.2) @ bent(beside, -0.3)[0], about_axis(2, 1.2)])
    sequence = of([(YAW_1, 0.6)])
    assert_close(flow(swimmer, sequence, start), dop853_flow(swimmer, sequence, start), 1e-12)


def test_uniform_steps_of_a_sixteenth_are_not_enough_near_the_collinear_shape() -> None:
    """A 6th-order step of 1/16 rad is exact in a planar stroke and errs by 1e-8 or more beside the collinear shape."""
    steps = of([(YAW_1, 1 / 16)]).times(10)
    coarse = Accuracy(stages=3, step=UNGRADED)
    planar = COLLINEAR.copy()
    planar[1] = about_axis(2, 0.9)
    assert_close(flow(UNIT, steps, planar, coarse), flow(UNIT, steps, planar), 1e-12)
    beside = bent(0.05, -0.3)
    assert not is_close(flow(UNIT, steps, beside, coarse), flow(UNIT, steps, beside), 1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_exact_is_exact_to_the_digits_it_claims(seed: int) -> None:
    """Twice as fine a mesh with more stages changes nothing above 1e-13 per radian."""
    rng = np.random.default_rng(100 + seed)
    swimmer, sequence = random_swimmer(rng).scaled(), random_sequence(rng, 40)
    finer = flow(swimmer, sequence, accuracy=Accuracy(stages=10, step=0.2))
    assert_close(flow(swimmer, sequence), finer, 1e-13, sequence.joint_travel_rad)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("slenderness", [0.002, 0.01, 0.05])
def test_no_primitive_among_many_is_off(ratio: float, slenderness: float) -> None:
    """The worst of 1500 random primitives errs by less than 2e-12 (L, rad) against a much finer mesh."""
    swimmer = Swimmer(1.0, ratio, slenderness=slenderness).scaled()
    sequence = random_sequence(np.random.default_rng(430), 1500)
    finer = displacements(swimmer, sequence, accuracy=Accuracy(stages=10, step=0.15))
    assert_close(displacements(swimmer, sequence), finer, 2e-12)


@pytest.mark.parametrize("seed", mostly_slow(range(4), 1))
def test_all_six_controls_at_once_solve_the_equations_of_motion(seed: int) -> None:
    """Both limbs turning about oblique axes at once."""
    rng = np.random.default_rng(200 + seed)
    swimmer, start = random_swimmer(rng), random_shapes(rng)
    rate, duration = rng.normal(size=(3, 6)), rng.uniform(0.1, 0.8, 3)
    _, found = flow_of_rates(swimmer, rate, duration, start)
    wanted = dop853_rates(swimmer, rate, duration, start)
    travel = float(np.abs(rate).sum(axis=1) @ duration)
    assert_close(in_lengths(swimmer, found[-1]), in_lengths(swimmer, wanted), 1e-12, travel)


@pytest.mark.parametrize("angle", [1.0, 10.0, 40.0, 100.0])
@pytest.mark.parametrize("control", [ROLL_1, ROLL_2])
@pytest.mark.parametrize("bend", [0.0, 0.01, 0.8])
def test_a_long_roll_is_a_constant_twist(angle: float, control: int, bend: float) -> None:
    """A limb rolling about its own axis keeps the drag as it is, so the flow is exp(-A e t), however long it lasts."""
    start = bent(0.0, bend)
    wanted = se3.exp(angle * base_twist(UNIT, start, np.eye(6)[control]))
    assert_close(flow(UNIT, of([(control, angle)]), start), wanted, 1e-12, angle)


# --- Order ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("stages", "counts"), [(1, (16, 32, 64, 128)), (2, (4, 8, 16, 32)), (3, (2, 3, 4, 6, 8))])
def test_order_is_twice_the_stages(stages: int, counts: tuple[int, ...]) -> None:
    """On equal steps of a path with both limbs turning, limb 2 bent by 1.5 rad."""
    start = bent(0.2, 0.4)
    start[1] = about_axis(2, 1.5)
    rate = np.array([0.5, 1.2, -0.9, 0.7, 0.3, 0.2])
    wanted = flow_of_rates(UNIT, rate, 1.0, start)[1][-1]
    errors = []
    for n in counts:
        found = flow_of_rates(UNIT, np.tile(rate, (n, 1)), np.full(n, 1 / n), start, Accuracy(stages, UNGRADED))
        errors.append(float(np.max(np.abs(found[1][-1] - wanted))))
    assert min(errors) > 1e-13
    assert abs(slope(1 / np.array(counts), errors) - 2 * stages) < 0.15


def test_a_finer_graded_mesh_is_better() -> None:
    """Where the mesh is graded, halving `step` thrice gains as the order says, or more."""
    sequence, start = of([(YAW_1, 0.6)]), bent(0.05, -0.3)
    wanted = flow(UNIT, sequence, start)
    for stages in (1, 2):
        found = [flow(UNIT, sequence, start, Accuracy(stages, step)) for step in (1 / 4, 1 / 32)]
        coarse, fine = (float(np.max(np.abs(g - wanted))) for g in found)
        assert fine < coarse / 8 ** (2 * stages) * 6


# --- Laws of Stokes swimming ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("control", range(6))
def test_scallop_theorem(control: int) -> None:
    """One degree of freedom there and back goes nowhere, from any shape; two of them do (the foil)."""
    start = random_shapes(np.random.default_rng(300 + control))
    there_and_back = of([(control, 0.4), (control, 0.7), (control, -1.9), (control, 0.8)])
    assert_close(flow(UNIT, there_and_back, start), ONE, 1e-12)
    other = (control + 4) % 6
    assert not is_close(flow(UNIT, loop(0.8, 0.8, control, other), start), ONE, 1e-4)


def test_scallop_theorem_for_a_curve_in_shape_space() -> None:
    """A path of all six rates retraced goes nowhere, though it is traced at other speeds on the way back."""
    rng = np.random.default_rng(301)
    start, rate, duration = random_shapes(rng), rng.normal(size=(4, 6)), rng.uniform(0.1, 0.5, 4)
    back = -3.0 * rate[::-1]
    times = np.concatenate([duration, duration[::-1] / 3])
    shapes, poses = flow_of_rates(UNIT, np.concatenate([rate, back]), times, start)
    assert_close(shapes[-1], start, 1e-14)
    assert_close(poses[-1], ONE, 1e-12)
    assert not is_close(poses[4], ONE, 1e-3)
    _, forward_again = flow_of_rates(UNIT, np.concatenate([rate, -back]), times, start)
    assert not is_close(forward_again[-1], ONE, 1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_reversal_is_the_inverse(seed: int) -> None:
    """A sequence run backwards undoes its motion; reversed order without the opposite signs (the foil) does not."""
    rng = np.random.default_rng(310 + seed)
    swimmer, sequence, start = random_swimmer(rng).scaled(), random_sequence(rng, 8), random_shapes(rng)
    end = sequence.shapes(start)[-1]
    there = flow(swimmer, sequence, start)
    assert_close(flow(swimmer, sequence + sequence.inverse(), start), ONE, 1e-12)
    assert_close(flow(swimmer, sequence.inverse(), end), se3.inverse(there), 1e-12)
    foil = PrimitiveSequence(sequence.control[::-1], sequence.angle[::-1])
    assert not is_close(flow(swimmer, foil, end), se3.inverse(there), 1e-3)


def test_displacement_is_the_same_from_every_pose() -> None:
    """Left invariance, with the pose integrated in the world; the spatial displacement g_end g_start^-1 is the foil."""
    rng = np.random.default_rng(320)
    sequence, start = random_sequence(rng, 4), random_shapes(rng)
    wanted = flow(UNIT, sequence, start)
    for _ in range(2):
        pose = se3.pose(random_rotations(rng), rng.normal(size=3))
        end = dop853_flow(UNIT, sequence, start, pose)
        assert_close(se3.inverse(pose) @ end, wanted, 1e-11)
        assert not is_close(end @ se3.inverse(pose), wanted, 1e-3)


def test_displacements_chain() -> None:
    """The flow is the ordered product of the primitives' displacements, each of them a flow from its own shape."""
    rng = np.random.default_rng(321)
    sequence, start = random_sequence(rng, 6), random_shapes(rng)
    steps, shapes = displacements(UNIT, sequence, start), sequence.shapes(start)
    for k in range(6):
        assert_close(steps[k], flow(UNIT, sequence[k : k + 1], shapes[k]), 1e-14)
    assert_close(np.linalg.multi_dot(list(steps)), flow(UNIT, sequence, start), 1e-13)
    assert not is_close(np.linalg.multi_dot(list(steps[::-1])), flow(UNIT, sequence, start), 1e-3)
    assert_close(flow(UNIT, EMPTY), ONE, 0.0)
    assert displacements(UNIT, EMPTY).shape == (0, 4, 4)


def test_cutting_a_primitive_changes_nothing() -> None:
    """One turn is two turns of half its angle; a zero turn is none."""
    whole = of([(PITCH_1, 0.7), (YAW_2, -0.9)])
    cut = of([(PITCH_1, 0.35), (PITCH_1, 0.35), (ROLL_2, 0.0), (YAW_2, -0.2), (YAW_2, -0.7)])
    assert_close(flow(UNIT, cut), flow(UNIT, whole), 1e-13)


def test_path_does_not_depend_on_the_rate() -> None:
    """Rates times a factor and durations over it give the same path; rates alone (the foil) do not."""
    rng = np.random.default_rng(330)
    rate, duration, start = rng.normal(size=(5, 6)), rng.uniform(0.1, 0.5, 5), random_shapes(rng)
    factor = np.array([0.01, 3.0, 100.0, 1.0, 0.5])
    shapes, poses = flow_of_rates(UNIT, rate, duration, start)
    found_shapes, found = flow_of_rates(UNIT, rate * factor[:, None], duration / factor, start)
    assert_close(found_shapes, shapes, 1e-14)
    assert_close(found, poses, 1e-13)
    _, foil = flow_of_rates(UNIT, rate * factor[:, None], duration, start)
    assert not is_close(foil, poses, 1e-3)


def test_primitives_are_paths_of_rates() -> None:
    """flow_of_rates of a sequence's rates passes through the shapes and poses of the sequence."""
    rng = np.random.default_rng(331)
    swimmer, sequence, start = random_swimmer(rng), random_sequence(rng, 12), random_shapes(rng)
    shapes, poses = flow_of_rates(swimmer, sequence.rates(), np.abs(sequence.angle), start)
    assert_close(shapes, sequence.shapes(start), 1e-13)
    wanted = se3.prefix_products(displacements(swimmer, sequence, start))
    assert_close(in_lengths(swimmer, poses), in_lengths(swimmer, wanted), 1e-13)
    assert_close(in_lengths(swimmer, poses[-1]), in_lengths(swimmer, flow(swimmer, sequence, start)), 1e-13)


def test_viscosity_does_not_move_the_path() -> None:
    """The path is bitwise the same in any fluid; the drag ratio (the foil) moves it."""
    rng = np.random.default_rng(332)
    swimmer, sequence = random_swimmer(rng), random_sequence(rng, 10)
    path = flow(swimmer, sequence)
    for viscosity in (1e-6, 1.0, 1e9):
        assert_close(flow(dataclasses.replace(swimmer, viscosity_pa_s=viscosity), sequence), path, 0.0)
    other = dataclasses.replace(swimmer, drag_ratio=swimmer.drag_ratio + 0.1)
    assert not is_close(in_lengths(other, flow(other, sequence)), in_lengths(swimmer, path), 1e-4)


def test_size_scales_the_path() -> None:
    """A swimmer ten times as large moves ten times as far and turns the same."""
    sequence = random_sequence(np.random.default_rng(333), 10)
    small, large = flow(Swimmer(0.1, 0.2), sequence), flow(Swimmer(1.0, 2.0), sequence)
    assert_close(large, se3.pose(small[:3, :3], 10 * small[:3, 3]), 1e-13)


def test_mirror_image_of_a_path() -> None:
    """Reflecting a path in the x-z plane (yaws and rolls change sign) reflects the motion; yaws alone (foil) do not."""
    sequence = random_sequence(np.random.default_rng(334), 12)
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    sign = np.array([-1.0, 1.0, -1.0, -1.0, 1.0, -1.0])
    wanted = mirror @ flow(UNIT, sequence) @ mirror
    assert_close(flow(UNIT, sequence.with_angles(sequence.angle * sign[sequence.control])), wanted, 1e-12)
    yaws_only = np.where(sequence.control % 3 == 2, -1.0, 1.0)
    assert not is_close(flow(UNIT, sequence.with_angles(sequence.angle * yaws_only)), wanted, 1e-3)


def test_planar_paths_stay_planar() -> None:
    """Yaw strokes from the collinear shape never leave the x-y plane, pitch strokes never the x-z plane."""
    rng = np.random.default_rng(335)
    sequence = PrimitiveSequence(rng.choice([YAW_1, YAW_2], 20), rng.uniform(-1, 1, 20))
    g = flow(UNIT, sequence)
    assert_close(g[2], [0, 0, 1, 0], 1e-14)
    rolled = flow(UNIT, PrimitiveSequence(sequence.control - 1, sequence.angle))
    turn = np.eye(4)
    turn[:3, :3] = about_axis(0, -math.pi / 2)
    assert_close(rolled, turn @ g @ turn.T, 1e-13)
    assert not is_close(rolled, turn.T @ g @ turn, 1e-3)


def test_work_is_the_integral_of_the_power() -> None:
    """Energy per primitive against quadrature of the dissipated power; it grows with the rate and the viscosity."""
    rng = np.random.default_rng(336)
    swimmer = dataclasses.replace(random_swimmer(rng), joint_rate_rad_s=2.5)
    sequence, start = random_sequence(rng, 6), random_shapes(rng)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    wanted = []
    shapes = sequence.shapes(start)[:-1]
    for shape, rate, control, angle in zip(shapes, sequence.rates(), sequence.control, sequence.angle, strict=True):
        path = np.tile(shape, (60, 1, 1, 1))
        path[:, control // 3] = path[:, control // 3] @ about_axis(int(control) % 3, angle * (nodes + 1) / 2)
        wanted.append(power(swimmer, path, 2.5 * rate) @ weights / 2 * abs(angle) / 2.5)
    found = work(swimmer, sequence, start)
    assert_close(found, wanted, 1e-10, max(wanted))
    assert np.all(found > 0)
    faster = dataclasses.replace(swimmer, joint_rate_rad_s=5.0, viscosity_pa_s=3 * swimmer.viscosity_pa_s)
    assert_close(work(faster, sequence, start) / found, np.full(6, 6.0), 1e-12, 6.0)


# --- The null direction --------------------------------------------------------------------------------------------


def test_opposite_rolls_move_nothing_at_the_collinear_shape() -> None:
    """The null direction, against the paper: opposite rolls; same-sign rolls (the foil) turn the base."""
    both = np.array([[1.0, 0, 0, -1.0, 0, 0]])
    assert_close(flow_of_rates(UNIT, both, [1.3])[1][-1], ONE, 1e-15, 4.0)
    assert_close(flow(UNIT, of([(ROLL_1, 0.9), (ROLL_2, -0.9)])), ONE, 1e-15, 4.0)
    assert not is_close(flow(UNIT, of([(ROLL_1, 0.9), (ROLL_2, 0.9)])), ONE, 1e-3)


@pytest.mark.parametrize(("a_1", "a_2"), [(0.9, 0.0), (0.0, -0.4), (0.9, 0.4), (0.7, -0.7)])
def test_rolls_turn_the_base_by_minus_a_third_of_their_sum(a_1: float, a_2: float) -> None:
    """Equal links share the roll; the difference instead of the sum is the foil."""
    g = flow(UNIT, of([(ROLL_1, a_1), (ROLL_2, a_2)]))
    assert_close(g[:3, :3], about_axis(0, -(a_1 + a_2) / 3), 1e-14)
    assert_close(g[:3, 3], np.zeros(3), 1e-15)
    if a_2 != 0.0:
        assert not is_close(g[:3, :3], about_axis(0, -(a_1 - a_2) / 3), 1e-3)


# --- Derivatives ---------------------------------------------------------------------------------------------------


def differences(swimmer: Swimmer, sequence: PrimitiveSequence, start: Array, step: float = 1e-3) -> Array:
    """Return g^-1 dg/d(angle) by fourth-order central differences. Shape (6, n)."""
    back = se3.inverse(flow(swimmer, sequence, start))
    columns = []
    for k in range(len(sequence)):
        twist = []
        for shift in (-2, -1, 1, 2):
            angle = sequence.angle.copy()
            angle[k] += shift * step
            twist.append(se3.log(back @ flow(swimmer, sequence.with_angles(angle), start)))
        columns.append((twist[0] - 8 * twist[1] + 8 * twist[2] - twist[3]) / (12 * step))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("seed", range(4))
def test_jacobian_is_the_derivative_of_the_flow(seed: int) -> None:
    """Random swimmers and starts, both limbs, zero angles among them; spatial twists (the foil) are others."""
    rng = np.random.default_rng(400 + seed)
    swimmer, start = random_swimmer(rng).scaled(), random_shapes(rng)
    sequence = random_sequence(rng, 10)
    sequence = sequence.with_angles(np.where(np.arange(10) % 4 == 1, 0.0, sequence.angle))
    g, jacobian = flow_and_jacobian(swimmer, sequence, start)
    assert_close(g, flow(swimmer, sequence, start), 1e-13)
    wanted = differences(swimmer, sequence, start)
    assert_close(jacobian, wanted, 1e-7)
    assert not is_close(se3.adjoint(g) @ jacobian, wanted, 1e-3)


@pytest.mark.parametrize(
    "sequence",
    [
        loop(0.1, 0.1, PITCH_1, YAW_1),
        loop(0.0, 0.0) + loop(0.0, 0.0, PITCH_2, ROLL_1),
        loop(0.8, 0.8) + loop(-0.8, -0.8),
        of([(ROLL_2, 0.0)]),
    ],
    ids=["crank", "all zero", "x-motion", "one zero roll"],
)
def test_jacobian_holds_at_the_collinear_shape(sequence: PrimitiveSequence) -> None:
    """Where A(r) is sharpest, on a crank stroke and on strokes of zero amplitude."""
    jacobian = flow_and_jacobian(UNIT, sequence)[1]
    assert_close(jacobian, differences(UNIT, sequence, COLLINEAR, 2e-4), 1e-7)


def test_jacobian_is_in_metres() -> None:
    """For a swimmer of L = 0.1 m translations shrink tenfold, turns do not."""
    sequence, scale = random_sequence(np.random.default_rng(410), 6), np.array([0.1] * 3 + [1.0] * 3)
    g, jacobian = flow_and_jacobian(Swimmer(), sequence)
    wanted_g, wanted = flow_and_jacobian(UNIT, sequence)
    assert_close(jacobian, scale[:, None] * wanted, 1e-13)
    assert_close(g, flow(Swimmer(), sequence), 1e-14)
    assert_close(g[:3, 3], 0.1 * wanted_g[:3, 3], 1e-14)


# --- Long runs -----------------------------------------------------------------------------------------------------


def test_a_power_of_a_cycle_is_a_thousand_cycles() -> None:
    """n cycles are a power of one, to 1e-10 after 1000 integrated cycles; 999 cycles are not."""
    stroke = loop(0.15, 0.2, YAW_1, PITCH_2) + loop(0.1, -0.15, PITCH_1, YAW_2)
    assert_close(stroke.shapes(COLLINEAR)[-1], COLLINEAR, 1e-15)
    found = flow(UNIT, stroke.times(1000))
    wanted = se3.power(flow(UNIT, stroke), 1000)
    assert_close(found, wanted, 1e-10)
    assert not is_close(se3.power(flow(UNIT, stroke), 999), wanted, 1e-6)
    assert_close(found[:3, :3].T @ found[:3, :3], np.eye(3), 1e-13)


def test_rotations_stay_orthogonal_over_a_hundred_thousand_radians() -> None:
    """Running products of 100,000 rad of primitives stay rotations to 1e-13, and stay on the cycle's power."""
    stroke = loop(1.0, 1.0, YAW_1, PITCH_2) + loop(1.0, -1.0, PITCH_1, YAW_2)
    cycles = 12_500
    assert stroke.joint_travel_rad * cycles == 100_000
    poses = se3.prefix_products(np.tile(displacements(UNIT, stroke), (cycles, 1, 1)))
    wanted = se3.power(flow(UNIT, stroke), np.arange(0, cycles + 1, 500))
    for r in (poses[:, :3, :3], wanted[:, :3, :3]):
        assert_close(np.swapaxes(r, -1, -2) @ r, np.broadcast_to(np.eye(3), r.shape), 1e-13)
    assert_close(wanted[:, :3, :3], poses[:: 500 * 8, :3, :3], 1e-9)
    reach = float(np.max(np.abs(wanted[:, :3, 3])))
    assert_close(wanted[:, :3, 3], poses[:: 500 * 8, :3, 3], 1e-9, max(reach, 1.0))


def test_integrated_rotations_and_shapes_stay_orthogonal() -> None:
    """A directly integrated run of 1600 rad through ever new shapes: base and limbs are rotations to 1e-13."""
    rng = np.random.default_rng(420)
    sequence = random_sequence(rng, 3200)
    shapes, poses = flow_of_rates(UNIT, sequence.rates(), np.abs(sequence.angle))
    for r in (shapes, poses[:, :3, :3]):
        assert_close(np.swapaxes(r, -1, -2) @ r, np.broadcast_to(np.eye(3), r.shape), 1e-13)
    assert_close(sequence.shapes(COLLINEAR), shapes, 1e-11)


# --- Known numbers -------------------------------------------------------------------------------------------------


def test_same_sign_rectangles_do_not_turn() -> None:
    """With equal sides they turn by exactly zero, though they move; with unequal sides (the foil) they turn."""
    for a in (0.3, 1.0, 2.0):
        g = flow(UNIT, loop(a, a))
        assert_close(g[:3, :3], np.eye(3), 1e-13)
        assert not is_close(g, ONE, 1e-3)
    assert not is_close(flow(UNIT, loop(1.0, 0.5))[:3, :3], np.eye(3), 1e-3)


@pytest.mark.parametrize(("a", "wanted", "tolerance"), [(1.0, -0.11473112, 1e-9), (1.5, 0.0, 1e-3), (2.0, 0.385, 5e-4)])
def test_loop_and_mirror_image_is_pure_x(a: float, wanted: float, tolerance: float) -> None:
    """-0.114731120 L at 1 rad, about 0 at 1.5, +0.385 L at 2: not monotone in the amplitude."""
    g = flow(UNIT, loop(a, a) + loop(-a, -a))
    assert_close(g[:3, 3], [wanted, 0.0, 0.0], tolerance)
    assert_close(g[:3, :3], np.eye(3), 1e-13)
    assert_close(g[1:3, 3], [0.0, 0.0], 1e-13)


def test_loop_and_mirror_image_run_backwards_is_pure_y() -> None:
    """-0.059771146 L along y at 1 rad and nothing else."""
    g = flow(UNIT, loop(1.0, 1.0) + loop(-1.0, -1.0).inverse())
    assert_close(g, se3.pose(np.eye(3), [0.0, -0.059771146, 0.0]), 1e-9)
    assert_close(g[[0, 2], 3], [0.0, 0.0], 1e-13)


def test_opposite_sign_rectangle_moves_and_yaws() -> None:
    """0.122 L and 2.85 deg at 1 rad; minus its mirror image 5.697 deg with a small translation left."""
    g = flow(UNIT, loop(1.0, -1.0))
    assert_close(g[0, 3], 0.122, 5e-4)
    assert_close(np.degrees(as_euler(g[:3, :3])), [2.85, 0.0, 0.0], 5e-3)
    turned = flow(UNIT, loop(1.0, -1.0) + loop(-1.0, 1.0).inverse())
    assert_close(np.degrees(as_euler(turned[:3, :3])), [5.697, 0.0, 0.0], 5e-4)
    assert 1e-3 < np.linalg.norm(turned[:3, 3]) < 1e-2


CRANK = {0.04: -11.4, 0.06: -22.0, 0.1: -42.4, 0.15: -59.5, 0.2: -68.9, 0.3: -74.1, 0.5: -52.1}


@pytest.mark.parametrize(("e", "degrees"), CRANK.items())
def test_crank_rolls_the_base(e: float, degrees: float) -> None:
    """One limb through a small square (pitch, yaw, back, back) rolls the base; yaw first (the foil) rolls it back."""
    g = flow(UNIT, loop(e, e, PITCH_1, YAW_1))
    assert_close(np.degrees(as_euler(g[:3, :3]))[2], degrees, 0.051)
    other = flow(UNIT, loop(e, e, YAW_1, PITCH_1))
    assert not is_close(np.degrees(as_euler(other[:3, :3]))[2], degrees, 1.0)


def test_crank_does_little_else() -> None:
    """At e = 0.1: 0.01 deg of yaw and 3e-4 L beside the roll, and the limb left rolled by 0.57 deg."""
    sequence = loop(0.1, 0.1, PITCH_1, YAW_1)
    g = flow(UNIT, sequence)
    assert_close(np.degrees(as_euler(g[:3, :3]))[:2], [0.011, -0.001], 1e-3)
    assert np.linalg.norm(g[:3, 3]) < 3e-4
    assert_close(np.degrees(as_euler(sequence.shapes(COLLINEAR)[-1, 0]))[2], 0.57, 5e-3)


@pytest.mark.parametrize(("e", "degrees"), [(0.05, -66.0), (0.1, -170.0)])
def test_centred_crank_rolls_further(e: float, degrees: float) -> None:
    """A square about the collinear shape: half a turn for a radian of travel."""
    steps = [(PITCH_1, e), (YAW_1, e), (PITCH_1, -2 * e), (YAW_1, -2 * e), (PITCH_1, 2 * e), (YAW_1, e), (PITCH_1, -e)]
    g = flow(UNIT, of(steps))
    assert_close(np.degrees(as_euler(g[:3, :3]))[2], degrees, 0.5)


def square_cycle(side: float, centre: float) -> Array:
    """Return the twist per radian of travel of a repeated square loop about yaws (c, -c), seen from collinear."""
    half = side / 2
    approach = of([(YAW_1, centre - half), (YAW_2, -centre + half)])
    reached = flow(UNIT, approach)
    cycle = flow(UNIT, loop(side, -side), approach.shapes(COLLINEAR)[-1])
    return se3.log(reached @ cycle @ se3.inverse(reached)) / (4 * side)


@pytest.mark.parametrize(("side", "speed"), [(1.0, 0.0287), (1.5, 0.0391), (2.0, 0.0451), (2.25, 0.0460)])
def test_cruise_is_straight(side: float, speed: float) -> None:
    """A centred square loop repeated moves along a straight line; further out it is slower again."""
    twist = square_cycle(side, 0.0)
    assert_close(np.linalg.norm(twist[:3]), speed, 5.1e-5)
    assert_close(twist[2:], np.zeros(4), 1e-13)
    assert np.linalg.norm(square_cycle(2.75, 0.0)[:3]) < 0.0460


STEER = [
    (1.0, 2.0, 0.0451, 0.0),
    (1.0, 1.75, 0.0429, 0.283),
    (1.0, 1.5, 0.0397, 0.484),
    (1.0, 1.25, 0.0356, 0.625),
    (1.0, 1.0, 0.0306, 0.712),
    (1.5, 3.0, 0.0381, 0.0),
    (1.5, 2.25, 0.0442, 1.28),
    (1.5, 1.875, 0.0420, 1.70),
    (1.5, 1.5, 0.0368, 2.03),
]


@pytest.mark.parametrize(("bend", "side", "speed", "degrees"), STEER)
def test_a_square_off_centre_steers(bend: float, side: float, speed: float, degrees: float) -> None:
    """The repeated loop swims a circular arc; moved off to the other side (the foil) it turns the other way."""
    centre = bend - side / 2
    twist = square_cycle(side, centre)
    assert_close(np.linalg.norm(twist[:3]), speed, 5.1e-5)
    assert_close(abs(np.degrees(twist[5])), degrees, 5.1e-3 if degrees > 1 else 5.1e-4)
    if centre:
        assert np.sign(square_cycle(side, -centre)[5]) == -np.sign(twist[5])
