"""The command verify: limits that are broken, rows of another swimmer, long files in parts, plan documents."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, runner

from purcell_cli import Configuration, PlanOptions, PrimitiveSequence, Swimmer, Workspace, plan
from purcell_cli.cli.app import _run
from purcell_cli.files import trajectory_reader
from purcell_cli.files.plan_file import PlanDocument, write_plan
from purcell_cli.files.trajectory_csv import write_csv
from purcell_cli.files.trajectory_formats import write_trajectory
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.trajectory import as_table, sample
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.solution import Solution
from purcell_cli.verification.limits_kept import NOTHING_MORE, Wanted
from purcell_cli.verification.verify import misfit, verify

START = Configuration()
PAPER = Swimmer()
OTHER = Swimmer(limb_half_length_m=0.12)


def swum(*primitives: tuple[str, float], swimmer: Swimmer = PAPER, phase: int = 2) -> tuple[Table, Configuration]:
    """Return the rows of primitives from the collinear shape, and where they end."""
    blocks = (Block(phase, "own", PrimitiveSequence.of(list(primitives))),)
    rows = sample(swimmer, START, blocks, 0.0625)
    return as_table(rows), rows.end


def faults(table: Table, goal: Configuration, swimmer: Swimmer = PAPER, wanted: Wanted = NOTHING_MORE) -> str:
    """Return what the check of rows finds wrong, a line each."""
    return "\n".join(verify([table], START, goal, swimmer, 1e-9, 1e-9, wanted).faults)


THROUGH = (("limb1 yaw", 2.9), ("limb2 yaw", -2.9), ("limb1 yaw", -2.9), ("limb2 yaw", 2.9))
"""Both limbs folded back on the same side of the base."""


def test_limbs_that_pass_through_each_other_are_found() -> None:
    free = Swimmer(max_bend_rad=3.0)
    table, goal = swum(*THROUGH, swimmer=free)
    found = verify([table], START, goal, free, 1e-9, 1e-9)
    assert found.certificate.reached
    assert not found.holds
    assert found.limits.clearance.distance_m < 0.0
    assert len(found.faults) == 1
    assert "limb 1 and limb 2 are" in found.faults[0]
    assert "(they overlap), less than 0 mm" in found.faults[0]


def test_bends_are_held_against_the_swimmers_limit() -> None:
    table, goal = swum(("limb1 yaw", 1.5), ("limb1 yaw", -1.5))
    assert faults(table, goal, Swimmer(max_bend_rad=1.5)) == ""
    assert "limb 1 bends by 1.5 rad in phase 2, more than 1.4 rad" in faults(table, goal, Swimmer(max_bend_rad=1.4))


def test_in_phase_3_a_limb_may_bend_as_far_as_at_the_goal() -> None:
    table, goal = swum(("limb1 yaw", 1.5), phase=3)
    assert faults(table, goal) == ""
    table, goal = swum(("limb1 yaw", 1.6), ("limb1 yaw", -0.1), phase=3)
    assert "limb 1 bends by 1.6 rad in phase 3, more than 1.5 rad" in faults(table, goal)


def test_a_clearance_is_judged_when_asked() -> None:
    table, goal = swum(("limb1 yaw", 1.0), ("limb2 yaw", 1.0), ("limb1 yaw", -1.0), ("limb2 yaw", -1.0))
    near = verify([table], START, goal, Swimmer(), 1e-9, 1e-9).limits.clearance.distance_m
    assert faults(table, goal, wanted=Wanted(near - 1e-6)) == ""
    assert "limb 1 and limb 2" in faults(table, goal, wanted=Wanted(near + 1e-6))


def test_a_workspace_is_judged_between_the_rows_too() -> None:
    table, goal = swum(("limb1 yaw", 1.0), ("limb1 yaw", -1.0))
    far = Workspace((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert faults(table, goal, wanted=Wanted(0.0, far)) == ""
    blocks = (Block(2, "own", PrimitiveSequence.of([("limb1 yaw", 1.0), ("limb1 yaw", -1.0)])),)
    coarse = as_table(sample(PAPER, START, blocks, 9.0))
    assert len(coarse.time_s) == 3
    near = Workspace((-1.0, -1.0, -1.0), (1.0, 0.05, 1.0))
    assert "end of limb 1 is" in faults(table, goal, wanted=Wanted(0.0, near))
    assert "end of limb 1 is" in faults(coarse, goal, wanted=Wanted(0.0, near))


@pytest.mark.parametrize(
    ("swimmer", "fits"),
    [
        (Swimmer(), True),
        (Swimmer(viscosity_pa_s=3.0, joint_rate_rad_s=7.0, max_bend_rad=0.3), True),
        (OTHER, False),
        (Swimmer(drag_ratio=1.99), False),
        (Swimmer(slenderness=0.011), False),
    ],
)
def test_rows_tell_whether_a_swimmer_can_have_made_them(swimmer: Swimmer, fits: bool) -> None:
    table, goal = swum(
        ("limb1 yaw", 0.5),
        ("limb2 pitch", 0.5),
        ("limb1 roll", 0.5),
        ("limb1 yaw", -0.5),
        ("limb2 pitch", -0.5),
        ("limb1 roll", -0.5),
    )
    assert (misfit(table, swimmer) <= 1e-6) is fits
    assert ("see --swimmer" in faults(table, goal, swimmer)) is not fits


def test_one_wrong_row_is_no_other_swimmer() -> None:
    table, goal = swum(("limb1 yaw", 0.5), ("limb2 pitch", 0.5), ("limb1 roll", 0.5))
    moved = table.position_m.copy()
    moved[5] += 1e-4
    found = faults(dataclasses.replace(table, position_m=moved), goal)
    assert "line 7" in found
    assert "see --swimmer" not in found


@pytest.mark.parametrize(("off", "told"), [(1e-6, True), (1e-12, False)])
@pytest.mark.parametrize("link", ["base", "limb 1", "limb 2"])
def test_a_quaternion_of_another_length_is_told(link: str, off: float, told: bool) -> None:
    table, goal = swum(("limb1 yaw", 0.5), ("limb2 pitch", 0.5))
    quaternions = {"base": table.base.copy(), "limb 1": table.limbs.copy(), "limb 2": table.limbs.copy()}
    row = {"base": 0, "limb 1": (3, 0), "limb 2": (3, 1)}[link]
    quaternions[link][row] *= 1.0 + off
    field = "base" if link == "base" else "limbs"
    found = faults(dataclasses.replace(table, **{field: quaternions[link]}), goal)
    line = 2 if link == "base" else 5
    assert found == (f"line {line}: the {link}'s quaternion has a length of 1.000001, not 1" if told else "")


def solved() -> Solution:
    """Return a plan with a clearance."""
    goal = Configuration.from_angles((0.02, 0.0, 0.0), (20.0, 0.0, 0.0))
    return plan(START, goal, swimmer=OTHER, options=PlanOptions(effort="quick", clearance_m=0.01))


def document(run: Run, *arguments: str) -> tuple[int, dict[str, Any], str]:
    """Run a command with --json and return its exit code, its document and what it said on stderr."""
    code, out, err = run(*arguments, "--json")
    return code, json.loads(out), err


@pytest.mark.slow
def test_a_plan_document_says_who_swims_and_what_must_hold(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made, run = solved(), runner(capsys)
    rows, saved = str(tmp_path / "swim.csv"), str(tmp_path / "plan.json")
    write_csv(made.trajectory, rows)
    write_plan(PlanDocument(made.plan, made.options), saved)
    code, found, _ = document(run, "verify", rows, saved)
    assert (code, found["verdict"], found["faults"]) == (0, "reached", [])
    assert found["judged"] == {
        "clearance_m": 0.01,
        "max_bend_rad": 1.0,
        "workspace_m": None,
        "joint_rate_rad_s": [1.0, 1.0],
        "joint_acceleration_rad_s2": None,
        "joint_ranges": False,
    }
    code, found, _ = document(run, "verify", rows, saved, "--clearance", "5")
    assert (code, found["verdict"]) == (1, "not reached")
    page = str(tmp_path / "page.html")
    _, _, err = document(run, "view", rows, "--out", page)
    assert "its rows move otherwise than this swimmer does" in err
    assert "--swimmer takes the swimmer's file or the plan document" in err
    _, _, err = document(run, "view", rows, "--out", page, "--swimmer", saved)
    assert err == ""
    picture = str(tmp_path / "picture.svg")
    for draw in (("view", rows, "--out", page), ("plot", rows, "--out", picture)):
        assert document(run, *draw, "--scenario", saved)[2] == ""  # whose plan it is says whose rows they are
        assert "its rows move otherwise" in document(run, *draw, "--scenario", saved, "--swimmer", "paper")[2]


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [False, True])
def test_long_files_are_read_in_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: bool) -> None:
    made = solved()
    rows = tmp_path / "swim.csv"
    write_csv(made.trajectory, rows)
    whole = trajectory_reader.read_csv(rows)
    monkeypatch.setattr(trajectory_reader, "_PART_BYTES", 20_000)
    parts = list(trajectory_reader.read_parts(rows))
    assert len(parts) > 3
    for field in dataclasses.fields(Table):
        np.testing.assert_array_equal(getattr(trajectory_reader.read_csv(rows), field.name), getattr(whole, field.name))
    if wrong:
        moved = parts[2].position_m.copy()
        moved[3] += 1e-6
        parts[2] = dataclasses.replace(parts[2], position_m=moved)
    asked = (START, made.plan.goal, OTHER, 1e-9, 1e-9)
    found = verify(parts, *asked)
    line = sum(len(p.time_s) - 1 for p in parts[:2]) + 3 + 2
    assert [f"line {line} " in text for text in found.faults] == ([True] if wrong else [])
    assert np.isclose(found.certificate.bound.base_rad, verify([whole], *asked).certificate.bound.base_rad, rtol=0.1)


@pytest.mark.parametrize("form", ["parquet", "npz"])
def test_files_for_other_programs_name_the_swimmer(tmp_path: Path, form: str) -> None:
    import polars as pl

    made = solved()
    path = tmp_path / f"swim.{form}"
    write_trajectory(made.trajectory, path, form, OTHER)
    text = str(np.load(path)["swimmer"]) if form == "npz" else pl.read_parquet_metadata(path)["swimmer"]
    assert Swimmer(**json.loads(text)) == OTHER


def test_a_row_that_would_turn_for_ever_is_refused_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A time that lost its point: 3e9 s of turning would be ten thousand million pieces."""
    file = tmp_path / "swim.csv"
    goal = Configuration.from_angles((0, 0, 0), (0, 0, 20), (0, 0, 0), (0, 0, 0))
    write_csv(plan(Configuration(), goal).trajectory, file)
    rows = file.read_text().splitlines()
    rows[-1] = ",".join(["3e9", *rows[-1].split(",")[1:]])
    file.write_text("\n".join(rows) + "\n")
    assert _run(["verify", str(file), "roll"]) == 2
    assert "rad at the most" in capsys.readouterr().err


def test_a_trajectory_that_is_given_last_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert _run(["verify", "nearby", "trajectory.csv"]) == 2
    assert "START: a YAML file or a scenario's name is wanted, found trajectory.csv; the trajectory comes first" in (
        capsys.readouterr().err
    )


def test_beads_that_are_solved_anew_show_at_once_that_work_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """That takes minutes, of which reading the file, which is what the bar counts, is the first instant."""
    monkeypatch.chdir(tmp_path)
    rows = sample(PAPER, START, (Block(2, "own", PrimitiveSequence.of([("limb1 yaw", 0.1)] * 2)),), 0.0625)
    write_csv(rows, tmp_path / "swim.csv")
    (tmp_path / "start.yaml").write_text("{}\n")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    for words, shown in (([], False), (["--full"], True)):
        assert _run(["verify", "swim.csv", "start.yaml", "start.yaml", *words]) == 1
        err = capsys.readouterr().err
        assert ("re-integrating" in err) == ("--full changes nothing" in err) == shown
