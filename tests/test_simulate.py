"""A trajectory's controls on another swimmer, by laws: the same swimmer, left invariance, a stream, noise."""

from __future__ import annotations

import dataclasses
import functools
import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, assert_close, in_lengths, is_close, missed, runner

from purcell_cli import Configuration, LinkSize, LinkSizes, PlanDocument, Swimmer, plan, read_csv, write_csv, write_plan
from purcell_cli.errors import ParameterError
from purcell_cli.feedback.noise import Noise
from purcell_cli.feedback.simulate import refuse_other_joints, simulate
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import as_quaternion, from_quaternion
from purcell_cli.mechanics.joints import Joint
from purcell_cli.mechanics.lift import flow_of_rates
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.motion.trajectory import as_table
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.solution import Solution

HERE = Configuration.from_angles((0.3, -0.2, 0.1), (40, 20, -30), (30, 10, 5), (-20, 0, 40))
UNIVERSAL = Swimmer(joints=(Joint("universal"), Joint("universal")))
TRUTH = Swimmer(drag="spheroid", links=LinkSizes(limb2=LinkSize(0.09)), body_radius_m=0.02)


@functools.cache
def solution() -> Solution:
    goal = Configuration(HERE.pose @ se3.exp(np.array([0.05, 0.02, 0.0, 0.1, 0.0, 0.2])), HERE.shape)
    return plan(HERE, goal)


def table() -> Table:
    return as_table(solution().trajectory)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)
    write_csv(solution().trajectory, "plan.csv")
    write_plan(PlanDocument(solution().plan, solution().options), "plan.json")
    Path("truth.yaml").write_text("drag: spheroid\nlinks: {limb2: {half_length_m: 0.09}}\nbody_radius_m: 0.02\n")
    Path("model.yaml").write_text("viscosity_pa_s: 0.95\n")
    return runner(capsys, "simulate")


@pytest.mark.slow
def test_the_model_itself_does_what_was_planned() -> None:
    """To 1e-12 in every row; another truth, the foil, does not."""
    rows = table()
    for viscous in (0.95, 30.0):
        found = simulate(rows, Swimmer(viscosity_pa_s=viscous))
        assert_close(found.trajectory.pose[:, :3, 3], rows.position_m, 1e-13)
        assert_close(found.trajectory.pose[:, :3, :3], from_quaternion(rows.base), 1e-12)
        assert_close(found.trajectory.shape, from_quaternion(rows.limbs), 1e-12)
        assert found.worst is None
    other = simulate(rows, TRUTH)
    assert not is_close(other.trajectory.pose[:, :3, 3], rows.position_m, 1e-3)
    assert other.worst is not None
    assert_close(other.trajectory.shape, from_quaternion(rows.limbs), 1e-12)


def test_the_truth_swims_by_its_own_flow() -> None:
    rows = table()
    _, poses = flow_of_rates(TRUTH, rows.rate_rad_s[:-1], np.diff(rows.time_s), from_quaternion(rows.limbs[0]))
    wanted = HERE.pose @ poses[-1]
    found = simulate(rows, TRUTH)
    assert missed(in_lengths(TRUTH, wanted), in_lengths(TRUTH, found.end.pose)) < 1e-12
    assert_close(found.off.position_m, np.linalg.norm(found.end.pose[:3, 3] - rows.position_m[-1]), 1e-15)


def test_what_happens_does_not_depend_on_where() -> None:
    rows, away = table(), se3.exp(np.array([0.3, 0.1, -0.4, 0.2, 0.7, -0.3]))
    there = dataclasses.replace(
        rows,
        position_m=rows.position_m @ away[:3, :3].T + away[:3, 3],
        base=as_quaternion(away[:3, :3] @ from_quaternion(rows.base)),
    )
    one, two = simulate(rows, TRUTH), simulate(there, TRUTH)
    assert_close(away @ one.trajectory.pose, two.trajectory.pose, 1e-12)
    for a, b in zip(one.losses, two.losses, strict=True):
        assert_close([a.position_m, a.angle_rad], [b.position_m, b.angle_rad], 1e-12)


