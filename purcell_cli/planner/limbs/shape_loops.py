"""Shape loops: closed paths of both limbs from the start's or the goal's shape, which move the base.

In phases 1 and 3 a limb may bend as far as it does at the start or the goal. Where it bends far, a
square of both limbs' angles turns the base by up to 5 degrees per rad of joint travel; the best loops
at a bend limit of 1 rad turn it by 0.9. So a few squares before the limbs are straightened, or after
they are bent, may save phase 2 more joint travel than they cost.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import ROUGH, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import TOLERANCE_L, clearances
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles, bends
from purcell_cli.planner.limbs.straightening import MOST_LOOPS, Straightenings

_SIDES_RAD = (-1.6, -0.8, 0.8, 1.6)
"""Angles of the squares' sides, for either limb [rad]."""
_LEAST_BEND_RAD = 1.3
"""Where neither limb bends further than this, no squares are tried: they turn the base too little [rad]."""


@frozen_dataclass(eq=False)
class ShapeLoops:
    """Closed paths of both limbs from a shape, which move the base.

    Attributes:
        sequence: Their primitives.
        joint_travel_rad: Their joint travel [rad]. Shape (n,).
        displacement: What each does to the base, to search by, in units of L. Shape (n, 4, 4).
    """

    sequence: tuple[PrimitiveSequence, ...]
    joint_travel_rad: Array
    displacement: Array

    def before(self, ways: Straightenings) -> Straightenings:
        """Return straightenings with each of the shape loops, or none, before what they do."""
        n, m = len(self.sequence), len(ways)
        index = np.repeat(np.arange(1, n + 1), m)[:, None]
        more = Straightenings(
            ways.limbs,
            np.tile(ways.order, (n, 1)),
            np.tile(ways.way, (n, 1)),
            np.concatenate([index, np.tile(ways.loop[:, :-1], (n, 1))], axis=1),
            (self.joint_travel_rad[:, None] + ways.joint_travel_rad).ravel(),
            (matmul(self.displacement[:, None], ways.displacement)).reshape(-1, 4, 4),
            ways.alone,
            (EMPTY, *self.sequence),
        )
        return ways.and_(more)

    def before_each(self, ways: Straightenings, way: NDArray[np.int64], loop: NDArray[np.int64]) -> Straightenings:
        """Return numbered straightenings with numbered shape loops before them.

        Args:
            ways: The straightenings that there are, without loops.
            way: Which straightening. Shape (n,).
            loop: Which shape loops, one after the other; 0 is none. Shape (n, 3).
        """
        moves, moved = np.concatenate([np.eye(4)[None], self.displacement]), ways.displacement[way]
        for k in range(MOST_LOOPS)[::-1]:
            moved = matmul(moves[loop[:, k]], moved)
        travel = np.append(0.0, self.joint_travel_rad)[loop].sum(axis=1) + ways.joint_travel_rad[way]
        every = EMPTY, *self.sequence
        return Straightenings(ways.limbs, ways.order[way], ways.way[way], loop, travel, moved, ways.alone, every)


def shape_loops(swimmer: Swimmer, shapes: Sequence[Array], clearance_m: float = 0.0) -> list[ShapeLoops]:
    """Return shape loops round each of some shapes: squares of both limbs' angles, gone round once or twice.

    A bent limb may bend as far as it does, and the more limbs are bent, the more a square turns the base.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shapes: The shapes. Each of shape (2, 3, 3).
        clearance_m: How far the limbs' surfaces stay apart, in units of L.
    """
    squares = [_squares(swimmer, shape) for shape in shapes]
    if not any(map(len, squares)):
        return [ShapeLoops((), np.empty(0), np.empty((0, 4, 4)))] * len(shapes)
    # Squares close, so they are played one after the other.
    pieces = Pieces.together(Pieces.of(some, shape) for shape, some in zip(shapes, squares, strict=True))
    moves = piece_displacements(swimmer, pieces, ROUGH).reshape(-1, 4, 4, 4)
    apart = clearances(swimmer, pieces, clearance_m)[0].reshape(-1, 4).min(axis=1)
    once = se3.normalised(matmul(matmul(matmul(moves[:, 0], moves[:, 1]), moves[:, 2]), moves[:, 3]))
    out, low = [], 0
    for some in squares:
        control, angle = some.control.reshape(-1, 4), some.angle.reshape(-1, 4)
        near, made = apart[low : low + len(control)], once[low : low + len(control)]
        low += len(control)
        kept = np.flatnonzero(near >= clearance_m - TOLERANCE_L)
        moved = np.concatenate([made[kept], se3.inverse(made[kept])])
        control = np.concatenate([control[kept], control[kept, ::-1]])
        angle = np.concatenate([angle[kept], -angle[kept, ::-1]])
        rows = [(control, angle), (np.tile(control, 2), np.tile(angle, 2))]
        travel = np.concatenate([np.abs(by).sum(axis=1) for _, by in rows])
        sequences = tuple(sequence for row in rows for sequence in _each(*row))
        out.append(ShapeLoops(sequences, travel, np.concatenate([moved, matmul(moved, moved)])))
    return out


def _each(control: NDArray[np.int64], angle: Array) -> list[PrimitiveSequence]:
    """Return a sequence for each row of controls and angles. Shapes (n, k)."""
    whole, k = PrimitiveSequence(control.ravel(), angle.ravel()), control.shape[1]
    return [whole[low : low + k] for low in range(0, len(whole), k)]


def _squares(swimmer: Swimmer, shape: Array) -> PrimitiveSequence:
    """Return squares from a shape and back to it, one after the other, four primitives each.

    On none does a limb bend further than it does, or than the limit.
    """
    limits = np.maximum(swimmer.max_bend_rad, bends(shape[..., 0])) + BEND_SLACK_RAD
    if np.max(limits) < _LEAST_BEND_RAD:
        return EMPTY
    control = np.repeat([[1, 2], [4, 5]], len(_SIDES_RAD), axis=1)
    angle = np.tile(_SIDES_RAD, (2, 2))
    to_and_fro = PrimitiveSequence(np.repeat(control.ravel(), 2), np.stack([angle, -angle], axis=-1).ravel())
    bent = LimbCircles.of(Pieces.of(to_and_fro, shape)).largest_bends()[0][::2].reshape(2, -1, 2)
    first, second = (np.flatnonzero(bent[limb, :, limb] <= limits[limb]) for limb in (0, 1))
    i, j = np.repeat(first, len(second)), np.tile(second, len(first))
    a, b = angle[0, i], angle[1, j]
    controls = np.stack([control[0, i], control[1, j]] * 2, axis=1)
    return PrimitiveSequence(controls.ravel(), np.stack([a, b, -a, -b], axis=1).ravel())
