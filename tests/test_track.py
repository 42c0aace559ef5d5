"""The loop: plan, swim on another swimmer, measure, plan again; it arrives where a plan alone misses."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, assert_close, runner

from purcell_cli import Configuration, PlanOptions, Swimmer
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import HalfSpace, Sphere
from purcell_cli.errors import ParameterError
from purcell_cli.feedback.drag_factors import What, factors_of, with_factors
from purcell_cli.feedback.drag_filter import DragFilter
from purcell_cli.feedback.measured import EXACTLY, Measuring, in_its_plane
from purcell_cli.feedback.replan import done_by
from purcell_cli.feedback.simulate import simulate
from purcell_cli.feedback.track import _until, track
from purcell_cli.feedback.tracker import Tracker
from purcell_cli.files.builtin import find_swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.configuration import Deviation, displacement_between
from purcell_cli.mechanics.joint_motion import refuse_displacement
from purcell_cli.mechanics.joints import Joint
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.motion.obstacle_distance import link_distances
from purcell_cli.motion.trajectory import as_table
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.planning import plan

TRUTH = Swimmer(drag_ratio=1.7)
START = Configuration()
GOAL = Configuration.from_angles((0.0, 0.0, 0.0), (20, 0, 0), (0, 0, 0), (0, 0, 0))
FAR = Configuration.from_angles((0.2, 0.1, 0.0), (20, 0, 0), (0, 0, 0), (0, 0, 0))


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "track")


@pytest.mark.slow
@pytest.mark.parametrize("goal", [GOAL, FAR])
def test_it_arrives_where_one_plan_alone_misses(goal: Configuration) -> None:
    found = track(START, goal, TRUTH)
    assert found.arrived
    assert found.off.within(1e-3 * TRUTH.length_m, math.radians(0.1))
    alone = simulate(as_table(plan(START, goal).trajectory), TRUTH).off
    assert not alone.within(1e-3 * TRUTH.length_m, math.radians(0.1))
    assert 1 <= found.replans <= 10
    # What was learned is of use: without it the way takes at least as many plans.
    plain = Tracker(goal, Swimmer())
    here, plans = START, 0
    while not plain.arrived(here):
        here = simulate(as_table(plain.update(here).trajectory), TRUTH).end
        plain._last = None
        plans += 1
    assert len(found.parts) <= plans


@pytest.mark.slow
def test_every_replan_stays_clear_of_obstacles() -> None:
    """A ball where a limb would swing, and a floor: the first plan misses, and all plans are clear of both."""
    scene = Scene((Sphere((0.2, 0.14, 0.0), 0.03), HalfSpace((0, 0, -0.15), (0, 0, 1))))
    goal = Configuration.from_angles((0.04, 0.0, 0.0), (10, 0, 0))
    found = track(START, goal, TRUTH, options=PlanOptions(obstacles=scene, effort="quick", clearance_m=0.002))
    assert found.arrived
    assert found.replans >= 1
    for part in found.parts:
        rows = part.solution.trajectory
        assert part.solution.limits.obstacle is not None
        assert part.solution.limits.obstacle.distance_m >= 0.002
        assert float(np.min(link_distances(TRUTH, scene, rows.pose, rows.shape[..., 0])[0])) >= 0.002 - 1e-9
    really = found.trajectory
    assert really is not None
    assert float(np.min(link_distances(TRUTH, scene, really.pose, really.shape[..., 0])[0])) > 0.0
    alone = track(START, goal, TRUTH, options=PlanOptions(effort="quick"), replans=0).parts[0].solution.trajectory
    assert float(np.min(link_distances(TRUTH, scene, alone.pose, alone.shape[..., 0])[0])) < 0.002


def test_a_model_that_is_the_truth_needs_no_second_plan() -> None:
    found = track(START, GOAL, Swimmer())
    assert (found.arrived, found.replans) == (True, 0)
    assert found.off.within(1e-10, 1e-9)


def test_a_truth_that_ramps_more_slowly_than_the_model_is_measured_in_the_plans_time() -> None:
    """What is seen on the way had been taken for what the plan does at the truth's later times: it led far astray."""
    goal = Configuration.from_angles((0.02, 0.01, 0.005))
    model = Swimmer(joint_acceleration_rad_s2=3.0)
    truth = Swimmer(drag="cylinder", joint_acceleration_rad_s2=2.0)
    found = track(Configuration(), goal, truth, model=model, replans=6)
    assert found.arrived
    assert found.parts[0].trajectory.time_s[-1] > 1.01 * _until(found.parts[0].solution, first=True)  # it is slower
    assert found.joint_travel_rad < 2.0 * found.parts[0].solution.joint_travel_rad


def test_the_last_fifth_of_a_long_plan_is_planned_again_on_the_way() -> None:
    long = plan(START, Configuration.from_angles((2.0, 0.0, 0.0)))
    done = done_by(long.plan, _until(long, first=False)) / long.joint_travel_rad
    assert long.joint_travel_rad > 400.0
    assert abs(done - 0.8) < 0.01
    assert done_by(long.plan, _until(long, first=True)) < 20.0
    short = plan(START, FAR)
    left = short.joint_travel_rad - done_by(short.plan, _until(short, first=False))
    assert abs(left - 20.0) < 1.0
    shortest = plan(START, GOAL)
    assert 3.0 < shortest.joint_travel_rad < 40.0
    assert _until(shortest, first=False) == math.inf > _until(shortest, first=True)


