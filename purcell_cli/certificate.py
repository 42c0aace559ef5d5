"""The certificate: an independent re-integration of written controls.

Nothing here uses the code that made the plan. The shape is replayed from the controls as written,
the base by scipy's DOP853 on the plain equation g' = -g hat(A(r) omega) with A(r) = P^-1 Q from
`connection`. Left invariance is used, and only where it holds: a stretch of control is integrated
again unless one with the same rates, the same duration to the bit and the same shape within
1e-11 rad has been.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.configuration import Configuration, Deviation
from purcell_cli.connection import base_twist, resistance
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer

Rows = np.ndarray[tuple[int, ...], np.dtype[np.int64]]
"""Numbers of rows."""

TOLERANCE_L = 1e-9
"""Position tolerance of an arrival, in units of L."""
TOLERANCE_RAD = 1e-9
"""Angle tolerance of an arrival [rad]."""

_RELATIVE, _ABSOLUTE = 1e-13, 1e-14
_SAME_SHAPE_DIGITS = 11
_PIECE_RAD, _PIECE = 0.2, 0.5
"""Longest pieces: an angle, and a part of the distance from the straight line, where A(r) is sharp."""


@dataclasses.dataclass(frozen=True, slots=True)
class Certificate:
    """What the re-integration of a motion found.

    Attributes:
        reached: Whether the goal is met within the tolerances.
        deviation: How far the replayed end is from the goal.
        tolerance_m: Position tolerance [m].
        tolerance_rad: Angle tolerance [rad].
        stretches: How many stretches of constant control there are.
        integrated: How many of them had to be integrated; the rest repeat those.
    """

    reached: bool
    deviation: Deviation
    tolerance_m: float
    tolerance_rad: float
    stretches: int
    integrated: int


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """A motion replayed from its controls alone.

    Attributes:
        row: The row at which each stretch of control begins, and the last row. Shape (m + 1,).
        pose: The base's pose there [m]. Shape (m + 1, 4, 4).
        shape: The limbs' orientations there. Shape (m + 1, 2, 3, 3).
        integrated: How many stretches were integrated.
    """

    row: Rows
    pose: Array
    shape: Array
    integrated: int

    @property
    def end(self) -> Configuration:
        """The configuration at the end."""
        return Configuration(self.pose[-1], self.shape[-1])


def replay(swimmer: Swimmer, start: Configuration, time_s: Array, rate_rad_s: Array, every_row: bool = False) -> Replay:
    """Replay controls from a start configuration.

    Args:
        swimmer: The swimmer.
        start: The configuration at the first time.
        time_s: Times [s]. Shape (n,).
        rate_rad_s: Limb rates, each holding until the next time; the last is not used. Shape (n, 6).
        every_row: Whether to stop at every row, not only where the control changes.
    """
    changed = np.any(rate_rad_s[1:-1] != rate_rad_s[:-2], axis=1) | every_row
    changes = np.flatnonzero(changed) + 1
    row = np.concatenate([[0], changes, [len(time_s) - 1]]) if len(time_s) > 1 else np.array([0])
    rates, durations = rate_rad_s[row[:-1]], np.diff(time_s[row])
    shapes = _shapes(start.shape, rates, durations)
    keys = np.concatenate(
        [np.round(shapes[:-1].reshape(len(rates), 18), _SAME_SHAPE_DIGITS) + 0.0, rates, durations[:, None]], axis=1
    )
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    moves = _integrate(swimmer, shapes[:-1][first], rates[first], durations[first])
    pose = np.empty((len(row), 4, 4))
    pose[0] = start.pose
    for k, j in enumerate(which.ravel()):
        pose[k + 1] = pose[k] @ moves[j]
    return Replay(row, pose, shapes, len(first))


def certify(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    time_s: Array,
    rate_rad_s: Array,
    tolerance_l: float = TOLERANCE_L,
    tolerance_rad: float = TOLERANCE_RAD,
) -> Certificate:
    """Return whether controls, as written, carry the swimmer from start to goal.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        time_s: Times [s]. Shape (n,).
        rate_rad_s: Limb rates, each holding until the next time. Shape (n, 6).
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
    """
    found = replay(swimmer, start, time_s, rate_rad_s)
    return judged(found, goal, tolerance_l * swimmer.length_m, tolerance_rad)


def judged(found: Replay, goal: Configuration, tolerance_m: float, tolerance_rad: float) -> Certificate:
    """Return whether a replayed motion ends at a goal, within tolerances [m] and [rad]."""
    deviation = Deviation.between(found.end, goal)
    reached = deviation.within(tolerance_m, tolerance_rad)
    return Certificate(reached, deviation, tolerance_m, tolerance_rad, len(found.row) - 1, found.integrated)


def _shapes(start: Array, rates: Array, durations: Array) -> Array:
    """Return the shapes at the ends of stretches, by scipy's rotations. Shape (m + 1, 2, 3, 3)."""
    from scipy.spatial.transform import Rotation

    turns = [Rotation.from_rotvec(rates[:, 3 * i : 3 * i + 3] * durations[:, None]).as_quat() for i in (0, 1)]
    out = np.empty((len(rates) + 1, 2, 3, 3))
    for i in (0, 1):
        quaternions = np.empty((len(rates) + 1, 4))
        here = Rotation.from_matrix(start[i]).as_quat()
        quaternions[0] = here
        for k, turn in enumerate(turns[i]):
            if turn[:3].any():
                here = _hamilton(here, turn)
            quaternions[k + 1] = here
        out[:, i] = Rotation.from_quat(quaternions).as_matrix()
    out[0] = start
    return out


