"""Arithmetic that gives the same bits on every processor.

A plan is a long chain of decisions, and some hang on the last bit. Matrix products and solutions by
BLAS and LAPACK, and sines by vector units, end with other bits on other processors. What stands here
uses only sums, products, quotients and square roots of IEEE doubles, in an order that depends on
nothing but the shapes of the arrays. Errors are a few units in the last place, as elsewhere.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_TERMS = 9
"""Terms of both Taylor series below."""
_SIN_COS = np.array(
    [[(-1.0) ** (k + 1) / math.factorial(2 * k + 3), (-1.0) ** k / math.factorial(2 * k + 4)] for k in range(_TERMS)]
)
"""Taylor coefficients of (sin r - r) / r^3 and (cos r - 1 + r^2 / 2) / r^4 in r^2: truncation below 1e-19 to pi/4."""
_SIN_COS_LAST, _SIN_COS_REST = _SIN_COS[-1].tolist(), _SIN_COS[-2::-1].tolist()
_HALF_PI = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
"""pi/2 in three parts of 33 bits: their products with whole numbers below 2^20 are exact (Cody and Waite 1980)."""
_ONE_BY_ONE = 8
"""Arrays of up to so many numbers go through Python's floats: quicker than numpy's calls, the same operations."""
_ATAN = np.array([[(-1.0) ** (k + 1) / (2 * k + 3)] for k in range(7)])
"""Taylor coefficients of (atan u - u) / u^3 in u^2: truncation below 1e-20 to u = 1/16."""
_EIGHTHS = [
    0.0,
    0.12435499454676143503,
    0.24497866312686415417,
    0.35877067027057222040,
    0.46364760900080611621,
    0.55859931534356243597,
    0.64350110879328438680,
    0.71882999962162450541,
    0.78539816339744830962,
]
"""atan(k / 8), to all digits of a double."""
_ATAN_EIGHTHS = np.array(_EIGHTHS)
_ATAN_LAST, _ATAN_REST = float(_ATAN[-1, 0]), _ATAN[-2::-1, 0].tolist()
_PI_REST = 1.2246467991473531772e-16
"""What pi has beyond its double."""
_LN2 = 0.69314718055994530942
"""The natural logarithm of 2, to all digits of a double."""
_SERIES = np.array(
    [[(-1.0) ** k / math.factorial(2 * k + first) for first in (1, 2, 3)] for k in range(12)]
)  # fmt: skip
"""Taylor coefficients of sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 in t^2."""
_TERMS_UP_TO = ((0.01, 5), (0.25, 8))
"""So many terms of `_SERIES` do where no t^2 is larger: truncation below 1e-17."""
SERIES_BELOW = 2.25
"""Up to this t^2 the series of `exp_coefficients` hold to rounding: truncation below 1e-17."""


_MANY, _FEW, _SMALL = 200, 216, 600
"""From so many matrices on, of up to so many terms each, rows are long; arrays of fewer terms are summed at once."""
_LONG = 8
"""Sums of more terms than this are left to numpy, which adds them pairwise."""


def matmul(first: ArrayLike, second: ArrayLike) -> NDArray[Any]:
    """Return products of matrices and vectors as `numpy.matmul` does, in the arrays' precision.

    Sums of few terms are made from the first on, whichever way is quick for so many products.

    Args:
        first: Matrices, or one vector. Shape (..., n, k).
        second: Matrices, or one vector. Shape (..., k, m), broadcast against the first.

    Returns:
        Products. Shape (..., n, m).
    """
    a, b = np.asarray(first), np.asarray(second)
    if b.ndim == 1:
        return inner(a, b)
    if a.ndim == 1:
        return np.asarray(matmul(a[None], b)[..., 0, :])
    n, k = a.shape[-2:]
    m = b.shape[-1]
    if a.ndim == b.ndim == 3 and len(a) == len(b) >= _MANY and n * k * m <= _FEW:
        return _long_rows(np.ascontiguousarray(a.transpose(1, 2, 0)), np.ascontiguousarray(b.transpose(1, 2, 0)))
    if k > _LONG:
        return inner(a[..., :, None, :], np.swapaxes(b, -1, -2)[..., None, :, :])
    if m > 1 and a.size * m <= _SMALL:
        return np.asarray(np.add.reduce(a[..., None] * b[..., None, :, :], axis=-2))
    out = a[..., :, 0, None] * b[..., 0, None, :]
    for j in range(1, k):
        out += a[..., :, j, None] * b[..., j, None, :]
    return np.asarray(out)


def _long_rows(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Return the products of matrices with the components on the first axes. Shapes (n, k, c) and (k, m, c)."""
    out = np.empty((a.shape[2], a.shape[0], b.shape[1]), dtype=np.result_type(a, b))
    for i in range(a.shape[0]):
        row = a[i, 0] * b[0]
        for j in range(1, a.shape[1]):
            row += a[i, j] * b[j]
        out[:, i] = row.T
    return out


def inner(first: ArrayLike, second: ArrayLike) -> Array:
    """Return inner products over the last axis. Shapes (..., n) to (...)."""
    a, b = np.asarray(first), np.asarray(second)
    count = max(a.shape[-1], b.shape[-1])
    if count > _LONG or count == 0:
        return np.asarray(np.add.reduce(np.ascontiguousarray(a * b), axis=-1))
    out = a[..., 0] * b[..., 0]
    for k in range(1, count):
        out = out + a[..., k] * b[..., k]
    return np.asarray(out)


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


