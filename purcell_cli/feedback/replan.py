"""The rest of a plan from a measured configuration: by the plan's own strokes, or else by a plan of its own."""

from __future__ import annotations

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.pace import paced
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.rest import of_primitives, rest
from purcell_cli.planning import plan
from purcell_cli.query import refuse_query
from purcell_cli.solution import Solution, carried_out


@frozen_dataclass(eq=False)
class Replanned:
    """The rest of a plan.

    Attributes:
        solution: The rest, carried out and checked.
        kept: Whether it is made of the plan's own strokes.
        off: How far from the plan's way the configuration was measured to be [L, rad]; None where nobody looks.
        done_rad: The plan's joint travel up to where that is nearest, or what was said to be made [rad].
        left_rad: The plan's joint travel from there on [rad].
    """

    solution: Solution
    kept: bool
    off: float | None = None
    done_rad: float = 0.0
    left_rad: float = 0.0


def replan(
    way: PlanPath,
    measured: Configuration,
    options: PlanOptions = PlanOptions(),
    *,
    goal: Configuration | None = None,
    after_rad: float = 0.0,
    progress: Progress = silent,
) -> Replanned:
    """Return the rest of a plan from where the swimmer was measured to be.

    The strokes up to the place of the way that is nearest are left out. Those that remain are brought to the goal by
    Newton's method; where they do not arrive within limits, or only by a long way, it is planned anew.

    Args:
        way: The plan's way; it is made once for many calls, see `PlanPath.of`.
        measured: Where the swimmer is.
        options: What was asked of the plan.
        goal: Where it is to end; the plan's goal where none is given.
        after_rad: The plan's joint travel that is made, at least [rad].
        progress: Is told how far a whole plan's search is.

    Raises:
        ParameterError: See `planning.plan`.
    """
    swimmer, aim = way.plan.swimmer, goal or way.plan.goal
    refuse_query(measured, aim, swimmer, options, "measured")
    place, off = way.nearest(measured, aim, after_rad)
    left = float(way.travel_rad[place])
    figures = off, float(way.travel_rad[0]) - left, left
    found = rest(way, place, measured, aim, Limits.of(options))
    solution = None if found is None else carried_out(found, options)
    if solution is not None and solution.verdict == Verdict.REACHED:
        return Replanned(solution, True, *figures)
    whole = plan(measured, aim, swimmer=swimmer, options=options, progress=progress)
    return Replanned(whole, False, *figures)


def way_of(made: Plan) -> PlanPath | None:
    """Return the way of a plan whose strokes can be brought to a goal anew: of primitives, and not none."""
    return PlanPath.of(made) if made.blocks and of_primitives(made) else None


_SHOWN_S = 5e-4
"""Durations are shown to a millisecond: a time beyond a plan's end by no more than this is its end [s]."""


def refuse_time(made: Plan, time_s: float) -> None:
    """Refuse a time that a plan does not have.

    Args:
        made: The plan.
        time_s: The time since it began [s].

    Raises:
        ParameterError: A time before the plan begins or after it has ended, or no number.
    """
    swimmer, blocks = paced(made.swimmer, made.start.shape, made.blocks)
    lasts = sum(block.duration for block in blocks) / swimmer.joint_rate_rad_s
    if not 0.0 <= time_s <= lasts + _SHOWN_S:
        raise ParameterError(f"after: a time from 0 s to {lasts:.3f} s, the plan's end, is wanted, found {time_s!r}")


def done_by(made: Plan, time_s: float) -> float:
    """Return the joint travel that a plan has made by a time, as even within each stroke [rad].

    Args:
        made: The plan.
        time_s: The time since it began [s].
    """
    return float(done_at(made, np.array([time_s]))[0])


def done_at(made: Plan, time_s: Array) -> Array:
    """Return the joint travel that a plan has made at each of many times, see `done_by` [rad]. Shape (n,) to (n,)."""
    swimmer, blocks = paced(made.swimmer, made.start.shape, made.blocks)
    left, done = time_s, np.zeros_like(time_s)
    for block, played in zip(made.blocks, blocks, strict=True):
        lasts = played.duration / swimmer.joint_rate_rad_s
        done = done + block.joint_travel_rad * (np.minimum(left / lasts, 1.0) if lasts > 0.0 else 1.0)
        left = np.maximum(left - lasts, 0.0)
    return done
