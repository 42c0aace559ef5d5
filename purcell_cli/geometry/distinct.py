"""Distinct numbers and rows of an array.

numpy's `unique` finds them too, but it imports masked arrays, 20 ms of a command's start.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def distinct(values: NDArray[np.number]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return where each distinct number, or row, is first, in rising order, and which of them each one is.

    Args:
        values: Numbers, shape (n,), or rows, shape (n, k), compared from the first column on.

    Returns:
        Indices into the values, shape (m,), and indices into those, shape (n,).
    """
    columns = values[None] if values.ndim == 1 else values.T
    order = np.lexsort(columns[::-1])
    ranked = columns[:, order]
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = np.any(ranked[:, 1:] != ranked[:, :-1], axis=0)
    which = np.empty(len(order), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which
