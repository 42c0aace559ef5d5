"""From a query to its plan: what is asked is checked, the search is begun, and what it finds is carried out."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from purcell_cli.errors import ParameterError, refuse_types
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.gaits.gait import Gait
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import Controls, Effort, Objective, PlanOptions
from purcell_cli.motion.plan import Blocked, Plan
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.effort import LEG
from purcell_cli.planner.gait_sequence import unfit_gaits
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.query import refuse_query
from purcell_cli.solution import Solution, carried_out

_DEAR = 1.5
"""Where a way round obstacles takes more than so many times what the way through them does, one in a plane is tried."""


def plan(
    start: Configuration,
    goal: Configuration,
    *,
    swimmer: Swimmer | None = None,
    options: PlanOptions = PlanOptions(),
    gaits: Mapping[str, Gait] | None = None,
    progress: Progress = silent,
) -> Solution:
    """Plan a motion from a start to a goal configuration, and check it.

    Args:
        start: The start configuration.
        goal: The goal configuration.
        swimmer: The swimmer; the paper's where none is given.
        options: What is asked of the plan besides. A plan with `Controls.SIMULTANEOUS` is one of primitives made
            quicker, where that is found how.
        gaits: The stored gaits to plan with; those of the package where none are given. One that is not pure is left
            out, which the plan says.
        progress: Is told how far the search is.

    Raises:
        ParameterError: An argument of another type.
        ParameterError: A start or goal that does not keep the clearance.
        ParameterError: A coordinate of the start or the goal too large to be said exactly.
        ParameterError: A motion that takes too much memory.
        ParameterError: A start, a goal or an option that the swimmer's joints do not allow.
        GaitError: No stored gait for a motion that is needed.
    """
    body = swimmer or Swimmer()
    refuse_types(
        start=(start, Configuration),
        goal=(goal, Configuration),
        swimmer=(body, Swimmer),
        options=(options, PlanOptions),
    )
    if gaits is not None:
        refuse_types(gaits=(gaits, Mapping))
    efforts = [options.effort]
    if options.controls == Controls.SIMULTANEOUS and options.effort == Effort.THOROUGH:
        efforts.insert(0, Effort.STANDARD)  # so that it is never worse
    tried = []
    for effort in efforts:
        asked = dataclasses.replace(options, effort=effort)
        made = planned(start, goal, swimmer=body, options=asked, gaits=gaits, progress=progress)
        tried.append(carried_out(made, options))

    def rank(one: Solution) -> tuple[bool, float]:
        spent = cost(options.objective, *one.paced, start.shape)
        return one.verdict != Verdict.REACHED, spent

    return tried[0] if len(tried) == 1 else min(tried, key=rank)


def planned(
    start: Configuration,
    goal: Configuration,
    *,
    swimmer: Swimmer | None = None,
    options: PlanOptions = PlanOptions(),
    gaits: Mapping[str, Gait] | None = None,
    progress: Progress = silent,
    clock_s: float = 0.0,
    effort: str = "",
) -> Plan:
    """Return the plan of a motion, not yet carried out; arguments and errors as of `plan`.

    As part of a longer motion its times are multiples of the step of that one's clock, `clock_s` [s]. Its effort may be
    another than the options', one of `planner.effort.EFFORTS`.
    """
    stored = stored_gaits() if gaits is None else gaits
    body, limits = swimmer or Swimmer(), dataclasses.replace(Limits.of(options), clock_s=clock_s)
    refuse_query(start, goal, body, options)
    if body.fluid == "beads":
        from purcell_cli.mechanics.bead_table import bead_tables

        bead_tables(body, lambda done, of: progress(done, of, "table of the links' drag, once for this swimmer"))
    packaged = stored_gaits()
    left_out = unfit_gaits([gait for name, gait in stored.items() if packaged.get(name) is not gait], body)
    stored = {**stored, **{name: packaged[name] for name in left_out if name in packaged}}
    stored = {name: gait for name, gait in stored.items() if name not in left_out or name in packaged}
    rolls = QuarterRolls.least(start, goal) if body.ball_joints else QuarterRolls()
    seen = rolls.seen(start), rolls.seen(goal)
    simultaneous = options.controls == Controls.SIMULTANEOUS
    if simultaneous and options.objective == Objective.SENSITIVITY:
        raise ParameterError("minimize: sensitivity goes with the controls primitive, found simultaneous")
    # One after the other, joints spend as much time as they travel; of simultaneous plans each is made from such a one.
    weighed = Objective.TRAVEL if options.objective == Objective.TIME else options.objective
    made = _reconfigured(body, *seen, stored, effort, weighed, limits, options, progress)
    made = dataclasses.replace(made, left_out=left_out)
    if simultaneous:
        from purcell_cli.planner.refine.simultaneous import quickened

        made = quickened(made, limits, options.objective, options.effort)
    return rolls.played(made, start, goal)


def _reconfigured(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    gaits: Mapping[str, Gait],
    effort: str,
    minimize: str,
    limits: Limits,
    options: PlanOptions,
    progress: Progress,
) -> Plan:
    """Return a plan: the one that knows no obstacles where it is clear of them, else one round them if any is found.

    Ways round them are looked for as long as the options' effort says, whatever that of a single plan.
    """
    effort = effort or options.effort
    if limits.obstacles is None:
        return reconfigure(swimmer, start, goal, gaits, effort, minimize, limits, progress)
    from purcell_cli.planner.routes.around import around
    from purcell_cli.planner.routes.flat import on_hinges

    direct = reconfigure(swimmer, start, goal, gaits, effort, minimize, limits, progress, ())
    if not direct.blocks or (direct.limits is not None and direct.limits.kept):
        return direct

    def searched(body: Swimmer) -> Plan | Blocked:
        def leg(begin: Configuration, end: Configuration, bend_rad: float) -> Plan:
            careful = dataclasses.replace(body, max_bend_rad=min(bend_rad, body.max_bend_rad))
            try:
                return reconfigure(careful, begin, end, gaits, LEG, minimize, limits, silent, ())
            except ParameterError:  # such small bends take too many primitives
                return Plan(careful, begin, end, ())

        return around(body, start, goal, limits, leg, options.seed, options.effort, progress)

    found = searched(swimmer)
    if isinstance(found, Blocked) or found.joint_travel_rad > _DEAR * direct.joint_travel_rad:
        flat = on_hinges(swimmer, start, goal, limits)
        other = found if flat is None else searched(flat)
        if isinstance(other, Plan) and (isinstance(found, Blocked) or other.joint_travel_rad < found.joint_travel_rad):
            found = dataclasses.replace(other, swimmer=swimmer)
    return dataclasses.replace(direct, blocked=found) if isinstance(found, Blocked) else found
