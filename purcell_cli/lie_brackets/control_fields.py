"""The control fields on Q = SO(3) x SO(3) x SE(3) and their Lie brackets at a shape, by exact Taylor arithmetic.

Control j turns a limb about one of its own axes: the field X_j = (E_j, xi_j) with E_j left invariant on
SO(3) x SO(3) and xi_j = -A(r) e_j the base's twist (equation (pure_kinematic_CVFs) of the paper, section IV).
All of these are left invariant in the base too, so that a bracket of fields (u, xi), (w, eta) with constant u, w is

    ([u, w], E_u eta - E_w xi + [xi, eta]),

[u, w] the limbs' cross products and the last term the bracket of se(3). Derivatives E_u are those along
A_i exp(t hat(u_i)). Around the shape A_i(x) = A_i exp(hat(x_i)), and every xi is a Taylor polynomial in x:
brackets of depth k need A(r) to degree k - 1, and no difference is ever taken.

Beside a wall the fields depend on where the base is too, and three more variables say so: with V_c the derivative along
the base's own motion c, a bracket's twist has xi_c V_c eta - eta_c V_c xi besides.

Twists are in units of L: the swimmer is scaled. Conventions: `rotations`.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, cross, hat
from purcell_cli.lie_brackets.bead_polynomials import left_of_zero, resistance_polynomial, wall_steps
from purcell_cli.lie_brackets.ranks import ROUNDING
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


@frozen_dataclass(eq=False)
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


@frozen_dataclass(eq=False)
class Frame:
    """The controls around a shape: coordinates, and the fields E_j in them.

    Attributes:
        controls: The controls that act, 0 to 5; closed under brackets.
        degree: To what degree the control fields are known.
        steps: How the coordinates move along E_j: column j. Shape (monomials, c, c).
        fields: The control fields, depth 1.
        angular: Limbs, 0 or 1, whose coordinates are joint angles: their fields commute.
        base_steps: Beside a wall, how its coordinates move along the base's own motions. Shape (monomials, 6, 3).
        rounding: What is left of a twist that is zero, per largest one.
    """

    controls: tuple[int, ...]
    degree: int
    steps: Array
    fields: Fields
    angular: tuple[int, ...] = ()
    base_steps: Array | None = None
    rounding: float = ROUNDING

    def ring(self, degree: int) -> Taylor:
        """Return the polynomials of a degree in the coordinates."""
        return taylor(len(self.controls) + (0 if self.base_steps is None else 3), degree)

    def along(self, twist: Array, degree: int) -> Array:
        """Return the derivatives of twists along all E_j, to one degree less.

        Args:
            twist: Polynomials. Shape (monomials, n, 6).
            degree: Their degree.

        Returns:
            Polynomials. Shape (fewer monomials, c, n, 6).
        """
        return self._stepped(twist, degree, self.steps, 0)

    def _stepped(self, twist: Array, degree: int, steps: Array, first: int) -> Array:
        """Return derivatives along fields that move the coordinates from some variable on by these steps."""
        high, low = self.ring(degree), self.ring(degree - 1)
        partial = np.stack([high.derivative(twist, first + k)[: len(low)] for k in range(steps.shape[1])], axis=1)
        flat = partial.reshape(len(low), steps.shape[1], -1)
        turned = np.swapaxes(steps[: len(low)], 1, 2)
        return low.product(turned, flat, np.matmul).reshape(*turned.shape[:2], *partial.shape[2:])

    def _carried(self, own: Array, twist: Array, degree: int) -> Array:
        """Return xi_c V_c eta - eta_c V_c xi of the controls' twists xi and others eta. Shape (monomials, c, n, 6)."""
        if self.base_steps is None:
            return np.zeros(())
        low, steps = self.ring(degree - 1), np.swapaxes(self.base_steps, 1, 2)
        first = len(self.controls)
        by_own, by_other = (self._stepped(x, degree, steps, first) for x in (own, twist))
        short = own[: len(low)], twist[: len(low)]
        out = low.product(short[0], by_other, lambda a, b: np.einsum("mjc,mcnt->mjnt", a, b))
        return out - low.product(short[1], by_own, lambda a, b: np.einsum("mnc,mcjt->mjnt", a, b))

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
        change = change + low.product(*pairs, se3.bracket) + self._carried(own, fields.twist, degree)
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
    swimmer: Swimmer,
    shape: Array,
    degree: int,
    controls: tuple[int, ...] = ALL_CONTROLS,
    beside: Array | None = None,
) -> Array:
    """Return A(r) of the scaled swimmer around a shape, from P A = Q of section III-C as polynomials.

    Args:
        swimmer: The swimmer.
        shape: The shape (A_1, A_2). Shape (2, 3, 3).
        degree: The degree.
        controls: The coordinates of A_i exp(hat(x_i)) that are varied; x is (x_1, x_2).
        beside: How the scaled swimmer sees its wall; three more variables then vary that. Shape (4,).

    Returns:
        Polynomials on (omega_1, omega_2). Shape (monomials, 6, 6).
    """
    ring = taylor(len(controls) + (0 if beside is None else 3), degree)
    x = coordinates(ring, controls)
    limbs = [shape[k] @ exponential(ring, x[:, 3 * k : 3 * k + 3], EXPONENTIAL) for k in (0, 1)]
    return connection_of_limbs(swimmer, ring, limbs, beside)


