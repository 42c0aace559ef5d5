"""Exploration: refines the candidates of a stage, the best of them further, and tries random plans."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Structure
from purcell_cli.planner.candidate import Candidate, joint_travel_rad, primitives_of
from purcell_cli.planner.effort import Stage
from purcell_cli.planner.incumbent import Contender, Incumbent
from purcell_cli.planner.library.random_plans import brought, random_plans
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.refine.minimum_travel import tightened
from purcell_cli.planner.refine.segments import free_primitives, segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Near, Refinement, cycles_apart
from purcell_cli.planner.structures import StructureRecord

_RANDOM_PLAN_RAD = 25.0
"""Random plans are tried where phase 2 takes less joint travel than this [rad]."""
_RIVAL = 1.1
"""Candidates estimated at less than so many times the joint travel of the best plan rival it."""
_SHORTER = 0.99
"""Candidates estimated at less than so many times the joint travel of the best plan are refined, however long."""
_FAR_LESS = 0.5
"""A candidate estimated at less than this part of the best plan's joint travel is tried though it may not arrive."""
_ARRIVED = 1e-3
"""Random plans that miss the goal by less than this are optimised [L, rad]."""
_REFINED = 4
"""So many of the shortest random plans are refined further."""
_PROMISING = 1.06
"""Random plans of less than so many times the joint travel of the best plan are refined further."""
_WITHIN_REACH = 1.08
"""Optimised motions are optimised further if they take less than so many times the best plan's joint travel."""
_FAR_MORE = 1.55
"""Motions of more than so many times the joint travel of the best plan are not optimised: it does not become less."""


def _any_size(_primitives: int, _travel_rad: float) -> None:
    """Refuse nothing."""


