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

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arctan2, matmul, norm, normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.steering import steered
from purcell_cli.planner.arcs.loop_family import Fan

_ARCS = 3
"""Arcs of each solution; the least cost leaves some of them empty."""
_ARRIVED = 1e-3
"""Ways that miss by more than this are left out: chains of loops settle the rest [L, rad]."""
_WAYS = (1.0, -1.0)
"""Directions, forwards and backwards, of the straight ways among the starts."""
_ACROSS = (1, 4, 7, 9)
"""The unknowns that lead out of the x-y plane: turns about y, and the roll."""
_STRAY_RAD = 1e-6
"""Ways in a plane that turn out of it by less than this do so by rounding [rad]."""
_SIDEWAYS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The frame whose axes are x, -z and y."""


@frozen_dataclass(eq=False)
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
    bearing, size = fan.reach
    x, off = steered(fan.straight, fan.tight, bearing, size, inverse, begun.reshape(n, 10))
    good = np.flatnonzero(off < _ARRIVED)
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
