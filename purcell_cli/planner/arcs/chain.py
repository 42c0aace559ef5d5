"""Chains: alternating rolls and arcs whose displacement has a closed form, so that phase 2 needs no flow.

A stroke of n cycles has the displacement exp(n L) exp(U), with L and U from the series of `loops`, and
a roll stroke rolls. So the displacement of phase 2, and its derivatives by the bends, asides and rolls,
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

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import apply, arctan2, hypot, inner, matmul, norm
from purcell_cli.geometry.rotations import Array, about_axis, wrapped
from purcell_cli.kernel.linear import least_steps
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.loop_family import Fan
from purcell_cli.planner.arcs.loop_fit import LONGEST_STEP_RAD, fitted
from purcell_cli.planner.arcs.loops import NAME, stroke
from purcell_cli.planner.arcs.roll_stroke import Rolling

_SMALL = 1e-6
"""The step of the difference quotients by bend, aside and roll [rad]."""
_CLOSE = 3e-3
"""Chains that miss their displacement by less than this are compared by cost, others by what they miss [L, rad]."""
_FULL_RAD = 1e-3
"""A loop whose bend is within this of its upper bound is as large as it may be [rad]."""
_FAR_L = 1.0
"""Over distances above this, errors across the way count in proportion to the distance [L]: they act as a heading."""
_FAR_AHEAD_L = 1000.0
"""Over distances above this, errors along the way count in proportion to the distance [L]."""
_THRIFT_RAD = 2.0
"""Step length along the cost gradient in each round, in joint travel [rad]."""
_ROLL_EFFORT = 5.0
"""Weight of a roll in the least step; a bend or aside has 8 times its cycles plus 4. A larger one keeps rolls."""
_LONGER = 0.1
"""The largest part by which the cycles of a chain grow at once, before rounding up."""
_ARRAYS = ("which", "cycles", "mirrored", "backwards", "bend", "aside", "roll")
_MIRROR = np.diag([1.0, -1.0, -1.0, 1.0])
"""Half a turn about x: negating all yaws and pitches conjugates a displacement by it. Shape (4, 4)."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
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
        aside: How much of the bends lies aside. Shape (n, m).
        roll: The roll before each arc, and the last [rad]. Shape (n, m + 1).
    """

    roll_stroke: Rolling
    fans: tuple[Fan, ...]
    which: NDArray[np.int64]
    cycles: Array
    mirrored: NDArray[np.bool_]
    backwards: NDArray[np.bool_]
    bend: Array
    aside: Array
    roll: Array

    def __len__(self) -> int:
        return len(self.which)

    def __getitem__(self, some: NDArray[np.int64]) -> Chains:
        """Return some of the chains, in an order of their own."""
        return dataclasses.replace(self, **{name: getattr(self, name)[some] for name in _ARRAYS})

    def put(self, some: NDArray[np.int64], others: Chains) -> Chains:
        """Return the chains with some of them replaced by as many others."""
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
        return np.concatenate([self.bend, self.aside, self.roll], axis=1)

    def _with(self, x: Array) -> Chains:
        m = self.which.shape[1]
        return dataclasses.replace(self, bend=x[:, :m], aside=x[:, m : 2 * m], roll=x[:, 2 * m :])

    def _bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest bends, asides and rolls; those of empty arcs stay as they are."""
        low, high = self._unknown, self._unknown
        m = self.which.shape[1]
        for k, fan in enumerate(self.fans):
            mine = np.nonzero(self.which == k)
            low[:, :m][mine], high[:, :m][mine] = fan.loops.least_rad, fan.loops.most_rad
            low[:, m : 2 * m][mine], high[:, m : 2 * m][mine] = fan.loops.least_aside, fan.loops.most_aside
        live = np.arange(m + 1) <= np.count_nonzero(self.which >= 0, axis=1)[:, None]
        low[:, 2 * m :][live], high[:, 2 * m :][live] = -np.inf, np.inf
        return low, high

    def costs(self) -> tuple[Array, Array]:
        """Return what the chains cost, rolls included [rad], and that by bends, asides and rolls.

        Returns:
            Costs, shape (n,), and derivatives, shape (n, 3 m + 1).
        """
        steps = np.array([[0.0, 0.0], [_SMALL, 0.0], [0.0, _SMALL]])
        paid = np.zeros((3, *self.which.shape))
        for k, fan in enumerate(self.fans):
            i, j = np.nonzero(self.which == k)
            places = (self.bend[i, j] + steps[:, :1], self.aside[i, j] + steps[:, 1:])
            cycle, ways = (part.reshape(3, -1) for part in fan.loops.costs(*(x.ravel() for x in places)))
            paid[:, i, j] = (self.cycles[i, j] * cycle + ways) / fan.unit
        rolling = self.roll_stroke.travel(np.stack([self.roll, self.roll + _SMALL]))
        slope = np.concatenate([paid[1] - paid[0], paid[2] - paid[0], rolling[1] - rolling[0]], axis=1) / _SMALL
        return paid[0].sum(axis=1) + rolling[0].sum(axis=1), slope

    def _moves(self) -> tuple[Array, Array]:
        """Return the arcs' displacements, and their body twists by bend and aside.

        Returns:
            Displacements, shape (n, m, 4, 4), and twists, shape (n, m, 2, 6).
        """
        cycle, ways = np.zeros((3, *self.which.shape, 6)), np.zeros((3, *self.which.shape, 6))
        for k, fan in enumerate(self.fans):
            i, j = np.nonzero(self.which == k)
            found = fan.loops.at(self.bend[i, j], self.aside[i, j])
            for part, values in ((cycle, found.cycle), (ways, found.ways)):
                part[0, i, j], part[1:, i, j] = values[0], values[0] + _SMALL * values[1:]
        moved = matmul(*se3.exp(np.stack([self.cycles[..., None] * cycle, ways])))
        moved = np.where(self.mirrored[..., None, None], matmul(matmul(_MIRROR, moved), _MIRROR), moved)
        moved = np.where(self.backwards[..., None, None], se3.inverse(moved), moved)
        return moved[0], np.moveaxis(_twist_of(matmul(se3.inverse(moved[0]), moved[1:])) / _SMALL, 0, 2)

    def residuals(self, wanted: Array) -> tuple[Array, Array]:
        """Return log(D^-1 g) and their derivatives by bends, asides and rolls.

        Args:
            wanted: The displacements D. Shape (n, 4, 4).

        Returns:
            Residuals, shape (n, 6), and derivatives, shape (n, 6, 3 m + 1).
        """
        moved, twists = self._moves()
        whole, after = self._put_together(moved)
        carried = se3.adjoint(se3.inverse(after))
        turned = matmul(carried[:, 1::2], np.swapaxes(twists, 2, 3))
        columns = [turned[..., 0], turned[..., 1], carried[:, ::2, :, 3]]
        derivative = np.concatenate(columns, axis=1).swapaxes(1, 2)
        return se3.log(se3.normalised(matmul(se3.inverse(wanted), whole))), derivative

    def displacements(self) -> Array:
        """Return what the chains do to the base. Shape (n, 4, 4)."""
        return self._put_together(self._moves()[0])[0]

    def _put_together(self, moved: Array) -> tuple[Array, Array]:
        """Return the displacements of whole chains, and of what follows each pure roll and each arc.

        Args:
            moved: The displacements of the arcs. Shape (n, m, 4, 4).

        Returns:
            Displacements. Shapes (n, 4, 4) and (n, 2 m + 1, 4, 4).
        """
        n, m = self.which.shape
        rolls = se3.pose(about_axis(0, self.roll), np.zeros((n, m + 1, 3)))
        after = np.empty((n, 2 * m + 1, 4, 4))
        after[:, 2 * m] = np.eye(4)
        pairs = matmul(moved, rolls[:, 1:])
        for k in reversed(range(m)):
            after[:, 2 * k] = matmul(pairs[:, k], after[:, 2 * k + 2])
        after[:, 1::2] = matmul(rolls[:, 1:], after[:, 2::2])
        return matmul(rolls[:, 0], after[:, 0]), after

    def settled(self, wanted: Array, rounds: int) -> tuple[Chains, Array, Array]:
        """Return the chains changed until they make displacements, at little cost.

        Every round takes the least step to the displacement from where the cost alone would lead;
        bends and asides stay within the table, and so within the bend limit.

        Args:
            wanted: The displacements. Shape (n, 4, 4).
            rounds: How many.

        Returns:
            The best chains of all rounds, what they miss by (see `missed`), shape (n,), and their costs, shape (n,).
        """
        low, high = self._bounds()
        effort = 8.0 * (self.cycles + 0.5)
        loose = np.concatenate([effort, effort, np.full_like(self.roll, _ROLL_EFFORT)], axis=1) ** -2.0
        x = best = self._unknown
        off, paid = np.full(len(self), np.inf), np.full(len(self), np.inf)
        for k in range(rounds + 1):
            here = self._with(x)
            residual, columns = here.residuals(wanted)
            cost, slope = here.costs()
            size = missed(residual, wanted)
            better = np.where(np.maximum(size, off) < _CLOSE, cost < paid, size < off)
            best, off, paid = (
                np.where(better[:, None], x, best),
                np.where(better, size, off),
                np.where(better, cost, paid),
            )
            if k < rounds:
                step = least_steps(columns, -residual, -_THRIFT_RAD * loose * slope, loose, low - x, high - x)
                x = x + step * np.minimum(1.0, LONGEST_STEP_RAD / np.maximum(np.abs(step).max(axis=1), 1e-300))[:, None]
        return self._with(best), off, paid

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
            beat, offset = (float(x[0]) for x in loops.sides(self.bend[k, j : j + 1], self.aside[k, j : j + 1]))
            parts = list(zip(stroke(beat, offset, loops.across), (1, int(self.cycles[k, j]), 1), strict=True))
            if self.mirrored[k, j]:
                parts = [(s.with_angles(-s.angle), n) for s, n in parts]
            if self.backwards[k, j]:
                parts = [(s.inverse(), n) for s, n in reversed(parts)]
            out += [Block(2, NAME, s, n, 2.0 * beat) for s, n in parts if n]
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
    found = [fitted(fan, np.abs(every[live][:, 0]), turn[live]) for fan in fans]
    cheapest = np.argmin(np.round([f.cost for f in found], 9), axis=0)
    forced = np.broadcast_to(only[:, None], (n, m))[live]
    chosen = np.where(forced < 0, cheapest, forced)
    which = np.full((n, m), -1)
    which[live] = chosen
    cycles, bend, aside = np.zeros((n, m)), np.zeros((n, m)), np.zeros((n, m))
    for values, name in ((cycles, "cycles"), (bend, "bend"), (aside, "aside")):
        values[live] = np.choose(chosen, [getattr(f, name) for f in found])
    twist = np.zeros((n, m, 6))
    for k, fan in enumerate(fans):
        mine = np.nonzero(which == k)
        once = fan.loops.at(bend[mine], aside[mine])
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
    return Chains(roll_stroke, fans, which, cycles, mirrored, backwards, bend, aside, turns)


