"""A plan's way: where it is, stroke by stroke, seen from where it ends.

The way is looked at where controls change and in between. It is seen from its end, so that it can be laid to any goal.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
from typing import cast

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.flow import played, with_twice_the_digits
from purcell_cli.mechanics.configuration import Configuration, displacement_between
from purcell_cli.mechanics.lift import SEARCHING, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.refine.minimum_travel import NAME, merged

PARTS = 4
"""Into how many parts each primitive of the way is cut."""
_AFTER_SLACK_RAD = 1e-9
"""A place this little before the travel that is made is not before it [rad]."""


@frozen_dataclass(slots=False, eq=False)
class PlanPath:
    """A plan's way: where it is, stroke by stroke, seen from where it ends.

    Attributes:
        plan: The plan, of primitives.
        block: The block that each place is in. Shape (n,).
        cycle: The cycle of the block. Shape (n,).
        part: The part of a primitive of the cycle that begins there. Shape (n,).
        control: The control that acts in that part. Shape (n,).
        angle: By how much it turns [rad]. Shape (n,).
        shape: The limbs' orientations. Shape (n, 2, 3, 3).
        left: The displacement from there to the plan's end [L]. Shape (n, 4, 4).
        travel_rad: The joint travel from there to the end [rad]. Shape (n,).
    """

    plan: Plan
    block: NDArray[np.int64]
    cycle: NDArray[np.int64]
    part: NDArray[np.int64]
    control: NDArray[np.int64]
    angle: Array
    shape: Array
    left: Array
    travel_rad: Array

    @classmethod
    def of(cls, plan: Plan) -> PlanPath:
        """Return the way of a plan of primitives."""
        unit, shape = plan.swimmer.scaled(), plan.start.shape
        here = with_twice_the_digits(np.eye(4))
        rows: list[tuple[Array, Array, Array]] = []
        places: list[NDArray[np.int64]] = []
        for k, block in enumerate(plan.blocks):
            cut = _cut(cast(PrimitiveSequence, block.sequence))
            shapes, n = cut.shapes(shape), len(cut)
            moves = piece_displacements(unit, Pieces.between(cut, shapes), SEARCHING)
            poses = played(here, moves, block.cycles).reshape(-1, 4, 4)
            cycle, part = np.divmod(np.arange(block.cycles * n), n)
            shape = shapes[-1]
            places.append(np.stack([np.full(len(cycle), k), cycle, part, cut.control[part]]))
            rows.append((cut.angle[part], shapes[part], poses))
        end = played(here, np.eye(4)[None], 1)[0]
        places.append(np.array([[len(plan.blocks)], [0], [0], [0]]))
        rows.append((np.zeros(1), shape[None], end))
        angle, limbs, pose = (np.concatenate(column) for column in zip(*rows, strict=True))
        travel = np.cumsum(np.abs(angle)[::-1])[::-1]
        block_, cycle, part, control = np.concatenate(places, axis=1)
        left = matmul(se3.inverse(pose), end[0])
        return cls(plan, block_, cycle, part, control, angle, limbs, left, travel)

    def nearest(self, measured: Configuration, goal: Configuration, after_rad: float = 0.0) -> tuple[int, float]:
        """Return the place nearest to a configuration, and how far off that is [L, rad].

        Args:
            measured: The configuration.
            goal: Where the way is to end.
            after_rad: Joint travel that is made by then; places before are left out [rad].
        """
        wanted = displacement_between(measured, goal, self.plan.swimmer.length_m)
        gap = matmul(wanted, se3.inverse(self.left))
        limbs = np.sum((self.shape - measured.shape) ** 2, axis=(1, 2, 3))
        turned = np.sum((gap[:, :3, :3] - np.eye(3)) ** 2, axis=(1, 2))
        off = np.sqrt(np.sum(gap[:, :3, 3] ** 2, axis=1) + 0.5 * (turned + limbs))
        off[self.travel_rad > self.travel_rad[0] - after_rad + _AFTER_SLACK_RAD] = np.inf
        place = int(np.argmin(off))
        return place, float(off[place])

    def blocks_from(self, place: int) -> tuple[Block, ...]:
        """Return the strokes that are left at a place."""
        k, cycle, part = (int(column[place]) for column in (self.block, self.cycle, self.part))
        blocks = self.plan.blocks
        if k == len(blocks):
            return ()
        out = [dataclasses.replace(blocks[k], cycles=blocks[k].cycles - cycle)]
        if part:
            sequence = cast(PrimitiveSequence, blocks[k].sequence)
            primitive, done = divmod(part, PARTS)
            rest = sequence[primitive:]
            first = np.concatenate([[1.0 - done / PARTS], np.ones(len(rest) - 1)])
            out = [dataclasses.replace(blocks[k], sequence=rest.with_angles(first * rest.angle), cycles=1)]
            if blocks[k].cycles - cycle > 1:
                out.append(dataclasses.replace(blocks[k], cycles=blocks[k].cycles - cycle - 1))
        return (*out, *blocks[k + 1 :])

    def back_and_forth(self, place: int, travel_rad: float) -> tuple[Block, ...]:
        """Return strokes that lead from a place back along the way and to it again, which moves nothing in all.

        Args:
            place: The place.
            travel_rad: The joint travel each way, at least, where the way is that long [rad].
        """
        blocks = self.plan.blocks
        phases = np.array([b.phase for b in blocks] + [3])[self.block]
        first = max(int(np.searchsorted(-self.travel_rad, -self.travel_rad[place] - travel_rad, "right")) - 1, 0)
        first = max(first, int(np.argmax(phases[: place + 1] > 1)))
        there, back = [], []
        for phase in (2, 3):
            some = first + np.flatnonzero(phases[first:place] == phase)
            if len(some):
                sequence = merged(PrimitiveSequence(self.control[some], self.angle[some]))
                there.append(Block(phase, NAME, sequence))
                back.append(Block(1 if phase == 3 else 2, NAME, sequence.inverse()))
        return (*back[::-1], *there)


def _cut(sequence: PrimitiveSequence) -> PrimitiveSequence:
    """Return a sequence with each primitive cut in parts."""
    return PrimitiveSequence(np.repeat(sequence.control, PARTS), np.repeat(sequence.angle, PARTS) / PARTS)
