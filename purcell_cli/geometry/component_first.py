"""Vectors and matrices by the thousand, components first: every sum or product is one over long rows.

What is done for one shape of the swimmer is small, and thousands go through at once. With the
components on the first axes and the shapes on the last, numpy works on contiguous rows; small
matrices one after the other would take it about ten times as long.
"""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry.rotations import Array


def cross_rows(a: Array, b: Array) -> Array:
    """Return the cross product over the first axis. Shapes (3, ...)."""
    (ax, ay, az), (bx, by, bz) = a, b
    first = ay * bz
    out = np.empty((3, *first.shape), dtype=first.dtype)
    np.subtract(first, az * by, out=out[0])
    np.subtract(az * bx, ax * bz, out=out[1])
    np.subtract(ax * by, ay * bx, out=out[2])
    return out


def dot_rows(a: Array, b: Array) -> Array:
    """Return the inner product over the first axis. Shapes (3, ...) to (...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def solve_positive(matrices: Array, wanted: Array) -> Array:
    """Return the solutions of positive definite systems, matrices first. Shapes (n, k, k) and (n, k) to (n, k)."""
    factors = factored_rows(np.array(matrices.transpose(1, 2, 0), order="C"))
    return np.ascontiguousarray(solved_rows(factors, np.array(wanted.T, order="C")).T)


def factored_rows(matrix: Array) -> Array:
    """Return the factors L and D of positive definite matrices L D L^T, by elimination without pivots.

    Args:
        matrix: Matrices. Shape (k, k, n). Overwritten.

    Returns:
        D on the diagonal and L below it. Shape (k, k, n).
    """
    for j in range(len(matrix) - 1):
        row = matrix[j, j + 1 :].copy()
        factor = np.divide(row, matrix[j, j], out=matrix[j + 1 :, j])
        for i in range(j + 1, len(matrix)):
            matrix[i, i:] -= factor[i - j - 1] * row[i - j - 1 :]
    return matrix


def solved_rows(factors: Array, wanted: Array) -> Array:
    """Return the solutions of positive definite systems.

    Args:
        factors: Their `factored_rows`. Shape (k, k, n).
        wanted: Right sides. Shape (k, ..., n). Overwritten.

    Returns:
        Solutions. Shape (k, ..., n).
    """
    k = len(factors)
    many = wanted.reshape(k, math.prod(wanted.shape[1:-1]), factors.shape[-1])
    for j in range(k - 1):
        many[j + 1 :] -= factors[j + 1 :, j, None] * many[j]
    for j in reversed(range(k)):
        many[j] /= factors[j, j]
        for i in range(j + 1, k):
            many[j] -= factors[i, j] * many[i]
    return many.reshape(wanted.shape)
