"""A descent by steps within a trust region: its radii and its rule are those of every objective.

Minimum time and minimum energy descend here; minimum travel, by many short steps, in the kernel (`descent.c`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.trust_region import step_taken

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
        taken, reach = step_taken(promised, here.merit - there.merit, reach, LARGEST_REACH)
        if taken:
            here = there
        if reach < LEAST_REACH or promised < worth(here):
            break
    return here, reach
