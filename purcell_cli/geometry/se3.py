"""The group SE(3) of base poses: 4x4 matrices g, twists (v, omega). Conventions: `rotations`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.reproducible import exp_coefficients, inner, matmul
from purcell_cli.geometry.rotations import Array, cross, hat, running
from purcell_cli.kernel import poses


def exp(twist: ArrayLike) -> Array:
    """Return the displacement made by a constant body twist in unit time.

    Args:
        twist: Twists (v, omega) [m, rad]. Shape (..., 6).

    Returns:
        Poses. Shape (..., 4, 4).
    """
    return poses.exp(twist)


def rotation(axis_angle: Array) -> Array:
    """Return the rotations with rotation vectors [rad]. Shape (..., 3) to (..., 3, 3)."""
    return poses.rotation(axis_angle)


def left_jacobian(axis_angle: Array) -> Array:
    """Return J with rotation(w + dw) = rotation(J dw) rotation(w), to leading order in dw.

    Args:
        axis_angle: Rotation vectors w [rad]. Shape (..., 3).

    Returns:
        Matrices. Shape (..., 3, 3).
    """
    _, b, c = exp_coefficients(inner(axis_angle, axis_angle))
    k = hat(axis_angle)
    return np.asarray(np.eye(3) + b[..., None, None] * k + c[..., None, None] * (matmul(k, k)))


def log(pose: ArrayLike) -> Array:
    """Return the twist (v, omega) with exp(twist) = pose, rotation angle at most pi.

    Args:
        pose: Poses. Shape (..., 4, 4).

    Returns:
        Twists [m, rad]. Shape (..., 6).
    """
    return poses.log(pose)


def inverse(pose: Array) -> Array:
    """Return the inverse pose. Shape (..., 4, 4)."""
    return poses.inverse(pose)


def pose(rotation: ArrayLike, position: ArrayLike) -> Array:
    """Return the pose with a rotation (..., 3, 3) and a position (..., 3) [m]. Shape (..., 4, 4)."""
    r, p = np.asarray(rotation, dtype=np.float64), np.asarray(position, dtype=np.float64)
    out = np.zeros((*np.broadcast_shapes(r.shape[:-2], p.shape[:-1]), 4, 4))
    out[..., :3, :3] = r
    out[..., :3, 3] = p
    out[..., 3, 3] = 1.0
    return out


def adjoint(pose: Array) -> Array:
    """Return the matrix Ad_g that carries a body twist into the frame g is seen from.

    Args:
        pose: Poses. Shape (..., 4, 4).

    Returns:
        Adjoint matrices on (v, omega). Shape (..., 6, 6).
    """
    return poses.adjoint(pose)


def bracket(first: Array, second: Array) -> Array:
    """Return the Lie bracket [first, second] of twists (v, omega). Shape (..., 6)."""
    v1, w1, v2, w2 = first[..., :3], first[..., 3:], second[..., :3], second[..., 3:]
    return np.concatenate([cross(w1, v2) - cross(w2, v1), cross(w1, w2)], axis=-1)


def normalised(pose: Array) -> Array:
    """Return the pose with its rotation made orthogonal to rounding. Shape (..., 4, 4)."""
    return poses.orthonormalised(pose)


def power(pose: Array, exponent: ArrayLike) -> Array:
    """Return pose^n along its one-parameter subgroup: n equal displacements one after the other.

    Args:
        pose: Poses. Shape (..., 4, 4).
        exponent: Powers, broadcast against the poses; the first power is the pose to the bit. Shape (...).

    Returns:
        Poses. Shape (..., 4, 4).
    """
    n = np.asarray(exponent, dtype=np.float64)
    if np.all(n == 1.0):
        return np.array(np.broadcast_to(pose, (*np.broadcast_shapes(n.shape, pose.shape[:-2]), 4, 4)))
    return np.where((n == 1.0)[..., None, None], pose, exp(n[..., None] * log(pose)))


def prefix_products(moves: Array) -> Array:
    """Return the running products I, g_1, g_1 g_2, ... of displacements.

    Args:
        moves: Displacements. Shape (n, 4, 4).

    Returns:
        Poses before, between and after them. Shape (n + 1, 4, 4).
    """
    return normalised(running(np.concatenate([np.eye(4)[None], moves])))
