"""How far the base's middle is from a curve over a whole motion, between rows too.

Distances from a curve change no faster than the middle moves, and how fast it can move is bounded by dissipation
(see `workspace`). So between two instants it was no further off than that allows, and only where this may be more than
what was found is the motion looked at closer.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from purcell_cli.geometry.reproducible import matmul
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
    row, part, depth = np.arange(len(poses)), np.zeros(len(poses), dtype=np.int64), 0
    moves, _ = path.ahead(piece, part, depth, 1.0)
    first, last = curve.distance_m(poses[:, :3, 3]), curve.distance_m(matmul(poses, moves)[:, :3, 3])
    k = int(np.argmax(first))
    best = OffCurve(float(first[k]), k, 0.0)
    if len(last) and float(np.max(last)) > best.distance_m:
        k = int(np.argmax(last))
        best = OffCurve(float(last[k]), k, float(pieces.durations[piece[k]]))
    while len(row):
        exact = _exact_m(swimmer, best, tolerance_m)
        length = pieces.durations[piece[row]] / 2**depth
        bound = 0.5 * (first + last + speed[piece[row]] * length)
        more = bound > best.distance_m + exact
        if np.count_nonzero(more) > _MOST:
            return dataclasses.replace(best, error_m=float(np.max(bound)) - best.distance_m)
        row, part, poses, first, last, length = (x[more] for x in (row, part, poses, first, last, length))
        moves, _ = path.ahead(piece[row], part, depth, 0.5)
        middle = matmul(poses, moves)
        between = curve.distance_m(middle[:, :3, 3])
        if len(between) and float(np.max(between)) > best.distance_m:
            k = int(np.argmax(between))
            best = OffCurve(float(between[k]), int(row[k]), float((part[k] + 0.5) * length[k]))
        row, part, depth = np.tile(row, 2), np.concatenate([2 * part, 2 * part + 1]), depth + 1
        poses = np.concatenate([poses, middle])
        first, last = np.concatenate([first, between]), np.concatenate([between, last])
    return dataclasses.replace(best, error_m=_exact_m(swimmer, best, tolerance_m))


def _exact_m(swimmer: Swimmer, best: OffCurve, tolerance_m: float) -> float:
    """Return how exactly the largest distance is to be known [m]."""
    room = abs(tolerance_m - best.distance_m)
    return max(_EXACT_L * swimmer.length_m, min(0.01 * best.distance_m, room))
