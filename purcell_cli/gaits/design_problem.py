"""A closed stroke as unknowns: what it does, its limits, and how both change with every turn.

A stroke is an approach from the collinear shape, a cycle, and the approach undone. Its unknowns are
the turns that its kind allows: of both limbs at once, or of one joint a move; in one plane or not.
The displacement and its derivative come from one pass of the exact lift. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError, UnknownNameError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import MOTIONS
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_vector, cross
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, piece_effort
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian_of_moves
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.options import Controls

CONTROLS = tuple(str(controls) for controls in Controls)
"""Whether a move turns all joints or one."""
AIMS = ("speed", "efficiency")
"""What a stroke can be made to have most of: displacement per joint travel, or per dissipation (see `atlas`)."""

_YAW_PLANE, _PITCH_PLANE = 2, 1
"""The index of the limb axis that bends turn about, in a plane."""
_FRACTIONS = (0.25, 0.5, 0.75, 1.0)
"""Where on a move the bends of a spatial stroke are limited; in a plane its end is enough."""
_DIFFERENCE_RAD = 1e-5
"""By how much angles are changed for the slope of the effort [rad]: 1e-3 leaves a slope off by 4e-6,
and from 1e-4 to 1e-7 it is off by less than 1e-7."""

_E_X = np.array([1.0, 0.0, 0.0])
"""The axis of a link in its own frame."""


@frozen_dataclass
class DesignTask:
    """What stroke is wanted.

    Along x, y or z the stroke must do nothing else. A turn (roll, pitch, yaw) may advance, since a
    swimmer turns while it travels, but has one axis only.

    Attributes:
        direction: One of `MOTIONS`.
        maximize: One of `AIMS`.
        max_bend_rad: How far a limb may bend from the base's axis [rad].
        planar: Whether all bends are in one plane.
        controls: One of `CONTROLS`.
        moves: How many moves a cycle has.

    Raises:
        UnknownNameError: A name that is none of these.
        ParameterError: A bend limit or number of moves out of range, or a planar roll.
    """

    direction: str = "x"
    maximize: str = "speed"
    max_bend_rad: float = 1.0
    planar: bool = True
    controls: str = "simultaneous"
    moves: int = 12

    def __post_init__(self) -> None:
        for name, known in (("direction", MOTIONS), ("maximize", AIMS), ("controls", CONTROLS)):
            if getattr(self, name) not in known:
                raise UnknownNameError(f"{name}: one of {', '.join(known)} is wanted, found {getattr(self, name)!r}")
        if not 0.0 < self.max_bend_rad <= 3.0:
            raise ParameterError(f"max_bend: an angle above 0 and at most 3 rad is wanted, found {self.max_bend_rad!r}")
        if not 3 <= self.moves <= 64:
            raise ParameterError(f"moves: a whole number at least 3 and at most 64 is wanted, found {self.moves}")
        if self.planar and self.direction == "roll":
            raise ParameterError("direction: one that bends in a plane can move along is wanted, found 'roll'")
        if self.maximize == "efficiency" and self.turns:
            raise ParameterError(f"direction: x, y or z, for efficiency, is wanted, found {self.direction!r}")

    @property
    def own(self) -> int:
        """The index of the direction in a twist."""
        return MOTIONS.index(self.direction)

    @property
    def turns(self) -> bool:
        """Whether the stroke is to turn the swimmer."""
        return self.own >= 3

    @property
    def axis(self) -> int | None:
        """The joints' axis of a planar stroke, None for others."""
        if not self.planar:
            return None
        return _PITCH_PLANE if self.direction in {"z", "pitch"} else _YAW_PLANE

    @property
    def cross(self) -> list[int]:
        """The components of the displacement that must be 0 and are not by symmetry."""
        wanted = [k for k in range(3 if self.turns else 0, 6) if k != self.own]
        in_plane = {None: range(6), _YAW_PLANE: (0, 1, 5), _PITCH_PLANE: (0, 2, 4)}[self.axis]
        return [k for k in wanted if k in in_plane]


@frozen_dataclass(eq=False)
class Values:
    """A stroke's values and their derivatives by the unknowns (last axis).

    Attributes:
        gain: Displacement along the direction [L or rad].
        gain_slope: Its derivative. Shape (n,).
        cost: Joint travel, smoothed, or effort.
        cost_slope: Its derivative. Shape (n,).
        gap: What must be 0: cross-talk [L, rad] and closure [rad]. Shape (k,).
        gap_slope: Its derivative. Shape (k, n).
        room: What must not be negative: room for the bends. Shape (m,).
        room_slope: Its derivative. Shape (m, n).
    """

    gain: float
    gain_slope: Array
    cost: float
    cost_slope: Array
    gap: Array
    gap_slope: Array
    room: Array
    room_slope: Array


