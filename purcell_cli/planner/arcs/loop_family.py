"""The fan: a swimmer's best loops for arcs, from the one that goes straight to the one that turns most.

A square loop of both yaw joints round the collinear shape goes straight. With the limbs bent aside it
swims along a circle, whose radius falls as the offset grows (see `loops`). Loops with an offset across
their plane turn by a quarter more per joint travel at a limit of 1 rad, and do not roll; but their ways
in and out are longer. Best means per joint travel, or per unit of another objective. Needle steering
prices its arcs by this fan.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.geometry.reproducible import arccos, arctan2, cos, hypot
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.chains import LoopTable
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.loops import Loops, loops

_STRAIGHT_RAD = np.linspace(0.8, 1.5, 8)
"""Half sides that are tried for the best straight loop, as far as the bend limit allows [rad]. Shape (8,)."""
_ACROSS = np.linspace(0.1, 0.6, 11)
"""Offsets across the plane that are tried for the loop that turns most per cost, in units of the bend limit."""
_SMALLEST = 0.225
"""The smallest half side of a loop that is offset in its plane, in units of the bend limit."""
_KNOTS = 12
"""Loops of a fan across the plane, in it at most one more, before those past the largest turn per cost are left out."""
_KNOTS_BETWEEN = 4
"""How many of them, offset in the plane, have the straight loop's half side while the bend limit leaves room."""
_ROUND = 0.97
"""Arcs of at least this part of the tightest loop's radius are swum by it, without going backwards."""


class Fan:
    """The loops of one scaled swimmer, from the best to go straight to the best to turn.

    Attributes:
        loops: The loops.
        bend: Their largest bends, from the best to go straight to the best to turn [rad]. Shape (k,).
        offset_share: How much of the bend is offset. Shape (k,).
        advance: Advance per cost [L/rad]. Shape (k,).
        turn: Turn per cost. Shape (k,).
        straight: The largest advance per cost [L/rad].
        tight: The largest turn per cost.
        unit: What a joint travel of 1 rad of the best straight loop costs.
        centre: Where on the base's axis the point is that swims along circles, its middle where limbs are alike [L].

    Costs are joint travel, or another measure in units that make the best straight loop cost its
    joint travel.

    Args:
        loops: The loops.
    """

    def __init__(self, loops: Loops) -> None:
        self.loops, bend = loops, loops.most_rad
        half_sides = _STRAIGHT_RAD[bend > _STRAIGHT_RAD]
        straight = bend
        if len(half_sides):
            half_sides = np.append(half_sides, bend)
            twist, price = _once(loops, half_sides, 0.0 * half_sides)
            straight = _summit(half_sides, np.abs(twist[:, 0]) / price)
        half_side, offset = _across(loops, bend, straight) if loops.across else _in_plane(bend, straight)
        cycle, price = _once(loops, half_side, offset)
        self.unit = price[0] / (8.0 * half_side[0])
        price = price / self.unit
        twist = cycle / price[:, None]
        self.centre = 0.0 if loops.even else _centre(twist)
        turn = hypot(twist[:, 4], twist[:, 5])
        some = slice(int(np.argmax(turn)) + 1)
        self.advance, self.turn = twist[some, 0], turn[some]
        self.bend, self.offset_share = (part[some] for part in loops.place(half_side, offset))
        self.turn[0] = 0.0
        self.straight, self.tight = float(np.max(np.abs(self.advance))), float(np.max(np.abs(self.turn)))
        self._bearing = arctan2(np.abs(self.turn) / self.tight, np.abs(self.advance) / self.straight)
        order = np.argsort(self._bearing, kind="stable")
        self._bearing, self._knot = self._bearing[order], order.astype(np.float64)
        size = hypot(self.turn / self.tight, self.advance / self.straight)
        self._size = size[order]

    @property
    def reach(self) -> tuple[Array, Array]:
        """Bearings, of turn against advance in what a unit cost makes of either at most, and what goes that way."""
        return self._bearing, self._size

    @property
    def measure(self) -> str:
        """What costs are; see `Loops`."""
        return self.loops.measure

    @property
    def table(self) -> LoopTable:
        """The loops as the kernel takes them."""
        return self.loops.table(self.unit)

    def cost(self, advance: Array, turn: Array) -> Array:
        """Return what arcs cost when their loops repeat often [rad]. Shape (...).

        An arc tighter than the tightest loop is swum forwards and backwards in turn.
        """
        a, b = np.abs(advance) / self.straight, np.abs(turn) / self.tight
        return np.asarray(np.maximum(hypot(a, b) / np.interp(arctan2(b, a), self._bearing, self._size), b))

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

    def knot(self, advance: Array, turn: Array) -> Array:
        """Return where in the table the loops that swim arcs are, from 0 on. Shapes (n,)."""
        bearing = arctan2(np.abs(turn) / self.tight, np.abs(advance) / self.straight)
        return np.interp(bearing, self._bearing, self._knot)

    def at(self, knot: Array, column: Array) -> Array:
        """Return the values of a column of the table at knots. Shapes (n,)."""
        return np.interp(knot, np.arange(len(column)), column)


