"""The curvature and the Lie brackets are what small loops of the exact lift do, and what sixty digits give."""

from __future__ import annotations

import itertools
from typing import Any

import mpmath
import numpy as np
import pytest
from helpers import UNIT, assert_close, bent, is_close, random_shapes, random_swimmer, slope

from purcell_cli import Swimmer, controllability, curvature
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import hat
from purcell_cli.lie_brackets.bracket_gaits import bracket_gait, gait_twist
from purcell_cli.lie_brackets.control_fields import (
    ALL_CONTROLS,
    brackets_by_depth,
    connection_polynomial,
    frame,
    word_name,
)
from purcell_cli.lie_brackets.ranks import rank_of
from purcell_cli.lie_brackets.taylor import taylor
from purcell_cli.mechanics.connection import COLLINEAR, connection

AMPLITUDES = np.array([5e-4, 1e-3, 2e-3])


def shape_of(seed: int) -> np.ndarray:
    return random_shapes(np.random.default_rng(seed), 1)[0]


@pytest.mark.parametrize("pair", [(2, 5), (1, 5), (0, 4), (1, 2), (3, 5)])
def test_a_small_loop_moves_the_base_by_the_curvature(pair: tuple[int, int]) -> None:
    """What is left over falls with the cube of the side; with the other sign it is as large as the motion."""
    shape = shape_of(3)
    exact = gait_twist(UNIT, pair, AMPLITUDES, shape)
    foretold = -np.outer(AMPLITUDES**2, curvature(UNIT, shape)[:, *pair])
    assert abs(slope(AMPLITUDES, np.linalg.norm(exact - foretold, axis=1)) - 3.0) < 0.15
    assert abs(slope(AMPLITUDES, np.linalg.norm(exact + foretold, axis=1)) - 2.0) < 0.15


def test_the_curvature_is_antisymmetric_and_batched() -> None:
    shapes = random_shapes(np.random.default_rng(4), 2, 3)
    found = curvature(UNIT, shapes)
    assert_close(found, -np.swapaxes(found, -1, -2), 1e-12)
    assert_close(found[1, 2], curvature(UNIT, shapes[1, 2]), 1e-12)
    assert not is_close(found, np.zeros_like(found), 1e-3)
    with pytest.raises(ParameterError, match="a shape is an array"):
        curvature(UNIT, np.eye(3))


def test_the_curvature_has_units() -> None:
    """A swimmer twice as large moves twice as far and turns alike."""
    shape = shape_of(5)
    small, large = (curvature(Swimmer(x, x), shape) for x in (0.1, 0.2))
    assert_close(large[:3], 2.0 * small[:3], 1e-12)
    assert_close(large[3:], small[3:], 1e-12)


