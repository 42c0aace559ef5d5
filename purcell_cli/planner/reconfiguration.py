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
import functools
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from purcell_cli.errors import ParameterError, UnknownNameError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation, displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import apart_bend_rad
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import Objective
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.arcs.primitive_counts import LEAST_BEND_RAD, advice
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.candidates import generate, ranked
from purcell_cli.planner.effort import EFFORTS, Stage
from purcell_cli.planner.exploration import Exploration
from purcell_cli.planner.objectives import generated_for, known_measure
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Refinement, played

_THERE = 1e-14
"""A start within this of its goal needs no motion: rounding errors of equal configurations [L, rad]."""

_DIGITS = 10
"""Digits of the displacement that candidates are made for [L]; the refinement makes it exactly."""

SMALLER_BENDS = (0.6, 0.35, 0.2, 0.1)
"""Shares of the bend limit that are tried where no plan stays in the workspace; each takes some half of the room."""

_LEAST_BEND_RAD = 0.1
"""The least bend limit to which a clearance or a workspace lowers that of phase 2 [rad]: loops beyond are many."""


def reconfigure(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    gaits: Mapping[str, Gait],
    effort: str = "standard",
    minimize: str = "travel",
    limits: Limits | None = None,
    progress: Progress = silent,
    smaller_bends: Sequence[float] = SMALLER_BENDS,
) -> Plan:
    """Return a plan from a start to a goal configuration.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        gaits: The stored gaits to choose from.
        effort: One of `EFFORTS`. Interrupted, "thorough" returns the best plan so far.
        minimize: One of `objectives.MEASURES`: what to spend least of.
        limits: What the plan must keep besides the bend limit; where none is found that does, the nearest to it.
        progress: Is told how far the search is.
        smaller_bends: Shares of the bend limit that are tried where no plan stays in the workspace.

    Raises:
        GaitError: No stored gait for a motion that is needed.
        UnknownNameError: No effort or measure has this name.
        ParameterError: No candidate whose motion fits into the memory that it may take, or none for such small bends.
    """
    known_measure(minimize)
    if effort not in EFFORTS:
        raise UnknownNameError(f"effort: one of {', '.join(EFFORTS)} is wanted, found {effort!r}")
    if Deviation.between(start, goal).within(_THERE * swimmer.length_m, _THERE):
        return Plan(swimmer, start, goal, ())
    kept_to = limits or Limits()
    bend_rad = careful_bend_rad(swimmer, kept_to)

    def least(objective: str, begun: Searched | None = None) -> Searched:
        def within(bend_rad: float) -> Searched:
            careful = dataclasses.replace(swimmer, max_bend_rad=bend_rad)
            return searched(careful, start, goal, gaits, effort, objective, kept_to, progress, begun)

        found = within(bend_rad)
        for share in smaller_bends:
            if not found.search.incumbent.leaves_workspace or share * bend_rad < _LEAST_BEND_RAD:
                break
            other = within(share * bend_rad)
            if other.search.incumbent.better_than(found.search.incumbent):
                found = other
        return found

    found = least(str(Objective.TRAVEL))
    if minimize != Objective.TRAVEL and not found.interrupted:
        found = least(minimize, found)
    best = found.search.incumbent.best
    if best is None:
        _refuse_hopeless(swimmer, gaits, found.search)
    blocks = () if best is None else played(best.motion)
    structures = found.search.structures(found.candidates)
    return Plan(swimmer, start, goal, blocks, structures, None if best is None else best.report)


def _refuse_hopeless(swimmer: Swimmer, gaits: Mapping[str, Gait], search: Exploration) -> None:
    """Refuse what has no candidate, where it is known what would help.

    Args:
        swimmer: The swimmer.
        gaits: The stored gaits.
        search: The search that found none.
    """
    reason = search.refused(*min(search.left_out)) if search.left_out else None
    if reason is not None:
        raise ParameterError(f"{reason}{advice(swimmer, gaits)}")
    if not swimmer.ball_joints and swimmer.max_bend_rad < LEAST_BEND_RAD:
        raise ParameterError(
            f"max_bend_rad: strokes of these joints that reach the goal are wanted, found none within "
            f"{swimmer.max_bend_rad:g} rad (plans for other than ball joints are promised from {LEAST_BEND_RAD:g} on)"
        )


