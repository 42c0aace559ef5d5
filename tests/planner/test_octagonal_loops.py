"""Octagons: squares with their corners cut, which end as squares do and are the quicker for it."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import UNIT, assert_close, is_close

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.octagonal_loops import corners, cycle, lasts, octagons, twist, yaws

CUTS = [(0.0, 0.0), (0.4, 0.25), (0.55, 0.27), (0.5, 0.5)]
FLOW = 1e-6
"""Loops are compared on a flow with errors of about 1e-7 (L, rad)."""


@pytest.mark.parametrize("cuts", CUTS)
@pytest.mark.parametrize("offset", [0.0, 0.3, -0.2])
def test_an_octagon_closes_and_is_symmetric_about_its_centre(offset: float, cuts: tuple[float, float]) -> None:
    corner = corners(0.7, offset, cuts)
    assert_close(np.sum(cycle(corner), axis=0), np.zeros(2), 1e-15)
    assert_close(MoveSequence.of_turns(yaws(cycle(corner))).shapes(COLLINEAR)[-1], COLLINEAR, 1e-15)
    assert_close(corner[:4] + corner[4:], np.full((4, 2), [2.0 * offset, -2.0 * offset]), 1e-15)
    assert_close(np.max(corner - corner.mean(axis=0), axis=0), [0.7, 0.7], 1e-15)


@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_without_cuts_an_octagon_swims_as_its_square_does(offset: float) -> None:
    """The square gone round by primitives from the same corner; with cuts, the foil, it swims otherwise."""
    corner = corners(0.6, offset, (0.0, 0.0))
    sides = cycle(corner)
    steps = [(3 * limb + 2, float(side[limb])) for side in sides for limb in (0, 1) if abs(side[limb]) > 1e-12]
    assert len(steps) == 4
    way = MoveSequence.of_turns(yaws(corner[:1]))
    entry = flow(UNIT, way)
    around = flow(UNIT, PrimitiveSequence.of(steps), way.shapes(COLLINEAR)[-1])
    assert_close(twist(UNIT, corner), se3.log(entry @ around @ se3.inverse(entry)), FLOW)
    assert not is_close(twist(UNIT, corners(0.6, offset, (0.4, 0.25))), twist(UNIT, corner), 1e-2)


@pytest.mark.parametrize("cuts", CUTS[1:])
def test_the_other_way_round_undoes_it_and_the_mirror_image_turns_the_other_way(cuts: tuple[float, float]) -> None:
    corner = corners(0.7, 0.3, cuts)
    once = twist(UNIT, corner)
    assert_close(twist(UNIT, np.concatenate([corner[:1], corner[:0:-1]])), -once, FLOW)
    mirrored = twist(UNIT, -corner)
    assert_close(mirrored[[0, 5]], once[[0, 5]] * [1.0, -1.0], FLOW)
    assert_close(twist(UNIT, corners(0.7, -0.3, cuts))[5], -once[5], FLOW)
    assert abs(once[5]) > 1e-2


def test_round_the_collinear_shape_an_octagon_goes_straight() -> None:
    made = twist(UNIT, corners(0.8, 0.0, (0.5, 0.3)))
    assert_close(made[3:], np.zeros(3), 1e-12)
    assert abs(made[0]) > 0.1


def test_a_cycle_lasts_as_long_as_its_longer_turns() -> None:
    """8 half sides for a square; a cut side, on which both limbs turn, costs once what it saves twice."""
    assert lasts(corners(0.5, 0.2, (0.0, 0.0))) == pytest.approx(4.0)
    assert lasts(corners(0.5, 0.2, (0.4, 0.2))) == pytest.approx(4.0 - 2.0 * (0.4 + 0.2))


@pytest.mark.slow
@pytest.mark.parametrize(("bend", "speed", "square"), [(1.0, 0.0610, 0.0451), (1.6, 0.0766, 0.0460)])
def test_a_cut_square_cruises_a_third_as_fast_again(bend: float, speed: float, square: float) -> None:
    """In units of L per second at one radian per second, without turning; the best square within the bend is slower."""
    loops = octagons(Swimmer(max_bend_rad=bend).scaled())
    corner = corners(loops.half[0], 0.0, (loops.cuts[0, 0], loops.cuts[0, 1]))
    made = twist(UNIT, corner)
    assert np.linalg.norm(made[:3]) / lasts(corner) >= speed > (1.0 + 1.0 / 3.0) * square
    assert_close(made[2:], np.zeros(4), 1e-12)
    assert np.max(np.abs(corner)) <= bend + 1e-12


@pytest.mark.slow
def test_the_cuts_are_about_the_best() -> None:
    """No cuts a twentieth of the side off are quicker by more than half a per cent; none at all are much slower."""
    loops = octagons(UNIT.scaled())

    def speed(k: int, cuts: tuple[float, float]) -> float:
        corner = corners(loops.half[k], loops.offset[k], cuts)
        return float(np.linalg.norm(twist(UNIT, corner)[[0, 5]])) / lasts(corner)

    for k in range(0, len(loops.half), 2):
        p, r = loops.cuts[k].tolist()
        best = speed(k, (p, r))
        for dp, dr in ((0.05, 0.0), (-0.05, 0.0), (0.0, 0.05), (0.0, -0.05)):
            if p + dp + r + dr <= 1.0 and min(p + dp, r + dr) >= 0.0:
                assert speed(k, (p + dp, r + dr)) < 1.005 * best
        assert speed(k, (0.0, 0.0)) < 0.9 * best


@pytest.mark.parametrize("bend", [0.5, 1.0])
def test_the_table_keeps_the_bend_limit_and_says_what_its_loops_do(bend: float) -> None:
    loops = octagons(Swimmer(max_bend_rad=bend).scaled())
    assert np.all(np.diff(loops.offset) > 0.0)
    assert np.all(loops.offset + loops.half <= bend + 1e-12)
    for k in range(len(loops.half)):
        made = twist(UNIT, corners(loops.half[k], loops.offset[k], tuple(loops.cuts[k])))
        assert_close([loops.advance[k], loops.turn[k]], made[[0, 5]], 1e-12)


@pytest.mark.parametrize(("advance", "turn"), [(0.2, 0.0), (-0.2, 0.0), (0.2, 0.02), (0.2, -0.02), (-0.2, 0.02)])
def test_a_loop_like_another_swims_its_arc(advance: float, turn: float) -> None:
    """As many cycles as are said advance and turn as much, to a few per cent, forwards and backwards."""
    corner, each = octagons(UNIT.scaled()).like(advance, turn)
    made = each * twist(UNIT, corner)
    assert_close(made[[0, 5]], [advance, turn], 0.04 * abs(advance))
    assert not is_close(made[[0, 5]], [-advance, turn], 0.04 * abs(advance))
