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
from collections.abc import Mapping

from purcell_cli.errors import UnknownNameError
from purcell_cli.gaits.gait import Gait
from purcell_cli.mechanics.configuration import Configuration, Deviation, displacement_between
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import apart_bend_rad
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.candidates import candidates
from purcell_cli.planner.effort import _WIDE, EFFORTS
from purcell_cli.planner.incumbent import Progress, _Best, played
from purcell_cli.planner.objectives import known_measure
from purcell_cli.planner.refine.shooting import Equations

_THERE = 1e-14
"""A start this near its goal (L, rad) is there already."""

_LEAST_BEND_RAD = 0.1
"""No bend limit is lowered further than this, whatever the clearance."""


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
