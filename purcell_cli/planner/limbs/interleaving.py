"""Interleaving: orders in which the rotations of one limb stand between those of the other."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import ROUGH, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import TOLERANCE_L, clearances
from purcell_cli.planner.limbs.limb_rotations import Ways
from purcell_cli.planner.limbs.straightening import MOST_LOOPS, Straightenings, rotation_pieces

_AT_ONCE = ((0, 0, 0), (1, 1, 1))
"""First halves of orders in which one limb makes all its rotations before the other: those are known already."""


def interleaved(
    swimmer: Swimmer, shapes: Sequence[Array], known: Sequence[Straightenings], most: int, clearance_m: float = 0.0
) -> list[Straightenings]:
    """Return straightenings and more of them: the rotations of one limb between the other's.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shapes: The shapes to begin with. Each of shape (2, 3, 3).
        known: Straightenings of each, the most promising first.
        most: How many of their pairs of ways, the first ones, are taken in all orders.
        clearance_m: How far the limbs' surfaces stay apart, in units of L.
    """
    chosen = []
    for one in known:
        first, _ = distinct(one.way)
        bent = all(np.any(limb.angle) for limb in one.limbs)  # otherwise there is nothing to stand between
        chosen.append(one.way[np.sort(first)[: most if bent else 0]])
    if not any(map(len, chosen)):
        return list(known)
    parts = [
        _crossed(shape, [limb[k] for limb, k in zip(one.limbs, some.T, strict=True)])
        for shape, one, some in zip(shapes, known, chosen, strict=True)
    ]
    pieces = Pieces.together(parts)
    moves = piece_displacements(swimmer, pieces, ROUGH).reshape(-1, 2, 3, 2, 4, 4)
    apart = clearances(swimmer, pieces, clearance_m)[0].reshape(-1, 2, 3, 2)
    out, low = [], 0
    for one, some in zip(known, chosen, strict=True):
        mine = slice(low, low + len(some))
        order, displacement, nearest = _through(*_with_ends(one, some, moves[mine], apart[mine]))
        way, orders = np.tile(some, (len(order), 1)), np.repeat(order, len(some), axis=0)
        travel = one.limbs[0].joint_travel_rad[way[:, 0]] + one.limbs[1].joint_travel_rad[way[:, 1]]
        moved, none = se3.normalised(displacement.reshape(-1, 4, 4)), np.zeros((len(way), MOST_LOOPS), dtype=np.int64)
        more = Straightenings(one.limbs, orders, way, none, travel, moved, one.alone)
        out.append(one.and_(more[np.flatnonzero(nearest.ravel() >= clearance_m - TOLERANCE_L)]))
        low += len(some)
    return out


def _crossed(shape: Array, ways: Sequence[Ways]) -> Pieces:
    """Return the pieces of every rotation of one limb after one and after two of the other: k x 2 x 3 x 2.

    Args:
        shape: The shape before. Shape (2, 3, 3).
        ways: The ways of limb 1 and of limb 2 that are taken together, k of each.
    """
    k = len(ways[0])
    begins = [rotation_pieces(way, shape, i).shapes.reshape(k, 3, 2, 3, 3)[:, :, i] for i, way in enumerate(ways)]
    shapes, rates, durations = np.empty((k, 2, 3, 2, 2, 3, 3)), np.empty((k, 2, 3, 2, 6)), np.empty((k, 2, 3, 2))
    for i, way in enumerate(ways):
        shapes[:, i, ..., i, :, :] = begins[i][:, :, None]
        shapes[:, i, ..., 1 - i, :, :] = begins[1 - i][:, None, 1:]
        turned = np.sign(way.angle)[..., None] * (np.arange(6) == way.control[..., None])
        rates[:, i], durations[:, i] = turned[:, :, None], np.abs(way.angle)[..., None]
    return Pieces(shapes.reshape(-1, 2, 3, 3), rates.reshape(-1, 6), durations.ravel())


def _with_ends(known: Straightenings, way: NDArray[np.int64], moves: Array, apart: Array) -> tuple[Array, Array]:
    """Return what every rotation of one limb does at every stage of the other, and how near the limbs come on it.

    Args:
        known: What it does before the other limb's rotations and after them.
        way: The ways of both limbs. Shape (k, 2).
        moves: What it does between. Shape (k, 2, 3, 2, 4, 4).
        apart: How near the limbs come there. Shape (k, 2, 3, 2).

    Returns:
        Displacements, shape (k, 2, 3, 4, 4, 4), and least distances, shape (k, 2, 3, 4).
    """
    whole = [np.stack([one.moves[i][way[:, i]] for i in (0, 1)], axis=1)[:, :, :, None] for one in known.alone]
    near = [np.stack([one.apart[i][way[:, i]] for i in (0, 1)], axis=1)[..., None] for one in known.alone]
    return np.concatenate([whole[0], moves, whole[1]], axis=3), np.concatenate([near[0], apart, near[1]], axis=3)


def _through(moves: Array, apart: Array) -> tuple[NDArray[np.int64], Array, Array]:
    """Return the orders in which neither limb makes all its rotations at once, and what they do.

    Args:
        moves: What every rotation of one limb does at every stage of the other. Shape (k, 2, 3, 4, 4, 4).
        apart: How near the limbs come on it. Shape (k, 2, 3, 4).

    Returns:
        Orders, shape (18, 6), displacements, shape (18, k, 4, 4), and the least distances, shape (18, k).
    """
    order = np.array([o for o in itertools.product((0, 1), repeat=6) if sum(o) == 3 and o[:3] not in _AT_ONCE])
    done = np.cumsum(order, axis=1) - order  # rotations of limb 2 before each
    row = np.arange(6)
    turn, other = np.where(order == 0, (row - done, done), (done, row - done))
    each, near = moves[:, order, turn, other], apart[:, order, turn, other]
    whole = functools.reduce(matmul, (each[:, :, n] for n in range(6)))
    return order, np.swapaxes(whole, 0, 1), near.min(axis=2).T
