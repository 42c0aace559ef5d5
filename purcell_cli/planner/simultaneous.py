"""Plans on which all six joints may turn at once: a plan by primitives, made quicker.

1. Every primitive becomes a move; long ones are cut, so that others can join them for a part.
2. Loops that repeat become octagons (`octagons`).
3. At the collinear shape the limbs first roll by an eighth of a turn, opposite ways, which moves
   the base not at all. A limb's yaw and pitch axes then lie across the base's, and turning on both
   it bends in the base's planes at the square root of two times the rate of one joint.
4. All turns are optimised together for the duration (`haste`) and settled exactly.

What comes out no quicker, or not exact, or bends too far, is not taken. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from purcell_cli import se3
from purcell_cli.configuration import Configuration
from purcell_cli.moves import MoveSequence
from purcell_cli.planner.course import Course, Leg, most_bent
from purcell_cli.planner.haste import hastened, settled
from purcell_cli.planner.octagons import cycle, octagons, twist, yaws
from purcell_cli.planner.reconfiguration import Plan
from purcell_cli.planner.shorten import SEARCHING
from purcell_cli.primitives import PrimitiveSequence
from purcell_cli.rotations import Array, about_axis, as_vector
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block, clock_step, starting_shapes

_ACROSS_RAD = 0.25 * math.pi
"""How far the limbs roll to have two axes each across the plane they bend in."""
_PIECE_RAD = 0.5
_FEW_CYCLES = 2
"""Loops that repeat no more often are free in every turn."""
_PLANAR_RAD = 0.2
_ARRIVED = 1e-10
_IDLE_RAD = 1e-10
_MARGIN_RAD = 1e-6
"""Room left below the bend limit for the exact finish."""

ROLLED, ROUNDED = "limbs rolled across", "rounded loop"
"""Names of strokes that are not in the primitive plan."""


def quickened(plan: Plan) -> Plan:
    """Return a plan that arrives as exactly in less time, all joints turning at once; or the same plan.

    Args:
        plan: A plan by primitives.
    """
    length = plan.swimmer.length_m
    wanted = se3.inverse(_scaled(plan.start, length)) @ _scaled(plan.goal, length)
    unit = plan.swimmer.scaled()
    inner = dataclasses.replace(unit, max_bend_rad=max(unit.max_bend_rad - _MARGIN_RAD, 0.5 * unit.max_bend_rad))
    best = plan
    for legs in _beginnings(plan, unit):
        course = Course(inner, legs, plan.start.shape, plan.goal.shape, wanted, SEARCHING)
        planar = _without_idle(hastened(course))
        found, off = settled(_without_idle(hastened(_freed(planar))))
        if off > _ARRIVED or _too_bent(found, unit.max_bend_rad):
            continue
        blocks = _on_the_clock(found, plan.swimmer.joint_rate_rad_s)
        if sum(b.duration for b in blocks) < sum(b.duration for b in best.blocks):
            best = dataclasses.replace(plan, blocks=tuple(blocks))
    return best


def _scaled(configuration: Configuration, length_m: float) -> Array:
    return se3.pose(configuration.pose[:3, :3], configuration.pose[:3, 3] / length_m)


def _beginnings(plan: Plan, swimmer: Swimmer) -> Iterator[list[Leg]]:
    """Yield motions to begin the search from."""
    if not plan.blocks:
        return
    yield _legs(plan, swimmer, _ACROSS_RAD)
    if not any(b.cycles > 1 for b in plan.blocks):
        yield _legs(plan, swimmer, 0.0)


def _legs(plan: Plan, swimmer: Swimmer, across_rad: float) -> list[Leg]:
    """Return the legs of a plan, its limbs rolled in phase 2 by an angle, one the one and one the other way [rad]."""
    out: dict[int, list[Leg]] = {1: [], 2: [], 3: []}
    for block, shape in zip(plan.blocks, starting_shapes(plan.blocks, plan.start.shape), strict=False):
        out[block.phase] += _rounded(block, shape, swimmer) or [_leg(block)]
    if out[2] and across_rad:
        roll = across_rad * np.array([[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]])
        rolled = [_seen_rolled(leg, across_rad) for leg in out[2]]
        out[2] = [Leg(2, ROLLED, roll), *rolled, Leg(2, ROLLED, -roll)]
    return [leg for phase in (1, 2, 3) for leg in out[phase]]


def _leg(block: Block) -> Leg:
    turn = MoveSequence.of_controls(block.sequence).turn
    if block.cycles == 1:
        cut = _cut(turn)
        return Leg(block.phase, block.gait, cut, tie=_planar_tie(cut), amplitude_rad=block.amplitude_rad)
    return Leg(block.phase, block.gait, turn, block.cycles, np.empty((turn.size, 0)), block.amplitude_rad)


def _cut(turn: Array) -> Array:
    """Return turns cut into pieces of half a radian at most. Shape (n, 6) to (m, 6)."""
    parts = np.maximum(np.ceil(np.max(np.abs(turn), axis=1) / _PIECE_RAD), 1).astype(np.int64)
    return np.repeat(turn / parts[:, None], parts, axis=0)


def _rounded(block: Block, shape: Array, swimmer: Swimmer) -> list[Leg]:
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
    corner = np.roll(corner, -int(np.argmin(np.linalg.norm(corner - here, axis=1))), axis=0)
    way = yaws(corner[:1] - here)
    turn = yaws(cycle(corner))
    loop = Leg(2, ROUNDED, turn, cycles, _half_tie(turn)) if cycles > _FEW_CYCLES else _free_loop(turn, cycles)
    return [Leg(2, ROUNDED, _cut(w), tie=_planar_tie(_cut(w))) for w in (way,)] + [loop] + [
        Leg(2, ROUNDED, _cut(w), tie=_planar_tie(_cut(w))) for w in (-way,)
    ]


def _free_loop(turn: Array, cycles: int) -> Leg:
    cut = _cut(np.tile(turn, (cycles, 1)))
    return Leg(2, ROUNDED, cut, tie=_planar_tie(cut))


def _planar_tie(turn: Array) -> Array | None:
    """Return the tie of turns by yaws alone or by pitches alone, which keeps them so; of others none. Shape (6 n, 2 n)."""
    used = np.flatnonzero(np.any(turn != 0.0, axis=0))
    plane = next((p for p in ([2, 5], [1, 4]) if set(used.tolist()) <= set(p)), None)
    return None if plane is None else np.kron(np.eye(len(turn)), np.eye(6)[:, plane])


def _half_tie(turn: Array) -> Array:
    """Return the tie of a loop whose second half undoes the turns of the first, by yaws. Shape (6 n, n)."""
    n = len(turn)
    out = np.zeros((n, 6, n // 2, 2))
    for k in range(n):
        for i, axis in enumerate((2, 5)):
            out[k, axis, k % (n // 2), i] = 1.0 if k < n // 2 else -1.0
    return out.reshape(6 * n, n)


def _seen_rolled(leg: Leg, across_rad: float) -> Leg:
    """Return the leg that moves the limbs' axes alike when the limbs are rolled, by as much opposite ways [rad]."""
    back = np.stack([about_axis(0, -across_rad), about_axis(0, across_rad)])

    def seen(turns: Array) -> Array:
        """Turn columns of limbs' vectors into the rolled limbs' frames. Shape (6 n, m)."""
        parts = turns.reshape(-1, 2, 3, turns.shape[1])
        return np.einsum("lij,nljm->nlim", back, parts).reshape(turns.shape)

    turn = seen(leg.turn.reshape(-1, 1)).reshape(-1, 6)
    return dataclasses.replace(leg, turn=turn, tie=None if leg.tie is None else seen(leg.tie))