def missed(residual: Array, wanted: Array) -> Array:
    """Return by how much displacements are missed [L, rad]; of far ones what lies across by less, for it is a heading.

    Args:
        residual: Twists log(D^-1 g). Shape (n, 6).
        wanted: The displacements D. Shape (n, 4, 4).
    """
    way = norm(wanted[..., :3, 3])
    ahead = apply(np.swapaxes(wanted[:, :3, :3], 1, 2), wanted[:, :3, 3]) / np.maximum(way, 1e-300)[:, None]
    along = inner(ahead, residual[:, :3])
    across = np.abs(residual[:, :3] - along[:, None] * ahead).max(axis=-1)
    parts = [
        np.abs(along) / (1.0 + way / _FAR_AHEAD_L),
        across / (1.0 + way / _FAR_L),
        np.abs(residual[:, 3:]).max(axis=-1),
    ]
    return np.asarray(np.maximum.reduce(parts))


def _twist_of(change: Array) -> Array:
    """Return the twists of small changes g^-1 g'. Shape (..., 4, 4) to (..., 6)."""
    spin = 0.5 * (change[..., :3, :3] - np.swapaxes(change[..., :3, :3], -1, -2))
    return np.concatenate([change[..., :3, 3], spin[..., [2, 0, 1], [1, 2, 0]]], axis=-1)
