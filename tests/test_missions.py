"""Missions through waypoints: each is passed exactly in what it names, and the rest is used to make the way shorter."""

from __future__ import annotations

import dataclasses
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import assert_close, dop853_rates, is_close, runner

from purcell_cli import (
    Configuration,
    Curve,
    Follow,
    Mission,
    Order,
    PlanDocument,
    PlanOptions,
    Swimmer,
    Waypoint,
    load_plan,
    plan,
    plan_mission,
    write_plan,
)
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import HalfSpace, Sphere
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, angle_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Blocked, Plan
from purcell_cli.motion.trajectory import schedule
from purcell_cli.planner.missions import mission_legs
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.missions.mission_legs import MissionLegs, Stop
from purcell_cli.planner.missions.on_the_way import blocks_before
from purcell_cli.planner.missions.waypoint_order import cheapest_orders, leg_prices
from purcell_cli.planner.missions.waypoint_poses import Touring, cheapest_way
from purcell_cli.planner.rest import blocks_after
from purcell_cli.planner.routes.around import ended
from purcell_cli.planning import planned
from purcell_cli.solution import Solution

QUICK = PlanOptions(effort="quick")


def at(*position_m: float, **named: Any) -> Waypoint:
    return Waypoint(np.array(position_m), **named)


@pytest.fixture(scope="module")
def short() -> Solution:
    """Return a short mission: a position, then limbs, then all of a configuration."""
    turn, limb = about_axis(0, 0.05), about_axis(2, 0.1)
    via = (
        at(0.001, 0.0, 0.0),
        Waypoint(limb1=limb),
        at(0.002, 0.0, 0.0, orientation=turn, limb1=limb, limb2=np.eye(3)),
    )
    return plan_mission(Mission(Configuration(), Configuration(), via), options=QUICK)


def waypoints_integrated(solution: Solution) -> list[tuple[Array, Array]]:
    """Return the pose and the shape at each waypoint, the pose by an independent integrator."""
    pose, shape, out = solution.plan.start.pose, solution.plan.start.shape, []
    for leg in solution.plan.legs[:-1]:
        time_s, rates = schedule(solution.plan.swimmer, shape, leg)
        pose = dop853_rates(solution.plan.swimmer, rates[:-1], np.diff(time_s), shape, pose)
        shape = starting_shapes(leg, shape)[-1]
        out.append((pose, shape))
    return out


@pytest.mark.slow
def test_each_waypoint_is_passed_in_what_it_names(short: Solution) -> None:
    assert short.verdict == "reached"
    assert len(short.passed) == 3
    integrated = waypoints_integrated(short)
    for passage, found, (pose, shape) in zip(short.plan.passages, short.passed, integrated, strict=True):
        one = passage.waypoint
        if one.position_m is not None:
            assert_close(pose[:3, 3], one.position_m, 1e-9, 0.1)
            assert not is_close(pose[:3, 3], one.position_m + 1e-6, 1e-9, 0.1)
        if one.orientation is not None:
            assert_close(pose[:3, :3], one.orientation, 1e-9)
        for limb, wanted in zip(shape, (one.limb1, one.limb2), strict=True):
            if wanted is not None:
                assert_close(limb, wanted, 1e-9)
        assert found.reached


def test_a_waypoint_that_is_missed_is_not_reached(short: Solution) -> None:
    first, *others = short.plan.passages
    off = dataclasses.replace(first, waypoint=at(0.001, 1e-8, 0.0))
    missed = dataclasses.replace(short, plan=dataclasses.replace(short.plan, passages=(off, *others)))
    assert short.certificate.reached
    assert missed.verdict == "not reached"
    assert [one.reached for one in missed.passed] == [False, True, True]


def test_legs_are_on_the_clock_of_the_whole(short: Solution) -> None:
    """So written times are exact, and limbs do not end a leg off by what rounding of late times adds up to."""
    step = clock_step(short.duration_s)
    lasts = np.concatenate([b.sequence.duration for b in short.plan.blocks]) / step
    assert_close(lasts, np.round(lasts), 0.0)
    alone = planned(Configuration(), Configuration.from_angles((0.002, 0.0, 0.0)), options=QUICK)
    lasts = np.concatenate([b.sequence.duration for b in alone.blocks]) / step
    assert not is_close(lasts, np.round(lasts), 0.0)
    off = short.rows_off
    assert off.position_m < 1e-13
    assert max(off.limb1_rad, off.limb2_rad) < 1e-14


