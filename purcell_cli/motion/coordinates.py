"""How large coordinates may be, so that files can say positions as exactly as is promised."""

from __future__ import annotations

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer

_LARGEST = 2.0**50
"""Largest coordinate, in units of the tolerance: beyond, doubles are more than a quarter of the tolerance apart."""


def refuse_large(swimmer: Swimmer, name: str, configuration: Configuration, tolerance_l: float = 1e-9) -> None:
    """Refuse coordinates of the base that are too large.

    Args:
        swimmer: The swimmer.
        name: What the configuration is, for the message.
        configuration: The configuration.
        tolerance_l: How exactly positions are to be said, in units of L.

    Raises:
        ParameterError: A coordinate so large that no file can say a position so exactly.
    """
    farthest, found = _LARGEST * tolerance_l * swimmer.length_m, configuration.pose[:3, 3]
    if np.any(np.abs(found) > farthest):
        largest = float(found[np.argmax(np.abs(found))])
        why = f"beyond, numbers cannot say a position to {tolerance_l:g} L, with L = {swimmer.length_m:g} m"
        most = f"{np.floor(farthest):.15g}" if farthest >= 1.0 else f"{farthest:.2g}"
        raise ParameterError(
            f"{name}: position_m: coordinates up to {most} m are wanted, found {largest!r} "
            f"({why}: move the world's origin nearer)"
        )
