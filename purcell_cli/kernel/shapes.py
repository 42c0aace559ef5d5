"""The limbs' orientations along a sequence of controls, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, Whole, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL


def shapes_along(start: ArrayLike, controls: ArrayLike | None, amounts: ArrayLike) -> Array:
    """Return the shapes before, between and after pieces.

    Args:
        start: Shape before the first. Shape (2, 3, 3).
        controls: Which control each primitive turns, 6 and 7 about the base's z, shape (n,); None for moves.
        amounts: The primitives' angles, shape (n,), or the moves' rotation vectors, shape (n, 6) [rad].

    Returns:
        Shapes. Shape (n + 1, 2, 3, 3).
    """
    amount = doubles(amounts, "amounts", (-1,) if controls is not None else (-1, 6))
    n = len(amount)
    begun, control, out = doubles(start, "start", (2, 3, 3)), control_numbers(controls, n), np.empty((n + 1, 2, 3, 3))
    which = None if control is None else address(control)
    KERNEL.purcell_shapes(n, address(begun), which, address(amount), address(out))
    return out


def control_numbers(controls: ArrayLike | None, n: int) -> Whole | None:
    """Return the controls of n primitives, shape (n,), or None for moves.

    Raises:
        ValueError: Another number of them, or one that is not from 0 to 7.
    """
    if controls is None:
        return None
    control = wholes(controls, "controls", (n,))
    if n and control.view(np.uint64).max() > 7:  # what is negative is large
        raise ValueError("controls: numbers from 0 to 7 are wanted")
    return control
