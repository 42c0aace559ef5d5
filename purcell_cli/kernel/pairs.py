"""What pairs of displacements, and the way between them, are estimated to cost, by the kernel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
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
    first: ArrayLike, second: ArrayLike, before: ArrayLike, after: ArrayLike, price: PriceNumbers, least_of: int = 0
) -> Array:
    """Return the costs of displacements one after another, and of what is spent besides.

    Args:
        first: Shape (n, 4, 4).
        second: Shape (m, 4, 4).
        before: What is spent with each of the first. Shape (n,).
        after: What is spent with each of the second. Shape (m,).
        price: The estimate; none of its numbers is negative.
        least_of: 0 for all pairs, 1 for the least cost with each of the first, 2 with each of the second.

    Returns:
        Shape (n, m), (n,) or (m,); infinite where there is no pair.
    """
    a, b = doubles(first, "first", (-1, 4, 4)), doubles(second, "second", (-1, 4, 4))
    n, m, numbers = len(a), len(b), doubles(price, "price", (8,))
    spent = doubles(before, "before", (n,)), doubles(after, "after", (m,))
    if least_of not in (0, 1, 2):
        raise ValueError(f"least_of: 0, 1 or 2 is wanted, found {least_of}")
    out = np.empty(((n, m), n, m)[least_of])
    given = (address(part) for part in (a, b, *spent, numbers))
    KERNEL.purcell_pair_prices(n, m, *given, least_of, address(out))
    return out
