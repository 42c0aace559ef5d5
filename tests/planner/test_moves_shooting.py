"""The equations of a motion on which all joints may turn at once: their values, derivatives, segments and bends."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, is_close, random_shapes

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.kernel.moves import bends, equations
from purcell_cli.mechanics.collocation import flow_of
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import EXACT, SEARCHING, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.inequalities import Linearised, linearised
from purcell_cli.planner.refine.octagonal_loops import yaws
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

SWIMMER = Swimmer(max_bend_rad=0.6).scaled()
CYCLES = 4


def straightened(shape: Array) -> Array:
    """Return the one move that straightens both limbs from a shape. Shape (1, 6)."""
    return -as_vector(shape).reshape(1, 6)


def loop(cycles: int = CYCLES) -> Segment:
    """Return a loop of two sides and the same undone, which closes whatever they are."""
    half = np.array([[0.5, 0.3], [-0.4, 0.2]])
    tie = np.zeros((4, 6, 4))
    for k, (i, sign) in enumerate([(0, 1.0), (1, 1.0), (0, -1.0), (1, -1.0)]):
        tie[k, 2, 2 * i], tie[k, 5, 2 * i + 1] = sign, sign
    return Segment.by_moves(2, "loop", yaws(np.concatenate([half, -half])), cycles, tie=tie.reshape(24, 4))


def motion(cycles: int = CYCLES) -> Equations:
    """Return a motion that arrives: limbs straightened, a loop, limbs bent to the goal's shape."""
    rng = np.random.default_rng(3)
    start, goal = random_shapes(rng), random_shapes(rng)
    segments = [
        Segment.by_moves(1, "in", straightened(start)),
        loop(cycles),
        Segment.by_moves(3, "out", -straightened(goal)),
    ]
    played = np.concatenate([segments[0].turn, np.tile(segments[1].turn, (CYCLES, 1)), segments[2].turn])
    wanted = flow(SWIMMER, MoveSequence.of_turns(played), start)
    return Equations(SWIMMER, segments, start, goal, wanted, EXACT)


def at(angle: Array) -> Linearised:
    return linearised(motion(), motion().at(angle), SWIMMER.max_bend_rad)


def test_a_motion_that_arrives_misses_nothing() -> None:
    """Against the flow of all cycles one after the other; the foil plays one cycle fewer."""
    assert motion().at(motion().angles).size < 1e-12
    assert motion(CYCLES - 1).at(motion().angles).size > 1e-2


@pytest.mark.slow
def test_the_equations_have_the_derivative_they_say() -> None:
    """Central differences at the arrival, a repeated loop and bends among them; the foil: the loop played once."""
    angle = motion().angles
    values, here = motion().at(angle), at(angle)
    assert len(angle) == 16
    h = 1e-6
    slopes, slacks = [], []
    for step in h * np.eye(16):
        up, down = motion().at(angle + step), motion().at(angle - step)
        slopes.append((up.residual - down.residual) / (2 * h))
        slacks.append((at(angle + step).slack - at(angle - step).slack) / (2 * h))
    free = [k for k in range(16) if not 6 <= k < 10]
    assert_close(values.derivative[:, 6:10], np.array(slopes).T[:, 6:10], 1e-7)
    assert_close(values.derivative[:6, 10:], np.array(slopes).T[:6, 10:], 1e-7)
    assert_close(values.derivative[6:, free], np.array(slopes).T[6:, free], 1e-7)
    assert len(here.slack) > 0
    assert_close(here.slope, np.array(slacks).T, 1e-7)
    once = motion(1).at(angle)
    assert not is_close(once.derivative[:6, 6:10], values.derivative[:6, 6:10], 1e-2)


def test_segments_take_their_angles_and_give_them_back() -> None:
    rng = np.random.default_rng(0)
    angle = rng.normal(size=16)
    segments = motion().with_angles(angle)
    assert_close(motion().of(segments).angles, angle, 1e-14)
    assert_close(np.sum(segments[1].turn, axis=0), np.zeros(6), 1e-15)
    held = Segment.by_moves(2, "held", loop().turn, 2, fixed=True)
    both = motion().of([segments[0], held])
    assert len(both.angles) == 6
    assert_close(both.with_angles(angle[:6])[1].turn, loop().turn, 0.0)


def test_a_motion_lasts_as_long_as_the_joint_that_turns_furthest_on_each_move() -> None:
    moves = [np.abs(segment.turn).max(axis=1).sum() * segment.cycles for segment in motion().segments]
    assert motion().duration == pytest.approx(sum(moves))
    assert loop().duration == pytest.approx(CYCLES * 2 * (0.5 + 0.4))


def test_where_a_limb_is_most_bent_on_a_move_is_where_fine_samples_have_it() -> None:
    """On large turns too; the end alone, the foil, is often less bent."""
    rng = np.random.default_rng(1)
    turn = 2.0 * rng.normal(size=(60, 6))
    kernel = flow_of(SWIMMER, SEARCHING)
    found = equations(kernel, COLLINEAR, turn, np.empty((0, 3), dtype=np.int64), np.eye(4), [60], COLLINEAR[None])
    room, slope = bends(found, np.full((60, 2), -1.0), 3.0)
    assert slope.shape == (120, 360)
    before, samples = found.shapes[:-1], np.linspace(0.0, 1.0, 801)[1:]
    swept = (before @ se3.rotation(samples[:, None, None, None] * turn.reshape(60, 2, 3)))[..., 0, 0]
    lowest = (room - 1.0).reshape(60, 2)
    # Unless it is most bent as it begins, which is the end of the move before.
    begins = swept.min(axis=0) > before[..., 0, 0] - 1e-9
    assert_close(lowest[~begins], swept.min(axis=0)[~begins], 1e-4)
    assert np.sum(swept[-1][~begins] > lowest[~begins] + 1e-2) > 30


def test_a_motion_on_a_rougher_flow_is_the_same_motion() -> None:
    rough = motion().at_accuracy(SEARCHING)
    assert_close(rough.angles, motion().angles, 0.0)
    assert 1e-14 < rough.at(rough.angles).size < 1e-5
    assert motion().of(rough.segments).accuracy == EXACT