@pytest.mark.slow
def test_what_really_happened_is_one_motion_of_the_truth() -> None:
    """Its controls, swum by the truth from the start, lead through the same rows; on the model they do not."""
    found = track(START, FAR, TRUTH)
    rows = found.trajectory
    assert rows is not None
    assert len(found.parts) > 1
    assert np.all(np.diff(rows.time_s) > 0.0)
    assert_close(rows.time_s[-1], sum(part.trajectory.time_s[-1] for part in found.parts), 1e-9)
    table: Table = as_table(rows)
    again = simulate(table, TRUTH)
    assert_close(again.trajectory.pose, rows.pose, 1e-10)
    assert Deviation.between(again.end, found.parts[-1].end).within(1e-11, 1e-10)
    assert not simulate(table, Swimmer()).off.within(1e-4, 1e-3)


@pytest.mark.slow
def test_with_noise_it_ends_within_what_the_noise_hides() -> None:
    measuring = Measuring(1e-3, 0.1, seed=4)
    found, same = (track(START, GOAL, TRUTH, measuring=measuring) for _ in range(2))
    assert found.arrived
    assert found.off.within(3e-3 * TRUTH.length_m, math.radians(0.3))
    assert np.array_equal(found.parts[-1].end.pose, same.parts[-1].end.pose)
    assert not np.array_equal(found.parts[-1].end.pose, found.parts[-1].measured.pose)


@pytest.mark.slow
def test_what_parallel_hinges_cannot_make_of_a_measurement_is_noise() -> None:
    """They stay in the plane of the start, tilted here, so that the rest can be planned; other joints may leave it."""
    swimmer, rng = find_swimmer("planar"), np.random.default_rng(3)
    start = Configuration.from_angles((0.1, 0.2, 0.3), (20, 30, 40))
    there = Configuration(start.pose @ Configuration.from_angles((0.03, 0.01, 0), (170, 0, 0)).pose, start.shape)
    seen = Measuring(1e-3, 0.1).of(there, swimmer.length_m, rng.normal(size=(2, 3)))
    kept = in_its_plane(swimmer, start, seen)
    refuse_displacement(swimmer, start, kept)
    with pytest.raises(ParameterError, match="plane"):
        refuse_displacement(swimmer, start, seen)
    off = displacement_between(there, kept, 1.0) - displacement_between(there, seen, 1.0)
    assert_close(off[[0, 1, 0, 1], [3, 3, 1, 0]], np.zeros(4), 1e-5)
    assert in_its_plane(find_swimmer("universal"), start, seen) is seen


def test_measurements_have_the_noise_that_is_asked_for() -> None:
    rng = np.random.default_rng(0)
    measuring = Measuring(2e-3, 0.5)
    off = [Deviation.between(measuring.of(FAR, 0.1, rng.normal(size=(2, 3))), FAR) for _ in range(2000)]
    rms = np.sqrt(np.mean(np.square([[d.position_m, d.base_rad] for d in off]), axis=0))
    assert_close(rms, np.array([2e-4, math.radians(0.5)]) * math.sqrt(3.0), 0.05 * math.radians(0.5))
    assert EXACTLY.of(FAR, 0.1, rng.normal(size=(2, 3))) is FAR


@pytest.mark.slow
def test_a_better_model_is_used_as_soon_as_it_is_known() -> None:
    """With the truth as the model after the first part, one replan ends there; without, one does not."""
    found = track(START, GOAL, TRUTH, tolerance_l=1e-8, tolerance_rad=1e-8, replans=1, fitted=lambda _: TRUTH)
    assert (found.arrived, found.replans) == (True, 1)
    assert not track(START, GOAL, TRUTH, tolerance_l=1e-8, tolerance_rad=1e-8, replans=1).arrived


@pytest.mark.slow
def test_a_loop_that_measures_within_strokes_arrives() -> None:
    """Every half second a new plan, far within a stroke; each goes on where the last one is.

    What the model is wrong by on the last part is left at the end, so the parts must not be long.
    """
    goal = Configuration.from_angles((0.03, 0.0, 0.0))
    tracker, here = Tracker(goal, Swimmer()), START
    rest = tracker.update(here)
    travel = [rest.joint_travel_rad]
    while not tracker.arrived(here) and len(travel) < 40:
        part = rest.trajectory.until(0.5)
        here = simulate(as_table(part), TRUTH).end
        rest = tracker.update(here, part.time_s[-1])
        travel.append(rest.joint_travel_rad)
    assert tracker.arrived(here)
    assert 3 < len(travel) < 40
    assert travel[6] < travel[1] - 0.8  # it goes on, and does not begin anew; the first part told how far it is


