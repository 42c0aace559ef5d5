"""Rotations and the conventions of the whole project.

Conventions (every other docstring points here):

- World frame; base frame at the middle of the base link, x along the link. Limb 1 hangs at the
  base's +x end, limb 2 at its -x end. Lengths in m, angles in rad, time in s.
- Orientations are active: ``A_1``, ``A_2`` turn limb coordinates into base coordinates, ``R``
  turns base coordinates into world coordinates. The paper's R_1, R_2 are the transposes.
  A shape is the pair (A_1, A_2), an array of shape (..., 2, 3, 3); collinear is the identity.
- Euler angles (psi, theta, phi) are the intrinsic Z-Y-X angles (yaw, pitch, roll) of the active
  matrix: R = Rz(psi) Ry(theta) Rx(phi). This equals the paper's passive R_x R_y R_z (section V-C).
- Quaternions are (w, x, y, z).
- Twists are (v, omega) in the body frame; a pose is a 4x4 matrix g with g' = g hat(xi).
- The six controls are the limbs' rates in their own frames, A_i' = A_i hat(omega_i), in the order
  limb 1 x, y, z, limb 2 x, y, z. About x is roll, about y pitch, about z yaw.

Written here and not taken from `scipy.spatial.transform`: to import that takes 0.5 s of processor time, more than twice
what numpy takes, and every command would wait for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.reproducible import arctan2, hypot, inner, matmul, norm, sin_cos
from purcell_cli.kernel import linear, poses

Array = NDArray[np.float64]

INPUT_SLACK = 1e-6
"""A quaternion or matrix this close to valid is normalised; further off it is refused."""

MEASURED_SLACK = 1e-2
"""What a measured quaternion or matrix may be off, which is written with two digits or more."""

_BOUND = 1.0 + 1e-9
"""Times a slack, so that what is off by just the slack is not refused by rounding: 1.01 - 1 is more than 0.01."""

_ROUNDING = 1e-15
"""What the elements of A^T A are off the identity where A is a rotation to rounding; at most half of it is seen."""

_AXES = np.eye(3)
"""The axes e_x, e_y, e_z, one a row."""


def hat(vector: ArrayLike) -> Array:
    """Return the matrix of the cross product with a vector, in its precision (appendix B of the paper).

    Args:
        vector: Vectors. Shape (..., 3).

    Returns:
        Skew matrices. Shape (..., 3, 3).
    """
    v = np.asarray(vector)
    out = np.zeros((*v.shape, 3), dtype=np.result_type(v, np.float64))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def cross(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the cross product over the last axis. Shapes (..., 3), broadcast."""
    return linear.cross(a, b)


def about_axis(axis: int, angle: ArrayLike) -> Array:
    """Return the rotation about one coordinate axis.

    Args:
        axis: 0, 1 or 2 for x (roll), y (pitch), z (yaw).
        angle: Angles [rad]. Shape (...).

    Returns:
        Active rotation matrices. Shape (..., 3, 3).
    """
    t = np.asarray(angle, dtype=np.float64)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros((*t.shape, 3, 3))
    s, c = sin_cos(t)
    out[..., axis, axis] = 1.0
    out[..., j, j], out[..., j, k] = c, -s
    out[..., k, j], out[..., k, k] = s, c
    return out


def orthonormalised(matrix: Array) -> Array:
    """Return the rotation nearest to an almost orthogonal matrix (one Newton step of the polar factor).

    The step squares the defect, so it is exact for matrices within 1e-8 of orthogonal.

    Args:
        matrix: Matrices orthogonal up to rounding. Shape (..., 3, 3).
    """
    return poses.orthonormalised(matrix)