def _once(loops: Loops, half_side: Array, offset: Array) -> tuple[Array, Array]:
    """Return what loops do in a cycle, seen at the collinear shape, and what that costs. Shapes (n, 6) and (n,)."""
    bend, offset_share = loops.place(half_side, offset)
    return loops.at(bend, offset_share).cycle[0], loops.costs(bend, offset_share)[0]


def _in_plane(bend_rad: float, straight_rad: float) -> tuple[Array, Array]:
    """Return half sides and offsets in the plane, at the bend limit from the straight loop's half side on [rad]."""
    half_side = np.linspace(straight_rad, _SMALLEST * bend_rad, _KNOTS - _KNOTS_BETWEEN + 1)
    offset = bend_rad - half_side
    between = np.linspace(0.0, offset[0], _KNOTS_BETWEEN, endpoint=False)
    between = between[: _KNOTS_BETWEEN if offset[0] > 0.0 else 0]
    return np.concatenate([np.full(len(between), straight_rad), half_side]), np.concatenate([between, offset])


def _across(loops: Loops, bend_rad: float, straight_rad: float) -> tuple[Array, Array]:
    """Return half sides and offsets across the plane, from the straight loop to the best to turn [rad]."""
    offset = _ACROSS * bend_rad
    once, paid = _once(loops, _largest_half_side(bend_rad, offset), offset)
    offset = np.linspace(0.0, _summit(offset, hypot(once[:, 4], once[:, 5]) / paid), _KNOTS)
    half_side = _largest_half_side(bend_rad, offset)
    if straight_rad < bend_rad:
        half_side = np.minimum(half_side, straight_rad + (half_side[-1] - straight_rad) * np.linspace(0.0, 1.0, _KNOTS))
    return half_side, offset


def _largest_half_side(bend_rad: float, offset: Array) -> Array:
    """Return the largest half sides that keep a bend limit, beside offsets across the plane [rad]."""
    return np.asarray(arccos(np.minimum(cos(bend_rad) / cos(offset), 1.0)))


def _summit(x: Array, y: Array) -> float:
    """Return where sampled values are largest, by the parabola through the three largest neighbours."""
    k = int(np.argmax(y))
    if not 0 < k < len(x) - 1:
        return float(x[k])
    before, after = x[k - 1] - x[k], x[k + 1] - x[k]
    slopes = (y[k - 1] - y[k]) / before, (y[k + 1] - y[k]) / after
    a = (slopes[1] - slopes[0]) / (after - before)
    b = slopes[1] - a * after
    return float(x[k] - 0.5 * b / a)


def _centre(twist: Array) -> float:
    """Return the point on the x axis that twists about y and z move along it, as nearly as they do [L].

    At (c, 0, 0) the velocity across the axis is (v_y + c w_z, v_z - c w_y).
    """
    (_, y, z), (_, p, q) = twist[:, :3].T, twist[:, 3:].T
    turning = float(np.sum(p * p + q * q))
    return float(np.sum(z * p - y * q)) / turning if turning > 0.0 else 0.0


@functools.lru_cache(maxsize=128)
def fan(swimmer: Swimmer, measure: str, across: bool) -> Fan:
    """Return the loops of a scaled swimmer for a measure, made once."""
    return Fan(loops(swimmer, measure, across))
