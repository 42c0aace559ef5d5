"""How far limbs may bend from the base's axis, as inequalities on the angles of a motion.

A limb that yaws or pitches sweeps a great circle, on which its bend is largest at an end unless it
passes the far side of the circle. So the bend is watched at the end of every primitive.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.planner.equations import Equations
from purcell_cli.rotations import Array

_WATCHED = 0.35
"""How near the limit, in the cosine of the bend, a primitive's end must come to be watched."""


def least_cosines(phase: NDArray[np.int64], start: Array, goal: Array, max_bend_rad: float) -> Array:
    """Return the least cosine of the bend that each limb may have on each piece of a motion. Shape (k, 2).

    The limit holds in phase 2; in phases 1 and 3 a limb may be as bent as the start or the goal has it.

    Args:
        phase: Phase of each piece. Shape (k,).
        start: Shape before the motion. Shape (2, 3, 3).
        goal: Shape it must end at. Shape (2, 3, 3).
        max_bend_rad: The limit [rad].
    """
    out = np.full((len(phase), 2), np.cos(max_bend_rad))
    for own, shape in ((1, start), (3, goal)):
        out[phase == own] = np.minimum(out[phase == own], shape[:, 0, 0])
    return out


def bend_rows(equations: Equations, shapes: Array, least: Array) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative.

    Args:
        equations: The motion.
        shapes: Its shapes. Shape (k + 1, 2, 3, 3).
        least: Least cosine of the bend of each limb on each primitive. Shape (k, 2).

    Returns:
        cos(bend) - least at the ends of primitives near the limit, shape (j,), and its derivative
        by the free angles, shape (j, n).
    """
    control = equations.sequence.control
    n = len(control)
    limb, axis = control // 3, control % 3
    ends = shapes[np.arange(1, n + 1), limb, :, 0]
    room = ends[:, 0] - least[np.arange(n), limb]
    watched = np.flatnonzero((room < _WATCHED) & (axis != 0))
    about = shapes[np.arange(n), limb, :, axis]
    lever = about[None, :, 1] * ends[watched, None, 2] - about[None, :, 2] * ends[watched, None, 1]
    acts = (limb[None, :] == limb[watched, None]) & (np.arange(n)[None, :] <= watched[:, None])
    return room[watched], equations.by_free_angles(np.where(acts, lever, 0.0))
