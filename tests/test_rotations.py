"""Rotations: the conventions hold, conversions are inverses of each other, and bad input is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import assert_close, is_close, random_rotations
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import (
    about_axis,
    angle_between,
    as_euler,
    as_quaternion,
    cross,
    from_euler,
    from_matrix,
    from_quaternion,
    hat,
    orthonormalised,
)

TURN = st.floats(-math.pi, math.pi)
EULER = st.tuples(TURN, st.floats(-math.pi / 2, math.pi / 2), TURN)
STRAIGHT_UP = math.pi / 2


def test_hat_is_the_cross_product() -> None:
    """hat(a) b = a x b over any leading axes."""
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(4, 5, 3)), rng.normal(size=(4, 5, 3))
    wanted = np.cross(a, b)
    assert_close((hat(a) @ b[..., None])[..., 0], wanted, 1e-15, 10.0)
    assert_close(cross(a, b), wanted, 1e-15, 10.0)
    assert_close(cross(a[:, :1], b), np.cross(a[:, :1], b), 1e-15, 10.0)
    assert not is_close((np.swapaxes(hat(a), -1, -2) @ b[..., None])[..., 0], wanted, 1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_about_axis_turns_the_right_handed_way(axis: int) -> None:
    """about_axis is scipy's active rotation; the paper's passive matrix is its transpose."""
    angles = np.linspace(-7.0, 7.0, 29)
    wanted = Rotation.from_rotvec(angles[:, None] * np.eye(3)[axis]).as_matrix()
    assert_close(about_axis(axis, angles), wanted, 2e-15)
    assert not is_close(np.swapaxes(about_axis(axis, angles), -1, -2), wanted, 1e-3)


def test_euler_angles_are_intrinsic_yaw_pitch_roll() -> None:
    """from_euler is intrinsic Z-Y-X, and the transpose of the paper's passive R_x R_y R_z; extrinsic z-y-x is not."""
    rng = np.random.default_rng(2)
    e = rng.uniform(-math.pi, math.pi, (50, 3))
    wanted = Rotation.from_euler("ZYX", e).as_matrix()
    assert_close(from_euler(e), wanted, 2e-15)
    passive = [np.swapaxes(about_axis(axis, e[:, 2 - axis]), -1, -2) for axis in range(3)]
    assert_close(np.swapaxes(passive[0] @ passive[1] @ passive[2], -1, -2), wanted, 2e-15)
    assert not is_close(from_euler(e), Rotation.from_euler("zyx", e).as_matrix(), 1e-3)
    assert not is_close(from_euler(e[:, ::-1]), wanted, 1e-3)


@given(EULER)
@example((0.0, 0.0, 0.0))
@example((0.7, STRAIGHT_UP, 0.0))
@example((0.7, -STRAIGHT_UP, -2.0))
@example((math.pi, 0.0, -math.pi))
@settings(max_examples=200, deadline=None)
def test_euler_angles_give_the_rotation_back(angles: tuple[float, float, float]) -> None:
    """from_euler(as_euler(R)) = R, gimbal lock included, and the angles lie in their ranges."""
    rotation = from_euler(angles)
    found = as_euler(rotation)
    assert_close(from_euler(found), rotation, 4e-15)
    assert abs(found[1]) <= math.pi / 2
    assert np.all(np.abs(found) <= math.pi)


@given(EULER.filter(lambda e: abs(e[1]) < 1.5 and max(abs(e[0]), abs(e[2])) < 3.1))
@settings(max_examples=100, deadline=None)
def test_euler_angles_come_back_away_from_gimbal_lock(angles: tuple[float, float, float]) -> None:
    """as_euler(from_euler(e)) = e where e is unique."""
    assert_close(as_euler(from_euler(angles)), angles, 1e-13)


