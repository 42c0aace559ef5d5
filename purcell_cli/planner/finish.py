"""The exact finish: Newton's method on the true flow until the goal is met in all twelve dimensions.

All angles change together, by the least amount that keeps the bend limit. Where rounding to the
clock then stands in the way, since strokes that repeat multiply it, only the angles after the last
of those go on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from purcell_cli.planner.equations import Equations, Values
from purcell_cli.planner.limits import bend_rows, least_cosines
from purcell_cli.planner.steps import bounded_step
from purcell_cli.rotations import Array

_ENOUGH = 4e-12
_PATIENCE = 4
"""Rounds without gain before the best is taken: rounding to the clock falls out anew in each."""
_WEAKEST = 1e-9
_REACH_RAD = 0.25
_ROUNDS = 20
_SHORTER = (1.0, 0.4, 0.15, 0.05)
"""What is tried of a step until it gains something."""


def approach(equations: Equations, max_bend_rad: float, close: float) -> tuple[Equations, Values, float]:
    """Return the motion with its angles changed to arrive, by short steps within the bend limit.

    Args:
        equations: The equations of a motion that almost arrives.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        close: Residual that is close enough [L, rad].

    Returns:
        The motion, its equations' values, and the largest residual left [L, rad].
    """
    least = least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad)
    angle = equations.angles
    values = equations.at(angle)
    best, kept, known = np.inf, angle, values
    for _ in range(_ROUNDS):
        room, _ = bend_rows(equations, values.shapes, least)
        off = max(values.size, float(-np.min(room, initial=0.0)))
        if off < best:
            best, kept, known = off, angle, values
        if best < close:
            break
        step = _bounded(equations, values, least)
        for shorter in _SHORTER:
            there = equations.at(angle + shorter * step)
            if there.size < values.size:
                break
        angle, values = angle + shorter * step, there
    return equations.of(equations.with_angles(kept)), known, float(best)


def _bounded(equations: Equations, values: Values, least: Array, first: int = 0) -> Array:
    """Return the least step to the arrival, from some free angle on, that leaves no limb bent too far. Shape (n,)."""
    room, slope = bend_rows(equations, values.shapes, least)
    step = np.zeros(values.derivative.shape[1])
    arrival = values.derivative[:, first:]
    step[first:] = bounded_step(arrival, values.residual, room, slope[:, first:], _REACH_RAD, _least)
    return step


def _least(rows: Array, wanted: Array) -> Array:
    """Return the least solution of few equations in many unknowns. Shape (n,)."""
    return np.asarray(np.linalg.lstsq(rows, wanted, rcond=_WEAKEST)[0])


def arrive(
    equations: Equations, rough: Values, max_bend_rad: float, rounded: Callable[[Array], Array]
) -> tuple[Equations, float]:
    """Return the motion with its angles changed, by the least amount, to end exactly at the goal.

    A rough derivative will do: what is missing is small, and shrinks by the derivative's own
    accuracy in each round.

    Args:
        equations: The equations of a motion that almost arrives.
        rough: The equations' values, at a rough accuracy.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        rounded: Rounds angles to what the clock can tell [rad].

    Returns:
        The motion of the best round, and the largest residual left [L, rad].
    """
    least = least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad)
    angle, first, idle = rounded(equations.angles), 0, 0
    missing = equations.residual(angle)
    best, kept, left = float(np.max(np.abs(missing))), angle, missing
    while idle < _PATIENCE and best > _ENOUGH:
        step = _bounded(equations, Values(missing, rough.derivative, rough.shapes), least, first)
        angle = rounded(angle + step)
        missing = equations.residual(angle)
        size = float(np.max(np.abs(missing)))
        idle = idle + 1 if size > 0.5 * best else 0
        if size < best:
            best, kept, left = size, angle, missing
        elif not first:
            first, angle, missing = equations.tail, kept, left
    return equations.of(equations.with_angles(kept)), best
