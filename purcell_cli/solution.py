"""A plan carried out: the motion, its trajectory, its costs and its certificate."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.frozen_dataclass import frozen_dataclass
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
from purcell_cli.motion.options import Controls, PlanOptions
from purcell_cli.motion.pace import paced
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import Trajectory, sample, schedule
from purcell_cli.motion.verdict import PlanVerdict, Verdict
from purcell_cli.planner.arcs.primitive_counts import advice
from purcell_cli.planner.candidate import primitives_of
from purcell_cli.verification.certificate import Certificate, judged
from purcell_cli.verification.replay import TOLERANCE_L, TOLERANCE_RAD, Replay, replay

_BATCH = 1 << 14
"""Rows that are compared at once: bounds the memory of a long motion."""


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
