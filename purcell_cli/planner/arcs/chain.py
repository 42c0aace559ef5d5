"""Chains: alternating rolls and arcs whose displacement has a closed form, so that phase 2 needs no flow.

A stroke of n cycles has the displacement exp(n L) exp(U), with L and U from the series of `loops`, and
a roll stroke rolls. So the displacement of phase 2, and its derivatives by the bends, offset shares and rolls,
take no integration. Newton steps biased along the cost gradient bring many chains at once to the wanted
displacements, up to the error of the series.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.reproducible import arctan2, hypot, norm
from purcell_cli.geometry.rotations import Array, wrapped
from purcell_cli.kernel.chains import Settled, settled
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.loop_family import Fan
from purcell_cli.planner.arcs.loop_fit import fitted
from purcell_cli.planner.arcs.loops import NAME, stroke
from purcell_cli.planner.arcs.roll_stroke import Rolling

_FULL_RAD = 1e-3
"""A loop whose bend is within this of its upper bound is as large as it may be [rad]."""
_ROLL_EFFORT = 5.0
"""Weight of a roll in the least step; a bend or an offset share has 8 times its cycles plus 4. More keeps rolls."""
_LONGER = 0.1
"""The largest part by which the cycles of a chain grow at once, before rounding up."""
_ARRAYS = ("which", "cycles", "mirrored", "backwards", "bend", "offset_share", "roll")


@frozen_dataclass(eq=False)
class Chains:
    """Chains of alternating rolls and arcs that begin and end with a roll; shorter chains are padded with empty arcs.

    Attributes:
        roll_stroke: What rolls.
        fans: The loops to choose from.
        which: The fan of each arc; -1 for an empty one. Shape (n, m).
        cycles: How many cycles each has. Shape (n, m).
        mirrored: Whether it turns the other way: all angles negated. Shape (n, m).
        backwards: Whether it is swum backwards. Shape (n, m).
        bend: The largest bends of the loops [rad]. Shape (n, m).
        offset_share: How much of the bend is offset. Shape (n, m).
        roll: The roll before each arc, and the last [rad]. Shape (n, m + 1).
    """

    roll_stroke: Rolling
    fans: tuple[Fan, ...]
    which: NDArray[np.int64]
    cycles: Array
    mirrored: NDArray[np.bool_]
    backwards: NDArray[np.bool_]
    bend: Array
    offset_share: Array
    roll: Array

    def __len__(self) -> int:
        return len(self.which)

    def __getitem__(self, some: NDArray[np.int64]) -> Chains:
        """Return some of the chains, in an order of their own."""
        return dataclasses.replace(self, **{name: getattr(self, name)[some] for name in _ARRAYS})

    def put(self, some: NDArray[np.int64], others: Chains) -> Chains:
        """Return the chains with some of them, shape (k,), replaced by as many others."""
        out = {name: getattr(self, name).copy() for name in _ARRAYS}
        for name, values in out.items():
            values[some] = getattr(others, name)
        return dataclasses.replace(self, **out)

    def arcs(self, k: int) -> int:
        """Return how many arcs one of the chains has."""
        return int(np.count_nonzero(self.which[k] >= 0))

    def idle(self, k: int) -> bool:
        """Return whether one of the chains does nothing."""
        return self.arcs(k) == 0 and not self.roll_stroke.blocks(float(self.roll[k, 0]))

    @property
    def _unknown(self) -> Array:
        return np.concatenate([self.bend, self.offset_share, self.roll], axis=1)

    def _with(self, x: Array) -> Chains:
        m = self.which.shape[1]
        return dataclasses.replace(self, bend=x[:, :m], offset_share=x[:, m : 2 * m], roll=x[:, 2 * m :])

    def _bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest bends, offset shares and rolls; those of empty arcs stay as they are."""
        low, high = self._unknown, self._unknown
        m = self.which.shape[1]
        for k, fan in enumerate(self.fans):
            mine = np.nonzero(self.which == k)
            low[:, :m][mine], high[:, :m][mine] = fan.loops.least_rad, fan.loops.most_rad
            low[:, m : 2 * m][mine], high[:, m : 2 * m][mine] = (
                fan.loops.least_offset_share,
                fan.loops.most_offset_share,
            )
        live = np.arange(m + 1) <= np.count_nonzero(self.which >= 0, axis=1)[:, None]
        low[:, 2 * m :][live], high[:, 2 * m :][live] = -np.inf, np.inf
        return low, high

    def costs(self) -> tuple[Array, Array]:
        """Return what the chains cost, rolls included [rad], and that by bends, offset shares and rolls.

        Returns:
            Costs, shape (n,), and derivatives, shape (n, 3 m + 1).
        """
        found = self._settled(np.broadcast_to(np.eye(4), (len(self), 4, 4)), 0)
        return found.cost, found.slope

    def residuals(self, wanted: Array) -> tuple[Array, Array]:
        """Return log(D^-1 g) and their derivatives by bends, offset shares and rolls.

        Args:
            wanted: The displacements D. Shape (n, 4, 4).

        Returns:
            Residuals, shape (n, 6), and derivatives, shape (n, 6, 3 m + 1).
        """
        found = self._settled(wanted, 0)
        return found.residual, found.derivative

    def displacements(self) -> Array:
        """Return what the chains do to the base. Shape (n, 4, 4)."""
        return self._settled(np.broadcast_to(np.eye(4), (len(self), 4, 4)), 0).displacement

    def _settled(self, wanted: Array, rounds: int) -> Settled:
        """Return what the kernel finds; see `settled`."""
        low, high = self._bounds()
        effort = 8.0 * (self.cycles + 0.5)
        efforts = np.concatenate([effort, effort, np.full_like(self.roll, _ROLL_EFFORT)], axis=1)
        loose = 1.0 / (efforts * efforts)  # numpy's powers depend on the processor
        kinds = [fan.table for fan in self.fans]
        chains = self.which, self.cycles, self.mirrored, self.backwards, self._unknown
        return settled(kinds, self.roll_stroke.table, self.fans[0].measure, *chains, wanted, low, high, loose, rounds)

    def settled(self, wanted: Array, rounds: int) -> tuple[Chains, Array, Array]:
        """Return the chains changed until they make displacements, at little cost.

        Every round takes the least step to the displacement from where the cost alone would lead;
        bends and offset shares stay within the table, and so within the bend limit.

        Args:
            wanted: The displacements. Shape (n, 4, 4).
            rounds: How many.

        Returns:
            The best chains of all rounds, what they miss by, of far displacements what lies across by less, for it is a
            heading, shape (n,), and their costs, shape (n,).
        """
        found = self._settled(wanted, rounds)
        return self._with(found.unknown), found.off, found.paid

    def short(self, wanted: Array) -> Array:
        """Return by how much less far than displacements the chains go [L]. Shapes (n, 4, 4) to (n,)."""
        way, gone = (norm(g[:, :3, 3]) for g in (wanted, self.displacements()))
        return np.asarray(np.maximum(way - gone, 0.0))

    def longer(self, wanted: Array, least: float = 0.0) -> Chains:
        """Return the chains with more cycles of every loop that is as large as it may be: as many as are wanting.

        Args:
            wanted: The displacements. Shape (n, 4, 4).
            least: The least part by which cycles grow, for chains that do not turn enough.
        """
        _, high = self._bounds()
        full = (self.which >= 0) & (self.bend > high[:, : self.which.shape[1]] - _FULL_RAD)
        way = norm(wanted[:, :3, 3])
        share = np.minimum(self.short(wanted) / np.maximum(way, 1e-300), _LONGER)
        more = np.maximum(np.ceil(np.maximum(share, least)[:, None] * self.cycles), 1.0)
        return dataclasses.replace(self, cycles=self.cycles + full * more)

    def shorter(self) -> tuple[Chains, NDArray[np.int64]]:
        """Return the chains with one cycle fewer of one of their loops, as large as may be, and of which each is."""
        _, high = self._bounds()
        k, j = np.nonzero((self.which >= 0) & (self.cycles >= 1.0))
        fewer, row = self[k], np.arange(len(k))
        cycles, bend = fewer.cycles.copy(), fewer.bend.copy()
        grown = bend[row, j] * np.sqrt(cycles[row, j] / np.maximum(cycles[row, j] - 1.0, 0.5))
        cycles[row, j] -= 1.0
        bend[row, j] = np.minimum(grown, high[k, j])
        return dataclasses.replace(fewer, cycles=cycles, bend=bend), k

    def blocks(self, k: int) -> list[Block]:
        """Return the strokes of one of the chains, from the collinear shape and back to it."""
        out: list[Block] = []
        for j in range(self.arcs(k)):
            out += self.roll_stroke.blocks(float(self.roll[k, j]))
            loops = self.fans[int(self.which[k, j])].loops
            half_side, offset = (
                float(x[0]) for x in loops.sides(self.bend[k, j : j + 1], self.offset_share[k, j : j + 1])
            )
            parts = list(zip(stroke(half_side, offset, loops.across), (1, int(self.cycles[k, j]), 1), strict=True))
            if self.mirrored[k, j]:
                parts = [(s.with_angles(-s.angle), n) for s, n in parts]
            if self.backwards[k, j]:
                parts = [(s.inverse(), n) for s, n in reversed(parts)]
            out += [Block(2, NAME, s, n, 2.0 * half_side) for s, n in parts if n]
        return [*out, *self.roll_stroke.blocks(float(self.roll[k, self.arcs(k)]))]


