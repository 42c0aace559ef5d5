"""Legs along a curve: as long as the tolerance lets them be, each planned exactly and its whole way held against it.

How far the base swings aside in a stroke grows with how far limbs bend, and so does how far a stroke goes. So the limbs
bend as far as the tolerance allows; and where a leg's way leaves the curve all the same, it is made shorter.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.mission import Follow
from purcell_cli.planner.missions.known_legs import KnownLegs, Leg, LegBlocks

SMALLEST_BEND_RAD = 0.1
"""Limbs bend at least so far in strokes [rad]: the number of strokes grows as its square falls."""
_SMALLER = 0.8
"""The next bend that is tried, as a part of the one before."""
_SWING = 1.01
"""Room that the tolerance leaves beside a straight stroke's swing."""
_TURN_L = 2.0
"""A turn by 1 rad counts as so long a way where a curve is cut into legs [L]: about the tightest circle's radius."""
_SHORTEST_L = (0.15, 0.03)
"""Legs are cut no shorter than this [L]: smaller bends are tried first, and with the smallest shorter ones."""
_PROBE_L = 3.0
"""How long the straight way is by which strokes' swing is measured [L]: long enough for strokes that repeat."""
_LONGEST_L = 8.0
"""Nor are they tried longer than this at first [L]."""
_SMOOTH_RAD = 0.3
"""A curve that turns by less than this at a point is smooth there [rad]: it has 20 points or more a circle."""
_SNAP = 0.25
"""A leg ends at a point of the curve where one is within this part of the leg of its end: so laps are cut alike."""
_MOST_LEGS = 2000
"""Legs of one curve at most."""
_HELD = 6
"""Legs that stay as short as the one that had to be made shorter, before longer ones are tried again."""
_TELLING = 0.15
"""Part of a curve after which what the whole will cost is told well enough to give it up."""


@frozen_dataclass(eq=False)
class CurvePoses:
    """Poses along a curve, between which a leg may begin or end anywhere.

    Attributes:
        pose: The poses [m]. Shape (n, 4, 4).
        along: How far along each is, turns counted too [L]. Shape (n,).
        place_m: How far along the curve each is [m]. Shape (n,).
    """

    pose: Array
    along: Array
    place_m: Array

    @classmethod
    def of(cls, follow: Follow, start: Configuration, goal: Configuration, length_m: float) -> CurvePoses:
        """Return the poses from the start along a curve to the goal."""
        inside = follow.poses(start)
        every = np.concatenate([start.pose[None], inside, goal.pose[None]])
        known = follow.curve.along_m
        own = known if len(inside) == len(known) else np.repeat(known, 2)[1:-1]
        place = np.concatenate([known[:1], own, known[-1:]])
        steps = norm(np.diff(every[:, :3, 3], axis=0)) / length_m
        steps = steps + _TURN_L * angle_between(every[:-1, :3, :3], every[1:, :3, :3])
        return cls(every, np.concatenate([[0.0], np.cumsum(steps)]), place)

    def snapped(self, along: float, slack: float) -> float:
        """Return a place along, or the stop nearest to it if that is within a slack of it [L].

        Stops are the poses; where the swimmer turns little at a point, half turned, so that it looks along a curve that
        is smooth.
        """
        turning = np.flatnonzero((np.diff(self.place_m) == 0.0) & (np.diff(self.along) < _SMOOTH_RAD * _TURN_L))
        stops = self.along.copy()
        stops[turning] = stops[turning + 1] = 0.5 * (stops[turning] + stops[turning + 1])
        stops[-1] = self.along[-1]
        near = float(stops[int(np.argmin(np.abs(stops - along)))])
        return near if abs(near - along) < slack else along

    def at(self, along: float) -> tuple[Array, float]:
        """Return the pose so far along, and how far along the curve it is [m]."""
        if along >= float(self.along[-1]):
            return self.pose[-1], float(self.place_m[-1])
        k = int(np.searchsorted(self.along, along, side="right")) - 1
        share = (along - float(self.along[k])) / float(self.along[k + 1] - self.along[k])
        a, b = self.pose[k], self.pose[k + 1]
        turn = se3.log(se3.pose(matmul(a[:3, :3].T, b[:3, :3]), np.zeros(3)))[3:]
        place = self.place_m[k] + share * (self.place_m[k + 1] - self.place_m[k])
        middle = a[:3, 3] + share * (b[:3, 3] - a[:3, 3])
        return se3.pose(matmul(a[:3, :3], se3.rotation(share * turn)), middle), float(place)