def test_a_better_model_with_other_joints_is_refused() -> None:
    with pytest.raises(ParameterError, match="joints"):
        Tracker(GOAL, Swimmer()).use(Swimmer(joints=(Joint("universal"), Joint("universal"))))


def test_at_the_goal_nothing_is_planned() -> None:
    found = track(GOAL, GOAL, TRUTH)
    assert (found.arrived, found.parts, found.trajectory) == (True, (), None)


@pytest.mark.slow
def test_the_command_says_what_happened_and_writes_it(command: Run, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("truth.yaml").write_text("drag_ratio: 1.7\n")
    code, out, _ = command("yaw", "--truth", "truth.yaml", "--out", "real.csv", "--json")
    document = json.loads(out)
    assert (code, document["verdict"], document["out"]) == (0, "reached", "real.csv")
    assert document["replans"] == len(document["parts"]) - 1
    assert document["parts"][-1]["off"] == document["off"]
    assert Path("real.csv").read_text().startswith("t_s,phase,gait")
    code, out, _ = command("yaw", "--truth", "truth.yaml", "--replans", "0", "--json")
    assert (code, json.loads(out)["verdict"]) == (1, "not reached")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["roll", "--truth", "truth.yaml", "--replans", "-1"], "replans"),
        (["roll", "--truth", "truth.yaml", "--tolerance", "0"], "--tolerance"),
        (["roll", "--truth", "truth.yaml", "--noise", "position=1"], "position_l"),
        (["roll", "--truth", "truth.yaml", "--noise", "base_deg=nan"], "finite"),
        (["roll", "--truth", "truth.yaml", "--out", "truth.yaml"], "truth.yaml"),
        (["roll", "--truth", "missing.yaml"], "no such file"),
    ],
)
def test_bad_input_is_refused(
    command: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("truth.yaml").write_text("drag_ratio: 1.7\n")
    code, out, err = command(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["truth.yaml"]


def test_a_noise_that_is_none_is_refused() -> None:
    with pytest.raises(ParameterError, match="position_l of at least 0"):
        Measuring(position_l=-1.0)
    for often in ("0", "1.5", "101"):
        with pytest.raises(ParameterError, match="at_rest as a whole number from 1 to 100"):
            Measuring.of_text(f"position_l=1e-3,at_rest={often}")


def test_a_swimmer_that_is_measured_more_often_hides_less() -> None:
    once, often = (Measuring.of_text(f"position_l=1e-3,base_deg=0.1,at_rest={n}") for n in (1, 16))
    some = math.radians(0.1)
    assert_close(once.hidden(1e-3, some), [3.5e-3, math.radians(0.35)], 1e-12)
    assert_close(often.hidden(1e-3, some), [1.625e-3, math.radians(0.1625)], 1e-12)
    assert Measuring().at_rest == 4


def test_what_is_measured_far_worse_than_the_tolerance_is_no_arrival() -> None:
    some = math.radians(0.1)
    assert_close(Measuring(1.0, 45.0).hidden(1e-3, some), [1e-2, math.radians(1.0)], 1e-12)
    found = track(START, GOAL, Swimmer(), measuring=Measuring(0.3), replans=1)
    assert not found.arrived


def test_the_filter_finds_the_drag_that_moved_the_swimmer() -> None:
    """From one short motion, measured on its way; the guess, and a filter told of another motion, predict worse."""
    factors = factors_of(What.KINDS)
    logs = np.array([0.05, -0.1, 0.1, 0.4, 0.3, 0.5, 0.2])
    truth, guess = with_factors(Swimmer(), factors, logs.tolist()), Swimmer()
    rng = np.random.default_rng(5)

    def motion() -> Pieces:
        rates = np.eye(6)[rng.integers(6, size=24)] * rng.choice([-1.0, 1.0], size=(24, 1))
        shapes = shapes_along(np.array([np.eye(3)] * 2), None, 0.4 * rates)
        return Pieces(shapes[:-1], rates, np.full(24, 0.4))

    def made(swimmer: Swimmer, pieces: Pieces) -> np.ndarray:
        moves = piece_displacements(swimmer, pieces)
        moves[:, :3, 3] /= swimmer.length_m
        return np.asarray(matmul(moves[::2], moves[1::2]))

    def off(swimmer: Swimmer, pieces: Pieces) -> float:
        gap = se3.log(matmul(se3.inverse(made(swimmer, pieces)), made(truth, pieces)))
        return float(np.max(np.abs(gap)))

    seen, other = motion(), motion()
    rows = np.arange(0, 25, 2)
    found = DragFilter.of(guess).after(seen, rows, made(truth, seen), np.zeros(6))
    wrong = DragFilter.of(guess).after(seen, rows, made(truth, motion()), np.zeros(6))
    assert off(found.swimmer, other) < 0.1 * off(guess, other)
    assert off(wrong.swimmer, other) > 0.5 * off(guess, other)
    assert np.max(np.diagonal(found.covariance)) < np.max(np.diagonal(DragFilter.of(guess).covariance))
    noisy = DragFilter.of(guess).after(seen, rows, made(truth, seen), np.ones(6))
    assert np.max(np.abs(noisy.logs)) < 0.2 * np.max(np.abs(found.logs))
