"""Arcs of swimmers whose limbs hang on hinges of one axis: square loops of both angles, as ball joints swim them.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import plane_axis
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.needle_steering import seen_in_plane
from purcell_cli.planner.arcs.steered import arcs_in_plane
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth

_STRAIGHT = 1.0 - 1e-12
"""The cosine of a bend above which limbs are in line with the base."""
_LEAST_BEND_RAD = 0.05
"""Hinges that bend less than this to both sides swim no arcs [rad]: loops would be many."""


def hinge_fan(swimmer: Swimmer) -> Fan | None:
    """Return the loops in their plane of a swimmer on two hinges of one axis, within their ranges; None for others.

    Args:
        swimmer: The swimmer, scaled to L = 1.
    """
    if plane_axis(swimmer) is None:
        return None
    reach = swimmer.max_bend_rad
    for joint in swimmer.joints:
        low, high = joint.range_rad(joint.angles[0])
        reach = min(reach, -low, high)
    if reach < _LEAST_BEND_RAD:
        return None
    return fan(dataclasses.replace(swimmer, max_bend_rad=reach, joints=Swimmer().joints), "travel", False)


def arcs_by_hinges(
    swimmer: Swimmer, home: Array, missing: Array, starts: int, around: Callable[[Iterable[Block]], tuple[Block, ...]]
) -> list[Candidate]:
    """Return motions by arcs that almost make a displacement in the hinges' plane; none from limbs that are bent.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        home: The shape between the phases. Shape (2, 3, 3).
        missing: The displacement between phases 1 and 3. Shape (4, 4).
        starts: Starts of needle steering.
        around: Puts phases 1 and 3 around strokes.
    """
    loops, pitch = hinge_fan(swimmer), plane_axis(swimmer) == "pitch"
    if loops is None or not np.all(home[:, 0, 0] > _STRAIGHT):
        return []
    breadth = Breadth(starts=starts, shorter=0)
    found = arcs_in_plane(loops, seen_in_plane(missing) if pitch else missing, breadth)
    return [dataclasses.replace(one, make=functools.partial(_made, one, pitch, around)) for one in found]


def _made(one: Candidate, pitch: bool, around: Callable[[Iterable[Block]], tuple[Block, ...]]) -> tuple[Block, ...]:
    """Return a candidate's strokes, by yaw hinges or by pitch hinges, with phases 1 and 3 around them."""
    strokes = one.make()
    if pitch:
        strokes = tuple(dataclasses.replace(block, sequence=_pitched(block)) for block in strokes)
    return around(strokes)


def _pitched(block: Block) -> PrimitiveSequence:
    """Return the primitives of a stroke of both yaws by both pitches."""
    sequence = block.sequence
    if not isinstance(sequence, PrimitiveSequence):
        raise TypeError(f"strokes of primitives are wanted, found {type(sequence).__name__}")
    return PrimitiveSequence(sequence.control - 1, sequence.angle)
