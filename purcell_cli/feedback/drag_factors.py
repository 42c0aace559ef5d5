"""What of a swimmer's drag is unknown: factors on the drag of its links, tied together or each its own.

Motion alone tells no force: drags that are all twice as large lead along the same path. So the base's drag across its
axis, which the viscosity sets, is the unit of all others, and has no factor.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from enum import StrEnum

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import exp_of
from purcell_cli.mechanics.drag import COX, LINKS, LinkDrag, LinkDrags, RodDrag
from purcell_cli.mechanics.swimmer import Swimmer


class What(StrEnum):
    """Which factors are fitted."""

    RATIO = "ratio"
    KINDS = "kinds"
    LINKS = "links"


DIRECTIONS = ("along", "across", "turn", "spin")
"""The drags of a link: along and across its axis, turning about its middle, spinning about its axis."""

_KINDS: dict[What, dict[str, tuple[int, ...]]] = {
    What.KINDS: {"base": (0,), "limbs": (1, 2)},
    What.LINKS: {link: (k,) for k, link in enumerate(LINKS)},
}
"""The links whose drags have factors in common, by what is fitted."""


@frozen_dataclass
class Factor:
    """A factor on one drag of some links; of the ratio, on how many times the drag across is the drag along.

    Attributes:
        name: Its name, such as "limbs along".
        links: The numbers of the links that it is for.
        direction: One of `DIRECTIONS`, or "ratio".
    """

    name: str
    links: tuple[int, ...]
    direction: str

    def value(self, rod: RodDrag) -> float:
        """Return what the factor multiplies, of a link [N s/m, N m s, or none]."""
        return float(getattr(rod, self.direction))


def factors_of(what: What) -> tuple[Factor, ...]:
    """Return the factors that are fitted; the base's drag across has none."""
    if what == What.RATIO:
        return (Factor("ratio", (0, 1, 2), "ratio"),)
    return tuple(
        Factor(f"{kind} {direction}", links, direction)
        for kind, links in _KINDS[what].items()
        for direction in DIRECTIONS
        if (kind, direction) != ("base", "across")
    )


def with_factors(guess: Swimmer, factors: Sequence[Factor], logs: Sequence[float]) -> Swimmer:
    """Return a swimmer whose drags are multiplied.

    Args:
        guess: The swimmer.
        factors: What is multiplied.
        logs: The factors' natural logarithms.

    Raises:
        ParameterError: No link can have such a drag, or not beside the others.
    """
    if [f.name for f in factors] == ["ratio"] and guess.drag == COX:
        return dataclasses.replace(guess, drag_ratio=guess.drag_ratio * exp_of(logs[0]))
    times = {(link, f.direction): exp_of(log) for f, log in zip(factors, logs, strict=True) for link in f.links}

    def drag(link: int) -> LinkDrag:
        rod = guess.rod(link)
        along = rod.along * times.get((link, "along"), 1.0) / times.get((link, "ratio"), 1.0)
        rest = (getattr(rod, name) * times.get((link, name), 1.0) for name in DIRECTIONS[1:])
        return LinkDrag(along, *rest)

    return dataclasses.replace(guess, drag=LinkDrags(*(drag(link) for link in range(3))))
