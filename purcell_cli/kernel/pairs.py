"""What pairs of displacements, and the way between them, are estimated to cost, and which meet, by the kernel."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, Whole, address, doubles
from purcell_cli.kernel.library import KERNEL


class PriceNumbers(NamedTuple):
    """The numbers of an estimate sqrt(turn2 t^2 + turn1 t + aside min(s scale, most) + way1 d) root + way d.

    t is a change of heading [rad], d a distance and s its part aside [L].
    """

    turn2: float = 0.0
    turn1: float = 0.0
    aside: float = 0.0
    scale: float = 0.0
    most: float = 0.0
    way1: float = 0.0
    root: float = 1.0
    way: float = 0.0


def pair_prices(
    first: ArrayLike,
    second: ArrayLike,
    before: ArrayLike,
    after: ArrayLike,
    price: PriceNumbers,
    least_of: int = 0,
    most: float = math.inf,
) -> Array:
    """Return the costs of displacements one after another, and of what is spent besides.

    Args:
        first: Shape (n, 4, 4).
        second: Shape (m, 4, 4).
        before: What is spent with each of the first. Shape (n,).
        after: What is spent with each of the second. Shape (m,).
        price: The estimate; none of its numbers is negative.
        least_of: 0 for all pairs, 1 for the least cost with each of the first, 2 with each of the second, 3 for both.
        most: Of all pairs those that cost more may be told to cost infinitely much.

    Returns:
        Shape (n, m), (n,), (m,) or (n + m,); infinite where there is no pair.
    """
    a, b = doubles(first, "first", (-1, 4, 4)), doubles(second, "second", (-1, 4, 4))
    n, m, numbers = len(a), len(b), doubles(price, "price", (8,))
    spent = doubles(before, "before", (n,)), doubles(after, "after", (m,))
    if least_of not in (0, 1, 2, 3):
        raise ValueError(f"least_of: 0, 1, 2 or 3 is wanted, found {least_of}")
    out = np.empty(((n, m), n, m, n + m)[least_of])
    given = (address(part) for part in (a, b, *spent, numbers))
    KERNEL.purcell_pair_prices(n, m, *given, least_of, most, address(out))
    return out


class MeetingPrices(NamedTuple):
    """What a straight way from one heading to another counts.

    It goes along r [L], aside of its first heading by s [L]. It costs along r and the less of swing |h - k| + aside s
    and far (|h - u| + |k - u|), where h and k are the unit headings and u is the direction to go, forwards or
    backwards.
    """

    swing: float
    far: float
    aside: float
    along: float


def meetings(
    first: ArrayLike,
    second: ArrayLike,
    before: ArrayLike,
    after: ArrayLike,
    prices: MeetingPrices,
    most: float,
    within: float,
    missing: float,
) -> tuple[Array, Whole]:
    """Return the least cost of a straight way from each of some poses to one of others, and to which.

    Args:
        first: Positions and unit headings where ways begin. Shape (n, 6).
        second: The same where they end. Shape (m, 6).
        before: What is spent with each of the first. Shape (n,).
        after: What is spent with each of the second, ascending. Shape (m,).
        prices: What counts of a way, and how much.
        most: Ways that cost as much are none.
        within: Nor are ways that cost so many times the least that is known by then.
        missing: Nor are those that cost more than this, their length left out.

    Returns:
        Costs, infinite where there is no way, and numbers of the second, -1 where there is none. Shapes (n,), (n,).
    """
    a, b = doubles(first, "first", (-1, 6)), doubles(second, "second", (-1, 6))
    n, m, numbers = len(a), len(b), doubles(prices, "prices", (4,))
    spent = doubles(before, "before", (n,)), doubles(after, "after", (m,))
    cost, index = np.empty(n), np.empty(n, dtype=np.int64)
    columns = np.ascontiguousarray(b.T)
    given = (address(part) for part in (a, columns, *spent, numbers))
    KERNEL.purcell_meetings(n, m, *given, most, within, missing, address(cost), address(index))
    return cost, index
