"""The bend limit, the ranges of joints and the clearance as inequalities on a motion's free angles.

The axis of a limb that turns at a constant rate describes a circle. Its bend is largest at an end of the
piece, or at the far side of the circle if the piece passes it. So each piece has one
inequality, at one of the two. By primitives, limbs can meet in phases 1 and 3 only (see `clearance.apart_bend_rad`);
there each primitive has another, where the limbs are nearest. Moves have one wherever limbs come near each other.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arccos, cos, matmul
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.kernel import moves, shooting
from purcell_cli.kernel.clearance import Apart
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_turns import by_turns, rotation_vectors
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import (
    clearance_slack,
    clearances,
    distance_slope,
    limb_distance,
    limits_apart,
    straight_distance,
)
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.refine.joint_ranges import ACTIVE_RAD, JointRange, joint_ranges
from purcell_cli.planner.refine.segments import AT_ONCE
from purcell_cli.planner.refine.shooting import Equations, MoreRows, Values

ACTIVE = 0.35
"""Primitives within this of the bend limit are constraints, in the cosine of the bend."""
_NEAR_L = 0.25
"""Primitives on which the limbs come within this of their least distance are constraints [L]."""
_BEYOND_RAD = 0.3
"""While a motion is optimised, limbs bend by less than this more than they may [rad]."""
_MARGIN_L = 1e-3
"""How much more than the clearance the limbs are to keep while a motion is optimised [L]."""
_MOVES_ACTIVE = 0.5
"""Moves within this of the bend limit are constraints, as a part of it; both as 1 - cos of the bend."""
_MOVES_NEAR_L = 0.1
"""Moves on which limbs are nearer to each other than so much more than they must be are constraints [L]."""


@frozen_dataclass(eq=False)
class Linearised:
    """A motion's equations and inequalities at some free angles, with their derivatives.

    Attributes:
        values: The equations.
        slack: What is left below the bend limit where it is little, in the cosine of the bend, in the ranges of
            joints [rad], and, on moves, of the limbs' distance [L]. Shape (j,).
        slope: Its derivative by the free angles. Shape (j, n).
    """

    values: Values
    slack: Array
    slope: Array


def linearised(equations: Equations, values: Values, max_bend_rad: float) -> Linearised:
    """Return a motion's equations with its inequalities.

    Args:
        equations: The motion.
        values: Its equations at some free angles.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
    """
    least = bend_limits(equations, max_bend_rad)
    return Linearised(values, *limit_rows(equations, values, least))


def bend_limits(equations: Equations, max_bend_rad: float) -> Array:
    """Return the least cosine of the bend that each limb may have on each piece; see `least_cosines`. Shape (k, 2)."""
    return least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad, equations.home)


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
        if np.any(mine := phase == own):
            out[mine] = np.minimum(out[mine], shape[:, 0, 0])
    return out


def limit_rows(equations: Equations, values: Values, least: Array) -> tuple[Array, Array]:
    """Return the slack of the bend limit, of joints' ranges, and of the distance on moves, where it is small.

    Args:
        equations: The motion.
        values: Its equations.
        least: Least cosine of the bend of each limb on each piece. Shape (k, 2).

    Returns:
        cos(bend) - least at the ends or far sides of pieces near the limit that may change, and the other slacks,
        shape (j,), and their derivative by the free angles, shape (j, n).
    """
    sequence = values.sequence
    if values.moved is None:
        slack, slope = shooting.bend_rows(
            sequence.control, sequence.angle, values.shapes, least, equations.fixed, ACTIVE
        )
    else:
        slack, slope = _rows_of_moves(equations, values.moved, values.turn, least)
    found = slack, equations.by_free_angles(slope)
    if equations.swimmer.ball_joints:
        return found
    ranges = range_rows(equations, sequence)
    return np.concatenate([found[0], ranges[0]]), np.concatenate([found[1], ranges[1]])


def _rows_of_moves(equations: Equations, moved: moves.MoveEquations, turn: Array, least: Array) -> tuple[Array, Array]:
    """Return the slack of the bend limit, and of the limbs' distance, on moves, and its derivative by all turns."""
    swimmer = equations.swimmer
    slack, slope = moves.bends(moved, least, float(_MOVES_ACTIVE * (1.0 - cos(swimmer.max_bend_rad))))
    if equations.apart is not None:
        vectors = rotation_vectors(swimmer, equations.start, turn)
        gaps, gaps_slope = distance_rows(swimmer, moved, vectors, equations.apart)
        slack, slope = np.concatenate([slack, gaps]), np.concatenate([slope, gaps_slope])
    return slack, by_turns(swimmer, equations.start, turn, slope)


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
    least, time = clearances(swimmer, pieces, apart + _MOVES_NEAR_L)
    near = np.flatnonzero(least < apart + _MOVES_NEAR_L)
    axes = LimbCircles.of(pieces).at(near, time[near])
    torque = cross(axes, distance_slope(swimmer, axes))
    path = found.turned[6 * n :].reshape(n, 2, 3, 3)
    levers = matmul(torque[:, None, :, None, :], path[None])[..., 0, :]
    part = np.where(pieces.durations[near] > 0.0, time[near] / np.maximum(pieces.durations[near], 1e-300), 0.0)
    acts = np.clip(near[:, None] - np.arange(n) + part[:, None], 0.0, 1.0)
    return least[near] - apart, (acts[..., None, None] * levers).reshape(len(near), AT_ONCE * n)


