"""The curvature DA(r) of the local connection form, exact at every shape (appendix A of the paper).

DA(X, Y) = dA(X, Y) - [A(X), A(Y)]: what is left of the base's motion when the limbs go round a small
loop. With xi = -A(r) omega, a loop of sides a along X and b along Y moves the base by -a b DA(X, Y), to leading order;
`lift.flow` has the exact value. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli import se3
from purcell_cli.connection import checked_shape
from purcell_cli.rotations import Array, cross
from purcell_cli.swimmer import Swimmer
from purcell_cli.twist import twist_model


def curvature(swimmer: Swimmer, shape: ArrayLike) -> Array:
    """Return DA(r) on the limbs' own axes: dA(e_i, e_j) - [A e_i, A e_j], antisymmetric in i and j.

    The derivative is `TwistModel.twist_and_change`, in closed form: turning a limb with its rates in the base
    is the derivative along the left-invariant field, up to the limb's rotation.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations (A_1, A_2). Shape (..., 2, 3, 3).

    Returns:
        DA(e_i, e_j) as twists (v, omega), i and j in the order of the controls [m/rad^2, 1/rad].
        Shape (..., 6, 6, 6), the twist's components first.
    """
    shapes = checked_shape(shape)
    r = shapes.reshape(-1, 2, 3, 3)
    n = len(r)
    # Rates of control j in base coordinates: column j of its limb's orientation.
    axes = np.repeat(r[..., 0].transpose(2, 1, 0)[..., None], 6, axis=-1).reshape(3, 2, 6 * n)
    rates = np.zeros((3, 2, n, 6))
    for control in range(6):
        rates[:, control // 3, :, control] = r[:, control // 3, :, control % 3].T
    xi, change = twist_model(swimmer).twist_and_change(axes, rates.reshape(3, 2, 6 * n))
    xi = xi.reshape(6, n, 6).transpose(1, 2, 0)  # (n, j, twist)
    along = np.einsum("tlkns,nlki->nlist", change.reshape(6, 2, 3, n, 6), r)
    along = along.reshape(n, 6, 6, 6)  # (n, i, j, twist): E_i of xi_j
    out = along.swapaxes(1, 2) - along - se3.bracket(xi[:, :, None], xi[:, None])
    # dA(e_i, e_j) also takes A of [e_i, e_j], which xi = -A turns into + xi([e_i, e_j]).
    for limb in range(2):
        part = slice(3 * limb, 3 * limb + 3)
        both = cross(np.eye(3)[:, None], np.eye(3)[None])
        out[:, part, part] += np.einsum("ijk,nkt->nijt", both, xi[:, part])
    out[..., :3] *= swimmer.length_m
    return np.asarray(np.moveaxis(out, -1, 1).reshape(*shapes.shape[:-3], 6, 6, 6))


def loop_twist(swimmer: Swimmer, shape: ArrayLike, first: int, second: int, area: float) -> Array:
    """Return the leading-order motion of the base when two controls turn a limb or two round a small loop.

    The loop: `first` by a, `second` by b, `first` by -a, `second` by -b, with area a b.

    Args:
        swimmer: The swimmer.
        shape: Limb orientations (A_1, A_2) where the loop begins. Shape (..., 2, 3, 3).
        first: A control, 0 to 5.
        second: Another.
        area: The product of the two angles, signed [rad^2].

    Returns:
        The base's twist (v, omega) [m, rad], beside the lift of the limb's own rotation that a loop within one
        limb leaves. Shape (..., 6).
    """
    return np.asarray(-area * curvature(swimmer, shape)[..., first, second])
