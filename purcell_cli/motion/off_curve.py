"""How far the base's middle is from a curve over a whole motion, between rows too, and how far the base is turned.

Distances from a curve change no faster than the middle moves, and how fast it can move is bounded by dissipation
(see `workspace`). So between two instants it was no further off than that allows, and only where this may be more than
what was found is the motion looked at closer. The base's orientation is treated alike: at every instant it is within
what is found of that of the curve where this was nearest at one of the instants that are looked at before and after.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.path_parts import PathParts, Rows
from purcell_cli.motion.workspace import middle_speed, turning_speed

_EXACT_L = 1e-4
"""The largest distance is known to this, in units of L, or to a hundredth of it if that is more."""
_EXACT = 0.02
"""The largest turn is known to this, and this part of it [rad]."""
_MOST = 1 << 18
"""Parts of pieces that are looked at at once at most; with more the error is reported."""


@frozen_dataclass
class OffCurve:
    """How far the base's middle is from a curve at most.

    Attributes:
        distance_m: The largest distance that was found [m].
        place: The index of the pose of the path after which it is.
        time_s: When, from there [s].
        error_m: The true largest distance is more by at most this [m].
        turned_rad: What the base's turn from the curve's orientation does not exceed; None where that is free [rad].
    """

    distance_m: float = 0.0
    place: int = 0
    time_s: float = 0.0
    error_m: float = 0.0
    turned_rad: float | None = None

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

    def exact_m(found: float) -> float:
        return _exact_m(swimmer, found, tolerance_m)

    def distance_m(poses: Array) -> Array:
        return curve.distance_m(poses[:, :3, 3])

    most, row, time_s, error_m = _largest(path, poses, piece, middle_speed(swimmer, path.circles), distance_m, exact_m)
    turned_rad = None
    if curve.orientation is not None:
        speed = turning_speed(swimmer, path.circles)
        turned, _, _, error = _largest(
            path, poses, piece, speed, curve.turned_from, lambda found: _EXACT * (1.0 + found)
        )
        turned_rad = turned + error
    return OffCurve(most, row, time_s, error_m, turned_rad)


def _largest(
    path: PathParts,
    poses: Array,
    piece: Rows,
    speed: Array,
    measure: Callable[[Array], Array],
    exact: Callable[[float], float],
) -> tuple[float, int, float, float]:
    """Return the largest value of what changes no faster than a speed, its place and time, and by how much it may err.

    Args:
        path: The pieces of the path.
        poses: The base's pose at each beginning of a piece [m]. Shape (m, 4, 4).
        piece: Which piece begins there. Shape (m,).
        speed: How fast it changes at most on each piece [1/s]. Shape (n,).
        measure: Returns its values at poses. Shapes (k, 4, 4) to (k,).
        exact: Returns how exactly a largest value is to be known.
    """
    best, error = (0.0, 0, 0.0), None

    def look(row: Rows, time_s: Array, poses: Array, _axes: Array) -> Array:
        nonlocal best
        off = measure(poses)
        if len(off) and float(np.max(off)) > best[0]:
            k = int(np.argmax(off))
            best = float(off[k]), int(row[k]), float(time_s[k])
        return off

    def more(here: Rows, first: Array, last: Array, length: Array) -> NDArray[np.bool_]:
        nonlocal error
        bound = 0.5 * (first + last + speed[here] * length)
        cut = np.asarray(bound > best[0] + exact(best[0]))
        if np.count_nonzero(cut) > _MOST:
            error = float(np.max(bound)) - best[0]
            cut[:] = False
        return cut

    path.halve(np.arange(len(poses)), poses, piece, look, more)
    return (*best, exact(best[0]) if error is None else error)


def _exact_m(swimmer: Swimmer, found_m: float, tolerance_m: float) -> float:
    """Return how exactly the largest distance is to be known [m]."""
    room = abs(tolerance_m - found_m)
    return max(_EXACT_L * swimmer.length_m, min(0.01 * found_m, room))
