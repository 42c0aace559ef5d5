"""The equations of an exact arrival of moves, and their bends as inequalities, by the kernel (`moves.c`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.flow import Flow, refuse, repeats_of
from purcell_cli.kernel.library import KERNEL


class MoveEquations(NamedTuple):
    """What is missing of a displacement and of shapes after moves.

    Attributes:
        shapes: Shapes before, between and after the moves. Shape (n + 1, 2, 3, 3).
        turned: Each limb's rotation vectors in base coordinates [rad], then how its later path turns, in base
            coordinates, as they change in its own, (n, 2, 3) and (n, 2, 3, 3) in one. Shape (24 n,).
        residual: A twist and rotation vectors in base coordinates [L, rad]. Shape (6 + 6 t,).
        derivative: By the rotation vectors. Shape (6 + 6 t, 6 n).
    """

    shapes: Array
    turned: Array
    residual: Array
    derivative: Array


def equations(
    flow: Flow,
    start: ArrayLike,
    turn: ArrayLike,
    repeats: ArrayLike,
    wanted_inverse: ArrayLike,
    stops: ArrayLike,
    ends: ArrayLike,
) -> MoveEquations:
    """Return what is missing after moves, and its derivative.

    Args:
        flow: The swimmer's flow.
        start: Shape before the first move. Shape (2, 3, 3).
        turn: Rotation vectors of both limbs, each in its own frame [rad]. Shape (n, 6).
        repeats: Parts played more than once: first move, the move after the last, cycles. Shape (k, 3).
        wanted_inverse: The inverse of the displacement. Shape (4, 4).
        stops: The moves before which shapes are wanted, n for the end. Shape (t,).
        ends: Those shapes. Shape (t, 2, 3, 3).

    Raises:
        ValueError: A move is so long that it has more than two million steps, or arrays do not fit.
    """
    turns = doubles(turn, "turn", (-1, 6))
    n = len(turns)
    parts, stop = repeats_of(repeats, n), wholes(stops, "stops", (-1,))
    t = len(stop)
    begun, wanted = doubles(start, "start", (2, 3, 3)), doubles(wanted_inverse, "wanted_inverse", (4, 4))
    end = doubles(ends, "ends", (t, 2, 3, 3))
    if t and not 0 <= int(stop.min()) <= int(stop.max()) <= n:
        raise ValueError(f"stops: numbers from 0 to {n} are wanted")
    out = MoveEquations(np.empty((n + 1, 2, 3, 3)), np.empty(24 * n), np.empty(6 + 6 * t), np.empty((6 + 6 * t, 6 * n)))
    room = np.empty(94 * n + 36 * len(parts))
    places = address(begun), address(turns), len(parts), address(parts), address(wanted), t, address(stop), address(end)
    rest = (address(part) for part in (room, out.turned, out.shapes, out.residual, out.derivative))
    refuse(KERNEL.purcell_move_equations(*flow.head, n, *places, *rest), 0)
    return out


def bends(found: MoveEquations, least: ArrayLike, near: float) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative by the rotation vectors.

    Args:
        found: The moves, see `equations`.
        least: The least cosine of each limb's bend on each move. Shape (n, 2).
        near: More room than this does not matter, in the cosine of the bend.

    Returns:
        cos(bend) - least where a limb is most bent on a move, shape (j,), and its derivative, shape (j, 6 n).
    """
    n = len(found.shapes) - 1
    limit, room, slope = doubles(least, "least", (n, 2)), np.empty(2 * n), np.empty((2 * n, 6 * n))
    given = (address(part) for part in (found.shapes, found.turned, limit))
    many = KERNEL.purcell_move_bends(n, *given, float(near), address(room), address(slope))
    return room[:many], slope[:many]
