"""The search: which strokes, in which order, take the swimmer to its goal at the least cost.

Three choices are made together. How the limbs are straightened and bent again moves the base, so it
decides what is left for phase 2; the needle then says by which arcs and rolls that is made, and a
chain of loops makes it; and for short ways stored gaits one after the other may be shorter than
arcs. What comes out is almost a plan: it arrives but for a few per cent, and the finish does the rest.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

import numpy as np

from purcell_cli.errors import GaitError
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.loop_family import fan
from purcell_cli.planner.arcs.roll_stroke import crank
from purcell_cli.planner.arcs.steered import _steered, _tightness
from purcell_cli.planner.candidate import Breadth, Candidate
from purcell_cli.planner.gait_sequence import phase_two, stroke_book
from purcell_cli.planner.library.recalled import _worded
from purcell_cli.planner.limbs.interleaving import interleaved
from purcell_cli.planner.limbs.pairs import _CROSSED, _gone_round, _Outer, _pairs
from purcell_cli.planner.limbs.shape_loops import detours
from purcell_cli.planner.limbs.straightening import straightenings

_ASIDE, _FAR_ASIDE = 8.0, 1.2
"""A way aside takes turns there and back: 4 arcs of an angle f and a radius r go 4 r (1 - cos f) aside, so they turn
by (8 aside / r)^0.5 in all; and by no more than a way so far aside, in radii."""
_SHORT_RAD = 60.0
"""Up to this joint travel stored gaits one after the other are tried too."""


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
    found: list[Candidate] = []
    rolling = [g for g in gaits.values() if g.moves == "roll" and g.amplitude_is_displacement]
    fans = tuple(fan(swimmer, measure, across) for across in (True, False))
    loops = max(fans, key=_tightness)

    def price(turn: Array, way: Array, aside: Array) -> Array:
        radii = np.minimum(aside * loops.tight / loops.straight, _FAR_ASIDE)
        return np.sqrt(turn**2 + _ASIDE * radii) / loops.tight + way / loops.straight

    shapes = start, goal
    every = _Outer(*straightenings(swimmer, shapes, clearance))
    few = every.best(wanted, price, _CROSSED)
    outer = _Outer(*interleaved(swimmer, shapes, (few.first, few.last), breadth.orders, clearance))
    outer = _gone_round(outer, detours(swimmer, shapes, clearance), wanted, price)
    pairs, missing = _pairs(outer, wanted, price, breadth.pairs)
    if rolling:
        found += _steered(fans, crank(rolling[0], swimmer), outer, pairs, missing, breadth)
    if not found or min(c.joint_travel_rad for c in found) < _SHORT_RAD:
        book = stroke_book(tuple(gaits.values()), swimmer)
        for (i, j), displacement in list(zip(pairs, missing, strict=True))[:2]:
            try:
                inner = phase_two(book, displacement)
            except GaitError:
                if found:
                    continue
                raise
            blocks = outer.around(i, inner, j)
            travel = sum(b.joint_travel_rad for b in blocks)
            found.append(Candidate("stored gaits one after the other", travel, functools.partial(tuple, blocks)))
        least = min((c.joint_travel_rad for c in found if not c.astray), default=math.inf)
        found += _worded(swimmer, every, wanted, least, breadth)
    return sorted(found, key=lambda c: c.rank(measure, swimmer, start))
