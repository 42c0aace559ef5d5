"""Cranks: the strokes that roll the swimmer, one after the other where one would be too large."""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.gaits import Gait, guessed
from purcell_cli.rotations import Array, wrapped
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block

_LARGEST_RAD = 1.6
"""The largest roll of one crank."""
_SLIGHT_RAD = 1e-4
"""Rolls by less are left to the finish."""
_KNOTS_RAD = np.array([0.0, 0.003, 0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.75, 1.0, 1.3, _LARGEST_RAD])


class Crank:
    """A stored gait that rolls one scaled swimmer by its amplitude.

    Attributes:
        swimmer: The swimmer.

    Args:
        gait: The gait.
        swimmer: The swimmer, scaled to L = 1.
    """

    def __init__(self, gait: Gait, swimmer: Swimmer) -> None:
        self._gait, self.swimmer = gait, swimmer
        once = [guessed(gait, swimmer, float(a)).cycle.joint_travel_rad for a in _KNOTS_RAD[1:]]
        self._travel = np.array([0.0, *once])

    def travel(self, angle: Array) -> Array:
        """Return about how much joint travel rolls by angles take [rad]. Shape (...)."""
        size = np.abs(wrapped(angle))
        count = np.maximum(np.ceil(size / _LARGEST_RAD), 1.0)
        return np.asarray(count * np.interp(size / count, _KNOTS_RAD, self._travel))

    def blocks(self, angle: float) -> list[Block]:
        """Return the cranks that roll by an angle [rad]."""
        angle = math.remainder(angle, 2.0 * math.pi)
        if abs(angle) < _SLIGHT_RAD:
            return []
        count = math.ceil(abs(angle) / _LARGEST_RAD)
        one = guessed(self._gait, self.swimmer, angle / count)
        return [Block(2, self._gait.name, one.cycle, 1, angle / count)] * count


@functools.lru_cache(maxsize=64)
def crank(gait: Gait, swimmer: Swimmer) -> Crank:
    """Return the cranks of a gait for a scaled swimmer, made once."""
    return Crank(gait, swimmer)
