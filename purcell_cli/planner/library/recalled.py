"""Short plans recalled from the library and brought to the goal."""

from __future__ import annotations

import functools

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.candidate import Breadth, Candidate
from purcell_cli.planner.library.plan_library import word_book
from purcell_cli.planner.library.random_plans import brought, word_of
from purcell_cli.planner.limbs.pairs import _Outer, _pairs
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD
from purcell_cli.planner.refine.minimum_travel import NAME, Pace, offered, shorten
from purcell_cli.planner.refine.shooting import Equations

_SHORTENED = 1.15
"""Words that are brought to their goal become so much shorter then, about."""


_TURN_PRICE, _WAY_PRICE = 374.0, 445.0
"""About the square of the joint travel of a small turn [rad^2 per rad] and a small way [rad^2 per L] by one word."""


def _worded(swimmer: Swimmer, outer: _Outer, wanted: Array, least: float, breadth: Breadth) -> list[Candidate]:
    """Return motions by words of the book, brought to the goal, that promise to be shorter than what is known.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        outer: The ways in and out.
        wanted: Body displacement of the whole. Shape (4, 4).
        least: The least joint travel known [rad].
        breadth: How widely to search.
    """
    pairs, missing = _pairs(outer, wanted, _by_word, breadth.pairs)
    around = np.array([outer.joint_travel_rad(i, j) for i, j in pairs])
    out: list[Candidate] = []
    for entry in word_book(swimmer).nearest(missing, around, breadth.words):
        if entry.estimate_rad > least:
            break
        each = se3.exp(se3.log(missing[entry.wanted]) / entry.laps)
        lap = Equations(swimmer, [word_of(offered(entry.lap, 1))], COLLINEAR, COLLINEAR, each, SEARCHING)
        near, off = brought(lap, swimmer.max_bend_rad - MARGIN_RAD)
        if off < CLOSE:
            make = functools.partial(_shortened, near, entry.laps, breadth.pace, outer, pairs[entry.wanted])
            travel = float(around[entry.wanted]) + entry.laps * near.joint_travel_rad / _SHORTENED
            out.append(Candidate("a word of the book", travel, make))
            least = min(least, travel)
    return out


def _shortened(lap: Equations, laps: int, pace: Pace, outer: _Outer, pair: tuple[int, int]) -> tuple[Block, ...]:
    """Return the strokes of a word that arrives, shortened, in as many laps."""
    lap = shorten(lap, lap.swimmer.max_bend_rad - MARGIN_RAD, pace)
    return outer.around(pair[0], [Block(2, NAME, lap.sequence.times(laps))], pair[1])


def _by_word(turn: Array, way: Array, _aside: Array) -> Array:
    """Return about the joint travel of a change of heading [rad] and a distance [L] by one word."""
    return np.asarray(np.sqrt(_TURN_PRICE * turn + _WAY_PRICE * way))
