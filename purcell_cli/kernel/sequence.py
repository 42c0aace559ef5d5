"""The cheapest sequence of motions along and about single axes that makes a displacement, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

_MOST = 7
"""Motions of a sequence at most."""


def cheapest(displacement: ArrayLike, counts: ArrayLike, strokes: ArrayLike) -> list[tuple[int, float]]:
    """Return motions that make a displacement, at about the least price that a search finds; see `gait_sequence.split`.

    Args:
        displacement: The displacement. Shape (4, 4).
        counts: How many strokes make each motion: along x, y, z and about them, 1 at least. Shape (6,).
        strokes: What a stroke's approach and one of its cycles travel, and how far a cycle goes. Shape (n, 3).

    Returns:
        Which motion, 0 to 5, and how far it goes, in order.
    """
    count = wholes(counts, "counts", (6,))
    if int(count.min()) < 1:
        raise ValueError("counts: a stroke of each motion is wanted")
    stroke, wanted = doubles(strokes, "strokes", (int(count.sum()), 3)), doubles(displacement, "displacement", (4, 4))
    along, amount = np.zeros(_MOST, dtype=np.int64), np.zeros(_MOST)
    places = (address(part) for part in (wanted, count, stroke, along, amount))
    n = KERNEL.purcell_sequence(*places)
    return list(zip(along[:n].tolist(), amount[:n].tolist(), strict=True))
