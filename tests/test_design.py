"""The designer: its gradients, its bars, what it promises of a stroke, and the command."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import UNIT, assert_close, dop853_rates, in_lengths

from purcell_cli.cli.app import _run
from purcell_cli.errors import GaitError, ParameterError, UnknownNameError
from purcell_cli.files.builtin import find_swimmer, stored_gaits
from purcell_cli.files.gait_file import gait_text, load_gait, write_gait
from purcell_cli.gaits import design as designer
from purcell_cli.gaits.design import design
from purcell_cli.gaits.design_problem import DesignTask, Problem
from purcell_cli.gaits.gait import Gait
from purcell_cli.gaits.joint_fit import bend_room_rad, refuse_joints
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.geometry.rotations import as_euler, as_vector
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint
from purcell_cli.mechanics.lift import EXACT
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

SQUARE = DesignTask("x", "speed", 2.5, planar=True, controls="primitive", moves=4)


@pytest.mark.slow
@pytest.mark.parametrize(
    "task",
    [
        DesignTask("yaw", planar=False, moves=4),
        DesignTask("x", "efficiency", moves=4),
        DesignTask("y", planar=False, controls="primitive", moves=7),
        DesignTask("z", moves=4),
    ],
    ids=["spatial", "efficiency", "primitive", "pitch plane"],
)
def test_every_slope_agrees_with_differences_of_its_values(task: DesignTask) -> None:
    rng = np.random.default_rng(0)
    problem = Problem.of(task, Swimmer(), rng)
    unknown, step = 0.3 * rng.normal(size=int(problem.free.sum())), 1e-6
    values = problem.at(unknown, 1e-2, EXACT)
    for k in range(len(unknown)):
        moved = step * np.eye(len(unknown))[k]
        up, down = problem.at(unknown + moved, 1e-2, EXACT), problem.at(unknown - moved, 1e-2, EXACT)
        for name in ("gain", "cost", "gap", "room"):
            found = (np.asarray(getattr(up, name)) - np.asarray(getattr(down, name))) / (2.0 * step)
            assert_close(getattr(values, f"{name}_slope")[..., k], found, 1e-7)


@pytest.mark.slow
def test_a_square_of_single_joints_is_found_that_beats_the_centred_one() -> None:
    found = design(UNIT, SQUARE, starts=3)
    assert found.ratio >= 0.0460
    stroke = realise(found.gait, UNIT)
    assert len(stroke.cycle) == 4
    end = in_lengths(UNIT, dop853_rates(UNIT, stroke.played().rates(), stroke.played().duration, COLLINEAR))
    assert_close(end[1:3, 3], np.zeros(2), 1e-10)
    assert_close(as_euler(end[:3, :3]), np.zeros(3), 1e-10)
    assert abs(end[0, 3] / stroke.cycle.joint_travel_rad - found.ratio) < 1e-10
    assert found.largest_bend_rad <= 2.5 + 1e-6
    assert gait_text(design(UNIT, SQUARE, starts=3).gait) == gait_text(found.gait)


@pytest.mark.slow
def test_all_joints_at_once_go_farther_than_the_bar_per_joint_travel() -> None:
    found = design(UNIT, DesignTask("x", "speed", 2.5, moves=12), starts=1)
    assert found.ratio >= 0.0490
    stroke = realise(found.gait, UNIT)
    assert isinstance(stroke.cycle, MoveSequence)
    assert abs(np.sum(np.abs(stroke.cycle.turn)) * found.ratio - found.entry.displacement[0]) < 1e-9
    assert np.max(np.abs(found.entry.displacement[1:])) < 1e-10


@pytest.mark.slow
def test_a_spatial_turn_has_one_axis_and_keeps_its_bends_at_every_instant() -> None:
    found = design(UNIT, DesignTask("yaw", "speed", 1.0, planar=False, moves=4), starts=1, seed=2)
    stroke = realise(found.gait, UNIT)
    moves = MoveSequence.of_controls(stroke.cycle)
    part = np.repeat(np.arange(len(moves)), 50)
    fine = moves.lasting(part, moves.duration[part] / 50.0)
    axes = fine.shapes(stroke.approach.shapes(COLLINEAR)[-1])[..., 0]
    assert np.max(np.arccos(axes[..., 0])) <= 1.0 + 2e-6
    assert np.max(np.abs(axes[..., 2])) > 1e-2
    assert np.max(np.abs(found.entry.displacement[[3, 4]])) < 1e-10
    assert found.entry.displacement[5] > 0.0
    assert stroke.closure_rad() < 1e-9


@pytest.mark.slow
def test_efficiency_is_what_efficiency_asks_for() -> None:
    fast, lean = (design(UNIT, DesignTask("x", aim, 1.0, moves=6), starts=1) for aim in ("speed", "efficiency"))
    assert lean.entry.efficiency > fast.entry.efficiency
    assert fast.ratio > lean.ratio


def test_an_interrupt_keeps_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = design(UNIT, SQUARE, starts=1)

    def stop(done: int, news: str) -> None:
        if done:
            raise KeyboardInterrupt

    assert gait_text(design(UNIT, SQUARE, starts=9, progress=stop).gait) == gait_text(whole.gait)
    monkeypatch.setattr(designer, "_from", lambda *_: stop(1, ""))
    with pytest.raises(KeyboardInterrupt):
        design(UNIT, SQUARE)


def test_no_stroke_found_and_tasks_that_are_none_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UnknownNameError, match="direction: one of x, y, z, roll, pitch, yaw is wanted, found 'w'"):
        DesignTask("w")
    for wrong in (
        {"max_bend_rad": 0.0},
        {"moves": 2},
        {"direction": "roll"},
        {"direction": "yaw", "maximize": "efficiency"},
    ):
        with pytest.raises(ParameterError):
            DesignTask(**wrong)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="starts"):
        design(UNIT, SQUARE, starts=0)
    with pytest.raises(ParameterError, match=r"max_bend: limbs bent by at most 1\.6 rad, .* found 2\.5 rad"):
        design(Swimmer(slenderness=0.1, fluid="beads"), DesignTask("x", max_bend_rad=2.5), starts=1)
    monkeypatch.setattr(designer, "_from", lambda *_: None)
    with pytest.raises(GaitError, match="none of 2 starts led to a stroke along x"):
        design(UNIT, SQUARE, starts=2)


@pytest.mark.parametrize("name", stored_gaits())
def test_a_gait_written_is_the_gait_read(name: str, tmp_path: Path) -> None:
    gait = stored_gaits()[name]
    write_gait(gait, tmp_path / "gait.yaml")
    again = load_gait(tmp_path / "gait.yaml")
    assert fields(again) == fields(gait)


def fields(gait: Gait) -> dict[str, object]:
    out = {name: getattr(gait, name) for name in Gait.__dataclass_fields__ if name != "curve"}
    return {**out, "curve": None if gait.curve is None else gait.curve.corners.tolist()}


@pytest.mark.slow
def test_the_command_writes_a_gait_that_the_other_commands_play(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "my stroke.yaml"
    square = ["--max-bend", "2.5", "--controls", "primitive", "--moves", "4", "--starts", "1"]
    assert _run(["design", *square, "--out", str(file), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document) == {
        *("schema", "verdict", "direction", "maximize", "planar", "controls", "max_bend_rad", "moves", "seed"),
        *("starts", "interrupted", "swimmer", "per_joint_travel", "unit", "largest_bend_rad", "stroke", "gait"),
    }
    assert document["unit"] == "L/rad"
    assert not document["interrupted"]
    out = tmp_path / "swim.csv"
    assert _run(["gait", "my-stroke", "--gaits", str(tmp_path), "--out", str(out), "--json"]) == 0
    played = json.loads(capsys.readouterr().out)
    assert abs(played["displacement"]["x_m"] / 0.1 - document["stroke"]["x_L"]) < 1e-12
    assert _run(["design", *square, "--out", str(file)]) == 0
    assert "L/rad of joint travel" in capsys.readouterr().out
    before = file.read_text()
    assert _run(["design", "--direction", "w", "--out", str(file)]) == 2
    assert file.read_text() == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limit_rad", "along", "ratio"),
    [
        ("turn-planar", 1.0, None, 0.0128554),
        ("turn-across", 1.0, None, 0.0158268),
        ("x-loop", 1.0, 0, 0.0458196),
        ("x-fold", 2.5, 0, 0.0621141),
        ("y-across", 1.0, 1, 0.0087758),
    ],
)
def test_the_stored_strokes_do_what_docs_say_of_them(
    name: str, limit_rad: float, along: int | None, ratio: float
) -> None:
    stroke = realise(stored_gaits()[name], UNIT)
    played = stroke.played()
    end = in_lengths(UNIT, dop853_rates(UNIT, played.rates(), played.duration, COLLINEAR))
    cost = float(np.sum(np.abs(stroke.cycle.rates()) * stroke.cycle.duration[:, None]))
    rotation = as_vector(end[:3, :3])
    if along is None:
        assert abs(np.linalg.norm(rotation) / cost - ratio) < 1e-6
        assert abs(rotation[0]) < 0.003 * np.linalg.norm(rotation)
    else:
        assert abs(end[along, 3] / cost - ratio) < 1e-6
        assert np.max(np.abs([*np.delete(end[:3, 3], along), *rotation])) < 1e-9
    sweeps = LimbCircles.of(Pieces.of(played))
    assert np.max(sweeps.largest_bends()[0]) < limit_rad + 2e-6
    assert stroke.closure_rad() < 1e-10


def test_strokes_that_joints_cannot_play_are_not_looked_for() -> None:
    """Before any search: the axis, the range and the kind; where there is room, the stroke is played."""
    planar, robot = find_swimmer("planar"), find_swimmer("robot")
    lopsided = dataclasses.replace(robot, joints=(Joint("hinge", "yaw", (5.0, 90.0)), robot.joints[1]))
    for swimmer, task, message in (
        (planar, DesignTask("z"), "joints that pitch.*limb 1 on a yaw hinge"),
        (robot, DesignTask("z", max_bend_rad=0.8), "at most 0.785398 rad.*found 0.8"),
        (robot, DesignTask("x", planar=False), "ball joints.*found a universal joint and a universal joint"),
        (lopsided, DesignTask("x"), "limb 1's psi to both sides of 0.*found .5.0, 90.0. degrees"),
    ):
        with pytest.raises(ParameterError, match=message):
            design(swimmer, task, starts=1)
    assert bend_room_rad(robot, 1) == math.radians(45.0)
    assert bend_room_rad(UNIT, None) == bend_room_rad(planar, 2) == math.inf
    found = design(robot, DesignTask("z", max_bend_rad=math.radians(45.0), controls="primitive", moves=4), starts=1)
    refuse_joints(robot, realise(found.gait, robot))
