"""The equations of an exact arrival for a motion by moves, all joints at once, and their derivatives.

A motion is a chain of segments. The turns of the joints on a segment's moves depend linearly on its own
unknowns. On a segment that is played once every component of every turn is an unknown; on a
repeated loop the unknowns are the sides of half of it, so that it closes whatever they are. The limbs
must be collinear at the end of phases 1 and 2, or as near to it as joints' ranges allow, and at the end of the
motion the limbs must have the goal's shape and the base the goal's pose.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import least_squares
from purcell_cli.geometry.reproducible import cos, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import moves
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.joint_turns import by_turns, rotation_vectors
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.refine.inequalities import least_cosines
from purcell_cli.planner.refine.move_inequalities import distance_rows, range_rows
from purcell_cli.planner.refine.segments import phase_ends

_ACTIVE = 0.5
"""Limbs within this of the bend limit on a move are constraints, as a part of it; both as 1 - cos of the bend."""


@frozen_dataclass(eq=False)
class MoveSegment:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        gait: Name of the stroke.
        turn: Turns of the joints on its moves, see `joint_turns` [rad]. Shape (n, 6).
        cycles: How often it is played.
        axes: The directions in which each of its moves may turn, turn = axes @ unknown, one after the other; None for
            all six. Shape (6, p).
        tie: What the turns of a loop that repeats depend on instead, turn = tie @ unknown. Shape (6 n, f).
        amplitude_rad: Amplitude of the stroke, where it has one [rad].
    """

    phase: int
    gait: str
    turn: Array
    cycles: int = 1
    axes: Array | None = None
    tie: Array | None = None
    amplitude_rad: float = math.nan

    @property
    def duration(self) -> float:
        """How long it lasts at a joint rate of 1 rad/s [s]."""
        return self.cycles * float(np.sum(np.max(np.abs(self.turn), axis=1)))

    @property
    def unknowns(self) -> int:
        """How many unknowns it has."""
        if self.tie is not None:
            return int(self.tie.shape[1])
        return len(self.turn) * (6 if self.axes is None else self.axes.shape[1])

    def picked(self) -> NDArray[np.int64] | None:
        """Return which components of its turns are its unknowns, where they are such. Shape (f,)."""
        if self.tie is not None:
            return None
        if self.axes is None:
            return np.arange(self.turn.size)
        used = np.argmax(self.axes, axis=0)
        if not np.array_equal(self.axes, np.eye(6)[:, used]):
            return None
        return np.asarray((6 * np.arange(len(self.turn))[:, None] + used).ravel())

    def unknown(self) -> Array:
        """Return the unknowns as they are. Shape (f,)."""
        if self.tie is not None:
            return np.asarray(least_squares(self.tie, self.turn.ravel()), dtype=np.float64)
        if self.axes is None:
            return self.turn.ravel()
        return np.asarray(matmul(self.turn, self.axes)).ravel()  # the axes are orthonormal

    def turned(self, unknown: Array) -> Array:
        """Return the turns of some unknowns. Shape (f,) to (n, 6)."""
        if self.tie is not None:
            return np.asarray(matmul(self.tie, unknown)).reshape(-1, 6)
        if self.axes is None:
            return unknown.reshape(-1, 6)
        return np.asarray(matmul(unknown.reshape(len(self.turn), -1), self.axes.T))

    def by_unknown(self, by_turn: Array) -> Array:
        """Return derivatives by the unknowns from those by the turns. Shape (m, 6 n) to (m, f)."""
        if self.tie is not None:
            return np.asarray(matmul(by_turn, self.tie))
        if self.axes is None:
            return by_turn
        m, n = len(by_turn), len(self.turn)
        return np.asarray(matmul(by_turn.reshape(m * n, 6), self.axes)).reshape(m, n * self.axes.shape[1])

    def at(self, unknown: Array) -> MoveSegment:
        """Return the segment at other unknowns. Shape (f,)."""
        return self if not self.unknowns else dataclasses.replace(self, turn=self.turned(unknown))


