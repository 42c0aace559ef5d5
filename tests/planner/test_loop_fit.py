"""Loops fitted to arcs: they advance and turn as asked, within the table, by as few cycles as do."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from helpers import assert_close, flown, missed

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.motion.blocks import Block
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.loop_fit import Fitted, fitted
from purcell_cli.planner.arcs.loops import stroke

NEAR = 1e-3
"""What fitted loops may be off by [L, rad]: chains settle them."""

BODY = Swimmer().scaled()
ADVANCE = np.array([3.0, 2.5, 10.0, 0.4, 2.0])
TURN = np.array([0.5, 0.2, 0.3, 0.0, 0.6])
BOTH = pytest.mark.parametrize("across", [False, True])


@functools.cache
def found(across: bool) -> tuple[Fan, Fitted]:
    of = fan(BODY, "travel", across)
    return of, fitted(of, ADVANCE, TURN)


def made(across: bool, k: int, cycles: int) -> np.ndarray:
    """Return the twist of one of the strokes on the exact flow, played so many times. Shape (6,)."""
    of, fit = found(across)
    half_side, offset = (float(x[0]) for x in of.loops.sides(fit.bend[k : k + 1], fit.offset_share[k : k + 1]))
    there, loop, back = stroke(half_side, offset, across)
    entry = flown(BODY, [Block(2, "", there)])
    cycle = se3.log(flown(BODY, [Block(2, "", there), Block(2, "", loop)]) @ se3.inverse(entry))
    return cycles * cycle + se3.log(flown(BODY, [Block(2, "", there), Block(2, "", back)]))


@BOTH
def test_fitted_loops_advance_and_turn_as_asked(across: bool) -> None:
    """On the exact flow; a cycle more, the foil, goes too far. Only loops in the plane can go exactly straight."""
    fit = found(across)[1]
    for k in np.flatnonzero((TURN > 0.0) | (not across)).tolist():
        twist, more = (made(across, k, int(fit.cycles[k]) + extra) for extra in (0, 1))
        assert_close([abs(twist[0]), np.hypot(twist[4], twist[5])], [ADVANCE[k], TURN[k]], NEAR)
        assert abs(more[0]) > ADVANCE[k] + 2 * NEAR


@BOTH
def test_loops_stay_within_the_table(across: bool) -> None:
    of, fit = found(across)
    bend, offset_share = of.loops.clipped(fit.bend, fit.offset_share)
    assert_close(fit.bend, bend, 0.0)
    assert_close(fit.offset_share, offset_share, 0.0)


@BOTH
def test_no_fewer_cycles_would_do(across: bool) -> None:
    """Two fewer of even the best loops fall short: one may be made up for by the ways in and out."""
    of, fit = found(across)
    knot = of.knot(ADVANCE, TURN)
    once = of.loops.at(of.at(knot, of.bend), of.at(knot, of.offset_share))
    reach = (fit.cycles - 2) * np.abs(once.cycle[0][:, 0])
    assert np.all(reach[fit.cycles > 2] < ADVANCE[fit.cycles > 2])


@BOTH
def test_the_cost_is_the_joint_travel_of_the_strokes(across: bool) -> None:
    of, fit = found(across)
    for k, (half_side, offset) in enumerate(zip(*of.loops.sides(fit.bend, fit.offset_share), strict=True)):
        there, loop, back = stroke(float(half_side), float(offset), across)
        travel = there.joint_travel_rad + int(fit.cycles[k]) * loop.joint_travel_rad + back.joint_travel_rad
        assert fit.cost[k] == pytest.approx(travel, rel=1e-9)
    assert np.all(fit.cost >= of.cost(ADVANCE, TURN) - 0.5)


@BOTH
def test_many_arcs_are_fitted_as_each_alone(across: bool) -> None:
    of, fit = found(across)
    for k in range(len(ADVANCE)):
        alone = fitted(of, ADVANCE[k : k + 1], TURN[k : k + 1])
        assert alone.cycles[0] == fit.cycles[k]
        assert_close([alone.bend[0], alone.offset_share[0]], [fit.bend[k], fit.offset_share[k]], 1e-12)


def test_a_straight_way_takes_loops_that_are_not_bent_aside() -> None:
    of, fit = found(False)
    assert np.all((fit.offset_share < 1e-3) == (TURN == 0.0))
    wanted = se3.pose(np.eye(3), [math.copysign(0.4, of.advance[0]), 0.0, 0.0])
    assert missed(wanted, se3.exp(made(False, 3, int(fit.cycles[3])))) < NEAR
