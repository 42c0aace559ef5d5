"""The certificate: an independent re-integration of written controls.

Nothing here uses the code that made the plan. The shape is replayed from the controls as written,
the base by scipy's DOP853 on the plain equation g' = -g hat(A(r) omega) with A(r) = P^-1 Q from
`connection`. Left invariance is used, and only where it holds: a segment of control is integrated
again unless one with the same rates, the same duration to the bit and the same shape within
2e-11 rad has been.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.rotations import Array, from_quaternion, hat, running
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.connection import base_twist_rows, resistance
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.verification.extended import extended, product, products, running_products

Rows = np.ndarray[tuple[int, ...], np.dtype[np.int64]]
"""Numbers of rows."""

TOLERANCE_L = 1e-9
"""Position tolerance of an arrival, in units of L."""
TOLERANCE_RAD = 1e-9
"""Angle tolerance of an arrival [rad]."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Care:
    """How carefully segments are integrated.

    Attributes:
        relative: Relative tolerance of DOP853.
        absolute: Absolute tolerance.
        part: How long pieces are, in units of `_PIECE_RAD` and `_PIECE`: so short that a step or two will do.
    """

    relative: float
    absolute: float
    part: float


_USUAL, _MORE = _Care(1e-12, 1e-13, 1.0), _Care(1e-13, 1e-14, 0.6)
"""More care is taken of long repetitions, whose errors grow with their square."""
_LONG = 10
"""A motion with more than this many times as many segments as distinct ones is a long repetition."""
_SAME_SHAPE_DIGITS = 11
"""Decimal places to which two shapes are the same, as quaternions, and their segment is integrated once.

A hundredth of the tolerances. With 13, rounding makes a thousand cycles of a curve seven times as many segments."""

_COARSE_RAD = 0.2
"""Longest pieces whose distance from the straight line is measured, at both ends [rad]."""
_PIECE_RAD, _PIECE = 0.05, 0.09
"""Longest pieces: an angle, and a part of the distance from the straight line, where A(r) is sharp.

So short that DOP853 keeps its tolerance in one step or two: long rows in few steps cost the least."""
_BATCH = 1024
"""Pieces solved as one system: bounds the memory of a long path."""


@dataclasses.dataclass(frozen=True, slots=True)
class Certificate:
    """What the re-integration of a motion found.

    Attributes:
        reached: Whether the goal is met within the tolerances.
        deviation: How far the replayed end is from the goal.
        tolerance_m: Position tolerance [m].
        tolerance_rad: Angle tolerance [rad].
        segments: How many segments of constant control there are.
        integrated: How many of them had to be integrated; the rest repeat those.
    """

    reached: bool
    deviation: Deviation
    tolerance_m: float
    tolerance_rad: float
    segments: int
    integrated: int


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """A motion replayed from its controls alone.

    Attributes:
        row: The row at which each segment of control begins, and the last row. Shape (m + 1,).
        begun: The configuration at the first.
        turned: How the limbs are turned since, as quaternions (w, x, y, z). Shape (m + 1, 2, 4).
        moves: Its displacements on the segments that were integrated [m], in extended precision. Shape (k, 4, 4).
        which: Which of them each segment makes. Shape (m,).
    """

    row: Rows
    begun: Configuration
    turned: Array
    moves: Array
    which: Rows

    @property
    def shape(self) -> Array:
        """The limbs' orientations where segments begin, and at the end. Shape (m + 1, 2, 3, 3)."""
        return _shapes(self.begun.shape, self.turned)

    @property
    def pose(self) -> Array:
        """The base's poses where segments begin, and at the end [m]. Shape (m + 1, 4, 4)."""
        return running_products(extended(self.begun.pose), self.moves[self.which]).astype(np.float64)

    @property
    def end(self) -> Configuration:
        """The configuration at the end."""
        pose = self.begun.pose @ product(self.moves, self.which)
        return Configuration(pose.astype(np.float64), _shapes(self.begun.shape, self.turned[-1]))


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
    turned = _turned(rates, durations)
    same = np.round(turned[:-1].reshape(len(rates), 8), _SAME_SHAPE_DIGITS) + 0.0
    first, which = _distinct(np.concatenate([same, rates, durations[:, None]], axis=1))
    care = _MORE if len(rates) > _LONG * len(first) else _USUAL
    begun = _shapes(start.shape, turned[first])
    return Replay(row, start, turned, _integrate(swimmer, begun, rates[first], durations[first], care), which)


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
    return Certificate(reached, deviation, tolerance_m, tolerance_rad, len(found.row) - 1, len(found.moves))


