"""Arcs: strokes that turn the swimmer while they carry it, as a steerable needle.

A square loop of both yaw joints round the collinear shape goes straight. It swims along a circle
when it is repeated with both limbs bent aside, limb 1 by c and limb 2 by -c, the tighter the larger
c is. In the plane of the loop, c moves the square's centre, and offset and beat share the bend
limit. Across that plane, as pitches, a limb's bend is arccos(cos c cos yaw), so both may be larger:
these loops turn by a quarter more per joint travel at a limit of 1 rad, and do not roll; but their
ways in and out are longer. The fan of loops from the best to go straight to the best to turn is
what this module tabulates for a swimmer, at the collinear shape and per joint travel, or whatever
else is to be spent least.

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

_STRAIGHT_RAD = np.linspace(0.8, 1.5, 8)
_ACROSS = np.linspace(0.1, 0.7, 13)
"""Offsets across the plane that are tried for the best to turn, in units of the bend limit."""
_SMALLEST = 0.225
"""The smallest beat of a loop that is offset in its plane, in units of the bend limit."""
_LARGEST_BEND_RAD = 1.5
_KNOTS = 12
_KNOTS_BETWEEN = 4
_WAYS = 0.45
"""With offsets across, the ways in and out go round a quarter of the loop's square, and do so much of what it does."""
_PITCH_1, _YAW_1, _PITCH_2, _YAW_2 = 1, 2, 4, 5
_NEGLIGIBLE_RAD = 1e-9
_ROUND = 0.97
"""Arcs that are tighter than the tightest loop by less than this are taken for it."""

NAME = "arc"
"""Name of the stroke."""


def stroke(beat: float, offset: float, across: bool) -> tuple[PrimitiveSequence, PrimitiveSequence, PrimitiveSequence]:
    """Return the way to a loop's corner, the loop, and the way back [rad].

    With an offset across the plane the way back is not the way there: together they go round a square
    of the side `beat`, the same way round as the loop. In the plane, the way there moves limb 1 half
    way, limb 2, and limb 1 again, which hardly turns the base.

    Args:
        beat: Half the square's side [rad].
        offset: How far limb 1 is bent aside, and limb 2 the other way [rad].
        across: Whether they are bent aside across the loop's plane.
    """
    if across:
        there = [(_PITCH_1, offset), (_PITCH_2, -offset), (_YAW_1, -beat), (_YAW_2, beat)]
        back = [(_YAW_1, beat), (_YAW_2, -beat), (_PITCH_2, offset), (_PITCH_1, -offset)]
    else:
        corner = offset - beat
        there = [(_YAW_1, 0.5 * corner), (_YAW_2, -corner), (_YAW_1, 0.5 * corner)]
        back = [(control, -angle) for control, angle in reversed(there)]
    loop = [(_YAW_1, 2.0 * beat), (_YAW_2, -2.0 * beat), (_YAW_1, -2.0 * beat), (_YAW_2, 2.0 * beat)]
    parts = [PrimitiveSequence.of(part).busy() for part in (there, loop, back)]
    return parts[0], parts[1], parts[2]


def _loops(swimmer: Swimmer, beats: Array, offsets: Array, across: bool, measure: str) -> tuple[Array, Array]:
    """Return what loops do in a cycle, seen at the collinear shape, and what that costs. Shapes (n, 6) and (n,)."""
    blocks: list[Block] = []
    for beat, offset in zip(beats.tolist(), offsets.tolist(), strict=True):
        blocks += [Block(2, NAME, s) for s in stroke(beat, offset, across)]
    moves = block_displacements(swimmer, blocks, COLLINEAR, SEARCHING).reshape(-1, 3, 4, 4)
    twists = (se3.adjoint(moves[:, 0]) @ se3.log(moves[:, 1])[..., None])[..., 0]
    return twists, costs(measure, swimmer, blocks, COLLINEAR)[1::3]


