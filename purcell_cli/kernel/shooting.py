"""The bend limit as inequalities on angles, and least steps under equations and inequalities, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL
from purcell_cli.kernel.shapes import control_numbers


def bend_rows(
    controls: ArrayLike, angles: ArrayLike, shapes: ArrayLike, least: ArrayLike, fixed: ArrayLike, near: float
) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative by all angles.

    Args:
        controls: Which control each primitive turns, 6 and 7 about the base's z. Shape (n,).
        angles: By how much [rad]. Shape (n,).
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        least: The least cosine of each limb's bend on each primitive. Shape (n, 2).
        fixed: 1 for primitives whose room does not matter, else 0. Shape (n,).
        near: More room than this does not matter, in the cosine of the bend.

    Returns:
        cos(bend) - least at the ends or far sides of primitives, shape (j,), and its derivative, shape (j, n).
    """
    angle = doubles(angles, "angles", (-1,))
    n = len(angle)
    control, shape = control_numbers(controls, n), doubles(shapes, "shapes", (n + 1, 2, 3, 3))
    limit, still = doubles(least, "least", (n, 2)), wholes(fixed, "fixed", (n,))
    places, room, slope = np.empty(6 * n), np.empty(n), np.empty((n, n))
    given = (address(part) for part in (control, angle, shape, limit, still))
    many = KERNEL.purcell_bend_rows(n, *given, float(near), *(address(part) for part in (places, room, slope)))
    return room[:many], slope[:many]


def bounded_step(
    arrival: ArrayLike, missing: ArrayLike, room: ArrayLike, slope: ArrayLike, reach: float, fine: bool = True
) -> Array:
    """Return the least step to the arrival under inequalities, as far as is linear. Shape (n,).

    Args:
        arrival: Derivative of what is missing, that of the base's pose first. Shape (m, n), m 6 at least.
        missing: What is missing. Shape (m,).
        room: Room left below the limits. Shape (k,).
        slope: Its derivative. Shape (k, n).
        reach: The largest component of the step.
        fine: Whether it is right to all digits, or to some six of them, as in searches where more steps follow.
    """
    equations = doubles(arrival, "arrival", (-1, -1))
    m, n = equations.shape
    if m < 6:
        raise ValueError(f"arrival: six equations at least are wanted, found {m}")
    left, rest = doubles(missing, "missing", (m,)), doubles(room, "room", (-1,))
    k = len(rest)
    rows, out, r = doubles(slope, "slope", (k, n)), np.empty(n), m + k
    work = np.empty(2 * n + 3 * r * n + 4 * r * r + 8 * r + 8)
    if n:
        given = (address(part) for part in (equations, left, rest, rows))
        KERNEL.purcell_bounded_step(m, k, n, *given, float(reach), int(fine), address(work), address(out))
    return out
