"""The connection A(r): reference tables, balance of forces, symmetries, and the laws of Stokes drag."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from helpers import (
    UNIT,
    assert_close,
    bent,
    is_close,
    random_rotations,
    random_shapes,
    random_swimmer,
    read_table,
    resistance,
)

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array, about_axis, from_quaternion, hat
from purcell_cli.mechanics.base_velocity import base_motion
from purcell_cli.mechanics.connection import (
    COLLINEAR,
    base_to_limb,
    base_twist,
    centre,
    connection,
    link_twist,
    power,
    rate_to_limb,
    resistance_and_coupling,
)
from purcell_cli.mechanics.swimmer import LIMITS, Swimmer

POINTS = read_table("connection_points.csv")
SEEDS = range(4)
LIMBS = (1, 2)
SIDE = {1: 1.0, 2: -1.0}
E_X = np.array([1.0, 0.0, 0.0])


def some(seed: int, count: int = 25) -> tuple[np.random.Generator, Swimmer, Array]:
    """Return a generator, a random swimmer with L = 1 in a fluid of unit drag, and random shapes."""
    rng = np.random.default_rng(seed)
    return rng, random_swimmer(rng).scaled(), random_shapes(rng, count)


def apply(matrix: Array, vector: Array) -> Array:
    """Return matrices times vectors over leading axes."""
    return (matrix @ vector[..., None])[..., 0]


def twice(block: Array) -> Array:
    """Return the 6x6 matrix with one 3x3 block twice on its diagonal."""
    return np.kron(np.eye(2), block)


# --- Tables from elsewhere -----------------------------------------------------------------------------------------


def table_case(row: dict[str, str]) -> tuple[Swimmer, Array, Array]:
    """Return a row's swimmer, shape and A(r)."""
    number = {key: float(value) for key, value in row.items()}
    swimmer = Swimmer(number["base_m"], number["limb_m"], number["slenderness"], drag_ratio=number["drag_ratio"])
    shape = from_quaternion([[number[f"l{limb}_q{part}"] for part in "wxyz"] for limb in LIMBS])
    wanted = np.array([[number[f"A{i}{j}"] for j in range(1, 7)] for i in range(1, 7)])
    return swimmer, shape, wanted


@pytest.mark.parametrize("row", POINTS, ids=range(len(POINTS)))
def test_connection_is_the_table(row: dict[str, str]) -> None:
    """A(r) agrees with an independent computation to 1e-11."""
    swimmer, shape, wanted = table_case(row)
    assert_close(connection(swimmer, shape), wanted, 1e-11)


def test_connection_of_other_conventions_is_not_the_table() -> None:
    """Passive orientations, exchanged limbs and the paper's spin moment k_R L each miss the table: the foils."""
    assert len(POINTS) == 12
    swimmer, shape, wanted = table_case(POINTS[1])
    assert not is_close(connection(swimmer, np.swapaxes(shape, -1, -2)), wanted, 1e-4)
    assert not is_close(connection(swimmer, shape[::-1]), wanted, 1e-4)
    half_spin = np.diag([1.0, 1.0, 1.0, 0.5, 1.0, 1.0])
    p, q = half_spin @ swimmer.drag_matrix(0), []
    for limb in LIMBS:
        t, h = np.swapaxes(base_to_limb(swimmer, shape, limb), -1, -2), half_spin @ swimmer.drag_matrix(limb)
        p, q = p + t @ h @ base_to_limb(swimmer, shape, limb), [*q, t @ h @ rate_to_limb(swimmer, limb)]
    assert not is_close(np.linalg.solve(p, np.concatenate(q, axis=-1)), wanted, 1e-5)


PLANAR = [
    # (b1, b3): (x', y', theta') for b1' = 1, then for b3' = 1; control-toolbox/bocop, problem swimmer.
    ((0.0, 0.0), (0.0, 1 / 8, -5 / 32), (0.0, -1 / 8, -5 / 32)),
    ((math.pi / 2, -math.pi / 2), (-5 / 36, 0.0, -1 / 12), (-5 / 36, 0.0, -1 / 12)),
    (
        (0.3, -0.7),
        (-0.009829681872, 0.11657850827, -0.16083197293),
        (-0.084727577437, -0.109295967533, -0.13981255265),
    ),
]


