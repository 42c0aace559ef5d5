"""SE(3): exp and log are inverses and exact at every angle; adjoint, bracket and powers obey their laws."""

from __future__ import annotations

import functools
import math

import mpmath
import numpy as np
import pytest
from helpers import assert_close, is_close, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import RigidTransform

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, hat
from purcell_cli.verification.extended import product

ANGLES = [0.0, 1e-300, 1e-20, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.03, 0.249999, 0.250001, 1.0, 2.0, 3.0]
NEAR_PI = [math.pi - d for d in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)]
AXIS = np.array([2.0, -3.0, 6.0]) / 7.0
VELOCITY = np.array([0.8, -1.1, 0.5])


def twist_about(angle: float) -> Array:
    """Return a twist with a finite translation and this rotation angle."""
    return np.concatenate([VELOCITY, angle * AXIS])


def twist_matrix(xi: Array) -> Array:
    """Return the 4x4 matrix of a twist. Shape (..., 4, 4)."""
    out = np.zeros((*xi.shape[:-1], 4, 4))
    out[..., :3, :3] = hat(xi[..., 3:])
    out[..., :3, 3] = xi[..., :3]
    return out


def exact_exp(xi: Array) -> Array:
    """Return the matrix exponential by mpmath at 50 digits, rounded once."""
    with mpmath.workdps(50):
        found = mpmath.expm(mpmath.matrix(twist_matrix(xi).tolist()), method="taylor")
        return np.array([[float(found[i, j]) for j in range(4)] for i in range(4)])


def naive_exp(xi: Array, identity_below: float) -> Array:
    """Return exp as often written: V = 1 under a threshold, and the textbook quotients above (the foil)."""
    v, w = xi[:3], xi[3:]
    t, k = float(np.linalg.norm(w)), hat(w)
    out = np.eye(4)
    if t < identity_below:
        out[:3, :3] += k
        out[:3, 3] = v
    else:
        out[:3, :3] += math.sin(t) / t * k + (1 - math.cos(t)) / t**2 * k @ k
        out[:3, 3] = (np.eye(3) + (1 - math.cos(t)) / t**2 * k + (t - math.sin(t)) / t**3 * k @ k) @ v
    return out


@pytest.mark.parametrize("angle", [*ANGLES, *NEAR_PI, math.pi, 5.0, 2 * math.pi, 10.0])
def test_exp_is_the_matrix_exponential(angle: float) -> None:
    """exp agrees with 50 digits at every angle, exact zero included, always with a finite translation."""
    xi = twist_about(angle)
    assert_close(se3.exp(xi), exact_exp(xi), 1e-15, 4.0)


@pytest.mark.parametrize(("angle", "identity_below"), [(1e-7, 1e-6), (1e-8, 0.0)])
def test_exp_with_a_careless_small_angle_branch_fails(angle: float, identity_below: float) -> None:
    """A branch that returns the identity, or no branch at all, is off by more than rounding: the foil."""
    xi = twist_about(angle)
    assert not is_close(naive_exp(xi, identity_below), exact_exp(xi), 1e-15, 4.0)


def test_exp_of_a_batch_is_exp_of_each() -> None:
    """Small and large angles side by side do not disturb each other."""
    twists = np.stack([twist_about(a) for a in ANGLES + NEAR_PI])
    batch = se3.exp(twists[:21].reshape(3, 7, 6))
    each = np.stack([se3.exp(xi) for xi in twists[:21]]).reshape(3, 7, 4, 4)
    assert_close(batch, each, 1e-15)
    assert se3.exp(np.empty((0, 6))).shape == (0, 4, 4)


@pytest.mark.parametrize("angle", [*ANGLES, *NEAR_PI])
def test_log_inverts_exp(angle: float) -> None:
    """log(exp(xi)) = xi for every rotation angle under pi, with no digits lost near 0 or near pi."""
    xi = twist_about(angle)
    assert_close(se3.log(se3.exp(xi)), xi, 1e-15, 8.0)


def test_exp_inverts_log_at_half_turns() -> None:
    """At exactly pi the axis has two signs; either gives the pose back."""
    g = np.stack([se3.exp(np.concatenate([VELOCITY, math.pi * axis])) for axis in (AXIS, -AXIS, *np.eye(3))])
    found = se3.log(g)
    assert_close(np.linalg.norm(found[:, 3:], axis=-1), np.full(5, math.pi), 1e-15, 4.0)
    assert_close(se3.exp(found), g, 1e-15, 10.0)


