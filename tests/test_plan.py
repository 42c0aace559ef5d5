"""A plan reaches its goal by primitives alone, in three phases; it obeys the symmetries of Stokes swimming."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import (
    assert_close,
    dop853_rates,
    in_lengths,
    is_close,
    mostly_slow,
    random_rotations,
    random_shapes,
    random_swimmer,
)
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, PlanOptions, Swimmer, certify, plan, write_csv
from purcell_cli.errors import GaitError, ParameterError, UnknownNameError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.clearance import limb_distance
from purcell_cli.solution import Solution, phase_displacement

REACHED, COLLINEAR_WITHIN = 1e-9, 1e-9
DT = 0.05
HERE = Configuration()
BENT = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 75), (30, 10, 0), (-20, 15, 5))
NEAR = Configuration.from_angles((0.205, -0.102, 0.304), (43, -19, 70), (10, -20, 30), (0, 15, -40))

START_YAML = """
base: {position_m: [0.2, -0.1, 0.3], orientation: {euler_deg: [40, -20, 75]}}
limb1: {euler_deg: [30, 10, 0]}
limb2: {euler_deg: [-20, 15, 5]}
"""
GOAL_YAML = """
base: {position_m: [0.205, -0.102, 0.304], orientation: {euler_deg: [43, -19, 70]}}
limb1: {euler_deg: [10, -20, 30]}
limb2: {euler_deg: [0, 15, -40]}
"""


def at(
    position_m: tuple[float, float, float] = (0, 0, 0), psi: float = 0, theta: float = 0, phi: float = 0
) -> Configuration:
    """Return a collinear configuration at a position with angles in degrees."""
    return Configuration.from_angles(position_m, (psi, theta, phi))


def random_limbs(seed: int, pose: Array | None = None) -> Configuration:
    """Return a configuration with both limbs at random orientations."""
    return Configuration(np.eye(4) if pose is None else pose, random_shapes(np.random.default_rng(seed)))


Query = tuple[Configuration, Configuration, Swimmer]

QUERIES: dict[str, Query] = {
    **{f"far along {axis}": (HERE, at(tuple(2.0 * np.eye(3)[k])), Swimmer()) for k, axis in enumerate("xyz")},
    "far along -x": (HERE, at((-2.0, 0.0, 0.0)), Swimmer()),
    **{f"near along {axis}": (HERE, at(tuple(1e-3 * np.eye(3)[k])), Swimmer()) for k, axis in enumerate("xyz")},
    **{f"a little {angle}": (HERE, at(**{angle: 0.5}), Swimmer()) for angle in ("psi", "theta", "phi")},
    **{f"a quarter turn of {angle}": (HERE, at(**{angle: -90.0}), Swimmer()) for angle in ("psi", "theta", "phi")},
    **{f"a half turn of {angle}": (HERE, at(**{angle: 180.0}), Swimmer()) for angle in ("psi", "theta", "phi")},
    "a half turn about an oblique axis": (
        HERE,
        Configuration(
            se3.pose(Rotation.from_rotvec(math.pi * np.array([2.0, -3.0, 6.0]) / 7.0).as_matrix(), np.zeros(3))
        ),
        Swimmer(),
    ),
    "limbs bent before": (random_limbs(1), HERE, Swimmer()),
    "limbs bent after": (HERE, random_limbs(2), Swimmer()),
    "limbs bent before and after": (random_limbs(3), random_limbs(4), Swimmer()),
    "limbs folded back": (
        HERE,
        Configuration.from_angles(limb1_euler_deg=(0, 180, 0), limb2_euler_deg=(180, 0, 0)),
        Swimmer(limb_half_length_m=0.04),
    ),
    "limbs rolled": (
        HERE,
        Configuration.from_angles(limb1_euler_deg=(0, 0, 50), limb2_euler_deg=(0, 0, -120)),
        Swimmer(),
    ),
    "short limbs": (BENT, NEAR, Swimmer(limb_half_length_m=0.03)),
    "long limbs": (BENT, NEAR, Swimmer(limb_half_length_m=0.3)),
    "thin links": (BENT, NEAR, Swimmer(slenderness=0.002)),
    "thick links": (BENT, NEAR, Swimmer(slenderness=0.05)),
    "little drag anisotropy": (HERE, at((0.03, 0.01, 0.0), 10), Swimmer(drag_ratio=1.2)),
    "much drag anisotropy": (BENT, NEAR, Swimmer(drag_ratio=4.0)),
    "micrometres": (
        HERE,
        at((2e-6, 1e-6, -1e-6), 30, 10, 20),
        Swimmer(base_half_length_m=1e-6, limb_half_length_m=1e-6),
    ),
    "gentle bends": (HERE, at((0.05, 0.03, 0.02), 10, 20, 30), Swimmer(max_bend_rad=0.4)),
    "fast joints": (BENT, NEAR, Swimmer(joint_rate_rad_s=7.3)),
}


@functools.cache
def solved(name: str) -> Solution:
    """Return the plan of a query by its name; planned once in a process."""
    start, goal, swimmer = QUERIES[name]
    return plan(start, goal, swimmer=swimmer, options=PlanOptions(dt_s=DT))


@functools.cache
def bent() -> Solution:
    """Return the plan that the laws are shown on: all twelve coordinates change."""
    return plan(BENT, NEAR, swimmer=Swimmer(), options=PlanOptions(dt_s=DT))


def random_query(seed: int) -> Query:
    """Return a query over 0.01 to 50 lengths, of the paper's swimmer or, every other time, of a random one."""
    rng = np.random.default_rng([2024, seed])
    swimmer = Swimmer()
    if seed % 2:
        swimmer = dataclasses.replace(random_swimmer(rng), joint_rate_rad_s=math.exp(rng.uniform(-1.0, 1.0)))
    far = swimmer.length_m * math.exp(rng.uniform(math.log(0.01), math.log(50.0)))
    way = rng.normal(size=3)
    start = Configuration(se3.pose(random_rotations(rng), far * rng.normal(size=3)), apart(rng, swimmer))
    there = se3.pose(random_rotations(rng), far * way / np.linalg.norm(way))
    return start, Configuration(start.pose @ there, apart(rng, swimmer)), swimmer