def test_small_losses_add_up_to_what_is_missed() -> None:
    """For a swimmer that is a little off; strokes of rows told apart by phase and name."""
    rows = table()
    names = np.array([f"stroke {k % 7}" for k in range(len(rows.time_s))])
    apart = dataclasses.replace(rows, gait=names)
    found = simulate(apart, Swimmer(drag_ratio=2.0 + 1e-6))
    assert len(found.losses) > 20
    total, off = sum(loss.position_m for loss in found.losses), found.off.position_m
    assert 0.0 < off <= total
    assert found.worst == int(np.argmax([loss.position_m / 0.1 + loss.angle_rad for loss in found.losses]))
    ends = [loss.ends_s for loss in found.losses]
    assert ends[:-1] == [loss.begins_s for loss in found.losses][1:]


def test_a_stream_carries_the_swimmer_along() -> None:
    rows, size = table(), 1e-3
    still, carried = simulate(rows, TRUTH), simulate(rows, TRUTH, Noise(drift_m_s=size, seed=3))
    stream = (carried.trajectory.pose[-1] - still.trajectory.pose[-1])[:3, 3] / rows.time_s[-1]
    assert 0.0 < np.linalg.norm(stream) < 5.0 * size
    away = carried.trajectory.pose[:, :3, 3] - still.trajectory.pose[:, :3, 3]
    assert_close(away, stream * rows.time_s[:, None], 1e-12)


def test_noise_is_seeded_and_of_the_size_asked_for() -> None:
    rows = table()
    noise = Noise.of("angle_deg=0.5, rate=0.03", 7)
    one, same, other = (simulate(rows, Swimmer(), n) for n in (noise, noise, dataclasses.replace(noise, seed=8)))
    assert np.array_equal(one.trajectory.pose, same.trajectory.pose)
    assert not is_close(one.trajectory.pose, other.trajectory.pose, 1e-4)
    acting = rows.rate_rad_s != 0.0
    part = one.trajectory.rate_rad_s[acting] / rows.rate_rad_s[acting] - 1.0
    assert 0.01 < np.std(np.unique(part)) < 0.06
    assert np.all(one.trajectory.rate_rad_s[~acting] == 0.0)
    again = simulate(as_table(one.trajectory), Swimmer())  # the file says what really happened
    assert_close(again.trajectory.pose, one.trajectory.pose, 1e-12)
    assert 1e-3 < one.off.limb1_rad < 0.2


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("rat=1", "nearest: rate"),
        ("rate", "a finite number for rate"),
        ("rate=x", "a finite number for rate"),
        ("rate=nan", "a finite number for rate"),
        ("rate=-1", "at least 0"),
        ("rate=0.1,rate=0.2", "each once"),
        ("angle_deg=1e9", "at most 90"),
    ],
)
def test_a_noise_that_is_none_is_refused(text: str, why: str) -> None:
    with pytest.raises(ParameterError, match=why):
        Noise.of(text)
    assert Noise.of("") == Noise()


# --- The command -----------------------------------------------------------------------------------------------------


def test_the_command_says_where_it_ends_and_writes_what_happened(run: Run) -> None:
    code, out, _ = run("plan.csv", "--swimmer", "truth.yaml", "--out", "real.csv", "--json")
    document, found = json.loads(out), simulate(table(), TRUTH)
    assert code == 0
    assert document["off"]["position_m"] == pytest.approx(found.off.position_m, rel=1e-9)
    assert np.linalg.norm(document["coordinates"]["position_m"]) == pytest.approx(document["off"]["position_m"])
    assert (document["model"], document["out"]) == (None, "real.csv")
    assert document["swimmer"]["links"] == {"limb2": {"half_length_m": 0.09}}
    assert_close(read_csv("real.csv").position_m, found.trajectory.pose[:, :3, 3], 1e-12)
    code, out, _ = run("real.csv", "--swimmer", "truth.yaml")
    assert code == 0
    assert "What strokes lost" not in out
    code, out, _ = run("plan.csv", "--swimmer", "truth.yaml", "--noise", "rate=0.02", "--seed", "4")
    assert "What strokes lost" in out


