"""Sensitivities are what an independent replay with another swimmer finds."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest
from helpers import assert_close, is_close

from purcell_cli import (
    Configuration,
    LinkDrag,
    LinkDrags,
    PlanOptions,
    PrimitiveSequence,
    Swimmer,
    flow,
    stored_scenarios,
)
from purcell_cli.errors import ParameterError
from purcell_cli.files.scenario_file import load_scenario
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import angle_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.swimmer import LIMITS
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.sensitivity import CHANGE, PARAMETERS, drag_sensitivity, sensitivities
from purcell_cli.planner.objectives import cost
from purcell_cli.planning import plan
from purcell_cli.solution import Solution
from purcell_cli.verification.replay import replay


@functools.cache
def solution(name: str) -> Solution:
    scenario = load_scenario(stored_scenarios()[name])
    return plan(scenario.start, scenario.goal, swimmer=scenario.swimmer)


def replayed(made: Solution, parameter: str, change: float) -> tuple[float, float]:
    """Return how far the end moves [m, rad] by the certificate's replay of the written controls."""
    swimmer = made.plan.swimmer
    other = dataclasses.replace(swimmer, **{parameter: getattr(swimmer, parameter) * (1.0 + change)})
    rows = made.trajectory
    first, second = (replay(s, made.plan.start, rows.time_s, rows.rate_rad_s).end.pose for s in (swimmer, other))
    turned = angle_between(first[:3, :3], second[:3, :3])
    return float(np.linalg.norm(second[:3, 3] - first[:3, 3])), float(turned)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nearby", "far", "slender", "unequal-links", "bent-start"])
def test_a_sensitivity_is_what_an_independent_replay_finds(name: str) -> None:
    made = solution(name)
    swimmer = made.plan.swimmer
    found = sensitivities(swimmer, made.plan.start, made.plan.blocks)
    assert [s.parameter for s in found] == list(PARAMETERS)
    for s in found:
        both = {change: replayed(made, s.parameter, change) for change in (CHANGE, -CHANGE)}
        position, angle = both[s.change]
        assert_close(s.position_m, position, 2e-8, swimmer.length_m)
        assert_close(s.angle_rad, angle, 2e-8)
        other, turned = both[-s.change]
        assert position / swimmer.length_m + angle >= other / swimmer.length_m + turned
        assert s.position_m > 0.0 or s.angle_rad > 0.0
    assert not is_close(found[0].position_m, found[1].position_m, 1e-3, found[0].position_m)


@pytest.mark.slow
def test_what_is_not_looked_at_moves_nothing() -> None:
    """Every parameter of a swimmer is looked at, but for those that the path does not depend on."""
    free = {"viscosity_pa_s": 1.01, "max_bend_rad": 1.01}
    assert set(PARAMETERS) | set(free) | {"joint_rate_rad_s"} == set(LIMITS)
    for parameter in free:
        assert_close(replayed(solution("nearby"), parameter, 0.01), (0.0, 0.0), 1e-13)


def test_the_strokes_shares_add_up_to_first_order() -> None:
    made = solution("far")
    for change in (1e-3, 1e-4):
        for s in sensitivities(made.plan.swimmer, made.plan.start, made.plan.blocks, change):
            total = s.by_block.sum(axis=0)
            size = np.hypot(np.linalg.norm(total[:3]) / 0.1, np.linalg.norm(total[3:]))
            assert_close(size, np.hypot(s.position_m / 0.1, s.angle_rad), 10.0 * change, float(size))


@pytest.mark.parametrize(
    ("swimmer", "parameter", "change"),
    [
        (Swimmer(slenderness=0.2), "slenderness", -CHANGE),
        (Swimmer(drag_ratio=1.005), "drag_ratio", CHANGE),
        (Swimmer(drag_ratio=1000.0), "drag_ratio", -CHANGE),
        (Swimmer(limb_half_length_m=10.0), "limb_half_length_m", -CHANGE),
        (Swimmer(limb_half_length_m=10.0), "base_half_length_m", CHANGE),
    ],
)
def test_a_swimmer_that_cannot_be_is_left_out(swimmer: Swimmer, parameter: str, change: float) -> None:
    blocks = [Block(2, "any", PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.5), ("limb1 roll", 0.3)]))]
    found = {s.parameter: s for s in sensitivities(swimmer, Configuration(), blocks)}
    assert found[parameter].change == change


