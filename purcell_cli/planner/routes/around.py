"""Plans round obstacles: exact legs along the cheapest path of a roadmap whose legs touch nothing.

Anytime by counts, not by the clock: the same query gives the same plan on every computer.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.joint_motion import home_shape, plane_axis
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Blocked, Plan, Structure
from purcell_cli.planner.progress import Progress
from purcell_cli.planner.routes.closed_off import refuse_closed_off, too_narrow
from purcell_cli.planner.routes.one_motion import ended, one_motion
from purcell_cli.planner.routes.poses import Region
from purcell_cli.planner.routes.roadmap import GOAL, START, Roadmap
from purcell_cli.planner.routes.swing import swings
from purcell_cli.planner.routes.walls import with_walls
from purcell_cli.wording import counted

LegPlanner = Callable[[Configuration, Configuration, float], Plan]
"""Plans a leg between configurations whose strokes keep a bend limit [rad]."""

SHORTER = {"quick": 0, "standard": 4, "thorough": 60}
"""How often a way that is found is made shorter, by effort."""
_ROUNDS = 6
"""How often a roadmap grows, at most."""
_LEAST_ROUNDS = 2
"""How often it grows before its path is made cheaper."""
_POSES = 40
"""By how many poses it grows each time: some 400 edges, in some tenths of a second."""
_LEGS = 120
"""Legs that are planned at most, of some 0.2 s each."""
_SPREADS = (2.0, 0.4, 1.0, 0.25)
"""How far from the path poses are tried that may make it cheaper, one round after the other [L]; they turn as far."""
NEAR_PATH = {"quick": 4, "standard": 24, "thorough": 80}
"""Rounds, at most, in which poses near the path make it cheaper before legs are planned, by effort: prices are right to
some 5 %, and a round takes less time than a leg."""
STARTS = {"quick": 1, "standard": 6, "thorough": 16}
"""How many roadmaps are begun, at most, by effort: what is not cheaper step by step may be so from elsewhere."""
_IDLE, _LESS = 8, 0.99
"""The rounds end where so many in a row have not brought the path's price below this part of the best before."""
_GAIN = 0.985
"""A way is looked for again where one is priced at less than this part of the one that is known."""
_LEGS_A_ROUND = 2
"""Legs that are planned at most for each round in which a way is made shorter."""
_DEARER = 1.08
"""Where a leg takes so many times its price, another path may be the cheapest."""
_ARRIVES = 1e-8
"""A leg that misses its end by less than this arrives; the next leg begins where it ends [L, rad]."""


@frozen_dataclass(eq=False)
class _Query:
    """What is asked for, and how legs are planned.

    Attributes:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        limits: What every leg keeps.
        leg: Plans a leg.
    """

    swimmer: Swimmer
    start: Configuration
    goal: Configuration
    limits: Limits
    leg: LegPlanner