def linked(
    roll_stroke: Rolling, fans: tuple[Fan, ...], arcs: Sequence[Array], roll: Array, only: NDArray[np.int64]
) -> Chains:
    """Return chains of loops that swim arcs, with the rolls that turn the loops into their planes.

    Never more than a quarter turn lies between: a loop whose angles are negated turns the other way.

    Args:
        roll_stroke: What rolls.
        fans: The loops to choose from.
        arcs: For each chain advances [L] and turns about y and z [rad]. Each of shape (m, 3).
        roll: The last roll of each chain, with the rolls of its arcs taken off [rad]. Shape (n,).
        only: The fan that a chain's loops are from; -1 for the cheapest at every arc. Shape (n,).
    """
    n, m = len(arcs), max([len(arc) for arc in arcs], default=0)
    every = np.zeros((n, m, 3))
    live = np.arange(m) < np.array([len(arc) for arc in arcs])[:, None]
    every[live] = np.concatenate([np.empty((0, 3)), *arcs])
    turn = hypot(every[..., 1], every[..., 2])
    wanted = np.stack([np.abs(every[live][:, 0]), turn[live]], axis=1)
    first, same = distinct(wanted)  # many chains share their arcs
    found = [fitted(fan, *wanted[first].T) for fan in fans]
    cheapest = np.argmin(np.round([f.cost for f in found], 9), axis=0)[same]
    forced = np.broadcast_to(only[:, None], (n, m))[live]
    chosen = np.where(forced < 0, cheapest, forced)
    which = np.full((n, m), -1)
    which[live] = chosen
    cycles, bend, offset_share = np.zeros((n, m)), np.zeros((n, m)), np.zeros((n, m))
    for values, name in ((cycles, "cycles"), (bend, "bend"), (offset_share, "offset_share")):
        values[live] = np.choose(chosen, [getattr(f, name)[same] for f in found])
    twist = np.zeros((n, m, 6))
    for k, fan in enumerate(fans):
        mine = np.nonzero(which == k)
        once = fan.loops.at(bend[mine], offset_share[mine])
        twist[mine] = cycles[mine][:, None] * once.cycle[0] + once.ways[0]
    backwards = twist[..., 0] * every[..., 0] < 0.0
    plane = arctan2(-every[..., 1], every[..., 2]) - arctan2(-twist[..., 4], twist[..., 5])
    plane = plane - np.where(backwards, math.pi, 0.0)
    turns, mirrored, before = np.zeros((n, m + 1)), np.zeros((n, m), dtype=bool), np.zeros(n)
    for k in range(m):
        bent = live[:, k] & (turn[:, k] > 0.0)
        change = np.where(bent, wrapped(plane[:, k] - before), 0.0)
        mirrored[:, k] = np.abs(change) > 0.5 * math.pi
        turns[:, k] = np.where(mirrored[:, k], wrapped(change + math.pi), change)
        before = before + turns[:, k]
    turns[np.arange(n), np.count_nonzero(live, axis=1)] = wrapped(roll - before)
    return Chains(roll_stroke, fans, which, cycles, mirrored, backwards, bend, offset_share, turns)
