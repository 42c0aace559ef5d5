"""The circles that the limbs' axes run along while both limbs turn at constant rates, and how far they bend.

A limb that turns at a constant rate in its own frame turns about an axis that is fixed in the base
frame, u = A omega. So its own axis a = A e_x runs along a circle about u, of which all is known in
closed form. Bend is the angle between a limb's axis and the base's. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arctan2, cos, hypot, inner, sin
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import clearance as kernel
from purcell_cli.mechanics.pieces import Pieces

BEND_SLACK_RAD = 1e-9
"""A bend above its limit by no more than this is rounding."""


def bends(axes: Array) -> Array:
    """Return the angles of limb axes with the base's axis [rad]. Shape (..., 3) to (...)."""
    return arctan2(hypot(axes[..., 1], axes[..., 2]), axes[..., 0])


@frozen_dataclass(eq=False)
class LimbCircles:
    """The circles that both limbs' axes run along on pieces of constant rates.

    At time t of a piece an axis is centre + cos(turn t) cosine + sin(turn t) sine.

    Attributes:
        centre: The part of the axis along the axis it turns about. Shape (n, 2, 3).
        cosine: The part across it at the piece's beginning. Shape (n, 2, 3).
        sine: The same a quarter turn later. Shape (n, 2, 3).
        turn: How fast each limb turns [rad/s]. Shape (n, 2).
        duration: How long the piece lasts [s]. Shape (n,).
    """

    centre: Array
    cosine: Array
    sine: Array
    turn: Array
    duration: Array

    @classmethod
    def of(cls, pieces: Pieces) -> LimbCircles:
        """Return the sweeps of pieces."""
        return cls(*kernel.circles(pieces.shapes, pieces.rates), np.asarray(pieces.durations, dtype=np.float64))

    def __len__(self) -> int:
        return len(self.duration)

    def at(self, piece: NDArray[np.int64], time: Array) -> Array:
        """Return the limbs' axes on some pieces, at times within them [s]. Shapes (m,) to (m, 2, 3)."""
        angle = (self.turn[piece] * time[:, None])[..., None]
        return np.asarray(self.centre[piece] + cos(angle) * self.cosine[piece] + sin(angle) * self.sine[piece])

    @property
    def known(self) -> kernel.Circles:
        """The circles as the kernel takes them."""
        return kernel.Circles(self.centre, self.cosine, self.sine, self.turn)

    @property
    def speed(self) -> Array:
        """How fast the limbs' axes move; that of a limb that only rolls rests [rad/s]. Shape (n, 2)."""
        return np.asarray(self.turn * np.sqrt(inner(self.sine, self.sine)))

    def largest_bends(self) -> tuple[Array, Array]:
        """Return each limb's largest bend on each piece, at any instant of it, and when.

        On its circle an axis is furthest from the base's where its x is least. If the piece ends
        before that point is reached, the largest bend is at the beginning or at the end.

        Returns:
            Bends [rad] and times within the pieces [s]. Shapes (n, 2).
        """
        return kernel.largest_bends(self.known, self.duration)
