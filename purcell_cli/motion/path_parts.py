"""The pieces of a path in equal parts.

What is bounded over a whole motion is looked at in parts that are halved wherever they are too long to tell.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

Rows = NDArray[np.int64]
Look = Callable[[Rows, Array, Array, Array], Array]
More = Callable[[Rows, Array, Array, Array], NDArray[np.bool_]]


class PathParts:
    """The pieces of a path, cut into 1, 2, 4, ... equal parts.

    Args:
        swimmer: The swimmer.
        pieces: The pieces.
        displacements: Returns the base's displacements on pieces [m]. Shape (n, 4, 4).
    """

    def __init__(self, swimmer: Swimmer, pieces: Pieces, displacements: Callable[[Swimmer, Pieces], Array]) -> None:
        self.swimmer, self.pieces, self.circles = swimmer, pieces, LimbCircles.of(pieces)
        self.displacements = displacements

    def ahead(self, piece: Rows, part: Rows, depth: int, share: float) -> tuple[Array, Array]:
        """Return the displacement from the beginning of parts, and the limbs' axes there.

        Args:
            piece: The pieces. Shape (m,).
            part: Which of their parts. Shape (m,).
            depth: Each piece has 2^depth parts.
            share: How far ahead, as a share of the part.
        """
        every = piece << depth | part
        first, which = distinct(every)
        key = every[first]
        one, length = key >> depth, self.pieces.durations[key >> depth] / 2**depth
        begun = (key - (one << depth)) * length
        twist = np.zeros((len(key), 2, 6))
        twist[..., 3:] = self.pieces.rates[one].reshape(-1, 2, 3) * begun[:, None, None]
        shapes = matmul(self.pieces.shapes[one], se3.exp(twist)[..., :3, :3])
        moves = self.displacements(self.swimmer, Pieces(shapes, self.pieces.rates[one], share * length))
        return moves[which], self.circles.at(one, begun + share * length)[which]

    def halve(self, row: Rows, poses: Array, piece: Rows, look: Look, more: More) -> None:
        """Look at places of the path and their pieces' ends, then at the middles of parts for as long as is wanted.

        Args:
            row: The places. Shape (r,).
            poses: The base's poses there [m]. Shape (r, 4, 4).
            piece: Which piece begins at each place of the path. Shape (m,).
            look: Measures some instants: places, times since them [s], the base's poses and the limbs' axes.
            more: Says which parts are cut further: their pieces, what was measured at both ends, and how long they are.
        """
        part, depth, durations = np.zeros(len(row), dtype=np.int64), 0, self.pieces.durations
        moves, axes = self.ahead(piece[row], part, depth, 1.0)
        first = look(row, np.zeros(len(row)), poses, self.pieces.shapes[piece[row], :, :, 0])
        last = look(row, durations[piece[row]], matmul(poses, moves), axes)
        while len(row):
            length = durations[piece[row]] / 2**depth
            cut = more(piece[row], first, last, length)
            row, part = row[cut], part[cut]
            poses, first, last, length = (x[cut] for x in (poses, first, last, length))
            moves, axes = self.ahead(piece[row], part, depth, 0.5)
            middle = matmul(poses, moves)
            between = look(row, (part + 0.5) * length, middle, axes)
            row, part, depth = np.tile(row, 2), np.concatenate([2 * part, 2 * part + 1]), depth + 1
            poses = np.concatenate([poses, middle])
            first, last = np.concatenate([first, between]), np.concatenate([between, last])
