"""The table of the resistance of links that feel each other, over the three numbers that it depends on.

A resistance depends on the limbs' axes only: on the bend of each, and on the angle between the planes that they are
bent in. Seen from the frame in which limb 1 is bent along y it is a smooth function of these three, mirror symmetric
in the last, and each bend goes on through straight to the other side: even or odd Chebyshev polynomials in the bends
and a Fourier series in the angle come near it to many digits. For limbs alike an end-for-end turn of the swimmer gives
half of the samples. What the coefficients are of stands in `bead_table.c`. A second table, of the bends that motions
mostly stay within, needs a third as many coefficients to be as near; it is sampled from the first.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import arccos, cos, matmul, sin, sin_cos_of
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.kernel.beads import NUMBERS, looked_up
from purcell_cli.kernel.library import DIGEST
from purcell_cli.mechanics.beads import LOWER, grand_resistance, solved_anew
from purcell_cli.mechanics.drag import LinkSize, LinkSizes
from purcell_cli.mechanics.fluid import BEADS, refuse_far_bends
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import refuse_wall
from purcell_cli.user_cache import kept

REACH_RAD = BEADS["max_bend_rad"][1]
"""Up to which bend the table reaches [rad]: beyond, beads of different links come near each other."""
_BENDS, _ANGLES = 10, 13
"""Polynomials of each limb's bend, and multiples of the angle: the error is some 1e-12 up to bends of 1 rad."""
_NEAR_RAD = 1.0 + 1e-6
"""Up to which bend the nearer table reaches [rad]: that of `max_bend_rad`, where nothing else is said."""
_NEAR_BENDS = 9
"""Polynomials of each limb's bend in it: the error is no larger."""

_MIRRORED = np.array([0, 0, 1, 1, 1, 0, 1, 1, 0, 1, 1, 0])
"""Which components of (v, omega, u_1, u_2) change their sign in the mirror of the x-y plane."""

_FLIPPED = np.array([0, 1, 1] * 4)
"""Which of them half a turn about x changes."""


def _order(fixed: int) -> NDArray[np.int64]:
    """Return which entries a row has of the sums over a limb's bend: `ENTRIES` of `bead_table.c`. Shape (80,).

    P and the other limb's couplings with the base, this limb's, and what only the power needs; 78 is no entry.
    """
    row, column = LOWER
    own = (row < 9) == (fixed == 0)
    part = np.where(row < 6, 0, np.where(column >= 6, 2, np.where(own, 1, 0)))
    order = np.lexsort((row >= 6, _MIRRORED[row] != _MIRRORED[column], part))
    return np.append(np.insert(order, np.count_nonzero(part == 0), len(order)), len(order))


_ROUGH, _EXACT = 1e-9, 1e-14
"""Coefficients below these parts of the largest are left out in a search, whose flows err by 1e-7, and else."""

Progress = Callable[[int, int], None]
"""Is told how many of how many samples are made."""


def _axes(first: float, second: float, angle: float) -> Array:
    """Return limb axes of two bends [rad], limb 1 bent along y and limb 2 at an angle to it. Shape (2, 3)."""
    (s1, c1), (s2, c2), (s, c) = (sin_cos_of(x) for x in (first, second, angle))
    return np.array([[c1, s1, 0.0], [c2, s2 * c, s2 * s]])


def _end_for_end(angle: float) -> Array:
    """Return what turns a resistance into that of the limbs' bends exchanged, seen from limb 1's frame. Shape (12, 12).

    The swimmer is turned by half a turn about z, so that limb 2 takes limb 1's place, and then about x.
    """
    turn = matmul(about_axis(0, angle), np.diag([-1.0, -1.0, 1.0]))
    out: Array = np.zeros((12, 12))
    for k, other in enumerate((0, 1, 3, 2)):
        out[3 * k : 3 * k + 3, 3 * other : 3 * other + 3] = turn
    return out


