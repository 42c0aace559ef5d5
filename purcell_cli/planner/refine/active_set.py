"""Least-norm steps under equations, bounds and inequalities, by active-set methods."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.component_first import solve_positive
from purcell_cli.geometry.linear_systems import least_squares, solve
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array

_PINNED = 6
"""Newton steps on the multipliers in `least_steps`."""
_MET = 1e-4
"""`least_steps` ends when no equation misses by more than this, in all of its problems [L, rad]."""
_SHIFT = 1e-8
"""Damping of the multipliers' equations in `least_steps`, as a part of the trace."""
_BEND_SLACK = 1e-9
"""A step may break the linearised limits by this, in the cosine of the bend."""
_ACTIVE_ROUNDS = 12
"""Rounds in which `bounded_step` looks for the active constraints; the set that breaks limits least is kept."""
_WEAKEST = 1e-9
"""Cut-off of the singular values in the least-squares step, as a part of the largest."""
_DAMPING = 1e-13
"""Damping of the Gram matrix, as a part of its trace, so that dependent constraints leave it regular."""


def least_steps(columns: Array, wanted: Array, begun: Array, loose: Array, low: Array, high: Array) -> Array:
    """Return the steps nearest to others, between bounds, that meet few equations as far as they can. Shape (n, k).

    Newton's method on the multipliers of the equations: a step is where they lead, clipped
    (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865).

    Args:
        columns: The equations' matrices. Shape (n, 6, k).
        wanted: Their right sides. Shape (n, 6).
        begun: The other steps. Shape (n, k).
        loose: How loosely each unknown keeps to them, the inverse weights. Shape (n, k).
        low: The least values. Shape (n, k).
        high: The greatest values. Shape (n, k).
    """
    step = best = np.clip(begun, low, high)
    lead, least = np.zeros_like(wanted), np.full(len(wanted), np.inf)
    for _ in range(_PINNED):
        missing = wanted - (matmul(columns, step[..., None]))[..., 0]
        size = np.max(np.abs(missing), axis=1)
        best, least = np.where((size < least)[:, None], step, best), np.minimum(size, least)
        if np.all(size < _MET):
            break
        lever = columns * np.where((step > low) & (step < high), loose, 0.0)[:, None]
        system = matmul(lever, np.swapaxes(columns, 1, 2))
        # Damped slightly, since the free unknowns may be too few for all equations.
        system += (_SHIFT * np.trace(system, axis1=1, axis2=2) + 1e-30)[:, None, None] * np.eye(6)
        lead = lead + solve_positive(system, missing)
        step = np.clip(begun + loose * (matmul(lead[:, None], columns))[:, 0], low, high)
    return np.asarray(best)


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
