"""Joints whose rates may not jump: which trajectories they can follow in time, and what becomes of others."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import assert_close
from scipy.optimize import linprog

from purcell_cli.cli.reports.gait import gait_document
from purcell_cli.feedback.simulate import simulate
from purcell_cli.feedback.track import track
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.motion.pace import paced
from purcell_cli.motion.trajectory import Trajectory, as_table, sample
from purcell_cli.verification.joints_kept import follow
from purcell_cli.verification.time_law import TimeLaw
from purcell_cli.verification.verify import verify

YAW = Joint("hinge", "yaw")
RAMPED = Swimmer(joint_acceleration_rad_s2=3.0)


def _followed(swimmer: Swimmer, rows: Trajectory) -> bool:
    return follow(swimmer, rows.time_s, Pieces(rows.shape, rows.rate_rad_s, np.append(np.diff(rows.time_s), 0.0)))


def _accelerating(swimmer: Swimmer, acceleration: float | None) -> Swimmer:
    return dataclasses.replace(swimmer, joint_acceleration_rad_s2=acceleration)


def _rates(swimmer: Swimmer, mean: np.ndarray, lasts: np.ndarray) -> str | None:
    """Return what is wrong with the rates of limb 1's yaw hinge."""
    rates = np.zeros((len(mean) + 1, 6))
    rates[:-1, 2] = mean
    shapes = np.broadcast_to(COLLINEAR, (len(rates), 2, 3, 3))
    times = np.append(0.0, np.cumsum(lasts))
    return TimeLaw(swimmer).fault(0, times, Pieces(shapes, rates, np.append(lasts, 0.0)))


@pytest.mark.parametrize("kind", ["ball", "universal", "hinge"])
def test_ramps_are_followed_at_their_acceleration_and_not_at_less_however_fine_the_rows(kind: str) -> None:
    joint = Joint(kind, "yaw" if kind == "hinge" else None)
    swimmer = Swimmer(joints=(dataclasses.replace(joint, rate_rad_s=0.5), joint), joint_acceleration_rad_s2=3.0)
    first, second = (6, 7) if kind == "universal" else (2, 5)
    loop = PrimitiveSequence.of([(first, 0.6), (second, 0.2), (first, -0.6), (second, -0.2)])
    blocks = [Block(2, "any", loop, 2)]
    pace, made = paced(swimmer, COLLINEAR, blocks)
    for dt_s in (0.004, 0.05, 10.0):
        rows = sample(pace, Configuration(), made, dt_s)
        assert _followed(swimmer, rows)
        assert not _followed(_accelerating(swimmer, 2.999), rows)
        jumps = sample(Swimmer(joint_rate_rad_s=0.5), Configuration(), blocks, dt_s)
        assert not _followed(swimmer, jumps)
        assert _followed(_accelerating(swimmer, None), jumps)


def _possible(mean: np.ndarray, lasts: np.ndarray, acceleration: float, most: float) -> bool:
    """Return whether a piecewise linear rate, from rest to rest and in one sense in each row, has these means."""
    parts = 24
    n = parts * len(mean) + 1
    row = np.repeat(np.arange(len(mean)), parts)
    step = lasts[row] / parts
    slopes = (np.eye(n)[1:] - np.eye(n)[:-1]) / step[:, None]
    halves = 0.5 * (np.eye(n)[1:] + np.eye(n)[:-1])
    means = np.stack([halves[row == k].mean(axis=0) for k in range(len(mean))])
    low, high = np.full(n, -most), np.full(n, most)
    for k, m in enumerate(mean):
        own = slice(k * parts, (k + 1) * parts + 1)
        low[own] = np.maximum(low[own], 0.0 if m >= 0.0 else -most)
        high[own] = np.minimum(high[own], 0.0 if m <= 0.0 else most)
    low[[0, -1]] = high[[0, -1]] = 0.0
    both = np.concatenate([slopes, -slopes])
    found = linprog(
        np.zeros(n), both, np.full(len(both), acceleration), means, mean, bounds=np.column_stack([low, high])
    )
    return bool(found.status == 0)


def test_what_can_be_followed_is_what_a_linear_program_finds_a_rate_for() -> None:
    rng = np.random.default_rng(0)
    swimmer = Swimmer(joints=(YAW, YAW))
    told = {True: 0, False: 0}
    for _ in range(120):
        count = int(rng.integers(2, 6))
        lasts = rng.uniform(0.1, 0.6, count)
        mean = rng.uniform(-0.2, 1.0, count) * rng.choice([1.0, 0.3])
        mean[rng.random(count) < 0.15] = 0.0
        found = _rates(_accelerating(swimmer, 4.0), mean, lasts) is None
        told[found] += 1
        # The program's rates have corners at some times only, so it needs a little more acceleration.
        if found:
            assert _possible(mean, lasts, 4.2, 1.005)
        else:
            assert not _possible(mean, lasts, 4.0, 1.0)
    assert min(told.values()) > 15


