"""The loops of swimmers on hinges and universal joints: they close, and do what the flow along them does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from joint_queries import COMBINATIONS, random_query

from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_motion import excess_of_ranges, home_shape
from purcell_cli.mechanics.joints import ANGLES, Joint
from purcell_cli.mechanics.lift import displacements
from purcell_cli.mechanics.swimmer import Swimmer
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


ONE_SIDED = {
    "universal and hinge": (
        Joint("universal", theta_deg=(15.0, 60.0)),
        Joint("hinge", "yaw", psi_deg=(-70.0, -5.0)),
    ),
    "universal joints": (
        Joint("universal", psi_deg=(-50.0, -10.0), theta_deg=(12.0, 60.0)),
        Joint("universal", psi_deg=(5.0, 80.0)),
    ),
    "yaw and pitch hinge": (Joint("hinge", "yaw", psi_deg=(2.0, 50.0)), Joint("hinge", "pitch", theta_deg=(8.0, 90.0))),
}


@pytest.mark.parametrize("name", ONE_SIDED)
def test_loops_stay_in_ranges_that_do_not_hold_0_and_within_the_bend_limit(name: str) -> None:
    """From a shape between the phases with room to both sides; loops of a wider limit (the foil) do not stay."""
    swimmer = Swimmer(joints=ONE_SIDED[name], max_bend_rad=0.9).scaled()
    wider = dataclasses.replace(swimmer, max_bend_rad=1.1)
    home = home_shape(swimmer, COLLINEAR)
    for joint, limb in zip(swimmer.joints, home, strict=True):
        for angle, value in zip(ANGLES, joint.read(limb), strict=True):
            if joint.range_deg(angle):
                assert min(-joint.beyond(angle, value - 0.09), -joint.beyond(angle, value + 0.09)) == 0.0

    def farthest(loops: Swimmer) -> float:
        every = loops_of(loops, home)
        found = every.some(np.linspace(0, len(every.screws) - 1, 60).astype(np.int64))
        shapes = np.concatenate([(loop.approach + loop.cycle).shapes(home) for loop in found.loops])
        angles = np.array([[joint.read(limb) for joint, limb in zip(swimmer.joints, s, strict=True)] for s in shapes])
        assert np.max(excess_of_ranges(swimmer, angles)) < 1e-12
        return float(np.max(np.arccos(shapes[..., 0, 0])))

    assert farthest(swimmer) < 0.9
    assert farthest(wider) > 0.9
