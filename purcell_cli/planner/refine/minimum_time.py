"""Minimum time: sequential linear programming on the duration under the exact arrival.

The joint that turns furthest on a move sets its duration. So the duration of a motion is a sum of
maxima of absolute values, and its minimum under linear equations is a linear program. An exact l1
penalty keeps the violations of the arrival and of the bend limit small; `exact_arrival` removes the rest.

Method: as in `minimum_travel`, Fletcher and de la Maza (1989), Math. Program. 43.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.refine.exact_arrival import newton_step
from purcell_cli.planner.refine.inequalities import Linearised, linearised
from purcell_cli.planner.refine.move_program import Weights
from purcell_cli.planner.refine.shooting import Equations
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
_APPROACHES = 40
"""The most damped Newton steps to the arrival from which the search begins."""
_RESTORATIONS = 6
"""The most Newton steps back to the arrival after each linear program."""
_RESTORED = 1e-6
"""A point whose residuals are all below this is at the arrival [L, rad]."""


@frozen_dataclass(eq=False)
class _Point:
    angle: Array
    linear: Linearised
    merit: float

    @property
    def size(self) -> float:
        """The largest residual [L, rad]."""
        return self.linear.values.size


@frozen_dataclass(eq=False)
class Found:
    """What a search ends with.

    Attributes:
        motion: The motion.
        merit: Its cost and a price for what it misses.
        reach: The radius of the trust region at the end [rad].
    """

    motion: Equations
    merit: float
    reach: float


class Program(Protocol):
    """What is to be least, and the programs of its steps."""

    def cost(self, turn: Array) -> float:
        """Return what the motion costs by some turns of joints [rad]. Shape (k, 6)."""

    def step(self, here: Linearised, price: float, reach: float) -> tuple[Array, float] | None:
        """Return the best change of the free angles in reach, and the merit it promises; None where none is found."""


class _Search:
    def __init__(self, motion: Equations, program: Program) -> None:
        self.motion, self.program = motion, program
        self.price = max(_LEAST_PRICE, _PRICE * motion.duration, _SHORT_PRICE / max(motion.duration, 0.1))

    def point(self, angle: Array) -> _Point:
        here = linearised(self.motion, self.motion.at(angle), self.motion.swimmer.max_bend_rad)
        violation = float(np.sum(np.abs(here.values.residual)) - np.sum(np.minimum(here.slack, 0.0)))
        return _Point(angle, here, self.program.cost(here.values.turn) + self.price * violation)

    def step(self, here: _Point, reach: float) -> tuple[Array, float] | None:
        """Return the free angles that minimise the linearised merit within reach, and that merit."""
        found = self.program.step(here.linear, self.price, reach)
        return None if found is None else (here.angle + found[0], found[1])

    def begun(self, angle: Array) -> _Point:
        """Return a point at the arrival, or as near as damped Newton steps come to it from angles (n,) [rad]."""
        here, reach = self.point(angle), _NEWTON_REACH
        for _ in range(_APPROACHES):
            if here.size < _RESTORED or reach < _LEAST_REACH:
                break
            there = self.point(here.angle + newton_step(here.linear, reach))
            better = there.merit < here.merit
            here, reach = (there, min(2.0 * reach, _NEWTON_REACH)) if better else (here, 0.4 * reach)
        return here

    def restored(self, there: _Point) -> _Point:
        """Return a point moved back to the arrival and within the bend limit by Newton's method.

        The roll of the base changes so fast with small bends that linear programs alone would need very short
        steps; Newton's method changes a few angles of a roll stroke to correct it after a long one.
        """
        for _ in range(_RESTORATIONS):
            moved = self.point(there.angle + newton_step(there.linear, _NEWTON_REACH))
            if moved.merit > there.merit:
                break
            there = moved
            if there.size < _RESTORED:
                break
        return there

    def run(self, angle: Array, rounds: int, reach: float) -> tuple[_Point, float]:
        return descended(
            self.begun(angle),
            self.step,
            lambda _, found, *__: self.restored(self.point(found)),
            rounds,
            lambda here: _WORTH * here.merit,
            reach,
        )


def minimised(motion: Equations, program: Program, rounds: int, reach: float) -> Found:
    """Return a motion that costs less and arrives almost exactly.

    Args:
        motion: The motion to begin with.
        program: What is to be least, for this motion.
        rounds: The most programs.
        reach: The radius of the trust region at the first step [rad].
    """
    found, last = _Search(motion, program).run(motion.angles, rounds, reach)
    return Found(motion.of(motion.with_angles(found.angle)), found.merit, last)