def test_what_is_free_at_a_waypoint_does_not_count() -> None:
    turned = Configuration.from_angles((0.1, 0.2, 0.3), (10, 20, 30), (5, 0, 0))
    assert at(0.1, 0.2, 0.3).deviation(turned).within(0.0, 0.0)
    assert not at(0.1, 0.2, 0.3, limb1=np.eye(3)).deviation(turned).within(0.0, 1e-3)
    assert Waypoint(limb2=np.eye(3)).filled(turned).shape[0].tolist() == turned.shape[0].tolist()


def test_limbs_that_are_named_alone_turn_where_they_are() -> None:
    """There and back is then no way for the base; with the base held fast it takes many strokes."""
    limb = about_axis(2, 0.1)
    found = plan_mission(Mission(Configuration(), Configuration(), (Waypoint(limb1=limb),)), options=QUICK)
    assert found.verdict == "reached"
    assert_close(found.joint_travel_rad, 0.2, 1e-3)


@pytest.mark.slow
def test_free_headings_make_a_way_round_shorter_than_separate_plans() -> None:
    via, goal = (at(0.15, 0.15, 0.0),), Configuration.from_angles((0.0, 0.3, 0.0), (180.0, 0.0, 0.0))
    whole = plan_mission(Mission(Configuration(), goal, via), options=QUICK)
    ends = [Configuration(), *(one.filled(Configuration()) for one in via), goal]
    apart = sum(plan(a, b, options=QUICK).joint_travel_rad for a, b in itertools.pairwise(ends))
    assert whole.verdict == "reached"
    assert whole.joint_travel_rad < 0.75 * apart


@pytest.mark.slow
def test_cruising_goes_on_through_waypoints_on_the_way() -> None:
    """Legs that end and begin with collinear limbs there take 6 to 9 % more than the plan that ignores them."""
    goal = Configuration.from_angles((0.6, 0.0, 0.0))
    via = tuple(at(x, 0.0, 0.0) for x in (0.1, 0.3, 0.4))
    found = plan_mission(Mission(Configuration(), goal, via), options=PlanOptions(dt_s=1.0))
    assert found.verdict == "reached"
    assert found.joint_travel_rad < 1.03 * planned(Configuration(), goal).joint_travel_rad
    shapes = starting_shapes(found.plan.blocks, COLLINEAR)
    for passage in found.plan.passages:
        assert float(np.max(bends(shapes[passage.block, :, :, 0]))) > 0.3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("one", "more"),
    [
        (Waypoint(limb1=about_axis(2, 0.7), limb2=about_axis(2, -0.7)), 1.0),
        (Waypoint(orientation=about_axis(2, 0.17)), 5.0),
    ],
)
def test_what_strokes_pass_anyway_costs_little(one: Waypoint, more: float) -> None:
    """To straighten limbs and bend them costs 2.8 rad; to turn the base there and back some 19."""
    goal = Configuration.from_angles((0.2, 0.0, 0.0))
    found = plan_mission(Mission(Configuration(), goal, (one,)), options=QUICK)
    assert found.verdict == "reached"
    assert found.joint_travel_rad < planned(Configuration(), goal, options=QUICK).joint_travel_rad + more
    (_, shape), *_ = waypoints_integrated(found)
    for limb, wanted in zip(shape, (one.limb1, one.limb2), strict=True):
        if wanted is not None:
            assert_close(limb, wanted, 1e-9)


