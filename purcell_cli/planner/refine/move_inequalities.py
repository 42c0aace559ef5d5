"""Inequalities on a motion by moves besides the bend limit: the limbs' distance, and the ranges of joints."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.kernel import moves
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import clearances, distance_slope
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.refine.joint_ranges import ACTIVE_RAD, joint_ranges

_ACTIVE_L = 0.1
"""Limbs nearer to each other than so much more than they must are constraints [L]."""


def distance_rows(swimmer: Swimmer, found: moves.MoveEquations, vectors: Array, apart: float) -> tuple[Array, Array]:
    """Return by how much more the limbs are apart than they must be where that is little, and about its derivative.

    Where limbs cross there is no way out, but a step that makes them cross costs more than it gains.

    Args:
        swimmer: The swimmer, scaled.
        found: The moves.
        vectors: Their rotation vectors [rad]. Shape (n, 6).
        apart: How far apart the limbs must be [L].

    Returns:
        Distances left where the limbs are nearest on a move [L], shape (k,), and their derivative by the rotation
        vectors, shape (k, 6 n).
    """
    n = len(vectors)
    pieces = Pieces.between(MoveSequence.of_turns(vectors), found.shapes)
    least, time = clearances(swimmer, pieces, apart + _ACTIVE_L)
    near = np.flatnonzero(least < apart + _ACTIVE_L)
    axes = LimbCircles.of(pieces).at(near, time[near])
    torque = cross(axes, distance_slope(swimmer, axes))
    path = found.turned[6 * n :].reshape(n, 2, 3, 3)
    levers = matmul(torque[:, None, :, None, :], path[None])[..., 0, :]
    part = np.where(pieces.durations[near] > 0.0, time[near] / np.maximum(pieces.durations[near], 1e-300), 0.0)
    acts = np.clip(near[:, None] - np.arange(n) + part[:, None], 0.0, 1.0)
    return least[near] - apart, (acts[..., None, None] * levers).reshape(len(near), 6 * n)


def range_rows(swimmer: Swimmer, known: Array, turn: Array) -> tuple[Array, Array]:
    """Return the room left in the ranges of joints where it is small, and its derivative by all turns.

    Args:
        swimmer: The swimmer.
        known: The shapes at the start and the goal and between the phases. Shape (3, 2, 3, 3).
        turn: Turns of joints; one cycle of a loop that repeats brings them back [rad]. Shape (n, 6).

    Returns:
        Angles left at the ends of moves [rad], shape (k,), and their derivative, shape (k, 6 n).
    """
    n = len(turn)
    slacks, slopes = [np.empty(0)], [np.empty((0, 6 * n))]
    for one in joint_ranges(swimmer, (known[0], known[1], known[2])):
        column = 3 * one.limb + one.axis
        for slack, sign in one.rooms(one.known[0] + np.cumsum(turn[:, column])):
            active = np.flatnonzero(slack < ACTIVE_RAD)
            acts = np.zeros((len(active), n, 6))
            acts[:, :, column] = np.where(np.arange(n) <= active[:, None], sign, 0.0)
            slacks.append(slack[active])
            slopes.append(acts.reshape(-1, 6 * n))
    return np.concatenate(slacks), np.concatenate(slopes)
