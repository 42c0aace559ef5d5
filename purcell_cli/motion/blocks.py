"""Strokes in a row: what a plan is made of."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.lift import EXACT, piece_work, run_displacements
from purcell_cli.mechanics.moves import ControlSequence, chained
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer


@frozen_dataclass(eq=False)
class Block:
    """A stroke played a number of times; one that repeats brings the limbs back to where they were.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        gait: Name of the stroke.
        sequence: Primitives or moves of one cycle.
        cycles: How often they are played.
        amplitude_rad: Amplitude of the stroke, where it has one [rad].
    """

    phase: int
    gait: str
    sequence: ControlSequence
    cycles: int = 1
    amplitude_rad: float = math.nan

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its pieces and joints of |angle| [rad]."""
        return self.cycles * self.sequence.joint_travel_rad

    @property
    def duration(self) -> float:
        """How long it lasts at a joint rate of 1 rad/s [s]."""
        return self.cycles * float(np.sum(self.sequence.duration))


@frozen_dataclass(eq=False)
class BlockPieces:
    """The pieces of all blocks, one cycle each, to be computed in one batch.

    A block that repeats brings the limbs back, so the shapes of one cycle of each are a chain.

    Attributes:
        sequence: The controls.
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        counts: How many pieces each block has. Shape (k,).
        cycles: How often each block is played. Shape (k,).
    """

    sequence: ControlSequence
    shapes: Array
    counts: NDArray[np.int64]
    cycles: NDArray[np.int64]

    @classmethod
    def of(cls, blocks: Sequence[Block], start: ArrayLike) -> BlockPieces:
        """Return the pieces of blocks from a shape. Shape (2, 3, 3)."""
        sequence = chained([b.sequence for b in blocks])
        counts, cycles = ([len(b.sequence) for b in blocks], [b.cycles for b in blocks])
        shapes = sequence.shapes(np.asarray(start, dtype=np.float64))
        return cls(sequence, shapes, np.array(counts, dtype=np.int64), np.array(cycles, dtype=np.int64))

    @property
    def once(self) -> Pieces:
        """The pieces, at a joint rate of 1 rad/s."""
        return Pieces.between(self.sequence, self.shapes)

    @property
    def block(self) -> NDArray[np.int64]:
        """The block that each piece is of. Shape (n,)."""
        return np.repeat(np.arange(len(self.counts)), self.counts)


def starting_shapes(blocks: Sequence[Block], start: ArrayLike) -> Array:
    """Return the shape before each block, and after the last. Shape (k + 1, 2, 3, 3)."""
    pieces = BlockPieces.of(blocks, start)
    return np.asarray(pieces.shapes[np.cumsum([0, *pieces.counts])])


def block_displacements(
    swimmer: Swimmer, blocks: Sequence[Block], start: ArrayLike, accuracy: Accuracy = EXACT
) -> Array:
    """Return the body displacement made by each block [m]. Shape (n, 4, 4).

    Args:
        swimmer: The swimmer.
        blocks: The motion.
        start: Shape before it. Shape (2, 3, 3).
        accuracy: Of the flow.
    """
    pieces = BlockPieces.of(blocks, start)
    return run_displacements(swimmer, pieces.once, pieces.counts, pieces.cycles, accuracy)


def energies(swimmer: Swimmer, blocks: Sequence[Block], start: ArrayLike) -> Array:
    """Return the energy dissipated in each block at the swimmer's joint rate [J]. Shape (n,)."""
    pieces = BlockPieces.of(blocks, start)
    once = piece_work(swimmer, pieces.once)
    return np.asarray(pieces.cycles * np.bincount(pieces.block, weights=once, minlength=len(blocks)))


PHASES = {1: "limbs to collinear", 2: "base displacement", 3: "limbs to the goal shape"}
