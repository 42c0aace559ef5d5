"""How near the limbs come to each other over a whole motion.

The links are capsules: segments with round ends, as thick as the links' radius. Each limb is joined
to the base, so these pairs touch at the joint whatever the shape, and only limb 1 and limb 2 can
collide, and either with the body, where the base bears a sphere. A limb that folds back onto the
base is therefore no collision by itself; folded all the
way it reaches the other limb's joint, where it is one, unless it is shorter than the base.

The least distance is found by cutting the motion wherever an instant between may still be nearer
than the nearest found so far. What is known of a stretch of time h between two distances: the
distance changes no faster than the limbs' points move, v; and the square of the distance between
two material points curves by no more than M, so that it lies above the parabola of curvature M
through its ends, and so does the least of all. The second bound closes quickly round a minimum. A
limb is nearest to the body where it bends most, so that pair needs no search.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.reproducible import arccos, arcsin, cos, hypot, sin
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.linear import nearest_on_segments
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

Rows = NDArray[np.int64]

LIMBS = "limb 1 and limb 2"
"""What messages call the pair of limbs."""

TOLERANCE_L = 1e-9
"""The least distance is known to this, in units of L."""

_PARTS = 4
"""Into how many a stretch is cut where a smaller distance may be: 2 to 8 find the same one, with 5 to 10 evaluations a
piece; the more, the fewer rounds."""

_BATCH = 1 << 16
"""Pieces of a motion that are searched together: bounds the memory of a long motion."""
_MOST_STRETCHES = 1 << 17
"""Stretches at most: when there are more none is cut again, and the error is reported.

