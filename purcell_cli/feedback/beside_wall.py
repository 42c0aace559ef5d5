"""The motion of a swimmer beside a wall, integrated in the world, where a wall breaks left invariance.

The integrator is Dormand and Prince's of order 8 with step control (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, II.5), on position and rotation matrix; each stage solves the beads anew. Conventions:
`rotations`.
"""

from __future__ import annotations

import itertools

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, hat
from purcell_cli.mechanics.beads import LOWER, resistance_entries, rooms
from purcell_cli.mechanics.drag import LINKS
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import Wall

_ERROR = 1e-9
"""Error of a step [L, rad]: a whole plan is then off by some 1e-8 L, far below any tolerance."""
_LEAST_RTOL = 1e-12
"""Relative error of a step: none beside the above, but not so little that the integrator warns."""


def twist_beside(unit: Swimmer, axes: Array, turning: Array, beside: Array) -> Array:
    """Return the base's body twist beside a wall, from the beads themselves.

    Args:
        unit: The swimmer, scaled to L = 1.
        axes: The limbs' axes in base coordinates. Shape (2, 3).
        turning: The limbs' rates in base coordinates [rad/s]. Shape (2, 3).
        beside: How it sees the wall (`Wall.beside`), clear of all beads. Shape (4,).

    Returns:
        (v, omega) [L/s, rad/s]. Shape (6,).
    """
    row, column = LOWER
    full = np.empty((12, 12))
    full[row, column] = full[column, row] = resistance_entries(unit, axes, beside)
    return np.asarray(-solve(full[:6, :6], matmul(full[:6, 6:], turning.ravel())))


class _Segment:
    """A part of a motion on which both limbs turn at constant rates.

    Args:
        unit: The swimmer, scaled to L = 1, beside its wall.
        shape: The shape at the beginning. Shape (2, 3, 3).
        rate: The limbs' rates [rad/s]. Shape (6,).
        stream: The velocity of the stream [L/s]. Shape (3,).
    """

    def __init__(self, unit: Swimmer, wall: Wall, shape: Array, rate: Array, stream: Array) -> None:
        self.unit, self.wall, self.stream = unit, wall, stream
        self.turning = np.stack([matmul(shape[k], rate[3 * k : 3 * k + 3]) for k in (0, 1)])
        self.begun = shape[..., 0]

    def axes(self, time: float) -> Array:
        """Return the limbs' axes at a time since the beginning. Shape (2, 3)."""
        return np.asarray(matmul(se3.rotation(self.turning * time), self.begun[..., None])[..., 0])

    def rooms(self, time: float, state: Array) -> Array:
        """Return how far the links are from the wall [L]. Shape (3,)."""
        return rooms(self.unit, self.axes(time), self.wall.beside(_pose(state)))

    def slope(self, time: float, state: Array) -> Array:
        """Return the derivative of a pose, not numbers where a link reaches into the wall. Shape (12,).

        The integrator then makes its step smaller, until that is as small as can be.
        """
        pose, axes = _pose(state), self.axes(time)
        beside = self.wall.beside(pose)
        if not np.min(rooms(self.unit, axes, beside)) > 0.0:
            return np.full(12, np.nan)
        xi = twist_beside(self.unit, axes, self.turning, beside)
        turned = matmul(pose[:3, :3], np.column_stack([xi[:3], hat(xi[3:])]))
        turned[:, 0] += self.stream
        return np.asarray(turned.T.ravel())

    def states(self, begun: Array, times: Array, step: float | None) -> tuple[Array, float | None]:
        """Return the states at times since the beginning, and the last step's size.

        Args:
            begun: The pose at the beginning: position [L] and the rotation's columns. Shape (12,).
            times: Times, the last one the end. Shape (n,).
            step: The size of the first step, where there is a guess.

        Raises:
            _TouchError: A link touches the wall.
        """
        from scipy.integrate import DOP853  # slow to import

        if not np.min(room := self.rooms(0.0, begun)) > 0.0:
            raise _TouchError(room, 0.0)
        last = float(times[-1])
        if not last > 0.0:  # a turn so small that no time shows it
            return np.tile(begun, (len(times), 1)), step
        first = None if step is None else min(step, last)
        solver = DOP853(self.slope, 0.0, begun, last, first_step=first, rtol=_LEAST_RTOL, atol=_ERROR)
        out, done = np.empty((len(times), 12)), 0
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise _TouchError(self.rooms(solver.t, solver.y), float(solver.t))
            inside = int(np.searchsorted(times, solver.t))
            if inside > done:
                out[done:inside] = solver.dense_output()(times[done:inside]).T
            done = inside
        out[-1] = solver.y
        return out, float(solver.step_size)


def _pose(state: Array) -> Array:
    """Return the pose of a position and a rotation's columns. Shape (12,) to (4, 4)."""
    return se3.pose(state[3:].reshape(3, 3).T, state[:3])


class _TouchError(Exception):
    """A link touches the wall: that of the least room [L], so long after the segment's beginning [s]."""

    def __init__(self, room: Array, time: float) -> None:
        self.link, self.time = LINKS[int(np.argmin(room))].replace("limb", "limb "), time
        super().__init__(self.link)


def poses_beside(swimmer: Swimmer, wall: Wall, begun: Array, pieces: Pieces, stream: Array) -> Array:
    """Return the base's poses before, between and after pieces of constant limb rates.

    Args:
        swimmer: The swimmer.
        wall: The wall.
        begun: The base's pose at the beginning [m]. Shape (4, 4).
        pieces: The pieces, in order.
        stream: The velocity of a stream that carries the swimmer along [m/s]. Shape (3,).

    Returns:
        Shape (n + 1, 4, 4).

    Raises:
        ParameterError: A link touches the wall; the message says which, when, and in which row.
    """
    unit, length = swimmer.scaled(), swimmer.length_m
    plane = wall.scaled(length)
    states = np.empty((len(pieces) + 1, 12))
    states[0, :3], states[0, 3:] = begun[:3, 3] / length, begun[:3, :3].T.ravel()
    ends = np.cumsum(pieces.durations)
    changes = np.flatnonzero(np.any(np.diff(pieces.rates, axis=0) != 0.0, axis=1)) + 1
    step: float | None = None
    for low, high in itertools.pairwise([0, *changes.tolist(), len(pieces)]):
        begins = float(ends[low] - pieces.durations[low])
        times = ends[low:high] - begins
        segment = _Segment(unit, plane, pieces.shapes[low], pieces.rates[low], stream / length)
        try:
            states[low + 1 : high + 1], step = segment.states(states[low], times, step)
        except _TouchError as touch:
            row, at = low + int(np.searchsorted(times, touch.time, side="right")) + 1, begins + touch.time
            raise ParameterError(
                f"wall: links clear of it all the way are wanted, found {touch.link} at it in row {row} ({at:.6g} s)"
            ) from touch
        states[high, 3:] = se3.normalised(_pose(states[high]))[:3, :3].T.ravel()
    out = se3.normalised(np.stack([_pose(state) for state in states]))
    out[:, :3, 3] *= length
    out[0] = begun
    return out
