"""A measured motion in windows, and by how much a model's motion is off in each.

In a window the model swims along the measured limb motion, rows being joined by rotations at a constant rate; where
it begins is fitted to all of the window's rows, so that no row's noise counts more than another's. Errors of the model
add up along a window, as they do in a plan; across windows they are forgotten. Conventions: `rotations`.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.drag_factors import Factor, with_factors
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.mechanics.lift import EXACT, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.measured_trajectory import MeasuredTrajectory

LARGEST_TURN_RAD = 0.5
"""A limb that turns by more between two rows may have gone another way than straight [rad]: a window ends there."""
MOST_TRAVEL_RAD = 10.0
"""Joint travel of a window at most [rad]. Longer ones tell hardly more: at 1e-3 L and 0.1 degree of noise ten rad give
standard errors 10 to 20 % above those of one window of 200 rad, 2 rad 50 to 100 %."""
LEAST_TRAVEL_RAD = 5.0
"""Joint travel of a window at least [rad]: a stroke's, so that what a whole stroke does counts."""
WANTED = 20
"""Windows that are wanted: so many tell how far their errors go together."""
LEAST_ROWS = 4
"""Rows of a window that show the base, at least: below, where it begins takes most of what they tell."""
_STEP = 1e-4
"""The change of a factor's logarithm by which derivatives are taken: their error is as small a part."""


@frozen_dataclass(eq=False)
class Window:
    """A part of a measured motion.

    Attributes:
        pieces: The limbs' motion from row to row.
        rows: The rows, from the window's first, in which the base was seen. Shape (m,).
        pose: The base's poses in those rows, from the first of them, in units of L. Shape (m, 4, 4).
    """

    pieces: Pieces
    rows: NDArray[np.int64]
    pose: Array

    def moves(self, swimmer: Swimmer) -> Array:
        """Return a swimmer's displacements from row to row, in units of L. Shape (n, 4, 4)."""
        out = piece_displacements(swimmer, self.pieces, EXACT)
        out[:, :3, 3] /= swimmer.length_m
        return out


@frozen_dataclass(eq=False)
class Misfit:
    """By how much a model is off in a window, to first order in what is off.

    Attributes:
        off: What must still be done in each row, in the base's frame [L, rad]. Shape (m, 6).
        change: How much of it a change of each factor's logarithm does. Shape (m, 6, k).
        begun: How much a displacement where the window begins does. Shape (m, 6, 6).
    """

    off: Array
    change: Array
    begun: Array

    def without_beginning(self, weights: Array) -> Misfit:
        """Return the misfit where the window begins as fits best, rows counting by weights. Shape (6,)."""
        m, k = self.change.shape[0], self.change.shape[-1]
        begun = (self.begun * weights[:, None]).reshape(6 * m, 6)
        rest = np.concatenate([self.off[..., None], self.change], axis=-1) * weights[:, None]
        flat = rest.reshape(6 * m, 1 + k)
        best = solve(matmul(begun.T, begun), matmul(begun.T, flat))
        left = ((flat - matmul(begun, best)) / np.tile(weights, m)[:, None]).reshape(m, 6, 1 + k)
        return Misfit(left[..., 0], left[..., 1:], self.begun)


def windows_of(measured: MeasuredTrajectory, length_m: float) -> list[Window]:
    """Return a measured motion in windows of like joint travel, without gaps.

    Args:
        measured: The motion.
        length_m: The swimmer's L [m].
    """
    turns = turns_between(measured.shape)
    size = np.max(norm(turns), axis=-1)
    pose = measured.pose.copy()
    pose[:, :3, 3] /= length_m
    travel = np.sum(norm(turns), axis=-1)
    travel[size > LARGEST_TURN_RAD] = 0.0
    most = min(MOST_TRAVEL_RAD, max(LEAST_TRAVEL_RAD, float(np.sum(travel)) / WANTED))
    edges = np.flatnonzero(np.concatenate([[True], size > LARGEST_TURN_RAD, [True]]))
    out = []
    for low, high in zip(edges[:-1].tolist(), (edges[1:] - 1).tolist(), strict=True):
        gone = np.concatenate([[0.0], np.cumsum(travel[low:high])])
        count = max(1, round(float(gone[-1]) / most))
        cuts = low + np.searchsorted(gone, np.arange(1, count) * (gone[-1] / count))
        ends = np.unique([low, *cuts.tolist(), high]).tolist()
        for a, b in itertools.pairwise(ends):
            rows = np.flatnonzero(measured.seen[a : b + 1])
            if len(rows) < LEAST_ROWS or not gone[b - low] > gone[a - low]:
                continue
            rates = turns[a:b].reshape(-1, 6)
            pieces = Pieces(measured.shape[a:b], rates, np.ones(b - a))
            first = pose[a + rows[0]]
            out.append(Window(pieces, rows, matmul(se3.inverse(first), pose[a + rows])))
    return out


def turns_between(shape: Array) -> Array:
    """Return the rotation vectors of the limbs from row to row, in their own frames [rad]. Shape (n - 1, 2, 3)."""
    return as_vector(matmul(np.swapaxes(shape[:-1], -1, -2), shape[1:]))


def misfit(window: Window, guess: Swimmer, factors: Sequence[Factor], logs: Array, derivatives: bool = True) -> Misfit:
    """Return by how much a model is off in a window.

    Args:
        window: The window.
        guess: The swimmer that the factors are for.
        factors: What is multiplied.
        logs: The factors' logarithms. Shape (k,).
        derivatives: Whether the changes by the factors are wanted; else they are 0.

    Raises:
        ParameterError: No link can have such a drag.
    """
    moves = window.moves(with_factors(guess, factors, logs.tolist()))
    made = se3.prefix_products(moves)
    here = made[window.rows]
    first = matmul(se3.inverse(here[0]), here)
    off = se3.log(se3.normalised(matmul(se3.inverse(first), window.pose)))
    change = np.zeros((len(here), 6, len(logs)))
    for k in range(len(logs)) if derivatives else ():
        other, step = _beside(window, guess, factors, logs, k)
        twist = se3.log(se3.normalised(matmul(se3.inverse(moves), other))) / step
        sums = np.cumsum(matmul(se3.adjoint(made[1:]), twist[..., None]), axis=0)
        sums = np.concatenate([np.zeros((1, 6, 1)), sums])[window.rows]
        change[..., k] = matmul(se3.adjoint(se3.inverse(here)), sums - sums[0])[..., 0]
    return Misfit(off, change, se3.adjoint(se3.inverse(first)))


def _beside(window: Window, guess: Swimmer, factors: Sequence[Factor], logs: Array, k: int) -> tuple[Array, float]:
    """Return the displacements with one logarithm a step aside, on the side where links can have it, and the step."""
    for step in (_STEP, -_STEP):
        aside = logs.copy()
        aside[k] += step
        try:
            return window.moves(with_factors(guess, factors, aside.tolist())), step
        except ParameterError:
            continue
    raise ParameterError(f"{factors[k].name}: a drag that may change is wanted, found one between two bounds")
