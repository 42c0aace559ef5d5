"""The order of waypoints that costs least: dynamic programming over the sets that are passed already.

Held and Karp (1962), J. SIAM 10, 196; the state has the candidate pose at the last waypoint too, since what a leg
costs depends on the headings at both its ends.
"""

from __future__ import annotations

import itertools
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


def best_order(first: Array, between: Array, last: Array) -> tuple[list[int], float]:
    """Return the order of least price, and its price [rad].

    Args:
        first: Prices from the start to each waypoint's candidates. Shape (n, h).
        between: Prices between candidates. Shape (n, h, n, h).
        last: Prices from candidates to the goal. Shape (n, h).
    """
    n, h = first.shape
    paid = np.full((1 << n, n, h), np.inf)
    back = np.full((1 << n, n, h), -1, dtype=np.int64)
    for k in range(n):
        paid[1 << k, k] = np.round(first[k], 6)
    for done in range(1, 1 << n):
        inside = [k for k in range(n) if done >> k & 1]
        if len(inside) < 2:
            continue
        for k in inside:
            before = paid[done ^ (1 << k)].reshape(n * h)
            whole = np.round(before[:, None] + between[:, :, k].reshape(n * h, h), 6)
            back[done, k] = np.argmin(whole, axis=0)
            paid[done, k] = np.min(whole, axis=0)
    done = (1 << n) - 1
    ends = np.round(paid[done] + last, 6).ravel()
    state = int(np.argmin(ends))
    price, order = float(ends[state]), []
    while True:
        k, pose = divmod(state, h)
        order.append(k)
        state = int(back[done, k, pose])
        done ^= 1 << k
        if not done:
            return order[::-1], price


def price_of_order(order: Sequence[int], first: Array, between: Array, last: Array) -> float:
    """Return the least price of an order, its candidates the best for it [rad]; arguments as of `best_order`."""
    paid = first[order[0]]
    for a, b in itertools.pairwise(order):
        paid = np.min(paid[:, None] + between[a, :, b], axis=0)
    return float(np.min(paid + last[order[-1]]))
