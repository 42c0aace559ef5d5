"""Ways to straighten both limbs: each ends collinear, does what it says to the base and keeps the limits."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, is_close, largest_bends, missed, nearest, random_shapes

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.motion.clearance import limb_distance
from purcell_cli.motion.limb_circles import bends
from purcell_cli.planner.limbs.straightening import Straightenings, straightenings

ROUGH = 6e-4
"""What the search's displacements of six turns may be off by [L, rad]: six times the error that is stated for one."""

BODY = Swimmer().scaled()
SHAPES = {
    "random": random_shapes(np.random.default_rng(2)),
    "a little bent": np.stack([about_axis(2, 0.4) @ about_axis(1, -0.2), about_axis(0, 0.5) @ about_axis(1, 0.6)]),
    "one limb bent": np.stack([np.eye(3), about_axis(1, 1.2) @ about_axis(0, 0.3)]),
    "rolled": np.stack([about_axis(0, 0.9), about_axis(0, -2.0)]),
}


def ways(name: str, clearance: float = 0.0) -> Straightenings:
    return straightenings(BODY, [SHAPES[name]], clearance)[0]


def some(found: Straightenings, most: int = 40) -> list[int]:
    """Return a few of the ways, evenly spread."""
    return np.unique(np.linspace(0, len(found) - 1, most).astype(int)).tolist()


@pytest.mark.parametrize("name", SHAPES)
def test_every_way_ends_at_the_collinear_shape(name: str) -> None:
    """The same turns from the other limb's shape, the foil, do not."""
    found = ways(name)
    for k in range(len(found)):
        sequence = found.sequence(k)
        assert_close(sequence.shapes(SHAPES[name])[-1], COLLINEAR, 1e-14)
        assert not is_close(sequence.shapes(SHAPES[name][::-1])[-1], COLLINEAR, 1e-3)
        assert sequence.joint_travel_rad == pytest.approx(found.joint_travel_rad[k], abs=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_a_way_does_to_the_base_what_it_says(name: str) -> None:
    """On the exact flow, from the shape it begins with; the way back, the foil, does the inverse."""
    found = ways(name)
    for k in some(found):
        does = flow(BODY, found.sequence(k), SHAPES[name])
        assert missed(found.displacement[k], does) < ROUGH
        back = flow(BODY, found.sequence(k).inverse(), COLLINEAR)
        assert missed(se3.inverse(found.displacement[k]), back) < ROUGH
        assert missed(found.displacement[k], back) > 1e-2


@pytest.mark.parametrize("name", SHAPES)
def test_no_limb_bends_further_than_it_does_or_than_the_limit(name: str) -> None:
    found = ways(name)
    limit = np.maximum(BODY.max_bend_rad, bends(SHAPES[name][..., 0])) + 1e-8
    for k in range(len(found)):
        assert np.all(largest_bends(found.sequence(k), SHAPES[name]) <= limit)


def test_ways_that_would_bend_further_are_left_out() -> None:
    """Of a limb that is bent more than the limit some ways bend more still: with a higher limit there are more."""
    shape = SHAPES["a little bent"]
    tight, roomy = (straightenings(Swimmer(max_bend_rad=b).scaled(), [shape])[0] for b in (0.3, 3.0))
    assert 0 < len(tight) < len(roomy)
    assert max(largest_bends(roomy.sequence(k), shape).max() for k in range(len(roomy))) > 0.8


@pytest.mark.parametrize("name", SHAPES)
def test_the_shortest_way_comes_first_and_none_is_much_longer(name: str) -> None:
    travel = ways(name).joint_travel_rad
    assert np.all(np.diff(travel) >= -1e-8)
    assert travel[-1] <= travel[0] + 7.0


def test_either_limb_may_go_first_unless_one_is_straight() -> None:
    first = ways("a little bent").order[:, 0]
    assert set(first.tolist()) == {0, 1}
    assert_close(np.sort(ways("random").order, axis=1), np.tile([0, 0, 0, 1, 1, 1], (len(ways("random")), 1)), 0.0)
    assert np.all(ways("one limb bent").order[:, 0] == 0)


def test_straight_limbs_have_one_way_and_it_is_empty() -> None:
    found = straightenings(BODY, [COLLINEAR])[0]
    assert len(found) == 1
    assert len(found.sequence(0)) == 0
    assert_close(found.displacement[0], np.eye(4), 0.0)


LONG = Swimmer(0.1, 0.2).scaled()
CROSSING = random_shapes(np.random.default_rng(7))
"""A shape with the long limbs 0.65 L apart, which some of the ways bring nearer."""


def test_the_limbs_stay_as_far_apart_as_asked() -> None:
    """What is allowed without a clearance, the foil, comes nearer."""
    free, kept = (straightenings(LONG, [CROSSING], c)[0] for c in (0.0, 0.5))
    assert 0 < len(kept) < len(free)
    assert all(nearest(LONG, kept.sequence(k), CROSSING) >= 0.5 - 1e-6 for k in some(kept))
    assert min(nearest(LONG, free.sequence(k), CROSSING) for k in some(free)) < 0.4


def test_where_no_way_keeps_the_limbs_apart_those_that_come_least_near_are_left() -> None:
    """A clearance that the shape itself does not have: the ways on which the limbs come no nearer."""
    apart = float(limb_distance(LONG, CROSSING[..., 0]))
    left = straightenings(LONG, [CROSSING], 1.05 * apart)[0]
    assert 0 < len(left) < len(straightenings(LONG, [CROSSING])[0])
    assert all(nearest(LONG, left.sequence(k), CROSSING) >= apart - 1e-6 for k in some(left))


def test_several_shapes_are_done_as_each_alone() -> None:
    together = straightenings(BODY, [SHAPES["random"], COLLINEAR, SHAPES["one limb bent"]])
    for found, name in ((together[0], "random"), (together[2], "one limb bent")):
        assert_close(found.way, ways(name).way, 0.0)
        assert_close(
            found.displacement, ways(name).displacement, 1e-7
        )  # those that are solved together settle together


def test_some_of_the_ways_and_more_of_them_keep_what_they_do() -> None:
    found = ways("random")
    picked = np.array([5, 2, 9])
    few = found[picked].and_(found[np.array([0])])
    assert len(few) == 4
    for k, old in enumerate([*picked, 0]):
        assert list(few.sequence(k)) == list(found.sequence(int(old)))
        assert_close(few.displacement[k], found.displacement[old], 0.0)
