"""Taylor polynomials of the resistance of links that feel each other's flow, and of a wall's, around a configuration.

There is no closed form to expand. The beads are solved at points on lines through the configuration; along each line
the resistance is interpolated at Chebyshev's nodes, and its parts of each degree are fitted to those of all lines. The
coordinates are those across the limbs' axes and, beside a wall, the normal's across itself and the height.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.taylor import Taylor, taylor
from purcell_cli.mechanics.beads import LOWER, entries_of_many, rooms
from purcell_cli.mechanics.swimmer import Swimmer

_LEFT, _LEFT_BESIDE = 1e-8, 1e-7
"""What the fit leaves of a twist that is zero, per largest one, at most: without a wall, and L away from one; measured,
by fits of other reach, some 1e-10 and 1e-8 to depth 4. Nearer to a wall it grows with the third power."""
_REACH_RAD = 0.4
"""How far the lines go [rad]: interpolation and the solver's rounding leave least to degree 3."""
_ROOM = 0.25
"""Which part of the room to a wall they take at most, counted in what a link's end moves by half of."""
_MORE_NODES = 14
"""Nodes on a line beyond the degree: the resistance's higher terms fall below rounding."""
_MORE_LINES = 1.6
"""Lines for each coefficient of the highest degree."""


def resistance_polynomial(swimmer: Swimmer, ring: Taylor, limbs: tuple[Array, Array], beside: Array | None) -> Array:
    """Return the resistance on (v, omega, u_1, u_2) of beads, the limbs' rates u in base coordinates.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        ring: The polynomials, the last three variables being the wall's where there is one (`wall_steps`).
        limbs: The limbs' orientations as polynomials. Shapes (monomials, 3, 3).
        beside: How the swimmer sees the wall at the configuration (`Wall.beside`); None without one. Shape (4,).

    Returns:
        Shape (monomials, 12, 12).

    Raises:
        ParameterError: A link that touches the wall.
    """
    across = [np.swapaxes(a[0], 0, 1) @ a[..., 0][..., None] for a in limbs]
    values = [part[:, k, 0] for part in across for k in (1, 2)]
    if beside is not None:
        values += [ring.variable(ring.variables - k) for k in (3, 2, 1)]
    own = taylor(len(values), ring.degree)
    axes = np.stack([a[0] for a in limbs])
    entries = _fitted(swimmer, own, axes, beside)
    row, column = LOWER
    out = np.zeros((len(ring), 12, 12))
    powers: dict[tuple[int, ...], Array] = {(0,) * len(values): ring.constant(np.ones(()))}
    for k, power in enumerate(map(tuple, own.powers.tolist())):
        if any(power):
            last = max(j for j, p in enumerate(power) if p)
            lower = tuple(p - (j == last) for j, p in enumerate(power))
            powers[power] = ring.product(powers[lower], values[last])
        out[:, row, column] += powers[power][:, None] * entries[k]
    out[:, column, row] = out[:, row, column]
    return out


def wall_steps(ring: Taylor, beside: Array) -> Array:
    """Return how a wall's coordinates change with the base's twist: of the normal across itself, and of the height.

    Args:
        ring: The polynomials, the last three variables being these.
        beside: How the swimmer sees the wall at the configuration. Shape (4,).

    Returns:
        Polynomials by (v, omega). Shape (monomials, 6, 3).
    """
    p, q = (ring.variable(ring.variables - k) for k in (3, 2))
    frame = _frame_of(beside[:3])
    square = ring.product(p, p) + ring.product(q, q)
    term, up = ring.constant(np.ones(())), ring.constant(np.ones(()))
    for k in range(1, ring.degree // 2 + 1):  # the series of sqrt(1 - p^2 - q^2)
        term = (k - 1.5) / k * ring.product(term, square)
        up = up + term
    out = np.zeros((len(ring), 6, 3))
    normal = np.stack([p, q, up], axis=-1)
    out[:, :3, 2] = normal @ frame.T
    out[:, 3:, 0] = q[:, None] * frame[:, 2] - up[:, None] * frame[:, 1]
    out[:, 3:, 1] = up[:, None] * frame[:, 0] - p[:, None] * frame[:, 2]
    return out


def _frame_of(normal: Array) -> Array:
    """Return a rotation whose last column is a normal. Shape (3, 3)."""
    aside = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = aside - normal * (normal @ aside)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal])


