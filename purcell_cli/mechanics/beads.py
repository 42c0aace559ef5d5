"""Links that feel each other's flow: lines of touching beads in the Rotne-Prager-Yamakawa approximation.

A link is a line of beads of its own radius, so many that neighbours touch, and moves as one rigid body. Beads feel
forces only. With M the mobility of all beads and K the map from the base's twist and the limbs' rates to the beads'
velocities, the resistance is K^T M^-1 K; its blocks are P and Q, and the base's twist is -P^-1 Q omega as without
interaction. Spin about a link's own axis keeps its local drag. Everything that rests on left invariance stays true.

The mobility of two beads, unequal or overlapping ones too, as beside a joint: Zuk, Wajnryb, Mizerski and Szymczak,
J. Fluid Mech. 741, R5 (2014). Conventions: `connection`.
"""

from __future__ import annotations

import functools
import os

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.arrays import Whole
from purcell_cli.kernel.beads import bead_resistance
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import refuse_wall

_P, _Q = np.tril_indices(6), np.indices((6, 6)).reshape(2, -1)
"""Rows and columns of the lower half of six by six, and of all of it."""
LOWER = (
    np.concatenate([_P[0], 6 + _Q[0], 6 + _P[0]]),
    np.concatenate([_P[1], _Q[1], 6 + _P[1]]),
)
"""Rows and columns of the entries of a resistance, in the kernel's order: P, Q^T, and what only the power needs."""


@frozen_dataclass(eq=False)
class Beads:
    """The beads of a swimmer.

    Attributes:
        link: Which link each is of: 0 the base, 1 or 2 a limb. Shape (n,).
        along: Where it is on the link's axis, from the base's middle or from the limb's joint outwards [m]. Shape (n,).
        radius: Its radius [m]. Shape (n,).
        spins: The links' drag of spinning about their own axes [N m s].
    """

    link: Whole
    along: Array
    radius: Array
    spins: tuple[float, ...]

    @classmethod
    def of(cls, swimmer: Swimmer) -> Beads:
        """Return the beads of a swimmer's links."""
        halves, radii = np.array(swimmer.halves_m), np.array(swimmer.radii_m)
        counts = np.round(halves / radii).astype(np.int64)
        along = [half * ((2.0 * np.arange(n) + 1.0) / n) for half, n in zip(halves, counts.tolist(), strict=True)]
        along[0] -= halves[0]
        link = np.repeat(np.arange(3, dtype=np.int64), counts)
        spins = tuple(swimmer.rod(k).spin for k in range(3))
        return cls(link, np.concatenate(along), np.repeat(radii, counts), spins)

    def places(self, swimmer: Swimmer, axes: Array) -> tuple[Array, Array]:
        """Return where the beads are in base coordinates, and from their limb's joint [m].

        Args:
            swimmer: The swimmer.
            axes: The limbs' axes in base coordinates. Shape (2, 3).

        Returns:
            Both of shape (n, 3).
        """
        outwards = np.stack([np.array([1.0, 0.0, 0.0]), axes[0], -axes[1]])
        arm = self.along[:, None] * outwards[self.link]
        place = arm.copy()
        place[:, 0] += np.array([0.0, swimmer.base_half_length_m, -swimmer.base_half_length_m])[self.link]
        return place, arm


@functools.lru_cache(maxsize=16)
def _beads(swimmer: Swimmer) -> Beads:
    return Beads.of(swimmer)


def resistance_entries(swimmer: Swimmer, axes: Array, beside: Array | None = None) -> Array:
    """Return the resistance of a shape on (v, omega, u_1, u_2), the limbs' rates u in base coordinates.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in base coordinates. Shape (2, 3).
        beside: How a swimmer beside a wall sees it (`Wall.beside`), clear of all beads. Shape (4,).

    Returns:
        Its lower half, in the order of `LOWER` [N s/m, N s, N s m]. Shape (78,).

    Raises:
        ParameterError: A swimmer beside a wall that is not said where.
    """
    if beside is None:
        refuse_wall(swimmer)
    beads = _beads(swimmer)
    out = swimmer.viscosity_pa_s * bead_resistance(*beads.places(swimmer, axes), beads.radius, beads.link, beside)
    row, column = LOWER
    for link in range(3):
        axis = np.zeros(12)
        axis[3:6] = axes[link - 1] if link else (1.0, 0.0, 0.0)
        if link:
            axis[3 + 3 * link : 6 + 3 * link] = axes[link - 1]
        out += beads.spins[link] * (axis[row] * axis[column])
    return np.asarray(out)


def rooms(swimmer: Swimmer, axes: Array, beside: Array) -> Array:
    """Return how far the base, limb 1 and limb 2 are from a wall, less than 0 where they reach into it [m]. Shape (3,).

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in base coordinates. Shape (2, 3).
        beside: How the swimmer sees the wall (`Wall.beside`). Shape (4,).
    """
    beads = _beads(swimmer)
    room = matmul(beads.places(swimmer, axes)[0], beside[:3]) + beside[3] - beads.radius
    return np.array([float(np.min(room[beads.link == link])) for link in range(3)])


def grand_resistance(swimmer: Swimmer, axes: Array) -> Array:
    """Return the resistance of a shape as a matrix; see `resistance_entries`. Shape (12, 12)."""
    row, column = LOWER
    out = np.empty((12, 12))
    out[row, column] = out[column, row] = resistance_entries(swimmer, axes)
    return out


def solved_anew(swimmer: Swimmer, axes: Array) -> Array:
    """Return the resistances of shapes; see `entries_of_many`. Shape (n, 78)."""
    return entries_of_many(swimmer, axes, None)


def entries_of_many(swimmer: Swimmer, axes: Array, beside: Array | None) -> Array:
    """Return the resistances of shapes, each from its beads, on all processors.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in base coordinates. Shape (n, 2, 3).
        beside: How the swimmer sees its wall each time; None without one. Shape (n, 4).

    Returns:
        See `resistance_entries`. Shape (n, 78).
    """
    from concurrent.futures import ThreadPoolExecutor  # only those who swim among beads wait for it

    seen = [None] * len(axes) if beside is None else beside
    out = np.empty((len(axes), len(LOWER[0])))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for k, found in enumerate(pool.map(functools.partial(resistance_entries, swimmer), axes, seen)):
            out[k] = found
    return out
