"""Closed ways round a bent shape: each closes, keeps the limits, and moves the base by what it says."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from helpers import assert_close, is_close, largest_bends, missed, nearest, random_shapes

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.motion.limb_circles import bends
from purcell_cli.planner.limbs.shape_loops import ShapeLoops, shape_loops
from purcell_cli.planner.limbs.straightening import straightenings

ROUGH = 8e-4
"""What the displacements of eight turns may be off by [L, rad]: eight times the error that is stated for one."""

BODY = Swimmer().scaled()
SHAPE = np.stack([about_axis(2, 2.0) @ about_axis(1, 0.3), about_axis(1, -1.5) @ about_axis(0, 0.4)])


@functools.cache
def found() -> ShapeLoops:
    return shape_loops(BODY, [SHAPE])[0]


def test_every_loop_closes() -> None:
    """Three of its four sides, the foil, do not."""
    assert len(found().sequence) > 20
    for loop in found().sequence:
        assert_close(loop.shapes(SHAPE)[-1], SHAPE, 1e-14)
        assert not is_close(loop[: len(loop) - 1].shapes(SHAPE)[-1], SHAPE, 0.1)


def test_every_loop_moves_the_base_by_what_it_says() -> None:
    """On the exact flow; a loop gone through the other way round, the foil, undoes it."""
    for k in range(0, len(found().sequence), 3):
        loop, does = found().sequence[k], found().displacement[k]
        assert missed(does, flow(BODY, loop, SHAPE)) < ROUGH
        assert missed(se3.inverse(does), flow(BODY, loop.inverse(), SHAPE)) < ROUGH
        assert missed(does, se3.inverse(does)) > 10 * ROUGH
        assert loop.joint_travel_rad == pytest.approx(found().joint_travel_rad[k], abs=1e-12)


def test_with_each_loop_come_its_inverse_and_both_gone_round_twice() -> None:
    n = len(found().sequence) // 4
    once, back, twice, back_twice = (found().sequence[k * n : (k + 1) * n] for k in range(4))
    for a, b, c, d in zip(once, back, twice, back_twice, strict=True):
        assert list(b) == list(a.inverse())
        assert list(c) == list(a.times(2))
        assert list(d) == list(b.times(2))


def test_no_limb_bends_further_than_it_does_or_than_the_limit() -> None:
    limit = np.maximum(BODY.max_bend_rad, bends(SHAPE[..., 0])) + 1e-8
    for loop in found().sequence:
        assert np.all(largest_bends(loop, SHAPE) <= limit)


@pytest.mark.parametrize("bend", [0.0, 1.29])
def test_round_limbs_that_are_bent_little_there_are_none(bend: float) -> None:
    """Unless the bend limit lets them bend further: the foil."""
    shape = np.stack([about_axis(2, bend), about_axis(1, -bend)])
    assert len(shape_loops(BODY, [shape])[0].sequence) == 0
    assert len(shape_loops(Swimmer(max_bend_rad=1.7).scaled(), [shape])[0].sequence) > 0


def test_the_limbs_stay_as_far_apart_as_asked() -> None:
    swimmer, apart = Swimmer(0.1, 0.2).scaled(), 0.5
    shape = random_shapes(np.random.default_rng(31))
    free, kept = (shape_loops(swimmer, [shape], c)[0] for c in (0.0, apart))
    assert 0 < len(kept.sequence) < len(free.sequence)
    assert all(nearest(swimmer, loop, shape) >= apart - 1e-6 for loop in kept.sequence)
    assert min(nearest(swimmer, loop, shape) for loop in free.sequence) < apart - 0.1


def test_before_a_straightening_a_loop_adds_what_it_does() -> None:
    ways = straightenings(BODY, [SHAPE])[0][np.arange(3)]
    more = found().before(ways)
    n, m = len(found().sequence), len(ways)
    assert len(more) == (n + 1) * m
    for k in range(m, len(more), 7):
        which, way = divmod(k - m, m)
        sequence = more.sequence(k)
        assert list(sequence) == [*found().sequence[which], *ways.sequence(way)]
        assert_close(sequence.shapes(SHAPE)[-1], COLLINEAR, 1e-14)
        assert sequence.joint_travel_rad == pytest.approx(more.joint_travel_rad[k], abs=1e-12)
        assert missed(more.displacement[k], flow(BODY, sequence, SHAPE)) < 2 * ROUGH
    assert [list(more.sequence(k)) for k in range(m)] == [list(ways.sequence(k)) for k in range(m)]
    again = found().before(more[np.array([m])])
    assert list(again.sequence(n)) == [*found().sequence[-1], *found().sequence[0], *ways.sequence(0)]