def running(values: NDArray[Any], product: Callable[..., NDArray[Any]] = matmul) -> NDArray[Any]:
    """Return a_1, a_1 a_2, a_1 a_2 a_3, ... in the values' precision.

    Neighbours are put together two by two, those again, and what lies between is filled in: twice as many products as
    there are values, and rounding that grows with the logarithm of their number.

    Args:
        values: What is multiplied. Shape (n, ...).
        product: An associative product of two arrays of values.

    Returns:
        The products. Shape (n, ...).
    """
    if len(values) < 2:
        return values
    out = np.empty_like(values)
    out[0] = values[0]
    out[1::2] = pairs = running(product(values[:-1:2], values[1::2]), product)
    out[2::2] = product(pairs[: (len(values) - 1) // 2], values[2::2])
    return out


def from_euler(angles: ArrayLike) -> Array:
    """Return the rotation with Euler angles (psi, theta, phi) [rad]. Shape (..., 3) to (..., 3, 3)."""
    e = np.asarray(angles, dtype=np.float64)
    return matmul(matmul(about_axis(2, e[..., 0]), about_axis(1, e[..., 1])), about_axis(0, e[..., 2]))


def as_euler(rotation: ArrayLike) -> Array:
    """Return the Euler angles (psi, theta, phi) [rad] of a rotation. Shape (..., 3, 3) to (..., 3).

    At theta = +-pi/2, where psi and phi share an axis, phi is taken as 0.
    """
    r = np.asarray(rotation, dtype=np.float64)
    cos_theta = hypot(r[..., 0, 0], r[..., 1, 0])
    locked = cos_theta < 1e-15
    theta = arctan2(-r[..., 2, 0], cos_theta)
    psi = np.where(
        locked,
        arctan2(-r[..., 0, 1], r[..., 1, 1]),
        arctan2(r[..., 1, 0], r[..., 0, 0]),
    )
    # What is left of the rotation after yaw is taken back: well conditioned next to the lock too.
    s, c = sin_cos(psi)
    phi = arctan2(s * r[..., 0, 2] - c * r[..., 1, 2], c * r[..., 1, 1] - s * r[..., 0, 1])
    return np.stack([psi, theta, np.where(locked, 0.0, phi)], axis=-1)


def from_quaternion(quaternion: ArrayLike, slack: float = INPUT_SLACK) -> Array:
    """Return the rotation of a unit quaternion (w, x, y, z).

    Args:
        quaternion: The quaternion. Shape (..., 4).
        slack: What its length may differ from 1.

    Returns:
        The rotation. Shape (..., 3, 3).

    Raises:
        ParameterError: The quaternion's length differs from 1 by more than the slack.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    if q.shape[-1:] != (4,):
        raise ParameterError(f"a quaternion of 4 numbers (w, x, y, z) is wanted, found shape {q.shape}")
    length = norm(q)[..., None]
    off = np.abs(length - 1.0)
    if not np.all(off <= slack * _BOUND):
        found = float(length.ravel()[np.argmax(np.where(np.isnan(off), np.inf, off))])
        raise ParameterError(f"a unit quaternion (length 1 within {slack:g}) is wanted, found length {found:.9g}")
    w, v = (q / length)[..., :1], (q / length)[..., 1:]
    k = hat(v)
    return np.asarray(_AXES + 2.0 * (w[..., None] * k + matmul(k, k)))


def as_quaternion(rotation: ArrayLike) -> Array:
    """Return the unit quaternion (w, x, y, z) of a rotation, w >= 0. Shape (..., 3, 3) to (..., 4)."""
    return poses.quaternion(rotation)


def quaternion_error(quaternion: ArrayLike) -> Array:
    """Return what the length of a quaternion differs from 1. Shape (..., 4) to (...)."""
    return np.asarray(np.abs(norm(np.asarray(quaternion, dtype=np.float64)) - 1.0))


def matrix_error(matrix: ArrayLike) -> Array:
    """Return what a matrix is off orthogonal: half of what A^T A is off the identity. Shape (..., 3, 3) to (...).

    To leading order this is what its elements are off the nearest rotation's, in the rotated frame.
    """
    m = np.asarray(matrix, dtype=np.float64)
    return np.asarray(np.max(np.abs(matmul(np.swapaxes(m, -1, -2), m) - _AXES), axis=(-1, -2)) / 2.0)


def from_matrix(matrix: ArrayLike, slack: float = INPUT_SLACK) -> Array:
    """Return the rotation nearest to a matrix that is almost one.

    A matrix that is one to rounding comes back bit for bit, so that what is written reads back.

    Args:
        matrix: The matrix. Shape (..., 3, 3).
        slack: What it may be off, as `matrix_error` says.

    Returns:
        The rotation. Shape (..., 3, 3).

    Raises:
        ParameterError: The matrix is further than the slack from orthogonal, or a reflection.
    """
    m = np.asarray(matrix, dtype=np.float64)
    error = matrix_error(m)
    if not np.all(error <= slack * _BOUND):
        raise ParameterError(
            f"a rotation matrix (orthogonal within {slack:g}) is wanted, found one off by {2.0 * np.max(error):.3g}"
        )
    if np.any(error > INPUT_SLACK):  # each step squares what it is off
        m = orthonormalised(orthonormalised(m))
    defect = 2.0 * matrix_error(m)[..., None, None]
    if not np.all(inner(m[..., 0, :], cross(m[..., 1, :], m[..., 2, :])) > 0):
        raise ParameterError("a rotation matrix is wanted, found a reflection (determinant -1)")
    return np.asarray(np.where(defect <= _ROUNDING, m, orthonormalised(orthonormalised(m))))


def as_vector(rotation: ArrayLike) -> Array:
    """Return the rotation vector of a rotation, at most pi long [rad]. Shape (..., 3, 3) to (..., 3)."""
    q = as_quaternion(rotation)
    sine = norm(q[..., 1:])[..., None]
    stretch = np.where(sine > 1e-150, 2.0 * arctan2(sine, q[..., :1]) / np.maximum(sine, 1e-150), 2.0)
    return np.asarray(stretch * q[..., 1:])


def wrapped(angle: ArrayLike) -> Array:
    """Return angles taken to between -pi and pi [rad]. Shape (...)."""
    return np.asarray(np.remainder(np.asarray(angle, dtype=np.float64) + np.pi, 2.0 * np.pi) - np.pi)


def angle_between(first: ArrayLike, second: ArrayLike) -> Array:
    """Return the angle [rad] of the rotation that takes one orientation to another. Shape (...).

    Accurate for small angles and near pi alike (half-angle quaternion form).
    """
    relative = matmul(np.swapaxes(np.asarray(first, dtype=np.float64), -1, -2), np.asarray(second, dtype=np.float64))
    return np.asarray(norm(as_vector(relative)))
