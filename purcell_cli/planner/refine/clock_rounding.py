"""Angles rounded to the clock one by one, so that those after each take up what it leaves of the arrival."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.refine.shooting import Equations

_DAMPING = 1e-12
"""Damping of the Gram matrix where angles are rounded one by one, as a part of its trace."""
_IDLE = 1e-6
"""Angles that move the goal by less than this part of the one that moves it most are not rounded one by one: such steps
would be too large to be told by a derivative."""
_PASSES = 2
"""How often all angles are rounded, at the most."""


def one_by_one(
    equations: Equations, angle: Array, missing: Array, derivative: Array, rounded: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Return angles on the clock that come nearer than those which are rounded all at once.

    The angle that counts most is rounded first, and those after it take up what that leaves (Babai's nearest plane:
    Combinatorica 6, 1986, 1), until what is left is a rounding error of the angles that count least.

    Args:
        equations: The equations.
        angle: Angles on the clock, almost there [rad]. Shape (n,).
        missing: What is missing there [L, rad]. Shape (m,).
        derivative: Its derivative, roughly. Shape (m, n).
        rounded: Rounds angles to what the clock can tell [rad].
    """
    best, kept = missing, angle
    size = np.sqrt(np.add.reduce(derivative * derivative, axis=0))
    order = np.argsort(-size, kind="stable")
    order = order[size[order] > _IDLE * np.max(size, initial=0.0)]
    columns = derivative.T[order]
    # Of each angle and all after it, summed from the last on.
    gram = np.add.accumulate((columns[:, :, None] * columns[:, None, :])[::-1])[::-1]
    trace = np.add.reduce(np.diagonal(gram, axis1=1, axis2=2), axis=1)
    gram = gram + (_DAMPING * trace + 1e-300)[:, None, None] * np.eye(len(derivative))
    lead = solve(gram, columns[:, :, None])[..., 0]
    for _ in range(_PASSES):
        left, there = best.copy(), kept.copy()
        for k, j in enumerate(order.tolist()):
            step = -float(np.add.reduce(lead[k] * left))
            there[j] = rounded(there[j : j + 1] + step)[0]
            left = left + columns[k] * (there[j] - kept[j])
        found = equations.residual(there)
        if np.max(np.abs(found)) >= np.max(np.abs(best)):
            break
        best, kept = found, there
    return kept, best
