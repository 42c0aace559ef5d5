"""The certificate: the replay of controls against other integrators, what it says of its own error, and the verdict."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from helpers import dop853_rates, mostly_slow, random_shapes

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import certificate
from purcell_cli.mechanics.bead_table import tabulated
from purcell_cli.solution import Solution
from purcell_cli.verification import extrapolation
from purcell_cli.verification import replay as replaying
from purcell_cli.verification.certificate import judged
from purcell_cli.verification.replay import Replay, replay

THIN = Swimmer(base_half_length_m=0.1, limb_half_length_m=0.25, slenderness=1e-3, drag_ratio=3.5)
STOUT = Swimmer(base_half_length_m=0.05, limb_half_length_m=0.02, slenderness=0.05, drag_ratio=1.5)


def controls(seed: int, pieces: int = 6, largest_rad: float = 0.8) -> tuple[Array, Array]:
    """Return random rates of both limbs, each for a time, and the times."""
    random = np.random.default_rng(seed)
    rates = random.uniform(-1.0, 1.0, (pieces, 6))
    times = np.concatenate([[0.0], np.cumsum(random.uniform(0.05, largest_rad, pieces))])
    return times, np.concatenate([rates, np.zeros((1, 6))])


def squares(cycles: int, side_rad: float, off_rad: float) -> tuple[Array, Array]:
    """Return cycles of a square of both limbs' yaws, after each of which limb 1 is off by a little more."""
    rates = np.zeros((4, 6))
    rates[[0, 1, 2, 3], [2, 5, 2, 5]] = (1.0, 1.0, -1.0, -1.0)
    once = side_rad + off_rad * np.array([1.0, 0.0, 0.0, 0.0])
    times = np.concatenate([[0.0], np.cumsum(np.tile(once, cycles))])
    return times, np.concatenate([np.tile(rates, (cycles, 1)), np.zeros((1, 6))])


BENT = Configuration.from_angles((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 3.0, 0.0))
"""A limb pitched by a little, past which the squares roll the base sharply."""


def apart(first: Array, second: Array, length_m: float) -> float:
    """Return the larger of the distance of two poses' positions, in units of L, and of their rotations' entries."""
    off = np.abs(np.asarray(first, dtype=np.float64) - np.asarray(second, dtype=np.float64))
    return float(max(np.max(off[:3, 3]) / length_m, np.max(off[:3, :3])))


@pytest.mark.parametrize("swimmer", [Swimmer(), THIN, STOUT], ids=["paper", "thin", "stout"])
@pytest.mark.parametrize("seed", mostly_slow(range(3), 0))
def test_a_replay_ends_where_dop853_does(swimmer: Swimmer, seed: int) -> None:
    times, rates = controls(seed)
    start = Configuration.from_angles((0.1, -0.2, 0.3), (20.0, -30.0, 40.0), (10.0, 40.0, 0.0), (-15.0, 5.0, 60.0))
    found = replay(swimmer, start, times, rates)
    wanted = dop853_rates(swimmer, rates[:-1], np.diff(times), start.shape, start.pose)
    assert apart(found.end.pose, wanted, swimmer.length_m) < 2e-11
    mirrored = dop853_rates(swimmer, -rates[:-1], np.diff(times), start.shape, start.pose)
    assert apart(found.end.pose, mirrored, swimmer.length_m) > 1e-3


@pytest.mark.parametrize("swimmer", [Swimmer(), THIN, STOUT], ids=["paper", "thin", "stout"])
@pytest.mark.parametrize("count", [1, 2, 7])
def test_pieces_in_doubles_are_those_in_extended_precision(swimmer: Swimmer, count: int) -> None:
    """The kernel's against numpy's; pieces twice as long, the foil, go elsewhere."""
    rng = np.random.default_rng(count)
    shapes, rates = random_shapes(rng, count), rng.uniform(-1.0, 1.0, (count, 6))
    unit, length = swimmer.scaled(), rng.uniform(0.01, 0.05, count)

    def found(precision: type, times: float = 1.0, by: Any = extrapolation._extrapolated) -> tuple[np.ndarray, ...]:
        turning = extrapolation.Turning.of(shapes.astype(precision), rates)
        return by(unit, turning, times * length.astype(precision), tabulated)

    exact = found(np.longdouble, by=extrapolation._in_numpy)
    for precision, most in ((np.float64, 1e-13), (np.longdouble, 500.0 * float(np.finfo(np.longdouble).eps))):
        for part, wanted, other in zip(found(precision), exact, found(precision, 2.0), strict=True):
            assert part.dtype == precision
            assert part.shape == wanted.shape == (count, 3, 4)
            assert np.max(np.abs(part - wanted)) < most
            assert np.max(np.abs(other - wanted)) > 1e-3