@pytest.mark.slow
def test_limbs_need_not_straighten_where_a_whole_pose_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the line and turned from it by 10 degrees: with straight limbs there it takes arcs."""
    via = (at(0.3, 0.0, 0.0, orientation=about_axis(2, 0.17)),)
    mission = Mission(Configuration(), Configuration.from_angles((0.6, 0.0, 0.0)), via)

    def bent(solution: Solution) -> float:
        shapes = starting_shapes(solution.plan.blocks, COLLINEAR)
        return float(np.max(bends(shapes[solution.plan.passages[0].block, :, :, 0])))

    found = plan_mission(mission, options=QUICK)
    assert found.verdict == "reached"
    assert bent(found) > 0.2
    monkeypatch.setattr(mission_legs, "legs_through", lambda *_: None)
    straight = plan_mission(mission, options=QUICK)
    assert bent(straight) < 1e-9
    assert found.joint_travel_rad < 0.95 * straight.joint_travel_rad


def test_strokes_before_and_after_a_cut_are_the_whole() -> None:
    wanted = planned(Configuration(), Configuration.from_angles((0.3, 0.0, 0.0)), options=PlanOptions(effort="quick"))
    for share in (0.0, 0.013, 0.5, 0.77, 1.0):
        cut_rad = share * wanted.joint_travel_rad
        before = blocks_before(wanted, cut_rad)
        assert_close(sum(b.joint_travel_rad for b in before), cut_rad, 1e-9)
        whole = dataclasses.replace(wanted, blocks=(*before, *blocks_after(wanted, cut_rad)))
        assert_close(ended(whole).pose, ended(wanted).pose, 1e-9)


def test_the_cheapest_way_is_that_of_all_ways() -> None:
    rng = np.random.default_rng(0)
    steps = [rng.uniform(size=shape) for shape in ((1, 4), (4, 3), (3, 5), (5, 1))]
    picks, price = cheapest_way(steps)

    def priced(way: tuple[int, ...]) -> float:
        places = (0, *way, 0)
        return sum(float(step[a, b]) for step, (a, b) in zip(steps, itertools.pairwise(places), strict=True))

    every = {way: priced(way) for way in itertools.product(range(4), range(3), range(5))}
    assert tuple(picks) == min(every, key=lambda way: every[way])
    assert_close(price, min(every.values()), 1e-5)


def test_chosen_headings_are_no_dearer_than_any_that_keep_the_start_s() -> None:
    price = LegPrice(Swimmer())
    via = [at(0.2, 0.15, 0.0), at(0.3, 0.4, 0.1)]
    start, goal = np.eye(4), se3.pose(about_axis(2, 1.5), np.array([0.3, 0.7, 0.0]))

    def priced(poses: list[Array]) -> float:
        ways = [start, *poses, goal]
        return float(np.sum(price(np.stack(ways[:-1]), np.stack(ways[1:]), 96)))

    chosen = Touring(Swimmer(), price).poses(start, via, goal)
    assert [pose[:3, 3].tolist() for pose in chosen] == [[0.2, 0.15, 0.0], [0.3, 0.4, 0.1]]
    assert priced(chosen) < 0.9 * priced(
        [se3.pose(np.eye(3), one.position_m) for one in via if one.position_m is not None]
    )


def test_the_free_order_is_the_best_of_all_orders() -> None:
    """Of the priced legs, six waypoints and all 720 orders; the nearest waypoint first is dearer."""
    rng = np.random.default_rng(2)
    first, between, last = (
        rng.uniform(1.0, 9.0, (6, 3)),
        rng.uniform(1.0, 9.0, (6, 3, 6, 3)),
        rng.uniform(1.0, 9.0, (6, 3)),
    )
    found = cheapest_orders(first, between, last, 40)

    def price_of(order: tuple[int, ...]) -> float:
        paid = first[order[0]]
        for a, b in itertools.pairwise(order):
            paid = np.min(paid[:, None] + between[a, :, b], axis=0)
        return float(np.min(paid + last[order[-1]]))

    prices = {way: price_of(way) for way in itertools.permutations(range(6))}
    assert_close([price for _, price in found], sorted(prices.values())[:40], 1e-5)
    assert_close([prices[tuple(order)] for order, _ in found], [price for _, price in found], 1e-5)
    assert len({tuple(order) for order, _ in found}) == 40
    price = found[0][1]
    assert prices[tuple(np.argsort(first.min(axis=1)).tolist())] > 1.02 * price


@pytest.mark.slow
def test_waypoints_on_a_line_are_passed_one_after_the_other() -> None:
    places = (0.9, 0.3, 0.6)
    via = [at(x, 0.0, 0.0) for x in places]
    goal = se3.pose(np.eye(3), np.array([1.2, 0.0, 0.0]))
    prices = leg_prices(Touring(Swimmer(), LegPrice(Swimmer())), np.eye(4), via, goal)
    (order, _), *_ = cheapest_orders(*prices, 1)
    assert [places[k] for k in order] == sorted(places)


@pytest.mark.parametrize(
    ("wanted", "via", "order"),
    [
        (r"via\.0: another place than the start", (at(0.0, 0.0, 0.0),), "given"),
        (r"via\.1: another place than the goal", (at(0.05, 0.0, 0.0), at(0.1, 0.0, 0.0)), "given"),
        (r"via\.1: another waypoint than via\[0\]", (at(0.05, 0.0, 0.0), at(0.05, 0.0, 0.0)), "given"),
        (r"via\.2: another waypoint than via\[0\]", (at(0.05, 0, 0), at(0.07, 0, 0), at(0.05, 0, 0)), "free"),
        (r"via: at most 12 waypoints", tuple(at(0.01 * k, 1.0, 0.0) for k in range(13)), "free"),
        (r"order: given", (), "free"),
    ],
)
def test_contradictions_are_refused(wanted: str, via: tuple[Waypoint, ...], order: str) -> None:
    with pytest.raises(ParameterError, match=wanted):
        Mission(Configuration(), Configuration.from_angles((0.1, 0.0, 0.0)), via, Order(order))


def test_there_and_back_again_is_no_contradiction() -> None:
    via = (at(0.05, 0.0, 0.0), at(0.07, 0.0, 0.0), at(0.05, 0.0, 0.0))
    assert len(Mission(Configuration(), Configuration.from_angles((0.1, 0.0, 0.0)), via).via) == 3


def test_a_waypoint_names_something() -> None:
    with pytest.raises(ParameterError, match="names a position, an orientation or a limb is wanted, found nothing"):
        Waypoint()


def test_what_leaves_the_plane_of_parallel_hinges_is_refused_by_its_name() -> None:
    swimmer = Swimmer(joints=(Joint("hinge", "yaw"), Joint("hinge", "yaw")))
    goal = Configuration.from_angles((0.4, 0.0, 0.0))
    with pytest.raises(ParameterError, match=r"via\[0\]: base: a pose in the start's x-y plane.*z off by 0\.1 m"):
        plan_mission(Mission(Configuration(), goal, (at(0.2, 0.0, 0.1),)), swimmer=swimmer)
    rising = Follow(Curve(np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.1], [0.4, 0.0, 0.0]])), 0.1)
    with pytest.raises(ParameterError, match=r"follow: base: a pose in the start's x-y plane"):
        plan_mission(Mission(Configuration(), goal, follow=rising), swimmer=swimmer)


def test_headings_at_a_waypoint_keep_clear_of_obstacles() -> None:
    """To look along the way touches the wall; among obstacles on all sides the waypoint is refused by its name."""
    wall = HalfSpace(np.array([0.24, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    limits = Limits(obstacles=Scene((wall,)))
    via, goal = (at(0.2, 0.0, 0.0),), Configuration.from_angles((0.0, 0.0, 0.0), (180, 0, 0))
    touching, clear = (
        Touring(Swimmer(), LegPrice(Swimmer()), one).poses(np.eye(4), via, goal.pose)[0] for one in (Limits(), limits)
    )
    limits.refuse(Swimmer(), "via[0]", Configuration(clear))
    with pytest.raises(ParameterError, match="clear of obstacles"):
        limits.refuse(Swimmer(), "via[0]", Configuration(touching))
    inside = PlanOptions(effort="quick", obstacles=Scene((Sphere(np.array([0.6, 0.02, 0.0]), 0.1),)))
    with pytest.raises(ParameterError, match=r"via\[0\]: all links clear of obstacles are wanted"):
        plan_mission(Mission(Configuration(), goal, (at(0.6, 0.0, 0.0),)), options=inside)


def test_headings_at_a_waypoint_leave_strokes_room() -> None:
    """Beside a wall: to look askew is clear of it, but only along it limbs have room to swing."""
    limits = Limits(obstacles=Scene((HalfSpace(np.array([0.0, -0.14, 0.0]), np.array([0.0, 1.0, 0.0])),)))
    askew, along = (Configuration.from_angles((0.2, 0.0, 0.0), (yaw, 0, 0)) for yaw in (20, 0))
    for one in (askew, along):
        limits.refuse(Swimmer(), "via[0]", one)
    touring = Touring(Swimmer(), LegPrice(Swimmer()), limits)
    waypoint, goal = at(0.2, 0.0, 0.0), Configuration.from_angles((0.4, 0.0, 0.0))
    kept = touring.others(waypoint, Configuration(), goal)
    assert any(np.allclose(one.pose, along.pose) for one in kept)
    nose = [abs(one.pose[1, 0]) for one in kept]
    assert max(nose) < 0.07 < abs(askew.pose[1, 0])
    everywhere = Touring(Swimmer(), touring.price).others(waypoint, Configuration(), goal)
    assert len(everywhere) > len(kept)


def test_where_a_leg_is_blocked_other_headings_are_tried() -> None:
    """The planner is a stand-in: legs that end or begin with one heading are blocked."""
    chosen, goal = Configuration.from_angles((0.2, 0.0, 0.0)), Configuration.from_angles((0.4, 0.3, 0.0))
    planned_to: list[Configuration] = []

    def leg(start: Configuration, end: Configuration, _bent: float) -> Plan:
        planned_to.append(end)
        bad = any(np.allclose(one.pose[:3, :3], np.eye(3)) for one in (start, end) if one.pose[0, 3] == 0.2)
        return Plan(Swimmer(), start, end, (), blocked=Blocked((0.0, 0.0, 0.0), 1.0, 0, "a wall") if bad else None)

    touring = Touring(Swimmer(), LegPrice(Swimmer()))
    legs = MissionLegs(Swimmer(), touring.price, Limits(), leg, lambda *_: None, touring.others, dear=True)
    found = legs.between(Configuration(), [Stop(at(0.2, 0.0, 0.0), chosen)], goal)
    assert [one.blocked for one in found] == [None, None]
    assert angle_between(found[0].goal.pose[:3, :3], np.eye(3)) > 0.3
    assert_close(found[0].goal.pose[:3, 3], [0.2, 0.0, 0.0], 1e-12)
    named = Stop(at(0.2, 0.0, 0.0, orientation=np.eye(3)), chosen)
    planned_to.clear()
    assert legs.between(Configuration(), [named], goal)[0].blocked is not None
    assert len(planned_to) == 2


def test_a_waypoint_whose_limbs_overlap_is_refused() -> None:
    folded = Waypoint(limb1=about_axis(2, 3.0), limb2=about_axis(2, -3.0))
    with pytest.raises(ParameterError, match=r"via\[0\]: a clearance"):
        plan_mission(Mission(Configuration(), Configuration(), (folded,)))


def test_a_plan_document_keeps_the_waypoints(short: Solution, tmp_path: Path) -> None:
    write_plan(PlanDocument(short.plan, short.options), tmp_path / "plan.json")
    again = load_plan(tmp_path / "plan.json").plan
    assert [(p.index, p.block, p.waypoint.names) for p in again.passages] == [
        (p.index, p.block, p.waypoint.names) for p in short.plan.passages
    ]
    text = (tmp_path / "plan.json").read_text()
    (tmp_path / "bad.json").write_text(text.replace('"index": 0, "block": ', '"index": 0, "block": 99'))
    with pytest.raises(Exception, match=r"via\[0\]\.block: wanted a number of blocks"):
        load_plan(tmp_path / "bad.json")


SCENARIO = """
name: tour
start: {}
via:
  - {base: {position_m: [0.001, 0, 0]}}
  - {limb1: {euler_deg: [5, 0, 0]}}