@frozen_dataclass
class Grid:
    """Where a table is sampled, and how far it reaches.

    Attributes:
        reach_rad: The largest bend [rad].
        many_bends: How many bends of each limb are sampled.
        many_angles: How many angles between the planes that the limbs are bent in.
    """

    reach_rad: float = REACH_RAD
    many_bends: int = _BENDS
    many_angles: int = _ANGLES

    @property
    def parts(self) -> Array:
        """The bends that are sampled, as parts of the reach: the positive ones of twice as many nodes. Shape (n,)."""
        n = self.many_bends
        return np.asarray(cos((np.arange(n) + 0.5) * (0.5 * np.pi / n)))

    @property
    def bends(self) -> Array:
        """The bends that are sampled [rad]. Shape (n,)."""
        return self.reach_rad * self.parts

    @property
    def shape(self) -> tuple[int, int, int]:
        """How many nodes there are: bends of limb 1, of limb 2, angles."""
        return self.many_bends, self.many_bends, self.many_angles

    @property
    def angles(self) -> Array:
        """The angles that are sampled [rad]. Shape (m,)."""
        m = self.many_angles
        return np.asarray(np.linspace(0.5, m - 0.5, m) * (np.pi / m), dtype=np.float64)


FINE = Grid(_NEAR_RAD, _NEAR_BENDS), Grid()
"""The grids of the tables that plans are made with."""


def _samples(unit: Swimmer, grid: Grid, progress: Progress) -> Array:
    """Return the resistances of the beads at all nodes. Shape (n, n, m, 78)."""
    bends, angles, n = grid.bends, grid.angles, grid.many_bends
    out = np.empty((n, n, grid.many_angles, 12, 12))
    alike = unit.equal_limbs

    def last(a: int) -> int:
        return a + 1 if alike else n

    wanted = [(a, b, c) for a in range(n) for b in range(last(a)) for c in range(grid.many_angles)]

    def sampled(place: tuple[int, int, int]) -> Array:
        a, b, c = place
        return grand_resistance(unit, _axes(float(bends[a]), float(bends[b]), float(angles[c])))

    def made() -> Iterator[Array]:
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            yield from pool.map(sampled, wanted)

    for k, ((a, b, c), found) in enumerate(zip(wanted, made(), strict=True), 1):
        out[a, b, c] = found
        if alike:
            turn = _end_for_end(float(angles[c]))
            out[b, a, c] = matmul(matmul(turn, found), turn.T)
        progress(k, len(wanted))
    return out[..., LOWER[0], LOWER[1]]


def made_tables(swimmer: Swimmer, progress: Progress = lambda _done, _of: None, grids: Sequence[Grid] = FINE) -> Array:
    """Return the kernel's tables of a swimmer: how many there are, then these, see `struct bead_table` of `kernel.h`.

    Args:
        swimmer: The swimmer.
        progress: Is told how far it is.
        grids: Where they are sampled, the one of the largest reach last: from the beads, the others from its table.

    Returns:
        Numbers one after the other. Shape (m,).
    """
    *near, far = grids
    widest = _table(_samples(swimmer.scaled(), far, progress), far)
    numbers = np.concatenate([np.zeros(NUMBERS - 1), [1.0], widest])
    tables = [_table(looked_up(numbers, _nodes(grid)).reshape(*grid.shape, -1), grid) for grid in near]
    return np.concatenate([[len(grids)], *tables, widest])


def _nodes(grid: Grid) -> Array:
    """Return the limb axes at a grid's nodes. Shape (n n m, 2, 3)."""
    bends, angles = grid.bends.tolist(), grid.angles.tolist()
    return np.array([_axes(a, b, angle) for a in bends for b in bends for angle in angles])


def _table(samples: Array, grid: Grid) -> Array:
    """Return the table of resistances at a grid's nodes. Shape (4 + n m (4 + 160 n),)."""
    n, m, angles = grid.many_bends, grid.many_angles, grid.angles
    places, steps = np.arange(n), np.arange(m)
    polynomials = cos(places[:, None] * ((places + 0.5) * (np.pi / n))) * (2.0 / n)
    polynomials[0] *= 0.5
    even, odd = (f(steps[:, None] * angles) * (2.0 / m) for f in (cos, sin))
    even[0] *= 0.5
    mixed = _MIRRORED[LOWER[0]] != _MIRRORED[LOWER[1]]
    turned = samples.transpose(2, 0, 1, 3).reshape(m, -1)
    sums = [matmul(series, turned).reshape(m, n, n, -1) for series in (even, odd)]
    table: Array = np.where(mixed, sums[1], sums[0]).transpose(1, 2, 0, 3)
    flips = _FLIPPED[LOWER[0]] != _FLIPPED[LOWER[1]]
    parts, is_odd = grid.parts, steps % 2 == 1
    table = table / np.where(is_odd[:, None] != flips, parts[:, None, None, None], 1.0)
    table = table / np.where(is_odd[:, None], parts[:, None, None], 1.0)
    for _ in range(2):
        table = matmul(polynomials, table.reshape(n, -1)).reshape(table.shape).swapaxes(0, 1)
    padded = np.concatenate([table, np.zeros((n, n, m, 1))], axis=-1)
    rows = [padded.transpose(2, *axes, 3)[..., _order(limb)].ravel() for limb, axes in enumerate(((1, 0), (0, 1)))]
    sizes = grid.reach_rad, float(cos(grid.reach_rad)), n, m
    return np.concatenate([sizes, _counts(table).ravel(), *rows])


