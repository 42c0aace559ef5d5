"""Every piece of a motion at its place: the cycles of a repeated block one by one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class EveryPiece:
    """Where and when each piece of a motion begins; the last is its end.

    Attributes:
        which: Which of the distinct pieces it is. Shape (m,).
        pose: The base's pose where it begins [m]. Shape (m, 4, 4).
        begun_s: When it begins [s]. Shape (m,).
    """

    which: NDArray[np.int64]
    pose: Array
    begun_s: Array

    @classmethod
    def of(cls, swimmer: Swimmer, start: Array, blocks: Sequence[Block], pieces: Pieces) -> EveryPiece:
        """Return the pieces of blocks, one after the other.

        Args:
            swimmer: The swimmer.
            start: The base's pose before them [m]. Shape (4, 4).
            blocks: The blocks.
            pieces: Their pieces, each cycle once, and a last one that begins at the end.
        """
        moves = piece_displacements(swimmer, pieces)
        index, poses, begun = [], [], []
        here, first, total = start, 0, 0.0
        for block in blocks:
            n = len(block.sequence)
            mine = np.arange(first, first + n)
            along = se3.prefix_products(moves[mine])
            counts = np.arange(block.cycles)
            origins = here[None] if block.cycles == 1 else se3.normalised(matmul(here, se3.power(along[-1], counts)))
            poses.append((matmul(origins[:, None], along[:-1])).reshape(-1, 4, 4))
            index.append(np.tile(mine, block.cycles))
            lasts = np.cumsum(pieces.durations[mine])
            once = float(lasts[-1]) if n else 0.0
            begun.append((total + counts[:, None] * once + np.append(0.0, lasts[:-1])[:n]).ravel())
            here = se3.normalised(matmul(here, se3.power(along[-1], block.cycles)))
            first, total = first + n, total + block.cycles * once
        return cls(
            np.concatenate([*index, [first]]).astype(np.int64),
            np.concatenate([*poses, here[None]]),
            np.concatenate([*begun, [total]]),
        )
