"""Convex programs of blocks: the least cost that other solvers find, and nothing that is no program."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from convex_programs import random_program
from helpers import mostly_slow
from scipy.optimize import linprog, minimize

from purcell_cli.kernel.convex import Blocks, least


@pytest.mark.parametrize("seed", range(40))
def test_linear_programs_are_those_of_highs(seed: int) -> None:
    """The least cost, within the accuracy asked for; where it begins, the foil, costs more."""
    given = random_program(seed)
    found = given.solved()
    assert found is not None
    m, n = len(given.wanted), len(given.begun)
    missed = np.concatenate([-np.eye(m), np.eye(m)[:, : given.equal]], axis=1)
    columns = np.concatenate([given.rows, missed], axis=1)
    wall = np.concatenate([given.wall, np.zeros((len(given.bound), missed.shape[1]))], axis=1)
    best = linprog(
        np.concatenate([given.blocks.cost, np.full(missed.shape[1], given.price)]),
        A_ub=np.concatenate([wall, columns[given.equal :]]),
        b_ub=np.concatenate([given.bound, given.wanted[given.equal :]]),
        A_eq=columns[: given.equal] if given.equal else None,
        b_eq=given.wanted[: given.equal] if given.equal else None,
        bounds=[(None, None)] * n + [(0.0, None)] * missed.shape[1],
    )
    assert abs(given.cost(found) - best.fun) < 1e-7 * (1.0 + given.price)
    assert given.cost(given.begun) > best.fun + 1e-3
    assert np.all(given.wall @ found <= given.bound + 1e-12)


@pytest.mark.parametrize("seed", mostly_slow([38, 0, 1], 1))
def test_quadratic_programs_cost_least(seed: int) -> None:
    """No random point within the walls costs less, and a search of another kind from it finds nothing better."""
    given = random_program(seed, curved=True)
    found = given.solved()
    assert found is not None
    assert np.all(given.wall @ found <= given.bound + 1e-12)
    least_cost = given.cost(found)
    rng = np.random.default_rng(seed)
    for _ in range(300):
        other = found + 10.0 ** rng.uniform(-4, 0) * rng.normal(size=len(found))
        if np.all(given.wall @ other <= given.bound):
            assert given.cost(other) > least_cost - 1e-7 * (1.0 + abs(least_cost))
    inside = {"type": "ineq", "fun": lambda y: given.bound - given.wall @ y}
    quickly = {"rhobeg": 0.01, "tol": 1e-9, "maxiter": 400}
    searched = minimize(given.cost, found, method="COBYLA", constraints=[inside], options=quickly)
    assert searched.fun > least_cost - 1e-6 * (1.0 + abs(least_cost))
    assert given.cost(given.begun) > least_cost + 1e-4


def test_no_rows_and_no_blocks_are_programs_too() -> None:
    wall = np.array([[1.0], [-1.0]])
    found = least(Blocks.of([wall], [0], [1.0]), [1.0, 0.5], np.empty((0, 0)), [], 0, 1.0, [0.0], 1e-10)
    assert found is not None
    assert abs(found[0] + 0.5) < 1e-9
    empty = Blocks.of([], [], [])
    assert least(empty, [], np.empty((0, 2)), [1.0, -1.0], 1, 1.0, [], 1e-6) is not None


def test_a_begin_on_a_wall_or_beyond_finds_nothing() -> None:
    given = random_program(1)
    for far in (0.0, 1.0):
        assert dataclasses.replace(given, bound=given.wall @ given.begun - far).solved() is None


def test_what_is_no_program_is_refused() -> None:
    good = random_program(4)
    blocks = good.blocks
    for name, number in (("bound", np.nan), ("across", np.inf), ("wanted", np.nan), ("begun", np.inf)):
        with pytest.raises(ValueError, match="finite"):
            dataclasses.replace(good, **{name: np.full_like(getattr(good, name), number)}).solved()
        with pytest.raises(ValueError, match="wanted"):
            dataclasses.replace(good, **{name: getattr(good, name)[:-1]}).solved()
    for name, value in (("price", 0.0), ("price", np.nan), ("equal", -1), ("equal", 99)):
        with pytest.raises(ValueError, match="wanted"):
            dataclasses.replace(good, **{name: value}).solved()
    with pytest.raises(ValueError, match="accuracy"):
        good.solved(0.0)
    for change in (
        {"sizes": blocks.sizes + 1},
        {"sizes": -blocks.sizes},
        {"cost": blocks.cost[:-1]},
        {"cost": np.full_like(blocks.cost, np.nan)},
        {"curve": np.zeros(1)},
        {"start": blocks.start + 1},
        {"start": blocks.start[::-1]},
        {"column": blocks.column + 6},
        {"column": -blocks.column - 1},
        {"column": blocks.column[:-1]},
        {"entry": blocks.entry[:-1]},
        {"entry": np.full_like(blocks.entry, np.inf)},
    ):
        with pytest.raises(ValueError, match="wanted"):
            dataclasses.replace(blocks, **change)
