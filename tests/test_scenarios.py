"""Every stored scenario comes to the verdict that it expects."""

from __future__ import annotations

import pytest
from helpers import is_close

from purcell_cli import load_scenario, plan, stored_scenarios
from purcell_cli.errors import PurcellError

SCENARIOS = stored_scenarios()


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_stored_scenario_comes_to_its_expected_verdict(name: str) -> None:
    scenario = load_scenario(SCENARIOS[name])
    expect = scenario.expect
    if expect.verdict == "error":
        with pytest.raises(PurcellError):
            plan(scenario.start, scenario.goal, swimmer=scenario.swimmer)
        return
    solution = plan(scenario.start, scenario.goal, swimmer=scenario.swimmer)
    found = solution.certificate.deviation
    assert solution.verdict == expect.verdict
    if expect.position_tolerance is not None:
        assert found.position_m <= expect.position_tolerance * scenario.swimmer.length_m
    if expect.angle_tolerance_rad is not None:
        assert max(found.base_rad, found.limb1_rad, found.limb2_rad) <= expect.angle_tolerance_rad
    if expect.max_joint_travel_rad is not None:
        assert solution.joint_travel_rad <= expect.max_joint_travel_rad


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_stored_scenario_has_the_name_of_its_file_and_something_to_do(name: str) -> None:
    scenario = load_scenario(SCENARIOS[name])
    assert scenario.name == name
    same_pose = is_close(scenario.start.pose, scenario.goal.pose, 0.0)
    assert not (same_pose and is_close(scenario.start.shape, scenario.goal.shape, 0.0))


def test_ten_scenarios_or_more_are_stored() -> None:
    assert len(SCENARIOS) >= 10
