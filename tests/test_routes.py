"""Ways round obstacles: found, exact and clear; and goals that are shown to be out of reach."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from helpers import runner

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Box, Capsule, HalfSpace, Sphere
from purcell_cli.environment.tube import Tube
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint
from purcell_cli.missions import joined
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Mission, Waypoint
from purcell_cli.motion.obstacle_distance import link_distances
from purcell_cli.motion.plan import Blocked, Plan
from purcell_cli.planner.arcs.needle_steering import steer
from purcell_cli.planner.effort import AGAIN
from purcell_cli.planner.routes.closed_off import refuse_closed_off, too_narrow
from purcell_cli.planner.routes.edges import clear_edges, room
from purcell_cli.planner.routes.flat import on_hinges
from purcell_cli.planner.routes.one_motion import ended, one_motion
from purcell_cli.planner.routes.poses import Region
from purcell_cli.planner.routes.roadmap import Roadmap
from purcell_cli.planner.routes.swing import swings
from purcell_cli.planning import planned
from purcell_cli.solution import Solution, carried_out

PAPER = Swimmer()


def collinear(position: tuple[float, float, float], yaw_deg: float = 0.0) -> Configuration:
    return Configuration(se3.pose(from_euler(np.radians([yaw_deg, 0.0, 0.0])), np.array(position)), COLLINEAR)


def pose(*position: float) -> Array:
    return se3.pose(np.eye(3), np.array(position))[None]


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Box:
    size, middle = np.subtract(high, low), 0.5 * np.add(high, low)
    return Box(tuple(middle.tolist()), tuple(size.tolist()))


def shell(thickness: float, gap: float = 0.0) -> Scene:
    """Return a closed room of 1 m round the origin; with a gap, its wall to the right is that much too short."""
    walls: list[Obstacle] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            low, high = [-0.5 - thickness] * 3, [0.5 + thickness] * 3
            low[axis], high[axis] = sorted((side * 0.5, side * (0.5 + thickness)))
            if axis == 0 and side > 0.0:
                high[1] -= gap
            walls.append(box((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    return Scene(tuple(walls))


def narrowing(radius: float, around: bool = False) -> Scene:
    """Return a tube along x with a narrow place halfway, and perhaps a branch round it."""
    straight = Tube(((-1, 0, 0), (0.4, 0, 0), (1.0, 0, 0), (1.6, 0, 0), (3, 0, 0)), (0.3, 0.3, radius, 0.3, 0.3))
    branch = Tube(((0, 0, 0), (0.2, 1, 0), (1.8, 1, 0), (2, 0, 0)), (0.3,) * 4)
    return Scene((straight, branch) if around else (straight,))


@pytest.mark.parametrize(
    ("scene", "goal", "closed"),
    [
        (shell(0.2), (1.5, 0, 0), True),
        (shell(0.2), (0.2, 0, 0), False),
        (shell(0.2, gap=0.4), (1.5, 0, 0), False),
        (narrowing(0.0015), (2, 0, 0), True),
        (narrowing(0.0015, around=True), (2, 0, 0), False),
        (narrowing(0.0015), (0.7, 0, 0), False),
        (narrowing(0.0025), (2, 0, 0), False),
        (Scene((HalfSpace((0.5, 0, 0), (-1, 0, 0)),)), (0.2, 0, 0), False),
    ],
)
def test_a_goal_that_is_closed_off_is_told_at_once(
    scene: Scene, goal: tuple[float, float, float], closed: bool
) -> None:
    """The paper's swimmer is 2 mm thick to both sides: a place of 1.5 mm is too narrow, one of 2.5 mm may do."""
    if not closed:
        refuse_closed_off(PAPER, scene, 0.0, collinear((0, 0, 0)), collinear(goal))
        return
    with pytest.raises(ParameterError, match=r"goal: a (way as wide|place that is not closed off)"):
        refuse_closed_off(PAPER, scene, 0.0, collinear((0, 0, 0)), collinear(goal))


