"""Plans on which all six joints may turn at once: a plan by primitives, optimised for minimum time.

1. Every primitive becomes a move; long ones are cut, so that others can join them for a part.
2. Loops that repeat become octagons (`octagonal_loops`).
3. At the collinear shape the limbs first roll by an eighth of a turn, opposite ways, which does not
   move the base. A limb's yaw and pitch axes then lie across the base's: it turns on both at once, and
   bends in the base's planes at the square root of two times the rate of one joint.
4. All rotations are optimised together for the duration (`minimum_time`) and settled exactly. At first
   strokes by yaws alone, or by pitches alone, stay so, since out of a plane the roll of the base
   changes too fast with the rotations; then all moves that are played once are free.

A result that is no quicker, not exact, or beyond a limit is rejected. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, about_axis, as_vector
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.moves import MoveSequence, joined
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, starting_shapes
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.limits import Limits, check
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.refine.minimum_time import minimise_time, settled
from purcell_cli.planner.refine.octagonal_loops import cycle, octagons, twist, yaws
from purcell_cli.planner.refine.shooting_moves import MoveSegment, MoveShooting

_ACROSS_RAD = 0.25 * math.pi
"""Roll of the limbs, an eighth of a turn, that puts their yaw and pitch axes midway between the base's [rad]."""
_PIECE_RAD = 0.5
"""Moves that turn a joint further than this are cut into equal pieces, which others can join [rad]."""
_FEW_CYCLES = 2
"""Loops of at most so many cycles are played out, so that each of their moves is free."""
_PLANAR_RAD = 0.2
"""Loops become octagons only where roll and pitch of both limbs are at most this [rad]."""
_ARRIVED = 1e-10
"""A motion whose residuals are all below this arrives [L, rad]."""
_IDLE_RAD = 1e-10
"""Moves that turn no joint further than this are dropped from the search [rad]."""
_UNFELT_RAD = 1e-13
"""Moves that turn no joint further than this are dropped from the plan [rad]."""
_MARGIN_RAD = 1e-6
"""Margin below the bend limit, left to the exact arrival [rad]; at most half the limit."""
_MOST_MOVES = 1000
"""Plans of more moves, one cycle of each stroke counted, stay as they are: derivatives grow with the square of that, to
some 7 GB at 9,000."""

TOGETHER, ROLLED, ROUNDED = "simultaneous moves", "limb rolls", "rounded shape loop"
"""Names of strokes that are not in the primitive plan."""


def quickened(plan: Plan, limits: Limits | None = None) -> Plan:
    """Return a plan that arrives as exactly in less time, all joints turning at once; or the same plan.

    Args:
        plan: A plan by primitives.
        limits: What the plan must keep besides the bend limit; what breaks them is not taken.
    """
    if not plan.blocks or sum(len(block.sequence) for block in plan.blocks) > _MOST_MOVES:
        return plan
    wanted = displacement_between(plan.start, plan.goal, plan.swimmer.length_m)
    unit = plan.swimmer.scaled()
    inner = dataclasses.replace(unit, max_bend_rad=max(unit.max_bend_rad - _MARGIN_RAD, 0.5 * unit.max_bend_rad))
    best = plan
    for across_rad in _ACROSS_RAD, 0.0:
        segments = _segments(plan, unit, across_rad)
        begun = MoveShooting(inner, segments, plan.start.shape, plan.goal.shape, wanted, SEARCHING)
        planar = _without_idle(minimise_time(begun))
        found, off = settled(_without_idle(minimise_time(_freed(planar))))
        blocks = _on_the_clock(found, plan.swimmer.joint_rate_rad_s)
        quicker = off < _ARRIVED and _duration(blocks) < _duration(best.blocks)
        if quicker and check(plan.swimmer, plan.start, blocks, limits).kept:
            best = dataclasses.replace(plan, blocks=tuple(blocks), limits=None)
        if best is not plan and any(b.cycles > 1 for b in blocks):
            break  # a long plan gains by rolled limbs more than by anything else
    return best


def _segments(plan: Plan, swimmer: Swimmer, across_rad: float) -> list[MoveSegment]:
    """Return the segments of a plan, its limbs rolled in phase 2 by an angle, opposite ways [rad]."""
    out: dict[int, list[MoveSegment]] = {1: [], 2: [], 3: []}
    for block, shape in zip(plan.blocks, starting_shapes(plan.blocks, plan.start.shape), strict=False):
        out[block.phase] += _rounded(block, shape, swimmer) or [_segment(block)]
    if out[2] and across_rad:
        roll = across_rad * np.array([[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]])
        rolled = [_seen_rolled(segment, across_rad) for segment in out[2]]
        out[2] = [MoveSegment(2, ROLLED, roll), *rolled, MoveSegment(2, ROLLED, -roll)]
    return [segment for phase in (1, 2, 3) for segment in out[phase]]


def _segment(block: Block) -> MoveSegment:
    turn = MoveSequence.of_controls(block.sequence).turn
    if block.cycles == 1:
        return _once(block.phase, block.gait, turn)
    return MoveSegment(block.phase, block.gait, turn, block.cycles, np.empty((turn.size, 0)), block.amplitude_rad)


