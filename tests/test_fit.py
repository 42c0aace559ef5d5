"""Drag from measured motion: exact where the data are, honest where they are noisy, silent where they say nothing."""

from __future__ import annotations

import csv
import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, runner

from purcell_cli import (
    Configuration,
    Effort,
    LinkDrag,
    LinkDrags,
    MeasuredTrajectory,
    PlanOptions,
    Swimmer,
    Trajectory,
    load_swimmer,
    read_measured,
    realise,
    stored_gaits,
    write_csv,
)
from purcell_cli.errors import InputError, ParameterError
from purcell_cli.feedback.drag_factors import Factor, What, factors_of, with_factors
from purcell_cli.feedback.fit import Fit, fit
from purcell_cli.feedback.learn import Learning
from purcell_cli.feedback.measured import Measuring
from purcell_cli.feedback.track import Tracking, track
from purcell_cli.feedback.windows import turns_between, windows_of
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.mechanics.lift import flow_of_rates

LOGS = np.array([0.1, -0.15, 0.2, 0.3, -0.2, 0.15, -0.1, 0.25, 0.05, -0.05, 0.12])
"""Logarithms of factors that a truth may have."""


QUICK = PlanOptions(effort=Effort.QUICK)


def swum(swimmer: Swimmer, rows: int = 200, planar: bool = False) -> MeasuredTrajectory:
    """Return a swimmer's motion as both limbs wave, in a plane or out of it, measured exactly."""
    t = np.linspace(0.0, 12.0, rows)
    yaws = np.stack([0.9 * np.sin(1.3 * t), 0.7 * np.sin(1.3 * t + 1.1) + 0.2 * np.sin(0.4 * t)])
    pitches = np.stack([0.5 * np.sin(0.9 * t + 0.3), 0.6 * np.cos(1.1 * t)]) * (not planar)
    rolls = np.stack([0.4 * np.sin(0.7 * t), 0.5 * np.sin(0.5 * t + 1.0)]) * (not planar)
    shape = np.moveaxis(from_euler(np.stack([yaws, pitches, rolls], axis=-1)), 0, 1)
    turns = turns_between(shape).reshape(-1, 6)
    _, poses = flow_of_rates(swimmer, turns, np.ones(rows - 1), shape[0])
    pose = se3.pose(from_euler([0.4, -0.2, 0.9]), [0.3, -0.1, 0.2]) @ poses
    return MeasuredTrajectory(t, pose, shape, np.ones(rows, dtype=bool))


def as_trajectory(measured: MeasuredTrajectory) -> Trajectory:
    """Return a motion as a trajectory without controls."""
    none = np.zeros(len(measured), dtype=np.int64)
    rates = np.zeros((len(measured), 6))
    return Trajectory(measured.time_s, none, none, ("wave",), measured.pose, measured.shape, rates)


def truth_of(what: What) -> Swimmer:
    factors = factors_of(what)
    return with_factors(Swimmer(), factors, LOGS[: len(factors)].tolist())


def noisy(
    measured: MeasuredTrajectory, seed: int, position_m: float = 1e-4, angle_rad: float = 2e-3
) -> MeasuredTrajectory:
    rng = np.random.default_rng(seed)
    twist = rng.normal(size=(len(measured), 6)) * np.repeat([position_m, angle_rad], 3)
    return dataclasses.replace(measured, pose=se3.normalised(measured.pose @ se3.exp(twist)))


def true_factor(factor: Factor, truth: Swimmer) -> float:
    (link, *_) = factor.links
    return factor.value(truth.rod(link)) / factor.value(Swimmer().rod(link))


@pytest.mark.parametrize("what", list(What))
def test_exact_motion_gives_the_drag_exactly(what: What) -> None:
    truth = truth_of(what)
    found = fit(swum(truth, 120), Swimmer(), what)
    assert found.settled
    assert all(f.told for f in found.factors)
    for link in range(3):
        for name in ("across", "ratio", "turn", "spin"):
            wanted = getattr(truth.rod(link), name)
            assert abs(getattr(found.swimmer.rod(link), name) / wanted - 1.0) < 1e-6, (link, name)
    assert found.after.position_l < 1e-9 < 1e-4 < found.before.position_l


