"""Least steps under equations and bounds: they hold what they must, and none that does is shorter."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import assert_close, is_close
from scipy.optimize import lsq_linear

from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.linear import least_steps
from purcell_cli.planner.refine.active_set import bounded_step, loose

FAR = 1e9
"""A reach that cuts no step [rad]."""


def problem(seed: int, bends: int = 4) -> tuple[Array, Array, Array, Array]:
    """Return a random arrival, what is missing, the room left, of which some is negative, and its derivative."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(8, 20)), rng.normal(size=8), rng.normal(size=bends), rng.normal(size=(bends, 20))


def brute_force(arrival: Array, missing: Array, room: Array, slope: Array) -> Array:
    """Return the least step by trying every set of inequalities as equations. Shape (n,)."""
    weight = loose(arrival)
    best, least = np.zeros(arrival.shape[1]), np.inf
    sets = [itertools.combinations(range(len(room)), k) for k in range(len(room) + 1)]
    for some in itertools.chain.from_iterable(sets):
        rows = np.concatenate([arrival, slope[list(some)]]) * weight
        step = np.linalg.lstsq(rows, -np.concatenate([missing, room[list(some)]]), rcond=None)[0]
        if np.all(room + slope @ (weight * step) >= -1e-9) and step @ step < least:
            best, least = weight * step, float(step @ step)
    assert np.isfinite(least)
    return best


@pytest.mark.parametrize("seed", range(12))
def test_a_step_that_one_bend_may_bind_arrives_keeps_it_and_is_the_least(seed: int) -> None:
    """Against both sets of bends tried; the least step without bends, the foil, breaks it where it binds."""
    arrival, missing, room, slope = problem(seed, 1)
    step = bounded_step(arrival, missing, room, slope, FAR)
    assert_close(arrival @ step, -missing, 1e-9)
    assert np.all(room + slope @ step >= -1e-9)
    assert_close(step, brute_force(arrival, missing, room, slope), 1e-7)
    free = bounded_step(arrival, missing, np.empty(0), np.empty((0, 20)), FAR)
    assert np.all(room + slope @ free >= -1e-9) == is_close(free, step, 1e-8)


@pytest.mark.parametrize("seed", range(12))
def test_a_step_that_many_bends_may_bind_arrives_keeps_them_and_is_not_much_longer(seed: int) -> None:
    """Than the least of all sets of bends tried, by a seventh at most: it ends at the first set that keeps them all."""
    arrival, missing, room, slope = problem(seed, 4)
    step = bounded_step(arrival, missing, room, slope, FAR)
    assert_close(arrival @ step, -missing, 1e-9)
    assert np.all(room + slope @ step >= -1e-9)
    found, least = (np.linalg.norm(x / loose(arrival)) for x in (step, brute_force(arrival, missing, room, slope)))
    assert least * (1.0 - 1e-9) <= found <= least * (1.0 + 1.0 / 7.0)


@pytest.mark.parametrize("bends", [1, 4])
def test_of_these_problems_some_have_bends_that_bind_and_some_do_not(bends: int) -> None:
    binding = []
    for seed in range(12):
        arrival, missing, room, slope = problem(seed, bends)
        step = bounded_step(arrival, missing, room, slope, FAR)
        binding.append(int(np.sum(np.abs(room + slope @ step) < 1e-8)))
    assert max(binding) >= (bends + 1) // 2
    assert min(binding) < max(binding)


def test_without_bends_a_step_is_the_least_by_weight() -> None:
    """An angle that moves the base by much changes by less; the plain least step, the foil, is another."""
    arrival, missing, *_ = problem(3)
    arrival[:6, :5] *= 30.0
    step = bounded_step(arrival, missing, np.empty(0), np.empty((0, 20)), FAR)
    weight = loose(arrival)
    assert_close(step, weight * np.linalg.lstsq(arrival * weight, -missing)[0], 1e-10)
    assert not is_close(step, np.linalg.lstsq(arrival, -missing)[0], 1e-3)
    assert np.all(weight[:5] < weight[5:].min())


