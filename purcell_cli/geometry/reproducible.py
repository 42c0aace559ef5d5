"""Arithmetic that gives the same bits on every processor.

A plan is a long chain of decisions, and some hang on the last bit. Matrix products and solutions by
BLAS and LAPACK, and sines by vector units, end with other bits on other processors. What stands here
uses only sums, products, quotients and square roots of IEEE doubles, in an order that depends on
nothing but the shapes of the arrays. Errors are a few units in the last place, as elsewhere.
The kernel does most of it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array
from purcell_cli.kernel.elementary import arctan2, arctan2_of, exp_coefficients, sin_cos, sin_cos_of
from purcell_cli.kernel.linear import inner, products

__all__ = ["Array", "arctan2", "arctan2_of", "exp_coefficients", "inner", "sin_cos", "sin_cos_of"]

_LN2 = 0.69314718055994530942
"""The natural logarithm of 2, to all digits of a double."""


def matmul(first: ArrayLike, second: ArrayLike) -> Array:
    """Return products of matrices and vectors as `numpy.matmul` does, every sum from the first term on.

    Args:
        first: Matrices, or one vector. Shape (..., n, k).
        second: Matrices, or one vector. Shape (..., k, m), broadcast against the first.

    Returns:
        Products. Shape (..., n, m).
    """
    a, b = np.asarray(first), np.asarray(second)
    if b.ndim == 1:
        return inner(a, b)
    return products(a[None], b)[..., 0, :] if a.ndim == 1 else products(a, b)


def apply(matrix: ArrayLike, vector: ArrayLike) -> Array:
    """Return matrices times vectors. Shapes (..., n, k) and (..., k) to (..., n)."""
    return matmul(matrix, np.asarray(vector)[..., None])[..., 0]


def norm(vector: ArrayLike) -> Array:
    """Return lengths over the last axis. Shape (..., n) to (...)."""
    return np.asarray(np.sqrt(inner(vector, vector)))


def hypot(x: ArrayLike, y: ArrayLike) -> Array:
    """Return sqrt(x^2 + y^2). Shape (...). Squares must not overflow."""
    a, b = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    return np.asarray(np.sqrt(a * a + b * b))


def sin(angle: ArrayLike) -> Array:
    """Return sines [angles in rad]. Shape (...)."""
    return sin_cos(angle)[0]


def cos(angle: ArrayLike) -> Array:
    """Return cosines [angles in rad]. Shape (...)."""
    return sin_cos(angle)[1]


def tan(angle: ArrayLike) -> Array:
    """Return tangents [angles in rad]. Shape (...)."""
    sine, cosine = sin_cos(angle)
    return np.asarray(sine / cosine)


def hypot_of(x: float, y: float) -> float:
    """Return sqrt(x^2 + y^2) of two numbers, the same bits as `hypot`."""
    return math.sqrt(x * x + y * y)


def arctan(value: ArrayLike) -> Array:
    """Return the angles between -pi/2 and pi/2 with a tangent [rad]. Shape (...)."""
    return arctan2(value, 1.0)


def arccos(value: ArrayLike) -> Array:
    """Return the angles between 0 and pi with a cosine [rad]. Shape (...)."""
    c = np.asarray(value, dtype=np.float64)
    return np.asarray(2.0 * arctan2(np.sqrt(1.0 - c), np.sqrt(1.0 + c)))


def arcsin(value: ArrayLike) -> Array:
    """Return the angles between -pi/2 and pi/2 with a sine [rad]. Shape (...)."""
    s = np.asarray(value, dtype=np.float64)
    return arctan2(s, np.sqrt((1.0 - s) * (1.0 + s)))


def log(value: float) -> float:
    """Return the natural logarithm of one positive number."""
    mantissa, exponent = math.frexp(value)
    if mantissa < math.sqrt(0.5):
        mantissa, exponent = 2.0 * mantissa, exponent - 1
    u = (mantissa - 1.0) / (mantissa + 1.0)
    z, series = u * u, 0.0
    for k in range(24, 0, -1):
        series = z * (1.0 / (2 * k + 1) + series)
    return exponent * _LN2 + 2.0 * (u + u * series)


def exp_of(value: float) -> float:
    """Return the exponential of one number."""
    halvings = round(value / _LN2)
    rest, series = value - halvings * _LN2, 1.0
    for k in range(20, 0, -1):
        series = 1.0 + rest * series / k
    return math.ldexp(series, halvings)


def power_of(base: float, exponent: float) -> float:
    """Return one positive number to a power; some units in the last place per unit of the logarithm."""
    return exp_of(exponent * log(base)) if exponent else 1.0


def normal_numbers(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Return normally distributed numbers, rounded: the last bits of the rarest depend on the system's logarithm."""
    return np.round(rng.standard_normal(shape), 9)


def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Return nodes on [-1, 1] and weights of Gauss quadrature, by Newton's method on the Legendre polynomial.

    Args:
        count: How many nodes, at least 1.

    Returns:
        Nodes, ascending, and weights. Shapes (count,).
    """
    x = -cos(np.pi * (np.arange(count) + 0.75) / (count + 0.5))
    slope = np.ones(count)
    for _ in range(50):
        before, value = np.ones(count), x
        for k in range(2, count + 1):
            before, value = value, ((2 * k - 1) * x * value - (k - 1) * before) / k
        slope = count * (before - x * value) / (1.0 - x * x)
        step = value / slope
        x = x - step
        if np.max(np.abs(step)) < 1e-16:
            break
    x = 0.5 * (x - x[::-1])
    weights = 2.0 / ((1.0 - x * x) * slope * slope)
    return x, 0.5 * (weights + weights[::-1])