def careful_bend_rad(swimmer: Swimmer, limits: Limits) -> float:
    """Return how far limbs bend in phase 2 [rad]: it needs no bends at which they could meet."""
    return min(swimmer.max_bend_rad, max(apart_bend_rad(swimmer, limits.clearance_m), _LEAST_BEND_RAD))


@frozen_dataclass(eq=False)
class Searched:
    """A search that is over.

    Attributes:
        search: The search.
        candidates: The candidates of its last stage.
        interrupted: Whether an interrupt ended it.
    """

    search: Exploration
    candidates: list[Candidate]
    interrupted: bool = False


def searched(
    careful: Swimmer,
    start: Configuration,
    goal: Configuration,
    gaits: Mapping[str, Gait],
    effort: str,
    minimize: str,
    kept_to: Limits,
    progress: Progress = silent,
    begun: Searched | None = None,
) -> Searched:
    """Return a search that is over.

    Args:
        careful: The swimmer, whose bend limit is that of phase 2.
        start: The start configuration.
        goal: The goal configuration.
        gaits: The stored gaits to choose from.
        effort: One of `EFFORTS`.
        minimize: One of `objectives.MEASURES`.
        kept_to: What the plan must keep besides the bend limit.
        progress: Is told how far the search is.
        begun: The search for least joint travel, where something else is minimised: its plan and its candidates are
            candidates here too, and no plan of less joint travel is taken.
    """
    unit, wanted = careful.scaled(), flattened(careful, displacement_between(start, goal, careful.length_m))
    query = Equations(unit, (), start.shape, goal.shape, wanted, SEARCHING)
    clearance = kept_to.clearance_m / careful.length_m
    # Linear programs make much of rounding errors, so candidates are looked for without them, wherever the start is.
    sought = se3.normalised(np.round(wanted, _DIGITS))
    problem = Problem(unit, start.shape, goal.shape, sought, gaits, generated_for(minimize), clearance)
    refined = Refinement(careful, start, kept_to, minimize)
    search = Exploration(query, refined, progress=progress, refused=functools.partial(kept_to.too_large, careful))
    found: list[Candidate] = []
    if begun is not None:
        found = begun.candidates  # what travels least often spends least of anything else
        if begun.search.incumbent.good:
            search.incumbent.least_rad = begun.search.incumbent.joint_travel_rad
    stages, candidates = _generators(problem, wanted, effort)
    for k, stage in enumerate(stages):
        if stage.last_resort:
            if search.incumbent.arrives or (begun is not None and begun.search.incumbent.arrives):
                break
            if search.left_out and search.incumbent.best is None:
                break
            found = []  # those have all been tried
        try:
            found = candidates(k, found)
            search.explore(stage, found)
        except KeyboardInterrupt:
            if not (stage.interrupt_keeps_best and search.incumbent.good):
                raise
            return Searched(search, found, interrupted=True)
    if begun is not None:
        search.take(begun.search)
    return Searched(search, found)


def _generators(
    problem: Problem, wanted: Array, effort: str
) -> tuple[tuple[Stage, ...], Callable[[int, list[Candidate]], list[Candidate]]]:
    """Return an effort's stages, and what gives the candidates of each beside those that are known, the best first."""
    if problem.swimmer.ball_joints:
        stages = EFFORTS[effort]
        return stages, lambda k, known: ranked(problem, [*known, *generate(problem, stages[k].breadth)])
    from purcell_cli.planner.joints.candidates import joint_candidates, varied
    from purcell_cli.planner.joints.effort import JOINT_EFFORTS

    wide = JOINT_EFFORTS[effort]

    def by_joints(k: int, known: list[Candidate]) -> list[Candidate]:
        new = joint_candidates(problem.swimmer, problem.start, problem.goal, wanted, wide[k].breadth)
        return varied([*known, *new])

    return tuple(one.stage for one in wide), by_joints
