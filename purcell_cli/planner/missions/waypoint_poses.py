"""The poses at waypoints that leave them free: those of a few candidates that make the whole way cheapest.

Each waypoint gets candidates, and dynamic programming finds the best of all their combinations; candidates round the
best are tried next. The Dubins touring problem is solved so (Faigl, Vana et al., 2017, arXiv 1702.06892 and others).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import cos, inner, matmul, norm, sin
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_motion import home_shape, plane_axis
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Waypoint, turned_to
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.routes.edges import first_with_room
from purcell_cli.planner.routes.swing import swings
from purcell_cli.planner.routes.walls import with_walls

_EVERYWHERE = 16
"""Headings spread over all directions that are tried at a waypoint, besides those along the way."""
_NEAR_RAD = (0.45, 0.2, 0.09)
"""How far from the best heading so far others are tried, one round after the other [rad]."""
_ROUND = 6
"""How many are tried round it."""
_SHARES = (0.0, 0.5, 1.0)
"""Where a free position is tried: so far from the known position before it to the next one."""
_STARTS = (4, 12)
"""Starts of needle steering in the first round, and in the later ones."""


@frozen_dataclass(eq=False)
class Touring:
    """The choice of poses for waypoints in an order.

    Attributes:
        swimmer: The swimmer.
        price: The price of its legs.
        limits: What configurations at waypoints keep, as far as candidates that do are found.
    """

    swimmer: Swimmer
    price: LegPrice
    limits: Limits = Limits()

    def poses(self, start: Array, via: Sequence[Waypoint], goal: Array) -> list[Array]:
        """Return the base's poses at waypoints, free parts chosen [m]. Each of shape (4, 4).

        Args:
            start: The pose at the start [m]. Shape (4, 4).
            via: The waypoints, in order.
            goal: The pose at the goal [m]. Shape (4, 4).
        """
        layers = [self.candidates(k, start, via, goal) for k in range(len(via))]
        chosen, _ = self._best(start, layers, goal, _STARTS[0])
        for near in _NEAR_RAD:
            layers = [self._round(one, pose, near) for one, pose in zip(via, chosen, strict=True)]
            chosen, _ = self._best(start, layers, goal, _STARTS[1])
        here, out = start, []
        for one, pose in zip(via, chosen, strict=True):
            rolls = one.orientation is None and plane_axis(self.swimmer) is None
            here = self.price.rolled(here, pose) if rolls else pose
            out.append(here)
        return out

    def candidates(self, k: int, start: Array, via: Sequence[Waypoint], goal: Array) -> Array:
        """Return candidate poses for the k-th waypoint [m]. Shape (m, 4, 4)."""
        one = via[k]
        known = [start[:3, 3], *(w.position_m for w in via), goal[:3, 3]]
        before = next(p for p in reversed(known[: k + 1]) if p is not None)
        after = next(p for p in known[k + 2 :] if p is not None)
        places = [one.position_m] if one.position_m is not None else [before + s * (after - before) for s in _SHARES]
        if one.orientation is not None:
            turns = [one.orientation]
        else:
            here = places[len(places) // 2]
            along = [here - before, after - here, after - before]
            along += [start[:3, 0], goal[:3, 0]]
            along += [
                w.orientation[:, 0] for w in (*via[max(k - 1, 0) : k], *via[k + 1 : k + 2]) if w.orientation is not None
            ]
            turns = self.turns(start[:3, :3], along)
        return self._kept(one, np.stack([se3.pose(turn, place) for place in places for turn in turns]))

    def others(self, one: Waypoint, start: Configuration, goal: Configuration) -> list[Configuration]:
        """Return configurations at a waypoint between two others, the cheapest first; none where it names how."""
        if one.orientation is not None:
            return []
        every = self.candidates(0, start.pose, [one], goal.pose)
        ends = (np.broadcast_to(end.pose, every.shape) for end in (start, goal))
        price = self.price(next(ends), every) + self.price(every, next(ends))
        home = home_shape(self.swimmer, start.shape)
        return [
            one.filled(Configuration(se3.normalised(every[k]), home))
            for k in np.argsort(np.round(price, 6), kind="stable")
        ]

    def _kept(self, one: Waypoint, poses: Array) -> Array:
        """Return the poses at which a waypoint keeps the limits and strokes have most room; all where none keeps them.

        Of obstacles those count that have room for strokes of the largest bend for which any has.
        """
        if self.limits.workspace is None and self.limits.obstacles is None:
            return poses
        kept = []
        for k, pose in enumerate(poses):
            try:
                self.limits.refuse(
                    self.swimmer, "", one.filled(Configuration(pose, home_shape(self.swimmer, COLLINEAR)))
                )
            except ParameterError:
                continue
            kept.append(k)
        some = poses[kept] if kept else poses
        if self.limits.obstacles is None:
            return some
        scene = with_walls(self.limits.obstacles, self.limits.workspace)
        widest = first_with_room(scene, swings(self.swimmer), self.price.length_m, self.limits.clearance_m, some)
        return np.asarray(some[widest == np.min(widest)])

    def turns(self, level: Array, along: Sequence[Array]) -> list[Array]:
        """Return orientations that look in directions, and against them, and in others spread evenly.

        Args:
            level: An orientation to turn from. Shape (3, 3).
            along: The directions; those of no length are left out. Each of shape (3,).
        """
        axis = plane_axis(self.swimmer)
        spread = _sphere(_EVERYWHERE) if axis is None else _circle(_EVERYWHERE, axis)
        known = [v / norm(v) for v in along if float(norm(v)) > 1e-9 * self.price.length_m]
        directions = [*known, *(-v for v in known), *(matmul(level, v) for v in spread)]
        kept: list[Array] = []
        for direction in directions:
            if all(float(inner(direction, other)) < 0.9999 for other in kept):
                kept.append(direction)
        return [turned_to(level, direction) for direction in kept]

    def _round(self, one: Waypoint, pose: Array, near: float) -> Array:
        """Return a pose and others with headings near it. Shape (m, 4, 4)."""
        if one.orientation is not None:
            return pose[None]
        axis = plane_axis(self.swimmer)
        if axis is None:
            angles = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
            turns = near * np.stack([0.0 * angles, cos(angles), sin(angles)], axis=1)
        else:
            sizes = near * np.linspace(-1.0, 1.0, _ROUND)
            turns = sizes[:, None] * (np.eye(3)[2] if axis == "yaw" else np.eye(3)[1])
        others = [se3.pose(matmul(pose[:3, :3], se3.rotation(turn)), pose[:3, 3]) for turn in turns]
        return self._kept(one, np.stack([pose, *others]))

    def _best(self, start: Array, layers: Sequence[Array], goal: Array, starts: int) -> tuple[list[Array], float]:
        """Return the candidates, one of each layer, by which the way is cheapest, and its price [rad]."""
        every = [start[None], *layers, goal[None]]
        steps = [self.price.between_all(a, b, starts) for a, b in itertools.pairwise(every)]
        picks, price = cheapest_way(steps)
        return [layer[k] for layer, k in zip(layers, picks, strict=True)], price


def cheapest_way(steps: Sequence[Array]) -> tuple[list[int], float]:
    """Return which candidate of each layer between the first and the last the cheapest way takes, and its price.

    Args:
        steps: The prices from each candidate of a layer to each of the next; the first and last layers have one.
            Shapes (a, b), (b, c) and so on.
    """
    paid = np.zeros(1)
    backs = []
    for step in steps:
        whole = np.round(paid[:, None] + step, 6)
        backs.append(np.argmin(whole, axis=0))
        paid = np.min(whole, axis=0)
    picks, here = [], 0
    for back in reversed(backs):
        here = int(back[here])
        picks.append(here)
    return picks[-2::-1], float(paid[0])


def _sphere(count: int) -> Array:
    """Return directions spread evenly over the sphere by the golden angle. Shape (n, 3)."""
    k = np.arange(count) + 0.5
    height = 1.0 - 2.0 * k / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * k
    aside = np.sqrt(1.0 - height**2)
    return np.stack([aside * cos(angle), aside * sin(angle), height], axis=1)


def _circle(count: int, axis: str) -> Array:
    """Return directions spread evenly over the base's plane. Shape (n, 3)."""
    turns = about_axis(2 if axis == "yaw" else 1, 2.0 * np.pi * np.arange(count) / count)
    return np.asarray(turns[:, :, 0])
