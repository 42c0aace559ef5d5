"""The ranges of joint angles while a motion is refined, and the room that angles leave in them."""

from __future__ import annotations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joints import ANGLES
from purcell_cli.mechanics.swimmer import Swimmer

ACTIVE_RAD = 0.35
"""Joints within this of an end of their range are constraints [rad]."""
_MARGIN_RAD = 1e-7
"""Margin inside joints' ranges: a hundred times what the last steps may change [rad]."""
_AT_KNOWN_RAD = 1e-6
"""An angle this near the start's, the goal's or that between the phases is held to the range itself [rad]."""


@frozen_dataclass(eq=False)
class JointRange:
    """The range of one joint angle.

    A range is kept with a margin, but where the start, the goal or the shape between the phases is nearer its end.

    Attributes:
        limb: Which limb's, 0 or 1.
        axis: Which axis of the limb the angle turns about: z, y or x, as 2, 1 or 0.
        known: The angle at the start, the goal and the shape between the phases [rad]. Shape (3,).
        low: The range's end below [rad].
        high: The range's end above [rad].
    """

    limb: int
    axis: int
    known: Array
    low: float
    high: float

    def rooms(self, angle: Array) -> tuple[tuple[Array, float], tuple[Array, float]]:
        """Return the room that angles [rad] leave at either end, shape (n,), and its slope by them, 1 or -1."""
        at_known = np.min(np.abs(angle[:, None] - self.known), axis=1) < _AT_KNOWN_RAD
        inside = np.where(at_known, 0.0, _MARGIN_RAD)
        return (angle - self.low - inside, 1.0), (self.high - inside - angle, -1.0)


def joint_ranges(swimmer: Swimmer, known: tuple[Array, Array, Array]) -> list[JointRange]:
    """Return the ranges of all joint angles that have one.

    Args:
        swimmer: The swimmer.
        known: The shapes at the start and the goal and between the phases. Each of shape (2, 3, 3).
    """
    out = []
    for limb, joint in enumerate(swimmer.joints):
        for k, name in enumerate(ANGLES):
            if name in joint.angles and joint.range_deg(name) is not None:
                angles = np.array([joint.read(shape[limb])[k] for shape in known])
                out.append(JointRange(limb, 2 - k, angles, *joint.range_rad(name)))
    return out
