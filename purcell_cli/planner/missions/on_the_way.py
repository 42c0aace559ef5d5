"""Waypoints on the way: a plan that ignores them passes near, so it is cut there and its strokes go on through them.

Limbs are at a waypoint as they are in the stroke: they do not straighten, and cruising goes on. Limbs that it names
turn there from the stroke, and back. Where it names both the position and the orientation limbs may straighten part of
the way there, since a stroke has the base aside of its line or turned from it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import cast

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between, as_vector
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.limbs.limb_rotations import least_travel, rotations_to
from purcell_cli.planner.missions.brought import brought
from purcell_cli.planner.missions.limbs_in_place import in_place
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.refine.minimum_travel import NAME
from purcell_cli.planner.rest import blocks_after, of_primitives
from purcell_cli.planner.routes.one_motion import ended

_BESIDE_L = 0.5
"""How far from a waypoint a plan that ignores it may pass for its strokes to be brought through it [L]: about what the
base swings aside in a stroke."""
_BESIDE_RAD = 0.4
"""How far its orientation may be off there [rad]: somewhat more than the base turns to and fro in a stroke."""
_AS_FAR_RAD = 10.0
"""Limbs that turn so far count as much as what a way may pass beside a waypoint [rad]: about what 0.5 L take."""
_PLACES, _APART_RAD = 3, 2.0
"""Places that are tried at most for a waypoint, and how far apart they are [rad]: half a side of a stroke's loop."""
_SHARES = (1.0, 0.8, 0.6, 0.4)
"""What is left of a stroke's bends at a waypoint that names the whole pose, tried one by one: 0 straightens."""
_MOST_FREE = 2000
"""Plans of more primitives are not brought through waypoints: each primitive may change by itself."""


def legs_through(swimmer: Swimmer, direct: Plan, via: Sequence[Waypoint], limits: Limits) -> list[Plan] | None:
    """Return a plan cut at waypoints that it is brought to pass; None where it does not pass near all of them, in turn.

    Limbs are as they are in the stroke but where a waypoint names them: they turn there and back.

    Args:
        swimmer: The swimmer.
        direct: A plan that ignores them, whose strokes bend a little less than they may: so they can go farther.
        via: Waypoints, in order.
        limits: What legs keep besides the bend limit.
    """
    if direct.primitives > _MOST_FREE:
        return None
    legs: list[Plan] = []
    apart = tuple(dataclasses.replace(b, cycles=1) for b in direct.blocks for _ in range(b.cycles))
    rest = dataclasses.replace(direct, blocks=apart)
    for k, waypoint in enumerate(via):
        if not rest.blocks or not of_primitives(rest):
            return None
        way = PlanPath.of(rest)
        for place in _places(way, waypoint, next((one for one in via[k + 1 :] if not in_place(one)), None)):
            cuts = (_cut(swimmer, rest, way, place, waypoint, limits, share) for share in _shares(waypoint))
            cut = next((one for one in cuts if one is not None), None)
            if cut is not None:
                break
        else:
            return None
        legs.append(cut[0])
        rest = cut[1]
    return [*legs, rest]


def _cut(
    swimmer: Swimmer, plan: Plan, way: PlanPath, place: int, waypoint: Waypoint, limits: Limits, share: float
) -> tuple[Plan, Plan] | None:
    """Return a plan cut at a place on its way, both parts brought to the waypoint there; None where that fails.

    Limbs that it leaves free keep a share of their bends in the stroke.
    """
    done_rad, begun = float(way.travel_rad[0] - way.travel_rad[place]), way.shape[place]
    free = begun if share == 1.0 else _part_way(home_shape(swimmer, begun), begun, share)
    named = waypoint.filled(Configuration(plan.start.pose, free)).shape
    there, back = _turned(swimmer, begun, named), _turned(swimmer, named, begun)
    if there is None or back is None:
        return None
    before = (*blocks_before(plan, done_rad), *there)
    end = ended(dataclasses.replace(plan, blocks=before))
    leg = brought(swimmer, plan.start, waypoint.filled(Configuration(end.pose, named)), before, limits)
    if leg is None:
        return None
    rest = brought(swimmer, ended(leg), plan.goal, (*back, *blocks_after(plan, done_rad)), limits)
    return None if rest is None else (leg, rest)


