"""The local connection form A(r) of the swimmer (sections III-B and III-C of the paper, as corrected).

Every function takes a shape (A_1, A_2) as an array (..., 2, 3, 3) and is batched over its leading
axes. Conventions: `rotations`.

Where this differs from the print: B_1 and B_2 carry the rotation in their upper right block and
give the velocity at the limb's centre, which is the point H_i is the drag about. As printed, P
would not be symmetric.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.component_first import cross_rows, dot_rows, factored_rows, solved_rows
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import apply, inner, matmul
from purcell_cli.geometry.rotations import Array, cross, from_euler, hat
from purcell_cli.mechanics.bead_table import tabulated
from purcell_cli.mechanics.beads import LOWER, grand_resistance, solved_anew
from purcell_cli.mechanics.swimmer import Swimmer

COLLINEAR: Array = np.stack([np.eye(3), np.eye(3)])
"""The collinear shape, the identity of SO(3) x SO(3). Shape (2, 3, 3)."""
COLLINEAR.setflags(write=False)

_E_X = np.array([1.0, 0.0, 0.0])
"""The axis of a link in its own frame."""

_SLACK = 1e-2
"""How far from orthogonal limb orientations may be: the stages of an integrator stray, other arrays are mistakes."""

_SIDE = {1: 1.0, 2: -1.0}
"""On which side of the base's middle each limb hangs."""


def checked_shape(shape: ArrayLike) -> Array:
    """Return a shape as an array of two orientations. Shape (..., 2, 3, 3).

    Raises:
        ParameterError: An array of another form, or of matrices that are no rotations within `_SLACK`.
    """
    r = _of_two(shape)
    if shape is not COLLINEAR:
        defect = np.max(np.abs(matmul(np.swapaxes(r, -1, -2), r) - np.eye(3)), initial=0.0)
        right_handed = inner(r[..., 0, :], cross(r[..., 1, :], r[..., 2, :])) > 0.0
        if not (defect <= _SLACK and np.all(right_handed)):
            why = f"off by {defect:.3g}" if not defect <= _SLACK else "that is a reflection"
            raise ParameterError(f"limb orientations are rotation matrices within {_SLACK:g}, found one {why}")
    return r


def shape_from_angles(
    limb1_euler_deg: ArrayLike = (0.0, 0.0, 0.0), limb2_euler_deg: ArrayLike = (0.0, 0.0, 0.0)
) -> Array:
    """Return the shape r = (A_1, A_2) of Euler angles (psi, theta, phi). Shape (..., 2, 3, 3).

    Args:
        limb1_euler_deg: Limb 1's orientation in the base [deg]. Shape (..., 3).
        limb2_euler_deg: Limb 2's orientation in the base [deg]. Shape (..., 3).
    """
    return np.stack([from_euler(np.radians(e)) for e in (limb1_euler_deg, limb2_euler_deg)], axis=-3)


def _of_two(shape: ArrayLike) -> Array:
    r = np.asarray(shape, dtype=np.float64)
    if r.ndim < 3 or r.shape[-3:] != (2, 3, 3):
        raise ParameterError(f"a shape is an array (..., 2, 3, 3) of two limb orientations, found {r.shape}")
    return r


def _limb(shape: ArrayLike, limb: int) -> Array:
    return _of_two(shape)[..., limb - 1, :, :]


def centre(swimmer: Swimmer, shape: ArrayLike, limb: int) -> Array:
    """Return c_i, the centre of a limb in base coordinates [m]. Shape (..., 3)."""
    a = _limb(shape, limb)[..., :, 0]
    return _SIDE[limb] * (swimmer.base_half_length_m * _E_X + swimmer.halves_m[limb] * a)


def base_to_limb(swimmer: Swimmer, shape: ArrayLike, limb: int) -> Array:
    """Return B_i, which takes the base's twist to the limb's at its centre, in its own frame.

    B_i = [[A_i^T, -A_i^T hat(c_i)], [0, A_i^T]]; corrects equations (xi1), (xi2) of section III-C.

    Returns:
        Matrices on (v, omega). Shape (..., 6, 6).
    """
    a_t = np.swapaxes(_limb(shape, limb), -1, -2)
    out = np.zeros((*a_t.shape[:-2], 6, 6))
    out[..., :3, :3] = a_t
    out[..., 3:, 3:] = a_t
    out[..., :3, 3:] = matmul(-a_t, hat(centre(swimmer, shape, limb)))
    return out


def rate_to_limb(swimmer: Swimmer, limb: int) -> Array:
    """Return W_i, which takes the limb's rate omega_i to its twist at its centre. Shape (6, 3)."""
    out = np.zeros((6, 3))
    out[:3] = -_SIDE[limb] * swimmer.halves_m[limb] * hat(_E_X)
    out[3:] = np.eye(3)
    return out