def test_exp_and_log_agree_with_scipy() -> None:
    """scipy's RigidTransform takes (omega, v); read as (v, omega) it is another motion."""
    rng = np.random.default_rng(1)
    xi = np.concatenate([rng.normal(size=(40, 3)), rng.uniform(-1.7, 1.7, (40, 3))], axis=-1)
    swapped = xi[:, [3, 4, 5, 0, 1, 2]]
    wanted = RigidTransform.from_exp_coords(swapped).as_matrix()
    assert_close(se3.exp(xi), wanted, 1e-15, 10.0)
    assert_close(se3.log(wanted).reshape(5, 8, 6), se3.log(wanted.reshape(5, 8, 4, 4)), 0.0)
    assert_close(se3.log(wanted), xi, 1e-14)
    assert not is_close(se3.exp(swapped), wanted, 1e-3)


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.tuples(*[st.floats(-1.8, 1.8)] * 3))
@settings(max_examples=100, deadline=None)
def test_exp_and_log_round_trip(velocity: tuple[float, ...], rotation: tuple[float, ...]) -> None:
    """log(exp(xi)) = xi for random twists with a rotation angle under pi."""
    xi = np.array([*velocity, *rotation])
    if np.linalg.norm(xi[3:]) < 3.1:
        assert_close(se3.log(se3.exp(xi)), xi, 1e-13)


def random_poses(rng: np.random.Generator, count: int) -> Array:
    """Return random poses. Shape (count, 4, 4)."""
    return se3.pose(random_rotations(rng, count), rng.normal(size=(count, 3)))


def test_inverse_undoes_a_pose() -> None:
    """g^-1 g = g g^-1 = 1, and exp(-xi) = exp(xi)^-1."""
    rng = np.random.default_rng(2)
    g = random_poses(rng, 20)
    one = np.broadcast_to(np.eye(4), g.shape)
    assert_close(se3.inverse(g) @ g, one, 1e-15, 10.0)
    assert_close(g @ se3.inverse(g), one, 1e-15, 10.0)
    xi = rng.normal(size=(20, 6))
    assert_close(se3.exp(-xi), se3.inverse(se3.exp(xi)), 1e-15, 20.0)


def test_pose_broadcasts_rotation_and_position() -> None:
    """One rotation goes with many positions, and the other way about."""
    r, p = random_rotations(np.random.default_rng(3)), np.arange(6.0).reshape(2, 3)
    g = se3.pose(r, p)
    assert_close(g[:, :3, :3], np.stack([r, r]), 0.0)
    assert_close(g[:, :3, 3], p, 0.0)
    assert_close(se3.pose(np.stack([r, r]), p[0])[1], g[0], 0.0)


def test_adjoint_carries_twists() -> None:
    """g exp(xi) g^-1 = exp(Ad_g xi) and Ad_gh = Ad_g Ad_h; Ad of the inverse and the (omega, v) form are foils."""
    rng = np.random.default_rng(4)
    g, h = random_poses(rng, 10), random_poses(rng, 10)
    xi = rng.normal(size=(10, 6))
    wanted = g @ se3.exp(xi) @ se3.inverse(g)
    ad = se3.adjoint(g)
    assert_close(se3.exp((ad @ xi[..., None])[..., 0]), wanted, 1e-14)
    assert_close(se3.adjoint(g @ h), ad @ se3.adjoint(h), 1e-14)
    assert_close(se3.adjoint(se3.inverse(g)) @ ad, np.broadcast_to(np.eye(6), ad.shape), 1e-14)
    for foil in (se3.adjoint(se3.inverse(g)), np.swapaxes(ad, -1, -2)):
        assert not is_close(se3.exp((foil @ xi[..., None])[..., 0]), wanted, 1e-3)


