"""The swimmer as CasADi expressions, for the peers that need a model of their own.

It is written anew from the README's equations with the drag of each link from `Swimmer.drag`, and the first
thing a run does is to compare it with `purcell_cli.mechanics.connection`. Lengths are in units of L; a state is
position, base quaternion, limb quaternions (w, x, y, z): 15 numbers.
"""

from __future__ import annotations

from typing import Any

import casadi as cs
import numpy as np

from purcell_cli import Swimmer
from purcell_cli.geometry.rotations import as_quaternion
from purcell_cli.mechanics.configuration import Configuration

STATES, CONTROLS = 15, 6


def quaternion_product(a: Any, b: Any) -> Any:
    """Return the product of quaternions (w, x, y, z)."""
    return cs.vertcat(a[0] * b[0] - cs.dot(a[1:], b[1:]), a[0] * b[1:] + b[0] * a[1:] + cs.cross(a[1:], b[1:]))


def matrix(q: Any) -> Any:
    """Return the rotation matrix of a unit quaternion."""
    w, v = q[0], q[1:]
    return (w * w - cs.dot(v, v)) * cs.SX.eye(3) + 2.0 * (v @ v.T) + 2.0 * w * cs.skew(v)


def solved(p: Any, wanted: Any) -> Any:
    """Return the solutions of a symmetric positive definite system, by elimination without pivots."""
    p, wanted, n = cs.SX(p), cs.SX(wanted), p.shape[0]
    for j in range(n):
        for i in range(j + 1, n):
            factor = p[i, j] / p[j, j]
            p[i, j + 1 :] -= factor * p[j, j + 1 :]
            wanted[i, :] -= factor * wanted[j, :]
    for j in reversed(range(n)):
        for i in range(j + 1, n):
            wanted[j, :] -= p[j, i] * wanted[i, :]
        wanted[j, :] /= p[j, j]
    return wanted


def resistance_and_wrench(swimmer: Swimmer, limbs: list[Any], rates: Any) -> tuple[Any, Any]:
    """Return P, and the wrench Q omega of turning limbs on a base at rest, for limb orientations (matrices)."""
    p, wrench = cs.SX(cs.sparsify(swimmer.drag_matrix(0))), cs.SX.zeros(6)
    base, half = swimmer.base_half_length_m, swimmer.limb_half_length_m
    for i, side in ((0, 1.0), (1, -1.0)):
        turned = limbs[i].T
        centre = side * (base * cs.SX([1.0, 0.0, 0.0]) + half * limbs[i][:, 0])
        b = cs.vertcat(cs.horzcat(turned, -turned @ cs.skew(centre)), cs.horzcat(cs.SX.zeros(3, 3), turned))
        w = cs.vertcat(-side * half * cs.skew(cs.SX([1.0, 0.0, 0.0])), cs.SX.eye(3))
        drag = cs.SX(cs.sparsify(swimmer.drag_matrix(i + 1)))
        p += b.T @ drag @ b
        wrench += b.T @ (drag @ (w @ rates[3 * i : 3 * i + 3]))
    return p, wrench


class Model:
    """The equation of motion of a swimmer with L = 1, and its derivative.

    Attributes:
        motion: Takes state and control to the state's rate of change.
        slope: Takes them to its derivative by both. The twist xi solves P xi = -Q omega, so its derivative is
            -P^-1 times that of P xi + Q omega at fixed xi: the elimination itself is not differentiated.
    """

    def __init__(self, swimmer: Swimmer) -> None:
        x, u, held = cs.SX.sym("x", STATES), cs.SX.sym("u", CONTROLS), cs.SX.sym("xi", 6)
        base, first, second = x[3:7], x[7:11], x[11:15]
        p, wrench = resistance_and_wrench(swimmer.scaled(), [matrix(first), matrix(second)], u)
        xi = solved(p, -wrench)
        spins = [(base, held[3:]), (first, u[:3]), (second, u[3:])]
        turning = [0.5 * quaternion_product(q, cs.vertcat(0.0, w)) for q, w in spins]
        rate = cs.vertcat(matrix(base) @ held[:3], *turning)
        by = cs.veccat(x, u)
        change = -solved(p, cs.jacobian(p @ held + wrench, by))
        slope = cs.jacobian(rate, by) + cs.jacobian(rate, held) @ change
        given = cs.Function("given", [x, u, held], [rate, slope])
        self.twist = cs.Function("twist", [x, u], [xi], {"cse": True})
        self.motion = cs.Function("motion", [x, u], [given(x, u, xi)[0]], {"cse": True})
        self.slope = cs.Function("slope", [x, u], given(x, u, xi), {"cse": True})

    def step(self, steps: int) -> Any:
        """Return the flow of (state, control, duration): classical Runge-Kutta steps of order four."""
        x, u, duration = cs.SX.sym("x", STATES), cs.SX.sym("u", CONTROLS), cs.SX.sym("h")
        end, h = x, duration / steps
        for _ in range(steps):
            k = [self.motion(end, u)]
            for share in (0.5, 0.5, 1.0):
                k.append(self.motion(end + share * h * k[-1], u))
            end = end + h / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
        return cs.Function("step", [x, u, duration], [end])

    def step_slope(self) -> Any:
        """Return the derivative of one such step by state and control, by the chain rule over its four stages."""
        x, u, h = cs.SX.sym("x", STATES), cs.SX.sym("u", CONTROLS), cs.SX.sym("h")
        start = cs.horzcat(cs.SX.eye(STATES), cs.SX(STATES, CONTROLS))
        held = cs.horzcat(cs.SX(CONTROLS, STATES), cs.SX.eye(CONTROLS))
        total, rate, change = cs.SX(STATES, STATES + CONTROLS), cs.SX.zeros(STATES), cs.SX(STATES, STATES + CONTROLS)
        for share, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
            before = start + share * h * change
            rate, by = self.slope(x + share * h * rate, u)
            change = by @ cs.vertcat(before, held)
            total += weight * change
        return cs.Function("step_slope", [x, u, h], [start + h / 6.0 * total], {"cse": True})


def state_of(configuration: Configuration, length_m: float) -> np.ndarray:
    """Return a configuration as a state."""
    turned = np.stack([configuration.pose[:3, :3], *configuration.shape])
    return np.concatenate([configuration.pose[:3, 3] / length_m, as_quaternion(turned).ravel()])