def resistance_and_coupling(swimmer: Swimmer, shape: ArrayLike) -> tuple[Array, Array]:
    """Return P and Q of section III-C, the wrenches on the frozen shape and on a base at rest.

    P = H_0 + sum T_i H_i B_i takes the base's twist to force and torque; it is symmetric positive
    definite. Q = [T_1 H_1 W_1, T_2 H_2 W_2] takes the limb rates to them.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations (A_1, A_2). Shape (..., 2, 3, 3).

    Returns:
        P and Q, on (v, omega) and on (omega_1, omega_2). Each of shape (..., 6, 6).
    """
    if swimmer.fluid == "beads":
        return _on_beads(swimmer, _of_two(shape))
    p = np.zeros((*np.shape(shape)[:-3], 6, 6)) + swimmer.drag_matrix(0)
    q = np.zeros_like(p)
    for limb in (1, 2):
        b = base_to_limb(swimmer, shape, limb)
        wrench = matmul(np.swapaxes(b, -1, -2), swimmer.drag_matrix(limb))
        p += matmul(wrench, b)
        q[..., 3 * limb - 3 : 3 * limb] = matmul(wrench, rate_to_limb(swimmer, limb))
    return p, q


def _on_beads(swimmer: Swimmer, shape: Array) -> tuple[Array, Array]:
    """Return P and Q of links that feel each other's flow, from the beads themselves."""
    shapes = shape.reshape(-1, 2, 3, 3)
    full = np.zeros((len(shapes), 12, 12))
    for k, one in enumerate(shapes):
        full[k] = grand_resistance(swimmer, one[..., 0])
    q = np.concatenate([matmul(full[:, :6, 6 + 3 * i : 9 + 3 * i], shapes[:, i]) for i in (0, 1)], axis=-1)
    return full[:, :6, :6].reshape(*shape.shape[:-3], 6, 6), q.reshape(*shape.shape[:-3], 6, 6)


def connection(swimmer: Swimmer, shape: ArrayLike) -> Array:
    """Return the local connection form A(r) = P^-1 Q: the base's twist is xi = -A(r) omega.

    Equation (Final_kinematic_model) of section III-C. Its rank is at most 5, and 5
    at almost every shape.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations (A_1, A_2). Shape (..., 2, 3, 3).

    Returns:
        Matrices from (omega_1, omega_2) [rad/s] to (v, omega) [m/s, rad/s]. Shape (..., 6, 6). For a swimmer whose
        links feel each other it is that of the beads themselves, not of their table.

    Raises:
        ParameterError: An array of another form, or of matrices that are no rotations.
    """
    checked_shape(shape)
    unit = swimmer.scaled()
    out = np.asarray(solve(*resistance_and_coupling(unit, shape)), dtype=np.float64)
    out[..., :3, :] *= swimmer.length_m
    return out


def base_twist(swimmer: Swimmer, shape: ArrayLike, rate: ArrayLike) -> Array:
    """Return the base's body twist xi = -A(r) omega for limb rates (..., 6) [rad/s]. Shape (..., 6).

    For a swimmer whose links feel each other it is that of the beads themselves, not of their table.
    """
    r, omega = np.asarray(shape, dtype=np.float64), np.asarray(rate, dtype=np.float64)
    if omega.shape[-1:] != (6,):
        raise ParameterError(f"six limb rates (omega_1, omega_2) are wanted, found shape {omega.shape}")
    _limb(r, 1)
    batch = np.broadcast_shapes(r.shape[:-3], omega.shape[:-1])
    shapes = np.broadcast_to(r, (*batch, 2, 3, 3)).reshape(-1, 2, 3, 3)
    turning = matmul(shapes, np.broadcast_to(omega, (*batch, 6)).reshape(-1, 2, 3, 1))
    rows = shapes[..., 0].transpose(1, 2, 0), turning[..., 0].transpose(1, 2, 0)
    xi = base_twist_rows(swimmer, *rows, solved_anew)
    return xi.T.reshape(*batch, 6)