def test_smaller_strokes_take_less_room_and_cost_more() -> None:
    found = swings(PAPER)
    assert all(a.radius > 1.4 * b.radius for a, b in itertools.pairwise(found))
    assert all(a.loops.straight > b.loops.straight for a, b in itertools.pairwise(found))
    assert found[0].radius < 2.0 * math.sin(1.0) + 0.1, "limbs of 2 L at 1 rad"
    assert abs(found[-1].half - 3.0) < 0.05


@pytest.mark.parametrize("axis", ["yaw", "pitch"])
def test_strokes_in_a_plane_take_room_in_it_alone(axis: str) -> None:
    """A floor 0.5 L under the plane is no matter; balls are where no point of a flat capsule, link and all, is."""
    swing, normal = swings(hinges(axis))[0], {"yaw": 2, "pitch": 1}[axis]
    up = np.eye(3)[normal]
    floor = Scene((HalfSpace(tuple((-0.05 * up).tolist()), tuple(up.tolist())),))
    assert room(floor, swing, 0.1, 0.01, np.eye(4)[None])[0] > 0.02
    assert room(floor, swings(PAPER)[0], 0.1, 0.01, np.eye(4)[None])[0] < 0.0
    rng = np.random.default_rng(5)
    along, aside = np.linspace(-swing.half, swing.half, 121), np.linspace(swing.lines[0], swing.lines[-1], 61)
    flat = np.stack(np.meshgrid(along, aside, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    swept = 0.1 * flat[:, [0, 1, 2] if axis == "yaw" else [0, 2, 1]]
    told = []
    for spot in rng.uniform(-1.0, 1.0, (300, 3)) * [0.4, 0.25, 0.1]:
        centre = spot[[0, 1, 2] if axis == "yaw" else [0, 2, 1]]
        left = float(room(Scene((Sphere(tuple(centre.tolist()), 0.05),)), swing, 0.1, 0.0, np.eye(4)[None])[0])
        apart = float(np.min(np.linalg.norm(swept - centre, axis=1))) - 0.05 - 0.002
        assert apart > 0.0 or left < 1e-3, "the grid's cells are 5 mm wide"
        assert left > 0.0 or apart < 0.1 * 0.12
        told.append(left > 0.0)
    assert 50 < sum(told) < 250


def test_an_edge_takes_the_way_that_is_clear() -> None:
    """Straight ahead where nothing stands, by arcs past a small ball, and no way through a wall."""
    swing = swings(PAPER)[0]
    cases = {"free": (9.0, 0.1), "ball": (0.7, 0.02), "wall": (0.7, 0.66)}
    found = {}
    for name, (x, radius) in cases.items():
        scene = Scene((Sphere((x, 0.0, 0.0), radius),))
        found[name] = clear_edges(scene, swing, 0.1, 0.0, pose(0.0, 0.0, 0.0), pose(1.4, 0.0, 0.0))[0]
    assert found["free"] is not None
    assert len(found["free"].poses) == 0
    assert found["wall"] is None
    if found["ball"] is not None:
        assert found["ball"].price > found["free"].price


def densely(solution: Solution, scene: Scene) -> float:
    """Return the least distance of a link from an obstacle in a plan's rows [m]."""
    rows = solution.trajectory
    return float(np.min(link_distances(solution.plan.swimmer, scene, rows.pose, rows.shape[..., 0])[0]))


@pytest.mark.slow
def test_a_plan_goes_round_a_ball_in_its_way() -> None:
    """The plan that knows no obstacles swims through the ball; the other is clear of it, exact, and the same again."""
    start, goal, scene = collinear((0, 0, 0)), collinear((1.4, 0, 0)), Scene((Sphere((0.7, 0, 0), 0.25),))
    empty = plan(start, goal)
    assert densely(empty, scene) < -0.2
    found = [plan(start, goal, options=PlanOptions(obstacles=scene, clearance_m=0.01)) for _ in range(2)]
    assert found[0].verdict == "reached"
    assert found[0].limits.obstacle is not None
    assert 0.01 <= found[0].limits.obstacle.distance_m <= densely(found[0], scene) + 1e-9
    assert found[0].joint_travel_rad < 2.0 * empty.joint_travel_rad
    assert "a way round obstacles in" in found[0].plan.structures[0].words
    assert [b.phase for b in found[0].plan.blocks] == sorted(b.phase for b in found[0].plan.blocks)
    assert min(b.joint_travel_rad for b in found[0].plan.blocks) > 1e-9, "no leg straightens what is no bend"
    assert np.array_equal(found[0].trajectory.pose, found[1].trajectory.pose)


@pytest.mark.slow
def test_a_replan_goes_round_a_ball_in_its_way() -> None:
    """A tracker asks for an effort of its own, of which searches for ways know nothing."""
    start, goal, scene = collinear((0, 0, 0)), collinear((1.2, 0, 0)), Scene((Sphere((0.6, 0, 0), 0.2),))
    asked = PlanOptions(obstacles=scene)
    found = carried_out(planned(start, goal, options=asked, effort=AGAIN), asked)
    assert found.verdict == "reached"
    assert found.limits.obstacle is not None
    assert 0.0 <= found.limits.obstacle.distance_m <= densely(found, scene) + 1e-9


@pytest.mark.slow
def test_a_narrow_straight_tube_is_swum_by_smaller_strokes() -> None:
    scene = Scene((Tube(((-1, 0, 0), (2, 0, 0)), (0.08, 0.08)),))
    found = plan(collinear((0, 0, 0)), collinear((0.1, 0, 0)), options=PlanOptions(obstacles=scene))
    assert found.verdict == "reached"
    assert found.limits.largest_bend_rad[1] is not None
    assert found.limits.largest_bend_rad[1] < 0.61


def test_poses_near_a_path_make_it_cheaper_and_never_dearer() -> None:
    """A ball to pass: what the poses drawn anywhere give is made cheaper, without exact legs."""
    scene = Scene((Sphere((0.7, 0, 0), 0.25),))
    start, goal = collinear((0, 0, 0)).pose, collinear((1.4, 0, 0)).pose
    roadmap = Roadmap(Region.of(scene, swings(PAPER), 0.1, 0.0, start, goal), start, goal)
    rng = np.random.default_rng(3)
    roadmap.grow(rng, 40)
    path = roadmap.path()
    assert path is not None
    prices = [roadmap.price(path)]
    for spread in (1.0, 0.4, 0.8, 0.25):
        roadmap.grow_near_path(rng, spread)
        path = roadmap.path()
        assert path is not None
        prices.append(roadmap.price(path))
    assert prices == sorted(prices, reverse=True)
    assert prices[-1] < 0.99 * prices[0]
    roadmap.reprice((path[1], path[0]), 1e4)
    again = roadmap.path()
    assert again is not None
    assert again[:2] != path[:2], "an edge that turns out dear is left"


def test_a_small_window_in_a_large_wall_is_found() -> None:
    """Of 3 L by 3 L in a thin wall of 30 L by 30 L: poses that look through it, from each of five seeds."""
    wide, half = 1.5, 0.15
    wall = [box((-0.025, low, -wide), (0.025, low + wide - half, wide)) for low in (half, -wide)]
    wall += [box((-0.025, -half, low), (0.025, half, low + wide - half)) for low in (half, -wide)]
    start, goal = pose(-0.9, -0.4, 0.2)[0], pose(0.9, 0.3, -0.3)[0]
    region = Region.of(Scene(tuple(wall)), swings(PAPER), 0.1, 0.0, start, goal)
    for seed in range(5):
        rng, roadmap = np.random.default_rng(seed), Roadmap(region, start, goal)
        for _ in range(2):
            roadmap.grow(rng, 40)
        at = roadmap.poses[:, :3, 3]
        within = (np.abs(at[:, 0]) < 0.2) & np.all(np.abs(at[:, 1:]) < half, axis=1)
        assert np.any(within & (np.abs(roadmap.poses[:, 0, 0]) > 0.8))


def test_a_path_that_nothing_can_be_drawn_near_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    start, goal = collinear((0, 0, 0)).pose, collinear((1.4, 0, 0)).pose
    scene = Scene((Sphere((0.7, 0, 0), 0.25),))
    roadmap = Roadmap(Region.of(scene, swings(PAPER), 0.1, 0.0, start, goal), start, goal)
    roadmap.grow(np.random.default_rng(3), 40)
    path, count = roadmap.path(), len(roadmap.poses)
    assert path is not None
    assert len(path) > 2
    none, edge = np.empty((0, 4, 4)), Roadmap.edge
    monkeypatch.setattr(Region, "near", lambda *_: none)
    monkeypatch.setattr(Roadmap, "edge", lambda *of: dataclasses.replace(edge(*of), poses=none))
    roadmap.grow_near_path(np.random.default_rng(0), 0.4)
    assert (roadmap.path(), len(roadmap.poses)) == (path, count)


def test_what_blocks_the_way_is_told() -> None:
    """Before a wall with a ball on either side: the nearest pose is this side, and the wall is named, not the balls."""
    scene = Scene((Sphere((0.0, 0.9, 0.0), 0.1), HalfSpace((0.6, 0, 0), (-1, 0, 0)), Sphere((1.3, 0.9, 0), 0.1)))
    start, goal = collinear((0, 0, 0)).pose, collinear((1.4, 0, 0)).pose
    roadmap = Roadmap(Region.of(scene, swings(PAPER)[3:], 0.1, 0.0, start, goal), start, goal)
    roadmap.grow(np.random.default_rng(0), 12)
    assert roadmap.path() is None
    told = re.fullmatch(
        r"the nearest attempt comes to \((.*)\) m, (.*) L from the goal; (.*) is in.*", roadmap.blocked().words
    )
    assert told is not None
    place = np.array([float(x) for x in told[1].split(",")])
    assert place[0] < 0.6
    assert abs(float(told[2]) - 10.0 * np.linalg.norm(place - [1.4, 0.0, 0.0])) < 0.02
    assert told[3] == "obstacle 2 (half_space)"


def test_a_mission_tells_which_leg_is_blocked() -> None:
    start, goal, none = collinear((0, 0, 0)), collinear((1, 0, 0)), Blocked((0.0, 0.0, 0.0), 1.0, 2, "a wall")
    mission = Mission(start, goal, (Waypoint(position_m=np.array([0.5, 0, 0])),))
    legs = [Plan(PAPER, start, goal, ()), Plan(PAPER, start, goal, (), blocked=none)]
    assert joined(PAPER, mission, [0], legs).blocked == dataclasses.replace(none, leg=1)
    assert joined(PAPER, mission, [0], legs[:1] * 2).blocked is None


def test_legs_make_one_motion_that_ends_at_the_goal() -> None:
    """Legs of which the first ends a little off: as they are they miss the goal, as one motion they do not."""
    stops = [collinear((0.0, 0, 0)), collinear((0.03, 0, 0)), collinear((0.06, 0.002, 0))]
    made = [plan(a, b, options=PlanOptions(effort="quick")).plan.blocks for a, b in itertools.pairwise(stops)]
    bent = [dataclasses.replace(b, sequence=b.sequence.with_angles(b.sequence.angle * (1.0 + 1e-6))) for b in made[0]]
    legs = [bent, list(made[1])]
    plain = Plan(PAPER, stops[0], stops[-1], tuple(b for leg in legs for b in leg))
    assert not Deviation.between(ended(plain), stops[-1]).within(1e-10, 1e-9)
    joined = one_motion(PAPER, stops[0], stops[-1], legs, PAPER.max_bend_rad)
    assert joined is not None
    assert Deviation.between(ended(dataclasses.replace(plain, blocks=joined)), stops[-1]).within(1e-11, 1e-10)


def hinges(axis: str) -> Swimmer:
    """Return the paper's swimmer on hinges, one of which bends by 50 degrees at most."""
    reach = (-50.0, 50.0)
    first = Joint("hinge", axis, psi_deg=reach) if axis == "yaw" else Joint("hinge", axis, theta_deg=reach)
    return Swimmer(joints=(first, Joint("hinge", axis)))


@pytest.mark.parametrize("axis", ["yaw", "pitch"])
def test_hinges_of_one_axis_get_poses_and_arcs_in_their_plane(axis: str) -> None:
    """From a tilted start; arcs turn about the hinges' axis alone, and make the way between the poses."""
    start = se3.pose(from_euler(np.array([0.5, -0.4, 0.8])), np.array([0.1, 0.2, 0.3]))
    scene = Scene((Sphere((0.7, 0.2, 0.1), 0.3), Sphere((0.2, 0.8, 0.1), 0.2)))
    k = {"yaw": 2, "pitch": 1}[axis]
    swing = swings(hinges(axis))[0]
    region = Region.of(scene, (swing,), 0.1, 0.0, start, start, axis)
    found = region.drawn(np.random.default_rng(1), 30, np.stack([start, start]))
    assert len(found) > 10
    moves = se3.inverse(start) @ found
    assert np.max(np.abs(moves[:, k, 3])) < 1e-12
    assert np.max(np.abs(moves[:, k, :3] - np.eye(3)[k])) < 1e-12
    moves[:, :3, 3] /= 0.1
    arcs = steer(moves, swing.loops, 8, plane=axis)
    assert len(set(arcs.displacement.tolist())) > 0.7 * len(moves)
    assert np.all(arcs.arc[..., {"yaw": 1, "pitch": 2}[axis]] == 0.0)
    assert np.all(arcs.roll == 0.0)
    zero = np.zeros_like(arcs.arc[..., 0])
    steps = se3.exp(np.stack([arcs.arc[..., 0], zero, zero, zero, arcs.arc[..., 1], arcs.arc[..., 2]], axis=-1))
    ends = steps[:, 0] @ steps[:, 1] @ steps[:, 2]
    assert np.max(np.abs(se3.log(se3.inverse(moves[arcs.displacement]) @ ends))) < 1e-3
    free = steer(moves, swing.loops, 8)
    assert np.max(np.abs(free.arc[..., {"yaw": 1, "pitch": 2}[axis]])) > 0.1, "others leave the plane"


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["yaw", pytest.param("pitch", marks=pytest.mark.nightly)])
def test_hinges_go_round_what_stands_in_their_plane(axis: str) -> None:
    """A rod across the plane, floor and ceiling, limbs bent at both ends; one hinge bends by 50 degrees at most."""
    body = hinges(axis)
    across = {"yaw": (0.0, 0.0, 1.0), "pitch": (0.0, 1.0, 0.0)}[axis]
    rod = Capsule((0.6 - across[0], -across[1], -across[2]), (0.6, across[1], across[2]), 0.12)
    sides = [
        HalfSpace((-0.03 * s * across[0], -0.03 * s * across[1], -0.03 * s * across[2]), tuple(s * x for x in across))
        for s in (1.0, -1.0)
    ]
    scene = Scene((rod, *sides))
    bent = from_euler(np.radians([20.0, 0.0, 0.0] if axis == "yaw" else [0.0, 20.0, 0.0]))
    start = Configuration(np.eye(4), np.stack([bent, np.eye(3)]))
    goal = Configuration(collinear((1.2, 0, 0)).pose, np.stack([np.eye(3), bent]))
    found = plan(start, goal, swimmer=body, options=PlanOptions(obstacles=scene))
    assert found.verdict == "reached"
    assert found.limits.obstacle is not None
    assert 0.0 <= found.limits.obstacle.distance_m <= densely(found, scene) + 1e-9
    assert np.max(np.abs(found.trajectory.pose[:, {"yaw": 2, "pitch": 1}[axis], 3])) < 1e-11
    assert np.min(found.trajectory.shape[..., 0, 0]) < math.cos(0.6), (
        "large strokes have room between floor and ceiling"
    )


@pytest.mark.slow
def test_a_slit_is_swum_by_strokes_in_its_plane() -> None:
    """Of 0.3 L between floor and ceiling no round stroke has room; flat ones go round what stands in it."""
    block = Box((0.0, 0.0, 0.0), (0.2, 0.6, 0.02))
    scene = Scene((block, HalfSpace((0, 0, -0.015), (0, 0, 1)), HalfSpace((0, 0, 0.015), (0, 0, -1))))
    assert room(scene, swings(PAPER)[-1], 0.1, 0.0, pose(0.0, 2.0, 0.0))[0] < 0.0
    start, goal = collinear((-0.8, 0, 0)), collinear((0.8, 0.2, 0), 40.0)
    found = plan(start, goal, options=PlanOptions(obstacles=scene))
    assert found.verdict == "reached"
    assert found.plan.swimmer == PAPER
    assert found.limits.obstacle is not None
    assert 0.0 <= found.limits.obstacle.distance_m <= densely(found, scene) + 1e-9
    assert np.max(np.abs(found.trajectory.pose[:, 2, 3])) < 1e-9


def test_ball_joints_are_seen_as_hinges_where_both_ends_lie_in_one_plane() -> None:
    def bent(at: Configuration, angles: tuple[float, float, float]) -> Configuration:
        return Configuration(at.pose, np.stack([from_euler(np.radians(angles)), np.eye(3)]))

    def axis(start: Configuration, goal: Configuration, body: Swimmer = PAPER) -> str | None:
        found = on_hinges(body, start, goal, Limits())
        return None if found is None else found.joints[0].axis

    start, level, above = collinear((0, 0, 0)), collinear((0.5, 0.2, 0), 30.0), collinear((0.5, 0, 0.2))
    assert [axis(start, level), axis(start, above), axis(start, collinear((0.5, 0.2, 0.2)))] == ["yaw", "pitch", None]
    assert axis(bent(start, (20, 0, 0)), level) == "yaw"
    assert axis(bent(start, (0, 20, 0)), level) is None
    assert axis(bent(start, (0, 20, 0)), above) == "pitch"
    assert axis(start, level, Swimmer(joints=(Joint("universal"), Joint()))) is None


def test_a_tube_too_narrow_for_any_stroke_is_said_at_once_and_typed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tube of 4 mm: the swimmer, 2 mm thick to both sides, has room, but no stroke. No pose is drawn to say so."""
    monkeypatch.setattr(Roadmap, "grow", lambda *_: pytest.fail("a search"))
    text = "start: {}\ngoal: {base: {position_m: [1, 0, 0]}}\n"
    text += "obstacles: [{tube: {centreline: [[-1, 0, 0], [2, 0, 0]], radius_m: 0.004}}]\n"
    (tmp_path / "a.yaml").write_text(f"name: a\n{text}", encoding="utf-8")
    command = runner(capsys)
    code, out, errors = command(
        "plan", str(tmp_path / "a.yaml"), "--json", "--out", str(tmp_path / "a.csv"), "--effort", "quick"
    )
    blocked = json.loads(out)["blocked"]
    assert (code, json.loads(out)["verdict"]) == (1, "not found within limits")
    assert blocked["words"] in errors
    assert "no proof" in blocked["words"]
    assert (blocked["position_m"], blocked["left_m"], blocked["obstacle"], blocked["leg"]) == ([0, 0, 0], 1.0, 0, 0)
    assert not too_narrow(Scene((Tube(((-1, 0, 0), (2, 0, 0)), (0.02, 0.02)),)), 0.015, np.eye(4), np.eye(4))


@pytest.mark.parametrize("way", ["closed", "touch"])
def test_what_cannot_be_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], way: str
) -> None:
    command, out = runner(capsys), tmp_path / "a.csv"
    tube = "{tube: {centreline: [[-1, 0, 0], [0.3, 0, 0], [1, 0, 0], [3, 0, 0]], radius_m: [0.3, 0.3, 0.001, 0.3]}}"
    obstacle = {"closed": tube, "touch": "{sphere: {centre_m: [2, 0.1, 0], radius_m: 0.2}}"}[way]
    text = f"name: a\nstart: {{}}\ngoal: {{base: {{position_m: [2, 0, 0]}}}}\nobstacles:\n  - {obstacle}\n"
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    code, _, errors = command("plan", str(tmp_path / "a.yaml"), "--out", str(out))
    assert (code, out.exists()) == (2, False)
    wanted = "found a place too narrow" if way == "closed" else "goal: all links clear of obstacles are wanted"
    assert wanted in errors
