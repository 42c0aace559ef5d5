"""Gauss collocation of the lift: nodes and weights of each accuracy, and the flow of a swimmer by them."""

from __future__ import annotations

import functools

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import gauss_legendre
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.flow import Flow, Rule
from purcell_cli.mechanics.base_velocity import kernel_numbers
from purcell_cli.mechanics.swimmer import Swimmer


@frozen_dataclass
class Accuracy:
    """How finely the lift is computed.

    Attributes:
        stages: Collocation nodes in a step; the order is twice that.
        step: Largest step, as a fraction of the distance from the collinear shape.
        settled: The iteration for the orientations ends with a change by less; what is left is far less.
    """

    stages: int = 8
    step: float = 0.4
    settled: float = 1e-14


@functools.cache
def _collocation(stages: int) -> tuple[Array, Array, Array]:
    """Return nodes on [0, 1], weights, and weights of the integral from 0 to each node."""
    x, w = gauss_legendre(stages)
    values = np.polynomial.legendre.legvander(x, stages - 1)
    integrals = np.stack(
        [np.polynomial.legendre.legval(x, np.polynomial.legendre.legint(row, lbnd=-1)) for row in np.eye(stages)],
        axis=-1,
    )
    to_node = 0.5 * np.asarray(solve(values.T, integrals.T).T, dtype=np.float64)
    return (x + 1) / 2, w / 2, to_node


@functools.lru_cache(maxsize=64)
def flow_of(swimmer: Swimmer, accuracy: Accuracy) -> Flow:
    """Return the flow of a swimmer, in units of L, at an accuracy."""
    return flow_with(kernel_numbers(swimmer), accuracy)


def flow_with(numbers: Array, accuracy: Accuracy) -> Flow:
    """Return the flow of a swimmer by its numbers, see `base_velocity.kernel_numbers`, shape (n,), at an accuracy."""
    return Flow(numbers, Rule(*_collocation(accuracy.stages), accuracy.step, accuracy.settled))