def _fitted(swimmer: Swimmer, own: Taylor, limbs: Array, beside: Array | None) -> Array:
    """Return the entries of the resistance as polynomials in the coordinates. Shape (monomials, 78)."""
    count, nodes = own.variables, own.degree + _MORE_NODES
    scale, reach = np.ones(count), _REACH_RAD
    if beside is not None:
        scale = np.array([0.5, 0.5, 0.5, 0.5, 1.0 / 3.0, 1.0 / 3.0, 1.0])  # no end then moves more than 2 L a unit
        room = _room(swimmer, limbs, beside)
        reach = min(reach, _ROOM * room)
    lines = _lines(count, own.degree)
    part = np.cos((np.arange(nodes) + 0.5) * (math.pi / nodes))
    points = (reach * scale * lines)[:, None] * part[:, None]
    entries = entries_of_many(swimmer, *_seen(limbs, beside, points.reshape(-1, count)))
    series = np.linalg.solve(
        np.polynomial.polynomial.polyvander(part, nodes - 1), entries.reshape(len(lines), nodes, -1)
    )
    out = np.empty((len(own), entries.shape[1]))
    for degree in range(own.degree + 1):
        mine = own.totals == degree
        powers = np.prod(lines[:, None] ** own.powers[mine], axis=-1)
        unit = reach**degree * np.prod(scale ** own.powers[mine], axis=-1)
        out[mine] = np.linalg.lstsq(powers, series[:, degree], rcond=None)[0] / unit[:, None]
    return out


def _room(swimmer: Swimmer, limbs: Array, beside: Array) -> float:
    """Return how far the links are from the wall.

    Raises:
        ParameterError: One touches it.
    """
    room = float(np.min(rooms(swimmer, limbs[:, :, 0], beside)))
    if not room > 0.0:
        raise ParameterError("wall: a configuration clear of it is wanted, found one that touches it")
    return room


def left_of_zero(swimmer: Swimmer, shape: Array, beside: Array | None) -> float:
    """Return what the fit leaves of a twist that is zero, per largest one.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shape: The shape. Shape (2, 3, 3).
        beside: How it sees its wall. Shape (4,).
    """
    if beside is None:
        return _LEFT
    return float(_LEFT_BESIDE / min(1.0, _room(swimmer, shape, beside)) ** 3)


@functools.lru_cache(maxsize=8)
def _lines(count: int, degree: int) -> Array:
    """Return the directions of the lines, evenly at random. Shape (n, count)."""
    n = max(round(_MORE_LINES * math.comb(count + degree - 1, degree)), count + 1)
    out = np.random.default_rng(0).normal(size=(n, count))
    out /= np.linalg.norm(out, axis=1)[:, None]
    out.setflags(write=False)
    return out


def _seen(limbs: Array, beside: Array | None, points: Array) -> tuple[Array, Array | None]:
    """Return the limbs' axes, and the wall as it is seen, at some coordinates. Shapes (n, 2, 3) and (n, 4)."""
    across = points[:, :4].reshape(-1, 2, 2)
    along = np.sqrt(1.0 - np.sum(across * across, axis=-1))
    axes = np.einsum("kij,nkj->nki", limbs, np.concatenate([along[..., None], across], axis=-1))
    if beside is None:
        return axes, None
    p, q, more = points[:, 4:].T
    normal = np.stack([p, q, np.sqrt(1.0 - p * p - q * q)], axis=-1) @ _frame_of(beside[:3]).T
    return axes, np.concatenate([normal, (beside[3] + more)[:, None]], axis=1)
