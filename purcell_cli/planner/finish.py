"""The exact finish: Newton's method on the true flow until the goal is met in all twelve dimensions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from purcell_cli.planner.equations import Equations, Stretch
from purcell_cli.rotations import Array

_ENOUGH = 1e-12
_ROUNDS = 12
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
    best, kept = np.inf, angle
    for _ in range(_ROUNDS):
        values = equations.at(angle)
        gain = values.size / best
        if gain < 1.0:
            best, kept = values.size, angle
        if best < _ENOUGH or gain > 0.5:
            break
        step = np.linalg.lstsq(values.derivative, -values.residual, rcond=_WEAKEST)[0]
        angle = rounded(angle + step)
    return equations.with_angles(kept), float(best)
