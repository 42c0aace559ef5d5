"""Plans of the rest of a way from measured configurations, made for the swimmer that measurements so far tell.

What the swimmer really made between measurements corrects what is believed of its links' drag (`drag_filter`); the rest
is planned for the swimmer that is believed in. So the miss falls much faster than by the model's own error. A model
whose links feel each other's flow stays as it is. Joints do as they are told.
"""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np

from purcell_cli.feedback.drag_filter import DragFilter
from purcell_cli.feedback.measured import EXACTLY, Measuring
from purcell_cli.feedback.replan import done_by, way_of
from purcell_cli.feedback.simulate import refuse_other_joints
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.configuration import Configuration, Deviation, displacement_between
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import block_displacements, starting_shapes
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.options import Controls, Effort, PlanOptions
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import schedule
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.effort import AGAIN
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planner.refine.minimum_travel import Pace
from purcell_cli.planner.rest import BACK_RAD, blocks_after, rest
from purcell_cli.planning import plan, planned
from purcell_cli.solution import Solution, carried_out

TOLERANCE_L = 1e-3
"""Position tolerance of an arrival, in units of L."""
TOLERANCE_RAD = float(np.radians(0.1))
"""Angle tolerance of an arrival [rad]."""
_PACE = Pace(rounds=2, steps=30, price=300.0, work=600)
"""How long a rest is shortened where a whole plan is made too."""
_HARDLY = 1.04
"""No whole plan is made beside a rest of less than so many times the joint travel that was left."""
_LAG_RAD = 0.1
"""The rest of a plan that was swum in part begins at most so much joint travel before what was swum [rad]."""


@frozen_dataclass(eq=False)
class Aim:
    """What a leg of the way is to come to.

    Attributes:
        goal: Where it is to end.
        waypoint: What of that counts as an arrival; all of it where there is none.
        slack_l: How far the position may be off besides the tolerance [L].
        leg: The plan of the leg, if there is one.
    """

    goal: Configuration
    waypoint: Waypoint | None = None
    slack_l: float = 0.0
    leg: Plan | None = None

    def off(self, found: Configuration) -> Deviation:
        """Return how far a configuration is from it, in what counts."""
        return Deviation.between(found, self.goal) if self.waypoint is None else self.waypoint.deviation(found)


