"""The reference of `purcell_clearance_rooms` and their slopes: the same in numpy, all primitives at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.reproducible import arccos, inner
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.mechanics.lift_derivatives import turning_axes
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import clearances, distance_slope, straight_distance
from purcell_cli.motion.limb_circles import LimbCircles


def clearance_slack(
    swimmer: Swimmer, sequence: PrimitiveSequence, shapes: Array, least: Array, near_m: float
) -> tuple[Array, Array]:
    """Return what the limbs' distance exceeds the least by where that is little, and its derivative by all angles."""
    return numbered_clearance_slack(swimmer, sequence, shapes, least, near_m)[1:]


def numbered_clearance_slack(
    swimmer: Swimmer, sequence: PrimitiveSequence, shapes: Array, least: Array, near_m: float
) -> tuple[NDArray[np.int64], Array, Array]:
    """Return on which primitives that is little, it, and its derivative by all angles."""
    row, limb = np.arange(len(sequence)), sequence.limb
    active = np.flatnonzero(least > -np.inf)
    if len(active):
        active = active[~_far_apart(swimmer, sequence, shapes, active, float(np.max(least[active])), near_m)]
    if not len(active):
        return active, np.zeros(0), np.zeros((0, len(sequence)))
    pieces = Pieces.between(sequence, shapes)[active]
    apart, time = clearances(swimmer, pieces, float(np.max(least)) + near_m)
    near = np.flatnonzero(apart - least[active] < near_m)
    at_end = time[near] >= pieces.durations[near]
    axes = LimbCircles.of(pieces).at(near, time[near])
    torque = cross(axes, distance_slope(swimmer, axes))
    lever = inner(turning_axes(sequence, shapes, row), torque[:, limb])
    based = sequence.control >= 6
    if np.any(based):  # universal joints' pitches turn limbs about their own y, where they are
        pitched = np.flatnonzero(~based & np.isin(limb, limb[based]))
        own_y = shapes[active[near] + at_end][..., 1][:, limb[pitched]]
        lever[:, pitched] = inner(own_y, torque[:, limb[pitched]])
    acts = row[None, :] < (active[near] + at_end)[:, None]
    return active[near], (apart - least[active])[near], np.where(acts, lever, 0.0)


def _far_apart(
    swimmer: Swimmer, sequence: PrimitiveSequence, shapes: Array, some: NDArray[np.int64], least: float, near_m: float
) -> NDArray[np.bool_]:
    bend = arccos(np.clip(shapes[..., 0, 0], -1.0, 1.0))
    most = 0.5 * (bend[some] + bend[some + 1] + np.abs(sequence.angle[some])[:, None])
    return np.asarray((np.max(most, axis=1) < 0.5 * np.pi) & (straight_distance(swimmer) - least >= near_m))
