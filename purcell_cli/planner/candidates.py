"""The search: which strokes, in which order, take the swimmer to its goal at the least cost.

Three choices are made together. How the limbs are straightened and bent again moves the base, so it
decides what is left for phase 2; the needle then says by which arcs and rolls that is made, and a
chain of loops makes it; and for short ways stored gaits one after the other may be shorter than
arcs. What comes out is almost a plan: it arrives but for a few per cent, and the finish does the rest.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from purcell_cli.errors import GaitError
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES, Block
from purcell_cli.planner.arcs.chain import Chains, linked
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.needle_steering import steer
from purcell_cli.planner.arcs.roll_stroke import Crank, crank
from purcell_cli.planner.gait_sequence import phase_two, stroke_book
from purcell_cli.planner.library.plan_library import word_book
from purcell_cli.planner.library.random_plans import brought, word_of
from purcell_cli.planner.limbs.shape_loops import Detours, detours
from purcell_cli.planner.limbs.straightening import DETOURS, Straightenings, interleaved, straightenings
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD
from purcell_cli.planner.refine.minimum_travel import NAME, Pace, offered, shorten
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.wording import counted

_CROSSED = 60
"""Ways to straighten and to bend that are carried on with to where their turns are put between one another."""
_TURNED = 10
"""Those that are carried on with to where detours are made before them."""
_ALIKE = 10
"""How many ways promise about the same, at most."""
_ASIDE, _FAR_ASIDE = 8.0, 1.2
"""A way aside takes turns there and back: 4 arcs of an angle f and a radius r go 4 r (1 - cos f) aside, so they turn
by (8 aside / r)^0.5 in all; and by no more than a way so far aside, in radii."""
_WEIGHED = 24
"""How many of the needle's ways are weighed as loops."""
_SHORT_RAD = 60.0
"""Up to this joint travel stored gaits one after the other are tried too."""
_SLIGHT_RAD, _SAME = 0.3, 1e-4
"""Arcs of less joint travel are left out; neighbours are one if that costs them no more than so much."""
_FAR_OFF = 0.02
"""Chains that miss by more, as `chain.missed` has it, are astray."""

Price = Callable[[Array, Array, Array], Array]
"""What phase 2 costs, about [rad]: of a change of heading [rad], a distance [L] and how much of it goes aside [L]."""

_SHORTENED = 1.15
"""Words that are brought to their goal become so much shorter then, about."""
_TURN_PRICE, _WAY_PRICE = 374.0, 445.0
"""About the square of the joint travel of a small turn [rad^2 per rad] and a small way [rad^2 per L] by one word."""


