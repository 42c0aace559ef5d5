"""Lines of beads that feel each other's flow, by the kernel: their resistance, and its table over the limbs' bends."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

RESISTANCE = 78
"""Entries of a resistance on (v, omega, u_1, u_2): P's lower half, Q^T, and the lower half of the rest."""
MOST_BENDS, MOST_MULTIPLES = 16, 16
"""Chebyshev polynomials of each limb's bend, and multiples of the angle between their planes, in a table at most."""
MOST_TABLES = 2
"""Tables of a swimmer at most."""
NUMBERS = 23
"""Numbers of a swimmer before its tables."""
WIDTH = 80
"""Numbers of a table's row: the entries of a resistance in whole blocks, which the kernel reads at once."""
_SIZES = 4
"""Numbers of a table before its counts: how far it reaches, that bend's cosine, and how many there are of what."""


def swimmer_numbers(swimmer: ArrayLike) -> Array:
    """Return the numbers of a swimmer, in the order of `struct swimmer` in `kernel.h`, checked. Shape (n,).

    Raises:
        ValueError: Their count is not that of a swimmer with the tables that they say they have.
    """
    found = doubles(swimmer, "swimmer", (-1,))
    if len(found) < NUMBERS:
        raise ValueError(f"swimmer: an array of shape ({NUMBERS},) or more is wanted, found {found.shape}")
    left = found[NUMBERS:]
    for _ in range(int(found[NUMBERS - 1]) if 0.0 <= found[NUMBERS - 1] <= MOST_TABLES else 0):
        left = left[_checked_table(left) :]
    if len(left) or found[NUMBERS - 1] not in range(MOST_TABLES + 1):
        raise ValueError(f"swimmer: up to {MOST_TABLES} tables are wanted, found {len(left)} numbers more")
    return found


def _checked_table(numbers: Array) -> int:
    """Return how long the table is that some numbers begin with.

    Raises:
        ValueError: They are none.
    """
    reach, least, bends, multiples = (float(x) for x in numbers[:_SIZES]) if len(numbers) >= _SIZES else (0.0,) * _SIZES
    known = reach > 0.0 and -1.0 <= least <= 1.0 and 2 <= bends <= MOST_BENDS and 1 <= multiples <= MOST_MULTIPLES
    n, m = (int(bends), int(multiples)) if known else (0, 0)
    length = _SIZES + n * m * (4 + 2 * n * WIDTH)
    if not known or len(numbers) < length:
        raise ValueError(f"swimmer: a table of {length} numbers is wanted, found {len(numbers)}")
    counts = numbers[_SIZES : _SIZES + 4 * n * m]
    if not (np.min(counts) >= 0.0 and np.max(counts) <= n):
        raise ValueError(f"swimmer: at most {n} coefficients of a sum are wanted")
    return length


def bead_resistance(
    place: ArrayLike, arm: ArrayLike, radius: ArrayLike, link: ArrayLike, wall: ArrayLike | None = None
) -> Array:
    """Return the resistance K^T M^-1 K of beads in a fluid of unit viscosity.

    Args:
        place: Their centres in base coordinates. Shape (n, 3).
        arm: The same from their limb's joint. Shape (n, 3).
        radius: Their radii. Shape (n,).
        link: Which link each is of: 0 the base, 1 or 2 a limb. Shape (n,).
        wall: Of a plane wall without slip the unit normal, into the fluid, and how high above it the origin of places
            is; None where there is no wall. Shape (4,).

    Returns:
        On (v, omega, u_1, u_2), the limbs' rates u in base coordinates. Shape (78,).

    Raises:
        ValueError: Their mobility is not positive definite, as it is for beads of some radius that are clear of a wall.
    """
    centre = doubles(place, "place", (-1, 3))
    n = len(centre)
    lever, size = doubles(arm, "arm", (n, 3)), doubles(radius, "radius", (n,))
    limb = wholes(link, "link", (n,))
    if n and not (limb.min() >= 0 and limb.max() <= 2 and size.min() > 0.0):
        raise ValueError("link and radius: 0, 1 or 2, and positive numbers are wanted")
    out, room = np.empty(RESISTANCE), np.empty(3 * n * (3 * n + 12))
    plane = None if wall is None else doubles(wall, "wall", (4,))
    beside = None if plane is None else address(plane)
    places = address(centre), address(lever), address(size), address(limb), beside, address(room), address(out)
    if not KERNEL.purcell_bead_resistance(n, *places):
        raise ValueError("the mobility of the beads is not positive definite")
    return out


def looked_up(swimmer: ArrayLike, axes: ArrayLike) -> Array:
    """Return the resistances that a swimmer's tables have for limb axes in base coordinates; see `bead_resistance`.

    Args:
        swimmer: Its numbers, with a table.
        axes: The limbs' axes. Shape (n, 2, 3).

    Returns:
        Shape (n, 78).
    """
    numbers, axis = swimmer_numbers(swimmer), doubles(axes, "axes", (-1, 2, 3))
    if len(numbers) == NUMBERS:
        raise ValueError("swimmer: one with a table is wanted")
    out = np.empty((len(axis), RESISTANCE))
    KERNEL.purcell_looked_up(address(numbers), len(axis), address(axis), address(out))
    return out
