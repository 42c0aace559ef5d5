"""Exact arrival: Newton's method on the exact flow until the goal is met in all twelve dimensions.

All angles change together, by the least amount that keeps the bend limit. Durations of primitives are rounded to the
clock, and repeated strokes and long distances multiply those rounding errors. Where they prevent the
arrival, a few small rotations after the last repeated stroke remove the residual. Moves keep their angles on the clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import EXACT, SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.active_set import bounded_step
from purcell_cli.planner.refine.clock_rounding import one_by_one
from purcell_cli.planner.refine.inequalities import (
    ACTIVE,
    Linearised,
    bend_limits,
    limit_rows,
    linearised,
    rows_besides,
)
from purcell_cli.planner.refine.minimum_travel import offered
from purcell_cli.planner.refine.shooting import Equations, Values

CLOSE = 3e-4
"""A motion that misses the goal by less than this is close enough for `arrive` [L, rad]."""
MARGIN_RAD = 1e-5
"""Margin below the bend limit that is kept until `arrive` [rad]."""
_ENOUGH = 2e-11
"""Newton's method ends when no residual is larger than this [L, rad]."""
_ENOUGH_UNROUNDED = 4e-12
"""The same where angles are not rounded [L, rad]."""
ENOUGH_LAST = 5e-11
"""The same after the last rotations, in which roll strokes multiply rounding errors [L, rad]."""
_DEPENDENT = 1e-9
"""Columns whose independent part is below this part of the largest column are dependent on the others."""
_TIGHT = 1e-3
"""Bend limits with less slack than this, in the cosine of the bend, have a say in which last angles may change."""
_MARGIN_RAD = 3e-6
"""Margin below the bend limit for second-order errors [rad]."""
LAST_MARGIN_RAD = 1e-6
"""The same of the last rotations, which would have no room with the first [rad]."""
_PATIENCE = 2
"""Rounds without a halved residual before the best is taken; rounding to the clock differs in each."""
REACH_RAD = 0.25
"""The largest change of an angle in one Newton step [rad]."""
_TELLING_RAD = 1e-8
"""Steps shorter than this do not update the derivative: their changes are rounding errors [rad]."""
_PLAIN = 2e-6
"""Above this, residuals at the rough accuracy are right to a few per cent and need no exact flow [L, rad]."""
_NEAR_LIMIT = 0.1
"""Limits with less slack than this bound a Newton step from the first, as a part of the most there is."""
_SPOILT = 30.0
"""Residual at which the last rotations take over, in units of what rounding to the clock adds to the residual."""
_NEVER = 1000
"""More steps, and parts of steps, than `approach` takes."""


class Patience(NamedTuple):
    """How Newton's method goes to a goal, and when it gives up.

    Attributes:
        reach_rad: The largest change of an angle in a step [rad].
        rounds: Rounds in which the residual does not even halve before it is given up.
        stuck: Steps in a row of which the smallest part or none helps before it is given up.
        trials: Evaluations after which it is given up if more than `hopeless` is still missing.
        hopeless: What may be missing at the beginning, or it is given up [L, rad].
        most_tried: Evaluations, whole steps but the first left out, after which it is given up.
        nearly: Where less is missing, a step is taken too if the next one would be half as long [L, rad].
    """

    reach_rad: float = REACH_RAD
    rounds: int = 2
    stuck: int = _NEVER
    trials: int = 0
    hopeless: float = math.inf
    most_tried: int = _NEVER
    nearly: float = 5e-2


NEAR = Patience()
"""For motions that nearly arrive."""
FROM_FAR = Patience(0.6, rounds=14, stuck=2, trials=10, hopeless=5.0)
"""For motions that begin far from their goal: those that arrive do so soon."""
BY_WHOLE_STEPS = Patience(0.3, rounds=8, stuck=2, trials=10, hopeless=5.0, most_tried=3, nearly=5.0)
"""For motions of many angles that begin far from their goal: those that arrive do so by whole steps, but for a few."""