def test_the_planar_curvature_at_the_collinear_shape() -> None:
    """Equal links of unit half length: 10/81 forward, and nothing else, by hand from the planar P and Q."""
    wanted = np.array([10.0 / 81.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert_close(curvature(UNIT, COLLINEAR)[:, 2, 5], wanted, 1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_brackets_of_depth_two_are_minus_the_curvature(seed: int) -> None:
    """Two ways to differentiate: polynomials from the paper's P and Q, and the twist's closed form."""
    swimmer = random_swimmer(np.random.default_rng(seed)).scaled()
    shape = shape_of(seed)
    around = frame(swimmer, shape, 1)
    (brackets,) = brackets_by_depth(around)
    found = around.vertical(brackets)[0]
    both = curvature(swimmer, shape)
    wanted = np.array([-both[:, i, j] for i, j in brackets.words])
    assert_close(found, wanted, 1e-12, float(np.abs(wanted).max()))
    assert not is_close(found, -wanted, 1e-3)


@pytest.mark.parametrize("degree", [2, 4])
def test_the_connection_is_its_polynomial(degree: int) -> None:
    """Around a shape the remainder falls with one power more than the degree."""
    shape, ring = shape_of(8), taylor(6, degree)
    turn = np.random.default_rng(8).normal(size=6)
    polynomial = connection_polynomial(UNIT, shape, degree)
    sizes, errors = np.array([0.01, 0.02, 0.04]), []
    for size in sizes:
        there = shape @ se3.rotation(size * turn.reshape(2, 3))
        monomials = np.prod((size * turn) ** ring.powers, axis=1)
        errors.append(np.linalg.norm(np.tensordot(monomials, polynomial, 1) - connection(UNIT, there)))
    assert abs(slope(sizes, errors) - degree - 1) < 0.3


def test_brackets_obey_jacobi() -> None:
    around = frame(UNIT, shape_of(9), 2)
    _, third = brackets_by_depth(around)
    twist = dict(zip(third.words, third.twist[0], strict=True))

    def bracket(i: int, j: int, k: int) -> np.ndarray:
        return twist[i, j, k] if j < k else -twist[i, k, j]

    for i, j, k in itertools.combinations(ALL_CONTROLS, 3):
        cyclic = [bracket(i, j, k), bracket(j, k, i), bracket(k, i, j)]
        assert_close(sum(cyclic), np.zeros(6), 1e-11)
        assert not is_close(cyclic[0] + cyclic[1] - cyclic[2], np.zeros(6), 1e-7)


@pytest.mark.parametrize("word", [(2, 2, 5), (1, 1, 2), (0, 2, 4), (2, 5, 2, 5), (1, 2, 1, 5)])
def test_a_bracket_is_what_its_gait_does(word: tuple[int, ...]) -> None:
    """What is left over falls with one power more than the bracket's depth, and not with the other sign."""
    shape = bent(0.6, 0.5) @ bent(0.3, -0.4, 2)
    around = frame(UNIT, shape, len(word) - 1)
    *_, last = brackets_by_depth(around)
    flip = 1.0 if word[-2] < word[-1] else -1.0
    inner = word if flip > 0 else (*word[:-2], word[-1], word[-2])
    foretold = flip * around.vertical(last)[0][last.words.index(inner)]
    sizes = np.array([0.01, 0.014, 0.02])
    exact, powers = gait_twist(UNIT, word, sizes, shape), sizes[:, None] ** len(word)
    assert abs(slope(sizes, np.linalg.norm(exact - powers * foretold, axis=1)) - len(word) - 1) < 0.15
    assert abs(slope(sizes, np.linalg.norm(exact + powers * foretold, axis=1)) - len(word)) < 0.15
    assert_close(bracket_gait(word, 0.3, shape).shapes(shape)[-1], shape, 1e-14)


def test_brackets_are_named() -> None:
    assert word_name((2, 0, 5)) == "[yaw 1, [roll 1, yaw 2]]"


class HighPrecision:
    """The connection and its derivatives by differences of sixty digits, from section III as corrected."""

    STEP = mpmath.mpf(10) ** -15

    def __init__(self, swimmer: Swimmer, shape: np.ndarray) -> None:
        number = np.vectorize(mpmath.mpf, otypes=[object])
        self.hat = lambda v: np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]], dtype=object)
        self.swimmer, self.shape = swimmer, [self.near(number(a)) for a in shape]

    @staticmethod
    def near(a: np.ndarray) -> np.ndarray:
        """Return the rotation to sixty digits: Newton steps of the polar factor."""
        for _ in range(4):
            a = a @ (np.eye(3, dtype=int).astype(object) * 3 - a.T @ a) / 2
        return a

    def drag(self, half: float) -> np.ndarray:
        half, a = mpmath.mpf(half), mpmath.mpf(self.swimmer.slenderness)
        k, spin = 1 / mpmath.log(1 / a), (2 * a * half) ** 2
        turn = 2 * k * half**3 / 3
        rows = [2 * k * half / mpmath.mpf(self.swimmer.drag_ratio), 2 * k * half, 2 * k * half]
        return np.diag(np.array([*rows, 2 * spin * half, turn, turn], dtype=object))

    def twists(self, shape: list[np.ndarray]) -> np.ndarray:
        """Return xi_j = -A e_j as rows. Shape (6, 6)."""
        base, half = mpmath.mpf(self.swimmer.base_half_length_m), mpmath.mpf(self.swimmer.limb_half_length_m)
        p, q = self.drag(base), np.zeros((6, 6), dtype=object)
        e_x = np.array([1, 0, 0], dtype=object)
        for limb, (a, side) in enumerate(zip(shape, (1, -1), strict=True)):
            b, w = np.zeros((6, 6), dtype=object), np.zeros((6, 3), dtype=object)
            b[:3, :3] = b[3:, 3:] = a.T
            b[:3, 3:] = -a.T @ self.hat(side * (base * e_x + half * a[:, 0]))
            w[:3], w[3:] = -side * half * self.hat(e_x), np.eye(3, dtype=int)
            p = p + b.T @ self.drag(half) @ b
            q[:, 3 * limb : 3 * limb + 3] = b.T @ self.drag(half) @ w
        inverse = np.array((mpmath.matrix(p.tolist()) ** -1).tolist(), dtype=object)
        return -(inverse @ q).T

    def turned(self, shape: list[np.ndarray], control: int, angle: Any) -> list[np.ndarray]:
        j, k = (control % 3 + 1) % 3, (control % 3 + 2) % 3
        turn = np.eye(3, dtype=int).astype(object)
        turn[j, j] = turn[k, k] = mpmath.cos(angle)
        turn[k, j], turn[j, k] = mpmath.sin(angle), -mpmath.sin(angle)
        return [a @ turn if limb == control // 3 else a for limb, a in enumerate(shape)]

    def along(self, controls: tuple[int, ...], shape: list[np.ndarray]) -> np.ndarray:
        """Return the twists' derivatives along left-invariant fields, the first outermost."""
        if not controls:
            return self.twists(shape)
        ends = [self.along(controls[1:], self.turned(shape, controls[0], s * self.STEP)) for s in (1, -1)]
        return (ends[0] - ends[1]) / (2 * self.STEP)


def object_bracket(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.concatenate(
        [np.cross(a[3:], b[:3]) - np.cross(b[3:], a[:3]), np.cross(a[3:], b[3:])],
    )


def high_precision_brackets(swimmer: Swimmer, shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertical brackets of depth 2 and 3, in the order of `fields`."""
    mp = HighPrecision(swimmer, shape)
    xi = mp.along((), mp.shape)
    first = [mp.along((i,), mp.shape) for i in range(6)]
    second = [[mp.along((i, j), mp.shape) for j in range(6)] for i in range(6)]
    units = np.eye(3, dtype=int)

    def limbs(i: int, u: np.ndarray) -> np.ndarray:
        out = np.zeros(6, dtype=int)
        part = slice(3 * (i // 3), 3 * (i // 3) + 3)
        out[part] = np.cross(units[i % 3], u[part])
        return out

    two, three = [], []
    for j, k in itertools.combinations(range(6), 2):
        e_k = np.eye(6, dtype=int)[k]
        u = limbs(j, e_k)
        eta = first[j][k] - first[k][j] + object_bracket(xi[j], xi[k])
        two.append(eta - u @ xi)
        for i in range(6):
            change = second[i][j][k] - second[i][k][j]
            change = change + object_bracket(first[i][j], xi[k]) + object_bracket(xi[j], first[i][k])
            lifted = sum(u[m] * first[m][i] for m in range(6))
            whole = change - lifted + object_bracket(xi[i], eta)
            three.append(((i, j, k), whole - limbs(i, u) @ xi))
    return np.array(two), np.array([x for _, x in sorted(three, key=lambda pair: pair[0])])


THIN = Swimmer(1.0, 1.0, slenderness=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("swimmer", "shape"),
    [(UNIT, COLLINEAR), (UNIT, shape_of(11)), (THIN, bent(0.01, 0.02))],
    ids=["collinear", "random", "thin"],
)
def test_brackets_and_ranks_are_those_of_sixty_digits(swimmer: Swimmer, shape: np.ndarray) -> None:
    with mpmath.workdps(60):
        wanted = high_precision_brackets(swimmer, shape)
        every = np.concatenate(wanted)
        values = sorted((abs(v) for v in mpmath.eigsy(mpmath.matrix((every.T @ every).tolist()))[0]), reverse=True)
        exact = np.array([float(mpmath.sqrt(v)) for v in values])
        ranks = [sum(mpmath.sqrt(v) > mpmath.mpf(10) ** -20 for v in values)]
        two = mpmath.eigsy(mpmath.matrix((wanted[0].T @ wanted[0]).tolist()))[0]
        ranks.insert(0, sum(mpmath.sqrt(abs(v)) > mpmath.mpf(10) ** -20 for v in two))
    around = frame(swimmer, shape, 2)
    found = [around.vertical(fields)[0] for fields in brackets_by_depth(around)]
    for a, b in zip(found, wanted, strict=True):
        rounding = rank_of(np.vstack(found)).floor
        assert_close(a, b.astype(float), rounding)
        assert not is_close(a, 1.001 * b.astype(float), rounding)
    assert_close(rank_of(np.vstack(found)).singular_values, exact, rank_of(np.vstack(found)).floor)
    levels = controllability(swimmer, shape, 3).depths
    assert [level.rank.dimension for level in levels] == ranks[: len(levels)]


def test_the_step_matrix_is_that_of_the_exponential() -> None:
    """exp(hat(x)) exp(t hat(e_j)) = exp(hat(x + t E_j x)) to first order in t."""
    around, ring = frame(UNIT, COLLINEAR, 5), taylor(6, 5)
    x = np.array([0.2, -0.1, 0.15, 0.0, 0.0, 0.0])
    steps = np.tensordot(np.prod(x**ring.powers, axis=1), around.steps, 1)
    for j in range(3):
        t = 1e-6
        ends = [se3.rotation(x[:3]) @ se3.rotation(s * t * np.eye(3)[j]) for s in (1.0, -1.0)]
        wanted = (ends[0] - ends[1]) / (2 * t)
        assert_close(se3.rotation(x[:3]) @ hat(np.eye(3)[j]), wanted, 1e-9)
        moved = [se3.rotation(x[:3] + s * t * steps[:3, j]) for s in (1.0, -1.0)]
        assert_close((moved[0] - moved[1]) / (2 * t), wanted, 1e-6)
        straight = [se3.rotation(x[:3] + s * t * np.eye(3)[j]) for s in (1.0, -1.0)]
        assert not is_close((straight[0] - straight[1]) / (2 * t), wanted, 1e-3)
