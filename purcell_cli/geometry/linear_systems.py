"""Linear systems and least squares in an order of operations that is the same on every processor.

They are for few equations: LAPACK is quicker, but its last bits depend on the processor (see `reproducible`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.reproducible import Array

_SWEEPS, _SKEW = 40, 3e-16
"""Jacobi sweeps at most, and the cosine between two columns that counts as none; some eight sweeps are made."""


def solve(matrix: ArrayLike, wanted: ArrayLike) -> Array:
    """Return the solutions of square systems, by Gauss-Jordan elimination with the largest pivot of each column.

    Args:
        matrix: Matrices. Shape (..., k, k).
        wanted: Right sides, or one vector. Shape (..., k, m).

    Returns:
        Solutions; not finite where a matrix is singular. Shape (..., k, m).
    """
    a, b = np.asarray(matrix, dtype=np.float64), np.asarray(wanted, dtype=np.float64)
    if b.ndim == 1:
        return solve(a, b[:, None])[..., 0]
    batch = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    k = a.shape[-1]
    both = np.concatenate(
        [np.broadcast_to(a, (*batch, k, k)), np.broadcast_to(b, (*batch, *b.shape[-2:]))], axis=-1
    ).reshape(math.prod(batch), k, k + b.shape[-1])
    every = np.arange(len(both))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for j in range(k):
            best = j + np.argmax(np.abs(both[:, j:, j]), axis=1)
            row = both[every, best, j:]
            both[every, best, j:] = both[:, j, j:]
            row = row / row[:, :1]
            factor = both[:, :, j].copy()
            factor[:, j] = 0.0
            both[:, :, j:] -= factor[:, :, None] * row[:, None]
            both[:, j, j:] = row
    return np.asarray(both[:, :, k:].reshape(*batch, k, b.shape[-1]))


def inverse(matrix: ArrayLike) -> Array:
    """Return the inverses of square matrices. Shape (..., k, k)."""
    return solve(matrix, np.eye(np.shape(matrix)[-1]))


def orthogonal_columns(matrix: ArrayLike, weakest: float = 0.0) -> tuple[Array, Array]:
    """Return Q and R of a matrix, by modified Gram and Schmidt with the longest column left taken next.

    Args:
        matrix: Shape (n, k).
        weakest: Columns of which less than this part of the longest column is left depend on those before.

    Returns:
        Orthonormal columns, as many as are independent, shape (n, r), and what they make the matrix of, shape (r, k).
    """
    rows = np.array(np.asarray(matrix, dtype=np.float64).T, order="C")
    basis, made = np.zeros((min(rows.shape), rows.shape[1])), np.zeros((min(rows.shape), len(rows)))
    largest, count = 0.0, 0
    for j in range(len(basis)):
        sizes = np.add.reduce(rows * rows, axis=1)
        best = int(np.argmax(sizes))
        size = math.sqrt(sizes[best])
        largest = max(largest, size)
        if size <= weakest * largest:
            break
        vector = rows[best] / size
        if j:  # cleared of the earlier ones once more, which rounding has left in it
            vector = vector - np.add.reduce(np.add.reduce(basis[:j] * vector, axis=1)[:, None] * basis[:j], axis=0)
            vector /= math.sqrt(np.add.reduce(vector * vector))
        basis[j] = vector
        made[j] = np.add.reduce(rows * vector, axis=1)
        rows -= made[j][:, None] * vector
        rows[best] = 0.0
        count = j + 1
    return basis[:count].T, made[:count]


def least_squares(matrix: ArrayLike, wanted: ArrayLike, weakest: float = 1e-15) -> Array:
    """Return the least x for which matrix x comes nearest to a vector, by a complete orthogonal factorisation.

    Args:
        matrix: Shape (n, k).
        wanted: Shape (n,).
        weakest: Rows of which less than this part of the longest row is left depend on the others.

    Returns:
        Shape (k,).
    """
    basis, made = orthogonal_columns(np.asarray(matrix).T, weakest)  # matrix = made^T basis^T
    across, triangle = orthogonal_columns(made.T)
    lead = np.add.reduce(across.T * np.asarray(wanted, dtype=np.float64), axis=1)
    return np.asarray(np.add.reduce(basis * solve(triangle, lead), axis=1))


def singular_values(matrix: ArrayLike) -> tuple[Array, Array, Array]:
    """Return U, s and V^T of a matrix, the largest value first, by one-sided Jacobi rotations (Hestenes 1958).

    All columns are turned in pairs at once, in the order of a tournament (Brent and Luk 1985).

    Args:
        matrix: Shape (n, k).

    Returns:
        Shapes (n, r), (r,) and (r, k), r the smaller of n and k.
    """
    a = np.array(matrix, dtype=np.float64)
    if a.shape[0] < a.shape[1]:
        u, s, vt = singular_values(a.T)
        return vt.T, s, u.T
    n, k = a.shape
    both = np.concatenate([a.T, np.eye(k)], axis=1)
    players = list(range(k + k % 2))
    half = len(players) // 2
    for _ in range(_SWEEPS):
        skew = 0.0
        for _ in range(max(len(players) - 1, 1)):
            pairs = [pair for pair in zip(players[:half], players[: half - 1 : -1], strict=True) if max(pair) < k]
            players = [players[0], players[-1], *players[1:-1]]
            if not pairs:
                continue
            i, j = np.array(pairs).T
            left, right = both[i], both[j]
            p, q, cross = (
                np.add.reduce(x[:, :n] * y[:, :n], axis=1) for x, y in ((left, left), (right, right), (left, right))
            )
            size = np.sqrt(p * q)
            turned = np.abs(cross) > _SKEW * size
            skew = max(skew, float(np.max(np.where(turned, 1.0, 0.0))))
            slope = np.where(turned, (q - p) / np.where(turned, 2.0 * cross, 1.0), 0.0)
            tangent = np.where(turned, np.copysign(1.0, slope) / (np.abs(slope) + np.sqrt(1.0 + slope * slope)), 0.0)
            cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
            sine = cosine * tangent
            both[i] = cosine[:, None] * left - sine[:, None] * right
            both[j] = sine[:, None] * left + cosine[:, None] * right
        if skew == 0.0:
            break
    size = np.sqrt(np.add.reduce(both[:, :n] * both[:, :n], axis=1))
    order = np.argsort(-size, kind="stable")
    columns = both[order, :n] / np.where(size[order] > 0.0, size[order], 1.0)[:, None]
    return columns.T, size[order], both[order, n:]