@pytest.mark.parametrize(("bend", "by_b1", "by_b3"), PLANAR)
def test_planar_connection_is_the_closed_form(
    bend: tuple[float, float], by_b1: tuple[float, ...], by_b3: tuple[float, ...]
) -> None:
    """In the yaw plane -A(r) is another code's closed form: b1 is limb 2's yaw, b3 limb 1's."""
    swimmer = Swimmer(base_half_length_m=1.0, limb_half_length_m=0.5, drag_ratio=2.0)
    b1, b3 = bend
    xi = -connection(swimmer, about_axis(2, [b3, b1]))
    planar = xi[[0, 1, 5]]
    assert_close(planar[:, 5], by_b1, 1e-11)
    assert_close(planar[:, 2], by_b3, 1e-11)
    assert_close(xi[[2, 3, 4]][:, [2, 5]], np.zeros((3, 2)), 1e-15)
    if abs(b1) != abs(b3):
        exchanged = -connection(swimmer, about_axis(2, [b1, b3]))[[0, 1, 5]]
        assert not is_close(exchanged[:, 5], by_b1, 1e-3)
        other_sign = -connection(swimmer, about_axis(2, [b3, -b1]))[[0, 1, 5]]
        assert not is_close(-other_sign[:, 5], by_b1, 1e-3)


def test_known_values_at_the_collinear_shape() -> None:
    """Equal links: a limb's roll turns the base by a third, its yaw by 7/27 and sideways by L/3."""
    a = connection(UNIT, COLLINEAR)
    assert_close(a[3], [1 / 3, 0, 0, 1 / 3, 0, 0], 1e-14)
    assert_close(a[5], [0, 0, 7 / 27, 0, 0, 7 / 27], 1e-14)
    assert_close(a[1], [0, 0, 1 / 3, 0, 0, -1 / 3], 1e-14)
    assert_close(a[0], np.zeros(6), 1e-14)


# --- Geometry ------------------------------------------------------------------------------------------------------


def test_limb_twists_are_those_of_the_moving_centre() -> None:
    """B_i xi + W_i omega_i is the velocity of the limb's centre and its spin, found by moving the swimmer a little."""
    rng, swimmer, shapes = some(10, 6)
    step = 1e-6
    for shape in shapes:
        rate, xi = rng.normal(size=6), rng.normal(size=6)
        for limb in LIMBS:
            a, omega = shape[limb - 1], rate[3 * limb - 3 : 3 * limb]
            place = []
            for t in (-step, step):
                moved = shape.copy()
                moved[limb - 1] = a @ (np.eye(3) + t * hat(omega))
                c = centre(swimmer, moved, limb)
                place.append(c + t * (xi[:3] + np.cross(xi[3:], c)))
            velocity = a.T @ (place[1] - place[0]) / (2 * step)
            wanted = np.concatenate([velocity, a.T @ xi[3:] + omega])
            assert_close(link_twist(swimmer, shape, rate, xi, limb), wanted, 1e-8)
        assert_close(link_twist(swimmer, shape, rate, xi, 0), xi, 0.0)


# --- Balance of forces ---------------------------------------------------------------------------------------------


def net_wrench(swimmer: Swimmer, shape: Array, rate: Array, xi_base: Array) -> Array:
    """Return the sum of T_i H_i xi_i over the links, minus the fluid's wrench on the swimmer."""
    total = apply(swimmer.drag_matrix(0), xi_base)
    for limb in LIMBS:
        xi = link_twist(swimmer, shape, rate, xi_base, limb)
        t = np.swapaxes(base_to_limb(swimmer, shape, limb), -1, -2)
        total = total + apply(t, apply(swimmer.drag_matrix(limb), xi))
    return total


def printed_b(swimmer: Swimmer, shape: Array, limb: int, rotated: bool) -> Array:
    """Return B_i with the velocity at the joint; as printed the upper right block is not rotated."""
    a_t = np.swapaxes(shape[..., limb - 1, :, :], -1, -2)
    out = np.zeros((*a_t.shape[:-2], 6, 6))
    out[..., :3, :3] = out[..., 3:, 3:] = a_t
    arm = -SIDE[limb] * swimmer.base_half_length_m * hat(E_X)
    out[..., :3, 3:] = a_t @ arm if rotated else arm
    return out


