"""Every stored scenario comes to the verdict that it expects."""

from __future__ import annotations

import dataclasses

import pytest
from helpers import is_close

from purcell_cli import load_scenario, stored_scenarios
from purcell_cli.batch.expectations import shortfalls
from purcell_cli.batch.solve_one import Settings, solve

SCENARIOS = stored_scenarios()
SLOW = {
    *("nearby", "planar-hinges", "planar-manoeuvre", "robot-joints", "slender", "universal-joints", "vessel"),
    "yaw-and-pitch",
}
"""Those that take a second or more."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else []) for n in SCENARIOS])
def test_a_stored_scenario_comes_to_what_it_expects_within_its_limits(name: str) -> None:
    """As a batch judges it; the foil, an expectation of a little less than was found, is not held."""
    scenario = load_scenario(SCENARIOS[name])
    row = solve(scenario, Settings(trajectories=False)).row
    assert shortfalls(scenario.expect, row) == []
    assert row["verdict"] == "reached"
    assert row["clearance_m"] > 0.0
    assert row["largest_bend_rad"] is None or row["largest_bend_rad"] <= scenario.swimmer.max_bend_rad
    less = dataclasses.replace(scenario.expect, max_joint_travel_rad=0.999 * row["joint_travel_rad"])
    assert len(shortfalls(less, row)) == 1
    assert len(shortfalls(dataclasses.replace(scenario.expect, verdict="not reached"), row)) == 1


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_stored_scenario_has_the_name_of_its_file_and_something_to_do(name: str) -> None:
    scenario = load_scenario(SCENARIOS[name])
    assert scenario.name == name
    same_pose = is_close(scenario.start.pose, scenario.goal.pose, 0.0)
    assert not (same_pose and is_close(scenario.start.shape, scenario.goal.shape, 0.0))


def test_ten_scenarios_or_more_are_stored() -> None:
    assert len(SCENARIOS) >= 10