Only limbs that keep the same distance for long need so many."""


@dataclasses.dataclass(frozen=True, slots=True)
class Clearance:
    """The least distance between the surfaces of the limbs, or of a limb and the body, and where it is.

    Attributes:
        distance_m: The distance; negative where the limbs overlap [m].
        piece: The piece of the motion it is on.
        time_s: When, from the piece's beginning [s].
        error_m: The true least distance is less by at most this [m].
        between: Which two come so near.
    """

    distance_m: float
    piece: int
    time_s: float
    error_m: float
    between: str = LIMBS


def apart_bend_rad(swimmer: Swimmer, clearance_m: float = 0.0) -> float:
    """Return the bend up to which the limbs keep a clearance [m] however they turn [rad].

    A limb bent by b lies beyond a plane across the base, a + 2 l cos(b) from its middle; the other limb lies
    beyond such a plane on the other side. Limbs so short that any bend will do may bend by pi. A limb that bends by
    more than a right angle passes the base's middle at a sin(b), or its tip does further off.
    """
    base = swimmer.base_half_length_m
    out = []
    for half, radius in zip(swimmer.halves_m[1:], swimmer.radii_m[1:], strict=True):
        cosine = (radius + 0.5 * clearance_m - base) / (2.0 * half)
        out.append(float(arccos(np.clip(cosine, -1.0, 1.0))))
        if swimmer.body_radius_m:
            sine = (swimmer.body_radius_m + radius + clearance_m) / base
            out.append(math.pi - float(arcsin(min(sine, 1.0))))
    return min(out)


def body_distance(swimmer: Swimmer, bend: Array) -> Array:
    """Return the distance of each limb's surface from the body's at bends [rad], [m]. Shape (..., 2).

    It falls with the bend; it is infinite where there is no body.
    """
    if not swimmer.body_radius_m:
        return np.full(np.shape(bend), np.inf)
    base, full = swimmer.base_half_length_m, 2.0 * np.array(swimmer.halves_m[1:])
    sine, cosine = sin(bend), cos(bend)
    foot = np.clip(-base * cosine, 0.0, full)
    return np.asarray(hypot(base + foot * cosine, foot * sine) - np.array(swimmer.radii_m[1:]) - swimmer.body_radius_m)


def segment_distance(gap: Array, first: Array, second: Array) -> Array:
    """Return the distance between segments p + s first and q + t second, s and t from 0 to 1.

    Args:
        gap: Vectors p - q between the beginnings. Shape (..., 3).
        first: The first segments; they may be points. Shape (..., 3).
        second: The second segments. Shape (..., 3).
    """
    return np.asarray(nearest_on_segments(gap, first, second)[..., 2])


def limb_distance(swimmer: Swimmer, axes: Array) -> Array:
    """Return the distance between the limbs' surfaces, negative where they overlap [m].

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in the base frame. Shape (..., 2, 3).
    """
    middle = segment_distance(*_segments(swimmer, axes))
    return np.asarray(middle - _radii(swimmer))


def _radii(swimmer: Swimmer) -> float:
    """Return the radii of both limbs together [m]."""
    return swimmer.radii_m[1] + swimmer.radii_m[2]


def distance_slope(swimmer: Swimmer, axes: Array) -> Array:
    """Return the derivative of the distance between the limbs by their axes [m]; 0 where they cross.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in the base frame. Shape (..., 2, 3).

    Returns:
        Shape (..., 2, 3).
    """
    gap, first, second = _segments(swimmer, axes)
    found = nearest_on_segments(gap, first, second)
    s, t, size = (found[..., k, None] for k in range(3))
    along = (gap + s * first - t * second) / np.where(size > 0.0, size, 1.0)
    full = 2.0 * np.array(swimmer.halves_m[1:])
    return np.asarray(full[:, None] * found[..., :2, None] * along[..., None, :])


def _segments(swimmer: Swimmer, axes: Array) -> tuple[Array, Array, Array]:
    """Return the vector from limb 2's joint to limb 1's, and the limbs from their joints on [m]. Shapes (..., 3)."""
    _, one, two = swimmer.halves_m
    gap = np.zeros_like(axes[..., 0, :])
    gap[..., 0] = 2.0 * swimmer.base_half_length_m
    return gap, 2.0 * one * axes[..., 0, :], -2.0 * two * axes[..., 1, :]


def least_clearance(swimmer: Swimmer, pieces: Pieces) -> Clearance:
    """Return the least distance between the limbs, or of one and the body, over pieces of constant limb rates.

    Args:
        swimmer: The swimmer.
        pieces: The pieces, one or more.
    """
    best = Clearance(np.inf, 0, 0.0, 0.0)
    for low in range(0, len(pieces), _BATCH):
        circles = LimbCircles.of(pieces[low : low + _BATCH])
        found = _Search(swimmer, circles, np.zeros(len(circles), dtype=np.int64), best.distance_m)
        error = max(best.error_m, found.error_m)
        if found.best[0] < best.distance_m:
            best = Clearance(float(found.best[0]), low + int(found.piece[0]), float(found.time[0]), error)
        if swimmer.body_radius_m:
            bend, time = circles.largest_bends()
            near = body_distance(swimmer, bend)
            k, limb = np.unravel_index(int(np.argmin(near)), near.shape)
            if near[k, limb] < best.distance_m:
                between = f"limb {limb + 1} and the body"
                best = Clearance(float(near[k, limb]), low + int(k), float(time[k, limb]), error, between)
    return best


def clearances(swimmer: Swimmer, pieces: Pieces, enough_m: float = np.inf) -> tuple[Array, Array]:
    """Return the least distance between the limbs on each of many pieces [m], and when [s]. Shapes (n,).

    Args:
        swimmer: The swimmer.
        pieces: The pieces.
        enough_m: Where the distance is more than this, it is not looked for closely [m].
    """
    circles = LimbCircles.of(pieces)
    found = _Search(swimmer, circles, np.arange(len(circles)), enough_m)
    return found.best, found.time


class _Search:
    """The search for the least distance in groups of pieces.

    Args:
        swimmer: The swimmer.
        circles: The pieces.
        group: The group of each piece, ascending from 0. Shape (n,).
        enough_m: Distances above this need not be found exactly [m].

    Attributes:
        best: The least distance found in each group [m].
        piece: The piece it is on.
        time: When, from the piece's beginning [s].
        error_m: How much less the true least distances may be [m].
    """

    def __init__(self, swimmer: Swimmer, circles: LimbCircles, group: Rows, enough_m: float) -> None:
        self.swimmer, self.circles, self.group, self.enough = swimmer, circles, group, enough_m
        count = int(group[-1]) + 1 if len(group) else 0
        self.best, self.time = np.full(count, np.inf), np.zeros(count)
        self.piece = np.zeros(count, dtype=np.int64)
        self.error_m = 0.0
        self._radii = _radii(swimmer)
        self._full = 2.0 * np.array(swimmer.halves_m[1:])
        self._speed = (self._full * circles.speed).sum(axis=1)
        self._pull = (self._full * circles.speed * circles.turn).sum(axis=1)
        if count:
            self._run()

    def _run(self) -> None:
        every = np.arange(len(self.circles))
        begun = np.zeros(len(every))
        first, last = self._distance(every, begun), self._distance(every, self.circles.duration)
        # While no limb bends more than a right angle the joints are nearest to each other.
        folded = self.circles.largest_bends()[0] > 0.5 * np.pi
        moving = np.any(folded, axis=1) & (self._speed * self.circles.duration > 0) & ~self._constant(folded)
        piece = every[moving]
        start, length, low, high = begun[moving], self.circles.duration[moving], first[moving], last[moving]
        while len(piece):
            bound = self._bound(piece, length, low, high)
            open_ = self._missing(piece, bound) > TOLERANCE_L * self.swimmer.length_m
            if np.count_nonzero(open_) > _MOST_STRETCHES:
                self.error_m = float(np.max(self._missing(piece, bound)))
                return
            piece, start, length, low, high = (x[open_] for x in (piece, start, length, low, high))
            n = len(piece)
            length = length / _PARTS
            inner = start[:, None] + length[:, None] * np.arange(1, _PARTS)
            between = self._distance(np.repeat(piece, _PARTS - 1), inner.ravel()).reshape(n, _PARTS - 1)
            ends = np.concatenate([low[:, None], between, high[:, None]], axis=1)
            start = (start[:, None] + length[:, None] * np.arange(_PARTS)).ravel()
            low, high = ends[:, :-1].ravel(), ends[:, 1:].ravel()
            piece, length = np.repeat(piece, _PARTS), np.repeat(length, _PARTS)
        self.error_m = TOLERANCE_L * self.swimmer.length_m

    def _constant(self, folded: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return on which pieces one limb rests and the other one's joint stays the point nearest to it. Shape (n,).

        It does if all of the resting limb lies behind the plane through that joint, across the moving
        limb's axis: both ends of the resting limb do.
        """
        circles = self.circles
        begun = circles.centre + circles.cosine
        end = (self._full[:, None] * begun)[:, ::-1]
        end[..., 0] += 2.0 * self.swimmer.base_half_length_m
        behind = ~folded & (circles.least_along(end) >= 0.0)
        rests = (circles.speed == 0.0)[:, ::-1]
        return np.asarray(np.any(behind & rests, axis=1))

    def _distance(self, piece: Rows, time: Array) -> Array:
        """Return distances at times, and keep the least. Shape (m,)."""
        found = limb_distance(self.swimmer, self.circles.at(piece, time))
        if len(found):
            order = np.lexsort((found, self.group[piece]))
            groups, first = np.unique(self.group[piece[order]], return_index=True)
            least = order[first]
            better = found[least] < self.best[groups]
            groups, least = groups[better], least[better]
            self.best[groups], self.piece[groups], self.time[groups] = found[least], piece[least], time[least]
        return found

    def _missing(self, piece: Rows, bound: Array) -> Array:
        """Return by how much a bound undercuts what is known already, or what is enough [m]."""
        return np.asarray(np.minimum(self.best[self.group[piece]], self.enough) - bound)

    def _bound(self, piece: Rows, length: Array, low: Array, high: Array) -> Array:
        """Return what the distance cannot go below on stretches of time between two distances [m]."""
        move = self._speed[piece] * length
        straight = 0.5 * (low + high - move)
        a, b = (low + self._radii) ** 2, (high + self._radii) ** 2
        reach = 2.0 * self.swimmer.base_half_length_m + move
        bulge = 2.0 * move**2 + 2.0 * reach * self._pull[piece] * length**2
        tilt = np.abs(b - a)
        inside = 0.5 * (a + b) - 0.125 * bulge - 0.5 * tilt**2 / np.where(bulge > 0.0, bulge, 1.0)
        square = np.where(tilt < 0.5 * bulge, inside, np.minimum(a, b))
        return np.asarray(np.maximum(straight, np.sqrt(np.maximum(square, 0.0)) - self._radii))
