"""Descent within a trust region: it reaches a minimum, never goes up, and ends when nothing is promised."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable

import numpy as np
from helpers import assert_close

from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.refine.trust_region import descended

STEPS = 400


@dataclasses.dataclass(frozen=True)
class Point:
    x: Array
    merit: float


def at(x: Array) -> Point:
    """Return a place in Rosenbrock's valley, which bends and is flat along its floor."""
    return Point(x, float(100.0 * (x[1] - x[0] ** 2) ** 2 + (1.0 - x[0]) ** 2))


def proposed(here: Point, reach: float) -> tuple[Array, float]:
    """Return the end of a Gauss-Newton step cut to a reach, and the merit of the linear model there."""
    x = here.x
    residual = np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])
    slope = np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])
    step = np.linalg.solve(slope, -residual)
    step *= min(1.0, reach / float(np.max(np.abs(step), initial=1e-300)))
    return x + step, float(np.sum((residual + slope @ step) ** 2))


def plain(_: Point, x: Array, promised: float, reach: float) -> Point:
    return at(x)


def nothing(_: Point) -> float:
    return 0.0


def watched(
    start: Point, land: Callable[[Point, Array, float, float], Point]
) -> tuple[Point, list[Point], list[float]]:
    """Return where a descent ends, the points it proposed from, and the reaches it proposed within."""
    froms: list[Point] = []
    reaches: list[float] = []

    def propose(here: Point, reach: float) -> tuple[Array, float]:
        froms.append(here)
        reaches.append(reach)
        return proposed(here, reach)

    return descended(start, propose, land, STEPS, nothing)[0], froms, reaches


def test_it_reaches_the_minimum_and_never_goes_up() -> None:
    end, froms, _ = watched(at(np.array([-1.2, 1.0])), plain)
    assert_close(end.x, [1.0, 1.0], 1e-6)
    assert np.all(np.diff([p.merit for p in froms]) <= 0.0)


def test_the_reach_grows_where_the_model_is_true_and_shrinks_where_it_is_not() -> None:
    _, froms, reaches = watched(at(np.array([-1.2, 1.0])), plain)
    moved = [b is not a for a, b in itertools.pairwise(froms)]
    steps = list(zip(itertools.pairwise(reaches), moved, strict=True))
    assert all(after < before for (before, after), went in steps if not went)
    assert any(after > before for (before, after), _ in steps)
    assert max(reaches) <= 0.5


def test_landings_that_are_no_better_leave_it_where_it_began() -> None:
    """The reach shrinks until it is given up; the foil of landing at what is proposed moves."""
    start = at(np.array([-1.2, 1.0]))
    end, froms, reaches = watched(start, lambda here, x, *_: Point(x, here.merit + 1.0))
    assert end is start
    assert all(p is start for p in froms)
    assert len(reaches) < 20
    assert np.all(np.diff(reaches) < 0.0)
    assert descended(start, proposed, plain, 1, nothing)[0] is not start


def test_it_ends_where_nothing_is_found_or_nothing_worth_it_is_promised() -> None:
    start = at(np.array([-1.2, 1.0]))
    assert descended(start, lambda *_: None, plain, STEPS, nothing)[0] is start
    minimum = at(np.array([1.0, 1.0]))
    assert descended(minimum, proposed, plain, STEPS, nothing)[0] is minimum
    told: list[float] = []

    def land(_: Point, x: Array, promised: float, reach: float) -> Point:
        told.append(promised)
        return at(x)

    descended(start, proposed, land, STEPS, lambda here: 0.1 * here.merit)
    assert told[-1] < 0.1 * start.merit
    assert len(told) < STEPS


def test_no_more_steps_are_made_than_allowed() -> None:
    told: list[Array] = []

    def land(_: Point, x: Array, promised: float, reach: float) -> Point:
        told.append(x)
        return at(x)

    for steps in (0, 1, 3):
        told.clear()
        descended(at(np.array([-1.2, 1.0])), proposed, land, steps, nothing)
        assert len(told) == steps
