"""The base's twist in closed form, and its derivative by the limbs' orientations and rates (section III-C).

Drag depends on a limb only through its axis a_i = A_i e_x. Rates are therefore kept in base
coordinates here, u_i = A_i omega_i, and the twist is a function of (a_1, a_2, u_1, u_2) alone,
linear in the rates. The formula is in the kernel (`connection.c`); here are the numbers that it needs. Conventions:
`rotations`.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.flow import Connection, connection
from purcell_cli.mechanics.swimmer import Swimmer


@functools.lru_cache(maxsize=64)
def kernel_numbers(swimmer: Swimmer) -> Array:
    """Return what the kernel needs of a swimmer, scaled to L = 1 and a lateral drag per length of 1.

    Returns:
        Half the base's length, its diagonal drag, the distance from the collinear shape at which A(r) is sharp [rad],
        the spread of the links per squared bend, how fast the distance can change; and of each limb its side, half
        its length, its drag across, the part by which that along is less, its drags of turning and of spinning.
        Shape (22,), then how many tables of links that feel each other follow, and these.

    Raises:
        ParameterError: A swimmer beside a wall.
    """
    if swimmer.fluid != "beads":
        return with_tables(swimmer, np.zeros(1))
    from purcell_cli.mechanics.bead_table import bead_tables

    return with_tables(swimmer, bead_tables(swimmer))


def with_tables(swimmer: Swimmer, tables: Array) -> Array:
    """Return what the kernel needs of a swimmer; see `kernel_numbers`. Shape (n,).

    Args:
        swimmer: The swimmer.
        tables: How many tables of links that feel each other there are, and these; see `bead_table.made_tables`.
            Shape (m,).
    """
    unit = swimmer.scaled()
    # The kernel's distance counts all lengths alike, so that it is at most what it is by their drags.
    half, spread = max(unit.halves_m[1:]), unit.bend_spread() / unit.weights()[0]
    steepness = math.sqrt(4.0 * (2.0 / 3.0 * half * half * half) / spread)
    base = (unit.base_half_length_m, *np.diagonal(unit.drag_matrix(0)), unit.roll_sharpness(), spread, steepness)
    out = np.concatenate([[*base, 1.0, *_limb(unit, 1), -1.0, *_limb(unit, 2)], tables])
    out.setflags(write=False)
    return out


def _limb(unit: Swimmer, limb: int) -> tuple[float, ...]:
    """Return half a limb's length, its drag across, by what part that along is less, and of turning and spinning."""
    rod = unit.rod(limb, 1.0)
    return unit.halves_m[limb], rod.across, 1.0 - 1.0 / rod.ratio, rod.turn, rod.spin


def base_motion(swimmer: Swimmer, axes: Array, rates: Array) -> Connection:
    """Return the base's twists xi = -P^-1 q, and what goes with them, for limb rates in base coordinates.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes. Shape (n, 2, 3).
        rates: Rates of the limbs in base coordinates [rad/s]. Shape (n, 2, 3).
    """
    return connection(kernel_numbers(swimmer), axes, rates)
