"""The atlas: Lie brackets against the exact flow, efficiency, sweeps, and what the command shows."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from helpers import PITCH_1, UNIT, YAW_1, YAW_2, assert_close, bent, random_shapes, random_swimmer, slope

from purcell_cli.cli.app import _run
from purcell_cli.errors import GaitError, ParameterError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.gaits.atlas import atlas, efficiency, entry, ratio_sweep, steps, straight_drag, sweep
from purcell_cli.gaits.gait import Stroke
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.gaits.shape_curves import WayPoints, played
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.curvature import bracket_twists
from purcell_cli.lie_brackets.leading_order import predicted
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR, connection, power
from purcell_cli.mechanics.lift import flow, piece_effort
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

GAITS = stored_gaits()


def test_a_small_loop_anywhere_moves_the_base_by_its_area_times_the_curvature() -> None:
    rng = np.random.default_rng(3)
    shape = random_shapes(rng, 1)
    swimmer = dataclasses.replace(random_swimmer(rng)).scaled()
    found = bracket_twists(swimmer, shape)[0]
    for i, j in ((YAW_1, YAW_2), (PITCH_1, YAW_2), (0, YAW_2)):
        sizes = np.array([0.004, 0.002, 0.001])
        off = []
        for e in sizes:
            loop = PrimitiveSequence(np.array([i, j, i, j]), np.array([e, e, -e, -e]))
            off.append(float(np.max(np.abs(se3.log(flow(swimmer, loop, shape[0])) - e**2 * found[i, j]))))
        assert abs(slope(sizes, off) - 3.0) < 0.15
        assert_close(found[i, j], -found[j, i], 1e-12)


def test_the_prediction_errs_by_one_order_more_with_each_order_taken() -> None:
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 6))
    sizes = np.array([2e-3, 1e-3, 5e-4])
    errors = np.empty((3, 3))
    for k, size in enumerate(sizes):
        stroke = Stroke("loop", 1.0, *played(WayPoints(points), size))
        exact = se3.log(stroke.displacement(UNIT))
        orders = np.cumsum(predicted(UNIT, stroke.played()).orders, axis=0)
        errors[k] = np.max(np.abs(exact - orders), axis=1)
    for order in (1, 2, 3):
        assert abs(slope(sizes, errors[:, order - 1]) - (order + 1)) < 0.15


@pytest.mark.parametrize(("name", "order"), [("x-motion", 2), ("y-motion", 3), ("z-rotation", 3), ("printed-phi", 1)])
def test_gaits_follow_their_leading_order_at_small_amplitudes(name: str, order: int) -> None:
    small, large = sweep(GAITS[name], UNIT, [0.02, 1.0]).rows
    assert small.displacement is not None
    assert small.prediction is not None
    assert small.order == large.order == order
    assert abs(small.prediction / small.displacement - 1.0) < 1e-3
    if order > 1:
        assert abs(large.prediction / large.displacement - 1.0) > 0.05


def test_a_sweep_marks_where_the_direction_changes() -> None:
    found = sweep(GAITS["x-motion"], UNIT, steps("1.3:1.8:0.1", "--sweep"))
    assert [row.reversed for row in found.rows].index(True) == 3
    assert sum(row.reversed for row in found.rows) == 1
    assert found.along == "x"


def test_efficiency_is_one_of_the_path_not_of_its_pace() -> None:
    stroke = realise(GAITS["max-efficiency"], UNIT)
    distance = float(np.linalg.norm(stroke.displacement(UNIT)[:3, 3]))
    slow = MoveSequence(stroke.cycle.rates() * 0.5, stroke.cycle.duration * 2.0)
    uneven = dataclasses.replace(stroke, cycle=slow)
    assert abs(efficiency(UNIT, uneven, distance) / efficiency(UNIT, stroke, distance) - 1.0) < 1e-12
    tall = dataclasses.replace(UNIT, viscosity_pa_s=7.0, joint_rate_rad_s=3.0)
    assert abs(efficiency(tall, stroke, distance) / efficiency(UNIT, stroke, distance) - 1.0) < 1e-12
    found = {name: entry(GAITS[name], UNIT) for name in ("max-efficiency", "max-displacement")}
    assert found["max-efficiency"].efficiency > found["max-displacement"].efficiency
    as_played = (
        straight_drag(UNIT) * distance**2 / found["max-efficiency"].energy_j / found["max-efficiency"].duration_s
    )
    assert 0.8 * found["max-efficiency"].efficiency < as_played < found["max-efficiency"].efficiency


def test_effort_is_the_integral_of_the_root_of_power_and_drag_that_of_the_straight_swimmer() -> None:
    shape, rate = bent(0.4, -0.7), np.array([0.3, -0.2, 1.0, 0.1, 0.5, -0.4])
    short = 1e-4
    found = piece_effort(UNIT, Pieces(shape[None], rate[None], np.array([short])))[0]
    assert abs(found / (short * np.sqrt(power(UNIT, shape, rate))) - 1.0) < 1e-3
    pulled: Array = np.zeros((1, 6))
    pulled[0, 0] = 1.0
    spread = sum(float(UNIT.drag_matrix(link)[0, 0]) for link in (0, 1, 2))
    assert abs(straight_drag(UNIT) / spread - 1.0) < 1e-12
    assert connection(UNIT, COLLINEAR).shape == (6, 6)


def test_the_drag_of_the_straight_swimmer_is_that_of_links_that_feel_each_other() -> None:
    """One rod three links long drags less than three rods: the links' own drags made efficiencies a fifth too large."""
    alone = Swimmer(slenderness=0.1)
    beads = dataclasses.replace(alone, fluid="beads")
    along, radius = np.arange(-14.0, 15.0, 2.0), 1.0
    apart = np.abs(along[:, None] - along)
    far = np.where(apart > 0.0, apart, 1.0)
    mobility = np.where(apart > 0.0, 1.5 * radius / far - (radius / far) ** 3, 1.0)
    rod = 6.0 * np.pi * beads.viscosity_pa_s * 0.02 * float(np.sum(np.linalg.inv(mobility)))
    assert abs(straight_drag(beads) / rod - 1.0) < 1e-9
    assert straight_drag(beads) < 0.9 * straight_drag(alone)


