"""Plans on which all six joints may turn at once: a plan by primitives, optimised for minimum time.

1. Every primitive becomes a move; long ones are cut, so that others can join them for a part.
2. Loops that repeat become octagons (`octagonal_loops`).
3. At the collinear shape the limbs first roll by an eighth of a turn, opposite ways, which does not
   move the base. A limb's yaw and pitch axes then lie across the base's: it turns on both at once, and
   bends in the base's planes at the square root of two times the rate of one joint.
4. All rotations are optimised together for the duration (`minimum_time`) and settled exactly. At first
   strokes by yaws alone, or by pitches alone, stay so, since out of a plane the roll of the base
   changes too fast with the rotations; then all moves that are played once are free.

Hinges turn about one axis, a ball joint beside them about all three; there limbs are not rolled first. A universal
joint turns psi or theta on a move, since a limb that turns both does not turn at a constant rate about an axis of its
own: a primitive becomes one move for each angle of the other limb that may join it (`joint_turns`).

A result that is no quicker, not exact, or beyond a limit is rejected. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.joint_turns import choices, rotation_vectors
from purcell_cli.mechanics.lift import ROUGH
from purcell_cli.mechanics.moves import MoveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clearance import apart_bend_rad, limb_distance
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.limits import Limits, LimitsReport
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.pace import paced as played_at_pace
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.refine.coarser_moves import coarser
from purcell_cli.planner.refine.exact_arrival import settled
from purcell_cli.planner.refine.minimum_energy import EnergyProgram, paced
from purcell_cli.planner.refine.minimum_time import QUICKEST, SHORTEST, Found, Program, minimised
from purcell_cli.planner.refine.move_program import MoveProgram, Weights
from purcell_cli.planner.refine.move_segments import (
    TOGETHER,
    all_freed,
    segments_of_plan,
    with_phases_held,
    without_idle,
    without_straightening,
)
from purcell_cli.planner.refine.random_starts import random_starts
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.slight_bends import within_bends
from purcell_cli.planner.refine.trust_region import FIRST_REACH

_ACROSS_RAD = 0.25 * math.pi
"""Roll of the limbs, an eighth of a turn, that puts their yaw and pitch axes midway between the base's [rad]."""
_ROUNDS = {"quick": (6, 15), "standard": (6, 30), "thorough": (12, 80)}
"""The most programs by effort: for each start, and then for the one that promises most."""
_LARGE = {"quick": (2e3, 6e3), "standard": (4e3, 14e3), "thorough": (24e3, 80e3)}
"""Programs times free angles by effort, so that motions of many moves take no longer than others."""
_LATER, _FOLLOWED = 1.75, 2
"""So many times the programs for each start, and so many starts followed to their end, where joint travel is minimised
and some starts swing: which promises most is told later then, and not as well."""
_LEG = 2, 5
"""After how many programs moves are made fewer: for each start, and then."""
_LEAST_REACH = 0.03
"""The least radius of the trust region where all turns become free [rad]."""
_FEW = 100
"""Motions of at most so many free angles keep their moves: a program takes a millisecond or two."""
_LEAST_ROUNDS = 4
"""The least number of programs, however many free angles there are."""
_ARRIVED = 1e-10
"""A motion whose residuals are all below this arrives [L, rad]."""
_UNFELT_RAD = 1e-13
"""Moves that turn no joint further than this are dropped from the plan [rad]."""
_SPARE = 1e-9
"""Part of the time of a plan by primitives that the one of least energy leaves, for rounding to the clock."""
_MARGIN_L = 1e-3
"""How much more than the clearance limbs are apart while a motion is refined [L]."""
_FOLDING_RAD = 0.5 * math.pi
"""From this bend limit on motions that swing at random are begun from, too [rad]; below, none arrived."""
_SWINGS = (0.4, 0.7)
"""How long those last, as parts of the time that the plan by primitives takes."""
_LONGEST_S = 80.0
"""And at most, at a joint rate of 1 rad/s: longer ones have too many moves [s]."""
_TRIED, _KEPT = 60, 2
"""How many of each length are made, and how many of them are begun from."""
_MARGIN_RAD = 1e-6
"""Margin below the bend limit, left to the exact arrival [rad]; at most half the limit."""
_MOST_MOVES = 1000
"""Plans of more moves, one cycle of each stroke counted, stay as they are: derivatives grow with the square of that, to
some 7 GB at 9,000."""

