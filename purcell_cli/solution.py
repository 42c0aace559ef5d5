"""A plan carried out: the motion, its trajectory, its costs and its certificate."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from purcell_cli.errors import ParameterError, UnknownNameError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements, energies, starting_shapes
from purcell_cli.motion.limits import Limits, LimitsReport, check
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import Trajectory, sample, schedule, spacing
from purcell_cli.motion.workspace import Workspace
from purcell_cli.planner.progress import Progress
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.planner.refine.simultaneous import quickened
from purcell_cli.verification.certificate import Certificate, certify

CONTROLS = ("primitive", "simultaneous")
"""How a plan may turn the joints: one at a time, or all six at once."""

FARTHEST_L = 1e9
"""A goal farther from the start than this, in units of L, is refused: no double says its position to a thousandth."""


@dataclasses.dataclass(frozen=True, eq=False)
class Solution:
    """A plan with everything that is known about it; rows, energies and the like are computed when first asked for.

    Attributes:
        plan: The strokes of the three phases.
        dt_s: Longest time between rows of the trajectory [s].
        certificate: What an independent re-integration of the controls found.
        limits: How near the motion comes to its limits, and which it breaks.
    """

    plan: Plan
    dt_s: float
    certificate: Certificate
    limits: LimitsReport

    @functools.cached_property
    def displacement(self) -> Array:
        """Body displacement of each block of the plan [m]. Shape (n, 4, 4)."""
        return block_displacements(self.plan.swimmer, self.plan.blocks, self.plan.start.shape)

    @property
    def deviation(self) -> Deviation:
        """How far the planner's own flow ends from the goal."""
        start = self.plan.start
        shape = starting_shapes(self.plan.blocks, start.shape)[-1]
        pose = se3.normalised(matmul(start.pose, se3.prefix_products(self.displacement)[-1]))
        return Deviation.between(Configuration(pose, shape), self.plan.goal)

    @functools.cached_property
    def trajectory(self) -> Trajectory:
        """The sampled motion."""
        return sample(self.plan.swimmer, self.plan.start, self.plan.blocks, self.dt_s)

    @functools.cached_property
    def energy_j(self) -> Array:
        """Energy dissipated in each block [J]. Shape (n,)."""
        return energies(self.plan.swimmer, self.plan.blocks, self.plan.start.shape)

    @property
    def verdict(self) -> str:
        """'reached' where the certificate says so and all limits are kept, or what it is instead."""
        if not self.limits.kept:
            return "not found within limits"
        return "reached" if self.certificate.reached else "not reached"

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all primitives of |angle|, or over all moves and joints [rad]."""
        return self.plan.joint_travel_rad

    @property
    def duration_s(self) -> float:
        """How long the motion takes [s]."""
        return sum(b.duration for b in self.plan.blocks) / self.plan.swimmer.joint_rate_rad_s

    @property
    def controls(self) -> str:
        """One of `CONTROLS`: whether joints turn one after the other or at once."""
        one_by_one = all(isinstance(b.sequence, PrimitiveSequence) for b in self.plan.blocks)
        return "primitive" if one_by_one else "simultaneous"

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
    swimmer: Swimmer | None = None,
    gaits: Mapping[str, Gait] | None = None,
    dt_s: float = 0.05,
    effort: str = "standard",
    controls: str = "primitive",
    minimize: str = "travel",
    clearance_m: float = 0.0,
    workspace: Workspace | None = None,
    progress: Progress = lambda _done, _of, _news: None,
    certifying: Callable[..., Certificate] = certify,
) -> Solution:
    """Plan a motion from a start to a goal configuration, and check it.

    Args:
        start: The start configuration.
        goal: The goal configuration.
        swimmer: The swimmer; the paper's where none is given.
        gaits: The stored gaits to plan with; those of the package where none are given.
        dt_s: Longest time between rows of the trajectory [s].
        effort: "quick", "standard", or "thorough" to look longer for a shorter plan.
        controls: One of `CONTROLS`: "primitive" turns one joint at a time; "simultaneous" makes that plan
            quicker by turning all six at once, where it finds how.
        minimize: What to spend least of: "travel" (of the joints), "energy" or "switches" (of control).
        clearance_m: How far the surfaces of limb 1 and limb 2 stay apart over the whole path, at least [m].
        workspace: A box that all three links stay in over the whole path.
        progress: Is told how far the search is.
        certifying: Does what `certify` does, perhaps elsewhere.

    Raises:
        ParameterError: A clearance that is none, or a start or goal that does not keep it.
        ParameterError: A goal farther from the start than `FARTHEST_L`.
        ParameterError: A time between rows that is not positive, or that asks for too many rows.
        GaitError: No stored gait for a motion that is needed.
        UnknownNameError: No controls or effort have this name.
    """
    if controls not in CONTROLS:
        raise UnknownNameError(f"controls: one of {', '.join(CONTROLS)} is wanted, found {controls!r}")
    stored = stored_gaits() if gaits is None else gaits
    body, limits = swimmer or Swimmer(), Limits(clearance_m, workspace)
    for name, configuration in (("start", start), ("goal", goal)):
        limits.refuse(body, name, configuration)
    if (away := math.dist(start.pose[:3, 3], goal.pose[:3, 3])) > FARTHEST_L * body.length_m:
        farthest = FARTHEST_L * body.length_m
        raise ParameterError(f"goal: a position within {farthest:g} m of the start is wanted, found {away:g} m")
    made = reconfigure(body, start, goal, stored, effort, minimize, limits, progress)
    made = quickened(made, limits) if controls == "simultaneous" else made
    return carried_out(made, dt_s, limits, certifying)


def carried_out(
    plan: Plan,
    dt_s: float = 0.05,
    limits: Limits | None = None,
    certifying: Callable[..., Certificate] = certify,
) -> Solution:
    """Carry out a plan, new or read from a document, and check it.

    Args:
        plan: The plan.
        dt_s: Longest time between rows of the trajectory [s].
        limits: What it must keep besides the bend limit; where none are given, the limbs may touch.
        certifying: Does what `certify` does, perhaps elsewhere.

    Raises:
        ParameterError: A time between rows that is not positive, or that asks for too many rows.
    """
    swimmer, start, goal, blocks = plan.swimmer, plan.start, plan.goal, plan.blocks
    wanted = limits or Limits()
    known = plan.limits
    return Solution(
        plan,
        spacing(swimmer, blocks, dt_s),
        certifying(swimmer, start, goal, *schedule(swimmer, blocks)),
        known if known is not None and known.limits == wanted else check(swimmer, start, blocks, wanted),
    )


def stroke_cycles(blocks: Sequence[Block]) -> int:
    """Return how many cycles the blocks of one stroke have; the shorter ones lead into and out of it."""
    longest = max(len(b.sequence) for b in blocks)
    return sum(b.cycles for b in blocks if len(b.sequence) == longest)


def phase_displacement(solution: Solution, phase: int) -> Array:
    """Return the body displacement made in one phase [m]. Shape (4, 4)."""
    inside = [k for k, block in enumerate(solution.plan.blocks) if block.phase == phase]
    return se3.prefix_products(solution.displacement[inside])[-1] if inside else np.eye(4)
