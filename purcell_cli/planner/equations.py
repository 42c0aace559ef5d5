"""The equations of an exact arrival, and their derivatives, for a whole motion at once.

A motion is cut into stretches: runs of primitives whose angles may change, and strokes that repeat
and stay as they are. Every free stretch must end at its shape, and the base at the goal: six
equations for the base and six for each free stretch. Left invariance carries each stretch's own
derivative to the end by the adjoint of what follows it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from purcell_cli import se3
from purcell_cli.connection import COLLINEAR
from purcell_cli.lift import EXACT, Accuracy, flow, flow_and_jacobian, shape_gap
from purcell_cli.primitives import PrimitiveSequence
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A part of a motion.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        strokes: The strokes it consists of, in order: name, amplitude [rad] and number of primitives.
        sequence: Its primitives.
        start: Shape before it. Shape (2, 3, 3).
        end: Shape it must end at. Shape (2, 3, 3).
        cycles: How often it is played; one that repeats stays as it is.
    """

    phase: int
    strokes: tuple[tuple[str, float, int], ...]
    sequence: PrimitiveSequence
    start: Array
    end: Array
    cycles: int = 1

    @property
    def free(self) -> bool:
        """Whether its angles may change."""
        return self.cycles == 1

    def renamed(self, name: str, sequence: PrimitiveSequence) -> Stretch:
        """Return the stretch with other primitives, all of one stroke."""
        return dataclasses.replace(self, sequence=sequence, strokes=((name, math.nan, len(sequence)),))

    def blocks(self) -> list[Block]:
        """Return its strokes as blocks."""
        out, position = [], 0
        for name, amplitude, count in self.strokes:
            part = self.sequence[position : position + count]
            out.append(Block(self.phase, name, part, self.cycles, amplitude))
            position += count
        return out


def stretches_of(blocks: Sequence[Block], start: Array, goal: Array) -> list[Stretch]:
    """Return blocks as stretches: neighbours that may change together are joined.

    Args:
        blocks: The motion.
        start: Shape before it. Shape (2, 3, 3).
        goal: Shape it must end at; the limbs are collinear where a phase ends before that. Shape (2, 3, 3).
    """
    out: list[Stretch] = []
    shape = start
    for block in blocks:
        after = block.sequence.shapes(shape)[-1]
        stroke = (block.gait, block.amplitude_rad, len(block.sequence))
        last = out[-1] if out else None
        if last is not None and last.free and block.cycles == 1 and last.phase == block.phase:
            strokes = (*last.strokes, stroke)
            out[-1] = dataclasses.replace(last, strokes=strokes, sequence=last.sequence + block.sequence, end=after)
        else:
            if last is not None and last.phase != block.phase:
                out[-1], shape = dataclasses.replace(last, end=COLLINEAR), COLLINEAR
            out.append(Stretch(block.phase, (stroke,), block.sequence, shape, after, block.cycles))
        shape = after
    if out:
        out[-1] = dataclasses.replace(out[-1], end=goal)
    return out


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Values:
    """The equations at one set of angles.

    Attributes:
        residual: What is missing [L, rad]. Shape (m,).
        derivative: By every free angle. Shape (m, n).
    """

    residual: Array
    derivative: Array

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.max(np.abs(self.residual)))


class Equations:
    """The equations of one motion.

    A repeated stroke multiplies what its first shape is off by the number of its cycles. Exact
    equations therefore follow the shapes as they come; those to search by take every stretch from
    the shape it ought to start at, and compute the repeated strokes once.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        stretches: The parts of the motion.
        displacement: Body displacement the motion must make, in units of L. Shape (4, 4).
        accuracy: Of the flow.
    """

    def __init__(
        self, swimmer: Swimmer, stretches: Sequence[Stretch], displacement: Array, accuracy: Accuracy = EXACT
    ) -> None:
        self.swimmer, self.accuracy = swimmer, accuracy
        self.stretches = tuple(stretches)
        self.wanted_inverse = se3.inverse(displacement)
        self._repeated: dict[tuple[int, bytes], Array] = {}
        counts = [len(s.sequence) if s.free else 0 for s in self.stretches]
        ends = np.cumsum(counts)
        self._slices = [slice(int(end) - n, int(end)) for n, end in zip(counts, ends, strict=True)]

    def angles(self) -> Array:
        """Return the angles of all free stretches as they are [rad]. Shape (n,)."""
        return np.concatenate([np.empty(0), *(s.sequence.angle for s in self.stretches if s.free)])

    def tail(self) -> int:
        """Return the first angle of those after which no stroke repeats: their changes are not multiplied."""
        repeated = [part.stop for s, part in zip(self.stretches, self._slices, strict=True) if not s.free]
        return repeated[-1] if repeated else 0

    def with_angles(self, angle: Array) -> list[Stretch]:
        """Return the stretches with other angles [rad]. Shape (n,)."""
        return [
            dataclasses.replace(s, sequence=s.sequence.with_angles(angle[part])) if s.free else s
            for s, part in zip(self.stretches, self._slices, strict=True)
        ]

    def at(self, angle: Array) -> Values:
        """Return the equations at some angles [rad]. Shape (n,)."""
        m = 6 + 6 * sum(s.free for s in self.stretches)
        residual, derivative = np.empty(m), np.zeros((m, len(angle)))
        after, row = np.eye(4), m
        stretches = self.with_angles(angle)
        starts = self._starts(stretches)
        for k in range(len(stretches) - 1, -1, -1):
            stretch, start, part = stretches[k], starts[k], self._slices[k]
            if not stretch.free:
                after = self._displacement(k, start) @ after
                continue
            row -= 6
            g, twists = flow_and_jacobian(self.swimmer, stretch.sequence, start, self.accuracy)
            residual[row : row + 6], derivative[row : row + 6, part] = shape_gap(stretch.sequence, start, stretch.end)
            derivative[:6, part] = se3.adjoint(se3.inverse(after)) @ twists
            after = g @ after
        residual[:6] = se3.log(se3.normalised(self.wanted_inverse @ after))
        return Values(residual, derivative)

    def _starts(self, stretches: Sequence[Stretch]) -> list[Array]:
        if self.accuracy is not EXACT:
            return [s.start for s in stretches]
        shapes = [stretches[0].start]
        for stretch in stretches[:-1]:
            shapes.append(stretch.sequence.shapes(shapes[-1])[-1])
        return shapes

    def _displacement(self, k: int, start: Array) -> Array:
        key = (k, start.tobytes())
        if key not in self._repeated:
            stretch = self.stretches[k]
            self._repeated[key] = se3.power(flow(self.swimmer, stretch.sequence, start), stretch.cycles)
        return self._repeated[key]