def printed_resistance(swimmer: Swimmer, shape: Array, rotated: bool) -> Array:
    """Return P of the paper's B_i and T_i (section III-C), or of its B_i with the rotation put in."""
    out = np.zeros((*shape.shape[:-3], 6, 6)) + swimmer.drag_matrix(0)
    for limb in LIMBS:
        t = np.swapaxes(printed_b(swimmer, shape, limb, rotated=True), -1, -2)
        out = out + t @ swimmer.drag_matrix(limb) @ printed_b(swimmer, shape, limb, rotated)
    return out


@pytest.mark.parametrize("seed", SEEDS)
def test_no_net_force_or_torque_acts(seed: int) -> None:
    """With xi = -A omega the links' wrenches cancel; with the paper's printed P, or a joint's velocity, they do not."""
    rng, swimmer, shapes = some(seed)
    rate = rng.normal(size=(len(shapes), 6))
    nothing = np.zeros((len(shapes), 6))
    driven = apply(resistance_and_coupling(swimmer, shapes)[1], rate)
    scale = float(np.max(np.abs(driven)))
    assert_close(net_wrench(swimmer, shapes, rate, base_twist(swimmer, shapes, rate)), nothing, 1e-13, scale)
    for rotated in (False, True):
        p = printed_resistance(swimmer, shapes, rotated)
        foil = -np.linalg.solve(p, driven[..., None])[..., 0]
        assert not is_close(net_wrench(swimmer, shapes, rate, foil), nothing, 1e-3, scale)
    against = net_wrench(swimmer, shapes, rate, -base_twist(swimmer, shapes, rate))
    assert not is_close(against, nothing, 1e-3, scale)


@pytest.mark.parametrize("seed", SEEDS)
def test_resistance_is_symmetric_positive_definite(seed: int) -> None:
    """P = P^T > 0 (reciprocal theorem, dissipation); as printed, P is not symmetric."""
    _, swimmer, shapes = some(seed)
    p = resistance(swimmer, shapes)
    scale = float(np.max(np.abs(p)))
    assert_close(p, np.swapaxes(p, -1, -2), 1e-15, 4 * scale)
    assert np.min(np.linalg.eigvalsh(p)) > 0
    foil = printed_resistance(swimmer, shapes, rotated=False)
    assert not is_close(foil, np.swapaxes(foil, -1, -2), 1e-2, scale)


def test_resistance_does_not_feel_a_limb_roll_about_its_own_axis() -> None:
    """A limb is a body of revolution; a yaw of the limb is the foil."""
    rng, swimmer, shapes = some(11)
    p = resistance(swimmer, shapes)
    turn = rng.uniform(-3, 3, (len(shapes), 2))
    assert_close(resistance(swimmer, shapes @ about_axis(0, turn)), p, 1e-14, 10.0)
    assert not is_close(resistance(swimmer, shapes @ about_axis(2, turn)), p, 1e-2)


def test_resistance_is_the_sum_over_short_rods() -> None:
    """P is the drag of many short pieces of the links, summed: resistive force theory from scratch."""
    _, swimmer, shapes = some(12, 5)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    k, lengths = swimmer.lateral_drag(), (swimmer.base_half_length_m, *[swimmer.limb_half_length_m] * 2)
    for shape in shapes:
        axes = (E_X, shape[0, :, 0], shape[1, :, 0])
        middles = (np.zeros(3), *(centre(swimmer, shape, limb) for limb in LIMBS))
        total = np.zeros((6, 6))
        for link, (axis, middle, half) in enumerate(zip(axes, middles, lengths, strict=True)):
            along = np.outer(axis, axis)
            local = k * (np.eye(3) - (1 - 1 / swimmer.drag_ratio) * along)
            for node, weight in zip(nodes, weights, strict=True):
                to_velocity = np.concatenate([np.eye(3), -hat(middle + node * half * axis)], axis=1)
                total += weight * half * to_velocity.T @ local @ to_velocity
            total[3:, 3:] += swimmer.rod(link).spin * along
        assert_close(resistance(swimmer, shape), total, 1e-13, 10.0)


