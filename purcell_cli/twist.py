"""The base's twist in closed form, and its derivative by the limbs' orientations and rates (section III-C).

Drag depends on a limb only through its axis a_i = A_i e_x. Rates are therefore kept in base
coordinates here, u_i = A_i omega_i, and the twist is a function of (a_1, a_2, u_1, u_2) alone,
linear in the rates. Conventions: `rotations`.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from purcell_cli.rotations import Array, cross, hat
from purcell_cli.swimmer import Swimmer

_E_X = np.array([1.0, 0.0, 0.0])
_I3 = np.eye(3)
_SIDES = np.array([1.0, -1.0])
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
        self.turn = 2.0 / 3.0 * self.limb**3
        self.spin = 2.0 * unit.spin_drag(self.limb) * self.limb
        self.base_drag = unit.drag(0)
        self.sharpness, self.straight_spread = unit.roll_sharpness(), unit.bend_spread()
        self.steepness = math.sqrt(8.0 / 3.0 * self.limb**3 / self.straight_spread)

    def distance(self, axes: Array) -> Array:
        """Return how far a shape is from a straight line, as a bend of one limb [rad]. Shape (n, 2, 3) to (n,).

        The spread of the links about the line that fits them best resists roll about that line;
        spin drag resists it where there is no spread.
        """
        c = self.centres(axes)
        total = 2.0 * self.base + 4.0 * self.limb
        second = 2.0 * self.limb * np.einsum("nli,nlj->nij", c, c)
        second += 2.0 / 3.0 * self.limb**3 * np.einsum("nli,nlj->nij", axes, axes)
        second[:, 0, 0] += 2.0 / 3.0 * self.base**3
        first = 2.0 * self.limb * c.sum(axis=1)
        second -= first[:, :, None] * first[:, None, :] / total
        moments = np.linalg.eigvalsh(second)
        spread = np.maximum(moments[:, 0] + moments[:, 1], 0.0)
        return np.asarray(np.minimum(np.sqrt(self.sharpness**2 + spread / self.straight_spread), _FARTHEST))

    def centres(self, axes: Array) -> Array:
        """Return the limbs' centres in base coordinates. Shape (n, 2, 3)."""
        return _SIDES[:, None] * (self.base * _E_X + self.limb * axes)

    def resistance(self, axes: Array) -> Array:
        """Return P about the base's centre, in closed form. Shape (n, 6, 6)."""
        c = self.centres(axes)
        moment = np.concatenate([axes, cross(c, axes)], axis=-1)
        out = -self.lateral * self.longitudinal_defect * np.einsum("nli,nlj->nij", moment, moment)
        # Torques: M - hat(c) D hat(c), with the part along the axis of D counted above.
        out[:, 3:, 3:] += (self.spin - self.turn) * np.einsum("nli,nlj->nij", axes, axes)
        out[:, 3:, 3:] -= self.lateral * np.einsum("nli,nlj->nij", c, c)
        c2 = self.lateral * np.einsum("nli,nli->n", c, c)
        total = c.sum(axis=1)
        k = self.lateral * hat(total)
        out[:, 3:, :3] += k
        out[:, :3, 3:] -= k
        out += self.base_drag
        for i in range(3):
            out[:, i, i] += 2.0 * self.lateral
            out[:, 3 + i, 3 + i] += 2.0 * self.turn + c2
        return np.asarray(out)

    def limb_wrench(self, axes: Array, velocity: Array, rate: Array) -> tuple[Array, Array]:
        """Return force and torque about the joint that move a limb with its joint's velocity.

        Args:
            axes: Limb axes. Shape (..., 2, 3), broadcast against the others.
            velocity: Velocities of the joints. Shape (..., 2, 3).
            rate: Angular velocities of the limbs. Shape (..., 2, 3).
        """
        arm = _SIDES[:, None] * self.limb * axes
        at_centre = velocity + cross(rate, arm)
        along = np.einsum("...i,...i->...", axes, at_centre)[..., None] * axes
        force = self.lateral * (at_centre - self.longitudinal_defect * along)
        spin = np.einsum("...i,...i->...", axes, rate)[..., None] * axes
        torque = cross(arm, force) + self.turn * rate + (self.spin - self.turn) * spin
        return force, torque

    def to_base(self, force: Array, torque: Array) -> Array:
        """Return wrenches about the base's centre from those about the joints. Shape (..., 6)."""
        joint = self.base * _SIDES[:, None] * _E_X
        return np.concatenate([force, torque + cross(joint, force)], axis=-1)

    def twist(self, axes: Array, rates: Array) -> Array:
        """Return the base's twist xi = -P^-1 q for limb rates in base coordinates. Shape (n, 6)."""
        wrench = self.to_base(*self.limb_wrench(axes, np.zeros(3), rates)).sum(axis=-2)
        out: Array = -np.linalg.solve(self.resistance(axes), wrench[..., None])[..., 0]
        return out

    def joint_power(self, axes: Array, rates: Array) -> Array:
        """Return the power of both joints' torques. Shape (n,)."""
        xi = self.twist(axes, rates)
        v, w = xi[:, None, :3], xi[:, None, 3:]
        v_joint = v + cross(w, self.base * _SIDES[:, None] * _E_X)
        torque = self.limb_wrench(axes, v_joint, w + rates)[1]
        return np.asarray(np.einsum("nli,nli->n", torque, rates))

    def twist_and_change(self, axes: Array, rates: Array) -> tuple[Array, Array]:
        """Return the twist and its derivative when a limb, with its rate, is turned in the base frame.

        Turning axis and rate of limb i by eta turns the limb's wrench and the motion it sees;
        only the base's motion stays. That gives the derivative without differentiating P.

        Returns:
            Twists, shape (n, 6), and derivatives along eta = e_x, e_y, e_z for each limb, shape
            (n, 6, 2, 3).
        """
        p_inverse = np.linalg.inv(self.resistance(axes))
        wrench = self.to_base(*self.limb_wrench(axes, np.zeros(3), rates)).sum(axis=-2)
        xi = -(p_inverse @ wrench[..., None])[..., 0]
        v, w = xi[:, None, :3], xi[:, None, 3:]
        v_joint = v + cross(w, self.base * _SIDES[:, None] * _E_X)
        force, torque = self.limb_wrench(axes, v_joint, w + rates)
        eta = _I3[:, None, None, :]  # (3, 1, 1, 3): broadcasts over nodes and limbs
        turned = (cross(eta, force), cross(eta, torque))
        seen = self.limb_wrench(axes, cross(eta, v_joint), cross(eta, w))
        change = self.to_base(turned[0] - seen[0], turned[1] - seen[1])  # (3, n, 2, 6)
        n = len(axes)
        columns = change.transpose(1, 3, 2, 0).reshape(n, 6, 6)
        return xi, -(p_inverse @ columns).reshape(n, 6, 2, 3)

    def per_rate(self, axes: Array) -> Array:
        """Return the twist for unit limb rates along e_x, e_y, e_z in base coordinates. Shape (n, 6, 2, 3)."""
        each = np.broadcast_to(_I3[:, None, None, :], (3, *axes.shape))
        wrench = self.to_base(*self.limb_wrench(axes, np.zeros(3), each))  # (3, n, 2, 6)
        n = len(axes)
        columns = wrench.transpose(1, 3, 2, 0).reshape(n, 6, 6)
        return -np.asarray(np.linalg.solve(self.resistance(axes), columns)).reshape(n, 6, 2, 3)


@functools.lru_cache(maxsize=64)
def twist_model(swimmer: Swimmer) -> TwistModel:
    """Return the numbers of a swimmer, made once."""
    return TwistModel(swimmer)
