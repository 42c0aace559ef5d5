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
from collections.abc import Mapping, Sequence

import numpy as np

from purcell_cli import se3
from purcell_cli.configuration import Configuration, Deviation
from purcell_cli.errors import UnknownNameError
from purcell_cli.gaits import Gait
from purcell_cli.lift import flow
from purcell_cli.planner.equations import Equations, Stretch, stretches_of
from purcell_cli.planner.finish import arrive
from purcell_cli.planner.limbs import from_collinear, to_collinear
from purcell_cli.planner.shorten import Pace, shorten
from purcell_cli.planner.strokes import phase_two, stroke_book
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block, clock_step, rounded

PHASES = {1: "limbs to collinear", 2: "stored gaits", 3: "limbs to the goal shape"}


@dataclasses.dataclass(frozen=True, slots=True)
class Structure:
    """A way to build a plan that was weighed.

    Attributes:
        words: What it does, in words.
        joint_travel_rad: Its joint travel, as estimated when it was weighed [rad].
    """

    words: str
    joint_travel_rad: float


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A plan: the motion from a start to a goal configuration.

    Attributes:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        blocks: The strokes of all three phases.
        structures: The structures that were weighed, best first; the first one was taken.
    """

    swimmer: Swimmer
    start: Configuration
    goal: Configuration
    blocks: tuple[Block, ...]
    structures: tuple[Structure, ...] = ()

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

_APART = 128
"""Cycles of repeated strokes are kept apart, free to change, up to so many primitives."""

EFFORTS: Mapping[str, tuple[int, Pace | None]] = {
    "standard": (0, None),
    "thorough": (64, Pace(rounds=6, steps=60)),
}
"""How many primitives of phase 2 are optimised together at most, and for how long."""


def reconfigure(
    swimmer: Swimmer, start: Configuration, goal: Configuration, gaits: Mapping[str, Gait], effort: str = "standard"
) -> Plan:
    """Return a plan from a start to a goal configuration.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        gaits: The stored gaits to choose from.
        effort: One of `EFFORTS`: "standard" plays stored gaits one after the other; "thorough" then
            shortens them together.

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
    first, last = to_collinear(start.shape), from_collinear(goal.shape)
    missing = se3.inverse(flow(unit, first, start.shape)) @ wanted @ se3.inverse(flow(unit, last))
    blocks = [
        *([Block(1, PHASES[1], first)] if len(first) else []),
        *phase_two(stroke_book(tuple(gaits.values()), unit), se3.normalised(missing)),
        *([Block(3, PHASES[3], last)] if len(last) else []),
    ]
    if not blocks:
        return Plan(swimmer, start, goal, ())
    plain, off = _exact(swimmer, stretches_of(_unrolled(blocks, _APART), start.shape, goal.shape), wanted)
    most, pace = EFFORTS[effort]
    if pace is not None:
        joined = stretches_of(_unrolled(blocks, most), start.shape, goal.shape)
        shorter, still_off = _exact(swimmer, shorten(unit, joined, wanted, swimmer.max_bend_rad, pace), wanted)
        if still_off < max(1e-10, off) and _travel(shorter) < _travel(plain):
            plain = shorter
    return Plan(swimmer, start, goal, tuple(b for s in plain for b in s.blocks() if np.any(b.sequence.angle)))


def _travel(stretches: Sequence[Stretch]) -> float:
    return sum(s.cycles * s.sequence.joint_travel_rad for s in stretches)


def _unrolled(blocks: Sequence[Block], most: int) -> list[Block]:
    """Return blocks with the cycles of repeated strokes apart, the last first, up to so many primitives."""
    out: list[Block] = []
    room = most - sum(len(b.sequence) for b in blocks if b.cycles == 1)
    for block in reversed(blocks):
        more = block.cycles * len(block.sequence)
        if block.cycles > 1 and more <= room:
            room -= more
            out += [dataclasses.replace(block, cycles=1)] * block.cycles
        else:
            out.append(block)
    return out[::-1]


def _exact(swimmer: Swimmer, stretches: Sequence[Stretch], wanted: Array) -> tuple[list[Stretch], float]:
    """Return stretches that arrive exactly, their durations on the clock, and what they miss by [L, rad]."""
    step = clock_step(1.01 * _travel(stretches) / swimmer.joint_rate_rad_s)

    def on_the_clock(angle: Array) -> Array:
        return rounded(angle, swimmer.joint_rate_rad_s, step)

    timed = [
        s if s.free else dataclasses.replace(s, sequence=s.sequence.with_angles(on_the_clock(s.sequence.angle)))
        for s in stretches
    ]
    return arrive(Equations(swimmer.scaled(), timed, wanted), on_the_clock)
