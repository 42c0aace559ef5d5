"""Phases 1 and 3: limbs to the collinear shape and from it, by primitives (section IV-B of the paper).

Three rotations about its own axes straighten a limb, in twelve orders and two ways each. Either limb
may go first, or the rotations of one stand between those of the other. Each way moves the base
differently, so the best depends on the goal: this module lists the ways and their displacements of the
base. Shape loops may come before (see `shape_loops`). Ways on which the limbs come too near each other
are left out.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import ROUGH, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import TOLERANCE_L, clearances
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles, bends
from purcell_cli.planner.limbs.limb_rotations import Ways, rotations_to

MOST_LOOPS = 3
"""The most shape loops before one straightening."""
_LONGER_RAD = 7.0
"""Straightenings with more joint travel than the shortest by more than this are left out [rad]."""


@frozen_dataclass(eq=False)
class Straightenings:
    """Ways to straighten both limbs.

    Attributes:
        limbs: The ways to straighten limb 1, and limb 2.
        order: Which limb rotates, 0 or 1, in the six rotations of both. Shape (n, 6).
        way: The way each limb takes. Shape (n, 2).
        loop: Which of the shape loops are made before, one after the other; 0 is none. Shape (n, 3).
        joint_travel_rad: Their joint travel [rad]. Shape (n,).
        displacement: What each does to the base, to search by, in units of L. Shape (n, 4, 4).
        alone: What each way of either limb does while the other one is as it was, and while it is straight.
        loops: The shape loops, the first of them empty.
    """

    limbs: tuple[Ways, Ways]
    order: NDArray[np.int64]
    way: NDArray[np.int64]
    loop: NDArray[np.int64]
    joint_travel_rad: Array
    displacement: Array
    alone: tuple[Played, Played]
    loops: tuple[PrimitiveSequence, ...] = (EMPTY,)

    def __len__(self) -> int:
        return len(self.order)

    def sequence(self, k: int) -> PrimitiveSequence:
        """Return the primitives of one of the ways."""
        rotations = [self.limbs[i].primitives(int(self.way[k, i])) for i in (0, 1)]
        taken = np.cumsum(self.order[k]) - self.order[k]  # rotations of limb 2 before each
        row = np.arange(6)
        straight = joined(rotations)[np.where(self.order[k] == 0, row - taken, 3 + taken)].busy()
        return joined([*(self.loops[i] for i in self.loop[k]), straight])

    def __getitem__(self, some: NDArray[np.int64]) -> Straightenings:
        """Return some of them, in an order of their own."""
        return dataclasses.replace(self, **{name: getattr(self, name)[some] for name in _COLUMNS})

    def and_(self, more: Straightenings) -> Straightenings:
        """Return these and more of the same limbs' ways, with the same shape loops if they have any."""
        both: dict[str, Any] = {name: np.concatenate([getattr(self, name), getattr(more, name)]) for name in _COLUMNS}
        return dataclasses.replace(more, **both)


_COLUMNS = ("order", "way", "loop", "joint_travel_rad", "displacement")


def straightenings(swimmer: Swimmer, shapes: Sequence[Array], clearance_m: float = 0.0) -> list[Straightenings]:
    """Return, for each of some shapes, the ways to straighten both limbs of a scaled swimmer, one after the other.

    No limb bends further on the way than it does at the beginning or the bend limit allows, and the
    limbs stay apart. Where no way keeps them apart, the ways on which they come least near are returned.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shapes: The shapes to begin with. Each of shape (2, 3, 3).
        clearance_m: How far the limbs' surfaces stay apart, in units of L.
    """
    if all(np.array_equal(shape, COLLINEAR) for shape in shapes):
        return [_none(swimmer)] * len(shapes)
    return _straightenings(swimmer, shapes, clearance_m)


@functools.lru_cache(maxsize=64)
def _none(swimmer: Swimmer) -> Straightenings:
    """Return the one way to straighten limbs that are straight, which does nothing; made once."""
    return _straightenings(swimmer, [COLLINEAR], 0.0)[0]


def _straightenings(swimmer: Swimmer, shapes: Sequence[Array], clearance_m: float) -> list[Straightenings]:
    limbs = [_within(swimmer, shape, [rotations_to(shape[i].T, i + 1) for i in (0, 1)]) for shape in shapes]
    played = _played(swimmer, shapes, limbs, clearance_m)
    return [_pairs(*one, clearance_m) for one in zip(limbs, played, strict=True)]