goal: {}
"""


def test_commands_plan_and_verify_a_mission(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    purcell = runner(capsys)
    Path("tour.yaml").write_text(SCENARIO)
    Path("swapped.yaml").write_text(SCENARIO.replace("0.001", "0.0011"))
    code, out, err = purcell("plan", "tour.yaml", "--effort", "quick", "--out", "tour.csv", "--json")
    assert code == 0, err
    waypoints = json.loads(out)["waypoints"]
    assert [(one["index"], one["names"]) for one in waypoints] == [(0, ["position_m"]), (1, ["limb1"])]
    assert 0.0 < waypoints[0]["time_s"] < waypoints[1]["time_s"]
    code, out, _ = purcell("verify", "tour.csv", "tour.yaml", "--json")
    found = json.loads(out)
    assert (code, [one["passed"] for one in found["waypoints"]], found["faults"]) == (0, [True, True], [])
    code, out, _ = purcell("verify", "tour.csv", "swapped.yaml", "--json")
    assert code == 1
    assert "waypoint via[0] is not passed where it is due; nearest on line" in json.loads(out)["faults"][0]
    code, out, _ = purcell("track", "tour.yaml", "--truth", "paper", "--json")
    found = json.loads(out)
    assert (code, found["replans"], [part["leg"] for part in found["parts"]]) == (0, 0, [1, 2, 3])


def test_track_keeps_the_clearance_that_plan_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What really happened stays as far from a ball as the plan, but for what drag that the model mistakes does."""
    monkeypatch.chdir(tmp_path)
    purcell = runner(capsys)
    ball = "obstacles: [{sphere: {centre_m: [0.2, 0.1, 0], radius_m: 0.03}}]"
    Path("ball.yaml").write_text(f"name: ball\nstart: {{}}\ngoal: {{base: {{position_m: [0.02, 0, 0]}}}}\n{ball}\n")
    Path("truth.yaml").write_text("drag_ratio: 1.8\n")
    near = []
    for asked in ((), ("--clearance", "0.02")):
        code, out, err = purcell("track", "ball.yaml", "--truth", "truth.yaml", *asked, "--json")
        assert code == 0, err
        near.append(json.loads(out)["obstacle_m"])
    assert near[0] < 0.018 < near[1]
    code, _, err = purcell("track", "ball.yaml", "--truth", "truth.yaml", "--clearance", "-1")
    assert (code, "--clearance: a finite length of 0 m or more is wanted, found -1.0" in err) == (2, True)