def approach(
    equations: Equations,
    max_bend_rad: float,
    patience: Patience = NEAR,
    enough: float = CLOSE,
) -> tuple[Equations, Values, float]:
    """Return the motion with its angles changed to arrive, by short steps within the bend limit.

    Args:
        equations: The equations of a motion that almost arrives.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        patience: How it goes, and when it gives up.
        enough: What may be missing [L, rad].

    Returns:
        The motion, its equations' values, and the largest residual left [L, rad].
    """
    least = bend_limits(equations, max_bend_rad)
    search = equations.descent(least, ACTIVE, *rows_besides(equations, None))
    angle, *known, off = search.approached(equations.angles, enough, *patience)
    return equations.of(equations.with_angles(angle)), equations.values(angle, *known), off


def newton_step(here: Linearised, reach: float = REACH_RAD) -> Array:
    """Return the least step to the arrival that breaks no limit, as far as is linear. Shape (n,).

    Args:
        here: The motion where it starts.
        reach: The step's largest component [rad].
    """
    derivative, residual, slack, slope = here.values.derivative, here.values.residual, here.slack, here.slope
    step, near = np.zeros(derivative.shape[1]), slack < _NEAR_LIMIT * np.max(slack, initial=0.0)
    for _ in range(2):
        step = bounded_step(derivative, residual, slack[near], slope[near], reach)
        broken = slack + (slope * step).sum(axis=1) < 0.0
        if not np.any(broken & ~near):
            break
        near = near | broken
    return step


def settled(motion: Equations) -> tuple[Equations, float]:
    """Return a motion by moves changed, by the least amount, to end exactly at the goal.

    Returns:
        The motion, and the largest residual left [L, rad].
    """
    exact, bend = motion.at_accuracy(EXACT), motion.swimmer.max_bend_rad
    angle, left, idle = exact.angles, math.inf, 0
    while True:
        values = exact.at(angle)
        idle = 0 if values.size < 0.5 * left else idle + 1
        left = min(left, values.size)
        if left < _ENOUGH_UNROUNDED or idle > _PATIENCE:
            break
        angle = angle + newton_step(linearised(exact, values, bend))
    return arrive(exact.of(exact.with_angles(angle)), values, bend)


def arrive(
    equations: Equations, rough: Values, max_bend_rad: float, rounded: Callable[[Array], Array] | None = None
) -> tuple[Equations, float]:
    """Return the motion with its angles changed, by the least amount, to end exactly at the goal.

    A rough derivative will do: what is missing is small, and shrinks by the derivative's own
    accuracy in each round.

    Args:
        equations: The equations of a motion that almost arrives.
        rough: The equations' values, at a rough accuracy.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        rounded: Rounds angles to what the clock can tell [rad]; None where they need no rounding.

    Returns:
        The motion of the best round, and the largest residual left [L, rad].
    """
    begun = equations.angles if rounded is None else rounded(equations.angles)
    # A large residual is known well enough at the rough accuracy.
    plain = _PLAIN * sum(s.cycles for s in equations.segments) / len(equations.segments)
    missing = rough.residual if rough.size > plain else equations.residual(begun)
    enough = np.full(len(missing), _ENOUGH_UNROUNDED if rounded is None else _ENOUGH)
    if equations.repeats:  # rounding to the clock leaves a residual of this size
        enough[:6] += _SPOILT * np.max(np.abs(matmul(rough.derivative[:6], begun - equations.angles)))
    every = np.arange(len(begun))
    angle, missing = _rounds(equations, begun, missing, rough, max_bend_rad - _MARGIN_RAD, rounded, every, enough)
    if rounded is not None and np.any(np.abs(missing) > ENOUGH_LAST):
        angle, missing = one_by_one(equations, angle, missing, rough.derivative, rounded)
    best = float(np.max(np.abs(missing)))
    here = equations.of(equations.with_angles(angle))
    first = 1 + max((k for k, s in enumerate(here.segments) if not s.once), default=-1)
    if best <= ENOUGH_LAST or first in (0, len(here.segments)):
        return here, best
    last = here.after(first, missing[:6])
    if not here.by_moves:
        last = last.of([s.changed(lambda part: offered(part, 1, here.controls)) for s in last.segments])
    known = len(missing) - 6 * len(last.targets)  # of limbs where an earlier phase ends
    missing = np.concatenate([missing[:6], missing[known:]])
    rough = last.at_accuracy(SEARCHING).at(last.angles)
    bend = max_bend_rad - LAST_MARGIN_RAD
    least = bend_limits(last, bend)
    slack, slope = limit_rows(last, rough, least)
    few = _independent(np.concatenate([rough.derivative, slope[slack < _TIGHT]]))
    enough = np.full(len(missing), ENOUGH_LAST)
    angle, left = _rounds(last, last.angles, missing, rough, bend, rounded, few, enough)
    if rounded is not None and np.any(np.abs(left) > enough):
        angle, left = one_by_one(last, angle, left, rough.derivative, rounded)
    closer = float(np.max(np.abs(np.append(left, missing[6:known]))))
    if closer >= best:
        return here, best
    there = last.with_angles(angle)
    busy = there if here.by_moves else [s.changed(PrimitiveSequence.busy) for s in there]
    return here.of([*here.segments[:first], *busy]), closer


