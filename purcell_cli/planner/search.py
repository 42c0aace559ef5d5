"""The search: which strokes, in which order, take the swimmer to its goal at the least cost.

Three choices are made together. How the limbs are straightened and bent again moves the base, so it
decides what is left for phase 2; the needle then says by which arcs and rolls that is made; and for
short ways stored gaits one after the other may be shorter than arcs. What comes out is almost a
plan: it arrives but for a few per cent, and the finish does the rest.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from purcell_cli import se3
from purcell_cli.errors import GaitError
from purcell_cli.gaits import Gait, guessed
from purcell_cli.planner.arcs import Fan, arc_blocks, fan
from purcell_cli.planner.limbs import Straightenings, straightenings
from purcell_cli.planner.measures import cost
from purcell_cli.planner.needle import settled, steer
from purcell_cli.planner.strokes import phase_two, stroke_book
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block

PHASES = {1: "limbs to collinear", 2: "stored gaits", 3: "limbs to the goal shape"}

_TRIED = 4
"""How many of the needle's ways are made into strokes."""
_CRANK_RAD = 1.6
"""The largest roll of one crank."""
_SHORT_RAD = 40.0
"""Up to this joint travel stored gaits one after the other are tried too."""
_NEGLIGIBLE = 1e-12
_SLIGHT_ROLL_RAD = 1e-4
"""Rolls by less are left to the finish."""
_SLIGHT_RAD, _SAME = 0.3, 1e-4
"""Arcs of less joint travel are left out; neighbours are one if that costs them no more than so much."""
_FAR_L = 3.0
"""From this distance on loops with offsets across their plane are tried too: their ways in and out pay there."""
_FAR_OFF = 0.3
"""Arcs that miss their displacement by more (L, rad) are too few."""