def base_twist_rows(
    swimmer: Swimmer, axis: Array, turning: Array, resistances: Callable[[Swimmer, Array], Array] = tabulated
) -> Array:
    """Return the base's body twist for limb axes a = A e_x and rates u = A omega in base coordinates.

    In the precision of the axes. P xi + q = 0, set up link by link. Drag is the same all round a link, so A D A^T is
    K = d_2 1 + (d_1 - d_2) a a^T, and likewise T for torques. A limb adds
    [[K, -K hat(c)], [hat(c) K, T - hat(c) K hat(c)]] to P, and to q the wrench of its turning by u about its joint.

    Args:
        swimmer: The swimmer.
        axis: The limbs' axes. Shape (2, 3, n).
        turning: The limbs' rates in base coordinates [rad/s]. Shape (2, 3, n).
        resistances: Of links that feel each other, at L = 1 for limb axes (n, 2, 3): from their table, or from the
            beads themselves (`beads.solved_anew`).

    Returns:
        Twists (v, omega) [m/s, rad/s]. Shape (6, n).
    """
    unit = swimmer.scaled()
    if swimmer.fluid == "beads":
        xi = _on_beads_rows(unit, axis, turning, resistances)
        xi[:3] *= swimmer.length_m
        return xi
    p, q = (np.zeros((*rows, axis.shape[-1]), dtype=np.result_type(axis, np.float64)) for rows in ((6, 6), (6,)))
    p[...] = unit.drag_matrix(0)[..., None]
    for limb, side in _SIDE.items():
        half, drag = unit.halves_m[limb], np.diag(unit.drag_matrix(limb))
        a, u = axis[limb - 1], turning[limb - 1]
        c = side * half * a
        c[0] += side * unit.base_half_length_m
        k, torque = ((d[0] - d[1]) * a[:, None] * a + (d[1] * np.eye(3))[..., None] for d in (drag[:3], drag[3:]))
        arm = cross_rows(c[:, None], k)  # hat(c) K
        p[:3, :3] += k
        p[3:, :3] += arm
        p[:3, 3:] += arm.swapaxes(0, 1)
        p[3:, 3:] += torque + cross_rows(c[:, None], arm.swapaxes(0, 1))
        push = (side * half * drag[1]) * cross_rows(u, a)
        q[:3] += push
        q[3:] += drag[4] * u + ((drag[3] - drag[4]) * dot_rows(a, u)) * a + cross_rows(c, push)
    xi = solved_rows(factored_rows(p), -q)
    xi[:3] *= swimmer.length_m
    return xi


def _on_beads_rows(unit: Swimmer, axis: Array, turning: Array, resistances: Callable[[Swimmer, Array], Array]) -> Array:
    """Return the same for links that feel each other's flow."""
    row, column = LOWER
    entries = resistances(unit, np.ascontiguousarray(axis.transpose(2, 0, 1), dtype=np.float64)).T
    full = np.empty((12, 12, axis.shape[-1]), dtype=np.result_type(axis, np.float64))
    full[row, column] = full[column, row] = entries
    q = np.sum(full[:6, 6:] * turning.reshape(6, -1), axis=1)
    return solved_rows(factored_rows(full[:6, :6]), -q)


def link_twist(swimmer: Swimmer, shape: ArrayLike, rate: ArrayLike, xi_base: Array, link: int) -> Array:
    """Return the twist xi_i = B_i xi + W_i omega_i of a link at its centre, in its own frame.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations. Shape (..., 2, 3, 3).
        rate: Limb rates (omega_1, omega_2) [rad/s]. Shape (..., 6).
        xi_base: The base's body twist (v, omega) [m/s, rad/s]. Shape (..., 6).
        link: 0 for the base, 1 or 2 for a limb.

    Returns:
        Twists (v, omega) [m/s, rad/s]. Shape (..., 6).
    """
    if link == 0:
        return xi_base
    omega = np.asarray(rate, dtype=np.float64)[..., 3 * (link - 1) : 3 * link]
    return apply(base_to_limb(swimmer, shape, link), xi_base) + apply(rate_to_limb(swimmer, link), omega)


def power(swimmer: Swimmer, shape: ArrayLike, rate: ArrayLike) -> Array:
    """Return the dissipated power, the sum over the links of xi_i^T H_i xi_i [W].

    Args:
        swimmer: The swimmer.
        shape: Limb orientations. Shape (..., 2, 3, 3).
        rate: Limb rates (omega_1, omega_2) [rad/s]. Shape (..., 6).

    Returns:
        Power. Shape (...).
    """
    xi_base = base_twist(swimmer, shape, rate)
    if swimmer.fluid == "beads":
        return _power_on_beads(swimmer, _of_two(shape), np.asarray(rate, dtype=np.float64), xi_base)
    total = np.zeros(xi_base.shape[:-1])
    for link in range(3):
        xi = link_twist(swimmer, shape, rate, xi_base, link)
        total = total + inner(xi, apply(swimmer.drag_matrix(link), xi))
    return total


def _power_on_beads(swimmer: Swimmer, shape: Array, rate: Array, xi: Array) -> Array:
    """Return the power of links that feel each other's flow, from the beads themselves."""
    batch = xi.shape[:-1]
    shapes = np.broadcast_to(shape, (*batch, 2, 3, 3)).reshape(-1, 2, 3, 3)
    turning = apply(shapes, np.broadcast_to(rate, (*batch, 6)).reshape(-1, 2, 3)).reshape(-1, 6)
    motion = np.concatenate([xi.reshape(-1, 6), turning], axis=1)
    found = [inner(m, apply(grand_resistance(swimmer, r[..., 0]), m)) for m, r in zip(motion, shapes, strict=True)]
    return np.reshape(found, batch)
