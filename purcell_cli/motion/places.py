"""Where the base is at each beginning of a piece of a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.path_parts import Rows


@frozen_dataclass(eq=False)
class Places:
    """Where the base is at each beginning of a piece of a motion: every cycle of a repeated block has its own.

    Attributes:
        piece: Which piece begins there; the last one lasts no time. Shape (m,).
        poses: The base's poses [m]. Shape (m, 4, 4).
        begun_s: When [s]. Shape (m,).
    """

    piece: Rows
    poses: Array
    begun_s: Array

    @classmethod
    def of(cls, swimmer: Swimmer, start: Array, blocks: Sequence[Block], pieces: Pieces, begun: Array) -> Places:
        """Return the places of a motion.

        Args:
            swimmer: The swimmer.
            start: The base's pose before the motion [m]. Shape (4, 4).
            blocks: The motion.
            pieces: Its pieces, each cycle once, and last one of no duration. There are n.
            begun: When each begins for the last time [s]. Shape (n,).
        """
        moves = piece_displacements(swimmer, pieces)
        index, poses, times = [], [], []
        here, first, total = start, 0, 0.0
        for block in blocks:
            n = len(block.sequence)
            mine = np.arange(first, first + n)
            along = se3.prefix_products(moves[mine])
            counts = np.arange(block.cycles)
            origins = here[None] if block.cycles == 1 else se3.normalised(matmul(here, se3.power(along[-1], counts)))
            poses.append((matmul(origins[:, None], along[:-1])).reshape(-1, 4, 4))
            index.append(np.tile(mine, block.cycles))
            once = float(np.sum(pieces.durations[mine]))
            times.append((counts[:, None] * once + begun[mine]).ravel())
            here = se3.normalised(matmul(here, se3.power(along[-1], block.cycles)))
            first, total = first + n, total + block.cycles * once
        which = np.concatenate([*index, [first]]).astype(np.int64)
        return cls(which, np.concatenate([*poses, here[None]]), np.concatenate([*times, [total]]))
