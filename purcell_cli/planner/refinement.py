"""Refinement: brings a motion that almost arrives to the goal, judges it, and minimises its joint travel."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.lift import EXACT, SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step, rounded
from purcell_cli.motion.limits import Limits, LimitsReport
from purcell_cli.motion.limits_check import check
from purcell_cli.planner.incumbent import Contender
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, approach, arrive
from purcell_cli.planner.refine.minimum_travel import Pace, minimise_travel, offering
from purcell_cli.planner.refine.segments import free_primitives
from purcell_cli.planner.refine.shooting import Equations, Values
from purcell_cli.planner.refine.slight_bends import within_bends

_MENDED, _FEW = 0.02, 100
"""Motions that miss by less than this [L, rad], of no more free primitives than so many, are offered idle controls."""
_CLOSER = 1e-6
"""What such motions may miss by then: where links come near one line the last steps are far from linear [L, rad]."""


@frozen_dataclass(eq=False)
class Near:
    """A motion brought as near the goal as the first steps go.

    Attributes:
        motion: The motion.
        values: Its equations' values.
        off: What it misses the goal by [L, rad].
    """

    motion: Equations
    values: Values
    off: float

    @property
    def close(self) -> bool:
        """Whether that is near enough for the last steps."""
        return self.off < CLOSE


@frozen_dataclass(eq=False)
class Refinement:
    """Refines the motions of one query.

    Attributes:
        swimmer: The swimmer; phase 2 keeps its bend limit.
        start: The configuration before the motion.
        limits: What the motion must keep besides.
        objective: One of `objectives.MEASURES`.
    """

    swimmer: Swimmer
    start: Configuration
    limits: Limits
    objective: str

    @property
    def bend_rad(self) -> float:
        """How far limbs bend in phase 2 until the last steps [rad]."""
        return self.swimmer.max_bend_rad - MARGIN_RAD

    @property
    def clearance(self) -> float:
        """How far limbs stay apart in phases 1 and 3 [L]."""
        return self.limits.clearance_m / self.swimmer.length_m

    def near(self, motion: Equations) -> Near:
        """Return a motion brought nearly to the goal, with idle controls offered where its own do not get there."""
        near = Near(*approach(motion, self.bend_rad))
        return near if near.close else min(near, self.richer(near), key=lambda one: one.off)

    def richer(self, near: Near) -> Near:
        """Return a motion brought nearly to the goal with every control that there is offered at its switches.

        A motion of few angles, some bent to their limit, may have none left to arrive by. What misses by much, or has
        many angles, stays as it is.
        """
        motion = near.motion
        if near.off > _MENDED or free_primitives(motion.segments) > _FEW:
            return near
        every = motion.of(offering(motion.segments, motion.controls))
        return Near(*approach(every, self.bend_rad, enough=_CLOSER))

    def shorter(self, motion: Equations, pace: Pace) -> Equations:
        """Return a motion of less joint travel that still arrives, almost exactly."""
        return minimise_travel(motion, self.bend_rad, pace, self.clearance)

    def cost(self, motion: Equations) -> float:
        """Return what a motion spends of the objective."""
        return cost(self.objective, motion.swimmer, motion.blocks(), motion.start)

    def contender(self, near: Near, words: str) -> Contender:
        """Return a motion brought exactly to the goal, its durations on the clock, and judged.

        Args:
            near: The motion, close to the goal.
            words: What it is made of.
        """
        own = clock_step(1.01 * near.motion.joint_travel_rad / self.swimmer.joint_rate_rad_s)
        step = max(own, self.limits.clock_s)

        def on_the_clock(angle: Array) -> Array:
            return rounded(angle, self.swimmer.joint_rate_rad_s, step)

        timed = [
            s if s.free else dataclasses.replace(s, sequence=closed_on_the_clock(s.sequence, on_the_clock))
            for s in near.motion.segments
        ]
        begun = near.motion.at_accuracy(EXACT).of(timed)
        # Rounded, a rectangle may close that did not, and then has fewer angles to change.
        rough = begun.at_accuracy(SEARCHING)
        values = near.values if len(begun.angles) == len(near.motion.angles) else rough.at(rough.angles)
        motion, off = arrive(begun, values, self.swimmer.max_bend_rad, on_the_clock)

        def judged(one: Equations) -> LimitsReport:
            return check(self.swimmer, self.start, played(one), self.limits)

        motion, off, report = within_bends(motion, off, judged, self.swimmer.max_bend_rad, on_the_clock)
        return Contender(motion, words, off, self._excess(report), self.cost(motion), report)

    def _excess(self, report: LimitsReport) -> float:
        """Return by how much limits are broken in all [L, rad]."""
        return sum(v.excess / (self.swimmer.length_m if v.unit == "m" else 1.0) for v in report.violations)


def closed_on_the_clock(sequence: PrimitiveSequence, on_the_clock: Callable[[Array], Array]) -> PrimitiveSequence:
    """Return a repeated stroke on the clock: angles that sum to nothing still do, which thousands of cycles need."""
    angle = sequence.angle.copy()
    for control in sorted(set(sequence.control.tolist())):
        own = sequence.control == control
        angle[own] = np.diff(on_the_clock(np.cumsum(angle[own])), prepend=0.0)
    return sequence.with_angles(angle)


def played(motion: Equations) -> tuple[Block, ...]:
    """Return a motion's blocks, those left out in which nothing rotates."""
    return tuple(b for b in motion.blocks() if np.any(b.sequence.duration))


def cycles_apart(motion: Equations, most: int) -> list[Block]:
    """Return a motion's blocks, the cycles of repeated strokes apart, the last first, up to so many primitives.

    Args:
        motion: The motion.
        most: How many primitives it may have then; strokes for which there is no room stay as they are.
    """
    out: list[Block] = []
    blocks = motion.blocks()
    room = most - sum(len(b.sequence) for b in blocks if b.cycles == 1)
    for block in reversed(blocks):
        more = block.cycles * len(block.sequence)
        if block.cycles > 1 and more <= room:
            room -= more
            out += [dataclasses.replace(block, cycles=1)] * block.cycles
        else:
            out.append(block)
    return out[::-1]
