"""Least-norm steps under equations, bounds and inequalities, by an active-set method of the kernel."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import shooting


def bounded_step(arrival: Array, missing: Array, slack: Array, slack_derivative: Array, reach: float) -> Array:
    """Return the least step to the arrival that leaves no limb bent too far, as far as is linear. Shape (n,).

    An angle that moves the base by much counts for more: its changes are what is least linear.
    Which limits bind is found by the multipliers' signs (primal-dual active sets: Hintermueller, Ito
    and Kunisch 2002, SIAM J. Optim. 13, 865).

    Args:
        arrival: Derivative of what is missing, that of the base's pose [L, rad] first. Shape (m, n).
        missing: What is missing. Shape (m,).
        slack: What is left below the bend limit, in the cosine of the bend. Shape (k,).
        slack_derivative: Its derivative. Shape (k, n).
        reach: The largest component of the step [rad].
    """
    return shooting.bounded_step(arrival, missing, slack, slack_derivative, reach)


def loose(arrival: Array) -> Array:
    """Return by how much less angles may change that move the base more. Shape (m, n) to (n,)."""
    return np.asarray(1.0 / np.sqrt(1.0 + np.sqrt(np.add.reduce(arrival[:6] * arrival[:6], axis=0))))
