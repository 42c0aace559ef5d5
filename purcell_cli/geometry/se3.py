"""The group SE(3) of base poses: 4x4 matrices g, twists (v, omega). Conventions: `rotations`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.reproducible import arctan2, exp_coefficients, inner, matmul
from purcell_cli.geometry.rotations import Array, as_quaternion, cross, hat, orthonormalised, running

_SERIES_BELOW = 0.25
"""Rotation angle [rad] under which (t - sin t)/t^3 sums its series; above, the closed form loses nothing."""


def exp(twist: ArrayLike) -> Array:
    """Return the displacement made by a constant body twist in unit time.

    Args:
        twist: Twists (v, omega) [m, rad]. Shape (..., 6).

    Returns:
        Poses. Shape (..., 4, 4).
    """
    xi = np.asarray(twist, dtype=np.float64)
    v, w = xi[..., :3], xi[..., 3:]
    a, b, c = exp_coefficients(inner(w, w))
    k = hat(w)
    k2 = matmul(k, k)
    out = np.zeros((*xi.shape[:-1], 4, 4))
    rotation = out[..., :3, :3]
    rotation[...] = a[..., None, None] * k + b[..., None, None] * k2
    wv = cross(w, v)
    out[..., :3, 3] = v + b[..., None] * wv + c[..., None] * cross(w, wv)
    for i in range(4):
        out[..., i, i] += 1.0
    return out


def rotation(axis_angle: Array) -> Array:
    """Return the rotations with rotation vectors [rad]. Shape (..., 3) to (..., 3, 3)."""
    a, b, _ = exp_coefficients(inner(axis_angle, axis_angle))
    k = hat(axis_angle)
    return np.asarray(np.eye(3) + a[..., None, None] * k + b[..., None, None] * (matmul(k, k)))


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
    g = np.asarray(pose, dtype=np.float64)
    q = as_quaternion(g[..., :3, :3])
    sine = np.sqrt(inner(q[..., 1:], q[..., 1:]))
    half = arctan2(sine, q[..., 0])
    stretch = 2.0 * np.where(sine > 0.0, half / np.where(sine > 0.0, sine, 1.0), 1.0)
    w = q[..., 1:] * stretch[..., None]
    # The inverse of exp's integral of the rotation: 1 - hat(w) / 2 + (1 - t/2 cot t/2) / t^2 hat(w)^2.
    x = 4.0 * half * half
    rest = (1 + x / 60 * (1 + x / 42 * (1 + x / 40 * (1 + 5 * x / 198)))) / 12
    if x.size and x.max() >= _SERIES_BELOW**2:
        closed = (1.0 - 0.5 * stretch * q[..., 0]) / np.where(sine > 0.0, x, 1.0)
        rest = np.where(x < _SERIES_BELOW**2, rest, closed)
    p = g[..., :3, 3]
    wp = cross(w, p)
    return np.concatenate([p - 0.5 * wp + rest[..., None] * cross(w, wp), w], axis=-1)


def inverse(pose: Array) -> Array:
    """Return the inverse pose. Shape (..., 4, 4)."""
    out = np.zeros_like(pose)
    rt = np.swapaxes(pose[..., :3, :3], -1, -2)
    out[..., :3, :3] = rt
    out[..., :3, 3] = -(matmul(rt, pose[..., :3, 3, None]))[..., 0]
    out[..., 3, 3] = 1.0
    return out


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
    r = pose[..., :3, :3]
    out = np.zeros((*pose.shape[:-2], 6, 6))
    out[..., :3, :3] = r
    out[..., 3:, 3:] = r
    out[..., :3, 3:] = matmul(hat(pose[..., :3, 3]), r)
    return out


def bracket(first: Array, second: Array) -> Array:
    """Return the Lie bracket [first, second] of twists (v, omega). Shape (..., 6)."""
    v1, w1, v2, w2 = first[..., :3], first[..., 3:], second[..., :3], second[..., 3:]
    return np.concatenate([cross(w1, v2) - cross(w2, v1), cross(w1, w2)], axis=-1)


def normalised(pose: Array) -> Array:
    """Return the pose with its rotation made orthogonal to rounding. Shape (..., 4, 4)."""
    out = pose.copy()
    out[..., :3, :3] = orthonormalised(pose[..., :3, :3])
    return out


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


def extended(poses: Array) -> Array:
    """Return poses in extended precision, where the machine has it: products of thousands lose nothing. Shape (...)."""
    return np.asarray(poses, dtype=np.longdouble)


def products(poses: Array, counts: ArrayLike) -> Array:
    """Return the products of consecutive runs of displacements, in their precision.

    Args:
        poses: Displacements. Shape (n, 4, 4).
        counts: How many each run has, in order; n together. Shape (k,).

    Returns:
        Poses, the identity for an empty run. Shape (k, 4, 4).
    """
    left = np.array(counts, dtype=np.int64)
    while np.any(left > 1):
        # Neighbours in a run are put together, two by two.
        half = (left + 1) // 2
        inside = np.arange(half.sum()) - np.repeat(np.cumsum(half) - half, half)
        even = np.repeat(np.cumsum(left) - left, half) + 2 * inside
        paired = np.flatnonzero(2 * inside + 1 < np.repeat(left, half))
        together = poses[even]
        together[paired] = matmul(together[paired], poses[even[paired] + 1])
        poses, left = together, half
    out = np.tile(np.eye(4, dtype=poses.dtype), (len(left), 1, 1))
    out[left > 0] = poses
    return out


def product(moves: Array, which: ArrayLike) -> Array:
    """Return the product of displacements that come again and again, in their precision.

    Neighbours are put together two by two, and each pair only once, however often it comes.

    Args:
        moves: The displacements. Shape (k, 4, 4).
        which: Which of them are made, in order. Shape (n,).

    Returns:
        A pose, the identity where none are made. Shape (4, 4).
    """
    left = np.array(which, dtype=np.int64)
    if not len(left):
        return np.eye(4, dtype=moves.dtype)
    while len(left) > 1:
        count = len(moves)
        pairs, order = np.unique(left[:-1:2] * count + left[1::2], return_inverse=True)
        moves = np.concatenate([matmul(moves[pairs // count], moves[pairs % count]), moves[left[-1:]]])
        left = np.append(order, len(pairs)) if len(left) % 2 else order
    return np.asarray(moves[left[0]])


def repeated(poses: Array, counts: ArrayLike) -> Array:
    """Return whole powers of poses, by squaring, in their precision; the first power is the pose to the bit.

    Args:
        poses: Displacements. Shape (k, 4, 4).
        counts: How often each is made, not negative. Shape (k,).

    Returns:
        Poses. Shape (k, 4, 4).
    """
    left = np.array(counts, dtype=np.int64)
    done, power = np.tile(np.eye(4, dtype=poses.dtype), (len(left), 1, 1)), poses
    while np.any(left):
        done = np.where((left % 2 == 1)[:, None, None], matmul(done, power), done)
        left = left // 2
        power = normalised(matmul(power, power)) if np.any(left) else power
    return done


def prefix_products(poses: Array) -> Array:
    """Return the running products I, g_1, g_1 g_2, ... of displacements.

    Args:
        poses: Displacements. Shape (n, 4, 4).

    Returns:
        Poses before, between and after them. Shape (n + 1, 4, 4).
    """
    return normalised(running(np.concatenate([np.eye(4, dtype=poses.dtype)[None], poses])))


def running_products(start: Array, moves: Array) -> Array:
    """Return start, start g_1, start g_1 g_2, ... in their precision.

    Args:
        start: A pose. Shape (4, 4).
        moves: Displacements. Shape (n, 4, 4).

    Returns:
        Poses. Shape (n + 1, 4, 4).
    """
    return running(np.concatenate([start[None], moves]))
