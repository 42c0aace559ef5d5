"""The loop: plan on a model, swim a part on the truth, measure, plan again from there.

The first part is short: it is swum for what it tells of the swimmer, whose drag the tracker learns (`tracker`). Its end
is one of a control's. Of every plan after it the last fifth is planned again on the way, where the miss so far is
cheaper to mend than at the end: there strokes that are left change a little, and a correction takes strokes of its
own. Plans of few strokes are swum whole. On the way the swimmer is measured where controls change.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from purcell_cli.environment.scene import Scene
from purcell_cli.errors import ParameterError, PurcellWarning
from purcell_cli.feedback.measured import EXACTLY, Measuring, in_its_plane
from purcell_cli.feedback.replan import done_at, done_by, way_of
from purcell_cli.feedback.simulate import refuse_other_joints, simulate
from purcell_cli.feedback.tracker import TOLERANCE_L, TOLERANCE_RAD, Aim, Tracker
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import normal_numbers
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.mission import Follow
from purcell_cli.motion.obstacle_distance import least_link_distance
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.trajectory import Trajectory, as_table
from purcell_cli.solution import Solution

REPLANS = 10
"""How often it is planned again, at most."""
_FIRST_RAD, _FIRST_SHARE = 12.0, 0.5
"""The first part is about so long [rad], and so large a share of its plan at most: of 6 to 16 rad the best."""
_WHOLE_RAD = 3.0
"""A first plan of less joint travel is swum whole [rad]."""
_LONG_RAD, _LEFT_RAD, _LEFT_SHARE = 40.0, 20.0, 0.2
"""Of a later plan of more joint travel [rad], at least so much [rad], and so large a share, is planned again on the
way: of 20 and 30 rad what took less joint travel in ten random queries."""
_APART_RAD, _MOST_SEEN = 0.5, 200
"""A swimmer is measured on its way so far apart at least [rad], and so often a part at most."""


@frozen_dataclass(eq=False)
class Part:
    """A plan that was swum, or its beginning.

    Attributes:
        solution: The plan, on the swimmer that was believed in.
        joint_travel_rad: The joint travel of what was swum of it [rad].
        measured: Where the swimmer was measured to be after it.
        end: Where it really was.
        trajectory: What really happened.
        leg: Which leg of the way it is of, from 0.
        aim: What that leg was to come to.
    """

    solution: Solution
    joint_travel_rad: float
    measured: Configuration
    end: Configuration
    trajectory: Trajectory
    leg: int
    aim: Aim


@frozen_dataclass(slots=False, eq=False)
class Tracking:
    """A way that was swum in parts, measured between them.

    Attributes:
        start: Where it began.
        goal: Where it was to end.
        truth: The swimmer that swam.
        parts: The parts, in order.
        arrived: Whether the last measurement was at the goal, within the tolerances.
        follow: The curve that it was to follow, if there is one.
        obstacles: What no link was to touch, if there is anything.
    """

    start: Configuration
    goal: Configuration
    truth: Swimmer
    parts: tuple[Part, ...]
    arrived: bool
    follow: Follow | None = None
    obstacles: Scene | None = None

    @property
    def replans(self) -> int:
        """How often it was planned again; the first plan of each leg is none of these."""
        return len(self.parts) - len({part.leg for part in self.parts})

    @functools.cached_property
    def off_curve_m(self) -> float | None:
        """How far from the curve the base's middle really was in any row [m]; None without a curve."""
        if self.follow is None:
            return None
        curve = self.follow.curve
        return max((float(np.max(curve.distance_m(p.trajectory.pose[:, :3, 3]))) for p in self.parts), default=0.0)

    @functools.cached_property
    def obstacle_m(self) -> float | None:
        """How near a link really came to an obstacle in any row [m]; None without obstacles, or where nothing swam."""
        if self.obstacles is None:
            return None
        rows = [part.trajectory for part in self.parts]
        near = [least_link_distance(self.truth, self.obstacles, one.pose, one.shape[..., 0]) for one in rows]
        return min(near, default=None)

    def judged(self) -> Tracking:
        """Return it as not arrived where it left the curve's tolerance, or touched an obstacle."""
        if not self.arrived:
            return self
        off_curve = self.follow is not None and (self.off_curve_m or 0.0) > self.follow.tolerance_m
        touched = self.obstacle_m is not None and self.obstacle_m < 0.0
        return dataclasses.replace(self, arrived=False) if off_curve or touched else self

    @property
    def off(self) -> Deviation:
        """How far from the goal the swimmer really ended."""
        return Deviation.between(self.parts[-1].end if self.parts else self.start, self.goal)

    @property
    def joint_travel_rad(self) -> float:
        """The joint travel of all parts [rad]."""
        return sum(part.joint_travel_rad for part in self.parts)

    @property
    def trajectory(self) -> Trajectory | None:
        """What really happened, from the start to the end; None where nothing was swum."""
        return joined([part.trajectory for part in self.parts]) if self.parts else None


