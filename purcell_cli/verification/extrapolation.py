"""The certificate's integrator: g' = g hat(xi(t)) by Gragg's and Bulirsch and Stoer's extrapolation.

The plain equation, by the modified midpoint rule with 2, 4, ..., 16 steps over a piece, extrapolated to no step
(Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.9). It shares nothing with the
planner's collocation, needs no table of coefficients, and so works in whatever precision its input has: with twice
the digits of doubles the motions of ten thousand cycles keep twelve digits.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import certificate
from purcell_cli.mechanics.bead_table import tabulated
from purcell_cli.mechanics.connection import base_twist_rows
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.verification.extended import Real, extended, products

Rows = np.ndarray[tuple[int, ...], np.dtype[np.int64]]
"""Numbers of rows."""

Resistances = Callable[[Swimmer, Array], Array]
"""Gives the resistances of shapes in which links feel each other."""

_STEPS = tuple(range(2, 17, 2))
"""Midpoint steps over a piece. The order is twice as many as there are, 16."""

_PIECE_RAD, _PIECE = 0.25, 0.4
"""Longest pieces: an angle, and a part of the least distance from the straight line, where A(r) is sharp.

Extrapolation of order 16 errs by less than rounding on such a piece."""
_ROUNDING, _EVERYWHERE = 16.0, 4.0
"""What rounding turns a piece by, in units of its angle, of the precision's last bit, and of one over the squared
distance from the straight line, which counts as no less than the second where extrapolation has but the digits of
doubles, of which it loses some. The sum over many pieces counts, not the one that is rounded most: of swimmers from
stout to thin it is half of this and less, of single segments up to eight times this."""
_LAST_BIT = 2.0**-63
"""The last bit of the most precise numbers of which that was found."""
_SURE, _LEAST = 8.0, 1.0 / 16.0
"""What rounding turns a segment by where that was measured, by two integrations with other pieces: so many times their
difference, and this part of the rest at the least."""
_MOST_RAD = 1e4
"""What no segment of one control turns the limbs by [rad]: a damaged time or rate would take memory without bound."""
_BATCH = 1024
"""Pieces solved as one system: bounds the memory of a long path."""


@functools.cache
def _times() -> tuple[tuple[int, int], ...]:
    """Return the parts of a piece, as fractions, at which the twist is wanted: where a midpoint step begins."""
    return tuple(sorted({(k // math.gcd(k, n), n // math.gcd(k, n)) for n in _STEPS for k in range(n)}))


class Turning:
    """Limbs that turn at constant rates, each about an axis that is fixed in the base.

    Attributes:
        begun: Their axes at time 0. Shape (2, 3, m).
        rate: Their rates in base coordinates. Shape (2, 3, m).

    Args:
        begun: As said; all is computed in their precision.
        rate: As said.
    """

    def __init__(self, begun: Real, rate: Real) -> None:
        self.begun, self.rate = begun, rate

    @classmethod
    def of(cls, shapes: Real, rates: Real) -> Turning:
        """Return the turning from shapes, shape (m, 2, 3, 3), at limb rates [rad/s], shape (m, 6)."""
        rate = np.einsum("mlij,mlj->lim", shapes, rates.reshape(-1, 2, 3).astype(shapes.dtype))
        return cls(np.ascontiguousarray(shapes[..., 0].transpose(1, 2, 0)), rate)

    def from_time(self, which: Rows, time: Real) -> Turning:
        """Return the turning of some of them from times on [s]. Shapes (n,), (n,)."""
        part = Turning(self.begun[..., which], self.rate[..., which])
        return Turning(part.axes(time[None])[:, :, 0], part.rate)

    def axes(self, time: Real) -> Real:
        """Return the limbs' axes at times [s]. Shapes (k, m) to (2, 3, k, m)."""
        speed = np.sqrt(np.sum(self.rate * self.rate, axis=1, keepdims=True))
        about = self.rate / np.where(speed > 0.0, speed, 1.0)
        across = _crossed(about, self.begun)
        angle, back = speed[:, :, None] * time, _crossed(about, across)[:, :, None]
        return np.asarray(self.begun[:, :, None] + np.sin(angle) * across[:, :, None] + (1.0 - np.cos(angle)) * back)


def _crossed(a: Real, b: Real) -> Real:
    """Return cross products. Shapes (2, 3, m), (2, 3, m)."""
    out = np.empty_like(b)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[:, i] = a[:, j] * b[:, k] - a[:, k] * b[:, j]
    return out


