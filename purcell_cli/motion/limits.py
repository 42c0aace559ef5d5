"""The limits that a plan keeps over its whole path, and the check that it does.

Limbs keep clear of each other, no limb bends too far or leaves its joint's ranges, and all links stay in
their workspace and touch no obstacle. All hold at every instant, not only where moves begin and end. In
phase 2 the bend limit is the swimmer's; in phases 1 and 3 a limb may also bend as far as it does at the start, or at
the goal.
"""

from __future__ import annotations

import dataclasses
import math

from purcell_cli.environment.scene import Scene
from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import refuse_shape
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import LIMBS, Clearance, body_distance, limb_distance
from purcell_cli.motion.clearance import TOLERANCE_L as CLEARANCE_SLACK_L
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.memory import DEFAULT_GB, budget_gb, too_huge, too_many_rows
from purcell_cli.motion.mission import Follow
from purcell_cli.motion.obstacle_distance import Encounter, refuse_touching
from purcell_cli.motion.off_curve import OffCurve
from purcell_cli.motion.options import OPTIONS, PlanOptions
from purcell_cli.motion.workspace import ENDS, WALLS, Excess, Workspace, excess_of
from purcell_cli.motion.workspace import TOLERANCE_L as WORKSPACE_SLACK_L

BEND_MARGIN_RAD = 2e-4
"""Loops are planned to bend this much less than the limit, which is left to the exact arrival [rad].

A stroke that comes as near the limit as that is at it."""

_LEFT = 0.5
"""At least this part of a motion's joint travel is taken to be left by refinement, which seldom saves a third."""


@frozen_dataclass
class Limits:
    """What a plan must keep besides the swimmer's bend limit.

    Attributes:
        clearance_m: How far the surfaces of limb 1, limb 2 and the body stay apart, at least [m].
        workspace: The box that all links stay in, if there is one.
        obstacles: What no link may touch, if there is anything; the clearance counts for it too.
        follow: The curve that the base's middle stays near, if there is one.
        max_memory_gb: The memory that the motion may take; see `memory.budget_gb` [GB].
        dt_s: The longest time between rows of the trajectory, of which there may not be too many [s].
        clock_s: The step of the clock of a longer motion that this one is part of [s]; 0 where it is alone.

    Raises:
        ParameterError: A clearance that is negative or not finite.
    """

    clearance_m: float = 0.0
    workspace: Workspace | None = None
    obstacles: Scene | None = None
    follow: Follow | None = None
    max_memory_gb: float = DEFAULT_GB
    dt_s: float = dataclasses.field(default=math.inf, compare=False)
    clock_s: float = dataclasses.field(default=0.0, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "clearance_m", OPTIONS["clearance_m"].checked(self.clearance_m, "clearance_m"))

    @classmethod
    def of(cls, options: PlanOptions, follow: Follow | None = None) -> Limits:
        """Return the limits that options ask for, and a curve to follow."""
        most = options.max_memory_gb, options.dt_s
        return cls(options.clearance_m, options.workspace, options.obstacles, follow, *most)

    def too_large(self, swimmer: Swimmer, primitives: int, travel_rad: float) -> ParameterError | None:
        """Return why a motion that is not refined yet is too large: where even half of its rows are too many.

        Args:
            swimmer: The swimmer.
            primitives: How many primitives or moves are played.
            travel_rad: The joint travel, or an estimate of it [rad].
        """
        found_gb, seconds = budget_gb(self.max_memory_gb), travel_rad / swimmer.joint_rate_rad_s

        def of(seconds: float) -> ParameterError | None:
            rows = too_many_rows(seconds, self.dt_s) or too_huge(primitives, seconds / self.dt_s, found_gb)
            return too_huge(primitives, 0.0, found_gb) or rows

        return of(_LEFT * seconds) and of(seconds)

    def refuse(self, swimmer: Swimmer, name: str, configuration: Configuration) -> None:
        """Refuse a start or goal at which the limbs are too near each other, or a link is outside the workspace.

        Args:
            swimmer: The swimmer.
            name: What the configuration is, for the message.
            configuration: The configuration.

        Raises:
            ParameterError: The limbs are nearer than they may be, or a link stands out of the workspace.
            ParameterError: A link touches an obstacle, or is nearer to one than the clearance.
            ParameterError: A shape that the joints cannot make.
        """
        refuse_shape(swimmer, name, configuration)
        axes = configuration.shape[..., 0]
        body = body_distance(swimmer, bends(axes))
        for between, distance in (
            (LIMBS, limb_distance(swimmer, axes)),
            *((f"limb {k + 1} and the body", body[k]) for k in (0, 1)),
        ):
            found = float(distance)
            if found < self.clearance_m - CLEARANCE_SLACK_L * swimmer.length_m:
                raise ParameterError(
                    f"{name}: a clearance of at least {self.clearance_m:g} m between {between} is wanted, "
                    f"found {found:.6g} m{' (they overlap)' if found < 0.0 else ''}"
                )
        if self.obstacles is not None:
            refuse_touching(swimmer, self.obstacles, self.clearance_m, name, configuration)
        if self.workspace is None:
            return
        out = excess_of(swimmer, self.workspace, configuration.pose, configuration.shape)
        if out.distance_m > WORKSPACE_SLACK_L * swimmer.length_m:
            raise ParameterError(
                f"{name}: all links inside the workspace are wanted, "
                f"found the {ENDS[out.end]} {out.distance_m:.6g} m beyond the {WALLS[out.wall]}"
            )


@frozen_dataclass
class Violation:
    """A limit that a motion breaks, where it breaks it most.

    Attributes:
        limit: "clearance", "bend", "joint", "range", "workspace", "obstacle" or "follow".
        excess: By how much, in `unit`.
        unit: "m" or "rad".
        time_s: When [s].
        phase: In which phase of the reconfiguration.
        what: What breaks it, in words.
    """

    limit: str
    excess: float
    unit: str
    time_s: float
    phase: int
    what: str


@frozen_dataclass
class LimitsReport:
    """How near a motion comes to its limits.

    Attributes:
        limits: The limits.
        clearance: The least distance of the limbs, on which piece and when.
        largest_bend_rad: The largest bend of a limb in phases 1, 2 and 3; None where nothing moves [rad].
        workspace: How far links leave their workspace, if there is one.
        violations: The limits that are broken.
        obstacle: How near links come to obstacles, if there are any.
        off_curve: How far the base's middle is from the curve that it follows, if there is one.
    """

    limits: Limits
    clearance: Clearance
    largest_bend_rad: tuple[float | None, float | None, float | None]
    workspace: Excess | None
    violations: tuple[Violation, ...]
    obstacle: Encounter | None = None
    off_curve: OffCurve | None = None

    @property
    def kept(self) -> bool:
        """Whether every limit is kept over the whole path."""
        return not self.violations
