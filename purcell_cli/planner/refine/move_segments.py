"""Plans as segments by moves, and what the search makes of those: freed, held, without idle moves."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.refine.rounded_loops import Ways, as_it_is, segments_by_moves
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

TOGETHER, ROLLED = "simultaneous moves", "limb rolls"
"""Names of strokes that are not in the primitive plan."""
_IDLE_RAD = 1e-10
"""Moves that turn no joint further than this are dropped from the search [rad]."""


def segments_of_plan(plan: Plan, swimmer: Swimmer, across_rad: float, ways: Ways | None) -> list[Segment]:
    """Return the segments of a plan, its limbs rolled in phase 2 by an angle, opposite ways [rad].

    Args:
        plan: The plan.
        swimmer: Its swimmer, scaled.
        across_rad: The angle [rad].
        ways: What may turn at once, where joints are not all ball joints.
    """
    out: dict[int, list[Segment]] = {1: [], 2: [], 3: []}
    for block, shape in zip(plan.blocks, starting_shapes(plan.blocks, plan.start.shape), strict=False):
        out[block.phase] += segments_by_moves(block, shape, swimmer, ways)
    if across_rad:
        roll = across_rad * np.array([[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]])
        rolled = [_seen_rolled(segment, across_rad) for segment in out[2]]
        out[2] = [Segment.by_moves(2, ROLLED, roll), *rolled, Segment.by_moves(2, ROLLED, -roll)]
    return _joined([segment for phase in (1, 2, 3) for segment in out[phase]])


def _joined(segments: list[Segment]) -> list[Segment]:
    """Return segments, neighbours in one phase that are played once and may turn about the same axes made one."""
    out: list[Segment] = []
    for segment in segments:
        last = out[-1] if out else None
        if last is not None and last.cycles == segment.cycles == 1 and _alike(last, segment):
            out[-1] = segment.with_turns(np.concatenate([last.turn, segment.turn]))
        else:
            out.append(segment)
    return out


def _alike(one: Segment, other: Segment) -> bool:
    """Return whether segments are of one phase and their moves may turn about the same axes."""
    if one.phase != other.phase or not one.loose or not other.loose:
        return False
    if one.tie is None or other.tie is None:
        return one.tie is other.tie
    return np.array_equal(one.tie, other.tie)


def _seen_rolled(segment: Segment, across_rad: float) -> Segment:
    """Return the segment that moves the limbs' axes alike when the limbs are rolled, by as much opposite ways [rad]."""
    back = np.stack([about_axis(0, -across_rad), about_axis(0, across_rad)])

    def seen(turns: Array) -> Array:
        """Turn columns of limbs' vectors into the rolled limbs' frames. Shape (6 n, m)."""
        parts = turns.reshape(len(turns) // 6, 2, 3, turns.shape[1])
        return np.asarray(matmul(back, parts).reshape(turns.shape))

    rolled = segment.with_turns(seen(segment.turn.reshape(-1, 1)).reshape(-1, 6))
    tie = segment.given_tie
    return rolled if tie is None else dataclasses.replace(rolled, given_tie=seen(tie))


def all_freed(motion: Equations, ways: Ways | None) -> Equations:
    """Return the motion with every turn that is made once free about all axes that joints have; some begin so."""
    if ways is not None:
        return motion
    free = [dataclasses.replace(s, given_tie=None) if s.loose else s for s in motion.segments]
    return motion.of(_joined(free))


def without_straightening(motion: Equations) -> Equations | None:
    """Return the motion all in phase 2, but for phases that begin or end with limbs bent too far for it, or None."""
    most = np.max(bends(np.stack([motion.start, motion.goal])[..., 0]), axis=1)
    within = {phase for phase, bend in zip((1, 3), most, strict=True) if bend <= motion.swimmer.max_bend_rad}
    if not within & {s.phase for s in motion.segments}:
        return None
    return motion.of(_joined([dataclasses.replace(s, phase=2) if s.phase in within else s for s in motion.segments]))


def with_phases_held(motion: Equations, plan: Plan, phases: set[int]) -> Equations:
    """Return the motion with some phases as a plan by primitives has them, not to be changed."""
    out: list[Segment] = []
    for phase in (1, 2, 3):
        if phase in phases:
            out += [as_it_is(block) for block in plan.blocks if block.phase == phase]
        else:
            out += [segment for segment in motion.segments if segment.phase == phase]
    return motion.of(out)


def without_idle(motion: Equations) -> Equations:
    """Return the motion without moves that turn nothing, unless none does."""
    segments = []
    for segment in motion.segments:
        used = np.max(np.abs(segment.turn), axis=1) > _IDLE_RAD
        if not segment.loose:
            segments.append(segment)
        elif np.any(used):
            segments.append(segment.with_turns(segment.turn[used]))
    return motion.of(segments) if segments else motion
