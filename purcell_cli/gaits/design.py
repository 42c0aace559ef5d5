"""The designer: closed strokes that do most for what they cost, by gradients of the exact lift from many starts.

From each start sequential quadratic programming (scipy's SLSQP) maximises displacement over cost,
with purity and closure as equations and the bend limit as inequalities. Joint travel has kinks
where a joint rests; they are rounded off less and less. The best stroke found is made exact by
Newton's method. Nothing says that it is the best there is. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from purcell_cli.errors import GaitError, ParameterError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.atlas import Entry, entry
from purcell_cli.gaits.design_problem import DesignTask, Problem, Values
from purcell_cli.gaits.gait import Gait, Turn
from purcell_cli.gaits.joint_fit import refuse_bends
from purcell_cli.gaits.shape_curves import WayPoints, size_rad
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import EXACT, SEARCHING
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

_SMOOTHING = (3e-2, 3e-3, 3e-4)
"""Sizes below which |angle| is rounded off, one search after the other [rad]."""

_ITERATIONS = 120
"""Iterations of SLSQP in each search: with 40 the ratio changes in its eighth digit, with 400 not at all."""

_GAIN = 1e-8
"""SLSQP stops when the scaled ratio gains less: 1e-6 costs 3e-7 of the ratio, 1e-10 gains nothing."""

_SCALE = 100.0
"""What the ratio is multiplied by for SLSQP, whose tolerances suit numbers near 1: it is of the order of 0.01."""

_NEARLY = 1e-5
"""Cross-talk, closure and excess bend (L, rad) of a search that found a stroke; Newton's method removes the rest."""

_PURE = 1e-11
"""Cross-talk and closure (L, rad) of a stroke that is handed out: a hundredth of a certificate's tolerances."""

_OVER_RAD = 1e-6
"""By how much a limb may bend beyond the limit [rad]: the summary names the limit to six digits."""

_IDLE_RAD = 1e-9
"""Moves whose turns are all smaller are left out of a curve [rad]."""

_LONGEST_RAD = 1.5
"""Longest turn of a limb in one move of a curve [rad]: half of what `straight_moves` takes for the shortest way."""

Progress = Callable[[int, str], None]
"""Takes how many starts are over, and the ratio of the best in words."""


@frozen_dataclass(eq=False)
class Designed:
    """The best stroke that was found.

    Attributes:
        task: What was asked for.
        gait: The stroke as a gait.
        entry: What one cycle of it does and costs.
        ratio: Displacement per joint travel [L/rad or rad/rad].
        largest_bend_rad: How far a limb bends at any instant [rad].
        starts: How many starts were carried through.
        seed: Seed of the starts.
    """

    task: DesignTask
    gait: Gait
    entry: Entry
    ratio: float
    largest_bend_rad: float
    starts: int
    seed: int


