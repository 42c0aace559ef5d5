"""Estimates the cost of phase 2 by arcs before any arc is known; phases 1 and 3 are chosen by it."""

from __future__ import annotations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.pairs import PriceNumbers, pair_prices
from purcell_cli.planner.arcs.loop_family import Fan

_ASIDE = 8.0
"""Factor of (aside / r) in the squared rotation of a way aside: 4 arcs of an angle f and a radius r go 4 r (1 - cos f)
aside, so they rotate by (8 aside / r)^0.5 in all."""
_FAR_ASIDE = 1.2
"""Ways further aside than this rotate no more, in radii of the tightest loop."""


def tightest(fans: tuple[Fan, ...]) -> Fan:
    """Return the loops that turn most per cost: those that are steered by."""
    return max(fans, key=lambda fan: fan.tight)


@frozen_dataclass(eq=False)
class ArcPrice:
    """The estimated cost of phase 2 by arcs.

    Attributes:
        loops: The loops that arcs are swum by.
    """

    loops: Fan

    @property
    def numbers(self) -> PriceNumbers:
        """The numbers of the estimate."""
        tight, straight = self.loops.tight, self.loops.straight
        return PriceNumbers(
            turn2=1.0, aside=_ASIDE, scale=tight / straight, most=_FAR_ASIDE, root=1.0 / tight, way=1.0 / straight
        )

    def of(self, displacement: Array) -> Array:
        """Return the costs of body displacements [rad]. Shape (n, 4, 4) to (n,)."""
        nothing = np.eye(4)[None], np.zeros(len(displacement)), np.zeros(1)
        return pair_prices(displacement, *nothing, self.numbers, 1)
