"""Needle steering in numpy, all beginnings at once: what the kernel's is compared with."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import apply, exp_coefficients, hypot, matmul
from purcell_cli.geometry.rotations import Array, about_axis, hat
from purcell_cli.planner.arcs.loop_family import Fan


def steered(inverse: Array, begun: Array, fan: Fan) -> tuple[Array, Array]:
    """Return arcs and a last roll, shape (n, 10), and what they miss, shape (n,)."""
    x, n = begun, len(begun)
    loose = np.empty((n, 10))
    for k_round in range(10):
        residual, jacobian = _equations(x, inverse)
        weighing = k_round < 7
        if weighing:
            loose = np.concatenate([_looseness(x[:, :9].reshape(n, 3, 3), fan), np.full((n, 1), 10.0)], axis=1)
        lever = jacobian * loose[:, None, :]
        system = matmul(lever, np.swapaxes(jacobian, 1, 2))
        system += 1e-12 * np.trace(system, axis1=1, axis2=2)[:, None, None] * np.eye(6)
        from_here = x if weighing else 0.0 * x
        wanted = apply(jacobian, from_here) - residual
        step = apply(np.swapaxes(lever, 1, 2), np.linalg.solve(system, wanted[..., None])[..., 0]) - from_here
        turning = np.max(np.abs(step[:, [1, 2, 4, 5, 7, 8, 9]]), axis=1)
        x = x + step * np.minimum(1.0, 0.5 / np.maximum(turning, 1e-300))[:, None]
    return x, np.max(np.abs(_equations(x, inverse)[0]), axis=1)


def _looseness(arc: Array, fan: Fan) -> Array:
    """Return the inverse weights of quadratics that fall with the joint travel of arcs. Shape (n, 9)."""
    a, b = np.abs(arc[..., 0]), hypot(arc[..., 1], arc[..., 2])
    here = np.maximum(fan.cost(a, b), 1e-2)
    a = np.maximum(a, np.minimum(0.1 * fan.straight * here, 1.0))
    b = np.maximum(b, np.minimum(0.1 * fan.tight * here, 0.5))
    here, more_a, more_b = fan.cost(np.stack([a, 1.01 * a, a]), np.stack([b, b, 1.01 * b]))
    loose_a = a**2 / (here * np.maximum(100.0 * (more_a / here - 1.0), 0.05))
    loose_b = b**2 / (here * np.maximum(100.0 * (more_b / here - 1.0), 0.05))
    return np.stack([loose_a, loose_b, loose_b], axis=-1).reshape(len(arc), 9)


def _swum(arc: Array) -> tuple[Array, Array, Array]:
    """Return the displacements exp(a, 0, 0; 0, p, q) of arcs, and the body twists of changes of a, p and q.

    The exponential's series have only even powers of the turn, so their closed forms (Murray, Li
    and Sastry 1994, A mathematical introduction to robotic manipulation, section 2.3) need no root.

    Args:
        arc: Advance [L] and turns about y and z [rad]. Shape (n, 3).

    Returns:
        Rotations, shape (n, 3, 3), positions, shape (n, 3), and twists, shape (n, 6, 3).
    """
    a, p, q = arc.T
    tt = p * p + q * q
    sine, cosine, rest = exp_coefficients(tt)
    sine_slope = rest - cosine  # (d/dt sin t / t) / t, and the same of (1 - cos t) / t^2
    small = tt < 1e-6
    cosine_slope = np.where(small, tt / 180.0 - 1.0 / 12.0, (sine - 2.0 * cosine) / np.where(small, 1.0, tt))
    zero, one = np.zeros_like(a), np.ones_like(a)
    rotation = np.empty((len(a), 3, 3))
    rotation[:, 0] = np.stack([1.0 - cosine * tt, -sine * q, sine * p], axis=-1)
    rotation[:, 1] = np.stack([sine * q, 1.0 - cosine * q * q, cosine * p * q], axis=-1)
    rotation[:, 2] = np.stack([-sine * p, cosine * p * q, 1.0 - cosine * p * p], axis=-1)
    unit = np.stack([sine, cosine * q, -cosine * p], axis=-1)
    slope = np.empty((len(a), 3, 3))
    slope[:, :, 0] = unit
    for k, (w, across) in enumerate(((p, (zero, zero, -cosine)), (q, (zero, cosine, zero))), 1):
        parts = (sine_slope * w, cosine_slope * w * q + across[1], -cosine_slope * w * p + across[2])
        slope[:, :, k] = a[:, None] * np.stack(parts, axis=-1)
    twist = np.zeros((len(a), 6, 3))
    twist[:, :3] = matmul(np.swapaxes(rotation, 1, 2), slope)
    # The right Jacobian 1 - (1 - cos t) / t^2 hat(w) + (t - sin t) / t^3 hat(w)^2 on the axes y and z.
    twist[:, 3:, 1] = np.stack([cosine * q, one - rest * q * q, rest * p * q], axis=-1)
    twist[:, 3:, 2] = np.stack([-cosine * p, rest * p * q, one - rest * p * p], axis=-1)
    return rotation, a[:, None] * unit, twist


def _equations(x: Array, inverse: Array) -> tuple[Array, Array]:
    """Return log(D^-1 exp .. exp) and its derivative. Shapes (n, 6) and (n, 6, 3 m + 1)."""
    n, m = len(x), x.shape[1] // 3
    moves = _swum(x[:, :-1].reshape(n * m, 3))
    rotation, position, twist = (part.reshape(n, m, *part.shape[1:]) for part in moves)
    jacobian = np.empty((n, 6, 3 * m + 1))
    jacobian[:, :, -1] = np.eye(6)[3]
    turned, moved = about_axis(0, x[:, -1]), np.zeros((n, 3))
    for k in reversed(range(m)):
        back = np.swapaxes(turned, 1, 2)
        speed, spin = twist[:, k, :3], twist[:, k, 3:]
        jacobian[:, :3, 3 * k : 3 * k + 3] = matmul(back, speed - matmul(hat(moved), spin))
        jacobian[:, 3:, 3 * k : 3 * k + 3] = matmul(back, spin)
        moved = (matmul(rotation[:, k], moved[..., None]))[..., 0] + position[:, k]
        turned = matmul(rotation[:, k], turned)
    return se3.log(se3.normalised(matmul(inverse, se3.pose(turned, moved)))), jacobian