_OUTER_PHASES = 2
"""Phases 1 and 3, each of which may have to stay as it is."""

_TOGETHER = 2
"""So many angles of joints must be able to turn at once for a plan to be made quicker."""


Maker = Callable[[Equations], Program]
"""Makes the program of a motion."""


def quickened(plan: Plan, limits: Limits | None = None, objective: str = "time", effort: str = "standard") -> Plan:
    """Return a plan that arrives as exactly and spends less, all joints turning at once; or the same plan.

    Args:
        plan: A plan by primitives.
        limits: What the plan must keep besides the bend limit; what breaks them is not taken.
        objective: One of `objectives.MEASURES`. Energy is least for the time that the plan by primitives takes; where
            switches are counted, that is the plan with few of them, made quicker.
        effort: One of `effort.EFFORTS`: how many programs a motion is optimised by.
    """
    if not plan.blocks or sum(len(block.sequence) for block in plan.blocks) > _MOST_MOVES:
        return plan
    if max(map(len, choices(plan.swimmer))) < _TOGETHER:
        return plan
    search = _Search(plan, limits, effort, "time" if objective == "switches" else objective)
    return search.run()


class _Search:
    """The search of one plan.

    Attributes:
        best: The best plan so far; at first the one by primitives.
    """

    def __init__(self, plan: Plan, limits: Limits | None, effort: str, objective: str) -> None:
        self.plan, self.limits, self.effort, self.objective = plan, limits, effort, objective
        self.best, self.total = plan, (1.0 - _SPARE) * math.fsum(b.duration for b in plan.blocks)
        swimmer = plan.swimmer
        self.ways = None if swimmer.ball_joints else tuple(choices(swimmer))
        rates = swimmer.rate_of(0) / swimmer.joint_rate_rad_s, swimmer.rate_of(1) / swimmer.joint_rate_rad_s
        self.rates = None if rates == (1.0, 1.0) else np.repeat(rates, 3)

    def run(self) -> Plan:
        """Return the best plan: what takes least time is where the search of others begins too."""
        across = (_ACROSS_RAD, 0.0) if self.ways is None else (0.0,)
        quickest = functools.partial(self._weighed, QUICKEST)
        swinging = self.swinging()
        found = [*self.descended(self.starts(*across), quickest), *self.descended(swinging, quickest)]
        if self.objective == "travel":
            later = (_LATER, _FOLLOWED) if swinging else (1.0, 1)
            self.descended([*found, *self.starts(0.0)], functools.partial(self._weighed, SHORTEST), *later)
        if self.objective == "energy":
            self.descended([*found, *self.starts(0.0)], functools.partial(EnergyProgram, total=self.total))
        return self.best

    def _weighed(self, weights: Weights, motion: Equations) -> Program:
        return MoveProgram(motion, dataclasses.replace(weights, rates=self.rates))

    def starts(self, *across_rad: float) -> list[Equations]:
        """Return the plan as motions by moves, the limbs rolled in phase 2 by angles, opposite ways [rad]."""
        plan, unit = self.plan, self.plan.swimmer.scaled()
        wanted = flattened(plan.swimmer, displacement_between(plan.start, plan.goal, plan.swimmer.length_m))
        inner = dataclasses.replace(unit, max_bend_rad=max(unit.max_bend_rad - _MARGIN_RAD, 0.5 * unit.max_bend_rad))
        if all(block.phase != 2 for block in plan.blocks):
            across_rad = across_rad[-1:]
        every = [segments_of_plan(plan, unit, across, self.ways) for across in across_rad]
        ends, apart = (plan.start.shape, plan.goal.shape), self._apart(inner)
        return [Equations(inner, s, *ends, wanted, ROUGH, apart) for s in every]

    def _apart(self, inner: Swimmer) -> float | None:
        """Return how far limbs stay from each other [L]; None where they cannot meet."""
        clearance = (self.limits.clearance_m if self.limits is not None else 0.0) / self.plan.swimmer.length_m
        ends = np.stack([self.plan.start.shape, self.plan.goal.shape])[..., 0]
        most = max(inner.max_bend_rad, float(np.max(bends(ends))))
        if most <= apart_bend_rad(inner, clearance):
            return None
        return min(clearance + _MARGIN_L, float(np.min(limb_distance(inner, ends))))

    def swinging(self) -> list[Equations]:
        """Return motions that swing at random, where limbs on ball joints may fold."""
        motion = self.starts(0.0)[0]
        most = float(np.max(bends(np.stack([motion.start, motion.goal])[..., 0])))
        if self.ways is not None or motion.swimmer.max_bend_rad < max(_FOLDING_RAD, most):
            return []
        lasting = [part * self.plan.joint_travel_rad for part in _SWINGS]
        return [
            one
            for k, seconds in enumerate(lasting)
            if seconds < _LONGEST_S
            for one in random_starts(motion, TOGETHER, seconds, _TRIED, _KEPT, k)
        ]

    def descended(
        self, starts: list[Equations], program: Maker, looked: float = 1.0, followed: int = 1
    ) -> list[Equations]:
        """Minimise what a program does from the start that promises most, or from the next where its plan does not do.

        A thorough search follows all of them to their end.

        Args:
            starts: The motions to begin with.
            program: Makes the program of a motion.
            looked: So many times the programs that the effort allows for each start.
            followed: How many starts whose plans do are followed to their end.

        Returns:
            The motions that arrive within limits, best first.
        """
        begun = [self._minimised(Found(start, math.inf, FIRST_REACH), program, False, looked) for start in starts]
        ended: list[Found] = []
        for one in sorted(begun, key=lambda one: one.merit):
            if len(ended) >= followed and self.effort != "thorough":
                break
            freed, reach = all_freed(one.motion, self.ways), max(one.reach, _LEAST_REACH)
            straight = without_straightening(freed)
            found = [] if straight is None else self._followed(Found(straight, one.merit, reach), program)
            ended += found or self._followed(Found(freed, one.merit, reach), program)
        return [one.motion for one in sorted(ended, key=lambda one: one.merit)]

    def _followed(self, here: Found, program: Maker) -> list[Found]:
        """Return where a motion leads if that arrives within limits; else none.

        A phase 1 or 3 that breaks a limit is as in the plan by primitives.
        """
        held: set[int] = set()
        made = functools.cache(self._made)
        broken = _held_phases(self._judged(made(here.motion)))
        for _ in range(_OUTER_PHASES):
            if held < held | broken:
                held = held | broken
                here = Found(with_phases_held(here.motion, self.plan, held), math.inf, FIRST_REACH)
            here = self._minimised(here, program, True)
            motion, off = settled(without_idle(here.motion))
            if off >= _ARRIVED:
                return []
            most = self.plan.swimmer.max_bend_rad
            motion, off, report = within_bends(motion, off, lambda one: self._judged(made(one)), most)
            if report.kept and off < _ARRIVED:
                self._consider(made(motion))
                return [dataclasses.replace(here, motion=motion)]
            broken = _held_phases(report)
            if broken <= held:
                return []
        return []

    def _minimised(self, here: Found, program: Maker, last: bool, part: float = 1.0) -> Found:
        """Return a motion that costs less, found by the programs that the effort allows; its moves become fewer."""
        most, large = _ROUNDS[self.effort][last], _LARGE[self.effort][last]
        rounds = min(int(part * most), max(_LEAST_ROUNDS, int(part * large / max(len(here.motion.angles), 1))))
        fewer = last
        for k in range(0, rounds, _LEG[last]):
            motion = without_idle(here.motion)
            tried = coarser(motion) if fewer and len(motion.angles) > _FEW else motion
            found = minimised(tried, program(tried), min(rounds - k, _LEG[last]), here.reach)
            fewer = found.merit < here.merit
            here = found if fewer else dataclasses.replace(here, reach=found.reach)
        return here

    def _made(self, motion: Equations) -> Plan:
        """Return the plan that a motion is."""
        lasting = paced(motion, self.total) if self.objective == "energy" else None
        blocks = _on_the_clock(motion, self.plan.swimmer.joint_rate_rad_s, lasting)
        return dataclasses.replace(self.plan, blocks=tuple(blocks), limits=None)

    def _judged(self, made: Plan) -> LimitsReport:
        """Return how near a motion comes to its limits."""
        return check(self.plan.swimmer, self.plan.start, made.blocks, self.limits)

    def _consider(self, made: Plan) -> None:
        """Keep a motion within limits if it spends less than the best so far."""
        if self._spent(made) < self._spent(self.best):
            self.best = made

    def _spent(self, plan: Plan) -> tuple[float, float, float]:
        """Return what plans are compared by: the objective, time, joint travel."""
        swimmer, blocks = played_at_pace(plan.swimmer, plan.start.shape, plan.blocks)
        spent = cost(self.objective, swimmer, plan.blocks if self.objective == "travel" else blocks, plan.start.shape)
        return spent, cost("time", swimmer, blocks, plan.start.shape), plan.joint_travel_rad


