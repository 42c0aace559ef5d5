"""The steps of plans by primitives and of quick plans alike: Newton steps within limits, and trust regions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from purcell_cli.geometry.rotations import Array

_BEND_SLACK = 1e-9
_ACTIVE_ROUNDS = 12
_WEAKEST, _DAMPING = 1e-9, 1e-13
_FIRST_REACH, _LARGEST_REACH, _LEAST_REACH = 0.1, 0.5, 1e-4


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
    gram, equal = rows @ rows.T, np.arange(len(wanted)) < len(missing)
    gram[np.diag_indices(len(gram))] += _DAMPING * np.trace(gram) + 1e-30
    active = kept = equal
    least, tried = np.inf, set[bytes]()
    for _ in range(_ACTIVE_ROUNDS):
        multipliers = np.zeros(len(wanted))
        multipliers[active] = np.linalg.solve(gram[np.ix_(active, active)], wanted[active])
        excess = np.where(equal, 0.0, wanted - gram @ multipliers)
        broken = excess > _BEND_SLACK
        if (worst := float(np.max(excess, initial=0.0))) < least:
            kept, least = active, worst
        if not np.any(broken):
            break
        tried.add(active.tobytes())
        renewed = equal | (multipliers > 0.0) | broken
        active = active | broken if renewed.tobytes() in tried else renewed
    step = weight * _least(rows[kept], wanted[kept])
    return np.asarray(step * min(1.0, reach / max(float(np.max(np.abs(step), initial=0.0)), 1e-300)))


def loose(arrival: Array) -> Array:
    """Return by how much less angles may change that move the base more. Shape (m, n) to (n,)."""
    return np.asarray(1.0 / np.sqrt(1.0 + np.sqrt(np.einsum("ij,ij->j", arrival[:6], arrival[:6]))))


def _least(rows: Array, wanted: Array) -> Array:
    """Return the least solution of few equations in many unknowns. Shape (n,)."""
    orthogonal, triangle = np.linalg.qr(rows.T)
    size = np.abs(np.diagonal(triangle))
    if len(size) == len(rows) and np.min(size) > _WEAKEST * np.max(size):
        return np.asarray(orthogonal @ np.linalg.solve(triangle.T, wanted))
    return np.asarray(np.linalg.lstsq(rows, wanted, rcond=_WEAKEST)[0])


class _Point(Protocol):
    @property
    def merit(self) -> float: ...


P = TypeVar("P", bound=_Point)


def descended(
    here: P,
    propose: Callable[[P, float], tuple[Array, float] | None],
    land: Callable[[P, Array, float, float], P],
    steps: int,
    worth: Callable[[P], float],
) -> P:
    """Return the point that steps within a trust region lead to (Fletcher and de la Maza 1989).

    Args:
        here: The point to begin at.
        propose: Returns where to go within a reach, and the merit promised there; None where it finds nothing.
        land: Returns the point reached from a point, for a place, the gain promised and the reach.
        steps: The most steps.
        worth: What a step must promise, from a point, to be worth it.
    """
    reach = _FIRST_REACH
    for _ in range(steps):
        found = propose(here, reach)
        if found is None:
            break
        promised = here.merit - found[1]
        there = land(here, found[0], promised, reach)
        kept = (here.merit - there.merit) / promised if promised > 0 else 0.0
        if kept > 0.02:
            here = there
        if kept > 0.6:
            reach = min(2.0 * reach, _LARGEST_REACH)
        elif kept < 0.2:
            reach *= 0.35
        if reach < _LEAST_REACH or promised < worth(here):
            break
    return here