def _counts(table: Array) -> Array:
    """Return how many coefficients count in the sums over each limb's bend: roughly, exactly. Shape (2, 2, m, n)."""
    size = np.max(np.abs(table), axis=-1)
    out = []
    for part in (_ROUGH, _EXACT):
        for axis in (0, 1):
            big = np.moveaxis(size > part * np.max(size), axis, -1)
            out.append(np.max(big * (1 + np.arange(len(size))), axis=-1).T)
    return np.array(out, dtype=np.float64)


_DIGITS = 13
"""Decimals of lengths at L = 1: what the rest makes of a resistance is far below a table's error."""

_known: dict[str, Array] = {}
"""The tables of this process, by what they depend on."""


def _unit(swimmer: Swimmer) -> Swimmer:
    """Return a swimmer with L = 1, its lengths to so many digits that the same swimmer scaled already is no other."""
    unit = swimmer.scaled()
    halves = [round(half, _DIGITS) for half in unit.halves_m]
    links = LinkSizes(*(LinkSize(half, unit.slenderness_of(k)) for k, half in enumerate(halves)))
    return dataclasses.replace(unit, limb_half_length_m=halves[1], links=links)


def bead_tables(swimmer: Swimmer, progress: Progress = lambda _done, _of: None) -> Array:
    """Return the kernel's tables of a swimmer: made once, then kept in the user's cache folder; see `made_tables`.

    Args:
        swimmer: The swimmer.
        progress: Is told how far it is, where it must be made.

    Raises:
        ParameterError: A swimmer beside a wall.
    """
    refuse_wall(swimmer)
    unit = _unit(swimmer)
    sizes = *unit.halves_m, *unit.radii_m
    key = f"{DIGEST} {[(g.reach_rad, g.many_bends, g.many_angles) for g in FINE]} {_ROUGH!r} {_EXACT!r} {sizes!r}"
    if key not in _known:
        tables = kept("beads", key, lambda: made_tables(unit, progress, FINE))
        tables.setflags(write=False)
        _known[key] = tables
    return _known[key]


def tabulated(swimmer: Swimmer, axes: Array) -> Array:
    """Return the resistances of shapes by the table, at L = 1 and a lateral drag per length of 1.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in base coordinates. Shape (n, 2, 3).

    Returns:
        See `beads.resistance_entries`. Shape (n, 78).

    Raises:
        ParameterError: A limb is bent further than the table reaches.
    """
    refuse_far_bends(float(np.max(arccos(np.clip(axes[..., 0], -1.0, 1.0)), initial=0.0)))
    return looked_up(np.concatenate([np.zeros(NUMBERS - 1), bead_tables(swimmer)]), axes)


def table_error(swimmer: Swimmer, axes: Array) -> float:
    """Return the largest error of the table's twists for unit joint rates, of those of the beads at some shapes.

    Args:
        swimmer: The swimmer.
        axes: The limbs' axes in base coordinates. Shape (n, 2, 3).

    Returns:
        In units of L, and rad, per rad of joint travel.

    Raises:
        ParameterError: See `tabulated`.
    """
    unit = swimmer.scaled()
    twists = []
    for entries in (tabulated(unit, axes), solved_anew(unit, axes)):
        full = np.empty((len(axes), 12, 12))
        full[:, LOWER[0], LOWER[1]] = full[:, LOWER[1], LOWER[0]] = entries
        twists.append(solve(full[:, :6, :6], full[:, :6, 6:]))
    return float(np.max(np.abs(twists[0] - twists[1]), initial=0.0))
