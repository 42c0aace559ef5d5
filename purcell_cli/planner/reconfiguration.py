"""Point-to-point reconfiguration in three phases (section IV-B of the paper).

1. Limbs to the collinear shape, by primitives.
2. A sequence of stored gaits that makes the body displacement still missing.
3. Limbs to the goal shape, by primitives.

The displacement of phase 2 is the body displacement g_2^-1 g_3 (left invariance), where the paper
prints g_3 g_2^-1: what phases 1 and 3 will do to the base is known before they are played, so it
is taken into account.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from purcell_cli.errors import UnknownNameError
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation, displacement_between
from purcell_cli.mechanics.lift import EXACT, SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clearance import apart_bend_rad
from purcell_cli.motion.clock import clock_step, rounded
from purcell_cli.motion.limits import Limits, LimitsReport, check
from purcell_cli.motion.plan import Plan, Structure
from purcell_cli.planner.candidates import Breadth, Candidate, candidates
from purcell_cli.planner.library.random_plans import brought, random_words
from purcell_cli.planner.objectives import cost, known_measure
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, approach, arrive
from purcell_cli.planner.refine.minimum_travel import Pace, shorten, tightened
from purcell_cli.planner.refine.shooting import Equations, Values, stretches_of

_THERE = 1e-14
"""A start this near its goal (L, rad) is there already."""

_ARRIVED = 1e-10
_LEAST_BEND_RAD = 0.1
"""No bend limit is lowered further than this, whatever the clearance."""


@dataclasses.dataclass(frozen=True, slots=True)
class Effort:
    """How long to look for a shorter plan.

    Attributes:
        candidates: How many of the search's motions are carried on with.
        pace: How long their strokes are optimised together; None for not at all.
        finalists: How many of the shortest are optimised further.
        last: How long those are.
        most: Cycles are told apart, each free to change, up to so many primitives.
        longest_rad: Motions of more joint travel are not optimised [rad].
        words: How many random words are tried too, for a phase 2 of little joint travel.
        breadth: How widely motions are searched for.
    """

    candidates: int
    pace: Pace | None = None
    finalists: int = 0
    last: Pace = Pace(rounds=12, steps=60, price=300.0)
    most: int = 0
    longest_rad: float = math.inf
    words: int = 0
    breadth: Breadth = Breadth()


EFFORTS: Mapping[str, Effort] = {
    "quick": Effort(1, breadth=Breadth(chains=1, rounds=4, shorter=0, words=4, pace=Pace(1, 6))),
    "standard": Effort(1, Pace(rounds=3, steps=12), most=24, longest_rad=16.0),
    "thorough": Effort(
        8,
        Pace(rounds=3, steps=40, price=300.0),
        finalists=3,
        most=60,
        words=32,
        breadth=Breadth(orders=40, pairs=48, starts=1152, chains=24, rounds=24, shorter=8, words=24, pace=Pace(3, 30)),
    ),
}

_WIDE = Effort(1, breadth=Breadth(pairs=36, starts=432, chains=24, rounds=20, shorter=0, words=24))
"""How to look where nothing arrives otherwise."""
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


def reconfigure(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    gaits: Mapping[str, Gait],
    effort: str = "standard",
    minimize: str = "travel",
    limits: Limits | None = None,
    progress: Progress = lambda _done, _of, _news: None,
) -> Plan:
    """Return a plan from a start to a goal configuration.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        gaits: The stored gaits to choose from.
        effort: One of `EFFORTS`. Interrupted, "thorough" returns the best plan so far.
        minimize: One of `measures.MEASURES`: what to spend least of.
        limits: What the plan must keep besides the bend limit; where none is found that does, the nearest to it.
        progress: Is told how far the search is.

    Raises:
        GaitError: No stored gait for a motion that is needed.
        UnknownNameError: No effort or measure has this name.
    """
    known_measure(minimize)
    if effort not in EFFORTS:
        raise UnknownNameError(f"effort: one of {', '.join(EFFORTS)} is wanted, found {effort!r}")
    if Deviation.between(start, goal).within(_THERE * swimmer.length_m, _THERE):
        return Plan(swimmer, start, goal, ())
    kept_to = limits or Limits()
    # Phase 2 needs no bends at which the limbs could meet.
    apart_rad = max(apart_bend_rad(swimmer, kept_to.clearance_m), _LEAST_BEND_RAD)
    careful = dataclasses.replace(swimmer, max_bend_rad=min(swimmer.max_bend_rad, apart_rad))
    unit, how = careful.scaled(), EFFORTS[effort]
    wanted = displacement_between(start, goal, swimmer.length_m)
    rough = Equations(unit, (), start.shape, goal.shape, wanted, SEARCHING)
    best = _Best(careful, start, kept_to, minimize)
    found: list[Candidate] = []
    try:
        # Who looks for long looks for a little first: so there is a plan early, and never a longer one.
        for effort_now in (EFFORTS["standard"], how) if how.words else (how, _WIDE):
            if effort_now is _WIDE:
                if best.arrived:
                    break
                found = []  # those have all been tried
            for measure in dict.fromkeys(("travel", minimize)):
                ends = start.shape, goal.shape
                found += candidates(unit, *ends, wanted, gaits, measure, best.apart, effort_now.breadth)
            found.sort(key=lambda c: c.rank(minimize, unit, start.shape))
            best.explore(found, rough, effort_now, progress)
    except KeyboardInterrupt:
        if not best.good or not how.words:
            raise
    blocks = () if best.motion is None else played(best.motion)
    return Plan(swimmer, start, goal, blocks, best.structures(found), best.report)


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
