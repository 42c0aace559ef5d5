"""Quarter rolls: what limbs' symmetry saves, and that nothing but the limbs' own controls change by it."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, is_close

from purcell_cli import Configuration, Controls, PlanOptions, Swimmer, plan
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Plan
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls, quarter_turns

BODY = Swimmer().scaled()
BENT = Configuration.from_angles(limb1_euler_deg=(30.0, -20.0, 80.0), limb2_euler_deg=(-10.0, 40.0, -130.0))
STROKE = PrimitiveSequence.of(
    [("limb1 yaw", 0.5), ("limb2 pitch", 0.4), ("limb1 roll", 0.3), ("limb2 yaw", -0.6), ("limb1 pitch", 0.2)]
)


def limbs(first: float, second: float = 0.0, x: float = 0.0) -> Configuration:
    """Return a configuration whose limbs are straight and rolled [deg], its base at x [m]."""
    return Configuration.from_angles((x, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, first), (0.0, 0.0, second))


@pytest.mark.parametrize("turns", [(0, 0), (1, 0), (2, 3), (3, 1)])
@pytest.mark.parametrize("moves", [False, True])
def test_rolled_limbs_play_the_same_motion_about_their_own_axes(turns: tuple[int, int], moves: bool) -> None:
    rolls = QuarterRolls(turns)
    seen, sequence = rolls.seen(BENT), MoveSequence.of_controls(STROKE) if moves else STROKE
    planned = Plan(Swimmer(), seen, seen, (Block(2, "stroke", sequence),))
    played = rolls.played(planned, BENT, BENT).blocks[0].sequence
    assert type(played) is type(sequence)
    assert_close(flow(BODY, played, BENT.shape), flow(BODY, sequence, seen.shape), 1e-12)
    rolled = np.stack([quarter_turns(n) for n in turns])
    assert_close(played.shapes(BENT.shape)[-1], sequence.shapes(seen.shape)[-1] @ rolled, 1e-12)
    if any(turns):  # the controls as they are seen would move it otherwise
        assert not is_close(flow(BODY, sequence, BENT.shape), flow(BODY, sequence, seen.shape), 1e-3)


def test_limbs_are_rolled_only_where_start_and_goal_share_it() -> None:
    assert QuarterRolls.least(limbs(179.0), limbs(-179.0)).turns == (2, 0)
    assert QuarterRolls.least(limbs(0.0, 80.0), limbs(0.0, 100.0)).turns == (0, 1)
    assert QuarterRolls.least(limbs(44.0), limbs(30.0)).turns == (0, 0)
    assert QuarterRolls.least(limbs(0.0), limbs(180.0)).turns == (0, 0)


@pytest.mark.parametrize(
    ("start", "goal", "most"),
    [
        (limbs(179.0), limbs(-179.0), 0.07975),
        (limbs(0.0, -179.0), limbs(0.0, 179.0), 0.07975),
        (limbs(89.0), limbs(91.0), 0.07975),
        (limbs(135.0, -90.0), limbs(135.0, -90.0, x=1e-4), 2.1),
    ],
)
def test_a_roll_that_start_and_goal_share_is_not_undone(start: Configuration, goal: Configuration, most: float) -> None:
    """Limbs rolled back to none would take 2 pi, 2 pi, pi and 4.5 rad."""
    found = plan(start, goal)
    assert found.verdict == "reached"
    assert found.joint_travel_rad < most


@pytest.mark.slow
def test_simultaneous_controls_arrive_with_rolled_limbs_too() -> None:
    found = plan(limbs(179.0), limbs(-179.0), options=PlanOptions(controls=Controls.SIMULTANEOUS))
    assert found.verdict == "reached"
    assert found.joint_travel_rad < 0.2
