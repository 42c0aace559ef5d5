"""Least-norm steps under equations, bounds and inequalities, by active-set methods."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.linear_systems import least_squares, solve
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array

_BEND_SLACK = 1e-9
"""A step may break the linearised limits by this, in the cosine of the bend."""
_ACTIVE_ROUNDS = 12
"""Rounds in which `bounded_step` looks for the active constraints; the set that breaks limits least is kept."""
_WEAKEST = 1e-9
"""Cut-off of the singular values in the least-squares step, as a part of the largest."""
_DAMPING = 1e-13
"""Damping of the Gram matrix, as a part of its trace, so that dependent constraints leave it regular."""


def bounded_step(arrival: Array, missing: Array, room: Array, room_derivative: Array, reach: float) -> Array:
    """Return the least step to the arrival that leaves no limb bent too far, as far as is linear. Shape (n,).

    An angle that moves the base by much counts for more: its changes are what is least linear.
    Which limits bind is found by the multipliers' signs (primal-dual active sets: Hintermueller, Ito
    and Kunisch 2002, SIAM J. Optim. 13, 865).

    Args:
        arrival: Derivative of what is missing, that of the base's pose [L, rad] first. Shape (m, n).
        missing: What is missing. Shape (m,).
        room: Room left below the bend limit, in the cosine of the bend. Shape (k,).
        room_derivative: Its derivative. Shape (k, n).
        reach: The largest component of the step [rad].
    """
    weight = loose(arrival)
    rows, wanted = np.concatenate([arrival, room_derivative]) * weight, -np.concatenate([missing, room])
    gram, equal = matmul(rows, rows.T), np.arange(len(wanted)) < len(missing)
    gram[np.diag_indices(len(gram))] += _DAMPING * np.trace(gram) + 1e-30
    active = kept = equal
    least, tried = np.inf, set[bytes]()
    for _ in range(_ACTIVE_ROUNDS):
        multipliers = np.zeros(len(wanted))
        multipliers[active] = solve(gram[np.ix_(active, active)], wanted[active])
        excess = np.where(equal, 0.0, wanted - matmul(gram, multipliers))
        broken = excess > _BEND_SLACK
        if (worst := float(np.max(excess, initial=0.0))) < least:
            kept, least = active, worst
        if not np.any(broken):
            break
        tried.add(active.tobytes())
        renewed = equal | (multipliers > 0.0) | broken
        active = active | broken if renewed.tobytes() in tried else renewed
    step = weight * least_squares(rows[kept], wanted[kept], _WEAKEST)
    return np.asarray(step * min(1.0, reach / max(float(np.max(np.abs(step), initial=0.0)), 1e-300)))


def loose(arrival: Array) -> Array:
    """Return by how much less angles may change that move the base more. Shape (m, n) to (n,)."""
    return np.asarray(1.0 / np.sqrt(1.0 + np.sqrt(np.add.reduce(arrival[:6] * arrival[:6], axis=0))))