def apart(rng: np.random.Generator, swimmer: Swimmer) -> Array:
    """Return a random shape whose limbs do not overlap. Shape (2, 3, 3)."""
    while limb_distance(swimmer, (shape := random_shapes(rng))[..., 0]) <= 0.0:
        pass
    return shape


def largest(solution: Solution) -> float:
    """Return the certificate's largest deviation, lengths in L."""
    d = solution.certificate.deviation
    return max(d.position_m / solution.plan.swimmer.length_m, d.base_rad, d.limb1_rad, d.limb2_rad)


def segments(solution: Solution) -> tuple[Array, Array]:
    """Return rates and durations of the segments of constant control. Shapes (m, 6), (m,)."""
    t, rates = solution.trajectory.time_s, solution.trajectory.rate_rad_s
    first = np.flatnonzero(np.append(True, np.any(rates[1:-1] != rates[:-2], axis=1)))
    return rates[first], np.diff(np.append(t[first], t[-1]))


def assert_same_controls(found: Solution, wanted: Solution, tolerance: float = 1e-9, faster: float = 1.0) -> None:
    """Assert that two plans turn the same joints by the same angles, one `faster` times as fast."""
    (rates, seconds), (other_rates, other_seconds) = segments(found), segments(wanted)
    assert_close(rates, faster * other_rates, 1e-12, faster)
    assert_close(faster * seconds, other_seconds, tolerance)


def differ(found: Solution, wanted: Solution) -> bool:
    """Return whether two plans turn joints differently; for foils."""
    (rates, seconds), (other_rates, other_seconds) = segments(found), segments(wanted)
    return rates.shape != other_rates.shape or not (
        np.array_equal(rates, other_rates) and is_close(seconds, other_seconds, 1e-6)
    )


def assert_reached(solution: Solution, query: Query) -> None:
    """Assert that a plan ends at its goal, by its certificate, its last row and its displacements."""
    start, goal, swimmer = query
    assert solution.verdict == "reached"
    assert solution.certificate.reached
    assert largest(solution) <= REACHED
    first, last = solution.trajectory, solution.trajectory.end
    assert_close(first.pose[0], start.pose, 1e-14, 1.0 + float(np.abs(start.pose).max()))
    assert_close(first.shape[0], start.shape, 1e-14)
    assert_close(in_lengths(swimmer, last.pose), in_lengths(swimmer, goal.pose), REACHED)
    assert_close(last.shape, goal.shape, REACHED)
    made = functools.reduce(np.matmul, solution.displacement, np.eye(4))
    assert_close(in_lengths(swimmer, start.pose @ made), in_lengths(swimmer, goal.pose), REACHED)


