"""The limbs' clearance and bends over a motion: the truth at every instant, found without looking at every one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import UNIT, YAW_1, assert_close, is_close, random_rotations, random_shapes, random_swimmer
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import (
    apart_bend_rad,
    clearances,
    least_clearance,
    limb_distance,
    segment_distance,
)
from purcell_cli.motion.limb_circles import LimbCircles, bends

TOUCHING = 2.0 * UNIT.radii_m[1]


def by_minimiser(gap: Array, first: Array, second: Array) -> float:
    """Return the distance of two segments, the parabola in (s, t) handed to scipy."""

    def square(at: Array) -> float:
        return float(np.sum((gap + at[0] * first - at[1] * second) ** 2))

    starts = [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.0, 1.0), (1.0, 0.0)]
    found = [minimize(square, s, bounds=[(0, 1), (0, 1)], method="L-BFGS-B", tol=1e-16) for s in starts]
    return math.sqrt(min(f.fun for f in found))


def turned(shapes: Array, rates: Array, times: Array) -> Array:
    """Return shapes after times, by scipy's rotation vectors. Shapes (m, 2, 3, 3), (m, 6), (m,)."""
    out = [
        shapes[:, i] @ Rotation.from_rotvec(rates[:, 3 * i : 3 * i + 3] * times[:, None]).as_matrix() for i in (0, 1)
    ]
    return np.stack(out, axis=1)


def finely(swimmer: Swimmer, shapes: Array, rates: Array, durations: Array) -> Array:
    """Return each piece's least clearance by dense sampling, three times finer round the least [m]."""
    low, high = np.zeros(len(durations)), durations
    least = np.full(len(durations), np.inf)
    for _ in range(5):
        times = np.linspace(low, high, 801, axis=1)
        many = [np.repeat(x, 801, axis=0) for x in (shapes, rates)]
        found = limb_distance(swimmer, turned(*many, times.ravel())[..., 0]).reshape(times.shape)
        k = np.argmin(found, axis=1)
        rows = np.arange(len(k))
        least = np.minimum(least, found[rows, k])
        low, high = times[rows, np.maximum(k - 2, 0)], times[rows, np.minimum(k + 2, 800)]
    return least


