"""The equations of an exact arrival, and their derivatives, for a whole motion at once.

A motion is a chain of stretches: runs of primitives whose angles are free, and strokes that repeat.
A repeated stroke that goes round a rectangle of two joints' angles closes whatever the sides, so
its two sides are free as well; any other stays as it is. The limbs must be collinear where phases
1 and 2 end, they must end at the goal's shape, and the base at the goal's pose.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import EXACT, Accuracy, Repeat, flow_and_jacobian, run_displacements, shape_gap
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block

Rows = NDArray[np.int64]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        strokes: The strokes it consists of, in order: name, amplitude [rad] and number of primitives.
        sequence: Its primitives.
        cycles: How often it is played.
    """

    phase: int
    strokes: tuple[tuple[str, float, int], ...]
    sequence: PrimitiveSequence
    cycles: int = 1

    @property
    def free(self) -> bool:
        """Whether every angle may change by itself."""
        return self.cycles == 1

    @property
    def rectangle(self) -> bool:
        """Whether it repeats a rectangle of two joints' angles."""
        c, a = self.sequence.control, self.sequence.angle
        return not self.free and len(a) == 4 and c[0] == c[2] and c[1] == c[3] and bool(np.all(a[:2] == -a[2:]))

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its primitives of |angle| [rad]."""
        return self.cycles * self.sequence.joint_travel_rad

    def renamed(self, name: str, sequence: PrimitiveSequence) -> Stretch:
        """Return the stretch with other primitives, all of one stroke."""
        return dataclasses.replace(self, sequence=sequence, strokes=((name, math.nan, len(sequence)),))

    def changed(self, change: Callable[[PrimitiveSequence], PrimitiveSequence]) -> Stretch:
        """Return the stretch with the primitives of each of its strokes changed."""
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


def stretches_of(blocks: Sequence[Block]) -> list[Stretch]:
    """Return blocks of primitives as stretches: neighbours in one phase that do not repeat are joined."""
    out: list[Stretch] = []
    for block in blocks:
        stroke = (block.gait, block.amplitude_rad, len(block.sequence))
        sequence = cast(PrimitiveSequence, block.sequence)
        last = out[-1] if out else None
        if last is not None and last.free and block.cycles == 1 and last.phase == block.phase:
            strokes = (*last.strokes, stroke)
            out[-1] = dataclasses.replace(last, strokes=strokes, sequence=last.sequence + sequence)
        else:
            out.append(Stretch(block.phase, (stroke,), sequence, block.cycles))
    return out


def phase_ends(phase: Rows, goal: Array) -> list[tuple[int, Array]]:
    """Return the pieces before which shapes are given, and those: collinear after phases 1 and 2, the goal's last.

    Args:
        phase: Phase of each piece. Shape (k,).
        goal: Shape at the end. Shape (2, 3, 3).
    """
    ends = [
        (int(np.flatnonzero(phase == p)[-1]) + 1, COLLINEAR) for p in (1, 2) if np.any(phase == p) and np.any(phase > p)
    ]
    return [*ends, (len(phase), goal)]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Values:
    """The equations at one set of free angles.

    Attributes:
        residual: What is missing [L, rad]. Shape (m,).
        derivative: By every free angle. Shape (m, n).
        sequence: The primitives, one cycle each.
        shapes: Shapes before, between and after them. Shape (k + 1, 2, 3, 3).
    """

    residual: Array
    derivative: Array
    sequence: PrimitiveSequence
    shapes: Array

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.max(np.abs(self.residual)))


class Equations:
    """The equations of one motion.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        stretches: The parts of the motion.
        start: Shape before it. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        displacement: Body displacement the motion must make, in units of L. Shape (4, 4).
        accuracy: Of the flow.
    """

    def __init__(
        self,
        swimmer: Swimmer,
        stretches: Sequence[Stretch],
        start: Array,
        goal: Array,
        displacement: Array,
        accuracy: Accuracy = EXACT,
    ) -> None:
        self.swimmer, self.accuracy, self.start, self.goal = swimmer, accuracy, start, goal
        self.stretches = tuple(stretches)
        self.displacement, self._wanted_inverse = displacement, se3.inverse(displacement)
        counts = [len(s.sequence) for s in self.stretches]
        stops = np.cumsum([0, *counts]).tolist()
        self._slices = [slice(a, b) for a, b in itertools.pairwise(stops)]
        self.repeats = [
            Repeat(part.start, part.stop, s.cycles)
            for s, part in zip(self.stretches, self._slices, strict=True)
            if not s.free
        ]
        self.phase = np.repeat(np.array([s.phase for s in self.stretches], dtype=np.int64), counts)
        self._free_index()
        self.targets = phase_ends(self.phase, goal)

    def _free_index(self) -> None:
        """Number the free angles: primitive k turns by sign[k] times free angle index[k]; -1 is none."""
        index: list[int] = []
        sign: list[float] = []
        weight: list[float] = []
        for s in self.stretches:
            n, k = len(s.sequence), len(weight)
            if s.free:
                index += list(range(k, k + n))
                sign += [1.0] * n
                weight += [1.0] * n
            else:
                index += [k, k + 1, k, k + 1] if s.rectangle else [-1] * n
                sign += [1.0, 1.0, -1.0, -1.0] if s.rectangle else [0.0] * n
                weight += [2.0 * s.cycles] * 2 if s.rectangle else []
        self.weight = np.array(weight)
        self._index, self._sign = np.array(index, dtype=np.int64), np.array(sign)
        self._own, self._opposite = np.flatnonzero(self._sign > 0), np.flatnonzero(self._sign < 0)

    def by_free_angles(self, columns: Array) -> Array:
        """Return derivatives by the free angles, of those by every primitive's angle. Shape (m, k) to (m, n)."""
        out = np.empty((len(columns), len(self.weight)))
        out[:, self._index[self._own]] = columns[:, self._own]
        out[:, self._index[self._opposite]] -= columns[:, self._opposite]
        return out

    @property
    def angles(self) -> Array:
        """The free angles as they are [rad]. Shape (n,)."""
        out = np.empty(len(self.weight))
        out[self._index[self._own]] = self.sequence.angle[self._own]
        return out

    @functools.cached_property
    def sequence(self) -> PrimitiveSequence:
        """All primitives, one cycle each, as they are."""
        return joined([s.sequence for s in self.stretches])

    def sequence_at(self, angle: Array) -> PrimitiveSequence:
        """Return all primitives, one cycle each, at other free angles [rad]. Shape (n,)."""
        return self.sequence.with_angles(
            np.where(self._index < 0, self.sequence.angle, self._sign * angle[self._index])
        )

    @property
    def joint_travel_rad(self) -> float:
        """The motion's joint travel [rad]."""
        return sum(s.joint_travel_rad for s in self.stretches)

    def blocks(self) -> list[Block]:
        """Return the motion's strokes."""
        return [b for s in self.stretches for b in s.blocks()]

    def of(self, stretches: Sequence[Stretch]) -> Equations:
        """Return the same equations for another motion."""
        return Equations(self.swimmer, stretches, self.start, self.goal, self.displacement, self.accuracy)

    def at_accuracy(self, accuracy: Accuracy) -> Equations:
        """Return the same equations on the flow computed otherwise."""
        return Equations(self.swimmer, self.stretches, self.start, self.goal, self.displacement, accuracy)

    def with_angles(self, angle: Array) -> list[Stretch]:
        """Return the stretches with other free angles [rad]. Shape (n,)."""
        sequence = self.sequence_at(angle)
        return [
            dataclasses.replace(s, sequence=sequence[part])
            for s, part in zip(self.stretches, self._slices, strict=True)
        ]

    def after(self, first: int, missing: Array) -> Equations:
        """Return the equations of the stretches from one on, those before being as they are.

        Args:
            first: The first of them.
            missing: What is missing of the base's displacement as the angles are [L, rad]. Shape (6,).
        """
        stop = self._slices[first].start
        shapes = self.sequence.shapes(self.start)[stop:]
        # With h of the stretches before, g of these and W wanted, h g = W exp(missing); these must make h^-1 W.
        g = self._displacement(self.stretches[first:], self.sequence[stop:], shapes)
        left = se3.normalised(g @ se3.exp(-missing))
        return Equations(self.swimmer, self.stretches[first:], shapes[0], self.goal, left, self.accuracy)

    def _displacement(self, stretches: Sequence[Stretch], sequence: PrimitiveSequence, shapes: Array) -> Array:
        """Return what stretches do to the base, one cycle of each in a sequence. Shape (4, 4)."""
        pieces = (shapes[:-1], sequence.rates(), sequence.duration)
        parts, cycles = [len(s.sequence) for s in stretches], [s.cycles for s in stretches]
        moves = run_displacements(self.swimmer, pieces, parts, cycles, self.accuracy)
        return np.asarray(functools.reduce(np.matmul, moves, np.eye(4)))

    def residual(self, angle: Array) -> Array:
        """Return what is missing at some free angles [L, rad]. Shape (n,) to (m,)."""
        sequence = self.sequence_at(angle)
        shapes = sequence.shapes(self.start)
        g = self._displacement(self.stretches, sequence, shapes)
        gaps = [shape_gap(sequence[:stop], shapes[: stop + 1], shape)[0] for stop, shape in self.targets]
        return np.concatenate([se3.log(se3.normalised(self._wanted_inverse @ g)), *gaps])

    def at(self, angle: Array) -> Values:
        """Return the equations and their derivative at some free angles [rad]. Shape (n,)."""
        sequence = self.sequence_at(angle)
        shapes = sequence.shapes(self.start)
        g, twists = flow_and_jacobian(self.swimmer, sequence, self.start, self.accuracy, self.repeats)
        residual = [se3.log(se3.normalised(self._wanted_inverse @ g))]
        derivative = [twists]
        for stop, shape in self.targets:
            gap, slope = shape_gap(sequence[:stop], shapes[: stop + 1], shape)
            residual.append(gap)
            derivative.append(np.pad(slope, ((0, 0), (0, len(sequence) - stop))))
        return Values(np.concatenate(residual), self.by_free_angles(np.concatenate(derivative)), sequence, shapes)