def _freed(course: Course) -> Course:
    """Return the course with every turn that is made once free in all components."""
    return course.of([leg if leg.cycles > 1 else dataclasses.replace(leg, tie=None) for leg in course.legs])


def _without_idle(course: Course) -> Course:
    """Return the course without moves that turn nothing."""
    legs = []
    for leg in course.legs:
        used = np.max(np.abs(leg.turn), axis=1) > _IDLE_RAD
        if leg.cycles > 1:
            legs.append(leg)
        elif np.any(used):
            tie = None if leg.tie is None else leg.tie.reshape(len(used), 6, -1)[used].reshape(6 * int(used.sum()), -1)
            legs.append(dataclasses.replace(leg, turn=leg.turn[used], tie=tie))
    return course.of(legs)


def _too_bent(course: Course, max_bend_rad: float) -> bool:
    """Return whether a limb bends beyond the limit at any instant of phase 2."""
    moves = MoveSequence.of_turns(np.concatenate([leg.turn for leg in course.legs]))
    shapes = moves.shapes(course.start)[:-1]
    turn = np.einsum("nlij,nlj->nli", shapes, moves.turn.reshape(-1, 2, 3))
    part = most_bent(shapes[..., 0], turn)
    axes = (se3.rotation(part[..., None] * turn) @ shapes[..., 0, None])[..., 0]
    return bool(np.any(axes[course.phase == 2, :, 0] < math.cos(max_bend_rad)))


def _on_the_clock(course: Course, rate_rad_s: float) -> list[Block]:
    """Return the motion as blocks, its durations rounded up to the clock; the turns stay as they are."""
    step = clock_step(1.01 * course.duration / rate_rad_s) * rate_rad_s
    return [
        Block(leg.phase, leg.gait, _ticking(leg.turn, step), leg.cycles, leg.amplitude_rad) for leg in course.legs
    ]


def _ticking(turn: Array, step: float) -> MoveSequence:
    ticks = np.maximum(np.ceil(np.max(np.abs(turn), axis=1) / step), 1.0)
    return MoveSequence(turn / (ticks * step)[:, None], ticks * step)

