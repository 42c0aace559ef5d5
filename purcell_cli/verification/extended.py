"""Products in extended precision, where the machine has it, for the certificate alone.

In numpy and not by the kernel's products, which made the plan.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.rotations import Array, running

Real = NDArray[Any]
"""Floating-point numbers of one precision or another."""

_TABLE = 1 << 14
"""Of fewer possible pairs a table tells quickest which come."""
_ONE = np.eye(4)
"""The displacement that is none."""


def extended(poses: Array) -> Array:
    """Return poses in extended precision: products of thousands lose nothing. Shape (...)."""
    return np.asarray(poses, dtype=np.longdouble)


def products(values: Real, counts: ArrayLike, product: Callable[..., Real] = np.matmul, one: ArrayLike = _ONE) -> Real:
    """Return the products of consecutive runs of values, in their precision.

    Args:
        values: What is multiplied. Shape (n, ...).
        counts: How many each run has, in order; n together. Shape (k,).
        product: An associative product of two arrays of values.
        one: What stands for an empty run. Shape (...).

    Returns:
        The products. Shape (k, ...).
    """
    left = np.array(counts, dtype=np.int64)
    while np.any(left > 1):
        # Neighbours in a run are put together, two by two.
        half = (left + 1) // 2
        inside = np.arange(half.sum()) - np.repeat(np.cumsum(half) - half, half)
        even = np.repeat(np.cumsum(left) - left, half) + 2 * inside
        paired = np.flatnonzero(2 * inside + 1 < np.repeat(left, half))
        together = values[even]
        together[paired] = product(together[paired], values[even[paired] + 1])
        values, left = together, half
    if len(values) == len(left):
        return values
    out = np.empty((len(left), *values.shape[1:]), dtype=values.dtype)
    out[:] = one
    out[left > 0] = values
    return out


def product(moves: Array, which: ArrayLike) -> Array:
    """Return the product of displacements that come again and again, in their precision.

    Neighbours are put together two by two, and each pair only once, however often it comes.

    Args:
        moves: The displacements, one or several for each. Shape (k, ..., 4, 4).
        which: Which of them are made, in order. Shape (n,).

    Returns:
        A pose, the identity where none are made, or several. Shape (..., 4, 4).
    """
    left = np.array(which, dtype=np.int64)
    if not len(left):
        return np.broadcast_to(np.eye(4, dtype=moves.dtype), moves.shape[1:])
    while len(left) > 1:
        count = len(moves)
        every = left[:-1:2] * count + left[1::2]
        if count * count < _TABLE:
            comes = np.zeros(count * count, dtype=np.bool_)
            comes[every] = True
            pairs, order = np.flatnonzero(comes), (np.cumsum(comes) - 1)[every]
        else:
            first, order = distinct(every)
            pairs = every[first]
        moves = np.concatenate([moves[pairs // count] @ moves[pairs % count], moves[left[-1:]]])
        left = np.append(order, len(pairs)) if len(left) % 2 else order
    return np.asarray(moves[left[0]])


def running_products(start: Array, moves: Array) -> Array:
    """Return start, start g_1, start g_1 g_2, ... in their precision.

    Args:
        start: A pose. Shape (4, 4).
        moves: Displacements. Shape (n, 4, 4).

    Returns:
        Poses. Shape (n + 1, 4, 4).
    """
    return running(np.concatenate([start[None], moves]), np.matmul)
