"""A plan carried out: the motion, its trajectory, its costs and its certificate."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements, energies, starting_shapes
from purcell_cli.motion.limits import Limits, LimitsReport
from purcell_cli.motion.limits_check import check_legs
from purcell_cli.motion.memory import refuse_huge, too_many_rows
from purcell_cli.motion.options import Controls, Effort, Objective, PlanOptions
from purcell_cli.motion.pace import paced
from purcell_cli.motion.plan import Blocked, Plan
from purcell_cli.motion.trajectory import Trajectory, sample, schedule
from purcell_cli.motion.verdict import PlanVerdict, Verdict
from purcell_cli.planner.arcs.primitive_counts import advice
from purcell_cli.planner.candidate import primitives_of
from purcell_cli.planner.effort import LEG
from purcell_cli.planner.gait_sequence import unfit_gaits
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.query import refuse_query
from purcell_cli.verification.certificate import Certificate, judged
from purcell_cli.verification.replay import TOLERANCE_L, TOLERANCE_RAD, Replay, replay

_BATCH = 1 << 14
"""Rows that are compared at once: bounds the memory of a long motion."""
_DEAR = 1.5
"""Where a way round obstacles takes more than so many times what the way through them does, one in a plane is tried."""


@frozen_dataclass(slots=False, eq=False)
class Solution:
    """A plan with everything that is known about it; rows, energies and the like are computed when first asked for.

    Attributes:
        plan: The strokes of the three phases.
        options: What was asked of it.
        replay: What an independent re-integration of the controls made of them.
        limits: How near the motion comes to its limits, and which it breaks.
    """

    plan: Plan
    options: PlanOptions
    replay: Replay
    limits: LimitsReport

    def __repr__(self) -> str:
        return f"<Solution: {self.verdict}, joint travel {self.joint_travel_rad:.6g} rad, {self.duration_s:.6g} s>"

    @functools.cached_property
    def certificate(self) -> Certificate:
        """How far the re-integration ends from the goal."""
        return judged(self.replay, self.plan.goal, TOLERANCE_L * self.plan.swimmer.length_m, TOLERANCE_RAD)

    @functools.cached_property
    def passed(self) -> tuple[Certificate, ...]:
        """How far the re-integration is, in what each waypoint names, from it where it is passed."""
        if not self.plan.passages:
            return ()
        _, blocks = self.paced
        rows = np.cumsum([0, *(b.cycles * np.count_nonzero(b.sequence.duration) for b in blocks)])
        length_m = self.plan.swimmer.length_m
        out = []
        for passage in self.plan.passages:
            segment = int(np.searchsorted(self.replay.row, rows[passage.block]))
            found = self.replay.until(segment)
            out.append(judged(found, passage.waypoint, TOLERANCE_L * length_m, TOLERANCE_RAD))
        return tuple(out)

    @functools.cached_property
    def rows_off(self) -> Deviation:
        """How far the trajectory's rows, where the control changes, are from the re-integration at the most."""
        rows, again = self.trajectory, self.replay
        swimmer, blocks = self.paced
        times, _ = schedule(swimmer, self.plan.start.shape, blocks)
        row = np.searchsorted(rows.time_s, times[again.row])
        pose, shape, most = again.pose, again.shape, np.zeros(4)
        for low in range(0, len(row), _BATCH):
            some = slice(low, low + _BATCH)
            k = row[some]
            away = np.sum((rows.pose[k, :3, 3] - pose[some, :3, 3]) ** 2, axis=1)
            turned = np.sum((rows.pose[k, :3, :3] - pose[some, :3, :3]) ** 2, axis=(1, 2))
            limbs = np.sum((rows.shape[k] - shape[some]) ** 2, axis=(2, 3))
            most = np.maximum(most, np.max(np.column_stack([away, 0.5 * turned, 0.5 * limbs]), axis=0))
        return Deviation(*np.sqrt(most).tolist())

    @functools.cached_property
    def displacement(self) -> Array:
        """Body displacement of each block of the plan [m]. Shape (n, 4, 4)."""
        return block_displacements(self.plan.swimmer, self.plan.blocks, self.plan.start.shape)

    @property
    def end(self) -> Configuration:
        """Where the planner's own flow ends."""
        start = self.plan.start
        shape = starting_shapes(self.plan.blocks, start.shape)[-1]
        return Configuration(se3.normalised(matmul(start.pose, se3.prefix_products(self.displacement)[-1])), shape)

    @property
    def deviation(self) -> Deviation:
        """How far the planner's own flow ends from the goal."""
        return Deviation.between(self.end, self.plan.goal)

    @functools.cached_property
    def trajectory(self) -> Trajectory:
        """The sampled motion."""
        swimmer, blocks = self.paced
        return sample(swimmer, self.plan.start, blocks, self.options.dt_s)

    @functools.cached_property
    def energy_j(self) -> Array:
        """Energy dissipated in each block [J]. Shape (n,)."""
        swimmer, blocks = self.paced
        return energies(swimmer, blocks, self.plan.start.shape)

    @property
    def verdict(self) -> PlanVerdict:
        """Reached where the certificate says so, all rows are where it says, and all limits are kept."""
        if not self.limits.kept:
            return Verdict.NOT_WITHIN_LIMITS
        found = self.certificate
        reached = found.reached and all(one.reached for one in self.passed)
        return Verdict.REACHED if reached and found.allows(self.rows_off) else Verdict.NOT_REACHED

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all primitives of |angle|, or over all moves and joints [rad]."""
        return self.plan.joint_travel_rad

    @property
    def duration_s(self) -> float:
        """How long the motion takes [s]."""
        return sum(self.durations_s)

    @property
    def durations_s(self) -> tuple[float, ...]:
        """How long each block lasts at the joints' pace [s]."""
        swimmer, blocks = self.paced
        return tuple(b.duration / swimmer.joint_rate_rad_s for b in blocks)

    @functools.cached_property
    def paced(self) -> tuple[Swimmer, tuple[Block, ...]]:
        """The plan's blocks at the joints' pace, and the swimmer whose joint rate their durations are for."""
        return paced(self.plan.swimmer, self.plan.start.shape, self.plan.blocks)

    @property
    def controls(self) -> Controls:
        """Whether joints turn one after the other or at once."""
        one_by_one = all(isinstance(b.sequence, PrimitiveSequence) for b in self.plan.blocks)
        return Controls.PRIMITIVE if one_by_one else Controls.SIMULTANEOUS

    @property
    def strokes(self) -> list[slice]:
        """Which blocks are one stroke: neighbours of the same phase, gait and amplitude."""
        out, first = [], 0
        keys = ((b.phase, b.gait, str(b.amplitude_rad)) for b in self.plan.blocks)
        for _, group in itertools.groupby(keys):
            last = first + len(list(group))
            out.append(slice(first, last))
            first = last
        return out


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
        ParameterError: A start or goal that does not keep the clearance.
        ParameterError: A coordinate of the start or the goal too large to be said exactly.
        ParameterError: A motion that takes too much memory.
        ParameterError: A start, a goal or an option that the swimmer's joints do not allow.
        GaitError: No stored gait for a motion that is needed.
    """
    efforts = [options.effort]
    if options.controls == Controls.SIMULTANEOUS and options.effort == Effort.THOROUGH:
        efforts.insert(0, Effort.STANDARD)  # so that it is never worse
    body, tried = swimmer or Swimmer(), []
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


def carried_out(plan: Plan, options: PlanOptions = PlanOptions()) -> Solution:
    """Carry out a plan, new or read from a document, and check it.

    Args:
        plan: The plan.
        options: The limits that it must keep besides the bend limit, and how its trajectory is sampled.

    Raises:
        ParameterError: A motion that takes too much memory.
    """
    start, (swimmer, blocks) = plan.start, paced(plan.swimmer, plan.start.shape, plan.blocks)
    wanted, known = Limits.of(options, plan.follow), plan.limits if blocks == plan.blocks else None
    legs = dataclasses.replace(plan, blocks=blocks).legs
    duration_s = sum(b.duration for b in blocks) / swimmer.joint_rate_rad_s
    if (found := too_many_rows(duration_s, options.dt_s)) is not None:
        raise found
    try:
        refuse_huge(primitives_of(blocks), duration_s / options.dt_s, options.max_memory_gb)
    except ParameterError as error:
        raise ParameterError(f"{error}{advice(swimmer, stored_gaits())}") from None
    return Solution(
        plan,
        options,
        replay(swimmer, start, *schedule(swimmer, start.shape, blocks), every_row=bool(plan.passages)),
        known if known is not None and known.limits == wanted else check_legs(swimmer, start, legs, wanted),
    )


def stroke_cycles(blocks: Sequence[Block]) -> int:
    """Return how many cycles the blocks of one stroke have; the shorter ones lead into and out of it."""
    longest = max(len(b.sequence) for b in blocks)
    return sum(b.cycles for b in blocks if len(b.sequence) == longest)


def phase_displacement(solution: Solution, phase: int) -> Array:
    """Return the body displacement made in one phase [m]. Shape (4, 4)."""
    inside = [k for k, block in enumerate(solution.plan.blocks) if block.phase == phase]
    return se3.prefix_products(solution.displacement[inside])[-1] if inside else np.eye(4)
