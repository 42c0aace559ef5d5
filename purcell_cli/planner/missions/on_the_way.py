"""Waypoints on the way: a plan that ignores them passes near, so it is cut there and its strokes go on through them.

Limbs are at a waypoint as they are in the stroke: they do not straighten, and cruising goes on.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import cast

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.missions.brought import brought
from purcell_cli.planner.rest import blocks_after, of_primitives
from purcell_cli.planner.way import Way
from purcell_cli.planner.ways.one_motion import ended

_BESIDE_L = 0.5
"""How far from a waypoint a plan that ignores it may pass for its strokes to be brought through it [L]: about what the
base swings aside in a stroke."""

_MOST_FREE = 2000
"""Plans of more primitives are not brought through waypoints: each primitive may change by itself."""


def free_but_for_place(waypoint: Waypoint) -> bool:
    """Return whether a waypoint names a position alone."""
    return waypoint.names == ("position_m",)


def legs_through(swimmer: Swimmer, direct: Plan, via: Sequence[Waypoint], limits: Limits) -> list[Plan] | None:
    """Return a plan cut at waypoints that it is brought to pass; None where it does not pass near all of them, in turn.

    Args:
        swimmer: The swimmer.
        direct: A plan that ignores them, whose strokes bend a little less than they may: so they can go farther.
        via: Waypoints that name a position alone, in order.
        limits: What legs keep besides the bend limit.
    """
    if direct.primitives > _MOST_FREE:
        return None
    legs: list[Plan] = []
    apart = tuple(dataclasses.replace(b, cycles=1) for b in direct.blocks for _ in range(b.cycles))
    rest: Plan | None = dataclasses.replace(direct, blocks=apart)
    for waypoint in via:
        if rest is None or not rest.blocks or not of_primitives(rest) or waypoint.position_m is None:
            return None
        way = Way.of(rest)
        left = way.left.copy()
        left[:, :3, 3] *= swimmer.length_m
        off = norm(matmul(rest.goal.pose, se3.inverse(left))[:, :3, 3] - waypoint.position_m)
        place = int(np.argmin(np.round(off / swimmer.length_m, 9)))
        if float(off[place]) > _BESIDE_L * swimmer.length_m:
            return None
        done_rad = float(way.travel_rad[0] - way.travel_rad[place])
        before = blocks_before(rest, done_rad)
        here = ended(dataclasses.replace(rest, blocks=before))
        there = waypoint.filled(Configuration(here.pose, here.shape))
        leg = brought(swimmer, rest.start, there, before, limits) if before else None
        if leg is None:
            return None
        legs.append(leg)
        rest = brought(swimmer, ended(leg), rest.goal, blocks_after(rest, done_rad), limits)
    return None if rest is None else [*legs, rest]


def blocks_before(plan: Plan, done_rad: float) -> tuple[Block, ...]:
    """Return the strokes of a plan of primitives that are made in some joint travel [rad], cut where it ends."""
    out: list[Block] = []
    for block in plan.blocks:
        once = block.sequence.joint_travel_rad
        cycles = min(int(done_rad / once), block.cycles) if once > 0.0 else 0
        if cycles:
            out.append(dataclasses.replace(block, cycles=cycles))
        done_rad -= cycles * once
        if cycles < block.cycles:
            sequence = cast(PrimitiveSequence, block.sequence)
            size = np.abs(sequence.angle)
            made = np.clip(done_rad - (np.cumsum(size) - size), 0.0, size)
            part = sequence.with_angles(np.sign(sequence.angle) * made).busy()
            if len(part):
                out.append(dataclasses.replace(block, sequence=part, cycles=1))
            break
    return tuple(out)