def around(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    limits: Limits,
    leg: LegPlanner,
    seed: int,
    effort: str,
    progress: Progress,
) -> Plan | Blocked:
    """Return a plan round obstacles, or what is in the way where none is found.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        limits: What the plan must keep, obstacles among it.
        leg: Plans a leg.
        seed: Seed of the roadmap's poses.
        effort: How long to look for a shorter way: one of `SHORTER`.
        progress: Is told how far the search is.

    Raises:
        ParameterError: No obstacles, or a goal that is shown to be out of reach.
    """
    if limits.obstacles is None:
        raise ParameterError("obstacles: one or more to go round are wanted, found none")
    refuse_closed_off(swimmer, limits.obstacles, limits.clearance_m, start, goal)
    scene = with_walls(limits.obstacles, limits.workspace)
    axis = plane_axis(swimmer)
    region = Region.of(scene, swings(swimmer), swimmer.length_m, limits.clearance_m, start.pose, goal.pose, axis)
    region = dataclasses.replace(region, walls=len(scene.obstacles) - len(limits.obstacles.obstacles))
    rng = np.random.default_rng(seed)
    roadmap, starts = Roadmap(region, start.pose, goal.pose), STARTS[effort]
    least = region.swings[-1]
    room_m = least.radius * swimmer.length_m + limits.clearance_m
    if too_narrow(limits.obstacles, room_m, start.pose, goal.pose):
        blocked = roadmap.blocked()
        words = (
            f"the tubes have a place narrower than the {2.0 * room_m:.3g} m that the smallest strokes looked for need, "
            f"of limbs bent by {least.bend_rad:.3g} rad, which is no proof that none would do; {blocked.words}"
        )
        return dataclasses.replace(blocked, words=words)
    for k in range(starts):
        if roadmap.good:
            break
        progress(k, starts, f"ways round obstacles from start {k + 1} on")
        other = Roadmap(region, start.pose, goal.pose)
        for _ in range(_LEAST_ROUNDS):
            other.grow(rng, _POSES)
        _cheaper(other, rng, NEAR_PATH[effort])
        roadmap = min(roadmap, other, key=lambda one: one.least_rad)
    search = _Search(_Query(swimmer, start, goal, limits, leg), roadmap)
    for k in range(_LEAST_ROUNDS, _ROUNDS + 1):
        if k > _LEAST_ROUNDS:
            roadmap.grow(rng, _POSES)
            _cheaper(roadmap, rng, NEAR_PATH[effort])
        progress(k, _ROUNDS, f"a way round obstacles: {len(roadmap.poses)} poses, {len(roadmap.edges)} edges")
        found = search.explored()
        if found is not None:
            return _shorter(search, rng, found, SHORTER[effort], progress)
        if search.spent >= _LEGS:
            break
    return roadmap.blocked()


def _cheaper(roadmap: Roadmap, rng: np.random.Generator, rounds: int) -> None:
    """Add poses near the cheapest path until they hardly make it cheaper."""
    idle, best = 0, np.inf
    for k in range(rounds):
        roadmap.grow_near_path(rng, _SPREADS[k % len(_SPREADS)])
        price = roadmap.least_rad
        idle, best = (0, price) if price < _LESS * best else (idle + 1, best)
        if idle >= _IDLE or price == np.inf:
            return


def _shorter(search: _Search, rng: np.random.Generator, found: Plan, rounds: int, progress: Progress) -> Plan:
    """Return a plan made shorter: poses near its path are tried, and its legs put together."""
    roadmap, spent = search.roadmap, search.spent
    for k in range(rounds):
        left = spent + rounds * _LEGS_A_ROUND - search.spent
        if left <= 0:
            break
        progress(k, rounds, f"a shorter way round obstacles than {found.joint_travel_rad:.0f} rad")
        if k % 2:
            roadmap.grow(rng, _POSES)
        roadmap.grow_near_path(rng, _SPREADS[k % len(_SPREADS)])
        better = search.explored(_GAIN * found.joint_travel_rad / search.dearer, left)
        if better is not None and better.joint_travel_rad < found.joint_travel_rad:
            found = better
    return found


