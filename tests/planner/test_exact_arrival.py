"""The exact finish: what almost arrives ends exactly at the goal, by little, on the clock, and what is fixed stays."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from helpers import assert_close, is_close, largest_bends, slope

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.motion.clock import clock_step, rounded
from purcell_cli.planner.limbs.limb_rotations import rotations_to
from purcell_cli.planner.refine.clock_rounding import one_by_one
from purcell_cli.planner.refine.exact_arrival import CLOSE, approach, arrive
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

BODY = Swimmer().scaled()
EXACTLY = 5e-11
"""What may be left [L, rad]."""
TICK = clock_step(100.0)

IN = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", 0.3), ("limb1 pitch", -0.3), ("limb2 roll", 0.2)])
WORD = PrimitiveSequence.of(
    [("limb1 yaw", 0.5), ("limb2 yaw", 0.4), ("limb1 pitch", 0.3), ("limb2 pitch", -0.4), ("limb1 roll", 0.3)]
)
LOOP = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.6), ("limb1 yaw", -0.5), ("limb2 yaw", -0.6)])
FIXED = PrimitiveSequence.of([("limb1 pitch", 0.2), ("limb2 yaw", 0.1), ("limb2 yaw", -0.1), ("limb1 pitch", -0.2)])
CYCLES, FIXED_CYCLES = 7, 3


def closed(word: PrimitiveSequence) -> PrimitiveSequence:
    """Return a word with the shortest turns that straighten both limbs after it."""
    shape = word.shapes(COLLINEAR)[-1]
    return joined([word, *(rotations_to(shape[i].T, i + 1).primitives(0) for i in (0, 1))])


def motion(by: Array) -> Equations:
    """Return the equations of a motion that misses its goal by a twist. Shape (6,)."""
    there, back = closed(WORD), closed(WORD.inverse())
    swum = joined([there, LOOP.times(CYCLES), back, FIXED.times(FIXED_CYCLES), IN])
    parts = [
        Segment(2, (("a", 0.0, len(there)),), there),
        Segment(2, (("b", 0.0, 4),), LOOP, cycles=CYCLES),
        Segment(2, (("c", 0.0, len(back)),), back),
        Segment(2, (("d", 0.0, 4),), FIXED, cycles=FIXED_CYCLES),
        Segment(3, (("e", 0.0, 4),), IN),
    ]
    wanted = flow(BODY, swum) @ se3.exp(by)
    return Equations(BODY, parts, COLLINEAR, IN.shapes(COLLINEAR)[-1], wanted)


def on_the_clock(angle: Array) -> Array:
    return rounded(angle, BODY.joint_rate_rad_s, TICK)


BY = np.array([2e-3, -1e-3, 1.5e-3, 1e-3, -2e-3, 1e-3])


@functools.cache
def near() -> Equations:
    return approach(motion(BY).at_accuracy(SEARCHING), BODY.max_bend_rad)[0]


@functools.cache
def exact() -> tuple[Equations, float]:
    rough = near().at(near().angles)
    begun = motion(BY).of(near().segments)
    return arrive(begun, rough, BODY.max_bend_rad, on_the_clock)


def played(equations: Equations) -> PrimitiveSequence:
    """Return all primitives of a motion, every cycle."""
    return joined([s.sequence.times(s.cycles) for s in equations.segments])


def test_a_motion_comes_near_its_goal() -> None:
    begun = motion(BY).at_accuracy(SEARCHING)
    found, values, off = approach(begun, BODY.max_bend_rad)
    assert off < CLOSE < begun.at(begun.angles).size
    assert values.size == off
    assert_close(found.at(found.angles).residual, values.residual, 1e-15)


def test_what_cannot_arrive_says_how_far_off_it_is_and_keeps_the_best() -> None:
    begun = motion(np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0])).at_accuracy(SEARCHING)
    found, values, off = approach(begun, BODY.max_bend_rad)
    assert off > 0.1
    assert off <= begun.at(begun.angles).size
    assert found.at(found.angles).size == pytest.approx(values.size)


def test_a_motion_that_arrived_ends_exactly_at_its_goal() -> None:
    """In all twelve dimensions, every cycle played on the exact flow; the motion that only comes near does not."""
    found, off = exact()
    assert off <= EXACTLY
    sequence = played(found)
    assert_close(flow(BODY, sequence), found.displacement, 4.0 * EXACTLY)
    assert_close(sequence.shapes(COLLINEAR)[-1], found.goal, 4.0 * EXACTLY)
    assert not is_close(flow(BODY, played(near())), found.displacement, 1e-9)


def test_a_repeated_stroke_that_is_no_rectangle_is_left_alone() -> None:
    """And controls and cycles stay; the sides of the rectangle, the foil, are changed, and it closes."""
    found, begun = exact()[0], motion(BY)
    assert [s.cycles for s in found.segments] == [s.cycles for s in begun.segments]
    assert_close(found.segments[3].sequence.angle, FIXED.angle, 0.0)
    assert list(found.segments[3].sequence.control) == list(FIXED.control)
    loop = found.segments[1]
    assert loop.rectangles == 1
    assert not is_close(loop.sequence.angle, LOOP.angle, 1e-6)
    assert_close(loop.sequence.shapes(COLLINEAR)[-1], COLLINEAR, 1e-15)
    for now, before in zip(found.segments[:4], begun.segments, strict=False):
        assert list(now.sequence.control) == list(before.sequence.control)


def test_what_is_changed_is_in_proportion_to_what_is_missing() -> None:
    """The least changes are linear in what is missing, as long as that is little."""
    shares, changes = np.array([0.05, 0.1, 0.2]), []
    for share in shares:
        begun = motion(share * BY)
        found = arrive(begun, begun.at_accuracy(SEARCHING).at(begun.angles), BODY.max_bend_rad, on_the_clock)[0]
        changes.append(np.linalg.norm(found.angles[: len(begun.angles)] - begun.angles))
    assert abs(slope(shares, changes) - 1.0) < 0.15
    assert changes[0] < 100.0 * shares[0] * np.linalg.norm(BY)


def test_every_duration_is_a_whole_number_of_ticks() -> None:
    """But those of the stroke that is left alone, which its maker puts on the clock."""
    for k, segment in enumerate(exact()[0].segments):
        ticks = segment.sequence.duration / TICK
        assert np.all(ticks == np.round(ticks)) == (k != 3)


def test_no_limb_bends_further_than_the_limit() -> None:
    """With a limit at which the motion begins, the foil, it would: it arrives by other angles."""
    sequence = played(exact()[0])
    limit = float(largest_bends(sequence).max())
    tight = Swimmer(max_bend_rad=limit - 2e-4).scaled()
    parts = near().segments
    begun = Equations(tight, parts, COLLINEAR, near().goal, near().displacement)
    found, off = arrive(begun, near().at(near().angles), tight.max_bend_rad, on_the_clock)
    assert off <= 1e-8
    inner = joined([s.sequence.times(s.cycles) for s in found.segments[:4]])
    assert np.all(largest_bends(inner) <= tight.max_bend_rad)


def test_without_repeated_strokes_it_arrives_as_well() -> None:
    swum = joined([closed(WORD), closed(WORD.inverse()), IN])
    goal, wanted = swum.shapes(COLLINEAR)[-1], flow(BODY, swum) @ se3.exp(0.1 * BY)
    begun = Equations(BODY, [Segment(3, (("a", 0.0, len(swum)),), swum)], COLLINEAR, goal, wanted)
    rough = begun.at_accuracy(SEARCHING).at(begun.angles)
    found, off = arrive(begun, rough, BODY.max_bend_rad, on_the_clock)
    assert off <= 2e-11
    assert_close(flow(BODY, played(found)), begun.displacement, 1e-10)


def test_an_angle_that_moves_nothing_is_left_where_angles_are_rounded_one_by_one() -> None:
    # What is left at the end, divided by what such an angle does, had been turns of 1e22 rad.
    almost = motion(np.full(6, 1e-8)).at_accuracy(SEARCHING)
    values = almost.at(almost.angles)
    derivative = values.derivative.copy()
    derivative[:, 3] = 1e-30
    step = functools.partial(rounded, rate_rad_s=1.0, step=TICK)
    angle, left = one_by_one(almost, step(almost.angles), almost.residual(step(almost.angles)), derivative, step)
    assert angle[3] == step(almost.angles)[3]
    assert np.max(np.abs(angle - almost.angles)) < 1e-5
    assert np.max(np.abs(left)) < 1e-3 * np.max(np.abs(values.residual))
