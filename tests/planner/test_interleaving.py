"""The turns of one limb between the other's: the same end and the same joint travel, another displacement."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from helpers import assert_close, largest_bends, missed, nearest, random_shapes

from purcell_cli import Swimmer
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.motion.limb_circles import bends
from purcell_cli.planner.limbs.interleaving import interleaved
from purcell_cli.planner.limbs.straightening import Straightenings, straightenings

ROUGH = 6e-4
"""What the search's displacements of six turns may be off by [L, rad]: six times the error that is stated for one."""

BODY = Swimmer().scaled()
SHAPE = random_shapes(np.random.default_rng(8))
PAIRS = 4


@functools.cache
def ways() -> tuple[Straightenings, Straightenings]:
    """Return ways to straighten both limbs, and those and more of them."""
    known = straightenings(BODY, [SHAPE])
    return known[0], interleaved(BODY, [SHAPE], known, PAIRS)[0]


def test_every_pair_of_ways_is_taken_in_all_eighteen_other_orders() -> None:
    """Twenty orders put three turns and three in a row; in two of them one limb makes all its turns at once."""
    known, found = ways()
    more = found[np.arange(len(known), len(found))]
    pairs, counts = np.unique(more.way, axis=0, return_counts=True)
    assert len(pairs) == PAIRS
    assert np.all(counts == 18)
    rows = np.unique(np.concatenate([more.way, more.order], axis=1), axis=0)
    assert len(rows) == len(more)
    assert np.all(more.order.sum(axis=1) == 3)
    assert not np.any(np.all(np.diff(more.order[:, :3], axis=1) == 0, axis=1))


def test_to_interleave_changes_neither_the_final_shape_nor_the_joint_travel() -> None:
    known, found = ways()
    for k in range(len(known), len(found)):
        sequence = found.sequence(k)
        same = np.flatnonzero(np.all(known.way == found.way[k], axis=1))
        assert_close(sequence.shapes(SHAPE)[-1], COLLINEAR, 1e-14)
        assert sequence.joint_travel_rad == pytest.approx(float(known.joint_travel_rad[same[0]]), abs=1e-12)
        assert found.joint_travel_rad[k] == pytest.approx(sequence.joint_travel_rad, abs=1e-12)
        assert np.all(largest_bends(sequence, SHAPE) <= np.maximum(1.0, bends(SHAPE[..., 0])) + 1e-8)


def test_an_interleaved_way_does_to_the_base_what_it_says() -> None:
    """On the exact flow; what one limb after the other does, the foil, is mostly another displacement."""
    known, found = ways()
    others = 0
    few = range(len(known), len(found), 5)
    for k in few:
        assert missed(found.displacement[k], flow(BODY, found.sequence(k), SHAPE)) < ROUGH
        same = np.flatnonzero(np.all(known.way == found.way[k], axis=1))
        others += all(missed(found.displacement[k], known.displacement[j]) > 10 * ROUGH for j in same)
    assert others > 0.7 * len(few)


def test_where_a_limb_is_straight_there_is_nothing_to_put_between() -> None:
    shape = np.stack([np.eye(3), SHAPE[1]])
    known = straightenings(BODY, [shape, COLLINEAR])
    found = interleaved(BODY, [shape, COLLINEAR], known, PAIRS)
    assert [len(f) for f in found] == [len(k) for k in known]


def test_orders_in_which_the_limbs_come_too_near_are_left_out() -> None:
    swimmer = Swimmer(0.1, 0.2).scaled()
    shape = random_shapes(np.random.default_rng(7))
    known = straightenings(swimmer, [shape])
    apart = 0.5
    free, kept = (interleaved(swimmer, [shape], known, 20, c)[0] for c in (0.0, apart))
    assert len(known[0]) < len(kept) < len(free)

    assert all(nearest(swimmer, kept.sequence(k), shape) >= apart - 1e-6 for k in range(len(known[0]), len(kept), 3))
    assert any(nearest(swimmer, free.sequence(k), shape) < apart - 1e-3 for k in range(len(known[0]), len(free)))
