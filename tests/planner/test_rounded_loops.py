"""Rectangles that repeat become octagons in any plane through the base's axis, which swim as far in less time."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.refine.rounded_loops import segments_by_moves

SWIMMER = Swimmer().scaled()
CYCLES, SIDE_RAD = 9, 1.8
ROLLED = se3.rotation(np.array([[0.5 * np.pi, 0.0, 0.0], [-0.5 * np.pi, 0.0, 0.0]]))


def rectangle(first: int, second: int, sense: float = 1.0) -> Block:
    """Return a rectangle of two controls that repeats."""
    sides = [-SIDE_RAD, -SIDE_RAD * sense, SIDE_RAD, SIDE_RAD * sense]
    return Block(2, "arc", PrimitiveSequence([first, second, first, second], sides), CYCLES)


def at_its_corner(block: Block, home: Array) -> Array:
    """Return the shape at the corner of a rectangle that has its centre at a collinear shape. Shape (2, 3, 3)."""
    sequence = block.sequence
    assert isinstance(sequence, PrimitiveSequence)
    return PrimitiveSequence(sequence.control[:2], -0.5 * sequence.angle[:2]).shapes(home)[-1]


def lasts(segments: list) -> float:
    return sum(segment.duration for segment in segments)


def swum(segments: list, start: Array) -> Array:
    """Return where segments end. Shape (4, 4)."""
    turn = np.concatenate([np.tile(segment.turn, (segment.cycles, 1)) for segment in segments])
    return flow(SWIMMER, MoveSequence.of_turns(turn), start, SEARCHING)


@pytest.mark.parametrize(
    ("block", "home"),
    [
        (rectangle(2, 5), COLLINEAR),
        (rectangle(1, 4), COLLINEAR),
        (rectangle(1, 4, -1.0), ROLLED),  # limbs rolled by a quarter turn, opposite ways: their pitches are yaws
        (rectangle(1, 5), np.stack([ROLLED[0], COLLINEAR[1]])),
    ],
)
def test_a_rectangle_in_a_plane_becomes_an_octagon_that_swims_alike_in_less_time(block: Block, home: Array) -> None:
    start = at_its_corner(block, home)
    made = segments_by_moves(block, start, SWIMMER, None)
    plain = MoveSequence.of_controls(block.sequence).turn
    assert len(made) == 3
    assert made[1].cycles > 2
    assert lasts(made) < 0.85 * CYCLES * 4.0 * SIDE_RAD
    found, wanted = (
        swum(made, start),
        flow(SWIMMER, MoveSequence.of_turns(np.tile(plain, (CYCLES, 1))), start, SEARCHING),
    )
    assert np.linalg.norm(found[:3, 3] - wanted[:3, 3]) < 0.25 * np.linalg.norm(wanted[:3, 3])
    assert np.max(np.abs(found[:3, :3] - wanted[:3, :3])) < 0.25
    tie = made[1].tie
    assert tie is not None
    unknown = np.random.default_rng(0).normal(size=tie.shape[1])
    assert_close(np.sum((tie @ unknown).reshape(-1, 6), axis=0), np.zeros(6), 1e-12)


def test_a_rectangle_out_of_one_plane_stays_as_it_is() -> None:
    """A yaw and a pitch (the foil of the last case above): one side does not lie in the other's plane."""
    block = rectangle(1, 5)
    made = segments_by_moves(block, at_its_corner(block, COLLINEAR), SWIMMER, None)
    assert len(made) == 1
    assert made[0].fixed
    assert_close(made[0].turn, MoveSequence.of_controls(block.sequence).turn, 0.0)