def _places() -> tuple[int, ...]:
    """Return at which of the times each step of each number of steps begins."""
    place = {time: k for k, time in enumerate(_times())}
    return tuple(place[m // math.gcd(m, n), n // math.gcd(m, n)] for n in _STEPS for m in range(n))


@functools.lru_cache(maxsize=64)
def _links(unit: Swimmer) -> Array:
    """Return of the base and the limbs half the length and the drag on (v, omega). Shape (3, 7)."""
    return np.array([[unit.halves_m[link], *np.diag(unit.drag_matrix(link))] for link in (0, 1, 2)])


def _extrapolated(unit: Swimmer, turning: Turning, length: Real, resistances: Resistances) -> tuple[Real, Real]:
    """Return by how much the base's displacements on pieces differ from none.

    They are so small that they lose nothing, and are put together by the caller.

    Args:
        unit: The swimmer, scaled to L = 1.
        turning: The limbs' turning on each piece.
        length: How long each piece lasts [s]. Shape (n,).
        resistances: See `base_twist_rows`.

    Returns:
        The columns of the rotation less 1, and the position: extrapolated from all steps, and from all without the
        last extrapolation, which is some hundred times less exact. Both of shape (n, 3, 4).
    """
    if unit.fluid == "beads":
        return _in_numpy(unit, turning, length, resistances)
    given = turning.begun, turning.rate, length, _parts(length.dtype), _STEPS, _places()
    return certificate.extrapolated(_links(unit), *given)


def _parts(dtype: np.dtype[np.floating[Any]]) -> Real:
    """Return the times at which midpoint steps begin, as parts of a piece."""
    return np.array([np.asarray(a, dtype) / np.asarray(b, dtype) for a, b in _times()])


def _in_numpy(unit: Swimmer, turning: Turning, length: Real, resistances: Resistances) -> tuple[Real, Real]:
    """Return the same without the kernel; arguments as of `_extrapolated`."""
    found = []
    for low in range(0, len(length), _BATCH):
        some = slice(low, low + _BATCH)
        part = Turning(turning.begun[..., some], turning.rate[..., some])
        found.append(_batch_in_numpy(unit, part, length[some], resistances))
    fine, rough = zip(*found, strict=True) if found else ([np.empty((0, 3, 4), dtype=length.dtype)],) * 2
    return np.concatenate(fine), np.concatenate(rough)


def _batch_in_numpy(unit: Swimmer, turning: Turning, length: Real, resistances: Resistances) -> tuple[Real, Real]:
    dtype, parts = length.dtype, _parts(length.dtype)
    place = {time: k for k, time in enumerate(_times())}
    n, k = len(length), len(parts)
    axes = turning.axes(parts[:, None] * length).reshape(2, 3, -1)
    rate = np.broadcast_to(turning.rate[:, :, None], (2, 3, k, n)).reshape(2, 3, -1)
    xi = (base_twist_rows(unit, axes, rate, resistances).reshape(6, k, n) * length).swapaxes(0, 1)
    columns: list[Real] = []
    last = before = np.zeros((4, 3, n), dtype=dtype)
    for row, steps in enumerate(_STEPS):
        step = np.asarray(1, dtype) / np.asarray(steps, dtype)
        earlier = np.zeros((4, 3, n), dtype=dtype)
        state = step * _slope(xi[0], earlier)
        for m in range(1, steps):
            divisor = math.gcd(m, steps)
            slope = _slope(xi[place[m // divisor, steps // divisor]], state)
            earlier, state = state, earlier + 2.0 * step * slope
        # Aitken and Neville: T_j = T_(j-1) + (T_(j-1) - T of the row before) / ((n_i / n_(i-j))^2 - 1).
        here = [state]
        for j in range(1, row + 1):
            ratio = np.asarray(steps, dtype) / np.asarray(_STEPS[row - j], dtype)
            here.append(here[-1] + (here[-1] - columns[j - 1]) / (ratio * ratio - 1.0))
        columns, last, before = here, here[-1], here[-2] if row else here[-1]
    return last.transpose(2, 1, 0), before.transpose(2, 1, 0)


def _slope(xi: Real, state: Real) -> Real:
    """Return the derivative of the rotation's columns and the position. Shapes (6, n) and (4, 3, n) to (4, 3, n)."""
    out = np.empty_like(state)
    rotation = state[:3].copy()
    for i in range(3):
        rotation[i, i] += 1.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = xi[3 + k] * rotation[j] - xi[3 + j] * rotation[k]
    out[3] = xi[0] * rotation[0] + xi[1] * rotation[1] + xi[2] * rotation[2]
    return out


@frozen_dataclass(eq=False)
class _Mesh:
    """Segments cut into pieces.

    Attributes:
        owner: Which segment each piece is of, ascending. Shape (n,).
        start: Where it begins, as a part of the segment. Shape (n,).
        length: How long it is, as a part of the segment. Shape (n,).
        near: How far the shape in its middle is from where A(r) is sharp [rad]. Shape (n,).
    """

    owner: Rows
    start: Array
    length: Array
    near: Array


def _mesh(unit: Swimmer, turning: Turning, swept: Array, durations: Array, finer: float) -> _Mesh:
    """Cut segments into pieces that are short against the distance from where A(r) is sharp, all along them.

    That distance is the root of the links' second moment about a line, so it changes no faster than the root of
    what a limb's turning moves, the integral of r^2 along it, (8/3) l^3.
    """
    half, weight = max(unit.halves_m[1:]), unit.weights()[1]
    steepness = math.sqrt(weight * 8.0 / 3.0 * half * half * half / unit.bend_spread())
    if np.max(swept, initial=0.0) > _MOST_RAD:
        raise ParameterError(
            f"rows that turn limbs by {_MOST_RAD:g} rad at the most are wanted, found one of {np.max(swept):.3g} rad"
        )
    # It is sharp where the links are straight, in any fluid.
    links = _links(unit if unit.fluid == "local" else dataclasses.replace(unit, fluid="local")).copy()
    links[:, 1:] /= unit.lateral_drag()
    bounds = unit.bend_spread(), steepness, unit.roll_sharpness(), finer * _PIECE, finer * _PIECE_RAD
    axes, rate = (rows.astype(np.float64).transpose(2, 0, 1) for rows in (turning.begun, turning.rate))
    owner, pieces = certificate.pieces_of(links, bounds, axes, rate, swept, durations)
    return _Mesh(owner, *pieces.T)


@frozen_dataclass(eq=False)
class Displacements:
    """The base's displacements on segments of constant control, put together in extended precision.

    Attributes:
        fine: The displacements [m]. Shape (m, 4, 4).
        rough: The same before the last extrapolation [m]. Shape (m, 4, 4).
        rounding: What rounding may turn them by, at the most [rad]. Shape (m,).
    """

    fine: Real
    rough: Real
    rounding: Array

    def put(self, some: Rows, others: Displacements) -> Displacements:
        """Return the displacements with some of them replaced by as many others."""
        fine, rough, rounding = self.fine.copy(), self.rough.copy(), self.rounding.copy()
        fine[some], rough[some], rounding[some] = others.fine, others.rough, others.rounding
        return Displacements(fine, rough, rounding)

    def measured(self, other: Displacements) -> Displacements:
        """Return the same, with rounding as another integration, in as many digits and with other pieces, shows it."""
        rotation = np.swapaxes(other.fine[:, :3, :3], 1, 2) @ self.fine[:, :3, :3] - np.eye(3)
        off = np.sqrt(0.5 * np.sum(rotation * rotation, axis=(1, 2))).astype(np.float64)
        rounding = np.minimum(_SURE * off + _LEAST * self.rounding, self.rounding)
        return dataclasses.replace(self, rounding=rounding)


def segment_displacements(
    swimmer: Swimmer,
    shapes: Real,
    rates: Array,
    durations: Array,
    finer: float = 1.0,
    resistances: Resistances = tabulated,
) -> Displacements:
    """Return the displacements of segments of constant control, computed in the shapes' precision.

    Long segments are cut into pieces so short that extrapolation takes them in one.

    Args:
        swimmer: The swimmer.
        shapes: Shapes where the segments begin. Shape (m, 2, 3, 3).
        rates: Limb rates [rad/s]. Shape (m, 6).
        durations: How long the segments last [s]. Shape (m,).
        finer: How long pieces are, in units of the usual length.
        resistances: See `base_twist_rows`.

    Raises:
        ParameterError: A segment that turns the limbs further than any does.
    """
    unit, turning = swimmer.scaled(), Turning.of(shapes, rates)
    swept = np.linalg.norm(rates, axis=1) * durations
    mesh = _mesh(unit, turning, swept, durations, finer)
    last_bit = max(float(np.finfo(shapes.dtype).eps), _LAST_BIT)
    sharper = np.maximum(1.0 / (mesh.near * mesh.near), _EVERYWHERE if shapes.dtype == np.float64 else 0.0)
    noise = _ROUNDING * last_bit * swept[mesh.owner] * mesh.length * sharper
    rounding = np.bincount(mesh.owner, noise, len(durations))
    seconds = durations.astype(shapes.dtype)[mesh.owner]
    begun, length = turning.from_time(mesh.owner, mesh.start * seconds), mesh.length * seconds
    counts = np.bincount(mesh.owner, minlength=len(durations))
    fine, rough = (_strung(pieces, counts) for pieces in _extrapolated(unit, begun, length, resistances))
    for out in (fine, rough):
        out[:, :3, 3] *= swimmer.length_m
    return Displacements(fine, rough, np.asarray(rounding, dtype=np.float64))


def _strung(pieces: Real, counts: Rows) -> Real:
    """Return the products of pieces' displacements, given as what they differ from none. Shapes (n, 3, 4), (m,)."""
    if certificate.has_extended():
        return certificate.strung(pieces, counts)
    out = extended(np.tile(np.eye(4), (len(pieces), 1, 1)))
    out[:, :3] += pieces
    return products(out, counts)
