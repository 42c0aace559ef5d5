"""Truncated Taylor polynomials in several variables, as arrays of coefficients.

A polynomial with values in an array of shape (...) is an array (monomials, ...). Sums are those of
numpy; products, quotients and derivatives are here, exact but for rounding.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.rotations import Array

Indices = NDArray[np.int64]


class Taylor:
    """The polynomials in some variables up to a total degree: their monomials and how these multiply.

    Args:
        variables: How many variables there are.
        degree: The largest total degree that is kept.
    """

    def __init__(self, variables: int, degree: int) -> None:
        self.variables, self.degree = variables, degree
        powers = [
            np.bincount(np.array(choice, dtype=np.int64), minlength=variables)
            for total in range(degree + 1)
            for choice in itertools.combinations_with_replacement(range(variables), total)
        ]
        self.powers: Indices = np.array(powers).reshape(-1, variables)
        self.totals: Indices = self.powers.sum(axis=1)
        self._place = {tuple(p): k for k, p in enumerate(self.powers.tolist())}
        first, second = np.nonzero(self.totals[:, None] + self.totals <= degree)
        whole = np.array([self._place[tuple(p)] for p in (self.powers[first] + self.powers[second]).tolist()])
        order = np.argsort(whole, kind="stable")
        self._first, self._second = first[order], second[order]
        self._starts: Indices = np.flatnonzero(np.diff(whole[order], prepend=-1))

    def __len__(self) -> int:
        return len(self.powers)

    def constant(self, value: Array) -> Array:
        """Return a value that does not depend on the variables. Shape (...) to (monomials, ...)."""
        out = np.zeros((len(self), *np.shape(value)))
        out[0] = value
        return out

    def variable(self, index: int) -> Array:
        """Return one of the variables. Shape (monomials,)."""
        out = np.zeros(len(self))
        if self.degree:
            out[1 + index] = 1.0
        return out

    def product(self, a: Array, b: Array, multiply: Callable[[Array, Array], Array] = np.multiply) -> Array:
        """Return a product of polynomials.

        Args:
            a: The first. Shape (monomials, ...).
            b: The second. Shape (monomials, ...).
            multiply: The bilinear product of their coefficients, row by row.
        """
        terms = multiply(a[self._first], b[self._second])
        return np.asarray(np.add.reduceat(terms, self._starts, axis=0))

    def solved(self, matrix: Array, right: Array) -> Array:
        """Return the solution of linear equations, degree by degree.

        Args:
            matrix: Matrices, regular at the origin. Shape (monomials, n, n).
            right: Right sides. Shape (monomials, n, m).

        Returns:
            Solutions. Shape (monomials, n, m).
        """
        inner, out = np.linalg.inv(matrix[0]), np.zeros_like(right)
        rest = matrix.copy()
        rest[0] = 0.0
        for total in range(self.degree + 1):
            mine = self.totals == total
            out[mine] = inner @ (right - self.product(rest, out, np.matmul))[mine]
        return out

    def derivative(self, a: Array, index: int) -> Array:
        """Return a partial derivative; it is exact to one degree less. Shape (monomials, ...)."""
        out = np.zeros_like(a)
        have = np.flatnonzero(self.powers[:, index])
        lower = self.powers[have].copy()
        lower[:, index] -= 1
        into = [self._place[tuple(p)] for p in lower.tolist()]
        out[into] = a[have] * self.powers[have, index].reshape(-1, *[1] * (a.ndim - 1))
        return out


@functools.lru_cache(maxsize=16)
def taylor(variables: int, degree: int) -> Taylor:
    """Return the polynomials in some variables up to a degree, their tables made once."""
    return Taylor(variables, degree)
