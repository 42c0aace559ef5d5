"""The curvature DA(r) of the local connection form, exact at every shape (appendix A of the paper).

DA(X, Y) = dA(X, Y) - [A(X), A(Y)]: what is left of the base's motion when the limbs go round a small
loop. With xi = -A(r) omega, a loop of sides a along X and b along Y moves the base by -a b DA(X, Y), to leading order;
`lift.flow` has the exact value. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.mechanics.base_velocity import base_motion
from purcell_cli.mechanics.connection import checked_shape
from purcell_cli.mechanics.swimmer import Swimmer


def curvature(swimmer: Swimmer, shape: ArrayLike) -> Array:
    """Return DA(r) on the limbs' own axes: dA(e_i, e_j) - [A e_i, A e_j], antisymmetric in i and j.

    The derivative is `base_motion`'s, in closed form: turning a limb with its rates in the base
    is the derivative along the left-invariant field, up to the limb's rotation.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations (A_1, A_2). Shape (..., 2, 3, 3).

    Returns:
        DA(e_i, e_j) as twists (v, omega), i and j in the order of the controls [m/rad^2, 1/rad].
        Shape (..., 6, 6, 6), the twist's components first.
    """
    shapes = checked_shape(shape)
    unit = shapes.reshape(-1, 2, 3, 3)
    xi, _ = twists_and_slopes(swimmer, unit)
    out = -bracket_twists(swimmer, unit)
    # dA(e_i, e_j) also takes A of [e_i, e_j], which xi = -A turns into + xi([e_i, e_j]).
    for limb in range(2):
        part = slice(3 * limb, 3 * limb + 3)
        both = cross(np.eye(3)[:, None], np.eye(3)[None])
        out[:, part, part] += np.einsum("ijk,nkt->nijt", both, xi[:, part])
    out[..., :3] *= swimmer.length_m
    return np.asarray(np.moveaxis(out, -1, 1).reshape(*shapes.shape[:-3], 6, 6, 6))


def bracket_twists(swimmer: Swimmer, shapes: Array) -> Array:
    """Return the base's part of the Lie brackets [f_i, f_j] of the control fields.

    A loop that turns by e about i, by e about j, back about i and back about j moves the base by
    e^2 times this, to leading order, beside what the limbs are left turned by.

    Args:
        swimmer: The swimmer.
        shapes: Shapes. Shape (n, 2, 3, 3).

    Returns:
        Twists by (i, j), in units of L. Shape (n, 6, 6, 6) [L/rad^2, rad/rad^2].
    """
    xi, slopes = twists_and_slopes(swimmer, shapes)
    return np.asarray(slopes - slopes.swapaxes(1, 2) + se3.bracket(xi[:, :, None], xi[:, None]))


def twists_and_slopes(swimmer: Swimmer, shapes: Array) -> tuple[Array, Array]:
    """Return the base's twist for each unit control, xi = -A e_j, and its derivatives along all of them.

    Args:
        swimmer: The swimmer.
        shapes: Shapes. Shape (n, 2, 3, 3).

    Returns:
        Twists by the control, shape (n, 6, 6), and their derivatives by the control that turns the limbs and the
        one of the twist, shape (n, 6, 6, 6), in units of L [L, rad].
    """
    n = len(shapes)
    axes = np.repeat(shapes[:, None, :, :, 0], 6, axis=1)
    rates = np.zeros((n, 6, 2, 3))
    for control in range(6):
        rates[:, control, control // 3] = shapes[:, control // 3, :, control % 3]
    found = base_motion(swimmer, axes.reshape(-1, 2, 3), rates.reshape(-1, 2, 3))
    slopes = np.einsum("nclka,nlki->nlica", found.change.reshape(n, 6, 2, 3, 6), shapes)
    return found.twist.reshape(n, 6, 6), slopes.reshape(n, 6, 6, 6)
