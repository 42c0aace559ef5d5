"""A limb's joint as hinges one after another, as robots and servos have them.

The order of a chain names the axes of its hinges from the base outwards: "zyx" is A = Rz(yaw) Ry(pitch) Rx(roll), whose
angles are the Euler angles (psi, theta, phi). Each hinge turns about the axis that the hinges before it have left.
Conventions: `rotations`.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arctan2, hypot, matmul
from purcell_cli.geometry.rotations import Array, about_axis

TURNS = {"x": "roll", "y": "pitch", "z": "yaw"}
"""What a hinge about each axis does, which is its name."""

ORDERS = tuple("".join(axes) for axes in permutations("zyx"))
"""The orders of three hinges that make a ball joint."""

_PARITY = {"xyz": 1.0, "yzx": 1.0, "zxy": 1.0}
"""1 for the orders that are even permutations of x, y, z; the others have -1."""


@frozen_dataclass
class HingeChain:
    """The hinges of one limb.

    Attributes:
        limb: 1 or 2.
        order: The hinges' axes from the base outwards: one to three different letters of x, y and z.
    """

    limb: int
    order: str

    @property
    def names(self) -> tuple[str, ...]:
        """The hinges' names, from the base outwards: limb1_yaw, limb1_pitch, limb1_roll for "zyx"."""
        return tuple(f"limb{self.limb}_{TURNS[axis]}" for axis in self.order)

    def rotation(self, angles: Array) -> Array:
        """Return the limb's orientation in the base. Angles [rad] of shape (..., k) to (..., 3, 3)."""
        out = np.broadcast_to(np.eye(3), (*angles.shape[:-1], 3, 3))
        for k, axis in enumerate(self.order):
            out = matmul(out, about_axis("xyz".index(axis), angles[..., k]))
        return out

    def angles(self, rotation: Array) -> Array:
        """Return the angles of the hinges that turn a limb to an orientation, or as near as their axes allow [rad].

        The outer hinges' are between -pi and pi, the middle one's of three between -pi/2 and pi/2; at these ends of
        its, the outer two share an axis and are ill determined.

        Args:
            rotation: The limb's orientation in the base. Shape (..., 3, 3).

        Returns:
            Angles. Shape (..., k).
        """
        i, j, k = ("xyz".index(axis) for axis in self.order + "".join(a for a in "xyz" if a not in self.order))
        parity = _PARITY.get("".join("xyz"[axis] for axis in (i, j, k)), -1.0)
        r = rotation
        if len(self.order) == 3:
            middle = arctan2(parity * r[..., i, k], hypot(r[..., i, i], r[..., i, j]))
            first = arctan2(-parity * r[..., j, k], r[..., k, k])
            return np.stack([first, middle, arctan2(-parity * r[..., i, j], r[..., i, i])], axis=-1)
        first = arctan2(parity * r[..., k, j], r[..., j, j])
        if len(self.order) == 1:
            return first[..., None]
        return np.stack([first, arctan2(parity * r[..., i, k], r[..., i, i])], axis=-1)
