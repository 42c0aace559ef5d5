"""Octagonal loops: squares of two joints' angles with their corners cut, on which both limbs turn at once.

On a square of primitives one limb waits for the other. On a cut corner both turn, which takes less
time; with the best cuts the swimmer is about half as fast again. The octagon

    q: limb 1 alone, p: the limbs apart in sign, s: limb 2 alone, r: the limbs alike in sign

is centrally symmetric, so it closes whatever its sides are, and round the collinear shape it does not
turn the base. With its centre at (c, -c) the swimmer follows a circle, as with a square (see `loops`).
Angles are rotations of the limbs about the base's z axis; lengths are in units of L.
"""

from __future__ import annotations

import functools

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arctan2, arctan2_of, hypot, hypot_of, matmul, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.swimmer import Swimmer

_OFFSETS = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
"""Offsets of the tabulated loops, in units of the bend limit."""
_LARGEST_RAD = 1.9
"""The largest half side of a loop round the collinear shape, whatever the bend limit [rad]."""
_FIRST_STEP, _LAST_STEP = 0.06, 0.02
"""Steps of the search for the best cuts, over the side: it halves them from the first until they are below the last."""
_CUTS = (0.55, 0.27)
"""The cuts p and r of the first loop, over its side, from which the best are searched."""


def corners(half: float, offset: float, cuts: tuple[float, float]) -> Array:
    """Return the corners of an octagon in the plane of both limbs' angles, anticlockwise [rad]. Shape (8, 2).

    Args:
        half: Half the side of the square.
        offset: Its centre is (offset, -offset).
        cuts: How much of the side the cuts p, of the corners alike in sign, and r take.
    """
    p, r = 2.0 * half * cuts[0], 2.0 * half * cuts[1]
    quarter = np.array([[half, half - p], [half - p, half], [r - half, half], [-half, half - r]])
    return np.asarray(np.concatenate([quarter, -quarter]) + np.array([offset, -offset]))


def yaws(angle: Array) -> Array:
    """Return turns of both limbs about the base's z axis as turns of unrolled limbs. Shape (n, 2) to (n, 6)."""
    out = np.zeros((len(angle), 6))
    out[:, [2, 5]] = angle
    return out


def cycle(corner: Array) -> Array:
    """Return the sides of a loop, once round from its first corner. Shape (n, 2)."""
    return np.asarray(np.roll(corner, -1, axis=0) - corner)


def twist(swimmer: Swimmer, corner: Array) -> Array:
    """Return what a loop does in one cycle, seen from the collinear shape from which both limbs go straight to it.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        corner: The loop's corners [rad]. Shape (n, 2).

    Returns:
        Twist of the cycle's displacement [L, rad]. Shape (6,).
    """
    way = MoveSequence.of_turns(yaws(corner[:1]))
    entry = flow(swimmer, way, accuracy=SEARCHING)
    around = flow(swimmer, MoveSequence.of_turns(yaws(cycle(corner))), way.shapes(COLLINEAR)[-1], SEARCHING)
    return np.asarray(se3.log(se3.normalised(matmul(matmul(entry, around), se3.inverse(entry)))))


def lasts(corner: Array) -> float:
    """Return how long one cycle takes at a joint rate of 1 rad/s [s]. Shape (n, 2) to ()."""
    return float(np.sum(np.max(np.abs(cycle(corner)), axis=1)))


@frozen_dataclass(eq=False)
class Octagons:
    """The quickest loops of one swimmer, over the offset of their centre.

    Attributes:
        offset: Offsets [rad], ascending. Shape (k,).
        half: Half sides of the squares [rad]. Shape (k,).
        cuts: Their cuts p and r over the side. Shape (k, 2).
        advance: Advance in a cycle, forwards where positive [L]. Shape (k,).
        turn: Turn in a cycle [rad]. Shape (k,).
    """

    offset: Array
    half: Array
    cuts: Array
    advance: Array
    turn: Array

    def like(self, advance: float, turn: float) -> tuple[Array, float]:
        """Return the loop that turns as much on its way as another, and how much further it goes.

        Args:
            advance: Advance of the other in a cycle [L].
            turn: Its turn in a cycle [rad].

        Returns:
            Corners in the order they are gone through, shape (8, 2), and the cycles that do as one of the other.
        """
        size = hypot(self.advance, self.turn)
        bearings = arctan2(np.abs(self.turn), np.abs(self.advance))
        bearing = float(np.clip(arctan2_of(abs(turn), abs(advance)), bearings[0], np.max(bearings)))
        stop = int(np.argmax(bearings)) + 1
        offset, half, p, r, goes, ahead, aside = (
            float(np.interp(bearing, bearings[:stop], column[:stop]))
            for column in (self.offset, self.half, *self.cuts.T, size, self.advance, self.turn)
        )
        corner = corners(half, offset, (p, r))
        backwards = ahead * advance < 0.0
        if (aside * turn < 0.0) != backwards:
            corner = -corner  # the mirror image
        if backwards:
            corner = corner[::-1]
        return corner, hypot_of(advance, turn) / goes


@functools.lru_cache(maxsize=64)
def octagons(swimmer: Swimmer) -> Octagons:
    """Return the quickest loops of a scaled swimmer, made once."""
    bend = swimmer.max_bend_rad
    rows = []
    largest, guess = min(bend, _LARGEST_RAD), _CUTS
    for offset in (_OFFSETS * bend).tolist():
        half = min(largest, bend - offset)

        guess = _quickest_cuts(swimmer, half, offset, guess)
        made = twist(swimmer, corners(half, offset, guess))
        rows.append([offset, half, *guess, made[0], made[5]])
    table = np.array(rows)
    table = table[: int(np.argmin(np.append(table[:, 4] * table[0, 4] > 0.0, False)))]  # where it goes one way
    return Octagons(table[:, 0], table[:, 1], table[:, 2:4], table[:, 4], table[:, 5])


def _quickest_cuts(swimmer: Swimmer, half: float, offset: float, guess: tuple[float, float]) -> tuple[float, float]:
    """Return the cuts near some with which a loop goes furthest in its time, by steps along either (pattern search)."""

    def speed(cuts: tuple[float, float]) -> float:
        if min(cuts) < 0.0 or sum(cuts) > 1.0:
            return 0.0
        corner = corners(half, offset, cuts)
        return float(norm(twist(swimmer, corner)[[0, 5]])) / lasts(corner)

    best, step = speed(guess), _FIRST_STEP
    while step > _LAST_STEP:
        tried = [(guess[0] + a * step, guess[1] + b * step) for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        speeds = [speed(cuts) for cuts in tried]
        k = int(np.argmax(speeds))
        if speeds[k] > best:
            guess, best = tried[k], speeds[k]
        else:
            step *= 0.5
    return guess
