"""OMPL's control planners RRT, KPIECE1 and EST.

State space: position (in units of L), base and limb orientations, as a compound of SE(3) and two SO(3); the distance
is the sum of the distance and the three angles. Controls: the six rates in [-1, 1] rad/s, held for 0.1 to 2 s, which
the planners choose. States are propagated by compiled CasADi expressions, Runge-Kutta steps of order four.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from benchmarks.peers.judge import LOOSE, Answer
from benchmarks.peers.model import CONTROLS, Model, state_of
from benchmarks.peers.queries import Query

STEP_S, MOST_STEPS = 0.1, 20
GOAL_BIAS = 0.1
"""Part of RRT's samples that are the goal; OMPL's default is 0.05."""
CELLS = 10
"""KPIECE1 and EST count states in cells of the base's position; as many of them are on the way to the goal."""


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
        x = self._x
        pose = state[0]
        x[0], x[1], x[2] = pose.getX(), pose.getY(), pose.getZ()
        for k, q in ((3, pose.rotation()), (7, state[1]), (11, state[2])):
            x[k], x[k + 1], x[k + 2], x[k + 3] = q.w, q.x, q.y, q.z
        for k in range(CONTROLS):
            self._u[k] = control[k]
        self._h[0] = seconds
        self._run()
        write(result, self._out.tolist())


def write(state: Any, x: list[float]) -> None:
    """Write 15 numbers into an OMPL state; quaternions are normalised."""
    state[0].setXYZ(x[0], x[1], x[2])
    for k, q in ((3, state[0].rotation()), (7, state[1]), (11, state[2])):
        length = (x[k] ** 2 + x[k + 1] ** 2 + x[k + 2] ** 2 + x[k + 3] ** 2) ** 0.5
        q.w = x[k] / length
        q.x = x[k + 1] / length
        q.y = x[k + 2] / length
        q.z = x[k + 3] / length


def _space(reach: float) -> Any:
    """Return the state space, positions up to `reach` from the start on each axis."""
    bounds = ob.RealVectorBounds(3)
    bounds.setLow(-reach)
    bounds.setHigh(reach)
    base = ob.SE3StateSpace()
    base.setBounds(bounds)
    space = ob.CompoundStateSpace()
    for part, weight in ((base, 1.0), (ob.SO3StateSpace(), 2.0), (ob.SO3StateSpace(), 2.0)):
        space.addSubspace(part, weight)  # the distance on SO(3) is half the angle
    return space


def answer(planner: str, query: Query, cap_s: float, seed: int) -> Answer | None:
    """Return what a planner finds, exact or nearest, within a time; None if it finds nothing.

    Args:
        planner: RRT, KPIECE1 or EST.
        query: The query.
        cap_s: The processor time it has [s].
        seed: Of OMPL's random numbers.
    """
    ou.setLogLevel(ou.LogLevel.LOG_ERROR)
    ou.RNG.setSeed(seed + 1)
    first, last = (state_of(c, query.swimmer.length_m) for c in (query.start, query.goal))
    space = _space(max(1.0, 1.5 * float(np.linalg.norm(last[:3]))))
    controls = oc.RealVectorControlSpace(space, CONTROLS)
    bounds = ob.RealVectorBounds(CONTROLS)
    bounds.setLow(-1.0)
    bounds.setHigh(1.0)
    controls.setBounds(bounds)
    setup = oc.SimpleSetup(controls)
    info = setup.getSpaceInformation()
    propagator = _Propagator(Model(query.swimmer))
    info.setStatePropagator(propagator)
    info.setPropagationStepSize(STEP_S)
    info.setMinMaxControlDuration(1, MOST_STEPS)
    setup.setStateValidityChecker(info.satisfiesBounds)
    start, goal = space.allocState(), space.allocState()
    write(start, first.tolist())
    write(goal, last.tolist())
    setup.setStartAndGoalStates(start, goal, LOOSE)
    cells = ob.SubspaceProjectionEvaluator(space, 0)
    space.registerDefaultProjection(cells)
    setup.getStateSpace().setup()
    for k in range(3):
        cells.setCellSizes(k, max(0.01, float(np.linalg.norm(last[:3])) / CELLS))
    chosen = getattr(oc, planner)(info)
    if planner == "RRT":
        chosen.setGoalBias(GOAL_BIAS)
        chosen.setIntermediateStates(True)
    setup.setPlanner(chosen)
    over = time.process_time() + cap_s
    setup.solve(ob.PlannerTerminationCondition(lambda: time.process_time() > over))
    if not setup.haveSolutionPath():
        return None
    path = setup.getSolutionPath()
    count = path.getControlCount()
    rates = np.array([[path.getControl(k)[i] for i in range(CONTROLS)] for k in range(count)]).reshape(-1, CONTROLS)
    return Answer(np.array(path.getControlDurations()), rates)
