"""The replay of a motion from its controls alone.

The shape is replayed as written, the base by `extrapolation`, all in extended precision where the machine has
it. Left invariance is used, and only where it holds: a segment of control is integrated again unless one with
the same rates, the same duration to the bit and almost the same shape has been; what the little difference of
shape makes is added to first order. Segments that come again and again, to the bit, are looked at once.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.rotations import Array, hat
from purcell_cli.kernel import certificate
from purcell_cli.mechanics.bead_table import tabulated
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.verification.extended import Real, extended, product, running_products
from purcell_cli.verification.extrapolation import Displacements, Resistances, Rows, segment_displacements
from purcell_cli.verification.limb_rotations import once, rotation_between, shapes_of, turned_along

TOLERANCE_L = 1e-9
"""Position tolerance of an arrival, in units of L."""
TOLERANCE_RAD = 1e-9
"""Angle tolerance of an arrival [rad]."""

_SAME_SHAPE_DIGITS = 9
"""Decimal places to which two shapes are almost the same, as quaternions, and their segment is integrated once.

What the difference makes is known to first order: the second is below 1e-15 rad even where A(r) is sharpest."""
_DRIFT_COUNTS, _SHARPEST = 1e-12, 100.0
"""Differences of shape are looked at where they could turn the base by more than this [rad] in all, if each radian of a
segment turned it by this many times its difference: A(r) varies over bends of some 0.01 rad and more."""
_DRIFT_STEP = 1e-5
"""Turn of a limb by which displacements are differenced [rad]: errors of 1e-7 of the first order."""
_Cares = tuple[tuple[type[np.floating[Any]], float], ...]
_CARES: _Cares = ((np.float64, 1.0), (np.longdouble, 1.4), (np.longdouble, 0.6), (np.longdouble, 0.3))
"""The precision of the numbers, and the length of pieces in units of the usual length: one after the other, until the
bound is small. Twice the digits take three times as long. Two in one precision measure rounding."""
_SLOW_CARES: _Cares = ((np.float64, 1.0), (np.float64, 0.6), (np.longdouble, 0.6), (np.longdouble, 0.3))
"""The same for links that feel each other, where extended precision takes seven times as long as doubles."""
_OFTEN = 60
"""Where a segment comes so often, doubles would not do and are left out."""
_SMALL = 0.1
"""A bound below this part of the tolerance is small."""
_LEFT = 0.04
"""Extended precision is for the segments that rounding turns most: what the others add is below this part of the
tolerance, which leaves those more than half of what is small: one integration of them is enough for a thousand L."""
_BATCH = 1 << 14
"""Segments that are put together at once: bounds the memory of a long motion."""


@frozen_dataclass(slots=False, eq=False)
class Replay:
    """A motion replayed from its controls alone; all in extended precision where nothing else is said.

    Attributes:
        row: The row at which each segment of control begins, and the last row. Shape (m + 1,).
        begun_pose: The base's pose at the first [m]. Shape (4, 4).
        begun_shape: The limbs' orientations at the first. Shape (2, 3, 3).
        turned: How the limbs are turned since, here and there, as quaternions (w, x, y, z). Shape (k, 2, 4).
        begun: Which of these each segment begins at, and the last ends at. Shape (m + 1,).
        moves: Its displacements on the segments that were integrated.
        which: Which of them each segment makes. Shape (m,).
        drift: What each segment makes besides, since its shape is a little another: body twists at its end [m, rad],
            in double precision; none where that is too little to count. Shape (m, 6), or (0, 6).
        length_m: The swimmer's L [m].
    """

    row: Rows
    begun_pose: Real
    begun_shape: Real
    turned: Real
    begun: Rows
    moves: Displacements
    which: Rows
    drift: Array
    length_m: float

    @functools.cached_property
    def shape(self) -> Array:
        """The limbs' orientations where segments begin, and at the end, in double precision. Shape (m + 1, 2, 3, 3)."""
        return shapes_of(self.begun_shape.astype(np.float64), self.turned.astype(np.float64))[self.begun]

    @property
    def end_shape(self) -> Real:
        """The limbs' orientations at the end. Shape (2, 3, 3)."""
        return shapes_of(self.begun_shape, self.turned[self.begun[-1]])

    @functools.cached_property
    def pose(self) -> Array:
        """The base's poses where segments begin, and at the end, in double precision [m]. Shape (m + 1, 4, 4)."""
        out = np.empty((len(self.which) + 1, 4, 4))
        here, out[0] = self.begun_pose, self.begun_pose
        turn = push = np.zeros(3)
        for low in range(0, len(self.which), _BATCH):
            some = slice(low, low + _BATCH)
            pose = running_products(here, self.moves.fine[self.which[some]])[1:]
            here = pose[-1].copy()
            if len(self.drift):
                # Seen from where the motion begins, the small twists add up, and each moves all that comes after it.
                away, rotation = (pose[:, :3, 3] - self.begun_pose[:3, 3]).astype(np.float64), pose[:, :3, :3]
                turned = np.einsum("kij,kj->ki", rotation, self.drift[some, 3:]).astype(np.float64)
                pushed = np.einsum("kij,kj->ki", rotation, self.drift[some, :3]) + np.cross(away, turned)
                turns, pushes = turn + np.cumsum(turned, axis=0), push + np.cumsum(pushed, axis=0)
                turn, push = turns[-1], pushes[-1]
                pose[:, :3, 3] += pushes + np.cross(turns, away)
                pose[:, :3, :3] += hat(turns) @ rotation
            out[1:][some] = pose
        return out

    @functools.cached_property
    def end_pose(self) -> Real:
        """The base's pose at the end [m]. Shape (4, 4)."""
        if len(self.drift):
            return extended(self.pose[-1])
        return np.asarray(self.begun_pose @ self._moved[0])

    @functools.cached_property
    def _moved(self) -> Real:
        """The base's displacement from the first pose to the last, and that before the last extrapolation."""
        return product(np.stack([self.moves.fine, self.moves.rough], axis=1), self.which)

    def until(self, segment: int) -> Replay:
        """Return the replay up to where a segment begins."""
        return dataclasses.replace(
            self,
            row=self.row[: segment + 1],
            begun=self.begun[: segment + 1],
            which=self.which[:segment],
            drift=self.drift[:segment],
        )

    @property
    def end(self) -> Configuration:
        """The configuration at the end."""
        return Configuration(self.end_pose.astype(np.float64), self.end_shape.astype(np.float64))

    @functools.cached_property
    def bound(self) -> Deviation:
        """By how much the end may be wrong: what the last extrapolation changed there, and all rounding together."""
        return self._bounded(self._reach)

    def _bounded(self, reach: Array) -> Deviation:
        """Return the bound, for a reach that is known well enough."""
        rounded, (fine, rough) = self._rounded(reach), self._moved
        away, turned = rough[:3, 3] - fine[:3, 3], rough[:3, :3] - fine[:3, :3]
        return Deviation(
            float(np.sqrt(np.sum(away * away)) + rounded.position_m),
            float(np.sqrt(0.5 * np.sum(turned * turned)) + rounded.base_rad),
            0.0,
            0.0,
        )

    def _rounded(self, reach: Array) -> Deviation:
        """Return by how much the end may be wrong by rounding alone."""
        away, turned = np.sum(self.moves.rounding * reach, axis=1).tolist()
        return Deviation(away, turned, 0.0, 0.0)

    @functools.cached_property
    def _reach(self) -> Array:
        """What turns of each displacement by 1 rad, wherever it is made, move [m] and turn the end by. Shape (2, k).

        Each moves the end by how far it is from there, and by L: by that alone at the end.
        """
        return certificate.reach(self.moves.fine.astype(np.float64), self.which, self.length_m)

    def rounded_most(self, reach: Array, left_m: float, left_rad: float) -> Rows:
        """Return which displacements rounding turns most, so many that the others move the end by no more than this.

        Args:
            reach: What small turns of each move the end by [m], and how often each is made. Shape (2, k).
            left_m: How far the others may move the end [m].
            left_rad: How far they may turn it [rad].
        """
        out = np.zeros(len(self.moves.rounding), dtype=np.bool_)
        for weight, most in zip(reach, (left_m, left_rad), strict=True):
            each = weight * self.moves.rounding
            order = np.argsort(each, kind="stable")
            out[order[np.count_nonzero(np.cumsum(each[order]) <= most) :]] = True
        return np.flatnonzero(out)


