"""Pairs of phases 1 and 3: what they leave to phase 2 is what the exact flow says."""

from __future__ import annotations

import dataclasses

import numpy as np
from helpers import missed, random_shapes

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
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
    return best_pairs(outer, WANTED, lambda heading, distance, _aside: heading + distance, 12)


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
