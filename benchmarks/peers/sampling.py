"""OMPL's control planners RRT, KPIECE1 and EST.

State space: position (in units of L), base and limb orientations, as a compound of SE(3) and two SO(3). Controls: the
six rates in [-1, 1] rad/s, held for as long as the planners choose. States are propagated by compiled CasADi
expressions, Runge-Kutta steps of order four. What can be set from Python is in `Settings`; `benchmarks.peers.tuning`
tries other values.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from benchmarks.peers.judge import LOOSE, Answer
from benchmarks.peers.model import CONTROLS, Model, state_of
from benchmarks.peers.queries import Query

REACH = 1.5
"""Positions are sampled up to so many times the goal's distance on each axis."""
FINEST = 0.1
"""Cells shrink with the way to the goal down to this (L, rad)."""


@dataclasses.dataclass(frozen=True)
class Settings:
    """What a user of OMPL can set from Python.

    Attributes:
        step_s: The step of propagation, and the shortest time that controls are held [s].
        longest_s: The longest time that controls are held [s].
        base_weight: What a radian of the base counts in the distance, where one L counts 1.
        limb_weight: The same for a radian of a limb.
        least_reach: Positions are sampled at least so far on each axis [L].
        goal_bias: For RRT, the part of samples that are the goal.
        intermediate: For RRT, whether the states after each step join the tree.
        projection: For KPIECE1 and EST, what they count states by: "position", the base's, or "left", the distance
            and the base's angle left to the goal.
        cells: For KPIECE1 and EST, how many cells the way to the goal has in each dimension.
    """

    step_s: float = 0.1
    longest_s: float = 2.0
    base_weight: float = 1.0
    limb_weight: float = 1.0
    least_reach: float = 1.0
    goal_bias: float = 0.1
    intermediate: bool = True
    projection: str = "position"
    cells: float = 10.0


SETTINGS = {"RRT": Settings(longest_s=10.0), "KPIECE1": Settings(longest_s=10.0), "EST": Settings()}
"""For each planner the best that `benchmarks.peers.tuning` found."""


class _Left(ob.ProjectionEvaluator):
    """Projects to the distance and the base's angle left to the goal, a state of 15 numbers."""

    def __init__(self, space: Any, goal: list[float]) -> None:
        super().__init__(space)
        self._goal = goal

    def getDimension(self) -> int:
        return 2

    def defaultCellSizes(self) -> None:
        """Leave them to be set."""

    def project(self, state: Any, out: Any) -> None:
        pose, (x, y, z, w, i, j, k) = state[0], self._goal[:7]
        q = pose.rotation()
        out[0] = math.dist((pose.getX(), pose.getY(), pose.getZ()), (x, y, z))
        out[1] = 2.0 * math.acos(min(1.0, abs(q.w * w + q.x * i + q.y * j + q.z * k)))


class _Propagator:
    """Moves OMPL's states; CasADi's function works on fixed buffers, which spares most of the call."""

    def __init__(self, model: Model) -> None:
        self._x, self._u, self._h, self._out = np.zeros(15), np.zeros(CONTROLS), np.zeros(1), np.zeros(15)
        self._function = model.step(1)
        self._buffer, self._run = self._function.buffer()
        for k, array in enumerate((self._x, self._u, self._h)):
            self._buffer.set_arg(k, memoryview(array))
        self._buffer.set_res(0, memoryview(self._out))

    def __call__(self, state: Any, control: Any, seconds: float, result: Any) -> None:
        self._x[:] = read(state)
        for k in range(CONTROLS):
            self._u[k] = control[k]
        self._h[0] = seconds
        self._run()
        write(result, self._out.tolist())


def read(state: Any) -> tuple[float, ...]:
    """Return the 15 numbers of an OMPL state."""
    pose, turns = state[0], (state[0].rotation(), state[1], state[2])
    return (pose.getX(), pose.getY(), pose.getZ(), *(x for q in turns for x in (q.w, q.x, q.y, q.z)))


def write(state: Any, x: list[float]) -> None:
    """Write 15 numbers into an OMPL state; quaternions are normalised."""
    state[0].setXYZ(x[0], x[1], x[2])
    for k, q in ((3, state[0].rotation()), (7, state[1]), (11, state[2])):
        length = (x[k] ** 2 + x[k + 1] ** 2 + x[k + 2] ** 2 + x[k + 3] ** 2) ** 0.5
        q.w = x[k] / length
        q.x = x[k + 1] / length
        q.y = x[k + 2] / length
        q.z = x[k + 3] / length