def whole_pose(waypoint: Waypoint) -> bool:
    """Return whether a waypoint names the position and the orientation."""
    return waypoint.position_m is not None and waypoint.orientation is not None


def _shares(waypoint: Waypoint) -> tuple[float, ...]:
    return _SHARES if whole_pose(waypoint) else _SHARES[:1]


def _part_way(begin: Array, end: Array, share: float) -> Array:
    """Return the shape a share of the way from one to another, each limb turned about one axis. Shape (2, 3, 3)."""
    turned = matmul(begin.transpose(0, 2, 1), end)
    return np.asarray(matmul(begin, np.stack([se3.rotation(share * as_vector(one)) for one in turned])))


def detours_rad(via: Sequence[Waypoint], home: Array) -> float:
    """Return what it takes limbs to turn from home to what waypoints name, and back [rad]. Shape (2, 3, 3)."""
    turns = [
        matmul(home[k].T, limb) for one in via for k, limb in enumerate((one.limb1, one.limb2)) if limb is not None
    ]
    return 2.0 * float(np.sum(least_travel(np.stack(turns)))) if turns else 0.0


def _places(way: PlanPath, waypoint: Waypoint, after: Waypoint | None) -> list[int]:
    """Return where on a way a waypoint may be passed, the best first: near what it names, limbs counted too.

    Args:
        way: The way, of what is left of the plan.
        waypoint: The waypoint.
        after: The next one that names a position or an orientation: places are before the way's nearest to that one.
    """
    off = _off(way, waypoint)
    left = way.travel_rad
    far = (off > 1.0) | (left <= 0.0) | (left >= left[0])
    if after is not None:
        far[int(np.argmin(np.round(_off(way, after), 9))) :] = True
    for k, limb in enumerate((waypoint.limb1, waypoint.limb2)):
        if limb is not None:
            off = off + least_travel(matmul(way.shape[:, k].transpose(0, 2, 1), limb)) / _AS_FAR_RAD
    if waypoint.position_m is None and waypoint.orientation is not None:  # strokes enough on both sides to be changed
        off = off + np.maximum(1.0 - np.minimum(left[0] - left, left) / _AS_FAR_RAD, 0.0)
    off = np.where(far, np.inf, np.round(off, 9))
    out: list[int] = []
    while len(out) < _PLACES and np.min(off) < np.inf:
        out.append(int(np.argmin(off)))
        off[np.abs(left - left[out[-1]]) < _APART_RAD] = np.inf
    return out


def _off(way: PlanPath, waypoint: Waypoint) -> Array:
    """Return how far places on a way are from a waypoint's position and orientation, over what may be. Shape (n,)."""
    length_m = way.plan.swimmer.length_m
    left = way.left.copy()
    left[:, :3, 3] *= length_m
    pose = matmul(way.plan.goal.pose, se3.inverse(left))
    off = np.zeros(len(pose))
    if waypoint.position_m is not None:
        off = norm(pose[:, :3, 3] - waypoint.position_m) / (_BESIDE_L * length_m)
    if waypoint.orientation is not None:
        off = np.maximum(off, angle_between(pose[:, :3, :3], waypoint.orientation[None]) / _BESIDE_RAD)
    return off


def _turned(swimmer: Swimmer, begin: Array, end: Array) -> tuple[Block, ...] | None:
    """Return limbs turned from one shape to another as a stroke of phase 2; None where joints cannot turn so.

    Args:
        swimmer: The swimmer.
        begin: The shape before. Shape (2, 3, 3).
        end: The shape after. Shape (2, 3, 3).
    """
    parts = []
    for k in (0, 1):
        ways = rotations_to(matmul(begin[k].T, end[k]), k + 1)
        every = [ways.primitives(j).busy() for j in range(len(ways))]
        possible = [one for one in every if set(one.control.tolist()) <= set(swimmer.controls)]
        if not possible:
            return None
        parts.append(possible[0])
    whole = joined(parts)
    return (Block(2, NAME, whole),) if len(whole) else ()


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
