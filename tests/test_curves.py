"""Closed curves of shapes: what they are played as, and the two strokes that others published."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers import UNIT, assert_close, dop853_rates, in_lengths, is_close, slope

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.files.gait_file import load_gait
from purcell_cli.gaits.gait import Stroke
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.gaits.shape_curves import Fourier, WayPoints, played, straight_moves
from purcell_cli.geometry.rotations import as_euler, as_vector
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.swimmer import Swimmer

EQUAL = Swimmer(base_half_length_m=1 / 6, limb_half_length_m=1 / 6)
"""Equal links, total length 1, drag ratio 2."""
PUBLISHED = {"max-displacement": 0.103516, "max-efficiency": 0.087273}


def ellipse(steps: int) -> Fourier:
    cosine, sine = np.zeros((2, 1, 6))
    cosine[0, 2], cosine[0, 5], sine[0, 2] = 1.3, -0.7, 0.8
    return Fourier(np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.1]), cosine, sine, steps)


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_published_strokes_go_as_far_as_published_and_do_not_turn(name: str) -> None:
    stroke = realise(stored_gaits()[name], EQUAL)
    g = stroke.displacement(EQUAL)
    assert abs(float(np.linalg.norm(g[:3, 3])) - PUBLISHED[name]) <= 5e-7
    assert_close(as_euler(g[:3, :3]), np.zeros(3), 1e-12)
    assert stroke.closure_rad() <= 1e-14
    foil = Swimmer(base_half_length_m=1 / 6, limb_half_length_m=1 / 6, drag_ratio=1.9)
    assert abs(float(np.linalg.norm(stroke.displacement(foil)[:3, 3])) - PUBLISHED[name]) > 1e-3


def test_the_published_strokes_agree_with_an_independent_integration() -> None:
    stroke = realise(stored_gaits()["max-efficiency"], UNIT)
    sequence = stroke.cycle[:40]
    start = stroke.approach.shapes(COLLINEAR)[-1]
    assert_close(flow(UNIT, sequence, start), dop853_rates(UNIT, sequence.rates(), sequence.duration, start), 1e-11)


def test_a_series_turns_right_to_fourth_order_and_heads_right_to_second() -> None:
    def end(steps: int) -> np.ndarray:
        approach, cycle = played(ellipse(steps), 1.0)
        return Stroke("ellipse", 1.0, approach, cycle).displacement(UNIT)

    steps = np.array([16, 32, 64])
    exact = end(1024)
    ends = [end(n) for n in steps]
    turned = [abs(as_euler(g[:3, :3])[0] - as_euler(exact[:3, :3])[0]) for g in ends]
    assert abs(slope(1.0 / steps, turned) - 4.0) < 0.15
    off = [float(np.max(np.abs(g[:3, 3] - exact[:3, 3]))) for g in ends]
    assert abs(slope(1.0 / steps, off) - 2.0) < 0.15
    assert off[-1] < 2e-6


def test_way_points_are_passed_and_the_curve_closes() -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.8, 0.8, (7, 6))
    approach, cycle = played(WayPoints(points), 1.0)
    shapes = cycle.shapes(approach.shapes(COLLINEAR)[-1])
    assert_close(as_vector(shapes[:-1]).reshape(-1, 6), points, 1e-14)
    assert_close(shapes[-1], shapes[0], 1e-14)
    assert not is_close(shapes[1], shapes[0], 1e-2)


def test_a_straight_move_about_one_axis_may_be_longer_than_half_a_turn() -> None:
    moves = straight_moves([[0, 0, -2, 0, 1, 0], [0, 0, 2, 0, 1, 0]])
    assert_close(moves.turn, [[0, 0, 4, 0, 0, 0]], 1e-15)
    with pytest.raises(ParameterError, match="limb 1's rotation vector changes by more than 3 rad"):
        straight_moves([[0, 0, -2, 0, 0, 0], [0, 1e-3, 2, 0, 0, 0]])


def test_an_amplitude_scales_the_curve_and_backwards_undoes_it() -> None:
    gait = stored_gaits()["max-efficiency"]
    half = realise(gait, UNIT, 0.5 * gait.default_rad)
    assert_close(half.cycle.rates() * half.cycle.duration[:, None], 0.5 * realise(gait, UNIT).cycle.turn, 1e-15)
    back = realise(gait, UNIT, -0.5 * gait.default_rad)
    assert_close(half.displacement(UNIT) @ back.displacement(UNIT), np.eye(4), 1e-12)


def test_rows_of_a_curve_end_where_the_stroke_does() -> None:
    stroke = realise(stored_gaits()["max-displacement"], EQUAL)
    rows = sample_stroke(EQUAL, Configuration(), stroke, 2)
    assert_close(in_lengths(EQUAL, rows.pose[-1]), in_lengths(EQUAL, stroke.displacement(EQUAL, 2)), 1e-11)
    assert np.max(np.abs(rows.rate_rad_s)) <= 1.0
    assert_close(rows.shape[-1], COLLINEAR, 1e-12)


CURVE = """\
name: mine
summary: mine
moves: none
curve:
  way_points:
    - [[0, 0, 1], [0, 0, -1]]
    - [[0, 0.5, 0], [0, 0, 0.5]]
    - [[0, 0, -1], [0, 0, 1]]
"""


def test_a_file_may_hold_way_points_or_a_series(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(CURVE)
    gait = load_gait(file)
    assert isinstance(gait.curve, WayPoints)
    assert gait.default_rad == 1.0
    assert_close(gait.curve.vectors[1], [0, 0.5, 0, 0, 0, 0.5], 0.0)
    series = "  fourier:\n    constant: {limb2 yaw: 0.1}\n    sine: {limb1 pitch: [0, 0.2]}\n    steps: 64\n"
    file.write_text(CURVE[: CURVE.index("  way_points")] + series)
    curve = load_gait(file).curve
    assert isinstance(curve, Fourier)
    assert (curve.steps, curve.sine[1, 1], curve.constant[5], len(curve.corners)) == (64, 0.2, 0.1, 65)


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("moves: none", "moves: x", ("moves", "only played")),
        ("moves: none", "moves: none\ncycle: [{limb1 yaw: 1}]", ("cycle", "no such key beside a curve")),
        ("0.5, 0]", "0.5]", ("curve.way_points[1][0]", "a list of 3")),
        ("[0, 0, -1]]", "[0, 0, -4]]", ("curve", "at most pi")),
        ("[[0, 0, -1]", "[[0, -2.5, -1.5]", ("curve.way_points", "between numbers 1 and 2")),
        ("  way_points", "  fourier: {steps: 64}\n  way_points", ("curve", "exactly one")),
    ],
)
def test_a_fault_in_a_curve_is_told_where_it_is(tmp_path: Path, old: str, new: str, parts: tuple[str, ...]) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(CURVE.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_gait(file)
    assert all(part in str(caught.value) for part in parts), str(caught.value)


def test_a_series_without_coefficients_or_with_too_few_steps_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="steps"):
        Fourier(np.zeros(6), np.ones((3, 6)), np.zeros((3, 6)), 16)
    file = tmp_path / "mine.yaml"
    file.write_text(CURVE[: CURVE.index("  way_points")] + "  fourier: {steps: 64}\n")
    with pytest.raises(InputError, match="a coefficient of cosine or sine"):
        load_gait(file)
    assert math.isclose(stored_gaits()["max-efficiency"].default_rad, 1.5, abs_tol=0.5)
