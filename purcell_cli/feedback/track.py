"""The loop: plan on a model, swim on the truth, measure, plan again from there.

What the swimmer really makes of a displacement that is asked of the model is learned on the way, as a linear map of
body twists (Broyden's update): the next plan asks for what is expected to make the displacement that is still missing.
So the miss falls faster than by the model's own error. Joints do as they are told; only the base's pose is corrected.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.measured import EXACTLY, Measuring
from purcell_cli.feedback.simulate import refuse_other_joints, simulate
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import solve
from purcell_cli.geometry.reproducible import inner, matmul, normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.trajectory import Trajectory, as_table
from purcell_cli.solution import Solution, plan

TOLERANCE_L = 1e-3
"""Position tolerance of an arrival, in units of L."""
TOLERANCE_RAD = float(np.radians(0.1))
"""Angle tolerance of an arrival [rad]."""
REPLANS = 10
"""How often it is planned again, at most."""
_LEARNED_FROM = 3.0
"""Displacements of more than so many tolerances say how the swimmer moves; smaller ones are mostly noise."""
_LEAST_GAIN, _MOST_GAIN = 0.4, 2.5
"""Where what was learned would shorten or lengthen a displacement by more, the model's word is taken."""


class Tracker:
    """Plans the rest of a way from measured configurations, and learns from what the last plan made.

    Args:
        goal: The goal.
        model: The swimmer that is planned for.
        options: What is asked of plans.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
    """

    def __init__(
        self,
        goal: Configuration,
        model: Swimmer,
        options: PlanOptions = PlanOptions(),
        tolerance_l: float = TOLERANCE_L,
        tolerance_rad: float = TOLERANCE_RAD,
    ) -> None:
        self.goal, self.model, self.options = goal, model, options
        self.tolerance_l, self.tolerance_rad = tolerance_l, tolerance_rad
        self._map: Array = np.eye(6)
        self._asked: Array | None = None
        self._begun = goal

    def off(self, measured: Configuration) -> Deviation:
        """Return how far a configuration is from the goal."""
        return Deviation.between(measured, self.goal)

    def arrived(self, measured: Configuration) -> bool:
        """Return whether a configuration is at the goal, within the tolerances."""
        return self.off(measured).within(self.tolerance_l * self.model.length_m, self.tolerance_rad)

    def update(self, measured: Configuration) -> Solution:
        """Return a plan of the rest of the way from where the swimmer was measured to be.

        Args:
            measured: Where it is, the last plan having been swum whole.

        Raises:
            ParameterError: See `solution.plan`.
        """
        self._learn(measured)
        missing = self._twist(measured, self.goal)
        asked = solve(self._map, missing)
        sizes = (float(np.sqrt(inner(t, t))) for t in (asked, missing))
        gain = next(sizes) / max(next(sizes), 1e-300)
        if not _LEAST_GAIN < gain < _MOST_GAIN:
            asked = missing
        pose = matmul(measured.pose, self._pose(asked))
        aim = Configuration(se3.normalised(pose), self.goal.shape)
        self._asked, self._begun = asked, measured
        return plan(measured, aim, swimmer=self.model, options=self.options)

    def use(self, model: Swimmer) -> None:
        """Plan for another model from now on; what was learned of the last one's error is forgotten.

        Args:
            model: A swimmer with the same joints.

        Raises:
            ParameterError: Its joints are others.
        """
        refuse_other_joints(self.model, model)
        self.model, self._map, self._asked = model, np.eye(6), None

    def _learn(self, measured: Configuration) -> None:
        """Take what the last plan made into the map."""
        if self._asked is None:
            return
        made, asked = self._twist(self._begun, measured), self._asked
        size = float(inner(asked, asked))
        if np.sqrt(size) < _LEARNED_FROM * max(self.tolerance_l, self.tolerance_rad):
            return
        surprise = made - matmul(self._map, asked)
        self._map = self._map + surprise[:, None] * asked / size

    def _twist(self, first: Configuration, second: Configuration) -> Array:
        """Return the body twist from one pose to another [L, rad]. Shape (6,)."""
        g = se3.normalised(matmul(se3.inverse(first.pose), second.pose))
        g[:3, 3] /= self.model.length_m
        return np.asarray(se3.log(g))

    def _pose(self, twist: Array) -> Array:
        g = se3.exp(twist)
        g[:3, 3] *= self.model.length_m
        return np.asarray(g)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A plan that was swum.

    Attributes:
        solution: The plan, on the model.
        measured: Where the swimmer was measured to be after it.
        end: Where it really was.
        trajectory: What really happened.
    """

    solution: Solution
    measured: Configuration
    end: Configuration
    trajectory: Trajectory


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """A way that was swum in parts, measured between them.

    Attributes:
        start: Where it began.
        goal: Where it was to end.
        truth: The swimmer that swam.
        parts: The parts, in order.
        arrived: Whether the last measurement was at the goal, within the tolerances.
    """

    start: Configuration
    goal: Configuration
    truth: Swimmer
    parts: tuple[Part, ...]
    arrived: bool

    @property
    def replans(self) -> int:
        """How often it was planned again."""
        return max(len(self.parts) - 1, 0)

    @property
    def off(self) -> Deviation:
        """How far from the goal the swimmer really ended."""
        return Deviation.between(self.parts[-1].end if self.parts else self.start, self.goal)

    @property
    def joint_travel_rad(self) -> float:
        """The joint travel of all parts [rad]."""
        return sum(part.solution.joint_travel_rad for part in self.parts)

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
) -> Tracking:
    """Plan on a model, swim on the truth, measure, and plan again until the goal is reached.

    Args:
        start: The start configuration.
        goal: The goal configuration.
        truth: The swimmer that swims.
        model: The swimmer that is planned for; the truth's joints with the paper's sizes where none is given.
        options: What is asked of plans.
        replans: How often it is planned again, at most.
        measuring: How exactly it is measured. A measurement counts as an arrival up to what its noise may hide.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
        told: Is told of the way so far after each part.
        fitted: Is asked for a better model before each replan, given the way so far; None keeps the model.

    Raises:
        ParameterError: Fewer than no replans, or see `solution.plan`.
    """
    if replans < 0:
        raise ParameterError(f"replans: a number at least 0 is wanted, found {replans}")
    body = model or Swimmer()
    refuse_other_joints(body, truth)
    tracker = Tracker(goal, body, options, *measuring.hidden(tolerance_l, tolerance_rad))
    noise = np.random.default_rng(measuring.seed)
    parts: list[Part] = []
    here = start
    measured = measuring.of(here, body.length_m, normal_numbers(noise, (2, 3)))
    while not tracker.arrived(measured) and len(parts) <= replans:
        solution = tracker.update(measured)
        swum = simulate(as_table(solution.trajectory), truth, begun=here.pose).trajectory
        here = swum.end
        measured = measuring.of(here, body.length_m, normal_numbers(noise, (2, 3)))
        parts.append(Part(solution, measured, here, swum))
        so_far = Tracking(start, goal, truth, tuple(parts), tracker.arrived(measured))
        told(so_far)
        better = None if so_far.arrived else fitted(so_far)
        if better is not None:
            tracker.use(better)
    return Tracking(start, goal, truth, tuple(parts), tracker.arrived(measured))


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
