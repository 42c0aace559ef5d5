"""Rectangles of two joint angles on grids, and the screw motion that each makes.

The sides of all rectangles of a pair of controls lie on one grid of their angles. So the displacement is computed once
along each edge of the grid, and a rectangle's is a product of those. Lengths are in units of L.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.lift import SEARCHING, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import AXIS_OF, BASE_YAWS, LIMB_OF, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.joints.loop import Aside, Loop, rectangle

_LINES = np.array([-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0])
"""The lines of a grid, as parts of how far its angle may go to either side."""
_HOME = 4
"""The line that the angle is on at home."""
_PARTS = ((0, 8), (1, 7), (2, 6), (3, 5), (0, 6), (2, 8), (0, 4), (4, 8))
"""The sides of rectangles, by the lines that they reach from and to."""
_SIDES = np.array([(*first, *second) for first, second in itertools.product(_PARTS, _PARTS)])
"""The rectangles of a grid: lines of the first angle and of the second, from and to."""
_LEAST_SIDE_RAD = 1e-3
"""Rectangles of shorter sides are left out [rad]."""


@frozen_dataclass(eq=False)
class Grid:
    """A grid of two joint angles.

    Attributes:
        pair: The two controls. They turn different limbs, or one limb's angles of which each closes by itself.
        spans: How far each may go, down and up [rad]. Shape (2, 2).
        offset: Another control that is turned first, and by how much.
    """

    pair: tuple[int, int]
    spans: Array
    offset: Aside

    @property
    def lines(self) -> Array:
        """The angles of the lines of both controls [rad]. Shape (2, 9)."""
        out: Array = np.abs(self.spans)[:, [0] * _HOME + [1] * (len(_LINES) - _HOME)] * _LINES
        return out


@frozen_dataclass(eq=False)
class Rectangles:
    """Rectangles with what they do.

    Attributes:
        grids: The grids that they are on.
        grid: The grid of each. Shape (n,).
        sides: The angles of the first control and of the second, from and to [rad]. Shape (n, 2, 2).
        twist: The body twist of one cycle of each (v/L, omega), seen from home. Shape (n, 6).
        travel: The joint travel of one cycle [rad]. Shape (n,).
        approach: That of both approaches [rad]. Shape (n,).
    """

    grids: tuple[Grid, ...]
    grid: NDArray[np.int64]
    sides: Array
    twist: Array
    travel: Array
    approach: Array

    def __len__(self) -> int:
        return len(self.grid)

    def loop(self, k: int) -> Loop:
        """Return a rectangle as a loop."""
        grid, ((a, b), (c, d)) = self.grids[int(self.grid[k])], self.sides[k].tolist()
        return rectangle(grid.pair, (a, b), (c, d), grid.offset)


def rectangles_on(swimmer: Swimmer, home: Array, grids: Sequence[Grid]) -> Rectangles:
    """Return the rectangles on grids, with what they do.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        home: Shape that they begin and end at. Shape (2, 3, 3).
        grids: The grids.
    """
    n, count = len(_LINES), len(grids)
    before, first, second = _edges(swimmer, home, grids)
    along = _along(first), _along(np.swapaxes(second, 1, 2))  # by [grid, line of the other angle, line]
    i, k, j, m = _SIDES.T

    def sides(
        which: int, other: NDArray[np.int64] | int, begin: NDArray[np.int64] | int, end: NDArray[np.int64]
    ) -> Array:
        moves = along[which]
        return matmul(se3.inverse(moves[:, other, begin]), moves[:, other, end])

    approach = matmul(
        matmul(before[:, None], sides(0, np.full_like(i, _HOME), np.full_like(i, _HOME), i)),
        sides(1, i, np.full_like(i, _HOME), j),
    )
    cycle = matmul(matmul(sides(0, j, i, k), sides(1, k, j, m)), matmul(sides(0, m, k, i), sides(1, i, m, j)))
    twist = se3.log(se3.normalised(matmul(matmul(approach, cycle), se3.inverse(approach)))).reshape(-1, 6)
    lines = np.array([grid.lines for grid in grids]).reshape(count, 2, n)
    ends = np.stack([lines[:, 0][:, _SIDES[:, :2]], lines[:, 1][:, _SIDES[:, 2:]]], axis=2).reshape(-1, 2, 2)
    offset = np.array([0.0 if grid.offset is None else abs(grid.offset[1]) for grid in grids])
    size = ends[..., 1] - ends[..., 0]
    own = np.repeat(np.arange(count), len(_SIDES))
    approach_rad = 2.0 * (offset[own] + np.sum(np.abs(ends[..., 0]), axis=1))
    good = np.flatnonzero(np.all(size > _LEAST_SIDE_RAD, axis=1))
    travel = 2.0 * np.sum(size, axis=1)
    return Rectangles(tuple(grids), own[good], ends[good], twist[good], travel[good], approach_rad[good])


def _edges(swimmer: Swimmer, home: Array, grids: Sequence[Grid]) -> tuple[Array, Array, Array]:
    """Return the displacements of the offsets, (g, 4, 4), and of the edges of grids.

    The edges are those along the first angle, (g, 8, 9, 4, 4), and along the second, (g, 9, 8, 4, 4), by their lines.
    """
    n = len(_LINES)
    shapes, controls, angles = [np.empty((0, 2, 3, 3))], [np.empty(0, dtype=np.int64)], [np.empty(0)]

    def add(begin: Array, control: int, angle: Array) -> None:
        shapes.append(begin.reshape(-1, 2, 3, 3))
        controls.append(np.full(angle.size, control))
        angles.append(angle.reshape(-1))

    for grid in grids:
        control, angle = grid.offset or (grid.pair[0], 0.0)
        begin = shapes_along(home, [control], [angle])[1]
        add(home[None], control, np.array([angle]))
        at, steps = _grid_shapes(begin, grid), np.diff(grid.lines, axis=1)
        add(at[:-1], grid.pair[0], np.repeat(steps[0], n))
        add(at[:, :-1], grid.pair[1], np.tile(steps[1], n))
    played = PrimitiveSequence(np.concatenate(controls), np.concatenate(angles))
    begun = np.concatenate(shapes)
    moves = piece_displacements(swimmer, Pieces(begun, played.rates(begun), played.duration), SEARCHING)
    split = 1 + (n - 1) * n
    every = moves.reshape(len(grids), split + n * (n - 1), 4, 4)
    return (
        every[:, 0],
        every[:, 1:split].reshape(len(grids), n - 1, n, 4, 4),
        every[:, split:].reshape(len(grids), n, n - 1, 4, 4),
    )


def _grid_shapes(begin: Array, grid: Grid) -> Array:
    """Return the shapes at the crossings of a grid whose angles start from a shape. Shape (9, 9, 2, 3, 3)."""
    n = len(_LINES)
    out = np.broadcast_to(begin, (n, n, 2, 3, 3)).copy()
    for k, control in enumerate(grid.pair):
        turn, limb = about_axis(int(AXIS_OF[control]), grid.lines[k]), int(LIMB_OF[control])
        turn = np.broadcast_to(turn[:, None] if k == 0 else turn[None], (n, n, 3, 3))
        now = out[:, :, limb]
        out[:, :, limb] = matmul(turn, now) if control in BASE_YAWS else matmul(now, turn)
    return out


def _along(edges: Array) -> Array:
    """Return the displacements along lines up to each crossing.

    Args:
        edges: By grid, edge and line. Shape (g, 8, 9, 4, 4).

    Returns:
        By grid, line and crossing. Shape (g, 9, 9, 4, 4).
    """
    out = [np.broadcast_to(np.eye(4), edges[:, 0].shape)]
    for k in range(edges.shape[1]):
        out.append(matmul(out[-1], edges[:, k]))
    return se3.normalised(np.stack(out, axis=2))
