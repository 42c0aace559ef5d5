"""Minimum time: sequential linear programming on the duration under the exact arrival.

The joint that turns furthest on a move sets its duration. So the duration of a motion is a sum of
maxima of absolute values, and its minimum under linear equations is a linear program. An exact l1
penalty keeps the violations of the arrival and of the bend limit small; `settled` removes the rest.

Method: as in `minimum_travel`, Fletcher and de la Maza (1989), Math. Program. 43.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import EXACT
from purcell_cli.planner.refine.active_set import bounded_step
from purcell_cli.planner.refine.move_program import Weights
from purcell_cli.planner.refine.shooting_moves import MoveShooting, Values
from purcell_cli.planner.refine.trust_region import descended

QUICKEST = Weights(time=1.0, travel=1e-3)
"""Least time, and of motions that take as long the one of least joint travel."""
SHORTEST = Weights(time=1e-3, travel=1.0)
"""Least joint travel, and of motions that travel as much the one of least time."""
_LEAST_REACH = 1e-4
"""Damped Newton steps to the arrival end when their reach is below this [rad]."""
_LEAST_PRICE = 200.0
"""The least cost of a violation, at a joint rate of 1 rad/s [s per L or rad]."""
_PRICE = 10.0
"""The least cost of a violation per second of the motion [1 per L or rad]."""
_SHORT_PRICE = 2e3
"""The same times the duration: the way grows with its square, so that a short motion would rather miss [s^2 per L]."""
_WORTH = 3e-4
"""A linear program that promises less than this part of the merit is the last."""
_NEWTON_REACH = 0.25
"""The largest component of a Newton step [rad]."""
_NEAR = 3e-3
"""Bends with less slack than this bound a Newton step from the first, as a part of the most there is."""
_APPROACHES = 40
"""The most damped Newton steps to the arrival from which the search begins."""
_RESTORATIONS = 6
"""The most Newton steps back to the arrival after each linear program."""
_RESTORED = 1e-6
"""A point whose residuals are all below this is at the arrival [L, rad]."""
_ENOUGH = 4e-12
"""The exact arrival ends when no residual is larger than this [L, rad]."""
_PATIENCE = 4
"""Rounds without a halved residual before the best is taken."""


@frozen_dataclass(eq=False)
class _Point:
    unknown: Array
    values: Values
    merit: float


@frozen_dataclass(eq=False)
class Found:
    """What a search ends with.

    Attributes:
        motion: The motion.
        merit: Its cost and a price for what it misses.
        reach: The radius of the trust region at the end [rad].
    """

    motion: MoveShooting
    merit: float
    reach: float


class Program(Protocol):
    """What is to be least, and the programs of its steps."""

    def cost(self, values: Values) -> float:
        """Return what the motion costs."""

    def step(self, values: Values, price: float, reach: float) -> tuple[Array, float] | None:
        """Return the best change of the unknowns within reach, and the merit it promises; None where none is found."""


class _Search:
    def __init__(self, motion: MoveShooting, program: Program) -> None:
        self.motion, self.program = motion, program
        self.price = max(_LEAST_PRICE, _PRICE * motion.duration, _SHORT_PRICE / max(motion.duration, 0.1))

    def point(self, unknown: Array) -> _Point:
        values = self.motion.at(unknown)
        violation = float(np.sum(np.abs(values.residual)) - np.sum(np.minimum(values.slack, 0.0)))
        return _Point(unknown, values, self.program.cost(values) + self.price * violation)

    def step(self, here: _Point, reach: float) -> tuple[Array, float] | None:
        """Return the unknowns that minimise the linearised merit within reach, and that merit."""
        found = self.program.step(here.values, self.price, reach)
        return None if found is None else (here.unknown + found[0], found[1])

    def begun(self, unknown: Array) -> _Point:
        """Return a point at the arrival to begin from, or as near to it as damped Newton steps come."""
        here, reach = self.point(unknown), _NEWTON_REACH
        for _ in range(_APPROACHES):
            if here.values.size < _RESTORED or reach < _LEAST_REACH:
                break
            there = self.point(here.unknown + newton_step(here.values, reach))
            better = there.merit < here.merit
            here, reach = (there, min(2.0 * reach, _NEWTON_REACH)) if better else (here, 0.4 * reach)
        return here

    def restored(self, there: _Point) -> _Point:
        """Return a point moved back to the arrival and within the bend limit by Newton's method.

        The roll of the base changes so fast with small bends that linear programs alone would need very short
        steps; Newton's method changes a few angles of a roll stroke to correct it after a long one.
        """
        for _ in range(_RESTORATIONS):
            moved = self.point(there.unknown + newton_step(there.values))
            if moved.merit > there.merit:
                break
            there = moved
            if there.values.size < _RESTORED:
                break
        return there

    def run(self, unknown: Array, rounds: int, reach: float) -> tuple[_Point, float]:
        return descended(
            self.begun(unknown),
            self.step,
            lambda _, found, *__: self.restored(self.point(found)),
            rounds,
            lambda here: _WORTH * here.merit,
            reach,
        )


def newton_step(values: Values, reach: float = _NEWTON_REACH, first: int = 0) -> Array:
    """Return the least step to the arrival that leaves no limb bent too far, as far as is linear. Shape (f,).

    Args:
        values: The equations where it starts.
        reach: Its largest component [rad].
        first: The first unknown that may change.
    """
    step = np.zeros(values.derivative.shape[1])
    arrival, slope, near = (
        values.derivative[:, first:],
        values.slack_derivative[:, first:],
        values.slack < _NEAR * np.max(values.slack, initial=0.0),
    )
    for _ in range(2):
        step[first:] = bounded_step(arrival, values.residual, values.slack[near], slope[near], reach)
        broken = values.slack + (values.slack_derivative * step).sum(axis=1) < 0.0
        if not np.any(broken & ~near):
            break
        near = near | broken
    return step


def minimised(motion: MoveShooting, program: Program, rounds: int, reach: float) -> Found:
    """Return a motion that costs less and arrives almost exactly.

    Args:
        motion: The motion to begin with.
        program: What is to be least, for this motion.
        rounds: The most programs.
        reach: The radius of the trust region at the first step [rad].
    """
    found, last = _Search(motion, program).run(motion.unknown, rounds, reach)
    return Found(motion.of(motion.segments_at(found.unknown)), found.merit, last)


def settled(motion: MoveShooting) -> tuple[MoveShooting, float]:
    """Return the motion changed, by the least amount, to end exactly at the goal.

    Where rounding then stands in the way, since loops that repeat multiply it, only the moves after
    the last of those go on.

    Returns:
        The motion, and the largest residual left [L, rad].
    """
    exact = motion.of(motion.segments, EXACT)
    unknown = exact.unknown
    best, kept, idle = np.inf, unknown, 0
    while idle < _PATIENCE:
        values = exact.at(unknown)
        idle = idle + 1 if values.size > 0.5 * best else 0
        if values.size < best:
            best, kept = values.size, unknown
        if best < _ENOUGH:
            break
        unknown = unknown + newton_step(values, first=exact.tail if idle else 0)
    return exact.of(exact.segments_at(kept)), float(best)