@frozen_dataclass(eq=False)
class Problem:
    """The unknowns of a stroke.

    Attributes:
        task: What is wanted.
        swimmer: The swimmer, scaled.
        free: Which turns are unknowns: moves of the approach, then of the cycle. Shape (moves, 6).
        lead: How many moves the approach has.
    """

    task: DesignTask
    swimmer: Swimmer
    free: NDArray[np.bool_]
    lead: int

    @classmethod
    def of(cls, task: DesignTask, swimmer: Swimmer, rng: np.random.Generator) -> Problem:
        """Return the problem; which joint moves when is drawn for spatial strokes of one joint a move."""
        joints = [a + 3 * limb for limb in (0, 1) for a in ((1, 2) if task.axis is None else (task.axis,))]
        if task.controls == "simultaneous":
            lead, free = 1, np.zeros((1 + task.moves, 6), dtype=np.bool_)
            free[0, joints] = True
            for limb in (0, 1):
                free[1:, [3 * limb + a for a in (range(3) if task.axis is None else (task.axis,))]] = True
            return cls(task, swimmer.scaled(), free, lead)
        approach = [*joints, joints[0]]
        if task.axis is None:
            rounds = [rng.permutation(joints) for _ in range(-(-task.moves // len(joints)))]
            cycle = np.concatenate(rounds)[: task.moves].tolist()
        else:
            cycle = [joints[k % 2] for k in range(task.moves)]
        free = np.zeros((len(approach) + task.moves, 6), dtype=np.bool_)
        free[np.arange(len(free)), [*approach, *cycle]] = True
        return cls(task, swimmer.scaled(), free, len(approach))

    def turns(self, unknown: Array) -> Array:
        """Return the turns of approach and cycle [rad]. Shape (moves, 6)."""
        out = np.zeros(self.free.shape)
        out[self.free] = unknown
        return out

    def sequence(self, turns: Array) -> MoveSequence:
        """Return the approach, one cycle, and the approach undone, by turns [rad]. Shape (n, 6)."""
        return MoveSequence.of_turns(np.concatenate([turns, -turns[: self.lead][::-1]]))

    def travel(self, unknown: Array) -> float:
        """Return the joint travel of a cycle by the free turns [rad]. Shape (n,) to ()."""
        return float(np.sum(np.abs(self.turns(unknown)[self.lead :])))

    def at(self, unknown: Array, smooth_rad: float, accuracy: Accuracy = SEARCHING) -> Values:
        """Return the values of the unknowns.

        Args:
            unknown: The free turns [rad]. Shape (n,).
            smooth_rad: The size below which a turn's absolute value is rounded off [rad].
            accuracy: Of the flow.
        """
        turns = self.turns(unknown)
        sequence = self.sequence(turns)
        count = len(turns)
        g, jacobian = flow_and_jacobian_of_moves(self.swimmer, sequence, COLLINEAR, accuracy)
        back = jacobian[:, ::-1][:, : self.lead]
        jacobian = jacobian[:, :count].copy()
        jacobian[:, : self.lead] -= back
        turned = as_vector(g[:3, :3])
        slope = np.concatenate(
            [
                np.einsum("ij,jnk->ink", g[:3, :3], jacobian[:3]),
                np.einsum("ij,jnk->ink", np.linalg.inv(se3.left_jacobian(-turned)), jacobian[3:]),
            ]
        )[:, self.free]
        moved = np.concatenate([g[:3, 3], turned])
        shapes = sequence.shapes(COLLINEAR)
        closure, closure_slope, room, room_slope = (
            self._planar_limits(turns) if self.task.planar else self._spatial_limits(turns, shapes)
        )
        cost, cost_slope = (
            self._effort(unknown) if self.task.maximize == "efficiency" else self._travel(turns, smooth_rad)
        )
        return Values(
            float(moved[self.task.own]),
            slope[self.task.own],
            cost,
            cost_slope,
            np.concatenate([moved[self.task.cross], closure]),
            np.concatenate([slope[self.task.cross], closure_slope]),
            room,
            room_slope,
        )

    def _travel(self, turns: Array, smooth_rad: float) -> tuple[float, Array]:
        """Return the smoothed joint travel of the cycle and its derivative."""
        size = np.sqrt(turns**2 + smooth_rad**2)
        cycle = self.free.copy()
        cycle[: self.lead] = False
        return float(np.sum((size - smooth_rad)[cycle])), np.where(cycle, turns / size, 0.0)[self.free]

    def _effort(self, unknown: Array) -> tuple[float, Array]:
        """Return the cycle's effort and its derivative, by central differences in one batch."""
        steps = _DIFFERENCE_RAD * np.eye(len(unknown))
        tried = np.concatenate([unknown[None], unknown + steps, unknown - steps])
        cycles = [self.turns(u) for u in tried]
        shapes = [MoveSequence.of_turns(t).shapes(COLLINEAR)[self.lead : -1] for t in cycles]
        moves = MoveSequence.of_turns(np.concatenate([t[self.lead :] for t in cycles]))
        each = piece_effort(self.swimmer, Pieces(np.concatenate(shapes), moves.rate, moves.duration))
        effort = each.reshape(len(tried), -1).sum(axis=1)
        n = len(unknown)
        return float(effort[0]), (effort[1 : n + 1] - effort[n + 1 :]) / (2.0 * _DIFFERENCE_RAD)

    def _planar_limits(self, turns: Array) -> tuple[Array, Array, Array, Array]:
        """Return closure and room for the bends, with their derivatives: all linear in the turns."""
        count, axis, lead = len(turns), self.task.axis or 0, self.lead
        joints = [axis, 3 + axis]
        closure_slope = np.zeros((2, count, 6))
        room_slope = np.zeros((count, 2, count, 6))
        for limb, joint in enumerate(joints):
            closure_slope[limb, lead:, joint] = 1.0
            room_slope[:, limb, :, joint] = np.tril(np.ones((count, count)))
        bend = np.cumsum(turns, axis=0)[:, joints].ravel()
        up = room_slope.reshape(2 * count, count, 6)[:, self.free]
        room = np.concatenate([self.task.max_bend_rad - bend, self.task.max_bend_rad + bend])
        closure = np.sum(turns[lead:], axis=0)[joints]
        return closure, closure_slope[:, self.free], room, np.concatenate([-up, up])

    def _spatial_limits(self, turns: Array, shapes: Array) -> tuple[Array, Array, Array, Array]:
        """Return closure and room for the bends (as cosines), with their derivatives."""
        count = len(turns)
        in_base = np.einsum("nlij,nlj->nli", shapes[:count], turns.reshape(count, 2, 3))
        whole = se3.left_jacobian(in_base) @ shapes[:count]
        missed = shapes[count] @ np.swapaxes(shapes[self.lead], -1, -2)
        closure = as_vector(missed)
        by_end = np.linalg.inv(se3.left_jacobian(closure))
        closure_slope = np.zeros((6, count, 6))
        for limb in (0, 1):
            part = slice(3 * limb, 3 * limb + 3)
            seen = np.array([np.eye(3) - missed[limb]] * self.lead + [np.eye(3)] * (count - self.lead))
            closure_slope[part, :, part] = np.moveaxis(by_end[limb] @ seen @ whole[:, limb], 0, 1)
        room, room_slope = [], []
        earlier = np.tril(np.ones((count, count)), -1)
        for fraction in _FRACTIONS:
            axes = (se3.rotation(fraction * in_base) @ shapes[:count])[..., 0]
            lever = cross(axes, np.broadcast_to(_E_X, axes.shape))
            own = fraction * se3.left_jacobian(fraction * in_base) @ shapes[:count]
            slope = np.zeros((count, 2, count, 6))
            for limb in (0, 1):
                part = slice(3 * limb, 3 * limb + 3)
                slope[:, limb, :, part] = np.einsum("vi,kij->vkj", lever[:, limb], whole[:, limb]) * earlier[..., None]
                slope[np.arange(count), limb, np.arange(count), part] = np.einsum(
                    "vi,vij->vj", lever[:, limb], own[:, limb]
                )
            room.append(axes[..., 0].ravel() - np.cos(self.task.max_bend_rad))
            room_slope.append(slope.reshape(2 * count, count, 6)[:, self.free])
        return closure.ravel(), closure_slope[:, self.free], np.concatenate(room), np.concatenate(room_slope)
