"""One loop: a rectangle of two joint angles, or some from one corner, and the way to where it begins.

A loop begins and ends at the shape between the phases: an approach leads to its corner, and away again. Joint angles
of which each closes by itself make the rectangle close exactly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arcsin, arctan2, matmul
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics.primitives import EMPTY, PRIMITIVE_NAMES, PrimitiveSequence, joined

Aside = tuple[int, float] | None
"""Another control, and the angle that it is kept at during a loop [rad]; None where all others rest at home."""


@frozen_dataclass(eq=False)
class Loop:
    """A rectangle of two angles, or some with a corner at home, one after the other.

    Attributes:
        approach: The primitives from the shape between the phases to its corner.
        cycle: Its primitives, four a rectangle.
    """

    approach: PrimitiveSequence
    cycle: PrimitiveSequence

    @property
    def kind(self) -> str:
        """What it is."""
        return "loop" if len(self.cycle) < 10 else "mirrored loops"

    @property
    def name(self) -> str:
        """What its stroke is called."""
        return " ".join(
            [
                self.kind,
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


Side = tuple[float, float, bool]
"""The pitch and the yaw that a ball joint's loop begins with [rad], and whether it is played forward."""


@frozen_dataclass(eq=False)
class RolledLoop(Loop):
    """Loops of a ball joint's yaw and pitch, one after the other, which a roll closes: two axes of a limb alone do not.

    Attributes:
        limb: The limb, 0 or 1.
        sides: What each begins with.
    """

    limb: int
    sides: tuple[Side, ...]

    def sized(self, part: float) -> Loop:
        """Return the loops from the same corner, with their first two sides a part of what they are."""
        return rolled(self.approach, self.limb, [(part * pitch, part * yaw, on) for pitch, yaw, on in self.sides])


def rolled(approach: PrimitiveSequence, limb: int, sides: Sequence[Side]) -> RolledLoop:
    """Return loops of a limb on a ball joint from one corner.

    With R = Ry(pitch) Rz(yaw) the way back is Ry(a) Rz(b) Rx(c) = R^-1: its angles in the order y, z, x.
    """
    x, y, z = 3 * limb, 3 * limb + 1, 3 * limb + 2
    played = []
    for pitch, yaw, forward in sides:
        back = matmul(about_axis(1, pitch), about_axis(2, yaw)).T
        b = float(arcsin(np.clip(back[1, 0], -1.0, 1.0)))
        a, c = float(arctan2(-back[2, 0], back[0, 0])), float(arctan2(-back[1, 2], back[1, 1]))
        loop = PrimitiveSequence.of([(y, pitch), (z, yaw), (y, a), (z, b), (x, c)])
        played.append(loop if forward else loop.inverse())
    return RolledLoop(approach, joined(played), limb, tuple(sides))


@frozen_dataclass(eq=False)
class PairedLoop(Loop):
    """Two loops, one after the other, each from home and back.

    Attributes:
        loops: The loops.
        forward: Whether each is played forward.
    """

    loops: tuple[Loop, Loop]
    forward: tuple[bool, bool]

    @property
    def kind(self) -> str:
        """What it is."""
        return "paired loops"

    def sized(self, part: float) -> Loop:
        """Return both loops with their sides a part of what they are."""
        first, second = (loop.sized(part) for loop in self.loops)
        return paired((first, second), self.forward)


def paired(loops: tuple[Loop, Loop], forward: tuple[bool, bool]) -> PairedLoop:
    """Return two loops of a limb one after the other, forward or backward."""
    played = []
    for loop, on in zip(loops, forward, strict=True):
        cycle = loop.cycle if on else loop.cycle.inverse()
        played += [loop.approach, cycle, loop.approach.inverse()]
    return PairedLoop(EMPTY, joined(played).busy(), loops, forward)


def _merged(sequence: PrimitiveSequence) -> PrimitiveSequence:
    """Return an approach with each control once, in the order in which they first act."""
    order = list(dict.fromkeys(sequence.control.tolist()))
    return PrimitiveSequence.of([(c, float(np.sum(sequence.angle[sequence.control == c]))) for c in order])


def rectangle(pair: tuple[int, int], first: tuple[float, float], second: tuple[float, float], offset: Aside) -> Loop:
    """Return the rectangle of two controls between two angles of each [rad]."""
    approach = ([] if offset is None else [offset]) + [(pair[0], first[0]), (pair[1], second[0])]
    a, b = first[1] - first[0], second[1] - second[0]
    cycle = PrimitiveSequence.of([(pair[0], a), (pair[1], b), (pair[0], -a), (pair[1], -b)])
    return Loop(PrimitiveSequence.of(approach), cycle)
