"""Fits loops of a fan to wanted arcs: their cycles, bend and offset share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.component_first import solve_positive
from purcell_cli.geometry.reproducible import apply, hypot, inner, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.arcs.loop_family import Fan

_FITTING = 3
"""Newton steps in which bend and offset share are fitted to an arc."""
_SPARE = 0.06
"""A count of cycles is rounded down if it exceeds a whole number by less than this."""
LONGEST_STEP_RAD = 0.3
"""The largest change of a bend or an offset share in one Newton step [rad]."""


@frozen_dataclass(eq=False)
class Fitted:
    """Loops that swim arcs.

    Attributes:
        cycles: How many. Shape (n,).
        bend: Their largest bends [rad]. Shape (n,).
        offset_share: How much of the bend is offset. Shape (n,).
        cost: What the strokes cost, ways in and out included [rad]. Shape (n,).
    """

    cycles: NDArray[np.int64]
    bend: Array
    offset_share: Array
    cost: Array


def fitted(fan: Fan, advance: Array, turn: Array) -> Fitted:
    """Return the loops of a fan that advance and turn by given amounts, as nearly as they can.

    Args:
        fan: The loops.
        advance: How far, not negative [L]. Shape (n,).
        turn: By how much, not negative [rad]. Shape (n,).
    """
    loops = fan.loops
    knot = fan.knot(advance, turn)
    bend, offset_share = fan.at(knot, fan.bend), fan.at(knot, fan.offset_share)
    scale = np.array([1.0 / fan.straight, 1.0 / fan.tight])
    wanted = np.stack([advance, turn], axis=1) * scale
    once = loops.at(bend, offset_share)
    cycle, ways = (_advance_and_turn(part[0])[0] * scale for part in (once.cycle, once.ways))
    size = np.maximum(inner(cycle, cycle), 1e-300)
    whole = inner(wanted, cycle) / size
    share = inner(ways, cycle) / size
    cycles = np.maximum(np.ceil(whole - share - _SPARE), np.where(share > 0.1, 0.0, 1.0))
    bend = bend * np.sqrt(np.minimum(whole / np.maximum(cycles + share, 1e-300), 1.0))
    for _ in range(_FITTING):
        bend, offset_share = loops.clipped(bend, offset_share)
        now = loops.at(bend, offset_share)
        twist = cycles[:, None] * now.cycle + now.ways
        value, slope = _advance_and_turn(twist)
        missing = wanted - value * scale
        slope = slope * scale[:, None]
        # Damped, since where loops only go straight, or only turn, one of the two equations is empty.
        normal = matmul(np.swapaxes(slope, 1, 2), slope)
        normal += 1e-6 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(2) + 1e-12 * np.eye(2)
        step = solve_positive(normal, apply(np.swapaxes(slope, 1, 2), missing))
        step = np.clip(step, -LONGEST_STEP_RAD, LONGEST_STEP_RAD)
        bend, offset_share = bend + step[:, 0], offset_share + step[:, 1]
    bend, offset_share = loops.clipped(bend, offset_share)
    per_cycle, for_ways = loops.costs(bend, offset_share)
    cost = (cycles * per_cycle + for_ways) / fan.unit
    return Fitted(cycles.astype(np.int64), bend, offset_share, cost)


def _advance_and_turn(twist: Array) -> tuple[Array, Array]:
    """Return advance and turn, not negative, of twists; with their slopes where those of the twists are given.

    Args:
        twist: Twists, shape (n, 6), or those and their slopes by two quantities, shape (3, n, 6).

    Returns:
        Values, shape (n, 2), and slopes, shape (n, 2, 2).
    """
    here = twist[0] if twist.ndim == 3 else twist
    turn = hypot(here[:, 4], here[:, 5])
    value = np.stack([np.abs(here[:, 0]), turn], axis=1)
    if twist.ndim != 3:
        return value, np.empty(0)
    forwards = np.sign(here[:, 0])
    safe = np.where(turn > 0.0, turn, 1.0)
    turning = (here[:, 4] * twist[1:, :, 4] + here[:, 5] * twist[1:, :, 5]) / safe
    return value, np.stack([forwards * twist[1:, :, 0], turning], axis=1).transpose(2, 1, 0)
