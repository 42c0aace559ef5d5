"""Needle steering: a body displacement as three arcs, in planes of any roll, and a last roll.

A swimmer that repeats a loop swims along a circle, and a roll, which costs little, chooses its plane.
So phase 2 is nearly the steering of a bevel-tipped needle: find the twists of least cost with
exp(xi_1) exp(xi_2) exp(xi_3) exp(roll) = D, where xi = (a, 0, 0; 0, p, q) advances by a and turns by
(p, q) about the y and z axes. Iteratively reweighted least squares, with weights from the cost of the
swimmer's loops, find sparse minima from many starts at once.

Needle steering: Webster et al. (2006), Int. J. Robotics Research 25, 509. Reweighted least squares:
Daubechies et al. (2010), Comm. Pure Appl. Math. 63, 1.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.component_first import solve_positive
from purcell_cli.geometry.reproducible import (
    apply,
    arctan2,
    exp_coefficients,
    hypot,
    matmul,
    norm,
    normal_numbers,
)
from purcell_cli.geometry.rotations import Array, about_axis, hat
from purcell_cli.planner.arcs.loop_family import Fan

_ARCS = 3
"""Arcs of each solution; the least cost leaves some of them empty."""
_ROUNDS = 10
"""Rounds of least squares from each start, the settling ones included."""
_SETTLING = 3
"""The last rounds, in which arcs only settle on the displacement and the weights stay."""
_SMALL_RAD = 1e-3
"""Below this turn of an arc a derivative is taken from its series, since its closed form cancels [rad]."""
_E_ROLL = np.eye(6)[3]
"""The unit twist of a roll. Shape (6,)."""
_ROLL_PRICE = 0.1
"""Weight of the squared last roll beside those of the arcs."""
_LEAST = 1e-2
"""The least cost of an arc in its weights, which an empty arc would make infinite [rad]."""
_LONGEST_TURN = 0.5
"""The largest change of a turn or roll in one round [rad]."""
_WAYS = (1.0, -1.0)
"""Directions, forwards and backwards, of the straight ways among the starts."""
_REVIVED = 0.1
"""The least advance and turn by which an arc is priced, as a part of what its cost could make of either; without it an
arc that only advances, or only turns, could never do the other."""
_REVIVED_L = 1.0
"""The largest advance that is assumed so [L]."""
_REVIVED_RAD = 0.5
"""The largest turn that is assumed so [rad]."""
_ACROSS = (1, 4, 7, 9)
"""The unknowns that lead out of the x-y plane: turns about y, and the roll."""
_STRAY_RAD = 1e-6
"""Ways in a plane that turn out of it by less than this do so by rounding [rad]."""
_SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The frame whose axes are x, -z and y."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """Ways to make displacements by arcs.

    Attributes:
        arc: Advance [L] and turns about y and z [rad] of each arc. Shape (n, 3, 3).
        roll: The last roll [rad]. Shape (n,).
        displacement: Which displacement each way makes. Shape (n,).
    """

    arc: Array
    roll: Array
    displacement: NDArray[np.int64]


def steer(displacement: Array, fan: Fan, starts: int, seed: int = 0, plane: str | None = None) -> Arcs:
    """Return ways to make displacements by arcs, each a local optimum.

    Args:
        displacement: Body displacements [L]. Shape (k, 4, 4).
        fan: The swimmer's loops.
        starts: How many starts for each displacement.
        seed: Seed of the starts.
        plane: "yaw" for displacements in the x-y plane whose arcs stay there, "pitch" for the x-z plane; None for any.
    """
    if plane == "pitch":
        found = steer(seen_in_plane(displacement), fan, starts, seed, "yaw")
        return dataclasses.replace(found, arc=found.arc[..., [0, 2, 1]])
    rng = np.random.default_rng(seed)
    k = len(displacement)
    d = np.repeat(displacement, starts, axis=0)
    inverse = se3.inverse(d)
    n = len(d)
    spread = normal_numbers(rng, (k, starts, _ARCS, 3)) * [1.0, 0.8, 0.8]
    far = norm(displacement[:, :3, 3])[:, None, None, None]
    spread[..., :1] *= 0.5 * far + 0.5
    begun = np.concatenate([spread.reshape(k, starts, 9), rng.uniform(-np.pi, np.pi, (k, starts, 1))], axis=2)
    begun[:, : len(_WAYS)] = _straight(displacement)[:, :starts]
    if plane is not None:  # what is in the plane stays there, by symmetry
        begun[..., _ACROSS] = 0.0
    x = begun.reshape(n, 10)
    loose = np.empty((n, 10))
    for k_round in range(_ROUNDS):
        residual, jacobian = _equations(x, inverse)
        weighing = k_round < _ROUNDS - _SETTLING  # afterwards the arcs only settle on the displacement
        if weighing:
            loose = np.concatenate(
                [_looseness(x[:, :9].reshape(n, 3, 3), fan), np.full((n, 1), 1.0 / _ROLL_PRICE)], axis=1
            )
        lever = jacobian * loose[:, None, :]
        system = matmul(lever, np.swapaxes(jacobian, 1, 2))
        system += 1e-12 * np.trace(system, axis1=1, axis2=2)[:, None, None] * np.eye(6)
        from_here = x if weighing else 0.0 * x
        wanted = (matmul(jacobian, from_here[:, :, None]))[:, :, 0] - residual
        step = apply(np.swapaxes(lever, 1, 2), solve_positive(system, wanted)) - from_here
        turning = np.max(np.abs(step[:, [1, 2, 4, 5, 7, 8, 9]]), axis=1)
        x = x + step * np.minimum(1.0, _LONGEST_TURN / np.maximum(turning, 1e-300))[:, None]
    residual, _ = _equations(x, inverse)
    good = np.flatnonzero(np.max(np.abs(residual), axis=1) < 1e-3)
    if plane is not None:
        good = good[np.max(np.abs(x[good][:, _ACROSS]), axis=1) < _STRAY_RAD]
        x[:, _ACROSS] = 0.0
    return Arcs(x[good, :9].reshape(-1, 3, 3), x[good, 9], np.repeat(np.arange(k), starts)[good])


def seen_in_plane(displacement: Array) -> Array:
    """Return displacements in the x-z plane as ones in the x-y plane, turns about y as turns about z. (..., 4, 4)."""
    return matmul(matmul(_SIDEWAYS.T, displacement), _SIDEWAYS)


def _straight(displacement: Array) -> Array:
    """Return the ways to turn on the spot, go straight, forwards or backwards, and turn again. Shape (k, 2, 10)."""
    position, rotation = displacement[:, :3, 3], displacement[:, :3, :3]
    far = norm(position)
    out = np.zeros((len(far), len(_WAYS), 10))
    for k, sign in enumerate(_WAYS):
        along = sign * position / np.where(far > 0.0, far, 1.0)[:, None]
        first = _turn_to(along)
        rest = matmul(np.swapaxes(se3.rotation(first), 1, 2), rotation)
        last = _turn_to(rest[:, :, 0])
        left = matmul(np.swapaxes(se3.rotation(last), 1, 2), rest)
        out[:, k, 1:3], out[:, k, 3], out[:, k, 7:9] = first[:, 1:], sign * far, last[:, 1:]
        out[:, k, 9] = arctan2(left[:, 2, 1], left[:, 1, 1])
    return out


def _turn_to(axis: Array) -> Array:
    """Return the shortest rotation vectors that turn the x axis to unit vectors. Shape (n, 3)."""
    across = np.stack([np.zeros(len(axis)), -axis[:, 2], axis[:, 1]], axis=1)
    sine = norm(across)[..., None]
    unit = np.where(sine > 1e-12, across / np.where(sine > 0.0, sine, 1.0), [0.0, 0.0, 1.0])
    return np.asarray(unit * arctan2(sine, axis[:, :1]))


def _looseness(arc: Array, fan: Fan) -> Array:
    """Return the inverse weights of quadratics that fall with the joint travel of arcs. Shape (n, 9)."""
    a, b = np.abs(arc[..., 0]), hypot(arc[..., 1], arc[..., 2])
    here = np.maximum(fan.cost(a, b), _LEAST)
    a = np.maximum(a, np.minimum(_REVIVED * fan.straight * here, _REVIVED_L))
    b = np.maximum(b, np.minimum(_REVIVED * fan.tight * here, _REVIVED_RAD))
    here, more_a, more_b = fan.cost(np.stack([a, 1.01 * a, a]), np.stack([b, b, 1.01 * b]))
    loose_a = a**2 / (here * np.maximum(100.0 * (more_a / here - 1.0), 0.05))
    loose_b = b**2 / (here * np.maximum(100.0 * (more_b / here - 1.0), 0.05))
    return np.stack([loose_a, loose_b, loose_b], axis=-1).reshape(len(arc), 9)


def _swum(arc: Array) -> tuple[Array, Array, Array]:
    """Return the displacements exp(a, 0, 0; 0, p, q) of arcs, and the body twists of changes of a, p and q.

    The exponential's series have only even powers of the turn, so their closed forms (Murray, Li
    and Sastry 1994, A mathematical introduction to robotic manipulation, section 2.3) need no root.

    Args:
        arc: Advance [L] and turns about y and z [rad]. Shape (n, 3).

    Returns:
        Rotations, shape (n, 3, 3), positions, shape (n, 3), and twists, shape (n, 6, 3).
    """
    a, p, q = arc.T
    tt = p * p + q * q
    sine, cosine, rest = exp_coefficients(tt)
    sine_slope = rest - cosine  # (d/dt sin t / t) / t, and the same of (1 - cos t) / t^2
    small = tt < _SMALL_RAD**2
    cosine_slope = np.where(small, tt / 180.0 - 1.0 / 12.0, (sine - 2.0 * cosine) / np.where(small, 1.0, tt))
    zero, one = np.zeros_like(a), np.ones_like(a)
    rotation = np.empty((len(a), 3, 3))
    rotation[:, 0] = np.stack([1.0 - cosine * tt, -sine * q, sine * p], axis=-1)
    rotation[:, 1] = np.stack([sine * q, 1.0 - cosine * q * q, cosine * p * q], axis=-1)
    rotation[:, 2] = np.stack([-sine * p, cosine * p * q, 1.0 - cosine * p * p], axis=-1)
    unit = np.stack([sine, cosine * q, -cosine * p], axis=-1)
    slope = np.empty((len(a), 3, 3))
    slope[:, :, 0] = unit
    for k, (w, across) in enumerate(((p, (zero, zero, -cosine)), (q, (zero, cosine, zero))), 1):
        parts = (sine_slope * w, cosine_slope * w * q + across[1], -cosine_slope * w * p + across[2])
        slope[:, :, k] = a[:, None] * np.stack(parts, axis=-1)
    twist = np.zeros((len(a), 6, 3))
    twist[:, :3] = matmul(np.swapaxes(rotation, 1, 2), slope)
    # The right Jacobian 1 - (1 - cos t) / t^2 hat(w) + (t - sin t) / t^3 hat(w)^2 on the axes y and z.
    twist[:, 3:, 1] = np.stack([cosine * q, one - rest * q * q, rest * p * q], axis=-1)
    twist[:, 3:, 2] = np.stack([-cosine * p, rest * p * q, one - rest * p * p], axis=-1)
    return rotation, a[:, None] * unit, twist


def _equations(x: Array, inverse: Array) -> tuple[Array, Array]:
    """Return log(D^-1 exp .. exp) and its derivative. Shapes (n, 6) and (n, 6, 3 m + 1)."""
    n, m = len(x), x.shape[1] // 3
    moves = _swum(x[:, :-1].reshape(n * m, 3))
    rotation, position, twist = (part.reshape(n, m, *part.shape[1:]) for part in moves)
    jacobian = np.empty((n, 6, 3 * m + 1))
    jacobian[:, :, -1] = _E_ROLL
    turned, moved = about_axis(0, x[:, -1]), np.zeros((n, 3))
    for k in reversed(range(m)):
        back = np.swapaxes(turned, 1, 2)
        speed, spin = twist[:, k, :3], twist[:, k, 3:]
        jacobian[:, :3, 3 * k : 3 * k + 3] = matmul(back, speed - matmul(hat(moved), spin))
        jacobian[:, 3:, 3 * k : 3 * k + 3] = matmul(back, spin)
        moved = (matmul(rotation[:, k], moved[..., None]))[..., 0] + position[:, k]
        turned = matmul(rotation[:, k], turned)
    return se3.log(se3.normalised(matmul(inverse, se3.pose(turned, moved)))), jacobian