def sin_cos(angle: ArrayLike) -> tuple[Array, Array]:
    """Return sines and cosines [angles in rad]. Shape (...)."""
    x = np.asarray(angle, dtype=np.float64)
    if x.size <= _ONE_BY_ONE:
        pairs = np.array([sin_cos_of(one) for one in x.ravel().tolist()]).reshape(*x.shape, 2)
        return np.array(pairs[..., 0]), np.array(pairs[..., 1])
    quarter = np.rint(x * (2.0 / np.pi))
    turned = quarter.any()
    r = ((x - quarter * _HALF_PI[0]) - quarter * _HALF_PI[1]) - quarter * _HALF_PI[2] if turned else x
    z = r * r
    series = _horner(_SIN_COS, z)
    half = 0.5 * z
    sine = r + r * (z * series[0])
    near = 1.0 - half
    cosine = near + (((1.0 - near) - half) + z * (z * series[1]))
    if not turned:
        return np.asarray(sine), np.asarray(cosine)
    place = np.remainder(quarter, 4.0)
    swapped = (place == 1.0) | (place == 3.0)
    sine, cosine = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return np.where(place >= 2.0, -sine, sine), np.where((place == 1.0) | (place == 2.0), -cosine, cosine)


def sin_cos_of(angle: float) -> tuple[float, float]:
    """Return the sine and cosine of one angle [rad], the same bits as `sin_cos`."""
    if not math.isfinite(angle):
        return math.nan, math.nan
    quarter = round(angle * (2.0 / math.pi))
    r = ((angle - quarter * _HALF_PI[0]) - quarter * _HALF_PI[1]) - quarter * _HALF_PI[2] if quarter else angle
    z = r * r
    first, second = _SIN_COS_LAST
    for one, two in _SIN_COS_REST:
        first, second = first * z + one, second * z + two
    half = 0.5 * z
    sine = r + r * (z * first)
    near = 1.0 - half
    cosine = near + (((1.0 - near) - half) + z * (z * second))
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[quarter % 4]


def _horner(coefficients: Array, z: Array) -> Array:
    """Return several polynomials, the last coefficients first. Shapes (k, n) and (...) to (n, ...)."""
    column = (coefficients.shape[1], *(1 for _ in z.shape))
    out = np.empty((coefficients.shape[1], *z.shape))
    out[...] = coefficients[-1].reshape(column)
    for row in coefficients[-2::-1]:
        out *= z
        out += row.reshape(column)
    return out


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


def exp_coefficients(angle_squared: Array) -> tuple[Array, Array, Array]:
    """Return sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 as functions of t^2. Shape (...)."""
    x = np.asarray(angle_squared, dtype=np.float64)
    largest = float(np.max(x, initial=0.0))
    terms = next((count for reach, count in _TERMS_UP_TO if largest <= reach), len(_SERIES))
    series = _horner(_SERIES[:terms], np.minimum(x, SERIES_BELOW))
    if largest > SERIES_BELOW:
        t = np.sqrt(np.maximum(x, SERIES_BELOW))
        sine, cosine = sin_cos(t)
        far = x > SERIES_BELOW
        closed = sine / t, (1.0 - cosine) / (t * t), (t - sine) / (t * t * t)
        return (
            np.where(far, closed[0], series[0]),
            np.where(far, closed[1], series[1]),
            np.where(far, closed[2], series[2]),
        )
    return series[0], series[1], series[2]


def arctan2(y: ArrayLike, x: ArrayLike) -> Array:
    """Return the angles of points (x, y), between -pi and pi [rad]. Shape (...)."""
    rise, run = np.asarray(y, dtype=np.float64), np.asarray(x, dtype=np.float64)
    if rise.size <= _ONE_BY_ONE and run.size <= _ONE_BY_ONE:
        rise, run = np.broadcast_arrays(rise, run)
        angles = [arctan2_of(p, q) for p, q in zip(rise.ravel().tolist(), run.ravel().tolist(), strict=True)]
        return np.array(angles, dtype=np.float64).reshape(rise.shape)
    up, along = np.abs(rise), np.abs(run)
    low, high = np.minimum(up, along), np.maximum(up, along)
    high = np.where(high > 0.0, high, 1.0)
    eighth = np.rint(8.0 * (low / high))
    node = 0.125 * eighth
    u = (low - node * high) / (high + node * low)
    z = u * u
    series = _horner(_ATAN, z)[0]
    angle = _ATAN_EIGHTHS[np.where(eighth >= 0.0, eighth, 0.0).astype(np.int64)] + (u + u * (z * series))
    angle = np.where(up > along, (0.5 * np.pi - angle) + 0.5 * _PI_REST, angle)
    angle = np.where(np.signbit(run), (np.pi - angle) + _PI_REST, angle)
    return np.asarray(np.copysign(angle, rise))


def arctan2_of(y: float, x: float) -> float:
    """Return the angle of one point (x, y) [rad], the same bits as `arctan2`."""
    if math.isnan(x) or math.isnan(y):
        return math.nan
    up, along = abs(y), abs(x)
    low, high = min(up, along), max(up, along)
    high = high if high > 0.0 else 1.0
    eighth = round(8.0 * (low / high))
    node = 0.125 * eighth
    u = (low - node * high) / (high + node * low)
    z = u * u
    series = _ATAN_LAST
    for one in _ATAN_REST:
        series = series * z + one
    angle = _EIGHTHS[eighth] + (u + u * (z * series))
    angle = (0.5 * math.pi - angle) + 0.5 * _PI_REST if up > along else angle
    angle = (math.pi - angle) + _PI_REST if math.copysign(1.0, x) < 0.0 else angle
    return math.copysign(angle, y)


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
