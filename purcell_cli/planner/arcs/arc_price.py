"""Estimates the cost of phase 2 by arcs before any arc is known; phases 1 and 3 are chosen by it."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry.reproducible import arccos, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.arcs.loop_family import Fan

_ASIDE = 8.0
"""Factor of (aside / r) in the squared rotation of a way aside: 4 arcs of an angle f and a radius r go 4 r (1 - cos f)
aside, so they rotate by (8 aside / r)^0.5 in all."""
_FAR_ASIDE = 1.2
"""Ways further aside than this rotate no more, in radii of the tightest loop."""


def tightest(fans: tuple[Fan, ...]) -> Fan:
    """Return the loops that turn most per cost: those that are steered by."""
    return max(fans, key=lambda fan: fan.tight)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class ArcPrice:
    """The estimated cost of phase 2 by arcs.

    Attributes:
        loops: The loops that arcs are swum by.
    """

    loops: Fan

    def __call__(self, turn: Array, way: Array, aside: Array) -> Array:
        """Return the costs [rad].

        Args:
            turn: Changes of heading [rad].
            way: Distances [L].
            aside: How much of those goes aside [L].
        """
        radii = np.minimum(aside * self.loops.tight / self.loops.straight, _FAR_ASIDE)
        return np.asarray(np.sqrt(turn**2 + _ASIDE * radii) / self.loops.tight + way / self.loops.straight)

    def of(self, displacement: Array) -> Array:
        """Return the costs of body displacements [rad]. Shape (n, 4, 4) to (n,)."""
        position = displacement[:, :3, 3]
        turn = arccos(np.clip(displacement[:, 0, 0], -1.0, 1.0))
        return self(turn, norm(position), norm(position[:, 1:]))
