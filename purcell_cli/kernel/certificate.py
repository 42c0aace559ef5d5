"""The certificate's integrator for doubles: it shares no formula with the planner's flow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

_MOST_ROWS, _MOST_TIMES = 8, 64
"""The most steps of one extrapolation, and the most times at which it evaluates: what the kernel has room for."""


def extrapolated(
    links: ArrayLike,
    axes: ArrayLike,
    rates: ArrayLike,
    lengths: ArrayLike,
    steps: Sequence[int],
    places: Sequence[int],
) -> tuple[Array, Array]:
    """Return by how much the base's displacements on pieces differ from none; see `verification.extrapolation`.

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
    numbers, length = doubles(links, "links", (3, 7)), doubles(lengths, "lengths", (-1,))
    n = len(length)
    axis, rate = doubles(axes, "axes", (2, 3, -1, n)), doubles(rates, "rates", (2, 3, n))
    many, place, t = wholes(steps, "steps", (-1,)), wholes(places, "places", (-1,)), axis.shape[2]
    counted = 0 < len(many) <= _MOST_ROWS and bool(np.all(many > 0)) and int(many.sum()) == len(place)
    if not counted or t > _MOST_TIMES or not (0 <= int(place.min()) <= int(place.max()) < t):
        raise ValueError(f"steps and places: at most {_MOST_ROWS} rows of places among {_MOST_TIMES} times are wanted")
    if np.any(many[1:] <= many[:-1]):
        raise ValueError("steps: ever more are wanted")
    fine, rough = np.empty((n, 3, 4)), np.empty((n, 3, 4))
    given = address(axis), address(rate), address(length), len(many), address(many), address(place)
    KERNEL.purcell_extrapolated(address(numbers), n, t, *given, address(fine), address(rough))
    return fine, rough
