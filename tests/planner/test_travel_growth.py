"""Joint travel grows smoothly with distance, and less of it is not found for another objective."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import NIGHTLY, mostly_slow

from purcell_cli import Configuration, PlanOptions, plan
from purcell_cli.geometry import se3

FARTHER = 1.15
"""Ratio of neighbouring distances; joint travel may grow by 30 % between them, and fall by 5 %."""


def travel(twist: tuple[float, ...], amount: float) -> float:
    """Return the joint travel of a plan for part of a twist [L, rad], limbs straight at both ends [rad]."""
    pose = se3.exp(amount * np.array(twist) / np.linalg.norm(twist))
    pose[:3, 3] *= 0.1
    found = plan(Configuration(), Configuration(pose))
    assert found.verdict == "reached"
    return found.joint_travel_rad


def growths(twist: tuple[float, ...], nearest: float, farthest: float, every: int) -> list[float]:
    """Return how joint travel grows from one amount to the next, which is so many steps of 15 % more."""
    count = int(np.log(farthest / nearest) / np.log(FARTHER)) // every + 1
    found = [travel(twist, nearest * FARTHER ** (every * k)) for k in range(count)]
    return [b / a for a, b in itertools.pairwise(found)]


@pytest.mark.parametrize("twist", mostly_slow([(1, 1, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0)], 1))
def test_a_way_aside_takes_no_jump(twist: tuple[float, ...]) -> None:
    """From 0.1 to 0.15 L, where arcs after a few strokes aside would take 4.4 times as much."""
    (growth,) = growths(twist, 0.1, 0.16, 3)
    assert 0.95 <= growth <= 1.3**3


def test_a_way_aside_takes_no_more_than_the_stored_motion() -> None:
    """0.2 L along y: no more than 134 rad per L, which squares of 1 rad take; arcs take 79 rad."""
    assert travel((0, 1, 0, 0, 0, 0), 0.2) < 0.2 * 134.0


NEAR, FAR = (0.5, 11), (2.5, 17)
"""To which distance a scan goes from 0.02 [L or rad], and how many steps of two ratios it takes."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("twist", "range_"),
    [
        ((1, 0, 0, 0, 0, 0), NEAR),
        ((0, 0, 0, 1, 1, 1), NEAR),
        *(
            pytest.param(twist, FAR, marks=NIGHTLY)
            for twist in [
                *((1, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (1, 1, 1, 0, 0, 0)),
                *((0, 0, 0, 0, 0, 1), (0, 0, 0, 1, 1, 1)),
            ]
        ),
    ],
)
def test_joint_travel_grows_smoothly(twist: tuple[float, ...], range_: tuple[float, int]) -> None:
    farthest, steps = range_
    found = growths(twist, 0.02, farthest, 2)
    assert len(found) == steps
    assert max(found) <= 1.3**2
    assert min(found) >= 0.95


@pytest.mark.slow
@pytest.mark.parametrize("objective", ["energy", "switches"])
def test_another_objective_finds_no_less_travel(objective: str) -> None:
    """Its candidates are the same, and the travel search refines those of least travel first."""
    goal = Configuration.from_angles((0.0, 0.02, 0.0))
    least = plan(Configuration(), goal).joint_travel_rad
    assert plan(Configuration(), goal, options=PlanOptions(objective=objective)).joint_travel_rad >= least * (
        1.0 - 1e-9
    )