def track(
    start: Configuration,
    goal: Configuration,
    truth: Swimmer,
    *,
    model: Swimmer | None = None,
    options: PlanOptions = PlanOptions(),
    replans: int = REPLANS,
    measuring: Measuring = EXACTLY,
    tolerance_l: float = TOLERANCE_L,
    tolerance_rad: float = TOLERANCE_RAD,
    told: Callable[[Tracking], None] = lambda _: None,
    fitted: Callable[[Tracking], Swimmer | None] = lambda _: None,
    legs: Sequence[Aim] = (),
    follow: Follow | None = None,
) -> Tracking:
    """Plan on a model, swim on the truth, measure, and plan again until the goal is reached.

    Args:
        start: The start configuration.
        goal: The goal configuration.
        truth: The swimmer that swims.
        model: The swimmer that is planned for; the truth's joints with the paper's sizes where none is given.
        options: What is asked of plans.
        replans: How often it is planned again, at most; of a way in legs each of them.
        measuring: How exactly it is measured. A measurement counts as an arrival up to what its noise may hide.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
        told: Is told of the way so far after each part.
        fitted: Is asked for a better model before each replan, given the way so far; None keeps the model.
        legs: What the legs of the way are to come to, the last to the goal; one leg where none are given.
        follow: A curve that the way is to stay near, if there is one: it arrives only where it really did.

    Raises:
        ParameterError: Fewer than no replans, or see `planning.plan`; later, as where a link touches, it ends.
    """
    if replans < 0:
        raise ParameterError(f"replans: a number at least 0 is wanted, found {replans}")
    body = model or Swimmer()
    refuse_other_joints(body, truth)
    tracker = Tracker(goal, body, options, *measuring.hidden(tolerance_l, tolerance_rad), measuring)
    noise = np.random.default_rng(measuring.seed)
    parts: list[Part] = []

    def measured_at(at: Configuration, many: int = measuring.at_rest) -> Configuration:
        normal = np.add.reduce(normal_numbers(noise, (many, 2, 3))) / many
        return in_its_plane(body, start, measuring.of(at, body.length_m, normal))

    def so_far(arrived: bool) -> Tracking:
        return Tracking(start, goal, truth, tuple(parts), arrived, follow, options.obstacles).judged()

    here, swum_s = start, math.inf
    measured = measured_at(here)
    every = legs or (Aim(goal),)
    for leg, aim in enumerate(every):
        tracker.turn_to(aim, measured, swum_s)
        tried, last = 0, leg == len(every) - 1
        while not tracker.arrived(measured) and tried <= replans:
            solution = _updated(tracker, measured, swum_s, tried > 0 or aim.leg is None, first=not parts)
            if solution is None:
                return so_far(False)
            swum_s = _until(solution, first=not parts) if tried < replans else math.inf
            swum, swum_s, measured = _swum(tracker, solution, truth, here, swum_s, measured_at)
            here = swum.end
            travel = done_by(solution.plan, min(swum_s, solution.duration_s))
            parts.append(Part(solution, travel, measured, here, swum, leg, aim))
            tried += 1
            made = so_far(last and tracker.arrived(measured))
            told(made)
            better = None if made.arrived else fitted(made)
            if better is not None:
                tracker.use(better)
        if not tracker.arrived(measured):
            return so_far(False)
    return so_far(True)