def replay(
    swimmer: Swimmer,
    start: Configuration | Replay,
    time_s: Array,
    rate_rad_s: Array,
    every_row: bool = False,
    tolerance_l: float = TOLERANCE_L,
    tolerance_rad: float = TOLERANCE_RAD,
    resistances: Resistances = tabulated,
) -> Replay:
    """Replay controls from a start configuration, with so much care that the bound is small against the tolerances.

    What cannot be had so well is returned as well as it can be; its bound says how well that is.

    Args:
        swimmer: The swimmer.
        start: The configuration at the first time, or what was replayed up to then.
        time_s: Times [s]. Shape (n,).
        rate_rad_s: Limb rates, each holding until the next time; the last is not used [rad/s]. Shape (n, 6).
        every_row: Whether to stop at every row, not only where the control changes.
        tolerance_l: Of the base's position at the end, in units of L.
        tolerance_rad: Of the base's orientation at the end [rad].
        resistances: Of links that feel each other: from their table, or from the beads themselves.
    """
    changed = np.any(rate_rad_s[1:-1] != rate_rad_s[:-2], axis=1) | every_row
    changes = np.flatnonzero(changed) + 1
    row = np.concatenate([[0], changes, [len(time_s) - 1]]) if len(time_s) > 1 else np.array([0])
    rates, durations = rate_rad_s[row[:-1]], np.diff(time_s[row])
    if isinstance(start, Replay):
        pose, shape = start.end_pose, start.end_shape
    else:
        pose, shape = extended(start.pose), extended(start.shape)
    kept, place = once(rates, durations)
    rates, durations = rates[kept], durations[kept]
    turned = turned_along(rates, durations)
    same = np.round(turned[:-1].reshape(len(rates), 8).astype(np.float64), _SAME_SHAPE_DIGITS) + 0.0
    first, which = _distinct(np.concatenate([same, rates, durations[:, None]], axis=1))
    off = rotation_between(turned[first][which], turned[:-1])
    shapes, rates, durations = shapes_of(shape, turned[first]), rates[first], durations[first]
    drift = _drift(swimmer, shapes, rates, durations, which, off, place)
    begun, which = np.append(place, len(kept)), which[place]
    small = _SMALL * tolerance_l * swimmer.length_m, _SMALL * tolerance_rad
    some: Rows = np.arange(len(first), dtype=np.int64)
    tried: dict[type[np.floating[Any]], Displacements] = {}
    found: Replay | None = None
    reach = np.empty((2, 0))  # of the first integration: as those of the others to many digits
    cares = _CARES if swimmer.fluid == "local" else _SLOW_CARES
    if cares is _CARES and np.max(np.bincount(which), initial=0) >= _OFTEN:
        cares = tuple(care for care in _CARES if care[0] == np.longdouble) or _CARES
    for precision, finer in cares:
        if found is not None and precision not in tried:
            left = _LEFT * tolerance_l * swimmer.length_m, _LEFT * tolerance_rad
            some = found.rounded_most(reach, *left)
        part = segment_displacements(
            swimmer, shapes[some].astype(precision), rates[some], durations[some], finer, resistances
        )
        before, tried[precision] = tried.get(precision), part
        part = part if before is None else part.measured(before)
        now = Replay(
            *(row, pose, shape, turned, begun),
            *(part if found is None else found.moves.put(some, part), which, drift, swimmer.length_m),
        )
        reach, found = now._reach if found is None else reach, now
        if found._rounded(reach).within(*small) and found._bounded(reach).within(*small):
            break
    assert found is not None  # noqa: S101  # there is one care at least
    return found


