"""Arcs: strokes that turn the swimmer while they carry it, as a steerable needle.

A square loop of both yaw joints, its centre moved off the collinear shape along (c, -c), swims along
a circle when it is repeated. The larger the offset the tighter the circle, and the smaller the
square that still keeps the bend limit. Among them are the best loop to go straight and the best to
turn; the fan of loops between those two is what this module tabulates for a swimmer, at the
collinear shape and per joint travel, or whatever else is to be spent least.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli import se3
from purcell_cli.connection import COLLINEAR
from purcell_cli.lift import SEARCHING
from purcell_cli.planner.measures import costs
from purcell_cli.primitives import PrimitiveSequence
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block, block_displacements

_STRAIGHT_SIDES = np.linspace(1.6, 3.0, 8)
_KNOTS = 9
_BETWEEN = 4
_SMALLEST = 0.45
"""The smallest square of the fan, in units of the bend limit."""
_YAW_1, _YAW_2 = 2, 5
_NEGLIGIBLE_RAD = 1e-9
_ROUND = 0.97
"""Arcs that are tighter than the tightest loop by less than this are taken for it."""

NAME = "arc"
"""Name of the stroke."""


def loop_and_approach(side: float, offset: float) -> tuple[PrimitiveSequence, PrimitiveSequence]:
    """Return the square loop with a side and an offset of its centre, and the way to its inner corner [rad].

    The way there moves limb 1 half way, limb 2, and limb 1 again, which hardly turns the base.
    """
    corner = offset - 0.5 * side
    loop = PrimitiveSequence.of([(_YAW_1, side), (_YAW_2, -side), (_YAW_1, -side), (_YAW_2, side)])
    return loop, PrimitiveSequence.of([(_YAW_1, 0.5 * corner), (_YAW_2, -corner), (_YAW_1, 0.5 * corner)])


def _loops(swimmer: Swimmer, sides: Array, offsets: Array, measure: str) -> tuple[Array, Array]:
    """Return what loops do in a cycle, seen at the collinear shape, and what that costs. Shapes (n, 6) and (n,)."""
    blocks: list[Block] = []
    for side, offset in zip(sides.tolist(), offsets.tolist(), strict=True):
        loop, approach = loop_and_approach(side, offset)
        blocks += [Block(2, NAME, s) for s in (approach, loop, approach.inverse())]
    entry, cycle = np.moveaxis(block_displacements(swimmer, blocks, COLLINEAR, SEARCHING).reshape(-1, 3, 4, 4), 1, 0)[
        :2
    ]
    twists = (se3.adjoint(entry) @ se3.log(cycle)[..., None])[..., 0]
    return twists, costs(measure, swimmer, blocks, COLLINEAR)[1::3]


class Fan:
    """The loops of one scaled swimmer, from the best to go straight to the best to turn.

    Attributes:
        side: Sides of the squares [rad]. Shape (k,).
        offset: Offsets of their centres [rad]. Shape (k,).
        price: What a cycle costs [rad]. Shape (k,).
        advance: Advance per cost [L/rad]. Shape (k,).
        turn: Turn per cost. Shape (k,).

    Costs are joint travel, or another measure in units that make the best straight loop cost its
    joint travel.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        measure: One of `measures.MEASURES`.
    """

    def __init__(self, swimmer: Swimmer, measure: str) -> None:
        bend = swimmer.max_bend_rad
        sides = _STRAIGHT_SIDES[2.0 * bend >= _STRAIGHT_SIDES]
        straight = 2.0 * bend
        if len(sides):
            once, paid = _loops(swimmer, sides, 0.0 * sides, measure)
            straight = _summit(sides, np.abs(once[:, 0]) / paid)
        side = np.linspace(straight, _SMALLEST * bend, _KNOTS)
        offset = bend - 0.5 * side
        between = np.linspace(0.0, offset[0], _BETWEEN, endpoint=False)[: _BETWEEN if offset[0] > 0.0 else 0]
        side, offset = np.concatenate([np.full(len(between), straight), side]), np.concatenate([between, offset])
        cycle, price = _loops(swimmer, side, offset, measure)
        price *= 4.0 * side[0] / price[0]
        twist = cycle / price[:, None]
        most = int(np.argmax(np.abs(twist[:, 5])))
        self.side, self.offset, self.price = side[: most + 1], offset[: most + 1], price[: most + 1]
        self.advance, self.turn = twist[: most + 1, 0], twist[: most + 1, 5]
        self.straight, self.tight = float(np.max(np.abs(self.advance))), float(np.max(np.abs(self.turn)))
        self._bearing = np.arctan2(np.abs(self.turn) / self.tight, np.abs(self.advance) / self.straight)
        order = np.argsort(self._bearing, kind="stable")
        self._bearing, self._knot = self._bearing[order], order.astype(np.float64)
        size = np.hypot(self.turn / self.tight, self.advance / self.straight)
        self._size = size[order]

    def cost(self, advance: Array, turn: Array) -> Array:
        """Return what arcs cost when their loops repeat often [rad]. Shape (...).

        An arc tighter than the tightest loop is swum forwards and backwards in turn.
        """
        a, b = np.abs(advance) / self.straight, np.abs(turn) / self.tight
        return np.asarray(np.maximum(np.hypot(a, b) / np.interp(np.arctan2(b, a), self._bearing, self._size), b))

    def ways(self, advance: float, turn: float) -> list[tuple[float, float]]:
        """Return the arc as advances and turns that loops can make [L, rad].

        One tighter than the tightest loop is swum half its turn forwards and half backwards, in
        three parts, so that to second order it stays in its place.
        """
        reach = abs(turn * self.advance[-1] / self.turn[-1])
        if abs(advance) >= _ROUND * reach:
            return [(advance, turn)]
        way = math.copysign(reach, advance)
        share = 0.5 * (1.0 + abs(advance) / reach)
        outer = (0.5 * share * way, 0.5 * share * turn)
        return [outer, (-(1.0 - share) * way, (1.0 - share) * turn), outer]

    def loop(self, advance: float, turn: float) -> tuple[float, ...]:
        """Return side, offset and cost of the loop that swims an arc [rad], and its advance and turn per cost."""
        bearing = math.atan2(abs(turn) / self.tight, abs(advance) / self.straight)
        knot = np.interp(bearing, self._bearing, self._knot)
        knots = np.arange(len(self.side))
        columns = (self.side, self.offset, self.price, self.advance, self.turn)
        return tuple(float(np.interp(knot, knots, c)) for c in columns)


def _summit(x: Array, y: Array) -> float:
    """Return where sampled values are largest, by the parabola through the three largest neighbours."""
    k = int(np.argmax(y))
    if not 0 < k < len(x) - 1:
        return float(x[k])
    a, b, _ = np.polyfit(x[k - 1 : k + 2] - x[k], y[k - 1 : k + 2], 2)
    return float(x[k] - 0.5 * b / a)


@functools.lru_cache(maxsize=64)
def fan(swimmer: Swimmer, measure: str) -> Fan:
    """Return the loops of a scaled swimmer for a measure, made once."""
    return Fan(swimmer, measure)


def arc_blocks(fan: Fan, advance: float, turn: float) -> list[Block]:
    """Return strokes that swim about an arc in the x-y plane, from the collinear shape and back to it.

    An arc tighter than the tightest loop turns as much, and goes further.

    Args:
        fan: The swimmer's loops.
        advance: How far [L], negative backwards.
        turn: By how much [rad].
    """
    wanted = float(fan.cost(np.array(advance), np.array(turn)))
    if wanted < _NEGLIGIBLE_RAD:
        return []
    side, offset, price, per_advance, per_turn = fan.loop(advance, turn)
    cycles = max(math.ceil(wanted / price - 1e-9), 1)
    side *= math.sqrt(wanted / (price * cycles))
    loop, approach = loop_and_approach(side, offset)
    forwards = per_advance * advance >= 0.0
    mirrored = (per_turn * turn < 0.0) == forwards
    if mirrored:
        loop, approach = loop.with_angles(-loop.angle), approach.with_angles(-approach.angle)
    if not forwards:
        loop = loop.inverse()
    parts = [(approach, 1), (loop, cycles), (approach.inverse(), 1)]
    return [Block(2, NAME, s, n, side) for s, n in parts if np.any(s.angle)]
