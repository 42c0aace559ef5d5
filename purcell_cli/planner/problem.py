"""The input of every generator of candidates: the query in units of L, and the phases 1 and 3, computed once."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.arc_price import ArcPrice, tightest
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.limbs.interleaving import interleaved
from purcell_cli.planner.limbs.pairs import INTERLEAVED_FROM, LimbPairs, OuterPhases, best_pairs, with_shape_loops
from purcell_cli.planner.limbs.shape_loops import ShapeLoops, shape_loops
from purcell_cli.planner.limbs.straightening import straightenings


@frozen_dataclass(slots=False, eq=False)
class Problem:
    """A wanted displacement between two shapes, and the objective.

    Attributes:
        swimmer: The swimmer, scaled to L = 1.
        start: Shape at the beginning. Shape (2, 3, 3).
        goal: Shape at the end. Shape (2, 3, 3).
        wanted: Body displacement, in units of L. Shape (4, 4).
        gaits: The stored gaits.
        objective: One of `objectives.MEASURES`.
        clearance: How far the limbs stay apart in phases 1 and 3, in units of L.
    """

    swimmer: Swimmer
    start: Array
    goal: Array
    wanted: Array
    gaits: Mapping[str, Gait]
    objective: str = "travel"
    clearance: float = 0.0
    _pairs: dict[Breadth, LimbPairs] = dataclasses.field(init=False, repr=False, default_factory=dict)
    _ways: dict[int, OuterPhases] = dataclasses.field(init=False, repr=False, default_factory=dict)

    @functools.cached_property
    def fans(self) -> tuple[Fan, Fan]:
        """The swimmer's loops for arcs: bent aside across their plane, and in it."""
        return fan(self.swimmer, self.objective, True), fan(self.swimmer, self.objective, False)

    @functools.cached_property
    def one_by_one(self) -> OuterPhases:
        """All ways to straighten the limbs of the start and of the goal, one limb after the other."""
        return OuterPhases(*straightenings(self.swimmer, (self.start, self.goal), self.clearance))

    @functools.cached_property
    def shape_loops(self) -> list[ShapeLoops]:
        """Closed paths of both limbs round the shapes of the start and of the goal."""
        return shape_loops(self.swimmer, (self.start, self.goal), self.clearance)

    def ways(self, orders: int) -> OuterPhases:
        """Return ways to straighten the limbs, with so many of the most promising interleaved."""
        if orders not in self._ways:
            few = self.one_by_one.best(self.wanted, ArcPrice(tightest(self.fans)).numbers, INTERLEAVED_FROM)
            both = few.first, few.last
            self._ways[orders] = OuterPhases(
                *interleaved(self.swimmer, (self.start, self.goal), both, orders, self.clearance)
            )
        return self._ways[orders]

    def pairs(self, breadth: Breadth) -> LimbPairs:
        """Return the pairs of ways in and out that promise least with a phase 2 by arcs; worked out once a breadth."""
        if breadth not in self._pairs:
            self._pairs[breadth] = self._steered_pairs(breadth)
        return self._pairs[breadth]

    def promised(self, breadth: Breadth) -> float:
        """Return about what the cheapest motion by arcs spends, before any arc is known."""
        pairs = self.pairs(breadth)
        return float(np.min(ArcPrice(tightest(self.fans)).of(pairs.missing) + pairs.joint_travel_rad))

    def _steered_pairs(self, breadth: Breadth) -> LimbPairs:
        price = ArcPrice(tightest(self.fans)).numbers
        outer = with_shape_loops(self.ways(breadth.orders), self.shape_loops, self.wanted, price)
        pairs = best_pairs(outer, self.wanted, price, breadth.pairs)
        return pairs.checked(self.swimmer, (self.start, self.goal), self.wanted)
