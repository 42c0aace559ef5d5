"""Moves: all six controls at once; the flow along them, its derivative, and the laws they share with primitives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import (
    UNIT,
    assert_close,
    dop853_rates,
    in_lengths,
    is_close,
    mostly_slow,
    random_sequence,
    random_shapes,
    random_swimmer,
)

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, as_vector
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow, flow_of_rates, work
from purcell_cli.mechanics.lift_derivatives import Repeat, flow_and_jacobian, flow_and_jacobian_of_moves
from purcell_cli.mechanics.moves import MoveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer


def random_moves(rng: np.random.Generator, count: int, largest: float = 1.0) -> MoveSequence:
    """Return moves with random turns; on some a limb or both rest."""
    turn = rng.uniform(-largest, largest, (count, 6))
    turn[1::4, :3], turn[2::4] = 0.0, 0.0
    return MoveSequence.of_turns(turn)


# --- The flow ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", mostly_slow(range(4), 1))
def test_the_flow_along_moves_is_the_solution_of_the_equations_of_motion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer, moves, start = random_swimmer(rng), random_moves(rng, 4), random_shapes(rng)
    found = flow(swimmer, moves, start)
    assert_close(
        in_lengths(swimmer, found), in_lengths(swimmer, dop853_rates(swimmer, moves.rate, moves.duration, start)), 3e-12
    )
    shapes, poses = flow_of_rates(swimmer, moves.rate, moves.duration, start)
    assert_close(in_lengths(swimmer, found), in_lengths(swimmer, poses[-1]), 1e-13)
    assert_close(moves.shapes(start), shapes, 1e-14)


def test_primitives_are_moves() -> None:
    """The same shapes, flow, work, travel and duration."""
    rng = np.random.default_rng(10)
    sequence, start = random_sequence(rng, 8), random_shapes(rng)
    moves = MoveSequence.of_controls(sequence)
    assert_close(moves.shapes(start), sequence.shapes(start), 1e-14)
    assert_close(flow(UNIT, moves, start), flow(UNIT, sequence, start), 1e-13)
    assert_close(work(UNIT, moves, start), work(UNIT, sequence, start), 1e-12)
    assert math.isclose(moves.joint_travel_rad, sequence.joint_travel_rad, rel_tol=1e-15)
    assert_close(moves.duration, sequence.duration, 0.0)


def test_reversal_is_the_inverse() -> None:
    """Run backwards, moves undo what they did; with the order kept (the foil) they do not."""
    rng = np.random.default_rng(11)
    swimmer, moves, start = random_swimmer(rng).scaled(), random_moves(rng, 5), random_shapes(rng)
    there, back = flow(swimmer, moves, start), flow(swimmer, moves.inverse(), moves.shapes(start)[-1])
    assert_close(there @ back, np.eye(4), 1e-12)
    only_signs = MoveSequence(-moves.rate, moves.duration)
    assert not is_close(there @ flow(swimmer, only_signs, moves.shapes(start)[-1]), np.eye(4), 1e-3)


def test_the_pace_leaves_the_path() -> None:
    """Half the rates for twice the time make the same displacement; half the rates alone (the foil) do not."""
    rng = np.random.default_rng(12)
    moves = random_moves(rng, 5)
    slow = MoveSequence(0.5 * moves.rate, 2.0 * moves.duration)
    assert_close(flow(UNIT, slow), flow(UNIT, moves), 1e-13)
    assert not is_close(flow(UNIT, MoveSequence(0.5 * moves.rate, moves.duration)), flow(UNIT, moves), 1e-3)


def test_a_rolled_limb_with_turned_controls_moves_the_base_alike() -> None:
    """Drag knows a limb only by its axis: A Rx(a), controls seen from there; the same controls (foil) differ."""
    rng = np.random.default_rng(13)
    moves, start = random_moves(rng, 5), random_shapes(rng)
    roll = np.stack([about_axis(0, 0.7), about_axis(0, -0.4)])
    seen = np.einsum("lji,nlj->nli", roll, moves.turn.reshape(-1, 2, 3)).reshape(-1, 6)
    wanted = flow(UNIT, moves, start)
    assert_close(flow(UNIT, MoveSequence.of_turns(seen), start @ roll), wanted, 1e-12)
    assert not is_close(flow(UNIT, moves, start @ roll), wanted, 1e-3)


def test_opposite_rolls_at_the_collinear_shape_move_nothing() -> None:
    opposite, alike = np.array([[0.8, 0, 0, -0.8, 0, 0]]), np.array([[0.8, 0, 0, 0.8, 0, 0]])
    assert_close(flow(UNIT, MoveSequence.of_turns(opposite)), np.eye(4), 1e-15)
    assert not is_close(flow(UNIT, MoveSequence.of_turns(alike)), np.eye(4), 1e-3)


# --- The derivative ------------------------------------------------------------------------------------------------


def differences(swimmer: Swimmer, turn: Array, start: Array, step: float = 1e-3) -> Array:
    """Return g^-1 dg/d(turn) by fourth-order central differences. Shape (6, n, 6)."""
    back = se3.inverse(flow(swimmer, MoveSequence.of_turns(turn), start))
    out = np.empty((6, *turn.shape))
    for place in np.ndindex(turn.shape):
        twist = []
        for shift in (-2, -1, 1, 2):
            other = turn.copy()
            other[place] += shift * step
            twist.append(se3.log(back @ flow(swimmer, MoveSequence.of_turns(other), start)))
        out[:, *place] = (twist[0] - 8 * twist[1] + 8 * twist[2] - twist[3]) / (12 * step)
    return out


@pytest.mark.parametrize("seed", range(3))
def test_the_derivative_by_every_turn_is_that_of_the_flow(seed: int) -> None:
    """Turns of nothing among them; as if turns commuted (the foil, no left Jacobian) it is another."""
    rng = np.random.default_rng(20 + seed)
    swimmer, moves, start = random_swimmer(rng).scaled(), random_moves(rng, 4), random_shapes(rng)
    g, jacobian = flow_and_jacobian_of_moves(swimmer, moves, start)
    assert_close(g, flow(swimmer, moves, start), 1e-13)
    wanted = differences(swimmer, moves.turn, start)
    assert_close(jacobian, wanted, 2e-8)
    angle = np.linalg.norm(moves.turn.reshape(-1, 2, 3), axis=2).max(axis=1)
    k = int(np.argmax(angle))
    commuting = np.einsum(
        "alj,lij->ali", jacobian[:, k].reshape(6, 2, 3), se3.left_jacobian(moves.turn[k].reshape(2, 3))
    )
    assert not is_close(commuting.reshape(6, 6), wanted[:, k], 1e-3)


def test_the_derivative_by_a_primitives_angle_is_one_of_a_moves() -> None:
    rng = np.random.default_rng(30)
    sequence, start = random_sequence(rng, 8), random_shapes(rng)
    wanted = flow_and_jacobian(UNIT, sequence, start)[1]
    found = flow_and_jacobian_of_moves(UNIT, MoveSequence.of_controls(sequence), start)[1]
    assert_close(found[:, np.arange(8), sequence.control], wanted, 1e-12)


def test_the_derivative_of_a_repeated_loop_counts_all_its_cycles() -> None:
    """A side and its opposite changed together, in a loop played five times between moves; once (the foil) is less."""
    rng = np.random.default_rng(31)
    ends = rng.uniform(-0.5, 0.5, (2, 6))
    side = np.zeros((2, 6))
    side[:, [2, 5]] = rng.uniform(-0.8, 0.8, (2, 2))

    def turns(change: float, cycles: int) -> Array:
        changed = side + change * np.array([[0, 0, 1.0, 0, 0, 0], np.zeros(6)])
        loop = np.concatenate([changed, -changed])
        return np.concatenate([ends[:1], np.tile(loop, (cycles, 1)), ends[1:]])

    def moved(change: float) -> Array:
        return se3.log(back @ flow(UNIT, MoveSequence.of_turns(turns(change, 5))))

    back = se3.inverse(flow(UNIT, MoveSequence.of_turns(turns(0.0, 5))))
    wanted = (moved(1e-5) - moved(-1e-5)) / 2e-5
    once = MoveSequence.of_turns(turns(0.0, 1))
    g, jacobian = flow_and_jacobian_of_moves(UNIT, once, COLLINEAR, repeats=[Repeat(1, 5, 5)])
    assert_close(g, se3.inverse(back), 1e-12)
    assert_close(jacobian[:, 1, 2] - jacobian[:, 3, 2], wanted, 1e-8)
    single = flow_and_jacobian_of_moves(UNIT, once)[1]
    assert not is_close(single[:, 1, 2] - single[:, 3, 2], wanted, 1e-3)


def test_the_left_jacobian_is_the_derivative_of_the_rotation() -> None:
    """By central differences, at zero too; the right one (the foil) is its transpose."""
    rng = np.random.default_rng(32)
    for size in (0.0, 1e-3, 0.2, 2.5):
        w, dw = size * np.array([0.6, -0.3, 0.742]), 1e-5 * rng.normal(size=3)
        turned = se3.rotation(w + dw) @ se3.rotation(w - dw).T
        assert_close(as_vector(turned), 2.0 * se3.left_jacobian(w) @ dw, 1e-13)
        if size > 0.1:
            assert not is_close(as_vector(turned), 2.0 * se3.left_jacobian(w).T @ dw, 1e-8)
        assert_close(se3.rotation(w) @ se3.rotation(w).T, np.eye(3), 1e-15)


# --- Bends ---------------------------------------------------------------------------------------------------------


# --- Sequences -----------------------------------------------------------------------------------------------------


def test_turns_are_made_at_the_full_rate_of_one_joint() -> None:
    rng = np.random.default_rng(50)
    moves = random_moves(rng, 6)
    largest = np.max(np.abs(moves.rate), axis=1)
    assert_close(largest, np.where(moves.duration > 0.0, 1.0, 0.0), 1e-15)
    assert math.isclose(moves.joint_travel_rad, float(np.sum(np.abs(moves.turn))), rel_tol=1e-14)
    both = joined([moves[:2], random_sequence(rng, 3), moves[2:]])
    assert (len(both), len(moves + moves), len(joined([]))) == (9, 12, 0)


def test_moves_cut_in_time_make_the_same_flow() -> None:
    rng = np.random.default_rng(51)
    moves = random_moves(rng, 5)
    parts = moves.lasting(np.repeat(np.arange(5), 2), np.repeat(0.5 * moves.duration, 2))
    assert_close(flow(UNIT, parts), flow(UNIT, moves), 1e-12)


@pytest.mark.parametrize(
    ("rate", "duration"),
    [
        (np.zeros((2, 6)), np.zeros(3)),
        (np.zeros((2, 5)), np.zeros(2)),
        (np.full((1, 6), np.nan), np.zeros(1)),
        (np.zeros((1, 6)), np.array([-1.0])),
        (np.full((1, 6), 1.1), np.ones(1)),
    ],
)
def test_bad_moves_are_refused(rate: Array, duration: Array) -> None:
    with pytest.raises(ParameterError):
        MoveSequence(rate, duration)