@pytest.mark.parametrize(
    ("steps", "places"),
    [([], []), ([2, 2], [0] * 4), ([1], [1]), ([1], [-1]), ([1, 2], [0]), ([*range(1, 10)], [0] * 45)],
)
def test_steps_that_make_no_sense_are_refused(steps: list[int], places: list[int]) -> None:
    axes, rates = np.tile(np.eye(3)[0][:, None], (2, 1, 2)), np.full((2, 3, 2), 0.1)
    with pytest.raises(ValueError, match="wanted"):
        certificate.extrapolated(np.ones((3, 7)), axes, rates, np.ones(2), [0.0], steps, places)
    with pytest.raises(ValueError, match="an array of shape"):
        certificate.extrapolated(np.ones((3, 7)), axes, rates, np.ones(3), [0.0], [1], [0])
    with pytest.raises(ValueError, match="turn no limb by more"):
        certificate.extrapolated(np.ones((3, 7)), axes, rates, np.full(2, 3.0), [0.0], [1], [0])


@pytest.mark.parametrize("swimmer", [Swimmer(), THIN, STOUT], ids=["paper", "thin", "stout"])
@pytest.mark.parametrize("seed", range(4))
def test_the_bound_holds_in_double_precision(swimmer: Swimmer, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    times, rates = controls(seed, 20, 0.3)
    monkeypatch.setattr(replaying, "_CARES", ((np.longdouble, 0.3),))
    exact = replay(swimmer, Configuration(), times, rates)
    monkeypatch.setattr(replaying, "_CARES", ((np.float64, 1.0),))
    found = replay(swimmer, Configuration(), times, rates)
    bound = max(found.bound.position_m / swimmer.length_m, found.bound.base_rad)
    assert apart(found.end_pose, exact.end_pose, swimmer.length_m) < bound < 1e-10
    monkeypatch.setattr(extrapolation, "_STEPS", (2, 4))
    extrapolation._times.cache_clear()
    coarse = replay(swimmer, Configuration(), times, rates)
    extrapolation._times.cache_clear()
    off = apart(coarse.end_pose, exact.end_pose, swimmer.length_m)
    assert 1e-9 < off < max(coarse.bound.position_m / swimmer.length_m, coarse.bound.base_rad)


@pytest.mark.parametrize("swimmer", [Swimmer(), THIN, STOUT], ids=["paper", "thin", "stout"])
@pytest.mark.parametrize("cycles", [1, 300])
def test_the_bound_holds_where_rounding_was_measured(
    swimmer: Swimmer, cycles: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In double precision, whose rounding shows; the same segments' errors add up over cycles."""
    times, rates = squares(cycles, 0.0625, 0.0)
    monkeypatch.setattr(replaying, "_CARES", ((np.longdouble, 0.3),))
    exact = replay(swimmer, BENT, times, rates)
    worst: list[float] = []
    for cares in (((np.float64, 0.3),), ((np.float64, 0.6), (np.float64, 0.3))):
        monkeypatch.setattr(replaying, "_CARES", cares)
        found = replay(swimmer, BENT, times, rates, tolerance_l=0.0, tolerance_rad=0.0)
        worst.append(max(found.bound.position_m / swimmer.length_m, found.bound.base_rad))
        assert apart(found.end_pose, exact.end_pose, swimmer.length_m) < worst[-1]
    assert worst[1] <= worst[0]


def test_rounding_that_was_measured_counts_for_less(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thin, long-limbed swimmer, whose rounding is far below the most there can be."""
    thin = Swimmer(base_half_length_m=0.01, limb_half_length_m=0.14, slenderness=1.6e-4, drag_ratio=1.05)
    times, rates = squares(2000, 0.0625, 0.0)
    ends, bounds = [], []
    for cares in (((np.longdouble, 0.3),), ((np.longdouble, 0.6), (np.longdouble, 0.3)), ((np.longdouble, 0.2),)):
        monkeypatch.setattr(replaying, "_CARES", cares)
        found = replay(thin, Configuration(), times, rates, tolerance_l=0.0, tolerance_rad=0.0)
        ends.append(found.end_pose)
        bounds.append(found.bound.base_rad)
    assert bounds[1] < 0.5 * bounds[0]
    assert apart(ends[1], ends[2], thin.length_m) < bounds[1]


def test_thousands_of_cycles_go_over_to_extended_precision() -> None:
    times, rates = squares(4000, 0.0625, 0.0)
    found = replay(THIN, BENT, times, rates)
    assert found.bound.within(1e-10 * THIN.length_m, 1e-10)
    assert np.max(found.moves.rounding) < 1e-14
    assert len(found.moves.fine) == 4


@pytest.mark.slow
def test_what_a_little_difference_of_shape_makes_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    times, rates = squares(150, 0.0625, 2.0**-40)
    monkeypatch.setattr(replaying, "_CARES", ((np.longdouble, 1.0),))
    once = replay(THIN, BENT, times, rates)
    monkeypatch.setattr(replaying, "_BATCH", 64)
    batched = replay(THIN, BENT, times, rates)
    np.testing.assert_allclose(batched.pose, once.pose, atol=1e-15)
    np.testing.assert_allclose(batched.shape, once.shape, atol=1e-15)
    monkeypatch.setattr(replaying, "_DRIFT_COUNTS", np.inf)
    without = replay(THIN, BENT, times, rates)
    monkeypatch.setattr(replaying, "_SAME_SHAPE_DIGITS", 40)
    each = replay(THIN, BENT, times, rates)
    assert len(each.moves.fine) == 600
    gap = apart(once.end_pose, each.end_pose, THIN.length_m)
    assert gap < 1e-13
    assert apart(without.end_pose, each.end_pose, THIN.length_m) > 1e-9


def test_differences_of_shape_are_counted_where_they_turn_the_base() -> None:
    """Each radian of a segment counts its difference: rows as fine as a file may have differ by rounding alone."""
    shapes = np.tile(np.eye(3), (3, 2, 1, 1))
    rates = np.tile([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (3, 1))
    which = np.repeat(np.arange(3), 1000)
    off = np.full((3000, 2, 3), 1e-19)
    off[which == 1] = 1e-12
    fine, coarse = np.full(3, 1e-3), np.ones(3)
    each = np.arange(3000)
    counted = replaying._drift(THIN, shapes, rates, coarse, which, off, each)
    assert np.any(counted[which == 1])
    assert not np.any(counted[which != 1])
    off[:] = 1e-18
    assert replaying._drift(THIN, shapes, rates, fine, which, off, each).shape == (0, 6)
    assert replaying._drift(THIN, shapes, rates, coarse, which, 100.0 * off, each).shape == (3000, 6)
    often = np.tile(np.arange(3), 1000)
    assert replaying._drift(THIN, shapes, rates, fine, which[::1000], 10.0 * off[::1000], often).shape == (0, 6)
    assert replaying._drift(THIN, shapes, rates, coarse, which[::1000], 100.0 * off[::1000], often).shape == (3000, 6)


def test_a_replay_goes_on_from_another() -> None:
    times, rates = controls(5)
    start = Configuration.from_angles((0.1, 0.0, 0.0), (30.0, 0.0, 0.0), (10.0, 0.0, 0.0))
    whole = replay(Swimmer(), start, times, rates)
    first = replay(Swimmer(), start, times[:4], rates[:4])
    rest = replay(Swimmer(), first, times[3:], rates[3:])
    assert apart(rest.end_pose, whole.end_pose, 0.1) < 1e-14
    np.testing.assert_allclose(rest.end.shape, whole.end.shape, atol=1e-15)


def made(error_rad: float, bound_rad: float) -> tuple[Replay, Configuration]:
    """Return a replay that ends so far from a goal, and may be wrong by so much."""
    times, rates = controls(1)
    found = replay(Swimmer(), Configuration(), times, rates)
    rounding = np.full(len(found.moves.fine), bound_rad / len(found.which))
    moves = dataclasses.replace(found.moves, rough=found.moves.fine, rounding=rounding)
    end = found.end
    turned = end.pose @ Configuration.from_angles((0.0, 0.0, 0.0), (float(np.degrees(error_rad)), 0.0, 0.0)).pose
    return dataclasses.replace(found, moves=moves), Configuration(turned, end.shape)


@pytest.mark.parametrize(
    ("error_rad", "bound_rad", "reached"),
    [(9e-10, 0.0, True), (9e-10, 5e-11, True), (9e-10, 2e-10, False), (1.1e-9, 0.0, False), (0.0, 2e-9, False)],
)
def test_reached_means_that_error_and_bound_are_within_the_tolerance(
    error_rad: float, bound_rad: float, reached: bool
) -> None:
    found, goal = made(error_rad, bound_rad)
    certificate = judged(found, goal, 1e-6, 1e-9)
    assert certificate.reached is reached
    assert np.isclose(certificate.bound.base_rad, bound_rad, rtol=1e-6)


def test_a_plan_whose_rows_are_elsewhere_is_not_reached() -> None:
    goal = Configuration.from_angles((0.01, 0.0, 0.0), (20.0, 0.0, 0.0))
    solution = plan(Configuration(), goal, options=PlanOptions(effort="quick"))
    assert solution.verdict == "reached"
    assert solution.rows_off.within(1e-11, 1e-10)
    rows = solution.trajectory
    pose = rows.pose.copy()
    pose[1:, 0, 3] += 1.1e-10
    moved = Solution(solution.plan, solution.options, solution.replay, solution.limits)
    moved.__dict__["trajectory"] = dataclasses.replace(rows, pose=pose)
    assert moved.certificate.reached
    assert moved.verdict == "not reached"


@pytest.mark.slow
def test_a_limb_that_passes_the_straight_line_in_the_middle_of_a_segment_is_not_passed_over() -> None:
    start = Configuration.from_angles((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (20.0, 0.03, 0.0), (0.0, 0.0, 0.0))
    times, rates = np.array([0.0, 0.7]), np.array([[0.0, 0.0, -1.0, 0.0, 0.0, 0.0], np.zeros(6)])
    found = replay(THIN, start, times, rates)
    wanted = dop853_rates(THIN, rates[:-1], np.diff(times), start.shape, start.pose)
    assert abs(np.degrees(np.arccos(np.clip(wanted[1, 1], -1.0, 1.0)))) > 1.0
    assert apart(found.end.pose, wanted, THIN.length_m) < 1e-10
