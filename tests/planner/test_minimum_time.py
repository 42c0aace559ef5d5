"""Quicker motions: Newton steps converge by the square, linear programs save time, and the arrival is exact after."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from helpers import assert_close, is_close, slope

from purcell_cli import Swimmer
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits_check import check
from purcell_cli.planner.refine.exact_arrival import newton_step, settled
from purcell_cli.planner.refine.inequalities import Linearised, linearised
from purcell_cli.planner.refine.minimum_time import QUICKEST, minimised
from purcell_cli.planner.refine.move_program import MoveProgram
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.trust_region import FIRST_REACH

BODY = Swimmer(max_bend_rad=0.7).scaled()
STEPS = [("limb1 yaw", 0.5), ("limb2 yaw", 0.6), ("limb1 pitch", 0.3), ("limb1 yaw", -0.4), ("limb2 yaw", -0.5)]
STEPS += [("limb2 pitch", -0.2), ("limb1 roll", 0.2), ("limb2 roll", -0.3)]


@functools.cache
def begun() -> Equations:
    """Return a motion by one joint at a time from the collinear shape, which arrives at the shape that it makes."""
    turn = MoveSequence.of_controls(PrimitiveSequence.of(STEPS)).turn
    moves = MoveSequence.of_turns(turn)
    goal = moves.shapes(COLLINEAR)[-1]
    return Equations(BODY, [Segment.by_moves(2, "a", turn)], COLLINEAR, goal, flow(BODY, moves), SEARCHING)


def at(motion: Equations, angle: Array) -> Linearised:
    return linearised(motion, motion.at(angle), motion.swimmer.max_bend_rad)


@functools.cache
def quick() -> Equations:
    return minimised(begun(), MoveProgram(begun(), QUICKEST), 30, FIRST_REACH).motion


@functools.cache
def exact() -> tuple[Equations, float]:
    return settled(quick())


def test_newton_steps_leave_the_square_of_what_was_missing() -> None:
    """The same steps the other way, the foil, leave twice as much as there was."""
    motion, rng = begun(), np.random.default_rng(0)
    change = rng.normal(size=len(motion.angles))
    sizes, left, away = np.array([5e-5, 1e-4, 2e-4]), [], []
    for size in sizes:
        angle = motion.angles + size * change
        here = at(motion, angle)
        left.append(motion.at(angle + newton_step(here)).size)
        away.append(motion.at(angle - newton_step(here)).size / here.values.size)
    assert abs(slope(sizes, left) - 2.0) < 0.15
    assert_close(away, np.full(3, 2.0), 0.1)


def test_a_newton_step_is_cut_to_its_reach() -> None:
    angle = begun().angles + 1e-3
    here = at(begun(), angle)
    assert begun().at(angle + newton_step(here)).size < 0.1 * here.values.size
    assert np.max(np.abs(newton_step(here, reach=1e-5))) == pytest.approx(1e-5)


@pytest.mark.slow
def test_all_joints_at_once_are_quicker() -> None:
    """By more than a third; and it almost arrives."""
    assert quick().duration < 0.67 * begun().duration
    assert quick().at(quick().angles).size < 1e-3
    assert np.max(np.count_nonzero(np.abs(quick().segments[0].turn) > 1e-3, axis=1)) >= 2


@pytest.mark.slow
def test_a_settled_motion_arrives_exactly() -> None:
    """Played on the exact flow; before it settles, the foil, it misses by more than rounding."""
    motion, off = exact()
    moves = MoveSequence.of_turns(motion.segments[0].turn)
    assert off < 1e-11
    assert_close(flow(BODY, moves), begun().displacement, 1e-10)
    assert_close(moves.shapes(COLLINEAR)[-1], begun().goal, 1e-10)
    assert not is_close(flow(BODY, MoveSequence.of_turns(quick().segments[0].turn)), begun().displacement, 1e-10)
    assert motion.duration < 0.67 * begun().duration


@pytest.mark.slow
def test_no_limb_bends_further_than_the_limit_at_any_instant() -> None:
    """Where one does, which the quickest way with a higher limit, the foil, wants."""
    found = check(BODY, Configuration(), [Block(2, "a", MoveSequence.of_turns(exact()[0].segments[0].turn))])
    assert found.largest_bend_rad[1] is not None
    assert found.largest_bend_rad[1] <= BODY.max_bend_rad + 1e-6