@pytest.mark.parametrize("short_of_lock", [0.0, 1e-16, 1e-15, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_euler_angles_are_exact_beside_gimbal_lock(short_of_lock: float, side: float) -> None:
    """A rotation with rounding in its entries, pitched almost straight up, still comes back to rounding.

    Reading psi and phi off separate tiny entries fails this: each is wrong by 1e-16 / cos(theta), and so is their sum.
    """
    rng = np.random.default_rng(3)
    turns = rng.uniform(-3.0, 3.0, (100, 2))
    theta = np.full(100, side * (STRAIGHT_UP - short_of_lock))
    detour = random_rotations(rng, 100)
    rotation = detour @ (np.swapaxes(detour, -1, -2) @ from_euler(np.stack([turns[:, 0], theta, turns[:, 1]], axis=-1)))
    assert_close(from_euler(as_euler(rotation)), rotation, 1e-14)


def test_roll_is_zero_at_gimbal_lock() -> None:
    """Where psi and phi share an axis the whole turn is put into psi."""
    found = as_euler(from_euler([[0.4, STRAIGHT_UP, 0.3], [0.4, -STRAIGHT_UP, 0.3]]))
    assert_close(found, [[0.1, STRAIGHT_UP, 0.0], [0.7, -STRAIGHT_UP, 0.0]], 1e-14)


@pytest.mark.slow
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
@example((0.0, 1.0, 0.0, 0.0))
@example((0.0, 0.0, -1.0, 0.0))
@example((0.0, 0.0, 0.0, 1.0))
@example((1.0, 1e-9, 0.0, 0.0))
@example((1e-12, 1.0, -1.0, 1.0))
@settings(max_examples=200, deadline=None)
def test_quaternions_give_the_rotation_back(parts: tuple[float, float, float, float]) -> None:
    """as_quaternion(from_quaternion(q)) = +-q with w >= 0, half turns included; the order is w, x, y, z."""
    q = np.array(parts) / np.linalg.norm(parts)
    rotation = from_quaternion(q)
    found = as_quaternion(rotation)
    assert found[0] >= 0
    assert_close(found * np.sign(found @ q), q, 1e-15, 3.0)
    assert_close(from_quaternion(found), rotation, 1e-15, 3.0)
    assert_close(rotation, Rotation.from_quat(q[[1, 2, 3, 0]]).as_matrix(), 1e-15, 3.0)


def test_quaternion_order_matters() -> None:
    """A quaternion read as (x, y, z, w) is another rotation: the foil of the round trip."""
    q = np.array([0.8, 0.6, 0.0, 0.0])
    assert not is_close(from_quaternion(q), Rotation.from_quat(q).as_matrix(), 1e-3)


def test_quaternions_and_matrices_within_a_millionth_are_normalised() -> None:
    """Input a little off is taken as the rotation it means."""
    rotation = random_rotations(np.random.default_rng(4))
    q = as_quaternion(rotation)
    assert_close(from_quaternion(q * (1 + 0.9e-6)), rotation, 1e-15, 3.0)
    found = from_matrix(rotation + 3e-7 * np.ones((3, 3)))
    assert_close(found.T @ found, np.eye(3), 1e-15, 3.0)
    assert_close(found, rotation, 1e-6)
    stacked = np.stack([rotation, np.eye(3)])
    assert_close(from_matrix(stacked), stacked, 1e-15, 3.0)


def test_a_rotation_to_rounding_comes_back_bit_for_bit() -> None:
    """Normalising twice is normalising once; without the exception half of all matrices would change."""
    rng = np.random.default_rng(5)
    once = from_matrix(random_rotations(rng, 4000) + 1e-8 * rng.normal(size=(4000, 3, 3)))
    assert np.array_equal(from_matrix(once), once)
    assert not np.array_equal(orthonormalised(orthonormalised(once)), once)


@pytest.mark.parametrize(
    "quaternion",
    [
        [0.0, 0.0, 0.0, 0.0],
        [1.0 + 2e-6, 0.0, 0.0, 0.0],
        [1.0 - 2e-6, 0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0, 0.0],
        [math.nan, 0.0, 0.0, 1.0],
        [math.inf, 0.0, 0.0, 0.0],
        [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.4]],
    ],
)
def test_quaternions_that_are_no_rotation_are_refused(quaternion: list[float]) -> None:
    """A quaternion not of unit length is an error, also one in a batch of good ones."""
    with pytest.raises(ParameterError, match="unit quaternion"):
        from_quaternion(quaternion)


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((3, 3)),
        2.0 * np.eye(3),
        np.diag([1.0, 1.0, -1.0]),
        -np.eye(3),
        np.eye(3) + 1e-5 * np.ones((3, 3)),
        np.full((3, 3), math.nan),
        np.stack([np.eye(3), np.diag([1.0, -1.0, 1.0])]),
    ],
    ids=["zero", "twice", "reflection", "inversion", "sheared", "nan", "one-in-a-batch"],
)
def test_matrices_that_are_no_rotation_are_refused(matrix: np.ndarray) -> None:
    """A matrix that is not orthogonal, or a reflection, is an error."""
    with pytest.raises(ParameterError, match="rotation matrix"):
        from_matrix(matrix)


def test_orthonormalised_squares_the_defect() -> None:
    """One step takes a defect of 1e-8 to rounding, and leaves a rotation where it is."""
    rng = np.random.default_rng(5)
    rotation = random_rotations(rng, 20)
    found = orthonormalised(rotation + 1e-9 * rng.normal(size=rotation.shape))
    assert_close(np.swapaxes(found, -1, -2) @ found, np.broadcast_to(np.eye(3), (20, 3, 3)), 1e-15, 3.0)
    assert_close(orthonormalised(rotation), rotation, 1e-15, 2.0)


@pytest.mark.parametrize("angle", [0.0, 1e-15, 1e-9, 1e-6, 1e-3, 1.0, 3.0, math.pi - 1e-6, math.pi - 1e-9, math.pi])
def test_angle_between_is_exact_at_both_ends(angle: float) -> None:
    """The angle keeps its digits near 0 and near pi, where the arc cosine of the trace (the foil) loses half."""
    rng = np.random.default_rng(6)
    first = random_rotations(rng)
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    second = first @ Rotation.from_rotvec(angle * axis).as_matrix()
    assert_close(angle_between(first, second), angle, 1e-15, 4.0)
    if angle in (1e-9, math.pi - 1e-9):
        by_trace = math.acos(min(1.0, max(-1.0, (np.trace(first.T @ second) - 1) / 2)))
        assert not is_close(by_trace, angle, 1e-12)