def assert_primitives_only(solution: Solution, dt_s: float = DT) -> None:
    """Assert that one joint turns at a time, at the swimmer's rate, with rows often enough."""
    t, rates = solution.trajectory.time_s, solution.trajectory.rate_rad_s
    assert len(t) == len(rates) == len(solution.trajectory)
    assert t[0] == 0.0
    assert np.all(np.diff(t) > 0.0)
    assert np.all(np.diff(t) <= dt_s * (1 + 1e-9))
    assert np.all(np.count_nonzero(rates[:-1], axis=1) == 1)
    assert np.all(np.abs(rates[:-1]).max(axis=1, initial=0.0) == solution.plan.swimmer.joint_rate_rad_s)
    assert np.all(rates[-1] == 0.0)
    assert_close(t[-1] * solution.plan.swimmer.joint_rate_rad_s, solution.joint_travel_rad, 1e-9)


def assert_three_phases(solution: Solution) -> None:
    """Assert that phases 1, 2, 3 come in order and that the limbs are collinear where phase 2 begins and ends.

    They may be rolled by quarter turns there, each by the same at both.
    """
    phase, shape = solution.trajectory.phase, solution.trajectory.shape
    assert set(phase.tolist()) <= {1, 2, 3}
    assert np.all(np.diff(phase) >= 0)
    straight = []
    for k in (2, 3):
        begins = np.flatnonzero(phase == k)
        if len(begins) and (begins[0] > 0 or k == 2):
            straight.append(shape[begins[0]])
    if phase[-1] == 2:
        straight.append(shape[-1])
    for limbs in straight:
        assert_close(limbs, np.round(straight[0]), COLLINEAR_WITHIN)
        assert_close(limbs[:, :, 0], COLLINEAR[:, :, 0], COLLINEAR_WITHIN)
    blocks = [block.phase for block in solution.plan.blocks]
    assert blocks == sorted(blocks)


def assert_lawful(solution: Solution, query: Query) -> None:
    """Assert all that holds for every plan."""
    assert_reached(solution, query)
    assert_primitives_only(solution)
    assert_three_phases(solution)


# --- Goals of every kind -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", mostly_slow(QUERIES, 4))
def test_a_goal_of_every_kind_is_reached_by_primitives_in_three_phases(name: str) -> None:
    assert_lawful(solved(name), QUERIES[name])


@pytest.mark.parametrize("seed", mostly_slow(range(100), 2, 20))
def test_a_random_goal_of_a_random_swimmer_is_reached_by_primitives_in_three_phases(seed: int) -> None:
    query = random_query(seed)
    assert_lawful(plan(*query[:2], swimmer=query[2], options=PlanOptions(dt_s=DT)), query)


@pytest.mark.slow
@pytest.mark.parametrize(
    "turned", [(0.0, 0.0, 0.0), (40.0, 10.0, -20.0), (140.0, -60.0, 60.0)], ids=["as before", "turned", "round"]
)
def test_a_thousand_lengths_are_no_farther_than_a_few(turned: tuple[float, float, float]) -> None:
    """Rounding to the clock, times thousands of cycles and a long lever, is made up for by the last strokes."""
    goal = at((80.0, 50.0, 33.0), *turned)
    query = (HERE, goal, Swimmer())
    solution = plan(*query[:2], swimmer=query[2])
    assert_reached(solution, query)
    straight = np.linalg.norm(goal.pose[:3, 3]) / Swimmer().length_m / 0.0451
    assert straight < solution.joint_travel_rad < 1.01 * straight + 200.0


@pytest.mark.parametrize("where", [HERE, at((3.0, -1.0, 2.0), 100, 50, -170)], ids=["origin", "elsewhere"])
def test_to_stay_where_one_is_takes_nothing(where: Configuration) -> None:
    solution = plan(where, where)
    assert_reached(solution, (where, where, Swimmer()))
    assert solution.joint_travel_rad == 0.0
    assert len(solution.trajectory) == 1
    assert np.all(solution.trajectory.rate_rad_s == 0.0)


