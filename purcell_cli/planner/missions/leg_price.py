"""The price of a leg: about what it costs to swim from one pose to another, for many legs at once.

Needle steering finds the arcs of least cost; what limbs cost at the ends is left out. On random legs of up to 6 L the
price is within some 10 % of the joint travel of the plan that is then made, with a few starts, and 5 % with 96.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import hypot, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.arc_price import ArcPrice, tightest
from purcell_cli.planner.arcs.loop_family import fan
from purcell_cli.planner.arcs.needle_steering import steer

STARTS = 4
"""Starts of needle steering for each leg where many legs are compared."""
_CAREFUL = 96
"""Starts where one leg is looked at."""
_TOGETHER = 16_384
"""Starts that are steered at once: bounds the memory."""
_PER_ARC_RAD = 4.0
"""About what the ways into and out of an arc's loop cost beside its cycles [rad], as plans of the paper's swimmer have
it; so few arcs are preferred to many."""
_EMPTY_RAD = 0.3
"""An arc that costs less is left out of plans [rad]."""


class LegPrice:
    """The price of legs of one swimmer.

    Attributes:
        length_m: The swimmer's L [m].

    Args:
        swimmer: The swimmer; one without ball joints is priced as if it had them.
    """

    def __init__(self, swimmer: Swimmer) -> None:
        unit = dataclasses.replace(swimmer, joints=Swimmer().joints).scaled()
        self._loops = tightest((fan(unit, "travel", True), fan(unit, "travel", False)))
        self._rough = ArcPrice(self._loops)
        self.length_m = swimmer.length_m

    def __call__(self, begin: Array, end: Array, starts: int = STARTS) -> Array:
        """Return the prices of legs between poses [rad].

        Args:
            begin: The base's poses where they begin [m]. Shape (n, 4, 4).
            end: Where they end [m]. Shape (n, 4, 4).
            starts: Starts of needle steering for each.
        """
        wanted = self._scaled(begin, end)
        out = self._rough.of(wanted)
        each = max(_TOGETHER // starts, 1)
        for low in range(0, len(wanted), each):
            found = steer(wanted[low : low + each], self._loops, starts)
            np.minimum.at(out, low + found.displacement, self._costs(found.arc))
        return out

    def _costs(self, arc: Array) -> Array:
        each = self._loops.cost(arc[..., 0], hypot(arc[..., 1], arc[..., 2]))
        return np.asarray(np.sum(each + _PER_ARC_RAD * (each > _EMPTY_RAD), axis=1))

    def between_all(self, begin: Array, end: Array, starts: int = STARTS) -> Array:
        """Return the prices of legs from each of some poses to each of others [rad]. Shapes (n, m)."""
        n, m = len(begin), len(end)
        pairs = np.repeat(begin, m, axis=0), np.tile(end, (n, 1, 1))
        return self(*pairs, starts).reshape(n, m)

    def rolled(self, begin: Array, end: Array) -> Array:
        """Return the end of a leg with the roll at which the cheapest arcs arrive. Shape (4, 4).

        Args:
            begin: The pose where it begins [m]. Shape (4, 4).
            end: Where it ends, whatever its roll [m]. Shape (4, 4).
        """
        found = steer(self._scaled(begin[None], end[None]), self._loops, _CAREFUL)
        if not len(found.roll):
            return end
        best = int(np.argmin(np.round(self._costs(found.arc), 6)))
        back = se3.pose(se3.rotation(np.array([-float(found.roll[best]), 0.0, 0.0])), np.zeros(3))
        return se3.normalised(matmul(end, back))

    def _scaled(self, begin: Array, end: Array) -> Array:
        move = matmul(se3.inverse(begin), end)
        move[:, :3, 3] /= self.length_m
        return se3.normalised(move)