def _start(problem: Problem, rng: np.random.Generator) -> Array:
    """Return a random loop of bends of the limbs as unknowns. Shape (n,)."""
    task, n = problem.task, problem.task.moves
    if task.controls == "primitive":
        unknown = rng.uniform(0.3, 1.0, int(problem.free.sum())) * task.max_bend_rad
        sign = np.array([(-1.0) ** (k // 2) for k in range(len(unknown) - problem.lead)])
        signs = np.concatenate([rng.choice([-0.5, 0.5], problem.lead), rng.choice([-1.0, 1.0]) * sign])
        return np.asarray(unknown * signs)
    phase = 2.0 * np.pi * np.arange(n + 1) / n
    size = task.max_bend_rad * rng.uniform(0.4, 0.9)
    vectors = np.zeros((n + 1, 2, 3))
    if task.axis is not None:
        shift, growth, turn = rng.uniform(-0.4, 0.4, 2), rng.uniform(0.6, 1.0, 2), rng.uniform(0.0, 2.0 * np.pi)
        lobes = rng.choice([1, 2])  # an ellipse, or a figure of eight, whose two areas cancel
        ring = growth * np.stack([np.cos(phase), rng.choice([-1.0, 1.0]) * np.sin(lobes * phase)], axis=-1)
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        vectors[..., task.axis] = size * (shift + ring @ turned.T)
        turns = np.diff(vectors, axis=0)
    else:
        for harmonic in (1, 2):
            wave = np.stack([np.cos(harmonic * phase), np.sin(harmonic * phase)])
            vectors[..., 1:] += np.einsum("pn,plk->nlk", wave, rng.normal(size=(2, 2, 2))) * size / harmonic**1.5 / 1.5
        vectors[..., 1:] += 0.3 * size * rng.normal(size=(2, 2))
        shapes = se3.rotation(vectors)
        turns = as_vector(np.swapaxes(shapes[:-1], -1, -2) @ shapes[1:])
    return np.asarray(np.concatenate([vectors[:1], turns]).reshape(n + 1, 6)[problem.free])


class _Search:
    """The functions that SLSQP asks for, each point computed once."""

    def __init__(self, problem: Problem, smooth_rad: float, accuracy: Accuracy) -> None:
        self.problem, self.smooth_rad, self.accuracy = problem, smooth_rad, accuracy
        self._point = np.empty(0)
        self._values: Values | None = None

    def _at(self, unknown: Array) -> Values:
        if self._values is None or not np.array_equal(unknown, self._point):
            self._point, self._values = unknown.copy(), self.problem.at(unknown, self.smooth_rad, self.accuracy)
        return self._values

    def run(self, unknown: Array) -> Array:
        """Return the unknowns at the end of a search, which may have failed [rad]. Shape (n,) to (n,)."""
        from scipy.optimize import minimize  # slow to import

        def loss(u: Array) -> tuple[float, Array]:
            v = self._at(u)
            return -_SCALE * v.gain / v.cost, -_SCALE * (v.gain_slope - v.gain / v.cost * v.cost_slope) / v.cost

        limits = [
            {"type": "eq", "fun": lambda u: self._at(u).gap, "jac": lambda u: self._at(u).gap_slope},
            {"type": "ineq", "fun": lambda u: self._at(u).room, "jac": lambda u: self._at(u).room_slope},
        ]
        options = {"maxiter": _ITERATIONS, "ftol": _GAIN}
        found = minimize(loss, unknown, jac=True, method="SLSQP", constraints=limits, options=options)
        return np.asarray(found.x)


def _searched(problem: Problem, unknown: Array) -> Array | None:
    """Return a local optimum near a start, or None where the search breaks down."""
    for smooth_rad in _SMOOTHING if problem.task.maximize == "speed" else _SMOOTHING[-1:]:
        unknown = _Search(problem, smooth_rad, SEARCHING).run(unknown)
        if not np.all(np.isfinite(unknown)) or np.max(np.abs(unknown)) > 2.0 * np.pi:
            return None
    values = problem.at(unknown, _SMOOTHING[-1])
    good = np.max(np.abs(values.gap)) < _NEARLY and np.min(values.room) > -_NEARLY and values.gain > 0.0
    return unknown if good else None


def _made_exact(problem: Problem, unknown: Array) -> Array | None:
    """Return the unknowns changed least so that the stroke is pure and closes, or None."""
    for _ in range(8):
        values = problem.at(unknown, _SMOOTHING[-1], EXACT)
        if np.max(np.abs(values.gap)) < _PURE:
            return unknown
        unknown = unknown - np.linalg.lstsq(values.gap_slope, values.gap, rcond=1e-9)[0]
    return None


def _largest_bend(problem: Problem, unknown: Array) -> float:
    moves = problem.sequence(problem.turns(unknown))
    circles = LimbCircles.of(Pieces.of(moves))
    return float(np.max(circles.largest_bends()[0]))


def _within(problem: Problem, unknown: Array) -> tuple[Problem, Array] | None:
    """Return the stroke searched on and made exact, with a tighter limit until its bends keep the one wanted."""
    limit = problem.task.max_bend_rad
    for _ in range(4):
        exact = _made_exact(problem, unknown)
        if exact is None:
            return None
        over = _largest_bend(problem, exact) - limit
        if over <= _OVER_RAD:
            return problem, exact
        tighter = problem.task.max_bend_rad - 1.05 * over - _OVER_RAD
        if tighter <= 0.0:
            return None
        problem = dataclasses.replace(problem, task=dataclasses.replace(problem.task, max_bend_rad=tighter))
        again = _searched(problem, exact)
        if again is None:
            return None
        unknown = again
    return None


def _way_points(problem: Problem, turns: Array) -> WayPoints:
    """Return the corners of the cycle; moves that are long for a rotation vector are halved."""
    axis = problem.task.axis
    if axis is not None:
        return WayPoints(np.cumsum(turns, axis=0)[:-1])
    moved = turns[problem.lead :]
    parts = np.ceil(np.max(np.linalg.norm(moved.reshape(-1, 2, 3), axis=-1), axis=1) / _LONGEST_RAD)
    count = np.maximum(parts, 1).astype(np.int64)
    fine = np.repeat(moved / count[:, None], count, axis=0)
    start = problem.sequence(turns).shapes(COLLINEAR)[problem.lead]
    return WayPoints(as_vector(MoveSequence.of_turns(fine).shapes(start)[:-1]).reshape(-1, 6))


def _gait(problem: Problem, unknown: Array, name: str, source: str) -> Gait:
    """Return a stroke as a gait: a curve, or primitives whose amplitude scales all angles."""
    task, turns = problem.task, problem.turns(unknown)
    plane = "planar" if task.planar else "spatial"
    what = {"speed": "joint travel", "efficiency": "dissipation"}[task.maximize]
    summary = f"a {plane} stroke of much {task.direction} for its {what}, bends within {task.max_bend_rad:g} rad"
    if task.controls == "simultaneous":
        moved = np.max(np.abs(turns), axis=1) > _IDLE_RAD
        moved[: problem.lead] = True
        curve = _way_points(problem, turns[moved])
        means = "largest turn of a limb from the collinear shape"
        return Gait(name, summary, "none", "a", means, size_rad(curve), (), source=source, curve=curve)
    joints, angles = np.argmax(problem.free, axis=1).tolist(), turns[problem.free].tolist()
    every = [Turn(j, {"a": angle}) for j, angle in zip(joints, angles, strict=True)]
    approach, cycle = tuple(every[: problem.lead]), tuple(every[problem.lead :])
    return Gait(name, summary, "none", "a", "scale of all angles", 1.0, cycle, approach, source=source)


def design(
    swimmer: Swimmer,
    task: DesignTask,
    name: str = "designed",
    starts: int = 4,
    seed: int = 0,
    progress: Progress = lambda _done, _news: None,
) -> Designed:
    """Return the best stroke found from a number of random starts; an interrupt ends the search with the best so far.

    Args:
        swimmer: The swimmer; the task has its own bend limit.
        task: What is wanted.
        name: The gait's name.
        starts: How many starts.
        seed: Seed of the starts.
        progress: Is called with how far the search is.

    Raises:
        ParameterError: No start, or more than 10,000; or joints that cannot play what is wanted.
        GaitError: No start led to a stroke.
        KeyboardInterrupt: Interrupted before any stroke was found.
    """
    refuse_types(swimmer=(swimmer, Swimmer), task=(task, DesignTask))
    if not 1 <= starts <= 10_000:
        raise ParameterError(f"starts: a whole number at least 1 and at most 10000 is wanted, found {starts}")
    refuse_bends(swimmer, task.axis, task.max_bend_rad)
    rng = np.random.default_rng(seed)
    best: tuple[float, Problem, Array] | None = None
    done = 0
    try:
        for done in range(starts):
            progress(done, "none yet" if best is None else _in_words(task, best[0]))
            found = _from(Problem.of(task, swimmer, rng), rng)
            if found is not None and (best is None or found[0] > best[0]):
                best = found
        done = starts
    except KeyboardInterrupt:
        if best is None:
            raise
    if best is None:
        raise GaitError(f"none of {starts} starts led to a stroke along {task.direction}; try more, or another seed")
    _, problem, unknown = best
    source = f"designed: {task.maximize} along {task.direction}, {task.controls} controls, seed {seed}, {done} starts"
    gait = _gait(dataclasses.replace(problem, task=task), unknown, name, source)
    gain = problem.at(unknown, _SMOOTHING[-1], EXACT).gain
    ratio = gain / problem.travel(unknown)
    return Designed(task, gait, entry(gait, swimmer), ratio, _largest_bend(problem, unknown), done, seed)


def _from(problem: Problem, rng: np.random.Generator) -> tuple[float, Problem, Array] | None:
    """Return the value, problem and unknowns of the local optimum near a random start, or None."""
    with np.errstate(all="ignore"):
        unknown = _searched(problem, _start(problem, rng))
        found = None if unknown is None else _within(problem, unknown)
    if found is None:
        return None
    tightened, exact = found
    try:
        _gait(tightened, exact, "", "")
    except ParameterError:  # a limb rolls half round: no rotation vectors tell such moves
        return None
    values = tightened.at(exact, _SMOOTHING[-1], EXACT)
    cost = tightened.travel(exact) if problem.task.maximize == "speed" else values.cost
    return values.gain / cost, tightened, exact


def _in_words(task: DesignTask, value: float) -> str:
    if task.maximize == "efficiency":
        return f"{value:.5f} L per effort"
    return f"{np.degrees(value):.4f} deg/rad" if task.turns else f"{value:.5f} L/rad"