@pytest.mark.parametrize("swimmer", [UNIT, Swimmer(1.0, 0.4), Swimmer(1.0, 2.5, slenderness=0.002)])
def test_roll_sharpness_is_the_bend_that_doubles_the_drag_on_roll(swimmer: Swimmer) -> None:
    """The resistance of the free swimmer to roll grows as 1 + (bend / sharpness)^2 near the collinear shape."""

    def drag_on_roll(bend: float) -> float:
        return float(1.0 / np.linalg.inv(resistance(swimmer.scaled(), bent(0.0, bend)))[3, 3])

    sharpness, straight = swimmer.roll_sharpness(), drag_on_roll(0.0)
    assert_close(drag_on_roll(sharpness) / straight, 2.0, 0.02)
    assert_close((drag_on_roll(0.01 * sharpness) / straight - 1.0) * 1e4, 1.0, 3e-3)


# --- Rank ----------------------------------------------------------------------------------------------------------


def assert_rank_five(matrices: Array, fifth: float) -> None:
    """Assert that the sixth singular value is rounding and the fifth is not."""
    values = np.linalg.svd(matrices, compute_uv=False)
    assert np.all(np.isfinite(values))
    assert np.all(values[..., 5] <= 1e-14 * values[..., 0]), "full rank"
    assert np.all(values[..., 4] >= fifth * values[..., 0]), "rank under five"


@pytest.mark.parametrize("seed", SEEDS)
def test_connection_has_rank_five(seed: int) -> None:
    """At a random shape exactly one direction of limb motion leaves the base still; P has full rank: the foil."""
    _, swimmer, shapes = some(seed, 100)
    a = connection(swimmer, shapes)
    # The fifth value is of the order of the spin drag over the lateral drag, the square of the slenderness.
    assert_rank_five(a, 0.02 * swimmer.slenderness**2)
    assert_rank_five(connection(swimmer, COLLINEAR), 0.02 * swimmer.slenderness**2)
    with pytest.raises(AssertionError, match="full rank"):
        assert_rank_five(resistance(swimmer, shapes), 0.0)
    with pytest.raises(AssertionError, match="full rank"):
        assert_rank_five(a + 1e-6 * np.eye(6), 0.0)