def _distinct(keys: Array) -> tuple[Rows, Rows]:
    """Return the first of every distinct row, and which of them each row is; rows are compared bit by bit."""
    words = np.ascontiguousarray(keys).view(np.uint64)
    mix = np.random.default_rng(0).integers(0, 2**64, words.shape[1], dtype=np.uint64) | np.uint64(1)
    spread = (words ^ (words >> np.uint64(32))) * mix
    first, which = distinct(spread.sum(axis=1, dtype=np.uint64))
    if not np.array_equal(words[first][which], words):  # two rows share a sum: compare them whole
        first, which = distinct(words)
    return first, which


def _drift(
    swimmer: Swimmer, shapes: Real, rates: Array, durations: Array, which: Rows, off: Array, place: Rows
) -> Array:
    """Return what segments make besides the displacement of the one that is integrated for them [m, rad].

    Args:
        swimmer: The swimmer.
        shapes: The shapes at the beginning of those that are integrated. Shape (k, 2, 3, 3).
        rates: Their limb rates. Shape (k, 6).
        durations: How long they last. Shape (k,).
        which: Which of them stands for each of some segments. Shape (n,).
        off: By how much their shapes are turned from that one's, in the limbs' frames [rad]. Shape (n, 2, 3).
        place: Which of these segments each is. Shape (m,).

    Returns:
        Body twists at the segments' ends, to first order, shape (m, 6), or (0, 6) where they are too small to count.
    """
    swept = np.linalg.norm(rates, axis=1) * durations
    each = np.abs(off).sum(axis=(1, 2)) * np.bincount(place, minlength=len(which))
    most = _SHARPEST * swept * np.bincount(which, each, len(shapes))
    least_first = np.argsort(most)
    swung = np.sort(least_first[np.cumsum(most[least_first]) >= _DRIFT_COUNTS])
    if not len(swung):
        return np.empty((0, 6))
    turns = np.zeros((6, 2, 3, 3)) + np.eye(3)
    shape = shapes[swung].astype(np.float64)
    ends = []
    for sign in (1.0, -1.0):
        for k in range(6):
            angle = np.zeros(3)
            angle[k % 3] = sign * _DRIFT_STEP
            turns[k, k // 3] = se3.rotation(angle)
        begun = (shape[:, None] @ turns).reshape(-1, 2, 3, 3)
        found = segment_displacements(
            swimmer, begun, np.repeat(rates[swung], 6, axis=0), np.repeat(durations[swung], 6)
        )
        ends.append(found.fine.astype(np.float64))
    slope = np.zeros((len(shapes), 6, 6))
    slope[swung] = (se3.log(np.linalg.inv(ends[1]) @ ends[0]) / (2.0 * _DRIFT_STEP)).reshape(-1, 6, 6)
    out = np.empty((len(which), 6))
    for low in range(0, len(which), _BATCH):
        some = slice(low, low + _BATCH)
        out[some] = np.einsum("ki,kij->kj", off[some].reshape(-1, 6), slope[which[some]])
    return out[place]
