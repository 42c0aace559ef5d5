"""Joint travel grows steadily with distance: no jump where one kind of motion takes over from another."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from purcell_cli import Configuration, plan
from purcell_cli.geometry import se3

FARTHER = 1.15
"""Ratio of neighbouring distances."""
MOST_GROWTH, MOST_FALL = 1.30, 0.95
"""What joint travel may grow and fall by between neighbours."""

DIRECTIONS = [d for d in itertools.product((1, 0, -1), repeat=3) if d > (0, 0, 0)]
"""The 13 axes and diagonals, one of each pair of opposite ones."""


def travels(direction: tuple[float, ...], first: float, count: int, turning: bool) -> list[float]:
    """Joint travel to goals ever farther in a direction [L], or ever more turned about it [rad]."""
    unit = np.array(direction) / np.linalg.norm(direction)
    out = []
    for k in range(count):
        amount = first * FARTHER**k * unit
        pose = se3.exp(np.concatenate([np.zeros(3), amount] if turning else [amount, np.zeros(3)]))
        pose[:3, 3] *= 0.1  # the paper's L
        found = plan(Configuration(), Configuration(pose))
        assert found.verdict == "reached"
        out.append(found.joint_travel_rad)
    return out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("direction", "first", "turning"),
    [
        ((1, 1, 0), 0.0535, False),
        ((0, 1, 1), 0.1, False),
        ((0, 0, 1), 0.0115, True),
        ((0, 0, 1), 0.01 * FARTHER**37, True),
        ((0, 1, 1), 0.01 * FARTHER**39, True),
        ((1, 0, 0), 1.5315, True),
        ((1, 0, 0), 2.0254, True),
        ((1, 1, 1), 0.0201, True),
        ((1, 1, 0), 0.0266, True),
    ],
    ids=[
        *("along x + y", "along y + z", "about z", "about z, far", "about y + z, to half a turn"),
        *("about x", "about x, to half a turn", "about x + y + z, near", "about x + y, near"),
    ],
)
def test_joint_travel_grows_steadily(direction: tuple[float, ...], first: float, turning: bool) -> None:
    growth = [b / a for a, b in itertools.pairwise(travels(direction, first, 3 if first > 1.0 else 5, turning))]
    assert min(growth) >= MOST_FALL
    assert max(growth) <= MOST_GROWTH
    assert np.prod(growth) > 1.05  # all in all farther costs more


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize(("turning", "count"), [(False, 60), (True, 42)], ids=["distances", "turns"])
@pytest.mark.parametrize("direction", DIRECTIONS, ids=str)
def test_joint_travel_grows_steadily_from_near_to_far(direction: tuple[float, ...], turning: bool, count: int) -> None:
    """From 0.01 to 38 L, or from 0.01 rad to half a turn."""
    growth = [b / a for a, b in itertools.pairwise(travels(direction, 0.01, count, turning))]
    assert min(growth) >= MOST_FALL
    assert max(growth) <= MOST_GROWTH
