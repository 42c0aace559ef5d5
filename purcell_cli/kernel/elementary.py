"""Sines, cosines, arc tangents and the coefficients of rotations, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def sin_cos(angle: ArrayLike) -> tuple[Array, Array]:
    """Return sines and cosines [angles in rad]. Shape (...)."""
    x = doubles(angle, "angle")
    out = np.empty((2, *x.shape))
    if x.size:
        start = address(out)
        KERNEL.purcell_sin_cos(x.size, address(x), start, start + 8 * x.size)
    return out[0, ...], out[1, ...]


def arctan2(y: ArrayLike, x: ArrayLike) -> Array:
    """Return the angles of points (x, y), between -pi and pi [rad]. Shape (...)."""
    rise, run = doubles(y, "y"), doubles(x, "x")
    if rise.shape != run.shape:
        rise, run = (np.ascontiguousarray(part) for part in np.broadcast_arrays(rise, run))
    out = np.empty(rise.shape)
    if out.size:
        KERNEL.purcell_arctan2(out.size, address(rise), address(run), address(out))
    return out


def exp_coefficients(angle_squared: ArrayLike) -> Array:
    """Return sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 as functions of t^2. Shape (...) to (3, ...)."""
    x = doubles(angle_squared, "angle_squared")
    out = np.empty((3, *x.shape))
    if x.size:
        KERNEL.purcell_exp_coefficients(x.size, address(x), address(out))
    return out


def sin_cos_of(angle: float) -> tuple[float, float]:
    """Return the sine and cosine of one angle [rad], the same bits as `sin_cos`."""
    return KERNEL.purcell_sine(angle), KERNEL.purcell_cosine(angle)


def arctan2_of(y: float, x: float) -> float:
    """Return the angle of one point (x, y) [rad], the same bits as `arctan2`."""
    return float(KERNEL.purcell_angle(y, x))