def test_the_wrong_kind_of_factors_does_not_explain_exact_motion() -> None:
    measured = swum(truth_of(What.LINKS), 120)
    left = {what: fit(measured, Swimmer(), what).after.position_l for what in (What.LINKS, What.RATIO)}
    assert left[What.LINKS] < 1e-9 < 1e-4 < left[What.RATIO]


def test_forces_that_are_all_larger_change_nothing() -> None:
    """The scale is the viscosity's: a truth of twice the drag is fitted by factors of 1."""
    measured = swum(Swimmer(viscosity_pa_s=1.9), 120)
    found = fit(measured, Swimmer())
    assert all(abs(f.value - 1.0) < 1e-8 for f in found.factors)
    assert "base across" not in [f.factor.name for f in found.factors]


@pytest.mark.slow
def test_standard_errors_are_honest() -> None:
    """Within two of them in 95 % of cases; half or twice as large ones would not be."""
    truth, scores = truth_of(What.KINDS), []
    exact = swum(truth, 120)
    for seed in range(8):
        found = fit(noisy(exact, seed), Swimmer())
        assert found.settled
        scores += [
            (f.value - true_factor(f.factor, truth)) / f.standard_error
            for f in found.factors
            if f.told and f.standard_error is not None
        ]
    assert len(scores) > 45
    assert 0.9 <= np.mean(np.abs(scores) < 2.0) <= 0.995
    assert 0.7 < np.sqrt(np.mean(np.square(scores))) < 1.3


def test_motion_in_a_plane_says_nothing_of_spin() -> None:
    truth = truth_of(What.KINDS)
    found = fit(swum(truth, 120, planar=True), Swimmer())
    assert [f.factor.name for f in found.factors if not f.told] == ["base spin", "limbs spin"]
    for f in found.factors:
        if f.told:
            assert abs(f.value - true_factor(f.factor, truth)) < 1e-6
        else:
            assert (f.value, f.standard_error) == (1.0, None)
    assert all(abs(found.swimmer.rod(k).spin / Swimmer().rod(k).spin - 1.0) < 1e-12 for k in range(3))


def test_what_the_data_tell_only_together_is_named() -> None:
    """One limb that yaws on a base that drags almost nothing: no motion tells its drags apart from the other's."""
    t = np.linspace(0.0, 6.0, 60)
    angles = np.zeros((60, 2, 3))
    angles[:, 0, 0] = 0.05 * np.sin(t)
    shape = from_euler(angles)
    _, pose = flow_of_rates(Swimmer(), turns_between(shape).reshape(-1, 6), np.ones(59), shape[0])
    found = fit(noisy(MeasuredTrajectory(t, pose, shape, np.ones(60, bool)), 1, 1e-5, 1e-4), Swimmer(), "links")
    held = [f for f in found.factors if not f.told]
    assert {"base spin", "limb2 along"} <= {f.factor.name for f in held}
    names = {f.factor.name for f in found.factors}
    assert any(f.only_with for f in held)
    assert all(f.factor.name not in f.only_with and set(f.only_with) <= names for f in held)


def test_gaps_and_unseen_bases_cost_little() -> None:
    """Rows that are missing end a window; a base that is not seen is integrated over. What is left is still exact."""
    truth = truth_of(What.KINDS)
    whole = swum(truth, 240)
    kept = np.r_[0:70, 100:240]
    seen = np.ones(len(kept), dtype=bool)
    seen[20:35] = False
    pose = whole.pose[kept].copy()
    pose[~seen] = np.eye(4)
    cut = MeasuredTrajectory(whole.time_s[kept], pose, whole.shape[kept], seen)
    assert all(np.max(np.abs(w.pieces.rates)) < 0.2 for w in windows_of(cut, 0.1))
    assert np.max(np.abs(turns_between(cut.shape))) > 0.5
    found = fit(cut, Swimmer())
    assert found.rows < len(kept) + found.windows - 10
    assert all(abs(f.value / true_factor(f.factor, truth) - 1.0) < 1e-6 for f in found.factors)


