"""Phase 2: a sequence of stored gaits that makes a given body displacement (section IV-B, step 2).

Each stored gait is pure: it makes one motion and no other. So a displacement is split into a sequence
of motions, and each motion into cycles of one amplitude.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from purcell_cli.errors import GaitError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits import pure_stroke
from purcell_cli.gaits.gait import MOTIONS, Gait, Stroke
from purcell_cli.geometry.reproducible import arctan2_of
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.sequence import cheapest
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.limbs.pairs import LimbPairs
from purcell_cli.planner.prepared import kept, words_of
from purcell_cli.planner.problem import Problem

_BEND_MAX_RAD = 1.0
"""The largest amplitude of a gait's stroke, where the bend limit is not less [rad]; smaller ones are tried next."""
_ROLL_STEP_RAD = 1.0
"""The same for gaits whose amplitude is the displacement, that is rolls [rad]."""
_SMALLEST_RAD = 0.1
"""Below this amplitude a gait that cannot be made pure is an error, and is tried no further [rad]."""
_ALMOST_PURE = 1e-9
"""Allowed cross-talk and closure of strokes that are only priced, not played [L, rad]."""
_TRIES = 40
"""How many counts of cycles are tried, from the fewest on, until a stroke goes as far as is wanted."""
_BEND_SLACK = 1.0 + 1e-6
"""A stroke may bend so many times the bend limit: room for rounding."""
_NEGLIGIBLE = 1e-13
"""Displacements below this are none [L, rad]."""
_PAIRS = 2
"""How many of the most promising pairs of limbs' ways get a sequence of gaits."""
_WORDS = "stored gaits one after the other"
"""What such candidates are made of."""
_DEAR = 1.06
"""Sequences priced at more than so many times the best that is known, or at a cycle of each stroke more than it, are
made only when they are asked for: of 70 queries prices were at most 4 % above what the strokes took, and what a price
does not know is each stroke's last cycle."""


@frozen_dataclass
class Motion:
    """One motion along or about one body axis.

    Attributes:
        along: One of `gait.MOTIONS`.
        amount: How far [L or rad].
    """

    along: str
    amount: float


class StrokeBook:
    """The pure strokes of one scaled swimmer: the largest displacement of each gait, and its cost.

    Attributes:
        swimmer: The swimmer.
        gaits: The gaits that make each motion.
        largest: Of each gait the largest amplitude that is used [rad], and how far its stroke goes [L or rad].
        numbers: What sequences of them are priced by; see `kernel.sequence.cheapest`.
    """

    def __init__(self, gaits: Iterable[Gait], swimmer: Swimmer) -> None:
        self.swimmer = swimmer
        everything = list(gaits)
        self.gaits = {m: [g for g in everything if g.moves == m] for m in MOTIONS}
        missing = [m for m, found in self.gaits.items() if not found]
        if missing:
            raise GaitError(f"planning needs a stored gait for each motion; none moves along {', '.join(missing)}")
        used = [g for found in self.gaits.values() for g in found]
        key = [str(swimmer.max_bend_rad), *(words_of(g) for g in used)]
        table = kept("strokes", swimmer, key, lambda: np.array([self._largest(g) for g in used]))
        rows: list[list[float]] = table.tolist()
        self.largest = {g.name: (row[0], row[1]) for g, row in zip(used, rows, strict=True)}
        self._prices = {g.name: (row[2], row[3], abs(row[1])) for g, row in zip(used, rows, strict=True)}
        counts = [len(self.gaits[m]) for m in MOTIONS]
        self.numbers = counts, np.array([self._prices[g.name] for m in MOTIONS for g in self.gaits[m]])

    def _largest(self, gait: Gait) -> tuple[float, float, float, float]:
        """Return the largest amplitude that is used, how far its stroke goes, and the travel of approach and cycle."""
        stroke = largest_stroke(gait, self.swimmer)
        approach, cycle = stroke.approach.joint_travel_rad, stroke.cycle.joint_travel_rad
        return stroke.amplitude_rad, self._amount(gait, stroke), 2.0 * approach, cycle

    def _amount(self, gait: Gait, stroke: Stroke) -> float:
        g = stroke.displacement(self.swimmer)
        own = MOTIONS.index(gait.moves)
        if own < 3:
            return float(g[own, 3])
        j, k = (own - 2) % 3, (own - 1) % 3
        return arctan2_of(float(g[k, j]), float(g[j, j]))

    def cost(self, motion: Motion) -> float:
        """Return about how much joint travel a motion takes [rad]."""
        return min(self._cost(g, motion) for g in self.gaits[motion.along])

    def cycle_rad(self, motion: Motion) -> float:
        """Return the joint travel of the largest cycle that makes a motion [rad]."""
        return max(self._prices[g.name][1] for g in self.gaits[motion.along])

    def _cost(self, gait: Gait, motion: Motion) -> float:
        approach, cycle, reach = self._prices[gait.name]
        count = abs(motion.amount) / reach
        return approach + cycle * float(math.ceil(count) ** (2 / 3) * count ** (1 / 3))

    def blocks(self, motion: Motion) -> list[Block]:
        """Return the strokes that make a motion exactly; none for a motion of nothing."""
        if abs(motion.amount) <= _NEGLIGIBLE:
            return []
        gait = min(self.gaits[motion.along], key=lambda g: self._cost(g, motion))
        _, reach = self.largest[gait.name]
        fewest = max(math.ceil(abs(motion.amount) / abs(reach) - 1e-12), 1)
        tries = ((n, self._of(gait, math.copysign(motion.amount / n, reach))) for n in range(fewest, fewest + _TRIES))
        cycles, stroke = next(((n, s) for n, s in tries if s is not None), (0, None))
        if stroke is None:
            raise GaitError(f"gait {gait.name!r} makes no {motion.amount:g} along {motion.along} for this swimmer")
        if motion.amount * reach < 0:
            stroke = stroke.inverse()
        return blocks_of(stroke, cycles)

    def _of(self, gait: Gait, amount: float) -> Stroke | None:
        """Return the stroke that goes an amount, or None where there is none within the bend limit.

        A displacement need not grow with the amplitude all the way to the limit.
        """
        amplitude, reach = self.largest[gait.name]
        order = 2.0 if gait.moves == "x" else 3.0
        near = amplitude * (amount / reach) ** (1.0 / order)
        try:
            stroke = pure_stroke.realise_displacement(gait, self.swimmer, amount, near)
        except GaitError:
            return None
        return stroke if stroke.bend_rad() <= self.swimmer.max_bend_rad * _BEND_SLACK else None


