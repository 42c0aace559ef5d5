"""The swimmer in a plane: its shape is two angles, and the curvature of its connection is three functions of them.

With all limb motion in yaw, or all in pitch, the links stay in one plane of the base. Along a small
closed loop of the two angles the base moves, to leading order, by the integral of the curvature over
the loop's inside; that is why a stroke is drawn over these height functions. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli import se3
from purcell_cli.connection import base_to_limb, centre, connection, rate_to_limb, resistance_and_coupling
from purcell_cli.rotations import Array, about_axis, hat
from purcell_cli.swimmer import Swimmer


@dataclasses.dataclass(frozen=True, slots=True)
class Plane:
    """A plane that the swimmer can stay in.

    Attributes:
        joint: What both joints turn by, "yaw" or "pitch".
        axis: The axis they turn about: 2 or 1.
        twist: Where x, the sideways motion and the turn of the base are in a twist.
        names: What these three are called.
    """

    joint: str
    axis: int
    twist: tuple[int, int, int]
    names: tuple[str, str, str]


PLANES = (Plane("yaw", 2, (0, 1, 5), ("x", "y", "yaw")), Plane("pitch", 1, (0, 2, 4), ("x", "z", "pitch")))
"""The plane x-y of the yaw joints, and x-z of the pitch joints."""


def plane_of(shapes: Array, slack: float = 1e-9) -> Plane | None:
    """Return the plane that all of some shapes lie in, or None where they leave both.

    Args:
        shapes: Shapes. Shape (n, 2, 3, 3).
        slack: How far the joint axis may lean [rad].
    """
    for plane in PLANES:
        if np.all(np.abs(np.delete(shapes[..., plane.axis], plane.axis, axis=-1)) <= slack):
            return plane
    return None


def angles_in(plane: Plane, shapes: Array) -> Array:
    """Return both joints' angles in a plane, without jumps along the rows [rad]. Shape (n, 2)."""
    x, y = shapes[..., 0, 0], shapes[..., 1, 0] if plane.axis == 2 else -shapes[..., 2, 0]
    return np.asarray(np.unwrap(np.arctan2(y, x), axis=0))


def planar_curvature(swimmer: Swimmer, plane: Plane, angles: ArrayLike) -> Array:
    """Return the curvature of the planar connection, as a body displacement per area of shape plane.

    With xi = a_1 alpha_1' + a_2 alpha_2' it is d a_2 / d alpha_1 - d a_1 / d alpha_2 + [a_1, a_2]: what the
    displacement of a small loop, alpha_1 first, tends to over its area. The derivative is exact:
    d(P^-1 Q) = P^-1 (dQ - dP P^-1 Q).

    Args:
        swimmer: The swimmer.
        plane: The plane.
        angles: Angles of limb 1 and limb 2 [rad]. Shape (..., 2).

    Returns:
        Along x, sideways [m/rad^2], and the turn [1/rad]. Shape (..., 3).
    """
    alpha, unit = np.asarray(angles, dtype=np.float64), swimmer.scaled()
    shape = about_axis(plane.axis, alpha)
    controls = [plane.axis, 3 + plane.axis]
    p, _ = resistance_and_coupling(unit, shape)
    a = connection(unit, shape)
    slope = [np.linalg.solve(p, _change(unit, plane, shape, limb, a)) for limb in (1, 2)]
    first, second = (-a[..., :, c] for c in controls)
    curl = -slope[0][..., :, controls[1]] + slope[1][..., :, controls[0]]
    out = (curl + se3.bracket(first, second))[..., list(plane.twist)]
    out[..., :2] *= swimmer.length_m
    return np.asarray(out)


def _change(swimmer: Swimmer, plane: Plane, shape: Array, limb: int, a: Array) -> Array:
    """Return dQ - dP A, the derivatives by one limb's angle. Shape (..., 6, 6)."""
    side = 1.0 if limb == 1 else -1.0
    turned = shape[..., limb - 1, :, :]
    turning = turned @ hat(np.eye(3)[plane.axis])
    moving = side * swimmer.limb_half_length_m * turning[..., :, 0]
    b, db = base_to_limb(swimmer, shape, limb), np.zeros((*shape.shape[:-3], 6, 6))
    turning_t = np.swapaxes(turning, -1, -2)
    db[..., :3, :3] = db[..., 3:, 3:] = turning_t
    db[..., :3, 3:] = -turning_t @ hat(centre(swimmer, shape, limb)) - np.swapaxes(turned, -1, -2) @ hat(moving)
    drag = swimmer.drag(limb)
    grown = np.swapaxes(db, -1, -2) @ drag
    dp = grown @ b
    out = -(dp + np.swapaxes(dp, -1, -2)) @ a
    out[..., 3 * limb - 3 : 3 * limb] += grown @ rate_to_limb(swimmer, limb)
    return out
