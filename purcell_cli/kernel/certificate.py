"""The certificate's integrator, for doubles and in extended precision: no formula of it is the planner's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.kernel.arrays import address, doubles, extended, wholes
from purcell_cli.kernel.library import KERNEL

_DOUBLE = 8
"""Bytes of a double."""
_MOST_ROWS, _MOST_TIMES = 8, 64
"""The most steps of one extrapolation, and the most times at which it evaluates: what the kernel has room for."""


def takes(precision: np.dtype[np.floating]) -> bool:
    """Return whether the kernel computes in a precision: in doubles, and in what numpy and its compiler have alike."""
    size: int = KERNEL.purcell_extended_size()
    return precision == np.float64 or (precision == np.longdouble and precision.itemsize == size)


def extrapolated(
    links: ArrayLike,
    axes: ArrayLike,
    rates: ArrayLike,
    lengths: ArrayLike,
    steps: Sequence[int],
    places: Sequence[int],
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Return by how much the base's displacements on pieces differ from none; see `verification.extrapolation`.

    In the precision of the axes, which the kernel `takes`.

    Args:
        links: Of the base and the limbs half the length and the drag on (v, omega), diagonal. Shape (3, 7).
        axes: The limbs' axes at the times at which midpoint steps begin. Shape (2, 3, t, n).
        rates: The limbs' rates in base coordinates. Shape (2, 3, n).
        lengths: How long each piece lasts. Shape (n,).
        steps: Numbers of midpoint steps, 8 at most. Shape (r,).
        places: At which of the times each step of each number begins, row after row.

    Returns:
        The columns of the rotation less 1, and the position: extrapolated from all, and from all without the last
        extrapolation. Both of shape (n, 3, 4).
    """
    double = np.asarray(axes).dtype.itemsize <= _DOUBLE
    kind, run = (doubles, KERNEL.purcell_extrapolated) if double else (extended, KERNEL.purcell_extrapolated_extended)
    numbers, length = doubles(links, "links", (3, 7)), kind(lengths, "lengths", (-1,))
    n = len(length)
    axis, rate = kind(axes, "axes", (2, 3, -1, n)), kind(rates, "rates", (2, 3, n))
    many, place, t = wholes(steps, "steps", (-1,)), wholes(places, "places", (-1,)), axis.shape[2]
    counted = 0 < len(many) <= _MOST_ROWS and bool(np.all(many > 0)) and int(many.sum()) == len(place)
    if not counted or t > _MOST_TIMES or not (0 <= int(place.min()) <= int(place.max()) < t):
        raise ValueError(f"steps and places: at most {_MOST_ROWS} rows of places among {_MOST_TIMES} times are wanted")
    if np.any(many[1:] <= many[:-1]):
        raise ValueError("steps: ever more are wanted")
    fine, rough = (np.empty((n, 3, 4), dtype=length.dtype) for _ in range(2))
    given = address(axis), address(rate), address(length), len(many), address(many), address(place)
    run(address(numbers), n, t, *given, address(fine), address(rough))
    return fine, rough