def rows_besides(equations: Equations, clearance: float | None) -> tuple[MoreRows | None, Apart | None]:
    """Return the inequalities on a motion besides the bend limit: what gives those of ranges, and limbs' distances.

    Args:
        equations: The motion.
        clearance: How far the limbs stay apart in phases 1 and 3 [L]; None where that does not matter.
    """
    apart = None if clearance is None else least_distances(equations, clearance)
    meeting = apart is not None and bool(np.any(apart > -np.inf)) and not _never_near(equations, float(np.max(apart)))
    return (
        None if equations.swimmer.ball_joints else functools.partial(range_rows, equations),
        limits_apart(equations.swimmer, apart, _NEAR_L) if meeting and apart is not None else None,
    )


@frozen_dataclass(eq=False)
class _RangeOf:
    """What the inequalities of one joint angle's range share at all angles of a motion.

    Attributes:
        within: The range.
        turns: Which of the motion's angles change it. Shape (c,).
        mine: After which of those it is looked at. Shape (j,).
        slope: Its derivative there by the free angles. Shape (j, n).
    """

    within: JointRange
    turns: NDArray[np.int64]
    mine: NDArray[np.int64]
    slope: Array


@functools.lru_cache(maxsize=4)
def _ranges(equations: Equations) -> list[_RangeOf]:
    out, sequence = [], equations.sequence
    still = np.zeros(len(sequence), dtype=bool) if equations.by_moves else equations.fixed != 0
    for one in joint_ranges(equations.swimmer, (equations.start, equations.goal, equations.home)):
        turns = np.flatnonzero((sequence.limb == one.limb) & (sequence.axis == one.axis))
        mine = np.flatnonzero(~still[turns])
        acts = np.zeros((len(mine), len(sequence)))
        acts[:, turns] = np.arange(len(turns)) <= mine[:, None]
        acts[:, still] = 0.0
        out.append(_RangeOf(one, turns, mine, equations.by_free_angles(acts)))
    return out


def range_rows(equations: Equations, sequence: PrimitiveSequence) -> tuple[Array, Array]:
    """Return the slack of the joints' ranges where it is small, and its derivative by the free angles.

    Args:
        equations: The motion; one cycle of a loop that repeats brings its angles back.
        sequence: Its controls, at any angles.

    Returns:
        Angles left at the ends of pieces [rad], shape (j,), and its derivative, shape (j, n).
    """
    slacks, slopes = [np.empty(0)], [np.empty((0, len(equations.weight)))]
    for one in _ranges(equations):
        angle = (one.within.known[0] + np.cumsum(sequence.angle[one.turns]))[one.mine]
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
        if np.any(mine := equations.phase == own):
            out[mine] = min(clearance + _MARGIN_L, float(limb_distance(equations.swimmer, shape[..., 0])))
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
