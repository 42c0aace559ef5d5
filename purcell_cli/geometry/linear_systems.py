"""Linear systems and least squares in an order of operations that is the same on every processor.

They are for few equations; the kernel does the work (`linear.c`). LAPACK's last bits depend on the processor.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.reproducible import Array
from purcell_cli.kernel import linear


def solve(matrix: ArrayLike, wanted: ArrayLike) -> Array:
    """Return the solutions of square systems, by elimination with the largest pivot of each column.

    Args:
        matrix: Matrices. Shape (..., k, k).
        wanted: Right sides, or one vector. Shape (..., k, m).

    Returns:
        Solutions; not finite where a matrix is singular. Shape (..., k, m).
    """
    b = np.asarray(wanted, dtype=np.float64)
    return linear.solve(matrix, b[:, None])[..., 0] if b.ndim == 1 else linear.solve(matrix, b)


def inverse(matrix: ArrayLike) -> Array:
    """Return the inverses of square matrices. Shape (..., k, k)."""
    return solve(matrix, np.eye(np.shape(matrix)[-1]))


def least_squares(matrix: ArrayLike, wanted: ArrayLike, weakest: float = 1e-15) -> Array:
    """Return the least x for which matrix x comes nearest to a vector, by a complete orthogonal factorisation.

    Args:
        matrix: Shape (n, k).
        wanted: Shape (n,).
        weakest: Rows of which less than this part of the longest row is left depend on the others.

    Returns:
        Shape (k,).
    """
    rows, made = linear.orthogonal_rows(matrix, weakest)  # matrix = made^T rows
    across, triangle = linear.orthogonal_rows(made, 0.0)  # made = triangle^T across
    lead = linear.products(across, np.asarray(wanted, dtype=np.float64)[:, None])
    out: Array = linear.products(linear.solve(triangle, lead).T, rows)[0]
    return out


def singular_values(matrix: ArrayLike) -> tuple[Array, Array, Array]:
    """Return U, s and V^T of a matrix, the largest value first, by one-sided Jacobi rotations (Hestenes 1958).

    Args:
        matrix: Shape (n, k).

    Returns:
        Shapes (n, r), (r,) and (r, k), r the smaller of n and k.
    """
    a = np.asarray(matrix, dtype=np.float64)
    if a.shape[0] < a.shape[1]:
        u, s, vt = singular_values(a.T)
        return vt.T, s, u.T
    columns, turned = linear.orthogonal_by_rotations(a.T)
    size = np.sqrt(np.add.reduce(columns * columns, axis=1))
    order = np.argsort(-size, kind="stable")
    unit = columns[order] / np.where(size[order] > 0.0, size[order], 1.0)[:, None]
    return unit.T, size[order], turned[order]