@pytest.mark.parametrize(
    ("swimmer", "yaw_1", "yaw_2"),
    [
        (UNIT, math.pi / 2, -math.pi / 2),
        (Swimmer(1.0, 2.0, slenderness=0.05), math.pi / 2, -math.pi / 2),
        (Swimmer(1.0, 0.5), math.acos(-2 / 3), math.acos(-2 / 3)),
    ],
    ids=["U", "U with long limbs", "parallel short limbs"],
)
def test_connection_has_rank_three_at_exceptional_shapes(swimmer: Swimmer, yaw_1: float, yaw_2: float) -> None:
    """Three limb motions leave the base still in the U (both limbs square to the base, on one side).

    So they do with short parallel limbs folded back to cos(yaw) = -4 limb / (3 base).
    """
    shape = about_axis(2, [yaw_1, yaw_2])
    values = np.linalg.svd(connection(swimmer.scaled(), shape), compute_uv=False)
    assert np.all(values[3:] < 1e-14)
    assert values[2] > 0.1
    beside = np.linalg.svd(connection(swimmer.scaled(), about_axis(2, [yaw_1, yaw_2 + 0.1])), compute_uv=False)
    assert np.all(beside[:5] > 1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_null_motion_swings_the_limbs_in_the_plane_of_equal_and_opposite_forces(seed: int) -> None:
    """The null vector: limbs push along +-(a_1 x a_2), so neither swings out of the plane the limbs span."""
    _, swimmer, shapes = some(seed)
    null = np.linalg.svd(connection(swimmer, shapes))[2][..., 5, :]
    assert_close(base_twist(swimmer, shapes, null), np.zeros_like(null), 1e-14)
    swing = np.einsum("nlij,nlj->nli", shapes, null.reshape(-1, 2, 3))
    normal = np.cross(shapes[:, 0, :, 0], shapes[:, 1, :, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    assert_close(np.einsum("nli,ni->nl", swing, normal), np.zeros((len(shapes), 2)), 1e-9)
    out_of_plane = np.linalg.svd(connection(swimmer, shapes))[2][..., 0, :].reshape(-1, 2, 3)
    foil = np.einsum("nlij,nlj,ni->nl", shapes, out_of_plane, normal)
    assert not is_close(foil, np.zeros((len(shapes), 2)), 1e-3)


# --- Scaling -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_viscosity_does_not_change_the_connection(seed: int) -> None:
    """Viscosity scales forces and power, never A(r); the drag ratio does change A: the foil."""
    rng, _, shapes = some(seed)
    swimmer = random_swimmer(rng)
    thick = dataclasses.replace(swimmer, viscosity_pa_s=1e3 * swimmer.viscosity_pa_s)
    a = connection(swimmer, shapes)
    assert_close(connection(thick, shapes), a, 0.0)
    p = resistance(swimmer, shapes)
    assert_close(resistance(thick, shapes) / 1e3, p, 1e-13, float(p.max()))
    rate = rng.normal(size=6)
    assert_close(power(thick, shapes, rate) / power(swimmer, shapes, rate), np.full(len(shapes), 1e3), 1e-9)
    other = dataclasses.replace(swimmer, drag_ratio=swimmer.drag_ratio + 0.1)
    assert not is_close(connection(other, shapes), a, 1e-3)


@pytest.mark.parametrize("size", [1e-6, 0.37, 5.0, 1e4])
def test_size_scales_only_the_translation(size: float) -> None:
    """All lengths times s: velocities times s, turning rates unchanged."""
    _, swimmer, shapes = some(13)
    big = dataclasses.replace(
        swimmer,
        base_half_length_m=size * swimmer.base_half_length_m,
        limb_half_length_m=size * swimmer.limb_half_length_m,
    )
    a, found = connection(swimmer, shapes), connection(big, shapes)
    assert_close(found[:, :3] / size, a[:, :3], 1e-13, 10.0)
    assert_close(found[:, 3:], a[:, 3:], 1e-13, 10.0)
    if size != 1.0:
        assert not is_close(found[:, :3], a[:, :3], 1e-3)


def test_scaled_swimmer_is_the_same_swimmer_in_units_of_length() -> None:
    """scaled() has L = 1 and unit drag, and scaling twice changes nothing more than rounding."""
    swimmer = random_swimmer(np.random.default_rng(14))
    unit = swimmer.scaled()
    assert_close([unit.length_m, unit.lateral_drag()], [1.0, 1.0], 1e-15, 2.0)
    shapes = random_shapes(np.random.default_rng(15), 5)
    in_lengths = connection(swimmer, shapes)
    in_lengths[:, :3] /= swimmer.length_m
    assert_close(connection(unit, shapes), in_lengths, 1e-13, 10.0)


# --- Symmetries ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [1, 2], ids=["x-z plane", "x-y plane"])
@pytest.mark.parametrize("seed", SEEDS)
def test_mirror_image_moves_as_the_mirror_image(seed: int, axis: int) -> None:
    """Reflect shape and rates in a plane through the base: v reflects, angular rates reflect as axial vectors."""
    _, swimmer, shapes = some(seed)
    mirror = np.eye(3)
    mirror[axis, axis] = -1.0
    image = connection(swimmer, mirror @ shapes @ mirror)
    of_twist = np.kron(np.diag([1.0, -1.0]), mirror)
    a = connection(swimmer, shapes)
    assert_close(image, of_twist @ a @ twice(-mirror), 1e-13, 10.0)
    assert not is_close(image, twice(mirror) @ a @ twice(mirror), 1e-3)
    assert not is_close(image, a, 1e-3)


@pytest.mark.parametrize("axis", [1, 2], ids=["about y", "about z"])
@pytest.mark.parametrize("seed", SEEDS)
def test_front_and_back_can_be_exchanged(seed: int, axis: int) -> None:
    """A half turn of the swimmer about y or z makes limb 2 limb 1; without renaming the limbs it is wrong."""
    _, swimmer, shapes = some(seed)
    half_turn = about_axis(axis, math.pi)
    swap = np.kron(np.array([[0.0, 1.0], [1.0, 0.0]]), half_turn)
    a, turned = connection(swimmer, shapes), half_turn @ shapes @ half_turn.T
    assert_close(connection(swimmer, turned[:, ::-1]), twice(half_turn) @ a @ swap, 1e-13, 10.0)
    assert not is_close(connection(swimmer, turned), twice(half_turn) @ a @ twice(half_turn), 1e-3)


def test_rolling_the_base_frame_changes_nothing() -> None:
    """The base is a body of revolution: turning its frame about x turns the twist; about z is the foil."""
    rng, swimmer, shapes = some(16)
    a = connection(swimmer, shapes)
    for axis, holds in ((0, True), (2, False)):
        turn = about_axis(axis, rng.uniform(0.5, 3.0))
        seen = connection(swimmer, turn @ shapes)
        if holds:
            assert_close(seen, twice(turn) @ a, 1e-13, 10.0)
        else:
            assert not is_close(seen, twice(turn) @ a, 1e-3)


def test_limb_frame_rolls_turn_the_controls_only() -> None:
    """Turning a limb's frame about its axis renames its rates: A(r') omega' = A(r) omega with omega' = X^T omega."""
    rng, swimmer, shapes = some(17)
    turn = about_axis(0, rng.uniform(0.5, 3.0))
    a = connection(swimmer, shapes)
    assert_close(connection(swimmer, shapes @ turn), a @ twice(turn), 1e-13, 10.0)
    assert not is_close(connection(swimmer, shapes @ turn), a, 1e-3)


# --- Power ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_power_is_a_positive_quadratic_form(seed: int) -> None:
    """Power is omega^T D omega with D = W^T H W - Q^T P^-1 Q > 0; a base held still needs more: the foil."""
    rng, swimmer, shapes = some(seed)
    rate = rng.normal(size=(len(shapes), 6))
    held = np.zeros((6, 6))
    for limb in LIMBS:
        part = slice(3 * limb - 3, 3 * limb)
        w = rate_to_limb(swimmer, limb)
        held[part, part] = w.T @ swimmer.drag_matrix(limb) @ w
    p, q = resistance_and_coupling(swimmer, shapes)
    form = held - np.swapaxes(q, -1, -2) @ np.linalg.solve(p, q)
    found = power(swimmer, shapes, rate)
    scale = float(np.max(found))
    assert_close(found, np.einsum("ni,nij,nj->n", rate, form, rate), 1e-13, 10 * scale)
    assert np.min(np.linalg.eigvalsh(form)) > 0
    assert_close(power(swimmer, shapes, 3.0 * rate), 9.0 * found, 1e-14, 9 * scale)
    assert_close(power(swimmer, shapes, 0.0 * rate), 0.0 * found, 0.0)
    at_rest = np.einsum("ni,ij,nj->n", rate, held, rate)
    assert np.all(at_rest > found)
    assert not is_close(at_rest, found, 1e-3, scale)


def test_the_base_moves_so_that_least_is_dissipated() -> None:
    """Helmholtz: any other base twist, at the same limb rates, dissipates more."""
    rng, swimmer, shapes = some(18)
    rate = rng.normal(size=(len(shapes), 6))
    least = power(swimmer, shapes, rate)
    xi = base_twist(swimmer, shapes, rate)
    for _ in range(20):
        other = xi + 0.01 * rng.normal(size=xi.shape)
        total = np.zeros(len(shapes))
        for link in range(3):
            seen = link_twist(swimmer, shapes, rate, other, link)
            total += np.einsum("ni,ij,nj->n", seen, swimmer.drag_matrix(link), seen)
        assert np.all(total > least)


def test_rolling_costs_only_spin_drag_when_collinear() -> None:
    """Opposite rolls at the collinear shape: 2 (2 k_R L) for two limbs, base still; the paper's k_R L is half of it."""
    spin = 0.5 * UNIT.rod(1).spin
    found = float(power(UNIT, COLLINEAR, [1.0, 0, 0, -1.0, 0, 0]))
    assert_close(found, 4 * spin, 1e-14, 4 * spin)
    assert not is_close(found, 2 * spin, 1e-3, spin)
    assert_close(spin, 4 * math.pi * 0.95 * 0.02**2, 1e-15)


# --- The same twist, faster ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_the_fast_twist_of_the_lift_is_the_connection(seed: int) -> None:
    """lift's closed form in axes and base rates agrees with -A(r) omega to 1e-12 relative, 1e-11 near collinear."""
    rng, swimmer, shapes = some(seed, 40)
    for k, angle in enumerate((0.0, 1e-6, 1e-3, 0.05)):
        shapes[k] = bent(angle, 0.7 * angle)
    rate = rng.normal(size=(len(shapes), 6))
    in_base = np.einsum("nlij,nlj->nli", shapes, rate.reshape(-1, 2, 3))
    axes = shapes[..., 0]
    found = base_motion(swimmer, axes, in_base).twist
    wanted = base_twist(swimmer, shapes, rate)
    size = np.linalg.norm(wanted, axis=-1, keepdims=True)
    assert_close(found[4:] / size[4:], wanted[4:] / size[4:], 1e-12)
    assert_close(found[:4] / size[:4], wanted[:4] / size[:4], 1e-11)
    in_limb = base_motion(swimmer, axes, rate.reshape(-1, 2, 3)).twist
    assert not is_close(in_limb / size, wanted / size, 1e-3)


def test_joint_torques_do_the_work() -> None:
    """The power of the joints' torques is the power dissipated, since nothing acts from outside."""
    rng, swimmer, shapes = some(19)
    rate = rng.normal(size=(len(shapes), 6))
    in_base = np.einsum("nlij,nlj->nli", shapes, rate.reshape(-1, 2, 3))
    wanted = power(swimmer, shapes, rate)
    assert_close(base_motion(swimmer, shapes[..., 0], in_base).power, wanted, 1e-13, float(wanted.max()))


# --- Batches and misuse --------------------------------------------------------------------------------------------


def test_a_batch_is_a_loop() -> None:
    """Leading axes of shapes and rates are a loop over them."""
    rng, swimmer, _ = some(20)
    shapes, rates = random_shapes(rng, 3, 4), rng.normal(size=(3, 4, 6))
    batch = (connection(swimmer, shapes), base_twist(swimmer, shapes, rates), power(swimmer, shapes, rates))
    for i in np.ndindex(3, 4):
        case = (swimmer, shapes[i], rates[i])
        single = (connection(*case[:2]), base_twist(*case), power(*case))
        for one, many in zip(single, batch, strict=True):
            assert_close(many[i], one, 1e-14, 10.0)
    one_shape = np.broadcast_to(shapes[0, 0], shapes.shape)
    assert_close(base_twist(swimmer, shapes[0, 0], rates), base_twist(swimmer, one_shape, rates), 1e-14)


NUMBERS = list(LIMITS)


IMPOSSIBLE = [-1.0, 0.0, -0.0, math.nan, math.inf, -math.inf, True, False, "0.1", None, 1j, [0.1]]


@pytest.mark.parametrize("value", IMPOSSIBLE, ids=repr)
@pytest.mark.parametrize("name", NUMBERS)
def test_impossible_swimmers_are_refused(name: str, value: Any) -> None:
    """Each parameter refuses what no swimmer can have, and names itself."""
    with pytest.raises(ParameterError, match=name):
        Swimmer(**{name: value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("drag_ratio", 1.0),
        ("drag_ratio", 0.5),
        ("slenderness", 0.21),
        ("max_bend_rad", 3.2),
        ("limb_half_length_m", 10.1),
        ("limb_half_length_m", 0.0009),
    ],
)
def test_swimmers_out_of_range_are_refused(name: str, value: float) -> None:
    """Isotropic drag, stout links, a bend beyond a half turn and links of absurd proportion are errors."""
    with pytest.raises(ParameterError, match=name):
        Swimmer(**{name: value})


def test_whole_numbers_are_numbers() -> None:
    """An int is taken as the float it means."""
    assert Swimmer(1, 2, drag_ratio=2) == Swimmer(1.0, 2.0, drag_ratio=2.0)
    assert isinstance(Swimmer(1, 2).base_half_length_m, float)


@pytest.mark.parametrize("shape", [np.eye(3), np.zeros((2, 2)), np.zeros((3, 3, 3)), 1.0, []], ids=np.shape)
def test_arrays_that_are_no_shape_are_refused(shape: Any) -> None:
    """A shape is (..., 2, 3, 3) and nothing else."""
    for function in (connection, resistance_and_coupling):
        with pytest.raises(ParameterError, match="a shape is an array"):
            function(UNIT, shape)


def test_the_collinear_shape_cannot_be_written_to() -> None:
    """The constant is read-only, and is two identities."""
    assert_close(COLLINEAR, np.stack([np.eye(3), np.eye(3)]), 0.0)
    with pytest.raises(ValueError, match="read-only"):
        COLLINEAR[0, 0, 0] = 2.0


def test_a_random_rotation_is_a_rotation() -> None:
    """The generator of these tests makes rotations, with determinant +1."""
    r = random_rotations(np.random.default_rng(21), 10)
    assert_close(np.linalg.det(r), np.ones(10), 1e-14)
