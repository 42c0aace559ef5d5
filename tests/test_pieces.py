"""Pieces of constant limb rates: cut, put together and computed on, they do what their sequence does."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import UNIT, assert_close, bent, is_close, random_sequence

from purcell_cli.geometry import se3
from purcell_cli.mechanics.lift import flow, piece_displacements, piece_work, work
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.motion.blocks import Block, BlockPieces


@pytest.mark.parametrize("moves", [False, True])
def test_the_pieces_of_a_sequence_do_what_it_does(moves: bool) -> None:
    """From the shape it begins at; from another one they do not."""
    start = bent(0.4, -0.7)
    primitives = random_sequence(np.random.default_rng(1), 6)
    sequence = MoveSequence.of_controls(primitives) if moves else primitives
    pieces = Pieces.of(sequence, start)
    assert len(pieces) == 6
    done = se3.prefix_products(piece_displacements(UNIT, pieces))[-1]
    assert_close(done, flow(UNIT, sequence, start), 1e-14)
    assert not is_close(se3.prefix_products(piece_displacements(UNIT, Pieces.of(sequence)))[-1], done, 1e-3)
    assert np.array_equal(piece_work(UNIT, pieces), work(UNIT, sequence, start))
    assert_close(pieces.shapes[0], start, 0.0)
    between = Pieces.between(sequence, sequence.shapes(start))
    assert np.array_equal(between.shapes, pieces.shapes)


def test_pieces_put_together_and_taken_apart_are_the_same() -> None:
    rng = np.random.default_rng(2)
    parts = [Pieces.of(random_sequence(rng, n), bent(0.1 * n, 0.2)) for n in (3, 1, 4)]
    every = Pieces.together(parts)
    assert len(every) == 8
    for part, some in zip(parts, (slice(0, 3), np.array([3]), slice(4, 8)), strict=True):
        for name in ("shapes", "rates", "durations"):
            assert np.array_equal(getattr(every[some], name), getattr(part, name))
    nothing = Pieces.together([])
    assert len(nothing) == 0
    assert piece_displacements(UNIT, nothing).shape == (0, 4, 4)


def test_the_pieces_of_blocks_are_one_cycle_of_each() -> None:
    rng = np.random.default_rng(3)
    blocks = [Block(1, "a", random_sequence(rng, 2)), Block(2, "b", random_sequence(rng, 3), 5)]
    pieces = BlockPieces.of(blocks, bent(0.3, 0.0))
    assert len(pieces.once) == 5
    assert np.array_equal(pieces.once.shapes, pieces.shapes[:-1])
    assert np.array_equal(pieces.once.durations, np.concatenate([b.sequence.duration for b in blocks]))
