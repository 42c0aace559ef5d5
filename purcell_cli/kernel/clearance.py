"""The circles that limbs' axes run along, how far limbs bend, and how near they come to each other, by the kernel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, Whole, address, doubles
from purcell_cli.kernel.library import KERNEL
from purcell_cli.kernel.shapes import control_numbers
from purcell_cli.kernel.shooting import Rooms

_ROOM = 2 * 1024 * 5
"""How many numbers the kernel works in at one primitive; see `kernel.h`."""


class Circles(NamedTuple):
    """The circles of both limbs' axes on n pieces: at time t, centre + cos(turn t) cosine + sin(turn t) sine.

    Shapes (n, 2, 3) three times, and (n, 2).
    """

    centre: Array
    cosine: Array
    sine: Array
    turn: Array


class Nearest(NamedTuple):
    """The least distances in groups of pieces, on which pieces they are, when, and by how much less they may be."""

    distance: Array
    piece: Whole
    time: Array
    error: float


class Apart(NamedTuple):
    """How far limbs must be apart on n primitives.

    Attributes:
        least: The least distance of the limbs' surfaces on each; -infinity where it does not matter. Shape (n,).
        links: As of `nearest`.
        small: How exactly distances are found.
        straight: The distance of straight limbs: if it exceeds the least ones by `near`, limbs matter where one folds.
        near: Distances that exceed the least by more than this do not matter.
    """

    least: Array
    links: tuple[float, float, float, float]
    small: float
    straight: float
    near: float

    def numbers(self) -> Array:
        """Return the links and what is small, as the kernel takes them. Shape (5,)."""
        return doubles((*self.links, self.small), "links", (5,))


def circles(shapes: ArrayLike, rates: ArrayLike) -> Circles:
    """Return the circles of pieces.

    Args:
        shapes: Shapes where they begin. Shape (n, 2, 3, 3).
        rates: Limb rates (omega_1, omega_2). Shape (n, 6).
    """
    shape = doubles(shapes, "shapes", (-1, 2, 3, 3))
    n = len(shape)
    rate = doubles(rates, "rates", (n, 6))
    out = Circles(np.empty((n, 2, 3)), np.empty((n, 2, 3)), np.empty((n, 2, 3)), np.empty((n, 2)))
    KERNEL.purcell_circles(n, address(shape), address(rate), *(address(part) for part in out))
    return out


def largest_bends(motion: Circles, durations: ArrayLike) -> tuple[Array, Array]:
    """Return each limb's largest bend on each piece, at any instant of it, and when. Shapes (n, 2).

    Args:
        motion: The circles.
        durations: How long the pieces last. Shape (n,).
    """
    arrays, n = _checked(motion, durations)
    bend, time = np.empty((n, 2)), np.empty((n, 2))
    KERNEL.purcell_largest_bends(n, *(address(part) for part in arrays), address(bend), address(time))
    return bend, time


def nearest(
    motion: Circles,
    durations: ArrayLike,
    links: tuple[float, float, float, float],
    apart: bool,
    enough: float,
    small: float,
    most: int,
) -> Nearest:
    """Return the least distances between the surfaces of both limbs.

    Args:
        motion: The circles.
        durations: How long the pieces last. Shape (n,).
        links: Half the base's length, the lengths of both limbs, and their radii together.
        apart: Whether each piece is a group of its own; otherwise all are one.
        enough: Distances above this need not be found exactly.
        small: How exactly the others are found.
        most: How many stretches are looked at at once; where more are wanted, the error is told.
    """
    arrays, n = _checked(motion, durations)
    groups = n if apart else min(n, 1)
    best, time, piece = np.full(groups, np.inf), np.zeros(groups), np.zeros(groups, dtype=np.int64)
    numbers, stretches, error = doubles((*links, small), "links", (5,)), np.empty((n, 5)), np.empty(1)
    places = [address(part) for part in (numbers, *arrays)]
    search = *places, int(apart), float(enough), address(best), address(time), address(piece)
    count = KERNEL.purcell_clearance_begun(n, *search, address(stretches))
    while count > 0:
        cut = np.empty((4 * count, 5))
        count = KERNEL.purcell_clearance_cut(count, *search, address(stretches), most, address(cut), address(error))
        stretches = cut
    return Nearest(best, piece, time, float(error[0]) if count < 0 else small)


def rows(controls: ArrayLike, angles: ArrayLike, shapes: ArrayLike, apart: Apart) -> tuple[Array, Array]:
    """Return what limbs are farther apart than they must be where that is little, and its derivative by the angles.

    Args:
        controls: The controls of primitives, 0 to 7. Shape (n,).
        angles: How far each turns [rad]. Shape (n,).
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        apart: How far they must be.

    Returns:
        The excess, shape (m,), and its derivative, shape (m, n), of m primitives.
    """
    angle = doubles(angles, "angles", (-1,))
    n = len(angle)
    control = control_numbers(controls, n)
    if control is None:
        raise ValueError("controls: numbers from 0 to 7 are wanted")
    shape, least, work = (
        doubles(shapes, "shapes", (n + 1, 2, 3, 3)),
        doubles(apart.least, "least", (n,)),
        np.empty(_ROOM),
    )
    rooms = Rooms(control, shape)
    numbers = apart.numbers()
    places = [address(part) for part in (control, angle, shape, least, numbers)]
    limits = float(apart.straight), float(apart.near), address(work)
    return rooms.sloped(KERNEL.purcell_clearance_rooms(n, *places, *limits, *rooms.places))


def _checked(motion: Circles, durations: ArrayLike) -> tuple[list[Array], int]:
    """Return the arrays of circles and the durations, and how many pieces there are."""
    turn = doubles(motion.turn, "turn", (-1, 2))
    n = len(turn)
    arrays = [doubles(part, name, (n, 2, 3)) for part, name in zip(motion[:3], Circles._fields, strict=False)]
    return [*arrays, turn, doubles(durations, "durations", (n,))], n
