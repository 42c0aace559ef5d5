"""The loops of swimmers on hinges and universal joints: they close, and do what the flow along them does."""

from __future__ import annotations

import numpy as np
import pytest
from joint_queries import COMBINATIONS, random_query

from purcell_cli.geometry import se3
from purcell_cli.mechanics.joint_motion import home_shape
from purcell_cli.mechanics.lift import displacements
from purcell_cli.planner.joints.loops import loops_of

_CLOSE = 2e-6
"""What errors of the rough flow on grids may add up to in a loop [L, rad]."""


@pytest.mark.parametrize("name", COMBINATIONS)
def test_loops_close_and_do_what_the_flow_along_them_does(name: str) -> None:
    query = random_query(name, 5)
    swimmer = query.swimmer.scaled()
    home = home_shape(swimmer, query.start.shape)
    every = loops_of(swimmer, home)
    some = np.linspace(0, len(every.screws) - 1, 7).astype(np.int64)
    found = every.some(some)
    backwards = 0
    for loop, twist, travel, approach in zip(
        found.loops, found.screws.twist, found.screws.travel, found.screws.approach, strict=True
    ):
        played = loop.approach + loop.cycle + loop.approach.inverse()
        assert np.max(np.abs(played.shapes(home)[-1] - home)) < 1e-12
        move = se3.prefix_products(displacements(swimmer, played, home))[-1]
        assert np.max(np.abs(se3.log(move) - twist)) < _CLOSE
        backwards += bool(np.max(np.abs(se3.log(se3.inverse(move)) - twist)) > 10 * _CLOSE)
        assert travel == pytest.approx(loop.cycle.joint_travel_rad)
        assert approach == pytest.approx(2.0 * loop.approach.joint_travel_rad)
    assert backwards > 3
