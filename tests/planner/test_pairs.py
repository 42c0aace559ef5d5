"""Pairs of phases 1 and 3: what they leave to phase 2 is what the exact flow says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import assert_close, missed, random_shapes

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
from purcell_cli.kernel.pairs import PriceNumbers, pair_prices
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.planner.limbs.pairs import LimbPairs, OuterPhases, best_pairs
from purcell_cli.planner.limbs.straightening import straightenings

WANTED = se3.pose(from_euler((0.3, -0.2, 0.1)), np.array([1.0, 0.5, -0.2]))
THIN = dataclasses.replace(
    Swimmer(), base_half_length_m=0.147, limb_half_length_m=0.477, slenderness=4e-4, drag_ratio=4.0
).scaled()
"""A limb of this that unfolds sweeps past the line of the base in a small part of the rotation."""
FOLDED = np.stack([from_euler((0.0, 0.0, np.pi)), from_euler((np.pi - np.radians(1.0), 0.0, 0.0))])
"""Limb 1 straight, but half a turn about its axis; limb 2 folded back, 1 degree beside the base."""


def pairs_of(swimmer: Swimmer, start: Array, goal: Array) -> LimbPairs:
    outer = OuterPhases(*straightenings(swimmer, (start, goal)))
    return best_pairs(outer, WANTED, PriceNumbers(turn2=1.0, way=1.0), 12)


def off(swimmer: Swimmer, pairs: LimbPairs, start: Array) -> float:
    """Return the most by which a pair and what it leaves to phase 2 miss the displacement together [L, rad]."""
    ends = []
    for k, (i, j) in enumerate(pairs.index.tolist()):
        before = flow(swimmer, pairs.ways.first.sequence(i), start)
        after = flow(swimmer, pairs.ways.last.sequence(j).inverse(), COLLINEAR)
        ends.append(missed(before @ pairs.missing[k] @ after, WANTED))
    return max(ends)


def test_ways_that_sweep_past_the_line_are_worked_out_anew() -> None:
    found = pairs_of(THIN, FOLDED, COLLINEAR)
    assert off(THIN, found, FOLDED) > 0.1  # what the search compares them by is not enough
    assert off(THIN, found.checked(THIN, (FOLDED, COLLINEAR), WANTED), FOLDED) < 1e-5


def test_ways_that_are_right_stay_as_they_are() -> None:
    rng, body = np.random.default_rng(4), Swimmer().scaled()
    start, goal = random_shapes(rng), random_shapes(rng)
    found = pairs_of(body, start, goal)
    assert np.array_equal(found.checked(body, (start, goal), WANTED).missing, found.missing)
    assert off(body, found, start) < 1e-2


@pytest.mark.parametrize("seed", range(5))
def test_prices_of_pairs_are_those_of_numpy_and_the_least_are_found(seed: int) -> None:
    """Of displacements one after the other; the least skip most pairs by a bound, a wrong one would miss some."""
    rng = np.random.default_rng(seed)
    twists = rng.normal(size=(2, 30, 6)) * rng.uniform(0.0, 2.0, (2, 30, 1))
    first, second = se3.exp(twists)
    spent = rng.uniform(0.0, 3.0, (2, 30))
    price = PriceNumbers(*rng.uniform(0.1, 2.0, 8))
    whole = first[:, None] @ second[None]
    turn, way = np.arccos(np.clip(whole[..., 0, 0], -1.0, 1.0)), np.linalg.norm(whole[..., :3, 3], axis=-1)
    aside = np.minimum(np.linalg.norm(whole[..., 1:3, 3], axis=-1) * price.scale, price.most)
    under = price.turn2 * turn**2 + price.turn1 * turn + price.aside * aside + price.way1 * way
    wanted = np.sqrt(under) * price.root + price.way * way + spent[0][:, None] + spent[1]
    assert_close(pair_prices(first, second, *spent, price), wanted, 1e-9)
    assert_close(pair_prices(first, second, *spent, price, 1), wanted.min(axis=1), 1e-9)
    assert_close(pair_prices(first, second, *spent, price, 2), wanted.min(axis=0), 1e-9)
    both = np.concatenate([pair_prices(first, second, *spent, price, k) for k in (1, 2)])
    assert np.array_equal(pair_prices(first, second, *spent, price, 3), both)
    few = pair_prices(first, second, *spent, price, most=float(np.median(wanted)))
    cheap = wanted < np.median(wanted)
    assert_close(few[cheap], wanted[cheap], 1e-9)
    assert np.any(np.isinf(few))
    assert not np.any(few[~cheap] < np.median(wanted) - 1e-9)
    with pytest.raises(ValueError, match="an array of shape"):
        pair_prices(first, second[:-1], *spent, price)
    with pytest.raises(ValueError, match="least_of"):
        pair_prices(first, second, *spent, price, 4)
