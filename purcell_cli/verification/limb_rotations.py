"""How limbs are turned by controls, as quaternions in extended precision, and which segments of control come again."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.rotations import Array, hat, running
from purcell_cli.kernel import certificate
from purcell_cli.verification.extended import Real, extended, products
from purcell_cli.verification.extrapolation import Rows

_BATCH = 1 << 14
"""Segments that are put together at once: bounds the memory of a long motion."""
_LONGEST = 64
"""The most segments of a cycle."""


def quaternions(rates: Array, durations: Array) -> Real:
    """Return by how much segments of constant rates turn limbs, as quaternions (w, x, y, z).

    Args:
        rates: Limb rates [rad/s]. Shape (m, 6).
        durations: How long the segments last [s]. Shape (m,).

    Returns:
        Quaternions. Shape (m, 2, 4).
    """
    half = 0.5 * extended(rates).reshape(-1, 2, 3) * durations[:, None, None]
    size = np.sqrt(np.sum(half * half, axis=-1, keepdims=True))
    sine = np.where(size > 0.0, np.sin(size) / np.where(size > 0.0, size, 1.0), 1.0)
    return np.concatenate([np.cos(size), half * sine], axis=-1)


def turned_along(rates: Array, durations: Array) -> Real:
    """Return how limbs are turned before, between and after segments; see `quaternions`. Shape (m + 1, 2, 4)."""
    each = np.zeros((len(rates) + 1, 2, 4), dtype=np.longdouble)
    each[0, :, 0] = 1.0
    each[1:] = quaternions(rates, durations)
    pairs = _pairs(each)
    for low in range(0, len(pairs) - 1, _BATCH):
        some = slice(low, low + _BATCH + 1)  # the last of one batch begins the next
        pairs[some] = running(pairs[some], _hamilton)
        each[some] /= np.sqrt(np.sum(each[some] * each[some], axis=-1, keepdims=True))
    return each


def shapes_of(start: Real, turned: Real) -> Real:
    """Return shapes that are turned since a first one, by quaternions (w, x, y, z). Shape (..., 2, 3, 3)."""
    k = hat(turned[..., 1:])
    return np.asarray(start @ (np.eye(3) + 2.0 * (turned[..., :1, None] * k + k @ k)))


def rotation_between(first: Real, second: Real) -> Array:
    """Return the small rotation vectors, in the limbs' frames, from quaternions to others. Shape (..., 2, 3)."""
    (w, v), (s, u) = ((q[..., :1], q[..., 1:]) for q in (first, second))
    return np.asarray(2.0 * (w * u - s * v - (hat(v) @ u[..., None])[..., 0]), dtype=np.float64)


def once(rates: Array, durations: Array) -> tuple[Rows, Rows]:
    """Return which segments are left when those that come again are left out, and which of them each segment is.

    Cycles come again where their rates and durations do to the bit and where, in extended precision, limbs return to
    the bit: then every cycle begins at the shape of the first. All this is told from the numbers themselves.

    Args:
        rates: Limb rates [rad/s]. Shape (m, 6).
        durations: How long the segments last [s]. Shape (m,).

    Returns:
        Indices of segments, ascending, shape (k,), and indices into those, shape (m,).
    """
    first, period, count = certificate.repeats(np.column_stack([durations, rates]), _LONGEST)
    again = np.flatnonzero(count > 1)
    cycle = np.repeat(first[again], period[again]) + _from_zero(period[again])
    made = products(_pairs(quaternions(rates[cycle], durations[cycle])), period[again], _hamilton)
    back = np.all((made[..., 0].imag == 0.0) & (made[..., 1] == 0.0), axis=-1)
    every = count * period
    period[again] = np.where(back, period[again], every[again])
    kept = np.repeat(first, period) + _from_zero(period)
    place = np.repeat(np.cumsum(period) - period, every) + _from_zero(every) % np.repeat(period, every)
    return kept, place


def _from_zero(counts: Rows) -> Rows:
    """Return 0, 1, 2, ... for each of some runs, one after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _pairs(quaternion: Real) -> Real:
    """Return w + x i + y j + z k as the complex numbers (w + x i, y + z i), in the same memory. Shape (..., 2)."""
    return np.asarray(quaternion.view(np.result_type(quaternion.dtype, np.complex128)))


def _hamilton(p: Real, q: Real) -> Real:
    """Return the products of quaternions a + b j, as pairs of complex numbers a, b. Shape (..., 2)."""
    a, b, c, d = p[..., 0], p[..., 1], q[..., 0], q[..., 1]
    out = np.empty(np.broadcast_shapes(p.shape, q.shape), dtype=p.dtype)
    out[..., 0], out[..., 1] = a * c - b * d.conj(), a * d + b * c.conj()
    return out