class Tracker:
    """Plans the rest of a way from measured configurations, and learns from what the parts so far made.

    It keeps the ways of its plans, so that an update changes their remaining strokes instead of planning anew.

    Args:
        goal: The goal.
        model: The swimmer that is planned for until something is learned.
        options: What is asked of plans.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
        measuring: How exactly it is measured: the less, the less is learned from little motion.
    """

    def __init__(
        self,
        goal: Configuration,
        model: Swimmer,
        options: PlanOptions = PlanOptions(),
        tolerance_l: float = TOLERANCE_L,
        tolerance_rad: float = TOLERANCE_RAD,
        measuring: Measuring = EXACTLY,
    ) -> None:
        self.goal, self.model, self.options = goal, model, options
        self.tolerance_l, self.tolerance_rad = tolerance_l, tolerance_rad
        self.measuring = measuring
        self.aim = Aim(goal)
        self._belief = DragFilter.of(model)
        self._last: Solution | None = None
        self._seen: list[tuple[float, Configuration]] = []
        self._ways: list[PlanPath] = []

    def turn_to(self, aim: Aim, measured: Configuration, swum_s: float = math.inf) -> None:
        """Go to another aim from now on: what the last plan made is learned from, and its way forgotten.

        Args:
            aim: The aim.
            measured: Where the swimmer is.
            swum_s: How long of the last plan was swum; all of it where nothing is said [s].
        """
        if self._last is not None:
            self.saw(measured, min(swum_s, self._last.duration_s))
            self._learn()
        self.aim, self.goal, self._last, self._seen = aim, aim.goal, None, []
        way = None if aim.leg is None else way_of(dataclasses.replace(aim.leg, swimmer=self.model))
        self._ways = [] if way is None else [way]

    def off(self, measured: Configuration) -> Deviation:
        """Return how far a configuration is from the goal, in what counts."""
        return self.aim.off(measured)

    def arrived(self, measured: Configuration) -> bool:
        """Return whether a configuration is at the goal, within the tolerances."""
        most = self.tolerance_l + self.aim.slack_l
        return self.off(measured).within(most * self.model.length_m, self.tolerance_rad)

    def update(self, measured: Configuration, swum_s: float = math.inf, anew: bool = False) -> Solution:
        """Return a plan of the rest of the way from where the swimmer was measured to be.

        Args:
            measured: Where it is.
            swum_s: How long of the last plan was swum; all of it where nothing is said [s].
            anew: Whether a whole plan is made too, and the one of less joint travel taken.

        Raises:
            ParameterError: See `planning.plan`.
        """
        if self._last is not None:
            self.saw(measured, min(swum_s, self._last.duration_s))
            self._learn()
            self._aim_at_what_counts(measured, swum_s)
        found = self._rest(measured, swum_s, anew)
        if found is None or (anew and not self._hardly_longer(found, swum_s)):
            whole = self._whole(measured)
            if found is None or _rank(whole) < _rank(found):
                found, self._ways = whole, self._ways if anew else []
        way = way_of(found.plan)
        self._ways = [*self._ways[:1], *([] if way is None else [way])]
        self._last, self._seen = found, [(0.0, measured)]
        return found

    def _hardly_longer(self, found: Solution, swum_s: float) -> bool:
        """Return whether a rest takes hardly more joint travel than what was left of the last plan."""
        last = self._last
        if last is None or found.verdict != Verdict.REACHED or swum_s >= last.duration_s:
            return False
        left = last.joint_travel_rad - done_by(last.plan, swum_s)
        return found.joint_travel_rad < _HARDLY * left

    def _whole(self, measured: Configuration) -> Solution:
        """Return a whole plan to the goal; after what was measured with more effort than a standard one."""
        asked = self.options
        if self._last is None or (asked.effort, asked.controls) != (Effort.STANDARD, Controls.PRIMITIVE):
            return plan(measured, self.goal, swimmer=self.model, options=asked)
        made = planned(measured, self.goal, swimmer=self.model, options=asked, effort=AGAIN)
        return carried_out(made, asked)

    def _aim_at_what_counts(self, measured: Configuration, swum_s: float) -> None:
        """Let what a waypoint leaves free be as what is left of the last plan is believed to make it."""
        if self._last is not None and self.aim.waypoint is not None and way_of(self._last.plan) is not None:
            end = self._going_on(
                self._last.plan, measured, done_by(self._last.plan, min(swum_s, self._last.duration_s))
            )
            self.goal = self.aim.waypoint.filled(end.goal)

    def on_its_way(self, measured: Configuration, swum_s: float) -> bool:
        """Return whether what is left of the last plan, as it is, is believed to arrive within half the tolerances.

        Args:
            measured: Where the swimmer is.
            swum_s: How long of the plan was swum [s].
        """
        last = self._last
        if last is None or way_of(last.plan) is None:
            return False
        end = self._going_on(last.plan, measured, done_by(last.plan, swum_s)).goal
        return self.off(end).within(0.5 * self.tolerance_l * self.model.length_m, 0.5 * self.tolerance_rad)

    def saw(self, measured: Configuration, swum_s: float) -> None:
        """Take a measurement on the way, which the next update learns from.

        Args:
            measured: Where the swimmer is.
            swum_s: How long of the last plan was swum [s].
        """
        if self._seen and swum_s > self._seen[-1][0]:
            self._seen.append((swum_s, measured))

    def _rest(self, measured: Configuration, swum_s: float, anew: bool) -> Solution | None:
        """Return the rest of one of the plans so far; None without one.

        Of a plan that was swum in part that is what is left of it: brought to the goal, or else as it is, since to go
        back where one came from at every measurement leads nowhere. Else that of the plan whose way is nearest.
        """
        last, limits = self._last, Limits.of(self.options)
        if last is not None and self._ways and swum_s < last.duration_s:
            done_rad, way = done_by(last.plan, swum_s), self._ways[-1]
            place, _ = way.nearest(measured, self.goal, max(done_rad - _LAG_RAD, 0.0))
            left = rest(way, place, measured, self.goal, limits, (0.0,), _PACE if anew else None)
            if left is None and not anew:
                left = self._going_on(last.plan, measured, done_rad)
            return None if left is None else carried_out(left, self.options)
        near = sorted(((*way.nearest(measured, self.goal), way) for way in self._ways), key=lambda one: one[1])
        for place, _, way in near:
            found = rest(way, place, measured, self.goal, limits, BACK_RAD, _PACE if anew else None)
            solution = None if found is None else carried_out(found, self.options)
            if solution is not None and solution.verdict == Verdict.REACHED:
                return solution
        return None

    def _going_on(self, last: Plan, measured: Configuration, done_rad: float) -> Plan:
        """Return what is left of a plan as it is; its goal is where the model then ends."""
        blocks = blocks_after(last, done_rad)
        pose = matmul(measured.pose, se3.prefix_products(block_displacements(self.model, blocks, measured.shape))[-1])
        end = Configuration(se3.normalised(pose), starting_shapes(blocks, measured.shape)[-1])
        return Plan(self.model, measured, end, blocks)

    def use(self, model: Swimmer) -> None:
        """Plan for another model from now on; what was learned before is forgotten.

        Args:
            model: A swimmer with the same joints.

        Raises:
            ParameterError: Its joints are others.
        """
        refuse_other_joints(self.model, model)
        self._belief = DragFilter.of(model)
        self._believe()

    def _learn(self) -> None:
        """Take what the last plan made from one measurement to the next into what is believed of drag."""
        last, seen = self._last, self._seen
        if last is None or len(seen) < 2 or self.model.fluid != "local":
            return
        times, rates = schedule(last.paced[0], last.plan.start.shape, last.paced[1])
        ends = np.array([time for time, _ in seen])
        cuts = np.unique(np.concatenate([times[times < ends[-1]], ends]))
        held, seconds = rates[np.searchsorted(times, cuts[:-1], "right") - 1], np.diff(cuts)
        shapes = shapes_along(last.plan.start.shape, None, held * seconds[:, None])
        made = np.array(
            [displacement_between(a, b, self.model.length_m) for (_, a), (_, b) in itertools.pairwise(seen)]
        )
        noise = np.repeat([self.measuring.position_l, math.radians(self.measuring.base_deg)], 3)
        rows = np.searchsorted(cuts, ends)
        self._belief = self._belief.after(Pieces(shapes[:-1], held, seconds), rows, made, noise * math.sqrt(2.0))
        self._believe()

    def _believe(self) -> None:
        """Plan for the swimmer that is believed in from now on."""
        self.model = self._belief.swimmer
        self._ways = [PlanPath.of(dataclasses.replace(way.plan, swimmer=self.model)) for way in self._ways]


def _rank(found: Solution) -> tuple[bool, float]:
    return found.verdict != Verdict.REACHED, found.joint_travel_rad
