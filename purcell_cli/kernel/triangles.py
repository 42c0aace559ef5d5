"""How far segments are from triangles, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def from_triangles(first: ArrayLike, last: ArrayLike, most: ArrayLike, boxes: ArrayLike, leaves: ArrayLike) -> Array:
    """Return how far segments are from the nearest triangle of a tree, 0 where they cross one; `most` if that is less.

    It is what comparing with every triangle would find: boxes only tell which need no look. Triangles with a sine below
    1e-8 at the first corner are taken for their sides: rounding hides which way they face.

    Args:
        first: The segments' beginnings. Shape (n, 3).
        last: Their ends. Shape (n, 3).
        most: Distances above these need not be known; they may be infinite. Shape (n,).
        boxes: The least and the largest coordinates of boxes; box k holds the boxes 2 k + 1 and 2 k + 2, and the last m
            hold the leaves' triangles. Shape (2 m - 1, 2, 3).
        leaves: The triangles; m is a power of 2, and a triangle may be there twice. Shape (m, w, 3, 3).

    Returns:
        Shape (n,).
    """
    one = doubles(first, "first", (-1, 3))
    two, limit = doubles(last, "last", one.shape), doubles(most, "most", one.shape[:1])
    corners = doubles(leaves, "leaves", (-1, -1, 3, 3))
    m, width = corners.shape[:2]
    if not width or m.bit_count() != 1:
        raise ValueError(f"leaves: a power of 2 of leaves with triangles is wanted, found {m} with {width} triangles")
    tree = doubles(boxes, "boxes", (2 * m - 1, 2, 3))
    out = np.empty(len(one))
    given = (address(part) for part in (tree, corners, out))
    KERNEL.purcell_from_triangles(len(one), address(one), address(two), address(limit), m, width, *given)
    return out
