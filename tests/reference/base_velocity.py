"""The numpy reference of the kernel's connection: the base's twist in closed form, and its derivatives (III-C).

Drag depends on a limb only through its axis a_i = A_i e_x. Rates are therefore kept in base
coordinates here, u_i = A_i omega_i, and the twist is a function of (a_1, a_2, u_1, u_2) alone,
linear in the rates. Conventions: `rotations`.

Arrays have components first and shapes last: see `rows`.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.geometry.component_first import cross_rows, dot_rows, factored_rows, solved_rows
from purcell_cli.geometry.reproducible import arccos, cos
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer

_E_X = np.array([1.0, 0.0, 0.0])[:, None, None]
"""The axis of a link in its own frame. Shape (3, 1, 1)."""

_SIDES = np.array([1.0, -1.0])[:, None]
"""On which side of the base's middle limb 1 and limb 2 hang. Shape (2, 1)."""

_FARTHEST = 1.0
"""Distances from the straight line count up to here [rad]: A(r) varies with the bends themselves."""


class TwistModel:
    """The numbers of a scaled swimmer that the twist needs, with lateral drag per length 1."""

    def __init__(self, swimmer: Swimmer) -> None:
        unit = swimmer.scaled()
        self.length_m = swimmer.length_m
        self.base, self.limb = unit.base_half_length_m, unit.limb_half_length_m
        self.lateral = 2.0 * self.limb
        self.longitudinal_defect = 1.0 - 1.0 / unit.drag_ratio
        self.turn = 2.0 / 3.0 * self.limb * self.limb * self.limb
        self.spin = unit.rod(1).spin
        self.base_drag = unit.drag_matrix(0)
        self.sharpness, self.straight_spread = unit.roll_sharpness(), unit.bend_spread()
        self.steepness = math.sqrt(4.0 * self.turn / self.straight_spread)

    def distance(self, axes: Array) -> Array:
        """Return how far a shape is from a straight line, as a bend of one limb [rad]. Shape (3, 2, n) to (n,).

        The spread of the links about the line that fits them best resists roll about that line;
        spin drag resists it where there is no spread.
        """
        c = self.centres(axes)
        first = 2.0 * self.limb * (c[:, 0] + c[:, 1])
        total = 2.0 * self.base + 4.0 * self.limb
        second = 2.0 * self.limb * (c[:, None] * c).sum(axis=2)
        second += self.turn * (axes[:, None] * axes).sum(axis=2)
        second[0, 0] += 2.0 / 3.0 * self.base * self.base * self.base
        second -= first[:, None] * first / total
        spread = np.maximum(_spread(second), 0.0)
        return np.asarray(
            np.minimum(np.sqrt(self.sharpness * self.sharpness + spread / self.straight_spread), _FARTHEST)
        )

    def centres(self, axes: Array) -> Array:
        """Return the limbs' centres in base coordinates. Shape (3, 2, n)."""
        return _SIDES * (self.base * _E_X + self.limb * axes)

    def resistance(self, axes: Array) -> Array:
        """Return P about the base's centre, in closed form. Shape (3, 2, n) to (6, 6, n)."""
        c = self.centres(axes)
        moment = np.concatenate([axes, cross_rows(c, axes)])
        out: Array = (moment[:, None] * (-self.lateral * self.longitudinal_defect * moment)).sum(axis=2)
        # Torques: M - hat(c) D hat(c), with the part along the axis of D counted above.
        out[3:, 3:] += (axes[:, None] * ((self.spin - self.turn) * axes)).sum(axis=2)
        out[3:, 3:] -= (c[:, None] * (self.lateral * c)).sum(axis=2)
        square = self.lateral * dot_rows(c, c).sum(axis=0)
        k = self.lateral * (c[:, 0] + c[:, 1])
        for i in range(3):
            j, l = (i + 1) % 3, (i + 2) % 3
            out[3 + l, j] += k[i]
            out[3 + j, l] -= k[i]
            out[j, 3 + l] += k[i]
            out[l, 3 + j] -= k[i]
            out[i, i] += 2.0 * self.lateral + self.base_drag[i, i]
            out[3 + i, 3 + i] += 2.0 * self.turn + self.base_drag[3 + i, 3 + i] + square
        return out

    def limb_wrench(self, axes: Array, velocity: Array | float, rate: Array) -> tuple[Array, Array]:
        """Return force and torque about the joint that move a limb with its joint's velocity.

        Args:
            axes: Limb axes. Shape (3, ..., 2, n), broadcast against the others.
            velocity: Velocities of the joints, or 0. Shape (3, ..., 2, n).
            rate: Angular velocities of the limbs. Shape (3, ..., 2, n).
        """
        arm = _SIDES * self.limb * axes
        at_centre = velocity + cross_rows(rate, arm)
        along = dot_rows(axes, at_centre) * axes
        force = self.lateral * (at_centre - self.longitudinal_defect * along)
        spin = dot_rows(axes, rate) * axes
        torque = cross_rows(arm, force) + self.turn * rate + (self.spin - self.turn) * spin
        return force, torque

    def to_base(self, force: Array, torque: Array) -> Array:
        """Return wrenches about the base's centre from those about the joints. Shape (6, ..., 2, n)."""
        out = np.concatenate([force, torque])
        arm = self.base * _SIDES
        out[4] -= arm * force[2]
        out[5] += arm * force[1]
        return out

    def twist(self, axes: Array, rates: Array) -> Array:
        """Return the base's twist xi = -P^-1 q for limb rates in base coordinates. Shapes (3, 2, n) to (6, n)."""
        return self._twist(factored_rows(self.resistance(axes)), axes, rates)

    def _twist(self, factors: Array, axes: Array, rates: Array) -> Array:
        wrench = self.to_base(*self.limb_wrench(axes, 0.0, rates))
        return solved_rows(factors, -wrench[:, 0] - wrench[:, 1])

    def _seen_by_limbs(self, xi: Array) -> tuple[Array, Array]:
        """Return the joints' velocities and the base's angular velocity. Shapes (3, 2, n) and (3, 1, n)."""
        v, w = np.repeat(xi[:3, None], 2, axis=1), xi[3:, None]
        arm = self.base * _SIDES
        v[1] += arm * w[2]
        v[2] -= arm * w[1]
        return v, w

    def joint_power(self, axes: Array, rates: Array) -> Array:
        """Return the power of both joints' torques. Shapes (3, 2, n) to (n,)."""
        v_joint, w = self._seen_by_limbs(self.twist(axes, rates))
        torque = self.limb_wrench(axes, v_joint, w + rates)[1]
        return np.asarray(dot_rows(torque, rates).sum(axis=0))

    def twist_and_change(self, axes: Array, rates: Array) -> tuple[Array, Array]:
        """Return the twist and its derivative when a limb, with its rate, is turned in the base frame.

        Turning axis and rate of limb i by eta turns the limb's wrench and the motion it sees;
        only the base's motion stays. That gives the derivative without differentiating P.

        Returns:
            Twists, shape (6, n), and derivatives along eta = e_x, e_y, e_z for each limb, shape
            (6, 2, 3, n).
        """
        factors = factored_rows(self.resistance(axes))
        xi = self._twist(factors, axes, rates)
        v_joint, w = self._seen_by_limbs(xi)
        force, torque = self.limb_wrench(axes, v_joint, w + rates)
        eta = np.eye(3)[:, :, None, None]  # (3, 3, 1, 1): broadcasts over limbs and shapes
        seen = self.limb_wrench(axes[:, None], cross_rows(eta, v_joint[:, None]), cross_rows(eta, w[:, None]))
        change = self.to_base(seen[0] - cross_rows(eta, force[:, None]), seen[1] - cross_rows(eta, torque[:, None]))
        columns = np.ascontiguousarray(change.transpose(0, 2, 1, 3))
        return xi, solved_rows(factors, columns)

    def per_rate(self, axes: Array) -> Array:
        """Return the twist for unit limb rates along e_x, e_y, e_z in base coordinates. Shape (6, 2, 3, n)."""
        each = np.eye(3)[:, :, None, None]
        wrench = self.to_base(*self.limb_wrench(axes[:, None], 0.0, each))  # (6, 3, 2, n)
        return solved_rows(factored_rows(self.resistance(axes)), -wrench.transpose(0, 2, 1, 3))


def _spread(moments: Array) -> Array:
    """Return the sum of the two smaller eigenvalues of symmetric matrices, in closed form. Shape (3, 3, n) to (n,).

    The largest by the cosine of a third of an angle (Smith 1961, Comm. ACM 4, 168).
    """
    trace = moments[0, 0] + moments[1, 1] + moments[2, 2]
    mean = trace / 3.0
    d = [moments[i, i] - mean for i in range(3)]
    a, b, c = moments[0, 1], moments[0, 2], moments[1, 2]
    size = np.sqrt(np.maximum((d[0] ** 2 + d[1] ** 2 + d[2] ** 2 + 2.0 * (a**2 + b**2 + c**2)) / 6.0, 1e-300))
    half_det = (
        0.5 * (d[0] * (d[1] * d[2] - c**2) - a * (a * d[2] - c * b) + b * (a * c - d[1] * b)) / (size * size * size)
    )
    largest = mean + 2.0 * size * cos(arccos(np.clip(half_det, -1.0, 1.0)) / 3.0)
    return np.asarray(trace - largest)


@functools.lru_cache(maxsize=64)
def twist_model(swimmer: Swimmer) -> TwistModel:
    """Return the numbers of a swimmer, made once."""
    return TwistModel(swimmer)
