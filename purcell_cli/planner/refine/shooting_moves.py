"""The equations of an exact arrival for a motion by moves, all joints at once, and their derivatives.

A motion is a chain of segments. The rotation vectors of a segment's moves depend linearly on its own
unknowns. On a segment that is played once every component of every rotation vector is an unknown; on a
repeated loop the unknowns are the sides of half of it, so that it closes whatever they are. The limbs
must be collinear at the end of phases 1 and 2, or as near to it as hinges' ranges allow, and at the end of the
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
from purcell_cli.mechanics.joints import ANGLES
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.refine.inequalities import least_cosines
from purcell_cli.planner.refine.segments import phase_ends

_ACTIVE = 0.5
"""Limbs within this of the bend limit on a move are constraints, as a part of it; both as 1 - cos of the bend."""
_ACTIVE_RANGE_RAD = 0.35
"""Hinges within this of an end of their range are constraints, the same as of primitives [rad]."""
_RANGE_MARGIN_RAD = 1e-7
"""Margin inside hinges' ranges: a hundred times what the last steps may change [rad]."""


@frozen_dataclass(eq=False)
class MoveSegment:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        gait: Name of the stroke.
        turn: Rotation vectors of its moves, in the limbs' own frames [rad]. Shape (n, 6).
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
        turn: Turns of all moves, one cycle each [rad]. Shape (n, 6).
        residual: What is missing [L, rad]. Shape (m,).
        derivative: By every unknown. Shape (m, f).
        slack: What is left below the bend limit where it is small, in the cosine of the bend, and in the ranges of
            hinges [rad]. Shape (k,).
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
    """

    def __init__(
        self,
        swimmer: Swimmer,
        segments: Sequence[MoveSegment],
        start: Array,
        goal: Array,
        displacement: Array,
        accuracy: Accuracy,
    ) -> None:
        self.swimmer, self.start, self.goal, self.accuracy = swimmer, start, goal, accuracy
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
        return MoveShooting(self.swimmer, segments, self.start, self.goal, self.displacement, accuracy or self.accuracy)

    @property
    def duration(self) -> float:
        """How long the motion lasts at a joint rate of 1 rad/s [s]."""
        return sum(segment.duration for segment in self.segments)

    @property
    def unknown(self) -> Array:
        """All unknowns as they are. Shape (f,)."""
        return np.concatenate([segment.unknown() for segment in self.segments])

    def by_unknown(self, by_turn: Array) -> Array:
        """Return derivatives by the unknowns from those by the turns. Shape (m, 6 n) to (m, f)."""
        parts = [segment.by_unknown(by_turn[:, 6 * a : 6 * b]) for segment, a, b in self._places]
        return np.concatenate([by_turn[:, :0], *parts], axis=1)

    @property
    def _places(self) -> list[tuple[MoveSegment, int, int]]:
        """The segments, the first move of each and the one after its last."""
        stops = self._stops.tolist()
        return list(zip(self.segments, stops[:-1], stops[1:], strict=True))

    def turn_at(self, change: Array, turn: Array) -> Array:
        """Return all turns where the unknowns have changed. Shapes (f,) and (n, 6) to (n, 6)."""
        parts = np.split(change, np.cumsum(self._counts)[:-1])
        own = [segment.turned(part) for segment, part in zip(self.segments, parts, strict=True)]
        return np.asarray(turn + np.concatenate(own))

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
        turn = np.concatenate([segment.turn for segment in self.segments_at(unknown)])
        flow, (stops, ends) = flow_of(self.swimmer, self.accuracy), self._ends
        found = moves.equations(flow, self.start, turn, self._repeats, self._wanted_inverse, stops, ends)
        near = float(_ACTIVE * (1.0 - cos(self.swimmer.max_bend_rad)))
        slack, slope = moves.bends(found, self._least_cosine, near)
        if not self.swimmer.ball_joints:
            left, left_slope = hinge_rows(self, turn)
            slack, slope = np.concatenate([slack, left]), np.concatenate([slope, left_slope])
        return Values(turn, found.residual, self.by_unknown(found.derivative), slack, self.by_unknown(slope))

    @functools.cached_property
    def _ends(self) -> tuple[NDArray[np.int64], Array]:
        """Before which moves shapes are wanted, shape (t,), and those, shape (t, 2, 3, 3)."""
        targets = phase_ends(self.phase, self.goal, self.home)
        return np.array([stop for stop, _ in targets]), np.array([shape for _, shape in targets])

    @functools.cached_property
    def _least_cosine(self) -> Array:
        """The least cosine of the bend of each limb on each move. Shape (n, 2)."""
        return least_cosines(self.phase, self.start, self.goal, self.swimmer.max_bend_rad, self.home)


def hinge_rows(motion: MoveShooting, turn: Array) -> tuple[Array, Array]:
    """Return the room left in the ranges of hinges where it is small, and its derivative by all turns.

    A range is kept with a margin, but where the start, the goal or the shape between the phases is nearer its end.

    Args:
        motion: The motion; one cycle of a loop that repeats brings hinges back.
        turn: Turns of its moves [rad]. Shape (n, 6).

    Returns:
        Angles left at the ends of moves [rad], shape (k,), and their derivative, shape (k, 6 n).
    """
    n = len(turn)
    slacks, slopes = [np.empty(0)], [np.empty((0, 6 * n))]
    for limb, joint in enumerate(motion.swimmer.joints):
        for k, name in enumerate(ANGLES):
            if joint.kind != "hinge" or joint.range_deg(name) is None:
                continue
            column = 3 * limb + 2 - k
            known = [joint.read(shape[limb])[k] for shape in (motion.start, motion.goal, motion.home)]
            angle = known[0] + np.cumsum(turn[:, column])
            low, high = joint.range_rad(name)
            low, high = min(low + _RANGE_MARGIN_RAD, *known), max(high - _RANGE_MARGIN_RAD, *known)
            acts = np.zeros((n, n, 6))
            acts[:, :, column] = np.arange(n)[None, :] <= np.arange(n)[:, None]
            for slack, slope in ((angle - low, acts), (high - angle, -acts)):
                active = slack < _ACTIVE_RANGE_RAD
                slacks.append(slack[active])
                slopes.append(slope[active].reshape(-1, 6 * n))
    return np.concatenate(slacks), np.concatenate(slopes)
