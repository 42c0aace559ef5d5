"""Pairs of loops, one forward and one backward, whose common rotation cancels.

Every loop of one limb beside a fixed one, or beside one that its range keeps bent, turns the base far more than it
moves it, and always about nearly the same axis. Two that turn it by as much leave what they do otherwise. Lengths are
in units of L.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, normal_numbers
from purcell_cli.geometry.rotations import Array

_LEAST_PART = 0.3
"""Loops are paired of which the second cancels the first when made smaller, but not by more than this."""
_DIRECTIONS = 80
"""Directions of the displacement space in each of which the best pair is kept."""


def cancelling(twist: Array, cost: Array) -> tuple[NDArray[np.int64], Array]:
    """Return pairs of loops that go far per joint travel in some direction, and how much of the second is played.

    Args:
        twist: The body twist of each loop (v/L, omega). Shape (n, 6).
        cost: Its joint travel, with its approaches [rad]. Shape (n,).

    Returns:
        The numbers of the first and of the second, shape (m, 2), and how much of a cycle of the second cancels the
        first, negative where it is played backward, shape (m,).
    """
    size = np.sqrt(np.sum(twist * twist, axis=1))
    common = twist[int(np.argmax(size / cost))]
    along = matmul(twist, common)
    first, second = (x.ravel() for x in np.meshgrid(np.arange(len(twist)), np.arange(len(twist)), indexing="ij"))
    part = -along[first] / np.where(along[second] == 0.0, np.inf, along[second])
    fair = (np.abs(part) > _LEAST_PART) & (np.abs(part) <= 1.0) & (first != second)
    first, second, part = first[fair], second[fair], part[fair]
    if not len(part):
        return np.empty((0, 2), dtype=np.int64), part
    both = matmul(se3.exp(twist[first]), se3.exp(part[:, None] * twist[second]))
    rate = se3.log(se3.normalised(both)) / (cost[first] + cost[second])[:, None]
    scale = np.max(np.abs(rate), axis=0)
    unit = rate / np.where(scale > 0.0, scale, 1.0)
    clean = np.abs(unit) / np.maximum(np.sqrt(np.sum(unit * unit, axis=1)), 1e-300)[:, None]
    rng = np.random.default_rng(0)
    best = [int(np.argmax(np.abs(unit[:, k]) * clean[:, k])) for k in range(6)]
    best += np.argmax(np.abs(matmul(unit, normal_numbers(rng, (_DIRECTIONS, 6)).T)), axis=0).tolist()
    some = np.array(list(dict.fromkeys(best)))
    return np.stack([first[some], second[some]], axis=1), part[some]
