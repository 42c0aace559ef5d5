"""Motions that arrive but bend a limb too far by little: changed so that they do neither."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.limits import LimitsReport
from purcell_cli.planner.refine.active_set import bounded_step
from purcell_cli.planner.refine.clock_rounding import one_by_one
from purcell_cli.planner.refine.exact_arrival import ENOUGH_LAST, LAST_MARGIN_RAD, REACH_RAD
from purcell_cli.planner.refine.inequalities import bend_limits, limit_rows
from purcell_cli.planner.refine.shooting import Equations

_INSIDE = 1e-10
"""How far inside its limit a bend is brought that was a little beyond, in its cosine."""
_LEAST_SINE = 1e-3
"""Bends whose sine is below this count as if it were this, where rows are put in terms of bends."""
_SLIGHT, _SHARPLY = 1e-4, (False, False, True, True)
"""Bends beyond their limit by less than this [rad] are mended by one more step at a time; the last of them count by the
angle, the first by its cosine."""


def within_bends(
    motion: Equations,
    off: float,
    judged: Callable[[Equations], LimitsReport],
    max_bend_rad: float,
    rounded: Callable[[Array], Array] | None = None,
) -> tuple[Equations, float, LimitsReport]:
    """Return a motion that arrives, changed to bend no limb too far if it does so by little and breaks no other limit.

    Args:
        motion: The motion.
        off: The largest residual left [L, rad].
        judged: Judges a motion.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        rounded: Rounds angles to what the clock can tell [rad]; None where they need no rounding.

    Returns:
        The motion, the largest residual left [L, rad], and how near it comes to its limits.
    """
    report = judged(motion)
    for sharply in _SHARPLY:
        slight = (
            all(v.limit == "bend" for v in report.violations) and sum(v.excess for v in report.violations) < _SLIGHT
        )
        if report.kept or not slight:
            break
        motion, off = bent_less(motion, max_bend_rad, rounded, sharply)
        report = judged(motion)
    return motion, off, report


def bent_less(
    equations: Equations, max_bend_rad: float, rounded: Callable[[Array], Array] | None = None, sharply: bool = False
) -> tuple[Equations, float]:
    """Return a motion that arrives, but bends a limb a little too far, with its angles changed to do neither.

    Args:
        equations: The equations of the motion, its angles on the clock.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        rounded: Rounds angles to what the clock can tell [rad]; None where they need no rounding.
        sharply: Whether an excess counts by its angle. Its cosine hardly tells one of a limb that is almost straight or
            folded.

    Returns:
        The motion, and the largest residual left [L, rad].
    """
    values = equations.at(equations.angles)
    least = bend_limits(equations, max_bend_rad - LAST_MARGIN_RAD)
    slack, slope = limit_rows(equations, values, least + _INSIDE)
    if sharply:
        sine = np.sqrt(np.maximum(1.0 - least * least, 0.0))
        per_bend = 1.0 / float(np.min(sine[sine > _LEAST_SINE], initial=1.0))
        slack, slope = per_bend * slack, per_bend * slope
    step = bounded_step(values.derivative, values.residual, slack, slope, REACH_RAD)
    angle = equations.angles + step if rounded is None else rounded(equations.angles + step)
    missing = equations.residual(angle)
    if rounded is not None and np.any(np.abs(missing) > ENOUGH_LAST):
        angle, missing = one_by_one(equations, angle, missing, values.derivative, rounded)
    return equations.of(equations.with_angles(angle)), float(np.max(np.abs(missing)))
