"""The pieces of a path in equal parts.

What is bounded over a whole motion is looked at in parts that are halved wherever they are too long to tell.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

Rows = NDArray[np.int64]


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
        key, which = np.unique(piece << depth | part, return_inverse=True)
        one, length = key >> depth, self.pieces.durations[key >> depth] / 2**depth
        begun = (key - (one << depth)) * length
        twist = np.zeros((len(key), 2, 6))
        twist[..., 3:] = self.pieces.rates[one].reshape(-1, 2, 3) * begun[:, None, None]
        shapes = matmul(self.pieces.shapes[one], se3.exp(twist)[..., :3, :3])
        moves = self.displacements(self.swimmer, Pieces(shapes, self.pieces.rates[one], share * length))
        return moves[which], self.circles.at(one, begun + share * length)[which]