def connection_of_limbs(swimmer: Swimmer, ring: Taylor, limbs: Sequence[Array], beside: Array | None = None) -> Array:
    """Return A(r) of the scaled swimmer from the limbs' orientations as polynomials.

    Args:
        swimmer: The swimmer.
        ring: The polynomials.
        limbs: The orientations A_1 and A_2. Shapes (monomials, 3, 3).
        beside: How the scaled swimmer sees its wall. Shape (4,).

    Returns:
        Polynomials on (omega_1, omega_2). Shape (monomials, 6, 6).
    """
    unit = swimmer.scaled()
    if swimmer.fluid == "beads":
        full = resistance_polynomial(unit, ring, (limbs[0], limbs[1]), beside)
        turned = [ring.product(full[:, :6, 6 + 3 * k : 9 + 3 * k], limbs[k], np.matmul) for k in (0, 1)]
        return ring.solved(full[:, :6, :6], np.concatenate(turned, axis=-1))
    p, q = ring.constant(unit.drag_matrix(0)), np.zeros((len(ring), 6, 6))
    for limb, side in ((1, 1.0), (2, -1.0)):
        part = slice(3 * limb - 3, 3 * limb)
        a = limbs[limb - 1]
        a_t = np.swapaxes(a, 1, 2)
        centre = side * (unit.base_half_length_m * ring.constant(_E_X) + unit.halves_m[limb] * a[..., 0])
        b = np.zeros((len(ring), 6, 6))
        b[:, :3, :3] = b[:, 3:, 3:] = a_t
        b[:, :3, 3:] = -ring.product(a_t, hat(centre), np.matmul)
        wrench = np.swapaxes(b, 1, 2) @ unit.drag_matrix(limb)
        p += ring.product(wrench, b, np.matmul)
        q[..., part] = wrench @ rate_to_limb(unit, limb)
    return ring.solved(p, q)


def frame(
    swimmer: Swimmer,
    shape: Array,
    degree: int,
    controls: tuple[int, ...] = ALL_CONTROLS,
    beside: Array | None = None,
) -> Frame:
    """Return the control fields around a shape.

    Args:
        swimmer: The swimmer.
        shape: The shape (A_1, A_2). Shape (2, 3, 3).
        degree: The degree; brackets of depth k need k - 1.
        controls: The controls that act, closed under brackets.
        beside: How the scaled swimmer sees its wall. Shape (4,).
    """
    ring = taylor(len(controls) + (0 if beside is None else 3), degree)
    x = coordinates(ring, controls)
    steps = np.zeros((len(ring), 6, 6))
    for part in (slice(0, 3), slice(3, 6)):
        steps[:, part, part] = exponential(ring, x[:, part], BERNOULLI)
    xi = -np.swapaxes(connection_polynomial(swimmer, shape, degree, controls, beside), 1, 2)
    words = tuple((j,) for j in controls)
    own = Fields(words, np.eye(6)[list(controls)], xi[:, controls])
    moved = steps[np.ix_(range(len(ring)), controls, controls)]
    base = None if beside is None else wall_steps(ring, beside)
    return Frame(controls, degree, moved, own, base_steps=base, rounding=rounding_of(swimmer, shape, beside))


def rounding_of(swimmer: Swimmer, shape: Array, beside: Array | None) -> float:
    """Return what is left of a twist that is zero, per largest one; see `frame`."""
    return left_of_zero(swimmer.scaled(), shape, beside) if swimmer.fluid == "beads" else ROUNDING


@functools.cache
def _axis_name(control: int) -> str:
    return f"{('roll', 'pitch', 'yaw')[control % 3]} {control // 3 + 1}"


def word_name(word: Word) -> str:
    """Return a bracket in words, like '[yaw 1, [yaw 1, yaw 2]]'."""
    if len(word) == 1:
        return _axis_name(word[0])
    return f"[{_axis_name(word[0])}, {word_name(word[1:])}]"
