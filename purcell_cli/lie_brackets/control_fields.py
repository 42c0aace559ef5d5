"""The control fields on Q = SO(3) x SO(3) x SE(3) and their Lie brackets at a shape, by exact Taylor arithmetic.

Control j turns a limb about one of its own axes: the field X_j = (E_j, xi_j) with E_j left invariant on
SO(3) x SO(3) and xi_j = -A(r) e_j the base's twist (equation (pure_kinematic_CVFs) of the paper, section IV).
All of these are left invariant in the base too, so that a bracket of fields (u, xi), (w, eta) with constant u, w is

    ([u, w], E_u eta - E_w xi + [xi, eta]),

[u, w] the limbs' cross products and the last term the bracket of se(3). Derivatives E_u are those along
A_i exp(t hat(u_i)). Around the shape A_i(x) = A_i exp(hat(x_i)), and every xi is a Taylor polynomial in x:
brackets of depth k need A(r) to degree k - 1, and no difference is ever taken.

Twists are in units of L: the swimmer is scaled. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, cross, hat
from purcell_cli.lie_brackets.taylor import Taylor, taylor
from purcell_cli.mechanics.connection import rate_to_limb
from purcell_cli.mechanics.swimmer import Swimmer

ALL_CONTROLS = tuple(range(6))
"""The controls of the swimmer in space: limb 1 x, y, z, limb 2 x, y, z."""

YAW_CONTROLS = (2, 5)
"""The controls of the planar swimmer."""

BERNOULLI = (1.0, 1.0 / 2.0, 1.0 / 12.0, 0.0, -1.0 / 720.0, 0.0, 1.0 / 30240.0)
"""Coefficients of t / (1 - exp(-t)): exp(x) exp(t u) = exp(x + t sum_n b_n hat(x)^n u), to first order in t."""

EXPONENTIAL = tuple(1.0 / float(np.prod(range(1, n + 1))) for n in range(len(BERNOULLI)))
"""Coefficients of exp(t), 1 / n!, as many as of the series above."""

_E_X = np.array([1.0, 0.0, 0.0])
"""The axis of a link in its own frame."""

MOST_DEPTH = len(BERNOULLI) - 1
"""The deepest brackets that there are coefficients for."""

Word = tuple[int, ...]
"""A bracket by its controls: (i, j, k) is [X_i, [X_j, X_k]]."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Fields:
    """Fields on Q of one bracket depth.

    Attributes:
        words: Which brackets they are.
        limbs: Their constant parts in so(3) + so(3), the limbs' own axes. Shape (n, 6).
        twist: Their base twists (v/L, omega) as Taylor polynomials. Shape (monomials, n, 6).
    """

    words: tuple[Word, ...]
    limbs: Array
    twist: Array


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The controls around a shape: coordinates, and the fields E_j in them.

    Attributes:
        controls: The controls that act, 0 to 5; closed under brackets.
        degree: To what degree the control fields are known.
        steps: How the coordinates move along E_j: column j. Shape (monomials, c, c).
        fields: The control fields, depth 1.
        angular: Limbs, 0 or 1, whose coordinates are joint angles: their fields commute.
    """

    controls: tuple[int, ...]
    degree: int
    steps: Array
    fields: Fields
    angular: tuple[int, ...] = ()

    def ring(self, degree: int) -> Taylor:
        """Return the polynomials of a degree in the controls' coordinates."""
        return taylor(len(self.controls), degree)

    def along(self, twist: Array, degree: int) -> Array:
        """Return the derivatives of twists along all E_j, to one degree less.

        Args:
            twist: Polynomials. Shape (monomials, n, 6).
            degree: Their degree.

        Returns:
            Polynomials. Shape (fewer monomials, c, n, 6).
        """
        high, low = self.ring(degree), self.ring(degree - 1)
        count = len(self.controls)
        partial = np.stack([high.derivative(twist, k)[: len(low)] for k in range(count)], axis=1)
        flat = partial.reshape(len(low), count, -1)
        turned = np.swapaxes(self.steps[: len(low)], 1, 2)
        return low.product(turned, flat, np.matmul).reshape(partial.shape)

    def brackets(self, fields: Fields, degree: int) -> Fields:
        """Return all brackets [X_j, F] of the controls with fields, to one degree less.

        Args:
            fields: The fields F.
            degree: The degree to which they are known.
        """
        low = self.ring(degree - 1)
        own = self.fields.twist[: len(self.ring(degree))]
        change = self.along(fields.twist, degree)
        chosen = fields.limbs[:, self.controls]
        change = change - np.einsum("nk,mkjt->mjnt", chosen, self.along(own, degree))
        pairs = (own[: len(low), :, None], fields.twist[: len(low), None])
        change = change + low.product(*pairs, se3.bracket)
        limbs = np.concatenate(
            [
                cross(self.fields.limbs[:, None, part], fields.limbs[None, :, part])
                for part in (slice(0, 3), slice(3, 6))
            ],
            axis=-1,
        )
        for limb in self.angular:
            limbs[..., 3 * limb : 3 * limb + 3] = 0.0
        words = tuple((j, *word) for j in self.controls for word in fields.words)
        return Fields(words, limbs.reshape(-1, 6), change.reshape(len(low), -1, 6))

    def vertical(self, fields: Fields) -> Array:
        """Return what fields add to the base beside the lift of their limb parts: xi + A(r) u. As `Fields.twist`."""
        own = self.fields.twist[: len(fields.twist)]
        out: Array = fields.twist - np.einsum("nk,mkt->mnt", fields.limbs[:, self.controls], own)
        return out


