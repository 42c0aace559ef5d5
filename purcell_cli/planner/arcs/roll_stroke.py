"""Roll strokes: strokes that roll the swimmer; a large roll takes several.

A table on the flow gives the roll of each amplitude, since the gait's free angles are guesses.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from purcell_cli.gaits.gait import Gait
from purcell_cli.gaits.pure_stroke import guessed
from purcell_cli.geometry.reproducible import arctan2
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.chains import RollTable
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.prepared import kept, words_of

_LARGEST_RAD = 1.6
"""The largest roll of one roll stroke [rad]; larger rolls take several strokes."""
_APART = 12
"""Up to so many roll strokes in a row may change one by one; of more, those between the first and last repeat one."""
_KEPT = 64
"""Strokes that are kept: a chain is asked for its strokes several times."""
_SLIGHT_RAD = 1e-4
"""Rolls by less than this make no stroke: the exact arrival makes up for them [rad]."""
_KNOTS_RAD = np.array(
    [*(0.003, 0.01, 0.02, 0.035, 0.05, 0.07, 0.09, 0.12, 0.15, 0.2, 0.25, 0.3, 0.36, 0.43), *np.linspace(0.5, 1.7, 13)]
)
"""Amplitudes of the tabulated roll strokes [rad], denser where the guesses of the gait's free angles are rough."""
_SMALLER, _LEAST_RAD = 0.8, 1e-6
"""Where even the first amplitude bends limbs beyond their limit, smaller ones are tabulated, each this part of the
next, until one does not, or is below this [rad]."""


class Rolling(Protocol):
    """What rolls between arcs."""

    @property
    def table(self) -> RollTable:
        """Rolls of one stroke up to the largest, and what they travel [rad], as the kernel takes them."""

    def blocks(self, angle: float) -> list[Block]:
        """Return the strokes that roll by an angle [rad]."""


class RollStroke:
    """A stored gait that rolls one scaled swimmer by its amplitude.

    Attributes:
        swimmer: The swimmer.

    Args:
        gait: The gait.
        swimmer: The swimmer, scaled to L = 1.
    """

    def __init__(self, gait: Gait, swimmer: Swimmer) -> None:
        self._gait, self.swimmer = gait, swimmer
        self._known = functools.lru_cache(maxsize=_KEPT)(self._once)
        key = str(swimmer.max_bend_rad), words_of(gait)
        self._rolled, self._amplitude, self._travel = kept("rolls", swimmer, key, self._tabulated)
        self._largest = min(_LARGEST_RAD, float(self._rolled[-1]))

    def _tabulated(self) -> Array:
        """Return rolls, and the amplitudes and the joint travel of their strokes [rad]. Shape (3, k)."""
        limit, knots = self.swimmer.max_bend_rad, _KNOTS_RAD.tolist()
        once = [self._once(a) for a in knots]
        while _bend(once[0]) > limit and knots[0] > _LEAST_RAD:
            knots.insert(0, _SMALLER * knots[0])
            once.insert(0, self._once(knots[0]))
        most = max(int(np.argmax([*(_bend(block) > limit for block in once), True])), 1)
        moves = block_displacements(self.swimmer, once[:most], COLLINEAR, SEARCHING)
        rolled = arctan2(moves[:, 2, 1], moves[:, 1, 1])
        some = slice(int(np.argmax(rolled)) + 1)  # thick limbs roll less by more
        table = np.array([rolled[some], knots[some], [block.joint_travel_rad for block in once[some]]])
        return np.concatenate([np.zeros((3, 1)), table], axis=1)

    @property
    def table(self) -> RollTable:
        """Rolls of one stroke up to the largest, and what they travel [rad], as the kernel takes them."""
        return RollTable(self._rolled, self._travel, self._largest)

    @property
    def primitives_per_radian(self) -> float:
        """How many primitives a roll by a radian takes, by the largest strokes."""
        return len(self._once(float(self._amplitude[-1])).sequence) / self._largest

    def blocks(self, angle: float) -> list[Block]:
        """Return the roll strokes that roll by an angle [rad], as nearly as the table has it."""
        angle = math.remainder(angle, 2.0 * math.pi)
        if abs(angle) < _SLIGHT_RAD:
            return []
        count = math.ceil(abs(angle) / self._largest)
        amplitude = np.interp(abs(angle) / count, self._rolled, self._amplitude)
        once = self._known(math.copysign(float(amplitude), angle))
        if count <= _APART:
            return [once] * count
        return [once, dataclasses.replace(once, cycles=count - 2), once]

    def _once(self, amplitude: float) -> Block:
        return Block(2, self._gait.name, guessed(self._gait, self.swimmer, amplitude).cycle, 1, amplitude)


def rolling(gaits: Mapping[str, Gait]) -> list[Gait]:
    """Return the stored gaits that roll by their amplitude."""
    return [g for g in gaits.values() if g.moves == "roll" and g.amplitude_is_displacement]


def _bend(block: Block) -> float:
    """Return how far a stroke bends the limbs [rad]."""
    return float(np.max(LimbCircles.of(Pieces.of(block.sequence)).largest_bends()[0], initial=0.0))


@functools.lru_cache(maxsize=64)
def roll_stroke(gait: Gait, swimmer: Swimmer) -> RollStroke:
    """Return the roll strokes of a gait for a scaled swimmer, made once."""
    return RollStroke(gait, swimmer)
