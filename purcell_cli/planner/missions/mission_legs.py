"""The legs of a mission, planned exactly in turn, and planned anew where they cost more than was promised."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import home_shape, plane_axis
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.missions.limbs_in_place import in_place
from purcell_cli.planner.missions.on_the_way import detours_rad, legs_through
from purcell_cli.planner.routes.one_motion import ended

LegPlanner = Callable[[Configuration, Configuration, float], Plan]
"""Plans a leg, from a configuration to another, with limbs that bend up to so much of their limit."""
OtherPoses = Callable[[Waypoint, Configuration, Configuration], Sequence[Configuration]]
"""Configurations at a waypoint that lies between two others, the cheapest first."""
InPlace = Callable[[Configuration, Waypoint], Plan | None]
"""Plans a leg in which limbs turn where they are."""

_STRAIGHT = 0.8
"""Nor are they where the straight line is less than this part of the line through them: to price a way takes longer."""
_ON_THE_WAY = 0.9
"""Waypoints are on the way from one stop to another where going there straight away costs at least this part of going
through them."""
_ROOM = 0.96
"""A plan that is to be brought through waypoints bends limbs up to this part of their limit: so its strokes can go some
8 % farther."""
_AS_SHORT = 1.03
"""Legs through waypoints on the way that take no more than so many times the plan that ignores them are taken."""
_DEAR = 1.1
"""Two legs that take more than so many times their price are planned anew by way of other headings between them: of
36 legs of random missions half took 0.98 of their price, and one in twelve more than 1.1."""
_SHORT_RAD = 80.0
"""Two legs of less joint travel are not planned anew [rad]: what they take is not that of arcs that repeat."""
_OTHERS, _UNLIKE_RAD = 3, 0.3
"""Headings that are tried at most where a leg to or from a waypoint is blocked, since to find that takes some 5 s, and
how far they are turned from the one that was chosen at least [rad]."""
_THERE = 1e-12
"""A waypoint that is met to this where a leg would begin is passed there [m, rad]."""
_TURNS_RAD = (0.12, -0.12)
"""By how much those headings differ [rad]."""


@frozen_dataclass(eq=False)
class Stop:
    """A waypoint, and the configuration that is chosen there.

    Attributes:
        waypoint: The waypoint.
        configuration: What is chosen; None where limbs turn in place.
    """

    waypoint: Waypoint
    configuration: Configuration | None


@frozen_dataclass(eq=False)
class MissionLegs:
    """The planning of legs.

    Attributes:
        swimmer: The swimmer.
        price: The price of its legs.
        limits: What legs keep besides the bend limit.
        plan_leg: Plans a leg.
        in_place: Turns limbs where they are.
        others: Says what else may be chosen at a waypoint.
        dear: Whether to plan a leg takes long, so that each is planned once.
    """

    swimmer: Swimmer
    price: LegPrice
    limits: Limits
    plan_leg: LegPlanner
    in_place: InPlace
    others: OtherPoses
    dear: bool = False

    def between(self, start: Configuration, stops: Sequence[Stop], goal: Configuration) -> list[Plan]:
        """Return the legs from the start to each stop in turn, and to the goal; each begins where the one before ends.

        Args:
            start: The start configuration.
            stops: The stops.
            goal: The goal configuration.
        """
        legs: list[Plan] = []
        every = [*(one.configuration for one in stops), goal]
        k, here = 0, start
        while k < len(every):
            if k < len(stops) and stops[k].waypoint.deviation(here).within(0.0, _THERE):
                legs, k = [*legs, Plan(self.swimmer, here, here, ())], k + 1
                continue
            run = self._run(here, stops, every, k)
            through, sure = self._through(here, stops[k:run], every[k : run + 1])
            if through is not None and not sure:
                apart: list[Plan] = []
                for j in range(k, run + 1):
                    apart = self._and_next(apart, ended(apart[-1]) if apart else here, stops, every, j)
                through = min(apart, through, key=_travel_rad)
            if through is not None:
                legs, k = legs + through, run + 1
            else:
                legs, k = self._and_next(legs, here, stops, every, k), k + 1
            here = ended(legs[-1])
        return legs

    def _and_next(
        self,
        legs: list[Plan],
        here: Configuration,
        stops: Sequence[Stop],
        every: Sequence[Configuration | None],
        k: int,
    ) -> list[Plan]:
        """Return legs and one more, to the k-th stop or the goal, the last two planned anew where they are dear."""
        legs = [*legs, self._leg(here, every[k], stops[k].waypoint if k < len(stops) else None)]
        if k and len(legs) > 1 and every[k] is not None and every[k - 1] is not None:
            if any(leg.blocked is not None for leg in legs[-2:]):
                legs[-2:] = self._elsewhere(legs[-2], legs[-1], stops[k - 1])
            else:
                legs[-2:] = self._anew(legs[-2], legs[-1], stops[k - 1])
        return legs

    def _elsewhere(self, first: Plan, second: Plan, stop: Stop) -> tuple[Plan, Plan]:
        """Return two legs of which one is blocked, by way of another heading between them where neither is then."""
        chosen = stop.configuration
        if chosen is None:
            return first, second
        every = self.others(stop.waypoint, first.start, second.goal)
        unlike = [one for one in every if angle_between(one.pose[:3, :3], chosen.pose[:3, :3]) > _UNLIKE_RAD]
        for there in unlike[:_OTHERS]:
            one = self.plan_leg(first.start, there, 1.0)
            if one.blocked is None:
                other = self.plan_leg(ended(one), second.goal, 1.0)
                if other.blocked is None:
                    return one, other
        return first, second

    def _leg(self, here: Configuration, there: Configuration | None, waypoint: Waypoint | None) -> Plan:
        if there is not None:
            return self.plan_leg(here, there, 1.0)
        found = None if waypoint is None else self.in_place(here, waypoint)
        return found or self.plan_leg(here, here if waypoint is None else waypoint.filled(here), 1.0)

    def _price(self, *pose: Array) -> float:
        """Return the price of legs from pose to pose [rad]."""
        return float(np.sum(self.price(np.stack(pose[:-1]), np.stack(pose[1:]))))

    def _run(
        self, here: Configuration, stops: Sequence[Stop], every: Sequence[Configuration | None], first: int
    ) -> int:
        """Return up to which stop those from the first on are all on the way; the first where none is."""
        poses, last = [here.pose], first
        if self.dear or self.limits.obstacles is not None:
            return first
        for k in range(first, len(every)):
            one = every[k]
            if one is None or (k < len(stops) and stops[k].waypoint.position_m is None):
                continue
            poses.append(one.pose)
            if k > first and _straight(poses) and self._price(poses[0], poses[-1]) >= _ON_THE_WAY * self._price(*poses):
                last = k
        return last

    def _through(
        self, here: Configuration, stops: Sequence[Stop], every: Sequence[Configuration | None]
    ) -> tuple[list[Plan] | None, bool]:
        """Return legs through stops on the way to the last configuration, and whether they cost as little as wanted."""
        goal = every[-1]
        if not stops or goal is None:
            return None, False
        via = [one.waypoint for one in stops]
        direct = self.plan_leg(here, goal, 1.0 if all(in_place(one) for one in via) else _ROOM)
        found = legs_through(self.swimmer, direct, via, self.limits)
        if found is None and any(_looks_anywhere(one) for one in via):
            looking = [_looking(one.waypoint, one.configuration) for one in stops]
            found = legs_through(self.swimmer, direct, looking, self.limits)
        promised = self._price(here.pose, *(one.pose for one in every if one is not None))
        enough = max(promised, _AS_SHORT * direct.joint_travel_rad)
        enough += detours_rad(via, home_shape(self.swimmer, here.shape))
        return found, found is not None and _travel_rad(found) < enough

    def _anew(self, first: Plan, second: Plan, stop: Stop) -> tuple[Plan, Plan]:
        """Return two legs, by way of another heading between them where that costs less and they are dear."""
        best, before = (first, second), first.joint_travel_rad + second.joint_travel_rad
        if self.dear or stop.waypoint.orientation is not None or stop.configuration is None:
            return best
        ends = (first.start.pose, second.goal.pose)
        if before < max(_SHORT_RAD, _DEAR * self._price(ends[0], stop.configuration.pose, ends[1])):
            return best
        for turn in self._turns():
            pose = matmul(stop.configuration.pose, se3.pose(se3.rotation(turn), np.zeros(3)))
            there = Configuration(se3.normalised(pose), stop.configuration.shape)
            one = self.plan_leg(first.start, there, 1.0)
            other = self.plan_leg(ended(one), second.goal, 1.0)
            spent = one.joint_travel_rad + other.joint_travel_rad
            if one.blocks and other.blocks and spent < before:
                best, before = (one, other), spent
                if before < _DEAR * self._price(ends[0], there.pose, ends[1]):
                    break
        return best

    def _turns(self) -> list[Array]:
        axis = plane_axis(self.swimmer)
        about = [1, 2] if axis is None else [2 if axis == "yaw" else 1]
        return [size * np.eye(3)[k] for size in _TURNS_RAD for k in reversed(about)]


def _looks_anywhere(waypoint: Waypoint) -> bool:
    """Return whether a waypoint names a position and limbs, and leaves the orientation free."""
    limbs = waypoint.limb1 is not None or waypoint.limb2 is not None
    return limbs and waypoint.position_m is not None and waypoint.orientation is None


def _looking(waypoint: Waypoint, chosen: Configuration | None) -> Waypoint:
    """Return such a waypoint with the orientation that is chosen for it; others as they are."""
    if chosen is None or not _looks_anywhere(waypoint):
        return waypoint
    return dataclasses.replace(waypoint, orientation=chosen.pose[:3, :3])


def _travel_rad(legs: Sequence[Plan]) -> float:
    """Return the joint travel of legs [rad]."""
    return sum(leg.joint_travel_rad for leg in legs)


def _straight(poses: Sequence[Array]) -> bool:
    """Return whether a way through places is about as long as the straight one."""
    places = np.stack(poses)[:, :3, 3]
    return float(norm(places[-1] - places[0])) >= _STRAIGHT * float(np.sum(norm(np.diff(places, axis=0))))