def test_the_best_ratio_of_links_for_small_square_strokes() -> None:
    gait = GAITS["x-cruise"]
    along, rows = ratio_sweep(gait, Swimmer(), 0.02, steps("0.66:0.78:0.01", "--link-ratio"))
    best = max(rows, key=lambda row: row.displacement)
    (two,) = ratio_sweep(gait, Swimmer(), 0.02, np.array([2.0]))[1]
    assert along == "x"
    assert abs(best.ratio - 0.72) < 0.015
    assert abs(best.displacement / two.displacement - 1.57) < 0.01


@pytest.mark.parametrize("text", ["1", "1:2", "0:1:0.1", "2:1:0.1", "1:2:0", "1:2:nan", "a:b:c", "1:2:1e-9"])
def test_steps_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(ParameterError, match=r"--sweep: A:B:STEP .* is wanted, found"):
        steps(text, "--sweep")
    assert_close(steps("0.1:0.3:0.1", "--sweep"), [0.1, 0.2, 0.3], 1e-15)


@pytest.mark.slow
def test_the_command_shows_and_writes_the_atlas(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "atlas.csv"
    assert _run(["gait", "--all", "--json", "--out", str(file)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document) == {"schema", "verdict", "swimmer", "gaits", "left_out", "atlas"}
    assert document["schema"] == "purcell/atlas/1"
    with file.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["gait"] for row in rows] == list(GAITS)
    x_motion = next(row for row in rows if row["gait"] == "x-motion")
    assert abs(float(x_motion["x_L"]) - 0.114731120) < 1e-8
    assert float(x_motion["x_L"]) == next(g["x_L"] for g in document["gaits"] if g["gait"] == "x-motion")
    assert _run(["gait", "--all"]) == 0
    assert "max-displacement" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command_shows_sweeps_and_refuses_two_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "sweep.csv"
    assert _run(["gait", "x-motion", "--sweep", "1.4:1.6:0.2", "--json", "--out", str(file)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document) == {"schema", "verdict", "gait", "swimmer", "along", "unit", "rows", "sweep"}
    assert [row["reversed"] for row in document["rows"]] == [False, True]
    assert file.read_text().startswith("amplitude_rad,displacement,prediction,order,reversed\n1.4,0.0449")
    assert _run(["gait", "x-cruise", "--link-ratio", "0.7:2:1.3", "--amplitude", "0.1"]) == 0
    assert "most" in capsys.readouterr().out
    assert _run(["gait", "x-rotation", "--sweep", "3:3.1:0.1"]) == 0
    assert _run(["gait", "--all", "--sweep", "1:2:1"]) == 2
    assert _run(["gait", "x-motion", "--sweep", "1:2"]) == 2


def test_links_that_feel_each_other_play_no_stroke_beyond_their_bends() -> None:
    """Their table ends at 1.6 rad: at 2.5 rad it made a way of x-fold that is three times as long as the spheres'."""
    swimmer = Swimmer(slenderness=0.1, fluid="beads")
    words = "at most 1.6 rad, for links that feel each other, are wanted, found 2.5 rad"
    with pytest.raises(GaitError, match=f"gait 'x-fold': limbs bent by {words}"):
        entry(GAITS["x-fold"], swimmer)
    with pytest.raises(GaitError, match=words):
        sample_stroke(swimmer, Configuration(), realise(GAITS["x-fold"], swimmer), 1)
    assert entry(GAITS["x-fold"], swimmer, 0.5).joint_travel_rad > 0.0
    few = {name: GAITS[name] for name in ("x-motion", "x-fold")}
    entries, left_out = atlas(few, swimmer)
    assert [one.gait.name for one in entries] == ["x-motion"]
    assert list(left_out) == ["x-fold"]
    assert words in left_out["x-fold"]
    rows = sweep(GAITS["x-motion"], swimmer, [1.5, 1.7]).rows
    assert [row.displacement is None for row in rows] == [False, True]
    assert entry(GAITS["x-fold"], Swimmer(slenderness=0.1)).joint_travel_rad > 0.0
