"""A descent by steps within a trust region, for minimum travel and for minimum time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from purcell_cli.geometry.rotations import Array

FIRST_REACH = 0.1
"""Radius of the trust region at the first step [rad]."""
LARGEST_REACH = 0.5
"""The largest radius [rad]."""
LEAST_REACH = 1e-4
"""The search ends when the radius is below this [rad]."""


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
    reach: float = FIRST_REACH,
) -> tuple[P, float]:
    """Return the point that steps within a trust region lead to, and its last radius (Fletcher and de la Maza 1989).

    Args:
        here: The point to begin at.
        propose: Returns where to go within a reach, and the merit promised there; None where it finds nothing.
        land: Returns the point reached from a point, for a place, the gain promised and the reach.
        steps: The most steps.
        worth: What a step must promise, from a point, to be worth it.
        reach: The radius at the first step [rad].
    """
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
            reach = min(2.0 * reach, LARGEST_REACH)
        elif kept < 0.2:
            reach *= 0.35
        if reach < LEAST_REACH or promised < worth(here):
            break
    return here, reach