def _rounds(
    equations: Equations,
    angle: Array,
    missing: Array,
    rough: Values,
    max_bend_rad: float,
    rounded: Callable[[Array], Array] | None,
    may: NDArray[np.int64],
    enough: Array,
) -> tuple[Array, Array]:
    """Return the best angles that some of them, changed in turn, lead to, and what is missing there.

    Args:
        equations: The equations.
        angle: The angles to begin at [rad]. Shape (n,).
        missing: What is missing there [L, rad]. Shape (m,).
        rough: The equations' values, at a rough accuracy.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        rounded: Rounds angles to what the clock can tell [rad], if they are rounded.
        may: Which angles may change.
        enough: What may be missing [L, rad]. Shape (m,).
    """
    least = bend_limits(equations, max_bend_rad)
    slack, slope = limit_rows(equations, rough, least)
    begun, derivative = angle, rough.derivative[:, may]
    best, kept, idle = (float(np.max(np.abs(missing))), missing), angle, 0
    while idle < _PATIENCE and np.any(np.abs(missing) > enough):
        left = slack + matmul(slope, angle - begun)
        step = np.zeros(len(angle))
        step[may] = bounded_step(derivative, missing, left, slope[:, may], REACH_RAD)
        angle, before = angle + step if rounded is None else rounded(angle + step), missing
        missing = equations.residual(angle)
        if (length := float(matmul(step, step))) > _TELLING_RAD**2:
            change = (missing - before - matmul(derivative, step[may])) / length
            derivative = derivative + change[:, None] * step[may]  # Broyden (1965), Math. Comp. 19, 577
        size = float(np.max(np.abs(missing)))
        idle = idle + 1 if size > 0.5 * best[0] else 0
        if size < best[0]:
            best, kept = (size, missing), angle
    return kept, best[1]


def _independent(columns: Array) -> NDArray[np.int64]:
    """Return the columns, as many as the rank, that are least dependent on one another."""
    left, chosen, largest = columns.copy(), [], 0.0
    for _ in range(len(columns)):  # pivots of a QR decomposition; scipy's takes too long to import
        sizes = np.add.reduce(left * left, axis=0)
        pick = int(np.argmax(sizes))
        largest = max(largest, float(sizes[pick]))
        if sizes[pick] <= _DEPENDENT**2 * largest:
            break
        chosen.append(pick)
        pivot = left[:, pick] / math.sqrt(sizes[pick])
        left -= pivot[:, None] * (matmul(pivot, left))
    return np.sort(np.array(chosen, dtype=np.int64))