def first_brackets(frame: Frame) -> Fields:
    """Return the brackets [X_i, X_j], i < j: the controls' own are told once."""
    both = frame.brackets(frame.fields, frame.degree)
    keep = [k for k, (i, j) in enumerate(both.words) if i < j]
    return Fields(tuple(both.words[k] for k in keep), both.limbs[keep], both.twist[:, keep])


def brackets_by_depth(frame: Frame) -> Iterator[Fields]:
    """Return the brackets of depth 2, 3, ... as far as the degree of the control fields goes."""
    fields = None
    for degree in range(frame.degree, 0, -1):
        fields = first_brackets(frame) if fields is None else frame.brackets(fields, degree)
        yield fields


def exponential(ring: Taylor, x: Array, coefficients: tuple[float, ...]) -> Array:
    """Return sum_n c_n hat(x)^n for a vector of polynomials. Shape (monomials, 3) to (monomials, 3, 3)."""
    power, out = ring.constant(np.eye(3)), coefficients[0] * ring.constant(np.eye(3))
    for c in coefficients[1 : ring.degree + 1]:
        power = ring.product(power, hat(x), np.matmul)
        out = out + c * power
    return out


def coordinates(ring: Taylor, controls: tuple[int, ...]) -> Array:
    """Return the coordinates x = (x_1, x_2) in which controls vary, as polynomials. Shape (monomials, 6)."""
    x = np.zeros((len(ring), 6))
    for k, control in enumerate(controls):
        x[:, control] = ring.variable(k)
    return x


def connection_polynomial(
    swimmer: Swimmer, shape: Array, degree: int, controls: tuple[int, ...] = ALL_CONTROLS
) -> Array:
    """Return A(r) of the scaled swimmer around a shape, from P A = Q of section III-C as polynomials.

    Args:
        swimmer: The swimmer.
        shape: The shape (A_1, A_2). Shape (2, 3, 3).
        degree: The degree.
        controls: The coordinates of A_i exp(hat(x_i)) that are varied; x is (x_1, x_2).

    Returns:
        Polynomials on (omega_1, omega_2). Shape (monomials, 6, 6).

    Raises:
        ParameterError: Links that feel each other's flow: there is no closed form for them.
    """
    ring = taylor(len(controls), degree)
    x = coordinates(ring, controls)
    limbs = [shape[k] @ exponential(ring, x[:, 3 * k : 3 * k + 3], EXPONENTIAL) for k in (0, 1)]
    return connection_of_limbs(swimmer, ring, limbs)


def connection_of_limbs(swimmer: Swimmer, ring: Taylor, limbs: Sequence[Array]) -> Array:
    """Return A(r) of the scaled swimmer from the limbs' orientations as polynomials.

    Args:
        swimmer: The swimmer.
        ring: The polynomials.
        limbs: The orientations A_1 and A_2. Shapes (monomials, 3, 3).

    Returns:
        Polynomials on (omega_1, omega_2). Shape (monomials, 6, 6).

    Raises:
        ParameterError: Links that feel each other's flow: there is no closed form for them.
    """
    if swimmer.fluid != "local":
        raise ParameterError(f"fluid: 'local', for brackets of control fields, is wanted, found {swimmer.fluid!r}")
    unit = swimmer.scaled()
    p, q = ring.constant(unit.drag(0)), np.zeros((len(ring), 6, 6))
    for limb, side in ((1, 1.0), (2, -1.0)):
        part = slice(3 * limb - 3, 3 * limb)
        a = limbs[limb - 1]
        a_t = np.swapaxes(a, 1, 2)
        centre = side * (unit.base_half_length_m * ring.constant(_E_X) + unit.limb_half_length_m * a[..., 0])
        b = np.zeros((len(ring), 6, 6))
        b[:, :3, :3] = b[:, 3:, 3:] = a_t
        b[:, :3, 3:] = -ring.product(a_t, hat(centre), np.matmul)
        wrench = np.swapaxes(b, 1, 2) @ unit.drag(limb)
        p += ring.product(wrench, b, np.matmul)
        q[..., part] = wrench @ rate_to_limb(unit, limb)
    return ring.solved(p, q)


def frame(swimmer: Swimmer, shape: Array, degree: int, controls: tuple[int, ...] = ALL_CONTROLS) -> Frame:
    """Return the control fields around a shape.

    Args:
        swimmer: The swimmer.
        shape: The shape (A_1, A_2). Shape (2, 3, 3).
        degree: The degree; brackets of depth k need k - 1.
        controls: The controls that act, closed under brackets.
    """
    ring = taylor(len(controls), degree)
    x = coordinates(ring, controls)
    steps = np.zeros((len(ring), 6, 6))
    for part in (slice(0, 3), slice(3, 6)):
        steps[:, part, part] = exponential(ring, x[:, part], BERNOULLI)
    xi = -np.swapaxes(connection_polynomial(swimmer, shape, degree, controls), 1, 2)
    words = tuple((j,) for j in controls)
    own = Fields(words, np.eye(6)[list(controls)], xi[:, controls])
    return Frame(controls, degree, steps[np.ix_(range(len(ring)), controls, controls)], own)


@functools.cache
def _axis_name(control: int) -> str:
    return f"{('roll', 'pitch', 'yaw')[control % 3]} {control // 3 + 1}"


def word_name(word: Word) -> str:
    """Return a bracket in words, like '[yaw 1, [yaw 1, yaw 2]]'."""
    if len(word) == 1:
        return _axis_name(word[0])
    return f"[{_axis_name(word[0])}, {word_name(word[1:])}]"
