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
        whole = np.broadcast_shapes(batch, other) if batch and other else batch or other
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


def _pairs(first: ArrayLike, second: ArrayLike) -> tuple[Array, Array]:
    """Return arrays of vectors made as many as each other."""
    a, b = doubles(first, "first"), doubles(second, "second")
    if a.ndim < 1 or b.ndim < 1 or a.shape[-1] != b.shape[-1]:
        raise ValueError(f"vectors (..., n) are wanted, found {a.shape} and {b.shape}")
    if a.shape != b.shape:
        whole = np.broadcast_shapes(a.shape, b.shape)
        a, b = (x if x.shape == whole else np.array(np.broadcast_to(x, whole), order="C") for x in (a, b))
    return a, b


def inner(first: ArrayLike, second: ArrayLike) -> Array:
    """Return inner products over the last axis. Shapes (..., n), broadcast, to (...)."""
    a, b = _pairs(first, second)
    out = np.zeros(a.shape[:-1])
    if a.size:
        KERNEL.purcell_inner(out.size, a.shape[-1], address(a), address(b), address(out))
    return out


def cross(first: ArrayLike, second: ArrayLike) -> Array:
    """Return cross products over the last axis. Shapes (..., 3), broadcast."""
    a, b = _pairs(first, second)
    if a.shape[-1] != 3:
        raise ValueError(f"vectors (..., 3) are wanted, found {a.shape}")
    out = np.empty(a.shape)
    if a.size:
        KERNEL.purcell_cross(a.size // 3, address(a), address(b), address(out))
    return out


def nearest_on_segments(gap: ArrayLike, first: ArrayLike, second: ArrayLike) -> Array:
    """Return s, t and the distance where segments p + s first and q + t second, s and t from 0 to 1, are nearest.

    Args:
        gap: Vectors p - q between the beginnings. Shape (..., 3).
        first: The first segments; they may be points. Shape (..., 3).
        second: The second segments. Shape (..., 3).

    Returns:
        Shape (..., 3).
    """
    between = doubles(gap, "gap")
    if between.ndim < 1 or between.shape[-1] != 3:
        raise ValueError(f"gap: vectors (..., 3) are wanted, found {between.shape}")
    one, two = doubles(first, "first", between.shape), doubles(second, "second", between.shape)
    out = np.empty(between.shape)
    if out.size:
        KERNEL.purcell_segments(out.size // 3, address(between), address(one), address(two), address(out))
    return out


def least_steps(
    columns: ArrayLike, wanted: ArrayLike, begun: ArrayLike, loose: ArrayLike, low: ArrayLike, high: ArrayLike
) -> Array:
    """Return the steps nearest to others, between bounds, that meet six equations as far as they can.

    Args:
        columns: The equations' matrices. Shape (n, 6, k).
        wanted: Their right sides. Shape (n, 6).
        begun: The other steps. Shape (n, k).
        loose: How loosely each unknown keeps to them, the inverse weights. Shape (n, k).
        low: The least values. Shape (n, k).
        high: The greatest values. Shape (n, k).

    Returns:
        Shape (n, k).
    """
    matrix = doubles(columns, "columns", (-1, 6, -1))
    n, _, k = matrix.shape
    right = doubles(wanted, "wanted", (n, 6))
    names = ("begun", "loose", "low", "high")
    rest = [doubles(part, name, (n, k)) for part, name in zip((begun, loose, low, high), names, strict=True)]
    out, room = np.empty((n, k)), np.empty((2, k))
    if out.size:
        places = (address(part) for part in (matrix, right, *rest, room, out))
        KERNEL.purcell_least_steps(n, k, *places)
    return out
