"""The swimmer in a plane: its shape is two angles, and the curvature of its connection is three functions of them.

With all limb motion in yaw, or all in pitch, the links stay in one plane of the base. Along a small
closed loop of the two angles the base moves, to leading order, by the integral of the curvature over
the loop's inside; that is why a stroke is drawn over these height functions. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.lie_brackets.curvature import curvature
from purcell_cli.mechanics.swimmer import Swimmer


@frozen_dataclass
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

    What the displacement of a small loop, alpha_1 first, tends to over its area: of the curvature DA(r), minus the
    part of one control of each limb.

    Args:
        swimmer: The swimmer.
        plane: The plane.
        angles: Angles of limb 1 and limb 2 [rad]. Shape (..., 2).

    Returns:
        Along x, sideways [m/rad^2], and the turn [1/rad]. Shape (..., 3).
    """
    shape = about_axis(plane.axis, np.asarray(angles, dtype=np.float64))
    return np.asarray(-curvature(swimmer, shape)[..., list(plane.twist), plane.axis, 3 + plane.axis])
