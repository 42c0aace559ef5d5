"""Gaits of one's own that are not the motion they are said to be: told with the figure, and not planned with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers import runner

from purcell_cli import Configuration, PlanOptions, Swimmer, plan, realise, stored_gaits
from purcell_cli.files.builtin import own_gaits
from purcell_cli.gaits.pure_stroke import fault
from purcell_cli.geometry import se3
from purcell_cli.planner import gait_sequence
from purcell_cli.planner.gait_sequence import unfit_gaits

_HEAD = "amplitude: {symbol: a, means: bend, default_rad: 1.0}\ncycle:"
SQUARE = f"{_HEAD} [{{limb1 yaw: a}}, {{limb2 yaw: a}}, {{limb1 yaw: -a}}, {{limb2 yaw: -a}}]\n"
OPEN = f"{_HEAD} [{{limb1 roll: a}}]\n"
FLAT = "free: {b: {guess: 0.5}}\n" + SQUARE.replace("limb2 yaw: a", "limb2 yaw: b").replace("yaw: -a}]", "yaw: -b}]")


def written(folder: Path, **gaits: str) -> Path:
    """Write gaits into a folder; each is what it moves, and the rest of its file."""
    folder.mkdir()
    for name, text in gaits.items():
        moves, _, rest = text.partition("|")
        (folder / f"{name}.yaml").write_text(f"name: {name}\nsummary: of one's own\nmoves: {moves}\n{rest}")
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return written(tmp_path / "own", drifty=f"x|{SQUARE}", ajar=f"roll|{OPEN}", flat=f"y|{FLAT}", played=f"none|{OPEN}")


def test_drift_and_a_gap_are_told_with_their_figures(folder: Path) -> None:
    own, body = own_gaits(folder), Swimmer()
    found = unfit_gaits(own.values(), body)
    assert set(found) == {"drifty", "ajar", "flat"}
    unit = body.scaled()
    twist = se3.log(realise(own["drifty"], unit).displacement(unit))
    assert np.argmax(np.abs(twist)) == 0, "it does move x most of all"
    assert found["drifty"] == f"it moves y too, by {abs(twist[1]):.3g} L a cycle"
    assert found["ajar"] == "its cycle leaves a limb 1 rad from where it began"
    assert found["flat"] == "it does not move y"


def test_no_stored_gait_has_a_fault_for_any_of_some_swimmers() -> None:
    for body in (Swimmer(), Swimmer(slenderness=0.02, limb_half_length_m=0.14), Swimmer(max_bend_rad=0.4)):
        assert unfit_gaits(stored_gaits().values(), body) == {}
    assert fault(realise(stored_gaits()["printed-x"], Swimmer()), "none", Swimmer()) == ""
    assert fault(realise(stored_gaits()["printed-x"], Swimmer()), "x", Swimmer()) != ""


def test_a_plan_names_what_it_leaves_out_and_is_as_without_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where one takes a stored gait's name; it is not tried, which took a quarter of a minute: the foil counts."""
    own = own_gaits(written(folder / "more", **{"x-motion": f"x|{SQUARE}"})) | own_gaits(folder)
    tried: list[str] = []
    realised = gait_sequence.pure_stroke.realise_displacement

    def noted(gait, *others):  # type: ignore[no-untyped-def]
        tried.append(gait.summary)
        return realised(gait, *others)

    monkeypatch.setattr(gait_sequence.pure_stroke, "realise_displacement", noted)
    goal = Configuration.from_angles((1.0, 0.0, 0.0))
    quick = PlanOptions(effort="quick")
    found = plan(Configuration(), goal, options=quick, gaits={**stored_gaits(), **own})
    assert set(found.plan.left_out) == {"drifty", "ajar", "flat", "x-motion"}
    assert tried
    assert "of one's own" not in tried
    plain = plan(Configuration(), goal, options=quick)
    assert plain.plan.left_out == {}
    assert np.array_equal(found.trajectory.pose, plain.trajectory.pose)


@pytest.mark.slow
def test_commands_name_them_on_standard_error(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    run = runner(capsys)
    code, _, err = run("plan", "roll", "--gaits", str(folder), "--effort", "quick")
    assert code == 0
    assert "gait drifty is left out: it moves y too, by 0.0299 L a cycle\n" in err
    assert err.count("is left out") == 3
    code, _, err = run("batch", "roll", "--gaits", str(folder), "--effort", "quick", "--jobs", "1")
    assert code == 0
    assert err.count("is left out") == 3
    code, _, err = run("gait", "drifty", "--gaits", str(folder))
    assert (code, err) == (0, "gait drifty is said to move x, but it moves y too, by 0.0299 L a cycle\n")
    assert run("gait", "played", "--gaits", str(folder))[2] == ""
