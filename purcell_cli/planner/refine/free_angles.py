"""Ties: how the angles of a motion's pieces depend, linearly, on those that are free.

A segment's tie says of every so many of its angles in turn how they depend on as many free ones of their own:
angle = tie @ free. On a segment that is played once each angle is free, or the turns about some axes are; on one that
repeats, the sides of a loop that closes whatever they are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array

HELD = np.empty((1, 0))
"""The tie of angles that stay as they are. Shape (1, 0)."""
RECTANGLE = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""The tie of a rectangle of two joints' angles, which closes whatever its sides are. Shape (4, 2)."""


def free_count(tie: Array | None, angles: int) -> int:
    """Return how many free angles so many angles under a tie (k, m) depend on; None ties nothing."""
    return angles if tie is None else angles // len(tie) * tie.shape[1]


def picked(tie: Array) -> tuple[NDArray[np.int64], Array] | None:
    """Return the free angle that each angle is, but for its sign, and that; -1 and 0 for none.

    Returns:
        Free angles and signs, each of shape (r,); None where a tie mixes free angles, or does not name each of them.
    """
    used = tie != 0.0
    if np.any(np.add.reduce(used, axis=1) > 1) or np.any(np.abs(tie[used]) != 1.0):
        return None
    sign = np.add.reduce(tie, axis=1)
    index = np.where(sign == 0.0, -1, np.argmax(used, axis=1) if tie.shape[1] else 0)
    plain = all(
        np.count_nonzero(tie[:, k] > 0.0) == 1 >= np.count_nonzero(tie[:, k] < 0.0) for k in range(tie.shape[1])
    )
    return (index, sign) if plain else None


@frozen_dataclass(eq=False)
class _Mixed:
    """Free angles that a segment's angles mix: which those are, which these are, and the tie of every so many."""

    free: slice
    angles: slice
    tie: Array


@frozen_dataclass(eq=False)
class FreeAngles:
    """The free angles of a motion: angle k is sign[k] times free angle index[k]; -1 is none, or more than one.

    Attributes:
        index: The free angle of each angle. Shape (k,).
        sign: Its sign. Shape (k,).
        weight: Joint travel per free angle. Shape (n,).
        all: Whether every angle is free, in order.
        own: The angles that are their free angle. Shape (a,).
        opposite: Those that are its negative. Shape (b,).
        mixed: The segments whose angles mix free ones.
    """

    index: NDArray[np.int64]
    sign: Array
    weight: Array
    all: bool
    own: NDArray[np.int64]
    opposite: NDArray[np.int64]
    mixed: tuple[_Mixed, ...] = ()

    @classmethod
    def of(cls, segments: Sequence[tuple[int, Array | None, int]]) -> FreeAngles:
        """Return the free angles of segments: how many angles each has, their tie, and how often they are played."""
        if all(tie is None for _, tie, _ in segments):
            n = sum(count for count, *_ in segments)
            every = np.arange(n)
            return cls(every, np.ones(n), np.ones(n), True, every, every[:0])
        index: list[NDArray[np.int64]] = []
        sign: list[Array] = []
        weight: list[Array] = []
        mixed: list[_Mixed] = []
        first = begun = 0
        for n, tie, cycles in segments:
            many = free_count(tie, n)
            if tie is None:
                index.append(np.arange(first, first + n))
                sign.append(np.ones(n))
                weight.append(np.ones(n))
            else:
                times = n // len(tie)
                known = picked(tie)
                if known is None:
                    mixed.append(_Mixed(slice(first, first + many), slice(begun, begun + n), tie))
                    known = np.full(len(tie), -1), np.zeros(len(tie))
                starts = first + tie.shape[1] * np.arange(times)[:, None]
                index.append(np.where(known[0] < 0, -1, starts + known[0]).ravel())
                sign.append(np.tile(known[1], times))
                weight.append(np.tile(cycles * np.add.reduce(np.abs(tie), axis=0), times))
            first, begun = first + many, begun + n
        signs, weights = np.concatenate(sign), np.concatenate(weight)
        own, opposite = np.flatnonzero(signs > 0), np.flatnonzero(signs < 0)
        return cls(np.concatenate(index), signs, weights, False, own, opposite, tuple(mixed))

    def __len__(self) -> int:
        return len(self.weight)

    def of_angles(self, angle: Array) -> Array:
        """Return the free angles of a motion's angles [rad]. Shape (k,) to (n,)."""
        if self.all:
            return angle.copy()
        out = np.zeros(len(self))
        out[self.index[self.own]] = angle[self.own]
        for part in self.mixed:  # the columns of a tie are orthogonal
            size = np.add.reduce(part.tie * part.tie, axis=0)
            out[part.free] = (matmul(angle[part.angles].reshape(-1, len(part.tie)), part.tie) / size).ravel()
        return out

    def made(self, free: Array) -> Array:
        """Return the angles that free ones make, 0 where those have no part [rad]. Shape (n,) to (k,)."""
        if self.all:
            return free
        out = self.sign * free[self.index] if len(free) else np.zeros(len(self.sign))
        for part in self.mixed:
            out[part.angles] = matmul(free[part.free].reshape(-1, part.tie.shape[1]), part.tie.T).ravel()
        return out

    def angles_at(self, free: Array, given: Array) -> Array:
        """Return a motion's angles at some free ones, given where those have no part [rad]. Shape (n,) to (k,)."""
        if self.all:
            return free
        held = self.index < 0
        for part in self.mixed:
            held[part.angles] = False
        return np.where(held, given, self.made(free))

    def by_free(self, columns: Array) -> Array:
        """Return derivatives by the free angles, of those by every angle. Shape (m, k) to (m, n)."""
        if self.all:
            return columns
        out = np.zeros((len(columns), len(self)))
        out[:, self.index[self.own]] = columns[:, self.own]
        out[:, self.index[self.opposite]] -= columns[:, self.opposite]
        for part in self.mixed:
            given = columns[:, part.angles].reshape(-1, len(part.tie))
            out[:, part.free] = matmul(given, part.tie).reshape(len(columns), part.free.stop - part.free.start)
        return out