def _held_phases(report: LimitsReport) -> set[int]:
    """Return which of phases 1 and 3 break a limit; bends come within theirs when the motion is settled."""
    return {v.phase for v in report.violations if v.phase != 2 and v.limit != "bend"}


def _on_the_clock(motion: Equations, rate_rad_s: float, lasting: Array | None = None) -> list[Block]:
    """Return the motion as blocks, its durations rounded up to the clock; the turns stay as they are.

    Args:
        motion: The motion.
        rate_rad_s: The joints' rate [rad/s].
        lasting: How long each move lasts, at a joint rate of 1 rad/s; as short as it can where it is not given [s].
    """
    counts = np.cumsum([len(segment.turn) for segment in motion.segments])[:-1]
    turns = np.concatenate([segment.turn for segment in motion.segments])
    vectors = np.split(rotation_vectors(motion.swimmer, motion.start, turns), counts)
    each = np.max(np.abs(turns), axis=1) if lasting is None else lasting
    step = clock_step(1.01 * float(matmul(motion.cycles, each)) / rate_rad_s) * rate_rad_s
    out: list[Block] = []
    for segment, vector, own in zip(motion.segments, vectors, np.split(each, counts), strict=True):
        ((name, amplitude, _),) = segment.strokes
        gait = TOGETHER if segment.phase == 2 and segment.cycles == 1 else name
        amplitude = amplitude if segment.cycles > 1 else math.nan
        felt = (np.max(np.abs(segment.turn), axis=1) > _UNFELT_RAD) | (segment.cycles > 1)
        moves = _ticking(vector[felt], segment.turn[felt], own[felt], step)
        block = Block(segment.phase, gait, moves, segment.cycles, amplitude)
        if out and block.cycles == out[-1].cycles == 1 and block.phase == out[-1].phase:
            block = Block(segment.phase, gait, joined([out.pop().sequence, block.sequence]))
        out.append(block)
    return [block for block in out if len(block.sequence)]


def _ticking(vector: Array, turn: Array, lasting: Array, step: float) -> MoveSequence:
    ticks = np.maximum(np.ceil(lasting / step), 1.0)
    rate, joint_rate = (np.clip(each / (ticks * step)[:, None], -1.0, 1.0) for each in (vector, turn))
    return MoveSequence(rate, ticks * step, joint_rate)
