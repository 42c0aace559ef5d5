"""One loop: a rectangle of two joint angles, or some from one corner, and the way to where it begins.

A loop begins and ends at the shape between the phases: an approach leads to its corner, and away again. Joint angles
of which each closes by itself make the rectangle close exactly.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.mechanics.primitives import PRIMITIVE_NAMES, PrimitiveSequence

Aside = tuple[int, float] | None
"""Another control, and the angle that it is kept at during a loop [rad]; None where all others rest at home."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """A rectangle of two angles, or some with a corner at home, one after the other.

    Attributes:
        approach: The primitives from the shape between the phases to its corner.
        cycle: Its primitives, four a rectangle.
    """

    approach: PrimitiveSequence
    cycle: PrimitiveSequence

    @property
    def name(self) -> str:
        """What its stroke is called."""
        return " ".join(
            [
                "loop" if len(self.cycle) == 4 else "mirrored loops",
                *(PRIMITIVE_NAMES[c].replace("base ", "") for c in self.cycle.control[:2]),
            ]
        )

    def sized(self, part: float) -> Loop:
        """Return the loop about the same centre, or from the same corner, with its sides a part of what they are."""
        if len(self.cycle) > 4:
            return Loop(self.approach, self.cycle.with_angles(part * self.cycle.angle))
        sides = self.cycle.angle[:2]
        moved = 0.5 * (1.0 - part) * sides
        approach = self.approach + PrimitiveSequence(self.cycle.control[:2], moved)
        return Loop(_merged(approach), self.cycle.with_angles(part * self.cycle.angle))


def _merged(sequence: PrimitiveSequence) -> PrimitiveSequence:
    """Return an approach with each control once, in the order in which they first act."""
    order = list(dict.fromkeys(sequence.control.tolist()))
    return PrimitiveSequence.of([(c, float(np.sum(sequence.angle[sequence.control == c]))) for c in order])


def rectangle(pair: tuple[int, int], first: tuple[float, float], second: tuple[float, float], aside: Aside) -> Loop:
    """Return the rectangle of two controls between two angles of each [rad]."""
    approach = ([] if aside is None else [aside]) + [(pair[0], first[0]), (pair[1], second[0])]
    a, b = first[1] - first[0], second[1] - second[0]
    cycle = PrimitiveSequence.of([(pair[0], a), (pair[1], b), (pair[0], -a), (pair[1], -b)])
    return Loop(PrimitiveSequence.of(approach), cycle)
