"""Chains of screw motions that make a displacement, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

_MOST = 16
"""The most screws of a chain, as in `screw_chains.c`."""


def solved(
    screws: ArrayLike, starts: ArrayLike, twists: ArrayLike, travel: ArrayLike, inverse: ArrayLike, rows: ArrayLike
) -> tuple[Array, Array]:
    """Return how often chains play each of their screws to make a displacement, by Newton's method.

    Args:
        screws: Which screws each chain has, in order, 16 at most. Shape (n, k).
        starts: How often each is played, to begin with. Shape (n, k).
        twists: The twist of each screw [L, rad]. Shape (m, 6).
        travel: What each screw's joint travel is, once played; positive [rad]. Shape (m,).
        inverse: The inverse of the displacement. Shape (4, 4).
        rows: The components of what is missing that count, from 0 to 5. Shape (r,).

    Returns:
        The numbers that come nearest, shape (n, k), and what they miss the displacement by [L, rad], shape (n,).
    """
    screw = wholes(screws, "screws", (-1, -1))
    n, length = screw.shape
    twist, row = doubles(twists, "twists", (-1, 6)), wholes(rows, "rows", (-1,))
    if length > _MOST or (screw.size and not 0 <= int(screw.min()) <= int(screw.max()) < len(twist)):
        raise ValueError(f"screws: at most {_MOST} screws of {len(twist)} are wanted")
    if not len(row) or not 0 <= int(row.min()) <= int(row.max()) < 6 or len(row) > 6:
        raise ValueError("rows: some of 0 to 5 are wanted")
    cycles, missing = doubles(starts, "starts", (n, length)).copy(), np.empty(n)
    given = screw, twist, doubles(travel, "travel", (len(twist),)), doubles(inverse, "inverse", (4, 4))
    before = (address(part) for part in given)
    KERNEL.purcell_screw_chains(n, length, *before, len(row), *(address(part) for part in (row, cycles, missing)))
    return cycles, missing
