"""Roll strokes: they roll the swimmer by what is asked for, and leave the rest as it was."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from helpers import assert_close, flown, largest_bends, missed

from purcell_cli import Swimmer, stored_gaits
from purcell_cli.gaits.pure_stroke import guessed
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.planner.arcs.roll_stroke import roll_stroke

GAIT = stored_gaits()["x-rotation"]
SWIMMERS = {
    "the paper's": Swimmer().scaled(),
    "long fat limbs": Swimmer(0.1, 0.25, slenderness=0.04).scaled(),
    "small bends": Swimmer(max_bend_rad=0.5).scaled(),
}
ANGLES = (-3.0, -0.31, 0.05, 0.9, 1.45, 2.2)
OFF = 2e-3
"""What a roll stroke by the table may miss [L, rad]: the finish makes up for it."""


def roll(angle: float) -> Array:
    return se3.pose(about_axis(0, angle), np.zeros(3))


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", SWIMMERS)
def test_a_roll_stroke_rolls_by_what_is_asked_and_nothing_else_is_left(name: str, angle: float) -> None:
    """On the exact flow, in all six components, and the limbs end as they were."""
    blocks = roll_stroke(GAIT, SWIMMERS[name]).blocks(angle)
    assert missed(roll(angle), flown(SWIMMERS[name], blocks)) < OFF
    assert_close(starting_shapes(blocks, COLLINEAR)[-1], COLLINEAR, 1e-7)


@pytest.mark.parametrize("angle", [-3.0, 0.9, 1.45])
@pytest.mark.parametrize("name", SWIMMERS)
def test_an_amplitude_that_is_off_by_one_per_cent_is_seen(name: str, angle: float) -> None:
    """The foil of the law before: it rolls by about one per cent too far."""
    swimmer = SWIMMERS[name]
    more = [
        dataclasses.replace(b, sequence=guessed(GAIT, swimmer, 1.01 * b.amplitude_rad).cycle)
        for b in roll_stroke(GAIT, swimmer).blocks(angle)
    ]
    off = missed(roll(angle), flown(swimmer, more))
    assert OFF < off < 0.05 * abs(angle)


@pytest.mark.parametrize("name", SWIMMERS)
def test_travel_is_about_that_of_the_strokes(name: str) -> None:
    turning = roll_stroke(GAIT, SWIMMERS[name])
    for angle in (*ANGLES, 0.004):
        made = sum(b.joint_travel_rad for b in turning.blocks(angle))
        assert turning.travel(np.array(angle)) == pytest.approx(made, rel=5e-3, abs=2e-3)


def test_the_other_way_round_is_the_same_mirrored() -> None:
    turning = roll_stroke(GAIT, SWIMMERS["the paper's"])
    for angle in (0.3, 1.2, 2.9):
        there, back = turning.blocks(angle), turning.blocks(-angle)
        assert len(there) == len(back)
        assert missed(roll(-angle), flown(SWIMMERS["the paper's"], back)) < OFF
        assert sum(b.joint_travel_rad for b in there) == pytest.approx(sum(b.joint_travel_rad for b in back), rel=1e-9)


def test_more_than_half_a_turn_is_less_the_other_way() -> None:
    turning = roll_stroke(GAIT, SWIMMERS["the paper's"])
    for angle in (1.5 * math.pi, -1.5 * math.pi, 4.2):
        short = math.remainder(angle, 2.0 * math.pi)
        assert [b.amplitude_rad for b in turning.blocks(angle)] == [b.amplitude_rad for b in turning.blocks(short)]
        assert turning.travel(np.array(angle)) == pytest.approx(turning.travel(np.array(short)))


def test_a_large_roll_takes_equal_strokes_and_as_few_as_do() -> None:
    turning = roll_stroke(GAIT, SWIMMERS["the paper's"])
    for angle, count in ((0.5, 1), (1.55, 1), (1.7, 2), (3.1, 2)):
        blocks = turning.blocks(angle)
        assert len({b.amplitude_rad for b in blocks}) == 1
        assert len(blocks) == count


def test_a_roll_too_slight_to_matter_takes_no_stroke() -> None:
    turning = roll_stroke(GAIT, SWIMMERS["the paper's"])
    assert turning.blocks(0.0) == []
    assert turning.blocks(9e-5) == []
    assert turning.blocks(2.0 * math.pi + 1e-6) == []
    assert turning.travel(np.array(0.0)) == 0.0


def test_where_limbs_may_bend_little_and_rolls_are_weak_strokes_bend_no_limb_too_far() -> None:
    """The smallest amplitude of the common table bends these limbs by a quarter more than they may."""
    stout = Swimmer(limb_half_length_m=0.02, slenderness=0.1, drag_ratio=1.3, max_bend_rad=0.1)
    smallest = guessed(GAIT, stout.scaled(), 0.003).cycle
    assert largest_bends(smallest).max() > 1.2 * stout.max_bend_rad
    blocks = roll_stroke(GAIT, stout.scaled()).blocks(0.2)
    assert max(largest_bends(b.sequence).max() for b in blocks) <= stout.max_bend_rad
    assert missed(roll(0.2), flown(stout.scaled(), blocks)) < OFF