def _updated(tracker: Tracker, measured: Configuration, swum_s: float, anew: bool, first: bool) -> Solution | None:
    """Return the plan that is swum next; None where none but the first can be made, as where a link touches."""
    try:
        return tracker.update(measured, swum_s, anew=anew)
    except ParameterError as error:
        if first:
            raise
        warnings.warn(f"it is not planned again: {error}", PurcellWarning, stacklevel=3)
        return None


def _swum(
    tracker: Tracker,
    solution: Solution,
    truth: Swimmer,
    here: Configuration,
    swum_s: float,
    measured_at: Callable[..., Configuration],
) -> tuple[Trajectory, float, Configuration]:
    """Return what happens where a plan is swum for some time, for how long it is [s], and the measurement after it.

    It is swum to its end where what is left of it is believed to arrive. The tracker is told what is seen on the way.
    """
    while True:
        found = simulate(as_table(solution.trajectory.until(swum_s)), truth, begun=here.pose)
        swum = found.trajectory
        rows = [] if found.slower_s else _seen_on_the_way(swum)  # its times are the plan's only at the plan's pace
        seen = [
            (float(swum.time_s[row]), measured_at(Configuration(swum.pose[row], swum.shape[row]), 1)) for row in rows
        ]
        measured = measured_at(swum.end)
        if swum_s == math.inf or not tracker.on_its_way(measured, swum_s):
            break
        swum_s = math.inf
    for time_s, at in seen:
        tracker.saw(at, time_s)
    return swum, swum_s, measured


def _seen_on_the_way(swum: Trajectory) -> list[int]:
    """Return the rows in which a swimmer is measured on its way: where controls change, not too near each other."""
    rate = swum.rate_rad_s
    switches = 1 + np.flatnonzero(np.any(rate[1:-1] != rate[:-2], axis=1))
    travel = np.concatenate([[0.0], np.cumsum(np.sum(np.abs(rate[:-1]), axis=1) * np.diff(swum.time_s))])
    apart, last, out = max(_APART_RAD, float(travel[-1]) / _MOST_SEEN), 0.0, []
    for row in switches.tolist():
        if apart <= travel[row] - last and apart <= travel[-1] - travel[row]:
            out.append(row)
            last = travel[row]
    return out


def _until(solution: Solution, first: bool) -> float:
    """Return how long of a plan is swum before the swimmer is measured again [s]; infinity for all of it."""
    travel = solution.joint_travel_rad
    if travel < (_WHOLE_RAD if first else _LONG_RAD) or way_of(solution.plan) is None:
        return math.inf
    wanted = min(_FIRST_RAD, _FIRST_SHARE * travel) if first else travel - max(_LEFT_RAD, _LEFT_SHARE * travel)
    rows = solution.trajectory
    switches = rows.time_s[1:-1][np.any(rows.rate_rad_s[1:-1] != rows.rate_rad_s[:-2], axis=1)]
    if not len(switches):
        return math.inf
    done = done_at(solution.plan, switches)
    return float(switches[int(np.argmin(np.abs(done - wanted)))])


def joined(parts: Sequence[Trajectory]) -> Trajectory:
    """Return trajectories one after the other; each begins where the one before ends."""
    names = tuple(dict.fromkeys(name for part in parts for name in part.gaits))
    rows: dict[str, list[Any]] = {name: [] for name in ("time_s", "phase", "gait", "pose", "shape", "rate_rad_s")}
    begun = 0.0
    for k, part in enumerate(parts):
        kept = slice(None) if k == len(parts) - 1 else slice(-1)
        number = np.array([names.index(name) for name in part.gaits], dtype=np.int64)
        own = {"time_s": begun + part.time_s, "gait": number[part.gait]}
        for name, values in rows.items():
            values.append(own.get(name, getattr(part, name))[kept])
        begun += float(part.time_s[-1])
    columns: dict[str, Any] = {name: np.concatenate(values) for name, values in rows.items()}
    lasts = np.append(np.diff(columns["time_s"]) > 0.0, True)  # a row may last less than later times can tell
    columns = {name: values[lasts] for name, values in columns.items()}
    return Trajectory(gaits=names, **columns)