class _Search:
    """The search for a path of a roadmap whose exact legs touch nothing.

    Attributes:
        spent: How many legs have been planned.

    Args:
        query: What is asked for.
        roadmap: The roadmap.
    """

    def __init__(self, query: _Query, roadmap: Roadmap) -> None:
        self.query, self.roadmap, self.spent = query, roadmap, 0
        self._known: dict[tuple[int, int], list[Plan]] = {}
        self._priced, self._made = 0.0, 0.0

    @property
    def dearer(self) -> float:
        """How many times their price exact legs have taken so far, 1 at least."""
        return max(self._made / self._priced, 1.0) if self._priced > 0.0 else 1.0

    def explored(self, below_rad: float = np.inf, most: int = _LEGS) -> Plan | None:
        """Return a plan along the cheapest path whose legs touch nothing; None where the roadmap has none.

        Args:
            below_rad: Paths that are priced at more are not looked at [rad].
            most: How many legs are planned at most.
        """
        last = min(self.spent + most, _LEGS)
        while self.spent < last and (path := self.roadmap.path()) is not None:
            if self.roadmap.price(path) >= below_rad:
                return None
            pairs = list(itertools.pairwise(path))
            for pair in pairs:
                if pair not in self._known:
                    legs = self._exact(pair)
                    if legs is None:
                        self.roadmap.bar(pair)
                        break
                    self._known[pair] = legs
                    travel = sum(leg.joint_travel_rad for leg in legs)
                    priced = self.roadmap.edge(*pair).price
                    self._priced, self._made = self._priced + priced, self._made + travel
                    self.roadmap.reprice(pair, travel)
                    if travel > _DEARER * priced:
                        break
            else:
                last_bend = self.roadmap.edge(*pairs[-1]).bend_rad
                made = self._played([plan for pair in pairs for plan in self._known[pair]], last_bend)
                if made is not None:
                    return made
                self.roadmap.bar(pairs[-1])
        return None

    def _exact(self, pair: tuple[int, int]) -> list[Plan] | None:
        """Return exact legs along an edge that touch nothing: one for all of it, or else one for each of its arcs."""
        edge = self.roadmap.edge(*pair)
        begin, end = (self._at(k) for k in pair)
        for between in ([], list(edge.poses))[: 1 + bool(len(edge.poses))]:
            legs = self._legs([begin, *(self._collinear(pose) for pose in between), end], edge.bend_rad)
            if legs is not None:
                return legs
        return None

    def _legs(self, stops: list[Configuration], bend_rad: float, within: float = _ARRIVES) -> list[Plan] | None:
        """Return exact legs from stop to stop, each within so much of its end [L, rad]; None if one cannot be had."""
        out: list[Plan] = []
        here = stops[0]
        for there in stops[1:]:
            self.spent += 1
            plan = self.query.leg(here, there, bend_rad)
            end = ended(plan)
            if plan.limits is None and plan.blocks:
                return None
            if (plan.limits is not None and not plan.limits.kept) or not self._arrives(end, there, within):
                return None
            out.append(plan)
            here = Configuration(end.pose, there.shape)  # to rounding: the next leg need not straighten what is no bend
        return out

    def _arrives(self, end: Configuration, there: Configuration, within: float) -> bool:
        return Deviation.between(end, there).within(within * self.query.swimmer.length_m, within)

    def _played(self, legs: list[Plan], bend_rad: float) -> Plan | None:
        """Return legs one after the other as one plan, the last one brought to the goal from where those before end."""
        query = self.query
        blocks = one_motion(
            query.swimmer, query.start, query.goal, [leg.blocks for leg in legs], bend_rad, query.limits
        )
        if blocks is None:
            return None
        whole = tuple(_in_phase([*blocks]))
        words = f"a way round obstacles in {counted(len(legs), 'leg')}"
        structure = Structure(words, sum(b.joint_travel_rad for b in whole))
        return Plan(query.swimmer, query.start, query.goal, whole, (structure,))

    def _at(self, k: int) -> Configuration:
        if k == START:
            return self.query.start
        return self.query.goal if k == GOAL else self._collinear(self.roadmap.poses[k])

    def _collinear(self, pose: Array) -> Configuration:
        return Configuration(se3.normalised(pose), home_shape(self.query.swimmer, self.query.start.shape))


def _in_phase(blocks: list[Block]) -> list[Block]:
    """Return blocks in phases that only rise: between the first and the last collinear shape all is phase 2."""
    inner = [k for k, b in enumerate(blocks) if b.phase == 2]
    if not inner:
        return blocks
    first, last = inner[0], inner[-1]
    return [b if not first < k < last else dataclasses.replace(b, phase=2) for k, b in enumerate(blocks)]