@dataclasses.dataclass(eq=False)
class CurveLegs:
    """The search for legs along one curve.

    Attributes:
        swimmer: The swimmer.
        follow: The curve.
        start: The start configuration.
        goal: The goal configuration, at the curve's end.
        plan_leg: Plans a leg.
        told: Is told how far along the search is, 0 to 1.
        known: The legs that are planned already.
    """

    swimmer: Swimmer
    follow: Follow
    start: Configuration
    goal: Configuration
    plan_leg: LegBlocks
    told: Callable[[float], None] = lambda _share: None
    known: KnownLegs = dataclasses.field(init=False)

    def __post_init__(self) -> None:
        self.known = KnownLegs(self.swimmer, self.follow.tolerance_m, self.plan_leg)

    def legs(self) -> tuple[Leg, ...]:
        """Return the legs of the cheapest way found, or of the one that leaves the curve latest.

        Raises:
            ParameterError: A tolerance that the swing of the smallest strokes exceeds already.
        """
        best: tuple[Leg, ...] | None = None
        least, furthest = np.inf, -1.0
        bend, smallest = self._largest_bend(), min(SMALLEST_BEND_RAD, self.swimmer.max_bend_rad)
        while True:
            found, reached = self._along(bend, least)
            travel = sum(leg.joint_travel_rad for leg in found)
            if reached >= 1.0 and travel < least:
                best, least, furthest = found, travel, 1.0
            elif furthest >= 1.0:
                break  # smaller strokes cost more
            elif reached > furthest:
                best, furthest = found, reached
            if bend <= smallest:
                break
            bend = max(_SMALLER * bend, smallest)
        return best or ()

    def _largest_bend(self) -> float:
        """Return how far limbs may bend [rad], so that a straight stroke's swing is within tolerance.

        Raises:
            ParameterError: Not even the smallest strokes swing so little.
        """
        bend, wanted = self.swimmer.max_bend_rad, self.follow.tolerance_m
        smallest = min(SMALLEST_BEND_RAD, bend)
        while (swing := self._swing_m(bend)) > wanted:
            if bend <= smallest:
                raise ParameterError(
                    f"follow.tolerance_m: at least {swing:.4g} m, which strokes swing aside whose limbs bend by "
                    f"{bend:g} rad, is wanted, found {wanted:g} m"
                )
            bend = max(bend * min(wanted / swing, _SMALLER), smallest)  # the swing is about proportional to it
        return bend

    def _swing_m(self, bend_rad: float) -> float:
        """Return how far the base's middle is from a straight way at most [m]."""
        way = _PROBE_L * self.swimmer.length_m
        shape = home_shape(self.swimmer, self.start.shape)
        begin = Configuration(np.eye(4), shape)
        end = Configuration(se3.pose(np.eye(3), np.array([way, 0.0, 0.0])), shape)
        blocks = self.plan_leg(begin, end, bend_rad)
        line = Curve(np.stack([begin.pose[:3, 3], end.pose[:3, 3]]))
        found = check(self.swimmer, begin, blocks, Limits(follow=Follow(line, self.swimmer.length_m * 1e3))).off_curve
        return np.inf if found is None else _SWING * found.most_m

    def _along(self, bend_rad: float, most_rad: float) -> tuple[tuple[Leg, ...], float]:
        """Return legs along the curve, and which part of it they keep near; given up where they cost too much."""
        poses = CurvePoses.of(self.follow, self.start, self.goal, self.swimmer.length_m)
        whole = float(poses.along[-1])
        shape = home_shape(self.swimmer, self.start.shape)
        here, at, place, step, held = self.start, 0.0, 0.0, min(_LONGEST_L, whole), 0
        shortest = _SHORTEST_L[bend_rad <= SMALLEST_BEND_RAD]
        out: list[Leg] = []
        for _ in range(_MOST_LEGS):
            if at >= whole:
                return tuple(out), 1.0
            step = min(step, whole - at)
            to = poses.snapped(at + step, _SNAP * step)
            last = to >= whole * (1.0 - 1e-12)
            pose, end = poses.at(to)
            there = self.goal if last else Configuration(se3.normalised(pose), shape)
            part = self.follow.curve.part(max(place - self.follow.tolerance_m, 0.0), end + self.follow.tolerance_m)
            leg = self.known.leg(here, there, bend_rad, last) if self._may(here, there, part) else None
            if leg is None or self.known.off_m(leg, here, part) > self.follow.tolerance_m:
                if step <= shortest:
                    return tuple(out), min(at / whole, 0.999)
                step, held = 0.5 * step, _HELD
                continue
            out.append(leg)
            # the limbs end as wanted to rounding; the next leg need not straighten what is no bend
            here = Configuration(se3.normalised(matmul(here.pose, leg.moved)), there.shape)
            at, place = to, end
            step, held = (step, held - 1) if held else (2.0 * step, 0)
            if at > _TELLING * whole and sum(leg.joint_travel_rad for leg in out) > most_rad * at / whole:
                return tuple(out), min(at / whole, 0.999)
            self.told(at / whole)
        return tuple(out), min(at / whole, 0.999)

    def _may(self, here: Configuration, there: Configuration, part: Curve) -> bool:
        """Return whether the circular way from one pose to the other is near enough to the curve."""
        twist = se3.log(se3.normalised(matmul(se3.inverse(here.pose), there.pose)))
        way = matmul(here.pose, se3.exp(np.linspace(0.0, 1.0, 9)[:, None] * twist))
        return float(np.max(part.distance_m(way[:, :3, 3]))) <= self.follow.tolerance_m
