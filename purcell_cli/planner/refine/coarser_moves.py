"""Fewer moves for the same motion: neighbours become one where the base hardly moves otherwise.

One move in place of two turns the limbs as they did. The base moves otherwise by about the area that both span in the
space of the joints' angles; parallel ones span none.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner, matmul
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.planner.refine.shooting import Equations

_AREA_RAD2 = 0.03
"""Neighbours that span less become one [rad^2], tried on twenty plans; what the base misses a few Newton steps mend."""
_SHARE = 5e-4
"""The most that they span in short motions, as a part of the square of the time that they take at 1 rad/s."""
_LONGEST_RAD = 0.5
"""One that turns no joint further than this [rad]."""
_SHARES = 1.0, 0.1
"""Parts of that area that are tried."""
_MENDED = 3.0
"""A residual that Newton steps mend, over the largest area [L/rad^2, rad/rad^2]."""


def coarser(motion: Equations) -> Equations:
    """Return the motion with fewer moves, where it is played once, or as it is; limbs end as they did."""
    most = min(_AREA_RAD2, _SHARE * motion.duration**2)
    for area in (share * most for share in _SHARES):
        fewer = [s.with_turns(_fewer(s.turn, area)) if s.loose else s for s in motion.segments]
        made = motion.of(fewer)
        if made.at(made.angles).size < _MENDED * most:
            return made
    return motion


def _fewer(turn: Array, area: float) -> Array:
    """Return turns, neighbours that span less than an area [rad^2] made one. Shape (n, 6) to (m, 6)."""
    out = list(turn[:1])
    for own in turn[1:]:
        last = out[-1]
        square, other, along = inner(np.array([last, own, last]), np.array([last, own, own]))
        if square * other - along * along <= area * area:
            both = as_vector(matmul(se3.rotation(last.reshape(2, 3)), se3.rotation(own.reshape(2, 3)))).ravel()
            if np.max(np.abs(both)) <= _LONGEST_RAD:
                out[-1] = both
                continue
        out.append(own)
    return np.array(out)
