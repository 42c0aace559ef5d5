"""How far the base's middle is from a curve over a whole motion, between rows too.

Distances from a curve change no faster than the middle moves, and how fast it can move is bounded by dissipation
(see `workspace`). So between two instants it was no further off than that allows, and only where this may be more than
what was found is the motion looked at closer.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.path_parts import PathParts, Rows
from purcell_cli.motion.workspace import middle_speed

_EXACT_L = 1e-4
"""The largest distance is known to this, in units of L, or to a hundredth of it if that is more."""
_MOST = 1 << 18
"""Parts of pieces that are looked at at once at most; with more the error is reported."""


@dataclasses.dataclass(frozen=True, slots=True)
class OffCurve:
    """How far the base's middle is from a curve at most.

    Attributes:
        distance_m: The largest distance that was found [m].
        place: The index of the pose of the path after which it is.
        time_s: When, from there [s].
        error_m: The true largest distance is more by at most this [m].
    """

    distance_m: float = 0.0
    place: int = 0
    time_s: float = 0.0
    error_m: float = 0.0

    @property
    def most_m(self) -> float:
        """What the distance does not exceed at any instant [m]."""
        return self.distance_m + self.error_m


def farthest(
    swimmer: Swimmer,
    curve: Curve,
    poses: Array,
    piece: Rows,
    pieces: Pieces,
    displacements: Callable[[Swimmer, Pieces], Array],
    tolerance_m: float = np.inf,
) -> OffCurve:
    """Return how far the base's middle is from a curve at most over a path of pieces of constant limb rates.

    Args:
        swimmer: The swimmer.
        curve: The curve.
        poses: The base's pose at each beginning of a piece [m]. Shape (m, 4, 4).
        piece: Which piece begins there. Shape (m,).
        pieces: The pieces.
        displacements: Returns the base's displacements on pieces [m]. Shape (n, 4, 4).
        tolerance_m: How far it may be: distances near that are looked at the more closely [m].
    """
    path = PathParts(swimmer, pieces, displacements)
    speed = middle_speed(swimmer, path.circles)
    best, error_m = OffCurve(), None

    def look(row: Rows, time_s: Array, poses: Array, _axes: Array) -> Array:
        nonlocal best
        off = curve.distance_m(poses[:, :3, 3])
        if len(off) and float(np.max(off)) > best.distance_m:
            k = int(np.argmax(off))
            best = OffCurve(float(off[k]), int(row[k]), float(time_s[k]))
        return off

    def more(here: Rows, first: Array, last: Array, length: Array) -> NDArray[np.bool_]:
        nonlocal error_m
        bound = 0.5 * (first + last + speed[here] * length)
        cut = np.asarray(bound > best.distance_m + _exact_m(swimmer, best, tolerance_m))
        if np.count_nonzero(cut) > _MOST:
            error_m = float(np.max(bound)) - best.distance_m
            cut[:] = False
        return cut

    path.halve(np.arange(len(poses)), poses, piece, look, more)
    return dataclasses.replace(best, error_m=_exact_m(swimmer, best, tolerance_m) if error_m is None else error_m)


def _exact_m(swimmer: Swimmer, best: OffCurve, tolerance_m: float) -> float:
    """Return how exactly the largest distance is to be known [m]."""
    room = abs(tolerance_m - best.distance_m)
    return max(_EXACT_L * swimmer.length_m, min(0.01 * best.distance_m, room))
