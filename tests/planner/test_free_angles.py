"""Ties: a motion's angles are linear in its free ones, and what ties mix comes back."""

from __future__ import annotations

import math

import numpy as np
from helpers import assert_close, is_close

from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.free_angles import RECTANGLE, FreeAngles, picked
from purcell_cli.planner.refine.segments import Segment


def free_angles(segments: list[Segment]) -> FreeAngles:
    return FreeAngles.of([(len(s.sequence), s.tie, s.cycles) for s in segments])


def turns(moves: int) -> Array:
    return np.random.default_rng(moves).normal(size=(moves, 6))


AXES = np.concatenate([about_axis(0, 0.7), about_axis(0, -0.7)])[:, 1:]
"""Two orthogonal columns of six numbers, none of which is 1 alone."""


def parts() -> list[Segment]:
    """Return segments of every kind by moves: free, held, about some axes, about mixed axes, and a loop."""
    half = np.zeros((2, 6, 2))
    half[0, 2, 0], half[0, 5, 1], half[1, 2, 0], half[1, 5, 1] = 1.0, 1.0, -1.0, -1.0
    side = np.zeros((1, 6))
    side[0, [2, 5]] = 0.4, -0.3
    return [
        Segment.by_moves(1, "free", turns(2)),
        Segment.by_moves(2, "held", turns(3), 2, fixed=True),
        Segment.by_moves(2, "yaws", turns(2) * [0, 0, 1, 0, 0, 1], tie=np.eye(6)[:, [2, 5]]),
        Segment.by_moves(2, "mixed", turns(3) @ AXES @ AXES.T / 2.0, tie=AXES),
        Segment.by_moves(2, "loop", np.concatenate([side, -side]), 7, half.reshape(12, 2)),
    ]


def test_free_angles_make_the_angles_that_they_are_read_from() -> None:
    """Of every kind of tie; a tie of which the columns are not orthogonal (the foil) is read wrong."""
    free = free_angles(parts())
    angle = np.concatenate([s.sequence.angle for s in parts()])
    assert len(free) == 12 + 0 + 4 + 6 + 2
    assert_close(free.angles_at(free.of_angles(angle), angle), angle, 1e-14)
    held = slice(12, 30)
    assert_close(free.made(free.of_angles(angle))[held], np.zeros(18), 0.0)
    skewed = [Segment.by_moves(2, "skewed", turns(3), tie=AXES @ [[1.0, 1.0], [0.0, 1.0]])]
    wrong, wanted = free_angles(skewed), np.arange(1.0, 7.0)
    assert not is_close(wrong.of_angles(wrong.made(wanted)), wanted, 0.1)


def test_derivatives_by_free_angles_are_those_of_the_angles_that_they_make() -> None:
    free, rng = free_angles(parts()), np.random.default_rng(0)
    columns = rng.normal(size=(5, len(free.sign)))
    linear = np.stack([free.made(unit) for unit in np.eye(len(free))], axis=1)
    assert_close(free.by_free(columns), columns @ linear, 1e-13)
    assert free.by_free(columns[:0]).shape == (0, len(free))


def test_a_rectangle_that_repeats_closes_whatever_its_sides_are() -> None:
    """Each side counts for two in every cycle; one that does not close (the foil) is held."""
    closed = PrimitiveSequence(np.array([2, 5, 2, 5] * 2), np.array([0.5, 0.2, -0.5, -0.2, 0.3, 0.1, -0.3, -0.1]))
    loop = Segment(2, (("loop", math.nan, 8),), closed, 9)
    free = free_angles([loop])
    assert_close(free.of_angles(closed.angle), [0.5, 0.2, 0.3, 0.1], 0.0)
    assert_close(free.weight, np.full(4, 18.0), 0.0)
    made = free.angles_at(np.array([1.0, 2.0, 3.0, 4.0]), closed.angle)
    assert_close(made, [1, 2, -1, -2, 3, 4, -3, -4], 0.0)
    assert len(free_angles([Segment(2, loop.strokes, closed.with_angles(closed.angle + 1e-3), 9)])) == 0


def test_ties_that_name_each_free_angle_once_are_told_by_their_signs() -> None:
    index, sign = picked(RECTANGLE) or (np.empty(0), np.empty(0))
    assert_close(index, [0, 1, 0, 1], 0.0)
    assert_close(sign, [1, 1, -1, -1], 0.0)
    assert picked(AXES) is None
    assert picked(np.ones((2, 1))) is None  # one free angle is two angles
