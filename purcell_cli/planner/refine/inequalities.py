"""The bend limit and the clearance as inequalities on a motion's angles.

The axis of a limb that yaws or pitches describes a great circle. Its bend is largest at an end of the
primitive, or at the far side of the circle if the primitive passes it. So each primitive has one
inequality, at one of the two. Limbs can meet in phases 1 and 3 only (see `clearance.apart_bend_rad`);
there each primitive has another, where the limbs are nearest.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arccos, cos
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import shooting
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.clearance import clearance_slack, limb_distance, straight_distance
from purcell_cli.planner.refine.joint_ranges import ACTIVE_RAD, JointRange, joint_ranges
from purcell_cli.planner.refine.shooting import Equations, MoreRows

ACTIVE = 0.35
"""Primitives within this of the bend limit are constraints, in the cosine of the bend."""
_NEAR_L = 0.25
"""Primitives on which the limbs come within this of their least distance are constraints [L]."""
_BEYOND_RAD = 0.3
"""While a motion is optimised, limbs bend by less than this more than they may [rad]."""
_MARGIN_L = 1e-3
"""How much more than the clearance the limbs are to keep while a motion is optimised [L]."""


def least_cosines(
    phase: NDArray[np.int64], start: Array, goal: Array, max_bend_rad: float, home: Array = COLLINEAR
) -> Array:
    """Return the least cosine of the bend that each limb may have on each piece of a motion. Shape (k, 2).

    The limit holds in phase 2, but for limbs that are bent more at home; in phases 1 and 3 a limb may be as bent as
    the start or the goal has it.

    Args:
        phase: Phase of each piece. Shape (k,).
        start: Shape before the motion. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        max_bend_rad: The limit [rad].
        home: Shape between the phases. Shape (2, 3, 3).
    """
    out = np.full((len(phase), 2), np.minimum(cos(max_bend_rad), home[:, 0, 0]))
    for own, shape in ((1, start), (3, goal)):
        out[phase == own] = np.minimum(out[phase == own], shape[:, 0, 0])
    return out


def bend_rows(equations: Equations, sequence: PrimitiveSequence, shapes: Array, least: Array) -> tuple[Array, Array]:
    """Return the slack of the bend limit where it is small, and its derivative.

    Args:
        equations: The motion.
        sequence: Its primitives.
        shapes: Its shapes. Shape (k + 1, 2, 3, 3).
        least: Least cosine of the bend of each limb on each primitive. Shape (k, 2).

    Returns:
        cos(bend) - least at the ends or far sides of primitives near the limit that may change, shape (j,), and
        its derivative by the free angles, shape (j, n).
    """
    slack, slope = shooting.bend_rows(sequence.control, sequence.angle, shapes, least, equations.fixed, ACTIVE)
    found = slack, equations.by_free_angles(slope)
    if equations.swimmer.ball_joints:
        return found
    ranges = range_rows(equations, sequence)
    return np.concatenate([found[0], ranges[0]]), np.concatenate([found[1], ranges[1]])


def rows_besides(equations: Equations, clearance: float | None) -> tuple[MoreRows | None, int]:
    """Return what gives the inequalities on a motion besides the bend limit, if any, and how many they are at most.

    Args:
        equations: The motion.
        clearance: How far the limbs stay apart in phases 1 and 3 [L]; None where that does not matter.
    """
    count, apart = len(equations.phase), None if clearance is None else least_distances(equations, clearance)
    meeting = apart is not None and bool(np.any(apart > -np.inf)) and not _never_near(equations, float(np.max(apart)))
    ranged = not equations.swimmer.ball_joints

    def rows(sequence: PrimitiveSequence, shapes: Array) -> tuple[Array, Array]:
        parts = []
        if ranged:
            parts.append(range_rows(equations, sequence))
        if meeting and apart is not None:
            parts.append(clearance_rows(equations, sequence, shapes, apart))
        slack, slope = (np.concatenate(part) for part in zip(*parts, strict=True))
        return slack, slope

    return (rows if ranged or meeting else None), 2 * count * ranged + count * meeting


@frozen_dataclass(eq=False)
class _RangeOf:
    """What the inequalities of one joint angle's range share at all angles of a motion.

    Attributes:
        within: The range.
        turns: Which primitives turn it. Shape (k,).
        mine: At the ends of which it may change. Shape (j,).
        slope: Its derivative there by the free angles. Shape (j, n).
    """

    within: JointRange
    turns: NDArray[np.bool_]
    mine: NDArray[np.int64]
    slope: Array


@functools.lru_cache(maxsize=4)
def _ranges(equations: Equations) -> list[_RangeOf]:
    out, sequence = [], equations.sequence
    for one in joint_ranges(equations.swimmer, (equations.start, equations.goal, equations.home)):
        turns = (sequence.limb == one.limb) & (sequence.axis == one.axis)
        mine = np.flatnonzero(turns & (equations.fixed == 0))
        acts = np.where(turns & (np.arange(len(sequence)) <= mine[:, None]), 1.0, 0.0)
        acts[:, equations.fixed != 0] = 0.0
        out.append(_RangeOf(one, turns, mine, equations.by_free_angles(acts)))
    return out


def range_rows(equations: Equations, sequence: PrimitiveSequence) -> tuple[Array, Array]:
    """Return the slack of the joints' ranges where it is small, and its derivative by the free angles.

    Args:
        equations: The motion.
        sequence: Its primitives, at any angles.

    Returns:
        Angles left at the ends of primitives [rad], shape (j,), and its derivative, shape (j, n).
    """
    slacks, slopes = [np.empty(0)], [np.empty((0, len(equations.weight)))]
    for one in _ranges(equations):
        angle = (one.within.known[0] + np.cumsum(np.where(one.turns, sequence.angle, 0.0)))[one.mine]
        for slack, sign in one.within.rooms(angle):
            active = np.flatnonzero(slack < ACTIVE_RAD)
            slacks.append(slack[active])
            slopes.append(sign * one.slope[active])
    return np.concatenate(slacks), np.concatenate(slopes)


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
    """Return the slack of the clearance where it is small, and its derivative.

    Args:
        equations: The motion.
        sequence: Its primitives.
        shapes: Its shapes. Shape (k + 1, 2, 3, 3).
        least: Least distance of the limbs on each primitive [L]. Shape (k,).

    Returns:
        Distance - least where the limbs are nearest on primitives [L], shape (j,), and its derivative
        by the free angles, shape (j, n).
    """
    slack, slope = clearance_slack(equations.swimmer, sequence.control, sequence.angle, shapes, least, _NEAR_L)
    return slack, equations.by_free_angles(slope)


def _never_near(equations: Equations, least: float) -> bool:
    """Return whether limbs as bent as phases 1 and 3 allow are no nearer to each other than their joints, by far."""
    shapes = np.stack([equations.start, equations.goal, equations.home])
    most = max(equations.swimmer.max_bend_rad, float(np.max(arccos(np.clip(shapes[..., 0, 0], -1.0, 1.0)))))
    return most < 0.5 * np.pi - _BEYOND_RAD and straight_distance(equations.swimmer) - least >= _NEAR_L
