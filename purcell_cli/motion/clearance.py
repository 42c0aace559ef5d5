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

import functools
import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arccos, arcsin, cos, hypot, sin
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import clearance as kernel
from purcell_cli.kernel.linear import nearest_on_segments
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

LIMBS = "limb 1 and limb 2"
"""What messages call the pair of limbs."""

TOLERANCE_L = 1e-9
"""The least distance is known to this, in units of L."""

_BATCH = 1 << 16
"""Pieces of a motion that are searched together: bounds the memory of a long motion."""
_MOST_STRETCHES = 1 << 17
"""Stretches at most: when there are more none is cut again, and the error is reported.

Only limbs that keep the same distance for long need so many."""


@frozen_dataclass
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
        found = _nearest(swimmer, circles, False, best.distance_m)
        error = max(best.error_m, found.error)
        if found.distance[0] < best.distance_m:
            best = Clearance(float(found.distance[0]), low + int(found.piece[0]), float(found.time[0]), error)
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
    found = _nearest(swimmer, LimbCircles.of(pieces), True, enough_m)
    return found.distance, found.time


def clearance_slack(
    swimmer: Swimmer, controls: ArrayLike, angles: ArrayLike, shapes: ArrayLike, least_m: ArrayLike, near_m: float
) -> tuple[Array, Array]:
    """Return by how much limbs are farther apart than they must be where that is little, and its derivative.

    Args:
        swimmer: The swimmer.
        controls: The controls of primitives. Shape (n,).
        angles: How far each turns [rad]. Shape (n,).
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        least_m: The least distance of the limbs on each [m]; -infinity where it does not matter. Shape (n,).
        near_m: Distances that exceed it by more than this do not matter [m].

    Returns:
        What the least distance on m primitives exceeds the least allowed by [m], shape (m,), and its derivative by all
        angles, shape (m, n).
    """
    return kernel.rows(controls, angles, shapes, limits_apart(swimmer, least_m, near_m))


def limits_apart(swimmer: Swimmer, least_m: ArrayLike, near_m: float) -> kernel.Apart:
    """Return how far limbs must be apart [m] as the kernel takes it; see `clearance_slack`. Shape (n,)."""
    small_m, straight_m = TOLERANCE_L * swimmer.length_m, straight_distance(swimmer)
    return kernel.Apart(np.asarray(least_m, dtype=np.float64), _links(swimmer), small_m, straight_m, near_m)


@functools.lru_cache(maxsize=64)
def straight_distance(swimmer: Swimmer) -> float:
    """Return the distance of the limbs' surfaces where both are straight [m]."""
    return float(limb_distance(swimmer, COLLINEAR[..., 0]))


def _nearest(swimmer: Swimmer, circles: LimbCircles, apart: bool, enough_m: float) -> kernel.Nearest:
    """Return the least distances on all pieces or, apart, on each; those above what is enough are not exact [m]."""
    small_m = TOLERANCE_L * swimmer.length_m
    return kernel.nearest(circles.known, circles.duration, _links(swimmer), apart, enough_m, small_m, _MOST_STRETCHES)


@functools.lru_cache(maxsize=64)
def _links(swimmer: Swimmer) -> tuple[float, float, float, float]:
    """Return half the base's length, the limbs' lengths and their radii together [m]."""
    one, two = (2.0 * half for half in swimmer.halves_m[1:])
    return swimmer.base_half_length_m, one, two, _radii(swimmer)