def test_bracket_is_the_matrix_commutator() -> None:
    """[x, y] as matrices, antisymmetric, Jacobi, and the derivative of Ad; the right-invariant sign is a foil."""
    rng = np.random.default_rng(5)
    x, y, z = rng.normal(size=(3, 8, 6))
    mx, my = twist_matrix(x), twist_matrix(y)
    assert_close(twist_matrix(se3.bracket(x, y)), mx @ my - my @ mx, 1e-14)
    assert_close(se3.bracket(y, x), -se3.bracket(x, y), 0.0)
    jacobi = sum(se3.bracket(a, se3.bracket(b, c)) for a, b, c in ((x, y, z), (y, z, x), (z, x, y)))
    assert_close(jacobi, np.zeros((8, 6)), 1e-13)
    ad_x = np.stack([se3.bracket(x[0], e) for e in np.eye(6)], axis=-1)
    assert_close(expm(ad_x), se3.adjoint(se3.exp(x[0])), 1e-14, 10.0)
    assert not is_close(expm(-ad_x), se3.adjoint(se3.exp(x[0])), 1e-3)


def test_power_is_repeated_multiplication() -> None:
    """pose^n along the one-parameter subgroup: whole, zero, negative and fractional powers."""
    g = se3.exp(np.array([0.3, -0.2, 0.1, 0.05, 0.4, -0.1]))
    wanted = np.stack([np.linalg.matrix_power(g, n) for n in range(8)])
    assert_close(se3.power(g, np.arange(8)), wanted, 1e-14)
    assert_close(se3.power(g, -1), se3.inverse(g), 1e-15, 4.0)
    assert_close(se3.power(g, 0.5) @ se3.power(g, 0.5), g, 1e-15, 4.0)
    assert_close(se3.power(np.eye(4), 5), np.eye(4), 0.0)
    slide = se3.pose(np.eye(3), VELOCITY)
    assert_close(se3.power(slide, 1e6), se3.pose(np.eye(3), 1e6 * VELOCITY), 1e-15, 1e6)
    powered_entries = se3.pose(g[:3, :3], 3 * g[:3, 3])
    assert not is_close(powered_entries, wanted[3], 1e-3)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5, 7, 8, 9, 31, 100])
def test_prefix_products_are_a_plain_loop(count: int) -> None:
    """I, g_1, g_1 g_2, ...; the product in the other order is the foil."""
    g = random_poses(np.random.default_rng(6), count)
    wanted, foil = [np.eye(4)], [np.eye(4)]
    for step in g:
        wanted.append(wanted[-1] @ step)
        foil.append(step @ foil[-1])
    found = se3.prefix_products(g)
    assert_close(found, np.stack(wanted), 1e-14, max(count, 1))
    if count > 1:
        assert not is_close(found, np.stack(foil), 1e-3)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 7, 8, 100, 1001])
def test_the_product_of_moves_that_come_again_is_a_plain_loop(count: int) -> None:
    """A square played over and over, with a way in, and moves at random."""
    rng = np.random.default_rng(9)
    g = se3.exp(0.3 * rng.normal(size=(6, 6)))
    for which in (np.append([4, 5], np.tile([0, 1, 2, 3], count))[:count], rng.integers(0, 6, count)):
        wanted = functools.reduce(np.matmul, g[which], np.eye(4))
        assert_close(product(g, which), wanted, 1e-14, max(count, 1))
        if count > 3:
            assert not is_close(product(g, which[::-1]), wanted, 1e-3)


def test_prefix_products_leave_their_argument_alone() -> None:
    """The displacements passed in are not written to."""
    g = random_poses(np.random.default_rng(7), 10)
    kept = g.copy()
    se3.prefix_products(g)
    assert_close(g, kept, 0.0)


def test_normalised_makes_rotations_orthogonal_and_keeps_positions() -> None:
    """Rounding in the rotation goes away; the position and the argument stay as they were."""
    rng = np.random.default_rng(8)
    g = random_poses(rng, 10)
    rough = g.copy()
    rough[:, :3, :3] += 1e-10 * rng.normal(size=(10, 3, 3))
    kept = rough.copy()
    found = se3.normalised(rough)
    r = found[:, :3, :3]
    assert_close(np.swapaxes(r, -1, -2) @ r, np.broadcast_to(np.eye(3), r.shape), 1e-15, 3.0)
    assert_close(found[:, :3, 3], g[:, :3, 3], 0.0)
    assert_close(rough, kept, 0.0)