def _space(settings: Settings, reach: float) -> Any:
    """Return the state space, positions up to `reach` from the start on each axis."""
    bounds = ob.RealVectorBounds(3)
    bounds.setLow(-reach)
    bounds.setHigh(reach)
    base = ob.SE3StateSpace()
    base.setBounds(bounds)
    base.setSubspaceWeight(1, 2.0 * settings.base_weight)  # the distance on SO(3) is half the angle
    space = ob.CompoundStateSpace()
    space.addSubspace(base, 1.0)
    for _ in range(2):
        space.addSubspace(ob.SO3StateSpace(), 2.0 * settings.limb_weight)
    return space


def _project(settings: Settings, space: Any, first: np.ndarray, last: np.ndarray) -> Any:
    """Give the state space its projection and cells, and return the projection, which has to be kept."""
    sizes, left = [float(np.linalg.norm(last[:3] - first[:3]))] * 3, settings.projection == "left"
    if left:
        sizes = [sizes[0], 2.0 * math.acos(min(1.0, abs(float(first[3:7] @ last[3:7]))))]
    projection = _Left(space, last.tolist()) if left else ob.SubspaceProjectionEvaluator(space, 0)
    space.registerDefaultProjection(projection)
    space.setup()
    counted = projection if left else space.getSubspace(0).getDefaultProjection()  # of which the other's are a copy
    for k, size in enumerate(sizes):
        counted.setCellSizes(k, max(FINEST, size) / settings.cells)
    return projection


def answer(
    planner: str, settings: Settings, query: Query, cap_s: float, seed: int, clear: Callable[[Any], bool] | None = None
) -> Answer | None:
    """Return what a planner finds, exact or nearest, within a time; None if it finds nothing.

    Args:
        planner: RRT, KPIECE1 or EST.
        settings: How it is set.
        query: The query.
        cap_s: The processor time it has [s].
        seed: Of OMPL's random numbers.
        clear: Whether a state is clear of obstacles; None for empty water.
    """
    ou.setLogLevel(ou.LogLevel.LOG_ERROR)
    ou.RNG.setSeed(seed + 1)
    first, last = (state_of(c, query.swimmer.length_m) for c in (query.start, query.goal))
    space = _space(settings, max(settings.least_reach, REACH * float(np.linalg.norm(last[:3]))))
    controls = oc.RealVectorControlSpace(space, CONTROLS)
    bounds = ob.RealVectorBounds(CONTROLS)
    bounds.setLow(-1.0)
    bounds.setHigh(1.0)
    controls.setBounds(bounds)
    setup = oc.SimpleSetup(controls)
    info = setup.getSpaceInformation()
    propagator = _Propagator(Model(query.swimmer))
    info.setStatePropagator(propagator)
    info.setPropagationStepSize(settings.step_s)
    info.setMinMaxControlDuration(1, round(settings.longest_s / settings.step_s))
    checks = [info.satisfiesBounds, *([] if clear is None else [clear])]
    setup.setStateValidityChecker(lambda state: all(check(state) for check in checks))
    start, goal = space.allocState(), space.allocState()
    write(start, first.tolist())
    write(goal, last.tolist())
    setup.setStartAndGoalStates(start, goal, LOOSE * min(1.0, settings.base_weight, settings.limb_weight))
    projection = _project(settings, setup.getStateSpace(), first, last)
    chosen = getattr(oc, planner)(info)
    if planner == "RRT":
        chosen.setGoalBias(settings.goal_bias)
        chosen.setIntermediateStates(settings.intermediate)
    setup.setPlanner(chosen)
    over = time.process_time() + cap_s
    setup.solve(ob.PlannerTerminationCondition(lambda: time.process_time() > over))
    del projection
    if not setup.haveSolutionPath():
        return None
    path = setup.getSolutionPath()
    count = path.getControlCount()
    rates = np.array([[path.getControl(k)[i] for i in range(CONTROLS)] for k in range(count)]).reshape(-1, CONTROLS)
    return Answer(np.array(path.getControlDurations()), rates)