class Fan:
    """The loops of one scaled swimmer, from the best to go straight to the best to turn.

    Attributes:
        beat: Half the sides of the squares [rad]. Shape (k,).
        offset: How far the limbs are bent aside [rad]. Shape (k,).
        price: What a cycle costs [rad]. Shape (k,).
        advance: Advance per cost [L/rad]. Shape (k,).
        turn: Turn per cost. Shape (k,).
        tilt: How far the arc's plane is rolled from the x-y plane [rad]. Shape (k,).

    Costs are joint travel, or another measure in units that make the best straight loop cost its
    joint travel.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        measure: One of `measures.MEASURES`.
        across: Whether the limbs are bent aside across the loops' plane, or in it.
    """

    def __init__(self, swimmer: Swimmer, measure: str, across: bool) -> None:
        bend = min(swimmer.max_bend_rad, _LARGEST_BEND_RAD) if across else swimmer.max_bend_rad
        beats = _STRAIGHT_RAD[bend >= _STRAIGHT_RAD]
        straight = bend
        if len(beats):
            once, paid = _loops(swimmer, beats, 0.0 * beats, across, measure)
            straight = _summit(beats, np.abs(once[:, 0]) / paid)
        beat, offset = _across(swimmer, bend, straight, measure) if across else _aside(bend, straight)
        cycle, price = _loops(swimmer, beat, offset, across, measure)
        price *= 8.0 * beat[0] / price[0]
        twist = cycle / price[:, None]
        turn = np.hypot(twist[:, 4], twist[:, 5])
        some = slice(int(np.argmax(turn)) + 1)
        self.across, self.beat, self.offset, self.price = across, beat[some], offset[some], price[some]
        self.advance, self.turn = twist[some, 0], turn[some]
        self.turn[0] = 0.0
        self.tilt = np.arctan2(-twist[some, 4], twist[some, 5])
        self.tilt[0] = self.tilt[1]
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

    def knot(self, advance: float, turn: float) -> float:
        """Return where in the table the loop that swims an arc is, from 0 on."""
        bearing = math.atan2(abs(turn) / self.tight, abs(advance) / self.straight)
        return float(np.interp(bearing, self._bearing, self._knot))

    def at(self, knot: float, column: Array) -> float:
        """Return the value of a column of the table at a knot."""
        return float(np.interp(knot, np.arange(len(column)), column))


def _aside(bend_rad: float, straight_rad: float) -> tuple[Array, Array]:
    """Return beats and offsets in the plane, at the bend limit from the straight loop's beat on [rad]."""
    beat = np.linspace(straight_rad, _SMALLEST * bend_rad, _KNOTS - _KNOTS_BETWEEN + 1)
    offset = bend_rad - beat
    between = np.linspace(0.0, offset[0], _KNOTS_BETWEEN, endpoint=False)
    between = between[: _KNOTS_BETWEEN if offset[0] > 0.0 else 0]
    return np.concatenate([np.full(len(between), straight_rad), beat]), np.concatenate([between, offset])


def _across(swimmer: Swimmer, bend_rad: float, straight_rad: float, measure: str) -> tuple[Array, Array]:
    """Return beats and offsets across the plane, from the straight loop to the best to turn [rad]."""
    offset = _ACROSS * bend_rad
    once, paid = _loops(swimmer, _largest_beat(bend_rad, offset), offset, True, measure)
    offset = np.linspace(0.0, _summit(offset, np.hypot(once[:, 4], once[:, 5]) / paid), _KNOTS)
    beat = _largest_beat(bend_rad, offset)
    if straight_rad < bend_rad:
        beat = np.minimum(beat, straight_rad + (beat[-1] - straight_rad) * np.linspace(0.0, 1.0, _KNOTS))
    return beat, offset


def _largest_beat(bend_rad: float, offset: Array) -> Array:
    """Return the largest beats that keep a bend limit, beside offsets across the plane [rad]."""
    return np.asarray(np.arccos(np.minimum(math.cos(bend_rad) / np.cos(offset), 1.0)))


def _summit(x: Array, y: Array) -> float:
    """Return where sampled values are largest, by the parabola through the three largest neighbours."""
    k = int(np.argmax(y))
    if not 0 < k < len(x) - 1:
        return float(x[k])
    a, b, _ = np.polyfit(x[k - 1 : k + 2] - x[k], y[k - 1 : k + 2], 2)
    return float(x[k] - 0.5 * b / a)


@functools.lru_cache(maxsize=128)
def fan(swimmer: Swimmer, measure: str, across: bool) -> Fan:
    """Return the loops of a scaled swimmer for a measure, made once."""
    return Fan(swimmer, measure, across)


def arc_blocks(fan: Fan, advance: float, turn: float) -> list[Block]:
    """Return strokes that swim about an arc, from the collinear shape and back to it.

    The arc lies in a plane that is rolled by the loop's tilt from the x-y plane. An arc tighter than
    the tightest loop turns as much, and goes further.

    Args:
        fan: The swimmer's loops.
        advance: How far [L], negative backwards.
        turn: By how much [rad].
    """
    wanted = float(fan.cost(np.array(advance), np.array(turn)))
    if wanted < _NEGLIGIBLE_RAD:
        return []
    knot = fan.knot(advance, turn)
    beat, offset, price, forwards = (fan.at(knot, c) for c in (fan.beat, fan.offset, fan.price, fan.advance))
    whole, ways = wanted / price, _WAYS if fan.across else 0.0
    cycles = max(math.ceil(whole - ways - 1e-9), 0)
    beat *= math.sqrt(whole / (cycles + ways))
    parts = list(zip(stroke(beat, offset, fan.across), (1, cycles, 1), strict=True))
    backwards = forwards * advance < 0.0
    if (turn < 0.0) != backwards:  # rolled half round, it turns the other way
        parts = [(s.with_angles(-s.angle), n) for s, n in parts]
    if backwards:
        parts = [(s.inverse(), n) for s, n in reversed(parts)]
    return [Block(2, NAME, s, n, 2.0 * beat) for s, n in parts if n]
