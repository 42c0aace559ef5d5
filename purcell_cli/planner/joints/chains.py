"""Chains of loops: which loops, how often each, make a displacement (the steering of far goals with any joints).

A loop that repeats moves the base along a screw: n cycles make exp(n xi). A chain of screws makes the displacement when
a few equations hold, in as many unknowns and more: the numbers of cycles, taken as real here. Newton's method solves
them from many starts at once, and the least joint travel wins. Lengths are in units of L.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import apply, matmul, normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.joints.loops import Loops, Rows

_DIRECTIONS = 400
"""Directions of the displacement space in each of which the best loop is kept."""
_ROUNDS = 40
"""The most Newton steps of a chain."""
_SOLVED = 1e-3
"""A chain that misses by less than this is solved [L, rad]: refinement does the rest."""
_DAMPING = 1e-6
"""Damping of the Gram matrix, as a part of its trace."""
_STEP = 1.5
"""The largest motion by one part of a chain in a Newton step [L, rad]."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Chains:
    """Chains of loops that make a displacement.

    Attributes:
        loops: Which loops, in order. Shape (n, k).
        cycles: How often each, negative the other way round; not whole. Shape (n, k).
        missing: What each misses by [L, rad]. Shape (n,).
        travel: The joint travel of each, approaches included [rad]. Shape (n,).
    """

    loops: Rows
    cycles: Array
    missing: Array
    travel: Array


def best_loops(loops: Loops, rows: tuple[int, ...], most: int, seed: int = 0) -> Rows:
    """Return the loops that go farthest per joint travel in some direction, the most useful first.

    Those are the corners of the convex hull of what loops do per joint travel. Each direction is measured by the
    largest there is of it. As a roll costs little and arcs turn by little, directions without a roll, and with a small
    share of rotations, are asked for as well.

    Args:
        loops: The loops.
        rows: The components of twists that count.
        most: How many at most.
        seed: Seed of the directions.
    """
    rate = loops.twist[:, rows] / loops.travel[:, None]
    scale = np.max(np.abs(rate), axis=0)
    unit = rate / np.where(scale > 0.0, scale, 1.0)
    rng = np.random.default_rng(seed)
    directions = normal_numbers(rng, (_DIRECTIONS, len(rows)))
    directions = np.concatenate([np.eye(len(rows)), directions])
    # A loop that goes little beside its direction is worth more: what it does beside must be undone.
    clean = np.abs(unit) / np.maximum(np.sqrt(np.sum(unit * unit, axis=1)), 1e-300)[:, None]
    found = [int(np.argmax(np.abs(unit[:, k]) * clean[:, k] ** 2)) for k in range(len(rows))]
    best = np.argmax(np.abs(matmul(unit, directions.T)), axis=0)
    names, counts = np.unique(best, return_counts=True)
    order = names[np.lexsort((names, -counts))].tolist()
    return np.array(list(dict.fromkeys([*found, *order]))[:most], dtype=np.int64)


def solved_chains(loops: Loops, words: Rows, starts: Array, wanted: Array, rows: tuple[int, ...]) -> Chains:
    """Return chains brought to a displacement by Newton's method, from some numbers of cycles.

    Args:
        loops: The loops.
        words: Which loops each chain has, in order. Shape (n, k).
        starts: The numbers of cycles to begin with. Shape (n, k).
        wanted: The displacement. Shape (4, 4).
        rows: The components of twists that count.
    """
    twist, travel = loops.twist[words], loops.travel[words]
    inverse, n = se3.inverse(wanted), starts.copy()
    size = np.sqrt(np.sum(twist * twist, axis=-1))
    weight = 1.0 / travel
    best, kept = np.full(len(words), np.inf), n.copy()
    every = np.arange(len(rows))
    for _ in range(_ROUNDS):
        moves = se3.exp(n[..., None] * twist)
        after = np.broadcast_to(np.eye(4), (len(words), 4, 4))
        columns = np.empty((len(words), len(rows), words.shape[1]))
        for k in range(words.shape[1] - 1, -1, -1):
            after = matmul(moves[:, k], after)
            columns[:, :, k] = apply(se3.adjoint(se3.inverse(after)), twist[:, k])[:, rows]
        residual = se3.log(matmul(inverse, se3.normalised(after)))[:, rows]
        off = np.max(np.abs(residual), axis=1)
        better = off < best
        best, kept[better] = np.where(better, off, best), n[better]
        weighted = columns * weight[:, None, :]
        gram = matmul(weighted, np.swapaxes(weighted, 1, 2))
        trace = np.trace(gram, axis1=1, axis2=2)
        gram[:, every, every] += _DAMPING * trace[:, None] + 1e-300
        multipliers = solve(gram, -residual[..., None])[..., 0]
        step = weight * apply(np.swapaxes(weighted, 1, 2), multipliers)
        step = np.where(np.isfinite(step), step, 0.0)
        longest = np.max(np.abs(step) * size, axis=1)
        n = n + step * np.minimum(1.0, _STEP / np.maximum(longest, 1e-300))[:, None]
    used = np.abs(kept) > 1e-3
    total = np.sum(np.abs(kept) * travel + used * loops.approach[words], axis=1)
    return Chains(words, kept, best, total)


def chains_for(
    loops: Loops, wanted: Array, rows: tuple[int, ...], counts: tuple[int, int, int], seed: int = 0
) -> Chains:
    """Return chains of loops that make a displacement, the least joint travel first.

    Args:
        loops: The loops, few of them.
        wanted: The displacement. Shape (4, 4).
        rows: The components of twists that count.
        counts: How many loops a chain has at least and at most, and how many chains are tried.
        seed: Seed of the chains.
    """
    least, most, tries = counts
    rng = np.random.default_rng(seed)
    twist = se3.log(wanted)
    way, turn = float(np.sqrt(np.sum(twist[:3] ** 2))), float(np.sqrt(np.sum(twist[3:] ** 2)))
    found: list[Chains] = []
    for length in range(least, most + 1):
        many = tries // (most + 1 - least)
        words = rng.integers(len(loops), size=(many, length))
        own = loops.twist[words]
        moves = np.sqrt(np.sum(own[..., :3] ** 2, axis=-1)), np.sqrt(np.sum(own[..., 3:] ** 2, axis=-1))
        # Of a loop that moves and turns, as many cycles as go the way, or turn by up to half a turn.
        reach = np.minimum(
            (way + 0.1) / np.maximum(moves[0], 1e-9), (min(turn, math.pi) + 1.0) / np.maximum(moves[1], 1e-9)
        )
        starts = normal_numbers(rng, (many, length)) * reach * 0.7
        found.append(solved_chains(loops, words, starts, wanted, rows))
    width = most
    return _sorted(
        Chains(
            np.concatenate([np.pad(c.loops, ((0, 0), (0, width - c.loops.shape[1]))) for c in found]),
            np.concatenate([np.pad(c.cycles, ((0, 0), (0, width - c.cycles.shape[1]))) for c in found]),
            np.concatenate([c.missing for c in found]),
            np.concatenate([c.travel for c in found]),
        )
    )


def _sorted(chains: Chains) -> Chains:
    good = np.flatnonzero(chains.missing < _SOLVED)
    order = good[np.argsort(np.round(chains.travel[good], 9), kind="stable")]
    return Chains(chains.loops[order], chains.cycles[order], chains.missing[order], chains.travel[order])