def test_no_motion_is_not_sensitive() -> None:
    for s in sensitivities(Swimmer(), Configuration(), []):
        assert (s.position_m, s.angle_rad, s.by_block.shape) == (0.0, 0.0, (0, 6))


# --- Drag that is uncertain on its own -------------------------------------------------------------------------------

LOOP = PrimitiveSequence.of([("limb1 yaw", 0.8), ("limb2 yaw", -0.6), ("limb1 yaw", -0.8), ("limb2 yaw", 0.6)])
BLOCKS = [Block(2, "loop", LOOP, 3)]


def with_more(swimmer: Swimmer, links: tuple[str, ...], part: str, change: float) -> Swimmer:
    """Return a swimmer, some of whose links' drag is a little more; part: along, across, turn, spin or all."""
    drags = {}
    for k, link in enumerate(("base", "limb1", "limb2")):
        rod, more = swimmer.rod(k), 1.0 + change
        own = {name: more if link in links and part in (name, "all") else 1.0 for name in ("along", "across", "turn")}
        spin = more if link in links and part == "all" else 1.0
        drags[link] = LinkDrag(
            own["along"] * rod.along, own["across"] * rod.across, own["turn"] * rod.turn, spin * rod.spin
        )
    return dataclasses.replace(swimmer, drag=LinkDrags(**drags))


def test_the_sensitivity_to_drag_is_that_of_other_swimmers() -> None:
    """All drags alike move nothing, so they are not uncertain together; spin is the foil."""
    swimmer = Swimmer(0.13, 0.1)
    moved = {}
    for links in (("base",), ("limb1", "limb2"), ("base", "limb1", "limb2")):
        for part in ("along", "across", "turn", "all"):
            ends = [flow(with_more(swimmer, links, part, sign * 1e-3), LOOP.times(3)) for sign in (1.0, -1.0)]
            twist = se3.log(np.linalg.inv(ends[1]) @ ends[0]) / 2e-3
            twist[:3] /= swimmer.length_m
            moved[links[0], len(links), part] = float(np.linalg.norm(twist))
    assert moved["base", 3, "all"] < 1e-8
    known = [("base", 1, "along"), ("base", 1, "turn"), *(("limb1", 2, part) for part in ("along", "across", "turn"))]
    wanted = np.sqrt(sum(moved[one] ** 2 for one in known))
    found = drag_sensitivity(swimmer, BLOCKS, COLLINEAR)
    assert_close(found, wanted, 2e-3, wanted)
    assert found > 0.1
    assert drag_sensitivity(dataclasses.replace(swimmer, viscosity_pa_s=9.0), BLOCKS, COLLINEAR) == pytest.approx(found)
    assert drag_sensitivity(swimmer, [], COLLINEAR) == 0.0


def test_a_plan_of_least_sensitivity_arrives_and_is_no_worse_than_that_of_least_travel() -> None:
    goal = Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 10))
    ways = [
        plan(Configuration(), goal, options=PlanOptions(effort="quick", objective=o)) for o in ("travel", "sensitivity")
    ]
    spent = [cost("sensitivity", way.plan.swimmer, way.plan.blocks, COLLINEAR) for way in ways]
    assert [way.verdict for way in ways] == ["reached", "reached"]
    assert 0.0 < spent[1] <= spent[0] * (1.0 + 1e-9)
    assert cost("sensitivity", Swimmer(), [], COLLINEAR) == 0.0


def test_joints_that_turn_at_once_have_no_least_sensitivity() -> None:
    options = PlanOptions(controls="simultaneous", objective="sensitivity")
    with pytest.raises(ParameterError, match="sensitivity goes with the controls primitive"):
        plan(Configuration(), Configuration.from_angles((0.01, 0, 0)), options=options)
