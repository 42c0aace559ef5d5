"""The equations of an exact arrival, and their derivatives, for a whole motion at once.

A motion is a chain of segments: primitives whose angles are free, and strokes that repeat. A repeated
stroke round rectangles of two joints' angles closes whatever their sides are, so their sides are free
as well; any other repeated stroke is fixed. The limbs must be collinear at the end of phases 1 and 2, or as near
as their joints allow,
and at the end of the motion the limbs must have the goal's shape and the base the goal's pose.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.descent import Descent, More
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.lift import EXACT, run_displacements
from purcell_cli.mechanics.lift_derivatives import shape_gap
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.refine.segments import Segment, phase_ends

MoreRows = Callable[[PrimitiveSequence, Array], tuple[Array, Array]]
"""Inequalities at a sequence and its shapes: the room that is left, and its derivative by the free angles."""


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
        segments: The parts of the motion.
        start: Shape before it. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        displacement: Body displacement the motion must make, in units of L. Shape (4, 4).
        accuracy: Of the flow.
    """

    def __init__(
        self,
        swimmer: Swimmer,
        segments: Sequence[Segment],
        start: Array,
        goal: Array,
        displacement: Array,
        accuracy: Accuracy = EXACT,
    ) -> None:
        self.swimmer, self.accuracy, self.start, self.goal = swimmer, accuracy, start, goal
        self.segments = tuple(segments)
        self.displacement, self._wanted_inverse = displacement, se3.inverse(displacement)
        counts = [len(s.sequence) for s in self.segments]
        stops = np.cumsum([0, *counts]).tolist()
        self._slices = [slice(a, b) for a, b in itertools.pairwise(stops)]
        self.repeats = [
            (part.start, part.stop, s.cycles) for s, part in zip(self.segments, self._slices, strict=True) if not s.free
        ]
        self.phase = np.repeat(np.array([s.phase for s in self.segments], dtype=np.int64), counts)
        self.fixed = np.repeat(np.array([s.fixed for s in self.segments], dtype=np.int64), counts)
        if not swimmer.ball_joints:  # where a stroke begins may change: its first cycle tells how far all then bend
            for s, part in zip(self.segments, self._slices, strict=True):
                if s.fixed:
                    self.fixed[part.start : part.start + s.strokes[0][2]] = 0
        self._free_index()
        self.home, self.controls = home_shape(swimmer, start), swimmer.controls
        self.targets = phase_ends(self.phase, goal, self.home)

    def _free_index(self) -> None:
        """Number the free angles: primitive k turns by sign[k] times free angle index[k]; -1 is none."""
        index: list[int] = []
        sign: list[float] = []
        weight: list[float] = []
        for s in self.segments:
            n, k = len(s.sequence), len(weight)
            if s.free:
                index += list(range(k, k + n))
                sign += [1.0] * n
                weight += [1.0] * n
            else:
                many = s.rectangles
                index += [k + 2 * r + side for r in range(many) for side in (0, 1, 0, 1)] if many else [-1] * n
                sign += [1.0, 1.0, -1.0, -1.0] * many if many else [0.0] * n
                weight += [2.0 * s.cycles] * (2 * many)
        self.weight = np.array(weight)
        self._index, self._sign = np.array(index, dtype=np.int64), np.array(sign)
        self._all_free = all(s.free for s in self.segments)
        self._own, self._opposite = np.flatnonzero(self._sign > 0), np.flatnonzero(self._sign < 0)

    def by_free_angles(self, columns: Array) -> Array:
        """Return derivatives by the free angles, of those by every primitive's angle. Shape (m, k) to (m, n)."""
        if self._all_free:
            return columns
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
        return joined([s.sequence for s in self.segments])

    def sequence_at(self, angle: Array) -> PrimitiveSequence:
        """Return all primitives, one cycle each, at other free angles [rad]. Shape (n,)."""
        return self.sequence.with_angles(
            np.where(self._index < 0, self.sequence.angle, self._sign * angle[self._index])
        )

    @property
    def joint_travel_rad(self) -> float:
        """The motion's joint travel [rad]."""
        return sum(s.joint_travel_rad for s in self.segments)

    def blocks(self) -> list[Block]:
        """Return the motion's strokes."""
        return [b for s in self.segments for b in s.blocks()]

    def of(self, segments: Sequence[Segment]) -> Equations:
        """Return the same equations for another motion."""
        return Equations(self.swimmer, segments, self.start, self.goal, self.displacement, self.accuracy)

    def at_accuracy(self, accuracy: Accuracy) -> Equations:
        """Return the same equations on the flow computed otherwise."""
        return Equations(self.swimmer, self.segments, self.start, self.goal, self.displacement, accuracy)

    def with_angles(self, angle: Array) -> list[Segment]:
        """Return the segments with other free angles [rad]. Shape (n,)."""
        sequence = self.sequence_at(angle)
        return [
            dataclasses.replace(s, sequence=sequence[part]) for s, part in zip(self.segments, self._slices, strict=True)
        ]

    def after(self, first: int, missing: Array) -> Equations:
        """Return the equations of the segments from one on, those before being as they are.

        Args:
            first: The first of them.
            missing: What is missing of the base's displacement as the angles are [L, rad]. Shape (6,).
        """
        stop = self._slices[first].start
        shapes = self.sequence.shapes(self.start)[stop:]
        # With h of the segments before, g of these and W wanted, h g = W exp(missing); these must make h^-1 W.
        g = self._displacement(self.segments[first:], self.sequence[stop:], shapes)
        left = se3.normalised(matmul(g, se3.exp(-missing)))
        return Equations(self.swimmer, self.segments[first:], shapes[0], self.goal, left, self.accuracy)

    def _displacement(self, segments: Sequence[Segment], sequence: PrimitiveSequence, shapes: Array) -> Array:
        """Return what segments do to the base, one cycle of each in a sequence. Shape (4, 4)."""
        pieces = Pieces.between(sequence, shapes)
        parts, cycles = [len(s.sequence) for s in segments], [s.cycles for s in segments]
        moves = run_displacements(self.swimmer, pieces, parts, cycles, self.accuracy)
        return np.asarray(functools.reduce(matmul, moves, np.eye(4)))

    def residual(self, angle: Array) -> Array:
        """Return what is missing at some free angles [L, rad]. Shape (n,) to (m,)."""
        sequence = self.sequence_at(angle)
        shapes = sequence.shapes(self.start)
        g = self._displacement(self.segments, sequence, shapes)
        gaps = [shape_gap(sequence[:stop], shapes[: stop + 1], shape)[0] for stop, shape in self.targets]
        return np.concatenate([se3.log(se3.normalised(matmul(self._wanted_inverse, g))), *gaps])

    def at(self, angle: Array) -> Values:
        """Return the equations and their derivative at some free angles [rad]. Shape (n,)."""
        sequence = self.sequence_at(angle)
        stops, ends = self._ends
        shapes, residual, derivative = flow_of(self.swimmer, self.accuracy).equations(
            self.start, sequence.control, sequence.angle, self.repeats, self._wanted_inverse, stops, ends
        )
        return Values(residual, self.by_free_angles(derivative), sequence, shapes)

    def descent(self, least: Array, near: float, more: MoreRows | None = None, most: int = 0) -> Descent:
        """Return searches for the free angles, made in one call each.

        Args:
            least: The least cosine of each limb's bend on each primitive. Shape (k, 2).
            near: More room below the bend limit than this does not matter, in the cosine of the bend.
            more: Gives more inequalities at a sequence of other angles and its shapes, see `inequalities`, if any.
            most: How many they are at most.
        """
        sequence, (stops, ends) = self.sequence, self._ends
        rows = None if more is None else _at_angles(more, sequence)
        motion = sequence.control, sequence.angle, self._index, self._sign, len(self.weight), self.repeats
        wanted = self.start, self._wanted_inverse, stops, ends
        return Descent(flow_of(self.swimmer, self.accuracy), *motion, *wanted, least, self.fixed, near, rows, most)

    def values(self, angle: Array, residual: Array, derivative: Array, shapes: Array) -> Values:
        """Return the equations' values at some free angles, where those are known; see `Values`."""
        return Values(residual, derivative, self.sequence_at(angle), shapes)

    @functools.cached_property
    def _ends(self) -> tuple[NDArray[np.int64], Array]:
        """Before which primitives shapes are wanted, shape (t,), and those, shape (t, 2, 3, 3)."""
        return np.array([stop for stop, _ in self.targets]), np.array([shape for _, shape in self.targets])


def _at_angles(rows: MoreRows, sequence: PrimitiveSequence) -> More:
    """Return inequalities at a sequence as those at its angles."""
    return lambda angle, shapes: rows(sequence.with_angles(angle.copy()), shapes)