def test_bent_limbs_that_stay_where_they_are_reach_their_goal() -> None:
    assert_lawful(plan(BENT, BENT, options=PlanOptions(dt_s=DT)), (BENT, BENT, Swimmer()))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a little psi"])
def test_to_look_longer_finds_no_longer_plan(name: str) -> None:
    start, goal, swimmer = QUERIES[name]
    thorough = plan(start, goal, swimmer=swimmer, options=PlanOptions(dt_s=DT, effort="thorough"))
    assert_lawful(thorough, QUERIES[name])
    assert thorough.joint_travel_rad <= solved(name).joint_travel_rad


def test_an_effort_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="effort: one of quick, standard, thorough is wanted, found 'lazy'"):
        plan(BENT, NEAR, options=PlanOptions(effort="lazy"))


def test_a_longer_way_takes_more_joint_travel() -> None:
    far, near = (solved(f"{how} along x").joint_travel_rad for how in ("far", "near"))
    assert far > near > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "query",
    [(BENT, NEAR, Swimmer(max_bend_rad=0.5)), (BENT, NEAR, Swimmer()), random_query(0)],
    ids=["half a radian", "one radian", "random 0"],
)
def test_stored_gaits_bend_a_limb_no_further_than_the_swimmer_allows(query: Query) -> None:
    """Within a thousandth, which the exact finish may add."""
    trajectory = plan(*query[:2], swimmer=query[2], options=PlanOptions(dt_s=DT)).trajectory
    axes = trajectory.shape[trajectory.phase == 2][:, :, :, 0]
    bend = np.arctan2(np.linalg.norm(axes[..., 1:], axis=-1), axes[..., 0])
    assert 0.0 < np.max(bend) <= 1.001 * query[2].max_bend_rad


@pytest.mark.slow
def test_a_plan_is_what_the_plain_equations_of_motion_do() -> None:
    """Integrated in the world, limbs and all, by code that shares only the connection; an early stop is the foil."""
    name = "a quarter turn of phi"
    start, goal, swimmer = QUERIES[name]
    rates, seconds = segments(solved(name))
    found = dop853_rates(swimmer, rates, seconds, start.shape, start.pose)
    assert_close(in_lengths(swimmer, found), in_lengths(swimmer, goal.pose), REACHED)
    early = dop853_rates(swimmer, rates[:-1], seconds[:-1], start.shape, start.pose)
    assert not is_close(in_lengths(swimmer, early), in_lengths(swimmer, goal.pose), REACHED)


def test_the_displacements_of_the_phases_make_the_displacement_of_the_plan() -> None:
    solution = bent()
    made = functools.reduce(np.matmul, (phase_displacement(solution, k) for k in (1, 2, 3)))
    wanted = se3.inverse(BENT.pose) @ NEAR.pose
    assert_close(in_lengths(Swimmer(), made), in_lengths(Swimmer(), wanted), REACHED)
    spatial = NEAR.pose @ se3.inverse(BENT.pose)
    assert not is_close(in_lengths(Swimmer(), made), in_lengths(Swimmer(), spatial), 1e-3)


@pytest.mark.slow
def test_rows_are_as_close_as_asked_for_and_the_motion_is_the_same() -> None:
    for dt in (0.013, 10.0):
        other = plan(BENT, NEAR, options=PlanOptions(dt_s=dt))
        assert_primitives_only(other, dt)
        assert_same_controls(other, bent(), 0.0)
        assert (len(other.trajectory) > len(bent().trajectory)) == (dt < DT)


@pytest.mark.parametrize("dt", [0.0, -1.0, math.nan])
def test_a_time_between_rows_that_is_none_is_refused(dt: float) -> None:
    with pytest.raises(ParameterError, match="dt: a time above"):
        plan(HERE, at((0.1, 0.0, 0.0)), options=PlanOptions(dt_s=dt))


def test_without_gaits_a_plan_says_what_it_lacks() -> None:
    with pytest.raises(GaitError, match="gait"):
        plan(HERE, at((0.1, 0.05, 0.02), 10, 20, 30), gaits={})


def test_what_a_solution_holds_cannot_be_written_to() -> None:
    trajectory = bent().trajectory
    for column in (
        trajectory.time_s,
        trajectory.phase,
        trajectory.gait,
        trajectory.pose,
        trajectory.shape,
        trajectory.rate_rad_s,
    ):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1


