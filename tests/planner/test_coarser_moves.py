"""Motions of fewer moves: limbs end as they did, and the base moves otherwise by a small area at most."""

from __future__ import annotations

import numpy as np
from helpers import assert_close

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.coarser_moves import coarser
from purcell_cli.planner.refine.octagonal_loops import yaws
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

SWIMMER = Swimmer().scaled()


def motion(*segments: Segment) -> Equations:
    """Return a motion that arrives."""
    turn = np.concatenate([np.tile(segment.turn, (segment.cycles, 1)) for segment in segments])
    moves = MoveSequence.of_turns(turn)
    goal = moves.shapes(COLLINEAR)[-1]
    return Equations(SWIMMER, segments, COLLINEAR, goal, flow(SWIMMER, moves, accuracy=SEARCHING), SEARCHING)


def turns(made: Equations) -> Array:
    return np.concatenate([segment.turn for segment in made.segments])


def test_small_neighbours_become_one_that_turns_the_limbs_alike() -> None:
    """About any axes; added up (the foil) they would not."""
    rng = np.random.default_rng(2)
    roll = np.array([0.45, 0.0, 0.0, -0.45, 0.0, 0.0])
    before = np.concatenate([rng.uniform(-0.06, 0.06, (10, 6)), np.tile(roll, (18, 1))])
    after = turns(coarser(motion(Segment.by_moves(2, "any", before))))
    ends = [MoveSequence.of_turns(turn).shapes(COLLINEAR)[-1] for turn in (before, after)]
    assert 18 < len(after) < 24
    assert_close(ends[0], ends[1], 1e-12)
    added = se3.rotation(before[:10].sum(axis=0).reshape(2, 3)) @ se3.rotation(18.0 * roll.reshape(2, 3))
    assert np.max(np.abs(added - ends[0])) > 1e-3


def test_parallel_neighbours_become_one_on_the_same_path() -> None:
    before = np.outer([0.2, 0.1, 0.05], np.random.default_rng(3).uniform(-0.9, 0.9, 6))
    after = turns(coarser(motion(Segment.by_moves(2, "any", before))))
    assert len(after) == 1
    went = [flow(SWIMMER, MoveSequence.of_turns(turn), accuracy=SEARCHING) for turn in (before, after)]
    assert_close(went[0], went[1], 1e-7)


def test_sides_that_span_an_area_and_loops_that_repeat_stay() -> None:
    square = yaws(np.array([[0.3, 0.0], [0.0, 0.3], [-0.3, 0.0], [0.0, -0.3]]))
    tiny = Segment.by_moves(2, "loop", 0.1 * square, 3, fixed=True)
    assert_close(
        turns(coarser(motion(Segment.by_moves(2, "any", square), tiny))), np.concatenate([square, tiny.turn]), 0.0
    )