@frozen_dataclass(eq=False)
class Exploration:
    """What the stages of one search share.

    Attributes:
        query: The equations of the query, without a motion.
        refinement: How motions are refined.
        incumbent: The best plan so far.
        record: The structures of the motions so far.
        progress: Is told how far the search is.
        refused: Says why a motion of so many primitives, or moves, and so much joint travel [rad] is too large.
        left_out: The primitives and the joint travel of candidates that are, and were left out.
    """

    query: Equations
    refinement: Refinement
    incumbent: Incumbent = dataclasses.field(default_factory=Incumbent)
    record: StructureRecord = dataclasses.field(default_factory=StructureRecord)
    progress: Progress = silent
    refused: Callable[[int, float], ParameterError | None] = _any_size
    left_out: list[tuple[int, float]] = dataclasses.field(default_factory=list)

    def take(self, other: Exploration) -> None:
        """Let the best plan of a search for another objective contend."""
        best = other.incumbent.best
        if best is not None:
            self.incumbent.consider(dataclasses.replace(best, cost=self.refinement.cost(best.motion)))
            self.record.near(best.words, best.motion.joint_travel_rad, best.fault)

    def explore(self, stage: Stage, candidates: Sequence[Candidate]) -> None:
        """Refine candidates, the best first: as many as the stage asks for, and more until one arrives in limits."""
        shorter: list[tuple[Equations, str]] = []
        known: set[tuple[str, int, float]] = set()
        done = 0
        for candidate in candidates:
            until_rad = stage.longest_rad if shorter else math.inf
            if done >= stage.candidates and self.incumbent.good and not self._rivals(stage, candidate, done, until_rad):
                continue
            blocks = self._new(candidate, known)
            if not blocks:
                continue
            known_near = self.refinement.near(self.query.of(segments_of(blocks)))
            near = known_near.motion
            done += 1
            if stage.interrupt_keeps_best:
                self._contend(known_near, candidate.words)
            self._tell(stage, done)
            far_more = near.joint_travel_rad > _FAR_MORE * self.incumbent.joint_travel_rad
            hopeless = bool(stage.rungs and shorter) and far_more
            if (pace := stage.pace_of(near.joint_travel_rad)) is not None and not hopeless:
                apart = near.of(segments_of(cycles_apart(near, stage.most_apart)))
                if free_primitives(apart.segments) <= stage.largest:
                    words = f"{candidate.words}, refined"
                    shorter.append((self.consider(self.refinement.shorter(apart, pace), words), words))
            if not stage.interrupt_keeps_best:
                self._contend(known_near, candidate.words)
        self._further(stage, shorter, done)
        self._random_plans(stage)

    def _further(self, stage: Stage, shorter: list[tuple[Equations, str]], done: int) -> None:
        """Optimise the shortest motions of a stage further, rung by rung, those that may still become the plan.

        Args:
            stage: The stage.
            shorter: The motions that were optimised, and what they are made of.
            done: How many are refined by now.
        """
        for count, pace in stage.rungs:
            shorter.sort(key=lambda one: round(one[0].joint_travel_rad, 9))
            further = shorter[:count]
            shorter = []
            for motion, words in further:
                done += 1
                if shorter and motion.joint_travel_rad > _WITHIN_REACH * self.incumbent.joint_travel_rad:
                    continue
                shorter.append((self.consider(self.refinement.shorter(motion, pace), words), words))
                self._tell(stage, done)

    def _new(self, candidate: Candidate, known: set[tuple[str, int, float]]) -> Sequence[Block]:
        """Return a candidate's strokes; none where there are none, they are too large, or one alike is known."""
        blocks = candidate.make()
        if not blocks:
            return ()
        size = primitives_of(blocks), joint_travel_rad(blocks)
        if self.refused(*size) is not None:
            self.left_out.append(size)
            return ()
        alike = candidate.words, size[0], round(size[1], 6)  # but for what is mirrored
        if alike in known:
            return ()
        known.add(alike)
        self.record.made(candidate, size[1])
        return blocks

    def _rivals(self, stage: Stage, candidate: Candidate, done: int, until_rad: float) -> bool:
        """Return whether a candidate is refined too: hardly longer than the best plan and short, or shorter than it.

        Args:
            stage: The stage.
            candidate: The candidate.
            done: How many are refined by now.
            until_rad: Less joint travel is short; all is where none was optimised by now [rad].
        """
        best, estimate = self.incumbent.joint_travel_rad, candidate.estimate_rad
        enough = stage.candidates + stage.rivals
        if done < enough and estimate < max(min(_RIVAL * best, until_rad), _SHORTER * best):
            return True
        return done <= enough and candidate.astray and estimate < _FAR_LESS * best

    def consider(self, motion: Equations, words: str) -> Equations:
        """Bring a motion to the goal, let it contend for the plan, and return it nearly there.

        Args:
            motion: The motion.
            words: What it is made of.
        """
        return self._contend(self.refinement.near(motion), words)

    def _contend(self, near: Near, words: str) -> Equations:
        """Bring a motion that is near the goal there, let it contend for the plan, and return it nearly there."""
        if near.close:
            fault = ""
            if not (self.incumbent.good and self.incumbent.beats(self.refinement.cost(near.motion))):
                contender = self.refinement.contender(near, words)
                if not contender.arrives and (other := self.refinement.richer(near)).close:
                    contender = min(contender, self.refinement.contender(other, words), key=lambda one: one.rank)
                self.incumbent.consider(contender)
                fault = contender.fault
            self.record.near(words, near.motion.joint_travel_rad, fault)
        elif self.incumbent.best is None:
            self.incumbent.consider(Contender(near.motion, "", near.off))
        return near.motion

    def structures(self, candidates: Sequence[Candidate]) -> tuple[Structure, ...]:
        """Return all structures so far, the structure of the best plan first.

        Args:
            candidates: The candidates of the last stage, the best first.
        """
        best = self.incumbent.best
        taken = Structure("" if best is None else best.words, self.incumbent.joint_travel_rad)
        return self.record.structures(taken, candidates, self.refinement.objective)

    def _random_plans(self, stage: Stage) -> None:
        """Try random plans in place of a phase 2 that takes little joint travel, but more than phases 1 and 3."""
        best, pace = self.incumbent.best, stage.pace
        if best is None or pace is None:
            return
        outer = [s for s in best.motion.segments if s.phase != 2]
        rest = sum(s.joint_travel_rad for s in outer)
        inner = best.motion.joint_travel_rad - rest
        bend, clearance = self.refinement.bend_rad, self.refinement.clearance
        found: list[Equations] = []
        for k, plan in enumerate(random_plans(stage.random_plans if rest < inner < _RANDOM_PLAN_RAD else 0)):
            parts = [s for s in outer if s.phase == 1] + [plan] + [s for s in outer if s.phase == 3]
            near, off = brought(self.query.of(parts), bend)
            if off < _ARRIVED:
                found.append(tightened(near, bend, pace, clearance))
            self._tell(stage, stage.trials - stage.random_plans + k + 1)
        found.sort(key=lambda motion: round(motion.joint_travel_rad, 9))
        for motion in found[:_REFINED]:
            if motion.joint_travel_rad < _PROMISING * self.incumbent.joint_travel_rad:
                longer = stage.rungs[0][1] if stage.rungs else pace
                self.consider(self.refinement.shorter(motion, longer), "a random short plan, refined")

    def _tell(self, stage: Stage, done: int) -> None:
        best = self.incumbent.joint_travel_rad
        self.progress(done, stage.trials, f"joint travel {best:.2f} rad" if math.isfinite(best) else "no plan yet")