# --- The certificate -----------------------------------------------------------------------------------------------


def certified(solution: Solution, query: Query, time_s: Array, rate_rad_s: Array) -> bool:
    start, goal, swimmer = query
    return certify(swimmer, start, goal, time_s, rate_rad_s).reached


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.99])
def test_a_certificate_finds_one_duration_changed_or_one_rate_turned_round(share: float) -> None:
    query, trajectory = (BENT, NEAR, Swimmer()), bent().trajectory
    t, rates = trajectory.time_s, trajectory.rate_rad_s
    assert certified(bent(), query, t, rates)
    k = int(share * (len(t) - 1))
    for change in (1e-6, -1e-6):
        longer = t + change * (np.arange(len(t)) > k)
        assert not certified(bent(), query, longer, rates)
    turned = rates.copy()
    turned[k] *= -1.0
    assert not certified(bent(), query, t, turned)


@pytest.mark.parametrize("k", range(12))
def test_a_certificate_finds_a_goal_missed_by_two_tolerances(k: int) -> None:
    """In any of the twelve coordinates: position by 2e-9 L, an orientation by 2e-9 rad; half a tolerance is reached."""
    t, rates = bent().trajectory.time_s, bent().trajectory.rate_rad_s
    for size, reached in ((2e-9, False), (0.5e-9, True)):
        twist = np.zeros(12)
        twist[k] = size
        pose = NEAR.pose @ se3.exp(twist[:6])
        pose[:3, 3] = NEAR.pose[:3, 3] + Swimmer().length_m * (pose[:3, 3] - NEAR.pose[:3, 3])
        turned = [NEAR.shape[i] @ Rotation.from_rotvec(twist[6 + 3 * i : 9 + 3 * i]).as_matrix() for i in (0, 1)]
        missed = Configuration(pose, np.stack(turned))
        assert certified(bent(), (BENT, missed, Swimmer()), t, rates) is reached


@pytest.mark.parametrize(
    "other", [Swimmer(slenderness=0.0101), Swimmer(drag_ratio=2.001), Swimmer(limb_half_length_m=0.1001)], ids=str
)
def test_a_certificate_is_for_one_swimmer(other: Swimmer) -> None:
    t, rates = bent().trajectory.time_s, bent().trajectory.rate_rad_s
    assert not certified(bent(), (BENT, NEAR, other), t, rates)


def test_a_certificate_tells_what_it_did() -> None:
    found = bent().certificate
    assert 0 < found.integrated <= found.segments == len(segments(bent())[1])
    assert found.tolerance_m == REACHED * Swimmer().length_m
    assert found.tolerance_rad == REACHED


# --- Equal input, equal output -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_equal_queries_have_equal_trajectories_to_the_byte(tmp_path: Path) -> None:
    """Twice in this process, and twice in others with other hash seeds."""
    files = [tmp_path / f"{k}.csv" for k in range(4)]
    write_csv(bent().trajectory, files[0])
    write_csv(plan(BENT, NEAR, swimmer=Swimmer(), options=PlanOptions(dt_s=DT)).trajectory, files[1])
    (tmp_path / "start.yaml").write_text(START_YAML)
    (tmp_path / "goal.yaml").write_text(GOAL_YAML)
    for file, hash_seed in ((files[2], "0"), (files[3], "4711")):
        command = [sys.executable, "-W", "error", "-c", "from purcell_cli.cli.app import main; main()"]
        arguments = ["plan", "start.yaml", "goal.yaml", "--out", str(file)]
        environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
        subprocess.run([*command, *arguments], cwd=tmp_path, env=environment, check=True, capture_output=True)
    first, *others = (file.read_bytes() for file in files)
    assert first.count(b"\n") == len(bent().trajectory) + 1
    assert all(other == first for other in others)


# --- Symmetries ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", mostly_slow(range(3), 1))
def test_the_same_world_motion_of_start_and_goal_leaves_the_controls(seed: int) -> None:
    """To 1e-7 rad: one free angle of a roll stroke hardly matters, and carries the rounding of the moved poses."""
    rng = np.random.default_rng(seed)
    world = se3.pose(random_rotations(rng), rng.normal(size=3))
    moved = plan(
        Configuration(world @ BENT.pose, BENT.shape),
        Configuration(world @ NEAR.pose, NEAR.shape),
        options=PlanOptions(dt_s=DT),
    )
    assert_same_controls(moved, bent(), 1e-7)
    assert_close(in_lengths(Swimmer(), moved.trajectory.pose[-1]), in_lengths(Swimmer(), world @ NEAR.pose), REACHED)


