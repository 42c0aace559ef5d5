"""Positions and angles as they are given: three finite numbers, or a refusal that says what they are called."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array


def three_numbers(given: ArrayLike, name: str) -> Array:
    """Return three finite numbers. Shape (3,).

    Args:
        given: The numbers.
        name: What they are called.

    Raises:
        ParameterError: Not three, or not finite.
    """
    try:
        found = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (3,) or not np.all(np.isfinite(found)):
        raise ParameterError(f"{name}: three finite numbers are wanted, found {given!r}")
    return found