def test_a_gait_is_played_with_ramps_and_verified_with_them() -> None:
    stroke = realise(stored_gaits()["x-motion"], RAMPED, 0.5)
    rows = sample_stroke(RAMPED, Configuration(), stroke, 2)
    plain = sample_stroke(Swimmer(), Configuration(), stroke, 2)
    assert_close(rows.end.pose, plain.end.pose, 1e-13)
    told = gait_document(stored_gaits()["x-motion"], stroke, RAMPED, 2, None)
    assert_close(told["duration_s"], float(rows.time_s[-1]), 1e-9)
    assert told["duration_s"] > float(plain.time_s[-1]) + 1.0
    angles = stroke.played(2).duration
    wanted = np.where(angles > 1.0 / 3.0, angles + 1.0 / 3.0, 2.0 * np.sqrt(angles / 3.0))
    assert_close(told["duration_s"], float(np.sum(wanted)), 0.02)
    faults = verify([as_table(rows)], Configuration(), plain.end, RAMPED, 1e-9, 1e-9).faults
    assert faults == ()
    (fault,) = verify([as_table(plain)], Configuration(), plain.end, RAMPED, 1e-9, 1e-9).faults
    assert "line 2 (t = 0 s): limb 2's yaw cannot turn by 0.5 rad in 0.5 s after the rows before" in fault
    assert "its limits are 3 rad/s^2 and 1 rad/s" in fault


def test_parts_of_a_file_are_judged_as_the_whole() -> None:
    stroke = realise(stored_gaits()["x-motion"], RAMPED, 0.5)
    rows = sample_stroke(RAMPED, Configuration(), stroke, 1)
    lasts = np.append(np.diff(rows.time_s), 0.0)
    for acceleration, holds in ((3.0, True), (2.9, False)):
        law, told = TimeLaw(_accelerating(RAMPED, acceleration)), []
        for low in range(0, len(lasts) - 1, 7):
            part = slice(low, min(low + 8, len(lasts)))
            mine = lasts[part].copy()
            mine[-1] = 0.0
            told.append(law.fault(low, rows.time_s[part], Pieces(rows.shape[part], rows.rate_rad_s[part], mine)))
        assert (set(told) == {None}) == holds


def test_the_steps_of_a_ramp_are_one_turn_where_it_is_taken_more_slowly() -> None:
    """From rest to rest at each step, the foil, would take several times as long."""
    stroke = realise(stored_gaits()["x-motion"], Swimmer(), 0.5)
    gentle = Swimmer(joint_acceleration_rad_s2=1.5)
    rows, wanted = (sample_stroke(swimmer, Configuration(), stroke, 2) for swimmer in (RAMPED, gentle))
    found = simulate(as_table(rows), gentle)
    assert found.slower_s > 1.0
    assert_close(float(found.trajectory.time_s[-1]), float(wanted.time_s[-1]), 0.1)
    assert_close(found.end.pose, rows.end.pose, 1e-12)
    assert _followed(gentle, found.trajectory)


def test_joints_that_cannot_follow_a_file_take_its_path_more_slowly() -> None:
    stroke = realise(stored_gaits()["x-motion"], Swimmer(), 0.5)
    rows = sample_stroke(Swimmer(), Configuration(), stroke, 2)
    same, slower = (simulate(as_table(rows), swimmer) for swimmer in (Swimmer(), RAMPED))
    assert same.slower_s == 0.0
    assert np.array_equal(same.trajectory.time_s, rows.time_s)
    wanted = float(sample_stroke(RAMPED, Configuration(), stroke, 2).time_s[-1])
    assert_close(slower.slower_s, wanted - float(rows.time_s[-1]), 0.02)
    assert_close(slower.end.pose, rows.end.pose, 1e-12)
    assert max(loss.position_m for loss in slower.losses) < 1e-12
    assert_close(slower.losses[-1].ends_s, float(slower.trajectory.time_s[-1]), 1e-12)
    assert _followed(RAMPED, slower.trajectory)
    assert not _followed(RAMPED, same.trajectory)
    # Its rows are no longer than the file's, but for joints that would take ever so many.
    longest, lame = np.max(np.diff(rows.time_s)), dataclasses.replace(RAMPED, joint_rate_rad_s=1e-6)
    for made, most in ((slower, longest), (simulate(as_table(rows), lame), 1e3)):
        assert np.max(np.diff(made.trajectory.time_s)) <= most * (1.0 + 1e-9)
        assert len(made.trajectory.time_s) < 250_000
        assert_close(made.end.pose, rows.end.pose, 1e-9)
    # Without an acceleration limit controls are taken as they are, whatever the joints' rates.
    assert simulate(as_table(rows), Swimmer(joint_rate_rad_s=0.5)).slower_s == 0.0


def test_a_truth_with_ramps_is_tracked_at_its_own_pace() -> None:
    goal = Configuration.from_angles(position_m=(0.02, 0.0, 0.0))
    hinges = Swimmer(joints=(YAW, YAW))
    options = PlanOptions(effort=Effort.QUICK)
    found = track(Configuration(), goal, _accelerating(hinges, 2.0), model=hinges, options=options)
    assert found.arrived
    assert found.replans == 0
    assert found.trajectory is not None
    assert float(found.trajectory.time_s[-1]) > 1.2 * found.joint_travel_rad
    assert _followed(_accelerating(hinges, 2.0), found.trajectory)