def _turned(rates: Array, durations: Array) -> Array:
    """Return how limbs are turned before, between and after segments, as quaternions. Shape (m + 1, 2, 4)."""
    half = 0.5 * rates.reshape(-1, 2, 3) * durations[:, None, None]
    size = np.sqrt(np.einsum("...i,...i->...", half, half))[..., None]
    each = np.zeros((len(rates) + 1, 2, 4))
    each[0, :, 0] = 1.0
    each[1:] = np.concatenate([np.cos(size), half * np.sinc(size / np.pi)], axis=-1)
    # w + x i + y j + z k as the complex numbers (w + x i, y + z i).
    out = running(each.view(np.complex128), _hamilton).view(np.float64)
    return np.asarray(out / np.sqrt(np.einsum("...i,...i->...", out, out))[..., None])


def _shapes(start: Array, turned: Array) -> Array:
    """Return shapes that are turned since a first one, by quaternions (w, x, y, z). Shape (..., 2, 3, 3)."""
    return np.asarray(start @ from_quaternion(turned))


def _hamilton(p: NDArray[np.complex128], q: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the products of quaternions a + b j, as pairs of complex numbers a, b. Shape (..., 2)."""
    (a, b), (c, d) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    return np.stack([a * c - b * d.conj(), a * d + b * c.conj()], axis=-1)


def _distinct(keys: Array) -> tuple[Rows, Rows]:
    """Return the first of every distinct row, and which of them each row is; rows are compared bit by bit."""
    words = np.ascontiguousarray(keys).view(np.uint64)
    mix = np.random.default_rng(0).integers(0, 2**64, words.shape[1], dtype=np.uint64) | np.uint64(1)
    spread = (words ^ (words >> np.uint64(32))) * mix
    _, first, which = np.unique(spread.sum(axis=1, dtype=np.uint64), return_index=True, return_inverse=True)
    if not np.array_equal(words[first][which], words):  # two rows share a sum: compare them whole
        _, first, which = np.unique(words, axis=0, return_index=True, return_inverse=True)
    return first, which.ravel()


def _cut(parts: Rows) -> tuple[Rows, Rows]:
    """Return, for things cut into parts, which one each part is of, and its number in it."""
    owner = np.repeat(np.arange(len(parts)), parts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)


def _distance(unit: Swimmer, shapes: Array) -> Array:
    """Return how far shapes are from where A(r) is sharp, as a bend [rad]: there P has a small eigenvalue."""
    least = np.linalg.eigvalsh(resistance(unit, shapes))[:, 0]
    return np.asarray(np.sqrt(np.maximum(least, 0.0) / (unit.lateral_drag() * unit.bend_spread())))


class _Turning:
    """Limbs that turn at constant rates, each about an axis that is fixed in the base: u = A omega.

    Attributes:
        rate: Their rates in base coordinates. Shape (2, 3, m).

    Args:
        shapes: Shapes at time 0. Shape (m, 2, 3, 3).
        rates: Limb rates. Shape (m, 6).
    """

    def __init__(self, shapes: Array, rates: Array) -> None:
        turn = (shapes @ rates.reshape(-1, 2, 3, 1))[..., 0]
        speed = np.linalg.norm(turn, axis=-1, keepdims=True)
        about, axes = hat(turn / np.where(speed > 0.0, speed, 1.0)), shapes[..., :1]
        self._speed, self._shapes, self._about = speed, shapes, about
        self.rate = np.ascontiguousarray(turn.transpose(1, 2, 0))
        self._rows = [np.ascontiguousarray(x[..., 0].transpose(1, 2, 0)) for x in (axes, about @ axes)]
        self._rows.append(np.ascontiguousarray((about @ about @ axes)[..., 0].transpose(1, 2, 0)))
        self._speed_rows = np.ascontiguousarray(speed.transpose(1, 2, 0))

    def axes(self, time: Array) -> Array:
        """Return the limbs' axes at times. Shapes (k, m) to (2, 3, k, m)."""
        angle = self._speed_rows[:, :, None] * time
        first, across, about = (rows[:, :, None] for rows in self._rows)
        return np.asarray(first + np.sin(angle) * across + (1.0 - np.cos(angle)) * about)

    def shapes(self, time: Array) -> Array:
        """Return the shapes R A at times, R = 1 + sin(w t) hat(n) + (1 - cos(w t)) hat(n)^2. Shape (m, 2, 3, 3)."""
        angle = (self._speed * time[:, None, None])[..., None]
        turned = np.sin(angle) * self._about + (1.0 - np.cos(angle)) * (self._about @ self._about)
        return np.asarray(self._shapes + turned @ self._shapes)


def _integrate(swimmer: Swimmer, shapes: Array, rates: Array, durations: Array, care: _Care) -> Array:
    """Return the displacements of segments of constant control by DOP853 [m]. Shape (m, 4, 4).

    Long segments are cut into pieces so short that one step or two will do.
    """
    if not len(durations):
        return np.empty((0, 4, 4))
    unit = swimmer.scaled()
    sweep = np.linalg.norm(rates, axis=1) * durations
    parts = np.maximum(np.ceil(sweep / _COARSE_RAD), 1).astype(np.int64)
    owner, index = _cut(parts)
    length = (durations / parts)[owner]
    turning = _Turning(shapes[owner], rates[owner])
    ends = [turning.shapes(k * length) for k in (index, index + 1)]
    # Where a piece comes near the straight line it is cut again.
    near = np.minimum(_distance(unit, ends[0]), _distance(unit, ends[1]))
    longest = care.part * np.minimum(_PIECE * near, _PIECE_RAD)
    again = np.maximum(np.ceil((sweep / parts)[owner] / longest), 1).astype(np.int64)
    whole, index = _cut(again)
    owner, length = owner[whole], (length / again)[whole]
    begun = _Turning(ends[0][whole], rates[owner]).shapes(index * length)
    pieces = extended(np.tile(np.eye(4), (len(owner), 1, 1)))
    for low in range(0, len(owner), _BATCH):
        some = slice(low, low + _BATCH)
        pieces[some, :3] += _integrate_pieces(unit, _Turning(begun[some], rates[owner[some]]), length[some], care)
    out = products(pieces, np.bincount(owner, minlength=len(parts)))
    out[:, :3, 3] *= swimmer.length_m
    return out


def _integrate_pieces(unit: Swimmer, turning: _Turning, length: Array, care: _Care) -> Array:
    """Return by how much the displacements of pieces differ from none. Shape (n, 3, 4).

    Args:
        unit: The swimmer, scaled to L = 1.
        turning: The limbs' turning on each piece.
        length: How long each piece lasts. Shape (n,).
        care: How carefully.
    """
    from scipy.integrate import DOP853, solve_ivp

    n = len(length)
    identity = np.eye(3)[:, :, None]
    known: dict[float, Array] = {}

    def twists(part: Array) -> Array:
        """Return xi at parts of the pieces, times their length. Shape (6, k, n)."""
        axes = turning.axes(part[:, None] * length).reshape(2, 3, -1)
        rate = np.broadcast_to(turning.rate[:, :, None], (2, 3, len(part), n)).reshape(2, 3, -1)
        return np.asarray(base_twist_rows(unit, axes, rate).reshape(6, len(part), n) * length)

    def plain_equation(part: float, state: Array) -> Array:
        if part not in known:
            # xi depends on time alone: the nodes of a first step over the whole piece are evaluated at once.
            parts = np.unique([0.0, *DOP853.C, 1.0]) if not known else np.array([part])
            known.update(zip(parts.tolist(), twists(parts).swapaxes(0, 1), strict=True))
        xi = known[part]
        rotation, out = state.reshape(4, 3, n)[:3] + identity, np.empty((4, 3, n))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            out[i] = xi[3 + k] * rotation[j] - xi[3 + j] * rotation[k]
        out[3] = xi[0] * rotation[0] + xi[1] * rotation[1] + xi[2] * rotation[2]
        return out.ravel()

    # The state is what differs from the identity, column by column, then the position: small numbers
    # lose less, and are put together in extended precision. Errors of a cycle's heading grow with n^2.
    control = {"rtol": care.relative, "atol": care.absolute, "first_step": 1.0}
    solved = solve_ivp(plain_equation, (0.0, 1.0), np.zeros(12 * n), method="DOP853", **control)
    return np.asarray(solved.y[:, -1].reshape(4, 3, n).transpose(2, 1, 0))
