"""Candidates by arcs with rolls between: needle steering chooses the arcs, and chains of loops swim them."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import hypot, hypot_of, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.chains import RollTable
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.arc_price import tightest
from purcell_cli.planner.arcs.chain import Chains, linked
from purcell_cli.planner.arcs.loop_family import Fan
from purcell_cli.planner.arcs.needle_steering import steer
from purcell_cli.planner.arcs.roll_stroke import roll_stroke, rolling
from purcell_cli.planner.arcs.settling import FAR_OFF, settled
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.limbs.pairs import LimbPairs
from purcell_cli.planner.problem import Problem
from purcell_cli.wording import counted

_WEIGHED = 24
"""The most steered solutions that are priced as chains of loops."""
_SLIGHT_RAD = 0.3
"""Arcs of less joint travel than this are left out [rad]."""
_SAME = 1e-4
"""Neighbouring arcs become one if their separate cost is at most this part above the cost of the one."""


def steered_arcs(problem: Problem, breadth: Breadth, known: Sequence[Candidate] = ()) -> list[Candidate]:
    """Return motions by arcs with rolls between; none where no stored gait rolls by its amplitude.

    Where what is known takes far less than arcs promise, they are one candidate that is not yet made.

    Args:
        problem: The problem.
        breadth: How widely to search.
        known: The candidates that are known.
    """
    if problem.objective == "travel" and known and rolling(problem.gaits):
        promised = problem.promised(breadth)
        if min((c.estimate_rad for c in known if not c.astray), default=math.inf) < breadth.arcs_from * promised:
            return [Candidate("arcs with rolls between", promised, functools.partial(_steered_later, problem, breadth))]
    return _steered(problem, breadth)


def _steered_later(problem: Problem, breadth: Breadth) -> tuple[Block, ...]:
    """Return the strokes of the best motion by arcs, or none."""
    found = sorted(_steered(problem, breadth), key=lambda c: (c.astray, c.estimate_rad))
    return found[0].make() if found else ()


def _steered(problem: Problem, breadth: Breadth) -> list[Candidate]:
    """Return motions by arcs with rolls between; none where no stored gait rolls by its amplitude."""
    if not (rolled := rolling(problem.gaits)):
        return []
    fans, steering, pairs = problem.fans, tightest(problem.fans), problem.pairs(breadth)
    way = steer(_seen_at(steering.centre, pairs.missing), steering, math.ceil(breadth.starts / len(pairs)))
    around = pairs.joint_travel_rad[way.displacement]
    each = steering.cost(way.arc[..., 0], hypot(way.arc[..., 1], way.arc[..., 2]))
    travel = each.sum(axis=1) + around
    picked = np.array(_distinct(travel), dtype=np.int64)
    arcs = [_swum(steering, _fewest(steering, way.arc[k], each[k])) for k in picked]
    # The cheapest loops at every arc; and, since only those go exactly straight, loops that are bent in the plane.
    only = np.repeat([-1, fans.index(next(f for f in fans if not f.loops.across))], len(picked))
    picked = np.concatenate([picked, picked])
    chains = linked(roll_stroke(rolled[0], problem.swimmer), fans, arcs + arcs, way.roll[picked], only)
    order = np.argsort(np.round(chains.costs()[0] + around[picked], 9), kind="stable")
    plane = order[only[order] >= 0][:1]
    best = np.concatenate([order[only[order] < 0][: max(breadth.chains - 1, 1)], plane])
    picked, chains = picked[best], chains[best]
    wanted = pairs.missing[way.displacement[picked]]
    found, of = settled(chains, wanted, around[picked], breadth)
    chains, spent, picked = found.chains, found.spent.tolist(), picked[of]
    out = []
    for n in range(len(chains)):
        if not chains.idle(n):
            words = f"{counted(chains.arcs(n), 'arc')} with rolls between"
            make = functools.partial(_played, chains, n, pairs, int(way.displacement[picked[n]]))
            out.append(Candidate(words, spent[n], make, bool(found.off[n] > FAR_OFF)))
    return out


def arcs_in_plane(loops: Fan, wanted: Array, breadth: Breadth) -> list[Candidate]:
    """Return motions by arcs that stay in the x-y plane, from the collinear shape and back to it.

    Args:
        loops: The swimmer's loops, bent aside in the plane.
        wanted: The displacement, in that plane. Shape (4, 4).
        breadth: How widely to search.
    """
    way = steer(_seen_at(loops.centre, wanted[None]), loops, breadth.starts, plane="yaw")
    each = loops.cost(way.arc[..., 0], np.abs(way.arc[..., 2]))
    arcs = [_swum(loops, _fewest(loops, way.arc[k], each[k])) for k in _distinct(each.sum(axis=1))]
    chains = linked(_NoRolls(), (loops,), arcs, np.zeros(len(arcs)), np.zeros(len(arcs), dtype=np.int64))
    chains = chains[np.argsort(np.round(chains.costs()[0], 9), kind="stable")[: breadth.chains]]
    n = len(chains)
    if not n:
        return []
    found, _ = settled(chains, np.repeat(wanted[None], n, axis=0), np.zeros(n), breadth)
    chains = found.chains
    return [
        Candidate(
            counted(chains.arcs(k), "arc"),
            float(found.spent[k]),
            functools.partial(_blocks_of, chains, k),
            bool(found.off[k] > FAR_OFF),
        )
        for k in range(len(chains))
        if not chains.idle(k)
    ]


def _blocks_of(chains: Chains, k: int) -> tuple[Block, ...]:
    return tuple(_last_apart(chains.blocks(k)))


class _NoRolls:
    """What rolls where nothing can."""

    table = RollTable(np.array([0.0, np.pi]), np.zeros(2), 4.0)

    def blocks(self, angle: float) -> list[Block]:
        del angle
        return []


def _seen_at(centre: float, displacements: Array) -> Array:
    """Return the displacements of the point (centre, 0, 0) of the base that displacements of its middle make.

    Where limbs are not alike, that point swims along circles, by which arcs are steered.
    """
    if not centre:
        return displacements
    shift = np.eye(4)
    shift[0, 3] = centre
    return matmul(matmul(se3.inverse(shift), displacements), shift)


def _played(chains: Chains, k: int, pairs: LimbPairs, pair: int) -> tuple[Block, ...]:
    """Return the strokes of one of the chains, with its ways in and out."""
    return pairs.around(pair, _last_apart(chains.blocks(k)))


def _distinct(travel: Array) -> list[int]:
    """Return the ways of least joint travel, each a little different from the one before."""
    out: list[int] = []
    for k in np.argsort(travel, kind="stable").tolist():
        if not out or travel[k] > travel[out[-1]] + 0.01:
            out.append(k)
        if len(out) == _WEIGHED:
            break
    return out


def _fewest(loops: Fan, arc: Array, travel: Array) -> Array:
    """Return arcs without slight ones, neighbours of one direction made one. Shapes (n, 3) and (n,) to (m, 3)."""
    out: list[Array] = []
    last = 0.0
    for one, own in zip(arc, travel.tolist(), strict=True):
        if own < _SLIGHT_RAD:
            continue
        both = _cost(loops, out[-1] + one) if out else 0.0
        if out and last + own < (1.0 + _SAME) * both:
            out[-1], last = out[-1] + one, both
        else:
            out.append(one)
            last = own
    return np.array(out).reshape(-1, 3)


def _swum(loops: Fan, arc: Array) -> Array:
    """Return arcs as loops can swim them, those that are too tight in parts. Shape (n, 3)."""
    parts = []
    for advance, p, q in arc.tolist():
        turn = hypot_of(p, q)
        across = (p / turn, q / turn) if turn > 0.0 else (0.0, 1.0)
        parts += [(a, b * across[0], b * across[1]) for a, b in loops.ways(advance, turn)]
    return np.array(parts).reshape(-1, 3)


def _cost(loops: Fan, arc: Array) -> float:
    return float(loops.cost(arc[0], hypot(arc[1], arc[2])))


def _last_apart(blocks: list[Block]) -> list[Block]:
    """Return blocks with the last cycle of all that repeat on its own: it takes up what the others leave."""
    repeated = [k for k, b in enumerate(blocks) if b.cycles > 1]
    if not repeated:
        return blocks
    k = repeated[-1]
    fewer, one = (dataclasses.replace(blocks[k], cycles=n) for n in (blocks[k].cycles - 1, 1))
    return [*blocks[:k], fewer, one, *blocks[k + 1 :]]