@pytest.mark.slow
def test_a_plan_document_names_the_model(run: Run) -> None:
    _, out, _ = run("plan.json", "--swimmer", "truth.yaml", "--json")
    _, other, _ = run("plan.csv", "--swimmer", "truth.yaml", "--model", "model.yaml", "--json")
    document, same = json.loads(out), json.loads(other)
    assert document["model"] == same["model"]
    assert document["model"]["drag_ratio"] == 2.0
    for key in ("off", "coordinates", "strokes"):
        assert str(document[key])[:60] == str(same[key])[:60]


def test_parquet_names_the_truth(run: Run) -> None:
    assert run("plan.csv", "--swimmer", "truth.yaml", "--out", "real.npz")[0] == 0
    with np.load("real.npz") as saved:
        assert json.loads(str(saved["swimmer"]))["drag"] == "spheroid"


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("none.csv", "--swimmer", "truth.yaml"), "no such file"),
        (("plan.csv",), "--swimmer"),
        (("plan.csv", "--swimmer", "none.yaml"), "none.yaml"),
        (("plan.csv", "--swimmer", "truth.yaml", "--noise", "drift=1"), "--noise"),
        (("plan.csv", "--swimmer", "truth.yaml", "--seed", "-1"), "seed"),
        (("plan.csv", "--swimmer", "truth.yaml", "--out", "plan.csv"), "plan.csv"),
    ],
)
def test_misuse_is_told_and_writes_nothing(run: Run, arguments: tuple[str, ...], why: str) -> None:
    before = sorted(Path().iterdir())
    code, out, error = run(*arguments)
    assert (code, out) == (2, "")
    assert why in error
    assert sorted(Path().iterdir()) == before


def test_a_motion_that_does_not_stop_is_refused() -> None:
    rows = table()
    with pytest.raises(ParameterError, match="last row"):
        simulate(dataclasses.replace(rows, rate_rad_s=rows.rate_rad_s + 1.0), Swimmer())


@pytest.mark.slow
def test_a_motion_that_the_joints_cannot_make_is_refused_with_the_line(run: Run) -> None:
    """The rows as well as the first shape; joints of the same kinds with other ranges are told apart."""
    quick, goal = PlanOptions(effort=Effort.QUICK), Configuration.from_angles((0.002, 0.0, 0.0))
    rows = as_table(plan(Configuration(), goal, swimmer=UNIVERSAL, options=quick).trajectory)
    simulate(rows, UNIVERSAL)
    simulate(rows, Swimmer())  # a ball joint turns about any axis
    narrow = Joint("universal", psi_deg=(-1.0, 1.0), theta_deg=(-1.0, 1.0))
    for joints, message in (
        (
            (Joint("hinge", "pitch"), Joint("universal")),
            r"^line \d+ .*found limb 1 turns at .* its pitch hinge has not",
        ),
        ((narrow, narrow), r"^line \d+ .*found limb [12]'s (psi|theta) is .* degrees, out of -1 to 1"),
    ):
        with pytest.raises(ParameterError, match=message):
            simulate(rows, Swimmer(joints=joints))
    with pytest.raises(ParameterError, match=r"with limb 1's range of psi \(-1\.0, 1\.0\), not none"):
        refuse_other_joints(UNIVERSAL, Swimmer(joints=(narrow, narrow)))
    Path("hinges.yaml").write_text("joints: {limb1: hinge, limb2: hinge}\n")
    code, _, err = run("plan.csv", "--swimmer", "hinges.yaml")
    assert (code, re.search(r"line \d+.*limb [12]", err) is not None) == (2, True)
    assert err.startswith("purcell simulate: plan.csv: line ")


def test_controls_that_the_truths_joints_cannot_make_are_refused_by_row() -> None:
    universal = Swimmer(joints=(Joint("universal"), Joint("universal")))
    with pytest.raises(ParameterError, match=r"line 2: limb 1: a roll of 0, since its joint is a universal joint"):
        simulate(table(), universal)
    yaws = as_table(plan(Configuration(), Configuration.from_angles((0.03, 0.0, 0.0))).trajectory)
    assert simulate(yaws, universal).worst is None
    narrow = Swimmer(joints=(Joint("hinge", "yaw", (-30.0, 30.0)), Joint("ball")))
    with pytest.raises(ParameterError, match=r"line \d+ .*limb 1's psi is .*, out of -30 to 30"):
        simulate(yaws, narrow)
