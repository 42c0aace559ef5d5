"""Strokes as segments by moves: rectangles that repeat become octagons, and long turns are cut."""

from __future__ import annotations

import functools
import math
from typing import cast

import numpy as np

from purcell_cli.geometry.reproducible import arctan2, cos, inner, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_turns import turns_of
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.refine.octagonal_loops import cycle, octagons, twist
from purcell_cli.planner.refine.segments import Segment

ROUNDED = "rounded shape loop"
"""Name of octagons, which are not in the plan by primitives."""
_PIECE_RAD = 1.0
"""Moves that turn a joint further than this are cut into equal pieces, which others can join [rad]."""
_FEW_CYCLES = 2
"""Loops of at most so many cycles are played out, so that each of their moves is free."""
_PLANAR_RAD = 0.2
"""Loops become octagons only where both axes are within this of a normal to the base's axis [rad]."""


Ways = tuple[tuple[int, ...], ...]
"""Which components of joints' turns may change at once: of a universal joint one angle or the other (`joint_turns`)."""


def segments_by_moves(block: Block, shape: Array, swimmer: Swimmer, ways: Ways | None) -> list[Segment]:
    """Return a stroke as segments: a rectangle that repeats as an octagon, with ways to it and from it.

    Args:
        block: The stroke.
        shape: The shape before it. Shape (2, 3, 3).
        swimmer: Its swimmer, scaled.
        ways: What may turn at once, where joints are not all ball joints.
    """
    if block.cycles == 1:
        return _once(block.phase, block.gait, _turn(block), ways)
    return _rounded(block, shape, swimmer, ways) or [as_it_is(block)]


def _turn(block: Block) -> Array:
    """Return the turns of joints in one cycle of a stroke of primitives [rad]. Shape (n, 6)."""
    return turns_of(cast(PrimitiveSequence, block.sequence))


def as_it_is(block: Block) -> Segment:
    """Return a stroke as a segment without free angles."""
    amplitude = block.amplitude_rad
    return Segment.by_moves(block.phase, block.gait, _turn(block), block.cycles, amplitude_rad=amplitude, fixed=True)


def _rounded(block: Block, shape: Array, swimmer: Swimmer, ways: Ways | None) -> list[Segment]:
    """Return a rectangle of one axis of each limb, both square to one plane through the base's axis, as an octagon."""
    if len(block.sequence) != 4 or not isinstance(block.sequence, PrimitiveSequence):
        return []
    used = np.flatnonzero(np.any(_turn(block) != 0.0, axis=0)).tolist()
    if len(used) != 2 or used[0] not in (1, 2) or used[1] not in (4, 5):
        return []
    about = np.stack([shape[0, :, used[0]], shape[1, :, used[1] - 3]])
    normal = about[0] * np.array([0.0, 1.0, 1.0])
    normal = normal / norm(normal)
    same = inner(about, normal)
    if np.min(np.abs(same)) < cos(_PLANAR_RAD):
        return []
    sense = np.sign(same)

    def turns(angle: Array) -> Array:
        """Angles of both limbs about the normal as turns of their joints. Shape (n, 2) to (n, 6)."""
        out = np.zeros((len(angle), 6))
        out[:, used] = angle * sense
        return out

    aside = np.array([0.0, normal[2], -normal[1]])
    here = arctan2(inner(shape[:, :, 0], aside), shape[:, 0, 0])
    sides = _turn(block)[:, used] * sense
    corner = here + np.concatenate([np.zeros((1, 2)), np.cumsum(sides, axis=0)[:-1]])
    did = twist(swimmer, corner)
    corner, each = octagons(swimmer).like(float(did[0]), float(did[5]))
    exact = block.cycles * each
    cycles = max(math.ceil(exact - 0.25), 1)
    middle = np.mean(corner, axis=0)
    corner = middle + min(math.sqrt(exact / cycles), 1.0) * (corner - middle)
    corner = np.roll(corner, -int(np.argmin(norm(corner - here))), axis=0)
    way, turn = turns(corner[:1] - here), turns(cycle(corner))
    if cycles <= _FEW_CYCLES:
        loop = _once(2, ROUNDED, np.tile(turn, (cycles, 1)), ways)
    else:
        loop = [Segment.by_moves(2, ROUNDED, turn, cycles, _half_tie(len(turn), used))]
    return [*_once(2, ROUNDED, way, ways), *loop, *_once(2, ROUNDED, -way, ways)]


def _once(phase: int, gait: str, turn: Array, ways: Ways | None) -> list[Segment]:
    """Return what is played once, its turns cut, and kept to the yaws or to the pitches if they are so.

    Where joints have but some axes, it is kept to those; where there are several ways in which they may turn at once,
    a move is shared out to all that it may be made in.
    """
    parts = np.maximum(np.ceil(np.max(np.abs(turn), axis=1) / _PIECE_RAD), 1).astype(np.int64)
    cut = np.repeat(turn / parts[:, None], parts, axis=0)
    used = set(np.flatnonzero(np.any(turn != 0.0, axis=0)).tolist())
    plane = next((p for p in ([2, 5], [1, 4]) if used <= set(p)), None)
    if ways is None or len(ways) == 1:
        free = plane if ways is None else ways[0]
        return [Segment.by_moves(phase, gait, cut, tie=None if free is None else axes_of(tuple(free)))]
    out = []
    for one in cut:
        within = [way for way in ways if set(np.flatnonzero(one).tolist()) <= set(way)]
        out += [Segment.by_moves(phase, gait, one[None] / len(within), tie=axes_of(way)) for way in within]
    return out


@functools.lru_cache(maxsize=64)
def axes_of(components: tuple[int, ...]) -> Array:
    """Return the axes of some components of turns, the same array for all. Shape (6, p)."""
    return np.eye(6)[:, list(components)]


def _half_tie(moves: int, axes: list[int]) -> Array:
    """Return the tie of a loop whose second half undoes the turns of the first, each limb's about an axis of its own.

    Shape (6 n, n).
    """
    half = moves // 2
    out = np.zeros((moves, 6, half, 2))
    for k in range(moves):
        for i, axis in enumerate(axes):
            out[k, axis, k % half, i] = 1.0 if k < half else -1.0
    return out.reshape(6 * moves, moves)
