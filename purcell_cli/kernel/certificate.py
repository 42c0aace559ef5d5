"""The certificate's integrator, in doubles and with twice their digits: no formula of it is the planner's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.kernel.arrays import address, doubles, extended, wholes
from purcell_cli.kernel.library import KERNEL

_DOUBLE = 8
"""Bytes of a double."""
_MOST_ROWS, _MOST_TIMES = 8, 64
"""The most steps of one extrapolation, and the most times at which it evaluates: what the kernel has room for."""
_MOST_RAD = 0.5
"""What no limb turns by on a piece: the series of its sine has terms for as much [rad]."""
_ROOM = 8
"""Pieces of a segment for which there is room at first."""


def has_extended() -> bool:
    """Return whether numpy and the kernel's compiler have the same extended precision."""
    size: int = KERNEL.purcell_extended_size()
    return np.dtype(np.longdouble).itemsize == size


def extrapolated(
    links: ArrayLike,
    axes: ArrayLike,
    rates: ArrayLike,
    lengths: ArrayLike,
    parts: ArrayLike,
    steps: Sequence[int],
    places: Sequence[int],
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Return by how much the base's displacements on pieces differ from none; see `verification.extrapolation`.

    In the precision of the axes: in doubles, or else with twice their digits.

    Args:
        links: Of the base and the limbs half the length and the drag on (v, omega), diagonal. Shape (3, 7).
        axes: The limbs' axes where pieces begin. Shape (2, 3, n).
        rates: The limbs' rates in base coordinates, at which none turns by more than half a radian. Shape (2, 3, n).
        lengths: How long each piece lasts. Shape (n,).
        parts: The times at which midpoint steps begin, as parts of a piece. Shape (t,).
        steps: Numbers of midpoint steps, 8 at most. Shape (r,).
        places: At which of the times each step of each number begins, row after row.

    Returns:
        The columns of the rotation less 1, and the position: extrapolated from all, and from all without the last
        extrapolation. Both of shape (n, 3, 4).
    """
    double = np.asarray(axes).dtype.itemsize <= _DOUBLE
    kind = doubles if double else extended
    numbers, length = doubles(links, "links", (3, 7)), kind(lengths, "lengths", (-1,))
    n = len(length)
    axis, rate = kind(axes, "axes", (2, 3, n)), kind(rates, "rates", (2, 3, n))
    time, many, place = kind(parts, "parts", (-1,)), wholes(steps, "steps", (-1,)), wholes(places, "places", (-1,))
    t = len(time)
    counted = 0 < len(many) <= _MOST_ROWS and bool(np.all(many > 0)) and int(many.sum()) == len(place)
    if not counted or t > _MOST_TIMES or not (0 <= int(place.min()) <= int(place.max()) < t):
        raise ValueError(f"steps and places: at most {_MOST_ROWS} rows of places among {_MOST_TIMES} times are wanted")
    if np.any(many[1:] <= many[:-1]):
        raise ValueError("steps: ever more are wanted")
    if np.any(np.sum(rate * rate, axis=1) * (length * length) > _MOST_RAD * _MOST_RAD):
        raise ValueError(f"lengths: pieces that turn no limb by more than {_MOST_RAD:g} rad are wanted")
    run = KERNEL.purcell_extrapolated if double else KERNEL.purcell_extrapolated_twice
    axis, rate, length, time = (part if double else _halves(part) for part in (axis, rate, length, time))
    fine, rough = (np.empty((n, 3, 4) if double else (2, n, 3, 4)) for _ in range(2))
    given = address(axis), address(rate), address(length), t, address(time), len(many), address(many), address(place)
    run(address(numbers), n, *given, address(fine), address(rough))
    return (fine, rough) if double else (_whole(fine), _whole(rough))


def _halves(numbers: NDArray[Any]) -> NDArray[np.float64]:
    """Return the doubles nearest to numbers, and those nearest to what is left. Shape (...) to (2, ...)."""
    high = numbers.astype(np.float64)
    return np.stack([high, (numbers - high).astype(np.float64)])


def _whole(halves: NDArray[np.float64]) -> NDArray[np.longdouble]:
    return np.asarray(halves[0].astype(np.longdouble) + halves[1])


def strung(pieces: ArrayLike, counts: ArrayLike) -> NDArray[np.longdouble]:
    """Return the products of consecutive runs of displacements, in extended precision: see `has_extended`.

    Args:
        pieces: By how much the displacements differ from none: rotations less 1, and positions. Shape (n, 3, 4).
        counts: How many each run has, in order; n together. Shape (k,).

    Returns:
        Poses, the identity for an empty run. Shape (k, 4, 4).
    """
    many, piece = wholes(counts, "counts", (-1,)), extended(pieces, "pieces", (-1, 3, 4))
    if np.any(many < 0) or int(many.sum()) != len(piece):
        raise ValueError(f"counts: {len(piece)} pieces in all are wanted, found {int(many.sum())}")
    out = np.empty((len(many), 4, 4), dtype=np.longdouble)
    KERNEL.purcell_strung(len(many), address(many), address(piece), address(out))
    return out


def reach(moves: ArrayLike, which: ArrayLike, least: float) -> NDArray[np.float64]:
    """Return what small turns move the end of a motion by, in which displacements come again and again.

    Args:
        moves: The displacements. Shape (k, 4, 4).
        which: Which of them are made, in order. Shape (n,).
        least: A length.

    Returns:
        Of each displacement the sum, over where it is made, of how far the end is from where it ends, and of that
        length; and how often it is made. Shape (2, k).
    """
    move, made = doubles(moves, "moves", (-1, 4, 4)), wholes(which, "which", (-1,))
    if len(made) and not 0 <= int(made.min()) <= int(made.max()) < len(move):
        raise ValueError(f"which: indices of {len(move)} displacements are wanted")
    out = np.empty((2, len(move)))
    KERNEL.purcell_reach(len(made), address(made), len(move), address(move), least, address(out))
    return out


def pieces_of(
    links: ArrayLike, bounds: ArrayLike, axes: ArrayLike, rates: ArrayLike, swept: ArrayLike, lasts: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return pieces of segments, so short that extrapolation takes them in one; see `verification.extrapolation`.

    Args:
        links: Of the base and the limbs half the length and the drag on (v, omega), diagonal. Shape (3, 7).
        bounds: What a bend adds to the spread of the links, how fast the distance from where A(r) is sharp can change
            with a limb's turn, the least distance that counts, the longest pieces as a part of it, and the longest
            [rad]. Shape (5,).
        axes: The limbs' axes where segments begin. Shape (m, 2, 3).
        rates: The limbs' rates in base coordinates. Shape (m, 2, 3).
        swept: How far segments turn the limbs [rad]. Shape (m,).
        lasts: How long they last. Shape (m,).

    Returns:
        Which segment each piece is of, ascending, shape (n,), and where it begins and how long it is, as parts of the
        segment, with the distance in its middle, shape (n, 3).

    Raises:
        ValueError: Bounds that want shorter pieces than there can be.
    """
    numbers, bound = doubles(links, "links", (3, 7)), doubles(bounds, "bounds", (5,))
    last = doubles(lasts, "lasts", (-1,))
    m = len(last)
    axis, rate = doubles(axes, "axes", (m, 2, 3)), doubles(rates, "rates", (m, 2, 3))
    arc, room = doubles(swept, "swept", (m,)), _ROOM * m
    given = address(numbers), address(bound), m, address(axis), address(rate), address(arc), address(last)
    while True:
        owner, pieces = np.empty(room, dtype=np.int64), np.empty((room, 3))
        count: int = KERNEL.purcell_pieces(*given, room, address(owner), address(pieces))
        if count < 0:
            raise ValueError("bounds: longer pieces are wanted")
        if count <= room:
            return owner[:count], pieces[:count]
        room = count


def repeats(rows: ArrayLike, longest: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return runs of neighbours that come again and again, bit by bit; all rows together, in order.

    Args:
        rows: Numbers. Shape (n, k).
        longest: The most rows that come again together.

    Returns:
        Where each run begins, how many rows come again, and how often: once, where they do not. All of shape (m,).
    """
    row = doubles(rows, "rows", (-1, -1))
    out = np.empty((3, len(row)), dtype=np.int64)
    count: int = KERNEL.purcell_repeats(*row.shape, address(row), longest, *(address(part) for part in out))
    return out[0, :count], out[1, :count], out[2, :count]
