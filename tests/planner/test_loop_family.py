"""The fan of loops: its costs against all loops of the table, and tight arcs in parts that stay in their place."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import assert_close, flown, missed, slope

from purcell_cli import LinkDrag, LinkDrags, LinkSize, LinkSizes, Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.loops import loops, stroke

BODY = Swimmer().scaled()
BETWEEN = 1.0 - 1e-3
"""Between its knots the fan interpolates, and costs fall short by less than this part."""
BOTH = pytest.mark.parametrize("across", [False, True])


def arc(advance: float, turn: float) -> Array:
    """Return the displacement of an arc that turns about z. Shape (4, 4)."""
    return se3.exp(np.array([advance, 0.0, 0.0, 0.0, 0.0, turn]))


def test_loops_bent_aside_across_their_plane_turn_by_a_quarter_more() -> None:
    """0.737 degrees a rad is the best of squares in the plane at a bend limit of 1 rad."""
    in_plane, across = (math.degrees(fan(BODY, "travel", a).tight) for a in (False, True))
    assert in_plane == pytest.approx(0.737, abs=2e-3)
    assert across == pytest.approx(0.907, abs=2e-3)


@BOTH
def test_a_loop_of_the_fan_costs_what_its_joint_travel_is(across: bool) -> None:
    """Played a hundred times on the exact flow, ways in and out left aside."""
    of = fan(BODY, "travel", across)
    for k in range(0, len(of.bend), 3):
        half_side, offset = (float(x[0]) for x in of.loops.sides(of.bend[k : k + 1], of.offset_share[k : k + 1]))
        there, loop, _ = (Block(2, "", s) for s in stroke(half_side, offset, across))
        entry = flown(BODY, [there])
        cycle = se3.log(flown(BODY, [there, loop]) @ se3.inverse(entry))
        turn = float(np.hypot(cycle[4], cycle[5]))
        cost = float(of.cost(np.array(100 * cycle[0]), np.array(100 * turn)))
        assert cost == pytest.approx(100 * loop.joint_travel_rad, rel=5e-3)


def shares(of: Fan, bend: Array, offset_share: Array) -> Array:
    """Return what loops cost by the fan over what they cost in truth. Shape (n,)."""
    cycle, paid = of.loops.at(bend, offset_share).cycle[0], of.loops.costs(bend, offset_share)[0] / of.unit
    return of.cost(cycle[:, 0], np.hypot(cycle[:, 4], cycle[:, 5])) / paid


@pytest.mark.parametrize("measure", ["travel", "energy"])
@BOTH
def test_no_loop_of_the_table_is_cheaper_than_the_fan(across: bool, measure: str) -> None:
    """By more than 2 %, that is; loops of two thirds of the bend, the foil, all cost more than the fan says."""
    of = fan(BODY, measure, across)
    grid = np.meshgrid(np.linspace(of.loops.least_rad, of.loops.most_rad, 25), np.linspace(0.01, 0.9, 40))
    bend, offset_share = of.loops.clipped(*(part.ravel() for part in grid))
    assert np.max(shares(of, bend, offset_share)) < 1.02
    if measure == "travel":
        assert np.max(shares(of, np.minimum(bend, of.loops.most_rad / 1.5), offset_share)) < 0.9


@BOTH
def test_the_cost_grows_with_the_arc_and_is_the_same_either_way(across: bool) -> None:
    of = fan(BODY, "travel", across)
    rng = np.random.default_rng(0)
    advance, turn = rng.normal(size=30), rng.normal(size=30)
    cost = of.cost(advance, turn)
    assert_close(of.cost(3.0 * advance, 3.0 * turn), 3.0 * cost, 1e-12, float(cost.max()))
    assert_close(of.cost(-advance, turn), cost, 0.0)
    assert np.all(of.cost(1.1 * advance, turn) >= cost - 1e-12)
    assert np.all(of.cost(advance, 1.1 * turn) >= BETWEEN * cost)
    assert np.all(cost >= BETWEEN * np.maximum(np.abs(advance) / of.straight, np.abs(turn) / of.tight))
    assert np.all(cost <= np.abs(advance) / of.straight + np.abs(turn) / of.tight + 1e-9)


@BOTH
def test_an_arc_in_parts_advances_and_turns_as_much_by_loops_there_are(across: bool) -> None:
    of = fan(BODY, "travel", across)
    reach = abs(of.advance[-1] / of.turn[-1])
    for share in (0.0, 0.3, 0.9, 1.0, 4.0):
        for turn in (0.2, -0.2):
            advance = share * reach * 0.2
            parts = of.ways(advance, turn)
            assert len(parts) == (1 if share >= 0.97 else 3)
            assert_close(np.sum(parts, axis=0), [advance, turn], 1e-12)
            assert all(abs(a) >= 0.96 * reach * abs(t) for a, t in parts)


@BOTH
def test_an_arc_that_is_too_tight_stays_in_its_place_to_second_order(across: bool) -> None:
    """Three parts are off by the third power of the turn; two, the foil, by the second."""
    of = fan(BODY, "travel", across)
    reach = abs(of.advance[-1] / of.turn[-1])
    turns = np.array([0.1, 0.2, 0.4])
    three, two = [], []
    for turn in turns.tolist():
        advance = 0.3 * reach * turn
        outer, middle, _ = of.ways(advance, turn)
        three.append(missed(arc(advance, turn), arc(*outer) @ arc(*middle) @ arc(*outer)))
        two.append(missed(arc(advance, turn), arc(*(2.0 * np.array(outer))) @ arc(*middle)))
    assert abs(slope(turns, three) - 3.0) < 0.15
    assert abs(slope(turns, two) - 2.0) < 0.15


@BOTH
def test_a_knot_is_found_again(across: bool) -> None:
    of = fan(BODY, "travel", across)
    knots = of.knot(of.advance, of.turn)
    assert_close(knots, np.arange(len(of.bend)), 1e-9)
    assert_close(of.at(knots, of.bend), of.bend, 1e-9)
    assert of.turn[0] == 0.0
    assert int(np.argmax(np.abs(of.turn))) == len(of.turn) - 1


@BOTH
@pytest.mark.parametrize("bend", [0.3, 1.0, 1.6])
def test_the_fan_keeps_the_bend_limit(bend: float, across: bool) -> None:
    of = fan(Swimmer(max_bend_rad=bend).scaled(), "travel", across)
    assert np.all(of.bend <= bend)
    assert np.max(of.bend) > 0.9 * min(bend, 1.5)


def test_a_fan_is_made_once_of_the_loops_of_its_swimmer() -> None:
    assert fan(BODY, "travel", False) is fan(BODY, "travel", False)
    assert fan(BODY, "travel", False).loops is loops(BODY, "travel", False)


@pytest.mark.parametrize(
    "swimmer",
    [
        Swimmer(links=LinkSizes(limb1=LinkSize(0.06))),
        Swimmer(links=LinkSizes(limb2=LinkSize(0.08, 0.03)), drag="cylinder", body_radius_m=0.03),
        Swimmer(drag=LinkDrags(limb1=LinkDrag(0.5, 0.9, 3e-3))),
    ],
    ids=["short limb 1", "short limb 2", "heavy limb 1"],
)
@BOTH
def test_where_limbs_differ_another_point_than_the_middle_swims_along_circles(swimmer: Swimmer, across: bool) -> None:
    """There the loops' twists about y and z move along x, and aside by much less than the middle."""
    of = fan(swimmer.scaled(), "travel", across)
    twist = of.loops.at(of.bend, of.offset_share).cycle[0]
    shift = np.eye(4)
    shift[0, 3] = of.centre
    there = (se3.adjoint(se3.inverse(shift)) @ twist.T).T
    assert abs(of.centre) > 0.02
    assert np.linalg.norm(there[:, 1:3]) < 0.6 * np.linalg.norm(twist[:, 1:3])
    assert_close(there[:, 0], twist[:, 0], 1e-15)
    assert fan(BODY, "travel", across).centre == 0.0