def test_a_guess_keeps_what_is_not_drag() -> None:
    guess = Swimmer(0.12, 0.09, max_bend_rad=0.8, body_radius_m=0.01, drag="cylinder")
    truth = with_factors(guess, factors_of(What.KINDS), (0.3 * LOGS[:7]).tolist())
    found = fit(swum(truth, 120), guess)
    assert found.swimmer.halves_m == guess.halves_m
    assert (found.swimmer.body_radius_m, found.swimmer.max_bend_rad) == (0.01, 0.8)
    assert abs(found.swimmer.rod(1).along / truth.rod(1).along - 1.0) < 1e-6
    assert isinstance(fit(swum(Swimmer(drag_ratio=1.7), 120), Swimmer(), "ratio").swimmer.drag, str)


def test_a_link_that_hardly_glides_is_fitted() -> None:
    """Next to the bound, where derivatives can be taken on one side alone."""
    truth = with_factors(Swimmer(), factors_of(What.RATIO), [np.log(0.50001)])
    found = fit(swum(truth, 60), Swimmer(drag_ratio=1.2), "ratio")
    assert found.settled
    assert found.swimmer.drag_ratio == pytest.approx(1.00002, rel=1e-9)


def test_a_drag_that_no_link_can_have_is_not_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motion of links that glide worse along their axes than across asks for what is refused."""
    with monkeypatch.context() as patch:
        patch.setattr("purcell_cli.mechanics.swimmer.refuse_odd", lambda _rods, _halves: None)
        rod = Swimmer().rod(0)
        drag = LinkDrag(1.5 * rod.across, rod.across, rod.turn, rod.spin)
        measured = swum(Swimmer(drag=LinkDrags(drag, drag, drag)), 60)
    found = fit(measured, Swimmer(), "ratio")
    assert not found.settled
    assert 1.0 < found.swimmer.drag_ratio < 1.1


@pytest.mark.slow
def test_fitted_drag_predicts_other_strokes_on_beads_four_times_better() -> None:
    beads = Swimmer(fluid="beads")
    found = fit(swum(beads, 150), Swimmer())
    gains = []
    for name, gait in stored_gaits().items():
        if not name.startswith("printed"):
            stroke = realise(gait, Swimmer())
            truth, *others = (stroke.displacement(s) for s in (beads, Swimmer(), found.swimmer))
            off = [np.linalg.norm(se3.log(se3.inverse(p) @ truth) / np.repeat([0.1, 1.0], 3)) for p in others]
            gains.append((off[0] / off[1], name))
    assert len(gains) > 8
    assert np.median([gain for gain, _ in gains]) >= 4.0, gains


# --- Files and the command -------------------------------------------------------------------------------------------

_FRAMES = (("", "base"), ("l1_", "limb1"), ("l2_", "limb2"))


@pytest.fixture
def table(tmp_path: Path) -> list[dict[str, str]]:
    """Return the rows of a real motion's CSV file."""
    write_csv(as_trajectory(swum(truth_of(What.KINDS), 100)), tmp_path / "real.csv")
    with (tmp_path / "real.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def written(path: Path, rows: list[dict[str, str]], columns: list[str] | None = None) -> Path:
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, columns or list(rows[0]), extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return path


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "fit")


