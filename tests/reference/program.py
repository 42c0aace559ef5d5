"""Linear programs with an exact penalty, by the function of the kernel that its descents call."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def penalised(
    cost: ArrayLike,
    matrix: ArrayLike,
    wanted: ArrayLike,
    equal: int,
    price: float,
    low: ArrayLike,
    high: ArrayLike,
    begun: ArrayLike,
) -> tuple[Array, float] | None:
    """Return the x between bounds of the least sum of cost |x| and of the price of what is missed, and that sum.

    Equations miss |matrix x - wanted|, inequalities by how much matrix x is above what is wanted.

    Args:
        cost: Not negative. Shape (n,).
        matrix: The equations, then the inequalities. Shape (m, n).
        wanted: Shape (m,).
        equal: How many equations there are.
        price: What a unit missed costs, positive.
        low: Shape (n,).
        high: Shape (n,).
        begun: Where to begin. Shape (n,).

    Returns:
        The x, shape (n,), and the sum; None where too many steps were taken.

    Raises:
        ValueError: Numbers that are not finite, bounds that cross, or costs that are negative.
    """
    rows = doubles(matrix, "matrix", (-1, -1))
    m, n = rows.shape
    each, right = doubles(cost, "cost", (n,)), doubles(wanted, "wanted", (m,))
    least, most, x = doubles(low, "low", (n,)), doubles(high, "high", (n,)), np.array(doubles(begun, "begun", (n,)))
    if not all(np.all(np.isfinite(part)) for part in (rows, each, right, least, most, x, price)):
        raise ValueError("program: finite numbers are wanted")
    if np.any(each < 0.0) or np.any(least > most) or not price > 0.0 or not 0 <= equal <= m:
        raise ValueError("program: costs that are not negative, bounds in order and a positive price are wanted")
    table, room, whole = np.empty((m, n)), np.empty(8 * m + 15 * n), np.empty(3 * m + 3 * n, dtype=np.int64)
    places = (address(part) for part in (rows, right, each, least, most, x, table, room, whole))
    if KERNEL.purcell_program(m, n, equal, m, float(price), *places) < 0:
        return None
    missed = (rows * x).sum(axis=1) - right
    missed = np.concatenate([np.abs(missed[:equal]), np.maximum(missed[equal:], 0.0)])
    return x, float(np.sum(each * np.abs(x)) + price * np.sum(missed))
