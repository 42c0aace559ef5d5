"""The rank of some twists of the base, and what the decision hangs on. Twists are in units of L: `fields`."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array

WEAK = 1e-2
"""A singular value below this [L, rad per rad^depth] is weak: the direction is there, but hardly of use."""

ROUNDING = 1e3 * float(np.finfo(np.float64).eps)
"""What rounding can leave of a singular value that is zero, per largest one; tests compare with 60 digits."""

_DOUBT = 100.0
"""A singular value that counts, but is within this factor of what rounding can leave, is not decided."""


@frozen_dataclass(eq=False)
class Rank:
    """The rank of some twists, and what it hangs on.

    Attributes:
        dimension: How many directions are above rounding, each base direction measured by its own largest twist.
        singular_values: Of all the twists, largest first [L, rad]. Shape (k,).
        floor: What rounding can leave of a zero singular value, by the largest.
        basis: An orthonormal basis of the span. Shape (directions, dimension).
        weakest: How much of each direction is in those of the smallest singular value. Shape (directions,).
    """

    dimension: int
    singular_values: Array
    floor: float
    basis: Array
    weakest: Array

    @property
    def clear_dimension(self) -> int:
        """How many singular values are not weak."""
        return int(np.sum(self.singular_values[: self.dimension] >= WEAK))

    @property
    def smallest(self) -> float:
        """The smallest singular value that counts, 0 where none does."""
        return float(self.singular_values[self.dimension - 1]) if self.dimension else 0.0

    @property
    def gap(self) -> float:
        """The smallest singular value that counts over the largest that does not, or over rounding; infinite over 0."""
        below = max(self.floor, float(self.singular_values[self.dimension :].max(initial=0.0)))
        return self.smallest / below if below else math.inf

    @property
    def robustness(self) -> Literal["clear", "weak", "undecided"]:
        """How safe the decision is: clear; weak, where a direction hangs on little; or undecided by rounding."""
        if self.dimension and self.smallest < _DOUBT * self.floor:
            return "undecided"
        return "clear" if self.clear_dimension == self.dimension else "weak"


def rank_of(vectors: Array, rounding: float = ROUNDING) -> Rank:
    """Return the rank of twists. Shape (n, directions).

    Spin drag makes the roll of a thin swimmer's brackets many times larger than all else, and rounding comes with
    it. Each direction is therefore scaled by its largest entry before the rank is counted.

    Args:
        vectors: The twists.
        rounding: What is left of a twist that is zero, per largest one.
    """
    left, values = _svd(vectors.T)
    floor = rounding * float(values.max(initial=0.0))
    size = np.max(np.abs(vectors), axis=0, initial=0.0)
    size[size < rounding] = 0.0
    scaled = np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0.0)
    directions, shares = _svd(scaled.T)
    dimension = int(np.sum(shares > rounding * shares.max(initial=0.0)))
    basis = np.linalg.qr(size[:, None] * directions[:, :dimension])[0]
    values.setflags(write=False)
    least = values <= max(floor, (1.0 + 1e-6) * float(values[-1]))
    return Rank(dimension, values, floor, basis, np.round(np.sum(left[:, least] ** 2, axis=1), 6))


def _svd(matrix: Array) -> tuple[Array, Array]:
    """Return the left singular vectors, all of them, and as many singular values; columns may be many."""
    rows, columns = matrix.shape
    left, values, _ = np.linalg.svd(matrix, full_matrices=columns < rows)
    return left, np.concatenate([values, np.zeros(len(left) - len(values))])


def simplest(basis: Array) -> Array:
    """Return a subspace's basis with a one in a coordinate of its own in each row, and zeros there elsewhere.

    Args:
        basis: Orthonormal columns. Shape (n, k).

    Returns:
        Rows. Shape (k, n).
    """
    projector, pivots = basis @ basis.T, []
    rest = projector.copy()
    for _ in range(basis.shape[1]):
        sizes = np.round(np.linalg.norm(rest, axis=0), 9)
        pivot = int(np.argmax(sizes))
        pivots.append(pivot)
        unit = rest[:, pivot] / np.linalg.norm(rest[:, pivot])
        rest = rest - np.outer(unit, unit @ rest)
    pivots.sort()
    rows = np.linalg.solve(basis[pivots], np.eye(len(pivots))).T @ basis.T
    return np.where(np.abs(rows) < 1e-9, 0.0, rows)


def null_space(direct: Array, rounding: float = ROUNDING) -> Array:
    """Return the limb rates that leave the base still, in their simplest form: a row each.

    Args:
        direct: The twists per rate. Shape (controls, directions).
        rounding: What is left of a twist that is zero, per largest one.
    """
    left, values, _ = np.linalg.svd(direct)
    kept = int(np.sum(values > rounding * float(values.max(initial=0.0))))
    return simplest(left[:, kept:])