@dataclasses.dataclass(frozen=True, slots=True)
class Breadth:
    """How widely to search.

    Attributes:
        orders: Pairs of limbs' ways whose turns are put between one another, at the start and at the goal each.
        pairs: Pairs of ways to straighten and to bend that are steered for.
        starts: Starts of the needle, for all pairs together.
        chains: How many of the needle's ways are settled as chains of loops.
        rounds: Rounds in which they settle.
        shorter: Rounds in which every chain tries to do with one cycle fewer of one of its loops.
        words: How many of the word book's entries are tried for short ways.
        pace: How long those that arrive are shortened.
    """

    orders: int = 10
    pairs: int = 12
    starts: int = 96
    chains: int = 4
    rounds: int = 5
    shorter: int = 2
    words: int = 6
    pace: Pace = Pace(rounds=2, steps=10)


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """A motion that almost arrives.

    Attributes:
        words: What it is made of.
        estimate_rad: About its joint travel, or what it spends in the same units [rad].
        make: Makes its strokes.
        astray: Whether it misses by so much that it may not arrive.
    """

    words: str
    estimate_rad: float
    make: Callable[[], tuple[Block, ...]]
    astray: bool = False

    @functools.cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Its strokes."""
        return self.make()

    @property
    def joint_travel_rad(self) -> float:
        """Its joint travel, as estimated as long as its strokes are not made [rad]."""
        made = "blocks" in self.__dict__
        return sum(b.joint_travel_rad for b in self.blocks) if made else self.estimate_rad

    def rank(self, measure: str, swimmer: Swimmer, start: Array) -> tuple[bool, float]:
        """Return what to sort by: whether it is astray, and what it spends from a start shape (`measures.costs`)."""
        spent = self.estimate_rad if measure == "travel" else cost(measure, swimmer, self.blocks, start)
        return self.astray, float(f"{spent:.9e}")


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


def _gone_round(outer: _Outer, round_: Sequence[Detours], wanted: Array, price: Price) -> _Outer:
    """Return the ways in and out that promise most with detours before them, if there are any.

    Args:
        outer: The ways in and out.
        round_: The detours round the start's and round the goal's shape.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
    """
    if not any(len(some.sequence) for some in round_):
        return outer
    few = outer.best(wanted, price, _TURNED)
    for k in range(DETOURS):
        most = _CROSSED if k == DETOURS - 1 else _TURNED
        first = _Outer(round_[0].before(few.first), few.last).best(wanted, price, most).first
        last = _Outer(first, round_[1].before(few.last)).best(wanted, price, most).last
        few = _Outer(first, last)
    return few


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


def _tightness(fan: Fan) -> float:
    return fan.tight


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Outer:
    """The ways to straighten the limbs of the start and of the goal: phases 1 and 3."""

    first: Straightenings
    last: Straightenings

    def promised(self, wanted: Array, price: Price) -> tuple[Array, Array]:
        """Return what is left when the limbs are straight, and the joint travel that pairs of ways promise [rad].

        Args:
            wanted: Body displacement of the whole. Shape (4, 4).
            price: What phase 2 costs, about.

        Returns:
            Displacements, shape (n, 4, 4), and joint travel, shape (n, m).
        """
        gone = se3.inverse(self.first.displacement) @ wanted
        done = self.last.displacement  # phase 3 is played backwards, so this is what undoes it
        heading = np.clip(gone[:, 0, :3] @ done[:, :3, 0].T, -1.0, 1.0)
        between = gone[:, :3, :3].reshape(-1, 3) @ done[:, :3, 3].T
        position = between.reshape(len(gone), 3, len(done)) + gone[:, :3, 3:]
        distance = np.sqrt(np.einsum("iaj,iaj->ij", position, position))
        aside = np.sqrt(np.einsum("iaj,iaj->ij", position[:, 1:], position[:, 1:]))
        limbs = self.first.joint_travel_rad[:, None] + self.last.joint_travel_rad
        return gone, price(np.arccos(heading), distance, aside) + limbs

    def best(self, wanted: Array, price: Price, most: int) -> _Outer:
        """Return the ways that promise most, at the start and at the goal, the best first (see `promised`)."""
        promised = self.promised(wanted, price)[1]
        order = (np.argsort(np.round(promised.min(axis=axis, initial=np.inf), 9), kind="stable") for axis in (1, 0))
        return _Outer(*(ways[row[:most]] for ways, row in zip((self.first, self.last), order, strict=True)))

    def joint_travel_rad(self, i: int, j: int) -> float:
        return float(self.first.joint_travel_rad[i] + self.last.joint_travel_rad[j])

    def around(self, i: int, inner: Sequence[Block], j: int) -> tuple[Block, ...]:
        """Return the strokes of a phase 2 with ways in and out."""
        before, after = self.first.sequence(i), self.last.sequence(j).inverse()
        return (
            *([Block(1, PHASES[1], before)] if len(before) else []),
            *inner,
            *([Block(3, PHASES[3], after)] if len(after) else []),
        )


def _steered(
    fans: tuple[Fan, ...],
    turning: Crank,
    outer: _Outer,
    pairs: list[tuple[int, int]],
    missing: Array,
    breadth: Breadth,
) -> list[Candidate]:
    """Return motions by arcs with rolls between, for pairs of ways in and out and what they leave."""
    steering = max(fans, key=_tightness)
    limbs = np.array([outer.joint_travel_rad(i, j) for i, j in pairs])
    way = steer(missing, steering, math.ceil(breadth.starts / len(pairs)))
    around = limbs[way.displacement]
    travel = steering.cost(way.arc[..., 0], np.hypot(way.arc[..., 1], way.arc[..., 2])).sum(axis=1) + around
    picked = np.array(_distinct(travel), dtype=np.int64)
    arcs = [_swum(steering, _fewest(steering, way.arc[k])) for k in picked]
    # The cheapest loops at every arc; and, since only those go exactly straight, loops that are bent in the plane.
    only = np.repeat([-1, fans.index(next(f for f in fans if not f.loops.across))], len(picked))
    picked = np.concatenate([picked, picked])
    chains = linked(turning, fans, arcs + arcs, way.roll[picked], only)
    order = np.argsort(np.round(chains.costs()[0] + around[picked], 9), kind="stable")
    plane = order[only[order] >= 0][:1]
    best = np.concatenate([order[only[order] < 0][: max(breadth.chains - 1, 1)], plane])
    picked, chains = picked[best], chains[best]
    wanted = missing[way.displacement[picked]]
    chains, off, spent = _settled(chains, wanted, around[picked], breadth)
    out = []
    for n in range(len(chains)):
        if not chains.idle(n):
            count, pair = chains.arcs(n), pairs[way.displacement[picked[n]]]
            words = f"{counted(count, 'arc')} with rolls between"
            make = functools.partial(_played, chains, n, outer, pair)
            out.append(Candidate(words, float(spent[n]), make, bool(off[n] > _FAR_OFF)))
    return out


def _settled(chains: Chains, wanted: Array, around: Array, breadth: Breadth) -> tuple[Chains, Array, Array]:
    """Return chains settled on displacements, with as many cycles as they need.

    Args:
        chains: The chains.
        wanted: The displacements. Shape (n, 4, 4).
        around: What is spent before and after them [rad]. Shape (n,).
        breadth: How widely to search.

    Returns:
        The chains, what they miss by (`chain.missed`), shape (n,), and what is spent in all, shape (n,).
    """
    chains, off, spent = chains.settled(wanted, breadth.rounds)
    spent = spent + around
    least = np.min(spent[off <= _FAR_OFF], initial=np.inf)
    promised = spent + chains.short(wanted) / max(f.straight for f in chains.fans)
    if len(few := np.flatnonzero((off > _FAR_OFF) & (promised < least))):
        more, left, paid = chains[few].longer(wanted[few]).settled(wanted[few], breadth.rounds)
        gained = np.flatnonzero(left < off[few])
        few = few[gained]
        chains, off[few], spent[few] = chains.put(few, more[gained]), left[gained], paid[gained] + around[few]
    few = np.argsort(np.round(spent, 9), kind="stable")[: math.ceil(0.5 * len(chains))]
    for _ in range(breadth.shorter):
        fewer, owner = chains[few].shorter()
        owner = few[owner]
        fewer, left, paid = fewer.settled(wanted[owner], breadth.rounds)
        paid = paid + around[owner]
        gain = np.where(left <= _FAR_OFF, spent[owner] - paid, -np.inf)
        order = np.lexsort((-np.round(gain, 9), owner))
        best = order[np.unique(owner[order], return_index=True)[1]]  # of each chain's
        best = best[gain[best] > 0.0]
        few = owner[best]
        if not len(few):
            break
        chains, off[few], spent[few] = chains.put(few, fewer[best]), left[best], paid[best]
    return chains, off, spent


def _played(chains: Chains, k: int, outer: _Outer, pair: tuple[int, int]) -> tuple[Block, ...]:
    """Return the strokes of one of the chains, with its ways in and out."""
    return outer.around(pair[0], _last_apart(chains.blocks(k)), pair[1])


def _distinct(travel: Array) -> list[int]:
    """Return the ways of least joint travel, each a little different from the one before."""
    out: list[int] = []
    for k in np.argsort(travel, kind="stable").tolist():
        if not out or travel[k] > travel[out[-1]] + 0.01:
            out.append(k)
        if len(out) == _WEIGHED:
            break
    return out


def _pairs(outer: _Outer, wanted: Array, price: Price, most: int) -> tuple[list[tuple[int, int]], Array]:
    """Return the pairs of ways in and out that promise the least joint travel, and what they leave to be made.

    Args:
        outer: The ways in and out.
        wanted: Body displacement of the whole. Shape (4, 4).
        price: What phase 2 costs, about.
        most: How many.
    """
    gone, promised = outer.promised(wanted, price)
    count = min(_ALIKE * most, promised.size)
    few = np.flatnonzero(promised <= np.partition(promised, count - 1, axis=None)[count - 1])
    # Ways that differ by how a limb rolls promise the same; the first of them will do.
    _, first = np.unique(np.round(promised.ravel()[few], 1), return_index=True)
    best = few[first[:most]]
    pairs = [(int(k // promised.shape[1]), int(k % promised.shape[1])) for k in best]
    return pairs, se3.normalised(np.stack([gone[i] @ outer.last.displacement[j] for i, j in pairs]))


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


def _last_apart(blocks: list[Block]) -> list[Block]:
    """Return blocks with the last cycle of all that repeat on its own: it takes up what the others leave."""
    repeated = [k for k, b in enumerate(blocks) if b.cycles > 1]
    if not repeated:
        return blocks
    k = repeated[-1]
    fewer, one = (dataclasses.replace(blocks[k], cycles=n) for n in (blocks[k].cycles - 1, 1))
    return [*blocks[:k], fewer, one, *blocks[k + 1 :]]
