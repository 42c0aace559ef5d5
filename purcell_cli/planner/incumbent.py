"""The best plan so far."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.lift import EXACT
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step, rounded
from purcell_cli.motion.limits import Limits, LimitsReport, check
from purcell_cli.motion.plan import Structure
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Effort
from purcell_cli.planner.library.random_plans import brought, random_words
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, approach, arrive
from purcell_cli.planner.refine.minimum_travel import shorten, tightened
from purcell_cli.planner.refine.shooting import Equations, Values
from purcell_cli.planner.refine.stretches import stretches_of

_ARRIVED = 1e-10


_WORD_RAD = 25.0
"""Phases 2 of less joint travel than this may be one random word."""


_PROMISING = 1.2
"""A word is carried on with if it is at most so many times as long as the best plan."""


Progress = Callable[[int, int, str], None]
"""Is told how many ways are explored, of how many, and in words what was found."""


class _Best:
    """The best plan so far, by a measure: one that arrives before one that does not, and one within limits first."""

    def __init__(self, swimmer: Swimmer, start: Configuration, limits: Limits, measure: str) -> None:
        self.swimmer, self.start, self.limits, self.measure = swimmer, start, limits, measure
        self.bend, self.apart = swimmer.max_bend_rad - MARGIN_RAD, limits.clearance_m / swimmer.length_m
        self.motion: Equations | None = None
        self.report: LimitsReport | None = None
        self.weighed: dict[str, float] = {}
        self.words = ""
        self._off, self._excess, self._cost = math.inf, math.inf, math.inf

    @property
    def good(self) -> bool:
        """Whether it arrives within limits."""
        return self.arrived and self._excess == 0.0

    @property
    def arrived(self) -> bool:
        """Whether it arrives, within limits or not."""
        return self._off < _ARRIVED

    @property
    def joint_travel_rad(self) -> float:
        return math.inf if self.motion is None else self.motion.joint_travel_rad

    def consider(self, motion: Equations, words: str) -> Equations:
        """Bring a motion to the goal, keep it if it is the best, and return it nearly there.

        Args:
            motion: The motion.
            words: What it is made of.
        """
        near, values, off = approach(motion, self.bend)
        if off < CLOSE:
            self.weighed[words] = min(near.joint_travel_rad, self.weighed.get(words, math.inf))
        if off < CLOSE and not (self.good and self._cost_of(near) >= self._cost):
            exact, off = _exact(self.swimmer, near, values)
            report, spent = check(self.swimmer, self.start, played(exact), self.limits), self._cost_of(exact)
            excess = self._excess_of(report)
            if (off >= _ARRIVED, excess, spent) < (self._off >= _ARRIVED, self._excess, self._cost):
                self.report = report
                self.motion, self._off, self._excess, self._cost, self.words = exact, off, excess, spent, words
        elif self.motion is None:
            self.motion, self._off = near, off
        return near

    def _cost_of(self, motion: Equations) -> float:
        return cost(self.measure, motion.swimmer, motion.blocks(), motion.start)

    def _excess_of(self, report: LimitsReport) -> float:
        return sum(v.excess / (self.swimmer.length_m if v.unit == "m" else 1.0) for v in report.violations)

    def explore(self, found: Sequence[Candidate], rough: Equations, how: Effort, progress: Progress) -> None:
        """Carry on with candidates, and with random words for small displacements."""
        waiting, k = list(found), 0
        shorter: list[tuple[Equations, str]] = []
        while waiting and (k < how.candidates or not self.good):
            candidate, k = waiting.pop(0), k + 1
            near = self.consider(rough.of(stretches_of(candidate.blocks)), candidate.words)
            self._tell(progress, k, how)
            if how.pace is not None and near.joint_travel_rad < how.longest_rad:
                apart, words = near.of(stretches_of(_apart(near, how.most))), f"{candidate.words}, joined"
                shorter.append((self.consider(shorten(apart, self.bend, how.pace, self.apart), words), words))
        shorter.sort(key=lambda one: round(one[0].joint_travel_rad, 9))
        for motion, words in shorter[: how.finalists]:
            self.consider(shorten(motion, self.bend, how.last, self.apart), words)
            k += 1
            self._tell(progress, k, how)
        self._words(rough, how, progress)

    def structures(self, found: Sequence[Candidate]) -> tuple[Structure, ...]:
        """Return what was weighed, the one taken first; those not carried on with as the search guessed them."""
        guessed: dict[str, float] = {}
        for candidate in found:
            guessed.setdefault(candidate.words, candidate.joint_travel_rad)
        rest = {**guessed, **self.weighed}
        rest.pop(self.words, None)
        ranked = sorted(rest.items(), key=lambda item: (round(item[1], 9), item[0]))
        return (Structure(self.words, self.joint_travel_rad), *(Structure(w, t) for w, t in ranked))

    def _words(self, rough: Equations, how: Effort, progress: Progress) -> None:
        if self.motion is None or how.pace is None:
            return
        outer = [s for s in self.motion.stretches if s.phase != 2]
        inner = self.joint_travel_rad - sum(s.joint_travel_rad for s in outer)
        for k, word in enumerate(random_words(how.words if inner < _WORD_RAD else 0)):
            parts = [s for s in outer if s.phase == 1] + [word] + [s for s in outer if s.phase == 3]
            near, off = brought(rough.of(parts), self.bend)
            if off < 1e-3:
                first = tightened(near, self.bend, how.pace, self.apart)
                if first.joint_travel_rad < _PROMISING * self.joint_travel_rad:
                    self.consider(shorten(first, self.bend, how.pace, self.apart), "one word of joined strokes")
            self._tell(progress, how.candidates + how.finalists + k + 1, how)

    def _tell(self, progress: Progress, done: int, how: Effort) -> None:
        progress(done, how.candidates + how.finalists + how.words, f"joint travel {self.joint_travel_rad:.2f} rad")


def played(motion: Equations) -> tuple[Block, ...]:
    """Return a motion's blocks, those left out in which nothing turns."""
    return tuple(b for b in motion.blocks() if np.any(b.sequence.duration))


def _apart(motion: Equations, most: int) -> list[Block]:
    """Return a motion's blocks, the cycles of repeated strokes apart, the last first, up to so many primitives."""
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


def _exact(swimmer: Swimmer, motion: Equations, values: Values) -> tuple[Equations, float]:
    """Return a motion that arrives exactly, its durations on the clock, and what it misses by [L, rad]."""
    step = clock_step(1.01 * motion.joint_travel_rad / swimmer.joint_rate_rad_s)

    def on_the_clock(angle: Array) -> Array:
        return rounded(angle, swimmer.joint_rate_rad_s, step)

    timed = [
        s if s.free else dataclasses.replace(s, sequence=s.sequence.with_angles(on_the_clock(s.sequence.angle)))
        for s in motion.stretches
    ]
    return arrive(motion.at_accuracy(EXACT).of(timed), values, swimmer.max_bend_rad, on_the_clock)