def random_pieces(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Return pieces of primitives, of both limbs at once, and of no motion."""
    rates = rng.normal(size=(count, 6))
    rates[::3] = np.eye(6)[rng.integers(0, 6, len(rates[::3]))]
    rates[1::9] = 0.0
    return random_shapes(rng, count), rates, rng.uniform(0.0, 4.0, count)


# --- Distance of segments ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_the_distance_of_segments_is_the_least_over_both(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gap, first, second = rng.normal(size=(3, 3))
    assert_close(segment_distance(gap, first, second), by_minimiser(gap, first, second), 1e-6)
    ends = [gap + s * first - t * second for s in (0, 1) for t in (0, 1)]
    assert segment_distance(gap, first, second) <= min(np.linalg.norm(e) for e in ends) + 1e-15


@pytest.mark.parametrize(
    ("gap", "first", "second", "distance"),
    [
        ((0, 3, 0), (1, 0, 0), (1, 0, 0), 3.0),
        ((0, 3, 0), (1, 0, 0), (-1, 0, 0), 3.0),
        ((5, 3, 0), (1, 0, 0), (1, 0, 0), 5.0),
        ((2, 0, 0), (1, 0, 0), (1, 0, 0), 1.0),
        ((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.0),
        ((-0.5, -0.5, 0.25), (1, 0, 0), (0, -1, 0), 0.25),
        ((-0.5, 0.5, 0.25), (1, 0, 0), (0, 1, 0), 0.25),
        ((3, 4, 0), (0, 0, 0), (0, 0, 0), 5.0),
        ((0.5, 2, 0), (0, 0, 0), (1, 0, 0), 2.0),
        ((0, 1e-3, 0), (1, 0, 0), (1, 1e-9, 0), 1e-3 - 1e-9),
    ],
)
def test_parallel_crossing_and_pointlike_segments(gap: Array, first: Array, second: Array, distance: float) -> None:
    found = segment_distance(*(np.array(v, dtype=float) for v in (gap, first, second)))
    assert_close(found, distance, 1e-12)


@given(angle=st.floats(1e-9, 1e-3), height=st.floats(0.0, 1.0))
def test_nearly_parallel_segments_that_cross_are_as_near_as_they_are(angle: float, height: float) -> None:
    first, second = np.array([2.0, 0.0, 0.0]), 2.0 * np.array([math.cos(angle), math.sin(angle), 0.0])
    gap = 0.5 * (second - first) + np.array([0.0, 0.0, height])
    assert_close(segment_distance(gap, first, second), height, 1e-12)


# --- Clearance of a shape ------------------------------------------------------------------------------------------


def test_the_clearance_of_known_shapes() -> None:
    """The foil: with the slenderness taken over the half length the limbs were thinner."""
    assert_close(limb_distance(UNIT, COLLINEAR[..., 0]), 2.0 - TOUCHING, 1e-15)
    assert TOUCHING == 2.0 * 0.01 * 2.0
    square = np.stack([about_axis(2, 0.5 * math.pi), about_axis(2, -0.5 * math.pi)])
    assert_close(limb_distance(UNIT, square[..., 0]), 2.0 - TOUCHING, 1e-15)
    folded = np.stack([about_axis(2, math.pi), np.eye(3)])
    assert_close(limb_distance(UNIT, folded[..., 0]), -TOUCHING, 1e-12)
    crossed = np.stack([about_axis(2, math.radians(150)), about_axis(2, math.radians(-150))])
    assert_close(limb_distance(UNIT, crossed[..., 0]), -TOUCHING, 1e-12)
    apart = np.stack([about_axis(2, math.radians(150)), about_axis(2, math.radians(150))])
    assert_close(limb_distance(UNIT, apart[..., 0]), 1.0 - TOUCHING, 1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_a_common_roll_and_the_exchange_of_the_limbs_leave_the_clearance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer, shape = random_swimmer(rng), random_shapes(rng)
    found, size = limb_distance(swimmer, shape[..., 0]), swimmer.length_m
    rolled = about_axis(0, rng.uniform(-3, 3)) @ shape
    assert_close(limb_distance(swimmer, rolled[..., 0]), found, 1e-13, size)
    about = about_axis(2, math.pi)  # the same swimmer, seen from the other end
    exchanged = about @ shape[::-1] @ about
    assert_close(limb_distance(swimmer, exchanged[..., 0]), found, 1e-13, size)
    if found > 1.9 * swimmer.base_half_length_m:
        return  # the joints are nearest, whatever the limbs do
    pitched = about_axis(1, 0.3) @ shape
    assert not is_close(limb_distance(swimmer, pitched[..., 0]), found, 1e-13, size)


@pytest.mark.parametrize("seed", range(6))
def test_limbs_bent_no_further_than_they_may_stay_apart_and_further_they_do_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer = random_swimmer(rng)
    clearance = 0.2 * rng.random() * swimmer.base_half_length_m
    most = apart_bend_rad(swimmer, clearance)
    shapes = random_shapes(rng, 4000)
    shapes = shapes[np.all(np.arccos(shapes[..., 0, 0]) <= most, axis=1)]
    assert len(shapes) > 100
    assert np.min(limb_distance(swimmer, shapes[..., 0])) >= clearance - 1e-12 * swimmer.length_m
    if most < math.pi:
        facing = np.stack([about_axis(2, most + 0.01), about_axis(2, -most - 0.01)])
        assert limb_distance(swimmer, facing[..., 0]) < clearance
    else:  # limbs so short that none reaches the middle
        assert 2.0 * swimmer.limb_half_length_m < swimmer.base_half_length_m


# --- Clearance of a motion -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_the_least_clearance_is_that_of_every_instant(seed: int) -> None:
    """Looking at the ends of pieces alone is the foil."""
    rng = np.random.default_rng(seed)
    swimmer = random_swimmer(rng)
    shapes, rates, durations = random_pieces(rng, 27)
    wanted, size = finely(swimmer, shapes, rates, durations), swimmer.length_m
    found = least_clearance(swimmer, Pieces(shapes, rates, durations))
    assert_close(found.distance_m, np.min(wanted), 2e-9, size)
    assert found.error_m <= 1e-9 * size
    k, time = found.piece, np.array([found.time_s])
    there = turned(shapes[k : k + 1], rates[k : k + 1], time)
    assert_close(limb_distance(swimmer, there[..., 0]), [found.distance_m], 1e-13, size)
    assert_close(clearances(swimmer, Pieces(shapes, rates, durations))[0], wanted, 2e-9, size)
    near = clearances(swimmer, Pieces(shapes, rates, durations), 0.0)[0]
    assert np.array_equal(near < 0.0, wanted < 0.0)
    ends = [limb_distance(swimmer, turned(shapes, rates, t)[..., 0]).min() for t in (0.0 * durations, durations)]
    at_an_end = min(time[0], durations[k] - time[0]) < 1e-6
    assert found.distance_m == min(ends) if at_an_end else found.distance_m < min(ends)


def test_a_limb_that_passes_the_other_between_its_ends_is_seen() -> None:
    """Limb 1 yaws from 120 to 240 degrees through limb 2's joint; the ends of the move are far away."""
    shapes, rates = np.stack([about_axis(2, math.radians(120)), np.eye(3)])[None], np.eye(6)[[YAW_1]]
    found = least_clearance(UNIT, Pieces(shapes, rates, np.array([math.radians(120)])))
    assert_close(found.distance_m, -TOUCHING, 1e-8)
    assert_close(found.time_s, math.radians(60), 1e-8)


def test_a_turn_of_a_whole_circle_is_seen_though_it_ends_where_it_began() -> None:
    found = least_clearance(UNIT, Pieces(COLLINEAR[None], np.eye(6)[[YAW_1]], np.array([2.0 * math.pi])))
    assert_close(found.distance_m, -TOUCHING, 1e-8)


@pytest.mark.parametrize("limb", [0, 1])
def test_a_distance_that_stays_the_same_is_found_by_few_looks(limb: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One limb rests, folded; the joint of the other stays nearest to it on a part of a yaw, which folds, too."""
    rested = about_axis(2, math.radians(150)) @ about_axis(0, 0.3)
    moving = about_axis(2, math.radians(60)) @ about_axis(0, 0.7)
    shape = np.stack([rested, moving] if limb else [moving, rested])
    pieces = Pieces(shape[None], np.eye(6)[[YAW_1 + 3 * limb]], np.array([-2.0 + math.pi]))
    joint = math.sin(math.radians(30)) * 2.0 * UNIT.base_half_length_m  # to the axis of the limb that rests
    monkeypatch.setattr("purcell_cli.motion.clearance._MOST_STRETCHES", 64)
    found = least_clearance(UNIT, pieces)
    assert_close(found.distance_m, joint - TOUCHING, 1e-12)
    assert_close(finely(UNIT, pieces.shapes, pieces.rates, pieces.durations), [found.distance_m], 1e-9)
    assert found.error_m <= 1e-9


@given(roll=st.floats(-7.0, 7.0), bend=st.floats(-3.1, 3.1))
def test_a_roll_leaves_the_clearance(roll: float, bend: float) -> None:
    shapes = np.stack([about_axis(2, bend), np.eye(3)])[None]
    found = least_clearance(UNIT, Pieces(shapes, np.eye(6)[[0]], np.array([abs(roll)])))
    assert_close(found.distance_m, limb_distance(UNIT, shapes[0, ..., 0]), 1e-13)


# --- Bends ---------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_largest_bend_is_that_of_every_instant(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shapes, rates, durations = random_pieces(rng, 9)
    found, when = LimbCircles.of(Pieces(shapes, rates, durations)).largest_bends()
    times = np.linspace(0.0, durations, 301, axis=1)
    many = [np.repeat(x, 301, axis=0) for x in (shapes, rates)]
    sampled = bends(turned(*many, times.ravel())[..., 0]).reshape(9, 301, 2).max(axis=1)
    assert np.all(found >= sampled - 1e-12)
    between = np.linalg.norm(rates.reshape(9, 2, 3), axis=-1) * durations[:, None] / 300
    assert np.all(found <= sampled + between)
    for limb in (0, 1):
        there = turned(shapes, rates, when[:, limb])[:, limb, :, 0]
        assert_close(bends(there), found[:, limb], 1e-7)


@pytest.mark.parametrize(
    ("bend", "angle", "largest"),
    [
        (0.0, 2.0 * math.pi, math.pi),
        (0.3, -0.5, 0.3),
        (0.3, -0.8, 0.5),
        (0.3, 0.4, 0.7),
        (0.0, 0.0, 0.0),
        (3.0, 1.0, math.pi),
    ],
)
def test_the_largest_bend_of_a_yaw_is_where_it_passes_furthest(bend: float, angle: float, largest: float) -> None:
    """A whole turn ends where it began; looking at the ends alone is the foil."""
    shapes = np.stack([about_axis(2, bend), np.eye(3)])[None]
    rates = math.copysign(1.0, angle) * np.eye(6)[[YAW_1]]
    found, _ = LimbCircles.of(Pieces(shapes, rates, np.array([abs(angle)]))).largest_bends()
    assert_close(found[0], [largest, 0.0], 1e-12)


def test_axes_sweep_on_circles() -> None:
    rng = np.random.default_rng(0)
    shapes, rates, durations = random_rotations(rng, 9, 2), rng.normal(size=(9, 6)), rng.uniform(0, 4, 9)
    sweeps = LimbCircles.of(Pieces(shapes, rates, durations))
    assert_close(sweeps.at(np.arange(9), durations), turned(shapes, rates, durations)[..., 0], 1e-14)
    later = sweeps.at(np.arange(9), durations + 1e-6) - sweeps.at(np.arange(9), durations - 1e-6)
    assert_close(np.linalg.norm(later, axis=-1) / 2e-6, sweeps.speed, 1e-8)
