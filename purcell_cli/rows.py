"""Vectors and matrices by the thousand, components first: every sum or product is one over long rows.

What is done for one shape of the swimmer is small, and thousands go through at once. With the
components on the first axes and the shapes on the last, numpy works on contiguous rows; small
matrices one after the other would take it about ten times as long.
"""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.rotations import Array


def cross_rows(a: Array, b: Array) -> Array:
    """Return the cross product over the first axis. Shapes (3, ...)."""
    out = np.empty((3, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[j] * b[k] - a[k] * b[j]
    return out


def dot_rows(a: Array, b: Array) -> Array:
    """Return the inner product over the first axis. Shapes (3, ...) to (...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def solved_rows(matrix: Array, wanted: Array) -> Array:
    """Return the solutions of positive definite systems, by elimination without pivots.

    Args:
        matrix: Matrices. Shape (k, k, n). Overwritten.
        wanted: Right sides. Shape (k, ..., n). Overwritten.

    Returns:
        Solutions. Shape (k, ..., n).
    """
    k = len(matrix)
    many = wanted.reshape(k, math.prod(wanted.shape[1:-1]), matrix.shape[-1])
    for j in range(k - 1):
        factor = matrix[j + 1 :, j] / matrix[j, j]
        matrix[j + 1 :, j + 1 :] -= factor[:, None] * matrix[j, j + 1 :]
        many[j + 1 :] -= factor[:, None] * many[j]
    for j in reversed(range(k)):
        for i in range(j + 1, k):
            many[j] -= matrix[j, i] * many[i]
        many[j] /= matrix[j, j]
    return many.reshape(wanted.shape)
