"""How a step within a trust region is judged, by the kernel (`trust_region.c`), for every objective alike."""

from __future__ import annotations

import ctypes

from purcell_cli.kernel.library import KERNEL


def step_taken(promised: float, gained: float, reach: float, largest: float) -> tuple[bool, float]:
    """Return whether a step is taken, and the next radius of the trust region.

    Args:
        promised: What the step's program promised to gain.
        gained: What it gains.
        reach: The radius it was made within.
        largest: The largest radius.
    """
    radius = ctypes.c_double(reach)
    taken = KERNEL.purcell_step_taken(float(promised), float(gained), float(largest), ctypes.addressof(radius))
    return bool(taken), radius.value
