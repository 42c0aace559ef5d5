"""A roadmap: poses that are clear of obstacles, edges between near ones, and the cheapest path from start to goal.

Probabilistic roadmaps: Kavraki, Svestka, Latombe and Overmars (1996), IEEE Trans. Robotics Automation 12, 566. The
exact legs are dear and made only for edges of the path that seems cheapest (LazySP: Dellin and Srinivasa, 2016). A
library of sampling planners (OMPL) steers by functions of its own and knows neither arcs nor their exact legs; what it
would leave to be done here is what this room holds.
"""

from __future__ import annotations

import dataclasses
import heapq
import itertools

import numpy as np

from purcell_cli.environment.scene import Scene
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.plan import Blocked
from purcell_cli.planner.arcs.arc_price import ArcPrice
from purcell_cli.planner.routes.edges import Edge, clear_edges
from purcell_cli.planner.routes.poses import Region

START, GOAL = 0, 1
"""The first two poses of a roadmap."""

_NEAREST = 8
"""To how many others, by price, a pose gets edges."""

_NEAR, _TRIED = 24, 8
"""Near each place of a path so many poses are drawn. Of those that promise something so many get edges: half of them
the most promising, which obstacles may bar, and half from among all others."""

_SLACK = 1.3
"""Poses are tried by which the way, roughly priced, costs up to so many times what it does now."""

_HARDLY = 1.08
"""A path of less than so many times the price through empty water is taken at once; others wait until the roadmap has
grown."""