def _rounded(block: Block, shape: Array, swimmer: Swimmer) -> list[MoveSegment]:
    """Return a repeated rectangle of both yaws as a repeated octagon with ways to it and from it; else nothing."""
    sequence = block.sequence
    if block.cycles == 1 or len(sequence) != 4 or not isinstance(sequence, PrimitiveSequence):
        return []
    bends = as_vector(shape)
    if set(sequence.control.tolist()) != {2, 5} or np.max(np.abs(bends[:, :2])) > _PLANAR_RAD:
        return []
    here = bends[:, 2]
    sides = MoveSequence.of_controls(sequence).turn[:, [2, 5]]
    corner = here + np.concatenate([np.zeros((1, 2)), np.cumsum(sides, axis=0)[:-1]])
    did = twist(swimmer, corner)
    corner, each = octagons(swimmer).like(float(did[0]), float(did[5]))
    exact = block.cycles * each
    cycles = max(math.ceil(exact - 0.25), 1)
    middle = np.mean(corner, axis=0)
    corner = middle + min(math.sqrt(exact / cycles), 1.0) * (corner - middle)
    corner = np.roll(corner, -int(np.argmin(norm(corner - here))), axis=0)
    way, turn = yaws(corner[:1] - here), yaws(cycle(corner))
    if cycles <= _FEW_CYCLES:
        loop = _once(2, ROUNDED, np.tile(turn, (cycles, 1)))
    else:
        loop = MoveSegment(2, ROUNDED, turn, cycles, _half_tie(turn))
    return [_once(2, ROUNDED, way), loop, _once(2, ROUNDED, -way)]


def _once(phase: int, gait: str, turn: Array) -> MoveSegment:
    """Return a segment that is played once, its turns cut, and kept to the yaws or to the pitches if they are so."""
    parts = np.maximum(np.ceil(np.max(np.abs(turn), axis=1) / _PIECE_RAD), 1).astype(np.int64)
    cut = np.repeat(turn / parts[:, None], parts, axis=0)
    used = set(np.flatnonzero(np.any(turn != 0.0, axis=0)).tolist())
    plane = next((p for p in ([2, 5], [1, 4]) if used <= set(p)), None)
    tie = None if plane is None else np.asarray(np.kron(np.eye(len(cut)), np.eye(6)[:, plane]), dtype=np.float64)
    return MoveSegment(phase, gait, cut, 1, tie)


def _half_tie(turn: Array) -> Array:
    """Return the tie of a loop whose second half undoes the turns of the first, by yaws. Shape (6 n, n)."""
    n = len(turn)
    out = np.zeros((n, 6, n // 2, 2))
    for k in range(n):
        for i, axis in enumerate((2, 5)):
            out[k, axis, k % (n // 2), i] = 1.0 if k < n // 2 else -1.0
    return out.reshape(6 * n, n)


def _seen_rolled(segment: MoveSegment, across_rad: float) -> MoveSegment:
    """Return the segment that moves the limbs' axes alike when the limbs are rolled, by as much opposite ways [rad]."""
    back = np.stack([about_axis(0, -across_rad), about_axis(0, across_rad)])

    def seen(turns: Array) -> Array:
        """Turn columns of limbs' vectors into the rolled limbs' frames. Shape (6 n, m)."""
        parts = turns.reshape(len(turns) // 6, 2, 3, turns.shape[1])
        return np.asarray(matmul(back, parts).reshape(turns.shape))

    turn = seen(segment.turn.reshape(-1, 1)).reshape(-1, 6)
    return dataclasses.replace(segment, turn=turn, tie=None if segment.tie is None else seen(segment.tie))


def _freed(motion: MoveShooting) -> MoveShooting:
    """Return the motion with every turn that is made once free in all components."""
    return motion.of([s if s.cycles > 1 else dataclasses.replace(s, tie=None) for s in motion.segments])


def _without_idle(motion: MoveShooting) -> MoveShooting:
    """Return the motion without moves that turn nothing, unless none does."""
    segments = []
    for segment in motion.segments:
        used = np.max(np.abs(segment.turn), axis=1) > _IDLE_RAD
        if segment.cycles > 1:
            segments.append(segment)
        elif np.any(used):
            tie = segment.tie
            if tie is not None:
                tie = tie.reshape(len(used), 6, -1)[used].reshape(6 * int(used.sum()), -1)
            segments.append(dataclasses.replace(segment, turn=segment.turn[used], tie=tie))
    return motion.of(segments) if segments else motion


def _duration(blocks: Sequence[Block]) -> float:
    return sum(b.duration for b in blocks)


def _on_the_clock(motion: MoveShooting, rate_rad_s: float) -> list[Block]:
    """Return the motion as blocks, its durations rounded up to the clock; the turns stay as they are."""
    step = clock_step(1.01 * motion.duration / rate_rad_s) * rate_rad_s
    out: list[Block] = []
    for segment in motion.segments:
        gait = TOGETHER if segment.phase == 2 and segment.cycles == 1 else segment.gait
        amplitude = segment.amplitude_rad if segment.cycles > 1 else math.nan
        felt = segment.turn if segment.cycles > 1 else segment.turn[np.max(np.abs(segment.turn), axis=1) > _UNFELT_RAD]
        block = Block(segment.phase, gait, _ticking(felt, step), segment.cycles, amplitude)
        if out and block.cycles == out[-1].cycles == 1 and block.phase == out[-1].phase:
            block = Block(segment.phase, gait, joined([out.pop().sequence, block.sequence]))
        out.append(block)
    return [block for block in out if len(block.sequence)]


def _ticking(turn: Array, step: float) -> MoveSequence:
    ticks = np.maximum(np.ceil(np.max(np.abs(turn), axis=1) / step), 1.0)
    return MoveSequence(np.clip(turn / (ticks * step)[:, None], -1.0, 1.0), ticks * step)
