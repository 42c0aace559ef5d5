"""Products, linear systems and orthogonal factors of small matrices, by the kernel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def products(first: ArrayLike, second: ArrayLike) -> Array:
    """Return products of matrices, each sum from the first term on.

    Args:
        first: Shape (..., n, k).
        second: Shape (..., k, m), broadcast against the first.

    Returns:
        Shape (..., n, m).
    """
    a, b = doubles(first, "first"), doubles(second, "second")
    if a.ndim < 2 or b.ndim < 2 or a.shape[-1] != b.shape[-2]:
        raise ValueError(f"matrices (..., n, k) and (..., k, m) are wanted, found {a.shape} and {b.shape}")
    (n, k), m = a.shape[-2:], b.shape[-1]
    batch, other = a.shape[:-2], b.shape[:-2]
    if batch != other:
        whole = np.broadcast_shapes(batch, other)
        one, two = math.prod(batch) == 1, math.prod(other) == 1
        if not (one or batch == whole):
            a = np.ascontiguousarray(np.broadcast_to(a, (*whole, n, k)))
        if not (two or other == whole):
            b = np.ascontiguousarray(np.broadcast_to(b, (*whole, k, m)))
        steps = (0 if one else n * k), (0 if two else k * m)
        batch = whole
    else:
        steps = n * k, k * m
    out = np.empty((*batch, n, m))
    if not k:
        out[...] = 0.0
    elif out.size:
        count = out.size // (n * m)
        KERNEL.purcell_products(count, n, k, m, address(a), steps[0], address(b), steps[1], address(out))
    return out


def solve(matrix: ArrayLike, wanted: ArrayLike) -> Array:
    """Return the solutions of square systems, not finite where a matrix is singular.

    Args:
        matrix: Shape (..., k, k).
        wanted: Right sides. Shape (..., k, m), broadcast against the matrices.

    Returns:
        Shape (..., k, m).
    """
    a, b = doubles(matrix, "matrix"), doubles(wanted, "wanted")
    if a.ndim < 2 or b.ndim < 2 or a.shape[-1] != a.shape[-2] or a.shape[-1] != b.shape[-2]:
        raise ValueError(f"matrices (..., k, k) and (..., k, m) are wanted, found {a.shape} and {b.shape}")
    batch = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    (k, m), count = b.shape[-2:], math.prod(batch)
    system = np.array(np.broadcast_to(a, (*batch, k, k)), order="C")
    out = np.array(np.broadcast_to(b, (*batch, k, m)), order="C")
    if out.size:
        KERNEL.purcell_solve(count, k, m, address(system), address(out))
    return out


def orthogonal_rows(matrix: ArrayLike, weakest: float) -> tuple[Array, Array]:
    """Return orthonormal rows and what they make a matrix of, by Gram and Schmidt with the longest row taken next.

    Args:
        matrix: Shape (k, n).
        weakest: Rows of which less than this part of the longest row is left depend on those before.

    Returns:
        Shapes (r, n) and (r, k), r rows being independent.
    """
    rows = np.array(doubles(matrix, "matrix", (-1, -1)), order="C")
    k, n = rows.shape
    basis, made = np.empty((min(k, n), n)), np.empty((min(k, n), k))
    if not rows.size:
        return basis, made
    count = KERNEL.purcell_orthogonal_rows(k, n, address(rows), float(weakest), address(basis), address(made))
    return basis[:count], made[:count]


def orthogonal_by_rotations(matrix: ArrayLike) -> tuple[Array, Array]:
    """Return rows made orthogonal by rotations, and the rotations.

    Args:
        matrix: Shape (k, n), k at most n.

    Returns:
        Shapes (k, n) and (k, k), the first being the second times the matrix.
    """
    rows = doubles(matrix, "matrix", (-1, -1))
    k, n = rows.shape
    both = np.concatenate([rows, np.eye(k)], axis=1)
    if both.size:
        KERNEL.purcell_orthogonal_by_rotations(k, n, address(both))
    return both[:, :n], both[:, n:]