@pytest.mark.slow
def test_a_motion_in_the_body_frames_of_start_and_goal_changes_the_controls() -> None:
    """The foil of left invariance: the same motion from the right."""
    body = se3.pose(random_rotations(np.random.default_rng(0)), [0.3, 0.1, -0.2])
    moved = plan(
        Configuration(BENT.pose @ body, BENT.shape),
        Configuration(NEAR.pose @ body, NEAR.shape),
        options=PlanOptions(dt_s=DT),
    )
    assert differ(moved, bent())


@pytest.mark.slow
def test_viscosity_leaves_the_controls_and_scales_the_energy() -> None:
    thick = plan(BENT, NEAR, swimmer=Swimmer(viscosity_pa_s=9.5), options=PlanOptions(dt_s=DT))
    assert_same_controls(thick, bent(), 0.0)
    assert_close(thick.energy_j / bent().energy_j, np.full(len(bent().energy_j), 10.0), 1e-9)
    assert differ(plan(BENT, NEAR, swimmer=Swimmer(drag_ratio=2.1), options=PlanOptions(dt_s=DT)), bent())


def test_the_joint_rate_scales_the_times_alone() -> None:
    """Three times the rate: the same angles, poses and travel, a third of the time, three times the energy."""
    rate = 3.0
    fast = plan(BENT, NEAR, swimmer=Swimmer(joint_rate_rad_s=rate), options=PlanOptions(dt_s=DT / rate))
    assert_same_controls(fast, bent(), faster=rate)
    assert_close(fast.joint_travel_rad, bent().joint_travel_rad, 1e-9)
    assert_close(rate * fast.trajectory.time_s[-1], bent().trajectory.time_s[-1], 1e-9)
    assert_close(rate * fast.plan.duration_s, bent().plan.duration_s, 1e-9)
    assert_close(np.sum(fast.energy_j), rate * np.sum(bent().energy_j), 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [4.0, 1e-5])
def test_scaling_all_lengths_scales_the_path(scale: float) -> None:
    def larger(c: Configuration) -> Configuration:
        pose = c.pose.copy()
        pose[:3, 3] *= scale
        return Configuration(pose, c.shape)

    swimmer = Swimmer(base_half_length_m=0.1 * scale, limb_half_length_m=0.1 * scale)
    scaled = plan(larger(BENT), larger(NEAR), swimmer=swimmer, options=PlanOptions(dt_s=DT))
    assert_close(scaled.joint_travel_rad, bent().joint_travel_rad, 1e-3, bent().joint_travel_rad)
    if scaled.plan.primitives == bent().plan.primitives:  # the search lets rounding grow, until another plan is better
        assert_same_controls(scaled, bent(), 1e-6)
    if len(scaled.trajectory) == len(bent().trajectory):
        found = in_lengths(swimmer, scaled.trajectory.pose)
        assert_close(found, in_lengths(Swimmer(), bent().trajectory.pose), 1e-6)
    if scale == 4.0:
        assert differ(plan(larger(BENT), larger(NEAR), swimmer=Swimmer(), options=PlanOptions(dt_s=DT)), bent())


@pytest.mark.slow
def test_energies_are_of_every_block_and_never_negative() -> None:
    for solution in itertools.chain([bent()], map(solved, ("limbs rolled",))):
        assert len(solution.energy_j) == len(solution.displacement) == len(solution.plan.blocks)
        assert np.all(solution.energy_j >= 0.0)
        assert np.sum(solution.energy_j) > 0.0


def test_progress_says_a_joint_travel_or_that_there_is_no_plan_yet() -> None:
    news: list[str] = []
    options = PlanOptions(effort="quick", controls="simultaneous")
    goal = Configuration.from_angles((1.5, 1.0, -0.5))
    plan(Configuration(), goal, options=options, progress=lambda _done, _of, words: news.append(words))
    assert "no plan yet" in news
    assert not any("inf" in words for words in news)
