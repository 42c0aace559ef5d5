"""The bend limit as inequalities on angles, and least steps under equations and inequalities, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, Whole, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL
from purcell_cli.kernel.shapes import control_numbers


class Rooms:
    """Memory for the rooms below limits on n primitives.

    Args:
        controls: The controls, as `control_numbers` gives them. Shape (n,).
        shapes: Shapes before, between and after the primitives. Shape (n + 1, 2, 3, 3).
    """

    def __init__(self, controls: Whole, shapes: Array) -> None:
        self._motion, n = (controls, shapes), len(shapes) - 1
        self._room, self._of, self._stop = np.empty(n), np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        self._torque = np.empty(6 * n)

    @property
    def places(self) -> list[int]:
        """Where the rooms, their primitives, where they are looked at and the torques there go."""
        return [address(part) for part in (self._room, self._of, self._stop, self._torque)]

    def sloped(self, count: int) -> tuple[Array, Array]:
        """Return the first rooms and their derivative by all angles. Shapes (count,) and (count, n)."""
        control, shapes = self._motion
        n = len(shapes) - 1
        axes, slope = np.empty(6 * n), np.empty((count, n))
        given = address(self._stop), address(self._torque), n, address(control), address(shapes)
        KERNEL.purcell_room_slopes(count, *given, address(axes), address(slope))
        return self._room[:count], slope


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
    if control is None:
        raise ValueError("controls: numbers from 0 to 7 are wanted")
    rooms = Rooms(control, shape)
    given = (address(part) for part in (control, angle, shape, limit, still))
    return rooms.sloped(KERNEL.purcell_bend_rooms(n, *given, float(near), *rooms.places))


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
    rows, out = doubles(slope, "slope", (k, n)), np.empty(n)
    work = np.empty(KERNEL.purcell_step_room(m + k, n))
    if n:
        given = (address(part) for part in (equations, left, rest, rows))
        KERNEL.purcell_bounded_step(m, k, n, *given, float(reach), int(fine), address(work), address(out))
    return out
