"""Single shooting: the equations of an exact arrival, and their derivatives, for a whole motion at once.

A motion is a chain of segments: primitives or moves whose angles are free, and strokes that repeat. How a segment's
angles depend on those that are free is its tie (`free_angles`). The limbs must be collinear at the end of phases 1
and 2, or as near as their joints allow, and at the end of the motion the limbs must have the goal's shape and the base
the goal's pose.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.kernel import moves
from purcell_cli.kernel.clearance import Apart
from purcell_cli.kernel.descent import Descent, More
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.joint_turns import by_turns, rotation_vectors
from purcell_cli.mechanics.lift import EXACT, run_displacements
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.refine.free_angles import FreeAngles
from purcell_cli.planner.refine.segments import AT_ONCE, Segment, phase_ends

MoreRows = Callable[[PrimitiveSequence], tuple[Array, Array]]
"""Inequalities at a sequence: the room that is left, and its derivative by the free angles."""


@frozen_dataclass(eq=False)
class Values:
    """The equations at one set of free angles.

    Attributes:
        residual: What is missing [L, rad]. Shape (m,).
        derivative: By every free angle. Shape (m, n).
        sequence: The controls and their angles, one cycle each.
        shapes: Shapes before, between and after the pieces. Shape (k + 1, 2, 3, 3).
        moved: What the inequalities of moves are told from; None for primitives.
    """

    residual: Array
    derivative: Array
    sequence: PrimitiveSequence
    shapes: Array
    moved: moves.MoveEquations | None = None

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.max(np.abs(self.residual)))

    @property
    def turn(self) -> Array:
        """The turns of joints on moves [rad]. Shape (n, 6)."""
        return self.sequence.angle.reshape(-1, AT_ONCE)


class Equations:
    """The equations of one motion.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        segments: The parts of the motion, all by primitives or all by moves.
        start: Shape before it. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        displacement: Body displacement the motion must make, in units of L. Shape (4, 4).
        accuracy: Of the flow.
        apart: How far the limbs' surfaces stay from each other on moves; None where they cannot meet [L].
    """

    def __init__(
        self,
        swimmer: Swimmer,
        segments: Sequence[Segment],
        start: Array,
        goal: Array,
        displacement: Array,
        accuracy: Accuracy = EXACT,
        apart: float | None = None,
    ) -> None:
        self.swimmer, self.accuracy, self.start, self.goal = swimmer, accuracy, start, goal
        self.segments, self.displacement, self.apart = tuple(segments), displacement, apart

    @functools.cached_property
    def _wanted_inverse(self) -> Array:
        return se3.inverse(self.displacement)

    @functools.cached_property
    def home(self) -> Array:
        """The shape between the phases. Shape (2, 3, 3)."""
        return home_shape(self.swimmer, self.start)

    @property
    def controls(self) -> tuple[int, ...]:
        """The controls that the swimmer has."""
        return self.swimmer.controls

    @functools.cached_property
    def by_moves(self) -> bool:
        """Whether its pieces are moves."""
        return any(s.at_once > 1 for s in self.segments)

    @functools.cached_property
    def _slices(self) -> list[slice]:
        """The angles of each segment."""
        stops = itertools.accumulate((len(s.sequence) for s in self.segments), initial=0)
        return [slice(a, b) for a, b in itertools.pairwise(stops)]

    @functools.cached_property
    def _pieces(self) -> list[slice]:
        """The pieces of each segment."""
        stops = itertools.accumulate((s.pieces for s in self.segments), initial=0)
        return [slice(a, b) for a, b in itertools.pairwise(stops)]

    @functools.cached_property
    def repeats(self) -> list[tuple[int, int, int]]:
        """The parts that repeat: the first piece, the one after the last, and how often they are played."""
        return [
            (part.start, part.stop, s.cycles) for s, part in zip(self.segments, self._pieces, strict=True) if not s.once
        ]

    @functools.cached_property
    def phase(self) -> NDArray[np.int64]:
        """The phase of each piece. Shape (k,)."""
        return self._each([s.phase for s in self.segments])

    @functools.cached_property
    def cycles(self) -> Array:
        """How often each piece is played. Shape (k,)."""
        return self._each([s.cycles for s in self.segments]).astype(np.float64)

    @functools.cached_property
    def fixed(self) -> NDArray[np.int64]:
        """1 for pieces whose bends and ranges need no watching, else 0. Shape (k,).

        Where a stroke begins whose angles stay as they are may change: by other than two ball joints its first cycle,
        which tells how far all of its cycles then bend, is watched.
        """
        out = self._each([int(s.fixed) for s in self.segments])
        if not self.swimmer.ball_joints:
            for s, part in zip(self.segments, self._pieces, strict=True):
                if s.fixed:
                    out[part.start : part.start + s.strokes[0][2]] = 0
        return out

    def _each(self, numbers: list[int]) -> NDArray[np.int64]:
        """Return numbers of the segments as those of their pieces."""
        return np.repeat(np.array(numbers, dtype=np.int64), [s.pieces for s in self.segments])

    @functools.cached_property
    def targets(self) -> list[tuple[int, Array]]:
        """The pieces before which shapes are given, and those."""
        return phase_ends(self.phase, self.goal, self.home)

    @functools.cached_property
    def _free(self) -> FreeAngles:
        """How the free angles are numbered."""
        return FreeAngles.of([(len(s.sequence), s.tie, s.cycles) for s in self.segments])

    @functools.cached_property
    def weight(self) -> Array:
        """Joint travel per free angle. Shape (n,)."""
        return self._free.weight

    def by_free_angles(self, columns: Array) -> Array:
        """Return derivatives by the free angles, of those by every angle. Shape (m, k) to (m, n)."""
        return self._free.by_free(columns)

    @property
    def angles(self) -> Array:
        """The free angles as they are [rad]. Shape (n,)."""
        return self._free.of_angles(self.sequence.angle)

    @functools.cached_property
    def sequence(self) -> PrimitiveSequence:
        """All controls and their angles, one cycle each, as they are."""
        return joined([s.sequence for s in self.segments])

    def sequence_at(self, angle: Array) -> PrimitiveSequence:
        """Return all controls and their angles, one cycle each, at other free angles [rad]. Shape (n,)."""
        return self.sequence.with_angles(self._free.angles_at(angle, self.sequence.angle))

    def turned(self, change: Array, turn: Array) -> Array:
        """Return the turns of joints on moves where free angles have changed [rad]. Shapes (n,), (k, 6) to (k, 6)."""
        return np.asarray(turn + self._free.made(change).reshape(-1, AT_ONCE))

    @property
    def joint_travel_rad(self) -> float:
        """The motion's joint travel [rad]."""
        return sum(s.joint_travel_rad for s in self.segments)

    @property
    def duration(self) -> float:
        """How long the motion lasts at a joint rate of 1 rad/s [s]."""
        return sum(s.duration for s in self.segments)

    def blocks(self) -> list[Block]:
        """Return the motion's strokes, of primitives."""
        return [b for s in self.segments for b in s.blocks()]

    def of(self, segments: Sequence[Segment]) -> Equations:
        """Return the same equations for another motion."""
        return self._sharing(("_wanted_inverse", "home"), segments, self.accuracy)

    def at_accuracy(self, accuracy: Accuracy) -> Equations:
        """Return the same equations on the flow computed otherwise."""
        known = ("_wanted_inverse", "home", "sequence", "_free", "phase", "by_moves")
        return self._sharing(known, self.segments, accuracy)

    def _sharing(self, names: Sequence[str], segments: Sequence[Segment], accuracy: Accuracy) -> Equations:
        """Return equations of the same query; what of these is known here need not be computed again."""
        ends = self.start, self.goal, self.displacement
        out = Equations(self.swimmer, segments, *ends, accuracy, self.apart)
        known, new = vars(self), vars(out)
        for name in names:
            if name in known:
                new[name] = known[name]
        return out

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
        stop, played = self._pieces[first].start, self._played(self.sequence)
        shapes = played.shapes(self.start)[stop:]
        # With h of the segments before, g of these and W wanted, h g = W exp(missing); these must make h^-1 W.
        g = self._displacement(self.segments[first:], played[stop:], shapes)
        left = se3.normalised(matmul(g, se3.exp(-missing)))
        return Equations(self.swimmer, self.segments[first:], shapes[0], self.goal, left, self.accuracy, self.apart)

    def _played(self, sequence: PrimitiveSequence) -> ControlSequence:
        """Return angles as what is played: primitives, or moves by the rotation vectors that turns of joints are."""
        if not self.by_moves:
            return sequence
        turn = sequence.angle.reshape(-1, AT_ONCE)
        return MoveSequence.of_turns(rotation_vectors(self.swimmer, self.start, turn))

    def _displacement(self, segments: Sequence[Segment], played: ControlSequence, shapes: Array) -> Array:
        """Return what segments do to the base, one cycle of each in a sequence. Shape (4, 4)."""
        pieces = Pieces.between(played, shapes)
        parts, cycles = [s.pieces for s in segments], [s.cycles for s in segments]
        runs = run_displacements(self.swimmer, pieces, parts, cycles, self.accuracy)
        return np.asarray(functools.reduce(matmul, runs, np.eye(4)))

    def residual(self, angle: Array) -> Array:
        """Return what is missing at some free angles [L, rad]. Shape (n,) to (m,)."""
        played = self._played(self.sequence_at(angle))
        shapes = played.shapes(self.start)
        g = self._displacement(self.segments, played, shapes)
        gaps = [as_vector(matmul(shapes[stop], np.swapaxes(end, -1, -2))).ravel() for stop, end in self.targets]
        return np.concatenate([se3.log(se3.normalised(matmul(self._wanted_inverse, g))), *gaps])

    def at(self, angle: Array) -> Values:
        """Return the equations and their derivative at some free angles [rad]. Shape (n,)."""
        sequence, flow = self.sequence_at(angle), flow_of(self.swimmer, self.accuracy)
        stops, ends = self._ends
        if self.by_moves:
            turn = sequence.angle.reshape(-1, AT_ONCE)
            vectors = rotation_vectors(self.swimmer, self.start, turn)
            found = moves.equations(flow, self.start, vectors, self.repeats, self._wanted_inverse, stops, ends)
            derivative = self.by_free_angles(by_turns(self.swimmer, self.start, turn, found.derivative))
            return Values(found.residual, derivative, sequence, found.shapes, found)
        shapes, residual, derivative = flow.equations(
            self.start, sequence.control, sequence.angle, self.repeats, self._wanted_inverse, stops, ends
        )
        return Values(residual, self.by_free_angles(derivative), sequence, shapes)

    def descent(self, least: Array, near: float, more: MoreRows | None = None, apart: Apart | None = None) -> Descent:
        """Return searches for the free angles of primitives, made in one call each.

        Args:
            least: The least cosine of each limb's bend on each primitive. Shape (k, 2).
            near: More room below the bend limit than this does not matter, in the cosine of the bend.
            more: Gives the inequalities of ranges at a sequence of other angles, at most two a primitive, if any.
            apart: How far limbs must be apart, if that matters.
        """
        sequence, (stops, ends) = self.sequence, self._ends
        rows = None if more is None else _at_angles(more, sequence)
        free = self._free
        motion = sequence.control, sequence.angle, free.index, free.sign, len(free), self.repeats
        wanted = self.start, self._wanted_inverse, stops, ends
        flow, most = flow_of(self.swimmer, self.accuracy), 2 * len(sequence)
        return Descent(flow, *motion, *wanted, least, self.fixed, near, apart, rows, most)

    def values(self, angle: Array, residual: Array, derivative: Array, shapes: Array) -> Values:
        """Return the equations' values at some free angles, where those are known; see `Values`."""
        return Values(residual, derivative, self.sequence_at(angle), shapes)

    @functools.cached_property
    def _ends(self) -> tuple[NDArray[np.int64], Array]:
        """Before which pieces shapes are wanted, shape (t,), and those, shape (t, 2, 3, 3)."""
        return np.array([stop for stop, _ in self.targets]), np.array([shape for _, shape in self.targets])


def _at_angles(rows: MoreRows, sequence: PrimitiveSequence) -> More:
    """Return inequalities at a sequence as those at its angles."""
    return lambda angle: rows(sequence.with_angles(angle.copy()))
