"""Convex programs of many small blocks that few rows tie, by the kernel (`convex.c`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.kernel.arrays import Array, Whole, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

_RECORD = 24
"""Doubles that the kernel keeps a block's record in."""


@frozen_dataclass(eq=False)
class Blocks:
    """The variables of a program, in blocks, and what each block costs and keeps within.

    Attributes:
        sizes: Variables of each block, how many of them, its last, are in rows across blocks, and walls. Shape (k, 3).
        cost: The slope of the cost at zero. Shape (n,).
        curve: Each block's matrix of second derivatives of the cost, row by row, one after the other; or None.
            Shape (m,).
        start: Where the entries of each wall begin, of all blocks' inequalities wall y <= bound. Shape (w + 1,).
        column: Which of its block's variables each entry is of, ascending within a wall. Shape (e,).
        entry: The walls' entries that are not zero. Shape (e,).

    Raises:
        ValueError: Arrays that do not fit the sizes, or numbers that are not finite.
    """

    sizes: Whole
    cost: Array
    curve: Array | None
    start: Whole
    column: Whole
    entry: Array

    @classmethod
    def of(cls, walls: Sequence[Array], linked: Sequence[int], cost: ArrayLike, curve: Array | None = None) -> Blocks:
        """Return blocks from their walls as matrices.

        Args:
            walls: Of each block. Shapes (walls, size).
            linked: How many of each block's variables, its last, are in rows across blocks.
            cost: See above.
            curve: See above.
        """
        sizes = np.array([[wall.shape[1], many, len(wall)] for wall, many in zip(walls, linked, strict=True)])
        where = [np.nonzero(wall) for wall in walls]
        counts = [np.bincount(rows, minlength=len(wall)) for (rows, _), wall in zip(where, walls, strict=True)]
        start = np.concatenate([[0], *counts]).cumsum().astype(np.int64)
        column = np.concatenate([np.empty(0, dtype=np.int64), *(columns for _, columns in where)])
        entry = np.concatenate([np.empty(0), *(wall[at] for wall, at in zip(walls, where, strict=True))])
        return cls(sizes.reshape(-1, 3), doubles(cost, "cost"), curve, start, column, entry)

    def __post_init__(self) -> None:
        sizes = wholes(self.sizes, "sizes", (-1, 3))
        size, linked, walls = sizes.T
        if np.any(sizes < 0) or np.any(linked > size):
            raise ValueError("sizes: no negative ones, and no more variables in rows than there are, are wanted")
        start, column = wholes(self.start, "start", (int(walls.sum()) + 1,)), wholes(self.column, "column", (-1,))
        each = np.diff(start)
        if start[0] != 0 or start[-1] != len(column) or np.any(each < 0):
            raise ValueError("start: where walls' entries begin, in order, and where the last end, is wanted")
        most = np.repeat(np.repeat(size, walls), each)
        follows = np.ones(len(column), dtype=bool)
        follows[start[:-1][each > 0]] = False
        if np.any(column < 0) or np.any(column >= most) or np.any(np.diff(column, prepend=0)[follows] <= 0):
            raise ValueError("column: variables of a wall's own block, ascending, are wanted")
        parts: dict[str, Array | None] = {
            "cost": doubles(self.cost, "cost", (int(size.sum()),)),
            "curve": None if self.curve is None else doubles(self.curve, "curve", (int((size * size).sum()),)),
            "entry": doubles(self.entry, "entry", (len(column),)),
        }
        for name, part in parts.items():
            if part is not None and not np.all(np.isfinite(part)):
                raise ValueError(f"{name}: finite numbers are wanted")
            object.__setattr__(self, name, part)
        for name, whole in (("sizes", sizes), ("start", start), ("column", column)):
            object.__setattr__(self, name, whole)


def least(
    blocks: Blocks,
    bound: ArrayLike,
    across: ArrayLike,
    wanted: ArrayLike,
    equal: int,
    price: float,
    begun: ArrayLike,
    enough: float,
) -> Array | None:
    """Return the y of the least cost . y + y . curve y / 2 plus the price of what rows across blocks miss.

    Equations miss |across^T y - wanted|, inequalities by how much across^T y is above what is wanted.

    Args:
        blocks: The variables, their costs and walls.
        bound: Of all walls. Shape (w,).
        across: What the rows are of the variables that they are about, equations first. Shape (l, m).
        wanted: Shape (m,).
        equal: How many equations there are.
        price: What a unit missed costs, positive.
        begun: Where to begin, strictly within the walls. Shape (n,).
        enough: How much more than the least the cost may be, about.

    Returns:
        The y, shape (n,); None where none is found.

    Raises:
        ValueError: Numbers that are not finite, or arrays whose lengths do not fit.
    """
    right = doubles(wanted, "wanted", (-1,))
    size, linked, walls = blocks.sizes.T
    m, l = len(right), int(linked.sum())
    rows, most = doubles(across, "across", (l, m)), doubles(bound, "bound", (int(walls.sum()),))
    y = np.array(doubles(begun, "begun", blocks.cost.shape))
    if not all(np.all(np.isfinite(part)) for part in (rows, right, most, y, price, enough)):
        raise ValueError("program: finite numbers are wanted")
    if not price > 0.0 or not enough > 0.0 or not 0 <= equal <= m:
        raise ValueError("program: a positive price, a positive accuracy, and no more equations than rows are wanted")
    work = m * (m + 11) + int((_RECORD + size * (size + 2) + linked * m + 5 * walls).sum())
    room = np.empty(max(work, 1))
    curve = 0 if blocks.curve is None else address(blocks.curve)
    parts = (address(blocks.sizes), address(blocks.cost), curve, address(blocks.start), address(blocks.column))
    found = KERNEL.purcell_convex(
        len(blocks.sizes),
        m,
        equal,
        float(price),
        float(enough),
        *parts,
        *(address(part) for part in (blocks.entry, most, rows, right, y, room)),
    )
    return None if found < 0 or not np.all(np.isfinite(y)) else y
