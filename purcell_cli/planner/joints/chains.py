"""Chains of loops: which loops, how often each, make a displacement (the steering of far goals with any joints).

A loop that repeats moves the base along a screw: n cycles make exp(n xi). A chain of screws makes the displacement when
a few equations hold, in as many unknowns and more: the numbers of cycles, taken as real here. Newton's method solves
them from many random starts at once, then from chains like the best ones, and the least joint travel wins. Lengths are
in units of L.
"""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import screw_chains
from purcell_cli.planner.joints.loops import Rows, Screws

_DIRECTIONS = 400
"""Directions of the displacement space in each of which the best loop is kept."""
_PARENTS, _CHILDREN, _GENERATIONS = 8, 16, 12
"""The best chains that others are made from, how many from each, and how often: they save a tenth of the joint travel
of random queries by all combinations of joints, for less time than three times as many random chains take."""
_FEWER = 5
"""How often others are made from chains that are the best of a like displacement: they are as good as those from
scratch."""
_UNEVEN = 0.3
"""Standard deviation of the relative change of a parent's numbers of cycles."""
_SOLVED = 1e-3
"""A chain that misses by less than this is solved [L, rad]: refinement does the rest."""


@frozen_dataclass(eq=False)
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

    def times(self, count: int) -> Chains:
        """Return the chains played a number of times, one after the other."""
        several = np.tile(self.loops, (1, count)), np.tile(self.cycles, (1, count))
        return Chains(*several, self.missing, self.travel * count)


def best_loops(loops: Screws, rows: tuple[int, ...], most: int, seed: int = 0) -> Rows:
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


def solved_chains(loops: Screws, which: Rows, starts: Array, wanted: Array, rows: tuple[int, ...]) -> Chains:
    """Return chains brought to a displacement by Newton's method, from some numbers of cycles.

    Args:
        loops: The loops.
        which: Which loops each chain has, in order. Shape (n, k).
        starts: The numbers of cycles to begin with. Shape (n, k).
        wanted: The displacement. Shape (4, 4).
        rows: The components of twists that count.
    """
    cycles, missing = screw_chains.solved(which, starts, loops.twist, loops.travel, se3.inverse(wanted), rows)
    travel = np.sum(np.abs(cycles) * loops.travel[which] + (np.abs(cycles) > 1e-3) * loops.approach[which], axis=1)
    return Chains(which, cycles, missing, travel)


def chains_for(
    loops: Screws,
    wanted: Array,
    rows: tuple[int, ...],
    counts: tuple[int, int, int],
    seed: int = 0,
    like: Chains | None = None,
) -> Chains:
    """Return chains of loops that make a displacement, the least joint travel first.

    Args:
        loops: The loops, few of them.
        wanted: The displacement. Shape (4, 4).
        rows: The components of twists that count.
        counts: How many loops a chain has at least and at most, and how many chains are tried.
        seed: Seed of the chains.
        like: Chains that make another displacement, of as many loops: the first ones are like those.
    """
    least, most, tries = counts
    rng = np.random.default_rng(seed)
    if like is not None:
        parents = solved_chains(loops, like.loops[:_PARENTS], like.cycles[:_PARENTS], wanted, rows)
        return _sorted(_bred(loops, wanted, rows, parents, _FEWER, rng))
    found: list[Chains] = []
    for length in range(least, most + 1):
        which = rng.integers(len(loops), size=(tries // (most + 1 - least), length))
        starts = normal_numbers(rng, which.shape) * _reach(loops, which, wanted)
        tried = solved_chains(loops, which, starts, wanted, rows)
        found.append(_bred(loops, wanted, rows, tried, _GENERATIONS, rng))
    return _sorted(_together(found, most))


def _bred(
    loops: Screws, wanted: Array, rows: tuple[int, ...], tried: Chains, generations: int, rng: np.random.Generator
) -> Chains:
    """Return chains, the last of those that others like the best ones were made of, again and again."""
    length = tried.loops.shape[1]
    for _ in range(generations):
        parents = _sorted(tried)
        if not len(parents.loops):
            break
        which, starts = _children(rng, loops, parents, wanted)
        tried = _together([parents, solved_chains(loops, which, starts, wanted, rows)], length)
    return tried


def _reach(loops: Screws, which: Rows, wanted: Array) -> Array:
    """Return how many cycles go the way, or turn by up to half a turn: the size of the first numbers of cycles."""
    twist = se3.log(wanted)
    way, turn = float(np.sqrt(np.sum(twist[:3] ** 2))), float(np.sqrt(np.sum(twist[3:] ** 2)))
    own = loops.twist[which]
    moves = np.sqrt(np.sum(own[..., :3] ** 2, axis=-1)), np.sqrt(np.sum(own[..., 3:] ** 2, axis=-1))
    reach = np.minimum(
        (way + 0.1) / np.maximum(moves[0], 1e-9), (min(turn, math.pi) + 1.0) / np.maximum(moves[1], 1e-9)
    )
    return np.asarray(0.7 * reach)


def _children(rng: np.random.Generator, loops: Screws, parents: Chains, wanted: Array) -> tuple[Rows, Array]:
    """Return chains like the best ones: one of their loops is another, its place another, or cycles are others."""
    few = min(_PARENTS, len(parents.loops))
    which = np.repeat(parents.loops[:few], _CHILDREN, axis=0)
    cycles = np.repeat(parents.cycles[:few], _CHILDREN, axis=0)
    row = np.arange(len(which))
    one, two = (rng.integers(which.shape[1], size=len(which)) for _ in range(2))
    cycles = cycles * (1.0 + _UNEVEN * normal_numbers(rng, cycles.shape))
    # Odd children have two loops change places, even ones have another loop in place of one.
    swap = row % 2 == 1
    order = np.tile(np.arange(which.shape[1]), (len(which), 1))
    order[row[swap], one[swap]], order[row[swap], two[swap]] = two[swap], one[swap]
    which, cycles = which[row[:, None], order], cycles[row[:, None], order]
    which[row[~swap], one[~swap]] = rng.integers(len(loops), size=int(np.sum(~swap)))
    fresh = normal_numbers(rng, cycles.shape) * _reach(loops, which, wanted)
    cycles[row[~swap], one[~swap]] = fresh[row[~swap], one[~swap]]
    return which, cycles


def _together(chains: list[Chains], width: int) -> Chains:
    """Return chains of several lengths as chains of one, the shorter ones with a first loop that is not played."""
    return Chains(
        np.concatenate([np.pad(c.loops, ((0, 0), (0, width - c.loops.shape[1]))) for c in chains]),
        np.concatenate([np.pad(c.cycles, ((0, 0), (0, width - c.cycles.shape[1]))) for c in chains]),
        np.concatenate([c.missing for c in chains]),
        np.concatenate([c.travel for c in chains]),
    )


def _sorted(chains: Chains) -> Chains:
    good = np.flatnonzero(chains.missing < _SOLVED)
    order = good[np.argsort(np.round(chains.travel[good], 9), kind="stable")]
    return Chains(chains.loops[order], chains.cycles[order], chains.missing[order], chains.travel[order])
