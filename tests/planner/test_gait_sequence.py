"""Stored gaits one after the other: a displacement is split into motions, and each motion is made exactly."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np
import pytest
from helpers import assert_close, flown, is_close, missed, random_rotations

from purcell_cli import Swimmer, stored_gaits
from purcell_cli.errors import GaitError
from purcell_cli.gaits.gait import MOTIONS
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.blocks import Block, starting_shapes
from purcell_cli.motion.limb_circles import bends
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.gait_sequence import Motion, StrokeBook, gait_sequences, largest_stroke, split, stroke_book
from purcell_cli.planner.problem import Problem

BODY = Swimmer().scaled()
PURE = 1e-9
"""What strokes one after the other may miss [L, rad]."""


@functools.cache
def book() -> StrokeBook:
    return stroke_book(tuple(stored_gaits().values()), BODY)


def strokes(displacement: Array) -> tuple[Block, ...]:
    """Return the strokes of the planner's first candidate by stored gaits, both limbs collinear at either end."""
    query = Problem(BODY, COLLINEAR, COLLINEAR, displacement, stored_gaits())
    return gait_sequences(query, Breadth())[0].make()


def motion_pose(motion: Motion) -> Array:
    """Return the displacement that a motion is. Shape (4, 4)."""
    k = MOTIONS.index(motion.along)
    if k < 3:
        return se3.pose(np.eye(3), motion.amount * np.eye(3)[k])
    return se3.pose(about_axis(k - 3, motion.amount), np.zeros(3))


def composed(motions: list[Motion]) -> Array:
    return functools.reduce(np.matmul, map(motion_pose, motions), np.eye(4))


DISPLACEMENTS = {
    "nothing": np.eye(4),
    "along x": se3.pose(np.eye(3), [3.0, 0.0, 0.0]),
    "along -x": se3.pose(np.eye(3), [-3.0, 0.0, 0.0]),
    "along y": se3.pose(np.eye(3), [0.0, 0.4, 0.0]),
    "along z": se3.pose(np.eye(3), [0.0, 0.0, -0.4]),
    **{
        f"a turn of {angle:g} rad about {'xyz'[k]}": se3.pose(about_axis(k, angle), np.zeros(3))
        for k in range(3)
        for angle in (0.4, -2.0, math.pi)
    },
    **{
        f"random {k}": se3.pose(random_rotations(np.random.default_rng(k)), np.random.default_rng(k).normal(size=3))
        for k in range(4)
    },
}


@pytest.mark.parametrize("amount", [0.07, -0.5, 1.3])
@pytest.mark.parametrize("along", MOTIONS)
def test_a_motion_is_made_exactly_and_alone(along: str, amount: float) -> None:
    """On the exact flow, in all six components, the limbs collinear before and after; one per cent more is seen."""
    blocks = book().blocks(Motion(along, amount))
    made = flown(BODY, blocks)
    assert missed(motion_pose(Motion(along, amount)), made) < PURE
    assert missed(motion_pose(Motion(along, 1.01 * amount)), made) > 1e-4
    shapes = starting_shapes(blocks, COLLINEAR)
    assert_close(shapes[-1], COLLINEAR, 1e-10)
    whole = [b.sequence.shapes(shape) for b, shape in zip(blocks, shapes, strict=False)]
    assert np.max(bends(np.concatenate(whole)[..., 0])) < 1.0 + 1e-5


def test_no_motion_takes_no_stroke() -> None:
    assert book().blocks(Motion("x", 0.0)) == []
    assert split(book(), np.eye(4)) == []
    assert strokes(np.eye(4)) == ()


@pytest.mark.parametrize("name", DISPLACEMENTS)
def test_motions_compose_to_the_displacement_they_are_split_from(name: str) -> None:
    """The same motions in the reverse order, the foil, do not, where there are several that do not commute."""
    motions = split(book(), DISPLACEMENTS[name])
    assert_close(composed(motions), DISPLACEMENTS[name], 1e-12)
    assert all(a.along != b.along for a, b in itertools.pairwise(motions))
    assert not name.startswith("random") or not is_close(composed(motions[::-1]), DISPLACEMENTS[name], 1e-3)


@pytest.mark.parametrize("name", DISPLACEMENTS)
def test_the_split_costs_no_more_than_along_the_axes_and_a_turn_after(name: str) -> None:
    """By the book's own prices, against motions along x, y and z, then roll, yaw and roll."""
    d = DISPLACEMENTS[name]
    a, b, c = math.atan2(d[2, 0], d[1, 0]), math.acos(np.clip(d[0, 0], -1.0, 1.0)), math.atan2(d[0, 2], -d[0, 1])
    plain = [Motion(axis, float(v)) for axis, v in zip("xyz", d[:3, 3], strict=True)]
    plain += [Motion("roll", a), Motion("yaw", b), Motion("roll", c)]
    known = is_close(composed(plain), d, 1e-9)
    price = sum(book().cost(m) for m in plain if m.amount)
    assert not known or sum(book().cost(m) for m in split(book(), d)) <= price + 1e-9
    assert known or not name.startswith("random")


@pytest.mark.parametrize("along", MOTIONS)
def test_a_larger_motion_costs_more_and_the_price_is_about_what_is_paid(along: str) -> None:
    costs = [book().cost(Motion(along, amount)) for amount in (0.05, 0.2, 1.0, 4.0)]
    assert np.all(np.diff(costs) > 0.0)
    assert book().cost(Motion(along, -0.2)) == costs[1]
    far = Motion(along, 4.0 if along in "xyz" else 0.9)
    paid = sum(b.joint_travel_rad for b in book().blocks(far))
    assert paid == pytest.approx(book().cost(far), rel=0.1)


@pytest.mark.parametrize("name", ["nothing", "along -x", "along z", "a turn of -2 rad about y", "random 0", "random 2"])
def test_what_the_planner_is_given_makes_the_displacement(name: str) -> None:
    blocks = strokes(DISPLACEMENTS[name])
    assert missed(DISPLACEMENTS[name], flown(BODY, blocks)) < 10 * PURE
    assert all(b.phase == 2 for b in blocks)


def test_without_a_gait_for_each_motion_the_book_says_which_is_missing() -> None:
    some = [g for g in stored_gaits().values() if g.moves not in ("y", "pitch")]
    with pytest.raises(GaitError, match="none moves along y, pitch"):
        StrokeBook(some, BODY)


def test_a_book_is_made_once_and_keeps_the_bend_limit_of_its_swimmer() -> None:
    gaits = tuple(stored_gaits().values())
    assert stroke_book(gaits, BODY) is book()
    gentle = stroke_book(gaits, Swimmer(max_bend_rad=0.4).scaled())
    strokes = [largest_stroke(gait, gentle.swimmer) for gait in gaits if gait.name in gentle.largest]
    assert all(stroke.bend_rad() <= 0.4 + 1e-6 for stroke in strokes)
    assert [stroke.amplitude_rad for stroke in strokes] == [gentle.largest[s.gait][0] for s in strokes]
    assert gentle.cost(Motion("x", 1.0)) > book().cost(Motion("x", 1.0))