@pytest.mark.slow
def test_the_command_writes_a_swimmer_that_every_command_takes(
    command: Run, tmp_path: Path, table: list[dict[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    out = tmp_path / "fitted.yaml"
    code, printed, _ = command(str(tmp_path / "real.csv"), "--out", str(out), "--json")
    document = json.loads(printed)
    assert (code, document["verdict"], document["out"]) == (0, "fitted", str(out))
    truth, found = truth_of(What.KINDS), load_swimmer(out)
    told = {f["name"] for f in document["factors"] if f["told"]}
    assert {"base along", "limbs along", "limbs across", "limbs turn"} <= told
    assert abs(found.rod(1).across / truth.rod(1).across - 1.0) < 1e-6
    assert found == dataclasses.replace(Swimmer(), drag=found.drag)
    assert isinstance(found.drag, LinkDrags)
    assert f"limbs across: {document['factors'][4]['value']:.5g}" in out.read_text()
    code, shown, _ = command(str(tmp_path / "real.csv"), "--out", str(tmp_path / "two.yaml"), "--swimmer", str(out))
    assert code == 0
    assert "told by the data" in shown
    assert [f.value for f in fit(read_measured(tmp_path / "real.csv"), found).factors if f.told] == pytest.approx(
        [1.0] * len(told), abs=1e-6
    )


def test_what_a_measurement_need_not_have(tmp_path: Path, table: list[dict[str, str]]) -> None:
    """Rates, phases and angles may be left out, columns stand in any order, quaternions be rounded, cells be empty."""
    whole = read_measured(tmp_path / "real.csv")
    needed = ["l2_qz", "l2_qw", "l2_qx", "l2_qy", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "t_s"]
    bare = read_measured(written(tmp_path / "bare.csv", table, [*needed, "l1_qw", "l1_qx", "l1_qy", "l1_qz"]))
    assert np.array_equal(bare.shape, whole.shape)
    assert np.array_equal(bare.pose, whole.pose)
    eulers = [f"{p}{a}_rad" for p, _ in _FRAMES for a in ("psi", "theta", "phi")]
    angles = read_measured(written(tmp_path / "angles.csv", table, ["t_s", "x_m", "y_m", "z_m", *eulers]))
    assert np.max(np.abs(angles.shape - whole.shape)) < 1e-12
    rounded = [{k: v if k in {"gait", "phase"} else f"{float(v):.3f}" for k, v in row.items()} for row in table]
    near = read_measured(written(tmp_path / "rounded.csv", rounded))
    assert 1e-6 < np.max(np.abs(near.pose - whole.pose)) < 2e-3
    assert np.max(np.abs(np.swapaxes(near.shape, -1, -2) @ near.shape - np.eye(3))) < 1e-12
    lost = [dict(row) for row in table]
    for name in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "psi_rad", "theta_rad", "phi_rad"):
        lost[3][name] = ""
    assert np.flatnonzero(~read_measured(written(tmp_path / "lost.csv", lost)).seen).tolist() == [3]


@pytest.mark.parametrize(
    ("name", "row", "value", "message"),
    [
        ("t_s", 7, "0.0", ":9: t_s: wanted a time of at least"),
        ("x_m", 4, "nan", ":6: column 'x_m': wanted a finite number, found 'nan'"),
        ("x_m", 4, "", ":6: column 'x_m': wanted a finite number, found ''"),
        ("l2_qw", 5, "0.2", ":7: l2_qw to l2_qz: wanted a quaternion of length 1 for the limb 2"),
        ("qw", 2, "7", ":4: qw to qz: wanted a quaternion of length 1 for the base"),
        ("l1_qx", 1, "left", ":3: column 'l1_qx': wanted a finite number, found 'left'"),
        ("y_m", 3, "1e9", ":5: x_m to z_m: wanted at most"),
    ],
)
def test_bad_rows_are_told(
    tmp_path: Path, table: list[dict[str, str]], name: str, row: int, value: str, message: str
) -> None:
    table[row][name] = value
    with pytest.raises(InputError) as error:
        read_measured(written(tmp_path / "bad.csv", table))
    assert f"bad.csv{message}" in str(error.value)


def test_missing_columns_are_told(tmp_path: Path, table: list[dict[str, str]]) -> None:
    for gone, message in (
        ("t_s", ":1: wanted the columns t_s, x_m, y_m, z_m, found no t_s"),
        ("z_m", "found no z_m"),
    ):
        with pytest.raises(InputError, match=message):
            read_measured(written(tmp_path / "bad.csv", table, [name for name in table[0] if name != gone]))
    with pytest.raises(InputError, match=r":1: wanted columns for the limb 1's orientation .*found no l1_qw"):
        read_measured(written(tmp_path / "bad.csv", table, [n for n in table[0] if n not in {"l1_qw", "l1_psi_rad"}]))
    (tmp_path / "bad.csv").write_text("t_s,t_s\n")
    with pytest.raises(InputError, match="'t_s' twice"):
        read_measured(tmp_path / "bad.csv")
    (tmp_path / "bad.csv").write_text("t_s;x_m;y_m\n")
    with pytest.raises(InputError, match=r":1: .*columns are parted by commas, not by ';'"):
        read_measured(tmp_path / "bad.csv")


def test_motion_that_says_nothing_is_refused() -> None:
    good = swum(Swimmer(), 60)
    still = dataclasses.replace(good, shape=np.broadcast_to(good.shape[0], good.shape.shape).copy())
    jump = dataclasses.replace(good, pose=good.pose.copy())
    jump.pose[30:, 0, 3] += 1.0
    few = MeasuredTrajectory(good.time_s[:3], good.pose[:3], good.shape[:3], good.seen[:3])
    sparse = MeasuredTrajectory(good.time_s[::12], good.pose[::12], good.shape[::12], good.seen[::12])
    for bad, message in (
        (still, "limbs that turn are wanted"),
        (jump, r"row 31 \(t_s"),
        (few, "rows that show the base"),
        (sparse, "no turn above 0.5 rad"),
    ):
        with pytest.raises(ParameterError, match=message):
            fit(bad, Swimmer())
    with pytest.raises(ParameterError, match="fluid: local"):
        fit(good, Swimmer(fluid="beads"))
    with pytest.raises(ParameterError, match="what: one of ratio, kinds, links is wanted, found 'all'"):
        fit(good, Swimmer(), "all")
    assert isinstance(fit(good, Swimmer()), Fit)


def test_misuse_is_refused_and_nothing_written(command: Run, tmp_path: Path, table: list[dict[str, str]]) -> None:
    real, out = str(tmp_path / "real.csv"), tmp_path / "fitted.yaml"
    table[5]["l1_qw"] = "0"
    bad = str(written(tmp_path / "torn.csv", table))
    for arguments, message in (
        ((real,), "--out"),
        ((real, "--out", str(out), "--what", "kind"), "nearest: kinds"),
        ((real, bad, "--out", str(out)), "torn.csv:7: l1_qw to l1_qz"),
        ((real, "--out", real), "real.csv"),
        ((real, str(tmp_path / "." / "torn.csv" / ".." / "real.csv"), "--out", str(out)), "once is wanted, found it 2"),
    ):
        code, _, err = command(*arguments)
        assert code == 2
        assert message in err
    assert not out.exists()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_killed_fit_leaves_what_was_written(tmp_path: Path) -> None:
    write_csv(as_trajectory(swum(truth_of(What.LINKS), 12000)), tmp_path / "m.csv")
    out = tmp_path / "fitted.yaml"
    out.write_text("drag_ratio: 1.9\n")
    program = [sys.executable, "-m", "purcell_cli", "fit", "m.csv", "--out", "fitted.yaml", "--what", "links"]
    with subprocess.Popen(program, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        time.sleep(0.8)
        running.send_signal(signal.SIGKILL)
    assert running.returncode == -signal.SIGKILL
    assert out.read_text() == "drag_ratio: 1.9\n"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fitted.yaml", "m.csv"]


def test_links_drag_as_numbers_is_what_the_factors_say() -> None:
    doubled = with_factors(Swimmer(), factors_of(What.LINKS), [np.log(1.5)] + [0.0] * 10)
    assert isinstance(doubled.drag, LinkDrags)
    assert doubled.drag.base == LinkDrag(*(getattr(doubled.rod(0), n) for n in ("along", "across", "turn", "spin")))
    assert doubled.rod(0).along == pytest.approx(1.5 * Swimmer().rod(0).along, rel=1e-12)


@pytest.mark.slow
def test_the_loop_learns_the_drag_of_what_swims() -> None:
    """The truth is local: after one part its drag is known, so that one more plan arrives; with noise, nearly."""
    truth = truth_of(What.KINDS)
    goal = Configuration.from_angles((0.0, 0.0, 0.0), (12, 0, 0), (0, 0, 0), (0, 0, 0))
    models: list[Swimmer | None] = []
    learning = Learning(Swimmer())

    def fitted(so_far: Tracking) -> Swimmer | None:
        models.append(learning(so_far))
        return models[-1]

    found = track(Configuration(), goal, truth, fitted=fitted, options=QUICK, tolerance_l=1e-7, tolerance_rad=1e-7)
    assert (found.arrived, found.replans) == (True, 1)
    (model,) = models
    assert model is not None
    assert abs(model.rod(1).across / truth.rod(1).across - 1.0) < 1e-6
    rough = Learning(Swimmer(), Measuring(1e-3, 0.1, seed=2))(found)
    assert rough is not None
    assert 1e-6 < abs(rough.rod(1).across / truth.rod(1).across - 1.0) < 0.05
    assert learning(dataclasses.replace(found, parts=())) is None
