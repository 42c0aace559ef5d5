"""How far segments are from balls and boxes, and how deep inside cones, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, Whole, address, doubles
from purcell_cli.kernel.library import KERNEL

_ROUNDS = 26
"""Halvings by which the deepest point of a segment inside a box is found: to 1e-8 of a segment's length."""


def _segments(first: ArrayLike, last: ArrayLike) -> tuple[Array, Array]:
    one = doubles(first, "first", (-1, 3))
    return one, doubles(last, "last", one.shape)


def from_balls(first: ArrayLike, last: ArrayLike, centres: ArrayLike, radii: ArrayLike) -> tuple[Array, Whole]:
    """Return how far segments are from the surface of the nearest ball, negative inside, and which that is.

    Args:
        first: The segments' beginnings. Shape (n, 3).
        last: Their ends. Shape (n, 3).
        centres: The balls' middles, one or more. Shape (m, 3).
        radii: Their radii. Shape (m,).

    Returns:
        Shapes (n,).
    """
    one, two = _segments(first, last)
    middles = doubles(centres, "centres", (-1, 3))
    sizes = doubles(radii, "radii", (len(middles),))
    if not len(middles):
        raise ValueError("centres: one ball or more is wanted, found none")
    out, which = np.empty(len(one)), np.empty(len(one), dtype=np.int64)
    given = (address(part) for part in (middles, sizes, out, which))
    KERNEL.purcell_from_balls(len(one), address(one), address(two), len(middles), *given)
    return out, which


def from_boxes(
    first: ArrayLike, last: ArrayLike, centres: ArrayLike, orientations: ArrayLike, halves: ArrayLike
) -> tuple[Array, Whole]:
    """Return the signed distances of segments from the nearest box, and which that is.

    Args:
        first: The segments' beginnings. Shape (n, 3).
        last: Their ends. Shape (n, 3).
        centres: The boxes' middles, one or more. Shape (m, 3).
        orientations: Turn their axes into the world's. Shape (m, 3, 3).
        halves: Half their edges. Shape (m, 3).

    Returns:
        Distances, exact outside, to 1e-8 of a segment's length inside, and indices. Shapes (n,).
    """
    one, two = _segments(first, last)
    middles = doubles(centres, "centres", (-1, 3))
    m = len(middles)
    turns, sizes = doubles(orientations, "orientations", (m, 3, 3)), doubles(halves, "halves", (m, 3))
    if not m:
        raise ValueError("centres: one box or more is wanted, found none")
    out, which = np.empty(len(one)), np.empty(len(one), dtype=np.int64)
    boxes = (address(part) for part in (middles, turns, sizes))
    KERNEL.purcell_from_boxes(len(one), address(one), address(two), m, *boxes, _ROUNDS, address(out), address(which))
    return out, which


def inside_cones(
    first: ArrayLike,
    last: ArrayLike,
    cells: int,
    begin: ArrayLike,
    way: ArrayLike,
    radius: ArrayLike,
    change: ArrayLike,
) -> tuple[Array, Whole]:
    """Return how far inside the union of cones with round ends segments are at the least, and in which cone.

    A segment is cut into cells, and a cell is as deep in a cone as its shallower end.

    Args:
        first: The segments' beginnings. Shape (n, 3).
        last: Their ends. Shape (n, 3).
        cells: Into how many cells each is cut.
        begin: Where the cones' axes begin, one cone or more. Shape (m, 3).
        way: From there to where they end; not 0. Shape (m, 3).
        radius: The radii at the beginning. Shape (m,).
        change: What the radii grow by until the end. Shape (m,).

    Returns:
        Shapes (n,).
    """
    one, two = _segments(first, last)
    axes = doubles(begin, "begin", (-1, 3))
    m = len(axes)
    rest = doubles(way, "way", (m, 3)), doubles(radius, "radius", (m,)), doubles(change, "change", (m,))
    if not m or cells < 1:
        raise ValueError(f"one cone and one cell or more are wanted, found {m} and {cells}")
    out, which, room = np.empty(len(one)), np.empty(len(one), dtype=np.int64), np.empty(3 * m)
    given = (address(part) for part in (axes, *rest, room, out, which))
    KERNEL.purcell_inside_cones(len(one), address(one), address(two), cells, m, *given)
    return out, which