def _hamilton(p: Array, q: Array) -> Array:
    """Return the product of two quaternions (x, y, z, w), normalised."""
    ax, ay, az, aw = p.tolist()
    bx, by, bz, bw = q.tolist()
    out = np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )
    return np.asarray(out / np.sqrt(out @ out))


def _cut(parts: Rows) -> tuple[Rows, Rows]:
    """Return, for things cut into parts, which one each part is of, and its number in it."""
    owner = np.repeat(np.arange(len(parts)), parts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)


def _turned(shapes: Array, rates: Array, times: Array) -> Array:
    """Return shapes after times at constant rates, by scipy's rotations. Shape (n, 2, 3, 3)."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_rotvec((rates * times[:, None]).reshape(-1, 3)).as_matrix()
    return np.asarray(shapes @ turns.reshape(-1, 2, 3, 3))


def _distance(unit: Swimmer, shapes: Array) -> Array:
    """Return how far shapes are from where A(r) is sharp, as a bend [rad]: there P has a small eigenvalue."""
    least = np.linalg.eigvalsh(resistance(unit, shapes))[:, 0]
    return np.asarray(np.sqrt(np.maximum(least, 0.0) / (unit.lateral_drag() * unit.bend_spread())))


def _integrate(swimmer: Swimmer, shapes: Array, rates: Array, durations: Array) -> Array:
    """Return the displacements of stretches of constant control by DOP853 [m]. Shape (m, 4, 4).

    Long stretches are cut, so that all pieces can be solved as one system with few steps.
    """
    from scipy.integrate import solve_ivp

    if not len(durations):
        return np.empty((0, 4, 4))
    unit = swimmer.scaled()
    sweep = np.linalg.norm(rates, axis=1) * durations
    parts = np.maximum(np.ceil(sweep / _PIECE_RAD), 1).astype(np.int64)
    owner, index = _cut(parts)
    length = (durations / parts)[owner]
    begun = _turned(shapes[owner], rates[owner], index * length)
    # Where a piece comes near the straight line it is cut again.
    near = np.minimum(_distance(unit, begun), _distance(unit, _turned(begun, rates[owner], length)))
    again = np.maximum(np.ceil((sweep / parts)[owner] / (_PIECE * near)), 1).astype(np.int64)
    whole, index = _cut(again)
    owner, length = owner[whole], (length / again)[whole]
    begun = _turned(begun[whole], rates[owner], index * length)
    parts = np.bincount(owner, minlength=len(parts))
    n = len(owner)

    def plain_equation(part: float, state: Array) -> Array:
        g = state.reshape(n, 3, 4)
        xi = base_twist(unit, _turned(begun, rates[owner], part * length), rates[owner]) * length[:, None]
        hat = np.zeros((n, 4, 4))
        hat[:, 0, 1], hat[:, 0, 2], hat[:, 1, 2] = -xi[:, 5], xi[:, 4], -xi[:, 3]
        hat[:, 1, 0], hat[:, 2, 0], hat[:, 2, 1] = xi[:, 5], -xi[:, 4], xi[:, 3]
        hat[:, :3, 3] = xi[:, :3]
        return np.asarray((g @ hat).ravel())

    rest = np.tile(np.eye(4)[:3].ravel(), n)
    solved = solve_ivp(plain_equation, (0.0, 1.0), rest, method="DOP853", rtol=_RELATIVE, atol=_ABSOLUTE, t_eval=[1.0])
    pieces = np.tile(np.eye(4), (n, 1, 1))
    pieces[:, :3] = solved.y[:, -1].reshape(n, 3, 4)
    out = np.tile(np.eye(4), (len(parts), 1, 1))
    for j in range(int(parts.max())):
        live = parts > j
        out[live] = out[live] @ pieces[(np.cumsum(parts) - parts)[live] + j]
    out[:, :3, 3] *= swimmer.length_m
    return out
