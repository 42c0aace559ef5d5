"""The steerable needle: its arcs and its last roll compose to the displacement, and cost no more than plain ways."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from helpers import assert_close, is_close, missed, random_rotations
from reference import steering as reference

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.kernel.steering import steered
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.needle_steering import Arcs, steer

COMPOSED = 1e-3
"""What a way may miss its displacement by [L, rad]: chains of loops settle it."""
STARTS = 48


def wanted() -> Array:
    """Return displacements near and far, in any direction, with and without a turn. Shape (7, 4, 4)."""
    rng = np.random.default_rng(4)
    plain = [
        se3.pose(np.eye(3), [3.0, 0.0, 0.0]),
        se3.pose(np.eye(3), [0.0, -2.0, 1.0]),
        se3.pose(about_axis(2, 1.0), np.zeros(3)),
    ]
    far = [se3.pose(random_rotations(rng), size * rng.normal(size=3)) for size in (0.1, 1.0, 5.0, 30.0)]
    return np.stack([*plain, *far])


@functools.cache
def the_fan() -> Fan:
    return fan(Swimmer().scaled(), "travel", False)


@functools.cache
def found() -> Arcs:
    return steer(wanted(), the_fan(), STARTS)


def composed(arc: Array, roll: float) -> Array:
    """Return what arcs and a last roll make. Shapes (m, 3) and () to (4, 4)."""
    out = np.eye(4)
    for advance, p, q in arc:
        out = out @ se3.exp(np.array([advance, 0.0, 0.0, 0.0, p, q]))
    return out @ se3.pose(about_axis(0, roll), np.zeros(3))


def cost(arc: Array) -> Array:
    """Return the joint travel of ways. Shape (n, m, 3) to (n,)."""
    return the_fan().cost(arc[..., 0], np.hypot(arc[..., 1], arc[..., 2])).sum(axis=-1)


def test_arcs_and_the_last_roll_compose_to_the_displacement() -> None:
    ways = found()
    for arc, roll, k in zip(ways.arc, ways.roll, ways.displacement, strict=True):
        assert missed(wanted()[k], composed(arc, float(roll))) < COMPOSED


@pytest.mark.parametrize("across", [False, True])
def test_the_kernel_steers_as_numpy_does(across: bool) -> None:
    """Most beginnings end at the same arcs; with tighter loops, the foil, hardly any does."""
    loops, rng = fan(Swimmer().scaled(), "travel", across), np.random.default_rng(9)
    inverse = np.repeat(se3.inverse(wanted()), 6, axis=0)
    begun = rng.normal(size=(len(inverse), 10))
    given = loops.straight, loops.tight, *loops.reach
    x, off = steered(*given, inverse, begun)
    asked, missing = reference.steered(inverse, begun, loops)
    alike = np.max(np.abs(x - asked), axis=1) < 1e-6 * np.maximum(1.0, np.max(np.abs(asked), axis=1))
    assert np.mean(alike) > 0.9  # a few chase each other round, and rounding errors grow
    assert np.max(np.abs(off - missing)[alike]) < 1e-6
    other = steered(loops.straight, 2.0 * loops.tight, *loops.reach, inverse, begun)[0]
    assert np.mean(np.max(np.abs(other - asked), axis=1) < 1e-6) < 0.3


def test_steering_refuses_what_makes_no_sense() -> None:
    good = [0.05, 0.01, [0.0, 1.5], [1.0, 1.0], np.eye(4)[None], np.zeros((1, 10))]
    assert steered(*good)[0].shape == (1, 10)
    for k, wrong in ((0, 0.0), (1, np.nan), (2, [0.0]), (3, [1.0]), (4, np.eye(4)), (5, np.zeros((1, 9)))):
        with pytest.raises(ValueError, match="wanted"):
            steered(*(wrong if j == k else part for j, part in enumerate(good)))


def test_arcs_in_the_wrong_order_or_with_the_roll_before_them_do_not() -> None:
    """The foils, for the displacements in any direction."""
    ways = found()
    others = [k for k in range(len(ways.roll)) if ways.displacement[k] >= 3]
    backwards = [missed(wanted()[ways.displacement[k]], composed(ways.arc[k][::-1], ways.roll[k])) for k in others]
    early = [
        missed(
            wanted()[ways.displacement[k]],
            se3.pose(about_axis(0, ways.roll[k]), np.zeros(3)) @ composed(ways.arc[k], 0.0),
        )
        for k in others
    ]
    assert np.mean(np.array(backwards) > 10 * COMPOSED) > 0.9
    assert np.mean(np.array(early) > 10 * COMPOSED) > 0.9


def test_every_displacement_is_made_from_many_starts() -> None:
    counts = np.bincount(found().displacement, minlength=len(wanted()))
    assert np.all(counts > STARTS / 4)


def test_the_best_way_costs_no_more_than_to_turn_go_straight_and_turn_again() -> None:
    """And less by far where there is more to do than one of these."""
    gains = []
    for k, d in enumerate(wanted()):
        way = d[:3, 3]
        far = float(np.linalg.norm(way))
        plain = []
        for sign in (1.0, -1.0):
            ahead = sign * way / far if far > 0.0 else np.array([1.0, 0.0, 0.0])
            first = math.acos(np.clip(ahead[0], -1.0, 1.0))
            last = math.acos(np.clip(ahead @ d[:3, 0], -1.0, 1.0))
            plain.append(float(cost(np.array([[[0.0, first, 0.0], [far, 0.0, 0.0], [0.0, last, 0.0]]]))[0]))
        best = float(np.min(cost(found().arc[found().displacement == k])))
        assert best <= min(plain) * (1.0 + 1e-3) + 1e-2
        gains.append(min(plain) / max(best, 1e-9))
    assert max(gains) > 1.1


@pytest.mark.slow
def test_each_way_costs_the_least_that_arcs_of_its_kind_can() -> None:
    """Small changes of the arcs that keep the displacement cost no less, but for a little: the search ends soon."""
    rng = np.random.default_rng(1)
    ways, step = found(), 1e-2
    mine = [np.flatnonzero(ways.displacement == k) for k in (4, 5)]
    best = [int(rows[np.argmin(cost(ways.arc[rows]))]) for rows in mine]
    for k in best:
        x = np.append(ways.arc[k].ravel(), ways.roll[k])

        def residual(x: Array, k: int = k) -> Array:
            d = wanted()[ways.displacement[k]]
            return se3.log(se3.normalised(se3.inverse(d) @ composed(x[:9].reshape(3, 3), float(x[9]))))

        slope = np.array([(residual(x + h) - residual(x - h)) / 2e-6 for h in 1e-6 * np.eye(10)]).T
        free = np.linalg.svd(slope)[2][6:]
        here = float(cost(x[:9].reshape(1, 3, 3))[0])
        for direction in rng.normal(size=(40, len(free))) @ free:
            y = x + step * direction / np.linalg.norm(direction)
            for _ in range(3):
                y = y - np.linalg.pinv(slope) @ (residual(y) - residual(x))
            assert float(cost(y[:9].reshape(1, 3, 3))[0]) > 0.99 * here


def test_the_same_seed_finds_the_same_ways_and_another_seed_others() -> None:
    again, other = (steer(wanted(), the_fan(), STARTS, seed) for seed in (0, 1))
    assert_close(again.arc, found().arc, 0.0)
    assert other.arc.shape != found().arc.shape or not is_close(other.arc, found().arc, 1e-3)


@pytest.mark.parametrize("starts", [1, 2, 5])
def test_few_starts_are_the_plain_ways_first(starts: int) -> None:
    ways = steer(wanted()[:1], the_fan(), starts)
    assert len(ways.roll) >= 1
    assert_close(ways.arc[0].sum(axis=0), [3.0, 0.0, 0.0], COMPOSED)
