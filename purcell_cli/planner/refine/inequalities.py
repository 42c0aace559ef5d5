"""The bend limit and the clearance as inequalities on a motion's angles.

The axis of a limb that yaws or pitches describes a great circle. Its bend is largest at an end of the
primitive, or at the far side of the circle if the primitive passes it. So each primitive has one
inequality, at one of the two. Limbs can meet in phases 1 and 3 only (see `clearance.apart_bend_rad`);
there each primitive has another, where the limbs are nearest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.reproducible import cos, inner, sin
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.clearance import clearances, distance_slope, limb_distance
from purcell_cli.motion.limb_circles import LimbCircles, lowest
from purcell_cli.planner.refine.shooting import Equations

_ACTIVE = 0.35
"""Primitives within this of the bend limit are constraints, in the cosine of the bend."""
_NEAR_L = 0.25
"""Primitives on which the limbs come within this of their least distance are constraints [L]."""
_MARGIN_L = 1e-3
"""How much more than the clearance the limbs are to keep while a motion is optimised [L]."""


def least_cosines(phase: NDArray[np.int64], start: Array, goal: Array, max_bend_rad: float) -> Array:
    """Return the least cosine of the bend that each limb may have on each piece of a motion. Shape (k, 2).

    The limit holds in phase 2; in phases 1 and 3 a limb may be as bent as the start or the goal has it.

    Args:
        phase: Phase of each piece. Shape (k,).
        start: Shape before the motion. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        max_bend_rad: The limit [rad].
    """
    out = np.full((len(phase), 2), cos(max_bend_rad))
    for own, shape in ((1, start), (3, goal)):
        out[phase == own] = np.minimum(out[phase == own], shape[:, 0, 0])
    return out


def bend_rows(equations: Equations, sequence: PrimitiveSequence, shapes: Array, least: Array) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative.

    Args:
        equations: The motion.
        sequence: Its primitives.
        shapes: Its shapes. Shape (k + 1, 2, 3, 3).
        least: Least cosine of the bend of each limb on each primitive. Shape (k, 2).

    Returns:
        cos(bend) - least at the ends or far sides of primitives near the limit that may change, shape (j,), and
        its derivative by the free angles, shape (j, n).
    """
    row, limb, axis = np.arange(len(sequence)), sequence.control // 3, sequence.control % 3
    begin, place = shapes[row, limb, :, 0], shapes[row + 1, limb, :, 0].copy()
    about = shapes[row, limb, :, axis]
    across = np.where(sequence.angle < 0.0, -1.0, 1.0)[:, None] * cross(about, begin)
    far = lowest(begin[:, 0], across[:, 0])
    # A primitive passes the far side if its rotation reaches it before the end.
    passed = (far < sequence.duration) & (axis != 0)
    place[passed] = (cos(far)[:, None] * begin + sin(far)[:, None] * across)[passed]
    room = place[:, 0] - least[row, limb]
    active = np.flatnonzero((room < _ACTIVE) & (axis != 0) & ~equations.fixed)
    lever = about[None, :, 1] * place[active, None, 2] - about[None, :, 2] * place[active, None, 1]
    acts = (limb[None, :] == limb[active, None]) & (row[None, :] <= (row - passed)[active, None])
    return room[active], equations.by_free_angles(np.where(acts, lever, 0.0))


def least_distances(equations: Equations, clearance: float) -> Array:
    """Return how near the limbs may come on each piece of a motion; anyhow in phase 2. Shape (k,).

    Args:
        equations: The motion.
        clearance: How near they may come, but for a start or goal where they are nearer [L].
    """
    out = np.full(len(equations.phase), -np.inf)
    for own, shape in ((1, equations.start), (3, equations.goal)):
        known = float(limb_distance(equations.swimmer, shape[..., 0]))
        out[equations.phase == own] = min(clearance + _MARGIN_L, known)
    return out


def clearance_rows(
    equations: Equations, sequence: PrimitiveSequence, shapes: Array, least: Array
) -> tuple[Array, Array]:
    """Return the room left between the limbs where it is small, and its derivative.

    Args:
        equations: The motion.
        sequence: Its primitives.
        shapes: Its shapes. Shape (k + 1, 2, 3, 3).
        least: Least distance of the limbs on each primitive [L]. Shape (k,).

    Returns:
        Distance - least where the limbs are nearest on primitives [L], shape (j,), and its derivative
        by the free angles, shape (j, n).
    """
    row, limb, axis = np.arange(len(sequence)), sequence.control // 3, sequence.control % 3
    active = np.flatnonzero(least > -np.inf)
    if not len(active):
        return np.zeros(0), np.zeros((0, len(equations.weight)))
    pieces = Pieces.between(sequence, shapes)[active]
    enough = float(np.max(least, initial=0.0)) + _NEAR_L
    apart, time = clearances(equations.swimmer, pieces, enough)
    near = np.flatnonzero(apart - least[active] < _NEAR_L)
    at_end = time[near] >= pieces.durations[near]
    axes = LimbCircles.of(pieces).at(near, time[near])
    torque = cross(axes, distance_slope(equations.swimmer, axes))
    lever = inner(shapes[row, limb, :, axis], torque[:, limb])
    acts = row[None, :] < (active[near] + at_end)[:, None]
    return (apart - least[active])[near], equations.by_free_angles(np.where(acts, lever, 0.0))