def blocks_of(stroke: Stroke, cycles: int) -> list[Block]:
    """Return a number of cycles of a stroke as blocks of phase 2; the last cycle is one of its own."""
    parts = [(stroke.approach, 1), (stroke.cycle, cycles - 1), (stroke.cycle, 1), (stroke.approach.inverse(), 1)]
    return [Block(2, stroke.gait, s, n, stroke.amplitude_rad) for s, n in parts if len(s) and n]


def largest_stroke(gait: Gait, swimmer: Swimmer) -> Stroke:
    """Return the stroke of largest amplitude that is used.

    Raises:
        GaitError: No amplitude makes it pure.
    """
    amplitude = _ROLL_STEP_RAD if gait.amplitude_is_displacement else min(swimmer.max_bend_rad, _BEND_MAX_RAD)
    while True:
        try:
            stroke = pure_stroke.realise(gait, swimmer, amplitude, _ALMOST_PURE)
        except GaitError:
            if amplitude < _SMALLEST_RAD:
                raise
            amplitude *= 0.8
            continue
        bend = stroke.bend_rad()
        if bend <= swimmer.max_bend_rad * _BEND_SLACK:
            return stroke
        amplitude *= swimmer.max_bend_rad / bend


def unfit_gaits(gaits: Iterable[Gait], swimmer: Swimmer) -> dict[str, str]:
    """Return which gaits cannot be planned with, and why: for the motion they are said to make, they are not pure.

    Args:
        gaits: The gaits; those that move "none" are never planned with, and are none of these.
        swimmer: The swimmer.
    """
    unit, out = swimmer.scaled(), {}
    for gait in gaits:
        if gait.moves not in MOTIONS:
            continue
        try:
            why = pure_stroke.fault(largest_stroke(gait, unit), gait.moves, unit)
        except GaitError as error:
            why = str(error)
        if why:
            out[gait.name] = why
    return out


@functools.lru_cache(maxsize=64)
def stroke_book(gaits: tuple[Gait, ...], swimmer: Swimmer) -> StrokeBook:
    """Return the strokes of a scaled swimmer, made once for the same gaits."""
    return StrokeBook(gaits, swimmer)


def split(book: StrokeBook, displacement: Array) -> list[Motion]:
    """Return the cheapest motions found that make a body displacement, in the order they are made.

    Roll, which costs little, turns the way to go into the x-y plane; a yaw turns part of the way
    towards it; the rest is made along x and y, and a last roll, yaw, roll sets the orientation.
    How far to turn towards the way to go is searched, forwards and backwards.

    Args:
        book: The swimmer's strokes.
        displacement: Body displacement, in units of L. Shape (4, 4).
    """
    return [Motion(MOTIONS[along], amount) for along, amount in cheapest(displacement, *book.numbers)]


def gait_sequences(problem: Problem, breadth: Breadth, known: Sequence[Candidate] = ()) -> list[Candidate]:
    """Return motions by stored gaits one after the other, those that seem dear not yet made.

    Args:
        problem: The problem.
        breadth: How widely to search.
        known: The candidates that are known.

    Raises:
        GaitError: No stored gait for a motion that is needed, and no other candidate.
    """
    book, pairs = stroke_book(tuple(problem.gaits.values()), problem.swimmer), problem.pairs(breadth)
    least = min((c.estimate_rad for c in known if not c.astray), default=math.inf)
    found: list[Candidate] = []
    for k, displacement in enumerate(pairs.missing[:_PAIRS]):
        if found and found[0].estimate_rad > _DEAR * _DEAR * least:
            break
        motions = split(book, displacement)
        price = float(pairs.joint_travel_rad[k]) + sum(book.cost(m) for m in motions)
        later = functools.cache(functools.partial(_made, book, motions, pairs, k))
        if price > min(_DEAR * least, least + sum(book.cycle_rad(m) for m in motions)):
            found.append(Candidate(_WORDS, price, functools.partial(_made_if_any, later)))
            continue
        try:
            found.append(Candidate.of(_WORDS, later()))
        except GaitError:
            if known or found:
                continue
            raise
    return found


def _made(book: StrokeBook, motions: Sequence[Motion], pairs: LimbPairs, pair: int) -> tuple[Block, ...]:
    """Return motions as stored gaits, with the ways of a pair in and out."""
    return pairs.around(pair, [block for motion in motions for block in book.blocks(motion)])


def _made_if_any(make: Callable[[], tuple[Block, ...]]) -> tuple[Block, ...]:
    """Return strokes, or none where a gait does not go as far as is wanted."""
    try:
        return make()
    except GaitError:
        return ()
