"""Needle steering by the kernel: three arcs and a last roll that make displacements."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def steered(
    straight: float, tight: float, bearing: ArrayLike, size: ArrayLike, inverse: ArrayLike, begun: ArrayLike
) -> tuple[Array, Array]:
    """Return arcs and a last roll, brought to displacements by least squares that are weighted anew in every round.

    Args:
        straight: The largest advance of the swimmer's loops per cost [L/rad].
        tight: The largest turn per cost.
        bearing: Bearings, ascending, of turn against advance in those units [rad]. Shape (k,).
        size: What a unit cost makes in those directions. Shape (k,).
        inverse: The inverses of the displacements. Shape (n, 4, 4).
        begun: Advance [L] and turns about y and z [rad] of three arcs, and a roll, to begin with. Shape (n, 10).

    Returns:
        Arcs and rolls, shape (n, 10), and what they miss by [L, rad], shape (n,).
    """
    x = np.array(doubles(begun, "begun", (-1, 10)))
    n, at = len(x), doubles(bearing, "bearing", (-1,))
    reach, wanted = doubles(size, "size", (len(at),)), doubles(inverse, "inverse", (n, 4, 4))
    if len(at) < 2 or not (straight > 0.0 and tight > 0.0):
        raise ValueError("bearing, straight and tight: two bearings at least and positive numbers are wanted")
    off = np.empty(n)
    places = (address(part) for part in (at, reach, wanted, x, off))
    KERNEL.purcell_steer(n, float(straight), float(tight), len(at), *places)
    return x, off
