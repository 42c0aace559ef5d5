"""The orders of waypoints that cost least: dynamic programming over the sets that are passed already.

Held and Karp (1962), J. SIAM 10, 196; the state has the candidate pose at the last waypoint too, since what a leg
costs depends on the headings at both its ends.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.mission import Waypoint
from purcell_cli.planner.missions.waypoint_poses import Touring

_POSES = 72
"""Candidate poses of all waypoints together: some 5,000 legs are priced, in half a second."""
_FEWEST = 4
"""Candidate poses of a waypoint at least."""


def leg_prices(touring: Touring, start: Array, via: Sequence[Waypoint], goal: Array) -> tuple[Array, Array, Array]:
    """Return the prices of legs from the start, between candidates at waypoints, and to the goal [rad].

    Args:
        touring: The choice of poses.
        start: The pose at the start [m]. Shape (4, 4).
        via: The waypoints. There are n.
        goal: The pose at the goal [m]. Shape (4, 4).

    Returns:
        Prices. Shapes (n, h), (n, h, n, h) and (n, h), h candidates each.
    """
    n = len(via)
    each = max(_POSES // n, _FEWEST)
    middle = 0.5 * (start[:3, 3] + goal[:3, 3])
    places = [middle if one.position_m is None else one.position_m for one in via]
    level = start[:3, :3]
    layers = []
    for k, one in enumerate(via):
        if one.orientation is not None:
            turns = [one.orientation]
        else:
            others = sorted(
                (p - places[k] for p in [start[:3, 3], goal[:3, 3], *(q for j, q in enumerate(places) if j != k)]),
                key=lambda v: round(float(inner(v, v)), 12),
            )
            turns = touring.turns(level, others[: max(each // 3, 1)])
        picked = [turns[j % len(turns)] for j in range(each)]
        layers.append(np.stack([se3.pose(turn, places[k]) for turn in picked]))
    every = np.concatenate(layers)
    first = touring.price.between_all(start[None], every)[0].reshape(n, each)
    last = touring.price.between_all(every, goal[None])[:, 0].reshape(n, each)
    return first, touring.price.between_all(every, every).reshape(n, each, n, each), last


def cheapest_orders(first: Array, between: Array, last: Array, count: int) -> list[tuple[list[int], float]]:
    """Return the orders of least price, the cheapest first, and their prices [rad].

    The table says exactly what comes before the last waypoints of an order costs at least, so that A* from the goal
    backwards (Hart, Nilsson and Raphael, 1968, IEEE Trans. Systems Science and Cybernetics 4, 100) ends at one order
    after the other.

    Args:
        first: Prices from the start to each waypoint's candidates. Shape (n, h).
        between: Prices between candidates. Shape (n, h, n, h).
        last: Prices from candidates to the goal. Shape (n, h).
        count: How many orders, at most.
    """
    paid, n = _paid(first, between), len(first)
    every = (1 << n) - 1
    out: list[tuple[list[int], float]] = []
    queue: list[tuple[float, tuple[int, ...], Array]] = [
        (round(float(np.min(paid[every, k] + last[k])), 6), (k,), np.round(last[k], 6)) for k in range(n)
    ]
    heapq.heapify(queue)
    while queue and len(out) < count:
        price, order, rest = heapq.heappop(queue)
        if len(order) == n:
            out.append(([*order], price))
            continue
        left = every - sum(1 << k for k in order)
        for k in (k for k in range(n) if left >> k & 1):
            more = np.round(np.min(between[k, :, order[0]] + rest, axis=1), 6)
            heapq.heappush(queue, (round(float(np.min(paid[left, k] + more)), 6), (k, *order), more))
    return out


def _paid(first: Array, between: Array) -> Array:
    """Return the least price at which a set of waypoints is passed, one of them last, at each of its candidates [rad].

    Shape (2**n, n, h).
    """
    n, h = first.shape
    paid = np.full((1 << n, n, h), np.inf)
    for k in range(n):
        paid[1 << k, k] = np.round(first[k], 6)
    for done in range(1, 1 << n):
        inside = [k for k in range(n) if done >> k & 1]
        for k in inside if len(inside) > 1 else ():
            before = paid[done ^ (1 << k)].reshape(n * h)
            paid[done, k] = np.min(np.round(before[:, None] + between[:, :, k].reshape(n * h, h), 6), axis=0)
    return paid