@frozen_dataclass(eq=False)
class Values:
    """The equations at some unknowns.

    Attributes:
        turn: Turns of joints on all moves, one cycle each [rad]. Shape (n, 6).
        residual: What is missing [L, rad]. Shape (m,).
        derivative: By every unknown. Shape (m, f).
        slack: What is left below the bend limit where it is small, in the cosine of the bend, and in the ranges of
            joints [rad]. Shape (k,).
        slack_derivative: By every unknown. Shape (k, f).
    """

    turn: Array
    residual: Array
    derivative: Array
    slack: Array
    slack_derivative: Array

    @property
    def size(self) -> float:
        """The largest residual [L, rad]."""
        return float(np.max(np.abs(self.residual)))


class MoveShooting:
    """The equations of one motion.

    Args:
        swimmer: The swimmer, scaled to L = 1; its bend limit holds in phase 2.
        segments: The parts of the motion.
        start: Shape before it. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        displacement: Body displacement the motion must make, in units of L. Shape (4, 4).
        accuracy: Of the flow.
        apart: How far the limbs' surfaces stay from each other; None where they cannot meet [L].
    """

    def __init__(
        self,
        swimmer: Swimmer,
        segments: Sequence[MoveSegment],
        start: Array,
        goal: Array,
        displacement: Array,
        accuracy: Accuracy,
        apart: float | None = None,
    ) -> None:
        self.swimmer, self.start, self.goal, self.accuracy, self.apart = swimmer, start, goal, accuracy, apart
        self.segments, self.displacement = tuple(segments), displacement
        self._wanted_inverse = se3.inverse(displacement)
        counts = [len(segment.turn) for segment in self.segments]
        self._stops = np.cumsum([0, *counts])
        self.phase = np.repeat([segment.phase for segment in self.segments], counts)
        self.cycles = np.repeat([segment.cycles for segment in self.segments], counts)
        self._repeats = [(a, b, segment.cycles) for segment, a, b in self._places if segment.cycles > 1]
        self.home = home_shape(swimmer, start)

    def of(self, segments: Sequence[MoveSegment], accuracy: Accuracy | None = None) -> MoveShooting:
        """Return the same equations for another motion, on the flow computed otherwise if an accuracy is given."""
        ends = self.start, self.goal, self.displacement
        return MoveShooting(self.swimmer, segments, *ends, accuracy or self.accuracy, self.apart)

    @property
    def duration(self) -> float:
        """How long the motion lasts at a joint rate of 1 rad/s [s]."""
        return sum(segment.duration for segment in self.segments)

    @property
    def unknown(self) -> Array:
        """All unknowns as they are. Shape (f,)."""
        return np.concatenate([segment.unknown() for segment in self.segments])

    @functools.cached_property
    def _runs(self) -> list[tuple[MoveSegment | None, NDArray[np.int64], slice, slice]]:
        """The unknowns in order: a segment alone, or None and the components that the unknowns of several are."""
        out: list[tuple[MoveSegment | None, NDArray[np.int64], slice, slice]] = []
        first = 0
        for segment, a, b in self._places:
            picked, last = segment.picked(), first + segment.unknowns
            own, moved, none = slice(first, last), slice(6 * a, 6 * b), np.empty(0, dtype=np.int64)
            if picked is None:
                out.append((segment, none, own, moved))
            elif out and out[-1][0] is None:
                columns, begun, before = out[-1][1:]
                columns = np.concatenate([columns, 6 * a + picked])
                out[-1] = None, columns, slice(begun.start, last), slice(before.start, 6 * b)
            else:
                out.append((None, 6 * a + picked, own, moved))
            first = last
        return out

    def by_unknown(self, by_turn: Array) -> Array:
        """Return derivatives by the unknowns from those by the turns. Shape (m, 6 n) to (m, f)."""
        parts = [
            by_turn[:, columns] if segment is None else segment.by_unknown(by_turn[:, moved])
            for segment, columns, _, moved in self._runs
        ]
        return np.concatenate([by_turn[:, :0], *parts], axis=1)

    @property
    def _places(self) -> list[tuple[MoveSegment, int, int]]:
        """The segments, the first move of each and the one after its last."""
        stops = self._stops.tolist()
        return list(zip(self.segments, stops[:-1], stops[1:], strict=True))

    def _turned(self, unknown: Array) -> Array:
        """Return the turns that unknowns make. Shape (f,) to (n, 6)."""
        out = np.zeros(6 * len(self.phase))
        for segment, columns, own, moved in self._runs:
            if segment is None:
                out[columns] = unknown[own]
            else:
                out[moved] = segment.turned(unknown[own]).ravel()
        return out.reshape(-1, 6)

    @functools.cached_property
    def _fixed(self) -> Array:
        """The turns that no unknown changes, and 0 for the others [rad]. Shape (n, 6)."""
        parts = [np.zeros_like(s.turn) if s.unknowns else s.turn for s in self.segments]
        return np.concatenate(parts)

    def turn_at(self, change: Array, turn: Array) -> Array:
        """Return all turns where the unknowns have changed. Shapes (f,) and (n, 6) to (n, 6)."""
        return np.asarray(turn + self._turned(change))

    @property
    def tail(self) -> int:
        """The first unknown of those after which no segment repeats: their changes are not multiplied."""
        last = max((k + 1 for k, segment in enumerate(self.segments) if segment.cycles > 1), default=0)
        return sum(self._counts[:last])

    @property
    def _counts(self) -> list[int]:
        """How many unknowns each segment has."""
        return [segment.unknowns for segment in self.segments]

    def segments_at(self, unknown: Array) -> list[MoveSegment]:
        """Return the segments at other unknowns. Shape (f,)."""
        parts = np.split(unknown, np.cumsum(self._counts)[:-1])
        return [segment.at(part) for segment, part in zip(self.segments, parts, strict=True)]

    def at(self, unknown: Array) -> Values:
        """Return the equations at some unknowns. Shape (f,)."""
        turn = self._fixed + self._turned(unknown)
        flow, (stops, ends) = flow_of(self.swimmer, self.accuracy), self._ends
        vectors = rotation_vectors(self.swimmer, self.start, turn)
        found = moves.equations(flow, self.start, vectors, self._repeats, self._wanted_inverse, stops, ends)
        near = float(_ACTIVE * (1.0 - cos(self.swimmer.max_bend_rad)))
        slack, slope = moves.bends(found, self._least_cosine, near)
        if self.apart is not None:
            gaps, gaps_slope = distance_rows(self.swimmer, found, vectors, self.apart)
            slack, slope = np.concatenate([slack, gaps]), np.concatenate([slope, gaps_slope])
        derivative, slope = (by_turns(self.swimmer, self.start, turn, d) for d in (found.derivative, slope))
        if not self.swimmer.ball_joints:
            left, left_slope = range_rows(self.swimmer, np.stack([self.start, self.goal, self.home]), turn)
            slack, slope = np.concatenate([slack, left]), np.concatenate([slope, left_slope])
        return Values(turn, found.residual, self.by_unknown(derivative), slack, self.by_unknown(slope))

    @functools.cached_property
    def _ends(self) -> tuple[NDArray[np.int64], Array]:
        """Before which moves shapes are wanted, shape (t,), and those, shape (t, 2, 3, 3)."""
        targets = phase_ends(self.phase, self.goal, self.home)
        return np.array([stop for stop, _ in targets]), np.array([shape for _, shape in targets])

    @functools.cached_property
    def _least_cosine(self) -> Array:
        """The least cosine of the bend of each limb on each move. Shape (n, 2)."""
        return least_cosines(self.phase, self.start, self.goal, self.swimmer.max_bend_rad, self.home)
