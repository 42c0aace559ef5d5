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

import numpy as np

from purcell_cli import se3
from purcell_cli.configuration import Configuration, Deviation
from purcell_cli.errors import UnknownNameError
from purcell_cli.gaits import Gait
from purcell_cli.lift import EXACT
from purcell_cli.planner.equations import Equations, stretches_of
from purcell_cli.planner.finish import approach, arrive
from purcell_cli.planner.search import candidates
from purcell_cli.planner.shorten import SEARCHING, Pace
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block, clock_step, rounded


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A plan: the motion from a start to a goal configuration.

    Attributes:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        blocks: The strokes of all three phases.
    """

    swimmer: Swimmer
    start: Configuration
    goal: Configuration
    blocks: tuple[Block, ...]

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all primitives of |angle| [rad]."""
        return sum(b.joint_travel_rad for b in self.blocks)

    @property
    def duration_s(self) -> float:
        """How long the motion takes at the swimmer's joint rate [s]."""
        return self.joint_travel_rad / self.swimmer.joint_rate_rad_s

    @property
    def primitives(self) -> int:
        """How many primitives are played."""
        return sum(b.cycles * len(b.sequence) for b in self.blocks)


def _scaled(pose: Array, length_m: float) -> Array:
    out = pose.copy()
    out[:3, 3] /= length_m
    return out


_THERE = 1e-14
"""A start this near its goal (L, rad) is there already."""

_CLOSE, _ARRIVED = 1e-7, 1e-10
_MARGIN_RAD = 1e-7
"""Room left below the bend limit for the exact finish."""

EFFORTS: Mapping[str, Pace | None] = {"quick": None, "standard": None, "thorough": Pace(rounds=6, steps=60)}
"""How long the strokes are optimised together."""


def reconfigure(
    swimmer: Swimmer, start: Configuration, goal: Configuration, gaits: Mapping[str, Gait], effort: str = "standard"
) -> Plan:
    """Return a plan from a start to a goal configuration.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        gaits: The stored gaits to choose from.
        effort: One of `EFFORTS`.

    Raises:
        GaitError: No stored gait for a motion that is needed.
        UnknownNameError: No effort has this name.
    """
    if effort not in EFFORTS:
        raise UnknownNameError(f"effort: one of {', '.join(EFFORTS)} is wanted, found {effort!r}")
    if Deviation.between(start, goal).within(_THERE * swimmer.length_m, _THERE):
        return Plan(swimmer, start, goal, ())
    unit = swimmer.scaled()
    wanted = se3.inverse(_scaled(start.pose, swimmer.length_m)) @ _scaled(goal.pose, swimmer.length_m)
    tried: list[tuple[float, Equations]] = []
    for candidate in candidates(unit, start.shape, goal.shape, wanted, gaits):
        rough = Equations(unit, stretches_of(candidate.blocks), start.shape, goal.shape, wanted, SEARCHING)
        near, off = approach(rough, swimmer.max_bend_rad - _MARGIN_RAD, _CLOSE)
        motion, off = _exact(swimmer, near) if off < _CLOSE else (near, off)
        tried.append((off, motion))
        if off < _ARRIVED:
            break
    _, motion = min(tried, key=lambda t: t[0])
    blocks = (b for s in motion.stretches for b in s.blocks() if np.any(b.sequence.angle))
    return Plan(swimmer, start, goal, tuple(blocks))


def _exact(swimmer: Swimmer, motion: Equations) -> tuple[Equations, float]:
    """Return a motion that arrives exactly, its durations on the clock, and what it misses by [L, rad]."""
    step = clock_step(1.01 * motion.joint_travel_rad / swimmer.joint_rate_rad_s)

    def on_the_clock(angle: Array) -> Array:
        return rounded(angle, swimmer.joint_rate_rad_s, step)

    timed = [
        s if s.free else dataclasses.replace(s, sequence=s.sequence.with_angles(on_the_clock(s.sequence.angle)))
        for s in motion.stretches
    ]
    return arrive(motion.at_accuracy(EXACT).of(timed), swimmer.max_bend_rad, on_the_clock)
