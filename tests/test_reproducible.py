"""Arithmetic that gives the same bits on every processor: it is right, and it is one order of operations."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest

from purcell_cli.geometry import linear_systems as systems
from purcell_cli.geometry import reproducible as r
from purcell_cli.kernel.linear import orthogonal_rows

RNG = np.random.default_rng(7)
ANGLES = np.concatenate(
    [RNG.uniform(-1.0, 1.0, 300), RNG.uniform(-30.0, 30.0, 300), RNG.uniform(-1e5, 1e5, 100), [0.0]]
)
PACKAGE = Path(r.__file__).parent.parent
ROOMS = ("geometry", "mechanics", "motion", "planner")
"""Where plans are made; `verification` and `lie_brackets` judge and explain them."""


def units_off(found: np.ndarray, exact: list[mpmath.mpf]) -> float:
    """Return the largest error in units in the last place."""
    off = [abs(mpmath.mpf(float(x)) - y) / np.spacing(abs(float(y))) for x, y in zip(found, exact, strict=True) if y]
    return float(max(off))


@pytest.mark.parametrize(
    ("found", "exact", "points"),
    [
        (r.sin, mpmath.sin, ANGLES),
        (r.cos, mpmath.cos, ANGLES),
        (r.arccos, mpmath.acos, RNG.uniform(-1.0, 1.0, 300)),
        (r.arcsin, mpmath.asin, RNG.uniform(-1.0, 1.0, 300)),
        (r.arctan, mpmath.atan, RNG.normal(size=300) * 10.0 ** RNG.uniform(-5.0, 5.0, 300)),
        (np.vectorize(r.log), mpmath.log, RNG.uniform(1.1, 1e4, 300)),
        (np.vectorize(r.exp_of), mpmath.exp, RNG.uniform(-1.0, 1.0, 300)),
    ],
)
def test_functions_are_right_to_few_units_in_the_last_place(found, exact, points) -> None:
    with mpmath.workdps(40):
        wanted = [exact(mpmath.mpf(float(x))) for x in points]
        assert units_off(found(points), wanted) < 3.0
        assert units_off(found(points * (1.0 + 1e-14)), wanted) > 3.0


def test_the_coefficients_of_exp_hold_on_both_sides_of_where_their_series_end() -> None:
    x = np.concatenate([[0.0, 1e-12], RNG.uniform(0.0, 4.5, 300), [0.01, 0.25, 2.25]])
    with mpmath.workdps(90):
        t = [mpmath.sqrt(mpmath.mpf(float(v))) or mpmath.mpf(10) ** -15 for v in x]
        exact = (
            [mpmath.sin(v) / v for v in t],
            [(1 - mpmath.cos(v)) / v**2 for v in t],
            [(v - mpmath.sin(v)) / v**3 for v in t],
        )
        for found, wanted in zip(r.exp_coefficients(x), exact, strict=True):
            assert units_off(found, wanted) < 6.0


@pytest.mark.parametrize(("y", "x"), [(0.0, 0.0), (0.0, -1.0), (-0.0, -1.0), (1.0, 0.0), (-2.0, 0.0), (-0.0, 1.0)])
def test_arc_tangents_on_the_axes_are_those_of_the_standard(y: float, x: float) -> None:
    assert r.arctan2(y, x) == math.atan2(y, x)
    assert math.copysign(1.0, r.arctan2(y, x)) == math.copysign(1.0, math.atan2(y, x))
    assert np.array_equal(r.arctan2(np.full(20, y), np.full(20, x)), np.full(20, math.atan2(y, x)))


def test_one_number_and_many_have_the_same_bits() -> None:
    sines, cosines = r.sin_cos(ANGLES)
    assert [r.sin_cos_of(x) for x in ANGLES.tolist()] == list(zip(sines.tolist(), cosines.tolist(), strict=True))
    y = RNG.normal(size=len(ANGLES))
    assert [r.arctan2_of(*pair) for pair in zip(y.tolist(), ANGLES.tolist(), strict=True)] == r.arctan2(
        y, ANGLES
    ).tolist()


@pytest.mark.parametrize("inner", [3, 4, 6])
@pytest.mark.parametrize("columns", [1, 4])
def test_products_have_the_same_bits_however_many_are_made_at_once(inner: int, columns: int) -> None:
    a, b = RNG.normal(size=(300, 4, inner)), RNG.normal(size=(300, inner, columns))
    many = r.matmul(a, b)
    assert np.allclose(many, np.matmul(a, b), rtol=0.0, atol=1e-13)
    assert all(np.array_equal(r.matmul(a[k], b[k]), many[k]) for k in range(len(a)))
    assert np.array_equal(r.matmul(a[:, None], b[:, None])[:, 0], many)


def test_products_take_vectors_as_numpy_does() -> None:
    a, v, w = RNG.normal(size=(5, 3, 12)), RNG.normal(size=12), RNG.normal(size=3)
    assert np.allclose(r.matmul(a, v), a @ v, atol=1e-13)
    assert np.allclose(r.matmul(w, a), w @ a, atol=1e-13)
    assert np.allclose(r.apply(a, np.tile(v, (5, 1))), a @ v, atol=1e-13)


def test_solutions_solve_their_systems_with_zeros_on_the_diagonal_too() -> None:
    a, b = RNG.normal(size=(40, 6, 6)), RNG.normal(size=(40, 6, 2))
    a[:, 0, 0] = 0.0
    assert np.max(np.abs(a @ systems.solve(a, b) - b)) < 1e-10
    assert np.allclose(a @ systems.inverse(a), np.eye(6), atol=1e-10)
    assert not np.all(np.isfinite(systems.solve(np.zeros((2, 2)), np.ones(2))))


@pytest.mark.parametrize("shape", [(12, 5), (5, 12), (40, 12), (6, 6), (7, 1), (3, 2)])
def test_least_squares_and_singular_values_agree_with_lapack(shape: tuple[int, int]) -> None:
    a, b = RNG.normal(size=shape), RNG.normal(size=shape[0])
    u, s, vt = systems.singular_values(a)
    assert np.allclose((u * s) @ vt, a, rtol=0.0, atol=1e-13)
    assert np.allclose(s, np.linalg.svd(a, compute_uv=False), rtol=1e-13)
    assert np.allclose(systems.least_squares(a, b), np.linalg.lstsq(a, b, rcond=None)[0], rtol=0.0, atol=1e-12)


def test_equations_that_depend_on_others_are_left_out() -> None:
    a, b = RNG.normal(size=(8, 30)), RNG.normal(size=8)
    a[5] = a[3] + a[2]
    assert np.allclose(systems.least_squares(a, b, 1e-9), np.linalg.lstsq(a, b, rcond=1e-9)[0], rtol=0.0, atol=1e-12)
    assert orthogonal_rows(a, 1e-9)[0].T.shape == (30, 7)


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_gauss_quadrature_is_exact_to_twice_its_nodes(count: int) -> None:
    x, weight = r.gauss_legendre(count)
    for power in range(2 * count + 1):
        exact = (1.0 + (-1.0) ** power) / (power + 1)
        assert (abs(np.sum(weight * x**power) - exact) < 1e-14) == (power < 2 * count)


def test_where_plans_are_made_nothing_depends_on_the_processor() -> None:
    """BLAS, LAPACK and the C library's functions end with other bits on other processors."""
    found = []
    for path in sorted(file for room in ROOMS for file in (PACKAGE / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
                found.append(f"{path.stem}:{node.lineno} {ast.unparse(node)}")
            if isinstance(node, ast.Attribute) and ast.unparse(node) in FORBIDDEN:
                found.append(f"{path.stem}:{node.lineno} {ast.unparse(node)}")
    assert found == []


FORBIDDEN = {
    *(f"np.{name}" for name in ("sin", "cos", "tan", "arctan2", "arccos", "arcsin", "arctan", "hypot", "exp", "log")),
    *(f"np.{name}" for name in ("matmul", "dot", "einsum", "tensordot", "linalg", "polyfit", "power")),
    *(f"math.{name}" for name in ("sin", "cos", "tan", "atan2", "acos", "asin", "atan", "exp", "log", "pow", "hypot")),
}