def _pairs(limbs: tuple[Ways, Ways], played: tuple[Played, Played], clearance_m: float) -> Straightenings:
    """Return the ways of two limbs in pairs, either limb first.

    Args:
        limbs: The ways of either limb.
        played: What they do while the other limb is as it was, and while it is straight.
        clearance_m: How far the limbs' surfaces stay apart, in units of L.
    """
    travels = [limb.joint_travel_rad for limb in limbs]
    orders = (0, 1) if np.any(travels[0]) and np.any(travels[1]) else (0,)
    near = [[part.min(axis=1) for part in one.apart] for one in played]
    whole = [[se3.normalised(matmul(matmul(m[:, 0], m[:, 1]), m[:, 2])) for m in one.moves] for one in played]
    apart = [np.minimum(near[0][i][:, None], near[1][1 - i]) for i in orders]
    least = min(clearance_m, max(float(a.max()) for a in apart)) - TOLERANCE_L
    shortest = min(float((travels[i][:, None] + travels[1 - i])[apart[i] >= least].min(initial=np.inf)) for i in orders)
    order, way, travel, displacement = [], [], [], []
    for i in orders:
        pairs = travels[i][:, None] + travels[1 - i]
        kept = np.argwhere((pairs <= shortest + _LONGER_RAD) & (apart[i] >= least))
        order.append(np.tile(np.repeat([i, 1 - i], 3), (len(kept), 1)))
        way.append(kept if i == 0 else kept[:, ::-1])
        travel.append(pairs[kept[:, 0], kept[:, 1]])
        displacement.append(matmul(whole[0][i][kept[:, 0]], whole[1][1 - i][kept[:, 1]]))
    found = Straightenings(
        limbs,
        np.concatenate(order),
        np.concatenate(way),
        np.zeros((sum(map(len, way)), MOST_LOOPS), dtype=np.int64),
        np.concatenate(travel),
        np.concatenate(displacement),
        played,
    )
    return found[np.argsort(np.round(found.joint_travel_rad, 9), kind="stable")]


@frozen_dataclass(eq=False)
class Played:
    """Displacements and clearances of the three rotations of ways of both limbs, the other limb as it was or straight.

    Attributes:
        moves: To the base, of limb 1's ways and of limb 2's. Each of shape (k, 3, 4, 4).
        apart: How near the limbs come, as far as it matters, in units of L. Each of shape (k, 3).
    """

    moves: tuple[Array, Array]
    apart: tuple[Array, Array]


def rotation_pieces(ways: Ways, shape: Array, limb: int) -> Pieces:
    """Return the pieces of all ways, three rotations each, of limb 0 or 1 from a shape."""
    axis, count = ways.control % 3, len(ways)
    turn = np.empty((count, 3, 3, 3))
    for k in range(3):
        mine = axis == k
        turn[mine] = about_axis(k, ways.angle[mine])
    shapes = np.tile(shape, (count, 3, 1, 1, 1))
    shapes[:, 1, limb] = matmul(shape[limb], turn[:, 0])
    shapes[:, 2, limb] = matmul(shapes[:, 1, limb], turn[:, 1])
    rates = np.where(np.arange(6) == ways.control[..., None], np.sign(ways.angle)[..., None], 0.0)
    return Pieces(shapes.reshape(-1, 2, 3, 3), rates.reshape(-1, 6), np.abs(ways.angle).ravel())


def _played(
    swimmer: Swimmer, shapes: Sequence[Array], limbs: Sequence[tuple[Ways, Ways]], clearance_m: float
) -> list[tuple[Played, Played]]:
    """Return what the ways of each shape's limbs do while the other limb is as it was, and while it is straight."""
    parts = []
    for shape, both in zip(shapes, limbs, strict=True):
        for straight in (False, True):
            for i, ways in enumerate(both):
                here = shape.copy()
                if straight:
                    here[1 - i] = np.eye(3)
                parts.append(rotation_pieces(ways, here, i))
    pieces = Pieces.together(parts)
    moves = piece_displacements(swimmer, pieces, ROUGH).reshape(-1, 3, 4, 4)
    apart = clearances(swimmer, pieces, clearance_m)[0].reshape(-1, 3)
    stops = np.cumsum([len(part) // 3 for part in parts])[:-1]
    each = list(zip(np.split(moves, stops), np.split(apart, stops), strict=True))
    done = [Played((a[0], b[0]), (a[1], b[1])) for a, b in zip(each[::2], each[1::2], strict=True)]
    return list(zip(done[::2], done[1::2], strict=True))


def _within(swimmer: Swimmer, shape: Array, limbs: Sequence[Ways]) -> tuple[Ways, Ways]:
    """Return the ways that bend a limb no further than it is, or than the limit; the first if there are none."""
    pieces = Pieces.together(rotation_pieces(w, shape, i) for i, w in enumerate(limbs))
    bend = LimbCircles.of(pieces).largest_bends()[0].reshape(-1, 3, 2).max(axis=1)
    kept, low = [], 0
    for i, ways in enumerate(limbs):
        limit = max(swimmer.max_bend_rad, float(bends(shape[i, :, 0]))) + BEND_SLACK_RAD
        good = np.flatnonzero(bend[low : low + len(ways), i] <= limit)
        low += len(ways)
        kept.append(ways[good if len(good) and np.any(ways.angle[0]) else np.array([0])])
    return kept[0], kept[1]