class Roadmap:
    """Poses and the edges between them.

    Attributes:
        region: Where the poses are.
        poses: The poses; the first two are the start's and the goal's [m]. Shape (n, 4, 4).
        edges: The edges that are clear, by the indices of their ends, the less one first.

    Args:
        region: Where the poses are.
        start: The pose at the start [m]. Shape (4, 4).
        goal: The pose at the goal [m]. Shape (4, 4).
    """

    def __init__(self, region: Region, start: Array, goal: Array) -> None:
        self.region = region
        self.poses = np.stack([start, goal])
        self.edges: dict[tuple[int, int], Edge] = {}
        self._level: dict[tuple[int, int], int] = {}
        self._widest = np.empty(0, dtype=np.int64)
        self._cheapest: list[int] | None = None
        self._changed = True
        self._prices = [ArcPrice(swing.loops) for swing in region.swings]
        through_empty_water = self._clear(None, 0, start[None], goal[None])[0]
        self._empty_rad = 0.0 if through_empty_water is None else through_empty_water.price
        self._join([(START, GOAL)], 0)

    def grow(self, rng: np.random.Generator, count: int) -> None:
        """Add poses, and edges between them and those that are near.

        Args:
            rng: Draws them.
            count: About how many.
        """
        before = len(self.poses)
        drawn = self.region.drawn(rng, count, self.poses[:2])
        if (path := self.path()) is not None:
            worth = self._rough_prices(self.poses[:1], drawn)[0] + self._rough_prices(drawn, self.poses[1:2])[:, 0]
            drawn = drawn[worth < _SLACK * self.price(path)]
        self.poses = np.concatenate([self.poses, drawn])
        n = len(self.poses)
        if n == before:
            return
        price = self._rough_prices(self.poses, self.poses)
        np.fill_diagonal(price, np.inf)
        pairs = set()
        for k in range(n):
            few = _NEAREST * (4 if k in {START, GOAL} else 1)
            for j in np.argsort(price[k], kind="stable")[:few].tolist():
                pairs.add((min(k, j), max(k, j)))
        self._join(sorted(pairs - self._level.keys()), 0)

    def grow_near_path(self, rng: np.random.Generator, spread: float) -> None:
        """Add poses near the cheapest path that may make it cheaper, and edges from them and between its own poses.

        Args:
            rng: Draws them.
            spread: How far from the path they are [L], and by how much they turn.
        """
        path, region = self.path(), self.region
        if path is None:
            return
        pairs = {(min(a, b), max(a, b)) for a, b in itertools.combinations(path, 2)}
        for k, (a, b) in enumerate(itertools.pairwise(path)):
            within = self.edge(a, b).poses
            between = np.concatenate([within, self.poses[[b] if b != GOAL else []]])
            if not len(between):
                continue
            first, last = path[max(k - 1, 0)], path[min(k + 2, len(path) - 1)]
            near = np.concatenate([within, region.near(rng, between, _NEAR, spread)])
            n = len(self.poses)
            worth = (
                self._rough_prices(self.poses[[first]], near)[0] + self._rough_prices(near, self.poses[[last]])[:, 0]
            )
            known = _SLACK * self.price(path[max(k - 1, 0) : k + 3])
            few = np.argsort(worth, kind="stable")[: np.count_nonzero(worth < known)]
            rank = np.linspace(_TRIED // 2, max(len(few) - 1, 0), _TRIED // 2).astype(np.int64)
            rank = np.unique(np.concatenate([np.arange(_TRIED // 2), rank]))
            near = near[few[rank[rank < len(few)]]]
            self.poses = np.concatenate([self.poses, near])
            ends = {first, a, b, last}
            pairs |= {(end, new) for new in range(n, len(self.poses)) for end in ends}
        self._join(sorted(pairs - self._level.keys()), 0)

    def _rough_prices(self, begin: Array, end: Array) -> Array:
        """Return what the ways from each of some poses to each of others may cost [rad]. Shape (n, m)."""
        prices = self._rough(np.repeat(begin, len(end), axis=0), np.tile(end, (len(begin), 1, 1)))
        return prices.reshape(len(begin), len(end))

    def _rough(self, begin: Array, end: Array, swing: int = 0) -> Array:
        """Return what the ways from poses to as many others may cost by strokes of a bend [rad]. Shape (n,)."""
        moves = matmul(se3.inverse(begin), end)
        moves[:, :3, 3] /= self.region.length_m
        return np.asarray(np.round(self._prices[swing].of(moves), 6))

    def reprice(self, pair: tuple[int, int], travel_rad: float) -> None:
        """Take the joint travel of an edge's exact legs for its price [rad]."""
        pair = (min(pair), max(pair))
        self.edges[pair] = dataclasses.replace(self.edges[pair], price=travel_rad)
        self._changed = True

    def _join(self, pairs: list[tuple[int, int]], level: int) -> None:
        """Look for edges between pairs of poses, by strokes of a bend, and of smaller ones where there are none."""
        region, most = self.region, _SLACK * self.least_rad
        self._widest = np.concatenate([self._widest, region.widest(self.poses[len(self._widest) :])])
        for k in range(level, len(region.swings)):
            for pair in pairs:
                self._level[pair] = k
            some = [(a, b) for a, b in pairs if max(self._widest[a], self._widest[b]) <= k]
            some = self._promising(some, k, most)
            if not some:
                continue
            first, last = (self.poses[[pair[end] for pair in some]] for end in (0, 1))
            found = self._clear(region.scene, k, first, last)
            self.edges.update({pair: edge for pair, edge in zip(some, found, strict=True) if edge is not None})
            self._changed = True
            pairs = [pair for pair in pairs if pair not in self.edges]

    def _clear(self, scene: Scene | None, swing: int, first: Array, last: Array) -> list[Edge | None]:
        """Return the cheapest ways between poses by strokes of a bend that are clear of obstacles, if there are any."""
        region = self.region
        axis = None if region.plane is None else region.plane.axis
        return clear_edges(scene, region.swings[swing], region.length_m, region.clearance_m, first, last, axis)

    def _promising(self, pairs: list[tuple[int, int]], swing: int, most_rad: float) -> list[tuple[int, int]]:
        """Return the pairs of poses by which a way from the start to the goal may cost no more than this [rad]."""
        if not pairs or most_rad == np.inf:
            return pairs
        first, last = (self.poses[[pair[end] for pair in pairs]] for end in (0, 1))
        start, goal = (np.repeat(self.poses[[end]], len(pairs), axis=0) for end in (START, GOAL))
        forth = self._rough(start, first) + self._rough(last, goal)
        back = self._rough(start, last) + self._rough(first, goal)
        whole = self._rough(first, last, swing) + np.minimum(forth, back)
        return [pair for pair, price in zip(pairs, whole.tolist(), strict=True) if price < most_rad]

    @property
    def good(self) -> bool:
        """Whether there is a path that costs hardly more than the way through empty water would."""
        return self.least_rad < _HARDLY * self._empty_rad

    @property
    def least_rad(self) -> float:
        """About the joint travel of the cheapest path; infinite where there is none [rad]."""
        path = self.path()
        return np.inf if path is None else self.price(path)

    def price(self, path: list[int]) -> float:
        """Return about the joint travel of a path [rad]."""
        return sum(self.edge(a, b).price for a, b in itertools.pairwise(path))

    def bar(self, pair: tuple[int, int]) -> None:
        """Take an edge away whose exact legs touch; strokes of a smaller bend may do."""
        pair = (min(pair), max(pair))
        del self.edges[pair]
        self._changed = True
        self._join([pair], self._level[pair] + 1)

    def edge(self, begin: int, end: int) -> Edge:
        """Return the edge from one pose to another."""
        return self.edges[begin, end] if begin < end else self.edges[end, begin].backwards()

    def blocked(self) -> Blocked:
        """Return how near to the goal the poses come that edges lead to, and what stands between."""
        reached, scene = {START}, self.region.scene
        while more := {b for pair in self.edges for a, b in (pair, pair[::-1]) if a in reached} - reached:
            reached |= more
        every = sorted(reached - {GOAL})
        left = self._rough_prices(self.poses[every], self.poses[[GOAL]])[:, 0]
        place, goal = self.poses[every[int(np.argmin(left))], :3, 3], self.poses[GOAL, :3, 3]
        _, which = scene.distance(place[None], goal[None])
        at = ", ".join(f"{x:.4g}" for x in place)
        left_m = float(norm(goal - place))
        obstacle = int(which[0]) if int(which[0]) < self.region.obstacles else None
        between = "a wall of the workspace" if obstacle is None else scene.name(obstacle)
        words = (
            f"the nearest attempt comes to ({at}) m, {left_m / self.region.length_m:.3g} L from the goal; "
            f"{between} is in the way from there"
        )
        return Blocked((float(place[0]), float(place[1]), float(place[2])), left_m, obstacle, words)

    def path(self) -> list[int] | None:
        """Return the poses along the cheapest path from the start to the goal; None where there is none."""
        if self._changed:
            self._cheapest, self._changed = self._found_path(), False
        return self._cheapest

    def _found_path(self) -> list[int] | None:
        near: dict[int, list[tuple[int, float]]] = {}
        for (a, b), edge in sorted(self.edges.items()):
            near.setdefault(a, []).append((b, edge.price))
            near.setdefault(b, []).append((a, edge.price))
        paid, before = {START: 0.0}, {START: START}
        queue = [(0.0, START)]
        while queue:
            price, here = heapq.heappop(queue)
            if here == GOAL:
                out = [GOAL]
                while out[-1] != START:
                    out.append(before[out[-1]])
                return out[::-1]
            if price > paid[here]:
                continue
            for there, more in near.get(here, []):
                if (whole := round(price + more, 6)) < paid.get(there, np.inf):
                    paid[there], before[there] = whole, here
                    heapq.heappush(queue, (whole, there))
        return None