@dataclasses.dataclass(frozen=True, slots=True)
class Breadth:
    """How widely to search.

    Attributes:
        pairs: Pairs of ways to straighten and to bend that are steered for.
        starts: Starts of the needle, for all pairs together.
        both: Whether both fans of loops are tried on short ways too.
    """

    pairs: int = 12
    starts: int = 96
    both: bool = False


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A motion that almost arrives.

    Attributes:
        words: What it is made of.
        blocks: Its strokes.
        kind: Candidates of one kind, where one of them does not arrive, are hard to make arrive.
    """

    words: str
    blocks: tuple[Block, ...]
    kind: str = ""

    @property
    def joint_travel_rad(self) -> float:
        """Its joint travel [rad]."""
        return sum(b.joint_travel_rad for b in self.blocks)


def candidates(
    swimmer: Swimmer,
    start: Array,
    goal: Array,
    wanted: Array,
    gaits: Mapping[str, Gait],
    measure: str = "travel",
    clearance: float = 0.0,
    breadth: Breadth = Breadth(),
) -> list[Candidate]:
    """Return motions that almost make a displacement between two shapes, the best first.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        start: Shape at the beginning. Shape (2, 3, 3).
        goal: Shape at the end. Shape (2, 3, 3).
        wanted: Body displacement. Shape (4, 4).
        gaits: The stored gaits.
        measure: One of `measures.MEASURES`.
        clearance: How far the limbs stay apart in phases 1 and 3, in units of L.
        breadth: How widely to search.

    Raises:
        GaitError: No stored gait for a motion that is needed.
    """
    first, last = (straightenings(swimmer, shape, clearance) for shape in (start, goal))
    found: list[Candidate] = []
    far = float(np.linalg.norm(wanted[:3, 3])) >= _FAR_L
    cranks = [g for g in gaits.values() if g.moves == "roll" and g.amplitude_is_displacement]
    for across in (True, False) if far or breadth.both else (False,):
        loops = fan(swimmer, measure, across)
        pairs, missing = _pairs(first, last, wanted, loops, breadth.pairs)
        if cranks:
            found += _steered(swimmer, loops, cranks[0], (first, last), pairs, missing, breadth.starts)
    if not found or min(c.joint_travel_rad for c in found) < _SHORT_RAD:
        book = stroke_book(tuple(gaits.values()), swimmer)
        for (i, j), displacement in list(zip(pairs, missing, strict=True))[:2]:
            try:
                inner = phase_two(book, displacement)
            except GaitError:
                if found:
                    continue
                raise
            found.append(_candidate("stored gaits one after the other", first, i, inner, last, j))
    return sorted(found, key=lambda c: float(f"{cost(measure, swimmer, c.blocks, start):.9e}"))


def _steered(
    swimmer: Swimmer,
    loops: Fan,
    crank: Gait,
    limbs: tuple[Straightenings, Straightenings],
    pairs: list[tuple[int, int]],
    missing: Array,
    starts: int,
) -> list[Candidate]:
    """Return motions by the loops of one fan and rolls between, for pairs of ways in and out and what they leave."""
    first, last = limbs
    way = steer(missing, loops, math.ceil(starts / len(pairs)))
    travel = loops.cost(way.arc[..., 0], np.hypot(way.arc[..., 1], way.arc[..., 2])).sum(axis=1)
    travel += np.array([first.joint_travel_rad[i] + last.joint_travel_rad[j] for i, j in pairs])[way.displacement]
    out = []
    for k in _distinct(travel):
        i, j = pairs[way.displacement[k]]
        made = missing[way.displacement[k]]
        arcs, roll, off = settled(_swum(loops, _fewest(loops, way.arc[k])), float(way.roll[k]), made)
        if off > _FAR_OFF:  # on a long way slight arcs count
            arcs, roll, _ = settled(_swum(loops, way.arc[k]), float(way.roll[k]), made)
        inner = _arcs(swimmer, loops, crank, arcs, roll)
        if inner:
            words = f"{len(arcs)} arc{'s' * (len(arcs) != 1)} with rolls between"
            out.append(_candidate(words, first, i, inner, last, j, "across" if loops.across else ""))
    return out


def _distinct(travel: Array) -> list[int]:
    """Return the ways of least joint travel, each a little different from the one before."""
    out: list[int] = []
    for k in np.argsort(travel, kind="stable").tolist():
        if not out or travel[k] > travel[out[-1]] + 0.01:
            out.append(k)
        if len(out) == _TRIED:
            break
    return out


def _candidate(
    words: str, first: Straightenings, i: int, inner: list[Block], last: Straightenings, j: int, kind: str = ""
) -> Candidate:
    before, after = first.sequence(i), last.sequence(j).inverse()
    return Candidate(
        words,
        (
            *([Block(1, PHASES[1], before)] if len(before) else []),
            *inner,
            *([Block(3, PHASES[3], after)] if len(after) else []),
        ),
        kind,
    )


def _pairs(
    first: Straightenings, last: Straightenings, wanted: Array, loops: Fan, most: int
) -> tuple[list[tuple[int, int]], Array]:
    """Return the pairs of ways in and out that promise the least joint travel, and what they leave to be made.

    What is left costs at least the change of heading at the tightest loop's rate, and at least the
    distance at the straight loop's.
    """
    gone = se3.inverse(first.displacement) @ wanted
    done = last.displacement  # phase 3 is played backwards, so this is what undoes it
    heading = np.clip(gone[:, 0, :3] @ done[:, :3, 0].T, -1.0, 1.0)
    between = gone[:, :3, :3].reshape(-1, 3) @ done[:, :3, 3].T
    position = between.reshape(len(gone), 3, -1) + gone[:, :3, 3:]
    distance = np.sqrt(np.einsum("iaj,iaj->ij", position, position))
    promised = np.arccos(heading) / loops.tight + distance / loops.straight
    promised += first.joint_travel_rad[:, None] + last.joint_travel_rad
    count = min(most, promised.size)
    few = np.flatnonzero(promised <= np.partition(promised, count - 1, axis=None)[count - 1])
    best = few[np.argsort(promised.ravel()[few], kind="stable")][:count]
    pairs = [(int(k // promised.shape[1]), int(k % promised.shape[1])) for k in best]
    return pairs, se3.normalised(np.stack([gone[i] @ done[j] for i, j in pairs]))


def _fewest(loops: Fan, arc: Array) -> Array:
    """Return arcs without slight ones, neighbours of one direction made one. Shape (n, 3)."""
    out: list[Array] = []
    for one in arc:
        travel = _cost(loops, one)
        if travel < _SLIGHT_RAD:
            continue
        if out and _cost(loops, out[-1]) + travel < (1.0 + _SAME) * _cost(loops, out[-1] + one):
            out[-1] = out[-1] + one
        else:
            out.append(one)
    return np.array(out).reshape(-1, 3)


def _swum(loops: Fan, arc: Array) -> Array:
    """Return arcs as loops can swim them, those that are too tight in parts. Shape (n, 3)."""
    parts = []
    for advance, p, q in arc.tolist():
        turn = math.hypot(p, q)
        across = (p / turn, q / turn) if turn > 0.0 else (0.0, 1.0)
        parts += [(a, b * across[0], b * across[1]) for a, b in loops.ways(advance, turn)]
    return np.array(parts).reshape(-1, 3)


def _cost(loops: Fan, arc: Array) -> float:
    return float(loops.cost(arc[0], np.hypot(arc[1], arc[2])))


def _arcs(swimmer: Swimmer, loops: Fan, crank: Gait, arc: Array, roll: float) -> list[Block]:
    """Return the strokes of arcs with the rolls between them: never more than a quarter turn to the next plane."""
    out: list[Block] = []
    plane = 0.0
    for advance, p, q in arc.tolist():
        turn = math.hypot(p, q)
        if turn > _NEGLIGIBLE:
            tilt = loops.at(loops.knot(advance, turn), loops.tilt)
            change = math.remainder(math.atan2(-p, q) - tilt - plane, 2.0 * math.pi)
            if abs(change) > 0.5 * math.pi:
                change, turn = math.remainder(change + math.pi, 2.0 * math.pi), -turn
            if abs(change) > _SLIGHT_ROLL_RAD:
                out += _rolls(swimmer, crank, change)
                plane += change
        out += arc_blocks(loops, advance, turn)
    return _last_apart(out) + _rolls(swimmer, crank, roll - plane)


def _last_apart(blocks: list[Block]) -> list[Block]:
    """Return blocks with the last cycle of all that repeat on its own: it takes up what the others leave."""
    repeated = [k for k, b in enumerate(blocks) if b.cycles > 1]
    if not repeated:
        return blocks
    k = repeated[-1]
    fewer, one = (dataclasses.replace(blocks[k], cycles=n) for n in (blocks[k].cycles - 1, 1))
    return [*blocks[:k], fewer, one, *blocks[k + 1 :]]


def _rolls(swimmer: Swimmer, crank: Gait, angle: float) -> list[Block]:
    angle = math.remainder(angle, 2.0 * math.pi)
    if abs(angle) < _SLIGHT_ROLL_RAD:
        return []
    count = math.ceil(abs(angle) / _CRANK_RAD)
    one = guessed(crank, swimmer, angle / count)
    return [Block(2, crank.name, one.cycle, 1, angle / count)] * count
