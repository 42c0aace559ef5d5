"""A plan: the motion from a start to a goal configuration."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import LimitsReport
from purcell_cli.motion.mission import Follow, Passage


@frozen_dataclass
class Structure:
    """A way to build a plan that was weighed.

    Attributes:
        words: What it does, in words.
        joint_travel_rad: Its joint travel, as estimated when it was weighed [rad].
        why_not: Why it was not taken though it has less joint travel than the one that was; else empty.
    """

    words: str
    joint_travel_rad: float
    why_not: str = ""


@frozen_dataclass
class Blocked:
    """How near to the goal a search for a way round obstacles came that found none, and what is in the way.

    Attributes:
        position_m: Where the base's middle is at the pose nearest to the goal that ways lead to [m].
        left_m: How far that is from the goal [m].
        obstacle: What is first in the way from there, by its index from 0; None for a wall of the workspace.
        words: All that, in words.
        leg: Which leg of a mission it is, from 0 on.
    """

    position_m: tuple[float, float, float]
    left_m: float
    obstacle: int | None
    words: str
    leg: int = 0


@frozen_dataclass(eq=False)
class Plan:
    """A plan: the motion from a start to a goal configuration.

    Attributes:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        blocks: The strokes of all three phases.
        structures: The structures that were weighed, best first; the first one was taken.
        limits: How near it comes to its limits, where the planner looked.
        left_out: Gaits of the user's own that could not be planned with, and why.
        passages: The waypoints that it passes, in order; each begins a leg, with phases of its own.
        follow: The curve that it follows, if there is one.
        blocked: How near the search came and what is in the way, where it found no way round obstacles.
    """

    swimmer: Swimmer
    start: Configuration
    goal: Configuration
    blocks: tuple[Block, ...]
    structures: tuple[Structure, ...] = ()
    limits: LimitsReport | None = None
    left_out: Mapping[str, str] = dataclasses.field(default_factory=dict)
    passages: tuple[Passage, ...] = ()
    follow: Follow | None = None
    blocked: Blocked | None = None

    def __repr__(self) -> str:
        return (
            f"<Plan: {len(self.blocks)} strokes' parts, {self.primitives} primitives, "
            f"joint travel {self.joint_travel_rad:.6g} rad>"
        )

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all primitives of |angle| [rad]."""
        return sum(b.joint_travel_rad for b in self.blocks)

    @property
    def duration_s(self) -> float:
        """How long the motion takes at the swimmer's joint rate [s]."""
        return sum(b.duration for b in self.blocks) / self.swimmer.joint_rate_rad_s

    @property
    def legs(self) -> tuple[tuple[Block, ...], ...]:
        """The blocks from the start to the first waypoint, between waypoints, and to the goal."""
        edges = [0, *(p.block for p in self.passages), len(self.blocks)]
        return tuple(self.blocks[a:b] for a, b in itertools.pairwise(edges))

    @property
    def primitives(self) -> int:
        """How many primitives are played."""
        return sum(b.cycles * len(b.sequence) for b in self.blocks)
