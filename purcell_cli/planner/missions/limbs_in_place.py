"""Legs to waypoints that name limbs alone: the limbs turn there and then, and the base goes where that takes it."""

from __future__ import annotations

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES, Block
from purcell_cli.motion.clock import clock_step, on_the_clock
from purcell_cli.motion.mission import Waypoint
from purcell_cli.planner.limbs.limb_rotations import rotations_to


def in_place(waypoint: Waypoint) -> bool:
    """Return whether a waypoint leaves the whole pose of the base free."""
    return waypoint.position_m is None and waypoint.orientation is None


def limbs_turned(swimmer: Swimmer, shape: Array, waypoint: Waypoint, clock_s: float = 0.0) -> tuple[Block, ...]:
    """Return the shortest rotations, limb 1's first, by which limbs come to what a waypoint names.

    Args:
        swimmer: The swimmer.
        shape: The shape before. Shape (2, 3, 3).
        waypoint: The waypoint; a limb that it leaves free stays as it is.
        clock_s: The step of the clock of a longer motion that they are part of [s].
    """
    parts: list[PrimitiveSequence] = []
    for k, wanted in enumerate((waypoint.limb1, waypoint.limb2)):
        if wanted is not None:
            parts.append(rotations_to(matmul(shape[k].T, wanted), k + 1).primitives(0).busy())
    whole = joined(parts)
    if not len(whole):
        return ()
    step = max(clock_step(1.01 * whole.joint_travel_rad / swimmer.joint_rate_rad_s), clock_s)
    return (Block(3, PHASES[3], on_the_clock(whole, swimmer, step)),)
