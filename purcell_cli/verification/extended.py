"""Products of displacements in extended precision, where the machine has it, for the certificate alone.

In numpy and not by the kernel, which made the plan.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.rotations import Array, running


def extended(poses: Array) -> Array:
    """Return poses in extended precision: products of thousands lose nothing. Shape (...)."""
    return np.asarray(poses, dtype=np.longdouble)


def products(poses: Array, counts: ArrayLike) -> Array:
    """Return the products of consecutive runs of displacements, in their precision.

    Args:
        poses: Displacements. Shape (n, 4, 4).
        counts: How many each run has, in order; n together. Shape (k,).

    Returns:
        Poses, the identity for an empty run. Shape (k, 4, 4).
    """
    left = np.array(counts, dtype=np.int64)
    while np.any(left > 1):
        # Neighbours in a run are put together, two by two.
        half = (left + 1) // 2
        inside = np.arange(half.sum()) - np.repeat(np.cumsum(half) - half, half)
        even = np.repeat(np.cumsum(left) - left, half) + 2 * inside
        paired = np.flatnonzero(2 * inside + 1 < np.repeat(left, half))
        together = poses[even]
        together[paired] = together[paired] @ poses[even[paired] + 1]
        poses, left = together, half
    out = np.tile(np.eye(4, dtype=poses.dtype), (len(left), 1, 1))
    out[left > 0] = poses
    return out


def product(moves: Array, which: ArrayLike) -> Array:
    """Return the product of displacements that come again and again, in their precision.

    Neighbours are put together two by two, and each pair only once, however often it comes.

    Args:
        moves: The displacements. Shape (k, 4, 4).
        which: Which of them are made, in order. Shape (n,).

    Returns:
        A pose, the identity where none are made. Shape (4, 4).
    """
    left = np.array(which, dtype=np.int64)
    if not len(left):
        return np.eye(4, dtype=moves.dtype)
    while len(left) > 1:
        count = len(moves)
        every = left[:-1:2] * count + left[1::2]
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
