"""How far limbs may bend from the base's axis, as inequalities on the angles of a motion.

A limb that yaws or pitches sweeps a great circle, on which its bend is largest at an end unless it
passes the far side of the circle. So the bend is watched at the end of every primitive.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.planner.equations import Stretch
from purcell_cli.rotations import Array

_WATCHED = 0.35
"""How near the limit, in the cosine of the bend, a primitive's end must come to be watched."""


def bend_rows(stretch: Stretch, max_bend_rad: float) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative.

    Args:
        stretch: A part of the motion.
        max_bend_rad: The limit [rad].

    Returns:
        cos(bend) - cos(limit) at the ends of primitives near the limit, shape (k,), and its
        derivative by the angles of the stretch, shape (k, n).
    """
    sequence = stretch.sequence
    n = len(sequence)
    shapes = sequence.shapes(stretch.start)
    limb, axis = sequence.control // 3, sequence.control % 3
    ends = shapes[np.arange(1, n + 1), limb, :, 0]
    room = ends[:, 0] - np.cos(max_bend_rad)
    watched = np.flatnonzero((room < _WATCHED) & (axis != 0))
    about = shapes[np.arange(n), limb, :, axis]
    lever = about[None, :, 1] * ends[watched, None, 2] - about[None, :, 2] * ends[watched, None, 1]
    acts = (limb[None, :] == limb[watched, None]) & (np.arange(n)[None, :] <= watched[:, None])
    return room[watched], np.where(acts, lever, 0.0)
