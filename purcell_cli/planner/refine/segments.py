"""Segments: strokes of a motion whose angles change together.

The pieces of a segment are primitives, on each of which one angle changes, or moves, on each of which six do: the turns
of both limbs' joints (`joint_turns`).
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.refine.free_angles import HELD, RECTANGLE

Rows = NDArray[np.int64]

AT_ONCE = 6
"""How many angles change on a move."""
_MOST_APART = 20_000
"""Up to so many primitives the cycles of a stroke are played one by one."""


@frozen_dataclass(eq=False)
class Segment:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        strokes: The strokes it consists of, in order: name, amplitude [rad] and number of angles.
        sequence: Its controls and angles; on moves six at a time are played at once.
        cycles: How often it is played.
        fixed: Whether its angles stay as they are though it does not repeat.
        at_once: How many angles change on each of its pieces: 1 on primitives, 6 on moves.
        given_tie: How its angles depend on free ones (`free_angles`), where that does not follow from what it is.
            Shape (r, f), for every r angles in turn.
    """

    phase: int
    strokes: tuple[tuple[str, float, int], ...]
    sequence: PrimitiveSequence
    cycles: int = 1
    fixed: bool = False
    at_once: int = 1
    given_tie: Array | None = None

    @classmethod
    def by_moves(
        cls,
        phase: int,
        name: str,
        turn: Array,
        cycles: int = 1,
        tie: Array | None = None,
        amplitude_rad: float = math.nan,
        fixed: bool = False,
    ) -> Segment:
        """Return a stroke by moves.

        Args:
            phase: 1, 2 or 3 of the reconfiguration.
            name: Of the stroke.
            turn: Turns of the joints on its moves [rad]. Shape (n, 6).
            cycles: How often it is played.
            tie: See above.
            amplitude_rad: Amplitude of the stroke, where it has one [rad].
            fixed: See above.
        """
        strokes = ((name, amplitude_rad, turn.size),)
        return cls(phase, strokes, _of_turns(turn), cycles, fixed, AT_ONCE, tie)

    @property
    def once(self) -> bool:
        """Whether it is played once, by angles that may change."""
        return self.cycles == 1 and not self.fixed

    @property
    def free(self) -> bool:
        """Whether every angle may change by itself."""
        return self.once and self.given_tie is None

    @property
    def tie(self) -> Array | None:
        """How its angles depend on free ones, see `free_angles`; None where each is free. Shape (r, f)."""
        if self.free or self.given_tie is not None:
            return self.given_tie
        return RECTANGLE if self.rectangles else HELD

    @property
    def loose(self) -> bool:
        """Whether each of its moves has free angles of its own, so that it may have fewer moves or more."""
        return self.tie is None or (len(self.tie) == self.at_once and self.tie.shape[1] > 0)

    @property
    def rectangles(self) -> int:
        """How many rectangles of two joints' angles it repeats, one after the other; 0 where it is not made of them."""
        if self.once or self.at_once > 1 or not len(self.sequence) or len(self.sequence) % 4:
            return 0
        c, a = self.sequence.control.reshape(-1, 4), self.sequence.angle.reshape(-1, 4)
        closed = np.all(c[:, :2] == c[:, 2:]) and np.all(a[:, :2] == -a[:, 2:])
        return len(c) if closed else 0

    @property
    def pieces(self) -> int:
        """How many primitives or moves it has, in one cycle."""
        return len(self.sequence) // self.at_once

    @property
    def turn(self) -> Array:
        """The turns of the joints on its moves [rad]. Shape (n, 6)."""
        return self.sequence.angle.reshape(-1, AT_ONCE)

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its angles of |angle| [rad]."""
        return self.cycles * self.sequence.joint_travel_rad

    @property
    def duration(self) -> float:
        """How long it lasts at a joint rate of 1 rad/s [s]."""
        largest = np.max(np.abs(self.sequence.angle.reshape(-1, self.at_once)), axis=1)
        return self.cycles * float(np.sum(largest))

    def renamed(self, name: str, sequence: PrimitiveSequence) -> Segment:
        """Return the segment with other pieces, all of one stroke."""
        return dataclasses.replace(self, sequence=sequence, strokes=((name, math.nan, len(sequence)),))

    def with_turns(self, turn: Array) -> Segment:
        """Return the segment with other moves, all of the stroke that it is. Shape (n, 6)."""
        ((name, amplitude, _),) = self.strokes
        return dataclasses.replace(self, sequence=_of_turns(turn), strokes=((name, amplitude, turn.size),))

    def changed(self, change: Callable[[PrimitiveSequence], PrimitiveSequence]) -> Segment:
        """Return the segment with the primitives of each of its strokes changed."""
        parts = [(name, amplitude, change(part)) for (name, amplitude, _), part in self._parts()]
        strokes = tuple((name, amplitude, len(part)) for name, amplitude, part in parts)
        return dataclasses.replace(self, strokes=strokes, sequence=joined([part for _, _, part in parts]))

    def _parts(self) -> Iterator[tuple[tuple[str, float, int], PrimitiveSequence]]:
        position = 0
        for stroke in self.strokes:
            yield stroke, self.sequence[position : position + stroke[2]]
            position += stroke[2]

    def blocks(self) -> list[Block]:
        """Return its strokes, of primitives, as blocks."""
        return [Block(self.phase, name, part, self.cycles, a) for (name, a, _), part in self._parts()]


def _of_turns(turn: Array) -> PrimitiveSequence:
    """Return turns of joints as the angles of all six controls on each move. Shape (n, 6)."""
    return PrimitiveSequence(_controls(len(turn)), turn)


@functools.lru_cache(maxsize=256)
def _controls(moves: int) -> Rows:
    return np.tile(np.arange(AT_ONCE), moves)


def segments_of(blocks: Sequence[Block]) -> list[Segment]:
    """Return blocks of primitives as segments: neighbours in one phase that do not repeat are joined.

    A repeated stroke that turns a limb about several axes closes to rounding only, and a thousand cycles of it add up;
    its cycles are played one by one.
    """
    out: list[Segment] = []
    for block in blocks:
        stroke = (block.gait, block.amplitude_rad, len(block.sequence))
        sequence = cast(PrimitiveSequence, block.sequence)
        last = out[-1] if out else None
        if last is not None and last.free and block.cycles == 1 and last.phase == block.phase:
            strokes = (*last.strokes, stroke)
            out[-1] = dataclasses.replace(last, strokes=strokes, sequence=last.sequence + sequence)
        elif block.cycles > 1 and block.cycles * len(sequence) <= _MOST_APART and not _closes_exactly(sequence):
            every = joined([sequence] * block.cycles)
            out.append(Segment(block.phase, (stroke,) * block.cycles, every, fixed=True))
        else:
            out.append(Segment(block.phase, (stroke,), sequence, block.cycles))
    return out


def _closes_exactly(sequence: PrimitiveSequence) -> bool:
    """Return whether a stroke turns each limb about one axis only, so that it closes to the last bit or not at all.

    The two angles of a universal joint close one by one.
    """
    limb, based = sequence.limb, sequence.control >= 6
    return all(len(set(sequence.control[(limb == k) & ~based].tolist())) < 2 for k in (0, 1))


def free_primitives(segments: Sequence[Segment]) -> int:
    """Return how many primitives have angles of their own to change."""
    return sum(len(s.sequence) for s in segments if s.free)


def phase_ends(phase: Rows, goal: Array, home: Array = COLLINEAR) -> list[tuple[int, Array]]:
    """Return the pieces before which shapes are given, and those: the home after phases 1 and 2, the goal's last.

    Args:
        phase: Phase of each piece. Shape (k,).
        goal: Shape at the end. Shape (2, 3, 3).
        home: Shape that phases 1 and 2 end at. Shape (2, 3, 3).
    """
    every = phase.tolist()
    known, n = set(every), len(every)
    ends = [(n - every[::-1].index(p), home) for p in (1, 2) if p in known and max(known) > p]
    return [*ends, (n, goal)]
