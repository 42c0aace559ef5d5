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

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.arcs.arc_price import ArcPrice
from purcell_cli.planner.ways.edges import Edge, clear_edges
from purcell_cli.planner.ways.poses import Region

START, GOAL = 0, 1
"""The first two poses of a roadmap."""

_NEAREST = 8
"""To how many others, by price, a pose gets edges."""

_NEAR, _TRIED = 24, 8
"""Near each place of a path so many poses are drawn, and the most promising of them get edges."""

_SLACK = 1.3
"""Poses are tried by which the way, roughly priced, costs up to so many times what it does now."""

_HARDLY = 1.15
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
        self._rough = ArcPrice(region.swings[0].loops)
        self._empty_rad = float(self._rough_prices(start[None], goal[None])[0, 0])
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
            near = near[np.argsort(worth, kind="stable")[: np.count_nonzero(worth < known)][:_TRIED]]
            self.poses = np.concatenate([self.poses, near])
            ends = {first, a, b, last}
            pairs |= {(end, new) for new in range(n, len(self.poses)) for end in ends}
        self._join(sorted(pairs - self._level.keys()), 0)

    def _rough_prices(self, begin: Array, end: Array) -> Array:
        """Return what the ways from each of some poses to each of others may cost [rad]. Shape (n, m)."""
        moves = matmul(se3.inverse(begin)[:, None], end[None, :]).reshape(-1, 4, 4)
        moves[:, :3, 3] /= self.region.length_m
        return np.asarray(np.round(self._rough.of(moves).reshape(len(begin), len(end)), 6))

    def reprice(self, pair: tuple[int, int], travel_rad: float) -> None:
        """Take the joint travel of an edge's exact legs for its price [rad]."""
        pair = (min(pair), max(pair))
        self.edges[pair] = dataclasses.replace(self.edges[pair], price=travel_rad)

    def _join(self, pairs: list[tuple[int, int]], level: int) -> None:
        """Look for edges between pairs of poses, by strokes of a bend, and of smaller ones where there are none."""
        region = self.region
        for k in range(level, len(region.swings)):
            if not pairs:
                return
            first, last = (self.poses[[pair[end] for pair in pairs]] for end in (0, 1))
            swing = region.swings[k]
            axis = None if region.plane is None else region.plane.axis
            found = clear_edges(region.scene, swing, region.length_m, region.clearance_m, first, last, axis)
            for pair, edge in zip(pairs, found, strict=True):
                self._level[pair] = k
                if edge is not None:
                    self.edges[pair] = edge
            pairs = [pair for pair, edge in zip(pairs, found, strict=True) if edge is None]

    @property
    def good(self) -> bool:
        """Whether there is a path that costs hardly more than the way through empty water would."""
        path = self.path()
        return path is not None and self.price(path) < _HARDLY * self._empty_rad

    def price(self, path: list[int]) -> float:
        """Return about the joint travel of a path [rad]."""
        return sum(self.edge(a, b).price for a, b in itertools.pairwise(path))

    def bar(self, pair: tuple[int, int]) -> None:
        """Take an edge away whose exact legs touch; strokes of a smaller bend may do."""
        pair = (min(pair), max(pair))
        del self.edges[pair]
        self._join([pair], self._level[pair] + 1)

    def edge(self, begin: int, end: int) -> Edge:
        """Return the edge from one pose to another."""
        return self.edges[begin, end] if begin < end else self.edges[end, begin].backwards()

    def path(self) -> list[int] | None:
        """Return the poses along the cheapest path from the start to the goal; None where there is none."""
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