@pytest.mark.parametrize("reach", [1e-3, 0.25])
def test_a_step_that_is_too_long_is_cut_and_keeps_its_direction(reach: float) -> None:
    arrival, missing, room, slope = problem(0)
    whole, cut = (bounded_step(arrival, missing, room, slope, r) for r in (FAR, reach))
    assert np.max(np.abs(cut)) == pytest.approx(min(reach, float(np.max(np.abs(whole)))))
    assert_close(cut * np.max(np.abs(whole)), whole * np.max(np.abs(cut)), 1e-12)


def test_equations_that_depend_on_each_other_are_met_as_far_as_they_can() -> None:
    """The same equation twice, and one that no angle changes."""
    arrival, missing, *_ = problem(5)
    twice, wanted = np.concatenate([arrival, arrival[:1]]), np.append(missing, missing[0])
    found = bounded_step(twice, wanted, np.empty(0), np.empty((0, 20)), FAR)
    once = bounded_step(arrival, missing, np.empty(0), np.empty((0, 20)), FAR)
    assert_close(found, once, 1e-7)
    arrival[7] = 0.0
    found = bounded_step(arrival, missing, np.empty(0), np.empty((0, 20)), FAR)
    assert_close(arrival[:7] @ found, -missing[:7], 1e-7)


def test_nothing_missing_takes_no_step() -> None:
    arrival, _, room, slope = problem(1)
    assert_close(bounded_step(arrival, np.zeros(8), np.abs(room), slope, FAR), np.zeros(20), 1e-15)


def boxes(seed: int, n: int = 10, k: int = 20) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return several random problems of six equations between bounds, with a solution strictly between."""
    rng = np.random.default_rng(seed)
    columns, inside = rng.normal(size=(n, 6, k)), rng.uniform(-0.5, 0.5, (n, k))
    wanted, begun = (columns @ inside[..., None])[..., 0], 0.5 * rng.normal(size=(n, k))
    return columns, wanted, begun, rng.uniform(0.3, 2.0, (n, k)), np.full((n, k), -1.0), np.full((n, k), 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_least_steps_meet_their_equations_between_the_bounds_and_are_the_nearest(seed: int) -> None:
    """Against least squares with bounds, in which the equations weigh a million times as much."""
    columns, wanted, begun, loosely, low, high = boxes(seed)
    steps = least_steps(columns, wanted, begun, loosely, low, high)
    assert np.all((steps >= low) & (steps <= high))
    met = np.max(np.abs((columns @ steps[..., None])[..., 0] - wanted), axis=1) < 1e-4
    assert np.mean(met) >= 0.8
    assert np.any(np.abs(steps[met]) == 1.0)
    for k in np.flatnonzero(met):
        weight = loosely[k] ** -0.5
        rows = np.concatenate([1e6 * columns[k], np.diag(weight)])
        sides = np.concatenate([1e6 * wanted[k], weight * begun[k]])
        known = lsq_linear(rows, sides, (low[k], high[k]), method="bvls", tol=1e-14).x
        assert_close(steps[k], known, 2e-3)
        assert not is_close(np.clip(begun[k], low[k], high[k]), known, 1e-2)


def test_bounds_that_do_not_bind_leave_the_nearest_step_of_all() -> None:
    columns, wanted, begun, loosely, *_ = boxes(9)
    steps = least_steps(columns, wanted, begun, loosely, np.full_like(begun, -1e6), np.full_like(begun, 1e6))
    for k in range(len(steps)):
        root = np.sqrt(loosely[k])
        missing = wanted[k] - columns[k] @ begun[k]
        assert_close(steps[k], begun[k] + root * np.linalg.lstsq(columns[k] * root, missing)[0], 1e-3)


def test_what_may_not_change_does_not() -> None:
    columns, wanted, begun, loosely, low, high = boxes(2)
    low[:, :3] = high[:, :3] = 0.25
    steps = least_steps(columns, wanted, begun, loosely, low, high)
    assert_close(steps[:, :3], np.full((len(steps), 3), 0.25), 0.0)
