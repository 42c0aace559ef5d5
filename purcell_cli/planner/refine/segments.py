"""Segments: strokes of a motion whose angles change together."""

from __future__ import annotations

import dataclasses
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

Rows = NDArray[np.int64]

_MOST_APART = 20_000
"""Up to so many primitives the cycles of a stroke are played one by one."""


@frozen_dataclass(eq=False)
class Segment:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        strokes: The strokes it consists of, in order: name, amplitude [rad] and number of primitives.
        sequence: Its primitives.
        cycles: How often it is played.
        fixed: Whether its angles stay as they are though it does not repeat.
    """

    phase: int
    strokes: tuple[tuple[str, float, int], ...]
    sequence: PrimitiveSequence
    cycles: int = 1
    fixed: bool = False

    @property
    def free(self) -> bool:
        """Whether every angle may change by itself."""
        return self.cycles == 1 and not self.fixed

    @property
    def rectangles(self) -> int:
        """How many rectangles of two joints' angles it repeats, one after the other; 0 where it is not made of them."""
        if self.free or not len(self.sequence) or len(self.sequence) % 4:
            return 0
        c, a = self.sequence.control.reshape(-1, 4), self.sequence.angle.reshape(-1, 4)
        closed = np.all(c[:, :2] == c[:, 2:]) and np.all(a[:, :2] == -a[:, 2:])
        return len(c) if closed else 0

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its primitives of |angle| [rad]."""
        return self.cycles * self.sequence.joint_travel_rad

    def renamed(self, name: str, sequence: PrimitiveSequence) -> Segment:
        """Return the segment with other primitives, all of one stroke."""
        return dataclasses.replace(self, sequence=sequence, strokes=((name, math.nan, len(sequence)),))

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
        """Return its strokes as blocks."""
        return [Block(self.phase, name, part, self.cycles, a) for (name, a, _), part in self._parts()]


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
