"""A trajectory integrated once more by code that shares nothing with the package: own drag, own integrator, numpy.

Drag is that of Cox, links of equal half length and slenderness, each alone in the fluid.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory

_STEPS_RAD = (0.06, 0.03, 0.015)
"""The longest steps, in the angle that limbs turn by together: each has a 64th of the error of the one before [rad]."""
_NEAR_RAD, _FINER = 0.3, 0.05
"""Limbs that bend by less than this in all make steps shorter, down to this part: there the roll that a limb's turn
makes of the base changes within a few times the slenderness [rad]."""
_GOOD = 5e-10
"""What misses the goal by less than this is not integrated by shorter steps [L, rad]."""
_NODES = 0.5 + math.sqrt(15.0) / 10.0 * np.array([-1.0, 0.0, 1.0])
"""The three Gauss nodes of a step, as parts of it."""
_TERMS = 9
"""Terms of the exponential series, of arguments below a tenth."""


def _hat(v: np.ndarray) -> np.ndarray:
    out = np.zeros((*v.shape[:-1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i, j], out[..., j, i] = -v[..., k], v[..., k]
    return out


def twists(swimmer: Swimmer, shapes: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the base's body twists, by force and torque about the base's middle. Shape (n, 6).

    Args:
        swimmer: The swimmer.
        shapes: Limbs' orientations. Shape (n, 2, 3, 3).
        rates: Limbs' rates in their own frames [rad/s]. Shape (n, 6).
    """
    n, forward = len(shapes), np.array([1.0, 0.0, 0.0])
    resistance, load = np.zeros((n, 6, 6)), np.zeros((n, 6))
    for link, side in ((0, 0.0), (1, 1.0), (2, -1.0)):
        half = swimmer.base_half_length_m if link == 0 else swimmer.limb_half_length_m
        radius = swimmer.slenderness * 2.0 * half
        lateral = 4.0 * math.pi / math.log(2.0 * half / radius)
        turned = np.broadcast_to(np.eye(3), (n, 3, 3)) if link == 0 else shapes[:, link - 1]
        axis = turned @ forward
        joint = side * swimmer.base_half_length_m * forward
        centre = joint + side * half * axis
        along = axis[:, :, None] * axis[:, None, :]
        force = 2.0 * half * lateral * (np.eye(3) - (1.0 - 1.0 / swimmer.drag_ratio) * along)
        torque = 2.0 / 3.0 * lateral * half**3 * (np.eye(3) - along) + 8.0 * math.pi * radius**2 * half * along
        moves = np.concatenate([np.broadcast_to(np.eye(3), (n, 3, 3)), -_hat(centre)], axis=2)  # the centre's velocity
        arm = _hat(centre)
        spins = np.concatenate([np.zeros((n, 3, 3)), np.broadcast_to(np.eye(3), (n, 3, 3))], axis=2)
        up, about = force @ moves, torque @ spins
        resistance += np.concatenate([up, arm @ up + about], axis=1)
        if link:
            rate = (turned @ rates[:, 3 * link - 3 : 3 * link, None])[..., 0]
            pushed = (force @ np.cross(rate, centre - joint)[..., None])[..., 0]
            load += np.concatenate([pushed, np.cross(centre, pushed) + (torque @ rate[..., None])[..., 0]], axis=1)
    return -np.linalg.solve(resistance, load[..., None])[..., 0]


def _bracket(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a @ b - b @ a


def missed(swimmer: Swimmer, rows: Trajectory, wanted: np.ndarray) -> float:
    """Return by how much the rows' controls miss a displacement [L, rad].

    Args:
        swimmer: The swimmer.
        rows: The rows, of which the first row's shape and the controls count.
        wanted: The displacement [m]. Shape (4, 4).
    """
    least = math.inf
    for step in _STEPS_RAD:
        gap = displacement(swimmer, rows, step) - wanted
        away = float(np.linalg.norm(gap[:3, 3])) / swimmer.length_m
        least = min(least, max(away, float(np.linalg.norm(gap[:3, :3])) / math.sqrt(2.0)))
        if least < _GOOD:
            break
    return least


def displacement(swimmer: Swimmer, rows: Trajectory, step_rad: float) -> np.ndarray:
    """Return the base's displacement that the rows' controls make, from the first row's shape [m]. Shape (4, 4).

    A Magnus integrator of sixth order (Blanes, Casas and Ros 2000, BIT 40, 434) takes equal steps within each row.

    Args:
        swimmer: The swimmer.
        rows: The rows.
        step_rad: The longest step, in the angle that limbs turn by together [rad].
    """
    lasts, rates = np.diff(rows.time_s), rows.rate_rad_s[:-1]
    speed = np.sum(np.linalg.norm(rates.reshape(-1, 2, 3), axis=2), axis=1)
    bend = np.sum(np.arccos(np.clip(rows.shape[:-1, :, 0, 0], -1.0, 1.0)), axis=1)
    longest = step_rad * np.clip(np.minimum(bend, np.append(bend[1:], bend[-1])) / _NEAR_RAD, _FINER, 1.0)
    count = np.maximum(np.ceil(speed * lasts / longest), 1).astype(int)
    row = np.repeat(np.arange(len(count)), count)
    first = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    length = (lasts / count)[row]
    shapes = _shapes(rows.shape[0], rates, lasts)
    a = []
    for node in _NODES:
        turns = rates[row].reshape(-1, 2, 3) * ((first + node) * length)[:, None, None]
        there = [shapes[row, k] @ Rotation.from_rotvec(turns[:, k]).as_matrix() for k in (0, 1)]
        twist = twists(swimmer, np.stack(there, axis=1), rates[row]) * length[:, None]
        moving = np.zeros((len(row), 4, 4))
        moving[:, :3, :3], moving[:, :3, 3] = _hat(twist[:, 3:]), twist[:, :3]
        a.append(np.swapaxes(moving, 1, 2))  # g' = g xi is (g^T)' = xi^T g^T
    one, two, three = a[1], math.sqrt(15.0) / 3.0 * (a[2] - a[0]), 10.0 / 3.0 * (a[2] - 2.0 * a[1] + a[0])
    c = _bracket(one, two)
    d = -_bracket(one, 2.0 * three + c) / 60.0
    exponent = one + three / 12.0 + _bracket(-20.0 * one - three + c, two + d) / 240.0
    moves = np.broadcast_to(np.eye(4), exponent.shape)
    for k in range(_TERMS, 0, -1):
        moves = np.eye(4) + exponent @ moves / k
    moves = np.swapaxes(moves, 1, 2)
    while len(moves) > 1:
        if len(moves) % 2:
            moves = np.concatenate([moves, np.eye(4)[None]])
        moves = moves[::2] @ moves[1::2]
    out: np.ndarray = moves[0]
    return out


def _shapes(start: np.ndarray, rates: np.ndarray, lasts: np.ndarray) -> np.ndarray:
    """Return the limbs' orientations at the beginning of each row. Shape (n, 2, 3, 3)."""
    turned = [Rotation.from_rotvec(rates[:, 3 * k : 3 * k + 3] * lasts[:, None]).as_matrix() for k in (0, 1)]
    out = np.empty((len(rates), 2, 3, 3))
    for k in (0, 1):
        now = start[k]
        for i, turn in enumerate(turned[k]):
            out[i, k] = now
            now = now @ turn
    return out
