"""Quarter rolls: a query and its plan with limbs rolled by quarter turns, which changes no flow.

A limb is symmetric about its axis. Seen in a frame rolled by a quarter turn its pitch is a yaw and its yaw a
pitch; the base moves the same. So limbs may be straight at any quarter turn of roll instead of none: a roll
that start and goal share need not be undone and made again, but for 45 degrees at the most.

Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arctan2
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.limbs.limb_rotations import least_travel

_GAIN_RAD = 0.05
"""Limbs are rolled where that saves more joint travel in phases 1 and 3 than this; phase 2 may lose less [rad]."""


def quarter_turns(count: int) -> Array:
    """Return the rotation about x by quarter turns, exactly. Shape (3, 3)."""
    cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[count % 4]
    return np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])


@frozen_dataclass
class QuarterRolls:
    """By how many quarter turns limbs 1 and 2 are rolled where they are straight.

    Attributes:
        turns: Quarter turns of each limb, 0 to 3.
    """

    turns: tuple[int, int] = (0, 0)

    @classmethod
    def least(cls, start: Configuration, goal: Configuration) -> QuarterRolls:
        """Return those at which the start's limbs are straightened, and the goal's bent, by least joint travel."""
        return cls((_least(start.shape[0], goal.shape[0]), _least(start.shape[1], goal.shape[1])))

    @classmethod
    def of_straight(cls, shape: Array) -> QuarterRolls:
        """Return those of straight limbs. Shape (2, 3, 3)."""
        quarters = (2.0 / np.pi) * arctan2(shape[:, 2, 1] - shape[:, 1, 2], shape[:, 1, 1] + shape[:, 2, 2])
        first, second = (round(float(one)) % 4 for one in quarters)
        return cls((first, second))

    def seen(self, configuration: Configuration) -> Configuration:
        """Return a configuration as if limbs rolled so were not rolled."""
        if not any(self.turns):
            return configuration
        back = [quarter_turns(-n) for n in self.turns]
        shape = np.stack([_columns(limb, turn) for limb, turn in zip(configuration.shape, back, strict=True)])
        return dataclasses.replace(configuration, shape=shape)

    def played(self, plan: Plan, start: Configuration, goal: Configuration) -> Plan:
        """Return a plan for what is seen as it is played between a start and a goal."""
        if not any(self.turns):
            return plan
        return dataclasses.replace(plan, start=start, goal=goal, blocks=self._turned(plan.blocks))

    def unplayed(self, blocks: Sequence[Block]) -> tuple[Block, ...]:
        """Return strokes as they are seen: the inverse of what `played` does with them."""
        if not any(self.turns):
            return tuple(blocks)
        first, second = self.turns
        return QuarterRolls((-first % 4, -second % 4))._turned(blocks)

    def _turned(self, blocks: Sequence[Block]) -> tuple[Block, ...]:
        axes = self._axes()
        return tuple(dataclasses.replace(b, sequence=_turned(b.sequence, *axes)) for b in blocks)

    def _axes(self) -> tuple[NDArray[np.int64], Array]:
        """Return which control each control is in the limbs' own frames, and with which sign. Shapes (6,)."""
        control, sign = np.arange(6), np.ones(6)
        for (limb, turns), axis in itertools.product(enumerate(self.turns), range(3)):
            own = quarter_turns(-turns)[:, axis]
            at = int(np.argmax(np.abs(own)))
            control[3 * limb + axis], sign[3 * limb + axis] = 3 * limb + at, own[at]
        return control, sign


def _turned(sequence: ControlSequence, control: NDArray[np.int64], sign: Array) -> ControlSequence:
    """Return controls about the axes of the rolled limbs' own frames; see `QuarterRolls._axes`."""
    if isinstance(sequence, PrimitiveSequence):
        return PrimitiveSequence(control[sequence.control], sign[sequence.control] * sequence.angle)
    moves = cast(MoveSequence, sequence)
    rate = np.empty_like(moves.rate)
    rate[:, control] = sign * moves.rate
    return MoveSequence(rate, moves.duration)


def _least(start: Array, goal: Array) -> int:
    """Return the quarter turns at which a limb's two rotations take least joint travel; none if all is the same."""
    if np.array_equal(start, np.eye(3)) or np.array_equal(goal, np.eye(3)):
        return 0
    seen = [[_columns(shape, quarter_turns(-n)).T for shape in (start, goal)] for n in range(4)]
    travel = least_travel(np.array(seen)).sum(axis=1).tolist()
    best = min(range(4), key=lambda n: round(travel[n], 9))
    return best if travel[best] < travel[0] - _GAIN_RAD else 0


def _columns(rotation: Array, turn: Array) -> Array:
    """Return a rotation times quarter turns, exactly: columns exchanged, with signs. Shape (3, 3)."""
    at = np.argmax(np.abs(turn), axis=0)
    return np.asarray(rotation[:, at] * turn[at, np.arange(3)])
