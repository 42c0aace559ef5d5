"""The exact finish: Newton's method on the true flow until the goal is met in all twelve dimensions.

All angles change together, by the least amount. Where rounding to the clock then stands in the way,
since strokes that repeat multiply it, only the angles after the last of those go on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from purcell_cli.planner.equations import Equations, Stretch
from purcell_cli.rotations import Array

_ENOUGH = 4e-12
_PATIENCE = 4
"""Rounds without gain before the best is taken: rounding to the clock falls out anew in each."""
_WEAKEST = 1e-9


def arrive(equations: Equations, rounded: Callable[[Array], Array]) -> tuple[list[Stretch], float]:
    """Return the stretches with their angles changed, by the least amount, to end exactly at the goal.

    Args:
        equations: The equations of a motion that almost arrives.
        rounded: Rounds angles to what the clock can tell [rad].

    Returns:
        The stretches of the best round, and the largest residual left [L, rad].
    """
    angle = rounded(equations.angles())
    best, kept, idle = np.inf, angle, 0
    while idle < _PATIENCE:
        values = equations.at(angle)
        idle = idle + 1 if values.size > 0.5 * best else 0
        if values.size < best:
            best, kept = values.size, angle
        if best < _ENOUGH:
            break
        first = equations.tail() if idle else 0
        step = np.linalg.lstsq(values.derivative[:, first:], -values.residual, rcond=_WEAKEST)[0]
        angle = rounded(np.concatenate([angle[:first], angle[first:] + step]))
    return equations.with_angles(kept), float(best)
